"""Search for the first event of a step: an onset, a separation, a limit, a guard of a joint's law, or a stop.

Every event is an upward zero crossing of an event function.  Over the step that function is represented by a
polynomial through its values at the start and the stages.  Its Bernstein coefficients bound it, so that no rise and
fall between two stages is missed, see `collocation`.  The guards of joints, whose upward crossing changes a mode or a
state, are event functions, too.
"""

import math

from ...tracing.compiled.family import invoke, kernel
from ..laws.contract import meets, touches
from ..observe import DEPTH, END, KAPPA, NODE_FRACTIONS, NODES, RATE, SCRATCH, SLIP, START, column_of
from .collocation import (
    COEFFICIENTS,
    CROSSING_TOLERANCE,
    DEGREE,
    NO_CROSSING,
    VALUES,
    WHOLE,
    error_bound,
    find_certain_crossing,
    find_first_crossing,
    find_minimum,
    lower_bound,
    negate,
    set_from_interpolant,
    set_from_values,
    upper_bound,
    value_and_slope,
)
from .integration import GUARD, IMPLICIT, LIMIT, NOTHING, ONSET, SEPARATION, STOP, evaluate_dense

SINGLE_STATE = NODES.size  # index of a guard's value at a single state, after those at the nodes of a step
START_FRACTION = 0.125  # fraction of a step within which a guard passed at its start is ignored
#: Of the largest force of a contact: smaller forces count as zero.  After an impact with almost no rebound the force
#: approaches zero slowly, and its sign is rounding.
FORCE_ROUNDING = 1e-13
GUARD_TOLERANCE = 1e-12  # of the size of a guard: accuracy of the location
BISECTION_START = 16  # evaluations after which the interval is bisected
SPEED_MARGIN = 1.2  # factor on the largest speed at the stages that bounds the speed between them
ROUGH_ERROR = 1e-3  # error bound of a gap's polynomial, relative to its size, from which the step is searched in parts
MIN_PART = 1.0 / 16.0  # of a step: shortest part
#: Of a step: largest correction of an onset by Newton's method, and its tolerance.
MAX_ONSET_CORRECTION, ONSET_TOLERANCE = 0.05, 1e-7
LIMIT_TOLERANCE = 1e-9  # of the root of a penetration: a step that begins this close to a limit has just passed it


@kernel
def evaluate_guards(pointer, y, row):
    """Write the values of the guards to `work.guards.value`; of those that are observables, only of active ones.

    If `row` is END, these are the values at the state `y` at the start of the step, and at its stages.  Otherwise the
    values at SINGLE_STATE are those at the state `y`, whose observables are in row `row`.
    """
    work, guards = pointer[0], pointer[0].guards
    for g in range(guards.contact.size):
        if guards.column[g] >= 0:
            if row == END and is_guard_active(pointer, g):
                for m in range(NODES.size):
                    guards.value[g, m] = guards.sign[g] * work.o[guards.column[g], NODES[m]]
            elif row != END:
                guards.value[g, SINGLE_STATE] = guards.sign[g] * work.o[guards.column[g], row]
    if guards.evaluate.code != 0:
        arguments = work.y, y, work.nodes, work.latched, work.o, guards.value
        invoke(guards.evaluate.code, guards.evaluate.parameters, arguments, row)


@kernel
def is_guard_active(pointer, g):
    """Return whether guard `g` is active in the current mode of its contact."""
    guards = pointer[0].guards
    return guards.modes[g] >> pointer[0].mode[guards.contact[g]] & 1 != 0


@kernel
def fit_guard(pointer, g):
    """Set the polynomial of guard `g` from its values at the nodes; return whether it can be passed."""
    p, value = pointer[0].polynomials, pointer[0].guards.value
    if not (value[g, 0] > -math.inf and value[g, DEGREE] > -math.inf):
        return False
    for m in range(COEFFICIENTS):
        p[VALUES, m] = value[g, m]
    set_from_values(p)
    return True


@kernel
def guard_value(pointer, g, x):
    """Return the value of guard `g` at the fraction `x` of the step, from the interpolant."""
    evaluate_dense(pointer, x)
    evaluate_guards(pointer, pointer[0].z, SCRATCH)
    return pointer[0].guards.value[g, SINGLE_STATE]


