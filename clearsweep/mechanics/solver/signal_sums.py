"""Sums, extremes and spectra of recorded signals, from the polynomials over the steps.

Time integrals of the signals, with powers up to the fourth and with e^(i w t), are quadratures at the stages, which are
exact for polynomials of degree 14.  For the spectra the quadrature terms are collected in bins, with the moments of
their places in the bin.  In a bin, e^(i w t) is its interpolant at Chebyshev points: with p moments, and w times half
the width of a bin at most 1, the relative error is about 2 (1/2)^p / p!, 2e-7 for the p here.
"""

import functools
import math

import numpy as np

from ...tracing import portable
from ...tracing.compiled.choosing import lane_range, rolled_range
from ...tracing.compiled.family import Routine, kernel, shaped
from ...tracing.memory import Fields
from ..observe import NODE_FRACTIONS, STAGES, START, TIME
from .collocation import WEIGHTS
from .slow_sums import DURATION, SIGNALS

POWERS = 4  # of the signals
BIN_MOMENTS = 8
BINS_PER_LINE = math.pi  # so that w times half the width of a bin is at most 1
NODE_COUNT = START + 1  # of a recorded step: stages, then its start
FRACTIONS = np.append(NODE_FRACTIONS[1:], 0.0)  # of the step, of these nodes
FINE_POINTS = np.arange(1, 4 * STAGES + 1) / (4 * STAGES)  # of the step, where extremes are searched
EXCESS = 0.12  # of the range of a signal at the nodes of a step, by which it may be larger between them
BITS = np.array([[p >> bit & 1 for p in range(BIN_MOMENTS)] for bit in range(3)], dtype=float)  # of each power p
REST = 1.0 - BITS
FORCES_AT = 2  # place of the forces on the frame among the columns with sums

#: From values at the nodes to the coefficients, highest first, of their polynomial over -1 to 1 in the step.
COEFFICIENTS = np.ascontiguousarray(portable.coefficients_through(2.0 * FRACTIONS - 1.0).rounded()[::-1].T)


def values_at(points: np.ndarray) -> np.ndarray:
    """Return the matrix (nodes, points) from values at the nodes to those of their polynomial at fractions `points`."""
    return _at(COEFFICIENTS, points)


def slopes_at(points: np.ndarray) -> np.ndarray:
    """Return the matrix (nodes, points) to derivatives by the fraction of the step."""
    return _at(2.0 * np.arange(NODE_COUNT - 1, 0, -1) * COEFFICIENTS[:, :-1], points)


