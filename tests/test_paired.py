"""How a figure goes with a value where all else is equal: an exact interval of the power, whatever the distribution."""

import math

import numpy as np
import pytest
from scipy.stats import binom, kendalltau

from clearsweep.report import effects
from clearsweep.report.effects import trend_exponent


def test_an_exact_power_is_found_and_its_interval_is_that_value():
    x, factors = np.array([1e-5, 2e-5, 5e-5]), np.array([[1.0], [30.0], [1e4]])
    estimate, pairs = trend_exponent(x, factors * x**0.7)
    assert pairs == 9
    assert estimate == pytest.approx((0.7, 0.7, 0.7))


def test_of_pairs_alone_the_interval_is_that_of_the_sign_test():
    slopes = np.array([-0.4, -0.1, 0.2, 0.3, 0.5, 0.8, 0.9, 1.5, 3.0])
    estimate, pairs = trend_exponent(np.array([1.0, math.e]), np.exp(np.column_stack([0.0 * slopes, slopes])))
    beyond = int(binom.ppf(0.025, 9, 0.5)) - 1  # as many as these fall short of the truth in at most 2.5 % of samples
    assert pairs == 9
    assert estimate == pytest.approx((0.5, slopes[beyond], slopes[-1 - beyond]))


@pytest.mark.parametrize(("rows", "values", "ends"), [(5, 2, False), (6, 2, True), (1, 4, False), (1, 5, True)])
def test_too_few_pairs_give_no_interval(rows, values, ends):
    """Five signs, or the order of four values, come about at random in more than 5 % of samples."""
    x = np.arange(1.0, values + 1.0)
    estimate, _ = trend_exponent(x, np.tile(x, (rows, 1)))
    assert estimate.value == pytest.approx(1.0)
    assert math.isfinite(estimate.low) == math.isfinite(estimate.high) == ends


def test_the_interval_contains_zero_as_often_as_kendalls_test_does_not_reject():
    generator, x = np.random.default_rng(3), np.arange(1.0, 9.0)
    for _ in range(50):
        row = generator.lognormal(0.05 * x, 0.3)
        estimate, _ = trend_exponent(x, row[None, :])
        assert (estimate.low > 0.0 or estimate.high < 0.0) == (kendalltau(x, row, method="exact").pvalue <= 0.05)


def test_the_interval_contains_the_truth_as_often_as_stated_for_heavy_tails():
    generator, x = np.random.default_rng(5), np.array([1.0, 2.0, 4.0])
    contents = 0
    for _ in range(400):
        table = x**0.3 * np.exp(generator.laplace(0.0, 0.3, (12, 3)) ** 3 + generator.normal(0.0, 2.0, (12, 1)))
        estimate, _ = trend_exponent(x, table)
        contents += estimate.low <= 0.3 <= estimate.high
    assert contents >= 0.93 * 400


def test_rows_with_gaps_count_what_they_have_and_without_pairs_nothing_is_known():
    x = np.array([1.0, 2.0, 4.0])
    table = np.array([[1.0, 2.0, np.nan], [np.nan, 3.0, np.nan], [5.0, np.nan, 20.0]])
    estimate, pairs = trend_exponent(x, table)
    assert (pairs, estimate.value) == (2, pytest.approx(1.0))
    nothing, none = trend_exponent(x, table[1:2])
    assert none == 0
    assert math.isnan(nothing.value)


def test_many_pairs_are_taken_as_normal_to_within_one_of_the_count(monkeypatch):
    sizes = np.full(300, 4)
    counted = effects.slopes_beyond(sizes, 0.025)
    monkeypatch.setattr(effects, "MAX_EXACT_PAIRS", 0)
    assert abs(effects.slopes_beyond(sizes, 0.025) - counted) <= 1
