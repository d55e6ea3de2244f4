"""Comparison of clearances at equal other values: the one with the thickest film, and its loss."""

import numpy as np

from ..language import wording
from . import labels
from .cases import FinishedCases

CaseByClearance = dict[float, int]  # clearance (m) -> index of the case with it


def sentences(cases: FinishedCases, thickness_column: str, loss_column: str) -> list[str]:
    """Return sentences on the clearance with the thickest film in most combinations of the other values; [] if none.

    thickness_column, loss_column : of the summary
    """
    clearance_path = next(
        (clearance_path for clearance_path in cases.varied_paths if clearance_path.endswith(".clearance")), None
    )
    if (
        clearance_path is None
        or len(cases.varied_paths) < 2
        or clearance_path in (cases.record.get("sample") or {}).get("drawn", {})
    ):
        return []
    groups = _comparable_groups(cases, clearance_path)
    thicknesses = cases.values_of(thickness_column).astype(float)
    groups = [group for group in groups if np.isfinite(thicknesses[list(group.values())]).all()]
    if not groups:
        return []
    thickest_clearances = [max(group, key=lambda clearance: thicknesses[group[clearance]]) for group in groups]
    best_clearance = max(sorted(set(thickest_clearances)), key=thickest_clearances.count)
    group_count = len(groups)
    clearance_text = labels.capitalise(cases.values_text(groups[0][best_clearance], (clearance_path,)))
    combinations = wording.count_text(group_count, "combination")
    text = (
        f"{clearance_text} has the thickest film in {thickest_clearances.count(best_clearance)} of {combinations} of "
        "the other values"
    )
    if cases.has_values(loss_column):
        losses = cases.values_of(loss_column).astype(float)
        least_loss_count = sum(
            bool(losses[group[best_clearance]] <= min(losses[index] for index in group.values())) for group in groups
        )
        text += f", and the least loss in {least_loss_count} of {group_count}"
    return [f"{text}."]


def _comparable_groups(cases: FinishedCases, clearance_path: str) -> list[CaseByClearance]:
    """Return the cases with equal other values, where these have all values of a path and there are several."""
    clearances, other_columns = (
        cases.values_of(clearance_path),
        [cases.values_of(other) for other in cases.varied_paths if other != clearance_path],
    )
    groups: dict[tuple, CaseByClearance] = {}
    for index in range(len(cases.case_ids)):
        groups.setdefault(tuple(str(column_values[index]) for column_values in other_columns), {})[
            float(clearances[index])
        ] = index
    count = len({float(value) for value in clearances})
    return [group for group in groups.values() if len(group) == count > 1]
