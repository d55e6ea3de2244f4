"""The directory of a run: its grid, its lock, and its committed cases."""

import contextlib
import fcntl
import functools
import hashlib
import itertools
import json
import os
import platform
import re
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, BinaryIO, Self

import numpy as np

from ..grid import Grid
from ..language.errors import ClearsweepError, DamagedError, DirectoryError, error_line
from ..searches import SEARCHES
from . import durable
from .batch import (
    HASH_LENGTH,
    ORBITS,
    SUMMARIES,
    BatchFiles,
    ResultSchema,
    Row,
    batch_files,
    file_name,
    hash_in_name,
    orbits_bytes,
    summary_table,
    table_bytes,
)
from .datasets import Contents, datasets, id_text, open_orbits
from .record import (
    RECORD_FILE,
    MisshapenError,
    difference_lines,
    differing,
    json_round_trip,
    read_record,
    record_bytes,
    signed,
    utc_now,
)

ROWS = np.dtype([("id", "u8"), ("batch", "i4"), ("row", "i4"), ("failed", "?")])
LOCK, SCRATCH = "lock", "tmp"
BLOCKS, DATASET = "blocks", "summary"  # folders of a run that is cut: of its blocks, and of their sorted summaries
LOCK_WAIT = 0.05  # s, longer than reading the holder of the lock
FINAL_FILES = SUMMARY_FILE, ORBITS_FILE = "summary.parquet", "orbits.h5"
IDS_FILE = "ids.bin"  # of a block: the identities of its cases, uint64
#: Tables of searches; run.json has their checksums.
ANSWER_FILES = tuple(f"{search.name}.parquet" for search in SEARCHES if search.has_table)
MISSHAPEN = "not as a run writes it"  # of a file with a valid checksum and other content
ANSWER_FILE = "answer.json"  # the answer to the question of the grid, of a finished run
_OWN_NAMES = {LOCK, SCRATCH, ORBITS, SUMMARIES}  # files of a run that may exist before run.json
#: Contents of files of histories that were checked, by path, number of cases, and whether it is that of one batch.
Checked = dict[tuple[Path, int, bool], Contents]
_HOLDER = re.compile(rb"(process \d+ on .* since \S+)?\s*")  # content of the lock file


class OtherGridError(DirectoryError):
    """A directory that contains the results of another grid."""

    def __init__(self, message: str, differing: list[str]):
        """Prepare with the dotted paths whose values differ."""
        super().__init__(message)
        self.differing = differing


