"""The time in which a motor starts a mechanism."""

from ...contracts.catalogue import Figure, Shown

START_UP_TIME = Figure(
    "start_up_time",
    "s",
    "time until a free crank first reaches 95 % of its motor's no-load speed; null: not reached, or no such speed",
    needs=("free",),
    value=lambda window, _: window.totals.whole.speed_reached or None,
    differs=False,
    shown=(Shown("output", "start-up time", 6),),
)
