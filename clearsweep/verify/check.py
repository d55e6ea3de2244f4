"""Error against run time, stability and cost of the cases of a user's own grid.

A case is reduced to its motion: searches, lives, `until` and `uncertain` are left out, and it runs one revolution.  Its
reference is the same case at REFERENCE_TOLERANCES, explicit; the reference's own error is its distance from a second
run whose rounding differs.  A run is compared over half a revolution, or over the predictable horizon of the run at the
grid's tolerance if this is shorter.  Beyond it two integrations of a chaotic motion are two samples of it.

Every measured piece is stored as soon as it is known, so a check that was stopped continues where it was.
"""

import copy
import itertools
import json
import math
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property, partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import clearsweep

from .. import grid, store
from ..contracts.case import column_name
from ..contracts.results import Trajectory
from ..language.errors import InputError, quoted
from ..simulation import scene
from ..simulation.lyapunov import HORIZON_SIZE
from ..simulation.trajectory import simulate
from ..store import durable
from . import stability
from .rivals import RIVAL_METHODS, rival_problem, sampled, scipy_ivp

CHOICES = ("worst", "median", "first")  # cases that are checked by default
REFERENCE_TOLERANCES = (1e-13, 1e-12, 1e-11)  # the first that a case can reach
SECOND_REFERENCE = 2.0  # tolerances of the reference: another sequence of steps, so other rounding errors
LADDER = tuple(10.0**-power for power in range(3, 13))
METHODS = ("auto", "explicit", "implicit")
HALF = 0.5  # revolutions over which errors are compared
LONGEST_RUN = 3.0  # revolutions in which the predictable horizon is sought
SAMPLES = 360  # per revolution, at which positions are compared
FIRST_PEAKS = 3
COMPARABLE = 0.98  # of a run: a free crank, or a pair of bodies, ends it at a time of its own
CLOSE = 0.005  # of the compared time: an event this close to its end moves the end
ROUNDS = 3  # the least processor time counts
STEP_BUDGET = 10**7  # per revolution: not a limit of a reference
SCREENING_TOLERANCE, MAX_SCREENED = 1e-4, 200  # of the cases that are run to find the worst and the median
STABILITY_REVOLUTIONS = 2.0
ONSET_TOLERANCES = 100.0  # tolerances, in revolutions, by which the first onset may differ between the methods
BEYOND_ONSET = 1.1  # times the first onset: length of the runs that are compared
LEAST_ONSET_DIFFERENCE = 1e-9  # revolutions
USEFUL_ERROR = 1e-3  # clearances: above the reference's own error, and below this, an error shows an order
ERRORS_ABOVE_REFERENCE = 10.0

Tree = dict[str, Any]  # a case in the form of a grid file, in SI
Report = Callable[[str], None]


class Level(NamedTuple):
    """One change of a case: its factor, the level in words, and the new values by path."""

    factor: str
    text: str
    change: Mapping[str, Any]


class Notebook:
    """Measured pieces by key, stored in a file as they become known, until a deadline."""

    def __init__(self, path: Path | None, identity: str, seconds: float):
        """Begin with the pieces that an earlier check with the same `identity` has stored in `path`."""
        self.path, self.identity, self.pieces = path, identity, {}
        self.deadline = time.monotonic() + seconds
        self.left_out = 0  # pieces that the deadline left out
        if path is not None and path.exists():
            self.pieces = self._stored_pieces(path)

    def _stored_pieces(self, path: Path) -> dict[str, Any]:
        try:
            content = json.loads(durable.read(path))
        except ValueError:
            return {}
        is_same = isinstance(content, dict) and content.get("identity") == self.identity
        return dict(content["pieces"]) if is_same and isinstance(content.get("pieces"), dict) else {}

    def piece(self, key: str, measure: Callable[[], Any]) -> Any:
        """Return a stored piece, or measure and store it; None after the deadline."""
        if key in self.pieces:
            return self.pieces[key]
        if time.monotonic() > self.deadline:
            self.left_out += 1
            return None
        self.pieces[key] = measured = measure()
        if self.path is not None:
            content = {"identity": self.identity, "pieces": self.pieces}
            durable.replace(self.path, json.dumps(content, allow_nan=False).encode())
        return measured


# ---------------------------------------------------------------------------------------------- cases


