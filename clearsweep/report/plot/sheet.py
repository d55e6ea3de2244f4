"""Axes on a sheet as SVG: position, edges, ticks and labels, colour bar; polar axes."""

from typing import Any, NamedTuple

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LogNorm, to_hex

from .axes import Axes
from .items import PAPER, Box, Side, text_height, text_svg, text_width
from .marks import item_svg, legend_size, legend_svg

# Axes on a sheet as SVG: position, edges, ticks and labels, colour bar.

GREY = "#6b7785"
PAD, GAP, LABEL_SIZE = (
    4.0,
    3.5,
    9.0,
)  # points: margin of the sheet, gap from a tick to its label, font size of an axis label
BAR_WIDTH, BAR_GAP = 10.0, 7.0  # points: width of a colour bar, distance from the axes
COLOUR_STOPS = 12  # colour stops of a colour bar


class ColourBar:
    """A colour bar; `ax.yaxis` has its ticks."""

    def __init__(self, coloured: ScalarMappable):
        """Take the coloured item."""
        self.coloured, self.solids = coloured, None
        side = Side("y")
        side.is_log = isinstance(coloured.norm, LogNorm)
        side.fixed_limits = [float(np.asarray(end)) for end in (coloured.norm.vmin, coloured.norm.vmax)]
        self.ax, self.outline = _BarAxes(side), _NoOutline()

    def set_label(self, name: str) -> None:
        """Set the label of the bar."""
        self.ax.yaxis.label = name


class _BarAxes(NamedTuple):
    yaxis: Side


class _NoOutline:
    @staticmethod
    def set_visible(shown: bool) -> None:
        """Do nothing: the bar has no outline."""


