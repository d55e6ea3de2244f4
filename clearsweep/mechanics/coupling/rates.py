"""The right-hand side: rates of the state, and the observables of the motion.

The state is a vector of n numbers: coordinates q, their rates v, time t, one root s per contact, and the internal
states of laws that have rates.  s is the square root of the penetration while the surfaces touch.  The independent
variable is not time but tau, with

    dt/dtau = kappa,   1/kappa = sigma * sum over contacts that touch of 1/s,   kappa = 1 without contact,

and ds/dtau = kappa (rate + relaxation) / (2 s).  A Hertzian contact is singular in time: its force varies as t^1.5 at
both ends, where any high-order method loses its order.  In tau it is smooth: the force is K s^3 and s crosses zero
linearly.  So entry and separation are ordinary points, and the separation is a simple root.  The relaxation keeps s^2
equal to the penetration that follows from the coordinates (Baumgarte 1972, one integration constant).
"""

from typing import NamedTuple

import numpy as np

from ...contracts.catalogue import Channel
from ...tracing.compiled.choosing import cond, rolled_range
from ...tracing.compiled.dual import Seeded, as_dual, as_type_of, rate_or_slope, slope
from ...tracing.compiled.family import Entry, entry, inlined, kernel, known, map_joints, shaped
from ..joints.contract import (
    JointState,
    Load,
    after_joint,
    after_number,
    after_part,
    contacts_at_speed,
    counts_of_part,
    extra_channel_count,
    extra_channels,
    extra_observables,
    first_offsets,
    gap_histories,
    guard_quantity,
    history_count_of,
    load,
    load_histories,
    observable_count,
    parts,
    power_lost,
    power_stored,
    total_counts,
    with_current_state,
)
from ..joints.spatial.forces import CHANNELS as SPATIAL_CHANNELS
from ..joints.spatial.forces import POINT_CHANNELS
from ..joints.worn import pairs, with_angles, with_body_angles
from ..laws.contract import internal_rates, internal_state, touches
from ..machines.contract import (
    FRAME_CHANNELS,
    PLACE_CHANNELS,
    accelerate,
    body_angles,
    crank_rate,
    describe,
    energy,
    friction_laws,
    friction_powers,
    gaps,
    link_signal_count,
    link_signals,
    load_power,
    output_error,
    pose_at,
    signal_count,
    vibration_histories,
)
from ..observe import (
    ACCELERATION,
    DRIVE,
    ERROR,
    ERROR_RATE,
    GRAVITY,
    KAPPA,
    KINETIC,
    TORQUE,
    Observed,
    film_column,
    write_contact_observables,
)
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


@inlined
def _gaps_with_angles(scene, y, joint_gaps):
    return with_body_angles(scene.joints, joint_gaps, body_angles(scene.mechanism, y))


@kernel
def gaps_with_angles(scene, y, joint_gaps):
    """Return the Gaps of a scene at the state `y`, with the rotation (rad) of the bodies of worn joints."""
    return _gaps_with_angles(scene, y, joint_gaps) if uses_body_angles(map(type, scene.joints)) else joint_gaps


@known
def uses_body_angles(joint_types):
    """Return whether a type of joint uses the rotation of its bodies."""
    return any(joint_type in with_angles.members for joint_type in joint_types)


@inlined
def evaluate_motion(scene, y, mode, latched):
    """Return the pose at the state `y`, and the Gaps, Loads and Motion that follow from the pose."""
    pose = pose_at(scene.mechanism, y)
    joint_gaps = gaps_with_angles(scene, y, gaps(scene.mechanism, pose))
    state = JointState(y, mode, latched, 2 * len(scene.coordinates) + 1)
    joints = joints_with_mass(scene, pose, joint_gaps, state)
    loads = loads_of(joints, joint_gaps, state)
    scene = with_friction_states(scene, y)
    loads = with_sticking_forces(scene, y, pose, joint_gaps, loads, mode)
    return pose, joint_gaps, loads, accelerate(scene.mechanism, pose, loads)


@inlined
def relaxed_rate(reference_rate, rate, depth, root):
    """Return half the rate of the square of a root of penetration, m/s, with its relaxation towards the depth."""
    return 0.5 * (rate + reference_rate * (depth - root * root))


@inlined
def root_rate(scene, contact, state, kappa, c):
    """Return the rate (m^0.5 per unit of tau) of the root of penetration of Contact number `c`, which touches."""
    approach = relaxed_rate(scene.reference_rate, contact.rate, contact.depth, state.y[state.roots + c])
    if total_counts(scene.joints).contact == 1:
        return approach * (1.0 / scene.sigma)
    return approach * kappa_over_root(scene, state.y, state.mode, kappa, c)


