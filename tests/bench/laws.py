"""What elastic laws and kinds of joints cost: `python tests/bench/laws.py`, `--write` for results/laws.md.

A slider-crank whose journal is pressed against its bearing, no loss, no friction: nanoseconds of one right-hand side,
and of the elastic law alone over penetrations from 10 nm to 100 um.  Kinds of joints: a right-hand side after a tenth
of a turn; in space with the plane with the same contacts: the first case of the study, apart everywhere and pressed
at both walls, and the planar slider-crank with the same joint, apart and pressed.  The least of several rounds, each of
which goes through all, so that a machine that grows slower slows all alike.
"""

import argparse
import sys
import time
from pathlib import Path
from typing import NamedTuple

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[2]))  # runs from a checkout, installed or not

import clearsweep
from clearsweep import grid
from clearsweep.mechanics.laws.contract import PRESSED
from clearsweep.mechanics.laws.elastic import elastic_force
from clearsweep.mechanics.wear import Worn
from clearsweep.simulation import catalogue
from clearsweep.simulation.running.run import Run, integration_of
from clearsweep.simulation.setup.scene import build
from clearsweep.simulation.setup.start import start_of
from clearsweep.tracing.compiled.family import invoke
from clearsweep.tracing.compiled.pinned import Pinned, pinned_at
from clearsweep.tracing.objects import machine_code

PAGE = Path(__file__).parents[2] / "results" / "laws.md"
FRACTAL = {"law": "fractal", "dimension": 1.5, "scale": 1e-11, "hardness": 5.5e9}
LAWS = ("power", "johnson", "persson", "compatible", "compatible-fit")
ROUGH = ("power", "johnson", "compatible")
ROUNDS, EVALUATIONS = 15, 20_000
WALLS, ROOT, ONSET = 2, 3e-3, 0.1  # of a joint in space; m^0.5, of 9 um; m/s
BRIEF = 1000  # evaluations at a time, of what is compared: short enough not to be interrupted in most rounds
STAGE = 10  # a place of the implicit method, where no largest pressure of a film is looked for
DEPTHS = np.geomspace(1e-8, 1e-4, 2000)  # m
STEEL = {"law": "hertz", "material": {"young": 207e9, "poisson": 0.3}}
OIL = {"viscosity": 0.4}
FILMS = ("reynolds", "finite", "short", "long", "pinkus-sternlicht")
WINKLER = STEEL | {"elastic": "winkler", "thickness": 5e-3}
WEAR = {"law": "archard", "coefficient": 1e-14, "bins": 360}
WORN = {  # a joint of circles, and the same worn before
    "deepest point": ({"contact": STEEL}, "mean"),
    "springs of `winkler`": ({"contact": WINKLER}, "winkler"),
}
KINDS = {  # what a joint has besides its sizes
    "dry": {"contact": STEEL},
    **{f"film {law}": {"film": OIL | {"law": law}} for law in FILMS},
    "film finite before dry": {"film": OIL | {"law": "finite"}, "contact": STEEL},
}


@machine_code
def _right_hand_sides(where, times):
    """Evaluate a right-hand side so many times; where : (3,) int64, its code, its parameters, a Kept of its arrays."""
    arrays = pinned_at(ARRAYS[0], where[2])[0]
    for _ in range(times):
        invoke(where[0], where[1], arrays, STAGE)


class Evaluated(NamedTuple):
    """What an evaluation of a right-hand side is given, as `integration.Work` has it."""

    y: np.ndarray
    mode: np.ndarray
    latched: np.ndarray
    k: np.ndarray
    o: np.ndarray


ARRAYS: list[Pinned] = []  # the one whose form they all have


@machine_code
def _forces(elastic, depths):
    total = 0.0
    for depth in depths:
        total += elastic_force(elastic, depth)
    return total


