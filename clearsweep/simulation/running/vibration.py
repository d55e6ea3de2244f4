"""Sums, extremes and spectra of the signals of vibration, from the polynomials over the steps of a run.

A run records its signals at the nodes of every step of the window, and pauses where the recording is full.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from ...mechanics.coupling.shaking import signal_count
from ...mechanics.machines.observed import axes_of
from ...mechanics.observe import (
    ANGLE,
    AX,
    END,
    FORCE_SQUARE,
    FORCE_X,
    FORCE_Y,
    MOMENT,
    PLACE_WIDTH,
    PLACES,
    STAGES,
    START,
    TIME,
    VX,
)
from ...mechanics.solver.signal_sums import (
    BIN_MOMENTS,
    BINS_PER_LINE,
    COEFFICIENTS,
    FINE_POINTS,
    FRACTIONS,
    NODE_COUNT,
    POWERS,
    TO_FINE_POINTS,
    Sizes,
    add_steps,
    spectrum,
    values_at,
)
from ...mechanics.solver.slow_sums import DISSIPATED, DRIVE_POWER, DRIVE_TORQUE, DURATION, FREE, SIGNALS
from ..machine.shaking import transfer
from ..setup.scene import Scene, ScheduledClock

CAPACITY = 2048  # steps that are recorded before the loop pauses
MAX_TURNS = 64  # of a stretch of the window with a spectrum of its own
BIN_BLOCK = 128  # the number of bins is a multiple of it, for fast transforms
MAX_LINES = 1 << 14  # of such a spectrum
SAME_TIME = 1e-9  # of a revolution: closer ends of a step and of a stretch are the same
#: From values at the nodes to derivatives of their polynomial there by the fraction of the step.
TO_SLOPES = COEFFICIENTS[:, :-1] @ (
    2.0 * np.arange(NODE_COUNT - 1, 0, -1)[:, None] * np.vander(2.0 * FRACTIONS - 1.0, NODE_COUNT - 1).T
)


class _Layout(NamedTuple):
    """Columns of a recording: counts, then which of them have powers, extremes and spectra."""

    width: int
    summed: np.ndarray  # signals with sums of powers and extremes
    spectral: np.ndarray  # signals with a spectrum over time


def _layout_of(scene: Scene) -> _Layout:
    """Return the layout of the recording of a scene."""
    shaking, vibration = scene.value.shaking, scene.case.vibration
    assert vibration is not None
    first_places = [SIGNALS + PLACES + PLACE_WIDTH * i for i in range(len(vibration.places))]
    forces = [SIGNALS + FORCE_X, SIGNALS + FORCE_Y]
    summed = [DRIVE_TORQUE, DRIVE_POWER, *forces, SIGNALS + FORCE_SQUARE, SIGNALS + MOMENT, DISSIPATED]
    summed += [first + AX + axis for first in first_places for axis in range(2)]
    spectral = forces if vibration.frame.mass is not None else []
    for first, place in zip(first_places, vibration.places, strict=True):
        spectral = [*spectral, *[first + VX + axis for axis in range(axes_of(place, scene.mechanism))]]
    return _Layout(SIGNALS + signal_count(shaking), np.array(summed), np.array(spectral, dtype=np.int64))


class Spectra(NamedTuple):
    """Spectra of the signals over the window: means over its stretches of whole turns."""

    turns: float  # whole revolutions in a stretch
    resolution: float  # rad/s, between lines
    squares: np.ndarray  # (signals, lines + 1) m^2/s^2, square of the amplitude of the velocity in each line
    orders: np.ndarray  # (2, orders + 1) amplitude of the force along x and y over the crank angle, N
    envelopes: np.ndarray  # (signals, orders + 1) amplitude of the envelope of the acceleration, m/s^2


class Signals:
    """The recorded signals of a run, summed up."""

    def __init__(self, scene: Scene):
        """Prepare for the cases of a layout."""
        self.layout = _layout_of(scene)
        self.recording = np.zeros((CAPACITY, self.layout.width, NODE_COUNT))
        self.choices = np.concatenate([self.layout.summed, self.layout.spectral])
        self.sums, self.scratch = np.zeros((self.layout.width, POWERS, STAGES)), np.zeros((BIN_MOMENTS, STAGES))
        self.bounds = np.zeros((self.layout.width, 2))  # largest value of each signal, and of its negative
        self.peaks = np.zeros((self.layout.width, 2, NODE_COUNT))  # the steps that contain them
        self.orders = scene.case.outline.vibration.orders if scene.case.outline.vibration else 0
        self.angle_bins = np.zeros((2, math.ceil(BINS_PER_LINE * self.orders), BIN_MOMENTS))
        self.time_bins = np.zeros((len(self.layout.spectral), 1, BIN_MOMENTS))

    def begin(self, scene: Scene) -> None:
        """Prepare for the run of a scene."""
        self.scene, vibration = scene, scene.case.vibration
        assert vibration is not None
        self.rate = scene.value.reference_rate
        highest_order = vibration.band[1] / self.rate
        settings = scene.case.simulate
        window_turns = math.floor(settings.revolutions - settings.discard + SAME_TIME)
        self.turns = max(min(window_turns, MAX_TURNS, math.floor(MAX_LINES / highest_order)), 1)
        self.period = self.turns * 2.0 * math.pi / self.rate  # s, of the lines
        self.lines = math.ceil(self.turns * highest_order * (1.0 + SAME_TIME))
        rates = 2.0 * math.pi / self.period * np.arange(self.lines + 1)
        self.responses = np.ones((len(self.layout.spectral), self.lines + 1), dtype=complex)
        if vibration.frame.mass is not None:
            self.responses[:2] = [transfer(vibration.frame, axis, rates) for axis in range(2)]
        bin_count = BIN_BLOCK * math.ceil(BINS_PER_LINE * self.lines / BIN_BLOCK)
        if self.time_bins.shape[1] != bin_count:
            self.time_bins = np.zeros((len(self.layout.spectral), bin_count, BIN_MOMENTS))
        self.reset()

    def reset(self) -> None:
        """Forget all recorded signals."""
        self.sums.fill(0.0)
        self.bounds.fill(-math.inf)
        self.peaks.fill(0.0)
        self.time, self.stretches = 0.0, 0  # s of all recorded steps; finished stretches
        self.begin_turns = math.nan  # revolutions before the window
        self.squares = np.zeros((len(self.layout.spectral), self.lines + 1))
        self.order_sums = np.zeros((2, self.orders + 1), dtype=complex)
        self.envelopes = np.zeros((len(self.layout.spectral), self.orders + 1))
        self._clear_stretch()

    def _clear_stretch(self) -> None:
        self.time_bins.fill(0.0)
        self.angle_bins.fill(0.0)
        self.stretch_time = 0.0

    def drain(self, work: Any) -> None:
        """Add the recorded steps of a run (integration.Work)."""
        count, work.stepper.recorded = int(work.stepper.recorded), 0.0
        if not count:
            return
        rows, clock = self.recording[:count], self.scene.crank_clock
        if self.orders:
            self._put_angles(rows)
        column = SIGNALS + (ANGLE if clock.free else TIME)
        if math.isnan(self.begin_turns):
            self.begin_turns, self.start_time = self._turns_at(rows[0, column, START]), rows[0, SIGNALS + TIME, START]
        while len(rows):
            end = clock.value_after(self.begin_turns + (self.stretches + 1) * self.turns)
            tolerance = SAME_TIME * (end - clock.value_after(self.begin_turns)) / self.turns
            index = int(np.searchsorted(rows[:, column, END], end - tolerance))
            if index == len(rows):
                self._add(rows)
                return
            before, after = _split(rows[index], column, end, tolerance)
            self._add(rows[:index])
            self._add(before)
            self._finish_stretch()
            rows = rows[index + 1 - len(after) :]
            rows[: len(after)] = after

    def _turns_at(self, value: float) -> float:
        """Return the revolutions after which the clock shows a value, at which the window begins."""
        clock, turns = self.scene.crank_clock, self.scene.case.simulate.discard
        turn = clock.value_after(turns + 1.0) - clock.value_after(turns)
        while clock.value_after(turns) < value - SAME_TIME * turn:
            turns += 1.0
        return turns

    def _put_angles(self, rows: np.ndarray) -> None:
        """Put the crank angle (rad) and its derivative by the fraction of the step into recorded rows."""
        if self.scene.crank_clock.free:
            rows[:, FREE] = rows[:, SIGNALS + ANGLE] @ TO_SLOPES
            return
        clock, time = self.scene.crank_clock, rows[:, SIGNALS + TIME]
        if not isinstance(clock, ScheduledClock):
            rows[:, SIGNALS + ANGLE], rows[:, FREE] = self.rate * time, self.rate * rows[:, DURATION]
            return
        row = np.clip(np.searchsorted(clock.times, time, side="right") - 1, 0, len(clock.times) - 1)
        elapsed, speed = time - clock.times[row], np.interp(time, clock.times, clock.speeds)
        rows[:, SIGNALS + ANGLE] = clock.angles[row] + 0.5 * elapsed * (clock.speeds[row] + speed)
        rows[:, FREE] = speed * rows[:, DURATION]

    def _add(self, rows: np.ndarray) -> None:
        """Add steps of the present stretch."""
        if not len(rows):
            return
        count, (width, summed, spectral) = len(rows), self.layout
        settings = Sizes(
            np.array(
                [
                    width,
                    len(summed),
                    len(spectral),
                    self.time_bins.shape[1],
                    self.angle_bins.shape[1],
                    self.start_time,
                    self.time_bins.shape[1] / self.period,
                    self.angle_bins.shape[1] / (2.0 * math.pi),
                ]
            )
        )
        rows = np.ascontiguousarray(rows)
        arrays = (rows, settings.numbers, self.choices, self.sums, self.bounds, self.peaks, self.scratch)
        add_steps((*arrays, self.time_bins, self.angle_bins), count)
        duration = float(rows[-1, SIGNALS + TIME, END] - rows[0, SIGNALS + TIME, START])
        self.time, self.stretch_time = self.time + duration, self.stretch_time + duration

    def refine_extremes(self) -> None:
        """Replace the extremes of the signals by those of the polynomials over the steps that contain them."""
        chosen, peaks = self.layout.summed, self.peaks[self.layout.summed]
        centre = FINE_POINTS[np.argmax(peaks @ TO_FINE_POINTS, axis=-1)]
        near = 2.0 * np.clip(centre[..., None] + FINE_POINTS[0] * np.linspace(-1.0, 1.0, 129), 0.0, 1.0) - 1.0
        total, coefficients = np.zeros(near.shape), peaks @ COEFFICIENTS
        for power in range(NODE_COUNT):
            total = total * near + coefficients[..., power, None]
        self.bounds[chosen] = np.maximum(self.bounds[chosen], total.max(axis=-1))

    def _finish_stretch(self) -> None:
        """Add the spectra of a finished stretch."""
        transforms = 2.0 / self.stretch_time * self.responses * spectrum(self.time_bins, self.lines)
        self.squares += np.abs(transforms) ** 2 * (self.stretch_time / self.period)
        if self.orders:
            self.order_sums += spectrum(self.angle_bins, self.orders) / (math.pi * self.turns)
            self.envelopes += self._envelopes(transforms)
        self.stretches += 1
        self._clear_stretch()

    def _envelopes(self, transforms: np.ndarray) -> np.ndarray:
        """Return the amplitudes (signals, orders + 1) of the envelope of the acceleration in the band, by order.

        The envelope is the magnitude of the analytic signal; its lines are those of the crank's orders.
        """
        size = 1 << math.ceil(math.log2(4 * (max(self.lines, self.orders * self.turns) + 1)))
        rates = 2.0 * math.pi / self.period * np.arange(self.lines + 1)
        analytic = np.zeros((len(transforms), size), dtype=complex)
        analytic[:, : self.lines + 1] = np.where(self.in_band(), 1j * rates * transforms, 0.0)
        envelope = np.abs(np.fft.ifft(analytic, axis=1)) * size
        amplitudes = 2.0 / size * np.abs(np.fft.rfft(envelope, axis=1))
        return amplitudes[:, : self.orders * self.turns + 1 : self.turns]

    def in_band(self) -> np.ndarray:
        """Return which lines are in the band, its ends included."""
        assert self.scene.case.vibration is not None
        low, high = self.scene.case.vibration.band
        rates = 2.0 * math.pi / self.period * np.arange(self.lines + 1)
        return (rates >= low * (1.0 - SAME_TIME)) & (rates <= high * (1.0 + SAME_TIME))

    def spectra(self) -> Spectra:
        """Return the spectra over all finished stretches."""
        count = max(self.stretches, 1)
        return Spectra(
            float(self.turns),
            2.0 * math.pi / self.period,
            self.squares / count,
            np.abs(self.order_sums) / count,
            self.envelopes / count,
        )

    def largest(self, column: int) -> float:
        """Return the largest value of a signal."""
        return float(self.bounds[column, 0])

    def smallest(self, column: int) -> float:
        """Return the smallest value of a signal."""
        return -float(self.bounds[column, 1])

    def size(self, column: int) -> float:
        """Return the largest size of a signal."""
        return float(self.bounds[column].max())

    def moments(self, column: int) -> np.ndarray:
        """Return the means (POWERS,) of a signal and of its powers over the window."""
        means: np.ndarray = self.sums[column].sum(axis=1) / self.time
        return means


def _split(row: np.ndarray, column: int, end: float, tolerance: float) -> tuple[np.ndarray, np.ndarray]:
    """Return a recorded step, (width, nodes), up to the `end` of a stretch and after it, each (steps, width, nodes)."""
    if row[column, END] <= end + tolerance:
        return row[None], row[None][:0]
    if row[column, START] >= end - tolerance:
        return row[None][:0], row[None]
    low, high = 0.0, 1.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        is_before = float(row[column] @ values_at(np.array([middle]))[:, 0]) < end
        low, high = (middle, high) if is_before else (low, middle)
    parts = []
    for begin, length in ((0.0, low), (low, 1.0 - low)):
        part = row @ values_at(begin + length * FRACTIONS)
        part[[DURATION, FREE]] *= length
        parts.append(part[None])
    return parts[0], parts[1]
