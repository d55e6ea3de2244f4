"""Sums, extremes, spectra and figures of the signals of vibration, from the polynomials over the steps of a run.

A run records its signals at the nodes of every step of the window, and pauses where the recording is full."""

import math
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np

from ...contracts.vibration import BEARING_PARTS, IDEAL, MAX_LINES, zone_of
from ...mechanics import observe
from ...mechanics.machines.described import axes_of
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
    slopes_at,
    spectrum,
    values_at,
)
from ...mechanics.solver.slow_sums import DISSIPATED, DRIVE_POWER, DRIVE_TORQUE, DURATION, FREE, SIGNALS
from ...tracing import portable
from ..machine.shaking import ideal_shaking, lines_in, longest_stretch, responses
from ..setup.scene import Scene, ScheduledClock
from .deformation import ZOOM_POINTS

CAPACITY = 2048  # steps that are recorded before the loop pauses
MAX_TURNS = 64  # of a stretch of the window with a spectrum of its own
BIN_BLOCK = 128  # the number of bins is a multiple of it, for fast transforms
ROOM = 1.5  # of the longest stretch of the ideal machine, that one with clearance may take
SAME_TIME = 1e-9  # of a revolution: closer ends of a step and of a stretch are the same
#: The window of Blackman and Harris with four terms, whose side lobes are below -92 dB (Harris 1978, Proc. IEEE 66:51).
WINDOW = 0.35875, 0.48829, 0.14128, 0.01168
#: From values at the nodes to derivatives of their polynomial there by the fraction of the step.
TO_SLOPES = slopes_at(FRACTIONS)


class _Layout(NamedTuple):
    """Columns of a recording: counts, then which of them have powers, extremes and spectra."""

    width: int
    summed: np.ndarray  # signals with sums of powers and extremes
    spectral: np.ndarray  # signals with a spectrum over time


def _layout_of(scene: Scene, width: int) -> _Layout:
    """Return the layout of the recording of a scene."""
    vibration = scene.case.vibration
    assert vibration is not None
    first_places = [SIGNALS + observe.PLACES + observe.PLACE_WIDTH * i for i in range(len(vibration.places))]
    forces = [SIGNALS + observe.FORCE_X, SIGNALS + observe.FORCE_Y]
    summed = [DRIVE_TORQUE, DRIVE_POWER, *forces, SIGNALS + observe.FORCE_SQUARE, SIGNALS + observe.MOMENT, DISSIPATED]
    summed += [first + observe.AX + axis for first in first_places for axis in range(2)]
    spectral = forces if vibration.frame.mass is not None else []
    for first, place in zip(first_places, vibration.places, strict=True):
        spectral = [*spectral, *[first + observe.VX + axis for axis in range(axes_of(place, scene.mechanism))]]
    return _Layout(width, np.array(summed), np.array(spectral, dtype=np.int64))


