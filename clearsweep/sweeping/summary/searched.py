"""Results of `seek` and `optimise` as `run --json` has them."""

import itertools
from collections.abc import Mapping, Sequence
from typing import Any

from ...answers.verdict import Limit
from ...answers.words import case_margin_text
from ...searches import unanswered
from ...searches.optimising import BestCase
from ..sweep import RunResult

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
    exceeded = case.limiting or "" if not case.feasible else ""
    return case._asdict() | {"margin_words": case_margin_text(case.margin, limits, exceeded)}
