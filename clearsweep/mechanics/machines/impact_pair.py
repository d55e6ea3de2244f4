"""Two bodies on a line with one gap: the behaviour of a contact law in isolation."""

from typing import NamedTuple

import numpy as np

from ...contracts.catalogue import CHOICE, CONDITION, Channel, Field, JointSite, Keys, Mechanism
from ..joints.dry import Gap
from . import contract


class ImpactPair(NamedTuple):
    """The coordinate is the displacement of the second body relative to the first."""

    mass: float  # kg, m1 m2 / (m1 + m2)


class Pose(NamedTuple):
    """The second body relative to the first."""

    x: float  # m
    v: float  # m/s


def build(bodies, drive, joints, offsets) -> contract.Built:
    """Return the pair centred in its gap, approaching."""
    first_mass, second_mass, speed = bodies["masses.0"], bodies["masses.1"], bodies["speed"]
    clearance = joints["pair"].clearance
    start = np.array([offsets["pair"][0], speed, 0.0])
    return contract.Built(
        ImpactPair(first_mass * second_mass / (first_mass + second_mass)),
        start,
        np.ones(1),
        clearance,
        speed / clearance,
    )


MECHANISM = Mechanism(
    "impact-pair",
    "two bodies on a line with one gap: the restitution of a contact law alone",
    "m x'' = -F, m = m1 m2 / (m1 + m2); gap 2 x clearance in all",
    "Newton; a free impact has a closed form for most laws",
    "",
    bodies=("first", "second"),
    joints=(JointSite("pair", "first", "second", "line"),),
    keys=(
        Keys(
            "mechanism.masses",
            "masses of the two bodies",
            (Field("0", "kg", "mass of the first body"), Field("1", "kg", "mass of the second body")),
            role=CHOICE,
        ),
        Keys(
            "mechanism", "", (Field("speed", "m/s", "speed at which the bodies approach each other"),), role=CONDITION
        ),
    ),
    channels=(
        Channel("pair/x", "m", "displacement of the second body relative to the first"),
        Channel("pair/v", "m/s", "its rate"),
    ),
    turns=False,
    build=build,
)


contract.pose_at.member(ImpactPair)(lambda mechanism, y: Pose(y[0], y[1]))
contract.gaps.member(ImpactPair)(lambda mechanism, pose: (Gap(pose.x, 0.0, pose.v, 0.0, 0.0, 0.0),))


@contract.accelerate.member(ImpactPair)
def _accelerate_impact_pair(mechanism, pose, loads):
    return contract.Motion((loads[0].fx * (1.0 / mechanism.mass),), 0.0, 0.0)


contract.impact_masses.member(ImpactPair)(lambda mechanism, pose, joint_gaps: (mechanism.mass,))
contract.energy.member(ImpactPair)(lambda mechanism, pose: (0.5 * mechanism.mass * pose.v * pose.v, 0.0))
contract.body_angles.member(ImpactPair)(lambda mechanism, y: ((0.0, 0.0),))
contract.output_error.member(ImpactPair)(lambda mechanism, pose: (0.0, 0.0))
contract.describe.member(ImpactPair)(lambda mechanism, y, pose, motion: (y[2], pose.x, pose.v))
