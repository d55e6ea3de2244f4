"""Drawings that compare cases: effects, strips, curves, clouds, histograms."""

import re
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.colors import Normalize
from matplotlib.ticker import FuncFormatter

from ...language import wording
from ...language.wording import Scale
from ..data.axis import Axis
from ..statistics.main_effects import MainEffect
from .style import (
    BLUE,
    GREEN,
    GREY,
    INK,
    ORANGE,
    PALE,
    PURPLE,
    RED,
    TICKS_NAMED,
    logarithmic,
    name_values,
    named_bar,
    plain_axes,
    with_unit,
)

CURVES = (BLUE, RED, GREEN, ORANGE, PURPLE, "#56B4E9", INK)  # of many curves; the next seven are dashed
BINS_DRAWN = 41  # largest number of bin edges of a histogram
POINTS_VECTOR = 300  # points of a cloud above which they are drawn as pixels
POINTS_DRAWN = 50_000  # points of a cloud above which covered points are omitted
LINES_BESIDE, NAME_SIZE = 24, 6.5  # lines available for names next to a drawing; font size, points
LONG = 10  # letters of a curve's name above which names are placed at the top
CELLS_SEEN = 300  # per side of a cloud: each is smaller than a point
DECADES = 8.0  # ratio of largest to smallest value above which an axis is logarithmic


class Curve(NamedTuple):
    """The medians of one figure of one joint over the values of an axis."""

    name: str  # in the legend; '' for none
    colour: str
    band: bool  # shaded from the 10th to the 90th percentile, with a solid line
    effect: MainEffect


class Family(NamedTuple):
    """One figure (SI) over an axis, a curve for each value of another axis, and its limit."""

    axis: Axis
    title: str  # of the legend; '' for none
    names: list[str]  # of the curves
    curves: np.ndarray  # (names, values of the axis)
    limit_values: np.ndarray | None  # (values of the axis,)


def family(ax: Axes, drawn: Family, scale: wording.Scale, name: str) -> None:
    """Draw the curves of a family in the unit `scale`, and the limit as a horizontal line."""
    known = drawn.curves[np.isfinite(drawn.curves)]
    places, spacing = _places(drawn.axis)
    shades = colormaps["viridis"](np.linspace(0.0, 0.85, len(drawn.names)))
    for curve, word, shade in zip(drawn.curves, drawn.names, shades, strict=True):
        is_known = np.isfinite(curve)
        marker = "o" if len(places) <= TICKS_NAMED else None
        style: dict[str, Any] = {"marker": marker, "markersize": 3.5, "linewidth": 1.4}
        ax.plot(places[is_known], curve[is_known] / scale.factor, color=shade, label=word or None, **style)
    if drawn.limit_values is not None:
        ax.plot(places, drawn.limit_values / scale.factor, color=RED, linewidth=1.4, linestyle="--", label="limit")
        known = np.concatenate([known, drawn.limit_values[np.isfinite(drawn.limit_values)]])
    ax.set(xlabel=drawn.axis.label(), ylabel=with_unit(name, scale))
    if spacing == "log":
        ax.set_xscale("log")
    if len(places) <= TICKS_NAMED:
        name_values(ax.xaxis, drawn.axis, places)
    elif spacing == "log":
        logarithmic(ax, "x")
    if known.min() > 0.0 and known.max() > DECADES * known.min():
        logarithmic(ax, "y")
    elif known.min() >= 0.0:
        ax.set_ylim(0.0, 1.08 * known.max() / scale.factor or None)
    plain_axes(ax)
    if any(drawn.names):
        where: dict[str, Any] = {"loc": "upper left", "bbox_to_anchor": (1.0, 1.03)}
        title = re.sub(r" (?=[\[(])", "\n", drawn.title)
        if max(map(len, drawn.names)) > LONG:
            where, title = {"loc": "lower left", "bbox_to_anchor": (-0.12, 1.0), "ncols": 2}, ""
        ax.legend(title=title, handlelength=1.4, frameon=False, **where)


