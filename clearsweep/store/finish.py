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
from .assemble import mark_of
from .batch import ResultSchema, values_of, words_of
from .blocks import IDS_FILE, SAMPLE_FILE, Block, Cut, Sampler, read_mark, write_mark
from .directory import DATASET, LOCK, ORBITS_FILE, SUMMARY_FILE
from .orbits import FORMAT, write_orbits
from .summary import HELD_ROWS, repetitive, summary_groups, write_summary
from .worst import Again, worst_cases, write_worst


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
    cut: Cut,
    form: ResultSchema,
    wanted: np.ndarray,
    facts: Facts,
    again: Again = lambda worst: [None] * len(worst),
    say: Callable[[str], None] = lambda _: None,
) -> dict[str, Any]:
    """Write the final files of a block, whose batches are committed; return its mark.

    wanted : identities of the cases in the block, ascending.  `say`, `again` : as in `merge`.
    """
    block.directory(form.frame)
    with durable.opened_lock(block.path / LOCK) as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)  # an abandoned driver may finish the block at the same time
        return _finish(block, cut, form, (wanted, facts, again, say))


def _finish(
    block: Block,
    cut: Cut,
    form: ResultSchema,
    how: tuple[np.ndarray, Facts, Again, Callable[[str], None]],
) -> dict[str, Any]:
    """Write the files of `finish_block` under the lock of the block."""
    wanted, facts, again, say = how
    run = block.directory(form.frame)
    for sentence in run.look(rows_kept=HELD_ROWS).values():
        say(f"{block.path}: {sentence}; its cases run again")
    rows = run.rows()
    stored = len(rows)
    if not np.array_equal(rows["id"], wanted):
        rows = rows[np.isin(rows["id"], wanted, assume_unique=True)]
    mark = mark_of(run, form, rows)
    present = read_mark(block, cut.form)
    if present and present["mark"] == mark:
        return present

    def chosen(columns: dict[str, np.ndarray]) -> set[str]:
        facts.add(columns)
        return facts.case_ids()

    sampler = Sampler(cut.sampled, chosen)
    worst = worst_cases(form, lambda schema: summary_groups(run, schema, rows)) if form.worst and len(rows) else []
    peaks = [(case, peak) for case, peak in zip(worst, again(worst) if worst else [], strict=True) if peak]
    with durable.storing(block.path):
        durable.discard(block.mark)
        durable.make_folder(block.run / DATASET)
        with contextlib.ExitStack() as finished:
            places = {
                name: finished.enter_context(durable.publishing(path, run.scratch))
                for name, path in block.files.items()
            }
            write_orbits(places[ORBITS_FILE], run, form, rows, mark)
            if peaks:
                with h5py.File(places[ORBITS_FILE], "r+", libver=FORMAT) as file:
                    write_worst(file, form, peaks)
            write_summary(
                places[SUMMARY_FILE],
                run,
                form,
                rows,
                mark,
                lambda table, _: sampler.add(table, _columns(table)),
            )
            places[IDS_FILE].write_bytes(np.ascontiguousarray(rows["id"]).astype("<u8").tobytes())
            schema = pq.read_schema(places[SUMMARY_FILE])
            with pq.ParquetWriter(places[SAMPLE_FILE], schema, write_page_checksum=True) as writer:
                writer.write_table(sampler.table(schema))
            for path in places.values():
                durable.sync(path)
        durable.sync(block.path)
        durable.sync(block.run / DATASET)
    failed = int(np.count_nonzero(rows["failed"]))
    return write_mark(
        block,
        {
            "form": cut.form,
            "mark": mark,
            "cases": len(wanted),
            "ok": len(rows) - failed,
            "failed": failed,
            "missing": len(wanted) - len(rows),
            "others": stored - len(rows),
            "drawn": sampler.taken,
            "ranges": sampler.ranges,
            "counts": facts.counts(),
        },
        run.scratch,
    )


def _columns(table: pa.Table) -> dict[str, np.ndarray]:
    """Return the columns of some rows of a summary as `values_of` does."""
    words = {*repetitive(table.schema)}
    return {
        name: (words_of if name in words else values_of)(table[name].combine_chunks()) for name in table.column_names
    }
