"""Converts a finished integration to a trajectory: figures, histories and the status in words."""

import functools
import math
from typing import Any

import numpy as np

from ...answers.validity import join_remarks
from ...contracts.layout import SECTION_COUNT, Layout
from ...contracts.machine import Motor
from ...contracts.results import EVENT_DTYPE, OUTSIDE_MODEL, PARTIAL_STATUSES, Trajectory
from ...mechanics.observe import force_quantiles, time_above
from ...mechanics.solver import integration
from ...mechanics.solver.slow_sums import Record, sample_states
from ...mechanics.solver.totals import HIGHEST_BIN
from ..figures.catalogue import WORK_COUNTS, figures_of, layout_formulas
from ..figures.window import DRY_FORCE_THRESHOLD, RARE_SHARE, Cost, Window, by_joint, summed_of, wear_depths_of
from ..machine.ideal import ideal_peaks
from ..remarks import remarks, yield_speeds
from ..running.run import BENT_TOO_FAR, HISTORY_NOT_FINITE, ROUNDING, TIME_BUDGET, Run, onset_rates
from ..running.vibration import vibration_figures
from ..setup.scene import Scene, length_unit
from ..setup.start import control_of, marks_reached, peaks_of, repetition_of, spread_of, start_turns

LEFT_BEARING = "left-bearing"
NO_EVENT_RECORDS = np.empty(0, EVENT_DTYPE)
_STATUS = {
    integration.STEP_BUDGET: (
        "step-budget",
        "reached the budget of {budget:,} steps at {time:.6g} s{of_total} ({steps:,} accepted, {rejected:,} rejected); "
        "increase simulate.step_budget",
    ),
    integration.EVENT_BUDGET: (
        "event-budget",
        "reached the budget of {events:,} events at {time:.6g} s{of_total}; increase simulate.event_budget",
    ),
    TIME_BUDGET: (
        "time-budget",
        "reached the budget of {patience:.6g} s of process time at {time:.6g} s{of_total}, after {steps:,} steps; "
        "increase simulate.time_budget",
    ),
    BENT_TOO_FAR: (
        OUTSIDE_MODEL,
        "a link deflected by more than a quarter of its length by {time:.6g} s{of_total}, beyond its second-order "
        "model; use a thicker or shorter link, or a slower drive",
    ),
    ROUNDING: (
        "rounding",
        "simulate.tolerance is below what positions of this size resolve: {size:.3g} m rounds to {rounding:.1e} m; "
        "{effect}. After {steps:,} steps the run is at {time:.6g} s{of_total}; a tolerance of {enough:.0e}{or_larger} "
        "is enough",
    ),
    integration.NOT_FINITE: (
        "not-finite",
        "the motion is no longer finite at {time:.6g} s; check masses, stiffness and clearance for wrong units",
    ),
    integration.SUMS_NOT_FINITE: (
        "not-finite",
        "the motion is finite up to {time:.6g} s, but a sum of its powers, forces or wear is not; check masses, "
        "stiffness and wear coefficients for wrong units, else report this grid as an error of the program",
    ),
    HISTORY_NOT_FINITE: (
        "not-finite",
        "the motion is finite up to {time:.6g} s, but its history {history} is not; check what own laws return, else "
        "report this grid as an error of the program",
    ),
    integration.STEP_UNDERFLOW: (
        "step-underflow",
        "the step became too small at {time:.6g} s; try a larger tolerance, or a force law without jumps",
    ),
    integration.TIME_LIMIT: (
        "time-limit",
        "reached the time limit at {time:.6g} s{of_total}; increase simulate.time_limit",
    ),
    integration.STALLED: (
        "stalled",
        "the drive stalls: at {time:.6g} s{of_total}, the crank stops; increase torque, flywheel "
        "inertia or initial speed, or reduce the loads",
    ),
    integration.LEFT_BEARING: (
        LEFT_BEARING,
        "the journal of {joint} leaves its bearing at {escape_time:.6g} s, after {revolutions:.4g} revolutions. The "
        "axial distance of their middles is {axial_distance:.4g} mm, half of the sum of both lengths. Write flange: "
        "true with an axial_clearance, lengthen bearing or journal, or hold the body along the axis at another joint",
    ),
}


