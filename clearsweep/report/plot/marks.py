"""Lines, points, areas, cells and words as SVG."""

import numpy as np
from matplotlib.colors import to_hex

from .axes import Axes
from .items import Box, Item, Marks, Stroke, TextStyle
from .letters import text_height, text_svg, text_width

LONG_PATH = 300  # corners of a path above which it is rounded to a tenth of a point
_ANCHORS = {"left": "start", "center": "middle", "right": "end"}


def item_svg(item: Item, ax: Axes, box: Box) -> str:
    """Return an item as SVG."""
    if item.kind == "cells":
        return _cells_svg(item, ax, box)
    if item.kind == "ellipse":
        return _ellipse_svg(item, ax, box)
    x, y = ax.to_points(item.x, item.y, box)
    x = box.left + item.x * box.width if item.spans_width else x
    y = box.top + (1.0 - item.y) * box.height if item.spans_height else y
    match item.kind:
        case "line":
            return line_svg(path_data(x, y), item.style)
        case "points":
            return points_svg(x, y, item.style)
        case "area":
            colour, alpha = item.style
            shape = path_data(x, y, closed=True)
            opacity = f"; fill-opacity: {alpha:g}" if alpha < 1.0 else ""
            return f'<path d="{shape}" style="fill: {colour}{opacity}"/>' if shape else ""
        case _:
            return _text_svg(float(x[0]), float(y[0]), item.style)


def path_data(x: np.ndarray, y: np.ndarray, *, closed: bool = False) -> str:
    """Return the lines between points, with gaps where they are not finite."""
    finite = np.isfinite(x) & np.isfinite(y)
    if not finite.any():
        return ""
    digits = 1 if len(x) > LONG_PATH else 2
    parts, boundaries = [], np.flatnonzero(np.diff(np.r_[0, finite.astype(int), 0]))
    for start, end in zip(boundaries[::2].tolist(), boundaries[1::2].tolist(), strict=True):
        corners = [
            f"{a:g} {b:g}"
            for a, b in zip(x[start:end].round(digits).tolist(), y[start:end].round(digits).tolist(), strict=True)
        ]
        parts.append("M" + "L".join(corners) + ("Z" if closed else ""))
    return "".join(parts)


def line_svg(shape: str, stroke: Stroke) -> str:
    """Return a path as a line."""
    dash = " ".join(f"{float(part) * stroke.width:g}" for part in stroke.dash.split())
    style = f"fill: none; stroke: {stroke.colour}; stroke-width: {stroke.width:g}"
    style += f"; stroke-dasharray: {dash}" if dash else ""
    style += f"; stroke-opacity: {stroke.alpha:g}" if stroke.alpha < 1.0 else ""
    style += f"; stroke-linecap: {stroke.cap}" if stroke.cap != "butt" else ""
    return f'<path d="{shape}" style="{style}; stroke-linejoin: round"/>' if shape else ""


def points_svg(x: np.ndarray, y: np.ndarray, marks: Marks) -> str:
    """Return points of one style as one path."""
    finite = np.isfinite(x) & np.isfinite(y)
    digits = 1 if finite.sum() > LONG_PATH else 2
    positions = list(zip(x[finite].round(digits).tolist(), y[finite].round(digits).tolist(), strict=True))
    if not positions:
        return ""
    half_size, opacity = 0.5 * marks.size, f"; stroke-opacity: {marks.alpha:g}" if marks.alpha < 1.0 else ""
    if marks.filled:
        look = f"fill: {marks.filled}; stroke: {marks.colour}; stroke-width: {marks.edge:g}"
        return "".join(f'<circle cx="{a:g}" cy="{b:g}" r="{half_size:g}" style="{look}"/>' for a, b in positions)
    style = f"fill: none; stroke: {marks.colour}{opacity}"
    if marks.shape == "s":
        return _squares(positions, marks)
    if marks.shape in "o.":
        shape = "".join(f"M{a:g} {b:g}h0" for a, b in positions)
        return f'<path d="{shape}" style="{style}; stroke-width: {marks.size:g}; stroke-linecap: round"/>'
    if marks.shape == "D":
        shape = "".join(
            f"M{a:g} {b - half_size:g}l{half_size:g} {half_size:g}l{-half_size:g} {half_size:g}l{-half_size:g} "
            f"{-half_size:g}Z"
            for a, b in positions
        )
        return f'<path d="{shape}" style="fill: {marks.colour}{opacity.replace("stroke", "fill")}"/>'
    directions = {"|": [(0, 1)], "_": [(1, 0)], "+": [(0, 1), (1, 0)], "x": [(1, 1), (1, -1)], "X": [(1, 1), (1, -1)]}
    shape = "".join(
        f"M{a - u * half_size:g} {b - v * half_size:g}l{2 * u * half_size:g} {2 * v * half_size:g}"
        for a, b in positions
        for u, v in directions[marks.shape]
    )
    stroke_width = max(0.35 * marks.size, 1.0) if marks.shape == "X" else marks.edge
    return f'<path d="{shape}" style="{style}; stroke-width: {stroke_width:g}"/>'


