"""Estimates the cost of a sweep by timing a few of its cases; nothing is stored."""

import itertools
import math
import tempfile
import time
from concurrent.futures import TimeoutError as LateError
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from .. import store
from ..contracts.case import Case
from ..grid import Grid, check_memory, first_case_history, key_units, leaves, recorded_history
from ..language import phases
from ..language.wording import count_text, duration_text
from . import blockwise, sweep
from .facts import first_and_last_value
from .pool import case_runner, executors, system
from .pool.case_runner import SIMULATION, Shard, distinct
from .pool.worker import CaseTime, Simulator, time_case

PILOT_CASES, PILOT_TIME = 64, 10.0  # largest number of timed cases, and s after which no further one is started
PILOT_SHARE = 0.5  # of PILOT_TIME for one case; a longer one is extrapolated
RETIMED_COMPILE_SECONDS = 0.5  # s of compiling above which an unfinished case is timed again
PILOT_LEAST = 8  # timed cases from which their scatter shows whether more are needed
PILOT_PRECISION, PILOT_ERROR = 0.1, 0.2  # standard error, of the time of all cases and in s, that needs no more cases
PILOT_PATIENCE = 60.0  # s to wait for one case, without compiling
MIN_COMPILE_SECONDS = 0.05  # s of compiling from which the start of the workers is measured again, without compiling
MAX_IMPORT_SECONDS = 2.0  # s of processor time before the estimate, at most, that a run takes, too
FINISH_SECONDS = 0.5  # s of processor time of a run after its last case: merging, last lines
SECONDS_PER_CASE = 1e-3  # s per case besides its motion: creating, committing and merging it
LONG_LIFE = 3600.0  # s of a run of lives from which cheaper settings are timed
CHEAPER_SHARE = 0.5  # of the time of a life that a cheaper setting may take
SHORT_BLOCK = 4.0  # revolutions of a cheaper block
COARSE_LIFE, COARSE_MOTION = 0.2, 1e-6  # cheaper `life.tolerance` and `simulate.tolerance`
EVENT_BYTES = 26  # bytes of one event in orbits.h5


class Estimate(NamedTuple):
    """Estimated work and cost of a run of a grid."""

    cases: int  # of the grid, or of its shard
    pending: int  # the same: a dry run does not look which of them are stored
    further: int  # cases that a search is expected to add; `seconds` and `bytes` contain them
    derived: dict[str, dict[str, Any]]  # name -> {"unit", "min", "max"}
    warnings: list[str]
    timed: int  # cases timed
    extrapolated: int  # timed cases that were extrapolated from their first revolutions or blocks
    case_seconds: float | None  # s, mean time of a case; None: the beginning of a case does not determine it
    longest: float | None  # s, largest of the timed cases
    seconds: float | None  # s of the whole run, start and end included; the dry run has compiled its code
    give_or_take: float | None  # s, twice the standard error of `seconds` from the scatter of the timed cases
    bytes: int  # bytes in the directory of the finished run, at most
    assumed: dict[str, dict[str, Any]]  # path written without a unit -> {"unit", "values"}: first and last value, SI
    defined: dict[str, dict[str, Any]]  # name under `define` -> value, unit, and expression or ''
    case: dict[str, Any]  # first case: identity, values by dotted path, units
    recommended: list[str]  # lines on the laws that are recommended for the joints of the first case