def effect(ax: Axes, curves: Sequence[Curve], scale: wording.Scale, limits: tuple[float, float], name: str) -> None:
    """Draw medians of a figure, within `limits` (SI), in the unit `scale` over the values of one axis."""
    axis = curves[0].effect.axis
    places, spacing = _places(axis)
    ticks, named = places, spacing == "name"
    joints = list(dict.fromkeys(curve.colour for curve in curves if curve.band))
    strength = 0.15 if len(curves) <= 2 else 0.06
    for curve in curves:
        low, high = curve.effect.low / scale.factor, curve.effect.high / scale.factor
        if named:  # no line between names
            offset = joints.index(curve.colour) if curve.colour in joints else 0
            places = ticks + 0.16 * (offset - 0.5 * (len(joints) - 1))
        if curve.band and named:
            ax.vlines(places, low, high, color=curve.colour, alpha=0.3, linewidth=6)
        elif curve.band:
            ax.fill_between(places, low, high, color=curve.colour, alpha=strength, linewidth=0)
        ax.plot(
            places,
            curve.effect.medians / scale.factor,
            color=curve.colour,
            linewidth=1.5,
            linestyle="" if named else "-" if curve.band else "--",
            label=curve.name,
            markersize=4,
            marker=("o" if curve.band else "s") if named or len(places) <= TICKS_NAMED else None,
        )
    ax.set(xlabel=axis.label(), ylabel=with_unit(name, scale))
    if spacing == "log":
        ax.set_xscale("log")
    if named:
        ax.set_xlim(-0.5, len(places) - 0.5)
    if named or len(places) <= TICKS_NAMED:
        name_values(ax.xaxis, axis, ticks)
    elif spacing == "log":
        logarithmic(ax, "x")
    if limits[0] > 0.0 and limits[1] > DECADES * limits[0]:
        logarithmic(ax, "y")
    ax.set_ylim(limits[0] / scale.factor * 0.9, limits[1] / scale.factor * 1.1)
    plain_axes(ax)
    if len(curves) > 1:
        above: dict[str, Any] = {"loc": "lower left", "bbox_to_anchor": (-0.12, 1.0), "ncols": 3, "borderaxespad": 0.2}
        ax.legend(**above, columnspacing=1.0, handlelength=1.6, frameon=False)


def strip(ax: Axes, groups: Sequence[tuple[str, np.ndarray]], name: str, scale: Scale) -> None:
    """Draw one row of points (SI, scaled) for each name, from the bottom up, with a bar at its median."""
    for place, (_, values) in enumerate(groups):
        ax.plot(
            values / scale.factor,
            np.full(len(values), place),
            "o",
            color=BLUE,
            markersize=4.5,
            alpha=0.55,
            markeredgewidth=0,
            rasterized=len(values) > POINTS_VECTOR,
        )
        ax.plot(np.median(values) / scale.factor, place, "|", color=RED, markersize=11, markeredgewidth=2.2)
    all_values = np.concatenate([values for _, values in groups])
    if all_values.min() > 0.0 and all_values.max() > 4.0 * all_values.min():  # else a log axis has no ticks
        logarithmic(ax, "x")
    _rows(ax, [law for law, _ in groups])
    ax.set_xlabel(with_unit(name, scale))


def returned(ax: Axes, rows: Sequence[tuple[str, float, float]]) -> None:
    """Draw the specified and the effective restitution by law; a row is (name, specified, effective)."""
    names = list(dict.fromkeys(row[0] for row in rows))[::-1]
    for number, (name, wanted, given) in enumerate(rows):
        place = names.index(name)
        ax.plot([wanted, given], [place, place], "-", color=GREY, linewidth=1.2, zorder=1)
        ax.plot(
            wanted,
            place,
            "o",
            markerfacecolor="white",
            color=INK,
            markersize=6,
            label="specified" if number == 0 else None,
        )
        ax.plot(given, place, "D", color=RED, markersize=4.5, label="computed" if number == 0 else None)
    _rows(ax, names)
    ax.set_xlabel("restitution")
    ax.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2, frameon=False, borderaxespad=0.2)


def elastic(ax: Axes, depths: np.ndarray, curves: Sequence[tuple[str, np.ndarray, bool]]) -> None:
    """Draw forces (N) over penetration (m); a curve is (name, forces, whether it is used); others are grey."""
    scale = wording.scale("m", depths)
    for (name, forces, used), number in zip(curves, _counted(curves), strict=True):
        dash = ("-", "--", ":")[number // len(CURVES) % 3]
        ax.plot(
            depths / scale.factor,
            forces,
            color=CURVES[number % len(CURVES)] if used else PALE,
            linestyle=dash if used else "-",
            linewidth=1.6 if used else 1.1,
            label=name if used else None,
            zorder=2 if used else 1,
        )
    ax.set(xscale="log", yscale="log", xlabel=f"penetration [{scale.unit}]", ylabel="elastic force [N]")
    ax.xaxis.set_major_formatter(FuncFormatter(lambda value, _: wording.short(value, 2)))
    ax.yaxis.set_major_formatter(FuncFormatter(lambda value, _: wording.short(value, 2)))
    others = [(name, forces[-1]) for name, forces, used in curves if not used]
    _name_others(ax, depths[-1] / scale.factor, others)
    plain_axes(ax)
    if others:
        ax.legend(loc="upper left", frameon=False, handlelength=2.4)
    else:
        ax.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False, handlelength=2.4)


def _name_others(ax: Axes, depth: float, ends: Sequence[tuple[str, float]]) -> None:
    """Label curves at their right ends (at `depth` on the axis, force in N), each label on its own line."""
    ends = sorted(ends, key=lambda end: end[1])
    low, high = np.log(ax.get_ylim())
    apart = (high - low) / max(len(ends), LINES_BESIDE)
    heights = [float(np.log(force)) for _, force in ends]
    for k in range(1, len(heights)):
        heights[k] = max(heights[k], heights[k - 1] + apart)
    for k in reversed(range(len(heights))):
        heights[k] = min(heights[k], high - apart * (len(heights) - k - 0.5))
    for (name, force), height in zip(ends, heights, strict=True):
        ax.annotate(
            name,
            (depth, force),
            (1.06, float(np.exp(height))),
            textcoords=ax.get_yaxis_transform(),
            va="center",
            color=GREY,
            fontsize=NAME_SIZE,
            arrowprops={"arrowstyle": "-", "color": PALE, "linewidth": 0.5, "shrinkB": 0, "relpos": (0.0, 0.5)},
        )


