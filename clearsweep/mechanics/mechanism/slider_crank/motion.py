"""The equations of motion of slider-cranks with clearance in any of their joints, and their energy.

Newton-Euler about the pin or centre of mass named in each function, for the unknowns that the opening leaves; `c1`,
`s1` and `c2`, `s2` are the unit vectors along crank and rod.  The drive torque keeps the crank's speed constant.
Where the crank pin (B) is open, rod and crank know of each other by its load alone, and each has its own equations.
"""

import math

from ...compiled.family import family, kernel
from ..contract import Ideal, Motion, Open, accelerate, describe, energy, output_error
from .pose import ROD, SliderCrank, places


@accelerate.member(SliderCrank, sites=(Ideal, Open, None))
def _fixed_crank(mechanism, p, loads):
    links, b = mechanism.links, loads[0]
    rod = _rod(mechanism, p, loads)
    return Motion(rod, rod[1], _fixed_crank_torque(links, p, b.fx, b.fy, b.moment_proximal))


@accelerate.member(SliderCrank, sites=(Open, Open, None))
def _floating_crank(mechanism, p, loads):
    links, a, b = mechanism.links, loads[0], loads[1]
    rod = _rod(mechanism, p, loads[1:])
    pivot = _floating_crank_acceleration(links, p, a.fx - b.fx, a.fy - b.fy)
    torque = _floating_crank_torque(links, p, a.fx, a.fy, b.fx, b.fy, a.moment_distal + b.moment_proximal)
    return Motion(rod + pivot, rod[1], torque)


@accelerate.member(SliderCrank, sites=(Ideal, Ideal, Open))
def _fixed_crank_with_rod(mechanism, p, loads):
    links, c = mechanism.links, loads[0]
    arm, pull = links.rod_center, links.speed * links.speed * links.crank_length
    turning = (
        c.moment_proximal
        - links.rod_length * (p.c2 * c.fy - p.s2 * c.fx)
        + links.rod_mass * arm * (pull * (p.c2 * p.s1 - p.s2 * p.c1) - links.gravity * p.c2)
    )
    alpha = turning * (1.0 / (links.rod_inertia + links.rod_mass * arm * arm))
    fx, fy = _crank_pin_force(links, p, -pull * p.c1, -pull * p.s1, alpha, -c.fx, -c.fy)
    slider = c.fx * (1.0 / links.slider_mass)
    return Motion((alpha, slider), slider, _fixed_crank_torque(links, p, fx, fy, 0.0))


@accelerate.member(SliderCrank, sites=(Open, Ideal, Ideal))
def _crank_hanging_on_rod(mechanism, p, loads):
    links, a = mechanism.links, loads[0]
    arm, speed2, mass = links.crank_length - links.crank_center, links.speed * links.speed, links.crank_mass
    fx = a.fx - mass * arm * speed2 * p.c1
    fy = a.fy - mass * (arm * speed2 * p.s1 + links.gravity)
    alpha, slider = _rod_on_slider(links, p, mass, fx, fy, 0.0)
    length, rate2 = links.rod_length, p.rod_rate * p.rod_rate
    bx = fx - mass * (slider + length * (alpha * p.s2 + rate2 * p.c2))
    by = fy - mass * length * (rate2 * p.s2 - alpha * p.c2)
    torque = _floating_crank_torque(links, p, a.fx, a.fy, bx, by, a.moment_distal)
    return Motion((alpha, slider), slider, torque)


@accelerate.member(SliderCrank, sites=(Open, Ideal, Open))
def _floating_crank_with_rod(mechanism, p, loads):
    links, a, c = mechanism.links, loads[0], loads[1]
    arm, offset, speed2 = links.rod_center, links.crank_length - links.crank_center, links.speed * links.speed
    both, swing, rate2 = links.crank_mass + links.rod_mass, links.rod_mass * links.rod_center, p.rod_rate * p.rod_rate
    rx = a.fx - c.fx - links.crank_mass * offset * speed2 * p.c1 + swing * rate2 * p.c2
    ry = a.fy - c.fy - links.crank_mass * offset * speed2 * p.s1 + swing * rate2 * p.s2 - both * links.gravity
    lightness = 1.0 / both
    turning = (
        c.moment_proximal
        - links.rod_length * (p.c2 * c.fy - p.s2 * c.fx)
        - swing * (links.gravity * p.c2 + (p.c2 * ry - p.s2 * rx) * lightness)
    )
    alpha = turning * (1.0 / (links.rod_inertia + swing * arm - swing * swing * lightness))
    bx, by = (rx + swing * alpha * p.s2) * lightness, (ry - swing * alpha * p.c2) * lightness
    fx, fy = _crank_pin_force(links, p, bx, by, alpha, -c.fx, -c.fy)
    torque = _floating_crank_torque(links, p, a.fx, a.fy, fx, fy, a.moment_distal)
    pull = speed2 * links.crank_length
    slider = c.fx * (1.0 / links.slider_mass)
    return Motion((alpha, slider, bx + pull * p.c1, by + pull * p.s1), slider, torque)


# ---------------------------------------------------------------------------------------------- rod, open at B


@family
def _rod(mechanism, p, loads):
    """Return the accelerations of the rod's angle, the slider and, where it floats, its centre x, y; loads at B, C."""


@_rod.member(SliderCrank, sites=(None, Open, Ideal))
def _rod_hinged_to_slider(mechanism, p, loads):
    links, b = mechanism.links, loads[0]
    return _rod_on_slider(links, p, 0.0, b.fx, b.fy, b.moment_distal)


