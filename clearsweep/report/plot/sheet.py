"""Axes on a sheet as SVG: items and legends, position, edges, ticks and labels, colour bar."""

import numpy as np

from .axes import Axes
from .items import (
    PAPER,
    Box,
    ColourScale,
    Item,
    Legend,
    LegendEntry,
    MarkerStyle,
    Side,
    Stroke,
    TextStyle,
    png_address,
    text_height,
    text_svg,
    text_width,
)

# Lines, points, areas, cells and texts as SVG.

HALO_PAD = 0.8  # points of background around a text
PIXELS_PER_POINT = 4  # of an image of points
MAX_POINTS, MAX_CELLS = 4_000, 3_000  # above these, they are pixels of an image
LONG_PATH = 300  # corners of a path above which it is rounded to a tenth of a point
_ANCHORS = {"left": "start", "center": "middle", "right": "end"}


def item_svg(item: Item, ax: Axes, box: Box) -> str:
    """Return an item as SVG."""
    if item.kind == "cells":
        return _cells_svg(item, ax, box) if item.style.values.size <= MAX_CELLS else _image_of_cells(item, ax, box)
    if item.kind == "ellipse":
        return _ellipse_svg(item, ax, box)
    x, y = ax.to_points(item.x, item.y, box)
    x = box.left + item.x * box.width if item.spans_width else x
    y = box.top + (1.0 - item.y) * box.height if item.spans_height else y
    match item.kind:
        case "line":
            return line_svg(path_data(x, y), item.style)
        case "points":
            return points_svg(x, y, item.style) if len(x) <= MAX_POINTS else _pixels_svg(x, y, item.style, box)
        case "area":
            colour, alpha = item.style
            path = path_data(x, y, closed=True)
            opacity = f"; fill-opacity: {alpha:g}" if alpha < 1.0 else ""
            return f'<path d="{path}" style="fill: {colour}{opacity}"/>' if path else ""
        case _:
            return _text_svg(float(x[0]) + item.style.offset, float(y[0]), item.style)


def path_data(x: np.ndarray, y: np.ndarray, *, closed: bool = False) -> str:
    """Return the lines between points, with gaps where they are not finite."""
    finite = np.isfinite(x) & np.isfinite(y)
    if not finite.any():
        return ""
    digits = 1 if len(x) > LONG_PATH else 2
    parts, boundaries = [], np.flatnonzero(np.diff(np.r_[0, finite.astype(int), 0]))
    for start, end in zip(boundaries[::2].tolist(), boundaries[1::2].tolist(), strict=True):
        places = x[start:end].round(digits).tolist(), y[start:end].round(digits).tolist()
        corners = [f"{a:g} {b:g}" for a, b in zip(*places, strict=True)]
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
    half_size = 0.5 * marker_style.size
    opacity = f"; stroke-opacity: {marker_style.alpha:g}" if marker_style.alpha < 1.0 else ""
    if marker_style.fill_colour:
        circle_style = f"fill: {marker_style.fill_colour}; stroke: {marker_style.colour}"
        circle_style += f"; stroke-width: {marker_style.edge_width:g}"
        return "".join(
            f'<circle cx="{a:g}" cy="{b:g}" r="{half_size:g}" style="{circle_style}"/>' for a, b in positions
        )
    style = f"fill: none; stroke: {marker_style.colour}{opacity}"
    if marker_style.shape in "sD":
        across = marker_style.size
        outline = f"h{across:g}v{across:g}h{-across:g}"
        if marker_style.shape == "D":
            outline = f"l{half_size:g} {half_size:g}l{-half_size:g} {half_size:g}l{-half_size:g} {-half_size:g}"
        left = half_size if marker_style.shape == "s" else 0.0
        path = "".join(f"M{a - left:g} {b - half_size:g}{outline}Z" for a, b in positions)
        return f'<path d="{path}" style="fill: {marker_style.colour}{opacity.replace("stroke", "fill")}"/>'
    if marker_style.shape in "o.":
        path = "".join(f"M{a:g} {b:g}h0" for a, b in positions)
        return f'<path d="{path}" style="{style}; stroke-width: {marker_style.size:g}; stroke-linecap: round"/>'
    directions = {"|": [(0, 1)], "_": [(1, 0)], "+": [(0, 1), (1, 0)], "x": [(1, 1), (1, -1)], "X": [(1, 1), (1, -1)]}
    path = "".join(
        f"M{a - u * half_size:g} {b - v * half_size:g}l{2 * u * half_size:g} {2 * v * half_size:g}"
        for a, b in positions
        for u, v in directions[marker_style.shape]
    )
    stroke_width = max(0.35 * marker_style.size, 1.0) if marker_style.shape == "X" else marker_style.edge_width
    return f'<path d="{path}" style="{style}; stroke-width: {stroke_width:g}"/>'


