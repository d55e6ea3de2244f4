"""Drawing of a machine at its start: bodies, joints and loads, each with its name."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from ... import simulation
from ...contracts.machine import GROUND
from ...language import wording
from ..plot import Axes
from . import (
    BLUE,
    GREEN,
    GREY,
    INK,
    ORANGE,
    PALE,
    PURPLE,
    RED,
)

# Drawing of a mechanism: its bodies, joints and loads at the start, each with its name.

BODY_COLOURS = (BLUE, GREEN, ORANGE, PURPLE, "#56B4E9", "#8C6D31")
_ARROW_ANGLES = np.arange(0.4, 5.2, 0.1)
_DRIVE_ARROW = np.stack([np.cos(_ARROW_ANGLES), np.sin(_ARROW_ANGLES)], -1)  # the arrow of a drive
_BLOCK_CORNERS = np.array(((-1, -1), (1, -1), (1, 1), (-1, 1), (-1, -1)))  # corners of a block
_FONT_SIZE, _LETTER_WIDTH, _LINE_HEIGHT = 8, 4.9, 12.0  # points: of names, their mean letter, their line
_LABEL_STYLE: dict[str, Any] = {"ha": "center", "va": "center", "size": _FONT_SIZE, "has_halo": True}
_MARGINS = np.array([0.7, 0.8])  # inches of a figure's width and height for ticks, their labels and the title
_LABEL_GAP = 0.02  # of the mechanism's size, from a name to its place
_DIRECTIONS = np.radians(np.arange(45.0, 405.0, 30.0))
_DIRECTION_OFFSETS = np.stack([np.cos(_DIRECTIONS), np.sin(_DIRECTIONS)], -1)
_DIRECTION_OFFSETS /= abs(_DIRECTION_OFFSETS).max(-1, keepdims=True)
# Candidate positions of a name: around its point, in each of these directions, near or far; distance has a cost.
_LABEL_OFFSETS = np.concatenate([far * _DIRECTION_OFFSETS for far in (1.0, 1.7, 2.6, 4.0)])
_DISTANCE_COST = np.repeat([0.0, 2.0, 5.0, 9.0], len(_DIRECTIONS))


def drawing_extent(sketch: simulation.Sketch) -> tuple[np.ndarray, np.ndarray]:
    """Return the lower left and the upper right corner (m) of the drawing."""
    point_arrays = [
        *(body.points for body in sketch.bodies),
        *(rim for body in sketch.bodies for rim in body.rims),
        *(load.anchor[None] for load in sketch.loads if load.anchor is not None),
        *(joint.slot for joint in sketch.joints if joint.slot is not None),
    ]
    points = np.concatenate(point_arrays)
    return points.min(axis=0), points.max(axis=0)


def picture_height(sketch: simulation.Sketch, width: float) -> float:
    """Return the height (inches) of a picture of a mechanism `width` (inches) wide, with names, ticks and title."""
    (left, right), (bottom, top) = _limits(sketch)
    return _MARGINS[1] + (width - _MARGINS[0]) * (top - bottom) / (right - left)


def _limits(sketch: simulation.Sketch) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return the limits (m) of both axes: the mechanism with a margin for names."""
    low, high = drawing_extent(sketch)
    margin = 0.22 * _size(sketch)
    return (float(low[0] - margin), float(high[0] + 1.4 * margin)), (float(low[1] - margin), float(high[1] + margin))


def _size(sketch: simulation.Sketch) -> float:
    """Return the longer side (m) of the drawing."""
    low, high = drawing_extent(sketch)
    return max(float(max(high - low)), 1e-9)


def draw_mechanism(ax: Axes, sketch: simulation.Sketch) -> None:
    """Draw a mechanism at its start."""
    size = _size(sketch)
    labels = _Labels(size)
    for joint in sketch.joints:
        if joint.guide is not None:
            labels.avoid(_draw_guide(ax, joint, joint.guide, size))
        if joint.slot is not None:
            ax.fill(*joint.slot.T, facecolor=PALE, edgecolor=RED, linewidth=1.2)
            labels.avoid(joint.slot)
    moving_bodies = [body for body in sketch.bodies if body.name != GROUND]
    for number, body in enumerate(moving_bodies):
        colour = BODY_COLOURS[number % len(BODY_COLOURS)]
        labels.avoid(_draw_body(ax, body, colour))
        for rim in body.rims:
            ax.plot(*rim.T, color=colour, linewidth=1.4, zorder=2)
            labels.avoid(rim)
        labels.add(body.name, body.points.mean(axis=0), colour, weight="bold")
    for joint in sketch.joints:
        labels.avoid(_draw_joint(ax, joint, size))
    for position, is_open, names in _joints_by_position(sketch.joints):
        labels.add(f"{names} (clearance)" if is_open else names, position, RED if is_open else GREY)
    for load in sketch.loads:
        labels.add(load.name, _draw_load(ax, load, size), INK)
    ax.equal_aspect = True
    x_limits, y_limits = _limits(sketch)
    ax.set_xlim(*x_limits)
    ax.set_ylim(*y_limits)
    labels.write(ax)
    factor, unit, _ = wording.scale("m", 0.01)  # mm, or in
    ax.xaxis.formatter = ax.yaxis.formatter = lambda value: f"{value / factor:.6g}"
    ax.set_labels(f"x [{unit}]", f"y [{unit}]")
    ax.hide_edges("top", "right")
    ax.set_tick_length(2.0)