class RunDirectory:
    """The directory of one run; only its batch files determine which cases are finished."""

    def __init__(self, path: str | Path, result_schema: ResultSchema | None = None):
        self.path = Path(path)
        self.orbits, self.summaries = self.path / ORBITS, self.path / SUMMARIES
        self.scratch = self.path / SCRATCH
        self.record = self.path / RECORD_FILE
        self.batches: list[BatchFiles] = []  # committed batches with valid checksums
        self.others: list[BatchFiles] = []  # batches of another grid
        self.misshapen: set[Path] = set()  # summaries whose content no run writes
        self.frame: str | None = None  # `ResultSchema.frame` of the batches that count; None: of all
        self.result_schema = result_schema  # of these batches, if it is known
        self.record_damage: str | None = None  # damage of run.json, if it can be restored from the batches

    def check(self, grid: Grid) -> None:
        """Raise DirectoryError if the directory cannot hold the results of `grid`; change nothing."""
        self.expect(ResultSchema.of(grid))
        self.record_damage = None
        with self._refusing():
            if not self.path.exists():
                return
            if not self.path.is_dir():
                raise DirectoryError(f"{self.path}: is a file, not a directory; choose another directory with --out")
            self._refuse_foreign_files()
        try:
            stored = read_record(self.path)["frame"] if self.record.exists() else None
        except DamagedError as error:
            self.load_batches()
            if not self.batches and not self._blocks_match():
                raise
            self.record_damage = str(error)
            return
        if stored is not None:
            self._compare(stored, json_round_trip(grid.fixed_settings()))

    def expect(self, result_schema: ResultSchema) -> None:
        """Let only batches with this schema count."""
        self.result_schema, self.frame = result_schema, result_schema.frame

    def _blocks_match(self) -> bool:
        """Return whether a block of the run has batches of the requested grid."""
        for folder in sorted(self.path.glob(f"{BLOCKS}/*/{SUMMARIES}")):
            block = RunDirectory(folder.parent, self.result_schema)
            block.frame = self.frame
            block.load_batches(histories=False)
            if block.batches:
                return True
        return False

    def _refuse_foreign_files(self) -> None:
        """Raise DirectoryError if a link, a pipe or the like has the name of a file of the run."""
        for name in (RECORD_FILE, LOCK, *FINAL_FILES):
            durable.check_regular(self.path / name)
        if self.record.exists():
            return
        foreign = sorted({entry.name for entry in self.path.iterdir()} - _OWN_NAMES)
        foreign += [f"{SUMMARIES}/{path.name}" for path in self.summaries.glob("*")]  # run.json is lost
        foreign += [f"{ORBITS}/{path.name}" for path in self.orbits.glob("*") if not hash_in_name(path)]
        foreign += [f"{SCRATCH}/{name}" for name in durable.find_foreign_names(self.scratch)]
        if foreign:
            raise DirectoryError(
                f"{self.path}: contains other files ({', '.join(foreign[:3])}) and no "
                "run.json; choose an empty or new directory with --out"
            )

    def _compare(self, stored_settings: dict[str, Any], grid_settings: dict[str, Any]) -> None:
        """Raise DirectoryError if the fixed settings of the directory differ from those of the grid."""
        if differences := differing(stored_settings, grid_settings):
            lines = difference_lines(
                f"{path}: there {_json_text(there)}, in the grid {_json_text(here)}"
                for path, (there, here) in sorted(differences.items())
            )
            raise OtherGridError(
                f"{self.path}: contains the results of another grid, and only values on swept axes may change; choose "
                f"another directory with --out, or move it aside with --fresh; differences:{lines}",
                sorted(differences),
            )

    @contextlib.contextmanager
    def open_for(self, grid: Grid, **facts: Any) -> Iterator[Self]:
        """Create the directory if it is missing, and lock it; a second process is refused.

        A new run.json contains `facts`.
        """
        self.check(grid)
        with contextlib.ExitStack() as exit_stack:
            with self._refusing():
                self.path.mkdir(parents=True, exist_ok=True)
                for folder in (self.orbits, self.summaries):
                    durable.make_folder(folder)
                self._lock(exit_stack.enter_context(durable.open_lock(self.path / LOCK)))
                durable.make_folder(self.scratch)  # under the lock: a run removes it at its end
                exit_stack.callback(durable.remove_temporaries, self.scratch, remove_folder=True)
                durable.remove_temporaries(self.scratch)
                durable.check_writable(self.scratch)
            self.check(grid)  # again, now that no other process can change it
            if self.record_damage or not self.record.exists():
                self.write_record(grid, start=utc_now(), end=None, **facts)
            yield self

    @contextlib.contextmanager
    def locked(self) -> Iterator[None]:
        """Hold the lock of a directory in which no grid runs; raise DirectoryError if a run is active."""
        with contextlib.ExitStack() as exit_stack:
            with self._refusing():
                self._lock(exit_stack.enter_context(durable.open_lock(self.path / LOCK)))
            yield

    def move_aside(self) -> Path:
        """Rename the directory to the first free NAME-2, NAME-3, ... and return the new path; nothing is deleted."""
        with self.locked(), self._refusing():
            numbered = (self.path.with_name(f"{self.path.name}-{number}") for number in itertools.count(2))
            return self.path.rename(next(path for path in numbered if not path.exists()))

    @contextlib.contextmanager
    def _refusing(self) -> Iterator[None]:
        """Convert an error of the file system into the DirectoryError of a directory that cannot be written."""
        try:
            yield
        except DirectoryError:
            raise
        except OSError as error:
            reason = f"cannot be written ({error.strerror}); choose another directory with --out"
            raise DirectoryError(f"{self.path}: {reason}") from error

    def _lock(self, lock: BinaryIO) -> None:
        try:
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                time.sleep(LOCK_WAIT)
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise DirectoryError(
                f"{self.path}: another run works here ({_read_holder(lock)}); wait for it, stop it, or "
                "choose another directory with --out"
            ) from None
        if not _HOLDER.fullmatch(lock.read(1000)):
            place = self.path / LOCK
            raise DirectoryError(f"{place}: is not the lock file of a run; move it away or choose another directory")
        lock.truncate(0)
        lock.seek(0)
        lock.write(f"process {os.getpid()} on {platform.node()} since {utc_now()}".encode())

    def holder(self) -> str | None:
        """Return the process that has the lock, or None."""
        with contextlib.suppress(FileNotFoundError), durable.open_regular(self.path / LOCK) as lock:
            try:
                fcntl.flock(lock, fcntl.LOCK_SH | fcntl.LOCK_NB)
            except BlockingIOError:
                return _read_holder(lock)
        return None

    def write_record(self, grid: Grid, **facts: Any) -> None:
        """Write run.json: the resolved grid, versions, machine and `facts` (start, end, counts and the like)."""
        with durable.storing(self.record):
            durable.replace(self.record, record_bytes(grid, facts), self.scratch)

    def add_to_record(self, **facts: Any) -> None:
        """Add facts to the existing run.json."""
        with durable.storing(self.record):
            durable.replace(self.record, signed(read_record(self.path) | facts), self.scratch)

    def write_answer(self, answer: dict[str, Any]) -> None:
        """Write answer.json."""
        file = self.path / ANSWER_FILE
        with durable.storing(file):
            durable.replace(file, json.dumps(json_round_trip(answer), indent=2).encode(), self.scratch)

    def discard_answer(self) -> None:
        """Remove answer.json, as a run starts that may change it."""
        with durable.storing(self.path / ANSWER_FILE):
            durable.discard(self.path / ANSWER_FILE)

    def load_intact_batches(self) -> list[str]:
        """Load intact commits; return descriptions of damaged ones and what happens to them.

        Unneeded files that a run wrote are removed; their names have checksums.  Damaged files are kept as *.damaged,
        and files with other names are not touched.
        """
        notes = [f"{self.record_damage.partition(';')[0]}; restored from the batches"] if self.record_damage else []
        damage = self.load_batches()
        notes += [f"{sentence}; its cases run again" for sentence in damage.values()]
        needed = {batch.orbits for batch in self.batches} | {batch.orbits for batch in self.others}
        unneeded = [*damage, *(path for path in batch_files_in(self.orbits) if path not in needed)]
        for path in unneeded:
            if path not in self.misshapen and durable.checksum(path)[:HASH_LENGTH] == hash_in_name(path):
                durable.discard(path)
            else:
                durable.set_aside(path)
        notes += [f"{batch.summary.relative_to(self.path)}: of another grid; left alone" for batch in self.others]
        if logs := durable.find(self.scratch, durable.LIFE_LOG):  # cases whose process was killed after the commit
            rows = self.rows()
            finished_ids = set(map(id_text, rows["id"][~rows["failed"]].tolist()))
            for case_id in finished_ids.intersection(logs):
                durable.discard(logs[case_id])
        return notes

    def load_batches(self, *, histories: bool = True, contents: bool = False) -> dict[Path, str]:
        """Load every committed batch with valid checksums and content; return the others' summaries with the reason.

        Without `histories` their files are not read; with `contents` these are opened and checked, too, which a merge
        does in any case.  Files that are gone since they were listed were replaced by a merge at work: all are listed
        again.
        """
        self.batches, self.others, self.misshapen, damage = [], [], set(), {}
        checksum, checked = functools.cache(durable.checksum), Checked()  # batches may share histories
        for path in batch_files_in(self.summaries):
            try:
                content = durable.read(path)
            except FileNotFoundError:
                return self.load_batches(histories=histories, contents=contents)
            if hashlib.sha256(content).hexdigest()[:HASH_LENGTH] != hash_in_name(path):
                damage[path] = f"{path.relative_to(self.path)}: damaged (its checksum differs)"
                continue
            try:
                batch = batch_files(path, content, self.result_schema)
            except MisshapenError as error:
                damage[path] = f"{path.relative_to(self.path)}: {MISSHAPEN} ({error})"
                self.misshapen.add(path)
                continue
            if self.frame not in (None, batch.frame):
                self.others.append(batch)
            elif histories and (problem := self._describe_damage(batch, checksum, checked if contents else None)):
                damage[path] = problem
            else:
                self.batches.append(batch)
        if not all(path.exists() for path in damage):
            return self.load_batches(histories=histories, contents=contents)
        return damage

    def _describe_damage(
        self, batch: BatchFiles, checksum: Callable[[Path], str], checked: Checked | None
    ) -> str | None:
        """Return the damage of a batch's histories; `checked` as in `check_histories`, None: not opened."""
        if batch.orbits is None:
            return None
        name = batch.orbits.relative_to(self.path)
        try:
            if checksum(batch.orbits) != batch.sha256:
                return f"{name}: damaged (its checksum differs)"
            if checked is not None and self.result_schema is not None:
                check_histories(batch, self.result_schema, checked)
        except FileNotFoundError:
            return f"{name}: missing"
        except MisshapenError as error:
            return f"{name}: {MISSHAPEN} ({error})"
        return None

    def register_batch(self, name: str) -> None:
        """Register a batch that was committed during this run, by the name of its summary."""
        self.batches.append(self.read_batch(name))

    def read_batch(self, name: str) -> BatchFiles:
        """Return a batch by the name of its summary; StorageError if it is not as a run writes it."""
        path, content = self.summaries / name, b""
        with contextlib.suppress(FileNotFoundError):
            content = durable.read(path)
        if hash_in_name(path) != hashlib.sha256(content).hexdigest()[:HASH_LENGTH]:  # changed after the commit
            raise durable.damaged_error(path)
        try:
            return batch_files(path, content, self.result_schema)
        except MisshapenError as error:
            raise durable.damaged_error(path) from error

    def link_batches(self, other: "RunDirectory") -> None:
        """Link or copy the batches of another directory; orbits first, since summaries commit."""
        known = {batch.name for batch in self.batches}
        new_batches = [batch for batch in other.batches if batch.name not in known]
        for folder, files in (
            (self.orbits, list(dict.fromkeys(batch.orbits for batch in new_batches if batch.orbits))),
            (self.summaries, [batch.summary for batch in new_batches]),
        ):
            with durable.storing(folder):
                for path in files:
                    durable.link_or_copy(path, folder / path.name, self.scratch)
                durable.sync(folder)
        for batch in new_batches:
            self.register_batch(batch.name)

    def summary_names(self) -> set[str]:
        """Return the names of the summaries of all committed batches."""
        return {path.name for path in batch_files_in(self.summaries)}

    def rows(self) -> np.ndarray:
        """Return the location of each committed case (ROWS, ascending by id): its newest result, preferably 'ok'."""
        rows, first = np.empty(sum(len(batch.ids) for batch in self.batches), ROWS), 0
        for number, batch in enumerate(self.batches):
            part = rows[first : first + len(batch.ids)]
            part["id"], part["failed"], part["batch"], part["row"] = batch.ids, batch.failed, number, range(len(part))
            first += len(part)
        rows = rows[np.argsort(rows["id"])]
        is_repeated = rows["id"][1:] == rows["id"][:-1]
        if is_repeated.any():
            newest_first = np.argsort([-batch.written for batch in self.batches], kind="stable")
            age = np.empty(len(newest_first), "i4")
            age[newest_first] = np.arange(len(age))
            order = np.lexsort((age[rows["batch"]], rows["failed"], rows["id"]))
            rows = rows[order[np.concatenate([[True], ~is_repeated])]]
        return rows


