"""The figures of every finished case in tables: forces of each joint, output and drive, how certain they are."""

from ...contracts.layout import DIFFERENCE
from ..case_table import case_table
from ..picture import capital
from ..section import Block, Note, Section, filled
from ..shown import shown
from ..study import P99, Joint, Study
from ..table import Table

CHECKED = 3  # figures of a joint whose error is shown where the grid asked for it: the first ones


def sections(study: Study) -> list[Section]:
    """Return the section; [] where no case finished."""
    if study.cases.empty:
        return []
    blocks: list[Block] = []
    if study.lead is P99:
        blocks.append(
            Note(
                "Peak: the largest of the window; beside it the median and the 95 % quantile of the peaks of its "
                "revolutions, which are one where the motion repeats itself. Load: normal and friction force together. "
                "p99: exceeded during 1 % of the time, so blind to shorter impacts. Ideal peak: largest reaction of "
                "the same joint without clearance."
            )
        )
    tables = [*(_joint(study, joint) for joint in study.joints), _whole(study), _certainty(study)]
    return [Section("peaks", "Peaks", filled([*blocks, *tables]))]


def _joint(study: Study, joint: Joint) -> Table:
    """Return forces and impacts of one joint, the largest leading figure first."""
    lead, title = joint.column(study.lead.figure), f"Forces in joint {joint.title}"
    return case_table(study, f"peaks_{joint.name}", title, shown(study, "forces", joint), lead)


def _whole(study: Study) -> Table:
    """Return what the output and the drive feel, or the measured restitution."""
    columns, output = shown(study, "output"), study.run.layout.output
    key, title = ("drive", "The drive") if study.driven else ("restitution", "Measured restitution")
    if output:
        key, title = output, f"{capital(output)} and drive"
    return case_table(study, key, title, columns, columns[0][0] if columns else "")


def _certainty(study: Study) -> Table:
    """Return how far figures can be trusted; empty unless the grid asked for any of it."""
    columns, until = shown(study, "certainty"), study.run.layout.until
    if until:
        columns.insert([column for column, _ in columns].index("figure_ci"), (until, until))
    for joint in study.joints:
        for column, name in shown(study, "forces", joint)[:CHECKED]:
            columns.append((column + DIFFERENCE, f"error of {name}{study.where(joint, ' ({})')}"))
    first = next((column for column, _ in columns if study.has(column)), "")
    table = case_table(study, "certainty", "How certain the figures are", columns, first)
    return table._replace(
        note=f"{table.note} Error: difference from a run at a tenth of the tolerance, which in "
        "chaotic motion is that of two samples; horizon: after it two such runs are."
    )
