"""Two runs compared case by case: differences of setup, shared cases, differences of figures."""

import math
from typing import NamedTuple

import numpy as np

from ... import simulation
from ...contracts.case import value_at
from ...contracts.results import TIMINGS
from ...language import wording
from ...language.errors import InputError
from ...store import StoredRun, grid_changes
from ..axis import leaves
from ..blocks.section import Facts, Gallery, Picture, Points, Section, capitalise, section
from ..blocks.table import Column, Quantity, Table, axis_columns, column_label, columns_of
from ..draw import GREY, comparison
from ..plot import Axes
from ..sections.setup import value_text
from ..study import CASE_SECTIONS, VARYING_SECTIONS, Study, answer_of_study, prepare
from .page import Page

RUN_NAMES = ("A", "B")
MOST_CHANGES = 5  # values that the first sentence lists


class Pairs(NamedTuple):
    """The cases that two runs share: the values on all axes of both runs are equal."""

    first: Study
    second: Study
    case_ids: list[tuple[str, str]]  # of A and of B; finished in both
    unpaired: tuple[int, int]  # finished cases in only one of the two


def comparison_page(first: StoredRun, second: StoredRun) -> Page:
    """Return the page that compares two runs.  Raises InputError if they have no common case."""
    pairs = pair_cases(prepare(first), prepare(second))
    runs = [pairs.first.run, pairs.second.run]
    return Page(
        name=" and ".join(dict.fromkeys(str(run.grid.get("name") or "a run") for run in runs)),
        subtitle=f"comparison of A, {runs[0].directory}, and B, {runs[1].directory}",
        axes_verb="Both vary",
        axes=[axis.name for axis in pairs.first.axes if axis in pairs.second.axes],
        sections=sections(pairs),
    )


def pair_cases(first: Study, second: Study) -> Pairs:
    """Return the finished cases of two runs with equal values on all axes of either."""
    paths = list(dict.fromkeys(axis.path for study in (first, second) for axis in study.axes))
    keyed, other_keyed = (
        zip(study.cases.index, *(_values_at(study, path) for path in paths), strict=True) for study in (first, second)
    )
    same: dict[tuple, list[str]] = {}
    for case_id, *values in other_keyed:
        same.setdefault(tuple(values), []).append(case_id)
    paired = [(case_id, other) for case_id, *values in keyed for other in same.get(tuple(values), ())]
    paired = paired if paths else paired[:1]
    if not paired:
        raise InputError(
            f"{first.run.directory} and {second.run.directory}: no finished case of one has the same values of "
            f"{', '.join(paths)} as a case of the other; compare runs that share some cases"
        )
    ids, other_ids = map(set, zip(*paired, strict=True))
    return Pairs(first, second, paired, (len(first.cases) - len(ids), len(second.cases) - len(other_ids)))


def _values_at(study: Study, path: str) -> list[float | str | None]:
    """Return the values of the finished cases at a path, swept, defined or fixed; None where there is none."""
    ids = study.cases.index
    if path in study.defined.dependents or any(axis.path == path for axis in study.axes):
        values = [study.value(case_id, path) for case_id in ids]
    else:
        value = value_at(study.base, path)
        values = [value if isinstance(value, int | float | str) else None] * len(ids)
    return [float(value) if isinstance(value, int | float) else value for value in values]


def sections(pairs: Pairs) -> list[Section]:
    """Return the sections of the page: differences of setup and figures, and the most different cases."""
    settings = _differing_settings(pairs)
    setup = Facts(
        "Differences in setup", "Differences in setup", [(path, f"A: {a}; B: {b}") for path, a, b in settings]
    )
    studies = zip((pairs.first, pairs.second), RUN_NAMES, strict=True)
    answers = [(name, answer_of_study(study)["sentences"]) for study, name in studies]
    verdict_sentences = [f"{name}: {sentences[0]}" for name, sentences in answers if sentences]
    changes = [_changed_values_sentence(settings), *verdict_sentences, *_largest_change_sentences(pairs)]
    points, tables = Points([*changes, *_comparison_sentences(pairs)]), (_figure_table(pairs), _case_table(pairs))
    same = Points(["Both runs have the same setup and differ only in their swept values."])
    return [
        *section("comparison", "Case by case", points, _pictures(pairs), *tables),
        *section("setup", "Setup", setup if setup.rows else same),
    ]


