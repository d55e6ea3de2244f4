"""A case wears until its limit, block by block, records how it went on, and goes on where it was killed."""

import copy
import json
import math

import fake_physics
import h5py
import numpy as np
import pytest
from fake_physics import sweep
from mechanism_cases import slider_crank, untimed
from ruamel.yaml import YAML

import clearsweep
from clearsweep import grid, simulation, store
from clearsweep.mechanics.solver import integration
from clearsweep.mechanics.wear import Worn
from clearsweep.simulation.analyses import life
from clearsweep.simulation.analyses.life import BlockRecord, decoded, encoded
from clearsweep.simulation.running.observed_run import restore, snapshot_of
from clearsweep.simulation.running.run import Run
from clearsweep.simulation.setup.start import control_of, start_of
from clearsweep.sweeping import estimate
from clearsweep.sweeping.summary import of_run, plain, run_text

LIFE = {"limit": "20 um", "joint": "rod-slider", "max_revolutions": 12, "tolerance": 0.2}
WORN = {
    "joints.rod-slider.wear": {"law": "archard", "coefficient": 2e-14, "bins": 72},
    "simulate.tolerance": 1e-6,
    "simulate.revolutions": 3,
    "simulate.discard": 1,
    "save.orbits": "last",
    "save.revolutions": 1,
    "save.samples": 36,
}


def source(changes=None, **keys):
    """Return a grid dict of a joint that wears, with this in the section `life`."""
    return slider_crank("rod-slider", changes=copy.deepcopy(WORN) | {"life": LIFE | keys} | (changes or {}))


def loaded(changes=None, **keys):
    return grid.load(source(changes, **keys), simulation.catalogue())


# ---------------------------------------------------------------------------------------------- grid


def test_a_life_is_part_of_a_case_and_left_out_it_is_none():
    base = grid.load(slider_crank("rod-slider", changes=WORN), simulation.catalogue())
    assert base.case(0).life is None
    assert "life" not in base.written_case(0)
    ids = {loaded(**keys).case_id(0) for keys in ({}, {"limit": "30 um"}, {"of": "clearance_growth"}, {"blocks": 20})}
    assert len(ids | {base.case_id(0)}) == 5
    assert loaded(of="wear_depth_max", blocks=200).case_id(0) == loaded().case_id(0)
    again = grid.load(loaded().resolved(), simulation.catalogue())
    assert again.case(0) == loaded().case(0)
    assert again.case_id(0) == loaded().case_id(0)


def test_a_long_life_with_evolve_proposes_settings_that_take_less_time():
    slow = {"simulate.tolerance": 1e-9, "simulate.revolutions": 40, "joints.rod-slider.wear.evolve": True}
    case = loaded(slow, tolerance=0.05, max_revolutions=60).case(0)
    lives = estimate.cheaper_lives(case)
    short, coarse, rough, constant = lives
    assert short == "simulate.revolutions: 5"
    assert rough == "simulate.revolutions: 5, simulate.tolerance: 1e-6, life.tolerance: 0.2"
    assert constant == "joints.rod-slider.wear.evolve: false"
    for settings, cheaper in lives.items():  # each is the case of a grid with these lines
        keys = dict(entry.split(": ") for entry in settings.split(", "))
        written = {path: YAML(typ="safe").load(value) for path, value in keys.items()}
        tolerance = written.pop("life.tolerance", 0.05)
        assert loaded(slow | written, tolerance=tolerance, max_revolutions=60).case(0) == cheaper
    assert estimate.cheaper_lives(loaded().case(0)) == {}  # without evolve the motion does not change
    (text,) = estimate.cheaper_lives_texts(7200.0, {short: 5000.0, coarse: 1200.0, constant: 30.0}, 2.0)
    assert "about 4 h" in text
    assert f"`{coarse}` about 40 min" in text
    assert f"`{short}`" not in text  # hardly faster
    assert estimate.cheaper_lives_texts(7200.0, {short: 5000.0}, 1.0) == []


def test_a_limit_can_be_swept():
    swept = loaded({"sweep": {"life.limit": ["10 um", "20 um"]}})
    assert [swept.case(k).life.limit for k in range(2)] == [1e-5, 2e-5]


def test_a_life_may_take_as_long_as_it_does_unless_its_grid_says_otherwise():
    assert loaded().case(0).simulate.time_budget == math.inf
    assert loaded({"simulate.time_budget": 60.0}).case(0).simulate.time_budget == 60.0
    assert loaded({"life": None}).case(0).simulate.time_budget == 600.0
    assert loaded({"simulate.time_budget": 60.0}).case_id(0) == loaded().case_id(0)


