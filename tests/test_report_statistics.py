"""Statistics that a report gives: how figures go with values, lives, borders, two runs, shares and times."""

import csv
import json
import math
import re

import numpy as np
import pytest
from fake_runs import RPM, Run
from hypothesis import given
from hypothesis import strategies as st
from right_grids import grid_of
from scipy import stats
from scipy.stats import binom, kendalltau
from test_sensitivity import CLEARANCE, PEAK, SPEED, YOUNG, linear, run  # noqa: F401 - a fixture

import clearsweep
from clearsweep import report
from clearsweep.answers.judged import Estimate, partial_rank_correlation, rank_correlation
from clearsweep.answers.words import FIELD_BY_COLUMN, Lifetime, hours_text, interval_text, spread_text
from clearsweep.contracts.layout import Column, Layout
from clearsweep.language.errors import InputError
from clearsweep.report import effects
from clearsweep.report.blocks.section import painted
from clearsweep.report.documents import two_runs
from clearsweep.report.effects import trend_exponent
from clearsweep.report.sections.sample import estimate_cells
from clearsweep.report.sections.setup import PATH, differences
from clearsweep.report.study import prepare
from clearsweep.searches.seeking import AGREEING_NEIGHBOURS, Border, expected_probe_count, scan_indices, search
from clearsweep.sweeping.facts import LifeExtremes, SlowestCase


@pytest.mark.parametrize(("largest", "reduce"), [(False, np.median), (True, np.max)])
def test_matched_tables_have_the_median_or_the_largest_of_the_cases_in_each_cell(largest, reduce):
    chance = np.random.default_rng(7)
    values = np.where(chance.random(200) < 0.2, np.nan, chance.normal(size=200))
    groups, rows, codes = chance.integers(0, 12, 300), chance.integers(0, 200, 300), chance.integers(-1, 5, 300)
    levels = np.array([1.0, 2.0, 3.0, 5.0, 8.0])
    table = effects.MatchedCases(None, groups, rows, levels, codes).table(values, largest=largest)
    assert len(table.groups) > 5
    for group, of_group in zip(table.groups, table.values, strict=True):
        for level, value in zip(table.levels, of_group, strict=True):
            in_cell = values[rows[(groups == group) & (codes >= 0) & (levels[codes] == level)]]
            known = in_cell[~np.isnan(in_cell)]
            np.testing.assert_equal(value, reduce(known) if len(known) else np.nan)


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


# Rank correlations of a sample: against scipy, the closed form of partial correlation, coverage, and the report.


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


def test_the_report_names_what_drives_a_sample_and_its_limits(run, tmp_path):  # noqa: F811  # noqa: F811
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


# How lives are reported: intervals of the numerics whose ends differ, and what uncertain coefficients make of them.


def life(share, hours=85.5, **more):
    """Return a life of some hours whose interval is a share of it to either side."""
    return Lifetime(hours, 1000.0, 1000.0 / (1.0 + share), 1000.0 / (1.0 - share), **more)


def plainly(text):
    return text.replace("\u00a0", " ")


@pytest.mark.parametrize("share", [0.3, 0.02, 2e-3, 1.3e-4, 2.5e-5, 1e-7, 0.0])
def test_the_ends_of_an_interval_differ_or_it_is_reported_by_its_width(share):
    text = plainly(interval_text(life(share)))
    assert text.startswith("computing error alone, 95 %: ")
    text = text.removeprefix("95 %")
    numbers = [float(number) for number in re.findall(r"([\d.]+) h", text)]
    if numbers:
        low, high = numbers
        assert low < 85.5 < high
        assert (low, high) == pytest.approx((85.5 / (1.0 + share), 85.5 / (1.0 - share)), rel=0.5 * share)
    else:
        known = float(re.search(r"± (?:under )?([\d.]+) %", text)[1])
        assert "under" in text if 100.0 * share < 1e-3 else known == pytest.approx(100.0 * share, rel=0.05)


def test_a_life_without_an_upper_end_says_so():
    assert interval_text(Lifetime(85.5, 1000.0, 994.0, math.inf)).endswith(": at least 85.0 h")
    assert "at least" in interval_text(Lifetime(85.5, 1000.0, 994.0, math.nan))


def test_an_end_that_is_not_known_is_not_said_to_be_endless():
    low = spread_text(life(0.02, revolutions_low_with_wear_uncertainty=1000.0 / 3.0))
    high = spread_text(life(0.02, revolutions_high_with_wear_uncertainty=3000.0))
    assert plainly(low) == "With the uncertain wear coefficients: 28.5 h to unknown"
    assert plainly(high) == "With the uncertain wear coefficients: unknown to 256 h"


