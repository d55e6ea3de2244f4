"""Sentences on the cases of one random sample: chances of exceeding limits, spread of figures, and its drivers."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from ..language import wording
from . import labels, probability, ranks, verdict, wear
from .cases import FinishedCases
from .probability import Estimate, is_one_sample

__all__ = [
    "direction_verb",
    "driver_sentences",
    "is_clear",
    "is_one_sample",
    "sentences",
    "spread_sentence",
    "variable_correlations",
]

MAX_DRIVER_CARDS = 3
MIN_CASES = 8  # cases: correlations of fewer are meaningless
QUANTILES = (0.05, 0.5, 0.95)
PERIOD = "period"  # column
NO_DRIVER = "No variable has a clear effect on it."
STRENGTH_NOTE = (
    "Strength is the size of the partial rank correlation: 0 means no trend, 1 a strict one with the other variables "
    "fixed."
)
EXTREME_SUFFIXES = ("_peak", "_max", "_min", "_ratio")  # ends of figures that are extremes of a window
LIMIT_MEDIAN = "If it keeps rising, limit the median peak or p99 instead of the largest peak."
QUARTILE = 0.25  # of the cases: those with the lowest and with the highest values of a variable

ValueFormatter = Callable[[Sequence[float]], list[str]]


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
        simple_correlation = ranks.rank_correlation(variable, values[is_known])
        rows.append((path, simple_correlation, ranks.partial_rank_correlation(variable, values[is_known], others)))
    return sorted(rows, key=lambda row: -abs(np.nan_to_num(row[2].value)))


def is_clear(correlation: Estimate) -> bool:
    """Return whether the interval of a correlation excludes 0."""
    return correlation.low > 0.0 or correlation.high < 0.0


def driver_sentences(
    drawn: Mapping[str, np.ndarray],
    values: np.ndarray,
    names: Mapping[str, str],
    format_values: ValueFormatter,
    subject: str = "It",
) -> list[str]:
    """Return sentences on the drivers of a figure, the `subject`, with direction and size of the strongest.

    Return [] if there are too few cases.

    drawn, values : as for `variable_correlations`; names : path -> words; format_values : values of the figure -> words
    """
    ranked = variable_correlations(drawn, values)
    clear = [
        (path, partial_correlation.value)
        for path, _simple, partial_correlation in ranked
        if is_clear(partial_correlation)
    ]
    if not clear:
        return [NO_DRIVER] if ranked else []
    (path, strongest), *others = clear
    low, high = format_values(_quarter_medians(np.asarray(drawn[path], float), values))
    lines = [
        f"{subject} {direction_verb(strongest)} most with {names[path]} (strength "
        f"{wording.number_text(abs(strongest), 2)}): "
        f"median {low} in its lowest quarter, {high} in its highest."
    ]
    if others:
        listed = [
            f"{direction_verb(value)} with {names[path]} ({wording.number_text(abs(value), 2)})"
            for path, value in others[:3]
        ]
        lines.append(f"It also {wording.sentence_list(listed)}.")
    return lines


def driver_cards(cases: FinishedCases) -> list[tuple[str, str, str]]:
    """Return name, strongest driver, and remark of a card for each limited figure and for the wear rate of a joint."""
    figures = [
        (cases.column_label(name), cases.values_of(name).astype(float))
        for name in dict.fromkeys(limit.column for limit in cases.limits)
        if cases.has_values(name)
    ]
    for joint in cases.layout.joints:
        if (depths := wear.depth_in_1000_hours(cases, joint)) is not None:
            figures.append((f"wear rate{cases.joint_text(joint.name)}", depths))
    return [card for label, values in figures[:MAX_DRIVER_CARDS] for card in _driver_card(cases, label, values)]


def _driver_card(cases: FinishedCases, label: str, values: np.ndarray) -> list[tuple[str, str, str]]:
    """Return the card on the drivers of a figure; [] without a clear one."""
    drawn, names = _drawn_variables(cases)
    clear = [(path, partial.value) for path, _, partial in variable_correlations(drawn, values) if is_clear(partial)]
    if not clear:
        return []
    (path, strongest), *others = clear
    listed = [f"{direction_verb(value)} with {names[path]}" for path, value in others[:2]]
    note = f"strength {wording.number_text(abs(strongest), 2)}"
    note += f"; it also {wording.sentence_list(listed)}" if listed else ""
    return [(f"{labels.capitalise(label)} {direction_verb(strongest)} most with", names[path], note)]


def direction_verb(correlation: float) -> str:
    """Return 'rises' or 'falls', the trend of a figure with a variable."""
    return "rises" if correlation > 0.0 else "falls"


def _quarter_medians(x: np.ndarray, values: np.ndarray) -> list[float]:
    """Return the medians of a figure over the lowest and over the highest quarter of a variable."""
    is_known = np.isfinite(values)
    x, y = x[is_known], values[is_known]
    low, high = np.quantile(x, (QUARTILE, 1.0 - QUARTILE))
    return [float(np.median(y[x <= low])), float(np.median(y[x >= high]))]


def sentences(cases: FinishedCases) -> list[str]:
    """Return sentences on chance, spread and drivers of the limited figures, or of the leading one, and on wear."""
    limits = cases.limits
    columns = list(dict.fromkeys(limit.column for limit in limits if cases.has_values(limit.column)))
    worst_case = None if columns else cases.worst_case()
    columns += [worst_case.columns[0]] if worst_case else []
    lines = [" ".join(longer_run_warning(cases, columns))] if limits else []
    has_drivers = False
    for column_name in columns:
        values = cases.values_of(column_name).astype(float)
        probability_sentences = [_exceedance_sentence(cases, limit) for limit in limits if limit.column == column_name]
        quantile_texts = cases.format_values(
            column_name, np.nanquantile(values[np.isfinite(values)], QUANTILES).tolist()
        )
        driver_lines = _sentences_on_drivers(cases, values, partial(cases.format_values, column_name))
        subject = (
            "Its median is"
            if probability_sentences
            else f"{labels.capitalise(cases.column_label(column_name))}: median"
        )
        note = [] if has_drivers or driver_lines in ([], [NO_DRIVER]) else [STRENGTH_NOTE]
        has_drivers |= bool(note)
        lines.append(" ".join([*probability_sentences, spread_sentence(subject, quantile_texts), *driver_lines, *note]))
    for joint in cases.layout.joints:
        if (depths := wear.depth_in_1000_hours(cases, joint)) is not None:
            lines.append(_wear_text(cases, joint, depths))
    return [line for line in lines if line]


def longer_run_warning(cases: FinishedCases, limited_columns: Sequence[str]) -> list[str]:
    """Return sentences that longer runs exceed limits on extremes more often, and on the revolutions that suffice.

    Return [] if all motions are periodic.

    limited_columns : columns
    """
    columns = {column.name: column for column in cases.layout.columns}
    limits_extremes = any(
        columns[name].figure.endswith(EXTREME_SUFFIXES) for name in limited_columns if name in columns
    )
    if PERIOD not in columns or not limits_extremes:
        return []
    irregular, total = int(np.isnan(cases.values_of(PERIOD).astype(float)).sum()), len(cases.case_ids)
    if not irregular:
        return []
    return [
        f"{irregular} of {wording.count_text(total, 'motion')} did not become periodic within the run: longer "
        "runs exceed limits on peaks more often.",
        "The order of the drivers may change, too.",
        _enough_revolutions(cases),
        *([LIMIT_MEDIAN] if any(name.endswith("_peak") for name in limited_columns) else []),
    ]


def _enough_revolutions(cases: FinishedCases) -> str:
    """Return a sentence on the revolutions that suffice."""
    revolutions = (cases.record.get("simulate") or {}).get("revolutions")
    is_varied = "simulate.revolutions" in cases.varied_paths
    next_text = f", to {2.0 * revolutions:g} next," if isinstance(revolutions, int | float) and not is_varied else ""
    return f"The probability is a lower bound: double the revolutions{next_text} until it no longer rises."


def _wear_text(cases: FinishedCases, joint: Any, depths: np.ndarray) -> str:
    """Return the spread and the drivers of the wear of a joint: its depth in 1000 hours, or the hours to the clearance.

    A depth beyond the clearance is no forecast.
    """
    clearances = wear.clearances(cases, joint)
    if clearances is not None and np.nanmedian(depths / clearances) > 1.0:
        hours = 1000.0 * clearances / np.where(depths > 0.0, depths, np.nan)
        subject = (
            f"Hours until the wear{cases.joint_text(joint.name)} equals the clearance, at the rate of the run: median"
        )
        return " ".join(
            [
                spread_sentence(subject, _hours_texts(np.nanquantile(hours, QUANTILES).tolist())),
                "After that the rate changes, so no depth is forecast.",
                *wear.worn_away_sentences(cases, joint, depths),
                *_sentences_on_drivers(cases, depths / 1000.0, _wear_rate_texts, "The wear rate"),
            ]
        )
    quantile_texts = wording.texts_in_common_unit(np.nanquantile(depths, QUANTILES).tolist(), "m")
    return " ".join(
        [
            spread_sentence(f"Wear depth per 1000 h{cases.joint_text(joint.name)}: median", quantile_texts),
            *_sentences_on_drivers(cases, depths, lambda numbers: wording.texts_in_common_unit(numbers, "m")),
        ]
    )


def _hours_texts(hours: Sequence[float]) -> list[str]:
    return [f"{wording.number_text(value, 2)}{wording.BLANK}h" for value in hours]


def _wear_rate_texts(rates: Sequence[float]) -> list[str]:
    return [f"{text}/h" for text in wording.texts_in_common_unit(rates, "m")]


def _sentences_on_drivers(
    cases: FinishedCases, values: np.ndarray, format_values: ValueFormatter, subject: str = "It"
) -> list[str]:
    drawn, names = _drawn_variables(cases)
    return driver_sentences(drawn, values, names, format_values, subject)


def _drawn_variables(cases: FinishedCases) -> tuple[dict[str, np.ndarray], dict[str, str]]:
    """Return the values (n,) of the drawn variables and their names in words, by path."""
    drawn = {path: cases.values_of(path).astype(float) for path in cases.varied_paths}
    names_and_values = {path: cases.describe_value(0, path) for path in cases.varied_paths}
    return drawn, {path: pair[0] if pair else path for path, pair in names_and_values.items()}


def _exceedance_sentence(cases: FinishedCases, limit: verdict.Limit) -> str:
    """Return sentences with the probability that a limit is exceeded, the worst value, and typical revolutions."""
    is_exceeded = _is_exceeded(cases, limit)
    limit_text = labels.capitalise(cases.limit_label(limit))
    probability_text = probability.percentage_text(
        probability.binomial_interval(int(is_exceeded.sum()), len(is_exceeded))
    )
    margins = limit.margin(_limit_columns(cases, limit))
    text = f"{limit_text}: exceeded with a probability of {probability_text}"
    if np.isfinite(margins).any():
        worst = int(np.nanargmin(margins))
        text += f"; the worst is {cases.figure_text(limit.column, worst)}{cases.setting_text(worst)}"
    return f"{text}.{_typical_revolution(cases, limit)}"


def _typical_revolution(cases: FinishedCases, limit: verdict.Limit) -> str:
    """Return how many median peaks exceed a limit on peaks, as ' By the median peak ...'; '' if it is unknown.

    Unlike a largest peak, the median peak does not grow with the run.
    """
    median = f"{limit.column}_median"
    if limit.times or not limit.column.endswith("_peak") or not cases.has_values(median):
        return ""
    exceeding = int(limit._replace(column=median).is_exceeded({median: cases.values_of(median).astype(float)}).sum())
    verb = "exceeds" if exceeding == 1 else "exceed"
    cases_text = wording.count_text(len(cases.case_ids), "case")
    return f" By the median peak per revolution, {exceeding} of {cases_text} {verb} it."


def _limit_columns(cases: FinishedCases, limit: verdict.Limit) -> dict[str, np.ndarray]:
    return {name: cases.values_of(name).astype(float) for name in (limit.column, limit.times) if name}


def _is_exceeded(cases: FinishedCases, limit: verdict.Limit) -> np.ndarray:
    """Return which cases (n,) exceed a limit."""
    return limit.is_exceeded(_limit_columns(cases, limit))


def spread_sentence(subject: str, quantile_texts: Sequence[str], interval: str = "") -> str:
    """Return the sentence on the spread of a figure; subject : 'Force peak: median'; quantile_texts : in words."""
    low, median, high = quantile_texts
    return f"{subject} {median}{interval}; 90 % of the cases are between {low} and {high}."
