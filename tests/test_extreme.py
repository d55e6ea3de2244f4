"""The largest peak to expect in many revolutions: distributions with known maxima, and a run as long as predicted."""

from typing import ClassVar

import h5py
import numpy as np
import pytest
from fake_physics import FAILS, GOOD, Fake, grid, merge, sweep
from right_grids import grid_of
from test_sweep import same_results

import clearsweep
from clearsweep.answers.questions import expected_peak_sentence, largest_expected_peak
from clearsweep.language.errors import InputError
from clearsweep.simulation.analyses import outcome
from clearsweep.simulation.figures.window import UNKNOWN_QUANTILE, Tail, expected_largest
from clearsweep.store import blocks
from clearsweep.sweeping import summary

MANY = 1e6


def beta(chance, count):
    """Return values of a bounded distribution, a beta(3, 3) between 8 and 12."""
    return 8.0 + 4.0 * chance.beta(3.0, 3.0, count)


def largest_of(chance, count):
    """Return the largest of so many values of `beta`."""
    from scipy.stats import beta as distribution

    return 8.0 + 4.0 * distribution(3.0, 3.0).ppf(chance.random() ** (1.0 / count))


def test_the_largest_bounded_value_exceeds_the_end_as_rarely_as_stated():
    chance = np.random.default_rng(5)
    inside, ratios = 0, []
    for _ in range(60):
        known = expected_largest(beta(chance, 300), MANY)
        future = largest_of(chance, MANY)
        inside += known.low <= future <= known.high
        ratios.append(known.value / future)
    assert inside >= 55  # of 60, with 97.5 % each: fewer have a chance of 1 %
    assert np.median(ratios) == pytest.approx(1.0, abs=0.02)


def test_more_values_make_the_interval_narrower():
    values = beta(np.random.default_rng(1), 4000)
    few, many = (expected_largest(values[:count], MANY) for count in (200, 4000))
    assert many.high - many.low < 0.5 * (few.high - few.low)


def test_nothing_is_predicted_of_few_or_of_dependent_values():
    chance = np.random.default_rng(2)
    assert expected_largest(beta(chance, 99), MANY) == UNKNOWN_QUANTILE
    assert expected_largest(np.repeat(beta(chance, 50), 3), MANY) == UNKNOWN_QUANTILE


def test_values_that_repeat_predict_the_largest_of_them():
    assert expected_largest(np.full(200, 5.0), MANY) == (5.0, 5.0, 5.0)
    assert expected_largest(np.tile([5.0, 7.0], 200), MANY) == (7.0, 7.0, 7.0)


def test_the_prediction_is_never_below_what_was_seen_and_scales_with_the_unit():
    values = beta(np.random.default_rng(3), 500)
    known, scaled = expected_largest(values, MANY), expected_largest(1e3 * values, MANY)
    assert values.max() == known.low <= known.value <= known.high
    assert scaled == pytest.approx([1e3 * each for each in known], rel=1e-9)


def test_a_tail_without_shape_is_exponential():
    item = Tail(np.array([2.0, 2.0]), np.array([0.0, -1e-9]), np.array([0.5, 0.5]))
    assert item.exceedance_probabilities(3.0) == pytest.approx(np.exp(-1.5), rel=1e-8)
    assert Tail(np.array([2.0]), np.array([-0.5]), np.ones(1)).exceedance_probabilities(4.0) == 0.0  # its end


def test_the_sentence_names_interval_window_and_place():
    block = {
        "case_id": np.array(["a" * 16, "b" * 16]),
        "period": np.array([np.nan, 1.0]),
        "j_force_peak": np.array([3.0, 9.0]),
        "j_force_peak_million": np.array([4.0, 9.0]),
        "j_force_peak_million_high": np.array([5.0, 9.0]),
    }
    worst = largest_expected_peak(block, ["j"])
    assert worst == ("a" * 16, "j", 4.0, 5.0, 3.0)  # a motion that repeats itself needs no prediction
    text = expected_peak_sentence(["4 N", "5 N", "3 N"], " in joint j")
    assert text.startswith(
        "The largest force peak in 10⁶ revolutions is estimated at 4 N, at most 5 N (97.5 %) in joint j"
    )
    assert largest_expected_peak({"case_id": block["case_id"], "period": np.ones(2)}, ["j"]) is None
    facts = worst._asdict() | {"swept": {}, "case_id": "a" * 16}
    assert {"value", "high", "seen"} <= facts.keys()  # of run --json
    assert summary.expected_lines({"expected": facts})[1] == text.replace("in joint j", "in j")


GRID = grid_of("a long run of one joint")


