"""Checks a case of every file of configs/: `PYTHONPATH=tests python -m bench.checked [--write] [NAME ...]`.

It runs `clearsweep check --case first` in a process for each core and prints a row per file, those that took longest
before at first; --write puts them into results/checked.md.
"""

import argparse
import multiprocessing
import re
import time
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path

from clearsweep import grid
from clearsweep.language.errors import InputError
from clearsweep.simulation.setup import scene
from clearsweep.sweeping.pool.executors import cores
from clearsweep.verify import check
from clearsweep.verify.accuracy import describe_measurement

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "results" / "checked.md"
SECONDS = 1800.0  # of one file
HEAD = (
    "| file | tolerance | error | ms a revolution | compared revolutions | reference good to | order | variants passed "
    "| first that fails | processor time, s |",
    "| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |",
)


def row_of(path: Path) -> str:
    """Return the row of one file."""
    begin = time.process_time()
    try:
        loaded = grid.load(path, scene.catalogue())
        case = check.measure(loaded, check.Options(("first",), SECONDS))["cases"][0]
    except InputError as error:
        return f"| {path.name} | {error} |"
    yours, reference, stable = case["yours"], case["reference"] or {"error": None}, case["stability"]
    failed = stable["failed"]
    cells = (
        path.name,
        f"{yours['tolerance']:g}",
        number(yours["error"], ".1e"),
        number(yours["milliseconds"], ".3g"),
        number(case["compared_revolutions"], ".2g"),
        number(reference["error"], ".0e"),
        number(case["order"], ".2f"),
        f"{stable['passed']} of {stable['tried']}",
        f"{failed[0]['text']}: {failed[0]['why'].partition(';')[0]}" if failed else "",
        f"{time.process_time() - begin:.0f}",
    )
    return f"| {' | '.join(cells)} |"


def number(value: float | None, form: str) -> str:
    """Return a number in words."""
    return "unknown" if value is None else format(value, form)


def files() -> list[Path]:
    """Return the files of configs/."""
    return sorted((ROOT / "configs").glob("*.yaml"))


def known_rows() -> dict[str, str]:
    """Return the rows of the page by file."""
    text = PAGE.read_text(encoding="utf-8") if PAGE.exists() else ""
    return {line.split()[1]: line for line in text.splitlines() if re.match(r"\| \S+\.yaml ", line)}


def seconds_before(path: Path) -> float:
    """Return the processor time (s) that a file took when its row of the page was measured; infinite for a new one."""
    match = re.search(r"\| (\d+) \|$", known_rows().get(path.name, ""))
    return float(match[1]) if match else float("inf")


def write(rows: dict[str, str]) -> None:
    """Put rows by file into the page, in place of those that it has of these files."""
    known = known_rows() | rows
    missing = [path.stem for path in files() if path.name not in known]
    facts = describe_measurement("PYTHONPATH=tests python -m bench.checked --write")
    lines = [
        "# The first case of every file of configs/, checked",
        "",
        f"`{facts['command']}`, {facts['date'][:10]}, model version {facts['model_version']}, "
        f"{facts['machine']['processor']}. Errors are in clearances; see [the how-to](../docs/howto/accuracy.md).",
        "",
        *HEAD,
        *(known[name] for name in sorted(known)),
        "",
        *([f"Not measured yet: {', '.join(missing)}.", ""] if missing else []),
    ]
    PAGE.write_text("\n".join(lines), encoding="utf-8")


def main() -> None:
    """Print the table; write each row as soon as it is known."""
    reader = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    reader.add_argument("names", nargs="*", help="files of configs/ without their ending; default: all")
    reader.add_argument("--write", action="store_true", help="put the rows into results/checked.md")
    given = reader.parse_args()
    paths = [ROOT / "configs" / f"{name}.yaml" for name in given.names] or files()
    print("\n".join(HEAD), flush=True)
    with ProcessPoolExecutor(cores(), multiprocessing.get_context("spawn")) as pool:
        files_of_rows = {pool.submit(row_of, path): path.name for path in sorted(paths, key=seconds_before)[::-1]}
        for done in as_completed(files_of_rows):
            print(done.result(), flush=True)
            if given.write:
                write({files_of_rows[done]: done.result()})


if __name__ == "__main__":
    main()
