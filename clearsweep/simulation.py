"""From a scene to its trajectory: buffers, one compiled call, the status in words."""

import math
import time

import numpy as np

from . import ideal, laws
from .errors import InputError
from .kernels import event as events
from .kernels import integrate as loop
from .kernels import method, stiff, wear
from .kernels import tally as tallies
from .kernels.family import NO_ENTRY, flatten
from .kernels.joint import FREE, PRESSED
from .kernels.motion import JOINT_WIDTH, JOINTS, rates_of, samples_of, slopes_of
from .kernels.record import Record
from .outcome import EVENT_DTYPE, Trajectory, channels, summary_columns
from .scene import Scene

#: Error that one step may make, per tolerance: of the coordinates in clearances, of their rates in clearances times
#: crank rate, of the root of penetration in roots of the clearance.  Errors of the coordinates turn the contact force a
#: little; those of the root of penetration are errors of its size, so they count most.  Chosen on the one-joint
#: reference trajectories: 15 to 20 % fewer evaluations at equal error than with 1, 1, 1 or a relative tolerance.
PLACE_WEIGHT, RATE_WEIGHT, ROOT_WEIGHT = 30.0, 3.0, 0.1
LONGEST = 0.02  # turns of the crank a step may span: keeps located maxima and histograms of slow motions sharp
ROUNDING = 1e-15  # of the mechanism's size and speed: no tolerance below it

_METHODS = {"auto": loop.AUTO, "explicit": events.EXPLICIT, "implicit": events.IMPLICIT}

