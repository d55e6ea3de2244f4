"""Reads what a run left: its summary, orbits, events and wear."""

from collections.abc import Iterator
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import h5py
import numpy as np
import pyarrow.parquet as pq

from .. import results
from ..errors import DirectoryError, InputError
from ..grid import SCHEMA_VERSION
from ..layout import Layout
from .batch import EVENT, SAMPLE
from .directory import read_record

if TYPE_CHECKING:
    import pandas as pd  # loaded only where a frame is made


class StoredRun:
    """The results in one directory.

    Attributes
    ----------
    directory : Path
    grid : dict, the content of run.json: name, axes and base case in SI, units of the axes, versions, machine, counts.
    layout : Layout, what the scene has.
    summary : DataFrame, one row per case in case_id order; `attrs["units"]` and `attrs["descriptions"]` by column.
    """

    def __init__(self, directory: str | Path):
        self.directory = Path(directory)
        self.grid = read_record(self.directory)
        self._check()
        self.layout = Layout.read(self.grid["layout"])

    def _check(self) -> None:
        """Raise DirectoryError where the merged files are missing, damaged, of different runs or of another form."""
        form = self.grid.get("frame", {}).get("schema")
        if form != SCHEMA_VERSION:
            written = self.grid.get("versions", {}).get("clearsweep", "unknown")
            raise DirectoryError(
                f"{self.directory}: has form {form} of run directories, written by clearsweep {written}; this version "
                f"reads form {SCHEMA_VERSION}: run the grid again into another directory, or read it with that version"
            )
        try:
            mark = pq.read_metadata(self.directory / "summary.parquet").metadata[b"clearsweep"].decode()
            with h5py.File(self.directory / "orbits.h5", "r") as file:
                matching = file.attrs["clearsweep"] == mark
        except (OSError, KeyError, TypeError, ValueError) as error:
            finished = (self.directory / "summary.parquet").exists() and (self.directory / "orbits.h5").exists()
            state = f"its files are damaged ({error})" if finished else "its run is not finished"
            raise DirectoryError(
                f"{self.directory}: {state}; run its grid again, which computes only what is missing"
            ) from error
        if not matching:
            raise DirectoryError(
                f"{self.directory}: summary.parquet and orbits.h5 are of different runs; "
                "run the grid again, which only merges what is there"
            )

    @cached_property
    def _places(self) -> dict[str, int]:
        """Return the row of every case."""
        with h5py.File(self.directory / "orbits.h5", "r") as file:
            return {case_id.decode(): row for row, case_id in enumerate(file["case_id"][:])}

    def __len__(self) -> int:
        return int(pq.read_metadata(self.directory / "summary.parquet").num_rows)

    def __repr__(self) -> str:
        return f"<clearsweep run {str(self.directory)!r}: {len(self)} cases>"

    @cached_property
    def summary(self) -> "pd.DataFrame":
        """Return the summary as a DataFrame; `attrs["units"]` and `attrs["descriptions"]` hold these by column."""
        with pq.ParquetFile(self.directory / "summary.parquet") as file:
            table = file.read(use_threads=False)
        frame = table.replace_schema_metadata(None).to_pandas()
        for name, key in (("units", b"unit"), ("descriptions", b"description")):
            frame.attrs[name] = {field.name: field.metadata[key].decode() for field in table.schema}
        return frame

    def rows(self, columns: list[str]) -> Iterator[dict[str, Any]]:
        """Yield the rows of the summary as dicts of these columns, a few thousand in memory at a time."""
        with pq.ParquetFile(self.directory / "summary.parquet") as file:
            for batch in file.iter_batches(batch_size=4096, columns=columns, use_threads=False):
                yield from batch.to_pylist()

    def orbit(self, case_id: str) -> "pd.DataFrame":
        """Return the time histories of one case as a DataFrame, columns by channel; `attrs["units"]` by column.

        It is empty for a failed case and where `save.orbits` is none.
        """
        channels = self.layout.channels
        frame = self._frame(case_id, SAMPLE, [channel.name for channel in channels])
        frame.attrs["units"] = {channel.name: channel.unit for channel in channels}
        return frame

    def events(self, case_id: str) -> "pd.DataFrame":
        """Return the contact events of one case as a DataFrame: t (s), joint, kind, rate (m/s), force_peak (N)."""
        frame = self._frame(case_id, EVENT, [f"events/{name}" for name in results.EVENT_DTYPE.names or ()])
        frame = frame.rename(columns=lambda name: name.removeprefix("events/"))
        frame["joint"] = frame["joint"].map(dict(enumerate(joint.name for joint in self.layout.joints)))
        frame["kind"] = frame["kind"].map(dict(enumerate(results.EVENT_KINDS)))
        frame.attrs["units"] = {"t": "s", "joint": "", "kind": "", "rate": "m/s", "force_peak": "N"}
        return frame

    def wear(self, case_id: str) -> dict[str, tuple[np.ndarray, np.ndarray]]:
        """Return joint -> (bearing, journal): depths in m per angular bin of each body; NaN for a failed case."""
        place = self._place(case_id)
        with h5py.File(self.directory / "orbits.h5", "r") as file:
            return {
                joint.name: (file[f"wear/{joint.name}/bearing"][place], file[f"wear/{joint.name}/journal"][place])
                for joint in self.layout.joints
                if joint.wear_bins
            }

    def _place(self, case_id: str) -> int:
        if case_id not in self._places:
            raise InputError(f"{self.directory}: no case {case_id!r}; the case_id column of summary.parquet lists them")
        return self._places[case_id]

    def _frame(self, case_id: str, each: str, paths: list[str]) -> "pd.DataFrame":
        import pandas as pd

        place = self._place(case_id)
        with h5py.File(self.directory / "orbits.h5", "r") as file:
            stored = "t" in file  # nothing is where save.orbits is none
            start, stop = (
                file["offsets" if each == SAMPLE else "events/offsets"][place : place + 2] if stored else (0, 0)
            )
            frame = pd.DataFrame({path: file[path][start:stop] if stored else [] for path in paths})
        return frame


def newest(results: Path) -> Path:
    """Return the directory below `results` whose run ended last."""
    records = list(results.glob("*/run.json"))
    if not records:
        raise DirectoryError(
            f"{results}: holds no run yet; `clearsweep run GRID.yaml` makes one, or name its directory"
        )
    return max(records, key=lambda path: path.stat().st_mtime).parent
