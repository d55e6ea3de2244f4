"""The axes of pages: limits as matplotlib has them, round ticks, points where they belong, the same bytes."""

import base64
import io
import re
import struct
import subprocess
import sys
import xml.etree.ElementTree as ET
from pathlib import Path

import fake_physics
import numpy as np
import pytest
from click.testing import CliRunner
from fake_runs import Run
from matplotlib import colormaps, get_data_path
from matplotlib.figure import Figure
from matplotlib.ft2font import FT2Font
from matplotlib.image import imread
from matplotlib.ticker import MaxNLocator
from test_report_sections import LINE

import clearsweep
from clearsweep import cli, report
from clearsweep.language import wording
from clearsweep.language.errors import InputError
from clearsweep.report import plot
from clearsweep.report import sections as of_page
from clearsweep.report.blocks.section import Columns, Dot, Gallery, Picture, Section, Spot, draw_svg, painted
from clearsweep.report.documents import page as report_page
from clearsweep.report.documents import paper
from clearsweep.report.draw import BLUE, POLAR_SPACE, draw_colour_bar, set_log_scale, set_plain_axes, set_polar_axes
from clearsweep.report.plot import ColourScale
from clearsweep.report.plot.items import Side, text_height, text_width
from clearsweep.report.study import prepare

SIZE = (4.2, 3.1)
X = np.linspace(1.0, 9.0, 30)
TABLE = np.array([[1.0, 2.0, np.nan], [30.0, 4.0, 4.0]])


def line(ax):
    ax.plot(X, X**2 - 3.0, color=BLUE, label="a")
    ax.plot(X, -X, "o", color="#808080", markersize=3, label="b")
    ax.set_legend("above", columns=2)


def powers(ax):
    ax.plot(X, 10.0**X, color=BLUE)
    set_log_scale(ax, "y")


def bars(ax):
    ax.bar(np.arange(3.0), np.array([1.0, 2.0, 0.5]), 0.8, np.zeros(3), color=BLUE, label="c")


def often(ax):
    ax.hist(X, [1.0, 2.0, 4.0, 9.0], color=BLUE)


def cells(ax):
    colours = plot.ColourScale(1.0, 30.0, is_log=True)
    ax.cells(np.arange(4) - 0.5, np.arange(3) - 0.5, TABLE, colours)
    draw_colour_bar(ax, colours, "peak [N]")


def cloud(ax):
    colours = plot.ColourScale(1.0, 9.0)
    ax.scatter(X, np.sin(X), values=X, scale=colours, size=4)
    draw_colour_bar(ax, colours, "turn")
    ax.set_xlim(0.0, None)
    ax.set_labels("x [m]", "y [m]")
    set_plain_axes(ax)


def levels(ax):
    ax.plot(X, X, color=BLUE)
    ax.axhline(20.0, color=BLUE, linestyle=":")
    ax.axvline(-5.0, color=BLUE)
    ax.axhspan(-3.0, 0.0, color=BLUE)
    ax.fill_between(X, X - 1.0, X + 30.0, color=BLUE, alpha=0.2)
    ax.vlines(X, 0.0, 40.0, color=BLUE)
    ax.set_ylim(None, 60.0)


def ring(ax):
    ax.circle((0.0, 0.0), 2.0, facecolor="#ffffff", edgecolor="#000000")
    ax.plot([0.0, 2.5], [0.0, 1.0], color=BLUE)
    ax.set_square(3.0)


def next_to(ax):
    ax.plot(X, X, color=BLUE)
    ax.leader((0.9, 5.0), (1.06, 7.0), color=BLUE, linewidth=0.5)
    ax.text(1.06, 7.0, "a name", spans_width=True, va="center", size=6.5)


