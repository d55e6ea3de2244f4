"""Sentences on a start-up: starts that were cut off, the time until a motor reaches its speed, the speed after it."""

from functools import partial

import numpy as np

from ..language import wording
from . import effects
from .case_ranking import MAX_SPEED, SPEED_AFTER_START, START_UP
from .cases import Cases

UNTIL = "force_peak_start"  # figure of a joint


def sentences(cases: Cases) -> list[str]:
    """Return sentences on starts that were cut off, on the start-up time and its drivers, and on the speed after it."""
    no_load = _no_load_speed(cases)
    if no_load is None:
        return []
    target, full = cases.texts(MAX_SPEED, [0.95 * no_load, no_load])
    return [*_cut_off(cases, target), *_times(cases, target, full), *_swing(cases, target, no_load)]


def _times(cases: Cases, target: str, full: str) -> list[str]:
    """Return sentences on the time until the crank first reaches the speed, and on its drivers."""
    times = cases.column(START_UP)
    reached = int(np.isfinite(times).sum())
    if not reached:
        return []
    ends = cases.texts(START_UP, [float(np.nanmin(times)), float(np.nanmax(times))])
    taken = " to ".join(dict.fromkeys(ends))
    count = f"{reached} of {wording.count(len(times), 'case')}" if len(times) > 1 else "The case"
    verb = "reach" if reached > 1 else "reaches"
    text = f"{count} {verb} {target}, 95 % of the motor's no-load speed of {full}, for the first time after {taken}."
    moved = effects.sentences(cases, "start-up time", times, partial(cases.texts, START_UP)) if _spread(times) else []
    return [" ".join([text, *moved])]


def _swing(cases: Cases, target: str, no_load: float) -> list[str]:
    """Return sentences on the speed after the start-up time: its largest swing, and cases that fall below it again."""
    widest = _widest_swing(cases)
    if widest is None:
        return []
    lowest = cases.column(SPEED_AFTER_START).astype(float)
    reached = int(np.isfinite(lowest).sum())
    low, high = _swing_words(cases, widest)
    over = float(cases.column(MAX_SPEED)[widest]) / no_load - 1.0
    above = f", up to {wording.percent(over)} above no load" if over > 0.0 else ""
    text = (
        f"After that, the speed swings between {low} and {high}{above}{cases.setting_text(widest)}, the largest swing."
    )
    below = int((lowest < 0.95 * no_load).sum())
    if not below:
        return [f"{text} No started case falls below {target} again."]
    count = f"{below} of {wording.count(reached, 'started case')}" if reached > 1 else "The case"
    return [f"{text} {count} {'fall' if below > 1 else 'falls'} below {target} again."]


def _widest_swing(cases: Cases) -> int | None:
    """Return the started case with the largest swing of the speed after its start-up time, or None."""
    if not cases.has(SPEED_AFTER_START):
        return None
    swings = cases.column(MAX_SPEED).astype(float) - cases.column(SPEED_AFTER_START).astype(float)
    return int(np.nanargmax(swings)) if np.isfinite(swings).any() else None


def _swing_words(cases: Cases, index: int) -> list[str]:
    return cases.texts(MAX_SPEED, [float(cases.column(name)[index]) for name in (SPEED_AFTER_START, MAX_SPEED)])


def cards(cases: Cases) -> list[tuple[str, str, str]]:
    """Return the cards on the start-up time, cut-off starts, and the speed after the start; [] without a motor."""
    no_load = _no_load_speed(cases)
    if no_load is None:
        return []
    times = cases.column(START_UP)
    missing, known = int(np.isnan(times).sum()), times[np.isfinite(times)]
    (target,) = cases.texts(MAX_SPEED, [0.95 * no_load])
    cut = f"; {missing} of {wording.count(len(times), 'case')} cut off{_after(cases)}" if missing else ""
    ends = dict.fromkeys(cases.texts(START_UP, [float(known.min()), float(known.max())])) if known.size else ["none"]
    shown = [("Start-up time", " to ".join(ends), f"until the speed first reaches {target}{cut}")]
    if missing and known.size:
        taken = f"after {' to '.join(ends)}; the others were cut off{_after(cases)}"
        shown = [(f"Cases that reach {target}", f"{known.size} of {len(times)}", taken)]
    widest = _widest_swing(cases)
    if widest is not None:
        swing = " to ".join(_swing_words(cases, widest)).replace(f"{wording.BLANK}rpm to", " to")
        shown.append(("Speed after that", swing, f"largest swing,{cases.setting_text(widest).removeprefix(' at')}"))
    return shown


def until_start(cases: Cases, joint: str) -> str:
    """Return the largest force of a joint until the start-up time in words, with its case; '' if it is unknown."""
    name = f"{joint}_{UNTIL}"
    if not cases.has(name):
        return ""
    largest = cases.extremes(name)[1]
    return f"{cases.text(name, largest)}{cases.setting_text(largest)}"


def _no_load_speed(cases: Cases) -> float | None:
    """Return the no-load speed (rad/s) that all cases share, or None if there is none."""
    motor = (cases.record.get("drive") or {}).get("motor") or {}
    no_load = motor.get("no_load_speed")
    if not isinstance(no_load, float) or "drive.motor.no_load_speed" in cases.axes or not cases.has(MAX_SPEED):
        return None
    return no_load


def _spread(times: np.ndarray) -> bool:
    known = times[np.isfinite(times)]
    return bool(known.size > 1 and np.ptp(known) > 0.0)


def _cut_off(cases: Cases, target: str) -> list[str]:
    """Return sentences on the cases that do not reach the speed, their highest speed, and the remedy."""
    times, speeds = cases.column(START_UP), cases.column(MAX_SPEED)
    missing = np.isnan(times)
    if not missing.any():
        return []
    highest = int(np.argmax(np.where(missing, speeds, -np.inf)))
    count = f"{int(missing.sum())} of {wording.count(len(times), 'case')}" if len(times) > 1 else "The case"
    were = "was" if missing.sum() == 1 else "were"
    shared = _shared(cases, missing)
    within = f" All with {wording.sentence_list(shared)} were." if shared else ""
    turns = _turns(cases)
    longer = f"set simulate.revolutions to {2.0 * turns:g} or more" if turns else "raise simulate.revolutions"
    return [
        f"{count} {were} cut off{_after(cases)}, before {target}: at most {cases.text(MAX_SPEED, highest)}"
        f"{cases.setting_text(highest)}.{within} To see whether the speed is reached later, {longer}. "
        "Forces and errors below leave such cases out, so they are lower bounds: these cases may exceed them."
    ]


def _turns(cases: Cases) -> float | None:
    """Return the revolutions of a run, or None where they vary or are unknown."""
    turns = (cases.record.get("simulate") or {}).get("revolutions")
    return turns if isinstance(turns, float) and "simulate.revolutions" not in cases.axes else None


def _after(cases: Cases) -> str:
    """Return ' after 8 revolutions', or '' where their number varies."""
    turns = _turns(cases)
    return f" after {turns:g} revolution{'' if turns == 1.0 else 's'}" if turns else ""


def started(cases: Cases) -> Cases:
    """Return the starts that reached the motor's speed, for their forces; all cases where nothing starts or none did.

    A start that was cut off lacks the rest of its forces, so that its peak cannot be compared.
    """
    if cases.ranking.question != "start-up" or _no_load_speed(cases) is None:
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
