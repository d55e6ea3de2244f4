"""What a whole step comes to, worked out of one case or of several side by side: its error, sums, courses, maxima.

It is in `Work.step`, behind the step's length and error: sums over the stages, each times its weight and dt/dtau;
how large an observable is at the stages of a step between whose ends it may have a maximum, else NO_PEAK; the courses
of dt/dtau and of every contact's force over the step.
"""

import math
from typing import NamedTuple

import numpy as np

from ...compiled.choosing import none_of, where
from ...compiled.dual import as_type_of
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
    NODES,
    NORMAL,
    SLIP,
    STORED,
    TANGENTIAL,
    TORQUE,
    column_of,
)
from ..dop853 import END, WEIGHTS, error_norm

WHOLE = -1  # in place of a row: all of them, a whole step
(
    LENGTH,
    ERROR,
    RISE,
    RUN,
    ACCEPTED,  # not zero where the step is good and contains no event
    STIFF,  # not zero where it may be short for what is stiff
    NEEDS_PEAK_SEARCH,  # not zero where a maximum may lie between its stages that is above what it is at their ends
    CONTINUES,  # not zero where the next step begins at its end with nothing changed
    ON_FAST_PATH,  # not zero where it does and nothing is due, so that its length is here already
    SUM_DRIVE,
    SUM_GRAVITY,
    SUM_ACCELERATION,
    HIGHEST_ACCELERATION,
    HIGHEST_TORQUE,
    HIGHEST_ERROR,
    SUMS,
) = range(16)
(
    SUM_STORED,
    SUM_LOST,
    SUM_RUBBED,
    SUM_FORCE,
    SUM_FORCE_SQUARE,
    FASTEST,  # m per unit of tau, the largest speed of the journal at stages but the last
    HIGHEST_FORCE,
    HIGHEST_DEPTH,
    HIGHEST_LOAD,
    SUMS_OF_CONTACT,
) = range(10)
NO_PEAK = -math.inf  # HIGHEST of an observable that has no maximum between the ends of the step


class TrialStep(NamedTuple):
    """What a step is made from and what it makes, see `event.Work`: arrays, or rows of one case or several."""

    y: tuple
    mode: tuple
    latched: tuple
    weight: tuple
    k: tuple
    o: tuple
    end: tuple
    step: tuple


@inlined
def step_width(contacts, n):
    """Return how many numbers there are, with room for a state of `n`."""
    return max(SUMS + SUMS_OF_CONTACT * contacts + (PARTS + 1) * (1 + contacts), SUMS + n)


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
    drive = gravity = square = as_type_of(0.0, o[0, KAPPA])
    for row in range(weights.size):
        if weights[row] != 0.0:
            share = weights[row] * o[row, KAPPA]
            drive, gravity = drive + share * o[row, DRIVE], gravity + share * o[row, GRAVITY]
            square = square + share * (o[row, ACCELERATION] * o[row, ACCELERATION])
    step[SUM_DRIVE], step[SUM_GRAVITY], step[SUM_ACCELERATION] = drive, gravity, square
    for c in range(tried.mode.size):
        if none_of(acts(tried.mode[c])):
            continue
        block, first = CONTACTS + CONTACT_WIDTH * c, SUMS + SUMS_OF_CONTACT * c
        stored = lost = rubbed = total = square = as_type_of(0.0, o[0, KAPPA])
        for row in range(weights.size):
            if weights[row] != 0.0:
                share, force = weights[row] * o[row, KAPPA], o[row, block + NORMAL]
                stored, lost = stored + share * o[row, block + STORED], lost + share * o[row, block + LOST]
                rubbed = rubbed - share * (o[row, block + TANGENTIAL] * o[row, block + SLIP])
                total, square = total + share * force, square + share * (force * force)
        step[first + SUM_STORED], step[first + SUM_LOST], step[first + SUM_RUBBED] = stored, lost, rubbed
        step[first + SUM_FORCE], step[first + SUM_FORCE_SQUARE] = total, square


@inlined
def integral_of(o, column, weights):
    """Return the sum of an observable over the stages, which have `weights`; times the step's length, its integral."""
    total = 0.0
    for row in range(weights.size):
        total += weights[row] * o[row, KAPPA] * o[row, column]
    return total


@inlined
def negative_part_of(o, column, weights):
    """Return the same sum of what an observable is below 0, as a number above 0."""
    total = 0.0
    for row in range(weights.size):
        total -= weights[row] * o[row, KAPPA] * min(o[row, column], 0.0)
    return total


