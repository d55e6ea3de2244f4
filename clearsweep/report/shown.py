"""Which figures a table shows, in which order and under which headings: every figure says so of itself."""

from .. import simulation
from ..catalogue import Figure, Shown
from ..layout import Column
from .study import RATIO, Joint, Study

#: The figure that is computed here, from two columns of the summary.
OVER_IDEAL = Figure(
    RATIO,
    "1",
    "force p99 over the peak of the ideal joint",
    of="joint",
    needs=("turns",),
    shown=(Shown("forces", "p99 / ideal", 5), Shown("effects", "p99 / ideal", 3)),
)


def shown(study: Study, table: str, joint: Joint | None = None) -> list[tuple[str, str]]:
    """Return column and heading of the figures that a table shows of a joint and of the mechanism, the joint's first.

    Without a `joint` those of all joints; where there are several, headings name them.
    """
    entries = {figure.name: figure.shown for figure in (*simulation.catalogue().figures, OVER_IDEAL)}
    places = {each.name: place for place, each in enumerate(study.joints)}
    found = []
    for column in (*study.run.layout.columns, *(_over_ideal(each) for each in study.joints)):
        if column.name in study.cases and (joint is None or column.joint in ("", joint.name)):
            for entry in entries.get(column.figure, ()):
                if entry.table == table and not (entry.if_any and not (study.cases[column.name] > 0.0).any()):
                    order = (places.get(column.joint, len(places)), entry.order)
                    found.append((order, column.name, _heading(study, entry.heading, "" if joint else column.joint)))
    return [(name, heading) for _, name, heading in sorted(found, key=lambda each: each[0])]


def _over_ideal(joint: Joint) -> Column:
    return Column(joint.column(RATIO), OVER_IDEAL.unit, OVER_IDEAL.text, figure=RATIO, joint=joint.name)


def _heading(study: Study, heading: str, joint: str) -> str:
    """Return a heading in full; it names `joint` where there are several."""
    rate = {"per_rev": " per rev.", "per_revolution": " per revolution"} if study.driven else {}
    text = heading.format_map({"output": study.run.layout.output, "per_rev": "", "per_revolution": ""} | rate)
    return text + next((study.where(each, " ({})") for each in study.joints if each.name == joint), "")
