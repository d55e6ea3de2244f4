"""Sentences on wear: its depth in 1000 hours, its drivers, and whether it is a forecast."""

from collections.abc import Mapping, Sequence

import numpy as np

from ..contracts.layout import JointLayout
from ..language import wording
from . import effects
from .cases import FinishedCases
from .validity import THOUSAND_HOURS


def sentences(cases: FinishedCases) -> list[str]:
    """Return sentences on the fastest wear of a body in each joint and, if surfaces evolve, the clearance growth."""
    lines = []
    for joint in cases.layout.joints:
        depths = depth_in_1000_hours(cases, joint)
        if depths is None:
            continue
        worst_index = int(np.nanargmax(depths))
        if growth_lines := _growth_sentences(cases, joint, worst_index):
            lines += growth_lines
            continue
        (depth_text,) = wording.texts_in_common_unit([float(depths[worst_index])], "m")
        text = (
            f"Deepest wear of one body{cases.joint_text(joint.name)}: {depth_text} per 1000 "
            f"h{cases.setting_text(worst_index)}."
        )
        remarks = forecast_remark(cases, joint, worst_index, float(depths[worst_index]))
        remarks += worn_away_sentences(cases, joint, depths)
        effect_sentences = effects.sentences(cases, effects.FIGURE_PRONOUN, depths, _depth_texts, 1)
        if remarks:  # 'it' would be the last one's subject
            effect_sentences = [sentence.replace("It ", "The depth ", 1) for sentence in effect_sentences]
        lines.append(" ".join([text, *remarks, *effect_sentences]))
    return lines


def depth_in_1000_hours(cases: FinishedCases, joint: JointLayout) -> np.ndarray | None:
    """Return the wear depth (m) of each case in 1000 hours at the rate of its window, or None without wear."""
    rate_column = f"{joint.name}_wear_rate_max"
    return (
        THOUSAND_HOURS * cases.values_of(rate_column).astype(float)
        if joint.wear_bins and cases.has_values(rate_column)
        else None
    )


def forecast_remark(
    cases: FinishedCases, joint: JointLayout, index: int, depth: float, subject: str = "This"
) -> list[str]:
    """Return the remark that a depth (m) in 1000 hours is no forecast if it exceeds the clearance, else []."""
    hours_text, clearance = clearance_hours_text(cases, joint, index, depth), _clearance(cases, joint, index)
    if not hours_text or clearance is None:
        return []
    (clearance_text,) = wording.texts_in_common_unit([clearance], "m")
    return [
        f"{subject} is not a forecast: after {hours_text} the wear reaches the clearance of {clearance_text}, and the "
        "rate changes."
    ]


def clearance_hours_text(cases: FinishedCases, joint: JointLayout, index: int, depth: float) -> str:
    """Return the hours after which the wear of a case equals its clearance; '' unless it does within 1000 hours.

    depth : m in 1000 hours
    """
    clearance = _clearance(cases, joint, index)
    if clearance is None or not depth > clearance:
        return ""
    return f"{wording.number_text(1000.0 * clearance / depth, 2)} h"


def worn_away_count(cases: FinishedCases, joint: JointLayout, depths: np.ndarray) -> int:
    """Return the number of cases whose wear exceeds the bearing radius; depths : (n,) m in 1000 hours."""
    radii = _lengths(cases, joint, "bearing_radius")
    return 0 if radii is None else int((depths > radii).sum())


def worn_away_sentences(cases: FinishedCases, joint: JointLayout, depths: np.ndarray) -> list[str]:
    """Return the alarm on bearings that are worn away within 1000 hours, or []; depths : (n,) m in 1000 hours."""
    count = worn_away_count(cases, joint, depths)
    if not count:
        return []
    total = wording.count_text(len(depths), "case")
    return [f"In {count} of {total} the bearing is worn away within 1000 h: check the wear coefficient and its unit."]


def _depth_texts(values: Sequence[float]) -> list[str]:
    return wording.texts_in_common_unit(values, "m")


def _growth_sentences(cases: FinishedCases, joint: JointLayout, worst_index: int) -> list[str]:
    """Return a sentence on the growth of the clearance per 1000 hours of the life of a case, or [] without a life."""
    growth_column, hours_column = (f"{joint.name}_{figure}" for figure in ("clearance_growth", "life_hours"))
    if not (cases.has_values(growth_column) and cases.has_values(hours_column)):
        return []
    growth_rate = (
        1000.0 * float(cases.values_of(growth_column)[worst_index]) / float(cases.values_of(hours_column)[worst_index])
    )
    if not np.isfinite(growth_rate):
        return []
    (growth_text,) = wording.texts_in_common_unit([growth_rate], "m")
    location = f"{cases.joint_text(joint.name)}{cases.setting_text(worst_index)}"
    return [f"Wear of both bodies widens the clearance{location} by {growth_text} per 1000 h of the life."]


def initial_clearance_text(cases: FinishedCases, name: str) -> str:
    """Return the clearance of a joint in words if all cases have the same, else ''; name : 'rod_slider'."""
    joint_name = wording.joint_name(name)
    section: Mapping = (cases.record.get("joints") or {}).get(joint_name) or {}
    value = None if f"joints.{joint_name}.clearance" in cases.varied_paths else section.get("clearance")
    return wording.texts_in_common_unit([value], "m")[0] if isinstance(value, float) and value > 0.0 else ""


def clearances(cases: FinishedCases, joint: JointLayout) -> np.ndarray | None:
    """Return the clearance (m) of a joint in each case (n,), or None if one is not a number above zero."""
    return _lengths(cases, joint, "clearance")


def _lengths(cases: FinishedCases, joint: JointLayout, key: str) -> np.ndarray | None:
    """Return a length (m) of a joint in each case (n,), or None if one is not a number above zero."""
    title = wording.joint_name(joint.name)
    path = f"joints.{title}.{key}"
    section: Mapping = (cases.record.get("joints") or {}).get(title) or {}
    value = cases.values_of(path) if path in cases.varied_paths else section.get(key)
    if not isinstance(value, float | np.ndarray):
        return None
    sizes = np.broadcast_to(np.asarray(value, float), (len(cases.case_ids),))
    return sizes if (sizes > 0.0).all() else None


def _clearance(cases: FinishedCases, joint: JointLayout, index: int) -> float | None:
    """Return the clearance (m) of a joint in a case, or None if it is not a fixed number."""
    sizes = clearances(cases, joint)
    return None if sizes is None else float(sizes[index])
