"""The shape of a worn surface, smooth enough for contact.

The wear depth h by angle changes the support function of a surface, the distance of the tangent whose normal has that
angle: R_b + h of the bearing, R_j - h of the journal.  (The angle of a normal and the polar angle of its point differ
by h' / R, which is neglected.)  A surface with the support function q has the radius of curvature q + q'', so bearing
and journal differ by

    c + h + h'',   h = h_bearing + h_journal ,

where they face each other.  While that is positive they touch at one point; the journal does not reach into a groove
narrower than itself.  The means of the bins are smoothed by a Gaussian, periodic and so without loss of volume.  For
bins finer than that, their number does not matter.

* For a force at one point, whose normal rotates the faster the smaller the difference, the Gaussian is so wide that the
  difference exceeds POINT_MARGIN for any rotation of the bodies.
* Where the arc may have any width, the Gaussian is narrow, and what acts is the profile of the same volume that is
  nearest to the smoothed one (least sum of squares) and whose difference exceeds CONFORMAL_MARGIN.  A wider Gaussian
  would reach the margin too.  But it makes a groove shallower and wider than it is; its edges then lose contact and
  wear no more, and the groove stays narrower than the journal.

A cubic spline through KNOTS values is twice continuously differentiable, so forces have a continuous slope.
"""

import functools
import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...contracts.catalogue import Law
from ...language.errors import InputError
from ...tracing import portable
from ...tracing.compiled.choosing import SHIFT, bits_of, direction
from ...tracing.compiled.dual import chain_rule, plain
from ...tracing.compiled.family import inlined
from ...tracing.compiled.pinned import array_handle, load_item, load_items
from ..laws.contract import Recipe, require
from ..laws.own import Own, maker
from ..laws.sampled import checked

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline

KNOTS = 256  # knots, and intervals of a Shape's table; a power of 2
KNOT_SPACING = 2.0 * math.pi / KNOTS  # rad
KNOTS_PER_RADIAN = 1.0 / KNOT_SPACING
#: Columns of an interval of the table: coefficients of h (m) by powers of the fraction of the interval; the integral of
#: h (m rad) over all previous intervals; constants of the antiderivatives of h cos and h sin, see `wear_moments_at`.
CONSTANT, LINEAR, QUADRATIC, CUBIC, INTEGRAL_BEFORE, COSINE_CONSTANT, SINE_CONSTANT, ROW_LENGTH = range(8)
MAX_FIT_STEPS = 20 * KNOTS  # of the active set; it takes about as many as there are knots in conformal contact


SMOOTHING_WIDTH = math.radians(2.0)  # standard deviation of the Gaussian for a force at one point, at least
WIDENING_FACTOR = 1.1  # factor on this width in each attempt to make the difference large enough
CONFORMAL_WIDTH = math.radians(1.0)  # standard deviation of the Gaussian for an arc of any width
#: clearances: minimum difference of the radii of curvature.  Surfaces that have run in differ by 0; above 0 they still
#: overlap on one arc alone.
POINT_MARGIN, CONFORMAL_MARGIN = 0.1, 2e-4


class Shape(NamedTuple):
    """Wear depth of a body, by the angle in its frame."""

    table: float  # address of (KNOTS, ROW_LENGTH)
    min_depth: float  # m, of h
    max_depth: float  # m
    max_slope: float  # m/rad, of |h'|
    max_curvature: float  # m/rad^2, largest -h''
    min_radius_change: float  # m, least h + h''
    integral: float  # m rad, integral of h over the circumference
    cosine_integral: float  # m rad, integral of h cos over the circumference
    sine_integral: float  # m rad


