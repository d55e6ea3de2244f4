"""Sentences on searches: what `refine` added, and the answers of `seek`, `optimise` and `identify`."""

from collections.abc import Iterator, Mapping
from typing import Any

from ..language import wording
from .words import MAX_LINES, Answer, Sentence, Words, every_text, from_to, margin_text


def added(answer: Answer, words: Words) -> Iterator[Sentence]:
    """Say how many cases a search added, and how many exceed a limit with them."""
    counts = answer["cases"]
    if counts and not counts["added"] and answer["question"] == "refine":
        yield Sentence("No cases were added: no two neighbours differ in meeting the limits.")
    if counts and counts["added"] and (totals := answer.get("all_cases")):
        values = {"added": counts["added"], "count": sum(totals.values()), **totals}
        values["open"] = f", {totals['undecided']} are undecided" if totals["undecided"] else ""
        yield Sentence(
            "The search added {added} cases; of all {count}, {exceeded} exceed a limit{open} and {met} meet them.",
            values,
        )


def seek(answer: Answer, words: Words) -> Iterator[Sentence]:
    """Give the answers of `seek`, or what comes nearest where there is none."""
    section = words.record.get("seek") or {}
    direction = "largest" if "largest" in section else "smallest"
    sought = section.get(direction)
    paths = [sought] if isinstance(sought, str) else list(sought or ())
    if not paths or not answer["search"]:
        yield Sentence("The search was interrupted; run the same command again to continue.")
        return
    names = wording.sentence_list([words.axis_name(path) for path in paths])
    items = []
    for row in answer["search"]:
        point = {path: value for path, value in row.items() if path in words.path_units}
        setting = words.setting({path: value for path, value in point.items() if value is not None})
        items.append(f"{setting}: {_sought(words, row, paths[0])}" if setting else _sought(words, row, paths[0]))
    every = every_text(answer, words) if section.get("for") == "all" else ""
    lead = f"The {direction} {names} within the limits{every}"
    if len(items) == 1:
        yield Sentence("{lead}: {item}.", {"lead": lead, "item": items[0]})
    else:
        yield Sentence("{lead}:", {"lead": lead})
        room = 3
        for item in items[:room]:
            yield Sentence("{item}.", {"item": item})
        if len(items) > room:
            yield Sentence("{more} more are in seek.parquet.", {"more": len(items) - room})
    for nearest in answer.get("nearest", ())[:1]:
        values = {"tried": nearest["tried"], "failed": nearest["failed"], "margin": words.margin(nearest)}
        values["where"] = words.setting(nearest["values"], nearest["case"])
        yield Sentence("Of {tried} values tried, {failed} failed; nearest: {margin} at {where}.", values)


def _sought(words: Words, row: Mapping[str, Any], path: str) -> str:
    """Return an answer of `seek` in words."""
    value, limiting = row.get(f"seek.{path}"), row.get("limiting")
    if value is None:
        figures = {column.name for column in words.layout.columns} | {*(words.record.get("figures") or {})}
        if limiting and figures.isdisjoint(limiting.split(",")):
            return f"not known, as cases failed ({limiting})"
        return "none in the range" if "seek_fit" not in row else "none of the fits"
    text = f"{row['seek_fit']} ({words.value(path, value)})" if row.get("seek_fit") else words.value(path, value)
    other = row["seek_high"] if "largest" in (words.record.get("seek") or {}) else row["seek_low"]
    by = wording.sentence_list([words.figure(name) for name in (limiting or "").split(",") if name])
    border = f" (not known to be safe at {words.value(path, other)})" if row["seek_low"] != row["seek_high"] else ""
    return f"{text}{border}{f', limited by {by}' if by else ', the end of the range'}"


def optimise(answer: Answer, words: Words) -> Iterator[Sentence]:
    """Give the best cases of `optimise`."""
    rows = answer["search"]
    if not rows:
        return
    section = words.record.get("optimise") or {}
    objectives = [
        name
        for sense in ("minimise", "maximise")
        for name in ([section[sense]] if isinstance(section.get(sense), str) else section.get(sense) or ())
    ]
    margins = [row.get("margin") for row in rows]
    is_met = answer.get("best_met", True)
    count = len(rows)
    tried = wording.count_text(answer["tried"], "case")
    lead = f"The best of {tried}" if count == 1 else f"The front has {count} of {tried}, such as"
    lead = lead if is_met else "No case meets the limits; nearest"
    for index, row in enumerate(rows[: MAX_LINES - 2]):
        values = {
            "lead": f"{lead}: " if not index else "",
            "setting": words.setting({path: row[path] for path in words.path_units if row.get(path) is not None}),
            "figures": wording.sentence_list(
                [
                    f"{words.figure(name)} {words.figures(name, [row[name]])[0]}"
                    for name in objectives
                    if row.get(name) is not None
                ]
            ),
            "margin": "" if margins[index] is None else f", {margin_text(margins[index], _limits_of(words, row))}",
        }
        yield Sentence("{lead}{setting}: {figures}{margin}.", values)
    if count > MAX_LINES - 2:
        yield Sentence("{more} more are in optimise.parquet.", {"more": count - MAX_LINES + 2})


def _limits_of(words: Words, row: Mapping[str, Any]) -> list:
    return [limit for limit in words.limits if limit.column in (row.get("limiting") or "").split(",")]


def identify(answer: Answer, words: Words) -> Iterator[Sentence]:
    """Give the identified values with their intervals."""
    for parameter in answer.get("identified", ())[: MAX_LINES - 1]:
        path = parameter["path"]
        value, low, high = (words.value(path, parameter[key]) for key in ("value", "low", "high"))
        values = {"name": words.axis_name(path), "value": value, "range": from_to(low, high).removeprefix("from ")}
        yield Sentence("{name} {value} (95 %: {range}){note}.", values | {"note": parameter["note"]})
    if not answer.get("explained", True):
        yield Sentence("Misfit: no values of these keys explain the measurement, so the intervals are widened.")
