"""Tortures clearsweep and reports the result: kills, mutated grids, flipped bits, exit codes, an adversary's list.

`python tests/reliability.py [--kills N] [--lives N] [--grids N] [--flips N] [--exits N] [--attempts no] [--seed N]
[--write]` has exit code 1 if anything failed; with `--write` it writes docs/reliability.md.
"""

import argparse
import datetime
import platform
import random
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

import torture
import torture_attempts
import torture_exits
import torture_flips
import torture_grids

import clearsweep
from clearsweep.sweeping import sweep

ROOT = Path(__file__).parent.parent
PAGE = ROOT / "docs" / "reliability.md"
MARK = "<!-- below: written by `python tests/reliability.py --write` -->\n"
GRIDS_TEXT = (
    "The test mutates working grids: it exchanges keys and values for other or hostile ones, and changes bytes. Each "
    "grid gets 5 s, 6 GB of address space and two revolutions of motion. Hypothesis draws the mutations from the seed."
)
FLIPS_TEXT = (
    "The test changes one bit of one file of a finished run of 12 cases. Then a reader reads everything, `status "
    "--verify` checks the files, and the grid runs again. These are the outcomes: `named`, an error named the file; "
    "`without meaning`, no checksum covers the bit and the reader read all data correctly; `silent`, the reader read "
    "other data. `restored` counts the runs that then repaired the file, or refused it by name."
)
FLIPS_HEAD = ("file", "flips", "named", "without meaning", "unnamed", "silent", "traceback", "restored")
ATTEMPTS_TEXT = "Each attempt is a command line in `tests/torture_attempts.py`. Exit code 2 is a refusal with a remedy."
ATTEMPTS_HEAD = ("attempt", "exit code", "took", "ended")
KILLS_TEXT = (
    "The test kills sweeps of real mechanics with SIGKILL at random moments, and starts them again. It kills the "
    "parent, one process, or all. It compares the results with those of an undisturbed run. Numbers of rows and "
    "values are sums over the runs. `cases lost` counts cases that were committed and are in no batch at the end; the "
    "batches themselves may be replaced by a merge."
)


EXITS_TEXT = (
    "The test runs every command, and its counterpart in Python, again and again, two programs at a time. In a second "
    "series it delays the threads of libraries until the interpreter ends, as happens on a loaded machine. Each "
    "program must end with exit code 0."
)
EXITS_HEAD = ("program", "runs", "other exit codes", "runs with late threads", "other exit codes")

LIVES_TEXT = (
    "The test kills four lives, each of some dozens of blocks of revolutions, in the same way. They must resume after "
    "the last block that was stored, and their histories must be equal to the last bit."
)


BLOCKS_TEXT = (
    "The test kills runs with blocks of 64 cases instead of 131,072, so that kills hit running, finished and marked "
    "blocks."
)


def kills(
    count: int, seed: int, folder: Path, grid: dict = torture.GRID, block: int = 0
) -> tuple[bool, list[list[str]]]:
    """Kill real sweeps; return whether no results were lost, and rows for the page."""
    start = torture.starter(folder, grid, block)
    assert start(folder / "undisturbed").wait() == 0
    repetitions = torture.torture(start, folder, count, seed, (0.1, 3.0))
    result = Counter()
    for each in repetitions:
        result.update(torture.differences(folder / "undisturbed", each.out) | {"cases lost": each.lost_cases()})
        print(f"{each.out.name}: {torture.kills_text(each.kills)}", flush=True)
    victims = sum((each.kills for each in repetitions), Counter())
    rows = [
        ["kills", f"{victims.total():,}: {torture.kills_text(victims)}"],
        ["seed", str(seed)],
        ["runs that were killed and finished", f"{len(repetitions):,}"],
        ["longest pause between two commits", f"{max(each.longest for each in repetitions):.1f} s"],
        *([name, f"{number:,}"] for name, number in result.items()),
    ]
    return torture.same(result), rows


def lives(count: int, seed: int, folder: Path) -> tuple[bool, list[list[str]]]:
    """Kill lives before their end; return whether their results are unchanged, and rows for the page."""
    return kills(count, seed, folder, torture.LIVES)


def blocks(count: int, seed: int, folder: Path) -> tuple[bool, list[list[str]]]:
    """Kill sweeps in blocks; return whether no results were lost, and rows for the page."""
    return kills(count, seed, folder, block=64)


def grids(count: int, seed: int, folder: Path) -> tuple[bool, list[list[str]]]:
    """Run mutated grids; return whether none had a fault, and rows for the page."""
    result = torture_grids.fuzz(count, seed, folder)
    codes = result["codes"]
    rows = [
        ["mutated grids", f"{result['grids']:,}"],
        ["seed", str(seed)],
        ["refused with an error message (exit code 2)", f"{codes.get(2, 0):,}"],
        ["ran, or had too many cases to run here (exit code 0)", f"{codes.get(0, 0):,}"],
        ["ran with failed cases, or cases of a kind that is not compiled here (exit code 3)", f"{codes.get(3, 0):,}"],
        ["longest", f"{result['longest']:.1f} s"],
        ["tracebacks, other exit codes, files outside, more than 5 s", f"{len(result['faults']):,}"],
    ]
    return not result["faults"], rows


