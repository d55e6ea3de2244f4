"""Items and legends as SVG."""

import numpy as np
from matplotlib.colors import to_hex

from .axes import Axes
from .items import Box, Item, LegendEntry, MarkerStyle, Stroke, TextStyle, text_height, text_svg, text_width

# Lines, points, areas, cells and texts as SVG.

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
            path = path_data(x, y, closed=True)
            opacity = f"; fill-opacity: {alpha:g}" if alpha < 1.0 else ""
            return f'<path d="{path}" style="fill: {colour}{opacity}"/>' if path else ""
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


def line_svg(path: str, stroke: Stroke) -> str:
    """Return a path as a line."""
    dash = " ".join(f"{float(part) * stroke.width:g}" for part in stroke.dash.split())
    style = f"fill: none; stroke: {stroke.colour}; stroke-width: {stroke.width:g}"
    style += f"; stroke-dasharray: {dash}" if dash else ""
    style += f"; stroke-opacity: {stroke.alpha:g}" if stroke.alpha < 1.0 else ""
    style += f"; stroke-linecap: {stroke.cap}" if stroke.cap != "butt" else ""
    return f'<path d="{path}" style="{style}; stroke-linejoin: round"/>' if path else ""


def points_svg(x: np.ndarray, y: np.ndarray, marker_style: MarkerStyle) -> str:
    """Return points of one style as one path."""
    finite = np.isfinite(x) & np.isfinite(y)
    digits = 1 if finite.sum() > LONG_PATH else 2
    positions = list(zip(x[finite].round(digits).tolist(), y[finite].round(digits).tolist(), strict=True))
    if not positions:
        return ""
    half_size, opacity = (
        0.5 * marker_style.size,
        f"; stroke-opacity: {marker_style.alpha:g}" if marker_style.alpha < 1.0 else "",
    )
    if marker_style.fill_colour:
        circle_style = f"fill: {marker_style.fill_colour}; stroke: {marker_style.colour}"
        circle_style += f"; stroke-width: {marker_style.edge_width:g}"
        return "".join(
            f'<circle cx="{a:g}" cy="{b:g}" r="{half_size:g}" style="{circle_style}"/>' for a, b in positions
        )
    style = f"fill: none; stroke: {marker_style.colour}{opacity}"
    if marker_style.shape == "s":
        return _squares_svg(positions, marker_style)
    if marker_style.shape in "o.":
        path = "".join(f"M{a:g} {b:g}h0" for a, b in positions)
        return f'<path d="{path}" style="{style}; stroke-width: {marker_style.size:g}; stroke-linecap: round"/>'
    if marker_style.shape == "D":
        path = "".join(
            f"M{a:g} {b - half_size:g}l{half_size:g} {half_size:g}l{-half_size:g} {half_size:g}l{-half_size:g} "
            f"{-half_size:g}Z"
            for a, b in positions
        )
        return f'<path d="{path}" style="fill: {marker_style.colour}{opacity.replace("stroke", "fill")}"/>'
    directions = {"|": [(0, 1)], "_": [(1, 0)], "+": [(0, 1), (1, 0)], "x": [(1, 1), (1, -1)], "X": [(1, 1), (1, -1)]}
    path = "".join(
        f"M{a - u * half_size:g} {b - v * half_size:g}l{2 * u * half_size:g} {2 * v * half_size:g}"
        for a, b in positions
        for u, v in directions[marker_style.shape]
    )
    stroke_width = max(0.35 * marker_style.size, 1.0) if marker_style.shape == "X" else marker_style.edge_width
    return f'<path d="{path}" style="{style}; stroke-width: {stroke_width:g}"/>'


def _squares_svg(positions: list[tuple[float, float]], marker_style: MarkerStyle) -> str:
    side = marker_style.size
    path = "".join(f"M{a - 0.5 * side:g} {b - 0.5 * side:g}h{side:g}v{side:g}h{-side:g}Z" for a, b in positions)
    opacity = f"; fill-opacity: {marker_style.alpha:g}" if marker_style.alpha < 1.0 else ""
    return f'<path d="{path}" style="fill: {marker_style.colour}{opacity}"/>'


