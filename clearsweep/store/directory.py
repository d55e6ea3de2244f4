"""The directory of one run: whose it is, who works in it, and which cases it holds."""

import contextlib
import datetime
import fcntl
import hashlib
import json
import os
import platform
import shutil
import time
from collections.abc import Iterator
from importlib import metadata
from pathlib import Path
from typing import Any, Self, TextIO

import numpy as np

import clearsweep

from ..errors import DirectoryError
from ..grid import Grid
from . import durable
from .batch import (
    ID_LENGTH,
    ORBITS,
    SUMMARIES,
    BatchFiles,
    Form,
    Row,
    batch_files,
    datasets,
    orbits_bytes,
    read_summary,
    summary_bytes,
)

ROWS = np.dtype([("id", "u8"), ("batch", "i4"), ("row", "i4"), ("failed", "?")])
_OWN_NAMES = {"lock", "tmp", ORBITS, SUMMARIES}  # what may be there before run.json is


class RunDirectory:
    """The directory of one run; what its batch files hold is the only truth about which cases are done."""

    def __init__(self, path: str | Path):
        self.path = Path(path)
        self.orbits, self.summaries = self.path / ORBITS, self.path / SUMMARIES
        self.scratch = self.path / "tmp"
        self.record = self.path / "run.json"
        self.batches: list[BatchFiles] = []  # those that were looked at, adopted or taken over

    def check(self, grid: Grid) -> None:
        """Raise DirectoryError where the directory cannot take the results of `grid`; nothing is changed."""
        if not self.path.exists():
            return
        if not self.path.is_dir():
            raise DirectoryError(f"{self.path}: is a file, not a directory; choose another directory with --out")
        if not self.record.exists():
            strangers = sorted({entry.name for entry in self.path.iterdir()} - _OWN_NAMES)
            strangers += [f"{SUMMARIES}/{path.name}" for path in self.summaries.glob("*")]  # of a lost run.json
            if strangers:
                raise DirectoryError(
                    f"{self.path}: holds other files ({', '.join(strangers[:3])}) and no "
                    "run.json; choose an empty or new directory with --out"
                )
            return
        present, wanted = read_record(self.path).get("frame", {}), _plain(grid.frame())
        differing = [path for path in sorted({*present, *wanted}) if present.get(path) != wanted.get(path)]
        if differing:
            lines = "".join(
                f"\n  {path}: there {_show(present.get(path))}, in the grid {_show(wanted.get(path))}"
                for path in differing
            )
            raise DirectoryError(
                f"{self.path}: holds the results of another grid; choose another directory with "
                f"--out, for only the values on swept axes may change; what differs:{lines}"
            )

    @contextlib.contextmanager
    def open_for(self, grid: Grid) -> Iterator[Self]:
        """Create the directory where it is missing and hold its lock; a second holder is refused."""
        self.check(grid)
        with contextlib.ExitStack() as at_end:
            try:
                for folder in (self.path, self.orbits, self.summaries):
                    folder.mkdir(parents=True, exist_ok=True)
                self._lock(at_end.enter_context(open(self.path / "lock", "a+", encoding="utf-8")))
                shutil.rmtree(self.scratch, ignore_errors=True)
                self.scratch.mkdir(exist_ok=True)
                (self.scratch / "probe").write_bytes(b"x")
                at_end.callback(shutil.rmtree, self.scratch, ignore_errors=True)
            except DirectoryError:
                raise
            except OSError as error:
                raise DirectoryError(
                    f"{self.path}: cannot be written ({error.strerror}); choose another directory with --out"
                ) from error
            self.check(grid)  # again, now that nobody else can change it
            if not self.record.exists():
                self.write_record(grid, start=now(), end=None)
            yield self

    def _lock(self, lock: TextIO) -> None:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            lock.seek(0)
            holder = lock.read().strip() or "unknown"
            raise DirectoryError(
                f"{self.path}: another run works here ({holder}); wait for it, stop it, or "
                "choose another directory with --out"
            ) from None
        lock.truncate(0)
        lock.write(f"process {os.getpid()} on {platform.node()} since {now()}")
        lock.flush()

    def write_record(self, grid: Grid, **facts: Any) -> None:
        """Write run.json: the resolved grid, versions, machine and `facts` (start, end, counts and the like)."""
        written = grid.resolved()
        record = {
            **written,
            "keys": list(written),
            "source": grid.source,
            "layout": grid.layout.written(),
            "frame": grid.frame(),
            "model_version": clearsweep.MODEL_VERSION,
            "units": {path: grid.unit(path) for path in grid.axes},
            "seeds": {"sample": written["sample"]["seed"]} if "seed" in written.get("sample", {}) else {},
            "versions": _versions(),
            "machine": _machine(),
            **facts,
        }
        durable.write(self.record, json.dumps(_plain(record), indent=2).encode(), self.scratch)

    def recover(self) -> list[str]:
        """Take in what is committed and intact; remove what is damaged or left over; return what was damaged."""
        damage = self.look()
        for path in damage:
            path.unlink(missing_ok=True)
        kept = {batch.orbits for batch in self.batches}
        for path in self.orbits.iterdir():
            if path not in kept:
                path.unlink(missing_ok=True)  # its summary was never written, or is damaged
        return list(damage.values())

    def look(self) -> dict[Path, str]:
        """Take in every committed batch whose checksums hold; return summaries that are damaged, and how."""
        self.batches, damage = [], {}
        for path in sorted(self.summaries.iterdir()) if self.summaries.exists() else ():
            if problem := self._admit(path):
                damage[path] = problem
        return damage

    def _admit(self, path: Path) -> str | None:
        """Take one committed batch into account, by its summary, or return what is wrong with it."""
        name = path.relative_to(self.path)
        content = path.read_bytes()
        if hashlib.sha256(content).hexdigest()[:16] != path.stem.partition("-")[2]:
            return f"{name}: damaged (its checksum differs); its cases run again"
        batch = batch_files(path, content)
        if batch.orbits is not None:
            name = batch.orbits.relative_to(self.path)
            if not batch.orbits.exists():
                return f"{name}: missing; its cases run again"
            if durable.checksum(batch.orbits) != batch.sha256:
                return f"{name}: damaged (its checksum differs); its cases run again"
        self.batches.append(batch)
        return None

    def adopt(self, name: str) -> None:
        """Take a batch into account that was committed during this run, by the name of its summary."""
        path = self.summaries / name
        self.batches.append(batch_files(path, path.read_bytes()))

    def take(self, other: "RunDirectory") -> None:
        """Take over the batches of another directory, linked or copied; orbits first, for the summaries commit."""
        known = {batch.name for batch in self.batches}
        new = [batch for batch in other.batches if batch.name not in known]
        for folder, files in (
            (self.orbits, [batch.orbits for batch in new if batch.orbits]),
            (self.summaries, [batch.summary for batch in new]),
        ):
            for path in files:
                durable.duplicate(path, folder / path.name, self.scratch)
            durable.sync(folder)
        for batch in new:
            self.adopt(batch.name)

    def committed(self) -> set[str]:
        """Return the names of all batches that are committed by now."""
        return {path.name.partition("-")[0] for path in self.summaries.iterdir()}

    def committed_as(self, batch: str) -> str | None:
        """Return the name of the summary that `batch` committed, None where it committed nothing."""
        return next((path.name for path in self.summaries.glob(f"{batch}-*.parquet")), None)

    def counts_of(self, name: str) -> tuple[int, int]:
        """Return how many cases the summary called `name` holds and how many of them failed."""
        statuses = read_summary(self.summaries / name, ["status"])["status"].to_pylist()
        return len(statuses), sum(status != "ok" for status in statuses)

    def rows(self) -> np.ndarray:
        """Return where each committed case is (ROWS, ascending by id): its newest result, an 'ok' one first."""
        tables = []
        for number, batch in enumerate(self.batches):
            table = read_summary(batch.summary, ["case_id", "status"])
            rows = np.empty(len(table), ROWS)
            rows["id"] = [int(case_id, 16) for case_id in table["case_id"].to_pylist()]
            rows["batch"], rows["row"] = number, np.arange(len(table))
            rows["failed"] = [status != "ok" for status in table["status"].to_pylist()]
            tables.append(rows)
        rows = np.concatenate([np.empty(0, ROWS), *tables])
        written = np.array([batch.written for batch in self.batches], "i8")[rows["batch"]]
        rows = rows[np.lexsort((-written, rows["failed"], rows["id"]))]
        return rows[np.concatenate([[True], rows["id"][1:] != rows["id"][:-1]])] if len(rows) else rows


