"""Judges the cases of a run: which designs meet the limits under every condition, and what drives the figures.

Everything follows from the run's record and the columns of its summary; no file is read and nothing is worded here.
The result of `answer_on` is a part of the answer: a dict of plain values that terminal, page and answer.json share.
"""

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from ..contracts import catalogue
from .judged import (
    CASES_AT_ONCE,
    EXCEEDED,
    MET,
    ONE_AT_A_TIME,
    RANDOM_METHODS,
    UNDECIDED,
    Cases,
    Key,
    binomial_interval,
    codes_of,
    combined_codes,
    fineness_of,
    floats,
    median,
    partial_rank_correlation,
    plain_value,
    variance_shares,
)

# Effects of varied values on figures, from blocks of cases that differ in one value and in nothing else.

MAX_LEVELS = 1000  # distinct values of an axis above which its effect is not assessed
MIN_DIFFERENCE = 0.01  # of the larger end: a smaller difference of two cases is none
MAX_REVERSAL = 0.1  # of the range of a block: a block that turns back by more is neither rising nor falling
SIGNIFICANCE = 0.05  # of the two-sided sign test
MIN_DRAWS = 8  # cases: rank correlations of fewer are meaningless
QUARTILE = 0.25  # of the draws: those with the lowest and with the highest values of a variable
RISES, FALLS, NONE, MIXED, NOT_DECIDED, DIFFERS = "rises", "falls", "none", "mixed", "not-decided", "differs"


class Axis(NamedTuple):
    """Varied paths that fix one another, so that they vary as one."""

    paths: tuple[str, ...]  # the first one gives the values
    levels: list[Any]  # distinct values, numbers ascending
    codes: np.ndarray  # (n,) index of each case's value, -1: not used

    @property
    def is_text(self) -> bool:
        """Return whether the values are words."""
        return any(isinstance(level, str) for level in self.levels)


def effects(cases: Cases, figures: Sequence[str]) -> list[dict[str, Any]]:
    """Return the effect of each axis on each figure in the form of the answer, the largest share first."""
    sample = cases.record.get("sample") or {}
    drawn = [path for path in sample.get("drawn", {}) if path in cases.codes]
    drawn = [] if sample.get("method") == ONE_AT_A_TIME else drawn
    axes = [axis for axis in axes_of(cases) if not set(axis.paths) & {*drawn, *catalogue.STARTS}]
    entries = []
    for figure in figures:
        values = cases.numbers(figure)
        shares = variance_shares(values, [axis.codes for axis in axes])
        of_figure = [
            {"figure": figure, "path": axis.paths[0], **_effect(cases, axis, values, share)}
            for axis, share in zip(axes, shares, strict=True)
        ]
        of_figure += [{"figure": figure, "path": path, **entry} for path, entry in _rank_effects(cases, drawn, values)]
        # by share and, where none is known, by size
        sizes = [(each["share"] or 0.0, abs((each["to"] or 0.0) - (each["from"] or 0.0))) for each in of_figure]
        order = sorted(range(len(of_figure)), key=sizes.__getitem__, reverse=True)
        entries += [of_figure[index] for index in order]
    return entries


def axes_of(cases: Cases) -> list[Axis]:
    """Return the axes of the judged cases; paths of `zip` or `cases` that fix one another are one axis."""
    tied = {path for section in ("zip", "cases") for path in cases.record.get(section) or {}}
    axes: list[Axis] = []
    for path, (levels, codes) in cases.codes.items():
        for index, axis in enumerate(axes):
            if {path, axis.paths[0]} <= tied and _fix_one_another(codes, axis.codes):
                axes[index] = axis._replace(paths=(*axis.paths, path))
                break
        else:
            axes.append(Axis((path,), levels, codes))
    return axes


def _fix_one_another(first: np.ndarray, second: np.ndarray) -> bool:
    values, others = first.tolist(), second.tolist()
    return len({*zip(values, others, strict=True)}) == len({*values}) == len({*others})


def known_blocks(codes: Mapping[str, np.ndarray], axis: Axis, values: np.ndarray) -> np.ndarray:
    """Return a figure of the cases that differ on one axis alone, (blocks, levels); NaN where it is unknown.

    Blocks count whose figure is known at both ends of the axis, or of words at every value.

    codes : path -> (n,) index of each case's value, -1: not used
    values : (n,) of each case
    """
    known = np.flatnonzero((axis.codes >= 0) & np.isfinite(values)).astype("u4")
    others = [of_path[known] for path, of_path in codes.items() if path not in axis.paths]
    group, level, last = combined_codes(others, len(known)), axis.codes[known], len(axis.levels) - 1
    ends = range(last + 1) if axis.is_text else (0, last)
    has_ends = [np.isin(np.arange(group.max(initial=-1) + 1), group[level == end]) for end in ends]
    number = np.cumsum(np.all(has_ends, axis=0)) - 1
    blocks = np.full((number.max(initial=-1) + 1, last + 1), np.nan)
    for first in range(0, len(known), CASES_AT_ONCE):
        part = slice(first, first + CASES_AT_ONCE)
        is_used = np.all(has_ends, axis=0)[group[part]]
        blocks[number[group[part][is_used]], level[part][is_used]] = values[known[part][is_used]]
    return blocks


