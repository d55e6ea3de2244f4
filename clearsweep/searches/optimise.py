"""`optimise`: its section, which has the values to vary and the columns to minimise or maximise, and its rounds.

Half of the cases come from an Optuna sampler.  The other half come from a surrogate model near the best case, or vary
the cases of a front.  The sampler is rebuilt in every round from the finished cases and seeded by the round: the same
results lead to the same cases, regardless of interruptions and of the number of workers.
"""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

import numpy as np

from ..answers.verdict import Limit, units_of
from ..answers.words import case_margin_text
from ..contracts.layout import Column
from ..contracts.search import CaseResults, Found, Point, SearchTable
from ..grid import Grid, sections
from ..grid.keys import Number, Word
from ..grid.keys.library_names import name_path
from ..grid.sections.fits import naming_of
from ..grid.written import WrittenValue
from ..language.errors import InputError, did_you_mean, quoted
from .seeking import AMONG, MISSING_OVER_TEXT, ROUND_SIZE, SEED_KEY, WHOLE, Choice, SearchOver

if TYPE_CHECKING:
    import optuna  # an optional dependency, imported when a round is requested


MODEL_SHARE = 0.5  # share of a round from the surrogate model or from variations of the front
MIN_FRONT_CASES = 3  # varied cases of a front
FIRST_STEP = 0.32  # standard deviation over the range after one case; falls with the square root of cases
CHANGE_PROBABILITY = 0.6  # probability that a variation, or a candidate of the model, changes a key
CROSSOVER_PROBABILITY = 0.3  # probability that it takes a value of another case
MAX_ATTEMPTS = 4  # attempts to get a round with a new case
FAILED_VIOLATION = 1e3  # violation assigned to a failed case: larger than any margin
MAX_NEIGHBOURS = 150  # most cases in the model; few enough for single-threaded linear algebra
MIN_MODEL_CASES = (2, 2)  # fewest cases in the model: a constant, and cases per key
CANDIDATE_COUNT = 400  # candidates for each chosen point
#: Weights of the rank by predicted value, used in turn; the rest is the rank by distance.
WEIGHTS = (0.5, 0.8, 0.95, 1.0)
LARGEST_STEP, HALVINGS = 0.2, 7  # standard deviations of candidates around good cases, in parts of the ranges
CLIP_PERCENTILE = 75.0  # percentile at which the objective is clipped; higher values would make the model oscillate
INFEASIBILITY_PENALTY = 10.0  # penalty for exceeded limits, in ranges of the objective


def interval_columns(column: str) -> tuple[str, str]:
    """Return the names of the columns with the ends of a column's 95 % interval, which few columns have."""
    return f"{column}_low", f"{column}_high"


class BestCase(NamedTuple):
    """One of the best cases, in SI."""

    case_id: str
    point: Point
    values: dict[str, float]  # by objective
    intervals: dict[str, tuple[float, float]]  # 95 % interval, by objective, if any
    margin: float | None  # margin to the limits, or None without limits
    limiting: str | None  # columns whose limits are not met, or with the nearest limit
    feasible: bool


@dataclass(frozen=True)
class OptimiseFound(Found):
    """Result of an optimisation."""

    objectives: tuple[str, ...]
    best: tuple[BestCase, ...]  # the best case or the front; if no case meets the limits, the nearest one
    start: BestCase | None  # the case written in the grid
    looked_at: int
    feasible: int
    alike: int | None  # feasible cases with an interval that overlaps that of the best, or None

    def table(self, axes: Sequence[Column], units: Mapping[str, str]) -> SearchTable:
        """Return a row for each of the best cases."""
        best, names = self.best, self.objectives
        columns = [Column("case_id", "", "identity of the case", "text")]
        columns += [axis._replace(description="its value") for axis in axes]
        columns += [Column(name, units[name], "objective") for name in names]
        columns += [
            Column("margin", "1", "smallest margin of its limits; null without limits"),
            Column("limiting", "", "the columns whose limits are exceeded, or the one nearest to its limit", "text"),
        ]
        values: list[list[Any]] = [[case.case_id for case in best]]
        values += [[case.point[axis.name] for case in best] for axis in axes]
        values += [[case.values.get(name) for case in best] for name in names]
        values += [[case.margin for case in best], [case.limiting for case in best]]
        return SearchTable(columns, values)

    def facts(self, catalogue: Any, record: Mapping[str, Any], judged: Any) -> dict[str, Any]:
        """Return the best cases and the one written in the grid, with their margins in words."""
        best = [_facts_of_case(case, judged.limits) for case in self.best]
        start = _facts_of_case(self.start, judged.limits) if self.start else None
        counts = {"looked_at": self.looked_at, "feasible": self.feasible, "alike": self.alike}
        units = units_of(record)
        return {
            "best": best,
            "start": start,
            **counts,
            "units": {name: units.get(name, "1") for name in self.best[0].values},
        }


