"""A loop that closes in two ways where nothing decides: a note names both assemblies; none where `start` decides."""

import copy
import math
import re

import pytest
from right_grids import grid_of

import clearsweep
from clearsweep.simulation import warnings

GROUND, CRANK, COUPLER, ROCKER = 0.13, 0.05, 0.12, 0.1  # m
FOUR_BAR = grid_of("a four-bar that may start in two ways")


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