def estimate(
    source: sweep.Source,
    out: str | Path | None = None,
    *,
    jobs: int | None = None,
    shard: str | None = None,
    no_effects: bool = False,
    simulator: Simulator = SIMULATION,
) -> Estimate:
    """Return the cost of running all cases of a grid; nothing is written, and no results are read.

    out : directory in which the run would store its results; it only decides whether the path is too long
    """
    begin, import_seconds = time.monotonic(), time.process_time()
    parsed_shard = None if shard is None else Shard.read(shard)
    with phases.phase("reading the grid"):
        grid = sweep.load(source, simulator)
        check_memory(recorded_history(grid))
        derived, warnings = sweep.facts(grid, simulator)
    directory = sweep.directory_of(grid, out, parsed_shard)
    with phases.phase("checking the cases"):
        requested = requested_cases(grid, directory, parsed_shard, simulator)
    added, choosing_seconds = grid.search.expected_cases(grid) if grid.search else (0, 0.0)
    warnings += [sentence] if grid.search and (sentence := grid.search.expectation(added)) else []
    further = grid.search.further_cases(grid) if grid.search and not no_effects else 0
    if further and grid.search:
        warnings.append(
            f"time includes up to {further:,} cases that show which other keys help; they run only if "
            f"`{grid.search.name}` finds no answer, and --no-effects leaves them out"
        )
    reading_seconds = time.monotonic() - begin
    # 1: nothing else runs here
    slowdown = max((reading_seconds + FINISH_SECONDS) / (time.process_time() - import_seconds + FINISH_SECONDS), 1.0)
    jobs = jobs or executors.cores()
    jobs = min(jobs, max(requested.cases, 1))
    timed, start_up, cheaper, jobs = pilot(grid, requested, jobs, simulator)
    times = [timed_case.seconds for timed_case in timed if timed_case.seconds is not None]
    events = [timed_case.events for timed_case in timed]
    mean = float(np.mean(times)) if times else None
    warnings += _warnings_of(timed)
    warnings += cheaper_lives_texts(mean, cheaper, requested.cases / jobs) if mean else []
    overhead = slowdown * (min(import_seconds, MAX_IMPORT_SECONDS) + FINISH_SECONDS) + reading_seconds + start_up
    case_count = requested.cases + added + further
    seconds = None if case_count else 0.0
    if case_count and mean is not None:
        search_time = slowdown * choosing_seconds * added
        seconds = overhead + search_time + (mean + slowdown * SECONDS_PER_CASE) * case_count / jobs
    units = key_units(grid.resolved(), simulator.catalogue())
    bounds = {path: first_and_last_value(grid, path) for path in grid.assumed_units if path in units}
    expressions = grid.defined.expression_by_name
    return Estimate(
        requested.cases,
        requested.cases,
        added,
        derived,
        warnings,
        len(times),
        sum(timed_case.extrapolated for timed_case in timed),
        mean,
        max(times, default=None),
        seconds,
        _standard_error(times, case_count) / jobs if seconds else None,
        int(case_count * _case_bytes(grid, float(np.mean(events)) if events else 0.0)),
        {path: {"unit": units[path], "values": values} for path, values in bounds.items() if values},
        {
            name: {"value": float(grid.defined.values[name]), "unit": grid.defined.units[name], "expression": text}
            for name, text in expressions.items()
        },
        _first_case(grid, units | {path: grid.unit(path) for path in grid.axes}),
        simulator.recommended(grid.case(0)),
    )


def _warnings_of(timed: list[CaseTime]) -> list[str]:
    """Return warnings about timed cases that fail, or that their time budget would end."""
    count, warnings = count_text(len(timed), "timed case"), []
    if over_budget := sum(timed_case.over_budget for timed_case in timed):
        warnings.append(
            f"{over_budget:,} of {count} would take longer than simulate.time_budget allows and end with the status "
            "time-budget; increase it, or reduce simulate.revolutions"
        )
    if failures := [timed_case.failure for timed_case in timed if timed_case.failure]:
        warnings.append(f"{len(failures):,} of {count} would fail, for example: {failures[0]}")
    return warnings


class _Requested(NamedTuple):
    """The cases of a grid, or of its shard."""

    cases: int
    timed: np.ndarray  # indices of a few cases, spread over them or over their blocks
    kinds: list[Case]  # one case for each kind of scene


