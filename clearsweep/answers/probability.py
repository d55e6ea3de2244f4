"""Probability of exceeding a limit, from the cases of a random sample."""

from collections.abc import Mapping
from typing import Any, NamedTuple

RANDOM_METHODS = ("sobol", "latin-hypercube", "random")  # methods whose points represent the distributions
ONE_AT_A_TIME = "one-at-a-time"  # method whose cases are no designs
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
