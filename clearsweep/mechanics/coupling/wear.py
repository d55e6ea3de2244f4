"""The wear of a step: contact positions of all joints along it, and the depth removed there."""

from typing import NamedTuple

from ...tracing.compiled.choosing import lane_range
from ...tracing.compiled.family import Entry, entry, kernel, map_joints, shaped
from ..joints.contract import Offsets, after_joint, first_offsets, total_counts
from ..joints.worn import with_body_angles
from ..machines.contract import body_angles, gaps, pose_at
from ..observe import PARTS, STATE_POINTS, STEP_VALUE_ROWS
from ..wear import ACCOUNT_SIZE, Account
from ..wear.arc import WORKSPACE_SIZE, workspace_of
from ..wear.bins import (
    POSITIONS,
    RECORDED_SIZE,
    SLOPES,
    AxialRows,
    Instant,
    Step,
    StripRows,
    WearTotals,
    record,
    update_joint_wear,
)


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
def _update_wear(joint, _, offsets, step_and_totals):
    update_joint_wear(joint, offsets.contact, step_and_totals)


update_wear_of_joints = map_joints(_update_wear, after_joint)


@kernel
def _record_step_positions(scene, dense_states, step):
    """Record the contact positions of all joints on their bodies at the STATE_POINTS points of a step."""
    for i in lane_range(STATE_POINTS):
        y = dense_states[:, i]
        pose = pose_at(scene.mechanism, y)
        angles = body_angles(scene.mechanism, y)
        joint_gaps = with_body_angles(scene.joints, gaps(scene.mechanism, pose), angles)
        instant = Instant(joint_gaps, angles, i, step)
        record_positions(scene.joints, instant.gaps, JointCursor(0, first_offsets(scene.joints, 0)), instant)


def wear_entry(scene, dense_states, mode, step_values, length, workspace, depths, account, stride):
    """Add the wear of a step; arrays are bare pointers; `scene` is a pointer to the Scene.

    dense_states : (2 coordinates + 1, STATE_POINTS) the state within the step; length : of the step, in tau;
    workspace : of the size that `workspace_size` returns.
    """
    parameters = scene[0]
    contacts, state_size = total_counts(parameters.joints).contact, 2 * len(parameters.coordinates) + 1
    workspace_array, axial_offset = (
        shaped(workspace, (workspace_size(contacts, stride),)),
        WORKSPACE_SIZE + contacts * (POSITIONS + SLOPES) * STATE_POINTS,
    )
    strip_offset = axial_offset + contacts * AxialRows.SIZE * STATE_POINTS
    buffer_offset = strip_offset + StripRows.SIZE * (PARTS + 1)
    step = Step(
        shaped(step_values, (contacts, STEP_VALUE_ROWS, PARTS + 1)),
        shaped(length, (1,))[0],
        shaped(mode, (contacts,)),
        workspace_array[WORKSPACE_SIZE:axial_offset].reshape(contacts, POSITIONS + SLOPES, STATE_POINTS),
        AxialRows(workspace_array[axial_offset:strip_offset].reshape(contacts, AxialRows.SIZE, STATE_POINTS)),
        StripRows(workspace_array[strip_offset:buffer_offset].reshape(StripRows.SIZE, PARTS + 1)),
        workspace_of(workspace_array),
        workspace_array[buffer_offset:],
    )
    _record_step_positions(parameters, shaped(dense_states, (state_size, STATE_POINTS)), step)
    totals = WearTotals(
        shaped(depths, (2 * contacts * stride,)), stride, Account(shaped(account, (contacts, ACCOUNT_SIZE)))
    )
    update_wear_of_joints(parameters.joints, parameters.joints, first_offsets(parameters.joints, 0), (step, totals))


@kernel
def workspace_size(contacts, stride):
    """Return the size of the workspace for the wear of `contacts`; stride : largest number of bins of a body."""
    return WORKSPACE_SIZE + contacts * RECORDED_SIZE + StripRows.SIZE * (PARTS + 1) + 3 * stride


def wear_of(scene, parameters) -> Entry:
    """Return the Entry that computes the wear of `scene`."""
    return entry(wear_entry, scene, "fifffff", parameters)