#: Drawing -> the same by matplotlib, whose limits are the reference.
PAINTS = {
    line: lambda ax: (ax.plot(X, X**2 - 3.0), ax.plot(X, -X, "o")),
    powers: lambda ax: ax.semilogy(X, 10.0**X),
    bars: lambda ax: ax.bar(np.arange(3.0), np.array([1.0, 2.0, 0.5]), 0.8, np.zeros(3)),
    often: lambda ax: ax.hist(X, [1.0, 2.0, 4.0, 9.0]),
    cells: lambda ax: ax.pcolormesh(np.arange(4) - 0.5, np.arange(3) - 0.5, TABLE),
    cloud: lambda ax: (ax.scatter(X, np.sin(X)), ax.set_xlim(0.0, None)),
    levels: lambda ax: (
        ax.plot(X, X),
        ax.axhline(20.0),
        ax.axvline(-5.0),
        ax.axhspan(-3.0, 0.0),
        ax.fill_between(X, X - 1.0, X + 30.0),
        ax.vlines(X, 0.0, 40.0),
        ax.set_ylim(None, 60.0),
    ),
    ring: lambda ax: ax.set(xlim=(-3.0, 3.0), ylim=(-3.0, 3.0)),
    next_to: lambda ax: ax.plot(X, X),
}


def own(paint, size=SIZE):
    sheet = plot.Sheet(size)
    paint(sheet.axes)
    return sheet


@pytest.mark.parametrize(("paint", "reference"), PAINTS.items(), ids=lambda paint: paint.__name__)
def test_limits_are_those_of_matplotlib(paint, reference):
    axes = Figure(figsize=SIZE).subplots()
    reference(axes)
    mine = own(paint).axes
    assert mine.xaxis.limits() == pytest.approx(axes.get_xlim())
    assert mine.yaxis.limits() == pytest.approx(axes.get_ylim())


@pytest.mark.parametrize("paint", PAINTS, ids=lambda paint: paint.__name__)
def test_a_drawing_is_whole_and_has_the_same_bytes_twice(paint):
    shown = Picture("title", "", "What <is> there.", paint, SIZE)
    text = draw_svg(shown, "f7")
    assert text == draw_svg(shown, "f7")
    assert "nan" not in text.lower()
    root = ET.fromstring(text)
    assert root.get("aria-label") == "What <is> there."
    ids = [each.get("id") for each in root.iter() if each.get("id")]
    assert ids
    assert all(name.startswith("f7-") for name in ids)
    for used in re.findall(r"url\(#([\w-]+)\)", text):
        assert used in ids
    for word in root.iter("{http://www.w3.org/2000/svg}text"):  # no word leaves the sheet
        assert 0.0 <= float(word.get("x")) <= 72.0 * SIZE[0]
        assert 0.0 <= float(word.get("y")) <= 72.0 * SIZE[1]


def test_points_are_where_the_ticks_say():
    sheet = own(lambda ax: (ax.plot([2.0, 4.0], [10.0, 1000.0], color=BLUE), set_log_scale(ax, "y")))
    box = sheet.box()
    text, ax = sheet.svg("f1", box), sheet.axes
    (drawn,) = re.findall(r'<path d="M([\d.]+) ([\d.]+)L([\d.]+) ([\d.]+)" style="fill: none; stroke: #0072b2', text)
    x0, y0, x1, y1 = map(float, drawn)
    ticks = {
        float(name): box.top + (1.0 - float(ax.yaxis.fraction(place))) * box.height
        for place, name in ax.yaxis.ticks(200)
    }
    assert y0 == pytest.approx(ticks[10.0], abs=0.01)
    assert y1 == pytest.approx(ticks[1000.0], abs=0.01)
    assert box.left < x0 < x1 < box.left + box.width


def test_spots_and_dots_are_on_what_they_say():
    spot = Spot((-0.5, -0.5), (0.5, 0.5), "one cell", "ab")
    shown = Picture("t", "", "alt", cells, SIZE, spots=(spot,), dots=(Dot(np.array([[0.0, 0.0], [2.0, 1.0]]), "red"),))
    text = draw_svg(shown, "f1")
    box = own(cells).box()
    left, top, wide, high = map(
        float, re.search(r'class="spot" x="([\d.]+)" y="([\d.]+)" width="([\d.]+)" height="([\d.]+)"', text).groups()
    )
    assert (left, wide) == (pytest.approx(box.left, abs=0.06), pytest.approx(box.width / 3.0, abs=0.06))
    assert (top + high, high) == (
        pytest.approx(box.top + box.height, abs=0.11),
        pytest.approx(box.height / 2.0, abs=0.06),
    )
    cx, cy = map(float, re.search(r'<circle cx="([\d.]+)" cy="([\d.]+)"', text).groups())
    assert (cx, cy) == (pytest.approx(left + wide / 2.0, abs=0.11), pytest.approx(top + high / 2.0, abs=0.11))


