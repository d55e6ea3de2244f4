"""State of a run directory: progress, active processes and damaged files, without running anything."""

import contextlib
import hashlib
import os
import stat
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ..language import phases, wording
from ..language.errors import DirectoryError
from ..language.wording import short_id
from . import durable
from .batch import HASH_LENGTH, ResultSchema, hash_in_name
from .blocks import Block, numbers_of_blocks, read_mark, verify_block
from .datasets import id_text
from .directory import (
    ANSWER_FILE,
    ANSWER_FILES,
    BLOCKS,
    DATASET,
    FINAL_FILES,
    ORBITS_FILE,
    SCRATCH,
    RunDirectory,
    batch_files_in,
)
from .read import verify
from .record import RECORD_FILE, check_format, is_finished, read_record

# ----------------------------------------------------------------------------------------------------------------------
# State of a long case until its row is committed, from which it resumes after its process was killed.


class Unfinished:
    """The log of a case: a temporary file, replaced as a whole, named by the identity of the case."""

    def __init__(self, directory: Path, case_id: str):
        """Prepare for a case of the run in a directory."""
        self.scratch = directory / SCRATCH
        self.path = durable.scratch_file(self.scratch, f"{case_id}.life")

    def read(self) -> bytes | None:
        """Return the last content, or None if there is none, or if it is damaged."""
        try:
            content = durable.read(self.path)
        except FileNotFoundError:
            return None
        checksum, _, payload = content.partition(b"\n")
        return payload if checksum == _log_checksum(payload) else None

    def keep(self, content: bytes) -> None:
        """Replace the content atomically."""
        with durable.storing(self.path):
            durable.replace(self.path, _log_checksum(content) + b"\n" + content, self.scratch)

    def discard(self) -> None:
        """Remove the content."""
        durable.discard(self.path)


def _log_checksum(content: bytes) -> bytes:
    return hashlib.sha256(content).hexdigest().encode()


# ----------------------------------------------------------------------------------------------------------------------
# The progress of a worker in its batch: a temporary file that the parent and `status` read.


class Working:
    """The file in which a process keeps its progress; `name` is that of its batch, its preparation, or `run`."""

    def __init__(self, directory: Path, name: str = "run"):
        """Prepare for a batch or preparation called `name` of the run in a directory; default: for the whole run."""
        self.path = durable.scratch_file(directory / SCRATCH, f"{name}.work")

    def replace_progress(self, content: bytes | None) -> None:
        """Replace the stored progress, which need not survive a crash; for None, remove the file."""
        with contextlib.suppress(OSError):  # a full disk, of which the batch itself reports
            if content is None:
                durable.discard(self.path)
            else:
                durable.overwrite_temporary(self.path, content)

    def read(self) -> phases.Progress | None:
        """Return the present progress, or None."""
        try:
            return phases.stored_progress(durable.read(self.path))
        except OSError:
            return None


def case_text(progress: phases.Progress) -> str:
    """Return the progress of a case as 'case 2 of 4 (3a0ed69e): block 7, 31 um of 50 um, 2 min spent, ...'."""
    facts = progress.facts
    if "case_id" not in facts:
        return progress.text
    return f"case {facts['case']:,} of {facts['cases']:,} ({short_id(facts['case_id'])}): {progress.text}"


# ----------------------------------------------------------------------------------------------------------------------
# Disk use of a run, and removal of files that are no longer needed.


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


def clean(directory: Path, *, batches: bool = False, dry_run: bool = False) -> dict[str, Any]:
    """Remove the unneeded files of a run; return the removed and the remaining files, for JSON.

    `batches`: also the batches of a finished run, whose files are checked first.  Another grid then computes all its
    cases in this directory.  `dry_run`: nothing is removed.  `other_cases` counts cases of removed batches that the
    last grid does not contain.  Sizes are in bytes.

    Raise DirectoryError if there is no run, a run is active, or a file that would remain is damaged.
    """
    record = read_record(directory)
    check_format(directory, record)
    run, merged = RunDirectory(directory, ResultSchema.of_record(record)), directory / ORBITS_FILE
    with run.locked():
        finished = is_finished(record)
        if batches and finished:
            verify(directory, record)
        damage = run.load_batches(histories=False)
        removable = unneeded_files(run, damage, batches=batches and finished)
        counts = record.get("counts", {})
        unused_rows = len(run.rows()) - counts.get("ok", 0) - counts.get("failed", 0) if batches and finished else 0
        removed = [
            {
                "kind": kind,
                "files": len(paths),
                "bytes": sum(_size(path) for path in paths if not _is_same_file(path, merged)),
            }
            for kind, paths in removable.items()
        ]
        if not dry_run:
            for path in (path for paths in removable.values() for path in paths):
                durable.discard(path)
            durable.remove_temporaries(run.scratch, remove_folder=True)
            for folder in (run.orbits, run.summaries):
                durable.sync(folder)
    sizes = disk_use(directory)
    return {
        "directory": str(directory),
        "finished": finished,
        "dry_run": dry_run,
        "removed": removed,
        "bytes": sum(entry["bytes"] for entry in removed),
        "other_cases": max(unused_rows, 0),
        "left": sizes,
    }


