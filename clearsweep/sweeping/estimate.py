"""What a sweep would cost: a few of its cases are timed, nothing is stored."""

import itertools
import math
import time
from concurrent.futures import TimeoutError as Late
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..contracts.case import Case
from ..grid import Grid, check_memory, key_units, largest_history, leaves, usual_history
from . import crew, executors, signals, sweep
from .bracket import usual_probes
from .shard import Shard, each_once
from .simulator import SIMULATION
from .worker import Simulator, time_case

PILOT_CASES, PILOT_TIME = 64, 10.0  # timed: at most so many cases, and no further one after so many seconds
ODD = 20.0  # times the median, above which a case is timed again: it may have compiled something
PILOT_PATIENCE = 60.0  # s waited for one case
START_UP = 1.0  # s until the workers are ready
EACH = 1e-3  # s a case takes besides its motion: to make it, commit it and merge it
EVENT_BYTES = 26  # of one event in orbits.h5


class Estimate(NamedTuple):
    """What a run of a grid would do and cost."""

    cases: int  # of the grid, or of its shard
    pending: int  # cases that the directory does not hold yet
    derived: dict[str, dict[str, Any]]  # name -> {"unit", "min", "max"}
    warnings: list[str]
    timed: int  # cases timed
    case_seconds: float | None  # s a case on average; None where a timed case did not end
    longest: float | None  # s, of the cases timed
    seconds: float | None  # s of the whole run, compiled code in the cache
    give_or_take: float | None  # s, twice the standard error of `seconds`, as the cases that were timed differ
    bytes: int  # in the directory: batches and merged files
    assumed: dict[str, dict[str, Any]]  # path written without a unit -> {"unit", "values"}: SI, the first and the last
    case: dict[str, Any]  # the first case: its identity, its values by dotted path, their units


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
    if grid.seek:
        times_more = usual_probes(grid.seek.last) / len(grid.seek.first())
        sentence = f"these are the first cases of `seek`; about {times_more:.2g} times as many follow from one another"
        warnings.append(f"{sentence}, and their time and storage")
    if grid.refine:
        warnings.append(f"up to {grid.refine.cases:,} cases that `refine` adds follow from these, and come on top")
    directory = sweep.directory_of(grid, out, part)
    directory.check(grid)
    directory.look()
    ids = crew.case_ids(grid)
    wanted = part.ids(ids) if part else each_once(ids)
    pending = crew.missing(ids, wanted, directory.rows(), retry_failed=False)
    jobs = jobs or executors.cores()
    times, events = _pilot(grid, pending, simulator) if len(pending) else ([], 0.0)
    mean = float(np.mean(times)) if times else None
    jobs = min(jobs, max(len(pending), 1))
    seconds = 0.0 if not len(pending) else None if mean is None else START_UP + (mean + EACH) * len(pending) / jobs
    units = key_units(grid.resolved(), simulator.catalogue())
    return Estimate(
        len(wanted),
        len(pending),
        derived,
        warnings,
        len(times),
        mean,
        max(times, default=None),
        seconds,
        _give_or_take(times, len(pending)) / jobs if seconds else None,
        int(len(pending) * _case_bytes(grid, events)),
        {
            path: {"unit": units[path], "values": ends}
            for path in grid.assumed
            if path in units and (ends := _ends(grid, path))
        },
        _first(grid, units),
    )


def _ends(grid: Grid, path: str) -> list[Any]:
    """Return the value of a path, or the first and the last that it takes; [] where the first case does not use it."""
    axis = grid.axes.get(path)
    if axis is None:
        return [value for key, value in leaves(grid.written_case(0)) if key == path]
    return list(dict.fromkeys((axis[0], axis[-1])))


def _first(grid: Grid, units: dict[str, str]) -> dict[str, Any]:
    """Return the first case: its identity, and value and unit of every key, defaults filled in."""
    values = dict(leaves(grid.written_case(0)))
    return {
        "case_id": grid.case_id(0),
        "values": {path: value for path, value in values.items() if not isinstance(value, dict | list)},
        "units": {path: units[path] for path in values if path in units},
    }


def _give_or_take(times: list[float], pending: int) -> float:
    """Return twice the standard error (s) of the time that all pending cases take; 0 where all were timed."""
    if not 1 < len(times) < pending:
        return 0.0
    return 2.0 * pending * float(np.std(times, ddof=1)) * math.sqrt((1.0 - len(times) / pending) / len(times))


def chosen(count: int) -> list[int]:
    """Return which of `count` cases are timed: one at random of each of equal stretches, in random order.

    Equal steps would meet the same values of the last axes again and again; any first few are a fair sample, too.
    """
    chance = np.random.default_rng(count)
    edges = np.linspace(0, count, min(count, PILOT_CASES) + 1).astype(int)
    picked = [int(chance.integers(low, high)) for low, high in itertools.pairwise(edges.tolist())]
    return [picked[place] for place in chance.permutation(len(picked))]


def _pilot(grid: Grid, pending: np.ndarray, simulator: Simulator) -> tuple[list[float], float]:
    """Return the times (s) of a few cases spread over the grid and their mean number of events."""
    times: list[float] = []
    events: list[int] = []
    with signals.catching():
        workers = executors.Local(1, load=simulator.load)
        try:
            crew.warm(workers, crew.kinds(grid, pending, simulator), simulator)
            cases = [grid.case(index) for index in pending[chosen(len(pending))].tolist()]

            def timed(case: Case) -> tuple[float, int]:
                spent: tuple[float, int] = workers.submit(time_case, simulator, case).result(timeout=PILOT_PATIENCE)
                return spent

            timed(cases[0])  # the first motion of all may compile what its first moment did not need
            begin = time.monotonic()
            for case in cases:
                if times and time.monotonic() - begin > PILOT_TIME:
                    break
                seconds, count = timed(case)
                times.append(seconds)
                events.append(count)
            times = [
                min(seconds, timed(case)[0]) if seconds > max(ODD * float(np.median(times)), 1.0) else seconds
                for case, seconds in zip(cases, times, strict=False)
            ]
        except Late:
            return [], 0.0
        finally:
            workers.close()
    return times, float(np.mean(events))


def _case_bytes(grid: Grid, events: float) -> float:
    """Return the bytes that one case takes in its batch and in the merged files together."""
    layout = grid.layout
    history = usual_history(grid)
    wear = sum(2 * 8 * joint.wear_bins * joint.wear_rows for joint in layout.joints)
    row = 8 * (len(layout.columns) + len(grid.axes)) + 32
    return 2.0 * (history + (events * EVENT_BYTES if history else 0.0) + wear + row)