_AT_REST = (
    "at-rest",
    "the oil stops the bodies before simulate.impacts is reached; reduce it, or use thinner oil or a higher speed",
)
_BACKWARDS = (
    "the torque of the drive is negative and turns the crank backwards from {time:.6g} s on; write a positive one, or "
    "mirror the mechanism"
)
_NEVER_TURNS = (
    "the crank does not turn: up to {time:.6g} s its loads, static friction among them, hold the torque of the drive; "
    "increase the torque, reduce the loads, or measure a machine at rest by simulate: {{time: 5 s}} in place of "
    "revolutions"
)
STANDING = 1e-4  # revolutions, below which a crank has not turned; what is loose on it may shake it
REST_RATE = 1e-9  # rad/s, of a crank that is at rest at its time limit; a faster one may only have had too little time
TYPICAL_STEPS = 10.0  # the budget over the steps that a run should need at a tolerance that is advised
LARGEST_TOLERANCE = 1e-3  # that is advised
REST_SPEED = 1e-3  # of the initial speed: slower bodies count as at rest when no step is small enough


def _status_of(scene: Scene, run: Run) -> tuple[str, str]:
    """Return the status of an integration and its message."""
    has_film = any(joint.film for joint in scene.layout.joints)
    if run.status == integration.STEP_UNDERFLOW and has_film and not scene.mechanism.turns:
        rates = slice(len(scene.value.coordinates), 2 * len(scene.value.coordinates))
        if np.abs(run.work.y[rates]).max() <= REST_SPEED * np.abs(scene.start[rates]).max():
            return _AT_REST
    drive = scene.machine.drive if scene.machine else None
    if run.status == integration.STALLED and isinstance(drive, Motor) and drive.stall_torque < 0.0:
        return _STATUS[run.status][0], _BACKWARDS
    work: Any = run.work  # mypy takes its parts for tuples of anything
    is_free, at_limit = scene.crank_clock.free, run.status == integration.TIME_LIMIT
    rate = work.y[len(scene.value.coordinates) + work.independent] if is_free else 0.0
    is_at_rest = run.status == integration.STALLED or (at_limit and abs(rate) < REST_RATE)
    if is_at_rest and not work.totals.mechanism.kinetic_start and _turns_of(scene, run) < STANDING:
        return _STATUS[run.status][0], _NEVER_TURNS
    return _STATUS[run.status]


def _turns_of(scene: Scene, run: Run) -> float:
    """Return the revolutions of a free crank since its start."""
    return float(run.work.y[run.work.independent] - scene.crank_clock.value_after(0.0)) / (2.0 * math.pi)


def trajectory_of(scene: Scene, run: Run, end: float) -> Trajectory:
    """Return the trajectory of an integration up to `end` (s, or rad for a free crank)."""
    window, failed = window_of(scene, run, end), run.status != integration.OK
    summary, units = figures_of(window, failed=failed), layout_formulas(scene.layout).units.copy()
    log = _events_of(scene.layout, run.events)
    if failed:
        status, message = _failure_of(scene, run, end)
        sample_count = int(run.work.counts.samples) if status in PARTIAL_STATUSES else 0
        channels = _histories_of(scene.layout, run.record, sample_count)
        events = log if status in (LEFT_BEARING, *PARTIAL_STATUSES) else log[:0]
        return Trajectory(status, message, summary, channels, events, units=units)
    summary |= run.figures
    summary |= yield_speeds(scene)
    summary |= vibration_figures(scene, run.signals, summary) if run.signals else {}
    summary |= run.link_signals.figures(scene.layout.output) if run.link_signals else {}
    message = join_remarks(*remarks(scene, window, summary))
    channels, sections = _histories_of(scene.layout, run.record, len(run.record.times)), sections_of(scene, run)
    return Trajectory("ok", message, summary, channels, log, window.wear, sections, units)


