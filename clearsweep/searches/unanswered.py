"""Facts for a `seek` without an answer: margins, limits that would pass, keys that help."""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from decimal import ROUND_CEILING, ROUND_FLOOR, Decimal
from typing import Any

from ..answers.verdict import KINDS, Limit, limits_and_figures_of, units_of
from ..grid import key_units
from ..sweeping.pool.simulator import SIMULATION
from .seeking import Answer
from .sensitivity import Effect, furthest_from_limits

DIGITS = 4  # digits of a limit that would pass


def unanswered_facts(record: Mapping[str, Any], answers: Sequence[Answer], effects: Iterable[Effect]) -> dict[str, Any]:
    """Return facts about searches without an answer for run.json, in SI; `record` is run.json."""
    limits, columns = limits_and_figures_of(record).limits, units_of(record)
    best = [case for answer in answers for case in answer.best]
    finite = all(case["margin"] is not None for case in best)
    units = key_units(record, SIMULATION.catalogue()) if effects else {}
    return {
        "best": [case | {"needed": loosened_limits(limits, columns, [case["margins"]])} for case in best],
        "needed": loosened_limits(limits, columns, [case["margins"] for case in best]) if finite else {},
        "furthest": furthest_from_limits(answers),
        "effects": [effect._asdict() | {"unit": units.get(effect.path, "1")} for effect in effects],
    }


def loosened_limits(
    limits: Sequence[Limit], units: Mapping[str, str], margins: Sequence[Mapping[str, float]]
) -> dict[str, str]:
    """Return in words the exceeded limits for cases with these margins, each relaxed so that all cases pass.

    Columns with two limits are left out: a margin does not show which limit is exceeded.
    """
    texts: dict[str, str] = {}
    columns = Counter(limit.column for limit in limits)
    for limit in limits:
        margin = min((margin.get(limit.column, 0.0) for margin in margins), default=0.0)
        if margin < 0.0 and columns[limit.column] > 1:
            return {}
        if margin < 0.0:
            is_upper = limit.kind == KINDS[0]
            size = abs(limit.value) or 1.0  # the margin to a bound of 0 is the excess
            loosened = limit.value + size * (-margin if is_upper else margin)
            value = _rounded(loosened, ROUND_CEILING if is_upper else ROUND_FLOOR)
            texts[limit.column] = limit._replace(value=value).bound_text(units.get(limit.column, "1"))
    return texts


def _rounded(value: float, rounding: str) -> float:
    """Return a number with DIGITS digits, rounded up or down so that the relaxed limit still passes."""
    exact = Decimal(f"{value:.12g}")  # removes rounding errors of a margin
    return float(exact.quantize(Decimal(1).scaleb(exact.adjusted() + 1 - DIGITS), rounding))