def _facts_of_case(case: BestCase, limits: Sequence[Limit]) -> dict[str, Any]:
    """Return a case with its margin in words; without limits, the words are None."""
    if case.margin is None:
        return case._asdict() | {"margin_words": None}
    exceeded = case.limiting or "" if not case.feasible else ""
    return case._asdict() | {"margin_words": case_margin_text(case.margin, limits, exceeded)}


class Optimisation:
    """One optimisation, round by round."""

    def __init__(self, optimise: "Optimise"):
        self.optimise = optimise
        self.trials: list[_Trial] = []
        self.seen_points: set[tuple[Any, ...]] = set()

    def record(self, grid: Grid, first_index: int, results: CaseResults) -> None:
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

    def ask(self) -> list[Point]:
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

    def result(self) -> OptimiseFound:
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
        names = tuple(name for name, _ in self.optimise.objectives)
        return OptimiseFound(
            names, tuple(trial.best() for trial in best), start, len(self.trials), len(feasible), alike
        )

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
        objectives = _signed(self.optimise.objectives)
        study = optuna.create_study(directions=["minimize"] * len(objectives), sampler=sampler)
        distributions = {path: _distribution(choice) for path, choice in self.optimise.over.items()}
        succeeded = [trial for trial in self.trials if not trial.failed]
        worst = {
            name: max((sign * trial.values[name] for trial in succeeded), default=0.0) for name, sign in objectives
        }
        for trial in self.trials:
            values = [worst[name] if trial.failed else sign * trial.values[name] for name, sign in objectives]
            study.add_trial(
                optuna.trial.create_trial(
                    params=trial.point,
                    distributions=distributions,
                    values=values,
                    constraints={"limits": trial.violation},
                )
            )
        propose = self._evolved_points if len(objectives) > 1 else self._surrogate_points
        points = propose(int(MODEL_SHARE * count), np.random.default_rng(seed))
        for _ in range(count - len(points)):
            proposal = study.ask(distributions)
            yield {path: proposal.params[path] for path in self.optimise.over}
        yield from points

    def _surrogate_points(self, count: int, rng: "np.random.Generator") -> list[Point]:
        """Return points where a surrogate model of the objective predicts better cases; a sampler stops too early.

        They have the categories of the best case; the model uses only cases with the same categories.
        """
        ((name, sign),) = _signed(self.optimise.objectives)
        trials = sorted(self.trials, key=lambda trial: trial.merit(name, sign))
        best = trials[0]
        choices = {path: choice for path, choice in self.optimise.over.items() if choice.kind != AMONG}
        fixed = {path: value for path, value in best.point.items() if path not in choices}
        if best.failed or not choices:
            return []
        trials = [trial for trial in trials if fixed.items() <= trial.point.items()]
        fractions = _fractions(trials, choices)
        objective = np.array([sign * trial.values[name] for trial in trials])
        objective[np.isnan(objective)] = np.nanmax(objective)  # failed cases
        margins = np.array([[-1.0 if trial.failed else trial.margins[key] for key in best.margins] for trial in trials])
        points = better_points(fractions, objective, np.nan_to_num(margins, nan=-1.0), count, rng)
        proposals = [fixed | _clipped_point(choices, row) for row in points.tolist()]
        return [{path: point[path] for path in self.optimise.over} for point in proposals]

    def _evolved_points(self, count: int, rng: "np.random.Generator") -> list[Point]:
        """Return points near the front, or [] if it has few cases; a sampler by itself leaves gaps.

        They come from differential evolution (Storn and Price 1997, J. Global Optim. 11, 341).  Cases next to wide
        gaps are varied more often, as in NSGA-II (Deb et al. 2002, IEEE Trans. Evol. Comput. 6, 182).
        """
        front = list(_front([trial for trial in self.trials if trial.violation == 0.0], self.optimise.objectives))
        if len(front) < MIN_FRONT_CASES:
            return []
        choices = self.optimise.over
        fractions = _fractions(front, choices)
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
            points.append(_clipped_point(choices, child.tolist()))
        return points


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
            for name in [name for name in self.unmet.split(",") if name]
        ]
        return sum(max(violation, np.finfo(float).tiny) for violation in excesses)

    def merit(self, name: str, sign: float) -> tuple[float, float, str]:
        """Return the sort key of a trial: violation of limits first, then an objective; smaller is better."""
        return self.violation, math.inf if self.failed else sign * self.values[name], self.case_id

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


