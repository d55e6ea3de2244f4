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
        self.yaxis.set_limits[0] = 0.0

    def to_points(self, x: Any, y: Any, box: Box) -> tuple[np.ndarray, np.ndarray]:
        """Return angles and radii as points on the sheet."""
        reach = 0.5 * box.width * self.yaxis.fraction(y)
        return box.left + 0.5 * box.width + reach * np.cos(x), box.top + 0.5 * box.height - reach * np.sin(x)

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
        margin = PAD + LABEL_GAP + text_width("360°", side.size)
        above, below = PAD + LABEL_GAP + 1.2 * side.size, PAD + LABEL_GAP + 1.2 * side.size + label_space(side)
        across = min(self.width - 2.0 * margin, self.height - above - below)
        return Box(0.5 * (self.width - across), above + 0.5 * (self.height - above - below - across), across, across)

    def _grid(self, ticks: dict[str, list[tuple[float, str]]], box: Box) -> str:
        look, most = self.axes.grid_style, self.axes.yaxis.limits()[1]
        style = f"fill: none; stroke: {look['colour']}; stroke-width: {look['width']}"
        x, y = box.left + 0.5 * box.width, box.top + 0.5 * box.height
        rings = "".join(
            f'<circle cx="{x:.2f}" cy="{y:.2f}" r="{0.5 * box.width * place / most:.2f}" style="{style}"/>'
            for place, _ in ticks["y"]
            if place > 0.0
        )
        ends = (self.axes.to_points(place, most, box) for place, _ in self._angles())
        spokes = "".join(f"M{x:.2f} {y:.2f}L{float(a):.2f} {float(b):.2f}" for a, b in ends)
        return f'{rings}<path d="{spokes}" style="{style}"/>'

    def _angles(self) -> list[tuple[float, str]]:
        """Return the ticks of the angle and their labels."""
        places = self.axes.xaxis.fixed_ticks[0] if self.axes.xaxis.fixed_ticks else []
        return [(place, f"{np.degrees(place):.0f}°") for place in places]

    def _edges(self, box: Box) -> str:
        x, y = box.left + 0.5 * box.width, box.top + 0.5 * box.height
        style = f"fill: none; stroke: {GREY}; stroke-width: 0.8"
        return f'<circle cx="{x:.2f}" cy="{y:.2f}" r="{0.5 * box.width:.2f}" style="{style}"/>'

    def _ticks(self, ticks: dict[str, list[tuple[float, str]]], box: Box) -> str:
        ax, words = self.axes, []
        middle = box.left + 0.5 * box.width
        for place, name in self._angles():
            side, up = float(np.cos(place)), float(np.sin(place))
            reach = 0.5 * box.width + LABEL_GAP
            x, y = middle + reach * side, box.top + 0.5 * box.height - (reach + 0.4 * ax.xaxis.size) * up
            anchor = "middle" if abs(side) < 0.1 else "start" if side > 0.0 else "end"
            words.append(text_svg(name, x, y, ax.xaxis.size, anchor, is_centred=True))
        for place, name in ticks["y"]:
            if place > 0.0:
                x, y = (float(point) for point in ax.to_points(ax.label_angle, place, box))
                words.append(text_svg(name, x, y, ax.yaxis.size, "start", is_centred=True))
        words.append(text_svg(ax.xaxis.label, middle, self.height - PAD - 0.22 * LABEL_SIZE, LABEL_SIZE, "middle"))
        return "\n".join(words)
