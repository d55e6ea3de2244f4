"""The equations of motion of slider-cranks with clearance in any of their joints, and of a pair; their energy.

Newton-Euler about the pin or centre of mass named in each function; `u1`, `u2` are the unit vectors along crank and
rod, `n` those turned by +90 degrees.  The drive torque is what keeps the crank's speed constant.
"""

import math
from typing import NamedTuple

from ..compiled.family import family, kernel
from .slider_crank import OpenA, OpenAB, OpenABC, OpenAC, OpenB, OpenBC, OpenC, Pair


class Motion(NamedTuple):
    """Accelerations in the order of the coordinates (unused ones 0), and the drive torque (N m)."""

    q0: float
    q1: float
    q2: float
    q3: float
    q4: float
    q5: float
    torque: float


@family
def motion(mechanism, p, loads):
    """Return the Motion at the Pose `p` under the joint loads `loads`, one Load per open joint."""


@family
def energy_and_gravity_power(mechanism, p):
    """Return the kinetic energy (J) and the power of gravity (W) at the Pose `p`."""


@family
def misplacement(mechanism, p):
    """Return how far (m) the slider is from its place in the ideal mechanism, and the rate (m/s) of that."""


@family
def describe(mechanism, p, acceleration, angle, moment, out):
    """Put the time histories of the bodies into `out`, in the order of their channels; return how many there are."""


# ---------------------------------------------------------------------------------------------- accelerations


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


@kernel
def _floating_rod(links, p, bx, by, b_moment, cx, cy, c_moment):
    """Return the accelerations (angle, x, y of the centre) of a rod loaded by forces and moments at both ends."""
    near, far = links.rod_center, links.rod_length - links.rod_center
    turning = b_moment + c_moment - near * (p.c2 * by - p.s2 * bx) + far * (p.c2 * cy - p.s2 * cx)
    return (turning / links.rod_inertia, (bx + cx) / links.rod_mass, (by + cy) / links.rod_mass - links.gravity)


@motion.member(OpenC)
def _motion_c(mechanism, p, loads):
    links, c = mechanism.links, loads[0]
    arm, pull = links.rod_center, links.speed * links.speed * links.crank_length
    turning = (
        c.moment_proximal
        - links.rod_length * (p.c2 * c.fy - p.s2 * c.fx)
        + links.rod_mass * arm * (pull * (p.c2 * p.s1 - p.s2 * p.c1) - links.gravity * p.c2)
    )
    alpha = turning * (1.0 / (links.rod_inertia + links.rod_mass * arm * arm))
    fx, fy = _crank_pin_force(links, p, -pull * p.c1, -pull * p.s1, alpha, -c.fx, -c.fy)
    torque = _fixed_crank_torque(links, p, fx, fy, 0.0)
    return Motion(alpha, c.fx * (1.0 / links.slider_mass), 0.0, 0.0, 0.0, 0.0, torque)


@motion.member(OpenB)
def _motion_b(mechanism, p, loads):
    links, b = mechanism.links, loads[0]
    alpha, a = _rod_on_slider(links, p, 0.0, b.fx, b.fy, b.moment_distal)
    torque = _fixed_crank_torque(links, p, b.fx, b.fy, b.moment_proximal)
    return Motion(alpha, a, 0.0, 0.0, 0.0, 0.0, torque)


@motion.member(OpenA)
def _motion_a(mechanism, p, loads):
    links, f = mechanism.links, loads[0]
    arm, speed2, mass = links.crank_length - links.crank_center, links.speed * links.speed, links.crank_mass
    fx = f.fx - mass * arm * speed2 * p.c1
    fy = f.fy - mass * (arm * speed2 * p.s1 + links.gravity)
    alpha, a = _rod_on_slider(links, p, mass, fx, fy, 0.0)
    length, rate2 = links.rod_length, p.rod_rate * p.rod_rate
    bx = fx - mass * (a + length * (alpha * p.s2 + rate2 * p.c2))
    by = fy - mass * length * (rate2 * p.s2 - alpha * p.c2)
    torque = _floating_crank_torque(links, p, f.fx, f.fy, bx, by, f.moment_distal)
    return Motion(alpha, a, 0.0, 0.0, 0.0, 0.0, torque)


@motion.member(OpenAB)
def _motion_ab(mechanism, p, loads):
    links, f, b = mechanism.links, loads[0], loads[1]
    alpha, a = _rod_on_slider(links, p, 0.0, b.fx, b.fy, b.moment_distal)
    px, py = _floating_crank_acceleration(links, p, f.fx - b.fx, f.fy - b.fy)
    torque = _floating_crank_torque(links, p, f.fx, f.fy, b.fx, b.fy, f.moment_distal + b.moment_proximal)
    return Motion(alpha, a, px, py, 0.0, 0.0, torque)


