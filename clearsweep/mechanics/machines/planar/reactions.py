"""Forces in the joints without clearance of a planar machine in motion, from the accelerations of its bodies.

The joints with clearance act as loads of known size.  The forces in the other joints are the multipliers of their
constraints (Haug 1989, "Computer Aided Kinematics and Dynamics", chapter 6): J^T f = applied - M a.
"""

import math
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np

from ....contracts.machine import GROUND, BodyPoint, Guide, Machine
from ....tracing.compiled.choosing import directions
from .closure import MachineStates
from .ideal import IdealMachine, ideal_of


class JointForce(NamedTuple):
    """Force and moment on the distal body of a joint with clearance; the proximal body has the opposite force."""

    force: np.ndarray  # (N, 2) N, at the joint's point
    couple_distal: np.ndarray  # (N,) N m, besides
    couple_proximal: np.ndarray


class Motion(NamedTuple):
    """The moving bodies of a machine at N times, in the order of the machine: x, y (m) and angle (rad) of each."""

    time: np.ndarray  # (N,) s
    crank_angle: np.ndarray  # (N,) rad, from the start angle on
    q: np.ndarray  # (N, 3 bodies)
    rates: np.ndarray
    accelerations: np.ndarray


class Reactions(NamedTuple):
    """Forces and couples in the joints without clearance."""

    forces: dict[str, np.ndarray]  # joint -> (N, 2) N, on its distal body
    couples: dict[str, np.ndarray]  # guide -> (N,) N m, on its distal body about the joint's point
    torque: np.ndarray  # (N,) N m, of the drive on the crank


def reactions(machine: Machine, motion: Motion, open_joint_forces: Mapping[str, JointForce]) -> Reactions:
    """Return forces and couples of the joints without clearance, and the torque of the drive."""
    ideal_machine = ideal_of(machine)
    closure, joints = ideal_machine.closure, ideal_machine.machine.joints
    states = MachineStates(motion.crank_angle, motion.q, motion.rates, motion.accelerations)
    ones = np.ones(len(motion.time))  # derivatives by time instead of those by the crank's angle
    applied = ideal_machine.applied_forces(states, ones, motion.time) - ideal_machine.inertia * motion.accelerations
    given_forces = {name: joint_force.force for name, joint_force in open_joint_forces.items()}
    for joint in joints:
        if joint.name in open_joint_forces:
            force, on_distal, on_proximal = open_joint_forces[joint.name]
            ideal_machine.add_force(applied, states, joint.distal, force, on_distal)
            ideal_machine.add_force(applied, states, joint.proximal, -force, on_proximal)
    row_ranges = list(zip(joints, closure.first_rows, closure.first_rows[1:], strict=False))
    is_closed_row = np.ones(closure.rows, bool)
    for joint, begin, end in row_ranges:
        is_closed_row[begin:end] = joint.name not in open_joint_forces
    jacobian = closure.evaluate(states.q, states.angles)[1][:, is_closed_row]
    inverse = np.linalg.pinv(np.swapaxes(jacobian, 1, 2))

    def solve(friction_forces):
        multipliers = np.zeros((len(ones), closure.rows))
        multipliers[:, is_closed_row] = np.einsum("nij,nj->ni", inverse, applied + friction_forces)
        forces = {
            joint.name: ideal_machine.reaction_of(joint, states, multipliers[:, begin:end])
            for joint, begin, end in row_ranges
            if joint.name not in open_joint_forces
        }
        ideal_machine.add_tooth_forces(forces, states)
        return forces | given_forces, forces, multipliers

    _, forces, multipliers = ideal_machine.with_friction(states, ones, solve)
    couples = {joint.name: -multipliers[:, begin] for joint, begin, _ in row_ranges if isinstance(joint, Guide)}
    return Reactions(
        forces, {name: joint_force for name, joint_force in couples.items() if name in forces}, -multipliers[:, -1]
    )


def levers(ideal_machine: IdealMachine, body: str, near: str, far: str) -> np.ndarray:
    """Return the displacement of the output (STATIONS + 1,) for a unit of extension of the line between two points.

    By reciprocity it is the force in this line under a unit force at the output, with the crank at rest.
    """
    states = ideal_machine.revolution
    if body not in ideal_machine.closure.index:
        return np.zeros(len(states.angles))
    force = np.zeros((len(states.q), 2))
    for joint, reaction in _reactions_to_output(ideal_machine):
        for sign, endpoint in ((1.0, joint.distal), (-1.0, joint.proximal)):
            if endpoint == BodyPoint(body, far):
                force += sign * reaction
    points = ideal_machine.machine.bodies[body].points
    x, y = np.subtract(points[far], points[near])
    cosine, sine = directions(ideal_machine.closure.angle(body, states.q) + math.atan2(y, x))
    levers: np.ndarray = force[:, 0] * cosine + force[:, 1] * sine
    return levers


def levers_of_support(ideal_machine: IdealMachine, name: str) -> np.ndarray:
    """Return the displacement of the output (STATIONS + 1, 2) for a unit of that of a joint's ground along x and y.

    By reciprocity it is the force of the machine on this ground under a unit force at the output.
    """
    bodies = ideal_machine.machine.bodies
    for joint, reaction in _reactions_to_output(ideal_machine):
        if joint.name == name:
            on_ground = joint.distal.body == GROUND or bodies[joint.distal.body].mounted
            return reaction if on_ground else -reaction
    return np.zeros((len(ideal_machine.revolution.angles), 2))  # it carries free bodies only


def _reactions_to_output(ideal_machine: IdealMachine) -> Iterator[tuple[Any, np.ndarray]]:
    """Yield the joints, each with the force on its distal body under a unit force at the output, the crank at rest."""
    states, aim, closure = ideal_machine.revolution, ideal_machine.machine.aim, ideal_machine.closure
    unit = np.zeros_like(states.q)
    if aim.point:
        direction = np.tile([math.cos(aim.direction), math.sin(aim.direction)], (len(states.q), 1))
        ideal_machine.add_force(unit, states, BodyPoint(aim.body, aim.point), direction, 0.0)
    else:
        unit[:, 3 * closure.index[aim.body] + 2] = 1.0
    assert states.inverse is not None  # of a revolution that was closed
    multipliers = states.inverse.multipliers(unit)
    for joint, begin, end in zip(
        ideal_machine.machine.joints, closure.first_rows, closure.first_rows[1:], strict=False
    ):
        yield joint, ideal_machine.reaction_of(joint, states, multipliers[:, begin:end])
