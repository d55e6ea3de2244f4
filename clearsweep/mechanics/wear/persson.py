"""Persson's pressure between a journal and a bearing of like materials, for any contact arc.

The theory gives the pressure over an arc, and the load of that arc, in closed form.  Wear needs the arc at a load and
integrals of the pressure over the arc and over parts of it.  These are smooth functions without a closed form, so they
are represented by polynomials through their values, with the stated accuracy.
"""

import math
from typing import NamedTuple

import numpy as np

from ...contracts.case import Joint
from ...contracts.catalogue import Law
from ...tracing import portable
from ...tracing.portable import coefficients_through, exact, polynomial_through
from ..laws.conformal import MAX_B2, half_angle_at_load
from ..laws.contract import register
from .contract import cumulative_pressure, half_arc, peak_over_mean, pressure_integral_over_load, smooth_range
from .pressure import MODULUS, modulus_of

MAX_HALF_ANGLE = 2.0 * math.atan(math.sqrt(MAX_B2))  # rad: half of the arc at an infinite load
HALFWAY_LOAD = 2.0  # E* c: load mapped to half of the interval of `_half_angle_over_root`, chosen for the closest fit
_NODES, _WEIGHTS = portable.gauss_rule(40)


class Persson(NamedTuple):
    """Conformal cylinders of like materials."""

    modulus: float  # E*, Pa


def pressure_over_load(angle, half_angle):
    """Return p R / f at `angle` (rad) from the middle of an arc of half-angle `half_angle` (rad).

    Ciavarella & Decuzzi 2001, with b = tan(half / 2), y = tan(angle / 2); the scale follows from the balance of forces.
    """
    b2, y2 = portable.tan(0.5 * half_angle) ** 2, portable.tan(0.5 * angle) ** 2
    root, root_of_sum = np.sqrt(np.maximum(b2 - y2, 0.0)), np.sqrt(1.0 + b2)
    return 2.0 * root / (math.pi * root_of_sum * (1.0 + y2)) + portable.atanh(root / root_of_sum) / (
        math.pi * b2 * (1.0 + b2)
    )


def _pressure_beyond(x, half_angle):
    """Return the integral of p R / f over the arc beyond `x` (-1 to 1), by Gauss's rule over the arcsine of `x`."""
    low, quarter = math.asin(x), 0.5 * math.pi
    t = low + 0.5 * (quarter - low) * (_NODES + 1.0)
    values = pressure_over_load(half_angle * portable.sin(t), half_angle) * half_angle * portable.cos(t)
    return 0.5 * (quarter - low) * np.sum(_WEIGHTS * values)


def _by_squared_half_angle(function):
    """Return a function of squared half-angles (array, over MAX_HALF_ANGLE squared) from one of a half-angle (rad)."""
    return lambda squares: np.array([function(MAX_HALF_ANGLE * math.sqrt(max(square, 1e-9))) for square in squares])


def _half_angle_over_root(z):
    """Return the half-angle (rad) over the root of z at a load q (in E* c), with z = q / (q + HALFWAY_LOAD)."""
    z = np.clip(z, 1e-12, 1.0 - 1e-12)
    return half_angle_at_load(HALFWAY_LOAD * z / (1.0 - z)) / np.sqrt(z)


def _tail_fractions(edge_distances, squares):
    """Return the load fractions beyond 1 - d, divided by d^(3/2), for all edge distances d and squared half-angles."""
    half_angles = MAX_HALF_ANGLE * np.sqrt(squares)
    return np.array(
        [
            [
                _pressure_beyond(1.0 - edge_distance, half_angle)
                / (2.0 * _pressure_beyond(0.0, half_angle))
                / edge_distance**1.5
                for half_angle in half_angles
            ]
            for edge_distance in edge_distances
        ]
    )


def _tail_coefficients(degree, square_degree):
    """Return the coefficients of the tail fractions by powers of the edge distance and of the squared half-angle."""
    edge_distances, squares = (portable.chebyshev_points(count + 1) for count in (degree, square_degree))
    rows, columns = (coefficients_through(points) for points in (edge_distances, squares))
    return (rows @ exact(_tail_fractions(edge_distances, squares)) @ columns.transposed).rounded()


