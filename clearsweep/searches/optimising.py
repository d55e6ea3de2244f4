"""Searches for the best cases, round by round: half of them come from an Optuna sampler.

The other half come from a surrogate model near the best case, or vary the cases of a front.
The sampler is rebuilt in every round from the finished cases and seeded by the round: the same
results lead to the same cases, regardless of interruptions and of the number of workers.
"""

import math
from collections.abc import Iterator
from importlib import util
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from .. import store
from ..grid import Grid
from ..grid.sections.optimise import AMONG, ROUND_SIZE, WHOLE, Choice, interval_columns
from ..language.errors import InputError
from . import surrogate
from .adaptive import Point

if TYPE_CHECKING:
    import optuna  # an optional dependency, imported when a round is requested

MODEL_SHARE = 0.5  # share of a round from the surrogate model or from variations of the front
MIN_FRONT_CASES = 3  # varied cases of a front
FIRST_STEP = 0.32  # standard deviation over the range after one case; falls with the square root of cases
CHANGE_PROBABILITY = 0.6  # probability that a variation changes a key by an own step
CROSSOVER_PROBABILITY = 0.3  # probability that it takes a value of another case
MAX_ATTEMPTS = 4  # attempts to get a round with a new case
FAILED_VIOLATION = 1e3  # violation assigned to a failed case: larger than any margin


class BestCase(NamedTuple):
    """One of the best cases, in SI."""

    case_id: str
    point: Point
    values: dict[str, float]  # by objective
    intervals: dict[str, tuple[float, float]]  # 95 % interval, by objective, if any
    margin: float | None  # margin to the limits, or None without limits
    limiting: str | None  # columns whose limits are not met, or with the nearest limit
    feasible: bool


class OptimisationResult(NamedTuple):
    """Result of an optimisation."""

    best: tuple[BestCase, ...]  # the best case or the front; if no case meets the limits, the nearest one
    start: BestCase | None  # the case written in the grid
    looked_at: int
    feasible: int
    alike: int | None  # feasible cases with an interval that overlaps that of the best, or None


