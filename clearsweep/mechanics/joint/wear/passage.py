"""A contact arc over a step: it grows, shrinks and travels, and leaves wear in the bins of a body.

The load of the arc that lies before the edge of a bin is integrated over the step for every edge that the arc meets.
What a bin is worn by is the difference between its edges, so it is the mean over the bin whatever its width.  An edge
that an end of the arc passes has its integral cut there, as the pressure is not smooth at the ends of the arc.
"""

import math
from typing import NamedTuple

import numpy as np

from ...compiled.family import inlined, kernel
from ...observe.histogram import COURSES, DEPTH_COURSE, FORCE, KAPPA_COURSE, PARTS, SLIP_COURSE
from .contract import Rubbing, half_arc, share_before, smooth_within, wear_rate

DEGREE = 6  # of the polynomials over the share of the step, as many as its stages give
ON_BEARING, ON_JOURNAL, ROWS = COURSES, COURSES + 1, COURSES + 2  # angles, after the courses
#: (DEGREE + 1, PARTS + 1): what gives the coefficients from values at even places of the step.
FIT = np.linalg.pinv(np.vander(np.arange(PARTS + 1) / PARTS, DEGREE + 1, increasing=True))
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(7)
NODES, WEIGHTS = 0.5 * (_NODES + 1.0), 0.5 * _WEIGHTS  # of Gauss's rule on 0 to 1
#: What gives the coefficients of a polynomial from its values at the NODES times the WEIGHTS.
RATES = np.linalg.inv(np.vander(NODES, increasing=True)) / WEIGHTS
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(8)
_NODES, _WEIGHTS = 0.5 * (_NODES + 1.0), 0.5 * _WEIGHTS
#: After x = u^2 (3 - 2 u), in which the load is smooth at the ends of the arc, where it goes with x^(3/2).
SOFT_NODES, SOFT_WEIGHTS = _NODES**2 * (3.0 - 2.0 * _NODES), 6.0 * _NODES * (1.0 - _NODES) * _WEIGHTS
POINTS = NODES.size + 2
#: (POINTS, POINTS): what gives the coefficients of a polynomial from its values at both ends and the NODES.
FROM_POINTS = np.linalg.inv(np.vander(np.concatenate([[0.0], NODES, [1.0]]), increasing=True))
#: Rows of what is known at both ends and the nodes between: of the joint, then of the body at hand; then the
#: coefficients over the share of the points' reach of what is worn off per such share, and of half the arc.
SHARE, LOAD, PEN, SLIDING, PACE, ANGLE, HALF, AREA, RATE, COURSE_OF_HALF, POINT_ROWS = range(11)
FAINT = 1e-300  # rad, for an arc without width
MARGIN = 0.01  # of the angle that is swept: it may be a little more between two nodes


class Passage(NamedTuple):
    """A step in which one body is worn."""

    row: int  # ON_BEARING or ON_JOURNAL
    radius: float  # m, of the body
    length: float  # of the step, in the unit of kappa
    polynomials: np.ndarray  # (ROWS, DEGREE + 1) coefficients over the share of the step; FORCE per length of the joint
    points: np.ndarray  # (POINT_ROWS, POINTS) room
    edges: np.ndarray  # (FINEST,) room, m rad, what is worn before edges that stay well within the arc


class Bins(NamedTuple):
    """Where the wear of a body is entered."""

    depths: np.ndarray  # (joints, 2, stride) m, mean depth of each bin, flat
    first: int
    count: int


@inlined
def value(polynomials, row, x):
    """Return the polynomial of a row at the share `x` of the step."""
    total = polynomials[row, DEGREE]
    for i in range(DEGREE - 1, -1, -1):
        total = total * x + polynomials[row, i]
    return total


@inlined
def rubbing_at(passage, x):
    """Return the Rubbing at the share `x` of the step."""
    p = passage.polynomials
    return Rubbing(max(value(p, FORCE, x), 0.0), value(p, DEPTH_COURSE, x), abs(value(p, SLIP_COURSE, x)))


@inlined
def worn_until(points, x):
    """Return what is worn off from the first to the share `x` of the step, m rad: the polynomial through the nodes."""
    reach = points[SHARE, POINTS - 1] - points[SHARE, 0]
    u, total = (x - points[SHARE, 0]) / reach, 0.0
    for i in range(NODES.size - 1, -1, -1):
        total = total * u + points[RATE, i] / (i + 1.0)
    return total * u


