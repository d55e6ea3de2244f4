"""Tables of the figures of every finished case: forces of each joint, output and drive, and their accuracy."""

from collections.abc import Iterator, Sequence
from typing import overload

from ...contracts.layout import DIFFERENCE
from ...language import wording
from ..blocks.case_table import case_table
from ..blocks.picture import capitalise
from ..blocks.section import Block, Note, Points, Section, without_empty
from ..blocks.table import Quantity, Table
from ..data.leading import PEAK
from ..data.study import Joint, Study
from ..data.table_columns import columns_in_table

HORIZON, PEAK_REVOLUTION = "horizon_revolutions", "force_peak_revolution"
MAX_CHECKED_FIGURES = 3  # figures of a joint whose error is shown if the grid requests it: the first ones


def sections(study: Study) -> list[Section]:
    """Return the section, or [] if no case finished."""
    if study.cases.empty:
        return []
    blocks: list[Block] = []
    if study.is_driven:
        blocks.append(
            Note(
                "The peak is the largest force of the window; median and 95 % quantile are those of the peaks of its "
                "revolutions. They are equal if every revolution of the window is the same; a window that begins "
                "before the motion is periodic also contains its run-in. The load is the resultant of normal and "
                "friction force. p99 is exceeded during 1 % of the time, so it ignores shorter impacts. The ideal peak "
                "is the largest reaction of the same joint without clearance."
            )
        )
    tables = [*(_force_table(study, joint) for joint in study.joints), _mechanism_table(study)]
    return [
        Section(
            "peaks",
            "Peaks",
            without_empty([*blocks, *tables, Points(_error_check_sentences(study)), _accuracy_table(study)]),
        )
    ]


def _force_table(study: Study, joint: Joint) -> Table:
    """Return forces and impacts of one joint, the largest force peak first."""
    lead, title = joint.column(PEAK.figure), f"Forces in joint {joint.title}"
    return case_table(study, f"peaks_{joint.name}", title, columns_in_table(study, "forces", joint), lead)


def _mechanism_table(study: Study) -> Table:
    """Return the figures of output and drive, or the measured restitution."""
    columns, output = columns_in_table(study, "output"), study.run.layout.output
    key, title = ("drive", "The drive") if study.is_driven else ("restitution", "Measured restitution")
    if output:
        key, title = output, f"{capitalise(output)} and drive"
    return case_table(study, key, title, columns, columns[0][0] if columns else "")


def _accuracy_table(study: Study) -> Table:
    """Return the accuracy of figures; empty unless the grid requests it."""
    columns, until_column = columns_in_table(study, "certainty"), study.run.layout.until
    if until_column:
        columns.insert([column for column, _ in columns].index("figure_ci"), (until_column, until_column))
    for joint in study.joints:
        for column, name in columns_in_table(study, "forces", joint)[:MAX_CHECKED_FIGURES]:
            columns.append((column + DIFFERENCE, f"error of {name}{study.joint_text(joint, ' ({})')}"))
    sort_column = next((column for column, _ in columns if study.has(column)), "")
    table = case_table(study, "certainty", "How certain the figures are", columns, sort_column)
    return table._replace(
        note=f"{table.note} The error is the difference from a run at a tenth of the tolerance. The horizon is the "
        "number of revolutions after which two such runs are two samples of a chaotic motion. The error is meaningful "
        "only before the horizon.",
        rows=_RowsWithReplacements(table, _replacement_texts(study)) if len(table.rows) else table.rows,
    )


def _replacement_texts(study: Study) -> dict[str, dict[str, str]]:
    """Return replacements of meaningless errors: heading of a column -> case_id -> text."""
    return {
        f"error of force peak{study.joint_text(joint, ' ({})')}": text_of_case
        for joint, text_of_case in _beyond_horizon(study)
    }


def _beyond_horizon(study: Study) -> list[tuple[Joint, dict[str, str]]]:
    """Return why the error of a force peak is meaningless: joint, and case_id -> text."""
    if not study.has(HORIZON):
        return []
    horizon, reasons = study.cases[HORIZON], []
    for joint in study.joints:
        revolution_column = joint.column(PEAK_REVOLUTION)
        if study.has(revolution_column):
            revolutions = study.cases[revolution_column]
            beyond = study.cases.index[(revolutions > horizon).to_numpy()]
            text_of_case = {
                case_id: f"peak in revolution {revolutions[case_id]:.0f}, horizon "
                f"{wording.number_text(horizon[case_id], 2)} "
                "revolutions: the error does not check convergence"
                for case_id in beyond
            }
            reasons.append((joint, text_of_case))
    return reasons


def _error_check_sentences(study: Study) -> list[str]:
    """Return the numbers of cases in which the error of the largest force is meaningful, and in which it is not."""
    points = []
    for joint, beyond in _beyond_horizon(study):
        chaotic_count, joint_text = int(study.cases[HORIZON].notna().sum()), study.joint_text(joint, " in joint {}")
        if beyond:
            case_id, text = next(iter(beyond.items()))
            points.append(
                f"The error of the force peak{joint_text} does not check convergence in {len(beyond)} of "
                f"{wording.count_text(len(study.cases), 'case')}, because their peak lies beyond the horizon. An "
                "example is "
                f"case {wording.short_id(case_id)} ({text.partition(':')[0]})."
            )
        if chaotic_count > len(beyond):
            points.append(
                f"In {wording.count_text(chaotic_count - len(beyond), 'chaotic case')} the peak{joint_text} lies "
                "within "
                "the horizon: "
                "the error checks only these first revolutions."
            )
    return points


class _RowsWithReplacements(Sequence):
    """The rows of a table, with meaningless errors replaced by texts."""

    def __init__(self, table: Table, replacements: dict[str, dict[str, str]]):
        """Take the table, and heading of a column -> case_id -> text."""
        headings = [column.name for column in table.columns]
        self.rows = table.rows
        self.replacements = {
            headings.index(heading): replacements[heading] for heading in replacements if heading in headings
        }

    def __len__(self) -> int:
        return len(self.rows)

    @overload
    def __getitem__(self, index: int) -> tuple: ...
    @overload
    def __getitem__(self, selection: slice) -> list[tuple]: ...
    def __getitem__(self, selection: int | slice) -> tuple | list[tuple]:
        if isinstance(selection, int):
            return self._replace_errors(self.rows[selection])
        return [self._replace_errors(row) for row in self.rows[selection]]

    def __iter__(self) -> Iterator[tuple]:
        return map(self._replace_errors, self.rows)

    def _replace_errors(self, row: tuple) -> tuple:
        """Return a row with its replacements; its first cell is the case_id."""
        return tuple(
            Quantity(value, self.replacements[column][row[0]]) if row[0] in self.replacements.get(column, {}) else value
            for column, value in enumerate(row)
        )
