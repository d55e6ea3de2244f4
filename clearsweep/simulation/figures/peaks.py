"""Figures of merit of single revolutions: quantiles of their force peaks, and the period of the motion."""

import math
from collections.abc import Callable
from functools import partial

from ...contracts.catalogue import Entry, Figure
from .window import Window

PEAK_TOLERANCE = 1e-9  # relative difference below which two peaks are the same


def ideal_peak(window: Window, index: int) -> float | None:
    """Return the largest reaction (N) of the ideal mechanism."""
    return window.ideal.get(window.case.joints[index].name)


def load_peak(window: Window, index: int) -> float:
    """Return the largest resultant (N) of normal and friction force."""
    joint = window.totals.joint[index]
    return float(max(joint.force_max, math.sqrt(joint.load_max)))


def peak_ratio(window: Window, index: int) -> float | None:
    """Return the largest resultant over the largest reaction without clearance, or None if there is no reaction."""
    ideal = ideal_peak(window, index)
    return load_peak(window, index) / ideal if ideal else None


def peak_turn(window: Window, index: int) -> int | None:
    """Return the revolution of the largest normal force, or None if that revolution is incomplete."""
    highest, largest = window.spreads[index].highest, window.totals.joint[index].force_max
    return highest[1] if highest and highest[0] >= (1.0 - PEAK_TOLERANCE) * largest > 0.0 else None


def peak_quantile_figures(name: str, text: str, entry: Entry) -> tuple[Figure, ...]:
    """Return the figures of a quantile of force peaks per revolution: its value and the ends of its interval."""

    def value(end: str) -> Callable[[Window, int], float | None]:
        return lambda window, index: getattr(getattr(window.spreads[index], name), end)

    column, end = f"force_peak_{name}", "{} end of the 95 % interval of {}; null: too few revolutions"
    figure = partial(Figure, unit="N", of="joint", needs=("turns",))
    return (
        figure(column, text=text, value=value("value"), tables=(entry,)),
        figure(f"{column}_low", text=end.format("lower", column), value=value("low"), differs=False),
        figure(f"{column}_high", text=end.format("upper", column), value=value("high"), differs=False),
    )


PEAKS = (
    Figure(
        "force_peak_revolution",
        "1",
        "number of the revolution with the largest normal force, from 1 and including `discard`; null: no complete "
        "revolution has it",
        of="joint",
        needs=("turns", "error_check"),
        kind="int",
        value=peak_turn,
        differs=False,
    ),
    *peak_quantile_figures(
        "median",
        "median of the largest normal forces of the window's revolutions",
        Entry("forces", "median of revolutions", 3),
    ),
    *peak_quantile_figures(
        "p95",
        "95 % quantile of the largest normal forces of the window's revolutions",
        Entry("forces", "95 % of revolutions", 3),
    ),
    Figure(
        "force_peak_million",
        "N",
        "largest normal force to expect in 10^6 revolutions (median), by extreme-value statistics of the window's "
        "revolutions; of a periodic motion, the largest of its last three periods; null: fewer than 100 independent "
        "revolutions",
        of="joint",
        needs=("turns",),
        value=lambda window, index: window.spreads[index].of_million.value,
        differs=False,
        tables=(Entry("forces", "expected in 10⁶ revolutions", 3, if_any=True),),
    ),
    Figure(
        "force_peak_million_high",
        "N",
        "normal force that the largest of 10^6 revolutions exceeds with a probability of 2.5 %; null as for the median",
        of="joint",
        needs=("turns",),
        value=lambda window, index: window.spreads[index].of_million.high,
        differs=False,
    ),
    Figure(
        "load_peak",
        "N",
        "largest resultant of normal and friction force in the window, located",
        of="joint",
        value=load_peak,
        tables=(
            Entry("forces", "load peak", 3),
            Entry("sample", "load peak", 3),
            Entry("case", "load peak", 3),
        ),
    ),
    Figure(
        "force_peak_ratio",
        "1",
        "load_peak over force_peak_ideal, both resultants; null: the latter is zero",
        of="joint",
        needs=("turns",),
        value=peak_ratio,
        tables=(
            Entry("forces", "load / ideal", 5),
            Entry("sample", "load / ideal", 3),
            Entry("case", "load / ideal", 4),
        ),
    ),
)
#: Figures from the state at the ends of revolutions.
PERIOD = (
    Figure(
        "period",
        "1",
        "revolutions after which the motion repeats; null: no repetition within the window",
        needs=("turns",),
        kind="int",
        value=lambda window, _: window.repetition and window.repetition.period,
        differs=False,
        tables=(Entry("certainty", "period", 2),),
    ),
    Figure(
        "periodic_from",
        "1",
        "revolutions of the run, `discard` included, after which the motion repeats itself with this period; null: as "
        "for the period",
        needs=("turns",),
        value=lambda window, _: window.repetition and window.repetition.begin,
        differs=False,
        tables=(Entry("certainty", "periodic from (rev.)", 2),),
    ),
)
