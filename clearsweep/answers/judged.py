"""The judged cases of a run: their varied values as codes, their figures and their verdicts."""

import math
from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Any

import numpy as np

from ..contracts import catalogue
from .verdict import Assessment, Limit, LimitsAndFigures, limits_and_figures_of

MET, EXCEEDED, UNDECIDED = "met", "exceeded", "undecided"  # verdicts of a case
#: Last keys of numerical settings of which the smaller value is the finer one; of all others it is the larger one.
FINER_IF_SMALLER = ("tolerance", "velocity_scale", "v0", "v1", "width", "from")

Key = tuple[int, ...]  # codes of the values at some paths, -1 where the case does not use a path


class Cases:
    """The judged cases of a run, with the codes of their varied values."""

    def __init__(
        self, record: Mapping[str, Any], columns: Mapping[str, Any], own: Sequence[bool] | np.ndarray | None = None
    ):
        """Prepare the cases of a grid.

        record : run.json; columns : (n,) each, by name; own : (n,) mask of the grid's own cases, default all
        """
        self.record = record
        is_own = np.ones(len(columns["case_id"]), bool) if own is None else np.asarray(own, bool)
        self.added_count = int((~is_own).sum())
        self._columns = columns
        self.role_by_path: dict[str, str] = dict(record.get("roles") or {})
        self._rows = np.flatnonzero(is_own)
        self.paths = [path for path in self.role_by_path if self._is_varied(path)]
        self.coarse_rows = np.zeros(0, int)
        numerics = self.paths_of(catalogue.NUMERICS)
        if numerics and len(self._rows):
            # For every own case the position of the finest case that differs in numerics alone, and a mask of these
            others = [path for path in self.paths if path not in numerics]
            group = combined_codes([codes_of(self.values(path))[1] for path in others], len(self))
            fineness = [fineness_of(path, *codes_of(self.values(path))) for path in numerics]
            order = np.lexsort([*fineness[::-1], group])
            is_last = np.append(np.diff(group[order]) != 0, True)
            finest_of_group = dict(zip(group[order][is_last].tolist(), order[is_last].tolist(), strict=True))
            finest_of = np.array([finest_of_group[number] for number in group.tolist()])
            self.finest_of, is_finest = finest_of, finest_of == np.arange(len(self))
            self._all_rows = self._rows
            self._rows = self._rows[is_finest]
        self.codes = {path: codes_of(self.values(path)) for path in self.paths if path not in numerics}
        status = self.values("status")
        self.is_finished = np.array([value == "ok" for value in status.tolist()], bool)

    def __len__(self) -> int:
        return len(self._rows)

    def _is_varied(self, path: str) -> bool:
        if path not in self._columns:
            return False
        values = _array(self._columns[path])
        return len(codes_of(values[self._rows] if len(self._rows) else values)[0]) > 1  # a search runs none of its own

    def paths_of(self, *names: str) -> list[str]:
        """Return the varied paths with one of these roles."""
        return [path for path in self.paths if self.role_by_path[path] in names]

    def labels_of(self, rows: np.ndarray) -> dict[str, dict[str, list[str]]]:
        """Return under `labels` the texts that ride along with some judged cases, by header; {} without such texts."""
        names = [name for name in self.record.get("case_labels") or [] if name in self._columns]
        texts = {name: [str(text) for text in self.values(name)[rows].tolist()] for name in names}
        return {"labels": {name: list(dict.fromkeys(each)) for name, each in texts.items()}} if names else {}

    def values(self, name: str) -> np.ndarray:
        """Return a column of the judged cases."""
        return _array(self._columns[name])[self._rows]

    def numbers(self, name: str) -> np.ndarray:
        """Return a figure of the judged cases as floats; NaN where it is missing or the case failed."""
        return np.where(self.is_finished, _floats(self.values(name)), np.nan)

    def figure_of_all(self, name: str) -> np.ndarray:
        """Return a figure of the own cases, coarse ones included, as floats; NaN where it is missing."""
        is_ok = np.array([value == "ok" for value in _array(self._columns["status"])[self._all_rows].tolist()])
        return np.where(is_ok, _floats(_array(self._columns[name])[self._all_rows]), np.nan)

    def values_of_all(self, name: str) -> np.ndarray:
        """Return a column of the own cases, coarse ones included."""
        return _array(self._columns[name])[self._all_rows]

    def rows_of(self, values: Mapping[str, Any]) -> np.ndarray:
        """Return the judged cases (indices) with these values, in the form of the answer; an unused path matches."""
        is_match = np.ones(len(self), bool)
        for path, value in values.items():
            levels, codes = self.codes[path]
            wanted = [code for code, level in enumerate(levels) if named_value(self.record, path, level) == value]
            is_match &= np.isin(codes, [-1, *wanted])
        return np.flatnonzero(is_match)

    def keys(self, paths: Sequence[str]) -> list[Key]:
        """Return the codes of every case at some paths."""
        columns = [self.codes[path][1].tolist() for path in paths]
        return list(zip(*columns, strict=True)) if columns else [()] * len(self)

    def values_at(self, paths: Sequence[str], key: Key) -> dict[str, Any]:
        """Return the values of a key in the form of the answer, without unused paths."""
        return {
            path: named_value(self.record, path, self.codes[path][0][code])
            for path, code in zip(paths, key, strict=True)
            if code >= 0
        }

    @cached_property
    def limits(self) -> tuple[Limit, ...]:
        """Return the limits of the grid."""
        return limits_and_figures_of(self.record).limits

    @cached_property
    def assessment(self) -> Assessment:
        """Return how the judged cases compare with the limits."""
        names = {name for limit in self.limits for name in (limit.column, limit.times) if name}
        columns = {name: self.numbers(name) for name in names}
        return LimitsAndFigures((), self.limits).assess(columns, self.is_finished)

    @cached_property
    def verdicts(self) -> np.ndarray:
        """Return the verdict of every judged case, (n,)."""
        exceeded, undecided = self.assessment.exceeded.any(axis=0), self.assessment.undecided.any(axis=0)
        return np.where(exceeded, EXCEEDED, np.where(undecided, UNDECIDED, MET))


