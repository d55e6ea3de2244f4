"""Sentences on a start-up: the time until a motor reaches its speed, starts that were cut off, the speed after it."""

import math
from functools import partial

import numpy as np

from ..contracts.machine import STARTED_FRACTION
from ..language import wording
from . import effects
from .case_ranking import MAX_SPEED, SPEED_AFTER_START, START_UP
from .cases import FinishedCases

FORCE_DURING_START = "force_peak_start"  # figure of a joint
SWING_ENDS = (SPEED_AFTER_START, MAX_SPEED)  # columns: lowest and highest speed after the start-up time
PERIOD = "period"  # column
LONGER_RUNS = "In longer runs the peak may be higher."
LONGER_RUNS_OF_STARTED = "In longer runs the started cases may have higher peaks, too."
MAX_SHARED = 4  # varied values in one sentence
REVOLUTION_MARGIN = 1.25  # revolutions to set over those estimated: the speed swings, so that the estimate is too low


def sentences(cases: FinishedCases) -> list[str]:
    """Return sentences on the start-up time and its drivers, on starts that were cut off, and on the speed after it."""
    no_load_speed = _no_load_speed(cases)
    if no_load_speed is None:
        return []
    target, no_load_text = cases.format_values(MAX_SPEED, [STARTED_FRACTION * no_load_speed, no_load_speed])
    target_text = f"{target}, 95 % of the motor's no-load speed of {no_load_text}"
    return [
        *_time_sentences(cases, target_text),
        *_cut_off_sentences(cases, target_text, no_load_speed),
        *_swing_sentences(cases, target, no_load_speed),
    ]


def _time_sentences(cases: FinishedCases, target_text: str) -> list[str]:
    """Return sentences on the time until the crank first reaches the speed, its drivers, and values that reach it."""
    times = cases.values_of(START_UP)
    reached_count = int(np.isfinite(times).sum())
    if not reached_count:
        return []
    range_texts = cases.format_values(START_UP, [float(np.nanmin(times)), float(np.nanmax(times))])
    time_range = " to ".join(dict.fromkeys(range_texts))
    count_text = f"{reached_count} of {wording.count_text(len(times), 'case')}" if len(times) > 1 else "The case"
    verb = "reach" if reached_count > 1 else "reaches"
    text = f"{count_text} {verb} {target_text}, for the first time after {time_range}."
    effect_sentences = (
        effects.sentences(cases, "start-up time", times, partial(cases.format_values, START_UP))
        if _is_varied(times)
        else []
    )
    reaching = _settings_text(cases, _shared_values(cases, np.isfinite(times)))
    reaching_sentences = [f"Every case with {reaching} does."] if reaching else []
    return [" ".join([text, *reaching_sentences, *effect_sentences])]


def _swing_sentences(cases: FinishedCases, target: str, no_load_speed: float) -> list[str]:
    """Return sentences on the speed after the start-up time: its middle, its largest swing, and its drivers."""
    widest = _widest_swing(cases)
    if widest is None:
        return []
    lowest, highest = (cases.values_of(name).astype(float) for name in SWING_ENDS)
    middles, swings = 0.5 * (lowest + highest), highest - lowest
    middle_ends = [float(np.nanmin(middles)), float(np.nanmax(middles))]
    middle_text = " to ".join(dict.fromkeys(cases.format_values(MAX_SPEED, middle_ends)))
    low, high = _swing_texts(cases, widest)
    overshoot = float(highest[widest]) / no_load_speed - 1.0
    overshoot_text = f", up to {wording.percent_text(overshoot)} above no load" if overshoot > 0.0 else ""
    half_width = wording.percent_text(0.5 * float(swings[widest] / middles[widest]))
    swing_text = f"\u00b1{half_width}, between {low} and {high}{overshoot_text}"
    swing_sentence = f"The largest swing is {swing_text}{cases.setting_text(widest)}."
    effect_sentences = effects.sentences(
        cases, "swing", np.where(np.isfinite(lowest), swings, np.nan), partial(cases.format_values, MAX_SPEED), 1
    )
    text = f"After that, the speed swings around {middle_text}, the middle of its extremes."
    return [" ".join([text, swing_sentence, *effect_sentences, _below_sentence(lowest, target, no_load_speed)])]


