"""Rainflow counting and damage, against the example of ASTM E1049 and closed forms."""

import itertools
import math

import numpy as np
import pytest
from test_bending import HEIGHT, LENGTH, SPEED, YOUNG, simeon

import clearsweep
from clearsweep.simulation.running.deformation import Rainflow, damage, turning_points

#: ASTM E1049-85, figure 6: the history, and its half cycles by range.
HISTORY = [-2.0, 1.0, -3.0, 5.0, -1.0, 3.0, -4.0, 4.0, -2.0]
COUNTS = {3.0: 0.5, 4.0: 1.5, 6.0: 0.5, 8.0: 1.0, 9.0: 0.5}


def counts_of(*pieces):
    """Return range -> count of a history in pieces."""
    rainflow, counts = Rainflow(), {}
    for cycles in [*[rainflow.add(np.array(piece)) for piece in pieces], rainflow.left()]:
        for size, count in cycles.tolist():
            counts[size] = counts.get(size, 0.0) + count
    return counts


def test_rainflow_counts_the_published_example():
    assert counts_of(HISTORY) == COUNTS


@pytest.mark.parametrize("cut", range(1, 2 * len(HISTORY)))
def test_pieces_and_points_between_turning_points_change_no_count(cut):
    middles = [0.5 * (first + second) for first, second in itertools.pairwise(HISTORY)]
    history = [value for pair in zip(HISTORY, [*middles, HISTORY[-1]], strict=True) for value in pair]
    assert counts_of(history[:cut], history[cut:]) == COUNTS
    assert counts_of(*[[value] for value in history]) == COUNTS


def test_constant_histories_have_no_cycles():
    assert counts_of([2.0, 2.0], [2.0]) == {}
    assert counts_of([]) == {}
    assert turning_points(np.array([1.0, 1.0, 2.0, 2.0, 1.0])).tolist() == [1.0, 2.0, 1.0]


def test_a_harmonic_stress_uses_up_its_life_in_the_given_cycles():
    rainflow, amplitude = Rainflow(), 150e6
    closed = rainflow.add(amplitude * np.cos(np.pi * np.arange(2001) / 10))  # 100 cycles
    cycles = np.concatenate([closed, rainflow.left()])
    assert cycles[:, 1].sum() == 100.0
    assert damage(cycles, 150e6, 5.0, 2e6) == pytest.approx(100 / 2e6, rel=1e-12)
    assert damage(cycles, 300e6, 5.0, 2e6) == pytest.approx(100 / 2e6 / 2**5, rel=1e-12)
    assert damage(np.zeros((0, 2)), 300e6, 5.0, 2e6) == 0.0


def test_damage_is_the_sum_over_amplitudes():
    cycles = np.array([[200e6, 3.0], [100e6, 0.5]])  # ranges
    assert damage(cycles, 100e6, 3.0, 1e6) == pytest.approx((3.0 + 0.5 / 8.0) / 1e6, rel=1e-14)


@pytest.mark.slow
def test_the_damage_of_a_rod_is_that_of_its_stress_at_the_middle():
    life = {"strength": 200e6, "exponent": 4.0, "cycles": 1e6}
    wide = {"section": None, "area": 1.0, "second_moment": 0.008 * HEIGHT**3 / 12.0, "edge": 0.5 * HEIGHT}
    grid = simeon(bending=1, damping=0.01, stress_life=life, **wide)  # its normal stress is nothing
    motion = clearsweep.simulate(clearsweep.load_case(grid), np.linspace(0.0, 2.0 * math.pi / SPEED, 20001))
    stress = YOUNG * 0.5 * HEIGHT * (math.pi / LENGTH) ** 2 * motion.channels["rod/deflection"]
    rainflow = Rainflow()
    cycles = np.concatenate([rainflow.add(stress), rainflow.left()])
    assert motion.summary["rod_damage"] == pytest.approx(damage(cycles, 200e6, 4.0, 1e6), rel=1e-3)
    assert motion.summary["rod_stress_max"] == pytest.approx(np.max(np.abs(stress)), rel=1e-3)
