"""Sentences on an identified machine: certainty of its values, and whether the model explains the signals."""

import math
from collections.abc import Mapping
from typing import Any

from ..language import wording

MAX_DEVIATION = 3.0  # standard deviations above which a feature is mentioned
MAX_SPEED_DEVIATION = 0.01  # relative difference of measured and computed speed above which it is mentioned
MAX_NAMED_FEATURES = 4  # most features mentioned


def certainty_text(parameter: Mapping[str, Any]) -> str:
    """Return the remark on an interval: the data hardly determine the value, or the interval ends at the range."""
    remarks = {"not": "the data do not determine it", "weakly": "the data determine it weakly"}
    statements = [remarks[parameter["determined"]]] if parameter["determined"] in remarks else []
    if parameter["ends"] and parameter["determined"] == "well":
        statements.append(
            f"the interval ends at the {' and '.join(parameter['ends'])} end of its range: widen the range"
        )
    return f"; {', '.join(statements)}" if statements else ""


def difference_text(fit: Mapping[str, Any]) -> str:
    """Return the difference between a computed and a measured feature in words."""
    if not fit["measured"]:
        return ""
    percentage = 100.0 * (fit["computed"] / fit["measured"] - 1.0)
    return f" ({percentage:+.3g} %)" if math.isfinite(percentage) else ""


def sentences(identified: Mapping[str, Any], joint_count: int) -> list[str]:
    """Return the sentences on misfit, keys that trade off, priors and treatment of the signals."""
    lines = [_misfit_sentence(identified)]
    for first_key, second_key, correlation in identified["traded"]:
        names = f"{wording.axis_name(first_key, joint_count)} and {wording.axis_name(second_key, joint_count)}"
        lines.append(f"{names} trade off (correlation {correlation:.2f}): the data determine a combination of them.")
    for signal in identified["signals"]:
        noise_text, low_text, high_text = (f"{100.0 * noise_share:.2g}" for noise_share in signal["noise"])
        lines.append(
            f"{signal['channel']} of {signal['file']}: {signal['revolutions']} revolutions of {signal['samples']:.4g} "
            f"samples, compared up to order {signal['orders']:.3g}; crank angle {math.degrees(signal['angle']):.3g} "
            f"deg in advance, noise {noise_text} % of the rms (95 %: {low_text} to {high_text} %)."
        )
        speed, computed_speed = signal["speed"], identified["computed_speed"]
        if speed and abs(speed / computed_speed - 1.0) > MAX_SPEED_DEVIATION:
            lines.append(
                f"{signal['file']}: the measured speed is {speed * 30.0 / math.pi:.5g} rpm, but the cases have "
                f"{computed_speed * 30.0 / math.pi:.5g} rpm; set drive.speed to the measured speed."
            )
    gain, noise_range = (
        identified["priors"]["gain"],
        [100.0 * noise_share for noise_share in identified["priors"]["noise"]],
    )
    lines.append(
        f"Priors: even over each range; gain within {196.0 * gain:.2g} % (95 %); offset and crank angle free; noise "
        f"{noise_range[0]:.2g} to {noise_range[1]:.2g} % of the rms."
    )
    return lines


def _misfit_sentence(identified: Mapping[str, Any]) -> str:
    """Return the sentence on whether the model explains the measurement."""
    if identified["explained"]:
        return "The model explains the measurement within the assumed errors; smaller model errors are not detected."
    deviating = sorted(
        (fit for fit in identified["fits"] if abs(fit["deviations"]) > MAX_DEVIATION),
        key=lambda fit: -abs(fit["deviations"]),
    )
    descriptions = [
        f"{fit['channel']}, {fit['feature']}{difference_text(fit)}" for fit in deviating[:MAX_NAMED_FEATURES]
    ]
    location = f"; largest differences: {wording.sentence_list(descriptions)}" if descriptions else ""
    return (
        f"Misfit: no values of these keys explain the measurement{location}. Errors are "
        f"{math.sqrt(identified['misfit']):.2g} times the assumed ones, so the intervals are widened; "
        "another law or a missing effect may be the reason."
    )