@inlined
def worn_at(points, u):
    """Return what is worn off per share of the `points`' reach at the share `u` of it, m rad."""
    total = 0.0
    for i in range(NODES.size - 1, -1, -1):
        total = total * u + points[RATE, i]
    return total


@inlined
def half_at(points, u):
    """Return half the arc (rad) at the share `u` of the points' reach: the polynomial through all points."""
    total = 0.0
    for i in range(POINTS - 1, -1, -1):
        total = total * u + points[COURSE_OF_HALF, i]
    return max(total, FAINT)


@inlined
def side_of(offset, half):
    """Return -1 where an edge at the angle `offset` from the arc's middle lies before the arc, 1 behind it, 0 in it."""
    if offset <= -half:
        return -1
    return 1 if offset >= half else 0


@kernel
def end_passes(passage, edge, end, i):
    """Return the share of the step at which an end (-1, 1) of the arc is at `edge` (rad), between points `i - 1`, `i`.

    An error e of it changes the integral by e^(5/2): one step of regula falsi and a parabola through all three suffice.
    """
    points, row = passage.points, passage.row
    low, high = points[SHARE, i - 1], points[SHARE, i]
    a = edge - points[ANGLE, i - 1] - end * points[HALF, i - 1]
    b = edge - points[ANGLE, i] - end * points[HALF, i]
    if a == b:
        return low
    x = (low * b - high * a) / (b - a)
    u = (x - points[SHARE, 0]) / (points[SHARE, POINTS - 1] - points[SHARE, 0])
    c = edge - value(passage.polynomials, row, x) - end * half_at(points, u)
    if c in (a, b):
        return x
    x = low * b * c / ((a - b) * (a - c)) + high * a * c / ((b - a) * (b - c)) + x * a * b / ((c - a) * (c - b))
    return min(max(x, low), high)


@kernel
def before_edge(joint, passage, edge, low, high):
    """Return what the arc wears before `edge` between two shares of a step in which the edge stays within the arc."""
    total, pressure, points = 0.0, joint.wear.pressure, passage.points
    inverse = 1.0 / (points[SHARE, POINTS - 1] - points[SHARE, 0])
    start, length = (low - points[SHARE, 0]) * inverse, (high - low) * inverse
    for i in range(SOFT_NODES.size):
        x, u = low + (high - low) * SOFT_NODES[i], start + length * SOFT_NODES[i]
        offset = edge - value(passage.polynomials, passage.row, x)
        total += SOFT_WEIGHTS[i] * worn_at(points, u) * share_before(pressure, offset / half_at(points, u))
    return length * total


@kernel
def piece(joint, passage, edge, side, low, high):
    """Return what the arc wears before `edge` between two shares of a step in which the edge stays on one side."""
    if side < 0 or high <= low:
        return 0.0
    if side > 0:
        return worn_until(passage.points, high) - worn_until(passage.points, low)
    return before_edge(joint, passage, edge, low, high)


@kernel
def worn_before(joint, passage, edge):
    """Return what the arc wears before the angle `edge` (rad) between the ends of the `points`, m rad."""
    points, total, outside = passage.points, 0.0, True
    first = side_of(edge - points[ANGLE, 0], points[HALF, 0])
    for i in range(1, POINTS):
        side = side_of(edge - points[ANGLE, i], points[HALF, i])
        outside = outside and side == first
    if first != 0 and outside:
        for i in range(1, POINTS - 1):
            total += points[AREA, i] if first > 0 else 0.0
        return total
    side, low = first, points[SHARE, 0]
    for i in range(1, POINTS):
        now = side_of(edge - points[ANGLE, i], points[HALF, i])
        while side != now:
            end = side if side != 0 else now  # the end of the arc that passes the edge
            x = max(low, end_passes(passage, edge, end, i))
            total += piece(joint, passage, edge, side, low, x)
            low, side = x, (0 if side != 0 else now)
    return total + piece(joint, passage, edge, side, low, points[SHARE, POINTS - 1])


@kernel
def see_joint(joint, passage, low, high):
    """Put what presses and slides between two shares of a step into the `points`."""
    points = passage.points
    for i in range(POINTS):
        x = low if i == 0 else high if i == POINTS - 1 else low + (high - low) * NODES[i - 1]
        rubbing = rubbing_at(passage, x)
        points[SHARE, i], points[LOAD, i], points[PEN, i] = x, rubbing.line_load, rubbing.depth
        points[SLIDING, i] = rubbing.slip
        points[PACE, i] = passage.length * max(value(passage.polynomials, KAPPA_COURSE, x), 0.0)


