"""The figures of a report: which are drawn for a run, from which cases, with which words; each is one inline SVG."""

import html
import io
import itertools
import re
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure

from .. import wording
from . import draw, findings
from .study import RATIO, Axis, Joint, Study, position

PAIRS = 6  # heat maps per joint: every pair of up to four axes
STYLE = {
    "svg.fonttype": "none",  # text stays text: searchable, read aloud, small
    "font.family": "DejaVu Sans",
    "font.size": 9,
    "axes.labelsize": 9,
    "legend.fontsize": 8,
    "legend.title_fontsize": 8,
    "xtick.labelsize": 8,
    "ytick.labelsize": 8,
    "axes.edgecolor": draw.GREY,
    "axes.labelcolor": draw.INK,
    "xtick.color": draw.GREY,
    "ytick.color": draw.GREY,
    "xtick.labelcolor": draw.INK,
    "ytick.labelcolor": draw.INK,
    "text.color": draw.INK,
    "axes.linewidth": 0.8,
    "axes.unicode_minus": True,
    "axes.formatter.useoffset": False,
    "axes.formatter.use_mathtext": False,
}


class Picture(NamedTuple):
    """One figure on the page."""

    title: str
    caption: str
    alt: str  # what a reader who cannot see it should know
    svg: str


class Canvas:
    """Draws the figures of one page: counts them, so that the ids inside one SVG never meet those of another."""

    def __init__(self) -> None:
        self.drawn = 0

    def picture(
        self, paint: Callable, title: str, caption: str, alt: str, size: tuple[float, float] = (4.2, 3.1), **axes
    ) -> Picture:
        """Return what `paint(ax)` draws as a picture of `size` (inches)."""
        self.drawn += 1
        key = f"f{self.drawn}"
        with rc_context({**STYLE, "svg.hashsalt": key}):
            figure = Figure(figsize=size, dpi=150, layout="constrained")
            paint(figure.subplots(subplot_kw=axes))
            return Picture(title, caption, alt, inline(figure, key, alt))


def inline(figure: Figure, key: str, alt: str) -> str:
    """Return a figure as an SVG element for a page: no metadata, every id begun with `key`, the text `alt` as label."""
    stream = io.StringIO()
    figure.savefig(stream, format="svg", metadata={"Date": None, "Creator": None, "Format": None, "Type": None})
    text = stream.getvalue()
    text = re.sub(r"<metadata>.*?</metadata>", "", text[text.index("<svg") :], flags=re.DOTALL)
    text = re.sub(r'\bid="([^"]+)"', rf'id="{key}-\1"', text)
    text = re.sub(r'(href="#|url\(#)', rf"\1{key}-", text)
    text = re.sub(r' (?:d|x|y)="[^"]+"', _rounded, text)
    text = re.sub(r"\s*\n\s*", "\n", text)
    return text.replace("<svg ", f'<svg role="img" aria-label="{html.escape(alt)}" ', 1)


def _rounded(attribute: re.Match) -> str:
    """Return coordinates rounded to a hundredth of a point."""
    return re.sub(r"\d+\.\d{3,}", lambda number: f"{float(number[0]):.2f}".rstrip("0").rstrip("."), attribute[0])


def drivers(study: Study, canvas: Canvas) -> list[Picture]:
    """Return, per swept axis, the medians of the forces over its values, and those of the p99 over the ideal peak."""
    joint = study.hardest_joint()
    if study.cases.empty or not study.levels() or not study.has(joint.column(study.lead.figure)):
        return []
    lead = study.lead
    forces = _drivers(study, canvas, ((lead.figure, lead.short, True), ("force_rms", "rms", False)), "force")
    if not study.has(joint.column(RATIO)) or len(study.levels()) == 1 or not _ideal_varies(study, joint):
        return forces
    return forces + _drivers(study, canvas, ((RATIO, "p99 / ideal", True),), "p99 / ideal peak")


def _ideal_varies(study: Study, joint: Joint) -> bool:
    """Tell whether a force over that of the ideal joint shows anything that the force itself does not."""
    column = joint.column("force_peak_ideal")
    return study.has(column) and study.cases[column].nunique() > 1