def _signed(objectives: Sequence[tuple[str, bool]]) -> list[tuple[str, float]]:
    """Return the objectives with the sign by which a smaller value is a better one."""
    return [(name, -1.0 if is_maximised else 1.0) for name, is_maximised in objectives]


def _front(trials: list[_Trial], objectives: tuple[tuple[str, bool], ...]) -> Iterator[_Trial]:
    """Yield the non-dominated trials in order of the first objective; for one objective, the best."""
    table = np.array([[sign * trial.values[name] for name, sign in _signed(objectives)] for trial in trials])
    order = sorted(range(len(trials)), key=lambda k: (*table[k].tolist(), trials[k].case_id))
    members: list[int] = []
    for k in order:
        if not any((table[member] <= table[k]).all() for member in members):
            members.append(k)
            yield trials[k]


def _fractions(trials: Sequence[_Trial], choices: Mapping[str, Choice]) -> np.ndarray:
    """Return the fractions (trials, paths) of the values of trials in their choices."""
    return np.array([[choice.fraction_of(trial.point[path]) for path, choice in choices.items()] for trial in trials])


def _clipped_point(choices: Mapping[str, Choice], fractions: Sequence[float]) -> Point:
    """Return the values at fractions (0 to 1) of the ranges of choices, clipped to the ends of the ranges."""
    point = {}
    for (path, choice), fraction in zip(choices.items(), fractions, strict=True):
        value = choice.value_at(fraction)
        point[path] = value if choice.kind == AMONG else min(max(value, choice.values[0]), choice.values[1])
    return point


def _distribution(choice: Choice) -> "optuna.distributions.BaseDistribution":
    """Return a choice as an Optuna distribution."""
    from optuna import distributions

    if choice.kind == AMONG:
        return distributions.CategoricalDistribution(list(choice.values))
    if choice.kind == WHOLE:
        return distributions.IntDistribution(choice.values[0], choice.values[1])
    low, high = choice.values
    return distributions.FloatDistribution(low, high, log=choice.is_logarithmic)


