"""A run prepared for reading: its axes in units for people, its finished and failed cases, its joints, its answer."""

import dataclasses
import functools
import shutil
import tempfile
import weakref
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

import numpy as np

from .. import grid, simulation, store
from .. import grid as grids
from ..answers.questions import LawResult, law_results
from ..answers.ranking import (
    MAX_SPEED,
    SPEED_AFTER_START,
    START_UP,
    Candidate,
    CaseRanking,
    FinishedCases,
    column_scale,
    column_texts,
    ranking_of,
)
from ..answers.verdict import EXCEEDED_COLUMN, UNDECIDED_COLUMN, Limit, limits_and_figures_of
from ..answers.words import Words
from ..contracts.case import Case, value_at
from ..contracts.case import Joint as CaseJoint
from ..contracts.catalogue import Catalogue, Figure, figure, shown
from ..contracts.layout import JointLayout
from ..language import phases, wording
from ..language.errors import DirectoryError, InputError
from ..language.wording import is_missing
from ..searches import base_laws
from ..store import BlockedRun, SampledRun, StoredRun, answer_of
from .axis import (
    Axis,
    LeadingFigure,
    Rows,
    axes_of,
    dependent_values,
    index_on_axis,
    leading_figure,
    tried_paths,
)

# A run prepared for reading: its axes in units for people, its finished and failed cases, its joints.

#: Sections of run.json that define a case.
CASE_SECTIONS = ("laws", "define", "mechanism", "drive", "loads", "life", "joints", "simulate", "save", "vibration")
MAX_NAMED_AXES = 4  # swept axes above which a sentence on a case leaves out the values that most cases share
VARYING_SECTIONS = ("sweep", "zip", "cases", "sample")  # and the sections that vary them
#: Figures of a joint computed here, see COMPUTED_FIGURES.
P99_OVER_IDEAL = "p99_over_ideal"
WEAR_PER_1000_HOURS = "wear_depth_1000_hours"
WEAR_PER_MILLION_STROKES = "wear_depth_million_strokes"


class Joint(NamedTuple):
    """One clearance joint as it is named in columns, in paths and in words."""

    name: str  # 'rod_slider'
    title: str  # 'rod-slider'
    layout: JointLayout

    @property
    def wears(self) -> bool:
        """Return whether its wear is computed."""
        return bool(self.layout.wear_bins)

    def column(self, figure: str) -> str:
        """Return the summary column of a figure of this joint."""
        return f"{self.name}_{figure}"


