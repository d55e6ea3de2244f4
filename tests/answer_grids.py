"""Random grids with made-up figures, run with substitute mechanics, and the comparison of answers with the judge's."""

import copy
import json
import math
import tempfile
import zlib
from pathlib import Path
from typing import Any, NamedTuple

import answer_oracle as oracle
import pyarrow.parquet as pq
from fake_physics import Fake
from hypothesis import strategies as st
from judged_cases import core_of
from right_grids import grid_of

from clearsweep import grid as grids
from clearsweep import simulation
from clearsweep.contracts import results
from clearsweep.contracts.catalogue import ENDLESS, Figure
from clearsweep.contracts.layout import Layout
from clearsweep.store import record as store_record
from clearsweep.sweeping.sweep import Options, run_sweep

PEAK, IMPACTS, ONSET, ANGLE, IDEAL = (
    f"rod_slider_{name}" for name in ("force_peak", "impacts_per_rev", "onset_rate", "free_angle", "force_peak_ideal")
)
OWN = "reserve"  # a figure of the grid's own
#: The laws and figures of the program, and a figure whose null means infinite.
CATALOGUE = simulation.catalogue()._replace(
    figures=(
        *simulation.catalogue().figures,
        Figure("free_angle", "rad", "made up; null: no limit", of="joint", null=ENDLESS, differs=False),
    )
)
CLEARANCE, MASS, LENGTH = "joints.rod-slider.clearance", "mechanism.slider.mass", "mechanism.rod.length"
SPEED, FORCE, GRAVITY, SPRING = "drive.speed", "loads.press.force.0", "mechanism.gravity", "loads.back.stiffness"
LAW, SCALE = "joints.rod-slider.contact.law", "joints.rod-slider.friction.velocity_scale"
RESTITUTION, FRICTION = "joints.rod-slider.contact.restitution", "joints.rod-slider.friction.coefficient"
TOLERANCE, REVOLUTIONS = "simulate.tolerance", "simulate.revolutions"
LENGTH_DEFINED, SPEED_DEFINED, MIXED = "define.gap", "define.pace", "define.both"
BASE = grid_of("a crank under two loads")
#: Paths to vary, each with values of which a prefix is taken; a dict has labels.
VALUES: dict[str, list | dict] = {
    CLEARANCE: ["0.02 mm", "0.05 mm", "0.1 mm", "0.2 mm"],
    MASS: ["0.1 kg", "0.3 kg", "0.2 kg"],
    LENGTH: ["119.98 mm", "120 mm", "120.02 mm"],
    SPRING: ["0 N/m", "1 kN/m", "2 kN/m"],
    FRICTION: [0, 0.1, 0.2],
    RESTITUTION: [0.2, 0.5, 0.8],
    SPEED: ["500 rpm", "2000 rpm", "1000 rpm"],
    FORCE: ["-10 N", "0 N", "10 N"],
    GRAVITY: ["0 m/s^2", "9.81 m/s^2"],
    LAW: ["flores", "lankarani-nikravesh", "hertz"],
    SCALE: ["1 mm/s", "2 mm/s"],
    TOLERANCE: ["1e-4", "1e-9", "1e-6"],
    REVOLUTIONS: [3, 6, 4],
    LENGTH_DEFINED: ["20 um", "100 um", "50 um"],
    SPEED_DEFINED: ["500 rpm", "1500 rpm", "1000 rpm"],
    MIXED: [1, 2, 3],
}
LABELS, FITS = {"light": "0.1 kg", "heavy": "0.3 kg", "middle": "0.2 kg"}, {"fits": ["H7/g6", "H7/f7", "H7/e8"]}
DEFINED = {
    LENGTH_DEFINED: {CLEARANCE: "= gap"},
    SPEED_DEFINED: {SPEED: "= pace"},
    MIXED: {SPEED: "= both * '300 rpm'", MASS: "= half * '0.1 kg'"},
}
NUMBERS = (0.0, 0.0, 1.0, -1.0, 2.0, 5.0, 0.5, 0.3, -3.0, 1e-9, 100.0)


