"""A dask cluster is one more place where cases run: same results, and the death of a worker costs nothing."""

import http.server
import os
import signal
import socket
import subprocess
import sys
import threading
import time
from pathlib import Path
from types import SimpleNamespace

import pytest
from fake_physics import DIES, GOOD, HANGS, grid
from test_sweep import quiet, same_results, wait_for

from clearsweep.language.errors import InputError, SchedulerLostError
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


@pytest.fixture
def silent():
    """Return the address of a server that takes connections and never says a word."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        yield f"tcp://127.0.0.1:{server.getsockname()[1]}"


@pytest.fixture
def talkative():
    """Return the address of a server that speaks HTTP."""
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), http.server.SimpleHTTPRequestHandler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"tcp://127.0.0.1:{server.server_port}"
        server.shutdown()


@pytest.mark.parametrize("kind", ["silent", "talkative"])
def test_a_server_that_is_no_scheduler_is_refused_within_one_deadline(tmp_path, monkeypatch, request, kind):
    address = request.getfixturevalue(kind)
    monkeypatch.setattr(executors, "PATIENCE", 0.5)
    begin = time.monotonic()
    with pytest.raises(InputError, match=f"scheduler: {address} does not answer"):
        quiet(grid(1), tmp_path / "run", executor="dask", scheduler=address)
    assert time.monotonic() - begin < 5.0
    assert not (tmp_path / "run").exists()


@pytest.fixture
def scheduler():
    """Return a scheduler with one worker, a program each, and its address."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
    address = f"tcp://127.0.0.1:{port}"
    options = ["--no-dashboard", "--host", "127.0.0.1"]
    commands = (
        ["distributed.cli.dask_scheduler", "--port", str(port), *options],
        ["distributed.cli.dask_worker", address, "--nthreads", "1", "--no-nanny", *options],
    )
    here = Path(__file__).parent
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(here), str(here.parent)])}
    quietly = {"env": environment, "stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    programs = [subprocess.Popen([sys.executable, "-m", *command], **quietly) for command in commands]
    yield programs[0], address
    for program in programs:
        program.kill()
        program.wait()


@pytest.mark.slow
@pytest.mark.parametrize("signum", [signal.SIGKILL, signal.SIGSTOP], ids=["killed", "silent"])
def test_a_scheduler_that_is_lost_ends_the_run_with_one_sentence(tmp_path, monkeypatch, scheduler, capfd, signum):
    running, address = scheduler

    def lose():
        wait_for(lambda: len(list(tmp_path.glob("run/parts/*"))) >= 2)
        monkeypatch.setattr(executors, "PATIENCE", 0.5)
        running.send_signal(signum)

    loser = threading.Thread(target=lose, daemon=True)
    loser.start()
    with pytest.raises(SchedulerLostError, match=r"was lost \(.*run the same command again to go on") as lost:
        quiet(grid(200, (GOOD + 0.05,)), tmp_path / "run", executor="dask", scheduler=address)
    loser.join()
    assert lost.value.exit_code == 4
    assert len(str(lost.value).splitlines()) == 1
    assert not [line for line in capfd.readouterr().err.splitlines() if "compiling" not in line]


@pytest.mark.parametrize("silence", [threading.Event().wait, lambda: 1 / 0], ids=["silent", "gone"])
def test_a_scheduler_that_is_asked_in_vain_is_lost(monkeypatch, silence):
    monkeypatch.setattr(executors, "PATIENCE", 0.1)
    workers = executors.Dask.__new__(executors.Dask)
    workers._scheduler, workers._counted = "tcp://there:1", 0.0
    workers._client = SimpleNamespace(nthreads=silence)
    with pytest.raises(
        SchedulerLostError, match=r"scheduler: tcp://there:1 was lost .*run the same command again"
    ) as lost:
        assert workers.jobs
    assert lost.value.exit_code == 4
