"""The leading question of a run: one order for verdict, cards, summary table and sorting."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from ..contracts.case import value_at
from ..contracts.layout import JointLayout, Layout
from ..language import wording
from .verdict import EXCEEDED_COLUMN, MARGIN_COLUMN, UNDECIDED_COLUMN, Limit, column_label

#: The questions of a grid in order of precedence.  Start-up, film and force studies are recognised by their content,
#: if there is no other question.
QUESTIONS = ("seek", "optimise", "identify", "life", "limits", "start-up", "film", "force")
SEARCHES = ("seek", "optimise", "identify")  # questions that are sections of a grid which choose cases
SENSES = ("minimise", "maximise")
TORQUE_UNIT = "N*m"  # of the force figures of a joint in rotation
START_UP, MAX_SPEED, SPEED_AFTER_START = "start_up_time", "crank_speed_max", "crank_speed_after"  # columns


_SMALLEST_IS_WORST, _LARGEST_IS_WORST = True, False  # which end of the ranking figure is worst


class Candidate(NamedTuple):
    """Columns of one joint or of the whole mechanism; the first column ranks it."""

    joint: str  # 'rod_slider', '' for the mechanism
    columns: tuple[str, ...]


class CaseRanking(NamedTuple):
    """The ranking of the cases of a run."""

    question: str  # one of QUESTIONS: the leading question of the run
    title: str  # heading of the summary table
    headings: tuple[str, ...]  # labels of each candidate's columns
    is_smallest_worst: bool  # whether the smallest value is worst
    candidates: tuple[Candidate, ...]
    limits: tuple[Limit, ...] = ()  # where the margin ranks

    @property
    def columns(self) -> tuple[str, ...]:
        """Return all columns that the ranking needs."""
        names = dict.fromkeys(name for candidate in self.candidates for name in candidate.columns)
        names |= dict.fromkeys(name for limit in self.limits for name in (limit.times, limit.floor) if name)
        return (*names, EXCEEDED_COLUMN, UNDECIDED_COLUMN) if MARGIN_COLUMN in names else tuple(names)

    def worst_values(self, columns: Mapping[str, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
        """Return the worst value of each case over the candidates, NaN if all are null, and the candidate's index.

        columns : (n,) each, NaN for null; a case that exceeds a limit without a margin is the worst of all
        """
        values = np.array([np.asarray(columns[candidate.columns[0]], float) for candidate in self.candidates])
        if MARGIN_COLUMN in self.columns:
            is_beyond, is_open = (
                np.array([isinstance(names, str) and names != "" for names in np.asarray(columns[name]).tolist()], bool)
                for name in (EXCEEDED_COLUMN, UNDECIDED_COLUMN)
            )
            if self.question == "optimise":  # cases that are not within the limits are never the best
                values = np.where(is_beyond | is_open, np.nan, values)
            else:
                values = np.where(np.isnan(values) & is_beyond, -np.inf, values)
        sign = -1.0 if self.is_smallest_worst else 1.0
        candidate_numbers = np.argmax(np.where(np.isnan(values), -np.inf, sign * values), axis=0)
        return np.take_along_axis(values, candidate_numbers[None], axis=0)[0], candidate_numbers

    def severity(self, values: np.ndarray, columns: Mapping[str, np.ndarray]) -> np.ndarray:
        """Return numbers that increase from the best case to the worst; null gives -inf, for a start-up inf.

        values : (n,) of `worst_values`; columns : (n,) each; without a margin the largest excess over a limit is worst
        """
        value_of_null = np.inf if self.question == "start-up" else -np.inf
        severity = np.where(np.isnan(values), value_of_null, -values if self.is_smallest_worst else values)
        is_beyond = np.isneginf(values)
        if not self.limits or not is_beyond.any():
            return severity
        needed = {name for limit in self.limits for name in limit.required_columns}
        numbers = {name: np.asarray(columns[name], float) for name in needed}
        excess = np.zeros(len(values))
        for limit in self.limits:
            beyond = np.nan_to_num(limit.excess(numbers), nan=np.inf)
            excess = np.where(limit.is_exceeded(numbers), np.maximum(excess, beyond), excess)
        share = np.divide(excess, 1.0 + excess, out=np.ones(len(values)), where=np.isfinite(excess))
        return np.where(is_beyond, np.finfo(float).max * (0.5 + 0.5 * share), severity)


def ranking_of(layout: Layout, limits: Iterable[Limit], grid: Mapping[str, Any] | None = None) -> CaseRanking:
    """Return the ranking of the cases of a run with this layout and these limits.

    grid : as in run.json; only the sections that choose cases matter

    The cases of a search are ranked by their margin to the limits, those of `optimise` by the first
    objective, best first.  The cases of `identify` are not ranked.
    """
    search = next((name for name in SEARCHES if (grid or {}).get(name)), "")
    column_names = {column.name for column in layout.columns}
    if not search and (life_column := f"{layout.life}_life_hours") in column_names:
        return CaseRanking(
            "life", "Shortest life", ("life",), _SMALLEST_IS_WORST, (Candidate(layout.life, (life_column,)),)
        )
    limits = tuple(limits)
    limited_columns = tuple(dict.fromkeys(limit.column for limit in limits))
    if search == "optimise":
        # Ranking by the objectives of `optimise`
        objectives_of_sense = {sense: (grid or {})["optimise"].get(sense) or [] for sense in SENSES}
        objectives = [
            name for names in objectives_of_sense.values() for name in ([names] if isinstance(names, str) else names)
        ]
        names = (*objectives, *((MARGIN_COLUMN,) if limited_columns else ()))
        headings = tuple(column_label(layout, name) for name in names)
        return CaseRanking(
            "optimise", "Best cases", headings, bool(objectives_of_sense["minimise"]), (Candidate("", names),)
        )
    if search == "identify":
        return CaseRanking("identify", "", (), _LARGEST_IS_WORST, ())
    if limited_columns:
        names = (MARGIN_COLUMN, *dict.fromkeys((*limited_columns, *((grid or {}).get("figures") or {}))))
        headings = tuple(column_label(layout, name) for name in names)
        candidates = (Candidate("", names),)
        return CaseRanking(search or "limits", "Smallest margin", headings, _SMALLEST_IS_WORST, candidates, limits)
    has_motor = bool(((grid or {}).get("drive") or {}).get("motor"))
    is_recorded = ((grid or {}).get("simulate") or {}).get("discard") == 0.0  # from the start on
    if {START_UP, MAX_SPEED} <= column_names and has_motor and is_recorded:
        label_by_name = {
            START_UP: "start-up time",
            MAX_SPEED: "highest speed",
            SPEED_AFTER_START: "lowest speed after the start",
        }
        names = tuple(name for name in label_by_name if name in column_names)
        labels = tuple(label_by_name[name] for name in names)
        return CaseRanking("start-up", "Slowest start-up", labels, _LARGEST_IS_WORST, (Candidate("", names),))
    return _content_ranking(layout)


def _content_ranking(layout: Layout) -> CaseRanking:
    """Return the ranking by the first question for which the layout has figures."""
    unit_of = {column.name: column.unit for column in layout.columns}
    joints = [joint.name for joint in layout.joints]
    for question, table_title, is_smallest_worst, headings_of_figures in _CONTENT_FIGURES:
        columns = layout.comparable(f"{name}_{next(iter(headings_of_figures))}" for name in joints)
        joints_with_figures = [name for name in joints if f"{name}_{next(iter(headings_of_figures))}" in columns]
        common_figures = {
            figure: heading
            for figure, heading in headings_of_figures.items()
            if all(f"{name}_{figure}" in unit_of for name in joints_with_figures)
        }
        if joints_with_figures:
            candidates = tuple(
                Candidate(name, tuple(f"{name}_{figure}" for figure in common_figures)) for name in joints_with_figures
            )
            title = table_title if unit_of[columns[0]] != TORQUE_UNIT else table_title.replace("normal force", "torque")
            return CaseRanking(question, title, tuple(common_figures.values()), is_smallest_worst, candidates)
    return CaseRanking("force", "", (), _LARGEST_IS_WORST, ())


_FILM_FIGURES = {"film_thickness_min": "least film", "dry_load_share": "dry load share", "film_loss": "loss"}
_FORCE_FIGURES = {"force_peak": "force peak", "force_peak_ratio": "load over ideal"}
_CONTENT_FIGURES = (
    ("film", "Thinnest film", _SMALLEST_IS_WORST, _FILM_FIGURES),
    ("force", "Largest normal force", _LARGEST_IS_WORST, _FORCE_FIGURES),
)


# The finished cases of a run and the display units of their columns.

UNIT_QUANTILE = 0.95  # the display unit suits this quantile of the values, so that a single peak does not decide it
DISPLAY_RANGE = (1e-3, 1e5)  # numbers outside this range have a unit of their own
TYPICAL_VELOCITY = 1e-3  # m/s, of vibration: in mm/s, as the zones of ISO 20816


class FinishedCases(NamedTuple):
    """The finished cases of a run, as numbers."""

    record: Mapping[str, Any]  # run.json
    layout: Layout
    varied_paths: tuple[str, ...]
    values_of: Callable[[str], np.ndarray]  # values (n,) of a column or a path; SI, NaN for null

    def __len__(self) -> int:
        return len(self.values_of("case_id"))

    def has_values(self, column_name: str) -> bool:
        """Return whether any case has a figure."""
        if not any(known.name == column_name for known in self.layout.columns):
            return False
        return bool(np.isfinite(self.values_of(column_name).astype(float)).any())

    def number(self, path: str) -> np.ndarray | None:
        """Return a number of the grid in each case (n,), whether it varies or not; None if it is not a number."""
        if path in self.varied_paths:
            return self.values_of(path).astype(float)
        value = value_at(self.record, path)
        return np.full(len(self), value) if isinstance(value, float) else None


def column_scale(column_name: str, unit: str, column_values: np.ndarray) -> wording.Scale:
    """Return the display unit of a column: it suits the 0.95 quantile of the values, for film thicknesses the median.

    column_values : (n,) SI, the values of the column
    """
    if column_name in (MAX_SPEED, SPEED_AFTER_START):
        return wording.scale(unit, 0.0, speed=True)
    if column_name.endswith("velocity_rms"):
        return wording.scale(unit, TYPICAL_VELOCITY)
    magnitudes = np.abs(column_values[np.isfinite(column_values)])
    magnitudes = magnitudes[magnitudes > 0.0]
    quantile = 0.5 if column_name.endswith("film_thickness_min") else UNIT_QUANTILE  # np.quantile takes 9 ms to load
    typical = np.interp(quantile, np.linspace(0.0, 1.0, magnitudes.size), np.sort(magnitudes)) if magnitudes.size else 0
    return wording.scale(unit, float(typical))


def column_texts(column_name: str, unit: str, column_values: np.ndarray, values: Sequence[float]) -> list[str]:
    """Return values of a column as number and unit: in the unit of the column, or in their own if it does not suit."""
    if unit == "K" and column_name.endswith("temperature"):
        return [wording.temperature_scale().text(value) for value in values]
    scale = column_scale(column_name, unit, np.asarray(column_values, float))
    displayed_magnitudes = [abs(value) / scale.factor for value in values if value and np.isfinite(value)]
    if displayed_magnitudes and not (
        DISPLAY_RANGE[0] <= min(displayed_magnitudes) and max(displayed_magnitudes) < DISPLAY_RANGE[1]
    ):
        return wording.texts_in_common_unit(values, unit)
    return [scale.text(value) for value in values]


# How long the wear rate of the window is valid.


def clearance_hours_text(cases: FinishedCases, joint: JointLayout, index: int, depth: float) -> str:
    """Return the hours after which the wear of a case equals its clearance; '' unless it does within 1000 hours.

    depth : m in 1000 hours
    """
    clearances = cases.number(f"joints.{wording.joint_name(joint.name)}.clearance")
    if clearances is None or not depth > clearances[index] > 0.0:
        return ""
    return f"{wording.number_text(1000.0 * float(clearances[index]) / depth, 2)} h"
