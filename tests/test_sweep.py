"""A sweep does every case once, whatever is killed, and says what became of each."""

import json
import os
import re
import resource
import signal
import subprocess
import sys
import time
from pathlib import Path

import fake_physics
import h5py
import numpy as np
import psutil
import pytest
import torture
from fake_physics import DIES, FAILS, GOOD, HANGS, LOCKS, RAISES, REFUSED, Fake, grid, sweep
from mechanism_cases import slider_crank

from clearsweep import grid as grids
from clearsweep import simulation, store
from clearsweep.contracts.results import Trajectory
from clearsweep.language import errors, phases
from clearsweep.sweeping import estimate
from clearsweep.sweeping.merge import complete_run
from clearsweep.sweeping.pool import case_runner, executors, forks
from clearsweep.sweeping.pool.case_runner import SIMULATION
from clearsweep.sweeping.pool.driver import Batches
from clearsweep.sweeping.pool.worker import BatchOutcome
from clearsweep.sweeping.summary import case_lines, estimate_text, of_run, run_text
from clearsweep.sweeping.sweep import facts

pytestmark = pytest.mark.heavy

HERE = Path(__file__).parent


def quiet(source, out, **options):
    return sweep(source, out, show_progress=False, **options)


def program(out, source, session=False, **options):
    """Start the sweep as a program of its own, with its workers in a group of processes of its own if asked to."""
    arguments = [sys.executable, str(HERE / "sweep_made_up.py"), str(out), json.dumps(source), json.dumps(options)]
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(HERE), str(HERE.parent)])}
    return subprocess.Popen(
        arguments,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=environment,
        start_new_session=session,
    )


def facts_of(process):
    out, err = process.communicate(timeout=300)
    assert out, err
    return json.loads(out)


def same_results(first: Path, other: Path) -> bool:
    """Tell whether two directories hold the same rows and orbits, timings aside."""
    return torture.same(torture.differences(first, other))


def wait_for(condition, seconds=30.0):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "did not happen in time"
        time.sleep(0.01)


def has_ended(process):
    """Return whether a process has ended, even if the one that adopted it has not asked for its code yet."""
    try:
        return process.status() == psutil.STATUS_ZOMBIE
    except psutil.NoSuchProcess:
        return True


def parts(out) -> int:
    return len(list(Path(out).glob("parts/*.parquet")))


def test_every_case_runs_and_the_next_run_has_nothing_left_to_do(tmp_path):
    first = quiet(grid(6, wear=True), tmp_path / "run")
    assert (first.cases, first.ran, first.reused, first.ok, first.exit_code) == (6, 6, 0, 6, 0)
    before = (tmp_path / "run" / "summary.parquet").read_bytes()
    again = quiet(grid(6, wear=True), tmp_path / "run", executor="serial")
    assert (again.ran, again.reused, again.ok) == (0, 6, 6)
    assert (tmp_path / "run" / "summary.parquet").read_bytes() == before


def test_a_larger_grid_runs_only_what_is_new_and_a_smaller_one_shows_only_its_own(tmp_path):
    quiet(grid(3), tmp_path / "run", executor="serial")
    assert quiet(grid(5), tmp_path / "run", executor="serial").ran == 2
    smaller = quiet(grid(2), tmp_path / "run", executor="serial")
    assert (smaller.ran, smaller.others) == (0, 3)
    assert "3 cases with other values on the axes stay stored" in run_text(of_run(smaller))
    assert len(smaller.open().summary) == 2
    with complete_run(tmp_path / "run", Fake) as run:
        every = run.summary
        assert run.grid["sweep"]["mechanism.slider.mass"] == [0.1 + 0.001 * k for k in (0, 1, 2, 3, 4)]
    assert len(smaller.open().summary) == 2
    larger = quiet(grid(5), tmp_path / "run", executor="serial")
    assert (larger.ran, larger.others) == (0, 0)
    assert every.equals(larger.open().summary)


@pytest.mark.parametrize("masses", [[0.1, 0.2, 0.3], [0.4]])
def test_all_cases_of_a_directory_whose_axes_go_in_step_are_one_run(tmp_path, masses):
    for values in ([0.1, 0.2], masses):
        source = grid(cases={"mechanism.slider.mass": values, "mechanism.gravity": [GOOD] * len(values)})
        del source["sweep"]
        quiet(source, tmp_path / "run", executor="serial")
    with complete_run(tmp_path / "run", Fake) as run:
        assert sorted(run.summary["mechanism.slider.mass"]) == sorted({0.1, 0.2, *masses})


