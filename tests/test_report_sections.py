"""Sections, also of machines unknown to the report, their sentences and units, and the verdict on the limits."""

import csv
import re
import typing
from types import SimpleNamespace
from unittest import mock

import numpy as np
import pandas as pd
import pytest
from fake_runs import CRANK, ROD, RPM, Run
from markupsafe import Markup
from test_report import Page
from test_seek import MASS, Arc, distance, off_border, quiet, refining_grid, searching

import clearsweep
from clearsweep import report, simulation
from clearsweep.answers import validity
from clearsweep.answers.verdict import EXCEEDED_COLUMN, MARGIN_COLUMN, UNDECIDED_COLUMN
from clearsweep.contracts.catalogue import CHOICE, CONDITION, Channel, Field, JointSite, Keys, Mechanism, Output
from clearsweep.language import wording
from clearsweep.mechanics.machines import MECHANISMS
from clearsweep.report import sections
from clearsweep.report.blocks.section import (
    Block,
    Cards,
    Columns,
    Detail,
    Facts,
    Gallery,
    Interactive,
    Note,
    Picture,
    Points,
    Section,
    Sentences,
    draw_svg,
    painted,
    without_empty,
)
from clearsweep.report.blocks.table import Column, Quantity, Table
from clearsweep.report.documents import page as single
from clearsweep.report.documents.page import with_code
from clearsweep.report.draw import BLUE
from clearsweep.report.effects import main_effects_of
from clearsweep.report.one_case.motion import motion_pictures, onset_pictures
from clearsweep.report.sections import answer as verdict_section
from clearsweep.report.sections.answer import (
    folded_verdict_sections,
    reliability_points,
    summary_sections,
    verdict_sections,
)
from clearsweep.report.sections.drivers import driver_sections, folded_driver_sections, tradeoff_sections
from clearsweep.report.sections.maps import map_sections
from clearsweep.report.sections.motion import peak_sections
from clearsweep.report.sections.searches import seek_sections
from clearsweep.report.study import answer_of_study, prepare, reduce_over_other_axes

LINE = Picture("A line", "from below", "A line that rises.", lambda ax: ax.plot([0.0, 1.0], [0.0, 1.0], color=BLUE))
LENGTHS = Table("lengths", "Lengths", "", (Column("name"), Column("length", "m")), [("crank", 0.05), ("rod", 0.12)])
BLOCKS = {
    Sentences: Sentences(["Said in full."]),
    Points: Points(["Said & listed."]),
    Note: Note("Said in small print."),
    Cards: Cards([("Length", "50 mm", "of the crank")]),
    Gallery: Gallery("How to read it.", [LINE]),
    Detail: Detail("Longest", "0123", "speed 3", [("p99", "1 N")], [LINE]),
    Facts: Facts("Given", "Given values", [("path", "value")]),
    Interactive: Interactive("explorer", "given-data", "Given", {"ids": ""}, "Said without scripts."),
    Columns: Columns(([Note("Left.")], [Facts("Right", "Right", [("a", "b")])])),
    Table: LENGTHS,
}


def further(given):
    return [Section("further", "A further section", [BLOCKS[kind] for kind in typing.get_args(Block)])]


@pytest.fixture
def with_further(monkeypatch):
    monkeypatch.setattr(sections, "UNFOLDED", (*sections.UNFOLDED, further))
    return Run(sweep={}, histories=False, wear=False)


def test_a_further_section_is_on_the_page_with_every_kind_of_block(with_further, tmp_path):
    page = Page(report.write(with_further, tmp_path / "page.html").read_text(encoding="utf-8"))
    assert page.ids.index("further") < page.ids.index("more") < page.ids.index("setup")
    assert page.open == []
    shown = page.text[page.text.index("A further section") :]
    for words in (
        "Said in full.",
        "Said & listed.",
        "Said in small print.",
        "Length 50 mm of the crank",
        "How to read it. A linefrom below",
        "Longest 0123 speed 3. p99 1 N",
        "Given path value",
        "Said without scripts.",
        "Left. Right a b",
        "Lengths namelengthmm crank50.0 rod120",
    ):
        assert words.replace(" ", "") in shown.replace(" ", "")
    assert page.figures == 3  # two of the section, and the mechanism


