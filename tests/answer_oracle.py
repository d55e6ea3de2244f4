"""A second judge of runs: the answers of a grid by plain loops, written from the manual without the program's code.

Slow and obvious on purpose.  Where the manual leaves a choice, a function returns every allowed result.
"""

import math
from itertools import pairwise
from statistics import median
from typing import Any, NamedTuple

CHOICE, CONDITION, MODEL, NUMERICS, UNCERTAINTY = "choice", "condition", "model", "numerics", "uncertainty"
ROLES = (CONDITION, UNCERTAINTY, MODEL, CHOICE, NUMERICS)  # the first that occurs is the role of a defined quantity
MET, EXCEEDED, UNDECIDED = "met", "exceeded", "undecided"
NOT_RUN, OK = "not run", "ok"
NOTHING, ENDLESS = "nothing", "endless"  # meanings of a null figure: nothing to measure, infinite
NAMES_OF_LAWS = ("law", "elastic", "onset", "pressure", "walls")
SMOOTHING = ("v0", "v1", "velocity_scale")
SPRING_KEYS = (
    "stiffness",
    "damping",
    "free_length",
    "anchor",
    "torsional_stiffness",
    "torsional_damping",
    "free_angle",
)
MOST_MISSING, MOST_DESIGNS = 20, 1000
NO_CHANGE = 0.01  # of the larger end: a smaller difference is none
TURN = 0.1  # of a block's range: turning back by more makes an effect mixed
SIGNIFICANT = 0.05


class Row(NamedTuple):
    """A case: the values of the varied paths, its status, its stored figures (None: null)."""

    case_id: str
    values: dict[str, Any]  # path -> SI or text; None: its laws do not use it
    status: str  # OK, NOT_RUN or the word of a failure
    figures: dict[str, float | None]


class Bound(NamedTuple):
    """A limit of the grid."""

    column: str
    kind: str  # 'at_most' or 'at_least'
    number: float
    times: str = ""


# --- roles -----------------------------------------------------------------------------------------------------------


def role_of_key(path: str) -> str:
    """Return the role of a path of a grid that is no defined quantity."""
    words = path.split(".")
    last = words[-1] if not words[-1].isdigit() else words[-2]
    if path in ("simulate.direction", "simulate.draw"):  # each start is a condition that a design must meet
        return CONDITION
    if words[0] == "simulate" or last in ("segments", "bending"):
        return NUMERICS
    if words[0] == "drive":
        return CHOICE if path == "drive.inertia" else CONDITION
    if words[0] == "loads":
        return _role_in_load(words, last)
    if words[0] == "mechanism":
        return CONDITION if "gravity" in words or "initial" in words or path == "mechanism.speed" else CHOICE
    return _role_in_joint(words, last) if words[0] == "joints" else CONDITION


def _role_in_load(words: list[str], last: str) -> str:
    if "friction" in words and (last in NAMES_OF_LAWS or last in SMOOTHING):
        return MODEL
    if "friction" not in words and last in SPRING_KEYS:
        return CHOICE
    return CONDITION


def _role_in_joint(words: list[str], last: str) -> str:
    if last in ("preload", "ambient", "tilt", "offset") or words[-2:] == ["film", "temperature"]:
        return CONDITION
    if last in NAMES_OF_LAWS or words[-2:] in (["film", "friction"], ["film", "limit"]):
        return MODEL
    if last in SMOOTHING or "transition" in words:
        return MODEL
    return CHOICE


def names_in(text: str) -> set[str]:
    """Return the words of an expression outside quotes."""
    outside = "".join(part for k, part in enumerate(text.replace('"', "'").split("'")) if k % 2 == 0)
    for sign in "=+-*/(),":
        outside = outside.replace(sign, " ")
    return set(outside.split())


def leaves(tree: Any, path: str = "") -> dict[str, Any]:
    """Return dotted path -> value of everything in a grid."""
    if isinstance(tree, dict):
        return {key: value for name, part in tree.items() for key, value in leaves(part, f"{path}{name}.").items()}
    if isinstance(tree, list):
        return {key: value for k, part in enumerate(tree) for key, value in leaves(part, f"{path}{k}.").items()}
    return {path[:-1]: tree}