@kernel
def find_passage(pointer, g):
    """Return the fraction of the step at which guard `g` becomes positive, or NO_CROSSING."""
    p, guards = pointer[0].polynomials, pointer[0].guards
    if not fit_guard(pointer, g):
        return NO_CROSSING
    noise = FORCE_ROUNDING * pointer[0].totals.joint[guards.contact[g]].peak if guards.column[g] >= 0 else 0.0
    if p[VALUES, 0] >= 0.0 and value_and_slope(p, WHOLE, START_FRACTION)[0] > noise:
        return 0.0
    x = find_certain_crossing(p, noise)
    return x if x == NO_CROSSING else refine_passage(pointer, g, x)


@kernel
def refine_passage(pointer, g, x):
    """Return the fraction at which guard `g` crosses zero, near the crossing `x` of its polynomial, or NO_CROSSING.

    Many guards are smooth, and one evaluation confirms the polynomial.  Others are not, such as the force of a contact
    that leaves its indentation, which varies with a power of 3/2.
    """
    p, size = pointer[0].polynomials, 0.0
    for m in range(COEFFICIENTS):
        size = max(size, abs(p[VALUES, m]))
    for _ in range(3):
        value = guard_value(pointer, g, x)
        if abs(value) <= GUARD_TOLERANCE * size:
            return x
        _, slope = value_and_slope(p, WHOLE, x)
        newton = x - value / slope if slope > 0.0 else -1.0
        if not 0.0 <= newton <= 1.0:
            break
        x = newton
    value = guard_value(pointer, g, x)
    (a, fa), (b, fb) = bracket_passage(pointer, x, value)
    if fb <= 0.0:  # it rises and falls between two stages
        b = find_maximum_after(p, x)
        fb = guard_value(pointer, g, b)
        if fb <= 0.0:
            return NO_CROSSING
    return find_crossing_between(pointer, g, (a, fa), (b, fb))


@kernel
def bracket_passage(pointer, x, value):
    """Return (fraction, value) of a guard before and after its likely zero near `x`, where it equals `value`."""
    p = pointer[0].polynomials
    (a, fa), (b, fb) = (0.0, p[VALUES, 0]), (1.0, p[VALUES, DEGREE])
    if pointer[0].method.current != IMPLICIT:  # whose values between start and end are interpolated themselves
        for m in range(1, COEFFICIENTS):
            if NODE_FRACTIONS[m] <= x and p[VALUES, m] < 0.0:
                a, fa = NODE_FRACTIONS[m], p[VALUES, m]
        for m in range(DEGREE, 0, -1):
            if NODE_FRACTIONS[m] > a and p[VALUES, m] > 0.0:
                b, fb = NODE_FRACTIONS[m], p[VALUES, m]
    if a < x < b and value < 0.0:
        a, fa = x, value
    elif a < x < b:
        b, fb = x, value
    return (a, fa), (b, fb)


@kernel
def find_maximum_after(p, x):
    """Return the fraction of the largest of several values of WHOLE between `x` and its next negative value."""
    x_of_maximum, largest, step = x, 0.0, 0.02 * (1.0 - x)
    for i in range(1, 51):
        value, _ = value_and_slope(p, WHOLE, x + i * step)
        if value <= 0.0:
            break
        if value > largest:
            x_of_maximum, largest = x + i * step, value
    return x_of_maximum


@kernel
def find_crossing_between(pointer, g, lower, upper):
    """Return the fraction just after guard `g` crosses zero in a bracket; `lower`, `upper` : (fraction, value).

    Regula falsi by Anderson & Bjorck (1973, BIT 13:253): the value at a retained end is scaled down according to the
    change of the value at the other end.
    """
    (a, fa), (b, fb) = lower, upper
    if fa >= 0.0:
        return a
    side = 0
    for iteration in range(64):
        x = (a * fb - b * fa) / (fb - fa)
        if iteration > BISECTION_START or not a < x < b:  # a jump, or a value that is not finite
            x = 0.5 * (a + b)
        x = min(
            max(x, a + 0.4 * CROSSING_TOLERANCE), b - 0.4 * CROSSING_TOLERANCE
        )  # so that the retained end moves, too
        fx = guard_value(pointer, g, x)
        if fx >= 0.0:
            if side == 1:
                fa *= 1.0 - fx / fb if fx < fb else 0.5
            b, fb, side = x, fx, 1
        else:
            if side == -1:
                fb *= 1.0 - fx / fa if fx > fa else 0.5
            a, fa, side = x, fx, -1
        if b - a <= CROSSING_TOLERANCE or fx == 0.0:
            break
    return b


