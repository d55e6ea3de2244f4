"""The picture of a mechanism: its bodies, joints and loads where it starts, each with its name."""

import math
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Arc, Circle, Polygon, Rectangle
from matplotlib.transforms import Affine2D

from ... import simulation
from ...machine import GROUND
from .style import BLUE, GREEN, GREY, INK, ORANGE, PALE, PURPLE, RED

_COLOURS = (BLUE, GREEN, ORANGE, PURPLE, "#56B4E9", "#8C6D31")
_HALO = {"facecolor": "white", "edgecolor": "none", "alpha": 0.75, "pad": 0.8}


def reach(sketch: simulation.Sketch) -> tuple[np.ndarray, np.ndarray]:
    """Return the lower left and the upper right corner (m) of what there is to draw."""
    places = [body.points for body in sketch.bodies] + [
        load.anchor[None] for load in sketch.loads if load.anchor is not None
    ]
    points = np.concatenate(places)
    return points.min(axis=0), points.max(axis=0)


def steepness(sketch: simulation.Sketch) -> float:
    """Return the height over the width of a picture of a mechanism, names included."""
    low, high = reach(sketch)
    size = float(max(high - low))
    return float((high[1] - low[1] + 0.5 * size) / (high[0] - low[0] + 0.6 * size))


def paint(ax: Axes, sketch: simulation.Sketch) -> None:
    """Draw a mechanism as it starts."""
    low, high = reach(sketch)
    size = float(max(*(high - low), 1e-9))
    labels = _Labels(ax, 0.055 * size)
    moving = [body for body in sketch.bodies if body.name != GROUND]
    for joint in sketch.joints:
        if joint.guide is not None:
            _guide(ax, joint, joint.guide, size)
    for number, body in enumerate(moving):
        colour = _COLOURS[number % len(_COLOURS)]
        _body(ax, body, colour)
        labels.put(body.name, body.points.mean(axis=0), colour, bold=True)
    for joint in sketch.joints:
        _joint(ax, joint, size)
        labels.put(f"{joint.name} (open)" if joint.open else joint.name, joint.place, RED if joint.open else GREY)
    for load in sketch.loads:
        labels.put(load.name, _load(ax, load, size), INK)
    ax.set_aspect("equal")
    room = 0.22 * size
    ax.set_xlim(low[0] - room, high[0] + 1.4 * room)
    ax.set_ylim(low[1] - room, high[1] + room)
    ax.xaxis.set_major_formatter(lambda value, _: f"{1e3 * value:g}")
    ax.yaxis.set_major_formatter(lambda value, _: f"{1e3 * value:g}")
    ax.set_xlabel("x [mm]")
    ax.set_ylabel("y [mm]")
    ax.spines[["top", "right"]].set_visible(False)
    ax.tick_params(length=2)


class _Labels:
    """Names beside what they name, moved apart where they would lie over each other."""

    def __init__(self, ax: Axes, step: float):
        self.ax, self.step = ax, step
        self.taken: list[tuple[float, float, int]] = []

    def put(self, text: str, place: np.ndarray, colour: str, *, bold: bool = False) -> None:
        """Write `text` beside `place` (m)."""
        x, y = float(place[0]) + 0.5 * self.step, float(place[1]) + 0.6 * self.step
        wide = 0.6 * self.step
        while any(abs(y - b) < 0.99 * self.step and abs(x - a) < wide * max(len(text), n) for a, b, n in self.taken):
            y += self.step
        self.taken.append((x, y, len(text)))
        weight = "bold" if bold else "normal"
        self.ax.text(x, y, text, color=colour, fontsize=8, weight=weight, bbox=_HALO, zorder=6, va="center")


def _body(ax: Axes, body: simulation.SketchedBody, colour: str) -> None:
    """Draw a body as the line, or the area, between its points."""
    points = body.points
    if len(points) > 2:
        middle = points.mean(axis=0)
        order = np.argsort(np.arctan2(points[:, 1] - middle[1], points[:, 0] - middle[0]))
        ax.add_patch(Polygon(points[order], closed=True, facecolor=colour, alpha=0.25, edgecolor=colour, lw=2.5))
    else:
        ax.plot(points[:, 0], points[:, 1], color=colour, lw=4.0, solid_capstyle="round", zorder=2)
    ax.plot(*body.center, marker="+", color=INK, ms=5, mew=0.8, zorder=5)


