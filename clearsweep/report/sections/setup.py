"""The set-up of a run, its mechanism, and what its tolerances and unknowns cost."""

import re
from collections import Counter
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from ... import grid
from ...language import wording
from ...language.wording import is_missing
from ..axis import PEAK, Axis, Rows, leaves
from ..blocks.section import Block, Columns, Facts, Gallery, Note, Picture, Section, Sentences, section, without_empty
from ..blocks.table import Column, Quantity, Table, columns_of, count_cell
from ..draw import BLUE, INK, set_log_scale, set_plain_axes
from ..one_case.joints import mechanism_picture
from ..plot import Axes
from ..study import CASE_SECTIONS, Study, known, resolve_cases

# Setup of the run: swept, fixed and derived values, and the origin of the results.

MAX_LISTED_VALUES = 12  # values of an axis that are listed one by one, at most
OMITTED_KEYS = (  # in the record of a run, and shown elsewhere or not for people
    "name",
    "sweep",
    "zip",
    "cases",
    "limits",
    "layout",
    "units",
    "fits",
    "written_units",
    "keys",
    "frame",
    "derived",
    "warnings",
)
OMITTED_PATHS = ("machine.node", "merged.mark")  # the name of a machine is nobody's else; run.json has both
CHECKSUM = re.compile("^([0-9a-f]{12})[0-9a-f]{28,}$")  # the page has the first digits, run.json has all
SUMMED_COLUMNS = (("steps", "accepted steps, all cases"), ("rhs_evaluations", "evaluations, all cases"))
RESIDUAL_NOTE = (
    "The energy residual is the largest imbalance of work, energy and losses, divided by the largest kinetic energy. "
    "It shows how accurately the equations are solved, not how well they describe a machine."
)


def setup_sections(study: Study) -> list[Section]:
    """Return the section, with the values in one column and their origin in the other."""
    axis_texts = [(axis.path, axis.values_text().removeprefix("in ")) for axis in study.axes]
    values: list[Block] = [
        Facts("Swept", "Swept values", axis_texts),
        Facts("The same in every case" if study.axes else "The case", "Fixed values", _fixed_values(study)),
        Facts("Derived from these", "Derived values", _derived_values(study)),
    ]
    origin: list[Block] = [Facts("Provenance", "Provenance", _provenance(study)), Note(RESIDUAL_NOTE)]
    return [Section("setup", "Values and origin", [Columns((without_empty(values), origin))])]


def _fixed_values(study: Study) -> list[tuple[str, str]]:
    """Return the values that every case shares: dotted path, value with unit."""
    swept = {axis.path for axis in study.axes}
    fits = {path: f" ({entries[0].name})" for path, entries in grid.recorded_fits(study.run.grid).items()}
    return [
        (path, value_text(study, path, value) + fits.get(path, ""))
        for path, value in leaves(study.base)
        if path not in swept
    ]


def value_text(study: Study, path: str, value: object) -> str:
    """Return a fixed value, or each of a list, with its unit."""
    if isinstance(value, list) and len(value) > MAX_LISTED_VALUES:
        unit, extremes = study.unit(path), (min(value), max(value))
        return (
            f"{len(value)} values, "
            f"{' to '.join(wording.scale(unit, extremes).exact_text(extreme, 4) for extreme in extremes)}"
        )
    if isinstance(value, list):
        return ", ".join(value_text(study, f"{path}.{index}", item) for index, item in enumerate(value))
    if isinstance(value, bool) or not isinstance(value, int | float):
        return str(value)
    written_scale = wording.written_scale(study.run.grid.get("written_units", {}).get(path), study.unit(path))
    return (written_scale or wording.scale(study.unit(path), value, speed=path == "drive.speed")).exact_text(value)


def _derived_values(study: Study) -> list[tuple[str, str]]:
    """Return derived values, such as a stiffness from a material: dotted path, range with unit."""
    facts = []
    for path, extremes in (study.run.grid.get("derived") or {}).items():
        scale = wording.scale(extremes["unit"], (extremes["min"], extremes["max"]))
        texts = dict.fromkeys(scale.exact_text(extremes[key], 4) for key in ("min", "max"))
        facts.append((path, " to ".join(texts)))
    return facts


