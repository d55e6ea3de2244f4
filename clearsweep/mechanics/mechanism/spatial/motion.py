"""The equations of motion of a slider-crank in space, its energy and its time histories.

Newton-Euler for the rod in its own frame, about the point by which it hangs: there its inertia stands still.  The drive
torque keeps the crank's speed constant.
"""

from ...compiled import calculus as math
from ...compiled.attitude import accelerated, in_body, in_fixed
from ...compiled.family import family, kernel
from ...compiled.vector import Vector, along, applied, cross, dot, minus, plus, times
from ..contract import Motion, accelerate, describe, energy, output_error
from .form import Bearing, Cylindrical, SpatialSliderCrank
from .pose import count, crank_bearing, on_crank


@family
def _turned_by(mechanism, p, alpha, rising):
    """Return the accelerations of the rod's coordinates but its centre; alpha : rad/s^2, in its frame; rising : m/s^2.

    The latter counts where it slides along a pin.
    """


@_turned_by.member(SpatialSliderCrank, sites=(Cylindrical, None))
@_turned_by.member(SpatialSliderCrank, sites=(None, Cylindrical))
def _angle(mechanism, p, alpha, rising):
    return rising, alpha.z


@_turned_by.member(SpatialSliderCrank)
def _quaternion(mechanism, p, alpha, rising):
    return accelerated(p.turning, p.spin, alpha, mechanism.links.speed)


@kernel
def _gyration(rod, spin):
    """Return -spin x (inertia spin), N m."""
    return cross(applied(rod.inertia, spin), spin)


@kernel
def _weight_of_crank(links, p):
    """Return the moment (N m) of the crank's weight about its pivot."""
    center = on_crank(p, links.crank_center)
    return links.crank_mass * (center.x * links.gravity.y - center.y * links.gravity.x)


@kernel
def _bearing_torque(mechanism, p, load):
    """Return the drive torque (N m) of a crank whose bearing bears on the rod with a load."""
    at, frame = crank_bearing(mechanism, p), p.frame
    fx, fy = dot(frame.x, load.force), dot(frame.y, load.force)
    return at.x * fy - at.y * fx - dot(frame.z, load.on_bearing) - _weight_of_crank(mechanism.links, p)


@accelerate.member(SpatialSliderCrank, sites=(Bearing, Bearing))
def _floating_rod(mechanism, p, loads):
    links, rod, near, far = mechanism.links, mechanism.rod, loads[0], loads[1]
    back, center = times(-1.0, rod.center), rod.center
    beyond = Vector(rod.length - center.x, -center.y, -center.z)
    moment = plus(plus(near.on_journal, far.on_journal), _gyration(rod, p.spin))
    moment = plus(moment, plus(cross(back, near.force), cross(beyond, far.force)))
    alpha = applied(rod.inverse, moment)
    pushed = in_fixed(p.frame, plus(near.force, far.force))
    lighter = 1.0 / rod.mass
    slider = links.gravity.x - dot(far.force, p.frame.x) / links.slider_mass
    carried = (
        pushed.x * lighter + links.gravity.x,
        pushed.y * lighter + links.gravity.y,
        pushed.z * lighter + links.gravity.z,
    )
    turned = _turned_by(mechanism, p, alpha, 0.0)
    return Motion((slider, *turned, *carried), slider, _bearing_torque(mechanism, p, near))


@accelerate.member(SpatialSliderCrank, sites=(Bearing, None))
def _rod_on_slider(mechanism, p, loads):
    links, rod, near, axis = mechanism.links, mechanism.rod, loads[0], p.frame.x
    both, weight = rod.mass + links.slider_mass, in_body(p.frame, links.gravity)
    back = Vector(-rod.length, 0.0, 0.0)
    moment = plus(near.on_journal, plus(cross(back, near.force), _gyration(rod, p.spin)))
    moment = along(moment, rod.mass, cross(rod.arm, weight))
    coupling = times(rod.mass, cross(rod.arm, axis))
    pulled = cross(p.spin, cross(p.spin, rod.arm))
    push = dot(near.force, axis) + both * links.gravity.x - rod.mass * dot(axis, pulled)
    yielding = applied(rod.inverse, coupling)
    slider = (push - dot(yielding, moment)) / (both - dot(coupling, yielding))
    alpha = along(applied(rod.inverse, moment), -slider, yielding)
    rising = near.force.z / rod.mass + links.gravity.z
    turned = _turned_by(mechanism, p, alpha, rising)
    return Motion((slider, *turned), slider, _bearing_torque(mechanism, p, near))


