"""The order of work of a sweep: check, lock, see what is missing, compile once, fan out, merge."""

import errno
import shutil
import time
from collections.abc import Mapping
from concurrent.futures import BrokenExecutor, Future
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any, NamedTuple, Self

import numpy as np

from .. import grid as grids
from .. import resources, store
from ..case import Case
from ..errors import DirectoryError, InputError, brief
from . import executors, progress, rounds, signals
from .driver import Batches, Driver
from .refining import Refined, Refining
from .seeking import Answer, Seeking
from .shard import Shard, each_once
from .simulator import SIMULATION
from .worker import Job, Simulator

SAMPLED_CASES = 200  # cases looked at for derived values and warnings
MOST_WARNINGS = 5
LONGEST_FILE = f"parts/{'x' * 60}"  # no name below a run's directory is longer
LONGEST_TIMEOUT = 1e8  # s, three years

Source = (
    str | PathLike | Mapping | grids.Changed | grids.Grid
)  # a grid file, a dict of the same shape, or what it was read to


@dataclass(frozen=True)
class RunResult:
    """What a run came to; the results themselves are in `directory`.

    Counts of cases: `cases` of the grid, `ran` this time, `reused` from before; `ok`, `failed` and `missing` of the
    grid's cases as they are now, `others` in the directory with other values on the axes. `seconds` is the run's wall
    time, `case_seconds` the sum over the cases that ran, `start_up` the part of `seconds` before the first case could
    begin.
    """

    directory: Path
    cases: int
    ran: int
    reused: int
    ok: int
    failed: int
    missing: int
    others: int  # cases of other values on the axes that stay stored
    seconds: float
    case_seconds: float
    start_up: float
    derived: dict[str, dict[str, Any]]  # name -> {"unit", "min", "max"}
    warnings: tuple[str, ...]
    joined: int = 0  # directories that were joined; 0 for a run
    seek: grids.Seek | None = None  # what was sought
    answers: tuple[Answer, ...] = ()  # what was found
    refined: Refined | None = None  # what `refine` came to; None where it was not asked for or was stopped

    @property
    def exit_code(self) -> int:
        """Return 3 where cases failed or were left, else 0."""
        return 3 if self.failed or self.missing else 0

    def open(self) -> store.StoredRun:
        """Return the results as clearsweep.open would."""
        return store.open(self.directory)


class Options(NamedTuple):
    """How a sweep runs; `sweep` says what each means."""

    jobs: int | None = None
    executor: str = "local"
    scheduler: str | None = None
    retry_failed: bool = False
    case_timeout: float | None = None
    max_failures: int | str | None = None
    shard: str | None = None
    show_progress: bool = True


def sweep(  # noqa: PLR0913 - options that a user gives by name, as on the command line
    source: Source,
    out: str | Path | None = None,
    *,
    jobs: int | None = None,
    executor: str = "local",
    scheduler: str | None = None,
    retry_failed: bool = False,
    case_timeout: float | None = None,
    max_failures: int | str | None = None,
    shard: str | None = None,
    show_progress: bool = True,
) -> RunResult:
    """Run the cases of a grid that `out` does not hold yet, merge all of them, return the counts.

    Parameters
    ----------
    source : path of a grid file, dict of the same shape, or Grid.
    out : directory; default results/<name of the grid>.
    jobs : number of worker processes; default the number of cores this process may use.
    executor : 'local' (processes), 'serial' (this process) or 'dask' (a cluster).
    scheduler : address of the cluster's scheduler; default a new cluster on this machine.
    retry_failed : run cases again that failed before.
    case_timeout : s a case may take; a longer one gets the status 'timeout'.
    max_failures : int, or text such as '5%' of the cases to run: stop when more than that have failed.
    shard : text such as '2/8': run only the second of eight parts of the cases; `merge` joins them.
    show_progress : tell stderr how far it is.

    Raises InputError for a grid or an option that cannot be used, DirectoryError for a directory that does not fit,
    StorageError where writing fails, and Stopped, a KeyboardInterrupt, after a signal.
    """
    options = Options(
        jobs, executor, scheduler, retry_failed, case_timeout, max_failures, shard, show_progress=show_progress
    )
    return run_sweep(source, out, options)


