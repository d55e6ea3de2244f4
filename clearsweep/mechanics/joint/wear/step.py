"""Wear over a step of the motion, spread over angular bins in each body's own frame."""

import math
from typing import NamedTuple

import numpy as np
from numba import types

from ...compiled.family import Entry, entry, kernel, map_joints, shaped
from ...mechanism.contract import body_angles, gaps, place
from ...observe.histogram import COURSES, DEPTH_COURSE, FORCE, KAPPA_COURSE, PARTS, SLIP_COURSE
from ..contract import after_joint, first_place, touches
from .contract import ACCOUNT, Bins, Rubbing, wear_rate

SIMPSON = (1.0 / 12.0, 4.0 / 12.0, 2.0 / 12.0, 4.0 / 12.0, 1.0 / 12.0)  # at every second of the PARTS + 1 places


class Step(NamedTuple):
    """A step of the motion: its ends, and the courses of every joint in between."""

    before: tuple  # a Gap per joint
    after: tuple
    angles_before: tuple  # rad, of the proximal and the distal body of every joint
    angles_after: tuple
    course: np.ndarray  # (joints, COURSES, PARTS + 1) see observe.histogram
    length: float  # of the step
    mode: np.ndarray  # (joints,) int64, what each joint is doing


class Worn(NamedTuple):
    """Where the wear of all joints is entered."""

    depths: np.ndarray  # (2 joints stride,) m, the bins of bearing and journal of every joint
    stride: int
    account: np.ndarray  # (joints, ACCOUNT)


@kernel
def course_of(a, b, slope_a, slope_b, x):
    """Return the angle at the share `x` of a step between angles `a` and `b` with these slopes: a cubic, unwrapped."""
    turns = 2.0 * math.pi
    b += turns * math.floor((a + 0.5 * (slope_a + slope_b) - b) / turns + 0.5)
    rest = 1.0 - x
    return rest * rest * ((1.0 + 2.0 * x) * a + x * slope_a) + x * x * ((3.0 - 2.0 * x) * b - rest * slope_b)


@kernel
def turning(gap):
    """Return the rate (rad/s) at which the direction of a Gap turns."""
    return (gap.x * gap.vy - gap.y * gap.vx) / (gap.x * gap.x + gap.y * gap.y)


@kernel
def wear_joint(joint, j, step, worn):
    """Enter the wear of joint `j` over a Step."""
    side, course, h = joint.side, step.course[j], step.length
    before, after = step.before[j], step.after[j]
    angles_before, angles_after = step.angles_before[j], step.angles_after[j]
    a = math.atan2(side * before.y, side * before.x)
    b = math.atan2(side * after.y, side * after.x)
    turn_a, turn_b = turning(before), turning(after)
    pace_a, pace_b = h * course[KAPPA_COURSE, 0], h * course[KAPPA_COURSE, PARTS]
    bearing, journal = (0, 1) if side > 0.0 else (1, 0)
    spin_a = (before.spin_proximal, before.spin_distal)
    spin_b = (after.spin_proximal, after.spin_distal)
    bins = Bins(worn.depths, 2 * j * worn.stride, worn.stride, worn.account[j])
    for i in range(5):
        place, x = i * PARTS // 4, 0.25 * i
        force = max(course[FORCE, place], 0.0)
        distance = SIMPSON[i] * h * course[KAPPA_COURSE, place] * abs(course[SLIP_COURSE, place])
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
            joint.wear, joint, Rubbing(force, course[DEPTH_COURSE, place], distance, on_bearing, on_journal), bins
        )


@kernel
def _wear(joint, _, place, shared):
    step, worn = shared
    if touches(step.mode[place.contact]):
        wear_joint(joint, place.contact, step, worn)


_wear_each = map_joints(_wear, after_joint)


def wear_entry(scene, y, end, mode, course, length, depths, account, stride):
    """Enter the wear of a step; `length` holds its length, bare pointers as in `rates.rates_entry`."""
    here = scene[0]
    joints = len(here.joints)
    n = 2 * len(here.coordinates) + 1 + joints
    start, finish = shaped(y, (n,)), shaped(end, (n,))
    before, after = place(here.mechanism, start), place(here.mechanism, finish)
    step = Step(
        gaps(here.mechanism, before),
        gaps(here.mechanism, after),
        body_angles(here.mechanism, start),
        body_angles(here.mechanism, finish),
        shaped(course, (joints, COURSES, PARTS + 1)),
        shaped(length, (1,))[0],
        shaped(mode, (joints,)),
    )
    worn = Worn(shaped(depths, (2 * joints * stride,)), stride, shaped(account, (joints, ACCOUNT)))
    _wear_each(here.joints, here.joints, first_place(here.joints, 0), (step, worn))


def wear_of(scene, parameters) -> Entry:
    """Return the Entry that computes the wear of `scene`."""
    number = types.float64
    return entry(wear_entry, scene, (number, number, types.int64, number, number, number, number), parameters)