class Setting(NamedTuple):
    """A grid as a user writes it, and the numbers from which the figures of its cases are made up."""

    grid: dict[str, Any]
    weights: dict[str, list[float]]  # column -> weights of the axes
    chances: list[int]  # of a case, by its number: what is special in it
    given: tuple[tuple[str, dict[str, float | None]], ...] = ()  # status and figures of every case, if they are given


class MadeUp(Fake):
    """A substitute for the mechanics; `outcomes`: text of a case -> status and figures."""

    def __init__(self, outcomes: dict[str, tuple[str, dict]], formula=None):
        self.outcomes, self.formula = outcomes, formula

    @staticmethod
    def catalogue():
        """Return the laws and figures."""
        return CATALOGUE

    @staticmethod
    def signature(case):
        """Return what all cases share."""
        return 0

    @staticmethod
    def derived(case):
        """Return no values."""
        return {}

    @staticmethod
    def alternatives(case):
        """Return two laws."""
        return {LAW: ["hertz", "hunt-crossley"]}

    def solve(self, case, log=None):
        """Return the made-up figures of a case."""
        status, figures = self.outcomes[repr(case)] if repr(case) in self.outcomes else self.formula(case)
        columns = {column.name: 1 if column.kind == "int" else 1.0 for column in Layout.of(case, CATALOGUE).columns}
        if status != oracle.OK:
            return results.Trajectory(status, "made to fail", dict.fromkeys(columns))
        return results.Trajectory(oracle.OK, "", columns | figures)


def put(tree: dict, path: str, value: Any) -> None:
    """Put a value at a dotted path of a grid."""
    *sections, last = path.split(".")
    for key in sections:
        tree = tree[int(key)] if isinstance(tree, list) else tree[key]
    tree[int(last) if isinstance(tree, list) else last] = value


@st.composite
def settings_of_grids(draw) -> Setting:
    """Draw a grid and its made-up figures."""
    grid = copy.deepcopy(BASE)
    count = draw(st.sampled_from([1, 2, 2, 3, 3, 4]))
    paths = draw(st.lists(st.sampled_from([*VALUES]), min_size=count, max_size=count, unique=True))
    taken: set[str] = set()
    kept = []
    for path in paths:
        users = set(DEFINED.get(path, {path: ""}))
        if not users & taken:
            kept.append(path)
            taken |= users
    for path in kept:
        for user, text in DEFINED.get(path, {}).items():
            put(grid, user, text)
            grid.setdefault("define", {})[path.removeprefix("define.")] = VALUES[path][0]
        if path == MIXED:
            grid["define"]["half"] = "= both / 2"
    axes = {path: VALUES[path][: draw(st.sampled_from([1, 2, 2, 3, 3, 3]))] for path in kept}
    _arrange(draw, grid, axes)
    if draw(st.booleans()):
        _limit(draw, grid)
    if draw(st.integers(0, 3)) == 0:
        others = ["choice", "condition", "uncertainty", "model"]
        grid["roles"] = {
            path: draw(st.sampled_from([*others, "numerics"] if path == SCALE else others))
            for path in draw(st.lists(st.sampled_from(kept), min_size=1, max_size=2, unique=True))
        }
    weights = {
        column: draw(st.lists(st.sampled_from(NUMBERS), min_size=6, max_size=6))
        for column in (PEAK, IMPACTS, ONSET, ANGLE, IDEAL)
    }
    chances = draw(st.lists(st.integers(0, draw(st.sampled_from([30, 60, 1000]))), min_size=12, max_size=12))
    return Setting(grid, weights, chances)


