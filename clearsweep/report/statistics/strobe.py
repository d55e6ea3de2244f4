"""Journals once per revolution, at crank angle 0: along an axis of a run, and in one case."""

from typing import NamedTuple

import numpy as np
import pandas as pd

from ..data.axis import Axis
from ..data.study import VARYING_SECTIONS, Joint, Study, recorded_revolutions

MAX_CASES = 120  # cases along an axis: more do not increase the density in print
MIN_POINTS = 3  # points of a case that make a picture


class Points(NamedTuple):
    """Positions of a journal at crank angle 0 of each revolution of some cases, concatenated; (n,) each."""

    value: np.ndarray  # of the axis, SI
    x: np.ndarray  # m
    y: np.ndarray  # m
    clearance: np.ndarray  # m, of the case; NaN if not a circle
    cases: int


def poincare_points(study: Study, joint: Joint, case_id: str) -> pd.DataFrame:
    """Return x, y (m), vx, vy (m/s) and `revolution` of a journal at crank angle 0 in the recorded window of a case."""
    frame = study.run.poincare(case_id)
    if frame.empty:
        return frame
    discarded, _ = recorded_revolutions(study.cases, study.base)
    frame = frame[frame["revolution"] >= discarded.iloc[study.cases.row_of(case_id)]]
    columns = {f"{joint.name}/{name}": name for name in ("x", "y", "vx", "vy")}
    return frame.rename(columns=columns)[["revolution", *columns.values()]].reset_index(drop=True)


def points_along_axis(study: Study, joint: Joint, axis: Axis, reference: str) -> Points:
    """Return the points of the cases along an axis that share all other values with the case `reference`."""
    values = study.cases[axis.path].to_numpy(float)
    indices = [index for index in cases_along_axis(study, axis, reference) if np.isfinite(values[index])]
    histories = [(index, poincare_points(study, joint, study.cases.index[index])) for index in indices]
    histories = [(index, frame) for index, frame in histories if len(frame)]
    clearances = [_clearance(study, joint, study.cases.index[index]) for index, _ in histories]
    counts = [len(frame) for _, frame in histories]

    def concatenate(name: str) -> np.ndarray:
        return np.concatenate([np.empty(0), *(frame[name].to_numpy(float) for _, frame in histories)])

    return Points(
        np.repeat(values[[index for index, _ in histories]], counts),
        concatenate("x"),
        concatenate("y"),
        np.repeat(np.array(clearances, float), counts),
        len(histories),
    )


def cases_along_axis(study: Study, axis: Axis, reference: str) -> list[int]:
    """Return the indices of at most MAX_CASES cases along an axis, by value; their other values are those of a case.

    For a drawn or parallel axis, the axes drawn or parallel with it vary as well.
    """
    varied_together = _paths_varied_together(study, axis)
    is_alike, reference_row = np.ones(len(study.cases), bool), study.cases.row_of(reference)
    for other in study.swept():
        if other is not axis and other.path not in varied_together:
            indices = study.indices_on(other)
            is_alike &= indices == indices[reference_row]
    rows = np.flatnonzero(is_alike)
    rows = rows[np.argsort(study.cases[axis.path].to_numpy(float)[rows], kind="stable")]
    return rows[np.unique(np.linspace(0, len(rows) - 1, min(len(rows), MAX_CASES)).round().astype(int))].tolist()


def _paths_varied_together(study: Study, axis: Axis) -> set[str]:
    """Return the paths whose values change together with an axis: parallel or drawn."""
    record = study.run.grid
    groups = [{*(record.get(section) or {})} for section in VARYING_SECTIONS if section in ("zip", "cases")]
    groups.append({*(record.get("sample") or {}).get("drawn", {})})
    return next((group for group in groups if axis.path in group), {axis.path})


def _clearance(study: Study, joint: Joint, case_id: str) -> float:
    value = study.value(case_id, f"joints.{joint.title}.clearance")
    return np.nan if value is None else float(value)
