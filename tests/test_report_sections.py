"""A section is a value: further ones, and machines unknown to the report, are on the page."""

import csv
import re
import typing

import numpy as np
import pandas as pd
import pytest
from report_fake import CRANK, ROD, RPM, Run
from test_report import Page

from clearsweep import report, simulation
from clearsweep.contracts.catalogue import Channel, Field, JointSite, Keys, Mechanism, Output
from clearsweep.mechanics.mechanism import MECHANISMS
from clearsweep.report import motion, section, sections, single, study
from clearsweep.report.picture import Picture
from clearsweep.report.sections import headline, summary
from clearsweep.report.table import Column, Quantity, Table

LINE = Picture("A line", "from below", "A line that rises.", lambda ax: ax.plot([0.0, 1.0], [0.0, 1.0]))
LENGTHS = Table("lengths", "Lengths", "", (Column("name"), Column("length", "m")), [("crank", 0.05), ("rod", 0.12)])
BLOCKS = {
    section.Sentences: section.Sentences(["Said in full."]),
    section.Points: section.Points(["Said & listed."]),
    section.Note: section.Note("Said in small print."),
    section.Cards: section.Cards([("Length", "50 mm", "of the crank")]),
    section.Gallery: section.Gallery("How to read it.", [LINE]),
    section.Detail: section.Detail("Longest", "0123", "speed 3", [("p99", "1 N")], [LINE]),
    section.Facts: section.Facts("Given", "Given values", [("path", "value")]),
    section.Interactive: section.Interactive("explorer", "given-data", "Given", {"ids": ""}, "Said without scripts."),
    section.Columns: section.Columns(([section.Note("Left.")], [section.Facts("Right", "Right", [("a", "b")])])),
    Table: LENGTHS,
}


def further(given):
    return [section.Section("further", "A further section", [BLOCKS[kind] for kind in typing.get_args(section.Block)])]


@pytest.fixture
def with_further(monkeypatch):
    monkeypatch.setattr(sections, "SECTIONS", (*sections.SECTIONS, further))
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
def test_ids_of_sections_and_tables_are_there_once_and_nothing_is_empty(given):
    shown = sections.of(study.prepare(Run(**given)))
    keys = [part.key for part in shown] + [table.key for part in shown for table in part.tables]
    assert len(keys) == len(set(keys))
    assert all(part.blocks for part in shown)
    assert all(table.rows for part in shown for table in part.tables)


def test_what_has_nothing_to_show_is_left_out():
    empty = [
        section.Sentences([]),
        section.Points([]),
        section.Gallery("How to read it.", []),
        section.Facts("Given", "Given values", []),
        LENGTHS._replace(rows=[]),
    ]
    assert section.filled(empty) == []
    assert section.filled(BLOCKS.values()) == list(BLOCKS.values())


@pytest.mark.slow
def test_a_table_called_like_its_section_has_no_second_heading(tmp_path):
    page = report.write(Run(failures=8), tmp_path / "page.html").read_text(encoding="utf-8")
    assert re.findall(r"<h(\d)[^>]*>Failed cases</h\1>", page) == ["2"]


def test_a_cell_with_a_unit_of_its_own_is_a_number_in_the_file():
    table = Table("own", "", "", (Column("a"), Column("b", file_only=True)), [(Quantity(2e-3, "2 mm"), "m")])
    assert table.shown().rows == [["2 mm"]]
    assert table.shown().heads[0].numeric
    assert table.csv().splitlines() == ["a,b", "0.002,m"]


def test_a_table_in_markdown_says_where_its_other_rows_are_and_escapes_what_divides_cells():
    text = Table("many", "Many", "", (Column("a|b"),), [(float(row),) for row in range(60)]).markdown()
    assert text.count("\n| ") == 52
    assert "| a\\|b |" in text
    assert "The first 50 of 60 rows; many.csv has all." in text


@pytest.mark.parametrize(
    ("enough", "remedy"), [(100, None), (640, "`bins: 640` would do for all"), (5000, "720 at most")]
)
def test_bins_that_are_too_coarse_for_the_arcs_are_told_with_how_many_would_do(enough, remedy):
    run = Run()
    run.summary["rod_slider_wear_bins_enough"] = float(enough)
    (section_,) = sections.wear.sections(study.prepare(run))
    message = " ".join(
        text for block in section_.blocks if isinstance(block, section.Sentences) for text in block.texts
    )
    assert ("360 bins are too coarse in" in message) == (remedy is not None)
    assert remedy is None or remedy in message


def test_wear_is_shown_in_units_of_designers_beside_those_of_the_window():
    prepared = study.prepare(Run())
    hours, strokes = (prepared.cases[f"rod_slider_wear_depth_{name}"] for name in ("1000_hours", "million_strokes"))
    turns = prepared.base["simulate"]["revolutions"] - prepared.base["simulate"]["discard"]
    assert hours.to_numpy() == pytest.approx(prepared.cases["rod_slider_wear_rate_max"].to_numpy() * 1000.0 * 3600.0)
    assert strokes.to_numpy() == pytest.approx(prepared.cases["rod_slider_wear_depth_max"].to_numpy() / turns * 1e6)
    (table,) = [block for block in sections.wear.sections(prepared)[0].blocks if isinstance(block, Table)]
    assert {"depth per 1000 h", "depth per 10⁶ strokes", "pressure peak", "pV peak"} <= {
        column.name for column in table.columns
    }


