"""Comparison of measured and computed signals: the nearest case, the offset of the crank angle."""

from collections.abc import Mapping
from os import PathLike
from typing import NamedTuple

import numpy as np

from ...answers import features
from ...grid.written.tables import MeasuredSignals, read_signals
from ...language.errors import InputError
from ..data.study import Study

MIN_REVOLUTIONS = 3  # revolutions required in a measurement
MAX_CASES = 200  # compared cases; of more, evenly spaced ones
ACCELERATION = "acceleration"  # header of the output body's acceleration


class SignalComparison(NamedTuple):
    """One measured signal and the computed one of a case; SI."""

    channel: str
    unit: str
    file: str
    case_id: str
    compared: int  # cases
    measured: np.ndarray  # (turns, samples of a revolution), with corrected crank angle
    computed: np.ndarray  # the same of the case
    angle: float  # rad, offset of the measured angle
    misfit: float  # rms of the difference of the mean revolutions over the rms measured


def compare_signals(study: Study, file: str | PathLike) -> list[SignalComparison]:
    """Return the signals of a file with those of the nearest case; raise InputError if they cannot be compared."""
    units = {channel.name: channel.unit for channel in study.run.layout.stored if channel.unit}
    units.pop("t", None)
    names = {name: name for name in units} | _short_names(units)
    signals = read_signals(file, {name: units[channel] for name, channel in names.items()})
    ids = [str(name) for name in study.cases.index]
    compared_ids = [
        ids[index] for index in np.unique(np.linspace(0, len(ids) - 1, min(len(ids), MAX_CASES)).astype(int))
    ]
    orbits = {case_id: orbit for case_id in compared_ids if len(orbit := study.run.orbit(case_id)) > 1}
    if not orbits:
        raise InputError(f"{file}: this run has no time histories to compare with; run it with save: {{orbits: last}}")
    best: dict[str, SignalComparison] = {}
    for name, values in signals.signals.items():
        channel = names[name]
        for case_id, orbit in orbits.items():
            angle = _crank_angles(signals, orbit["crank_angle"].to_numpy(), orbit["t"].to_numpy())
            compared_pair = _compare_with_case(
                angle, values, orbit["crank_angle"].to_numpy(), orbit[channel].to_numpy(), signals
            )
            if channel not in best or compared_pair[3] < best[channel].misfit:
                best[channel] = SignalComparison(
                    channel, units[channel], signals.file, case_id, len(orbits), *compared_pair
                )
    return list(best.values())


def _short_names(units: Mapping[str, str]) -> dict[str, str]:
    """Return short name of a signal -> its channel."""
    channels = [name for name in ("slider/a", "output/a", "rocker/a") if name in units]
    return {ACCELERATION: channels[0]} if channels else {}


def _crank_angles(signals: MeasuredSignals, crank_angle: np.ndarray, times: np.ndarray) -> np.ndarray:
    """Return the crank angles (rad) of measured samples; of samples over time, from the mean speed of a case."""
    if signals.over == "crank_angle":
        return signals.abscissa
    return signals.abscissa * (crank_angle[-1] - crank_angle[0]) / (times[-1] - times[0])


def _compare_with_case(
    angle: np.ndarray, values: np.ndarray, crank_angle: np.ndarray, computed: np.ndarray, signals: MeasuredSignals
) -> tuple[np.ndarray, np.ndarray, float, float]:
    """Return the measured and computed revolutions, the angle (rad) between them, and the misfit."""
    highest_order = features.highest_common_order(
        features.samples_per_revolution(angle), features.samples_per_revolution(crank_angle)
    )
    revolutions = features.split_revolutions(angle, values, 0.0, highest_order)
    if len(revolutions) < MIN_REVOLUTIONS:
        raise InputError(
            f"{signals.file}: has {(angle[-1] - angle[0]) / features.TURN:.3g} revolutions; at least {MIN_REVOLUTIONS} "
            "whole ones, from crank angle 0 on, are needed"
        )
    computed_revolutions = features.split_revolutions(crank_angle, computed, 0.0, highest_order)
    if not len(computed_revolutions):
        raise InputError(f"{signals.file}: the cases have less than a revolution saved; write save: {{revolutions: 2}}")
    lag = features.find_lag(revolutions.mean(axis=0), computed_revolutions.mean(axis=0))
    revolutions = np.roll(revolutions.ravel(), -lag).reshape(revolutions.shape)
    revolutions = revolutions[:-1] if lag else revolutions  # the last one contains the start of the first
    mean_revolution = revolutions.mean(axis=0)
    measured_rms = float(np.sqrt(((mean_revolution - mean_revolution.mean()) ** 2).mean()))
    difference_rms = float(np.sqrt(((mean_revolution - computed_revolutions.mean(axis=0)) ** 2).mean()))
    phase_shift = features.TURN * lag / revolutions.shape[1]
    return (
        revolutions,
        computed_revolutions,
        phase_shift - features.TURN * (phase_shift > features.TURN / 2.0),
        difference_rms / measured_rms if measured_rms else np.inf,
    )
