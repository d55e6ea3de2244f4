"""What takes long says what it does and for how long still: in the parent, in workers, to `status` and in a dry run."""

import dataclasses
import html
import io
import itertools
import os
import re
import threading
import time

import fake_physics
import numpy as np
import pytest
from fake_physics import Fake, grid, sweep
from mechanism_cases import slider_crank

import clearsweep
from clearsweep import report, simulation, store
from clearsweep.contracts.results import Trajectory
from clearsweep.language import phases
from clearsweep.language.errors import StorageError
from clearsweep.mechanics.solver import loop
from clearsweep.report import effects
from clearsweep.report.study import open_partial
from clearsweep.simulation.analyses import outcome
from clearsweep.simulation.running.observed_run import Life, LifeLimits
from clearsweep.store import StoredRun
from clearsweep.sweeping import estimate, summary
from clearsweep.sweeping.pool import driver
from clearsweep.sweeping.pool.case_runner import SIMULATION
from clearsweep.sweeping.pool.worker import time_case
from clearsweep.tracing import objects

heavy = pytest.mark.heavy


class Clock:
    """A clock that goes on when it is asked to."""

    def __init__(self, monkeypatch):
        self.now = 0.0
        monkeypatch.setattr(phases.time, "monotonic", lambda: self.now)


@pytest.fixture
def manual_time(monkeypatch):
    """Stand in for the clock of this process."""
    return Clock(monkeypatch)


@pytest.fixture
def phases_seen():
    """Collect the words of all phases that this process opens."""

    class Listener:
        def __init__(self):
            self.words = []

        def changed(self):
            """Record the words of the open phases."""
            self.words += [result.what] if (result := phases.progress()) else []

    listener = Listener()
    phases.listeners.append(listener)
    yield listener.words
    phases.listeners.remove(listener)


def lines_over(manual_time, seconds, display):
    """Let so many seconds go by under the eyes of a display."""
    for _ in range(int(2 * seconds)):
        manual_time.now += 0.5
        display.refresh()


# ---------------------------------------------------------------------------------------------- phases


def test_a_phase_is_reported_after_five_seconds_and_ever_more_rarely(manual_time, capsys):
    display = phases.Display()
    with phases.phase("writing orbits.h5") as writing:
        lines_over(manual_time, 4.5, display)
        assert not capsys.readouterr().err
        writing.note(share=0.25)
        lines_over(manual_time, 300.0, display)
    printed = capsys.readouterr().err.splitlines()
    assert printed[0] == "writing orbits.h5, 25 %, 5 s spent, about 15 s left"
    assert 5 < len(printed) < 15


def test_a_row_of_short_phases_is_never_silent_for_longer_than_one_long_phase(manual_time, capsys):
    display = phases.Display()
    for number in range(5):
        with phases.phase(f"part {number}"):
            lines_over(manual_time, 3.0, display)
    printed = capsys.readouterr().err.splitlines()
    assert printed == ["part 1, 2 s spent", "part 3, 1 s spent", "part 4, 3 s spent"]


def test_phases_inside_are_named_and_the_one_that_knows_reports_the_time_left(manual_time):
    with phases.phase("timing 4 cases"), phases.phase("") as case, phases.phase(lambda: "revolution 3 of 10") as run:
        manual_time.now = 6.0
        run.note(share=0.3)
        case.facts = {"case": 2}
        result = phases.progress()
        assert (result.what, result.left, dict(result.facts)) == (
            "timing 4 cases: revolution 3 of 10",
            14.0,
            {"case": 2},
        )
    assert phases.progress() is None


def test_what_is_compiled_inside_does_not_slow_the_pace_of_a_phase(manual_time):
    with phases.phase("running") as running:
        with phases.phase(phases.Phase("compiling", once=True)):
            manual_time.now = 30.0
        manual_time.now = 40.0
        running.note(share=0.5)
        assert phases.progress().left == 10.0
    assert phases.compile_seconds() >= 30.0


