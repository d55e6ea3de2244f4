"""Force and moment of the ideal machine on its frame, and the motion of places, over its crank angle."""

import copy
import functools
import math
from functools import partial
from typing import Any, NamedTuple, cast

import numpy as np

from ...contracts.case import Case
from ...contracts.catalogue import Mechanism
from ...contracts.machine import GROUND, Constant, Machine
from ...contracts.vibration import Frame, Vibration
from ...language.errors import InputError
from ...mechanics.machines import planar
from ...mechanics.machines.contract import Built, CompiledPlace, Shaking
from ...mechanics.machines.described import axes_of, point_of, unreacted_loads
from ...tracing.compiled.family import are_entries_empty
from .ideal import (
    MAX_TURNS_PER_CYCLE,
    SAMPLES_PER_TURN,
    knots_of_loads,
    largest,
    machine_of,
    mechanism_of,
    turn_range_of,
)

FX, FY, SQUARE, MOMENT = range(4)
SAME = 1e-9  # relative difference of frequencies that are the same
_FIGURES = ("frame_force_x_peak", "frame_force_y_peak", "frame_force_peak", "frame_moment_peak")


@functools.lru_cache(maxsize=16)  # the cases of a sweep share it
def responses(frame: Frame, spacing: float, count: int) -> np.ndarray:
    """Return velocity over force (m/(N s)) of a frame on its mount, (2, count): along x and y at lines (rad/s)."""
    assert frame.mass is not None
    rates = spacing * np.arange(count)
    stiffness = np.array(frame.mount.stiffness if frame.mount else (0.0, 0.0))[:, None]
    damping = 2.0 * frame.mount.damping * np.sqrt(stiffness * frame.mass) if frame.mount else 0.0
    impedance = 1j * (frame.mass * rates**2 - stiffness) + rates * damping
    response: np.ndarray = np.divide(rates, impedance, out=np.zeros((2, count), dtype=complex), where=rates > 0.0)
    return response


def lines_in(band: tuple[float, float], spacing: float) -> slice:
    """Return which lines, multiples of `spacing` (rad/s), are in a band (rad/s), its ends included."""
    return slice(math.ceil(band[0] / spacing * (1.0 - SAME)), math.floor(band[1] / spacing * (1.0 + SAME)) + 1)


def longest_stretch(case: Case, machine: Machine | None, turns: int) -> float:
    """Return the longest time (s) of `turns` revolutions in the window of a case without clearance; 0 if unknown."""
    if are_entries_empty():
        return 0.0
    machine = machine or machine_of(mechanism_of(case), case)
    assert machine is not None
    ideal, drive = planar.ideal_of(planar.with_segments(machine)), cast(Any, machine.drive)
    passed = np.arange(case.simulate.discard, case.simulate.revolutions * (1.0 + SAME), turns)
    angles = drive.start_angle + planar.direction_of(drive) * 2.0 * math.pi * passed
    times = ideal.crank_passage(angles, lambda: planar.ideal_form(ideal))[0]
    return float(np.diff(times).max(initial=0.0)) if np.isfinite(times).all() else 0.0


class _Spot(NamedTuple):
    """A point of a body, or the frame."""

    name: str
    body: str
    arm: tuple[float, float]  # m, from the centre of mass, in the frame of the body
    axes: int  # 1: only x counts


class IdealShaking(NamedTuple):
    """The ideal machine: figures of the frame, amplitudes of its orders, and of the velocities of places."""

    figures: dict[str, float]  # by column, without its suffix
    orders: np.ndarray  # (2, orders + 1) N, amplitude of the force along x and y
    rate: float  # rad/s, between the lines of the following; 0 if the crank does not turn through the window
    forces: np.ndarray  # (2, lines) N
    places: dict[str, np.ndarray]  # name -> (1 or 2, lines) m/s

    def velocities(self, vibration: Vibration) -> dict[str, float | None]:
        """Return the largest velocity (m/s, rms) of each place along x or y in the band, None without a motion."""
        if not self.rate:
            return dict.fromkeys(self.places if vibration.frame.mass is None else ["frame", *self.places])
        spectra = dict(self.places)
        if vibration.frame.mass is not None:
            spectra["frame"] = self.forces * np.abs(responses(vibration.frame, self.rate, self.forces.shape[1]))
        band = lines_in(vibration.band, self.rate)
        return {
            name: math.sqrt(0.5 * float((amplitudes[:, band] ** 2).sum(axis=1).max()))
            for name, amplitudes in spectra.items()
        }


