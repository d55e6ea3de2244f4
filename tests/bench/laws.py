"""What the elastic laws cost, rough surfaces among them: `python tests/bench/laws.py`, `--write` for results/laws.md.

A slider-crank whose journal is pressed against its bearing, no loss, no friction: nanoseconds of one right-hand side,
and of the elastic law alone over penetrations from 10 nm to 100 um.  The least of several rounds, each of which
goes through all laws, so that a machine that grows slower slows all alike.
"""

import argparse
import sys
import time
from pathlib import Path

import numpy as np
from numba import njit

sys.path.insert(0, str(Path(__file__).parents[2]))  # runs from a checkout, installed or not

import clearsweep
from clearsweep.mechanics.compiled.family import invoke
from clearsweep.mechanics.joint.elastic.contract import elastic_force
from clearsweep.simulation.run import Run

PAGE = Path(__file__).parents[2] / "results" / "laws.md"
FRACTAL = {"law": "fractal", "dimension": 1.5, "scale": 1e-11, "hardness": 5.5e9}
LAWS = ("power", "johnson", "persson", "compatible", "compatible-fit")
ROUGH = ("power", "johnson", "compatible")
ROUNDS, EVALUATIONS = 15, 20_000
DEPTHS = np.geomspace(1e-8, 1e-4, 2000)  # m


@njit
def _right_hand_sides(code, parameters, arrays, times):
    for _ in range(times):
        invoke(code, parameters, arrays, 0)


@njit
def _forces(elastic, depths):
    total = 0.0
    for depth in depths:
        total += elastic_force(elastic, depth)
    return total


def scene_of(elastic: str, roughness: dict | None):
    """Return a scene whose joint is pressed."""
    contact = {"law": "hertz", "elastic": elastic, "material": {"young": 207e9, "poisson": 0.3}}
    joint = {"clearance": 1e-4, "bearing_radius": 0.01, "length": 0.02, "contact": contact}
    if roughness:
        joint["roughness"] = roughness
    return clearsweep.load_case(
        {
            "mechanism": {
                "type": "slider-crank",
                "crank": {"length": 0.05, "mass": 0.3, "inertia": 1e-4},
                "rod": {"length": 0.12, "mass": 0.21, "inertia": 2.5e-4},
                "slider": {"mass": 0.14},
            },
            "drive": {"speed": "3000 rpm"},
            "joints": {"rod-slider": joint},
            "simulate": {"revolutions": 1, "discard": 0, "start": "seated"},
            "save": {"orbits": "none"},
        }
    )


def measure(rounds: int = ROUNDS) -> list[tuple[str, float, float]]:
    """Return name, time of a right-hand side and of the law alone (s) of every law."""
    joints = {law: (law, None) for law in LAWS} | {f"{law} with fractal": (law, FRACTAL) for law in ROUGH}
    runs, terms, least = {}, {}, {name: [np.inf, np.inf] for name in joints}
    for name, (law, roughness) in joints.items():
        scene = scene_of(law, roughness)
        runs[name], terms[name] = Run(scene, np.empty(0)), scene.value.joints[0].elastic
        print(f"compiling {name}", file=sys.stderr, flush=True)
        _timed(runs[name].work, terms[name])
    for _ in range(rounds):
        for name in joints:
            least[name] = [min(pair) for pair in zip(least[name], _timed(runs[name].work, terms[name]), strict=True)]
    return [(name, *times) for name, times in least.items()]


def _timed(work, term) -> tuple[float, float]:
    """Return the time (s) of a right-hand side and of the law."""
    arrays = (work.y, work.mode, work.latched, work.k, work.o)
    begin = time.perf_counter()
    _right_hand_sides(work.rates.code, work.rates.parameters, arrays, EVALUATIONS)
    middle = time.perf_counter()
    for _ in range(5):
        _forces(term, DEPTHS)
    return (middle - begin) / EVALUATIONS, (time.perf_counter() - middle) / (5 * len(DEPTHS))


def text(rows: list[tuple[str, float, float]]) -> str:
    """Return the page."""
    whole = {name: side for name, side, _ in rows}
    lines = [
        "# Cost of the elastic laws",
        "",
        f"Written by `python tests/bench/laws.py --write` on {time.strftime('%Y-%m-%d', time.gmtime())}: a pressed",
        f"joint of a slider-crank, the least of {ROUNDS} rounds of {EVALUATIONS:,} evaluations. `power` has Hertz's",
        "exponent; `kogut-etsion` runs the code of `fractal`, with another table.",
        "",
        "| elastic law | right-hand side, ns | over that of `power` | over the smooth law | law alone, ns |",
        "| --- | --- | --- | --- | --- |",
    ]
    for name, side, law in rows:
        smooth = f"{side / whole[name.partition(' ')[0]]:.2f}" if " " in name else "-"
        lines.append(f"| {name} | {1e9 * side:.0f} | {side / whole['power']:.2f} | {smooth} | {1e9 * law:.1f} |")
    return "\n".join([*lines, ""])


def main() -> None:
    """Measure, print, and write the page where asked."""
    reader = argparse.ArgumentParser(description=__doc__)
    reader.add_argument("--write", action="store_true", help=f"write {PAGE.name}")
    asked = reader.parse_args()
    page = text(measure())
    print(page)
    if asked.write:
        PAGE.write_text(page, encoding="utf-8")


if __name__ == "__main__":
    main()
