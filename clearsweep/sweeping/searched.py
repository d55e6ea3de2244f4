"""The last lines of a run on `seek`, `optimise` and `refine`."""

import itertools
from collections.abc import Mapping, Sequence
from typing import Any

from ..answers.verdict import Limit, margin_text
from ..language import wording
from . import unanswered
from .optimising import BestCase
from .sensitivity import STEP
from .settings import grid_text, number_of_joints, setting_text, value_text
from .sweep import RunResult

LISTED_ANSWERS, LISTED_EFFECTS = 12, 6


def seek_facts(result: RunResult, record: Mapping[str, Any]) -> dict[str, Any] | None:
    """Return the result of `seek` as a JSON-ready dictionary in SI units, or None if the grid has no `seek`.

    record : run.json
    """
    if result.seek is None:
        return None
    remedies = unanswered.unanswered_facts(record, result.answers, result.effects)
    nearest_cases = iter(remedies.pop("best"))
    answers = [
        answer._asdict() | {"best": [*itertools.islice(nearest_cases, len(answer.best))]} for answer in result.answers
    ]
    return {
        "asked": result.seek.resolved() | {"unit": record["units"][result.seek.path]},
        "answers": answers,
    } | remedies


def seek_lines(facts: dict[str, Any]) -> list[str]:
    """Return the last lines on the result of `seek`."""
    if not facts["seek"]:
        return []
    question, answers = facts["seek"]["asked"], facts["seek"]["answers"]
    direction = "largest" if "largest" in question else "smallest"
    sought_paths = question[direction] if isinstance(question[direction], list) else [question[direction]]
    path = sought_paths[0]
    paths = [*facts["units"]]
    names = wording.sentence_list([wording.axis_name(path, number_of_joints(paths)) for path in sought_paths])
    lines = ["", f"The {direction} {names} within the limits (all in seek.parquet)"]
    if not answers:
        return [*lines, "  the search was interrupted; run the same command again to continue"]
    for answer in answers[:LISTED_ANSWERS]:
        value, low, high = (value_text(path, answer[name], facts) for name in ("value", "low", "high"))
        answered = (
            value if answer["value"] is not None else "none of the fits" if answer["fits"] else "none in the range"
        )
        answered = f"{value}, its largest clearance" if answer["fit"] else answered
        answered += f" (border between {low} and {high})" if answer["low"] != answer["high"] else ""
        limiting = answer["limiting"]
        answered += (
            f", limited by {_limit_names(limiting, facts)}"
            if limiting
            else ", the end of the range: no limit is reached"
        )
        setting = setting_text(answer["point"], facts)
        if setting and question.get("for") == "all":
            conditions = wording.sentence_list(
                [wording.axis_name(key, number_of_joints(paths)) for key in answer["point"]]
            )
            worst = f" at {setting}" if limiting else ""
            lines.append(f"  at every {conditions}: {answered}{worst}")
        else:
            lines.append(f"  {setting}: {answered}" if setting else f"  {answered}")
        if answer["beyond"]:
            names = wording.sentence_list(list(answer["beyond"]))
            lines.append(f"    not monotone: {names} beyond it also meet the limits")
        lines += [f"    {_nearest_line(path, case, facts)}" for case in answer["best"][:LISTED_ANSWERS]]
        if len(answer["best"]) > LISTED_ANSWERS:
            lines.append(f"    and {len(answer['best']) - LISTED_ANSWERS:,} more")
    if len(answers) > LISTED_ANSWERS:
        lines.append(f"  and {len(answers) - LISTED_ANSWERS:,} more")
    count = sum(len(answer["best"]) for answer in answers)
    if facts["seek"]["needed"] and count > 1:
        loosened = wording.sentence_list([f"{name} {change}" for name, change in facts["seek"]["needed"].items()])
        lines.append(f"  All of these {count} would pass with {loosened}.")
    return [*lines, *_effect_lines(path, facts)]


def _effect_lines(path: str, facts: dict[str, Any]) -> list[str]:
    """Return the lines on keys that change the margin if no value of `path` meets the limits."""
    effects, furthest, texts = facts["seek"]["effects"], facts["seek"]["furthest"], []
    step = f"{100.0 * STEP:g} %"
    for effect in effects:
        lower, unchanged, upper = (_margin_text(effect[name]) for name in ("lower", "margin", "upper"))
        if len({lower, unchanged, upper}) > 1:
            value = grid_text(effect["value"], effect["unit"], speed=effect["path"].endswith("speed"))
            texts.append(f"    {effect['path']} ({value}): {lower} with {step} less, {upper} with {step} more")
    if not texts:
        return ["  No other single key of the grid changes the margin."] if effects else []
    setting = setting_text({**furthest["point"], path: furthest["value"]}, facts)
    heading = f"  Effect of other keys on the worst margin, {_margin_text(furthest['margin'])} at {setting}:"
    return [heading, *texts[:LISTED_EFFECTS]]


