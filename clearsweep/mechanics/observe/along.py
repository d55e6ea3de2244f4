"""What a whole step comes to, worked out with it, of one case or of several side by side: powers and courses.

It stands in `Work.step`, behind the step's length and error: sums over the stages, each times its weight and dt/dtau,
then the courses of dt/dtau and of every contact's force over the step.
"""

from typing import NamedTuple

from ..compiled.dual import as_type_of
from ..compiled.family import inlined
from ..compiled.rows import lies_in_lanes
from ..solver.dop853 import END, WEIGHTS, error_norm
from .histogram import COURSE, PARTS
from .observables import (
    ACCELERATION,
    CONTACT_WIDTH,
    CONTACTS,
    DRIVE,
    GRAVITY,
    KAPPA,
    LOST,
    NODES,
    NORMAL,
    SLIP,
    STORED,
    TANGENTIAL,
)

WHOLE = -1  # in place of a row: all of them, a whole step
LENGTH, ERROR, RISE, RUN, SUM_DRIVE, SUM_GRAVITY, SUM_ACCELERATION, SUMS = range(8)
SUM_STORED, SUM_LOST, SUM_RUBBED, SUM_FORCE, SUM_FORCE_SQUARE, SUMS_OF_CONTACT = range(6)


class Attempt(NamedTuple):
    """What a step is made from and what it makes, see `event.Work`: arrays, or `rows.Rows` of several cases."""

    y: tuple
    mode: tuple
    latched: tuple
    scale: tuple
    k: tuple
    o: tuple
    end: tuple
    step: tuple


lies_in_lanes(Attempt, Attempt._fields)


@inlined
def step_width(contacts, n):
    """Return how many numbers there are, with room for a state of `n`."""
    return max(SUMS + SUMS_OF_CONTACT * contacts + (PARTS + 1) * (1 + contacts), SUMS + n)


@inlined
def sum_of(contact, which):
    """Return where a sum of a contact stands: SUM_STORED to SUM_FORCE_SQUARE."""
    return SUMS + SUMS_OF_CONTACT * contact + which


@inlined
def course_of(contacts, contact):
    """Return where the course of a contact's force begins; that of dt/dtau where `contact` is -1."""
    return SUMS + SUMS_OF_CONTACT * contacts + (PARTS + 1) * (1 + contact)


@inlined
def sum_along(o, contacts, step, weights):
    """Put the sums of powers and squares over the stages, which have `weights`, into `step`."""
    zero = as_type_of(0.0, o[0, KAPPA])
    for place in range(SUM_DRIVE, SUMS + SUMS_OF_CONTACT * contacts):
        step[place] = zero
    for row in range(weights.size):
        if weights[row] == 0.0:
            continue
        share = weights[row] * o[row, KAPPA]
        step[SUM_DRIVE] = step[SUM_DRIVE] + share * o[row, DRIVE]
        step[SUM_GRAVITY] = step[SUM_GRAVITY] + share * o[row, GRAVITY]
        step[SUM_ACCELERATION] = step[SUM_ACCELERATION] + share * (o[row, ACCELERATION] * o[row, ACCELERATION])
        for c in range(contacts):
            block, first = CONTACTS + CONTACT_WIDTH * c, SUMS + SUMS_OF_CONTACT * c
            force, rubbed = o[row, block + NORMAL], o[row, block + TANGENTIAL] * o[row, block + SLIP]
            step[first + SUM_STORED] = step[first + SUM_STORED] + share * o[row, block + STORED]
            step[first + SUM_LOST] = step[first + SUM_LOST] + share * o[row, block + LOST]
            step[first + SUM_RUBBED] = step[first + SUM_RUBBED] - share * rubbed
            step[first + SUM_FORCE] = step[first + SUM_FORCE] + share * force
            step[first + SUM_FORCE_SQUARE] = step[first + SUM_FORCE_SQUARE] + share * (force * force)


@inlined
def integral_of(o, column, weights):
    """Return the sum of an observable over the stages, which have `weights`; times the step's length, its integral."""
    total = 0.0
    for row in range(weights.size):
        total += weights[row] * o[row, KAPPA] * o[row, column]
    return total


@inlined
def follow_along(o, contacts, step):
    """Put the courses of dt/dtau and of the contacts' forces into `step`: polynomials through the stages."""
    first = SUMS + SUMS_OF_CONTACT * contacts
    for c in range(contacts + 1):
        column = KAPPA if c == 0 else CONTACTS + CONTACT_WIDTH * (c - 1) + NORMAL
        for i in range(PARTS + 1):
            total = as_type_of(0.0, o[0, KAPPA])
            for m in range(NODES.size):
                total = total + COURSE[m, i] * o[NODES[m], column]
            step[first + (PARTS + 1) * c + i] = total


@inlined
def keep_last_stage(tried, state):
    """Keep the state of the last stage, which lies at the end of the step, too."""
    for i in range(tried.end.size):
        tried.step[SUMS + i] = state[i]


@inlined
def sum_up(tried):
    """Put into `step` what a step comes to whose rows 0 to END are filled."""
    k, end, step, contacts = tried.k, tried.end, tried.step, tried.mode.size
    rise = run = as_type_of(0.0, step[LENGTH])
    for i in range(end.size):
        inverse = 1.0 / tried.scale[i]
        steeper, farther = (k[END, i] - k[END - 1, i]) * inverse, (end[i] - step[SUMS + i]) * inverse
        rise, run = rise + steeper * steeper, run + farther * farther
    step[RISE], step[RUN] = rise, run
    step[ERROR] = error_norm(step[LENGTH], k, tried.scale)
    sum_along(tried.o, contacts, step, WEIGHTS)
    follow_along(tried.o, contacts, step)
