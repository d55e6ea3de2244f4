"""Limits and own figures: what they say of cases, that they are no part of one, and what a mistake is answered."""

import math

import fake_physics
import numpy as np
import pytest
from mechanism_cases import slider_crank

import clearsweep
from clearsweep import grid
from clearsweep.answers.verdict import Limit, LimitsAndFigures, limits_of
from clearsweep.answers.words import margin_text
from clearsweep.contracts import catalogue
from clearsweep.contracts.layout import Column
from clearsweep.language import expression
from clearsweep.language.errors import InputError
from clearsweep.report.sections import answer as section_of_verdict
from clearsweep.report.study import prepare
from clearsweep.sweeping.summary import of_run

PEAK, IDEAL = "rod_slider_force_peak", "rod_slider_force_peak_ideal"
UNITS = {"force": "N", "other": "N", "length": "m", "rate": "rad/s", "ratio": "1"}
HEADROOM = {"headroom": f"1 - {PEAK} / (2 * {IDEAL})"}


def evaluated(limits, **columns):
    """Return the columns that limits add to some cases."""
    given = {name: np.array(values, float) for name, values in columns.items()}
    return LimitsAndFigures((), limits_of(limits)).evaluate(given)


def test_a_figure_that_is_null_leaves_its_limit_undecided():
    limits = {"force": {"at_most": 8.0, "at_least": -8.0}, "length": 1.0}
    result = evaluated(limits, force=[4.0, math.nan, math.nan], length=[0.5, 0.5, 2.0])
    assert result["limits_exceeded"].tolist() == ["", "", "length"]
    assert result["limits_undecided"].tolist() == ["", "force", "force"]
    assert result["margin"] == pytest.approx([0.5, math.nan, -1.0], nan_ok=True)


@pytest.mark.parametrize("times", [math.nan, math.inf, 1e300])
def test_a_bound_that_is_null_or_overflows_is_undecided_without_warning(times, recwarn):
    limits = {"force": {"at_most": 1e308, "times": "ideal"}}
    result = evaluated(limits, force=[1.0, 1.0], ideal=[times, 1.0])
    assert result["limits_exceeded"].tolist() == ["", ""]
    assert result["limits_undecided"].tolist() == ["force", ""]
    assert np.isnan(result["margin"]).tolist() == [True, False]
    assert not recwarn.list


@pytest.mark.parametrize(
    ("null", "most", "least"),
    [(catalogue.NOTHING, ("", ""), ("", "")), (catalogue.ENDLESS, ("x", ""), ("", "")), ("", ("", "x"), ("", "x"))],
)
def test_a_null_counts_by_what_it_means(null, most, least):
    columns = [Column("x", "1", "", null=null)]
    for kind, expected in (("at_most", most), ("at_least", least)):
        limits = limits_of({"x": {kind: 5.0}}, columns)
        result = LimitsAndFigures((), limits).evaluate({"x": np.array([math.nan, 5.0])})
        names = [result[name].tolist() for name in ("limits_exceeded", "limits_undecided")]
        assert names == [[expected[0], ""], [expected[1], ""]]


@pytest.mark.parametrize(
    ("life", "floor", "most", "least"),
    [
        (math.inf, math.inf, ("x", ""), ("", "")),  # no wear
        (math.nan, 6.0, ("x", ""), ("", "")),  # longer than the bound, though not run to its end
        (math.nan, 5.0, ("", "x"), ("", "x")),
        (math.nan, math.nan, ("", "x"), ("", "x")),
    ],
)
def test_a_life_without_an_end_counts_by_what_is_known(life, floor, most, least):
    columns = [Column("pin_life_hours", "h", "", figure="life_hours", joint="pin")]
    values = {"pin_life_hours": np.array([life, 5.0]), "pin_life_low_hours": np.array([floor, 4.0])}
    for kind, expected in (("at_most", most), ("at_least", least)):
        verdict = LimitsAndFigures((), limits_of({"pin_life_hours": {kind: 5.0}}, columns))
        assert verdict.required_columns() == values.keys()
        result = verdict.evaluate(values)
        names = [result[name].tolist() for name in ("limits_exceeded", "limits_undecided")]
        assert names == [
            [expected[0].replace("x", "pin_life_hours"), ""],
            [expected[1].replace("x", "pin_life_hours"), ""],
        ]


