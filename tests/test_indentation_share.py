"""The error of a position is clearance and indentation: the answer splits it where the contact is soft."""

import json

import pytest

import clearsweep

MASS, CRANK, SPEED, CLEARANCE = 1.2, 0.04, 31.4159, 2e-5  # kg, m, rad/s, m
YOKE = {
    "name": "yoke",
    "mechanism": {
        "type": "planar",
        "bodies": {
            "ground": {"points": {"o": [0.0, 0.0]}},
            "crank": {"mass": 0.5, "inertia": 1e-3, "points": {"o": [0.0, 0.0], "pin": [CRANK, 0.0]}},
            "yoke": {"mass": MASS, "inertia": 1e-2, "points": {"mid": [0.0, 0.0]}},
        },
        "joints": {
            "main": {"type": "revolute", "between": ["ground.o", "crank.o"]},
            "rail": {"type": "prismatic", "between": ["ground.o", "yoke.mid"]},
            "slot": {"type": "slot", "between": ["yoke.mid", "crank.pin"], "axis": "90 deg"},
        },
        "driven": "main",
        "output": {"body": "yoke", "point": "mid"},
    },
    "drive": {"speed": SPEED},
    "joints": {"slot": {"clearance": CLEARANCE, "bearing_radius": 8e-3, "slot_length": 0.1}},
    "simulate": {"revolutions": 6, "discard": 3},
}


@pytest.mark.parametrize("stiffness", [1e7, 1e11])
def test_the_answer_splits_an_error_into_clearance_and_indentation(stiffness, tmp_path):
    contact = {"law": "flores", "stiffness": stiffness, "exponent": 1.5, "restitution": 0.5}
    grid = YOKE | {"joints": {"slot": YOKE["joints"]["slot"] | {"contact": contact}}}
    clearsweep.sweep(grid, out=tmp_path / "run", executor="serial")
    answer = json.loads((tmp_path / "run" / "answer.json").read_text())
    largest = next(entry["largest"] for entry in answer["extremes"] if entry["figure"] == "output_error_max")
    static = (MASS * CRANK * SPEED**2 / stiffness) ** (2.0 / 3.0)  # m, Hertz under the force at the dead centres
    if static < 0.1 * CLEARANCE:
        assert "indentation" not in largest
        return
    assert largest["indentation"] == pytest.approx(static, rel=0.03)
    assert largest["value"] - largest["indentation"] == pytest.approx(CLEARANCE, rel=0.03)


@pytest.mark.parametrize(("limit", "is_hopeless"), [(0.2e-3, True), (0.29e-3, False)])
def test_it_says_where_no_clearance_can_meet(limit, is_hopeless, tmp_path):
    contact = {"law": "flores", "stiffness": 1e7, "exponent": 1.5, "restitution": 0.5}
    grid = YOKE | {"joints": {"slot": YOKE["joints"]["slot"] | {"contact": contact}}}
    clearsweep.sweep(grid | {"limits": {"output_error_max": limit}}, out=tmp_path / "run", executor="serial")
    text = (tmp_path / "run" / "answer.json").read_text()
    assert "is indentation at the stiffness given" in text
    assert ("No clearance can meet" in text) == is_hopeless