def test_a_further_section_is_in_the_tables(with_further, tmp_path):
    files = report.tables(with_further, tmp_path)
    assert {"lengths.csv", "lengths.md"} <= {file.name for file in files}
    rows = list(csv.reader((tmp_path / "lengths.csv").read_text(encoding="utf-8").splitlines()))
    assert rows == [["name", "length [m]"], ["crank", "0.05"], ["rod", "0.12"]]
    written = (tmp_path / "lengths.md").read_text(encoding="utf-8").splitlines()
    assert written == [
        "### Lengths",
        "",
        "| name | length [mm] |",
        "| --- | ---: |",
        "| crank | 50.0 |",
        "| rod | 120 |",
    ]


def test_tables_of_sections_paint_nothing(monkeypatch, tmp_path):
    monkeypatch.setattr("matplotlib.figure.Figure.savefig", lambda *_, **__: pytest.fail("something was drawn"))
    assert report.tables(Run(failures=8), tmp_path)


@pytest.mark.parametrize("given", [{}, {"failures": 108}, {"sweep": {}, "wear": False}], ids=["all", "failed", "one"])
def test_ids_of_sections_and_tables_exist_once_and_nothing_is_empty(given):
    shown = sections.all_sections(prepare(Run(**given)))
    keys = [part.key for part in shown] + [table.key for part in shown for table in part.tables]
    assert len(keys) == len(set(keys))
    assert all(part.blocks for part in shown)
    assert all(table.rows for part in shown for table in part.tables)


def test_what_has_nothing_to_show_is_left_out():
    empty = [
        Sentences([]),
        Points([]),
        Gallery("How to read it.", []),
        Facts("Given", "Given values", []),
        LENGTHS._replace(rows=[]),
    ]
    assert without_empty(empty) == []
    assert without_empty(BLOCKS.values()) == list(BLOCKS.values())


@pytest.mark.slow
def test_a_table_called_like_its_section_has_no_second_heading(tmp_path):
    page = report.write(Run(failures=8), tmp_path / "page.html").read_text(encoding="utf-8")
    assert re.findall(r"<h(\d)[^>]*>Failed cases</h\1>", page) == ["2"]


def test_a_cell_with_a_unit_of_its_own_is_a_number_in_the_file():
    table = Table("own", "", "", (Column("a"), Column("b", file_only=True)), [(Quantity(2e-3, "2 mm"), "m")])
    assert table.to_text().rows == [["2 mm"]]
    assert table.to_text().heads[0].numeric
    assert table.csv().splitlines() == ["a,b", "0.002,m"]


def test_a_table_in_markdown_names_its_other_rows_and_escapes_dividers():
    text = Table("many", "Many", "", (Column("a|b"),), [(float(row),) for row in range(60)]).markdown()
    assert text.count("\n| ") == 52
    assert "| a\\|b |" in text
    assert "The first 50 of 60 rows; many.csv has all." in text


@pytest.mark.parametrize(
    ("enough", "remedy"),
    [(100, None), (640, "`bins: 640` is enough for all"), (5000, "even 720 bins, the maximum, are too few")],
)
def test_bins_that_are_too_coarse_for_the_arcs_are_reported_with_how_many_would_do(enough, remedy):
    run = Run()
    run.summary["rod_slider_wear_bins_enough"] = float(enough)
    (section_,) = sections.wear.wear_sections(prepare(run))
    message = " ".join(text for block in section_.blocks if isinstance(block, Sentences) for text in block.texts)
    assert ("360 bins are too coarse in" in message) == (remedy is not None)
    assert remedy is None or remedy in message


def test_wear_is_shown_in_units_of_designers_beside_those_of_the_window():
    prepared = prepare(Run())
    hours, strokes = (prepared.cases[f"rod_slider_wear_depth_{name}"] for name in ("1000_hours", "million_strokes"))
    turns = prepared.base["simulate"]["revolutions"] - prepared.base["simulate"]["discard"]
    assert hours == pytest.approx(prepared.cases["rod_slider_wear_rate_max"] * 1000.0 * 3600.0)
    assert strokes == pytest.approx(prepared.cases["rod_slider_wear_depth_max"] / turns * 1e6)
    (table,) = [block for block in sections.wear.wear_sections(prepared)[0].blocks if isinstance(block, Table)]
    assert {"depth per 1000 h", "depth per 10⁶ strokes", "pressure peak", "pV peak"} <= {
        column.name for column in table.columns
    }