def _cells_svg(item: Item, ax: Axes, box: Box) -> str:
    """Return cells; adjacent cells of one colour are merged."""
    values, scale, edge, edge_width = item.style
    fractions, is_known = scale.fractions(values), np.isfinite(values)
    colours = [
        [colour if known else "" for colour, known in zip(scale.hex_colours(row), known_row, strict=True)]
        for row, known_row in zip(fractions, is_known, strict=True)
    ]
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
    (left, right) = ax.xaxis.fraction([x - x_radius, x + x_radius])
    (low, high) = ax.yaxis.fraction([y - y_radius, y + y_radius])
    return (
        f'<ellipse cx="{box.left + 0.5 * (left + right) * box.width:.2f}" '
        f'cy="{box.top + (1.0 - 0.5 * (low + high)) * box.height:.2f}" rx="{0.5 * (right - left) * box.width:.2f}" '
        f'ry="{0.5 * (high - low) * box.height:.2f}" '
        f'style="fill: {face}; stroke: {edge}; stroke-width: {edge_width:g}"/>'
    )


def _text_svg(x: float, y: float, text_style: TextStyle) -> str:
    weight = f"font-weight: {text_style.weight}; " if text_style.weight != "normal" else ""
    style, is_centred = f"{weight}fill: {text_style.colour}", text_style.va == "center"
    anchor, size = _ANCHORS[text_style.ha], text_style.size
    text = text_svg(text_style.text, x, y, size, anchor, style=style, is_centred=is_centred)
    return _halo(x, y, text_style) + text


def _halo(x: float, y: float, text_style: TextStyle) -> str:
    """Return the background of a text centred at a position, or ''."""
    if not text_style.has_halo:
        return ""
    width = text_width(text_style.text, text_style.size) + 2.0 * HALO_PAD
    height = text_height(text_style.text, text_style.size) + 2.0 * HALO_PAD
    rectangle = _frame(Box(x - 0.5 * width, y - 0.5 * height, width, height))
    return f'<rect {rectangle} style="fill: {PAPER}; fill-opacity: 0.75"/>'


def _frame(box: Box) -> str:
    """Return the attributes of a box."""
    return f'x="{box.left:.2f}" y="{box.top:.2f}" width="{box.width:.2f}" height="{box.height:.2f}"'


def _image_of_cells(item: Item, ax: Axes, box: Box) -> str:
    """Return cells at equal distances as an image, a pixel for each."""
    values, scale, *_ = item.style
    opacity = np.where(np.isfinite(values), 255, 0)[..., None].astype(np.uint8)
    pixels = np.concatenate([scale.rgb(scale.fractions(values)), opacity], axis=-1)
    (left, right), (bottom, top) = ax.to_points(item.x[[0, -1]], item.y[[0, -1]], box)
    return image_svg(pixels[::-1], Box(left, top, right - left, bottom - top))


def image_svg(pixels: np.ndarray, box: Box, *, is_smooth: bool = False) -> str:
    """Return an image (rows, columns, 4), uint8 RGBA, that fills a box."""
    rendering = "" if is_smooth else ' style="image-rendering: pixelated"'
    return f'<image {_frame(box)} preserveAspectRatio="none"{rendering} href="{png_address(pixels)}"/>'


def _pixels_svg(x: np.ndarray, y: np.ndarray, marker_style: MarkerStyle, box: Box) -> str:
    """Return many points as an image: each covers the pixels within its radius, at least the nearest."""
    finite = np.isfinite(x) & np.isfinite(y)
    columns, rows = (max(1, round(PIXELS_PER_POINT * length)) for length in (box.width, box.height))
    column = ((x[finite] - box.left) / box.width * columns).astype(int)
    row = ((y[finite] - box.top) / box.height * rows).astype(int)
    reach = int(0.5 * marker_style.size * PIXELS_PER_POINT)
    is_covered = np.zeros((rows, columns), bool)
    for across in range(-reach, reach + 1):
        for down in range(-reach, reach + 1):
            if across**2 + down**2 <= reach**2:
                m, k = column + across, row + down
                is_inside = (m >= 0) & (m < columns) & (k >= 0) & (k < rows)
                is_covered[k[is_inside], m[is_inside]] = True
    red, green, blue = (int(marker_style.colour[i : i + 2], 16) for i in (1, 3, 5))
    pixels = np.zeros((rows, columns, 4), np.uint8)
    pixels[is_covered] = (red, green, blue, round(255 * marker_style.alpha))
    return image_svg(pixels, box)


