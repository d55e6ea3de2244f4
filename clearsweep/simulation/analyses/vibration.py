"""Computes the figures of vibration of a run from its recorded signals, and those of the ideal machine."""

import math
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from ...contracts.vibration import IDEAL, zone_of
from ...mechanics.machines.observed import axes_of
from ...mechanics.observe import AX, FORCE_SQUARE, FORCE_X, FORCE_Y, MOMENT, PLACE_WIDTH, PLACES
from ...mechanics.solver.slow_sums import DISSIPATED, DRIVE_POWER, DRIVE_TORQUE, SIGNALS
from ..machine.shaking import ideal_shaking
from ..running.vibration import Signals
from ..setup.scene import Scene


class Motion(NamedTuple):
    """The velocity of a place along x or y in the band."""

    velocity_rms: float  # m/s
    band_energy: float  # m^2/s^4


def vibration_figures(scene: Scene, signals: Signals) -> dict[str, Any]:
    """Return the columns of vibration of a finished run."""
    signals.conclude()
    vibration, ideal = scene.case.vibration, ideal_shaking(scene.case, scene.machine)
    assert vibration is not None
    values: dict[str, Any] = dict(_frame_figures(signals))
    values |= {f"{name}{IDEAL}": value for name, value in ideal.figures.items()}
    values |= {f"{name}_velocity_rms{IDEAL}": value for name, value in ideal.velocities(vibration).items()}
    values |= {"vibration_turns": float(signals.turns), "vibration_resolution": signals.resolution / (2.0 * math.pi)}
    for suffix, orders in (("", signals.order_amplitudes), (IDEAL, ideal.orders)):
        for axis, amplitudes in zip("xy", orders.tolist(), strict=True):
            values |= {f"frame_force_{axis}_order_{k}{suffix}": value for k, value in enumerate(amplitudes)}
    forces = range(SIGNALS + FORCE_X, SIGNALS + FORCE_Y + 1)
    values |= _signature_of("frame", signals, forces)[1]
    spectrum = 0
    if vibration.frame.mass is not None:
        values |= _place_figures(scene, signals, "frame", spectrum, forces)
        spectrum += len(forces)
    for i, place in enumerate(vibration.places):
        first = SIGNALS + PLACES + PLACE_WIDTH * i + AX
        columns = range(first, first + axes_of(place, scene.mechanism))
        values |= _place_figures(scene, signals, place.name.replace("-", "_"), spectrum, columns)
        spectrum += len(columns)
    names = {column.name for column in scene.layout.columns}
    return {name: value for name, value in values.items() if name in names}


def _frame_figures(signals: Signals) -> Iterator[tuple[str, float]]:
    """Yield the figures of the frame and of the drive: column and value."""
    means, bounds = signals.means.tolist(), signals.bounds.tolist()
    square, moment, torque = SIGNALS + FORCE_SQUARE, SIGNALS + MOMENT, DRIVE_TORQUE
    yield "frame_force_peak", math.sqrt(bounds[square][0])
    yield "frame_force_rms", math.sqrt(means[square][0])
    yield "frame_force_x_peak", max(bounds[SIGNALS + FORCE_X])
    yield "frame_force_y_peak", max(bounds[SIGNALS + FORCE_Y])
    yield "frame_moment_peak", max(bounds[moment])
    yield "frame_moment_rms", math.sqrt(means[moment][1])
    yield "crank_torque_rms", math.sqrt(means[torque][1])
    yield "crank_torque_ripple", sum(bounds[torque])  # the second is that of the negative
    mean, mean_square = means[DRIVE_POWER][:2]
    yield "drive_power_peak", max(bounds[DRIVE_POWER])
    yield "drive_power_mean", mean
    yield "drive_power_reactive", math.sqrt(max(mean_square - mean * mean, 0.0))
    yield "impact_power", means[DISSIPATED][0]


def motion_of(squares: np.ndarray, rates: np.ndarray) -> Motion:
    """Return the Motion in a band from the squares (m^2/s^2) of the amplitudes of its lines at `rates` (rad/s)."""
    return Motion(math.sqrt(0.5 * float(squares.sum())), 0.5 * float((squares * rates**2).sum()))


def _place_figures(scene: Scene, signals: Signals, name: str, spectrum: int, columns: range) -> dict[str, Any]:
    """Return the figures of a place: columns by name.

    spectrum : index of its first spectrum; columns : of its accelerations, or of the forces on the frame, in the
    recording
    """
    vibration, rates = scene.case.vibration, signals.rates_in_band()
    assert vibration is not None
    squares = signals.squares[spectrum : spectrum + len(columns), signals.band]
    motions = [motion_of(each, rates) for each in squares]
    velocity = max(motion.velocity_rms for motion in motions)
    values: dict[str, Any] = {f"{name}_velocity_rms": velocity}
    for letter, motion in zip("xy", motions, strict=False):
        values[f"{name}_velocity_{letter}_rms"] = motion.velocity_rms
    values[f"{name}_zone"] = zone_of(velocity, vibration.zones) if vibration.zones else None
    axis, signal_figures = _signature_of(name, signals, columns)
    values[f"{name}_band_energy"] = motions[axis].band_energy
    envelope = enumerate(signals.envelopes[spectrum + axis].tolist())
    return values | signal_figures | {f"{name}_envelope_order_{k}": value for k, value in envelope}


def _signature_of(name: str, signals: Signals, columns: range) -> tuple[int, dict[str, float | None]]:
    """Return the direction with the larger root mean square among signals, and the figures of its signature."""
    axis = int(np.argmax(signals.means[columns.start : columns.stop, 1]))
    figures = signature(signals.means[columns[axis]], float(signals.bounds[columns[axis]].max()))
    return axis, {f"{name}_{key}": value for key, value in figures.items()}


def signature(means: np.ndarray, peak: float) -> dict[str, float | None]:
    """Return kurtosis, crest factor and skewness of a signal from the means of its powers, and its largest size."""
    mean, square, cube, fourth = means.tolist()
    variance = square - mean * mean
    if variance <= 1e-24 * square or square == 0.0:
        return {"kurtosis": None, "crest": None, "skewness": None}
    third = cube - 3.0 * mean * square + 2.0 * mean**3
    kurtosis = (fourth - 4.0 * mean * cube + 6.0 * mean**2 * square - 3.0 * mean**4) / variance**2
    return {"kurtosis": kurtosis, "crest": peak / math.sqrt(square), "skewness": third / variance**1.5}
