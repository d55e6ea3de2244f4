"""A bearing whose housing translates without rotation, around a shaft at constant speed: a film test rig."""

from typing import Any

import numpy as np

from ...contracts.results import Trajectory
from ...simulation.analyses.trajectory import simulate
from ...simulation.setup.scene import load_case


def grid(joint: dict[str, Any], speed: float, load: float, *, mass: float, revolutions: float) -> dict[str, Any]:
    """Return the grid of a rig: joint, shaft speed (rad/s), downward load (N) and mass (kg) of the housing."""
    origin = [0.0, 0.0]
    return {
        "mechanism": {
            "type": "planar",
            "bodies": {
                "ground": {"points": {"main": origin, "rail": origin}},
                "shaft": {"mass": 1.0, "inertia": 1e-4, "points": {"pin": origin}},
                "carriage": {"mass": 0.0, "inertia": 0.0, "points": {"pin": origin}},
                "housing": {"mass": mass, "inertia": 0.0, "points": {"bore": origin}},
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
    """Return the run of a grid.  Raise RuntimeError if it fails."""
    trajectory = simulate(load_case(source))
    if trajectory.status != "ok":
        raise RuntimeError(f"a rig did not run: {trajectory.message}")
    return trajectory


def attitude(trajectory: Trajectory) -> float:
    """Return the angle (rad) from the upward load on the journal to its eccentricity, at the end of a run."""
    x, y = trajectory["joints/film/x"][-1], trajectory["joints/film/y"][-1]
    return float(np.arctan2(-x, y))


def eccentricity(trajectory: Trajectory) -> float:
    """Return the eccentricity (m) of the journal at the end of a run."""
    return float(np.hypot(trajectory["joints/film/x"][-1], trajectory["joints/film/y"][-1]))


def torque(trajectory: Trajectory) -> float:
    """Return the torque (N m) on the shaft at the end of a run."""
    return float(trajectory["drive/torque"][-1])
