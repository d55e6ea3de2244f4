"""What a whole step comes to: its error, sums, courses, maxima.

It is in `Work.step`, behind the step's length and error: sums over the stages, each times its weight and dt/dtau;
how large an observable is at the stages of a step between whose ends it may have a maximum, else NO_PEAK; the courses
of dt/dtau and of every contact's force over the step.
"""

import math
from typing import NamedTuple

import numpy as np

from ...compiled.choosing import abreast
from ...compiled.family import inlined
from ...joint.contract import acts, meets
from ...observe.histogram import COURSE, PARTS
from ...observe.observables import (
    ACCELERATION,
    CONTACT_WIDTH,
    CONTACTS,
    DEPTH,
    DRIVE,
    GRAVITY,
    KAPPA,
    LOST,
    NORMAL,
    SLIP,
    STORED,
    TANGENTIAL,
    TORQUE,
    column_of,
)
from ...observe.stages import END, NODES, SHARES, STAGES, START

(
    LENGTH,
    ERROR,
    CHANGE,  # mean square of how far, over the allowed error, the latest sweep moved all stages of a component
    CONTRACTION,  # by which factor a sweep moves them less than the one before
    SWEEPS,  # how many it took
    ACCEPTED,  # not zero where the step is good and contains no event
    STIFF,  # not zero where it may be short for what is stiff
    NEEDS_PEAK_SEARCH,  # not zero where a maximum may lie between its stages that is above what it is at their ends
    SUM_DRIVE,
    SUM_GRAVITY,
    SUM_ACCELERATION,
    HIGHEST_ACCELERATION,
    HIGHEST_TORQUE,
    HIGHEST_ERROR,
    SUMS,
) = range(15)
(
    SUM_STORED,
    SUM_LOST,
    SUM_RUBBED,
    SUM_FORCE,
    SUM_FORCE_SQUARE,
    FASTEST,  # m per unit of tau, the largest speed of the journal at the start and all stages but the last
    HIGHEST_FORCE,
    HIGHEST_DEPTH,
    HIGHEST_LOAD,
    SUMS_OF_CONTACT,
) = range(10)
NO_PEAK = -math.inf  # HIGHEST of an observable that has no maximum between the ends of the step


class TrialStep(NamedTuple):
    """What a step comes from and comes to, see `event.Work`."""

    y: tuple
    mode: tuple
    k: tuple
    o: tuple
    end: tuple
    step: tuple


@inlined
def step_width(contacts):
    """Return how many numbers there are."""
    return SUMS + SUMS_OF_CONTACT * contacts + (PARTS + 1) * (1 + contacts)


@inlined
def sum_of(contact, which):
    """Return where a sum of a contact is: SUM_STORED to HIGHEST_LOAD."""
    return SUMS + SUMS_OF_CONTACT * contact + which


@inlined
def course_of(contacts, contact):
    """Return where the course of a contact's force begins; that of dt/dtau where `contact` is -1."""
    return SUMS + SUMS_OF_CONTACT * contacts + (PARTS + 1) * (1 + contact)


@inlined
def sum_along(tried, weights):
    """Put the sums of powers and squares over the stages, which have `weights`, into `step`; of contacts that act."""
    o, step = tried.o, tried.step
    drive = gravity = square = 0.0
    for row in range(weights.size):
        if weights[row] != 0.0:
            share = weights[row] * o[KAPPA, row]
            drive, gravity = drive + share * o[DRIVE, row], gravity + share * o[GRAVITY, row]
            square = square + share * (o[ACCELERATION, row] * o[ACCELERATION, row])
    step[SUM_DRIVE], step[SUM_GRAVITY], step[SUM_ACCELERATION] = drive, gravity, square
    for c in range(tried.mode.size):
        if not acts(tried.mode[c]):
            continue
        block, first = CONTACTS + CONTACT_WIDTH * c, SUMS + SUMS_OF_CONTACT * c
        stored = lost = rubbed = total = square = 0.0
        for row in range(weights.size):
            if weights[row] != 0.0:
                share, force = weights[row] * o[KAPPA, row], o[block + NORMAL, row]
                stored, lost = stored + share * o[block + STORED, row], lost + share * o[block + LOST, row]
                rubbed = rubbed - share * (o[block + TANGENTIAL, row] * o[block + SLIP, row])
                total, square = total + share * force, square + share * (force * force)
        step[first + SUM_STORED], step[first + SUM_LOST], step[first + SUM_RUBBED] = stored, lost, rubbed
        step[first + SUM_FORCE], step[first + SUM_FORCE_SQUARE] = total, square