_STATUS = {
    loop.OK: ("ok", ""),
    loop.STEP_BUDGET: (
        "step-budget",
        "took all {budget} steps it may, having got to {time:.6g} s of {end:.6g} s; simulate.step_budget allows more",
    ),
    loop.EVENT_BUDGET: (
        "event-budget",
        "met all {events} events it may, having got to {time:.6g} s of {end:.6g} s; simulate.event_budget allows more",
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


def simulate(scene: Scene, times=None) -> Trajectory:
    """Return the trajectory of a scene.

    Parameters
    ----------
    scene : what `load_case` or `scene.build` returned.
    times : (n,) s, increasing, within the run: where to report.  None: the case's own sampling.

    A failed integration is a Trajectory too: its `status` names the reason, `message` says it in a sentence.  Raises
    InputError for times outside the run.
    """
    pair = scene.layout.mechanism == "impact-pair"
    end = math.inf if pair else scene.case["simulate"]["revolutions"] * _period(scene)
    if times is not None:
        times = _checked_times(times, end)
    elif scene.case["save"]["orbits"] == "none":
        times = np.empty(0)
    elif pair:  # its duration is known afterwards
        last = _run(scene, np.empty(0), end)
        times = np.linspace(0.0, last.work.y[last.work.time], int(scene.case["save"]["samples"]) + 1)
    else:
        times = _own_times(scene, end)
    return _trajectory(scene, _run(scene, times, end), end)


def compile_for(case: dict) -> None:
    """Compile, or load from the cache, all code that a case needs, by running its first moment."""
    from .scene import build

    scene = build(case)
    end = 1e-3 / scene.value.pace
    times = np.empty(0) if case["save"]["orbits"] == "none" else np.array([0.0])
    _run(scene, times, end)


def _period(scene: Scene) -> float:
    return 2.0 * math.pi / scene.value.pace


def _checked_times(times, end: float) -> np.ndarray:
    times = np.ascontiguousarray(times, dtype=float)
    if times.ndim != 1 or not np.all(np.isfinite(times)) or np.any(np.diff(times) < 0.0):
        raise InputError("times: expected a one-dimensional array of increasing, finite times in s")
    if times.size and not (times[0] >= 0.0 and times[-1] <= end * (1.0 + 1e-12)):
        raise InputError(f"times: found {times[0]:.6g} s to {times[-1]:.6g} s; the run lasts from 0 to {end:.6g} s")
    return np.minimum(times, end)


def _own_times(scene: Scene, end: float) -> np.ndarray:
    """Return the times of the case's own sampling: k / samples of a turn, both ends of the stretch included."""
    samples, revolutions = scene.case["save"]["samples"], scene.case["simulate"]["revolutions"]
    first = (
        0
        if scene.case["save"]["orbits"] == "all"
        else round((revolutions - scene.case["save"]["revolutions"]) * samples)
    )
    count = np.arange(first, math.floor(revolutions * samples + 1e-9) + 1)
    return np.minimum(count / samples * _period(scene), end)


class _Run:
    """The buffers of one integration and what it came to."""

    def __init__(self, scene: Scene, times: np.ndarray, implicit: bool):
        value, joints = scene.value, scene.value.joints
        n, columns = scene.start.size, JOINTS + JOINT_WIDTH * len(joints)
        self.parameters = flatten(value)  # compiled code holds its address
        contact = PRESSED if scene.in_contact else FREE
        worn = any(part.wear_bins for part in scene.layout.joints)
        bins = max(part.wear_bins for part in scene.layout.joints)
        self.tally = tallies.Tally(
            whole=np.zeros(tallies.WHOLE),
            joint=np.zeros((len(joints), tallies.JOINT)),
            time=np.zeros((len(joints), tallies.BINS)),
            ramp=np.zeros((len(joints), tallies.BINS)),
            course=np.zeros((len(joints), 3, tallies.PARTS + 1)),
            length=np.zeros(1),
            wear=np.zeros(2 * len(joints) * bins),
            account=np.zeros((len(joints), wear.ACCOUNT)),
        )
        self.record = Record(times, np.zeros((times.size, len(channels(scene.layout)))))
        self.work = events.Work(
            rates=rates_of(value, self.parameters),
            slopes=slopes_of(value, self.parameters, implicit),
            sample=samples_of(value, self.parameters) if times.size else NO_ENTRY,
            wear=wear.wear_of(value, self.parameters) if worn else NO_ENTRY,
            time=2 * len(value.coordinates),
            pace=value.pace,
            sigma=value.sigma,
            longest=math.inf if scene.layout.mechanism == "impact-pair" else LONGEST * _period(scene),
            y=scene.start.copy(),
            end=np.empty(n),
            z=np.empty(n),
            k=np.zeros((method.ROWS, n)),
            o=np.zeros((method.ROWS, columns)),
            f=np.zeros((7, n)),
            scale=_scale(scene),
            state=np.full(len(joints), contact, dtype=np.int64),
            onset=np.full(len(joints), loop.ONSET_FLOOR),
            clearance=np.array([joint.clearance for joint in joints]),
            side=np.array([joint.side for joint in joints]),
            limit_depth=np.array([laws.penetration_limit(joint) for joint in scene.case["joints"].values()]),
            counts=np.zeros(events.COUNTS, dtype=np.int64),
            mode=np.zeros(3, dtype=np.int64),
            implicit=stiff.implicit_of(n),
            tally=self.tally,
            record=self.record,
        )
        self.status, self.events, self.duration = loop.OK, np.empty((0, 5)), 0.0


def _scale(scene: Scene) -> np.ndarray:
    """Return the error (n,) that one step may make in each component of the state."""
    value, tolerance = scene.value, scene.case["simulate"]["tolerance"]
    n = len(value.coordinates)
    clearance = min(joint.clearance for joint in value.joints)
    arm = np.ones(n)
    size = clearance
    if scene.layout.mechanism == "slider-crank":
        mechanism = scene.case["mechanism"]
        arm[0] = mechanism["rod"]["length"]  # the first coordinate is an angle
        size = mechanism["crank"]["length"] + mechanism["rod"]["length"]
    place = np.maximum(PLACE_WEIGHT * tolerance * clearance, ROUNDING * size) / arm
    rate = np.maximum(RATE_WEIGHT * tolerance * clearance, ROUNDING * size) * value.pace / arm
    moment = np.maximum(PLACE_WEIGHT * tolerance, ROUNDING) / value.pace
    root = np.full(len(value.joints), ROOT_WEIGHT * tolerance * math.sqrt(clearance))
    return np.concatenate([place, rate, [moment], root])


def _run(scene: Scene, times: np.ndarray, end: float) -> _Run:
    """Return the integration of a scene up to `end` (s), reported at `times` (s)."""
    settings = scene.case["simulate"]
    pair = scene.layout.mechanism == "impact-pair"
    window = 0.0 if pair else settings["discard"] * _period(scene)
    turns = settings["impacts"] if pair else max(settings["revolutions"], 1.0)
    control = loop.Control(
        window=window,
        end=end,
        separations=int(settings["impacts"]) if pair else 0,
        step_budget=int(settings["step_budget"] * turns),
        event_budget=int(settings["event_budget"] * turns),
        method=_METHODS[settings["method"]],
        keep_events=scene.case["save"]["orbits"] != "none" or times.size > 0,
    )
    run = _integrated(scene, times, control, control.method == events.IMPLICIT)
    return _integrated(scene, times, control, True) if run.status == loop.TURNS_STIFF else run


def _integrated(scene: Scene, times: np.ndarray, control: loop.Control, implicit: bool) -> _Run:
    """Return an integration from the start; `implicit`: what the implicit method needs is to be compiled before."""
    run = _Run(scene, times, implicit)
    if control.method == events.IMPLICIT:
        run.work.mode[:] = (events.IMPLICIT, 0, events.IMPLICIT)
    begin = time.perf_counter()
    run.status, run.events = loop.integrate(control, run.work)
    run.duration = time.perf_counter() - begin
    return run


def _trajectory(scene: Scene, run: _Run, end: float) -> Trajectory:
    """Return the trajectory that an integration came to."""
    reached = run.work.y[run.work.time] if run.status != loop.OK else end
    status, text = _STATUS[run.status]
    turns = scene.case["simulate"].get("revolutions", 1.0)
    message = text.format(time=reached, end=end, events=run.work.counts[events.EVENTS],
                          budget=int(scene.case["simulate"]["step_budget"] * max(turns, 1.0)))  # fmt: skip
    counts = run.work.counts
    summary = dict.fromkeys(column.name for column in summary_columns(scene.layout))
    if run.status == loop.OK:
        summary.update(_figures(scene, run, end))
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


def _events(scene: Scene, run: _Run) -> np.ndarray:
    """Return the event log as a structured array."""
    events = np.empty(len(run.events), EVENT_DTYPE)
    names = np.array([part.name for part in scene.layout.joints])
    events["t"], events["rate"], events["force_peak"] = run.events[:, 0], run.events[:, 3], run.events[:, 4]
    events["joint"] = names[run.events[:, 1].astype(int)]
    events["kind"] = np.where(run.events[:, 2] == loop.ONSET, "on", "off")
    return events


def _wear(scene: Scene, run: _Run) -> dict:
    """Return the wear depths of bearing and journal, m, by joint."""
    depths = run.tally.wear.reshape(len(scene.layout.joints), 2, -1)
    return {
        part.name: (depths[place, 0, : part.wear_bins].copy(), depths[place, 1, : part.wear_bins].copy())
        for place, part in enumerate(scene.layout.joints)
        if part.wear_bins
    }


def _figures(scene: Scene, run: _Run, end: float) -> dict:
    """Return the figures of merit of an integration that went through."""
    pair = scene.layout.mechanism == "impact-pair"
    whole, settings = run.tally.whole, scene.case["simulate"]
    duration = run.work.y[run.work.time] if pair else end - settings["discard"] * _period(scene)
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


def _wear_figures(scene: Scene, run: _Run, place: int, duration: float) -> dict:
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
