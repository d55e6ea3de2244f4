"""The one place that words an answer: each rule yields its sentences from the values of the answer, or none."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from ..language import wording
from . import figure_sentences
from .judge import DIFFERS, FALLS, MIN_DIFFERENCE, MIXED, NONE, NOT_RUN, RISES
from .verdict import capitalise
from .words import (
    MAX_LENGTH,
    MAX_LINES,
    PERCENT,
    Answer,
    Rule,
    Words,
    every_text,
    from_to,
    in_brackets,
    listed,
    share_text,
    varied_values,
)

SMALL_MARGIN = 0.1  # margins below this are not certain
CONVERGED = 0.01  # relative difference of coarser numerics up to which a figure is converged
MAX_EFFECTS = 2  # effects on one figure
MAX_BETWEEN = 3  # medians between both ends that an effect lists
MAX_FIGURES = 2  # limited figures whose effects are named
MAX_GAPS = 3  # undecided conditions of a design that are listed
MAX_SHARES = 2  # designs whose draws are counted
LONGER_IS_FINER = ("simulate.revolutions", "simulate.time", "simulate.cycles")


def sentences(answer: Answer, words: Words) -> list[str]:
    """Return the sentences of an answer, the most important first: at most MAX_LINES lines of MAX_LENGTH characters."""
    lines: list[str] = []
    first, *others = RULES[answer["question"]]
    for rule in (first, figure_sentences.branch_sentences, *others, figure_sentences.found_sentences):
        lines += map(capitalise, rule(answer, words))
    return [shortened(line) for line in dict.fromkeys(lines)][:MAX_LINES]


def shortened(line: str) -> str:
    """Return a line of at most MAX_LENGTH characters; what is left out is marked."""
    return line if len(line) <= MAX_LENGTH else f"{line[: MAX_LENGTH - 4].rsplit(' ', 1)[0]} ..."


def state(answer: Answer, words: Words) -> Iterator[str]:
    """Say that a run is not complete."""
    if not answer["complete"]:
        yield "The run is not complete: the answer covers the cases that are finished so far."


def verdict(answer: Answer, words: Words) -> Iterator[str]:
    """Say how many designs meet the limits under every condition; without designs, how many cases do."""
    designs, total, counts = answer["designs"], answer["designs_total"], answer["cases"]
    judged = sum(counts[name] for name in ("met", "exceeded", "undecided")) if counts else 0
    if not judged:
        return
    verdicts = answer["verdicts"] if designs else {"meets": counts["met"], "undecided": counts["undecided"]}
    met, open_count = verdicts["meets"], verdicts["undecided"]
    noun, limits = words.limits_text()
    limits_everywhere, all_of = f"{noun}{every_text(answer, words)}{limits}", "both" if total == 2 else f"all {total}"
    undecided, verb = f"; {open_count} undecided" if open_count else "", "meets" if met == 1 else "meet"
    if not designs:
        yield f"{met} of {judged} cases {verb} {noun}{limits}{undecided}."
    elif total == 1:
        (design,) = designs
        subject = "the machine" if design["conditions"] > 1 else "the case"
        exceeding = f" ({design['exceeded']} of {design['conditions']} exceed)" if design["conditions"] > 1 else ""
        yield {
            "meets": f"{subject} meets {limits_everywhere}.",
            "exceeds": f"{subject} does not meet {limits_everywhere}{exceeding}.",
            "undecided": f"Whether {subject} meets {noun}{every_text(answer, words)} is undecided{limits}.",
        }[design["verdict"]]
    elif met == total:
        yield f"{capitalise(all_of)} designs meet {limits_everywhere}."
    elif open_count == total:
        yield f"No design is known to meet {limits_everywhere}; {all_of} are undecided."
    elif not met:
        yield f"None of {total} designs meets {limits_everywhere}{undecided}."
    else:
        yield f"{met} of {total} designs {verb} {limits_everywhere}{undecided}."


def share(answer: Answer, words: Words) -> Iterator[str]:
    """Say which share of the draws of a sample exceeds a limit; the interval is that of the share that meets them."""
    designs = [design for design in answer["designs"] if "share" in design]
    if not designs or is_paired(answer):
        return
    if len(designs) > MAX_SHARES:
        items = [f"{words.design(design)} {share_text(design['share']['met'])}" for design in designs]
        yield f"Draws that meet the limits: {listed(items, MAX_LENGTH - 30)}."
        return
    for design in designs:
        part, interval, limits = design["share"], "", words.limits_text()[1]
        where = f"{words.design(design)}: " if design["values"] else ""
        if part["undecided"] == 1.0:
            yield f"{where}none of {part['draws']} draws is known to meet or exceed the limits{limits}."
            continue
        undecided = f"; {share_text(part['undecided'])} are undecided" if part["undecided"] else ""
        if part["low"] is not None:
            ends = (part["low"], part["high"]) if part["undecided"] else (1.0 - part["high"], 1.0 - part["low"])
            low, high = (share_text(end).removesuffix(PERCENT) for end in ends)
            of_what = "meeting them" if part["undecided"] else "exceeding one"
            interval = f" ({low} to {high}{PERCENT} {of_what}, 95{PERCENT} interval)"
        exceeded = f"{share_text(part['exceeded'])} of {part['draws']} draws exceed a limit"
        yield f"{where}{exceeded}{interval}{undecided}{limits}."


def boundary(answer: Answer, words: Words) -> Iterator[str]:
    """Say up to where the limits are met, which designs meet them best, or which comes nearest."""
    designs = answer["designs"]
    if not designs or any("share" in design for design in designs):
        return  # the shares say more
    met = [design for design in designs if design["verdict"] == "meets"]
    if answer["designs_total"] == 1 or not designs[0]["values"]:
        if text := words.margin(designs[0]):
            lead = "Smallest" if designs[0]["verdict"] == "meets" else "Worst:"
            yield f"{lead} {text}{at_worst(answer, words, designs[0])}."
    elif edge := _edge(answer):
        good, bad, upwards = edge
        met_range = f"{'up to' if upwards else 'from'} {words.design(good)}{in_brackets(words.margin(good))}"
        yield f"Met {met_range}; {words.design(bad)} has {words.margin(bad)}{at_worst(answer, words, bad)}."
    elif met:
        items = [f"{words.design(design)}{in_brackets(words.margin(design))}" for design in met]
        lead = "Met by" if len(met) < answer["designs_total"] else "Best first:"
        yield f"{lead} {listed(items, MAX_LENGTH - 15)}."
    elif nearest := next((design for design in designs if design["verdict"] == "exceeds"), None):
        yield f"Nearest: {words.design(nearest)}, {words.margin(nearest)}{at_worst(answer, words, nearest)}."
    smallest = min((design["margin"] for design in met if design["margin"] is not None), default=1.0)
    if met and smallest < SMALL_MARGIN:
        text = f"{wording.short_number_text(100.0 * smallest, 3)}{PERCENT}"
        yield f"A margin of {text} is not certain: other laws or longer runs may use it up."


def at_worst(answer: Answer, words: Words, design: Mapping[str, Any]) -> str:
    """Return ' at crank speed 2000 rpm', the conditions of a design's worst case, or ''."""
    setting = words.setting(answer.get("settings", {}).get(design["worst"]) or {}, design["worst"])
    return f" at {setting}" if setting else ""