def window_of(scene: Scene, run: Run, end: float) -> Window:
    """Return the Window of an integration up to `end` (s, or rad for a free crank), from which figures are computed.

    Figures of forces, and the period, are left out of a failed run, as sums and states may then be infinite.
    """
    settings, duration, failed = scene.case.simulate, _duration(scene, run, end), run.status != integration.OK
    totals = by_joint(run.totals, scene.layout)
    sums = summed_of(totals)
    # A quantile may lie anywhere in its bin, also above the largest force
    highest = totals.bins[:, HIGHEST_BIN].tolist()
    quantiles = [] if failed else force_quantiles(totals.histogram, highest, RARE_SHARE * duration)
    revolutions: Any = run.work.revolutions  # mypy takes it for a tuple of anything
    repetition = None if failed else repetition_of(scene, run.marks, revolutions)
    # Time (s) below the least load of each rolling bearing of known rating, in a window of `duration` (s)
    light_load_times = [
        max(duration - time_above(joint.rolling.least_load, histogram), 0.0)
        if joint.rolling and joint.rolling.least_load
        else 0.0
        for joint, histogram in zip(scene.case.joints, totals.histogram, strict=True)
    ]
    return Window(
        case=scene.case,
        mechanism=scene.mechanism,
        layout=scene.layout,
        joints=scene.value.joints,
        totals=sums,
        exceeded_force=[min(force, joint.force_max) for force, joint in zip(quantiles, sums.joint, strict=False)],
        dry_time=[  # s, in which the dry contact carries load
            time_above(DRY_FORCE_THRESHOLD * sums.joint[index].load_time / duration, totals.dry[index])
            if joint.film
            else 0.0
            for index, joint in enumerate(scene.layout.joints)
        ],
        light_load_time=light_load_times,
        ideal=ideal_peaks(scene.case, scene.machine) if scene.mechanism.turns and not failed else {},
        wear=wear_depths_of(scene.layout, sums),
        counts=run.counts,
        events=int(run.work.counts.events),
        integration_time=run.duration,
        duration=duration,
        turns=settings.revolutions - settings.discard if scene.mechanism.turns else 1.0,
        spreads=tuple(spread_of(each, run.marks, repetition) for each in peaks_of(scene, run.marks, revolutions).T),
        repetition=repetition,
        sliding_distance=[
            scene.worn[joint.name].sliding_distance if joint.name in scene.worn else 0.0 for joint in scene.case.joints
        ],
        onset_rate=onset_rates(run),
    )


def add_cost(summary: dict, cost: Cost) -> None:
    """Add the work of further integrations to the work counts of a summary."""
    for figure in WORK_COUNTS:
        assert figure.value is not None
        summary[figure.name] += (int if figure.kind == "int" else float)(figure.value(cost, None))


def _failure_of(scene: Scene, run: Run, end: float) -> tuple[str, str]:
    """Return the status of a failed integration and its message."""
    status, text = _status_of(scene, run)
    of_total = f" of {end:.6g} s" if math.isfinite(end) else ""
    if scene.crank_clock.free:
        of_total = f", after {_turns_of(scene, run):.4g} of {scene.case.simulate.revolutions:.6g} revolutions"
    message = text.format(
        time=run.work.y[run.work.time],
        of_total=of_total,
        events=int(run.work.counts.events),
        steps=int(run.work.counts.steps),
        rejected=int(run.work.counts.rejected),
        patience=scene.case.simulate.time_budget,
        budget=control_of(scene, end, keep_events=False).step_budget,
        **(_escaped_journal(scene, run) if run.status == integration.LEFT_BEARING else {}),
        **(_unresolved_positions(scene, run) if run.status == ROUNDING else {}),
        history=scene.layout.channels[np.argwhere(~np.isfinite(run.record.samples))[0, 1]].name
        if run.status == HISTORY_NOT_FINITE
        else "",
    )
    return status, message


