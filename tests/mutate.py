"""Mutates code that determines numbers as mutations.txt says, one place at a time in a copy; its tests must then fail.

`python tests/mutate.py [WORD ...]` runs the mutations whose file, function or pattern contains one of the words, by
default all; the exit code is 1 if one survives or no longer applies.  The tests run with the compiler off, because a
changed kernel would be compiled anew each time.
"""

import argparse
import ast
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parent.parent
SLOWEST = 300.0  # s for the tests of one mutation; more is taken for a loop without an end, which a test run would show


class Mutation(NamedTuple):
    """A pattern that is once in a function or constant, its replacement, and tests of which one must then fail."""

    file: str
    where: str  # name of the function, method (`Class.method`) or constant, or `family.member(Type)` of a lambda
    old: str  # Python; line breaks, spaces and a comma before a closing bracket need not be those of the file
    new: str
    tests: str  # arguments of pytest

    def applied(self, source: str) -> str:
        """Return the mutated text of the file; LookupError says why the mutation no longer applies."""
        sections = [section for name, section in named(ast.parse(source)) if name == self.where]
        if len(sections) != 1:
            raise LookupError(f"{self.where} is there {len(sections)} times")
        lines = source.splitlines(keepends=True)
        first, last = sections[0]
        head, body, tail = ("".join(part) for part in (lines[: first - 1], lines[first - 1 : last], lines[last:]))
        changed, count = pattern(self.old).subn(lambda _: self.new, body)
        if count != 1:
            raise LookupError(f"{self.where} has the pattern {count} times")
        return head + changed + tail


def named(tree: ast.Module | ast.ClassDef, prefix: str = "") -> Iterator[tuple[str, tuple[int, int]]]:
    """Yield (name, (first line, last line)) of every function, method, constant and registered lambda of a module."""
    for node in tree.body:
        lines = node.lineno, node.end_lineno or node.lineno
        if isinstance(node, ast.FunctionDef):
            yield prefix + node.name, lines
        elif isinstance(node, ast.ClassDef):
            yield from named(node, f"{prefix}{node.name}.")
        elif isinstance(node, ast.Assign | ast.AnnAssign):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            for name in (part.id for target in targets for part in ast.walk(target) if isinstance(part, ast.Name)):
                yield prefix + name, lines
        elif isinstance(node, ast.Expr) and isinstance(node.value, ast.Call):
            yield ast.unparse(node.value.func), lines


def pattern(text: str) -> re.Pattern[str]:
    """Return what matches `text` however the formatter breaks its lines, and only whole words and numbers of it."""
    tokens = re.findall(r"\w+|\S", text)
    parts = [rf",?\s*{re.escape(token)}" if token in ")]}" else re.escape(token) for token in tokens]
    begin = r"\b" if re.match(r"\w", tokens[0]) else ""
    end = r"\b" if re.match(r"\w", tokens[-1]) else ""
    return re.compile(begin + r"\s*".join(parts) + end)


def read_mutations(text: str) -> list[Mutation]:
    """Return the mutations of a table.

    Below a file of the package are its tests, indented, and below these a line `where: old => new` per mutation.
    """
    mutations, file, tests = [], "", ""
    for line in text.splitlines():
        depth = len(line) - len(line.lstrip())
        if depth == 4:
            where, _, change = line.strip().partition(": ")
            old, _, new = change.partition(" =>")
            mutations.append(Mutation(file, where, old, new.strip(), tests))
        elif depth == 2:
            tests = line.strip()
        elif line:
            file = line
    return mutations


MUTATIONS = read_mutations((ROOT / "tests" / "mutations.txt").read_text(encoding="utf-8"))


def run(place: Path, tests: str) -> int:
    """Return how pytest ended, started in `place` without the compiler."""
    environment = {
        **os.environ,
        "CLEARSWEEP_DISABLE_JIT": "1",
        "PYTHONPATH": str(place),
        "PYTHONDONTWRITEBYTECODE": "1",
    }
    words = [word.strip("'") for word in tests.split(" ", 2)]
    command = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", "-m", "not slow and not compiled"]
    try:
        done = subprocess.run(
            [*command, *words], cwd=place, env=environment, capture_output=True, check=False, timeout=SLOWEST
        )
    except subprocess.TimeoutExpired:
        return 1
    return done.returncode


def spoiled(place: Path, mutation: Mutation) -> str:
    """Return what became of one mutation: 'killed', or what is wrong."""
    file = place / "clearsweep" / mutation.file
    try:
        whole = file.read_text(encoding="utf-8")
        changed = mutation.applied(whole)
    except (LookupError, OSError) as error:
        return f"NO LONGER APPLIES: {error}"
    file.write_text(changed, encoding="utf-8")
    try:
        code = run(place, mutation.tests)
    finally:
        file.write_text(whole, encoding="utf-8")
    return {0: "SURVIVES", 1: "killed"}.get(code, f"CANNOT BE TESTED: pytest ended with {code}")


def main() -> int:
    """Run the mutations that are asked for, and report what became of them."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("words", nargs="*")
    words = parser.parse_args().words
    chosen = [
        first
        for first in MUTATIONS
        if not words or any(word in f"{first.file} {first.where} {first.old}" for word in words)
    ]
    bad = []
    with tempfile.TemporaryDirectory() as scratch:
        place = Path(scratch)
        for name in ("clearsweep", "tests", "configs"):
            shutil.copytree(ROOT / name, place / name, ignore=shutil.ignore_patterns("__pycache__"))
        for name in ("pyproject.toml", "README.md"):
            shutil.copy(ROOT / name, place)
        for tests in dict.fromkeys(mutation.tests for mutation in chosen):
            if code := run(place, tests):
                sys.exit(f"{tests}: fails without a mutation (pytest ended with {code})")
        for number, mutation in enumerate(chosen, 1):
            begin = time.perf_counter()
            outcome = spoiled(place, mutation)
            bad += [mutation] if outcome != "killed" else []
            took = time.perf_counter() - begin
            change = f"{mutation.file}: {mutation.where}: {mutation.old!r} -> {mutation.new!r}"
            print(f"{number:3}/{len(chosen)} {took:5.1f} s  {change}: {outcome}", flush=True)
    print(f"{len(chosen) - len(bad)} of {len(chosen)} mutations killed")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