@pytest.mark.slow
def test_a_long_chaotic_run_reaches_what_its_beginning_predicts(monkeypatch):
    recorded, spread = [], outcome.spread_of
    monkeypatch.setattr(outcome, "spread_of", lambda peaks, *rest: recorded.append(peaks) or spread(peaks, *rest))
    path = clearsweep.simulate(clearsweep.load_case(GRID))
    assert path.status == "ok"
    assert path.summary["period"] is None
    (peaks,) = recorded
    windows = peaks[: len(peaks) // 400 * 400].reshape(-1, 400)
    predicted = [expected_largest(window, len(peaks)) for window in windows]
    assert np.mean([known.high >= peaks.max() for known in predicted]) > 0.9
    assert np.median([known.value for known in predicted]) == pytest.approx(peaks.max(), rel=0.02)


# The revolution of the largest peak, saved of the worst cases: which, and that it is the one.


PEAK = "rod_slider_force_peak"


class Peaked(Fake):
    """Made-up mechanics that say which peaks they were asked for."""

    asked: ClassVar[list] = []

    @classmethod
    def peak(cls, case, joint, revolutions, window_from=None):
        """Return a made-up revolution."""
        cls.asked.append((case.mechanism.values["slider.mass"], joint, revolutions))
        return Fake.peak(case, joint, revolutions)


@pytest.fixture(autouse=True)
def _nothing_asked():
    Peaked.asked = []


def quiet(source, out, **options):
    return sweep(source, out, simulator=Peaked, executor="serial", show_progress=False, **options)


def asking(worst=2, masses=5, **changes):
    """Return a grid that saves the peaks of its worst cases."""
    source = grid(masses, **changes)
    return source | {"save": source["save"] | {"worst": worst}}


def test_the_worst_cases_are_computed_again_and_what_is_saved_is_read_back(tmp_path):
    quiet(asking(gravities=(GOOD, FAILS)), tmp_path / "run")
    run = clearsweep.open(tmp_path / "run")
    ranked = run.summary[run.summary["status"] == "ok"].sort_values(PEAK, ascending=False)
    assert run.worst == ranked["case_id"].tolist()[:2]
    assert [mass for mass, *_ in Peaked.asked] == ranked[PEAK].tolist()[:2]
    assert {(joint, length) for _, joint, length in Peaked.asked} == {(0, 10.0)}
    for case_id in run.worst:
        frame = run.peak_revolution(case_id[:10])
        assert (frame.attrs["joint"], frame.attrs["turns"]) == ("rod_slider", 3.0)
        assert np.array_equal(frame["slider/x"], run.orbit(case_id)["slider/x"])  # made up, both are the same
        assert frame.attrs["units"]["slider/x"] == "m"
    with pytest.raises(InputError, match="was not saved"):
        run.peak_revolution(ranked["case_id"].iloc[2])
    with h5py.File(tmp_path / "run" / "orbits.h5") as file:
        parts = []
        file["worst"].visititems(lambda _, part: parts.append(part) if isinstance(part, h5py.Dataset) else None)
        assert len(parts) == 4 + len(run.layout.channels)
        assert all({"units", "description"} <= set(part.attrs) for part in parts)


def test_nothing_is_computed_again_while_the_run_is_as_it_was(tmp_path):
    quiet(asking(), tmp_path / "run")
    assert len(Peaked.asked) == 2
    quiet(asking(), tmp_path / "run")
    assert len(Peaked.asked) == 2
    quiet(grid(5), tmp_path / "run")  # what is saved of a finished run may be left out and asked for again
    assert clearsweep.open(tmp_path / "run").worst == []
    assert quiet(asking(worst=3), tmp_path / "run").ran == 0
    assert len(clearsweep.open(tmp_path / "run").worst) == 3


def test_without_histories_of_all_cases_those_of_the_worst_exist(tmp_path):
    source = asking()
    quiet(source | {"save": {"orbits": "none", "samples": 20, "worst": 1}}, tmp_path / "run")
    run = clearsweep.open(tmp_path / "run")
    assert run.orbit(run.worst[0]).empty
    with h5py.File(tmp_path / "run" / "orbits.h5") as file:
        assert "t" not in file
        assert "t" in file["worst"]


def test_shards_merge_to_what_one_run_leaves(tmp_path):
    quiet(asking(), tmp_path / "whole")
    for number in (1, 2):
        quiet(asking(), tmp_path / f"{number}", shard=f"{number}/2")
    merge([tmp_path / "1", tmp_path / "2"], tmp_path / "merged")
    assert same_results(tmp_path / "merged", tmp_path / "whole")


class Elsewhere(Peaked):
    """Made-up mechanics on another machine, where peaks differ in their last bits."""

    @classmethod
    def peak(cls, case, joint, revolutions, window_from=None):
        """Return a made-up revolution with another peak."""
        result = super().peak(case, joint, revolutions)
        result.path.summary[PEAK] *= 1.0 + 1e-15
        return result


@pytest.mark.parametrize(("block", "saved"), [(1000, 2), (2, 5)])
def test_a_motion_that_is_another_one_here_is_left_out_with_a_sentence(tmp_path, monkeypatch, capfd, block, saved):
    """In one piece and in blocks, each of which saves the peaks of its own two worst cases."""
    monkeypatch.setattr(blocks, "BLOCK", block)
    sweep(asking(), tmp_path / "run", simulator=Elsewhere, executor="serial", show_progress=False)
    run = clearsweep.open(tmp_path / "run")
    assert run.worst == []
    assert len(run.summary) == 5
    sentence = "the revolution of its largest peak is left out (its motion differs on this machine)"
    assert capfd.readouterr().err.count(sentence) == saved
