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
        (full,) = cases.texts(FASTEST, [no_load])
        taken = " to ".join(dict.fromkeys(ends))
        text = f"Start-up to {target}, 95 % of the motor's no-load speed of {full}, takes {taken}."
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
    cut = f"{missing} of {wording.count(len(times), 'case')} cut off{_after(cases)}"
    remark = cut if missing else "to 95 % of the speed"
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
    count = f"{int(missing.sum())} of {wording.count(len(times), 'case')}"
    were = "was" if missing.sum() == 1 else "were"
    text = (
        f"{count} {were} cut off{_after(cases)}, before {target}: at most {cases.text(FASTEST, highest)}"
        f"{cases.at(highest)}."
    )
    shared = _shared(cases, missing)
    within = f" All with {wording.sentence_list(shared)} were." if shared else ""
    return [
        f"{text}{within} Their forces and errors lack the rest of the start. To see whether they reach the speed "
        "later, raise simulate.revolutions."
    ]


def _after(cases: Cases) -> str:
    """Return ' after 8 revolutions', or '' where their number varies."""
    turns = (cases.record.get("simulate") or {}).get("revolutions")
    if not isinstance(turns, float) or "simulate.revolutions" in cases.axes:
        return ""
    return f" after {turns:g} revolution{'' if turns == 1.0 else 's'}"


def finished(cases: Cases) -> Cases:
    """Return the starts that reached the motor's speed, for their forces; all cases where nothing starts or none did.

    A start that was cut off lacks the rest of its forces, so that its peak cannot be compared.
    """
    if cases.lead.question != "start-up" or _no_load_speed(cases) is None:
        return cases
    reached = np.flatnonzero(np.isfinite(cases.column(START_UP)))
    if len(reached) in (0, len(cases.case_ids)):
        return cases
    return cases._replace(
        case_ids=[cases.case_ids[index] for index in reached.tolist()],
        column=lambda name: cases.column(name)[reached],
        named_value=lambda index, path: cases.named_value(int(reached[index]), path),
    )


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