def test_what_does_not_answer_the_question_is_folded_by_subject(tmp_path):
    page = report.write(Run(failures=8), tmp_path / "page.html").read_text(encoding="utf-8")
    seen, folded = page.split('<section id="more"')
    assert seen.count("<figure") <= 12
    assert re.findall(r'<section id="([\w-]+)"', seen) == [
        "summary",
        "verdict",
        "cases",
        "drivers",
        "trust",
        "lasting",
    ]
    subjects = [subject for subject, _ in sections.FOLDED if subject != "Laws and errors"]
    assert re.findall(r"<summary><b>([^<]*)</b>", folded) == subjects
    assert folded.count("<summary><b>") == 5
    assert seen.count("<details>") == 1  # what the player of the worst case does not show
    (worst,) = sections.cases.case_sections(prepare(Run(failures=8)))
    (detail,) = worst.blocks
    if detail.player:
        assert not {picture.title for picture in detail.pictures} & {"Journal orbit", "Normal force", "Crank torque"}
    assert "Normal force" in {picture.title for _, picture in worst.pictures}  # for files


@pytest.mark.parametrize(
    ("columns", "limits", "figure", "smallest"),
    [
        ((), {}, "force_peak", False),
        (("film_thickness_min",), {}, "film_thickness_min", True),
        (("film_thickness_min",), {"rod_slider_force_rms": 1.0}, "force_rms", False),
        ((), {"slider_error_max": 1.0}, "force_peak", False),
    ],
)
def test_the_figure_that_leads_maps_and_effects_follows_the_question(columns, limits, figure, smallest):
    run = Run(histories=False)
    for name in columns:
        column = run.layout.columns[-1]._replace(name=f"rod_slider_{name}", unit="m", figure=name, joint="rod_slider")
        run.layout = run.layout._replace(columns=(*run.layout.columns, column))
        run.summary[column.name] = 1.0 / run.summary["rod_slider_force_peak"]
        run.summary.attrs["units"][column.name] = "m"
    run.grid["limits"] = limits
    prepared = prepare(run)
    assert (prepared.lead.figure, prepared.lead.smallest) == (figure, smallest)
    values = run.summary.set_index("case_id")[f"rod_slider_{figure}"]
    assert prepared.worst(prepared.joints[0]) == (values.idxmin() if smallest else values.idxmax())
    if not limits:
        (drawn,) = sections.maps.answer_maps(prepared)
        assert drawn.title.lower().startswith("least film" if smallest else "force peak")
        assert drawn.caption.startswith("Smallest" if smallest else "Largest")


LEAD, AMPLITUDE = 0.25, 0.4  # rad
GRAVITY = Field("gravity", "m/s^2", "gravity, down", low_open=False, default=9.81)


def rocker(case, angles, times=None):
    """Return a made-up rocker that swings with the crank."""
    drive, angle = case.drive.speed, AMPLITUDE * np.sin(angles + LEAD)
    forces = {"rod-rocker": np.zeros((*np.shape(angles), 2))}
    return simulation.IdealMotion(angle, drive * AMPLITUDE * np.cos(angles + LEAD), -(drive**2) * angle, forces)