def _changed_values_sentence(settings: list[tuple[str, str, str]]) -> str:
    """Return what differs in the setup, from A to B; of many values the first are listed."""
    if not settings:
        return "Both runs have the same setup."
    more = f"; and {len(settings) - MOST_CHANGES} more" if len(settings) > MOST_CHANGES else ""
    changes = (f"{path} from {first} to {second}" for path, first, second in settings[:MOST_CHANGES])
    return f"Changed from A to B: {'; '.join(changes)}{more}."


def _largest_change_sentences(pairs: Pairs) -> list[str]:
    """Return the figure with a unit whose median factor between the runs is the largest, or [] if none changes."""
    compared = {figure.name for figure in simulation.catalogue().figures if figure.differs}
    medians = {}
    for column in pairs.first.run.layout.columns:
        if column.figure in compared and column.unit != "1" and column.name in _columns(pairs):
            ratios = _ratios(pairs, column.name)
            positive = ratios[np.isfinite(ratios) & (ratios > 0.0)]
            medians[column.name] = float(np.median(positive)) if positive.size else 1.0
    name = max(medians, key=lambda name: abs(math.log(medians[name])), default="")
    if not name or medians[name] == 1.0:
        return []
    label, factor = column_label(pairs.first, name), wording.number_text(medians[name])
    return [f"Largest change of a figure with a unit: the {label} of B is {factor} times that of A in the median case."]


def _comparison_sentences(pairs: Pairs) -> list[str]:
    """Return sentences on the number of compared cases, and of those identical to the last bit."""
    column = _leading_column(pairs)
    ratios = _ratios(pairs, column)
    equal_count = int(np.count_nonzero(ratios == 1.0))
    sentences = [
        f"{wording.count_text(len(pairs.case_ids), 'case')} finished in both runs. Of these, {equal_count} have "
        f"exactly the same {column_label(pairs.first, column)}. Cases in A alone: {pairs.unpaired[0]}; in B alone: "
        f"{pairs.unpaired[1]}."
    ]
    finite_ratios = ratios[np.isfinite(ratios)]
    if finite_ratios.size and equal_count < len(ratios):
        low, median, high = np.quantile(finite_ratios, [0.05, 0.5, 0.95])
        low, median, high = (wording.number_text(float(quantile)) for quantile in (low, median, high))
        spread = f"and {low} to {high} times in nine of ten cases"
        sentences.append(
            f"The {column_label(pairs.first, column)} of B is {median} times that of A in the median case, {spread}."
        )
    equal_figures = [
        name for name in _columns(pairs) if np.all(_ratios(pairs, name) == 1.0) and _has_values(pairs, name)
    ]
    if equal_figures and equal_count < len(ratios):
        sentences.append(
            f"Equal in every case: {wording.sentence_list([column_label(pairs.first, key) for key in equal_figures])}."
        )
    return sentences


def _has_values(pairs: Pairs, column: str) -> bool:
    """Return whether any case has a figure."""
    return bool(np.isfinite(_paired_values(pairs, column)[0]).any())


def _pictures(pairs: Pairs) -> Gallery:
    """Return pictures of the leading figure, the force peaks and the output error of B over those of A."""
    study = pairs.first
    candidates = [
        _leading_column(pairs),
        *(joint.column("force_peak") for joint in study.joints),
        study.column("error_max"),
    ]
    columns = [
        column for column in dict.fromkeys(candidates) if column in _columns(pairs) and _has_values(pairs, column)
    ]
    note = "Each point is a case that finished in both runs. On the line both values are equal."
    return Gallery(note, [_scatter_picture(pairs, name) for name in columns])


def _scatter_picture(pairs: Pairs, column: str) -> Picture:
    """Return the picture of a figure of B over the same figure of A."""
    first_values, second_values = _paired_values(pairs, column)
    scale = wording.scale(
        pairs.first.unit(column), [*first_values[np.isfinite(first_values)], *second_values[np.isfinite(second_values)]]
    )
    name = column_label(pairs.first, column)

    def paint(ax: Axes) -> None:
        comparison.draw_cloud(ax, first_values, second_values, None, (f"{name} of A", f"{name} of B"), (scale, scale))
        values = np.concatenate([first_values, second_values]) / scale.factor
        ends = [np.nanmin(values), np.nanmax(values)]
        ax.plot(ends, ends, color=GREY, linewidth=1.0, zorder=0.0)

    return Picture(
        f"{capitalise(name)} of B over A", "", f"{name} of B over that of A, {len(first_values)} cases.", paint
    )