ARC_COEFFICIENTS = polynomial_through(_half_angle_over_root, 14)  # by powers of z, to 2e-11
INTEGRAL_COEFFICIENTS = polynomial_through(
    _by_squared_half_angle(lambda half_angle: 2.0 * _pressure_beyond(0.0, half_angle)), 8
)  # by powers of the squared half-angle, to 1e-13
PEAK_COEFFICIENTS = polynomial_through(
    _by_squared_half_angle(
        lambda half_angle: pressure_over_load(0.0, half_angle) * half_angle / _pressure_beyond(0.0, half_angle)
    ),
    10,
)  # to 2e-12
TAIL_COEFFICIENTS = _tail_coefficients(8, 7)  # (9, 8), to 1e-9


@half_arc.member(Persson)
def _half_arc_persson(pressure, joint, radius, sliding):
    q = sliding.line_load / (pressure.modulus * sliding.clearance)
    z, total = q / (q + HALFWAY_LOAD), 0.0
    for i in range(ARC_COEFFICIENTS.size - 1, -1, -1):
        total = total * z + ARC_COEFFICIENTS[i]
    return total * math.sqrt(z)


@cumulative_pressure.member(Persson)
def _cumulative_pressure_persson(pressure, x, half_angle):
    edge_distance, square, tail = (
        max(1.0 - abs(x), 0.0),
        half_angle * half_angle * (1.0 / (MAX_HALF_ANGLE * MAX_HALF_ANGLE)),
        0.0,
    )
    for i in range(TAIL_COEFFICIENTS.shape[0] - 1, -1, -1):
        column = 0.0
        for k in range(TAIL_COEFFICIENTS.shape[1] - 1, -1, -1):
            column = column * square + TAIL_COEFFICIENTS[i, k]
        tail = tail * edge_distance + column
    return 0.5 + math.copysign(0.5 - tail * edge_distance * math.sqrt(edge_distance), x)


@smooth_range.member(Persson)
def _smooth_range_persson(pressure):
    return 0.95  # at the ends it varies as the power 3/2


@pressure_integral_over_load.member(Persson)
def _pressure_integral_over_load_persson(pressure, half_angle):
    square, total = half_angle * half_angle * (1.0 / (MAX_HALF_ANGLE * MAX_HALF_ANGLE)), 0.0
    for i in range(INTEGRAL_COEFFICIENTS.size - 1, -1, -1):
        total = total * square + INTEGRAL_COEFFICIENTS[i]
    return total


@peak_over_mean.member(Persson)
def _peak_over_mean_persson(pressure, half_angle):
    square, total = half_angle * half_angle * (1.0 / (MAX_HALF_ANGLE * MAX_HALF_ANGLE)), 0.0
    for i in range(PEAK_COEFFICIENTS.size - 1, -1, -1):
        total = total * square + PEAK_COEFFICIENTS[i]
    return total


def _make_persson(joint: Joint) -> Persson:
    return Persson(modulus_of(joint))


register(
    Law(
        "pressure",
        "persson",
        "conformal contact of like materials, over any arc up to its limiting angle",
        "p R / f = 2 sqrt(b^2 - y^2) / (pi sqrt(1 + b^2) (1 + y^2)) + ln((w + r) / (w - r)) / (2 pi b^2 (1 + b^2)), "
        "r = sqrt(b^2 - y^2), w = sqrt(b^2 + 1), b = tan(theta / 2), y = tan(phi / 2); "
        "f = 2 pi E* c b^2 (b^2 + 1) / (2 - ln(b^2 + 1) - 2 b^4), f = F / length",
        "after Persson 1964 (thesis, Chalmers) and Ciavarella & Decuzzi 2001, Int. J. Solids Struct. 38:4507, like "
        "materials; the scale from the balance of forces",
        (MODULUS,),
        needs=("modulus",),
        notes="The arc follows from the load, not from the penetration; a small one is that of Hertz.  The half-angle "
        "cannot pass 84.83 degrees.  Bearing and journal have the same arc.",
    ),
    (Persson,),
    _make_persson,
)