def test_no_margin_is_beyond_a_float():
    result = evaluated({"force": 1e-310}, force=[1.0])
    assert (result["limits_exceeded"].tolist(), np.isfinite(result["margin"]).tolist()) == (["force"], [True])


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("force + other", "N", [5.0, 7.0]),
        ("1 - force / (2 * other)", "1", [1 - 2 / 6, 1 - 3 / 8]),
        ("force * length", "N*m", [8.0, 15.0]),
        ("force / length ** 2", "Pa", [2 / 16, 3 / 25]),
        ("sqrt(force * other)", "N", [6**0.5, 12**0.5]),
        ("max(force, other, '2.5 kN' / 1000)", "N", [3.0, 4.0]),
        ("-abs(force - '5 N')", "N", [-3.0, -2.0]),
        ("force * length * rate", "rad*m^2*kg/s^3", [16.0, 45.0]),
        ("length ** -1.5", "1/m^1.5", [4**-1.5, 5**-1.5]),
        ("force / (other - other)", "1", [math.nan, math.nan]),
    ],
)
def test_expressions_have_the_units_and_values_of_their_columns(text, unit, value):
    columns = {"force": [2, 3], "other": [3, 4], "length": [4, 5], "rate": [2, 3], "ratio": [1, 1]}
    assert expression.unit_of(text, UNITS) == unit
    result = expression.value_of(text, {name: np.array(values, float) for name, values in columns.items()})
    assert result == pytest.approx(value, rel=1e-14, nan_ok=True)


@pytest.mark.parametrize(
    "text",
    [
        "__import__('os').system('true')",
        "force.__class__",
        "(lambda: 1)()",
        "[force for force in (1, 2)]",
        "force if 1 else other",
        "force[0]",
        "f'{force}'",
        "force ** other",
        "force ** 9 ** 9",
        "force and other",
        "force < other",
        "(x := force)",
        "min(*force)",
        "min(force, key=other)",
        "True * force",
        "1j * force",
        "force + length",
        "force + 1",
        "max(force, length)",
        "3 * 4",
        "1e999 * force",
        "force +",
        "",
        "(" * 400 + "force" + ")" * 400,
        "force" + "+ force" * 100,
        "force + '3 furlong'",
    ],
)
def test_all_else_is_refused_and_nothing_is_run(text):
    with pytest.raises(InputError):
        expression.unit_of(text, UNITS)


def test_they_are_no_part_of_a_case_and_of_what_a_directory_fixes(tmp_path):
    plain = grid.load(fake_physics.grid(), fake_physics.CATALOGUE)
    more = {"figures": HEADROOM, "limits": {PEAK: {"at_most": 2, "times": IDEAL}, "headroom": {"at_least": "10 %"}}}
    limited = grid.load(fake_physics.grid(**more), fake_physics.CATALOGUE)
    assert limited.case_id(0) == plain.case_id(0)
    assert limited.fixed_settings() == plain.fixed_settings()
    again = grid.load(limited.resolved(), fake_physics.CATALOGUE)
    assert again.verdict == limited.verdict
    assert again.limits == {PEAK: {"times": IDEAL, "at_most": 2.0}, "headroom": {"at_least": 0.1}}


@pytest.fixture
def ran(tmp_path):
    """Return a function that runs the same made-up cases, of which some fail, under limits; what ran, the summary."""

    def run(**more):
        source = fake_physics.grid(masses=3, gravities=(fake_physics.GOOD, fake_physics.FAILS), **more)
        result = fake_physics.sweep(source, tmp_path / "run", executor="serial", show_progress=False)
        summary = clearsweep.open(result.directory).summary
        return result, summary

    return run


def test_limits_of_a_finished_sweep_are_changed_without_running_a_case(ran):
    plain = ran()[1]
    assert "margin" not in plain
    first, summary = ran(limits={PEAK: "0.1015 N"}, figures=HEADROOM)
    assert (first.ran, first.reused) == (0, 6)
    good = summary[summary["status"] == "ok"]
    assert good["limits_exceeded"].tolist() == ["" if value <= 0.1015 else PEAK for value in good[PEAK]]
    assert good["margin"].tolist() == pytest.approx((1.0 - good[PEAK] / 0.1015).tolist())
    assert good["headroom"].tolist() == pytest.approx((1.0 - good[PEAK] / (2.0 * good[IDEAL])).tolist())
    assert summary.attrs["units"]["headroom"] == "1"
    failed = summary[summary["status"] != "ok"]
    assert len(failed) == 3
    assert failed[["limits_exceeded", "margin", "headroom"]].isna().all(axis=None)
    assert failed["limits_undecided"].tolist() == [PEAK] * 3
    second, summary = ran(limits={"headroom": {"at_least": 0.9}}, figures=HEADROOM)
    assert second.ran == 0
    assert set(summary["limits_exceeded"].dropna()) == {"headroom"}
    assert list(ran()[1].columns) == list(plain.columns)


