"""The interface of mechanisms: a description, and the functions of the compiled form.

A mechanism is a file or, if that would be long, a folder: a `catalogue.Mechanism` that describes it, and the members
of the families below for its compiled type.  Nothing else refers to it: its name, keys, joints and channels are
read from that description, and the types in the compiled form choose the code.

Joints without clearance are types too: a planar machine has a site, `Ideal()` or `Open()`, for each of its joints; its
`accelerate` is generated and eliminates the constraints of ideal joints.  A free crank is a further coordinate.  Loads
on bodies are further values of the compiled form, which `accelerate` reads.
"""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from ...contracts.catalogue import Channel
from ...tracing.compiled.dual import Moving, as_type_of, slope, value
from ...tracing.compiled.family import family, family_with_default, inlined, kernel
from ..observe import ANGLE, AX, AY, FORCE_SQUARE, FORCE_X, FORCE_Y, MOMENT, PLACE_WIDTH, PLACES, TIME, VX, VY


class IdealMotion(NamedTuple):
    """An ideal mechanism at drive angles, as arrays of any shape (...)."""

    position: np.ndarray  # of the output, in the unit of its catalogue.Output, m or rad
    velocity: np.ndarray  # the unit of the output per s
    acceleration: np.ndarray  # the unit of the output per s^2
    reactions: Mapping[str, np.ndarray]  # joint -> (..., 2) N, force on its distal body
    torque: np.ndarray | None = None  # N m, of the drive on the crank, or None if it is not known


class Built(NamedTuple):
    """A mechanism with numbers and clearances."""

    value: tuple  # compiled form
    start: np.ndarray  # (2 n + 1,) coordinates, their rates, time, with the distal pins at the requested offsets
    lengths: np.ndarray  # (n,) m: displacement of the bodies for a unit of each coordinate
    size: float  # m, size of the machine, which determines the rounding of positions
    rate: float  # rad/s, time scale: speed of the crank, or approach speed over clearance


# ---------------------------------------------------------------------------------------------- the compiled form


class Ideal(NamedTuple):
    """A joint without clearance: its pins coincide."""


class Open(NamedTuple):
    """A joint with clearance: only its load acts between its bodies."""


class Motion(NamedTuple):
    """Accelerations of a mechanism."""

    accelerations: tuple  # of the coordinates
    output: float  # of the output, in its unit per s^2; 0 without one
    torque: float  # N m, of the drive; 0 without one


class GapAcceleration(NamedTuple):
    """Accelerations of a Gap."""

    ax: float  # m/s^2
    ay: float
    proximal: float  # rad/s^2
    distal: float


class BodyMotion(NamedTuple):
    """Inertia and motion of a body in the plane of the mechanism."""

    mass: float  # kg
    spin: float  # N m s, angular momentum about its centre of mass, counter-clockwise
    x: float  # m, centre of mass
    y: float
    vx: float  # m/s
    vy: float
    turn_xx: float  # 1/s, velocity of a point relative to the centre of mass for a unit of its x in the body's frame
    turn_xy: float
    turn_yx: float  # 1/s, likewise for a unit of its y
    turn_yy: float
    weighs: float  # 1: gravity acts on it; 0: on a housing it does not


@family
def pose_at(mechanism, y):
    """Return the pose, a NamedTuple specific to the mechanism, at the state `y`: coordinates, rates, time."""


@family
def gaps(mechanism, pose):
    """Return a Gap for each open joint, in the order of the sites."""


@family
def accelerate(mechanism, pose, loads):
    """Return the Motion under the joint loads `loads`, one Load for each open joint."""


@family
def impact_masses(mechanism, pose, joint_gaps):
    """Return, for each open joint, the effective mass (kg) of an impact along its Gap in `joint_gaps`.

    1 / (n^T J M^-1 J^T n), n being the unit vector along the gap, M the whole mass matrix and J the gap's derivatives
    by the coordinates: force over relative acceleration.
    """


