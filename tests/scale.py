"""Measures the cost of a sweep besides its cases, up to a million of them, with substitutes and with real mechanics.

`python tests/scale.py [--made-up N,N,...] [--real N,N,...] [--write]` (`make scale`) runs grids of these sizes, each
step in its own process; with `--write` the tables go into results/speed.md.
"""

import argparse
import contextlib
import datetime
import io
import json
import os
import platform
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import scale_cases
import speed_page
from scale_cases import COUNTS

import clearsweep
from clearsweep import report, store
from clearsweep.sweeping import estimate, summary, sweep
from clearsweep.sweeping.pool.case_runner import SIMULATION

ROOT = Path(__file__).parent.parent
LEAST = 100  # cases of the run from which the start-up is taken
JOBS = 2
SHORT = 1e-3  # s, duration of a substitute case for the share of the cases in the total
KINDS = {
    "made-up": (scale_cases.made_up, scale_cases.StandIn),
    "real": (scale_cases.real, SIMULATION._replace(solve=scale_cases.timed)),
}

# ------------------------------------------------------------------------------------------- one step, in a process


def run(kind: str, directory: Path, count: int, seconds: float) -> dict[str, Any]:
    """Run a grid as the command does, including the final table."""
    make, simulator = KINDS[kind]
    source = make(count, seconds) if seconds else make(count)
    result = sweep.run_sweep(source, directory, sweep.Options(jobs=JOBS, show_progress=False), simulator)
    summary.run_text(summary.of_run(result))
    return {"start": result.start_up, "ran": result.ran}


def dry_run(kind: str, directory: Path, count: int, _: float) -> dict[str, Any]:
    """Print the plan of a run."""
    make, simulator = KINDS[kind]
    return {"pending": estimate.estimate(make(count), directory, jobs=JOBS, simulator=simulator).pending}


def status(_kind: str, directory: Path, _count: int, _: float) -> dict[str, Any]:
    """Print the progress of a run."""
    return {"state": store.status(directory)["state"]}


def verify(_kind: str, directory: Path, _count: int, _: float) -> dict[str, Any]:
    """Verify every checksum."""
    return {"state": store.status(directory, every_file=True)["state"]}


def page(_kind: str, directory: Path, _count: int, _: float) -> dict[str, Any]:
    """Write the report."""
    return {"page": report.write(store.open(directory), directory / "report.html").stat().st_size}


def frame(_kind: str, directory: Path, _count: int, _: float) -> dict[str, Any]:
    """Read the summary from Python."""
    return {"rows": len(store.open(directory).summary)}


STEPS = {
    "run": run,
    "again": run,
    "dry-run": dry_run,
    "status": status,
    "verify": verify,
    "report": page,
    "frame": frame,
}


def memory(key: str) -> int:
    """Return the memory of this process (B): VmRSS, current, or VmHWM, the largest since its last reset."""
    lines = Path("/proc/self/status").read_text().splitlines()
    return 1024 * int(next(line.split()[1] for line in lines if line.startswith(key)))


def step(name: str, kind: str, directory: str, count: str, seconds: str) -> None:
    """Run one step and print its cost, as JSON."""
    if name in ("report", "frame"):
        import clearsweep.report.documents.page  # noqa: F401 - what a verb loads is no part of its memory
    else:
        import pebble  # noqa: F401
    before = memory("VmRSS")
    Path("/proc/self/clear_refs").write_text("5")
    begin, spent = time.perf_counter(), time.process_time()
    with contextlib.redirect_stdout(io.StringIO()):
        facts = STEPS[name](kind, Path(directory), int(count), float(seconds))
    workers = resource.getrusage(resource.RUSAGE_CHILDREN)
    cost = {
        "wall": time.perf_counter() - begin,
        "parent": time.process_time() - spent,
        "workers": workers.ru_utime + workers.ru_stime,
        "memory": memory("VmHWM") - before,
    }
    print(json.dumps(cost | facts))


def measured(name: str, kind: str, directory: Path, count: int, seconds: float = 0.0) -> dict[str, Any]:
    """Return the cost of one step in its own process."""
    arguments = [name, kind, str(directory), str(count), str(seconds)]
    program = [sys.executable, "-c", "import scale, sys; scale.step(*sys.argv[1:])", *arguments]
    done = subprocess.run(program, capture_output=True, text=True, check=False, env=_environment())
    if done.returncode:
        raise SystemExit(f"{name}: {done.stderr}")
    print(f"scale: {kind} {count:,} {name}: {done.stdout.strip()}", file=sys.stderr, flush=True)
    return dict(json.loads(done.stdout))


def _environment() -> dict[str, str]:
    paths = [str(ROOT / "tests"), str(ROOT), os.environ.get("PYTHONPATH", "")]
    return os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, paths))}


# --------------------------------------------------------------------------------------------------- the tables