class Signals:
    """The recorded signals of a run, summed up."""

    def __init__(self, scene: Scene, width: int):
        """Prepare for the cases of a layout; width : number of recorded columns."""
        self.layout = _layout_of(scene, width)
        self.choices = np.concatenate([self.layout.summed, self.layout.spectral])
        self.sums = np.zeros((self.layout.width, POWERS, observe.STAGES))
        self.scratch = np.zeros((BIN_MOMENTS, observe.STAGES))
        self.bounds = np.zeros((self.layout.width, 2))  # largest value of each signal, and of its negative
        self.means = np.zeros((self.layout.width, POWERS))  # of each signal and of its powers
        self.peaks = np.zeros((self.layout.width, 2, NODE_COUNT))  # the steps that contain them
        self.orders = scene.case.outline.vibration.orders if scene.case.outline.vibration else 0
        self.angle_bins = np.zeros((2, math.ceil(BINS_PER_LINE * self.orders), BIN_MOMENTS))
        self.time_bins = np.zeros((len(self.layout.spectral), 1, BIN_MOMENTS))

    def begin(self, scene: Scene) -> None:
        """Prepare for the run of a scene."""
        settings, vibration = scene.case.simulate, scene.case.vibration
        assert vibration is not None
        self.scene, self.vibration = scene, vibration
        self.rate = 2.0 * math.pi / settings.period if settings.period else scene.value.reference_rate
        highest_order = vibration.band[1] / self.rate
        window_turns = math.floor(settings.revolutions - settings.discard + SAME_TIME)
        self.turns = max(min(window_turns, MAX_TURNS, math.floor(MAX_LINES / highest_order)), 1)
        crank_clock = scene.crank_clock
        self.is_steady = not crank_clock.free and not isinstance(crank_clock, ScheduledClock)
        self.period = self.turns * 2.0 * math.pi / self.rate  # s, of the lines; no stretch may be longer
        self.is_even = self.is_steady or bool(settings.period)  # all stretches take the period of the lines
        if not self.is_even:
            self.period = ROOM * longest_stretch(scene.case, scene.machine, self.turns) or self.period
            highest_order = vibration.band[1] * self.period / (2.0 * math.pi * self.turns)
        self.lines = math.ceil(self.turns * highest_order * (1.0 + SAME_TIME))
        self.order_lines = self.turns if scene.case.outline.length != "time" else 2 * self.lines + 2
        self.resolution = 2.0 * math.pi / self.period
        self.band = lines_in(vibration.band, self.resolution)
        self.angle_unit = self.rate if self.is_steady else 1.0  # rad, of the column that is proportional to the angle
        bin_count = BIN_BLOCK * math.ceil(BINS_PER_LINE * self.lines / BIN_BLOCK)
        if self.time_bins.shape[1] != bin_count:
            self.time_bins = np.zeros((len(self.layout.spectral), bin_count, BIN_MOMENTS))
        angle_count = self.angle_bins.shape[1]
        counts = self.layout.width, len(self.layout.summed), len(self.layout.spectral), bin_count, angle_count
        angle = (SIGNALS + observe.TIME, DURATION) if self.is_steady else (SIGNALS + observe.ANGLE, FREE)
        scales = 0.0, bin_count / self.period, *angle, self.angle_unit * angle_count / (2.0 * math.pi)
        self.sizes = Sizes(np.array([*counts, *scales]))
        self.reset()

    def reset(self) -> None:
        """Forget all recorded signals."""
        self.sums.fill(0.0)
        self.bounds.fill(-math.inf)
        self.peaks.fill(0.0)
        self.time, self.stretched = 0.0, 0.0  # s, of all recorded steps, and of finished stretches
        self.stretches = 0
        self.begin_turns = math.nan  # revolutions before the window
        self.is_too_slow = False  # a stretch was longer than the period of the lines, whose spectrum is then unknown
        spectra = len(self.layout.spectral)
        self.squares = np.zeros((spectra, self.lines + 1))  # m^2/s^2, of the amplitude of the velocity in each line
        self.order_sums = np.zeros((2, self.orders + 1), dtype=complex)  # N, of the force along x and y
        self.envelopes = np.zeros((spectra, self.orders + 1))  # m/s^2, amplitude of that of the acceleration
        self.transforms: list[tuple[np.ndarray, float]] = []  # of stretches, and rad/s between lines; with bearings
        self._clear_stretch()

    def _clear_stretch(self) -> None:
        self.time_bins.fill(0.0)
        self.angle_bins.fill(0.0)
        self.stretch_time = 0.0

    def add(self, rows: np.ndarray) -> None:
        """Add recorded steps (steps, columns, nodes), whose free columns and angles may change."""
        if not len(rows):
            return
        crank_clock = self.scene.crank_clock
        if self.orders and not self.is_steady:
            self._put_angles(rows)
        column = SIGNALS + (observe.ANGLE if crank_clock.free else observe.TIME)
        if math.isnan(self.begin_turns):
            self.begin_turns = self._turns_at(rows[0, column, observe.START])
            self.sizes.start_time = rows[0, SIGNALS + observe.TIME, observe.START]
        while len(rows):
            end = crank_clock.value_after(self.begin_turns + (self.stretches + 1) * self.turns)
            tolerance = SAME_TIME * (end - crank_clock.value_after(self.begin_turns)) / self.turns
            index = int(np.searchsorted(rows[:, column, observe.END], end - tolerance))
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
        crank_clock, turns = self.scene.crank_clock, self.scene.case.simulate.discard
        turn = crank_clock.value_after(turns + 1.0) - crank_clock.value_after(turns)
        while crank_clock.value_after(turns) < value - SAME_TIME * turn:
            turns += 1.0
        return turns

    def _put_angles(self, rows: np.ndarray) -> None:
        """Put the crank angle (rad) and its derivative by the fraction of the step into recorded rows."""
        crank_clock, time = self.scene.crank_clock, rows[:, SIGNALS + observe.TIME]
        if not isinstance(crank_clock, ScheduledClock):
            rows[:, FREE] = portable.product(rows[:, SIGNALS + observe.ANGLE], TO_SLOPES)
            return
        row = np.clip(np.searchsorted(crank_clock.times, time, side="right") - 1, 0, len(crank_clock.times) - 1)
        elapsed, speed = time - crank_clock.times[row], np.interp(time, crank_clock.times, crank_clock.speeds)
        rows[:, SIGNALS + observe.ANGLE] = crank_clock.angles[row] + 0.5 * elapsed * (crank_clock.speeds[row] + speed)
        rows[:, FREE] = speed * rows[:, DURATION]

    def _add(self, rows: np.ndarray) -> None:
        """Add steps of the present stretch."""
        if not len(rows):
            return
        rows = np.ascontiguousarray(rows)
        arrays = (rows, self.sizes.numbers, self.choices, self.sums, self.bounds, self.peaks, self.scratch)
        add_steps((*arrays, self.time_bins, self.angle_bins), len(rows))
        if not self.stretch_time:
            self.stretch_begin = float(rows[0, SIGNALS + observe.TIME, observe.START])
        duration = float(rows[-1, SIGNALS + observe.TIME, observe.END] - rows[0, SIGNALS + observe.TIME, observe.START])
        self.time, self.stretch_time = self.time + duration, self.stretch_time + duration

    def _finish_stretch(self) -> None:
        """Add the spectra of a finished stretch."""
        self.is_too_slow |= self.stretch_time > self.period * (1.0 - 1.0 / BIN_BLOCK) and not self.is_even
        if len(self.time_bins):
            transforms, share = self._transforms()
            resolution = self.resolution * share
            if any(joint.is_rolling for joint in self.scene.layout.joints):
                half_bin = -1j * math.pi * share / self.time_bins.shape[1]  # by which `spectrum` is early
                self.transforms.append((transforms * np.exp(half_bin * np.arange(self.lines + 1)), resolution))
                self.transforms[-1][0][:, :: self.order_lines] = 0.0  # what every turn has
            if self.vibration.frame.mass is not None:
                transforms[:2] *= responses(self.vibration.frame, resolution, self.lines + 1)
            self.squares += np.abs(transforms) ** 2 * (self.stretch_time / self.period * share)
            if self.orders:
                self.envelopes += self._envelopes(transforms, resolution)
        if self.orders:
            self.order_sums += spectrum(self.angle_bins, self.orders) * (self.angle_unit / (math.pi * self.turns))
        self.stretches, self.stretched = self.stretches + 1, self.stretched + self.stretch_time
        self._clear_stretch()

    def _transforms(self) -> tuple[np.ndarray, float]:
        """Return the amplitudes (spectra, lines + 1) of a stretch, and the distance of its lines over `resolution`.

        They are those of the time of the stretch, which differs from the period where the speed varies.
        """
        if self.is_even:
            return 2.0 / self.stretch_time * spectrum(self.time_bins, self.lines), 1.0
        first = math.floor((self.stretch_begin - self.sizes.start_time) * self.sizes.time_scale)
        bins, share = np.roll(self.time_bins, -first, axis=1), self.period / self.stretch_time
        return 2.0 / self.stretch_time * spectrum(bins, self.lines, share), share

    def _envelopes(self, transforms: np.ndarray, resolution: float) -> np.ndarray:
        """Return the amplitudes (signals, orders + 1) of the envelope of the acceleration in the band, by order.

        The envelope is the magnitude of the analytic signal; its lines are those of the crank's orders.  resolution :
        rad/s, distance of the lines of the stretch
        """
        size = 1 << math.ceil(math.log2(4 * (max(self.lines, self.orders * self.turns) + 1)))
        analytic, band = np.zeros((len(transforms), size), dtype=complex), lines_in(self.vibration.band, resolution)
        rates = resolution * np.arange(band.start, min(band.stop, self.lines + 1))
        analytic[:, band.start : band.start + len(rates)] = (
            1j * rates * transforms[:, band.start : band.start + len(rates)]
        )
        envelope = np.abs(np.fft.ifft(analytic, axis=1)) * size
        amplitudes = 2.0 / size * np.abs(np.fft.rfft(envelope, axis=1))
        return amplitudes[:, : self.orders * self.turns + 1 : self.turns]

    def amplitudes_at(self, rate: float) -> np.ndarray | None:
        """Return the amplitudes (spectra,) of velocities (m/s) at a rate (rad/s) between lines, or None if unknown.

        They are of what differs from turn to turn, and unknown where WINDOW does not separate them from orders.
        """
        squares = []
        for transforms, resolution in self.transforms:
            line = rate / resolution
            if min(line % self.order_lines, -line % self.order_lines, self.lines - line) < len(WINDOW):
                return None
            amplitudes = np.abs(portable.product(transforms, window_transform(line - np.arange(self.lines + 1))))
            if self.vibration.frame.mass is not None:
                amplitudes[:2] *= np.abs(responses(self.vibration.frame, rate, 2)[:, 1])
            squares.append(amplitudes**2)
        return np.sqrt(np.mean(squares, axis=0)) if squares else None

    def conclude(self) -> None:
        """Take means over the window, and extremes of the polynomials over the steps that contain them."""
        if self.stretches and not self.is_even:
            self.resolution = 2.0 * math.pi * self.stretches / self.stretched
            self.band = lines_in(self.vibration.band, self.resolution)
        count, chosen, peaks = max(self.stretches, 1), self.layout.summed, self.peaks[self.layout.summed]
        self.squares, self.envelopes = self.squares / count, self.envelopes / count
        self.order_amplitudes = np.abs(self.order_sums) / count
        self.means = self.sums.sum(axis=2) / self.time
        centre = FINE_POINTS[np.argmax(portable.product(peaks, TO_FINE_POINTS), axis=-1)]
        near = 2.0 * np.clip(centre[..., None] + ZOOM_POINTS, 0.0, 1.0) - 1.0
        total, coefficients = np.zeros(near.shape), portable.product(peaks, COEFFICIENTS)
        for power in range(NODE_COUNT):
            total = total * near + coefficients[..., power, None]
        self.bounds[chosen] = np.maximum(self.bounds[chosen], total.max(axis=-1))