def unneeded_files(run: RunDirectory, damage: Iterable[Path] = (), *, batches: bool = False) -> dict[str, list[Path]]:
    """Return the unneeded files in the directory of `run` by kind; only files that a run wrote.

    `damage`: damaged summaries; they and their histories remain for the next run.
    """
    rows = run.rows()
    used = {*rows["batch"].tolist()}
    repeated = [batch for number, batch in enumerate(run.batches) if number not in used]
    used_files = {batch.orbits for number, batch in enumerate(run.batches) if number in used}
    unneeded = run.batches if batches else repeated
    orbit_files = {batch.orbits for batch in run.batches}
    damaged_batches = {path.name.partition("-")[0] for path in damage}
    unused = [path for path in batch_files_in(run.orbits) if path not in orbit_files]
    unused = [path for path in unused if path.name.partition("-")[0] not in damaged_batches]
    unused = [path for path in unused if durable.checksum(path)[:HASH_LENGTH] == hash_in_name(path)]
    finished_ids = set(map(id_text, rows["id"][~rows["failed"]].tolist()))
    logs = durable.find(run.scratch, durable.LIFE_LOG)
    removable = {
        "writes": [
            path for folder in (run.scratch, run.path) for path in durable.find(folder, durable.TEMPORARY).values()
        ],
        "histories": unused,
        "lives": [path for case_id, path in logs.items() if case_id in finished_ids],
        "damaged": [
            path for folder in (run.orbits, run.summaries) for path in durable.find(folder, durable.SET_ASIDE).values()
        ],
        "batches" if batches else "repeated": [
            path
            for path in dict.fromkeys(path for batch in unneeded for path in (batch.summary, batch.orbits))
            if path and (batches or path not in used_files)
        ],
    }
    return {kind: removable[kind] for kind in KINDS if removable.get(kind)}


def disk_use(directory: Path) -> dict[str, int]:
    """Return the sizes in bytes of the results, of the batches, of other files (pages), and of all."""
    sizes = {"results": 0, "batches": 0, "other": 0}
    run, merged = RunDirectory(directory), Path(directory, ORBITS_FILE)
    for folder, _, names in os.walk(directory):
        for path in (Path(folder) / name for name in names):
            if folder != str(directory) and _is_same_file(path, merged):
                continue  # a second name of the merged histories
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


def _is_same_file(path: Path, other: Path) -> bool:
    with contextlib.suppress(OSError):
        return os.path.samestat(os.lstat(path), os.lstat(other))
    return False


def _size(path: Path) -> int:
    """Return the size of a regular file in bytes, otherwise 0."""
    try:
        entry = os.lstat(path)
    except FileNotFoundError:  # files of an active run
        return 0
    return entry.st_size if stat.S_ISREG(entry.st_mode) else 0


# ----------------------------------------------------------------------------------------------------------------------


FINISHED, UNDER_WAY, INTERRUPTED, DAMAGED = "finished", "under way", "interrupted", "damaged"


def status(directory: Path, *, every_file: bool = False) -> dict[str, Any]:
    """Return the state of a run, ready for JSON; `every_file`: read every file and compare checksums.

    `cases` are those of the grid, `missing` those without a result; None while a run prepares other values of the
    axes than the last one.  `ok` and `failed` count finished cases.  `doing` is what a run does at present, `left` the
    time (s) until its cases are finished; None if unknown.  `at_work` has the progress of every
    worker with a long case: its activity, elapsed time, time left (s; None if unknown), for a life also the block and
    the wear (m).  `disk` has sizes in bytes.  `damage` has a sentence for each changed file.

    Raise DirectoryError if there is no run that can be read.
    """
    record = read_record(directory)
    check_format(directory, record)
    run = RunDirectory(directory, ResultSchema.of_record(record))
    holder, merged = run.holder(), "merged" in record
    blocks = blocks_state(directory, record, every_file=every_file) if "blocks" in record else None
    damage = (
        blocks[1]
        if blocks
        else [
            f"{directory}/{sentence}; its cases run again"
            for sentence in run.load_batches(histories=every_file, contents=every_file).values()
        ]
    )
    for name in (*FINAL_FILES, *ANSWER_FILES) if merged and not blocks else ():
        try:
            if every_file or name in ANSWER_FILES or not (directory / name).is_file():
                verify(directory, record, (name,))
        except DirectoryError as error:
            damage.append(str(error))
    state = DAMAGED if damage else UNDER_WAY if holder else FINISHED if is_finished(record) else INTERRUPTED
    progress = Working(directory).read() if holder else None
    return {
        "directory": str(directory),
        "name": record.get("name"),
        "state": state,
        "holder": holder,
        "at_work": [
            {**each.facts, "what": each.what, "seconds": each.seconds, "left": each.left, "text": case_text(each)}
            for batch in (durable.find(run.scratch, durable.PROGRESS) if holder else ())
            if (each := Working(directory, batch).read())
        ],
        **(blocks[0] if blocks else _count_cases(record, run, progress, working=holder is not None)),
        "doing": progress and progress.text,
        "left": progress and progress.left,
        "carried": _carried_facts(record),
        "start": record.get("start"),
        "end": record.get("end"),
        "files": {
            name: str(directory / name)
            for name in (*FINAL_FILES, DATASET, BLOCKS, *ANSWER_FILES, RECORD_FILE)
            if (directory / name).exists()
        },
        "disk": disk_use(directory),
        "every_file": every_file,
        "damage": damage,
    }


