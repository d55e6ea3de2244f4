"""run.json: the grid, the versions and the results of a run; it contains a checksum of itself."""

import datetime
import functools
import hashlib
import io
import json
import os
import platform
from collections.abc import Mapping
from importlib import metadata
from pathlib import Path
from typing import Any

import clearsweep

from ..grid import SCHEMA_VERSION, Grid
from ..language.errors import DamagedError, DirectoryError
from ..searches import search_of
from . import durable, record_shape

RECORD_FILE = "run.json"


def record_bytes(grid: Grid, facts: dict[str, Any]) -> bytes:
    """Return run.json: the resolved grid, versions, machine and `facts` (start, end, counts and the like)."""
    written = grid.resolved()
    return signed(
        {
            **written,
            "keys": list(written),
            "source": grid.source,
            "layout": grid.layout.written(),
            "frame": grid.fixed_settings(),
            "model_version": clearsweep.MODEL_VERSION,
            "units": {path: grid.unit(path) for path in grid.axes},
            "fits": {path: [entry._asdict() for entry in fits] for path, fits in grid.fits.items()},
            "labels": grid.labels,
            "roles": grid.roles,
            "written_units": {path: entry._asdict() for path, entry in grid.written_units.items()},
            "seeds": {"sample": written["sample"]["seed"]} if "seed" in written.get("sample", {}) else {},
            "versions": _package_versions(),
            "machine": _describe_machine(),
            **facts,
        }
    )


def signed(record: dict[str, Any]) -> bytes:
    """Return the content of run.json with its checksum."""
    content = json_round_trip(record)
    content["checksum"] = record_checksum(content)
    written = io.BytesIO()
    for part in json.JSONEncoder(indent=2).iterencode(content):  # the list of all parts takes ten times their text
        written.write(part.encode())
    return written.getvalue()


def read_record(directory: Path) -> dict[str, Any]:
    """Return the content of run.json; DamagedError if it was changed, DirectoryError if it is missing."""
    path = Path(directory) / RECORD_FILE
    try:
        record = json.loads(durable.read(path))
        checksum = record_checksum(record) if isinstance(record, dict) else None
    except (FileNotFoundError, NotADirectoryError):
        reason = "there is no run.json in it" if Path(directory).is_dir() else "there is no directory of this name"
        raise DirectoryError(
            f"{directory}: contains no run ({reason}); give a directory that `clearsweep run` has written"
        ) from None
    except (ValueError, RecursionError) as error:
        raise damaged_error(path, f"it is not JSON: {error}") from error
    if checksum is None or not isinstance(record.get("frame"), dict):
        raise damaged_error(path, "it was not written by `clearsweep run`")
    if "checksum" not in record and record["frame"].get("schema") != SCHEMA_VERSION:
        return dict(record)  # written by a version without checksums
    if record.get("checksum") != checksum:
        raise damaged_error(path, "its checksum differs")
    if record["frame"].get("schema") == SCHEMA_VERSION:
        try:
            record_shape.check_record(record)
        except record_shape.MisshapenError as problem:
            raise damaged_error(path, f"it was not written by `clearsweep run`: {problem}") from None
    return dict(record)


def check_format(directory: Path, record: dict[str, Any]) -> None:
    """Raise DirectoryError if this version cannot read the format of a run directory."""
    number = record["frame"].get("schema")
    if number != SCHEMA_VERSION:
        written = record.get("versions", {}).get("clearsweep", "unknown")
        raise DirectoryError(
            f"{directory}: has format {number} of run directories, written by clearsweep {written}; this version "
            f"reads format {SCHEMA_VERSION}: run the grid again into another directory, or read it with that version"
        )


def damaged_error(path: Path, reason: str) -> DamagedError:
    """Return the error for a file of a run that was changed."""
    return DamagedError(
        f"{path}: damaged ({reason}); run the grid again with --out {path.parent}, which restores it from its batches"
    )


def is_finished(record: dict[str, Any]) -> bool:
    """Return whether a run has merged all its cases; one with too many failures stops before."""
    return "merged" in record and not record.get("counts", {}).get("missing")


def record_checksum(record: dict[str, Any]) -> str:
    """Return the checksum of run.json without the checksum itself, regardless of layout."""
    content = {key: value for key, value in record.items() if key != "checksum"}
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()


def declared_values(record: Mapping[str, Any], path: str) -> list[Any] | None:
    """Return the values of an axis in run.json; None if a search adds others."""
    if search_of(record):
        return None
    sections = [
        *(record.get(name, {}) for name in ("sweep", "zip", "cases")),
        record.get("sample", {}).get("drawn", {}),
    ]
    return next((section[path] for section in sections if path in section), None)


def kind_of_axis(record: Mapping[str, Any], path: str) -> str:
    """Return the kind of the column of an axis; '' if it is unknown."""
    values = declared_values(record, path)
    return "" if values is None else "text" if all(isinstance(value, str) for value in values) else "float"


def json_round_trip(value: Any) -> Any:
    """Return `value` after a round trip through JSON."""
    return json.loads(json.dumps(value, default=lambda scalar: scalar.item()))


def utc_now() -> str:
    """Return the time in UTC, ISO 8601."""
    return datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds")


@functools.cache  # 50 ms, and it is asked for at the start and at the end of a run
def _package_versions() -> dict[str, str]:
    names = ("numpy", "llvmlite", "scipy", "pandas", "pyarrow", "h5py")
    return {
        "clearsweep": clearsweep.__version__,
        "python": platform.python_version(),
        **{name: metadata.version(name) for name in names},
    }


def _describe_machine() -> dict[str, Any]:
    return {
        "node": platform.node(),
        "system": platform.platform(),
        "processor": platform.machine(),
        "cores": os.cpu_count(),
    }