class Options(NamedTuple):
    """The options of a check."""

    selection: Sequence[str] = CHOICES  # of CHOICES, or (the beginning of) a case id
    seconds: float = 60.0  # after which nothing further is measured
    rivals: bool = False  # scipy's methods, too
    directory: Path | None = None  # where measured pieces are stored
    results: Path | None = None  # a run of the grid, from which the worst and the median case are taken


def measure(loaded: grid.Grid, options: Options, report_progress: Report = lambda sentence: None) -> dict[str, Any]:
    """Return the check of some cases of a grid, as a dict for JSON: `cases`, their `indices`, `advice`, `complete`.

    Raises InputError for a case that cannot start, or a selection that names none.
    """
    selected = select_cases(loaded, options.selection, options.results, report_progress)
    identity = f"{clearsweep.MODEL_VERSION} {clearsweep.__version__} {','.join(loaded.case_id(i) for i in selected)}"
    path = options.directory / "measured.json" if options.directory else None
    book = Notebook(path, identity, options.seconds)
    cases = [
        check_case(loaded, index, labels, book, rivals=options.rivals, report_progress=report_progress)
        for index, labels in selected.items()
    ]
    complete = not book.left_out
    return {
        "grid": loaded.name,
        "indices": list(selected),
        "complete": complete,
        "cases": cases,
        "advice": advice(cases, complete=complete),
    }


def wording_of_cases(count: int) -> str:
    """Return '1 case' or '48 cases'."""
    return "1 case" if count == 1 else f"{count:,} cases"


