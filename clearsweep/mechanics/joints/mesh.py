"""Play in rotation: teeth of two wheels between two flanks, or the halves of a coupling.

The position x is that of the first body relative to the second along the line of action, from the middle of the play
(Kahraman & Singh 1990, "Non-linear dynamics of a spur gear pair", Journal of Sound and Vibration 142).  The teeth press
on the drive flank where x exceeds half of the play, on the coast flank where -x does: two contacts, each with its own
mode, root of penetration and onset rate.  Of a coupling x is an angle and a force a torque, both at an arm of 1 m.

Friction acts at the point of contact, which moves along the line of action by a base pitch for each pair of teeth; one
pair carries the force at a time, and its change is an event.  The teeth slide at the distance from the pitch point
times the difference of both spins, so friction changes its direction at the pitch point.

The stiffness may vary along the path of contact, k = k0 g(s) with s in base pitches.  The energy g(s) W0(depth) also
depends on the angle of the first wheel, so -W0 g'(s) ds/dangle acts as a torque between this wheel and the line of
centres: forces and torque are the derivatives of one energy, and a turn neither creates nor destroys any.

Where a wheel moves in its bearing, x and the play change with its displacement, to first order: the line of action
keeps its direction.  Force and moments are the derivatives of the depths, so the powers of the forces on both bodies
add up to force times rate of depth.  A viscous drag also acts without contact.
"""

import math
from typing import NamedTuple

import numpy as np

from ...language.errors import InputError
from ...tracing.compiled.choosing import where
from ...tracing.compiled.dual import as_type_of, plain
from ...tracing.compiled.family import family_with_default, inlined, kernel
from ...tracing.compiled.pinned import array_handle, cubic_at, cubic_rows
from ..laws import contract as law_contract
from ..laws.elastic import elastic_energy, elastic_force, root_parity
from ..observe import FORCE_ROW, PARTS, QUARTER_POINTS, lagrange
from ..wear import NoWear, SlidingContact, wear_rate
from ..wear.bins import record, update_joint_wear
from . import contract
from .dry import Clip, SurfaceMotion, pressed_contact_at

DRIVE, COAST = 1.0, -1.0  # sides of the play
FLANKS = ("drive", "coast")  # their names, in the order of the contacts


class Teeth(NamedTuple):
    """The path of contact of involute teeth."""

    pitch: float  # m, base pitch
    approach: float  # share of it before the pitch point
    near: float  # m, lever of friction at the pitch point about the first centre; below 0 for inner teeth
    far: float  # m, about the second centre
    pair: float = law_contract.NEVER  # number of the pair that carries the force, from the first step of a contact on


class Stiffness(NamedTuple):
    """The stiffness of teeth over that of their elastic law: a periodic cubic along the path of contact."""

    rows: float  # address, see `cubic_at`, over the share of a base pitch
    count: float


class Scaled(NamedTuple):
    """An elastic law at a place of the path of contact."""

    elastic: tuple  # elastic_force
    factor: float  # 1


class Mesh(NamedTuple):
    """Play between two flanks."""

    clearance: float  # m, half of the play along the line of action; rad for a coupling; of stops a small part of it
    side: float  # 1; other joints have a journal
    arm_proximal: float  # m, by which the angle of the first body adds to x; 1 for a coupling
    arm_distal: float  # m, likewise of the second body; below 0 if both turn in the same sense
    drag: float  # N s/m, along the line of action
    reach: float  # m or rad, half of the play
    middle: float  # m or rad, position of its middle
    law: tuple  # contact_force, of each flank
    elastic: tuple  # elastic_force
    friction: tuple  # friction_force, of each flank
    teeth: tuple  # Teeth, or () where nothing follows them
    stiffness: tuple  # Stiffness, or () if it is constant
    wear: tuple  # wear_rate


class MeshGap(NamedTuple):
    """Position of the teeth, and the forces on the second centre for a unit of force on a flank, in the fixed frame."""

    x: float  # m, along the line of action
    v: float  # m/s
    wider: float  # m, by which the displacement of the centres widens both sides of the play
    widening: float  # m/s, its rate
    across_x: float  # 1, across the line of centres, of the drive flank; the coast flank has the opposite
    across_y: float
    apart_x: float  # 1, along the line of centres, of both flanks
    apart_y: float
    roll: float  # rad, angle of the first wheel relative to the line of centres
    spin: float  # rad/s, of the first wheel relative to the second
    slide_x: float  # m/s, of the second centre relative to the first
    slide_y: float