def test_serial_and_parallel_runs_leave_the_same(tmp_path):
    quiet(grid(7, wear=True), tmp_path / "serial", executor="serial")
    quiet(grid(7, wear=True), tmp_path / "parallel", jobs=2)
    assert same_results(tmp_path / "serial", tmp_path / "parallel")


class Unhurried(Fake):
    """Its cases end in a process that gives them a second, and nowhere else."""

    @staticmethod
    def solve(case):
        """Return a made-up trajectory, or that of a case whose time is up."""
        is_up = case.simulate.time_budget < 1.0
        return Trajectory("time-budget", "its time is up", {}) if is_up else fake_physics.trajectory(case)


@pytest.mark.parametrize(
    ("simulator", "options", "pools"),
    [
        (Fake, {}, 0),
        (Fake, {"case_timeout": 9.0}, 1),  # only another process ends a case in time
        (Unhurried, {}, 1),  # what takes longer is not stored, but done by a worker
    ],
)
def test_few_cheap_cases_need_no_other_process(tmp_path, monkeypatch, simulator, options, pools):
    monkeypatch.setattr(case_runner, "SIMULATION", simulator)
    started, start = [], executors.EXECUTORS["local"]
    monkeypatch.setitem(executors.EXECUTORS, "local", lambda *given: [started.append(given), start(*given)][1])
    quiet(grid(7, wear=True), tmp_path / "run", simulator=simulator, jobs=2, **options)
    quiet(grid(7, wear=True), tmp_path / "workers", jobs=2, executor="serial")
    assert len(started) == pools
    assert same_results(tmp_path / "run", tmp_path / "workers")


@pytest.mark.parametrize(
    ("seconds", "jobs", "workers"), [(1.9, 1, False), (0.5, 2, False), (1.9, 2, True), (9, 1, True)]
)
def test_workers_are_started_where_they_save_more_than_they_take(seconds, jobs, workers):
    assert case_runner.is_worth_workers(seconds, jobs) == workers


def test_failures_become_rows_with_their_reason_and_the_others_continue(tmp_path):
    result = quiet(grid(2, (GOOD, REFUSED, RAISES, FAILS, DIES, HANGS)), tmp_path / "run", case_timeout=0.3)
    assert (result.ok, result.failed, result.missing, result.exit_code) == (2, 10, 0, 3)
    summary = result.open().summary
    messages = {row["mechanism.gravity"]: (row["status"], row["message"]) for _, row in summary.iterrows()}
    assert messages[GOOD] == ("ok", "")
    assert messages[REFUSED] == ("refused", "mechanism: cannot be put together")
    assert messages[RAISES] == ("crashed", "ZeroDivisionError: made to fail")
    assert messages[FAILS] == ("step-budget", "the step budget was used up")
    assert messages[DIES] == ("crashed", "its worker died twice (SIGKILL, perhaps out of memory)")
    assert messages[HANGS][0] == "timeout"
    assert "0.3 s" in messages[HANGS][1]


def test_a_run_that_stopped_with_too_many_failures_is_not_finished(tmp_path):
    result = quiet(grid(20, (FAILS,)), tmp_path / "run", executor="serial", max_failures=2)
    assert result.missing > 0
    facts = store.status(tmp_path / "run")
    assert (facts["state"], facts["missing"]) == ("interrupted", result.missing)
    removed = store.clean(tmp_path / "run", batches=True)
    assert (removed["finished"], removed["removed"]) == (False, [])


def test_a_crash_in_a_batch_costs_the_others_nothing(tmp_path):
    result = quiet(
        grid(
            30,
            (GOOD, DIES),
            sweep={
                "mechanism.gravity": [GOOD, 0.001, 0.002, 0.003, 0.004, DIES],
                "mechanism.slider.mass": [0.1 + 0.001 * k for k in range(2)],
            },
        ),
        tmp_path / "run",
        jobs=2,
    )
    assert (result.ok, result.failed, result.missing) == (10, 2, 0)


