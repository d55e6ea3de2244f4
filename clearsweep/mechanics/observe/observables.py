"""Observables of the motion at each stage of a step, in columns that are accessed by name.

KAPPA to ERROR_RATE are columns of the whole mechanism; a block for every contact follows.  LOAD, the square
of the resultant of normal and tangential force (N^2), and FRICTION_POWER, the power of friction (W, dissipated), are
filled in on demand, by `put_load` and `put_friction_power`.  If a joint has a film, another block for
every contact follows: the dry fraction of its normal force (N), the powers (W) of film and dry friction, its
largest pressure (Pa), the shear speed (m/s) of the surfaces, and the power (W) of its pressure only.
The power (W) of each friction load follows, negative if it dissipates energy.
"""

from typing import NamedTuple

from ...tracing.compiled.family import inlined

KAPPA, DRIVE, GRAVITY, ACCELERATION, TORQUE, KINETIC, ERROR, ERROR_RATE, CONTACTS = range(9)
NORMAL, STORED, LOST, TANGENTIAL, SLIP, RAW, DEPTH, RATE, GUARD_QUANTITY, LOAD, FRICTION_POWER, CONTACT_WIDTH = range(
    12
)
DRY_FORCE, FILM_POWER, DRY_FRICTION_POWER, PEAK_PRESSURE, SHEAR_SPEED, PRESSURE_POWER, FILM_WIDTH = range(7)


class Observed(NamedTuple):
    """Observables of a contact."""

    normal: float  # N, normal force
    stored: float  # W, stored in elastic deformation
    lost: float  # W, dissipated by the normal force
    tangential: float  # N, friction force
    slip: float  # m/s, sliding speed; in free flight a bound of the rate of the depth
    raw: float  # N, normal force before clipping, minus the least force of its law
    depth: float  # m, eccentricity minus clearance
    rate: float  # m/s, of the eccentricity
    guard_quantity: float  # a further quantity that only guards use, see `joint.contract.guard_quantity`


@inlined
def column_count(contacts):
    """Return the number of observables."""
    return CONTACTS + CONTACT_WIDTH * contacts


@inlined
def column_of(contact, quantity):
    """Return the column of an observable of a contact: NORMAL to GUARD_QUANTITY."""
    return CONTACTS + CONTACT_WIDTH * contact + quantity


@inlined
def film_column(contacts, contact, quantity):
    """Return the column of a film observable, DRY_FORCE to PRESSURE_POWER, of one of `contacts` contacts."""
    return CONTACTS + CONTACT_WIDTH * contacts + FILM_WIDTH * contact + quantity


@inlined
def contact_observables_in(o, row, contact):
    """Return the Observed of a contact in row `row` of `o`; unused fields are not read."""
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
        guard_quantity=o[block + GUARD_QUANTITY, row],
    )


@inlined
def contact_observables(pointer, row, contact):
    """Return the Observed of a contact in row `row` of the observables of the Work behind `pointer`."""
    return contact_observables_in(pointer[0].o, row, contact)


@inlined
def write_contact_observables(o, row, contact, contact_values):
    """Write the Observed `contact_values` of a contact to row `row` of `o`."""
    block = CONTACTS + CONTACT_WIDTH * contact
    o[block + NORMAL, row] = contact_values.normal
    o[block + STORED, row] = contact_values.stored
    o[block + LOST, row] = contact_values.lost
    o[block + TANGENTIAL, row] = contact_values.tangential
    o[block + SLIP, row] = contact_values.slip
    o[block + RAW, row] = contact_values.raw
    o[block + DEPTH, row] = contact_values.depth
    o[block + RATE, row] = contact_values.rate
    o[block + GUARD_QUANTITY, row] = contact_values.guard_quantity


@inlined
def put_load(o, row, contact):
    """Write the squared resultant force of a contact to row `row` of `o`."""
    normal, tangential = o[column_of(contact, NORMAL), row], o[column_of(contact, TANGENTIAL), row]
    o[column_of(contact, LOAD), row] = normal * normal + tangential * tangential


@inlined
def put_friction_power(o, row, contact):
    """Write the friction power of a contact to row `row` of `o`."""
    o[column_of(contact, FRICTION_POWER), row] = (
        -o[column_of(contact, TANGENTIAL), row] * o[column_of(contact, SLIP), row]
    )
