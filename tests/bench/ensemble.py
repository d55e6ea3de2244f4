"""Measures many cases at once: `make bench`, or `PYTHONPATH=tests python -m bench.ensemble`.

Processor time per case of grids around problems of `clearsweep verify`: by `solve`, as sweeps do it, with every figure
of the summary; by numbalsoda's DOP853, one by one and a case a thread, and by diffrax in one batch, which take nothing
along but the events.  All have their turn in every round and the least time counts.
"""

import argparse
import copy
import functools
import itertools
import os
import time
from typing import NamedTuple

import numpy as np
import speed_page
from llvmlite.binding import get_host_cpu_features

from clearsweep import simulation
from clearsweep.simulation.analyses.trajectory import simulate
from clearsweep.verify.accuracy import all_problems, scene_of, solution_of

try:
    from . import soda
except ImportError:
    soda = None  # numbalsoda is not here: without its rows
try:
    from . import batched
except ImportError:
    batched = None  # diffrax is not here

FLAGSHIP = "b_base"
CASES = {FLAGSHIP: 512, "b_grav_fric": 256, "ab_base": 256}
WIDE = 16  # clearances, each with the other cases' restitutions
TOLERANCE = 1e-8  # ours
THEIRS = (1e-7, 1e-8, 1e-9, 1e-10)  # between which numbalsoda's time at our error lies
BATCHED, BATCH = 1e-8, 64  # diffrax's tolerance, and its cases: of 512 one takes more than half as long again
TIGHT = 1e-12  # of the motion from which errors are taken
JUDGED = 16  # cases
ASKED = {512: 0.10, 256: 0.15}  # of numbalsoda's DOP853, by the bits of a vector register
ASKED_INTEGRATING = 0.06


class Route(NamedTuple):
    """A way to integrate all cases of a grid."""

    name: str
    run: object  # () -> s of it that went into integrating, where that is known
    states: object  # () -> (JUDGED, 2 coordinates) at half a revolution
    cases: int  # of the grid that it integrates


