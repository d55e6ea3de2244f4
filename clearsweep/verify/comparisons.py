"""Chaotic averages over tolerance and length, machines with known motion, and stiff cases by both methods."""

import copy
import itertools
import math
import time
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from .. import grid
from ..contracts import results
from ..contracts.layout import Layout
from ..mechanics.solver.integration import Work
from ..simulation.analyses.trajectory import simulate
from ..simulation.figures.catalogue import Blocks, Interval
from ..simulation.running.observed_run import Decision
from ..simulation.setup import scene
from .accuracy import ImpactPair, ReferenceTrajectory, all_problems, read_problems, scene_of
from .extremes import ExtremeCase, cases_of

# ----------------------------------------------------------------------------------------------------------------------
# Convergence of statistics with the tolerance and the length of a run, where pointwise errors are meaningless.
#
# After one or two revolutions two integrations of the same chaotic motion are two samples of it, whatever their
# tolerance.  Only figures over many revolutions can converge.  With the length of the run they converge to a value with
# an interval (blocks of revolutions, see `Blocks`), and these intervals must agree between tolerances.


PROBLEM_NAME, DISCARDED_REVOLUTIONS = "b_base", 2  # before its statistics begin
WEAR = {"law": "archard", "coefficient": 2e-14}
FIGURES = ("rod_slider_force_rms", "rod_slider_force_p99", "rod_slider_impacts_per_rev", "rod_slider_wear_rate_max")
AVERAGE_TOLERANCES = (1e-6, 1e-7, 1e-8, 1e-9, 1e-10)
LENGTHS = (10, 30, 100, 300, 1000)  # revolutions
QUICK_AVERAGE_TOLERANCES, QUICK_LENGTHS = (1e-6, 1e-8, 1e-10), (10, 30, 100)


class LengthObserver:
    """Records the intervals of the figures when a run reaches given lengths."""

    per_revolution = 1

    def __init__(self, layout: Layout, lengths: Sequence[int]):
        self.blocks, self.lengths = Blocks(layout, FIGURES), lengths
        self.intervals: dict[int, dict[str, Interval]] = {}  # length -> figure -> interval

    def observe(self, work: Work) -> Decision:
        """Record a revolution, and the intervals of the figures if the run has reached one of the lengths."""
        revolutions = self.blocks.turns
        self.blocks.record(work)
        if revolutions in self.lengths:
            self.intervals[revolutions] = {figure: self.blocks.interval(figure) for figure in FIGURES}
        return Decision.CONTINUE


def measure_convergence(
    *, quick: bool = False, report_progress: Callable[[str], None] = lambda step: None
) -> dict[str, Any]:
    """Return the figures and intervals of every tolerance and length as `rows`, and their agreement.

    `within` : share of the pairs of tolerances, over all figures and lengths, whose difference is within both intervals
    combined (root of the sum of squares); 0.95 for correct intervals.
    """
    tolerances, lengths = (QUICK_AVERAGE_TOLERANCES, QUICK_LENGTHS) if quick else (AVERAGE_TOLERANCES, LENGTHS)
    start_time, rows = time.perf_counter(), []
    for tolerance in tolerances:
        report_progress(f"convergence of statistics: tolerance {tolerance:g}")
        rows += run_at_tolerance(tolerance, lengths)
    pairs = [
        (first_row[figure], second_row[figure])
        for length in lengths
        for first_row, second_row in itertools.combinations([row for row in rows if row["revolutions"] == length], 2)
        for figure in FIGURES
    ]
    is_within = [
        abs(first["value"] - second["value"]) <= math.hypot(first["half_width"], second["half_width"])
        for first, second in pairs
    ]
    return {
        "problem": PROBLEM_NAME,
        "discard": DISCARDED_REVOLUTIONS,
        "figures": list(FIGURES),
        "rows": rows,
        "within": sum(is_within) / len(is_within),
        "seconds": time.perf_counter() - start_time,
    }


def run_at_tolerance(tolerance: float, lengths: Sequence[int]) -> list[dict[str, Any]]:
    """Return a row for each length, in revolutions after the discarded ones, of one run at a tolerance."""
    source = copy.deepcopy(next(problem.grid for problem in all_problems() if problem.name == PROBLEM_NAME))
    source["joints"]["rod-slider"] |= {"length": 0.02, "wear": WEAR}
    total_revolutions = DISCARDED_REVOLUTIONS + max(lengths)
    source["simulate"] = {"revolutions": total_revolutions, "discard": DISCARDED_REVOLUTIONS, "tolerance": tolerance}
    scene_of_problem = scene.build(grid.load(source, scene.catalogue()).case(0))
    observer = LengthObserver(scene_of_problem.layout, lengths)
    simulate(scene_of_problem, observers=(observer,))
    return [
        {"tolerance": tolerance, "revolutions": revolutions}
        | {figure: interval._asdict() for figure, interval in intervals.items()}
        for revolutions, intervals in observer.intervals.items()
    ]