MADE_UP = (
    Mechanism(
        *("four-bar", "made up", "", "", ""),
        bodies=("ground", "crank", "rod", "rocker"),
        joints=(JointSite("rod-rocker", "rod", "rocker"),),
        keys=(Keys("drive", "the drive", (Field("speed", "rad/s"),), "implied", role=CONDITION),),
        channels=(
            Channel("rocker/angle", "rad", "angle of the rocker"),
            Channel("rocker/rate", "rad/s", "its rate"),
            Channel("rocker/acceleration", "rad/s^2", "its acceleration"),
            Channel("crank/torque", "N*m", "drive torque on the crank"),
        ),
        turns=True,
        build=None,
        output=Output("rocker", "rad"),
    ),
    Mechanism(
        *("falling-mass", "made up", "", "", ""),
        bodies=("slot", "mass"),
        joints=(JointSite("slot", "slot", "mass", "line"),),
        keys=(Keys("mechanism", "", (Field("mass", "kg"), GRAVITY), role=CHOICE),),
        channels=(Channel("mass/x", "m", "height of the mass"), Channel("mass/v", "m/s", "its rate")),
        turns=False,
        build=None,
    ),
    Mechanism(
        *("wheel", "made up", "", "", ""),
        bodies=("ground", "wheel"),
        joints=(JointSite("hub", "ground", "wheel"),),
        keys=(Keys("drive", "the drive", (Field("speed", "rad/s"),), "implied", role=CONDITION),),
        channels=(Channel("wheel/charge", "A*s", "what it carries"),),
        turns=True,
        build=None,
    ),
)
JOINTS = {"four-bar": "rod_rocker", "falling-mass": "slot", "wheel": "hub"}
TITLES = {
    "four-bar": [
        "Journal orbit",
        "Journal orbit unrolled",
        "Normal force",
        "Rocker acceleration against the ideal mechanism",
        "Rocker position error",
        "Crank torque",
    ],
    "falling-mass": ["Mass x", "Phase portrait: mass v over mass x", "Normal force"],
    "wheel": ["Wheel charge", "Journal orbit", "Journal orbit unrolled", "Normal force"],
}


@pytest.fixture(autouse=True)
def made_up(monkeypatch):
    for mechanism in MADE_UP:
        monkeypatch.setitem(MECHANISMS, mechanism.name, mechanism)
    real = simulation.ideal_motion
    known = {"four-bar": rocker}
    monkeypatch.setattr(simulation, "ideal_motion", lambda case, *at: known.get(case.mechanism.type, real)(case, *at))


def run_of(name, **changes):
    bodies = {"mass": 0.1, "gravity": 9.81} if name == "falling-mass" else {}
    given = {"sweep": {}, "joints": (JOINTS[name],), "mechanism": name, "wear": False, "bodies": bodies, "name": name}
    return Run(**given | changes)


@pytest.mark.parametrize("name", JOINTS)
@pytest.mark.parametrize("swept", [False, True])
def test_a_mechanism_that_the_report_does_not_know_is_reported(name, swept, tmp_path):
    sweep = {f"joints.{JOINTS[name].replace('_', '-')}.clearance": [1e-4, 2e-4, 5e-4]} if swept else {}
    page = Page(report.write(run_of(name, sweep=sweep), tmp_path / "page.html").read_text(encoding="utf-8"))
    assert page.open == []
    assert "slider" not in page.text.lower()
    for title in TITLES[name]:
        assert title in page.text
    assert report.tables(run_of(name, sweep=sweep), tmp_path / "tables")


@pytest.mark.parametrize("name", JOINTS)
def test_and_one_case_of_it_is_shown(name, tmp_path, monkeypatch):
    run = run_of(name)
    case_id = run.summary["case_id"][0]
    channels = {channel: np.asarray(values) for channel, values in run.orbit(case_id).items()}
    prepared = prepare(run)
    assert [picture.title for picture in motion_pictures(prepared, case_id, channels)] == TITLES[name]
    events = np.zeros(0, [("t", float), ("kind", "U3"), ("rate", float)])
    given = simulation.Trajectory("ok", "", {"steps": 100}, channels, events)
    monkeypatch.setattr(single.simulation, "solve", lambda case: given)
    assert report.show(run, case_id, tmp_path / "case.html").stat().st_size > 10_000


def test_the_output_is_judged_by_its_own_ideal_motion_and_in_its_own_unit():
    t = np.linspace(16 * np.pi, 20 * np.pi, 1441) / (5000 * RPM)
    ideal = AMPLITUDE * np.sin(5000 * RPM * t + LEAD)
    run = run_of("four-bar", further={"rocker/angle": ideal + np.radians(0.5)})
    prepared, case_id = prepare(run), run.summary["case_id"][0]
    message = {picture.title: picture.alt for picture in motion_pictures(prepared, case_id, run.orbit(case_id))}
    assert message["Rocker position error"] == "Rocker error, at most 0.500°."
    assert "the ideal mechanism reaches" in message["Rocker acceleration against the ideal mechanism"]
    run.summary["rocker_error_max"] = np.radians(0.5)
    (section,) = summary_sections(prepare(run))
    assert "0.500°" in {value for name, value, _ in section.blocks[0].cards if name == "Largest rocker error"}


