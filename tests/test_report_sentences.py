"""Sentences of the report: one unit for what is compared, peaks beside p99, every joint's own elastic range."""

import re

import numpy as np
import pytest
from matplotlib.figure import Figure
from report_fake import Run

from clearsweep.language import wording
from clearsweep.report import motion, study
from clearsweep.report.section import Cards
from clearsweep.report.sections import drivers, headline, summary, tradeoffs, verdict

JOINT, P99, PEAK = "joints.rod-slider", "rod_slider_force_p99", "rod_slider_force_peak"
SLOW, FAST = 30.0, 500.0  # rad/s: forces of 10 N and of 10 kN
SPEEDS = {"drive.speed": [SLOW, 150.0, FAST], f"{JOINT}.clearance": [5e-5, 5e-4]}
POLYMER = {"young": 0.5e9, "poisson": 0.4, "density": 2200.0}
BEARS = 4.767e-3  # m/s: 1e-5 sqrt(0.5e9 / 2200)


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
    told = [*headline.sentences(prepared), *verdict.ratios(prepared)]
    assert sum(bool(units(sentence)) for sentence in told) >= 4
    assert all(len(units(sentence)) < 2 for sentence in told), told
    assert units(told[-1]) == {"kN"}  # of a median of some kN the peak and the ideal one, both less, take the unit


def test_the_rows_of_a_figure_have_one_unit(run):
    (table,) = drivers.sections(study.prepare(run))[0].tables
    cells = [cell.text for row in table.rows if row[0] == "force p99" for cell in (row[4], row[6])]
    assert len(cells) == 4
    assert units(" ".join(cells)) == {"kN"}


def test_the_largest_peak_is_named_where_p99_does_not_see_it(run):
    hidden = run.summary[P99].idxmin()
    run.summary.loc[hidden, PEAK] = 9e6
    told = [
        text for text in headline.sentences(study.prepare(run)) if text.startswith("Largest peak: 9.00\u00a0MN at ")
    ]
    assert len(told) == 1
    assert "crank speed 286.5\u00a0rpm" in told[0]


def test_no_peak_is_named_twice(run):
    run.summary.loc[run.summary[P99].idxmax(), PEAK] = 9e6
    assert not any(text.startswith("Largest peak") for text in headline.sentences(study.prepare(run)))


def test_cards_and_pictures_have_the_elastic_range_of_the_joints_material(run):
    run.grid["joints"]["rod-slider"]["contact"] = {**run.grid["joints"]["rod-slider"]["contact"], "material": POLYMER}
    prepared = study.prepare(run)
    (cards,) = summary.sections(prepared)[0].blocks
    assert isinstance(cards, Cards)
    assert {name: beside for name, _, beside in cards.cards}["Fastest onset"] == "its material elastic to 4.8\u00a0mm/s"
    captions = [picture.caption for _, picture in tradeoffs.sections(prepared)[0].pictures]
    assert "Its material stays elastic up to about 4.8\u00a0mm/s." in captions
    case_id = prepared.cases.index[0]
    (picture,) = motion.onsets(prepared, case_id, run.events(case_id), run.orbit(case_id))
    axes = Figure().subplots()
    picture.paint(axes)
    assert axes.lines[-1].get_ydata() == pytest.approx([BEARS, BEARS], rel=1e-3)


def test_joints_of_different_materials_have_a_line_each():
    run = Run({}, joints=("crank_rod", "rod_slider"))
    run.grid["joints"]["rod-slider"]["contact"] = {**run.grid["joints"]["rod-slider"]["contact"], "material": POLYMER}
    prepared = study.prepare(run)
    case_id = prepared.cases.index[0]
    (picture,) = motion.onsets(prepared, case_id, run.events(case_id), run.orbit(case_id))
    axes = Figure().subplots()
    picture.paint(axes)
    lines = {line.get_label(): line.get_ydata()[0] for line in axes.lines if line.get_label().startswith("elastic")}
    assert lines == pytest.approx(
        {"elastic up to here (steel, crank-rod)": 0.05, "elastic up to here (its material, rod-slider)": BEARS},
        rel=1e-3,
    )
