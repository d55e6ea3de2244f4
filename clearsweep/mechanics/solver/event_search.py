"""Search for the first event of a step: an onset, a separation, a limit, a guard of a joint's law, or a stop.

Every event is an upward zero crossing of an event function.  Over the step that function is represented by a
polynomial through its values at the start and the stages.  Its Bernstein coefficients bound it, so that no rise and
fall between two stages is missed, see `bernstein`.
"""

import math

from ..compiled.family import kernel
from ..joint.contract import meets, touches
from ..observe.observables import DEPTH, KAPPA, RATE, SLIP, column_of
from ..observe.stages import END, NODES, SCRATCH, SHARES, START
from .bernstein import (
    COEFFICIENTS,
    DEGREE,
    NOWHERE,
    VALUES,
    WHOLE,
    crossing_for_certain,
    first_crossing,
    from_interpolant,
    from_values,
    highest,
    lowest,
    lowest_place,
    tail,
    turn_sign,
)
from .event import GUARD, LIMIT, NOTHING, ONSET, SEPARATION, STOP, evaluate_dense
from .guarding import evaluate_guards, first_passage, looked_at

MARGIN = 1.2  # on the largest speed at the stages: bounds the speed between them
ROUGH = 1e-3  # tail of a gap's polynomial, over its size, from which the step is searched in parts
LEAST_PART = 1.0 / 16.0  # of a step: shortest part
NEXT_TO_ROOT, ENOUGH = 0.05, 1e-7  # of a step: largest correction of an onset by Newton's method, and its tolerance
PASSED = 1e-9  # of the root of a penetration: a step that begins this close to a limit has just passed it


@kernel
def take_gap(at, j, h):
    """Set the polynomial of contact `j` in free flight, positive where it touches, from the depths at the nodes.

    It is d (d + 2 s) of the depth d (m) and its largest size s.  In a bearing this is the squared eccentricity minus
    the
    squared clearance, which is smooth even where the path crosses the centre and the depth has a kink.
    """
    work, column = at[0], column_of(j, DEPTH)
    p, size = work.polynomials, work.clearance[j]
    for m in range(COEFFICIENTS):
        size = max(size, -work.o[column, NODES[m]])
    for m in range(COEFFICIENTS):
        depth = work.o[column, NODES[m]]
        p[VALUES, m] = depth * (depth + 2.0 * size)
    from_values(p)
    depth_rate = work.o[column_of(j, RATE), START] * work.o[KAPPA, START] * h
    p[WHOLE, 1] = (
        p[WHOLE, 0] + 2.0 * (work.o[column, START] + size) * depth_rate / DEGREE
    )  # its slope is known at the start


@kernel
def take_part_of_gap(at, j, begin, width):
    """Set the polynomial of contact `j` over a part of the step, from the interpolant."""
    work, column = at[0], column_of(j, DEPTH)
    p, size = work.polynomials, work.clearance[j]
    for m in range(COEFFICIENTS):
        evaluate_dense(at, begin + width * SHARES[m])
        p[VALUES, m] = work.o[column, SCRATCH]
        size = max(size, -p[VALUES, m])
    for m in range(COEFFICIENTS):
        p[VALUES, m] *= p[VALUES, m] + 2.0 * size
    from_values(p)


@kernel
def is_rough(p):
    """Return whether the error of WHOLE matters, where it may vanish."""
    size = 0.0
    for i in range(COEFFICIENTS):
        size = max(size, abs(p[VALUES, i]))
    tail_bound = tail(p)
    return tail_bound > ROUGH * size and highest(p) + tail_bound >= 0.0


@kernel
def cannot_arrive(at, j, h):
    """Return whether the path of the journal of free contact `j` is too short to reach the bearing."""
    work = at[0]
    fastest = max(work.contact_steps[j].fastest, work.o[column_of(j, SLIP), END] * work.o[KAPPA, END])
    gaps = work.o[column_of(j, DEPTH), START] + work.o[column_of(j, DEPTH), END]
    return gaps + MARGIN * h * fastest < 0.0