def test_failed_cases_run_again_only_when_asked(tmp_path):
    quiet(grid(2, (GOOD, FAILS)), tmp_path / "run", executor="serial")
    kept = quiet(grid(2, (GOOD, FAILS)), tmp_path / "run", executor="serial")
    assert (kept.ran, kept.failed, kept.exit_code) == (0, 2, 3)
    assert quiet(grid(2, (GOOD, FAILS)), tmp_path / "run", executor="serial", retry_failed=True).ran == 2


@pytest.mark.parametrize("limit", [3, "1%"])
def test_too_many_failures_stop_the_run(tmp_path, limit):
    result = quiet(grid(400, (FAILS,)), tmp_path / "run", max_failures=limit, jobs=2)
    assert 3 < result.failed < 400
    assert result.missing == 400 - result.failed
    assert result.exit_code == 3
    assert len(result.open().summary) == result.failed


def test_a_damaged_shard_is_named_and_computed_again(tmp_path, capfd):
    quiet(grid(6, wear=True), tmp_path / "run", executor="serial")
    quiet(grid(6, wear=True), tmp_path / "whole", executor="serial")
    shard = sorted((tmp_path / "run" / "shards").iterdir())[0]
    content = bytearray(shard.read_bytes())
    content[-100] ^= 255
    shard.write_bytes(content)
    assert quiet(grid(6, wear=True), tmp_path / "run", executor="serial").ran > 0
    assert f"shards/{shard.name}: damaged" in capfd.readouterr().err
    assert same_results(tmp_path / "run", tmp_path / "whole")


def tortured(tmp_path, kills, seed):
    """Kill parents and workers at random moments, go on each time, and compare what is left with undisturbed runs."""
    source = grid(40, (GOOD + 0.02,), wear=True)
    quiet(source, tmp_path / "undisturbed", executor="serial")

    def start(out, **options):
        return program(out, source, jobs=2, show_progress=False, **options)

    for each in torture.torture(start, tmp_path, kills, seed, (0.1, 0.9)):
        assert same_results(tmp_path / "undisturbed", each.out)
        assert each.lost_cases() == 0
        assert not (each.out / "tmp").exists()
        assert parts(each.out) == len(list((each.out / "shards").iterdir()))


@pytest.mark.parametrize("name", ["orbits.h5", "summary.parquet"])
def test_a_merged_file_that_was_damaged_or_lost_is_made_again(tmp_path, name):
    out = tmp_path / "run"
    quiet(grid(6, wear=True), out, executor="serial")
    whole, before = (out / name).read_bytes(), (out / name).stat().st_mtime_ns
    quiet(grid(6, wear=True), out, executor="serial")
    assert (out / name).stat().st_mtime_ns == before  # nothing to do: left as it is
    for harm in (whole[:-7], whole[:300] + bytes([whole[300] ^ 1]) + whole[301:], None):
        (out / name).unlink()
        if harm is not None:
            (out / name).write_bytes(harm)
        assert quiet(grid(6, wear=True), out, executor="serial").ran == 0
        assert (out / name).read_bytes() == whole


def test_histories_are_on_the_disk_once_and_damage_to_them_costs_their_cases_alone(tmp_path):
    out = tmp_path / "run"
    quiet(grid(6, wear=True), out, executor="serial")
    (shard,) = (out / "shards").iterdir()
    assert shard.samefile(out / "orbits.h5")
    assert quiet(grid(9, wear=True), out, executor="serial").ran == 3  # the first six are read from the merged file
    for cases, kept in ((2, 9), (9, 9)):  # a smaller grid keeps the histories of the others
        assert quiet(grid(cases, wear=True), out, executor="serial").ran == 0
        (shard,) = (out / "shards").iterdir()
        with h5py.File(shard) as file:
            assert len(file["case_id"]) == kept
    assert shard.samefile(out / "orbits.h5")
    limited = grid(9, wear=True) | {"limits": {"rod_slider_force_peak": "1 N"}}
    assert quiet(limited, out, executor="serial").ran == 0
    (shard,) = (out / "shards").iterdir()
    assert shard.samefile(out / "orbits.h5")
    assert quiet(grid(9, wear=True), out, executor="serial").ran == 0
    quiet(grid(9, wear=True), tmp_path / "whole", executor="serial")
    assert same_results(out, tmp_path / "whole")
    with open(out / "orbits.h5", "r+b") as file:
        file.write(b"damaged")
    assert quiet(grid(9, wear=True), out, executor="serial").ran > 0
    assert same_results(out, tmp_path / "whole")


