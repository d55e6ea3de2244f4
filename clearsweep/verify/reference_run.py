"""The reference motion of a case, and the error and the time of other methods.

The reference is the case at REFERENCE_TOLERANCES; its own error is its largest distance from two further
runs, whose rounding differs.  A run is compared over half a revolution, or over the predictable horizon of the run at
the grid's tolerance if this is shorter.  Beyond it two integrations of a chaotic motion are two samples of it.
"""

import copy
import math
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from .. import grid
from ..contracts.case import column_name
from ..contracts.results import Trajectory
from ..grid.cases import put_values
from ..language.errors import InputError
from ..simulation.analyses.trajectory import simulate
from ..simulation.running.observed_run import HORIZON_SIZE
from ..simulation.setup import scene
from .rivals import sampled, scipy_ivp

# ----------------------------------------------------------------------------------------------------------------------
# A case in the form of a grid file, in SI, reduced to its motion and changed by dotted path.


Tree = dict[str, Any]  # a case in the form of a grid file, in SI


def base_tree(written: Mapping[str, Any], **settings: Any) -> Tree:
    """Return a case reduced to its motion: one revolution from the start, no history, with some `simulate` settings."""
    tree: Tree = copy.deepcopy(plain(written))
    for name in ("life", "uncertain", "define", "vibration"):
        tree.pop(name, None)
    simulation = tree["simulate"]
    chain = ("start", "carried_axis", "direction") if simulation.get("start") == "carried" else ()
    for name in ("until", "horizon", "error_check", "discard", "time_budget", *chain):  # a chain's case begins centred
        simulation.pop(name, None)
    if "revolutions" in simulation:
        simulation |= {"revolutions": 1.0, "discard": 0.0}
    tree["save"] = {"orbits": "none"}
    simulation |= settings
    return tree


def plain(value: Any) -> Any:
    """Return nested sections as plain dicts and lists."""
    if isinstance(value, Mapping):
        return {key: plain(item) for key, item in value.items()}
    return [plain(item) for item in value] if isinstance(value, list | tuple) else value


def scene_of(tree: Tree) -> scene.Scene:
    """Return the Scene of a case in the form of a grid file.  Raises InputError."""
    return scene.build(grid.load(tree, scene.catalogue()).case(0))


def with_values(tree: Tree, values: Mapping[str, Any]) -> Tree:
    """Return a copy with some values, by dotted path."""
    return put_values(copy.deepcopy(tree), values)


def without(tree: Tree, path: str) -> Tree:
    """Return a copy without a section."""
    changed: Tree = copy.deepcopy(tree)
    *parents, key = path.split(".")
    section = changed
    for parent in parents:
        section = section[parent]
    del section[key]
    return changed


