"""Sentences on the cases of one random sample: chances of exceeding limits, spread of figures, and its drivers."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from ..language import wording
from . import labels, probability, ranks, verdict, wear
from .cases import Cases
from .probability import Estimate, is_one_sample

__all__ = ["correlations", "driver_sentences", "is_clear", "is_one_sample", "sentences", "spread"]

MIN_CASES = 8  # cases: correlations of fewer are meaningless
QUANTILES = (0.05, 0.5, 0.95)
PERIOD = "period"  # column
EXTREME_SUFFIXES = ("_peak", "_max", "_min", "_ratio")  # ends of figures that are extremes of a window
QUARTILE = 0.25  # of the cases: those with the lowest and with the highest values of a variable

Texts = Callable[[Sequence[float]], list[str]]


def correlations(drawn: Mapping[str, np.ndarray], values: np.ndarray) -> list[tuple[str, Estimate, Estimate]]:
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
        simple = ranks.rank_correlation(variable, values[is_known])
        rows.append((path, simple, ranks.partial_rank_correlation(variable, values[is_known], others)))
    return sorted(rows, key=lambda row: -abs(np.nan_to_num(row[2].value)))


def is_clear(correlation: Estimate) -> bool:
    """Return whether the interval of a correlation excludes 0."""
    return correlation.low > 0.0 or correlation.high < 0.0


def driver_sentences(
    drawn: Mapping[str, np.ndarray], values: np.ndarray, names: Mapping[str, str], format_values: Texts
) -> list[str]:
    """Return sentences on the drivers of a figure, called 'it', with direction and size of the strongest.

    Return [] if there are too few cases.

    drawn, values : as for `correlations`; names : path -> words; format_values : values of the figure -> words
    """
    ranked = correlations(drawn, values)
    clear = [
        (path, partial_correlation.value)
        for path, _simple, partial_correlation in ranked
        if is_clear(partial_correlation)
    ]
    if not clear:
        return ["No variable has a clear effect on it."] if ranked else []
    (path, strongest), *others = clear
    low, high = format_values(_quarters(np.asarray(drawn[path], float), values))
    lines = [
        f"It {_verb(strongest)} most with {names[path]} (partial rank correlation {wording.plain(strongest, 2)}): "
        f"median {low} in its lowest quarter, {high} in its highest."
    ]
    if others:
        listed = [f"{_verb(value)} with {names[path]} ({wording.plain(value, 2)})" for path, value in others[:3]]
        lines.append(f"It also {wording.sentence_list(listed)}.")
    return lines


def _verb(correlation: float) -> str:
    return "rises" if correlation > 0.0 else "falls"


def _quarters(x: np.ndarray, values: np.ndarray) -> list[float]:
    """Return the medians of a figure over the lowest and over the highest quarter of a variable."""
    is_known = np.isfinite(values)
    x, y = x[is_known], values[is_known]
    low, high = np.quantile(x, (QUARTILE, 1.0 - QUARTILE))
    return [float(np.median(y[x <= low])), float(np.median(y[x >= high]))]


def sentences(cases: Cases) -> list[str]:
    """Return sentences on chance, spread and drivers of the limited figures, or of the leading one, and on wear."""
    limits = cases.limits
    columns = list(dict.fromkeys(limit.column for limit in limits if cases.has(limit.column)))
    worst_case = None if columns else cases.worst()
    columns += [worst_case[1][0]] if worst_case else []
    lines = longer_run_warning(cases, columns) if limits else []
    for name in columns:
        values = cases.column(name).astype(float)
        probabilities = [_exceedance(cases, limit) for limit in limits if limit.column == name]
        texts = cases.texts(name, np.nanquantile(values[np.isfinite(values)], QUANTILES).tolist())
        drivers = _drivers(cases, values, partial(cases.texts, name))
        subject = "Its median is" if probabilities else f"{labels.capital(cases.label(name))}: median"
        lines.append(" ".join([*probabilities, spread(subject, texts), *drivers]))
    for joint in cases.layout.joints:
        if (depths := wear.depth_in_1000_hours(cases, joint)) is not None:
            lines.append(_wear(cases, joint, depths))
    return lines


def longer_run_warning(cases: Cases, limited_columns: Sequence[str]) -> list[str]:
    """Return a sentence that longer runs exceed limits on extremes more often; [] if all motions are periodic.

    limited_columns : columns
    """
    columns = {column.name: column for column in cases.layout.columns}
    limits_extremes = any(
        columns[name].figure.endswith(EXTREME_SUFFIXES) for name in limited_columns if name in columns
    )
    if PERIOD not in columns or not limits_extremes:
        return []
    irregular, total = int(np.isnan(cases.column(PERIOD).astype(float)).sum()), len(cases.case_ids)
    if not irregular:
        return []
    return [
        f"{irregular} of {wording.count(total, 'motion')} did not become periodic within the run: longer "
        "runs exceed limits on peaks more often. The order of the drivers may change, too. "
        "To count more revolutions, raise simulate.revolutions."
    ]


def _wear(cases: Cases, joint: Any, depths: np.ndarray) -> str:
    """Return the spread of the wear depth in 1000 hours of a joint, whether it is a forecast, and its drivers."""
    known_cases = np.flatnonzero(np.isfinite(depths))
    quantiles = np.quantile(depths[known_cases], QUANTILES).tolist()
    median_case = int(known_cases[np.argsort(depths[known_cases])[(len(known_cases) - 1) // 2]])
    texts = wording.in_common_unit(quantiles, "m")
    return " ".join(
        [
            *wear.remark(
                cases, joint, median_case, float(depths[median_case]), "In the median case, the wear per 1000 h"
            ),
            spread(f"Wear depth per 1000 h{cases.joint_text(joint.name)}: median", texts),
            *_drivers(cases, depths, lambda numbers: wording.in_common_unit(numbers, "m")),
        ]
    )


def _drivers(cases: Cases, values: np.ndarray, format_values: Texts) -> list[str]:
    drawn = {path: cases.column(path).astype(float) for path in cases.axes}
    pairs = {path: cases.named_value(0, path) for path in cases.axes}
    return driver_sentences(
        drawn, values, {path: pair[0] if pair else path for path, pair in pairs.items()}, format_values
    )


def _exceedance(cases: Cases, limit: verdict.Limit) -> str:
    """Return a sentence with the probability that a limit is exceeded."""
    columns = {name: cases.column(name).astype(float) for name in (limit.column, limit.times) if name}
    is_exceeded = limit.fails(columns)
    words = labels.capital(cases.limit_label(limit))
    probability_text = probability.percentages(probability.binomial_interval(int(is_exceeded.sum()), len(is_exceeded)))
    return f"{words}: exceeded with a probability of {probability_text}."


def spread(subject: str, texts: Sequence[str], interval: str = "") -> str:
    """Return the sentence on the spread of a figure; subject : 'Force peak: median'; texts : its QUANTILES in words."""
    low, median, high = texts
    return f"{subject} {median}{interval}; 90 % of the cases are between {low} and {high}."
