"""The worst cases of a run, and their peak revolutions in orbits.h5."""

from collections.abc import Callable, Iterator, Sequence
from typing import Any, NamedTuple

import h5py
import numpy as np
import pyarrow as pa

from ..contracts.results import Peak
from .batch import ResultSchema, summary_schema, write_dataset
from .columns import values_of
from .datasets import GROUP, JOINT, OFFSETS, TURNS, peak_datasets

RANKING_FIGURES = ("force_peak_ratio", "force_peak")  # figures of a joint: the first of which any case has a value
_LENGTH_COLUMNS = ("revolutions_run", "window_from")  # of `simulate.until`


class Worst(NamedTuple):
    """One of the worst cases."""

    case_id: str
    point: dict[str, Any]  # swept path -> value
    joint: int  # index of its joint in the layout
    peak: float  # N, the largest normal force of that joint
    revolutions: float | None  # length of its run, if `simulate.until` determined it
    window_from: float | None  # revolutions before the window of its figures, likewise


#: Reads columns of the summary, some rows at a time.
ReadGroups = Callable[[pa.Schema], Iterator[pa.Table]]
#: Computes the revolution of the largest peak of some cases again, or None if that failed.
ComputePeakRevolutions = Callable[[Sequence[Worst]], Sequence[Peak | None]]


def worst_cases(result_schema: ResultSchema, groups: ReadGroups) -> list[Worst]:
    """Return the worst cases of a summary, the worst first: those with the largest load ratio of any joint.

    If no case has one, the largest normal force counts.
    """
    for figure in RANKING_FIGURES:
        names = [f"{joint.name}_{figure}" for joint in result_schema.layout.joints]
        if {column.name for column in result_schema.layout.columns}.issuperset(names):
            largest = _cases_with_largest(result_schema, groups, names)
            if largest:
                return largest
    return []


def _cases_with_largest(result_schema: ResultSchema, groups: ReadGroups, names: list[str]) -> list[Worst]:
    """Return the cases with the largest value of any of some columns, one for each joint."""
    joints, paths = result_schema.layout.joints, [axis.path for axis in result_schema.axes]
    peaks = [f"{joint.name}_force_peak" for joint in joints]
    full_schema = summary_schema(result_schema)
    optional = [name for name in _LENGTH_COLUMNS if name in full_schema.names]
    names_to_read = dict.fromkeys(["case_id", "status", *paths, *names, *peaks, *optional])
    ranked: list[tuple[float, Worst]] = []
    for group in groups(pa.schema([full_schema.field(name) for name in names_to_read])):
        columns = {name: values_of(group[name].combine_chunks()) for name in names_to_read}
        figures = np.array([columns[name] for name in names])
        figures[:, columns["status"] != "ok"] = np.nan
        largest = np.where(np.isnan(figures).all(axis=0), -np.inf, np.fmax.reduce(figures, axis=0))
        for row in np.lexsort((columns["case_id"], -largest))[: result_schema.worst].tolist():
            if np.isfinite(largest[row]):
                joint = int(np.nanargmax(figures[:, row]))
                point = {path: _plain_value(columns[path][row]) for path in paths}
                length = [float(columns[name][row]) if name in optional else None for name in _LENGTH_COLUMNS]
                case = Worst(columns["case_id"][row], point, joint, float(columns[peaks[joint]][row]), *length)
                ranked.append((float(largest[row]), case))
    ranked.sort(key=lambda entry: (-entry[0], entry[1].case_id))
    return [case for _, case in ranked[: result_schema.worst]]


def _plain_value(value: Any) -> Any:
    return value if isinstance(value, str) else None if value is None or np.isnan(value) else float(value)


def write_worst(file: h5py.File, result_schema: ResultSchema, cases: Sequence[tuple[Worst, Peak]]) -> None:
    """Write the peak revolutions, the worst case first."""
    if not cases:
        return
    paths = [peak.path for _, peak in cases]
    content: dict[str, Any] = {
        f"{GROUP}/case_id": [case.case_id.encode() for case, _ in cases],
        JOINT: [case.joint for case, _ in cases],
        TURNS: [peak.turns for _, peak in cases],
        OFFSETS: np.cumsum([0, *(len(path.t) for path in paths)]),
    }
    for dataset in peak_datasets(result_schema.layout):
        values = content.get(dataset.path)
        if values is None:
            values = np.concatenate([path.channels[dataset.path.removeprefix(f"{GROUP}/")] for path in paths])
        write_dataset(file, dataset, np.asarray(values, dataset.dtype), fletcher32=True)
