"""Judges the cases of a run: which designs meet the limits under every condition, and what drives the figures.

Everything follows from the run's record and the columns of its summary; no file is read and nothing is worded here.
The result of `judge` is the answer: a dict of plain values that terminal, page and answer.json share.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from typing import Any

import numpy as np

from ..contracts import roles
from . import blocks, verdict
from .probability import ONE_AT_A_TIME, RANDOM_METHODS, binomial_interval
from .verdict import Assessment, Limit

MET, EXCEEDED, UNDECIDED = "met", "exceeded", "undecided"  # verdicts of a case
VERDICTS = {MET: "meets", UNDECIDED: "undecided", EXCEEDED: "exceeds"}  # verdict of its cases -> of a design, in order
NOT_RUN = "not run"
MAX_DESIGNS, MAX_MISSING = 1000, 20  # entries of a list in the answer
#: Last keys of numerical settings of which the smaller value is the finer one; of all others it is the larger one.
FINER_IF_SMALLER = ("tolerance", "velocity_scale", "v0", "v1", "width", "from")

Key = tuple[int, ...]  # codes of the values at some paths, -1 where the case does not use a path


class Cases:
    """The judged cases of a run, with the codes of their varied values."""

    def __init__(
        self, record: Mapping[str, Any], columns: Mapping[str, Any], own: Sequence[bool] | np.ndarray | None = None
    ):
        """Prepare the cases of a grid.

        record : run.json; columns : (n,) each, by name; own : (n,) mask of the grid's own cases, default all
        """
        self.record = record
        is_own = np.ones(len(columns["case_id"]), bool) if own is None else np.asarray(own, bool)
        self.added_count = int((~is_own).sum())
        self._columns = columns
        self.role_by_path: dict[str, str] = dict(record.get("roles") or {})
        self._rows = np.flatnonzero(is_own)
        self.paths = [path for path in self.role_by_path if self._is_varied(path)]
        self.coarse_rows = np.zeros(0, int)
        numerics = self.paths_of(roles.NUMERICS)
        if numerics and len(self._rows):
            self.finest_of, is_finest = _finest(self, numerics)
            self._all_rows = self._rows
            self._rows = self._rows[is_finest]
        self.codes = {path: codes_of(self.values(path)) for path in self.paths if path not in numerics}
        status = self.values("status")
        self.is_finished = np.array([value == "ok" for value in status.tolist()], bool)

    def __len__(self) -> int:
        return len(self._rows)

    def _is_varied(self, path: str) -> bool:
        if path not in self._columns:
            return False
        values = _array(self._columns[path])
        return len(codes_of(values[self._rows] if len(self._rows) else values)[0]) > 1  # a search runs none of its own

    def paths_of(self, *names: str) -> list[str]:
        """Return the varied paths with one of these roles."""
        return [path for path in self.paths if self.role_by_path[path] in names]

    def values(self, name: str) -> np.ndarray:
        """Return a column of the judged cases."""
        return _array(self._columns[name])[self._rows]

    def numbers(self, name: str) -> np.ndarray:
        """Return a figure of the judged cases as floats; NaN where it is missing or the case failed."""
        return np.where(self.is_finished, _floats(self.values(name)), np.nan)

    def figure_of_all(self, name: str) -> np.ndarray:
        """Return a figure of the own cases, coarse ones included, as floats; NaN where it is missing."""
        is_ok = np.array([value == "ok" for value in _array(self._columns["status"])[self._all_rows].tolist()])
        return np.where(is_ok, _floats(_array(self._columns[name])[self._all_rows]), np.nan)

    def values_of_all(self, name: str) -> np.ndarray:
        """Return a column of the own cases, coarse ones included."""
        return _array(self._columns[name])[self._all_rows]

    def rows_of(self, values: Mapping[str, Any]) -> np.ndarray:
        """Return the judged cases (indices) with these values, in the form of the answer; an unused path matches."""
        is_match = np.ones(len(self), bool)
        for path, value in values.items():
            levels, codes = self.codes[path]
            wanted = [code for code, level in enumerate(levels) if named_value(self.record, path, level) == value]
            is_match &= np.isin(codes, [-1, *wanted])
        return np.flatnonzero(is_match)

    def keys(self, paths: Sequence[str]) -> list[Key]:
        """Return the codes of every case at some paths."""
        columns = [self.codes[path][1].tolist() for path in paths]
        return list(zip(*columns, strict=True)) if columns else [()] * len(self)

    def values_at(self, paths: Sequence[str], key: Key) -> dict[str, Any]:
        """Return the values of a key in the form of the answer, without unused paths."""
        return {
            path: named_value(self.record, path, self.codes[path][0][code])
            for path, code in zip(paths, key, strict=True)
            if code >= 0
        }

    @cached_property
    def limits(self) -> tuple[Limit, ...]:
        """Return the limits of the grid."""
        return verdict.limits_and_figures_of(self.record).limits

    @cached_property
    def assessment(self) -> Assessment:
        """Return how the judged cases compare with the limits."""
        names = {name for limit in self.limits for name in (limit.column, limit.times) if name}
        columns = {name: self.numbers(name) for name in names}
        return verdict.LimitsAndFigures((), self.limits).assess(columns, self.is_finished)

    @cached_property
    def verdicts(self) -> np.ndarray:
        """Return the verdict of every judged case, (n,)."""
        exceeded, undecided = self.assessment.exceeded.any(axis=0), self.assessment.undecided.any(axis=0)
        return np.where(exceeded, EXCEEDED, np.where(undecided, UNDECIDED, MET))


def judge(  # noqa: PLR0913 - one call, whose arguments are the fields of a question
    record: Mapping[str, Any],
    columns: Mapping[str, Any],
    *,
    own: Sequence[bool] | np.ndarray | None = None,
    complete: bool = True,
    question: str = "",
    figures: Sequence[str] | None = None,
    search: Sequence[Mapping[str, Any]] = (),
) -> dict[str, Any]:
    """Return the answer to the question of a grid, without sentences.

    record : run.json, of which `roles`, `layout`, `limits`, `figures`, `sample`, `zip`, `cases`, `labels`, `fits` count
    columns : name -> (n,) values of case_id, status, every varied path and every figure in use; None or NaN for null
    own : (n,) mask of the grid's own cases, default all; the others were added by a search
    complete : whether these are all cases of a finished run
    question : default: `sample` for one random sample, else `limits` or `force`
    figures : columns whose effects are listed, default: limited and user-defined ones
    search : rows of the table of the search
    """
    cases = Cases(record, columns, own)
    if figures is None:
        figures = list(dict.fromkeys([*(limit.column for limit in cases.limits), *(record.get("figures") or {})]))
    return {
        "question": question or _question(cases),
        "complete": bool(complete),
        **answer_on(cases, figures),
        "search": [dict(row) for row in search],
        "sentences": [],
    }


def answer_on(cases: Cases, figures: Sequence[str]) -> dict[str, Any]:
    """Return the part of the answer that follows from the cases; figures : columns whose effects are listed."""
    designs = sorted(_designs(cases) if cases.limits else [], key=_rank)
    counts = None
    if cases.limits:
        counts = {name: int((cases.verdicts == name).sum()) for name in (MET, EXCEEDED, UNDECIDED)}
        counts["added"] = cases.added_count
    return {
        "roles": {path: cases.role_by_path[path] for path in cases.paths},
        "cases": counts,
        "designs": designs[:MAX_DESIGNS],
        "designs_total": len(designs),
        "verdicts": {name: sum(design["verdict"] == name for design in designs) for name in VERDICTS.values()},
        "effects": blocks.effects(cases, figures),
        "convergence": _convergence(cases, figures),
    }


def _question(cases: Cases) -> str:
    sample = cases.record.get("sample") or {}
    if sample.get("method", ONE_AT_A_TIME) != ONE_AT_A_TIME and set(cases.paths) <= set(sample["drawn"]):
        return "sample"
    return "limits" if cases.limits else "force"


def _designs(cases: Cases) -> list[dict[str, Any]]:
    """Return the designs with their verdicts, in order of appearance; none for a one-at-a-time sample."""
    sample = cases.record.get("sample") or {}
    if sample.get("method") == ONE_AT_A_TIME or not len(cases):
        return []
    choices = cases.paths_of(roles.CHOICE)
    conditions = cases.paths_of(roles.CONDITION, roles.MODEL, roles.UNCERTAINTY)
    choice_keys, condition_keys = cases.keys(choices), cases.keys(conditions)
    choice_forms, condition_forms = _completions(choice_keys), _completions(condition_keys)
    tuples = list(dict.fromkeys(form for key in condition_keys for form in condition_forms[key]))
    rows_by_design: dict[Key, dict[Key, list[int]]] = {}
    for row, (choice_key, condition_key) in enumerate(zip(choice_keys, condition_keys, strict=True)):
        for design in choice_forms[choice_key]:
            rows_by_tuple = rows_by_design.setdefault(design, {})
            for condition in condition_forms[condition_key]:
                rows_by_tuple.setdefault(condition, []).append(row)
    drawn = [index for index, path in enumerate(conditions) if path in sample.get("drawn", {})]
    designs = []
    for design, rows_by_tuple in rows_by_design.items():
        entry = _design(cases, rows_by_tuple, (conditions, tuples))
        if drawn:
            entry["share"] = _share(cases, rows_by_tuple, drawn, tuples)
        designs.append({"values": cases.values_at(choices, design), **entry})
    return designs


def _design(
    cases: Cases, rows_by_tuple: Mapping[Key, Sequence[int]], required: tuple[Sequence[str], Sequence[Key]]
) -> dict[str, Any]:
    """Return the verdict on a design; required : the paths of its conditions, and the tuples of the run."""
    conditions, tuples = required
    verdict_by_tuple = {condition: combined(cases.verdicts[rows].tolist()) for condition, rows in rows_by_tuple.items()}
    counts = {name: list(verdict_by_tuple.values()).count(name) for name in (MET, EXCEEDED, UNDECIDED)}
    missing = [
        (condition, _reason(cases, rows_by_tuple[condition]) if condition in rows_by_tuple else NOT_RUN)
        for condition in tuples
        if verdict_by_tuple.get(condition, UNDECIDED) == UNDECIDED
    ]
    decisive = EXCEEDED if counts[EXCEEDED] else UNDECIDED if missing else MET
    rows = sorted({row for rows in rows_by_tuple.values() for row in rows})
    return {
        "verdict": VERDICTS[decisive],
        **_worst(cases, [row for row in rows if cases.verdicts[row] == decisive]),
        "conditions": len(tuples),
        **counts,
        "missing": [
            {"values": cases.values_at(conditions, condition), "why": why} for condition, why in missing[:MAX_MISSING]
        ],
        "missing_total": len(missing),
    }


def combined(verdicts: Sequence[str]) -> str:
    """Return the verdict on several cases that must all meet the limits."""
    return EXCEEDED if EXCEEDED in verdicts else UNDECIDED if UNDECIDED in verdicts else MET


def _reason(cases: Cases, rows: Sequence[int]) -> str:
    """Return why the first undecided one of these cases is undecided: its status, or the column that is null."""
    row = next(row for row in rows if cases.verdicts[row] == UNDECIDED)
    if not cases.is_finished[row]:
        return str(cases.values("status")[row])
    limit = next(
        limit for limit, is_open in zip(cases.limits, cases.assessment.undecided[:, row], strict=True) if is_open
    )
    is_figure_null = not limit.null and np.isnan(cases.numbers(limit.column)[row])
    return f"{limit.column if is_figure_null or not limit.times else limit.times} is null"


def _worst(cases: Cases, rows: Sequence[int]) -> dict[str, Any]:
    """Return margin, excess, limit and identity of the worst of these cases, which share a verdict."""
    rows = [row for row in rows if cases.values("status")[row] != NOT_RUN]
    if not rows:
        return {"margin": None, "excess": None, "limit": None, "worst": None}
    facts = [_margin_of(cases, row) for row in rows]
    order = [
        (fact["margin"] is not None, fact["margin"] or 0.0, -(np.inf if fact["excess"] is None else fact["excess"]))
        for fact in facts
    ]
    index = min(range(len(rows)), key=lambda place: (order[place], -place))  # of equal ones the last, as in tables
    return facts[index] | {"worst": str(cases.values("case_id")[rows[index]])}


def _margin_of(cases: Cases, row: int) -> dict[str, Any]:
    """Return the margin of a case and its limit, or the largest excess over a bound that shows no margin."""
    margin = float(cases.assessment.margin[row]) + 0.0  # no negative zero
    if np.isfinite(margin):
        relative = cases.assessment.relative[:, row]
        return {"margin": margin, "excess": None, "limit": cases.limits[int(np.nanargmin(relative))].column}
    best: tuple[float, str] | None = None
    for limit, is_exceeded in zip(cases.limits, cases.assessment.exceeded[:, row], strict=True):
        if is_exceeded:
            names = (limit.column, *((limit.times,) if limit.times else ()))
            excess = float(limit.excess({name: cases.numbers(name)[row : row + 1] for name in names})[0])
            if best is None or np.nan_to_num(excess, nan=np.inf) > np.nan_to_num(best[0], nan=np.inf):
                best = excess, limit.column
    if best is None:
        return {"margin": None, "excess": None, "limit": None}
    return {"margin": None, "excess": best[0] if np.isfinite(best[0]) else None, "limit": best[1]}


def _rank(design: Mapping[str, Any]) -> tuple[int, bool, float, float]:
    """Return the place of a design in the list: met ones by margin, undecided ones, exceeding ones by margin."""
    margin, excess = design["margin"], design["excess"]
    place = list(VERDICTS.values()).index(design["verdict"])
    return place, margin is None, -(margin or 0.0), np.inf if excess is None else excess


def _share(
    cases: Cases, rows_by_tuple: Mapping[Key, Sequence[int]], drawn: Sequence[int], tuples: Sequence[Key]
) -> dict[str, float | None]:
    """Return the shares of the draws of a design that meet the limits, exceed one, or are undecided.

    `low` and `high` are the ends of the 95 % interval of the share that meets them; None unless the draws are random.
    """
    verdicts: dict[Key, list[str]] = {}
    for condition in tuples:
        rows = list(rows_by_tuple.get(condition, ()))
        of_condition = cases.verdicts[rows].tolist() if rows else [UNDECIDED]
        verdicts.setdefault(tuple(condition[index] for index in drawn), []).extend(of_condition)
    results = [combined(of_draw) for of_draw in verdicts.values()]
    count = {name: results.count(name) for name in (MET, EXCEEDED, UNDECIDED)}
    is_random = cases.record["sample"].get("method") in RANDOM_METHODS
    _, low, high = binomial_interval(count[MET], len(results)) if is_random else (None, None, None)
    shares = {name: count[name] / len(results) for name in count}
    return {"met": shares[MET], "low": low, "high": high, "exceeded": shares[EXCEEDED], "undecided": shares[UNDECIDED]}


def _completions(keys: Sequence[Key]) -> dict[Key, list[Key]]:
    """Return each key with its unused paths filled in by compatible keys: an unused value makes no difference."""
    distinct = list(dict.fromkeys(keys))
    forms = {key: [key] for key in distinct}
    for key in distinct:
        if -1 not in key:
            continue
        found, todo = dict[Key, None](), [key]
        while todo:
            form = todo.pop()
            filled = [merged for merged in (_merged(form, other) for other in distinct) if merged and merged != form]
            if not filled and form not in found:
                found[form] = None
            todo += [merged for merged in dict.fromkeys(filled) if merged not in found]
        forms[key] = list(found)
    return forms


def _merged(key: Key, other: Key) -> Key | None:
    """Return a key with unused codes taken from another; None if the two differ at a path that both use."""
    if any(a != b and a >= 0 and b >= 0 for a, b in zip(key, other, strict=True)):
        return None
    return tuple(b if a < 0 else a for a, b in zip(key, other, strict=True))


def _finest(cases: Cases, numerics: Sequence[str]) -> tuple[np.ndarray, np.ndarray]:
    """Return for every own case the position of the finest case that differs in numerics alone, and a mask of these."""
    others = [path for path in cases.paths if path not in numerics]
    group = combined_codes([codes_of(cases.values(path))[1] for path in others], len(cases))
    fineness = [_fineness(path, *codes_of(cases.values(path))) for path in numerics]
    order = np.lexsort([*fineness[::-1], group])
    is_last = np.append(np.diff(group[order]) != 0, True)
    finest_of_group = dict(zip(group[order][is_last].tolist(), order[is_last].tolist(), strict=True))
    finest_of = np.array([finest_of_group[number] for number in group.tolist()])
    return finest_of, finest_of == np.arange(len(cases))


def _fineness(path: str, levels: list, codes: np.ndarray) -> np.ndarray:
    """Return numbers (n,) that increase with the fineness of the values at a numerical path."""
    sign = -1 if path.rpartition(".")[2] in FINER_IF_SMALLER else 1
    return sign * codes


def _convergence(cases: Cases, figures: Sequence[str]) -> list[dict[str, Any]]:
    """Return how far figures at coarser numerics differ from the finest, the next finest first, the largest of each."""
    numerics = cases.paths_of(roles.NUMERICS)
    entries = []
    for path in numerics if len(cases) else ():
        values = cases.values_of_all(path)
        others = [cases.values_of_all(other) for other in numerics if other != path]
        is_alone = cases.finest_of != np.arange(len(values))  # a finest case is no coarser one of itself
        for column in others:
            is_alone &= np.array([a == b for a, b in zip(column, column[cases.finest_of], strict=True)])
        levels, codes = codes_of(values)
        fineness = _fineness(path, levels, codes)
        coarser = np.unique(fineness[is_alone])[::-1]
        for figure in figures:
            numbers = cases.figure_of_all(figure)
            for level in coarser.tolist():
                rows = np.flatnonzero(is_alone & (fineness == level))
                if entry := _difference(numbers[cases.finest_of[rows]], numbers[rows]):
                    value = levels[int(codes[rows[0]])]
                    entries.append({"figure": figure, "path": path, **entry, "value": _plain(value)})
    return entries


def _difference(finest: np.ndarray, coarser: np.ndarray) -> dict[str, Any] | None:
    """Return the pair with the largest relative difference; None if no pair is known."""
    is_known = np.isfinite(finest) & np.isfinite(coarser)
    if not is_known.any():
        return None
    finest, coarser = finest[is_known], coarser[is_known]
    with np.errstate(all="ignore"):
        relative = np.where(finest == coarser, 0.0, np.abs(coarser - finest) / np.abs(finest))
    worst = int(np.argmax(relative))
    difference = float(relative[worst])
    return {
        "finest": float(finest[worst]),
        "next": float(coarser[worst]),
        "difference": difference if np.isfinite(difference) else None,
    }


def combined_codes(columns: Sequence[np.ndarray], count: int) -> np.ndarray:
    """Return one number for each case that is equal where all codes are; columns : (n,) each."""
    number = np.zeros(count, np.int64)
    for codes in columns:
        number = number * (int(codes.max(initial=0)) + 2) + codes + 1
        number = np.unique(number, return_inverse=True)[1].reshape(-1)
    return number


def codes_of(values: np.ndarray) -> tuple[list, np.ndarray]:
    """Return the distinct values, numbers ascending, texts in order of appearance, and each value's index; null: -1."""
    if values.dtype.kind in "fiub":
        unique_values, indices = np.unique(values, return_inverse=True)
        is_known = np.isfinite(unique_values.astype(float))
        return unique_values[is_known].tolist(), np.where(is_known[indices], indices, -1).reshape(-1)
    present = [value for value in values.tolist() if not is_null(value)]
    has_text = any(isinstance(value, str) for value in present)
    levels = list(dict.fromkeys(present)) if has_text else sorted(set(present))
    index_of = {value: index for index, value in enumerate(levels)}
    return levels, np.array([-1 if is_null(value) else index_of[value] for value in values.tolist()], int)


