"""Runs the grids that pages show and writes what they print in place of what the pages show; tests compare.

`python docs/tools/printed.py [PAGE ...]`: README, gallery and how-tos, or those named.  A page shows some lines of an
output.  A line that is no longer printed is replaced by the printed line most like it.  Read the difference afterwards:
sentences that quote the numbers are not changed.
"""

import contextlib
import difflib
import re
import shutil
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from click.testing import CliRunner
from ruamel.yaml import YAML

from clearsweep.cli import verbs

ROOT = Path(__file__).parents[2]
CONFIGS = ROOT / "configs"
HOWTOS = sorted((ROOT / "docs/howto").glob("*.md"))
MARK = "<!-- output -->\n"  # in a how-to, of the grid above
OF_A_FILE = re.compile(r"<!-- output: (?:clearsweep run configs/)?(\w+)(?:\.yaml)? -->\n```text\n((?:(?!```).*\n)*)```")
OF_A_BLOCK = re.compile(
    rf"^```yaml\n((?:(?!^```).*\n)*)```\n(?:(?!^```).*\n)*{MARK}```text\n((?:(?!^```).*\n)*)```", re.MULTILINE
)
TIMES = re.compile(r" ran in |^Results in |^Next: ")  # lines that differ from run to run


class Example(NamedTuple):
    """A grid and the lines that a page shows of its output."""

    grid: Path | dict
    shown: str


def examples(page: Path) -> Iterator[Example]:
    """Yield the examples of a page."""
    text = page.read_text(encoding="utf-8")
    for name, shown in OF_A_FILE.findall(text):
        yield Example(CONFIGS / f"{name}.yaml", shown)
    for block, shown in OF_A_BLOCK.findall(text):
        yield Example(completed(block), shown)


def completed(block: str) -> dict:
    """Return the grid of configs/slider_crank_restitution.yaml with the sections of `block`, without its sweep.

    A block with a name is a whole grid, or extends one.
    """
    sections = YAML(typ="safe").load(block)
    if "name" in sections:
        return dict(sections)
    whole = YAML(typ="safe").load((CONFIGS / "slider_crank_restitution.yaml").read_text(encoding="utf-8"))
    del whole["sweep"]
    for key, value in sections.items():
        whole[key] = {**whole[key], **value} if key in whole else value
    return whole


def printed(example: Example) -> list[str]:
    """Return the lines that `clearsweep run` prints for the grid of an example."""
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(CONFIGS):
        grid = example.grid
        if isinstance(grid, dict):
            shutil.copytree(CONFIGS, folder, dirs_exist_ok=True)  # files that grids name
            grid = Path(folder) / "grid.yaml"
            YAML(typ="safe").dump(example.grid, grid)
        result = CliRunner().invoke(verbs, ["run", str(grid), "--out", str(Path(folder) / "run"), "-j", "1"])
    if result.exit_code != 0:
        raise RuntimeError(result.output)
    return [line.rstrip() for line in result.stdout.splitlines()]


def missing(shown: str, lines: list[str]) -> list[str]:
    """Return the lines that are shown but not printed, except those that differ from run to run."""
    return [line for line in shown.splitlines() if line and line not in lines and not TIMES.search(line)]


def renewed(shown: str, lines: list[str]) -> str:
    """Return what is shown with the printed line most like it for each line that is not printed, in printed order."""
    old, left = missing(shown, lines), [line for line in lines if line not in shown.splitlines()]
    made = []
    for line in shown.splitlines():
        best = difflib.get_close_matches(line, left, n=1, cutoff=0.0) if line in old else []
        made.extend(best or [line])
        left = [each for each in left if each not in best]
    ordered = iter(sorted((line for line in made if line and line in lines), key=lines.index))
    return "".join(f"{next(ordered) if line and line in lines else line}\n" for line in made)


def renew(page: Path) -> None:
    """Write the lines that are printed into a page."""
    for example in list(examples(page)):
        new = renewed(example.shown, printed(example))
        if new != example.shown:
            page.write_text(page.read_text(encoding="utf-8").replace(example.shown, new), encoding="utf-8")
            print(f"{page.relative_to(ROOT)}: an output has changed")


if __name__ == "__main__":
    named = [Path(name).resolve() for name in sys.argv[1:]]
    for each in named or [ROOT / "README.md", ROOT / "docs/gallery.md", *HOWTOS]:
        renew(each)