@inlined
def integral_of(o, column, weights):
    """Return the sum of an observable over the stages, which have `weights`; times the step's length, its integral."""
    total = 0.0
    for row in range(weights.size):
        total += weights[row] * o[KAPPA, row] * o[column, row]
    return total


@inlined
def negative_part_of(o, column, weights):
    """Return the same sum of what an observable is below 0, as a number above 0."""
    total = 0.0
    for row in range(weights.size):
        total -= weights[row] * o[KAPPA, row] * min(o[column, row], 0.0)
    return total


@inlined
def integral_of_size(o, column, weights):
    """Return the same of the size of an observable."""
    total = 0.0
    for row in range(weights.size):
        total += weights[row] * o[KAPPA, row] * abs(o[column, row])
    return total


@inlined
def follow_along(tried):
    """Put the courses of dt/dtau and of the forces of contacts that act into `step`: polynomials through the stages."""
    contacts = tried.mode.size
    follow_column(tried, KAPPA, course_of(contacts, -1))
    for c in range(contacts):
        if acts(tried.mode[c]):
            follow_column(tried, column_of(c, NORMAL), course_of(contacts, c))


@inlined
def follow_column(tried, column, first):
    """Put the course of an observable into `step`, from `first` on."""
    tried.step[first] = tried.o[column, START]
    for i in abreast(PARTS):
        total = COURSE[0, i] * tried.o[column, NODES[0]]
        for m in range(1, NODES.size):
            total += COURSE[m, i] * tried.o[column, NODES[m]]
        tried.step[first + 1 + i] = total


@inlined
def sum_up(tried, weights):
    """Put into `step` what a step comes to whose rows of `weights` are filled."""
    sum_along(tried, weights)
    follow_along(tried)
    look_for_speeds(tried)
    look_for_peaks(tried)


@inlined
def look_for_speeds(tried):
    """Put into `step` how fast the journals in free flight are at the start and all stages but the last."""
    o, step = tried.o, tried.step
    for c in range(tried.mode.size):
        if not meets(tried.mode[c]):
            continue
        fastest = o[column_of(c, SLIP), START] * o[KAPPA, START]
        for row in range(END):
            fastest = max(fastest, o[column_of(c, SLIP), row] * o[KAPPA, row])
        step[sum_of(c, FASTEST)] = fastest


@inlined
def look_for_peaks(tried):
    """Put into `step` how high observables are where they may have a peak; those of contacts that act alone."""
    o, step = tried.o, tried.step
    step[HIGHEST_ACCELERATION] = highest_inside(o, ACCELERATION, math.copysign(1.0, o[ACCELERATION, END]))
    step[HIGHEST_TORQUE] = highest_inside(o, TORQUE, math.copysign(1.0, o[TORQUE, END]))
    for c in range(tried.mode.size):
        if not acts(tried.mode[c]):
            continue
        step[sum_of(c, HIGHEST_FORCE)] = highest_inside(o, column_of(c, NORMAL), 1.0)
        step[sum_of(c, HIGHEST_DEPTH)] = highest_inside(o, column_of(c, DEPTH), 1.0)


@inlined
def highest_inside(o, column, sign):
    """Return the largest value of an observable, times `sign`, at the nodes; NO_PEAK where it has none there.

    A peak: it rises at the start of the step and falls at its end, or nearly so, by slopes of the parabolas through
    three nodes at either end, a tenth of the step outside, so that one close to an end counts in both steps there.
    """
    rise = fall = 0.0
    for m in range(3):
        rise += RISE[m] * o[column, NODES[FIRST[m]]]
        fall += FALL[m] * o[column, NODES[FINAL[m]]]
    if not (sign * rise > 0.0 > sign * fall):
        return NO_PEAK
    highest = sign * o[column, START]
    for m in range(STAGES):
        highest = max(highest, sign * o[column, m])
    return highest


def _slope(nodes, point):
    """Return the weights that give the slope at `point` of the parabola through values at three `nodes`."""
    a, b, c = nodes
    return np.array(
        [
            (2 * point - b - c) / ((a - b) * (a - c)),
            (2 * point - a - c) / ((b - a) * (b - c)),
            (2 * point - a - b) / ((c - a) * (c - b)),
        ]
    )


FIRST, FINAL = np.array([0, 2, 3]), np.array([5, 6, 8])  # of NODES, some tenths of the step apart
RISE, FALL = _slope(SHARES[FIRST], -0.1), _slope(SHARES[FINAL], 1.1)
