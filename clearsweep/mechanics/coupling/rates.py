"""The right-hand side: rates of the state, and the observables of the motion.

The state is a vector of n numbers: coordinates q, their rates v, time t, one root s per contact, and the internal
states of laws that have rates.  s is the square root of the penetration while the surfaces touch.  The independent
variable is not time but tau, with

    dt/dtau = kappa,   1/kappa = sigma * sum over contacts that touch of 1/s,   kappa = 1 without contact,

and ds/dtau = kappa (rate + relaxation) / (2 s); in space the sum is the root of that of 1/s^2.  A Hertzian contact is
singular in time: its force varies as t^1.5 at both ends, where any high-order method loses its order.  In tau it is
smooth: the force is K s^3 and s crosses zero linearly.  So entry and separation are ordinary points, and the separation
is a simple root.  The relaxation keeps s^2 equal to the penetration that follows from the coordinates (Baumgarte 1972,
one integration constant).
"""

from typing import NamedTuple

from ...contracts.catalogue import Channel
from ...tracing.compiled.choosing import cond, lane_range, rolled_range
from ...tracing.compiled.dual import Seeded, as_dual, as_type_of, rate_or_slope, slope
from ...tracing.compiled.family import entries_of, inlined, kernel, shaped
from .. import observe
from ..joints import contract
from ..joints.spatial.forces import CHANNELS as SPATIAL_CHANNELS
from ..joints.spatial.forces import POINT_CHANNELS
from ..joints.worn import with_angles, with_body_angles
from ..laws.contract import internal_rates, internal_state, touches
from ..machines import contract as machine
from .inertia import joints_with_mass, with_sticking_forces
from .state import kappa_over_root, put_friction_rates, size_of, time_scale, with_friction_states


class Scene(NamedTuple):
    """A mechanism and its clearance joints; its type chooses the compiled code, its values are the parameters."""

    mechanism: tuple  # its compiled form
    joints: tuple  # one Joint per open joint, in the order of the sites
    coordinates: tuple  # as many zeros as there are coordinates; the number is part of the type
    reference_rate: float  # rad/s, crank speed, or approach speed over clearance
    sigma: float  # m^0.5, sets the unit of tau; any positive number
    shaking: tuple = ()  # shaking.Shaking, or () without vibration


@kernel
def gaps_with_angles(scene, y, joint_gaps):
    """Return the Gaps of a scene at the state `y`, with the rotation (rad) of the bodies of worn joints."""
    if not any(type(joint) in with_angles.members for joint in scene.joints):
        return joint_gaps
    return with_body_angles(scene.joints, joint_gaps, machine.body_angles(scene.mechanism, y))


@inlined
def evaluate_motion(scene, y, mode, latched, deepest_angles=None):
    """Return the pose at the state `y`, and the Gaps, Loads and Motion that follow from the pose.

    deepest_angles : of a stage, see `contract.JointState`.
    """
    pose = machine.pose_at(scene.mechanism, y)
    joint_gaps = gaps_with_angles(scene, y, machine.gaps(scene.mechanism, pose))
    state = contract.JointState(y, mode, latched, 2 * len(scene.coordinates) + 1, deepest_angles)
    joints = joints_with_mass(scene, pose, joint_gaps, state)
    loads = loads_of(joints, joint_gaps, state)
    scene = with_friction_states(scene, y)
    loads = with_sticking_forces(scene, y, pose, joint_gaps, loads, mode)
    return pose, joint_gaps, loads, machine.accelerate(scene.mechanism, pose, loads)


@inlined
def root_rate(scene, contact, state, kappa, c):
    """Return the rate (m^0.5 per unit of tau) of the root of penetration of Contact number `c`, which touches."""
    root = state.y[state.roots + c]
    # half the rate (m/s) of the square of the root, with its relaxation towards the depth
    approach = 0.5 * (contact.rate + scene.reference_rate * (contact.depth - root * root))
    if contract.total_counts(scene.joints).contact == 1:
        return approach * (1.0 / scene.sigma)
    return approach * kappa_over_root(scene, state.y, state.mode, kappa, c)