class Optimisation:
    """One optimisation, round by round."""

    def __init__(self, grid: Grid):
        assert grid.optimise is not None  # only for grids that have the section
        if util.find_spec("optuna") is None:
            raise InputError("optimise: needs Optuna, which is not installed; run `pip install clearsweep[optimise]`")
        self.optimise = grid.optimise
        self.trials: list[_Trial] = []
        self.seen_points: set[tuple[Any, ...]] = set()

    def learn(self, grid: Grid, first_index: int, results: store.CaseResults) -> None:
        """Record the results of a grid's cases from the index `first_index` on."""
        names = [column for column, _ in self.optimise.objectives]
        for index in range(first_index, len(grid)):
            k = index - first_index
            point, failed = grid.point(index), results.status[k] != "ok"
            values = {name: float(results.columns[name][k]) for name in names}
            if not failed and not all(map(math.isfinite, values.values())):
                null = [name for name, value in values.items() if not math.isfinite(value)]
                raise InputError(
                    f"optimise: {', '.join(null)} is null in case {grid.case_id(index)}, so that cases cannot be "
                    "compared; choose another objective, or a `figures` expression that is never null"
                )
            intervals = {name: _interval(results.columns, name, k) for name in names}
            margins = {name: float(margin[k]) for name, margin in results.margins.items()}
            self.seen_points.add(tuple(point.values()))
            trial = _Trial(
                grid.case_id(index),
                point,
                values,
                intervals,
                margins,
                results.unmet[k],
                float(results.margin[k]),
                failed=failed,
            )
            self.trials.append(trial)

    def next_points(self) -> list[Point]:
        """Return the points of the next cases."""
        remaining = self.optimise.cases - len(self.trials)
        points: dict[tuple[Any, ...], Point] = {}
        for attempt in range(MAX_ATTEMPTS if remaining > 0 else 0):
            for point in self._proposed_points(attempt, min(ROUND_SIZE, remaining)):
                key = tuple(point.values())
                if key not in self.seen_points and len(points) < remaining:
                    points.setdefault(key, point)
            if points:
                break
        return list(points.values())

    def result(self) -> OptimisationResult:
        """Return the final result."""
        feasible = [trial for trial in self.trials if trial.violation == 0.0]
        if feasible:
            best = list(_front(feasible, self.optimise.objectives))
        else:
            best = sorted(self.trials, key=lambda trial: (trial.violation, trial.case_id))[:1]
        start_values = tuple(self.optimise.start.values())
        start = next(
            (trial.best() for trial in self.trials if start_values and tuple(trial.point.values()) == start_values),
            None,
        )
        alike = self._indistinguishable_from(best[0], feasible) if len(self.optimise.objectives) == 1 else None
        return OptimisationResult(tuple(trial.best() for trial in best), start, len(self.trials), len(feasible), alike)

    def _indistinguishable_from(self, best: "_Trial", feasible: "list[_Trial]") -> int | None:
        """Return how many other feasible cases are indistinguishable from the best, or None if it has no interval."""
        ((name, _),) = self.optimise.objectives
        low, high = best.intervals[name]
        if not feasible or not math.isfinite(low + high):
            return None
        return sum(trial.intervals[name][0] <= high and trial.intervals[name][1] >= low for trial in feasible) - 1

    def _proposed_points(self, attempt: int, count: int) -> Iterator[Point]:
        """Yield points from a sampler that knows all trials."""
        import optuna

        optuna.logging.set_verbosity(optuna.logging.WARNING)
        seed = int(np.random.SeedSequence([self.optimise.seed, len(self.trials), attempt]).generate_state(1)[0])
        sampler = optuna.samplers.TPESampler(seed=seed, multivariate=True, n_ei_candidates=48, constant_liar=True)
        signs = [-1.0 if is_maximised else 1.0 for _, is_maximised in self.optimise.objectives]
        study = optuna.create_study(directions=["minimize"] * len(signs), sampler=sampler)
        distributions = {path: _distribution(choice) for path, choice in self.optimise.over.items()}
        succeeded = [trial for trial in self.trials if not trial.failed]
        worst = {
            name: max((sign * trial.values[name] for trial in succeeded), default=0.0)
            for name, sign in self._signed_objectives()
        }
        for trial in self.trials:
            values = [
                worst[name] if trial.failed else sign * trial.values[name] for name, sign in self._signed_objectives()
            ]
            study.add_trial(
                optuna.trial.create_trial(
                    params=trial.point,
                    distributions=distributions,
                    values=values,
                    constraints={"limits": trial.violation},
                )
            )
        propose = self._evolved_points if len(signs) > 1 else self._surrogate_points
        points = propose(int(MODEL_SHARE * count), np.random.default_rng(seed))
        for _ in range(count - len(points)):
            proposal = study.ask(distributions)
            yield {path: proposal.params[path] for path in self.optimise.over}
        yield from points

    def _surrogate_points(self, count: int, rng: np.random.Generator) -> list[Point]:
        """Return points where a surrogate model of the objective predicts better cases; a sampler stops too early.

        They have the categories of the best case; the model uses only cases with the same categories.
        """
        ((name, sign),) = self._signed_objectives()
        trials = sorted(self.trials, key=lambda trial: trial.merit(name, sign))
        best = trials[0]
        choices = {path: choice for path, choice in self.optimise.over.items() if choice.kind != AMONG}
        fixed = {path: value for path, value in best.point.items() if path not in choices}
        if best.failed or not choices:
            return []
        trials = [trial for trial in trials if fixed.items() <= trial.point.items()]
        fractions = np.array(
            [[choice.fraction_of(trial.point[path]) for path, choice in choices.items()] for trial in trials]
        )
        objective = np.array([sign * trial.values[name] for trial in trials])
        objective[np.isnan(objective)] = np.nanmax(objective)  # failed cases
        margins = np.array([[-1.0 if trial.failed else trial.margins[key] for key in best.margins] for trial in trials])
        points = surrogate.better_points(fractions, objective, np.nan_to_num(margins, nan=-1.0), count, rng)
        proposals = [
            {path: _clipped_value(choices[path], fraction) for path, fraction in zip(choices, row, strict=True)}
            for row in points.tolist()
        ]
        return [{path: (fixed | point)[path] for path in self.optimise.over} for point in proposals]

    def _evolved_points(self, count: int, rng: np.random.Generator) -> list[Point]:
        """Return points near the front, or [] if it has few cases; a sampler by itself leaves gaps.

        They come from differential evolution (Storn and Price 1997, J. Global Optim. 11, 341).  Cases next to wide
        gaps are varied more often, as in NSGA-II (Deb et al. 2002, IEEE Trans. Evol. Comput. 6, 182).
        """
        front = list(_front([trial for trial in self.trials if trial.violation == 0.0], self.optimise.objectives))
        if len(front) < MIN_FRONT_CASES:
            return []
        choices = self.optimise.over
        fractions = np.array(
            [[choice.fraction_of(trial.point[path]) for path, choice in choices.items()] for trial in front]
        )
        values = np.array([list(trial.values.values()) for trial in front])
        distances = np.linalg.norm(
            np.diff(values / np.maximum(np.ptp(values, axis=0), np.finfo(float).tiny), axis=0), axis=1
        )
        gaps = np.maximum(np.append(distances[0], distances), np.append(distances, distances[-1]))
        weights = 0.5 * gaps / gaps.sum() + 0.5 / len(front)
        step = FIRST_STEP / math.sqrt(len(self.trials))
        is_categorical = np.array([choice.kind == AMONG for choice in choices.values()])
        points = []
        for _ in range(count):
            parent, first, second = fractions[[rng.choice(len(front), p=weights), *rng.integers(len(front), size=2)]]
            is_changed = rng.random(len(parent)) < CHANGE_PROBABILITY
            child = (
                parent
                + rng.uniform(-0.5, 1.0) * (first - second)
                + step * is_changed * rng.standard_normal(len(parent))
            )
            child = np.where(
                is_categorical, np.where(rng.random(len(parent)) < CROSSOVER_PROBABILITY, first, parent), child
            ).clip(0.0, 1.0)
            points.append(
                {
                    path: _clipped_value(choice, fraction)
                    for (path, choice), fraction in zip(choices.items(), child.tolist(), strict=True)
                }
            )
        return points

    def _signed_objectives(self) -> list[tuple[str, float]]:
        return [(name, -1.0 if is_maximised else 1.0) for name, is_maximised in self.optimise.objectives]