def _edge(answer: Answer) -> tuple[Mapping[str, Any], Mapping[str, Any], bool] | None:
    """Return the last design that meets the limits, the next one, and whether smaller values meet them.

    None unless a single number is chosen and the verdict changes once; undecided designs count as not met.
    """
    designs = answer["designs"]
    paths = {path for design in designs for path in design["values"]}
    if len(paths) != 1 or answer["designs_total"] != len(designs):
        return None
    (path,) = paths
    order = answer.get("order", {}).get(path)
    values = [design["values"].get(path) for design in designs]
    if order is None and any(not isinstance(value, float) for value in values):
        return None
    place = (lambda design: order.index(design["values"][path])) if order else (lambda design: design["values"][path])
    ascending = sorted(designs, key=place)
    is_met = [design["verdict"] == "meets" for design in ascending]
    changes = [index for index in range(len(is_met) - 1) if is_met[index] != is_met[index + 1]]
    if len(changes) != 1:
        return None
    low, high = ascending[changes[0]], ascending[changes[0] + 1]
    good, bad = (low, high) if is_met[changes[0]] else (high, low)
    return (good, bad, good is low) if bad["verdict"] == "exceeds" else None


def missing(answer: Answer, words: Words) -> Iterator[str]:
    """Say what is missing of undecided designs: conditions that were not run, failed, or lack a figure."""
    designs = [design for design in answer["designs"] if design["missing"]]
    if not designs:
        return
    if is_paired(answer):
        section = next((name for name in ("zip", "sample") if words.record.get(name)), "cases")
        yield (
            f"Every row of `{section}` has its own condition, so no design was run under all of them; name what you "
            "choose in `roles`."
        )
        return
    designs = [design for design in designs if design["verdict"] == "undecided"]  # what exceeds is decided
    if not designs:
        return
    groups: dict[tuple, tuple[Mapping[str, Any], str, list[Mapping[str, Any]]]] = {}
    for design in designs:
        for lack in design["missing"]:
            key = (*lack["values"].items(), lack["why"])
            groups.setdefault(key, (lack["values"], lack["why"], []))[2].append(design)
    items = [_missing_text(answer, words, *group) for group in groups.values()]
    if len(designs) == 1 and (total := designs[0]["missing_total"]) > MAX_GAPS:
        yield f"Undecided: {total} of {designs[0]['conditions']} conditions, such as: {items[0]}."
        return
    yield f"Undecided: {listed(items, MAX_LENGTH - 12)}."