def _cells_svg(item: Item, ax: Axes, box: Box) -> str:
    """Return cells; adjacent cells of one colour are merged."""
    colours, edge, edge_width = item.style
    x = (box.left + ax.xaxis.fraction(item.x) * box.width).round(2)
    y = (box.top + (1.0 - ax.yaxis.fraction(item.y)) * box.height).round(2)
    paths: dict[str, list[str]] = {}
    for row, row_colours in enumerate(colours):
        column = 0
        while column < len(row_colours):
            end = column + 1
            while not edge and end < len(row_colours) and row_colours[end] == row_colours[column]:
                end += 1
            if row_colours[column]:
                cell_width, cell_height = x[end] - x[column], y[row + 1] - y[row]
                paths.setdefault(row_colours[column], []).append(
                    f"M{x[column]:g} {y[row]:g}h{cell_width:.2f}v{cell_height:.2f}h{-cell_width:.2f}Z"
                )
            column = end
    edge_style = f"; stroke: {edge}; stroke-width: {edge_width:g}" if edge else ""
    rendering = "" if edge else ' shape-rendering="crispEdges"'
    cells = "\n".join(
        f'<path d="{"".join(path)}" style="fill: {colour}{edge_style}"/>' for colour, path in paths.items()
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


def _text_svg(x: float, y: float, text_style: TextStyle) -> str:
    weight = f"font-weight: {text_style.weight}; " if text_style.weight != "normal" else ""
    style = f"{weight}fill: {text_style.colour}"
    return _halo(x, y, text_style) + text_svg(
        text_style.text,
        x,
        y,
        text_style.size,
        _ANCHORS[text_style.ha],
        style=style,
        is_centred=text_style.va == "center",
    )


def _halo(x: float, y: float, text_style: TextStyle) -> str:
    """Return the background of a text centred at a position, or ''."""
    if not text_style.halo:
        return ""
    pad = float(text_style.halo.get("pad", 1.0))
    halo_width, halo_height = (
        text_width(text_style.text, text_style.size) + 2.0 * pad,
        text_height(text_style.text, text_style.size) + 2.0 * pad,
    )
    style = f"fill: {to_hex(text_style.halo['facecolor'])}; fill-opacity: {text_style.halo.get('alpha', 1.0):g}"
    return (
        f'<rect x="{x - 0.5 * halo_width:.2f}" y="{y - 0.5 * halo_height:.2f}" '
        f'width="{halo_width:.2f}" height="{halo_height:.2f}" '
        f'style="{style}"/>'
    )


# Legends of lines, points and areas.

FONT_SIZE, ROW_HEIGHT, SAMPLE_GAP, AXES_GAP = (
    8.0,
    12.5,
    6.0,
    5.0,
)  # points: font size, row height, gap after a sample, gap to the right of axes


def legend_size(ax: Axes) -> tuple[float, float]:
    """Return the height above axes and the width to their right of their legend, in points."""
    if ax.legend_options is None or not ax.legend_entries:
        return 0.0, 0.0
    if ax.legend_options["placement"] == "above":
        return ROW_HEIGHT * len(_rows(ax)) + 3.0, 0.0
    if ax.legend_options["placement"] == "right":
        title = ax.legend_options.get("title") or ""
        widest = max(
            [_sample_width(ax) + SAMPLE_GAP + text_width(entry.name, FONT_SIZE) for entry in ax.legend_entries]
            + [text_width(title, FONT_SIZE)]
        )
        return 0.0, AXES_GAP + widest
    return 0.0, 0.0


def _sample_width(ax: Axes) -> float:
    """Return the width of the sample of a line, in points."""
    return FONT_SIZE * float(ax.legend_options.get("handlelength", 2.0)) if ax.legend_options else 0.0


def _rows(ax: Axes) -> list[list[LegendEntry]]:
    """Return the entries row by row, in the requested columns, filled column by column."""
    columns = min(int(ax.legend_options.get("ncols", 1)) if ax.legend_options else 1, len(ax.legend_entries))
    row_count = -(-len(ax.legend_entries) // columns)
    return [ax.legend_entries[row::row_count] for row in range(row_count)]


def legend_svg(ax: Axes, box: Box) -> list[str]:
    """Return the legend of axes as SVG."""
    if ax.legend_options is None or not ax.legend_entries:
        return []
    placement, parts, sample_width = ax.legend_options["placement"], list[str](), _sample_width(ax)
    if placement == "above":
        rows = _rows(ax)
        anchor = ax.legend_options["bbox_to_anchor"][0]
        left = box.left + anchor * box.width + 4.0
        column_gap = FONT_SIZE * float(ax.legend_options.get("columnspacing", 2.0))
        columns = max(map(len, rows))
        column_widths = [
            max(text_width(row[k].name, FONT_SIZE) for row in rows if k < len(row)) for k in range(columns)
        ]
        entry_lefts = left + np.cumsum(
            [0.0, *(sample_width + SAMPLE_GAP + column_width + column_gap for column_width in column_widths)]
        )
        for k, row in enumerate(rows):
            y = box.top - 3.0 - ROW_HEIGHT * (len(rows) - k - 0.5)
            for entry_left, entry in zip(entry_lefts.tolist(), row, strict=False):
                parts += _entry_svg(entry, entry_left, y, sample_width)
        return parts
    x = box.left + box.width + AXES_GAP if placement == "right" else box.left + AXES_GAP
    title = ax.legend_options.get("title") or ""
    total_height = ROW_HEIGHT * len(ax.legend_entries) + (text_height(title, FONT_SIZE) + 3.0 if title else 0.0)
    is_centred = placement == "right" and ax.legend_options["loc"] == "center left"
    y = box.top + 0.5 * (box.height - total_height) if is_centred else box.top + (0.0 if placement == "right" else 3.0)
    if title:
        parts.append(text_svg(title, x, y + 0.8 * FONT_SIZE, FONT_SIZE, "start"))
        y += text_height(title, FONT_SIZE) + 3.0
    for k, entry in enumerate(ax.legend_entries):
        parts += _entry_svg(entry, x, y + ROW_HEIGHT * (k + 0.5), sample_width)
    return parts


def _entry_svg(entry: LegendEntry, x: float, y: float, sample_width: float) -> list[str]:
    """Return a row of a legend: a sample and its name; y : of its centre."""
    parts = []
    if entry.fill_colour:
        parts.append(
            f'<rect x="{x:.2f}" y="{y - 2.8:.2f}" width="{sample_width:.2f}" height="5.6" '
            f'style="fill: {entry.fill_colour}"/>'
        )
    if entry.stroke:
        parts.append(line_svg(f"M{x:.2f} {y:.2f}h{sample_width:.2f}", entry.stroke))
    if entry.marker_style:
        marker_style = entry.marker_style._replace(size=max(entry.marker_style.size, 4.0), alpha=1.0)
        parts.append(points_svg(np.array([x + 0.5 * sample_width]), np.array([y]), marker_style))
    parts.append(text_svg(entry.name, x + sample_width + SAMPLE_GAP, y, FONT_SIZE, "start", is_centred=True))
    return parts
