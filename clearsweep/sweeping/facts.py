"""Facts about the cases of a run, collected some rows at a time, for its last lines."""

import functools
import math
import operator
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np

from ..answers import validity
from ..answers.questions import largest_expected_peak, required_columns
from ..answers.ranking import Candidate, CaseRanking, ranking_of
from ..answers.verdict import EXCEEDED_COLUMN, MARGIN_COLUMN, UNDECIDED_COLUMN, Limit, limits_and_figures_of, units_of
from ..answers.words import (
    FIELD_BY_COLUMN,
    MIN_DIGITS,
    case_margin_text,
    grid_text,
    hours_text,
    interval_text,
    life_criterion_text,
    number_of_joints,
    read_lifetime,
    spread_text,
    varied_text,
)
from ..contracts.layout import Layout
from ..grid import Grid, leaves
from ..language import wording
from ..searches import OwnRows
from ..store import StoredRun, sum_counts

# Values of a case in words, for the last lines of a run.


def grid_texts(values: Iterable[float], unit: str, *, speed: bool = False, typical: float | None = None) -> list[str]:
    """Return values of one quantity as `grid_text` does, all in the unit of the largest, or of a `typical` value."""
    values = list(values)
    scale = wording.scale(unit, values if typical is None else typical, speed=speed)
    name = "deg" if scale.unit == "\u00b0" else scale.unit.replace(wording.BLANK, " ")
    if not name:  # 15440, not 1.544e+04
        return [f"{float(f'{value:.4g}'):.0f}" if 1e4 <= abs(value) < 1e6 else f"{value:.4g}" for value in values]
    if name.isascii() or name.startswith("\u00b5"):
        return [f"{value / scale.factor:.4g} {name}" for value in values]
    return [f"{value:.4g} {unit}" for value in values]


def setting_text(swept: dict[str, Any], facts: dict[str, Any]) -> str:
    """Return the swept values of a case in words."""
    used = {path: value for path, value in swept.items() if value is not None}
    named = ((setting_name(path, swept, facts), value_text(path, value, facts)) for path, value in used.items())
    return ", ".join(f"{name} {text}{joints}" for name, joints, text in wording.of_joints(named))


def setting_name(path: str, paths: Iterable[str], facts: Mapping[str, Any]) -> str:
    """Return the name of a swept path, one of `paths`; clearances of fits and groups are named radial."""
    name = wording.axis_name(path, number_of_joints(paths))
    return wording.name_with_fits(name, [fit["name"] for fit in facts["fits"].get(path, ())])


def value_text(path: str, value: Any, facts: dict[str, Any]) -> str:
    """Return a swept value with its unit; its label comes first, and the fit of which it is the mean is added."""
    if value is None or isinstance(value, str):
        return value or "-"
    label = next((name for name, labelled in facts.get("labels", {}).get(path, {}).items() if labelled == value), "")
    fit = next((f" ({fit['name']})" for fit in facts["fits"].get(path, ()) if fit["mean"] == value), "")
    digits = facts.get("digits", {}).get(path, MIN_DIGITS)
    number = varied_text(path, value, facts["units"].get(path, "1"), facts["written_units"], digits) + fit
    return f"{label} ({number})" if label else number


def first_and_last_value(grid: Grid, path: str) -> list[Any]:
    """Return the value of a path, or its first and last value; [] if the first case does not use it."""
    axis = grid.axes.get(path)
    if axis is None:
        return [value for key, value in leaves(grid.written_case(0)) if key == path]
    return list(dict.fromkeys((axis[0], axis[-1])))


def assumed_texts(assumed_units: Mapping[str, Mapping[str, Any]]) -> dict[str, str]:
    """Return path -> value of each quantity written without a unit: '100 rad/s = 954.9 rpm'."""
    texts = {}
    for path, entry in assumed_units.items():
        unit = entry["unit"]
        values = f"{' to '.join(f'{value:.6g}' for value in entry['values'])} {unit}"
        readable = " to ".join(grid_text(value, unit, speed=path.endswith("speed")) for value in entry["values"])
        if unit == "rad/s":
            readable = f"{' to '.join(f'{30.0 * value / math.pi:,.5g}' for value in entry['values'])} rpm"
        texts[path] = f"{values}{'' if readable == values else f' = {readable}'}"
    return texts