def ideal_shaking(case: Case, machine: Machine | None) -> IdealShaking:
    """Return the shaking of the machine of a case without clearance; machine : that of the case, if already built."""
    mechanism = mechanism_of(case)
    machine = machine or machine_of(mechanism, case)
    vibration, outline = case.vibration, case.outline.vibration
    assert machine is not None
    assert vibration is not None
    tables = [load.table for load in case.loads if load.table]
    turn_range = turn_range_of(case, tables)
    spots = []
    bodies = {**planar.with_segments(machine).bodies, **machine.bodies}  # housings among them
    for place in vibration.places:
        body, axes = bodies[place.body], axes_of(place, mechanism)
        arm = tuple(np.subtract(point_of(place, body), body.center).tolist())
        spots.append(_Spot(place.name.replace("-", "_"), place.body, arm, axes))
    unreacted = tuple(machine.loads[i].name for i in unreacted_loads(case, machine))
    return _ideal_shaking(
        machine,
        turn_range,
        () if case.simulate.period else knots_of_loads(case, tables, turn_range),
        case.simulate.period,
        (tuple(spots), unreacted, outline.orders if outline else 0, point_of_moment(vibration.frame, machine)),
    )


def shaking_of(case: Case, mechanism: Mechanism, built: Built) -> Shaking:
    """Return the signals of vibration of a case, in compiled form.  Raises InputError for a place that has none."""
    assert case.vibration is not None
    machine, places, form = machine_of(mechanism, case), list[CompiledPlace](), cast(Any, built.value)
    assert machine is not None  # all mechanisms that turn have one
    segmented = planar.with_segments(machine).bodies
    names = [name for name in segmented if name != GROUND]
    for place in case.vibration.places:
        body, number = {**segmented, **machine.bodies}[place.body], names.index(place.body)
        if body.elastic:
            raise InputError(f"vibration.at.{place.name}: {place.body} is elastic; choose a place on a rigid body")
        if mechanism.spatial and place.point:
            path = f"vibration.at.{place.name}.point"
            raise InputError(f"{path}: in space the centre of mass of a body is observed; leave `point` out")
        arm = np.subtract(point_of(place, body), body.center).tolist()
        compiled_number = form.reported[number] if mechanism.spatial else planar.as_empty_tuples(1 + number)
        places.append(CompiledPlace(compiled_number, *arm))
    unreacted = tuple(map(planar.as_empty_tuples, unreacted_loads(case, machine)))
    return Shaking(tuple(places), unreacted, *point_of_moment(case.vibration.frame, machine))


def ideal_frame_force(case: Case, angles: np.ndarray) -> np.ndarray:
    """Return the force x, y (2, N) N on the frame without clearance at crank angles (N,) rad from the start on."""
    machine = machine_of(mechanism_of(case), case)
    assert machine is not None
    unreacted = tuple(machine.loads[i].name for i in unreacted_loads(case, machine))
    force: np.ndarray = _Shaking(machine, (0.0, 0.0), unreacted, over_time=False).at(angles, ())[0][:2]
    return force


def point_of_moment(frame: Frame, machine: Machine) -> tuple[float, float]:
    """Return the point (m) about which the moment on the frame is taken."""
    if frame.about is not None:
        return frame.about
    pivot = next(joint.proximal for joint in machine.joints if joint.name == machine.driven)
    x, y = machine.bodies[pivot.body].points[pivot.point]
    return x, y


# the cases of a sweep share few mechanisms and speeds
@planar.shared_by(lambda machine, *further: (planar.machine_key(machine), further), 256)
def _ideal_shaking(
    machine: Machine,
    turn_range: tuple[float, float],
    knots: tuple[float, ...],
    period: float | None,
    observed: tuple[tuple[_Spot, ...], tuple[str, ...], int, tuple[float, float]],
) -> IdealShaking:
    """Return the shaking of a machine over a range of revolutions, or of cycles of a `period` (s)."""
    drive: Any = machine.drive
    spots, unreacted, orders, about = observed
    shaking = _Shaking(machine, about, unreacted, over_time=period is not None)
    start, scale, count = drive.start_angle, planar.direction_of(drive), SAMPLES_PER_TURN
    if period is not None:
        start, scale = 0.0, period / (2.0 * math.pi)
        count *= math.ceil(min(max(1.0, shaking.ideal.reference_rate() * scale), MAX_TURNS_PER_CYCLE))
    begin, turns = turn_range[0], max(math.floor(turn_range[1] - turn_range[0] + 1e-9), 1)
    angles: np.ndarray = 2.0 * math.pi * (begin + np.arange(count * turns) / count)
    frame, velocities = shaking.at(start + scale * angles, spots)

    def sizes(angles: np.ndarray) -> np.ndarray:
        return np.abs(shaking.at(start + scale * angles, ())[0])  # type: ignore[no-any-return]

    peaks = largest(sizes, np.array(sorted({*angles.tolist(), 2.0 * math.pi * turn_range[1], *knots})))
    figures = dict(zip(_FIGURES, [*peaks[:2], math.sqrt(peaks[2]), peaks[3]], strict=True))
    figures |= {
        "frame_force_rms": math.sqrt(float(frame[SQUARE].mean())),
        "frame_moment_rms": math.sqrt(float((frame[MOMENT] ** 2).mean())),
    }
    forces = _amplitudes(frame[:2])
    in_orders = forces[:, : orders * turns + 1 : turns]
    amplitudes = _amplitudes
    if period:
        rate = 2.0 * math.pi / (turns * period)
    elif turn_range[1] == turns and isinstance(drive, Constant):
        rate = abs(drive.speed) / turns
    else:
        ends = start + scale * np.append(angles, 2.0 * math.pi * (begin + turns))
        times = shaking.ideal.crank_passage(ends, lambda: planar.ideal_form(shaking.ideal))[0]
        rate = 2.0 * math.pi / (times[-1] - times[0]) if np.isfinite(times).all() else 0.0
        amplitudes = partial(_amplitudes_over_time, times)
        forces = amplitudes(frame[:2])
    by_name = {spot.name: amplitudes(velocities[i][: spot.axes]) for i, spot in enumerate(spots)}
    return IdealShaking({key: float(value) for key, value in figures.items()}, in_orders, rate, forces, by_name)


