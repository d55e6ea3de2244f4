"""Sentence on the largest force peak to expect in many revolutions."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

FIGURE = "force_peak_million"
NEEDED = 100  # independent revolutions
ENDS = ("", "_high")


class Expected(NamedTuple):
    """The largest force peak to expect in a joint in 10^6 revolutions, and the largest of the window; N."""

    case_id: str
    joint: str  # as in columns
    value: float
    high: float  # exceeded with a probability of 2.5 %
    seen: float


def columns(joints: list[str]) -> list[str]:
    """Return the columns of the summary that the prediction needs."""
    return [name for joint in joints for name in (*_predicted(joint), f"{joint}_force_peak")] + ["period"]


def worst(block: Mapping[str, np.ndarray], joints: list[str]) -> Expected | None:
    """Return the largest peak to expect among finished non-periodic motions, or None if there is none."""
    highest: Expected | None = None
    irregular = np.isnan(np.asarray(block["period"], float)) if "period" in block else np.zeros(0, bool)
    for joint in joints:
        if f"{joint}_{FIGURE}" not in block or not irregular.any():
            continue
        values = np.where(irregular, np.asarray(block[f"{joint}_{FIGURE}"], float), np.nan)
        if np.isnan(values).all():
            continue
        index = int(np.nanargmax(values))
        figures = (float(block[name][index]) for name in (*_predicted(joint), f"{joint}_force_peak"))
        candidate = Expected(str(block["case_id"][index]), joint, *figures)
        highest = candidate if highest is None or candidate.value > highest.value else highest
    return highest


def sentence(figures: list[str], where: str) -> str:
    """Return a sentence with the expected peak.

    figures : value, upper end, and largest peak of the window, as texts
    where : ' in joint ... at ...'
    """
    value, high, largest = figures
    return (
        f"The largest force peak in 10⁶ revolutions is estimated at {value}, at most {high} (97.5 %){where}. The "
        f"largest peak in the window is {largest}."
    )


def _predicted(joint: str) -> list[str]:
    return [f"{joint}_{FIGURE}{suffix}" for suffix in ENDS]