def case_seconds(directory: Path) -> float:
    """Return the processor time (s) of all cases of a run."""
    return sum(float(np.nansum(block["run_time"])) for block in store.open(directory).blocks(["run_time"]))


def growth(kind: str, counts: list[int], folder: Path, seconds: float = 0.0) -> Iterator[list[str]]:
    """Yield a row for each number of cases: the cost of a case without start-up."""
    tiny = folder / f"{kind}-{LEAST}-{seconds:g}"
    least = measured("run", kind, tiny, LEAST, seconds)
    inside = case_seconds(tiny)
    first = None
    for count in counts:
        directory = folder / f"{kind}-{count}-{seconds:g}"
        cost = measured("run", kind, directory, count, seconds)
        cases = case_seconds(directory)
        parent, workers = (1e6 * (cost[who] - least[who]) / (count - LEAST) for who in ("parent", "workers"))
        each = 1e6 * (cases - inside) / (count - LEAST)
        first = first or parent + workers
        yield [
            f"{count:,}",
            f"{each:.0f}",
            f"{workers - each:.0f}",
            f"{parent:.0f}",
            f"{parent + workers:.0f}",
            f"{(parent + workers) / first:.2f}",
            f"{each / (parent + workers):.2f}",
            f"{cases / (JOBS * cost['wall']):.2f}",
            f"{cost['wall']:.0f}",
            f"{1e-6 * cost['memory']:.0f}",
        ]


GROWTH = (
    "cases",
    "case, us",
    "with its worker, us",
    "parent, us",
    "all, us",
    "over the first",
    "case / all",
    "cases / (2 x wall)",
    "wall, s",
    "parent's memory, MB",
)


def verbs(kind: str, count: int, folder: Path) -> Iterator[list[str]]:
    """Yield a row for each command that reads a run with `count` cases."""
    directory = folder / f"{kind}-{count}-0"
    for name in ("again", "dry-run", "status", "verify", "frame", "report"):
        cost = measured(name, kind, directory, count)
        start = f"{cost['start']:.1f}" if "start" in cost else "-"
        memory, page = f"{1e-6 * cost['memory']:.0f}", f"{1e-6 * cost['page']:.1f}" if "page" in cost else "-"
        yield [_VERBS[name], start, f"{cost['wall']:.1f}", f"{cost['parent']:.1f}", memory, page]


VERBS = ("what", "start, s", "wall, s", "processor, s", "memory, MB", "page, MB")
_VERBS = {
    "again": "`run`, all cases there",
    "dry-run": "`run --dry-run`, all cases there",
    "status": "`status`",
    "verify": "`status --verify`",
    "frame": "`clearsweep.open(DIR).summary`",
    "report": "`report`",
}


def table(head: tuple[str, ...], rows: list[list[str]]) -> str:
    """Return rows as a table of Markdown."""
    return "\n".join(f"| {' | '.join(cells)} |" for cells in (head, ["---"] * len(head), *rows))


def main() -> None:
    """Run the measurements of the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--made-up", default="10000,100000,1000000", help="numbers of substitutes: of these")
    parser.add_argument("--real", default="10000,100000", help="numbers of real cases, of the same")
    parser.add_argument("--write", action="store_true", help="write the tables into results/speed.md, too")
    asked = parser.parse_args()
    counts, real_counts = ([int(word) for word in text.split(",") if word] for text in (asked.made_up, asked.real))
    unknown = {*counts, *real_counts} - {*COUNTS}
    if unknown:
        parser.error(f"found {sorted(unknown)}; expected some of {', '.join(map(str, COUNTS))}")
    text = [
        f"## Many cases\n\n`make scale`, {datetime.datetime.now(datetime.UTC).isoformat(timespec='seconds')}, "
        f"clearsweep {clearsweep.__version__}, {platform.system()} {platform.machine()}, {os.cpu_count()} cores, load "
        f"{os.getloadavg()[0]:.1f} at the start; {JOBS} workers. Times a case are processor times, least disturbed by "
        f"other programs, those of a run of {LEAST} cases taken off; memory is above that after the imports."
    ]
    with tempfile.TemporaryDirectory(prefix="clearsweep-scale-") as name:
        folder = Path(name)
        if counts:
            text += ["Stand-ins that take no time:", table(GROWTH, list(growth("made-up", counts, folder)))]
            text += [
                f"Reading a run of {counts[-1]:,} of them:",
                table(VERBS, list(verbs("made-up", counts[-1], folder))),
            ]
            text += [
                f"Stand-ins of {1e3 * SHORT:g} ms:",
                table(GROWTH, list(growth("made-up", counts[:1], folder, SHORT))),
            ]
        if real_counts:
            text += ["Real cases, of one revolution:", table(GROWTH, list(growth("real", real_counts, folder)))]
    page = "\n\n".join(text) + "\n"
    print(page)
    if asked.write:
        speed_page.write("many cases", page)


if __name__ == "__main__":
    main()
