"""Every method on every problem: its error and its run time, in one interleaved run."""

import datetime
import itertools
import math
import os
import platform
import sys
import time
from collections.abc import Callable
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import clearsweep

from ..simulation.analyses.trajectory import simulate
from .problems import Errors, all_problems, scene_of, solution_of
from .rivals import Solution, runge_kutta_4, scipy_ivp

TOLERANCES = tuple(10.0**-k for k in range(4, 13))
QUICK_TOLERANCES = (1e-4, 1e-6, 1e-9, 1e-12)
COARSE_TOLERANCES, QUICK_COARSE_TOLERANCES = (
    (1e-4, 1e-6, 1e-8),
    (1e-6,),
)  # for methods that are slow at tight tolerances
STEPS = (1e-5, 3e-6, 1e-6, 3e-7, 1e-7, 3e-8, 1e-8)  # s
QUICK_STEPS = (1e-5, 1e-6, 1e-7)  # s
ROUNDS, QUICK_ROUNDS = 7, 2
SINGLE_ROUND_TIME = 0.2  # s, a run of this duration has one round: short disturbances hardly affect it
MIN_ROUND_TIME = 0.02  # s, a round repeats a short run until this time has passed
FLAGSHIP, HEADLINE_TOLERANCE = "b_base", 1e-9
#: ms per revolution of scipy's DOP853 on the flagship when it was first measured, by tolerance (2-core x86-64 machine):
#: a rival that takes far more or less than this is not the one that a ratio is quoted against.
FIRST_MEASURED_MS = {1e-6: 74.0, 1e-9: 127.0}


class Method(NamedTuple):
    """A method of integration, with some settings."""

    name: str
    setting: str  # varied setting: tolerance (1) or step (s)
    settings: tuple[float, ...]
    solve: object  # (problem, setting) -> Solution at the problem's times
    repeat: object  # (problem, setting) -> a function to be timed, which integrates; its result is not used


def _solve_ours(problem, tolerance: float, method: str) -> Solution:
    """Return the solution of `clearsweep.simulate` at the times of a problem."""
    times = problem.times if len(problem.times) else [0.0]  # with times, events are kept
    return solution_of(problem, simulate(scene_of(problem, tolerance, method), times=times))


def _repeat_ours(problem, tolerance: float, method: str):
    """Return a function that runs `clearsweep.simulate` and returns the time (s) of the integration."""
    scene = scene_of(problem, tolerance, method)
    return lambda: simulate(scene).summary["run_time"]


def _solve_runge_kutta(problem, step: float) -> Solution:
    """Return the solution of Runge-Kutta 4 with a `step` (s)."""
    return runge_kutta_4(scene_of(problem, HEADLINE_TOLERANCE), problem.times, step, problem.separations)


def _repeat_runge_kutta(problem, step: float):
    """Return a function that runs Runge-Kutta 4."""
    scene = scene_of(problem, HEADLINE_TOLERANCE)
    return lambda: runge_kutta_4(scene, problem.times, step, problem.separations) and None


def _solve_scipy(problem, tolerance: float, method: str) -> Solution:
    """Return the solution of a `method` of scipy at the times of a problem."""
    return _repeat_scipy(problem, tolerance, method, problem.times)()


def _repeat_scipy(problem, tolerance: float, method: str, times=()):
    """Return a function that runs a `method` of scipy."""
    scene = scene_of(problem, tolerance)
    return lambda: scipy_ivp(scene, times, problem.end, tolerance, problem.separations, method)


