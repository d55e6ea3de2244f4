"""Costs of the explicit and the implicit method in stiff motion, and of the choice between them.

Equal error: the explicit method at some tolerance is compared with `auto` at the loosest power of ten at which its
error is no larger.  The reference is the explicit method at REFERENCE_TOLERANCE, which shares only the right-hand side
with the implicit one.  An evaluation of the Jacobian counts as one of the right-hand side for each of its columns.

Equal tolerance: `auto` over the better of the two methods, in processor time.
"""

import math
import time
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from .. import grid
from ..contracts import results
from ..simulation.analyses.trajectory import simulate
from ..simulation.setup import scene
from .extremes import ExtremeCase, contact_section, slider_crank_grid, tanh_section, voigt_section
from .problems import ImpactPair, ReferenceTrajectory, all_problems, scene_of

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
    loaded: dict[str, Any] = {"gravity": 9.81, "start": "seated"}
    steep_friction, soft_contact = tanh_section(0.3, 1e-5), contact_section(1e9, 0.1)
    return [
        ExtremeCase("damping/C 1e6 N s/m", slider_crank_grid("C", contact=voigt_section(1e6))),
        ExtremeCase("damping/C 1e7 N s/m", slider_crank_grid("C", contact=voigt_section(1e7))),
        ExtremeCase("damping/BC 1e6 N s/m", slider_crank_grid("BC", speed=1500, contact=voigt_section(1e6))),
        ExtremeCase("damping/ABC 1e6 N s/m", slider_crank_grid("ABC", speed=1500, contact=voigt_section(1e6))),
        ExtremeCase(
            "stiffness/C 1e13, restitution 0.01, 300 rpm",
            slider_crank_grid("C", speed=300, contact=contact_section(1e13, 0.01), **loaded),
        ),
        ExtremeCase(
            "stiffness/C 1e14, restitution 0.01, 300 rpm",
            slider_crank_grid("C", speed=300, contact=contact_section(1e14, 0.01), **loaded),
        ),
        ExtremeCase(
            "friction/C full at 1e-5 m/s, 60 rpm",
            slider_crank_grid("C", speed=60, contact=soft_contact, friction=steep_friction, **loaded),
        ),
        ExtremeCase(
            "friction/B full at 1e-5 m/s, 60 rpm",
            slider_crank_grid("B", speed=60, contact=soft_contact, friction=steep_friction, **loaded),
        ),
    ]


def measure(*, quick: bool = False, report_progress: Callable[[str], None] | None = None) -> dict[str, Any]:
    """Return the comparisons of methods: `rows`, `choices` and `others`.

    rows : explicit and automatic at equal error, for every stiff case and tolerance; choices : all methods at equal
    tolerance; others : cases that are not stiff.
    """
    rows, choices = [], []
    for case in stiff_cases():
        if report_progress:
            report_progress(f"stiffness: {case.name}")
        rows += compare_at_equal_error(case, QUICK_TOLERANCES if quick else TOLERANCES)
        choices += [
            compare_methods(case, tolerance) for tolerance in (QUICK_TOLERANCES if quick else CHOICE_TOLERANCES)
        ]
    return {
        "rows": rows,
        "choices": choices,
        "others": [evaluation_ratio(problem) for problem in all_problems() if problem.name != "b_damped"],
    }


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
        rows.append(
            {
                "name": case.name,
                "explicit": explicit,
                "auto": auto,
                "evaluations_ratio": explicit["rhs_evaluations"] / auto["rhs_evaluations"] if is_as_accurate else None,
                "run_time_ratio": explicit["run_time"] / auto["run_time"] if is_as_accurate else None,
            }
        )
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
