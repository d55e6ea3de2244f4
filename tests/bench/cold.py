"""What a first run costs: `PYTHONPATH=tests python -m bench.cold [--write] [GRID ...]`; `--write`: results/speed.md.

Processor time of all processes of `clearsweep run GRID` of an installed wheel, once with an empty cache, once more with
what that kept.  The difference is what compiling costs a user.  A further law: a second scene in a process that has run
one.
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
sys.path.append(sys.argv[1])
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


def install(place: str) -> None:
    """Build a wheel of this checkout and unpack it as pip does, for this Python with all that it has."""
    pip = [sys.executable, "-m", "pip", "--quiet"]
    subprocess.run([*pip, "wheel", "--no-deps", "--wheel-dir", place, str(ROOT)], check=True)
    (wheel,) = Path(place).glob("*.whl")
    subprocess.run([*pip, "install", "--no-deps", "--target", f"{place}/site", str(wheel)], check=True)


def used(place: str, cache: str) -> dict[str, str]:
    """Return the environment in which the wheel in `place` runs with a cache."""
    return {**os.environ, "CLEARSWEEP_CACHE_DIR": cache, "PYTHONPATH": f"{place}/site"}


def spent(command: list[str], place: str, cache: str) -> float:
    """Return the processor time (s) of a command and all its processes."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    subprocess.run(command, env=used(place, cache), check=True, cwd=place, **quiet)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def first_and_second(grid: str, place: str) -> tuple[float, float]:
    """Return the processor time (s) of a first run and of one with what that kept."""
    with tempfile.TemporaryDirectory() as runs:
        command = [sys.executable, "-m", "clearsweep", "run", f"{ROOT}/configs/{grid}.yaml", "--out"]
        return tuple(spent([*command, f"{runs}/{run}"], place, f"{runs}/cache") for run in ("first", "second"))


def further_law(place: str) -> float:
    """Return the processor time (s) of a scene with a further law in a process that has run another."""
    with tempfile.TemporaryDirectory() as cache:
        command = [sys.executable, "-c", FURTHER, str(ROOT / "tests")]
        done = subprocess.run(command, env=used(place, cache), check=True, cwd=place, capture_output=True, text=True)
        return float(done.stdout)


def table(grids: tuple[str, ...]) -> list[str]:
    """Return the lines of the table."""
    lines = ["| grid | first run, s | again, s | compiling, s |", "| --- | --- | --- | --- |"]
    with tempfile.TemporaryDirectory() as place:
        install(place)
        for grid in grids:
            print(grid, file=sys.stderr, flush=True)
            first, second = first_and_second(grid, place)
            lines.append(f"| `{grid}` | {first:.2f} | {second:.2f} | {first - second:.2f} |")
        return [*lines, "", f"A further law in a process that runs: {further_law(place):.2f} s."]


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
            f"`python -m bench.cold`, {time.strftime('%Y-%m-%d')}: processor time of all processes of a run of an "
            "installed wheel with an empty cache, and of the same run again."
        )
        speed_page.write("first run", "\n".join(["## A first run", "", said, "", *lines]))


if __name__ == "__main__":
    main()
