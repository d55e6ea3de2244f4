"""Wear over a step of the motion, spread over angular bins in each body's own frame."""

import math
from typing import NamedTuple

import numpy as np

from ...tracing.compiled.choosing import lane_range
from ...tracing.compiled.family import family, kernel, map_joints
from ...tracing.portable import exact, inverse
from ..joints.contract import Offsets
from ..joints.offsets import after_joint
from ..laws.contract import touches
from ..observe import FORCE_ROW, FRICTION_POWER_ROW, KAPPA_ROW, PARTS, QUARTER_POINTS, STATE_POINTS, STEP_VALUE_ROWS
from .account import accumulate_distance
from .arc_over_step import BEARING_ANGLE_ROW, DEGREE, FIT, POINTS
from .binning import update_worn_profile
from .contract import Bins, JointAccount, NoWear, contact_angle

ANGLES = (
    QUARTER_POINTS + 4
)  # numbers that determine the profile of an angle: at the quarters, then its slopes at both ends
POSITIONS = 3  # such profiles of a contact: its angles on both bodies (rad) and, of worn surfaces, its depth (m)
SLOPES = POSITIONS  # of these profiles, per fraction of the step; `record` writes the rates per second
#: What a joint in space notes of a contact at the quarters, see `wall_strips.StripPosition`.
LEAN, REACH, TILT_SQUARE, BEARING_START, JOURNAL_START, FACING, AXIAL_ROWS = range(7)
#: Of the strip of one contact at equidistant times: the first three, as at the quarters, its largest depth (m), and
#: its integrals, see `wall_strips.integrals_of`.
MAX_DEPTH, LOAD_INTEGRAL, DEPTH_INTEGRAL, STRIP_ROWS = range(TILT_SQUARE + 1, TILT_SQUARE + 5)
RECORDED_SIZE = (POSITIONS + SLOPES + AXIAL_ROWS) * STATE_POINTS  # numbers stored per contact
_QUARTERS = np.arange(QUARTER_POINTS + 2) / (QUARTER_POINTS + 1)
#: (ANGLES, POINTS): the coefficients of an angle's profile from its values at the quarters and its end slopes.
FROM_ANGLES = np.zeros((ANGLES, POINTS))
_AT_QUARTERS = [[quarter**i for i in range(DEGREE + 1)] for quarter in _QUARTERS.tolist()]
_AT_ENDS = [[float(i == 1) for i in range(DEGREE + 1)], [float(i) for i in range(DEGREE + 1)]]
FROM_ANGLES[:, : DEGREE + 1] = inverse(exact(_AT_QUARTERS + _AT_ENDS)).transposed.rounded()


class Step(NamedTuple):
    """Profiles and positions of the contacts over a step of the motion, and workspaces."""

    step_values: np.ndarray  # (contacts, STEP_VALUE_ROWS, PARTS + 1) see observe.histogram
    length: float  # of the step
    mode: np.ndarray  # (contacts,) int64, mode of each contact
    positions: np.ndarray  # (contacts, POSITIONS + SLOPES, STATE_POINTS)
    axial: np.ndarray  # (contacts, AXIAL_ROWS, STATE_POINTS) of joints in space
    strip: np.ndarray  # (STRIP_ROWS, PARTS + 1) of one of their contacts, at equidistant times
    workspace: np.ndarray  # (WORKSPACE_SIZE,) see arc_over_step
    wear_buffer: np.ndarray  # (3 stride,) bins (m) of both bodies, at 0 between the contacts; slices of one contact


class WearTotals(NamedTuple):
    """Wear of all joints, to which each step adds; the depths of a joint are at its first contact."""

    depths: np.ndarray  # (2 contacts stride,) m, the bins of bearing and journal
    stride: int
    account: np.ndarray  # (contacts, ACCOUNT_SIZE)


class Instant(NamedTuple):
    """Positions of the bodies at one time of a step."""

    gaps: tuple  # a gap per joint
    body_angles: tuple  # body_angles of every joint
    number: int
    step: Step


@family
def record(joint, gap, body_angles, j, instant):
    """Record the positions of a joint's contacts, the first being `j`, at an Instant; body_angles : (2,) rad."""


@record.member(None)
def _default_record(joint, gap, body_angles, j, instant):
    step, i = instant.step, instant.number
    if not touches(step.mode[j]):
        return
    side = joint.side
    angle, angle_rate, depth, depth_rate = contact_angle(joint, gap)
    proximal_angle, distal_angle = body_angles
    bearing_angle, journal_angle = (proximal_angle, distal_angle) if side > 0.0 else (distal_angle, proximal_angle)
    step.positions[j, 0, i], step.positions[j, 1, i], step.positions[j, 2, i] = (
        angle - bearing_angle,
        angle - journal_angle,
        depth,
    )
    proximal_rate, distal_rate = angle_rate - gap.spin_proximal, angle_rate - gap.spin_distal
    step.positions[j, SLOPES, i] = proximal_rate if side > 0.0 else distal_rate
    step.positions[j, SLOPES + 1, i] = distal_rate if side > 0.0 else proximal_rate
    step.positions[j, SLOPES + 2, i] = depth_rate