class Study(NamedTuple):
    """A run prepared for reading.

    `cases` has the finished cases, `failed` the others. `base` is the resolved case in SI before the sweep's values.
    """

    run: StoredRun
    axes: tuple[Axis, ...]
    joints: tuple[Joint, ...]
    mechanism: str
    cases: Rows
    failed: Rows
    units: dict[str, str]  # SI, by column of the summary and by dotted path of the grid
    base: dict
    shows_median: bool = False  # maps show the median over the axes that they leave out, not the worst
    defined: grid.Definitions = grid.NO_DEFINITIONS  # numbers that follow from swept names
    law_checks: tuple[LawResult, ...] = ()  # the deciding case under other laws, which `cases` has not

    @property
    def lead(self) -> LeadingFigure:
        """Return the leading figure by the question of the grid."""
        return leading_figure(self.run.layout, self.limits, self.has, self.run.grid)

    @property
    def is_driven(self) -> bool:
        """Return whether a drive keeps the mechanism moving: forces then have quantiles, and onsets a rate."""
        return "drive" in self.base

    @property
    def is_start_up(self) -> bool:
        """Return whether a motor starts the mechanism and the start is recorded: there is no steady state."""
        is_start = bool(self.column("crank_speed_min")) and value_at(self.base, "simulate.discard") == 0.0
        return is_start and (self.turn == "revolution" or "motor" in self.base["drive"])

    @property
    def turn(self) -> str:
        """Return what the length of a run is measured in: 'revolution', 'cycle' or 'run', which is one whole."""
        simulate = self.base.get("simulate", {})
        return "cycle" if "period" in simulate else "run" if "time" in simulate else "revolution"

    @property
    def is_over_time(self) -> bool:
        """Return whether histories are drawn over time: of a start-up, or where the length of a run is a time."""
        return self.is_start_up or self.turn != "revolution"

    @property
    def limits(self) -> tuple[Limit, ...]:
        """Return the limits of the grid."""
        return limits_and_figures_of(self.run.grid).limits

    def joint(self, name: str) -> Joint:
        """Return the joint with a name, as in columns."""
        return next(joint for joint in self.joints if joint.name == name)

    def swept(self) -> tuple[Axis, ...]:
        """Return the axes that have more than one value."""
        return tuple(axis for axis in self.axes if len(axis.values) > 1)

    def levels(self) -> tuple[Axis, ...]:
        """Return the axes whose values are few and shared by many cases, so that cases can be compared."""
        return tuple(axis for axis in self.swept() if not axis.is_scattered)

    @property
    def label_columns(self) -> list[str]:
        """Return the columns of texts that ride along with the table of cases."""
        return [name for name in self.run.grid.get("case_labels", []) if name in self.cases]

    def setting(self, case_id: str, omitted_axis: Axis | None = None) -> str:
        """Return the swept values of a case in words, except those of `omitted_axis`; '' if nothing is swept.

        If there are more than MAX_NAMED_AXES axes, values that most cases share are left out.
        """
        axis_values = [(axis, self._value_of(case_id, axis.path)) for axis in self.swept() if axis is not omitted_axis]
        used_values = [(axis, value) for axis, value in axis_values if not is_missing(value)]
        distinctive = used_values
        if len(used_values) > MAX_NAMED_AXES:
            distinctive = [(axis, value) for axis, value in used_values if value != self._most_common_value(axis)]
        named = wording.of_joints((axis.name, axis.text(value)) for axis, value in distinctive)
        value_texts = [f"{name} {text}{joints}" for name, joints, text in named]
        rows = self.failed if self.cases.row_of(case_id) < 0 else self.cases
        value_texts = [*(f"{name} {rows.at(case_id, name)}" for name in self.label_columns), *value_texts]
        note = ["all other values as in most cases"] if len(distinctive) < len(used_values) else []
        return ", ".join([*value_texts, *note])

    def value(self, case_id: str, path: str) -> float | str | None:
        """Return the value (SI) of a case at a dotted path, swept or not, or None if it has none."""
        if any(axis.path == path for axis in self.axes):
            value = self._value_of(case_id, path)
            return None if is_missing(value) else value
        if path in self.defined.dependents:
            names = {f"define.{name}" for name in self.defined.varied_names}
            return self.defined.values_at({name: self._value_of(case_id, name) for name in names})[path]
        return value_at(self.base, path)

    def radial_clearance(self, case_id: str, joint: Joint) -> float | None:
        """Return the radius (m) in which the journal of a joint is free, half the clearance of a rolling bearing.

        None if the case has no such number, or a bearing has a preload.
        """
        clearance = self.value(case_id, f"joints.{joint.title}.clearance")
        diametral = joint.layout.is_rolling
        if diametral and not isinstance(clearance, float):  # it follows from the name of the bearing, which varies
            clearance = 2.0 * joint_of(resolve_cases(self, [case_id])[0], joint).clearance
        if clearance is None or isinstance(clearance, str):
            return None
        return None if diametral and clearance <= 0.0 else (0.5 if diametral else 1.0) * float(clearance)

    def most_loaded_joint(self) -> Joint:
        """Return the joint with the worst leading figure of all finished cases; the output in place of joints."""
        lead, output = self.lead, self.run.layout.output
        if not self.joints:
            return Joint(output, output, JointLayout(output))

        columns = [joint.column(lead.figure) for joint in self.joints]
        sign, worst = (-1.0, self.cases.smallest) if lead.smallest else (1.0, self.cases.largest)
        alike = self.run.layout.comparable(column for column in columns if self.has(column))
        severities = [sign * worst(column) if column in alike else -np.inf for column in columns]
        return self.joints[int(np.argmax(severities))]

    @property
    def leading_joints(self) -> tuple[Joint, ...]:
        """Return the joints with clearance, or the output in place of them, see `most_loaded_joint`."""
        return self.joints or (self.most_loaded_joint(),)

    def leading_values(self, channels: Mapping) -> np.ndarray:
        """Return the quantity whose largest value decides what is shown of a case: a force, or without joints another.

        channels : time histories by name
        """
        name = f"joints/{self.most_loaded_joint().name}/force_normal"
        if name not in channels:
            yielding = ("/deflection", "/extension", "/mount_x")
            name = next((other for other in channels if other.endswith(yielding)), "crank_angle")
        return np.abs(np.asarray(channels[name], float))

    def worst(self, joint: Joint) -> str:
        """Return the case with the worst leading figure of a joint, or the first one if none has this figure."""
        return self.cases.worst_case(joint.column(self.lead.figure), smallest=self.lead.smallest)

    def joint_text(self, joint: Joint, template: str) -> str:
        """Return `template`, such as ' in joint {}', filled with the name of a joint; '' if there is only one joint."""
        return template.format(joint.title) if len(self.joints) > 1 else ""

    def column(self, figure: str) -> str:
        """Return the summary column of a figure of the mechanism, or '' if the run has no such column."""
        columns = (column.name for column in self.run.layout.columns if column.figure == figure and not column.joint)
        return next(columns, "")

    def indices_on(self, axis: Axis) -> np.ndarray:
        """Return the index of the value of every finished case on an axis; -1: none."""
        return self.cases.cached(("places", axis.path), lambda: index_on_axis(axis, self.cases[axis.path]))

    def unit(self, name: str) -> str:
        """Return the SI unit of a column or a dotted path, or '1' if it has none."""
        return self.units.get(name, "1")

    def scale(self, column: str) -> wording.Scale:
        """Return the scale that suits a column of the finished cases."""
        return column_scale(column, self.unit(column), self.cases[column])

    def text(self, case_id: str, column: str) -> str:
        """Return one figure of one case with its unit."""
        return self.texts((case_id, column))[0]

    def texts(self, *figures: tuple[str, str]) -> list[str]:
        """Return figures (case_id, column) of one quantity for one sentence, all in the unit of the first column."""
        column = figures[0][1]
        known = self.cases[column]
        return column_texts(column, self.unit(column), known, [self.cases.at(*figure) for figure in figures])

    def has(self, column: str) -> bool:
        """Return whether any finished case has this figure."""
        return not np.isnan(self.cases.largest(column))

    def _most_common_value(self, axis: Axis) -> float | str | None:
        """Return the value of an axis that more than half of the finished cases have, or None."""
        if axis.is_scattered or self.cases.empty:
            return None
        counts = np.bincount(self.indices_on(axis) + 1, minlength=2)[1:]
        return axis.values[int(counts.argmax())] if 2 * counts.max() > len(self.cases) else None

    def _value_of(self, case_id: str, path: str) -> float | str:
        return (self.failed if self.cases.row_of(case_id) < 0 else self.cases).at(case_id, path)


