"""Texts on a life: hours, with the intervals from numerics and from uncertain wear coefficients."""

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

from ..language import wording
from .validity import WIDE_SMOOTHING

DIGITS = (3, 4, 5)  # digits: as few as distinguish the ends of an interval
SMALLEST_INTERVAL = 1e-5  # of a life: a smaller interval is reported as below this


class Lifetime(NamedTuple):
    """The columns of a life in revolutions, except hours; nan for missing values."""

    hours: float  # h
    revolutions: float
    low: float
    high: float  # inf or nan: unbounded
    low_uncertain: float = math.nan
    high_uncertain: float = math.nan
    smoothing: float = math.nan  # rad, smoothing width of worn shapes at its end


#: Name of a joint's column -> field of Lifetime.
COLUMNS = {f"life_{name}": name for name in Lifetime._fields[:-1]} | {"wear_smoothing": "smoothing"}


def lifetime_of(columns: Mapping[str, float]) -> Lifetime:
    """Return a life from its columns, without the joint's name; missing columns are nan."""
    return Lifetime(**{field: columns.get(name, math.nan) for name, field in COLUMNS.items()})


#: Value of `life.of` -> the condition at which a life ends.
_ENDS = {"wear_depth_max": "wear of one body reaches", "clearance_growth": "the clearance has grown by"}


def criterion(section: Mapping[str, Any]) -> str:
    """Return the condition at which a life ends, from the section `life` of a grid: 'until ...'; '' without one."""
    if not section:
        return ""
    limit = section.get("limit")
    value = wording.text(limit, "m") if isinstance(limit, float) else "its limit"
    return f"until {_ENDS[section['of']]} {value}"


def interval_text(life: Lifetime) -> str:
    """Return a life in hours with the numerical interval only, and a remark on what this omits."""
    parts = [f"{wording.plain(life.hours)} h ({_numerics(life)})"]
    if math.isfinite(life.low_uncertain) or math.isfinite(life.high_uncertain):
        bounds = [
            f"{preposition}{_hours(life, revolutions, DIGITS[0])}"
            for preposition, revolutions in (("from ", life.low_uncertain), ("to ", life.high_uncertain))
            if math.isfinite(revolutions)
        ]
        range_text = (
            " ".join(bounds).removeprefix("from ") if len(bounds) == 2 else f"{bounds[0]}, the other end not known,"
        )
        parts.append(f"{range_text} with the uncertain wear coefficients")
    if life.smoothing > WIDE_SMOOTHING:
        parts.append(
            f"its worn shapes are smoothed over {math.degrees(life.smoothing):.2g} deg, an effect that the interval "
            "does not contain"
        )
    return "; ".join(parts)


def _hours(life: Lifetime, revolutions: float, digits: int) -> str:
    """Return an end of an interval (revolutions) in hours."""
    return f"{wording.plain(life.hours * revolutions / life.revolutions, digits)} h"


def _numerics(life: Lifetime) -> str:
    """Return the numerical 95 % interval: its ends if five digits distinguish them, else its half-width."""
    percent = f"95{wording.BLANK}%, numerics alone"
    if not math.isfinite(life.high):
        return f"{percent}: {_hours(life, life.low, DIGITS[0])} to no end"
    for digits in DIGITS:
        texts = [_hours(life, revolutions, digits) for revolutions in (life.low, life.revolutions, life.high)]
        if len({*texts}) == len(texts):
            return f"{percent}: {texts[0]} to {texts[2]}"
    share = 0.5 * (life.high - life.low) / life.revolutions
    if share < SMALLEST_INTERVAL:
        return f"{percent}: \u00b1 under {wording.plain(100.0 * SMALLEST_INTERVAL, 1)}{wording.BLANK}%"
    return f"{percent}: \u00b1 {wording.plain(100.0 * share, 2)}{wording.BLANK}%"
