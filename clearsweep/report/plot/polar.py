"""Polar axes: the abscissa is an angle, counter-clockwise from the right, the ordinate a radius."""

from typing import Any

import numpy as np

from .axes import Axes
from .items import Box
from .letters import text_svg, text_width
from .sheet import GREY, LABEL_SIZE, PAD, Sheet, label_space

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
