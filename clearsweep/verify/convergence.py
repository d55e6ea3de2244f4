"""Convergence of statistics with the tolerance and the length of a run, where pointwise errors are meaningless.

After one or two revolutions two integrations of the same chaotic motion are two samples of it, whatever their
tolerance.  Only figures over many revolutions can converge.  With the length of the run they converge to a value with
an interval (blocks of revolutions, see `blocks`), and these intervals must agree between tolerances.
"""

import copy
import itertools
import math
import time
from collections.abc import Callable, Sequence
from typing import Any

from .. import grid
from ..contracts.layout import Layout
from ..mechanics.solver.integration import Work
from ..simulation.analyses.trajectory import simulate
from ..simulation.figures.batch_means import Blocks, Interval
from ..simulation.running.observed_run import Decision
from ..simulation.setup import scene
from .problems import all_problems

PROBLEM_NAME, DISCARDED_REVOLUTIONS = "b_base", 2  # before its statistics begin
WEAR = {"law": "archard", "coefficient": 2e-14}
FIGURES = ("rod_slider_force_rms", "rod_slider_force_p99", "rod_slider_impacts_per_rev", "rod_slider_wear_rate_max")
TOLERANCES = (1e-6, 1e-7, 1e-8, 1e-9, 1e-10)
LENGTHS = (10, 30, 100, 300, 1000)  # revolutions
QUICK_TOLERANCES, QUICK_LENGTHS = (1e-6, 1e-8, 1e-10), (10, 30, 100)


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


def measure(*, quick: bool = False, report_progress: Callable[[str], None] | None = None) -> dict[str, Any]:
    """Return the figures and intervals of every tolerance and length as `rows`, and their agreement.

    `within` : share of the pairs of tolerances, over all figures and lengths, whose difference is within both intervals
    combined (root of the sum of squares); 0.95 for correct intervals.
    """
    tolerances, lengths = (QUICK_TOLERANCES, QUICK_LENGTHS) if quick else (TOLERANCES, LENGTHS)
    start_time, rows = time.perf_counter(), []
    for tolerance in tolerances:
        if report_progress:
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