def test_a_terminal_gets_a_line_that_is_redrawn_and_cleared(manual_time, monkeypatch):
    stream = io.StringIO()
    stream.isatty = lambda: True
    monkeypatch.setattr("sys.stderr", stream)
    display = phases.Display()
    with phases.phase("drawing") as drawing:
        lines_over(manual_time, 2.0, display)
        drawing.note(share=0.5)
        display.refresh()
        drawn = stream.getvalue().rpartition("\r")[2].rstrip()
        assert re.fullmatch(r"\|[#█]{12} {12}\| drawing, 50 %, 2 s spent, about 2 s left", drawn)
        display.print_line("a sentence")
        assert re.search(r"\r +\ra sentence\n$", stream.getvalue())
        display.refresh()
    display.refresh()
    assert re.search(r"\r +\r$", stream.getvalue())


def test_a_fault_in_one_line_does_not_end_the_progress_of_a_run(monkeypatch, capfd):
    failed, message = threading.Event(), threading.Event()

    def words():
        if not failed.is_set():
            failed.set()
            raise ZeroDivisionError
        message.set()
        return "still at work"

    monkeypatch.setattr(phases, "REFRESH_INTERVAL", 0.001)
    with phases.show_progress(), phases.phase(words):
        assert message.wait(10.0)
    assert "Traceback" not in capfd.readouterr().err


def test_what_a_worker_wrote_is_read_as_it_is_by_then(manual_time, monkeypatch):
    content, wall = [], [1000.0]
    monkeypatch.setattr(phases.time, "time", lambda: wall[0])
    with phases.store_progress(content.append):
        with phases.phase("block 3, 10 um of 50 um") as life:
            life.note(remaining_time=60.0)
            assert not content  # as it may be over at once
            manual_time.now = 2.0
            life.note(remaining_time=58.0, block=3)
        assert content.pop() is None  # it is over
    wall[0] += 8.0
    result = phases.stored_progress(content[0])
    assert (result.what, result.seconds, result.left) == ("block 3, 10 um of 50 um", 10.0, 50.0)
    assert result.facts == {"block": 3}
    assert phases.stored_progress(content[0][:-1]) is None


def test_the_compiler_at_work_is_a_phase(monkeypatch):
    message = []
    monkeypatch.setattr(objects.cache, "load", lambda name: None)
    monkeypatch.setattr(objects.cache, "store", lambda name, content: None)
    monkeypatch.setattr(objects, "compile_object", lambda module: message.append(phases.progress()) or b"")
    assert objects.load_or_compile(objects.load_or_compile, "a test", objects.Trace) is None
    (compiling,) = message
    assert (compiling.what, compiling.once) == ("compiling (kept for later runs)", True)
    assert phases.progress() is None


def test_the_compiler_is_reported_from_its_begin_as_it_reports_nothing_itself(manual_time):
    written = []
    with phases.store_progress(written.append):
        with phases.phase(phases.Phase("compiling (kept for later runs)", once=True)):
            manual_time.now += 20.0
            assert phases.stored_progress(written[-1]).what == "compiling (kept for later runs)"
        assert written[-1] is None


def test_a_life_of_equal_blocks_foretells_its_end(manual_time):
    with phases.phase(Life(LifeLimits(50e-6, 10e-6, 100, 10.0, constant_rates=False), earlier_blocks=0)) as life:
        assert phases.progress().left is None
        for block in range(5):  # 20 s each, 10 um further with each but the first
            manual_time.now += 20.0
            life.reached(10e-6 * block)
            if block:
                left = 20.0 * (6 - block - 1 + 1)
                assert phases.progress().left == pytest.approx(left)
        assert phases.progress().what == "block 6, 40.0\N{NO-BREAK SPACE}µm of 50.0\N{NO-BREAK SPACE}µm"
        assert phases.progress().facts["block"] == 6


# ---------------------------------------------------------------------------------------------- sweeps