def _squares(positions: list[tuple[float, float]], marks: Marks) -> str:
    side = marks.size
    shape = "".join(f"M{a - 0.5 * side:g} {b - 0.5 * side:g}h{side:g}v{side:g}h{-side:g}Z" for a, b in positions)
    opacity = f"; fill-opacity: {marks.alpha:g}" if marks.alpha < 1.0 else ""
    return f'<path d="{shape}" style="fill: {marks.colour}{opacity}"/>'


def _cells_svg(item: Item, ax: Axes, box: Box) -> str:
    """Return cells; adjacent cells of one colour are merged."""
    colours, edge, edge_width = item.style
    x = (box.left + ax.xaxis.fraction(item.x) * box.width).round(2)
    y = (box.top + (1.0 - ax.yaxis.fraction(item.y)) * box.height).round(2)
    shapes: dict[str, list[str]] = {}
    for row, row_colours in enumerate(colours):
        column = 0
        while column < len(row_colours):
            end = column + 1
            while not edge and end < len(row_colours) and row_colours[end] == row_colours[column]:
                end += 1
            if row_colours[column]:
                cell_width, cell_height = x[end] - x[column], y[row + 1] - y[row]
                shapes.setdefault(row_colours[column], []).append(
                    f"M{x[column]:g} {y[row]:g}h{cell_width:.2f}v{cell_height:.2f}h{-cell_width:.2f}Z"
                )
            column = end
    edge_style = f"; stroke: {edge}; stroke-width: {edge_width:g}" if edge else ""
    rendering = "" if edge else ' shape-rendering="crispEdges"'
    cells = "\n".join(
        f'<path d="{"".join(shape)}" style="fill: {colour}{edge_style}"/>' for colour, shape in shapes.items()
    )
    return f"<g{rendering}>\n{cells}\n</g>"


def _ellipse_svg(item: Item, ax: Axes, box: Box) -> str:
    (x, x_radius), (y, y_radius) = item.x, item.y
    face, edge, edge_width = item.style
    (left, right), (low, high) = (
        ax.xaxis.fraction([x - x_radius, x + x_radius]),
        ax.yaxis.fraction([y - y_radius, y + y_radius]),
    )
    return (
        f'<ellipse cx="{box.left + 0.5 * (left + right) * box.width:.2f}" '
        f'cy="{box.top + (1.0 - 0.5 * (low + high)) * box.height:.2f}" rx="{0.5 * (right - left) * box.width:.2f}" '
        f'ry="{0.5 * (high - low) * box.height:.2f}" '
        f'style="fill: {face}; stroke: {edge}; stroke-width: {edge_width:g}"/>'
    )


def _text_svg(x: float, y: float, words: TextStyle) -> str:
    weight = f"font-weight: {words.weight}; " if words.weight != "normal" else ""
    look = f"{weight}fill: {words.colour}"
    return _halo(x, y, words) + text_svg(
        words.text, x, y, words.size, _ANCHORS[words.ha], look=look, is_centred=words.va == "center"
    )


def _halo(x: float, y: float, words: TextStyle) -> str:
    """Return the background of a text centred at a position, or ''."""
    if not words.halo:
        return ""
    pad = float(words.halo.get("pad", 1.0))
    halo_width, halo_height = (
        text_width(words.text, words.size) + 2.0 * pad,
        text_height(words.text, words.size) + 2.0 * pad,
    )
    style = f"fill: {to_hex(words.halo['facecolor'])}; fill-opacity: {words.halo.get('alpha', 1.0):g}"
    return (
        f'<rect x="{x - 0.5 * halo_width:.2f}" y="{y - 0.5 * halo_height:.2f}" '
        f'width="{halo_width:.2f}" height="{halo_height:.2f}" '
        f'style="{style}"/>'
    )