def verdict_on(axis: Axis, blocks: np.ndarray) -> str:
    """Return the verdict on the differences of a figure between the values of an axis; blocks : (blocks, levels) SI."""
    if not axis.is_text:
        return MIXED if _turns_back(blocks).any() else _trend(blocks)
    return NONE if _is_none(blocks.min(axis=1), blocks.max(axis=1)).all() else DIFFERS


def _effect(cases: Cases, axis: Axis, values: np.ndarray, share: float) -> dict[str, Any]:
    """Return the effect of an axis on a figure; values : (n,) SI, NaN for null."""
    last = len(axis.levels) - 1
    codes = {path: of_path for path, (_, of_path) in cases.codes.items()}
    blocks = known_blocks(codes, axis, values) if 1 <= last <= MAX_LEVELS else np.empty((0, 0))
    entry: dict[str, Any] = {"verdict": NOT_DECIDED, "from": None, "to": None, "pairs": len(blocks)}
    if not len(blocks):
        return entry | {"share": None, "method": "pairs", **_tied(axis)}
    medians = np.array([median(column[np.isfinite(column)]) for column in blocks.T])  # NaN where none has a case
    entry |= {"verdict": verdict_on(axis, blocks)}
    reversals = int(np.count_nonzero(_turns_back(blocks)))
    if entry["verdict"] == MIXED and 2 * reversals <= len(blocks) and (trend := _trend(blocks)) in (RISES, FALLS):
        entry |= {"trend": trend, "reversed": reversals}  # between the ends, which most blocks keep on the way
    entry |= {"share": None if math.isnan(share) else float(share), "method": "pairs"}
    if axis.is_text:
        lowest, highest = int(np.nanargmin(medians)), int(np.nanargmax(medians))
        entry |= {"lowest": axis.levels[lowest], "highest": axis.levels[highest]}
        entry |= {"from": float(medians[lowest]), "to": float(medians[highest])}
    else:
        entry |= {"from": float(medians[0]), "to": float(medians[-1])}
    return entry | {"medians": [None if math.isnan(median) else float(median) for median in medians], **_tied(axis)}


def _tied(axis: Axis) -> dict[str, list[str]]:
    return {"with": list(axis.paths[1:])} if len(axis.paths) > 1 else {}


def _trend(blocks: np.ndarray) -> str:
    """Return the verdict on the differences of blocks between both ends of an axis, whatever is between them."""
    start, end = blocks[:, 0], blocks[:, -1]
    differs = ~_is_none(start, end)
    rising, falling = int(np.count_nonzero(differs & (end > start))), int(np.count_nonzero(differs & (end <= start)))
    if not rising and not falling:
        return NONE
    if rising and falling and sign_test(rising, falling) > SIGNIFICANCE:
        return MIXED
    return RISES if rising > falling else FALLS