def flips(count: int, seed: int, folder: Path) -> tuple[bool, list[list[str]]]:
    """Flip bits of a real run; return whether all were detected, and rows for the page."""
    grid = torture.GRID | {"sweep": {"drive.speed": {"linspace": ["1000 rpm", "5000 rpm", 12]}}}

    def run(directory):
        sweep.sweep(grid, directory, executor="serial", show_progress=False)

    run(folder / "finished")
    result = torture_flips.flips(folder / "finished", count, seed, run)
    bad = (torture_flips.UNNAMED, torture_flips.SILENT, torture_flips.FAULT)
    outcomes = (torture_flips.NAMED, torture_flips.UNREAD, *bad, "restored")
    rows = [
        [f"`{kind}`", f"{sum(each.values()) - each['restored']:,}", *(f"{each[outcome]:,}" for outcome in outcomes)]
        for kind, each in sorted(result.items())
    ]
    total = sum(result.values(), Counter())
    rows.append(["all", f"{total.total() - total['restored']:,}", *(f"{total[outcome]:,}" for outcome in outcomes)])
    good = not any(total[outcome] for outcome in bad) and total["restored"] == count
    return good, rows


def attempts(_count: int, _seed: int, folder: Path) -> tuple[bool, list[list[str]]]:
    """Try the adversary's list; return whether all ended as specified, and rows for the page."""
    results = torture_attempts.try_all(folder)
    rows = [
        [
            result.attempt.name,
            "-" if result.code is None else str(result.code),
            f"{result.seconds:.0f} s",
            result.fault or "as specified",
        ]
        for result in results
    ]
    return not any(result.fault for result in results), rows


def exits(count: int, _seed: int, folder: Path) -> tuple[bool, list[list[str]]]:
    """Run every command many times; return whether each had exit code 0, and rows for the page."""
    result = torture_exits.exits(count, -(-count // 10), folder)
    rows = [
        [name, *(f"{number}" for codes in both for number in (len(codes), sum(code != 0 for code in codes)))]
        for name, both in result.items()
    ]
    totals = [str(sum(int(row[k]) for row in rows)) for k in range(1, len(EXITS_HEAD))]
    return totals[1] == totals[3] == "0", [*rows, ["all", *totals]]


def table(head: tuple[str, ...], rows: list[list[str]]) -> str:
    """Return rows as a table of Markdown."""
    lines = [head, ("---",) * len(head), *rows]
    return "\n".join("| " + " | ".join(cell.replace("|", "\\|") for cell in line) + " |" for line in lines)


def page(command: str, tables: dict[str, tuple[str, str]]) -> str:
    """Return docs/reliability.md with the tables of the same titles replaced."""
    before, mark, rest = PAGE.read_text(encoding="utf-8").partition(MARK)
    sections = dict(section.strip().split("\n\n", 1) for section in rest.split("### ")[1:])
    surroundings = f"clearsweep {clearsweep.__version__}, Python {platform.python_version()}, {platform.system()}"
    measured = f"`{command}`, {datetime.datetime.now(datetime.UTC):%Y-%m-%d}; {surroundings}."
    sections |= {title: f"{text}\n\n{rows}\n\n{measured}" for title, (text, rows) in tables.items()}
    return f"{before}{mark}\n" + "\n\n".join(f"### {title}\n\n{body}" for title, body in sections.items()) + "\n"


def main(arguments: list[str] | None = None) -> int:
    """Run the tortures given by the options, print the tables, and write the page."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--kills", type=int, default=100)
    parser.add_argument("--lives", type=int, default=20, help="kills of lives")
    parser.add_argument("--blocks", type=int, default=60, help="kills of sweeps that are cut into blocks")
    parser.add_argument("--grids", type=int, default=500)
    parser.add_argument("--flips", type=int, default=200)
    parser.add_argument(
        "--exits", type=int, default=100, help="runs of all commands together; a tenth as many with late threads"
    )
    parser.add_argument("--attempts", choices=("yes", "no"), default="yes")
    parser.add_argument("--seed", type=int, default=random.randrange(10**6))
    parser.add_argument("--write", action="store_true", help=f"write what was measured into {PAGE.relative_to(ROOT)}")
    options = parser.parse_args(arguments)
    print(f"seed {options.seed}", flush=True)
    good, tables = True, {}
    with tempfile.TemporaryDirectory() as place:
        for title, text, head, asked, work in (
            ("Mutated grids", GRIDS_TEXT, ("", ""), options.grids, grids),
            ("Flipped bits", FLIPS_TEXT, FLIPS_HEAD, options.flips, flips),
            ("Attempts", ATTEMPTS_TEXT, ATTEMPTS_HEAD, int(options.attempts == "yes"), attempts),
            ("Exits", EXITS_TEXT, EXITS_HEAD, options.exits, exits),
            ("Kills", KILLS_TEXT, ("", ""), options.kills, kills),
            ("Killed lives", LIVES_TEXT, ("", ""), options.lives, lives),
            ("Killed blocks", BLOCKS_TEXT, ("", ""), options.blocks, blocks),
        ):
            if asked:
                folder, begin = Path(place) / title.split()[-1], time.monotonic()
                folder.mkdir()
                well, rows = work(asked, options.seed, folder)
                good = good and well
                tables[title] = (text, table(head, rows))
                print(f"\n{title}, {time.monotonic() - begin:.0f} s\n\n{tables[title][1]}\n", flush=True)
    print("nothing fell short" if good else f"SOMETHING FELL SHORT, try --seed {options.seed} again")
    if options.write:
        numbers = ("kills", "lives", "blocks", "grids", "flips", "exits", "attempts")
        asked = " ".join(f"--{name} {getattr(options, name)}" for name in numbers)
        command = f"python tests/reliability.py {asked} --seed {options.seed} --write"
        PAGE.write_text(page(command, tables), encoding="utf-8")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