def test_hours_of_a_life_are_limited_in_hours_and_are_numbers_in_figures():
    limits_met = {
        "limits": {"rod_slider_life_hours": {"at_least": "300 min"}, "rod_slider_life_revolutions": {"at_least": 1e6}},
        "figures": {"days": "rod_slider_life_hours / 24"},
    }
    verdict = loaded(limits_met).verdict
    assert [limit.value for limit in verdict.limits] == [5.0, 1e6]
    assert verdict.figures[0].unit == "1"
    assert loaded({"limits": {"rod_slider_life_hours": {"at_least": 5.0}}}).verdict.limits == verdict.limits[:1]


# ---------------------------------------------------------------------------------------------- store


def test_histories_of_lives_are_stored_ragged_and_read_again(tmp_path):
    made_up = fake_physics.grid(masses=4, wear=True, life=LIFE | {"limit": "20 um"})
    sweep(made_up, tmp_path / "run", executor="serial", show_progress=False)
    run = clearsweep.open(tmp_path / "run")
    contents = grid.load(made_up, fake_physics.CATALOGUE)
    for k in range(len(contents)):
        expected, result = fake_physics.trajectory(contents.case(k)).history, run.history(contents.case_id(k))
        assert result.keys() == expected.keys()
        assert all(np.array_equal(result[name], expected[name]) for name in result)
    with h5py.File(tmp_path / "run" / "orbits.h5") as file:
        assert file["history/offsets"][-1] == sum(
            len(run.history(contents.case_id(k))["revolutions"]) for k in range(len(contents))
        )
        assert file["history/rod_slider/profile_bearing"].shape == (file["history/offsets"][-1], 36)
        for name in ("revolutions", "offsets", "rod_slider/clearance", "rod_slider/profile_journal"):
            assert {"units", "description"} <= file[f"history/{name}"].attrs.keys()
    assert not (tmp_path / "run" / "tmp").exists()


def test_what_has_no_life_has_nothing_of_it(tmp_path):
    sweep(fake_physics.grid(masses=2, wear=True), tmp_path / "run", executor="serial", show_progress=False)
    run = clearsweep.open(tmp_path / "run")
    assert run.history(run.summary["case_id"][0]) == {}
    assert not [name for name in run.columns if "life" in name or "growth" in name]
    with h5py.File(tmp_path / "run" / "orbits.h5") as file:
        assert "history" not in file


def test_failed_lives_keep_no_history(tmp_path):
    made_up = fake_physics.grid(masses=2, gravities=(0.0, fake_physics.FAILS), wear=True, life=LIFE)
    sweep(made_up, tmp_path / "run", executor="serial", show_progress=False)
    run = clearsweep.open(tmp_path / "run")
    for case_id, status in zip(run.summary["case_id"], run.summary["status"], strict=True):
        assert (len(run.history(case_id)["revolutions"]) > 0) == (status == "ok")


def test_a_log_is_whole_or_nothing_and_follows_its_case(tmp_path):
    (tmp_path / "tmp").mkdir()
    log = store.Unfinished(tmp_path, "0123456789abcdef")
    assert log.read() is None
    log.keep(b"one")
    log.keep(b"two\n\0")
    assert log.read() == b"two\n\0"
    (path,) = (tmp_path / "tmp").iterdir()
    path.write_bytes(path.read_bytes()[:-1] + b"x")
    assert log.read() is None
    log.discard()
    log.discard()
    assert not list((tmp_path / "tmp").iterdir())


@pytest.mark.slow
def test_logs_outlive_a_run_until_their_cases_are_done(tmp_path):
    made_up = fake_physics.grid(masses=2, gravities=(0.0, fake_physics.DIES), wear=True, life=LIFE)
    sweep(made_up, tmp_path / "run", jobs=1, show_progress=False)
    contents = grid.load(made_up, fake_physics.CATALOGUE)
    killed = {f".clearsweep-{contents.case_id(k)}.life" for k in range(4) if contents.point(k)["mechanism.gravity"]}
    assert {path.name for path in (tmp_path / "run" / "tmp").iterdir()} == killed
    done = next(contents.case_id(k) for k in range(4) if not contents.point(k)["mechanism.gravity"])
    store.Unfinished(tmp_path / "run", done).keep(b"of a process that was killed after its commit")
    sweep(made_up, tmp_path / "run", jobs=1, show_progress=False)
    assert {path.name for path in (tmp_path / "run" / "tmp").iterdir()} == killed


