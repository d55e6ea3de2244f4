"""What each revolution comes to: peaks against dense samples and events, sections, periods, intervals of quantiles."""

import numpy as np
import pytest
from mechanism_cases import slider_crank
from scipy import stats

import clearsweep
from clearsweep.answers.judged import binomial_distribution
from clearsweep.simulation.analyses import trajectory
from clearsweep.simulation.figures import window
from clearsweep.simulation.setup import start

FRICTION = {"law": "ambrosio", "coefficient": 0.05, "v0": 1e-3, "v1": 1e-2}
TURN = 0.012  # s
SHORT = {"simulate.revolutions": 3, "simulate.discard": 1, "joints.rod-slider.friction": FRICTION}
#: the journal hardly leaves the bearing: the motion settles to one that repeats itself with the crank
QUIET = {"joints.rod-slider.clearance": 5e-5, "joints.rod-slider.contact.restitution": 0.3}


def run(times=None, **changes):
    case = slider_crank("rod-slider", changes=SHORT | changes)
    trajectory = clearsweep.simulate(clearsweep.load_case(case), times=times)
    assert trajectory.status == "ok", trajectory.message
    return trajectory


@pytest.fixture(scope="module")
def dense():
    """Return a run sampled so densely that a sample is within 1e-4 of every peak."""
    return run(np.linspace(TURN, 3 * TURN, 200_001))


def test_the_load_peak_is_the_largest_resultant_of_the_two_forces(dense):
    load = np.hypot(dense["joints/rod_slider/force_normal"], dense["joints/rod_slider/force_tangential"]).max()
    result = dense.summary["rod_slider_load_peak"]
    assert load <= result * (1.0 + 1e-9)
    assert load == pytest.approx(result, rel=1e-4)
    assert result > 1.0005 * dense.summary["rod_slider_force_peak"]  # where it slides, sqrt(1 + 0.05^2) of it
    assert dense.summary["rod_slider_force_peak_ratio"] == pytest.approx(
        result / dense.summary["rod_slider_force_peak_ideal"], rel=1e-12
    )


def test_without_friction_the_load_is_the_normal_force():
    summary = run(**{"joints.rod-slider.friction": None}).summary
    assert summary["rod_slider_load_peak"] == summary["rod_slider_force_peak"]


def test_peaks_of_revolutions_are_those_of_dense_samples(dense):
    force, summary = dense["joints/rod_slider/force_normal"], dense.summary
    peaks = [force[:100_001].max(), force[100_000:].max()]
    assert peaks[0] != pytest.approx(peaks[1], rel=1e-3)
    assert summary["rod_slider_force_peak_median"] == pytest.approx(np.median(peaks), rel=1e-4)
    assert summary["rod_slider_force_peak_p95"] == pytest.approx(np.quantile(peaks, 0.95), rel=1e-4)
    assert summary["rod_slider_force_peak"] >= summary["rod_slider_force_peak_p95"]


def test_a_peak_belongs_to_the_revolution_of_its_contact():
    path = run(**{"simulate.revolutions": 9, "save": {"orbits": "last", "revolutions": 1, "samples": 2}})
    ended = path.events[path.events["kind"] == "off"]
    begun = path.events["t"][path.events["kind"] == "on"][: len(ended)]
    first, last = np.floor(begun / TURN), np.floor(ended["t"] / TURN)
    peaks = np.zeros(9)
    np.maximum.at(peaks, last[first == last].astype(int), ended["force_peak"][first == last])
    straddling = np.zeros(9)
    np.maximum.at(straddling, last[first != last].astype(int), ended["force_peak"][first != last])
    np.maximum.at(straddling, first[first != last].astype(int), ended["force_peak"][first != last])
    assert np.all(straddling[1:] < peaks[1:])  # so that the events have the peak of every revolution
    result = path.summary["rod_slider_force_peak_median"]
    assert result == pytest.approx(np.median(peaks[1:]), rel=1e-12)
    assert path.summary["rod_slider_force_peak_median_low"] == pytest.approx(np.sort(peaks[1:])[0], rel=1e-12)
    assert path.summary["rod_slider_force_peak_p95_high"] is None


def test_the_revolution_of_the_largest_peak_has_the_bits_of_the_whole_run():
    changes = SHORT | {"simulate.revolutions": 7, "save": {"orbits": "all", "samples": 90}}
    scene = clearsweep.load_case(slider_crank("rod-slider", changes=changes))
    whole, result = clearsweep.simulate(scene), trajectory.peak_revolution(scene.case, 0, 7.0)
    first = int(result.turns)
    assert 1 <= first == result.turns <= 6
    same = [
        name for name in whole.summary if name not in ("run_time", "setup_time", "rhs_evaluations")
    ]  # which sampling adds to
    assert [result.path.summary[name] for name in same] == [whole.summary[name] for name in same]
    here = slice(90 * first, 90 * first + 91)
    usual = np.isin(result.path.t, whole.t)
    for name in ("t", "slider/x", "joints/rod_slider/force_normal"):
        assert np.array_equal(result.path[name][usual], whole[name][here])
    assert 91 < result.path.t.size < 91 + 62
    force = result.path["joints/rod_slider/force_normal"].max()
    assert 0.9 < force / whole.summary["rod_slider_force_peak"] <= 1.0 + 1e-12  # in between it is sampled densely
    ended = whole.events[whole.events["kind"] == "off"]
    hardest = ended[ended["t"] > TURN][np.argmax(ended["force_peak"][ended["t"] > TURN])]
    assert hardest["force_peak"] == pytest.approx(whole.summary["rod_slider_force_peak"], rel=1e-12)
    assert 0.0 < hardest["t"] / TURN - first < 1.2  # of a contact that ends there or soon after


