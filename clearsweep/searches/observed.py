"""Measured signals over the crank angle, and feature vectors of them and of cases, computed by the same code."""

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np

from ..answers import features
from ..grid.written.tables import read_signals
from ..language.errors import InputError

GAIN = 0.05  # standard deviation of the logarithm of a sensor's gain: 95 % within 10 %
NOISE = (2e-3, 0.2)  # range of rms noise over rms signal in the compared band, with a log-uniform prior
MODEL_ERRORS = {
    "rms": 0.03,
    "peaks": 0.05,
    "spectrum": 0.05,
    "impacts": 0.05,
    "phases": 0.03,
}  # model error: standard deviations of logarithms of features, and of phases
BOOTSTRAP_DRAWS = 200  # bootstrap draws of revolutions, for the scatter of measured features
SPECTRUM_FLOOR = 2e-3  # of the rms: smaller values in a band count as equal
ALIGNED_ORDERS = 6  # orders used to find the crank angle of a signal: those of the ideal motion
MIN_REVOLUTIONS = 3  # revolutions that have to be measured, and computed of every case
MIN_SAMPLES_PER_IMPACT = 20  # an impact


class Signal(NamedTuple):
    """One measured signal."""

    file: str  # its path, whole
    channel: str  # of time histories, which it is compared with
    column: str  # of the file
    unit: str  # of the channel, SI


class AngularSignal(NamedTuple):
    """A measured signal over the crank angle."""

    signal: Signal
    angle: np.ndarray  # (n,) rad, ascending
    values: np.ndarray  # (n,) SI
    speed: float | None  # rad/s, mean, where the file has time


def angular_signals(file: str, signals: list[Signal], rate: float | None) -> list[AngularSignal]:
    """Return signals of a file over the crank angle; raise InputError if they have too few revolutions or samples.

    rate : crank speed (rad/s), or None if it is not a single number
    """
    known_units: Mapping[str, str | None] = {signal.column: signal.unit for signal in signals}
    content = read_signals(file, known_units, allow_others=True)
    angular = []
    for signal in signals:
        values, angle, speed = content.signals[signal.column], content.abscissa, None
        if content.over == "time":
            if rate is None:
                raise InputError(
                    f"{file}:1: has the column time, but drive.speed is not constant here; add a column "
                    "crank_angle [deg]"
                )
            angle = features.track_crank_angle(content.abscissa, values, rate)
            speed = float((angle[-1] - angle[0]) / (content.abscissa[-1] - content.abscissa[0]))
        _check_sampling(file, signal.column, angle, values)
        angular.append(AngularSignal(signal, angle, values, speed))
    return angular


def _check_sampling(file: str, column: str, angle: np.ndarray, values: np.ndarray) -> None:
    """Raise InputError if a signal has too few revolutions, or too few samples per impact."""
    count, density = (angle[-1] - angle[0]) / features.TURN, features.samples_per_revolution(angle)
    if count < MIN_REVOLUTIONS - 1e-6:
        raise InputError(f"{file}: {column} has {count:.3g} revolutions; at least {MIN_REVOLUTIONS} are needed")
    impacts = max(features.features_of(features.split_revolutions(angle, values)).impacts, 1.0)
    if density < MIN_SAMPLES_PER_IMPACT * impacts:
        raise InputError(
            f"{file}: {column} has {density:.3g} samples a revolution and {impacts:.3g} impacts a revolution, "
            f"{density / impacts:.2g} samples an impact; at least {MIN_SAMPLES_PER_IMPACT} are needed: "
            f"{MIN_SAMPLES_PER_IMPACT * impacts:.3g} samples a revolution"
        )


class FeatureLabel(NamedTuple):
    """Meaning of an element of a feature vector."""

    signal: int
    kind: str  # one of `identify.FEATURES`
    text: str
    unit: str  # '' for a phase, which has little meaning alone

    def feature_value(self, value: float) -> float:
        """Return the feature from its element of a vector."""
        return float(np.expm1(value) if self.kind == "impacts" else np.exp(value))


class ObservedSignal(NamedTuple):
    """A measured signal: its revolutions, and the statistics that cases are compared with."""

    angular: AngularSignal
    revolutions: np.ndarray  # (turns, samples)
    orders: float  # highest crank order compared
    rms: float

    def angle(self, history: Mapping[str, np.ndarray]) -> float:
        """Return the offset (rad, -pi to pi) of the measured crank angle from that of a case."""
        computed = self._computed(history)
        lag = features.find_lag(self.revolutions.mean(axis=0), computed.mean(axis=0), ALIGNED_ORDERS)
        phase_shift = float(features.TURN * lag / computed.shape[1] + self.angular.angle[0]) % features.TURN
        return phase_shift - features.TURN * (phase_shift > features.TURN / 2.0)

    def statistics(
        self, history: Mapping[str, np.ndarray], noise_ratio: float, rng: "np.random.Generator"
    ) -> features.RevolutionStatistics:
        """Return the statistics of a case at the measured crank angle.

        noise_ratio : rms of the added noise over the measured rms
        """
        computed = self._computed(history)
        lag = features.find_lag(self.revolutions.mean(axis=0), computed.mean(axis=0), ALIGNED_ORDERS)
        noisy = computed + noise_ratio * self.rms * features.white_noise(rng, computed, self.orders)
        return features.revolution_statistics(np.roll(noisy.ravel(), lag).reshape(computed.shape))

    def _computed(self, history: Mapping[str, np.ndarray]) -> np.ndarray:
        angle, values = history["crank_angle"], history[self.angular.signal.channel]
        return features.split_revolutions(angle, values, 0.0, self.orders)