def _margin_text(margin: float | None) -> str:
    return "failed" if margin is None else f"{100.0 * margin:.3g} %"


def _nearest_line(path: str, case: dict[str, Any], facts: dict[str, Any]) -> str:
    """Return a line with the best margin for one combination of the other axes, and the limits that would pass."""
    setting = setting_text(case["point"], facts)
    prefix = f"{setting}: " if setting else ""
    if case["margin"] is None:
        return f"{prefix}every case failed or cannot be assessed ({case['limiting']})"
    margin = _margin_text(case["margin"])
    text = f"{prefix}best at {value_text(path, case['value'], facts)}, margin {margin}"
    text = f"{prefix}best with {case['fit']}, margin {margin}" if case["fit"] else text
    if case["limiting"] is None:  # another case exceeds them, or the motion is chaotic
        return f"{text}, within the limits there"
    text += f", limited by {_limit_names(case['limiting'], facts)}"
    needed = [f"{name} {change}" for name, change in case["needed"].items()]
    return f"{text}; it would meet the limits with {wording.sentence_list(needed)}" if needed else text


def _limit_names(columns: str, facts: dict[str, Any]) -> str:
    """Return limited columns, separated by commas, in words."""
    return wording.sentence_list([facts["limited_figures"].get(name, name) for name in columns.split(",")])


def refine_lines(facts: dict[str, Any]) -> list[str]:
    """Return the last lines on the result of `refine`."""
    refinement = facts["refined"]
    if not refinement:
        return []
    count, allowed = refinement["added"], refinement["asked"]
    if not refinement["crossed"]:
        return ["", "Refined: no cases added, because no two neighbours differ in meeting the limits"]
    units = (
        "its position is known to a thousandth of a grid step" if refinement["whole"] else "more cases would narrow it"
    )
    boxes = f"{refinement['crossed']:,} place" + "s" * (refinement["crossed"] != 1)
    return [
        "",
        f"Refined: {count:,} of at most {allowed:,} cases added along the border of the limits, at {boxes}; {units}",
    ]


def optimise_facts(result: RunResult, units: Mapping[str, str], limits: Sequence[Limit]) -> dict[str, Any] | None:
    """Return the result of `optimise` as a JSON-ready dictionary in SI units, or None if there is none.

    `units` maps columns to units.
    """
    optimum = result.optimised
    if optimum is None:
        return None
    best = [_case_facts(case, limits) for case in optimum.best]
    start = _case_facts(optimum.start, limits) if optimum.start else None
    names = [*optimum.best[0].values]
    return optimum._asdict() | {"best": best, "start": start, "units": {name: units.get(name, "1") for name in names}}


def _case_facts(case: BestCase, limits: Sequence[Limit]) -> dict[str, Any]:
    """Return a case as a JSON-ready dictionary with its margin in words; without limits, the words are None."""
    if case.margin is None:
        return case._asdict() | {"margin_words": None}
    exceeded = case.limiting or "" if case.margin < 0.0 else ""
    return case._asdict() | {"margin_words": margin_text(case.margin, limits, exceeded)}


def _objective_text(column: str, case: Mapping[str, Any], unit: str) -> str:
    """Return an objective of a case with its interval, if it has one."""
    text = f"{column} {grid_text(case['values'][column], unit)}"
    if column not in case["intervals"]:
        return text
    low, high = (grid_text(end, unit) for end in case["intervals"][column])
    return f"{text} (95 %: {low} to {high})"


def optimise_lines(facts: dict[str, Any]) -> list[str]:
    """Return the last lines on the result of `optimise`."""
    optimum = facts["optimised"]
    if not optimum:
        return []
    best, start = optimum["best"], optimum["start"]
    front = f"the front has {len(best):,} cases" if len(best) > 1 else "the best case"
    lines = ["", f"Optimised over {optimum['looked_at']:,} cases: {front} (all in optimise.parquet)"]
    if not optimum["feasible"]:
        front = "no case meets the limits; the nearest case"
        lines[-1] = f"Optimised over {optimum['looked_at']:,} cases: {front} (optimise.parquet)"
    for name, case in [*(("", case) for case in best[:LISTED_ANSWERS]), *((("start: ", start),) if start else ())]:
        values = [_objective_text(column, case, optimum["units"][column]) for column in case["values"]]
        limiting = _limit_names(case["limiting"] or "", facts)
        margin = "" if case["margin"] is None else f", margin {case['margin_words']} ({limiting})"
        lines.append(f"  {name}{setting_text(case['point'], facts)}: {', '.join(values) or 'failed'}{margin}")
    if len(best) > LISTED_ANSWERS:
        lines.append(f"  and {len(best) - LISTED_ANSWERS:,} more")
    if optimum["alike"]:
        equivalent = wording.count_text(optimum["alike"], "other case") + (
            " within the limits" if best[0]["limiting"] else ""
        )
        lines.append(f"  {equivalent} cannot be distinguished from it: the 95 % intervals overlap")
    return lines