def role_of(path: str, grid: dict, drawn: tuple[str, ...] = ()) -> str:
    """Return the role of a varied path of a grid, a dict as a user writes it; `drawn`: what `sample` varies."""
    if path in grid.get("roles", {}):
        return grid["roles"][path]
    if path in drawn:
        return UNCERTAINTY
    if not path.startswith("define."):
        return role_of_key(path)
    used, before = {path.removeprefix("define.")}, set()
    while used != before:  # names that are made of these names
        before = set(used)
        for name, text in grid["define"].items():
            if isinstance(text, str) and text.strip().startswith("=") and names_in(text) & used:
                used.add(name)
    sections = {key: part for key, part in grid.items() if key in ("mechanism", "drive", "loads", "joints", "simulate")}
    assigned = {
        grid.get("roles", {}).get(user, role_of_key(user))
        for user, text in leaves(sections).items()
        if isinstance(text, str) and text.strip().startswith("=") and names_in(text) & used
    }
    return next(role for role in ROLES if role in assigned)


def roles_of(paths: list[str], grid: dict, points: list[dict[str, Any]], drawn: tuple[str, ...] = ()) -> dict[str, str]:
    """Return the role of each varied path; `points`: the values of every case.

    In `zip` and `cases` a condition that the choices of its row determine is part of the design.
    """
    roles = {path: role_of(path, grid, drawn) for path in paths}
    for section in ("zip", "cases"):
        tied = [path for path in grid.get(section, {}) if path in roles]
        choices = [path for path in tied if roles[path] == CHOICE]
        for path in tied if choices else ():
            seen: dict[tuple, set] = {}
            for point in points:
                seen.setdefault(tuple(point[choice] for choice in choices), set()).add(point[path])
            is_given = path in grid.get("roles", {})
            if roles[path] in (CONDITION, MODEL) and not is_given and all(len(values) == 1 for values in seen.values()):
                roles[path] = CHOICE
    return roles


# --- cases -----------------------------------------------------------------------------------------------------------


def bound_of(limit: Bound, row: Row) -> float | None:
    """Return the bound of a case, or None if the column that it is a multiple of is null."""
    if not limit.times:
        return limit.number
    times = row.figures.get(limit.times)
    return None if times is None else limit.number * times


def verdict_of_limit(limit: Bound, row: Row, nulls: dict[str, str]) -> str:
    """Return whether a case meets one limit."""
    if row.status != OK:
        return UNDECIDED
    value, bound = row.figures.get(limit.column), bound_of(limit, row)
    if value is None and nulls.get(limit.column) == NOTHING:
        return MET
    if bound is None or math.isnan(bound):
        return UNDECIDED
    if value is None and nulls.get(limit.column) == ENDLESS:
        value = math.inf
    if value is None:
        return UNDECIDED
    beyond = value > bound if limit.kind == "at_most" else value < bound
    return EXCEEDED if beyond else MET


def verdict_of_case(row: Row, limits: list[Bound], nulls: dict[str, str]) -> str:
    """Return whether a case meets all limits."""
    verdicts = [verdict_of_limit(limit, row, nulls) for limit in limits]
    if EXCEEDED in verdicts:
        return EXCEEDED
    return UNDECIDED if UNDECIDED in verdicts else MET


def named(row: Row, limits: list[Bound], nulls: dict[str, str], verdict: str) -> set[str]:
    """Return the columns of the limits with this verdict."""
    return {limit.column for limit in limits if verdict_of_limit(limit, row, nulls) == verdict}


def margin_of(row: Row, limits: list[Bound], nulls: dict[str, str]) -> float | None:
    """Return the margin of a case, or None."""
    verdict = verdict_of_case(row, limits, nulls)
    if verdict == UNDECIDED:
        return None
    margins = []
    for limit in limits:
        value, bound = row.figures.get(limit.column), bound_of(limit, row)
        if value is None or bound is None or bound == 0.0 or not math.isfinite(bound):
            continue  # an infinite figure has no distance
        distance = bound - value if limit.kind == "at_most" else value - bound
        margins.append(distance / abs(bound))
    if not margins or (verdict == EXCEEDED and min(margins) >= 0.0):
        return None
    return min(margins)


def excesses_of(row: Row, limits: list[Bound], nulls: dict[str, str]) -> dict[str, float]:
    """Return column -> absolute excess of the exceeded limits whose bound is 0."""
    return {
        limit.column: abs(row.figures[limit.column])
        for limit in limits
        if bound_of(limit, row) == 0.0
        and verdict_of_limit(limit, row, nulls) == EXCEEDED
        and row.figures.get(limit.column) is not None
    }