def prepare(run: StoredRun, *, shows_median: bool = False) -> Study:
    """Return a run, as the store opens it, prepared for reading; `shows_median` as in Study."""
    if isinstance(run, BlockedRun):
        run = SampledRun(run)
    layout, record = run.layout, run.grid
    units = grid.key_units(record, simulation.catalogue()) | run.units
    base = {key: record[key] for key in CASE_SECTIONS if key in record}
    tried = {path: run.column(path).tolist() for path in tried_paths(record)}
    tried_values = {path: tuple(sorted({each for each in tried[path] if not is_missing(each)})) for path in tried}
    axes = axes_of(record, tried_values, units, len(layout.joints))
    joints = tuple(Joint(joint.name, wording.joint_name(joint.name), joint) for joint in layout.joints)
    is_finished = np.concatenate([np.array(block["status"] == "ok", bool) for block in run.blocks(["status"])])
    is_grid_case = _is_grid_case(run)
    text_columns = {
        *record.get("case_labels", []),
        "status",
        "message",
        EXCEEDED_COLUMN,
        UNDECIDED_COLUMN,
        *(axis.path for axis in axes if not axis.is_numeric),
        *(column.name for column in run.layout.columns if column.kind == "text"),
    }
    derived = {
        joint.column(figure.name): (figure.unit, functools.partial(compute, joint))
        for joint in joints
        for figure, needed, compute in COMPUTED_FIGURES
        if joint.column(needed) in run.columns and (joint.wears or "wear" not in figure.needs)
        if "drive" in base or "turns" not in figure.needs
    }
    units |= {column: unit for column, (unit, _) in derived.items()}
    definitions = grid.definitions_of_resolved(record)
    derived |= {
        path: (units.get(path, "1"), functools.partial(dependent_values, definitions, path))
        for path in definitions.dependents
    }
    computed = {column: functools.partial(compute, base=base) for column, (_, compute) in derived.items()}
    cases = Rows(run, run.column("case_id"), is_finished & is_grid_case, text_columns, computed)
    failed = Rows(run, run.column("case_id"), ~is_finished & is_grid_case, text_columns)
    checks: tuple[LawResult, ...] = ()
    if not is_grid_case.all():
        grid_laws = base_laws(run.grid)
        ranking = ranking_of(layout, limits_and_figures_of(run.grid).limits, run.grid)
        names, checking = ("case_id", *grid_laws, *ranking.columns), is_finished & ~is_grid_case
        table = {name: run.column(name)[checking] for name in names}
        checks = tuple(law_results(table, grid_laws, ranking))
    return Study(run, axes, joints, layout.mechanism, cases, failed, units, base, shows_median, definitions, checks)


