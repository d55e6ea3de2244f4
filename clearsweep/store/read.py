"""Reads the results of a run: summary, orbits, events and wear; damaged files are reported by name."""

import html
import os
from collections.abc import Iterable, Iterator
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pyarrow as pa

from ..answers.verdict import limits_and_figures_of
from ..contracts import results
from ..contracts.layout import SECTION_COUNT, Column, Layout
from ..language import wording
from ..language.errors import DirectoryError, InputError
from ..searches import SEARCHES, search_of
from . import durable
from .batch import GROUP_ROWS, has_histories, ids_of_column
from .datasets import (
    EVENT,
    GROUP,
    ID_LENGTH,
    JOINT,
    NODE,
    OFFSETS,
    SAMPLE,
    SECTION,
    TURNS,
    Stored,
    field_of,
    id_texts,
    life_datasets,
    read_values,
    values_of,
)
from .directory import ANSWER_FILES, FINAL_FILES, ORBITS_FILE, SUMMARY_FILE
from .parts import Part, attributes_of, damage_said, plausible, to_frame, unfinished_error
from .record import RECORD_FILE, check_format, damaged_error, declared_values, kind_of_axis, read_record

if TYPE_CHECKING:
    import pandas as pd  # imported only for frames
    import xarray  # optional; imported only on demand

EVENT_COLUMNS = ("t", "joint", "kind")  # of `event_blocks`
COLUMN_TYPES = {pa.float64(), pa.int64(), pa.string()}  # of columns
HEXADECIMAL = frozenset("0123456789abcdef")  # digits of a case_id
OFFSETS_BY_ITEM = {SAMPLE: "offsets", EVENT: "events/offsets", SECTION: "poincare/offsets", NODE: "history/offsets"}


MAX_NAMED = 3  # most cases in a message


