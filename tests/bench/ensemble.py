"""Measures cases side by side, alone and with numbalsoda: `PYTHONPATH=tests python -m bench.ensemble`.

Processor time per case of grids around problems of `clearsweep verify`: by `solve_each`, as sweeps do it, by `solve`,
one by one, and by numbalsoda's DOP853, which takes nothing along but the events. All have their turn in every round and
the least time counts. Errors are those on the problem itself, over its first half.
"""

import argparse
import copy
import itertools
import os
import time

import numpy as np

from clearsweep import grid, simulation
from clearsweep.simulation.trajectory import simulate
from clearsweep.verify.problems import found_by_simulate, problems, scene_of

try:
    from . import soda
except ImportError:
    soda = None  # numbalsoda is not here: without its column

NAMES = ("b_base", "b_grav_fric", "ab_base")
TOLERANCE = 1e-8  # ours
THEIRS = 1e-8  # numbalsoda's, at which its error on the problem is about ours
WIDE = 16  # clearances, each with the other cases' restitutions


def varied(problem, count: int) -> list:
    """Return problems like one, of other clearances and restitutions."""
    found = []
    steps = itertools.product(np.linspace(0.9, 1.1, WIDE), np.linspace(0.97, 1.03, count // WIDE))
    for wider, livelier in steps:
        source = copy.deepcopy(problem.grid)
        for joint in {id(joint): joint for joint in source["joints"].values()}.values():
            joint["clearance"] *= float(wider)
            joint["contact"]["restitution"] *= float(livelier)
        found.append(problem._replace(grid=source))
    return found


def least(ways: dict, rounds: int) -> dict:
    """Return the least processor time (s) of each of several functions, which have their turn in every round."""
    found = dict.fromkeys(ways, np.inf)
    for _, (name, way) in itertools.product(range(rounds), ways.items()):
        began = time.process_time()
        way()
        found[name] = min(found[name], time.process_time() - began)
    return found


def ways_of(cases: list, like: list) -> dict:
    """Return what is timed: functions without arguments by name."""
    ways = {
        "together": lambda: dict(simulation.solve_each(cases)),
        "alone": lambda: [simulation.solve(case) for case in cases],
    }
    if soda and like:
        theirs = [soda.repeat(problem, THEIRS, "DOP853") for problem in like]
        ways["numbalsoda"] = lambda: [way() for way in theirs]
    return ways


def line(name: str, count: int, times: dict, errors: str) -> str:
    """Return a row of the table."""
    each = {way: 1e3 * spent / count for way, spent in times.items()}
    over = f"{each['together'] / each['numbalsoda']:.2f}" if "numbalsoda" in each else "-"
    values = "".join(
        f"{each[way]:12.3f}" if way in each else f"{'-':>12}" for way in ("together", "alone", "numbalsoda")
    )
    return f"  {name:<16}{count:>6}{values}{each['together'] / each['alone']:>12.2f}{over:>18}  {errors}"


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cases", type=int, default=512, help="of each grid; of thousand_cases.yaml every k-th")
    parser.add_argument("--rounds", type=int, default=5)
    asked = parser.parse_args()
    print(f"Cases side by side (ms of processor time per case, load {os.getloadavg()[0]:.1f})")
    print(f"  {'grid around':<16}{'cases':>6}{'together':>12}{'alone':>12}{'numbalsoda':>12}", end="")
    print(f"{'over alone':>12}{'over numbalsoda':>18}  errors")
    for problem in (problem for problem in problems() if problem.name in NAMES):
        like = varied(problem, asked.cases)
        cases = [scene_of(one, TOLERANCE).case for one in like]
        ours = found_by_simulate(problem, simulate(scene_of(problem, TOLERANCE), times=problem.times))
        errors = f"{problem.judge(ours).first_half:.1e}"
        if soda:
            errors += f", {problem.judge(soda.solve(problem, THEIRS, 'DOP853')).first_half:.1e}"
        ways = ways_of(cases, like)
        least(ways, 1)  # compiles
        print(line(problem.name, len(cases), least(ways, asked.rounds), errors), flush=True)
    study = grid.load("configs/thousand_cases.yaml", simulation.catalogue())
    cases = [study.case(index) for index in range(0, len(study), max(1, len(study) // asked.cases))]
    ways = ways_of(cases, [])
    least(ways, 1)
    print(line("thousand_cases", len(cases), least(ways, asked.rounds), "-"))


if __name__ == "__main__":
    main()
