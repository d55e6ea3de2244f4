"""Finishes a block: its batches become a sorted summary, orbits, the index of its cases, a sample and its mark."""

import contextlib
import fcntl
from collections.abc import Callable
from typing import Any, Protocol

import h5py
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from . import durable
from .assemble import content_hash_of
from .batch import ResultSchema
from .blocks import SAMPLE_FILE, Block, Division, Sampler, read_mark, write_mark
from .columns import values_of, words_of
from .directory import DATASET, IDS_FILE, LOCK, ORBITS_FILE, SUMMARY_FILE
from .orbits import HDF5_LIBRARY_VERSIONS, write_orbits
from .summary import repetitive_columns, summary_groups, write_summary
from .worst import ComputePeakRevolutions, worst_cases, write_worst


class Facts(Protocol):
    """Counts of the cases of a block, and the cases that it mentions."""

    def add(self, block: dict[str, np.ndarray], /) -> None:
        """Add the columns of some cases."""

    def case_ids(self) -> set[str]:
        """Return the cases mentioned so far."""

    def counts(self) -> dict[str, Any]:
        """Return the counts for JSON."""


def finish_block(  # noqa: PLR0913 - the block, its content, what is made of it
    block: Block,
    division: Division,
    result_schema: ResultSchema,
    requested: np.ndarray,
    facts: Facts,
    compute_peak_revolutions: ComputePeakRevolutions = lambda worst: [None] * len(worst),
    report: Callable[[str], None] = lambda _: None,
) -> dict[str, Any]:
    """Write the final files of a block, whose batches are committed; return its mark.

    requested : identities of the cases in the block, ascending.  `report`, `compute_peak_revolutions` : as in `merge`.
    """
    block.directory(result_schema)
    with durable.open_lock(block.path / LOCK) as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)  # an abandoned driver may finish the block at the same time
        return _finish(block, division, result_schema, (requested, facts, compute_peak_revolutions, report))


def _finish(
    block: Block,
    division: Division,
    result_schema: ResultSchema,
    content: tuple[np.ndarray, Facts, ComputePeakRevolutions, Callable[[str], None]],
) -> dict[str, Any]:
    """Write the files of `finish_block` under the lock of the block."""
    requested, facts, compute_peak_revolutions, report = content
    run = block.directory(result_schema)
    for sentence in run.load_batches().values():
        report(f"{block.path}: {sentence}; its cases run again")
    rows = run.rows()
    stored_count = len(rows)
    if not np.array_equal(rows["id"], requested):
        rows = rows[np.isin(rows["id"], requested, assume_unique=True)]
    content_hash = content_hash_of(run, result_schema, rows)
    existing = read_mark(block, division.fingerprint)
    if existing and existing["mark"] == content_hash:
        return existing

    def add_and_mention(columns: dict[str, np.ndarray]) -> set[str]:
        facts.add(columns)
        return facts.case_ids()

    sampler = Sampler(division.sampled, add_and_mention)
    worst = (
        worst_cases(result_schema, lambda schema: summary_groups(run, schema, rows))
        if result_schema.worst and len(rows)
        else []
    )
    peaks = [
        (case, peak) for case, peak in zip(worst, compute_peak_revolutions(worst) if worst else [], strict=True) if peak
    ]
    with durable.storing(block.path):
        durable.discard(block.mark)
        durable.make_folder(block.run / DATASET)
        with contextlib.ExitStack() as exit_stack:
            targets = {
                name: exit_stack.enter_context(durable.atomic_file(path, run.scratch))
                for name, path in block.files.items()
            }
            write_orbits(targets[ORBITS_FILE], run, result_schema, rows, content_hash)
            if peaks:
                with h5py.File(targets[ORBITS_FILE], "r+", libver=HDF5_LIBRARY_VERSIONS) as file:
                    write_worst(file, result_schema, peaks)
            write_summary(
                targets[SUMMARY_FILE],
                run,
                result_schema,
                rows,
                content_hash,
                lambda table, _: sampler.add(table, _columns(table)),
            )
            targets[IDS_FILE].write_bytes(np.ascontiguousarray(rows["id"]).astype("<u8").tobytes())
            schema = pq.read_schema(targets[SUMMARY_FILE])
            with pq.ParquetWriter(targets[SAMPLE_FILE], schema, write_page_checksum=True) as writer:
                writer.write_table(sampler.table(schema))
            for path in targets.values():
                durable.sync(path)
        durable.sync(block.path)
        durable.sync(block.run / DATASET)
    failed = int(np.count_nonzero(rows["failed"]))
    return write_mark(
        block,
        {
            "form": division.fingerprint,
            "mark": content_hash,
            "cases": len(requested),
            "ok": len(rows) - failed,
            "failed": failed,
            "missing": len(requested) - len(rows),
            "others": stored_count - len(rows),
            "drawn": sampler.random_count,
            "ranges": sampler.ranges,
            "counts": facts.counts(),
        },
        run.scratch,
    )


def _columns(table: pa.Table) -> dict[str, np.ndarray]:
    """Return the columns of some rows of a summary as `values_of` does."""
    repeated = {*repetitive_columns(table.schema)}
    return {
        name: (words_of if name in repeated else values_of)(table[name].combine_chunks()) for name in table.column_names
    }