FlankContact = NamedTuple(
    "FlankContact",
    [*contract.CONTACT_FIELDS, *((name, float) for name in ("drag_power", "pitches", "place", "torque", "turned"))],
)
FlankContact.__doc__ = """The observables of a flank.

drag_power : W, of the drive flank; pitches : 1, see `_pitches`; place : m, of the point of contact from the pitch point
in the direction of the flank's normal; torque : N m, on the first wheel by the varying stiffness; turned : W.
"""


@contract.contact_modes.member(Mesh)
def _contact_modes_mesh(joint):
    # an acting contact has located maxima: also of the position in the play, and of the power of the drag
    return contract.ContactModes(law_contract.ACTS | law_contract.MEETS, law_contract.PRESSED), contract.ContactModes(
        law_contract.ACTS | law_contract.MEETS, law_contract.PRESSED
    )


@contract.parts.member(Mesh)
def _parts_mesh(joint):
    teeth = (joint.teeth,) if type(joint.teeth) in law_contract.guards.members else ()
    laws = Clip(), joint.law, joint.friction, *teeth
    return tuple([contract.Part(law, flank) for flank in range(2) for law in laws])


law_contract.guards.member(Teeth)(law_contract.guards_of_pieces)


@law_contract.guard_values.member(Teeth)
def _guard_values_teeth(teeth, start, contact, root):
    if teeth.pair == law_contract.NEVER:
        return law_contract.NEVER, law_contract.NEVER, 1.0
    passed = contact.guard_quantity - teeth.pair
    return passed - 1.0, -passed, law_contract.NEVER


@law_contract.latched.member(Teeth)
def _latched_teeth(teeth, event, contact, root):
    if event in (law_contract.ENTERED, law_contract.LEFT):
        return (law_contract.NEVER,)
    if event == law_contract.FIRST_STEP:
        return (math.floor(contact.guard_quantity),)
    return (teeth.pair + (1.0 if event == law_contract.END_PASSED else -1.0),)


contract.guard_quantity.member(FlankContact)(lambda contact: contact.pitches)
contract.power_stored.member(FlankContact)(lambda contact: contact.elastic * contact.rate + contact.turned)
elastic_force.member(Scaled)(lambda scaled, pen: scaled.factor * elastic_force(scaled.elastic, pen))
elastic_energy.member(Scaled)(lambda scaled, pen: scaled.factor * elastic_energy(scaled.elastic, pen))
root_parity.member(Scaled)(lambda scaled: root_parity(scaled.elastic))


@contract.power_lost.member(FlankContact)
def _power_lost_at_flank(contact):
    return (contact.normal - contact.elastic) * contact.rate + contact.drag_power


@inlined
def flank_offsets(joint, offsets, flank):
    """Return the Offsets of flank number `flank`, from those of the joint."""
    laws = (joint.law, joint.friction, joint.teeth) if joint.teeth else (joint.law, joint.friction)
    return contract.repeated_offsets(offsets, flank, laws)


@inlined
def _pitches(joint, roll, side):
    """Return how many pitches the contact of a flank has passed since the beginning of a path of contact.

    At an angle of 0 of the first wheel the drive flank touches at the pitch point, and the coast flank half a pitch on.
    """
    return side * joint.arm_proximal * roll / joint.teeth.pitch + joint.teeth.approach + (0.25 - 0.25 * side)


@inlined
def _tangent(gap, side):
    """Return the direction of a flank at the point of contact: its normal turned by 90 degrees."""
    return -(side * gap.across_y + gap.apart_y), side * gap.across_x + gap.apart_x


@inlined
def _slip(joint, gap, side, place):
    """Return the speed (m/s) at which the first flank slides on the second one, by which friction does its work."""
    x, y = _tangent(gap, side)
    twist_speed = gap.v + gap.across_x * gap.slide_x + gap.across_y * gap.slide_y  # without the motion of the centres
    rolling = joint.teeth.near / joint.arm_proximal * twist_speed - x * gap.slide_x - y * gap.slide_y
    return place * gap.spin + rolling