def test_results_of_blocks_are_read_as_they_were_written_and_nothing_else_is():
    chance = np.random.default_rng(3)
    message = [
        BlockRecord(*(chance.standard_normal(shape) for shape in (7, 7, 2, (24, 2), 12, 2, ())))._replace(
            counts=np.arange(12) + k, life=np.int64(k)
        )
        for k in range(3)
    ]
    content = encoded(message)
    again = decoded(content, 7)
    assert len(again) == 3
    for first, other in zip(message, again, strict=True):
        assert all(a.tobytes() == b.tobytes() and a.dtype == b.dtype for a, b in zip(first, other, strict=True))
    assert decoded(content, 8) == decoded(content[:-40], 7) == decoded(b"", 7) == decoded(None, 7) == []


# ---------------------------------------------------------------------------------------------- motion

heavy = pytest.mark.heavy


def lived(changes=None, log=None, **keys):
    return clearsweep.simulate(clearsweep.load_case(source(changes, **keys)), log=log)


class KilledError(Exception):
    """Stands for the death of a process."""


class Memory:
    """A log in memory, whose process is killed when it has kept so many blocks."""

    def __init__(self, most=math.inf, content=None):
        """Take how many, and what was kept before."""
        self.content, self.kept, self.most = content, 0, most

    def read(self):
        """Return what was kept."""
        return self.content

    def keep(self, content):
        """Keep it, or be killed."""
        self.content, self.kept = content, self.kept + 1
        if self.kept >= self.most:
            raise KilledError


@heavy
def test_a_wear_rate_that_nothing_changes_is_found_in_one_block():
    result = lived()
    summary, history = result.summary, result.history
    assert result.status == "ok"
    assert "unreached" not in result.message  # though 5000 rpm are too fast for a dry bush, which it says
    assert "pv-high: rod-slider has a mean pV of" in result.message
    assert summary["rod_slider_life_blocks"] == 1
    length = summary["rod_slider_life_revolutions"]
    turns = round((result.t[-1] * 5000.0 / 60.0) - 1.0)
    assert turns > 8
    assert length == pytest.approx(2e-5 / summary["rod_slider_wear_depth_max"] * turns, rel=1e-9)
    assert summary["rod_slider_life_hours"] == pytest.approx(length / 5000.0 / 60.0, rel=1e-9)
    assert summary["rod_slider_life_low"] < length < summary["rod_slider_life_high"]
    assert summary["rod_slider_life_jump_error"] == 0.0
    assert history["revolutions"].tolist() == [0.0, length]
    assert history["rod_slider/profile_bearing"].shape == (2, 72)
    depth = max(history[f"rod_slider/profile_{body}"][-1].max() for body in ("bearing", "journal"))
    assert history["rod_slider/wear_depth_max"][-1] == depth == pytest.approx(2e-5, rel=1e-12)
    assert history["rod_slider/wear_rate"] == pytest.approx([summary["rod_slider_wear_rate_max"]] * 2, rel=1e-9)
    assert history["rod_slider/force_peak"].tolist() == [summary["rod_slider_force_peak"]] * 2
    growth = summary["rod_slider_clearance_growth"]
    assert 2e-5 <= growth <= 4e-5
    assert history["rod_slider/clearance"] == pytest.approx([5e-4, 5e-4 + growth], rel=1e-12)
    assert result["history/revolutions"] is history["revolutions"]
    assert len(repr(result)) - len(result.message) < 200
    plain = clearsweep.simulate(
        clearsweep.load_case(slider_crank("rod-slider", changes=WORN | {"simulate.revolutions": turns + 1}))
    )
    assert all(np.array_equal(result[name], plain[name]) for name in plain.channels)
    assert np.array_equal(result.events, plain.events)
    assert summary["rod_slider_force_rms"] == plain.summary["rod_slider_force_rms"]
    assert plain.history == {}


@heavy
def test_clearance_growth_is_a_limit_as_well():
    result = lived(of="clearance_growth")
    assert result.summary["rod_slider_clearance_growth"] == pytest.approx(2e-5, rel=1e-6)
    assert result.history["rod_slider/wear_depth_max"][-1] < 2e-5
    assert result.summary["rod_slider_life_revolutions"] < lived().summary["rod_slider_life_revolutions"]