def test_the_time_left_of_a_life_counts_those_that_follow_it(manual_time):
    limits = LifeLimits(50e-6, 10e-6, 100, 10.0, constant_rates=False)
    left = []
    for further in (0, 2):
        manual_time.now = 0.0
        with phases.phase(Life(limits._replace(further_lives=further), earlier_blocks=0)) as life:
            for k in range(1, 3):
                manual_time.now = 10.0 * k
                life.reached(10e-6 * k)
            left.append(phases.progress().left)
    # 20 s of 2 blocks are done of one life, so the others take 20 s and what is left of it
    assert left[1] == pytest.approx(left[0] + 2.0 * (20.0 + left[0]))


def test_the_time_left_of_cases_does_not_jump_and_counts_what_workers_have_in_hand(manual_time):
    cases, text, done = driver.CaseProgress(1000), [], 0
    cases.read_progress = lambda: (done - cases.done, ())
    with phases.phase(cases):
        for step in range(
            100
        ):  # ten cases a second, a batch of fifty every five; the first second passes in starting up
            manual_time.now += 1.0 if step == 0 else 0.25
            done = int(2.5 * step)
            cases.advance(50 if done >= cases.done + 50 else 0, 0)
            if (left := phases.progress().left) is not None:
                text.append(left + manual_time.now)
        assert phases.progress().what == "247 of 1,000 cases, 0 failed"
    assert len(text) > 10
    assert max(text) - min(text) < 10.0  # s: the end that is foretold stays where it is


def test_progress_of_cases_in_a_log_is_a_line_now_and_then(manual_time, capsys):
    display, cases = phases.Display(), driver.CaseProgress(1000)
    with phases.phase(cases):
        for _ in range(1000):
            manual_time.now += 0.5
            cases.advance(1, 0)
            display.refresh()
    printed = capsys.readouterr().err.splitlines()
    assert 5 < len(printed) < 25
    assert printed[0] == "10 of 1,000 cases, 0 failed, 5 s spent, about 8 min 15 s left"


def test_every_part_of_a_sweep_is_a_phase(tmp_path, phases_seen):
    result = sweep(
        grid(3, save={"orbits": "none", "worst": 1}), tmp_path / "run", executor="serial", show_progress=False
    )
    assert result.ok == 3
    expected = [
        "reading the grid",
        "checking the cases",
        "reading the directory",
        "loading compiled code",
        "1 of 3 cases, 0 failed",
        "saving the revolution of the largest peak of 1 case",
        "writing orbits.h5",
        "writing summary.parquet",
        "computing checksums",
    ]
    places = [next((k for k, words in enumerate(phases_seen) if words.startswith(start)), -1) for start in expected]
    assert -1 not in places
    assert places == sorted(places)


class Long(Fake):
    """Compiles for some seconds, and its cases are lives of some seconds."""

    @staticmethod
    def compile_for(case):
        """Take four seconds, of seven that were expected."""
        with phases.phase(phases.Phase("compiling (kept for later runs)", once=True)) as compiling:
            for tenth in range(40):
                compiling.note(remaining_time=7.0 - 0.1 * tenth)
                time.sleep(0.1)

    @staticmethod
    def solve(case, log=None):
        """Return a made-up trajectory after a life of three seconds."""
        with phases.phase(lambda: "block 7, 31 um of 50 um", covers_nested=True) as life:
            for tenth in range(30):
                life.note(remaining_time=300.0 - 0.1 * tenth, block=7, reached=31e-6, limit=50e-6)
                time.sleep(0.1)
        return fake_physics.trajectory(case)