@inlined
def _zero_rate(scene, contact, state, kappa, c):
    return as_type_of(0.0, state.y[state.roots + c])


_rate_of_root = cond(root_rate, _zero_rate)


class _ObservableRows(NamedTuple):
    """Destination of the observables of contacts."""

    contacts: int  # number of contacts
    o: tuple  # (columns, 16)
    row: int
    is_converged: bool  # whether the state is on the solution, not an iterate


@kernel
def _put_number(number, _, column, destination):
    values, row = destination
    values[column, row] = number


_put_numbers = map_joints(_put_number, after_number)


@inlined
def _put_contacts(joint, load, offsets, destination):
    o, row = destination.o, destination.row
    for i in range(len(load.contacts)):
        contact, c = load.contacts[i], offsets.contact + i
        dissipated = power_lost(contact)
        observed_contact = Observed(
            normal=contact.normal,
            stored=power_stored(contact),
            lost=dissipated,
            tangential=contact.tangential,
            slip=contact.slip,
            raw=contact.raw,
            depth=contact.depth,
            rate=contact.rate,
            guard_quantity=guard_quantity(contact),
        )
        write_contact_observables(o, row, c, observed_contact)
        extra = extra_observables(contact, destination.is_converged)
        _put_numbers(extra, extra, film_column(destination.contacts, c, 0), (o, row))


_put_all_contacts = map_joints(_put_contacts, after_joint)


class RootRates(NamedTuple):
    """Destination of the rates of roots of penetration, and their inputs."""

    scene: Scene
    state: JointState
    kappa: float  # s
    k: tuple  # (n, 16) rates
    row: int


@inlined
def _put_roots(joint, load, offsets, destination):
    state = destination.state
    for i in range(len(load.contacts)):
        c = offsets.contact + i
        arguments = destination.scene, load.contacts[i], state, destination.kappa, c
        destination.k[state.roots + c, destination.row] = _rate_of_root(touches(state.mode[c]), arguments)


_put_all_roots = map_joints(_put_roots, after_joint)


@inlined
def rates(scene, y, mode, latched, k, o, row, is_converged=True):
    """Write the rates of `y` with respect to tau to row `row` of `k`, and the observables to row `row` of `o`.

    Return the pose, the Loads and the Motion.

    y : (n,) state; k : (n, 16) and o : (columns, 16), None to omit either; a row is one value of the last index;
    mode : (contacts,) mode of each contact; latched : see JointState; is_converged : whether the state is on the
    solution, not an iterate.
    """
    count = len(scene.coordinates)
    time_index = 2 * count
    pose, _, loads, motion = evaluate_motion(scene, y, mode, latched)
    kappa = time_scale(scene, y, mode)
    state, offsets = JointState(y, mode, latched, time_index + 1), first_offsets(scene.joints, time_index + 1)
    if k is not None:
        for i in range(count):
            k[i, row] = kappa * y[count + i]
            k[count + i, row] = kappa * motion.accelerations[i]
        k[time_index, row] = kappa
        _put_all_roots(scene.joints, loads, offsets, RootRates(scene, state, kappa, k, row))
        put_internal_rates(scene.joints, loads, state, kappa, k[:, row])
        put_friction_rates(scene, y, motion, kappa, k[:, row])
    if o is not None:
        o[KAPPA, row] = kappa
        o[DRIVE, row] = motion.torque * crank_rate(scene.mechanism, pose, scene.reference_rate)
        o[KINETIC, row], external_power = energy(scene.mechanism, pose)
        o[GRAVITY, row] = external_power + load_power(scene.mechanism, motion)
        o[ACCELERATION, row] = motion.output
        o[TORQUE, row] = motion.torque
        powers, film_columns = friction_powers(scene.mechanism, motion), observable_count(scene.joints)
        for i in range(len(powers)):
            o[film_columns + i, row] = powers[i]
        _put_all_contacts(
            scene.joints, loads, offsets, _ObservableRows(total_counts(scene.joints).contact, o, row, is_converged)
        )
    return pose, loads, motion


@inlined
def put_error(scene, pose, o, row):
    """Write the output error at a `pose`; it comes from a table and is used only at the ends of steps."""
    o[ERROR, row], o[ERROR_RATE, row] = output_error(scene.mechanism, pose)


