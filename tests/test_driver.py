"""The driver survives what executors do to it: pools that break, workers that vanish or leave early."""

import pickle
import subprocess
from concurrent.futures import BrokenExecutor, Future

import numpy as np
import pytest
from fake_physics import CATALOGUE, Fake, OtherVersion, grid, sweep

from clearsweep import grid as grids
from clearsweep import store
from clearsweep.language.errors import ClearsweepError
from clearsweep.sweeping.pool import driver as driving
from clearsweep.sweeping.pool import executors
from clearsweep.sweeping.pool.case_runner import compile_all
from clearsweep.sweeping.pool.driver import Batches, CaseProgress, Driver
from clearsweep.sweeping.pool.worker import BatchOutcome, RunContext, run_batch

CASES = 12


class Unreliable(executors.Serial):
    """Runs batches here, but first does what `trouble` says, one word per batch."""

    def __init__(self, *trouble):
        super().__init__()
        self.trouble = list(trouble)
        self.restarts = 0
        self.died = set()  # cases that have ended a worker

    def restart(self):
        """Count the restarts."""
        self.restarts += 1

    def submit(self, function, *args):
        """Run a batch, or lose it in the way that is due."""
        word = self.trouble.pop(0) if self.trouble else "well"
        if word == "refuse":
            raise RuntimeError("the pool is broken")
        if word == "well":
            return super().submit(function, *args)
        return getattr(self, word)(*args)

    def breaks(self, _job, _batch):
        """Fail with all that is under way."""
        future = Future()
        future.set_exception(BrokenExecutor("all workers are gone"))
        return future

    def commits_then_breaks(self, context, batch):
        """Lose the outcome of a batch that was committed."""
        run_batch(context, batch)
        return self.breaks(context, batch)

    def vanishes(self, context, batch):
        """Leave the status of a process that is no more, and never answer."""
        gone = subprocess.Popen(["true"])
        gone.wait()
        context.status_file(batch).write_text(f"{gone.pid} 0\n")
        return Future()

    def vanishes_once_with_each_case(self, context, batch):
        """Do so if the first case of a batch has not done it before."""
        case = batch.cases[0].case_id
        if case in self.died:
            return super().submit(run_batch, context, batch)
        self.died.add(case)
        return self.vanishes(context, batch)

    def leaves_early(self, context, batch):
        """Commit the first case alone, as a worker does that is asked to go."""
        return super().submit(run_batch, context, batch._replace(cases=batch.cases.part(0, 1)))


#: What a task of somebody else's answers in place of a batch: (context, batch) -> the answer; and what is said of it.
LIES = {
    "a number": (lambda context, batch: 42, "it is int, not the outcome of a batch"),
    "nothing": (lambda context, batch: None, "it is NoneType"),
    "a count below 0": (lambda context, batch: BatchOutcome(None, -1, 0, 0.0), "it counts -1 finished"),
    "too many cases": (lambda context, batch: BatchOutcome("x", 10**9, 0, 0.0), "it counts 1000000000 finished"),
    "a count of words": (lambda context, batch: BatchOutcome("x", "1", 0, 0.0), "it counts '1' finished"),
    "endless time": (lambda context, batch: BatchOutcome("x", 1, 0, float("inf")), "it took inf s"),
    "no file": (lambda context, batch: BatchOutcome(None, 1, 0, 0.0), "it finished 1 cases and committed None"),
    "a file elsewhere": (
        lambda context, batch: BatchOutcome(f"../../{batch.name}-{'0' * 16}.parquet", 1, 0, 0.0),
        "which is none of its files",
    ),
    "a file of another batch": (
        lambda context, batch: BatchOutcome(f"{'0' * 16}-{'0' * 16}.parquet", 1, 0, 0.0),
        "which is none of its files",
    ),
    "other cases": (
        lambda context, batch: run_batch(context, batch._replace(cases=batch.cases.part(1, 2)))._replace(
            failed_count=0
        ),
        "has other cases than the batch",
    ),
    "no case, for ever": (lambda context, batch: BatchOutcome(None, 0, 0, 0.0), "no case of it is finished"),
}


class Liar(executors.Serial):
    """Runs the first batch, and answers every later one with a lie."""

    def __init__(self, lie):
        super().__init__()
        self.lie, self.batches = lie, 0

    def submit(self, function, *args):
        """Answer a batch."""
        self.batches += 1
        return super().submit(function if self.batches == 1 else self.lie, *args)


@pytest.mark.parametrize("name", LIES)
def test_a_strange_answer_ends_the_run_in_a_sentence_and_costs_no_case(driven, tmp_path, name):
    lie, said = LIES[name]
    with pytest.raises(ClearsweepError, match=r"as no worker of this run answers: .*nobody else uses") as caught:
        driven(Liar(lie))
    assert said in str(caught.value)
    result = sweep(grid(CASES), tmp_path / "run", executor="serial", show_progress=False)
    assert (result.ok, result.missing, result.failed) == (CASES, 0, 0)
    assert 0 < result.reused < CASES