def _below_sentence(lowest: np.ndarray, target: str, no_load: float) -> str:
    """Return a sentence on the started cases that fall below the speed again; lowest : (n,) rad/s, after the start."""
    below, reached = int((lowest < STARTED_FRACTION * no_load).sum()), int(np.isfinite(lowest).sum())
    if not below:
        return f"No started case falls below {target} again."
    count = f"{below} of {wording.count_text(reached, 'started case')}" if reached > 1 else "The case"
    return f"{count} {'fall' if below > 1 else 'falls'} below {target} again."


def _widest_swing(cases: FinishedCases) -> int | None:
    """Return the started case with the largest swing of the speed after its start-up time, or None."""
    if not cases.has_values(SPEED_AFTER_START):
        return None
    swings = cases.values_of(MAX_SPEED).astype(float) - cases.values_of(SPEED_AFTER_START).astype(float)
    return int(np.nanargmax(swings)) if np.isfinite(swings).any() else None


def _swing_texts(cases: FinishedCases, index: int) -> list[str]:
    return cases.format_values(MAX_SPEED, [float(cases.values_of(name)[index]) for name in SWING_ENDS])


def start_up_cards(cases: FinishedCases) -> list[tuple[str, str, str]]:
    """Return the cards on the start-up time, cut-off starts, and the speed after the start; [] without a motor."""
    no_load_speed = _no_load_speed(cases)
    if no_load_speed is None:
        return []
    times = cases.values_of(START_UP)
    cut_off_count, known_times = int(np.isnan(times).sum()), times[np.isfinite(times)]
    (target_text,) = cases.format_values(MAX_SPEED, [STARTED_FRACTION * no_load_speed])
    within = within_revolutions_text(cases)
    cut_off_text = f"; not reached{within}" if cut_off_count else ""
    range_texts = (
        dict.fromkeys(cases.format_values(START_UP, [float(known_times.min()), float(known_times.max())]))
        if known_times.size
        else ["none"]
    )
    cards = [("Start-up time", " to ".join(range_texts), f"until the speed first reaches {target_text}{cut_off_text}")]
    if cut_off_count and known_times.size:
        missing = _missing_text(cases, np.isnan(times))
        time_range = f"after {' to '.join(range_texts)}; not {missing or 'the others'}{within}"
        cards = [(f"Cases that reach {target_text}", f"{known_times.size} of {len(times)}", time_range)]
    widest = _widest_swing(cases)
    if widest is not None:
        swing = " to ".join(_swing_texts(cases, widest)).replace(f"{wording.BLANK}rpm to", " to")
        (middle_text,) = cases.format_values(
            MAX_SPEED, [float(np.mean([cases.values_of(name)[widest] for name in SWING_ENDS]))]
        )
        setting = cases.setting_text(widest).removeprefix(" at ")
        note = ", ".join(filter(None, (f"largest swing, around {middle_text}", setting)))
        cards.append(("Speed after that", swing, note))
    return cards


def start_force_text(cases: FinishedCases, joint: str) -> str:
    """Return the largest force of a joint until the start-up time in words, with its case; '' if it is unknown."""
    column_name = f"{joint}_{FORCE_DURING_START}"
    if not cases.has_values(column_name):
        return ""
    largest_case = cases.argmin_argmax(column_name)[1]
    return f"{cases.figure_text(column_name, largest_case)}{cases.setting_text(largest_case)}"


