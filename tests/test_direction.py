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
    result = np.array([function(float(angle)) for angle in angles])
    np.testing.assert_allclose(result, np.column_stack([np.cos(angles), np.sin(angles)]), rtol=0, atol=3e-16)


def test_beyond_the_reach_of_the_table_the_library_is_asked():
    for angle in (LARGEST, -3e9, 1e300):
        assert direction(angle) == (math.cos(angle), math.sin(angle))
    assert all(math.isnan(part) for part in direction(math.nan))


def test_compiled_code_has_functions_of_its_own_there():
    """Up to 2^40 rad, where their reduction of an angle runs out of digits."""
    for angle in (LARGEST, -3e9, 1e12):
        assert compiled(angle) == pytest.approx((math.cos(angle), math.sin(angle)), rel=0.0, abs=3e-16)
    assert all(math.isnan(part) for angle in (1e13, math.nan) for part in compiled(angle))
