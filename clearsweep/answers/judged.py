"""The judged cases of a run: their varied values as codes, their figures and verdicts; statistics of cases."""

import math
from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from ..contracts import catalogue
from ..language.wording import is_missing
from .verdict import Assessment, Limit, LimitsAndFigures, limits_and_figures_of

MET, EXCEEDED, UNDECIDED = "met", "exceeded", "undecided"  # verdicts of a case
#: Last keys of numerical settings of which the smaller value is the finer one; of all others it is the larger one.
FINER_IF_SMALLER = ("tolerance", "velocity_scale", "v0", "v1", "width", "from")

CASES_AT_ONCE = 4096  # of which numbers are made at a time: so memory hardly grows with them

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
        is_own = np.ones(len(columns["status"]), bool) if own is None else np.asarray(own, bool)
        self.added_count = int((~is_own).sum())
        self._columns = columns
        self.role_by_path: dict[str, str] = dict(record.get("roles") or {})
        self._rows = np.flatnonzero(is_own).astype("u4")
        self.paths = [path for path in self.role_by_path if self._is_varied(path)]
        numerics = self.paths_of(catalogue.NUMERICS)
        if numerics and len(self._rows):
            # For every own case the position of the finest case that differs in numerics alone, and a mask of these
            others = [path for path in self.paths if path not in numerics]
            group = combined_codes([codes_of(self.values(path))[1] for path in others], len(self))
            fineness = [fineness_of(path, codes_of(self.values(path))[1]) for path in numerics]
            order = np.lexsort([*fineness[::-1], group])
            is_last = np.append(np.diff(group[order]) != 0, True)
            finest_of_group = dict(zip(group[order][is_last].tolist(), order[is_last].tolist(), strict=True))
            finest_of = np.array([finest_of_group[number] for number in group.tolist()])
            self.finest_of, is_finest = finest_of, finest_of == np.arange(len(self))
            self._all_rows = self._rows
            self._rows = self._rows[is_finest]
        self.codes = {path: codes_of(self.values(path)) for path in self.paths if path not in numerics}
        self.is_finished = self.values("status") == "ok"

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

    def labels_of(self, rows: np.ndarray) -> dict[str, dict[str, list[str]]]:
        """Return under `labels` the texts that ride along with some judged cases, by header; {} without such texts."""
        names = [name for name in self.record.get("case_labels") or [] if name in self._columns]
        texts = {name: [str(text) for text in self.values(name)[rows].tolist()] for name in names}
        return {"labels": {name: list(dict.fromkeys(each)) for name, each in texts.items()}} if names else {}

    def values(self, name: str) -> np.ndarray:
        """Return a column of the judged cases; it is not to be changed."""
        values = _array(self._columns[name])
        return values if len(values) == len(self._rows) else values[self._rows]

    def case_id(self, row: int) -> str:
        """Return the identity of a judged case."""
        return str(_array(self._columns["case_id"])[self._rows[[row]]].astype(str)[0])

    def numbers(self, name: str) -> np.ndarray:
        """Return a figure of the judged cases as floats, not to be changed; NaN if missing or if the case failed."""
        values = floats(self.values(name))
        known: np.ndarray = values if self.is_finished.all() else np.where(self.is_finished, values, np.nan)
        return known

    def values_of_all(self, name: str) -> np.ndarray:
        """Return a column of the own cases, coarse ones included."""
        values: np.ndarray = _array(self._columns[name])[self._all_rows]
        return values

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
        return limits_and_figures_of(self.record).limits

    @cached_property
    def assessment(self) -> Assessment:
        """Return how the judged cases compare with the limits."""
        names = {name for limit in self.limits for name in limit.required_columns}
        columns = {name: self.numbers(name) for name in names}
        return LimitsAndFigures((), self.limits).assess(columns, self.is_finished)

    @cached_property
    def verdicts(self) -> np.ndarray:
        """Return the verdict of every judged case, (n,)."""
        exceeded, undecided = self.assessment.exceeded.any(axis=0), self.assessment.undecided.any(axis=0)
        return np.where(exceeded, EXCEEDED, np.where(undecided, UNDECIDED, MET))