def test_the_ideal_motion_of_the_slider_crank_is_the_closed_form():
    run = Run(sweep={})
    prepared, case_id = prepare(run), run.summary["case_id"][0]
    angle = np.linspace(16 * np.pi, 20 * np.pi, 1441)
    place = CRANK * np.cos(angle) + np.sqrt(ROD**2 - (CRANK * np.sin(angle)) ** 2)
    path = pd.DataFrame(run.orbit(case_id)).assign(**{"slider/place": place + 2e-6})
    message = {picture.title: picture.alt for picture in motion_pictures(prepared, case_id, path)}
    assert message["Slider position error"].replace("\u00a0", " ") == "Slider error, at most 2.00 µm."


JOINT, PEAK = "joints.rod-slider", "rod_slider_force_peak"
SLOW, FAST = 30.0, 500.0  # rad/s: forces of 10 N and of 10 kN
SPEEDS = {"drive.speed": [SLOW, 150.0, FAST], f"{JOINT}.clearance": [5e-5, 5e-4]}


@pytest.fixture
def wide_run():
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
    assert wording.texts_in_common_unit((18.8e3, 109.0, None), "N") == ["18.8\u00a0kN", "0.109\u00a0kN", wording.DASH]
    assert wording.texts_in_common_unit((3e-6, 2e-4), "m") == ["0.00300\u00a0mm", "0.200\u00a0mm"]


def test_the_rows_of_a_figure_have_one_unit(wide_run):
    (table,) = folded_driver_sections(prepare(wide_run))[0].tables
    cells = [cell.text for row in table.rows if row[0] == "force peak" for cell in (row[4], row[6])]
    assert len(cells) == 4
    assert units(" ".join(cells)) == {"kN"}


def test_what_drives_it_is_the_figure_that_decides(wide_run):
    assert driven(wide_run) == ["Force over crank speed", "Force over clearance"]
    wide_run.grid["limits"] = {"slider_error_max": 1e-9}  # exceeded by all
    assert {title.partition(" over ")[0] for title in driven(wide_run)} == {"Slider error"}
    folded = folded_driver_sections(prepare(wide_run))[0].pictures
    assert "Force over crank speed" in [picture.title for _, picture in folded]
    wide_run.grid["limits"] = {PEAK: 1.0}
    assert {title.partition(" over ")[0] for title in driven(wide_run)} == {"Force peak"}


def driven(run):
    """Return the titles of the pictures of what drives a run."""
    return [picture.title for _, picture in driver_sections(prepare(run))[0].pictures]


def test_cards_and_pictures_have_the_speed_at_which_the_joint_first_yields(wide_run):
    made = Run(SPEEDS, strength=600e6)
    made.summary["rod_slider_yield_speed"] = 0.35
    prepared = prepare(made)
    captions = [picture.caption for _, picture in tradeoff_sections(prepared)[0].pictures]
    assert "The contact first yields at 0.35\u00a0m/s." in captions
    assert lines(made) == pytest.approx({"first yield (rod-slider)": 0.35})
    made.summary["rod_slider_yield_speed"] = 40.0  # far beyond: a line would press all onsets to the bottom
    assert lines(made) == {}


def test_unknown_strengths_are_not_judged(wide_run):
    prepared = prepare(wide_run)
    (cards,) = summary_sections(prepared)[0].blocks
    assert "Fastest onset" not in [name for name, *_ in cards.cards]  # it has no reference
    captions = [picture.caption for _, picture in tradeoff_sections(prepared)[0].pictures]
    assert any("is not computed, because it needs a yield strength or a hardness" in caption for caption in captions)
    assert lines(wide_run) == {}


STEEL = {"young": 207e9, "poisson": 0.3, "yield_strength": 600e6}


