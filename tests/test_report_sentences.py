"""Sentences of the report: one unit for what is compared, peaks compared with p99, every joint's own elastic range."""

import re

import numpy as np
import pytest
from fake_runs import Run
from matplotlib.figure import Figure

from clearsweep.judging import validity
from clearsweep.language import wording
from clearsweep.report import motion, study
from clearsweep.report.section import Cards, Points
from clearsweep.report.sections import drivers, headline, peaks, summary, tradeoffs, verdict
from clearsweep.report.table import Quantity

JOINT, P99, PEAK = "joints.rod-slider", "rod_slider_force_p99", "rod_slider_force_peak"
SLOW, FAST = 30.0, 500.0  # rad/s: forces of 10 N and of 10 kN
SPEEDS = {"drive.speed": [SLOW, 150.0, FAST], f"{JOINT}.clearance": [5e-5, 5e-4]}


@pytest.fixture
def run():
    """Return a run whose forces go over three decades, and which compares its peaks with the ideal ones."""
    made = Run(SPEEDS, histories=True)
    made.summary["rod_slider_load_peak"] = made.summary[PEAK]
    made.summary["rod_slider_force_peak_ratio"] = made.summary["drive.speed"].rsub(2.0 * FAST)  # largest where slow
    made.summary["rod_slider_force_peak_median"] = 1e3 * made.summary[PEAK]
    made.summary["period"] = np.nan
    return made


def units(text):
    """Return the units of force in a text, each once."""
    return set(re.findall(r"\d\u00a0([mkMµ]?N)(?![\w\u00a0])", text))


def test_values_that_are_compared_have_the_unit_of_the_largest():
    assert wording.alike((18.8e3, 109.0, None), "N") == ["18.8\u00a0kN", "0.109\u00a0kN", wording.DASH]
    assert wording.alike((3e-6, 2e-4), "m") == ["0.00300\u00a0mm", "0.200\u00a0mm"]


def test_a_sentence_has_one_unit_of_force(run):
    prepared = study.prepare(run)
    message = [*headline.sentences(prepared), *verdict.ratios(prepared)]
    message[:0] = drivers.sentences(prepared, prepared.joints[0])
    assert sum(bool(units(sentence)) for sentence in message) >= 4
    assert all(len(units(sentence)) < 2 for sentence in message), message
    assert units(message[-1]) == {"kN"}  # of a median of some kN the peak and the ideal one, both less, take the unit


def test_the_rows_of_a_figure_have_one_unit(run):
    (table,) = drivers.more(study.prepare(run))[0].tables
    cells = [cell.text for row in table.rows if row[0] == "force peak" for cell in (row[4], row[6])]
    assert len(cells) == 4
    assert units(" ".join(cells)) == {"kN"}


def test_the_largest_peak_is_named_with_what_p99_sees_of_it(run):
    hidden = run.summary[P99].idxmin()
    run.summary.loc[hidden, PEAK] = 9e6
    message = headline.sentences(study.prepare(run))[0]
    assert message.startswith("Largest force peak: 9.00\u00a0MN at ")
    assert "crank speed 286.5\u00a0rpm" in message
    assert "(p99 " in message


def test_cards_and_pictures_have_the_speed_at_which_the_joint_first_yields(run):
    made = Run(SPEEDS, strength=600e6)
    made.summary["rod_slider_yield_speed"] = 0.35
    prepared = study.prepare(made)
    (cards,) = summary.sections(prepared)[0].blocks
    assert isinstance(cards, Cards)
    beside = {name: beside for name, _, beside in cards.cards}["Fastest onset"]
    assert beside == "its contact first yields at 0.35\u00a0m/s"
    captions = [picture.caption for _, picture in tradeoffs.sections(prepared)[0].pictures]
    assert "The contact first yields at 0.35\u00a0m/s." in captions
    assert lines(made) == pytest.approx({"first yield (rod-slider)": 0.35})
    made.summary["rod_slider_yield_speed"] = 40.0  # far beyond: a line would press all onsets to the bottom
    assert lines(made) == {}


def test_unknown_strengths_are_not_judged(run):
    prepared = study.prepare(run)
    (cards,) = summary.sections(prepared)[0].blocks
    assert {name: beside for name, _, beside in cards.cards}["Fastest onset"] == "first yield not judged"
    captions = [picture.caption for _, picture in tradeoffs.sections(prepared)[0].pictures]
    assert any("is not judged: it takes a yield strength or a hardness" in caption for caption in captions)
    assert lines(run) == {}


STEEL = {"young": 207e9, "poisson": 0.3, "yield_strength": 600e6}