def _joints_by_position(joints: Sequence[simulation.SketchedJoint]) -> list[tuple[np.ndarray, bool, str]]:
    """Return position (m), whether open, and names of joints, grouped by equal position and openness."""
    groups: dict[tuple, list[simulation.SketchedJoint]] = {}
    for joint in joints:
        groups.setdefault((*np.round(joint.position, 9), joint.has_clearance), []).append(joint)
    return [
        (group[0].position, group[0].has_clearance, ", ".join(joint.name for joint in group))
        for group in groups.values()
    ]


class _Labels:
    """Names next to their objects, each where it covers least."""

    def __init__(self, size: float):
        self.size = size  # m, of the mechanism
        self.requests: list[tuple[str, np.ndarray, str, str]] = []
        self.obstacles: list[np.ndarray] = []  # (n, 2) m, points that names should not cover

    def avoid(self, points: np.ndarray) -> None:
        """Keep names away from `points`, (n, 2) m."""
        self.obstacles.append(points)

    def add(self, text: str, position: np.ndarray, colour: str, weight: str = "normal") -> None:
        """Request `text` next to `position` (m)."""
        self.requests.append((text, np.asarray(position, dtype=float), colour, weight))

    def write(self, ax: Axes) -> None:
        """Write all names; the limits of the axes must not change afterwards."""
        obstacles, occupied = np.concatenate(self.obstacles), np.empty((0, 4))
        (left, right), (bottom, top) = ax.xaxis.limits(), ax.yaxis.limits()
        width, height = 72.0 * (np.array(ax.sheet_size) - _MARGINS)  # typographic points; the axes fill their figure
        metres_per_point = max((right - left) / width, (top - bottom) / height)
        for text, position, colour, weight in self.requests:
            half_size = metres_per_point * np.array([0.5 * _LETTER_WIDTH * len(text) + 2.0, 0.5 * _LINE_HEIGHT])
            centres = position + _LABEL_OFFSETS * (half_size + _LABEL_GAP * self.size)
            low, high = centres - half_size, centres + half_size
            covered_counts = ((obstacles > low[:, None]) & (obstacles < high[:, None])).all(-1).sum(-1)
            overlap_counts = ((low[:, None] < occupied[:, 2:]) & (high[:, None] > occupied[:, :2])).all(-1).sum(-1)
            is_outside = (low < (left, bottom)).any(-1) | (high > (right, top)).any(-1)
            best_index = np.argmin(covered_counts + 100.0 * overlap_counts + 100.0 * is_outside + _DISTANCE_COST)
            occupied = np.vstack([occupied, np.append(low[best_index], high[best_index])])
            if _DISTANCE_COST[best_index] > 1.0:
                ax.plot(*np.stack([position, centres[best_index]]).T, color=colour, linewidth=0.5, zorder=5)
            x, y = centres[best_index]
            ax.text(x, y, text, colour=colour, weight=weight, **_LABEL_STYLE)


def _interpolate(points: np.ndarray) -> np.ndarray:
    """Return `points` (n, 2) with points interpolated between them."""
    fraction = np.linspace(0.0, 1.0, 25)[:, None, None]
    return ((1.0 - fraction) * points[:-1] + fraction * points[1:]).reshape(-1, 2) if len(points) > 1 else points


def _draw_body(ax: Axes, body: simulation.SketchedBody, colour: str) -> np.ndarray:
    """Draw a body as the line, or the area, between its points; return points (m) of it."""
    points = body.points
    if len(points) > 2:
        centre = points.mean(axis=0)
        order = np.argsort(np.arctan2(points[:, 1] - centre[1], points[:, 0] - centre[0]))
        ax.fill(*points[order].T, facecolor=colour, alpha=0.25, edgecolor=colour, linewidth=2.5)
    else:
        ax.plot(points[:, 0], points[:, 1], color=colour, linewidth=4.0, capstyle="round", zorder=2)
    if body.elastic_ends is not None:
        ax.plot(*_zigzag(*body.elastic_ends).T, color="#ffffff", linewidth=1.2, zorder=3)
    ax.plot(*body.center, marker="+", linestyle="", color=INK, markersize=5, markeredgewidth=0.8, zorder=5)
    return np.vstack([_interpolate(points), body.center])


