"""Features of a signal over the crank angle: the same code for what was measured and what was computed."""

from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    import numpy as np  # loaded only where features are computed

TURN = 6.283185307179586  # rad
SAMPLES = 720  # of a revolution, at least
LARGEST_GRID = 4096  # samples of a revolution: the band of features ends at its Nyquist order
USED_BAND = 0.8  # of the Nyquist order of the coarser of two signals: filters of recorders roll off above
#: Orders of the crank from and to which the power of a signal is summed.
BANDS = (
    *((1, 1), (2, 2), (3, 3), (4, 4), (5, 6), (7, 8), (9, 11), (12, 16), (17, 22), (23, 32), (33, 45), (46, 64)),
    *((65, 90), (91, 128), (129, 181), (182, 256), (257, 362), (363, 512), (513, 724), (725, 1024)),
)
HARMONICS = 12  # of the energy of impacts over the crank angle, which say where in a revolution it is
RIGID_ORDERS = 12  # above, the power is attributed to impacts: motion without clearance has hardly any there
THRESHOLD = 0.2  # of the median over revolutions of the largest value above RIGID_ORDERS: beyond, it is an impact
WEAK = 0.05  # rms of an order over that of the signal, below which its phase cannot be followed
APART = 48  # at most so many impacts are distinguished in a revolution


class Features(NamedTuple):
    """Features of a signal, in its unit."""

    rms: float  # about its mean
    peak_median: float  # of the largest absolute values of its revolutions, about the mean
    peak_p95: float
    spectrum: tuple[float, ...]  # rms in each of BANDS
    impacts: float  # a revolution
    #: Cosine and sine parts of HARMONICS of the energy above RIGID_ORDERS over the crank angle, over that energy.
    phases: tuple[float, ...]


class Statistics(NamedTuple):
    """Statistics of each revolution of a signal, from which its features follow."""

    square: "np.ndarray"  # (turns,) mean square about the mean of the signal
    peak: "np.ndarray"  # (turns,)
    power: "np.ndarray"  # (turns, bands) mean square in each of BANDS
    impacts: "np.ndarray"  # (turns,)
    energy: "np.ndarray"  # (turns, HARMONICS + 1) complex harmonics of the square above RIGID_ORDERS, from 0 on

    def features(self, rows: "np.ndarray | slice" = slice(None)) -> Features:
        """Return the features of some of the revolutions."""
        import numpy as np

        peaks, power, energy = self.peak[rows], self.power[rows].mean(axis=0), self.energy[rows].mean(axis=0)
        shares = energy[1:] / max(float(energy[0].real), np.finfo(float).tiny)
        return Features(
            float(np.sqrt(self.square[rows].mean())),
            float(np.median(peaks)),
            float(np.percentile(peaks, 95.0)),
            tuple(np.sqrt(power).tolist()),
            float(self.impacts[rows].mean()),
            tuple(np.column_stack([shares.real, -shares.imag]).ravel().tolist()),
        )


def of(turns: "np.ndarray") -> Features:
    """Return the features of whole revolutions (turns, samples of a revolution) of a signal."""
    return statistics(turns).features()


def statistics(turns: "np.ndarray") -> Statistics:
    """Return the statistics of each of the revolutions (turns, samples of a revolution) of a signal."""
    import numpy as np

    count, samples = turns.shape
    about = turns - turns.mean()
    amplitudes = np.fft.rfft(turns, axis=1) / samples
    power = 2.0 * np.abs(amplitudes) ** 2
    bands = np.array([power[:, low : high + 1].sum(axis=1) for low, high in BANDS]).T
    above = about - _up_to(turns.ravel(), RIGID_ORDERS * count, len(turns.ravel())).reshape(turns.shape)
    energy = np.fft.rfft(above**2, axis=1)[:, : HARMONICS + 1] / samples
    return Statistics((about**2).mean(axis=1), np.abs(about).max(axis=1), bands, _impacts(np.abs(above)), energy)


