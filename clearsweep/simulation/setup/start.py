"""Inputs and control of one integration of a scene."""

import functools
import itertools
import math
import operator
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ...contracts.layout import MAX_REVOLUTIONS, WALLS, Layout
from ...mechanics import observe
from ...mechanics.coupling.entries import workspace_size
from ...mechanics.coupling.rates import observed_width
from ...mechanics.joints.contract import every_contact
from ...mechanics.machines import planar
from ...mechanics.machines.contract import friction_laws
from ...mechanics.observe import ROW_COUNT, STAGES
from ...mechanics.solver import integration, loop, totals
from ...mechanics.solver.collocation import COEFFICIENTS, ROWS
from ...mechanics.solver.step_control import MAX_PATTERN_BITS, PIECE_BITS
from ...mechanics.solver.totals import ContactStep, Step
from ...mechanics.wear import ACCOUNT_SIZE, MAX_BINS
from ...tracing.compiled.family import Entry, form_number
from ...tracing.memory import Fields
from ...tracing.symbols import WIDTH
from ..figures.window import (
    Quantile,
    Repetition,
    Spread,
    contact_slices,
    expected_largest,
    quantiles,
    resultant_contacts,
)
from .scene import STALL_TURNS, Scene, initial_shapes, state_units

# Quantities of single revolutions: force peaks, the motion at crank angle 0, the period of the motion.

LONGEST_PERIOD, MIN_REPEATS = 16, 3  # most revolutions of a period; how often it must be repeated
LAST_RETURNS = LONGEST_PERIOD * (MIN_REPEATS + 1)  # revolutions from which a period is found
RETURN_TOLERANCE = 1e-3  # clearances, and clearances times crank speed: tolerance of a periodic motion
MARK_TOLERANCE = 1e-9  # revolutions: closer marks are merged


class Marks(NamedTuple):
    """Times of a run, in revolutions since its start, at which something is recorded."""

    turns: np.ndarray  # (marks,) increasing
    window: np.ndarray  # (w,) indices of the bounds of the window's revolutions
    sections: np.ndarray  # (s,) indices of the marks at crank angle 0

    def after(self, turns: float) -> "Marks":
        """Return the marks of a window that begins `turns` revolutions after the start."""
        return self._replace(window=self.window[self.turns[self.window] > turns - MARK_TOLERANCE])


NO_MARKS = Marks(np.empty(0), np.empty(0, int), np.empty(0, int))


def marks_of(scene: Scene, revolutions: float) -> Marks:
    """Return the marks of a run of `revolutions`; there are none if nothing turns."""
    if not scene.mechanism.turns:
        return NO_MARKS
    phase = None if scene.case.save.orbits == "none" else -start_turns(scene) % 1.0
    if phase is not None and scene.case.simulate.period is not None:
        phase = 0.0  # at the start of every cycle
    return _marks(scene.case.simulate.discard, revolutions, phase)


@functools.lru_cache(maxsize=64)  # the cases of a sweep share them
def _marks(discard: float, revolutions: float, phase: float | None) -> Marks:
    """Return the marks of a run whose window begins at `discard`; sections begin at `phase`, None for no sections."""
    window = _consecutive(discard, revolutions)
    sections = np.empty(0) if phase is None else _consecutive(phase, revolutions)
    if np.array_equal(window, sections[len(sections) - len(window) :]):  # almost always
        turns = sections
    else:
        turns = np.sort(np.concatenate([window, sections]))
        turns = turns[np.diff(turns, prepend=-1.0) > MARK_TOLERANCE]
    return Marks(np.minimum(turns, revolutions), _nearest(turns, window), _nearest(turns, sections))


def _consecutive(start: float, end: float) -> np.ndarray:
    """Return start, start + 1, ... up to `end`; if there are many, only the last ones."""
    count = max(math.floor(end - start + MARK_TOLERANCE) + 1, 0)
    return start + np.arange(max(count - MAX_REVOLUTIONS - 1, 0), count)


def start_turns(scene: Scene) -> float:
    """Return the crank angle at the start, in turns in the direction of its turning."""
    direction = planar.direction_of(scene.machine.drive) if scene.machine else 1.0
    return direction * scene.case.drive.start_angle / (2.0 * math.pi) if scene.case.drive else 0.0


def _nearest(turns: np.ndarray, requested: np.ndarray) -> np.ndarray:
    return np.searchsorted(turns, requested - MARK_TOLERANCE)