def varied(problem, count: int) -> list:
    """Return problems like one, of other clearances and restitutions."""
    result = []
    steps = itertools.product(np.linspace(0.9, 1.1, WIDE), np.linspace(0.97, 1.03, count // WIDE))
    for wider, livelier in steps:
        source = copy.deepcopy(problem.grid)
        for joint in {id(joint): joint for joint in source["joints"].values()}.values():
            joint["clearance"] *= float(wider)
            joint["contact"]["restitution"] *= float(livelier)
        result.append(problem._replace(grid=source))
    return result


def ours(short: list, tolerance: float) -> np.ndarray:
    """Return what clearsweep gives at the times of problems."""
    result = [(first, simulate(scene_of(first, tolerance), times=first.times)) for first in short]
    return np.array([solution_of(first, path).states[0] for first, path in result])


def ways_of(like: list, short: list, *, flagship: bool) -> list[Route]:
    """Return all ways to integrate problems `like` one, of which `short` are some up to half a revolution."""
    scenes = [scene_of(first, TOLERANCE) for first in like]  # to build one takes ten times as long as to run it
    shared = {section: getattr(scenes[0].case, section) for section in ("mechanism", "loads", "outline")}
    cases = [built.case._replace(**shared) for built in scenes]  # as the cases of one grid share what does not vary
    scenes_of_short = scenes[:: len(like) // len(short)]

    def one_by_one():
        return sum(simulation.solve(case).summary["run_time"] for case in cases)

    def limits_met():
        return ours(short, TOLERANCE)

    result = [Route("clearsweep", one_by_one, limits_met, len(like))]
    if soda:
        for tolerance in THEIRS:
            many = soda.many(like, scenes, tolerance), soda.many(short, scenes_of_short, tolerance)
            each, few = (functools.partial(integrate, threads=1) for integrate in many)
            result.append(Route(f"numbalsoda DOP853 {tolerance:g}", each, few, len(like)))
        each = functools.partial(soda.many(like, scenes, TOLERANCE), threads=os.cpu_count())
        result.append(Route(f"the same {TOLERANCE:g}, a case a thread", each, None, len(like)))
    if batched and flagship:
        result.append(in_batch(like[:: max(1, len(like) // BATCH)], short[0].end))
    return result


def in_batch(some: list, half: float) -> Route:
    """Return diffrax's way for problems, of which every so many-th is evaluated at the time `half` (s)."""
    batch, step = batched.prepared(some, BATCHED), len(some) // JUDGED
    name = f"diffrax Dopri8 {BATCHED:g}, {len(some)} cases"
    return Route(name, lambda: batch(some[0].end), lambda: batch(half)[::step], len(some))


class Cost(NamedTuple):
    """What a way takes for a case."""

    processor: float  # s
    wall: float  # s
    integrating: float | None  # s, of the processor


def costs(ways: list[Route], repetitions: int) -> list[Cost]:
    """Return the least costs of all ways, which are compiled and have their turn in every round."""
    rows = []
    for way in ways * repetitions:
        began, wall_start = time.process_time(), time.perf_counter()
        inside = way.run()
        inside = inside if isinstance(inside, float) else np.nan
        rows.append((time.process_time() - began, time.perf_counter() - wall_start, inside))
    least = np.min(np.reshape(rows, (repetitions, len(ways), 3)), axis=0)
    least /= np.array([[way.cases] for way in ways])
    return [Cost(float(p), float(w), None if np.isnan(i) else float(i)) for p, w, i in least]


def at_error(error: float, points: list[tuple[float, float]]) -> float | None:
    """Return the time at an error, on log-log lines between points (error, time); None beyond them."""
    points = sorted(points)
    if not points or not points[0][0] <= error <= points[-1][0]:
        return None
    errors, times = np.log(np.array(points)).T
    return float(np.exp(np.interp(np.log(error), errors, times)))


def bits() -> int:
    """Return the width of this processor's vector registers."""
    features = get_host_cpu_features()
    return next((width for name, width in (("avx512f", 512), ("avx2", 256)) if features.get(name)), 128)


def measure(problem, count: int, repetitions: int) -> list[str]:
    """Return the table of grids around a problem."""
    like = varied(problem, count)
    half = problem.times[len(problem.times) // 2 - 1 :][:1]
    short = [first._replace(times=half) for first in like[:: len(like) // JUDGED]]
    ways, truth = ways_of(like, short, flagship=problem.name == FLAGSHIP), ours(short, TIGHT)
    states_of_ways = [way.states and way.states() for way in ways]  # compiles what is timed afterwards
    errors = [
        None if states is None else float(np.median(np.max(np.abs(states - truth) / problem.scales, axis=1)))
        for states in states_of_ways
    ]
    result = costs(ways, repetitions)
    named = zip(ways, errors, result, strict=True)
    points = [(error, cost.processor) for way, error, cost in named if way.name.startswith("numbalsoda")]
    lines = [
        f"{problem.name}, {len(like)} cases:",
        "",
        "| way | error | processor, ms | integrating, ms | wall, ms | clearsweep over it |",
        "| --- | --- | --- | --- | --- | --- |",
    ]
    for way, cost, error in zip(ways, result, errors, strict=True):
        integrating = "-" if cost.integrating is None else f"{1e3 * cost.integrating:.3f}"
        lines.append(
            f"| {way.name} | {'-' if error is None else f'{error:.1e}'} | {1e3 * cost.processor:.3f} | {integrating} "
            f"| {1e3 * cost.wall:.3f} | {result[0].processor / cost.processor:.3f} |"
        )
    theirs = at_error(errors[0], points)
    if theirs:
        lines += ["", verdict(result[0], theirs, flagship=problem.name == FLAGSHIP)]
    return lines


def verdict(cost: Cost, theirs: float, *, flagship: bool) -> str:
    """Return what share of numbalsoda's processor time (s) at equal error clearsweep takes, and what is asked."""
    share, inside = cost.processor / theirs, cost.integrating / theirs
    text = f"At equal error clearsweep takes {share:.3f} of numbalsoda's DOP853, its integration {inside:.3f}"
    asked = ASKED.get(bits())
    if not flagship or asked is None:
        return f"{text}."
    return (
        f"{text}; asked {asked:.2f}: {'met' if share <= asked else 'missed'}; "
        f"{ASKED_INTEGRATING:.2f}: {'met' if inside <= ASKED_INTEGRATING else 'missed'}."
    )


def page(cases: int | None, repetitions: int) -> str:
    """Return all tables."""
    lines = [
        "## Many cases",
        "",
        "Grids of clearances and restitutions around the problems above, one revolution; cases in turn,",
        f"vector registers of {bits()} bit; {os.cpu_count()} cores, load {os.getloadavg()[0]:.1f} before.",
        f"Error: median over {JUDGED} cases, at half a revolution, from the motion at {TIGHT:g}. Times a case: least",
        f"of {repetitions} interleaved rounds, compilation excluded; clearsweep in one process with all figures of the",
        "summary.  All but the column of the wall are processor times.",
    ]
    if batched:
        lines += ["", batched.LACKS]
    for problem in all_problems():
        if problem.name in CASES:
            lines += ["", *measure(problem, cases or CASES[problem.name], repetitions)]
    return "\n".join([*lines, ""])


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(prog="python -m bench.ensemble", description=__doc__.splitlines()[0])
    parser.add_argument("--cases", type=int, help=f"of each grid, a multiple of {WIDE}; default {CASES}")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--write", action="store_true", help="write results/speed.md too")
    asked = parser.parse_args()
    text = page(asked.cases, asked.rounds)
    print(text)
    if asked.write:
        speed_page.write("side by side", text)


if __name__ == "__main__":
    main()
