"""Sentences that answer the question of a grid, the same on the page and in the last lines of a run."""

from functools import partial

import numpy as np

from ..language import wording
from . import case_ranking, designs, effects, films, fits, labels, sampled, start_up, verdict, wear
from .cases import MAX_NAMED_AXES, Cases

RUN_LENGTH = "revolutions_run"  # column
LISTED_LIMITS = 2  # limits that a sentence names

__all__ = ["MAX_NAMED_AXES", "Cases", "question_sentences", "sentences"]


def sentences(cases: Cases) -> list[str]:
    """Return the answer to the question of a grid, then the range of the figures that it defines."""
    if not len(cases.case_ids):
        return []
    return [*question_sentences(cases), *figure_ranges(cases), *run_lengths(cases)]


def question_sentences(cases: Cases) -> list[str]:
    """Return the answer to the leading question: a random sample, life, start-up, limits, film or force."""
    if sampled.is_one_sample(cases.record):
        return sampled.sentences(cases)
    by_question = {
        "life": (life_effects, limits_at_end),
        "start-up": (start_up.sentences, start_forces),
        "limits": (limit_sentences, films.losses, start_up.sentences),
        "film": (films.sentences,),
        "force": (largest_force, position_error),
    }
    return [line for answer in by_question.get(cases.ranking.question, (start_up.sentences,)) for line in answer(cases)]


def start_forces(cases: Cases) -> list[str]:
    """Return the largest force until the start-up time and in the whole run, and the error, of the started cases."""
    of_started = start_up.started(cases)
    worst = of_started.worst(case_ranking.force_ranking(of_started.layout))
    lines = [*peak_force(of_started), *position_error(of_started)]
    if len(of_started.case_ids) < len(cases.case_ids):
        lines = [line.replace(": ", " of the started cases: ", 1) for line in lines]
    force_until_start = start_up.until_start(of_started, worst[2]) if worst is not None else ""
    if force_until_start:
        lines[0] = f"{lines[0].replace(': ', ', in the whole run: ', 1)} Until the start-up time: {force_until_start}."
    unknown_text = start_up.force_of_cut_off(cases, worst[1][0]) if worst is not None else ""
    if unknown_text and len(of_started.case_ids) < len(cases.case_ids):
        lines[0] += f" The peak is {unknown_text} until the end of the run."
    return lines


def life_effects(cases: Cases) -> list[str]:
    """Return sentences on the effects of varied values on the life."""
    name = cases.ranking.candidates[0].columns[0]
    if not cases.has(name):
        return []
    hours = cases.column(name).astype(float)
    effect_sentences = effects.sentences(
        cases, "life", hours, lambda values: [f"{wording.plain(value)}{wording.BLANK}h" for value in values]
    )
    clearance_text = wear.starting_clearance(cases, cases.layout.life)
    life_sentences = [
        *effect_sentences,
        *([f"The clearance at the start is {clearance_text}."] if clearance_text else []),
    ]
    lines = [" ".join(life_sentences)] if life_sentences else []
    if "uncertain" not in cases.record or not cases.record["uncertain"]:
        lines.append(
            "The intervals exclude the wear coefficient, often uncertain by a factor of 3 to 10: see `uncertain`."
        )
    return lines


def limits_at_end(cases: Cases) -> list[str]:
    """Return whether the cases meet the limits at the end of the life, the state that their figures describe."""
    limits = cases.limits
    if not limits:
        return []
    margins = cases.column(verdict.MARGIN).astype(float)
    count, exceeding = len(margins), int((~(margins >= 0.0)).sum())
    limit_texts = [cases.limit_label(limit) for limit in limits]
    listed = wording.sentence_list(limit_texts) if len(limit_texts) <= LISTED_LIMITS else f"{len(limit_texts)} limits"
    meeting_text = "every case meets" if count > 1 else "the case meets"
    failing_text = f"{exceeding} of {wording.count(count, 'case')} {'does' if exceeding == 1 else 'do'} not meet"
    text = f"At the end of the life, {failing_text if exceeding else meeting_text} the limits: {listed}."
    if np.isfinite(margins).any():
        worst = int(np.nanargmin(margins))
        exceeded = cases.column(verdict.EXCEEDED)[worst] or ""
        margin = verdict.margin_words(float(margins[worst]), limits, exceeded)
        text += f" Smallest margin there: {margin}{cases.setting_text(worst)}."
    return [text]


