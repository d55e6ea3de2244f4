"""Features of a signal over the crank angle, for measured and computed signals alike."""

from typing import NamedTuple

from ..language import np

TURN = 6.283185307179586  # rad
MIN_SAMPLES = 720  # least samples of a revolution
MAX_SAMPLES = 4096  # samples of a revolution; the features reach up to its Nyquist order
USED_BAND = 0.8  # of the coarser signal's Nyquist order; anti-aliasing filters roll off above
#: Bands of crank orders over which the power of a signal is summed.
BANDS = (
    *((1, 1), (2, 2), (3, 3), (4, 4), (5, 6), (7, 8), (9, 11), (12, 16), (17, 22), (23, 32), (33, 45), (46, 64)),
    *((65, 90), (91, 128), (129, 181), (182, 256), (257, 362), (363, 512), (513, 724), (725, 1024)),
)
HARMONICS = 12  # harmonics of impact energy over the crank angle, which locate impacts within a revolution
RIGID_ORDERS = 12  # above this order power is attributed to impacts; ideal motion has hardly any there
IMPACT_THRESHOLD = 0.2  # of the median per-revolution peak above RIGID_ORDERS; larger values are impacts
MIN_ORDER_RMS = 0.05  # rms of an order over that of the signal below which its phase cannot be tracked
MAX_IMPACTS = 48  # most impacts counted in a revolution


class Features(NamedTuple):
    """Features of a signal, in its unit."""

    rms: float  # about its mean
    peak_median: float  # mean over revolutions of the largest deviation from the mean
    peak_p95: float
    spectrum: tuple[float, ...]  # rms in each of BANDS
    impacts: float  # per revolution
    #: Cosine and sine parts of HARMONICS of the energy above RIGID_ORDERS over the crank angle, over that energy.
    phases: tuple[float, ...]
    crest: float  # median over revolutions of the largest deviation from the mean, over the rms
    kurtosis: float  # fourth moment about the mean over the square of the second; 1.5 of a sine


class RevolutionStatistics(NamedTuple):
    """Statistics of each revolution of a signal, from which its features follow."""

    mean_square: "np.ndarray"  # (revolutions,) mean square about the mean of the signal
    peak: "np.ndarray"  # (revolutions,)
    power: "np.ndarray"  # (revolutions, bands) mean square in each of BANDS
    impacts: "np.ndarray"  # (revolutions,)
    energy: "np.ndarray"  # (revolutions, HARMONICS + 1) complex harmonics of the square above RIGID_ORDERS, from 0 on
    mean_fourth: "np.ndarray"  # (revolutions,) mean fourth power of the deviations from the mean of the signal

    def features(self, rows: "np.ndarray | slice" = slice(None)) -> Features:
        """Return the features of a selection of revolutions."""
        peaks, power, energy = self.peak[rows], self.power[rows].mean(axis=0), self.energy[rows].mean(axis=0)
        relative_energy = energy[1:] / max(float(energy[0].real), np.finfo(float).tiny)
        mean_square = float(self.mean_square[rows].mean())
        return Features(
            float(np.sqrt(mean_square)),
            float(np.median(peaks)),
            float(np.percentile(peaks, 95.0)),
            tuple(np.sqrt(power).tolist()),
            float(self.impacts[rows].mean()),
            tuple(np.column_stack([relative_energy.real, -relative_energy.imag]).ravel().tolist()),
            float(np.median(peaks) / np.sqrt(mean_square)),
            float(self.mean_fourth[rows].mean() / mean_square**2),
        )


def features_of(revolutions: "np.ndarray") -> Features:
    """Return the features of a signal from whole `revolutions`, (revolutions, samples)."""
    return revolution_statistics(revolutions).features()


