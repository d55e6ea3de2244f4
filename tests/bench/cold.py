"""What a first run costs: `PYTHONPATH=tests python -m bench.cold [--write] [GRID ...]`; `--write`: results/speed.md.

Processor time of all processes of `clearsweep run GRID`, once with an empty cache but for what set-up builds, once more
with what that kept.  The difference is what compiling costs a user.  A further law: a second scene in a process that
has run one.
"""

import argparse
import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import speed_page

ROOT = Path(__file__).parents[2]
GRIDS = (
    "one_case",
    "slider_crank",
    "four_bar",
    "press",
    "lubricated",
    "spatial_slider_crank",
    "worn_slider_crank",
    "law_comparison",
)
FURTHER = """
import sys, time
sys.path.insert(0, "tests")
import clearsweep
from clearsweep import simulation
from mechanism_cases import slider_crank
for elastic in ("liu", "johnson"):
    contact = {"law": "flores", "restitution": 0.5, "elastic": elastic, "material": {"young": 207e9, "poisson": 0.3}}
    changes = {"joints.rod-slider.contact": contact, "simulate.revolutions": 0.01}
    case = clearsweep.load_case(slider_crank("rod-slider", changes=changes)).case
    begin = time.process_time()
    simulation.solve(case)
    seconds = time.process_time() - begin
print(seconds)
"""


def spent(command: list[str], cache: str) -> float:
    """Return the processor time (s) of a command and all its processes."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    environment = {**os.environ, "CLEARSWEEP_CACHE_DIR": cache}
    subprocess.run(command, env=environment, check=True, cwd=ROOT, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def first_and_second(grid: str) -> tuple[float, float]:
    """Return the processor time (s) of a first run and of one with what that kept."""
    with tempfile.TemporaryDirectory() as place:
        command = [sys.executable, "-m", "clearsweep", "run", f"configs/{grid}.yaml", "--out"]
        return tuple(spent([*command, f"{place}/{run}"], f"{place}/cache") for run in ("first", "second"))


def further_law() -> float:
    """Return the processor time (s) of a scene with a further law in a process that has run another."""
    with tempfile.TemporaryDirectory() as cache:
        environment = {**os.environ, "CLEARSWEEP_CACHE_DIR": cache}
        command = [sys.executable, "-c", FURTHER]
        done = subprocess.run(command, env=environment, check=True, cwd=ROOT, capture_output=True, text=True)
        return float(done.stdout)


def table(grids: tuple[str, ...]) -> list[str]:
    """Return the lines of the table."""
    lines = ["| grid | first run, s | again, s | compiling, s |", "| --- | --- | --- | --- |"]
    for grid in grids:
        print(grid, file=sys.stderr, flush=True)
        first, second = first_and_second(grid)
        lines.append(f"| `{grid}` | {first:.1f} | {second:.1f} | {first - second:.1f} |")
    return [*lines, "", f"A further law in a process that runs: {further_law():.2f} s."]


def main() -> None:
    """Print the table, or put it into the page."""
    reader = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    reader.add_argument("--write", action="store_true", help=f"put the table into {speed_page.PAGE.relative_to(ROOT)}")
    reader.add_argument("grids", nargs="*", metavar="GRID", default=GRIDS, help="names of grids in configs/")
    given = reader.parse_args()
    lines = table(tuple(given.grids))
    print("\n".join(lines))
    if given.write:
        said = (
            f"`python -m bench.cold`, {time.strftime('%Y-%m-%d')}: processor time of all processes of a run with "
            "an empty cache, but for the loop that set-up builds, and of the same run again."
        )
        speed_page.write("first run", "\n".join(["## A first run", "", said, "", *lines]))


if __name__ == "__main__":
    main()