@pytest.mark.parametrize("kind", ["a column without a value", "spatial, guide: no column"])
def test_a_joint_that_cannot_be_judged_is_not_asked_for_the_strength_it_has(kind):
    made = Run(SPEEDS, strength=600e6 if kind.startswith("a column") else None)
    made.summary["rod_slider_yield_speed"] = np.nan
    contact = {"law": "flores", "elastic": "johnson", "restitution": 0.7, "material": STEEL}
    made.grid["joints"]["rod-slider"]["contact"] = contact
    prepared = prepare(made)
    captions = " ".join(picture.caption for _, picture in tradeoff_sections(prepared)[0].pictures)
    assert "is not computed for this kind of joint or law." in captions
    assert "it takes a yield strength" not in captions
    (cards,) = summary_sections(prepared)[0].blocks
    assert "Fastest onset" not in [name for name, *_ in cards.cards]  # it has no reference


def test_closing_lines_claim_nothing_of_joints_that_cannot_be_judged():
    remarks = validity.Remarks(["rod_slider"])
    columns = {"rod_slider_onset_rate_max": [9.0], "rod_slider_law_limit_fraction": [0.0]}
    for limits_met in ({}, {"rod_slider_yield_speed": [None]}):
        remarks.add({"case_id": ["a"], "message": [""], **columns, **limits_met})
    assert remarks.sentences() == []


def lines(made):
    """Return label -> speed (m/s) of the lines in the picture of the onsets of a run's first case."""
    prepared = prepare(made)
    case_id = prepared.cases.index[0]
    (picture,) = onset_pictures(prepared, case_id, made.events(case_id), made.orbit(case_id))
    axes = painted(picture)[0].axes
    levels = [item.y[0] for item in axes.items if item.spans_width]
    return dict(zip([entry.name for entry in axes.legend_entries], levels, strict=True))


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
    prepared = prepare(made)
    (section,) = peak_sections(prepared)
    table = next(table for table in section.tables if table.key == "certainty")
    place = [column.name for column in table.columns].index("error of force peak")
    cells = {row[0]: row[place] for row in table.rows}
    text = {case_id: cell.text for case_id, cell in cells.items() if isinstance(cell, Quantity)}
    # a peak in revolution 2 may lie after 1.98 revolutions, one in revolution 3 not after 3
    first, second = frame["case_id"][:2]
    assert text == {
        first: "peak in revolution 3, horizon 2.0 revolutions: the error does not check convergence",
        second: "peak in revolution 2, horizon 2.0 revolutions: the error does not check convergence",
    }
    assert all(cell.value == 2.02e-4 for cell in cells.values() if isinstance(cell, Quantity))
    (points,) = (block for block in section.blocks if isinstance(block, Points))
    assert "does not check convergence in 2 of 6 cases" in points.texts[0]
    assert "In 3 chaotic cases the peak lies within the horizon" in points.texts[1]
    assert "the error checks only these first revolutions" in points.texts[1]


def test_the_sentence_on_an_unchecked_peak_names_its_own_joint():
    made = Run(SPEEDS, joints=("crank_rod", "rod_slider"), checked=True)
    frame = made.summary
    frame["horizon_revolutions"] = 2.0
    frame["crank_rod_force_peak_revolution"] = np.nan  # never touched
    frame["rod_slider_force_peak_revolution"] = [3, 1, 1, 1, 1, 1]
    (section,) = peak_sections(prepare(made))
    (points,) = (block for block in section.blocks if isinstance(block, Points))
    assert points.texts[0].startswith("The error of the force peak in joint rod-slider does not check convergence in 1")
    assert "the peak in joint rod-slider lies within" in points.texts[1]
    assert len(points.texts) == 2


def test_without_a_horizon_nothing_is_said_of_single_errors():
    made = Run(SPEEDS, checked=True)
    made.summary["horizon_revolutions"] = np.nan
    (section,) = peak_sections(prepare(made))
    assert not any(isinstance(block, Points) for block in section.blocks)


IDEAL = "rod_slider_force_peak_ideal"
LIMITS = {PEAK: {"at_most": 6.0, "times": IDEAL}, "slider_error_max": 3e-4}