def side(low, high, **values):
    made = Side("x")
    made.extend_data([low, high])
    for name, value in values.items():
        setattr(made, name, value)
    return made


@pytest.mark.parametrize(
    ("low", "high", "names"),
    [
        (0.0, 1.0, ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]),
        (-3.0, 3.0, [f"{wording.MINUS}2", f"{wording.MINUS}1", "0", "1", "2"]),
        (0.0, 2e6, ["0", "1 x 10⁶", "2 x 10⁶"]),
    ],
)
def test_ticks_are_at_round_numbers(low, high, names):
    ticks = side(low, high, margin=0.0).ticks(180.0)
    steps = np.diff([place for place, _ in ticks])
    assert steps == pytest.approx(steps[0])
    assert round(steps[0] / 10.0 ** np.floor(np.log10(steps[0])), 6) in (1.0, 2.0, 2.5, 5.0)
    assert 2 <= len(ticks) <= 9
    assert {*names} <= {name.replace(wording.BLANK, " ").replace(wording.TIMES, "x") for _, name in ticks}


def test_ticks_follow_their_locators_and_a_logarithm_has_decades():
    assert [place for place, _ in side(0.0, 360.0, margin=0.0, tick_rule=plot.multiples_of(90)).ticks(200.0)] == [
        0,
        90,
        180,
        270,
        360,
    ]
    assert len(side(0.0, 1.0, margin=0.0, tick_rule=plot.round_ticks(4)).ticks(200.0)) <= 5
    assert next(name for _, name in side(1e-3, 1e3, margin=0.0, is_log=True).ticks(200.0)) == "10⁻³"


def test_widths_of_words_are_those_of_the_font():
    font = FT2Font(f"{get_data_path()}/fonts/ttf/DejaVuSans.ttf")
    font.set_size(100.0, 72.0)
    for words in ("crank speed [rpm]", f"{wording.MINUS}0.0053", "force peak [kN]", "10⁻³"):
        font.set_text(words)
        assert text_width(words, 100.0) == pytest.approx(font.get_width_height()[0] / 64.0, rel=0.06)
    assert text_height("two\nlines", 8.0) == 2.0 * text_height("one", 8.0)


@pytest.mark.parametrize("intervals", [2, 4, 5, 9])
@pytest.mark.parametrize(("low", "high"), [(0.0, 1.0), (-3.2, 7.7), (1e-7, 9.3e-7), (123.0, 4567.0)])
def test_round_ticks_are_those_of_matplotlib(low, high, intervals):
    ticks = MaxNLocator(intervals, steps=[1, 2, 2.5, 5, 10]).tick_values(low, high)
    within = ticks[(ticks >= low - 1e-9 * high) & (ticks <= high + 1e-9 * high)]
    assert plot.round_ticks(intervals)(low, high) == pytest.approx(within, rel=1e-9, abs=1e-12 * high)


def test_colours_are_those_of_viridis_between_the_ends_of_the_scale():
    scale, numbers = plot.ColourScale(1.0, 100.0, is_log=True), np.logspace(0.0, 2.0, 41)
    assert scale.rgb(scale.fractions(numbers)) == pytest.approx(
        np.rint(255.0 * colormaps["viridis"](np.linspace(0.0, 1.0, 41))[:, :3]), abs=3.0
    )
    assert scale.hex_colours(scale.fractions([0.1, 1e4])) == [plot.VIRIDIS[0], plot.VIRIDIS[-1]]


