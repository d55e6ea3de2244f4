"""Wear is extrapolated to the life that follows from the law of its rate, and says how far it may be off."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq

from clearsweep.simulation.analyses.extrapolation import StepControl, extrapolate_life, redistributed_fraction
from clearsweep.simulation.machine.ideal import first_touch

SCALE, RATE = 0.3, 1e-6  # m, over which the made-up rates change; m per revolution


class BlockRecord:
    """What a made-up block found."""

    def __init__(self, rate, share=0.0, turns=1.0):
        """Take the rates, the half-width of their interval over themselves, and the revolutions of the block."""
        self.rate = np.array(rate, float)
        self.width = share * self.rate
        self.turns = turns


class Deepest:
    """The deepest of all bins."""

    def value(self, state):
        """Return its depth."""
        return float(state.max())

    def slope(self, state):
        """Return which it is."""
        return (np.arange(state.size) == np.argmax(state)).astype(float)

    def shape_error(self, state):
        """Return that no shape is smoothed."""
        return 0.0

    def is_valid(self, state):
        """Return that every state can be run."""
        return True


def control(**other):
    bins = slice(0, other.pop("bins", 1))
    usual = {
        "limit": 1.0,
        "tolerance": 0.05,
        "blocks": 400,
        "min_jump": 1.0,
        "max_jump": math.inf,
        "max_first_growth": np.full(bins.stop, 0.02),
        "groups": (bins,),
        "constant_rates": False,
        "identical_blocks": False,
    }
    return StepControl(**usual | other)


def life(rates, share=0.0, **other):
    asked = control(**other)
    return extrapolate_life(
        lambda state: BlockRecord(rates(state), share), Deepest(), asked, np.zeros(asked.max_first_growth.size)
    )


#: Rates over what has worn, and the revolutions until it is 1 m: the integral of 1 / rate.
LAWS = {
    "falling": (lambda h: RATE * np.exp(-h / SCALE), SCALE * (math.exp(1.0 / SCALE) - 1.0) / RATE),
    "growing": (lambda h: RATE * (1.0 + h / SCALE), SCALE * math.log1p(1.0 / SCALE) / RATE),
    "root": (lambda h: RATE / (h + 0.05), (0.5 + 0.05) / RATE),
    "even": (lambda h: RATE + 0.0 * h, 1.0 / RATE),
}


@pytest.mark.parametrize("law", LAWS)
def test_a_life_is_that_of_the_law_of_its_rate_within_its_interval(law):
    rates, exact = LAWS[law]
    result = life(rates)
    assert result.reached
    assert result.revolutions == pytest.approx(exact, rel=3e-3)
    assert result.low <= exact <= result.high
    assert result.nodes[-1].state[0] == pytest.approx(1.0, rel=1e-12)
    assert np.all(np.diff([node.revolutions for node in result.nodes]) > 0.0)


@pytest.mark.parametrize("law", ["falling", "growing"])
def test_jumps_half_as_long_leave_a_quarter_of_the_error_that_a_life_states(law):
    rates, exact = LAWS[law]
    result = {longest: life(rates, tolerance=0.5, max_jump=longest * exact) for longest in (0.02, 0.01, 0.005)}
    errors = [abs(each.revolutions / exact - 1.0) for each in result.values()]
    assert errors[0] > 3.4 * errors[1] > 3.4**2 * errors[2]
    assert all(error <= each.jump_error for error, each in zip(errors, result.values(), strict=True))
    assert abs(result[0.02].revolutions / result[0.01].revolutions - 1.0) < 0.02
    assert result[0.01].blocks > 1.8 * result[0.02].blocks


def test_a_tighter_tolerance_costs_blocks_and_gives_accuracy():
    rates, exact = LAWS["falling"]
    loose, tight = life(rates, tolerance=0.2), life(rates, tolerance=0.02)
    assert abs(tight.revolutions / exact - 1.0) < 0.1 * abs(loose.revolutions / exact - 1.0)
    assert loose.blocks < 20 < tight.blocks
    assert tight.jump_error < 0.1 * loose.jump_error


def test_a_constant_rate_takes_one_block_and_has_its_interval():
    result = life(LAWS["even"][0], share=0.1, constant_rates=True, identical_blocks=True)
    assert result.blocks == 1
    assert result.jump_error == 0.0
    assert result.revolutions == pytest.approx(1.0 / RATE, rel=1e-12)
    assert result.low == pytest.approx(1.0 / (1.1 * RATE), rel=1e-12)
    assert result.high == pytest.approx(1.0 / (0.9 * RATE), rel=1e-12)


class Depth(Deepest):
    """What is worn, compared with the way slid."""

    def value(self, state):
        """Return the depth."""
        return float(state[0])

    def slope(self, state):
        """Return that the depth alone counts."""
        return np.array([1.0, 0.0])


def run_in(turns, *, drifting, initial, tolerance=1e-3):
    """Return a life in which the coefficient falls from `initial` to 1 with the way slid, 1 per revolution, over 5000.

    The rate of a block of so many `turns` is the mean over it, an integral in closed form.
    """

    def measure(state):
        fallen = (initial - 1.0) * math.exp(-state[1] / 5000.0) * -math.expm1(-turns / 5000.0) * 5000.0 / turns
        return BlockRecord([RATE * (1.0 + fallen), 1.0], turns=turns)

    first = np.array([math.inf, 500.0])
    asked = control(
        limit=0.02,
        tolerance=tolerance,
        blocks=20000,
        max_first_growth=first,
        identical_blocks=True,
        drifting_rates=drifting,
    )
    return extrapolate_life(measure, Depth(), asked, np.zeros(2))


@pytest.mark.parametrize("initial", [4.0, 0.25])
@pytest.mark.parametrize("turns", [20.0, 100.0])
def test_the_interval_of_a_life_that_runs_in_has_what_half_a_block_makes_of_it(turns, initial):
    def left(n):
        return RATE * (n + (initial - 1.0) * 5000.0 * -math.expm1(-n / 5000.0)) - 0.02

    exact = brentq(left, 0.0, 1e5)
    last = 1.0 + (initial - 1.0) * math.exp(-exact / 5000.0)
    bias = 0.5 * turns * (initial / last - 1.0)  # revolutions, from the rates at both ends
    result = run_in(turns, initial=initial, drifting=True)
    assert result.revolutions - exact == pytest.approx(bias, rel=0.03)
    assert result.low < exact < result.high
    bare = run_in(turns, initial=initial, drifting=False)
    assert not bare.low < exact < bare.high
    wider = 0.5 * (result.high - result.low) - 0.5 * (bare.high - bare.low)
    assert wider == pytest.approx(abs(bias), rel=0.02)


@pytest.mark.parametrize("tolerance", [0.1, 0.02, 0.005])
def test_jumps_through_a_running_in_err_by_less_than_the_interval(tolerance):
    """The rate depends on the way slid, which a jump foretells; a correction by the depth would err by 1.9 % at 0.1."""
    result = run_in(1.0, initial=4.0, drifting=True, tolerance=tolerance)
    exact = brentq(lambda n: RATE * (n + 15000.0 * -math.expm1(-n / 5000.0)) - 0.02, 0.0, 1e5)
    assert result.low < exact < result.high
    assert result.jump_error < 0.2 * tolerance


def test_independent_blocks_narrow_the_interval_and_blocks_of_one_motion_do_not():
    even = LAWS["even"][0]
    apart, alike = life(even, share=0.1), life(even, share=0.1, identical_blocks=True)
    assert alike.high == pytest.approx(1.0 / (0.9 * RATE), rel=1e-6)
    assert 1.0 / RATE < apart.high < 0.97 * alike.high


def test_what_intervals_explain_does_not_shorten_jumps():
    chance = np.random.default_rng(5)
    rates, exact = LAWS["growing"]
    lives = [
        extrapolate_life(
            lambda h: BlockRecord(rates(h) * (1.0 + 0.1 * chance.standard_normal(1)), 0.196),
            Deepest(),
            control(),
            np.zeros(1),
        )
        for _ in range(40)
    ]
    assert np.mean([each.blocks for each in lives]) < 2.0 * life(rates).blocks
    assert sum(each.low <= exact <= each.high for each in lives) >= 36
    assert np.mean([each.revolutions for each in lives]) == pytest.approx(exact, rel=0.03)


def test_a_pit_that_wanders_is_followed():
    """Bins wear where they are least worn, so that all come down together: the deepest is one of many."""
    bins = 8

    def rates(state):
        shares = np.exp(-(state - state.min()) / 0.05) * np.linspace(1.0, 2.0, bins)
        return RATE * bins * shares / shares.sum()

    result = life(rates, bins=bins)
    assert result.reached
    depth = result.nodes[-1].state
    assert depth.sum() == pytest.approx(bins * RATE * result.revolutions, rel=1e-9)
    finest = life(rates, bins=bins, tolerance=0.01)
    assert result.revolutions == pytest.approx(finest.revolutions, rel=0.02)
    assert np.allclose(depth, finest.nodes[-1].state, atol=0.02)


def test_the_edge_of_a_scar_that_widens_is_as_deep_as_it_has_been_worn():
    """An edge moves with the depth, and all behind it wears alike: a bin is as deep as the scar since the edge came."""
    places = (np.arange(200) + 0.5) / 200

    def rates(state):
        return RATE * (places < 0.2 + 0.6 * state.max())

    for tolerance in (0.1, 0.05, 0.02):
        result = life(rates, bins=200, tolerance=tolerance)
        exact = np.clip(1.0 - (places - 0.2) / 0.6, 0.0, 1.0)
        assert np.max(np.abs(result.nodes[-1].state - exact)) < 0.3 * tolerance
        assert result.blocks < 5.0 / tolerance


def test_a_rate_that_moves_elsewhere_is_seen_though_its_sum_stays():
    here, there = BlockRecord([1.0, 0.0]), BlockRecord([0.0, 1.0])
    here.block = here
    assert redistributed_fraction(here, there, (slice(0, 2),)) == 1.0
    assert redistributed_fraction(here, here, (slice(0, 2),)) == 0.0
    assert redistributed_fraction(here, there, (slice(0, 0),)) == 0.0


def test_a_jump_is_not_longer_than_one_that_was_refused_just_before():
    """A scar widens as it deepens; the intervals of its rates explain differences up to some length of the jump."""
    bins = np.linspace(-1.0, 1.0, 81)
    deepest = []

    def widening(state):
        deepest.append(state.max())
        half_width = 0.05 + 0.9 * deepest[-1]
        return BlockRecord(RATE * np.maximum(1.0 - (bins / half_width) ** 2, 0.0) / half_width, 0.03)

    result = extrapolate_life(widening, Deepest(), control(bins=81), np.zeros(81))
    lengths = np.diff([node.revolutions for node in result.nodes])
    refused = np.diff(deepest) < 0.0  # the next prediction is less deep
    after = [int(np.sum(~refused[:k])) - 1 for k in np.flatnonzero(refused)]  # jump that was repeated
    assert len(set(after)) > 1
    assert all(lengths[k + 1] <= lengths[k] * (1.0 + 1e-12) for k in after if k + 2 < len(lengths))


def test_a_life_that_does_not_come_to_its_end_is_as_long_as_it_was_run():
    result = life(lambda h: RATE * np.exp(-h / 0.01), blocks=12)
    assert not result.reached
    assert result.blocks == 12
    assert result.low == result.revolutions > 0.0
    assert math.isinf(result.high)
    assert math.isnan(result.jump_error)
    still = life(lambda h: 0.0 * h)
    assert (still.reached, still.blocks, still.revolutions) == (False, 1, 0.0)
    assert not life(lambda h: 0.0 * h, constant_rates=True).reached


def test_a_block_that_fails_ends_it():
    count = iter(range(3))
    assert (
        extrapolate_life(lambda h: BlockRecord([RATE]) if next(count) < 2 else None, Deepest(), control(), np.zeros(1))
        is None
    )
    assert extrapolate_life(lambda h: None, Deepest(), control(), np.zeros(1)) is None


# ---------------------------------------------------------------------------------------------- first touch

BINS, CLEARANCE = 360, 1e-4


def touched(bearing, journal, turn, direction):
    """Return the eccentricity at first touch, found by moving the journal out until the gap closes somewhere."""
    angles = np.arange(BINS)
    gap = CLEARANCE + bearing + np.roll(journal, turn)
    low, high = 0.0, 2.0 * gap.max()
    for _ in range(50):
        middle = 0.5 * (low + high)
        closed = np.any(gap - middle * np.cos(2.0 * math.pi * (angles - direction) / BINS) < 0.0)
        low, high = (low, middle) if closed else (middle, high)
    return low


def pit(middle, half, depth):
    off = (np.arange(BINS) - middle + BINS / 2) % BINS - BINS / 2
    return depth * np.maximum(1.0 - (off / half) ** 2, 0.0)


def test_the_eccentricity_at_first_touch_is_that_at_which_the_gap_closes():
    bearing, journal = pit(40, 30, 2e-5), pit(200, 25, 1e-5)
    turns = [0, 100, 190, 230]
    result = first_touch(CLEARANCE, bearing, journal, 2.0 * math.pi * np.array(turns) / BINS)
    naive = {(t, d): touched(bearing, journal, t, d) for t in turns for d in range(BINS)}
    (turn, direction), most = max(naive.items(), key=lambda each: each[1])
    assert result.growth == pytest.approx(most - CLEARANCE, rel=1e-6, abs=1e-15)
    assert result.journal_bin == (result.bearing_bin - turn) % BINS
    assert abs(result.bearing_bin - direction) < 60
    depth = bearing[result.bearing_bin] + journal[result.journal_bin]
    assert (CLEARANCE + depth) * result.growth_per_depth == pytest.approx(CLEARANCE + result.growth, rel=1e-12)


def test_a_body_that_is_worn_all_round_widens_the_joint_and_one_narrow_pit_does_not():
    even, none = np.full(BINS, 1e-5), np.zeros(BINS)
    assert first_touch(CLEARANCE, even, none, [0.0]).growth == pytest.approx(1e-5, rel=1e-12)
    assert first_touch(CLEARANCE, even, even, [1.0]).growth == pytest.approx(2e-5, rel=1e-12)
    assert first_touch(CLEARANCE, none, none, [0.3, 2.0]).growth == 0.0
    narrow = none.copy()
    narrow[7] = 1e-4
    assert first_touch(CLEARANCE, narrow, none, [0.0]).growth < 2e-4 * (1.0 - math.cos(2.0 * math.pi / BINS))