@pytest.fixture
def limited_run():
    """Return a run with limits, its columns computed anew."""
    made = Run(failures=3)
    made.grid["limits"] = LIMITS
    rows = made.summary["status"] == "ok"
    ratio = made.summary[PEAK] / made.summary[IDEAL]
    made.summary["rod_slider_load_peak"] = made.summary[PEAK]
    made.summary["rod_slider_force_peak_ratio"] = ratio
    made.summary["period"] = np.where(np.arange(len(rows)) % 2, np.nan, 1.0)
    error = made.summary["slider_error_max"]
    names = [(PEAK, ratio > 6.0), ("slider_error_max", error > 3e-4)]
    exceeded = [",".join(name for name, beyond in names if beyond[row]) for row in made.summary.index]
    made.summary[EXCEEDED_COLUMN] = np.where(rows, exceeded, None)
    made.summary[UNDECIDED_COLUMN] = np.where(rows, "", ",".join(LIMITS))
    made.summary[MARGIN_COLUMN] = np.minimum(1.0 - ratio / 6.0, 1.0 - error / 3e-4)
    return made


def test_the_table_of_limits_is_that_of_the_summary(limited_run):
    prepared = prepare(limited_run)
    (table,) = folded_verdict_sections(prepared)[0].tables
    assert not verdict_sections(prepared)[0].tables
    cases = prepared.cases
    result = {row[0]: tuple(cell.value for cell in row[2:6]) for row in table.rows}
    assert [row[1] for row in table.rows] == [
        "force peak at most 6 times the ideal peak",
        "slider error at most 0.3\u00a0mm",
    ]
    margins = {PEAK: 1.0 - cases[PEAK] / cases[IDEAL] / 6.0, "slider_error_max": 1.0 - cases["slider_error_max"] / 3e-4}
    for name, margin in margins.items():
        assert result[name][:3] == (int((margin < 0.0).sum()), 0, len(cases))
        assert result[name][3] == pytest.approx(margin.min(), rel=1e-12)


def test_a_map_shows_the_worst_of_a_cell_or_on_request_the_median(limited_run):
    for typical, reduced, word in ((False, np.max, "Largest over"), (True, np.median, "Median over")):
        prepared = prepare(limited_run, shows_median=typical)
        across, up = prepared.axes[0], prepared.axes[3]
        values = prepared.cases[PEAK]
        table = reduce_over_other_axes(prepared, values, (across, up), reduced)
        at = (prepared.cases[across.path] == across.values[1]) & (prepared.cases[up.path] == up.values[2])
        assert table[2, 1] == reduced(values[at])
        assert map_sections(prepared)[0].blocks[0].pictures[0].caption.startswith(word)


def test_only_motions_that_are_found_to_be_chaotic_are_named_chaotic(limited_run):
    def sentence_of(made):
        return " ".join(reliability_points(prepare(made)))

    finished = limited_run.summary["status"] == "ok"
    repeating = int(limited_run.summary["period"][finished].notna().sum())
    assert f"{repeating} of {int(finished.sum())} motions repeat" in sentence_of(limited_run)
    assert "chaotic" not in sentence_of(limited_run)
    limited_run.summary["lyapunov_exponent"] = 3.0
    assert f"{int(finished.sum()) - repeating} of {int(finished.sum())} motions are chaotic" in sentence_of(limited_run)


def test_a_peak_near_the_median_of_its_revolutions_is_no_chance(limited_run):
    for share, said in (
        (0.995, "peaks are within 1\u00a0% of a typical one"),
        (0.5, "up to 2.0 times that of a typical"),
    ):
        peaks = [name for name in limited_run.summary if name.endswith("_force_peak")]
        for name in peaks:
            limited_run.summary[f"{name}_median"] = share * limited_run.summary[name]
        text = " ".join(reliability_points(prepare(limited_run)))
        assert said in text
        assert ("partly chance" in text) == (share < 0.9)


def test_the_page_holds_the_verdict_and_its_map(limited_run, tmp_path):
    page = report.write(limited_run, tmp_path / "page.html").read_text(encoding="utf-8")
    assert "Within the limits" in page
    assert page.index('id="verdict"') < page.index('id="headline"')


def sentence_of(result, place=0):
    """Return what the first block of a section says, with plain spaces."""
    return " ".join(result[place].blocks[0].texts).replace("\u00a0", " ")