def fineness_of(path: str, levels: list, codes: np.ndarray) -> np.ndarray:
    """Return numbers (n,) that increase with the fineness of the values at a numerical path."""
    sign = -1 if path.rpartition(".")[2] in FINER_IF_SMALLER else 1
    return sign * codes


def combined_codes(columns: Sequence[np.ndarray], count: int) -> np.ndarray:
    """Return one number for each case that is equal where all codes are; columns : (n,) each."""
    number = np.zeros(count, np.int64)
    for codes in columns:
        number = number * (int(codes.max(initial=0)) + 2) + codes + 1
        number = np.unique(number, return_inverse=True)[1].reshape(-1)
    return number


def codes_of(values: np.ndarray) -> tuple[list, np.ndarray]:
    """Return the distinct values, numbers ascending, texts in order of appearance, and each value's index; null: -1."""
    if values.dtype.kind in "fiub":
        unique_values, indices = np.unique(values, return_inverse=True)
        is_known = np.isfinite(unique_values.astype(float))
        return unique_values[is_known].tolist(), np.where(is_known[indices], indices, -1).reshape(-1)
    present = [value for value in values.tolist() if not is_null(value)]
    has_text = any(isinstance(value, str) for value in present)
    levels = list(dict.fromkeys(present)) if has_text else sorted(set(present))
    index_of = {value: index for index, value in enumerate(levels)}
    return levels, np.array([-1 if is_null(value) else index_of[value] for value in values.tolist()], int)


def is_null(value: Any) -> bool:
    """Return whether a value is None or NaN."""
    return value is None or (isinstance(value, float) and math.isnan(value))


def named_value(record: Mapping[str, Any], path: str, value: Any) -> Any:
    """Return a varied value as the answer has it: the label or the fit if it has one, a law's name, else SI."""
    for name, labelled in ((record.get("labels") or {}).get(path) or {}).items():
        if labelled == value:
            return name
    for fit in (record.get("fits") or {}).get(path) or ():
        if fit["mean"] == value:
            return fit["name"]
    return plain_value(value)


def plain_value(value: Any) -> Any:
    """Return a value as JSON has it: a word, a truth value or a float."""
    return value if isinstance(value, str | bool) else float(value)


def _array(values: Any) -> np.ndarray:
    return values if isinstance(values, np.ndarray) else np.array(list(values), object)


def _floats(values: np.ndarray) -> np.ndarray:
    if values.dtype.kind == "O":
        return np.array([np.nan if is_null(value) else value for value in values.tolist()], float)
    return values.astype(float)
