"""Joins runs of one grid, such as its shards, into one run, and all cases in a directory into one."""

import contextlib
import dataclasses
import tempfile
import time
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from .. import grid as grids
from .. import store
from ..grid.sections.variations import VARYING_SECTIONS
from ..language import phases
from ..language.errors import DirectoryError
from . import blockwise
from .pool import system
from .pool.case_runner import SIMULATION, CaseRunner, Options, Shard, case_ids, distinct
from .pool.worker import Simulator
from .sweep import RunResult, conclude, facts

# Joins runs of one grid, such as its shards, into one run.

MAX_LISTED = 3  # cases or shards that a message lists


def merge(
    directories: Iterable[str | Path], out: str | Path, *, partial: bool = False, simulator: Simulator = SIMULATION
) -> RunResult:
    """Join runs of the same grid into `out`, with the same files as from one run of the grid.

    Directories of different grids, cases that disagree and, unless `partial`, missing cases are refused with a
    DirectoryError before anything is written.  Batches are hard-linked if possible, else copied; the
    directories are not changed.  `simulator` reads the grid.
    """
    begin = time.monotonic()
    out = Path(out)
    paths = list({Path(directory).resolve(): Path(directory) for directory in directories}.values())
    records = _read_records_of_same_grid(paths)
    grid = grids.load({key: records[0][key] for key in records[0]["keys"]}, simulator.catalogue())
    grid = dataclasses.replace(grid, **grids.as_written(records[0]))
    target = store.RunDirectory(out)
    target.check(grid)
    if target.record.exists() and out.resolve() not in {path.resolve() for path in paths}:
        paths.append(out)
    derived, warnings = _facts(grid, simulator, records[0])
    record_entries = {"start": min(record["start"] for record in records), "source": records[0]["source"]}
    record_entries |= {"derived": derived, "warnings": warnings, "joined": [str(path) for path in paths]}
    joined_runs = _JoinedRuns(paths, [record.get("shard") for record in records], grid, simulator, partial)
    join = _join_blocks if store.Division.of(grid) else _join_batches
    with system.catching():
        counts: dict[str, Any] = join(joined_runs, target, record_entries)
    seconds = time.monotonic() - begin
    return RunResult(out, **counts, seconds=seconds, derived=derived, warnings=tuple(warnings), joined=len(paths))


def _facts(
    grid: grids.Grid, simulator: Simulator, record: dict[str, Any]
) -> tuple[dict[str, dict[str, Any]], list[str]]:
    """Return the `facts` of a grid, or those in run.json if they need laws of one's own, which do not run for this."""
    if all(map(grids.has_run, grid.law_files)):
        return facts(grid, simulator)
    return record.get("derived", {}), record.get("warnings", [])


class _JoinedRuns(NamedTuple):
    """The runs to join, and their common grid."""

    paths: list[Path]
    shards: list[str | None]
    grid: grids.Grid
    simulator: Simulator
    partial: bool  # whether cases may be missing


def _join_batches(runs: _JoinedRuns, target: store.RunDirectory, record_entries: dict[str, Any]) -> dict[str, int]:
    """Join the batches of runs without blocks; return the counts."""
    sources = [store.RunDirectory(path) for path in runs.paths]
    for path in sources:
        path.check(runs.grid)
    rows = _checked_rows(sources)
    ids = distinct(case_ids(runs.grid))
    if not runs.partial:
        _check_complete(ids, rows, runs.shards)
    _check_agreement(store.ResultSchema.of(runs.grid), sources, rows)
    with target.open_for(runs.grid), CaseRunner(target, Options(), runs.simulator) as case_runner:
        target.discard_answer()
        for sentence in target.load_intact_batches():
            phases.print_line(sentence)
        for path in sources:
            target.link_batches(path)
        counts = conclude(case_runner, runs.grid, ids, **record_entries)
        store.commit_answer(target, store.open(target.path))
    return counts