def revolution_statistics(revolutions: "np.ndarray") -> RevolutionStatistics:
    """Return the statistics of each of the `revolutions` (revolutions, samples) of a signal."""
    count, samples = revolutions.shape
    deviations = revolutions - revolutions.mean()
    amplitudes = np.fft.rfft(revolutions, axis=1) / samples
    power = 2.0 * np.abs(amplitudes) ** 2
    bands = np.array([power[:, low : high + 1].sum(axis=1) for low, high in BANDS]).T
    fast_part = deviations - _band_limited(revolutions.ravel(), RIGID_ORDERS * count, len(revolutions.ravel())).reshape(
        revolutions.shape
    )
    energy = np.fft.rfft(fast_part**2, axis=1)[:, : HARMONICS + 1] / samples
    return RevolutionStatistics(
        (deviations**2).mean(axis=1),
        np.abs(deviations).max(axis=1),
        bands,
        _count_impact_onsets(np.abs(fast_part)),
        energy,
        (deviations**4).mean(axis=1),
    )


def _count_impact_onsets(magnitude: "np.ndarray") -> "np.ndarray":
    """Return how many impacts begin in each revolution from the `magnitude` (revolutions, samples) of the fast part."""
    count, samples = magnitude.shape
    threshold = IMPACT_THRESHOLD * float(np.median(magnitude.max(axis=1)))
    above_threshold = np.flatnonzero(magnitude.ravel() > threshold) if threshold > 0.0 else np.empty(0, int)
    onsets = above_threshold[np.diff(above_threshold, prepend=-samples) > samples / MAX_IMPACTS]
    return np.bincount(onsets // samples, minlength=count).astype(float)


def _band_limited(values: "np.ndarray", highest_order: float, count: int) -> "np.ndarray":
    """Return `count` uniform samples of a periodic signal without mean and harmonics above `highest_order`.

    The upper fifth of the band is tapered to avoid ringing.
    """
    spectrum = np.fft.rfft(values)[: count // 2 + 1]
    orders = np.arange(len(spectrum)) / max(highest_order, 1.0)
    spectrum *= 0.5 + 0.5 * np.cos(np.pi * np.clip((orders - 0.8) / 0.2, 0.0, 1.0))
    spectrum[0] = 0.0
    filtered: np.ndarray = np.fft.irfft(spectrum, count) * (count / len(values))
    return filtered


def white_noise(rng: "np.random.Generator", revolutions: "np.ndarray", highest_order: float) -> "np.ndarray":
    """Return white noise up to an order, with rms 1, in the shape of `revolutions` (revolutions, samples)."""
    white = _band_limited(rng.standard_normal(revolutions.size), highest_order * len(revolutions), revolutions.size)
    normalised: np.ndarray = (white / np.sqrt((white**2).mean())).reshape(revolutions.shape)
    return normalised


def samples_per_revolution(angle: "np.ndarray") -> float:
    """Return the number of samples per revolution of ascending crank angles (rad)."""
    return float(TURN / np.median(np.diff(angle)))


def highest_common_order(*sampling_rates: float) -> float:
    """Return the highest order at which signals with these numbers of samples per revolution can be compared."""
    return USED_BAND * min(*sampling_rates, MAX_SAMPLES) / 2.0


def samples_for_band(highest_order: float) -> int:
    """Return the number of samples per revolution for a band up to `highest_order`."""
    samples = MIN_SAMPLES
    while samples < min(2.0 * highest_order / USED_BAND, MAX_SAMPLES) - 1e-6:
        samples *= 2
    return samples


def split_revolutions(
    angle: "np.ndarray", values: "np.ndarray", start: float | None = None, highest_order: float | None = None
) -> "np.ndarray":
    """Return the whole revolutions (revolutions, samples) of values over ascending crank angles (rad), from `start` on.

    start : rad, of any revolution; defaults to the first angle
    highest_order : highest order kept; by default as high as the samples allow

    The signal is interpolated linearly at four times its sampling, which keeps its peaks.
    """
    sampling_rate = samples_per_revolution(angle)
    highest_order = highest_common_order(sampling_rate) if highest_order is None else highest_order
    samples = samples_for_band(highest_order)
    first_angle = angle[0] if start is None else start + TURN * np.ceil((angle[0] - start) / TURN - 1e-9)
    count = int(np.floor((angle[-1] - first_angle) / TURN + 1e-6))
    fine_samples = samples * max(int(np.ceil(4.0 * sampling_rate / samples)), 1)
    interpolated: np.ndarray = np.interp(
        first_angle + TURN * np.arange(count * fine_samples) / fine_samples, angle, values
    )
    if not count:
        return interpolated.reshape(0, samples)
    resampled: np.ndarray = interpolated.mean() + _band_limited(
        interpolated, highest_order * count, count * samples
    ).reshape(count, samples)
    return resampled


def find_lag(measured: "np.ndarray", computed: "np.ndarray", highest_order: int | None = None) -> int:
    """Return the lag (samples, from 0 on) of a measured revolution behind the computed one.

    Both are means over revolutions, (samples,); the lag maximises their circular correlation.

    highest_order : highest order in the correlation; by default all
    """
    spectra = [
        np.fft.rfft(signal - signal.mean())[: None if highest_order is None else highest_order + 1]
        for signal in (measured, computed)
    ]
    return int(np.argmax(np.fft.irfft(spectra[0] * np.conj(spectra[1]), len(measured))))


def track_crank_angle(times: "np.ndarray", values: "np.ndarray", nominal_rate: float) -> "np.ndarray":
    """Return the crank angles (rad, from 0) of samples at times (s) for mean crank speed near `nominal_rate` (rad/s).

    The speed maximises the power of orders 1 to 4 within 5 % of `nominal_rate`.  Its slow variation is taken from
    the phase of the strongest of these orders, averaged twice over a revolution.
    """
    deviations = values - values.mean()
    span = times[-1] - times[0]
    uniform_times = np.linspace(times[0], times[-1], len(times))
    deviations = np.interp(uniform_times, times, deviations) * np.hanning(len(times))
    spectrum = np.abs(np.fft.rfft(deviations, 4 * len(deviations))) ** 2
    resolution = TURN / (4.0 * span * len(times) / (len(times) - 1))  # rad/s, resolution of the spectrum
    trial_rates = nominal_rate * np.linspace(0.95, 1.05, 2001)
    spectrum_rates = np.arange(len(spectrum)) * resolution
    power = [np.interp(order * trial_rates, spectrum_rates, spectrum) for order in (1, 2, 3, 4)]
    best_index = int(np.argmax(np.sum(power, axis=0)))
    mean_rate = float(trial_rates[best_index])
    strongest_order = int(np.argmax([spectrum[best_index] for spectrum in power])) + 1
    angle: np.ndarray = mean_rate * (times - times[0])
    for _ in range(2):  # the first pass leaves an error from variation within a revolution
        demodulated = (values - values.mean()) * np.exp(-1j * strongest_order * angle)
        smooth = _moving_average(
            times, _moving_average(times, demodulated, TURN / mean_rate), TURN / mean_rate
        )  # filters other orders
        if np.abs(smooth).min() < MIN_ORDER_RMS * np.std(values):
            return angle
        phase = np.unwrap(np.angle(smooth)) / strongest_order
        refined_angle = angle + phase - phase[0]
        if (np.diff(refined_angle) <= 0.0).any():
            return angle
        angle = refined_angle
    return angle


def _moving_average(times: "np.ndarray", values: "np.ndarray", width: float) -> "np.ndarray":
    """Return the moving average of values over ascending times (s) within a window of `width` (s)."""
    cumulative = np.concatenate([[0.0], np.cumsum(values)])
    half_width = min(width, times[-1] - times[0]) / 2.0
    centres = np.clip(times, times[0] + half_width, times[-1] - half_width)  # full width also at both ends
    first_index = np.searchsorted(times, centres - half_width)
    end_index = np.searchsorted(times, centres + half_width, side="right")
    averages: np.ndarray = (cumulative[end_index] - cumulative[first_index]) / np.maximum(end_index - first_index, 1)
    return averages