# ----------------------------------------------------------------------------------------------------------------------
# Error against run time on machines with known motion in quadruple precision: one of each kind.
#
# `references/machines.json` describes the origin of the trajectories.  The error is the largest of all channels of the
# bodies, over the channel's own largest value, up to the time where a comparison is meaningful.


MACHINE_TOLERANCES = (1e-6, 1e-8, 1e-10, 1e-12)
MACHINE_ROUNDS = 3  # the least run time counts
REST_VALUE = 1e-9  # largest value below which a channel is at rest
TITLES = {
    "fb_c": "four-bar, clearance in coupler-rocker",
    "sc_load": "slider-crank pressed by 500 N",
    "sc_torque": "slider-crank, free crank under 2 N m",
    "v_twin": "V-twin, two loops, clearance in one",
    "sc_film": "slider-crank, rod-slider in a film of 0.4 Pa s",
    "sc_film_dry": "slider-crank, a film of 1 mPa s and dry contact",
}


def measure_machines(
    *, quick: bool = False, report_progress: Callable[[str], None] = lambda step: None
) -> dict[str, Any]:
    """Return `rows`, one for every machine and tolerance; none if `quick`, because each machine compiles a scene."""
    rows = []
    for name, entry in ({} if quick else read_problems("machines.json")).items():
        report_progress(f"machines: {name}")
        rows += [run_machine(name, entry, tolerance) for tolerance in MACHINE_TOLERANCES]
    return {"rows": rows}


def run_machine(name: str, entry: dict[str, Any], tolerance: float) -> dict[str, Any]:
    """Return the row of a machine at a tolerance."""
    source, times = copy.deepcopy(entry["grid"]), np.array(entry["samples"]["t"])
    source["simulate"]["tolerance"] = tolerance
    loaded_scene = scene.load_case(source)
    compared_times = times[times <= entry["fair"]]
    trajectory = simulate(loaded_scene, times=compared_times)
    run_time = min(simulate(loaded_scene, times=compared_times).summary["run_time"] for _ in range(MACHINE_ROUNDS))
    max_error = max(
        _relative_error(trajectory[channel], np.array(values)[: compared_times.size])
        for channel, values in entry["samples"].items()
        if "force" not in channel and "torque" not in channel
    )
    event_times, reference = trajectory.events["t"], np.array([row[0] for row in entry["events"]])
    has_same_count = len(event_times) == len(reference)
    return {
        "name": name,
        "tolerance": tolerance,
        "error": max_error,
        "events": len(event_times),
        "events_expected": len(reference),
        "event_error": event_error(event_times, reference) if has_same_count else None,  # s
        "rhs_evaluations": trajectory.summary["rhs_evaluations"],
        "energy_residual": trajectory.summary["energy_residual"],
        "ms": 1e3 * run_time,
    }


def event_error(times: np.ndarray, reference: np.ndarray) -> float:
    """Return the largest error (s) of corresponding events, 0 without events."""
    return float(np.max(np.abs(times - reference), initial=0.0))


def _relative_error(computed: np.ndarray, reference: np.ndarray) -> float:
    """Return the largest error over the largest value, 0 for a channel at rest."""
    largest = float(np.max(np.abs(reference)))
    is_moving = largest > REST_VALUE and math.isfinite(largest)
    return float(np.max(np.abs(computed - reference))) / largest if is_moving else 0.0


# ----------------------------------------------------------------------------------------------------------------------
# Costs of the explicit and the implicit method in stiff motion, and of the choice between them.
#
# Equal error: the explicit method at some tolerance is compared with `auto` at the loosest power of ten at which its
# error is no larger.  The reference is the explicit method at REFERENCE_TOLERANCE, which shares only the right-hand
# side with the implicit one.  An evaluation of the Jacobian counts as one of the right-hand side for each of its
# columns.
#
# Equal tolerance: `auto` over the better of the two methods, in processor time.


TOLERANCES, QUICK_TOLERANCES = (1e-6, 1e-8), (1e-6,)
CHOICE_TOLERANCES = (1e-4, 1e-6, 1e-8, 1e-10)
METHODS = ("explicit", "implicit", "auto")
DEFAULT_TOLERANCE = 1e-8
REFERENCE_TOLERANCE = 1e-11
EXTRA_DECADES = 3  # powers of ten by which `auto` may be tighter
SAMPLES = 160  # per revolution, samples of the error
STEP_BUDGET = 3e6  # budget: not a limit for the explicit method
ROUNDS = 3  # the least run time counts


def stiff_cases() -> list[ExtremeCase]:
    """Return cases in which plain sweeps limit the steps of the explicit method: damping, stiffness, friction."""
    return cases_of("methods")


