"""Every method on every problem with a known answer: its error and its run time, in one interleaved run."""

import copy
import datetime
import itertools
import json
import math
import os
import platform
import sys
import time
from collections.abc import Callable
from functools import partial
from importlib import resources
from importlib.metadata import version
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy.special import lambertw

import clearsweep

from .. import grid
from ..contracts.case import column_name
from ..mechanics.solver.integration import ONSET, SEPARATION
from ..simulation.analyses.trajectory import simulate
from ..simulation.setup import scene
from .rivals import Solution, runge_kutta_4, scipy_ivp

# ----------------------------------------------------------------------------------------------------------------------
# Problems with known answers: quadruple-precision trajectories of slider-cranks, and impacts of two bodies.
#
# `references/planar.json` describes the origin of its trajectories and its rows.  A problem builds its scene, gives the
# output times, and assesses the solution of an integrator.


CRANK = 0.05  # m
STIFF_TURNS, REFERENCE_TOLERANCE = 0.25, 1e-12  # revolutions; tolerance of the trajectory of the stiff problem
EVENT_KINDS = {"on": ONSET, "off": SEPARATION}


class Errors(NamedTuple):
    """Errors of a solution, None where undefined."""

    error_first_half: float | None  # largest error of a sample in the first half of the run, over its scale
    error_whole: float  # the same over the whole run; impact pair: largest error of a restitution
    events: int  # contact onsets and separations found
    events_exact: bool  # correct number, joints and kinds in the correct order
    peak_error_first_half: float | None  # largest relative error of a force peak in the first half
    peak_error_first_three: float | None  # the same of the first three force peaks


class ReferenceTrajectory(NamedTuple):
    """A slider-crank whose motion is known at given times."""

    name: str
    title: str
    grid: dict
    scales: np.ndarray  # (2 coordinates,) 0.05 rad, 0.05 m, crank rate, crank rate x crank length
    samples: np.ndarray  # (samples, 2 coordinates) in the order of the compiled state
    times: np.ndarray  # (samples,) s, equidistant, the last one is the end
    events: np.ndarray  # (events, 5) time (s), joint, ONSET or SEPARATION, rate (m/s), force peak (N, nan: not known)
    revolutions: float
    separations: int = 0
    measure: str = "pointwise"
    min_rival_tolerance: float = 0.0  # tolerance below which the rivals would take minutes

    @property
    def end(self) -> float:
        """Return the length of the run, s."""
        return self.times[-1]

    def assess(self, solution: Solution) -> Errors:
        """Return the errors of a solution at the samples."""
        half_count, error, peaks, first_peaks = len(self.times) // 2, np.array([np.nan]), None, None
        if solution.states.shape == self.samples.shape and bool(np.all(np.isfinite(solution.states))):
            error = np.abs(solution.states - self.samples) / self.scales
            peaks, first_peaks = self._peak_error(solution), self._peak_error(solution, 3)
        first_half, whole = float(error[:half_count].max()), float(error.max())
        are_events_exact = _have_same_events(solution.events, self.events)
        return Errors(first_half, whole, len(solution.events), are_events_exact, peaks, first_peaks)

    def _peak_error(self, solution: Solution, count: int | None = None) -> float | None:
        """Return the largest relative error of the force peaks (or of `count` of them) in the first half."""
        computed, reference = (
            log[(log[:, 2] == SEPARATION) & (log[:, 0] <= 0.5 * self.end), 4][:count]
            for log in (solution.events, self.events)
        )
        if len(computed) != len(reference) or not len(reference) or not np.all(computed > 0.0):
            return None
        return float(np.nanmax(np.abs(computed / reference - 1.0)))  # nan: an unknown peak


class ImpactPair(NamedTuple):
    """Two bodies that bounce against each other; the ratio of rebound to approach speed is known in closed form."""

    name: str
    title: str
    grid: dict
    restitution: float  # the ratio, of every impact
    separations: int
    end: float  # s, later than the last separation
    times: np.ndarray = np.empty(0)
    revolutions: float = 1.0  # cost is measured over the whole run
    measure: str = "restitution"
    min_rival_tolerance: float = 0.0

    @property
    def events(self) -> np.ndarray:
        """Return the events in the form of `Trajectory.events`, with joint and kind only."""
        return np.array([(0.0, 0.0, kind, 0.0, 0.0) for kind in (ONSET, SEPARATION)] * self.separations)

    def assess(self, solution: Solution) -> Errors:
        """Return the largest error of the ratio of rebound to approach speed."""
        are_events_exact = _have_same_events(solution.events, self.events)
        rates = solution.events[:, 3]
        worst = float(np.max(np.abs(-rates[1::2] / rates[::2] - self.restitution))) if are_events_exact else math.nan
        return Errors(None, worst, len(solution.events), are_events_exact, None, None)


