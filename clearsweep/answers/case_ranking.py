"""The leading question of a run: one order for verdict, cards, summary table and sorting."""

from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

import numpy as np

from ..contracts.layout import Layout
from . import labels
from .verdict import EXCEEDED, MARGIN, UNDECIDED, Limit, limits_and_figures_of

#: The questions of a grid in order of precedence.  Start-up, film and force studies are recognised by their content,
#: if there is no other question.
QUESTIONS = ("life", "seek", "optimise", "identify", "limits", "start-up", "film", "force")
SEARCHES = ("seek", "optimise", "identify")  # questions that are sections of a grid which choose cases
SENSES = ("minimise", "maximise")
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
        names |= dict.fromkeys(limit.times for limit in self.limits if limit.times)
        return (*names, EXCEEDED, UNDECIDED) if MARGIN in names else tuple(names)

    def worst_values(self, columns: Mapping[str, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
        """Return the worst value of each case over the candidates, NaN if all are null, and the candidate's index.

        columns : (n,) each, NaN for null; a case that exceeds a limit without a margin is the worst of all
        """
        values = np.array([np.asarray(columns[candidate.columns[0]], float) for candidate in self.candidates])
        if MARGIN in self.columns:
            is_beyond, is_open = (
                np.array([isinstance(names, str) and names != "" for names in np.asarray(columns[name]).tolist()], bool)
                for name in (EXCEEDED, UNDECIDED)
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
        needed = {name for limit in self.limits for name in (limit.column, limit.times) if name}
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
    if (life_column := f"{layout.life}_life_hours") in column_names:
        return CaseRanking(
            "life", "Shortest life", ("life",), _SMALLEST_IS_WORST, (Candidate(layout.life, (life_column,)),)
        )
    limits = tuple(limits)
    limited_columns = tuple(dict.fromkeys(limit.column for limit in limits))
    if search == "optimise":
        return _objective_ranking((grid or {})["optimise"], limited_columns)
    if search == "identify":
        return CaseRanking("identify", "", (), _LARGEST_IS_WORST, ())
    if limited_columns:
        names = (MARGIN, *dict.fromkeys((*limited_columns, *((grid or {}).get("figures") or {}))))
        headings = tuple(labels.column_label(layout, name) for name in names)
        candidates = (Candidate("", names),)
        return CaseRanking(search or "limits", "Smallest margin", headings, _SMALLEST_IS_WORST, candidates, limits)
    if {START_UP, MAX_SPEED} <= column_names and _is_start_up(grid or {}):
        label_by_name = {
            START_UP: "start-up time",
            MAX_SPEED: "highest speed",
            SPEED_AFTER_START: "lowest speed after the start",
        }
        names = tuple(name for name in label_by_name if name in column_names)
        return CaseRanking(
            "start-up",
            "Slowest start-up",
            tuple(label_by_name[name] for name in names),
            _LARGEST_IS_WORST,
            (Candidate("", names),),
        )
    return _content_ranking(layout, [question for question, *_ in _CONTENT_FIGURES])


def limits_of_record(record: Mapping[str, Any]) -> tuple[Limit, ...]:
    """Return the limits of a run, from its run.json."""
    return limits_and_figures_of(record).limits


def _is_start_up(grid: Mapping[str, Any]) -> bool:
    """Return whether a motor with a no-load speed starts the mechanism and the start is recorded."""
    motor = (grid.get("drive") or {}).get("motor") or {}
    return "no_load_speed" in motor and (grid.get("simulate") or {}).get("discard") == 0.0


def _content_ranking(layout: Layout, questions: list[str]) -> CaseRanking:
    """Return the ranking by the first of the questions for which the layout has figures."""
    column_names = {column.name for column in layout.columns}
    joints = [joint.name for joint in layout.joints]
    for question, table_title, is_smallest_worst, headings_of_figures in _CONTENT_FIGURES:
        if question not in questions:
            continue
        joints_with_figures = [name for name in joints if f"{name}_{next(iter(headings_of_figures))}" in column_names]
        common_figures = {
            figure: heading
            for figure, heading in headings_of_figures.items()
            if all(f"{name}_{figure}" in column_names for name in joints_with_figures)
        }
        if joints_with_figures:
            candidates = tuple(
                Candidate(name, tuple(f"{name}_{figure}" for figure in common_figures)) for name in joints_with_figures
            )
            return CaseRanking(question, table_title, tuple(common_figures.values()), is_smallest_worst, candidates)
    return CaseRanking("force", "", (), _LARGEST_IS_WORST, ())


def _objective_ranking(section: Mapping[str, Any], limited_columns: tuple[str, ...]) -> CaseRanking:
    """Return the ranking by the objectives of `optimise`."""
    objectives_of_sense = {sense: section.get(sense) or [] for sense in SENSES}
    objectives = [
        name for names in objectives_of_sense.values() for name in ([names] if isinstance(names, str) else names)
    ]
    names = (*objectives, *((MARGIN,) if limited_columns else ()))
    return CaseRanking("optimise", "Best cases", names, bool(objectives_of_sense["minimise"]), (Candidate("", names),))


_CONTENT_FIGURES: tuple[tuple[str, str, bool, dict[str, str]], ...] = (
    (
        "film",
        "Thinnest film",
        _SMALLEST_IS_WORST,
        {"film_thickness_min": "least film", "dry_load_share": "dry load share", "film_loss": "loss"},
    ),
    (
        "force",
        "Largest normal force",
        _LARGEST_IS_WORST,
        {"force_peak": "force peak", "force_peak_ratio": "load over ideal"},
    ),
)
