"""What a machine costs that no earlier case had: `PYTHONPATH=tests python -m bench.machines [--write]`.

The ideal machine behind a scene is kept for the cases that share it.  Here one value varies, and every case has another
one: a clearance, which changes no machine, a speed, a length, and a flywheel of a motor.  Medians of the columns
`setup_time` and `run_time`; the first case, which compiles, is left out.
"""

import argparse
import time
from pathlib import Path
from statistics import median

import speed_page
from ruamel.yaml import YAML

from clearsweep import simulation
from clearsweep.grid import load

CONFIGS = Path(__file__).parents[2] / "configs"
CASES = 17
CLEARANCE = "joints.rod-slider.clearance", "0.05 mm", "0.2 mm"
VARIED = (
    ("slider_crank", *CLEARANCE),
    ("slider_crank", "drive.speed", "600 rpm", "2400 rpm"),
    ("slider_crank", "mechanism.rod.length", "110 mm", "130 mm"),
    ("start_up", *CLEARANCE),
    ("start_up", "drive.inertia", "0.5e-3 kg*m^2", "8e-3 kg*m^2"),
)


def times_of(name: str, path: str, low: str, high: str) -> tuple[float, float]:
    """Return the set-up time and the run time (s) of a case of a grid in which only one value varies."""
    grid = YAML(typ="safe").load(CONFIGS / f"{name}.yaml") | {"sweep": {path: {"linspace": [low, high, CASES]}}}
    loaded = load(grid, simulation.catalogue())
    _, *summaries = [simulation.solve(loaded.case(index)).summary for index in range(CASES)]
    return tuple(median(summary[column] for summary in summaries) for column in ("setup_time", "run_time"))


def table() -> list[str]:
    """Return the lines of the table."""
    lines = ["| grid | varies | set-up, ms | run, ms | both over run |", "| --- | --- | --- | --- | --- |"]
    for name, path, *bounds in VARIED:
        setup, run = times_of(name, path, *bounds)
        lines.append(f"| `{name}` | `{path}` | {1e3 * setup:.1f} | {1e3 * run:.1f} | {(setup + run) / run:.2f} |")
    return lines


def main() -> None:
    """Print the table, or put it into the page."""
    reader = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    reader.add_argument("--write", action="store_true", help="put the table into results/speed.md")
    given = reader.parse_args()
    lines = [
        "## A machine that no earlier case had",
        "",
        f"`make bench ARGS=--write`, {time.strftime('%Y-%m-%d')}: medians of {CASES - 1} cases with different values.",
        "",
        *table(),
    ]
    print("\n".join(lines))
    if given.write:
        speed_page.write("machines", "\n".join(lines))


if __name__ == "__main__":
    main()