def all_methods(*, quick: bool) -> list[Method]:
    """Return our methods, then those of the rivals, with their settings."""
    tolerances, steps = (QUICK_TOLERANCES, QUICK_STEPS) if quick else (TOLERANCES, STEPS)
    coarse_tolerances = QUICK_COARSE_TOLERANCES if quick else COARSE_TOLERANCES

    def adaptive_method(name, settings, solve, repeat, method):
        return Method(name, "tolerance", settings, partial(solve, method=method), partial(repeat, method=method))

    return [
        adaptive_method("event-driven", tolerances, _solve_ours, _repeat_ours, "auto"),
        adaptive_method("explicit only", coarse_tolerances, _solve_ours, _repeat_ours, "explicit"),
        adaptive_method("implicit only", coarse_tolerances, _solve_ours, _repeat_ours, "implicit"),
        adaptive_method("scipy DOP853", tolerances, _solve_scipy, _repeat_scipy, "DOP853"),
        adaptive_method("scipy LSODA", coarse_tolerances, _solve_scipy, _repeat_scipy, "LSODA"),
        adaptive_method("scipy Radau", coarse_tolerances, _solve_scipy, _repeat_scipy, "Radau"),
        Method("fixed-step RK4", "step", steps, _solve_runge_kutta, _repeat_runge_kutta),
    ]


def measure(*, quick: bool = False, report_progress: Callable[[str], None] | None = None) -> dict[str, Any]:
    """Return every figure of every method on every problem, as `results["problems"][i]["rows"]`, and `headline`.

    `report_progress` : called with messages.  Times are processor times, the least of several rounds, in each of which
    every method has one turn, after compilation.  Our time is that of the whole call of `simulate` with every figure of
    the summary and no history; `integration_ms_per_revolution` is the part that the summary calls `run_time`.
    """
    results = describe_measurement("clearsweep verify" + (" --quick" if quick else "")) | {
        "quick": quick,
        "rounds": QUICK_ROUNDS if quick else ROUNDS,
        "problems": [],
    }
    for problem in all_problems():
        if report_progress:
            report_progress(f"{problem.name}: {problem.title}")
        results["problems"].append(measure_problem(problem, all_methods(quick=quick), results["rounds"]))
    results["headline"] = headline_figures(results["problems"])
    return results


def measure_problem(
    problem,
    methods: list[Method],
    repetitions: int,
    single_round_time: float = SINGLE_ROUND_TIME,
) -> dict:
    """Return the figures of all methods on one problem; runs that take `single_round_time` s or more have one round."""
    rows, runs = [], []
    for method in methods:
        for setting in method.settings:
            if method.name.startswith("scipy") and setting < problem.min_rival_tolerance:
                continue
            solution = method.solve(problem, setting)
            rows.append(_result_row(method, setting, problem.assess(solution), solution))
            runs.append(method.repeat(problem, setting))
    least_times, integrations = _least_times(runs, repetitions, single_round_time)
    for row, total, integration in zip(rows, least_times, integrations, strict=True):
        row["ms_per_revolution"] = 1e3 * total / problem.revolutions
        row["integration_ms_per_revolution"] = 1e3 * integration / problem.revolutions if integration else None
    return {
        "name": problem.name,
        "title": problem.title,
        "measure": problem.measure,
        "revolutions": problem.revolutions,
        "events_expected": len(problem.events),
        "rows": rows,
    }


def _result_row(method: Method, setting: float, errors: Errors, solution: Solution) -> dict:
    """Return the errors and the cost of a method with a setting, for JSON."""
    figures = {name: _json_number(value) for name, value in errors._asdict().items()}
    return {
        "method": method.name,
        method.setting: setting,
        "error_first_half": figures["first_half"],
        "error_whole": figures["whole"],
        "events": figures["events"],
        "events_exact": figures["events_exact"],
        "peak_error_first_half": figures["peaks"],
        "peak_error_first_three": figures["first_peaks"],
        "steps": solution.steps,
        "steps_rejected": solution.rejected,
        "rhs_evaluations": solution.evaluations,
    }