class JointCursor(NamedTuple):
    """Number of a joint, and its Offsets."""

    number: int
    offsets: Offsets


@kernel
def _cursor_after(cursor, joint):
    return JointCursor(cursor.number + 1, after_joint(cursor.offsets, joint))


@kernel
def _record_joint(joint, gap, cursor, instant):
    record(joint, gap, instant.body_angles[cursor.number], cursor.offsets.contact, instant)


record_positions = map_joints(_record_joint, _cursor_after)


@kernel
def fit_profiles(workspace, step_values, length):
    """Write the coefficients of the profiles of a contact, its forces per `length` (m), to `workspace`."""
    per_length = 1.0 / length
    for i in lane_range(POINTS):
        for row in range(STEP_VALUE_ROWS):
            total = 0.0
            for k in range(PARTS + 1):
                total += FIT[k, i] * step_values[row, k]
            workspace[row * POINTS + i] = total * per_length if row in (FORCE_ROW, FRICTION_POWER_ROW) else total


@kernel
def unwrap_angles(angles):
    """Remove jumps by full turns from angles (rad) at the quarters of a step."""
    full_turn, turns, previous_angle, largest_change = 2.0 * math.pi, 0.0, angles[0], 0.0
    for i in range(1, QUARTER_POINTS + 2):
        largest_change = max(largest_change, abs(angles[i] - angles[i - 1]))
    if largest_change <= math.pi:
        return
    for i in range(1, QUARTER_POINTS + 2):
        angle = angles[i]
        turns += math.floor((angle - previous_angle) * (1.0 / full_turn) + 0.5)
        angles[i], previous_angle = angle - full_turn * turns, angle


@kernel
def fit_positions(workspace, positions):
    """Write the coefficients of the profiles of the position of a contact to `workspace`."""
    for i in lane_range(POINTS):
        for row in range(POSITIONS):
            total = 0.0
            for k in range(QUARTER_POINTS + 2):
                total += FROM_ANGLES[k, i] * positions[row, k]
            total += FROM_ANGLES[ANGLES - 2, i] * positions[SLOPES + row, 0]
            total += FROM_ANGLES[ANGLES - 1, i] * positions[SLOPES + row, QUARTER_POINTS + 1]
            workspace[(BEARING_ANGLE_ROW + row) * POINTS + i] = total


@kernel
def write_end_slopes(step, j):
    """Write the slopes of the profiles of the position of contact `j` at both ends of the step, from their rates."""
    for end, part_index in ((0, 0), (QUARTER_POINTS + 1, PARTS)):
        duration = step.length * step.step_values[j, KAPPA_ROW, part_index]
        for row in range(POSITIONS):
            step.positions[j, SLOPES + row, end] *= duration


@family
def update_contact_wear(law, joint, j, step_and_totals):
    """Add the wear of contact `j` of a joint with this wear law, over a Step; step_and_totals : Step and WearTotals."""


@update_contact_wear.member(NoWear)
def _update_contact_wear_no_wear(law, joint, j, step_and_totals):
    pass


@update_contact_wear.member(None)
def _default_update_contact_wear(law, joint, j, step_and_totals):
    step, totals = step_and_totals
    fit_profiles(step.workspace, step.step_values[j], law.length)
    for body in range(2):
        unwrap_angles(step.positions[j, body])
    write_end_slopes(step, j)
    fit_positions(step.workspace, step.positions[j])
    accumulate_distance(step, j, totals.account[j])
    count, bins_offset = int(law.bins), 2 * j * totals.stride
    bins = Bins(totals.depths, bins_offset, count), Bins(totals.depths, bins_offset + totals.stride, count)
    account = JointAccount(totals.account[j], 1.0)
    update_worn_profile(joint, step.workspace, step.step_values[j], step.length, bins, account)


@family
def update_joint_wear(joint, j, step_and_totals):
    """Add the wear of a joint, whose first contact is `j`, over a Step; step_and_totals : Step and WearTotals."""


@update_joint_wear.member(None)
def _default_update_joint_wear(joint, j, step_and_totals):
    if touches(step_and_totals[0].mode[j]):
        update_contact_wear(joint.wear, joint, j, step_and_totals)


@kernel
def _update_wear(joint, _, offsets, step_and_totals):
    update_joint_wear(joint, offsets.contact, step_and_totals)


update_wear_of_joints = map_joints(_update_wear, after_joint)
