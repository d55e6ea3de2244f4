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
from importlib import metadata
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

import clearsweep

from ..errors import DirectoryError
from . import durable
from .batch import ID_LENGTH, Form, Row, datasets, part_bytes, shard_bytes

ROWS = np.dtype([("id", "u8"), ("part", "i4"), ("row", "i4"), ("failed", "?")])
_OWN_NAMES = {"lock", "tmp", "shards", "parts"}  # what may be there before run.json is


class Part(NamedTuple):
    """One committed batch: its file, the shard with its orbits (None where nothing is kept), when it was made."""

    path: Path
    shard: Path | None
    sha256: str
    written: int  # ns since 1970


class Store:
    """The directory of one run; what its part files hold is the only truth about which cases are done."""

    def __init__(self, directory: str | Path):
        self.directory = Path(directory)
        self.shards, self.parts_directory = self.directory / "shards", self.directory / "parts"
        self.scratch = self.directory / "tmp"
        self.record = self.directory / "run.json"
        self.parts: list[Part] = []

    def check(self, grid) -> None:
        """Raise DirectoryError where the directory cannot take the results of `grid`; nothing is changed."""
        if not self.directory.exists():
            return
        if not self.directory.is_dir():
            raise DirectoryError(f"{self.directory}: is a file, not a directory; choose another directory with --out")
        if not self.record.exists():
            strangers = sorted({entry.name for entry in self.directory.iterdir()} - _OWN_NAMES)
            strangers += [f"parts/{path.name}" for path in self.parts_directory.glob("*")]  # of a lost run.json
            if strangers:
                raise DirectoryError(
                    f"{self.directory}: holds other files ({', '.join(strangers[:3])}) and no "
                    "run.json; choose an empty or new directory with --out"
                )
            return
        held, wanted = read_record(self.directory).get("frame", {}), _plain(grid.frame())
        differing = [path for path in sorted({*held, *wanted}) if held.get(path) != wanted.get(path)]
        if differing:
            found = "".join(
                f"\n  {path}: there {_show(held.get(path))}, in the grid {_show(wanted.get(path))}"
                for path in differing
            )
            raise DirectoryError(
                f"{self.directory}: holds the results of another grid; choose another directory with "
                f"--out, for only the values on swept axes may change; what differs:{found}"
            )

    @contextlib.contextmanager
    def open_for(self, grid):
        """Create the directory where it is missing and hold its lock; a second holder is refused."""
        self.check(grid)
        with contextlib.ExitStack() as held:
            try:
                for folder in (self.directory, self.shards, self.parts_directory):
                    folder.mkdir(parents=True, exist_ok=True)
                self._lock(held.enter_context(open(self.directory / "lock", "a+", encoding="utf-8")))
                shutil.rmtree(self.scratch, ignore_errors=True)
                self.scratch.mkdir(exist_ok=True)
                (self.scratch / "probe").write_bytes(b"x")
                held.callback(shutil.rmtree, self.scratch, ignore_errors=True)
            except DirectoryError:
                raise
            except OSError as error:
                raise DirectoryError(
                    f"{self.directory}: cannot be written ({error.strerror}); choose another directory with --out"
                ) from error
            self.check(grid)  # again, now that nobody else can change it
            if not self.record.exists():
                self.write_record(grid, start=now(), end=None)
            yield self

    def _lock(self, lock) -> None:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            lock.seek(0)
            holder = lock.read().strip() or "unknown"
            raise DirectoryError(
                f"{self.directory}: another run works here ({holder}); wait for it, stop it, or "
                "choose another directory with --out"
            ) from None
        lock.truncate(0)
        lock.write(f"process {os.getpid()} on {platform.node()} since {now()}")
        lock.flush()

    def write_record(self, grid, **facts) -> None:
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
        kept = {part.shard for part in self.parts}
        for path in self.shards.iterdir():
            if path not in kept:
                path.unlink(missing_ok=True)  # its part was never written, or is damaged
        return list(damage.values())

    def look(self) -> dict[Path, str]:
        """Take in every committed batch whose checksums hold; return the parts that are damaged and what is wrong."""
        self.parts, damage = [], {}
        for path in sorted(self.parts_directory.iterdir()) if self.parts_directory.exists() else ():
            if problem := self._admit(path):
                damage[path] = problem
        return damage

    def _admit(self, path: Path) -> str | None:
        """Take one committed part into account, or return what is wrong with it."""
        name = path.relative_to(self.directory)
        content = path.read_bytes()
        if hashlib.sha256(content).hexdigest()[:16] != path.stem.partition("-")[2]:
            return f"{name}: damaged (its checksum differs); its cases run again"
        part = describe_part(path, content)
        if part.shard is not None:
            shard = part.shard.relative_to(self.directory)
            if not part.shard.exists():
                return f"{shard}: missing; its cases run again"
            if durable.checksum(part.shard) != part.sha256:
                return f"{shard}: damaged (its checksum differs); its cases run again"
        self.parts.append(part)
        return None

    def adopt(self, name: str) -> None:
        """Take a part into account that was committed during this run."""
        path = self.parts_directory / name
        self.parts.append(describe_part(path, path.read_bytes()))

    def take(self, other: "Store") -> None:
        """Take over the batches of another directory, linked or copied; as ever the shards first, the parts commit."""
        known = {part.path.name for part in self.parts}
        new = [part for part in other.parts if part.path.name not in known]
        for folder, files in (
            (self.shards, [part.shard for part in new if part.shard]),
            (self.parts_directory, [part.path for part in new]),
        ):
            for path in files:
                durable.duplicate(path, folder / path.name, self.scratch)
            durable.sync(folder)
        for part in new:
            self.adopt(part.path.name)

    def batches(self) -> set[str]:
        """Return the names of all batches that are committed by now."""
        return {path.name.partition("-")[0] for path in self.parts_directory.iterdir()}

    def part_of(self, batch: str) -> str | None:
        """Return the name of the part that `batch` committed, None where it committed nothing."""
        return next((path.name for path in self.parts_directory.glob(f"{batch}-*.parquet")), None)

    def counts_of(self, name: str) -> tuple[int, int]:
        """Return how many cases a part holds and how many of them failed."""
        statuses = read_part(self.parts_directory / name, ["status"])["status"].to_pylist()
        return len(statuses), sum(status != "ok" for status in statuses)

    def rows(self) -> np.ndarray:
        """Return where each committed case is (ROWS, ascending by id): its newest result, an 'ok' one first."""
        found = []
        for number, part in enumerate(self.parts):
            table = read_part(part.path, ["case_id", "status"])
            rows = np.empty(len(table), ROWS)
            rows["id"] = [int(case_id, 16) for case_id in table["case_id"].to_pylist()]
            rows["part"], rows["row"] = number, np.arange(len(table))
            rows["failed"] = [status != "ok" for status in table["status"].to_pylist()]
            found.append(rows)
        rows = np.concatenate([np.empty(0, ROWS), *found])
        written = np.array([part.written for part in self.parts], "i8")[rows["part"]]
        rows = rows[np.lexsort((-written, rows["failed"], rows["id"]))]
        return rows[np.concatenate([[True], rows["id"][1:] != rows["id"][:-1]])] if len(rows) else rows


