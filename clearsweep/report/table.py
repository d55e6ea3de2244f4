"""The tables of a report: peaks, wear, main effects, speeds, failures; as CSV in SI and as text for the page."""

import csv
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd

from .. import wording
from . import findings
from .study import RATIO, Axis, Joint, Study, position, prepare

SHOWN = 50  # rows of a table on the page; the CSV has all


class Column(NamedTuple):
    """One column of a table: its name in words, its SI unit ('1': none), and the axis it belongs to, if any."""

    name: str
    unit: str = "1"
    axis: Axis | None = None
    file_only: bool = False  # left out on the page, where the cells carry it


class Quantity(NamedTuple):
    """One cell with a unit of its own: a number in the CSV, number and unit on the page."""

    value: float | str  # SI
    text: str


class Table(NamedTuple):
    """One table: `rows` in SI, in the order in which they are shown."""

    key: str  # name of the CSV file
    title: str
    note: str
    columns: tuple[Column, ...]
    rows: list[tuple]

    def shown(self) -> "Shown":
        """Return the table in text: heads with units for people, the first SHOWN rows."""
        heads, cells, numeric = [], [], []
        for place, column in enumerate(self.columns):
            if column.file_only:
                continue
            values = [row[place] for row in self.rows[:SHOWN]]
            scale = _scale(column, values)
            heads.append((column.name, scale.unit))
            cells.append([_cell(value, column, scale) for value in values])
            bare = [value.value if isinstance(value, Quantity) else value for value in values]
            numeric.append(not any(isinstance(value, str) for value in bare))
        return Shown(heads, [list(row) for row in zip(*cells, strict=True)], numeric, len(self.rows))


class Shown(NamedTuple):
    """A table in text, cut to the rows that the page shows."""

    heads: list[tuple[str, str]]  # name, unit ('' for none)
    rows: list[list[str]]
    numeric: list[bool]
    total: int  # rows there are in all


PEAKS = (
    ("force_peak", "force peak", "N"),
    ("force_p99", "force p99", "N"),
    ("force_rms", "force rms", "N"),
    ("force_peak_ideal", "ideal peak", "N"),
    (RATIO, "p99 / ideal", "1"),
    ("impacts_per_rev", "impacts per rev.", "1"),
    ("contact_fraction", "time in contact", "1"),
    ("onset_rate_max", "fastest onset", "m/s"),
    ("penetration_max", "penetration", "m"),
)
PAST_LAWS = (("law_limit_fraction", "time past its law's range"), ("force_clips", "clips"))  # shown where there are any
SLIDER = (
    ("slider_error_max", "slider error", "m"),
    ("slider_acceleration_peak", "slider acc. peak", "m/s^2"),
    ("slider_acceleration_rms", "slider acc. rms", "m/s^2"),
    ("crank_torque_peak", "crank torque peak", "N*m"),
    ("pair_restitution", "restitution", "1"),
)
WEAR = (
    ("wear_depth_max", "depth", "m"),
    ("wear_rate_max", "depth rate", "m/s"),
    ("wear_volume", "volume", "m^3"),
    ("force_p99", "force p99", "N"),
    ("wear_narrow_arcs", "narrow arcs", "1"),
)


def write(run, directory: Path) -> list[Path]:
    """Write every table of a run as CSV (SI, unit in the header) into `directory`; return the files."""
    directory = Path(directory)
    directory.mkdir(parents=True, exist_ok=True)
    study = prepare(run)
    files = []
    for table in every(study):
        file = directory / f"{table.key}.csv"
        with file.open("w", newline="", encoding="utf-8") as stream:
            writer = csv.writer(stream)
            writer.writerow(
                [
                    f"{column.name} [{column.unit}]" if column.unit not in ("1", "") else column.name
                    for column in table.columns
                ]
            )
            writer.writerows([[_plain(value) for value in row] for row in table.rows])
        files.append(file)
    return files


def every(study: Study) -> list[Table]:
    """Return the tables of a run, those that have nothing to say left out."""
    from . import laws, probability

    found = [
        best_by_speed(study),
        *probability.tables(study),
        main_effects(study),
        *laws.tables(study),
        *(peaks(study, joint) for joint in study.joints),
        slider(study),
        certainty(study),
        *(wear(study, joint) for joint in study.joints if joint.wears),
        failed(study),
    ]
    return [table for table in found if table.rows]


