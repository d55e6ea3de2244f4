"""Bodies of a planar machine that its ideal joints do not determine."""

from typing import Any

from ....contracts.machine import (
    GROUND,
    Braking,
    Constant,
    Initial,
    Machine,
    Mesh,
    Rubbing,
    Slot,
    Spring,
    Stops,
    Stretch,
    TorsionSpring,
)
from .closure import MobilityError
from .structure import ANGLE, SHIFT_X, SHIFT_Y


def determined(machine: Machine) -> Machine:
    """Return a machine whose joints determine it: without stops, with rigid torsion springs or without free bodies."""
    machine = machine._replace(joints=tuple(joint for joint in machine.joints if not isinstance(joint, Stops)))
    rigid = with_rigid_springs(machine)
    return rigid if _constraints(rigid) == 3 * (len(rigid.bodies) - 1) else without_free_bodies(machine)


def without_free_bodies(machine: Machine) -> Machine:
    """Return a machine without the free bodies that its joints do not determine; raise MobilityError.

    A free body has a given initial state.  Its joints and the loads on it are also removed.
    """
    free = {name for name, body in machine.bodies.items() if body.initial is not None}
    if not free or _constraints(machine) == 3 * (len(machine.bodies) - 1):
        return machine
    if machine.aim.body in free:
        raise MobilityError(
            f"the output cannot be the free body {machine.aim.body!r}: without clearance its motion is undetermined; "
            "choose a body whose motion ideal joints determine, such as the driven body"
        )
    joints = tuple(j for j in machine.joints if not free & {j.proximal.body, j.distal.body})
    names = {joint.name for joint in joints}
    loads = tuple(load for load in machine.loads if not free & _bodies_of(load) and names >= _joints_of(load))
    bodies = {name: body for name, body in machine.bodies.items() if name not in free}
    return machine._replace(bodies=bodies, joints=joints, loads=loads)


def without_forces(machine: Machine) -> Machine:
    """Return a machine at a constant speed without loads except the torsion springs that determine its position."""
    springs = tuple(load for load in machine.loads if isinstance(load, TorsionSpring))
    return machine._replace(drive=Constant(1.0, machine.drive.start_angle), loads=springs)


def with_rigid_springs(machine: Machine) -> Machine:
    """Return a machine in which torsion springs stay at their free angles where only they determine how a body turns.

    The first springs count, as many as degrees of freedom are left.
    """
    missing = 3 * (len(machine.bodies) - 1) - _constraints(machine)
    springs = [load for load in machine.loads if isinstance(load, TorsionSpring)][: max(missing, 0)]
    couplings = (
        Mesh(spring.name, spring.second, spring.first, GROUND, -1.0, rest=spring.free_angle) for spring in springs
    )
    loads = tuple(load for load in machine.loads if load not in springs)
    return machine._replace(joints=(*machine.joints, *couplings), loads=loads) if springs else machine


def _constraints(machine: Machine) -> int:
    """Return the number of equations of joints and drive, with springs at rest."""
    return 1 + sum({Slot: 1, Mesh: 1, Stretch: 3}.get(type(joint), 2) for joint in machine.joints)


def _bodies_of(load: Any) -> set[str]:
    """Return the bodies that a load acts on; for friction in a joint, those of the joint."""
    if isinstance(load, Rubbing | Braking):
        return set()
    if isinstance(load, Spring | TorsionSpring):
        return {load.first.body, load.second.body}
    return {load.at.body}


def _joints_of(load: Any) -> set[str]:
    return {load.joint} if isinstance(load, Rubbing | Braking) else set()


def initial_coordinate(initial: Initial, kind: int) -> tuple[float, float]:
    """Return the initial coordinate of a free body and its rate."""
    return {ANGLE: (initial.angle, initial.rate), SHIFT_X: (initial.x, initial.vx), SHIFT_Y: (initial.y, initial.vy)}[
        kind
    ]
