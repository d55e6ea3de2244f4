"""Axes on a sheet as SVG: position, edges, ticks and labels, colour bar; polar axes."""

import numpy as np

from .axes import Axes
from .items import PAPER, Box, ColourScale, Side, text_height, text_svg, text_width
from .marks import AXES_GAP, image_svg, item_svg, legend_size, legend_svg, line_svg

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
        width_of_texts_beside = max(
            (AXES_GAP + style.offset + text_width(style.text, style.size) for style in texts), default=0.0
        )
        right = PAD + max(right, width_of_texts_beside)
        if ax.colour_bar:
            right += (
                BAR_GAP + BAR_WIDTH + _tick_width(ax.colour_bar[1], self.height - 50.0) + label_space(ax.colour_bar[1])
            )
        names = ax.xaxis.ticks(self.width - left - right)
        space_below = PAD + _tick_height(ax.xaxis, [name for _, name in names]) + label_space(ax.xaxis)
        top = PAD + max(space_above, 0.5 * ax.yaxis.font_size)
        if names and not ax.colour_bar and not ax.xaxis.rotation:
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

    def svg(self, id_prefix: str, box: Box) -> str:
        """Return the sheet, with its axes in `box`, as an SVG element whose ids are prefixed by `id_prefix`."""
        ax = self.axes
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

    def _bar_svg(self, scale: ColourScale, side: Side, box: Box) -> str:
        left = box.left + box.width + BAR_GAP
        colours = scale.rgb(np.linspace(1.0, 0.0, BAR_PIXELS))
        pixels = np.concatenate([colours, np.full((BAR_PIXELS, 1), 255, np.uint8)], axis=-1)[:, None]
        parts = [image_svg(pixels, Box(left, box.top, BAR_WIDTH, box.height), is_smooth=True)]
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
    if side.rotation:
        longest = max((text_width(name, side.font_size) for name in names), default=0.0)
        return side.tick_length + GAP + longest * float(np.sin(np.radians(side.rotation))) + side.font_size
    return side.tick_length + GAP + max((text_height(name, side.font_size) for name in names), default=0.0)


def label_space(side: Side) -> float:
    """Return the space for the label of a side, in points."""
    return text_height(side.label, LABEL_SIZE) + 3.0 if side.label else 0.0


# Polar axes: the abscissa is an angle, counter-clockwise from the right, the ordinate a radius.

LABEL_GAP = 5.0  # points from the rim to the labels of angles
RADIUS_LABEL_ANGLE = float(np.radians(22.5))  # of the labels of radii


class PolarAxes(Axes):
    """Axes whose abscissa is an angle in radians."""

    def __init__(self, sheet_size: tuple[float, float]):
        """Take the size of their sheet in inches."""
        super().__init__(sheet_size)
        self.equal_aspect = True
        self.yaxis.fixed_limits[0] = 0.0

    def to_points(self, x: np.ndarray, y: np.ndarray, box: Box) -> tuple[np.ndarray, np.ndarray]:
        """Return angles and radii as points on the sheet."""
        radius = 0.5 * box.width * self.yaxis.fraction(y)
        return box.left + 0.5 * box.width + radius * np.cos(x), box.top + 0.5 * box.height - radius * np.sin(x)


class PolarSheet(Sheet):
    """A sheet with one pair of polar axes."""

    def __init__(self, size: tuple[float, float]):
        """Take the size in inches."""
        super().__init__(size)
        self.axes = PolarAxes(size)

    def box(self) -> Box:
        """Return the square around the disc."""
        side = self.axes.xaxis
        margin = PAD + LABEL_GAP + text_width("360°", side.font_size)
        space_above = PAD + LABEL_GAP + 1.2 * side.font_size
        space_below = PAD + LABEL_GAP + 1.2 * side.font_size + label_space(side)
        diameter = min(self.width - 2.0 * margin, self.height - space_above - space_below)
        return Box(
            0.5 * (self.width - diameter),
            space_above + 0.5 * (self.height - space_above - space_below - diameter),
            diameter,
            diameter,
        )

    def _grid_svg(self, ticks: dict[str, list[tuple[float, str]]], box: Box) -> str:
        stroke, max_radius = self.axes.grid_stroke, self.axes.yaxis.limits()[1]
        assert stroke is not None
        style = f"fill: none; stroke: {stroke.colour}; stroke-width: {stroke.width:g}"
        x, y = box.left + 0.5 * box.width, box.top + 0.5 * box.height
        rings = "".join(
            f'<circle cx="{x:.2f}" cy="{y:.2f}" r="{0.5 * box.width * tick / max_radius:.2f}" style="{style}"/>'
            for tick, _ in ticks["y"]
            if tick > 0.0
        )
        spoke_ends = (self.axes.to_points(tick, max_radius, box) for tick, _ in self._angle_ticks())
        spokes = "".join(f"M{x:.2f} {y:.2f}L{float(a):.2f} {float(b):.2f}" for a, b in spoke_ends)
        return rings + line_svg(spokes, stroke)

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
                x, y = (float(point) for point in ax.to_points(RADIUS_LABEL_ANGLE, tick, box))
                texts.append(text_svg(name, x, y, ax.yaxis.font_size, "start", is_centred=True))
        texts.append(text_svg(ax.xaxis.label, centre_x, self.height - PAD - 0.22 * LABEL_SIZE, LABEL_SIZE, "middle"))
        return "\n".join(texts)


def make_sheet(size: tuple[float, float], *, is_polar: bool) -> Sheet:
    """Return a sheet with plane or polar axes; size : inches."""
    return PolarSheet(size) if is_polar else Sheet(size)