def _arrange(draw, grid: dict, axes: dict[str, list]) -> None:
    """Put axes into sections of a grid."""
    how = draw(st.sampled_from(["sweep", "sweep", "sweep", "zip", "cases", "sample", "one-at-a-time"]))
    names = [*axes]
    drawable = [path for path in names if path not in (LAW, REVOLUTIONS, MIXED)]
    if LAW in names and RESTITUTION in names:
        how = "sweep"  # hertz uses no restitution, which is allowed in a product alone
    if how in ("zip", "cases") and names:
        tied = names[: draw(st.integers(1, len(names)))]
        product = [[]]
        for path in tied:
            product = [[*row, value] for row in product for value in axes[path]]
        rows = draw(st.lists(st.sampled_from(product), min_size=1, max_size=8, unique_by=repr))
        grid[how] = {path: [row[k] for row in rows] for k, path in enumerate(tied)}
        axes = {path: values for path, values in axes.items() if path not in tied}
    elif how in ("sample", "one-at-a-time") and drawable:
        drawn = drawable[: draw(st.integers(1, min(2, len(drawable))))]
        names, counts = st.sampled_from(["random", "latin-hypercube"]), st.sampled_from([2, 5, 8, 12])
        method = {"method": draw(names), "n": draw(counts)}
        over = {path: {"uniform": sorted(VALUES[path][:2], key=_size)} for path in drawn}
        grid["sample"] = (method if how == "sample" else {"method": "one-at-a-time"}) | {"over": over}
        axes = {path: values for path, values in axes.items() if path not in drawn}
    if axes:
        grid["sweep"] = dict(axes)
        if MASS in axes and draw(st.booleans()):
            grid["sweep"][MASS] = {name: LABELS[name] for name in [*LABELS][: len(axes[MASS])]}
        if CLEARANCE in axes and draw(st.booleans()):
            grid["sweep"][CLEARANCE] = {"fits": FITS["fits"][: len(axes[CLEARANCE])]}


def _size(value: Any) -> float:
    return float(str(value).split()[0]) * (1000.0 if " kN" in str(value) else 1.0)


def _limit(draw, grid: dict) -> None:
    """Put limits into a grid."""
    number = st.sampled_from([0, 0, 1, 2, -1, 5, 0.5, -3, 1000, 1000, 1000])
    limits: dict[str, Any] = {}
    for column in draw(
        st.lists(st.sampled_from([PEAK, IMPACTS, ONSET, ANGLE, OWN]), min_size=1, max_size=3, unique=True)
    ):
        kind = draw(st.sampled_from(["", "", "", "at_most", "at_least", "times", "both"]))
        if kind == "times":
            limits[column] = {draw(st.sampled_from(["at_most", "at_least"])): draw(number), "times": IDEAL}
        elif kind == "both":
            low, high = sorted(draw(st.lists(number, min_size=2, max_size=2)))
            limits[column] = {"at_least": low, "at_most": high}
        else:
            limits[column] = {kind: draw(number)} if kind else draw(number)
    units = {PEAK: "N", IMPACTS: "1", ONSET: "m/s", ANGLE: "rad", OWN: "1"}
    if OWN in limits:
        grid["figures"] = {OWN: draw(st.sampled_from([f"1 - {PEAK} / '2 N'", f"{PEAK} / {IDEAL}"]))}
    for column, bound in limits.items():
        text = units[column]
        if isinstance(bound, dict) and "times" in bound:
            text = {"N": "1"}.get(text, f"{text}/N")
        limits[column] = _with_unit(bound, text)
    grid["limits"] = limits


def _with_unit(bound: Any, unit: str) -> Any:
    if isinstance(bound, dict):
        return {key: part if key == "times" else _with_unit(part, unit) for key, part in bound.items()}
    return f"{bound} {unit}" if unit != "1" else bound


# --- runs ------------------------------------------------------------------------------------------------------------


class Judged(NamedTuple):
    """A run and what the judge needs to know about it."""

    answer: dict[str, Any]
    rows: list[oracle.Row]
    added: int
    roles: dict[str, str]
    limits: list[oracle.Bound]
    nulls: dict[str, str]  # column -> meaning of null
    texts: dict[str, dict[Any, str]]  # path -> value -> its label or fit
    sampled: bool
    one_at_a_time: bool
    summary: list[dict[str, Any]]
    written: dict[str, Any]


