"""Kills sweeps with -9 at random moments, resumes them, and compares the results with an undisturbed run."""

import contextlib
import json
import os
import random
import signal
import subprocess
import sys
import time
from collections import Counter
from pathlib import Path

import h5py
import numpy as np
import psutil
import pyarrow as pa
import pyarrow.parquet as pq
from right_grids import grid_of

from clearsweep.contracts.results import TIMINGS

ROOT = Path(__file__).parent.parent
GRID = grid_of("a crank that is tortured")
JOINT = GRID["joints"]["rod-slider"]
#: Cases in many blocks, of some tenths of a second each.
LIVES = GRID | {
    "name": "lives",
    "joints": {"rod-slider": JOINT | {"wear": JOINT["wear"] | {"evolve": True}}},
    "simulate": {"revolutions": 40, "discard": 2, "tolerance": 1e-7},
    "life": {"limit": "50 um", "joint": "rod-slider", "max_revolutions": 60, "longest_jump": 1000},
    "sweep": {"joints.rod-slider.clearance": {"linspace": ["0.2 mm", "0.5 mm", 4]}},
}


class Round:
    """One directory, killed and resumed until its run is complete."""

    grace = 5.0  # s in which workers end after their parent

    def __init__(self, start, out: Path, chance: random.Random, pause: tuple[float, float]):
        self.start, self.out, self.chance, self.pause = start, out, chance, pause
        self.kills = Counter()  # by victim
        self.committed = set()  # names of batches that were committed
        self.cases = set()  # in these
        self.longest = 0.0  # s between two commits of one parent

    def run(self, most: int) -> None:
        """Kill up to `most` times, resume each time, and let the rest run undisturbed."""
        process = self.start(self.out)
        while self.kills.total() < most and self._goes_on(process, self.chance.uniform(*self.pause)):
            family = psutil.Process(process.pid).children(recursive=True)
            kind = self.chance.choice(["parent", "one process", "all"])
            victims = {
                "parent": [process],
                "all": [process, *family],
                "one process": [self.chance.choice([process, *family])],
            }[kind]
            self.chance.shuffle(victims)
            for victim in victims:
                with contextlib.suppress(ProcessLookupError):
                    os.kill(victim.pid, signal.SIGKILL)
            self.kills[kind] += 1
            if process in victims:
                process.communicate()
                assert not (left := outliving(family, self.grace)), f"workers outlived their parent: {left}"
                self._look()
                process = self.start(self.out)
        while self._goes_on(process, 60.0):
            pass
        process.communicate()
        # a case that was at work in two killed workers is 'crashed' by rule, so it is asked for again
        last = self.start(self.out, retry_failed=True)
        text = last.communicate(timeout=300)
        assert last.returncode == 0, text

    def lost_cases(self) -> int:
        """Return the number of cases that were committed and are in no batch now."""
        return len(self.cases - set().union(*map(cases_of, batches(self.out))))

    def _look(self) -> bool:
        """Record the committed batches; return whether there are new ones."""
        with contextlib.suppress(FileNotFoundError):
            paths = batches(self.out) - self.committed
            for path in paths:  # a merge may have replaced one of them meanwhile: its cases are then in another
                with contextlib.suppress(FileNotFoundError):
                    self.cases |= cases_of(path)
            self.committed |= paths
            return bool(paths)
        return False

    def _goes_on(self, process, seconds: float) -> bool:
        """Watch a run for `seconds`; return whether it is still running."""
        end, before = time.monotonic() + seconds, None
        while process.poll() is None and (now := time.monotonic()) < end:
            if self._look():
                self.longest = max(self.longest, now - (before or now))
                before = now
            time.sleep(0.01)
        return process.poll() is None


def batches(directory: Path) -> set[Path]:
    """Return the files of all committed batches, including those of blocks."""
    folders = [directory / "parts", *directory.glob("blocks/*/parts")]
    return {folder / name for folder in folders if folder.is_dir() for name in os.listdir(folder)}


def cases_of(path: Path) -> set[str]:
    """Return the identities of the cases in a batch."""
    return set(pq.read_table(path, columns=["case_id"])["case_id"].to_pylist())


def tables_of(directory: Path) -> list[Path]:
    """Return the files of the summary: one, or one of each block."""
    return sorted(directory.glob("summary/*.parquet")) or [directory / "summary.parquet"]


