"""Figures for a paper: every one of the page, under a name that stays, as wide as is asked for, fonts within."""

import io
import re
import struct

import fake_physics
import numpy as np
import pytest
from click.testing import CliRunner
from fake_runs import Run
from matplotlib.image import imread
from test_report_sections import LINE

import clearsweep
from clearsweep import cli, report
from clearsweep.language.errors import InputError
from clearsweep.report import plot
from clearsweep.report import sections as of_page
from clearsweep.report.blocks.section import Columns, Gallery, Section, painted
from clearsweep.report.documents import page as report_page
from clearsweep.report.documents import paper
from clearsweep.report.plot import ColourScale
from clearsweep.report.study import prepare

WIDE = LINE._replace(size=(4.6, 3.4))


@pytest.fixture
def undrawn(monkeypatch):
    """Leave the drawing out: of pictures the number counts."""
    monkeypatch.setattr(report_page, "draw_svg", lambda *_: "<svg ></svg>")
    monkeypatch.setattr(paper, "picture_bytes", lambda *_: b"drawn")


def test_every_picture_of_the_page_has_a_name_of_its_own_that_the_next_page_has_too(undrawn):
    sections = of_page.all_sections(prepare(Run()))
    names = [name for name, _ in paper.named_pictures(sections)]
    assert names == [name for name, _ in paper.named_pictures(of_page.all_sections(prepare(Run())))]
    played = [
        picture for first in sections for block in first.blocks for picture in getattr(block, "player_pictures", ())
    ]
    assert played  # the page's player shows them; files have them all the same
    assert len(names) == len(set(names)) == report.page_of(Run()).text().count("<svg ") + len(played)
    assert all(re.fullmatch(r"[a-z0-9-]+", name) for name in names)
    assert "verdict-force-peak-clearance-crank-speed" in names
    assert "cases-worst-case-largest-normal-force-journal-orbit" in names


def test_pictures_of_one_title_are_numbered():
    twice = Section("a", "", [Gallery("", [LINE, WIDE, LINE])])
    columns = Section("b", "", [Columns(([Gallery("", [LINE])],))])
    assert [name for name, _ in paper.named_pictures([twice, columns])] == [
        "a-a-line",
        "a-a-line-2",
        "a-a-line-3",
        "b-a-line",
    ]


@pytest.mark.parametrize(("drawn", "width", "points"), [(LINE, None, 85), (WIDE, None, 170), (WIDE, 85.0, 85)])
def test_a_figure_is_as_wide_as_its_column_or_its_page_and_needs_no_font(drawn, width, points):
    text = paper.picture_bytes(drawn, "svg", width).decode()
    assert float(re.search(r'<svg [^>]*width="([\d.]+)pt"', text)[1]) == pytest.approx(points / 25.4 * 72, rel=1e-5)
    assert "<text" not in text
    assert text.encode() == paper.picture_bytes(drawn, "svg", width)


def test_a_pdf_has_its_fonts_within_as_outlines_that_journals_take():
    page = paper.picture_bytes(LINE, "pdf")
    assert b"/FontFile2" in page
    assert b"/Type3" not in page
    assert b"CreationDate" not in page
    box = re.search(rb"/MediaBox \[\s*0 0 ([\d.]+) ([\d.]+)\s*\]", page)
    assert float(box[1]) == pytest.approx(85 / 25.4 * 72, rel=1e-5)


def test_a_png_has_six_hundred_dots_an_inch():
    wide, _ = struct.unpack(">II", paper.picture_bytes(LINE, "png")[16:24])
    assert wide == int(85 / 25.4 * 600)


def test_letters_shrink_with_a_figure_and_never_beyond_what_journals_print(monkeypatch):
    drawn = []
    monkeypatch.setattr(paper, "drawing_bytes", lambda svg, form, scale: drawn.append((svg, scale)) or b"")
    marked = LINE._replace(paint=lambda ax: ax.set_labels("x", "y"))
    for width in (85.0, 170.0):
        paper.picture_bytes(marked, "svg", width)
    sizes = [scale * float(re.search(r"font-size: ([\d.]+)px[^>]*>x<", svg)[1]) for svg, scale in drawn]
    assert sizes == pytest.approx([9.0 * 85 / 25.4 / 4.2, 8.0], rel=1e-6)


def test_a_file_has_what_the_page_has_where_the_page_has_it():
    numbers = np.arange(6400.0).reshape(80, 80)

    def paint(ax):
        ax.cells(np.linspace(0.0, 1.0, 81), np.linspace(0.0, 1.0, 81), numbers, ColourScale(0.0, 6399.0))
        ax.fill([1.0, 2.0, 2.0, 1.0], [0.0, 0.0, 1.0, 1.0], facecolor="#ff0000", edgecolor="#ff0000")
        ax.scatter([0.5], [1.5], size=20.0, color="#0000ff")
        ax.circle((1.5, 1.5), 0.2, facecolor="#00ff00", edgecolor="#00ff00")
        ax.plot([0.0, 2.0], [1.0, 1.0], color="#000000", linewidth=4.0)
        ax.set_xlim(0.0, 2.0)
        ax.set_ylim(0.0, 2.0)

    sheet, box = painted(LINE._replace(paint=paint))
    pixels = imread(io.BytesIO(paper.drawing_bytes(sheet.svg("f", box), "png", dots_per_inch=144)))
    expected = {
        (0.5, 0.02): plot.VIRIDIS[0],
        (0.5, 0.98): plot.VIRIDIS[-1],
        (1.5, 0.5): "#ff0000",
        (0.5, 1.5): "#0000ff",
        (1.5, 1.5): "#00ff00",
        (0.7, 1.0): "#000000",
        (1.02, 1.9): "#ffffff",
    }
    for place, colour in expected.items():
        x, y = (float(side) for side in sheet.axes.to_points(*place, box))
        pixel = pixels[int(2.0 * y), int(2.0 * x), :3] * 255.0
        assert pixel == pytest.approx([int(colour[k : k + 2], 16) for k in (1, 3, 5)], abs=12.0), place


def test_unknown_forms_and_widths_are_refused(tmp_path):
    with pytest.raises(InputError, match=r"format of figures: found 'eps'; expected one of svg, pdf, png"):
        paper.write_figures([], paper.FigureOptions(tmp_path, "eps"))
    with pytest.raises(InputError, match=r"width of figures: found '90'; expected one of auto, 85, 170"):
        paper.write_figures([], paper.FigureOptions(tmp_path, width="90"))


def test_the_command_writes_every_figure_and_table_and_says_their_names(undrawn, tmp_path):
    made, figures, tables = (str(tmp_path / name) for name in ("run", "figures", "tables"))
    fake_physics.sweep(fake_physics.grid(masses=2, wear=True), tmp_path / "run", executor="serial", show_progress=False)
    given = ["report", made, "--figures", figures, "--format", "pdf", "--tables", tables]
    result = CliRunner().invoke(cli.verbs, given)
    assert result.exit_code == 0, result.exception
    _, *written, last = result.stdout.splitlines()
    assert {str(file) for file in (tmp_path / "figures").iterdir()} == {*written}
    assert last == tables
    assert len((tmp_path / "figures/figures.md").read_text().splitlines()) == len(written) + 1  # head and rule, no list
    assert clearsweep.open(made).figures(figures) != []
    assert CliRunner().invoke(cli.verbs, ["report", made, "--format", "eps"]).exit_code == 2