def _is_grid_case(run: StoredRun | SampledRun) -> np.ndarray:
    """Return a mask of the cases that belong to the grid and do not check a law."""
    is_grid_case = np.ones(len(run.column("case_id")), bool)
    for path, law in base_laws(run.grid).items():
        values = run.column(path)
        is_grid_case &= (values == law) | [value is None for value in values.tolist()]
    return is_grid_case


def _p99_over_ideal(joint: Joint, cases: Rows, base: Mapping) -> np.ndarray:
    """Return the ratio of a joint's force p99 to the largest reaction of the same joint without clearance."""
    ideal = cases[joint.column("force_peak_ideal")]
    return cases[joint.column("force_p99")] / np.where(ideal > 0.0, ideal, np.nan)


class ComputedFigure(NamedTuple):
    """A figure of a joint that is computed of columns of the summary."""

    figure: Figure
    needed: str  # the figure without which there is none
    compute: Callable[..., np.ndarray]  # (joint, cases, base) -> (cases,) SI


COMPUTED_FIGURES = (
    ComputedFigure(
        figure(
            f"{P99_OVER_IDEAL} [1]: force p99 divided by the force peak without clearance",
            tables=shown("p99 / ideal", forces=5, effects=3),
        ),
        "force_peak_ideal",
        _p99_over_ideal,
    ),
    ComputedFigure(
        figure(
            f"{WEAR_PER_1000_HOURS} [m]: largest wear depth after 1000 hours at the wear rate of the window",
            needs=("wear",),
            tables=shown("depth per 1000 h", wear=51),
        ),
        "wear_rate_max",
        lambda joint, cases, base: 3.6e6 * cases[joint.column("wear_rate_max")],
    ),
    ComputedFigure(
        figure(
            f"{WEAR_PER_MILLION_STROKES} [m]: largest wear depth after a million crank revolutions at the wear rate of "
            "the window",
            needs=("wear", "turns"),
            tables=shown("depth per 10⁶ strokes", wear=52),
        ),
        "wear_rate_max",
        lambda joint, cases, base: 1e6 * cases[joint.column("wear_depth_max")] / recorded_revolutions(cases, base)[1],
    ),
)


def recorded_revolutions(cases: Rows, base: Mapping) -> tuple[np.ndarray, np.ndarray]:
    """Return the number of revolutions before and in the recorded window of each finished case; NaN if unknown."""
    length = "simulate.cycles" if value_at(base, "simulate.period") else "simulate.revolutions"
    total, discarded = (cases.get(path, value_at(base, path)) for path in (length, "simulate.discard"))
    if (time := cases.get("simulate.time", value_at(base, "simulate.time"))) is not None:  # the window is one cycle
        before = 0.0 if discarded is None else discarded
        total, discarded = time / (time - before), before / (time - before)
    total = np.nan if total is None else total
    discarded = 2.0 * (total > 2.0) if discarded is None else discarded  # it follows from the revolutions, which vary
    discarded = np.broadcast_to(np.asarray(cases.get("window_from", discarded), float), len(cases))
    recorded = cases.get("revolutions_run", total) - discarded
    return discarded, np.where(recorded > 0.0, recorded, np.nan)


