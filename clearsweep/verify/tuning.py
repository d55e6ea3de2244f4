"""Tunes a parameter of a case by bisection, until a contact just grazes or two joints touch at the same time."""

import copy
from collections.abc import Callable
from typing import Any

import numpy as np

from .. import grid
from ..contracts.case import column_name
from ..simulation.analyses.trajectory import simulate
from ..simulation.setup import scene
from .extremes import ExtremeCase

TUNED_REVOLUTIONS = 0.25  # revolutions within which the onsets are compared
SCAN_VALUES = 64  # values of the parameter between which a change of the count of onsets is searched for
MAX_HALVINGS = 60
GRAZE_RATIO = 1e-4  # of the largest onset rate: a graze closes slower


def tune_case(case: ExtremeCase) -> tuple[dict[str, Any], str]:
    """Return the grid of a case with its tuned parameter, and a note with the value."""
    kind, path, low, high = case.tuning
    search = _find_graze if kind == "graze" else _find_meeting
    value, remark = search(case, path, low, high)
    return replace_value(case.grid, path, value), f"{path} = {value!r}; {remark}"


def replace_value(source: dict[str, Any], path: str, value: Any) -> dict[str, Any]:
    """Return a grid with the value at a dotted path replaced."""
    source = copy.deepcopy(source)
    section = source
    *parents, last_key = path.split(".")
    for key in parents:
        section = section[key]
    section[last_key] = value
    return source


def find_onsets(source: dict[str, Any], path: str, value: float) -> np.ndarray:
    """Return the event log's onsets within TUNED_REVOLUTIONS revolutions."""
    shortened = replace_value(replace_value(source, path, value), "simulate.revolutions", TUNED_REVOLUTIONS)
    events = simulate(scene.build(grid.load(shortened, scene.catalogue()).case(0)), times=[0.0]).events
    onsets: np.ndarray = events[events["kind"] == "on"]
    return onsets


def bisect(predicate: Callable[[float], bool], low: float, high: float) -> tuple[float, float]:
    """Return neighbours between `low`, where `predicate` is true, and `high`, where it is not."""
    for _ in range(MAX_HALVINGS):
        midpoint = 0.5 * (low + high)
        if midpoint in (low, high):
            break
        low, high = (midpoint, high) if predicate(midpoint) else (low, midpoint)
    return low, high


def _find_graze(case: ExtremeCase, path: str, low: float, high: float) -> tuple[float, str]:
    """Return the value at which an onset is about to vanish, closing ever slower."""
    values = np.geomspace(low, high, SCAN_VALUES)
    counts = [len(find_onsets(case.grid, path, value)) for value in values]
    for i in np.flatnonzero(np.diff(counts)):
        smaller_count = counts[i] if counts[i] < counts[i + 1] else counts[i + 1]
        bounds = (values[i], values[i + 1]) if counts[i] > smaller_count else (values[i + 1], values[i])

        def has_more(value: float, fewer: int = smaller_count) -> bool:
            return len(find_onsets(case.grid, path, value)) > fewer

        value, _ = bisect(has_more, *bounds)
        rates = find_onsets(case.grid, path, value)["rate"]
        if rates.min() < GRAZE_RATIO * rates.max():  # else an onset crossed the horizon
            return float(value), f"onset at {rates.min():.1e} m/s after {rates.max():.1e} m/s"
    raise LookupError(f"{case.name}: no graze between {low:g} and {high:g}")


def _find_meeting(case: ExtremeCase, path: str, low: float, high: float) -> tuple[float, str]:
    """Return the clearance at which the first onset of its joint falls upon one of the other joint."""
    joint = column_name(path.split(".")[1])

    def onsets_before(value: float) -> int:  # onsets of the other joint before the first one of this
        log = find_onsets(case.grid, path, value)
        own_rows = np.flatnonzero(log["joint"] == joint)
        return int(own_rows[0]) if own_rows.size else len(log)

    values = np.geomspace(low, high, SCAN_VALUES)
    counts = [onsets_before(value) for value in values]
    for i in np.flatnonzero(np.diff(counts)):
        if counts[i + 1] < counts[i]:
            continue

        def has_at_most(value: float, count: int = counts[i]) -> bool:
            return onsets_before(value) <= count

        value, _ = bisect(has_at_most, values[i], values[i + 1])
        log = find_onsets(case.grid, path, value)
        own_times, other_times = (log["t"][log["joint"] == joint], log["t"][log["joint"] != joint])
        if own_times.size and other_times.size > counts[i]:
            return float(value), f"onsets {abs(own_times[0] - other_times[counts[i]]):.1e} s apart"
    raise LookupError(f"{case.name}: no onsets of two joints meet between {low:g} and {high:g} m")
