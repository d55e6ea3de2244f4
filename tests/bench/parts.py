"""What parts of a case cost, with the case without them: onset rates that end, wear."""

import copy
import time
from typing import NamedTuple

import numpy as np

import clearsweep
from clearsweep.simulation.running.run import Run
from clearsweep.simulation.setup.start import control_of, period, start_of
from clearsweep.verify.accuracy import FLAGSHIP, all_problems

WEAR = {"JOINTS.length": 0.02, "JOINTS.wear": {"law": "archard", "coefficient": 2e-14}}


class Pair(NamedTuple):
    """A problem changed in one thing, compared with the problem as it is."""

    name: str
    problem: str
    changes: dict  # dotted path below the grid, `JOINTS` for every joint -> value
    each: bool  # compared by evaluation, not by case


PAIRS = (
    Pair("onset renewed over first", FLAGSHIP, {"JOINTS.contact.onset": "renewed"}, each=True),
    Pair("wear in 360 bins over none", FLAGSHIP, WEAR | {"JOINTS.wear.bins": 360}, each=False),
    Pair("wear in 100,000 bins over none", FLAGSHIP, WEAR | {"JOINTS.wear.bins": 100_000}, each=False),
)


def measure(repetitions: int, note) -> list[dict]:
    """Return name, ns of an evaluation or ms of a revolution with and without, and their ratio, of all PAIRS."""
    known, rows = {problem.name: problem for problem in all_problems()}, []
    for pair in PAIRS:
        note(f"parts: {pair.name}")
        grid = known[pair.problem].grid
        scenes = [clearsweep.load_case(changed(grid, changes)) for changes in (pair.changes, {})]
        times = [[spent(scene, each=pair.each) for scene in scenes] for _ in range(repetitions + 1)]
        with_it, without = np.min(times[1:], axis=0).tolist()  # the first round compiles
        rows.append({"name": pair.name, "each": pair.each, "with": with_it, "without": without})
    return rows


def changed(grid: dict, changes: dict) -> dict:
    """Return a grid with values put at dotted paths."""
    made = copy.deepcopy(grid)
    made["joints"] = {name: copy.deepcopy(joint) for name, joint in made["joints"].items()}
    for path, value in changes.items():
        first, *middle, last = path.split(".")
        for section in made["joints"].values() if first == "JOINTS" else [made[first]]:
            here = section
            for key in middle:
                here = here[key]
            here[last] = copy.deepcopy(value)
    return made


def spent(scene, *, each: bool) -> float:
    """Return the processor time (s) of an integration, of one evaluation of it where `each`."""
    run, end = Run(start_of(scene, np.empty(0))), scene.case.simulate.revolutions * period(scene)
    control = control_of(scene, end, keep_events=False)
    began = time.process_time()
    run.advance(control)
    took = time.process_time() - began
    return took / run.work.counts.evaluations if each else took / scene.case.simulate.revolutions


def lines(rows: list[dict]) -> list[str]:
    """Return the table."""
    text = ["What parts of a case cost, integrating:", f"  {'':<44}{'with':>12}{'without':>12}{'ratio':>8}"]
    for row in rows:
        scale, unit = (1e9, "ns/rhs") if row["each"] else (1e3, "ms/rev")
        cells = "".join(f"{f'{scale * row[key]:.3g} {unit}':>14}" for key in ("with", "without"))
        text.append(f"  {row['name']:<42}{cells}{row['with'] / row['without']:>8.2f}")
    return text
