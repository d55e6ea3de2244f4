"""Stations of a revolution at which an ideal machine is closed; quantities of its geometry alone are stored for them.

A position repeats with every revolution of the crank, so angles at stations of later revolutions need no new closure.
"""

import functools
import math
import pickle
from collections.abc import Callable
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
    """The states of a machine over a revolution."""

    def __init__(self, closure: Closure, start: float):
        self.states = closure.close_revolution(start)

    def states_at(self, angles: np.ndarray, close: Callable[[np.ndarray], MachineStates]) -> MachineStates:
        """Return the machine at crank angles (N,) rad; `close` computes those that are not stations."""
        station, revolutions, off_station = self._nearest_stations(angles)
        q = self.states.q[station] + revolutions[:, None] * growth_per_revolution(self.states)
        inverses = self.states.inverse
        assert inverses is not None  # of stations
        states = MachineStates(
            angles, q, self.states.derivative[station], self.states.second_derivative[station], inverses.chosen(station)
        )
        if not off_station.any():
            return states
        closed = close(angles[off_station])
        for values, computed in zip(states[1:4], closed[1:4], strict=True):
            values[off_station] = computed
        return states._replace(inverse=states.inverse.replaced(off_station, closed.inverse))

    def _nearest_stations(self, angles: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the stations (N,) nearest to angles (N,) rad, revolutions before them, and a mask of other angles."""
        start, step = self.states.angles[0], 2.0 * math.pi / STATIONS
        nearest_station = np.rint((angles - start) / step)
        off_station = np.abs(start + nearest_station * step - angles) > ROUNDINGS * np.spacing(np.max(np.abs(angles)))
        revolutions = np.floor(nearest_station / STATIONS)
        return (nearest_station - STATIONS * revolutions).astype(int), revolutions, off_station


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
