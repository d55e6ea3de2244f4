"""A bearing housing that shifts on springs but does not turn, by two guides and a carriage without mass."""

import math
import re
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq

import clearsweep

STIFFNESS, MASS, CLEARANCE, CONTACT = 2e5, 0.5, 50e-6, 1e10  # N/m, kg, m, N/m^1.5


def housing(shift, *, damping=0.0, force=0.0):
    """Return the grid of a journal at rest in a housing whose springs pull it to `shift` (m) along y."""
    still = [0.0, 0.0]
    springs = {
        name: {
            "between": ["ground", "housing"],
            "anchor": [x, y + shift],
            "point": "middle",
            "stiffness": STIFFNESS,
            "free_length": 1.0,
            "damping": damping,
        }
        for name, x, y in (("along", -1.0, 0.0), ("across", 0.0, -1.0))
    }
    return {
        "mechanism": {
            "type": "planar",
            "gravity": 0.0,
            "bodies": {
                "ground": {"points": {"main": still}},
                "shaft": {"mass": 0.3, "inertia": 1e-4, "points": {"middle": still}},
                "carriage": {"mass": 0.0, "inertia": 0.0, "points": {"middle": still}},
                "housing": {"mass": MASS, "inertia": 1e-3, "points": {"middle": still}},
            },
            "joints": {
                "main": {"type": "revolute", "between": ["ground.main", "shaft.middle"]},
                "along": {"type": "prismatic", "between": ["ground.main", "carriage.middle"]},
                "across": {"type": "prismatic", "between": ["carriage.middle", "housing.middle"], "axis": "90 deg"},
                "bearing": {"type": "revolute", "between": ["housing.middle", "shaft.middle"]},
            },
            "driven": "main",
            "output": {"body": "shaft"},
        },
        "drive": {"speed": "600 rpm"},
        "loads": springs | ({"push": {"on": "housing", "force": [0.0, force]}} if force else {}),
        "joints": {
            "bearing": {
                "clearance": CLEARANCE,
                "bearing_radius": 10e-3,
                "contact": {"law": "hertz", "stiffness": CONTACT},
            }
        },
        "simulate": {"revolutions": 1.0, "discard": 0, "tolerance": 1e-10},
        "save": {"orbits": "all"},
    }


def test_a_housing_on_springs_sways_at_the_frequency_of_its_mass():
    times = np.linspace(0.0, 0.02, 41)
    path = clearsweep.simulate(clearsweep.load_case(housing(20e-6)), times=times)
    exact = 20e-6 * (1.0 - np.cos(math.sqrt(STIFFNESS / MASS) * times))
    np.testing.assert_allclose(path["housing/y"], exact, atol=1e-9)
    np.testing.assert_allclose(path["housing/angle"], 0.0, atol=1e-15)
    assert len(path.events) == 0


def test_a_housing_shifted_beyond_the_clearance_rests_on_the_journal():
    shift = 120e-6
    path = clearsweep.simulate(clearsweep.load_case(housing(shift, damping=400.0)))
    place = brentq(lambda y: STIFFNESS * (shift - y) - CONTACT * (y - CLEARANCE) ** 1.5, CLEARANCE, shift)
    assert path.status == "ok"
    assert path["housing/y"][-1] == pytest.approx(place, rel=1e-5)
    assert path["joints/bearing/force_normal"][-1] == pytest.approx(STIFFNESS * (shift - place), rel=1e-4)
    assert path.summary["energy_residual"] < 1e-6


def test_a_load_shifts_its_housing_by_the_force_over_the_stiffness():
    path = clearsweep.simulate(clearsweep.load_case(housing(0.0, damping=400.0, force=5.0)))
    assert path["housing/y"][-1] == pytest.approx(5.0 / STIFFNESS, rel=1e-5)


def test_the_how_to_shows_a_housing_that_rests_on_the_journal(tmp_path):
    text = (Path(__file__).parents[1] / "docs/howto/mechanisms.md").read_text(encoding="utf-8")
    (grid,) = re.findall(r"```yaml\n(name: shifting-housing\n.*?)```", text, re.DOTALL)
    (tmp_path / "grid.yaml").write_text(grid, encoding="utf-8")
    for shift in (20e-6, 80e-6, 120e-6):
        case = clearsweep.load_case(tmp_path / "grid.yaml", overrides={"define.shift": f"{shift * 1e6} um"})
        force = clearsweep.simulate(case).summary["bearing_force_peak"]
        place = brentq(lambda y, s=shift: STIFFNESS * (s - y) - CONTACT * max(y - CLEARANCE, 0.0) ** 1.5, 0.0, shift)
        assert force == pytest.approx(CONTACT * max(place - CLEARANCE, 0.0) ** 1.5, rel=1e-3, abs=1e-9)
