"""Effects of varied values on figures, from blocks of cases that differ in one value and in nothing else."""

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from . import ranks
from .judged import Cases
from .probability import ONE_AT_A_TIME
from .variance import variance_shares

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
    axes = [axis for axis in axes_of(cases) if not set(axis.paths) & set(drawn)]
    entries = []
    for figure in figures:
        values = cases.numbers(figure)
        shares = variance_shares(values, [axis.codes for axis in axes])
        of_figure = [
            {"figure": figure, "path": axis.paths[0], **_effect(cases, axis, values, share)}
            for axis, share in zip(axes, shares, strict=True)
        ]
        of_figure += [{"figure": figure, "path": path, **entry} for path, entry in _rank_effects(cases, drawn, values)]
        entries += sorted(of_figure, key=_strength, reverse=True)
    return entries


def _strength(entry: dict[str, Any]) -> tuple[float, float]:
    """Return the share of an effect and, where none is known, its size."""
    return entry["share"] or 0.0, abs((entry["to"] or 0.0) - (entry["from"] or 0.0))


def axes_of(cases: Cases) -> list[Axis]:
    """Return the axes of the judged cases; paths of `zip` or `cases` that fix one another are one axis."""
    tied = {path for section in ("zip", "cases") for path in cases.record.get(section) or {}}
    axes: list[Axis] = []
    for path, (levels, codes) in cases.codes.items():
        partner = next(
            (
                index
                for index, axis in enumerate(axes)
                if path in tied and axis.paths[0] in tied and _fix_one_another(codes, axis.codes)
            ),
            None,
        )
        if partner is None:
            axes.append(Axis((path,), levels, codes))
        else:
            axes[partner] = axes[partner]._replace(paths=(*axes[partner].paths, path))
    return axes


def _fix_one_another(codes: np.ndarray, other: np.ndarray) -> bool:
    pairs = len(set(zip(codes.tolist(), other.tolist(), strict=True)))
    return pairs == len(np.unique(codes)) == len(np.unique(other))


def blocks_of(codes: Mapping[str, np.ndarray], axis: Axis) -> list[np.ndarray]:
    """Return the cases that differ on one axis alone, as arrays of indices with ascending codes.

    codes : path -> (n,) index of each case's value, -1: not used
    """
    used = np.flatnonzero(axis.codes >= 0)
    group = np.zeros(len(used), np.int64)
    for path, of_path in codes.items():
        if path not in axis.paths:
            group = group * (int(of_path.max(initial=0)) + 2) + of_path[used] + 1
            group = np.unique(group, return_inverse=True)[1].reshape(-1)
    order = np.lexsort([axis.codes[used], group])
    ends = np.flatnonzero(np.diff(group[order])) + 1
    return np.split(used[order], ends) if len(used) else []


def known_blocks(codes: Mapping[str, np.ndarray], axis: Axis, values: np.ndarray) -> list[np.ndarray]:
    """Return the blocks whose figure is known at both ends of the axis, or of words at every value; values : (n,)."""
    blocks = [block[np.isfinite(values[block])] for block in blocks_of(codes, axis)]
    last = len(axis.levels) - 1
    if axis.is_text:
        return [block for block in blocks if len(np.unique(axis.codes[block])) == last + 1]
    return [block for block in blocks if block.size and _spans(axis.codes[block], last)]


def verdict_on(axis: Axis, blocks: Sequence[np.ndarray], values: np.ndarray) -> str:
    """Return the verdict on the differences of a figure between the values of an axis; values : (n,) SI."""
    lines = [_line(axis.codes[block], values[block], len(axis.levels) - 1) for block in blocks]
    if not axis.is_text:
        return _direction(lines)
    return NONE if all(_is_none(float(np.nanmin(line)), float(np.nanmax(line))) for line in lines) else DIFFERS