@kernel
def see_body(joint, passage):
    """Put what the body sees of that into the `points`; return what it is worn by, m rad, and where arcs lie."""
    points, row = passage.points, passage.row
    reach = points[SHARE, POINTS - 1] - points[SHARE, 0]
    total, start, stop = 0.0, math.inf, -math.inf
    for i in range(POINTS):
        rubbing = Rubbing(points[LOAD, i], points[PEN, i], points[SLIDING, i])
        points[ANGLE, i] = value(passage.polynomials, row, points[SHARE, i])
        points[HALF, i] = half_arc(joint.wear.pressure, joint, passage.radius, rubbing)
        start = min(start, points[ANGLE, i] - points[HALF, i])
        stop = max(stop, points[ANGLE, i] + points[HALF, i])
        if 0 < i < POINTS - 1:
            bearing, journal = wear_rate(joint.wear, rubbing)
            area = bearing if row == ON_BEARING else journal
            points[AREA, i] = reach * WEIGHTS[i - 1] * points[PACE, i] * area / passage.radius
            total += points[AREA, i]
    for i in range(NODES.size):
        points[RATE, i] = 0.0
        for k in range(NODES.size):
            points[RATE, i] += RATES[i, k] * points[AREA, k + 1]
    for i in range(POINTS):
        points[COURSE_OF_HALF, i] = 0.0
        for k in range(POINTS):
            points[COURSE_OF_HALF, i] += FROM_POINTS[i, k] * points[HALF, k]
    return total, start, stop


@kernel
def enter_inner(joint, passage, width):
    """Put what is worn before edges that stay well within the arc into `edges`; return the first and the last of them.

    What is integrated is smooth there, so that all of them share the nodes: a loop that the compiler can vectorise.
    """
    points, edges, pressure = passage.points, passage.edges, joint.wear.pressure
    start, stop, within = -math.inf, math.inf, smooth_within(pressure)
    for i in range(POINTS):
        start = max(start, points[ANGLE, i] - within * points[HALF, i])
        stop = min(stop, points[ANGLE, i] + within * points[HALF, i])
    first, last = math.ceil(start / width), math.floor(stop / width)
    count = max(last - first + 1, 0)
    for k in range(count):
        edges[k] = 0.0
    if count > 0:
        for i in range(1, POINTS - 1):
            area, inverse = points[AREA, i], 1.0 / max(points[HALF, i], FAINT)
            begin = (first * width - points[ANGLE, i]) * inverse
            for k in range(count):
                edges[k] += area * share_before(pressure, begin + k * (width * inverse))
    return first, last


@kernel
def enter_part(joint, passage, bins):
    """Enter what the arc wears off the body between the ends of the `points`."""
    total, start, stop = see_body(joint, passage)
    if total <= 0.0:
        return
    width, before = 2.0 * math.pi / bins.count, 0.0
    margin = MARGIN * (stop - start)
    first, last = math.floor((start - margin) / width), math.floor((stop + margin) / width)
    low, high = enter_inner(joint, passage, width)
    for place in range(first, last + 1):
        up_to, edge = total, place + 1
        if place < last:
            inner = low <= edge <= high
            up_to = passage.edges[edge - low] if inner else worn_before(joint, passage, edge * width)
            up_to = min(max(up_to, before), total)
        bins.depths[bins.first + place % bins.count] += (up_to - before) / width
        before = up_to


@kernel
def enter_wear(joint, bodies, course, bins):
    """Enter what bearing and journal are worn by over a step.

    bodies, bins : of both; course : (COURSES, PARTS + 1), of which the sliding speed is read.
    """
    low = 0.0
    for i in range(PARTS + 1):
        high = 1.0
        if i < PARTS:
            a, b = course[SLIP_COURSE, i], course[SLIP_COURSE, i + 1]
            if a * b >= 0.0:
                continue
            high = (i + a / (a - b)) / PARTS  # where the sliding turns, its speed has a kink
        see_joint(joint, bodies[0], low, high)
        for body in range(2):
            enter_part(joint, bodies[body], bins[body])
        low = high