class Observation(NamedTuple):
    """All measured signals as one feature vector."""

    signals: tuple[ObservedSignal, ...]
    labels: tuple[FeatureLabel, ...]
    feature_names: tuple[str, ...]  # of `identify.FEATURES`
    values: np.ndarray  # (features,)
    covariance: np.ndarray  # (features, features): scatter of the measurement, gain error and model error

    def of_case(self, history: Mapping[str, np.ndarray], noise: np.ndarray, rng: "np.random.Generator") -> np.ndarray:
        """Return the feature vector (features,) of a case; noise : (signals,) shares of the signals' rms."""
        vectors = []
        for observed, noise_ratio in zip(self.signals, noise.tolist(), strict=True):
            features_of_case = observed.statistics(history, noise_ratio, rng).features()
            vectors.append(feature_vector(features_of_case, observed.orders, self.feature_names))
        return np.concatenate(vectors)


def observe(identify: Any, history: Mapping[str, np.ndarray]) -> Observation:
    """Return the measurement, prepared for cases with the sampling of `history`."""
    span, angle = history["t"][-1] - history["t"][0], history["crank_angle"][-1] - history["crank_angle"][0]
    observations: list[ObservedSignal] = []
    for file in dict.fromkeys(signal.file for signal in identify.signals):
        signals = [signal for signal in identify.signals if signal.file == file]
        for angular in angular_signals(file, signals, float(angle / span)):
            orders = features.highest_common_order(
                features.samples_per_revolution(angular.angle), features.samples_per_revolution(history["crank_angle"])
            )
            revolutions = features.split_revolutions(angular.angle, angular.values, None, orders)
            rms = float(np.sqrt(((revolutions - revolutions.mean()) ** 2).mean()))
            if not rms > 0.0:
                raise InputError(f"{file}: {angular.signal.column} does not vary; measure it again, or leave it out")
            observations.append(ObservedSignal(angular, revolutions, orders, rms))
    labels: list[FeatureLabel] = []
    values, covariances = [], []
    for index, observed in enumerate(observations):
        new_labels = list(_labels(index, observed, identify.features))
        statistics = features.revolution_statistics(observed.revolutions)
        values.append(feature_vector(statistics.features(), observed.orders, identify.features))
        covariances.append(_signal_covariance(statistics, observed, identify, new_labels))
        labels += new_labels
    covariance = np.zeros((len(labels), len(labels)))
    first = 0
    for signal_covariance in covariances:
        covariance[first : first + len(signal_covariance), first : first + len(signal_covariance)] = signal_covariance
        first += len(signal_covariance)
    return Observation(tuple(observations), tuple(labels), identify.features, np.concatenate(values), covariance)


def feature_vector(measured: features.Features, orders: float, names: tuple[str, ...]) -> np.ndarray:
    """Return the chosen features, transformed so that relative errors have a uniform effect."""
    values_by_feature: dict[str, list[float]] = {
        "rms": [np.log(measured.rms)],
        "peaks": [np.log(measured.peak_median), np.log(measured.peak_p95)],
        "spectrum": [np.log(measured.spectrum[k] + SPECTRUM_FLOOR * measured.rms) for k in _band_edges(orders)],
        "impacts": [np.log1p(measured.impacts), *measured.phases],
    }
    return np.array([number for name in names for number in values_by_feature[name]])


def _band_edges(orders: float) -> list[int]:
    return [index for index, (_, high) in enumerate(features.BANDS) if high <= max(orders, features.BANDS[0][1])]


def _labels(index: int, observed: ObservedSignal, names: tuple[str, ...]) -> Iterator[FeatureLabel]:
    unit = observed.angular.signal.unit
    bands = [features.BANDS[k] for k in _band_edges(observed.orders)]
    texts = {
        "rms": [("rms", unit)],
        "peaks": [("peak per revolution, median", unit), ("peak per revolution, p95", unit)],
        "spectrum": [(f"rms, orders {low} to {high}", unit) for low, high in bands],
        "impacts": [
            ("impacts a revolution", "1"),
            *(
                (f"phase of impacts, harmonic {k}, {component}", "")
                for k in range(1, features.HARMONICS + 1)
                for component in ("cosine", "sine")
            ),
        ],
    }
    for name in names:
        yield from (FeatureLabel(index, name, *text) for text in texts[name])


def _signal_covariance(
    statistics: features.RevolutionStatistics, observed: ObservedSignal, identify: Any, labels: list[FeatureLabel]
) -> np.ndarray:
    """Return the covariance of a signal's features, without the emulator's part."""
    count = len(statistics.peak)
    rng = np.random.default_rng([identify.seed, count])
    sample_indices = rng.integers(count, size=(BOOTSTRAP_DRAWS, count))
    vectors = np.array(
        [feature_vector(statistics.features(row), observed.orders, identify.features) for row in sample_indices]
    )
    gain = np.array([GAIN * (label.kind != "impacts") for label in labels])
    model_covariance = np.diag([MODEL_ERRORS[label.kind if label.unit else "phases"] ** 2 for label in labels])
    covariance: np.ndarray = np.cov(vectors.T) * count / (count - 1.0) + np.outer(gain, gain) + model_covariance
    return covariance
