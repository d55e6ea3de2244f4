"""Wear of bearing and journal, spread over angular bins in each body's own frame while the motion goes on."""

import math
from typing import NamedTuple

from numba import types
from numba.extending import overload

from ..compiled.family import OPTIONS, Entry, entry, family, kernel, shaped
from ..mechanism.slider_crank import body_angles, gaps, pose
from ..observe.tally import FORCE, KAPPA_COURSE, PARTS, SLIP
from .dry import FREE

# Columns of the account of a joint's wear
ARCS, NARROW, ACCOUNT = range(3)
WIDE = 5.0  # bins: an arc narrower than this is not resolved, and counted
SIMPSON = (1.0 / 12.0, 4.0 / 12.0, 2.0 / 12.0, 4.0 / 12.0, 1.0 / 12.0)  # at every second of the PARTS + 1 places


class NoWear(NamedTuple):
    """Nothing is worn and nothing computed."""


class Archard(NamedTuple):
    """dh = k p |v| dt with the pressure of a Hertzian line contact."""

    bearing_coefficient: float  # m^2/N
    journal_coefficient: float  # m^2/N
    bins: float  # of each body
    length: float  # m, of the joint along its pin
    modulus: float  # Pa, E* of both bodies
    radius: float  # m, R_b R_j / (R_b - R_j)


@family
def wear_rate(law, joint, force, depths, stride, first, bearing_angle, journal_angle, distance, account):
    """Enter the wear of sliding `distance` (m) under `force` (N), the contact being at these angles of the bodies.

    depths : flat array in which the bins of the bearing begin at `first`, those of the journal at `first` + `stride`.
    """


@wear_rate.member(NoWear)
def _no_wear(law, joint, force, depths, stride, first, bearing_angle, journal_angle, distance, account):
    pass


@wear_rate.member(Archard)
def _archard(law, joint, force, depths, stride, first, bearing_angle, journal_angle, distance, account):
    line_load = force / law.length
    half_width = math.sqrt(4.0 * line_load * law.radius / (math.pi * law.modulus))
    half_arc = min(half_width / joint.bearing_radius, 0.5 * math.pi)
    account[ARCS] += 1.0
    if 2.0 * half_arc < WIDE * 2.0 * math.pi / law.bins:
        account[NARROW] += 1.0
    sliding = line_load * distance
    bins = int(law.bins)
    spread(depths, first, bins, bearing_angle, half_arc, law.bearing_coefficient * sliding / joint.bearing_radius)
    spread(
        depths, first + stride, bins, journal_angle, half_arc, law.journal_coefficient * sliding / joint.journal_radius
    )


@kernel
def share_before(x):
    """Return the share of a Hertzian pressure that lies before `x`, where -1 and 1 are its ends."""
    if x <= -1.0:
        return 0.0
    if x >= 1.0:
        return 1.0
    return 0.5 + (x * math.sqrt(1.0 - x * x) + math.asin(x)) / math.pi


@kernel
def spread(depths, first, bins, angle, half_arc, amount):
    """Add `amount` (m rad), spread like a Hertzian pressure over `angle` +- `half_arc` (rad), to the bins' means."""
    if amount == 0.0:
        return
    width = 2.0 * math.pi / bins
    begin = math.floor((angle - half_arc) / width)
    last = math.floor((angle + half_arc) / width)
    before = 0.0
    for place in range(int(begin), int(last) + 1):
        up_to = share_before(((place + 1) * width - angle) / half_arc) if place < last else 1.0
        depths[first + place % bins] += amount * (up_to - before) / width
        before = up_to


@kernel
def course_of(a, b, slope_a, slope_b, x):
    """Return the angle at the share `x` of a step between angles `a` and `b` with these slopes: a cubic, unwrapped."""
    turns = 2.0 * math.pi
    b += turns * math.floor((a + 0.5 * (slope_a + slope_b) - b) / turns + 0.5)
    rest = 1.0 - x
    return rest * rest * ((1.0 + 2.0 * x) * a + x * slope_a) + x * x * ((3.0 - 2.0 * x) * b - rest * slope_b)