@pytest.mark.slow
@heavy
def test_a_run_and_its_status_report_compiling_and_a_life_at_work(tmp_path, monkeypatch, capfd):
    monkeypatch.setattr(phases, "FIRST_LINE_DELAY", 0.3)  # s
    monkeypatch.setattr(phases, "INTERVAL_GROWTH", 1.0)  # else a slow start leaves seconds between lines
    monkeypatch.setattr(driver, "LONG_CASE_TIME", 0.3)
    seen, ended = [], threading.Event()

    def watch():
        while not ended.wait(0.2):
            if (tmp_path / "run" / "run.json").exists():
                seen.append(store.status(tmp_path / "run"))

    thread = threading.Thread(target=watch)
    thread.start()
    try:
        result = sweep(grid(2), tmp_path / "run", jobs=1, simulator=Long)
    finally:
        ended.set()
        thread.join()
    assert result.ok == 2
    lines = capfd.readouterr().err.splitlines()
    compiling = [line for line in lines if line.startswith("compiling (kept for later runs), part ")]
    assert compiling
    assert "about" in compiling[-1]
    at_work = [line for line in lines if "block 7, 31 um of 50 um" in line]
    assert at_work[0].startswith("0 of 2 cases, 0 failed, ")
    assert "left; case 1 of 2 (" in at_work[0]
    assert "about 4 min 5" in at_work[0].partition("; ")[2]
    assert int(at_work[0].partition("about ")[2].split(" min")[0]) in (9, 10)  # two lives of 5 min, one after the other
    message = [fact for facts in seen for fact in facts["at_work"] if "block" in fact]
    assert {each["case"] for each in message} >= {1}
    assert (message[0]["block"], message[0]["limit"], message[0]["what"]) == (7, 50e-6, "block 7, 31 um of 50 um")
    assert 290.0 < message[0]["left"] < 300.0
    text = next(store.status_text(facts) for facts in seen if any("block" in fact for fact in facts["at_work"]))
    assert "\ncase 1 of 2 (" in text
    assert not store.status(tmp_path / "run")["at_work"]
    assert not (tmp_path / "run" / "tmp").exists()


def test_a_resumed_run_counts_all_cases_of_the_grid_as_its_status_does(tmp_path, monkeypatch, phases_seen):
    monkeypatch.setattr(phases, "MIN_ELAPSED", 0.0)
    monkeypatch.setattr(os, "fsync", lambda handle: time.sleep(0.01))  # meanwhile the state is written, as by a disk
    directory, states = tmp_path / "run", []
    sweep(grid(3), directory, executor="serial", show_progress=False)

    class Asking(Fake):
        @staticmethod
        def solve(case, log=None):
            """Ask for the status of the run in which this case is."""
            states.append(store.status(directory))
            return fake_physics.trajectory(case)

    sweep(grid(12), directory, executor="serial", show_progress=False, simulator=Asking)
    assert [words for words in phases_seen if words.endswith("cases, 0 failed")][-1] == "12 of 12 cases, 0 failed"
    assert states[0]["ok"] == 3
    assert states[-1]["ok"] > 3
    for state in states:
        assert state["cases"] == state["ok"] + state["missing"] == 12
        done = int(re.search(r"at present: (\d+) of 12 cases, 0 failed", store.status_text(state))[1])
        assert 3 <= done <= state["ok"]  # the file with the progress may be older than the batches
    assert store.status(directory)["doing"] is None


def test_the_time_left_of_a_run_in_blocks_counts_later_blocks(manual_time):
    cases = driver.CaseProgress(100, "block 2 of 3: ", done=40, later=100)
    with phases.phase(cases):
        for _ in range(21):
            manual_time.now += 1.0
            cases.advance(2, 0)  # two cases a second
            phases.progress()
        assert phases.progress().what == "block 2 of 3: 82 of 100 cases, 0 failed"
        assert phases.progress().left == pytest.approx(0.5 * (18 + 100))


@heavy
def test_short_cases_leave_no_progress_in_files(tmp_path, monkeypatch):
    puts = []
    monkeypatch.setattr(
        store.Working, "replace_progress", lambda self, content: puts.append(content) if content else None
    )
    # progress is written after a second: on a busy machine that is not much for more cases
    assert sweep(grid(30), tmp_path / "run", executor="serial", show_progress=False).ok == 30
    assert not puts


# ---------------------------------------------------------------------------------------------- dry runs