def peaks(study: Study, joint: Joint) -> Table:
    """Return forces and impacts of one joint, one row per finished case, the largest p99 first."""
    figures = [(joint.column(figure), Column(name, unit)) for figure, name, unit in PEAKS]
    if study.mechanism == "impact-pair":
        figures = [(column, Column("impacts") if head.name == "impacts per rev." else head) for column, head in figures]
    figures += [
        (joint.column(figure), Column(name))
        for figure, name in PAST_LAWS
        if study.has(joint.column(figure)) and (study.cases[joint.column(figure)] > 0.0).any()
    ]
    figures.append(("slider_error_max", Column("slider error", "m")))
    title = f"Forces in joint {joint.title}"
    return _cases(study, f"peaks_{joint.name}", title, figures, joint.column(study.lead.figure))


def slider(study: Study) -> Table:
    """Return what the slider and the drive feel (or the measured restitution), one row per finished case."""
    figures = [(column, Column(name, unit)) for column, name, unit in SLIDER]
    first = next((column for column, _ in figures if column in study.cases), None)
    title = "Measured restitution" if study.mechanism == "impact-pair" else "Slider and drive"
    return _cases(study, "slider", title, figures, first)


def certainty(study: Study) -> Table:
    """Return how far figures can be trusted, one row per finished case; empty unless the grid asked for any of it."""
    unit = study.units.get("figure_ci", "1")
    until = study.run.layout.until
    figures = [
        ("revolutions_run", Column("revolutions")),
        ("period", Column("period")),
        ("settled", Column("settled")),
        (until, Column(until, unit)),
        ("figure_ci", Column("95 % interval, half", unit)),
        ("lyapunov_exponent", Column("Lyapunov exponent", "1/s")),
        ("horizon_revolutions", Column("horizon (rev.)")),
    ]
    for joint in study.joints:
        for figure, name, unit in PEAKS[:3]:
            one = f"{name} ({joint.title})" if len(study.joints) > 1 else name
            figures.append((f"{joint.column(figure)}_difference", Column(f"error of {one}", unit)))
    first = next((column for column, _ in figures if study.has(column)), None)
    table = _cases(study, "certainty", "How certain the figures are", figures, first)
    return table._replace(
        note=f"{table.note} Error: difference from a run at a tenth of the tolerance, which in "
        "chaotic motion is that of two samples; horizon: after it two such runs are."
    )


def wear(study: Study, joint: Joint) -> Table:
    """Return the wear of one joint, one row per finished case, the deepest first."""
    figures = [(joint.column(figure), Column(name, unit)) for figure, name, unit in WEAR]
    table = _cases(study, f"wear_{joint.name}", f"Wear in joint {joint.title}", figures, joint.column("wear_depth_max"))
    return table._replace(
        note=f"{table.note} Depth and volume are those of the recorded window; narrow arcs: share of "
        "the wear steps whose contact arc was narrower than five bins."
    )


def failed(study: Study) -> Table:
    """Return the cases that did not finish, with their reason."""
    columns = (
        Column("case_id"),
        *(Column(axis.name, _unit(study, axis), axis) for axis in study.swept()),
        Column("status"),
        Column("reason"),
    )
    rows = [
        (case_id, *(row[axis.path] for axis in study.swept()), str(row["status"]), _words(row["message"]))
        for case_id, row in study.failed.iterrows()
    ]
    return Table("failed", "Failed cases", "", columns, rows)


def main_effects(study: Study) -> Table:
    """Return the main effect of every axis on force p99 and rms of every joint, wear and slider error."""
    columns = (
        Column("figure"),
        Column("figure unit", file_only=True),
        Column("axis"),
        Column("axis unit", file_only=True),
        Column("smallest median"),
        Column("found at"),
        Column("largest median"),
        Column("reached at"),
        Column("factor"),
        Column("share of the variation"),
    )
    rows = []
    for name, column in _affected(study):
        unit = study.units.get(column, "1")
        for one in findings.effects(study, column):
            if np.isfinite(one.medians).any():
                rows.append(
                    (
                        name,
                        unit,
                        one.axis.name,
                        _unit(study, one.axis),
                        *(
                            cell
                            for place in one.extremes()
                            for cell in (
                                Quantity(float(one.medians[place]), wording.text(one.medians[place], unit)),
                                Quantity(one.axis.values[place], one.axis.text(one.axis.values[place])),
                            )
                        ),
                        one.factor(),
                        Quantity(one.share, findings.percent(one.share)),
                    )
                )
    note = (
        "Median over all finished cases that share a value; the other axes run over all their values. Share of the "
        "variation: of the variance of the logarithm of the figure, what the axis explains by itself; the rest "
        "is interaction and chaos."
    )
    return Table("effects", "Main effects", note, columns, rows)


