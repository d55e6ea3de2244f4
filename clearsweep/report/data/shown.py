"""Determines the figures, the order and the headings of a table from the descriptions of the figures."""

from ... import simulation
from ...contracts.catalogue import Figure, Shown
from ...contracts.layout import Column
from ...judging import labels
from .study import PER_HOURS, PER_STROKES, RATIO, Joint, Study

#: The figures that are computed of columns of the summary, see `study`.
COMPUTED = (
    Figure(
        RATIO,
        "1",
        "force p99 divided by the force peak without clearance",
        of="joint",
        needs=("turns",),
        shown=(Shown("forces", "p99 / ideal", 5), Shown("effects", "p99 / ideal", 3)),
    ),
    Figure(
        PER_HOURS,
        "m",
        "largest wear depth after 1000 hours at the wear rate of the window",
        of="joint",
        needs=("wear",),
        shown=(Shown("wear", "depth per 1000 h", 51),),
    ),
    Figure(
        PER_STROKES,
        "m",
        "largest wear depth after a million crank revolutions at the wear rate of the window",
        of="joint",
        needs=("wear", "turns"),
        shown=(Shown("wear", "depth per 10⁶ strokes", 52),),
    ),
)


def shown(study: Study, table: str, joint: Joint | None = None) -> list[tuple[str, str]]:
    """Return column and heading of the figures of a joint and of the mechanism in a table, the joint's first.

    Without `joint`, the figures of all joints are returned; if there are several joints, headings name them.
    """
    entries = {figure.name: figure.shown for figure in (*simulation.catalogue().figures, *COMPUTED)}
    places = {joint.name: place for place, joint in enumerate(study.joints)}
    sections = []
    computed = (_computed(figure, joint) for joint in study.joints for figure in COMPUTED)
    for column in (*study.run.layout.columns, *computed):
        if column.name in study.cases and (joint is None or column.joint in ("", joint.name)):
            for entry in entries.get(column.figure, ()):
                if entry.table == table and not (entry.if_any and not (study.cases[column.name] > 0.0).any()):
                    order = (places.get(column.joint, len(places)), entry.order)
                    sections.append((order, column.name, _heading(study, entry.heading, "" if joint else column.joint)))
    return [(name, heading) for _, name, heading in sorted(sections, key=lambda each: each[0])]


def in_words(study: Study, column: str) -> str:
    """Return the label of a column, as in the closing lines of a run."""
    return labels.label(study.run.layout, column)


def _computed(figure: Figure, joint: Joint) -> Column:
    return Column(joint.column(figure.name), figure.unit, figure.text, figure=figure.name, joint=joint.name)


def _heading(study: Study, heading: str, joint: str) -> str:
    """Return a complete heading, which names `joint` if there are several joints."""
    rate = {"per_rev": " per rev.", "per_revolution": " per revolution"} if study.driven else {}
    text = heading.format_map({"output": study.run.layout.output, "per_rev": "", "per_revolution": ""} | rate)
    return text + next((study.where(each, " ({})") for each in study.joints if each.name == joint), "")
