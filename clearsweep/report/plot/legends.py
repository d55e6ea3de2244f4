"""Legends of lines, points and areas."""

import numpy as np

from . import marks
from .axes import Axes
from .items import Box, Entry
from .letters import height, text, width

SIZE, ROW, SPACE, AFTER = (
    8.0,
    12.5,
    6.0,
    5.0,
)  # points: font size, row height, gap after a sample, gap to the right of axes


def size(ax: Axes) -> tuple[float, float]:
    """Return the height above axes and the width to their right of their legend, in points."""
    if ax.key is None or not ax.entries:
        return 0.0, 0.0
    if ax.key["where"] == "above":
        return ROW * len(_rows(ax)) + 3.0, 0.0
    if ax.key["where"] == "right":
        title = ax.key.get("title") or ""
        widest = max([_sample(ax) + SPACE + width(entry.name, SIZE) for entry in ax.entries] + [width(title, SIZE)])
        return 0.0, AFTER + widest
    return 0.0, 0.0


def _sample(ax: Axes) -> float:
    """Return the width of the sample of a line, in points."""
    return SIZE * float(ax.key.get("handlelength", 2.0)) if ax.key else 0.0


def _rows(ax: Axes) -> list[list[Entry]]:
    """Return the entries row by row, in the requested columns, filled column by column."""
    columns = min(int(ax.key.get("ncols", 1)) if ax.key else 1, len(ax.entries))
    many = -(-len(ax.entries) // columns)
    return [ax.entries[row::many] for row in range(many)]


def drawn(ax: Axes, box: Box) -> list[str]:
    """Return the legend of axes as SVG."""
    if ax.key is None or not ax.entries:
        return []
    where, parts, sample = ax.key["where"], list[str](), _sample(ax)
    if where == "above":
        rows = _rows(ax)
        anchor = ax.key["bbox_to_anchor"][0]
        first = box.left + anchor * box.wide + 4.0
        apart = SIZE * float(ax.key.get("columnspacing", 2.0))
        columns = max(map(len, rows))
        wide = [max(width(row[k].name, SIZE) for row in rows if k < len(row)) for k in range(columns)]
        starts = first + np.cumsum([0.0, *(sample + SPACE + each + apart for each in wide)])
        for k, row in enumerate(rows):
            y = box.top - 3.0 - ROW * (len(rows) - k - 0.5)
            for start, entry in zip(starts.tolist(), row, strict=False):
                parts += _entry(entry, start, y, sample)
        return parts
    x = box.left + box.wide + AFTER if where == "right" else box.left + AFTER
    title = ax.key.get("title") or ""
    tall = ROW * len(ax.entries) + (height(title, SIZE) + 3.0 if title else 0.0)
    middle = where == "right" and ax.key["loc"] == "center left"
    y = box.top + 0.5 * (box.high - tall) if middle else box.top + (0.0 if where == "right" else 3.0)
    if title:
        parts.append(text(title, x, y + 0.8 * SIZE, SIZE, "start"))
        y += height(title, SIZE) + 3.0
    for k, entry in enumerate(ax.entries):
        parts += _entry(entry, x, y + ROW * (k + 0.5), sample)
    return parts


def _entry(entry: Entry, x: float, y: float, sample: float) -> list[str]:
    """Return a row of a legend: a sample and its name; y : of its centre."""
    parts = []
    if entry.fill:
        parts.append(
            f'<rect x="{x:.2f}" y="{y - 2.8:.2f}" width="{sample:.2f}" height="5.6" style="fill: {entry.fill}"/>'
        )
    if entry.stroke:
        parts.append(marks.line(f"M{x:.2f} {y:.2f}h{sample:.2f}", entry.stroke))
    if entry.marks:
        shown = entry.marks._replace(size=max(entry.marks.size, 4.0), alpha=1.0)
        parts.append(marks.points(np.array([x + 0.5 * sample]), np.array([y]), shown))
    parts.append(text(entry.name, x + sample + SPACE, y, SIZE, "start", middle=True))
    return parts
