"""Comparison of clearances at equal other values: the one with the thickest film, and its loss."""

import numpy as np

from ..language import wording
from . import labels
from .cases import Cases

CaseByClearance = dict[float, int]  # clearance (m) -> index of the case with it


def sentences(cases: Cases, thickness: str, loss: str) -> list[str]:
    """Return sentences on the clearance with the thickest film in most combinations of the other values; [] if none.

    thickness, loss : columns
    """
    path = next((path for path in cases.axes if path.endswith(".clearance")), None)
    if path is None or len(cases.axes) < 2 or path in (cases.record.get("sample") or {}).get("drawn", {}):
        return []
    groups = _groups(cases, path)
    thicknesses = cases.column(thickness).astype(float)
    groups = [group for group in groups if np.isfinite(thicknesses[list(group.values())]).all()]
    if not groups:
        return []
    thickest = [max(group, key=lambda clearance: thicknesses[group[clearance]]) for group in groups]
    best_clearance = max(sorted(set(thickest)), key=thickest.count)
    total = len(groups)
    setting = labels.capital(cases.setting(groups[0][best_clearance], (path,)))
    combinations = wording.count(total, "combination")
    text = f"{setting} has the thickest film in {thickest.count(best_clearance)} of {combinations} of the other values"
    if cases.has(loss):
        losses = cases.column(loss).astype(float)
        least_loss_count = sum(
            bool(losses[group[best_clearance]] <= min(losses[index] for index in group.values())) for group in groups
        )
        text += f", and the least loss in {least_loss_count} of {total}"
    return [f"{text}."]


def _groups(cases: Cases, path: str) -> list[CaseByClearance]:
    """Return the cases with equal other values, where these have all values of a path and there are several."""
    values, others = cases.column(path), [cases.column(other) for other in cases.axes if other != path]
    groups: dict[tuple, CaseByClearance] = {}
    for index in range(len(cases.case_ids)):
        groups.setdefault(tuple(str(column_values[index]) for column_values in others), {})[float(values[index])] = (
            index
        )
    count = len({float(value) for value in values})
    return [group for group in groups.values() if len(group) == count > 1]