_SIZES = ("m", "kg", "kg*m^2", "rad/s", "m/s")  # units of lengths, masses, inertias and speeds
_MANY = 15  # quantities in a sentence


def assumed_sentences(grid: Grid) -> list[str]:
    """Return a sentence on the sizes and speeds that a grid file writes without a unit; [] if there are none."""
    paths = [path for path in grid.assumed_units if grid.source and grid.unit(path) in _SIZES]
    bounds = {path: first_and_last_value(grid, path) for path in sorted(paths, key=lambda path: path[:5] != "drive")}
    values = {path: {"unit": grid.unit(path), "values": values} for path, values in bounds.items() if values}
    texts = assumed_texts(values)
    lines = [f"{wording.axis_name(path, number_of_joints(texts))} {text}" for path, text in texts.items()]
    more = f", and {len(lines) - _MANY} more that --dry-run lists" if len(lines) > _MANY else ""
    return [f"no unit given, SI assumed: {', '.join(lines[:_MANY])}{more}"] if lines else []


# The shortest and the longest life of a run, for its last lines.

COMPARISONS = {"shortest": operator.lt, "longest": operator.gt}


class LifeExtremes:
    """Keeps the shortest and longest life of finished cases."""

    def __init__(self, layout: Layout, section: Mapping[str, Any]):
        """Prepare for the layout of a run and the section `life` of its grid; without a life nothing is kept."""
        column_names = {column.name for column in layout.columns}
        names = {name: f"{layout.life}_{name}" for name in FIELD_BY_COLUMN} if layout.life else {}
        self.columns_by_name = {name: column for name, column in names.items() if column in column_names}
        self.joint = layout.life
        self.columns = [*self.columns_by_name.values()]
        self.until = life_criterion_text(section)
        self.unreached = self.unlimited = 0  # number of lives
        self.extremes: dict[str, dict[str, Any]] = {}  # key of COMPARISONS -> the case

    def add(self, block: Mapping[str, np.ndarray], describe: Callable[[int], dict[str, Any]]) -> None:
        """Add finished cases; describe : index in the block -> description of the case."""
        hours = block[self.columns[0]].astype(float)
        self.unreached += int(np.isnan(hours).sum())
        self.unlimited += int(np.isinf(hours).sum())
        hours[np.isinf(hours)] = np.nan
        if np.isnan(hours).all():
            return
        for index in dict.fromkeys((int(np.nanargmin(hours)), int(np.nanargmax(hours)))):
            values = {name: float(block[column].astype(float)[index]) for name, column in self.columns_by_name.items()}
            life = read_lifetime(values)
            remarks = [text for text in (interval_text(life), spread_text(life)) if text]
            entry = describe(index) | {"hours": life.hours, "text": hours_text(life), "remarks": remarks}
            for key, precedes in COMPARISONS.items():
                if key not in self.extremes or precedes(life.hours, self.extremes[key]["hours"]):
                    self.extremes[key] = entry

    def facts(self) -> dict[str, Any] | None:
        """Return both lives and the numbers of unreached and unlimited ones, for JSON, or None without lives."""
        counts = {"unreached": self.unreached, "unlimited": self.unlimited}
        facts = {"joint": self.joint, "until": self.until, **self.extremes, **counts}
        return facts if self.columns else None


# Run time of cases relative to the duration of their motion, for the last lines of a run.

SPEED, REVOLUTIONS = "drive.speed", "simulate.revolutions"  # paths of a grid
REVOLUTIONS_RUN, RUN_TIME = "revolutions_run", "run_time"  # columns