@pytest.fixture
def driven(tmp_path):
    """Return a function that drives twelve cases with an executor and returns (driver, ids stored, ids wanted)."""
    held_grid = grids.load(grid(CASES), CATALOGUE)
    ids = np.array([int(held_grid.case_id(i), 16) for i in range(CASES)], "u8")

    def drive_with(executor):
        with store.RunDirectory(tmp_path / "run").open_for(held_grid) as contents:
            batches = Batches(np.arange(CASES), ids, 1, 0.0)
            batches.times.add(BatchOutcome("x", 4, 0, 4.0))  # of four slow cases: batches of several, not of all
            context = RunContext(contents.path, held_grid, Fake)
            driver = Driver(executor, contents, context, batches, None, CaseProgress(CASES))
            assert driver.run()
            rows = contents.rows()
            assert not rows["failed"].any()
            assert sum(len(batch.ids) for batch in contents.batches) == CASES, "a case ran twice"
            return driver, rows["id"], np.sort(ids)

    return drive_with


@pytest.mark.parametrize("trouble", ["refuse", "breaks", "commits_then_breaks", "vanishes", "leaves_early"])
def test_every_case_is_stored_once_in_spite_of(driven, trouble, monkeypatch):
    monkeypatch.setattr(driving, "DEATH_TIMEOUT", 0.1)
    executor = Unreliable("well", trouble, trouble)
    driver, stored, expected = driven(executor)
    np.testing.assert_array_equal(stored, expected)
    assert driver.ran == CASES
    assert executor.restarts == (2 if trouble in ("refuse", "breaks", "commits_then_breaks") else 0)


def test_a_case_is_given_up_only_when_a_second_worker_has_died_with_it(driven, monkeypatch):
    monkeypatch.setattr(driving, "DEATH_TIMEOUT", 0.02)
    monkeypatch.setattr(driving, "CHECK_INTERVAL", 0.01)
    executor = Unreliable(*["vanishes_once_with_each_case"] * 10 * CASES)
    _, stored, expected = driven(executor)
    np.testing.assert_array_equal(stored, expected)
    assert len(executor.died) == CASES


@pytest.mark.parametrize(
    ("code", "cause"),
    [(None, "unknown cause"), (3, "exit code 3"), (-11, "SIGSEGV"), (-35, "signal 35")],
)
def test_the_cause_of_a_death_is_named(code, cause):
    assert driving.death_cause(code) == cause


def test_a_pool_that_breaks_while_it_compiles_is_replaced(tmp_path):
    executor = Unreliable("refuse")
    assert compile_all(executor, [None], Fake, tmp_path) == 0.0
    assert executor.restarts == 1


def test_batches_reach_their_length_soon_after_a_slow_first_case():
    batches, sizes = Batches(np.arange(100_000), np.zeros(100_000, "u8"), 2, 0.0), []
    for seconds in (30.0, *[0.0] * 9):
        sizes.append(len(batches.next().cases))
        batches.times.add(BatchOutcome("x", sizes[-1], 0, seconds + 1e-3 * sizes[-1]))
    assert sizes[-1] > 0.9 * driving.TARGET_SECONDS / 1e-3


def test_batches_of_the_next_block_begin_as_long_as_those_of_the_last_one():
    times = driving.CaseTimes()
    last, following = (Batches(np.arange(100_000), np.zeros(100_000, "u8"), 2, 0.0, times) for _ in range(2))
    for _ in range(10):
        times.add(BatchOutcome("x", size := len(last.next().cases), 0, 1e-3 * size))
    assert len(following.next().cases) > 0.9 * driving.TARGET_SECONDS / 1e-3


def test_a_pool_that_breaks_again_and_again_ends_the_run_with_advice(driven):
    with pytest.raises(ClearsweepError, match="--executor serial"):
        driven(Unreliable(*["breaks"] * 20))


def test_a_job_that_is_sent_again_and_again_is_unpacked_once(tmp_path):
    sent, other = (pickle.dumps(RunContext(tmp_path, grids.load(grid(n), CATALOGUE), Fake)) for n in (2, 3))
    first = pickle.loads(sent)
    assert first.grid.case_id(1) == grids.load(grid(2), CATALOGUE).case_id(1)
    assert pickle.loads(sent) is first
    assert len(pickle.loads(other).grid) == 3


def test_workers_with_another_version_of_the_model_are_refused_and_commit_nothing(tmp_path):
    with pytest.raises(ClearsweepError, match="another version of clearsweep"):
        sweep(grid(3), tmp_path / "run", jobs=1, show_progress=False, simulator=OtherVersion)
    assert not list((tmp_path / "run" / "parts").iterdir())