def select_cases(
    loaded: grid.Grid, selection: Sequence[str], results: Path | None, report_progress: Report
) -> dict[int, list[str]]:
    """Return index -> the words of `selection` that chose it.  Raises InputError for an unknown case id."""
    selected: dict[int, list[str]] = {}
    ranked: list[int] | None = None
    for word in selection:
        if word == "first" or (word in CHOICES and len(loaded) == 1):
            index = 0
        elif word in CHOICES:
            ranked = ranked or _ranked_cases(loaded, results, report_progress)
            index = ranked[0] if word == "worst" else ranked[len(ranked) // 2]
        else:
            matching = [i for i in range(len(loaded)) if loaded.case_id(i).startswith(word)]
            if len(matching) != 1:
                raise InputError(
                    f"--case {quoted(word)}: {'no case' if not matching else f'{len(matching)} cases'} of the grid "
                    f"match; write {', '.join(CHOICES)}, or more of a case_id, as `clearsweep run` prints them"
                )
            index = matching[0]
        selected.setdefault(index, []).append(word)
    return selected


def _ranked_cases(loaded: grid.Grid, results: Path | None, report_progress: Report) -> list[int]:
    """Return the indices of cases, the largest ratio of load peak to ideal peak first.

    They are those of a finished run of this grid; otherwise at most MAX_SCREENED, evenly spread, are run at
    SCREENING_TOLERANCE.
    """
    stored = _stored_ratios(results) if results else {}
    ratios = {i: stored[case_id] for i in range(len(loaded)) if (case_id := loaded.case_id(i)) in stored}
    if not ratios:
        indices = np.unique(np.linspace(0, len(loaded) - 1, MAX_SCREENED).astype(int)).tolist()
        report_progress(f"running {wording_of_cases(len(indices))} at {SCREENING_TOLERANCE:g} to find the worst")
        for index in indices:
            tree = base_tree(loaded.written_case(index), tolerance=SCREENING_TOLERANCE)
            ratios[index] = _largest_ratio(simulate(scene_of(tree)).summary)
    return sorted(ratios, key=lambda index: -ratios[index])


def _stored_ratios(results: Path) -> dict[str, float]:
    """Return case_id -> largest ratio of a run in the directory `results`; empty if there is none that can be read."""
    if not (results / "summary.parquet").is_file():
        return {}
    summary = store.open(results).summary
    columns = [name for name in summary.columns if name.endswith("_force_peak_ratio")]
    if not columns:
        return {}
    ids = summary["case_id"] if "case_id" in summary.columns else summary.index
    return dict(zip(ids, summary[columns].max(axis=1).fillna(0.0), strict=True))


def _largest_ratio(summary: Mapping[str, Any]) -> float:
    """Return the largest ratio of load peak to ideal peak of a case; without one its largest force peak."""
    for ending in ("_force_peak_ratio", "_force_peak"):
        values = [value for name, value in summary.items() if name.endswith(ending) and value is not None]
        if values:
            return float(max(values))
    return 0.0


def base_tree(written: Mapping[str, Any], **settings: Any) -> Tree:
    """Return a case reduced to its motion: one revolution from the start, no history, with some `simulate` settings."""
    tree: Tree = copy.deepcopy(_plain(written))
    for name in ("life", "uncertain", "define"):
        tree.pop(name, None)
    simulation = tree["simulate"]
    for name in ("until", "horizon", "error_check", "discard", "time_budget"):
        simulation.pop(name, None)
    if "revolutions" in simulation:
        simulation |= {"revolutions": 1.0, "discard": 0.0}
    tree["save"] = {"orbits": "none"}
    simulation |= settings
    return tree


def _plain(value: Any) -> Any:
    """Return nested sections as plain dicts and lists."""
    if isinstance(value, Mapping):
        return {key: _plain(item) for key, item in value.items()}
    return [_plain(item) for item in value] if isinstance(value, list | tuple) else value


def scene_of(tree: Tree) -> scene.Scene:
    """Return the Scene of a case in the form of a grid file.  Raises InputError."""
    return scene.build(grid.load(tree, scene.catalogue()).case(0))


# ---------------------------------------------------------------------------------------------- one case


def check_case(
    loaded: grid.Grid,
    index: int,
    labels: Sequence[str],
    book: Notebook,
    *,
    rivals: bool,
    report_progress: Report,
) -> dict[str, Any]:
    """Return the check of one case: reference, ladder, stability and parts."""
    case_id, written = loaded.case_id(index), loaded.written_case(index)
    tree = base_tree(written)
    tolerance = float(tree["simulate"]["tolerance"])
    name = f"case {case_id[:8]} ({', '.join(labels)})"
    report_progress(f"{name}: reference")
    result: dict[str, Any] = {
        "case_id": case_id,
        "chosen_as": list(labels),
        "values": {path: value for path, value in loaded.point(index).items() if value is not None},
    }
    truth = Truth(tree, tolerance)
    reference = book.piece(f"{case_id} reference", truth.summary)
    result |= reference or {"horizon_revolutions": None, "compared_revolutions": None, "reference": None}
    has_reference = reference is not None and reference["reference"]["tolerance"] is not None
    published = Truth(_with_published_onset(tree), tolerance)
    ladder: list[dict[str, Any]] = []

    def climb(rungs: Iterable[tuple[str, float]]) -> None:
        for method, rung in rungs if has_reference else ():
            report_progress(f"{name}: {method} at {rung:g}")
            base = published if method.startswith("scipy") else truth
            row = book.piece(f"{case_id} {method} {rung:g}", partial(base.row, method, rung))
            ladder.extend([row] if row else [])

    climb(("auto", rung) for rung in sorted({*LADDER, tolerance}, reverse=True))
    result["stability"] = check_stability(tree, case_id, book, lambda text: report_progress(f"{name}: {text}"))
    report_progress(f"{name}: cost of its parts")
    result["parts"] = book.piece(f"{case_id} parts", lambda: costs_of_parts(written)) or []
    climb(itertools.product(METHODS[1:], LADDER))
    obstacle = rival_problem(scene_of(tree)) if rivals else ""
    if rivals and not obstacle:
        climb(itertools.product([f"scipy {method}" for method in RIVAL_METHODS], LADDER))
    result |= {"ladder": ladder, "rivals": obstacle}
    yours = next((row for row in ladder if row["method"] == "auto" and row["tolerance"] == tolerance), None)
    yours = yours or {"error": None, "milliseconds": None}
    result["yours"] = {"tolerance": tolerance, "error": yours["error"], "milliseconds": yours["milliseconds"]}
    result["order"] = fitted_order(ladder, (reference or {}).get("reference"))
    return result


def _with_published_onset(tree: Tree) -> Tree:
    """Return a case whose onset rates count to the end of their contacts, as the rivals' right-hand side has it."""
    onsets = {
        f"joints.{name}.contact.onset": "first"
        for name, joint in tree["joints"].items()
        if joint.get("contact", {}).get("onset")
    }
    return _with_values(tree, onsets)


class Truth:
    """The reference motion of a case, computed when it is needed."""

    def __init__(self, tree: Tree, tolerance: float):
        """Prepare for a case as `base_tree` returns it; tolerance : of the grid."""
        self.tree, self.tolerance = tree, tolerance
        self._limit = 0.0  # s, end of the comparison
        self._path: Trajectory | None = None
        self._summary: dict[str, Any] = {}

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
        self._compute()
        return self._summary

    def _compute(self) -> None:
        """Compute the reference, its own error and the horizon."""
        why = ""
        for tolerance in REFERENCE_TOLERANCES:
            try:
                path = self._long_run("explicit", tolerance, None)
                if path.status == "ok":
                    path = _before_end(path)
                second = self._long_run("explicit", SECOND_REFERENCE * tolerance, path.channels.get("t"))
            except InputError as error:
                why = str(error)
                continue
            if path.status == second.status == "ok":
                break
            why = path.message or second.message
        else:
            missing = {"tolerance": None, "error": None, "why": why}
            self._summary = {"horizon_revolutions": None, "compared_revolutions": None, "reference": missing}
            return
        self._path = path
        yours = self._long_run("auto", self.tolerance, path["t"])
        revolutions = self._revolutions()
        horizon = None
        if yours.status == "ok":
            beyond = np.flatnonzero(distances(self.tree, yours, path) > HORIZON_SIZE)
            horizon = float(revolutions[beyond[0]]) if beyond.size else None
        length = min(HALF, math.inf if horizon is None else horizon)
        self._limit = self._between_events(float(np.interp(length, revolutions, path["t"])))
        own_error = float(np.max(distances(self.tree, second, path)[self._compared()], initial=0.0))
        self._summary = {
            "horizon_revolutions": horizon,
            "compared_revolutions": length,
            "reference": {"tolerance": tolerance, "error": own_error},
        }

    def _long_run(self, method: str, tolerance: float, times: np.ndarray | None) -> Trajectory:
        """Return a run over LONGEST_RUN revolutions, sampled at `times` (s) or evenly."""
        case_scene = self.scene
        if times is None:
            samples = SAMPLES if self.is_turning else int(LONGEST_RUN * SAMPLES)
            case_scene = scene_of(dict(self.tree, save={"orbits": "all", "samples": samples}))
        settings: dict[str, Any] = {"revolutions": LONGEST_RUN} if self.is_turning else {}
        settings |= {"method": method, "tolerance": tolerance, "step_budget": STEP_BUDGET}
        return simulate(case_scene.with_settings(**settings), times=times)

    def _revolutions(self) -> np.ndarray:
        """Return the revolutions (without a crank the share of the run times LONGEST_RUN) of the samples, (n,)."""
        assert self._path is not None  # computed before
        if not self.is_turning:
            return np.asarray(LONGEST_RUN * self._path["t"] / self._path["t"][-1])
        angle = self._path["crank_angle"]
        return np.asarray(np.abs(angle - angle[0]) / (2.0 * math.pi))

    def _between_events(self, limit: float) -> float:
        """Return a time (s) near `limit` that no event is close to, so that rounding decides on none."""
        assert self._path is not None  # computed before
        times, close = self._path.events["t"], CLOSE * limit
        before, after = times[times <= limit], times[times > limit]
        last = float(before[-1]) if before.size else -math.inf
        following = float(after[0]) if after.size else math.inf
        if limit - last > close and following - limit > close:
            return limit
        middle = 0.5 * (last + following)
        return min(middle, last + 2.0 * close) if limit - last <= close else max(middle, following - 2.0 * close)

    def _compared(self) -> np.ndarray:
        """Return a mask of the samples that are compared."""
        assert self._path is not None  # computed before
        return self._path["t"] <= self._limit

    def row(self, method: str, tolerance: float) -> dict[str, Any]:
        """Return error and processor time of a method at a tolerance."""
        if self._path is None:
            self._compute()
        assert self._path is not None  # a case without reference has no ladder
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
        assert self._path is not None  # computed before
        case_scene = self.scene.with_settings(method=method, tolerance=tolerance)
        times = self._path["t"][self._compared()]
        path = simulate(case_scene, times=times)
        if path.status != "ok":
            raise _FailedRunError(path.status, path.message)
        spent = [_processor_time(case_scene) for _ in range(ROUNDS)]
        return self._errors(path, self._compared()) | _least_and_scatter(spent)

    def _errors(self, path: Any, mask: np.ndarray) -> dict[str, Any]:
        """Return the errors of a run's events, and of its samples, which are those of the reference in `mask`."""
        assert self._path is not None  # computed before
        events = path.events
        error = float(np.max(distances(self.tree, path, self._path, mask), initial=0.0))
        own, truth = (log[log["t"] <= self._limit] for log in (events, self._path.events))
        is_equal = len(own) == len(truth) and bool(
            np.all(own["joint"] == truth["joint"]) and np.all(own["kind"] == truth["kind"])
        )
        peaks, true_peaks = (log["force_peak"][log["kind"] == "off"][:FIRST_PEAKS] for log in (own, truth))
        comparable = len(peaks) == len(true_peaks) > 0 and bool(np.all(true_peaks > 0.0)) and bool(np.all(peaks > 0.0))
        peak_error = float(np.max(np.abs(peaks / true_peaks - 1.0))) if comparable else None
        return {"error": error, "peaks": peak_error, "events_equal": is_equal}

    def _rival(self, method: str, tolerance: float) -> dict[str, Any]:
        """Return the errors and the time of a method of scipy on the same right-hand side."""
        assert self._path is not None  # computed before
        case_scene = self.scene
        mask = self._compared() & (self._path["t"] > 0.0)
        times = self._path["t"][mask]
        end = float(times[-1])
        begin = time.process_time()
        solution = scipy_ivp(case_scene, times, end, tolerance, method=method.removeprefix("scipy "))
        spent = time.process_time() - begin
        if len(solution.states) != len(times):
            raise _FailedRunError("incomplete", f"it ended after {len(solution.states)} of {len(times)} samples")
        path = sampled(case_scene, times, solution)
        turned = self._revolutions()[self._compared()][-1]
        return self._errors(path, mask) | {"milliseconds": 1e3 * spent / turned, "scatter": None}


def _before_end(path: Trajectory) -> Trajectory:
    """Return a run without the samples of its last part, which a run at another tolerance may not reach."""
    kept = path["t"] <= COMPARABLE * path["t"][-1]
    return replace(path, channels={name: values[kept] for name, values in path.channels.items()})


class _FailedRunError(Exception):
    """A run that did not end `ok`: its status, and its message as text."""

    def __init__(self, status: str, message: str):
        super().__init__(message)
        self.status = status


def distances(tree: Tree, path: Any, truth: Trajectory, mask: np.ndarray | None = None) -> np.ndarray:
    """Return the largest distance (clearances) of any open joint's journal from the reference at the samples, (n,)."""
    largest: np.ndarray = np.zeros(len(path["t"]))
    for name, joint in tree["joints"].items():
        channels = [f"joints/{column_name(name)}/{axis}" for axis in "xyz"]
        parts = [
            path[channel] - (truth[channel] if mask is None else truth[channel][mask])
            for channel in channels
            if channel in truth.channels
        ]
        largest = np.maximum(largest, np.sqrt(np.sum(np.square(parts), axis=0)) / float(joint["clearance"]))
    return largest


def _processor_time(case_scene: scene.Scene) -> tuple[float, Trajectory]:
    """Return the processor time (s) of a run without samples, and the run."""
    begin = time.process_time()
    path = simulate(case_scene)
    return time.process_time() - begin, path


def _least_and_scatter(spent: Sequence[tuple[float, Trajectory]]) -> dict[str, float]:
    """Return the least time (ms a revolution) of runs of one revolution, and the excess of the largest over it."""
    times = [seconds for seconds, _ in spent]
    return {"milliseconds": 1e3 * min(times), "scatter": max(times) / min(times) - 1.0}


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


# ---------------------------------------------------------------------------------------------- stability


def levels_of(tree: Tree) -> dict[str, list[Level]]:
    """Return the changes of a case by factor; a factor that the scene lacks is left out."""
    leaves = dict(_leaves(tree))
    in_contact = {path: value for path, value in leaves.items() if path.startswith("joints.") and ".contact." in path}
    stiffness = {path: value for path, value in in_contact.items() if path.endswith((".stiffness", ".young"))}
    damping = {path: value for path, value in in_contact.items() if path.endswith((".damping", ".damping_factor"))}
    clearances = {f"joints.{name}.clearance": joint["clearance"] for name, joint in tree["joints"].items()}
    speeds = {
        path: leaves[path] for path in ("drive.speed", "drive.initial_speed", "mechanism.speed") if path in leaves
    }
    restitutions = [path for path in in_contact if path.endswith(".restitution")]
    friction = [
        path for path in leaves if path.startswith("joints.") and ".friction." in path and path.endswith("coefficient")
    ]
    start = tree["simulate"].get("start", "centred")
    factors = {
        "clearance": _scaled("clearance", clearances),
        "stiffness": _scaled("stiffness", stiffness),
        "speed": _scaled("speed", {path: value for path, value in speeds.items() if value}),
        "restitution": _set("restitution", restitutions, (0.0, 1.0)),
        "damping": _scaled("damping", damping),
        "friction": _set("friction", friction, (0.0, 1.0)),
        "tolerance": _set("tolerance", ["simulate.tolerance"], (1e-4, 1e-12)),
        "start": [
            Level("start", f"start {word}", {"simulate.start": word})
            for word in ("centred", "seated")
            if word != start and "start" in tree["simulate"]
        ],
    }
    return {name: levels for name, levels in factors.items() if levels}


def _leaves(tree: Any, prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Yield dotted path and value of every number and word of a tree."""
    if isinstance(tree, Mapping):
        for key, value in tree.items():
            yield from _leaves(value, f"{prefix}.{key}" if prefix else key)
    elif not isinstance(tree, list):
        yield prefix, tree


def _scaled(factor: str, values: Mapping[str, Any]) -> list[Level]:
    """Return the values at a tenth and at ten times."""
    if not values:
        return []
    return [
        Level(factor, f"{text} the {factor}", {path: scale * value for path, value in values.items()})
        for scale, text in ((0.1, "a tenth of"), (10.0, "ten times"))
    ]


def _set(factor: str, paths: Sequence[str], values: Sequence[float]) -> list[Level]:
    """Return these values at all paths."""
    return [Level(factor, f"{factor} {value:g}", dict.fromkeys(paths, value)) for value in values] if paths else []


def variants_of(tree: Tree) -> list[tuple[Level, ...]]:
    """Return the variants of a case: every level alone, and every pair of levels of two factors."""
    factors = levels_of(tree)
    singles: list[tuple[Level, ...]] = [(level,) for levels in factors.values() for level in levels]
    return singles + [
        pair
        for first, second in itertools.combinations(factors.values(), 2)
        for pair in itertools.product(first, second)
    ]


def check_stability(tree: Tree, case_id: str, book: Notebook, report_progress: Report) -> dict[str, Any]:
    """Return how many variants of a case were tried and passed, the failed and the refused ones."""
    tried, passed, failed, refused = 0, 0, [], []
    for variant in variants_of(tree):
        text = variant_text(variant)
        report_progress(text)
        outcome = book.piece(f"{case_id} {text}", partial(try_variant, tree, variant, book.deadline))
        if outcome is None:
            continue
        entry = {"change": {path: value for level in variant for path, value in level.change.items()}, "text": text}
        if outcome["status"] == "refused":
            refused.append(entry | outcome)
            continue
        tried += 1
        passed += not outcome["why"]
        failed += [entry | outcome] if outcome["why"] else []
    return {"tried": tried, "passed": passed, "failed": failed, "refused": refused}


def variant_text(variant: Sequence[Level]) -> str:
    """Return a variant in words: 'restitution 0, ten times the speed'."""
    return ", ".join(level.text for level in variant)


def try_variant(tree: Tree, variant: Sequence[Level], deadline: float) -> dict[str, Any]:
    """Return status and cause of failure of a variant; the cause is empty if it passes."""
    changes = {path: value for level in variant for path, value in level.change.items()}
    if "revolutions" in tree["simulate"]:
        changes["simulate.revolutions"] = STABILITY_REVOLUTIONS
    changed = _with_values(tree, changes)
    try:
        case_scene = scene_of(changed)
    except InputError as error:
        return {"status": "refused", "why": str(error)}
    seconds = max(deadline - time.monotonic(), 1.0)
    case_scene = case_scene.with_settings(time_budget=seconds)
    row = stability.run_scene(case_scene)
    why = row["failure"] or _onset_difference(case_scene, row["first_onset"])
    return {"status": row["status"], "why": why, "energy_residual": row["energy_residual"]}


def _onset_difference(case_scene: scene.Scene, first_onset: float | None) -> str:
    """Return how the first onset differs between the explicit and the implicit method; '' if it is equal.

    first_onset : s, None if there is none.
    """
    if first_onset is None:
        return ""
    period, onsets = 2.0 * math.pi / case_scene.value.reference_rate, []
    settings: dict[str, Any] = {}
    if case_scene.mechanism.turns:
        settings["revolutions"] = min(BEYOND_ONSET * first_onset / period + 0.01, STABILITY_REVOLUTIONS)
    for method in ("explicit", "implicit"):
        path = simulate(case_scene.with_settings(method=method, **settings), times=np.zeros(1))
        events = path.events[path.events["kind"] == "on"]
        if not len(events):
            return f"first onset: none by the {method} method, at {first_onset:.9g} s by auto"
        onsets.append((str(events["joint"][0]), float(events["t"][0])))
    (joint, moment), (other_joint, other_moment) = onsets
    allowed = max(ONSET_TOLERANCES * case_scene.case.simulate.tolerance, LEAST_ONSET_DIFFERENCE)
    if joint == other_joint and abs(moment - other_moment) <= allowed * period:
        return ""
    return (
        f"first onset: {joint} at {moment:.9g} s by the explicit method, {other_joint} at {other_moment:.9g} s by the "
        "implicit one"
    )


def _with_values(tree: Tree, values: Mapping[str, Any]) -> Tree:
    """Return a copy with some values, by dotted path."""
    changed: Tree = copy.deepcopy(tree)
    for path, value in values.items():
        *parents, key = path.split(".")
        section = changed
        for parent in parents:
            section = section.setdefault(parent, {})
        section[key] = value
    return changed


# ---------------------------------------------------------------------------------------------- cost of parts

PART_ROUNDS = 6  # the first warms up, the least counts
UNOBSERVED = 0.999  # share of a run that is discarded, so that nothing is accumulated
OPTIONAL_SECTIONS = ("friction", "wear", "film", "roughness", "thermal")  # of a joint


def costs_of_parts(written: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return what each part of a scene costs (ms a revolution), found by leaving it out.

    A scene without a law moves otherwise, so for laws the costs of a step are compared, times the steps of the whole
    scene; a joint also brings steps of its own.  `rates` is what remains without any part: equations of motion, steps
    and events.
    """
    base = bare = base_tree(written)
    scenes = {"": scene_of(base)}
    for name, joint in base["joints"].items():
        removable = [f"joints.{name}.{section}" for section in OPTIONAL_SECTIONS if section in joint]
        for path in [*([f"joints.{name}"] if len(base["joints"]) > 1 else []), *removable]:
            try:
                scenes[path] = scene_of(_without(base, path))
                barer = _without(bare, path) if path in removable else bare
                scene_of(barer)
            except InputError:
                continue  # the rest of the scene needs this part
            bare = barer
    if _plain(written).get("save", {}).get("orbits", "none") != "none":
        length = {"revolutions": 1.0} if "revolutions" in base["simulate"] else {}
        scenes["orbits"] = scene_of(dict(base, save=_plain(written)["save"] | length))
    plain = scene_of(bare)
    unobserved = plain.with_settings(discard=UNOBSERVED * plain.case.simulate.revolutions)
    runs = {**scenes, "bare": plain, "unobserved": unobserved}
    costs = dict.fromkeys(runs, math.inf)
    counts = {}
    for _ in range(PART_ROUNDS):
        for path, case_scene in runs.items():
            seconds, trajectory = _processor_time(case_scene)
            counts[path] = trajectory.summary["steps"]
            costs[path] = min(costs[path], seconds / max(counts[path], 1))
    rows = []
    for path in runs:
        if path in ("", "bare", "unobserved"):
            continue
        cost = costs[path] - costs[""] if path == "orbits" else costs[""] - costs[path]
        milliseconds = 1e3 * cost * counts[""]
        if path.count(".") == 1:  # a joint
            milliseconds = 1e3 * (costs[""] * counts[""] - costs[path] * counts[path])
        rows.append({"part": path, "milliseconds": milliseconds})
    rows.append({"part": "histogram", "milliseconds": 1e3 * (costs["bare"] - costs["unobserved"]) * counts[""]})
    rows.append({"part": "rates", "milliseconds": 1e3 * costs["unobserved"] * counts[""]})
    return rows


def _without(tree: Tree, path: str) -> Tree:
    """Return a copy without a section."""
    changed: Tree = copy.deepcopy(tree)
    *parents, key = path.split(".")
    section = changed
    for parent in parents:
        section = section[parent]
    del section[key]
    return changed


# ---------------------------------------------------------------------------------------------- advice

WORTHWHILE = 0.1  # share of the run time below which a looser tolerance is not proposed
ENOUGH = 1e-6  # clearances: error of a journal that no figure of a report shows
TOO_LARGE = 1e-3  # clearances: error of a journal above which single peaks are doubtful
MAX_NAMED = 2  # failed variants that the advice names


def advice(cases: Sequence[Mapping[str, Any]], *, complete: bool) -> list[str]:
    """Return three sentences on what to do, from the checks of the cases; a further one if pieces are missing."""
    lines = [*_accuracy_sentences(cases), _stability_sentence(cases)]
    if not complete:
        lines.append("The time ran out before everything was measured; run the same command again to continue.")
    return lines


def _accuracy_sentences(cases: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return what the grid's tolerance achieves, and which tolerance to use, for the worst of the cases."""
    known = [case for case in cases if case["yours"]["error"] is not None]
    if not known:
        causes = [(case.get("reference") or {}).get("why") for case in cases]
        cause = next(filter(None, causes), "the time ran out")
        return [f"The error at your tolerance is unknown: {cause}."]
    worst = max(known, key=lambda case: case["yours"]["error"])
    yours, error = worst["yours"], worst["yours"]["error"]
    length = worst["compared_revolutions"]
    period = "half a revolution" if length == HALF else f"{length:.2g} revolutions, its predictable horizon"
    in_case = f" (case {worst['case_id'][:8]})" if len(cases) > 1 else ""
    first = (
        f"At your tolerance {yours['tolerance']:g} the journal is within {error:.1g} of its clearance for {period}"
        f"{in_case}, in {yours['milliseconds']:.2g} ms a revolution."
    )
    return [first, _tolerance_sentence(known, worst)]


def _tolerance_sentence(cases: Sequence[Mapping[str, Any]], worst: Mapping[str, Any]) -> str:
    """Return which tolerance to use: tighter if the error is too large, else the loosest that would do."""
    tolerance, error = worst["yours"]["tolerance"], worst["yours"]["error"]
    if error > TOO_LARGE:
        tighter = _loosest_with(cases, TOO_LARGE)
        if tighter is None:
            return f"No tolerance keeps the journal within {TOO_LARGE:g} of its clearance; trust statistics only."
        return f"Use {tighter:g}: it keeps the journal within {_errors_at(cases, tighter):.1g} of its clearance."
    loosest = _loosest_with(cases, ENOUGH)
    if loosest is None or loosest <= tolerance:
        return f"A looser tolerance would err by more than {ENOUGH:g} of the clearance; keep yours."
    saved = 1.0 - _time_at(cases, loosest) / _time_at(cases, tolerance)
    if saved < WORTHWHILE:
        return (
            f"A looser tolerance saves no time worth having ({loosest:g}: {100.0 * max(saved, 0.0):.0f} %); keep yours."
        )
    return f"{loosest:g} would do with {_errors_at(cases, loosest):.1g}, {100.0 * saved:.0f} % faster."


def _rows_at(cases: Sequence[Mapping[str, Any]], tolerance: float) -> list[Mapping[str, Any]]:
    """Return the rows of `auto` at a tolerance, one for each case that has it."""
    rows = [row for case in cases for row in case["ladder"] if row["method"] == "auto"]
    return [row for row in rows if row["tolerance"] == tolerance and row["error"] is not None]


def _errors_at(cases: Sequence[Mapping[str, Any]], tolerance: float) -> float:
    return float(max(row["error"] for row in _rows_at(cases, tolerance)))


def _time_at(cases: Sequence[Mapping[str, Any]], tolerance: float) -> float:
    return float(sum(row["milliseconds"] for row in _rows_at(cases, tolerance)))


def _loosest_with(cases: Sequence[Mapping[str, Any]], error: float) -> float | None:
    """Return the loosest tolerance at which every case has at most this error and the right events."""
    for tolerance in sorted({row["tolerance"] for case in cases for row in case["ladder"]}, reverse=True):
        rows = _rows_at(cases, tolerance)
        if len(rows) == len(cases) and all(row["error"] <= error and row["events_equal"] for row in rows):
            return float(tolerance)
    return None


def _stability_sentence(cases: Sequence[Mapping[str, Any]]) -> str:
    """Return how many variants pass, and the first that fail."""
    tried, passed = (sum(case["stability"][name] for case in cases) for name in ("tried", "passed"))
    failed = [entry for case in cases for entry in case["stability"]["failed"]]
    if not tried:
        return "No variant was tried."
    if not failed:
        return f"All {tried} variants pass."
    named = [f"{entry['text']}: {entry['why'].partition(';')[0]}" for entry in failed[:MAX_NAMED]]
    rest = f", and {len(failed) - MAX_NAMED} more" if len(failed) > MAX_NAMED else ""
    return f"{passed} of {tried} variants pass; {'; '.join(named)}{rest}."