def joint_of(case: Case, joint: Joint) -> CaseJoint:
    """Return the joint of a case that corresponds to a joint of the columns."""
    return next(section for section in case.joints if section.column == joint.name)


def joint_with_laws(case: Case, joint: Joint) -> CaseJoint:
    """Return `joint_of` if its laws are known here; raise InputError if they are of one's own and have not run."""
    section = joint_of(case, joint)
    if not simulation.has_laws(section):
        raise InputError(f"the laws of joint {joint.title} are of a file that a report does not run")
    return section


def resolve_cases(study: Study, case_ids: Iterable[str]) -> list[Case]:
    """Return cases of a run in SI with the keys that they use.  Raises InputError if a law is unknown."""
    record = study.run.grid
    sections = {key: record[key] for key in (*CASE_SECTIONS, *VARYING_SECTIONS) if key in record}
    for path in tried_paths(record):  # an axis like the others, of what was tried
        tried = next(axis.values for axis in study.axes if axis.path == path)
        end_values = tried if isinstance(tried[0], str) else dict.fromkeys((tried[0], tried[-1]))
        sections["sweep"] = sections.get("sweep", {}) | {path: list(end_values)}
    loaded = study.cases.cached(("resolved",), lambda: grid.load(sections, simulation.catalogue()))
    return [loaded.case_at({axis.path: study.value(case_id, axis.path) for axis in study.axes}) for case_id in case_ids]


Known = TypeVar("Known")


def known(compute: Callable[[], Known]) -> Known | None:
    """Return a result that needs the mechanism and the laws of a case, or None where these are not known here.

    They are those of another version, or of a law file that a report does not run.
    """
    try:
        return compute()
    except InputError:
        return None


def indices_by_value(value_indices: np.ndarray, count: int) -> list[np.ndarray]:
    """Return the ascending indices of the cases with each of `count` values; value_indices : (cases,), -1 for none."""
    order = np.argsort(value_indices, kind="stable")
    return np.split(order, np.searchsorted(value_indices[order], np.arange(count + 1)))[1:-1]


def reduce_over_other_axes(
    study: Study, values: np.ndarray, axes: tuple[Axis, Axis | None], reduce: Callable[[np.ndarray], float]
) -> np.ndarray:
    """Return the `values` of the finished cases, reduced to one number for each cell.

    The shape is (values of the second axis, values of the first), one row without a second axis; cells without a value
    are NaN.
    """
    cells = [reduce(values[cases]) if len(cases) else np.nan for cases in cases_by_cell(study, values, axes)]
    return np.array(cells, float).reshape(-1, len(axes[0].values))


def cases_by_cell(study: Study, values: np.ndarray, axes: tuple[Axis, Axis | None]) -> list[np.ndarray]:
    """Return the indices of the finished cases with a value for each cell; the first axis varies fastest."""
    x_axis, y_axis = axes
    column = study.indices_on(x_axis)
    row, rows = (study.indices_on(y_axis), len(y_axis.values)) if y_axis else (np.zeros_like(column), 1)
    is_known = np.isfinite(values) & (row >= 0) & (column >= 0)
    cell = np.where(is_known, row * len(x_axis.values) + column, -1)
    return indices_by_value(cell, rows * len(x_axis.values))


#: Function that reduces the cases of a cell to one number -> its name.
REDUCTION_NAMES: dict[Callable[[np.ndarray], float], str] = {np.max: "Largest", np.min: "Smallest", np.median: "Median"}


# The answer of a study, the same value as in answer.json, and its words.


def answer_of_study(study: Study) -> Mapping[str, Any]:
    """Return the answer of the run of a study."""
    answer: Mapping[str, Any] = study.cases.cached(("answer",), lambda: answer_of(study.run))
    return answer


