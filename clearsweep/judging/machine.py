"""Sentences on an identified machine: certainty of its values, and whether the model explains the signals."""

import math
from collections.abc import Mapping
from typing import Any

from ..language import wording

FAR = 3.0  # standard deviations above which a feature is mentioned
SPEED = 0.01  # rad, offset of the crank angle above which it is mentioned
LISTED = 4  # most features mentioned


def certainty(parameter: Mapping[str, Any]) -> str:
    """Return the remark on an interval: the data hardly determine the value, or the interval ends at the range."""
    words = {"not": "the data do not determine it", "weakly": "the data determine it weakly"}
    parts = [words[parameter["determined"]]] if parameter["determined"] in words else []
    if parameter["ends"] and parameter["determined"] == "well":
        parts.append(f"the interval ends at the {' and '.join(parameter['ends'])} end of its range: widen the range")
    return f"; {', '.join(parts)}" if parts else ""


def difference(fit: Mapping[str, Any]) -> str:
    """Return the difference between a computed and a measured feature in words."""
    if not fit["measured"]:
        return ""
    off = 100.0 * (fit["computed"] / fit["measured"] - 1.0)
    return f" ({off:+.3g} %)" if math.isfinite(off) else ""


def sentences(identified: Mapping[str, Any], joints: int) -> list[str]:
    """Return the sentences on misfit, keys that trade off, priors and treatment of the signals."""
    lines = [_misfit(identified)]
    for first, second, size in identified["traded"]:
        names = f"{wording.axis_name(first, joints)} and {wording.axis_name(second, joints)}"
        lines.append(f"{names} trade off (correlation {size:.2f}): the data determine a combination of them.")
    for each in identified["signals"]:
        noise, low, high = (f"{100.0 * share:.2g}" for share in each["noise"])
        lines.append(
            f"{each['channel']} of {each['file']}: {each['revolutions']} revolutions of {each['samples']:.4g} samples, "
            f"compared up to order {each['orders']:.3g}; crank angle {math.degrees(each['angle']):.3g} deg ahead, "
            f"noise {noise} % of the rms (95 %: {low} to {high} %)."
        )
        speed, own = each["speed"], identified["computed_speed"]
        if speed and abs(speed / own - 1.0) > SPEED:
            lines.append(
                f"{each['file']}: the measured speed is {speed * 30.0 / math.pi:.5g} rpm, but the cases have "
                f"{own * 30.0 / math.pi:.5g} rpm; write the measured speed under drive."
            )
    gain, ends = identified["priors"]["gain"], [100.0 * share for share in identified["priors"]["noise"]]
    lines.append(
        f"Priors: even over each range; gain within {196.0 * gain:.2g} % (95 %); offset and crank angle free; noise "
        f"{ends[0]:.2g} to {ends[1]:.2g} % of the rms."
    )
    return lines


def _misfit(identified: Mapping[str, Any]) -> str:
    """Return the sentence on whether the model explains the measurement."""
    if identified["explained"]:
        return "The model explains the measurement within the assumed errors; smaller model errors are not detected."
    far = sorted(
        (each for each in identified["fits"] if abs(each["deviations"]) > FAR),
        key=lambda each: -abs(each["deviations"]),
    )
    named = [f"{each['channel']}, {each['feature']}{difference(each)}" for each in far[:LISTED]]
    where = f"; largest differences: {wording.sentence_list(named)}" if named else ""
    return (
        f"Misfit: no values of these keys explain the measurement{where}. Errors are "
        f"{math.sqrt(identified['misfit']):.2g} times the assumed ones, so the intervals are widened; "
        "another law or a missing effect may be the reason."
    )
