"""From a scene to its trajectory: buffers, one compiled call, the status in words."""

import dataclasses
import math
import time

import numpy as np

from . import ideal, instants, laws, span
from .kernels import event as events
from .kernels import integrate as loop
from .kernels import method, stiff, wear
from .kernels import tally as tallies
from .kernels.family import NO_ENTRY, flatten
from .kernels.joint import FREE, PRESSED, width
from .kernels.motion import JOINT_WIDTH, JOINTS, rates_of, samples_of, slopes_of
from .kernels.normal import Plastic
from .kernels.record import Record
from .outcome import EVENT_DTYPE, Trajectory, channels, differ, summary_columns
from .remarks import past_limits
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
    end = math.inf if pair else scene.case["simulate"]["revolutions"] * _period(scene)
    if times is not None:
        times = instants.checked(times, end)
    elif scene.case["save"]["orbits"] == "none":
        times = np.empty(0)
    elif pair:  # its duration is known afterwards
        last = _run(scene, np.empty(0), end)
        times = np.linspace(0.0, last.work.y[last.work.time], int(scene.case["save"]["samples"]) + 1)
    else:
        times = instants.own(scene.case, _period(scene), end)
    return _trajectory(scene, _run(scene, times, end, watchers), end)


def _settle(scene: Scene, times, watchers) -> Trajectory:
    """Return the trajectory of a scene that is to run until a figure has settled.

    What is reported comes from a second run over that stretch, the same to the last bit, as its times were not known.
    """
    settings, turn, orbits = scene.case["simulate"], _period(scene), scene.case["save"]["orbits"]
    whole = _changed(scene, revolutions=span.longest(settings))
    end = whole.case["simulate"]["revolutions"] * turn
    run = _Run(scene, span.marks(settings, turn))
    watch = span.Until(scene, run.record.samples)
    _integrate(whole, run, end, orbits != "none" or times is not None, (watch, *watchers))
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


def _retrace(scene: Scene, run: "_Run", times: np.ndarray, end: float, starts) -> None:
    """Record the motion of a run at `times`, from the last of its `starts` before them or from the beginning."""
    again = _Run(scene, times)
    before = [start for start in starts if times.size and start["y"][run.work.time] <= times[0]]
    if before:
        span.go_to(before[-1], again.work)
    _call(again, _control(scene, end, keep_events=False))
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
    """Compile, or load from the cache, all code that a case needs, by running its first moment."""
    from .scene import build

    scene = build(case)
    end = 1e-3 / scene.value.pace
    bare = case["save"]["orbits"] == "none" and not scene.layout.until
    _run(scene, np.empty(0) if bare else np.array([0.0]), end)


def work_counts(scene: Scene) -> dict[str, int]:
    """Return what integrating a slider-crank takes: steps, rejected ones, evaluations, those that locate events."""
    counts = _run(scene, np.empty(0), scene.case["simulate"]["revolutions"] * _period(scene)).work.counts
    places = {"steps": events.STEPS, "steps_rejected": events.REJECTED, "rhs_evaluations": events.EVALUATIONS,
              "rhs_evaluations_locating": events.LOCATING}  # fmt: skip
    return {name: int(counts[place]) for name, place in places.items()}


def _period(scene: Scene) -> float:
    return 2.0 * math.pi / scene.value.pace


class _Run:
    """The buffers of one integration and what it came to."""

    def __init__(self, scene: Scene, times: np.ndarray):
        value, joints = scene.value, scene.value.joints
        self.value = value
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
            band=np.array([getattr(joint.friction, "band", 0.0) for joint in joints]),
            deepest=_places(value, Plastic),
            owner=np.repeat(np.arange(len(joints)), [width(joint) for joint in joints]),
            limit_depth=np.array([laws.penetration_limit(joint) for joint in scene.case["joints"].values()]),
            counts=np.zeros(events.COUNTS, dtype=np.int64),
            mode=np.zeros(3, dtype=np.int64),
            proposals=np.zeros(2 << len(joints)),
            ahead=np.zeros(3),
            slopes=np.zeros(2, dtype=np.int64),
            implicit=stiff.implicit_of(n),
            tally=self.tally,
            record=self.record,
        )
        self.status, self.events, self.duration = loop.OK, np.empty((0, 5)), 0.0
        self.counts = self.work.counts.copy()  # what all of it took, runs beside this one included
        self.found = {}  # figures that were found on the way

    def go(self, control: loop.Control) -> tuple[int, np.ndarray]:
        """Return the status and the events of an integration from where this one stands to where `control` ends it.

        What only a stiff motion needs is compiled when the motion turns out to be one.
        """
        began = time.perf_counter()
        status, log = loop.integrate(control, self.work)
        self.duration += time.perf_counter() - began
        if status != loop.TURNS_STIFF:
            return status, log
        self.work.slopes[:] = slopes_of(self.value, self.parameters)
        status, more = self.go(control)
        return status, np.concatenate([log, more])

    def spent(self, other: "_Run") -> None:
        """Add what a run beside this one took."""
        self.counts += other.counts
        self.duration += other.duration