@kernel
def _flank_contact(joint, gap, offsets, state, number):
    side = (DRIVE, COAST)[number]
    depth = side * (gap.x - joint.middle) - gap.wider - joint.reach
    rate = side * gap.v - gap.widening
    drag_power = joint.drag * gap.v * gap.v if number == 0 else as_type_of(0.0, depth)
    zero, speed = as_type_of(0.0, depth), abs(rate)
    if not law_contract.touches(state.mode[offsets.contact + number]):
        return FlankContact(zero, zero, speed, rate, depth, zero, zero, drag_power, zero, zero, zero, zero)
    at_flank = flank_offsets(joint, offsets, number)
    slip = tangential = pitches = place = torque = turned = zero
    if joint.teeth:
        at_teeth = contract.after_law(contract.after_law(at_flank, joint.law), joint.friction)
        teeth = contract.with_current_state(joint.teeth, state.y, state.latched, at_teeth)
        pitches = _pitches(joint, gap.roll, side)
        pair = where(teeth.pair > law_contract.NEVER, teeth.pair, math.floor(plain(pitches)))
        place = teeth.pitch * (pitches - pair - teeth.approach)
        slip = _slip(joint, gap, side, place)
    current = joint
    if joint.stiffness:
        root = state.y[state.roots + at_flank.contact]
        factor, slope, _ = cubic_at(*joint.stiffness, pitches - math.floor(plain(pitches)))
        current = joint._replace(elastic=Scaled(joint.elastic, factor))
        energy_slope = slope * elastic_energy(joint.elastic, root * root)
        torque = -side * joint.arm_proximal / joint.teeth.pitch * energy_slope
        turned = -torque * (gap.v + joint.arm_distal * gap.spin) / (joint.arm_proximal + joint.arm_distal)
    contact = pressed_contact_at(current, SurfaceMotion(depth, rate, slip), at_flank, state)
    if joint.teeth:
        tangential = contact.tangential
    observed = contact.normal, tangential, slip, rate, depth, contact.elastic, contact.raw, drag_power
    return FlankContact(*observed, pitches, place, torque, turned)


@contract.load.member(Mesh)
def _load_mesh(joint, gap, offsets, state):
    drive, coast = [_flank_contact(joint, gap, offsets, state, number) for number in range(2)]
    driving, parting = drive.normal - coast.normal + joint.drag * gap.v, drive.normal + coast.normal
    across, moment = driving, -joint.arm_proximal * driving
    if joint.stiffness:  # a couple of forces on both centres keeps its torque in balance
        torque = drive.torque + coast.torque
        across, moment = driving - torque / (joint.arm_proximal + joint.arm_distal), moment + torque
    flanks = contract.Load(
        fx=across * gap.across_x + parting * gap.apart_x,
        fy=across * gap.across_y + parting * gap.apart_y,
        moment_proximal=moment,
        moment_distal=-joint.arm_distal * driving,
        contacts=(drive, coast),
    )
    return _with_friction(joint, gap, _with_friction(joint, gap, flanks, DRIVE, 0), COAST, 1) if joint.teeth else flanks


@inlined
def _with_friction(joint, gap, load, side, number):
    """Return the Load with the friction of a flank, which acts on the first wheel along the tangent."""
    force, place, (x, y) = load.contacts[number].tangential, load.contacts[number].place, _tangent(gap, side)
    return contract.Load(
        fx=load.fx - force * x,
        fy=load.fy - force * y,
        moment_proximal=load.moment_proximal + force * (joint.teeth.near + place),
        moment_distal=load.moment_distal + force * (joint.teeth.far - place),
        contacts=load.contacts,
    )


@contract.gap_histories.member(Mesh)
def _gap_histories_mesh(joint, gap, side):
    zero = as_type_of(0.0, gap.x)
    return gap.x, zero, gap.v, zero


@contract.load_histories.member(Mesh)
def _load_histories_mesh(joint, load):
    drive, coast = load.contacts
    return drive.normal + coast.normal, as_type_of(0.0, drive.normal)


def stiffness_of(rows, name):
    """Return the Stiffness of a table of a joint, () without one; InputError if it is not above 0 everywhere."""
    from scipy.interpolate import CubicSpline

    if rows is None:
        return ()
    curve = CubicSpline(rows["pitch"], rows["factor"], bc_type="periodic")
    places = np.append(curve.x, curve.derivative().roots(extrapolate=False))
    lowest = places[np.nanargmin(curve(places))]
    if not curve(lowest) > 0.0:
        raise InputError(
            f"joints.{name}.mesh_stiffness: the cubic through its rows falls to {curve(lowest):.3g} at the pitch "
            f"{lowest:.3g}; it must stay above 0, so add rows there"
        )
    table = cubic_rows(curve)
    return Stiffness(array_handle(table), float(len(table)))


# ---------------------------------------------------------------------------------------------- wear