class Steady(Fake):
    """Its cases take 100 s at a steady pace, or as much of that as their time budget allows."""

    compiles = 0.0  # s, of the first case

    @classmethod
    def solve(cls, case, log=None):
        """Return a made-up trajectory, or what a case comes to whose time is over."""
        if cls.compiles:
            with phases.phase(phases.Phase("compiling", once=True)):
                time.sleep(cls.compiles)
            cls.compiles = 0.0
        begin = time.monotonic()
        with phases.phase("running") as running:
            for _ in itertools.count():
                spent = time.monotonic() - begin
                running.note(share=spent / 100.0)
                if spent > case.simulate.time_budget:
                    return Trajectory("time-budget", "", {})
                time.sleep(0.02)


@pytest.mark.slow
@heavy
def test_a_dry_run_of_cases_that_take_long_extrapolates_their_beginning(tmp_path, monkeypatch):
    monkeypatch.setattr(estimate, "PILOT_TIME", 4.0)  # s
    begin = time.monotonic()
    result = estimate.estimate(grid(3), tmp_path / "run", jobs=1, simulator=Steady)
    assert time.monotonic() - begin < 60.0  # of 300 s, on a machine with other work to do
    assert result.extrapolated == result.timed >= 2
    assert result.case_seconds == pytest.approx(100.0, rel=0.1)
    assert result.seconds == pytest.approx(300.0, rel=0.1)
    assert "2 of them extrapolated from" in summary.estimate_text(result._replace(extrapolated=2)._asdict())


@pytest.mark.slow
def test_the_time_of_a_case_is_without_what_it_compiles(monkeypatch):
    monkeypatch.setattr(Steady, "compiles", 1.5)
    case = clearsweep.grid.load(grid(1), Fake.catalogue()).case(0)
    timed = time_case(Steady, case, 1.5)
    assert timed.extrapolated
    assert timed.compiling == pytest.approx(1.5, abs=0.5)
    assert timed.elapsed == pytest.approx(1.5, abs=0.5)
    assert timed.seconds == pytest.approx(100.0, rel=0.1)
    short = case._replace(simulate=case.simulate._replace(time_budget=50.0))
    assert time_case(Steady, short, 1.5).over_budget
    assert time_case(Steady, short, 1.5).seconds == 50.0


def test_a_further_life_that_is_cut_off_is_extrapolated_like_one_before(monkeypatch):
    """Its own life is done, so that its status is ok; the message says that the pilot's patience ended another one."""
    monkeypatch.setattr(phases, "MIN_ELAPSED", 0.2)
    cut = "life-failed: the life with the wear coefficients at their low ends is not known: its block 4 has the status "
    case, solve = clearsweep.grid.load(grid(1), Fake.catalogue()).case(0), Steady.solve
    for status, extrapolated in (("time-budget", True), ("step-budget", False)):

        def solve_own(case, log=None, status=status):
            return dataclasses.replace(solve(case), status="ok", message=cut + status)

        monkeypatch.setattr(Steady, "solve", staticmethod(solve_own))
        timed = time_case(Steady, case, 0.4)
        assert timed.extrapolated == extrapolated
        assert timed.seconds == pytest.approx(100.0 if extrapolated else timed.elapsed, rel=0.1)


def test_the_start_of_workers_is_estimated_without_compiling(monkeypatch, tmp_path):
    """A run after the dry run finds the code in the cache."""
    starts, started = iter([(2.0, 1.5), (0.5, 0.0)]), estimate.start_workers
    monkeypatch.setattr(estimate, "start_workers", lambda *arguments: (started(*arguments)[0], *next(starts)))
    loaded = clearsweep.grid.load(grid(2), Fake.catalogue())
    requested = estimate.requested_cases(loaded, store.RunDirectory(tmp_path / "none"), None, Fake)
    assert estimate.pilot(loaded, requested, 1, Fake).start_up == 0.5
    assert next(starts, None) is None


# ---------------------------------------------------------------------------------------------- unfinished runs


class Full(Fake):
    """The disk is full at the case with the largest mass but two."""

    @staticmethod
    def solve(case, log=None):
        """Return a made-up trajectory, or find no room for it."""
        if case.mechanism.values["slider.mass"] > 0.1025:
            raise StorageError("no room")
        return fake_physics.trajectory(case)


