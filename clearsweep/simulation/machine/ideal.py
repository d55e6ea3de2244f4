"""The ideal machine without clearance: its motion, its largest forces, its elastic links, the first touch."""

import functools
import math
from collections.abc import Callable, Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np

from ...contracts.case import Case
from ...contracts.catalogue import Mechanism, Outline
from ...contracts.machine import GROUND, Constant, Machine, Motor, Path, Schedule
from ...mechanics.machines import MECHANISMS, planar
from ...mechanics.machines.contract import IdealMotion
from ...tracing.compiled.family import Identity

# Global maxima of functions on an interval that can be evaluated anywhere and may jump.

ACCURACY = 1e-9  # of the largest value: allowed difference of neighbouring samples at a maximum
MIN_SPACING = 1e-12  # of the interval: of two closer points one is dropped
STEEPNESS = 8.0  # times the median slope of neighbours: a steeper interval may contain a jump
NEIGHBOURS = 7  # intervals in this median
MAX_REFINED = 32  # jumps, and maxima of a function, that are refined
SAMPLES_PER_SIDE = 8  # further samples on each side of a maximum per round
VERTEX_OFFSET = 1e-3  # of its interval: distance of two more samples from the vertex of the parabola
MAX_ROUNDS = 60

Functions = Callable[[np.ndarray], np.ndarray]  # (n,) -> (m, n): m functions at n points


def largest(functions: Functions, points: np.ndarray) -> np.ndarray:
    """Return the largest value (m,) of each function between the ends of `points`; nan if undefined.

    points : (n,) increasing, initial samples; a peak that lies between two of them can be missed.
    """
    points = points[np.append(True, np.diff(points) > MIN_SPACING * np.ptp(points))]
    values = functions(points)
    maxima = np.full(len(values), np.nan)
    defined = np.isfinite(values).all(axis=1)
    if defined.any():

        def defined_functions(x: np.ndarray) -> np.ndarray:
            return functions(x)[defined]

        samples = [(points, values[defined])]
        maxima[defined] = _maxima(defined_functions, *_merged(samples + _jumps(defined_functions, *samples[0])))
    return maxima


def _merged(samples: list[tuple[np.ndarray, np.ndarray]]) -> tuple[np.ndarray, np.ndarray]:
    """Return samples, points (n,) and values (m, n), merged in increasing order."""
    points, values = (np.concatenate(arrays, axis=-1) for arrays in zip(*samples, strict=True))
    order = np.argsort(points, kind="stable")
    return points[order], values[:, order]


