"""From a scene to its trajectory: one integration or more, the figures they come to, the status in words."""

import dataclasses
import math
from collections.abc import Generator, Iterable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..case import Case
from ..errors import InputError
from ..grid import check_memory, history_bytes
from ..layout import DIFFERENCE, Layout
from ..mechanics.joint import registry
from ..mechanics.observe.record import Record
from ..mechanics.observe.tally import ONSETS
from ..mechanics.solver import event as events
from ..mechanics.solver import loop
from ..results import EVENT_DTYPE, Trajectory
from ..validity import UNCHECKED, Reached, imbalance, kept_onsets, message_of, past_limits, too_deep, worn_through
from .figures import COST, figures_of
from .run import TIME_BUDGET, Run, alone, call, control_of, integrate, integrated, integrating, onset_rates, period
from .scene import Patience, Scene, build
from .until import Until, longest, marks
from .watch import Moment, Watcher, go_to
from .window import Window, wear_of

Simulating = Generator[Run, None, Trajectory]

_STATUS = {
    loop.OK: ("ok", ""),
    loop.STEP_BUDGET: (
        "step-budget",
        "took {steps:,} steps and {rejected:,} that were rejected, all {budget:,} it may, having got to {time:.6g} s"
        "{whole}; simulate.step_budget allows more",
    ),
    loop.EVENT_BUDGET: (
        "event-budget",
        "met all {events:,} events it may, having got to {time:.6g} s{whole}; simulate.event_budget allows more",
    ),
    TIME_BUDGET: (
        "time-budget",
        "took the {patience:.6g} s of process time that it may, having got to {time:.6g} s{whole} in {steps:,} steps; "
        "simulate.time_budget allows more",
    ),
    loop.NOT_FINITE: (
        "not-finite",
        "the motion is no longer finite at {time:.6g} s; look for masses, stiffness or clearance far from each other",
    ),
    loop.STEP_UNDERFLOW: (
        "step-underflow",
        "no step is small enough at {time:.6g} s; a looser tolerance may help, or a force law without jumps",
    ),
}


def simulate(scene: Scene, times: ArrayLike | None = None, watchers: Sequence[Watcher] = ()) -> Trajectory:
    """Return the trajectory of a scene.

    Parameters
    ----------
    scene : what `load_case` or `scene.build` returned.
    times : (n,) s, increasing, within the run: where to report.  None: the case's own sampling.
    watchers : what looks at the run on its way, see `watch.drive`.

    A failed integration is a Trajectory too: its `status` names the reason, `message` says it in a sentence.  Raises
    InputError for times outside the run.
    """
    return alone(simulating(scene, times, watchers))


def simulating(scene: Scene, times: ArrayLike | None = None, watchers: Sequence[Watcher] = ()) -> Simulating:
    """Simulate a scene, as `simulate` does, but hand out every plain integration for others to do, see `alone`."""
    scene = dataclasses.replace(scene, patience=Patience(scene.case.simulate.time_budget))
    if scene.layout.until:
        trajectory = _settle(scene, times, watchers)
    else:
        trajectory = yield from _simulate(scene, times, watchers)
    if scene.layout.error_check:
        trajectory = yield from _error_checked(scene, trajectory)
    return trajectory


def _simulate(scene: Scene, times: ArrayLike | None, watchers: Sequence[Watcher] = ()) -> Simulating:
    """Return the trajectory of a scene whose length is given."""
    turning = scene.mechanism.turns
    end = scene.case.simulate.revolutions * period(scene) if turning else math.inf
    if times is not None:
        reported = checked_times(times, end)
    elif scene.case.save.orbits == "none":
        reported = np.empty(0)
    elif not turning:  # its duration is known afterwards
        last = yield from integrating(scene, np.empty(0), end)
        reported = np.linspace(0.0, last.work.end[last.work.time], scene.case.save.samples + 1)
    else:
        check_memory(history_bytes(scene.layout, scene.case.save, scene.case.simulate.revolutions))
        reported = sampling_times(scene.case, period(scene), end)
    run = yield from integrating(scene, reported, end, watchers)
    return _trajectory(scene, run, end)