@pytest.mark.parametrize("orbits", ["last", "none"])
def test_the_cases_of_an_unfinished_run_are_read_as_those_of_the_finished_one(tmp_path, orbits):
    with pytest.raises(StorageError):
        sweep(
            grid(5, orbits=orbits, wear=True), tmp_path / "run", executor="serial", show_progress=False, simulator=Full
        )
    with pytest.raises(clearsweep.DirectoryError, match=r"not finished.*--partial"):
        clearsweep.open(tmp_path / "run")
    before = sorted(path.name for path in (tmp_path / "run").rglob("*"))
    run = open_partial(tmp_path / "run", StoredRun, Fake.catalogue)
    assert 0 < len(run) < 5
    assert run.directory == tmp_path / "run"
    assert {key: run.grid["counts"][key] for key in ("cases", "ok", "missing")} == {
        "cases": 5,
        "ok": len(run),
        "missing": 5 - len(run),
    }
    assert run.grid["derived"]
    place = run.files_directory
    assert place.exists()
    assert sorted(path.name for path in (tmp_path / "run").rglob("*")) == before
    whole = sweep(grid(5, orbits=orbits, wear=True), tmp_path / "whole", executor="serial", show_progress=False).open()
    rows = whole.summary[whole.summary["case_id"].isin(run.summary["case_id"])].reset_index(drop=True)
    assert run.summary.equals(rows)
    for case_id in run.summary["case_id"]:
        assert run.orbit(case_id).equals(whole.orbit(case_id))
        assert np.array_equal(run.wear(case_id)["rod_slider"], whole.wear(case_id)["rod_slider"])
    del run
    assert not place.exists()


def test_the_page_of_an_unfinished_run_says_how_many_cases_it_has(tmp_path):
    """Also while another process works there, which has the lock of the directory."""
    with pytest.raises(StorageError):
        sweep(grid(5), tmp_path / "run", executor="serial", show_progress=False, simulator=Full)
    with store.RunDirectory(tmp_path / "run").open_for(clearsweep.grid.load(grid(5), Fake.catalogue())):
        assert store.status(tmp_path / "run")["state"] == "under way"
        run = open_partial(tmp_path / "run", report.Run, Fake.catalogue)
        page = report.write(run, tmp_path / "page.html").read_text(encoding="utf-8")
    there = len(run)
    assert 0 < there < 5
    assert "The run is not complete: the answer covers the cases that are finished so far." in page
    assert f"none failed, {5 - there} not run yet" in page
    whole = sweep(grid(5), tmp_path / "whole", executor="serial", show_progress=False)
    page = report.write(report.open(whole.directory), tmp_path / "whole.html").read_text(encoding="utf-8")
    assert "not finished" not in page


@pytest.mark.parametrize("method", ["sobol", "saltelli"])
def test_the_page_of_an_unfinished_sample_has_its_finished_cases(tmp_path, method):
    over = {"mechanism.slider.mass": {"uniform": ["0.1 kg", "0.105 kg"]}, "drive.speed": {"uniform": [10, 20]}}
    drawn = fake_physics.grid(sample={"method": method, "n": 16, "seed": 3, "over": over})
    drawn.pop("sweep")
    drawn["limits"] = {"rod_slider_force_peak": "1 N"}
    with pytest.raises(StorageError):
        sweep(drawn, tmp_path / "run", executor="serial", show_progress=False, simulator=Full)
    run = open_partial(tmp_path / "run", report.Run, Fake.catalogue)
    page = report.write(run, tmp_path / "page.html").read_text(encoding="utf-8")
    finished, missing = run.grid["counts"]["ok"], run.grid["counts"]["missing"]
    assert finished > 0 < missing
    assert "The run is not complete: the answer covers the cases that are finished so far." in page
    (sample,) = effects.samples_of(run)
    assert sample.is_finished().sum() == finished
    assert np.isfinite(sample.figures["rod_slider_force_peak"]).sum() == finished
    if method == "saltelli":
        assert f"a sensitivity needs every case of its design, and {missing} have no result" in html.unescape(page)


