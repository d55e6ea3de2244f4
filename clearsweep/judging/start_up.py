"""Sentences on a start-up: the time in which a motor reaches its speed, and the cases that do not reach it."""

from functools import partial

import numpy as np

from ..language import wording
from . import effects
from .cases import Cases
from .order import FASTEST, START_UP


def sentences(cases: Cases) -> list[str]:
    """Return sentences on the start-up time, its drivers, cases that fail to start, and the overshoot of the speed."""
    no_load = _no_load_speed(cases)
    if no_load is None:
        return []
    times, speeds = cases.column(START_UP), cases.column(FASTEST)
    (target,) = cases.texts(FASTEST, [0.95 * no_load])
    lines = []
    if np.isfinite(times).any():
        ends = cases.texts(START_UP, [float(np.nanmin(times)), float(np.nanmax(times))])
        text = f"Start-up to {target}, 95 % of the motor's no-load speed, takes {' to '.join(dict.fromkeys(ends))}."
        moved = (
            effects.sentences(cases, "start-up time", times, partial(cases.texts, START_UP)) if _spread(times) else []
        )
        lines.append(" ".join([text, *moved]))
    lines += _not_reached(cases, target)
    fastest = int(np.nanargmax(speeds))
    if speeds[fastest] > no_load:
        over = wording.percent(float(speeds[fastest]) / no_load - 1.0)
        lines.append(
            f"The crank exceeds the no-load speed by up to {over}: {cases.text(FASTEST, fastest)}{cases.at(fastest)}."
        )
    return lines


def card(cases: Cases) -> tuple[str, str] | None:
    """Return the start-up times as 'shortest to longest' and a note on cases that fail; None without a motor."""
    if _no_load_speed(cases) is None:
        return None
    times = cases.column(START_UP)
    missing, known = int(np.isnan(times).sum()), times[np.isfinite(times)]
    remark = f"not reached in {missing} of {wording.count(len(times), 'case')}" if missing else "to 95 % of the speed"
    ends = dict.fromkeys(cases.texts(START_UP, [float(known.min()), float(known.max())])) if known.size else ["none"]
    return " to ".join(ends), remark


def _no_load_speed(cases: Cases) -> float | None:
    """Return the no-load speed (rad/s) that all cases share, or None if there is none."""
    motor = (cases.record.get("drive") or {}).get("motor") or {}
    no_load = motor.get("no_load_speed")
    if not isinstance(no_load, float) or "drive.motor.no_load_speed" in cases.axes or not cases.has(FASTEST):
        return None
    return no_load


def _spread(times: np.ndarray) -> bool:
    known = times[np.isfinite(times)]
    return bool(known.size > 1 and np.ptp(known) > 0.0)


def _not_reached(cases: Cases, target: str) -> list[str]:
    """Return sentences on the cases that do not reach the speed, their common values, and their highest speed."""
    times, speeds = cases.column(START_UP), cases.column(FASTEST)
    missing = np.isnan(times)
    if not missing.any():
        return []
    highest = int(np.argmax(np.where(missing, speeds, -np.inf)))
    within = ""
    if isinstance(revolutions := (cases.record.get("simulate") or {}).get("revolutions"), float):
        within = f" within {wording.count(int(revolutions), 'revolution')}"
    count = f"{int(missing.sum())} of {wording.count(len(times), 'case')}"
    text = f"{count} did not reach {target}{within}: at most {cases.text(FASTEST, highest)}{cases.at(highest)}."
    shared = _shared(cases, missing)
    return [f"{text} None with {wording.sentence_list(shared)} reached it." if shared else text]


def _shared(cases: Cases, missing: np.ndarray) -> list[str]:
    """Return the varied values, in words, with which no case reaches the speed."""
    said = []
    for path in cases.axes:
        values = cases.column(path)
        if isinstance(values[0], str):
            continue
        for value in np.unique(values[missing].astype(float)).tolist():
            having = values.astype(float) == value
            if having.sum() > 1 and missing[having].all() and not missing.all():
                said.append(cases.setting(int(np.flatnonzero(having)[0]), (path,)))
    return said
