"""Sentences that answer the question of a grid, the same on the page and in the last lines of a run."""

from functools import partial

import numpy as np

from ..language import wording
from . import case_ranking, designs, effects, films, fits, labels, sampled, start_up, verdict, wear
from .cases import MAX_NAMED_AXES, FinishedCases

RUN_LENGTH_COLUMN = "revolutions_run"  # column
UNWORN = "The limits are those of unworn joints: wear widens the clearance, so they may not hold until then."
MAX_LISTED_LIMITS = 2  # limits that a sentence names

__all__ = ["MAX_NAMED_AXES", "FinishedCases", "question_sentences", "sentences"]


def sentences(cases: FinishedCases) -> list[str]:
    """Return the answer to the question of a grid, then the range of the figures that it defines."""
    if not len(cases.case_ids):
        return []
    return [*question_sentences(cases), *figure_range_sentences(cases), *run_length_sentences(cases)]


def question_sentences(cases: FinishedCases) -> list[str]:
    """Return the answer to the leading question: a random sample, life, start-up, limits, film or force."""
    if sampled.is_one_sample(cases.record):
        return sampled.sentences(cases)
    answers_by_question = {
        "life": (life_effect_sentences, end_of_life_limit_sentences),
        "start-up": (start_up.sentences, start_force_sentences),
        "limits": (limit_sentences, films.all_loss_sentences, start_up.sentences),
        "film": (films.sentences,),
        "force": (largest_force_sentences, position_error_sentences),
    }
    return [
        line
        for answer in answers_by_question.get(cases.ranking.question, (start_up.sentences,))
        for line in answer(cases)
    ]


def start_force_sentences(cases: FinishedCases) -> list[str]:
    """Return the largest force within the run and until the start-up time, and the error, of the started cases."""
    started = start_up.started_cases(cases)
    worst_case = started.worst_case(case_ranking.force_ranking(started.layout))
    lines = [*peak_force_sentences(started), *position_error_sentences(started)]
    if len(started.case_ids) < len(cases.case_ids):
        lines = [line.replace(": ", " of the started cases: ", 1) for line in lines]
    force_until_start = start_up.start_force_text(started, worst_case.joint) if worst_case is not None else ""
    if force_until_start:
        within = start_up.within_revolutions_text(started)
        lines[0] = f"{lines[0].replace(': ', f'{within}: ', 1)} Until the start-up time: {force_until_start}."
    unknown_text = start_up.force_of_cut_off(cases, worst_case.columns[0]) if worst_case is not None else ""
    if unknown_text and len(started.case_ids) < len(cases.case_ids):
        lines[0] += f" The peak is {unknown_text}."
    if worst_case is not None and start_up.may_peak_later(started):
        has_cut_off = len(started.case_ids) < len(cases.case_ids)
        lines[0] += f" {start_up.LONGER_RUNS_OF_STARTED if has_cut_off else start_up.LONGER_RUNS}"
    return lines


def life_effect_sentences(cases: FinishedCases) -> list[str]:
    """Return sentences on the effects of varied values on the life."""
    name = cases.ranking.candidates[0].columns[0]
    if not cases.has_values(name):
        return []
    hours = cases.values_of(name).astype(float)
    effect_sentences = effects.sentences(
        cases, "life", hours, lambda values: [f"{wording.number_text(value)}{wording.BLANK}h" for value in values]
    )
    clearance_text = wear.initial_clearance_text(cases, cases.layout.life)
    life_sentences = [
        *effect_sentences,
        *([f"The clearance at the start is {clearance_text}."] if clearance_text else []),
    ]
    if not cases.record.get("uncertain"):
        life_sentences.append(
            "The intervals exclude the uncertainty of the wear coefficient: add `uncertain` to the grid to include it."
        )
    return [" ".join(life_sentences)] if life_sentences else []


def end_of_life_limit_sentences(cases: FinishedCases) -> list[str]:
    """Return whether the cases meet the limits at the end of the life, the state that their figures describe."""
    limits = cases.limits
    if not limits:
        return []
    margins = cases.values_of(verdict.MARGIN).astype(float)
    count, exceeding = len(margins), int((~(margins >= 0.0)).sum())
    limit_texts = [cases.limit_label(limit) for limit in limits]
    limits_text = (
        wording.sentence_list(limit_texts) if len(limit_texts) <= MAX_LISTED_LIMITS else f"{len(limit_texts)} limits"
    )
    meeting_text = "every case meets" if count > 1 else "the case meets"
    failing_text = f"{exceeding} of {wording.count_text(count, 'case')} {'does' if exceeding == 1 else 'do'} not meet"
    text = f"At the end of the life, {failing_text if exceeding else meeting_text} the limits: {limits_text}."
    if np.isfinite(margins).any():
        worst_index = int(np.nanargmin(margins))
        exceeded = cases.values_of(verdict.EXCEEDED)[worst_index] or ""
        margin = verdict.margin_text(float(margins[worst_index]), limits, exceeded)
        text += f" Smallest margin there: {margin}{cases.setting_text(worst_index)}."
        text += " ".join(["", *verdict.small_margin_sentences(float(margins[worst_index]))])
    return [text]