# Legends of lines, points and areas.

FONT_SIZE, ROW_HEIGHT = 8.0, 12.5  # points
SAMPLE_GAP, AXES_GAP = 6.0, 5.0  # points after a sample, to the right of axes


def legend_size(ax: Axes) -> tuple[float, float]:
    """Return the height above axes and the width to their right of their legend, in points."""
    legend = ax.legend
    if legend is None or not ax.legend_entries or legend.place == "inside":
        return 0.0, 0.0
    if legend.place == "above":
        return ROW_HEIGHT * len(_rows(ax, legend)) + 3.0, 0.0
    names = [FONT_SIZE * legend.sample + SAMPLE_GAP + text_width(entry.name, FONT_SIZE) for entry in ax.legend_entries]
    return 0.0, AXES_GAP + max(*names, text_width(legend.title, FONT_SIZE))


def _rows(ax: Axes, legend: Legend) -> list[list[LegendEntry]]:
    """Return the entries row by row, in the requested columns, filled column by column."""
    row_count = -(-len(ax.legend_entries) // min(legend.columns, len(ax.legend_entries)))
    return [ax.legend_entries[row::row_count] for row in range(row_count)]


def legend_svg(ax: Axes, box: Box) -> list[str]:
    """Return the legend of axes as SVG."""
    legend = ax.legend
    if legend is None or not ax.legend_entries:
        return []
    if legend.place == "above":
        return _legend_above(ax, legend, box)
    is_right, parts = legend.place.endswith("right"), []
    x = box.left + AXES_GAP + (box.width if is_right else 0.0)
    title_height = text_height(legend.title, FONT_SIZE) + 3.0 if legend.title else 0.0
    free_height = box.height - ROW_HEIGHT * len(ax.legend_entries) - title_height
    y = box.top + (0.5 * free_height if legend.place == "centre right" else 0.0 if is_right else 3.0)
    if legend.title:
        parts.append(text_svg(legend.title, x, y + 0.8 * FONT_SIZE, FONT_SIZE, "start"))
    for k, entry in enumerate(ax.legend_entries):
        parts += _entry_svg(entry, x, y + title_height + ROW_HEIGHT * (k + 0.5), FONT_SIZE * legend.sample)
    return parts


def _legend_above(ax: Axes, legend: Legend, box: Box) -> list[str]:
    rows, sample_width, parts = _rows(ax, legend), FONT_SIZE * legend.sample, []
    columns = [[row[k] for row in rows if k < len(row)] for k in range(max(map(len, rows)))]
    names = [max(text_width(entry.name, FONT_SIZE) for entry in column) for column in columns]
    widths = [sample_width + SAMPLE_GAP + name for name in names]
    lefts = box.left + legend.left * box.width + 4.0
    entry_lefts = lefts + np.cumsum([0.0, *(width + FONT_SIZE * legend.column_gap for width in widths)])
    for k, row in enumerate(rows):
        y = box.top - 3.0 - ROW_HEIGHT * (len(rows) - k - 0.5)
        for entry_left, entry in zip(entry_lefts.tolist(), row, strict=False):
            parts += _entry_svg(entry, entry_left, y, sample_width)
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


# Axes on a sheet as SVG: position, edges, ticks and labels, colour bar.

GREY = "#6b7785"
PAD, GAP, LABEL_SIZE = (4.0, 3.5, 9.0)  # points: margin of a sheet, from a tick to its name, font size
BAR_WIDTH, BAR_GAP = 10.0, 7.0  # points: width of a colour bar, distance from the axes
BAR_PIXELS = 128  # of a colour bar


class Sheet:
    """A sheet with one pair of axes."""

    def __init__(self, size: tuple[float, float]):
        """Take the size in inches."""
        self.width, self.height = (72.0 * side for side in size)
        self.axes: Axes = Axes(size)

    def box(self) -> Box:
        """Return the position of the axes within labels, ticks, legend and bar."""
        ax = self.axes
        space_above, right = legend_size(ax)
        left = PAD + _tick_width(ax.yaxis, self.height - 50.0) + label_space(ax.yaxis)
        texts = [item.style for item in ax.items if item.kind == "text" and item.spans_width and item.x[0] >= 1.0]
        widths = (AXES_GAP + style.offset + text_width(style.text, style.size) for style in texts)
        right = PAD + max(right, max(widths, default=0.0))
        if ax.colour_bar:
            bar_side = ax.colour_bar[1]
            right += BAR_GAP + BAR_WIDTH + _tick_width(bar_side, self.height - 50.0) + label_space(bar_side)
        names = ax.xaxis.ticks(self.width - left - right)
        space_below = PAD + _tick_height(ax.xaxis, [name for _, name in names]) + label_space(ax.xaxis)
        top = PAD + max(space_above, 0.5 * ax.yaxis.font_size)
        if names and not ax.colour_bar and not ax.xaxis.rotation:
            tick, name = names[-1]
            beyond = (1.0 - float(ax.xaxis.fraction(tick))) * (self.width - left - right)
            overhang = 0.5 * text_width(name, ax.xaxis.font_size) - beyond
            right = max(right, PAD + overhang)
        box = Box(left, top, max(self.width - left - right, 20.0), max(self.height - top - space_below, 20.0))
        if not ax.equal_aspect:
            return box
        x_range, y_range = (abs(np.subtract(*side.limits())) for side in (ax.xaxis, ax.yaxis))
        scale = min(box.width / x_range, box.height / y_range)
        width, height = scale * x_range, scale * y_range
        return Box(box.left + 0.5 * (box.width - width), box.top + 0.5 * (box.height - height), width, height)

    def svg(self, id_prefix: str, box: Box) -> str:
        """Return the sheet, with its axes in `box`, as an SVG element whose ids are prefixed by `id_prefix`."""
        ax = self.axes
        clip_id = f"{id_prefix}-clip"
        parts = [
            f'<svg width="{self.width:g}pt" height="{self.height:g}pt" viewBox="0 0 {self.width:g} {self.height:g}" '
            'xmlns="http://www.w3.org/2000/svg">',
            f'<clipPath id="{clip_id}"><rect {_frame(box)}/></clipPath>',
            f'<rect width="{self.width:g}" height="{self.height:g}" style="fill: {PAPER}"/>',
        ]
        ticks = {"x": ax.xaxis.ticks(box.width), "y": ax.yaxis.ticks(box.height)}
        if ax.face_colour != PAPER:
            parts.append(f'<rect {_frame(box)} style="fill: {ax.face_colour}"/>')
        if ax.grid_stroke:
            parts.append(self._grid_svg(ticks, box))
        items = sorted(ax.items, key=lambda item: item.order)
        parts.append(f'<g clip-path="url(#{clip_id})">')
        parts += [item_svg(item, ax, box) for item in items if item.is_clipped]
        parts.append("</g>")
        parts += [item_svg(item, ax, box) for item in items if not item.is_clipped]
        parts += [self._edges_svg(box), self._ticks_svg(ticks, box)]
        parts += legend_svg(ax, box)
        if ax.colour_bar:
            parts.append(self._bar_svg(*ax.colour_bar, box))
        return "\n".join([*filter(None, parts), "</svg>\n"])

    def _grid_svg(self, ticks: dict[str, list[tuple[float, str]]], box: Box) -> str:
        ax, path = self.axes, []
        for tick, _ in ticks["x"]:
            x = box.left + float(ax.xaxis.fraction(tick)) * box.width
            path.append(f"M{x:.2f} {box.top:.2f}v{box.height:.2f}")
        for tick, _ in ticks["y"]:
            y = box.top + (1.0 - float(ax.yaxis.fraction(tick))) * box.height
            path.append(f"M{box.left:.2f} {y:.2f}h{box.width:.2f}")
        assert ax.grid_stroke is not None
        return line_svg("".join(path), ax.grid_stroke)

    def _edges_svg(self, box: Box) -> str:
        left, top, width, height = box
        lines = {
            "left": f"M{left:.2f} {top:.2f}v{height:.2f}",
            "right": f"M{left + width:.2f} {top:.2f}v{height:.2f}",
            "top": f"M{left:.2f} {top:.2f}h{width:.2f}",
            "bottom": f"M{left:.2f} {top + height:.2f}h{width:.2f}",
        }
        path = "".join(line for name, line in lines.items() if name in self.axes.edges)
        style = f"fill: none; stroke: {GREY}; stroke-width: 0.8; stroke-linecap: square"
        return f'<path d="{path}" style="{style}"/>' if path else ""

    def _ticks_svg(self, ticks: dict[str, list[tuple[float, str]]], box: Box) -> str:
        ax, path, texts = self.axes, [], []
        side, bottom = ax.xaxis, box.top + box.height
        for tick, name in ticks["x"]:
            x, y = box.left + float(side.fraction(tick)) * box.width, bottom + side.tick_length + GAP
            path.append(f"M{x:.2f} {bottom:.2f}v{side.tick_length:g}" if side.tick_length else "")
            if side.rotation:
                middle = y + 0.5 * side.font_size
                texts.append(text_svg(name, x, middle, side.font_size, "end", rotation=-side.rotation))
            else:
                texts.append(text_svg(name, x, y + 0.8 * side.font_size, side.font_size, "middle"))
        side = ax.yaxis
        for tick, name in ticks["y"]:
            y = box.top + (1.0 - float(side.fraction(tick))) * box.height
            path.append(f"M{box.left:.2f} {y:.2f}h{-side.tick_length:g}" if side.tick_length else "")
            texts.append(text_svg(name, box.left - side.tick_length - GAP, y, side.font_size, "end", is_centred=True))
        label_baseline = self.height - PAD - 0.22 * LABEL_SIZE
        if ax.equal_aspect:
            space_below = _tick_height(ax.xaxis, [name for _, name in ticks["x"]]) + label_space(ax.xaxis)
            label_baseline = bottom + space_below - 0.22 * LABEL_SIZE
        texts.append(text_svg(ax.xaxis.label, box.left + 0.5 * box.width, label_baseline, LABEL_SIZE, "middle"))
        baseline = box.left - _tick_width(ax.yaxis, box.height) - 0.5 * LABEL_SIZE
        texts.append(self._vertical_label(ax.yaxis.label, baseline, box))
        lines = "".join(path)
        ticks_svg = f'<path d="{lines}" style="stroke: {GREY}; stroke-width: 0.8"/>' if lines else ""
        return "\n".join([part for part in (ticks_svg, *texts) if part])

    def _vertical_label(self, label: str, x: float, box: Box) -> str:
        """Return the label of a vertical side, centred on the axes as far as the sheet allows."""
        longest = self.height - 2.0 * PAD
        size = min(LABEL_SIZE, LABEL_SIZE * longest / max(text_width(label, LABEL_SIZE), 1.0))
        half_length = 0.5 * text_width(label, size)
        centre = min(max(box.top + 0.5 * box.height, PAD + half_length), self.height - PAD - half_length)
        return text_svg(label, x, centre, size, "middle", rotation=-90.0)

    def _bar_svg(self, scale: ColourScale, side: Side, box: Box) -> str:
        left = box.left + box.width + BAR_GAP
        colours = scale.rgb(np.linspace(1.0, 0.0, BAR_PIXELS))
        pixels = np.concatenate([colours, np.full((BAR_PIXELS, 1), 255, np.uint8)], axis=-1)[:, None]
        parts = [image_svg(pixels, Box(left, box.top, BAR_WIDTH, box.height), is_smooth=True)]
        path = []
        for tick, name in side.ticks(box.height):
            y = box.top + (1.0 - float(side.fraction(tick))) * box.height
            x = left + BAR_WIDTH + side.tick_length
            path.append(f"M{left + BAR_WIDTH:.2f} {y:.2f}h{side.tick_length:g}")
            parts.append(text_svg(name, x + GAP, y, side.font_size, "start", is_centred=True))
        parts.append(f'<path d="{"".join(path)}" style="stroke: {GREY}; stroke-width: 0.8"/>' if path else "")
        x = left + BAR_WIDTH + _tick_width(side, box.height) + label_space(side) - 0.3 * LABEL_SIZE
        parts.append(self._vertical_label(side.label, x, box))
        return "\n".join(filter(None, parts))


def _tick_width(side: Side, length: float) -> float:
    """Return the width of the ticks of a vertical side and of their labels, in points."""
    names = [name for _, name in side.ticks(length)]
    return side.tick_length + GAP + max((text_width(name, side.font_size) for name in names), default=0.0)


def _tick_height(side: Side, names: list[str]) -> float:
    """Return the total height (points) of the ticks of a horizontal side and their labels."""
    if side.rotation:
        longest = max((text_width(name, side.font_size) for name in names), default=0.0)
        return side.tick_length + GAP + longest * float(np.sin(np.radians(side.rotation))) + side.font_size
    return side.tick_length + GAP + max((text_height(name, side.font_size) for name in names), default=0.0)


def label_space(side: Side) -> float:
    """Return the space for the label of a side, in points."""
    return text_height(side.label, LABEL_SIZE) + 3.0 if side.label else 0.0