def _json_number(value):
    """Return a value that JSON can represent."""
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _least_times(runs: list, repetitions: int, single_round_time: float) -> tuple[np.ndarray, list]:
    """Return the least time (s) of each of `runs`, and the least time reported by the run itself, if any."""
    least_times, integrations = np.full(len(runs), math.inf), [None] * len(runs)
    for _ in range(repetitions):
        for i, run in enumerate(runs):
            if math.isfinite(least_times[i]) and least_times[i] > single_round_time:
                continue
            elapsed = 0.0
            while elapsed < MIN_ROUND_TIME:
                start = time.process_time()
                result = run()
                duration = time.process_time() - start
                elapsed += duration
                least_times[i] = min(least_times[i], duration)
                if isinstance(result, float):
                    integrations[i] = min(integrations[i] or math.inf, result)
    return least_times, integrations


def find_row(entry: dict, method: str, tolerance: float) -> dict:
    """Return the row of a problem's entry for a method at a tolerance."""
    return next(row for row in entry["rows"] if row["method"] == method and row.get("tolerance") == tolerance)


def headline_figures(entries: list[dict]) -> dict:
    """Return the figures on the flagship problem: time and error of ours and of scipy's, and their ratios."""
    entry = next(entry for entry in entries if entry["name"] == FLAGSHIP)
    event_driven, rival = (find_row(entry, name, HEADLINE_TOLERANCE) for name in ("event-driven", "scipy DOP853"))
    time_at_equal_error = time_at_error(entry, "scipy DOP853", event_driven["error_first_half"])
    return {
        "problem": FLAGSHIP,
        "tolerance": HEADLINE_TOLERANCE,
        "ms_per_revolution": event_driven["ms_per_revolution"],
        "integration_ms_per_revolution": event_driven["integration_ms_per_revolution"],
        "error_first_half": event_driven["error_first_half"],
        "scipy_ms_per_revolution": rival["ms_per_revolution"],
        "scipy_error_first_half": rival["error_first_half"],
        "ratio_at_equal_tolerance": rival["ms_per_revolution"] / event_driven["ms_per_revolution"],
        "scipy_ms_per_revolution_at_equal_error": time_at_equal_error,
        "ratio_at_equal_error": time_at_equal_error / event_driven["ms_per_revolution"]
        if time_at_equal_error
        else None,
        "scipy_over_first_measured": {
            f"{tolerance:g}": find_row(entry, "scipy DOP853", tolerance)["ms_per_revolution"] / first_measured
            for tolerance, first_measured in FIRST_MEASURED_MS.items()
        },
    }


def time_at_error(entry: dict, method: str, error: float) -> float | None:
    """Return the time (ms per revolution) at which a method reaches an error, interpolated between its settings
    (log-log).

    None if its settings do not span the error.
    """
    rows = [row for row in entry["rows"] if row["method"] == method and row["error_first_half"]]
    points = [(row["error_first_half"], row["ms_per_revolution"]) for row in rows]
    for (larger_error, shorter), (smaller_error, longer) in itertools.pairwise(points):
        if larger_error >= error >= smaller_error and larger_error > smaller_error:
            return shorter * (longer / shorter) ** (
                math.log(larger_error / error) / math.log(larger_error / smaller_error)
            )
    return None


def describe_measurement(command: str) -> dict:
    """Return command, date and machine of a measurement."""
    return {
        "command": command,
        "version": clearsweep.__version__,
        "model_version": clearsweep.MODEL_VERSION,
        "date": datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
        "machine": describe_machine(),
    }


def describe_machine() -> dict:
    """Return a description of the machine."""
    return {
        "system": f"{platform.system()} {platform.machine()}",
        "processor": _processor_name(),
        "cores": len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count(),
        "python": sys.version.split()[0],
        **{name: version(name) for name in ("numpy", "scipy", "llvmlite")},
    }


def _processor_name() -> str:
    """Return the processor's name, if the system reports it."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor()
    names = (line.split(":", 1)[1].strip() for line in lines if line.startswith("model name"))
    return next(names, platform.processor())
