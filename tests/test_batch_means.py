"""Intervals from blocks of revolutions, of made-up sums: against the sums themselves and Student's interval."""

import math
from types import SimpleNamespace

import interval_coverage
import numpy as np
import pytest
from mechanism_cases import slider_crank
from scipy import optimize, stats
from test_tally import add_span, filled

from clearsweep.mechanics.observe import BINS, time_above
from clearsweep.mechanics.solver.totals import ContactTotals, MechanismTotals
from clearsweep.simulation import load_case
from clearsweep.simulation.figures import catalogue, sums

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
        add_span(self.totals.histogram[1], FORCES, share * TURN)
        add_span(self.totals.histogram[1], (0.0, 0.0), (1.0 - share) * TURN)
        self.taken.append(self.sums())


def run(figure, turns):
    """Return a made-up run, and what a figure came to in it."""
    made = Made()
    blocks = catalogue.Blocks(LAYOUT, (figure,))
    blocks.record(made)
    for _ in range(turns):
        made.turn()
        blocks.record(made)
    return made, blocks.interval(figure)


def student(values):
    """Return half of the 95 % interval of the mean of correlated, skewed values, by scipy and a search for a root."""
    count, off = len(values), values - values.mean()
    alike = float(off[1:] @ off[:-1] / (off @ off))
    alike = min(max(alike + (1.0 + 3.0 * alike) / count, 0.0), 0.9)  # Kendall's bias of a correlation
    inflation = (1.0 + alike) / (1.0 - alike)
    skewness = abs(stats.skew(values)) * math.sqrt(inflation / count)  # of the mean

    def transformed(error):  # Hall 1992: nearly without skewness
        return error + skewness * error**2 / 3.0 + skewness**2 * error**3 / 27.0 + skewness / 6.0

    quantile = stats.t.ppf(0.975, count - 1)
    longer = -optimize.brentq(lambda error: transformed(error) + quantile, -1e3, 0.0)
    return longer * math.sqrt(values.var(ddof=1) / count * inflation)


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


def test_wear_is_that_of_the_deepest_bin_of_the_joint_up_to_the_end_of_any_bin():
    made, result = run("rod_slider_wear_rate_max", 20)
    depths = np.array([wear[16:] for _, _, wear in made.taken])  # bearing and journal of the second joint
    deepest = np.argmax(depths[-1])
    assert result.value == pytest.approx(depths[-1, deepest] / (20 * TURN))
    rates = np.diff(depths, axis=0).T / TURN
    ends = [student(bin_rates) - 0.25 * (result.value - bin_rates.mean()) for bin_rates in rates]
    assert max(ends) > ends[deepest]
    assert result.half_width == pytest.approx(max(ends))


def test_wear_that_is_steady_in_one_bin_does_not_hide_that_another_may_be_deeper():
    """Of 300 runs 285 should know that the second bin wears at 1; one in three shows the first, at 0.95, as deepest."""
    random, inside, hidden = np.random.default_rng(1), 0, 0
    for _ in range(300):
        wear = np.column_stack([random.normal(0.95, 0.02, 31), random.normal(1.0, 0.4, 31)])
        depths = np.vstack([np.zeros(2), np.cumsum(wear, axis=0)])
        rate, width = sums.DepthRate().over_blocks(np.arange(32.0), depths, 1)
        inside += rate - width <= 1.0 <= rate + width
        hidden += depths[-1, 0] > depths[-1, 1]
    assert hidden > 50
    assert inside >= 276


def test_a_run_does_not_end_because_a_bin_that_scatters_is_low_by_chance():
    """Looks at lengths that grow by a tenth, until the interval is 5 %: 190 of 200 should contain the truth."""
    random, inside = np.random.default_rng(2), 0
    for _ in range(200):
        wear = np.column_stack([random.normal(0.945, 0.09, 640), 0.55 + random.exponential(0.45, 640)])
        depths = np.vstack([np.zeros(2), np.cumsum(wear, axis=0)])
        for turns in (int(31 * 1.1**look) for look in range(32)):
            stride = 2 ** max(math.ceil(math.log2(turns / 32)), 0)
            ends = np.arange(0, turns + 1, stride)
            rate, width = sums.DepthRate().over_blocks(ends.astype(float), depths[ends], stride)
            if width <= 0.05 * rate:
                break
        inside += rate - width <= 1.0 <= rate + width
    assert inside >= 186


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


def test_quantiles_of_student_are_those_of_his_distribution():
    freedoms = range(1, len(sums.STUDENT_QUANTILES) + 3)
    quantiles = np.array(list(map(sums.student_quantile, freedoms)))
    assert quantiles == pytest.approx(stats.t.ppf(0.975, freedoms), rel=1e-12)
    assert quantiles[0] == pytest.approx(math.tan(0.475 * math.pi), rel=1e-12)
    assert quantiles[1] == pytest.approx(0.95 * math.sqrt(2.0 / (1.0 - 0.95**2)), rel=1e-12)