def requested_cases(grid: Grid, directory: store.RunDirectory, shard: Shard | None, simulator: Simulator) -> _Requested:
    """Return the cases that a run computes."""
    if division := store.Division.of(grid, str(shard or "")):
        duplicates, path = blockwise.duplicate_indices(grid), directory.path.absolute()
        job = blockwise.BlockJob(path, grid, simulator, case_runner.Options(), division, shard, duplicates)
        numbers = np.linspace(0, division.count - 1, min(PILOT_CASES, division.count)).astype(int)
        per_block = -(-PILOT_CASES // len(numbers))
        spread_indices = [
            np.linspace(0, len(division.part(k)) - 1, per_block).astype("i8") + division.part(k).start
            for k in numbers.tolist()
        ]
        timed = np.unique(np.concatenate(spread_indices))
        scenes = {simulator.signature(case): case for case in map(grid.case, timed.tolist())}
        return _Requested(blockwise.count_requested(job), timed, list(scenes.values()))
    ids = case_runner.case_ids(grid)
    requested_ids = shard.ids(ids) if shard else distinct(ids)
    indices = np.flatnonzero(np.isin(ids, requested_ids)) if shard else np.arange(len(ids))
    kinds = case_runner.one_case_per_scene(grid, indices, simulator)
    return _Requested(len(requested_ids), indices[timed_indices(len(indices))], kinds)


def _first_case(grid: Grid, units: dict[str, str]) -> dict[str, Any]:
    """Return the first case: identity, and value and unit of every key with defaults filled in."""
    values, written = dict(leaves(grid.written_case(0))), grid.written_units
    return {
        "case_id": grid.case_id(0),
        "values": {path: value for path, value in values.items() if not isinstance(value, dict | list | tuple)},
        "units": {path: units[path] for path in values if path in units},
        "written_units": {path: unit._asdict() for path, unit in written.items() if path in values},
    }


def _standard_error(times: list[float], pending: int) -> float:
    """Return twice the standard error (s) of the total time of pending cases; 0 if all were timed."""
    if not 1 < len(times) < pending:
        return 0.0
    return 2.0 * pending * float(np.std(times, ddof=1)) * math.sqrt((1.0 - len(times) / pending) / len(times))


def timed_indices(count: int) -> list[int]:
    """Return which of `count` cases to time: a random one from each of equal intervals, in random order.

    Equal steps would repeat the same values of the last axes.  The first few indices are also a random sample.
    """
    rng = np.random.default_rng(count)
    edges = np.linspace(0, count, min(count, PILOT_CASES) + 1).astype(int)
    selected = [int(rng.integers(low, high)) for low, high in itertools.pairwise(edges.tolist())]
    return [selected[position] for position in rng.permutation(len(selected))]


class _Pilot(NamedTuple):
    """Measured times of a few cases, and of the start of the workers, which are 1 if this process runs all cases."""

    timed: list[CaseTime]  # [] if the first case does not answer
    start_up: float  # s until workers are started and have loaded their code from the cache
    cheaper: dict[str, float]  # settings that a life takes less with -> s of a case
    worker_count: int


def pilot(grid: Grid, requested: _Requested, worker_count: int, simulator: Simulator) -> _Pilot:
    """Return the times of a few cases spread over the grid, and of the start of `worker_count` workers."""
    with system.catching(), tempfile.TemporaryDirectory(prefix="clearsweep-") as folder:
        directory = Path(folder)
        (directory / store.SCRATCH).mkdir()
        cases, working = [grid.case(k) for k in requested.timed.tolist()], store.Working(directory, "0" * 16)
        timed: list[CaseTime] = []
        if case_runner.may_run_here(grid, cases[0], case_runner.Options(), simulator):
            here, begin = executors.Serial(), time.monotonic()
            compiled = case_runner.compile_all(here, requested.kinds, simulator, directory)
            start_up = time.monotonic() - begin - compiled
            timed = _time_cases(here, simulator, cases, working, requested.cases)
            if not case_runner.is_worth_workers(_mean(timed) * requested.cases, worker_count):
                return _Pilot(timed, start_up, {}, 1)
        workers, start_up, compiled = start_workers(worker_count, requested.kinds, simulator, directory)
        try:
            timed = timed or _time_cases(workers, simulator, cases, working, requested.cases)
            run_seconds = _mean(timed) * requested.cases / worker_count
            lives = cheaper_lives(grid.case(int(requested.timed[0]))) if run_seconds > LONG_LIFE else {}
            cheaper = {
                settings: seconds
                for settings, case in lives.items()
                if (seconds := _mean(_time_cases(workers, simulator, [case], working, 1)))
            }
        finally:
            workers.close()
        if compiled > MIN_COMPILE_SECONDS:  # what a run has to load is in the cache now
            workers, start_up, _ = start_workers(worker_count, requested.kinds, simulator, directory)
            workers.close()
        return _Pilot(timed, start_up, cheaper, worker_count)


def _mean(timed: list[CaseTime]) -> float:
    """Return the mean time (s) of the timed cases whose time is known, 0 if there are none."""
    times = [timed_case.seconds for timed_case in timed if timed_case.seconds is not None]
    return float(np.mean(times)) if times else 0.0


def cheaper_lives(case: Case) -> dict[str, Case]:
    """Return settings, as in a grid file, with which a life whose wear changes the motion takes less time.

    Each with the case that has them; {} for another case.
    """
    worn = [joint for joint in case.joints if joint.wear and joint.wear.evolve]
    if case.life is None or not worn:
        return {}
    lives: dict[str, Case] = {}
    life, simulate, settings = case.life, case.simulate, []
    if simulate.revolutions > simulate.discard + SHORT_BLOCK:
        simulate = simulate._replace(revolutions=simulate.discard + SHORT_BLOCK)
        settings.append(f"simulate.revolutions: {simulate.revolutions:g}")
        lives[", ".join(settings)] = case._replace(simulate=simulate)
    if simulate.tolerance < COARSE_MOTION:
        simulate = simulate._replace(tolerance=COARSE_MOTION)
        settings.append("simulate.tolerance: 1e-6")
        lives[", ".join(settings)] = case._replace(simulate=simulate)
    if life.tolerance < COARSE_LIFE:
        settings.append(f"life.tolerance: {COARSE_LIFE:g}")
        lives[", ".join(settings)] = case._replace(simulate=simulate, life=life._replace(tolerance=COARSE_LIFE))
    lives[", ".join(f"joints.{joint.name}.wear.evolve: false" for joint in worn)] = case._replace(
        joints=tuple(joint._replace(wear=joint.wear and joint.wear._replace(evolve=False)) for joint in case.joints)
    )
    return lives


def cheaper_lives_texts(mean: float, cheaper: dict[str, float], cases_per_worker: float) -> list[str]:
    """Return the settings with which lives take clearly less time, and these times; [] if there are none.

    mean, cheaper : s of a case as written, and with other settings; cases_per_worker : cases one after another
    """
    affordable = {settings: seconds for settings, seconds in cheaper.items() if seconds < CHEAPER_SHARE * mean}
    if not affordable:
        return []
    texts = [
        f"`{settings}` about {duration_text(seconds * cases_per_worker)}"
        for settings, seconds in sorted(affordable.items(), key=lambda item: -item[1])
    ]
    kept = " Without `evolve` a life keeps the wear rate of the new joint." if "evolve" in "".join(affordable) else ""
    return [
        f"the lives take about {duration_text(mean * cases_per_worker)}, because their wear changes the motion; "
        f"cheaper settings, timed in the same way: {'; '.join(texts)}.{kept}"
    ]


def start_workers(
    worker_count: int, kinds: list[Case], simulator: Simulator, directory: Path
) -> tuple[executors.Executor, float, float]:
    """Return started workers with compiled code, the elapsed time (s), and the sum of their compile times (s)."""
    begin = time.monotonic()
    workers = executors.EXECUTORS["local"](worker_count, None, simulator.load)
    compiled = case_runner.compile_all(workers, kinds, simulator, directory)
    return workers, time.monotonic() - begin, compiled


def _time_cases(
    workers: executors.Executor, simulator: Simulator, cases: list[Case], working: store.Working, all_cases: int
) -> list[CaseTime]:
    """Return the times of as many of the first cases as PILOT_TIME allows and the time of `all_cases` needs."""
    results: list[CaseTime] = []

    def progress_text() -> str:
        at_work = working.read()
        return f"timing {count_text(len(cases), 'case')}" + (f": {at_work.what}" if at_work and at_work.what else "")

    def time_alone(case: Case) -> CaseTime:
        task, begin = workers.submit(time_case, simulator, case, PILOT_SHARE * PILOT_TIME, working), time.monotonic()
        while True:
            try:
                timed: CaseTime = task.result(timeout=phases.FIRST_LINE_DELAY)
                return timed
            except LateError:
                compiles = (at_work := working.read()) and at_work.once
                begin = time.monotonic() if compiles else begin
                if time.monotonic() - begin > PILOT_PATIENCE:
                    raise

    with phases.phase(progress_text) as timing:
        for case in cases:
            try:
                timed = time_alone(case)
                if timed.extrapolated and (timed.seconds is None or timed.compiling > RETIMED_COMPILE_SECONDS):
                    timed = _combine_attempts(timed, time_alone(case))  # the compiled code is in the cache now
            except LateError:
                break
            results.append(timed)
            spent = sum(result.elapsed for result in results)
            timing.note(share=min(max(len(results) / len(cases), spent / PILOT_TIME), 1.0))
            if spent > PILOT_TIME or _is_enough([result.seconds for result in results], all_cases):
                break
    return results


def _is_enough(times: list[float | None], all_cases: int) -> bool:
    """Return whether more timed cases would hardly change the estimate for all cases."""
    known = [seconds for seconds in times if seconds is not None]
    if len(known) < max(PILOT_LEAST, len(times)):
        return False
    return _standard_error(known, all_cases) < max(PILOT_ERROR, PILOT_PRECISION * float(np.mean(known)) * all_cases)


def _combine_attempts(first_attempt: CaseTime, second_attempt: CaseTime) -> CaseTime:
    """Return the time of a case from two attempts, of which the first did not finish compiling."""
    is_slow_setup = first_attempt.seconds is None and first_attempt.compiling <= RETIMED_COMPILE_SECONDS
    seconds = second_attempt.seconds
    if seconds is not None and is_slow_setup:
        seconds += first_attempt.elapsed
    return second_attempt._replace(seconds=seconds, elapsed=first_attempt.elapsed + second_attempt.elapsed)


def _case_bytes(grid: Grid, events: float) -> float:
    """Return the bytes of one case: its histories, before compression, and its rows in a batch and in the summary."""
    layout = grid.layout
    history = first_case_history(grid)
    wear = sum(2 * 8 * joint.wear_bins * joint.wear_rows for joint in layout.joints)
    row = 8 * (len(layout.columns) + len(grid.axes)) + 32
    return history + (events * EVENT_BYTES if history else 0.0) + wear + 2.0 * row
