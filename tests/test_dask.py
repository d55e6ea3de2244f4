"""A dask cluster is one more place where cases run: same results, and the death of a worker costs nothing."""

import http.server
import json
import os
import signal
import socket
import subprocess
import sys
import threading
import time
import weakref
from pathlib import Path
from types import SimpleNamespace
from typing import ClassVar, NamedTuple

import pytest
from fake_physics import DIES, GOOD, HANGS, grid
from test_sweep import quiet, same_results, wait_for

from clearsweep.language.errors import ClearsweepError, InputError, SchedulerLostError, StorageError
from clearsweep.sweeping.pool import executors

pytestmark = pytest.mark.heavy

pytest.importorskip("distributed")

HERE = Path(__file__).parent
#: Prints address and processes of a cluster, and keeps it until stdin is closed.
RUN_CLUSTER = """
import json, sys
from distributed import LocalCluster
if __name__ == "__main__":
    options = {"host": "127.0.0.1", "dashboard_address": "127.0.0.1:0", "silence_logs": 50}
    cluster = LocalCluster(n_workers=2, threads_per_worker=1, **options)
    facts = {"address": cluster.scheduler_address, "workers": [nanny.pid for nanny in cluster.workers.values()]}
    print(json.dumps(facts), flush=True)
    sys.stdin.read()
"""


class Cluster(NamedTuple):
    """A cluster that somebody else runs."""

    address: str
    workers: list[int]  # their processes


@pytest.fixture(scope="module")
def cluster():
    """Return a cluster of two workers on this machine, in processes of their own that can be ended at any time."""
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(HERE), str(HERE.parent)])}
    program = [sys.executable, "-c", RUN_CLUSTER]
    with subprocess.Popen(
        program, env=environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, start_new_session=True
    ) as process:
        try:
            yield Cluster(**json.loads(process.stdout.readline()))
        finally:
            os.killpg(process.pid, signal.SIGKILL)


def test_a_worker_that_is_killed_costs_no_case(cluster, tmp_path):
    source = grid(60, (GOOD + 0.03,), wear=True)
    quiet(source, tmp_path / "alone")

    def kill_one():
        while len(list(tmp_path.glob("run/parts/*"))) < 2:
            time.sleep(0.01)
        os.kill(cluster.workers[0], signal.SIGKILL)

    killer = threading.Thread(target=kill_one)
    killer.start()
    result = quiet(source, tmp_path / "run", executor="dask", scheduler=cluster.address)
    killer.join()
    assert (result.ok, result.failed, result.missing) == (60, 0, 0)
    assert same_results(tmp_path / "run", tmp_path / "alone")


@pytest.mark.slow
@pytest.mark.parametrize("folder", ["parts", "shards"])
def test_what_a_node_damages_while_a_run_works_is_said_and_computed_again(cluster, tmp_path, folder):
    source = grid(60, (GOOD + 0.03,), wear=True)

    def damage_one():
        wait_for(lambda: len(list(tmp_path.glob("run/parts/*"))) >= 2)
        path = next(tmp_path.glob(f"run/{folder}/*"))
        path.write_bytes(path.read_bytes()[:-7])  # as a node whose disk lies

    damager = threading.Thread(target=damage_one)
    damager.start()
    with pytest.raises(StorageError, match=r"damaged or removed .*run the same command again"):
        quiet(source, tmp_path / "run", executor="dask", scheduler=cluster.address)
    damager.join()
    again = quiet(source, tmp_path / "run", executor="dask", scheduler=cluster.address)
    assert (again.ok, again.failed, again.missing) == (60, 0, 0)
    assert 0 < again.ran < 60
    assert same_results(tmp_path / "run", quiet(source, tmp_path / "alone").directory)


def replace_batches(answer):
    """Let a worker answer every batch so; a task of anybody on the cluster can do that."""
    from clearsweep.sweeping.pool import worker

    worker.original = getattr(worker, "original", worker.run_batch)
    worker.run_batch = answer or worker.original


def not_an_outcome(context, batch):
    return {"committed": "../../elsewhere"}


def an_error_of_its_own(context, batch):
    raise LookupError("nobody knows")