def test_a_coefficient_without_uncertainty_has_the_usual_one():
    known = life(0.02, revolutions_low_with_wear_uncertainty=400.0, revolutions_high_with_wear_uncertainty=3100.0)
    assert plainly(spread_text(known)) == "With the uncertain wear coefficients: 34.2 h to 265 h"
    assert plainly(spread_text(life(0.02))).endswith("coefficient: 28.5 to 8.55 h")


def test_the_extremes_are_the_shortest_and_the_longest_life():
    columns = tuple(Column(f"pin_{name}", "1", "") for name in [*FIELD_BY_COLUMN][:4])
    lives = LifeExtremes(
        Layout("planar", True, "", (), columns, (), life="pin"), {"of": "wear_depth_max", "limit": 2e-5}
    )
    hours = np.array([40.0, 85.5, np.nan, 20.0, 60.0])
    block = {"pin_life_hours": hours, "pin_life_revolutions": np.full(5, 1000.0)}
    block |= {"pin_life_low": np.full(5, 990.0), "pin_life_high": np.full(5, 1010.0)}
    lives.add(block, lambda place: {"case_id": f"{place}" * 16, "swept": {"drive.speed": place}})
    facts = lives.facts()
    assert [facts[end]["hours"] for end in ("shortest", "longest")] == [20.0, 85.5]
    assert (facts["unreached"], facts["shortest"]["text"]) == (1, "20.0 h")
    hours[0] = math.inf
    lives.add(block, lambda place: {"case_id": f"{place}" * 16, "swept": {"drive.speed": place}})
    assert (lives.facts()["unlimited"], lives.facts()["longest"]["hours"]) == (1, 85.5)
    assert hours_text(life(0.02)) == "85.5 h"
    assert LifeExtremes(Layout("planar", True, "", (), columns, ()), {}).facts() is None


# The border of values within limits is found where it is sharp, and enclosed where it is not.


def bisected(good, last):
    """Return the border where `good` says what is good, and all places that were looked at."""
    known = {}
    for _ in range(200):
        step = search(known, last)
        if step.border is not None:
            return step.border, known
        assert step.probes
        assert not known.keys() & set(step.probes)
        known |= {place: good(place) for place in step.probes}
    raise AssertionError("no end")


@given(st.integers(2, 12), st.data())
def test_a_sharp_border_is_found_exactly_with_few_looks(power, data):
    last = 2**power
    border = data.draw(st.integers(0, last - 1))
    answer, known = bisected(lambda place: place <= border, last)
    assert answer == Border(border, border + 1)
    assert len(known) <= 5 + power + 2 * AGREEING_NEIGHBOURS
    assert abs(len(known) - expected_probe_count(last)) <= 4


@pytest.mark.parametrize("last", [4, 64])
def test_all_good_and_all_bad_are_reported(last):
    assert bisected(lambda place: True, last)[0] == Border(last, None)
    answer, known = bisected(lambda place: False, last)
    assert answer == Border(None, 0)
    assert set(known) == set(scan_indices(last))


def test_what_is_good_again_beyond_a_bad_stretch_is_not_relied_upon():
    assert bisected(lambda place: place <= 20 or place >= 60, 64)[0] == Border(20, 21)


def test_good_places_that_begin_later_count():
    assert bisected(lambda place: 30 <= place <= 50, 64)[0] == Border(50, 51)


@given(st.integers(4, 9), st.integers(0, 2**32), st.floats(0.3, 0.7), st.integers(2, 30))
def test_in_noise_the_answer_encloses_the_border_and_what_agrees_with_it(power, seed, share, wide):
    import random

    last = 2**power
    chance = random.Random(seed)
    flips = {place: chance.random() < 0.5 for place in range(last + 1)}
    border = round(share * last)

    def good(place):
        return flips[place] if abs(place - border) < wide else place < border

    answer, known = bisected(good, last)
    if answer.last_good is None:
        return
    assert known[answer.last_good]
    assert all(
        known[place] for place in range(answer.last_good - AGREEING_NEIGHBOURS, answer.last_good) if place in known
    )
    if answer.first_bad is not None:
        assert answer.last_good < answer.first_bad
        assert not known[answer.first_bad]
        assert not any(
            known[place]
            for place in range(answer.first_bad + 1, answer.first_bad + 1 + AGREEING_NEIGHBOURS)
            if place in known
        )
    assert len(known) <= 5 + power + 2 * AGREEING_NEIGHBOURS + 6 * (power + 1)


# Two runs are compared by the values that either varies, and what differs is given in numbers.


SHORT = {CLEARANCE: [1e-4, 2e-4], "drive.speed": [1000 * RPM, 3000 * RPM]}


def harder(run, factor=2.0):  # noqa: F811
    """Return a run whose force peak is larger by a factor."""
    run.summary["rod_slider_force_peak"] *= factor
    run.directory = "harder"
    return run