def _provenance(study: Study) -> list[tuple[str, str]]:
    """Return the origin of the figures: versions, machine, times, counts, energy residual."""
    record = {
        key: value for key, value in study.run.grid.items() if key not in (*CASE_SECTIONS, *OMITTED_KEYS) and value
    }
    if "sample" in record:
        record["sample"] = {key: value for key, value in record["sample"].items() if key != "drawn"}
    written = [(path, str(value)) for path, value in leaves(record) if path not in OMITTED_PATHS]
    facts = [(path.replace("_", " "), CHECKSUM.sub(r"\1...", text)) for path, text in written]
    if study.has("energy_residual"):
        median = float(np.nanmedian(study.cases["energy_residual"]))
        facts.append(("energy residual, largest", wording.number_text(study.cases.largest("energy_residual"), 2)))
        facts.append(("energy residual, median", wording.number_text(median, 2)))
    facts += [
        (name, wording.number_text(np.nansum(study.cases[column]), 4))
        for column, name in SUMMED_COLUMNS
        if study.has(column)
    ]
    if study.has("run_time"):
        facts.append(("integration time, all cases", wording.quantity_text(np.nansum(study.cases["run_time"]), "s")))
    return facts


# The mechanism of a run at its start.


def mechanism_sections(study: Study) -> list[Section]:
    """Return the section, or [] if the mechanism has no picture, or is not known here."""
    first_case = [*study.cases.index[:1], *study.failed.index[:1]][:1]
    picture = known(lambda: mechanism_picture(resolve_cases(study, first_case)[0])) if first_case else None
    return section("mechanism", "", Gallery("", [picture] if picture else []))


# Error against run time of a run that sweeps `simulate.tolerance`, from the finest of otherwise equal cases.

PATH = "simulate.tolerance"
FIGURES = ("force_peak", "force_p99", "force_rms")
COLOURS = ("#D55E00", "#0072B2", "#009E73")  # Okabe and Ito 2008
LEAST_DRAWN = 1e-16  # a difference of 0 is drawn there
TOLERANCE_NOTE = (
    "Each point is the median over the cases of one tolerance. Beyond the horizon of chaotic motion two tolerances are "
    "two samples of the same motion, and their difference does not fall any further."
)


def tolerance_sections(study: Study) -> list[Section]:
    """Return the section, or [] unless tolerances are swept and cases at several of them have finished."""
    if study.cases.empty or not study.joints or PATH not in {axis.path for axis in study.swept()}:
        return []
    joint = study.most_loaded_joint()
    columns = [joint.column(name) for name in FIGURES if study.has(joint.column(name))]
    others = [axis.path for axis in study.swept() if axis.path != PATH]
    medians = differences(study.cases, others, columns)
    if len(medians) < 2 or not columns:
        return []
    heads = [*columns_of("tolerance | run time [s]"), *(Column(f"difference of {name}") for name in columns)]
    rows = list(map(tuple, medians.tolist()))
    table = Table("tolerances", "Difference from the finest tolerance", "Medians; relative.", heads, rows)
    finest = f"The reference is the finest tolerance, {study.cases.smallest(PATH):g}, of otherwise equal cases."
    gallery = Gallery(TOLERANCE_NOTE, [_tolerance_picture(medians, columns)])
    return [Section("tolerances", "Error against run time", [Sentences([finest]), gallery, table])]


def differences(cases: Rows | Mapping[str, np.ndarray], other_paths: list[str], columns: list[str]) -> np.ndarray:
    """Return tolerance, and medians of run time (s) and of relative differences from the finest of equal cases.

    The shape is (tolerances, 2 + columns), the coarsest first; the finest tolerance has no row.

    cases : finished cases with a column `run_time`; other_paths : the swept paths besides the tolerance
    """
    tolerances = cases[PATH]
    finest, references = np.full(len(tolerances), np.nan), np.full((len(tolerances), len(columns)), np.nan)
    group_of: dict[tuple, list[int]] = {}
    for row, key in enumerate(zip(*(map(str, cases[path].tolist()) for path in other_paths), strict=True)):
        group_of.setdefault(key, []).append(row)
    values = np.stack([cases[column] for column in columns], axis=-1) if columns else references
    for rows in group_of.values() or [list(range(len(tolerances)))]:
        finest[rows] = tolerances[rows].min()
        is_finest = tolerances[rows] == finest[rows]
        references[rows] = np.fmax.reduce(values[rows][is_finest], axis=0)
    by_case = np.column_stack([tolerances, cases["run_time"], np.abs(values / references - 1.0)])
    coarser = by_case[tolerances > finest]
    levels = np.unique(coarser[:, 0])[::-1]
    medians = [np.nanmedian(coarser[coarser[:, 0] == level], axis=0) for level in levels]
    return np.array(medians).reshape(-1, by_case.shape[1])


