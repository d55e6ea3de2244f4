"""Features of a signal over the crank angle: the same code for what was measured and what was computed."""

from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    import numpy as np  # loaded only where features are worked out

TURN = 6.283185307179586  # rad
SAMPLES = 720  # of a revolution
BANDS = ((1, 2), (3, 4), (5, 8), (9, 16), (17, 32), (33, 64), (65, 128), (129, 256))  # orders of the crank


class Features(NamedTuple):
    """What stays of a signal; in its unit."""

    rms: float  # about its mean
    peak_median: float  # of the largest absolute values of its revolutions, about the mean
    peak_p95: float
    spectrum: tuple[float, ...]  # rms in each of BANDS


def of(turns: "np.ndarray") -> Features:
    """Return the features of whole revolutions (turns, SAMPLES) of a signal."""
    import numpy as np

    about = turns - turns.mean()
    peaks = np.abs(about).max(axis=1)
    amplitudes = np.fft.rfft(turns, axis=1) / turns.shape[1]
    power = 2.0 * (np.abs(amplitudes) ** 2).mean(axis=0)
    bands = tuple(float(np.sqrt(power[low : high + 1].sum())) for low, high in BANDS)
    return Features(
        float(np.sqrt((about**2).mean())), float(np.median(peaks)), float(np.percentile(peaks, 95.0)), bands
    )


def revolutions(angle: "np.ndarray", values: "np.ndarray", start: float | None = None) -> "np.ndarray":
    """Return the whole revolutions (turns, SAMPLES) of values over ascending crank angles (rad), from `start` on.

    `start` defaults to the first angle.  Between samples the signal is taken as linear.
    """
    import numpy as np

    begin = angle[0] if start is None else start + TURN * np.ceil((angle[0] - start) / TURN - 1e-9)
    count = int(np.floor((angle[-1] - begin) / TURN + 1e-6))
    wanted = begin + TURN * np.arange(count * SAMPLES) / SAMPLES
    found: np.ndarray = np.interp(wanted, angle, values).reshape(count, SAMPLES)
    return found


def shift(measured: "np.ndarray", computed: "np.ndarray") -> int:
    """Return by how many samples a revolution that was measured lags behind the computed one, 0 to SAMPLES - 1.

    Both are means over revolutions, (SAMPLES,); it is where their circular correlation is largest.
    """
    import numpy as np

    spectra = [np.fft.rfft(each - each.mean()) for each in (measured, computed)]
    return int(np.argmax(np.fft.irfft(spectra[0] * np.conj(spectra[1]), SAMPLES)))