def _have_same_events(computed: np.ndarray, reference: np.ndarray) -> bool:
    return len(computed) == len(reference) and bool(np.all(computed[:, 1:3] == reference[:, 1:3]))


def scene_of(problem, tolerance: float, method: str = "auto"):
    """Return the Scene of a problem, to be integrated with `tolerance`; no history is stored."""
    settings = {"simulate.tolerance": tolerance, "simulate.method": method}
    return scene.build(grid.load(problem.grid, scene.catalogue(), settings).case(0))


def restitution_of(factor: float) -> float:
    """Return the ratio of rebound to approach speed under F = F_elastic (1 + chi u), chi being `factor`.

    It is (1 + W(-(1 + chi) exp(-(1 + chi)))) / chi with Lambert's W, for any elastic law, masses and speed.
    """
    return float(1.0 + lambertw(-(1.0 + factor) * math.exp(-(1.0 + factor))).real) / factor


def read_problems(file: str) -> dict[str, Any]:
    """Return the entries of the reference trajectories in a `file` of references by name."""
    path = resources.files(__package__) / "references" / file
    problems: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))["problems"]
    return problems


def all_problems() -> list:
    """Return all problems."""
    entries = read_problems("planar.json")
    problems = [_reference_problem(name, entry) for name, entry in entries.items()]
    return [*problems, _stiff_problem(entries["b_base"]), _impact_pair_problem()]


def _stiff_problem(base: dict) -> ReferenceTrajectory:
    """Return a heavily damped contact as a problem; its trajectory is our own at the tightest tolerance.

    scipy's methods, which share only the force law with it, give the same trajectory.  `base`: entry of the problem
    whose contact is replaced.
    """
    source = copy.deepcopy(_reference_problem("", base).grid)
    (joint,) = source["joints"]
    source["joints"][joint]["contact"] = {"law": "kelvin-voigt", "stiffness": 1e8, "damping": 1e6}
    source["simulate"]["revolutions"] = STIFF_TURNS
    speed = grid.load(source, scene.catalogue()).case(0).drive.speed
    times = np.arange(1, 41) / 40 * STIFF_TURNS * 2.0 * math.pi / speed
    scales = np.array([0.05, 0.05, speed, speed * CRANK])
    title = "rod-slider, damped by 1e6 N s/m; reference: ours at 1e-12"
    samples, events = np.empty((0, 0)), np.empty((0, 5))
    problem = ReferenceTrajectory(
        "b_damped", title, source, scales, samples, times, events, STIFF_TURNS, min_rival_tolerance=1e-6
    )
    reference = solution_of(problem, simulate(scene_of(problem, REFERENCE_TOLERANCE), times=times))
    return problem._replace(samples=reference.states, events=reference.events)


def _reference_problem(name: str, entry: dict) -> ReferenceTrajectory:
    """Return a reference trajectory as a problem."""
    samples = np.array(entry["samples"])
    names = [column_name(joint) for joint in entry["grid"]["joints"]]
    revolutions = entry["grid"]["simulate"]["revolutions"]
    events = [(t, names.index(joint), EVENT_KINDS[kind], rate, peak) for t, joint, kind, rate, peak in entry["events"]]
    speed = 2.0 * math.pi * revolutions / samples[-1, 0]
    # two joints: the rod's centre comes first
    order, coordinate_count = ([0, 1], 2) if len(names) == 1 else ([2, 3, 0, 1], 4)
    scales = np.array([0.05] * coordinate_count + [speed] + [speed * CRANK] * (coordinate_count - 1))
    values = samples[:, 1:][:, order + [coordinate_count + column for column in order]]
    known = (scales, values, samples[:, 0], np.array(events, dtype=float), revolutions)
    return ReferenceTrajectory(name, entry["title"], entry["grid"], *known)


