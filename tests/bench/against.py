"""Measures sweeps by this checkout beside another commit's, taking turns: `make bench AGAINST=TREE`.

TREE is a checkout of the other commit (`git worktree add TREE COMMIT`). Each has a process of its own, in which it runs
`configs/thousand_cases.yaml` and two like it, without workers; processor time of the whole sweep, files and merging
included, compilation excluded, least of several rounds.
"""

import argparse
import copy
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import speed_page

ROOT = Path(__file__).parents[2]
FRICTION = {"law": "ambrosio", "coefficient": 0.05, "v0": "1 mm/s", "v1": "10 mm/s"}
ASKED = {"thousand_cases": 0.25, "with friction": 0.25, "with two joints": 0.4}
SPEEDS = {"linspace": ["1000 rpm", "5000 rpm", 4]}  # of the two others: 400 cases


def grids() -> dict[str, dict]:
    """Return the grids that are swept, by name."""
    from ruamel.yaml import YAML

    plain = YAML(typ="safe").load(ROOT / "configs" / "thousand_cases.yaml")
    few = copy.deepcopy(plain)
    few["sweep"]["drive.speed"] = SPEEDS
    rubbing, two = copy.deepcopy(few), copy.deepcopy(few)
    rubbing["joints"]["rod-slider"]["friction"] = FRICTION
    two["joints"]["crank-rod"] = copy.deepcopy(two["joints"]["rod-slider"])
    return {"thousand_cases": plain, "with friction": rubbing, "with two joints": two}


def serve() -> None:
    """Sweep grids as they come on stdin, a line of JSON each; answer with cases, failures and processor time (s)."""
    import clearsweep

    answers, sys.stdout = sys.stdout, sys.stderr
    for line in sys.stdin:
        with tempfile.TemporaryDirectory() as place:
            began = time.process_time()
            result = clearsweep.sweep(json.loads(line), place, executor="serial", show_progress=False)
            spent = time.process_time() - began
        print(json.dumps([result.ran, result.failed, spent]), file=answers, flush=True)


class Tree:
    """A checkout, and the process that runs its code."""

    def __init__(self, root: Path):
        paths = os.pathsep.join([str(root), str(ROOT / "tests")])
        self.process = subprocess.Popen(
            [sys.executable, "-c", "from bench import against; against.serve()"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            env=os.environ | {"PYTHONPATH": paths},
        )
        named = ["git", "-C", str(root), "describe", "--always", "--dirty", "--abbrev=8"]
        self.name = subprocess.run(named, capture_output=True, text=True, check=False).stdout.strip() or "unknown"

    def sweep(self, source: dict) -> tuple[int, int, float]:
        """Return cases, those that failed and the processor time (s) of a sweep."""
        print(json.dumps(source), file=self.process.stdin, flush=True)
        answer = self.process.stdout.readline()
        if not answer:
            raise SystemExit(f"against: {self.name}: the sweep ended early, see above")
        return tuple(json.loads(answer))


def table(other: Path, rounds: int) -> str:
    """Return what each grid takes with both checkouts."""
    trees = [Tree(ROOT), Tree(other)]
    lines = [
        f"{trees[0].name} against {trees[1].name}, load {os.getloadavg()[0]:.1f} before; ms of processor time per",
        f"case, the whole sweep in one process, least of {rounds} interleaved rounds, compilation excluded.",
        "",
        "| sweep | cases | failed, of either | this | other | this / other | asked |",
        "| --- | --- | --- | --- | --- | --- | --- |",
    ]
    for name, source in grids().items():
        small = copy.deepcopy(source)
        small["sweep"]["drive.speed"] = ["1000 rpm"]
        for tree in trees:
            tree.sweep(small)  # compiles
        runs = [[tree.sweep(source) for tree in trees] for _ in range(rounds)]
        cases, failed = runs[0][0][0], tuple(found[1] for found in runs[0])
        each = [1e3 * min(run[place][2] for run in runs) / cases for place in range(2)]
        lines.append(
            f"| {name} | {cases} | {failed[0]}, {failed[1]} | {each[0]:.3f} | {each[1]:.3f} | {each[0] / each[1]:.3f} "
            f"| {ASKED[name]} |"
        )
    for tree in trees:
        tree.process.stdin.close()
        tree.process.wait()
    return "\n".join(lines)


def main() -> None:
    """Print the table, and write it where asked."""
    parser = argparse.ArgumentParser(prog="python -m bench.against", description=__doc__.splitlines()[0])
    parser.add_argument("tree", type=Path, help="a checkout of the other commit")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--write", action="store_true", help="write results/speed.md too")
    asked = parser.parse_args()
    text = f"## Against another commit\n\n{table(asked.tree.resolve(), asked.rounds)}\n"
    print(text)
    if asked.write:
        speed_page.write("two commits", text)


if __name__ == "__main__":
    main()