# --- which cases count -----------------------------------------------------------------------------------------------


def convergence_of(pairs: list[tuple[Row, Row]], figure: str, path: str) -> dict[Any, float]:
    """Return coarser value of the only numerics path -> largest relative difference of a figure from the finest."""
    largest: dict[Any, float] = {}
    for finest, coarser in pairs:
        value, other = finest.figures.get(figure), coarser.figures.get(figure)
        if finest.status != OK or coarser.status != OK or value is None or other is None:
            continue
        difference = abs(other - value) / abs(value) if value else 0.0 if other == 0.0 else math.inf
        largest[coarser.values[path]] = max(difference, largest.get(coarser.values[path], 0.0))
    return largest


def is_finer(path: str, value: Any, other: Any) -> bool:
    """Return whether a setting is finer than another: a smaller tolerance or smoothing, else the larger number."""
    return value < other if path.endswith(("tolerance", *SMOOTHING)) else value > other


def split_by_fineness(rows: list[Row], roles: dict[str, str]) -> tuple[list[Row], list[tuple[Row, Row]]]:
    """Return the finest of the rows that differ in numerics alone, and pairs of (finest, coarser)."""
    numerics = [path for path, role in roles.items() if role == NUMERICS]
    finest: list[Row] = []
    for row in rows:
        rivals = [other for other in rows if equal_but(row, other, numerics)]
        if not any(_beats(other, row, numerics) for other in rivals):
            finest.append(row)
    coarser = [(best, row) for best in finest for row in rows if row is not best and equal_but(row, best, numerics)]
    return finest, coarser


def _beats(row: Row, other: Row, numerics: list[str]) -> bool:
    """Return whether a row is finer: the first setting in which they differ decides."""
    for path in numerics:
        if row.values[path] != other.values[path]:
            return is_finer(path, row.values[path], other.values[path])
    return False


def equal_but(row: Row, other: Row, excepted: list[str]) -> bool:
    """Return whether two rows have the same values elsewhere."""
    return all(row.values[path] == other.values[path] for path in row.values if path not in excepted)


# --- designs ---------------------------------------------------------------------------------------------------------


def fits_into(part: dict, whole: dict) -> bool:
    """Return whether the values that are in use agree."""
    return all(value is None or value == whole[path] for path, value in part.items())


def distinct(tuples: list[dict]) -> list[dict]:
    """Return the distinct tuples; one with unused values is part of those which agree elsewhere, if there are any."""
    different: list[dict] = []
    for entry in tuples:
        if entry not in different:
            different.append(entry)
    return [entry for entry in different if not any(other != entry and fits_into(entry, other) for other in different)]


class Design(NamedTuple):
    """What is said of a design."""

    values: dict[str, Any]
    verdict: str  # 'meets', 'exceeds' or 'undecided'
    conditions: int
    met: int
    exceeded: int
    undecided: int  # cases; holes are `missing` alone
    missing: list[tuple[dict, str]]
    margins: set[float | None]
    worst: set[str | None]
    excesses: dict[str, dict[str, float]]  # of the worst cases: case_id -> column -> excess
    deciding: dict[str | None, set[str | None]]  # of the worst cases: case_id -> columns of which one is named
    draws: tuple[int, int, int]  # of a sample: draws that meet, exceed, are undecided


def designs_of(
    rows: list[Row], roles: dict[str, str], limits: list[Bound], nulls: dict[str, str], drawn: tuple[str, ...] = ()
) -> list[Design]:
    """Return the designs of judged rows, in no order; `drawn`: the paths that a sample varies."""
    choices = [path for path, role in roles.items() if role == CHOICE]
    others = [path for path, role in roles.items() if role in (CONDITION, MODEL, UNCERTAINTY)]
    design_values = distinct([{path: row.values[path] for path in choices} for row in rows])
    conditions = distinct([{path: row.values[path] for path in others} for row in rows])
    return [_design(values, conditions, rows, (choices, others, drawn), limits, nulls) for values in design_values]


