"""Drawings that compare cases: effects, strips, curves, clouds, histograms."""

import re
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ...language import wording
from ...language.wording import Scale
from ..axis import Axis
from ..effects import MainEffect
from ..plot import Axes, ColourScale
from . import (
    BLUE,
    INK,
    MAX_LABELLED_TICKS,
    RED,
    draw_axis_colour_bar,
    label_values,
    label_with_unit,
    set_log_scale,
    set_plain_axes,
)

MAX_BIN_EDGES = 41  # largest number of bin edges of a histogram
MANY_POINTS = 300  # points of a cloud above which they are smaller
MAX_POINTS = 50_000  # points of a cloud above which covered points are omitted
NAMES_LEFT = -0.12  # left end of names above a drawing, as a share of its width
MAX_SIDE_NAME_LENGTH = 10  # letters of a curve's name above which names are placed at the top
GRID_CELLS = 300  # per side of a cloud: each is smaller than a point
LOG_SCALE_RATIO = 8.0  # ratio of largest to smallest value above which an axis is logarithmic


class Curve(NamedTuple):
    """The medians of one figure of one joint over the values of an axis."""

    name: str  # in the legend; '' for none
    colour: str
    has_band: bool  # shaded from the 10th to the 90th percentile, with a solid line
    effect: MainEffect


class CurveFamily(NamedTuple):
    """One figure (SI) over an axis, a curve for each value of another axis, and its limit."""

    axis: Axis
    title: str  # of the legend; '' for none
    names: list[str]  # of the curves
    curves: np.ndarray  # (names, values of the axis)
    limit_values: np.ndarray | None  # (values of the axis,)


def draw_family(ax: Axes, family: CurveFamily, scale: wording.Scale, name: str) -> None:
    """Draw the curves of a family in the unit `scale`, and the limit as a horizontal line."""
    known_values = family.curves[np.isfinite(family.curves)]
    positions = _positions(family.axis)
    colours = ColourScale(0.0, 1.0).hex_colours(np.linspace(0.0, 0.85, len(family.names)))
    for curve, label, colour in zip(family.curves, family.names, colours, strict=True):
        is_known = np.isfinite(curve)
        marker = "o" if len(positions) <= MAX_LABELLED_TICKS else ""
        style: dict[str, Any] = {"marker": marker, "markersize": 3.5, "linewidth": 1.4}
        ax.plot(positions[is_known], curve[is_known] / scale.factor, color=colour, label=label, **style)
    if family.limit_values is not None:
        ax.plot(positions, family.limit_values / scale.factor, color=RED, linewidth=1.4, linestyle="--", label="limit")
        known_values = np.concatenate([known_values, family.limit_values[np.isfinite(family.limit_values)]])
    ax.set_labels(family.axis.label(), label_with_unit(name, scale))
    _label_abscissa(ax, family.axis, positions)
    if known_values.min() > 0.0 and known_values.max() > LOG_SCALE_RATIO * known_values.min():
        set_log_scale(ax, "y")
    elif known_values.min() >= 0.0:
        ax.set_ylim(0.0, 1.08 * known_values.max() / scale.factor or None)
    set_plain_axes(ax)
    if any(family.names):
        if max(map(len, family.names)) > MAX_SIDE_NAME_LENGTH:
            ax.set_legend("above", columns=2, sample=1.4, left=NAMES_LEFT)
        else:
            ax.set_legend("right", title=re.sub(r" (?=[\[(])", "\n", family.title), sample=1.4)


def _label_abscissa(ax: Axes, axis: Axis, positions: np.ndarray) -> None:
    """Scale and label the abscissa of an axis: its values if they are few."""
    if axis.is_geometric:
        set_log_scale(ax, "x")
    if not axis.is_numeric or len(positions) <= MAX_LABELLED_TICKS:
        label_values(ax.xaxis, axis, positions)


def draw_effect(
    ax: Axes, curves: Sequence[Curve], scale: wording.Scale, limits: tuple[float, float], name: str
) -> None:
    """Draw medians of a figure, within `limits` (SI), in the unit `scale` over the values of one axis."""
    axis = curves[0].effect.axis
    positions = tick_positions = _positions(axis)
    has_names = not axis.is_numeric
    has_markers = has_names or len(positions) <= MAX_LABELLED_TICKS
    joint_colours = list(dict.fromkeys(curve.colour for curve in curves if curve.has_band))
    band_alpha = 0.15 if len(curves) <= 2 else 0.06
    for curve in curves:
        low, high = curve.effect.low / scale.factor, curve.effect.high / scale.factor
        if has_names:  # no line between names
            offset = joint_colours.index(curve.colour) if curve.colour in joint_colours else 0
            positions = tick_positions + 0.16 * (offset - 0.5 * (len(joint_colours) - 1))
        marker, line_style = ("o", "-") if curve.has_band else ("s", "--")
        if curve.has_band and has_names:
            ax.vlines(positions, low, high, color=curve.colour, alpha=0.3, linewidth=6)
        elif curve.has_band:
            ax.fill_between(positions, low, high, color=curve.colour, alpha=band_alpha)
        style: dict[str, Any] = {"linestyle": "" if has_names else line_style, "marker": marker if has_markers else ""}
        medians = curve.effect.medians / scale.factor
        ax.plot(positions, medians, color=curve.colour, linewidth=1.5, label=curve.name, markersize=4, **style)
    ax.set_labels(axis.label(), label_with_unit(name, scale))
    if has_names:
        ax.set_xlim(-0.5, len(positions) - 0.5)
    _label_abscissa(ax, axis, tick_positions)
    if limits[0] > 0.0 and limits[1] > LOG_SCALE_RATIO * limits[0]:
        set_log_scale(ax, "y")
    ax.set_ylim(limits[0] / scale.factor * 0.9, limits[1] / scale.factor * 1.1)
    set_plain_axes(ax)
    if len(curves) > 1:
        ax.set_legend("above", columns=3, column_gap=1.0, sample=1.6, left=NAMES_LEFT)


