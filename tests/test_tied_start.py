"""A loop that closes in two ways where nothing decides: a note names both assemblies; none where `start` decides."""

import copy
import math
import re

import pytest

import clearsweep
from clearsweep.simulation import warnings

GROUND, CRANK, COUPLER, ROCKER = 0.13, 0.05, 0.12, 0.1  # m
FOUR_BAR = {
    "mechanism": {
        "type": "planar",
        "bodies": {
            "ground": {"points": {"o": [0.0, 0.0], "p": [GROUND, 0.0]}},
            "crank": {"mass": 0.3, "inertia": 1e-4, "points": {"o": [0.0, 0.0], "a": [CRANK, 0.0]}},
            "coupler": {"mass": 0.21, "inertia": 2.5e-4, "points": {"a": [0.0, 0.0], "b": [COUPLER, 0.0]}},
            "rocker": {"mass": 0.25, "inertia": 2.2e-4, "points": {"p": [0.0, 0.0], "b": [ROCKER, 0.0]}},
        },
        "joints": {
            "main": {"type": "revolute", "between": ["ground.o", "crank.o"]},
            "a": {"type": "revolute", "between": ["crank.a", "coupler.a"]},
            "b": {"type": "revolute", "between": ["coupler.b", "rocker.b"]},
            "p": {"type": "revolute", "between": ["ground.p", "rocker.p"]},
        },
        "driven": "main",
        "output": {"body": "rocker"},
    },
    "drive": {"speed": 30.0},
    "joints": {
        "b": {
            "clearance": 1e-4,
            "bearing_radius": 0.01,
            "contact": {"law": "flores", "stiffness": 5e9, "exponent": 1.5, "restitution": 0.6},
        }
    },
    "simulate": {"revolutions": 3, "discard": 1},
}


def notes(start):
    """Return the notes on the start of a four-bar with these angles."""
    source = copy.deepcopy(FOUR_BAR)
    source["mechanism"]["start"] = start
    return [note for note in warnings(clearsweep.load_case(source).case) if note.startswith("mechanism.start")]


def test_a_note_names_both_assemblies():
    (note,) = notes({})
    base = GROUND - CRANK  # the third side of the triangle with coupler and rocker at crank angle 0
    expected = math.degrees(math.acos((COUPLER**2 + base**2 - ROCKER**2) / (2.0 * COUPLER * base)))
    angles = sorted(float(angle) for angle in re.findall(r"coupler: (-?[\d.]+) deg", note))
    assert angles == pytest.approx([-expected, expected], rel=1e-3)


@pytest.mark.parametrize("start", [{"coupler": "50 deg"}, {"coupler": "-50 deg"}, {"rocker": "100 deg"}])
def test_no_note_where_start_decides(start):
    assert notes(start) == []