def extreme_sentences(cases: FinishedCases) -> list[str]:
    """Return the part of the answer that needs only the cases with the extremes of each column."""
    if not len(cases.case_ids):
        return []
    force_sentences = (
        (*peak_force_sentences(cases), *position_error_sentences(cases)) if cases.ranking.question == "force" else ()
    )
    return [*force_sentences, *figure_range_sentences(cases)]


def run_length_sentences(cases: FinishedCases) -> list[str]:
    """Return sentences on how long the cases ran under `until`, and on how many did not reach its accuracy."""
    if not cases.has_values(RUN_LENGTH_COLUMN):
        return []
    fewest, most = (
        f"{cases.values_of(RUN_LENGTH_COLUMN)[index]:.0f}" for index in cases.argmin_argmax(RUN_LENGTH_COLUMN)
    )
    text = f"A case ran {fewest}{f' to {most}' if most != fewest else ''} revolutions."
    count, unsettled_count = len(cases.case_ids), int(np.sum(cases.values_of("settled") == 0))
    accuracy_sentence = "" if unsettled_count else "Each reached its accuracy or a periodic motion."
    if unsettled_count:
        cases_text = wording.count_text(count, "case")
        accuracy_sentence = f"{unsettled_count} of {cases_text} reached neither the accuracy nor a periodic motion."
    return [f"{text} {accuracy_sentence}"]


def largest_force_sentences(cases: FinishedCases) -> list[str]:
    """Return sentences on the largest normal force and the inputs that affect it most."""
    worst_case = cases.worst_case(case_ranking.force_ranking(cases.layout))
    if worst_case is None:
        return []
    peak_column = worst_case.columns[0]
    effect_sentences = effects.sentences(
        cases,
        cases.column_label(peak_column),
        cases.values_of(peak_column).astype(float),
        partial(cases.format_values, peak_column),
    )
    return [
        *peak_force_sentences(cases),
        *([" ".join(effect_sentences)] if effect_sentences else []),
        *_restitution_sentences(cases),
    ]


def peak_force_sentences(cases: FinishedCases) -> list[str]:
    """Return sentences on the largest normal force and the load over the largest reaction without clearance."""
    worst_case = cases.worst_case(case_ranking.force_ranking(cases.layout))
    if worst_case is None:
        return []
    index, (peak_column, *_), joint = worst_case
    text = (
        f"Largest normal force{cases.joint_text(joint)}: "
        f"{cases.figure_text(peak_column, index)}{cases.setting_text(index)}{cases.case_text(index)}."
    )
    ratio_column, load_column = f"{joint}_force_peak_ratio", f"{joint}_load_peak"
    if cases.has_values(ratio_column) and np.isfinite(cases.values_of(ratio_column)[index]):
        is_load_larger = (
            cases.has_values(load_column) and cases.values_of(load_column)[index] > cases.values_of(peak_column)[index]
        )
        subject = "With friction, the load" if is_load_larger else "It"
        text += f" {subject} is {cases.figure_text(ratio_column, index)} times the largest reaction without clearance."
    return [text]


def _restitution_sentences(cases: FinishedCases) -> list[str]:
    """Return for each joint the largest difference of measured and requested restitution, if it varies."""
    lines = []
    for joint in cases.layout.joints:
        column, path = f"{joint.name}_restitution", f"joints.{wording.joint_name(joint.name)}.contact.restitution"
        if path not in cases.varied_paths or not cases.has_values(column):
            continue
        measured, requested = cases.values_of(column).astype(float), cases.values_of(path).astype(float)
        worst_index = int(np.nanargmax(np.abs(measured - requested)))
        lines.append(
            f"Measured restitution{cases.joint_text(joint.name)} differs from the requested one by at most "
            f"{wording.number_text(abs(float(measured[worst_index] - requested[worst_index])), 2)}: "
            f"{wording.number_text(float(measured[worst_index]))}{cases.setting_text(worst_index)}."
        )
    return lines


def position_error_sentences(cases: FinishedCases) -> list[str]:
    """Return sentences on the largest error of the output's position and the strongest effect on it."""
    error_column = next((column.name for column in cases.layout.columns if column.figure == "error_max"), "")
    if not error_column or not cases.has_values(error_column):
        return []
    worst_index, hardest_case = (
        cases.argmin_argmax(error_column)[1],
        cases.worst_case(case_ranking.force_ranking(cases.layout)),
    )
    location = (
        cases.difference_text(worst_index, hardest_case.case_index) if hardest_case else cases.setting_text(worst_index)
    )
    text = f"Largest {cases.layout.output} error: {cases.figure_text(error_column, worst_index)}{location}."
    return [" ".join([text, *_strongest_effect_sentences(cases, error_column)])]