def _guide(ax: Axes, joint: simulation.SketchedJoint, direction: float, size: float) -> None:
    """Draw the line of a guide and the block that moves along it."""
    along = np.array([math.cos(direction), math.sin(direction)])
    ends = joint.place + 0.2 * size * np.array([[-1.0], [1.0]]) * along
    ax.plot(ends[:, 0], ends[:, 1], color=GREY, lw=0.8, ls=(0, (6, 3)), zorder=1)
    wide, high = 0.14 * size, 0.08 * size
    turn = Affine2D().rotate(direction).translate(*joint.place) + ax.transData
    block = Rectangle((-0.5 * wide, -0.5 * high), wide, high, facecolor=PALE, edgecolor=RED if joint.open else GREY)
    block.set_transform(turn)
    ax.add_patch(block)


def _joint(ax: Axes, joint: simulation.SketchedJoint, size: float) -> None:
    """Draw a joint: a ring, with a second one round it where it is open, hatched where it is on the ground."""
    if joint.guide is not None:
        return
    radius = 0.016 * size
    x, y = joint.place
    if joint.grounded:
        wide = 2.2 * radius
        ax.add_patch(
            Polygon(
                [(x, y), (x - wide, y - 1.6 * wide), (x + wide, y - 1.6 * wide)], facecolor=PALE, edgecolor=GREY, lw=0.8
            )
        )
        ax.plot([x - 1.5 * wide, x + 1.5 * wide], [y - 1.6 * wide] * 2, color=GREY, lw=1.2)
    ax.add_patch(Circle((x, y), radius, facecolor="white", edgecolor=INK, lw=1.2, zorder=4))
    if joint.open:
        ax.add_patch(Circle((x, y), 1.9 * radius, fill=False, edgecolor=RED, lw=1.4, zorder=4))
    if joint.driven:
        wide = 0.11 * size
        ax.add_patch(Arc((x, y), wide, wide, theta1=20.0, theta2=300.0, color=INK, lw=1.0, zorder=3))
        tip = np.array([x, y]) + 0.5 * wide * np.array([math.cos(math.radians(300)), math.sin(math.radians(300))])
        away = 0.02 * size * np.array([math.cos(math.radians(30)), math.sin(math.radians(30))])
        _arrow(ax, tip - 0.2 * away, tip + away, {"arrowstyle": "->", "color": INK, "lw": 1.0})


def _load(ax: Axes, load: simulation.SketchedLoad, size: float) -> np.ndarray:
    """Draw a load; return where its name belongs."""
    if load.anchor is not None:
        line = np.linspace(load.anchor, load.place, 15)
        across = load.place - load.anchor
        across = np.array([-across[1], across[0]]) / max(float(np.hypot(*across)), 1e-12)
        line[2:-2] += 0.02 * size * np.where(np.arange(11) % 2, 1.0, -1.0)[:, None] * across
        ax.plot(line[:, 0], line[:, 1], color=INK, lw=0.9, zorder=3)
        return 0.5 * (load.anchor + load.place)
    if load.direction is None:
        ax.plot(*load.place, marker="D", color=INK, ms=4, zorder=5)
        return np.asarray(load.place)
    tail = load.place - 0.2 * size * load.direction
    _arrow(ax, tail, load.place, {"arrowstyle": "-|>", "color": INK, "lw": 1.4})
    return np.asarray(tail)


def _arrow(ax: Axes, begin: np.ndarray, end: np.ndarray, look: dict[str, Any]) -> None:
    """Draw an arrow from one place (m) to another."""
    (a, b), (x, y) = begin, end
    ax.annotate("", xy=(x, y), xytext=(a, b), arrowprops=look, zorder=5)
