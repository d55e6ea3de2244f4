"""The motion of the hardest, the median and the mildest loaded case."""

from markupsafe import Markup

from .. import player
from ..motion import history, onsets, pictures
from ..section import Block, Detail, Note, Section
from ..shown import shown
from ..study import Joint, Study

TITLES = {
    1: "The motion",
    2: "The motion of the hardest and the mildest loaded case",
    3: "The motion of the hardest, the median and the mildest loaded case",
}
WHY = (
    (),
    ("The case",),
    ("Hardest loaded case", "Mildest loaded case"),
    ("Hardest loaded case", "Median case", "Mildest loaded case"),
)
NO_JOINT = Joint("-", "", wears=False)  # figures of the mechanism alone
NOT_SAVED = Markup(
    "This run saved no time histories (<code>save: {orbits: none}</code>). <code>clearsweep show DIR CASE_ID</code> "
    "simulates one case again and draws it."
)


def sections(study: Study) -> list[Section]:
    """Return the cases whose history was saved, drawn, or how to draw one; [] where none finished."""
    if study.cases.empty:
        return []
    details: list[Block] = [*_details(study)]
    return [Section("cases", TITLES.get(len(details), "The motion"), details or [Note(NOT_SAVED)])]


def _details(study: Study) -> list[Detail]:
    column = study.hardest_joint().column(study.lead.figure)
    ids = study.cases.ranked(column)
    details = []
    for why, case_id in zip(WHY[len(ids)], ids, strict=True):
        path = history(study.run, case_id)
        if path is not None:
            drawn = pictures(study, case_id, path) + onsets(study, case_id, study.run.events(case_id), path)
            moving = player.of(study, case_id, path)
            details.append(Detail(why, case_id, study.setting(case_id), _figures(study, case_id), drawn, moving))
    return details


def _figures(study: Study, case_id: str) -> list[tuple[str, str]]:
    """Return the figures of a case: name, value with unit; of several joints one after another, each named."""
    whole = {name for name, _ in shown(study, "case", NO_JOINT)}
    figures: list[tuple[str, str]] = []
    for joint in study.joints:
        figures += [("joint", joint.title)] if len(study.joints) > 1 else []
        columns = [each for each in shown(study, "case", joint) if each[0] not in whole]
        figures += [(name, study.text(case_id, column)) for column, name in columns]
    return figures + [(name, study.text(case_id, column)) for column, name in shown(study, "case", NO_JOINT)]
