"""Emulator of case features: Gaussian processes trained on finished cases, and a posterior from measured features.

Features are first projected on a few principal directions, each with its own process
(Higdon et al. 2008, J. Am. Stat. Assoc. 103, 570, sections 2.1 and 2.2).  The residual of the projection is part of
the covariance of the measured features, as is the scatter of non-periodic motion.
"""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from sklearn.gaussian_process import kernels  # an optional dependency, imported when a process is fitted

MAX_DIRECTIONS = 14
MIN_VARIANCE_SHARE = 0.995  # least share of the features' variance in the directions
LENGTH_BOUNDS = (0.05, 30.0)  # correlation lengths of the processes, in parts of the ranges
NOISE_BOUNDS = (1e-4, 2.0)  # share of a direction's variance that no input explains
JITTER = 1e-8  # variance added to keep a covariance positive definite
MAX_ITERATIONS = 25  # iterations of the search for the lengths of a process
CENTRE_COUNT = 512  # degrees of freedom of the proposal distribution
UNIFORM_SHARE = 0.1  # share of the points spread over all ranges
RELATIVE_WIDTH = 0.5  # standard deviation at a centre over that of all points
MIN_EFFECTIVE_SIZE = 200.0  # least effective number of points of a draw; weights are flattened until it is reached