def window_transform(lines: np.ndarray) -> np.ndarray:
    """Return what an amplitude of 1 becomes in a spectrum through WINDOW, at a distance of `lines`, whole or not."""
    terms = [0.5 * term * (np.sinc(lines - k) + np.sinc(lines + k)) for k, term in enumerate(WINDOW)]
    transform: np.ndarray = np.sum(terms, axis=0) * np.exp(-1j * math.pi * lines) / WINDOW[0]
    return transform


def _split(row: np.ndarray, column: int, end: float, tolerance: float) -> tuple[np.ndarray, np.ndarray]:
    """Return a recorded step, (width, nodes), up to the `end` of a stretch and after it, each (steps, width, nodes)."""
    if row[column, observe.END] <= end + tolerance:
        return row[None], row[None][:0]
    if row[column, observe.START] >= end - tolerance:
        return row[None][:0], row[None]
    low, high = 0.0, 1.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        is_before = float(portable.product(row[column], values_at(np.array([middle]))[:, 0])) < end
        low, high = (middle, high) if is_before else (low, middle)
    parts = []
    for begin, length in ((0.0, low), (low, 1.0 - low)):
        part = portable.product(row, values_at(begin + length * FRACTIONS))
        part[[DURATION, FREE]] *= length
        parts.append(part[None])
    return parts[0], parts[1]


