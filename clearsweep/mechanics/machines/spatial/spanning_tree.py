"""The spanning tree of a spatial machine, and the checks that it exists."""

from collections.abc import Collection, Mapping
from typing import NamedTuple

from ....contracts.machine import GROUND, Guide, Machine

REVOLUTE, SPHERICAL, CYLINDRICAL = "revolute", "spherical", "cylindrical"
TILTING = (SPHERICAL, CYLINDRICAL)


class Attachment(NamedTuple):
    """Attachment of a body: joint and parent."""

    body: str
    joint: str  # '': loose
    parent: str = GROUND


class SpanningTreeError(ValueError):
    """A machine that is not a tree, or that cannot leave the plane; `joint` is at fault."""

    def __init__(self, joint: str, text: str):
        super().__init__(text)
        self.joint = joint


def spanning_tree(machine: Machine, open_joints: Collection[str], ideal: Mapping[str, str]) -> list[Attachment]:
    """Return the attachments of the moving bodies, parents first, beginning with the crank.

    with_clearance : joints with clearance; ideal : freedom of each other pin.  Raises UntiedError.
    """
    ideal_joints = [joint for joint in machine.joints if joint.name not in open_joints]
    crank = next(joint for joint in ideal_joints if joint.name == machine.driven)
    attachments = [Attachment(crank.distal.body, crank.name)]
    used_joints, placed = {crank.name}, {GROUND, crank.distal.body}
    while len(placed) < len(machine.bodies):
        for joint in ideal_joints:
            bodies = [endpoint.body for endpoint in (joint.proximal, joint.distal)]
            unplaced = [body for body in bodies if body not in placed]
            if len(unplaced) == 1:
                (parent,) = [body for body in bodies if body in placed]
                attachments.append(Attachment(unplaced[0], joint.name, parent))
                used_joints.add(joint.name)
                placed.add(unplaced[0])
                break
        else:
            body = next(body for body in machine.bodies if body not in placed)
            attachments.append(Attachment(body, ""))
            placed.add(body)
    for joint in ideal_joints:
        if joint.name not in used_joints:
            raise SpanningTreeError(
                joint.name,
                "closes a loop of joints without clearance, which is not known in space: give clearance to "
                f"{joint.name} or to another joint of that loop",
            )
    _check_mobility(machine, open_joints, ideal, attachments)
    return attachments


def _check_mobility(
    machine: Machine, open_joints: Collection[str], ideal: Mapping[str, str], attachments: list[Attachment]
) -> None:
    """Raise UntiedError if pins keep both bodies of an open joint in the plane."""
    flat = {GROUND}
    for attachment in attachments:
        if attachment.parent in flat and attachment.joint and ideal.get(attachment.joint, REVOLUTE) not in TILTING:
            flat.add(attachment.body)
    for joint in machine.joints:
        if joint.name in open_joints and {joint.proximal.body, joint.distal.body} <= flat:
            pins = [
                attachment.joint
                for attachment in attachments[1:]
                if attachment.body in flat and not isinstance(_joint(machine, attachment.joint), Guide)
            ]
            raise SpanningTreeError(
                joint.name,
                f"cannot tilt or shift: {' and '.join([machine.driven, *pins])} are revolute joints, which keep its "
                "bodies in the plane" + (f"; write ideal: {{{pins[-1]}: spherical}} or cylindrical" if pins else ""),
            )


def _joint(machine: Machine, name: str):
    return next(joint for joint in machine.joints if joint.name == name)