def _settle(scene: Scene, times: ArrayLike | None, watchers: Sequence[Watcher]) -> Trajectory:
    """Return the trajectory of a scene that is to run until a figure has settled.

    What is reported comes from a second run over that stretch, the same to the last bit, as its times were not known.
    """
    settings, turn, orbits = scene.case.simulate, period(scene), scene.case.save.orbits
    whole = _changed(scene, revolutions=longest(settings))
    end = whole.case.simulate.revolutions * turn
    run = Run(scene, marks(settings, turn))
    watch = Until(scene, run.record.samples)
    keep_events = orbits != "none" or times is not None
    integrate(whole, run, end, keep_events=keep_events, watchers=(watch, *watchers))
    run.record = Record(np.empty(0), np.empty(0))
    if run.status != loop.OK:
        return _trajectory(whole, run, end)
    settled = _changed(scene, revolutions=watch.revolutions)
    end = watch.revolutions * turn
    if times is not None or orbits != "none":
        check_memory(0.0 if times is not None else history_bytes(scene.layout, scene.case.save, watch.revolutions))
        reported = sampling_times(settled.case, turn, end) if times is None else checked_times(times, end)
        _retrace(settled, run, reported, end, watch.starts)
    trajectory = _trajectory(settled, run, end)
    trajectory.summary.update(watch.figures())
    return trajectory


def _retrace(scene: Scene, run: Run, times: np.ndarray, end: float, starts: Iterable[Moment]) -> None:
    """Record the motion of a run at `times`, from the last of its `starts` before them or from the beginning."""
    again = Run(scene, times)
    before = [start for start in starts if times.size and start["y"][run.work.time] <= times[0]]
    if before:
        go_to(before[-1], again.work)
    call(again, control_of(scene, end, keep_events=False), scene)
    run.status, run.record = again.status, again.record
    run.spent(again)


def _changed(scene: Scene, **settings: Any) -> Scene:
    """Return a scene with other values in `simulate`."""
    simulate = scene.case.simulate._replace(**settings)
    return dataclasses.replace(scene, case=scene.case._replace(simulate=simulate))


def _error_checked(scene: Scene, trajectory: Trajectory) -> Simulating:
    """Return a trajectory with the difference of every figure from a run at a tenth of the tolerance in its summary."""
    if trajectory.status != "ok":
        return trajectory
    tighter = {"tolerance": 0.1 * scene.case.simulate.tolerance}
    if scene.layout.until:
        tighter["revolutions"] = trajectory.summary["revolutions_run"]
    other = yield from _simulate(_changed(scene, **tighter), np.empty(0))
    _differ(trajectory.summary, other.summary)
    if other.status == "ok":
        return trajectory
    failure = f"{UNCHECKED}the run at a tenth of the tolerance has the status {other.status}: {other.message}"
    return dataclasses.replace(trajectory, message=message_of(trajectory.message, failure))


def _differ(summary: dict, tighter: dict) -> None:
    """Enter into a summary how far its figures are from those at a tighter tolerance, and add what the latter cost."""
    for name in [name for name in summary if name.endswith(DIFFERENCE)]:
        values = (summary[name.removesuffix(DIFFERENCE)], tighter[name.removesuffix(DIFFERENCE)])
        summary[name] = None if None in values else abs(values[0] - values[1])
    for figure in COST:
        summary[figure.name] += tighter[figure.name]


def compile_for(case: Case) -> None:
    """Compile, or load from the cache, the code of a case by running its first moment; stiff motion may take more."""
    scene = build(case)
    end = 1e-3 / scene.value.reference_rate
    bare = case.save.orbits == "none" and not scene.layout.until
    integrated(scene, np.empty(0) if bare else np.array([0.0]), end)


def _trajectory(scene: Scene, run: Run, end: float) -> Trajectory:
    """Return the trajectory that an integration came to."""
    reached = run.work.y[run.work.time] if run.status != loop.OK else end
    status, text = _STATUS[run.status]
    whole = f" of {end:.6g} s" if math.isfinite(end) else ""
    message = text.format(
        time=reached,
        whole=whole,
        events=int(run.work.counts[events.EVENTS]),
        steps=int(run.work.counts[events.STEPS]),
        rejected=int(run.work.counts[events.REJECTED]),
        patience=scene.case.simulate.time_budget,
        budget=control_of(scene, end, keep_events=False).step_budget,
    )
    failed = run.status != loop.OK
    summary = dict.fromkeys(column.name for column in scene.layout.columns)
    window = window_of(scene, run, end)
    summary |= figures_of(window, failed=failed)
    if failed:
        return Trajectory(status, message, summary)
    summary |= run.figures
    limits = past_limits(
        (
            joint.name,
            joint.contact.elastic or "",
            registry.penetration_limit(joint),
            float(summary[f"{joint.column}_law_limit_fraction"] or 0.0),
        )
        for joint in scene.case.joints
    )
    message = message_of(limits, kept_onsets(_lasting(scene, run)), *nonsense(scene, run, summary))
    names = [channel.name for channel in scene.layout.channels]
    histories = (
        dict(zip(names, np.ascontiguousarray(run.record.samples.T), strict=True)) if run.record.times.size else {}
    )
    return Trajectory(status, message, summary, histories, _events_of(scene.layout, run.events), window.wear)