def test_kill_9_at_any_moment_loses_nothing_that_was_committed(tmp_path):
    tortured(tmp_path, kills=3, seed=1)


@pytest.mark.slow
def test_a_hundred_kills_lose_nothing_that_was_committed(tmp_path):
    tortured(tmp_path, kills=100, seed=2)


@pytest.mark.few("15-143")
@pytest.mark.parametrize(("signum", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_signal_stops_the_run_soon_and_keeps_what_is_finished(tmp_path, signum, code):
    source = grid(60, (GOOD + 0.03,))
    process = program(tmp_path / "run", source, jobs=2, show_progress=False)
    wait_for(lambda: parts(tmp_path / "run") >= 2)
    children = psutil.Process(process.pid).children(recursive=True)
    asked = time.monotonic()
    process.send_signal(signum)
    _, err = process.communicate(timeout=20)
    assert process.returncode == code
    assert time.monotonic() - asked < 5.0
    assert "run the same command again" in err
    wait_for(lambda: all(map(has_ended, children)), 3.0)
    kept = int(err.split("stopped: ")[1].split(" of")[0])
    resumed = quiet(source, tmp_path / "run", jobs=2)
    assert resumed.reused == kept > 0


@pytest.mark.slow
def test_a_signal_ends_even_a_run_whose_cases_hang(tmp_path):
    process = program(tmp_path / "run", grid(4, (GOOD, HANGS)), jobs=2, show_progress=False)
    wait_for(lambda: list(Path(tmp_path).glob("run/tmp/*.note")))
    time.sleep(0.5)
    children = psutil.Process(process.pid).children(recursive=True)
    asked = time.monotonic()
    process.send_signal(signal.SIGINT)
    time.sleep(0.3)
    process.send_signal(signal.SIGINT)
    process.communicate(timeout=20)
    assert process.returncode == 130
    assert time.monotonic() - asked < 3.0
    wait_for(lambda: all(map(has_ended, children)), 3.0)


def test_workers_die_with_a_parent_that_is_killed(tmp_path):
    process = program(tmp_path / "run", grid(4, (HANGS,)), jobs=2, show_progress=False)
    wait_for(lambda: list(Path(tmp_path).glob("run/tmp/*.note")))
    children = psutil.Process(process.pid).children(recursive=True)
    assert len(children) >= 2
    process.kill()
    wait_for(lambda: all(map(has_ended, children)), 3.0)
    process.communicate(timeout=20)


@pytest.mark.few("9-False")
@pytest.mark.parametrize(
    ("signum", "is_server"), [(signal.SIGKILL, False), (signal.SIGKILL, True), (signal.SIGTERM, False)]
)
def test_a_worker_that_is_ended_and_the_server_that_forks_them_cost_no_case(tmp_path, signum, is_server):
    source = grid(60, (GOOD + 0.03,))
    process = program(tmp_path / "run", source, jobs=2, show_progress=False)
    wait_for(lambda: parts(tmp_path / "run") >= 2)
    family = psutil.Process(process.pid).children(recursive=True)
    processes = [each for each in family if "resource_tracker" not in " ".join(each.cmdline())]
    victims = [each for each in processes if bool(each.children()) is is_server]
    if victims:  # only Linux has a server
        victims[0].send_signal(signum)
    assert victims or sys.platform != "linux"
    assert facts_of(process)["failed"] == 0
    assert process.returncode == 0


def test_a_worker_killed_with_the_lock_stalls_the_others_for_seconds_only(tmp_path):
    result = quiet(grid(1, (GOOD, 0.001, 0.002, LOCKS, 0.004)), tmp_path / "run", jobs=2)
    assert (result.ok, result.failed, result.missing) == (4, 1, 0)
    assert result.open().summary.query("status != 'ok'")["status"].tolist() == ["crashed"]
    assert result.seconds < 20.0


def test_a_second_run_in_the_same_directory_is_refused(tmp_path):
    process = program(tmp_path / "run", grid(20, (GOOD + 0.2,)), jobs=1, show_progress=False)
    wait_for(lambda: parts(tmp_path / "run") >= 1)
    with pytest.raises(errors.DirectoryError, match="another run works here"):
        quiet(grid(20, (GOOD + 0.2,)), tmp_path / "run")
    process.kill()
    process.communicate(timeout=20)


@pytest.mark.few("2000-tmp|parts|shards")
@pytest.mark.parametrize(("limit", "fails"), [(2000, r"tmp|parts|shards"), (150_000, "writing failed")])
def test_storage_that_fails_stops_the_run_and_harms_nothing(tmp_path, limit, fails):
    """`limit`: bytes that a file may have; no batch fits any more, or every batch but not the merged histories."""
    pause = 0.002 if limit < 10_000 else 0.02  # s, as short as leaves several batches
    small, source = (
        grid(count, (GOOD + pause,), orbits="all", wear=True, simulate={"revolutions": 10}) for count in (3, 120)
    )
    quiet(small, tmp_path / "run", executor="serial")
    before = {path.name: path.read_bytes() for path in (tmp_path / "run" / "parts").iterdir()}
    allowed = resource.getrlimit(resource.RLIMIT_FSIZE)
    try:
        resource.setrlimit(resource.RLIMIT_FSIZE, (limit, allowed[1]))
        process = program(tmp_path / "run", source, jobs=2, show_progress=False)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, allowed)
    _, err = process.communicate(timeout=60)
    assert process.returncode == 4, err
    assert re.search(f"StorageError: .*({fails}).*safe: make room and run the same command again", err)
    after = {path.name: path.read_bytes() for path in (tmp_path / "run" / "parts").iterdir()}
    assert before.items() <= after.items()
    resumed = quiet(source, tmp_path / "run", executor="serial")
    assert resumed.reused == (3 if limit < 10_000 else 120)
    quiet(source, tmp_path / "whole", executor="serial")
    assert same_results(tmp_path / "whole", tmp_path / "run")


@pytest.mark.slow
@pytest.mark.parametrize("counts", [(100, 10_000), (1000, 100_000)])
def test_the_parent_grows_by_less_than_50_mb_with_a_hundred_times_the_cases(tmp_path, counts):
    peaks = []
    for count in counts:
        source = grid(orbits="none", sweep={"mechanism.slider.mass": {"linspace": [0.1, 0.3, count]}})
        process = program(tmp_path / str(count), source, show_progress=False)
        result = facts_of(process)
        assert result["ran"] == count
        assert set(result["slow"]) <= (set() if count == 100 else {"pyarrow.compute"})
        peaks.append(result["peak"])
    assert peaks[1] - peaks[0] < 50_000, peaks  # kB


def test_one_worker_has_one_thread(tmp_path, monkeypatch):
    for name in forks.THREAD_VARIABLES:
        monkeypatch.setenv(name, "7")
    workers = forks.Local(1)
    try:
        inside = workers.submit(os.getenv, "OPENBLAS_NUM_THREADS").result()
    finally:
        workers.close()
    assert inside == "1"
    assert os.environ["OPENBLAS_NUM_THREADS"] == "7"


def test_batches_grow_to_about_two_seconds_and_shrink_towards_the_end():
    batches = Batches(np.arange(10_000), np.arange(10_000, dtype="u8"), 2, 0.0)
    sizes = []
    while batch := batches.next():
        sizes.append(len(batch.cases))
        batches.times.add(BatchOutcome("x", len(batch.cases), 0, 0.01 * len(batch.cases)))
    assert sum(sizes) == 10_000
    assert sizes[:3] == [1, 8, 64]
    assert max(sizes) == 200
    assert 2 * sizes[-1] <= 60


def test_batches_with_large_histories_stay_small():
    batches = Batches(np.arange(1000), np.arange(1000, dtype="u8"), 2, 8e6)
    batches.times.add(BatchOutcome("x", 500, 0, 0.5))
    assert len(batches.next().cases) == 4


def test_a_dry_run_counts_times_and_writes_nothing(tmp_path, monkeypatch):
    starts, started = [], estimate.start_workers

    def timed(*given):
        workers, start_up, compiled = started(*given)
        starts.append(start_up)
        return workers, start_up, compiled

    monkeypatch.setattr(estimate, "start_workers", timed)
    result = estimate.estimate(grid(50, (GOOD + 0.02,), wear=True), tmp_path / "run", jobs=2, simulator=Fake)
    assert (result.cases, result.pending) == (50, 50)
    assert result.derived["joints.rod-slider.contact.stiffness"]["max"] == 6.61e10
    assert 0.02 < result.case_seconds < 0.1
    assert 0.5 < result.seconds - starts[-1] - 25 * result.case_seconds < 5.0  # what is not measured by itself
    assert not (tmp_path / "run").exists()
    quiet(grid(50, (GOOD + 0.02,), wear=True), tmp_path / "run", executor="serial")
    size = sum(path.stat().st_size for path in (tmp_path / "run").rglob("*"))
    assert 0.3 * size < result.bytes < 3.0 * size


def test_a_run_without_workers_is_refused_before_anything_is_written(tmp_path):
    with pytest.raises(errors.InputError, match="jobs"):
        quiet(grid(1), tmp_path / "run", jobs=0)
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize(("angle", "warned"), [(90, True), ("90 deg", False), (1.5, False)])
def test_an_angle_of_many_turns_without_a_unit_is_warned_of(angle, warned):
    read = grids.load(slider_crank("rod-slider", changes={"drive.start_angle": angle}), simulation.catalogue())
    text = "drive.start_angle: 90 without a unit is 90 rad, or 5157 deg; write 90 deg if that is meant"
    assert (text in facts(read, SIMULATION)[1]) == warned


def test_a_dry_run_shows_a_case_and_what_si_is_assumed_for(tmp_path):
    source = grid(2, drive={"speed": 100})
    source["joints"]["rod-slider"]["length"] = 0.02
    source["sweep"]["mechanism.slider.mass"] = [0.1, 0.101]
    result = estimate.estimate(source, tmp_path / "run", simulator=Fake)
    assert result.assumed["drive.speed"] == {"unit": "rad/s", "values": [100.0]}
    assert result.assumed["mechanism.slider.mass"] == {"unit": "kg", "values": [0.1, 0.101]}
    assert "joints.rod-slider.length" in result.assumed
    assert "joints.rod-slider.clearance" not in result.assumed  # 0.5 mm
    assert result.case["values"]["joints.rod-slider.clearance"] == 0.5e-3
    text = estimate_text(result._asdict())
    assert "no unit given, SI assumed: drive.speed = 100 rad/s = 954.93 rpm\n" in text
    assert "no unit given, SI assumed: mechanism.slider.mass = 0.1 to 0.101 kg" in text
    assert "  joints.rod-slider: clearance 0.5 mm, bearing_radius 10 mm, length 20 mm" in text


def test_a_dry_run_sums_up_a_table():
    column = "loads.gas.table.fx"
    case = {"case_id": "0" * 40, "units": {}, "written_units": {}}
    values = {"loads.gas.scale": 1.0, f"{column}.0": 5.0, f"{column}.1": -700.0, f"{column}.2": 2.0}
    lines = case_lines(case | {"values": values})
    assert lines[1:] == ["  loads.gas: scale 1", f"  {column}: 3 values in SI, -700 to 5"]


def test_what_a_first_case_compiles_and_cases_that_differ_do_not_spoil_the_estimate():
    counts = np.bincount(np.array(estimate.timed_indices(6400)) // 100)
    assert counts.tolist() == [1] * 64  # one of each stretch
    assert len(set(np.array(estimate.timed_indices(6400)) % 5)) == 5  # of an axis of five values each is met
    assert sorted(estimate.timed_indices(3)) == [0, 1, 2]


class Warming(Fake):
    """Its first case of all compiles something for a second."""

    solved = 0

    @classmethod
    def solve(cls, case):
        """Return a made-up trajectory."""
        cls.solved += 1
        if cls.solved == 1:
            with phases.phase(phases.Phase("compiling", once=True)):
                time.sleep(1.0)
        time.sleep(0.01)
        return fake_physics.trajectory(case)


def test_the_time_that_a_first_case_compiles_is_no_part_of_the_estimate(tmp_path, monkeypatch):
    monkeypatch.setattr(estimate, "PILOT_TIME", 0.5)  # s: less than the first case takes
    result = estimate.estimate(grid(20), tmp_path / "run", jobs=1, simulator=Warming)
    assert result.case_seconds < 0.05
    assert result.timed > 3


def test_the_loop_and_a_scene_compile_at_once_in_two_workers(tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    assert quiet(grid(), tmp_path / "run", simulator=fake_physics.Together, jobs=2).ok == 3
    assert "compiling in advance failed" not in capfd.readouterr().err