def _is_none(start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Return whether two figures differ by at most a hundredth of the larger one."""
    return np.asarray(np.abs(end - start) <= MIN_DIFFERENCE * np.maximum(np.abs(start), np.abs(end)))


def _turns_back(blocks: np.ndarray) -> np.ndarray:
    """Return which blocks, known at both ends, run against their own direction by more than a tenth of their range."""
    start, end, low, high = blocks[:, 0], blocks[:, -1], np.nanmin(blocks, axis=1), np.nanmax(blocks, axis=1)
    fall = np.nanmax(np.fmax.accumulate(blocks, axis=1) - blocks, axis=1)
    rise = np.nanmax(blocks - np.fmin.accumulate(blocks, axis=1), axis=1)
    reversal = np.where(end > start, fall, np.where(end < start, rise, np.minimum(fall, rise)))
    turns: np.ndarray = (np.isfinite(blocks).sum(axis=1) > 2) & ~_is_none(low, high)
    turns &= reversal > MAX_REVERSAL * (high - low)
    return turns


def sign_test(first: int, second: int) -> float:
    """Return the two-sided probability of counts at least as uneven as these if both signs are equally likely."""
    total, larger = first + second, max(first, second)
    return min(1.0, 2.0 * sum(math.comb(total, count) for count in range(larger, total + 1)) / 2.0**total)


def _rank_effects(cases: Cases, drawn: Sequence[str], values: np.ndarray) -> list[tuple[str, dict[str, Any]]]:
    """Return the effect of each drawn variable by partial rank correlation, as (path, entry)."""
    is_known = np.isfinite(values)
    variables = {path: np.array(cases.codes[path][0])[cases.codes[path][1]][is_known] for path in drawn}
    known, entries = values[is_known], []
    for path, variable in variables.items():
        entry: dict[str, Any] = {"verdict": NOT_DECIDED, "from": None, "to": None, "pairs": len(known)}
        entry |= {"share": None, "method": "ranks"}
        if len(known) >= MIN_DRAWS and _is_none(known.min(), known.max()):
            entry["verdict"] = NONE
        elif len(known) >= MIN_DRAWS:
            others = [other for name, other in variables.items() if name != path]
            partial = partial_rank_correlation(variable, known, others)
            low, high = np.quantile(variable, (QUARTILE, 1.0 - QUARTILE))
            entry["from"] = median(known[variable <= low])
            entry["to"] = median(known[variable >= high])
            entry["share"] = None if math.isnan(partial.value) else float(partial.value**2)
            entry["verdict"] = RISES if partial.low > 0.0 else FALLS if partial.high < 0.0 else NOT_DECIDED
        entries.append((path, entry))
    return entries


VERDICTS = {MET: "meets", UNDECIDED: "undecided", EXCEEDED: "exceeds"}  # verdict of its cases -> of a design, in order
NOT_RUN = "not run"
MAX_DESIGNS, MAX_MISSING = 1000, 20  # entries of a list in the answer


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
        "effects": effects(cases, figures),
        "convergence": _convergence(cases, figures),
    }


def _designs(cases: Cases) -> list[dict[str, Any]]:
    """Return the designs with their verdicts, in order of appearance; none for a one-at-a-time sample."""
    sample = cases.record.get("sample") or {}
    if sample.get("method") == ONE_AT_A_TIME or not len(cases):
        return []
    choices = cases.paths_of(catalogue.CHOICE)
    conditions = cases.paths_of(catalogue.CONDITION, catalogue.MODEL, catalogue.UNCERTAINTY)
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
        labels = cases.labels_of(np.concatenate([*rows_by_tuple.values()]))
        designs.append({"values": cases.values_at(choices, design), **labels, **entry})
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
    return facts[index] | {"worst": cases.case_id(rows[index])}


def _margin_of(cases: Cases, row: int) -> dict[str, Any]:
    """Return the margin of a case and its limit, or the largest excess over a bound that shows no margin."""
    margin = float(cases.assessment.margin[row]) + 0.0  # no negative zero
    if np.isfinite(margin):
        relative = cases.assessment.relative[:, row]
        return {"margin": margin, "excess": None, "limit": cases.limits[int(np.nanargmin(relative))].column}
    best: tuple[float, str] | None = None
    for limit, is_exceeded in zip(cases.limits, cases.assessment.exceeded[:, row], strict=True):
        if is_exceeded:
            numbers = {name: cases.numbers(name)[row : row + 1] for name in limit.required_columns}
            excess = float(limit.excess(numbers)[0])
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
) -> dict[str, Any]:
    """Return the shares of the draws of a design that meet the limits, exceed one, or are undecided, and their number.

    A draw that exceeds a limit under one of several conditions counts as exceeding.  `low` and `high` are the ends of
    the 95 % interval of the share that meets them; None unless the draws are random.
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
    ends = {"met": shares[MET], "low": low, "high": high}
    return ends | {"exceeded": shares[EXCEEDED], "undecided": shares[UNDECIDED], "draws": len(results)}


def _completions(keys: Sequence[Key]) -> dict[Key, list[Key]]:
    """Return each key with its unused paths filled in by compatible keys: an unused value makes no difference."""
    distinct = list(dict.fromkeys(keys))
    completions = {key: [key] for key in distinct}
    for key in distinct:
        if -1 not in key:
            continue
        complete_keys, todo = dict[Key, None](), [key]
        while todo:
            form = todo.pop()
            filled = [merged for merged in (_merged(form, other) for other in distinct) if merged and merged != form]
            if not filled and form not in complete_keys:
                complete_keys[form] = None
            todo += [merged for merged in dict.fromkeys(filled) if merged not in complete_keys]
        completions[key] = list(complete_keys)
    return completions


def _merged(key: Key, other: Key) -> Key | None:
    """Return a key with unused codes taken from another; None if the two differ at a path that both use."""
    if any(a != b and a >= 0 and b >= 0 for a, b in zip(key, other, strict=True)):
        return None
    return tuple(b if a < 0 else a for a, b in zip(key, other, strict=True))


def _convergence(cases: Cases, figures: Sequence[str]) -> list[dict[str, Any]]:
    """Return how far figures at coarser numerics differ from the finest, the next finest first, the largest of each."""
    numerics = cases.paths_of(catalogue.NUMERICS)
    entries = []
    for path in numerics if len(cases) else ():
        values = cases.values_of_all(path)
        others = [cases.values_of_all(other) for other in numerics if other != path]
        is_alone = cases.finest_of != np.arange(len(values))  # a finest case is no coarser one of itself
        for column in others:
            is_alone &= np.array([a == b for a, b in zip(column, column[cases.finest_of], strict=True)])
        levels, codes = codes_of(values)
        fineness = fineness_of(path, codes)
        coarser = sorted({*fineness[is_alone].tolist()}, reverse=True)
        for figure in figures:
            numbers = np.where(cases.values_of_all("status") == "ok", floats(cases.values_of_all(figure)), np.nan)
            for level in coarser:
                rows = np.flatnonzero(is_alone & (fineness == level))
                if entry := _difference(numbers[cases.finest_of[rows]], numbers[rows]):
                    value = levels[int(codes[rows[0]])]
                    entries.append({"figure": figure, "path": path, **entry, "value": plain_value(value)})
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
