"""What a whole step comes to, worked out with it, of one case or of several side by side: powers and courses.

It stands in `Work.step`, behind the step's length and error: sums over the stages, each times its weight and dt/dtau,
then the courses of dt/dtau and of every contact's force over the step.
"""

from ..compiled.dual import as_type_of
from ..compiled.family import inlined
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
    RUBBED,
    STORED,
)

LENGTH, ERROR, RISE, RUN, SUM_DRIVE, SUM_GRAVITY, SUM_ACCELERATION, SUMS = range(8)
SUM_STORED, SUM_LOST, SUM_RUBBED, SUM_FORCE, SUMS_OF_CONTACT = range(5)


@inlined
def step_width(contacts, n):
    """Return how many numbers there are, with room for a state of `n`."""
    return max(SUMS + SUMS_OF_CONTACT * contacts + (PARTS + 1) * (1 + contacts), SUMS + n)


@inlined
def sum_of(contact, which):
    """Return where a sum of a contact stands: SUM_STORED to SUM_FORCE."""
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
            force = o[row, block + NORMAL]
            step[first + SUM_STORED] = step[first + SUM_STORED] + share * o[row, block + STORED]
            step[first + SUM_LOST] = step[first + SUM_LOST] + share * o[row, block + LOST]
            step[first + SUM_RUBBED] = step[first + SUM_RUBBED] + share * o[row, block + RUBBED]
            step[first + SUM_FORCE] = step[first + SUM_FORCE] + share * (force * force)


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