def test_many_points_and_many_cells_are_an_image_with_each_where_it_belongs():
    x, y = np.meshgrid(np.linspace(0.0, 1.0, 80), np.linspace(0.0, 1.0, 80))

    def points(ax):
        ax.scatter(x.ravel(), 0.5 * y.ravel(), size=0.75, color="#ff0000")
        ax.set_xlim(0.0, 1.0)
        ax.set_ylim(0.0, 1.0)

    pixels = pixels_of(points)
    assert {tuple(pixel) for pixel in pixels[pixels[..., 3] > 0].tolist()} == {(255, 0, 0, 255)}
    assert not pixels[: len(pixels) // 2 - 1, :, 3].any()  # all are in the lower half
    assert np.count_nonzero(pixels[..., 3]) >= 0.95 * x.size
    numbers = np.arange(6400.0).reshape(80, 80)
    numbers[0, 0] = np.nan  # lower left
    pixels = pixels_of(lambda ax: ax.cells(np.arange(81), np.arange(81), numbers, plot.ColourScale(0.0, 6399.0)))
    assert pixels.shape == (80, 80, 4)
    assert np.argwhere(pixels[..., 3] == 0).tolist() == [[79, 0]]
    assert tuple(pixels[0, 79, :3]) == (0xFD, 0xE7, 0x25)  # the largest is at the upper right


def pixels_of(paint):
    """Return the pixels (rows, columns, 4) of the only image of a drawing, read by another program."""
    (address,) = re.findall(r'href="data:image/png;base64,([^"]+)"', draw_svg(Picture("t", "", "alt", paint), "f1"))
    return np.rint(255.0 * imread(io.BytesIO(base64.b64decode(address)))).astype(int)


def test_polar_axes_have_angles_counter_clockwise_and_radii_from_the_middle():
    sheet = plot.Sheet(SIZE)
    set_polar_axes(sheet.axes, 4.0)
    box = sheet.box()
    text = sheet.svg("f1", box)
    assert box.width == box.height
    angles = re.findall(r'x="([\d.]+)" y="([\d.]+)"[^>]*>(\d+)°<', text)
    assert [degrees for *_, degrees in angles] == [f"{degrees}" for degrees in range(0, 360, 45)]
    middle = box.left + 0.5 * box.width, box.top + 0.5 * box.height
    for x, y, degrees in angles:  # the ordinate of a sheet points down
        place = np.array([float(x) - middle[0], middle[1] - float(y)])
        direction = np.array([np.cos(np.radians(float(degrees))), np.sin(np.radians(float(degrees)))])
        assert place @ direction > 0.95 * np.linalg.norm(place) > 0.4 * box.width / POLAR_SPACE
    radii = [float(radius) for radius in re.findall(r'<ellipse [^>]*rx="([\d.]+)"', text)]
    assert radii == pytest.approx(
        [radius * 0.5 * box.width / POLAR_SPACE / 4.0 for radius in (1.0, 2.0, 3.0, 4.0, 4.0)], abs=0.01
    )
    assert "nan" not in text


def test_a_page_is_drawn_without_matplotlib():
    program = (
        "import sys, fake_runs; from clearsweep import report; text = report.page_of(fake_runs.Run(wear=True)).text(); "
        "print(text.count('<svg ') > 20, *[name for name in sys.argv[1:] if name in sys.modules])"
    )
    slow = ("matplotlib", "PIL", "scipy.optimize", "scipy.linalg")
    loaded = subprocess.run(
        [sys.executable, "-c", program, *slow], cwd=Path(__file__).parent, capture_output=True, text=True, check=True
    )
    assert loaded.stdout.split() == ["True"]


# What pictures and tables of a page share is found once: texts are measured, columns are read.


def test_a_drawing_has_the_colours_of_the_theme_but_white_letters_stay_white():
    def paint(ax):
        ax.plot([0.0, 1.0], [0.0, 1.0], color=BLUE)
        ax.text(0.5, 0.5, "on a dark cell", colour="#ffffff")

    drawing = draw_svg(Picture("A line", "", "A line.", paint), "f1")
    assert "stroke: var(--curve, #0072b2)" in drawing
    assert "fill: var(--paper, #ffffff)" in drawing
    assert drawing.count("fill: white") == 1
    assert not re.search("(fill|stroke): #(ffffff|1f2933|6b7785)", drawing)


def test_columns_of_few_cases_are_read_once(monkeypatch):
    read, column = [], Run.column
    monkeypatch.setattr(Run, "column", lambda self, name: read.append(name) or column(self, name))
    cases = prepare(Run()).cases
    names = [name for name in cases.columns if name.startswith("rod_slider_force")]
    assert len(names) > 3
    read.clear()
    for name in names + names:
        assert len(cases[name]) == len(cases)
    assert sorted(read) == sorted(set(read))


def test_columns_of_many_cases_are_not_all_kept(monkeypatch):
    monkeypatch.setattr("clearsweep.report.axis.CACHED_VALUES", 3 * len(prepare(Run()).cases))
    cases = prepare(Run()).cases
    for name in cases.columns:
        cases[name]
    assert len(cases.column_cache) == 3


# Figures for a paper: every one of the page, under a name that stays, as wide as is asked for, fonts within.


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
