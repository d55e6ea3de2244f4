"""Polar axes: the abscissa is an angle, counter-clockwise from the right, the ordinate a radius."""

from typing import Any

import numpy as np

from .axes import Axes
from .items import Box
from .letters import text, width
from .sheet import GREY, LABEL, PAD, Sheet, named

APART = 5.0  # points from the rim to the labels of angles


class PolarAxes(Axes):
    """Axes whose abscissa is an angle in radians."""

    def __init__(self, figure: Any):
        """Take the sheet of these axes."""
        super().__init__(figure)
        self.equal, self.named_at = True, 0.0
        self.yaxis.given[0] = 0.0

    def points(self, x: Any, y: Any, box: Box) -> tuple[np.ndarray, np.ndarray]:
        """Return angles and radii as points on the sheet."""
        reach = 0.5 * box.wide * self.yaxis.share(y)
        return box.left + 0.5 * box.wide + reach * np.cos(x), box.top + 0.5 * box.high - reach * np.sin(x)

    def set_rlabel_position(self, degrees: float) -> None:
        """Set the angle of the labels of radii."""
        self.named_at = float(np.radians(degrees))


class PolarSheet(Sheet):
    """A sheet with one pair of polar axes."""

    def __init__(self, size: tuple[float, float]):
        """Take the size in inches."""
        super().__init__(size)
        self.axes = PolarAxes(self)

    def box(self) -> Box:
        """Return the square around the disc."""
        side = self.axes.xaxis
        margin = PAD + APART + width("360°", side.size)
        above, below = PAD + APART + 1.2 * side.size, PAD + APART + 1.2 * side.size + named(side)
        across = min(self.wide - 2.0 * margin, self.high - above - below)
        return Box(0.5 * (self.wide - across), above + 0.5 * (self.high - above - below - across), across, across)

    def _grid(self, ticks: dict[str, list[tuple[float, str]]], box: Box) -> str:
        look, most = self.axes.ruled, self.axes.yaxis.limits()[1]
        style = f"fill: none; stroke: {look['colour']}; stroke-width: {look['width']}"
        x, y = box.left + 0.5 * box.wide, box.top + 0.5 * box.high
        rings = "".join(
            f'<circle cx="{x:.2f}" cy="{y:.2f}" r="{0.5 * box.wide * place / most:.2f}" style="{style}"/>'
            for place, _ in ticks["y"]
            if place > 0.0
        )
        ends = (self.axes.points(place, most, box) for place, _ in self._angles())
        spokes = "".join(f"M{x:.2f} {y:.2f}L{float(a):.2f} {float(b):.2f}" for a, b in ends)
        return f'{rings}<path d="{spokes}" style="{style}"/>'

    def _angles(self) -> list[tuple[float, str]]:
        """Return the ticks of the angle and their labels."""
        places = self.axes.xaxis.fixed[0] if self.axes.xaxis.fixed else []
        return [(place, f"{np.degrees(place):.0f}°") for place in places]

    def _edges(self, box: Box) -> str:
        x, y = box.left + 0.5 * box.wide, box.top + 0.5 * box.high
        style = f"fill: none; stroke: {GREY}; stroke-width: 0.8"
        return f'<circle cx="{x:.2f}" cy="{y:.2f}" r="{0.5 * box.wide:.2f}" style="{style}"/>'

    def _ticks(self, ticks: dict[str, list[tuple[float, str]]], box: Box) -> str:
        ax, words = self.axes, []
        middle = box.left + 0.5 * box.wide
        for place, name in self._angles():
            side, up = float(np.cos(place)), float(np.sin(place))
            reach = 0.5 * box.wide + APART
            x, y = middle + reach * side, box.top + 0.5 * box.high - (reach + 0.4 * ax.xaxis.size) * up
            anchor = "middle" if abs(side) < 0.1 else "start" if side > 0.0 else "end"
            words.append(text(name, x, y, ax.xaxis.size, anchor, middle=True))
        for place, name in ticks["y"]:
            if place > 0.0:
                x, y = (float(point) for point in ax.points(ax.named_at, place, box))
                words.append(text(name, x, y, ax.yaxis.size, "start", middle=True))
        words.append(text(ax.xaxis.label, middle, self.high - PAD - 0.22 * LABEL, LABEL, "middle"))
        return "\n".join(words)
