"""Error against run time, stability and cost of the cases of a user's own grid.

A case is reduced to its motion: searches, lives, `until` and `uncertain` are left out, and it runs one revolution.
Every measured piece is stored as soon as it is known, so a check that was stopped continues where it was.
"""

import itertools
import json
import math
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import clearsweep

from .. import grid, store
from ..answers.words import MIN_DIGITS, varied_text
from ..contracts.results import OUTSIDE_MODEL
from ..language import phases, wording
from ..language.errors import InputError, quoted
from ..simulation.analyses.trajectory import simulate
from ..simulation.setup import scene
from ..store import durable
from . import Report, announced_steps, stability
from .reference_run import (
    CLEARANCES,
    HALF,
    STEP_BUDGET,
    Tree,
    Truth,
    base_tree,
    fitted_order,
    leaves,
    plain,
    processor_time,
    scene_of,
    with_published_onset,
    with_values,
    without,
)
from .rivals import RIVAL_METHODS, rival_problem

# ----------------------------------------------------------------------------------------------------------------------
# Variants of a case at the extremes of its factors, and what the parts of its scene cost.


STABILITY_REVOLUTIONS = 2.0
ONSET_TOLERANCES = 100.0  # tolerances, in revolutions, by which the first onset may differ between the methods
BEYOND_ONSET = 1.1  # times the first onset: length of the runs that are compared
LEAST_ONSET_DIFFERENCE = 1e-9  # revolutions
PART_ROUNDS = 6  # the first warms up, the least counts
UNOBSERVED = 0.999  # share of a run that is discarded, so that nothing is accumulated
OPTIONAL_SECTIONS = ("friction", "wear", "film", "roughness", "thermal")  # of a joint


class Level(NamedTuple):
    """One change of a case: its factor, the level in words, and the new values by path."""

    factor: str
    text: str
    change: Mapping[str, Any]


def levels_of(tree: Tree) -> dict[str, list[Level]]:
    """Return the changes of a case by factor; a factor that the scene lacks is left out."""
    values = dict(leaves(tree))
    in_contact = {path: value for path, value in values.items() if path.startswith("joints.") and ".contact." in path}
    stiffness = {path: value for path, value in in_contact.items() if path.endswith((".stiffness", ".young"))}
    damping = {path: value for path, value in in_contact.items() if path.endswith((".damping", ".damping_factor"))}
    clearances = {
        f"joints.{name}.{key}": joint[key]
        for name, joint in tree.get("joints", {}).items()
        for key in ("clearance", "backlash", "play")
        if key in joint
    }
    speeds = {
        path: values[path] for path in ("drive.speed", "drive.initial_speed", "mechanism.speed") if path in values
    }
    restitutions = [path for path in in_contact if path.endswith(".restitution")]
    in_friction = [path for path in values if path.startswith("joints.") and ".friction." in path]
    friction = [path for path in in_friction if path.endswith("coefficient")]
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


def variant_text(variant: Sequence[Level]) -> str:
    """Return a variant in words: 'restitution 0, ten times the speed'."""
    return ", ".join(level.text for level in variant)


def try_variant(tree: Tree, variant: Sequence[Level], deadline: float) -> dict[str, Any]:
    """Return status and cause of failure of a variant; the cause is empty if it passes.

    A variant that cannot be built, or leaves the model, is refused: no method could pass.
    """
    changes = {path: value for level in variant for path, value in level.change.items()}
    if "revolutions" in tree["simulate"]:
        changes["simulate.revolutions"] = STABILITY_REVOLUTIONS
    changed = with_values(tree, changes)
    try:
        case_scene = scene_of(changed)
    except InputError as error:
        return {"status": "refused", "why": str(error)}
    seconds = max(deadline - time.monotonic(), 1.0)
    case_scene = case_scene.with_settings(time_budget=seconds)
    row = stability.run_scene(case_scene)
    if row["status"] == OUTSIDE_MODEL:
        return {"status": "refused", "why": row["failure"]}
    why = row["failure"] or _onset_difference(case_scene, row["first_onset"])
    return {"status": row["status"], "why": why, "energy_residual": row["energy_residual"]}


