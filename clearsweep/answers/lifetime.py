"""Texts on a life: hours, with the intervals from numerics and from uncertain wear coefficients."""

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

from ..language import wording

WEAR_UNCERTAINTY_FACTORS = (3.0, 10.0)  # usual uncertainty of a wear coefficient
FASTER_WEAR = "{:g} to {:g} times".format(*WEAR_UNCERTAINTY_FACTORS)
INTERVAL_DIGITS = (3, 4, 5)  # digits: as few as distinguish the ends of an interval
MIN_RELATIVE_HALF_WIDTH = 1e-5  # of a life: a smaller interval is reported as below this


class Lifetime(NamedTuple):
    """The life of a joint: time and revolutions until its limit, with 95 % intervals; NaN for missing values."""

    hours: float  # h
    revolutions: float  # until the limit, as all following bounds
    revolutions_low: float  # lower bound from the numerical error
    revolutions_high: float  # upper bound; inf or NaN: unbounded
    revolutions_low_with_wear_uncertainty: float = math.nan  # lower bound from the uncertain wear coefficients
    revolutions_high_with_wear_uncertainty: float = math.nan  # upper bound from them


#: Name of a joint's column -> field of Lifetime.
FIELD_BY_COLUMN = {
    "life_hours": "hours",
    "life_revolutions": "revolutions",
    "life_low": "revolutions_low",
    "life_high": "revolutions_high",
    "life_low_uncertain": "revolutions_low_with_wear_uncertainty",
    "life_high_uncertain": "revolutions_high_with_wear_uncertainty",
}


def read_lifetime(columns: Mapping[str, float]) -> Lifetime:
    """Return a life from `columns`, whose names lack the joint; missing columns are NaN."""
    return Lifetime(**{field: columns.get(name, math.nan) for name, field in FIELD_BY_COLUMN.items()})


#: Value of `life.of` -> the condition at which a life ends.
_CRITERIA = {"wear_depth_max": "wear of one body reaches", "clearance_growth": "the clearance has grown by"}


def criterion_text(life_section: Mapping[str, Any]) -> str:
    """Return the condition at which a life ends as 'until ...', or ''; life_section : `life` of a grid."""
    if not life_section:
        return ""
    wear_limit = life_section.get("limit")
    limit_text = wording.quantity_text(wear_limit, "m") if isinstance(wear_limit, float) else "its limit"
    return f"until {_CRITERIA[life_section['of']]} {limit_text}"


def hours_text(life: Lifetime) -> str:
    """Return a life in hours."""
    return f"{wording.number_text(life.hours)} h"


def faster_wear_text(hours: float) -> str:
    """Return a life in hours with the wear WEAR_UNCERTAINTY_FACTORS times as fast: '159 to 47.8 h'."""
    texts = [wording.number_text(hours / factor) for factor in WEAR_UNCERTAINTY_FACTORS]
    return f"{' to '.join(texts)}{wording.BLANK}h"


def interval_text(life: Lifetime) -> str:
    """Return the 95 % interval of a life that the numerics leave, or '' if it is unknown."""
    if math.isnan(life.revolutions_low):
        return ""
    return f"95{wording.BLANK}% of the numerics alone: {_numerical_interval_text(life)}"


def spread_text(life: Lifetime) -> str:
    """Return what the wear coefficient leaves open: the interval of an uncertain one, or faster wear."""
    ends = life.revolutions_low_with_wear_uncertainty, life.revolutions_high_with_wear_uncertainty
    if any(map(math.isfinite, ends)):
        low, high = (
            _interval_end_text(life, end, INTERVAL_DIGITS[0]) if math.isfinite(end) else "unknown" for end in ends
        )
        return f"With the uncertain wear coefficients: {low} to {high}"
    if not math.isfinite(life.hours):
        return ""
    return f"With wear {FASTER_WEAR} as fast, the usual uncertainty of its coefficient: {faster_wear_text(life.hours)}"


def _interval_end_text(life: Lifetime, revolutions: float, digits: int) -> str:
    """Return an end of an interval (revolutions) in hours, rounded to `digits`."""
    return f"{wording.number_text(life.hours * revolutions / life.revolutions, digits)} h"


def _numerical_interval_text(life: Lifetime) -> str:
    """Return the numerical 95 % interval: its ends if five digits distinguish them, else its half-width."""
    if not math.isfinite(life.revolutions_high):
        return f"at least {_interval_end_text(life, life.revolutions_low, INTERVAL_DIGITS[0])}"
    for digits in INTERVAL_DIGITS:
        texts = [
            _interval_end_text(life, revolutions, digits)
            for revolutions in (life.revolutions_low, life.revolutions, life.revolutions_high)
        ]
        if len({*texts}) == len(texts):
            return f"{texts[0]} to {texts[2]}"
    relative_half_width = 0.5 * (life.revolutions_high - life.revolutions_low) / life.revolutions
    if relative_half_width < MIN_RELATIVE_HALF_WIDTH:
        return f"\u00b1 under {wording.number_text(100.0 * MIN_RELATIVE_HALF_WIDTH, 1)}{wording.BLANK}%"
    return f"\u00b1 {wording.number_text(100.0 * relative_half_width, 2)}{wording.BLANK}%"