def _tolerance_picture(medians: np.ndarray, columns: list[str]) -> Picture:
    """Return the picture of the differences over the run time, a curve per figure."""

    def paint(ax: Axes) -> None:
        for column, differences, colour in zip(columns, medians.T[2:], COLOURS, strict=False):
            errors = np.maximum(differences, LEAST_DRAWN)
            ax.plot(medians[:, 1], errors, color=colour, marker="o", markersize=4, label=column)
        ax.set_labels("run time of a case [s]", "relative difference")
        set_log_scale(ax, "x", "y")
        ax.set_legend("right")

    return Picture(
        "Error against run time", "", "Difference from the finest tolerance over run time.", paint, (5.4, 3.1)
    )


# An error budget: effects of single unknowns on the force peak, from a base case and one-at-a-time changes.

MIN_UNKNOWNS = 3  # unknowns of a budget
MAX_CASES = 2000  # cases that are looked at: a budget has few
NEGLIGIBLE_CHANGE = 0.02  # of the base: an unknown that moves a figure by less decides nothing


class Unknown(NamedTuple):
    """Axes that change together, and the cases in which they do."""

    axes: tuple[Axis, ...]
    cases: tuple[str, ...]

    @property
    def name(self) -> str:
        """Return the name of the unknown in words."""
        return " and ".join(axis.name for axis in self.axes)


class Bar(NamedTuple):
    """Effect of an unknown on a figure."""

    unknown: Unknown
    decrease: float  # of the base, at most 0
    increase: float  # at least 0
    case_of_decrease: str  # case_id; '': the base
    case_of_increase: str


def budget_sections(study: Study) -> list[Section]:
    """Return the section, or [] unless the finished cases are a base case and cases that each change one unknown."""
    if study.cases.empty or not study.joints:
        return []
    column = study.most_loaded_joint().column(PEAK.figure)
    design = one_at_a_time_design(study)
    if design is None or not study.has(column) or not study.cases.at(design[0], column) > 0.0:
        return []
    base, unknowns = design
    bars = bars_of(study, column, base, unknowns)
    blocks = Sentences(_sentences(study, column, base, bars)), Gallery("", [_budget_picture(study, bars)])
    return section("budget", "Error budget of the force peak", *blocks, _table(study, bars))


def one_at_a_time_design(study: Study) -> tuple[str, list[Unknown]] | None:
    """Return the base case and the unknowns, or None if cases differ from each other in another way."""
    axes, cases = study.swept(), study.cases
    if "sample" in study.run.grid or not MIN_UNKNOWNS <= len(axes) < len(cases) <= MAX_CASES:
        return None
    values = [cases[axis.path].tolist() for axis in axes]
    known = ([value for value in column if not is_missing(value)] for column in values)
    usual = [Counter(column).most_common(1)[0][0] for column in known]
    differs = np.array([[value != most for value in column] for column, most in zip(values, usual, strict=True)])
    base_rows = np.flatnonzero(~differs.any(axis=0))
    if len(base_rows) != 1:
        return None
    groups: dict[tuple[int, ...], list[str]] = {}
    for row in np.flatnonzero(differs.any(axis=0)):
        groups.setdefault(tuple(np.flatnonzero(differs[:, row]).tolist()), []).append(cases.index[row])
    if len(groups) < MIN_UNKNOWNS or sum(map(len, groups)) > len(set().union(*groups)):
        return None  # an axis of two groups: cases change several unknowns
    unknowns = [Unknown(tuple(axes[index] for index in changed), tuple(ids)) for changed, ids in groups.items()]
    return cases.index[base_rows[0]], unknowns


def bars_of(study: Study, column: str, base: str, unknowns: list[Unknown]) -> list[Bar]:
    """Return the bar of each unknown, the one with the largest effect first."""
    base_value, bars = float(study.cases.at(base, column)), []
    for unknown in unknowns:
        changes = {case: float(study.cases.at(case, column)) / base_value - 1.0 for case in unknown.cases}
        changes = {"": 0.0} | {case: change for case, change in changes.items() if np.isfinite(change)}
        low, high = min(changes, key=changes.__getitem__), max(changes, key=changes.__getitem__)
        bars.append(Bar(unknown, changes[low], changes[high], low, high))
    return sorted(bars, key=lambda bar: bar.decrease - bar.increase)