@heavy
@pytest.mark.parametrize("blocks", [2, 20])
def test_what_does_not_wear_has_an_unlimited_life_and_says_so(blocks):
    result = lived({"joints.rod-slider.wear.coefficient": 0.0, "life.blocks": blocks})
    assert result.status == "ok"
    lives = ("revolutions", "hours", "low", "low_hours", "high")
    assert [result.summary[f"rod_slider_life_{name}"] for name in lives] == [math.inf] * 5
    assert result.message.split(" | ")[-1] == ("unreached: rod-slider has no wear, so it never reaches life.limit")


@heavy
@pytest.mark.parametrize("kept", [1, 3])
def test_a_life_that_was_killed_gives_the_same_end_to_the_last_bit(monkeypatch, kept):
    monkeypatch.setattr(life.LifeRun, "identical_blocks", False)  # as if what has worn changed the motion
    whole = lived(limit="60 um")
    assert whole.summary["rod_slider_life_blocks"] > 4
    log = Memory(most=kept)
    with pytest.raises(KilledError):
        lived(log=log, limit="60 um")
    resumed = Memory()
    resumed.content = log.content
    again = lived(log=resumed, limit="60 um")
    assert resumed.kept == whole.summary["rod_slider_life_blocks"] - 1 - kept  # the last one need not be kept
    assert again.history.keys() == whole.history.keys()
    assert all(again.history[name].tobytes() == whole.history[name].tobytes() for name in whole.history)
    assert untimed(again) == untimed(whole)
    assert all(np.array_equal(again[name], whole[name]) for name in whole.channels)


@heavy
def test_a_life_of_one_block_that_was_killed_is_one_of_one_block():
    log = Memory(most=1)
    with pytest.raises(KilledError):
        lived(log=log)
    again, whole = lived(log=log), lived()
    assert untimed(again) == untimed(whole)
    assert all(again.history[name].tobytes() == whole.history[name].tobytes() for name in whole.history)


@heavy
def test_a_life_that_does_not_reach_its_limit_has_a_lower_bound(monkeypatch, capsys):
    monkeypatch.setattr(life.LifeRun, "identical_blocks", False)
    monkeypatch.setattr("clearsweep.language.phases.FIRST_LINE_DELAY", 0.0)
    monkeypatch.setattr("clearsweep.language.phases.MAX_INTERVAL", 0.0)
    monkeypatch.setattr("clearsweep.language.phases.REFRESH_INTERVAL", 1e-3)
    scene = clearsweep.load_case(source(blocks=3, limit="900 um"))
    result = clearsweep.simulate(scene, progress=True)
    summary = result.summary
    assert result.status == "ok"
    assert "unreached: rod-slider does not reach life.limit in " in result.message
    assert summary["rod_slider_life_revolutions"] is None
    assert summary["rod_slider_life_high"] is None
    assert summary["rod_slider_life_low"] == result.history["revolutions"][-1] > 0.0
    seconds = summary["rod_slider_life_low"] * 60.0 / 5000.0
    assert summary["rod_slider_life_low_hours"] == pytest.approx(seconds / 3600.0, rel=1e-9)
    assert summary["rod_slider_clearance_growth"] > 0.0
    text = capsys.readouterr().err
    assert "block 1, 0\N{NO-BREAK SPACE}m of 0.900\N{NO-BREAK SPACE}mm: " in text
    assert "block 3, " in text
    assert ": revolution " in text


@heavy
def test_a_life_that_fails_says_in_which_block():
    result = lived({"simulate.event_budget": 1})
    assert result.status == "event-budget"
    assert result.message.startswith("block 1 of its life: reached the budget of ")
    assert result.history == {}
    assert result.summary["rod_slider_life_revolutions"] is None


@heavy
def test_time_that_a_killed_life_took_counts_towards_its_budget(monkeypatch):
    monkeypatch.setattr(life.LifeRun, "identical_blocks", False)
    log = Memory(most=2)
    with pytest.raises(KilledError):
        lived(log=log)
    message = decoded(log.content, 2 * 72 + 2)
    spent = [each._replace(seconds=np.array([0.1, 1000.0])) for each in message]
    resumed = Memory()
    resumed.content = encoded(spent)
    assert lived({"simulate.time_budget": 900.0}, log=resumed).status == "time-budget"


# ---------------------------------------------------------------------------------------------- shapes that act