def scene_of(joint: dict, start: str):
    """Return the scene of a slider-crank whose small end has what `joint` says besides its sizes."""
    return clearsweep.load_case(
        {
            "mechanism": {
                "type": "slider-crank",
                "crank": {"length": 0.05, "mass": 0.3, "inertia": 1e-4},
                "rod": {"length": 0.12, "mass": 0.21, "inertia": 2.5e-4},
                "slider": {"mass": 0.14},
            },
            "drive": {"speed": "3000 rpm"},
            "joints": {"rod-slider": {"clearance": 1e-4, "bearing_radius": 0.01, "length": 0.02} | joint},
            "simulate": {"revolutions": 1, "discard": 0, "start": start},
            "save": {"orbits": "none"},
        }
    )


def in_both() -> dict:
    """Return the scene of the first case of the study in space, and of the planar slider-crank with its joint."""
    study = grid.load(Path(__file__).parents[2] / "configs" / "spatial_slider_crank.yaml", catalogue())
    case = study.written_case(0)
    joint, mechanism = case["joints"]["crank-rod"], case["mechanism"]
    keys = ("clearance", "bearing_radius", "length", "contact", "friction")
    bodies = {
        "crank": mechanism["crank"] | {"inertia": mechanism["crank"]["inertia"][2]},
        "rod": mechanism["rod"] | {"inertia": mechanism["rod"]["inertia"][2]},
    }
    for body in bodies.values():
        body["center"] = body["center"][0]
    flat = {
        "mechanism": {"type": "slider-crank", "slider": mechanism["slider"]} | bodies,
        "drive": case["drive"],
        "joints": {"crank-rod": {key: joint[key] for key in keys}},
        "simulate": {"revolutions": 1, "discard": 0},
        "save": {"orbits": "none"},
    }
    return {"plane": clearsweep.load_case(flat), "space": build(study.case(0))}


def spaces(repetitions: int = 20 * ROUNDS) -> dict[str, dict[str, float]]:
    """Return the time (s) of a right-hand side in plane and space, of what is apart and of what is pressed."""
    runs, least = {}, {state: {"plane": np.inf, "space": np.inf} for state in ("apart", "pressed")}
    for name, scene in in_both().items():
        print(f"compiling {name}", file=sys.stderr, flush=True)
        runs[name] = integration_of(scene, np.empty(0), 0.1 * scene.crank_clock.value_after(1.0))
    for _ in range(repetitions):
        for name, run in runs.items():
            work = run.work
            for state, times in least.items():
                work.mode[:] = work.apart
                walls = slice(0, (WALLS if name == "space" else 1) if state == "pressed" else 0)
                work.mode[walls], work.latched[walls] = PRESSED, ONSET
                work.y[work.time + 1 :][walls] = ROOT
                times[name] = min(times[name], _side(work, BRIEF))
    return least


def kinds(repetitions: int = ROUNDS) -> list[tuple[str, float]]:
    """Return name and time (s) of a right-hand side of every kind of joint."""
    scenes = {name: scene_of(joint, "centred") for name, joint in KINDS.items()}
    runs, least = {}, dict.fromkeys(scenes, np.inf)  # a run keeps the parameters that compiled code reads
    for name, scene in scenes.items():
        print(f"compiling {name}", file=sys.stderr, flush=True)
        runs[name] = integration_of(scene, np.empty(0), 0.1 * scene.crank_clock.value_after(1.0))
        _side(runs[name].work)
    for _ in range(repetitions):
        for name, run in runs.items():
            least[name] = min(least[name], _side(run.work))
    return list(least.items())


def worn(repetitions: int = ROUNDS) -> list[tuple[str, float, float]]:
    """Return name and times (s) of a right-hand side of circles and of what is left of them, pressed."""
    angles = 2.0 * np.pi * (np.arange(360) + 0.5) / 360
    before = Worn(8e-6 * (1.0 + np.cos(2.0 * angles)), 4e-6 * (1.0 + np.cos(3.0 * angles + 1.0)))
    runs, least = {}, {}
    for name, (joint, pressure) in WORN.items():
        wear = WEAR | {"pressure": pressure}
        scenes = [scene_of(joint | {"wear": wear | {"evolve": acts}}, "seated") for acts in (False, True)]
        scenes[1] = build(scenes[1].case, {"rod-slider": before})
        print(f"compiling {name}", file=sys.stderr, flush=True)
        runs[name], least[name] = [Run(start_of(scene, np.empty(0))) for scene in scenes], [np.inf, np.inf]
        for run in runs[name]:
            _side(run.work)
    for _ in range(repetitions):
        for name, pair in runs.items():
            least[name] = [min(time, _side(run.work)) for time, run in zip(least[name], pair, strict=True)]
    return [(name, *times) for name, times in least.items()]


