"""From a scene to its trajectory: one integration or more, the figures they come to, the status in words."""

import dataclasses
import math
import time
from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..case import Case
from ..errors import InputError
from ..grid import check_memory, history_bytes
from ..layout import DIFFERENCE, SECTION_COUNT, Layout
from ..mechanics.compiled.announce import announced
from ..mechanics.compiled.family import empty_entries
from ..mechanics.observe.record import Record, sample_states
from ..mechanics.observe.tally import OPENED
from ..mechanics.solver import event as events
from ..mechanics.solver import loop
from ..results import EVENT_DTYPE, Trajectory
from ..validity import UNBALANCED, UNCHECKED, message_of
from .figures import COST, figures_of
from .heat import Balance, balanced, has_balance
from .remarks import remarks
from .revolutions import begun, marks_of, period_in, spreads_of
from .run import TIME_BUDGET, Run, call, control_of, integrate, integrated, onset_rates, unit_of
from .scene import Scene, build
from .telling import Telling
from .until import Until, longest, marks
from .watch import Moment, Watcher, go_to
from .window import Window, by_joint, wear_of

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
    loop.TIME_LIMIT: (
        "time-limit",
        "took {time:.6g} s of motion{whole}, as long as it may; simulate.time_limit allows more",
    ),
    loop.STALLED: (
        "stalled",
        "the drive stalls: at {time:.6g} s, after {turned:.4g}{whole}, the crank does not get through; more torque, a "
        "flywheel or a larger initial speed help, or smaller loads",
    ),
}


def simulate(
    scene: Scene, times: ArrayLike | None = None, watchers: Sequence[Watcher] = (), *, progress: bool = False
) -> Trajectory:
    """Return the trajectory of a scene.

    Parameters
    ----------
    scene : what `load_case` or `scene.build` returned.
    times : (n,) s, increasing, within the run: where to report.  None: the case's own sampling.
    watchers : what looks at the run on its way, see `watch.drive`.
    progress : whether to tell stderr now and then how far a long run is; no bit of the result depends on it.

    A failed integration is a Trajectory too: its `status` names the reason, `message` says it in a sentence.  Raises
    InputError for times outside the run.
    """
    scene = dataclasses.replace(scene, deadline=time.process_time() + scene.case.simulate.time_budget)
    balance = None
    if has_balance(scene.case):
        scene, balance = balanced(scene)
    if progress and scene.mechanism.turns:
        settings = scene.case.simulate
        most = longest(settings) if scene.layout.until else settings.revolutions
        watchers = (*watchers, Telling(settings.discard, most))
    trajectory = _settle(scene, times, watchers) if scene.layout.until else _simulate(scene, times, watchers)
    if balance:
        trajectory = _with_balance(trajectory, balance)
    if scene.layout.error_check:
        trajectory = _error_checked(scene, trajectory)
    trajectory.summary.update(scene.verdict.of_case(trajectory.summary, failed=trajectory.status != "ok"))
    return trajectory


def _with_balance(trajectory: Trajectory, balance: Balance) -> Trajectory:
    """Return a trajectory that tells how far the temperatures of its films are known."""
    for joint, width in balance.width.items():
        trajectory.summary[f"{joint}_film_temperature_ci"] = width if math.isfinite(width) else None
    if balance.stands or trajectory.status != "ok":
        return trajectory
    return dataclasses.replace(trajectory, message=message_of(trajectory.message, UNBALANCED))


def _simulate(scene: Scene, times: ArrayLike | None, watchers: Sequence[Watcher] = ()) -> Trajectory:
    """Return the trajectory of a scene whose length is given."""
    turning = scene.mechanism.turns
    end = scene.turning.at(scene.case.simulate.revolutions) if turning else math.inf
    if math.isinf(end) and turning:
        raise InputError(
            f"drive.speed.table: the crank comes to rest before {scene.case.simulate.revolutions:.6g} revolutions; let "
            "it go on, or write fewer simulate.revolutions"
        )
    turned = scene.turning.free and times is None
    if times is not None:
        reported = checked_times(times, math.inf if scene.turning.free else end)
    elif scene.case.save.orbits == "none":
        reported = np.empty(0)
    elif not turning:  # its duration is known afterwards
        last = integrated(scene, np.empty(0), end)
        reported = np.linspace(0.0, last.work.end[last.work.time], scene.case.save.samples + 1)
    else:
        check_memory(history_bytes(scene.layout, scene.case.save, scene.case.simulate.revolutions))
        reported = sampling_times(scene.case, scene.turning.at)
    marked = marks_of(scene, scene.case.simulate.revolutions)
    run = integrated(scene, reported, end, watchers, turned=turned, marks=marked)
    if scene.turning.free and times is not None and run.status == loop.OK:
        finish_samples(scene, run)
    return _trajectory(scene, run, end)


