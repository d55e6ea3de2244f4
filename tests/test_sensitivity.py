"""Claims about what a sample says: estimators against known distributions, sensitivities against known functions."""

import csv

import fake_physics
import numpy as np
import pandas as pd
import pytest
from fake_physics import sweep
from fake_runs import CONTACT, JOINT, TEXT, OfFrame, load
from scipy import stats

from clearsweep import report
from clearsweep.answers.judged import QUANTILES
from clearsweep.language.errors import InputError
from clearsweep.report import effects
from clearsweep.report.sections.sample import limit_table
from clearsweep.report.study import answer_of_study, prepare

pytestmark = pytest.mark.heavy

CLEARANCE, SPEED, YOUNG = f"{JOINT}.clearance", "drive.speed", f"{CONTACT}.material.young"
MATERIAL = TEXT.replace("      stiffness: 6.61e10 N/m^1.5\n", "      material: {young: 207 GPa, poisson: 0.3}\n")
PEAK = "rod_slider_force_peak"


class Run(OfFrame):
    """A run as the store hands it out, its figures made up from the swept values: no histories, nothing simulated."""

    def __init__(self, text, figure, failing=(), overrides=None):
        cases = load(text, overrides)
        self.layout = cases.layout
        units = {column.name: column.unit for column in self.layout.columns}
        self.grid = cases.resolved() | {"units": {path: cases.unit(path) for path in cases.axes}}
        self.grid |= {"roles": cases.roles, "layout": cases.layout.written()}
        rows = []
        for k in range(len(cases)):
            point, failed = cases.point(k), k in failing
            figures = {name: None if failed else figure(point) for name in units}
            status = "step-budget" if failed else "ok"
            rows.append({"case_id": cases.case_id(k), **point, "status": status, "message": "", **figures})
        self.summary = pd.DataFrame(rows).sort_values("case_id", ignore_index=True)
        self.summary.attrs["units"] = units | self.grid["units"]

    def orbit(self, _case_id):
        """Return no history."""
        return pd.DataFrame({channel.name: np.empty(0) for channel in self.layout.channels})

    def wear(self, _case_id):
        """Return unworn bodies."""
        return {joint.name: (np.zeros(joint.wear_bins),) * 2 for joint in self.layout.joints if joint.wear_bins}


@pytest.fixture
def run(tmp_path):
    """Return a function that makes a run of a made-up figure of a sampled grid up."""

    def make(figure, method="sobol", n=64, seed=7, more="", **options):
        head = f"method: {method}" + ("" if method == "one-at-a-time" else f", n: {n}, seed: {seed}")
        over = f"{CLEARANCE}: {{uniform: [1 mm, 2 mm]}}, {SPEED}: {{uniform: [10 rad/s, 20 rad/s]}}"
        over += f", {YOUNG}: {{uniform: [1, 2]}}"
        text = tmp_path / "text.yaml"
        text.write_text(f"{MATERIAL}sample: {{{head}, over: {{{over}}}}}\n{more}", encoding="utf-8")
        return Run(text, figure, **options)

    return make


def linear(point):
    """Return a figure to which clearance adds 0 to 4, speed 0 to 2, Young's modulus nothing."""
    return 10.0 + 4.0 * (point[CLEARANCE] / 1e-3 - 1.0) + 0.2 * (point[SPEED] - 10.0)


def unit(value):
    """Return a variable of `linear` between 0 and 1, wildly mixed: what chaos would make of it."""
    return (value * 1e14) % 1.0


# --------------------------------------------------------------------------------------------------- samples


@pytest.mark.few("sobol-10.0-inf")
@pytest.mark.parametrize(("method", "least", "most"), [("random", 2.5, 6.5), ("sobol", 10.0, np.inf)])
def test_the_error_of_a_mean_falls_as_expected(run, method, least, most):
    """Sixteen times the cases: a fourth of the error where points are independent, much less for a Sobol sequence."""
    errors = []
    for n in (16, 256):
        result = [effects.samples_of(run(linear, method, n, seed))[0] for seed in range(20)]
        errors.append(np.sqrt(np.mean([(first.figures[PEAK].mean() - 13.0) ** 2 for first in result])))
    assert least < errors[0] / errors[1] < most


@pytest.mark.slow
def test_intervals_hold_the_truth_about_as_often_as_they_say():
    chance, contents = np.random.default_rng(3), []
    for _ in range(200):
        values = chance.normal(10.0, 2.0, 100)
        message = effects.summarise_spread(values)
        exceeded = effects.exceedance_probability(values > 12.0)
        truths = (10.0, 0.2, *(stats.norm.ppf(share, 10.0, 2.0) for share in QUANTILES), stats.norm.sf(1.0))
        estimates = (message.mean, message.cv, *message.quantiles, exceeded)
        contents.append(
            [not (first.low > truth or first.high < truth) for first, truth in zip(estimates, truths, strict=True)]
        )
    assert (np.mean(contents, axis=0) > 0.88).all()


