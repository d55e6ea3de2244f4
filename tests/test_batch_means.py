"""Intervals from blocks of revolutions, of made-up sums: against the sums themselves and Student's interval."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from mechanism_cases import slider_crank
from scipy import stats
from test_tally import add_ramp, filled

from clearsweep.mechanics.observe.histogram import BINS, time_above
from clearsweep.mechanics.solver.accumulate.totals import ContactTotals, MechanismTotals
from clearsweep.simulation import batch_means, load_case, sums

WORN = {
    f"joints.{name}.wear": {"law": "archard", "coefficient": 2e-14, "bins": 8} for name in ("crank-rod", "rod-slider")
}
LAYOUT = load_case(slider_crank("crank-rod", "rod-slider", changes=WORN)).layout
TURN = 0.02  # s, of a revolution
FORCES = (100.0, 300.0)  # N, at an even rate from one to the other in every revolution, for a share of the time


class Made:
    """A run under way whose sums grow by independent random numbers."""

    def __init__(self, seed=1):
        self.random = np.random.default_rng(seed)
        self.turns = 0
        self.totals = SimpleNamespace(
            mechanism=MechanismTotals.zeros(),
            joint=ContactTotals.zeros(2),
            histogram=np.zeros((2, BINS, 2)),
            wear=np.zeros(2 * 2 * 8),
        )
        self.taken = [self.sums()]

    @property
    def y(self):
        """Return the state, which here is the time (s) alone."""
        return np.array([1.0 + TURN * self.turns])

    time = 0

    def sums(self):
        """Return copies of what is summed of the second joint and of the mechanism."""
        return self.totals.joint[1].copy(), self.totals.mechanism.copy(), self.totals.wear.copy()

    def turn(self):
        """Let one revolution pass."""
        self.turns += 1
        for name in ("force_square", "contact_time", "beyond_time"):
            self.totals.joint.column(name)[:] += self.random.uniform(0.5, 1.5, 2)
        self.totals.joint.column("onsets")[:] += self.random.integers(1, 9, 2)
        self.totals.mechanism.acceleration_square += self.random.uniform(0.5, 1.5)
        self.totals.wear += self.random.uniform(0.0, 1.0, self.totals.wear.size) * np.arange(32)
        share = self.random.uniform(0.02, 0.06)
        add_ramp(self.totals.histogram[1], FORCES, share * TURN)
        add_ramp(self.totals.histogram[1], (0.0, 0.0), (1.0 - share) * TURN)
        self.taken.append(self.sums())


def run(figure, turns):
    """Return a made-up run, and what a figure came to in it."""
    made = Made()
    blocks = batch_means.Blocks(LAYOUT, (figure,))
    blocks.record(made)
    for _ in range(turns):
        made.turn()
        blocks.record(made)
    return made, blocks.interval(figure)


def student(values):
    """Return half of the 95 % interval of the mean of values of which neighbours are alike at random alone."""
    off = values - values.mean()
    together = max(float(off[1:] @ off[:-1] / (off @ off)), 0.0)
    wide = math.sqrt((1.0 + together) / (1.0 - together))
    return stats.t.ppf(0.975, len(values) - 1) * values.std(ddof=1) / math.sqrt(len(values)) * wide


@pytest.mark.parametrize(
    ("figure", "name"),
    [("contact_fraction", "contact_time"), ("law_limit_fraction", "beyond_time")],
)
def test_a_mean_over_time_and_its_interval_are_those_of_the_blocks(figure, name):
    made, result = run(f"rod_slider_{figure}", 20)
    means = np.diff([getattr(joint, name) for joint, _, _ in made.taken]) / TURN
    assert (result.value, result.blocks) == (pytest.approx(means.mean()), 20)
    assert result.half_width == pytest.approx(student(means))


def test_impacts_are_counted_per_revolution():
    made, result = run("rod_slider_impacts_per_rev", 20)
    counts = np.diff([joint.onsets for joint, _, _ in made.taken])
    assert result.value == pytest.approx(counts.mean())
    assert result.half_width == pytest.approx(student(counts))


@pytest.mark.parametrize("figure", ["rod_slider_force_rms", "slider_acceleration_rms"])
def test_a_root_mean_square_has_half_the_relative_interval_of_the_square(figure):
    made, result = run(figure, 20)
    taken = [
        whole.acceleration_square if figure.startswith("slider") else joint.force_square
        for joint, whole, _ in made.taken
    ]
    squares = np.diff(taken) / TURN
    assert result.value == pytest.approx(math.sqrt(squares.mean()))
    assert result.half_width / result.value == pytest.approx(0.5 * student(squares) / squares.mean())


def test_wear_is_that_of_the_deepest_bin_of_the_joint():
    made, result = run("rod_slider_wear_rate_max", 20)
    depths = np.array([wear[16:] for _, _, wear in made.taken])  # bearing and journal of the second joint
    deepest = np.argmax(depths[-1])
    assert result.value == pytest.approx(depths[-1, deepest] / (20 * TURN))
    assert result.half_width == pytest.approx(student(np.diff(depths[:, deepest]) / TURN))


def test_the_force_exceeded_for_a_hundredth_of_the_time_is_that_of_the_ramps():
    _, result = run("rod_slider_force_p99", 30)
    random = Made().random
    shares = []
    for _ in range(30):
        random.uniform(size=6), random.integers(1, 9, 2), random.uniform(), random.uniform(size=32)
        shares.append(random.uniform(0.02, 0.06))
    mean = np.mean(shares)
    force = FORCES[1] - 0.01 / mean * (FORCES[1] - FORCES[0])
    assert result.value == pytest.approx(force, rel=2e-3)
    above = np.array(shares) * (FORCES[1] - force) / (FORCES[1] - FORCES[0])  # share of time above it, by block
    steepness = mean / (FORCES[1] - FORCES[0])  # share of time per newton
    assert result.half_width == pytest.approx(student(above) / steepness, rel=0.02)


@pytest.mark.parametrize("force", [120.0, 121.3, 200.0, 299.0])
def test_the_time_above_a_force_is_that_of_the_ramp(force):
    assert time_above(force, filled(FORCES, 1.0)) == pytest.approx((300.0 - force) / 200.0, abs=1e-9)


def test_blocks_become_longer_as_a_run_grows_and_all_of_them_count():
    made, result = run("rod_slider_contact_fraction", 71)
    taken = np.array([joint.contact_time for joint, _, _ in made.taken])
    whole = np.diff(taken[: 17 * 4 + 1 : 4]) / (4 * TURN)  # 17 blocks of four revolutions; 32 would be of two
    assert result.blocks == 17
    assert result.value == pytest.approx(whole.mean())
    assert result.half_width == pytest.approx(student(whole))


def test_neighbours_that_are_alike_widen_the_interval_up_to_a_limit():
    values = np.repeat([1.0, 2.0, 1.0, 2.0, 1.0, 2.0], 4)
    assert sums.half_width(values) == pytest.approx(student(values))
    assert sums.half_width(values) > 1.5 * sums.half_width(np.tile([1.0, 2.0], 12))
    drift = np.linspace(0.0, 1.0, 1000)
    most = math.sqrt(1.9 / 0.1)
    plain = stats.t.ppf(0.975, 999) * drift.std(ddof=1) / math.sqrt(1000)
    assert sums.half_width(drift) == pytest.approx(most * plain)


def test_an_interval_of_few_blocks_is_never_narrow_enough():
    assert not batch_means.Interval(1.0, 0.0, 7).within(0.1)
    assert batch_means.Interval(-1.0, 0.1, 8).within(0.1)
    assert not batch_means.Interval(1.0, 0.11, 8).within(0.1)