_rate_of_root = cond(root_rate, lambda scene, contact, state, kappa, c: as_type_of(0.0, state.y[state.roots + c]))


@inlined
def _contacts_of(loads):
    """Return the Contacts of all joints under their Loads."""
    return tuple([contact for load in loads for contact in load.contacts])


@inlined
def _put_contacts(loads, o, row, is_converged):
    """Write the observables of all contacts."""
    contacts = _contacts_of(loads)
    for c, contact in enumerate(contacts):
        dissipated = contract.power_lost(contact)
        observed = observe.Observed(
            normal=contact.normal,
            stored=contract.power_stored(contact),
            lost=dissipated,
            tangential=contact.tangential,
            slip=contact.slip,
            raw=contact.raw,
            depth=contact.depth,
            rate=contact.rate,
            guard_quantity=contract.guard_quantity(contact),
        )
        for column, number in enumerate(observed, observe.column_of(c, observe.NORMAL)):
            o[column, row] = number
        for column, number in enumerate(
            contract.extra_observables(contact, is_converged), observe.film_column(len(contacts), c, 0)
        ):
            o[column, row] = number


@inlined
def _put_root_rates(scene, loads, state, kappa, k, row):
    """Write the rates of all roots of penetration to row `row` of `k`."""
    for c, contact in enumerate(_contacts_of(loads)):
        k[state.roots + c, row] = _rate_of_root(touches(state.mode[c]), (scene, contact, state, kappa, c))


@inlined
def rates(scene, y, mode, latched, k, o, row, is_converged=True, deepest_angles=None):
    """Write the rates of `y` with respect to tau to row `row` of `k`, and the observables to row `row` of `o`.

    Return the pose, the Loads and the Motion.

    y : (n,) state; k : (n, 16) and o : (columns, 16), None to omit either; a row is one value of the last index;
    mode : (contacts,) mode of each contact; latched, deepest_angles : see JointState; is_converged : whether the state
    is on the solution, not an iterate.
    """
    count = len(scene.coordinates)
    time_index = 2 * count
    pose, _, loads, motion = evaluate_motion(scene, y, mode, latched, deepest_angles)
    kappa = time_scale(scene, y, mode)
    state = contract.JointState(y, mode, latched, time_index + 1)
    if k is not None:
        for i in range(count):
            k[i, row] = kappa * y[count + i]
            k[count + i, row] = kappa * motion.accelerations[i]
        k[time_index, row] = kappa
        _put_root_rates(scene, loads, state, kappa, k, row)
        put_internal_rates(scene.joints, loads, state, kappa, k[:, row])
        put_friction_rates(scene, y, motion, kappa, k[:, row])
    if o is not None:
        o[observe.KAPPA, row] = kappa
        o[observe.DRIVE, row] = motion.torque * machine.crank_rate(scene.mechanism, pose, scene.reference_rate)
        o[observe.KINETIC, row], external_power = machine.energy(scene.mechanism, pose)
        o[observe.GRAVITY, row] = external_power + machine.load_power(scene.mechanism, motion)
        o[observe.ACCELERATION, row] = motion.output
        o[observe.TORQUE, row] = motion.torque
        powers, film_columns = machine.friction_powers(scene.mechanism, motion), contract.observable_count(scene.joints)
        for i in range(len(powers)):
            o[film_columns + i, row] = powers[i]
        _put_contacts(loads, o, row, is_converged)
    return pose, loads, motion


@inlined
def put_error(scene, pose, o, row):
    """Write the output error at a `pose`; it comes from a table and is used only at the ends of steps."""
    o[observe.ERROR, row], o[observe.ERROR_RATE, row] = machine.output_error(scene.mechanism, pose)