def test_the_closing_lines_count_cases_that_exceed_limits(ran):
    result, summary = ran(limits={PEAK: "0.1015 N", "steps": {"at_least": 2, "times": "rhs_evaluations"}})
    facts = of_run(result)
    assert facts["limits"]["cases"] == 3
    assert facts["limits"]["exceeding"] == 3
    assert facts["limits"]["each"][PEAK]["cases"] == int((summary[PEAK] > 0.1015).sum()) == 1
    assert facts["limits"]["worst"]["margin"] == summary["margin"].min()
    counts = {"met": 0, "exceeded": 3, "undecided": 3, "added": 0}
    assert facts["answer"]["cases"] == counts
    assert of_run(ran()[0])["limits"] is None


def test_the_worst_case_beyond_a_limit_of_zero_exceeds_it_by_most(ran):
    """Its margin is null, so the largest excess decides, as in the table of cases."""
    result, summary = ran(limits={PEAK: 0, "steps": {"at_most": 1e9}})
    facts = of_run(result)
    worst = summary.loc[summary[PEAK].idxmax(), "case_id"]
    assert facts["limits"]["worst"]["case_id"] == worst == facts["worst"][0]["case_id"]
    assert facts["limits"]["worst"]["margin"] is None
    assert facts["limits"]["worst"]["margin_words"] == "exceeded"


@pytest.mark.parametrize("text", [f"{PEAK} / (0 * steps)", f"0 * {PEAK} / (0 * steps)"])
def test_an_infinite_or_undefined_figure_decides_nothing(ran, text):
    limits = {"ratio": "5 N", PEAK: "1 kN"}
    result, summary = ran(limits=limits, figures={"ratio": text})
    good = summary[summary["status"] == "ok"]
    assert good["limits_exceeded"].tolist() == [""] * 3
    assert good["limits_undecided"].tolist() == ["ratio"] * 3
    assert good[["ratio", "margin"]].isna().all(axis=None)
    facts = of_run(result)
    assert (facts["limits"]["exceeding"], facts["limits"]["unknown"], facts["limits"]["worst"]) == (0, 3, None)
    assert facts["limits"]["each"]["ratio"] == {"limit": "at most 5\u00a0N", "cases": 0, "unknown": 3}
    assert {entry["why"] for design in facts["answer"]["designs"] for entry in design["missing"]} >= {"ratio is null"}
    study = prepare(clearsweep.open(result.directory))
    rows = {row[0]: row for row in section_of_verdict.limit_table(study).rows}
    assert [cell.value for cell in rows["ratio"][2:5]] == [0, 3, 3]
    assert [cell.value for cell in rows[PEAK][2:5]] == [0, 0, 3]


def test_a_case_from_python_is_judged_like_one_of_a_sweep():
    more = {"figures": HEADROOM, "limits": {PEAK: "1 N", "steps": {"at_least": 1}}}
    changes = {"simulate.revolutions": 0.5, "save": {"orbits": "none"}, **more}
    result = clearsweep.simulate(clearsweep.load_case(slider_crank("rod-slider", changes=changes))).summary
    assert result["limits_exceeded"] == PEAK
    assert result["margin"] == pytest.approx(1.0 - result[PEAK], rel=1e-12)
    assert result["headroom"] == pytest.approx(1.0 - result[PEAK] / (2.0 * result[IDEAL]), rel=1e-12)


def test_margins_beyond_a_bound_are_multiples_of_it_and_never_negative():
    force, film = Limit("force", "at_most", 5.0), Limit("film", "at_least", 2.0)
    below = Limit("force", "at_most", -1.0)
    assert margin_text(1.0 - 31.4, (force,)) == "31 times the limit"
    assert margin_text(1.0 - 31.4, (force, Limit("dry", "at_most", 0.0))) == "31 times the limit"  # 0 has no margin
    assert margin_text(-1e-4, (force,)) == "1.0001 times the limit"
    assert margin_text(0.32, (force,)) == "margin 32\u00a0%"
    assert margin_text(337.84, (film,)) == "margin 338 times the limit"
    assert margin_text(-0.75, (film,)) == "0.25 times the limit"
    assert margin_text(-3.0, (below,)) == "beyond the limit by 3 times its size"


def test_a_limit_is_printed_in_the_unit_in_which_it_is_written():
    limits = {PEAK: "30 lbf", "slider_error_max": {"at_most": "5 mil"}}
    verdict = grid.load(fake_physics.grid(limits=limits), fake_physics.CATALOGUE).verdict
    units = {PEAK: "N", "slider_error_max": "m"}
    texts = [limit.bound_text(units[limit.column]) for limit in verdict.limits]
    assert texts == ["at most 30\u00a0lbf", "at most 5\u00a0mil"]