class SlowestCase:
    """Keeps the case with the longest run time relative to the duration of its motion."""

    def __init__(self, record: Mapping[str, Any], layout: Layout):
        """Prepare from run.json; lives and free cranks are left out."""
        sections = ((path, *path.split(".")) for path in (SPEED, REVOLUTIONS))
        values = {path: (record.get(section) or {}).get(key) for path, section, key in sections}
        self.fixed_values = {path: float(value) for path, value in values.items() if isinstance(value, (int, float))}
        in_rows = {REVOLUTIONS_RUN, *(path for path in values if path in record.get("sweep", record["units"]))}
        names = {column.name for column in layout.columns}
        self.revolutions = REVOLUTIONS_RUN if REVOLUTIONS_RUN in names else REVOLUTIONS
        required = {SPEED, self.revolutions}
        is_known = required <= in_rows | self.fixed_values.keys()
        self.columns = [RUN_TIME, *sorted(required & in_rows)] if is_known and not layout.life else []
        self.slowest: dict[str, Any] | None = None

    def add(self, block: Mapping[str, np.ndarray], describe: Callable[[int], dict[str, Any]]) -> None:
        """Add finished cases; describe : index in the block -> description of the case."""
        run_times = block[RUN_TIME].astype(float)
        speed, revolutions = (
            block[name].astype(float) if name in self.columns else np.full(run_times.size, self.fixed_values[name])
            for name in (SPEED, self.revolutions)
        )
        with np.errstate(divide="ignore", invalid="ignore"):
            motion_times = 2.0 * math.pi * revolutions / np.abs(speed)
            factors = motion_times / run_times
        if np.isfinite(factors).any():
            index = int(np.nanargmin(factors))
            if self.slowest is None or factors[index] < self.slowest["factor"]:
                motion, spent = float(motion_times[index]), float(run_times[index])
                self.slowest = describe(index) | {"factor": float(factors[index]), "motion": motion, "spent": spent}


# The worst cases of a run for the leading question of its grid, for the summary table.

WORST_CASES = 5


class WorstCases:
    """Keeps the worst finished cases, updated block by block."""

    def __init__(self, ranking: CaseRanking, joints: list[str], limits: tuple[Limit, ...]):
        """Prepare with the ranking, the joints whose force peaks each entry contains, and the limits of the grid."""
        self.ranking, self.joints, self.limits = ranking, joints, limits
        columns = dict.fromkeys((*ranking.columns, *(f"{joint}_force_peak" for joint in joints)))
        self.columns = [*columns] if ranking.candidates else []
        self.entries: list[dict[str, Any]] = []  # the worst first

    def add(self, block: Mapping[str, np.ndarray], describe: Callable[[int], dict[str, Any]]) -> None:
        """Add finished cases; describe : index in the block -> description of the case."""
        values, candidate_numbers = self.ranking.worst_values(block)
        severity = self.ranking.severity(values, block)
        least_severity = np.partition(severity, -WORST_CASES)[-WORST_CASES] if len(severity) > WORST_CASES else -np.inf
        worst = np.flatnonzero(severity >= least_severity)
        worst = worst[np.lexsort((block["case_id"][worst], severity[worst]))[-WORST_CASES:]]
        entries = [
            describe(index)
            | self._figures(block, index, int(candidate_numbers[index]))
            | {"severity": float(severity[index])}
            for index in worst.tolist()
        ]
        order = operator.itemgetter("severity", "case_id")
        self.entries = sorted([*self.entries, *entries], key=order, reverse=True)[:WORST_CASES]

    def facts(self) -> list[dict[str, Any]]:
        """Return the cases for JSON, which has no infinity: null is the severity of cases without the figure."""
        return [
            entry | {"severity": entry["severity"] if np.isfinite(entry["severity"]) else None}
            for entry in self.entries
        ]

    def _figures(self, block: Mapping[str, np.ndarray], index: int, number: int) -> dict[str, Any]:
        """Return the figures that rank a case, and the largest force peak with its joint; None for null."""
        candidate = self.ranking.candidates[number]
        peaks = [(float(np.nan_to_num(float(block[f"{joint}_force_peak"][index]))), joint) for joint in self.joints]
        peak, joint = max(peaks, default=(None, ""))  # a machine may have no open joint
        figures = []
        for name in candidate.columns:
            value = float(block[name][index])
            figures.append({"column": name, "value": value if np.isfinite(value) else None})
            if value == np.inf:
                figures[-1]["words"] = wording.UNLIMITED
            elif name == MARGIN_COLUMN:
                figures[-1]["words"] = case_margin_text(value, self.limits, block[EXCEEDED_COLUMN][index] or "")
        return {"joint": candidate.joint or joint, "force_peak": peak, "figures": figures}


# Counts of the cases of a run and its extreme cases; counts of blocks add up.

LISTED_FAILURES = 3  # number of cases with each status