def finish_samples(scene: Scene, run: Run) -> None:
    """Report the end of a free crank's run at the times that are asked for there, which was not known before.

    Raises InputError for times beyond it.
    """
    last, times = float(run.work.end[run.work.time]), run.record.times
    if times.size and times[-1] > last * (1.0 + 1e-9):
        raise InputError(f"times: found {times[-1]:.6g} s; the run lasts from 0 to {last:.6g} s")
    times[:] = np.minimum(times, last)
    run.work.y[:] = run.work.end
    run.work.ahead[0] = 0.0
    loop.integrate(control_of(scene, math.inf, keep_events=False)._replace(window=math.inf, step_budget=0), run.work)


def _settle(scene: Scene, times: ArrayLike | None, watchers: Sequence[Watcher]) -> Trajectory:
    """Return the trajectory of a scene that is to run until a figure has settled.

    What is reported comes from a second run over that stretch, the same to the last bit, as its times were not known.
    """
    settings, at, orbits = scene.case.simulate, scene.turning.at, scene.case.save.orbits
    whole = _changed(scene, revolutions=longest(settings))
    end = at(whole.case.simulate.revolutions)
    run = Run(scene, marks(settings, at), turned=True, marks=marks_of(scene, longest(settings)))
    watch = Until(scene, run.record.samples)
    keep_events = orbits != "none" or times is not None
    integrate(whole, run, end, keep_events=keep_events, watchers=(watch, *watchers))
    run.record = Record(np.empty(0), np.empty(0), run.record.along)
    if run.status != loop.OK:
        return _trajectory(whole, run, end)
    settled = _changed(scene, revolutions=watch.revolutions)
    end = at(watch.revolutions)
    if times is not None or orbits != "none":
        check_memory(0.0 if times is not None else history_bytes(scene.layout, scene.case.save, watch.revolutions))
        last = math.inf if scene.turning.free else end
        again = Run(
            scene,
            sampling_times(settled.case, at) if times is None else checked_times(times, last),
            turned=times is None,
        )
        _retrace(settled, run, again, end, watch.starts)
    trajectory = _trajectory(settled, run, end)
    trajectory.summary.update(watch.figures())
    return trajectory


def _retrace(scene: Scene, run: Run, again: Run, end: float, starts: Iterable[Moment]) -> None:
    """Record the motion of a run in `again`, from the last of its `starts` before or from the beginning."""
    times, along = again.record.times, again.record.along
    before = [start for start in starts if times.size and start["y"][along] <= times[0]]
    if before:
        go_to(before[-1], again.work)
    call(again, control_of(scene, end, keep_events=False), scene)
    if scene.turning.free and along == again.work.time and again.status == loop.OK:
        finish_samples(scene, again)
    run.status, run.record = again.status, again.record
    run.spent(again)


def _changed(scene: Scene, **settings: Any) -> Scene:
    """Return a scene with other values in `simulate`."""
    simulate = scene.case.simulate._replace(**settings)
    return dataclasses.replace(scene, case=scene.case._replace(simulate=simulate))


def _error_checked(scene: Scene, trajectory: Trajectory) -> Trajectory:
    """Return a trajectory with the difference of every figure from a run at a tenth of the tolerance in its summary."""
    if trajectory.status != "ok":
        return trajectory
    tighter = {"tolerance": 0.1 * scene.case.simulate.tolerance}
    if scene.layout.until:
        tighter["revolutions"] = trajectory.summary["revolutions_run"]
    other = _simulate(_changed(scene, **tighter), np.empty(0))
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
    """Compile the code of a case's own scene, or load it from the cache; stiff motion may take more."""
    scene = build(case)
    bare = case.save.orbits == "none" and not scene.layout.until
    with announced():
        Run(scene, np.empty(0) if bare else np.array([0.0]))


def compile_loop(case: Case) -> None:
    """Compile the integration loop, which is the same for all cases, or load it from the cache."""
    scene = build(case)
    with empty_entries():
        run = Run(scene, np.empty(0))
    with announced():
        loop.compile_for(control_of(scene, scene.turning.at(1.0), keep_events=True), run.work)


