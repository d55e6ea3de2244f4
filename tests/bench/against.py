"""Measures sweeps by this checkout compared with another commit's, taking turns: `make bench AGAINST=TREE`.

TREE is a checkout of the other commit (`git worktree add TREE COMMIT`). Each has a process of its own, in which it runs
`configs/thousand_cases.yaml` and two like it, without workers: processor time, least of several rounds, files and
merging included.  What a sweep of FEW^3 cases takes is taken off as start-up; compilation is over before.

A commit from before `contact.onset` knows its value `first` alone, so that by default the two integrate different
motions: with two joints this one meets 34 to 41 impacts a revolution in place of 18 to 23.  With --first this checkout
integrates the motion that such a commit does.

With --files it measures `clearsweep run` of every grid of `configs/` instead, start-up, files and merging included.
With --named NAME,NAME only these of its files.  With --readme it measures the README's grid, with its own number of
cases and with ten times as many speeds.
"""

import argparse
import copy
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import speed_page

ROOT = Path(__file__).parents[2]
FRICTION = {"law": "ambrosio", "coefficient": 0.05, "v0": "1 mm/s", "v1": "10 mm/s"}
ASKED = {"thousand_cases": 0.25, "with friction": 0.25, "with two joints": 0.4}
ASKED_README = 0.25, 0.35
SPEEDS = 4  # of the two others: 400 cases
MOST = 1.03  # times the other's processor time that a command on a file of configs/ may take
SOME_FAILED = 3  # exit code of a run with failed cases
FEW = 4  # values on each axis of a sweep that is taken for the start-up of the others


def grids() -> dict[str, dict]:
    """Return the grids that are swept, by name."""
    from ruamel.yaml import YAML

    plain = YAML(typ="safe").load(ROOT / "configs" / "thousand_cases.yaml")
    rubbing, two = (thinned(plain, {"drive.speed": SPEEDS}) for _ in range(2))
    rubbing["joints"]["rod-slider"]["friction"] = FRICTION
    two["joints"]["crank-rod"] = copy.deepcopy(two["joints"]["rod-slider"])
    return {"thousand_cases": plain, "with friction": rubbing, "with two joints": two}


def thinned(source: dict, counts: dict[str, int]) -> dict:
    """Return a grid with so many values on the axes named."""
    result = copy.deepcopy(source)
    for path, count in counts.items():
        result["sweep"][path]["linspace"][2] = count
    return result


def with_first_onset(source: dict) -> dict:
    """Return a grid whose contacts go by the rate of their first touch throughout."""
    result = copy.deepcopy(source)
    for joint in result["joints"].values():
        joint["contact"]["onset"] = "first"
    return result


def serve() -> None:
    """Run grids as they come on stdin, a line of JSON each; answer each with what it took."""
    answers, sys.stdout = sys.stdout, sys.stderr
    for line in sys.stdin:
        asked = json.loads(line)
        print(json.dumps(swept(asked)), file=answers, flush=True)


def swept(source: dict) -> tuple[int, int, float, float]:
    """Return cases, failures and processor time (s) of a sweep, and of its repetition, in which no case runs."""
    import clearsweep

    with tempfile.TemporaryDirectory() as place:
        began = time.process_time()
        result = clearsweep.sweep(source, place, executor="serial", show_progress=False)
        spent, began = time.process_time() - began, time.process_time()
        clearsweep.sweep(source, place, executor="serial", show_progress=False)
        return result.ran, result.failed, spent, time.process_time() - began


def name_of(root: Path) -> str:
    """Return the commit of a checkout."""
    named = ["git", "-C", str(root), "describe", "--always", "--dirty", "--abbrev=8"]
    return subprocess.run(named, capture_output=True, text=True, check=False).stdout.strip() or "unknown"


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
            cwd=root,  # what is imported comes from there first
        )
        self.name = name_of(root)

    def sweep(self, source: dict) -> tuple[int, int, float]:
        """Return cases, those that failed and the processor time (s) of a grid."""
        print(json.dumps(source), file=self.process.stdin, flush=True)
        answer = self.process.stdout.readline()
        if not answer:
            raise SystemExit(f"against: {self.name}: the sweep ended early, see above")
        return tuple(json.loads(answer))


def table(other: Path, repetitions: int, *, first: bool) -> str:
    """Return what each grid takes with both checkouts; `first`: this one with the onset that old ones have."""
    trees = [Tree(ROOT), Tree(other)]
    lines = [
        f"{trees[0].name} against {trees[1].name}, load {os.getloadavg()[0]:.1f} before; ms of processor time per",
        f"case, start-up of a sweep taken off, in one process, least of {repetitions} interleaved rounds.",
        *(["This one with `contact.onset: first`, the motion of commits that do not know that key."] if first else []),
        "",
        "| sweep | cases | failed, of either | this | other | this / other | with start-up | asked |",
        "| --- | --- | --- | --- | --- | --- | --- | --- |",
    ]
    for name, source in grids().items():
        few = thinned(source, dict.fromkeys(source["sweep"], FEW))
        pairs = [(with_first_onset(grid) if first else grid, grid) for grid in (source, few)]
        for tree, grid in zip(trees, pairs[1], strict=True):
            tree.sweep(grid)  # compiles
        runs = [
            [tree.sweep(grid) for pair in pairs for tree, grid in zip(trees, pair, strict=True)]
            for _ in range(repetitions)
        ]
        (cases, failed, *_), (_, others, *_), (less, *_), _ = runs[0]
        whole, start = np.min([[took for _, _, took, _ in run] for run in runs], axis=0).reshape(2, 2)
        each = 1e3 * (whole - start) / (cases - less)
        lines.append(
            f"| {name} | {cases} | {failed}, {others} | {each[0]:.3f} | {each[1]:.3f} | {each[0] / each[1]:.3f} "
            f"| {whole[0] / whole[1]:.3f} | {ASKED[name]} |"
        )
    for tree in trees:
        tree.process.stdin.close()
        tree.process.wait()
    return "\n".join(lines)