def _missing_text(
    answer: Answer, words: Words, values: Mapping[str, Any], why: str, designs: Sequence[Mapping[str, Any]]
) -> str:
    names = [words.design(design) for design in designs if design["values"]]
    total = answer["designs_total"]
    everyone = "both designs" if total == 2 else f"all {total} designs"
    several = everyone if len(designs) == total else f"{len(names)} designs"
    subject = (names[0] if len(names) == 1 else several) if names else "it" if values else "the case"
    at = f" at {words.setting(values)}" if values else ""
    if why == NOT_RUN:
        return f"{subject} {'was' if len(names) < 2 else 'were'} not run{at}"
    if why.endswith(" is null"):
        column = why.removesuffix(" is null")
        return f"{words.figure(column)} of {subject} is null{at}"
    return f"{subject} failed{at} ({why})"


def is_paired(answer: Answer) -> bool:
    """Return whether every case has a condition of its own, so that no design has more than one."""
    designs = answer["designs"]
    run = [design["met"] + design["exceeded"] + design["undecided"] for design in designs]
    return (
        len(designs) > 1
        and len(designs) == answer["designs_total"]
        and all(count == 1 for count in run)
        and all(design["conditions"] == len(designs) for design in designs)
    )


def convergence(answer: Answer, words: Words) -> Iterator[str]:
    """Say whether figures at coarser numerics agree with the finest ones, which decide."""
    largest: dict[tuple[str, str], Mapping[str, Any]] = {}
    for entry in answer["convergence"]:
        key = entry["path"], entry["figure"]
        if key not in largest or size_of(entry) > size_of(largest[key]):
            largest[key] = entry
    for (path, figure), entry in list(largest.items())[:2]:
        finest, coarse = words.figures(figure, [entry["finest"], entry["next"]])
        which = "longest run" if path in LONGER_IS_FINER else f"finest {words.axis_name(path)}"
        difference, name = f"{wording.number_text(100.0 * size_of(entry), 2)}{PERCENT}", words.figure(figure)
        if size_of(entry) <= CONVERGED:
            yield f"The {which} decides; coarser ones differ in {name} by at most {difference}."
        else:
            setting = words.setting({path: entry["value"]})
            yield f"The {which} decides ({name} {finest}); {setting}: {coarse}, {difference} off, not converged."


def size_of(entry: Mapping[str, Any]) -> float:
    """Return the relative difference of a convergence entry; 1 where the finest figure is 0."""
    return 1.0 if entry["difference"] is None else float(entry["difference"])