def run_sweep(source: Source, out: str | Path | None, options: Options, simulator: Simulator = SIMULATION) -> RunResult:
    """Run a grid as `sweep` does, its cases by `simulator`."""
    begin = time.monotonic()
    check(options)
    _most(options.max_failures, 0)
    grid = load(source, simulator)
    grids.check_memory(grids.largest_history(grid))
    shard = None if options.shard is None else Shard.read(options.shard)
    if shard and grid.seek:
        raise InputError("shard: the probes of `seek` follow from one another; divide the values of the other axes")
    if shard and grid.refine:
        raise InputError(
            "shard: the cases that `refine` adds follow from all others; run the shards of the grid without it, merge "
            "them, and run the grid with it where they were merged to"
        )
    ids = case_ids(grid)
    wanted = shard.ids(ids) if shard else each_once(ids)
    derived, warnings = facts(grid, simulator)
    known = {"derived": derived, "warnings": warnings, "shard": shard and str(shard)}
    search = Seeking(grid) if grid.seek else Refining(grid) if grid.refine else None
    with signals.catching(), directory_of(grid, out, shard).open_for(grid, counts={"cases": len(wanted)}) as directory:
        start = store.now()
        for sentence in directory.recover():
            progress.say(sentence)
        with Crew(directory, options, simulator) as crew:
            if search:
                grid, complete = rounds.run(grid, search, crew.look)
                wanted = each_once(case_ids(grid))
            else:
                complete = crew.run(grid, ids, wanted)
        del ids  # 8 MB of a million cases, which merging needs
        answers = search.answers() if isinstance(search, Seeking) and complete else []
        store.write_answers(directory, store.Form.of(grid), grid.seek.path if grid.seek else "", answers)
        counts: dict[str, Any] = conclude(directory, grid, wanted, ran=crew.ran, start=start, **known)
    return RunResult(
        directory.path,
        **counts,
        seconds=time.monotonic() - begin,
        case_seconds=crew.case_seconds,
        start_up=(crew.ready or begin) - begin,
        derived=derived,
        warnings=tuple(warnings),
        seek=grid.seek,
        answers=tuple(answers),
        refined=search.result() if isinstance(search, Refining) and complete else None,
    )


class Crew:
    """The workers of a run, which are started when the first case is missing and do the cases of one grid or several.

    `ran`, `case_seconds` : number of cases and s of work in all; `ready` : when the first case could begin, None: none.
    """

    def __init__(self, directory: store.RunDirectory, options: Options, simulator: Simulator):
        self.directory, self.options, self.simulator = directory, options, simulator
        self.workers: executors.Executor | None = None
        self.ran, self.case_seconds = 0, 0.0
        self.ready: float | None = None
        self.tried: list[np.ndarray] = []  # identities of cases, which are not tried again however they ended

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        if self.workers is not None:
            self.workers.close()

    def run(self, grid: grids.Grid, ids: np.ndarray, wanted: np.ndarray) -> bool:
        """Run the cases of a grid that are missing; return False where too many failed and the rest was left.

        ids : of all cases by index; wanted : of those that are to be there, ascending.
        """
        pending = missing(ids, wanted, self.directory.rows(), retry_failed=self.options.retry_failed)
        for tried in self.tried:
            pending = pending[~within(ids[pending], tried)]
        if not len(pending):
            return True
        grids.check_disk(len(pending) * grids.largest_history(grid), shutil.disk_usage(self.directory.path).free)
        workers = self._hired(grid, pending)
        job = Job(self.directory.path.resolve(), grid, self.simulator, self.options.case_timeout)
        batches = Batches(pending, ids, workers.jobs, grids.usual_history(grid))
        with progress.of(len(pending), wanted=self.options.show_progress) as display:
            most_failures = _most(self.options.max_failures, len(pending))
            driver = Driver(workers, self.directory, job, batches, most_failures, display)
            done = driver.run()
        self.ran, self.case_seconds = self.ran + driver.ran, self.case_seconds + driver.case_seconds
        self.tried.append(np.sort(ids[pending]))
        return done

    def look(self, grid: grids.Grid, first: int) -> store.Judged | None:
        """Run the cases of a grid that are missing; return how those from the index `first` on stand to their limits.

        None where some were left.
        """
        ids = case_ids(grid)
        if not self.run(grid, ids, np.sort(ids)):
            return None
        rows = self.directory.rows()
        return store.judge(self.directory, store.Form.of(grid), rows[np.searchsorted(rows["id"], ids[first:])])

    def _hired(self, grid: grids.Grid, pending: np.ndarray) -> executors.Executor:
        """Return the workers, started and their code compiled."""
        if self.workers is None:
            jobs = self.options.jobs or executors.cores()
            jobs = min(jobs, len(pending))
            self.workers = executors.EXECUTORS[self.options.executor](jobs, self.options.scheduler, self.simulator.load)
            warm(self.workers, grid, pending, self.simulator)
            self.ready = time.monotonic()
        return self.workers


