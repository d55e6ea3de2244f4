"""Texts on a life: hours, with the intervals from numerics and from uncertain wear coefficients."""

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

from ..language import wording
from .validity import WIDE_SMOOTHING

FASTER_WEAR = 3.0  # lower end of the usual uncertainty of a wear coefficient, a factor
INTERVAL_DIGITS = (3, 4, 5)  # digits: as few as distinguish the ends of an interval
MIN_RELATIVE_WIDTH = 1e-5  # of a life: a smaller interval is reported as below this


class Lifetime(NamedTuple):
    """The life of a joint: time and revolutions until its limit, with 95 % intervals; NaN for missing values."""

    hours: float  # h
    revolutions: float  # until the limit, as all following bounds
    low: float  # lower bound from the numerical error
    high: float  # upper bound; inf or NaN: unbounded
    low_uncertain: float = math.nan  # lower bound from the uncertain wear coefficients
    high_uncertain: float = math.nan  # upper bound from them
    smoothing: float = math.nan  # rad, smoothing width of worn shapes at its end


#: Name of a joint's column -> field of Lifetime.
COLUMNS = {f"life_{name}": name for name in Lifetime._fields[:-1]} | {"wear_smoothing": "smoothing"}


def read_lifetime(columns: Mapping[str, float]) -> Lifetime:
    """Return a life from `columns`, whose names lack the joint; missing columns are NaN."""
    return Lifetime(**{field: columns.get(name, math.nan) for name, field in COLUMNS.items()})


#: Value of `life.of` -> the condition at which a life ends.
_CRITERIA = {"wear_depth_max": "wear of one body reaches", "clearance_growth": "the clearance has grown by"}


def criterion_text(section: Mapping[str, Any]) -> str:
    """Return the condition at which a life ends as 'until ...', or ''; section : `life` of a grid."""
    if not section:
        return ""
    limit = section.get("limit")
    limit_text = wording.text(limit, "m") if isinstance(limit, float) else "its limit"
    return f"until {_CRITERIA[section['of']]} {limit_text}"


def hours_text(life: Lifetime) -> str:
    """Return a life in hours."""
    return f"{wording.plain(life.hours)} h"


def faster_wear_sentences(life: Lifetime) -> list[str]:
    """Return the sentence on a larger wear coefficient, which ends a life sooner; [] if its uncertainty is known."""
    if math.isfinite(life.low_uncertain) or math.isfinite(life.high_uncertain):
        return []
    return [
        f"With wear {FASTER_WEAR:g} times as fast, within the usual uncertainty of its coefficient, it is about "
        f"{faster_wear_text(life.hours)}."
    ]


def faster_wear_text(hours: float) -> str:
    """Return a life in hours with the wear FASTER_WEAR times as fast."""
    return f"{wording.plain(hours / FASTER_WEAR)}{wording.BLANK}h"


def interval_sentences(life: Lifetime) -> list[str]:
    """Return sentences on the intervals of a life: from numerics, from uncertain coefficients, and what they omit."""
    sentences = [f"95{wording.BLANK}% interval of the numerics alone: {_numerical_interval_text(life)}."]
    if math.isfinite(life.low_uncertain) or math.isfinite(life.high_uncertain):
        bounds = [
            f"{preposition}{_interval_end_text(life, revolutions, INTERVAL_DIGITS[0])}"
            for preposition, revolutions in (("from ", life.low_uncertain), ("to ", life.high_uncertain))
            if math.isfinite(revolutions)
        ]
        range_text = " ".join(bounds).removeprefix("from ") if len(bounds) == 2 else f"{bounds[0]}, other end unknown"
        sentences.append(f"With the uncertain wear coefficients: {range_text}.")
    if life.smoothing > WIDE_SMOOTHING:
        sentences.append(
            f"Not included: the effect of smoothing the worn shapes over {_degrees_text(life.smoothing)}, which is "
            "unknown: "
            "take the hours as an estimate."
        )
    return sentences


def _degrees_text(angle: float) -> str:
    """Return an angle (rad) in degrees."""
    return f"{math.degrees(angle):.2g} deg"


def _interval_end_text(life: Lifetime, revolutions: float, digits: int) -> str:
    """Return an end of an interval (revolutions) in hours, rounded to `digits`."""
    return f"{wording.plain(life.hours * revolutions / life.revolutions, digits)} h"


def _numerical_interval_text(life: Lifetime) -> str:
    """Return the numerical 95 % interval: its ends if five digits distinguish them, else its half-width."""
    if not math.isfinite(life.high):
        return f"at least {_interval_end_text(life, life.low, INTERVAL_DIGITS[0])}"
    for digits in INTERVAL_DIGITS:
        texts = [
            _interval_end_text(life, revolutions, digits) for revolutions in (life.low, life.revolutions, life.high)
        ]
        if len({*texts}) == len(texts):
            return f"{texts[0]} to {texts[2]}"
    relative_half_width = 0.5 * (life.high - life.low) / life.revolutions
    if relative_half_width < MIN_RELATIVE_WIDTH:
        return f"\u00b1 under {wording.plain(100.0 * MIN_RELATIVE_WIDTH, 1)}{wording.BLANK}%"
    return f"\u00b1 {wording.plain(100.0 * relative_half_width, 2)}{wording.BLANK}%"
