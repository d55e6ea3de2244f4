"""What is seen of a motion at every stage of a step: a row of numbers, read by name.

KAPPA to ERROR_RATE are columns of the whole mechanism; after them is a block for every contact.  LOAD, the square
of the resultant of normal and tangential force (N^2), and RUBBED, the power of friction (W, what is rubbed off), are
filled in where they are asked for, by `put_load` and `put_rubbed`.  Only where a joint has a film, another block for
every contact follows: the dry share of its normal force (N), the powers (W) that the film takes and dry friction, its
largest pressure (Pa), the speed (m/s) of the surfaces that shear it, the power (W) that its pressure alone takes.
Behind these is the power (W) of each load that is friction, below 0 where it takes energy.
"""

from typing import NamedTuple

import numpy as np

from ..compiled.family import inlined

KAPPA, DRIVE, GRAVITY, ACCELERATION, TORQUE, KINETIC, ERROR, ERROR_RATE, CONTACTS = range(9)
NORMAL, STORED, LOST, TANGENTIAL, SLIP, RAW, DEPTH, RATE, LOAD, RUBBED, CONTACT_WIDTH = range(11)
DRY, DRAINED, DRY_RUBBED, PRESSURE, SPEED, PUMPED, FILM_WIDTH = range(7)

#: Rows whose stages lie at distinct times, and these times as shares of the step.
NODES = np.array([0, 6, 5, 9, 8, 10, 12])
SHARES = np.array([0.0, 0.25, 1.0 / 3.0, 0.6, 0.6512820512820513, 0.8571428571428571, 1.0])


class Observed(NamedTuple):
    """What is seen of a contact."""

    normal: float  # N, normal force
    stored: float  # W, power that goes into the elastic deformation
    lost: float  # W, power that the normal force takes away besides it
    tangential: float  # N, friction force
    slip: float  # m/s, sliding speed; in free flight the relative speed
    raw: float  # N, the normal force before it is clipped, above the least that its law allows
    depth: float  # m, eccentricity less clearance
    rate: float  # m/s, of the eccentricity


@inlined
def columns(contacts):
    """Return how many observables there are."""
    return CONTACTS + CONTACT_WIDTH * contacts


@inlined
def column_of(contact, which):
    """Return the column of an observable of a contact: NORMAL to RATE."""
    return CONTACTS + CONTACT_WIDTH * contact + which


@inlined
def film_column(contacts, contact, which):
    """Return the column of what is seen of the film at one of so many contacts: DRY to PUMPED."""
    return CONTACTS + CONTACT_WIDTH * contacts + FILM_WIDTH * contact + which


@inlined
def observed_in(o, row, contact):
    """Return the Observed of a contact in row `row` of `o`; what is not used of it is not read."""
    block = CONTACTS + CONTACT_WIDTH * contact
    return Observed(
        normal=o[row, block + NORMAL],
        stored=o[row, block + STORED],
        lost=o[row, block + LOST],
        tangential=o[row, block + TANGENTIAL],
        slip=o[row, block + SLIP],
        raw=o[row, block + RAW],
        depth=o[row, block + DEPTH],
        rate=o[row, block + RATE],
    )


@inlined
def observed(at, row, contact):
    """Return the Observed of a contact in row `row` of the observables of the Work behind `at`."""
    return observed_in(at[0].o, row, contact)


@inlined
def observe(o, row, contact, seen):
    """Put the Observed `seen` of a contact into row `row` of `o`."""
    block = CONTACTS + CONTACT_WIDTH * contact
    o[row, block + NORMAL] = seen.normal
    o[row, block + STORED] = seen.stored
    o[row, block + LOST] = seen.lost
    o[row, block + TANGENTIAL] = seen.tangential
    o[row, block + SLIP] = seen.slip
    o[row, block + RAW] = seen.raw
    o[row, block + DEPTH] = seen.depth
    o[row, block + RATE] = seen.rate


@inlined
def put_load(o, row, contact):
    """Put the square of the resultant force of a contact into row `row` of `o`."""
    normal, tangential = o[row, column_of(contact, NORMAL)], o[row, column_of(contact, TANGENTIAL)]
    o[row, column_of(contact, LOAD)] = normal * normal + tangential * tangential


@inlined
def put_rubbed(o, row, contact):
    """Put the power of the friction of a contact into row `row` of `o`."""
    o[row, column_of(contact, RUBBED)] = -o[row, column_of(contact, TANGENTIAL)] * o[row, column_of(contact, SLIP)]