def _onset_difference(case_scene: scene.Scene, first_onset: float | None) -> str:
    """Return how the first onset differs between the explicit and the implicit method; '' if it is equal.

    first_onset : s, None if there is none.
    """
    if first_onset is None:
        return ""
    period, onsets = 2.0 * math.pi / case_scene.value.reference_rate, []
    settings: dict[str, Any] = {"step_budget": STEP_BUDGET}
    if case_scene.mechanism.turns:
        length = case_scene.case.simulate.period or period  # of a cycle, or of a run over a time
        settings["revolutions"] = min(BEYOND_ONSET * first_onset / length + 0.01, STABILITY_REVOLUTIONS)
    for method in ("explicit", "implicit"):
        path = simulate(case_scene.with_settings(method=method, **settings), times=np.zeros(1))
        events = path.events[path.events["kind"] == "on"]
        if not len(events):
            end = "none" if path.status == "ok" else path.status
            return f"first onset: {end} by the {method} method, at {first_onset:.9g} s by auto"
        onsets.append((str(events["joint"][0]), float(events["t"][0])))
    (joint, moment), (other_joint, other_moment) = onsets
    allowed = max(ONSET_TOLERANCES * case_scene.case.simulate.tolerance, LEAST_ONSET_DIFFERENCE)
    if joint == other_joint and abs(moment - other_moment) <= allowed * period:
        return ""
    return (
        f"first onset: {joint} at {moment:.9g} s by the explicit method, {other_joint} at {other_moment:.9g} s by the "
        "implicit one"
    )