def figures_of(setting: Setting, grid: grids.Grid, number: int) -> tuple[str, dict[str, float | None]]:
    """Return the made-up status and figures of a case by its number."""
    if setting.given:
        status, figures = setting.given[number]
        return status, dict.fromkeys((PEAK, IMPACTS, ONSET, ANGLE, IDEAL), 1.0) | figures
    steps = []
    for path, value in grid.point(number).items():
        values = list(dict.fromkeys(grid.axes[path]))
        ordered = sorted((item for item in values if item is not None), key=lambda item: (isinstance(item, str), item))
        steps.append(ordered.index(value) if value is not None else 0)
    chance = setting.chances[number % len(setting.chances)] * 7 + number
    figures: dict[str, float | None] = {}
    for place, (column, weights) in enumerate(setting.weights.items()):
        value = weights[0] + sum(weight * step for weight, step in zip(weights[1:], steps, strict=False))
        value += weights[5] * (steps[0] * steps[-1] if len(steps) > 1 else 0.0)
        figures[column] = None if (chance + 11 * place) % 29 == 1 else value
        if (chance + 5 * place) % 37 == 3:
            figures[column] = 0.0
    status = "step-budget" if chance % 23 == 5 else "time-limit" if chance % 23 == 11 else oracle.OK
    return status, figures


def answered(setting: Setting) -> Judged:
    """Return the answer of the core to made-up figures, without a run."""
    written = copy.deepcopy(setting.grid)
    grid = grids.load(written, CATALOGUE)
    record = json.loads(store_record.record_bytes(grid, {}))
    outcomes = [figures_of(setting, grid, number) for number in range(len(grid))]
    stored: dict[str, dict[str, Any]] = {}
    for number, (status, made_up) in enumerate(outcomes):
        figures = made_up if status == oracle.OK else dict.fromkeys(made_up)
        row = {"case_id": grid.case_id(number), "status": status, **grid.point(number), **figures}
        stored.setdefault(row["case_id"], row | grid.verdict.evaluate_case(row, failed=status != oracle.OK))
    summary = [*stored.values()]
    columns = {name: [row[name] for row in summary] for name in summary[0]}
    return judged(setting, grid, summary, core_of(record, columns))


def run_of(setting: Setting, directory: Path, **options: Any) -> dict[str, Any]:
    """Run a grid with substitute mechanics and return its answer."""
    grid = grids.load(copy.deepcopy(setting.grid), CATALOGUE)
    outcomes = {repr(grid.case(number)): figures_of(setting, grid, number) for number in range(len(grid))}
    chosen = Options(executor="serial", show_progress=False)._replace(**options)
    run_sweep(copy.deepcopy(setting.grid), directory, chosen, MadeUp(outcomes))
    return json.loads((directory / "answer.json").read_text(encoding="utf-8"))


def judged(setting: Setting, grid: grids.Grid, summary: list[dict[str, Any]], answer: dict[str, Any]) -> Judged:
    """Return what the second judge needs to know about a run; `summary`: its rows."""
    stored = {row["case_id"]: row for row in summary}
    varied = [path for path, values in grid.axes.items() if len(set(values)) > 1]
    drawn = tuple(setting.grid.get("sample", {}).get("over", {}))
    roles = oracle.roles_of(varied, setting.grid, [grid.point(number) for number in range(len(grid))], drawn)
    rows, ids = [], set()
    is_search = bool({"seek", "optimise", "identify"} & setting.grid.keys())  # every case of which is tried by it
    for number in range(0 if is_search else len(grid)):
        case_id = grid.case_id(number)
        if case_id in ids:
            continue
        ids.add(case_id)
        row, point = stored.get(case_id), grid.point(number)
        figures = {} if row is None else {name: value for name, value in row.items() if name not in grid.axes}
        status = oracle.NOT_RUN if row is None else row["status"]
        rows.append(oracle.Row(case_id, {path: point[path] for path in varied}, status, figures))
    return Judged(
        answer,
        rows,
        len(stored.keys() - ids),
        roles,
        limits_of(grid),
        {column.name: column.null for column in grid.layout.columns},
        texts_of(grid),
        "sample" in setting.grid,
        setting.grid.get("sample", {}).get("method") == "one-at-a-time",
        summary,
        setting.grid,
    )