def _counted(curves: Sequence[tuple[str, np.ndarray, bool]]) -> list[int]:
    """Return, for each curve, the number of used curves before it."""
    return [sum(used for *_, used in curves[:place]) for place in range(len(curves))]


def _rows(ax: Axes, names: Sequence[str]) -> None:
    """Label the rows of a drawing, from the bottom up."""
    ax.set_yticks(np.arange(len(names)), names)
    ax.set_ylim(-0.6, len(names) - 0.4)
    ax.tick_params(axis="y", length=0)
    plain_axes(ax)


def cloud(
    ax: Axes,
    x: np.ndarray,
    y: np.ndarray,
    colour: tuple[np.ndarray, Axis] | None,
    names: tuple[str, str],
    scales: tuple[Scale, Scale],
) -> None:
    """Draw one point per case (SI, scaled); `colour` : index of its value on an axis."""
    x, y = x / scales[0].factor, y / scales[1].factor
    wide = [_spread(values) for values in (x, y)]
    style: dict[str, Any] = {
        "s": 16 if len(x) <= POINTS_VECTOR else 6,
        "linewidths": 0,
        "alpha": 0.85,
        "rasterized": len(x) > POINTS_VECTOR,
    }
    if colour is None:
        ax.scatter(x, y, color=BLUE, **style)
    else:
        places, axis = colour
        norm = Normalize(0, max(len(axis.values) - 1, 1))
        ax.scatter(x, y, c=places, norm=norm, cmap="viridis", **style)
        named_bar(ax, axis, norm)
    for which, apart in zip(("x", "y"), wide, strict=True):
        if apart:
            logarithmic(ax, which)
    ax.set(xlabel=with_unit(names[0], scales[0]), ylabel=with_unit(names[1], scales[1]))
    plain_axes(ax)


def uncovered(
    x: np.ndarray, y: np.ndarray, colour: tuple[np.ndarray, Axis] | None
) -> tuple[np.ndarray, np.ndarray, tuple[np.ndarray, Axis] | None]:
    """Return the points of a `cloud` without covered ones, if they are many."""
    if len(x) <= POINTS_DRAWN:
        return x, y, colour
    seen = _seen(*(np.log(values) if _spread(values) else values for values in (x, y)))
    return x[seen], y[seen], colour and (colour[0][seen], colour[1])


def _spread(values: np.ndarray) -> bool:
    """Return whether the spread of values requires a logarithmic scale."""
    known = values[np.isfinite(values)]
    return bool(known.size and known.min() > 0.0 and known.max() > DECADES * known.min())


def _seen(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Return the indices of points not covered by later ones: the last one in every small cell of the plane."""
    known = np.flatnonzero(np.isfinite(x) & np.isfinite(y))
    cells = np.zeros(len(known), np.int32)
    for values in (x, y):
        cells = cells * CELLS_SEEN + _cells(values[known])
    _, last = np.unique(cells[::-1], return_index=True)
    return np.sort(known[len(known) - 1 - last])


def _cells(values: np.ndarray) -> np.ndarray:
    """Return the indices of values among CELLS_SEEN equal parts of their span."""
    low, high = (values.min(), values.max()) if len(values) else (0.0, 0.0)
    parts: np.ndarray = (CELLS_SEEN * (values - low) / (high - low or 1.0)).astype(np.int32)
    return parts.clip(max=CELLS_SEEN - 1, out=parts)


def histogram(
    ax: Axes, values: np.ndarray, name: str, scale: Scale, marks: tuple[float, ...], limit: float | None
) -> None:
    """Draw the distribution of values (SI, scaled), with marked values and a limit."""
    shown = values / scale.factor
    bins = "auto" if np.ptp(shown) > 1e-9 * np.abs(shown).max() else 1
    edges = np.histogram_bin_edges(shown, bins)
    edges = edges if len(edges) <= BINS_DRAWN else np.linspace(edges[0], edges[-1], BINS_DRAWN)
    ax.hist(shown, edges.tolist(), weights=np.full(len(shown), 100.0 / len(shown)), color=BLUE, alpha=0.85, linewidth=0)
    for mark in marks:
        ax.axvline(mark / scale.factor, color=INK, linewidth=0.9, linestyle=":")
    if limit is not None:
        ax.axvline(limit / scale.factor, color=RED, linewidth=1.4)
    ax.set(xlabel=with_unit(name, scale), ylabel="cases [%]")
    plain_axes(ax)


def _places(axis: Axis) -> tuple[np.ndarray, str]:
    """Return the positions of an axis's values on an abscissa, and the kind of the abscissa."""
    if not axis.numeric:
        return np.arange(len(axis.values), dtype=float), "name"
    places = axis.scale.of(np.asarray(axis.values, float))
    return places, "log" if places.min() > 0.0 and places.max() >= 8.0 * places.min() else "linear"