@pytest.mark.parametrize(
    ("answer", "said"),
    [(not_an_outcome, "it is dict, not the outcome"), (an_error_of_its_own, "LookupError: nobody knows")],
)
def test_a_hostile_task_on_the_workers_is_said_in_a_sentence_and_costs_no_case(cluster, tmp_path, answer, said):
    source = grid(6, (GOOD + 0.001,))
    client = executors.client(cluster.address)
    try:
        client.run(replace_batches, answer)
        with pytest.raises(ClearsweepError, match="as no worker of this run answers") as caught:
            quiet(source, tmp_path / "run", executor="dask", scheduler=cluster.address)
        assert said in str(caught.value)
        assert not list((tmp_path / "run" / "parts").iterdir())
    finally:
        client.run(replace_batches, None)
        client.close()
    result = quiet(source, tmp_path / "run", executor="dask", scheduler=cluster.address)
    assert (result.ok, result.failed, result.missing) == (6, 0, 0)


@pytest.mark.slow
def test_a_case_that_kills_its_worker_twice_has_crashed_and_the_others_continue(cluster, tmp_path):
    source = grid(1, (GOOD, 0.001, 0.002, 0.003, DIES))
    result = quiet(source, tmp_path / "run", executor="dask", scheduler=cluster.address)
    assert (result.ok, result.failed, result.missing) == (4, 1, 0)
    failed = result.open().summary.query("status != 'ok'")
    assert set(failed["status"]) == {"crashed"}
    assert all("its worker died twice" in message for message in failed["message"])


@pytest.mark.slow
def test_without_a_scheduler_there_is_a_cluster_of_its_own_and_late_cases_end(tmp_path):
    result = quiet(grid(1, (GOOD, HANGS, DIES)), tmp_path / "run", executor="dask", jobs=2, case_timeout=0.5)
    assert (result.ok, result.failed, result.missing) == (1, 2, 0)
    message = dict(zip(result.open().summary["mechanism.gravity"], result.open().summary["status"], strict=True))
    assert message == {GOOD: "ok", HANGS: "timeout", DIES: "crashed"}


def test_workers_on_this_machine_have_one_thread_each():
    workers = executors.Dask(1)
    try:
        inside = [workers.submit(os.getenv, name).result(20) for name in executors.THREAD_VARIABLES]
        assert workers.worker_count == 1
    finally:
        workers.close()
    assert inside == ["1"] * len(inside)


@pytest.mark.parametrize("address", ["tcp://127.0.0.1:9", "nonsense", "http://127.0.0.1:9"])
def test_a_scheduler_that_does_not_answer_is_refused_before_anything_is_written(tmp_path, monkeypatch, address):
    monkeypatch.setattr(executors, "ANSWER_TIMEOUT", 0.5)
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
    monkeypatch.setattr(executors, "ANSWER_TIMEOUT", 0.5)
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
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(HERE), str(HERE.parent)])}
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
        monkeypatch.setattr(executors, "ANSWER_TIMEOUT", 0.5)
        running.send_signal(signum)

    loser = threading.Thread(target=lose, daemon=True)
    loser.start()
    with pytest.raises(SchedulerLostError, match=r"was lost \(.*run the same command again to continue") as lost:
        quiet(grid(200, (GOOD + 0.05,)), tmp_path / "run", executor="dask", scheduler=address)
    loser.join()
    assert lost.value.exit_code == 4
    assert len(str(lost.value).splitlines()) == 1
    assert not [line for line in capfd.readouterr().err.splitlines() if "compiling" not in line]


@pytest.mark.parametrize("silence", [threading.Event().wait, lambda: 1 / 0], ids=["silent", "gone"])
def test_a_scheduler_that_is_asked_in_vain_is_lost(monkeypatch, silence):
    monkeypatch.setattr(executors, "ANSWER_TIMEOUT", 0.1)
    workers = executors.Dask.__new__(executors.Dask)
    workers._scheduler, workers._counted_at = "tcp://there:1", 0.0
    workers._client = SimpleNamespace(nthreads=silence)
    with pytest.raises(
        SchedulerLostError, match=r"scheduler: tcp://there:1 was lost .*run the same command again"
    ) as lost:
        assert workers.worker_count
    assert lost.value.exit_code == 4


def test_a_cluster_that_does_not_close_is_given_up(monkeypatch):
    class Stuck:
        """A cluster whose lock nobody gives back."""

        _instances: ClassVar = weakref.WeakSet()  # which are closed when the interpreter ends

        def close(self, timeout):
            """Wait for ever."""
            threading.Event().wait()

    monkeypatch.setattr(executors, "ANSWER_TIMEOUT", 0.1)
    stuck = Stuck()
    Stuck._instances.add(stuck)
    workers = executors.Dask.__new__(executors.Dask)
    workers._executor = SimpleNamespace(shutdown=lambda wait: None)
    workers._client = workers._cluster = stuck
    stuck.workers = {}
    begin = time.monotonic()
    workers.close()
    assert time.monotonic() - begin < 5.0
    assert not Stuck._instances