@inlined
def put_root_rates(scene, joint_gaps, loads, state, kappa, k, row):
    """Write the rates of all roots of penetration to row `row` of `k` (n, 16), from the Gaps of the joints.

    loads : the Loads at these coordinates and roots, but at other velocities; None if they are not known
    """
    if loads is None:
        loads = loads_of(scene.joints, joint_gaps, state)
    else:
        items = list(zip(scene.joints, joint_gaps, loads, contract.offsets_of(scene.joints, state.roots), strict=True))
        contacts = [contract.contacts_at_speed(joint, gap, at, state, before) for joint, gap, before, at in items]
        loads = [before._replace(contacts=now) for before, now in zip(loads, contacts, strict=True)]
    _put_root_rates(scene, loads, state, kappa, k, row)


@inlined
def observed_width(scene):
    """Return the number of observables: of joints, then the power (W) of each friction load, then the signals."""
    return first_signal(scene) + scene_signal_count(scene)


@inlined
def scene_signal_count(scene):
    """Return the number of signals: of vibration, then of links that bend."""
    return machine.signal_count(scene.shaking) + machine.link_signal_count(scene.mechanism)


@inlined
def put_link_signals(scene, pose, loads, motion, o, row):
    """Write the signals of links that bend to row `row` of `o`."""
    signals, column = machine.link_signals(scene.mechanism, pose, loads, motion), first_signal(scene)
    for i in range(len(signals)):
        o[column + machine.signal_count(scene.shaking) + i, row] = signals[i]


@inlined
def first_signal(scene):
    """Return the column of the first signal of vibration among the observables."""
    return contract.observable_count(scene.joints) + len(machine.friction_laws(scene.mechanism))


def slopes_entry(scene, y, mode, latched, jacobian, stage):
    """Write the exact derivatives of `rates` at the state `y` to `jacobian[stage]` (n, n or more).

    Columns are in lanes; those beyond the state are zero.  Arrays are bare pointers; `scene` is a pointer to the Scene.
    """
    scene = scene[0]
    contacts, size, latched_count = size_of(scene)
    y, mode, latched = shaped(y, (size,)), shaped(mode, (contacts,)), shaped(latched, (latched_count,))
    width = observe.whole_registers(size)
    jacobian = shaped(jacobian, (3, size, width))
    for first in rolled_range(0, width, observe.STAGES):
        for lane in lane_range(observe.STAGES):
            _put_slopes(scene, Seeded(y, first + lane), mode, latched, jacobian[stage, :, first + lane])


@inlined
def _put_slopes(scene, z, mode, latched, out):
    """Write the slopes of the rates at a Seeded state `z` to `out` (n,)."""
    _, _, loads, motion = evaluate_motion(scene, z, mode, latched)
    kappa, n = as_dual(time_scale(scene, z, mode)), len(scene.coordinates)
    for i in range(n):
        out[i] = slope(kappa * z[n + i])
        out[n + i] = slope(kappa * motion.accelerations[i])
    out[2 * n] = slope(kappa)
    state = contract.JointState(z, mode, latched, 2 * n + 1)
    for c, contact in enumerate(_contacts_of(loads)):
        out[state.roots + c] = 0.0
        if touches(mode[c]):
            out[state.roots + c] = slope(as_dual(root_rate(scene, contact, state, kappa, c)))
    put_internal_rates(scene.joints, loads, state, kappa, out)
    put_friction_rates(scene, z, motion, kappa, out)


