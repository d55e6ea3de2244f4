"""The guards of joints, functions whose upward zero crossing changes a mode or a state: values and crossings."""

import math

from ..compiled.family import invoke, kernel
from ..observe.stages import END, NODES, SCRATCH, SHARES
from .accumulate.totals import PEAK
from .bernstein import (
    COEFFICIENTS,
    DEGREE,
    FINE,
    NOWHERE,
    VALUES,
    WHOLE,
    crossing_for_certain,
    from_values,
    value_and_slope,
)
from .event import IMPLICIT, evaluate_dense

ELSEWHERE = NODES.size  # place of a guard's value at a single state, after those at the nodes of a step
NEXT_TO_START = 0.125  # share of a step within which a guard passed at its start is ignored
#: Of the largest force of a contact: smaller forces count as zero.  After an impact with almost no rebound the force
#: approaches zero slowly, and its sign is rounding.
ROUNDING = 1e-13
RIGHT = 1e-12  # of the size of a guard: accuracy of the location
HALVING = 16  # evaluations after which the interval is bisected


@kernel
def evaluate_guards(at, y, row):
    """Write the values of all guards to `work.guards.value`.

    If `row` is END, these are the values at the state `y` at the start of the step, and at its stages.  Otherwise the
    values at ELSEWHERE are those at the state `y`, whose observables are in row `row`.
    """
    work, guards = at[0], at[0].guards
    for g in range(guards.contact.size):
        if guards.column[g] >= 0:
            if row == END:
                for m in range(NODES.size):
                    guards.value[g, m] = guards.sign[g] * work.o[guards.column[g], NODES[m]]
            else:
                guards.value[g, ELSEWHERE] = guards.sign[g] * work.o[guards.column[g], row]
    if guards.evaluate.code != 0:
        arguments = y, work.nodes, work.latched, work.o, guards.value
        invoke(guards.evaluate.code, guards.evaluate.parameters, arguments, row)


@kernel
def looked_at(at, g):
    """Return whether guard `g` is active in the current mode of its contact."""
    guards = at[0].guards
    return guards.modes[g] >> at[0].mode[guards.contact[g]] & 1 != 0


@kernel
def take_guard(at, g):
    """Set the polynomial of guard `g` from its values at the nodes; return whether it can be passed."""
    p, value = at[0].polynomials, at[0].guards.value
    if not (value[g, 0] > -math.inf and value[g, DEGREE] > -math.inf):
        return False
    for m in range(COEFFICIENTS):
        p[VALUES, m] = value[g, m]
    from_values(p)
    return True


@kernel
def guard_value(at, g, x):
    """Return the value of guard `g` at the share `x` of the step, from the interpolant."""
    evaluate_dense(at, x)
    evaluate_guards(at, at[0].z, SCRATCH)
    return at[0].guards.value[g, ELSEWHERE]


@kernel
def first_passage(at, g):
    """Return the share of the step at which guard `g` becomes positive, or NOWHERE."""
    p, guards = at[0].polynomials, at[0].guards
    if not take_guard(at, g):
        return NOWHERE
    noise = ROUNDING * at[0].totals.joint[guards.contact[g], PEAK] if guards.column[g] >= 0 else 0.0
    if p[VALUES, 0] >= 0.0 and value_and_slope(p, WHOLE, NEXT_TO_START)[0] > noise:
        return 0.0
    x = crossing_for_certain(p, noise)
    return x if x == NOWHERE else true_passage(at, g, x)


@kernel
def true_passage(at, g, x):
    """Return where guard `g` itself crosses zero, near the crossing of its polynomial at the share `x`, or NOWHERE.

    Many guards are smooth, and one evaluation confirms the polynomial.  Others are not, such as the force of a contact
    that
    leaves its indentation, which varies with a power of 3/2 there.
    """
    p, size = at[0].polynomials, 0.0
    for m in range(COEFFICIENTS):
        size = max(size, abs(p[VALUES, m]))
    for _ in range(3):
        value = guard_value(at, g, x)
        if abs(value) <= RIGHT * size:
            return x
        _, slope = value_and_slope(p, WHOLE, x)
        newton = x - value / slope if slope > 0.0 else -1.0
        if not 0.0 <= newton <= 1.0:
            break
        x = newton
    value = guard_value(at, g, x)
    (a, fa), (b, fb) = ends_around(at, x, value)
    if fb <= 0.0:  # it rises and falls between two stages
        b = top_behind(p, x)
        fb = guard_value(at, g, b)
        if fb <= 0.0:
            return NOWHERE
    return crossing_between(at, g, (a, fa), (b, fb))


@kernel
def ends_around(at, x, value):
    """Return (share, value) of a guard before and behind where it is likely to pass zero, its `value` at `x` known."""
    p = at[0].polynomials
    (a, fa), (b, fb) = (0.0, p[VALUES, 0]), (1.0, p[VALUES, DEGREE])
    if at[0].method[0] != IMPLICIT:  # whose values between start and end are interpolated themselves
        for m in range(1, COEFFICIENTS):
            if SHARES[m] <= x and p[VALUES, m] < 0.0:
                a, fa = SHARES[m], p[VALUES, m]
        for m in range(DEGREE, 0, -1):
            if SHARES[m] > a and p[VALUES, m] > 0.0:
                b, fb = SHARES[m], p[VALUES, m]
    if a < x < b and value < 0.0:
        a, fa = x, value
    elif a < x < b:
        b, fb = x, value
    return (a, fa), (b, fb)


@kernel
def top_behind(p, x):
    """Return where WHOLE is highest, of several places between `x` and its next negative value."""
    largest, top, step = x, 0.0, 0.02 * (1.0 - x)
    for i in range(1, 51):
        value, _ = value_and_slope(p, WHOLE, x + i * step)
        if value <= 0.0:
            break
        if value > top:
            largest, top = x + i * step, value
    return largest


@kernel
def crossing_between(at, g, lower, upper):
    """Return the share at which guard `g` crosses zero between two ends, each (share, value), approached from behind.

    Regula falsi by Anderson & Bjorck (1973, BIT 13:253): the value at a retained end is scaled down according to the
    change
    of the value at the other end.
    """
    (a, fa), (b, fb) = lower, upper
    if fa >= 0.0:
        return a
    side = 0
    for iteration in range(64):
        x = (a * fb - b * fa) / (fb - fa)
        if iteration > HALVING or not a < x < b:  # a jump, or a value that is not finite
            x = 0.5 * (a + b)
        x = min(max(x, a + 0.4 * FINE), b - 0.4 * FINE)  # so that the retained end moves, too
        fx = guard_value(at, g, x)
        if fx >= 0.0:
            if side == 1:
                fa *= 1.0 - fx / fb if fx < fb else 0.5
            b, fb, side = x, fx, 1
        else:
            if side == -1:
                fb *= 1.0 - fx / fa if fx > fa else 0.5
            a, fa, side = x, fx, -1
        if b - a <= FINE or fx == 0.0:
            break
    return b
