"""Sentences on single figures: forces, errors, lives, starts, films and wear, with the cases of their extremes."""

from collections.abc import Iterator, Mapping
from typing import Any

from ..language import wording
from . import lifetime
from .words import Answer, Sentence, Words, factor_text, in_brackets

MAX_PLACE = 90  # characters of the values of a case; of longer ones its identity stands


def own_figures(answer: Answer, words: Words) -> Iterator[Sentence]:
    """Give the range of the user-defined figures."""
    for name in words.record.get("figures") or {}:
        if entry := extreme(answer, name):
            low, high = words.figures(name, [entry["smallest"]["value"], entry["largest"]["value"]])
            text = low if low == high else f"{low} to {high}"
            yield Sentence("{figure}: {range}.", {"figure": words.figure(name), "range": text})


def extreme(answer: Answer, column: str) -> Mapping[str, Any] | None:
    """Return the entry with the extremes of a column, or None."""
    return next((entry for entry in answer.get("extremes", ()) if entry["figure"] == column), None)


def extremes_of(answer: Answer, figure: str, words: Words) -> list[Mapping[str, Any]]:
    """Return the entries of a figure of all joints."""
    names = {column.name for column in words.layout.columns if column.figure == figure}
    return [entry for entry in answer.get("extremes", ()) if entry["figure"] in names]


def place_text(answer: Answer, words: Words, end: Mapping[str, Any], room: int = MAX_PLACE) -> str:
    """Return ' at crank speed 2000 rpm (case 1a2b3c4d)' for an end of an extreme; in a small room the case alone."""
    setting, case = words.setting(end["values"], end["case"]), f"case {wording.short_id(end['case'])}"
    if not setting:
        return ""
    return f" in {case}" if setting == case or len(setting) > room else f" at {setting} ({case})"


def force(answer: Answer, words: Words) -> Iterator[Sentence]:
    """Give the largest normal force and its ratio to the ideal reaction."""
    entries = extremes_of(answer, "force_peak", words)
    if not entries and not answer.get("finished", 1):
        yield Sentence("No case finished, so nothing is known of forces and errors.")
    if not entries:
        return
    entry = max(entries, key=lambda candidate: candidate["largest"]["value"])
    if not entry["largest"]["value"]:
        yield Sentence("The surfaces never touch: every force peak is 0.")
        return
    (text,) = words.figures(entry["figure"], [entry["largest"]["value"]])
    ratio = entry["largest"].get("ratio")
    values = {
        "figure": words.figure(entry["figure"]),
        "value": text,
        "ratio": f", {factor_text(ratio)} times the ideal" if ratio else "",
        "where": place_text(answer, words, entry["largest"]),
    }
    yield Sentence("Largest {figure}: {value}{ratio}{where}.", values)
    never = [other for other in entries if not other["largest"]["value"]]
    if never:
        names = wording.sentence_list([words.figure(other["figure"]) for other in never])
        yield Sentence("The surfaces never touch: {names} 0.", {"names": names})
    elif not entry["smallest"]["value"]:
        where = place_text(answer, words, entry["smallest"])
        yield Sentence("The surfaces do not touch in every case, such as{where}.", {"where": where})


def error(answer: Answer, words: Words) -> Iterator[Sentence]:
    """Give the largest error of the output."""
    for entry in [entry for entry in extremes_of(answer, "error_max", words) if entry["largest"]["value"]][:1]:
        (text,) = words.figures(entry["figure"], [entry["largest"]["value"]])
        where = place_text(answer, words, entry["largest"])
        values = {"figure": words.figure(entry["figure"]), "value": text, "where": where}
        yield Sentence("Largest {figure}: {value}{where}.", values)


def touch(answer: Answer, words: Words) -> Iterator[Sentence]:
    """Say that the surfaces of a joint never touch, where limits lead."""
    for entry in extremes_of(answer, "force_peak", words):
        if not entry["largest"]["value"]:
            joint = next(column.joint for column in words.layout.columns if column.name == entry["figure"])
            name = wording.joint_name(joint)
            yield Sentence("The surfaces of {joint} never touch in any case.", {"joint": name})