def extreme_sentences(cases: Cases) -> list[str]:
    """Return the part of the answer that needs only the cases with the extremes of each column."""
    if not len(cases.case_ids):
        return []
    force = (*peak_force(cases), *position_error(cases)) if cases.ranking.question == "force" else ()
    return [*force, *figure_ranges(cases)]


def run_lengths(cases: Cases) -> list[str]:
    """Return sentences on how long the cases ran under `until`, and on how many did not reach its accuracy."""
    if not cases.has(RUN_LENGTH):
        return []
    fewest, most = (f"{cases.column(RUN_LENGTH)[index]:.0f}" for index in cases.extremes(RUN_LENGTH))
    text = f"A case ran {fewest}{f' to {most}' if most != fewest else ''} revolutions."
    count, unsettled = len(cases.case_ids), int(np.sum(cases.column("settled") == 0))
    accuracy_sentence = "" if unsettled else "Each reached its accuracy or a periodic motion."
    if unsettled:
        accuracy_sentence = (
            f"{unsettled} of {wording.count(count, 'case')} reached neither the accuracy nor a periodic motion."
        )
    return [f"{text} {accuracy_sentence}"]


def largest_force(cases: Cases) -> list[str]:
    """Return sentences on the largest normal force and the effects on it."""
    worst = cases.worst(case_ranking.force_ranking(cases.layout))
    if worst is None:
        return []
    name = worst[1][0]
    effect_sentences = effects.sentences(
        cases, cases.label(name), cases.column(name).astype(float), partial(cases.texts, name)
    )
    return [*peak_force(cases), *([" ".join(effect_sentences)] if effect_sentences else []), *_restitutions(cases)]


def peak_force(cases: Cases) -> list[str]:
    """Return sentences on the largest normal force and the load over the largest reaction without clearance."""
    worst = cases.worst(case_ranking.force_ranking(cases.layout))
    if worst is None:
        return []
    index, (peak, *_), joint = worst
    text = (
        f"Largest normal force{cases.joint_text(joint)}: "
        f"{cases.text(peak, index)}{cases.setting_text(index)}{cases.case_text(index)}."
    )
    ratio, load = f"{joint}_force_peak_ratio", f"{joint}_load_peak"
    if cases.has(ratio) and np.isfinite(cases.column(ratio)[index]):
        is_load_larger = cases.has(load) and cases.column(load)[index] > cases.column(peak)[index]
        subject = "With friction, the load" if is_load_larger else "It"
        text += f" {subject} is {cases.text(ratio, index)} times the largest reaction without clearance."
    return [text]


def _restitutions(cases: Cases) -> list[str]:
    """Return for each joint the largest difference of measured and requested restitution, if it varies."""
    lines = []
    for joint in cases.layout.joints:
        column, path = f"{joint.name}_restitution", f"joints.{wording.joint_name(joint.name)}.contact.restitution"
        if path not in cases.axes or not cases.has(column):
            continue
        measured, requested = cases.column(column).astype(float), cases.column(path).astype(float)
        worst = int(np.nanargmax(np.abs(measured - requested)))
        lines.append(
            f"Measured restitution{cases.joint_text(joint.name)} differs from the requested one by at most "
            f"{wording.plain(abs(float(measured[worst] - requested[worst])), 2)}: "
            f"{wording.plain(float(measured[worst]))}{cases.setting_text(worst)}."
        )
    return lines


def position_error(cases: Cases) -> list[str]:
    """Return sentences on the largest error of the output's position and the strongest effect on it."""
    error_column = next((column.name for column in cases.layout.columns if column.figure == "error_max"), "")
    if not error_column or not cases.has(error_column):
        return []
    worst, hardest = cases.extremes(error_column)[1], cases.worst(case_ranking.force_ranking(cases.layout))
    at = cases.at_difference(worst, hardest[0]) if hardest else cases.setting_text(worst)
    text = f"Largest {cases.layout.output} error: {cases.text(error_column, worst)}{at}."
    return [" ".join([text, *_strongest_effect(cases, error_column)])]