def _jumps(functions: Functions, points: np.ndarray, values: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return samples that converge to every jump, by bisection of the intervals that may contain one."""
    scale = np.maximum(np.abs(values).max(axis=1, keepdims=True), np.finfo(float).tiny)
    change, half_width = np.abs(np.diff(values)) / scale, NEIGHBOURS // 2
    slope = change / np.diff(points)
    padded = np.pad(slope, ((0, 0), (half_width, half_width)), "edge")
    window = np.lib.stride_tricks.sliding_window_view(padded, NEIGHBOURS, axis=1)
    smallest = functools.reduce(np.minimum, (window[..., k] for k in range(NEIGHBOURS)))
    rows, columns = np.nonzero((slope > STEEPNESS * smallest) & (change > ACCURACY))  # few; the median takes longer
    median_slope = np.sort(window[rows, columns], axis=-1)[..., half_width]  # np.median loads masked arrays
    steep = np.zeros(len(points) - 1)
    np.maximum.at(steep, columns, np.where(slope[rows, columns] > STEEPNESS * median_slope, change[rows, columns], 0.0))
    columns = np.flatnonzero(steep)
    columns = columns[np.argsort(-steep[columns], kind="stable")[:MAX_REFINED]]
    low, high, low_value, high_value = points[columns], points[columns + 1], values[:, columns], values[:, columns + 1]
    jumps = []
    for _ in range(MAX_ROUNDS):
        centre = 0.5 * (low + high)
        is_open = (low < centre) & (centre < high) & (np.abs(high_value - low_value) > ACCURACY * scale).any(axis=0)
        if not is_open.any():
            break
        low = low[is_open]
        high = high[is_open]
        low_value = low_value[:, is_open]
        high_value = high_value[:, is_open]
        centre = centre[is_open]
        value_at_centre = functions(centre)
        jumps.append((centre, value_at_centre))
        jump_is_right = (np.abs(high_value - value_at_centre) / scale).sum(axis=0) > (
            np.abs(value_at_centre - low_value) / scale
        ).sum(axis=0)
        low, low_value = np.where(jump_is_right, centre, low), np.where(jump_is_right, value_at_centre, low_value)
        high, high_value = np.where(jump_is_right, high, centre), np.where(jump_is_right, high_value, value_at_centre)
    return jumps


def _maxima(functions: Functions, points: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return the largest value of each function, refining around every maximum that may be the largest."""
    largest_values: np.ndarray = values.max(axis=1)
    rows, x, y = _candidates(points, values)
    fractions = np.arange(1, SAMPLES_PER_SIDE + 1) / (SAMPLES_PER_SIDE + 1.0)
    for _ in range(MAX_ROUNDS):
        drop = y[:, 1] - y.min(axis=1)
        is_wide = x[:, 2] - x[:, 0] > 4.0 * np.spacing(np.abs(x).max(axis=1))
        is_open = is_wide & (drop > ACCURACY * np.abs(largest_values[rows])) & (y[:, 1] + drop >= largest_values[rows])
        if not is_open.any():
            break
        rows, x, y = rows[is_open], x[is_open], y[is_open]
        low, top, high = (x[:, k : k + 1] for k in range(3))
        # Vertices (b,) of the parabolas through three samples each, points and values (b, 3)
        left_width, right_width = x[:, 1] - x[:, 0], x[:, 2] - x[:, 1]
        rise, fall = _slope(y[:, 1] - y[:, 0], left_width), _slope(y[:, 1] - y[:, 2], right_width)
        curvature = rise + fall  # above 0: the middle value is the largest
        vertex: np.ndarray = x[:, 1] + _slope(rise * right_width - fall * left_width, 2.0 * curvature)
        near_vertex = np.clip(vertex[:, None] + (high - low) * VERTEX_OFFSET * np.arange(-1, 2), low, high)
        new_points = np.concatenate(
            [low + fractions * (top - low), top + fractions * (high - top), near_vertex], axis=1
        )
        new_values = functions(new_points.ravel())[
            np.repeat(rows, new_points.shape[1]), np.arange(new_points.size)
        ].reshape(new_points.shape)
        x, y = np.concatenate([x, new_points], axis=1), np.concatenate([y, new_values], axis=1)
        order = np.argsort(x, axis=1, kind="stable")
        x, y = np.take_along_axis(x, order, 1), np.take_along_axis(y, order, 1)
        neighbours = _neighbours(np.argmax(y, axis=1), x.shape[1])
        x, y = np.take_along_axis(x, neighbours, 1), np.take_along_axis(y, neighbours, 1)
        np.maximum.at(largest_values, rows, y[:, 1])
    return largest_values


def _slope(rise: np.ndarray, run: np.ndarray) -> np.ndarray:
    """Return `rise` over `run`, or 0 if `run` is 0: a maximum at an end has no neighbour on one side."""
    slope: np.ndarray = np.divide(rise, run, out=np.zeros_like(rise), where=run > 0.0)
    return slope


def _candidates(points: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the candidates for the largest value: function index (b,), points and values (b, 3) around each."""
    step = np.diff(values)
    rises, falls = np.pad(step, ((0, 0), (1, 0))), np.pad(step, ((0, 0), (0, 1)))  # before and behind each sample
    upper_bound = values + np.maximum(rises, -falls)
    rows, columns = np.nonzero((rises >= 0.0) & (falls <= 0.0) & (upper_bound >= values.max(axis=1, keepdims=True)))
    order = np.lexsort((-values[rows, columns], rows))  # largest first for each function
    order = order[np.arange(len(rows)) - np.searchsorted(rows, rows) < MAX_REFINED]
    rows, columns = rows[order], columns[order]
    neighbours = _neighbours(columns, len(points))
    return rows, points[neighbours], values[rows[:, None], neighbours]


def _neighbours(indices: np.ndarray, count: int) -> np.ndarray:
    """Return indices below `count` with their neighbours: (b, 3) from (b,)."""
    return np.stack([np.maximum(indices - 1, 0), indices, np.minimum(indices + 1, count - 1)], axis=-1)


# The mechanism of a case without clearance: its motion and its largest reactions.

SAMPLES_PER_TURN = 720  # initial samples of a turn
MAX_TURNS_PER_CYCLE = 1000.0  # of the crank, that are sampled so densely


def mechanism_of(case: Case) -> Mechanism:
    """Return the mechanism of a case, with the user-defined parts of its grid."""
    mechanism: Mechanism = MECHANISMS[case.mechanism.type]
    return _mechanism_with_outline(mechanism.with_outline, case.outline) if mechanism.with_outline else mechanism


@functools.lru_cache(maxsize=256)  # the cases of a sweep share it
def _mechanism_with_outline(with_outline: Callable[[Outline], Mechanism], outline: Outline) -> Mechanism:
    return with_outline(outline)


def machine_of(mechanism: Mechanism, case: Case) -> Machine | None:
    """Return the planar machine of a case, or None if its mechanism has none; cases that differ elsewhere share it."""
    return _machine(mechanism.machine, case) if mechanism.machine else None


def _parts_of_machine(machine_from: Callable[[Case], Machine], case: Case) -> tuple:
    """Return what the machine of a case depends on: its parts, its drive, and how far it turns."""
    settings = case.simulate
    length = settings.revolutions, settings.period, settings.until is None, case.life is None
    sections = Identity(case.mechanism), Identity(case.loads), Identity(case.outline)
    return machine_from, sections, repr((case.drive, length))


@planar.shared_by(_parts_of_machine, 256)
def _machine(machine_from: Callable[[Case], Machine], case: Case) -> Machine:
    return machine_from(case)


def ideal_motion(case: Case, angles: np.ndarray, times: np.ndarray | None = None) -> IdealMotion | None:
    """Return the ideal mechanism of a case at drive angles (rad), or None if it has none.

    times : (as `angles`) s, which count in their place where the length of the run is a time
    """
    machine, is_timed = machine_of(mechanism_of(case), case), times is not None and case.simulate.period is not None
    return planar.ideal(machine, times if is_timed else angles, over_time=is_timed) if machine else None


def ideal_peaks(case: Case, machine: Machine | None = None) -> Mapping[str, float]:
    """Return the largest reaction (N) of each joint without clearance; empty if the mechanism has no ideal motion.

    machine : the machine of the case, if it is already built
    """
    machine = machine or machine_of(mechanism_of(case), case)
    if machine is None:
        return {}
    tables = [load.table for load in case.loads if load.table]
    turn_range, period = turn_range_of(case, tables), case.simulate.period
    if period is None:
        knots = knots_of_loads(case, tables, turn_range)
    else:
        per_cycle = 2.0 * math.pi / period
        bounds = [2.0 * math.pi * bound for bound in turn_range]
        rows = [per_cycle * time for time in planar.discontinuity_times(machine)]
        knots = tuple(row for row in rows if bounds[0] < row < bounds[1])
    return _peaks(machine, turn_range, period, knots)


# the cases of a sweep share few mechanisms and speeds
@planar.shared_by(lambda machine, *further: (planar.machine_key(machine), further), 256)
def _peaks(
    machine: Machine, turn_range: tuple[float, float], period: float | None, knots: tuple[float, ...]
) -> Mapping[str, float]:
    """Return the result of `peaks` for a machine; period : s, of a cycle in place of a revolution."""
    drive: Any = machine.drive
    start, direction = drive.start_angle, planar.direction_of(drive)
    if period is None:
        return peaks(lambda angles: planar.ideal_reactions(machine, start + direction * angles), turn_range, knots)
    turns_per_cycle = period * planar.ideal_of(machine).reference_rate() / (2.0 * math.pi)
    seconds = period / (2.0 * math.pi)
    return peaks(
        lambda angles: planar.ideal_reactions(machine, seconds * angles, over_time=True),
        turn_range,
        knots,
        min(max(1.0, turns_per_cycle), MAX_TURNS_PER_CYCLE),
    )


def turn_range_of(case: Case, tables: list[Mapping[str, Any]]) -> tuple[float, float]:
    """Return the revolutions over which the ideal mechanism is evaluated: one period, or else the window.

    tables : load tables of the case
    """
    is_free = case.outline.free or (case.drive is not None and case.drive.table is not None)
    is_periodic = not is_free and case.simulate.period is None and not any("time" in table for table in tables)
    if not is_periodic:
        return case.simulate.discard, case.simulate.revolutions
    spans = [table["crank_angle"][-1] - table["crank_angle"][0] for table in tables]
    return 0.0, float(max([1, *[round(span / (2.0 * math.pi)) for span in spans]]))


def knots_of_loads(case: Case, tables: list[Mapping[str, Any]], turn_range: tuple[float, float]) -> tuple[float, ...]:
    """Return the crank angles (rad from the start, in the direction of its turning) of rows in load tables."""
    assert case.drive is not None  # a machine has an ideal motion
    speeds = case.drive.table["speed"] if case.drive.table and "speed" in case.drive.table else (case.drive.speed,)
    sign = -1.0 if min(speeds) < 0.0 else 1.0
    begin, end = 2.0 * math.pi * turn_range[0], 2.0 * math.pi * turn_range[1]
    knots: list[float] = []
    for table in tables:
        if "crank_angle" in table:
            row_angles = sign * (np.array(table["crank_angle"]) - case.drive.start_angle)[:: int(sign)]
            span = row_angles[-1] - row_angles[0]
            turns = np.arange(math.floor((begin - row_angles[-1]) / span), math.ceil((end - row_angles[0]) / span) + 1)
            row_angles = np.add.outer(span * turns, row_angles).ravel()
        elif case.outline.free or case.drive.table is not None:
            continue
        else:
            row_angles = abs(case.drive.speed) * np.array(table["time"])
        knots += row_angles[(row_angles > begin) & (row_angles < end)].tolist()
    return tuple(knots)


def peaks(
    reactions: Callable[[np.ndarray], Mapping[str, np.ndarray]],
    turn_range: tuple[float, float],
    knots: tuple[float, ...] = (),
    density: float = 1.0,
) -> Mapping[str, float]:
    """Return the largest reaction (N) of each joint over a range of revolutions, both ends included.

    reactions : (n,) rad from the start -> force (n, 2) N of each joint; knots : (k,) rad, further angles to evaluate;
    density : samples at first, over SAMPLES_PER_TURN.
    """
    names: list[str] = []

    def magnitudes(angles: np.ndarray) -> np.ndarray:
        forces = reactions(angles)
        names[:] = forces
        return np.array([np.hypot(force[:, 0], force[:, 1]) for force in forces.values()])

    start_angle, end_angle = (2.0 * math.pi * turns for turns in turn_range)
    count = max(round(density * SAMPLES_PER_TURN * (turn_range[1] - turn_range[0])), 2)
    equidistant = np.linspace(start_angle, end_angle, count + 1)
    largest_values = largest(magnitudes, np.array(sorted({*equidistant.tolist(), *knots})))
    return dict(zip(names, largest_values.tolist(), strict=True))


def max_drive_speed(machine: Machine) -> float:
    """Return the largest speed (rad/s) of a drive; for a free crank under constant torque, its initial speed."""
    drive = machine.drive
    if isinstance(drive, Motor) and drive.servo is not None:
        drive = drive.servo.target
    if isinstance(drive, Constant):
        return abs(drive.speed)
    if isinstance(drive, (Schedule, Path)):
        return float(np.max(np.abs(planar.motion_table(drive)[:, 2])))
    assert isinstance(drive, Motor)  # the only other drive
    return max(abs(speed) for speed in (drive.initial_speed, drive.no_load_speed) if math.isfinite(speed))


# Largest eccentricity of the journal in a worn joint before its surfaces touch, over all directions.


class Touch(NamedTuple):
    """The largest eccentricity of a journal before its surfaces touch."""

    growth: float  # m, eccentricity minus the clearance of the unworn joint
    bearing_bin: int  # bins in contact there
    journal_bin: int
    growth_per_depth: (
        float  # growth of the eccentricity per depth worn there: 1 / cos of the angle between both directions
    )


def first_touch(clearance: float, bearing: np.ndarray, journal: np.ndarray, relative_angles: np.ndarray) -> Touch:
    """Return the largest eccentricity of a journal before its surfaces touch.

    With the gap clearance + h_bearing + h_journal - e cos(phi - gamma), a journal that moves in the direction gamma
    touches at e = min over phi of (clearance + h_bearing + h_journal) / cos(phi - gamma), to first order in depths
    over the radius.  The result is the largest e over all gamma and relative angles of the bodies.

    bearing, journal : (bins,) m, depth of each bin in the frame of its body; relative_angles : (n,) rad, the angles
    of the body of the journal minus those of the body of the bearing.
    """
    bins = len(bearing)
    shifts = np.round(np.asarray(relative_angles) * bins / (2.0 * np.pi)).astype(int) % bins
    bin_shifts = np.array(sorted({*shifts.tolist()}))  # np.unique loads masked arrays, in 25 ms
    bin_numbers = np.arange(bins)
    facing_bin = (
        bin_numbers - bin_shifts[:, None]
    ) % bins  # (rotations, bins) bin of the journal that faces each bin of the bearing
    gap = clearance + bearing + journal[facing_bin]
    bins_in_reach = int(np.arccos(clearance / gap.max()) * bins / (2.0 * np.pi)) + 1  # no first touch beyond this angle
    offsets = [bin_offset for bin_offset in range(-bins_in_reach, bins_in_reach + 1) if 4 * abs(bin_offset) < bins]
    smallest, offset_of_smallest = gap.copy(), np.zeros(gap.shape, int)
    for bin_offset in offsets:
        eccentricity = np.roll(gap, -bin_offset, axis=1) / np.cos(2.0 * np.pi * bin_offset / bins)
        is_smaller = eccentricity < smallest
        smallest[is_smaller], offset_of_smallest[is_smaller] = eccentricity[is_smaller], bin_offset
    rotation, direction = np.unravel_index(int(np.argmax(smallest)), smallest.shape)
    offset = int(offset_of_smallest[rotation, direction])
    bearing_bin = int((direction + offset) % bins)
    growth_per_depth = float(1.0 / np.cos(2.0 * np.pi * offset / bins))
    return Touch(
        float(smallest[rotation, direction]) - clearance,
        bearing_bin,
        int(facing_bin[rotation, bearing_bin]),
        growth_per_depth,
    )


def first_touch_in_slot(bearing: np.ndarray, journal: np.ndarray) -> Touch:
    """Return an upper bound for a pin in a slot: the deepest bins of wall and pin face each other.

    bearing, journal : (bins,) m, depth of each bin; the bins of the wall follow its arc length
    """
    bearing_bin, journal_bin = int(np.argmax(bearing)), int(np.argmax(journal))
    return Touch(float(bearing[bearing_bin] + journal[journal_bin]), bearing_bin, journal_bin, 1.0)


# Sizes and speeds of a case that no machine has, which usually come from a wrong unit.

LEAST_LINE_MASS = 0.01  # kg/m of a link; a steel wire of 1.3 mm diameter
LARGEST_LENGTH = 100.0  # m, of a link
LARGEST_PIN_DIAMETER = 1.0  # m
LARGEST_CLEARANCE = 0.02  # m, radial
LARGEST_PIN_SPEED = 500.0  # m/s, of the crank pin; a ring of steel bursts: density times speed squared is 2 GPa


def size_warnings(case: Case) -> list[str]:
    """Return a warning that lists the implausible sizes and speeds of a case, or []."""
    machine = machine_of(mechanism_of(case), case)
    section = "mechanism.bodies" if case.outline.bodies else "mechanism"
    sentences = [*(_machine_warnings(machine, section) if machine else ())]
    for joint in case.joints:
        diameter = 2.0 * (joint.bearing_radius or 0.0)
        if diameter > LARGEST_PIN_DIAMETER:
            sentences.append(f"joints.{joint.name}.bearing_radius is that of a pin of {diameter:.3g} m diameter")
        if joint.clearance > LARGEST_CLEARANCE and not (joint.play or joint.stops):
            key, size = ("backlash", joint.backlash) if joint.backlash else ("clearance", joint.clearance)
            sentences.append(f"joints.{joint.name}.{key} is {1e3 * size:.3g} mm")
    listed = ", ".join(sentences)
    return [f"sizes that no machine has; check their units (SI where none is written): {listed}"] if listed else []


def _machine_warnings(machine: Machine, section: str) -> Iterator[str]:
    """Yield what is implausible in the links and the drive of a machine."""
    lengths = {
        name: max(math.dist(first, second) for first in body.points.values() for second in body.points.values())
        for name, body in machine.bodies.items()
        if name != GROUND and body.points
    }
    for name, length in lengths.items():
        line_mass = machine.bodies[name].mass / length if length else math.inf
        if length > LARGEST_LENGTH:
            yield f"{section}.{name} is {length:.4g} m long"
        if 0.0 < line_mass < LEAST_LINE_MASS:
            yield f"{section}.{name} has {line_mass:.2g} kg per metre of its length, {length:.3g} m"
    driven = next(joint.distal.body for joint in machine.joints if joint.name == machine.driven)
    speed = max_drive_speed(machine)
    if lengths.get(driven, 0.0) * speed > LARGEST_PIN_SPEED:
        end_speed = f"{lengths[driven] * speed:,.4g} m/s"
        yield f"drive turns at {speed * 30.0 / math.pi:,.5g} rpm, so that the end of {driven} moves at {end_speed}"


def servo_warnings(case: Case) -> list[str]:
    """Return a note if a servo's limit is below the torque that keeps the crank of a case on its target."""
    machine = machine_of(mechanism_of(case), case) if case.outline.drive == "servo" else None
    if machine is None:
        return []
    drive: Any = machine.drive  # mypy takes it for a tuple of anything
    limit = drive.servo.torque_limit
    assert case.simulate.period is not None  # revolutions do not measure the run of a servo
    times = np.linspace(0.0, case.simulate.revolutions * case.simulate.period, 1 + SAMPLES_PER_TURN)
    target = drive.servo.target._replace(start_angle=drive.start_angle)
    flywheel_torque = drive.inertia * planar.motion_at(target, times)[2]
    torques = np.abs(planar.ideal(machine._replace(drive=target), times, over_time=True).torque + flywheel_torque)
    needed = np.where(np.isfinite(torques), torques, 0.0)
    if np.max(needed) <= limit:
        return []
    return [
        f"drive.servo.torque_limit: without clearance the target takes up to {np.max(needed):.4g} N*m, at "
        f"{times[np.argmax(needed)]:.4g} s, and the limit is {limit:.4g} N*m; the crank falls behind the target there"
    ]


def start_angles(case: Case) -> dict[str, tuple[float, str]]:
    """Return `mechanism.start.BODY` -> (angle, rad) of bodies whose loops close in several ways, as they are taken."""
    return {f"mechanism.start.{body}": (angle, "rad") for body, angle in _rival_assemblies(case).taken.items()}


def _rival_assemblies(case: Case) -> planar.Rivals:
    """Return how else the loops of a case close at the start."""
    is_planar = case.outline.bodies and not case.outline.spatial
    machine = machine_of(mechanism_of(case), case) if is_planar else None
    return planar.rival_assemblies(machine) if machine else planar.Rivals({}, {})


def start_warnings(case: Case) -> list[str]:
    """Return a note if the loops of a case close in two ways at the start and nothing in the grid decides."""
    angles = _rival_assemblies(case).ties
    if not angles:
        return []
    taken, other = (
        ", ".join(f"{body}: {math.degrees(pair[k]):.4g} deg" for body, pair in angles.items()) for k in (0, 1)
    )
    return [
        f"mechanism.start: the loops close in two ways at the start, and nothing decides: {{{taken}}} is taken, "
        f"{{{other}}} is possible; write `start` with the angles you mean, and see `clearsweep draw`"
    ]