@kernel
def first_onset(at, j, h):
    """Return the share of the step at which free contact `j` first touches its bearing while closing, or NOWHERE."""
    work = at[0]
    p, begin = work.polynomials, work.o[column_of(j, DEPTH), START]
    if cannot_arrive(at, j, h):
        return NOWHERE
    if begin >= 0.0 and work.o[column_of(j, RATE), START] >= 0.0:
        return 0.0
    take_gap(at, j, h)
    if is_rough(p):
        return first_onset_in_parts(at, j, h)
    x = crossing_for_certain(p, 0.0)
    if x == NOWHERE and begin >= 0.0 and p[VALUES, DEGREE] >= 0.0:  # it never quite separated
        return lowest_place(p)
    return x if x == NOWHERE else true_onset(at, j, h, x)


@kernel
def true_onset(at, j, h, x):
    """Return the share of the step at which contact `j` touches, by Newton's method from its polynomial's share `x`."""
    work = at[0]
    for _ in range(4):
        evaluate_dense(at, x)
        slope = work.o[column_of(j, RATE), SCRATCH] * work.o[KAPPA, SCRATCH] * h
        move = work.o[column_of(j, DEPTH), SCRATCH] / slope if slope != 0.0 else 1.0
        if not abs(move) < NEXT_TO_ROOT:  # nearly tangential
            break
        x = min(max(x - move, 0.0), 1.0)
        if abs(move) <= ENOUGH:
            break
    return x


@kernel
def first_onset_in_parts(at, j, h):
    """Return the result of `first_onset` where the gap is not smooth over the step, as with worn surfaces."""
    p, begin, width = at[0].polynomials, 0.0, 0.5
    while begin < 1.0:
        take_part_of_gap(at, j, begin, width)
        if width > LEAST_PART and is_rough(p):
            width *= 0.5
        else:
            x = crossing_for_certain(p, 0.0)
            if x != NOWHERE:
                return true_onset(at, j, h, begin + width * x)
            begin += width
            width = min(2.0 * width, 1.0 - begin)
    return NOWHERE


@kernel
def first_separation(at, j):
    """Return the share of the step at which contact `j` separates, from the interpolant, or NOWHERE."""
    work, root = at[0], at[0].time + 1 + j
    from_interpolant(work.polynomials, work.y[root], work.f, root)
    if lowest(work.polynomials) > 0.0:
        return NOWHERE
    turn_sign(work.polynomials)
    return first_crossing(work.polynomials)


@kernel
def first_limit(at, j):
    """Return the share at which the penetration of contact `j` passes the limit of its elastic law, or NOWHERE."""
    work, root = at[0], at[0].time + 1 + j
    limit = math.sqrt(work.limit_depth[j])
    from_interpolant(work.polynomials, work.y[root] - limit, work.f, root)
    overshoot = work.y[root] - limit
    if overshoot > PASSED * limit or (overshoot > -PASSED * limit and work.k[root, START] > 0.0):
        turn_sign(work.polynomials)
    return first_crossing(work.polynomials) if highest(work.polynomials) >= 0.0 else NOWHERE


@kernel
def first_stop(at, stop):
    """Return the share of the step at which the run reaches `stop`, which is not beyond its end."""
    work = at[0]
    from_interpolant(work.polynomials, work.y[work.independent] - stop, work.f, work.independent)
    return min(first_crossing(work.polynomials), 1.0)


@kernel
def first_event(at, h, stop):
    """Return (share of the step, kind, contact) of its first event; kind is NOTHING without event."""
    work, guards = at[0], at[0].guards
    largest, kind, contact = NOWHERE, NOTHING, 0
    if work.end[work.independent] >= stop:
        largest, kind = first_stop(at, stop), STOP
    for j in range(work.mode.size):
        x, event_kind = NOWHERE, NOTHING
        if meets(work.mode[j]):
            x, event_kind = first_onset(at, j, h), ONSET
        elif touches(work.mode[j]):
            x, event_kind = first_separation(at, j), SEPARATION
            if work.limit_depth[j] < math.inf:
                y = first_limit(at, j)
                if y < x:
                    x, event_kind = y, LIMIT
        if x < largest:
            largest, kind, contact = x, event_kind, j
    if guards.contact.size > 0:
        evaluate_guards(at, work.y, END)
        for g in range(guards.contact.size):
            if looked_at(at, g):
                x = first_passage(at, g)
                if x < largest:
                    largest, kind, contact = x, GUARD + g, guards.contact[g]
    return largest, kind, contact