def effect_lines(answer: Answer, words: Words) -> Iterator[str]:
    """Say how figures change with what varies, the strongest effect first."""
    for figure in deciding_figures(answer):
        effects = [effect for effect in answer["effects"] if effect["figure"] == figure]
        clear = [effect for effect in effects if effect.get("trend", effect["verdict"]) in (RISES, FALLS, DIFFERS)]
        texts = [effect_text(answer, words, effect, subject=not index) for index, effect in enumerate(clear)]
        texts = [text for text in texts if text]
        if texts:
            yield f"{listed(texts[:MAX_EFFECTS], MAX_LENGTH - 1, more='')}."
        others = {
            verdict_: words.axes(
                [effect["path"] for effect in effects if effect.get("trend", effect["verdict"]) == verdict_]
            )
            for verdict_ in (MIXED, NONE)
        }
        mixed = f"{words.figure(figure)} has no steady trend with {_short_list(others[MIXED])}" if others[MIXED] else ""
        clauses = [mixed] if mixed else []
        if others[NONE] and words.is_zero(figure):
            clauses += [f"{words.figure(figure)} is 0 in every finished case"]
        elif others[NONE]:
            verb, it = "changes" if len(others[NONE]) == 1 else "change", "it" if clauses else words.figure(figure)
            clauses += [f"{_short_list(others[NONE])} {verb} {it} by at most {share_text(MIN_DIFFERENCE)}"]
        if clauses and (not texts or figure == deciding_figures(answer)[0]):
            yield f"{'; '.join(clauses)}."


def _short_list(names: Sequence[str]) -> str:
    """Return the first names, as many as fit into a clause, and the number of the others."""
    for count in range(len(names), 0, -1):
        left = len(names) - count
        others = ["another" if left == 1 else f"{left} others"] if left else []
        text = wording.sentence_list([*names[:count], *others])
        if len(text) <= MAX_LENGTH // 3:
            break
    return text


def deciding_figures(answer: Answer) -> list[str]:
    """Return the figures that lead: those of exceeding designs first, then those with the smallest margins."""
    figures = list(dict.fromkeys(effect["figure"] for effect in answer["effects"]))
    order = {verdict_: rank for rank, verdict_ in enumerate(("exceeds", "undecided", "meets"))}
    ranked = sorted(answer["designs"], key=lambda design: order[design["verdict"]])
    leading = dict.fromkeys(design["limit"] for design in ranked if design["limit"] in figures)
    return [*dict.fromkeys([*leading, *figures])][:MAX_FIGURES]


def effect_text(answer: Answer, words: Words, effect: Mapping[str, Any], *, subject: bool) -> str:
    """Return an effect: 'force peak rises from 64.5 to 442 N as crank speed grows from 500 to 2000 rpm'."""
    figure, path = effect["figure"], effect["path"]
    start, end = words.figures(figure, [effect["from"], effect["to"]])
    name = words.figure(figure) if subject else "it"
    if effect["verdict"] == DIFFERS:
        low, high = words.value(path, effect["lowest"]), words.value(path, effect["highest"])
        return f"{name} is smallest, {start}, with {words.axis_name(path)} {low} and largest, {end}, with {high}"
    ends = answer.get("ends", {}).get(path)
    changes = effect.get("trend", effect["verdict"])
    turns = f", but not steadily in {effect['reversed']} of {effect['pairs']} comparisons" if "trend" in effect else ""
    if effect["method"] == "ranks":
        return f"{name} {effect['verdict']} with {words.axis_name(path)}, {from_to(start, end)} over its quarters"
    if effect.get("with"):
        tied = [(words.axis_name(each), (*varied_values(words.record, each),)) for each in (path, *effect["with"])]
        (axis, joints, _), *others = wording.of_joints(tied)
        span = f" {from_to(*(words.value(path, value) for value in ends))}" if ends else ""
        names = wording.sentence_list([f"{other}{in_joints}" for other, in_joints, _ in others])
        follows = f" and {names} {'changes' if len(others) == 1 else 'change'} with it" if others else ""
        return f"{name} {changes} {from_to(start, end)} as {axis}{joints} grows{span}{follows}{turns}"
    grows = f" as {words.axis_name(path)} grows"
    between = effect.get("medians", [])[1:-1]
    if start == end:
        return ""
    if 0 < len(between) <= MAX_BETWEEN and None not in between and subject:
        texts = [
            text.partition(wording.BLANK)[0] for text in words.figures(figure, [effect["from"], *between, effect["to"]])
        ]
        start = f"{start} over {', '.join(texts[1:-1])}" if start == texts[0] else start
    grows += f" {from_to(*(words.value(path, value) for value in ends))}" if ends else ""
    return f"{name} {changes} {from_to(start, end)}{grows}{turns}"


