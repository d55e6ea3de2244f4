"""Measures which share of two workers' time goes into cases, with real mechanics: `make bench`.

The share is the sum of the cases' processor times over workers x wall time, from the moment the workers are ready to
the end of the merge.  Where other programs use the processor it says less than it should.

With --minute it compares the wall times of a minute of work with one worker and with two instead.
"""

import argparse
import os
import tempfile
from pathlib import Path

import numpy as np
import scale_cases
import speed_page

from clearsweep.sweeping import sweep
from clearsweep.sweeping.pool.case_runner import SIMULATION

WORKERS = 2
LENGTHS = {1e-3: 12_000, 1e-2: 1200, 0.2: 80}  # s, nominal length of a case: number of cases
ASKED = {1e-3: 0.85, 1e-2: 0.85, 0.2: 0.95}
MINUTE = 1e-2, 6000  # s, nominal length of a case, and number of cases of a minute of work
ASKED_OF_TWO = 1.9  # wall time of one worker over that of two, from a minute of work on
PILOT = 10, 64  # revolutions and cases by which the length of a revolution is found
TIMED = SIMULATION._replace(solve=scale_cases.timed)


def grid(revolutions: int, cases: int) -> dict:
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
        "simulate": {"revolutions": revolutions, "discard": 1, "tolerance": 1e-8},
        "save": {"orbits": "none"},
        "sweep": {"joints.rod-slider.contact.restitution": {"linspace": [0.6, 0.9, cases]}},
    }


def measure(revolutions: int, cases: int, executor: str, jobs: int = WORKERS) -> dict[str, float]:
    """Return counts and times (s) of one run."""
    options = sweep.Options(jobs=jobs, executor=executor, show_progress=False)
    with tempfile.TemporaryDirectory() as place:
        result = sweep.run_sweep(grid(revolutions, cases), place, options, TIMED)
        spent = float(np.sum(result.open().summary["run_time"]))
        batches = len(os.listdir(Path(place) / "parts"))
    wall = result.seconds - result.start_up
    each, share = spent / cases, spent / (jobs * wall)
    walls = {"wall": wall, "whole": result.seconds}  # s, from the moment the workers are ready; with start-up
    return {"cases": cases, "each": each, "batches": batches, "share": share, **walls}


def table(runs: int, executor: str) -> str:
    """Return a row for each length of case, the best of several runs."""
    revolutions, cases = PILOT
    turn = measure(revolutions, cases, executor)["each"] / revolutions
    lines = [
        f"{WORKERS} workers, best of {runs} runs, load {os.getloadavg()[0]:.1f} before.",
        "",
        "| cases of | number | processor time of one | wall | batches | cases / (2 x wall) | asked |",
        "| --- | --- | --- | --- | --- | --- | --- |",
    ]
    for length, count in LENGTHS.items():
        long = max(2, round(length / turn))
        best = max((measure(long, count, executor) for _ in range(runs)), key=lambda result: result["share"])
        lines.append(
            f"| {1e3 * length:g} ms | {count:,} | {1e3 * best['each']:.2f} ms | {best['wall']:.1f} s "
            f"| {best['batches']} | {best['share']:.3f} | {ASKED[length]} |"
        )
    return "\n".join(lines)


def minute(executor: str) -> str:
    """Return how long a minute of work takes one worker and two, start-up and merge included."""
    (revolutions, few), (length, cases) = PILOT, MINUTE
    turn = measure(revolutions, few, executor)["each"] / revolutions
    walls = [measure(round(length / turn), cases, executor, jobs)["whole"] for jobs in (1, 2)]
    return (
        f"{cases:,} cases of {1e3 * length:g} ms: {walls[0]:.1f} s with one worker, {walls[1]:.1f} s with two, "
        f"{walls[0] / walls[1]:.2f} times as fast (asked {ASKED_OF_TWO:g}; load {os.getloadavg()[0]:.1f} after)."
    )


def main() -> None:
    """Print the table, and write it where asked."""
    parser = argparse.ArgumentParser(prog="python -m bench.efficiency", description=__doc__.partition("\n")[0])
    parser.add_argument("--runs", type=int, default=2)
    parser.add_argument("--executor", choices=["local", "dask"], default="local")
    parser.add_argument("--minute", action="store_true", help="a minute of work with one worker and with two instead")
    parser.add_argument("--write", action="store_true", help="write results/speed.md too")
    asked = parser.parse_args()
    if asked.minute:
        print(minute(asked.executor))
        return
    text = f"## Two workers\n\n{table(asked.runs, asked.executor)}\n"
    print(text)
    if asked.write:
        speed_page.write("two workers", text)


if __name__ == "__main__":
    main()