class StoredRun:
    """The results in one directory.

    Attributes
    ----------
    directory : Path
    grid : dict, the content of run.json: name, axes and base case in SI, units of the axes, versions, machine, counts.
    layout : Layout, joints, columns and channels.
    summary : DataFrame, one row per case in case_id order; `attrs["units"]` and `attrs["descriptions"]` by column.
    """

    def __init__(self, directory: str | Path, files_directory: Path | None = None):
        """Open a directory; `files_directory` contains its files if they were assembled elsewhere."""
        self.directory = Path(directory)
        self.files_directory = files_directory or self.directory
        self.grid = read_record(self.files_directory)
        check_format(self.files_directory, self.grid)
        self.layout = Layout.read(self.grid["layout"])
        self._set_part()
        verify(self.files_directory, self.grid, (SUMMARY_FILE, *ANSWER_FILES))
        self._check_content()

    def _set_part(self) -> None:
        """Set the parts of the run: one, whose orbits.h5 has the mark of run.json."""
        files = {name: self.files_directory / name for name in (*FINAL_FILES, *ANSWER_FILES)}
        self.parts = [Part(files, Stored(self.layout, self.histories), self.grid.get("merged", {}).get("mark"))]

    @property
    def histories(self) -> bool:
        """Return whether samples and events are stored."""
        return has_histories(self.grid["frame"])

    @property
    def files(self) -> tuple[str, ...]:
        """Return the names of the files that a reader uses."""
        return (*FINAL_FILES, RECORD_FILE)

    def marks(self) -> list[dict[str, Any]]:
        """Return the marks of the blocks, or [] for a run without blocks."""
        return []

    def sample_and_extremes(self, columns: list[str]) -> Iterator[dict[str, np.ndarray]]:
        """Yield the same as `blocks`; for a run in blocks, only random and extreme rows."""
        return self.blocks(columns)

    @classmethod
    def check_merged(cls, directory: Path, record: dict[str, Any]) -> None:
        """Raise DamagedError if the merged files of a directory have content that no run writes."""
        run = cls.__new__(cls)
        run.directory, run.files_directory, run.grid = directory, directory, record
        run.layout = Layout.read(record["layout"])
        run._set_part()
        run._check_content()
        for _ in run.parts[0].rows():  # checks every value
            pa.default_memory_pool().release_unused()  # it would keep the gaps between the columns of a group

    def _check_content(self) -> None:
        """Raise DamagedError if the merged files have content that no run writes; their checksums do not prove that."""
        self._check_columns()
        (part,), counts = self.parts, self.grid.get("counts", {})
        if {"ok", "failed"} <= counts.keys() and len(self) != counts["ok"] + counts["failed"]:
            raise damaged_error(part.files[SUMMARY_FILE], "its number of rows is not that in run.json")
        self._check_axes()
        with part.orbits():  # checks it
            pass
        first, is_same = 0, bool((part.ids[1:] > part.ids[:-1]).all())
        with damage_said(part.files[SUMMARY_FILE]):
            for rows in part.rows(["case_id"]):
                is_same &= np.array_equal(ids_of_column(rows.column(0)), part.ids[first : first + len(rows)])
                first += len(rows)
        if not is_same or first != len(part.ids):
            raise damaged_error(part.files[ORBITS_FILE], "its cases are not those of summary.parquet, in order")

    def _check_columns(self) -> None:
        """Raise DamagedError if the columns of a table disagree with run.json."""
        try:
            computed = limits_and_figures_of(self.grid).columns
        except InputError as error:
            raise damaged_error(self.files_directory / RECORD_FILE, f"figures: {error}") from error
        names = ("case_id", "status", "message", *self.grid.get("case_labels", []))
        texts = [Column(name, "", "", "text") for name in names]
        axes = [Column(path, unit, "", kind_of_axis(self.grid, path)) for path, unit in self.grid["units"].items()]
        self._check_fields(SUMMARY_FILE, [*texts, *axes, *self.layout.columns, *computed])
        for search in SEARCHES:
            name = f"{search.name}.parquet"
            if name in self.grid.get("answers", {}):
                self._check_fields(name, [Column(column, "", "", "") for column in search.table_columns(self.grid)])

    def _check_fields(self, name: str, columns: Iterable[Column]) -> None:
        """Raise DamagedError unless a table has these columns, of their kind and with their unit if they are known."""
        expected = {column.name: column for column in columns}
        with self.parts[0].table(name) as table:
            fields = list(table.schema_arrow)
            is_valid = sorted(field.name for field in fields) == sorted(expected)
            for field in fields if is_valid else ():
                column, described = expected[field.name], field.metadata or {}
                unit = described[b"unit"].decode() if described.keys() >= {b"unit", b"description"} else None
                described.get(b"description", b"").decode()  # UnicodeDecodeError is a ValueError
                is_valid &= unit is not None and field.type in COLUMN_TYPES
                is_valid &= not column.kind or (field.type == field_of(column).type and unit == column.unit)
        if not is_valid:
            raise damaged_error(self.parts[0].files[name], "its columns differ from those in run.json")

    def _check_axes(self) -> None:
        """Raise DamagedError if a case has another value on an axis than run.json lists; a search adds values."""
        declared = {path: declared_values(self.grid, path) for path in self.grid["units"]}
        unused = [None] if any(kind_of_axis(self.grid, path) == "text" for path in declared) else []  # by a swept law
        listed = {path: [*values, *unused] for path, values in declared.items() if values is not None}
        for path, values in listed.items():
            if not _are_listed((rows.column(0) for rows in self.parts[0].rows([path])), values):
                raise damaged_error(self.parts[0].files[SUMMARY_FILE], f"{path} has other values than in run.json")

    def __len__(self) -> int:
        return sum(map(len, self.parts))

    def __repr__(self) -> str:
        return f"<clearsweep run {str(self.directory)!r}: {len(self)} cases>"

    def _repr_html_(self) -> str:
        """Return the preview for a notebook: smallest, median and largest value of every axis and figure."""
        numbers = [name for name in self.units if self.schema.field(name).type != pa.string()]
        blocks = [*self.sample_and_extremes(numbers)]
        rows = ""
        for name in numbers:
            values = np.concatenate([np.empty(0), *(block[name] for block in blocks)])
            known = values[~np.isnan(values)]
            quantiles = np.quantile(known, [0.0, 0.5, 1.0], method="nearest") if known.size else [None] * 3
            cells = (wording.quantity_text(value, self.units[name]) for value in quantiles)
            rows += f"<tr><td>{html.escape(name)}</td>{''.join(f'<td>{cell}</td>' for cell in cells)}</tr>"
        heads = "".join(f"<th>{head}</th>" for head in ("column", "smallest", "median", "largest"))
        return f"<p><code>{html.escape(repr(self))}</code></p><table><tr>{heads}</tr>{rows}</table>"

    def to_xarray(self, channels: Iterable[str] | None = None) -> "xarray.Dataset":
        """Return figures over `case_id`, and time histories over `case_id` and `sample`, as an xarray.Dataset.

        channels : names of the time histories; default all that are stored, () for none.  The coordinate `t` (s) has
        the time of each sample.  Shorter histories end with NaN.  Every variable has `units` in its attributes.

        Needs xarray, which `pip install "clearsweep[xarray]"` installs; an ImportError says so.  Raises InputError for
        a channel that is not stored.
        """
        stored = {channel.name: channel.unit for channel in self.layout.stored if self.histories}
        names = [*stored] if channels is None else list(channels)
        if unknown := [name for name in names if name not in stored]:
            raise InputError(f"no channel {unknown[0]!r} is stored; there are {', '.join(stored) or 'none'}")
        ids = self.column("case_id")
        data: dict[str, Any] = {
            name: ("case_id", self.column(name), {"units": unit})
            for name, unit in self.units.items()
            if name != "case_id"
        }
        sizes, histories = [], {name: [np.empty(0)] for name in dict.fromkeys(["t", *names]) if name in stored}
        for part in self.parts if names else ():
            with part.orbits() as file:
                sizes += np.diff(file["offsets"][:]).tolist()
                for name, pieces in histories.items():
                    pieces.append(read_values(file, name, slice(None)))
        lengths = np.array(sizes or [0], int)
        is_sample = np.arange(lengths.max()) < lengths[:, np.newaxis]
        for name, pieces in histories.items() if names else ():
            table = np.full(is_sample.shape, np.nan)
            table[is_sample] = np.concatenate(pieces)
            data[name] = (("case_id", "sample"), table, {"units": stored[name]})
        coordinates = {"case_id": ids} | ({"t": data.pop("t"), "sample": np.arange(lengths.max())} if names else {})
        attributes = {"name": str(self.grid.get("name") or ""), "model_version": self.grid["model_version"]}
        return results.dataset(data, coordinates, attributes)

    @cached_property
    def summary(self) -> "pd.DataFrame":
        """Return the summary as a DataFrame; `attrs["units"]` and `attrs["descriptions"]` hold these by column."""
        with self.parts[0].table() as file:
            return to_frame(plausible(file.read(use_threads=False)))

    @cached_property
    def schema(self) -> pa.Schema:
        """Return the columns of the summary; their metadata hold `unit` and `description`."""
        with self.parts[0].table() as file:
            return file.schema_arrow

    @cached_property
    def units(self) -> dict[str, str]:
        """Return the unit (SI) of every column of the summary, in their order."""
        return attributes_of(self.schema)["units"]

    @property
    def columns(self) -> list[str]:
        """Return the names of the columns of the summary, in their order."""
        return list(self.units)

    def column(self, name: str) -> np.ndarray:
        """Return a column of the summary for all cases, without pandas; a frame of a million cases takes 0.5 GB.

        Numbers are float64, NaN if missing; texts are objects, None if missing.
        """
        if name == "case_id":
            return id_texts(np.concatenate([part.ids for part in self.parts])).astype(str).astype(object)
        is_text = self.schema.field(name).type == pa.string()
        values, offset = np.empty(len(self), object if is_text else float), 0
        for block in self.blocks([name]):  # group by group, so that only one copy exists
            values[offset : offset + len(block[name])] = block[name]
            offset += len(block[name])
        if len(values) > GROUP_ROWS:  # it takes 1 ms
            pa.default_memory_pool().release_unused()  # it would keep the gaps between the groups
        return values

    def blocks(self, columns: list[str]) -> Iterator[dict[str, np.ndarray]]:
        """Yield these columns of the summary, name -> values, for a few thousand rows at a time.

        Numbers are float64, NaN if missing; texts are objects, None if missing.
        """
        for part in self.parts:
            for batch in part.rows(columns):
                yield {name: values_of(batch.column(name)) for name in columns}

    def orbit(self, case_id: str) -> "pd.DataFrame":
        """Return the time histories of one case as a DataFrame, columns by channel; `attrs["units"]` by column.

        It is empty for a failed case and if `save.orbits` is none.
        """
        return _frame(self.orbit_columns(case_id), {channel.name: channel.unit for channel in self.layout.stored})

    def orbit_columns(self, case_id: str) -> dict[str, np.ndarray]:
        """Return the columns of `orbit` as arrays, without pandas."""
        return self._arrays(case_id, SAMPLE, [channel.name for channel in self.layout.stored])

    def events(self, case_id: str) -> "pd.DataFrame":
        """Return the contact events of one case as a DataFrame: t (s), joint, kind, rate (m/s), force_peak (N)."""
        units = {"t": "s", "joint": "", "kind": "", "rate": "m/s", "force_peak": "N"}
        return _frame(self.event_columns(case_id), units)

    def event_columns(self, case_id: str) -> dict[str, np.ndarray]:
        """Return the columns of `events` as arrays, without pandas."""
        columns = self._arrays(case_id, EVENT, [f"events/{name}" for name in results.EVENT_DTYPE.names or ()])
        for name, words in (("joint", self.layout.contacts), ("kind", results.EVENT_KINDS)):
            columns[name] = np.array([*words, None], object)[columns[name].astype(int)]
        return columns

    def event_blocks(self) -> Iterator[tuple[np.ndarray, dict[str, np.ndarray]]]:
        """Yield the numbers of events by case, and t (s), joint and kind of all events, a few thousand cases at a time.

        joint : index in `layout.contacts`; kind : index in `results.EVENT_KINDS`.  Empty if `save.orbits` is none.
        """
        for part in self.parts:
            with part.orbits() as file:
                offsets = file["events/offsets"][:] if self.histories else np.zeros(1, "i8")
                for first in range(0, len(offsets) - 1, GROUP_ROWS):
                    bounds = offsets[first : first + GROUP_ROWS + 1]
                    span = slice(int(bounds[0]), int(bounds[-1]))
                    yield np.diff(bounds), {name: read_values(file, f"events/{name}", span) for name in EVENT_COLUMNS}

    @property
    def seek(self) -> "pd.DataFrame | None":
        """Return the answers of `seek` as a DataFrame, `attrs["units"]` by column; None if there is no search."""
        return self.search_table("seek")

    @property
    def optimise(self) -> "pd.DataFrame | None":
        """Return the best cases as a DataFrame, `attrs["units"]` by column, or None if nothing was optimised."""
        return self.search_table("optimise")

    @property
    def identify(self) -> "pd.DataFrame | None":
        """Return a weighted sample of the parameters of a measured machine, or None if nothing was identified.

        It is a DataFrame with a column `weight`, `attrs["units"]` by column.
        """
        return self.search_table("identify")

    def search_table(self, search: str) -> "pd.DataFrame | None":
        """Return the table of a search by its name, `attrs["units"]` by column, or None if it has none."""
        name = f"{search}.parquet"
        if name not in self.grid.get("answers", {}):
            return None
        with self.parts[0].table(name) as file:
            table = plausible(file.read(use_threads=False))
        frame = table.replace_schema_metadata(None).to_pandas(use_threads=False)
        frame.attrs["units"] = {field.name: field.metadata[b"unit"].decode() for field in table.schema}
        return frame

    def poincare(self, case_id: str) -> "pd.DataFrame":
        """Return journal positions (m) and velocities (m/s) at crank angle 0 of every revolution.

        Columns are `rod_slider/x` and the like, with `attrs["units"]`; `revolution` counts turns of the crank.
        The result is empty if `orbit` returns an empty DataFrame.
        """
        units = {channel.name.replace("joints/", "", 1): channel.unit for channel in self.layout.channels}
        columns = self.section_columns(case_id)
        return _frame(columns, {name: units.get(name, "1") for name in columns})

    def section_columns(self, case_id: str) -> dict[str, np.ndarray]:
        """Return the columns of `poincare` as arrays, without pandas."""
        names = [path for _, path in self.layout.sections]
        return self._arrays(case_id, SECTION, [SECTION_COUNT, *names] if names else [])

    @property
    def worst(self) -> list[str]:
        """Return the cases whose peak revolution was saved (`save.worst`), worst first."""
        worst: list[str] = []
        for part in self.parts if self.grid.get("save", {}).get("worst") else ():
            with part.orbits() as file:
                worst += [case_id.decode() for case_id in file[f"{GROUP}/case_id"][:]] if GROUP in file else []
        return worst

    def peak_revolution(self, case_id: str) -> "pd.DataFrame":
        """Return the time histories of the peak revolution of a case; raise InputError if it was not saved.

        Columns and `attrs["units"]` as those of `orbit`; `attrs["joint"]` is the joint of the peak ('rod_slider'),
        `attrs["turns"]` the number of earlier revolutions.
        """
        (part, row), channels = self._find(case_id), self.layout.channels
        case_id = part.id_at(row)
        with part.orbits() as file:
            saved = file[f"{GROUP}/case_id"][:].tolist() if GROUP in file else []
            if case_id.encode() not in saved:
                others = ", ".join(case_id.decode() for case_id in saved) or "none; `save: {worst: 3}` asks for them"
                raise InputError(f"{self.directory}: the peak of {case_id} was not saved (those that were: {others})")
            row = saved.index(case_id.encode())
            span = slice(*file[OFFSETS][row : row + 2])
            columns = {channel.name: read_values(file, f"{GROUP}/{channel.name}", span) for channel in channels}
            frame = _frame(columns, {channel.name: channel.unit for channel in channels})
            frame.attrs["joint"] = self.layout.joints[int(read_values(file, JOINT, slice(row, row + 1))[0])].name
            frame.attrs["turns"] = float(file[TURNS][row])
        return frame

    def wear(self, case_id: str) -> dict[str, tuple[np.ndarray, np.ndarray]]:
        """Return joint -> (bearing, journal): depths in m per angular bin of each body; NaN for a failed case.

        The shape is (bins,), for a spatial joint (bins, length bins).
        """
        part, row = self._find(case_id)
        with part.orbits() as file:
            return {
                joint.name: (
                    read_values(file, f"wear/{joint.name}/bearing", row),
                    read_values(file, f"wear/{joint.name}/journal", row),
                )
                for joint in self.layout.joints
                if joint.wear_bins
            }

    def history(self, case_id: str) -> dict[str, np.ndarray]:
        """Return the history of the life of one case, as Trajectory.history, or {} if there is no `life`.

        The arrays of a failed case are empty.
        """
        if not self.layout.life:
            return {}
        part, row = self._find(case_id)
        with part.orbits() as file:
            span = slice(*file[OFFSETS_BY_ITEM[NODE]][row : row + 2])
            paths = sorted(dataset.path for dataset in life_datasets(self.layout))
            return {path.removeprefix(results.HISTORY): read_values(file, path, span) for path in paths}

    def full_id(self, prefix: str) -> str:
        """Return the case_id that begins with `prefix`; InputError if there is none or more than one."""
        part, row = self._find(prefix)
        return part.id_at(row)

    def _find(self, prefix: str) -> tuple[Part, int]:
        """Return the part and the row of the case whose case_id begins with `prefix`."""
        text, count, candidates = str(prefix), 0, []
        if 0 < len(text) <= ID_LENGTH and HEXADECIMAL.issuperset(text):
            low, high = int(text.ljust(ID_LENGTH, "0"), 16), int(text.ljust(ID_LENGTH, "f"), 16)
            for part in self.parts:
                first, end = part.rows_between(low, high)
                count += end - first
                candidates += [(part, row) for row in range(first, min(end, first + MAX_NAMED))]
        if not count:
            raise InputError(f"{self.directory}: no case {prefix!r}; the case_id column of {self.files[0]} lists them")
        if count > 1:
            names = ", ".join(sorted(part.id_at(row) for part, row in candidates)[:MAX_NAMED])
            more = ", ..." if count > MAX_NAMED else ""
            raise InputError(
                f"{self.directory}: {count} cases begin with {prefix!r} ({names}{more}); write more characters"
            )
        return candidates[0]

    def _arrays(self, case_id: str, item: str, paths: list[str]) -> dict[str, np.ndarray]:
        """Return datasets of one case, by the last parts of their paths; empty ones if `save.orbits` is none."""
        part, row = self._find(case_id)
        with part.orbits() as file:
            stored = bool(paths) and self.histories
            span = slice(*file[OFFSETS_BY_ITEM[item]][row : row + 2]) if stored else slice(0)
            values = [read_values(file, path, span) if stored else np.empty(0) for path in paths]
        names = (path.removeprefix("events/").removeprefix("poincare/") for path in paths)
        return dict(zip(names, values, strict=True))