def _impact_pair_problem() -> ImpactPair:
    """Return the impact pair as a problem."""
    contact = {"law": "lankarani-nikravesh", "stiffness": 6.61e10, "restitution": 0.9}
    contact["onset"] = "first"  # supported by the rivals
    source = {
        "mechanism": {"type": "impact-pair", "masses": [0.2, 0.2], "speed": 1.0},
        "joints": {"pair": {"clearance": 1e-3, "contact": contact}},
        "simulate": {"impacts": 5},
        "save": {"orbits": "none"},
    }
    ratio = restitution_of(0.75 * (1.0 - 0.9**2))
    return ImpactPair("impact_pair", "five impacts of two bodies", source, ratio, 5, 1.0)


def solution_of(problem, trajectory) -> Solution:
    """Return the Trajectory of `clearsweep.simulate` as a Solution."""
    summary, channels = trajectory.summary, trajectory.channels
    names = _channel_names(problem)
    states = np.column_stack([channels[name] for name in names]) if channels and names else np.empty((0, 0))
    joints = [column_name(joint) for joint in problem.grid["joints"]]
    rows = [
        (event["t"], joints.index(event["joint"]), EVENT_KINDS[event["kind"]], event["rate"], event["force_peak"])
        for event in trajectory.events
    ]
    costs = (summary[name] for name in ("steps", "steps_rejected", "rhs_evaluations"))
    return Solution(states, np.array(rows).reshape(-1, 5), *costs)


def _channel_names(problem) -> list[str]:
    """Return the channels with the compiled state of a problem with known samples, in its order."""
    if problem.measure == "restitution":
        return []
    rod = ["rod/x", "rod/y"] if len(problem.grid["joints"]) == 2 else []
    rates = ["rod/vx", "rod/vy"] if rod else []
    return ["rod/angle", "slider/x", *rod, "rod/rate", "slider/v", *rates]


# ----------------------------------------------------------------------------------------------------------------------
# Every method on every problem: its error and its run time, in one interleaved run.


TOLERANCES = tuple(10.0**-k for k in range(4, 13))
QUICK_TOLERANCES = (1e-4, 1e-6, 1e-9, 1e-12)
# for methods that are slow at tight tolerances
COARSE_TOLERANCES = (1e-4, 1e-6, 1e-8)
QUICK_COARSE_TOLERANCES = (1e-6,)
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


def _repeat_runge_kutta(problem, step: float):
    """Return a function that runs Runge-Kutta 4."""
    scene = scene_of(problem, HEADLINE_TOLERANCE)
    return lambda: runge_kutta_4(scene, problem.times, step, problem.separations)


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
        Method("fixed-step RK4", "step", steps, lambda *of: _repeat_runge_kutta(*of)(), _repeat_runge_kutta),
    ]


def measure(*, quick: bool = False, report_progress: Callable[[str], None] = lambda step: None) -> dict[str, Any]:
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
        report_progress(f"{problem.name}: {problem.title}")
        results["problems"].append(measure_problem(problem, all_methods(quick=quick), results["rounds"]))
    results["headline"] = headline_figures(results["problems"])
    return results


def measure_problem(
    problem, methods: list[Method], repetitions: int, single_round_time: float = SINGLE_ROUND_TIME
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
    figures = {  # JSON has no other numbers
        name: value if value is None or math.isfinite(value) else None for name, value in errors._asdict().items()
    }
    costs = {"steps": solution.steps, "steps_rejected": solution.rejected, "rhs_evaluations": solution.evaluations}
    return {"method": method.name, method.setting: setting} | figures | costs


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
    own_time = event_driven["ms_per_revolution"]
    return {
        "problem": FLAGSHIP,
        "tolerance": HEADLINE_TOLERANCE,
        "ms_per_revolution": own_time,
        "integration_ms_per_revolution": event_driven["integration_ms_per_revolution"],
        "error_first_half": event_driven["error_first_half"],
        "scipy_ms_per_revolution": rival["ms_per_revolution"],
        "scipy_error_first_half": rival["error_first_half"],
        "ratio_at_equal_tolerance": rival["ms_per_revolution"] / own_time,
        "scipy_ms_per_revolution_at_equal_error": time_at_equal_error,
        "ratio_at_equal_error": time_at_equal_error / own_time if time_at_equal_error else None,
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
            share = math.log(larger_error / error) / math.log(larger_error / smaller_error)
            return shorter * (longer / shorter) ** share
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