def _trajectory(scene: Scene, run: Run, end: float) -> Trajectory:
    """Return the trajectory that an integration came to."""
    status, text = _STATUS[run.status]
    whole = f" of {end:.6g} s" if math.isfinite(end) else ""
    if scene.turning.free:
        whole = f" of {scene.case.simulate.revolutions:.6g} revolutions"
    message = text.format(
        time=run.work.y[run.work.time],
        turned=(run.work.y[run.work.along] - scene.turning.at(0.0)) / (2.0 * math.pi),
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
        return Trajectory(status, message, summary, units=scene.layout.units)
    summary |= run.figures
    message = message_of(*remarks(scene, run, window, summary))
    names = [channel.name for channel in scene.layout.channels]
    histories = (
        dict(zip(names, np.ascontiguousarray(run.record.samples.T), strict=True)) if run.record.times.size else {}
    )
    logged = _events_of(scene.layout, run.events)
    sections, units = sections_of(scene, run), scene.layout.units
    return Trajectory(status, message, summary, histories, logged, window.wear, sections, units)


def sections_of(scene: Scene, run: Run) -> dict[str, np.ndarray]:
    """Return the journals' places and rates at crank angle 0 of every revolution, by channel; {} if not asked for."""
    turns: Any = run.work.turns  # mypy takes it for a tuple of anything
    sections = run.marks.sections[run.marks.sections < turns.passed[0]]
    if not len(run.marks.sections) or not run.work.sample.code:
        return {}
    channels = scene.layout.channels
    values = np.zeros((len(sections), len(channels)))
    sample_states(run.work, turns.states[sections], values)
    found = {channel.name: values[:, place].copy() for place, channel in enumerate(channels)}
    counted = np.round(run.marks.turns[sections] + begun(scene)).astype("i8")
    return {SECTION_COUNT: counted} | {section: found[name] for name, section in scene.layout.sections}


def _events_of(layout: Layout, log: np.ndarray) -> np.ndarray:
    """Return the event log of a run, (events, 5), as a structured array."""
    found = np.empty(len(log), EVENT_DTYPE)
    names = np.array(layout.contacts)
    found["t"], found["rate"], found["force_peak"] = log[:, 0], log[:, 3], log[:, 4]
    found["joint"] = names[log[:, 1].astype(int)]
    found["kind"] = np.where(log[:, 2] == loop.ONSET, "on", "off")
    return found


def window_of(scene: Scene, run: Run, end: float) -> Window:
    """Return what an integration up to `end` (s) came to."""
    settings, turning = scene.case.simulate, scene.mechanism.turns
    tally = by_joint(run.tally, scene.layout)
    return Window(
        case=scene.case,
        mechanism=scene.mechanism,
        layout=scene.layout,
        joints=scene.value.joints,
        tally=tally,
        wear=wear_of(scene.layout, tally),
        counts=run.counts,
        seconds=run.duration,
        duration=_duration(scene, run, end),
        turns=settings.revolutions - settings.discard if turning else 1.0,
        spreads=spreads_of(scene, run.marks, run.work.turns),
        period=period_in(scene, run.marks, run.work.turns, unit_of(scene)),
        onset=onset_rates(run),
    )


def _duration(scene: Scene, run: Run, end: float) -> float:
    """Return how long (s) the window of an integration up to `end` is."""
    if not scene.mechanism.turns:
        return float(run.work.end[run.work.time])
    if scene.turning.free:
        return float(run.work.end[run.work.time] - run.tally.whole[OPENED])
    return end - scene.turning.at(scene.case.simulate.discard)


def checked_times(times: ArrayLike, end: float) -> np.ndarray:
    """Return times (s) that a user asks for, as an array; raise InputError unless they lie within a run up to `end`."""
    array: np.ndarray = np.ascontiguousarray(times, dtype=float)
    if array.ndim != 1 or not np.all(np.isfinite(array)) or np.any(np.diff(array) < 0.0):
        raise InputError("times: expected a one-dimensional array of increasing, finite times in s")
    if array.size and not (array[0] >= 0.0 and array[-1] <= end * (1.0 + 1e-12)):
        raise InputError(f"times: found {array[0]:.6g} s to {array[-1]:.6g} s; the run lasts from 0 to {end:.6g} s")
    within: np.ndarray = np.minimum(array, end)
    return within


def sampling_times(case: Case, at: Callable[[float], float]) -> np.ndarray:
    """Return where a case is sampled: at k / samples of a revolution, both ends of the stretch included."""
    save, revolutions = case.save, case.simulate.revolutions
    first = 0 if save.orbits == "all" else round((revolutions - save.revolutions) * save.samples)
    count = np.arange(first, math.floor(revolutions * save.samples + 1e-9) + 1)
    return np.minimum([at(turns) for turns in count / save.samples], at(revolutions))


def work_counts(scene: Scene) -> dict[str, int]:
    """Return what integrating a slider-crank takes: steps, rejected ones, evaluations, those that locate events."""
    counts = integrated(scene, np.empty(0), scene.turning.at(scene.case.simulate.revolutions)).work.counts
    places = {
        "steps": events.STEPS,
        "steps_rejected": events.REJECTED,
        "rhs_evaluations": events.EVALUATIONS,
        "rhs_evaluations_locating": events.LOCATING,
    }
    return {name: int(counts[place]) for name, place in places.items()}