def costs_of_parts(written: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return what each part of a scene costs (ms a revolution), found by leaving it out.

    A scene without a law moves otherwise, so for laws the costs of a step are compared, times the steps of the whole
    scene; a joint also brings steps of its own.  `rates` is what remains without any part: equations of motion, steps
    and events.
    """
    base = bare = base_tree(written)
    scenes = {"": scene_of(base)}
    for name, joint in base.get("joints", {}).items():
        removable = [f"joints.{name}.{section}" for section in OPTIONAL_SECTIONS if section in joint]
        for path in [*([f"joints.{name}"] if len(base["joints"]) > 1 else []), *removable]:
            try:
                scenes[path] = scene_of(without(base, path))
                barer = without(bare, path) if path in removable else bare
                scene_of(barer)
            except InputError:
                continue  # the rest of the scene needs this part
            bare = barer
    if plain(written).get("save", {}).get("orbits", "none") != "none":
        length = {"revolutions": 1.0} if "revolutions" in base["simulate"] else {}
        scenes["orbits"] = scene_of(dict(base, save=plain(written)["save"] | length))
    barest = scene_of(bare)
    unobserved = barest.with_settings(discard=UNOBSERVED * barest.case.simulate.revolutions)
    runs = {**scenes, "bare": barest, "unobserved": unobserved}
    costs = dict.fromkeys(runs, math.inf)
    counts = {}
    for _ in range(PART_ROUNDS):
        for path, case_scene in runs.items():
            seconds, trajectory = processor_time(case_scene)
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


# ----------------------------------------------------------------------------------------------------------------------


CHOICES = ("worst", "median", "first")  # cases that are checked by default
LADDER = tuple(10.0**-power for power in range(3, 13))
METHODS = ("auto", "explicit", "implicit")
SCREENING_TOLERANCE, MAX_SCREENED = 1e-4, 200  # of the cases that are run to find the worst and the median


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


class Options(NamedTuple):
    """The options of a check."""

    selection: Sequence[str] = CHOICES  # of CHOICES, or (the beginning of) a case id
    seconds: float = 60.0  # after which nothing further is measured
    rivals: bool = False  # scipy's methods, too
    directory: Path | None = None  # where measured pieces are stored
    results: Path | None = None  # a run of the grid, from which the worst and the median case are taken


def text_of_values(loaded: grid.Grid) -> Callable[[str, Any], str]:
    """Return the function of a path and a varied value of a grid that returns it in the unit of the grid."""
    units = grid.key_units(loaded.resolved(), scene.catalogue()) | {path: loaded.unit(path) for path in loaded.axes}
    written = {path: unit._asdict() for path, unit in loaded.written_units.items()}

    def text(path: str, value: Any) -> str:
        return value if isinstance(value, str) else varied_text(path, value, units.get(path, "1"), written, MIN_DIGITS)

    return text


def check_grid(  # noqa: PLR0913 - one per option of the command
    source: Path,
    selection: Sequence[str] | int,
    results: Path,
    out: Path | None,
    *,
    seconds: float,
    rivals: bool,
    as_json: bool,
) -> str:
    """Check cases of a grid; write check.json and check.html into `out`, default NAME-check below `results`.

    selection : words and ids, or how many of CHOICES.  Return the text, or JSON, for the terminal.
    """
    with announced_steps("check") as report_progress:
        report_progress("reading the grid")
        loaded = grid.load(source, scene.catalogue())
        start = "; those of a chain begin centred here" if loaded.chained else ""
        phases.print_line(f"check: {wording.count_text(len(loaded), 'case')} in the grid {loaded.name}{start}")
        directory = out or results / f"{loaded.name}-check"
        directory.mkdir(parents=True, exist_ok=True)
        words = CHOICES[:selection] if isinstance(selection, int) else selection
        options = Options(words, seconds, rivals, directory, results / loaded.name)
        try:
            result = measure(loaded, options, report_progress)
        except KeyboardInterrupt:
            raise KeyboardInterrupt("stopped; run the same command again to continue") from None
    from . import check_page  # with the report, pandas and 0.5 s, when the first lines are printed

    trees = [base_tree(loaded.written_case(index)) for index in result.pop("indices")]
    levels = [{name: [level.text for level in group] for name, group in levels_of(tree).items()} for tree in trees]
    content = json.dumps(result, indent=2, allow_nan=False)
    durable.replace(directory / "check.json", content.encode())
    page = check_page.write_page(result, levels, text_of_values(loaded), directory / "check.html")
    return content if as_json else f"{check_page.result_text(result, text_of_values(loaded))}\n{page}"


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
                count = f"{len(matching)} cases of the grid match" if matching else "no case of the grid matches"
                raise InputError(
                    f"--case {quoted(word)}: {count}; write {', '.join(CHOICES)}, or more of a case_id, as `clearsweep "
                    "run` prints them"
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
        report_progress(
            f"running {wording.count_text(len(indices), 'case')} at {SCREENING_TOLERANCE:g} to find the worst"
        )
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


def check_case(
    loaded: grid.Grid, index: int, labels: Sequence[str], book: Notebook, *, rivals: bool, report_progress: Report
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
        "measured_in": CLEARANCES if tree.get("joints") else "largest deformations",
        "values": {path: value for path, value in loaded.point(index).items() if value is not None},
    }
    truth = Truth(tree, tolerance)
    reference = book.piece(f"{case_id} reference", truth.summary)
    result |= reference or {"horizon_revolutions": None, "compared_revolutions": None, "reference": None}
    has_reference = reference is not None and reference["reference"]["tolerance"] is not None
    published = Truth(with_published_onset(tree), tolerance)
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
    missing = (reference or {}).get("reference", {}).get("why") or yours.get("why", "the time ran out")
    result["yours"] = {"tolerance": tolerance, "error": yours["error"], "milliseconds": yours["milliseconds"]}
    result["yours"] |= {"why": missing} if yours["error"] is None else {}
    result["order"] = fitted_order(ladder, (reference or {}).get("reference"))
    return result


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


WORTHWHILE = 0.1  # share of the run time below which a looser tolerance is not proposed
ENOUGH = 1e-6  # clearances: error of a journal that no figure of a report shows
TOO_LARGE = 1e-3  # clearances: error of a journal above which single peaks are doubtful
CLOSE_JOURNAL = "the journal within {:g} of its clearance, with its contacts in order"


def advice(cases: Sequence[Mapping[str, Any]], *, complete: bool) -> list[str]:
    """Return three sentences on what to do, from the checks of the cases; a further one if pieces are missing."""
    lines = [*_accuracy_sentences(cases), _stability_sentence(cases)]
    if not complete:
        lines.append("The time ran out before everything was measured; run the same command again to continue.")
    return lines


def _accuracy_sentences(cases: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return what the grid's tolerance achieves, and which tolerance to use, for the worst of the cases."""
    known = [case for case in cases if case["yours"]["error"] is not None]
    unknown = [
        f"The error at your tolerance is unknown{_in_case(case, cases)}: {case['yours']['why'].rstrip('.')}."
        for case in cases
        if case not in known
    ]
    if not known:
        return unknown[:1]
    worst = max(known, key=lambda case: case["yours"]["error"])
    yours, error = worst["yours"], worst["yours"]["error"]
    length = worst["compared_revolutions"]
    period = "half a revolution" if length == HALF else f"{length:.2g} revolutions, its predictable horizon"
    subject = f"the journal is within {error:.1g} of its clearance"
    if worst.get("measured_in", CLEARANCES) != CLEARANCES:
        subject = f"deformations are within {error:.1g} of their largest"
    first = (
        f"At your tolerance {yours['tolerance']:g} {subject} for {period}"
        f"{_in_case(worst, cases)}, in {yours['milliseconds']:.2g} ms a revolution."
    )
    return [" ".join([first, *unknown[:1]]), _tolerance_sentence(known, worst)]


def _in_case(case: Mapping[str, Any], cases: Sequence[Mapping[str, Any]]) -> str:
    return f" (case {case['case_id'][:8]})" if len(cases) > 1 else ""


def _tolerance_sentence(cases: Sequence[Mapping[str, Any]], worst: Mapping[str, Any]) -> str:
    """Return which tolerance to use: tighter if the error is too large, else the loosest that would do."""
    tolerance, error = worst["yours"]["tolerance"], worst["yours"]["error"]
    wanted = TOO_LARGE if error > TOO_LARGE else ENOUGH
    loosest = _loosest_with(cases, wanted)
    if loosest is None and error > TOO_LARGE:
        return f"No tolerance keeps {CLOSE_JOURNAL.format(TOO_LARGE)}; trust statistics only."
    if loosest is None:
        return f"Keep yours: no tolerance keeps {CLOSE_JOURNAL.format(ENOUGH)}."
    achieved = max(row["error"] for row in _rows_at(cases, loosest))
    ratio = _time_at(cases, loosest) / _time_at(cases, tolerance)
    if error > TOO_LARGE:
        return f"Use {loosest:g}: it keeps the journal within {achieved:.1g} of its clearance."
    if error > ENOUGH:
        more = 100.0 * max(ratio - 1.0, 0.0)
        return f"Keep yours, or use {loosest:g}: within {achieved:.1g} of the clearance for {more:.0f} % more time."
    if loosest <= tolerance:
        return f"A looser tolerance would err by more than {ENOUGH:g} of the clearance; keep yours."
    saved = 100.0 * (1.0 - ratio)
    if ratio > 1.0 - WORTHWHILE:
        return f"A looser tolerance saves no time worth having ({loosest:g}: {max(saved, 0.0):.0f} %); keep yours."
    return f"{loosest:g} would do with {achieved:.1g}, {saved:.0f} % faster."


def _rows_at(cases: Sequence[Mapping[str, Any]], tolerance: float) -> list[Mapping[str, Any]]:
    """Return the rows of `auto` at a tolerance, one for each case that has it."""
    rows = [row for case in cases for row in case["ladder"] if row["method"] == "auto"]
    return [row for row in rows if row["tolerance"] == tolerance and row["error"] is not None]


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
    """Return how many variants pass, and why the others fail."""
    tried, passed = (sum(case["stability"][name] for case in cases) for name in ("tried", "passed"))
    failed = [entry for case in cases for entry in case["stability"]["failed"]]
    if not tried:
        return "No variant was tried."
    if not failed:
        return f"All {tried} variants pass."
    kinds: dict[str, list[str]] = {}
    for entry in failed:
        kind, _, detail = entry["why"].partition(":")
        kinds.setdefault(kind, []).append(f"{entry['text']}:{detail.partition(';')[0].partition(' (')[0]}")
    named = [f"{len(texts)} by {kind}, the first is {texts[0]}" for kind, texts in kinds.items()]
    return f"{passed} of {tried} variants pass; {'; '.join(named)}."
