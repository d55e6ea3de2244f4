"""The rivals' own equations of motion, in plain time: nothing of clearsweep's kernels, so that each checks the other.

A rod of three degrees of freedom hangs between crank and slider.  Its end at the crank pin is hinged (two coordinates:
rod angle, slider x) or open (four: rod angle, slider x, rod centre x, y); its other end at the slider is open.  Contact
acts along the line of the two pins, `n` from the one nearer the drive to the other, at a place `reach` from each.

States are in units of the record's `place`, `angle`, `speed` and `spin`, because numbalsoda takes one absolute
tolerance for all components: in these it means clearances.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit

FREE, PRESSED = 0, 1
FLOOR = 1e-3  # m/s, least onset rate, as clearsweep has it

RECORD = np.dtype(
    [
        ("crank", "f8"),  # m, length
        ("rate", "f8"),  # rad/s, of the crank
        ("rod", "f8"),  # m, length
        ("center", "f8"),  # m, crank pin to the rod's centre of mass
        ("rod_mass", "f8"),  # kg
        ("rod_inertia", "f8"),  # kg m^2, about the centre of mass
        ("slider_mass", "f8"),  # kg
        ("gravity", "f8"),  # m/s^2
        ("clearance", "f8"),  # m, of every joint
        ("stiffness", "f8"),  # N/m^1.5
        ("loss", "f8"),  # 1, chi of F = K depth^1.5 (1 + chi rate / onset rate)
        ("friction", "f8"),  # 1
        ("v0", "f8"),  # m/s, below it no friction
        ("v1", "f8"),  # m/s, above it full friction
        ("reach_near", "f8"),  # m, from the pin nearer the drive to the place of contact, along n
        ("reach_far", "f8"),  # m, from the other pin
        ("place", "f8"),  # m, unit of the coordinates
        ("angle", "f8"),  # rad
        ("speed", "f8"),  # m/s, unit of their rates
        ("spin", "f8"),  # rad/s
        ("state", "f8", (2,)),  # FREE or PRESSED, of each joint
        ("onset", "f8", (2,)),  # m/s, closing rate with which the contact began
        ("depth", "f8", (2,)),  # m, as last evaluated; negative in free flight
        ("closing_rate", "f8", (2,)),  # m/s, its rate
        ("force", "f8", (2,)),  # N, the normal force
        ("joints", "i8"),  # open ones
        ("latest", "f8"),  # the joint of the latest event, -1: none yet
        ("blind", "f8"),  # s, until then that joint is not looked at: its depth is zero but for rounding
        ("evaluations", "f8"),
    ]
)


def parameters(scene) -> np.ndarray:
    """Return the (1,) RECORD of a clearsweep Scene whose joints are alike, under Lankarani and Nikravesh's law."""
    values, joints = scene.case.mechanism.values, scene.case.joints
    joint, rate = joints[0], scene.case.drive.speed
    clearance, bearing, contact = joint.clearance, joint.bearing_radius, joint.contact.values
    friction = joint.friction.values if joint.friction else {}
    p = np.zeros(1, RECORD)
    p["crank"], p["rate"], p["rod"] = values["crank.length"], rate, values["rod.length"]
    p["center"] = values["rod.center"]
    p["rod_mass"], p["rod_inertia"] = values["rod.mass"], values["rod.inertia"]
    p["slider_mass"] = values["slider.mass"]
    p["gravity"], p["clearance"] = values["gravity"], clearance
    p["stiffness"], p["loss"] = contact["stiffness"], 0.75 * (1.0 - contact["restitution"] ** 2)
    p["friction"], p["v0"], p["v1"] = friction.get("coefficient", 0.0), friction.get("v0", 0.0), friction.get("v1", 1.0)
    # the journal sits on the nearer body: it touches the bearing's wall on the side from which the farther pin comes
    p["reach_near"], p["reach_far"] = clearance - bearing, -bearing
    p["place"], p["speed"] = clearance, clearance * rate
    p["angle"], p["spin"] = clearance / values["rod.length"], clearance * rate / values["rod.length"]
    p["onset"], p["latest"], p["joints"] = 1.0, -1.0, len(joints)
    return p


@njit(error_model="numpy")
def contact(p, j, x, y, vx, vy, spin_near, spin_far):
    """Return the force (N) on the farther body of joint `j` and the moments (N m) on the nearer and the farther one.

    (x, y) : the farther pin relative to the nearer one, m; (vx, vy) : its velocity, m/s.
    """
    eccentricity = math.sqrt(x * x + y * y)
    nx, ny = x / eccentricity, y / eccentricity
    depth, last_lines = eccentricity - p.clearance, vx * nx + vy * ny
    p.depth[j], p.closing_rate[j] = depth, last_lines
    if p.state[j] == FREE or depth <= 0.0:
        p.force[j] = 0.0
        return 0.0, 0.0, 0.0, 0.0
    normal = max(p.stiffness * depth * math.sqrt(depth) * (1.0 + p.loss * last_lines / p.onset[j]), 0.0)
    p.force[j] = normal
    rub = 0.0
    if p.friction > 0.0:
        slip = vy * nx - vx * ny + spin_far * p.reach_far - spin_near * p.reach_near
        share = min(max((abs(slip) - p.v0) / (p.v1 - p.v0), 0.0), 1.0)
        rub = -p.friction * normal * math.copysign(share, slip)
    fx, fy = -normal * nx - rub * ny, -normal * ny + rub * nx
    return fx, fy, -p.reach_near * rub, p.reach_far * rub