def _join_blocks(runs: _JoinedRuns, target: store.RunDirectory, record_entries: dict[str, Any]) -> dict[str, int]:
    """Join runs in blocks one block at a time, so that memory does not grow with their number; return the counts."""
    grid, result_schema, division = runs.grid, store.ResultSchema.of(runs.grid), store.Division.of(runs.grid)
    assert division  # of a grid in blocks
    duplicates = blockwise.duplicate_indices(grid)
    job = blockwise.BlockJob(target.path.absolute(), grid, runs.simulator, Options(), division, None, duplicates)
    missing = 0
    for number in range(division.count):  # everything is checked before anything is written
        sources = _block_sources(runs.paths, number, result_schema)
        rows = _checked_rows(sources)
        ids = np.sort(job.cases(number)[1])
        if not runs.partial:
            _check_complete(ids, rows, runs.shards)
        missing += len(np.setdiff1d(ids, np.concatenate([np.empty(0, "u8"), *(row["id"] for row in rows)])))
        _check_agreement(result_schema, sources, rows)
    requested = blockwise.count_requested(job)
    with (
        target.open_for(grid, counts={"cases": requested}, blocks=blockwise.blocks_entry(job, [])),
        CaseRunner(target, Options(executor="serial"), runs.simulator) as case_runner,
    ):
        target.discard_answer()
        runner = blockwise.BlockRunner(job, case_runner)
        for number in range(division.count):
            sources = _block_sources(runs.paths, number, result_schema)
            _checked_rows(sources)
            runner.join(number, sources)
        outcome = blockwise.BlocksOutcome(runner.marks, 0, 0.0, complete=not missing)
        counts = blockwise.conclude(target, job, outcome, (0, requested), **record_entries)
        store.commit_answer(target, store.open(target.path))
    return counts


def _block_sources(paths: list[Path], number: int, result_schema: store.ResultSchema) -> list[store.RunDirectory]:
    """Return the directories of a block in several runs."""
    sources = [store.RunDirectory(store.Block(path, number).path) for path in paths]
    for source in sources:
        source.expect(result_schema)
    return sources


def _checked_rows(sources: list[store.RunDirectory]) -> list[np.ndarray]:
    """Return the location of each case in the batches of some directories; what is damaged is left out."""
    for source in sources:
        for sentence in source.load_batches(contents=True).values():
            phases.print_line(f"{source.path}: {sentence}; left out")
    return [source.rows() for source in sources]


def _read_records_of_same_grid(paths: list[Path]) -> list[dict[str, Any]]:
    """Return the run.json of every directory; DirectoryError if grids or versions differ."""
    records = [store.read_record(path) for path in paths]
    for source, record in zip(paths, records, strict=True):
        if not {"frame", "keys", "start"} <= record.keys():
            raise DirectoryError(
                f"{source / 'run.json'}: was not written by `clearsweep run`; remove this directory from the command"
            )
        if "merged" in record and "blocks" not in record:
            store.verify(source, record)
    first_settings = _deciding_settings(records[0])
    for source, record in zip(paths[1:], records[1:], strict=True):
        lines = store.difference_lines(
            f"{path}: {_short_text(first)} in the first, {_short_text(this)} in this one"
            for path, (first, this) in sorted(store.differing(first_settings, _deciding_settings(record)).items())
        )
        if lines:
            raise DirectoryError(
                f"{source}: contains results of another grid than {paths[0]}; "
                f"only shards of one grid can be merged; differences:{lines}"
            )
    return records


def _deciding_settings(record: dict[str, Any]) -> dict[str, Any]:
    """Return dotted path -> value of all settings that determine the cases of a run and their results."""
    sections = {section: record.get(section) or {} for section in VARYING_SECTIONS}
    axes = {f"{section}.{path}": values for section, paths in sections.items() for path, values in paths.items()}
    frame: dict[str, Any] = record.get("frame", {})
    return frame | axes


