"""What pictures and tables of a page share is found once: texts are measured, columns are read."""

import re

from fake_runs import Run

from clearsweep.report.blocks.section import Picture, draw_svg
from clearsweep.report.draw import BLUE
from clearsweep.report.study import prepare


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
    assert len(cases._column_cache) == 3