#: Ends of the columns that follow from spectra.
OF_SPECTRA = ("_velocity_rms", "_velocity_x_rms", "_velocity_y_rms", "_zone", "_band_energy", "_velocity")


def vibration_figures(scene: Scene, signals: Signals, figures: Mapping[str, Any]) -> dict[str, Any]:
    """Return the columns of vibration of a finished run; figures : its other columns by name."""
    signals.conclude()
    vibration, ideal = signals.vibration, ideal_shaking(scene.case, scene.machine)
    values: dict[str, Any] = dict(_frame_figures(signals))
    values |= {f"{name}{IDEAL}": value for name, value in ideal.figures.items()}
    values |= {f"{name}_velocity_rms{IDEAL}": value for name, value in ideal.velocities(vibration).items()}
    values |= {"vibration_turns": float(signals.turns), "vibration_resolution": signals.resolution / (2.0 * math.pi)}
    for suffix, orders in (("", signals.order_amplitudes), (IDEAL, ideal.orders)):
        for axis, amplitudes in zip("xy", orders.tolist(), strict=True):
            values |= {f"frame_force_{axis}_order_{k}{suffix}": value for k, value in enumerate(amplitudes)}
    forces = range(SIGNALS + observe.FORCE_X, SIGNALS + observe.FORCE_Y + 1)
    values |= _signature_of("frame", signals, forces)[1]
    spectrum = 0
    bearing_lines = {
        f"{name}_velocity": signals.amplitudes_at(2.0 * math.pi * figures[f"{name}_frequency"])
        for joint in scene.layout.joints
        for name in (f"{joint.name}_{part}" for part in BEARING_PARTS if joint.is_rolling)
    }
    if vibration.frame.mass is not None:
        values |= _place_figures(signals, "frame", spectrum, forces, bearing_lines)
        spectrum += len(forces)
    for i, place in enumerate(vibration.places):
        first = SIGNALS + observe.PLACES + observe.PLACE_WIDTH * i + observe.AX
        columns = range(first, first + axes_of(place, scene.mechanism))
        values |= _place_figures(signals, place.name.replace("-", "_"), spectrum, columns, bearing_lines)
        spectrum += len(columns)
    if signals.is_too_slow:
        values |= {name: None for name in values if name.endswith(OF_SPECTRA) or "_envelope_order_" in name}
    names = {column.name for column in scene.layout.columns}
    return {name: value for name, value in values.items() if name in names}


