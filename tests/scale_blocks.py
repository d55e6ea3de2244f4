"""Measures runs that are cut into blocks of made-up cases: what each case costs, and what reading 10^8 cases takes.

`python tests/scale_blocks.py run COUNT DIR` runs so many cases; `extend COUNT DIR` really runs one block in a hundred
of them, and puts its files, with identities of their own, in the place of the others.  `again`, `status`, `one` and
`report` read DIR as a second run, `status`, a look for one case and the report do.  `merge` finishes the blocks of DIR
again, one after another.  Each prints a line of JSON; `python tests/scale_blocks.py write LOG` makes a part of
results/speed.md of these lines and those of `scale_nodes.py`.
"""

import json
import os
import platform
import sys
import time
from pathlib import Path

import numpy as np
import scale
import scale_cases
import speed_page

from clearsweep import grid as grids
from clearsweep import store
from clearsweep.store import blocks
from clearsweep.sweeping import blockwise
from clearsweep.sweeping.pool.case_runner import CaseRunner, Options
from clearsweep.sweeping.pool.worker import RunContext

EACH = 100  # blocks of which one really runs
HEAD = ("cases", "worker, us a case", "parent, us a case", "parent's memory, MB", "wall, s", "load")
READ = ("what, of 100,000,000 cases", "processor, s", "wall, s", "memory, MB", "load")
WHAT = {
    "again": "`run`, all cases there, closing table included",
    "status": "`status`",
    "one": "`open(DIR).summary` for one `case_id`",
    "report": "`report`",
}


def extend(directory: Path, count: int) -> dict:
    """Run one block in EACH of a grid; give the others files of the same size, and identities of their own."""
    grid = grids.load(scale_cases.made_up(count), scale_cases.StandIn.catalogue())
    options, division = Options(jobs=scale.JOBS, show_progress=False), store.Division.of(grid)
    job = blockwise.BlockJob(
        directory.absolute(), grid, scale_cases.StandIn, options, division, None, np.empty(0, "i8")
    )
    run, real = store.RunDirectory(directory), range(0, division.count, EACH)
    facts = {"counts": {"cases": len(grid)}, "blocks": {"size": division.size, "count": division.count, "numbers": []}}
    with run.open_for(grid, **facts), CaseRunner(run, options, scale_cases.StandIn) as case_runner:
        runner, begin = blockwise.BlockRunner(job, case_runner), time.process_time()
        for number in real:
            runner.run(number)
        runner.collect()
        spent = time.process_time() - begin
    chance = np.random.default_rng(1)
    for number in set(range(division.count)) - set(real):
        stand_in(directory, division, number, chance)
    return {"parent": spent, "ran": sum(len(division.part(number)) for number in real), "blocks": division.count}


def stand_in(directory: Path, division: store.Division, number: int, chance: np.random.Generator | None) -> None:
    """Finish a block with the files of the first one, and with identities of its own, by `chance`; None: with its."""
    first, block = store.Block(directory, 0), store.Block(directory, number)
    mark = json.loads(first.mark.read_text())
    block.path.mkdir(parents=True, exist_ok=True)
    for name, path in block.files.items():
        if chance and name == blocks.IDS_FILE:
            np.sort(chance.integers(0, 2**64, len(division.part(number)), dtype="u8")).tofile(path)
        else:
            os.link(first.files[name], path)
    files = mark["files"] | {blocks.IDS_FILE: ["", block.files[blocks.IDS_FILE].stat().st_size]}
    other = {key: value for key, value in mark.items() if key != "checksum"} | {"block": number, "files": files}
    block.mark.write_text(json.dumps(other | {"checksum": store.sha256_of(json.dumps(other, sort_keys=True))}))