def _lasting(scene: Scene, run: Run) -> Iterator[tuple[str, float]]:
    """Yield joint and onset rate (m/s) of every contact that lasts throughout the window and keeps that rate."""
    kept = onset_rates(run)
    for j, joint in enumerate(scene.case.joints):
        if joint.contact.onset == "first" and not math.isnan(kept[j]) and run.tally.joint[j, ONSETS] == 0.0:
            yield joint.name, kept[j]


def nonsense(scene: Scene, run: Run, summary: Mapping[str, Any]) -> tuple[str, ...]:
    """Return remarks on figures of a finished case that cannot be meant, '' for each that can."""
    joints = [
        Reached(
            joint.name,
            summary[f"{joint.column}_penetration_max"],
            summary.get(f"{joint.column}_wear_depth_max") or 0.0,
            joint.clearance,
            joint.bearing_radius,
        )
        for joint in scene.case.joints
    ]
    onsets = 0.5 * run.work.counts[events.EVENTS]
    count = onsets + max(scene.case.simulate.revolutions, 1.0)
    balance = imbalance(summary["energy_residual"], scene.case.simulate.tolerance, count)
    return too_deep(joints), worn_through(joints), balance


def _events_of(layout: Layout, log: np.ndarray) -> np.ndarray:
    """Return the event log of a run, (events, 5), as a structured array."""
    found = np.empty(len(log), EVENT_DTYPE)
    names = np.array([joint.name for joint in layout.joints])
    found["t"], found["rate"], found["force_peak"] = log[:, 0], log[:, 3], log[:, 4]
    found["joint"] = names[log[:, 1].astype(int)]
    found["kind"] = np.where(log[:, 2] == loop.ONSET, "on", "off")
    return found


def window_of(scene: Scene, run: Run, end: float) -> Window:
    """Return what an integration up to `end` (s) came to."""
    settings, turning = scene.case.simulate, scene.mechanism.turns
    return Window(
        case=scene.case,
        mechanism=scene.mechanism,
        layout=scene.layout,
        joints=scene.value.joints,
        tally=run.tally,
        wear=wear_of(scene.layout, run.tally),
        counts=run.counts,
        seconds=run.duration,
        duration=end - settings.discard * period(scene) if turning else run.work.end[run.work.time],
        turns=settings.revolutions - settings.discard if turning else 1.0,
        onset=onset_rates(run),
    )


def checked_times(times: ArrayLike, end: float) -> np.ndarray:
    """Return times (s) that a user asks for, as an array; raise InputError unless they lie within a run up to `end`."""
    array: np.ndarray = np.ascontiguousarray(times, dtype=float)
    if array.ndim != 1 or not np.all(np.isfinite(array)) or np.any(np.diff(array) < 0.0):
        raise InputError("times: expected a one-dimensional array of increasing, finite times in s")
    if array.size and not (array[0] >= 0.0 and array[-1] <= end * (1.0 + 1e-12)):
        raise InputError(f"times: found {array[0]:.6g} s to {array[-1]:.6g} s; the run lasts from 0 to {end:.6g} s")
    within: np.ndarray = np.minimum(array, end)
    return within


def sampling_times(case: Case, turn: float, end: float) -> np.ndarray:
    """Return the times (s) of a case's own sampling: k / samples of a `turn` (s), both ends of the stretch included."""
    save, revolutions = case.save, case.simulate.revolutions
    first = 0 if save.orbits == "all" else round((revolutions - save.revolutions) * save.samples)
    count = np.arange(first, math.floor(revolutions * save.samples + 1e-9) + 1)
    return np.minimum(count / save.samples * turn, end)


def work_counts(scene: Scene) -> dict[str, int]:
    """Return what integrating a slider-crank takes: steps, rejected ones, evaluations, those that locate events."""
    run = integrated(scene, np.empty(0), scene.case.simulate.revolutions * period(scene))
    counts = run.work.counts
    places = {
        "steps": events.STEPS,
        "steps_rejected": events.REJECTED,
        "rhs_evaluations": events.EVALUATIONS,
        "rhs_evaluations_locating": events.LOCATING,
    }
    return {name: int(counts[place]) for name, place in places.items()}