#: Time histories of a joint, in the order in which `sample_entry` writes them.
JOINT_CHANNELS = (
    Channel("x", "m", "journal centre relative to the bearing centre, fixed frame, x"),
    Channel("y", "m", "journal centre relative to the bearing centre, fixed frame, y"),
    Channel("vx", "m/s", "its rate, x"),
    Channel("vy", "m/s", "its rate, y"),
    Channel(
        "force_normal",
        "N",
        "normal force, pushing the journal back to the centre; below 0 only where a film or a law pulls",
    ),
    Channel("force_tangential", "N", "tangential force on the journal along the outward normal turned by +90 degrees"),
)
#: Time histories of a film, after those of its joint.
FILM_CHANNELS = (Channel("force_dry", "N", "dry share of the normal force"),)
#: Time histories of a rolling bearing, and of each of its elements.
ROLLING_CHANNELS = (
    *JOINT_CHANNELS[:4],
    Channel("cage_angle", "rad", "angle of the first element in the fixed frame"),
    Channel("force_normal", "N", "resultant of the forces of the elements"),
    Channel("force_tangential", "N", "friction of the bearing at half its bore, on the journal"),
)
ELEMENT_CHANNELS = (Channel("element_{}_force", "N", "force of element {}, from the angle of the first one on"),)
#: Time histories of a joint, of a spatial joint, and of each contact point of a spatial joint, the same for all joints;
#: of a rolling bearing; of the frame, and of a place.
CHANNELS = (
    JOINT_CHANNELS,
    FILM_CHANNELS,
    SPATIAL_CHANNELS,
    POINT_CHANNELS,
    ROLLING_CHANNELS,
    ELEMENT_CHANNELS,
    machine.FRAME_CHANNELS,
    machine.PLACE_CHANNELS,
)


def sample_entry(scene, y, mode, latched, journal_sides, out, channels):
    """Write the first `channels` time histories at `y` to `out`."""
    parameters = scene[0]
    contacts, n, latched_count = size_of(parameters)
    values = shaped(out, (channels,))
    journal_sides, y = shaped(journal_sides, (contacts,)), shaped(y, (n,))
    mode, latched = shaped(mode, (contacts,)), shaped(latched, (latched_count,))
    pose, joint_gaps, loads, motion = evaluate_motion(parameters, y, mode, latched)
    histories = machine.describe(parameters.mechanism, y, pose, motion)
    for i, (joint, offsets) in enumerate(
        zip(parameters.joints, contract.offsets_of(parameters.joints, 0), strict=True)
    ):
        of_gap = contract.gap_histories(joint, joint_gaps[i], journal_sides[offsets.contact])
        histories = (
            *histories,
            *of_gap,
            *contract.load_histories(joint, loads[i]),
            *contract.extra_channels(loads[i].contacts[0]),
        )
    for column, number in enumerate(histories):
        values[column] = number
    if parameters.shaking:
        histories = machine.vibration_histories(parameters, y, pose, motion)
        for i in range(len(histories)):
            values[channels - len(histories) + i] = histories[i]


#: Functions that give Entries of a scene: the derivatives of the right-hand side, the time histories.
slopes_of, samples_of = entries_of(slopes_entry, "fiff"), entries_of(sample_entry, "fifff")


# ---------------------------------------------------------------------------------------------- loads of all joints


@inlined
def loads_of(joints, joint_gaps, state):
    """Return a Load for each joint of the tuple `joints`, with their Gaps."""
    items = list(zip(joints, joint_gaps, contract.offsets_of(joints, state.roots), strict=True))
    return tuple([contract.load(joint, gap, offsets, state) for joint, gap, offsets in items])


# ---------------------------------------------------------------------------------------------- internal states


@kernel
def _put_rates_of_part(part, contact, offsets, state, kappa, out):
    declared, touching = internal_state(part.law), touches(state.mode[offsets.contact + part.contact])
    if touching or any(number.survives_separation for number in declared):
        law = contract.with_current_state(part.law, state.y, state.latched, offsets)
        for i, rate in enumerate(internal_rates(law, contact)):
            present_rate = rate if touching or declared[i].survives_separation else as_type_of(0.0, rate)
            out[offsets.internal + i] = rate_or_slope(kappa * present_rate)
    else:
        for i in range(len(declared)):
            out[offsets.internal + i] = 0.0


@kernel
def put_internal_rates(joints, loads, state, kappa, out):
    """Put the rates of all internal states with respect to tau into `out`, or their slopes.

    Out of contact only numbers that are kept over separations have a rate.
    """
    for number, part, offsets in contract.located_parts(joints, state.roots):
        if contract.counts_of(part.law).internal:
            _put_rates_of_part(part, loads[number].contacts[part.contact], offsets, state, kappa, out)