def look_up(directory: Path) -> dict:
    """Look for a case of the last block that really ran."""
    import pandas  # noqa: F401 - what a program loads is no part of its time

    part = store.Part(store.Block(directory, 0).files, None)
    case_id = part.id_at(len(part) // 2)
    before = scale.memory("VmRSS")
    Path("/proc/self/clear_refs").write_text("5")
    begin, spent = time.perf_counter(), time.process_time()
    summary = store.open(directory).summary
    rows = len(summary[summary["case_id"] == case_id])
    wall, parent = time.perf_counter() - begin, time.process_time() - spent
    return {"wall": wall, "parent": parent, "memory": scale.memory("VmHWM") - before, "rows": rows}


def merge(directory: Path, count: int) -> dict:
    """Finish all blocks again; return the processor time of each row (us), of the first block with what it loads."""
    grid = grids.load(scale_cases.made_up(count), scale_cases.StandIn.catalogue())
    division = store.Division.of(grid)
    job = blockwise.BlockJob(directory, grid, scale_cases.StandIn, Options(), division, None, np.empty(0, "i8"))
    of_workers, costs = RunContext(directory, grid, scale_cases.StandIn), []
    for number in range(division.count):
        block, expected = store.Block(directory, number), np.sort(job.cases(number)[1])
        block.mark.unlink()
        begin = time.process_time()
        blockwise.finish_block(of_workers, block, division, expected)
        costs.append(1e6 * (time.process_time() - begin) / len(expected))
    batches = sum(
        1 for number in range(division.count) for _ in (store.Block(directory, number).path / "parts").iterdir()
    )
    later = costs[1:]
    return {
        "first": costs[0],
        "least": min(later),
        "median": float(np.median(later)),
        "batches": batches / division.count,
    }


def measure(name: str, count: int, directory: Path) -> dict:
    """Return what one step costs."""
    if name == "merge":
        return merge(directory, count)
    if name == "extend":
        return extend(directory, count)
    if name == "one":
        return look_up(directory)
    return scale.measured("run" if name == "again" else name, "made-up", directory, count)


def page(lines: list[dict]) -> str:
    """Return the part of the page that some lines make."""
    runs = [
        [
            f"{line['count']:,}",
            f"{1e6 * line['workers'] / line['count']:.1f}",
            f"{1e6 * line['parent'] / line['count']:.1f}",
            f"{1e-6 * line['memory']:.0f}",
            f"{line['wall']:.0f}",
            f"{line['load']:.0f}",
        ]
        for line in lines
        if line["name"] == "run"
    ]
    read = [
        [
            WHAT[line["name"]],
            f"{line['parent']:.2f}",
            f"{line['wall']:.1f}",
            f"{1e-6 * line['memory']:.0f}",
            f"{line['load']:.0f}",
        ]
        for line in lines
        if line["name"] in WHAT
    ]
    text = [
        f"## Runs in blocks\n\n`python tests/scale_blocks.py`, {lines[0]['date']}, {platform.system()} "
        f"{platform.machine()}, {os.cpu_count()} cores shared with other programs, as the load says; "
        f"{scale.JOBS} workers. Processor times; memory is above that after the imports.",
        scale.table(HEAD, runs),
    ]
    for line in lines:
        if line["name"] == "merge":
            text.append(
                f"Merging a block of the {line['count']:,} cases, 26 columns in {line['batches']:.0f} batches, takes "
                f"{line['median']:.2f} us a row (median of the blocks; least {line['least']:.2f}; load "
                f"{line['load']:.0f}). The first block of a worker takes {line['first']:.2f} us, with what is loaded."
            )
        if line["name"] == "nodes":
            text.append(
                f"{line['nodes']} simulated nodes of {line['cores']} cores, cases of 0.7 ms: {line['blocks']} blocks "
                f"took {line['wall']:.1f} s, so that {line['busy']:,.0f} cores were busy on average (load "
                f"{line['load']:.0f}). The parent took {1e3 * line['parent'] / (line['blocks'] - 1):.1f} ms of the "
                f"processor a block, {100 * line['parent'] / line['wall']:.1f} % of one core. A simulated node waits "
                "as long as its cores would work, and links finished files; distributing the blocks, reading "
                "their marks and the scheduler are real."
            )
        if line["name"] == "extend":
            text.append(
                f"A grid of {line['count']:,} cases has {line['blocks']:,} blocks. One in {EACH} really ran, "
                f"{line['ran']:,} cases with {1e6 * line['parent'] / line['ran']:.1f} us of the parent each; the files "
                "of the others are theirs, with identities of their own."
            )
    text.append(scale.table(READ, read))
    if first := [line["name"] for line in lines if line.get("nice", 0) < 0]:
        text.append(f"Run before other programs (nice -20): {', '.join(first)}.")
    if earlier := [f"{line['name']} of {line['count']:,}" for line in lines if line.get("earlier")]:
        text.append(f"Measured before batches had up to 4,096 cases, and not repeated: {', '.join(earlier)}.")
    return "\n\n".join(text) + "\n"


def main() -> None:
    """Do what the command line asks for."""
    if sys.argv[1] == "write":
        lines = [json.loads(line) for line in Path(sys.argv[2]).read_text().splitlines()]
        speed_page.write("blocks", page(lines))
        return
    name, count, directory = sys.argv[1], int(sys.argv[2]), Path(sys.argv[3])
    known = {
        "name": name,
        "count": count,
        "date": time.strftime("%Y-%m-%d"),
        "load": os.getloadavg()[0],
        "nice": os.nice(0),
    }
    print(json.dumps(known | measure(name, count, directory)))


if __name__ == "__main__":
    main()