# Depth over the flanks of both wheels, a mean over the teeth of each.  A pair of teeth that passes a place of its path
# at the distance s from the pitch point wears them by k w |v| / |u|: w is the force per face width, v the sliding
# speed, and u the speed of the contact along the flank, spin times radius of curvature (Flodin & Andersson 1997,
# "Simulation of mild wear in spur gears", Wear 207).  The bins divide the path of contact, first of the drive flank,
# then of the coast flank.

#: (QUARTER_POINTS + 2, PARTS + 1): from values at the quarters of a step to those at the ends of its parts.
_TO_PARTS = lagrange(np.arange(QUARTER_POINTS + 2) / (QUARTER_POINTS + 1), np.arange(PARTS + 1) / PARTS).T.copy()


@record.member(Mesh)
def _record_mesh(joint, gap, body_angles, j, instant):
    for flank in range(2):
        instant.step.positions[j + flank, 0, instant.number] = gap.roll


@update_joint_wear.member(Mesh)
def _update_joint_wear_mesh(joint, j, step_and_totals):
    for flank in range(2):
        if law_contract.touches(step_and_totals[0].mode[j + flank]):
            _update_flank_wear(joint.wear, joint, j, flank, step_and_totals)


@family_with_default
def _update_flank_wear(law, joint, j, flank, step_and_totals):
    """Add the wear of a flank of a joint, whose first contact is `j`, over a Step."""
    step, totals = step_and_totals
    bins, previous = int(law.bins) // 2, 0.0
    for i in range(PARTS + 1):
        roll = 0.0
        for k in range(QUARTER_POINTS + 2):
            roll += _TO_PARTS[k, i] * step.positions[j + flank, 0, k]
        place = _pitches(joint, roll, DRIVE if flank == 0 else COAST) * bins
        if i > 0:
            forces = step.step_values[j + flank, FORCE_ROW, i - 1], step.step_values[j + flank, FORCE_ROW, i]
            line_load = 0.5 * max(forces[0] + forces[1], 0.0) / law.length
            first_bin = 2 * j * totals.stride + flank * bins
            _add_wear(joint, law, line_load, (previous, place), (totals.depths, first_bin, totals.stride, bins))
        previous = place


@_update_flank_wear.member(NoWear)
def _update_flank_wear_no_wear(law, joint, j, flank, step_and_totals):
    pass


@kernel
def _add_wear(joint, law, line_load, span, target):
    """Add the wear of a part of a step, under a line load (N/m), to the bins that the contact passes.

    span : places at both ends, in bins; target : depths (m), index of the first bin, distance of the bodies, bins
    """
    teeth, (depths, first_bin, stride, bins) = joint.teeth, target
    low, high, width = min(span[0], span[1]), max(span[0], span[1]), teeth.pitch / target[3]
    ratio, count = joint.arm_distal / joint.arm_proximal, 2.0 * math.pi * joint.arm_proximal / teeth.pitch
    sliding = SlidingContact(line_load, 0.0, 1.0, 0.0, 0.0, line_load, 0.0, 0.0)
    first_rate, second_rate = wear_rate(law, sliding)
    for number in range(math.floor(low), math.floor(high) + 1):
        position = number % bins
        begin = (position + max(low - number, 0.0)) * width - teeth.approach * teeth.pitch
        end = (position + min(high - number, 1.0)) * width - teeth.approach * teeth.pitch
        slid = 0.5 * abs(1.0 + 1.0 / ratio) * (end * abs(end) - begin * abs(begin)) / (width * count)
        middle = (position + 0.5) * width - teeth.approach * teeth.pitch
        depths[first_bin + position] += first_rate * slid / abs(teeth.near + middle)
        depths[first_bin + stride + position] += second_rate * slid / abs(teeth.far - middle)


def worn_volume(joint, *depths):
    """Return the volume (m^3) worn off the teeth of both wheels, from their mean depths (bins,) m by bin."""
    teeth, bins = joint.teeth, len(depths[0]) // 2
    middles = np.tile((np.arange(bins) + 0.5) / bins - teeth.approach, 2) * teeth.pitch
    radii = np.abs(teeth.near + middles), np.abs(teeth.far - middles)
    # of all teeth of a wheel, a bin is as long as the turn of the wheel times the radius of curvature, over the bins
    turned = [float(np.sum(depth[: 2 * bins] * radius)) for depth, radius in zip(depths, radii, strict=True)]
    return 2.0 * math.pi / bins * joint.wear.length * sum(turned)
