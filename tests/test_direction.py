"""Cosine and sine by the project's own polynomials are as good as the library's, compiled or not."""

import math

import numpy as np
import pytest

from clearsweep.tracing.compiled.choosing import MAX_EXACT_ANGLE, direction
from clearsweep.tracing.objects import machine_code

compiled = machine_code(direction)


@pytest.mark.parametrize("function", [direction, compiled])
@pytest.mark.parametrize("largest", [1e-9, 0.1, 7.0, 1e3, MAX_EXACT_ANGLE])
def test_a_direction_is_exact_to_rounding(function, largest):
    angles = np.concatenate([np.linspace(-largest, largest, 2001), np.arange(-40, 41) * math.pi / 8 % largest])
    result = np.array([function(float(angle)) for angle in angles])
    np.testing.assert_allclose(result, np.column_stack([np.cos(angles), np.sin(angles)]), rtol=0, atol=2e-16)


@pytest.mark.parametrize("function", [direction, compiled])
def test_beyond_it_is_exact_to_the_rounding_of_the_angle(function):
    for angle in (1e7, -3e9, 1e12):
        rounding = np.spacing(abs(angle))
        assert function(angle) == pytest.approx((math.cos(angle), math.sin(angle)), rel=0.0, abs=2e-16 + rounding)
    assert all(math.isnan(part) for part in function(math.nan))
