"""Lines, points, areas, cells and words as SVG."""

import numpy as np
from matplotlib.colors import to_hex

from .axes import Axes
from .items import Box, Item, Marks, Stroke, Words
from .letters import height, text, width

LONG = 300  # corners of a path above which it is rounded to a tenth of a point
_ANCHORS = {"left": "start", "center": "middle", "right": "end"}


def drawn(item: Item, ax: Axes, box: Box) -> str:
    """Return an item as SVG."""
    if item.kind == "cells":
        return _cells(item, ax, box)
    if item.kind == "ellipse":
        return _ellipse(item, ax, box)
    x, y = ax.points(item.x, item.y, box)
    x = box.left + item.x * box.wide if item.upright else x
    y = box.top + (1.0 - item.y) * box.high if item.across else y
    match item.kind:
        case "line":
            return line(path(x, y), item.look)
        case "points":
            return points(x, y, item.look)
        case "area":
            colour, alpha = item.look
            shape = path(x, y, closed=True)
            faint = f"; fill-opacity: {alpha:g}" if alpha < 1.0 else ""
            return f'<path d="{shape}" style="fill: {colour}{faint}"/>' if shape else ""
        case _:
            return _words(float(x[0]), float(y[0]), item.look)


def path(x: np.ndarray, y: np.ndarray, *, closed: bool = False) -> str:
    """Return the lines between points, with gaps where they are not finite."""
    finite = np.isfinite(x) & np.isfinite(y)
    if not finite.any():
        return ""
    digits = 1 if len(x) > LONG else 2
    parts, ends = [], np.flatnonzero(np.diff(np.r_[0, finite.astype(int), 0]))
    for first, last in zip(ends[::2].tolist(), ends[1::2].tolist(), strict=True):
        corners = [
            f"{a:g} {b:g}"
            for a, b in zip(x[first:last].round(digits).tolist(), y[first:last].round(digits).tolist(), strict=True)
        ]
        parts.append("M" + "L".join(corners) + ("Z" if closed else ""))
    return "".join(parts)


def line(shape: str, stroke: Stroke) -> str:
    """Return a path as a line."""
    dash = " ".join(f"{float(part) * stroke.width:g}" for part in stroke.dash.split())
    style = f"fill: none; stroke: {stroke.colour}; stroke-width: {stroke.width:g}"
    style += f"; stroke-dasharray: {dash}" if dash else ""
    style += f"; stroke-opacity: {stroke.alpha:g}" if stroke.alpha < 1.0 else ""
    style += f"; stroke-linecap: {stroke.cap}" if stroke.cap != "butt" else ""
    return f'<path d="{shape}" style="{style}; stroke-linejoin: round"/>' if shape else ""


def points(x: np.ndarray, y: np.ndarray, marks: Marks) -> str:
    """Return points of one style as one path."""
    finite = np.isfinite(x) & np.isfinite(y)
    digits = 1 if finite.sum() > LONG else 2
    places = list(zip(x[finite].round(digits).tolist(), y[finite].round(digits).tolist(), strict=True))
    if not places:
        return ""
    half, faint = 0.5 * marks.size, f"; stroke-opacity: {marks.alpha:g}" if marks.alpha < 1.0 else ""
    if marks.filled:
        look = f"fill: {marks.filled}; stroke: {marks.colour}; stroke-width: {marks.edge:g}"
        return "".join(f'<circle cx="{a:g}" cy="{b:g}" r="{half:g}" style="{look}"/>' for a, b in places)
    style = f"fill: none; stroke: {marks.colour}{faint}"
    if marks.shape == "s":
        return _squares(places, marks)
    if marks.shape in "o.":
        shape = "".join(f"M{a:g} {b:g}h0" for a, b in places)
        return f'<path d="{shape}" style="{style}; stroke-width: {marks.size:g}; stroke-linecap: round"/>'
    if marks.shape == "D":
        shape = "".join(
            f"M{a:g} {b - half:g}l{half:g} {half:g}l{-half:g} {half:g}l{-half:g} {-half:g}Z" for a, b in places
        )
        return f'<path d="{shape}" style="fill: {marks.colour}{faint.replace("stroke", "fill")}"/>'
    ways = {"|": [(0, 1)], "_": [(1, 0)], "+": [(0, 1), (1, 0)], "x": [(1, 1), (1, -1)], "X": [(1, 1), (1, -1)]}
    shape = "".join(
        f"M{a - u * half:g} {b - v * half:g}l{2 * u * half:g} {2 * v * half:g}"
        for a, b in places
        for u, v in ways[marks.shape]
    )
    wide = max(0.35 * marks.size, 1.0) if marks.shape == "X" else marks.edge
    return f'<path d="{shape}" style="{style}; stroke-width: {wide:g}"/>'


