"""The shape of a worn surface, smooth enough for contact.

The wear depth h by angle changes the support function of a surface, the distance of the tangent whose normal has that
angle: R_b + h of the bearing, R_j - h of the journal.  (The angle of a normal and the polar angle of its point differ
by h' / R, which is neglected.)  A surface with the support function q has the radius of curvature q + q'', so bearing
and journal differ by

    c + h + h'',   h = h_bearing + h_journal ,

where they face each other.  While that is positive they touch at one point; the journal does not reach into a groove
narrower than itself.  The means of the bins are therefore smoothed by a Gaussian, periodic and so without loss of
volume.  Its width is SMOOTHING_WIDTH, about that of a contact arc, or larger, so that the difference exceeds a minimum
for any rotation of the bodies: POINT_MARGIN for a force at one point, whose normal rotates the faster the smaller the
difference, FOUNDATION_MARGIN where surfaces that have run in conform to each other.  For bins finer than that, their
number does not matter.  A cubic spline through KNOTS values of the result is twice continuously differentiable, so
forces have a continuous slope.
"""

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...compiled.array_handle import array_handle, load_item
from ...compiled.choosing import bits_of
from ...compiled.direction import SHIFT
from ...compiled.dual import chain_rule, plain
from ...compiled.family import inlined
from ...trace import portable

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline

KNOTS = 256  # knots, and intervals of a Shape's table; a power of 2
KNOT_SPACING = 2.0 * math.pi / KNOTS  # rad
KNOTS_PER_RADIAN = 1.0 / KNOT_SPACING
#: Columns of an interval of the table: coefficients of h (m) by powers of the fraction of the interval, and the
#: integral of h (m rad) over all previous intervals.
CONSTANT, LINEAR, QUADRATIC, CUBIC, INTEGRAL_BEFORE, ROW_LENGTH = range(6)
SMOOTHING_WIDTH = math.radians(2.0)  # standard deviation of the Gaussian
WIDENING_FACTOR = 1.1  # factor on the width in each attempt to make the difference large enough
POINT_MARGIN, FOUNDATION_MARGIN = 0.1, -0.02  # clearances: minimum difference of the radii of curvature


class Shape(NamedTuple):
    """Wear depth of a body, by the angle in its frame."""

    table: float  # address of (KNOTS, ROW_LENGTH)
    min_depth: float  # m, of h
    max_depth: float  # m
    max_slope: float  # m/rad, of |h'|
    max_curvature: float  # m/rad^2, largest -h''
    min_radius_change: float  # m, least h + h''
    integral: float  # m rad, integral of h over the circumference


def smooth_depths(depths: np.ndarray, width: float) -> "CubicSpline":
    """Return the periodic spline h (m) of the angle (rad) from mean depths of bins and a Gaussian's `width` (rad)."""
    from scipy.interpolate import CubicSpline

    count = len(depths)
    orders = np.arange(min(count, KNOTS) // 2)  # of harmonics; higher ones would alias
    angles = math.pi * orders / count
    phase_shift = portable.cos(angles) - 1j * portable.sin(angles)
    spectrum = np.fft.rfft(depths)[: orders.size] * phase_shift
    bin_mean_factor = np.append(1.0, portable.sin(angles[1:]) / angles[1:])
    filtered = spectrum / bin_mean_factor * portable.exp(-0.5 * (orders * width) ** 2)
    values = np.fft.irfft(filtered, KNOTS) * (KNOTS / count)
    return CubicSpline(np.arange(KNOTS + 1) * KNOT_SPACING, np.append(values, values[0]), bc_type="periodic")


def shapes_of(
    bearing: np.ndarray, journal: np.ndarray, clearance: float, min_difference: float
) -> tuple[Shape, Shape, float]:
    """Return the shapes of both bodies from the mean depths of their bins (m), and the width (rad) of the Gaussian.

    min_difference : least difference of the radii of curvature, in clearances: POINT_MARGIN or FOUNDATION_MARGIN
    """
    width = SMOOTHING_WIDTH
    while True:
        splines = smooth_depths(bearing, width), smooth_depths(journal, width)
        knots = splines[0].x
        radius_change = math.fsum(float(np.min(spline(knots) + spline(knots, 2))) for spline in splines)
        if clearance + radius_change >= min_difference * clearance:
            return shape_of(splines[0]), shape_of(splines[1]), width
        width *= WIDENING_FACTOR


def shape_of(spline: "CubicSpline") -> Shape:
    """Return the Shape of a spline through KNOTS values around the body."""
    table = np.empty((KNOTS, ROW_LENGTH))
    for power in range(4):
        table[:, power] = spline.c[3 - power] * KNOT_SPACING**power
    interval_integrals = KNOT_SPACING * sum(table[:, power] / (power + 1.0) for power in range(INTEGRAL_BEFORE))
    table[:, INTEGRAL_BEFORE] = np.concatenate([[0.0], np.cumsum(interval_integrals)[:-1]])
    angles = np.linspace(0.0, 2.0 * math.pi, 16 * KNOTS, endpoint=False)
    values = spline(angles)
    return Shape(
        array_handle(table),
        float(values.min()),
        float(values.max()),
        float(np.abs(spline(angles, 1)).max()),
        float(np.max(-spline(angles, 2))),
        float(np.min(values + spline(angles, 2))),
        float(interval_integrals.sum()),
    )


@inlined
def locate_interval(position):
    """Return the fraction of its interval before a `position`, counted in intervals, and the offset of its row."""
    shifted = (position - 0.5) + SHIFT  # rounded to an integer, which is then in its last bits
    return position - (shifted - SHIFT), (bits_of(shifted) & (KNOTS - 1)) * ROW_LENGTH


@inlined
def wear_depth_at(table, angle):
    """Return h (m) and its first three derivatives at an angle (rad) in the frame of the body, from a Shape's table.

    For automatic differentiation, h and its first derivative carry the slopes of the angle.
    """
    position = plain(angle) * KNOTS_PER_RADIAN
    x, offset = locate_interval(position)
    a, b = load_item(table, offset + CONSTANT), load_item(table, offset + LINEAR)
    c, d = load_item(table, offset + QUADRATIC), load_item(table, offset + CUBIC)
    h = a + x * (b + x * (c + x * d))
    slope = (b + x * (2.0 * c + 3.0 * x * d)) * KNOTS_PER_RADIAN
    second_derivative = (2.0 * c + 6.0 * x * d) * (KNOTS_PER_RADIAN * KNOTS_PER_RADIAN)
    third_derivative = 6.0 * d * (KNOTS_PER_RADIAN * KNOTS_PER_RADIAN * KNOTS_PER_RADIAN)
    return chain_rule(h, slope, angle), chain_rule(slope, second_derivative, angle), second_derivative, third_derivative


@inlined
def wear_integral_at(shape, angle):
    """Return the integral of h (m rad) from 0 to an angle (rad) in the frame of the body."""
    position = angle * KNOTS_PER_RADIAN
    x, offset = locate_interval(position)
    a, b = load_item(shape.table, offset + CONSTANT), load_item(shape.table, offset + LINEAR)
    c, d = load_item(shape.table, offset + QUADRATIC), load_item(shape.table, offset + CUBIC)
    turns = math.floor(position * (1.0 / KNOTS))
    integral_in_interval = x * (a + x * (0.5 * b + x * (c * (1.0 / 3.0) + x * (0.25 * d)))) * KNOT_SPACING
    return load_item(shape.table, offset + INTEGRAL_BEFORE) + integral_in_interval + turns * shape.integral