def measure_stiff(*, quick: bool = False, report_progress: Callable[[str], None] = lambda step: None) -> dict[str, Any]:
    """Return the comparisons of methods: `rows`, `choices` and `others`.

    rows : explicit and automatic at equal error, for every stiff case and tolerance; choices : all methods at equal
    tolerance; others : cases that are not stiff.
    """
    rows, choices = [], []
    for case in stiff_cases():
        report_progress(f"stiffness: {case.name}")
        tolerances, choice_tolerances = (QUICK_TOLERANCES,) * 2 if quick else (TOLERANCES, CHOICE_TOLERANCES)
        rows += compare_at_equal_error(case, tolerances)
        choices += [compare_methods(case, tolerance) for tolerance in choice_tolerances]
    others = [evaluation_ratio(problem) for problem in all_problems() if problem.name != "b_damped"]
    return {"rows": rows, "choices": choices, "others": others}


def evaluation_ratio(problem: ReferenceTrajectory | ImpactPair) -> dict[str, Any]:
    """Return the evaluations of explicit and automatic on a problem that is not stiff, and their ratio."""
    evaluations = {
        method: simulate(scene_of(problem, DEFAULT_TOLERANCE, method)).summary["rhs_evaluations"]
        for method in ("explicit", "auto")
    }
    return {"name": problem.name} | evaluations | {"evaluations_ratio": evaluations["auto"] / evaluations["explicit"]}


def compare_at_equal_error(case: ExtremeCase, tolerances: Sequence[float]) -> list[dict[str, Any]]:
    """Return a row for each of the tolerances of the explicit method."""
    reference = run_case(case, REFERENCE_TOLERANCE, "explicit")
    rows = []
    for tolerance in tolerances:
        explicit = _figures(case, tolerance, "explicit", reference)
        for decades in range(EXTRA_DECADES + 1):
            auto = _figures(case, tolerance / 10.0**decades, "auto", reference)
            if auto["error"] <= explicit["error"]:
                break
        is_as_accurate = auto["error"] <= explicit["error"]
        ratios = {
            f"{ratio}_ratio": explicit[name] / auto[name] if is_as_accurate else None
            for ratio, name in (("evaluations", "rhs_evaluations"), ("run_time", "run_time"))
        }
        rows.append({"name": case.name, "explicit": explicit, "auto": auto} | ratios)
    return rows


def compare_methods(case: ExtremeCase, tolerance: float) -> dict[str, Any]:
    """Return evaluations and least processor time (s) of ROUNDS interleaved runs of every method, and their ratio.

    The time of a method that exhausts its budget of steps is infinite.
    """
    times: dict[str, float] = dict.fromkeys(METHODS, math.inf)
    runs: dict[str, results.Trajectory] = {}
    for _ in range(ROUNDS):
        for method in METHODS:
            start = time.process_time()
            runs[method] = run_case(case, tolerance, method)
            if runs[method].status == "ok":
                times[method] = min(times[method], time.process_time() - start)
    evaluations = {method: runs[method].summary["rhs_evaluations"] for method in METHODS}
    cheaper = min(times["explicit"], times["implicit"])
    return {
        "name": case.name,
        "tolerance": tolerance,
        "rhs_evaluations": evaluations,
        "processor_time": {method: value if math.isfinite(value) else None for method, value in times.items()},
        "over_better": times["auto"] / cheaper,
    }


def run_case(case: ExtremeCase, tolerance: float, method: str) -> results.Trajectory:
    """Return the Trajectory of a case over one revolution."""
    settings = {
        "simulate.tolerance": tolerance,
        "simulate.method": method,
        "simulate.revolutions": 1,
        "simulate.step_budget": STEP_BUDGET,
    }
    loaded_scene = scene.build(grid.load(case.grid, scene.catalogue(), settings).case(0))
    period = 2.0 * math.pi / loaded_scene.value.reference_rate
    return simulate(loaded_scene, times=np.arange(1, SAMPLES + 1) / SAMPLES * period)


def error_of(trajectory: results.Trajectory, reference: results.Trajectory, case: ExtremeCase) -> float:
    """Return the largest error at the samples: angle / 0.05 rad, place / 0.05 m, their rates over those times speed."""
    speed: float = case.grid["drive"]["speed"]
    scales = {"rod/angle": 0.05, "slider/x": 0.05, "rod/rate": speed, "slider/v": 0.05 * speed}
    return max(float(np.max(np.abs(trajectory[name] - reference[name]))) / scale for name, scale in scales.items())


def _figures(case: ExtremeCase, tolerance: float, method: str, reference: results.Trajectory) -> dict[str, Any]:
    """Return the cost and the error of a method at a tolerance."""
    runs = [run_case(case, tolerance, method) for _ in range(ROUNDS)]
    return {
        "tolerance": tolerance,
        "rhs_evaluations": runs[0].summary["rhs_evaluations"],
        "steps": runs[0].summary["steps"],
        "error": error_of(runs[0], reference, case),
        "run_time": min(run.summary["run_time"] for run in runs),
    }