def spread_of(peaks: np.ndarray, marks: Marks, repetition: Repetition | None) -> Spread:
    """Return the distribution of a joint's force peaks (N) over the window's revolutions.

    All later revolutions of a periodic motion have the peaks of its last periods, without those of the run-in.
    """
    median, p95 = quantiles(peaks, (0.5, 0.95))
    if repetition is None:
        of_million = expected_largest(peaks)
    else:
        lasting = float(peaks[-MIN_REPEATS * repetition.period :].max())
        of_million = Quantile(lasting, lasting, lasting)
    highest = None
    if len(peaks):
        index = int(peaks.argmax())
        highest = float(peaks[index]), math.floor(marks.turns[marks.window[index]] + MARK_TOLERANCE) + 1
    return Spread(median, p95, of_million, highest)


def marks_reached(indices: np.ndarray, revolutions: Any) -> np.ndarray:
    """Return the `indices` of marks that a run has reached."""
    passed = revolutions.passed.item()
    return indices if passed == len(revolutions.marks) else indices[indices < passed]


def peaks_of(scene: Scene, marks: Marks, revolutions: Any) -> np.ndarray:
    """Return the largest normal force (N) of each joint in each revolution of the window: (revolutions, joints)."""
    window = marks_reached(marks.window, revolutions)
    if len(window) < 2:
        return np.zeros((0, len(scene.layout.joints)))
    begin, end = int(window[0]) + 1, int(window[-1]) + 1
    peaks: np.ndarray = revolutions.peaks[begin:end]
    if len(peaks) != len(window) - 1:
        peaks = np.maximum.reduceat(peaks, window[:-1] - window[0])
    if len(scene.layout.joints) == peaks.shape[1]:
        return peaks
    return np.stack([peaks[:, contacts].max(axis=1) for contacts in resultant_contacts(scene.layout)], axis=1)


def repetition_of(scene: Scene, marks: Marks, revolutions: Any) -> Repetition | None:
    """Return the period of the window's motion and where it begins, or None if the motion is not periodic."""
    rows = marks_reached(marks.window, revolutions)
    if len(rows) <= MIN_REPEATS:
        return None
    units, coordinate_count = state_units(scene), len(scene.value.coordinates)
    angle_period = 2.0 * math.pi / units[:coordinate_count]

    def states(chosen: np.ndarray) -> np.ndarray:
        return revolutions.states[chosen, : 2 * coordinate_count] / units  # type: ignore[no-any-return]

    period = period_of(states(rows[-LAST_RETURNS:]), angle_period)
    if period is None:
        return None
    every = states(rows)
    differences = every[period:] - every[:-period]
    angles = differences[:, :coordinate_count]
    angles -= angle_period * np.round(angles / angle_period)
    departures = np.flatnonzero(np.abs(differences).max(axis=1) > RETURN_TOLERANCE)
    first = int(departures[-1]) + 1 if len(departures) else 0
    return Repetition(period, float(marks.turns[rows[first]]))