class _Trial(NamedTuple):
    case_id: str
    point: Point
    values: dict[str, float]
    intervals: dict[str, tuple[float, float]]  # by objective, NaN if missing
    margins: dict[str, float]  # by limited column; minus infinity if unknown
    unmet: str  # columns whose limits are exceeded or undecided, comma separated
    margin: float  # of the case, NaN for null
    failed: bool

    @property
    def violation(self) -> float:
        """Return the total violation of the limits, 0 if all are met."""
        if self.failed:
            return FAILED_VIOLATION
        excesses = [
            FAILED_VIOLATION if not math.isfinite(self.margins[name]) else -self.margins[name]
            for name in self.unmet_columns
        ]
        return sum(max(violation, np.finfo(float).tiny) for violation in excesses)

    def merit(self, name: str, sign: float) -> tuple[float, float, str]:
        """Return the sort key of a trial: violation of limits first, then an objective; smaller is better."""
        return self.violation, math.inf if self.failed else sign * self.values[name], self.case_id

    @property
    def unmet_columns(self) -> list[str]:
        """Return the columns whose limits are not met."""
        return [name for name in self.unmet.split(",") if name]

    def best(self) -> BestCase:
        """Return the trial as a result."""
        finite = {name: margin for name, margin in self.margins.items() if math.isfinite(margin)}
        nearest = min(finite, key=lambda name: finite[name], default=None)
        values = {name: value for name, value in self.values.items() if math.isfinite(value)}
        intervals = {name: interval for name, interval in self.intervals.items() if math.isfinite(sum(interval))}
        margin = self.margin if math.isfinite(self.margin) else None
        limiting = self.unmet or nearest
        return BestCase(self.case_id, self.point, values, intervals, margin, limiting, self.violation == 0.0)


def _interval(columns: dict[str, np.ndarray], name: str, index: int) -> tuple[float, float]:
    """Return the 95 % interval of a column for the case at an index, or NaN if it has none."""
    low, high = (float(columns[column][index]) if column in columns else math.nan for column in interval_columns(name))
    return low, high


def _front(trials: list[_Trial], objectives: tuple[tuple[str, bool], ...]) -> Iterator[_Trial]:
    """Yield the non-dominated trials in order of the first objective; for one objective, the best."""
    signed = [(name, -1.0 if is_maximised else 1.0) for name, is_maximised in objectives]
    table = np.array([[sign * trial.values[name] for name, sign in signed] for trial in trials])
    order = sorted(range(len(trials)), key=lambda k: (*table[k].tolist(), trials[k].case_id))
    members: list[int] = []
    for k in order:
        if not any((table[member] <= table[k]).all() for member in members):
            members.append(k)
            yield trials[k]


def _clipped_value(choice: Choice, fraction: float) -> Any:
    """Return the value at a share (0 to 1) of the range of a choice, clipped to the ends of the range."""
    value = choice.value_at(fraction)
    return value if choice.kind == AMONG else min(max(value, choice.values[0]), choice.values[1])


def _distribution(choice: Choice) -> "optuna.distributions.BaseDistribution":
    """Return a choice as an Optuna distribution."""
    from optuna import distributions

    if choice.kind == AMONG:
        return distributions.CategoricalDistribution(list(choice.values))
    if choice.kind == WHOLE:
        return distributions.IntDistribution(choice.values[0], choice.values[1])
    low, high = choice.values
    return distributions.FloatDistribution(low, high, log=choice.is_logarithmic)