@njit(error_model="numpy")
def hinged(t, u, du, p):
    """Put the rates of the state `u` at the time `t` (s) into `du`: the rod hinged to the crank, open at the slider."""
    p.evaluations += 1
    angle, x, spin, v = u[0] * p.angle, u[1] * p.place, u[2] * p.spin, u[3] * p.speed
    c, s, c1, s1 = math.cos(angle), math.sin(angle), math.cos(p.rate * t), math.sin(p.rate * t)
    tip = p.crank * p.rate
    fx, fy, moment, _ = contact(
        p,
        0,
        x - p.crank * c1 - p.rod * c,
        -p.crank * s1 - p.rod * s,
        v + tip * s1 + p.rod * spin * s,
        -tip * c1 - p.rod * spin * c,
        spin,
        0.0,
    )
    ax, ay = -tip * p.rate * c1, p.gravity - tip * p.rate * s1  # of the crank pin, against free fall
    angle_rate = moment - p.rod * (c * fy - s * fx) - p.rod_mass * p.center * (c * ay - s * ax)
    du[0], du[1] = u[2] * p.rate, u[3] * p.rate
    du[2] = angle_rate / ((p.rod_inertia + p.rod_mass * p.center * p.center) * p.spin)
    du[3] = fx / (p.slider_mass * p.speed)


@njit(error_model="numpy")
def hinged_depths(t, u, p):
    """Put the depth alone at the state `u` into the record."""
    angle, turn = u[0] * p.angle, p.rate * t
    x = u[1] * p.place - p.crank * math.cos(turn) - p.rod * math.cos(angle)
    y = p.crank * math.sin(turn) + p.rod * math.sin(angle)
    p.depth[0] = math.sqrt(x * x + y * y) - p.clearance


@njit(error_model="numpy")
def floating(t, u, du, p):
    """Put the rates of the state `u` at the time `t` (s) into `du`: the rod open at both ends."""
    p.evaluations += 1
    angle, x, gx, gy = u[0] * p.angle, u[1] * p.place, u[2] * p.place, u[3] * p.place
    spin, v, gvx, gvy = u[4] * p.spin, u[5] * p.speed, u[6] * p.speed, u[7] * p.speed
    c, s, c1, s1 = math.cos(angle), math.sin(angle), math.cos(p.rate * t), math.sin(p.rate * t)
    tip, near, far = p.crank * p.rate, p.center, p.rod - p.center
    bx, by, _, b_moment = contact(
        p,
        0,
        gx - near * c - p.crank * c1,
        gy - near * s - p.crank * s1,
        gvx + near * spin * s + tip * s1,
        gvy - near * spin * c - tip * c1,
        p.rate,
        spin,
    )
    fx, fy, c_moment, _ = contact(
        p, 1, x - gx - far * c, -gy - far * s, v - gvx + far * spin * s, -gvy - far * spin * c, spin, 0.0
    )
    angle_rate = b_moment + c_moment - near * (c * by - s * bx) - far * (c * fy - s * fx)
    for i in range(4):
        du[i] = u[4 + i] * p.rate
    du[4] = angle_rate / (p.rod_inertia * p.spin)
    du[5] = fx / (p.slider_mass * p.speed)
    du[6] = (bx - fx) / (p.rod_mass * p.speed)
    du[7] = ((by - fy) / p.rod_mass - p.gravity) / p.speed


@njit(error_model="numpy")
def floating_depths(t, u, p):
    """Put the depths alone at the state `u` into the record."""
    angle, turn, far = u[0] * p.angle, p.rate * t, p.rod - p.center
    c, s, gx, gy = math.cos(angle), math.sin(angle), u[2] * p.place, u[3] * p.place
    x, y = gx - p.center * c - p.crank * math.cos(turn), gy - p.center * s - p.crank * math.sin(turn)
    p.depth[0] = math.sqrt(x * x + y * y) - p.clearance
    x, y = u[1] * p.place - gx - far * c, gy + far * s
    p.depth[1] = math.sqrt(x * x + y * y) - p.clearance


class Model(NamedTuple):
    """The compiled equations of one choice of open joints."""

    rates: object
    depths: object
    joints: int
    size: int  # of the state


MODELS = {
    ("rod-slider",): Model(hinged, hinged_depths, 1, 4),
    ("crank-rod", "rod-slider"): Model(floating, floating_depths, 2, 8),
}


def units(p, model) -> np.ndarray:
    """Return the units of the components of the state."""
    p, others = p[0], model.size // 2 - 1
    return np.array([p["angle"], *[p["place"]] * others, p["spin"], *[p["speed"]] * others])


@njit(error_model="numpy")
def margin(p, j, t):
    """Return how far (m) joint `j` is from its next event, positive before it; infinite where it has just had one."""
    if p.latest == j and t < p.blind:
        return math.inf
    return -p.depth[j] if p.state[j] == FREE else p.depth[j]