def _impacts(size: "np.ndarray") -> "np.ndarray":
    """Return how many impacts begin in each revolution (turns, samples), by the absolute value of the fast part."""
    import numpy as np

    count, samples = size.shape
    level = THRESHOLD * float(np.median(size.max(axis=1)))
    high = np.flatnonzero(size.ravel() > level) if level > 0.0 else np.empty(0, int)
    begins = high[np.diff(high, prepend=-samples) > samples / APART]
    return np.bincount(begins // samples, minlength=count).astype(float)


def _up_to(values: "np.ndarray", highest: float, count: int) -> "np.ndarray":
    """Return `count` even samples of a repeating signal without its mean and its harmonics above the `highest`.

    The upper fifth of the band is faded out, so that a step does not ring.
    """
    import numpy as np

    spectrum = np.fft.rfft(values)[: count // 2 + 1]
    place = np.arange(len(spectrum)) / max(highest, 1.0)
    spectrum *= 0.5 + 0.5 * np.cos(np.pi * np.clip((place - 0.8) / 0.2, 0.0, 1.0))
    spectrum[0] = 0.0
    filtered: np.ndarray = np.fft.irfft(spectrum, count) * (count / len(values))
    return filtered


def noise(chance: "np.random.Generator", turns: "np.ndarray", orders: float) -> "np.ndarray":
    """Return even noise up to an order, with rms 1, in the shape of `turns` (turns, samples)."""
    import numpy as np

    white = _up_to(chance.standard_normal(turns.size), orders * len(turns), turns.size)
    normalised: np.ndarray = (white / np.sqrt((white**2).mean())).reshape(turns.shape)
    return normalised


def density(angle: "np.ndarray") -> float:
    """Return the number of samples per revolution of ascending crank angles (rad)."""
    import numpy as np

    return float(TURN / np.median(np.diff(angle)))


def common_band(*densities: float) -> float:
    """Return the highest order at which signals with these numbers of samples per revolution can be compared."""
    return USED_BAND * min(*densities, LARGEST_GRID) / 2.0


def grid_of(orders: float) -> int:
    """Return the number of samples per revolution that a band up to these orders needs."""
    samples = SAMPLES
    while samples < min(2.0 * orders / USED_BAND, LARGEST_GRID) - 1e-6:
        samples *= 2
    return samples


def revolutions(
    angle: "np.ndarray", values: "np.ndarray", start: float | None = None, orders: float | None = None
) -> "np.ndarray":
    """Return the whole revolutions (turns, samples) of values over ascending crank angles (rad), from `start` on.

    start : rad, of any revolution; defaults to the first angle
    orders : highest order that is kept; defaults to what the samples allow

    Between samples the signal is taken as linear, four times as fine as it is sampled: so its peaks stay.
    """
    import numpy as np

    own = density(angle)
    orders = common_band(own) if orders is None else orders
    samples = grid_of(orders)
    begin = angle[0] if start is None else start + TURN * np.ceil((angle[0] - start) / TURN - 1e-9)
    count = int(np.floor((angle[-1] - begin) / TURN + 1e-6))
    fine = samples * max(int(np.ceil(4.0 * own / samples)), 1)
    fitted: np.ndarray = np.interp(begin + TURN * np.arange(count * fine) / fine, angle, values)
    if not count:
        return fitted.reshape(0, samples)
    resampled: np.ndarray = fitted.mean() + _up_to(fitted, orders * count, count * samples).reshape(count, samples)
    return resampled


def shift(measured: "np.ndarray", computed: "np.ndarray", highest: int | None = None) -> int:
    """Return the lag (samples, from 0 on) of a measured revolution behind the computed one.

    Both are means over revolutions, (samples,); it is where their circular correlation is largest.

    highest : order up to which they are correlated; defaults to all
    """
    import numpy as np

    spectra = [
        np.fft.rfft(each - each.mean())[: None if highest is None else highest + 1] for each in (measured, computed)
    ]
    return int(np.argmax(np.fft.irfft(spectra[0] * np.conj(spectra[1]), len(measured))))


def angle_of_time(times: "np.ndarray", values: "np.ndarray", rate: float) -> "np.ndarray":
    """Return the crank angles (rad, 0 at first) of samples over time (s) whose mean crank speed is near `rate` (rad/s).

    The speed is where the orders 1 to 4 are strongest, within 5 % of `rate`.  What slowly varies about it is taken from
    the phase of the strongest of these orders, averaged twice over a revolution.
    """
    import numpy as np

    about = values - values.mean()
    span = times[-1] - times[0]
    even = np.linspace(times[0], times[-1], len(times))
    about = np.interp(even, times, about) * np.hanning(len(times))
    spectrum = np.abs(np.fft.rfft(about, 4 * len(about))) ** 2
    step = TURN / (4.0 * span * len(times) / (len(times) - 1))  # rad/s between its lines
    tried = rate * np.linspace(0.95, 1.05, 2001)
    lines = np.arange(len(spectrum)) * step
    power = [np.interp(order * tried, lines, spectrum) for order in (1, 2, 3, 4)]
    best = int(np.argmax(np.sum(power, axis=0)))
    mean, strongest = float(tried[best]), int(np.argmax([each[best] for each in power])) + 1
    angle: np.ndarray = mean * (times - times[0])
    for _ in range(2):  # the first time, what varies within a revolution leaves an error
        demodulated = (values - values.mean()) * np.exp(-1j * strongest * angle)
        smooth = _averaged(times, _averaged(times, demodulated, TURN / mean), TURN / mean)  # no other order leaks
        if np.abs(smooth).min() < WEAK * np.std(values):
            return angle
        phase = np.unwrap(np.angle(smooth)) / strongest
        better = angle + phase - phase[0]
        if (np.diff(better) <= 0.0).any():
            return angle
        angle = better
    return angle


def _averaged(times: "np.ndarray", values: "np.ndarray", width: float) -> "np.ndarray":
    """Return values over ascending times (s), each the mean of those within `width` (s) about it."""
    import numpy as np

    total = np.concatenate([[0.0], np.cumsum(values)])
    half = min(width, times[-1] - times[0]) / 2.0
    middle = np.clip(times, times[0] + half, times[-1] - half)  # of whole width at both ends, too
    first, last = np.searchsorted(times, middle - half), np.searchsorted(times, middle + half, side="right")
    averages: np.ndarray = (total[last] - total[first]) / np.maximum(last - first, 1)
    return averages
