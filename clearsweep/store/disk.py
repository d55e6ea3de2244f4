"""Disk use of a run, and removal of files that are no longer needed."""

import os
import stat
from collections.abc import Iterable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..language import wording
from . import durable
from .batch import HASH_LENGTH, ResultSchema, hash_in_name, id_text
from .directory import ANSWER_FILE, ANSWER_FILES, FINAL_FILES, RunDirectory, batch_files_in
from .read import verify
from .record import RECORD_FILE, check_format, is_finished, read_record

RESULT_FILES = (*FINAL_FILES, *ANSWER_FILES, ANSWER_FILE, RECORD_FILE)

#: Removable files: kind -> description, in the order of the report.
KINDS = {
    "writes": "incomplete files of processes that were killed",
    "histories": "histories without a summary",
    "repeated": "batches whose cases were all computed again",
    "lives": "stored blocks of finished lives",
    "damaged": "copies of damaged batches",
    "batches": "batches of a finished run",
}


class UnneededFiles(NamedTuple):
    """Unneeded files of one kind."""

    kind: str  # of KINDS
    paths: tuple[Path, ...]
    size: int  # bytes


def clean(directory: Path, *, batches: bool = False, dry_run: bool = False) -> dict[str, Any]:
    """Remove the unneeded files of a run; return the removed and the remaining files, for JSON.

    `batches`: also the batches of a finished run, whose files are checked first.  Another grid then computes all its
    cases in this directory.  `dry_run`: nothing is removed.  `other_cases` counts cases of removed batches that the
    last grid does not contain.  Sizes are in bytes.

    Raise DirectoryError if there is no run, a run is active, or a file that would remain is damaged.
    """
    record = read_record(directory)
    check_format(directory, record)
    run = RunDirectory(directory)
    run.result_schema = ResultSchema.of_record(record)
    with run.locked():
        finished = is_finished(record)
        if batches and finished:
            verify(directory, record)
        damage = run.load_batches(histories=False)
        removable = unneeded_files(run, damage, batches=batches and finished)
        counts = record.get("counts", {})
        unused_rows = len(run.rows()) - counts.get("ok", 0) - counts.get("failed", 0) if batches and finished else 0
        for path in (path for unneeded in removable for path in unneeded.paths if not dry_run):
            durable.discard(path)
        if not dry_run:
            durable.remove_temporaries(run.scratch, remove_folder=True)
            for folder in (run.orbits, run.summaries):
                durable.sync(folder)
    sizes = disk_use(directory)
    return {
        "directory": str(directory),
        "finished": finished,
        "dry_run": dry_run,
        "removed": [
            {"kind": unneeded.kind, "files": len(unneeded.paths), "bytes": unneeded.size} for unneeded in removable
        ],
        "bytes": sum(unneeded.size for unneeded in removable),
        "other_cases": max(unused_rows, 0),
        "left": sizes,
    }


def unneeded_files(run: RunDirectory, damage: Iterable[Path] = (), *, batches: bool = False) -> list[UnneededFiles]:
    """Return the unneeded files in the directory of `run`; only files that a run wrote.

    `damage`: damaged summaries; they and their histories remain for the next run.
    """
    rows = run.rows()
    used = {int(number) for number in np.unique(rows["batch"])}
    repeated = [batch for number, batch in enumerate(run.batches) if number not in used]
    unneeded = run.batches if batches else repeated
    orbit_files = {batch.orbits for batch in run.batches}
    damaged_batches = {path.name.partition("-")[0] for path in damage}
    unused = [path for path in batch_files_in(run.orbits) if path not in orbit_files]
    unused = [
        path for path in unused if path.name.partition("-")[0] not in damaged_batches and _has_named_checksum(path)
    ]
    finished_ids = set(map(id_text, rows["id"][~rows["failed"]].tolist()))
    lives = [path for case_id, path in durable.find_life_logs(run.scratch).items() if case_id in finished_ids]
    removable = {
        "writes": [*durable.find_temporaries(run.scratch), *durable.find_temporaries(run.path)],
        "histories": unused,
        "lives": lives,
        "damaged": [path for folder in (run.orbits, run.summaries) for path in durable.find_set_aside(folder)],
        "batches" if batches else "repeated": [
            path for batch in unneeded for path in (batch.summary, batch.orbits) if path
        ],
    }
    return [
        UnneededFiles(kind, tuple(removable[kind]), sum(map(_size, removable[kind])))
        for kind in KINDS
        if removable.get(kind)
    ]


def disk_use(directory: Path) -> dict[str, int]:
    """Return the sizes in bytes of the results, of the batches, of other files (pages), and of all."""
    sizes = {"results": 0, "batches": 0, "other": 0}
    run = RunDirectory(directory)
    for folder, _, names in os.walk(directory):
        for path in (Path(folder) / name for name in names):
            batch = path.parent in (run.orbits, run.summaries)
            result = path.parent == directory and path.name in RESULT_FILES
            sizes["batches" if batch else "results" if result else "other"] += _size(path)
    return sizes | {"all": sum(sizes.values())}


def clean_text(facts: dict[str, Any]) -> str:
    """Return the result of `clean` as text."""
    verb = "would be removed" if facts["dry_run"] else "removed"
    lines = [
        f"{facts['directory']}: {wording.bytes_text(facts['bytes'])} {verb}",
        *(
            f"  {KINDS[fact['kind']]}: {wording.count_text(fact['files'], 'file')}, {wording.bytes_text(fact['bytes'])}"
            for fact in facts["removed"]
        ),
    ]
    if facts["other_cases"]:
        lines.append(
            f"  of these {wording.count_text(facts['other_cases'], 'case')} that the last grid does not contain"
        )
    lines.append(f"Disk: {disk_use_text(facts['left'])}")
    keeps_batches = not any(fact["kind"] == "batches" for fact in facts["removed"])
    if facts["finished"] and facts["left"]["batches"] and keeps_batches:
        lines.append("--batches also removes the batches; a changed grid then computes all cases again")
    if not facts["finished"]:
        lines.append("The run is not finished, so its batches are kept; run the same command again to continue")
    return "\n".join(lines)


def disk_use_text(sizes: dict[str, int]) -> str:
    """Return the sizes from `disk_use` as '52 MB: results 20 MB, batches 32 MB'."""
    parts = [f"{name} {wording.bytes_text(sizes[name])}" for name in ("results", "batches", "other") if sizes[name]]
    return f"{wording.bytes_text(sizes['all'])}: {', '.join(parts)}"


def _has_named_checksum(path: Path) -> bool:
    """Return whether a file of a batch has the checksum in its name."""
    return durable.checksum(path)[:HASH_LENGTH] == hash_in_name(path)


def _size(path: Path) -> int:
    """Return the size of a regular file in bytes, otherwise 0."""
    try:
        entry = os.lstat(path)
    except FileNotFoundError:  # files of an active run
        return 0
    return entry.st_size if stat.S_ISREG(entry.st_mode) else 0