def smooth_depths(depths: np.ndarray, width: float) -> np.ndarray:
    """Return h (KNOTS,) m around a body from mean depths of bins (m), smoothed by a Gaussian of `width` (rad)."""
    count = len(depths)
    orders = np.arange(min(count, KNOTS) // 2)  # of harmonics; higher ones would alias
    angles = math.pi * orders / count
    cosines, sines, bins = portable.cos(angles), portable.sin(angles), np.fft.rfft(depths)[: orders.size]
    # numpy multiplies complex numbers with other bits where a processor has no fused operations
    spectrum = bins.real * cosines + bins.imag * sines + 1j * (bins.imag * cosines - bins.real * sines)
    bin_mean_factor = np.append(1.0, sines[1:] / angles[1:])
    filtered = spectrum / bin_mean_factor * portable.exp(-0.5 * (orders * width) ** 2)
    values: np.ndarray = np.fft.irfft(filtered, KNOTS) * (KNOTS / count)
    return values


def spline_through(values: np.ndarray) -> "CubicSpline":
    """Return the periodic cubic spline (m) of the angle (rad) through KNOTS values around a body."""
    from scipy.interpolate import CubicSpline

    return CubicSpline(np.arange(KNOTS + 1) * KNOT_SPACING, np.append(values, values[0]), bc_type="periodic")


@functools.cache
def second_derivatives() -> np.ndarray:
    """Return the (KNOTS, KNOTS) matrix (1/rad^2) from values at the knots to second derivatives of their spline."""
    cosines = portable.cos(np.arange(KNOTS // 2 + 1) * KNOT_SPACING)
    column = np.fft.irfft(12.0 * (cosines - 1.0) / (KNOT_SPACING**2 * (4.0 + 2.0 * cosines)), KNOTS)
    knots = np.arange(KNOTS)
    matrix: np.ndarray = column[(knots[:, None] - knots) % KNOTS]
    return matrix


def fit_profile(values: np.ndarray, least: float) -> np.ndarray:
    """Return the profile (KNOTS,) nearest to `values` (m) whose spline q has q + q'' >= `least` (m) at all knots.

    Nearest by the sum of squares, among profiles of the same mean.  (Lawson & Hanson 1974, Solving Least Squares
    Problems, chapter 23: least distance programming.)
    """
    operator = second_derivatives() + np.eye(KNOTS)
    shortfall = least - portable.product(operator, values)
    if shortfall.max() <= 0.0:
        return values
    from scipy.optimize import nnls

    unit, scale = float(shortfall.max()), abs(float(operator[0, 0]))
    rows = (operator - 1.0 / KNOTS) / scale  # without its mean, a change moves no volume
    system = np.vstack([rows.T, shortfall[None] / unit])
    target = np.append(np.zeros(KNOTS), 1.0)
    # the library only finds which multipliers are positive, as its last bits depend on the processor
    positive = system[:, nnls(system, target, maxiter=MAX_FIT_STEPS)[0] > 0.0]
    squares, residual = portable.product(positive.T, positive), -target
    for _ in range(2):  # the second time for what the condition of the squares has cost
        change = portable.solve(squares, portable.product(positive.T, residual))
        residual = residual - portable.product(positive, change)
    return values - (unit / scale) * residual[:-1] / residual[-1]


def point_profiles(
    bearing: np.ndarray, journal: np.ndarray, clearance: float
) -> tuple[tuple[np.ndarray, np.ndarray], float]:
    """Return the profiles (KNOTS,) m for a force at one point from the mean depths of bins (m), and the width (rad)."""
    width = SMOOTHING_WIDTH
    while True:
        profiles = smooth_depths(bearing, width), smooth_depths(journal, width)
        if clearance + sum(least_radius_change(profile) for profile in profiles) >= POINT_MARGIN * clearance:
            return profiles, width
        width *= WIDENING_FACTOR


def conformal_profiles(bearing: np.ndarray, journal: np.ndarray, clearance: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the profiles (KNOTS,) m of both bodies for an arc of any width from the mean depths of their bins (m)."""
    smooth = [smooth_depths(bins, CONFORMAL_WIDTH) for bins in (bearing, journal)]
    least = [least_radius_change(profile) for profile in smooth]
    bounds = least_radius_changes(least[0], least[1], (CONFORMAL_MARGIN - 1.0) * clearance)
    return fit_profile(smooth[0], bounds[0]), fit_profile(smooth[1], bounds[1])


def least_radius_change(profile: np.ndarray) -> float:
    """Return the least h + h'' (m) at the knots of a profile (KNOTS,) m."""
    return float(np.min(profile + portable.product(second_derivatives(), profile)))


def bin_means(profile: np.ndarray, count: int) -> np.ndarray:
    """Return the mean depths (m) of `count` bins of a profile (KNOTS,) m."""
    edges = np.linspace(0.0, 2.0 * math.pi, count + 1)
    means: np.ndarray = np.diff(spline_through(profile).antiderivative()(edges)) * (count / (2.0 * math.pi))
    return means


def least_radius_changes(bearing: float, journal: float, bound: float) -> tuple[float, float]:
    """Return bounds (m) of the radius changes of both bodies, whose sum is `bound`, from the least of each (m).

    A body whose radius of curvature grows everywhere gives its share to the other; else both share alike.
    """
    if bearing + journal >= bound:
        return bearing, journal
    if max(bearing, journal) >= 0.0:
        return (bearing, bound - bearing) if bearing >= journal else (bound - journal, journal)
    share = bound / (bearing + journal)
    return share * bearing, share * journal


def shape_of(values: np.ndarray) -> Shape:
    """Return the Shape of the spline through KNOTS values (m) around the body."""
    spline = spline_through(values)
    table = np.empty((KNOTS, ROW_LENGTH))
    for power in range(4):
        table[:, power] = spline.c[3 - power] * KNOT_SPACING**power
    interval_integrals = KNOT_SPACING * sum(table[:, power] / (power + 1.0) for power in range(INTEGRAL_BEFORE))
    table[:, INTEGRAL_BEFORE] = np.concatenate([[0.0], np.cumsum(interval_integrals)[:-1]])
    third_derivative = 6.0 * spline.c[0]
    jumps, knots = third_derivative - np.roll(third_derivative, 1), np.arange(KNOTS) * KNOT_SPACING
    cosine_jumps, sine_jumps = jumps * portable.cos(knots), jumps * portable.sin(knots)
    table[1:, COSINE_CONSTANT], table[1:, SINE_CONSTANT] = np.cumsum(cosine_jumps[1:]), np.cumsum(sine_jumps[1:])
    table[0, COSINE_CONSTANT:] = 0.0
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
        float(cosine_jumps.sum()),
        float(sine_jumps.sum()),
    )


require("profile")  # no compiled family: its table is computed before compiling


@maker("profile")
def _profile_recipe(own: Own, description: Law) -> Recipe:
    """Return the recipe of a bearing's shape: h as of wear, but of either sign.  The function runs as Python."""

    def bound(joint):
        return functools.partial(own.evaluate, own.parameters(joint.profile.values))

    def make(joint):
        depth = bound(joint)
        return shape_of(np.array([depth(float(knot)) for knot in np.arange(KNOTS) * KNOT_SPACING]))

    def check(joint):
        depth, turn = checked(bound(joint), ("angle",), own.place), 2.0 * math.pi
        angles = np.linspace(0.0, turn, 8 * KNOTS + 1)
        depths = np.array([depth(float(angle)) for angle in angles])
        span, jump = np.ptp(depths), abs(depths[-1] - depths[0])
        if jump > 1e-6 * max(span, abs(depths).max()):
            raise InputError(f"{own.place}: jumps by {jump:.4g} m from angle 2 pi to angle 0; the bearing is closed")
        least = float(depths.min())
        if joint.clearance + least <= 0.0:
            raise InputError(
                f"{own.place}: is {least:.4g} m at {angles[depths.argmin()]:.4g} rad, more than the clearance of "
                f"{joint.clearance:.4g} m: the journal in the middle would not fit"
            )
        change = least_radius_change(depths[:-1:8])
        if joint.clearance + change < POINT_MARGIN * joint.clearance:
            raise InputError(
                f"{own.place}: the journal would touch at two places: clearance plus h + h'' falls to "
                f"{joint.clearance + change:.4g} m; it must stay above {POINT_MARGIN * joint.clearance:.4g} m, a tenth "
                "of the clearance"
            )
        error = float(np.abs(spline_through(depths[:-1:8])(angles) - depths).max())
        is_fine = error <= 1e-2 * span + 1e-6 * joint.clearance
        return () if is_fine else (f"{own.place}: {KNOTS} points miss its details by up to {error:.4g} m",)

    return Recipe(description, (Shape,), make, check=check)


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
    a, b, c, d = load_items(table, offset + CONSTANT, INTEGRAL_BEFORE)
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
    a, b, c, d = load_items(shape.table, offset + CONSTANT, INTEGRAL_BEFORE)
    turns = math.floor(position * (1.0 / KNOTS))
    integral_in_interval = x * (a + x * (0.5 * b + x * (c * (1.0 / 3.0) + x * (0.25 * d)))) * KNOT_SPACING
    return load_item(shape.table, offset + INTEGRAL_BEFORE) + integral_in_interval + turns * shape.integral


@inlined
def wear_moments_at(shape, angle, body_angle):
    """Return antiderivatives (m rad) of h cos and h sin of the angle in space; angles : rad, in space, of the body.

    On an interval h is a cubic, whose antiderivatives are, at the angle t in the frame of the body,

        h sin t + h' cos t - h'' sin t - h''' cos t,   -h cos t + h' sin t + h'' cos t - h''' sin t .

    They jump with h''' at every knot; the constants of the table cancel these jumps.
    """
    in_body = angle - body_angle
    h, slope, second_derivative, third_derivative = wear_depth_at(shape.table, in_body)
    position = in_body * KNOTS_PER_RADIAN
    _, offset = locate_interval(position)
    turns = math.floor(position * (1.0 / KNOTS))
    parallel, across = h - second_derivative, slope - third_derivative
    c, s = direction(in_body)
    cosine_part = parallel * s + across * c + load_item(shape.table, offset + COSINE_CONSTANT)
    sine_part = across * s - parallel * c + load_item(shape.table, offset + SINE_CONSTANT)
    cosine_part, sine_part = cosine_part + turns * shape.cosine_integral, sine_part + turns * shape.sine_integral
    c, s = direction(body_angle)
    return c * cosine_part - s * sine_part, s * cosine_part + c * sine_part