def _strongest_effect(cases: Cases, name: str) -> list[str]:
    """Return the strongest effect on a column, with 'it' as its subject."""
    values = cases.column(name).astype(float)
    return effects.sentences(cases, effects.PRONOUN, values, partial(cases.texts, name), 1)


def limit_sentences(cases: Cases) -> list[str]:
    """Return sentences on the designs that meet the limits, the effects on limited figures, and open points of fits."""
    limits = cases.limits
    if not limits:
        return []
    limit_texts = [cases.limit_label(limit) for limit in limits]
    limits_text = (
        wording.sentence_list(limit_texts) if len(limit_texts) <= LISTED_LIMITS else f"{len(limit_texts)} limits"
    )
    design_sentences = designs.sentences(cases, limits_text)
    if not design_sentences:
        return []
    lines = [*fits.sentences(cases), " ".join(design_sentences)]
    for limit in _deciding(cases, limits):
        effect_sentences = _limit_effects(cases, limit, 1 if len(limits) > 1 else effects.MAX_EFFECTS)
        lines += [" ".join(effect_sentences)] if effect_sentences else []
    return lines


def _deciding(cases: Cases, limits: tuple[verdict.Limit, ...]) -> list[verdict.Limit]:
    """Return the limits that most cases exceed; if none is exceeded, the limit with the smallest margin."""
    columns = {
        name: cases.column(name).astype(float) for limit in limits for name in (limit.column, limit.times) if name
    }
    valued = [limit for limit in limits if np.isfinite(limit.margin(columns)).any()]
    exceeded_limits = sorted(
        (limit for limit in valued if limit.fails(columns).any()), key=lambda limit: -limit.fails(columns).sum()
    )
    nearest = sorted(valued, key=lambda limit: float(np.nanmin(limit.margin(columns))))[:1]
    return exceeded_limits[:LISTED_LIMITS] or nearest


def _limit_effects(cases: Cases, limit: verdict.Limit, most: int) -> list[str]:
    """Return the effects on a limited figure or, for a relative limit, on its ratio to the other column."""
    values, name = cases.column(limit.column).astype(float), cases.label(limit.column)
    if not limit.times:
        return effects.sentences(cases, name, values, partial(cases.texts, limit.column), most)
    with np.errstate(all="ignore"):
        ratios = values / cases.column(limit.times).astype(float)
    ratios = np.where(np.isfinite(ratios), ratios, np.nan)
    label = f"{name} over {cases.label(limit.times)}"
    return effects.sentences(cases, label, ratios, lambda numbers: [wording.plain(number) for number in numbers], most)


def figure_ranges(cases: Cases) -> list[str]:
    """Return sentences on the range of each user-defined figure and the strongest effect on it."""
    lines = []
    for name in cases.record.get("figures") or {}:
        values = cases.column(name)
        if np.isfinite(values).any():
            low, high = (cases.text(name, int(arg_extreme(values))) for arg_extreme in (np.nanargmin, np.nanargmax))
            range_text = " to ".join(dict.fromkeys((low, high)))
            text = f"{labels.capital(cases.label(name))}: {range_text}."
            lines.append(" ".join([text, *_range_of_accepted(cases, name), *_strongest_effect(cases, name)]))
    return lines


def _range_of_accepted(cases: Cases, name: str) -> list[str]:
    """Return the range of a figure in the designs that meet the limits, if there are others; else []."""
    values, accepted = cases.column(name).astype(float), designs.accepted(cases)
    if not accepted.any() or accepted.all() or not np.isfinite(values[accepted]).any():
        return []
    accepted_values = values[accepted]
    range_text = " to ".join(
        dict.fromkeys(cases.texts(name, [float(np.nanmin(accepted_values)), float(np.nanmax(accepted_values))]))
    )
    return [f"Where the limits are met: {range_text}."]
