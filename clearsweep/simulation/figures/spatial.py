"""Figures of spatial joints: tilt, edge loading and flange contacts."""

import math

from ...contracts.catalogue import ENDLESS, Entry, Figure
from ...mechanics.joints.spatial import jam_angle
from .sums import PerRevolution
from .window import Window


def tilt_limit(window: Window, index: int) -> float | None:
    """Return the tilt (rad) at which the journal jams between the walls, or None if it cannot."""
    angle = jam_angle(window.joints[index])
    return angle if math.isfinite(angle) else None


def edge_load_share(window: Window, index: int) -> float:
    """Return the imbalance of wall loads: difference of normal forces over their sum, both averaged over time."""
    joint = window.totals.joint[index]
    return float(joint.uneven_time / joint.force_time) if joint.force_time else 0.0


SPATIAL = (
    Figure(
        "tilt_max",
        "rad",
        "largest angle between the axes of bearing and journal",
        of="joint",
        needs=("spatial",),
        value=lambda window, index: window.totals.joint[index].tilt_max,
        tables=(Entry("forces", "tilt", 20),),
    ),
    Figure(
        "tilt_limit",
        "rad",
        "tilt at which the journal jams between the walls; null: no limit",
        of="joint",
        needs=("spatial",),
        value=tilt_limit,
        differs=False,
        null=ENDLESS,
        tables=(Entry("forces", "tilt that jams", 21),),
    ),
    Figure(
        "edge_load_share",
        "1",
        "difference of the walls' normal forces over their sum, as means over time; 0: even, 1: one edge carries all",
        of="joint",
        needs=("spatial",),
        value=edge_load_share,
        tables=(Entry("forces", "edge load share", 22),),
    ),
    Figure(
        "axial_force_peak",
        "N",
        "largest normal force at a flange, located",
        of="joint",
        needs=("spatial", "axial"),
        value=lambda window, index: window.totals.joint[index].axial_force_max,
        tables=(Entry("forces", "axial force peak", 23),),
    ),
    Figure(
        "axial_impacts_per_rev",
        "1",
        "contact onsets at the flanges in the window per revolution",
        of="joint",
        needs=("spatial", "axial"),
        sums=PerRevolution("axial_onsets"),
        tables=(Entry("forces", "axial impacts{per_rev}", 24),),
    ),
)