def test_a_finished_run_is_opened_as_it_is_and_an_empty_one_is_refused(tmp_path):
    sweep(grid(2), tmp_path / "run", executor="serial", show_progress=False)
    run = clearsweep.open(tmp_path / "run", partial=True)
    assert run.files_directory == run.directory
    with pytest.raises(StorageError):
        sweep(grid(1, sweep={"mechanism.slider.mass": [0.2]}), tmp_path / "none", executor="serial", simulator=Full)
    with pytest.raises(clearsweep.DirectoryError, match="no case of its run is finished yet"):
        clearsweep.open(tmp_path / "none", partial=True)


# ---------------------------------------------------------------------------------------------- real cases

PLAIN = {"simulate.discard": 0, "simulate.tolerance": 1e-5}


def real_case(**changes):
    """Return a short case of a slider-crank, with other settings."""
    return clearsweep.load_case(slider_crank("rod-slider", changes=PLAIN | changes)).case


@heavy
def test_what_a_case_takes_beside_its_integration_is_its_setup_time(monkeypatch):
    def slow(*arguments):
        end = time.thread_time() + 0.4
        while time.thread_time() < end:
            pass
        return ideal_peaks(*arguments)

    case, ideal_peaks = real_case(**{"simulate.revolutions": 0.1}), outcome.ideal_peaks
    simulation.solve(case)  # compiles and loads
    quick = simulation.solve(case).summary["setup_time"]
    monkeypatch.setattr(outcome, "ideal_peaks", slow)
    begin = time.thread_time()
    result = simulation.solve(case)
    spent = time.thread_time() - begin
    assert 0.0 < quick < result.summary["setup_time"] - 0.3
    assert 0.4 < result.summary["setup_time"] <= spent - result.summary["run_time"] + 1e-6
    assert result.units["setup_time"] == "s"


@heavy
def test_times_of_a_case_are_those_of_the_processor(monkeypatch):
    """A case that waits for the processor takes no longer."""

    def waiting(*arguments):
        time.sleep(0.4)
        return integrate(*arguments)

    case, integrate = real_case(**{"simulate.revolutions": 0.1}), loop.integrate
    monkeypatch.setattr(loop, "integrate", waiting)
    summary = simulation.solve(case).summary
    assert 0.0 < summary["run_time"] < 0.2
    assert 0.0 < summary["setup_time"] < 0.2


@pytest.mark.slow
@heavy
@pytest.mark.compiled
def test_the_time_of_a_long_case_is_extrapolated_from_its_first_revolutions():
    time_case(SIMULATION, real_case(), 0.5)  # compiles and loads
    short, long = (
        time_case(
            SIMULATION, real_case(**{"simulate.revolutions": n, "simulate.time_budget": 1e9}), 2.0 * phases.MIN_ELAPSED
        )
        for n in (1e6, 1e7)
    )
    assert short.extrapolated
    assert long.extrapolated
    assert short.elapsed < 30.0  # s, on a machine with other work to do
    assert 4.0 < long.seconds / short.seconds < 25.0


@pytest.mark.slow
@heavy
@pytest.mark.compiled
def test_the_time_of_a_life_is_extrapolated_from_its_first_block():
    life = {
        "joints.rod-slider.wear": {"law": "archard", "coefficient": 1e-16, "evolve": True, "bins": 36},
        "life": {"limit": 50e-6, "of": "wear_depth_max", "joint": "rod-slider", "max_revolutions": 1e6},
        "simulate.revolutions": 1e5,
    }
    case = real_case(**life)
    _, timed = (time_case(SIMULATION, case, 2.0) for _ in range(2))  # the first one compiles and loads
    assert timed.extrapolated
    assert timed.seconds > 5.0 * timed.elapsed
    assert timed.elapsed < 30.0
