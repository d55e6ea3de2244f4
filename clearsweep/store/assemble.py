"""Merges the batches of a run into `orbits.h5` and `summary.parquet`."""

import contextlib
import hashlib
from collections.abc import Callable

import h5py
import numpy as np

from ..language import phases
from . import durable
from .batch import ResultSchema
from .directory import FINAL_FILES, ORBITS_FILE, SUMMARY_FILE, RunDirectory
from .orbits import FORMAT, write_orbits
from .record import read_record
from .summary import HELD_ROWS, summary_groups, write_summary
from .worst import Again, worst_cases, write_worst


def merge(
    run: RunDirectory,
    form: ResultSchema,
    rows: np.ndarray,
    *,
    say: Callable[[str], None] = lambda _: None,
    again: Again = lambda worst: [None] * len(worst),
) -> dict[str, str]:
    """Write orbits.h5 and summary.parquet with exactly the cases in `rows` (ROWS, ascending by id), unless present.

    Return what informs the next run whether they are still what they should be: the mark of their content, checksums.
    `say` is given a sentence for each that is not.  `again` computes the revolution of the largest peak of the worst
    cases.
    """
    mark = mark_of(run, form, rows)
    known: dict[str, str] = read_record(run.path).get("merged", {})
    if known.get("mark") == mark:
        merged = _merged(run, mark)
        if merged == known:
            return known
        for name in sorted(known):
            if merged.get(name) != known[name]:
                state = "damaged (its checksum is not that in run.json)" if name in merged else "missing"
                say(f"{name}: {state}; written again from the batches")
    worst = worst_cases(form, lambda schema: summary_groups(run, schema, rows)) if form.worst else []
    peaks = [(case, peak) for case, peak in zip(worst, again(worst) if worst else [], strict=True) if peak]
    with durable.storing(run.path):
        with contextlib.ExitStack() as finished:
            summary, orbits = (
                finished.enter_context(durable.publishing(run.path / name, run.scratch)) for name in FINAL_FILES
            )
            with phases.phase(f"writing {ORBITS_FILE}"):
                write_orbits(orbits, run, form, rows, mark)
            if peaks:
                with h5py.File(orbits, "r+", libver=FORMAT) as file:
                    write_worst(file, form, peaks)
            with phases.phase(f"writing {SUMMARY_FILE}") as writing:
                write_summary(summary, run, form, rows, mark, lambda _, before: writing.note(share=before / len(rows)))
            for path in (summary, orbits):
                durable.sync(path)
        durable.sync(run.path)
        with phases.phase("computing checksums"):
            return _merged(run, mark)


def mark_of(run: RunDirectory, form: ResultSchema, rows: np.ndarray) -> str:
    """Return a hash of the content of the merged files, which both carry: batches are named by their content."""
    digest = hashlib.sha256(form.content.encode())
    for column in ("id", "row"):
        digest.update(rows[column].tobytes())
    names = np.array([batch.name for batch in run.batches], "S")
    for start in range(0, len(rows), HELD_ROWS):
        digest.update(names[rows["batch"][start : start + HELD_ROWS]].tobytes())
    return digest.hexdigest()[:16]


def _merged(run: RunDirectory, mark: str) -> dict[str, str]:
    paths = [run.path / name for name in FINAL_FILES]
    return {"mark": mark} | {path.name: durable.checksum(path) for path in paths if path.exists()}
