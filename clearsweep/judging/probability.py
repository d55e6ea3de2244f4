"""Probability of exceeding a limit, from the cases of a random sample."""

from collections.abc import Mapping
from typing import Any, NamedTuple

RANDOM_METHODS = ("sobol", "latin-hypercube", "random")  # methods whose points represent the distributions
CONFIDENCE = 0.95  # of intervals


class Estimate(NamedTuple):
    """An estimate and its confidence interval; an end is NaN if the sample is too small."""

    value: float
    low: float
    high: float


def binomial_interval(count: int, cases: int) -> tuple[float, float, float]:
    """Return the probability from `count` of `cases`, and the ends of Clopper and Pearson's exact interval."""
    from scipy.stats import binomtest

    test = binomtest(count, cases)
    interval = test.proportion_ci(CONFIDENCE, method="exact")
    return float(test.statistic), float(interval.low), float(interval.high)


def is_one_sample(record: Mapping[str, Any]) -> bool:
    """Return whether the cases of a run are one random sample, by its run.json."""
    sample = record.get("sample") or {}
    drawn = sample.get("drawn", {})
    return sample.get("method") in RANDOM_METHODS and set(record.get("units", {})) == set(drawn)


def percentages(probability: tuple[float, float, float]) -> str:
    """Return a probability with its interval: '22 % (95 %: 12 to 34 %)'."""
    value, low, high = (f"{100.0 * value:.2g}" for value in probability)
    return f"{value} % (95 %: {low} to {high} %)"


def window_text(record: Mapping[str, Any]) -> str:
    """Return ' within the 3 counted revolutions', without the number where a run ends by itself or varies it."""
    section = record.get("simulate") or {}
    revolutions, discard = section.get("revolutions"), section.get("discard", 0.0)
    is_fixed = isinstance(revolutions, int | float) and isinstance(discard, int | float) and not section.get("until")
    if not is_fixed or {"simulate.revolutions", "simulate.discard"} & set(record.get("units", {})):
        return " within the counted revolutions"
    counted = revolutions - discard
    return f" within the {counted:g} counted revolutions" if counted != 1.0 else " within one revolution"


def sentence(probability: tuple[float, float, float], record: Mapping[str, Any]) -> str:
    """Return the probability that any limit is exceeded in the counted revolutions, in words; record : run.json."""
    return (
        f"At least one limit is exceeded with a probability of {percentages(probability)}{window_text(record)}. "
        "The interval is that of the number of cases alone."
    )
