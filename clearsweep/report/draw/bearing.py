"""Drawings of a rolling bearing: its elements with their loads, the loads around it, and life over its clearance."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ...contracts.case import Rolling
from ...language import wording
from ..axis import Axis
from ..plot import Axes, multiples_of
from . import BLUE, GREY, INK, ORANGE, PALE, RED, label_values, label_with_unit, set_plain_axes

LONGEST_ARROW = 0.9  # of an element's diameter: drawn length of the largest load
RING_THICKNESS = 0.35  # of an element's diameter, of a ring of unknown bore or outside diameter
SECTORS = 72  # of the circle, in which loads are collected


class LoadedElements(NamedTuple):
    """The elements of a bearing over the saved samples of a case."""

    angles: np.ndarray  # (samples, elements) rad, in the fixed frame
    loads: np.ndarray  # (samples, elements) N

    @property
    def peak(self) -> int:
        """Return the sample with the largest load of an element."""
        return int(self.loads.max(axis=1).argmax())

    def by_sector(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the largest and the mean load (SECTORS,) N of the elements in each sector; nan: none was there."""
        sectors = np.floor(np.mod(self.angles, 2.0 * np.pi) / (2.0 * np.pi) * SECTORS).astype(int) % SECTORS
        counts = np.bincount(sectors.ravel(), minlength=SECTORS)
        largest = np.full(SECTORS, -np.inf)
        np.maximum.at(largest, sectors.ravel(), self.loads.ravel())
        sums = np.bincount(sectors.ravel(), self.loads.ravel(), SECTORS)
        with np.errstate(invalid="ignore"):
            return np.where(counts > 0, largest, np.nan), sums / np.where(counts > 0, counts, np.nan)


def draw_bearing(ax: Axes, bearing: Rolling, angles: np.ndarray, loads: np.ndarray) -> None:
    """Draw the rings and the elements of a bearing at `angles` (Z,) rad, with their `loads` (Z,) N as bars inward."""
    diameter, pitch = 1e3 * bearing.element_diameter, 1e3 * bearing.pitch_diameter
    inner, outer = pitch - diameter, pitch + diameter
    thickness = 2.0 * RING_THICKNESS * diameter
    bore = 1e3 * bearing.bore if bearing.bore else max(inner - thickness, 0.2 * inner)
    outside = 1e3 * bearing.outside_diameter if bearing.outside_diameter else outer + thickness
    for size, face in ((outside, PALE), (outer, "#ffffff"), (inner, PALE), (bore, "#ffffff")):
        ax.circle((0.0, 0.0), 0.5 * size, facecolor=face, edgecolor=GREY, zorder=0.0)
    largest = max(float(loads.max()), np.finfo(float).tiny)
    for angle, load in zip(angles, loads, strict=True):
        direction = np.array([np.cos(angle), np.sin(angle)])
        centre = 0.5 * pitch * direction
        is_loaded = load > 0.0
        face, edge = (BLUE, INK) if is_loaded else ("#ffffff", GREY)
        ax.circle((float(centre[0]), float(centre[1])), 0.5 * diameter, facecolor=face, edgecolor=edge, zorder=1.0)
        if is_loaded:
            ends = np.outer([0.5 * inner, 0.5 * inner - LONGEST_ARROW * diameter * load / largest], direction)
            ax.plot(ends[:, 0], ends[:, 1], color=RED, linewidth=2.6)
    ax.set_square(0.54 * outside)
    ax.set_labels("x [mm]", "y [mm]")
    set_plain_axes(ax)


def draw_load_distribution(ax: Axes, elements: LoadedElements) -> None:
    """Draw the largest and the mean load of the elements over their angle, and the loads at the largest."""
    largest, mean = elements.by_sector()
    scale = wording.scale("N", float(elements.loads.max()))
    angles = (np.arange(SECTORS) + 0.5) * 360.0 / SECTORS
    ax.plot(angles, largest / scale.factor, color=BLUE, linewidth=1.4, label="largest")
    ax.plot(angles, mean / scale.factor, color=ORANGE, linewidth=1.2, linestyle="--", label="mean")
    at_peak = np.degrees(np.mod(elements.angles[elements.peak], 2.0 * np.pi))
    ax.plot(at_peak, elements.loads[elements.peak] / scale.factor, "o", color=RED, markersize=4.0, label="at the peak")
    ax.xaxis.tick_rule = multiples_of(90)
    ax.set_xlim(0.0, 360.0)
    ax.set_ylim(0.0, None)
    ax.set_labels("angle of the element [°]", label_with_unit("load of an element", scale))
    set_plain_axes(ax)
    ax.set_legend("above", columns=3)


def draw_life(ax: Axes, axis: Axis, lives: Sequence[tuple[str, np.ndarray]]) -> None:
    """Draw lives (values of the axis,) h over the clearance; each with its name, '' if there is one."""
    positions = np.array(axis.values, float) / axis.scale.factor
    for (name, values), colour in zip(lives, (BLUE, ORANGE, RED, GREY), strict=False):
        ax.plot(positions, values, "o-", color=colour, markersize=4.0, label=name)
    if positions.min() < 0.0 < positions.max():
        ax.axvline(0.0, color=GREY, linewidth=0.8, linestyle="--")
    label_values(ax.xaxis, axis, positions)
    ax.set_ylim(0.0, None)
    ax.set_labels(axis.label(), "rating life [h]")
    set_plain_axes(ax)
    if lives[1:]:
        ax.set_legend("above", columns=2)
