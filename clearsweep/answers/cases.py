"""The finished cases of a run, prepared for the sentences that answer the question of its grid."""

import re
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from ..contracts.layout import Layout
from ..language import wording
from . import labels
from .case_ranking import MAX_SPEED, SPEED_AFTER_START, CaseRanking
from .verdict import Limit, figures_of, limits_of

MAX_NAMED_AXES = 4  # varied values of a case above which a sentence has its id instead
UNIT_SUFFIX_PATTERN = re.compile(r"[\s\u00a0].*$")  # of a number with unit: its first blank and everything after it
UNIT_QUANTILE = 0.95  # the display unit suits this quantile of the values, so that a single peak does not decide it
DISPLAY_RANGE = (1e-3, 1e5)  # numbers outside this range have a unit of their own


class WorstCase(NamedTuple):
    """The worst case by a ranking."""

    case_index: int
    columns: tuple[str, ...]  # of the candidate that makes it the worst
    joint: str


class FinishedCases(NamedTuple):
    """The finished cases of a run, as numbers and in words."""

    record: Mapping[str, Any]  # run.json
    layout: Layout
    ranking: CaseRanking
    varied_paths: tuple[str, ...]  # varied paths
    case_ids: Sequence[str]
    values_of: Callable[[str], np.ndarray]  # values (n,) of a column or a path; SI, NaN for null
    format_values: Callable[[str, Sequence[float]], list[str]]  # column and values -> words, in the unit of the column
    describe_value: Callable[[int, str], tuple[str, str] | None]  # index, path -> name and value in words; None: unused
    is_complete: bool = True  # whether these are all cases, so that medians over varied values are known

    def values_text(self, index: int, paths: Sequence[str]) -> str:
        """Return the values of a case at some paths in words: 'crank speed 60 rpm, clearance 0.1 mm'."""
        pairs = [self.describe_value(index, path) for path in paths]
        return ", ".join(f"{name} {value}" for name, value in filter(None, pairs))

    def setting_text(self, index: int) -> str:
        """Return ' at crank speed 60 rpm', or the case id if many values vary; '' if nothing varies."""
        if len(self.varied_paths) > MAX_NAMED_AXES:
            return f" in case {wording.short_id(self.case_ids[index])}"
        setting = self.values_text(index, self.varied_paths)
        return f" at {setting}" if setting else ""

    def difference_text(self, index: int, mentioned_index: int) -> str:
        """Return the values of a case that differ from those of the case mentioned before, ' at crank speed 60 rpm'."""
        if len(self.varied_paths) > MAX_NAMED_AXES:
            return self.setting_text(index)
        if index == mentioned_index:
            return " in the same case" if self.varied_paths else ""
        paths = [
            path for path in self.varied_paths if self.values_of(path)[index] != self.values_of(path)[mentioned_index]
        ]
        unchanged_text = ", otherwise the same" if len(paths) < len(self.varied_paths) else ""
        return f" at {self.values_text(index, paths)}{unchanged_text}"

    def case_text(self, index: int) -> str:
        """Return ' (case 1a7fc708)', or '' if `setting_text` returns the id already."""
        return "" if len(self.varied_paths) > MAX_NAMED_AXES else f" (case {wording.short_id(self.case_ids[index])})"

    def figure_text(self, column_name: str, index: int) -> str:
        """Return a figure of a case in words."""
        return self.format_values(column_name, [float(self.values_of(column_name)[index])])[0]

    def has_values(self, column_name: str) -> bool:
        """Return whether any case has a figure."""
        if not any(known.name == column_name for known in self.layout.columns):
            return False
        return bool(np.isfinite(self.values_of(column_name)).any())

    @property
    def limits(self) -> tuple[Limit, ...]:
        """Return the limits of the grid."""
        return limits_of(self.record.get("limits") or {}, self.layout.columns)

    def limit_label(self, limit: Limit) -> str:
        """Return a limit in words."""
        units = {column.name: column.unit for column in self.layout.columns}
        units |= {figure.name: figure.unit for figure in figures_of(self.record.get("figures") or {}, units)}
        return labels.limit_label(self.layout, limit, units.get(limit.column, "1"))

    def column_label(self, column_name: str) -> str:
        """Return the label of a column."""
        return labels.column_label(self.layout, column_name)

    def argmin_argmax(self, column_name: str) -> tuple[int, int]:
        """Return the indices of the smallest and the largest value of a figure that some case has."""
        values = self.values_of(column_name)
        return int(np.nanargmin(values)), int(np.nanargmax(values))

    def worst_case(self, ranking: CaseRanking | None = None) -> WorstCase | None:
        """Return the worst case by a ranking, default `ranking`; None if all are null."""
        ranking = ranking or self.ranking
        if not ranking.candidates:
            return None
        values, candidate_indices = ranking.worst_values({name: self.values_of(name) for name in ranking.columns})
        severity = ranking.severity(values)
        if np.isneginf(severity).all():
            return None
        index = int(np.flatnonzero(severity == severity.max())[-1])
        candidate = ranking.candidates[int(candidate_indices[index])]
        return WorstCase(index, candidate.columns, candidate.joint)

    def joint_text(self, joint: str) -> str:
        """Return ' in joint NAME', or '' if there is only one joint."""
        return f" in joint {wording.joint_name(joint)}" if len(self.layout.joints) > 1 else ""


def column_scale(column_name: str, unit: str, column_values: np.ndarray) -> wording.Scale:
    """Return the display unit of a column: it suits the 0.95 quantile of the values, for film thicknesses the median.

    column_values : (n,) SI, the values of the column
    """
    if column_name in (MAX_SPEED, SPEED_AFTER_START):
        return wording.scale(unit, 0.0, speed=True)
    magnitudes = np.abs(column_values[np.isfinite(column_values)])
    magnitudes = magnitudes[magnitudes > 0.0]
    quantile = 0.5 if column_name.endswith("film_thickness_min") else UNIT_QUANTILE
    typical_magnitude = np.quantile(magnitudes, quantile) if magnitudes.size else 0.0
    return wording.scale(unit, float(typical_magnitude))


def column_texts(column_name: str, unit: str, column_values: np.ndarray, values: Sequence[float]) -> list[str]:
    """Return values of a column as number and unit: in the unit of the column, or in their own if it does not suit."""
    scale = column_scale(column_name, unit, np.asarray(column_values, float))
    displayed_magnitudes = [abs(value) / scale.factor for value in values if value and np.isfinite(value)]
    if displayed_magnitudes and not (
        DISPLAY_RANGE[0] <= min(displayed_magnitudes) and max(displayed_magnitudes) < DISPLAY_RANGE[1]
    ):
        return wording.texts_in_common_unit(values, unit)
    return [scale.text(value) for value in values]


def range_text(first: str, last: str) -> str:
    """Return 'from 1 to 2 mm' for '1 mm' and '2 mm'."""
    match = UNIT_SUFFIX_PATTERN.search(last)
    common_unit = match[0] if match and "(" not in last else ""
    return f"from {first.removesuffix(common_unit)} to {last}"