class RunFacts:
    """Facts for the summary table of a run, collected some rows at a time."""

    def __init__(self, record: Mapping[str, Any], layout: Layout):
        """Prepare from run.json and the layout."""
        joints = [joint.name for joint in layout.joints]
        self.failures: list[dict[str, Any]] = []
        self.statuses: Counter[str] = Counter()
        self.remarks, self.limits = validity.Remarks(joints), _LimitCounts(record)
        self.lives, self.slowest_case = LifeExtremes(layout, record.get("life") or {}), SlowestCase(record, layout)
        self.ranking = ranking_of(layout, self.limits.verdict.limits, record)
        self.own = OwnRows(record, self.ranking)
        self.swept = [*record.get("case_labels", []), *record["units"]]
        self.swept = [path for path in self.swept if path not in self.own.columns]
        peaks = layout.comparable(f"{joint}_force_peak" for joint in joints)
        pressed = [name.removesuffix("_force_peak") for name in peaks]
        self.worst = WorstCases(self.ranking, pressed, self.limits.verdict.limits)
        self.expected: dict[str, Any] | None = None  # the largest force peak to expect in many revolutions
        self._joints, names = joints, {column.name for column in layout.columns}
        columns = ["status", *record.get("case_labels", []), *record["units"], *self.worst.columns]
        columns += validity.required_columns(joints, names)
        columns += [name for name in required_columns(joints) if name in names]
        columns += [*self.limits.columns, *self.lives.columns, *self.slowest_case.columns]
        self.columns = list(dict.fromkeys(columns))

    def read(self, run: StoredRun) -> None:
        """Add a run; of a run in blocks, the extreme rows of its blocks and the sums of their counts."""
        for block in run.sample_and_extremes(self.columns):
            self.add(block)
        if marks := run.marks():
            self._replace_counts([mark["counts"] for mark in marks])

    def add(self, block: dict[str, np.ndarray]) -> None:
        """Add some cases, with at least the columns of `required_columns`."""
        is_ok, is_of_grid = block["status"] == "ok", self.own.of_grid(block)
        if not is_of_grid.all():
            self.own.add({name: values[is_ok & ~is_of_grid] for name, values in block.items()})
        for index in np.flatnonzero(~is_ok).tolist():
            status = block["status"][index]
            self.statuses[status] += 1
            if sum(entry["status"] == status for entry in self.failures) < LISTED_FAILURES:
                description = _case_description(block, index, self.swept)
                self.failures.append(description | {"status": status, "message": block["message"][index]})
        if is_ok.any():
            self.statuses["ok"] += int(np.count_nonzero(is_ok))
            is_counted = is_ok & is_of_grid
            finished = block if is_counted.all() else {name: values[is_counted] for name, values in block.items()}
            self.remarks.add(finished)
            describe = functools.partial(_case_description, finished, swept=self.swept)
            for part in (self.limits, self.lives, self.slowest_case, self.worst):
                if part.columns:
                    part.add(finished, describe)
            largest = largest_expected_peak(finished, self._joints)
            if largest and (self.expected is None or largest.value > self.expected["value"]):
                index = finished["case_id"].tolist().index(largest.case_id)
                self.expected = largest._asdict() | describe(index)

    def select(self, block: dict[str, np.ndarray]) -> set[str]:
        """Add some cases; return the identities of the cases in the facts so far."""
        self.add(block)
        extremes = [*self.lives.extremes.values(), self.slowest_case.slowest, self.limits.worst]
        entries = [*self.failures, *self.worst.entries, *extremes]
        return {entry["case_id"] for entry in entries if entry} | self.remarks.case_ids()

    def counts(self) -> dict[str, Any]:
        """Return the counts for JSON."""
        return {
            "statuses": dict(self.statuses),
            "remarks": {"cases": self.remarks.cases, **self.remarks.counts},
            **{name: dict(counter) for name, counter in self.limits.counters.items()},
            "unreached": self.lives.unreached,
            "unlimited": self.lives.unlimited,
        }

    def _replace_counts(self, counts: list[dict[str, Any]]) -> None:
        """Replace the counts of the rows read by the sums over all blocks."""
        self.statuses = sum_counts(counts, "statuses")
        self.limits.counters = {name: sum_counts(counts, name) for name in self.limits.counters}
        self.remarks.replace_counts(sum_counts(counts, "remarks"))
        self.lives.unreached = sum(count["unreached"] for count in counts)
        self.lives.unlimited = sum(count["unlimited"] for count in counts)


