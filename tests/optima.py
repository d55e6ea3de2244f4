"""Compares the results of `optimise` with brute-force searches of 20,000 cases, for three problems.

    python tests/optima.py                          # all problems, 10 seeds each, 300 cases a seed
    python tests/optima.py --problem spring --seeds 2
    python tests/optima.py --show FILE              # the table of an earlier run

Every line of the JSON file is a brute-force search or one run of `optimise`; an interrupted run continues after the
last
line.  A machine of one revolution takes a few ms per case.

"""

import argparse
import json
import tempfile
import time
from pathlib import Path

import numpy as np
from right_grids import grid_of

import clearsweep

JOINT, SPRING = "joints.rod-slider", "loads.spring"
MACHINE = grid_of("a crank to optimise")
#: Objectives to minimise, and the values of every key: ends, number, whether they are spaced logarithmically.
PROBLEMS = {
    "spring": {
        "minimise": ["rod_slider_load_peak"],
        "over": {
            f"{SPRING}.stiffness": ("1 kN/m", "30 kN/m", 142, False),
            f"{SPRING}.free_length": ("200 mm", "360 mm", 141, False),
        },
    },
    "joint": {
        "minimise": ["rod_slider_force_peak"],
        "limits": {"rod_slider_penetration_max": {"at_most": "20 um"}},
        "over": {
            f"{JOINT}.clearance": ("20 um", "300 um", 27, False),
            f"{JOINT}.contact.stiffness": ("1e9 N/m^1.5", "1e11 N/m^1.5", 40, True),
            f"{SPRING}.stiffness": ("1 kN/m", "30 kN/m", 19, False),
        },
    },
    "front": {
        "minimise": ["rod_slider_load_peak", "slider_error_max"],
        "over": {
            f"{JOINT}.clearance": ("20 um", "300 um", 27, False),
            f"{JOINT}.contact.stiffness": ("1e9 N/m^1.5", "1e11 N/m^1.5", 27, True),
            f"{SPRING}.stiffness": ("1 kN/m", "30 kN/m", 28, False),
        },
    },
}


def front(points):
    """Return the points (n, objectives) that no other one dominates, in order of the first objective."""
    points, kept = points[np.lexsort(points.T[::-1])], []
    for point in points:
        if not any((other <= point).all() for other in kept):
            kept.append(point)
    return np.array(kept)


def hypervolume(points, reference):
    """Return the area that a front of two objectives dominates below a reference point."""
    inside = front(points[(points < reference).all(axis=1)])
    rights = np.append(inside[1:, 0], reference[0])
    return float(((rights - inside[:, 0]) * (reference[1] - inside[:, 1])).sum())


def swept(grid, problem):
    """Return the objectives (n, objectives) of the cases of a grid that keep to its limits, and the seconds it took."""
    with tempfile.TemporaryDirectory() as folder:
        begin, own = time.monotonic(), time.process_time()
        result = clearsweep.sweep(grid, Path(folder) / "run", show_progress=False)
        seconds, own = time.monotonic() - begin, time.process_time() - own
        table = result.open().summary
        good = table["status"] == "ok"
        if "limits" in problem:
            good &= table["limits_exceeded"] == ""
        return {
            "cases": len(table),
            "failed": result.failed,
            "seconds": seconds,
            "processor_seconds_beside_the_cases": own,
            "points": front(table.loc[good, problem["minimise"]].to_numpy(float)).tolist(),
        }


def grid_of(problem, **more):
    """Return the machine as the grid of a problem."""
    limits = {"limits": problem["limits"]} if "limits" in problem else {}
    return MACHINE | limits | more


def brute(problem):
    """Return the results of 20,000 evenly spaced cases of a problem."""
    ways = {True: "geomspace", False: "linspace"}
    axes = {path: {ways[even]: [low, high, count]} for path, (low, high, count, even) in problem["over"].items()}
    return swept(grid_of(problem, sweep=axes), problem)


def optimised(problem, seed, cases):
    """Return the result of `optimise`."""
    over = {path: [low, high] for path, (low, high, *_) in problem["over"].items()}
    section = {"over": over, "minimise": problem["minimise"], "cases": cases, "seed": seed}
    return swept(grid_of(problem, optimise=section), problem)


def compared(rows, name):
    """Return the brute force of a problem, or None if it has not run, and its runs of `optimise`."""
    mine = [row for row in rows if row["problem"] == name]
    every = next((row for row in mine if row["seed"] is None), None)
    return every, [row for row in mine if row["seed"] is not None]


def shares(every, runs, objectives):
    """Return the results of runs relative to a brute-force search, median and worst, in %, and their median time (s).

    For one objective it is the excess of their best value over its best; for two, their share of its hypervolume.
    """
    known = np.array(every["points"])
    own = np.median([row["processor_seconds_beside_the_cases"] for row in runs])
    if objectives == 1:
        off = [100.0 * (row["points"][0][0] / known[0, 0] - 1.0) if row["points"] else np.inf for row in runs]
        return np.median(off), max(off), own
    reference = known.max(axis=0)
    parts = [100.0 * hypervolume(np.array(row["points"]), reference) / hypervolume(known, reference) for row in runs]
    return np.median(parts), min(parts), own


def table(rows):
    """Print the best cases of every problem relative to those of its brute-force search."""
    for name, problem in PROBLEMS.items():
        every, runs = compared(rows, name)
        if every is None or not runs:
            continue
        middle, worst, own = shares(every, runs, len(problem["minimise"]))
        text = f"{name}: {every['cases']} cases by brute force; {len(runs)} seeds of {runs[0]['cases']} cases: "
        if len(problem["minimise"]) == 1:
            text += f"{middle:+.2f} % from its best in the median, {worst:+.2f} % at most (-: better)"
        else:
            text += f"hypervolume {middle:.1f} % of its front in the median, {worst:.1f} % at least"
        print(f"{text}; {own:.2f} s of processor time apart from the cases")


def main():
    """Run the missing searches and print the table."""
    reader = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    reader.add_argument("--problem", choices=PROBLEMS, action="append")
    reader.add_argument("--seeds", type=int, default=10)
    reader.add_argument("--cases", type=int, default=300)
    reader.add_argument("--out", type=Path, default=Path("results/inverse/optima.jsonl"))
    reader.add_argument("--show", type=Path)
    asked = reader.parse_args()
    file = asked.show or asked.out
    file.parent.mkdir(parents=True, exist_ok=True)
    rows = [json.loads(line) for line in file.read_text().splitlines()] if file.exists() else []
    done = {(row["problem"], row["seed"]) for row in rows}
    for name in () if asked.show else asked.problem or PROBLEMS:
        for seed in (None, *range(1, asked.seeds + 1)):
            if (name, seed) not in done:
                problem = PROBLEMS[name]
                row = brute(problem) if seed is None else optimised(problem, seed, asked.cases)
                rows.append({"problem": name, "seed": seed} | row)
                with file.open("a") as lines:
                    lines.write(json.dumps(rows[-1]) + "\n")
    table(rows)


if __name__ == "__main__":
    main()