def film(answer: Answer, words: Words) -> Iterator[str]:
    """Give the thinnest film, and the combinations whose films stay safe under every condition."""
    entries = figure_sentences.extremes_of(answer, "film_thickness_min", words)
    if not entries:
        return
    safe = answer.get("film")
    if safe and safe["total"] > 1:
        items = [f"{words.design(design)}{in_brackets(design['text'])}" for design in safe["designs"]]
        safe_designs = f": {listed(items, 60)}" if items else ""
        undecided = f"; {safe['undecided']} undecided" if safe["undecided"] else ""
        verb = f"{'keep' if safe['count'] > 1 else 'keeps'} its film {safe['criterion']}{every_text(answer, words)}"
        yield f"{safe['count'] or 'none'} of {safe['total']} combinations {verb}{safe_designs}{undecided}."
        yield from missing({**answer, "designs": safe["missing"], "designs_total": safe["total"]}, words)
    entry = min(entries, key=lambda candidate: candidate["smallest"]["value"])
    (text,) = words.figures(entry["figure"], [entry["smallest"]["value"]])
    yield f"Thinnest film: {text}{figure_sentences.place_text(words, entry['smallest'])}."


def worded(key: str) -> Rule:
    """Return the rule that says a sentence of the answer as it is."""
    return lambda answer, words: [answer[key]] if answer.get(key) else []


def irregular(answer: Answer, words: Words) -> Iterator[str]:
    """Warn that longer runs exceed limits on peaks more often where the motion is not periodic."""
    if count := answer.get("irregular"):
        motions = f"{count} of {answer['finished']} motions"
        yield f"{motions} are not periodic: longer runs exceed limits on peaks more often."


def suggestion(answer: Answer, words: Words) -> Iterator[str]:
    """Suggest a limit for a grid without limits."""
    if limit := answer.get("suggestion"):
        yield f"No limits are set. To judge the cases, add for example: limits: {{{limit}}}"


laws = worded("laws")  # whether other laws change the verdict on the deciding case
fits = worded("fits")  # what the verdicts on fits hold for: their mean clearances, and the ends that are covered
JUDGED = (state, verdict, share, missing, boundary, fits)
OWN = (figure_sentences.own_figure_sentences, figure_sentences.vibration_sentences)
FORCES = (figure_sentences.force_sentences, figure_sentences.error_sentences)
TOUCH = (figure_sentences.touch, figure_sentences.indentation_sentences)
WEAR, LOSS = figure_sentences.wear_sentences, figure_sentences.loss_sentences
WORN = (WEAR, figure_sentences.indentation_sentences)
RULES: dict[str, tuple[Rule, ...]] = {
    "limits": (*JUDGED, convergence, *TOUCH, laws, effect_lines, *OWN, LOSS, WEAR),
    "sample": (state, share, irregular, missing, effect_lines, *OWN, WEAR),
    "refine": (*JUDGED, figure_sentences.added_sentences, convergence, effect_lines),
    "seek": (state, figure_sentences.seek_sentences),
    "optimise": (state, figure_sentences.optimise_sentences),
    "identify": (state, figure_sentences.identify_sentences),
    "life": (state, figure_sentences.life_sentences, verdict, boundary, laws, effect_lines, *OWN),
    "start-up": (state, figure_sentences.start_up_sentences, *FORCES, laws, effect_lines, *OWN, *WORN, suggestion),
    "film": (state, film, effect_lines, LOSS, figure_sentences.force_sentences, laws, *OWN, suggestion),
    "force": (state, *FORCES, convergence, laws, effect_lines, *WORN, *OWN, suggestion),
}
