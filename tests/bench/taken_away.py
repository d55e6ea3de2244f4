"""What each feature of the README's grid costs: `PYTHONPATH=tests python -m bench.taken_away [--write]`.

Processor time per case of configs/slider_crank_restitution.yaml, and of a grid of the same ranges with ten times as
many speeds, as they are and with wear, orbits and friction taken away.  Cases are simulated without storage.  All
variants have their turn in every round; the mean of each is over the least times of its cases, which scatter less than
the least sum.
"""

import argparse
import copy
import tempfile
import time
from pathlib import Path

import numpy as np
import speed_page
from ruamel.yaml import YAML

from clearsweep import simulation
from clearsweep.grid import load

GRID = Path(__file__).parents[2] / "configs/slider_crank_restitution.yaml"
JOINT = "rod-slider"
FEATURES = ("wear", "orbits", "friction")
VARIANTS = ((), ("wear",), ("orbits",), ("friction",), ("wear", "orbits"), FEATURES)
COUNTS = (48, 480)
TAKEN = 48  # cases of the larger grid that are run, evenly spread over it
ROUNDS = 8


def grid_without(features: tuple[str, ...], count: int) -> dict:
    """Return the grid of so many cases without some FEATURES."""
    grid = YAML(typ="safe").load(GRID)
    if "orbits" in features:
        grid["save"] = {"orbits": "none"}
    for name in {"wear", "friction"} & set(features):
        del grid["joints"][JOINT][name]
    speeds = grid["sweep"]["drive.speed"]["linspace"]
    speeds[-1] = speeds[-1] * count // COUNTS[0]
    return copy.deepcopy(grid)


def cases_of(grid: dict) -> list:
    """Return the cases of a grid that are run."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "grid.yaml"
        YAML(typ="safe").dump(grid, path)
        made = load(path, simulation.catalogue())
        step = max(len(made) // TAKEN, 1)
        return [made.case(place) for place in range(0, len(made), step)]


def spent(cases: list) -> np.ndarray:
    """Return the processor time (s) of each case."""
    times = []
    for case in cases:
        begin = time.process_time()
        simulation.solve(case)
        times.append(time.process_time() - begin)
    return np.array(times)


def table() -> list[str]:
    """Return the lines of the table."""
    lines = ["| taken away | " + " | ".join(f"{count} cases, ms a case" for count in COUNTS) + " | over the whole |"]
    lines.append("| --- |" + " --- |" * (len(COUNTS) + 1))
    runs = {(features, count): cases_of(grid_without(features, count)) for features in VARIANTS for count in COUNTS}
    for cases in runs.values():
        simulation.solve(cases[0])  # compiles
    timings = [{key: spent(cases) for key, cases in runs.items()} for _ in range(ROUNDS)]
    least = {key: np.min([timing[key] for timing in timings], axis=0).mean() for key in runs}
    for features in VARIANTS:
        times = [1e3 * least[features, count] for count in COUNTS]
        shares = ", ".join(f"{least[features, count] / least[(), count]:.2f}" for count in COUNTS)
        lines.append(f"| {', '.join(features) or 'nothing'} | {times[0]:.1f} | {times[1]:.1f} | {shares} |")
    return lines


def main() -> None:
    """Print the table, or put it into the page."""
    reader = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    reader.add_argument("--write", action="store_true", help="put the table into results/speed.md")
    given = reader.parse_args()
    lines = table()
    print("\n".join(lines))
    if given.write:
        head = [
            "## What each feature of the README's grid costs",
            "",
            f"`make bench ARGS=--write`, {time.strftime('%Y-%m-%d')}: processor time, one process.",
            "",
        ]
        speed_page.write("taken away", "\n".join([*head, *lines]))


if __name__ == "__main__":
    main()