@accelerate.member(SpatialSliderCrank, sites=(None, Bearing))
def _rod_on_crank(mechanism, p, loads):
    links, rod, far = mechanism.links, mechanism.rod, loads[0]
    pull = links.speed * links.speed * links.crank_length
    lifted = Vector(
        links.gravity.x + pull * p.c1, links.gravity.y + pull * p.s1, 0.0 * p.c1 + links.gravity.z
    )  # weight less what the pin's acceleration takes
    felt = in_body(p.frame, lifted)
    moment = plus(far.on_journal, plus(cross(Vector(rod.length, 0.0, 0.0), far.force), _gyration(rod, p.spin)))
    moment = along(moment, rod.mass, cross(rod.arm, felt))
    alpha = applied(rod.inverse, moment)
    slider = links.gravity.x - dot(far.force, p.frame.x) / links.slider_mass
    rising = far.force.z / rod.mass + links.gravity.z
    swung = plus(cross(alpha, rod.arm), cross(p.spin, cross(p.spin, rod.arm)))
    on_pin = minus(times(rod.mass, minus(swung, felt)), far.force)
    fx, fy = dot(p.frame.x, on_pin), dot(p.frame.y, on_pin)
    torque = links.crank_length * (p.c1 * fy - p.s1 * fx) - _weight_of_crank(links, p)
    turned = _turned_by(mechanism, p, alpha, rising)
    return Motion((slider, *turned), slider, torque)


@energy.member(SpatialSliderCrank)
def _energy(mechanism, p):
    links, rod = mechanism.links, mechanism.rod
    moving = plus(p.pin_velocity, cross(p.spin, rod.center))
    turning = applied(rod.inertia, p.spin)
    swing = cross(p.spin, rod.arm)
    about_center = dot(p.spin, turning) - rod.mass * dot(swing, swing)
    center = on_crank(p, links.crank_center)
    rim = links.speed * links.speed * (center.x * center.x + center.y * center.y)
    kinetic = 0.5 * (
        links.slider_mass * p.v * p.v
        + rod.mass * dot(moving, moving)
        + about_center
        + links.crank_mass * rim
        + links.crank_inertia * links.speed * links.speed
    )
    weight = in_body(p.frame, links.gravity)
    turned = links.speed * (center.x * links.gravity.y - center.y * links.gravity.x)
    outside = rod.mass * dot(weight, moving) + links.slider_mass * links.gravity.x * p.v + links.crank_mass * turned
    return kinetic, outside


@output_error.member(SpatialSliderCrank)
def _slider_error(mechanism, p):
    links, length = mechanism.links, mechanism.rod.length
    reach = math.sqrt(length * length - (links.crank_length * p.s1) ** 2)
    ideal = links.crank_length * p.c1 + reach
    return p.x - ideal, p.v + links.speed * links.crank_length * p.s1 * ideal / reach


# ---------------------------------------------------------------------------------------------- time histories


@family
def _quaternion_of(mechanism, y):
    """Return the quaternion of the rod, w x y z, of length 1."""


@_quaternion_of.member(SpatialSliderCrank, sites=(Cylindrical, None))
@_quaternion_of.member(SpatialSliderCrank, sites=(None, Cylindrical))
def _of_angle(mechanism, y):
    half = 0.5 * y[2]
    return math.cos(half), 0.0, 0.0, math.sin(half)


@_quaternion_of.member(SpatialSliderCrank)
def _of_length_one(mechanism, y):
    long = math.sqrt(y[1] * y[1] + y[2] * y[2] + y[3] * y[3] + y[4] * y[4])
    return y[1] / long, y[2] / long, y[3] / long, y[4] / long


@kernel
def _put_body(out, first, at, moving, quaternion, spin):
    out[first], out[first + 1], out[first + 2] = at.x, at.y, at.z
    out[first + 3], out[first + 4], out[first + 5] = moving.x, moving.y, moving.z
    for k in range(4):
        out[first + 6 + k] = quaternion[k]
    out[first + 10], out[first + 11], out[first + 12] = spin.x, spin.y, spin.z


@describe.member(SpatialSliderCrank)
def _describe(mechanism, y, p, motion, out):
    links, rod, time = mechanism.links, mechanism.rod, y[2 * count(mechanism)]
    angle = links.speed * time
    out[0], out[1], out[2] = time, angle, motion.torque
    out[3], out[4], out[5] = p.x, p.v, motion.output
    center = on_crank(p, links.crank_center)
    rim = Vector(-links.speed * center.y, links.speed * center.x, 0.0)
    turned = (math.cos(0.5 * angle), 0.0, 0.0, math.sin(0.5 * angle))
    _put_body(out, 6, center, rim, turned, Vector(0.0, 0.0, links.speed))
    at = plus(p.pin, in_fixed(p.frame, rod.center))
    moving = in_fixed(p.frame, plus(p.pin_velocity, cross(p.spin, rod.center)))
    _put_body(out, 19, at, moving, _quaternion_of(mechanism, y), in_fixed(p.frame, p.spin))
    for k in range(12):  # the slider moves along x alone; its place stands above
        out[32 + k] = 0.0
    out[34], out[37] = p.v, 1.0
    return 44
