"""Films of oil: least thickness, losses, and the time in which only the film carries load."""

from ..blocks.case_table import case_table
from ..blocks.section import Block, Section
from ..data.study import Study
from ..data.table_columns import columns_in_table

NOTE = (
    "The film carries the whole load as long as the journal does not touch the bearing. Beyond the valid range of its "
    "law, the film is evaluated at the limit. The least thickness and the loss are those of the recorded window."
)


def sections(study: Study) -> list[Section]:
    """Return the section, or [] if no case finished or no joint has a film."""
    blocks: list[Block] = []
    for joint in study.joints if not study.cases.empty else ():
        thinnest = joint.column("film_thickness_min")
        if study.has(thinnest):
            title = f"Film in joint {joint.title}"
            table = case_table(
                study, f"film_{joint.name}", title, columns_in_table(study, "film", joint), thinnest, smallest=True
            )
            blocks.append(table._replace(note=f"{table.note} {NOTE}"))
    return [Section("film", "Films", blocks)] if blocks else []