def _arm(scene: Scene) -> np.ndarray:
    """Return what makes a place (m) of each coordinate."""
    arm = np.ones(len(scene.value.coordinates))
    if scene.layout.mechanism == "slider-crank":
        arm[0] = scene.case["mechanism"]["rod"]["length"]  # the first coordinate is an angle
    return arm


def _unit(scene: Scene) -> np.ndarray:
    """Return a clearance as change of each coordinate, and a clearance times crank rate of each rate."""
    unit = min(joint.clearance for joint in scene.value.joints) / _arm(scene)
    return np.concatenate([unit, unit * scene.value.pace])


def _places(value, law) -> np.ndarray:
    """Return where in the state of a scene the memory of each joint's normal law begins, 0 where it is no `law`."""
    first = 2 * len(value.coordinates) + 1 + len(value.joints)
    places = first + np.cumsum([0] + [width(joint) for joint in value.joints[:-1]])
    return places * [isinstance(joint.law, law) for joint in value.joints]


def _scale(scene: Scene) -> np.ndarray:
    """Return the error (n,) that one step may make in each component of the state."""
    value, tolerance = scene.value, scene.case["simulate"]["tolerance"]
    clearance, arm = min(joint.clearance for joint in value.joints), _arm(scene)
    size = clearance
    if scene.layout.mechanism == "slider-crank":
        mechanism = scene.case["mechanism"]
        size = mechanism["crank"]["length"] + mechanism["rod"]["length"]
    place = np.maximum(PLACE_WEIGHT * tolerance * clearance, ROUNDING * size) / arm
    rate = np.maximum(RATE_WEIGHT * tolerance * clearance, ROUNDING * size) * value.pace / arm
    moment = np.maximum(PLACE_WEIGHT * tolerance, ROUNDING) / value.pace
    root = np.full(len(value.joints), ROOT_WEIGHT * tolerance * math.sqrt(clearance))
    return np.concatenate([place, rate, [moment], root, tolerance * np.array(value.memories)])


def _run(scene: Scene, times: np.ndarray, end: float, watchers=()) -> _Run:
    """Return the integration of a scene up to `end` (s), reported at `times` (s)."""
    run = _Run(scene, times)
    _integrate(scene, run, end, scene.case["save"]["orbits"] != "none" or times.size > 0, watchers)
    return run


def _integrate(scene: Scene, run: _Run, end: float, keep_events: bool, watchers=()) -> None:
    """Integrate a scene up to `end` (s), in the eyes of `watchers`, see `span`."""
    control = _control(scene, end, keep_events)
    if not scene.layout.horizon:
        _call(run, control, scene, watchers)
        return
    twin = _Run(scene, np.empty(0))
    watch = span.Twin(control, twin, _unit(scene), scene.case["simulate"]["tolerance"])
    _call(run, control, scene, (*watchers, watch))
    run.found = watch.figures(_period(scene))
    twin.counts += twin.work.counts
    run.spent(twin)


def _control(scene: Scene, end: float, keep_events: bool) -> loop.Control:
    """Return how to integrate a scene up to `end` (s)."""
    settings = scene.case["simulate"]
    pair = scene.layout.mechanism == "impact-pair"
    window = 0.0 if pair else settings["discard"] * _period(scene)
    turns = settings["impacts"] if pair else max(settings["revolutions"], 1.0)
    return loop.Control(
        window=window,
        end=end,
        separations=int(settings["impacts"]) if pair else 0,
        step_budget=int(settings["step_budget"] * turns),
        event_budget=int(settings["event_budget"] * turns),
        method=_METHODS[settings["method"]],
        keep_events=keep_events,
    )


def _call(run: _Run, control: loop.Control, scene: Scene | None = None, watchers=()) -> None:
    """Integrate, at one go unless somebody watches."""
    if control.method == events.IMPLICIT and run.work.ahead[0] == 0.0:
        run.work.mode[:] = (events.IMPLICIT, 0, events.IMPLICIT)
    if watchers:
        discard, turn = scene.case["simulate"]["discard"], _period(scene)
        run.status, run.events = span.drive(control, run, discard, turn, watchers)
    else:
        run.status, run.events = run.go(control)
    run.counts += run.work.counts


def _trajectory(scene: Scene, run: _Run, end: float) -> Trajectory:
    """Return the trajectory that an integration came to."""
    reached = run.work.y[run.work.time] if run.status != loop.OK else end
    status, text = _STATUS[run.status]
    turns = scene.case["simulate"].get("revolutions", 1.0)
    message = text.format(time=reached, end=end, events=run.work.counts[events.EVENTS],
                          budget=int(scene.case["simulate"]["step_budget"] * max(turns, 1.0)))  # fmt: skip
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