def draw_strip(ax: Axes, groups: Sequence[tuple[str, np.ndarray]], name: str, scale: Scale) -> None:
    """Draw one row of points (SI, scaled) for each name, from the bottom up, with a bar at its median."""
    for row, (_, values) in enumerate(groups):
        ax.plot(values / scale.factor, np.full(len(values), row), "o", color=BLUE, markersize=4.5, alpha=0.55)
        ax.plot(np.median(values) / scale.factor, row, "|", color=RED, markersize=11, markeredgewidth=2.2)
    all_values = np.concatenate([values for _, values in groups])
    if all_values.min() > 0.0 and all_values.max() > 4.0 * all_values.min():  # else a log axis has no ticks
        set_log_scale(ax, "x")
    label_rows(ax, [group_name for group_name, _ in groups])
    ax.xaxis.label = label_with_unit(name, scale)


def label_rows(ax: Axes, names: Sequence[str]) -> None:
    """Label the rows of a drawing, from the bottom up."""
    ax.yaxis.set_ticks(range(len(names)), names)
    ax.set_ylim(-0.6, len(names) - 0.4)
    ax.set_tick_length(0.0, "y")
    set_plain_axes(ax)


def draw_cloud(
    ax: Axes,
    x: np.ndarray,
    y: np.ndarray,
    colour: tuple[np.ndarray, Axis] | None,
    names: tuple[str, str],
    scales: tuple[Scale, Scale],
) -> None:
    """Draw one point per case (SI, scaled); `colour` : index of its value on an axis."""
    x, y = x / scales[0].factor, y / scales[1].factor
    style: dict[str, Any] = {"size": 4.0 if len(x) <= MANY_POINTS else 2.4, "alpha": 0.85}
    if colour is None:
        ax.scatter(x, y, color=BLUE, **style)
    else:
        value_indices, axis = colour
        colours = ColourScale(0.0, float(max(len(axis.values) - 1, 1)))
        ax.scatter(x, y, values=value_indices, scale=colours, **style)
        draw_axis_colour_bar(ax, axis, colours)
    set_log_scale(ax, *(side for side, values in (("x", x), ("y", y)) if _needs_log_scale(values)))
    ax.set_labels(label_with_unit(names[0], scales[0]), label_with_unit(names[1], scales[1]))
    set_plain_axes(ax)


def without_covered_points(
    x: np.ndarray, y: np.ndarray, colour: tuple[np.ndarray, Axis] | None
) -> tuple[np.ndarray, np.ndarray, tuple[np.ndarray, Axis] | None]:
    """Return the points of `draw_cloud` without covered ones, if they are many."""
    if len(x) <= MAX_POINTS:
        return x, y, colour
    visible = visible_points(*(np.log(values) if _needs_log_scale(values) else values for values in (x, y)))
    return x[visible], y[visible], colour and (colour[0][visible], colour[1])


def _needs_log_scale(values: np.ndarray) -> bool:
    """Return whether the spread of values requires a logarithmic scale."""
    known = values[np.isfinite(values)]
    return bool(known.size and known.min() > 0.0 and known.max() > LOG_SCALE_RATIO * known.min())


def visible_points(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Return the indices of points not covered by later ones: the last one in every small cell of the plane."""
    finite = np.flatnonzero(np.isfinite(x) & np.isfinite(y))
    cells = np.zeros(len(finite), np.int32)
    for values in (x, y):
        known = values[finite]
        low, high = (known.min(), known.max()) if len(known) else (0.0, 0.0)
        indices = (GRID_CELLS * (known - low) / (high - low or 1.0)).astype(np.int32)
        cells = cells * GRID_CELLS + indices.clip(max=GRID_CELLS - 1)
    _, last_indices = np.unique(cells[::-1], return_index=True)
    return np.sort(finite[len(finite) - 1 - last_indices])


def draw_histogram(
    ax: Axes, values: np.ndarray, name: str, scale: Scale, marked_values: tuple[float, ...], limit: float | None
) -> None:
    """Draw the distribution of values (SI, scaled), with marked values and a limit."""
    scaled_values = values / scale.factor
    bins = "auto" if np.ptp(scaled_values) > 1e-9 * np.abs(scaled_values).max() else 1
    edges = np.histogram_bin_edges(scaled_values, bins)
    edges = edges if len(edges) <= MAX_BIN_EDGES else np.linspace(edges[0], edges[-1], MAX_BIN_EDGES)
    weights = np.full(len(scaled_values), 100.0 / len(scaled_values))
    ax.hist(scaled_values, edges.tolist(), weights=weights, color=BLUE, alpha=0.85)
    for marked_value in marked_values:
        ax.axvline(marked_value / scale.factor, color=INK, linewidth=0.9, linestyle=":")
    if limit is not None:
        ax.axvline(limit / scale.factor, color=RED, linewidth=1.4)
    ax.set_labels(label_with_unit(name, scale), "cases [%]")
    set_plain_axes(ax)


def _positions(axis: Axis) -> np.ndarray:
    """Return the positions of an axis's values on an abscissa."""
    if not axis.is_numeric:
        return np.arange(len(axis.values), dtype=float)
    return np.asarray(axis.scale.from_si(np.asarray(axis.values, float)))