def _frame_figures(signals: Signals) -> Iterator[tuple[str, float]]:
    """Yield the figures of the frame and of the drive: column and value."""
    means, bounds = signals.means.tolist(), signals.bounds.tolist()
    square, moment, torque = SIGNALS + observe.FORCE_SQUARE, SIGNALS + observe.MOMENT, DRIVE_TORQUE
    yield "frame_force_peak", math.sqrt(bounds[square][0])
    yield "frame_force_rms", math.sqrt(means[square][0])
    yield "frame_force_x_peak", max(bounds[SIGNALS + observe.FORCE_X])
    yield "frame_force_y_peak", max(bounds[SIGNALS + observe.FORCE_Y])
    yield "frame_moment_peak", max(bounds[moment])
    yield "frame_moment_rms", math.sqrt(means[moment][1])
    yield "crank_torque_rms", math.sqrt(means[torque][1])
    yield "crank_torque_ripple", sum(bounds[torque])  # the second is that of the negative
    mean, mean_square = means[DRIVE_POWER][:2]
    yield "drive_power_peak", max(bounds[DRIVE_POWER])
    yield "drive_power_mean", mean
    yield "drive_power_reactive", math.sqrt(max(mean_square - mean * mean, 0.0))
    yield "impact_power", means[DISSIPATED][0]


def motion_of(squares: np.ndarray, rates: np.ndarray) -> tuple[float, float]:
    """Return the velocity (m/s rms) and the band energy (m^2/s^4) of a motion in a band.

    squares : (m^2/s^2) of the amplitudes of the velocity of its lines at `rates` (rad/s)
    """
    return math.sqrt(0.5 * float(squares.sum())), 0.5 * float((squares * rates**2).sum())


def _place_figures(
    signals: Signals, name: str, spectrum: int, columns: range, bearing_lines: Mapping[str, np.ndarray | None]
) -> dict[str, Any]:
    """Return the figures of a place: columns by name.

    spectrum : index of its first spectrum; columns : of its accelerations, or of the forces on the frame, in the
    recording; bearing_lines : amplitudes (spectra,) m/s at the frequencies of rolling bearings
    """
    zones, rates = signals.vibration.zones, signals.resolution * np.arange(signals.band.start, signals.band.stop)
    own = slice(spectrum, spectrum + len(columns))
    squares = signals.squares[own, signals.band]
    velocities, energies = zip(*(motion_of(each, rates) for each in squares), strict=True)
    velocity = max(velocities)
    values: dict[str, Any] = {f"{name}_velocity_rms": velocity}
    values |= {f"{name}_velocity_{letter}_rms": each for letter, each in zip("xy", velocities, strict=False)}
    values[f"{name}_zone"] = zone_of(velocity, zones) if zones else None
    axis, signal_figures = _signature_of(name, signals, columns)
    values[f"{name}_band_energy"] = energies[axis]
    envelope = enumerate(signals.envelopes[spectrum + axis].tolist())
    values |= {f"{name}_{key}": None if each is None else float(each[own].max()) for key, each in bearing_lines.items()}
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