class _LimitCounts:
    """How many cases meet the limits of a grid, as `run` reports it."""

    def __init__(self, record: Mapping[str, Any]):
        self.verdict = limits_and_figures_of(record)
        self.units = units_of(record)
        limited = {name for limit in self.verdict.limits for name in limit.required_columns}
        self.columns = [EXCEEDED_COLUMN, UNDECIDED_COLUMN, MARGIN_COLUMN, *sorted(limited)] if limited else []
        self.counters: dict[str, Counter[str]] = {
            "limits": Counter(cases=0, any=0, unknown=0),  # all cases, and those beyond, or undecided by, any limit
            "exceeded": Counter(),  # column -> number of cases beyond its limit
            "unknown": Counter(),  # column -> number of cases whose limit is undecided
            "fails": Counter(),  # index of a limit -> number of cases beyond it
            "unjudged": Counter(),  # index of a limit -> number of cases that leave it undecided
        }
        candidate = Candidate("", (MARGIN_COLUMN,))
        self.ranking = CaseRanking(
            "limits", "", (), is_smallest_worst=True, candidates=(candidate,), limits=self.verdict.limits
        )
        self.worst: dict[str, Any] | None = None  # exceeding without a margin by most, else with the smallest margin
        self._worst_key = -np.inf, ""  # severity and identity

    def add(self, block: Mapping[str, np.ndarray], describe: Callable[[int], dict[str, Any]]) -> None:
        """Add finished cases; describe : index in the block -> description of the case."""
        both = list(zip(block[EXCEEDED_COLUMN], block[UNDECIDED_COLUMN], strict=True))
        beyond, undecided = (
            sum(bool(names) for names, _ in both),
            sum(bool(open_) and not names for names, open_ in both),
        )
        self.counters["limits"].update(cases=len(both), any=beyond, unknown=undecided)
        for counter, column in (("exceeded", EXCEEDED_COLUMN), ("unknown", UNDECIDED_COLUMN)):
            self.counters[counter].update(name for names in block[column] if names for name in names.split(","))
        for index, limit in enumerate(self.verdict.limits):
            self.counters["fails"][str(index)] += int(np.count_nonzero(limit.is_exceeded(block)))
            self.counters["unjudged"][str(index)] += int(np.count_nonzero(limit.is_undecided(block)))
        severity = self.ranking.severity(self.ranking.worst_values(block)[0], block)
        index = int(np.lexsort((block["case_id"], severity))[-1])
        key = float(severity[index]), str(block["case_id"][index])
        if severity[index] > -np.inf and key > self._worst_key:
            margin, names = float(block[MARGIN_COLUMN][index]), block[EXCEEDED_COLUMN][index] or ""
            words = case_margin_text(margin, self.verdict.limits, names)
            figures = {"margin": margin if np.isfinite(margin) else None, "margin_words": words}
            self.worst, self._worst_key = describe(index) | figures, key

    def facts(self) -> dict[str, Any] | None:
        """Return the counts for JSON, or None if there are no limits."""
        if not self.columns:
            return None
        bounds: dict[str, list[str]] = {limit.column: [] for limit in self.verdict.limits}
        for limit in self.verdict.limits:
            bounds[limit.column].append(limit.bound_text(self.units.get(limit.column, "1")))
        counts, exceeded, unknown = (self.counters[name] for name in ("limits", "exceeded", "unknown"))
        each = {
            name: {"limit": ", ".join(text), "cases": exceeded[name], "unknown": unknown[name]}
            for name, text in bounds.items()
        }
        totals = {"cases": counts["cases"], "exceeding": counts["any"], "unknown": counts["unknown"]}
        return totals | {"each": each, "worst": self.worst}


def _case_description(block: dict[str, np.ndarray], index: int, swept: list[str]) -> dict[str, Any]:
    """Return the description of the case at an index of a block; None for values that it does not use."""
    values = {path: block[path][index : index + 1].tolist()[0] for path in swept}
    in_use = {path: None if isinstance(value, float) and math.isnan(value) else value for path, value in values.items()}
    return {"case_id": block["case_id"][index], "swept": in_use}