def made(**options):
    result = Run(**options)
    result.directory = "plain"
    return result


def tables_of(first, second, tmp_path):
    two_runs.comparison_page(first, second).write_tables(tmp_path)
    return {path.stem: list(csv.DictReader(path.read_text().splitlines())) for path in tmp_path.glob("*.csv")}


def test_every_case_meets_its_counterpart_and_the_factor_between_them_is_reported(tmp_path):
    result = tables_of(made(sweep=SHORT), harder(made(sweep=SHORT)), tmp_path)
    figures = {row["column"]: row for row in result["compared_figures"]}
    assert float(figures["rod_slider_force_peak"]["B over A, median"]) == pytest.approx(2.0)
    assert list(figures) == ["rod_slider_force_peak"]  # the others are the same
    assert float(figures["rod_slider_force_peak"]["cases that differ"]) == 1.0
    assert len(result["compared_cases"]) == 4
    assert all(float(row["B over A"]) == pytest.approx(2.0) for row in result["compared_cases"])


def test_a_value_that_one_run_sweeps_and_the_other_has_fixed_is_matched():
    several, single = made(sweep=SHORT), made(sweep={CLEARANCE: [1e-4, 5e-4]})
    speed = prepare(single).base["drive"]["speed"]
    several.summary.loc[several.summary["drive.speed"] == 1000 * RPM, "drive.speed"] = speed
    pairs = two_runs.pair_cases(prepare(several), prepare(single))
    assert len(pairs.case_ids) == 1
    assert pairs.unpaired == (3, 1)


def test_runs_without_a_case_in_common_are_refused():
    with pytest.raises(InputError, match="no finished case of one has the same values"):
        two_runs.pair_cases(prepare(made(sweep={CLEARANCE: [1e-4]})), prepare(made(sweep={CLEARANCE: [2e-4]})))


def test_the_page_says_what_differs_in_the_setup():
    heavier = harder(made(sweep=SHORT))
    heavier.grid["mechanism"]["slider"]["mass"] = 0.28
    plain = made(sweep=SHORT)
    for each, bound in ((plain, 4e3), (heavier, 5e3)):
        each.grid |= {"limits": {"rod_slider_force_peak": bound}}
        each.grid["keys"] = ["mechanism", "limits"]
    text = two_runs.comparison_page(plain, heavier).text()
    mass = "mechanism.slider.mass from 0.14\u00a0kg to 0.28\u00a0kg"
    limit = "limits.rod_slider_force_peak from 4\u00a0kN to 5\u00a0kN"
    changed = text.index(f"Changed from A to B: {mass}; {limit}.")
    verdict = text.index("A: None of 2 designs")
    largest = text.index("Largest change of a figure with a unit: the force peak of B is 2.00 times that of A")
    assert changed < verdict < largest < text.index("4 cases finished in both runs")
    assert "4 cases finished in both runs" in text
    assert "The force peak of B is 2.00 times that of A in the median case" in text
    assert "Equal in every case: force rms, force p99" in text


def test_what_is_drawn_is_each_case_of_b_over_that_of_a():
    first, second = made(sweep=SHORT), harder(made(sweep=SHORT))
    (name, picture), *_ = two_runs.comparison_page(first, second).sections[0].pictures
    assert (name, picture.title) == ("", "Force peak of B over A")
    (points,) = (item for item in painted(picture)[0].axes.items if item.kind == "points")
    drawn = 1e3 * np.stack([points.x, points.y], -1)
    forces = first.summary["rod_slider_force_peak"].to_numpy()
    assert drawn[np.argsort(drawn[:, 0])] == pytest.approx(np.sort(forces)[:, np.newaxis] * [1.0, 2.0], rel=1e-12)


# The error of a position is clearance and indentation: the answer splits it where the contact is soft.


MASS, CRANK, YOKE_SPEED, YOKE_CLEARANCE = 1.2, 0.04, 31.4159, 2e-5  # kg, m, rad/s, m
YOKE = grid_of("a yoke")


@pytest.mark.parametrize("stiffness", [1e7, 1e11])
def test_the_answer_splits_an_error_into_clearance_and_indentation(stiffness, tmp_path):
    contact = {"law": "flores", "stiffness": stiffness, "exponent": 1.5, "restitution": 0.5}
    grid = YOKE | {"joints": {"slot": YOKE["joints"]["slot"] | {"contact": contact}}}
    clearsweep.sweep(grid, out=tmp_path / "run", executor="serial")
    answer = json.loads((tmp_path / "run" / "answer.json").read_text())
    largest = next(entry["largest"] for entry in answer["extremes"] if entry["figure"] == "output_error_max")
    static = (MASS * CRANK * YOKE_SPEED**2 / stiffness) ** (2.0 / 3.0)  # m, Hertz under the force at the dead centres
    if static < 0.1 * YOKE_CLEARANCE:
        assert "indentation" not in largest
        return
    assert largest["indentation"] == pytest.approx(static, rel=0.03)
    assert largest["value"] - largest["indentation"] == pytest.approx(YOKE_CLEARANCE, rel=0.03)


