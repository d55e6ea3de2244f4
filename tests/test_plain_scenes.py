"""Plain Python gives the figures of compiled code, in short scenes of machines, joints, drives and loads of most kinds.

`python tests/test_plain_scenes.py` prints the figures of all scenes as JSON.
"""

import json
import math
import os
import subprocess
import sys

import numpy as np
import pytest
import test_drives
import test_mounts
import test_own_laws
import test_play
import test_slot
import test_vibration
import test_wear_in_space
from fake_runs import CONFIGS
from mechanism_cases import changed, slider_crank
from right_grids import grid_of
from spatial_cases import spatial

import clearsweep
from clearsweep import grid, simulation
from clearsweep.contracts.results import TIMINGS
from clearsweep.simulation.setup import scene

pytestmark = pytest.mark.plain

SHORT = {"simulate.revolutions": 0.02, "simulate.discard": 0.0}
SHORT |= {"save.orbits": "all", "save.samples": 150, "save.revolutions": None}
SHORTER = {"simulate.revolutions": 0.004, "save.samples": 750}
IN_TIME = {"simulate.revolutions": None, "simulate.time": 0.002, "save.orbits": "none"}

ZERO = 1e-12  # what is zero but for rounding is below it, except wear, which is smaller
WORN = "_wear_"
#: Figures that rounding moves: what is left of energies, and numbers of steps that hardly are within the tolerance.
ROUNDED = "energy_residual", "steps", "steps_rejected", "rhs_evaluations"

# ---------------------------------------------------------------------------------------------- parts of grids

TANH = {"law": "tanh", "coefficient": 0.1, "velocity_scale": 1e-2}
DAHL = {"law": "dahl", "coefficient": 0.1, "bristle_stiffness": 1e5}
STICKS = {"law": "karnopp", "coefficient": 0.1, "static_coefficient": 0.15, "stribeck_velocity": 2e-3, "band": 2e-4}
BLOCK = {"clearance": 2e-5, "length": 0.04, "height": 0.03}
BLOCK |= {"contact": {"law": "exact", "stiffness": 3e9, "restitution": 0.5}}
OIL = {"law": "my-short", "viscosity": 0.05}
ELASTIC = {"axial_stiffness": 1e7, "segments": 2}
MOUNTS = {"ground-crank": test_mounts.HOUSING}
SPRING = {"between": ["ground", "rod"], "anchor": [0.2, 0.1], "stiffness": 1e3, "free_length": 0.1, "damping": 5.0}
TARGET = {"time [s]": [0.0, 0.1], "angle [rad]": [0.0, 2.0]}
SERVO = {"target": TARGET, "stiffness": 100.0, "damping": 4.0}
MOTOR = {"table": {"speed [rad/s]": [0.0, 100.0, 200.0], "torque [N*m]": [5.0, 4.0, 0.0]}}
ANGLES = {"table": {"time [s]": [0.0, 0.1, 0.2], "angle [rad]": [0.0, 10.0, 18.0]}}
SPEEDS = {"table": {"time [s]": [0.0, 0.001, 0.2], "speed [rpm]": [1000.0, 1200.0, 1300.0]}}
LINE = {"law": "line", "stall": 5.0, "no_load": 100.0}
PUSH = {"on": "slider", "law": "mine", "f": 50.0, "k": 100.0}
OWN = {
    "contact": {"law": "my-flores", "e": 0.7, "stiffness": 1e9},
    "friction": test_own_laws.MY_LUGRE,
    "wear": {"law": "my-archard", "k": 2e-15},
}
PARALLELOGRAM = grid_of("a parallelogram")


def driven(drive, **loads):
    """Return a slider-crank with clearance at the slider's pin, this drive and these loads."""
    return test_drives.MACHINE | {"drive": drive, "loads": loads}


def guided(friction):
    """Return a slider-crank whose slider is a block between two walls."""
    return slider_crank(
        changes={"joints.slider-ground": BLOCK | {"friction": friction}, "mechanism.slider.inertia": 1e-4}
    )


def rubbing(friction):
    """Return a slider-crank with clearance at the slider's pin and friction in a pin and a guide without."""
    pin, rail = {"on": "crank-rod", "friction": friction | {"radius": 0.01}}, {"on": "slider-ground"}
    return slider_crank("rod-slider", changes={"loads": {"pin": pin, "rail": rail | {"friction": friction}}})


def vibrating():
    """Return a slider-crank on a housing that yields, without clearance, whose vibration is observed."""
    rid = {"joints": None, "vibration.at.frame.mass": None, "vibration.at.frame.mount": None}
    return changed(test_vibration.GRID, rid | {"mechanism.mounts": MOUNTS})


# ---------------------------------------------------------------------------------------------- scenes

