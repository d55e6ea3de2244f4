"""Films against Butenschön's tables where they are hardest: squeezed, and at an eccentricity ratio of 0.99."""

import math

import numpy as np
import pytest
from film_oracle import solution
from test_reynolds_film import film_result, law_of

from clearsweep.mechanics.laws import reynolds

#: (length / diameter, eccentricity ratio, Sommerfeld number of pure squeeze), from the tables of Butenschön 1976.
SQUEEZED = [(1.0, 0.99, 6057.9), (0.5, 0.99, 5486.9), (0.25, 0.99, 4335.3), (0.25, -0.9, 0.0376), (0.25, -0.5, 0.0688)]


@pytest.mark.parametrize(("slenderness", "ratio", "number"), SQUEEZED)
def test_a_squeezed_film_has_the_number_of_the_table(slenderness, ratio, number):
    """A ratio below 0 is a journal that leaves: the film is squeezed on the other side."""
    force = film_result(law_of(slenderness), abs(ratio), math.copysign(1.0, ratio), 0.0)
    assert 6.0 * float(np.hypot(*force)) == pytest.approx(number, rel=8e-3)
    assert reynolds.squeeze_number(reynolds.make_butenschoen(1.0, slenderness), ratio) == pytest.approx(
        number, rel=0.025
    )


@pytest.mark.slow
def test_the_table_and_the_fit_lie_below_the_converged_force_at_the_last_ratio():
    """Two meshes of the second solver agree within 1e-4; So of the table is 107.787, 0.5 % below them."""
    coarse, fine = (3.0 * 0.99 * np.hypot(*solution(1.0, 0.99, 0.0, 1.0, (cells, 8))[:2]) for cells in (384, 768))
    assert coarse == pytest.approx(fine, rel=1e-4)
    assert 107.787 / fine == pytest.approx(0.995, abs=1e-3)
    fit, _, _ = reynolds.wedge_number(reynolds.make_butenschoen(1.0, 1.0), 0.99)
    assert fit / fine == pytest.approx(0.9765, abs=1e-3)
    assert 3.0 * np.hypot(*film_result(law_of(1.0), 0.99, 0.0, 0.99)) == pytest.approx(fine, rel=1e-3)
