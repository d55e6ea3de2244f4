"""Error against run time on machines with known motion in quadruple precision: one of each kind.

`references/machines.json` describes the origin of the trajectories.  The error is the largest of all channels of the
bodies, over the channel's own largest value, up to the time where a comparison is meaningful.
"""

import copy
import json
import math
from collections.abc import Callable
from importlib import resources
from typing import Any

import numpy as np

from ..simulation.analyses.trajectory import simulate
from ..simulation.setup import scene

TOLERANCES = (1e-6, 1e-8, 1e-10, 1e-12)
ROUNDS = 3  # the least run time counts
REST_VALUE = 1e-9  # largest value below which a channel is at rest
TITLES = {
    "fb_c": "four-bar, clearance in coupler-rocker",
    "sc_load": "slider-crank pressed by 500 N",
    "sc_torque": "slider-crank, free crank under 2 N m",
    "v_twin": "V-twin, two loops, clearance in one",
    "sc_film": "slider-crank, rod-slider in a film of 0.4 Pa s",
    "sc_film_dry": "slider-crank, a film of 1 mPa s and dry contact",
}


def read_references() -> dict[str, Any]:
    """Return the references by name."""
    file = resources.files(__package__) / "references" / "machines.json"
    problems: dict[str, Any] = json.loads(file.read_text(encoding="utf-8"))["problems"]
    return problems


def measure(*, quick: bool = False, report_progress: Callable[[str], None] | None = None) -> dict[str, Any]:
    """Return `rows`, one for every machine and tolerance; none if `quick`, because each machine compiles a scene."""
    rows = []
    for name, entry in ({} if quick else read_references()).items():
        if report_progress:
            report_progress(f"machines: {name}")
        rows += [run_machine(name, entry, tolerance) for tolerance in TOLERANCES]
    return {"rows": rows}


def run_machine(name: str, entry: dict[str, Any], tolerance: float) -> dict[str, Any]:
    """Return the row of a machine at a tolerance."""
    source, times = copy.deepcopy(entry["grid"]), np.array(entry["samples"]["t"])
    source["simulate"]["tolerance"] = tolerance
    loaded_scene = scene.load_case(source)
    compared_times = times[times <= entry["fair"]]
    trajectory = simulate(loaded_scene, times=compared_times)
    run_time = min(simulate(loaded_scene, times=compared_times).summary["run_time"] for _ in range(ROUNDS))
    max_error = max(
        _relative_error(trajectory[channel], np.array(values)[: compared_times.size])
        for channel, values in entry["samples"].items()
        if "force" not in channel and "torque" not in channel
    )
    event_times, reference = trajectory.events["t"], np.array([row[0] for row in entry["events"]])
    has_same_count = len(event_times) == len(reference)
    return {
        "name": name,
        "tolerance": tolerance,
        "error": max_error,
        "events": len(event_times),
        "events_expected": len(reference),
        "event_error": event_error(event_times, reference) if has_same_count else None,  # s
        "rhs_evaluations": trajectory.summary["rhs_evaluations"],
        "energy_residual": trajectory.summary["energy_residual"],
        "ms": 1e3 * run_time,
    }


def event_error(times: np.ndarray, reference: np.ndarray) -> float:
    """Return the largest error (s) of corresponding events, 0 without events."""
    return float(np.max(np.abs(times - reference), initial=0.0))


def _relative_error(computed: np.ndarray, reference: np.ndarray) -> float:
    """Return the largest error over the largest value, 0 for a channel at rest."""
    largest = float(np.max(np.abs(reference)))
    return (
        float(np.max(np.abs(computed - reference))) / largest
        if largest > REST_VALUE and math.isfinite(largest)
        else 0.0
    )