def combined_change(bars: list[Bar]) -> tuple[float, float]:
    """Return the relative change of a figure, down and up, by all unknowns together.

    The unknowns are independent, so the logarithms of the ratios are combined by root-sum-square.  Logarithms are used
    because a peak cannot fall by more than 100 %.
    """
    log_decrease = np.linalg.norm([np.log1p(bar.decrease) for bar in bars])
    log_increase = np.linalg.norm([np.log1p(bar.increase) for bar in bars])
    return float(np.expm1(-log_decrease)), float(np.expm1(log_increase))


def _sentences(study: Study, column: str, base: str, bars: list[Bar]) -> list[str]:
    lower, upper = combined_change(bars)
    influential = [bar.unknown.name for bar in bars if bar.increase - bar.decrease >= NEGLIGIBLE_CHANGE]
    negligible = [bar.unknown.name for bar in bars if bar.increase - bar.decrease < NEGLIGIBLE_CHANGE]
    base_peak = study.text(base, column)
    largest = wording.sentence_list(influential[:2]) if influential else "none of the unknowns"
    verb = "have" if len(influential[:2]) > 1 else "has"
    sentences = [
        f"The base case {base[:8]} has a force peak of {base_peak}. Each other case changes one unknown. If the "
        f"unknowns are independent, the uncertainty of the peak is {_percent_text(lower)} to {_percent_text(upper)}. "
        "For each bound, the logarithms of the changes are combined by root-sum-square.",
        f"{largest[:1].upper()}{largest[1:]} {verb} the largest effect on the peak.",
    ]
    if negligible:
        sentences.append(
            f"The effect is below {wording.percent_text(NEGLIGIBLE_CHANGE)} for {wording.sentence_list(negligible)}."
        )
    return [*sentences, "The cases change one unknown at a time, so they do not show interactions."]


def _percent_text(change: float) -> str:
    return f"{100.0 * change:+.1f} %"


def _values_text(study: Study, bar: Bar, case_id: str) -> str:
    """Return the values of an unknown in a case."""
    if not case_id:
        return "base"
    return ", ".join(axis.text(study.cases.at(case_id, axis.path)) for axis in bar.unknown.axes)


def _budget_picture(study: Study, bars: list[Bar]) -> Picture:
    """Return the tornado: a bar per unknown, the largest at the top, with the settings at both of its ends."""
    alt = "; ".join(
        f"{bar.unknown.name}: {_percent_text(bar.decrease)} to {_percent_text(bar.increase)}" for bar in bars
    )

    def paint(ax: Axes) -> None:
        drawn, positions = bars[::-1], np.arange(len(bars), dtype=float)
        changes = (100.0 * np.array([getattr(bar, name) for bar in drawn]) for name in ("decrease", "increase"))
        ax.barh(positions, *changes, height=0.6, color=BLUE, alpha=0.75)
        style: dict[str, Any] = {"va": "center", "size": 7.0}
        for position, bar in zip(positions.tolist(), drawn, strict=True):
            if bar.decrease < 0.0:
                setting = _values_text(study, bar, bar.case_of_decrease)
                ax.text(100.0 * bar.decrease, position, setting, ha="right", offset=-3.0, **style)
            if bar.increase > 0.0:
                setting = _values_text(study, bar, bar.case_of_increase)
                ax.text(100.0 * bar.increase, position, setting, offset=3.0, **style)
        ax.axvline(0.0, color=INK, linewidth=1.0)
        ax.yaxis.set_ticks(positions.tolist(), [bar.unknown.name.replace(" and ", "\nand ") for bar in drawn])
        ax.set_tick_length(0.0, "y")
        ax.xaxis.margin = 0.25  # space for the words next to the bars
        ax.xaxis.label = f"change of {PEAK.name} [%]"
        set_plain_axes(ax)

    return Picture(
        "Error budget",
        "effect of each unknown alone on the force peak",
        f"Bars of the change of the force peak by unknown. {alt}",
        paint,
        size=(7.0, 0.8 + 0.34 * len(bars)),
    )


def _table(study: Study, bars: list[Bar]) -> Table:
    """Return the table with the numbers of the bars."""
    rows = [
        (
            bar.unknown.name,
            count_cell(len(bar.unknown.cases)),
            Quantity(bar.decrease, _percent_text(bar.decrease)),
            _values_text(study, bar, bar.case_of_decrease),
            Quantity(bar.increase, _percent_text(bar.increase)),
            _values_text(study, bar, bar.case_of_increase),
        )
        for bar in bars
    ]
    note = "Change of the largest normal force from that of the base case, one unknown at a time."
    columns = columns_of("unknown | cases | least change | at | largest change | reached at")
    return Table("budget", "Error budget", note, columns, rows)
