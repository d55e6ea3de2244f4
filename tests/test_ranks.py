"""Rank correlations of a sample: against scipy, the closed form of partial correlation, coverage, and the report."""

import csv

import numpy as np
import pytest
from scipy import stats
from test_sensitivity import CLEARANCE, PEAK, SPEED, YOUNG, linear, run  # noqa: F401 - a fixture

from clearsweep import report
from clearsweep.answers.judged import partial_rank_correlation, rank_correlation


def test_a_rank_correlation_is_that_of_spearman():
    random = np.random.default_rng(2)
    x = random.integers(0, 9, 60).astype(float)  # with ties
    y = x + random.normal(0.0, 4.0, 60)
    assert rank_correlation(x, y).value == pytest.approx(stats.spearmanr(x, y).statistic, rel=1e-12)
    assert rank_correlation(np.arange(9.0), np.exp(np.arange(9.0))) == (1.0, 1.0, 1.0)
    assert np.isnan(rank_correlation(np.arange(9.0), np.ones(9)).value)


def test_a_partial_correlation_with_one_other_has_its_closed_form():
    random = np.random.default_rng(4)
    x, z = random.normal(size=(2, 80))
    y = x + 2.0 * z + random.normal(size=80)
    xy, xz, yz = (stats.spearmanr(*pair).statistic for pair in ((x, y), (x, z), (y, z)))
    expected = (xy - xz * yz) / np.sqrt((1.0 - xz**2) * (1.0 - yz**2))
    assert partial_rank_correlation(x, y, [z]).value == pytest.approx(expected, rel=1e-10)


def test_intervals_hold_the_truth_about_as_often_as_they_say():
    random, contents = np.random.default_rng(6), []
    truth = 6.0 / np.pi * np.arcsin(0.6 / 2.0)  # Spearman's of two normal variables whose correlation is 0.6
    for _ in range(400):
        x, noise = random.normal(size=(2, 80))
        result = rank_correlation(x, 0.6 * x + 0.8 * noise)
        contents.append(result.low <= truth <= result.high)
    assert 0.91 < np.mean(contents) < 0.99


def test_the_report_names_what_drives_a_sample_and_its_limits(run, tmp_path):  # noqa: F811
    made = run(linear, more=f"limits: {{{PEAK}: 13 N}}\n")
    report.tables(made, tmp_path)
    with open(tmp_path / "rank_drivers.csv", encoding="utf-8") as stream:
        rows = [row for row in csv.DictReader(stream) if row["figure"] == "force peak"]
    assert [row["variable"] for row in rows][:2] == ["clearance", "crank speed"]
    summary = made.summary
    for row, path in zip(rows, (CLEARANCE, SPEED, YOUNG), strict=True):
        x, y = summary[path].to_numpy(), summary[PEAK].to_numpy()
        assert float(row["rank correlation"]) == pytest.approx(stats.spearmanr(x, y).statistic, rel=1e-9)
        upper = y[x > np.median(x)] > 13.0
        assert float(row["upper half"]) == pytest.approx(upper.mean(), rel=1e-12)
    assert float(rows[0]["others fixed"]) > 0.99
    assert abs(float(rows[2]["rank correlation"])) < 0.25
    assert float(rows[0]["limits exceeded, lower half"]) < 0.2
    assert float(rows[0]["upper half"]) > 0.8