def worn_on(case, turns):
    """Return the deepest bin and the force peak after each of so many revolutions of one motion.

    It is never begun anew: after each revolution what it wore off is taken off the shape, and it goes on as it was.
    """
    joint, last = case.joints[0], None
    worn, depths, peaks = np.zeros((2, joint.wear.bins)), [], []
    for k in range(turns + 1):
        scene = simulation.build(case, {joint.name: Worn(*worn)})
        run = Run(start_of(scene, np.empty(0)))
        control = control_of(scene, math.inf, keep_events=False)._replace(window=0.0, step_budget=10**9)
        if last:
            restore(snapshot_of(last.work), run.work)
        status, _ = run.advance(control._replace(pause=scene.crank_clock.value_after(case.simulate.discard + k)))
        assert status == integration.PAUSED
        last = run
        if k:
            worn = worn + run.totals.wear.reshape(2, -1)
            peaks.append(run.totals.joint[0].force_max)
        depths.append(worn.max())
    return np.array(depths), np.array(peaks), worn


ACTING = {
    "joints.rod-slider.wear": {"law": "archard", "coefficient": 4e-12, "bins": 360, "evolve": True},
    "joints.rod-slider.clearance": 3e-5,  # of 5e-5 the motion is irregular: runs of 200 revolutions differ by a tenth
    "joints.rod-slider.contact.restitution": 0.1,
    "drive.speed": "1500 rpm",
    "simulate.tolerance": 1e-7,
    "simulate.revolutions": 12,
    "simulate.discard": 8,
}


@pytest.mark.slow
def test_jumps_come_to_what_two_hundred_revolutions_of_one_motion_wear_off():
    """Wear comes to a fifth of the clearance and changes the forces by more than a twenty-fifth.

    How many jumps are repeated depends on the scatter of irregular motion: starts that differ by rounding need 10 to 16
    blocks (mean 12, standard deviation 1.8), so the claim on their number is one on the mean.
    """
    plain = grid.load(source(ACTING | {"life": None}), simulation.catalogue()).case(0)
    depths, peaks, worn = worn_on(plain, 200)
    assert depths[-1] / plain.joints[0].clearance == pytest.approx(0.2, rel=0.1)
    assert abs(np.median(peaks[-10:]) / np.median(peaks[:10]) - 1.0) > 0.04
    results = [
        lived(
            ACTING | {"joints.rod-slider.clearance": 3e-5 * (1.0 + start * 1e-9)},
            limit=float(depths[-1]),
            tolerance=0.05,
            max_revolutions=50,
        )
        for start in range(6)
    ]
    assert np.mean([result.summary["rod_slider_life_blocks"] for result in results]) < 15.0
    for result in results:
        length = result.summary["rod_slider_life_revolutions"]
        within = result.summary["rod_slider_life_low"] < 200.0 < result.summary["rod_slider_life_high"]
        assert within or length == pytest.approx(200.0, rel=0.02)
    for place, body in enumerate(("bearing", "journal")):
        assert result.history[f"rod_slider/profile_{body}"][-1].sum() == pytest.approx(worn[place].sum(), rel=0.02)
    halved = lived(ACTING, limit=float(depths[-1]), tolerance=0.05, max_revolutions=50, longest_jump=40)
    assert halved.summary["rod_slider_life_revolutions"] == pytest.approx(length, rel=0.02)


@heavy
def test_unlimited_lives_meet_their_limit_and_are_told_in_words(tmp_path):
    source_of_both = source({"joints.rod-slider.wear.coefficient": 0.0}) | {
        "limits": {"rod_slider_life_hours": {"at_least": "10 h"}},
        "sweep": {"joints.rod-slider.wear.coefficient": [0.0, 2e-14]},
        "name": "unlimited",
    }
    facts = of_run(clearsweep.sweep(source_of_both, tmp_path / "out", executor="serial", show_progress=False))
    run = clearsweep.open(tmp_path / "out")
    json.dumps(facts, allow_nan=False)
    text = plain(run_text(facts))
    assert "  unlimited" in text
    assert "1 case has no wear, so the life there is unlimited." in text
    assert sorted(np.isinf(run.summary["rod_slider_life_hours"])) == [False, True]
    assert [design["verdict"] for design in facts["answer"]["designs"]] == ["meets", "exceeds"]
    assert "unlimited" in run.report(tmp_path / "report.html").read_text(encoding="utf-8")