@family
def energy(mechanism, pose):
    """Return the kinetic energy (J) and the power (W) of gravity and of loads that depend only on the pose."""


@family
def body_angles(mechanism, y):
    """Return the angles (rad) of the proximal and the distal body of every open joint at the state `y`.

    For a spatial joint it is the bearing's x axis, a Vector in the frame of the journal.
    """


@family_with_default
def crank_rate(mechanism, pose, nominal):
    """Return the crank speed (rad/s), by which the drive's torque does work; `nominal` if it is constant."""
    return nominal


@family_with_default
def load_power(mechanism, motion):
    """Return the power (W) of loads that depend on the Motion, such as friction in joints without clearance."""
    return 0.0


@family_with_default
def friction_laws(mechanism):
    """Return the law of each friction load: in joints without clearance, or with a given size."""
    return ()


@family_with_default
def with_friction_laws(mechanism, laws):
    """Return the mechanism with other `laws` of its friction loads, of the same types."""
    return mechanism


@family_with_default
def friction_slips(mechanism, motion):
    """Return the sliding speed at which the law of each friction load is evaluated, for a Motion.

    The unit is m/s, or rad/s for a couple of a given size.
    """
    return ()


@family_with_default
def friction_powers(mechanism, motion):
    """Return the power (W) of each friction load for a Motion, negative if it dissipates energy."""
    return ()


@family
def body_motions(mechanism, pose):
    """Return the BodyMotion of every body that moves, in the order of their numbers."""


@family
def gravity_of(mechanism):
    """Return the acceleration of gravity (m/s^2) along x and y."""


@family_with_default
def load_resultants(mechanism, pose):
    """Return force x, y (N) and moment about the origin (N m) of each load on all moving bodies together.

    Friction, whose reaction acts on another body, has none.
    """
    return ()


@family_with_default
def link_signals(mechanism, pose, loads, motion):
    """Return the crank's angle (rad), then of each link that bends its modes (m) and the normal forces (N) at stations.

    The displacements (m) of each housing along x and y follow.  () without such links and housings.
    """
    return ()


@family_with_default
def link_signal_count(mechanism):
    """Return the number of `link_signals`."""
    return 0


@family
def output_error(mechanism, pose):
    """Return the deviation of the output from the ideal mechanism, in its unit, and its rate."""


@family
def describe(mechanism, y, pose, motion):
    """Return the values of the time histories of the bodies, in channel order."""


def has_finite_accelerations(mechanism, start: np.ndarray, no_loads: tuple) -> bool:
    """Return whether all accelerations at the initial state are finite; no_loads : a Load of zeros per open joint."""
    try:
        with np.errstate(all="ignore"):
            motion = accelerate(mechanism, pose_at(mechanism, start), no_loads)
    except ZeroDivisionError:
        return False
    return bool(np.all(np.isfinite([*motion.accelerations, motion.torque])))


@inlined
def gap_accelerations(mechanism, y, motion):
    """Return a GapAcceleration for each open joint: time derivatives of the rates from `gaps`."""
    return tuple([_slope(gap) for gap in gaps(mechanism, pose_at(mechanism, Moving(y, motion.accelerations)))])


@kernel
def _slope(gap):
    """Return the GapAcceleration of a Gap of Duals; all its numbers have the same type."""
    ax = slope(gap.vx)
    return GapAcceleration(
        ax,
        as_type_of(slope(gap.vy), ax),
        as_type_of(slope(gap.spin_proximal), ax),
        as_type_of(slope(gap.spin_distal), ax),
    )


# ---------------------------------------------------------------------------------------------- signals of vibration


class CompiledPlace(NamedTuple):
    """A point of a body whose motion is observed."""

    body: tuple  # its number, as empty tuples
    x: float  # m, from the centre of mass, in the frame of the body
    y: float


class Shaking(NamedTuple):
    """The signals of a scene with vibration, besides force and moment on the frame."""

    places: tuple  # of CompiledPlace
    unreacted: tuple  # numbers of the loads that the frame does not react, as empty tuples
    x: float  # m, point of the moment
    y: float


