"""Measured signals and their features, and the parameters of a grid that explain them."""

import contextlib
import itertools
import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..answers import features
from ..contracts.layout import Column
from ..contracts.search import CaseResults, Found, Point, SearchTable
from ..grid import Grid
from ..grid.written.tables import read_signals
from ..language.errors import InputError
from . import emulator
from .seeking import ROUND_SIZE

# ----------------------------------------------------------------------------------------------------------------------
# Measured signals over the crank angle, and feature vectors of them and of cases, computed by the same code.


GAIN = 0.05  # standard deviation of the logarithm of a sensor's gain: 95 % within 10 %
NOISE = (2e-3, 0.2)  # range of rms noise over rms signal in the compared band, with a log-uniform prior
MODEL_ERRORS = {
    "rms": 0.03,
    "peaks": 0.05,
    "spectrum": 0.05,
    "impacts": 0.05,
    "signature": 0.05,
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
    output: str = ""  # the column of a second encoder; the first is that of the input
    arms: tuple[float, ...] = ()  # m or 1, of both: by which their angles add to the position in a play

    @property
    def columns(self) -> dict[str, str]:
        """Return the columns of the file that it needs, and their SI units."""
        return {self.column: "rad", self.output: "rad"} if self.output else {self.column: self.unit}


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
    known_units: dict[str, str | None] = {}
    for signal in signals:
        known_units |= signal.columns
    content = read_signals(file, known_units, allow_others=True)
    angular = []
    for signal in signals:
        values, angle, speed = content.signals[signal.column], content.abscissa, None
        if signal.output:
            values = signal.arms[0] * values + signal.arms[1] * content.signals[signal.output]
        if content.over == "time":
            if rate is None:
                raise InputError(
                    f"{file}:1: has the column time, but drive.speed is not constant here; add a column "
                    "crank_angle [deg], or write simulate.cycles and their period"
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
    from scipy.linalg import block_diag

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
    covariance = block_diag(*covariances)
    return Observation(tuple(observations), tuple(labels), identify.features, np.concatenate(values), covariance)


def feature_vector(measured: features.Features, orders: float, names: tuple[str, ...]) -> np.ndarray:
    """Return the chosen features, transformed so that relative errors have a uniform effect."""
    values_by_feature: dict[str, list[float]] = {
        "rms": [np.log(measured.rms)],
        "peaks": [np.log(measured.peak_median), np.log(measured.peak_p95)],
        "spectrum": [np.log(measured.spectrum[k] + SPECTRUM_FLOOR * measured.rms) for k in _band_edges(orders)],
        "impacts": [np.log1p(measured.impacts), *measured.phases],
        "signature": [np.log(measured.crest), np.log(measured.kurtosis)],
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
        "signature": [("crest", "1"), ("kurtosis", "1")],
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
    gain = np.array([GAIN * (label.kind not in ("impacts", "signature")) for label in labels])
    model_covariance = np.diag([MODEL_ERRORS[label.kind if label.unit else "phases"] ** 2 for label in labels])
    covariance: np.ndarray = np.cov(vectors.T) * count / (count - 1.0) + np.outer(gain, gain) + model_covariance
    return covariance


# ----------------------------------------------------------------------------------------------------------------------
# Identifies a measured machine, round by round: cases, an emulator of their features, a posterior.
#
# An interrupted run repeats the same rounds: they depend only on stored cases, on the
# files of measured signals and on the seed, and are computed on one thread.


if TYPE_CHECKING:
    from sklearn.gaussian_process import kernels

UNIFORM_FIRST_CASES = 96  # evenly spread cases before an emulator chooses, at most half of all
UNIFORM_CASES = 3  # evenly spread cases in each later round, so that distant likely regions are not missed
SAMPLE_SIZES, SAMPLE_ITERATIONS = (1024, 4096), (2, 3)  # sample size of a posterior between rounds, and of the last one
MIN_CASES = 12  # cases that must finish
CASES_PER_NARROWING = (
    48  # cases after which the ranges are narrowed to likely values, where the emulator is more accurate
)
NARROWING_MARGIN = 0.15  # margin kept on either side, of the width of the likely range
MIN_CASES_PER_INPUT = 12  # cases per input in an emulator: those nearest to the ranges
NARROWING_QUANTILES = (0.002, 0.998)  # quantiles of a flattened posterior that bound the narrowed ranges
STORED_ROWS = 4096  # stored rows of the sample
BEST_CASES = 8
WELL_DETERMINED_WIDTH, WEAKLY_DETERMINED_WIDTH = (0.5, 0.8)  # most width of an interval over that of the prior
TRADE_OFF_CORRELATION = 0.8  # correlation of two keys above which they trade off
END_TOLERANCE = 0.02  # of a range: an interval this close to its end counts as ending there
MISFIT_PROBABILITY = 0.01  # probability of the misfit below which the model does not explain the measurement


class Parameter(NamedTuple):
    """Identified value of a key, in SI."""

    path: str
    value: float  # median
    low: float  # lower end of the 95 % interval
    high: float
    determined: str  # 'well', 'weakly' or 'not'
    ends: tuple[str, ...]  # 'lower', 'upper': ends of the range that the interval reaches


class FeatureFit(NamedTuple):
    """Fit of the best cases to a feature, in SI."""

    channel: str
    kind: str
    feature: str
    unit: str
    measured: float
    computed: float  # median of the best cases
    deviations: float  # measured minus computed at the best point, in standard deviations


class SignalTreatment(NamedTuple):
    """Treatment of a signal."""

    file: str
    channel: str
    revolutions: int
    samples: float  # of a revolution
    orders: float  # highest order compared
    angle: float  # rad, offset of its crank angle
    speed: float | None  # rad/s, mean, if it is over time
    noise: tuple[float, float, float]  # rms of noise over that of the signal: median and ends of the interval


@dataclass(frozen=True)
class IdentifyFound(Found):
    """Result of an identification."""

    parameters: tuple[Parameter, ...]
    traded: tuple[tuple[str, str, float], ...]  # pairs of keys that trade off, and their correlation
    fits: tuple[FeatureFit, ...]
    signals: tuple[SignalTreatment, ...]
    misfit: float  # mean squared distance in standard deviations; 1 is expected
    explained: bool
    looked_at: int
    finished: int
    computed_speed: float  # rad/s, mean crank speed of the cases
    sample: dict[str, np.ndarray]  # path -> values; 'weight'
    priors: Mapping[str, Any]  # of a sensor's gain and of noise

    def table(self, axes: Sequence[Column], units: Mapping[str, str]) -> SearchTable:
        """Return a weighted sample of the keys."""
        columns = [axis._replace(description="value that it may have") for axis in axes]
        columns += [Column("weight", "1", "probability of the row, 1 in all")]
        return SearchTable(columns, [self.sample[column.name].tolist() for column in columns])

    def entries(self) -> dict[str, Any]:
        """Return the result for run.json."""
        return {"identified": self.facts(None, {}, None)}

    def facts(self, catalogue: Any, record: Mapping[str, Any], judged: Any) -> dict[str, Any]:
        """Return the result without the sample, in SI units."""
        signals = [
            signal._asdict() | {"file": Path(signal.file).name, "noise": list(signal.noise)} for signal in self.signals
        ]
        return {
            "parameters": [fact._asdict() | {"ends": list(fact.ends)} for fact in self.parameters],
            "traded": [list(pair) for pair in self.traded],
            "fits": [fit._asdict() for fit in self.fits],
            "signals": signals,
            **{name: getattr(self, name) for name in ("misfit", "explained", "looked_at", "finished")},
            "computed_speed": self.computed_speed,
            "priors": self.priors,
        }


@dataclass(frozen=True)
class NotIdentified(Found):
    """Too few cases finished for an answer."""

    note: str

    def entries(self) -> dict[str, Any]:
        """Return that there is no result."""
        return {"identified": None}


class Identification:
    """One identification, round by round."""

    def __init__(self, identify: Any):  # `identify.Identify`, which is above this file
        self.identify = identify
        self.observation: Observation | None = None
        self.history: dict[str, np.ndarray] = {}  # of the first case that finished
        self.looked_at = 0
        self.points: list[np.ndarray] = []  # inputs of finished cases: keys and noise, in parts of their ranges
        self.values: list[np.ndarray] = []  # features of finished cases
        self.trained: tuple[int, list[kernels.Kernel] | None] = (0, None)  # cases of the last search for lengths
        self.narrowed_ranges = np.array([[0.0] * len(identify.over), [1.0] * len(identify.over)])  # narrowed ranges
        self.narrowed_at = 0  # cases at the last narrowing

    def record(self, grid: Grid, first_index: int, results: CaseResults) -> None:
        """Record the results of a grid's cases from the index `first_index` on."""
        for index, status, channels in zip(
            range(first_index, len(grid)), results.status, results.histories, strict=True
        ):
            self.looked_at += 1
            if status != "ok":
                continue
            rate, history = self.identify.cycle_rate, channels
            if rate:  # the phase of a cycle takes the place of the crank angle
                history = {**channels, "crank_angle": rate * channels["t"]}
            if self.observation is None:
                self.observation, self.history = observe(self.identify, history), history
            rng = np.random.default_rng([self.identify.seed, int(grid.case_id(index), 16)])
            noise_fractions = rng.random(len(self.observation.signals))
            features = self.observation.of_case(history, _noise_of_fractions(noise_fractions), rng)
            point = grid.point(index)
            key_fractions = [choice.fraction_of(point[path]) for path, choice in self.identify.over.items()]
            if np.isfinite(features).all():
                self.points.append(np.array([*key_fractions, *noise_fractions]))
                self.values.append(features)

    def ask(self) -> list[Point]:
        """Return the points of the next cases."""
        count = min(ROUND_SIZE, self.identify.cases - self.looked_at)
        if count <= 0:
            return []
        uniform = self.narrowed_ranges[0] + (
            self.narrowed_ranges[1] - self.narrowed_ranges[0]
        ) * self.identify.sobol_points(self.looked_at, count)
        if self.looked_at < min(UNIFORM_FIRST_CASES, self.identify.cases // 2) or len(self.points) < MIN_CASES:
            return [self.identify.point(fractions) for fractions in uniform]
        with _reproducible():
            rng = np.random.default_rng([self.identify.seed, self.looked_at])
            posterior = self._posterior(rng, is_last=False)[1]
            weights = emulator.flattened(posterior)
            if self.looked_at >= self.narrowed_at + CASES_PER_NARROWING:
                self._narrow(posterior._replace(weights=weights))
            selected = rng.choice(len(weights), max(count - UNIFORM_CASES, 1), replace=False, p=weights)
        likely = posterior.points[selected, : len(self.identify.over)]
        return [self.identify.point(fractions) for fractions in [*likely, *uniform[: count - len(likely)]]]

    def result(self) -> IdentifyFound | NotIdentified:
        """Return the final result; that of too few finished cases says so."""
        if len(self.points) < MIN_CASES:
            return NotIdentified(
                f"identify: nothing is identified, as only {len(self.points)} of {self.looked_at} cases finished and "
                f"at least {MIN_CASES} are needed; read the messages of the failed cases, then change the ranges under "
                "identify.over or allow more cases"
            )
        with _reproducible():
            rng = np.random.default_rng([self.identify.seed, self.looked_at])
            return self._result_of_posterior(*self._posterior(rng, is_last=True))

    def _narrow(self, posterior: emulator.Posterior) -> None:
        """Narrow the ranges to likely values."""
        intervals = np.array(
            [posterior.quantiles(column, NARROWING_QUANTILES) for column in range(self.narrowed_ranges.shape[1])]
        ).T
        margin = NARROWING_MARGIN * (intervals[1] - intervals[0])
        ranges = np.clip(
            [intervals[0] - margin, intervals[1] + margin], self.narrowed_ranges[0], self.narrowed_ranges[1]
        )
        self.narrowed_at, self.narrowed_ranges, self.trained = self.looked_at, ranges, (0, None)

    def _nearest_cases(self, points: np.ndarray) -> np.ndarray:
        """Return the indices of the cases for the emulator: those within the ranges, if there are enough."""
        keys = points[:, : self.narrowed_ranges.shape[1]]
        distances = np.maximum(self.narrowed_ranges[0] - keys, keys - self.narrowed_ranges[1]).max(axis=1)
        minimum = MIN_CASES_PER_INPUT * points.shape[1]
        return np.sort(
            np.argsort(np.maximum(distances, 0.0), kind="stable")[: max(np.count_nonzero(distances <= 0.0), minimum)]
        )

    def _posterior(
        self, rng: "np.random.Generator", *, is_last: bool
    ) -> tuple[emulator.LikelihoodModel, emulator.Posterior, np.ndarray]:
        """Return the likelihood on the narrowed ranges, a sample of the posterior, and its most likely point.

        The sample is in fractions of the whole ranges; the most likely point (inputs,) in those of the narrowed ranges.
        """
        assert self.observation is not None  # cases finished
        nearest = self._nearest_cases(np.array(self.points))
        points, values = np.array(self.points)[nearest], np.array(self.values)[nearest]
        key_count = self.narrowed_ranges.shape[1]
        ranges = np.hstack([self.narrowed_ranges, np.array([[0.0], [1.0]]).repeat(points.shape[1] - key_count, axis=1)])
        points = (points - ranges[0]) / (ranges[1] - ranges[0])
        trained_count, kernels = self.trained
        must_train = is_last or kernels is None or len(points) >= 2 * trained_count
        emulated = emulator.fit(points, values, None if must_train else kernels)
        if must_train:
            self.trained = (len(points), emulated.kernels)
        likelihood = emulator.LikelihoodModel(emulated, self.observation.values, self.observation.covariance)
        inputs, size, iterations = points.shape[1], SAMPLE_SIZES[is_last], SAMPLE_ITERATIONS[is_last]
        posterior = emulator.sample(likelihood, inputs, rng, size, iterations)
        smallest = float(posterior.squares.min()) / len(self.observation.values)
        if smallest > 1.0:  # errors exceed the assumed ones
            likelihood = likelihood._replace(inflation=smallest)
            posterior = emulator.sample(likelihood, inputs, rng, size, iterations)
        best = posterior.points[np.argmax(likelihood.log_likelihood(posterior.squares, posterior.volumes))]
        return likelihood, posterior._replace(points=ranges[0] + (ranges[1] - ranges[0]) * posterior.points), best

    def _result_of_posterior(
        self, likelihood: emulator.LikelihoodModel, posterior: emulator.Posterior, best: np.ndarray
    ) -> IdentifyFound:
        from scipy.stats import chi2

        assert self.observation is not None  # cases finished
        over = self.identify.over
        parameters = []
        for column, (path, choice) in enumerate(over.items()):
            low, median, high = posterior.quantiles(column, (0.025, 0.5, 0.975))
            width = (high - low) / 0.95
            determined = (
                "well" if width <= WELL_DETERMINED_WIDTH else "weakly" if width <= WEAKLY_DETERMINED_WIDTH else "not"
            )
            reached_ends = [
                end
                for end, is_at_end in (("lower", low < END_TOLERANCE), ("upper", high > 1.0 - END_TOLERANCE))
                if is_at_end
            ]
            values = (choice.value_at(median), choice.value_at(low), choice.value_at(high))
            parameters.append(Parameter(path, *values, determined, tuple(reached_ends)))
        names, weights = list(over), posterior.weights
        points = posterior.points[:, : len(names)]
        covariance = np.atleast_2d(np.cov(points.T, aweights=weights))
        sizes = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
        correlated: np.ndarray = covariance / np.outer(sizes, sizes)
        traded = [
            (names[i], names[j], float(correlated[i, j]))
            for i, j in itertools.combinations(range(len(names)), 2)
            if abs(correlated[i, j]) >= TRADE_OFF_CORRELATION
        ]
        square, count = likelihood.inflation * len(likelihood.measured), len(likelihood.measured)
        angle, times = self.history["crank_angle"], self.history["t"]
        return IdentifyFound(
            tuple(parameters),
            tuple(traded),
            tuple(self._feature_fits(likelihood, best)),
            tuple(self._signal_treatments(posterior)),
            likelihood.inflation,
            bool(chi2.sf(square, count) >= MISFIT_PROBABILITY) or likelihood.inflation == 1.0,
            self.looked_at,
            len(self.points),
            float((angle[-1] - angle[0]) / (times[-1] - times[0])),
            self._stored_sample(posterior),
            {"gain": GAIN, "noise": list(NOISE)},
        )

    def _feature_fits(self, likelihood: emulator.LikelihoodModel, best: np.ndarray) -> Iterator[FeatureFit]:
        """Yield the fit of the best cases to each meaningful feature."""
        assert self.observation is not None  # cases finished
        differences_from_best, sigmas = likelihood.deviations(best)
        values = np.array(self.values)
        shared = np.linalg.inv(self.observation.covariance)
        differences = values - self.observation.values
        nearest = np.argsort(np.einsum("ij,jk,ik->i", differences, shared, differences), kind="stable")[:BEST_CASES]
        for index, label in enumerate(self.observation.labels):
            if label.unit:
                computed = label.feature_value(float(np.median(values[nearest, index])))
                measured = label.feature_value(float(self.observation.values[index]))
                channel = self.observation.signals[label.signal].angular.signal.channel
                sigma = float(differences_from_best[index] / sigmas[index])
                yield FeatureFit(channel, label.kind, label.text, label.unit, measured, computed, sigma)

    def _signal_treatments(self, posterior: emulator.Posterior) -> Iterator[SignalTreatment]:
        """Yield the treatment of each signal."""
        assert self.observation is not None  # cases finished
        for index, observed_signal in enumerate(self.observation.signals):
            signal, angular = observed_signal.angular.signal, observed_signal.angular
            low, median, high = posterior.quantiles(len(self.identify.over) + index, (0.025, 0.5, 0.975))
            noise = [float(noise_share) for noise_share in _noise_of_fractions(np.array([median, low, high]))]
            samples = float(len(angular.angle) - 1) * features.TURN / float(angular.angle[-1] - angular.angle[0])
            yield SignalTreatment(
                signal.file,
                signal.channel,
                len(observed_signal.revolutions),
                samples,
                observed_signal.orders,
                float(observed_signal.angle(self.history)),
                angular.speed,
                (noise[0], noise[1], noise[2]),
            )

    def _stored_sample(self, posterior: emulator.Posterior) -> dict[str, np.ndarray]:
        """Return the sample in SI, or only its most likely rows if there are too many."""
        largest = np.sort(np.argsort(-posterior.weights, kind="stable")[:STORED_ROWS])
        columns = {
            path: np.array([choice.value_at(fraction) for fraction in posterior.points[largest, column].tolist()])
            for column, (path, choice) in enumerate(self.identify.over.items())
        }
        return columns | {"weight": posterior.weights[largest] / posterior.weights[largest].sum()}


def _noise_of_fractions(fractions: np.ndarray) -> np.ndarray:
    """Return noise shares from parts, 0 to 1, of their range."""
    low, high = NOISE
    noise: np.ndarray = low * (high / low) ** fractions
    return noise


@contextlib.contextmanager
def _reproducible() -> Iterator[None]:
    """Compute on one thread, so that bits do not depend on the number of threads, and without kernel warnings."""
    from sklearn.exceptions import ConvergenceWarning
    from threadpoolctl import threadpool_limits

    with threadpool_limits(1), warnings.catch_warnings():
        warnings.simplefilter("ignore", ConvergenceWarning)
        yield
