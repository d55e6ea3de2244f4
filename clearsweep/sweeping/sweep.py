"""The order of work of a sweep: check, lock, find missing cases, compile once, distribute, merge."""

import errno
import inspect
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from os import PathLike
from pathlib import Path
from typing import Any, get_type_hints

import numpy as np

from .. import grid as grids
from .. import store
from ..contracts.results import Peak
from ..contracts.search import Found, FurtherRuns
from ..language import phases, wording
from ..language.errors import DamagedError, DirectoryError, InputError
from . import Options, blockwise, flags, nodes
from .facts import assumed_sentences
from .pool import executors, system
from .pool.case_runner import SIMULATION, CaseRunner, Shard, case_ids, distinct, failure_limit, is_common
from .pool.worker import Simulator

SAMPLED_CASES = 200  # cases examined for derived values and warnings
MOST_WARNINGS = 5
MOST_NAMED = 3  # paths that a line on another grid names
LONGEST_FILE = f"parts/{'x' * 60}"  # no name below a run's directory is longer
LONGEST_TIMEOUT = 1e8  # s, three years

Source = str | PathLike | Mapping | grids.OverriddenGrid | grids.Grid  # a grid file, a dict of the same form, or a Grid


@dataclass(frozen=True)
class RunResult:
    """Outcome of a run; the results themselves are in `directory`.

    Counts of cases: `cases` of the grid, `ran` this time, `reused` from before; `ok`, `failed` and `missing` of the
    grid's cases now, `others` in the directory with other values on the axes. `seconds` is the run's wall
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
    others: int  # stored cases with other values on the axes
    seconds: float
    derived: dict[str, dict[str, Any]]  # name -> {"unit", "min", "max"}
    warnings: tuple[str, ...]
    case_seconds: float = 0.0
    start_up: float = 0.0
    joined: int = 0  # number of joined directories; 0 for a run
    search_result: Any = None  # the grid's answer, a `contracts.search.Found`; None without a search or if stopped

    @property
    def exit_code(self) -> int:
        """Return 3 if cases failed or are missing, else 0."""
        return 3 if self.failed or self.missing else 0

    def open(self) -> store.StoredRun:
        """Return the results as `clearsweep.open` does."""
        return store.open(self.directory)


def sweep(source: Source, out: str | Path | None = None, **options: Any) -> RunResult:
    """Run the missing cases of a grid in `out`, merge all results, return the counts.

    Parameters
    ----------
    source : path of a grid file, dict of the same form, or Grid.
    out : directory; default results/<name of the grid>, where the run of another grid is moved aside.
    OPTIONS

    Raises InputError for an invalid grid or option, DirectoryError for an unsuitable directory,
    StorageError if writing fails, and Stopped, a KeyboardInterrupt, after a signal.
    """
    return run_sweep(source, out, Options(**options))


def _document(function: Any) -> None:
    """Add the options to the docstring and the signature of a function that takes them as keywords."""
    lines = "\n    ".join(f"{name} : {flag.text}" for name, flag in flags().items())
    function.__doc__ = (function.__doc__ or "").replace("OPTIONS", lines)
    own = [item for item in inspect.signature(function).parameters.values() if item.kind is not item.VAR_KEYWORD]
    keywords = [
        inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=Options._field_defaults[name], annotation=kind)
        for name, kind in get_type_hints(Options).items()
    ]
    function.__signature__ = inspect.Signature([*own, *keywords], return_annotation=RunResult)


_document(sweep)


def run_sweep(source: Source, out: str | Path | None, options: Options, simulator: Simulator = SIMULATION) -> RunResult:
    """Run a grid as `sweep` does, with the cases computed by `simulator`."""
    begin = time.monotonic()
    check(options)
    failure_limit(options.max_failures, 0)
    with phases.show_progress(options.show_progress), grids.allowing(options.trust_laws):
        with phases.phase("reading the grid"):
            grid = load(source, simulator)
        result = _run_sweep(grid, out, options, simulator, begin)
        if result.search_result is None:
            return result

        def run_further(further: dict[str, Any], directory: Path) -> store.StoredRun:
            further_grid = load(further, simulator)
            begin = time.monotonic()
            return _run_sweep(further_grid, directory, options._replace(fresh=False), simulator, begin).open()

        runs = FurtherRuns(simulator.catalogue(), result.directory, None if options.no_effects else run_further)
        search_result, entries = result.search_result.further(grid, result.open().grid, runs)
        if entries:
            with directory_of(grid, result.directory).open_for(grid) as directory:
                directory.add_to_record(**entries)
                store.commit_answer(directory, store.open(directory.path))  # which says what would help
        return replace(result, search_result=search_result)


def _run_sweep(
    grid: grids.Grid, out: str | Path | None, options: Options, simulator: Simulator, begin: float
) -> RunResult:
    """Run a grid; phases show the progress.  begin : s, monotonic time at which reading it began"""
    grids.check_memory(grids.recorded_history(grid))
    shard = None if options.shard is None else Shard.read(options.shard)
    division = _division_of(grid, shard, options)
    with phases.phase("checking the cases"):
        ids = blockwise.duplicate_indices(grid) if division else case_ids(grid)
        derived, warnings = facts(grid, simulator)
        warnings = [*assumed_sentences(grid), *warnings]
    record_entries: dict[str, Any] = {"derived": derived, "warnings": warnings, "shard": shard and str(shard)}
    active_search = grid.search.begin(grid, simulator) if grid.search else None
    directory = _cleared_directory(grid, out, shard, options)
    if division:
        job = blockwise.BlockJob(directory.path.absolute(), grid, simulator, options, division, shard, ids)
        begun = {"counts": {"cases": blockwise.count_requested(job)}, "blocks": blockwise.blocks_entry(job, [])}
    else:
        requested = shard.ids(ids) if shard else distinct(ids)
        begun = {"counts": {"cases": len(requested)}}
    search_result: Found | None = None
    with (
        system.catching(),
        directory.open_for(grid, **begun, **record_entries),
        phases.store_progress(store.Working(directory.path).replace_progress),
    ):
        record_entries["start"] = store.utc_now()
        directory.discard_answer()
        with phases.phase("reading the directory"):
            sentences = directory.load_intact_batches()
        for sentence in sentences:
            phases.print_line(sentence)
        with CaseRunner(directory, options, simulator) as case_runner:
            if division:
                counts = _run_blocks(job, case_runner, begun["counts"]["cases"], record_entries)
            else:
                if active_search:
                    grid, is_complete = case_runner.search(grid, active_search)
                    requested = distinct(case_ids(grid))
                    search_result = active_search.result() if is_complete else None
                else:
                    case_runner.run(grid, ids, requested)
                del ids  # 8 MB for a million cases, which merging needs
                if search_result and search_result.note:
                    record_entries["warnings"] = warnings = [*warnings, search_result.note]
                record_entries |= search_result.entries() if search_result else {}
                name, schema = grid.search.name if grid.search else "", store.ResultSchema.of(grid)
                record_entries["answers"] = store.write_search_table(directory, schema, name, search_result)
                counts = conclude(case_runner, grid, requested, **record_entries)
                del requested
                directory.batches = []  # 9 bytes a case, which the answer needs
                store.release_memory()
        if not division:
            store.commit_answer(directory, store.open(directory.path))
    return RunResult(
        directory.path,
        **counts,
        seconds=time.monotonic() - begin,
        derived=derived,
        warnings=tuple(warnings),
        case_seconds=case_runner.case_seconds,
        start_up=(case_runner.ready_time or begin) - begin,
        search_result=search_result,
    )


def _division_of(grid: grids.Grid, shard: Shard | None, options: Options) -> store.Division | None:
    """Return the division of a grid into blocks; raise InputError if it cannot run as the options say."""
    if shard and grid.search:
        raise InputError(f"shard: {grid.search.refusal_of_shards.format(name=grid.search.name)}")
    division = store.Division.of(grid, str(shard or ""))
    if grid.chained and (shard or division):
        raise InputError(
            f"simulate.start: carried takes every case from the end of another, so its {len(grid):,} cases are not "
            + ("divided into shards; run them without --shard" if shard else "cut into blocks; take fewer values")
        )
    if options.executor == executors.NODES and not division:
        raise InputError(
            f"executor: nodes assigns whole blocks of {store.block_size():,} cases to nodes, and this grid has "
            f"{len(grid):,} or is searched; write --executor dask"
        )
    return division


def _run_blocks(
    job: blockwise.BlockJob, case_runner: CaseRunner, requested: int, record_entries: dict[str, Any]
) -> dict[str, int]:
    """Run a grid in blocks, and commit its answer; return the counts."""
    directory = case_runner.directory
    while True:
        if job.options.executor == executors.NODES:
            outcome = nodes.run_on_nodes(job)
        else:
            outcome = blockwise.run_blocks(job, case_runner, directory)
        case_runner.case_seconds = outcome.case_seconds  # nodes have runners of their own
        counts = blockwise.conclude(directory, job, outcome, (outcome.ran, requested), **record_entries)
        try:
            store.commit_answer(directory, store.open(directory.path))
        except DamagedError as error:  # a checksum agrees with content that no run writes
            if not store.unmark_damaged(directory.path):
                raise
            phases.print_line(f"{str(error).partition(';')[0]}; written again from the batches")
        else:
            return counts


def load(source: Source, simulator: Simulator = SIMULATION) -> grids.Grid:
    """Return the grid in `source`, which may be a Grid already."""
    return source if isinstance(source, grids.Grid) else grids.load(source, simulator.catalogue())


def directory_of(grid: grids.Grid, out: str | Path | None = None, shard: Shard | None = None) -> store.RunDirectory:
    """Return the directory of the results of `grid`, or of one shard of it."""
    name = f"{grid.name}-shard-{shard.number}-of-{shard.of}" if shard else grid.name
    path = Path(out) if out else Path("results") / name
    try:
        (path / LONGEST_FILE).stat()
    except OSError as error:
        if error.errno == errno.ENAMETOOLONG:
            raise DirectoryError(f"{system.path_too_long_text(str(path))} with --out") from None
    return store.RunDirectory(path)


def latest_run(file: Path) -> tuple[Path, str]:
    """Return the directory of the latest run of a grid file, and a sentence on what changed in the file since, or ''.

    Raises DirectoryError if the grid was not run.
    """
    grid = load(file)
    directory = directory_of(grid)
    if not directory.record.exists():
        raise DirectoryError(f"{directory.path}: contains no run of {file}; `clearsweep run {file}` makes one")
    changed = [*store.grid_changes(store.read_record(directory.path), store.grid_record(grid))]
    if not changed:
        return directory.path, ""
    more = f" and {len(changed) - MOST_NAMED} more" if len(changed) > MOST_NAMED else ""
    return directory.path, (
        f"{file} has changed since the run in {directory.path}: {', '.join(changed[:MOST_NAMED])}{more}; this is the "
        f"report of that run, and `clearsweep run {file}` makes a new one"
    )


def _cleared_directory(
    grid: grids.Grid, out: str | Path | None, shard: Shard | None, options: Options
) -> store.RunDirectory:
    """Return the directory of the results of `grid`, from which an earlier run is moved aside where that is wanted.

    That is a run of another grid in the default directory, and with `fresh` any run.
    """
    directory = directory_of(grid, out, shard)
    moved = ""
    try:
        directory.check(grid)
        moved = "an earlier run" if options.fresh and directory.record.exists() else ""
    except store.OtherGridError as error:
        if out is not None and not options.fresh:
            raise
        moved = f"the run of another grid ({wording.sentence_list(error.differing[:MOST_NAMED])})"
    if moved:
        phases.print_line(f"{directory.path} contained {moved}, which is now in {directory.move_aside()}")
        directory = directory_of(grid, out, shard)
    return directory


def conclude(case_runner: CaseRunner, grid: grids.Grid, requested: np.ndarray, **record_entries: Any) -> dict[str, int]:
    """Merge the results of the wanted cases and write run.json; return the counts.

    The case runner knows the directory, and computes the peak revolutions of the worst cases.
    """
    directory, ran = case_runner.directory, case_runner.ran
    store.release_memory()
    rows = directory.rows()
    stored = len(rows)
    requested_ids = is_common(rows["id"], requested)
    rows = rows if requested_ids.all() else rows[requested_ids]
    result_schema = store.ResultSchema.of(grid)

    def peaks(worst: Sequence[store.Worst]) -> list[Peak | None]:
        activity = f"saving the revolution of the largest peak of {wording.count_text(len(worst), 'case')}"
        with phases.phase(activity):
            return case_runner.peaks(grid, worst)

    merged = store.merge(directory, result_schema, rows, report=phases.print_line, compute_peak_revolutions=peaks)
    failed = int(np.count_nonzero(rows["failed"]))
    counts = blockwise.counts_of(len(requested), ran, ok=len(rows) - failed, failed=failed, others=stored - len(rows))
    entries = {"answers": {}} | record_entries
    directory.write_record(grid, end=store.utc_now(), counts=counts, merged=merged, **entries)
    store.keep_histories_once(directory, result_schema, rows, merged[store.FINAL_FILES[1]])
    return counts


def facts(grid: grids.Grid, simulator: Simulator) -> tuple[dict[str, dict[str, Any]], list[str]]:
    """Return ranges of derived values (name -> unit, min, max) and warnings, over a sample of the cases."""
    ranges: dict[str, dict[str, Any]] = {}
    sentences: dict[str, None] = dict.fromkeys((*grid.warnings, *_angle_warnings(grid)))
    for path, fits in grid.fits.items():
        for fit in fits:
            radial = 0.5 if fit.is_group else 1.0
            for kind, factor in (("radial", radial), ("diametral", 2.0 * radial)):
                range_of_fit = {"min": factor * fit.low, "max": factor * fit.high}
                ranges[f"{path} ({fit.name}, {kind})"] = {"unit": "m", **range_of_fit}
    for figure_assumed in grid.library_values:
        unit, best_value, low, high = figure_assumed.value
        ranges[f"{figure_assumed.path} ({figure_assumed.name})"] = {"unit": unit, "min": best_value, "max": best_value}
        if low < high:
            ranges[f"{figure_assumed.path} ({figure_assumed.name}, range)"] = {"unit": unit, "min": low, "max": high}
    for index in dict.fromkeys(np.linspace(0, len(grid) - 1, SAMPLED_CASES).round().astype(int).tolist()):
        case = grid.case(index)
        for name, (value, unit) in simulator.derived(case).items():
            # laws may give one name different dimensions
            has_same_unit = ranges.get(name, {"unit": unit})["unit"] == unit
            key = name if has_same_unit else f"{name} [{unit}]"
            known_range = ranges.get(key, {"min": value, "max": value})
            ranges[key] = {"unit": unit, "min": min(known_range["min"], value), "max": max(known_range["max"], value)}
        sentences.update(dict.fromkeys(simulator.warnings(case)))
    return ranges, list(sentences)[:MOST_WARNINGS]


def _angle_warnings(grid: grids.Grid) -> list[str]:
    """Return warnings about angles of more than a revolution that are written without a unit."""
    warnings, written = [], dict(grids.leaves(grid.written_case(0)))
    for path in grid.assumed_units:
        values = grid.axes.get(path, [written.get(path)])
        largest = max((abs(value) for value in values if isinstance(value, float)), default=0.0)
        if largest > 2.0 * np.pi and grid.unit(path) == "rad":
            turned = f"{largest:g} rad, or {np.degrees(largest):.4g} deg"
            warnings.append(f"{path}: {largest:g} without a unit is {turned}; write {largest:g} deg if that is meant")
    return warnings


def check(options: Options) -> None:
    """Raise InputError for invalid or conflicting options."""
    executor, jobs, case_timeout, scheduler = options.executor, options.jobs, options.case_timeout, options.scheduler
    names = (*executors.EXECUTORS, executors.NODES)
    if executor not in names:
        raise InputError(f"executor: found {executor!r}; expected one of {', '.join(names)}")
    if jobs is not None and not (isinstance(jobs, int) and jobs >= 1):
        raise InputError(f"jobs: found {jobs!r}; expected a whole number of at least 1")
    if case_timeout is not None and not 0.0 < case_timeout <= LONGEST_TIMEOUT:
        raise InputError(
            f"case timeout: found {case_timeout:g} s; expected more than 0 s and at most {LONGEST_TIMEOUT:g} s; leave "
            "it out for no limit"
        )
    if case_timeout and executor == "serial":
        raise InputError("case timeout: the serial executor cannot end a case; use the local executor")
    if executor == executors.NODES and not scheduler:
        needed = "the address of a scheduler, each of whose workers is a node: --scheduler"
        raise InputError(f"executor: nodes needs {needed}")
    if scheduler and executor not in ("dask", executors.NODES):
        raise InputError(f"scheduler: the {executor} executor uses none; add --executor dask")
    executors.allow_files(executor, jobs or executors.cores())
    if executor in ("dask", executors.NODES):
        executors.check_scheduler(scheduler)
