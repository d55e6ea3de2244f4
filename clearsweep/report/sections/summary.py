"""The cards at the top of the page: verdict, margin, worst case, force, error, life, and what drives them."""

from collections.abc import Mapping
from typing import Any

from ...answers import blocks, figure_sentences, sentences
from ...answers.words import Words, every_text, factor_text, share_text
from ...language import wording
from ..blocks.section import Cards, Section
from ..data.answered import answer_of_study, words_of
from ..data.study import Study
from ..samples import counts
from . import identified, seek

MAX_CARDS = 7  # concepts on the first screen
Card = tuple[str, str, str]  # name, value with unit, reference


def sections(study: Study) -> list[Section]:
    """Return the cards of a run."""
    return [Section("summary", "", [Cards(_cards(study))])]


def _cards(study: Study) -> list[Card]:
    """Return name, value with unit, and reference of each card."""
    finished, failed = counts.finished_and_failed(study)
    missing = study.run.grid.get("counts", {}).get("missing", 0)
    note = (f"{failed} failed" if failed else "none failed") + (f", {missing} not run yet" if missing else "")
    finished_card = ("Cases finished", f"{finished} of {finished + failed + missing}", note)
    cards = [] if study.cases.empty else _answer_cards(study)
    if study.run.marks():
        sample_note = "a random sample, and the cases with the smallest and the largest value of each figure"
        cards.append(("Shown on this page", f"{len(study.cases) + len(study.failed)} cases", sample_note))
    return [finished_card, *cards] if failed or missing else [*cards, finished_card]


def _answer_cards(study: Study) -> list[Card]:
    """Return the cards that the answer fills, in the order of their weight."""
    answer = answer_of_study(study)
    if answer["question"] == "identify":
        return identified.parameter_cards(study)
    cards = [*(seek.answer_cards(study) if answer["question"] == "seek" else ()), *_verdict_cards(study, answer)]
    figures = [
        ("life_hours", "Shortest life", "smallest"),
        ("start_up_time", "Start-up time", "largest"),
        ("film_thickness_min", "Thinnest film", "smallest"),
        ("force_peak", "Largest normal force", "largest"),
        ("error_max", f"Largest {study.run.layout.output} error", "largest"),
    ]
    for figure, name, end in figures:
        cards += _extreme_cards(study, answer, (figure, name, end))
    return [*cards[: MAX_CARDS - 1], *_driver_cards(study, answer)]


def _verdict_cards(study: Study, answer: Mapping[str, Any]) -> list[Card]:
    """Return the cards on the verdict and on the margin of the best or the nearest design."""
    designs, words = answer["designs"], words_of(study)
    if not designs:
        return []
    best, every = designs[0], every_text(answer, words).strip()
    if share := best.get("share"):
        return [("Exceeds a limit", share_text(share["exceeded"]), f"of {best['conditions']} draws")]
    if answer["designs_total"] == 1:
        cards = [("Verdict", f"{best['verdict']} the limits".replace("undecided the limits", "undecided"), every)]
    else:
        met, open_count = (answer["verdicts"][name] for name in ("meets", "undecided"))
        note = "; ".join(filter(None, (every, f"{open_count} undecided" if open_count else "")))
        cards = [("Designs within the limits", f"{met} of {answer['designs_total']}", note)]
    text = words.margin(best)
    where = "; ".join(
        filter(None, (words.setting(best["values"]), sentences.at_worst(answer, words, best).removeprefix(" at ")))
    )
    if not text:
        return cards
    if text.startswith("margin "):
        name = "Largest margin" if len(designs) > 1 else "Smallest margin"
        return [*cards, (name, text.removeprefix("margin "), where)]
    value, _, figure = text.partition(" of ") if " times the limit of " in text else (text, "", "")
    return [*cards, ("Nearest design" if len(designs) > 1 else "Worst case", value, f"{figure}; {where}".strip("; "))]


def _extreme_cards(study: Study, answer: Mapping[str, Any], figure: tuple[str, str, str]) -> list[Card]:
    """Return the card on the worst value of a figure over all joints; [] if no case has it."""
    (name, title, end), words = figure, words_of(study)
    entries = figure_sentences.extremes_of(answer, name, words)
    if not entries:
        return []
    sign = -1.0 if end == "smallest" else 1.0
    worst = max(entries, key=lambda entry: sign * entry[end]["value"])
    value = worst[end]["value"]
    hours = f"{wording.number_text(value)}{wording.BLANK}h"
    text = hours if name == "life_hours" else words.figures(worst["figure"], [value])[0]
    if name == "force_peak" and not value:
        text = "the surfaces never touch"
    ratio = worst[end].get("ratio")
    notes = [words.setting(worst[end]["values"], worst[end]["case"])]
    notes += [f"{factor_text(ratio)} times the ideal"] if ratio else []
    notes += [worst[end]["body"]] if worst[end].get("body") else []
    joint = next((column.joint for column in study.run.layout.columns if column.name == worst["figure"]), "")
    notes += [f"joint {wording.joint_name(joint)}"] if joint and len(study.joints) > 1 else []
    return [(title, text, "; ".join(filter(None, notes)))]


def _driver_cards(study: Study, answer: Mapping[str, Any]) -> list[Card]:
    """Return the card on what drives the leading figure; [] without a clear effect."""
    words = words_of(study)
    for figure in sentences.deciding_figures(answer)[:1]:
        for effect in answer["effects"]:
            if effect["figure"] == figure and effect["verdict"] in (blocks.RISES, blocks.FALLS, blocks.DIFFERS):
                text = sentences.effect_text(answer, words, effect, subject=True)
                return [(f"{words.figure(figure).capitalize()} depends on", _axis_names(words, effect), text)]
    return []


def _axis_names(words: Words, effect: Mapping[str, Any]) -> str:
    """Return the name of the axis of an effect, with all paths that vary together."""
    return wording.sentence_list([words.axis_name(path) for path in (effect["path"], *effect.get("with", ()))])