@pytest.mark.parametrize("kind", ["a column without a value", "spatial, guide: no column"])
def test_a_joint_that_cannot_be_judged_is_not_asked_for_the_strength_it_has(kind):
    made = Run(SPEEDS, strength=600e6 if kind.startswith("a column") else None)
    made.summary["rod_slider_yield_speed"] = np.nan
    contact = {"law": "flores", "elastic": "johnson", "restitution": 0.7, "material": STEEL}
    made.grid["joints"]["rod-slider"]["contact"] = contact
    prepared = study.prepare(made)
    captions = " ".join(picture.caption for _, picture in tradeoffs.sections(prepared)[0].pictures)
    assert "is not judged for this kind of joint or law." in captions
    assert "it takes a yield strength" not in captions
    (cards,) = summary.sections(prepared)[0].blocks
    assert {name: beside for name, _, beside in cards.cards}["Fastest onset"] == "first yield not judged"


def test_closing_lines_claim_nothing_of_joints_that_cannot_be_judged():
    remarks = validity.Remarks(["rod_slider"])
    columns = {"rod_slider_onset_rate_max": [9.0], "rod_slider_law_limit_fraction": [0.0]}
    for judged in ({}, {"rod_slider_yield_speed": [None]}):
        remarks.add({"case_id": ["a"], "message": [""], **columns, **judged})
    assert remarks.sentences() == []


def lines(made):
    """Return label -> speed (m/s) of the lines in the picture of the onsets of a run's first case."""
    prepared = study.prepare(made)
    case_id = prepared.cases.index[0]
    (picture,) = motion.onsets(prepared, case_id, made.events(case_id), made.orbit(case_id))
    axes = Figure().subplots()
    picture.paint(axes)
    return {line.get_label(): line.get_ydata()[0] for line in axes.lines if line.get_label().startswith("first yield")}


def test_joints_have_a_line_each():
    run = Run({}, joints=("crank_rod", "rod_slider"), strength=600e6)
    run.summary["crank_rod_yield_speed"], run.summary["rod_slider_yield_speed"] = 0.2, 0.4
    assert lines(run) == pytest.approx({"first yield (crank-rod)": 0.2, "first yield (rod-slider)": 0.4})


def test_an_error_beyond_the_horizon_is_said_to_check_nothing():
    made = Run(SPEEDS, checked=True)
    frame = made.summary
    frame["horizon_revolutions"] = [1.98, 1.98, 5.0, np.nan, 3.0, 2.5]
    frame["rod_slider_force_peak_revolution"] = [3, 2, 4, 7, 3, 2]
    frame["rod_slider_force_peak_difference"] = 2.02e-4
    prepared = study.prepare(made)
    (section,) = peaks.sections(prepared)
    table = next(table for table in section.tables if table.key == "certainty")
    place = [column.name for column in table.columns].index("error of force peak")
    cells = {row[0]: row[place] for row in table.rows}
    said = {case_id: cell.text for case_id, cell in cells.items() if isinstance(cell, Quantity)}
    # a peak in revolution 2 may lie after 1.98 revolutions, one in revolution 3 not after 3
    first, second = frame["case_id"][:2]
    assert said == {
        first: "peak in revolution 3, horizon 2.0 revolutions: no check of convergence",
        second: "peak in revolution 2, horizon 2.0 revolutions: no check of convergence",
    }
    assert all(cell.value == 2.02e-4 for cell in cells.values() if isinstance(cell, Quantity))
    (points,) = (block for block in section.blocks if isinstance(block, Points))
    assert "is no check of convergence in 2 of 6 cases" in points.texts[0]
    assert "In 3 chaotic cases the peak lies within the horizon" in points.texts[1]
    assert "a check of the first revolutions alone" in points.texts[1]


def test_the_sentence_on_an_unchecked_peak_names_its_own_joint():
    made = Run(SPEEDS, joints=("crank_rod", "rod_slider"), checked=True)
    frame = made.summary
    frame["horizon_revolutions"] = 2.0
    frame["crank_rod_force_peak_revolution"] = np.nan  # never touched
    frame["rod_slider_force_peak_revolution"] = [3, 1, 1, 1, 1, 1]
    (section,) = peaks.sections(study.prepare(made))
    (points,) = (block for block in section.blocks if isinstance(block, Points))
    assert points.texts[0].startswith("The error of the force peak in joint rod-slider is no check of convergence in 1")
    assert "the peak in joint rod-slider lies within" in points.texts[1]
    assert len(points.texts) == 2


def test_without_a_horizon_nothing_is_said_of_single_errors():
    made = Run(SPEEDS, checked=True)
    made.summary["horizon_revolutions"] = np.nan
    (section,) = peaks.sections(study.prepare(made))
    assert not any(isinstance(block, Points) for block in section.blocks)
