"""What is seen of a motion at every stage of a step: a column of numbers, read by name.

KAPPA to ERROR_RATE are columns of the whole mechanism; after them is a block for every contact.  LOAD, the square
of the resultant of normal and tangential force (N^2), and RUBBED, the power of friction (W, what is rubbed off), are
filled in where they are asked for, by `put_load` and `put_rubbed`.  Only where a joint has a film, another block for
every contact follows: the dry share of its normal force (N), the powers (W) that the film takes and dry friction, its
largest pressure (Pa), the speed (m/s) of the surfaces that shear it, the power (W) that its pressure alone takes.
Behind these is the power (W) of each load that is friction, below 0 where it takes energy.
"""

from typing import NamedTuple

from ..compiled.family import inlined

KAPPA, DRIVE, GRAVITY, ACCELERATION, TORQUE, KINETIC, ERROR, ERROR_RATE, CONTACTS = range(9)
NORMAL, STORED, LOST, TANGENTIAL, SLIP, RAW, DEPTH, RATE, LOAD, RUBBED, CONTACT_WIDTH = range(11)
DRY, DRAINED, DRY_RUBBED, PRESSURE, SPEED, PUMPED, FILM_WIDTH = range(7)


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
        normal=o[block + NORMAL, row],
        stored=o[block + STORED, row],
        lost=o[block + LOST, row],
        tangential=o[block + TANGENTIAL, row],
        slip=o[block + SLIP, row],
        raw=o[block + RAW, row],
        depth=o[block + DEPTH, row],
        rate=o[block + RATE, row],
    )


@inlined
def observed(at, row, contact):
    """Return the Observed of a contact in row `row` of the observables of the Work behind `at`."""
    return observed_in(at[0].o, row, contact)


@inlined
def observe(o, row, contact, seen):
    """Put the Observed `seen` of a contact into row `row` of `o`."""
    block = CONTACTS + CONTACT_WIDTH * contact
    o[block + NORMAL, row] = seen.normal
    o[block + STORED, row] = seen.stored
    o[block + LOST, row] = seen.lost
    o[block + TANGENTIAL, row] = seen.tangential
    o[block + SLIP, row] = seen.slip
    o[block + RAW, row] = seen.raw
    o[block + DEPTH, row] = seen.depth
    o[block + RATE, row] = seen.rate


@inlined
def put_load(o, row, contact):
    """Put the square of the resultant force of a contact into row `row` of `o`."""
    normal, tangential = o[column_of(contact, NORMAL), row], o[column_of(contact, TANGENTIAL), row]
    o[column_of(contact, LOAD), row] = normal * normal + tangential * tangential


@inlined
def put_rubbed(o, row, contact):
    """Put the power of the friction of a contact into row `row` of `o`."""
    o[column_of(contact, RUBBED), row] = -o[column_of(contact, TANGENTIAL), row] * o[column_of(contact, SLIP), row]