def better_points(
    known_points: np.ndarray, objective: np.ndarray, margins: np.ndarray, count: int, rng: "np.random.Generator"
) -> np.ndarray:
    """Return points of the unit cube at which a surrogate model predicts better results; none with too few cases.

    The model is a cubic radial basis function.  Points are chosen by expected value and by distance from known ones,
    as in the local stochastic method of Regis and Shoemaker (2007, INFORMS J. Comput. 19, 497).  The margin of each
    limit has a model of its own (Regis 2014, Eng. Optim. 46, 218).  Returns (count, keys), or (0, keys).

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
    known_points = known_points[neighbours]
    objective = np.minimum(objective[neighbours], np.percentile(objective[neighbours], CLIP_PERCENTILE))
    if len(known_points) < MIN_MODEL_CASES[0] + MIN_MODEL_CASES[1] * keys:
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


def _candidates_near(known_points: np.ndarray, rng: "np.random.Generator") -> np.ndarray:
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


OPTIMISE = "optimise"
SENSES = ("minimise", "maximise")
MAX_CASES = 100_000
_AMONG_FORM = {"anyOf": [{"type": "array", "minItems": 1}, *sections.AXES_OF_NAMES]}
OPTIMISE_SECTION = sections.KeySection(
    OPTIMISE,
    "search for the values that minimise or maximise columns of summary.parquet within `limits`",
    "{over: {define.play: [5 um, 100 um]}, minimise: rod_slider_load_peak, cases: 300}",
    (
        sections.EntriesKey(
            "over",
            "path -> [low, high], {among: [a, ...]} (laws, materials, fits, groups, numbers) or {whole: [low, high]}",
            required=True,
            missing=f"{MISSING_OVER_TEXT}, such as {{define.play: [5 um, 100 um]}}",
            entry={
                "anyOf": [
                    sections.PAIR_SCHEMA,
                    *sections.single_key_schemas({AMONG: _AMONG_FORM, WHOLE: sections.PAIR_SCHEMA}),
                ]
            },
        ),
        *(sections.NamesKey(sense, f"column or columns to {sense}", noun="column") for sense in SENSES),
        sections.cases_key(1, MAX_CASES),
        SEED_KEY,
    ),
    {"anyOf": [{"required": [sense]} for sense in SENSES]},
)


@dataclass(frozen=True)
class Optimise(SearchOver):
    """Objectives, and the values to choose from, in SI."""

    name: ClassVar[str] = OPTIMISE
    keys: ClassVar[sections.KeySection] = OPTIMISE_SECTION
    example: ClassVar[str] = (
        "optimise: {over: {drive.speed: [500 rpm, 3000 rpm]}, minimise: rod_slider_load_peak, cases: 60}"
    )
    answer_key: ClassVar[str] = "optimised"
    conflicts: ClassVar[tuple[str, ...]] = ("sweep", "zip", "cases", "sample", "seek", "refine")
    seconds_per_choice: ClassVar[float] = 6e-3
    library: ClassVar[tuple[str, str]] = "optuna", "Optuna"
    at_work: ClassVar[Callable[..., Any]] = Optimisation
    objectives: tuple[tuple[str, bool], ...]  # column, and whether it is to be large

    def first_points(self) -> list[tuple[Any, ...]]:
        """Return the point written in the grid."""
        return [tuple(self.start.values())] if self.start else []

    def result_columns(self, grid: Any) -> list[str]:
        """Return the columns that compare cases: objectives, and the ends of their intervals, which few have."""
        available = {column.name for column in grid.layout.columns}
        objectives = [name for name, _ in self.objectives]
        return [*objectives, *(end for name in objectives for end in interval_columns(name) if end in available)]

    @classmethod
    def missing_answer(cls, answer: Mapping[str, Any]) -> str:
        """Return that no case meets the limits."""
        is_met = answer["search"] and answer.get("best_met", True)
        return "" if is_met else "`optimise` has no case that meets the limits"

    @classmethod
    def table_columns(cls, record: Mapping[str, Any]) -> set[str]:
        """Return the columns of optimise.parquet."""
        section = record.get(OPTIMISE) or {}
        objectives = {name for sense in SENSES for name in section.get(sense, [])}
        return {"case_id", *record["units"], *objectives, "margin", "limiting"}

    def resolved_fields(self) -> dict[str, Any]:
        """Return the objectives."""
        columns_by_sense = {
            sense: [column for column, is_maximised in self.objectives if is_maximised is (sense == SENSES[1])]
            for sense in SENSES
        }
        return {key: names for key, names in columns_by_sense.items() if names}

    @classmethod
    def read_choice(cls, reader: sections.Reader, key: str, written: WrittenValue) -> tuple[str, WrittenValue] | None:
        """Return path and values of an entry of `over`, and record the kind of its choice."""
        path = name_path(key, reader.keys_in_use)
        key_path, used_key = f"{OPTIMISE}.over.{path}", reader.keys_in_use.get(path)
        is_whole = isinstance(used_key, Number) and any(use.field.integer for use in used_key.uses)
        content, kind = written.value, "range"
        if isinstance(content, dict) and len(content) == 1 and {*content} <= {AMONG, WHOLE}:
            ((kind, written),) = content.items()
            content = written.value
            if kind == AMONG and isinstance(content, dict) and naming_of(reader, path):
                reader.choices[path] = AMONG
                return path, written
        is_pair = isinstance(content, list) and len(content) == 2
        if not isinstance(content, list) or not content or (kind != AMONG and not is_pair):
            message = f"found {quoted(content)}; expected [low, high], {{among: [...]}} or {{whole: [low, high]}}"
            reader.problems.add(written, key_path, message)
            return None
        is_word = isinstance(used_key, Word)
        if kind != AMONG and (is_word or is_whole != (kind == WHOLE)):
            expected = "{among: [...]}" if is_word else "{whole: [low, high]}" if is_whole else "[low, high]"
            reader.problems.add(written, key_path, f"found {quoted(content)}; this key takes {expected}")
            return None
        reader.choices[path] = kind
        return path, written

    @classmethod
    def read_own(cls, reader: sections.Reader, section: WrittenValue) -> dict[str, Any]:
        """Return the objectives."""
        objectives: list[tuple[str, bool]] = []
        known_columns = {**reader.figures, **dict.fromkeys(reader.user_figures, "")}
        for sense in SENSES:
            for item in OPTIMISE_SECTION.value(reader.problems, section, sense) or ():
                if item.value not in known_columns:
                    suggestion = did_you_mean(item.value, known_columns) or f" (known: {', '.join(known_columns)})"
                    message = f"{quoted(item.value)} is not a column of this grid{suggestion}"
                    reader.problems.add(item, f"{OPTIMISE}.{sense}", message)
                elif item.value in dict(objectives):
                    reader.problems.add(item, f"{OPTIMISE}.{sense}", f"{item.value} occurs twice; remove one of them")
                else:
                    objectives.append((item.value, sense == SENSES[1]))
        if not any(sense in section.value for sense in SENSES):
            message = "is missing; give the column to minimise, or maximise: the column to maximise"
            reader.problems.add(section, f"{OPTIMISE}.{SENSES[0]}", message)
        return {"objectives": tuple(objectives)} if objectives else {}
