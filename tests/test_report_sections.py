"""A section of the report is a value: a further one is found on the page and in the tables."""

import csv
import re
import typing

import pytest
from report_fake import Run
from test_report import Page

from clearsweep import report
from clearsweep.report import section, sections, study
from clearsweep.report.picture import Picture
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
    assert page.count("<details>") == folded.count("<details>") == 5
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