def orbits_of(directory: Path) -> list[Path]:
    """Return the files of the orbits: one, or one of each block."""
    return sorted(directory.glob("blocks/*/orbits.h5")) or [directory / "orbits.h5"]


def outliving(family: list[psutil.Process], seconds: float) -> list[str]:
    """Return descriptions of processes still running after `seconds`; one that waits to be reaped does not count."""
    left = []
    for process in psutil.wait_procs(family, timeout=seconds)[1]:
        with contextlib.suppress(psutil.NoSuchProcess):
            if process.status() != psutil.STATUS_ZOMBIE:
                left.append(f"{process.status()} {process.cpu_times().user:.1f} s {' '.join(process.cmdline())}")
    return left


def torture(start, folder: Path, kills: int, seed: int, pause: tuple[float, float]) -> list[Round]:
    """Return the rounds in which `kills` processes were killed; `start(out, **options)` starts a sweep as a program."""
    repetitions, chance = [], random.Random(seed)
    while (done := sum(each.kills.total() for each in repetitions)) < kills:
        repetitions.append(Round(start, folder / f"round{len(repetitions) + 1}", chance, pause))
        repetitions[-1].run(kills - done)
    return repetitions


def differences(single: Path, other: Path) -> dict[str, int]:
    """Return the differences of two runs: rows and values missing or different in the second, without timings."""
    tables = [pa.concat_tables(map(pq.read_table, tables_of(path))) for path in (single, other)]
    tables = [table.drop_columns(sorted(TIMINGS.intersection(table.column_names))) for table in tables]
    rows = [{row["case_id"]: row for row in table.to_pylist()} for table in tables]
    result = {
        "rows": len(rows[0]),
        "rows lost": len(rows[0].keys() - rows[1].keys()),
        "rows differing": sum(rows[1].get(name, row) != row for name, row in rows[0].items()),
        "rows too many": len(tables[1]) - len(tables[0]),
        "values": 0,
        "values differing": 0,
    }
    if tables[0].schema != tables[1].schema:
        result["rows differing"] = len(tables[0])
    for here, there in zip(orbits_of(single), orbits_of(other), strict=True):
        _compare_orbits(here, there, result)
    return result


def _compare_orbits(single: Path, other: Path, result: dict[str, int]) -> None:
    """Add the differences of two files of orbits to the counts of `differences`."""
    with h5py.File(single, "r") as first, h5py.File(other, "r") as second:
        names = [[], []]
        for file, contents in ((first, names[0]), (second, names[1])):
            file.visititems(
                lambda name, item, contents=contents: contents.append(name) if isinstance(item, h5py.Dataset) else None
            )
        for name in set(names[0]) | set(names[1]):
            here, there = (file[name][:] if name in file else np.empty(0) for file in (first, second))
            result["values"] += here.size
            same = here.tobytes() == there.tobytes()
            result["values differing"] += 0 if same else max(here.size, there.size, 1)


def same(result: dict[str, int]) -> bool:
    """Return whether differences() found none."""
    return not any(count for name, count in result.items() if name not in ("rows", "values"))


#: The command line, with the number of cases per block as its first argument.
CUT = "import sys; from clearsweep.store import blocks; blocks.BLOCK = int(sys.argv.pop(1)); import clearsweep.cli as c"
CUT += "; sys.exit(c.main())"


def starter(folder: Path, grid: dict = GRID, block: int = 0):
    """Write a grid into a folder and return a function that starts its run, with two workers, as a program.

    block : cases per block; 0: the default.
    """
    program = ["-c", CUT, str(block)] if block else ["-m", "clearsweep"]
    (folder / "grid.yaml").write_text(json.dumps(grid), encoding="utf-8")

    def start(out, retry_failed=False):
        command = [sys.executable, *program, "run", folder / "grid.yaml", "--out", out, "-j", "2"]
        return subprocess.Popen(
            command + ["--retry-failed"] * retry_failed,
            env=os.environ | {"PYTHONPATH": str(ROOT)},
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )

    return start


def kills_text(counts: dict[str, int]) -> str:
    """Return counts as '3 parent, 2 all'."""
    return ", ".join(f"{count:,} {name}" for name, count in counts.items())
