"""The motion of the worst case for the question of the grid, and of the cases that represent the leading figure.

Pictures do not repeat the content of a player.
"""

from collections.abc import Iterable, Mapping

import numpy as np
from markupsafe import Markup

from ...language import wording
from ..blocks.picture import capitalise
from ..blocks.section import Block, Detail, Section
from ..data.study import Joint, Study
from ..data.table_columns import columns_in_table
from ..data.worst_case import case_ranking_of, worst_case
from ..one_case import player
from ..one_case.motion import motion_pictures, onset_pictures, saved_channels

MECHANISM_ONLY = Joint("-", "", wears=False)  # figures of the mechanism alone
FIRST = ("joint", "peak", "load / ideal", " error", "film", "life")  # ends of the names of figures of the first screen
SHOWN_PEAK = 0.9  # of the force peak: curves that reach it show the peak
NOT_SAVED = Markup(
    "No time histories were saved (<code>save: {{orbits: none}}</code>). <code>clearsweep show {} {}</code> "
    "shows this case in motion."
)


def sections(study: Study) -> list[Section]:
    """Return the worst case in motion, or how to draw it; [] without a finished case, and for `identify`."""
    if study.cases.empty or case_ranking_of(study).question == "identify":
        return []
    worst = worst_case(study)
    worst_ids = [worst[0]] if worst else []
    title = case_ranking_of(study).title
    label = (
        (f"Worst case: {title[:1].lower()}{title[1:]}" if title else "Worst case")
        if len(study.cases) > 1
        else "The case"
    )
    shown_id = next(iter([*worst_ids, *_representative_case_ids(study)]), None)
    blocks: list[Block] = []
    if shown_id is not None:
        shown = _details(study, [shown_id], {}, label) or [_without_history(study, shown_id, label)]
        blocks += [
            detail._replace(figures=[pair for pair in detail.figures if pair[0].endswith(FIRST)]) for detail in shown
        ]
    return [Section("cases", "The worst case" if len(study.cases) > 1 else "The motion", blocks)]


def _without_history(study: Study, case_id: str, label: str) -> Detail:
    """Return a case without time histories: its figures, and the command that draws it."""
    remark = NOT_SAVED.format(study.run.directory, wording.short_id(case_id))
    return Detail(label, case_id, study.setting(case_id), _summary_values(study, case_id), [], note=remark)


def other_cases_sections(study: Study) -> list[Section]:
    """Return the cases with the largest, the median and the smallest leading figure, except the worst case."""
    if study.cases.empty:
        return []
    worst_id, ranked_ids = worst_case(study), _representative_case_ids(study)
    shown_id = worst_id[0] if worst_id else next(iter(ranked_ids), None)
    shown_id = None if case_ranking_of(study).question == "identify" else shown_id
    rank_words = ("largest", "smallest") if len(ranked_ids) == 2 else ("largest", "median", "smallest")
    name = capitalise(study.lead.name)
    labels = {
        case_id: f"{name}, the {rank_word} of all cases"
        for case_id, rank_word in zip(ranked_ids, rank_words, strict=False)
    }
    other_ids = [case_id for case_id in ranked_ids if case_id != shown_id]
    return [Section("other-cases", "Other cases in motion", [*_details(study, other_ids, labels, "")])]


def _representative_case_ids(study: Study) -> tuple[str, ...]:
    """Return the cases with the largest, the median and the smallest leading figure of the most loaded joint."""
    return study.cases.representative_cases(study.most_loaded_joint().column(study.lead.figure))


def _details(study: Study, case_ids: Iterable[str], labels: dict[str, str], default_label: str) -> list[Detail]:
    """Return the cases with saved time histories in motion, each with its label."""
    details = []
    for case_id in case_ids:
        channels = saved_channels(study.run, case_id)
        if channels is not None:
            case_pictures = motion_pictures(study, case_id, channels) + onset_pictures(
                study, case_id, study.run.events(case_id), channels
            )
            animation = player.player_data(study, case_id, channels)
            player_pictures = tuple(picture for picture in case_pictures if picture.shown_in_player and animation)
            static_pictures = [picture for picture in case_pictures if not (picture.shown_in_player and animation)]
            setting, figures = study.setting(case_id), _summary_values(study, case_id)
            label = labels.get(case_id, default_label)
            note = _peak_note(study, case_id, channels)
            details.append(
                Detail(
                    label,
                    case_id,
                    setting,
                    figures,
                    static_pictures,
                    animation,
                    player_pictures=player_pictures,
                    note=note,
                )
            )
    return details


def _peak_note(study: Study, case_id: str, channels: Mapping) -> str:
    """Return a remark if the curves of a case do not contain the force peak of a joint, or ''."""
    for joint in study.joints:
        column, force = joint.column("force_peak"), channels.get(f"joints/{joint.name}/force_normal", ())
        if len(force) and np.max(force) < SHOWN_PEAK * study.cases.at[case_id, column]:
            reached = wording.quantity_text(float(np.max(force)), "N")
            advice = (
                "" if "worst" in study.run.grid.get("save", {}) else " With save.worst a run stores its revolution."
            )
            return (
                f"The curves do not contain the force peak{study.joint_text(joint, ' of joint {}')}, "
                f"{study.text(case_id, column)}: they reach {reached}. They show the saved revolutions, and an "
                f"impact can lie between two samples.{advice}"
            )
    return ""


def _summary_values(study: Study, case_id: str) -> list[tuple[str, str]]:
    """Return name and value with unit of the figures of a case; if there are several joints, each is named."""
    mechanism_columns = {name for name, _ in columns_in_table(study, "case", MECHANISM_ONLY)}
    figures: list[tuple[str, str]] = []
    for joint in study.joints:
        figures += [("joint", joint.title)] if len(study.joints) > 1 else []
        columns = [entry for entry in columns_in_table(study, "case", joint) if entry[0] not in mechanism_columns]
        figures += [(name, study.text(case_id, column)) for column, name in columns]
    return figures + [
        (name, study.text(case_id, column)) for column, name in columns_in_table(study, "case", MECHANISM_ONLY)
    ]
