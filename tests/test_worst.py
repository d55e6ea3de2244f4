"""The revolution of the largest peak, saved of the worst cases: which, and that it is the one."""

from typing import ClassVar

import h5py
import numpy as np
import pytest
from fake_physics import FAILS, GOOD, Fake, grid, merge, sweep
from test_sweep import same_results

import clearsweep
from clearsweep.language.errors import InputError
from clearsweep.store import blocks

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