class Sheet:
    """A sheet with one pair of axes."""

    def __init__(self, size: tuple[float, float]):
        """Take the size in inches."""
        self.width, self.height = (72.0 * side for side in size)
        self.axes: Axes = Axes(self)
        self.bar: ColourBar | None = None

    def get_size_inches(self) -> np.ndarray:
        """Return width and height in inches."""
        return np.array([self.width, self.height]) / 72.0

    def colorbar(self, coloured: ScalarMappable, **_: Any) -> ColourBar:
        """Return a colour bar to the right of the axes."""
        self.bar = bar = ColourBar(coloured)
        return bar

    def box(self) -> Box:
        """Return the position of the axes within labels, ticks, legend and bar."""
        ax = self.axes
        space_above, right = legend_size(ax)
        left = PAD + _tick_width(ax.yaxis, self.height - 50.0) + label_space(ax.yaxis)
        right += PAD + (
            BAR_GAP + BAR_WIDTH + _tick_width(self.bar.ax.yaxis, self.height - 50.0) + label_space(self.bar.ax.yaxis)
            if self.bar
            else 0.0
        )
        names = ax.xaxis.ticks(self.width - left - right)
        space_below = PAD + _tick_height(ax.xaxis, [name for _, name in names]) + label_space(ax.xaxis)
        top = PAD + max(space_above, 0.5 * ax.yaxis.font_size)
        if names and not self.bar and not ax.xaxis.label_style.get("rotation"):
            tick, name = names[-1]
            overhang = 0.5 * text_width(name, ax.xaxis.font_size) - (1.0 - float(ax.xaxis.fraction(tick))) * (
                self.width - left - right
            )
            right = max(right, PAD + overhang)
        box = Box(left, top, max(self.width - left - right, 20.0), max(self.height - top - space_below, 20.0))
        if not ax.equal_aspect:
            return box
        x_range, y_range = (abs(np.subtract(*side.limits())) for side in (ax.xaxis, ax.yaxis))
        scale = min(box.width / x_range, box.height / y_range)
        width, height = scale * x_range, scale * y_range
        return Box(box.left + 0.5 * (box.width - width), box.top + 0.5 * (box.height - height), width, height)

    def svg(self, id_prefix: str) -> tuple[str, Box]:
        """Return the sheet as an SVG element, with ids prefixed by `id_prefix`, and the position of the axes."""
        ax, box = self.axes, self.box()
        clip_id = f"{id_prefix}-clip"
        parts = [
            f'<svg width="{self.width:g}pt" height="{self.height:g}pt" viewBox="0 0 {self.width:g} {self.height:g}" '
            'xmlns="http://www.w3.org/2000/svg">',
            f'<clipPath id="{clip_id}"><rect x="{box.left:.2f}" y="{box.top:.2f}" width="{box.width:.2f}" '
            f'height="{box.height:.2f}"/></clipPath>',
            f'<rect width="{self.width:g}" height="{self.height:g}" style="fill: {PAPER}"/>',
        ]
        ticks = {"x": ax.xaxis.ticks(box.width), "y": ax.yaxis.ticks(box.height)}
        if ax.face_colour != PAPER:
            parts.append(
                f'<rect x="{box.left:.2f}" y="{box.top:.2f}" width="{box.width:.2f}" height="{box.height:.2f}" '
                f'style="fill: {ax.face_colour}"/>'
            )
        if ax.grid_style:
            parts.append(self._grid_svg(ticks, box))
        items = sorted(ax.items, key=lambda item: item.order)
        parts.append(f'<g clip-path="url(#{clip_id})">')
        parts += [item_svg(item, ax, box) for item in items if item.kind != "text"]
        parts.append("</g>")
        parts += [item_svg(item, ax, box) for item in items if item.kind == "text"]
        parts += [self._edges_svg(box), self._ticks_svg(ticks, box)]
        parts += legend_svg(ax, box)
        if self.bar:
            parts.append(self._bar_svg(self.bar, box, id_prefix))
        return "\n".join([*filter(None, parts), "</svg>\n"]), box

    def _grid_svg(self, ticks: dict[str, list[tuple[float, str]]], box: Box) -> str:
        ax, path = self.axes, []
        for tick, _ in ticks["x"]:
            x = box.left + float(ax.xaxis.fraction(tick)) * box.width
            path.append(f"M{x:.2f} {box.top:.2f}v{box.height:.2f}")
        for tick, _ in ticks["y"]:
            y = box.top + (1.0 - float(ax.yaxis.fraction(tick))) * box.height
            path.append(f"M{box.left:.2f} {y:.2f}h{box.width:.2f}")
        grid_style = ax.grid_style
        style = (
            f"fill: none; stroke: {grid_style['colour']}; stroke-width: {grid_style['width']}; "
            f"stroke-opacity: {grid_style['alpha']:g}"
        )
        return f'<path d="{"".join(path)}" style="{style}"/>' if path else ""

    def _edges_svg(self, box: Box) -> str:
        left, top, width, height = box
        lines = {
            "left": f"M{left:.2f} {top:.2f}v{height:.2f}",
            "right": f"M{left + width:.2f} {top:.2f}v{height:.2f}",
            "top": f"M{left:.2f} {top:.2f}h{width:.2f}",
            "bottom": f"M{left:.2f} {top + height:.2f}h{width:.2f}",
        }
        path = "".join(line for name, line in lines.items() if self.axes.spines.get(name))
        style = f"fill: none; stroke: {GREY}; stroke-width: 0.8; stroke-linecap: square"
        return f'<path d="{path}" style="{style}"/>' if path else ""

    def _ticks_svg(self, ticks: dict[str, list[tuple[float, str]]], box: Box) -> str:
        ax, path, texts = self.axes, [], []
        side, bottom = ax.xaxis, box.top + box.height
        rotation = side.label_style.get("rotation")
        for tick, name in ticks["x"]:
            x, y = box.left + float(side.fraction(tick)) * box.width, bottom + side.tick_length + GAP
            path.append(f"M{x:.2f} {bottom:.2f}v{side.tick_length:g}" if side.tick_length else "")
            if rotation:
                texts.append(
                    text_svg(name, x, y + 0.5 * side.font_size, side.font_size, "end", rotation=-float(rotation))
                )
            else:
                texts.append(text_svg(name, x, y + 0.8 * side.font_size, side.font_size, "middle"))
        side = ax.yaxis
        for tick, name in ticks["y"]:
            y = box.top + (1.0 - float(side.fraction(tick))) * box.height
            path.append(f"M{box.left:.2f} {y:.2f}h{-side.tick_length:g}" if side.tick_length else "")
            texts.append(text_svg(name, box.left - side.tick_length - GAP, y, side.font_size, "end", is_centred=True))
        label_baseline = self.height - PAD - 0.22 * LABEL_SIZE
        if ax.equal_aspect:
            label_baseline = (
                bottom
                + _tick_height(ax.xaxis, [name for _, name in ticks["x"]])
                + label_space(ax.xaxis)
                - 0.22 * LABEL_SIZE
            )
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

    def _bar_svg(self, bar: ColourBar, box: Box, id_prefix: str) -> str:
        left, side = box.left + box.width + BAR_GAP, bar.ax.yaxis
        stops = "".join(
            f'<stop offset="{share:.3f}" stop-color="{to_hex(bar.coloured.cmap(share))}"/>'
            for share in np.linspace(0.0, 1.0, COLOUR_STOPS)
        )
        parts = [
            f'<linearGradient id="{id_prefix}-bar" x1="0" y1="1" x2="0" y2="0">{stops}</linearGradient>',
            f'<rect x="{left:.2f}" y="{box.top:.2f}" width="{BAR_WIDTH:g}" height="{box.height:.2f}" '
            f'fill="url(#{id_prefix}-bar)"/>',
        ]
        path = []
        for tick, name in side.ticks(box.height):
            y = box.top + (1.0 - float(side.fraction(tick))) * box.height
            path.append(f"M{left + BAR_WIDTH:.2f} {y:.2f}h{side.tick_length:g}")
            parts.append(
                text_svg(name, left + BAR_WIDTH + side.tick_length + GAP, y, side.font_size, "start", is_centred=True)
            )
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
    if rotation := side.label_style.get("rotation"):
        longest = max((text_width(name, side.font_size) for name in names), default=0.0)
        return side.tick_length + GAP + longest * float(np.sin(np.radians(rotation))) + side.font_size
    return side.tick_length + GAP + max((text_height(name, side.font_size) for name in names), default=0.0)