@motion.member(OpenAC)
def _motion_ac(mechanism, p, loads):
    links, f, c = mechanism.links, loads[0], loads[1]
    arm, offset, speed2 = links.rod_center, links.crank_length - links.crank_center, links.speed * links.speed
    both, swing, rate2 = links.crank_mass + links.rod_mass, links.rod_mass * links.rod_center, p.rod_rate * p.rod_rate
    rx = f.fx - c.fx - links.crank_mass * offset * speed2 * p.c1 + swing * rate2 * p.c2
    ry = f.fy - c.fy - links.crank_mass * offset * speed2 * p.s1 + swing * rate2 * p.s2 - both * links.gravity
    turning = (
        c.moment_proximal
        - links.rod_length * (p.c2 * c.fy - p.s2 * c.fx)
        - swing * (links.gravity * p.c2 + (p.c2 * ry - p.s2 * rx) / both)
    )
    alpha = turning / (links.rod_inertia + swing * arm - swing * swing / both)
    bx, by = (rx + swing * alpha * p.s2) / both, (ry - swing * alpha * p.c2) / both
    fx, fy = _crank_pin_force(links, p, bx, by, alpha, -c.fx, -c.fy)
    torque = _floating_crank_torque(links, p, f.fx, f.fy, fx, fy, f.moment_distal)
    pull = speed2 * links.crank_length
    return Motion(alpha, c.fx * (1.0 / links.slider_mass), bx + pull * p.c1, by + pull * p.s1, 0.0, 0.0, torque)


@motion.member(OpenBC)
def _motion_bc(mechanism, p, loads):
    links, b, c = mechanism.links, loads[0], loads[1]
    alpha, gx, gy = _floating_rod(links, p, b.fx, b.fy, b.moment_distal, -c.fx, -c.fy, c.moment_proximal)
    torque = _fixed_crank_torque(links, p, b.fx, b.fy, b.moment_proximal)
    return Motion(alpha, c.fx * (1.0 / links.slider_mass), gx, gy, 0.0, 0.0, torque)


@motion.member(OpenABC)
def _motion_abc(mechanism, p, loads):
    links, f, b, c = mechanism.links, loads[0], loads[1], loads[2]
    alpha, gx, gy = _floating_rod(links, p, b.fx, b.fy, b.moment_distal, -c.fx, -c.fy, c.moment_proximal)
    px, py = _floating_crank_acceleration(links, p, f.fx - b.fx, f.fy - b.fy)
    torque = _floating_crank_torque(links, p, f.fx, f.fy, b.fx, b.fy, f.moment_distal + b.moment_proximal)
    return Motion(alpha, c.fx * (1.0 / links.slider_mass), gx, gy, px, py, torque)


@motion.member(Pair)
def _motion_pair(mechanism, p, loads):
    return Motion(loads[0].fx * (1.0 / mechanism.mass), 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


# ---------------------------------------------------------------------------------------------- energy


@kernel
def _slider_crank_energy(mechanism, p):
    links = mechanism.links
    arm, rim = links.rod_center, links.crank_center * links.speed
    rvx, rvy = p.bvx - arm * p.rod_rate * p.s2, p.bvy + arm * p.rod_rate * p.c2
    cvx, cvy = p.avx - rim * p.s1, p.avy + rim * p.c1
    kinetic = 0.5 * (
        links.slider_mass * p.v * p.v
        + links.rod_mass * (rvx * rvx + rvy * rvy)
        + links.rod_inertia * p.rod_rate * p.rod_rate
        + links.crank_mass * (cvx * cvx + cvy * cvy)
        + links.crank_inertia * links.speed * links.speed
    )
    return kinetic, -links.gravity * (links.rod_mass * rvy + links.crank_mass * cvy)


for _mechanism in (OpenA, OpenB, OpenC, OpenAB, OpenAC, OpenBC, OpenABC):
    energy_and_gravity_power.member(_mechanism)(_slider_crank_energy)


def _describe_slider_crank(mechanism, p, acceleration, angle, moment, out):
    links, arm = mechanism.links, mechanism.links.rod_center
    out[0], out[1], out[2] = moment, links.speed * moment, acceleration.torque
    out[3], out[4], out[5] = p.x, p.v, acceleration.q1
    out[6], out[7] = angle, p.rod_rate
    out[8], out[9] = p.bx + arm * p.c2, p.by + arm * p.s2
    out[10], out[11] = p.bvx - arm * p.rod_rate * p.s2, p.bvy + arm * p.rod_rate * p.c2
    return 12


@describe.member(Pair)
def _describe_pair(mechanism, p, acceleration, angle, moment, out):
    out[0], out[1], out[2] = moment, p.x, p.v
    return 3


@kernel
def _slider_crank_misplacement(mechanism, p):
    links = mechanism.links
    reach = math.sqrt(links.rod_length * links.rod_length - (links.crank_length * p.s1) ** 2)
    ideal = links.crank_length * p.c1 + reach
    return p.x - ideal, p.v + links.speed * links.crank_length * p.s1 * ideal / reach


for _mechanism in (OpenA, OpenB, OpenC, OpenAB, OpenAC, OpenBC, OpenABC):
    misplacement.member(_mechanism)(_slider_crank_misplacement)
    describe.member(_mechanism)(_describe_slider_crank)


@misplacement.member(Pair)
def _pair_misplacement(mechanism, p):
    return 0.0, 0.0


@energy_and_gravity_power.member(Pair)
def _pair_energy(mechanism, p):
    return 0.5 * mechanism.mass * p.v * p.v, 0.0
