"""A dask cluster is one more place where cases run: same results, and the death of a worker costs nothing."""

import os
import signal
import threading
import time

import pytest
from fake_physics import DIES, GOOD, HANGS, grid
from test_sweep import quiet, same_results

from clearsweep.errors import InputError
from clearsweep.sweeping import executors

pytestmark = pytest.mark.heavy

pytest.importorskip("distributed")


@pytest.fixture(autouse=True)
def hard_limit():
    """End the tests where a cluster hangs, which no exception would."""
    before = signal.signal(signal.SIGALRM, lambda *_: pytest.fail("hangs"))
    signal.alarm(100)  # each takes a few seconds where the machine has nothing else to do
    yield
    signal.alarm(0)
    signal.signal(signal.SIGALRM, before)


@pytest.fixture(scope="module")
def cluster():
    """Return a cluster of two workers on this machine, as somebody else would run it."""
    from distributed import LocalCluster

    with LocalCluster(
        n_workers=2, threads_per_worker=1, host="127.0.0.1", dashboard_address="127.0.0.1:0", silence_logs=50
    ) as running:
        yield running


def test_a_worker_that_is_killed_costs_no_case(cluster, tmp_path):
    source = grid(60, (GOOD + 0.03,), wear=True)
    quiet(source, tmp_path / "alone")

    def kill_one():
        while len(list(tmp_path.glob("run/parts/*"))) < 2:
            time.sleep(0.01)
        os.kill(next(iter(cluster.workers.values())).pid, signal.SIGKILL)

    killer = threading.Thread(target=kill_one)
    killer.start()
    result = quiet(source, tmp_path / "run", executor="dask", scheduler=cluster.scheduler_address)
    killer.join()
    assert (result.ok, result.failed, result.missing) == (60, 0, 0)
    assert same_results(tmp_path / "run", tmp_path / "alone")


def test_a_case_that_kills_its_worker_twice_has_crashed_and_the_others_go_on(cluster, tmp_path):
    source = grid(1, (GOOD, 0.001, 0.002, 0.003, DIES))
    result = quiet(source, tmp_path / "run", executor="dask", scheduler=cluster.scheduler_address)
    assert (result.ok, result.failed, result.missing) == (4, 1, 0)
    failed = result.open().summary.query("status != 'ok'")
    assert set(failed["status"]) == {"crashed"}
    assert all("its worker died twice" in message for message in failed["message"])


def test_without_a_scheduler_there_is_a_cluster_of_its_own_and_late_cases_end(tmp_path):
    result = quiet(grid(1, (GOOD, HANGS, DIES)), tmp_path / "run", executor="dask", jobs=2, case_timeout=0.5)
    assert (result.ok, result.failed, result.missing) == (1, 2, 0)
    told = dict(zip(result.open().summary["mechanism.gravity"], result.open().summary["status"], strict=True))
    assert told == {GOOD: "ok", HANGS: "timeout", DIES: "crashed"}


def test_workers_on_this_machine_have_one_thread_each():
    workers = executors.Dask(1)
    try:
        inside = [workers.submit(os.getenv, name).result(20) for name in executors.THREAD_VARIABLES]
        assert workers.jobs == 1
    finally:
        workers.close()
    assert inside == ["1"] * len(inside)


@pytest.mark.parametrize("address", ["tcp://127.0.0.1:9", "nonsense", "http://127.0.0.1:9"])
def test_a_scheduler_that_does_not_answer_is_refused_before_anything_is_written(tmp_path, monkeypatch, address):
    monkeypatch.setattr(executors, "PATIENCE", 0.5)
    with pytest.raises(InputError, match=f"scheduler: {address} does not answer"):
        quiet(grid(1), tmp_path / "run", executor="dask", scheduler=address)
    assert not (tmp_path / "run").exists()
