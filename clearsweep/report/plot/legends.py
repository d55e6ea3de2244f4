"""Legends of lines, points and areas."""

import numpy as np

from . import marks
from .axes import Axes
from .items import Box, LegendEntry
from .letters import text_height, text_svg, text_width

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
        parts.append(marks.line_svg(f"M{x:.2f} {y:.2f}h{sample_width:.2f}", entry.stroke))
    if entry.marker_style:
        marker_style = entry.marker_style._replace(size=max(entry.marker_style.size, 4.0), alpha=1.0)
        parts.append(marks.points_svg(np.array([x + 0.5 * sample_width]), np.array([y]), marker_style))
    parts.append(text_svg(entry.name, x + sample_width + SAMPLE_GAP, y, FONT_SIZE, "start", is_centred=True))
    return parts