def _check_complete(ids: np.ndarray, rows: list[np.ndarray], shards: list[str | None]) -> None:
    """Raise DirectoryError if a case is in no directory."""
    missing = np.setdiff1d(ids, np.concatenate([row["id"] for row in rows]))
    if not len(missing):
        return
    divisions = {Shard.read(text).of for text in shards if text}
    remedy = "merge with --partial, then run the grid with --out there to compute the rest"
    if len(divisions) == 1 and all(shards):  # all of one division: list the missing shards
        parts = [Shard(k + 1, total) for total in divisions for k in range(total)]
        missing_shards = [str(shard) for shard in parts if np.isin(shard.ids(ids), missing).any()]
        remedy = f"run the rest of shard {_list_text(missing_shards)}, or {remedy}"
    examples = _list_text([store.id_text(value) for value in missing[: MAX_LISTED + 1].tolist()])
    raise DirectoryError(
        f"{len(missing):,} of {len(ids):,} cases are in none of these directories ({examples}); {remedy}"
    )


def _check_agreement(
    result_schema: store.ResultSchema, sources: list[store.RunDirectory], rows: list[np.ndarray]
) -> None:
    """Raise DirectoryError if a case in two directories differs in more than timing."""
    ids = np.concatenate([row["id"] for row in rows])
    row_numbers = np.concatenate([np.arange(len(row)) for row in rows])
    number = np.repeat(np.arange(len(rows)), [len(row) for row in rows])
    order = np.argsort(ids, kind="stable")
    repeats = np.flatnonzero(ids[order][1:] == ids[order][:-1])
    first, second = order[repeats], order[repeats + 1]
    for a, b in np.unique(np.column_stack([number[first], number[second]]), axis=0).tolist():
        is_pair = (number[first] == a) & (number[second] == b)
        numbers = row_numbers[first[is_pair]], row_numbers[second[is_pair]]
        difference = store.difference(result_schema, sources[a], rows[a][numbers[0]], sources[b], rows[b][numbers[1]])
        if difference:
            case_id, name, first_value, second_value = difference
            raise DirectoryError(
                f"case {case_id}: {name} is {_short_text(first_value)} in {sources[a].path} and "
                f"{_short_text(second_value)} in {sources[b].path}; remove one of them "
                "(chaotic motion differs between machines that round differently)"
            )


def _list_text(texts: list[str]) -> str:
    return ", ".join(texts[:MAX_LISTED]) + (", ..." if len(texts) > MAX_LISTED else "")


def _short_text(value: Any) -> str:
    text = "nothing" if value is None else repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."


# All cases in a directory as one run to read, including those of earlier grids.


@contextlib.contextmanager
def complete_run(directory: str | Path, simulator: Simulator = SIMULATION) -> Iterator[store.StoredRun]:
    """Yield a run that contains every committed case in `directory`.

    The run is assembled in a temporary directory, which needs as much space as the cases; `directory` is not changed.
    Raises DirectoryError if there is no run.
    """
    record = store.read_record(Path(directory))
    store.check_format(Path(directory), record)
    if "blocks" in record:  # all of its blocks belong to the last grid
        yield store.open(directory)
        return
    source = store.RunDirectory(directory)
    with phases.phase("reading the directory"):
        source.expect(store.ResultSchema.of_record(record))
        source.load_batches(contents=True)
    with tempfile.TemporaryDirectory(prefix="clearsweep-") as folder:
        grid = grids.load(store.keys_of_all(record, source), simulator.catalogue())
        store.check_version(Path(directory), record, grid)
        target = store.RunDirectory(Path(folder) / "run")
        with target.open_for(grid), CaseRunner(target, Options(), simulator) as case_runner:
            target.link_batches(source)
            derived, warnings = _facts(grid, simulator, record)
            outcome_facts = {"source": record.get("source"), "derived": derived, "warnings": warnings}
            conclude(case_runner, grid, target.rows()["id"], start=record.get("start"), **outcome_facts)
        yield store.open(target.path)