def life(answer: Answer, words: Words) -> Iterator[Sentence]:
    """Give the shortest and the longest life with their intervals."""
    criterion = lifetime.criterion_text(words.record.get("life") or {})
    until = f" {criterion}" if criterion else ""
    for entry in extremes_of(answer, "life_hours", words)[:1]:
        joint = wording.joint_name(words.layout.life)
        shortest, longest = entry["smallest"], entry["largest"]
        values = {"joint": joint, "until": until, **_life_values(answer, words, shortest)}
        yield Sentence("Shortest life of {joint}{body}: {hours}{where}.", values)
        yield Sentence("It lasts{until}{interval}.", values)
        if shortest.get("spread"):
            yield Sentence("{spread}.", {"spread": shortest["spread"]})
        if longest["case"] != shortest["case"]:
            yield Sentence("Longest: {hours}{interval}{where}.", _life_values(answer, words, longest))
    if unreached := answer.get("unreached"):
        count = wording.count_text(unreached, "case")
        yield Sentence("{count} did not reach the limit, so the life there is longer than the run.", {"count": count})


def _life_values(answer: Answer, words: Words, end: Mapping[str, Any]) -> dict[str, str]:
    return {
        "body": f" ({end['body']})" if end.get("body") else "",
        "hours": f"{wording.number_text(end['value'])}{wording.BLANK}h",
        "interval": in_brackets(end.get("interval", "")),
        "where": place_text(answer, words, end),
    }


def start_up(answer: Answer, words: Words) -> Iterator[Sentence]:
    """Say how fast the motor reaches its speed, and which cases do not."""
    entry = extreme(answer, "start_up_time")
    unreached, total = answer.get("unreached", 0), answer.get("finished", 0)
    if entry is None:
        yield Sentence("No case reaches 95 % of the motor's no-load speed within its run; run more revolutions.")
        return
    first, last = words.figures("start_up_time", [entry["smallest"]["value"], entry["largest"]["value"]])
    text = last if first == last else f"{first} to {last}"
    where = place_text(answer, words, entry["largest"]) if first != last else ""
    cases = f"{total - unreached} of {total} cases reach" if total > 1 else "The motor reaches"
    values = {"cases": cases, "time": text, "where": f", the slowest{where}" if where else ""}
    yield Sentence("{cases} 95 % of the no-load speed after {time}{where}.", values)
    if unreached:
        yield Sentence(
            "{count} ended before: run more revolutions there.", {"count": wording.count_text(unreached, "start")}
        )


def losses(answer: Answer, words: Words) -> Iterator[Sentence]:
    """Give the range of the loss of each film."""
    for entry in extremes_of(answer, "film_loss", words)[:1]:
        low, high = words.figures(entry["figure"], [entry["smallest"]["value"], entry["largest"]["value"]])
        values = {"figure": words.figure(entry["figure"]), "range": low if low == high else f"{low} to {high}"}
        yield Sentence("{figure}: {range}.", values)


def wear(answer: Answer, words: Words) -> Iterator[Sentence]:
    """Give the deepest wear in 1000 hours, and when it would reach the clearance."""
    for entry in extremes_of(answer, "wear_rate_max", words)[:1]:
        rate = entry["largest"]["value"]
        if not rate:
            continue
        (text,) = wording.texts_in_common_unit([3.6e6 * rate], "m")
        hours = entry["largest"].get("clearance_hours")
        until = f", valid up to {wording.number_text(hours, 2)} h, when it has doubled the clearance" if hours else ""
        where = place_text(answer, words, entry["largest"], MAX_PLACE // 2 if hours else MAX_PLACE)
        yield Sentence(
            "Deepest wear: {value} per 1000 h{where}{until}.", {"value": text, "where": where, "until": until}
        )
