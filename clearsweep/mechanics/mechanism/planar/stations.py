"""Stations of a revolution at which an ideal machine is closed; quantities of its geometry alone are stored for them.

A position repeats with every turn of the crank, so angles at stations of later turns need no new closure.
"""

import functools
import math
import pickle
from typing import Any

import numpy as np

from ....contracts.machine import Machine, Stretch
from .closure import STATIONS, Closure
from .turn import Turn, winding_of

ROUNDINGS = 4.0  # roundings of an angle, by which it may differ from that of a station


class Alike:
    """A value that equals any other, so a cache finds results by the other parts of a key."""

    def __init__(self, value: Any):
        self.value = value

    def __eq__(self, other_item: object) -> bool:
        return isinstance(other_item, Alike)

    def __hash__(self) -> int:
        return 0


class Stations:
    """A turn of a machine, and the inverse of its constraints at the stations."""

    def __init__(self, closure: Closure, start: float):
        self.turn = closure.turn(start)
        self._closure = closure

    @functools.cached_property
    def inverse(self) -> np.ndarray:
        """Return matrices (STATIONS, rows, 3 bodies): forces on the bodies -> multipliers of the constraints."""
        return inverse_of(self._closure, self.turn.q[:-1], self.turn.angles[:-1])

    def find(self, angles: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the station (N,) nearest to angles (N,) rad, the turns before it, and a mask of other angles."""
        start, step = self.turn.angles[0], 2.0 * math.pi / STATIONS
        nearest_station = np.rint((angles - start) / step)
        off_station = np.abs(start + nearest_station * step - angles) > ROUNDINGS * np.spacing(np.max(np.abs(angles)))
        total = np.floor(nearest_station / STATIONS)
        return (nearest_station - STATIONS * total).astype(int), total, off_station

    def at(self, angles: np.ndarray, closed: Any) -> Turn:
        """Return the machine at crank angles (N,) rad.

        `closed`, (n,) rad -> Turn, computes those that are no stations.
        """
        station, total, off_station = self.find(angles)
        q = self.turn.q[station] + total[:, None] * winding_of(self.turn)
        turn = Turn(angles, q, self.turn.first[station], self.turn.second[station])
        if off_station.any():
            for values, computed in zip(turn[1:], closed(angles[off_station])[1:], strict=True):
                values[off_station] = computed
        return turn

    def inverse_at(self, closure: Closure, turn: Turn) -> np.ndarray:
        """Return the inverses (N, rows, 3 bodies) at the angles of a Turn."""
        station, _, off_station = self.find(turn.angles)
        inverse = self.inverse[station]
        if off_station.any():
            inverse[off_station] = inverse_of(closure, turn.q[off_station], turn.angles[off_station])
        return inverse


def inverse_of(closure: Closure, q: np.ndarray, angles: np.ndarray) -> np.ndarray:
    """Return the inverses (N, rows, 3 bodies) of the transposed derivatives of the constraints."""
    return np.linalg.inv(closure.evaluate(q, angles)[1].transpose(0, 2, 1))


def stations_of(machine: Machine) -> Stations:
    """Return the Stations of a machine; cases that differ in masses and loads share them."""
    return _shared_stations(geometry_of(machine), Alike(machine))


def geometry_of(machine: Machine) -> bytes:
    """Return the key of everything that determines the positions of a machine, without masses, loads and speeds."""
    bodies = {name: (tuple(body.center), dict(body.points), body.initial) for name, body in machine.bodies.items()}
    joints = [
        joint._replace(stiffness=0.0, damping=0.0) if isinstance(joint, Stretch) else joint for joint in machine.joints
    ]
    return pickle.dumps((bodies, joints, machine.driven, dict(machine.start), machine.drive.start_angle))


@functools.lru_cache(maxsize=64)
def _shared_stations(key: bytes, machine: Alike) -> Stations:
    return Stations(Closure(machine.value), machine.value.drive.start_angle)