def test_what_does_not_answer_the_question_is_folded_by_subject_and_no_picture_repeats_the_player(tmp_path):
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
    subjects = [subject for subject, _ in sections.MORE if subject != "Laws and errors"]
    assert re.findall(r"<summary><b>([^<]*)</b>", folded) == subjects
    assert folded.count("<summary><b>") == 5
    assert seen.count("<details>") == 1  # what the player of the worst case does not show
    (worst,) = sections.cases.sections(study.prepare(Run(failures=8)))
    (detail,) = worst.blocks
    if detail.moving:
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
    prepared = study.prepare(run)
    assert (prepared.lead.figure, prepared.lead.smallest) == (figure, smallest)
    values = run.summary.set_index("case_id")[f"rod_slider_{figure}"]
    assert prepared.worst(prepared.joints[0]) == (values.idxmin() if smallest else values.idxmax())
    if not limits:
        (drawn,) = sections.maps.first(prepared)
        assert drawn.title.lower().startswith("least film" if smallest else "force peak")
        assert drawn.caption.startswith("Smallest" if smallest else "Largest")


LEAD, AMPLITUDE = 0.25, 0.4  # rad
GRAVITY = Field("gravity", "m/s^2", "gravity, down", low_open=False, default=9.81)


def rocker(case, angles):
    """Return a made-up rocker that swings with the crank."""
    drive, angle = case.drive.speed, AMPLITUDE * np.sin(angles + LEAD)
    forces = {"rod-rocker": np.zeros((*np.shape(angles), 2))}
    return simulation.IdealMotion(angle, drive * AMPLITUDE * np.cos(angles + LEAD), -(drive**2) * angle, forces)


MADE_UP = (
    Mechanism(
        *("four-bar", "made up", "", "", ""),
        bodies=("ground", "crank", "rod", "rocker"),
        joints=(JointSite("rod-rocker", "rod", "rocker"),),
        keys=(Keys("drive", "the drive", (Field("speed", "rad/s"),), "implied"),),
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
        keys=(Keys("mechanism", "", (Field("mass", "kg"), GRAVITY)),),
        channels=(Channel("mass/x", "m", "height of the mass"), Channel("mass/v", "m/s", "its rate")),
        turns=False,
        build=None,
    ),
    Mechanism(
        *("wheel", "made up", "", "", ""),
        bodies=("ground", "wheel"),
        joints=(JointSite("hub", "ground", "wheel"),),
        keys=(Keys("drive", "the drive", (Field("speed", "rad/s"),), "implied"),),
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
    monkeypatch.setattr(simulation, "ideal_motion", lambda case, at: known.get(case.mechanism.type, real)(case, at))


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
    prepared = study.prepare(run)
    assert [picture.title for picture in motion.pictures(prepared, case_id, channels)] == TITLES[name]
    events = np.zeros(0, [("t", float), ("kind", "U3"), ("rate", float)])
    given = simulation.Trajectory("ok", "", {"steps": 100}, channels, events)
    monkeypatch.setattr(single.simulation, "solve", lambda case: given)
    assert report.show(run, case_id, tmp_path / "case.html").stat().st_size > 10_000


def test_the_output_is_judged_by_its_own_ideal_motion_and_in_its_own_unit():
    t = np.linspace(16 * np.pi, 20 * np.pi, 1441) / (5000 * RPM)
    ideal = AMPLITUDE * np.sin(5000 * RPM * t + LEAD)
    run = run_of("four-bar", further={"rocker/angle": ideal + np.radians(0.5)})
    prepared, case_id = study.prepare(run), run.summary["case_id"][0]
    message = {picture.title: picture.alt for picture in motion.pictures(prepared, case_id, run.orbit(case_id))}
    assert message["Rocker position error"] == "Rocker error, at most 0.500°."
    assert "the ideal mechanism reaches" in message["Rocker acceleration against the ideal mechanism"]
    run.summary["rocker_error_max"] = np.radians(0.5)
    (said,) = [sentence for sentence in headline.sentences(study.prepare(run)) if "ideal place" in sentence]
    assert said.startswith("The rocker is off its ideal place by up to 0.500°; its acceleration reaches")
    (section,) = summary.sections(study.prepare(run))
    assert ("Largest rocker error", "0.500°", "off the ideal place") in section.blocks[0].cards


def test_the_ideal_motion_of_the_slider_crank_is_the_closed_form_that_the_grid_gives():
    run = Run(sweep={})
    prepared, case_id = study.prepare(run), run.summary["case_id"][0]
    angle = np.linspace(16 * np.pi, 20 * np.pi, 1441)
    place = CRANK * np.cos(angle) + np.sqrt(ROD**2 - (CRANK * np.sin(angle)) ** 2)
    path = pd.DataFrame(run.orbit(case_id)).assign(**{"slider/place": place + 2e-6})
    message = {picture.title: picture.alt for picture in motion.pictures(prepared, case_id, path)}
    assert message["Slider position error"].replace("\u00a0", " ") == "Slider error, at most 2.00 µm."
