"""Figures of a start by a motor: its duration, the least speed after it, and the largest forces during it."""

import math

from ...contracts.catalogue import Entry, Figure
from .window import Window


def start_up_time(window: Window, _: int) -> float | None:
    """Return the start-up time (s) of a free crank, or None if it did not start."""
    time = float(window.totals.mechanism.target_time)
    return time if math.isfinite(time) else None


def min_speed_after_start(window: Window, _: int) -> float | None:
    """Return the least speed (rad/s) of a free crank after its start-up time, or None if it did not start."""
    speed = float(window.totals.mechanism.min_speed_after_target)
    return speed if math.isfinite(speed) else None


def max_force_to_start(window: Window, index: int) -> float | None:
    """Return the largest normal force (N) in a joint until the start-up time, or None if this is not in the window."""
    mechanism_totals = window.totals.mechanism
    is_in_window = mechanism_totals.window_start < mechanism_totals.target_time < math.inf
    return float(window.totals.joint[index].force_max_to_target) if is_in_window else None


START_UP_TIME = Figure(
    "start_up_time",
    "s",
    "time until a free crank first reaches 95 % of its motor's no-load speed; 0: it starts faster; null: not reached, "
    "or no such speed",
    needs=("free",),
    value=start_up_time,
    differs=False,
    tables=(Entry("output", "start-up time", 6),),
)
CRANK_SPEED_AFTER = Figure(
    "crank_speed_after",
    "rad/s",
    "least speed of a free crank after `start_up_time`; null: not reached, or no such speed",
    needs=("free",),
    value=min_speed_after_start,
    differs=False,
    tables=(Entry("output", "least crank speed after the start", 7),),
)
FORCE_PEAK_START = Figure(
    "force_peak_start",
    "N",
    "largest normal force until `start_up_time`, to the end of this step; null: not reached, or before the window",
    of="joint",
    needs=("free",),
    value=max_force_to_start,
    differs=False,
)