def _unresolved_positions(scene: Scene, run: Run) -> dict[str, str | float]:
    """Return size (m), rounding (m), what it does in the tightest joint, and a tolerance that is enough.

    The number of steps grows about as tolerance^(-2/3).
    """
    tightest = min(scene.case.joints, key=lambda joint: joint.clearance, default=None)
    clearance = length_unit(scene.value.joints, scene.built)
    rounding = np.finfo(float).eps * scene.built.size
    excess = max(TYPICAL_STEPS * run.expected_steps() / run.work.control.step_budget, 1.0)
    enough = scene.case.simulate.tolerance * max(excess**1.5, 2.0)
    return {
        "size": scene.built.size,
        "rounding": rounding,
        "effect": f"this turns the contact force of {tightest.name}, with {1e6 * clearance:.3g} um of clearance, by "
        f"{rounding / clearance:.1e} rad"
        if tightest
        else "this moves the links",
        "or_larger": ", or a larger clearance," if tightest else "",
        "enough": min(10.0 ** math.ceil(math.log10(enough)), LARGEST_TOLERANCE),
    }


def _escaped_journal(scene: Scene, run: Run) -> dict[str, str | float]:
    """Return which journal left its bearing, the time (s, revolutions) and its eccentricity (mm), for the message."""
    work, contact = run.work, int(run.work.stepper.contact)
    bounds = np.cumsum([len(joint.contacts) for joint in scene.layout.joints])
    index = int(np.searchsorted(bounds, contact, side="right"))
    joint: Any = scene.value.joints[index]  # mypy takes it for a tuple of anything
    assert scene.case.drive  # what moves in space is turned
    turns = work.end[work.time] * abs(scene.case.drive.speed) / (2.0 * math.pi)
    return {
        "joint": scene.case.joints[index].name,
        "escape_time": work.end[work.time],
        "revolutions": turns,
        "axial_distance": 1e3 * (joint.half_length + joint.journal_half_length),
    }


def sections_of(scene: Scene, run: Run) -> dict[str, np.ndarray]:
    """Return journal positions and velocities at crank angle 0 of every revolution, by channel, or {} if not stored."""
    if not len(run.marks.sections) or not run.work.sample.code:
        return {}
    revolutions: Any = run.work.revolutions  # mypy takes it for a tuple of anything
    sections = marks_reached(run.marks.sections, revolutions)
    channels = scene.layout.channels
    values = np.zeros((len(sections), len(channels)))
    sample_states(run.work, revolutions.states[sections], values)
    columns = {channel.name: column for channel, column in zip(channels, values.T, strict=True)}
    revolution_numbers = np.round(run.marks.turns[sections] + start_turns(scene)).astype("i8")
    return {SECTION_COUNT: revolution_numbers} | {
        section: columns[name].copy() for name, section in scene.layout.sections
    }


def _histories_of(layout: Layout, record: Record, count: int) -> dict[str, np.ndarray]:
    """Return the first `count` samples of the time histories of a run by channel, or {} if none are recorded."""
    if not count:
        return {}
    samples = np.array(record.samples[:count].T, order="C")  # a copy: another case may reuse the buffers
    return dict(zip([channel.name for channel in layout.channels], samples, strict=True))


def _events_of(layout: Layout, log: np.ndarray) -> np.ndarray:
    """Return the event log of a run, (events, 5), as a structured array."""
    if not len(log):
        return NO_EVENT_RECORDS
    rows = (2.0 * log[:, 1] + (log[:, 2] == integration.ONSET)).astype(int)
    records: np.ndarray = _unnumbered_events(layout.contacts).take(rows)
    records["t"], records["rate"], records["force_peak"] = log[:, 0], log[:, 3], log[:, 4]
    return records


@functools.lru_cache(maxsize=64)
def _unnumbered_events(contacts: tuple[str, ...]) -> np.ndarray:
    """Return the records of a separation and of an onset of each contact, one after the other, without numbers."""
    names = np.repeat(contacts, 2)
    types = {name: EVENT_DTYPE[name] for name in EVENT_DTYPE.names or ()}
    types["joint"] = np.promote_types(types["joint"], names.dtype)
    records = np.zeros(len(names), [*types.items()])
    records["joint"], records["kind"] = names, np.tile(["off", "on"], len(contacts))
    return records


def _duration(scene: Scene, run: Run, end: float) -> float:
    """Return the length (s) of the window of an integration up to `end`."""
    if not scene.mechanism.turns:
        return float(run.work.end[run.work.time])
    if scene.crank_clock.free:
        return float(run.work.end[run.work.time] - run.totals.mechanism.window_start)
    return end - scene.crank_clock.value_after(scene.case.simulate.discard)