@pytest.mark.parametrize(("limit", "is_hopeless"), [(0.2e-3, True), (0.29e-3, False)])
def test_it_says_where_no_clearance_can_meet(limit, is_hopeless, tmp_path):
    contact = {"law": "flores", "stiffness": 1e7, "exponent": 1.5, "restitution": 0.5}
    grid = YOKE | {"joints": {"slot": YOKE["joints"]["slot"] | {"contact": contact}}}
    clearsweep.sweep(grid | {"limits": {"output_error_max": limit}}, out=tmp_path / "run", executor="serial")
    text = (tmp_path / "run" / "answer.json").read_text()
    assert "is indentation at the stiffness given" in text
    assert ("No clearance can meet" in text) == is_hopeless


# The section on error against run time of a run that sweeps its tolerance.


JOINT_PEAK = "j_force_peak"


def test_each_case_is_compared_with_the_finest_of_the_same_values():
    cases = {
        PATH: np.array([1e-4, 1e-6, 1e-8] * 2),
        "drive.speed": np.array([1.0] * 3 + [2.0] * 3),
        "run_time": np.array([1.0, 2.0, 4.0, 3.0, 6.0, 12.0]),
        JOINT_PEAK: np.array([110.0, 101.0, 100.0, 8.0, 9.8, 10.0]),
    }
    tolerances, run_times, changes = differences(cases, ["drive.speed"], [JOINT_PEAK]).T
    assert tolerances.tolist() == [1e-4, 1e-6]
    assert run_times.tolist() == [2.0, 4.0]
    assert changes.tolist() == pytest.approx([0.15, 0.015])


def test_a_case_without_a_finer_one_is_compared_with_itself_only():
    cases = {PATH: np.array([1e-4, 1e-8]), "law": np.array(["a", "b"]), "run_time": np.ones(2)}
    assert not len(differences(cases | {JOINT_PEAK: np.array([1.0, np.nan])}, ["law"], [JOINT_PEAK]))


# What a run reports of the case that took longest for the time that its machine takes.


def layout_with(*columns, life=""):
    return Layout("slider-crank", True, "slider", (), tuple(Column(name, "s", "") for name in columns), (), life=life)


def told_of(record, layout, block):
    pace = SlowestCase(record, layout)
    assert set(pace.columns) <= set(block)
    if pace.columns:
        pace.add({name: np.array(values) for name, values in block.items()}, lambda place: {"case_id": f"case{place}"})
    return pace.slowest


def test_the_slowest_case_is_the_one_with_the_least_motion_for_its_time():
    record = {"drive": {}, "simulate": {"revolutions": 10.0}, "units": {"drive.speed": "rpm"}}
    block = {"run_time": [0.1, 0.05, 0.3], "drive.speed": [100.0 * math.pi, -400.0 * math.pi, 50.0 * math.pi]}
    slowest = told_of(record, layout_with("run_time"), block)
    assert slowest["case_id"] == "case1"
    assert slowest["factor"] == pytest.approx(10.0 * 2.0 / 400.0 / 0.05, rel=1e-12)


def test_a_run_with_until_counts_the_revolutions_that_were_run():
    record = {"drive": {"speed": 2.0 * math.pi}, "simulate": {"revolutions": 10.0}, "units": {}}
    slowest = told_of(
        record, layout_with("run_time", "revolutions_run"), {"run_time": [2.0], "revolutions_run": [40.0]}
    )
    assert slowest["factor"] == pytest.approx(20.0, rel=1e-12)


@pytest.mark.parametrize("life", ["", "rod-slider"])
def test_nothing_is_reported_of_lives_and_of_cranks_without_a_speed(life):
    record = {"drive": {"speed": 10.0} if life else {"torque": 3.0}, "simulate": {"revolutions": 10.0}, "units": {}}
    assert told_of(record, layout_with("run_time", life=life), {"run_time": [1.0]}) is None


@pytest.mark.parametrize(
    ("low", "high", "text"),
    [(math.nan, math.nan, "2.00"), (1.0, 3.0, "2.00 (1.00 to 3.00)"), (1.0, math.nan, "2.00 (1.00 to \N{EN DASH})")],
)
def test_an_estimate_without_an_interval_has_no_brackets(low, high, text):
    assert estimate_cells(Estimate(2.0, low, high), "1")[0].text == text
