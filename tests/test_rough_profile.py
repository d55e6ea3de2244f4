"""Dimension and scale of surfaces from measured profiles."""

import math

import numpy as np
import pytest
from rough_profile import profile

from clearsweep.mechanics.laws.roughness import fit_profile


@pytest.mark.parametrize("dimension", [1.3, 1.5, 1.7])
def test_a_profile_of_known_dimension_is_recognised(dimension):
    x, heights = profile(dimension)
    result = fit_profile(tuple(x), tuple(heights))
    assert result.dimension == pytest.approx(dimension, abs=0.03, rel=0.0)
    assert result.dimension_low < dimension < result.dimension_high
    assert result.dimension_high - result.dimension_low < 0.2
    assert math.log10(result.scale) == pytest.approx(-10.0, abs=0.5, rel=0.0)
    assert result.scale_low < result.scale < result.scale_high
    assert result.residual < 0.05


def test_tilt_and_height_of_a_profile_do_not_matter():
    x, heights = profile(1.5, rows=2000)
    tilted = fit_profile(tuple(x), tuple(heights + 0.3 * x + 1.0))
    assert tilted.dimension == pytest.approx(fit_profile(tuple(x), tuple(heights)).dimension, rel=1e-6)


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (lambda x, z: (x[:500], z[:500]), "has 500 rows; at least 1000"),
        (lambda x, z: (x**1.1, z), "expected even steps"),
        (lambda x, z: (x, 0.0 * z), "is flat"),
        (lambda x, z: (x, np.sin(2e3 * x)), "grow with the distance to the power"),
    ],
)
def test_what_is_no_profile_of_a_fractal_is_reported(spoil, message):
    x, heights = spoil(*profile(1.5, rows=1200))
    with pytest.raises(ValueError, match=message):
        fit_profile(tuple(x), tuple(heights))