def leaves(tree: Any, prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Yield dotted path and value of every number and word of a tree."""
    if isinstance(tree, Mapping):
        for key, value in tree.items():
            yield from leaves(value, f"{prefix}.{key}" if prefix else key)
    elif not isinstance(tree, list):
        yield prefix, tree


# ----------------------------------------------------------------------------------------------------------------------


REFERENCE_TOLERANCES = (1e-13, 1e-12, 1e-11, 1e-10, 1e-9)  # the first that a case can reach
FURTHER_REFERENCES = (2.0, 3.0)  # tolerances of the reference: other sequences of steps, so other rounding errors
HALF = 0.5  # revolutions over which errors are compared
CLEARANCES = "clearances"  # what errors are measured in, where a joint is open
LONGEST_RUN = 3.0  # revolutions in which the predictable horizon is determined
SAMPLES = 360  # per revolution, at which positions are compared
FIRST_PEAKS = 3
YIELDING = ("/deflection", "/extension", "/mount_x", "/mount_y")  # ends of channels of a machine without open joints
COMPARABLE = 0.98  # of a run: a free crank, or a pair of bodies, ends it at a time of its own
CLOSE = 0.005  # of the compared time: an event this close to its end moves the end
ROUNDS = 3  # the least processor time counts
STEP_BUDGET = 10**6  # of a reference: one that needs more has reached the rounding of its positions
USEFUL_ERROR = 1e-3  # clearances: above the reference's own error, and below this, an error shows an order
ERRORS_ABOVE_REFERENCE = 10.0


def with_published_onset(tree: Tree) -> Tree:
    """Return a case whose onset rates count to the end of their contacts, as the rivals' right-hand side has it."""
    onsets = {
        f"joints.{name}.contact.onset": "first"
        for name, joint in tree.get("joints", {}).items()
        if joint.get("contact", {}).get("onset")
    }
    return with_values(tree, onsets)


class Reference(NamedTuple):
    """The reference motion of a case; one that has none has a summary only."""

    summary: dict[str, Any]  # horizon and compared length (revolutions), tolerance and own error (clearances)
    path: Any = None  # its Trajectory
    revolutions: Any = None  # (n,) of the samples; without a crank the share of the run times LONGEST_RUN
    limit: float = 0.0  # s, end of the comparison

    @property
    def compared(self) -> np.ndarray:
        """Return a mask of the samples that are compared."""
        return np.asarray(self.path["t"] <= self.limit)


class Truth:
    """The reference motion of a case, computed when it is needed."""

    def __init__(self, tree: Tree, tolerance: float):
        """Prepare for a case as `base_tree` returns it; tolerance : of the grid."""
        self.tree, self.tolerance = tree, tolerance

    @cached_property
    def scene(self) -> scene.Scene:
        """Return the case over one revolution, without samples."""
        return scene_of(self.tree)

    @property
    def is_turning(self) -> bool:
        """Return whether the machine has a crank, so that revolutions are defined."""
        return "revolutions" in self.tree["simulate"]

    def summary(self) -> dict[str, Any]:
        """Return horizon, compared length (revolutions), and tolerance and own error (clearances) of the reference."""
        return self._reference.summary

    @cached_property
    def _reference(self) -> Reference:
        """Return the reference, its own error and the horizon."""
        why = ""
        finer = [tolerance for tolerance in REFERENCE_TOLERANCES if tolerance < self.tolerance]
        for tolerance in finer or REFERENCE_TOLERANCES[:1]:
            try:
                path = self._long_run(tolerance, None)
                if path.status != "ok":
                    why = path.message
                    continue
                kept = path["t"] <= COMPARABLE * path["t"][-1]  # a run at another tolerance may not reach the end
                path = replace(path, channels={name: values[kept] for name, values in path.channels.items()})
                further = [self._long_run(ratio * tolerance, path["t"]) for ratio in FURTHER_REFERENCES]
            except InputError as error:
                why = str(error)
                continue
            messages = [run.message for run in further if run.status != "ok"]
            if not messages:
                break
            why = messages[0]
        else:
            missing = {"tolerance": None, "error": None, "why": why}
            return Reference({"horizon_revolutions": None, "compared_revolutions": None, "reference": missing})
        yours = self._long_run(self.tolerance, path["t"])
        revolutions = LONGEST_RUN * path["t"] / path["t"][-1]
        if self.is_turning:
            revolutions = np.abs(path["crank_angle"] - path["crank_angle"][0]) / (2.0 * math.pi)
        horizon = None
        if yours.status == "ok":
            beyond = np.flatnonzero(distances(self.tree, yours, path) > HORIZON_SIZE)
            horizon = float(revolutions[beyond[0]]) if beyond.size else None
        length = min(HALF, math.inf if horizon is None else horizon)
        limit = _between_events(path.events["t"], float(np.interp(length, revolutions, path["t"])))
        own_errors = (distances(self.tree, run, path)[path["t"] <= limit] for run in further)
        own_error = float(max(np.max(errors, initial=0.0) for errors in own_errors))
        summary = {
            "horizon_revolutions": horizon,
            "compared_revolutions": length,
            "reference": {"tolerance": tolerance, "error": own_error},
        }
        return Reference(summary, path, revolutions, limit)

    def _long_run(self, tolerance: float, times: np.ndarray | None) -> Trajectory:
        """Return a run over LONGEST_RUN revolutions, sampled at `times` (s) or evenly."""
        case_scene = self.scene
        if times is None:
            samples = SAMPLES if self.is_turning else int(LONGEST_RUN * SAMPLES)
            case_scene = scene_of(dict(self.tree, save={"orbits": "all", "samples": samples}))
        settings: dict[str, Any] = {"revolutions": LONGEST_RUN} if self.is_turning else {}
        settings |= {"method": "auto", "tolerance": tolerance, "step_budget": STEP_BUDGET}
        return simulate(case_scene.with_settings(**settings), times=times)

    def row(self, method: str, tolerance: float) -> dict[str, Any]:
        """Return error and processor time of a method at a tolerance."""
        row: dict[str, Any] = {"method": method, "tolerance": tolerance, "status": "ok"}
        missing = {"error": None, "peaks": None, "events_equal": False, "milliseconds": None, "scatter": None}
        try:
            return row | (
                self._rival(method, tolerance) if method.startswith("scipy") else self._own(method, tolerance)
            )
        except InputError as error:
            return row | missing | {"status": "refused", "why": str(error)}
        except _FailedRunError as failed:
            return row | missing | {"status": failed.status, "why": str(failed)}

    def _own(self, method: str, tolerance: float) -> dict[str, Any]:
        """Return the errors and the time of one of our methods."""
        case_scene, compared = self.scene.with_settings(method=method, tolerance=tolerance), self._reference.compared
        path = simulate(case_scene, times=self._reference.path["t"][compared])
        if path.status != "ok":
            raise _FailedRunError(path.status, path.message)
        seconds = [processor_time(case_scene)[0] for _ in range(ROUNDS)]  # of one revolution
        least_and_scatter = {"milliseconds": 1e3 * min(seconds), "scatter": max(seconds) / min(seconds) - 1.0}
        return self._errors(path, compared) | least_and_scatter

    def _errors(self, path: Any, mask: np.ndarray) -> dict[str, Any]:
        """Return the errors of a run's events, and of its samples, which are those of the reference in `mask`."""
        reference = self._reference
        error = float(np.max(distances(self.tree, path, reference.path, mask), initial=0.0))
        own, truth = (log[log["t"] <= reference.limit] for log in (path.events, reference.path.events))
        is_equal = len(own) == len(truth) and all(np.array_equal(own[name], truth[name]) for name in ("joint", "kind"))
        peaks, true_peaks = (log["force_peak"][log["kind"] == "off"][:FIRST_PEAKS] for log in (own, truth))
        comparable = len(peaks) == len(true_peaks) > 0 and bool(np.all(true_peaks > 0.0)) and bool(np.all(peaks > 0.0))
        peak_error = float(np.max(np.abs(peaks / true_peaks - 1.0))) if comparable else None
        return {"error": error, "peaks": peak_error, "events_equal": is_equal}

    def _rival(self, method: str, tolerance: float) -> dict[str, Any]:
        """Return the errors and the time of a method of scipy on the same right-hand side."""
        reference = self._reference
        mask = reference.compared & (reference.path["t"] > 0.0)
        times = reference.path["t"][mask]
        begin = time.process_time()
        solution = scipy_ivp(self.scene, times, float(times[-1]), tolerance, method=method.removeprefix("scipy "))
        spent = time.process_time() - begin
        if len(solution.states) != len(times):
            raise _FailedRunError("incomplete", f"it ended after {len(solution.states)} of {len(times)} samples")
        turned = reference.revolutions[reference.compared][-1]
        errors = self._errors(sampled(self.scene, times, solution), mask)
        return errors | {"milliseconds": 1e3 * spent / turned, "scatter": None}


def _between_events(times: np.ndarray, limit: float) -> float:
    """Return a time (s) near `limit` that no event at `times` is close to, so that rounding decides on none."""
    before, after, close = times[times <= limit], times[times > limit], CLOSE * limit
    last = float(before[-1]) if before.size else -math.inf
    following = float(after[0]) if after.size else math.inf
    if limit - last > close and following - limit > close:
        return limit
    middle = 0.5 * (last + following)
    return min(middle, last + 2.0 * close) if limit - last <= close else max(middle, following - 2.0 * close)


class _FailedRunError(Exception):
    """A run that did not end `ok`: its status, and its message as text."""

    def __init__(self, status: str, message: str):
        super().__init__(message)
        self.status = status


def distances(tree: Tree, path: Any, truth: Trajectory, mask: np.ndarray | None = None) -> np.ndarray:
    """Return the largest distance (clearances) of any open joint's journal from the reference at the samples, (n,).

    Without an open joint it is that of what bends, stretches or yields, relative to its largest value.
    """
    largest: np.ndarray = np.zeros(len(path["t"]))
    for channel in truth.channels if "joints" not in tree else ():
        if channel.endswith(YIELDING):
            error = path[channel] - (truth[channel] if mask is None else truth[channel][mask])
            largest = np.maximum(largest, np.abs(error) / (np.max(np.abs(truth[channel])) or 1.0))
    for name, joint in tree.get("joints", {}).items():
        errors = [
            path[channel] - (truth[channel] if mask is None else truth[channel][mask])
            for channel in (f"joints/{column_name(name)}/{axis}" for axis in "xyz")
            if channel in truth.channels
        ]
        largest = np.maximum(largest, np.sqrt(np.sum(np.square(errors), axis=0)) / clearance_of(joint))
    return largest


def clearance_of(joint: Mapping[str, Any]) -> float:
    """Return the clearance of a joint of a grid (m or rad): half of its play if it has a backlash, a play or stops."""
    if "stops" in joint and "clearance" not in joint:
        return 0.5 * float(joint["stops"]["at"][1] - joint["stops"]["at"][0])
    return float(joint.get("clearance", 0.5 * joint.get("backlash", joint.get("play", 0.0))))


def processor_time(case_scene: scene.Scene) -> tuple[float, Trajectory]:
    """Return the processor time (s) of a run without samples, and the run."""
    begin = time.process_time()
    path = simulate(case_scene)
    return time.process_time() - begin, path


def fitted_order(ladder: Sequence[Mapping[str, Any]], reference: Mapping[str, Any] | None) -> float | None:
    """Return p of error ~ tolerance^p, fitted to the rows of `auto` that have a useful error; None for fewer than 3."""
    own_error = (reference or {}).get("error") or 0.0
    points = [
        (math.log(row["tolerance"]), math.log(row["error"]))
        for row in ladder
        if row["method"] == "auto" and row["error"] and ERRORS_ABOVE_REFERENCE * own_error < row["error"] < USEFUL_ERROR
    ]
    if len(points) < 3:
        return None
    x, y = np.transpose(points)
    return float(np.polyfit(x, y, 1)[0])
