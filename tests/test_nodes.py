"""A driver on each node of a cluster: nodes are processes here, each with a pool of its own."""

import os
import signal
import socket
import subprocess
import sys
import threading
import time
from pathlib import Path
from types import SimpleNamespace
from typing import ClassVar

import pytest
from fake_faults import FullDisk, OtherClock, Slow
from fake_physics import FAILS, GOOD, grid
from test_blocks import rows_of
from test_sweep import quiet, wait_for

import clearsweep
from clearsweep import grid as grids
from clearsweep import store
from clearsweep.language.errors import InputError
from clearsweep.store import blocks
from clearsweep.sweeping import blockwise, nodes
from clearsweep.sweeping import merge as merging
from clearsweep.sweeping.pool import case_runner

pytestmark = pytest.mark.heavy

pytest.importorskip("distributed")

HERE = Path(__file__).parent
MIXED = grid(16, (GOOD, GOOD + 0.001, FAILS))  # 48 cases


class Answered:
    """A cluster of one node that answers at once: 4 of 100 cases fail in each block; the last is requested again."""

    excluded: ClassVar[set] = set()
    address = ""

    def __init__(self):
        self.allowed, self.answered = [], set()

    def nodes(self):
        """Return the only node."""
        return ["node"]

    def submit(self, function, *given, **_):
        """Return the report of a block."""
        future, report = SimpleNamespace(done=lambda: True, status="finished"), nodes.NodeReport("node")
        if function is nodes.run_block:
            *_, number, allowed = given
            self.allowed.append(allowed)
            report = report if number in self.answered else report._replace(ran=100, failed=4)
            self.answered.add(number)
        future.result = lambda timeout: report
        return future

    def close(self):
        """Do nothing."""


def test_a_share_of_failures_is_of_all_cases_in_every_round(tmp_path, monkeypatch):
    """4 % fail where 5 % may, and a node died before it finished its block."""
    requested = iter([list(range(10)), [9], []])
    monkeypatch.setattr(nodes, "unfinished_blocks", lambda job: (next(requested), {}))
    (tmp_path / store.SCRATCH).mkdir()
    made = SimpleNamespace(layout=SimpleNamespace(life=False))
    options = case_runner.Options(max_failures="5%")
    job = blockwise.BlockJob(tmp_path, made, None, options, store.Division(100, 1000, ""), None, None)
    monkeypatch.setattr(nodes.pickle, "dumps", lambda job: b"")
    cluster = Answered()
    driver = nodes.NodesDriver(job, cluster, SimpleNamespace(advance=lambda *_: None))
    assert driver.run()
    assert (driver.ran, driver.failed) == (1000, 40)
    assert min(cluster.allowed) == 10


class Machines:
    """A scheduler and nodes, a program each."""

    def __init__(self):
        with socket.create_server(("127.0.0.1", 0)) as server:
            self.port = server.getsockname()[1]
        self.address = f"tcp://127.0.0.1:{self.port}"
        self.programs = []
        self.scheduler = self.start("distributed.cli.dask_scheduler", "--port", str(self.port))
        self.nodes = []

    def start(self, module, *options, **environment):
        paths = os.pathsep.join([str(HERE), str(HERE.parent)])
        program = subprocess.Popen(
            [sys.executable, "-m", module, *options, "--no-dashboard", "--host", "127.0.0.1"],
            env=os.environ | {"PYTHONPATH": paths} | environment,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
        )
        self.programs.append(program)
        return program

    def add(self, count=1, **environment):
        options = (self.address, "--nthreads", "1", "--no-nanny")
        self.nodes += [self.start("distributed.cli.dask_worker", *options, **environment) for _ in range(count)]

    def end(self):
        for program in self.programs:
            program.send_signal(signal.SIGCONT)
            program.kill()
            program.wait()


@pytest.fixture
def machines():
    """Return a scheduler, to which a test adds the nodes that it needs."""
    started = Machines()
    yield started
    started.end()


@pytest.fixture(scope="module")
def pair():
    """Return a scheduler and two nodes, to which nothing happens."""
    started = Machines()
    started.add(2)
    yield started
    started.end()


@pytest.fixture(autouse=True)
def small(monkeypatch):
    """Cut grids of more than eight cases, and wait for little."""
    monkeypatch.setattr(blocks, "BLOCK", 8)
    monkeypatch.setattr(nodes, "RECOUNT_INTERVAL", 0.2)
    monkeypatch.setattr(nodes, "HELP_AFTER", 1.0)
    monkeypatch.setattr(nodes, "SILENCE_TIMEOUT", 1.0)


def on_nodes(source, out, machines, **options):
    return quiet(source, out, executor="nodes", scheduler=machines.address, jobs=1, **options)


def once(condition, deed):
    """Do something once a condition is met, in a thread."""

    def act():
        wait_for(condition)
        deed()

    thread = threading.Thread(target=act, daemon=True)
    thread.start()
    return thread


def undergoes(deed, parts, directory, machines):
    """Run 48 cases of 50 ms on nodes to which something happens once so many parts are there; all cases are."""
    actor = once(lambda: len(list(directory.glob("run/blocks/*/parts/*"))) >= parts, deed)
    result = on_nodes(grid(48, (GOOD + 0.05,)), directory / "run", machines)
    actor.join()
    assert (result.ok, result.missing) == (48, 0)
    assert complete(directory / "run")