def test_a_quantile_has_no_end_that_the_sample_is_too_small_for():
    lowest, middle, highest = effects.summarise_spread(np.arange(20.0)).quantiles
    assert np.isnan(lowest.low)
    assert np.isnan(highest.high)
    assert middle.low < middle.value < middle.high


def test_equal_values_have_no_spread():
    message = effects.summarise_spread(np.full(16, 0.1))
    assert message.cv == (0.0, 0.0, 0.0)
    assert all(first == (0.1, 0.1, 0.1) for first in message.quantiles)


def limit_rows(run):
    """Return heading -> cell of every row of the table of limits of a run."""
    table = limit_table(prepare(run), effects.samples_of(run))
    return [dict(zip([column.name for column in table.columns], row, strict=True)) for row in table.rows], table.note


@pytest.mark.parametrize("failing", [(), (3, 4, 40)])
def test_failed_cases_count_as_failures_in_a_probability_of_their_own(run, failing):
    """Exact binomial intervals of both counts, failed cases left out and counted."""
    made = run(linear, failing=failing, more=f"limits: {{{PEAK}: 14 N, rod_slider_force_rms: 15 N}}\n")
    values = made.summary[PEAK].dropna().to_numpy(float)
    rows, note = limit_rows(made)
    beyond = [np.count_nonzero(values > limit) for limit in (14.0, 15.0)]
    assert 0 < beyond[1] < beyond[0] < len(values)
    assert len(rows) == 3  # two limits, and at least one of them
    for row, count in zip(rows, [beyond[1], beyond[0], beyond[0]], strict=True):  # rms, peak, either
        result = row["probability of exceeding it"]
        assert result.value == pytest.approx(count / len(values))
        if not failing:
            assert "or of failing" not in row
            continue
        either = stats.binomtest(count + len(failing), 64)
        low, high = either.proportion_ci(0.95, method="exact")
        assert row["or of failing"].value == pytest.approx(either.statistic)
        assert row["or of failing, low"].value == pytest.approx(low)
        assert row["or of failing, high"].value == pytest.approx(high)
    assert ("3 failed cases" in note) == bool(failing)


def test_a_limit_that_was_never_exceeded_may_still_be():
    assert effects.exceedance_probability(np.arange(64.0) > 63.0) == pytest.approx((0.0, 0.0, 1.0 - 0.025 ** (1 / 64)))


def test_a_sample_is_shown_separately_for_each_setting_of_the_other_axes(run):
    more = "sweep: {mechanism.gravity: [0, 1]}"
    made = run(lambda point: linear(point) * (1 + point["mechanism.gravity"]), more=more)
    first, two = sorted(effects.samples_of(made), key=lambda setting: setting.point["mechanism.gravity"])
    assert [first.point, two.point] == [{"mechanism.gravity": 0.0}, {"mechanism.gravity": 1.0}]
    assert np.array_equal(two.figures[PEAK], 2.0 * first.figures[PEAK])


def test_equal_draws_count_as_often_as_they_were_drawn(run):
    sure = {"method": "sobol", "n": 64, "over": {SPEED: {"uniform": [15, 15]}}}
    made = run(lambda point: point[SPEED], overrides={"sample": sure})
    (first,) = effects.samples_of(made)
    assert len(made.summary) == 1
    assert len(first.case_ids) == 64


def test_a_stored_sample_is_found_again_and_grows(tmp_path):
    over = {"mechanism.slider.mass": {"normal": {"mean": "0.14 kg", "cv": 0.1}}}
    drawn = fake_physics.grid(sample={"method": "sobol", "n": 16, "seed": 7, "over": over})
    drawn.pop("sweep")
    options = {"executor": "serial", "show_progress": False}
    sweep(drawn, tmp_path / "run", **options)
    drawn["sample"]["n"] = 32
    result = sweep(drawn, tmp_path / "run", **options)
    assert (result.ran, result.reused) == (16, 16)
    (first,) = effects.samples_of(result.open())
    assert first.figures[PEAK] == pytest.approx(
        result.open().grid["sample"]["drawn"]["mechanism.slider.mass"], rel=1e-15
    )


def test_failed_cases_are_left_out_and_counted(run):
    (first,) = effects.samples_of(run(linear, failing=(3, 5)))
    assert len(first.failed) == 2
    assert effects.summarise_spread(first.figures[PEAK]).cases == 62


# ----------------------------------------------------------------------------------------------- sensitivities