def test_neighbours_that_are_alike_widen_the_interval_up_to_a_limit():
    values = np.repeat([1.0, 2.0, 1.0, 2.0, 1.0, 2.0], 4)
    assert sums.half_width(values) == pytest.approx(student(values))
    assert sums.half_width(values) > 1.5 * sums.half_width(np.tile([1.0, 2.0], 12))
    drift = np.linspace(0.0, 1.0, 1000)
    most = math.sqrt(1.9 / 0.1)
    plain = stats.t.ppf(0.975, 999) * drift.std(ddof=1) / math.sqrt(1000)
    assert sums.half_width(drift) == pytest.approx(most * plain)


def test_an_interval_of_skewed_values_reaches_as_far_as_its_longer_side():
    values = np.r_[np.zeros(11), 1.0]
    assert sums.half_width(values) == pytest.approx(student(values))
    assert sums.half_width(values) > 1.5 * sums.half_width(np.tile([0.0, 1.0], 6)) / math.sqrt(3.0)
    assert sums.half_width(1.0 - values) == pytest.approx(sums.half_width(values))


def test_an_interval_is_narrow_enough_relative_to_its_value():
    assert catalogue.Interval(-1.0, 0.1, 8, 30).within(0.1)
    assert not catalogue.Interval(1.0, 0.11, 8, 30).within(0.1)
    assert not catalogue.Interval(0.0, math.inf, 0, 0).within(0.1)


class Quiet(Made):
    """A run in which nothing that the sums count occurs, but contact, which is never lost."""

    def turn(self):
        """Let one revolution pass."""
        self.turns += 1
        self.totals.joint.column("contact_time")[:] = self.y[0] - 1.0  # with the rounding of times
        self.taken.append(self.sums())


@pytest.mark.parametrize(
    ("figure", "value", "width"),
    [
        ("rod_slider_impacts_per_rev", 0.0, 3.0 / 24),  # 0.95 = 1 - (1 - p)^n at p = 3 / n
        ("rod_slider_law_limit_fraction", 0.0, 3.0 / 24),
        ("rod_slider_contact_fraction", 1.0, 3.0 / 24),
        ("rod_slider_force_rms", 0.0, math.inf),  # it may become anything
        ("rod_slider_force_p99", 0.0, math.inf),
        ("rod_slider_wear_rate_max", 0.0, math.inf),
        ("slider_acceleration_rms", 0.0, math.inf),
    ],
)
@pytest.mark.parametrize("period", [None, 1])
def test_what_did_not_occur_is_known_in_periodic_motion_alone(figure, value, width, period):
    made, blocks = Quiet(), catalogue.Blocks(LAYOUT, (figure,), period)
    blocks.record(made)
    for _ in range(24):
        made.turn()
        blocks.record(made)
    result = blocks.interval(figure)
    assert result.value == pytest.approx(value)
    assert result.half_width == (pytest.approx(width) if period is None else pytest.approx(0.0, abs=1e-9))


def test_the_interval_of_p99_reaches_the_forces_at_both_ends_of_its_share_of_time():
    """Steeper on one side than on the other, so that half of both together would be too little."""
    made, blocks = Made(), catalogue.Blocks(LAYOUT, ("rod_slider_force_p99",))
    blocks.record(made)
    for index in range(30):
        made.turns += 1
        add_span(made.totals.histogram[1], (100.0, 200.0), 0.2 * TURN)
        add_span(made.totals.histogram[1], (200.0, 2000.0), (0.005 + 0.01 * (index % 2)) * TURN)
        add_span(made.totals.histogram[1], (0.0, 0.0), 0.5 * TURN)
        blocks.record(made)
    result = blocks.interval("rod_slider_force_p99")
    assert result.value == pytest.approx(200.0, rel=5e-3)
    above = student(np.tile([0.005, 0.015], 15))
    assert result.half_width == pytest.approx(1800.0 * above / 0.01, rel=0.02)


@pytest.mark.slow
@pytest.mark.parametrize("name", interval_coverage.SERIES)
def test_intervals_at_which_runs_end_contain_the_mean_as_often_as_stated(name):
    """Of 600 trials 570 are expected; the rule that ends a run, that of `until` and of lives, may lose 30."""
    assert 540 <= interval_coverage.made_up_coverage(name, 0.05, 600).inside <= 597


@pytest.mark.slow
def test_intervals_of_lives_contain_the_life_of_long_runs_as_often_as_stated():
    truth = interval_coverage.true_life()
    assert interval_coverage.life_coverage((10, 2, 0.05), 100, truth).inside >= 92