def _squares(places: list[tuple[float, float]], marks: Marks) -> str:
    side = marks.size
    shape = "".join(f"M{a - 0.5 * side:g} {b - 0.5 * side:g}h{side:g}v{side:g}h{-side:g}Z" for a, b in places)
    faint = f"; fill-opacity: {marks.alpha:g}" if marks.alpha < 1.0 else ""
    return f'<path d="{shape}" style="fill: {marks.colour}{faint}"/>'


def _cells(item: Item, ax: Axes, box: Box) -> str:
    """Return cells; adjacent cells of one colour are merged."""
    colours, edge, wide = item.look
    x = (box.left + ax.xaxis.share(item.x) * box.wide).round(2)
    y = (box.top + (1.0 - ax.yaxis.share(item.y)) * box.high).round(2)
    shapes: dict[str, list[str]] = {}
    for row, line_of in enumerate(colours):
        column = 0
        while column < len(line_of):
            last = column + 1
            while not edge and last < len(line_of) and line_of[last] == line_of[column]:
                last += 1
            if line_of[column]:
                across, up = x[last] - x[column], y[row + 1] - y[row]
                shapes.setdefault(line_of[column], []).append(
                    f"M{x[column]:g} {y[row]:g}h{across:.2f}v{up:.2f}h{-across:.2f}Z"
                )
            column = last
    rim = f"; stroke: {edge}; stroke-width: {wide:g}" if edge else ""
    sharp = "" if edge else ' shape-rendering="crispEdges"'
    cells = "\n".join(f'<path d="{"".join(shape)}" style="fill: {colour}{rim}"/>' for colour, shape in shapes.items())
    return f"<g{sharp}>\n{cells}\n</g>"


def _ellipse(item: Item, ax: Axes, box: Box) -> str:
    (x, across), (y, up) = item.x, item.y
    face, edge, wide = item.look
    (left, right), (low, high) = ax.xaxis.share([x - across, x + across]), ax.yaxis.share([y - up, y + up])
    return (
        f'<ellipse cx="{box.left + 0.5 * (left + right) * box.wide:.2f}" '
        f'cy="{box.top + (1.0 - 0.5 * (low + high)) * box.high:.2f}" rx="{0.5 * (right - left) * box.wide:.2f}" '
        f'ry="{0.5 * (high - low) * box.high:.2f}" style="fill: {face}; stroke: {edge}; stroke-width: {wide:g}"/>'
    )


def _words(x: float, y: float, words: Words) -> str:
    weight = f"font-weight: {words.weight}; " if words.weight != "normal" else ""
    look = f"{weight}fill: {words.colour}"
    return _halo(x, y, words) + text(
        words.text, x, y, words.size, _ANCHORS[words.ha], look=look, middle=words.va == "center"
    )


def _halo(x: float, y: float, words: Words) -> str:
    """Return the background of a text centred at a position, or ''."""
    if not words.halo:
        return ""
    pad = float(words.halo.get("pad", 1.0))
    wide, high = width(words.text, words.size) + 2.0 * pad, height(words.text, words.size) + 2.0 * pad
    style = f"fill: {to_hex(words.halo['facecolor'])}; fill-opacity: {words.halo.get('alpha', 1.0):g}"
    return (
        f'<rect x="{x - 0.5 * wide:.2f}" y="{y - 0.5 * high:.2f}" width="{wide:.2f}" height="{high:.2f}" '
        f'style="{style}"/>'
    )
