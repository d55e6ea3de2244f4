"""Chooses the dependent coordinates of a planar machine, which its loops determine."""

import itertools

import numpy as np

from .drive import Steady
from .form import Planar
from .machine_type import MachineType
from .pose_generation import loop_jacobian, pose_of
from .spanning_tree import ANGLE, TRAVEL, Coordinate

NEAR_SINGULAR = 1e-7  # least singular value over the largest: a change point, where no choice is better
EXAMINED_ANGLES = 36  # crank angles that are examined


def choose_dependent(value: Planar, machine: MachineType, profiles: list) -> list[int]:
    """Return the indices of the coordinates that, taken as dependent, keep the loops furthest from singular.

    value : a machine without dependent coordinates; profiles : (values, slopes, ...) of each coordinate at
    equidistant angles over a revolution of the ideal machine.
    """
    from scipy.linalg import qr

    if not machine.free:
        value = value._replace(drive=Steady(1.0, value.cycle.start))
    jacobians_at_angles = []
    angles = range(0, len(profiles[0][0]) - 1, max((len(profiles[0][0]) - 1) // EXAMINED_ANGLES, 1))
    for k in angles:
        time = 2.0 * np.pi * k / (len(profiles[0][0]) - 1)
        y = np.array([*(profile[0][k] for profile in profiles), *(0.0 for _ in profiles), time])
        jacobians_at_angles.append(np.array(loop_jacobian(value, pose_of(value, y))))
    jacobians = np.array(jacobians_at_angles)
    fixed_coordinates = {
        Coordinate(ANGLE, machine.spanning_tree.crank),
        *(Coordinate(TRAVEL, j) for j in machine.sprung),
    }
    candidates = [
        i for i, coordinate in enumerate(machine.spanning_tree.coordinates) if coordinate not in fixed_coordinates
    ]
    scale = np.max(np.abs(jacobians), axis=(0, 2), keepdims=True)
    jacobians = (jacobians / scale)[:, :, candidates]
    singular_values = np.linalg.svd(jacobians, compute_uv=False)
    jacobians = jacobians[singular_values[:, -1] > NEAR_SINGULAR * singular_values[:, 0]]  # not at change points
    jacobians /= np.maximum(np.max(np.abs(jacobians), axis=(0, 1)), 1e-300)
    count = jacobians.shape[1]
    choices = {tuple(sorted(qr(angle_jacobian, mode="r", pivoting=True)[1][:count])) for angle_jacobian in jacobians}
    if len(candidates) <= 8:
        choices |= set(itertools.combinations(range(len(candidates)), count))

    def smallest_singular_value(choice: tuple) -> float:
        return float(np.min(np.linalg.svd(jacobians[:, :, list(choice)], compute_uv=False)[:, -1]))

    return sorted(candidates[i] for i in max(sorted(choices), key=smallest_singular_value))