def _drivers(study: Study, canvas: Canvas, figures: tuple, name: str) -> list[Picture]:
    """Return one picture per axis, the strongest first; a figure is (column of a joint, name, with band)."""
    curves, several = {}, len(study.joints) > 1
    for one in findings.effects(study, study.hardest_joint().column(figures[0][0])):
        curves[one.axis.path] = []
    for place, joint in enumerate(study.joints):
        for figure, word, band in figures:
            colour = draw.JOINT_COLOURS[place % 3] if several or band else draw.RED
            named = word if not several else joint.title if band else ""  # dashed is explained above the figures
            for one in findings.effects(study, joint.column(figure)) if study.has(joint.column(figure)) else ():
                curves[one.axis.path].append((named, colour, band, one))
    edges = [
        edge
        for drawn in curves.values()
        for _, _, band, one in drawn
        for edge in ((one.low, one.high) if band else (one.medians,))
    ]
    return [_driver(study, canvas, drawn, name, _range(edges)) for drawn in curves.values() if drawn]


def impacts_name(study: Study) -> str:
    """Return what the column `impacts_per_rev` counts."""
    return "impacts" if study.mechanism == "impact-pair" else "impacts per revolution"


def _driver(study: Study, canvas: Canvas, curves: list, name: str, limits: tuple[float, float]) -> Picture:
    one = curves[0][3]
    unit, axis, joint = study.units.get(one.column, "1"), one.axis, study.joints[0]
    what = study.lead.short if one.column == joint.column(study.lead.figure) else "p99 / ideal"
    what += f", joint {joint.title}" if len(study.joints) > 1 else ""
    steps = (
        [
            f"{axis.text(value)}: {wording.text(median, unit)}"
            for value, median in zip(axis.values, one.medians, strict=True)
        ]
        if len(axis.values) <= 9
        else []
    )
    caption = "" if np.isnan(one.share) else f"{findings.percent(one.share)} of the variation of {what}"
    return canvas.picture(
        lambda ax: draw.effect(ax, curves, unit, limits, name),
        f"{_title(name)} over {axis.name}",
        caption,
        f"Median of {what} over {axis.name}. {'; '.join(steps)}",
        size=(3.3, 2.8),
    )


def maps(study: Study, joint: Joint, canvas: Canvas) -> list[Picture]:
    """Return heat maps of one joint: its leading figure over pairs of axes, more figures over the strongest pair."""
    lead = joint.column(study.lead.figure)
    ranked = [one.axis for one in findings.effects(study, lead)]
    pairs = [tuple(sorted(pair, key=study.axes.index)) for pair in itertools.combinations(ranked, 2)][:PAIRS]
    if not pairs or not study.has(lead):
        return []
    more = [("p99 / ideal peak", joint.column(RATIO))] if _ideal_varies(study, joint) else []
    more = [
        *more,
        (impacts_name(study), joint.column("impacts_per_rev")),
        ("time in contact", joint.column("contact_fraction")),
        ("wear depth", joint.column("wear_depth_max")),
    ]
    if joint == study.hardest_joint():
        more += [("slider error", "slider_error_max"), ("measured restitution", "pair_restitution")]
    wanted = [(study.lead.name, lead, pair) for pair in pairs]
    wanted += [(name, column, pairs[0]) for name, column in more if study.has(column)]
    return [_map(study, canvas, *one) for one in wanted]


def _map(study: Study, canvas: Canvas, name: str, column: str, pair: tuple[Axis, Axis]) -> Picture:
    across, up = pair
    table = medians(study, study.cases[column].to_numpy(float), across, up)
    scale = wording.scale(study.units.get(column, "1"), table[np.isfinite(table)])
    others = [axis.name for axis in study.swept() if axis not in pair]
    caption = f"Median over {wording.sentence_list(others)}." if others else "One case per cell."
    lowest, highest = (scale.text(value) for value in (np.nanmin(table), np.nanmax(table)))
    title = f"{_title(name)}: {across.name} {wording.TIMES} {up.name}"
    return canvas.picture(
        lambda ax: draw.heat(ax, table, across, up, scale, name),
        title,
        caption,
        f"Heat map of {name} over {across.name} and {up.name}, from {lowest} to {highest}. {caption}",
    )


