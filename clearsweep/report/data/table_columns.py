"""Determines the figures, the order and the headings of a table from the descriptions of the figures."""

from ... import simulation
from ...answers import labels
from ...contracts.catalogue import Entry, Figure
from ...contracts.layout import Column
from .study import P99_OVER_IDEAL, WEAR_PER_1000_HOURS, WEAR_PER_MILLION_STROKES, Joint, Study

#: The figures that are computed of columns of the summary, see `study`.
COMPUTED_FIGURES = (
    Figure(
        P99_OVER_IDEAL,
        "1",
        "force p99 divided by the force peak without clearance",
        of="joint",
        needs=("turns",),
        tables=(Entry("forces", "p99 / ideal", 5), Entry("effects", "p99 / ideal", 3)),
    ),
    Figure(
        WEAR_PER_1000_HOURS,
        "m",
        "largest wear depth after 1000 hours at the wear rate of the window",
        of="joint",
        needs=("wear",),
        tables=(Entry("wear", "depth per 1000 h", 51),),
    ),
    Figure(
        WEAR_PER_MILLION_STROKES,
        "m",
        "largest wear depth after a million crank revolutions at the wear rate of the window",
        of="joint",
        needs=("wear", "turns"),
        tables=(Entry("wear", "depth per 10⁶ strokes", 52),),
    ),
)


def columns_in_table(study: Study, table: str, joint: Joint | None = None) -> list[tuple[str, str]]:
    """Return column and heading of the figures of a joint and of the mechanism in a table, the joint's first.

    Without `joint`, the figures of all joints are returned; if there are several joints, headings name them.
    """
    entries = {figure.name: figure.tables for figure in (*simulation.catalogue().figures, *COMPUTED_FIGURES)}
    joint_order = {joint.name: joint_index for joint_index, joint in enumerate(study.joints)}
    ordered_columns = []
    computed = (_computed_column(figure, joint) for joint in study.joints for figure in COMPUTED_FIGURES)
    for column in (*study.run.layout.columns, *computed):
        if column.name in study.cases and (joint is None or column.joint in ("", joint.name)):
            for entry in entries.get(column.figure, ()):
                if entry.table == table and not (entry.if_any and not (study.cases[column.name] > 0.0).any()):
                    order = (joint_order.get(column.joint, len(joint_order)), entry.order)
                    ordered_columns.append(
                        (order, column.name, _heading(study, entry.heading, "" if joint else column.joint))
                    )
    return [(name, heading) for _, name, heading in sorted(ordered_columns, key=lambda column_entry: column_entry[0])]


def column_label(study: Study, column: str) -> str:
    """Return the label of a column, as in the last lines of a run."""
    return labels.column_label(study.run.layout, column)


def _computed_column(figure: Figure, joint: Joint) -> Column:
    return Column(joint.column(figure.name), figure.unit, figure.text, figure=figure.name, joint=joint.name)


def _heading(study: Study, heading: str, joint: str) -> str:
    """Return a complete heading, which names `joint` if there are several joints."""
    rate_texts = {"per_rev": " per rev.", "per_revolution": " per revolution"} if study.is_driven else {}
    text = heading.format_map({"output": study.run.layout.output, "per_rev": "", "per_revolution": ""} | rate_texts)
    return text + next(
        (study.joint_text(known_joint, " ({})") for known_joint in study.joints if known_joint.name == joint), ""
    )