@kernel
def wear_joint(joint, j, before, after, angles_before, angles_after, course, h, depths, stride, account):
    """Enter the wear of joint `j` over a step of length `h`: Gaps and angles at its ends, force and slip between."""
    side = joint.side
    a = math.atan2(side * before.y, side * before.x)
    b = math.atan2(side * after.y, side * after.x)
    turn_a = (before.x * before.vy - before.y * before.vx) / (before.x * before.x + before.y * before.y)
    turn_b = (after.x * after.vy - after.y * after.vx) / (after.x * after.x + after.y * after.y)
    pace_a, pace_b = h * course[j, KAPPA_COURSE, 0], h * course[j, KAPPA_COURSE, PARTS]
    bearing, journal = (0, 1) if side > 0.0 else (1, 0)
    spin_a = (before.spin_proximal, before.spin_distal)
    spin_b = (after.spin_proximal, after.spin_distal)
    for i in range(5):
        place = i * PARTS // 4
        x = 0.25 * i
        force = max(course[j, FORCE, place], 0.0)
        distance = SIMPSON[i] * h * course[j, KAPPA_COURSE, place] * abs(course[j, SLIP, place])
        if force * distance == 0.0:
            continue
        on_bearing = course_of(
            a - angles_before[bearing],
            b - angles_after[bearing],
            pace_a * (turn_a - spin_a[bearing]),
            pace_b * (turn_b - spin_b[bearing]),
            x,
        )
        on_journal = course_of(
            a - angles_before[journal],
            b - angles_after[journal],
            pace_a * (turn_a - spin_a[journal]),
            pace_b * (turn_b - spin_b[journal]),
            x,
        )
        wear_rate(
            joint.wear, joint, force, depths, stride, 2 * j * stride, on_bearing, on_journal, distance, account[j]
        )


def wear_all(joints, j, state, before, after, angles_before, angles_after, course, h, depths, stride, account):
    """Enter the wear of every joint of the tuple `joints` that is in contact."""
    if joints:
        rest = (state, before, after, angles_before, angles_after, course, h, depths, stride, account)
        if state[j] != FREE:
            ends = (before[j], after[j], angles_before[j], angles_after[j])
            wear_joint(joints[0], j, *ends, course, h, depths, stride, account)
        wear_all(joints[1:], j + 1, *rest)


@overload(wear_all, strict=False, jit_options=dict(OPTIONS))
def _wear_all(joints, j, state, before, after, angles_before, angles_after, course, h, depths, stride, account):
    def nothing(joints, j, state, before, after, angles_before, angles_after, course, h, depths, stride, account):
        pass

    def some(joints, j, state, before, after, angles_before, angles_after, course, h, depths, stride, account):
        rest = (state, before, after, angles_before, angles_after, course, h, depths, stride, account)
        if state[j] != FREE:
            ends = (before[j], after[j], angles_before[j], angles_after[j])
            wear_joint(joints[0], j, *ends, course, h, depths, stride, account)
        wear_all(joints[1:], j + 1, *rest)

    return some if len(joints) else nothing


def wear_entry(scene, y, end, state, course, length, depths, account, stride):
    """Enter the wear of a step; `length` holds its length, bare pointers as in `motion.rates_entry`."""
    here = scene[0]
    joints = len(here.joints)
    n = 2 * len(here.coordinates) + 1 + joints
    start, finish = shaped(y, (n,)), shaped(end, (n,))
    before, after = pose(here.mechanism, start), pose(here.mechanism, finish)
    wear_all(
        here.joints,
        0,
        shaped(state, (joints,)),
        gaps(here.mechanism, before),
        gaps(here.mechanism, after),
        body_angles(here.mechanism, start),
        body_angles(here.mechanism, finish),
        shaped(course, (joints, 3, PARTS + 1)),
        shaped(length, (1,))[0],
        shaped(depths, (2 * joints * stride,)),
        stride,
        shaped(account, (joints, ACCOUNT)),
    )


def wear_of(scene, parameters) -> Entry:
    """Return the Entry that computes the wear of `scene`."""
    number = types.float64
    return entry(wear_entry, scene, (number, number, types.int64, number, number, number, number), parameters)
