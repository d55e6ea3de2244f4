"""Figures of joints with play in rotation, gears and couplings."""

from typing import Any

from ...contracts.catalogue import Entry, Figure
from .sums import FreeShare, PerRevolution
from .window import Window


def twist_range(window: Window, index: int) -> tuple[float, float]:
    """Return the least and the largest angle (rad) of the second body from the middle of the play, first body fixed.

    Positive is the side of the drive flank: the second body lags behind.
    """
    sums, joint = window.totals.joint[index], window.joints[index]
    arm = abs(joint.arm_distal)  # type: ignore[attr-defined]  # of a joint with play in rotation
    return -(joint.clearance + sums.coast_depth) / arm, (joint.clearance + sums.drive_depth) / arm


def lost_motion(window: Window, index: int) -> float:
    """Return the range (rad) of the angle of the second body relative to the first."""
    least, largest = twist_range(window, index)
    return largest - least


def transmission_error(window: Window, index: int) -> float:
    """Return the largest distance (rad) of the second body from where it would be without play and deflection."""
    return max(map(abs, twist_range(window, index)))


def torque_peak(window: Window, index: int) -> float:
    """Return the largest torque (N m) of the contact forces on the second body."""
    return float(window.totals.joint[index].force_max * abs(window.joints[index].arm_distal))  # type: ignore[attr-defined]


def torque_peak_ideal(window: Window, index: int) -> float | None:
    """Return the largest torque (N m) on the second body without play, or None if it is unknown."""
    force = window.ideal.get(window.case.joints[index].name)
    return None if force is None else force * abs(window.joints[index].arm_distal)  # type: ignore[attr-defined]


def _figure(name: str, unit: str, text: str, tables: tuple[Entry, ...], needs: str = "", **computed: Any) -> Figure:
    """Return a figure of a joint with play in rotation."""
    return Figure(name, unit, text, of="joint", needs=("flanked", *needs.split()), tables=tables, **computed)


FLANKED = (
    _figure(
        "impacts_per_cycle",
        "1",
        "contact onsets on both flanks in the window per cycle; per revolution where no cycle is given",
        (Entry("forces", "impacts per cycle", 27, if_any=True),),
        needs="turns",
        sums=PerRevolution("onsets"),
    ),
    _figure(
        "free_share",
        "1",
        "share of the window's time without contact on either flank",
        (Entry("forces", "time in the play", 28, if_any=True),),
        sums=FreeShare("contact_time"),
    ),
    _figure(
        "lost_motion",
        "rad",
        "range of the angle of the second body relative to the first, play and deflection; the width of the loop of "
        "output over input of a drive that reverses",
        (Entry("forces", "lost motion", 29, if_any=True), Entry("case", "lost motion", 11)),
        value=lost_motion,
    ),
    _figure(
        "transmission_error",
        "rad",
        "largest angle of the second body from where it would be without play and deflection",
        (Entry("forces", "transmission error", 30, if_any=True),),
        value=transmission_error,
    ),
    _figure(
        "torque_peak",
        "N*m",
        "largest torque of the flanks on the second body, located",
        (Entry("forces", "torque peak", 31, if_any=True), Entry("case", "torque peak", 12)),
        value=torque_peak,
    ),
    _figure(
        "torque_peak_ideal",
        "N*m",
        "largest torque on the second body in the ideal mechanism",
        (Entry("forces", "ideal torque peak", 32, if_any=True),),
        needs="turns",
        value=torque_peak_ideal,
        differs=False,
    ),
)