def test_the_revolution_of_the_largest_peak_is_that_of_the_histories():
    times = np.linspace(TURN, 5 * TURN, 400_001)
    path = run(times, **{"simulate.revolutions": 5, "simulate.error_check": True})
    largest = times[path["joints/rod_slider/force_normal"].argmax()]
    assert path.summary["rod_slider_force_peak_revolution"] == int(largest / TURN) + 1
    assert path.summary["rod_slider_force_peak_difference"] is not None
    assert "rod_slider_force_peak_revolution" not in run().summary


def test_a_journal_that_stays_on_its_bearing_repeats_itself_every_revolution():
    path = run(**QUIET, **{"simulate.revolutions": 8, "simulate.discard": 3})
    assert path.summary["period"] == 1
    median, largest = (path.summary[f"rod_slider_force_peak{end}"] for end in ("_median", ""))
    assert median == pytest.approx(largest, rel=1e-6)


def test_two_revolutions_do_not_determine_a_period():
    assert run(**QUIET, **{"simulate.revolutions": 5, "simulate.discard": 3}).summary["period"] is None


@pytest.mark.parametrize("angle", [0.0, 90.0, -30.0])
def test_sections_are_the_samples_at_crank_angle_zero(angle):
    saved = {"save": {"orbits": "all", "samples": 360}, "simulate.revolutions": 2}
    path = run(**saved, **({"drive.start_angle": f"{angle} deg"} if angle else {}))
    turns = path["crank_angle"] / (2.0 * np.pi)
    at_zero = np.abs(turns - np.round(turns)) < 1e-9
    assert path["poincare/revolution"].tolist() == np.round(turns[at_zero]).astype(int).tolist()
    assert len(path.poincare) == 5
    for name in ("x", "y", "vx", "vy"):
        expected = path[f"joints/rod_slider/{name}"][at_zero]
        assert path[f"poincare/rod_slider/{name}"] == pytest.approx(expected, rel=1e-9, abs=1e-14)


def test_a_run_without_histories_has_no_sections():
    assert run().poincare == {}


def rows(period, count, *, drift=0.0):
    made = np.random.default_rng(3).normal(size=(period, 4))
    return np.array([made[k % period] + drift * k for k in range(count)])


@pytest.mark.parametrize("period", [1, 2, 5, 16])
def test_a_period_is_found_once_it_was_repeated_three_times(period):
    assert start.period_of(rows(period, 4 * period)) == period
    assert start.period_of(rows(period, 4 * period - 1)) is None
    assert start.period_of(rows(period, 4 * period, drift=2e-3)) is None


def test_whole_turns_of_an_angle_are_no_difference():
    turn = np.array([6.0])
    going_round = rows(2, 8)
    going_round[:, 0] += 6.0 * np.arange(8)
    assert start.period_of(going_round) is None
    assert start.period_of(going_round, turn) == 2


def test_intervals_of_quantiles_hold_what_they_promise():
    random, missed = np.random.default_rng(5), np.zeros(2)
    for _ in range(2000):
        values = random.exponential(size=100)
        for share, place in ((0.5, 0), (0.95, 1)):
            result, true = window.quantiles(values, (share,))[0], stats.expon.ppf(share)
            assert result.value == pytest.approx(np.quantile(values, share), rel=1e-12)
            high = np.inf if result.high is None else result.high  # what is no end is no bound
            missed[place] += not result.low <= true <= high
    assert np.all(missed / 2000 < 0.05 + 3 * np.sqrt(0.05 * 0.95 / 2000))


def test_values_that_follow_each_other_count_for_fewer():
    walk = np.cumsum(np.random.default_rng(1).normal(size=200))
    mixed = np.random.default_rng(2).permutation(walk)
    widths = [result.high - result.low for result in (window.quantiles(values, (0.5,))[0] for values in (walk, mixed))]
    assert widths[0] > 2.0 * widths[1]


def test_too_few_revolutions_have_no_interval():
    assert window.quantiles(np.arange(5.0), (0.5,))[0] == (2.0, None, None)
    assert window.quantiles(np.array([1.0, 6.0, 2.0, 5.0, 3.0, 4.0]), (0.5,))[0] == (3.5, 1.0, 6.0)
    assert window.quantiles(np.empty(0), (0.5,))[0] == (None, None, None)
    changing = np.arange(72.0) * (-1.0) ** np.arange(72)  # neighbours are far apart
    assert window.quantiles(changing, (0.95,))[0].high == 70.0
    assert window.quantiles(changing[:71], (0.95,))[0].high is None


@pytest.mark.parametrize(("count", "probability"), [(1, 0.5), (19, 0.95), (300, 0.5), (20_000, 0.975)])
def test_numbers_of_successes_are_distributed_as_by_the_binomial_formula(count, probability):
    expected = stats.binom.cdf(np.arange(count + 1), count, probability)
    assert binomial_distribution(count, probability) == pytest.approx(expected, abs=1e-9)
