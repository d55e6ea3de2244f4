"""The pressures and wear laws of docs/model-wear.md in numpy, without code of the package.

A pressure is a function of line load (N/m), radius of the body (m), penetration (m), E* (Pa) and Sizes.  It returns the
half-angle of its arc (rad) and a function of the angle (rad) from the middle of the arc, in Pa.
"""

import math
from typing import NamedTuple

import numpy as np
from scipy.integrate import cumulative_trapezoid
from scipy.optimize import brentq


class Sizes(NamedTuple):
    """Sizes of a joint."""

    clearance: float  # m
    bearing: float  # m, radius


def mean(load, radius, depth, modulus, sizes):
    """Return the uniform pressure over the arc of rigid circles."""
    half = math.acos(sizes.clearance / (sizes.clearance + depth))
    return half, lambda psi: np.full_like(psi, load / (2.0 * radius * math.sin(half)))


def winkler(load, radius, depth, modulus, sizes):
    """Return the pressure proportional to the overlap of rigid circles, over their arc."""
    half = math.acos(sizes.clearance / (sizes.clearance + depth))
    scale = load / radius / (half - math.sin(half) * math.cos(half))
    return half, lambda psi: scale * (np.cos(psi) - math.cos(half))


def hertz_line(load, radius, depth, modulus, sizes):
    """Return the Hertzian pressure: half an ellipse."""
    relative = sizes.bearing * (sizes.bearing - sizes.clearance) / sizes.clearance
    width = math.sqrt(4.0 * load * relative / (math.pi * modulus))
    half = width / radius
    return half, lambda psi: 2.0 * load / (math.pi * width) * np.sqrt(np.maximum(1.0 - (psi / half) ** 2, 0.0))


def persson(load, radius, depth, modulus, sizes):
    """Return Persson's pressure; the load determines the arc."""

    def excess(b):
        w2 = b * b + 1.0
        left = 2.0 - math.log(w2) - 2.0 * b**4
        return load * left - 2.0 * math.pi * modulus * sizes.clearance * b * b * w2

    b = brentq(excess, 1e-9, 0.9137, xtol=1e-15)
    w = math.sqrt(b * b + 1.0)

    def pressure(psi):
        y2 = np.tan(0.5 * psi) ** 2
        r = np.sqrt(np.maximum(b * b - y2, 0.0))
        logarithm = np.log((w + r) / (w - r)) / (2.0 * math.pi * b * b * w * w)
        return load / radius * (2.0 * r / (math.pi * w * (1.0 + y2)) + logarithm)

    return 2.0 * math.atan(b), pressure


PRESSURES = {"mean": mean, "winkler": winkler, "hertz-line": hertz_line, "persson": persson}
#: Area (m^2/s) removed from a cross-section, from coefficient, summed pressure (N/m), slip (m/s) and work (W/m).
AREAS = {
    "archard": lambda k, pressed, slip, work: k * pressed * slip,
    "energy": lambda k, pressed, slip, work: k * work,
}


def spread(values, half, radius, edges, points=20001):
    """Return the integral of a pressure (N/m) between edges (rad) and over its arc of half-angle `half` (rad)."""
    share = np.sin(np.linspace(-0.5 * math.pi, 0.5 * math.pi, points))  # dense where a pressure ends like a square root
    psi = half * share
    sums = np.concatenate([[0.0], cumulative_trapezoid(radius * values(psi), psi)])
    return np.diff(np.interp(edges, psi, sums)), sums[-1]


def bin_edges(angle, bins):
    """Return the edges (rad) of all bins, by number, relative to the middle of an arc at `angle` (rad)."""
    width = 2.0 * math.pi / bins
    begin = np.mod(np.arange(bins) * width - angle + math.pi, 2.0 * math.pi) - math.pi
    return np.stack([begin, begin + width], axis=1)