def blocks_state(
    directory: Path, record: dict[str, Any], *, every_file: bool
) -> tuple[dict[str, int | None], list[str]]:
    """Return the numbers of cases of a run in blocks, of finished ones, and the damage to their files."""
    ok = failed = 0
    damage = []
    listed, schema = set(record["blocks"]["numbers"]), ResultSchema.of_record(record)
    for number in sorted({*listed, *numbers_of_blocks(directory)}):
        block = Block(directory, number)
        mark, batches = read_mark(block), RunDirectory(block.path, schema)
        if mark is None:
            if number in listed:
                damage.append(
                    f"{block.path}: its block.json or another file is damaged or missing; the next run restores it"
                )
            batches.load_batches(histories=False)
        elif every_file:
            damage += verify_block(block, mark)
            sentences = batches.load_batches(contents=True).values()
            damage += [f"{block.path}/{sentence}; its cases run again" for sentence in sentences]
        counts = mark or _count_rows(batches)
        ok, failed = ok + counts["ok"], failed + counts["failed"]
    cases = record.get("counts", {}).get("cases")
    missing = None if cases is None else max(cases - ok - failed, 0)
    return {"cases": cases, "ok": ok, "failed": failed, "missing": missing}, damage


def _count_cases(
    record: dict[str, Any], run: RunDirectory, progress: phases.Progress | None, *, working: bool
) -> dict[str, int | None]:
    """Return numbers of cases: of the grid, with and without a good result, and without any."""
    if progress and (of_run := progress.facts.get("run")):
        return {**of_run, "missing": of_run["cases"] - of_run["ok"] - of_run["failed"]}
    counts: dict[str, int | None] = record.get("counts", {})
    names = ("cases", "ok", "failed", "missing")
    if not working and counts.keys() >= set(names):
        return {name: counts[name] for name in names}
    rows = _count_rows(run)
    cases = None if "merged" in record else counts.get("cases")
    missing = None if cases is None else max(cases - sum(rows.values()), 0)
    return {"cases": cases, **rows, "missing": missing}


def _count_rows(run: RunDirectory) -> dict[str, int]:
    """Return numbers of committed cases, with and without a good result."""
    failed = run.rows()["failed"]
    return {"ok": int(np.count_nonzero(~failed)), "failed": int(np.count_nonzero(failed))}


def _carried_facts(record: Mapping[str, Any]) -> str | None:
    """Return the axis along which a run carries its state, and in which directions; None if it does not."""
    simulate, sweep = record.get("simulate") or {}, record.get("sweep") or {}
    directions = sweep.get("simulate.direction") or [simulate.get("direction")]
    axis = simulate.get("carried_axis")
    return f"{axis}: {' and '.join(map(str, directions))}" if axis else None


def status_text(facts: dict[str, Any]) -> str:
    """Return the state of a run as text."""
    labels = {
        FINISHED: f"finished {facts['end']}",
        UNDER_WAY: f"a run works here ({facts['holder']})",
        INTERRUPTED: "merged without all cases; merge all shards again, or run the grid into this directory"
        if facts["end"]
        else "interrupted; run the same command again to continue",
        DAMAGED: "damaged",
    }
    total = "" if facts["cases"] is None else f" of {facts['cases']:,}"
    missing = f", {facts['missing']:,} left" if facts["missing"] else ""
    doing = [f"at present: {facts['doing']}"] if facts["doing"] else []
    checked = "all checksums agree" if facts["every_file"] else "--verify reads every file and checks it"
    return "\n".join(
        [
            f"{facts['directory']}: {labels[facts['state']]}",
            f"{facts['ok'] + facts['failed']:,}{total} cases are there: "
            f"{facts['ok']:,} ok, {facts['failed']:,} failed{missing}",
            *([f"Carried along {facts['carried']}"] if facts["carried"] else []),
            *doing,
            *(fact["text"] for fact in facts["at_work"]),
            f"Files: {', '.join(facts['files'])}",
            f"Disk: {disk_use_text(facts['disk'])}",
            *([] if facts["damage"] else [f"Checksums: {checked}"]),
        ]
    )