def _figure_table(pairs: Pairs) -> Table:
    """Return the table of all common figures: B over A, and the number of different cases."""
    rows = []
    for column in _columns(pairs):
        ratios = _ratios(pairs, column)
        finite_ratios = ratios[np.isfinite(ratios)]
        if finite_ratios.size and np.any(ratios != 1.0):
            differing_fraction = float(np.mean(ratios != 1.0))
            differing_share = Quantity(differing_fraction, wording.percent_text(differing_fraction))
            quantiles, label = np.quantile(finite_ratios, [0.5, 0.05, 0.95]), column_label(pairs.first, column)
            rows.append((column, label, *quantiles, differing_share))
    columns = columns_of("column* | figure | B over A, median | 5 % | 95 % | cases that differ")
    return Table("compared_figures", "Figures of B over those of A", "", columns, rows)


def _case_table(pairs: Pairs) -> Table:
    """Return the table of cases, by the difference of the leading figure."""
    column, study = _leading_column(pairs), pairs.first
    first_values, second_values, ratios = (*_paired_values(pairs, column), _ratios(pairs, column))
    with np.errstate(all="ignore"):
        difference = np.nan_to_num(np.abs(np.log(ratios)), nan=-1.0)
    axes = study.swept()
    heads = (
        Column("case_id"),
        *axis_columns(study, axes),
        Column(f"{column_label(study, column)} of A", study.unit(column)),
        Column("of B", study.unit(column)),
        Column("B over A"),
    )
    rows = []
    for row in np.argsort(-difference, kind="stable").tolist():
        case_id = pairs.case_ids[row][0]
        values = (study.value(case_id, axis.path) for axis in axes)
        rows.append((case_id, *values, float(first_values[row]), float(second_values[row]), float(ratios[row])))
    note = "Case ids are those of A. The largest difference comes first."
    return Table("compared_cases", "Comparison of the cases", note, heads, rows)


def _differing_settings(pairs: Pairs) -> list[tuple[str, str, str]]:
    """Return the values that differ: dotted path, value in A, value in B, with units."""
    runs = []
    for study in (pairs.first, pairs.second):
        swept = {axis.path for axis in study.axes}
        setting = {path: value_text(study, path, value) for path, value in leaves(study.base) if path not in swept}
        setting |= {axis.path: f"swept, {axis.values_text()}" for axis in study.axes}
        runs.append(setting | {"model version": str(study.run.grid.get("model_version"))})
    changes = {path: tuple(run.get(path, "nothing") for run in runs) for path in {**runs[0], **runs[1]}}
    for path, values in grid_changes(pairs.first.run.grid, pairs.second.run.grid).items():
        section, _, name = path.partition(".")
        if section not in (*CASE_SECTIONS, *VARYING_SECTIONS):
            changes[path] = tuple(
                "nothing" if value is None else value_text(study, name.partition(".")[0], value)
                for study, value in zip((pairs.first, pairs.second), values, strict=True)
            )
    return [(path, first, second) for path, (first, second) in changes.items() if first != second]


def _columns(pairs: Pairs) -> list[str]:
    """Return the common figures, without timings."""
    known = {column.name for column in pairs.first.run.layout.columns if column.kind != "text"} - TIMINGS
    return [name for name in pairs.first.cases.columns if name in pairs.second.cases and name in known]


def _leading_column(pairs: Pairs) -> str:
    """Return the leading figure of the most loaded joint in A, if both have it."""
    column = pairs.first.most_loaded_joint().column(pairs.first.lead.figure)
    return column if column in pairs.second.cases else _columns(pairs)[0]


def _paired_values(pairs: Pairs, column: str) -> tuple[np.ndarray, np.ndarray]:
    """Return a figure of the paired cases in A and in B, SI."""
    first, second = (
        study.cases[column][[*map(study.cases.row_of, ids)]]
        for study, ids in zip((pairs.first, pairs.second), zip(*pairs.case_ids, strict=True), strict=True)
    )
    return first, second


def _ratios(pairs: Pairs, column: str) -> np.ndarray:
    """Return the ratio of a figure in B to that in A; 1 if both are equal, including zeros and missing values."""
    first, second = _paired_values(pairs, column)
    with np.errstate(all="ignore"):
        ratio: np.ndarray = np.where((first == second) | (np.isnan(first) & np.isnan(second)), 1.0, second / first)
    return ratio