@_rod.member(SliderCrank, sites=(None, Open, Open))
def _floating_rod(mechanism, p, loads):
    links, b, c = mechanism.links, loads[0], loads[1]
    near, far = links.rod_center, links.rod_length - links.rod_center
    cx, cy = -c.fx, -c.fy
    turning = b.moment_distal + c.moment_proximal - near * (p.c2 * b.fy - p.s2 * b.fx) + far * (p.c2 * cy - p.s2 * cx)
    lightness = 1.0 / links.rod_mass
    return (
        turning * (1.0 / links.rod_inertia),
        c.fx * (1.0 / links.slider_mass),
        (b.fx + cx) * lightness,
        (b.fy + cy) * lightness - links.gravity,
    )


@kernel
def _rod_on_slider(links, p, hung, fx, fy, moment):
    """Return angular acceleration and slider acceleration of a rod hinged to the slider.

    (fx, fy) acts at the crank pin, where a mass `hung` (kg) moves along; moments about the slider pin.
    """
    arm = links.rod_length - links.rod_center
    swing = links.rod_mass * arm + hung * links.rod_length
    m11 = links.rod_inertia + links.rod_mass * arm * arm + hung * links.rod_length * links.rod_length
    m12 = swing * p.s2
    m22 = links.rod_mass + links.slider_mass + hung
    r1 = moment - links.rod_length * (p.c2 * fy - p.s2 * fx) + links.rod_mass * arm * links.gravity * p.c2
    r2 = fx - swing * p.rod_rate * p.rod_rate * p.c2
    inverse = 1.0 / (m11 * m22 - m12 * m12)
    return (m22 * r1 - m12 * r2) * inverse, (m11 * r2 - m12 * r1) * inverse


@kernel
def _crank_pin_force(links, p, bx, by, alpha, cx, cy):
    """Return the force on the rod at a closed crank pin that accelerates by (bx, by); (cx, cy) at the other end."""
    arm, rate2 = links.rod_center, p.rod_rate * p.rod_rate
    gx = bx - arm * (alpha * p.s2 + rate2 * p.c2)
    gy = by + arm * (alpha * p.c2 - rate2 * p.s2)
    return links.rod_mass * gx - cx, links.rod_mass * (gy + links.gravity) - cy


# ---------------------------------------------------------------------------------------------- crank


@kernel
def _fixed_crank_torque(links, p, fx, fy, moment):
    """Return the drive torque (N m): moments about the pivot of a crank that loads the rod by (fx, fy) at its pin."""
    return (
        links.crank_length * (p.c1 * fy - p.s1 * fx)
        + links.crank_center * links.crank_mass * links.gravity * p.c1
        - moment
    )


@kernel
def _floating_crank_torque(links, p, ax, ay, fx, fy, moment):
    """Return the drive torque (N m): moments about the centre of mass; (ax, ay) at the pivot, (fx, fy) on the rod."""
    arm = links.crank_length - links.crank_center
    return links.crank_center * (p.c1 * ay - p.s1 * ax) + arm * (p.c1 * fy - p.s1 * fx) - moment


@kernel
def _floating_crank_acceleration(links, p, fx, fy):
    """Return the pivot's acceleration (m/s^2) of a floating crank under the force (fx, fy)."""
    swing = links.crank_center * links.speed * links.speed
    return (fx * (1.0 / links.crank_mass) + swing * p.c1, fy * (1.0 / links.crank_mass) - links.gravity + swing * p.s1)


# ---------------------------------------------------------------------------------------------- energy and output


@energy.member(SliderCrank)
def _energy(mechanism, p):
    links, pivot, pin = mechanism.links, p.pivot, p.pin
    arm, rim = links.rod_center, links.crank_center * links.speed
    rvx, rvy = pin.vx - arm * p.rod_rate * p.s2, pin.vy + arm * p.rod_rate * p.c2
    cvx, cvy = pivot.vx - rim * p.s1, pivot.vy + rim * p.c1
    kinetic = 0.5 * (
        links.slider_mass * p.v * p.v
        + links.rod_mass * (rvx * rvx + rvy * rvy)
        + links.rod_inertia * p.rod_rate * p.rod_rate
        + links.crank_mass * (cvx * cvx + cvy * cvy)
        + links.crank_inertia * links.speed * links.speed
    )
    return kinetic, -links.gravity * (links.rod_mass * rvy + links.crank_mass * cvy)


@output_error.member(SliderCrank)
def _slider_error(mechanism, p):
    links = mechanism.links
    reach = math.sqrt(links.rod_length * links.rod_length - (links.crank_length * p.s1) ** 2)
    ideal = links.crank_length * p.c1 + reach
    return p.x - ideal, p.v + links.speed * links.crank_length * p.s1 * ideal / reach


@describe.member(SliderCrank)
def _describe(mechanism, y, p, motion, out):
    links, arm, time = mechanism.links, mechanism.links.rod_center, y[2 * places(mechanism).count]
    out[0], out[1], out[2] = time, links.speed * time, motion.torque
    out[3], out[4], out[5] = p.x, p.v, motion.output
    out[6], out[7] = y[ROD], p.rod_rate
    out[8], out[9] = p.pin.x + arm * p.c2, p.pin.y + arm * p.s2
    out[10], out[11] = p.pin.vx - arm * p.rod_rate * p.s2, p.pin.vy + arm * p.rod_rate * p.c2
    center, rim = links.crank_center, links.crank_center * links.speed
    out[12], out[13] = p.pivot.x + center * p.c1, p.pivot.y + center * p.s1
    out[14], out[15] = p.pivot.vx - rim * p.s1, p.pivot.vy + rim * p.c1
    out[16], out[17] = links.speed * time, links.speed
    out[18], out[19], out[20], out[21], out[22] = 0.0, p.v, 0.0, 0.0, 0.0  # of the slider, which moves along x alone
    return 23