def fineness_of(path: str, codes: np.ndarray) -> np.ndarray:
    """Return numbers (n,) that increase with the fineness of the values at a numerical path."""
    return -codes if path.rpartition(".")[2] in FINER_IF_SMALLER else codes


def combined_codes(columns: Sequence[np.ndarray], count: int) -> np.ndarray:
    """Return one number for each case that is equal where all codes are; columns : (n,) each."""
    number = np.zeros(count, np.int64)
    for codes in columns:
        number *= int(codes.max(initial=0)) + 2
        number += codes
        number += 1
        number = _without_gaps(number)
    return number


def _without_gaps(numbers: np.ndarray) -> np.ndarray:
    """Return the place of each number, from 0, among those that occur, (n,); sorting takes five times the memory."""
    if numbers.max(initial=0) > 4 * len(numbers):
        numbers = np.unique(numbers, return_inverse=True)[1].reshape(-1)
    places: np.ndarray = (np.cumsum(np.bincount(numbers) > 0) - 1)[numbers]
    return places


def codes_of(values: np.ndarray) -> tuple[list, np.ndarray]:
    """Return the distinct values, numbers ascending, texts in order of appearance, and each value's index; null: -1."""
    if values.dtype.kind in "fiub":
        is_known = np.isfinite(values)
        ordered = np.sort(values[is_known])  # np.unique loads masked arrays, in 9 ms
        distinct = ordered[np.diff(ordered, prepend=np.nan) != 0.0]
        kind = "i2" if len(distinct) < 2**15 - 1 else "i4"
        return distinct.tolist(), np.where(is_known, np.searchsorted(distinct, values), -1).astype(kind)
    present = [value for value in values.tolist() if not is_missing(value)]
    has_text = any(isinstance(value, str) for value in present)
    levels = list(dict.fromkeys(present)) if has_text else sorted(set(present))
    index_of = {value: index for index, value in enumerate(levels)}
    return levels, np.array([-1 if is_missing(value) else index_of[value] for value in values.tolist()], "i4")


def named_value(record: Mapping[str, Any], path: str, value: Any) -> Any:
    """Return a varied value as the answer has it: the label or the fit if it has one, a law's name, else SI."""
    for name, labelled in ((record.get("labels") or {}).get(path) or {}).items():
        if labelled == value:
            return name
    for fit in (record.get("fits") or {}).get(path) or ():
        if fit["mean"] == value:
            return fit["name"]
    return plain_value(value)


def plain_value(value: Any) -> Any:
    """Return a value as JSON has it: a word, a truth value or a float."""
    return value if isinstance(value, str | bool) else float(value)


def _array(values: Any) -> np.ndarray:
    return values if isinstance(values, np.ndarray) else np.array(list(values), object)


def floats(values: np.ndarray) -> np.ndarray:
    """Return a column as floats, NaN for null."""
    if values.dtype.kind == "O":
        return np.array([np.nan if is_missing(value) else value for value in values.tolist()], float)
    return values.astype(float, copy=False)


# ---------------------------------------------------------------------------------------------- statistics


# Probability of exceeding a limit, from the cases of a random sample.

RANDOM_METHODS = ("sobol", "latin-hypercube", "random")  # methods whose points represent the distributions
ONE_AT_A_TIME = "one-at-a-time"  # method whose cases are no designs
CONFIDENCE = 0.95  # of intervals


class Estimate(NamedTuple):
    """An estimate and its confidence interval; an end is NaN if the sample is too small."""

    value: float
    low: float
    high: float


