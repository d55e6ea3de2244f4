"""Wear in 1000 hours at the rate of the window, and how long that rate holds."""

import numpy as np

from ..contracts.layout import JointLayout
from ..language import wording
from .cases import FinishedCases
from .validity import THOUSAND_HOURS


def depth_in_1000_hours(cases: FinishedCases, joint: JointLayout) -> np.ndarray | None:
    """Return the wear depth (m) of each case in 1000 hours at the rate of its window, or None without wear."""
    rate_column = f"{joint.name}_wear_rate_max"
    if not (joint.wear_bins and cases.has_values(rate_column)):
        return None
    depth: np.ndarray = THOUSAND_HOURS * cases.values_of(rate_column).astype(float)
    return depth


def clearance_hours_text(cases: FinishedCases, joint: JointLayout, index: int, depth: float) -> str:
    """Return the hours after which the wear of a case equals its clearance; '' unless it does within 1000 hours.

    depth : m in 1000 hours
    """
    clearances = cases.number(f"joints.{wording.joint_name(joint.name)}.clearance")
    if clearances is None or not depth > clearances[index] > 0.0:
        return ""
    return f"{wording.number_text(1000.0 * float(clearances[index]) / depth, 2)} h"


def worn_away_count(cases: FinishedCases, joint: JointLayout, depths: np.ndarray) -> int:
    """Return the number of cases whose wear exceeds the bearing radius; depths : (n,) m in 1000 hours."""
    radii = cases.number(f"joints.{wording.joint_name(joint.name)}.bearing_radius")
    return 0 if radii is None else int((depths > radii).sum())