def table_of_readme(other: Path, repeats: int) -> str:
    """Return what a case of the README's grid takes with both checkouts, start-up taken off."""
    from ruamel.yaml import YAML

    trees = [Tree(ROOT), Tree(other)]
    plain = YAML(typ="safe").load(ROOT / "configs" / "slider_crank_restitution.yaml")
    many = thinned(plain, {"drive.speed": 10 * plain["sweep"]["drive.speed"]["linspace"][2]})
    for tree in trees:
        tree.sweep(plain)  # compiles
    runs = [[tree.sweep(grid) for grid in (plain, many) for tree in trees] for _ in range(repeats)]
    (few, failed, *_), (_, others, *_), (cases, *_), _ = runs[0]
    spent, idle = np.min([[took[2:] for took in run] for run in runs], axis=0).reshape(2, 2, 2).transpose(2, 0, 1)
    own = 1e3 * (spent[0] - idle[0]) / few
    further = 1e3 * (spent[1] - spent[0]) / (cases - few)
    for tree in trees:
        tree.process.stdin.close()
        tree.process.wait()
    return "\n".join(
        [
            f"{trees[0].name} against {trees[1].name}, load {os.getloadavg()[0]:.1f} after; ms of processor time per",
            f"case in one process, files and merging included, least of {repeats} interleaved rounds.",
            "",
            "| README's grid | failed, of either | this | other | this / other | asked |",
            "| --- | --- | --- | --- | --- | --- |",
            f"| {cases} cases, a sweep of {few} taken off | {failed}, {others} | {further[0]:.2f} | {further[1]:.2f} "
            f"| {further[0] / further[1]:.3f} | {ASKED_README[0]} |",
            f"| {few} cases, a run in which none runs taken off | {failed}, {others} | {own[0]:.2f} | {own[1]:.2f} "
            f"| {own[0] / own[1]:.3f} | {ASKED_README[1]} |",
        ]
    )


def table_of_files(other: Path, repetitions: int, named: list[str]) -> str:
    """Return what `clearsweep run FILE` takes with both checkouts: of all that both have, or those `named`."""
    trees = [ROOT, other]
    lines = [
        f"{name_of(ROOT)} against {name_of(other)}, load {os.getloadavg()[0]:.1f} before; processor time (s) of",
        f"`clearsweep run FILE --jobs 1`, all processes, least of {repetitions} interleaved rounds after one that",
        "compiles; both run the file of the other.",
        "",
        "| file | this, s | other, s | this / other | |",
        "| --- | --- | --- | --- | --- |",
    ]
    with tempfile.TemporaryDirectory() as place:
        for path in sorted((ROOT / "configs").glob("*.yaml")):
            file = other / "configs" / path.name
            if (named and path.stem not in named) or not file.exists():
                continue
            seconds = [[commanded(tree, file, place) for tree in trees] for _ in range(repetitions + 1)]
            this, that = np.min(seconds[1:], axis=0)
            verdict = "" if this <= MOST * that else f"more than {MOST:g}"
            lines.append(f"| {path.stem} | {this:.2f} | {that:.2f} | {this / that:.2f} | {verdict} |")
            print(lines[-1], file=sys.stderr, flush=True)
    return "\n".join(lines)


def commanded(tree: Path, file: Path, place: str) -> float:
    """Return the processor time (s) of a run of a grid by a checkout, with its cache in `place`."""
    environment = os.environ | {"PYTHONPATH": str(tree), "CLEARSWEEP_CACHE_DIR": f"{place}/cache{tree.name}"}
    with tempfile.TemporaryDirectory(dir=place) as out:
        command = [sys.executable, "-m", "clearsweep", "run", str(file), "--jobs", "1", "--out", out]
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        done = subprocess.run(command, env=environment, cwd=place, capture_output=True, text=True, check=False)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode not in (0, SOME_FAILED):
        raise SystemExit(f"against: {file} by {tree}: {done.stderr}")
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main() -> None:
    """Print the table, and write it where asked."""
    parser = argparse.ArgumentParser(prog="python -m bench.against", description=__doc__.splitlines()[0])
    parser.add_argument("tree", type=Path, help="a checkout of the other commit")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--first", action="store_true", help="this checkout with `contact.onset: first`, too")
    parser.add_argument("--files", action="store_true", help="a run of every file of configs/ instead")
    parser.add_argument("--named", type=lambda text: text.split(","), default=[], help="only these files")
    parser.add_argument("--readme", action="store_true", help="the README's grid instead")
    parser.add_argument("--write", action="store_true", help="write results/speed.md too")
    asked = parser.parse_args()
    tree, repeats = asked.tree.resolve(), asked.rounds
    if asked.readme:
        text = f"## The README's grid against another commit\n\n{table_of_readme(tree, repeats)}"
        print(text)
        if asked.write:
            speed_page.write("README of two commits", f"{text}\n")
        return
    if asked.files or asked.named:
        rows = table_of_files(tree, repeats, asked.named)
        text = f"## Every file of configs/ against another commit\n\n{rows}"
        print(text)
        if asked.write and not asked.named:
            speed_page.write("files of two commits", f"{text}\n")
        return
    tables = [table(tree, repeats, first=first) for first in (False, True)[: 1 + asked.first]]
    text = "\n\n".join(["## Against another commit", *tables]) + "\n"
    print(text)
    if asked.write:
        speed_page.write("two commits", text)


if __name__ == "__main__":
    main()