@inlined
def put_root_rates(scene, joint_gaps, loads, destination):
    """Write the rates of all roots of penetration to RootRates, from the Gaps of the joints.

    loads : the Loads at these coordinates and roots, but at other velocities; None if they are not known
    """
    offsets = first_offsets(scene.joints, destination.state.roots)
    if loads is None:
        loads = loads_of(scene.joints, joint_gaps, destination.state)
    else:
        loads = _loads_at_speed(scene.joints, pairs(loads, joint_gaps, 0, 0), offsets, destination.state)
    _put_all_roots(scene.joints, loads, offsets, destination)


@inlined
def _load_at_speed(joint, load_and_gap, offsets, state):
    load, gap = load_and_gap
    return load._replace(contacts=contacts_at_speed(joint, gap, offsets, state, load.contacts))


_loads_at_speed = map_joints(_load_at_speed, after_joint)


@inlined
def observed_width(scene):
    """Return the number of observables: of joints, then the power (W) of each friction load, then the signals."""
    return first_signal(scene) + scene_signal_count(scene)


@inlined
def scene_signal_count(scene):
    """Return the number of signals: of vibration, then of links that bend."""
    return signal_count(scene.shaking) + link_signal_count(scene.mechanism)


@inlined
def put_link_signals(scene, pose, loads, motion, o, row):
    """Write the signals of links that bend to row `row` of `o`."""
    signals, column = link_signals(scene.mechanism, pose, loads, motion), first_signal(scene)
    for i in range(len(signals)):
        o[column + signal_count(scene.shaking) + i, row] = signals[i]


@inlined
def first_signal(scene):
    """Return the column of the first signal of vibration among the observables."""
    return observable_count(scene.joints) + len(friction_laws(scene.mechanism))


class _SlopeColumn(NamedTuple):
    """Destination of the derivatives of roots of penetration, and their inputs."""

    scene: Scene
    state: JointState
    kappa: float  # s
    out: tuple  # (n,)


@inlined
def _put_root_slopes(joint, load, offsets, destination):
    state = destination.state
    for i in range(len(load.contacts)):
        c = offsets.contact + i
        destination.out[state.roots + c] = 0.0
        if touches(state.mode[c]):
            rate = root_rate(destination.scene, load.contacts[i], state, destination.kappa, c)
            destination.out[state.roots + c] = slope(as_dual(rate))


_put_all_root_slopes = map_joints(_put_root_slopes, after_joint)


@inlined
def differentiate(scene, y, mode, latched, jacobian, stage):
    """Write the exact derivatives of `rates` at the state `y` to `jacobian[stage]` (n, n), column by column."""
    n = len(scene.coordinates)
    _, size, _ = size_of(scene)
    for column in rolled_range(size):
        z = Seeded(y, column)
        _, _, loads, motion = evaluate_motion(scene, z, mode, latched)
        kappa = as_dual(time_scale(scene, z, mode))
        for i in range(n):
            jacobian[stage, i, column] = slope(kappa * z[n + i])
            jacobian[stage, n + i, column] = slope(kappa * motion.accelerations[i])
        jacobian[stage, 2 * n, column] = slope(kappa)
        out, state = jacobian[stage, :, column], JointState(z, mode, latched, 2 * n + 1)
        _put_all_root_slopes(
            scene.joints, loads, first_offsets(scene.joints, 2 * n + 1), _SlopeColumn(scene, state, kappa, out)
        )
        put_internal_rates(scene.joints, loads, state, kappa, out)
        put_friction_rates(scene, z, motion, kappa, out)


def slopes_entry(scene, y, mode, latched, jacobian, stage):
    """Evaluate `differentiate` with arrays from bare pointers; `scene` is a pointer to the Scene."""
    parameters = scene[0]
    contacts, n, latched_count = size_of(parameters)
    differentiate(
        parameters,
        shaped(y, (n,)),
        shaped(mode, (contacts,)),
        shaped(latched, (latched_count,)),
        shaped(jacobian, (3, n, n)),
        stage,
    )


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
    FRAME_CHANNELS,
    PLACE_CHANNELS,
)


class _SampleCursor(NamedTuple):
    """Destination of the time histories of a joint: its first contact and first column."""

    offsets: tuple  # Offsets of the joint
    column: int


@kernel
def _cursor_after(cursor, joint):
    return _SampleCursor(
        after_joint(cursor.offsets, joint), cursor.column + history_count_of(joint) + extra_channel_count(joint)
    )


@inlined
def _put_gap(joint, gap, cursor, destination):
    out, journal_sides = destination
    values = gap_histories(joint, gap, journal_sides[cursor.offsets.contact])
    for i in range(len(values)):
        out[cursor.column + i] = values[i]


