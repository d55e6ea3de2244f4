"""The motion of the worst case for the question of the grid, and of the worst, the median and the mildest case.

Pictures do not repeat the content of a player.
"""

from collections.abc import Iterable

from markupsafe import Markup

from ...language import wording
from ..blocks.picture import capital
from ..blocks.section import Block, Detail, Section
from ..data.study import Joint, Study
from ..data.table_columns import columns_in_table
from ..data.worst_case import question, worst_case
from ..one_case import player
from ..one_case.motion import onsets, pictures, saved_channels

NO_JOINT = Joint("-", "", wears=False)  # figures of the mechanism alone
NOT_SAVED = Markup(
    "No time histories were saved (<code>save: {{orbits: none}}</code>). <code>clearsweep show {} {}</code> "
    "shows this case in motion."
)


def sections(study: Study) -> list[Section]:
    """Return the worst case in motion, or how to draw it; [] without a finished case, and for `identify`."""
    if study.cases.empty or question(study).question == "identify":
        return []
    worst = worst_case(study)
    ids = [worst[0]] if worst else []
    title = question(study).title
    why = (
        (f"Worst case: {title[:1].lower()}{title[1:]}" if title else "Worst case")
        if len(study.cases) > 1
        else "The case"
    )
    shown_ids = [*ids, *_ranked(study)][:1]
    blocks: list[Block] = [*_details(study, shown_ids, {}, why)] or [
        _without_history(study, each, why) for each in shown_ids
    ]
    return [Section("cases", "The worst case" if len(study.cases) > 1 else "The motion", blocks)]


def _without_history(study: Study, case_id: str, why: str) -> Detail:
    """Return a case without time histories: its figures, and the command that draws it."""
    remark = NOT_SAVED.format(study.run.directory, wording.short_id(case_id))
    return Detail(why, case_id, study.setting(case_id), _figures(study, case_id), [], note=remark)


def others(study: Study) -> list[Section]:
    """Return the cases with the largest, the median and the smallest leading figure, except the worst case."""
    if study.cases.empty:
        return []
    worst, ranked = worst_case(study), _ranked(study)
    first = worst[0] if worst else next(iter(ranked), None)
    first = None if question(study).question == "identify" else first
    words = ("largest", "smallest") if len(ranked) == 2 else ("largest", "median", "smallest")
    name = capital(study.lead.name)
    why = {case_id: f"{name}, the {word} of all cases" for case_id, word in zip(ranked, words, strict=False)}
    rest = [case_id for case_id in ranked if case_id != first]
    return [Section("other-cases", "Other cases in motion", [*_details(study, rest, why, "")])]


def _ranked(study: Study) -> tuple[str, ...]:
    """Return the cases with the largest, the median and the smallest leading figure of the most loaded joint."""
    return study.cases.extreme_cases(study.hardest_joint().column(study.lead.figure))


def _details(study: Study, ids: Iterable[str], why: dict[str, str], otherwise: str) -> list[Detail]:
    details = []
    for case_id in ids:
        path = saved_channels(study.run, case_id)
        if path is not None:
            drawn = pictures(study, case_id, path) + onsets(study, case_id, study.run.events(case_id), path)
            moving = player.player_of(study, case_id, path)
            played = tuple(picture for picture in drawn if picture.played and moving)
            kept = [picture for picture in drawn if not (picture.played and moving)]
            setting, figures = study.setting(case_id), _figures(study, case_id)
            word = why.get(case_id, otherwise)
            details.append(Detail(word, case_id, setting, figures, kept, moving, played=played))
    return details


def _figures(study: Study, case_id: str) -> list[tuple[str, str]]:
    """Return name and value with unit of the figures of a case; if there are several joints, each is named."""
    whole = {name for name, _ in columns_in_table(study, "case", NO_JOINT)}
    figures: list[tuple[str, str]] = []
    for joint in study.joints:
        figures += [("joint", joint.title)] if len(study.joints) > 1 else []
        columns = [each for each in columns_in_table(study, "case", joint) if each[0] not in whole]
        figures += [(name, study.text(case_id, column)) for column, name in columns]
    return figures + [(name, study.text(case_id, column)) for column, name in columns_in_table(study, "case", NO_JOINT)]