class Emulator(NamedTuple):
    """Features over inputs in the unit cube."""

    mean: np.ndarray  # (features,)
    scale: np.ndarray  # (features,)
    basis: np.ndarray  # (directions, features), of (features - mean) / scale
    processes: tuple[Any, ...]  # one for each direction
    coefficient_deviations: np.ndarray  # (directions,) standard deviation of each
    residual_covariance: np.ndarray  # (features, features) scaled covariance of the residual

    def predict(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return means (n, features) of the features at points, and variances (n, directions) in scaled units."""
        predictions = [predict_process(process, points) for process in self.processes]
        coefficients = np.array([mean for mean, _ in predictions]).T * self.coefficient_deviations
        variances = np.array([deviation for _, deviation in predictions]).T ** 2 * self.coefficient_deviations**2
        return self.mean + self.scale * (coefficients @ self.basis), variances

    @property
    def kernels(self) -> "list[kernels.Kernel]":
        """Return the trained kernels: lengths and noise of the processes."""
        return [process.kernel_ for process in self.processes]


def fit(points: np.ndarray, values: np.ndarray, trained_kernels: "list[kernels.Kernel] | None" = None) -> Emulator:
    """Return an emulator of features (n, features) over points (n, inputs).

    trained_kernels : kernels of an emulator of fewer points, which are kept
    """
    mean, scale = values.mean(axis=0), np.maximum(values.std(axis=0), 1e-9)
    standardised = (values - mean) / scale
    _, singular_values, directions = np.linalg.svd(standardised, full_matrices=False)
    count = min(
        int(np.searchsorted(np.cumsum(singular_values**2) / (singular_values**2).sum(), MIN_VARIANCE_SHARE)) + 1,
        MAX_DIRECTIONS,
    )
    count = len(trained_kernels) if trained_kernels else count
    basis = directions[:count] * np.where(directions[:count].sum(axis=1) < 0.0, -1.0, 1.0)[:, None]
    coefficients = standardised @ basis.T
    residual = standardised - coefficients @ basis
    deviations = np.maximum(coefficients.std(axis=0), 1e-9)
    kernels_by_direction = trained_kernels or [None] * count
    processes = tuple(
        _fit_process(points, coefficients[:, k] / deviations[k], kernels_by_direction[k]) for k in range(count)
    )
    return Emulator(mean, scale, basis, processes, deviations, residual.T @ residual / len(points))


def _fit_process(points: np.ndarray, values: np.ndarray, kernel: "kernels.Kernel | None") -> Any:
    """Return a Gaussian process of values (n,), with a given or a fitted kernel."""
    from scipy.optimize import minimize
    from sklearn.gaussian_process import GaussianProcessRegressor
    from sklearn.gaussian_process.kernels import Matern, WhiteKernel

    def search(_target: Callable, start: np.ndarray, bounds: np.ndarray) -> tuple[np.ndarray, float]:
        target, options = Evidence.of(points, values).negative_log_likelihood, {"maxiter": MAX_ITERATIONS}
        best = minimize(target, start, method="L-BFGS-B", jac=True, bounds=bounds, options=options)
        return best.x, best.fun

    if kernel is None:
        lengths = np.full(points.shape[1], 0.7)
        kernel = 1.0 * Matern(lengths, LENGTH_BOUNDS, nu=2.5) + WhiteKernel(0.05, NOISE_BOUNDS)
        return GaussianProcessRegressor(kernel, optimizer=search, alpha=JITTER).fit(points, values)
    return GaussianProcessRegressor(kernel, optimizer=None, alpha=JITTER).fit(points, values)


def predict_process(process: Any, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return means and standard deviations (n,) of a process at points (n, inputs).

    Bit-identical to `predict` of scikit-learn, in 0.8 of its time.
    """
    from scipy.linalg import solve_triangular
    from scipy.spatial.distance import cdist

    size, lengths = process.kernel_.k1.k1.constant_value, process.kernel_.k1.k2.length_scale
    distances = cdist(points / lengths, process.X_train_ / lengths)
    distances *= np.sqrt(5.0)
    covariance = (1.0 + distances + distances**2 / 3.0) * np.exp(-distances)
    covariance *= size
    solved = solve_triangular(process.L_, covariance.T, lower=True, check_finite=False)
    variance = size + process.kernel_.k2.noise_level - np.einsum("ij,ji->i", solved.T, solved)
    return covariance @ process.alpha_, np.sqrt(np.maximum(variance, 0.0))


class Evidence(NamedTuple):
    """Likelihood of values by the logarithms of a kernel's size, lengths and noise: Matern 5/2 plus white noise.

    Same as scikit-learn's, which is five times slower because it forms an array (n, n, inputs) of derivatives.
    Rasmussen and Williams 2006, Gaussian Processes for Machine Learning, equations 2.30, 4.17 and 5.9.
    """

    squares: np.ndarray  # (inputs, n * n) of differences of points
    values: np.ndarray  # (n,)

    @classmethod
    def of(cls, points: np.ndarray, values: np.ndarray) -> "Evidence":
        """Return the evidence of values (n,) at points (n, inputs)."""
        squares = [np.subtract.outer(column, column).ravel() ** 2 for column in points.T]
        return cls(np.array(squares), values)

    def negative_log_likelihood(self, logarithms: np.ndarray) -> tuple[float, np.ndarray]:
        """Return the negative logarithm of the likelihood and its derivatives."""
        from scipy.linalg import lapack

        size, noise = np.exp(logarithms[0]), np.exp(logarithms[-1])
        inverse_squares, count = np.exp(-2.0 * logarithms[1:-1]), len(self.values)
        distances = np.sqrt(5.0 * (inverse_squares @ self.squares))
        decay = size * np.exp(-distances)
        kernel = (decay * (1.0 + distances + distances**2 / 3.0)).reshape(count, count)
        root, failed = lapack.dpotrf(kernel + (noise + JITTER) * np.eye(count), lower=1)
        if failed:
            return np.inf, np.zeros(len(logarithms))
        weights, _ = lapack.dpotrs(root, self.values, lower=1)
        lower = np.tril(lapack.dpotri(root, lower=1)[0])
        gradient_weights = np.outer(weights, weights) - lower - np.tril(lower, -1).T
        projected = (decay * (1.0 + distances) * gradient_weights.ravel()) @ self.squares.T
        slopes = [
            np.vdot(gradient_weights, kernel),
            *(5.0 / 3.0 * inverse_squares * projected),
            noise * np.trace(gradient_weights),
        ]
        likelihood = -0.5 * self.values @ weights - np.log(np.diag(root)).sum() - 0.5 * count * np.log(2.0 * np.pi)
        return -float(likelihood), -0.5 * np.array(slopes)


class LikelihoodModel(NamedTuple):
    """Likelihood of the measured features at points of an emulator."""

    emulator: Emulator
    measured: np.ndarray  # (features,)
    covariance: np.ndarray  # (features, features), without the emulator's part
    inflation: float = 1.0  # factor on all variances

    def distance(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return squared distances (n,) of points from the measurement, and logarithms of the covariance volumes.

        The covariance is a low-rank part from the processes plus a common part (Woodbury identity).
        """
        means, variances = self.emulator.predict(points)
        scale, basis = self.emulator.scale, self.emulator.basis
        covariance = self.covariance / np.outer(scale, scale) + self.emulator.residual_covariance
        covariance[np.diag_indices_from(covariance)] += 1e-9
        deviations = (self.measured - means) / scale
        inverse = np.linalg.inv(covariance)
        capacitance = basis @ inverse @ basis.T + np.eye(len(basis)) / np.maximum(variances, 1e-12)[:, None, :]
        projected = deviations @ inverse @ basis.T
        solved = np.linalg.solve(capacitance, projected[:, :, None])[:, :, 0]
        squares = np.einsum("ij,jk,ik->i", deviations, inverse, deviations) - (projected * solved).sum(axis=1)
        volumes = np.linalg.slogdet(covariance)[1] + np.log(np.maximum(variances, 1e-12)).sum(axis=1)
        return squares, volumes + np.linalg.slogdet(capacitance)[1]

    def log_likelihood(self, squares: np.ndarray, volumes: np.ndarray) -> np.ndarray:
        """Return the log-likelihoods of points from the results of `distance`, up to a constant."""
        likelihood: np.ndarray = -0.5 * (squares / self.inflation + volumes)
        return likelihood

    def deviations(self, point: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the excess of each measured feature over that at a point (inputs,), and the standard deviations."""
        means, variances = self.emulator.predict(point[None])
        scale, basis = self.emulator.scale, self.emulator.basis
        emulator_variance = (
            (variances[0][:, None] * basis**2).sum(axis=0) + np.diag(self.emulator.residual_covariance)
        ) * scale**2
        return self.measured - means[0], np.sqrt(emulator_variance + np.diag(self.covariance))


class Posterior(NamedTuple):
    """A weighted sample of the unit cube."""

    points: np.ndarray  # (n, inputs)
    weights: np.ndarray  # (n,), 1 in all
    squares: np.ndarray  # (n,) squared distances from the measurement, in standard deviations that are not inflated
    volumes: np.ndarray  # (n,) logarithms

    def quantiles(self, column: int, probabilities: tuple[float, ...]) -> list[float]:
        """Return quantiles of an input."""
        order = np.argsort(self.points[:, column], kind="stable")
        cumulated = np.cumsum(self.weights[order]) - 0.5 * self.weights[order]
        return [float(value) for value in np.interp(probabilities, cumulated, self.points[order, column])]


def sample(
    likelihood: LikelihoodModel, inputs: int, rng: "np.random.Generator", size: int, iterations: int
) -> Posterior:
    """Return a weighted sample of the posterior on the unit cube, with a uniform prior.

    Each round draws near the likely points of the previous round (adaptive importance sampling,
    Cappe et al. 2004, J. Comput. Graph. Stat. 13, 907); weights are likelihood over proposal density.
    """
    from scipy.spatial.distance import cdist
    from scipy.stats import qmc

    points = qmc.Sobol(inputs, seed=rng).random_base2(int(np.ceil(np.log2(size))))
    log_weights = likelihood.log_likelihood(*likelihood.distance(points))
    for _ in range(iterations):
        probabilities = _flattened(log_weights)
        centres = points[rng.choice(len(points), CENTRE_COUNT, p=probabilities)]
        mean = probabilities @ points
        covariance = np.einsum("i,ij,ik->jk", probabilities, points - mean, points - mean)
        root = RELATIVE_WIDTH * np.linalg.cholesky(covariance + 1e-6 * np.eye(inputs))
        points = _proposed_points(centres, root, rng, size)
        whitened = np.linalg.inv(root)
        squared_distances = cdist(points @ whitened.T, centres @ whitened.T, "sqeuclidean")
        normalisation = (2.0 * np.pi) ** (inputs / 2.0) * abs(np.prod(np.diag(root)))
        density = UNIFORM_SHARE + (1.0 - UNIFORM_SHARE) * np.exp(-0.5 * squared_distances).mean(axis=1) / normalisation
        squares, volumes = likelihood.distance(points)
        log_weights = likelihood.log_likelihood(squares, volumes) - np.log(density)
    weights = np.exp(log_weights - log_weights.max())
    return Posterior(points, weights / weights.sum(), squares, volumes)


def _proposed_points(centres: np.ndarray, root: np.ndarray, rng: "np.random.Generator", size: int) -> np.ndarray:
    """Return points of the unit cube: some uniform, the others around the centres; points outside are drawn again."""
    points = np.empty((0, centres.shape[1]))
    while len(points) < size:
        near_centres = centres[rng.integers(len(centres), size=size)] + rng.standard_normal((size, len(root))) @ root.T
        uniform = rng.random(near_centres.shape)
        proposed = np.where(rng.random((size, 1)) < UNIFORM_SHARE, uniform, near_centres)
        points = np.concatenate([points, proposed[((proposed >= 0.0) & (proposed <= 1.0)).all(axis=1)]])
    return points[:size]


def _flattened(log_weights: np.ndarray) -> np.ndarray:
    """Return weights, flattened by halving their logarithms until no few points dominate."""
    power = 1.0
    while True:
        weights: np.ndarray = np.exp(power * (log_weights - log_weights.max()))
        weights /= weights.sum()
        if 1.0 / (weights**2).sum() >= min(MIN_EFFECTIVE_SIZE, 0.5 * len(log_weights)):
            return weights
        power *= 0.5


def flattened(posterior: Posterior) -> np.ndarray:
    """Return flattened weights (n,) of a posterior: at least their square roots."""
    with np.errstate(divide="ignore"):
        return _flattened(0.5 * np.log(posterior.weights))
