"""A bearing whose housing shifts but does not turn, round a shaft that turns at constant speed: the rig of a film."""

from typing import Any

import numpy as np

from ...contracts.results import Trajectory
from ...simulation.scene import load_case
from ...simulation.trajectory import simulate


def grid(joint: dict[str, Any], speed: float, load: float, *, mass: float, revolutions: float) -> dict[str, Any]:
    """Return the grid of a rig: its joint, rad/s of the shaft, N down on the housing, kg of the housing."""
    still = [0.0, 0.0]
    return {
        "mechanism": {
            "type": "planar",
            "bodies": {
                "ground": {"points": {"main": still, "rail": still}},
                "shaft": {"mass": 1.0, "inertia": 1e-4, "points": {"pin": still}},
                "carriage": {"mass": 0.0, "inertia": 0.0, "points": {"pin": still}},
                "housing": {"mass": mass, "inertia": 0.0, "points": {"bore": still}},
            },
            "joints": {
                "main": {"type": "revolute", "between": ["ground.main", "shaft.pin"]},
                "across": {"type": "prismatic", "between": ["ground.rail", "carriage.pin"], "axis": 0.0},
                "along": {"type": "prismatic", "between": ["carriage.pin", "housing.bore"], "axis": "90 deg"},
                "film": {"type": "revolute", "between": ["shaft.pin", "housing.bore"], "journal": "shaft"},
            },
            "driven": "main",
            "output": {"body": "shaft"},
        },
        "drive": {"speed": speed},
        "loads": {"weight": {"on": "housing", "force": [0.0, -load]}},
        "joints": {"film": joint},
        "simulate": {"revolutions": revolutions, "discard": revolutions - 1.0},
        "save": {"orbits": "last"},
    }


def run(source: dict[str, Any]) -> Trajectory:
    """Return the run of a grid.  Raises RuntimeError where it fails."""
    trajectory = simulate(load_case(source))
    if trajectory.status != "ok":
        raise RuntimeError(f"a rig did not run: {trajectory.message}")
    return trajectory


def attitude(trajectory: Trajectory) -> float:
    """Return the angle (rad) from the load on the journal, which is upwards, to its eccentricity, where a run ends."""
    x, y = trajectory["joints/film/x"][-1], trajectory["joints/film/y"][-1]
    return float(np.arctan2(-x, y))


def eccentricity(trajectory: Trajectory) -> float:
    """Return the distance (m) of the journal from the middle of its bearing where a run ends."""
    return float(np.hypot(trajectory["joints/film/x"][-1], trajectory["joints/film/y"][-1]))


def torque(trajectory: Trajectory) -> float:
    """Return the torque (N m) on the shaft where a run ends."""
    return float(trajectory["drive/torque"][-1])
