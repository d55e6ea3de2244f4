"""How long the wear rate of the window is valid."""

from ..contracts.layout import JointLayout
from ..language import wording
from .cases import FinishedCases


def clearance_hours_text(cases: FinishedCases, joint: JointLayout, index: int, depth: float) -> str:
    """Return the hours after which the wear of a case equals its clearance; '' unless it does within 1000 hours.

    depth : m in 1000 hours
    """
    clearances = cases.number(f"joints.{wording.joint_name(joint.name)}.clearance")
    if clearances is None or not depth > clearances[index] > 0.0:
        return ""
    return f"{wording.number_text(1000.0 * float(clearances[index]) / depth, 2)} h"
