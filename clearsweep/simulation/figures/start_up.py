"""The start of a mechanism by a motor: its time, the speed after it, and the largest force in it."""

import math

from ...contracts.catalogue import Figure, Shown
from ..window import Window


def speed_after(window: Window, _: int) -> float | None:
    """Return the least speed (rad/s) of a free crank after its start-up time, or None if it did not start."""
    speed = float(window.totals.mechanism.min_speed_after_target)
    return speed if math.isfinite(speed) else None


def force_until(window: Window, index: int) -> float | None:
    """Return the largest normal force (N) in a joint until the start-up time, or None if this is not in the window."""
    whole = window.totals.mechanism
    started = whole.target_time > whole.window_start
    return float(window.totals.joint[index].force_max_to_target) if started else None


START_UP_TIME = Figure(
    "start_up_time",
    "s",
    "time until a free crank first reaches 95 % of its motor's no-load speed; null: not reached, or no such speed",
    needs=("free",),
    value=lambda window, _: window.totals.mechanism.target_time or None,
    differs=False,
    shown=(Shown("output", "start-up time", 6),),
)
CRANK_SPEED_AFTER = Figure(
    "crank_speed_after",
    "rad/s",
    "least speed of a free crank after `start_up_time`; null: not reached, or no such speed",
    needs=("free",),
    value=speed_after,
    differs=False,
    shown=(Shown("output", "least crank speed after the start", 7),),
)
FORCE_PEAK_START = Figure(
    "force_peak_start",
    "N",
    "largest normal force until `start_up_time`, to the end of this step; null: not reached, or before the window",
    of="joint",
    needs=("free",),
    value=force_until,
    differs=False,
)