def _at(coefficients: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return polynomials over -1 to 1, a row each, at fractions `points`, with the same bits on every processor."""
    total = np.zeros((len(coefficients), len(points)))
    for column in coefficients.T:
        total = total * (2.0 * points - 1.0) + column[:, None]
    return total


TO_FINE_POINTS = values_at(FINE_POINTS)


class Sizes(Fields):
    """Sizes of the arrays of `_add`, and the units of the bins."""

    width: float
    summed: float  # signals with sums and extremes
    spectral: float  # signals with a spectrum over time
    time_bins: float
    angle_bins: float
    start_time: float  # s
    time_scale: float  # bins per s
    angle: float  # column that is proportional to the crank angle
    stationary_point: float  # column of its derivative by the fraction of the step
    angle_scale: float  # bins per unit of the former


def _add(rows, settings, choices, sums, bounds, peaks, scratch, time_bins, angle_bins, count):
    """Add recorded steps to sums, bounds and bins; arrays are bare pointers.

    rows : (count, width, NODE_COUNT); choices : columns with sums, then those with spectra; sums : (width, POWERS,
    STAGES), of each stage; bounds : (width, 2) largest value of a signal and of its negative at FINE_POINTS; peaks :
    (width, 2, NODE_COUNT) the steps that contain them; scratch : (BIN_MOMENTS, STAGES); time_bins, angle_bins :
    (signals, bins, BIN_MOMENTS)
    """
    settings = Sizes(shaped(settings, (Sizes.SIZE,)))
    width, summed_count, spectral_count = int(settings.width), int(settings.summed), int(settings.spectral)
    rows, sums = shaped(rows, (count, width, NODE_COUNT)), shaped(sums, (width, POWERS, STAGES))
    choices, bounds = shaped(choices, (summed_count + spectral_count,)), shaped(bounds, (width, 2))
    peaks, scratch = shaped(peaks, (width, 2, NODE_COUNT)), shaped(scratch, (BIN_MOMENTS, STAGES))
    for i in rolled_range(count):
        for k in rolled_range(summed_count):
            c = choices[k]
            for m in lane_range(STAGES):
                value = rows[i, c, m]
                term = WEIGHTS[m] * rows[i, DURATION, m] * value
                square = term * value
                cube = square * value
                sums[c, 0, m] += term
                sums[c, 1, m] += square
                sums[c, 2, m] += cube
                sums[c, 3, m] += cube * value
            _update_extremes(rows[i, c], bounds[c], peaks[c], scratch)
        if spectral_count > 0:
            _collect(
                (rows[i], SIGNALS + TIME, DURATION, scratch),
                (settings.start_time, settings.time_scale),
                (choices, summed_count, spectral_count),
                shaped(time_bins, (spectral_count, int(settings.time_bins), BIN_MOMENTS)),
            )
        if settings.angle_bins > 0.0:
            _collect(
                (rows[i], int(settings.angle), int(settings.stationary_point), scratch),
                (0.0, settings.angle_scale),
                (choices, FORCES_AT, 2),
                shaped(angle_bins, (2, int(settings.angle_bins), BIN_MOMENTS)),
            )


@kernel
def _update_extremes(values, bounds, peaks, scratch):
    """Update the extremes of a signal by its `values` at the nodes of a step, and between them if they may be larger.

    bounds : (2,); peaks : (2, NODE_COUNT); see `_add`
    """
    low = high = values[START]
    for m in range(STAGES):
        low, high = min(low, values[m]), max(high, values[m])
    excess = EXCESS * (high - low)
    if high + excess > bounds[0] or excess - low > bounds[1]:
        for part in range(FINE_POINTS.size // STAGES):
            for i in lane_range(STAGES):
                total = 0.0
                for m in range(NODE_COUNT):
                    total += TO_FINE_POINTS[m, part * STAGES + i] * values[m]
                scratch[part, i] = total
        for part in range(FINE_POINTS.size // STAGES):
            for i in rolled_range(STAGES):
                low, high = min(low, scratch[part, i]), max(high, scratch[part, i])
        if high > bounds[0]:
            bounds[0] = high
            for m in range(NODE_COUNT):
                peaks[0, m] = values[m]
        if -low > bounds[1]:
            bounds[1] = -low
            for m in range(NODE_COUNT):
                peaks[1, m] = -values[m]


@kernel
def _collect(step, scale, chosen, bins):
    """Add the quadrature terms of a step to bins over time or angle.

    step : recorded values, column of time or angle, column of its derivative, scratch; scale : origin, bins per unit;
    chosen : columns, the first of them and their number; bins : (signals, bins, BIN_MOMENTS)
    """
    row, column, derivative, scratch = step
    columns, first, count = chosen
    bin_count = bins.shape[1]
    for m in rolled_range(STAGES):
        place = (row[column, m] - scale[0]) * scale[1]
        cell = math.floor(place)
        index = int(cell - bin_count * math.floor(cell / bin_count))
        offset, weight = place - cell - 0.5, WEIGHTS[m] * row[derivative, m]
        square = offset * offset
        fourth = square * square
        for p in lane_range(BIN_MOMENTS):  # the offset to the power p, times the weight
            low = (BITS[0, p] * offset + REST[0, p]) * (BITS[1, p] * square + REST[1, p])
            scratch[0, p] = weight * (low * (BITS[2, p] * fourth + REST[2, p]))
        for k in rolled_range(count):
            value = row[columns[first + k], m]
            for p in lane_range(BIN_MOMENTS):
                bins[k, index, p] += scratch[0, p] * value


add_steps = Routine(_add, "ffiffffff")


def spectrum(bins: np.ndarray, lines: int, spacing: float = 1.0) -> np.ndarray:
    """Return the integrals of signals times e^(-i w t) at w = 2 pi j `spacing` over the span of all bins.

    bins : (signals, bins, BIN_MOMENTS); the phase is that of a time half a bin earlier.  j is from 0 to `lines`; with a
    spacing other than 1 the signals begin in the first bin.  Shape (signals, lines + 1).
    """
    count = bins.shape[1]
    if spacing == 1.0:
        transforms, weights = np.fft.rfft(bins, axis=1)[:, : lines + 1], _weights(count)[: lines + 1]
    else:
        transforms = _chirp_transform(bins, lines + 1, spacing)
        weights = _weights_at(spacing * np.arange(lines + 1), count)
    total: np.ndarray = np.einsum("slp,lp->sl", transforms, weights)
    return total


def _chirp_transform(values: np.ndarray, lines: int, spacing: float) -> np.ndarray:
    """Return the sums of values (signals, n, p) times e^(-2 pi i j k `spacing` / n) over k, (signals, lines, p).

    By convolution with a chirp: Bluestein 1970, IEEE Transactions on Audio and Electroacoustics 18:451.
    """
    count = values.shape[1]
    places = np.arange(max(count, lines))
    chirp = np.exp(-1j * math.pi * spacing / count * places.astype(float) ** 2)
    size = 1 << (count + lines - 1).bit_length()
    kernel = np.zeros(size, dtype=complex)
    kernel[:lines], kernel[size - count + 1 :] = chirp[:lines].conj(), chirp[1:count][::-1].conj()
    product = np.fft.fft(values * chirp[:count, None], size, axis=1) * np.fft.fft(kernel)[:, None]
    transforms: np.ndarray = np.fft.ifft(product, axis=1)[:, :lines] * chirp[:lines, None]
    return transforms


@functools.lru_cache(maxsize=16)  # the cases of a sweep share it
def _weights(count: int) -> np.ndarray:
    """Return the weight (lines, BIN_MOMENTS) of each moment of a bin in each line that `count` bins resolve."""
    return _weights_at(np.arange(count // BINS_PER_LINE + 1), count)


def _weights_at(lines: np.ndarray, count: int) -> np.ndarray:
    """Return the weight (lines, BIN_MOMENTS) of each moment of a bin at `lines`, periods in `count` bins.

    They are the coefficients of the polynomial that is e^(-i w t) at Chebyshev points of the bin.
    """
    points = 0.5 * np.cos(math.pi * np.arange(1, BIN_MOMENTS, 2) / (2 * BIN_MOMENTS))  # of the width; or negative
    phases = 2.0 * math.pi / count * np.outer(lines, points)
    to_weights = portable.coefficients_through(points**2).rounded().T
    weights = np.empty((len(phases), BIN_MOMENTS), dtype=complex)
    weights[:, 0::2] = portable.product(np.cos(phases), to_weights)
    weights[:, 1::2] = -1j * portable.product(np.sin(phases) / points, to_weights)
    return weights
