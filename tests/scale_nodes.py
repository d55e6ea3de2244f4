"""Measures what a run on many nodes costs its parent; nodes are simulated: they wait as long as their cores would work.

`python tests/scale_nodes.py NODES CORES DIR` really runs one block of made-up cases. Then a parent and a scheduler give
BLOCKS blocks to each of NODES nodes with CORES cores, for cases of SECONDS. A node waits, and puts the files of that
block in the place of its own. It prints a line of JSON for `scale_blocks.py write`.
"""

import functools
import json
import os
import pickle
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import scale
import scale_blocks
import scale_cases

from clearsweep import grid as grids
from clearsweep import store
from clearsweep.sweeping import blockwise, nodes
from clearsweep.sweeping.nodes import NodeReport, _address, close, run_block
from clearsweep.sweeping.pool.case_runner import CaseRunner, Options
from clearsweep.sweeping.pool.driver import CaseProgress

SECONDS = 0.7e-3  # s, of a case
BLOCKS = 36  # for each node: about a minute for 64 cores
CLUSTER = """
import sys
from distributed import LocalCluster
options = dict(n_workers=int(sys.argv[1]), threads_per_worker=1, processes=False, protocol="tcp://", host="127.0.0.1")
with LocalCluster(**options, dashboard_address=None) as cluster:
    print(cluster.scheduler_address, flush=True)
    sys.stdin.read()
"""


unpacked = functools.lru_cache(1)(pickle.loads)


def simulated(_token: str, content: bytes, number: int, _most: int | None, cores: int) -> NodeReport:
    """Wait for as long as a node would work at a block, and finish it with the files of the first one."""
    job = unpacked(content)
    cases, begin = len(job.division.part(number)), time.monotonic()
    scale_blocks.stand_in(job.directory, job.division, number, None)
    time.sleep(max(cases * SECONDS / cores - (time.monotonic() - begin), 0.0))
    return NodeReport(_address(), cases, 0, cases * SECONDS)


class Cluster(nodes.Cluster):
    """A cluster of simulated nodes."""

    cores = 1

    def submit(self, function, *args, on=None):
        """Return the future of a function on some node; blocks are simulated, and nothing is left to finish."""
        if function is run_block:
            return super().submit(simulated, *args, self.cores, on=on)
        return super().submit(close, "", on=on) if function is close else super().submit(idle, on=on)


def idle() -> NodeReport:
    """Return the report of a node with nothing to do."""
    return NodeReport(_address())


def run(count: int, cores: int, directory: Path, address: str) -> dict:
    """Run all blocks on simulated nodes; return what that cost the parent."""
    blocks = count * BLOCKS
    scale_cases.COUNTS[blocks * store.block_size()] = (blocks, 256, 512)
    grid = grids.load(scale_cases.made_up(blocks * store.block_size()), scale_cases.StandIn.catalogue())
    options, division = Options(jobs=scale.JOBS, show_progress=False, scheduler=address), store.Division.of(grid)
    job = blockwise.BlockJob(
        directory.absolute(), grid, scale_cases.StandIn, options, division, None, np.empty(0, "i8")
    )
    directory_of_run = store.RunDirectory(directory)
    facts = {"counts": {"cases": len(grid)}, "blocks": {"size": division.size, "count": division.count, "numbers": []}}
    with directory_of_run.open_for(grid, **facts):
        with CaseRunner(directory_of_run, options, scale_cases.StandIn) as case_runner:
            runner = blockwise.BlockRunner(job, case_runner)
            runner.run(0)
            runner.collect()
        Cluster.cores = cores
        cluster = Cluster(address)
        while len(cluster.nodes()) < count:
            time.sleep(0.1)
            cluster._counted_at = -nodes.RECOUNT_INTERVAL
        driver = nodes.NodesDriver(job, cluster, CaseProgress(len(grid)))
        begin, spent = time.perf_counter(), time.process_time()
        driver.run()
        wall, parent = time.perf_counter() - begin, time.process_time() - spent
    left, _ = blockwise.unfinished_blocks(job)
    work = (blocks - 1) * store.block_size() * SECONDS  # s, of one core
    known = {"nodes": count, "cores": cores, "blocks": blocks, "left": len(left), "parent": parent, "wall": wall}
    return known | {"busy": work / wall}


def main() -> None:
    """Do what the command line asks for."""
    count, cores, directory = int(sys.argv[1]), int(sys.argv[2]), Path(sys.argv[3])
    paths = os.pathsep.join([str(scale.ROOT / "tests"), str(scale.ROOT)])
    with subprocess.Popen(
        [sys.executable, "-c", CLUSTER, str(count)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        env=os.environ | {"PYTHONPATH": paths},
    ) as program:
        assert program.stdout
        known = {"name": "nodes", "date": time.strftime("%Y-%m-%d"), "load": os.getloadavg()[0], "nice": os.nice(0)}
        print(json.dumps(known | run(count, cores, directory, program.stdout.readline().strip())))
        program.kill()


if __name__ == "__main__":
    import scale_nodes  # under its name nodes find it, too

    scale_nodes.main()