def check_histories(batch: BatchFiles, result_schema: ResultSchema, checked: Checked) -> Contents:
    """Return the contents of a batch's histories; MisshapenError if they are not those of its cases.

    checked : the contents of files that other batches share, to which this one is added; they are not opened again
    """
    assert batch.orbits is not None
    is_plain, cases = batch.cases is None, batch.cases or len(batch.ids)
    claim = batch.orbits, cases, is_plain
    try:
        if claim not in checked:
            with open_orbits(batch.orbits, result_schema.stored, cases, plain=is_plain) as (_, contents):
                checked[claim] = contents
    except (FileNotFoundError, ClearsweepError):
        raise
    except (OSError, RuntimeError, KeyError, ValueError, TypeError) as error:  # errors of HDF5 and h5py
        raise MisshapenError(error_line(error)) from error
    contents = checked[claim]
    if not np.array_equal(contents.ids[batch.first : batch.first + len(batch.ids)], batch.ids):
        raise MisshapenError("its cases are not those of its summary")
    return contents


def commit(directory: Path, result_schema: ResultSchema, batch: str, rows: list[Row]) -> str:
    """Commit a batch: orbits first, then the summary, which is the commit; return the summary's name."""
    run = RunDirectory(directory)
    facts: dict[str, Any] = {"shard": None, "sha256": "", "written": time.time_ns(), "frame": result_schema.frame}
    if datasets(result_schema.stored):
        content = orbits_bytes(result_schema, rows)
        checksum = hashlib.sha256(content).hexdigest()
        name = file_name(batch, checksum, "h5")
        facts |= {"shard": name, "sha256": checksum}
        with durable.storing(run.orbits / name):
            durable.replace(run.orbits / name, content, run.scratch)
    content = table_bytes(summary_table(result_schema, rows), facts)
    name = file_name(batch, hashlib.sha256(content).hexdigest(), "parquet")
    with durable.storing(run.summaries / name):
        durable.replace(run.summaries / name, content, run.scratch)
    return name


def batch_files_in(folder: Path) -> list[Path]:
    """Return the files in a folder with names of batch files, in order."""
    return sorted(path for path in folder.iterdir() if hash_in_name(path)) if folder.exists() else []


def _read_holder(lock: BinaryIO) -> str:
    lock.seek(0)
    return lock.read(1000).decode(errors="replace").strip() or "unknown"


def _json_text(value: Any) -> str:
    return "nothing" if value is None else json.dumps(value)