@inlined
def integral_of_size(o, column, weights):
    """Return the same of the size of an observable."""
    total = 0.0
    for row in range(weights.size):
        total += weights[row] * o[row, KAPPA] * abs(o[row, column])
    return total


@inlined
def follow_along(tried):
    """Put the courses of dt/dtau and of the forces of contacts that act into `step`: polynomials through the stages."""
    contacts = tried.mode.size
    follow_column(tried, KAPPA, course_of(contacts, -1))
    for c in range(contacts):
        if not none_of(acts(tried.mode[c])):
            follow_column(tried, column_of(c, NORMAL), course_of(contacts, c))


@inlined
def follow_column(tried, column, first):
    """Put the course of an observable into `step`, from `first` on."""
    for i in range(PARTS + 1):
        total = as_type_of(0.0, tried.o[0, column])
        for m in range(NODES.size):
            total = total + COURSE[m, i] * tried.o[NODES[m], column]
        tried.step[first + i] = total


@inlined
def keep_last_stage(tried, state):
    """Keep the state of the last stage, which lies at the end of the step, too."""
    for i in range(tried.end.size):
        tried.step[SUMS + i] = state[i]


@inlined
def sum_up(tried):
    """Put into `step` what a step comes to whose rows 0 to END are filled."""
    k, end, step = tried.k, tried.end, tried.step
    rise = run = as_type_of(0.0, step[LENGTH])
    for i in range(end.size):
        weight = tried.weight[i]
        steeper, farther = (k[END, i] - k[END - 1, i]) * weight, (end[i] - step[SUMS + i]) * weight
        rise, run = rise + steeper * steeper, run + farther * farther
    step[RISE], step[RUN] = rise, run
    step[ERROR] = error_norm(step[LENGTH], k, tried.weight)
    sum_along(tried, WEIGHTS)
    follow_along(tried)
    look_for_speeds(tried)
    look_for_peaks(tried)


@inlined
def look_for_speeds(tried):
    """Put into `step` how fast the journals in free flight are at the stages but the last."""
    o, step = tried.o, tried.step
    for c in range(tried.mode.size):
        if none_of(meets(tried.mode[c])):
            continue
        fastest = as_type_of(0.0, step[LENGTH])
        for row in range(END):
            fastest = max(fastest, o[row, column_of(c, SLIP)] * o[row, KAPPA])
        step[sum_of(c, FASTEST)] = fastest


@inlined
def look_for_peaks(tried):
    """Put into `step` how high observables are where they may have a peak; those of contacts that act alone."""
    o, step = tried.o, tried.step
    step[HIGHEST_ACCELERATION] = highest_inside(o, ACCELERATION, math.copysign(1.0, o[END, ACCELERATION]))
    step[HIGHEST_TORQUE] = highest_inside(o, TORQUE, math.copysign(1.0, o[END, TORQUE]))
    for c in range(tried.mode.size):
        if none_of(acts(tried.mode[c])):
            continue
        upwards = as_type_of(1.0, step[LENGTH])
        step[sum_of(c, HIGHEST_FORCE)] = highest_inside(o, column_of(c, NORMAL), upwards)
        step[sum_of(c, HIGHEST_DEPTH)] = highest_inside(o, column_of(c, DEPTH), upwards)


@inlined
def highest_inside(o, column, sign):
    """Return the largest value of an observable, times `sign`, at the distinct stages; NO_PEAK where it has none there.

    A peak: it rises at the start of the step and falls at its end, or nearly so, by slopes of the parabolas through
    three stages at either end, a tenth of the step outside, so that one close to an end counts in both steps there.
    """
    rise = START[0] * o[0, column] + START[1] * o[3, column] + START[2] * o[6, column]
    fall = FINISH[0] * o[8, column] + FINISH[1] * o[10, column] + FINISH[2] * o[END, column]
    highest = sign * o[0, column]
    for m in range(1, NODES.size):
        highest = max(highest, sign * o[NODES[m], column])
    return where((sign * rise > 0.0) & (sign * fall < 0.0), highest, NO_PEAK)


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


START = _slope((0.0, 0.11835034190722739, 0.25), -0.1)
FINISH = _slope((0.6512820512820513, 0.8571428571428571, 1.0), 1.1)


@inlined
def advance(tried):
    """Make the end of a step the start of the next where the motion goes on."""
    y, k, o, goes_on = tried.y, tried.k, tried.o, tried.step[CONTINUES] != 0.0
    for i in range(y.size):
        y[i], k[0, i] = where(goes_on, tried.end[i], y[i]), where(goes_on, k[END, i], k[0, i])
    for column in range(o.shape[1]):
        o[0, column] = where(goes_on, o[END, column], o[0, column])