def _no_load_speed(cases: FinishedCases) -> float | None:
    """Return the no-load speed (rad/s) that all cases share, or None if there is none."""
    motor = (cases.record.get("drive") or {}).get("motor") or {}
    speed = motor.get("no_load_speed")
    if (
        not isinstance(speed, float)
        or "drive.motor.no_load_speed" in cases.varied_paths
        or not cases.has_values(MAX_SPEED)
    ):
        return None
    return speed


def _is_varied(times: np.ndarray) -> bool:
    known_times = times[np.isfinite(times)]
    return bool(known_times.size > 1 and np.ptp(known_times) > 0.0)


def _cut_off_sentences(cases: FinishedCases, target_text: str, no_load: float) -> list[str]:
    """Return sentences on the cases that do not reach the speed, their highest speed, and the remedy."""
    is_cut_off, speeds = np.isnan(cases.values_of(START_UP)), cases.values_of(MAX_SPEED)
    if not is_cut_off.any():
        return []
    fastest_case = int(np.argmax(np.where(is_cut_off, speeds, -np.inf)))
    fastest, within = cases.figure_text(MAX_SPEED, fastest_case), within_revolutions_text(cases)
    if is_cut_off.all():
        subject = "No case reaches" if len(speeds) > 1 else "The case does not reach"
        text = f"{subject} {target_text},{within}: at most {fastest}{cases.setting_text(fastest_case)}."
    elif missing := _missing_text(cases, is_cut_off):
        text = f"No case {missing} reaches it{within}: at most {fastest}."
    else:
        count_text = f"{int(is_cut_off.sum())} of {wording.count_text(len(speeds), 'case')}"
        verb = "does" if is_cut_off.sum() == 1 else "do"
        text = f"{count_text} {verb} not reach it{within}: at most {fastest}{cases.setting_text(fastest_case)}."
    return [f"{text} {_remedy(cases, float(speeds[fastest_case]) / no_load, is_cut_off)}"]


def _missing_text(cases: FinishedCases, is_cut_off: np.ndarray) -> str:
    """Return 'with drive inertia 0.008 kg*m^2' if such values explain all starts that were cut off, else ''."""
    shared = _shared_values(cases, is_cut_off)
    has_shared_value = np.any([has_value for _, has_value in shared], axis=0)
    return f"with {_settings_text(cases, shared)}" if shared and has_shared_value[is_cut_off].all() else ""


def _settings_text(cases: FinishedCases, shared: list[tuple[str, np.ndarray]]) -> str:
    """Return varied values in words: 'drive inertia 0.002 kg*m^2 or 0.008 kg*m^2'; shared : as of `_shared_values`."""
    texts: dict[str, list[str]] = {}
    for path, has_value in shared:
        pair = cases.describe_value(int(np.flatnonzero(has_value)[0]), path)
        if pair is not None:
            texts.setdefault(pair[0], []).append(pair[1])
    return " or ".join(f"{name} {' or '.join(values)}" for name, values in texts.items())


def _remedy(cases: FinishedCases, speed_fraction: float, is_cut_off: np.ndarray) -> str:
    """Return the sentences on the revolutions to set; speed_fraction : highest speed over that without load."""
    revolutions = _fixed_revolutions(cases)
    if not revolutions:
        return "To see whether it is reached later, run more revolutions."
    needed = _needed_revolutions(cases, revolutions, speed_fraction)
    if needed is None:
        return (
            f"If the speed still rises at the end of the run, run {2.0 * revolutions:g} revolutions or more. Otherwise "
            "the loads hold it there: reduce them, or use a stronger motor."
        )
    subject = "This case needs" if is_cut_off.sum() == 1 else "These cases need"
    rounded = max(math.ceil(REVOLUTION_MARGIN * needed), math.floor(revolutions) + 1)
    return f"{subject} about {needed:.0f} revolutions by the motor's torque: run {rounded} or more."