@kernel
def fit_gap(pointer, j, h):
    """Fit the gap polynomial of contact `j` in free flight to the depths at the nodes; it is positive where it touches.

    The fitted function is d (d + 2 s) of the depth d (m) and the largest size s (m) of d.  In a bearing it is the
    squared eccentricity minus the squared clearance, which is smooth at the centre of the bearing, where d has a kink.
    """
    work, column = pointer[0], column_of(j, DEPTH)
    p, size = work.polynomials, work.clearance[j]
    for m in range(COEFFICIENTS):
        size = max(size, -work.o[column, NODES[m]])
    for m in range(COEFFICIENTS):
        depth = work.o[column, NODES[m]]
        p[VALUES, m] = depth * (depth + 2.0 * size)
    set_from_values(p)
    depth_rate = work.o[column_of(j, RATE), START] * work.o[KAPPA, START] * h
    p[WHOLE, 1] = (
        p[WHOLE, 0] + 2.0 * (work.o[column, START] + size) * depth_rate / DEGREE
    )  # its slope is known at the start


@kernel
def fit_gap_part(pointer, j, begin, width):
    """Set the polynomial of contact `j` over a part of the step, from the interpolant."""
    work, column = pointer[0], column_of(j, DEPTH)
    p, size = work.polynomials, work.clearance[j]
    for m in range(COEFFICIENTS):
        evaluate_dense(pointer, begin + width * NODE_FRACTIONS[m])
        p[VALUES, m] = work.o[column, SCRATCH]
        size = max(size, -p[VALUES, m])
    for m in range(COEFFICIENTS):
        p[VALUES, m] *= p[VALUES, m] + 2.0 * size
    set_from_values(p)


@kernel
def is_rough(p):
    """Return whether the error of WHOLE matters at its possible zeros."""
    size = 0.0
    for i in range(COEFFICIENTS):
        size = max(size, abs(p[VALUES, i]))
    error = error_bound(p)
    return error > ROUGH_ERROR * size and upper_bound(p) + error >= 0.0


@kernel
def cannot_reach_bearing(pointer, j, h):
    """Return whether the path of the journal of free contact `j` is too short to reach the bearing."""
    work = pointer[0]
    fastest = max(work.contact_steps[j].fastest, work.o[column_of(j, SLIP), END] * work.o[KAPPA, END])
    gaps = work.o[column_of(j, DEPTH), START] + work.o[column_of(j, DEPTH), END]
    return gaps + SPEED_MARGIN * h * fastest < 0.0


@kernel
def find_onset(pointer, j, h):
    """Return the fraction of the step at which free contact `j` first touches its bearing, or NO_CROSSING."""
    work = pointer[0]
    p, start_depth = work.polynomials, work.o[column_of(j, DEPTH), START]
    if cannot_reach_bearing(pointer, j, h):
        return NO_CROSSING
    if start_depth >= 0.0 and work.o[column_of(j, RATE), START] >= 0.0:
        return 0.0
    fit_gap(pointer, j, h)
    if is_rough(p):
        return find_onset_in_parts(pointer, j, h)
    x = find_certain_crossing(p, 0.0)
    if x == NO_CROSSING and start_depth >= 0.0 and p[VALUES, DEGREE] >= 0.0:  # it never quite separated
        return find_minimum(p)
    return x if x == NO_CROSSING else refine_onset(pointer, j, h, x)


@kernel
def refine_onset(pointer, j, h, x):
    """Return the fraction of the step at which contact `j` touches, by Newton's method from the fraction `x`."""
    work = pointer[0]
    for _ in range(4):
        evaluate_dense(pointer, x)
        slope = work.o[column_of(j, RATE), SCRATCH] * work.o[KAPPA, SCRATCH] * h
        correction = work.o[column_of(j, DEPTH), SCRATCH] / slope if slope != 0.0 else 1.0
        if not abs(correction) < MAX_ONSET_CORRECTION:  # nearly tangential
            break
        x = min(max(x - correction, 0.0), 1.0)
        if abs(correction) <= ONSET_TOLERANCE:
            break
    return x