@pytest.mark.parametrize(("whom", "limit"), [("each", 0.3137), ("all", 0.3137), ("each", 0.05), ("each", 1.0)])
def test_what_was_sought_stands_in_the_verdict_and_in_a_section_of_its_own(tmp_path, whom, limit):
    source = searching(limit, gravities=(0.0, 1e-3))
    source["seek"]["for"] = whom
    quiet(source, tmp_path / "run")
    run = clearsweep.open(tmp_path / "run")
    prepared = prepare(run)
    (part,) = seek_sections(prepared)
    table = part.tables[0]
    frame = run.seek
    assert [row[-5] for row in table.rows] == pytest.approx(frame[f"seek.{MASS}"].tolist(), rel=1e-12, nan_ok=True)
    assert len(table.rows) == (2 if whom == "each" else 1)
    first = sentence_of(verdict_sections(prepared)).replace("\u202f", "")
    assert first.partition(". ")[0] not in sentence_of([part])  # nothing is said twice
    if limit == 0.05:
        assert "none in the range" in first
    else:
        assert f"{frame[f'seek.{MASS}'].min():.4g} kg" in first
    pictures = [picture for block in part.blocks for picture in getattr(block, "pictures", [])]
    assert len(pictures) == (whom == "each" and limit > 0.05)
    assert MASS in {axis.path for axis in prepared.axes}
    report.write(run, tmp_path / "page.html")


def test_the_map_shows_cases_between_its_cells(tmp_path):
    quiet(refining_grid(), tmp_path / "run", simulator=Arc)
    run = clearsweep.open(tmp_path / "run")
    prepared = prepare(run)
    added_distances, own = off_border(run.summary)
    counts = answer_of_study(prepared)["cases"]
    assert counts["added"] == len(added_distances)
    assert sum(counts.values()) == len(run.summary)
    (picture,) = verdict_sections(prepared)[0].blocks[-1].pictures
    assert f"The {len(added_distances)} dots between cells are cases that refine added" in picture.caption
    assert len(draw_svg(picture, "map")) > 1000
    across, up = prepared.axes
    dots = verdict_section.added_points(prepared, (prepared.cases[EXCEEDED_COLUMN] != "").astype(float), across, up)
    assert len(own) == 20
    mass, speed = 0.1 + 0.2 * dots.x, 100.0 + 200.0 * dots.y  # both axes have equal steps
    assert np.array_equal(np.hypot(mass, speed / 1000.0) > 0.6137, dots.failing)


def test_main_effects_leave_out_the_cases_between_the_values(tmp_path):
    quiet(refining_grid(), tmp_path / "run", simulator=Arc)
    prepared = prepare(clearsweep.open(tmp_path / "run"))
    grid_mass, grid_speed = np.meshgrid(*(axis.values for axis in sorted(prepared.axes, key=lambda axis: axis.path)))
    on_grid = distance(*((grid_mass, grid_speed) if grid_mass.max() < 1.0 else (grid_speed, grid_mass)))
    expected = [np.median(on_grid, axis=axis) for axis in (0, 1)]
    effects = [effect.medians for effect in main_effects_of(prepared, "rod_slider_force_peak")]
    assert sorted(map(tuple, effects)) == [pytest.approx(row) for row in sorted(map(tuple, expected))]


def test_the_card_of_a_sample_counts_draws_and_names_the_design():
    share = {"exceeded": 0.75, "undecided": 0.25, "draws": 4}
    answer = {"designs": [{"values": {MASS: 0.1}, "share": share, "conditions": 8}], "designs_total": 1}
    study = SimpleNamespace(run=None)
    words = SimpleNamespace(design=lambda design: "slider mass 0.1 kg")
    with (
        mock.patch.object(verdict_section, "words_of", return_value=words),
        mock.patch.object(verdict_section, "every_text", return_value=""),
    ):
        ((title, value, note),) = verdict_section._verdict_cards(study, answer)
    assert (title, value.replace("\u00a0", " "), note.replace("\u00a0", " ")) == (
        "Exceeds a limit",
        "75 %",
        "of 4 draws; 25 % undecided; slider mass 0.1 kg",
    )


def test_words_between_backquotes_are_code_and_everything_else_is_escaped():
    text = "see `uncertain` <b> & `a < b`"
    assert with_code(text) == "see <code>uncertain</code> &lt;b&gt; &amp; <code>a &lt; b</code>"
    assert with_code(Markup("<i>kept</i>")) == "<i>kept</i>"
