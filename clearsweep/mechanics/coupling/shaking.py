"""The signals of vibration: force and moment of a mechanism on its frame, and the motion of places on its bodies."""

from typing import NamedTuple

from ...contracts.catalogue import Channel
from ...tracing.compiled.dual import Moving, slope, value
from ...tracing.compiled.family import inlined
from ..machines.contract import body_motions, gravity_of, load_resultants, pose_at
from ..observe import ANGLE, AX, AY, FORCE_SQUARE, FORCE_X, FORCE_Y, MOMENT, PLACE_WIDTH, PLACES, TIME, VX, VY


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
