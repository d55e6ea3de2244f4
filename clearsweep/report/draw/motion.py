"""Drawings of one motion: orbit, force, histories and contact onsets."""

from collections.abc import Sequence
from itertools import cycle
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.patches import Circle
from matplotlib.ticker import MaxNLocator, MultipleLocator

from ...language import wording
from .style import BLUE, GREY, INK, RED, draw_colour_bar, set_crank_angle_axis, set_plain_axes, stem_lines

if TYPE_CHECKING:
    from matplotlib.axes import Axes

DRAWN_PENETRATION = 0.4  # of the clearance: drawn height of the deepest penetration in an unrolled gap


def draw_orbit(ax: "Axes", x: np.ndarray, y: np.ndarray, force: np.ndarray, clearance: float) -> None:
    """Draw the path of the journal centre (m) in the clearance circle; contact is coloured by force (N)."""
    scale = wording.scale("m", clearance)
    x, y, radius = x / scale.factor, y / scale.factor, clearance / scale.factor
    ax.add_patch(Circle((0.0, 0.0), radius, facecolor="#f3f6f9", edgecolor=INK, linewidth=1.0, zorder=0))
    ax.plot(x, y, color=GREY, linewidth=0.5, alpha=0.8, rasterized=len(x) > 5000)
    half_width = 1.08 * max(radius, float(np.hypot(x, y).max(initial=0.0)))
    _draw_contact_points(ax, x, y, force)
    ax.set(
        xlim=(-half_width, half_width),
        ylim=(-half_width, half_width),
        aspect="equal",
        xlabel=f"journal x [{scale.unit}]",
        ylabel=f"journal y [{scale.unit}]",
    )
    ax.xaxis.set_major_locator(MaxNLocator(5))
    ax.yaxis.set_major_locator(MaxNLocator(5))


def _draw_contact_points(ax: "Axes", x: np.ndarray, y: np.ndarray, force: np.ndarray) -> None:
    """Draw the points of a path in contact, coloured by the force (N)."""
    in_contact = force > 0.0
    if in_contact.any():
        scale = wording.scale("N", force)
        points = ax.scatter(
            x[in_contact],
            y[in_contact],
            c=force[in_contact] / scale.factor,
            s=4,
            cmap="viridis",
            zorder=3,
            linewidths=0,
            rasterized=True,
        )
        draw_colour_bar(ax, points, f"normal force [{scale.unit}]")


def draw_unrolled_orbit(ax: "Axes", x: np.ndarray, y: np.ndarray, force: np.ndarray, clearance: float) -> None:
    """Draw the gap of a journal (m) over the direction of its centre; penetration is magnified."""
    scale, direction = wording.scale("m", clearance), np.degrees(np.arctan2(y, x))
    gap, magnification = clearance - np.hypot(x, y), penetration_magnification(x, y, clearance)
    max_penetration = max(float(-gap.min()), 0.0)
    height = np.where(gap < 0.0, magnification * gap, gap) / scale.factor
    crosses_seam = np.abs(np.diff(direction)) > 180.0  # a line that crosses +-180 degrees
    ax.plot(
        np.insert(direction, np.flatnonzero(crosses_seam) + 1, np.nan),
        np.insert(height, np.flatnonzero(crosses_seam) + 1, np.nan),
        color=GREY,
        linewidth=0.5,
        alpha=0.8,
        rasterized=len(x) > 5000,
    )
    ax.axhspan(1.1 * min(float(height.min()), 0.0), 0.0, color="#f6e7dd", linewidth=0, zorder=0)
    ax.axhline(0.0, color=INK, linewidth=1.0)
    _draw_contact_points(ax, direction, height, force)
    high, low = 1.05 * max(float(height.max()), 0.2 * clearance / scale.factor), 1.1 * min(float(height.min()), 0.0)
    penetration_ticks = [] if max_penetration == 0.0 else [-max_penetration, -0.5 * max_penetration]
    gap_ticks = np.asarray(MaxNLocator(max(1, round(4.0 * high / (high - low)))).tick_values(0.0, high))
    gap_ticks = gap_ticks[(gap_ticks >= 0.0) & (gap_ticks <= high)]
    penetration_labels = [
        wording.short_number_text(value / scale.factor, 2).replace("-", wording.MINUS) for value in penetration_ticks
    ]
    ax.set_yticks(
        [*(magnification * value / scale.factor for value in penetration_ticks), *gap_ticks],
        [*penetration_labels, *map(_short_text, gap_ticks)],
    )
    ax.set(
        xlim=(-180.0, 180.0),
        ylim=(low, high),
        xlabel="direction of the journal centre [°]",
        ylabel=f"gap [{scale.unit}]",
    )
    ax.xaxis.set_major_locator(MultipleLocator(90))
    set_plain_axes(ax)


