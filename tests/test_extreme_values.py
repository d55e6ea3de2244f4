"""Values that no machine has are refused in a sentence with their place, before anything is computed with them."""

import math

import pytest

from clearsweep.contracts.catalogue import LARGEST, Field


@pytest.mark.parametrize("value", [0.0, 1.0 / LARGEST, LARGEST, 1.0])
def test_the_bounds_themselves_are_allowed(value):
    assert Field("x", "m", low_open=False).contains(value)
    assert not Field("x", "m", -math.inf).contains(-2.0 * LARGEST)
    assert "of a size from 1e-60 to 1e+60" in Field("x", "m").allowed(2.0 * LARGEST)
    assert "of a size" not in Field("x", "m").allowed(-1.0)