def commit(directory: Path, form: Form, batch: str, rows: list[Row]) -> str:
    """Store one batch for good: its orbits first, then its summary, which is the commit; return the summary's name."""
    run = RunDirectory(directory)
    facts: dict[str, Any] = {"shard": None, "sha256": "", "written": time.time_ns()}
    if datasets(form):
        content = orbits_bytes(form, rows)
        facts |= {"shard": f"{batch}.h5", "sha256": hashlib.sha256(content).hexdigest()}
        durable.write(run.orbits / f"{batch}.h5", content, run.scratch)
    content = summary_bytes(form, rows, facts)
    name = f"{batch}-{hashlib.sha256(content).hexdigest()[:16]}.parquet"
    durable.write(run.summaries / name, content, run.scratch)
    return name


def read_record(directory: Path) -> dict[str, Any]:
    """Return the content of run.json; raise DirectoryError where there is none or it cannot be read."""
    path = Path(directory) / "run.json"
    try:
        record: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
        return record
    except FileNotFoundError:
        raise DirectoryError(
            f"{directory}: holds no run (there is no run.json in it); "
            "name a directory that `clearsweep run` has written"
        ) from None
    except (OSError, ValueError) as error:
        raise DirectoryError(f"{path}: cannot be read ({error}); move the directory away and run again") from error


def id_text(value: int) -> str:
    """Return a case_id as it is written."""
    return f"{value:0{ID_LENGTH}x}"


def now() -> str:
    """Return the time in UTC, ISO 8601."""
    return datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds")


def _versions() -> dict[str, str]:
    names = ("numpy", "numba", "scipy", "pandas", "pyarrow", "h5py")
    return {
        "clearsweep": clearsweep.__version__,
        "python": platform.python_version(),
        **{name: metadata.version(name) for name in names},
    }


def _machine() -> dict[str, Any]:
    return {
        "node": platform.node(),
        "system": platform.platform(),
        "processor": platform.machine(),
        "cores": os.cpu_count(),
    }


def _plain(value: Any) -> Any:
    """Return `value` as JSON would give it back."""
    return json.loads(json.dumps(value, default=lambda other: other.item()))


def _show(value: Any) -> str:
    return "nothing" if value is None else json.dumps(value)
