"""Chooses the dependent coordinates of a planar machine, which its loops determine."""

import itertools

import numpy as np

from .drive import Steady
from .equations import function_of
from .form import Planar
from .machine_type import MachineType
from .spanning_tree import ANGLE, RUN, Coordinate

EXAMINED_ANGLES = 36  # crank angles that are examined


def choose_dependent(value: Planar, machine: MachineType, profiles: list) -> list[int]:
    """Return the indices of the coordinates that, taken as dependent, keep the loops furthest from singular.

    value : a machine without dependent coordinates; profiles : (values, slopes, ...) of each coordinate at
    equidistant angles over a revolution of the ideal machine.
    """
    from scipy.linalg import qr

    if not machine.free:
        value = value._replace(drive=Steady(1.0, value.turn.start))
    place, loops, snapshots = function_of(value, "place"), function_of(value, "loops"), []
    angles = range(0, len(profiles[0][0]) - 1, max((len(profiles[0][0]) - 1) // EXAMINED_ANGLES, 1))
    for k in angles:
        time = 2.0 * np.pi * k / (len(profiles[0][0]) - 1)
        y = np.array([*(profile[0][k] for profile in profiles), *(0.0 for _ in profiles), time])
        snapshots.append(np.array(loops(value, place(value, y))))
    jacobians = np.array(snapshots)
    fixed_coordinates = {Coordinate(ANGLE, machine.spanning_tree.crank), *(Coordinate(RUN, j) for j in machine.sprung)}
    candidates = [i for i, item in enumerate(machine.spanning_tree.coordinates) if item not in fixed_coordinates]
    scale = np.max(np.abs(jacobians), axis=(0, 2), keepdims=True)
    jacobians = (jacobians / scale)[:, :, candidates]
    jacobians /= np.maximum(np.max(np.abs(jacobians), axis=(0, 1)), 1e-300)
    count = jacobians.shape[1]
    choices = {tuple(sorted(qr(snapshot, mode="r", pivoting=True)[1][:count])) for snapshot in jacobians}
    if len(candidates) <= 8:
        choices |= set(itertools.combinations(range(len(candidates)), count))

    def smallest_singular_value(choice: tuple) -> float:
        return float(np.min(np.linalg.svd(jacobians[:, :, list(choice)], compute_uv=False)[:, -1]))

    return sorted(candidates[i] for i in max(sorted(choices), key=smallest_singular_value))
