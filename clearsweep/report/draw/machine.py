"""Drawings of a machine and its motion: bodies, joints and loads; orbits, histories, onsets; journals in space."""

import math
from collections.abc import Sequence
from itertools import cycle
from typing import Any

import numpy as np

from ... import simulation
from ...contracts.machine import GROUND
from ...language import wording
from ..plot import Axes, ColourScale, multiples_of, round_ticks
from . import (
    BLUE,
    GREEN,
    GREY,
    INK,
    ORANGE,
    PALE,
    PURPLE,
    RED,
    draw_colour_bar,
    set_crank_angle_axis,
    set_plain_axes,
    stem_lines,
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


# Drawings of one motion: orbit, force, histories and contact onsets.

DRAWN_PENETRATION = 0.4  # of the clearance: drawn height of the deepest penetration in an unrolled gap


def draw_orbit(ax: Axes, x: np.ndarray, y: np.ndarray, force: np.ndarray, clearance: float) -> None:
    """Draw the path of the journal centre (m) in the clearance circle; contact is coloured by force (N)."""
    scale = wording.scale("m", clearance)
    x, y, radius = x / scale.factor, y / scale.factor, clearance / scale.factor
    ax.circle((0.0, 0.0), radius, facecolor="#f3f6f9", edgecolor=INK, zorder=0)
    ax.plot(x, y, color=GREY, linewidth=0.5, alpha=0.8)
    half_width = 1.08 * max(radius, float(np.hypot(x, y).max(initial=0.0)))
    _draw_contact_points(ax, x, y, force)
    ax.set_square(half_width)
    ax.set_labels(f"journal x [{scale.unit}]", f"journal y [{scale.unit}]")
    ax.xaxis.tick_rule = round_ticks(5)
    ax.yaxis.tick_rule = round_ticks(5)


def _draw_contact_points(ax: Axes, x: np.ndarray, y: np.ndarray, force: np.ndarray) -> None:
    """Draw the points of a path in contact, coloured by the force (N)."""
    in_contact = force > 0.0
    if in_contact.any():
        scale = wording.scale("N", force)
        forces = force[in_contact] / scale.factor
        colours = ColourScale(float(forces.min()), float(forces.max()))
        ax.scatter(x[in_contact], y[in_contact], size=2.0, values=forces, scale=colours, zorder=3)
        draw_colour_bar(ax, colours, f"normal force [{scale.unit}]")


def draw_unrolled_orbit(ax: Axes, x: np.ndarray, y: np.ndarray, force: np.ndarray, clearance: float) -> None:
    """Draw the gap of a journal (m) over the direction of its centre; penetration is magnified."""
    scale, direction = wording.scale("m", clearance), np.degrees(np.arctan2(y, x))
    gap, magnification = clearance - np.hypot(x, y), penetration_magnification(x, y, clearance)
    max_penetration = max(float(-gap.min()), 0.0)
    height = np.where(gap < 0.0, magnification * gap, gap) / scale.factor
    seams = np.flatnonzero(np.abs(np.diff(direction)) > 180.0) + 1  # where a line crosses +-180 degrees
    ax.plot(np.insert(direction, seams, np.nan), np.insert(height, seams, np.nan), color=GREY, linewidth=0.5, alpha=0.8)
    ax.axhspan(1.1 * min(float(height.min()), 0.0), 0.0, color="#f6e7dd", zorder=0)
    ax.axhline(0.0, color=INK, linewidth=1.0)
    _draw_contact_points(ax, direction, height, force)
    high, low = 1.05 * max(float(height.max()), 0.2 * clearance / scale.factor), 1.1 * min(float(height.min()), 0.0)
    penetrations = [] if max_penetration == 0.0 else [-max_penetration, -0.5 * max_penetration]
    gap_ticks = np.asarray(round_ticks(max(1, round(4.0 * high / (high - low))))(0.0, high))
    gap_ticks = gap_ticks[(gap_ticks >= 0.0) & (gap_ticks <= high)]
    names = [wording.short_number_text(value / scale.factor, 2).replace("-", wording.MINUS) for value in penetrations]
    ticks = [*(magnification * value / scale.factor for value in penetrations), *gap_ticks]
    ax.yaxis.set_ticks(ticks, [*names, *map(_short_text, gap_ticks)])
    ax.set_xlim(-180.0, 180.0)
    ax.set_ylim(low, high)
    ax.set_labels("direction of the journal centre [°]", f"gap [{scale.unit}]")
    ax.xaxis.tick_rule = multiples_of(90)
    set_plain_axes(ax)


def penetration_magnification(x: np.ndarray, y: np.ndarray, clearance: float) -> float:
    """Return the magnification of penetration relative to the gap: one digit, at least 1."""
    max_penetration = float(np.hypot(x, y).max()) - clearance
    return max(float(f"{DRAWN_PENETRATION * clearance / max_penetration:.1g}"), 1.0) if max_penetration > 0.0 else 1.0


def _short_text(value: float) -> str:
    return wording.short_number_text(float(value), 3)


def draw_force(ax: Axes, angle: np.ndarray, normal: np.ndarray, levels: Sequence[tuple[str, float]], unit: str) -> None:
    """Draw the normal force (`unit`, N or N*m) over the crank angle (rad), with named levels as horizontal lines."""
    scale = wording.scale(unit, [*normal, *(level for _, level in levels)])
    ax.plot(np.degrees(angle), normal / scale.factor, color=BLUE, linewidth=0.7)
    for (name, level), colour, line_style in zip(levels, (RED, INK), ("--", ":"), strict=False):
        ax.axhline(level / scale.factor, color=colour, linewidth=1.1, linestyle=line_style, label=name)
    ax.yaxis.label = f"{'torque' if unit == 'N*m' else 'normal force'} [{scale.unit}]"
    ax.set_ylim(0.0, None)
    set_crank_angle_axis(ax, angle, has_legend=bool(levels))


def draw_against_ideal(
    ax: Axes, angle: np.ndarray, actual: np.ndarray, ideal: np.ndarray | None, unit: str, name: str
) -> None:
    """Draw a quantity (SI) over the crank angle (rad) and, if available, the same in the ideal mechanism."""
    scale = wording.scale(unit, actual)
    ax.plot(np.degrees(angle), actual / scale.factor, color=BLUE, linewidth=0.7, label="with clearance")
    if ideal is not None:
        ax.plot(np.degrees(angle), ideal / scale.factor, color=RED, linewidth=1.4, linestyle="--", label="ideal")
    ax.yaxis.label = f"{name} [{scale.unit}]"
    set_crank_angle_axis(ax, angle, has_legend=ideal is not None)


def draw_over_time(
    ax: Axes, t: np.ndarray, values: np.ndarray, unit: str, name: str, ideal: np.ndarray | None = None
) -> None:
    """Draw a quantity (SI) over time (s) and, if available, the same in the ideal mechanism at equal crank angles."""
    scale, time_scale = wording.scale(unit, values, speed="speed" in name), wording.scale("s", t)
    label = "with clearance" if ideal is not None else ""
    ax.plot(t / time_scale.factor, values / scale.factor, color=BLUE, linewidth=0.8, label=label)
    if ideal is not None:
        ax.plot(t / time_scale.factor, ideal / scale.factor, color=RED, linewidth=1.2, linestyle="--", label="ideal")
    ax.set_labels(f"time [{time_scale.unit}]", f"{name} [{scale.unit}]")
    set_plain_axes(ax)
    if ideal is not None:
        ax.set_legend("above", columns=2)


def draw_phase_portrait(ax: Axes, quantity: tuple[np.ndarray, str, str], rate: tuple[np.ndarray, str, str]) -> None:
    """Draw a rate over its quantity; each : values in SI, unit, name."""
    (x, *x_unit_and_name), (v, *v_unit_and_name) = quantity, rate
    x_scale, v_scale = wording.scale(x_unit_and_name[0], x), wording.scale(v_unit_and_name[0], v)
    ax.plot(x / x_scale.factor, v / v_scale.factor, color=BLUE, linewidth=0.8)
    ax.set_labels(f"{x_unit_and_name[1]} [{x_scale.unit}]", f"{v_unit_and_name[1]} [{v_scale.unit}]")
    set_plain_axes(ax)


def draw_onsets(ax: Axes, angle: np.ndarray, rate: np.ndarray, limits: Sequence[tuple[str, float]], unit: str) -> None:
    """Draw closing rates (`unit`, m/s or rad/s) of contact onsets over the crank angle (rad), and those of yield."""
    scale = wording.scale(unit, [*rate, *(limit for _, limit in limits)])
    ax.plot(*stem_lines(np.degrees(angle), 0.0, rate / scale.factor), color=BLUE, linewidth=0.6)
    ax.plot(np.degrees(angle), rate / scale.factor, ".", color=BLUE, markersize=4)
    for (name, limit), dash in zip(limits, cycle(("--", ":", "-."))):
        label = f"first yield ({name})"
        ax.axhline(limit / scale.factor, color=RED, linewidth=1.1, linestyle=dash, label=label)
    ax.yaxis.label = f"closing rate at onset [{scale.unit}]"
    ax.set_ylim(0.0, None)
    full_turns = np.array([0.0, 2.0 * np.pi * np.ceil(angle.max() / (2.0 * np.pi))])
    set_crank_angle_axis(ax, full_turns, has_legend=bool(limits))


# Drawings of a journal in a spatial bearing: its axis, the orbits of its ends, its tilt.

END_COLOURS = (BLUE, RED)  # of the end at +z, at -z
MAX_DRAWN_POSITIONS = 24  # number of drawn positions of the axis
CIRCLE_ANGLES = np.linspace(0.0, 2.0 * np.pi, 73)
AZIMUTH, ELEVATION = np.radians(-60.0), np.radians(25.0)  # of the view
#: (2, 3): x, y and z of a bearing on the picture, a parallel projection.
VIEW = np.array(
    [
        [-np.sin(AZIMUTH), np.cos(AZIMUTH), 0.0],
        [-np.sin(ELEVATION) * np.cos(AZIMUTH), -np.sin(ELEVATION) * np.sin(AZIMUTH), np.cos(ELEVATION)],
    ]
)


def draw_axis(ax: Axes, journal_ends: np.ndarray, half_lengths: tuple[float, float], clearance: float) -> None:
    """Draw the path of the ends of a journal's axis, seen from the side and above; journal_ends : (2, n, 3) m.

    z is along the bearing.  half_lengths : m, half the lengths of journal and bearing.  The scale along the bearing is
    chosen so that both directions fill the picture.
    """
    size = np.array([clearance, clearance, 0.6 * half_lengths[0] if half_lengths[0] > 0.0 else 1.0])
    circle = clearance * np.stack([np.cos(CIRCLE_ANGLES), np.sin(CIRCLE_ANGLES), np.zeros(CIRCLE_ANGLES.size)], -1)
    centre_line = np.array([[0.0, 0.0, -1.2], [0.0, 0.0, 1.2]]) * half_lengths[1]

    def draw_line(points: np.ndarray, colour: str, linewidth: float, zorder: float = 2.0) -> None:
        ax.plot(*(VIEW @ (points / size).T), color=colour, linewidth=linewidth, zorder=zorder)

    draw_line(centre_line, GREY, 0.8)
    for k in np.linspace(0, journal_ends.shape[1] - 1, min(MAX_DRAWN_POSITIONS, journal_ends.shape[1])).astype(int):
        draw_line(journal_ends[:, k], PALE, 0.6, zorder=0.0)
    for end, colour, sign in zip(journal_ends, END_COLOURS, (1.0, -1.0), strict=True):
        draw_line(circle + np.array([0.0, 0.0, sign * half_lengths[0]]), INK, 0.8)
        draw_line(end, colour, 0.6)
    radius, length = wording.quantity_text(clearance, "m"), wording.quantity_text(2.0 * half_lengths[0], "m")
    ax.set_labels(f"circles: radius {radius}", f"journal: {length} along the bearing")
    for side in (ax.xaxis, ax.yaxis):
        side.set_ticks([])
    ax.equal_aspect = True


def draw_end_orbits(ax: Axes, journal_ends: np.ndarray, clearance: float) -> None:
    """Draw the view along the bearing: the orbits (2, n, 3) m of both ends in the clearance circle."""
    scale = wording.scale("m", clearance)
    radius = clearance / scale.factor
    ax.plot(radius * np.cos(CIRCLE_ANGLES), radius * np.sin(CIRCLE_ANGLES), color=INK, linewidth=1.0)
    for end, colour, name in zip(journal_ends, END_COLOURS, ("end +z", "end -z"), strict=True):
        ax.plot(*(end[:, :2].T / scale.factor), color=colour, linewidth=0.5, alpha=0.6, label=name)
    ax.equal_aspect = True
    ax.set_labels(f"x [{scale.unit}]", f"y [{scale.unit}]")
    ax.set_legend("above", columns=2)


def draw_tilt(ax: Axes, angle: np.ndarray, tilt: np.ndarray, limit: float | None) -> None:
    """Draw the tilt (rad) over the crank angle (rad), and the tilt at which the journal jams."""
    ax.plot(np.degrees(angle), np.degrees(tilt), color=BLUE, linewidth=0.8)
    if limit is not None:
        ax.axhline(np.degrees(limit), color=RED, linewidth=1.1, linestyle="--", label="jams")
    ax.yaxis.label = "tilt [°]"
    ax.set_ylim(0.0, None)
    set_crank_angle_axis(ax, angle, has_legend=limit is not None)