def _strongest_effect_sentences(cases: FinishedCases, name: str) -> list[str]:
    """Return the strongest effect on a column, with 'it' as its subject."""
    values = cases.values_of(name).astype(float)
    return effects.sentences(cases, effects.FIGURE_PRONOUN, values, partial(cases.format_values, name), 1)


def limit_sentences(cases: FinishedCases) -> list[str]:
    """Return sentences on the designs that meet the limits, the effects on limited figures, and open points of fits."""
    limits = cases.limits
    if not limits:
        return []
    limit_texts = [cases.limit_label(limit) for limit in limits]
    limits_text = (
        wording.sentence_list(limit_texts) if len(limit_texts) <= MAX_LISTED_LIMITS else f"{len(limit_texts)} limits"
    )
    design_sentences = designs.sentences(cases, limits_text)
    if not design_sentences:
        return []
    lines = [*fits.sentences(cases), " ".join(design_sentences)]
    for limit in _deciding_limits(cases, limits):
        effect_sentences = _limit_effect_sentences(cases, limit, 1 if len(limits) > 1 else effects.MAX_EFFECTS)
        lines += [" ".join(effect_sentences)] if effect_sentences else []
    return lines


def _deciding_limits(cases: FinishedCases, limits: tuple[verdict.Limit, ...]) -> list[verdict.Limit]:
    """Return the limits that most cases exceed; if none is exceeded, the limit with the smallest margin."""
    columns = {
        name: cases.values_of(name).astype(float) for limit in limits for name in (limit.column, limit.times) if name
    }
    assessed_limits = [limit for limit in limits if np.isfinite(limit.margin(columns)).any()]
    exceeded_limits = sorted(
        (limit for limit in assessed_limits if limit.is_exceeded(columns).any()),
        key=lambda limit: -limit.is_exceeded(columns).sum(),
    )
    nearest_limits = sorted(assessed_limits, key=lambda limit: float(np.nanmin(limit.margin(columns))))[:1]
    return exceeded_limits[:MAX_LISTED_LIMITS] or nearest_limits


def _limit_effect_sentences(cases: FinishedCases, limit: verdict.Limit, max_effects: int) -> list[str]:
    """Return the effects on a limited figure or, for a relative limit, on its ratio to the other column."""
    values, name = cases.values_of(limit.column).astype(float), cases.column_label(limit.column)
    if not limit.times:
        return effects.sentences(cases, name, values, partial(cases.format_values, limit.column), max_effects)
    with np.errstate(all="ignore"):
        ratios = values / cases.values_of(limit.times).astype(float)
    ratios = np.where(np.isfinite(ratios), ratios, np.nan)
    label = f"{name} over {cases.column_label(limit.times)}"
    return effects.sentences(
        cases, label, ratios, lambda numbers: [wording.number_text(number) for number in numbers], max_effects
    )


def figure_range_sentences(cases: FinishedCases) -> list[str]:
    """Return sentences on the range of each user-defined figure and the strongest effect on it."""
    lines = []
    for name in cases.record.get("figures") or {}:
        values = cases.values_of(name)
        if np.isfinite(values).any():
            low, high = (
                cases.figure_text(name, int(arg_extreme(values))) for arg_extreme in (np.nanargmin, np.nanargmax)
            )
            range_text = " to ".join(dict.fromkeys((low, high)))
            text = f"{labels.capitalise(cases.column_label(name))}: {range_text}."
            lines.append(
                " ".join(
                    [
                        text,
                        *_accepted_range_sentences(cases, name),
                        *_strongest_effect_sentences(cases, name),
                        *_unworn_limit_sentences(cases, name),
                    ]
                )
            )
    return lines


def _accepted_range_sentences(cases: FinishedCases, name: str) -> list[str]:
    """Return the range of a figure in the designs that meet the limits, if there are others; else []."""
    values, accepted_fits = cases.values_of(name).astype(float), fits.accepted_cases(cases)
    accepted = designs.is_in_accepted_design(cases) if accepted_fits is None else accepted_fits
    if not accepted.any() or accepted.all() or not np.isfinite(values[accepted]).any():
        return []
    accepted_values = values[accepted]
    range_text = " to ".join(
        dict.fromkeys(cases.format_values(name, [float(np.nanmin(accepted_values)), float(np.nanmax(accepted_values))]))
    )
    where = "Where the limits are met" if accepted_fits is None else f"For {fits.accepted_text(cases)}"
    return [f"{where}: {range_text}."]


def _unworn_limit_sentences(cases: FinishedCases, name: str) -> list[str]:
    """Return the reservation on a figure of wear in a grid with limits if all cases are known, else []."""
    is_of_wear = "_wear_" in str(cases.record["figures"][name])
    is_reserved = is_of_wear and cases.limits and cases.ranking.question != "life"
    return [UNWORN] if is_reserved and cases.is_complete else []
