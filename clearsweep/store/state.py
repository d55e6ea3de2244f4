"""State of a run directory: progress, active processes and damaged files, without running anything."""

from pathlib import Path
from typing import Any

import numpy as np

from ..language import phases
from ..language.errors import DirectoryError
from . import disk
from .batch import ResultSchema
from .blocks import Block, numbers_of_blocks, read_mark, verify_block
from .directory import ANSWER_FILES, BLOCKS, DATASET, FINAL_FILES, RunDirectory
from .read import verify
from .record import RECORD_FILE, check_format, is_finished, read_record
from .working import case_text, read_workers

FINISHED, UNDER_WAY, INTERRUPTED, DAMAGED = "finished", "under way", "interrupted", "damaged"


def status(directory: Path, *, every_file: bool = False) -> dict[str, Any]:
    """Return the state of a run, ready for JSON; `every_file`: read every file and compare checksums.

    `cases` are those of the grid, `missing` those without a result; None while a run computes other values of the
    axes than the last one.  `ok` and `failed` count committed cases.  `at_work` has the progress of every
    worker with a long case: its activity, elapsed time, time left (s; None if unknown), for a life also the block and
    the wear (m).  `disk` has sizes in bytes.  `damage` has a sentence for each changed file.

    Raise DirectoryError if there is no run that can be read.
    """
    record = read_record(directory)
    check_format(directory, record)
    run = RunDirectory(directory)
    holder, merged = run.holder(), "merged" in record
    blocks = blocks_state(directory, record, every_file=every_file) if "blocks" in record else None
    run.result_schema = ResultSchema.of_record(record)
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
    return {
        "directory": str(directory),
        "name": record.get("name"),
        "state": state,
        "holder": holder,
        "at_work": [_worker_facts(progress) for progress in read_workers(directory)] if holder else [],
        **(blocks[0] if blocks else _count_cases(record, run, working=holder is not None)),
        "start": record.get("start"),
        "end": record.get("end"),
        "files": {
            name: str(directory / name)
            for name in (*FINAL_FILES, DATASET, BLOCKS, *ANSWER_FILES, RECORD_FILE)
            if (directory / name).exists()
        },
        "disk": disk.disk_use(directory),
        "every_file": every_file,
        "damage": damage,
    }


def blocks_state(
    directory: Path, record: dict[str, Any], *, every_file: bool
) -> tuple[dict[str, int | None], list[str]]:
    """Return the numbers of cases of a run in blocks, of finished ones, and the damage to their files."""
    ok = failed = 0
    damage = []
    listed = set(record["blocks"]["numbers"])
    for number in sorted({*listed, *numbers_of_blocks(directory)}):
        block = Block(directory, number)
        mark = read_mark(block)
        if mark is None:
            if number in listed:
                damage.append(
                    f"{block.path}: its block.json or another file is damaged or missing; the next run restores it"
                )
            continue
        ok, failed = ok + mark["ok"], failed + mark["failed"]
        if every_file:
            damage += verify_block(block, mark)
            batches = RunDirectory(block.path)
            batches.result_schema = ResultSchema.of_record(record)
            sentences = batches.load_batches(contents=True).values()
            damage += [f"{block.path}/{sentence}; its cases run again" for sentence in sentences]
    cases = record.get("counts", {}).get("cases")
    missing = None if cases is None else max(cases - ok - failed, 0)
    return {"cases": cases, "ok": ok, "failed": failed, "missing": missing}, damage


def _count_cases(record: dict[str, Any], run: RunDirectory, *, working: bool) -> dict[str, int | None]:
    """Return numbers of cases: of the grid, with and without a good result, and without any."""
    counts: dict[str, int | None] = record.get("counts", {})
    names = ("cases", "ok", "failed", "missing")
    if not working and counts.keys() >= set(names):
        return {name: counts[name] for name in names}
    failed = run.rows()["failed"]
    cases = None if "merged" in record else counts.get("cases")
    return {
        "cases": cases,
        "ok": int(np.count_nonzero(~failed)),
        "failed": int(np.count_nonzero(failed)),
        "missing": None if cases is None else max(cases - len(failed), 0),
    }


def _worker_facts(progress: phases.Progress) -> dict[str, Any]:
    """Return the progress of a worker, ready for JSON, with a line for people."""
    return {
        **progress.facts,
        "what": progress.what,
        "seconds": progress.seconds,
        "left": progress.left,
        "text": case_text(progress),
    }


def status_text(facts: dict[str, Any]) -> str:
    """Return the state of a run as text."""
    labels = {
        FINISHED: f"finished {facts['end']}",
        UNDER_WAY: f"a run works here ({facts['holder']})",
        INTERRUPTED: "interrupted; run the same command again to continue",
        DAMAGED: "damaged",
    }
    total = "" if facts["cases"] is None else f" of {facts['cases']:,}"
    missing = f", {facts['missing']:,} left" if facts["missing"] else ""
    checked = "all checksums agree" if facts["every_file"] else "--verify reads every file and checks it"
    return "\n".join(
        [
            f"{facts['directory']}: {labels[facts['state']]}",
            f"{facts['ok'] + facts['failed']:,}{total} cases are there: "
            f"{facts['ok']:,} ok, {facts['failed']:,} failed{missing}",
            *(fact["text"] for fact in facts["at_work"]),
            f"Files: {', '.join(facts['files'])}",
            f"Disk: {disk.disk_use_text(facts['disk'])}",
            *([] if facts["damage"] else [f"Checksums: {checked}"]),
        ]
    )