def words_of(study: Study) -> Words:
    """Return the words of the run of a study."""
    return Words(study.run.grid, study.run.layout, finished_cases(study).values_of)


def finished_cases(study: Study) -> FinishedCases:
    """Return the finished cases of a study as the room of answers reads them."""
    paths, cases = tuple(axis.path for axis in study.swept()), study.cases
    return FinishedCases(
        study.run.grid, study.run.layout, paths, lambda name: cases.index if name == "case_id" else cases[name]
    )


# The worst case of a run with respect to its grid's question, as in the last lines of the run.


def case_ranking_of(study: Study) -> CaseRanking:
    """Return the ranking of the cases of a study."""
    return ranking_of(study.run.layout, study.limits, study.run.grid)


def worst_case(study: Study) -> tuple[str, Candidate] | None:
    """Return the worst case and the columns to show of it, or None if all are null."""
    ranking, cases = case_ranking_of(study), study.cases
    if cases.empty or not ranking.candidates or any(name not in cases for name in ranking.columns):
        return None
    columns = {name: cases[name] for name in ranking.columns}
    values, candidate_indices = ranking.worst_values(columns)
    if np.isnan(values).all():
        return None
    severity = ranking.severity(values, columns)
    row = int(np.flatnonzero(severity == severity.max())[-1])  # of equal ones the last, as in the last lines of the run
    return cases.index[row], ranking.candidates[int(candidate_indices[row])]


# Selects comparable figures: it leaves out starts that ended before the motor reached its speed.

EXCLUDED_STARTS_NOTE = " Starts that were cut off before the motor's speed are left out."


def comparable_values(study: Study, column: str) -> np.ndarray:
    """Return a figure of the finished cases (n,) in SI, NaN for null and for starts that were cut off."""
    values = study.cases[column]
    if not excludes_cut_off_starts(study, column):
        return values
    finished = np.where(_is_cut_off(study), np.nan, values)
    return finished if np.isfinite(finished).any() else values


def excludes_cut_off_starts(study: Study, column: str) -> bool:
    """Return whether a figure leaves out starts that were cut off."""
    return column not in (START_UP, MAX_SPEED, SPEED_AFTER_START) and bool(_is_cut_off(study).any())


def _is_cut_off(study: Study) -> np.ndarray:
    """Return which starts did not reach the motor's speed; none if all or nothing starts."""
    count = len(study.cases)
    if case_ranking_of(study).question != "start-up" or not study.has(START_UP):
        return np.zeros(count, bool)
    is_cut_off: np.ndarray = np.isnan(study.cases[START_UP])
    return is_cut_off


# Opens an unfinished run: its finished cases are assembled as if it had ended with them.

Run = TypeVar("Run", bound=store.StoredRun)


def open_partial(
    directory: Path, open_run: Callable[[Path, Path], Run], catalogue: Callable[[], Catalogue] = simulation.catalogue
) -> Run:
    """Return the result of `open_run` for a directory and a place where its finished cases are assembled.

    Raise DirectoryError without a finished case.
    """
    folder = Path(tempfile.mkdtemp(prefix="clearsweep-"))
    try:
        with phases.phase("assembling the finished cases"):
            _assemble(directory, folder / "run", catalogue())
        run = open_run(directory, folder / "run")
    except BaseException:
        shutil.rmtree(folder, ignore_errors=True)
        raise
    weakref.finalize(run, shutil.rmtree, folder, ignore_errors=True)
    return run


def _assemble(directory: Path, target: Path, catalogue: Catalogue) -> None:
    """Write the run of the cases finished so far in a directory to `target`."""
    record, source = store.read_record(directory), store.RunDirectory(directory)
    source.expect(store.ResultSchema.of_record(record))
    source.load_batches(contents=True)
    if not source.batches:
        raise DirectoryError(f"{directory}: no case of its run is finished yet; `status` prints its progress")
    grid = grids.load(store.keys_so_far(record, source), catalogue)
    store.check_version(directory, record, grid)
    grid = dataclasses.replace(grid, **grids.as_written(record))
    store.gather(source, grid, np.unique(np.fromiter(grid.identities(), "u8", len(grid))), target)
