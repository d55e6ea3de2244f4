"""The axes of pages: limits as matplotlib has them, round ticks, points where they belong, the same bytes."""

import re
import subprocess
import sys
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest
from fake_runs import Run
from matplotlib import get_data_path
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.patches import Circle
from matplotlib.ticker import MaxNLocator, MultipleLocator

from clearsweep import report
from clearsweep.language import wording
from clearsweep.report import plot
from clearsweep.report.blocks import picture
from clearsweep.report.blocks.picture import Dot, Picture, Spot, draw_svg
from clearsweep.report.draw.style import BLUE, draw_colour_bar, set_log_scale, set_plain_axes
from clearsweep.report.plot.items import Side, text_height, text_width

SIZE = (4.2, 3.1)
X = np.linspace(1.0, 9.0, 30)


def line(ax):
    ax.plot(X, X**2 - 3.0, color=BLUE, label="a")
    ax.plot(X, -X, "o", color="0.5", markersize=3, label="b")
    ax.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2, frameon=False)


def powers(ax):
    ax.plot(X, 10.0**X, color=BLUE)
    set_log_scale(ax, "y")


def bars(ax):
    ax.bar(np.arange(3.0), np.array([1.0, 2.0, 0.5]), 0.8, np.zeros(3), color=BLUE, label="c")


def often(ax):
    ax.hist(X, [1.0, 2.0, 4.0, 9.0], color=BLUE)


def cells(ax):
    table = np.ma.masked_invalid([[1.0, 2.0, np.nan], [30.0, 4.0, 4.0]])
    mesh = ax.pcolormesh(np.arange(4) - 0.5, np.arange(3) - 0.5, table, norm=LogNorm(1.0, 30.0), cmap="viridis")
    draw_colour_bar(ax, mesh, "peak [N]", is_logarithmic=True)


def cloud(ax):
    points = ax.scatter(X, np.sin(X), c=X, cmap="viridis", s=16)
    draw_colour_bar(ax, points, "turn")
    ax.set(xlim=(0.0, None), xlabel="x [m]", ylabel="y [m]")
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
    ax.add_patch(Circle((0.0, 0.0), 2.0, facecolor="white", edgecolor="black"))
    ax.plot([0.0, 2.5], [0.0, 1.0], color=BLUE)
    ax.set(xlim=(-3.0, 3.0), ylim=(-3.0, 3.0), aspect="equal")


PAINTS = [line, powers, bars, often, cells, cloud, levels, ring]


def own(paint, size=SIZE):
    sheet = plot.Sheet(size)
    paint(sheet.axes)
    return sheet


@pytest.mark.parametrize("paint", PAINTS, ids=lambda paint: paint.__name__)
def test_limits_are_those_of_matplotlib(paint):
    axes = Figure(figsize=SIZE).subplots()
    paint(axes)
    mine = own(paint).axes
    assert mine.get_xlim() == pytest.approx(axes.get_xlim())
    assert mine.get_ylim() == pytest.approx(axes.get_ylim())


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
    text, box = sheet.svg("f1")
    ax = sheet.axes
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
    sheet = own(cells)
    _, box = sheet.svg("f1")
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
    assert [place for place, _ in side(0.0, 360.0, margin=0.0, locator=MultipleLocator(90)).ticks(200.0)] == [
        0,
        90,
        180,
        270,
        360,
    ]
    assert len(side(0.0, 1.0, margin=0.0, locator=MaxNLocator(4)).ticks(200.0)) <= 5
    assert next(name for _, name in side(1e-3, 1e3, margin=0.0, is_log=True).ticks(200.0)) == "10⁻³"


def test_widths_of_words_are_those_of_the_font():
    from matplotlib.ft2font import FT2Font

    font = FT2Font(f"{get_data_path()}/fonts/ttf/DejaVuSans.ttf")
    font.set_size(100.0, 72.0)
    for words in ("crank speed [rpm]", f"{wording.MINUS}0.0053", "force peak [kN]", "10⁻³"):
        font.set_text(words)
        assert text_width(words, 100.0) == pytest.approx(font.get_width_height()[0] / 64.0, rel=0.06)
    assert text_height("two\nlines", 8.0) == 2.0 * text_height("one", 8.0)


@pytest.mark.parametrize(
    "paint",
    [
        lambda ax: ax.annotate("there", (0.0, 0.0)),
        lambda ax: ax.plot(np.zeros(5000), np.zeros(5000), "o"),
        lambda ax: ax.plot([0.0, 1.0], [0.0, 1.0], drawstyle="steps"),
        lambda ax: (ax.plot([0.0, 1.0], label="a"), ax.legend()),
        lambda ax: ax.pcolormesh(np.arange(101), np.arange(101), np.zeros((100, 100)), cmap="viridis"),
    ],
)
def test_what_these_axes_cannot_draw_is_drawn_by_matplotlib(paint):
    with pytest.raises(plot.UnsupportedError):
        own(paint)
    assert draw_svg(Picture("t", "", "alt", paint), "f1").startswith("<svg ")


def around(ax):
    angles = np.linspace(0.0, 2.0 * np.pi, 36, endpoint=False)
    ax.fill(angles, 2.0 + np.cos(angles), facecolor=(BLUE, 0.25), edgecolor=BLUE, linewidth=1.2)
    ax.plot([0.5 * np.pi], [2.0], "o", color=BLUE, markersize=4)
    ax.set_xticks(np.radians(np.arange(0, 360, 90)))
    ax.set_rlabel_position(22.5)
    ax.set_ylim(0.0, 4.0)
    ax.grid(color="#c3ccd5", linewidth=0.5)
    ax.set_xlabel("depth [m]")


def test_polar_axes_have_angles_counter_clockwise_and_radii_from_the_middle():
    sheet = plot.make_sheet(SIZE, "polar")
    around(sheet.axes)
    text, box = sheet.svg("f1")
    assert box.width == box.height
    x, y = (float(point) for point in sheet.axes.to_points(0.5 * np.pi, 2.0, box))
    assert (x, y) == (pytest.approx(box.left + 0.5 * box.width), pytest.approx(box.top + 0.25 * box.height))
    assert f"M{x:.2f}".rstrip("0") in text
    assert re.findall(r">(\d+)°<", text) == ["0", "90", "180", "270"]
    assert "nan" not in text
    with pytest.raises(plot.UnsupportedError):
        plot.make_sheet(SIZE, "3d")


def test_a_page_loads_neither_the_figures_of_matplotlib_nor_an_optimiser():
    program = (
        "import sys, fake_runs; from clearsweep import report; report.page_of(fake_runs.Run(wear=True)).text(); "
        "print(*[name for name in sys.argv[1:] if name in sys.modules])"
    )
    slow = ("matplotlib.axes", "matplotlib.figure", "scipy.optimize", "scipy.linalg", "matplotlib.colors")
    loaded = subprocess.run(
        [sys.executable, "-c", program, *slow], cwd=Path(__file__).parent, capture_output=True, text=True, check=True
    )
    assert loaded.stdout.split() == ["matplotlib.colors"]  # a page uses its colours and ticks


def test_a_page_is_drawn_without_matplotlib(monkeypatch):
    monkeypatch.setattr(picture, "_draw_by_matplotlib", lambda shown, key: pytest.fail(shown.title))
    assert report.page_of(Run(wear=True)).text().count("<svg ") > 20