@kernel
def _put_channel(number, _, column, values):
    values[column] = number


_put_channels = map_joints(_put_channel, after_number)


@inlined
def _put_force(joint, load, cursor, destination):
    values = load_histories(joint, load)
    first_column = cursor.column + history_count_of(joint) - len(values)
    for i in range(len(values)):
        destination[0][first_column + i] = values[i]
    extra = extra_channels(load.contacts[0])
    _put_channels(extra, extra, cursor.column + history_count_of(joint), destination[0])


_put_gaps, _put_forces = map_joints(_put_gap, _cursor_after), map_joints(_put_force, _cursor_after)


def sample_entry(scene, y, mode, latched, journal_sides, out, channels):
    """Write the first `channels` time histories at `y` to `out`."""
    parameters = scene[0]
    contacts, n, latched_count = size_of(parameters)
    values = shaped(out, (channels,))
    journal_sides, y = shaped(journal_sides, (contacts,)), shaped(y, (n,))
    mode, latched = shaped(mode, (contacts,)), shaped(latched, (latched_count,))
    pose, joint_gaps, loads, motion = evaluate_motion(parameters, y, mode, latched)
    cursor = _SampleCursor(first_offsets(parameters.joints, 0), describe(parameters.mechanism, y, pose, motion, values))
    _put_gaps(parameters.joints, joint_gaps, cursor, (values, journal_sides))
    _put_forces(parameters.joints, loads, cursor, (values, journal_sides))
    if parameters.shaking:
        histories = vibration_histories(parameters, y, pose, motion)
        for i in range(len(histories)):
            values[channels - len(histories) + i] = histories[i]


def slopes_of(scene, parameters) -> Entry:
    """Return the Entry of the derivatives of the right-hand side of `scene`."""
    return entry(slopes_entry, scene, "fiff", parameters)


def samples_of(scene, parameters) -> Entry:
    """Return the Entry of the time histories of `scene`."""
    return entry(sample_entry, scene, "fifff", parameters)


# ---------------------------------------------------------------------------------------------- loads of all joints


_loads = map_joints(load, after_joint)


@inlined
def loads_of(joints, gaps, state):
    """Return a Load for each joint of the tuple `joints`, with their Gaps."""
    return _loads(joints, gaps, first_offsets(joints, state.roots), state)


# ---------------------------------------------------------------------------------------------- internal states


class _RatesContext(NamedTuple):
    """Data for the rates of internal states."""

    load: Load
    state: tuple  # JointState
    kappa: float  # s
    out: np.ndarray  # (n,) rates of the state vector, or their slopes


class _RateContext(NamedTuple):
    """Data for the rate of one number."""

    touching: bool
    kappa: float  # s
    out: np.ndarray


@kernel
def _put_rate(rate, declared, index, context):
    rate = rate if context.touching or declared.survives_separation else as_type_of(0.0, rate)
    context.out[index] = rate_or_slope(context.kappa * rate)


@kernel
def _put_zero(declared, _, index, out):
    out[index] = 0.0


@kernel
def _survives(declared, _, index, context):
    return declared.survives_separation


_put_rates, _put_all_zeros, _survival_of_each = (
    map_joints(function, after_number) for function in (_put_rate, _put_zero, _survives)
)


@kernel
def _put_part_rates(part, _, offsets, context):
    if not counts_of_part(part).internal:
        return
    declared, touching = internal_state(part.law), touches(context.state.mode[offsets.contact + part.contact])
    if touching or True in _survival_of_each(declared, declared, 0, 0):
        law = with_current_state(part.law, context.state.y, context.state.latched, offsets)
        rates = internal_rates(law, context.load.contacts[part.contact])
        _put_rates(rates, declared, offsets.internal, _RateContext(touching, context.kappa, context.out))
    else:
        _put_all_zeros(declared, declared, offsets.internal, context.out)


_put_rates_of_parts = map_joints(_put_part_rates, after_part)


@kernel
def _put_joint_rates(joint, load, offsets, context):
    state, kappa, out = context
    joint_parts = parts(joint)
    _put_rates_of_parts(joint_parts, joint_parts, offsets, _RatesContext(load, state, kappa, out))


_put_rates_of_joints = map_joints(_put_joint_rates, after_joint)


@kernel
def put_internal_rates(joints, loads, state, kappa, out):
    """Put the rates of all internal states with respect to tau into `out`, or their slopes.

    Out of contact only numbers that are kept over separations have a rate.
    """
    _put_rates_of_joints(joints, loads, first_offsets(joints, state.roots), (state, kappa, out))
