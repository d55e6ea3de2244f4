"""What a sweep would cost: a few of its cases are timed, nothing is stored."""

import time
from concurrent.futures import TimeoutError as Late
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..grid import Grid, check_memory, largest_history, usual_history
from . import executors, signals, sweep
from .shard import Shard, each_once
from .simulator import SIMULATION
from .worker import Simulator, time_case

PILOT_CASES, PILOT_TIME = 8, 10.0  # timed: at most so many cases, and no further one after so many seconds
PILOT_PATIENCE = 60.0  # s waited for one case
START_UP = 1.0  # s until the workers are ready
EVENT_BYTES = 26  # of one event in orbits.h5


class Estimate(NamedTuple):
    """What a run of a grid would do and cost."""

    cases: int  # of the grid, or of its shard
    pending: int  # cases that the directory does not hold yet
    derived: dict[str, dict[str, Any]]  # name -> {"unit", "min", "max"}
    warnings: list[str]
    timed: int  # cases timed
    case_seconds: float | None  # s a case on average; None where a timed case did not end
    seconds: float | None  # s of the whole run, compiled code in the cache
    bytes: int  # in the directory: batches and merged files


def estimate(
    source: sweep.Source,
    out: str | Path | None = None,
    *,
    jobs: int | None = None,
    shard: str | None = None,
    simulator: Simulator = SIMULATION,
) -> Estimate:
    """Return what running the pending cases of a grid would cost; nothing is written, `out` is only looked at."""
    part = None if shard is None else Shard.read(shard)
    grid = sweep.load(source, simulator)
    check_memory(largest_history(grid))
    derived, warnings = sweep.facts(grid, simulator)
    directory = sweep.directory_of(grid, out, part)
    directory.check(grid)
    directory.look()
    ids = sweep.case_ids(grid)
    wanted = part.ids(ids) if part else each_once(ids)
    pending = sweep.missing(ids, wanted, directory.rows(), retry_failed=False)
    jobs = jobs or executors.cores()
    times, events = _pilot(grid, pending, simulator) if len(pending) else ([], 0.0)
    mean = float(np.mean(times)) if times else None
    seconds = 0.0 if not len(pending) else None if mean is None else START_UP + mean * len(pending) / jobs
    return Estimate(
        len(wanted),
        len(pending),
        derived,
        warnings,
        len(times),
        mean,
        seconds,
        int(len(pending) * _case_bytes(grid, events)),
    )


def _pilot(grid: Grid, pending: np.ndarray, simulator: Simulator) -> tuple[list[float], float]:
    """Return the times (s) of a few cases spread over the grid and their mean number of events."""
    chosen = pending[np.unique(np.linspace(0, len(pending) - 1, PILOT_CASES).round().astype(int))].tolist()
    times, events = [], []
    with signals.catching():
        workers = executors.Local(1, load=simulator.load)
        try:
            sweep.warm(workers, grid, pending, simulator)
            begin = time.monotonic()
            for index in chosen:
                if time.monotonic() - begin > PILOT_TIME:
                    break
                seconds, count = workers.submit(time_case, simulator, grid.case(index)).result(timeout=PILOT_PATIENCE)
                times.append(seconds)
                events.append(count)
        except Late:
            return [], 0.0
        finally:
            workers.close()
    return times, float(np.mean(events))


def _case_bytes(grid: Grid, events: float) -> float:
    """Return the bytes that one case takes in its batch and in the merged files together."""
    layout = grid.layout
    history = usual_history(grid)
    wear = sum(2 * 8 * joint.wear_bins for joint in layout.joints)
    row = 8 * (len(layout.columns) + len(grid.axes)) + 32
    return 2.0 * (history + (events * EVENT_BYTES if history else 0.0) + wear + row)