def _effect(cases: Cases, axis: Axis, values: np.ndarray, share: float) -> dict[str, Any]:
    """Return the effect of an axis on a figure; values : (n,) SI, NaN for null."""
    last = len(axis.levels) - 1
    codes = {path: of_path for path, (_, of_path) in cases.codes.items()}
    blocks = known_blocks(codes, axis, values) if 1 <= last <= MAX_LEVELS else []
    entry: dict[str, Any] = {"verdict": NOT_DECIDED, "from": None, "to": None, "pairs": len(blocks)}
    if not blocks:
        return entry | {"share": None, "method": "pairs", **_tied(axis)}
    medians = _medians([_line(axis.codes[block], values[block], last) for block in blocks])
    entry |= {"verdict": verdict_on(axis, blocks, values)}
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


def _spans(codes: np.ndarray, last: int) -> bool:
    return int(codes.min()) == 0 and int(codes.max()) == last


def _line(codes: np.ndarray, values: np.ndarray, last: int) -> np.ndarray:
    """Return the figure of a block at each value of the axis, (levels,); NaN where it is unknown."""
    line = np.full(last + 1, np.nan)
    line[codes] = values
    return line


def _medians(lines: Sequence[np.ndarray]) -> np.ndarray:
    """Return the median over blocks at each value of the axis; NaN where no block has a case."""
    table = np.array(lines)
    return np.array(
        [np.median(column[np.isfinite(column)]) if np.isfinite(column).any() else np.nan for column in table.T]
    )


def _direction(lines: Sequence[np.ndarray]) -> str:
    """Return the verdict on the differences of blocks between both ends of an axis of numbers."""
    signs = [0 if _is_none(line[0], line[-1]) else 1 if line[-1] > line[0] else -1 for line in lines]
    rising, falling = signs.count(1), signs.count(-1)
    if any(_turns_back(line) for line in lines):
        return MIXED
    if not rising and not falling:
        return NONE
    if rising and falling and sign_test(rising, falling) > SIGNIFICANCE:
        return MIXED
    return RISES if rising > falling else FALLS


def _is_none(start: float, end: float) -> bool:
    """Return whether two figures differ by at most a hundredth of the larger one."""
    return abs(end - start) <= MIN_DIFFERENCE * max(abs(start), abs(end))


def _turns_back(line: np.ndarray) -> bool:
    """Return whether a block runs against its own direction by more than a tenth of its range."""
    known = line[np.isfinite(line)]
    low, high = float(known.min()), float(known.max())
    if len(known) < 3 or _is_none(low, high):
        return False
    fall = float((np.maximum.accumulate(known) - known).max())
    rise = float((known - np.minimum.accumulate(known)).max())
    reversal = fall if known[-1] > known[0] else rise if known[-1] < known[0] else min(fall, rise)
    return reversal > MAX_REVERSAL * (high - low)


def sign_test(first: int, second: int) -> float:
    """Return the two-sided probability of counts at least as uneven as these if both signs are equally likely."""
    total, larger = first + second, max(first, second)
    tail = sum(math.comb(total, count) for count in range(larger, total + 1)) / 2.0**total
    return min(1.0, 2.0 * tail)


def _rank_effects(cases: Cases, drawn: Sequence[str], values: np.ndarray) -> list[tuple[str, dict[str, Any]]]:
    """Return the effect of each drawn variable by partial rank correlation, as (path, entry)."""
    is_known = np.isfinite(values)
    variables = {path: np.array(cases.codes[path][0])[cases.codes[path][1]][is_known] for path in drawn}
    known, entries = values[is_known], []
    for path, variable in variables.items():
        entry: dict[str, Any] = {"verdict": NOT_DECIDED, "from": None, "to": None, "pairs": len(known)}
        entry |= {"share": None, "method": "ranks"}
        if len(known) >= MIN_DRAWS and _is_none(float(known.min()), float(known.max())):
            entry["verdict"] = NONE
        elif len(known) >= MIN_DRAWS:
            others = [other for name, other in variables.items() if name != path]
            partial = ranks.partial_rank_correlation(variable, known, others)
            low, high = np.quantile(variable, (QUARTILE, 1.0 - QUARTILE))
            entry["from"], entry["to"] = (
                float(np.median(known[variable <= low])),
                float(np.median(known[variable >= high])),
            )
            entry["share"] = None if math.isnan(partial.value) else float(partial.value**2)
            entry["verdict"] = RISES if partial.low > 0.0 else FALLS if partial.high < 0.0 else NOT_DECIDED
        entries.append((path, entry))
    return entries
