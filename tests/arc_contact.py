"""Conformal contact on a grid: an oracle without assumptions on the arc of contact or the form of the pressure."""

import math
from typing import NamedTuple

import numpy as np


class Arc(NamedTuple):
    """A contact of journal and bearing."""

    load: float  # over E* c L
    half_angle: float  # rad
    peak: float  # pressure over E* c / R
    pressure: np.ndarray  # (elements,) over E* c / R
    angles: np.ndarray  # (elements,) rad, 0 and above


def on_a_grid(depth, elements=600):
    """Return the contact with a depth of `depth` clearances: elements have positive pressure or a gap.

    The kernel -1 - ln|sin(x / 2)| is integrated over each element.  Elements with negative pressure are released one
    after
    another until none is left.
    """
    reach = 1.05 * math.acos(1.0 / (1.0 + depth))
    middle, width = (np.arange(elements) + 0.5) * reach / elements, reach / elements
    nodes, weights = np.polynomial.legendre.leggauss(4)

    def displaced(gap):
        inner = np.abs(0.5 * (np.abs(gap)[..., None] + 0.5 * width * nodes))
        far = 0.5 * width * np.sum(weights * (-1.0 - np.log(np.abs(np.sin(inner)))), -1)
        near = -width * math.log(0.25 * width)  # around its own centre, where the sine equals its angle
        return np.where(np.abs(gap) < 0.5 * width, near, far)

    kernel = displaced(middle[:, None] - middle[None, :]) + displaced(middle[:, None] + middle[None, :])
    overlap = 0.5 * math.pi * ((1.0 + depth) * np.cos(middle) - 1.0)
    pushes = np.ones(elements, bool)
    while True:
        pressure, there = np.zeros(elements), np.flatnonzero(pushes)
        pressure[there] = np.linalg.solve(kernel[np.ix_(there, there)], overlap[there])
        if (pressure >= 0.0).all():
            break
        pushes &= pressure >= 0.0
    load = 2.0 * width * float(np.sum(pressure * np.cos(middle)))
    return Arc(load, width * float(pushes.sum()), float(pressure[0]), pressure, middle)


def persson_load(half_angle):
    """Return Persson's load over E* c L for a half-angle (rad)."""
    b2 = math.tan(0.5 * half_angle) ** 2
    return 2.0 * math.pi * b2 * (b2 + 1.0) / (2.0 - math.log1p(b2) - 2.0 * b2 * b2)


def persson_peak(load):
    """Return Persson's largest pressure over E* c / R under a load over E* c L."""
    low, high = 0.0, math.radians(84.8)
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if persson_load(middle) < load else (low, middle)
    b = math.tan(0.5 * low)
    whole = math.sqrt(1.0 + b * b)
    spread = math.log((whole + b) / (whole - b)) / (2.0 * math.pi * b * b * whole * whole)
    return load * (2.0 * b / (math.pi * whole) + spread)