def limits_of(grid: grids.Grid) -> list[oracle.Bound]:
    """Return the limits of a grid, SI."""
    bounds = []
    for column, bound in grid.limits.items():
        parts = bound if isinstance(bound, dict) else {"at_most": bound}
        bounds += [
            oracle.Bound(column, kind, parts[kind], parts.get("times", ""))
            for kind in ("at_most", "at_least")
            if kind in parts
        ]
    return bounds


def texts_of(grid: grids.Grid) -> dict[str, dict[Any, str]]:
    """Return the labels and fits of values."""
    texts = {path: {value: label for label, value in labels.items()} for path, labels in grid.labels.items()}
    for path, fits in grid.fits.items():
        texts[path] = {fit.mean: fit.name for fit in fits}
    return texts


def shown(values: dict[str, Any], texts: dict[str, dict[Any, str]]) -> dict[str, Any]:
    """Return values as an answer shows them."""
    return {path: texts.get(path, {}).get(value, value) for path, value in values.items()}


def in_use(values: dict[str, Any]) -> dict[str, Any]:
    """Return the values that the laws of a design use."""
    return {path: value for path, value in values.items() if value is not None}


# --- comparison ------------------------------------------------------------------------------------------------------


def differences(run: Judged) -> list[str]:
    """Return every difference between an answer and the judge's."""
    answer, problems = run.answer, []

    def check(what: str, got: Any, allowed: Any) -> None:
        if got not in allowed:
            problems.append(f"{what}: {got!r}, not in {allowed!r}")

    check("roles", answer["roles"], [run.roles])
    finest, pairs = oracle.split_by_fineness(run.rows, run.roles)
    _compare_convergence(run, pairs, check)
    _compare_columns(run, check)
    if not run.limits:
        check("cases", answer["cases"], [None])
        check("designs", answer["designs"], [[]])
    elif not run.rows:
        check("cases", answer["cases"], [{"met": 0, "exceeded": 0, "undecided": 0, "added": run.added}])
        check("designs", answer["designs"], [[]])
    else:
        verdicts = [oracle.verdict_of_case(row, run.limits, run.nulls) for row in finest]
        counts = {word: verdicts.count(word) for word in (oracle.MET, oracle.EXCEEDED, oracle.UNDECIDED)}
        check("cases", answer["cases"], [counts | {"added": run.added}])
        _compare_designs(run, finest, check)
    if not {"seek", "optimise", "identify"} & run.written.keys():
        _compare_effects(run, finest, check)
    sections = [name for name in ("life", "seek", "refine", "optimise", "identify") if name in run.written]
    question = sections[0] if sections else "limits" if run.limits else "force"
    is_mixed = run.one_at_a_time or "sweep" in run.written
    questions = {question} if not run.sampled else {"sample", question} if is_mixed else {"sample"}
    check("question", answer["question"], questions)
    check("complete", answer["complete"], [all(row.status != oracle.NOT_RUN for row in run.rows)])
    return problems


def _compare_convergence(run: Judged, pairs: list, check) -> None:
    """Compare what numerics say; of several of them only the figures and paths."""
    numerics = [path for path, role in run.roles.items() if role == oracle.NUMERICS]
    entries = run.answer["convergence"]
    check("paths of convergence", all(entry["path"] in numerics for entry in entries), [True])
    for figure in {limit.column for limit in run.limits} if len(numerics) == 1 else ():
        expected = oracle.convergence_of(pairs, figure, numerics[0])
        listed = [entry["difference"] for entry in entries if entry["figure"] == figure]
        numbers = [math.inf if difference is None else difference for difference in listed]
        check(f"differences of {figure}: {numbers}, {expected}", _same_numbers(numbers, [*expected.values()]), [True])


def _same_numbers(numbers: list[float], others: list[float]) -> bool:
    return len(numbers) == len(others) and all(
        a == b or math.isclose(a, b, rel_tol=1e-9) for a, b in zip(sorted(numbers), sorted(others), strict=True)
    )