def best_by_speed(study: Study) -> Table:
    """Return the least and the most loaded design at each crank speed; empty unless speed and another axis vary."""
    speed = next((axis for axis in study.levels() if axis.path == "drive.speed"), None)
    others = [axis for axis in study.swept() if axis is not speed]
    if speed is None or not others or study.cases.empty:
        return Table("by_speed", "", "", (), [])
    joint = study.hardest_joint()
    column = joint.column("force_p99")
    places, rows = position(speed, study.cases[speed.path]), []
    for place, value in enumerate(speed.values):
        here = study.cases[places == place][column].dropna()
        for word, case_id in (("least", here.idxmin()), ("most", here.idxmax())) if len(here) else ():
            row = study.cases.loc[case_id]
            rows.append(
                (
                    value,
                    word,
                    *(row[axis.path] for axis in others),
                    row[column],
                    row.get(joint.column(RATIO), np.nan),
                    row.get("slider_error_max", np.nan),
                    case_id,
                )
            )
    columns = (
        Column(speed.name, _unit(study, speed), speed),
        Column("load"),
        *(Column(axis.name, _unit(study, axis), axis) for axis in others),
        Column("force p99", "N"),
        Column("p99 / ideal"),
        Column("slider error", "m"),
        Column("case_id"),
    )
    where = f" in joint {joint.title}" if len(study.joints) > 1 else ""
    return Table(
        "by_speed",
        "Least and most loaded design at each crank speed",
        f"Ranked by the 99th percentile of the contact force{where}.",
        columns,
        rows,
    )


def _cases(study: Study, key: str, title: str, figures: list[tuple[str, Column]], by: str | None) -> Table:
    figures = [(column, head) for column, head in figures if column in study.cases]
    heads = (
        Column("case_id"),
        *(Column(axis.name, _unit(study, axis), axis) for axis in study.swept()),
        *(head for _, head in figures),
    )
    if not figures or study.cases.empty:
        return Table(key, title, "", heads, [])
    ordered = study.cases.sort_values(by, ascending=False, kind="stable", na_position="last")
    values = [ordered.index, *(ordered[axis.path] for axis in study.swept()), *(ordered[name] for name, _ in figures)]
    name = next(head.name for column, head in figures if column == by)
    return Table(key, title, f"Sorted by {name}, largest first.", heads, list(zip(*values, strict=True)))


def _affected(study: Study) -> list[tuple[str, str]]:
    """Return the figures whose main effects are tabulated: name in words, column."""
    several = len(study.joints) > 1
    figures = (
        (study.lead.figure, study.lead.name),
        ("force_rms", "force rms"),
        (RATIO, "p99 / ideal"),
        ("wear_depth_max", "wear depth"),
    )
    named = [
        (f"{name} ({joint.title})" if several else name, joint.column(figure))
        for joint in study.joints
        for figure, name in figures
    ]
    named += [("slider error", "slider_error_max"), ("restitution", "pair_restitution")]
    return [(name, column) for name, column in named if study.has(column)]


def _scale(column: Column, values: list) -> wording.Scale:
    if column.axis is not None:
        return column.axis.scale
    if values and all(isinstance(value, Quantity) for value in values):
        return wording.Scale(1.0, "")  # each carries its unit
    return wording.scale(column.unit, [value for value in values if not isinstance(value, (str, Quantity))])


def _cell(value, column: Column, scale: wording.Scale) -> str:
    if isinstance(value, Quantity):
        return value.text
    if _missing(value):
        return wording.DASH
    if isinstance(value, str):
        return value
    return scale.number(value) if column.axis is None else column.axis.number(value)


def _plain(value):
    value = value.value if isinstance(value, Quantity) else value
    return "" if _missing(value) else value


def _unit(study: Study, axis: Axis) -> str:
    return study.units.get(axis.path, "1")


def _missing(value) -> bool:
    return value is None or bool(pd.isna(value))


def _words(message) -> str:
    return "" if _missing(message) else str(message)