def penetration_magnification(x: np.ndarray, y: np.ndarray, clearance: float) -> float:
    """Return the magnification of penetration relative to the gap: one digit, at least 1."""
    max_penetration = float(np.hypot(x, y).max()) - clearance
    return max(float(f"{DRAWN_PENETRATION * clearance / max_penetration:.1g}"), 1.0) if max_penetration > 0.0 else 1.0


def _short_text(value: float) -> str:
    return wording.short_number_text(float(value), 3)


def draw_force(ax: "Axes", angle: np.ndarray, normal: np.ndarray, levels: Sequence[tuple[str, float]]) -> None:
    """Draw the normal force (N) over the crank angle (rad), with named levels (N) as horizontal lines."""
    scale = wording.scale("N", [*normal, *(level for _, level in levels)])
    ax.plot(np.degrees(angle), normal / scale.factor, color=BLUE, linewidth=0.7, rasterized=len(angle) > 5000)
    for (name, level), colour, line_style in zip(levels, (RED, INK), ("--", ":"), strict=False):
        ax.axhline(level / scale.factor, color=colour, linewidth=1.1, linestyle=line_style, label=name)
    ax.set(ylabel=f"normal force [{scale.unit}]", ylim=(0.0, None))
    set_crank_angle_axis(ax, angle, has_legend=bool(levels))


def draw_against_ideal(
    ax: "Axes", angle: np.ndarray, actual: np.ndarray, ideal: np.ndarray | None, unit: str, name: str
) -> None:
    """Draw a quantity (SI) over the crank angle (rad) and, if available, the same in the ideal mechanism."""
    scale = wording.scale(unit, actual)
    ax.plot(
        np.degrees(angle),
        actual / scale.factor,
        color=BLUE,
        linewidth=0.7,
        label="with clearance",
        rasterized=len(angle) > 5000,
    )
    if ideal is not None:
        ax.plot(np.degrees(angle), ideal / scale.factor, color=RED, linewidth=1.4, linestyle="--", label="ideal")
    ax.set(ylabel=f"{name} [{scale.unit}]")
    set_crank_angle_axis(ax, angle, has_legend=ideal is not None)


def draw_over_time(ax: "Axes", t: np.ndarray, values: np.ndarray, unit: str, name: str) -> None:
    """Draw a quantity (SI) over time (s)."""
    scale, time_scale = wording.scale(unit, values), wording.scale("s", t)
    ax.plot(t / time_scale.factor, values / scale.factor, color=BLUE, linewidth=0.8, rasterized=len(t) > 5000)
    ax.set(xlabel=f"time [{time_scale.unit}]", ylabel=f"{name} [{scale.unit}]")
    set_plain_axes(ax)


def draw_phase_portrait(ax: "Axes", quantity: tuple[np.ndarray, str, str], rate: tuple[np.ndarray, str, str]) -> None:
    """Draw a rate over its quantity; each : values in SI, unit, name."""
    (x, *x_unit_and_name), (v, *v_unit_and_name) = quantity, rate
    x_scale, v_scale = wording.scale(x_unit_and_name[0], x), wording.scale(v_unit_and_name[0], v)
    ax.plot(x / x_scale.factor, v / v_scale.factor, color=BLUE, linewidth=0.8, rasterized=len(x) > 5000)
    ax.set(xlabel=f"{x_unit_and_name[1]} [{x_scale.unit}]", ylabel=f"{v_unit_and_name[1]} [{v_scale.unit}]")
    set_plain_axes(ax)


def draw_onsets(ax: "Axes", angle: np.ndarray, rate: np.ndarray, limits: Sequence[tuple[str, float]]) -> None:
    """Draw closing rates (m/s) of contact onsets over the crank angle (rad), and the rates at which contacts yield."""
    scale = wording.scale("m/s", [*rate, *(limit for _, limit in limits)])
    ax.plot(*stem_lines(np.degrees(angle), 0.0, rate / scale.factor), color=BLUE, linewidth=0.6)
    ax.plot(np.degrees(angle), rate / scale.factor, ".", color=BLUE, markersize=4, rasterized=len(angle) > 500)
    for (name, limit), dash in zip(limits, cycle(("--", ":", "-."))):
        label = f"first yield ({name})"
        ax.axhline(limit / scale.factor, color=RED, linewidth=1.1, linestyle=dash, label=label)
    ax.set(ylabel=f"closing rate at onset [{scale.unit}]", ylim=(0.0, None))
    set_crank_angle_axis(
        ax, np.array([0.0, 2.0 * np.pi * np.ceil(angle.max() / (2.0 * np.pi))]), has_legend=bool(limits)
    )  # full turns