#: Time histories of the frame, after those of the joints.
FRAME_CHANNELS = (
    Channel("frame/force_x", "N", "force of the mechanism on its frame, x"),
    Channel("frame/force_y", "N", "force of the mechanism on its frame, y"),
    Channel("frame/moment", "N*m", "moment of the mechanism on its frame"),
)
#: Time histories of a place, whose name takes the place of {}.
PLACE_CHANNELS = (
    Channel("{}/ax", "m/s^2", "acceleration of the place {}, x"),
    Channel("{}/ay", "m/s^2", "acceleration of the place {}, y"),
)


def signal_count(shaking):
    """Return the number of signals; `shaking` is a Shaking, or () without vibration."""
    return PLACES + PLACE_WIDTH * len(shaking.places) if shaking else 0


@inlined
def frame_forces(scene, y, pose, motion):
    """Return force x, y (N) and moment (N m) on the frame at the state `y`, and the BodyMotions with slopes.

    The force is minus the sum of m (a - g) of all bodies, the moment is minus the rate of their angular momentum plus
    that of their weights: every other force acts between the bodies and the frame, the drive's included.
    """
    mechanism, shaking = scene.mechanism, scene.shaking
    bodies = body_motions(mechanism, pose_at(mechanism, Moving(y, motion.accelerations)))
    gravity_x, gravity_y = gravity_of(mechanism)
    fx = fy = moment = 0.0
    for i in range(len(bodies)):
        body = bodies[i]
        force_x = body.mass * (body.weighs * gravity_x - slope(body.vx))
        force_y = body.mass * (body.weighs * gravity_y - slope(body.vy))
        fx, fy = fx + force_x, fy + force_y
        moment = moment + (value(body.x) * force_y - value(body.y) * force_x - slope(body.spin))
    resultants = load_resultants(mechanism, pose)
    for i in range(len(shaking.unreacted)):
        load_x, load_y, load_moment = resultants[len(shaking.unreacted[i])]
        fx, fy, moment = fx + load_x, fy + load_y, moment + load_moment
    return fx, fy, moment - (shaking.x * fy - shaking.y * fx), bodies


@inlined
def put_signals(scene, y, pose, motion, o, row, column):
    """Write the signals at the state `y` to row `row` of `o`, from `column` on."""
    shaking = scene.shaking
    fx, fy, moment, bodies = frame_forces(scene, y, pose, motion)
    o[column + TIME, row], o[column + ANGLE, row] = y[2 * len(scene.coordinates)], y[0]
    o[column + FORCE_X, row], o[column + FORCE_Y, row] = fx, fy
    o[column + FORCE_SQUARE, row], o[column + MOMENT, row] = fx * fx + fy * fy, moment
    for i in range(len(shaking.places)):
        vx, vy = place_velocity(shaking.places[i], bodies)
        first = column + PLACES + PLACE_WIDTH * i
        o[first + VX, row], o[first + VY, row] = value(vx), value(vy)
        o[first + AX, row], o[first + AY, row] = slope(vx), slope(vy)


@inlined
def place_velocity(place, bodies):
    """Return the velocity (m/s) along x and y of a CompiledPlace, its slopes the accelerations, from BodyMotions."""
    body = bodies[len(place.body) - 1]
    vx = body.vx + place.x * body.turn_xx + place.y * body.turn_yx
    return vx, body.vy + place.x * body.turn_xy + place.y * body.turn_yy


@inlined
def vibration_histories(scene, y, pose, motion):
    """Return the time histories of vibration: of FRAME_CHANNELS, then PLACE_CHANNELS of each place."""
    fx, fy, moment, bodies = frame_forces(scene, y, pose, motion)
    histories = (fx, fy, moment)
    for i in range(len(scene.shaking.places)):
        vx, vy = place_velocity(scene.shaking.places[i], bodies)
        histories = (*histories, slope(vx), slope(vy))
    return histories
