"""Resolved cases used by many tests."""

import copy
import os
import subprocess
import sys

import numpy as np
from right_grids import grid_of

import clearsweep
from clearsweep import grid, simulation
from clearsweep.contracts.results import TIMINGS

SLIDER_CRANK = grid_of("a slider-crank")
JOINT = SLIDER_CRANK["joints"].pop("rod-slider")
PAIR = grid_of("an impact pair")


def slider_crank(*joints, changes=None):
    """Return a grid dict with clearance at `joints`; `changes` maps dotted paths to values."""
    case = copy.deepcopy(SLIDER_CRANK)
    for name in joints:
        case["joints"][name] = copy.deepcopy(JOINT)
    return changed(case, changes)


def changed(case, changes=None, /, **named):
    """Return the grid dict with values at paths replaced; None removes a key.

    A path has dots, or slashes if its keys have dots; as the name of an argument it has `__` for dots.
    """
    case = copy.deepcopy(case)
    for path, value in ((changes or {}) | {name.replace("__", "."): value for name, value in named.items()}).items():
        *parents, last = path.split("/" if "/" in path else ".")
        section = case
        for key in parents:
            section = section.setdefault(key, {})
        section[last] = value
        if value is None:
            del section[last]
    return case


def resolved(source):
    """Return the resolved case of a grid dict without sweep, in the shape of a grid file."""
    return grid.load(source, simulation.catalogue()).written_case(0)


def untimed(result):
    """Return the figures of a trajectory, but for the time that they took."""
    return {name: value for name, value in result.summary.items() if name not in TIMINGS}


def told_both_ways(program: str) -> list[list[float]]:
    """Return the numbers that a program prints after "ok", with compiled code and with the compiler off.

    It may use the modules of the tests.
    """
    message, program = [], f"import sys\nsys.path.insert(0, 'tests')\nimport clearsweep\n{program}"
    for off in ("0", "1"):
        done = subprocess.run(
            [sys.executable, "-c", program],
            capture_output=True,
            text=True,
            check=False,
            env={**os.environ, "CLEARSWEEP_DISABLE_JIT": off},
        )
        assert done.returncode == 0, done.stderr
        status, *numbers = done.stdout.split()
        assert status == "ok"
        message.append([float(number) for number in numbers])
    return message


def check_that_no_contact_passes_unseen(
    joints, tolerance, speed, clearance, restitution, gravity, revolutions=1.0, samples=20001
):
    """Check that no journal is beyond its clearance outside of the contacts in the event log; `speed` in rpm."""
    changes = {
        "simulate.tolerance": tolerance,
        "simulate.revolutions": revolutions,
        "drive.speed": f"{speed} rpm",
        "mechanism.gravity": gravity,
    }
    for name in joints:
        changes[f"joints.{name}.clearance"] = clearance
        changes[f"joints.{name}.contact"] = {"law": "exact", "stiffness": 6.61e10, "restitution": restitution}
    times = np.linspace(0.0, revolutions * 60.0 / speed, samples)
    trajectory = clearsweep.simulate(clearsweep.load_case(slider_crank(*joints, changes=changes)), times=times)
    assert trajectory.status == "ok"
    for name in joints:
        joint = name.replace("-", "_")
        events = trajectory.events[trajectory.events["joint"] == joint]
        in_contact = np.searchsorted(events["t"], times, side="right") % 2 == 1
        eccentricity = np.hypot(trajectory[f"joints/{joint}/x"], trajectory[f"joints/{joint}/y"])
        allowed = clearance * (1.0 + 100.0 * tolerance) + 1e-14
        assert np.all(eccentricity[~in_contact] <= allowed)
        assert list(events["kind"]) == ["on", "off"] * (len(events) // 2) + ["on"] * (len(events) % 2)
