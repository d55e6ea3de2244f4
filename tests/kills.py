"""Kills `optimise` and `identify` with -9 at random moments, resumes them, and compares the answers with undisturbed
ones.

    python tests/kills.py                          # 100 kills of each
    python tests/kills.py --kills 20 --of identify --seed 2

optimise.parquet and identify.parquet must be identical bytes; summaries and histories are equal except for times.

"""

import argparse
import json
import random
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

import optima
import rigs
import torture

SHORTEST_PAUSE = 0.5  # s between two kills
OUT = Path("results/inverse/kills.jsonl")
GRACE = 60.0  # s in which workers end after their parent: they may have to load first, and the machine may be busy
FILES = {"optimise": "optimise.parquet", "identify": "identify.parquet"}


def optimise():
    """Return a grid that optimises two objectives."""
    problem = optima.PROBLEMS["front"]
    over = {path: [low, high] for path, (low, high, *_) in problem["over"].items()}
    return optima.grid_of(problem, optimise={"over": over, "minimise": problem["minimise"], "cases": 160})


def identify():
    """Return a grid that identifies clearance and friction of the rig of configs/rig.yaml."""
    section = {
        "over": {rigs.CLEARANCE: ["20 um", "300 um"], rigs.KEYS[3]: [0.002, 0.1]},
        "from": {str(rigs.GRID.with_name("rig.csv")): {"slider/a": "acceleration"}},
        "cases": 64,
    }
    return rigs.base() | {"identify": section}


GRIDS = {"optimise": optimise, "identify": identify}


def killed(name, kills, seed, longest_pause):
    """Kill the run of a grid `kills` times; return the victims, and the trials with any difference."""
    with tempfile.TemporaryDirectory() as folder:
        start = torture.starter(Path(folder), GRIDS[name]())
        undisturbed = Path(folder) / "undisturbed"
        assert start(undisturbed).wait() == 0
        answer, wrong, victims, trials = (undisturbed / FILES[name]).read_bytes(), [], Counter(), 0
        chance, begin = random.Random(seed), time.monotonic()
        while victims.total() < kills:
            trials += 1
            trial = torture.Round(start, Path(folder) / f"run{trials}", chance, (SHORTEST_PAUSE, longest_pause))
            trial.grace = GRACE
            trial.run(kills - victims.total())
            victims += trial.kills
            differences = torture.differences(undisturbed, trial.out)
            if (trial.out / FILES[name]).read_bytes() != answer:
                wrong.append(f"run {trials}: {FILES[name]} has other bytes")
            if not torture.same(differences) or trial.lost_cases():
                wrong.append(f"run {trials}: {differences}, {trial.lost_cases()} cases lost")
            counts = ", ".join(f"{count} {kind}" for kind, count in victims.items())
            print(f"{name}: {counts} killed in {trials} runs, {time.monotonic() - begin:.0f} s", flush=True)
        row = {"of": name, "seed": seed, "kills": dict(victims), "runs": trials, "wrong": wrong}
        OUT.parent.mkdir(parents=True, exist_ok=True)
        with OUT.open("a", encoding="utf-8") as lines:
            lines.write(json.dumps(row) + "\n")
        return wrong


def main():
    """Kill, compare, and print differences; the exit code is 1 if there are any."""
    reader = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    reader.add_argument("--kills", type=int, default=100)
    reader.add_argument("--seed", type=int, default=1)
    reader.add_argument("--pause", type=float, default=8.0, help="s between two kills at most: a start takes two")
    reader.add_argument("--of", choices=GRIDS, action="append")
    asked = reader.parse_args()
    wrong = [line for name in asked.of or GRIDS for line in killed(name, asked.kills, asked.seed, asked.pause)]
    print("\n".join(wrong) or "every answer has the bytes of an undisturbed run, every case its values")
    return bool(wrong)


if __name__ == "__main__":
    sys.exit(main())
