"""Tables of the figures of every finished case: forces of each joint, output and drive, and their accuracy."""

from collections.abc import Iterator, Sequence
from typing import overload

from ...contracts.layout import DIFFERENCE
from ...language import wording
from ..blocks.case_table import case_table
from ..blocks.picture import capital
from ..blocks.section import Block, Note, Points, Section, without_empty
from ..blocks.table import Quantity, Table
from ..data.leading import PEAK
from ..data.study import Joint, Study
from ..data.table_columns import columns_in_table

HORIZON, PEAK_TURN = "horizon_revolutions", "force_peak_revolution"
CHECKED = 3  # figures of a joint whose error is shown if the grid requests it: the first ones


def sections(study: Study) -> list[Section]:
    """Return the section, or [] if no case finished."""
    if study.cases.empty:
        return []
    blocks: list[Block] = []
    if study.is_driven:
        blocks.append(
            Note(
                "The peak is the largest force of the window; median and 95 % quantile are those of the peaks of its "
                "revolutions. In periodic motion the three are equal. The load is the resultant of normal and friction "
                "force. p99 is exceeded during 1 % of the time, so it ignores shorter impacts. The ideal peak is the "
                "largest reaction of the same joint without clearance."
            )
        )
    tables = [*(_joint(study, joint) for joint in study.joints), _whole(study)]
    return [Section("peaks", "Peaks", without_empty([*blocks, *tables, Points(_checks(study)), _certainty(study)]))]


def _joint(study: Study, joint: Joint) -> Table:
    """Return forces and impacts of one joint, the largest force peak first."""
    lead, title = joint.column(PEAK.figure), f"Forces in joint {joint.title}"
    return case_table(study, f"peaks_{joint.name}", title, columns_in_table(study, "forces", joint), lead)


def _whole(study: Study) -> Table:
    """Return the figures of output and drive, or the measured restitution."""
    columns, output = columns_in_table(study, "output"), study.run.layout.output
    key, title = ("drive", "The drive") if study.is_driven else ("restitution", "Measured restitution")
    if output:
        key, title = output, f"{capital(output)} and drive"
    return case_table(study, key, title, columns, columns[0][0] if columns else "")


def _certainty(study: Study) -> Table:
    """Return the accuracy of figures; empty unless the grid requests it."""
    columns, until = columns_in_table(study, "certainty"), study.run.layout.until
    if until:
        columns.insert([column for column, _ in columns].index("figure_ci"), (until, until))
    for joint in study.joints:
        for column, name in columns_in_table(study, "forces", joint)[:CHECKED]:
            columns.append((column + DIFFERENCE, f"error of {name}{study.joint_text(joint, ' ({})')}"))
    first = next((column for column, _ in columns if study.has(column)), "")
    table = case_table(study, "certainty", "How certain the figures are", columns, first)
    return table._replace(
        note=f"{table.note} The error is the difference from a run at a tenth of the tolerance. The horizon is the "
        "number of revolutions after which two such runs are two samples of a chaotic motion. The error is meaningful "
        "only before the horizon.",
        rows=_Unchecked(table, _words_of_columns(study)) if len(table.rows) else table.rows,
    )


def _words_of_columns(study: Study) -> dict[str, dict[str, str]]:
    """Return replacements of meaningless errors: heading of a column -> case_id -> text."""
    return {f"error of force peak{study.joint_text(joint, ' ({})')}": words for joint, words in _beyond_horizon(study)}


def _beyond_horizon(study: Study) -> list[tuple[Joint, dict[str, str]]]:
    """Return why the error of a force peak is meaningless: joint, and case_id -> text."""
    if not study.has(HORIZON):
        return []
    horizon, cases = study.cases[HORIZON], []
    for joint in study.joints:
        turn = joint.column(PEAK_TURN)
        if study.has(turn):
            turns = study.cases[turn]
            beyond = study.cases.index[(turns > horizon).to_numpy()]
            words = {
                case_id: f"peak in revolution {turns[case_id]:.0f}, horizon {wording.plain(horizon[case_id], 2)} "
                "revolutions: the error does not check convergence"
                for case_id in beyond
            }
            cases.append((joint, words))
    return cases


def _checks(study: Study) -> list[str]:
    """Return the numbers of cases in which the error of the largest force is meaningful, and in which it is not."""
    points = []
    for joint, beyond in _beyond_horizon(study):
        chaotic, where = int(study.cases[HORIZON].notna().sum()), study.joint_text(joint, " in joint {}")
        if beyond:
            case_id, words = next(iter(beyond.items()))
            points.append(
                f"The error of the force peak{where} does not check convergence in {len(beyond)} of "
                f"{wording.count(len(study.cases), 'case')}, because their peak lies beyond the horizon. An example is "
                f"case {wording.short_id(case_id)} ({words.partition(':')[0]})."
            )
        if chaotic > len(beyond):
            points.append(
                f"In {wording.count(chaotic - len(beyond), 'chaotic case')} the peak{where} lies within the horizon: "
                "the error checks only these first revolutions."
            )
    return points


class _Unchecked(Sequence):
    """The rows of a table, with meaningless errors replaced by texts."""

    def __init__(self, table: Table, words: dict[str, dict[str, str]]):
        """Take the table, and heading of a column -> case_id -> text."""
        heads = [column.name for column in table.columns]
        self.rows = table.rows
        self.words = {heads.index(heading): words[heading] for heading in words if heading in heads}

    def __len__(self) -> int:
        return len(self.rows)

    @overload
    def __getitem__(self, which: int) -> tuple: ...
    @overload
    def __getitem__(self, which: slice) -> list[tuple]: ...
    def __getitem__(self, which: int | slice) -> tuple | list[tuple]:
        if isinstance(which, int):
            return self._described(self.rows[which])
        return [self._described(row) for row in self.rows[which]]

    def __iter__(self) -> Iterator[tuple]:
        return map(self._described, self.rows)

    def _described(self, row: tuple) -> tuple:
        """Return a row with its replacements; its first cell is the case_id."""
        return tuple(
            Quantity(value, self.words[place][row[0]]) if row[0] in self.words.get(place, {}) else value
            for place, value in enumerate(row)
        )
