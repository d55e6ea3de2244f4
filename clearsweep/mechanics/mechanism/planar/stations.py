"""Stations of a revolution at which an ideal machine is closed; quantities of its geometry alone are stored for them.

A position repeats with every revolution of the crank, so angles at stations of later revolutions need no new closure.
"""

import functools
import math
import pickle
from typing import Any

import numpy as np

from ....contracts.machine import Machine, Stretch
from .closure import STATIONS, Closure
from .machine_states import MachineStates, growth_per_revolution

ROUNDINGS = 4.0  # roundings of an angle, by which it may differ from that of a station


class AlwaysEqual:
    """A value that equals any other, so a cache finds results by the other parts of a key."""

    def __init__(self, value: Any):
        self.value = value

    def __eq__(self, other_value: object) -> bool:
        return isinstance(other_value, AlwaysEqual)

    def __hash__(self) -> int:
        return 0


class Stations:
    """The states of a machine over a revolution, and the inverses of its constraints at the stations."""

    def __init__(self, closure: Closure, start: float):
        self.states = closure.close_revolution(start)
        self._closure = closure

    @functools.cached_property
    def inverse(self) -> np.ndarray:
        """Return matrices (STATIONS, rows, 3 bodies): forces on the bodies -> multipliers of the constraints."""
        return inverse_of(self._closure, self.states.q[:-1], self.states.angles[:-1])

    def nearest_stations(self, angles: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the stations (N,) nearest to angles (N,) rad, revolutions before them, and a mask of other angles."""
        start, step = self.states.angles[0], 2.0 * math.pi / STATIONS
        nearest_station = np.rint((angles - start) / step)
        off_station = np.abs(start + nearest_station * step - angles) > ROUNDINGS * np.spacing(np.max(np.abs(angles)))
        revolutions = np.floor(nearest_station / STATIONS)
        return (nearest_station - STATIONS * revolutions).astype(int), revolutions, off_station

    def states_at(self, angles: np.ndarray, close: Any) -> MachineStates:
        """Return the machine at crank angles (N,) rad.

        `close`, (n,) rad -> MachineStates, computes those that are not stations.
        """
        station, revolutions, off_station = self.nearest_stations(angles)
        q = self.states.q[station] + revolutions[:, None] * growth_per_revolution(self.states)
        states = MachineStates(angles, q, self.states.derivative[station], self.states.second_derivative[station])
        if off_station.any():
            for values, computed in zip(states[1:], close(angles[off_station])[1:], strict=True):
                values[off_station] = computed
        return states

    def inverse_at(self, closure: Closure, states: MachineStates) -> np.ndarray:
        """Return the inverses (N, rows, 3 bodies) at the angles of `states`."""
        station, _, off_station = self.nearest_stations(states.angles)
        inverse = self.inverse[station]
        if off_station.any():
            inverse[off_station] = inverse_of(closure, states.q[off_station], states.angles[off_station])
        return inverse


def inverse_of(closure: Closure, q: np.ndarray, angles: np.ndarray) -> np.ndarray:
    """Return the inverses (N, rows, 3 bodies) of the transposed derivatives of the constraints."""
    return np.linalg.inv(closure.evaluate(q, angles)[1].transpose(0, 2, 1))


def stations_of(machine: Machine) -> Stations:
    """Return the Stations of a machine; cases that differ in masses and loads share them."""
    return _shared_stations(geometry_of(machine), AlwaysEqual(machine))


def geometry_of(machine: Machine) -> bytes:
    """Return the key of everything that determines the positions of a machine, without masses, loads and speeds."""
    bodies = {name: (tuple(body.center), dict(body.points), body.initial) for name, body in machine.bodies.items()}
    joints = [
        joint._replace(stiffness=0.0, damping=0.0) if isinstance(joint, Stretch) else joint for joint in machine.joints
    ]
    return pickle.dumps((bodies, joints, machine.driven, dict(machine.start), machine.drive.start_angle))


@functools.lru_cache(maxsize=64)
def _shared_stations(key: bytes, machine: AlwaysEqual) -> Stations:
    return Stations(Closure(machine.value), machine.value.drive.start_angle)