def test_sobol_indices_of_a_linear_figure(run):
    made = run(linear, "saltelli", 1024)
    (first,) = effects.samples_of(made)
    result = effects.sobol_indices(first, PEAK, list(made.grid["sample"]["drawn"]))
    for index, truth in zip(result, (0.8, 0.2, 0.0), strict=True):
        assert index.first.value == pytest.approx(truth, abs=0.01)
        assert index.total.value == pytest.approx(truth, abs=0.01)
        assert index.first.low <= index.first.value <= index.first.high
    values = first.figures[PEAK].reshape(5, 1, -1)
    scipys = stats.sobol_indices(func={"f_A": values[0], "f_B": values[1], "f_AB": values[2:]}, n=1024)
    assert [index.first.value for index in result] == pytest.approx(scipys.first_order.ravel(), abs=1e-12)
    assert [index.total.value for index in result] == pytest.approx(scipys.total_order.ravel(), abs=1e-12)


@pytest.mark.parametrize("method", ["saltelli", "one-at-a-time"])
def test_a_sensitivity_is_refused_where_a_case_failed(run, method, tmp_path):
    made = run(linear, method, 16, failing=(4,))
    (first,) = effects.samples_of(made)
    describe = effects.sobol_indices if method == "saltelli" else effects.single_effects
    with pytest.raises(InputError, match=f"1 failed: {first.failed[0]}; run them again"):
        describe(first, PEAK, list(made.grid["sample"]["drawn"]))
    assert f"1 failed: {first.failed[0]}" in report.write(made, tmp_path / "page.html").read_text(encoding="utf-8")


def test_one_at_a_time_gives_each_variable_its_effect(run):
    made = run(linear, "one-at-a-time")
    (first,) = effects.samples_of(made)
    result = effects.single_effects(first, PEAK, list(made.grid["sample"]["drawn"]))
    assert [effect.path for effect in result] == [CLEARANCE, SPEED, YOUNG]
    assert [effect.high - effect.low for effect in result] == pytest.approx([3.6, 1.8, 0.0])
    assert not any(effect.is_chaotic for effect in result)


def test_an_effect_within_the_scatter_is_called_chaotic(run):
    made = run(lambda point: linear(point) + 20.0 * unit(sum(point.values())), "one-at-a-time")
    (first,) = effects.samples_of(made)
    result = effects.single_effects(first, PEAK, list(made.grid["sample"]["drawn"]))
    assert result[0].scatter > 5.0
    assert any(effect.is_chaotic for effect in result)


def chance(made):
    """Return what is said of chance in the force peak of a run of method saltelli."""
    (first,) = effects.samples_of(made)
    return effects.share_of_chance(first, PEAK, effects.sobol_indices(first, PEAK, list(made.grid["sample"]["drawn"])))


def noisy(run, share):
    """Return a run of whose force peak's variance this share is chance, and the force peaks of its cases run again.

    Chance is drawn in the order of the swept values: that of case_ids changes with every model version.
    """
    made, random = run(linear, "saltelli", 512), np.random.default_rng(1)
    order = np.lexsort([made.summary[path] for path in made.grid["sample"]["drawn"]])

    def drawn():
        return random.normal(size=len(order))[np.argsort(order)]

    peaks = made.summary[PEAK].astype(float)
    sigma = np.sqrt(share / (1.0 - share) * peaks.var()) if share < 1.0 else peaks.std()
    base = peaks if share < 1.0 else peaks.mean()
    first, again = (base + sigma * drawn() for _ in range(2))
    made.summary[PEAK], made.summary["energy_residual"] = first, drawn()
    return made, again


@pytest.mark.few("0.7-True")
@pytest.mark.parametrize(("share", "chaotic"), [(0.0, False), (0.2, False), (0.7, True), (1.0, True)])
def test_the_share_of_chance_is_measured_by_cases_run_again(run, share, chaotic):
    made, again = noisy(run, share)
    made.summary[f"{PEAK}_difference"] = again - made.summary[PEAK]
    result = chance(made)
    assert result.is_measured
    assert result.share == pytest.approx(share, abs=0.1)
    assert result.is_chaotic == chaotic


@pytest.mark.few("0.2-False", "0.7-True")
@pytest.mark.parametrize(("share", "chaotic"), [(0.0, False), (0.2, False), (0.7, True), (1.0, True)])
def test_the_design_alone_bounds_the_share_of_chance(run, share, chaotic):
    result = chance(noisy(run, share)[0])
    assert not result.is_measured
    assert share - 0.1 < result.share < share + 0.2  # the weakest variable has no part of its own
    assert result.is_chaotic == chaotic


def test_a_variable_that_leaves_the_motion_alone_does_not_bound_chance(run):
    made, _ = noisy(run, 0.7)
    inert = made.summary.groupby([CLEARANCE, SPEED]).transform("first")
    made.summary[[PEAK, "energy_residual"]] = inert[[PEAK, "energy_residual"]]  # Young's modulus changes nothing
    (first,) = effects.samples_of(made)
    indices = effects.sobol_indices(first, PEAK, list(made.grid["sample"]["drawn"]))
    assert [index.total.value for index in indices if index.path == YOUNG] == [0.0]
    assert effects.share_of_chance(first, PEAK, indices).is_chaotic