def median(values: np.ndarray) -> float:
    """Return the median of known numbers, NaN of none; that of numpy loads its masked arrays, in 25 ms."""
    if not len(values):
        return math.nan
    low, high = np.sort(values)[[(len(values) - 1) // 2, len(values) // 2]].tolist()
    return float(0.5 * (low + high))


def binomial_interval(count: int, cases: int) -> tuple[float, float, float]:
    """Return the probability from `count` of `cases`, and the ends of Clopper and Pearson's exact interval."""
    from scipy.stats import binomtest

    test = binomtest(count, cases)
    interval = test.proportion_ci(CONFIDENCE, method="exact")
    return float(test.statistic), float(interval.low), float(interval.high)


def binomial_distribution(count: int, probability: float) -> np.ndarray:
    """Return the probabilities (count + 1,) of at most 0, 1, ... successes in `count` trials."""
    successes = np.arange(1, count + 1)
    ratios = (count + 1 - successes) / successes * (probability / (1.0 - probability))  # of each to one fewer
    logarithms = np.concatenate([[0.0], np.cumsum(np.log(ratios))])
    sums = np.cumsum(np.exp(logarithms - logarithms.max()))
    cumulative: np.ndarray = sums / sums[-1]
    return cumulative


def is_one_sample(record: Mapping[str, Any]) -> bool:
    """Return whether the cases of a run are one random sample, by its run.json."""
    sample = record.get("sample") or {}
    return sample.get("method") in RANDOM_METHODS and {*record.get("units", ())} == {*sample.get("drawn", ())}


# Analysis of variance of a figure over varied values: the share of each.

PASSES = 20  # of the fit of main effects; one is exact if every combination finished


def variance_shares(values: np.ndarray, value_indices: list[np.ndarray]) -> list[float]:
    """Return, for each axis, its share of the variance of a figure, corrected for chance; NaN: undefined.

    The variance is that of log(values) where all values are positive, else that of the values.
    `value_indices` : per axis the index of each case on it, (cases,).  The scatter is the residual of the sum of all
    main effects (analysis of variance without interactions); without degrees of freedom no share is defined.
    """
    is_known = np.isfinite(values)
    known = values[is_known]
    is_positive = bool((known > 0.0).all())
    residuals = np.log(known) if is_positive else known / max(float(np.abs(known).max(initial=0.0)), 1e-300)
    groups = [_without_gaps(indices[is_known] + 1).astype(indices.dtype) for indices in value_indices]
    freedoms = [int(group.max(initial=0)) for group in groups]
    residual_freedom = len(residuals) - 1 - sum(freedoms)
    residuals -= residuals.mean() if len(residuals) else 0.0
    del known
    total = float(residuals @ residuals)
    if residual_freedom <= 0 or total <= 1e-20 * len(residuals):  # all values equal, except for rounding
        return [np.nan] * len(value_indices)
    sums_between = [float(np.bincount(group) @ _group_means(group, residuals) ** 2) for group in groups]
    for _ in range(PASSES):
        for group in groups:
            means = _group_means(group, residuals)
            for first in range(0, len(group), CASES_AT_ONCE):
                residuals[first : first + CASES_AT_ONCE] -= means[group[first : first + CASES_AT_ONCE]]
    scatter = max(float(residuals @ residuals) / residual_freedom, 1e-12 * total)
    between = zip(sums_between, freedoms, strict=True)
    return [max(0.0, (sum_of_squares - freedom * scatter) / total) for sum_of_squares, freedom in between]


def _group_means(group: np.ndarray, values: np.ndarray) -> np.ndarray:
    means: np.ndarray = np.bincount(group, values) / np.bincount(group)
    return means


# Rank correlations of drawn variables with a figure, simple and partial, and their intervals.
#
# Ranks only measure whether the figure increases with the variable, so that a single large peak has little weight.

NORMAL_QUANTILE = 1.959963984540054  # standard deviations: 95 % of a normal distribution are within


def rank_values(values: np.ndarray) -> np.ndarray:
    """Return the ranks of values (n,); equal values share a rank."""
    from scipy.stats import rankdata

    ranked: np.ndarray = rankdata(values)
    return ranked


def rank_correlation(x: np.ndarray, y: np.ndarray) -> Estimate:
    """Return Spearman's rank correlation and its 95 % interval (Bonett & Wright 2000, Psychometrika 65:23).

    The result is NaN if one of them is constant, or with fewer than five values.
    """
    return _with_interval(_correlation(rank_values(x), rank_values(y)), len(x), 0)


def partial_rank_correlation(x: np.ndarray, y: np.ndarray, others: list[np.ndarray]) -> Estimate:
    """Return the rank correlation of the residuals of both ranks after linear regression on the ranks `others`.

    Iman, Shortencarier & Johnson 1985 (SAND85-0044): PRCC.
    """
    regressors = np.column_stack([np.ones(len(x)), *(rank_values(other) for other in others)])
    residuals = []
    for values in (rank_values(x), rank_values(y)):
        residual = values - regressors @ np.linalg.lstsq(regressors, values, rcond=None)[0]
        residuals.append(np.where(np.abs(residual) > 1e-9 * len(x), residual, 0.0))  # below this it is rounding
    return _with_interval(_correlation(*residuals), len(x), len(others))


def _correlation(x: np.ndarray, y: np.ndarray) -> float:
    x, y = x - x.mean(), y - y.mean()
    norm = math.sqrt(float(x @ x) * float(y @ y))
    return min(max(float(x @ y) / norm, -1.0), 1.0) if norm > 0.0 else math.nan


def _with_interval(correlation: float, count: int, controlled_count: int) -> Estimate:
    """Return a correlation and its interval by Fisher's transformation."""
    degrees_of_freedom = count - controlled_count - 3
    if math.isnan(correlation) or degrees_of_freedom < 2:
        return Estimate(correlation if degrees_of_freedom >= 2 else math.nan, math.nan, math.nan)
    if abs(correlation) >= 1.0:
        return Estimate(correlation, correlation, correlation)
    half_width = NORMAL_QUANTILE * math.sqrt((1.0 + 0.5 * correlation * correlation) / degrees_of_freedom)
    return Estimate(
        correlation, math.tanh(math.atanh(correlation) - half_width), math.tanh(math.atanh(correlation) + half_width)
    )


MIN_CASES = 8  # cases: correlations of fewer are meaningless
QUANTILES = (0.05, 0.5, 0.95)
STRENGTH_NOTE = "Strength of an effect: 0 means none, 1 that the variable decides alone."


def variable_correlations(drawn: Mapping[str, np.ndarray], values: np.ndarray) -> list[tuple[str, Estimate, Estimate]]:
    """Return variable, rank correlation with a figure, and partial rank correlation, the strongest first.

    Return [] if there are too few cases or the figure is constant.

    drawn : path -> (n,) values; values : (n,), NaN for null
    """
    is_known = np.isfinite(values)
    if is_known.sum() < MIN_CASES or np.ptp(values[is_known]) == 0.0:
        return []
    rows, known_values = [], {path: np.asarray(column_values, float)[is_known] for path, column_values in drawn.items()}
    for path, variable in known_values.items():
        others = [other for name, other in known_values.items() if name != path]
        simple_correlation = rank_correlation(variable, values[is_known])
        rows.append((path, simple_correlation, partial_rank_correlation(variable, values[is_known], others)))
    return sorted(rows, key=lambda row: -abs(np.nan_to_num(row[2].value)))


def is_clear(correlation: Estimate) -> bool:
    """Return whether the interval of a correlation excludes 0."""
    return correlation.low > 0.0 or correlation.high < 0.0


def direction_verb(correlation: float) -> str:
    """Return 'rises' or 'falls', the trend of a figure with a variable."""
    return "rises" if correlation > 0.0 else "falls"