def _frame(columns: dict[str, np.ndarray], units: dict[str, str]) -> "pd.DataFrame":
    """Return columns as a DataFrame with their units."""
    import pandas as pd

    frame = pd.DataFrame(columns)
    frame.attrs["units"] = units
    return frame


def _are_listed(column: Iterable[pa.Array], values: list[Any]) -> bool:
    """Return whether a column has no other values than these; a set of a hundred thousand numbers takes 9 MB."""
    words = {value for value in values if value is None or isinstance(value, str)}
    numbers = np.sort([*(value for value in values if value not in words), np.inf])
    for part in column:
        present = values_of(part)
        if part.type == pa.string():
            is_listed = words.issuperset(present.tolist())
        else:
            known = present[~np.isnan(present)]  # without null
            is_listed = bool((numbers[np.searchsorted(numbers, known)] == known).all())
            is_listed &= not part.null_count or None in words
        if not is_listed:
            return False
    return True


def verify(directory: Path, record: dict[str, Any], names: Iterable[str] = (*FINAL_FILES, *ANSWER_FILES)) -> None:
    """Raise DamagedError if the checksum of a file differs from that in `record`, its run.json."""
    search = search_of(record)
    for path in (directory / name for name in names):
        if "merged" not in record:
            raise unfinished_error(directory, path.name)
        if path.name in ANSWER_FILES and "answers" not in record and search and search.has_table:
            raise damaged_error(path, "run.json has no checksum of it, as an older version wrote it")
        expected = (record["merged"] | record.get("answers", {})).get(path.name)
        if expected is None and path.name in ANSWER_FILES and not os.path.lexists(path):
            continue  # there was no search
        try:
            actual = durable.checksum(path)
        except FileNotFoundError:
            raise unfinished_error(directory, path.name) from None
        if actual != expected:
            raise damaged_error(path, "its checksum is not that in run.json")


def newest_run(results: Path) -> Path:
    """Return the directory below `results` of the latest run."""
    records = list(results.glob("*/run.json"))
    if not records:
        remedy = "`clearsweep run GRID.yaml` creates one; or name the directory of a run"
        raise DirectoryError(f"{results}: contains no run yet; {remedy}")
    return max(records, key=lambda path: path.stat().st_mtime).parent
