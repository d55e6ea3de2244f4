"""From a scene to its trajectory: one integration or more, the figures they come to, the status in words."""

import dataclasses
import math

import numpy as np

from . import ideal, instants, laws, span
from .integration import Run, call, control_of, integrate, integrated, period
from .kernels import event as events
from .kernels import integrate as loop
from .kernels import tally as tallies
from .kernels.record import Record
from .outcome import EVENT_DTYPE, Trajectory, channels, differ, summary_columns
from .remarks import past_limits
from .scene import Scene

_STATUS = {
    loop.OK: ("ok", ""),
    loop.STEP_BUDGET: (
        "step-budget",
        "took all {budget} steps it may, having got to {time:.6g} s{whole}; simulate.step_budget allows more",
    ),
    loop.EVENT_BUDGET: (
        "event-budget",
        "met all {events} events it may, having got to {time:.6g} s{whole}; simulate.event_budget allows more",
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


def simulate(scene: Scene, times=None, watchers=()) -> Trajectory:
    """Return the trajectory of a scene.

    Parameters
    ----------
    scene : what `load_case` or `scene.build` returned.
    times : (n,) s, increasing, within the run: where to report.  None: the case's own sampling.
    watchers : what looks at the run on its way, see `span.drive`.

    A failed integration is a Trajectory too: its `status` names the reason, `message` says it in a sentence.  Raises
    InputError for times outside the run.
    """
    found = _settle(scene, times, watchers) if scene.layout.until else _simulate(scene, times, watchers)
    if scene.layout.error_check:
        _check_error(scene, found)
    return found


def _simulate(scene: Scene, times, watchers=()) -> Trajectory:
    """Return the trajectory of a scene whose length is given."""
    pair = scene.layout.mechanism == "impact-pair"
    end = math.inf if pair else scene.case["simulate"]["revolutions"] * period(scene)
    if times is not None:
        times = instants.checked(times, end)
    elif scene.case["save"]["orbits"] == "none":
        times = np.empty(0)
    elif pair:  # its duration is known afterwards
        last = integrated(scene, np.empty(0), end)
        times = np.linspace(0.0, last.work.y[last.work.time], int(scene.case["save"]["samples"]) + 1)
    else:
        times = instants.own(scene.case, period(scene), end)
    return _trajectory(scene, integrated(scene, times, end, watchers), end)


def _settle(scene: Scene, times, watchers) -> Trajectory:
    """Return the trajectory of a scene that is to run until a figure has settled.

    What is reported comes from a second run over that stretch, the same to the last bit, as its times were not known.
    """
    settings, turn, orbits = scene.case["simulate"], period(scene), scene.case["save"]["orbits"]
    whole = _changed(scene, revolutions=span.longest(settings))
    end = whole.case["simulate"]["revolutions"] * turn
    run = Run(scene, span.marks(settings, turn))
    watch = span.Until(scene, run.record.samples)
    integrate(whole, run, end, orbits != "none" or times is not None, (watch, *watchers))
    run.record = Record(np.empty(0), np.empty(0))
    if run.status != loop.OK:
        return _trajectory(whole, run, end)
    settled = _changed(scene, revolutions=watch.revolutions)
    end = watch.revolutions * turn
    if times is not None or orbits != "none":
        times = instants.own(settled.case, turn, end) if times is None else instants.checked(times, end)
        _retrace(settled, run, times, end, watch.starts)
    found = _trajectory(settled, run, end)
    found.summary.update(watch.figures())
    return found


def _retrace(scene: Scene, run: "Run", times: np.ndarray, end: float, starts) -> None:
    """Record the motion of a run at `times`, from the last of its `starts` before them or from the beginning."""
    again = Run(scene, times)
    before = [start for start in starts if times.size and start["y"][run.work.time] <= times[0]]
    if before:
        span.go_to(before[-1], again.work)
    call(again, control_of(scene, end, keep_events=False))
    run.record = again.record
    run.spent(again)


def _changed(scene: Scene, **settings) -> Scene:
    """Return a scene with other values in `simulate`."""
    return dataclasses.replace(scene, case=scene.case | {"simulate": scene.case["simulate"] | settings})


def _check_error(scene: Scene, found: Trajectory) -> None:
    """Enter into the summary how far every figure differs from that of a run at a tenth of the tolerance."""
    if found.status != "ok":
        return
    tighter = {"tolerance": 0.1 * scene.case["simulate"]["tolerance"]}
    if scene.layout.until:
        tighter["revolutions"] = found.summary["revolutions_run"]
    made = dataclasses.replace(_changed(scene, **tighter), layout=scene.layout._replace(error_check=False, until=""))
    differ(found.summary, _simulate(made, np.empty(0)).summary)


def compile_for(case: dict) -> None:
    """Compile, or load from the cache, the code of a case by running its first moment; stiff motion may take more."""
    from .scene import build

    scene = build(case)
    end = 1e-3 / scene.value.pace
    bare = case["save"]["orbits"] == "none" and not scene.layout.until
    integrated(scene, np.empty(0) if bare else np.array([0.0]), end)


def work_counts(scene: Scene) -> dict[str, int]:
    """Return what integrating a slider-crank takes: steps, rejected ones, evaluations, those that locate events."""
    counts = integrated(scene, np.empty(0), scene.case["simulate"]["revolutions"] * period(scene)).work.counts
    places = {"steps": events.STEPS, "steps_rejected": events.REJECTED, "rhs_evaluations": events.EVALUATIONS,
              "rhs_evaluations_locating": events.LOCATING}  # fmt: skip
    return {name: int(counts[place]) for name, place in places.items()}


def _trajectory(scene: Scene, run: Run, end: float) -> Trajectory:
    """Return the trajectory that an integration came to."""
    reached = run.work.y[run.work.time] if run.status != loop.OK else end
    status, text = _STATUS[run.status]
    whole = f" of {end:.6g} s" if math.isfinite(end) else ""
    message = text.format(time=reached, whole=whole, events=run.work.counts[events.EVENTS],
                          budget=control_of(scene, end, False).step_budget)  # fmt: skip
    counts = run.counts
    summary = dict.fromkeys(column.name for column in summary_columns(scene.layout))
    if run.status == loop.OK:
        summary.update(_figures(scene, run, end) | run.found)
        message = past_limits(
            (name, joint["contact"].get("elastic", ""), laws.penetration_limit(joint),
             summary[f"{part.name}_law_limit_fraction"])
            for part, (name, joint) in zip(scene.layout.joints, scene.case["joints"].items(), strict=True)
        )  # fmt: skip
    summary.update(
        steps=int(counts[events.STEPS]),
        steps_rejected=int(counts[events.REJECTED]),
        rhs_evaluations=int(counts[events.EVALUATIONS]),
        run_time=run.duration,
    )
    if run.status != loop.OK:
        return Trajectory(status, message, summary)
    names = [channel.name for channel in channels(scene.layout)]
    histories = (
        dict(zip(names, np.ascontiguousarray(run.record.samples.T), strict=True)) if run.record.times.size else {}
    )
    return Trajectory(status, message, summary, histories, _events(scene, run), _wear(scene, run))


def _events(scene: Scene, run: Run) -> np.ndarray:
    """Return the event log as a structured array."""
    events = np.empty(len(run.events), EVENT_DTYPE)
    names = np.array([part.name for part in scene.layout.joints])
    events["t"], events["rate"], events["force_peak"] = run.events[:, 0], run.events[:, 3], run.events[:, 4]
    events["joint"] = names[run.events[:, 1].astype(int)]
    events["kind"] = np.where(run.events[:, 2] == loop.ONSET, "on", "off")
    return events


def _wear(scene: Scene, run: Run) -> dict:
    """Return the wear depths of bearing and journal, m, by joint."""
    depths = run.tally.wear.reshape(len(scene.layout.joints), 2, -1)
    return {
        part.name: (depths[place, 0, : part.wear_bins].copy(), depths[place, 1, : part.wear_bins].copy())
        for place, part in enumerate(scene.layout.joints)
        if part.wear_bins
    }


def _figures(scene: Scene, run: Run, end: float) -> dict:
    """Return the figures of merit of an integration that went through."""
    pair = scene.layout.mechanism == "impact-pair"
    whole, settings = run.tally.whole, scene.case["simulate"]
    duration = run.work.y[run.work.time] if pair else end - settings["discard"] * period(scene)
    turns = 1.0 if pair else settings["revolutions"] - settings["discard"]
    figures = {"energy_residual": float(whole[tallies.RESIDUAL] / whole[tallies.KINETIC_MAX])}
    for place, (part, joint) in enumerate(zip(scene.layout.joints, scene.value.joints, strict=True)):
        row = run.tally.joint[place]
        depth = float(max(row[tallies.DEPTH_MAX], -joint.clearance))
        p99 = tallies.force_exceeded(run.tally.time[place], run.tally.ramp[place], 0.01 * duration)
        found = {
            "force_peak": row[tallies.FORCE_MAX],
            "force_rms": math.sqrt(row[tallies.FORCE_SQUARE] / duration),
            "force_p99": p99,
            "impacts_per_rev": row[tallies.ONSETS] / turns,
            "contact_fraction": row[tallies.CONTACT_TIME] / duration,
            "onset_rate_max": row[tallies.ONSET_MAX],
            "penetration_max": max(depth, 0.0),
            "eccentricity_max": joint.clearance + depth,
            "force_clips": row[tallies.CLIPS],
            "law_limit_fraction": row[tallies.BEYOND_TIME] / duration,
        }
        if part.wear_bins:
            found |= _wear_figures(scene, run, place, duration)
        figures |= {f"{part.name}_{name}": float(value) for name, value in found.items()}
    if pair:
        joint = run.tally.joint[0]
        counted = joint[tallies.REBOUNDS]
        figures["pair_restitution"] = float(joint[tallies.RESTITUTION] / counted) if counted else None
        return figures
    for name, value in ideal.largest_reactions(scene.case["mechanism"], scene.value.pace).items():
        if f"{name}_force_peak" in figures:
            figures[f"{name}_force_peak_ideal"] = value
    figures["slider_acceleration_peak"] = float(whole[tallies.ACCELERATION_MAX])
    figures["slider_acceleration_rms"] = math.sqrt(whole[tallies.ACCELERATION_SQUARE] / duration)
    figures["slider_error_max"] = float(whole[tallies.ERROR_MAX])
    figures["crank_torque_peak"] = float(whole[tallies.TORQUE_MAX])
    return figures


def _wear_figures(scene: Scene, run: Run, place: int, duration: float) -> dict:
    """Return the figures of one joint's wear."""
    part, joint = scene.layout.joints[place], scene.value.joints[place]
    bearing, journal = _wear(scene, run)[part.name]
    deepest = max(bearing.max(), journal.max())
    cell = 2.0 * math.pi / part.wear_bins * joint.wear.length
    arcs, narrow = run.tally.account[place]
    return {
        "wear_depth_max": deepest,
        "wear_rate_max": deepest / duration,
        "wear_volume": cell * (joint.bearing_radius * bearing.sum() + joint.journal_radius * journal.sum()),
        "wear_narrow_arcs": narrow / arcs if arcs else 0.0,
    }