def _amplitudes_over_time(times: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return the amplitudes (signals, lines) of values (signals, n) at `times` (n + 1,) s but the last, by cubics."""
    count = values.shape[1]
    even = times[0] + (times[-1] - times[0]) * np.arange(count) / count
    place = np.clip(np.searchsorted(times[:-1], even, side="right") - 1, 0, count - 2)
    steps, slopes = np.diff(times[:-1]), np.gradient(values, times[:-1], axis=1, edge_order=2)
    step, part = steps[place], (even - times[place]) / steps[place]
    rise = values[:, place + 1] - values[:, place]
    begin, end = slopes[:, place] * step - rise, rise - slopes[:, place + 1] * step
    cubic = values[:, place] + part * rise + part * (1.0 - part) * ((1.0 - part) * begin + part * end)
    return _amplitudes(cubic)


def _amplitudes(values: np.ndarray) -> np.ndarray:
    """Return the amplitudes (signals, lines) of signals (signals, n) over their span."""
    amplitudes: np.ndarray = 2.0 / values.shape[1] * np.abs(np.fft.rfft(values, axis=1))
    return amplitudes


class _Shaking:
    """The signals of an ideal machine at crank angles (rad), or at times (s)."""

    def __init__(self, machine: Machine, about: tuple[float, float], unreacted: tuple[str, ...], *, over_time: bool):
        """Prepare for a machine whose frame does not react the loads of these names."""
        self.ideal, self.about, self.over_time = planar.ideal_of(planar.with_segments(machine)), about, over_time
        loads = tuple(load for load in self.ideal.machine.loads if load.name in unreacted)
        self.loaded = copy.copy(self.ideal) if loads else None
        if self.loaded:
            self.loaded.machine = self.ideal.machine._replace(loads=loads, gravity=0.0)

    def at(self, places: np.ndarray, spots: tuple[_Spot, ...]) -> tuple[np.ndarray, list[np.ndarray]]:
        """Return force x, y, its square and moment (4, N), and velocities (2, N) m/s of spots, at places (N,)."""
        passage = self.ideal.passage_at(places, lambda: planar.ideal_form(self.ideal), self.over_time)
        parts = np.array_split(np.stack(passage), max(len(places) // SAMPLES_PER_TURN, 1), axis=1)
        results = [self._part(part, spots) for part in parts]
        frame = np.concatenate([result[0] for result in results], axis=1)
        return frame, [np.concatenate([result[1][i] for result in results], axis=1) for i in range(len(spots))]

    def _part(self, passage: np.ndarray, spots: tuple[_Spot, ...]) -> tuple[np.ndarray, list[np.ndarray]]:
        """Return the results of `at`; passage : (3, N) angles (rad), times (s) and rates (rad/s)."""
        angles, times, rates = passage
        states, inertia = self.ideal.states_at(angles), self.ideal.inertia
        acceleration = self.ideal.balance(states, rates, times)[0]
        motion = states.second_derivative * (rates**2)[:, None] + states.derivative * acceleration[:, None]
        forces = -inertia * motion
        forces[:, 1::3] -= self.ideal.heavy * self.ideal.machine.gravity
        if self.loaded:
            forces += self.loaded.applied_forces(states, rates, times)
        x, y = states.q[:, 0::3] - self.about[0], states.q[:, 1::3] - self.about[1]
        fx, fy = forces[:, 0::3].sum(axis=1), forces[:, 1::3].sum(axis=1)
        moment = (x * forces[:, 1::3] - y * forces[:, 0::3] + forces[:, 2::3]).sum(axis=1)
        velocities = [self._velocity(states, rates, spot) for spot in spots]
        return np.stack([fx, fy, fx * fx + fy * fy, moment]), velocities

    def _velocity(self, states: planar.MachineStates, rates: np.ndarray, spot: _Spot) -> np.ndarray:
        """Return the velocity (2, N) m/s of a spot."""
        i = 3 * self.ideal.closure.index[spot.body]
        angle, turn, (arm_x, arm_y) = states.q[:, i + 2], states.derivative[:, i + 2], spot.arm
        x = np.cos(angle) * arm_x - np.sin(angle) * arm_y
        y = np.sin(angle) * arm_x + np.cos(angle) * arm_y
        velocity: np.ndarray = rates * np.stack(
            [states.derivative[:, i] - turn * y, states.derivative[:, i + 1] + turn * x]
        )
        return velocity
