"""The approach speed at which the contacts of a scene first yield."""

import functools
import math

import numpy as np

from ...contracts.case import Joint
from ...mechanics.joints import registry
from ...mechanics.joints.dry import Gap
from ...mechanics.joints.registry import largest_mass, yield_energy
from ...mechanics.machines.contract import impact_masses, pose_at
from ...tracing.compiled.family import Identity
from ..setup.scene import Scene

DIRECTIONS = tuple(math.radians(angle) for angle in (0.0, 45.0, 90.0))  # see `largest_mass`


def yield_speeds(scene: Scene) -> dict[str, float | None]:
    """Return the approach speed (m/s) at first yield of each joint of known strength, by column; None if undefined.

    The speed is sqrt(2 W / m), with W the elastic energy at first yield and m the largest effective mass at the start.
    """
    elastic_joints = [
        (index, case_joint)
        for index, (case_joint, joint) in enumerate(zip(scene.case.joints, scene.layout.joints, strict=True))
        if joint.strength
    ]
    if not elastic_joints:
        return {}
    masses = _largest_masses(Identity(scene.value.mechanism), scene.start.tobytes(), len(scene.case.joints))
    return {
        f"{case_joint.column}_yield_speed": _speed(case_joint, masses[index]) for index, case_joint in elastic_joints
    }


def _speed(joint: Joint, mass: float | None) -> float | None:
    """Return the approach speed (m/s) at which a joint first yields under a mass (kg), or None if unknown."""
    if mass is None:
        return None
    energy = yield_energy(joint, registry.compile_contact(joint)[1])
    return None if energy is None else math.sqrt(2.0 * energy / mass)


@functools.lru_cache(maxsize=256)  # the cases of a sweep share mechanisms and starts
def _largest_masses(mechanism: Identity, start: bytes, joint_count: int) -> list[float | None]:
    """Return the largest effective mass (kg) of each joint over all directions at a start, or None if unknown.

    mechanism : compiled; start : the initial state of the scene, as bytes of float64.
    """
    pose = pose_at(mechanism.value, np.frombuffer(start))
    by_direction = [
        impact_masses(
            mechanism.value,
            pose,
            (Gap(math.cos(direction), math.sin(direction), 0.0, 0.0, 0.0, 0.0),) * joint_count,
        )
        for direction in DIRECTIONS
    ]
    return [largest_mass(np.array(masses, float)) for masses in zip(*by_direction, strict=True)]
