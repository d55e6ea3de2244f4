"""Exit codes: every command runs many times, unchanged and with threads that end late, with the specified exit code."""

import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import torture_attempts

HERE = Path(__file__).parent
SECONDS = 300.0  # time limit of one program, with others running
SERIES = "time [s],force [N],speed [m/s]\n0,100,0.1\n1,120,0.2\n2,110,0.1\n"
FROM_PYTHON = (
    "import sys, clearsweep as c; a = sys.argv; c.sweep(a[1], a[2], jobs=1, show_progress=False); "
    "run = c.open(a[2]); len(run.summary), run.column('status'); c.open('ok').summary"
)
#: A Parquet file that is pre-read through a Python file: this aborts if threads end late.
READS_AHEAD = (
    "import sys, pyarrow.parquet as q; q.ParquetFile(open(sys.argv[1], 'rb'), pre_buffer=True).read(['status'])"
)

#: The command line without its protected exit: the interpreter ends as for any program.
ENDS_AS_USUAL = "from clearsweep import cli; cli.main()"

Command = Callable[[str], list[str]]  # arguments of a program from a name that no other try has


def prepared(folder: Path) -> dict[str, Command]:
    """Prepare the inputs of all commands in `folder`, and return their programs by name."""
    environment = torture_attempts.prepared(folder)
    fresh = folder / "fresh"
    (fresh / "series.csv").write_text(SERIES)
    for part in (1, 2):
        command = [*_verb("run", "g.yaml", "--out", f"part{part}", "-j", "1", "--shard", f"{part}/2")]
        subprocess.run(command, cwd=fresh, env=environment, check=True, capture_output=True)
    case = next(fresh.glob("ok/parts/*.parquet"))
    case_id = subprocess.run(
        [sys.executable, "-c", f"import pyarrow.parquet as pq; print(pq.read_table({str(case)!r})['case_id'][0])"],
        check=True,
        capture_output=True,
        text=True,
    ).stdout.strip()

    def copied(name: str) -> str:
        return str(shutil.copytree(fresh / "ok", fresh / name))

    worn = ("series.csv", "--coefficient", "2e-14 m^2/N", "--area", "100 mm^2")
    return {
        "run": lambda name: _verb("run", "g.yaml", "--out", name, "-j", "1"),
        "run again": lambda name: _verb("run", "g.yaml", "--out", copied(name), "-j", "1"),
        "report": lambda name: _verb("report", "ok", "--out", f"{name}.html"),
        "status": lambda _: _verb("status", "ok", "--verify"),
        "show": lambda name: _verb("show", "ok", case_id, "--out", f"{name}.html"),
        "merge": lambda name: _verb("merge", "part1", "part2", "--out", name),
        "wear": lambda _: _verb("wear", *worn),
        "from Python": lambda name: [sys.executable, "-c", FROM_PYTHON, "g.yaml", name],
    }


def _as_usual(command: Command) -> Command:
    def ended(name: str) -> list[str]:
        python, *arguments = command(name)
        return [python, "-c", ENDS_AS_USUAL, *arguments[2:]] if arguments[0] == "-m" else [python, *arguments]

    return ended


def _verb(*arguments: str) -> list[str]:
    return [sys.executable, "-m", "clearsweep", *arguments]


def late_threads(folder: Path) -> dict[str, str]:
    """Compile the library that delays threads, and return the environment that loads it."""
    library = folder / "late_threads.so"
    source = HERE / "late_threads" / "late_threads.c"
    subprocess.run(
        ["cc", "-shared", "-fPIC", "-O1", "-o", library, source, "-ldl", "-lpthread"], check=True, capture_output=True
    )
    paths = os.pathsep.join([str(HERE / "late_threads"), str(HERE.parent)])
    return os.environ | {"LD_PRELOAD": str(library), "PYTHONPATH": paths}


def codes(command: Command, count: int, cwd: Path, environment: dict[str, str], mark: str) -> list[int]:
    """Return the exit codes of `count` runs of a program, two at a time."""

    def run(number: int) -> int:
        program = command(f"{mark}{number}")
        ended = subprocess.run(
            program, cwd=cwd, env=environment, capture_output=True, check=False, timeout=SECONDS, text=True
        )
        if ended.returncode:
            print(f"{' '.join(program[2:])}: exit code {ended.returncode}: {ended.stderr[-400:]}", flush=True)
        return ended.returncode

    with ThreadPoolExecutor(2) as threads:
        return list(threads.map(run, range(count)))


def exits(natural: int, forced: int, folder: Path) -> dict[str, tuple[list[int], list[int]]]:
    """Return the exit codes of every command: unchanged (`natural` runs in total), and with late threads.

    With late threads there are `forced` runs of each, with the normal exit of the interpreter instead of that of
    `__main__`.
    """
    commands = prepared(folder)
    place, late = folder / "fresh", late_threads(folder)
    share = -(-natural // len(commands))
    return {
        name: (
            codes(command, share, place, os.environ | {"PYTHONPATH": str(HERE.parent)}, f"n-{name.split()[-1]}"),
            codes(_as_usual(command), forced, place, late, f"f-{name.split()[-1]}"),
        )
        for name, command in commands.items()
    }
