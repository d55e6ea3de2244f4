"""Merges the batches of a run into `orbits.h5` and `summary.parquet`."""

import contextlib
import hashlib
from collections.abc import Callable

import h5py
import numpy as np

from ..language import phases
from ..language.errors import DamagedError
from . import durable
from .batch import ResultSchema
from .directory import FINAL_FILES, ORBITS_FILE, SUMMARY_FILE, RunDirectory
from .orbits import HDF5_LIBRARY_VERSIONS, write_orbits
from .read import StoredRun
from .record import read_record
from .summary import ROWS_IN_MEMORY, summary_groups, write_summary
from .worst import ComputePeakRevolutions, worst_cases, write_worst


def merge(
    run: RunDirectory,
    result_schema: ResultSchema,
    rows: np.ndarray,
    *,
    report: Callable[[str], None] = lambda _: None,
    compute_peak_revolutions: ComputePeakRevolutions = lambda worst: [None] * len(worst),
) -> dict[str, str]:
    """Write orbits.h5 and summary.parquet with exactly the cases in `rows`, unless present.

    rows : structured array with the fields `id`, `batch` and `row`, ascending by id.
    Return the hash of their content and their checksums, by which the next run recognises unchanged files.
    `report` receives a sentence for each changed file.  `compute_peak_revolutions` returns those of the worst cases.
    """
    content_hash = content_hash_of(run, result_schema, rows)
    record = read_record(run.path)
    recorded_checksums: dict[str, str] = record.get("merged", {})
    if recorded_checksums.get("mark") == content_hash:
        current_checksums = _checksums(run, content_hash)
        if current_checksums == recorded_checksums:
            try:
                StoredRun.check_merged(run.path, record)
                return recorded_checksums
            except DamagedError as error:
                report(f"{str(error).partition(';')[0]}; written again from the batches")
        for name in sorted(recorded_checksums):
            if current_checksums.get(name) != recorded_checksums[name]:
                state = "damaged (its checksum is not that in run.json)" if name in current_checksums else "missing"
                report(f"{name}: {state}; written again from the batches")
    worst = worst_cases(result_schema, lambda schema: summary_groups(run, schema, rows)) if result_schema.worst else []
    peaks = [
        (case, peak) for case, peak in zip(worst, compute_peak_revolutions(worst) if worst else [], strict=True) if peak
    ]
    with durable.storing(run.path):
        with contextlib.ExitStack() as exit_stack:
            summary, orbits = (
                exit_stack.enter_context(durable.atomic_file(run.path / name, run.scratch)) for name in FINAL_FILES
            )
            with phases.phase(f"writing {ORBITS_FILE}"):
                write_orbits(orbits, run, result_schema, rows, content_hash)
            if peaks:
                with h5py.File(orbits, "r+", libver=HDF5_LIBRARY_VERSIONS) as file:
                    write_worst(file, result_schema, peaks)
            with phases.phase(f"writing {SUMMARY_FILE}") as writing:
                write_summary(
                    summary,
                    run,
                    result_schema,
                    rows,
                    content_hash,
                    lambda _, written_rows: writing.note(share=written_rows / len(rows)),
                )
            for path in (summary, orbits):
                durable.sync(path)
        durable.sync(run.path)
        with phases.phase("computing checksums"):
            return _checksums(run, content_hash)


def content_hash_of(run: RunDirectory, result_schema: ResultSchema, rows: np.ndarray) -> str:
    """Return a hash of the content of the merged files, which is stored in both files.

    It is computed from the names of the batches, since these contain hashes of their content.
    """
    digest = hashlib.sha256(result_schema.content.encode())
    for column in ("id", "row"):
        digest.update(rows[column].tobytes())
    names = np.array([batch.name for batch in run.batches], "S")
    for start in range(0, len(rows), ROWS_IN_MEMORY):
        digest.update(names[rows["batch"][start : start + ROWS_IN_MEMORY]].tobytes())
    return digest.hexdigest()[:16]


def _checksums(run: RunDirectory, content_hash: str) -> dict[str, str]:
    paths = [run.path / name for name in FINAL_FILES]
    return {"mark": content_hash} | {path.name: durable.checksum(path) for path in paths if path.exists()}