def load(source: Source, simulator: Simulator = SIMULATION) -> grids.Grid:
    """Return the grid in `source`, which may be one already."""
    return source if isinstance(source, grids.Grid) else grids.load(source, simulator.catalogue())


def directory_of(grid: grids.Grid, out: str | Path | None = None, shard: Shard | None = None) -> store.RunDirectory:
    """Return the directory of the results of `grid`, or of one shard of it."""
    name = f"{grid.name}-shard-{shard.number}-of-{shard.of}" if shard else grid.name
    path = Path(out) if out else Path("results") / name
    try:
        (path / LONGEST_FILE).stat()
    except OSError as error:
        if error.errno == errno.ENAMETOOLONG:
            raise DirectoryError(f"{resources.too_long(str(path))} with --out") from None
    return store.RunDirectory(path)


def conclude(
    directory: store.RunDirectory, grid: grids.Grid, wanted: np.ndarray, *, ran: int, **known: Any
) -> dict[str, int]:
    """Merge the results of the wanted cases, write run.json with what is `known` of the run; return the counts."""
    rows = directory.rows()
    stored = len(rows)
    asked = within(rows["id"], wanted)
    rows = rows if asked.all() else rows[asked]
    merged = store.merge(directory, store.Form.of(grid), rows, say=progress.say)
    failed = int(np.count_nonzero(rows["failed"]))
    counts = {
        "cases": len(wanted),
        "ran": ran,
        "reused": max(len(rows) - ran, 0),
        "ok": len(rows) - failed,
        "failed": failed,
        "missing": len(wanted) - len(rows),
        "others": stored - len(rows),
    }
    directory.write_record(grid, end=store.now(), counts=counts, merged=merged, **known)
    return counts


def facts(grid: grids.Grid, simulator: Simulator) -> tuple[dict[str, dict[str, Any]], list[str]]:
    """Return the ranges of what is derived (name -> unit, min, max) and the warnings, over a sample of the cases."""
    ranges: dict[str, dict[str, Any]] = {}
    sentences: dict[str, None] = {}
    for path, fits in grid.fits.items():
        for known in fits:
            for kind, factor in (("radial", 1.0), ("diametral", 2.0)):
                ends = {"min": factor * known.low, "max": factor * known.high}
                ranges[f"{path} ({known.name}, {kind})"] = {"unit": "m", **ends}
    for index in np.unique(np.linspace(0, len(grid) - 1, SAMPLED_CASES).round().astype(int)).tolist():
        case = grid.case(index)
        for name, (value, unit) in simulator.derived(case).items():
            same = ranges.get(name, {"unit": unit})["unit"] == unit  # laws give one name different dimensions
            key = name if same else f"{name} [{unit}]"
            before = ranges.get(key, {"min": value, "max": value})
            ranges[key] = {"unit": unit, "min": min(before["min"], value), "max": max(before["max"], value)}
        sentences.update(dict.fromkeys(simulator.warnings(case)))
    return ranges, list(sentences)[:MOST_WARNINGS]


def case_ids(grid: grids.Grid) -> np.ndarray:
    """Return the identities of all cases as numbers, uint64, by index."""
    return np.fromiter(grid.identities(), "u8", len(grid))


