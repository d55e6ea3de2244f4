"""Sentence on the largest force peak to expect in many revolutions."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

EXPECTED_PEAK_FIGURE = "force_peak_million"
MIN_REVOLUTIONS = 100  # independent revolutions
BOUND_SUFFIXES = ("", "_high")


class ExpectedPeak(NamedTuple):
    """The largest force peak to expect in a joint in 10^6 revolutions, N; its fields are keys of `run --json`."""

    case_id: str
    joint: str  # as in columns
    value: float
    high: float  # exceeded with a probability of 2.5 %
    seen: float  # largest peak of the window


def required_columns(joints: list[str]) -> list[str]:
    """Return the columns of the summary that the prediction needs."""
    return [name for joint in joints for name in (*_prediction_columns(joint), f"{joint}_force_peak")] + ["period"]


def largest_expected_peak(table: Mapping[str, np.ndarray], joints: list[str]) -> ExpectedPeak | None:
    """Return the largest peak to expect among finished non-periodic motions, or None if there is none."""
    largest_peak: ExpectedPeak | None = None
    is_irregular = np.isnan(np.asarray(table["period"], float)) if "period" in table else np.zeros(0, bool)
    for joint in joints:
        if f"{joint}_{EXPECTED_PEAK_FIGURE}" not in table or not is_irregular.any():
            continue
        values = np.where(is_irregular, np.asarray(table[f"{joint}_{EXPECTED_PEAK_FIGURE}"], float), np.nan)
        if np.isnan(values).all():
            continue
        index = int(np.nanargmax(values))
        figures = (float(table[name][index]) for name in (*_prediction_columns(joint), f"{joint}_force_peak"))
        candidate = ExpectedPeak(str(table["case_id"][index]), joint, *figures)
        largest_peak = candidate if largest_peak is None or candidate.value > largest_peak.value else largest_peak
    return largest_peak


def expected_peak_sentence(peak_texts: list[str], location: str) -> str:
    """Return a sentence with the expected peak.

    figures : value, upper end, and largest peak of the window, as texts
    location : ' in joint ... at ...'
    """
    value_text, bound_text, window_text = peak_texts
    return (
        f"The largest force peak in 10⁶ revolutions is estimated at {value_text}, at most {bound_text} (97.5 "
        f"%){location}. "
        f"The largest peak in the window is {window_text}."
    )


def _prediction_columns(joint: str) -> list[str]:
    return [f"{joint}_{EXPECTED_PEAK_FIGURE}{suffix}" for suffix in BOUND_SUFFIXES]
