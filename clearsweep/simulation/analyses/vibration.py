"""Computes the figures of vibration of a run from its recorded signals, and those of the ideal machine."""

import math
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from ...contracts.vibration import IDEAL, zone_of
from ...mechanics.machines.observed import axes_of
from ...mechanics.observe import AX, FORCE_SQUARE, FORCE_X, FORCE_Y, MOMENT, PLACE_WIDTH, PLACES
from ...mechanics.solver.slow_sums import DISSIPATED, DRIVE_POWER, DRIVE_TORQUE, SIGNALS
from ..machine.shaking import IdealShaking, ideal_shaking
from ..running.vibration import Signals
from ..setup.scene import Scene


class Motion(NamedTuple):
    """The velocity of a place along x or y in the band."""

    velocity_rms: float  # m/s
    band_energy: float  # m^2/s^4


def vibration_figures(scene: Scene, signals: Signals) -> dict[str, Any]:
    """Return the columns of vibration of a finished run."""
    signals.refine_extremes()
    values: dict[str, Any] = dict(_frame_figures(scene, signals))
    spectra, vibration = signals.spectra(), scene.case.vibration
    assert vibration is not None
    ideal = ideal_shaking(scene.case, scene.machine)
    values |= _ideal_figures(scene, ideal)
    values |= {"vibration_turns": spectra.turns, "vibration_resolution": spectra.resolution / (2.0 * math.pi)}
    for axis, amplitudes in zip("xy", spectra.orders, strict=True):
        values |= {f"frame_force_{axis}_order_{k}": float(amplitudes[k]) for k in range(1, signals.orders + 1)}
    spectrum = 0
    if vibration.frame.mass is not None:
        values |= _place_figures(scene, signals, "frame", spectrum, (SIGNALS + FORCE_X, SIGNALS + FORCE_Y))
        spectrum += 2
    for i, place in enumerate(vibration.places):
        first = SIGNALS + PLACES + PLACE_WIDTH * i + AX
        columns = tuple(range(first, first + axes_of(place, scene.mechanism)))
        values |= _place_figures(scene, signals, place.name.replace("-", "_"), spectrum, columns)
        spectrum += len(columns)
    names = {column.name for column in scene.layout.columns}
    return {name: value for name, value in values.items() if name in names}


def _frame_figures(scene: Scene, signals: Signals) -> Iterator[tuple[str, float]]:
    """Yield the figures of the frame and of the drive: column and value."""
    square = SIGNALS + FORCE_SQUARE
    yield "frame_force_peak", math.sqrt(signals.largest(square))
    yield "frame_force_rms", math.sqrt(signals.moments(square)[0])
    for axis, column in (("x", SIGNALS + FORCE_X), ("y", SIGNALS + FORCE_Y)):
        yield f"frame_force_{axis}_peak", signals.size(column)
    yield "frame_moment_peak", signals.size(SIGNALS + MOMENT)
    yield "frame_moment_rms", math.sqrt(signals.moments(SIGNALS + MOMENT)[1])
    yield "crank_torque_rms", math.sqrt(signals.moments(DRIVE_TORQUE)[1])
    yield "crank_torque_ripple", signals.largest(DRIVE_TORQUE) - signals.smallest(DRIVE_TORQUE)
    mean, mean_square = signals.moments(DRIVE_POWER)[:2]
    yield "drive_power_peak", signals.size(DRIVE_POWER)
    yield "drive_power_mean", float(mean)
    yield "drive_power_reactive", math.sqrt(max(mean_square - mean * mean, 0.0))
    yield "impact_power", float(signals.moments(DISSIPATED)[0])


def motion_of(squares: np.ndarray, rates: np.ndarray) -> Motion:
    """Return the Motion in a band from the squares (m^2/s^2) of the amplitudes of its lines at `rates` (rad/s)."""
    return Motion(math.sqrt(0.5 * float(squares.sum())), 0.5 * float((squares * rates**2).sum()))


def _place_figures(
    scene: Scene, signals: Signals, name: str, spectrum: int, columns: tuple[int, ...]
) -> dict[str, Any]:
    """Return the figures of a place: columns by name.

    spectrum : index of its first spectrum; columns : of its accelerations, or of the forces on the frame, in the
    recording
    """
    vibration, spectra, in_band = scene.case.vibration, signals.spectra(), signals.in_band()
    assert vibration is not None
    rates = spectra.resolution * np.flatnonzero(in_band)
    motions, values = [], dict[str, Any]()
    for axis in range(len(columns)):
        squares = spectra.squares[spectrum + axis, in_band]
        motions.append(motion_of(squares, rates))
        values[f"{name}_velocity_{'xy'[axis]}_rms"] = motions[axis].velocity_rms
    velocity = max(motion.velocity_rms for motion in motions)
    values[f"{name}_velocity_rms"] = velocity
    values[f"{name}_zone"] = zone_of(velocity, vibration.zones) if vibration.zones else None
    moments = [signals.moments(column) for column in columns]
    axis = int(np.argmax([each[1] for each in moments]))
    values[f"{name}_band_energy"] = motions[axis].band_energy
    signal_figures = signature(moments[axis], signals.size(columns[axis]))
    values |= {f"{name}_{key}": value for key, value in signal_figures.items()}
    envelope = spectra.envelopes[spectrum + axis]
    return values | {f"{name}_envelope_order_{k}": float(envelope[k]) for k in range(1, signals.orders + 1)}


def signature(means: np.ndarray, peak: float) -> dict[str, float | None]:
    """Return kurtosis, crest factor and skewness of a signal from the means of its powers, and its largest size."""
    mean, square, cube, fourth = means.tolist()
    variance = square - mean * mean
    if variance <= 1e-24 * square or square == 0.0:
        return {"kurtosis": None, "crest": None, "skewness": None}
    third = cube - 3.0 * mean * square + 2.0 * mean**3
    kurtosis = (fourth - 4.0 * mean * cube + 6.0 * mean**2 * square - 3.0 * mean**4) / variance**2
    return {"kurtosis": kurtosis, "crest": peak / math.sqrt(square), "skewness": third / variance**1.5}


def _ideal_figures(scene: Scene, ideal: IdealShaking) -> dict[str, float | None]:
    """Return the figures of the ideal machine, by column."""
    values: dict[str, float | None] = {f"{name}{IDEAL}": value for name, value in ideal.figures.items()}
    vibration = scene.case.vibration
    assert vibration is not None
    for axis, amplitudes in zip("xy", ideal.orders, strict=True):
        values |= {f"frame_force_{axis}_order_{k}{IDEAL}": float(value) for k, value in enumerate(amplitudes)}
    for name, velocity in ideal.velocities(vibration).items():
        values[f"{name}_velocity_rms{IDEAL}"] = velocity
    return values