def _design(values, conditions, rows, paths, limits, nulls) -> Design:
    choices, others, drawn = paths
    draws: dict[tuple, list[str]] = {}
    met, exceeded, undecided, missing = [], [], [], []
    for condition in conditions:
        row = next(
            (
                row
                for row in rows
                if fits_into({path: row.values[path] for path in choices}, values)
                and fits_into({path: row.values[path] for path in others}, condition)
            ),
            None,
        )
        draw = draws.setdefault(tuple(condition.get(path) for path in drawn), [])
        if row is None:
            missing.append((condition, NOT_RUN))
            draw.append(UNDECIDED)
            continue
        verdict = verdict_of_case(row, limits, nulls)
        draw.append(verdict)
        {MET: met, EXCEEDED: exceeded, UNDECIDED: undecided}[verdict].append(row)
        if verdict == UNDECIDED:
            missing.append((condition, why_undecided(row, limits, nulls)))
    verdict = "exceeds" if exceeded else "undecided" if missing else "meets"
    decisive = exceeded or (undecided if missing else met)
    decisive = [row for row in decisive if row.status != NOT_RUN]  # nobody can look up a case that was not run
    margins = {row.case_id: margin_of(row, limits, nulls) for row in decisive}
    least = None if None in margins.values() else min(margins.values(), default=None)
    worst = {case_id for case_id, margin in margins.items() if margin == least} or {None}
    worst_rows = [row for row in decisive if row.case_id in worst]
    return Design(
        values,
        verdict,
        len(conditions),
        len(met),
        len(exceeded),
        len(undecided),
        missing,
        {least},
        worst,
        {row.case_id: excesses_of(row, limits, nulls) for row in worst_rows},
        {None: {None}} | {row.case_id: deciding_limits(row, limits, nulls) for row in worst_rows},
        (
            sum({*verdicts} == {MET} for verdicts in draws.values()),
            sum(EXCEEDED in verdicts for verdicts in draws.values()),
            sum(EXCEEDED not in verdicts and UNDECIDED in verdicts for verdicts in draws.values()),
        ),
    )


def deciding_limits(row: Row, limits: list[Bound], nulls: dict[str, str]) -> set[str | None]:
    """Return the columns of which one is named as the limit that decides a case."""
    verdict, margin = verdict_of_case(row, limits, nulls), margin_of(row, limits, nulls)
    if verdict == MET and margin is None:
        return {None, *(limit.column for limit in limits)}
    if verdict == UNDECIDED:
        return {None, *named(row, limits, nulls, UNDECIDED)}
    if margin is None:
        return {*named(row, limits, nulls, EXCEEDED)}
    return {limit.column for limit in limits if margin_of(row, [limit], nulls) == margin}


def why_undecided(row: Row, limits: list[Bound], nulls: dict[str, str]) -> str:
    """Return why a case is undecided: its status, or the columns that are null, one of which may be named."""
    if row.status != OK:
        return row.status
    columns = []
    for limit in limits:
        if verdict_of_limit(limit, row, nulls) == UNDECIDED:
            columns += [name for name in (limit.column, limit.times) if name and row.figures.get(name) is None]
    return "|".join(f"{column} is null" for column in columns)


# --- effects ---------------------------------------------------------------------------------------------------------


def axes_of(rows: list[Row], roles: dict[str, str]) -> list[list[str]]:
    """Return the axes, each with the paths that fix one another; numerics are no axes."""
    axes: list[list[str]] = []
    for path in [path for path, role in roles.items() if role != NUMERICS]:
        for axis in axes:
            if fix_one_another(rows, axis[0], path):
                axis.append(path)
                break
        else:
            axes.append([path])
    return axes


def fix_one_another(rows: list[Row], path: str, other: str) -> bool:
    """Return whether each value of a path occurs with one value of the other alone, and the other way round."""
    pairs = {(row.values[path], row.values[other]) for row in rows}
    return len({first for first, _ in pairs}) == len(pairs) == len({second for _, second in pairs})


class Expected(NamedTuple):
    """What may be said of an effect."""

    verdicts: set[str]
    pairs: int
    start: float | None  # median at the low end
    end: float | None
    lowest: frozenset = frozenset()
    highest: frozenset = frozenset()


def effect_of(rows: list[Row], roles: dict[str, str], figure: str, path: str) -> Expected:
    """Return the effect of the axis of a path on a figure."""
    axis = next(axis for axis in axes_of(rows, roles) if path in axis)
    others = [other for other in roles if other not in axis and roles[other] != NUMERICS]
    values = {row.values[path] for row in rows if row.values[path] is not None}
    is_text = any(isinstance(value, str) for value in values)
    blocks: list[list[Row]] = []
    for row in rows:
        if row.status != OK or row.figures.get(figure) is None or row.values[path] is None:
            continue
        for block in blocks:
            if all(block[0].values[other] == row.values[other] for other in others):
                block.append(row)
                break
        else:
            blocks.append([row])
    if is_text:
        return _text_effect(blocks, figure, path, values)
    low, high = min(values), max(values)
    pairs = []
    for block in blocks:
        at = {row.values[path]: row.figures[figure] for row in block}
        if low in at and high in at:
            pairs.append([at[value] for value in sorted(at)])
    if not pairs:
        return Expected({"not-decided"}, 0, None, None)
    return Expected(
        verdicts_of_pairs(pairs), len(pairs), median(run[0] for run in pairs), median(run[-1] for run in pairs)
    )