def test_a_tenth_of_the_tolerance_counts_as_a_disturbance(run):
    made = run(linear, "one-at-a-time")
    made.summary[f"{PEAK}_difference"] = 2.0
    (first,) = effects.samples_of(made)
    result = {effect.path: effect for effect in effects.single_effects(first, PEAK, list(made.grid["sample"]["drawn"]))}
    assert result[SPEED].scatter == pytest.approx(2.0)
    assert result[SPEED].is_chaotic  # its effect is 1.8
    assert not result[CLEARANCE].is_chaotic  # 3.6
    assert result[CLEARANCE].blurred() == pytest.approx(2.0 / 3.6)


# ------------------------------------------------------------------------------------------------------- report


@pytest.mark.slow
@pytest.mark.parametrize("again", [True, False])
def test_the_report_flags_what_is_chaotic_and_says_what_was_not_checked(run, again, tmp_path):
    made, second = noisy(run, 1.0)
    if again:
        made.summary[f"{PEAK}_difference"] = second - made.summary[PEAK]
    text = report.write(made, tmp_path / "page.html").read_text(encoding="utf-8")
    assert ("Force peak is chaotic here" in text) == again
    assert ("is not known to be free of chaos here" in text) != again
    assert ("This run only gives an upper bound of the share of chance" in text) != again
    assert ("A run with <code>error_check: true</code>" in text or "A run with `error_check: true`" in text) != again
    report.tables(made, tmp_path / "tables")
    with open(tmp_path / "tables" / "sensitivity.csv", encoding="utf-8") as stream:
        *_, row = [row for row in csv.DictReader(stream) if row["figure"] == "force peak"]
    assert row["verdict"] == ("chaotic" if again else "may be chaotic")
    assert row["chance was"] == ("measured" if again else "bounded")
    assert float(row["share of chance"]) == pytest.approx(1.0, abs=0.2)


def test_the_verdict_of_a_sample_has_the_probability_with_its_interval(run):
    def verdict_of(more):
        made = run(linear, more=f"limits: {{{PEAK}: 14 N}}\n{more}")
        made.summary["limits_exceeded"] = np.where(made.summary[PEAK] > 14.0, PEAK, "")
        made.summary["limits_undecided"] = ""
        return made, answer_of_study(prepare(made))

    made, answer = verdict_of("")
    beyond = int((made.summary[PEAK] > 14.0).sum())
    low, high = stats.binomtest(64 - beyond, 64).proportion_ci(0.95, method="exact")
    (design,) = answer["designs"]
    assert design["share"]["exceeded"] == beyond / 64
    assert (design["share"]["low"], design["share"]["high"]) == pytest.approx((low, high), rel=1e-12)
    swept = verdict_of("sweep: {mechanism.gravity: [0, 1]}\n")[1]
    assert swept["designs"][0]["conditions"] == 128


def test_the_report_shows_spread_and_limits(run, tmp_path):
    made = run(linear, more=f"limits: {{{PEAK}: 14 N}}\n")
    page = report.write(made, tmp_path / "page.html").read_text(encoding="utf-8")
    for text in ("Spread of the figures", "Probability of exceeding limits", "Histogram of force peak, 64 cases"):
        assert text in page
    assert "Each point is the median over cases" not in page  # hardly two drawn cases share one
    report.tables(made, tmp_path / "tables")
    with open(tmp_path / "tables" / "limits.csv", encoding="utf-8") as stream:
        (row,) = csv.DictReader(stream)
    assert row["figure"] == "force peak"
    assert float(row["limit"]) == 14.0
    assert float(row["probability of exceeding it"]) == pytest.approx(0.25, abs=0.05)
    assert float(row["probability of exceeding it, low"]) < 0.25 < float(row["probability of exceeding it, high"])


@pytest.mark.parametrize(("method", "title"), [("saltelli", "Sobol indices"), ("one-at-a-time", "One-at-a-time")])
def test_the_report_shows_what_drives_the_spread(run, method, title, tmp_path):
    made = run(linear, method, 16, more="sweep: {mechanism.gravity: [0, 1]}")
    assert title in report.write(made, tmp_path / "page.html").read_text(encoding="utf-8")


def test_a_report_without_a_sample_has_no_such_section(tmp_path):
    text = tmp_path / "text.yaml"
    text.write_text(f"{TEXT}zip: {{{SPEED}: [10 rad/s, 20 rad/s], {CLEARANCE}: [1 mm, 2 mm]}}\n")
    page = report.write(Run(text, linear), tmp_path / "page.html").read_text(encoding="utf-8")
    assert "Probabilistic study" not in page