def _zigzag(start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Return the corners (m) of a zigzag between two places, straight at its ends."""
    vector = end - start
    perpendicular = 0.02 * np.array([-vector[1], vector[0]])
    fractions = np.concatenate([[0.0, 0.15], np.linspace(0.175, 0.825, 14), [0.85, 1.0]])
    signs = np.concatenate([[0.0, 0.0], np.resize([1.0, -1.0], 14), [0.0, 0.0]])
    corners: np.ndarray = start + fractions[:, None] * vector + signs[:, None] * perpendicular
    return corners


def _draw_guide(ax: Axes, joint: simulation.SketchedJoint, direction: float, size: float) -> np.ndarray:
    """Draw the line of a guide and the block that moves along it; return points (m) of the block."""
    unit_vector = np.array([math.cos(direction), math.sin(direction)])
    ends = joint.position + 0.2 * size * np.array([[-1.0], [1.0]]) * unit_vector
    ax.plot(ends[:, 0], ends[:, 1], color=GREY, linewidth=0.8, linestyle="6 3", zorder=1)
    perpendicular = np.array([-unit_vector[1], unit_vector[0]])
    sides = 0.14 * size * unit_vector, 0.08 * size * perpendicular
    outline = joint.position + 0.5 * (_BLOCK_CORNERS[:, :1] * sides[0] + _BLOCK_CORNERS[:, 1:] * sides[1])
    ax.fill(*outline[:-1].T, facecolor=PALE, edgecolor=RED if joint.has_clearance else GREY, linewidth=1.0)
    return _interpolate(outline)


def _draw_joint(ax: Axes, joint: simulation.SketchedJoint, size: float) -> np.ndarray:
    """Draw a joint: a ring, a second ring if it is open, hatched if it is on the ground.

    Return points (n, 2) m of it.
    """
    if joint.guide is not None:
        return joint.position[None]
    radius = 0.016 * size
    x, y = joint.position
    point_arrays = [joint.position[None]]
    if joint.grounded:
        width = 2.2 * radius
        base = y - 1.6 * width
        ax.fill([x, x - width, x + width], [y, base, base], facecolor=PALE, edgecolor=GREY, linewidth=0.8)
        ax.plot([x - 1.5 * width, x + 1.5 * width], [base, base], color=GREY, linewidth=1.2)
        point_arrays.append(_interpolate(np.array([(x - width, base), (x, y), (x + width, base)])))
    ax.circle((x, y), radius, facecolor="#ffffff", edgecolor=INK, linewidth=1.2, zorder=4)
    if joint.has_clearance:
        ax.circle((x, y), 1.9 * radius, edgecolor=RED, linewidth=1.4, zorder=4)
    if joint.driven:
        width = 0.11 * size
        arrow = joint.position + 0.5 * width * _DRIVE_ARROW
        ax.plot(*arrow.T, color=INK, linewidth=1.0, zorder=3)
        _draw_arrow_head(ax, arrow[-1], arrow[-1] - arrow[-2], 0.022 * size)
        point_arrays.append(arrow)
    return np.concatenate(point_arrays)


def _draw_load(ax: Axes, load: simulation.SketchedLoad, size: float) -> np.ndarray:
    """Draw a load; return the position (m) of its name."""
    if load.anchor is not None:
        line = np.linspace(load.anchor, load.position, 15)
        perpendicular = load.position - load.anchor
        perpendicular = np.array([-perpendicular[1], perpendicular[0]]) / max(float(np.hypot(*perpendicular)), 1e-12)
        line[2:-2] += 0.02 * size * np.where(np.arange(11) % 2, 1.0, -1.0)[:, None] * perpendicular
        ax.plot(line[:, 0], line[:, 1], color=INK, linewidth=0.9, zorder=3)
        return 0.5 * (load.anchor + load.position)
    if load.direction is None:
        ax.plot(*load.position, marker="D", linestyle="", color=INK, markersize=4, zorder=5)
        return np.asarray(load.position)
    tail = load.position - 0.2 * size * load.direction
    ax.plot(*np.stack([tail, load.position]).T, color=INK, linewidth=1.4, zorder=5)
    _draw_arrow_head(ax, load.position, load.direction, 0.04 * size)
    return np.asarray(tail)


def _draw_arrow_head(ax: Axes, tip: np.ndarray, direction: np.ndarray, length: float) -> None:
    """Draw the head of an arrow at `tip` (m) that points in a direction; length : m."""
    back = -length * direction / max(float(np.hypot(*direction)), 1e-12)
    perpendicular = 0.4 * np.array([-back[1], back[0]])
    corners = np.stack([tip, tip + back + perpendicular, tip + back - perpendicular])
    ax.fill(*corners.T, facecolor=INK, edgecolor=INK, zorder=5)