def direction_of_draws(rows: list[Row], roles: dict[str, str], figure: str, path: str) -> str:
    """Return the effect of the only varied path where all of at least eight draws agree, else ''."""
    values = [(row.values[path], row.figures.get(figure)) for row in rows]
    if len(roles) > 1 or len(rows) < 8 or any(figure is None for _, figure in values):
        return ""
    figures = [figure for _, figure in sorted(values)]
    if all(b - a > 2.0 * NO_CHANGE * max(abs(a), abs(b)) for a, b in pairwise(figures)):
        return "rises"
    return "falls" if all(a - b > 2.0 * NO_CHANGE * max(abs(a), abs(b)) for a, b in pairwise(figures)) else ""


def is_none(start: float, end: float) -> bool:
    """Return whether a difference counts as none."""
    return abs(end - start) <= NO_CHANGE * max(abs(start), abs(end))


def verdicts_of_pairs(pairs: list[list[float]]) -> set[str]:
    """Return the allowed verdicts on blocks, each the figures along the axis."""
    ups = sum(run[-1] > run[0] and not is_none(run[0], run[-1]) for run in pairs)
    downs = sum(run[-1] < run[0] and not is_none(run[0], run[-1]) for run in pairs)
    if not ups and not downs:
        base = "none"
    elif not downs or (ups > downs and sign_test(ups, downs) <= SIGNIFICANT):
        base = "rises"
    elif not ups or (downs > ups and sign_test(ups, downs) <= SIGNIFICANT):
        base = "falls"
    else:
        base = "mixed"
    turned = [turns_back(run) for run in pairs]
    if "yes" in turned:
        return {"mixed"}
    return {base, "mixed"} if "perhaps" in turned else {base}


def turns_back(run: list[float]) -> str:
    """Return 'yes' if a block turns back by more than a tenth of its range, 'perhaps' if its range is next to none."""
    span = max(run) - min(run)
    if span == 0.0:
        return "no"
    drop = max((a - b for k, a in enumerate(run) for b in run[k:]), default=0.0)
    climb = max((b - a for k, a in enumerate(run) for b in run[k:]), default=0.0)
    back = drop if run[-1] > run[0] else climb if run[-1] < run[0] else min(drop, climb)
    if abs(back / span - TURN) < 1e-9:
        return "perhaps"
    if back <= TURN * span:
        return "no"
    return "perhaps" if span <= NO_CHANGE * max(map(abs, run)) else "yes"


def sign_test(ups: int, downs: int) -> float:
    """Return the two-sided probability of so uneven a split of equally likely signs."""
    count, fewer = ups + downs, min(ups, downs)
    return min(1.0, 2.0 * sum(math.comb(count, k) for k in range(fewer + 1)) / 2.0**count)


def _text_effect(blocks: list[list[Row]], figure: str, path: str, values: set) -> Expected:
    """Return the effect of names: whether the figure differs within a block that has all of them."""
    full = [block for block in blocks if len({row.values[path] for row in block}) == len(values)]
    if not full:
        return Expected({"not-decided"}, 0, None, None)
    medians = {
        value: median(row.figures[figure] for block in full for row in block if row.values[path] == value)
        for value in values
    }
    least, most = min(medians.values()), max(medians.values())
    differ = [
        not is_none(min(row.figures[figure] for row in block), max(row.figures[figure] for row in block))
        for block in full
    ]
    return Expected(
        {"differs"} if any(differ) else {"none"},
        len(full),
        None,
        None,
        frozenset(value for value, size in medians.items() if size == least),
        frozenset(value for value, size in medians.items() if size == most),
    )


def is_sorted(values: list[float | None]) -> bool:
    """Return whether numbers fall; None may be anywhere."""
    numbers = [value for value in values if value is not None]
    return all(a >= b for a, b in pairwise(numbers))