def medians(study: Study, values: np.ndarray, across: Axis, up: Axis) -> np.ndarray:
    """Return the median of one value per finished case in every cell (up, across); NaN where there is none."""
    row, column = position(up, study.cases[up.path]), position(across, study.cases[across.path])
    cell = row * len(across.values) + column
    table = np.full(len(up.values) * len(across.values), np.nan)
    filled = np.isfinite(values) & (row >= 0) & (column >= 0)
    for place in np.unique(cell[filled]):
        table[place] = np.median(values[filled & (cell == place)])
    return table.reshape(len(up.values), len(across.values))


def tradeoffs(study: Study, canvas: Canvas) -> list[Picture]:
    """Return clouds of all cases: peak against p99, slider error against p99, p99 against the fastest onset."""
    if len(study.cases) < 3 or study.mechanism == "impact-pair":
        return []
    joint = study.hardest_joint()
    p99 = joint.column("force_p99")
    axes = [one.axis for one in findings.effects(study, p99)]
    wanted = (
        (
            "Force peak against p99",
            "force p99",
            p99,
            "force peak",
            joint.column("force_peak"),
            "Cases of equal p99 have different peaks: a peak is a single event.",
        ),
        (
            "Position error against force",
            "slider error",
            "slider_error_max",
            "force p99",
            p99,
            "Down and to the left is better.",
        ),
        (
            "How hard the journal arrives",
            "fastest onset",
            joint.column("onset_rate_max"),
            "force p99",
            p99,
            f"Steel stays elastic up to about {findings.ELASTIC_TEXT}.",
        ),
    )
    return [_cloud(study, canvas, axes, *one) for one in wanted if study.has(one[2]) and study.has(one[4])]


def _cloud(
    study: Study, canvas: Canvas, axes: list[Axis], title: str, x_name: str, x: str, y_name: str, y: str, caption: str
) -> Picture:
    places = position(axes[0], study.cases[axes[0].path]) if axes else None
    colour = (np.where(places < 0, np.nan, places), axes[0]) if axes else None
    scales = (study.scale(x), study.scale(y))
    return canvas.picture(
        lambda ax: draw.cloud(
            ax, study.cases[x].to_numpy(float), study.cases[y].to_numpy(float), colour, (x_name, y_name), scales
        ),
        title,
        caption,
        f"Cloud of {len(study.cases)} cases: {y_name} over {x_name}.",
    )


def wear(study: Study, joint: Joint, canvas: Canvas) -> list[Picture]:
    """Return the polar wear depth of the deepest worn case of one joint, and of the median one where there is one."""
    column = joint.column("wear_depth_max")
    if not joint.wears or not study.has(column):
        return []
    ordered = study.cases[column].dropna().sort_values(ascending=False, kind="stable").index
    chosen = {"Deepest": ordered[0]} | ({"Median": ordered[len(ordered) // 2]} if len(ordered) > 2 else {})
    return [_wear(study, joint, canvas, word, case_id) for word, case_id in chosen.items()]


def _wear(study: Study, joint: Joint, canvas: Canvas, word: str, case_id: str) -> Picture:
    bearing, journal = (np.asarray(depth, float) for depth in study.run.wear(case_id)[joint.name])
    caption = "; ".join(filter(None, (study.setting(case_id), f"case {case_id}")))
    deepest = [wording.text(float(depth.max(initial=0.0)), "m") for depth in (bearing, journal)]
    return canvas.picture(
        lambda ax: draw.wear(ax, bearing, journal),
        f"{word} wear, joint {joint.title}",
        caption,
        f"Polar wear depth: at most {deepest[0]} on the bearing, {deepest[1]} on the journal.",
        size=(4.2, 3.4),
        projection="polar",
    )


def _title(name: str) -> str:
    return name if name.startswith("p99") else f"{name[0].upper()}{name[1:]}"


def _range(edges: list[np.ndarray]) -> tuple[float, float]:
    everything = np.concatenate(edges)
    everything = everything[np.isfinite(everything)]
    return (float(everything.min()), float(everything.max())) if everything.size else (0.0, 1.0)