def measure(repetitions: int = ROUNDS) -> list[tuple[str, float, float]]:
    """Return name, time of a right-hand side and of the law alone (s) of every law."""
    joints = {law: (law, None) for law in LAWS} | {f"{law} with fractal": (law, FRACTAL) for law in ROUGH}
    runs, terms, least = {}, {}, {name: [np.inf, np.inf] for name in joints}
    for name, (law, roughness) in joints.items():
        rough = {"roughness": roughness} if roughness else {}
        scene = scene_of({"contact": STEEL | {"elastic": law}} | rough, "seated")
        runs[name], terms[name] = Run(start_of(scene, np.empty(0))), scene.value.joints[0].elastic
        print(f"compiling {name}", file=sys.stderr, flush=True)
        _timed(runs[name].work, terms[name])
    for _ in range(repetitions):
        for name in joints:
            least[name] = [min(pair) for pair in zip(least[name], _timed(runs[name].work, terms[name]), strict=True)]
    return [(name, *times) for name, times in least.items()]


def _side(work, times: int = EVALUATIONS) -> float:
    """Return the time (s) of a right-hand side, of so many."""
    kept = Pinned(Evaluated(*(getattr(work, name) for name in Evaluated._fields)))
    ARRAYS[:] = [kept]
    where = np.array([*work.rates, kept.address])
    begin = time.perf_counter()
    _right_hand_sides(where, times)
    return (time.perf_counter() - begin) / times


def _timed(work, term) -> tuple[float, float]:
    """Return the time (s) of a right-hand side and of the law."""
    side, begin = _side(work), time.perf_counter()
    for _ in range(5):
        _forces(term, DEPTHS)
    return side, (time.perf_counter() - begin) / (5 * len(DEPTHS))


def text(
    rows: list[tuple[str, float, float]],
    joints: list[tuple[str, float]],
    both: dict[str, dict[str, float]],
    shapes: list[tuple[str, float, float]],
) -> str:
    """Return the page."""
    whole = {name: side for name, side, _ in rows}
    lines = [
        "# Cost of elastic laws and of kinds of joints",
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
    lines += [
        "",
        "A right-hand side after a tenth of a turn.",
        "",
        "| joint | right-hand side, ns | over `dry` |",
        "| --- | --- | --- |",
    ]
    dry = dict(joints)["dry"]
    lines += [f"| {name} | {1e9 * side:.0f} | {side / dry:.2f} |" for name, side in joints]
    lines += [
        "",
        "In space, the first case of `configs/spatial_slider_crank.yaml`, and in the plane with the same joint, apart",
        f"and pressed (at both walls), the least of {20 * ROUNDS} rounds of {BRIEF:,} evaluations.",
        "",
        "| contacts | plane, ns | space, ns | ratio |",
        "| --- | --- | --- | --- |",
    ]
    for state, times in both.items():
        plane, space = times["plane"], times["space"]
        lines.append(f"| {state} | {1e9 * plane:.0f} | {1e9 * space:.0f} | {space / plane:.2f} |")
    lines += [
        "",
        "A pressed joint whose worn shape acts (`wear.evolve`), worn by up to a quarter of its clearance before.",
        "",
        "| where the force acts | circles, ns | worn, ns | over circles |",
        "| --- | --- | --- | --- |",
    ]
    lines += [f"| {name} | {1e9 * new:.0f} | {1e9 * old:.0f} | {old / new:.2f} |" for name, new, old in shapes]
    return "\n".join([*lines, ""])


def main() -> None:
    """Measure, print, and write the page where asked."""
    reader = argparse.ArgumentParser(description=__doc__)
    reader.add_argument("--write", action="store_true", help=f"write {PAGE.name}")
    asked = reader.parse_args()
    page = text(measure(), kinds(), spaces(), worn())
    print(page)
    if asked.write:
        PAGE.write_text(page, encoding="utf-8")


if __name__ == "__main__":
    main()