def commit(directory: Path, form: Form, batch: str, rows: list[Row]) -> str:
    """Store one batch for good: its shard first, then its part, which is the commit; return the part's name."""
    store = Store(directory)
    facts = {"shard": None, "sha256": "", "written": time.time_ns()}
    if datasets(form):
        content = shard_bytes(form, rows)
        facts |= {"shard": f"{batch}.h5", "sha256": hashlib.sha256(content).hexdigest()}
        durable.write(store.shards / f"{batch}.h5", content, store.scratch)
    content = part_bytes(form, rows, facts)
    name = f"{batch}-{hashlib.sha256(content).hexdigest()[:16]}.parquet"
    durable.write(store.parts_directory / name, content, store.scratch)
    return name


def describe_part(path: Path, content: bytes) -> Part:
    """Return what a part file says of itself and of its shard."""
    facts = json.loads(pq.read_metadata(pa.BufferReader(content)).metadata[b"clearsweep"])
    shard = None if facts["shard"] is None else path.parent.parent / "shards" / facts["shard"]
    return Part(path, shard, facts["sha256"], facts["written"])


def read_part(path: Path, columns: list[str]) -> pa.Table:
    """Return columns of a part."""
    with pq.ParquetFile(path) as file:  # lighter than pq.read_table, which loads the machinery for data sets
        return file.read(columns, use_threads=False)


def read_record(directory: Path) -> dict:
    """Return run.json; DirectoryError where there is none or it cannot be read."""
    path = Path(directory) / "run.json"
    try:
        return json.loads(path.read_text(encoding="utf-8"))
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


def _versions() -> dict:
    names = ("numpy", "numba", "scipy", "pandas", "pyarrow", "h5py")
    return {
        "clearsweep": clearsweep.__version__,
        "python": platform.python_version(),
        **{name: metadata.version(name) for name in names},
    }


def _machine() -> dict:
    return {
        "node": platform.node(),
        "system": platform.platform(),
        "processor": platform.machine(),
        "cores": os.cpu_count(),
    }


def _plain(value):
    """Return `value` as JSON would give it back."""
    return json.loads(json.dumps(value, default=lambda other: other.item()))


def _show(value) -> str:
    return "nothing" if value is None else json.dumps(value)
