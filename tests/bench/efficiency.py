"""Measures which share of two workers' time goes into cases, with real mechanics: `python tests/bench/efficiency.py`.

Efficiency is the sum of the cases' times over workers x wall time, from the moment the workers are ready to the end of
the merge. `integrating` counts the integration alone (`run_time` of the summary), `cases` all that is done for a case
(reading its values, building its scene, its figures). On a machine with other work both say less than they should.
"""

import argparse
import os
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2]))  # runs from a checkout, installed or not

from clearsweep.sweeping import progress, sweep

WORKERS = 2
#: Nominal length of a case -> revolutions, cases
LENGTHS = {"1 ms": (1.25, 10000), "10 ms": (5, 1500), "200 ms": (90, 100)}
TARGETS = {"1 ms": 0.85, "10 ms": 0.85, "200 ms": 0.95}


def grid(revolutions: float, cases: int) -> dict:
    """Return a grid of equally long cases without histories."""
    return {
        "name": "efficiency",
        "mechanism": {
            "type": "slider-crank",
            "crank": {"length": "50 mm", "mass": 0.3, "inertia": 1e-4},
            "rod": {"length": "120 mm", "mass": 0.21, "inertia": 2.5e-4},
            "slider": {"mass": "0.14 kg"},
        },
        "drive": {"speed": "5000 rpm"},
        "joints": {
            "rod-slider": {
                "clearance": "0.5 mm",
                "bearing_radius": "10 mm",
                "contact": {"law": "lankarani-nikravesh", "stiffness": "6.61e10 N/m^1.5", "restitution": 0.9},
            }
        },
        "simulate": {"revolutions": revolutions, "discard": 1, "tolerance": 1e-9},
        "save": {"orbits": "none"},
        "sweep": {"joints.rod-slider.contact.restitution": {"linspace": [0.6, 0.9, cases]}},
    }


def measure(revolutions: float, cases: int, executor: str = "local") -> dict[str, float]:
    """Return counts and times (s) of one run."""
    with tempfile.TemporaryDirectory() as place:
        before = time.process_time()
        result = sweep.sweep(grid(revolutions, cases), place, jobs=WORKERS, executor=executor, show_progress=False)
        parent = time.process_time() - before
        summary = result.open().summary
        batches = len(os.listdir(Path(place) / "parts"))
    wall = result.seconds - result.start_up
    return {
        "cases": len(summary),
        "mean": summary["run_time"].mean(),
        "wall": wall,
        "parent": parent,
        "batches": batches,
        "integrating": summary["run_time"].sum() / (WORKERS * wall),
        "computing": result.case_seconds / (WORKERS * wall),
    }


def main(arguments: list[str] | None = None) -> None:
    """Print a row for each length of case, the best of several runs."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--runs", type=int, default=2)
    parser.add_argument("--executor", choices=["local", "dask"], default="local")
    options = parser.parse_args(arguments)
    progress.say(f"{WORKERS} workers, best of {options.runs} runs")
    print("| cases of | number | mean | wall | batches | parent's CPU | integrating | cases | target |")
    print("| --- | --- | --- | --- | --- | --- | --- | --- | --- |")
    for name, (revolutions, cases) in LENGTHS.items():
        found = max(
            (measure(revolutions, cases, options.executor) for _ in range(options.runs)),
            key=lambda each: each["computing"],
        )
        print(
            f"| {name} | {found['cases']} | {1e3 * found['mean']:.1f} ms | {found['wall']:.1f} s "
            f"| {found['batches']} | {found['parent']:.1f} s | {found['integrating']:.3f} "
            f"| {found['computing']:.3f} | {TARGETS[name]} |",
            flush=True,
        )


if __name__ == "__main__":
    main()