FILES = ["compressor", "v_twin", "start_up", "pump", "gear_rattle", "bending_rod", "lubricated", "two_joints", "engine"]
#: Sources of grids, of which the first case is taken, and what replaces SHORT, by name.
SCENES = {
    **{name: (CONFIGS / f"{name}.yaml", {}) for name in FILES},
    **{name: (CONFIGS / f"{name}.yaml", SHORTER) for name in ("press", "wiper", "rolling", "spatial_four_bar")},
    "slot": (test_slot.GRID, {}),
    "worn slot": (test_slot.worn_grid(evolve=True), {}),
    "guide": (guided(TANH), {}),
    "guide with bristles": (guided(DAHL), {}),
    "guide that sticks": (guided(STICKS), {"simulate.revolutions": 0.1}),
    "coupling": (test_play.coupling(), {}),
    "gear": (test_play.gear(), {}),
    "stops": (test_play.flap(), {}),
    "gear that wears": (test_play.wearing_gear(-3.0, 0.06) | {"drive": {"speed": SPEEDS}}, {}),
    "wear in space": (spatial(wear=test_wear_in_space.WEAR, offset=[1.5e-4, 0.0, 0.0], tilt=[0.003, 0.002]), {}),
    "mounts": (slider_crank("rod-slider", changes={"mechanism.mounts": MOUNTS}), {}),
    "vibration": (vibrating(), {"simulate.revolutions": 3.0, "simulate.tolerance": 1e-3, "save.samples": 5}),
    "elastic rod": (slider_crank("rod-slider", changes={"mechanism.rod.elastic": ELASTIC}), {}),
    "friction without clearance": (rubbing(TANH), {}),
    "bristles without clearance": (rubbing(DAHL), {}),
    "sticking without clearance": (rubbing(STICKS), {}),
    "parallelogram": (PARALLELOGRAM, {}),
    "folded parallelogram": (PARALLELOGRAM, {"drive.start_angle": 0.0}),
    "servo": (driven({"servo": SERVO}), IN_TIME),
    "limited servo": (driven({"servo": SERVO | {"torque_limit": 1.0}}), IN_TIME),
    "regulated servo": (driven({"servo": SERVO | {"torque_limit": 1.0, "integral": 1000.0}}), IN_TIME),
    "motor": (driven({"motor": MOTOR, "initial_speed": 50.0}, spring=SPRING), {}),
    "angles": (driven({"angle": ANGLES}), {}),
    "speeds": (driven({"speed": SPEEDS}), SHORTER),
    "torque": (driven({"torque": 1.0, "initial_speed": 20.0}), {}),
    "own laws": (test_own_laws.with_joint(test_own_laws.CRANK, **OWN), {}),
    "own film": (test_own_laws.with_joint(test_own_laws.CRANK, length=0.008, film=OIL), {}),
    "own motor": (driven({"motor": LINE, "initial_speed": 50.0}, push=PUSH), {}),
}
#: Catalogues with laws of one's own; other scenes have that of the package.
CATALOGUES = dict.fromkeys(("own laws", "own film"), test_own_laws.copies) | {"own motor": test_own_laws.drivers}


def figures_of(name):
    """Return the figures of a scene that are finite numbers, and the largest magnitude of each history, by name."""
    source, changes = SCENES[name]
    catalogue = CATALOGUES.get(name, simulation.catalogue)()
    run = clearsweep.simulate(scene.build(grid.load(source, catalogue, SHORT | changes).case(0)))
    assert run.status == "ok", run.message
    largest = {key: float(np.abs(values).max()) for key, values in run.channels.items() if len(values)}
    figures = {key: x for key, x in run.summary.items() if isinstance(x, int | float) and key not in TIMINGS}
    return {key: x for key, x in (figures | largest).items() if math.isfinite(x)}


@pytest.fixture(scope="module")
def compiled():
    """Return the figures of all scenes by compiled code, by name."""
    unmeasured = {key: x for key, x in os.environ.items() if not key.startswith("COVERAGE_")}
    done = subprocess.run(
        [sys.executable, __file__],
        capture_output=True,
        text=True,
        check=False,
        env=unmeasured | {"CLEARSWEEP_DISABLE_JIT": "0"},
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@pytest.mark.timeout(1800)
@pytest.mark.parametrize("name", SCENES)
def test_plain_python_gives_the_figures_of_compiled_code(compiled, name):
    """To the rounding that steps and contacts enlarge: compiled code fuses products and sums."""
    plain, expected = figures_of(name), compiled[name]
    assert plain.keys() == expected.keys()
    assert plain["steps"] == pytest.approx(expected["steps"], rel=0.1)
    apart = {
        key: (x, expected[key])
        for key, x in plain.items()
        if key not in ROUNDED and not math.isclose(x, expected[key], rel_tol=1e-6, abs_tol=0.0 if WORN in key else ZERO)
    }
    assert apart == {}


if __name__ == "__main__":
    json.dump({name: figures_of(name) for name in SCENES}, sys.stdout)
