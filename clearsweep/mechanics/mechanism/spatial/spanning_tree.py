"""The spanning tree of a spatial machine, and the checks that it exists."""

from collections.abc import Collection, Mapping
from typing import NamedTuple

from ....contracts.machine import GROUND, Guide, Machine

REVOLUTE, SPHERICAL, CYLINDRICAL = "revolute", "spherical", "cylindrical"
TILTING = (SPHERICAL, CYLINDRICAL)


class Hang(NamedTuple):
    """Attachment of a body: joint and parent."""

    body: str
    joint: str  # '': loose
    parent: str = GROUND


class UntiedError(ValueError):
    """A machine that is not a tree, or that cannot leave the plane; `joint` is at fault."""

    def __init__(self, joint: str, text: str):
        super().__init__(text)
        self.joint = joint


def spanning_tree(machine: Machine, opened: Collection[str], ideal: Mapping[str, str]) -> list[Hang]:
    """Return the attachments of the moving bodies, parents first, beginning with the crank.

    opened : joints with clearance; ideal : freedom of each other pin.  Raises UntiedError.
    """
    closed = [joint for joint in machine.joints if joint.name not in opened]
    crank = next(joint for joint in closed if joint.name == machine.driven)
    hangs_ = [Hang(crank.distal.body, crank.name)]
    used, placed = {crank.name}, {GROUND, crank.distal.body}
    while len(placed) < len(machine.bodies):
        for joint in closed:
            ends = [end.body for end in (joint.proximal, joint.distal)]
            hangs = [body for body in ends if body not in placed]
            if len(hangs) == 1:
                (parent,) = [body for body in ends if body in placed]
                hangs_.append(Hang(hangs[0], joint.name, parent))
                used.add(joint.name)
                placed.add(hangs[0])
                break
        else:
            body = next(body for body in machine.bodies if body not in placed)
            hangs_.append(Hang(body, ""))
            placed.add(body)
    for joint in closed:
        if joint.name not in used:
            raise UntiedError(
                joint.name,
                "closes a loop of joints without clearance, which is not known in space: give clearance to "
                f"{joint.name} or to another joint of that loop",
            )
    _check_ways(machine, opened, ideal, hangs_)
    return hangs_


def _check_ways(machine: Machine, opened: Collection[str], ideal: Mapping[str, str], hangs_: list[Hang]) -> None:
    """Raise UntiedError if pins keep both bodies of an open joint in the plane."""
    flat = {GROUND}
    for hang in hangs_:
        if hang.parent in flat and hang.joint and ideal.get(hang.joint, REVOLUTE) not in TILTING:
            flat.add(hang.body)
    for joint in machine.joints:
        if joint.name in opened and {joint.proximal.body, joint.distal.body} <= flat:
            pins = [
                hang.joint
                for hang in hangs_[1:]
                if hang.body in flat and not isinstance(_joint(machine, hang.joint), Guide)
            ]
            raise UntiedError(
                joint.name,
                f"cannot tilt or shift: {' and '.join([machine.driven, *pins])} are revolute joints, which keep its "
                "bodies in the plane" + (f"; write ideal: {{{pins[-1]}: spherical}} or cylindrical" if pins else ""),
            )


def _joint(machine: Machine, name: str):
    return next(joint for joint in machine.joints if joint.name == name)