def label_space(side: Side) -> float:
    """Return the space for the label of a side, in points."""
    return text_height(side.label, LABEL_SIZE) + 3.0 if side.label else 0.0


# Polar axes: the abscissa is an angle, counter-clockwise from the right, the ordinate a radius.

LABEL_GAP = 5.0  # points from the rim to the labels of angles


class PolarAxes(Axes):
    """Axes whose abscissa is an angle in radians."""

    def __init__(self, figure: Any):
        """Take the sheet of these axes."""
        super().__init__(figure)
        self.equal_aspect, self.label_angle = True, 0.0
        self.yaxis.fixed_limits[0] = 0.0

    def to_points(self, x: Any, y: Any, box: Box) -> tuple[np.ndarray, np.ndarray]:
        """Return angles and radii as points on the sheet."""
        radius = 0.5 * box.width * self.yaxis.fraction(y)
        return box.left + 0.5 * box.width + radius * np.cos(x), box.top + 0.5 * box.height - radius * np.sin(x)

    def set_rlabel_position(self, degrees: float) -> None:
        """Set the angle of the labels of radii."""
        self.label_angle = float(np.radians(degrees))


class PolarSheet(Sheet):
    """A sheet with one pair of polar axes."""

    def __init__(self, size: tuple[float, float]):
        """Take the size in inches."""
        super().__init__(size)
        self.axes = PolarAxes(self)

    def box(self) -> Box:
        """Return the square around the disc."""
        side = self.axes.xaxis
        margin = PAD + LABEL_GAP + text_width("360°", side.font_size)
        space_above, space_below = (
            PAD + LABEL_GAP + 1.2 * side.font_size,
            PAD + LABEL_GAP + 1.2 * side.font_size + label_space(side),
        )
        diameter = min(self.width - 2.0 * margin, self.height - space_above - space_below)
        return Box(
            0.5 * (self.width - diameter),
            space_above + 0.5 * (self.height - space_above - space_below - diameter),
            diameter,
            diameter,
        )

    def _grid_svg(self, ticks: dict[str, list[tuple[float, str]]], box: Box) -> str:
        grid_style, max_radius = self.axes.grid_style, self.axes.yaxis.limits()[1]
        style = f"fill: none; stroke: {grid_style['colour']}; stroke-width: {grid_style['width']}"
        x, y = box.left + 0.5 * box.width, box.top + 0.5 * box.height
        rings = "".join(
            f'<circle cx="{x:.2f}" cy="{y:.2f}" r="{0.5 * box.width * tick / max_radius:.2f}" style="{style}"/>'
            for tick, _ in ticks["y"]
            if tick > 0.0
        )
        spoke_ends = (self.axes.to_points(tick, max_radius, box) for tick, _ in self._angle_ticks())
        spokes = "".join(f"M{x:.2f} {y:.2f}L{float(a):.2f} {float(b):.2f}" for a, b in spoke_ends)
        return f'{rings}<path d="{spokes}" style="{style}"/>'

    def _angle_ticks(self) -> list[tuple[float, str]]:
        """Return the ticks of the angle and their labels."""
        ticks = self.axes.xaxis.fixed_ticks[0] if self.axes.xaxis.fixed_ticks else []
        return [(tick, f"{np.degrees(tick):.0f}°") for tick in ticks]

    def _edges_svg(self, box: Box) -> str:
        x, y = box.left + 0.5 * box.width, box.top + 0.5 * box.height
        style = f"fill: none; stroke: {GREY}; stroke-width: 0.8"
        return f'<circle cx="{x:.2f}" cy="{y:.2f}" r="{0.5 * box.width:.2f}" style="{style}"/>'

    def _ticks_svg(self, ticks: dict[str, list[tuple[float, str]]], box: Box) -> str:
        ax, texts = self.axes, []
        centre_x = box.left + 0.5 * box.width
        for tick, name in self._angle_ticks():
            cosine, sine = float(np.cos(tick)), float(np.sin(tick))
            radius = 0.5 * box.width + LABEL_GAP
            x, y = centre_x + radius * cosine, box.top + 0.5 * box.height - (radius + 0.4 * ax.xaxis.font_size) * sine
            anchor = "middle" if abs(cosine) < 0.1 else "start" if cosine > 0.0 else "end"
            texts.append(text_svg(name, x, y, ax.xaxis.font_size, anchor, is_centred=True))
        for tick, name in ticks["y"]:
            if tick > 0.0:
                x, y = (float(point) for point in ax.to_points(ax.label_angle, tick, box))
                texts.append(text_svg(name, x, y, ax.yaxis.font_size, "start", is_centred=True))
        texts.append(text_svg(ax.xaxis.label, centre_x, self.height - PAD - 0.22 * LABEL_SIZE, LABEL_SIZE, "middle"))
        return "\n".join(texts)