def is_null(value: Any) -> bool:
    """Return whether a value is None or NaN."""
    return value is None or (isinstance(value, float) and math.isnan(value))


def named_value(record: Mapping[str, Any], path: str, value: Any) -> Any:
    """Return a varied value as the answer has it: the label or the fit if it has one, a law's name, else SI."""
    for name, labelled in ((record.get("labels") or {}).get(path) or {}).items():
        if labelled == value:
            return name
    for fit in (record.get("fits") or {}).get(path) or ():
        if fit["mean"] == value:
            return fit["name"]
    return _plain(value)


def _plain(value: Any) -> Any:
    return value if isinstance(value, str | bool) else float(value)


def _array(values: Any) -> np.ndarray:
    return values if isinstance(values, np.ndarray) else np.array(list(values), object)


def _floats(values: np.ndarray) -> np.ndarray:
    if values.dtype.kind == "O":
        return np.array([np.nan if is_null(value) else value for value in values.tolist()], float)
    return values.astype(float)


def missing_groups(designs: Sequence[Mapping[str, Any]]) -> Iterator[tuple[Mapping[str, Any], str, int]]:
    """Yield the values and the reason of what is missing, each once, with the number of designs that miss it."""
    counts: dict[tuple, int] = {}
    entries: dict[tuple, tuple[Mapping[str, Any], str]] = {}
    for design in designs:
        for entry in design["missing"]:
            key = (tuple(entry["values"].items()), entry["why"])
            counts[key] = counts.get(key, 0) + 1
            entries[key] = entry["values"], entry["why"]
    for key, (values, why) in entries.items():
        yield values, why, counts[key]
