"""Figures of rolling bearings."""

import math

from ...contracts.case import Rolling
from ...contracts.catalogue import ENDLESS, Entry, Figure
from ...mechanics.joints.rolling import FATIGUE_FORCE
from ...mechanics.laws.rating import equivalent_loads, load_powers, passing_rates, rating_life
from .window import Window


def _bearing_of(window: Window, index: int) -> Rolling:
    bearing = window.case.joints[index].rolling
    assert bearing is not None  # only rolling bearings have these figures
    return bearing


def static_safety(window: Window, index: int) -> float | None:
    """Return C0 / P0 of a rolling bearing (ISO 76:2006), or None without load.

    P0, the equivalent static load of a radial bearing without axial load, is the largest resultant of its elements.
    """
    rating, load = _bearing_of(window, index).capacity.static, window.totals.joint[index].force_max
    assert rating is not None  # only bearings with this rating have this figure
    return float(rating / load) if load > 0.0 else None


def life_in_revolutions(window: Window, index: int) -> float | None:
    """Return the rating life of a rolling bearing (1e6 revolutions), or None if it is not loaded while it turns.

    Each load counts by the speed at which the rings turn relative to each other.
    """
    bearing, totals = _bearing_of(window, index), window.totals.joint[index]
    if not totals.inner_fatigue > 0.0:
        return None
    elements_turned = bearing.elements * totals.relative_turn
    means = (
        fatigue / elements_turned * FATIGUE_FORCE**power
        for fatigue, power in zip((totals.inner_fatigue, totals.outer_fatigue), load_powers(bearing), strict=True)
    )
    return rating_life(bearing, equivalent_loads(bearing, *means))


def mean_speed(window: Window, index: int) -> float:
    """Return the mean speed (1/s) of the inner ring relative to the outer one, without its sign."""
    return float(window.totals.joint[index].relative_turn / (2.0 * math.pi * window.duration))


def life_in_hours(window: Window, index: int) -> float | None:
    """Return the rating life of a rolling bearing (h) at its mean speed, or None as `life_in_revolutions`."""
    revolutions = life_in_revolutions(window, index)
    return None if revolutions is None else 1e6 * revolutions / (3600.0 * mean_speed(window, index))


def _passing_frequency(name: str, text: str) -> Figure:
    """Return the figure of a passing frequency; `name`: its field in `PassingRates`."""
    return Figure(
        f"{name}_frequency",
        "Hz",
        f"{text}, at the mean speed of the inner ring relative to the outer one",
        of="joint",
        needs=("rolling",),
        value=lambda window, index: (
            mean_speed(window, index) * getattr(passing_rates(_bearing_of(window, index)), name)
        ),
    )


ROLLING = (
    Figure(
        "life_l10r",
        "h",
        "basic reference rating life of a rolling bearing, reached by 90 % (ISO/TS 16281); null: without load",
        of="joint",
        needs=("rolling", "dynamic"),
        value=life_in_hours,
        tables=(Entry("forces", "rating life", 30, if_any=True), Entry("case", "rating life", 13)),
        null=ENDLESS,
    ),
    Figure(
        "life_l10r_revolutions",
        "1",
        "the same life in millions of revolutions of the inner ring relative to the outer one; null: without load",
        of="joint",
        needs=("rolling", "dynamic"),
        value=life_in_revolutions,
        null=ENDLESS,
    ),
    Figure(
        "light_load_fraction",
        "1",
        "share of the window's time at less than the least load against skidding: 0.01 of the dynamic rating of "
        "ball bearings, 0.02 of roller bearings",
        of="joint",
        needs=("rolling", "dynamic"),
        value=lambda window, index: window.light_load_time[index] / window.duration,
        tables=(Entry("forces", "time too lightly loaded", 31, if_any=True),),
    ),
    _passing_frequency("cage", "turns of the cage of a rolling bearing relative to the outer ring per second"),
    _passing_frequency("element", "turns of an element of a rolling bearing about itself per second"),
    _passing_frequency("inner", "elements of a rolling bearing that pass a point of the inner ring per second"),
    _passing_frequency("outer", "elements of a rolling bearing that pass a point of the outer ring per second"),
    Figure(
        "element_load_max",
        "N",
        "largest force of a rolling element in the window, located",
        of="joint",
        needs=("rolling",),
        value=lambda window, index: window.totals.joint[index].element_force_max,
        tables=(Entry("forces", "element load", 27, if_any=True), Entry("case", "element load", 11)),
    ),
    Figure(
        "elements_loaded_max",
        "1",
        "largest number of rolling elements that carry load at a time",
        of="joint",
        needs=("rolling",),
        value=lambda window, index: round(window.totals.joint[index].elements_loaded),
        kind="int",
        tables=(Entry("forces", "elements loaded", 28, if_any=True),),
    ),
    Figure(
        "static_safety",
        "1",
        "static load rating over the largest equivalent static load, which is the force peak (ISO 76); null: no load",
        of="joint",
        needs=("rolling", "static"),
        value=static_safety,
        tables=(Entry("forces", "static safety", 29, if_any=True), Entry("case", "static safety", 12)),
        null=ENDLESS,
    ),
)
