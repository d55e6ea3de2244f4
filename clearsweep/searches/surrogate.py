"""Points at which a surrogate model of the cases near the best one predicts better results.

The model is a cubic radial basis function.  Points are chosen by expected value and by distance from known ones, as in
the local stochastic method of Regis and Shoemaker (2007, INFORMS J. Comput. 19, 497).  The margin of each limit has a
model of its own (Regis 2014, Eng. Optim. 46, 218).
"""

import numpy as np

MAX_NEIGHBOURS = 150  # most cases in the model; few enough for single-threaded linear algebra
MIN_CASES = (2, 2)  # fewest cases in the model: a constant, and cases per key
CANDIDATE_COUNT = 400  # candidates for each chosen point
#: Weights of the rank by predicted value, used in turn; the rest is the rank by distance.
WEIGHTS = (0.5, 0.8, 0.95, 1.0)
LARGEST_STEP, HALVINGS = 0.2, 7  # standard deviations of candidates around good cases, in parts of the ranges
CHANGE_PROBABILITY = 0.6  # probability that a candidate changes a key
CLIP_PERCENTILE = 75.0  # percentile at which the objective is clipped; higher values would make the model oscillate
INFEASIBILITY_PENALTY = 10.0  # penalty for exceeded limits, in ranges of the objective


def better_points(
    known_points: np.ndarray, objective: np.ndarray, margins: np.ndarray, count: int, rng: np.random.Generator
) -> np.ndarray:
    """Return points (count, keys) of the unit cube, (0, keys) if there are too few cases.

    known_points : (n, keys) in order of merit
    objective : (n,) to be minimised
    margins : (n, limits) to their limits, negative beyond a limit
    """
    from scipy.interpolate import RBFInterpolator
    from scipy.spatial.distance import cdist

    keys = known_points.shape[1]
    neighbours = np.sort(
        np.argsort(np.linalg.norm(known_points - known_points[0], axis=1), kind="stable")[:MAX_NEIGHBOURS]
    )
    known_points, objective = (
        known_points[neighbours],
        np.minimum(objective[neighbours], np.percentile(objective[neighbours], CLIP_PERCENTILE)),
    )
    if len(known_points) < MIN_CASES[0] + MIN_CASES[1] * keys:
        return np.empty((0, keys))
    scaled = (objective - objective.min()) / max(np.ptp(objective), np.finfo(float).tiny)
    try:
        model = RBFInterpolator(
            known_points, np.column_stack([scaled, margins[neighbours].clip(-1.0, 1.0)]), kernel="cubic"
        )
    except np.linalg.LinAlgError:  # all cases have the same value of a key
        return np.empty((0, keys))
    existing = known_points
    for position in range(count):
        weight = WEIGHTS[position % len(WEIGHTS)]
        candidates = (
            rng.random((CANDIDATE_COUNT, keys)) if weight == WEIGHTS[0] else _candidates_near(known_points, rng)
        )
        expected = model(candidates)
        exceeded = np.maximum(-expected[:, 1:], 0.0).sum(axis=1)
        merit = expected[:, 0] + (exceeded > 0.0) * (INFEASIBILITY_PENALTY + exceeded)
        distances = cdist(candidates, existing).min(axis=1)
        selected = np.argmin(weight * _ranks(merit) + (1.0 - weight) * _ranks(-distances))
        existing = np.vstack([existing, candidates[selected]])
    return existing[len(known_points) :]


def _candidates_near(known_points: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Return candidates around cases in order of merit: half around the first, a quarter around the next."""
    centres = known_points[np.minimum(rng.geometric(0.5, CANDIDATE_COUNT), len(known_points)) - 1]
    steps = LARGEST_STEP * 0.5 ** rng.integers(HALVINGS, size=(CANDIDATE_COUNT, 1))
    is_changed = rng.random(centres.shape) < CHANGE_PROBABILITY
    is_changed[np.arange(CANDIDATE_COUNT), rng.integers(centres.shape[1], size=CANDIDATE_COUNT)] = True
    candidates: np.ndarray = (centres + steps * is_changed * rng.standard_normal(centres.shape)).clip(0.0, 1.0)
    return candidates


def _ranks(values: np.ndarray) -> np.ndarray:
    """Return the ranks of values from 0 on, lowest first."""
    return np.argsort(np.argsort(values, kind="stable"), kind="stable")
