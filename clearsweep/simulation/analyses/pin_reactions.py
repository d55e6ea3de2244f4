"""Forces in the joints without clearance of one case over time, from the accelerations of its motion."""

from typing import NamedTuple

import numpy as np

from ...contracts.case import Case, Joint, column_name
from ...contracts.machine import GROUND, Machine, Pin, Stretch
from ...contracts.results import Trajectory
from ...mechanics.machines.planar.reactions import JointForce, Motion, Reactions, reactions
from ..machine.ideal import mechanism_of
from ..setup.scene import Scene
from .trajectory import simulate

STEP = 1e-6  # of the mean distance of the samples of a turn, between the two velocities of an acceleration
PIN_CHANNELS = ("x", "y", "force_normal", "force_tangential")  # channels of an open pin


class PinReactions(NamedTuple):
    """A trajectory, and the forces on the bodies with the journals of its pins without clearance, at its times."""

    trajectory: Trajectory
    forces: dict[str, np.ndarray]  # joint in columns ('crank_rod') -> (n, 2) N, in the fixed frame
    couples: dict[str, np.ndarray]  # guide in columns -> (n,) N m, on the sliding body
    torque: np.ndarray  # (n,) N m, of the drive


def reactions_unknown(case: Case) -> str:
    """Return why the forces in the joints without clearance are not known for a case; '' if they are."""
    mechanism = mechanism_of(case)
    if mechanism.machine is None:
        return "the mechanism is not planar"
    machine = mechanism.machine(case)
    if any(isinstance(joint, Stretch) for joint in machine.joints):
        return "a link is elastic"
    if any(body.initial is not None for body in machine.bodies.values()):
        return "a body is free"
    joints_by_name = {joint.name: joint for joint in machine.joints}
    if not all(isinstance(joints_by_name[joint.name], Pin) and joint.film is None for joint in case.joints):
        return "a joint with clearance is not a dry pin"
    return "its life changes the surfaces" if case.life else ""


def pin_reactions(scene: Scene, times: np.ndarray) -> PinReactions:
    """Return a trajectory at times (n,) s and the forces in its joints without clearance, or none if it failed.

    `reactions_unknown` must be '' for the case.  An acceleration is the difference of two close velocities.  Bristles
    of friction in joints without clearance count as bent by long sliding.
    """
    case, machine_of = scene.case, mechanism_of(scene.case).machine
    assert machine_of is not None  # of a case that is not refused
    machine = machine_of(case)
    step = STEP * float(np.min(np.diff(times)))
    first_times = np.append(times[:-1], times[-1] - step)
    trajectory = simulate(scene, np.stack([first_times, first_times + step], -1).ravel())
    if trajectory.status != "ok":
        return PinReactions(trajectory, {}, {}, np.zeros(0))
    result = reactions(
        machine,
        _motion(machine, trajectory),
        {joint.name: _joint_force(joint, machine, trajectory) for joint in case.joints},
    )
    return PinReactions(trajectory, _on_journals(case, result), *_couples_and_torque(result))


def _motion(machine: Machine, trajectory: Trajectory) -> Motion:
    """Return the bodies at every second sample of a trajectory, with the accelerations up to the sample after it."""
    channels = trajectory.channels
    names = [column_name(name) for name in machine.bodies if name != GROUND]
    time, step = channels["t"][::2], np.diff(channels["t"])[::2]
    q = np.stack([channels[f"{name}/{key}"] for name in names for key in ("x", "y", "angle")], -1)
    rates = np.stack([channels[f"{name}/{key}"] for name in names for key in ("vx", "vy", "rate")], -1)
    accelerations = (rates[1::2] - rates[::2]) / step[:, None]
    return Motion(time, channels["crank_angle"][::2], q[::2], rates[::2], accelerations)


def _joint_force(joint: Joint, machine: Machine, trajectory: Trajectory) -> JointForce:
    """Return force and moment in a dry pin with clearance at every second sample of a trajectory."""
    x, y, normal, tangential = (
        trajectory.channels[f"joints/{column_name(joint.name)}/{key}"][::2] for key in PIN_CHANNELS
    )
    distance = np.hypot(x, y)
    outward = np.stack([x, y], -1) / np.where(distance > 0.0, distance, 1.0)[:, None]
    on_journal = -normal[:, None] * outward + tangential[:, None] * np.stack([-outward[:, 1], outward[:, 0]], -1)
    radius = joint.bearing_radius or 0.0
    couples = (radius - joint.clearance) * tangential, -radius * tangential
    distal = next(machine_joint.distal.body for machine_joint in machine.joints if machine_joint.name == joint.name)
    if joint.journal in (None, distal):
        return JointForce(on_journal, *couples)
    return JointForce(-on_journal, *couples[::-1])


def _on_journals(case: Case, result: Reactions) -> dict[str, np.ndarray]:
    """Return the forces on the bodies that would carry the journals; for a guide or slot, on the distal body."""
    signs = {site.name: -1.0 if site.journals[0] == site.proximal else 1.0 for site in mechanism_of(case).joints}
    return {column_name(name): signs.get(name, 1.0) * force for name, force in result.forces.items()}


def _couples_and_torque(result: Reactions) -> tuple[dict[str, np.ndarray], np.ndarray]:
    return {column_name(name): couple for name, couple in result.couples.items()}, result.torque