def _compare_columns(run: Judged, check) -> None:
    """Compare the columns of the summary."""
    if not run.limits:
        return
    stored = {row["case_id"]: row for row in run.summary}
    for row in run.rows:
        columns = stored.get(row.case_id)
        if columns is None:
            continue
        exceeded, undecided = (
            set(filter(None, (columns[name] or "").split(","))) for name in ("limits_exceeded", "limits_undecided")
        )
        check(f"limits_exceeded of {row}", exceeded, [oracle.named(row, run.limits, run.nulls, oracle.EXCEEDED)])
        allowed = [oracle.named(row, run.limits, run.nulls, oracle.UNDECIDED) - exceeded]
        allowed += [oracle.named(row, run.limits, run.nulls, oracle.UNDECIDED)]
        check(f"limits_undecided of {row}", undecided, allowed if row.status == oracle.OK else [set(), *allowed])
        margin = oracle.margin_of(row, run.limits, run.nulls)
        check(f"margin of {row}", _close(columns["margin"], margin), [True, (columns["margin"], margin)][:1])


def _close(number: float | None, other: float | None) -> bool:
    if number is None or other is None:
        return number is other
    return math.isclose(number, other, rel_tol=1e-9, abs_tol=1e-300) or (abs(number) > 1e300 and abs(other) > 1e300)


def _compare_designs(run: Judged, finest: list[oracle.Row], check) -> None:
    answer = run.answer
    if run.one_at_a_time:
        check("designs of one-at-a-time", answer["designs"], [[]])
        return
    drawn = tuple(run.written.get("sample", {}).get("over", {}))
    expected = oracle.designs_of(finest, run.roles, run.limits, run.nulls, drawn)
    listed = answer["designs"]
    check("designs_total", answer["designs_total"], [len(expected)])
    check("listed designs", len(listed), [min(len(expected), oracle.MOST_DESIGNS)])
    order = [design["verdict"] for design in listed]
    check("order", order, [sorted(order, key=["meets", "undecided", "exceeds"].index)])
    check("order of margins", oracle.is_sorted([d["margin"] for d in listed if d["verdict"] == "meets"]), [True])
    for design in expected:
        values = shown(design.values, run.texts)
        same = [entry for entry in listed if in_use(entry["values"]) == in_use(values)]
        check(f"designs with {values}", len(same), [1] if len(listed) == len(expected) else [0, 1])
        for entry in same:
            _compare_design(run, design, entry, check)


def _compare_design(run: Judged, design: oracle.Design, entry: dict, check) -> None:
    name = f"of design {entry['values']}"
    for key in ("verdict", "conditions", "met", "exceeded"):
        check(f"{key} {name}", entry[key], [getattr(design, key)])
    check(f"undecided {name}", entry["undecided"], [design.undecided, len(design.missing)])
    check(f"missing_total {name}", entry["missing_total"], [len(design.missing)])
    check(f"missing {name}", len(entry["missing"]), [min(len(design.missing), oracle.MOST_MISSING)])
    reasons = [(in_use(shown(values, run.texts)), why) for values, why in design.missing]
    for hole in entry["missing"]:
        allowed = [why for values, why in reasons if values == in_use(hole["values"])]
        check(f"missing values {name}", in_use(hole["values"]), [values for values, _ in reasons])
        check(f"why of {hole['values']} {name}", hole["why"], [word for why in allowed for word in why.split("|")])
    check(f"worst {name}", entry["worst"], design.worst)
    check(f"margin {name} {entry['margin']}", any(_close(entry["margin"], m) for m in design.margins), [True])
    check(f"limit {name}", entry["limit"], design.deciding.get(entry["worst"], set()))
    size = design.excesses.get(entry["worst"], {}).get(entry["limit"])
    has_excess = design.verdict == "exceeds" and entry["margin"] is None and size is not None
    if has_excess or design.verdict != "exceeds":
        check(f"excess {name} {entry['excess']} {size}", _close(entry["excess"], size if has_excess else None), [True])
    if any(run.roles.get(path) not in (None, oracle.CHOICE) for path in run.written.get("sample", {}).get("over", {})):
        share, draws = entry["share"], design.draws
        count = sum(draws)
        check(f"draws {name}", share["draws"], [count])
        for key, number in zip(("met", "exceeded", "undecided"), draws, strict=True):
            check(f"{key} in share {name} {share} {draws}", _close(share[key], number / count), [True])
        if run.written["sample"]["method"] != "saltelli":  # the draws of which are not independent
            check(f"interval of share {name}", 0.0 <= share["low"] <= share["met"] <= share["high"] <= 1.0, [True])