def complete(directory, cases=48):
    """Return whether all cases are there, each once, and all checksums are right."""
    facts = store.status(directory, every_file=True)
    there = facts["state"], facts["missing"], len(rows_of(directory)), len(store.open(directory))
    return there == ("finished", 0, cases, cases)


@pytest.mark.slow
def test_nodes_run_and_finish_all_blocks(tmp_path, pair):
    result = on_nodes(MIXED, tmp_path / "run", pair)
    assert (result.cases, result.ok, result.failed, result.missing) == (48, 32, 16, 0)
    assert result.ran >= 48  # on a busy machine a node helps another and runs some of its cases, too
    assert complete(tmp_path / "run")
    again = on_nodes(MIXED, tmp_path / "run", pair)
    assert (again.ran, again.reused) == (0, 48)


@pytest.mark.slow
def test_nodes_run_the_laws_of_the_launcher_which_they_do_not_trust_themselves(tmp_path, pair, monkeypatch):
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "config"))  # of the launcher alone
    law = '@laws.elastic("spring", k="N/m")\ndef spring(penetration, p):\n    return p.k * penetration\n'
    (tmp_path / "my_laws.py").write_text(f"from clearsweep import laws\n\n{law}")
    grids.trust(tmp_path / "my_laws.py")
    contact = {"law": "flores", "elastic": "spring", "k": "1e8 N/m", "restitution": 0.9}
    pairs = {
        "laws": str(tmp_path / "my_laws.py"),
        "mechanism": {"type": "impact-pair", "masses": ["1 kg", "1 kg"], "speed": "1 m/s"},
        "joints": {"pair": {"bearing_radius": "10 mm", "clearance": "0.1 mm", "contact": contact}},
        "simulate": {"impacts": 1},
        "sweep": {"joints.pair.contact.k": {"linspace": ["1e8 N/m", "2e8 N/m", 10]}},
    }
    nodes_run = clearsweep.sweep(pairs, tmp_path / "nodes", executor="nodes", scheduler=pair.address, jobs=1)
    assert (nodes_run.ok, nodes_run.failed) == (10, 0)
    for index in (1, 2):
        clearsweep.sweep(pairs, tmp_path / str(index), executor="serial", shard=f"{index}/2")
    joined = merging.merge([tmp_path / "1", tmp_path / "2"], tmp_path / "joined")
    assert joined.cases == 10
    summaries = [clearsweep.open(tmp_path / name).summary.pair_restitution for name in ("nodes", "joined")]
    assert list(summaries[0]) == list(summaries[1])
    assert clearsweep.sweep(pairs, tmp_path / "joined", executor="serial").reused == 10


@pytest.mark.slow
def test_nodes_are_for_grids_that_are_cut(tmp_path, pair):
    with pytest.raises(InputError, match=r"executor: nodes assigns whole blocks .* write --executor dask"):
        on_nodes(grid(4), tmp_path / "run", pair)


@pytest.mark.slow
def test_the_work_of_a_node_that_dies_goes_to_another(tmp_path, machines):
    machines.add(2)
    undergoes(machines.nodes[0].kill, 4, tmp_path, machines)


@pytest.mark.slow
def test_a_scheduler_that_restarts_costs_no_case(tmp_path, machines):
    machines.add(1)

    def restart():
        machines.scheduler.kill()
        machines.scheduler.wait()
        machines.nodes[0].kill()
        machines.scheduler = machines.start("distributed.cli.dask_scheduler", "--port", str(machines.port))
        machines.add(1)

    undergoes(restart, 4, tmp_path, machines)


@pytest.mark.slow
def test_a_node_that_stops_is_helped_and_replaced(tmp_path, machines):
    machines.add(2)
    begin = time.monotonic()
    undergoes(lambda: os.killpg(machines.nodes[0].pid, signal.SIGSTOP), 2, tmp_path, machines)
    assert time.monotonic() - begin < 60.0


@pytest.mark.slow
def test_the_block_of_a_slow_node_is_shared_and_no_case_exists_twice(tmp_path, machines):
    log = tmp_path / "slow"
    machines.add(1, CLEARSWEEP_TEST_SLOW=str(log))
    joins = once(log.exists, machines.add)  # the first block is the slow node's
    result = on_nodes(grid(48, (GOOD,)), tmp_path / "run", machines, simulator=Slow)
    joins.join()
    assert (result.ok, result.failed, result.missing) == (48, 0, 0)
    assert complete(tmp_path / "run")
    ran = log.read_text().splitlines()
    assert len(ran) == len(set(ran))
    assert len(ran) < 8, "the slow node ran all of its block"


@pytest.mark.slow
def test_a_node_whose_disk_is_full_is_left_out(tmp_path, machines, capfd):
    machines.add(1, CLEARSWEEP_TEST_FULL="yes")
    machines.add(1)
    result = on_nodes(MIXED, tmp_path / "run", machines, simulator=FullDisk)
    assert (result.ok, result.failed, result.missing) == (32, 16, 0)
    assert complete(tmp_path / "run")
    assert "its work goes to other nodes" in capfd.readouterr().err


@pytest.mark.slow
def test_clocks_that_differ_change_nothing(tmp_path, machines):
    machines.add(1, CLEARSWEEP_TEST_CLOCK="-86400")
    machines.add(1, CLEARSWEEP_TEST_CLOCK="86400")
    result = on_nodes(MIXED, tmp_path / "run", machines, simulator=OtherClock)
    assert (result.ok, result.failed, result.missing) == (32, 16, 0)
    assert complete(tmp_path / "run")
