"""The closing lines of a run on what was sought and refined."""

from typing import Any

from ..language import wording
from .settings import joint_count, setting_text, value_text
from .sweep import RunResult

LISTED_ANSWERS = 12


def sought(result: RunResult, units: dict[str, str]) -> dict[str, Any] | None:
    """Return what was sought and found, ready for JSON, in SI; None where nothing was sought."""
    if result.seek is None:
        return None
    asked = result.seek.written() | {"unit": units[result.seek.path]}
    return {"asked": asked, "answers": [answer._asdict() for answer in result.answers]}


def seek_lines(facts: dict[str, Any]) -> list[str]:
    """Return the lines on what was sought."""
    if not facts["seek"]:
        return []
    asked, answers = facts["seek"]["asked"], facts["seek"]["answers"]
    end = "largest" if "largest" in asked else "smallest"
    paths = [*facts["units"]]
    lines = [
        "",
        f"The {end} {wording.axis_name(asked[end], joint_count(paths))} within the limits (all in seek.parquet)",
    ]
    if not answers:
        return [*lines, "  the search was stopped before its end; run the same command again to go on"]
    for answer in answers[:LISTED_ANSWERS]:
        value, low, high = (value_text(asked[end], answer[name], facts) for name in ("value", "low", "high"))
        found = "none in the range" if answer["value"] is None else value
        found += f" (border between {low} and {high})" if answer["low"] != answer["high"] else ""
        limiting = answer["limiting"]
        found += f", limited by {limiting}" if limiting else ", the end of the range: nothing limits it there"
        setting = setting_text(answer["point"], facts)
        lines.append(f"  {setting}: {found}" if setting else f"  {found}")
    if len(answers) > LISTED_ANSWERS:
        lines.append(f"  and {len(answers) - LISTED_ANSWERS:,} more")
    return lines


def refine_lines(facts: dict[str, Any]) -> list[str]:
    """Return the lines on what `refine` came to."""
    refined = facts["refined"]
    if not refined:
        return []
    added, asked = refined["added"], refined["asked"]
    if not refined["crossed"]:
        return ["", "Refined: no cases added, as nowhere one keeps to the limits and its neighbour does not"]
    known = (
        "its place is known to a thousandth of the steps of the grid" if refined["whole"] else "more would narrow it"
    )
    boxes = f"{refined['crossed']:,} place" + "s" * (refined["crossed"] != 1)
    return [
        "",
        f"Refined: {added:,} of at most {asked:,} cases added where the limits' border runs, at {boxes}; {known}",
    ]
