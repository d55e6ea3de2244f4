"""Cosine and sine from the table are as good as the library's, compiled or not."""

import math

import numpy as np
import pytest

from clearsweep.mechanics.compiled.direction import LARGEST, direction
from clearsweep.mechanics.trace.objects import machine_code

compiled = machine_code(direction)


@pytest.mark.parametrize("function", [direction, compiled])
@pytest.mark.parametrize("largest", [1e-9, 0.1, 7.0, 1e3, 1e5])
def test_a_direction_is_exact_to_rounding(function, largest):
    angles = np.concatenate([np.linspace(-largest, largest, 2001), np.arange(-40, 41) * math.pi / 8 % largest])
    found = np.array([function(float(angle)) for angle in angles])
    np.testing.assert_allclose(found, np.column_stack([np.cos(angles), np.sin(angles)]), rtol=0, atol=3e-16)


@pytest.mark.parametrize("function", [direction, compiled])
def test_beyond_the_reach_of_the_table_the_library_is_asked(function):
    for angle in (LARGEST, -3e9, 1e300):
        assert function(angle) == (math.cos(angle), math.sin(angle))
    assert all(math.isnan(part) for part in function(math.nan))
