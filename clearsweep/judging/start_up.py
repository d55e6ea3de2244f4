"""Sentences on a start-up: starts that were cut off, the time until a motor reaches its speed, the speed after it."""

from functools import partial

import numpy as np

from ..language import wording
from . import effects
from .case_ranking import MAX_SPEED, SPEED_AFTER_START, START_UP
from .cases import Cases

FORCE_DURING_START = "force_peak_start"  # figure of a joint
STARTED_FRACTION = 0.95  # of the no-load speed, as in simulation.crank_clock


def sentences(cases: Cases) -> list[str]:
    """Return sentences on starts that were cut off, on the start-up time and its drivers, and on the speed after it."""
    no_load = _no_load_speed(cases)
    if no_load is None:
        return []
    target_text, no_load_text = cases.texts(MAX_SPEED, [STARTED_FRACTION * no_load, no_load])
    return [
        *_cut_off_sentences(cases, target_text),
        *_time_sentences(cases, target_text, no_load_text),
        *_swing_sentences(cases, target_text, no_load),
    ]


def _time_sentences(cases: Cases, target_text: str, no_load_text: str) -> list[str]:
    """Return sentences on the time until the crank first reaches the speed, and on its drivers."""
    times = cases.column(START_UP)
    reached = int(np.isfinite(times).sum())
    if not reached:
        return []
    ends = cases.texts(START_UP, [float(np.nanmin(times)), float(np.nanmax(times))])
    time_range = " to ".join(dict.fromkeys(ends))
    count = f"{reached} of {wording.count(len(times), 'case')}" if len(times) > 1 else "The case"
    verb = "reach" if reached > 1 else "reaches"
    text = (
        f"{count} {verb} {target_text}, 95 % of the motor's no-load speed of {no_load_text}, for the first time after "
        f"{time_range}."
    )
    effect_sentences = (
        effects.sentences(cases, "start-up time", times, partial(cases.texts, START_UP)) if _varies(times) else []
    )
    return [" ".join([text, *effect_sentences])]


def _swing_sentences(cases: Cases, target_text: str, no_load: float) -> list[str]:
    """Return sentences on the speed after the start-up time: its largest swing, and cases that fall below it again."""
    widest = _widest_swing(cases)
    if widest is None:
        return []
    lowest = cases.column(SPEED_AFTER_START).astype(float)
    reached = int(np.isfinite(lowest).sum())
    low, high = _swing_texts(cases, widest)
    overshoot = float(cases.column(MAX_SPEED)[widest]) / no_load - 1.0
    overshoot_text = f", up to {wording.percent(overshoot)} above no load" if overshoot > 0.0 else ""
    setting = cases.setting_text(widest)
    text = f"After that, the speed swings between {low} and {high}{overshoot_text}{setting}, the largest swing."
    below_count = int((lowest < STARTED_FRACTION * no_load).sum())
    if not below_count:
        return [f"{text} No started case falls below {target_text} again."]
    count = f"{below_count} of {wording.count(reached, 'started case')}" if reached > 1 else "The case"
    return [f"{text} {count} {'fall' if below_count > 1 else 'falls'} below {target_text} again."]


def _widest_swing(cases: Cases) -> int | None:
    """Return the started case with the largest swing of the speed after its start-up time, or None."""
    if not cases.has(SPEED_AFTER_START):
        return None
    swings = cases.column(MAX_SPEED).astype(float) - cases.column(SPEED_AFTER_START).astype(float)
    return int(np.nanargmax(swings)) if np.isfinite(swings).any() else None


def _swing_texts(cases: Cases, index: int) -> list[str]:
    return cases.texts(MAX_SPEED, [float(cases.column(name)[index]) for name in (SPEED_AFTER_START, MAX_SPEED)])