def missing(ids: np.ndarray, wanted: np.ndarray, rows: np.ndarray, *, retry_failed: bool) -> np.ndarray:
    """Return the indices of the `wanted` cases (ascending) that are to run, each identity once.

    rows : what there is, ascending by id.
    """
    if retry_failed:
        rows = rows[~rows["failed"]]
    order = np.argsort(ids, kind="stable")
    sorted_ids = ids[order]
    keep = np.concatenate([[True], sorted_ids[1:] != sorted_ids[:-1]])[: len(ids)]
    keep &= within(sorted_ids, wanted)
    keep &= ~within(sorted_ids, rows["id"])
    return np.sort(order[keep])


def within(values: np.ndarray, those: np.ndarray) -> np.ndarray:
    """Return which of the values are among `those`, ascending; a fifth of np.isin's memory."""
    if not len(those):
        return np.zeros(len(values), bool)
    places = np.searchsorted(those, values)
    places[places == len(those)] = 0
    there: np.ndarray = those[places] == values
    return there


def kinds(grid: grids.Grid, pending: np.ndarray, simulator: Simulator) -> list[Case]:
    """Return one pending case for each kind of scene; only names of laws can change the kind."""
    if not any(isinstance(values[0], str) for values in grid.axes.values()):
        return [grid.case(int(pending[0]))]
    wanted = np.zeros(len(grid), bool)
    wanted[pending] = True
    firsts: dict[grids.Words, int] = {}
    for index, words in enumerate(grid.words()):
        if wanted[index] and words not in firsts:
            firsts[words] = index
    cases = [grid.case(index) for index in firsts.values()]
    return list({simulator.signature(case): case for case in cases}.values())


def warm(workers: executors.Executor, grid: grids.Grid, pending: np.ndarray, simulator: Simulator) -> None:
    """Compile all that the cases need, so that every worker finds it in the cache: each part once, in one of them.

    What fails there fails again as a case, where it is recorded.
    """
    cases = kinds(grid, pending, simulator)
    parts = [(simulator.compile_loop, cases[0]), *((simulator.compile_for, case) for case in cases)]
    try:
        failures = [_failure(future) for future in [workers.submit(*part) for part in parts]]
    except BrokenExecutor as error:
        failures = [error]
    if any(isinstance(failure, BrokenExecutor) for failure in failures):
        workers.restart()
    elif told := next(filter(None, failures), None):
        progress.say(f"compiling ahead failed ({brief(told)}); the cases themselves will tell")


def _failure(future: Future) -> Exception | None:
    try:
        future.result()
    except Exception as error:
        return error
    return None


def check(options: Options) -> None:
    """Raise InputError for options that do not hold or do not go together."""
    executor, jobs, case_timeout, scheduler = options.executor, options.jobs, options.case_timeout, options.scheduler
    if executor not in executors.EXECUTORS:
        raise InputError(f"executor: found {executor!r}; expected one of {', '.join(executors.EXECUTORS)}")
    if jobs is not None and jobs < 1:
        raise InputError(f"jobs: found {jobs}; expected a whole number of at least 1")
    if case_timeout is not None and not 0.0 < case_timeout <= LONGEST_TIMEOUT:
        raise InputError(
            f"case timeout: found {case_timeout:g} s; expected more than 0 s and at most {LONGEST_TIMEOUT:g} s; leave "
            "it out for no limit"
        )
    if case_timeout and executor == "serial":
        raise InputError("case timeout: the serial executor cannot end a case; use the local executor")
    if scheduler and executor != "dask":
        raise InputError(f"scheduler: the {executor} executor has none; write --executor dask, too")
    executors.allow_files(executor, jobs or executors.cores())
    if executor == "dask":
        executors.reach(scheduler)


def _most(max_failures: int | str | None, cases: int) -> int | None:
    """Return how many cases may fail, from a number or a percentage."""
    if max_failures is None:
        return None
    text = str(max_failures).strip()
    share = cases / 100.0 if text.endswith("%") else 1.0
    try:
        most = int(float(text.removesuffix("%")) * share)
    except (ValueError, OverflowError):
        most = -1
    if most < 0:
        raise InputError(f"max failures: found {max_failures!r}; expected a number of cases (20) or a share (5%)")
    return most