def period_of(returns: np.ndarray, angle_period: np.ndarray | None = None) -> int | None:
    """Return the period of the last rows of (revolutions, columns), or None.

    angle_period : period of the angles in the first columns: multiples of it count as no difference.
    """
    rows = returns[-LAST_RETURNS:].tolist()  # nearly every motion differs in the first numbers; floats are faster then
    angle_periods = [] if angle_period is None else angle_period.tolist()
    for period in range(1, min(LONGEST_PERIOD, len(rows) // (MIN_REPEATS + 1)) + 1):
        repeats = zip(rows[-MIN_REPEATS * period :], rows[-(MIN_REPEATS + 1) * period : -period], strict=True)
        if all(_is_return(row, previous_row, angle_periods) for row, previous_row in repeats):
            return period
    return None


def _is_return(row: list[float], previous_row: list[float], angle_periods: list[float]) -> bool:
    """Return whether two rows are equal within the tolerance; angle_periods : as in `period_of`."""
    differences = map(operator.sub, row, previous_row)
    is_same_angle = all(
        abs(math.remainder(difference, angle_period)) <= RETURN_TOLERANCE
        for angle_period, difference in zip(angle_periods, differences, strict=False)
    )
    return is_same_angle and all(abs(difference) <= RETURN_TOLERANCE for difference in differences)


# The arrays of an integration: their shapes, their memory, the names of their numbers.

BLOCK_BYTES = 16384  # bytes: need of a short motion without histograms

Arrays = dict[str, np.ndarray]  # name of a field of Work, Totals or RevolutionMarks -> array


def arrays_of(scene: Scene, marks: int, zeros: Callable[..., np.ndarray]) -> Arrays:
    """Return the arrays of an integration of `scene` with a number of `marks`, as zeros; events in the log are unset.

    `initial_values` contains all arrays that do not start as zeros, one behind the other.  `zeros` creates those that
    are cleared for another run.
    """
    contacts, n, value = len(every_contact(scene.value.joints)), scene.start.size, scene.value
    joints, patterns = scene.layout.joints, 2 << min(contacts + PIECE_BITS, MAX_PATTERN_BITS)
    bins = max([min(joint.wear_bins, MAX_BINS) * joint.wear_rows for joint in joints], default=0)
    has_film, has_wear = any(joint.film for joint in joints), any(joint.wear_bins for joint in joints)
    initial_array_shapes: dict[str, tuple[int, ...]] = {
        **initial_shapes(value, scene.start),
        "stepper": (integration.Stepper.SIZE,),
        **dict.fromkeys(("step_peak", "peak_since_mark"), (contacts,)),
        "mechanism": (totals.MechanismTotals.SIZE,),
        "joint": (contacts, totals.ContactTotals.SIZE),
    }
    step_array_shapes = {
        "k": (n, ROW_COUNT),
        "o": (observed_width(value), ROW_COUNT),
        "nodes": (n + 1 + contacts, STAGES),
        "f": (n, STAGES),
        "polynomials": (ROWS, COEFFICIENTS),
        "step": (Step.SIZE,),
        "contact_steps": (contacts, ContactStep.SIZE),
        "profiles": (1 + contacts, observe.PARTS + 1),
        "part_times": (contacts, totals.PART_TIME_ROWS, observe.PARTS),
        "fine_sums": (observe.FINE_ROWS + 2, 2, observe.PARTS),
        "end": (n,),
        "z": (n,),
    }
    cleared_array_shapes = {
        "states": (marks, n),
        "peaks": (marks, contacts),
        "step_values": (contacts, observe.STEP_VALUE_ROWS, observe.PARTS + 1),
        "length": (1,),
        "dense_states": (2 * len(value.coordinates) + 1, observe.STATE_POINTS),
        "workspace": (workspace_size(contacts, bins) if has_wear else 0,),
        "wear": (2 * contacts * bins,),
        "account": (contacts, ACCOUNT_SIZE),
        "friction": (len(friction_laws(value.mechanism)),),
        **dict.fromkeys(("proposals", "onset_rates"), (patterns,)),
    }
    cleared_integer_shapes = {
        "passed": (1,),
        "counts": (integration.Counts.SIZE,),
        "method": (integration.Method.SIZE,),
        "slopes": (integration.Slopes.SIZE,),
        "bins": (contacts, totals.BIN_COLUMNS),
    }
    integer_array_shapes = {"mode": (contacts,), "has_friction": (contacts,)}
    numbers, arrays = np.zeros(sum(map(math.prod, initial_array_shapes.values()))), dict[str, np.ndarray]()
    ends = itertools.accumulate(map(math.prod, initial_array_shapes.values()))
    for (name, shape), end in zip(initial_array_shapes.items(), ends, strict=True):
        arrays[name] = numbers[end - math.prod(shape) : end].reshape(shape)
    return {
        **arrays,
        **{name: _aligned(shape) for name, shape in step_array_shapes.items()},
        **{name: zeros(shape) for name, shape in cleared_array_shapes.items()},
        **{name: zeros(shape, dtype=np.int64) for name, shape in cleared_integer_shapes.items()},
        **{name: np.zeros(shape, np.int64) for name, shape in integer_array_shapes.items()},
        "control": np.zeros(integration.ControlNumbers.SIZE),
        "has_histogram": np.array(
            [not joint.is_rolling or k >= joint.corners for joint in joints for k in range(len(joint.contacts))],
            np.int64,
        ),
        "resultant": _resultants(scene.layout, contacts),
        "fine_bins": _aligned((observe.FINE_ROWS + 1, observe.PARTS)).view(np.int64),
        "histogram": np.zeros((contacts, observe.BINS, 2)),
        "dry": np.zeros((contacts if has_film else 0, observe.BINS, 2)),
        "log": np.empty((loop.LOG_ROWS, 5)),
        "initial_values": numbers,
    }


def _resultants(layout: Layout, contacts: int) -> np.ndarray:
    """Return for each of the contacts the index of the contact that is the resultant of it and others, or -1."""
    resultants = np.full(contacts, -1)
    for row, joint in zip(contact_slices(layout), layout.joints, strict=True):
        if joint.corners and not joint.flanked:
            parts = WALLS if joint.is_spatial else joint.corners
            resultants[row.start : row.start + parts] = row.start + joint.corners
    return resultants


def _aligned(shape: tuple[int, ...]) -> np.ndarray:
    """Return zeros that are aligned for vector registers."""
    numbers = np.zeros(math.prod(shape) + WIDTH)
    begin = -numbers.ctypes.data // 8 % WIDTH
    return numbers[begin : begin + math.prod(shape)].reshape(shape)


def fields_from(record_type: type, arrays: Arrays) -> dict[str, Any]:
    """Return the arrays that are fields of a NamedTuple, with names for their numbers if the type defines them."""
    return {
        name: kind(arrays[name]) if isinstance(kind, type) and issubclass(kind, Fields) else arrays[name]
        for name, kind in record_type.__annotations__.items()
        if name in arrays and kind is not Entry
    }


class Memory:
    """Arrays that start as zeros, cut from a few large blocks so that they are cleared quickly."""

    def __init__(self) -> None:
        self.blocks: list[np.ndarray] = []
        self.bytes_used = 0  # bytes used of the latest block

    def zeros(self, shape: int | tuple[int, ...], dtype: Any = float) -> np.ndarray:
        """Return an array of zeros."""
        byte_count = math.prod(shape if isinstance(shape, tuple) else (shape,)) * np.dtype(dtype).itemsize
        if not self.blocks or self.bytes_used + byte_count > BLOCK_BYTES:
            self.blocks.append(np.zeros(max(byte_count, BLOCK_BYTES), np.uint8))
            self.bytes_used = 0
        begin, self.bytes_used = self.bytes_used, self.bytes_used + -(-byte_count // 8) * 8
        array: np.ndarray = self.blocks[-1][begin : begin + byte_count].view(dtype).reshape(shape)
        return array

    def clear(self) -> None:
        """Set all arrays to zero."""
        for block in self.blocks:
            block.fill(0)


TIME_ROUNDING = 2e-15  # of the largest time: sums that should end at a row of a speed table miss it by less
MAX_STEP_TURNS = 0.02  # crank turns per step at most: keeps maxima and histograms of slow motions accurate
NO_TIMES = np.empty(0)  # to report
UNLIMITED = 2**62  # largest count of steps or events

_METHODS = {"auto": integration.AUTO, "explicit": integration.EXPLICIT, "implicit": integration.IMPLICIT}


def period(scene: Scene) -> float:
    """Return the time (s) of a revolution of the crank."""
    return 2.0 * math.pi / scene.value.reference_rate


class Start(NamedTuple):
    """Scene and inputs of an integration."""

    scene: Scene
    times: np.ndarray  # at which results are reported
    marks: Marks
    inputs: np.ndarray  # the times, the values of the clock at the marks, and `SceneInputs.loop_inputs`
    max_step: float  # s, longest step

    @property
    def kind(self) -> tuple[Any, ...]:
        """Return what scenes must share to reuse one Run: their type, layout, and numbers of inputs."""
        numbers = self.times.size, self.marks.turns.size, self.scene.inputs.knots
        return form_number(self.scene.value), self.scene.layout, *numbers


def start_of(scene: Scene, times: np.ndarray, marks: Marks = NO_MARKS) -> Start:
    """Return the Start of a scene with results at `times` and these `marks`."""
    return Start(
        scene=scene,
        times=times,
        marks=marks,
        inputs=np.concatenate([times, scene.crank_clock.values_after(marks.turns), scene.inputs.loop_inputs]),
        max_step=MAX_STEP_TURNS * period(scene) if scene.mechanism.turns else math.inf,
    )


def control_of(scene: Scene, end: float, *, keep_events: bool) -> integration.Control:
    """Return the control of an integration up to `end` (s, or rad for a free crank)."""
    settings, drive = scene.case.simulate, scene.case.drive
    has_crank, free = scene.mechanism.turns, scene.crank_clock.free
    window_start = scene.crank_clock.value_after(settings.discard) if has_crank else 0.0
    turns = max(settings.revolutions, settings.turns(scene.value.reference_rate), 1.0)
    budget_units = turns if has_crank else settings.impacts
    table = (drive and drive.table) or {}
    return integration.Control(
        window=window_start,
        end=end,
        separations=0 if has_crank else int(settings.impacts),
        step_budget=min(int(settings.step_budget * budget_units), UNLIMITED),
        event_budget=min(int(settings.event_budget * budget_units), UNLIMITED),
        method=_METHODS[settings.method],
        keep_events=keep_events,
        time_limit=settings.time_limit if free else math.inf,
        patience=STALL_TURNS * period(scene) if free else math.inf,
        early=TIME_ROUNDING * table["time"][-1] if {"time", "speed"} <= table.keys() else 0.0,
    )