def cards(cases: Cases) -> list[tuple[str, str, str]]:
    """Return the cards on the start-up time, cut-off starts, and the speed after the start; [] without a motor."""
    no_load = _no_load_speed(cases)
    if no_load is None:
        return []
    times = cases.column(START_UP)
    cut_count, known = int(np.isnan(times).sum()), times[np.isfinite(times)]
    (target_text,) = cases.texts(MAX_SPEED, [STARTED_FRACTION * no_load])
    cut = (
        f"; {cut_count} of {wording.count(len(times), 'case')} cut off{_after_revolutions_text(cases)}"
        if cut_count
        else ""
    )
    ends = dict.fromkeys(cases.texts(START_UP, [float(known.min()), float(known.max())])) if known.size else ["none"]
    cards_shown = [("Start-up time", " to ".join(ends), f"until the speed first reaches {target_text}{cut}")]
    if cut_count and known.size:
        time_range = f"after {' to '.join(ends)}; the others were cut off{_after_revolutions_text(cases)}"
        cards_shown = [(f"Cases that reach {target_text}", f"{known.size} of {len(times)}", time_range)]
    widest = _widest_swing(cases)
    if widest is not None:
        swing = " to ".join(_swing_texts(cases, widest)).replace(f"{wording.BLANK}rpm to", " to")
        cards_shown.append(
            ("Speed after that", swing, f"largest swing,{cases.setting_text(widest).removeprefix(' at')}")
        )
    return cards_shown


def until_start(cases: Cases, joint: str) -> str:
    """Return the largest force of a joint until the start-up time in words, with its case; '' if it is unknown."""
    name = f"{joint}_{FORCE_DURING_START}"
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


def _varies(times: np.ndarray) -> bool:
    known = times[np.isfinite(times)]
    return bool(known.size > 1 and np.ptp(known) > 0.0)


def _cut_off_sentences(cases: Cases, target_text: str) -> list[str]:
    """Return sentences on the cases that do not reach the speed, their highest speed, and the remedy."""
    times, speeds = cases.column(START_UP), cases.column(MAX_SPEED)
    is_cut_off = np.isnan(times)
    if not is_cut_off.any():
        return []
    highest = int(np.argmax(np.where(is_cut_off, speeds, -np.inf)))
    count = f"{int(is_cut_off.sum())} of {wording.count(len(times), 'case')}" if len(times) > 1 else "The case"
    were = "was" if is_cut_off.sum() == 1 else "were"
    shared = _shared_settings(cases, is_cut_off)
    shared_sentence = f" All with {wording.sentence_list(shared)} were." if shared else ""
    revolutions = _revolutions(cases)
    remedy = (
        f"set simulate.revolutions to {2.0 * revolutions:g} or more" if revolutions else "raise simulate.revolutions"
    )
    return [
        f"{count} {were} cut off{_after_revolutions_text(cases)}, before {target_text}: at most "
        f"{cases.text(MAX_SPEED, highest)}{cases.setting_text(highest)}.{shared_sentence} "
        f"To see whether the speed is reached later, {remedy}. "
        "Forces and errors below leave such cases out, so they are lower bounds: these cases may exceed them."
    ]


def _revolutions(cases: Cases) -> float | None:
    """Return the revolutions of a run, or None where they vary or are unknown."""
    revolutions = (cases.record.get("simulate") or {}).get("revolutions")
    return revolutions if isinstance(revolutions, float) and "simulate.revolutions" not in cases.axes else None


def _after_revolutions_text(cases: Cases) -> str:
    """Return ' after 8 revolutions', or '' where their number varies."""
    revolutions = _revolutions(cases)
    return f" after {revolutions:g} revolution{'' if revolutions == 1.0 else 's'}" if revolutions else ""


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


def _shared_settings(cases: Cases, is_cut_off: np.ndarray) -> list[str]:
    """Return the varied values, in words, with which no case reaches the speed."""
    settings = []
    for path in cases.axes:
        values = cases.column(path)
        if isinstance(values[0], str):
            continue
        for value in np.unique(values[is_cut_off].astype(float)).tolist():
            has_value = values.astype(float) == value
            if has_value.sum() > 1 and is_cut_off[has_value].all() and not is_cut_off.all():
                settings.append(cases.setting(int(np.flatnonzero(has_value)[0]), (path,)))
    return settings