def _needed_revolutions(cases: FinishedCases, revolutions: float, speed_fraction: float) -> float | None:
    """Return the revolutions until a motor alone brings a constant inertia to its speed; None with loads.

    With the time constant T = inertia no_load / stall_torque and f = speed / no_load, the angle from rest is
    no_load T (-ln(1 - f) - f); its unknown factor follows from the speed at the end of the run.
    """
    initial_speed = (cases.record.get("drive") or {}).get("initial_speed") or 0.0
    if cases.record.get("loads") or initial_speed or not 0.0 < speed_fraction < STARTED_FRACTION:
        return None
    angles = [-math.log1p(-fraction) - fraction for fraction in (STARTED_FRACTION, speed_fraction)]
    return revolutions * angles[0] / angles[1]


def _fixed_revolutions(cases: FinishedCases) -> float | None:
    """Return the revolutions of a run, or None where they vary or are unknown."""
    revolutions = (cases.record.get("simulate") or {}).get("revolutions")
    return revolutions if isinstance(revolutions, float) and "simulate.revolutions" not in cases.varied_paths else None


def within_revolutions_text(cases: FinishedCases) -> str:
    """Return ' within 8 revolutions', or ' within its run' where their number varies."""
    revolutions = _fixed_revolutions(cases)
    if not revolutions:
        return " within its run"
    return f" within {revolutions:g} revolution{'' if revolutions == 1.0 else 's'}"


def force_of_cut_off(cases: FinishedCases, column: str) -> str:
    """Return what is known of a force of the starts that were cut off in words, or '' if there is none.

    column : the force
    """
    is_cut_off = np.isnan(cases.values_of(START_UP).astype(float)) & np.isfinite(cases.values_of(column).astype(float))
    if _no_load_speed(cases) is None or not is_cut_off.any() or is_cut_off.all():
        return ""
    force = float(cases.values_of(column)[is_cut_off].max())
    subject = _missing_text(cases, is_cut_off) or "of the starts that were cut off"
    force_text = cases.format_values(column, [force])[0]
    return f"unknown {subject}: {force_text} until the end of the run, but it may become the highest"


def may_peak_later(started: FinishedCases) -> bool:
    """Return whether a longer run may have higher peaks: the motion of some started case is not known to repeat."""
    periods = started.values_of(PERIOD).astype(float) if started.has_values(PERIOD) else np.array([np.nan])
    return _no_load_speed(started) is not None and bool(np.isnan(periods).any())


def started_cases(cases: FinishedCases) -> FinishedCases:
    """Return the starts that reached the motor's speed, for their forces; all cases where nothing starts or none did.

    A start that was cut off lacks the rest of its forces, so that its peak cannot be compared.
    """
    if cases.ranking.question != "start-up" or _no_load_speed(cases) is None:
        return cases
    started = np.flatnonzero(np.isfinite(cases.values_of(START_UP)))
    if len(started) in (0, len(cases.case_ids)):
        return cases
    return cases._replace(
        case_ids=[cases.case_ids[index] for index in started.tolist()],
        values_of=lambda name: cases.values_of(name)[started],
        describe_value=lambda index, path: cases.describe_value(int(started[index]), path),
    )


def _shared_values(cases: FinishedCases, is_member: np.ndarray) -> list[tuple[str, np.ndarray]]:
    """Return path and cases (n,) of each varied value all of whose cases are members, at most MAX_SHARED or none.

    A value has several cases unless only one path varies, so that it may explain them.
    """
    shared = []
    fewest = 1 if len(cases.varied_paths) == 1 else 2
    for path in cases.varied_paths if not is_member.all() else ():
        values = cases.values_of(path)
        if isinstance(values[0], str):
            continue
        for value in np.unique(values[is_member].astype(float)).tolist():
            has_value = values.astype(float) == value
            if has_value.sum() >= fewest and is_member[has_value].all():
                shared.append((path, has_value))
    return shared if len(shared) <= MAX_SHARED else []
