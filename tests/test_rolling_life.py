"""Rating life of rolling bearings by ISO/TS 16281, with the numbers of a second program, and passing frequencies."""

import numpy as np
import pytest

from clearsweep.answers.validity import skidding_remark
from clearsweep.contracts.case import Capacity, Rolling
from clearsweep.mechanics.laws.bearings import equivalent_loads, load_powers, passing_rates, rating_life, rating_loads

BALL = Rolling("ball", 7, 11.5e-3, 43.5e-3, (0.52, 0.53), capacity=Capacity(23.4e3, 11.6e3))
ROLLER = Rolling("roller", 6, 9e-3, 43.5e-3, capacity=Capacity(31.5e3))
#: Loads (N) of the elements under 1000 N over one of them and without clearance, rating loads and equivalent loads of
#: inner and outer ring (N), and life (1e6 revolutions), by a second program.
SECOND_PROGRAM = {
    "ball": (
        BALL,
        (619.61395716, 305.04592192, 0.0, 0.0, 0.0, 0.0, 305.04592192),
        (8423.2445117, 18288.744788),
        (347.86021103, 363.98637974),
        13162.771709,
    ),
    "roller": (
        ROLLER,
        (683.55626835, 316.44373165, 0.0, 0.0, 0.0, 316.44373165),
        (17081.176747, 29794.958974),
        (446.45535668, 465.26742317),
        1971057.4727,
    ),
}


@pytest.mark.parametrize("name", SECOND_PROGRAM)
def test_life_is_that_of_a_second_program(name):
    bearing, loads, ratings, equivalents, life = SECOND_PROGRAM[name]
    means = [np.mean(np.array(loads) ** power) for power in load_powers(bearing)]
    assert rating_loads(bearing) == pytest.approx(ratings, rel=1e-9)
    assert equivalent_loads(bearing, *means) == pytest.approx(equivalents, rel=1e-8)
    assert rating_life(bearing, equivalent_loads(bearing, *means)) == pytest.approx(life, rel=1e-8)


def test_life_falls_with_the_third_power_of_a_load_on_balls_the_fourth_on_rollers():
    for bearing, power in ((BALL, 3.0), (ROLLER, 4.0)):
        lives = [
            rating_life(bearing, equivalent_loads(bearing, *(load**k for k in load_powers(bearing))))
            for load in (1e3, 2e3)
        ]
        assert lives[0] / lives[1] == pytest.approx(2.0**power, rel=1e-12)


def test_life_needs_a_rating():
    with pytest.raises(ValueError, match=r"capacity\.dynamic"):
        rating_loads(BALL._replace(capacity=Capacity()))


def test_elements_pass_as_those_of_a_planetary_gear():
    """The cage is the carrier of a gear with the raceways as wheels; its elements turn with the sum of both paths."""
    for bearing in (BALL, ROLLER):
        inner, outer = (bearing.pitch_diameter + sign * bearing.element_diameter for sign in (-1.0, 1.0))
        rates = passing_rates(bearing)
        cage = inner / (inner + outer)
        assert rates.cage == pytest.approx(cage, rel=1e-15)
        assert rates.outer == pytest.approx(bearing.elements * cage, rel=1e-15)
        assert rates.inner == pytest.approx(bearing.elements * (1.0 - cage), rel=1e-15)
        assert rates.element == pytest.approx(cage * outer / bearing.element_diameter, rel=1e-14)
    assert [25.0 * rate for rate in passing_rates(BALL)] == pytest.approx(
        (9.1954022989, 43.978010995, 110.63218391, 64.367816092), rel=1e-10
    )


def test_a_bearing_below_its_least_load_is_remarked():
    """SKF, requisite minimum load: 0.01 of the dynamic rating of ball bearings, 0.02 of roller bearings."""
    assert (BALL.least_load, ROLLER.least_load) == pytest.approx((234.0, 630.0), rel=1e-12)
    assert BALL._replace(capacity=Capacity()).least_load == 0.0
    remark = skidding_remark([("crank-rod", BALL.least_load, 0.25)])
    assert "crank-rod carries less than 234 N 25 % of the time" in remark
    assert skidding_remark([]) == ""