@kernel
def find_onset_in_parts(pointer, j, h):
    """Return the result of `find_onset` if the gap is not smooth over the step, as with worn surfaces."""
    p, begin, width = pointer[0].polynomials, 0.0, 0.5
    while begin < 1.0:
        fit_gap_part(pointer, j, begin, width)
        if width > MIN_PART and is_rough(p):
            width *= 0.5
        else:
            x = find_certain_crossing(p, 0.0)
            if x != NO_CROSSING:
                return refine_onset(pointer, j, h, begin + width * x)
            begin += width
            width = min(2.0 * width, 1.0 - begin)
    return NO_CROSSING


@kernel
def find_separation(pointer, j):
    """Return the fraction of the step at which contact `j` separates, from the interpolant, or NO_CROSSING."""
    work, root = pointer[0], pointer[0].time + 1 + j
    set_from_interpolant(work.polynomials, work.y[root], work.f, root)
    if lower_bound(work.polynomials) > 0.0:
        return NO_CROSSING
    negate(work.polynomials)
    return find_first_crossing(work.polynomials)


@kernel
def find_limit(pointer, j):
    """Return the fraction at which contact `j` passes the depth limit of its elastic law, or NO_CROSSING."""
    work, root = pointer[0], pointer[0].time + 1 + j
    limit = math.sqrt(work.limit_depth[j])
    set_from_interpolant(work.polynomials, work.y[root] - limit, work.f, root)
    overshoot = work.y[root] - limit
    if overshoot > LIMIT_TOLERANCE * limit or (overshoot > -LIMIT_TOLERANCE * limit and work.k[root, START] > 0.0):
        negate(work.polynomials)
    return find_first_crossing(work.polynomials) if upper_bound(work.polynomials) >= 0.0 else NO_CROSSING


@kernel
def find_stop(pointer, stop):
    """Return the fraction of the step at which the run reaches `stop`, which is not beyond its end."""
    work = pointer[0]
    if work.y[work.independent] >= stop:  # another event was just there, within rounding
        return 0.0
    set_from_interpolant(work.polynomials, work.y[work.independent] - stop, work.f, work.independent)
    return min(find_first_crossing(work.polynomials), 1.0)


@kernel
def has_passed(pointer, stop, x):
    """Return whether the run is beyond `stop` at the fraction `x` of a step that does not end beyond it.

    Behind the separation of a contact time runs back, see `coupling.rates`.
    """
    work = pointer[0]
    if work.end[work.independent] >= stop:
        return False
    set_from_interpolant(work.polynomials, work.y[work.independent] - stop, work.f, work.independent)
    return value_and_slope(work.polynomials, WHOLE, x)[0] >= 0.0


@kernel
def locate_first_event(pointer, h, stop):
    """Return (fraction of the step, kind, contact) of its first event; kind is NOTHING without event."""
    work, guards = pointer[0], pointer[0].guards
    earliest, kind, contact = NO_CROSSING, NOTHING, 0
    if work.end[work.independent] >= stop:
        earliest, kind = find_stop(pointer, stop), STOP
    for j in range(work.mode.size):
        x, event_kind = NO_CROSSING, NOTHING
        if meets(work.mode[j]):
            x, event_kind = find_onset(pointer, j, h), ONSET
        elif touches(work.mode[j]):
            x, event_kind = find_separation(pointer, j), SEPARATION
            if work.limit_depth[j] < math.inf:
                limit_fraction = find_limit(pointer, j)
                if limit_fraction < x:
                    x, event_kind = limit_fraction, LIMIT
        if x < earliest:
            earliest, kind, contact = x, event_kind, j
    if guards.contact.size > 0:
        evaluate_guards(pointer, work.y, END)
        for g in range(guards.contact.size):
            if is_guard_active(pointer, g):
                x = find_passage(pointer, g)
                if x < earliest:
                    earliest, kind, contact = x, GUARD + g, guards.contact[g]
    if kind not in (NOTHING, STOP) and has_passed(pointer, stop, earliest):
        earliest, kind = find_stop(pointer, stop), STOP
    return earliest, kind, contact