def _compare_effects(run: Judged, finest: list[oracle.Row], check) -> None:
    axes = oracle.axes_of(finest, run.roles) if run.roles else []
    reported = {(effect["figure"], effect["path"]): effect for effect in run.answer["effects"]}
    numerics = {path for path, role in run.roles.items() if role == oracle.NUMERICS}
    for (figure, path), effect in reported.items():
        name = f"effect of {path} on {figure}"
        check(f"{name}: path", path, set(run.roles) - numerics)
        if effect["method"] == "ranks":
            check(f"{name}: method of a sample", run.sampled, [True])
            if direction := oracle.direction_of_draws(finest, run.roles, figure, path):
                check(f"{name}: verdict", effect["verdict"], [direction])
            continue
        if any(row.figures.get(figure) in (math.inf, -math.inf) for row in finest):
            continue
        expected = oracle.effect_of(finest, run.roles, figure, path)
        check(f"{name}: verdict", effect["verdict"], expected.verdicts)
        check(f"{name}: pairs", effect["pairs"], [expected.pairs])
        if expected.start is not None:
            check(f"{name}: from {effect['from']}", _close(effect["from"], expected.start), [True])
            check(f"{name}: to {effect['to']}", _close(effect["to"], expected.end), [True])
        if effect["verdict"] == "differs":
            texts = run.texts.get(path, {})
            check(f"{name}: lowest", effect["lowest"], {texts.get(v, v) for v in expected.lowest})
            check(f"{name}: highest", effect["highest"], {texts.get(v, v) for v in expected.highest})
    if run.sampled:
        return
    for limit in run.limits:
        if limit.times or not any(row.figures.get(limit.column) is not None for row in finest):
            continue
        for axis in axes:
            check(
                f"an effect of {axis} on {limit.column}", any((limit.column, path) in reported for path in axis), [True]
            )


def run_and_judged(setting: Setting, **options: Any) -> Judged:
    """Run a grid with substitute mechanics in a directory of its own."""
    with tempfile.TemporaryDirectory() as folder:
        directory = Path(folder) / "run"
        answer = run_of(setting, directory, **options)
        summary = pq.read_table(directory / "summary.parquet").to_pylist()
    return judged(setting, grids.load(copy.deepcopy(setting.grid), CATALOGUE), summary, answer)


def formula(case) -> tuple[str, dict[str, float | None]]:
    """Return made-up figures that grow with clearance and mass; some cases fail, some figures are null."""
    clearance, mass = case.joints[0].clearance, case.mechanism.values["slider.mass"]
    chance = zlib.crc32(repr((clearance, mass, case.joints[0].contact.law)).encode())  # whatever else a case may have
    size = 1e4 * clearance * (1.0 + mass)
    if chance % 17 == 3:
        return "step-budget", {}
    figures: dict[str, float | None] = {PEAK: size, IMPACTS: float(max(0, round(4.0 * size - 2.0))), ONSET: size - 1.0}
    return oracle.OK, figures | ({ONSET: None} if chance % 5 == 1 else {}) | (
        {IMPACTS: None} if chance % 19 == 2 else {}
    )


def search_and_judged(grid: dict[str, Any], directory: Path, **options: Any) -> Judged:
    """Run a grid that adds cases with figures by formula."""
    chosen = Options(executor="serial", show_progress=False)._replace(**options)
    run_sweep(copy.deepcopy(grid), directory, chosen, MadeUp({}, formula))
    answer = json.loads((directory / "answer.json").read_text(encoding="utf-8"))
    summary = pq.read_table(directory / "summary.parquet").to_pylist()
    return judged(Setting(grid, {}, [0]), grids.load(copy.deepcopy(grid), CATALOGUE), summary, answer)
