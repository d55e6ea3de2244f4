"""Writes docs/glossary.md from one table, glossary.csv, and counts per room how often the words to avoid are used.

`python docs/tools/glossary.py` writes the page; with `--record` it also lowers the recorded counts. Tests compare both.
"""

import csv
import io
import json
import re
import sys
import tokenize
from collections import Counter
from functools import cache
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[2]
TABLE = Path(__file__).with_suffix(".csv")
RECORD = Path(__file__).with_name("glossary_counts.json")
PAGE = ROOT / "docs/glossary.md"
HEAD = """\
# Glossary

<!-- written by docs/tools/glossary.py from docs/tools/glossary.csv; a test compares -->

The project uses the terms of multibody dynamics and numerical analysis. The left column lists words that older code
still uses; write the word of the second column instead. A test counts the left column in every room, as identifiers and
in text. The recorded counts may only fall: `python docs/tools/glossary.py --record` lowers them after a rename.

Five words with one meaning each:

| word | meaning |
| --- | --- |
| limits | acceptable values of figures, as the grid's key `limits` states them |
| pressure | contact pressure from which wear is computed |
| batch | cases that one worker integrates together, and the file that holds their results |
| pose | positions and angles of all bodies at one time |
| shard | part I of N of a grid, run on a machine of its own |

| avoid | write | meaning | counted in |
| --- | --- | --- | --- |
"""
COUNTED = {"name": "identifiers", "text": "text", "both": "identifiers and text"}


class Term(NamedTuple):
    """A word to avoid, what to write, what it means, and where it is counted: name, text or both."""

    ours: str
    write: str
    meaning: str
    counted: str


class Count(NamedTuple):
    """How often the words to avoid are used in one room."""

    identifiers: int
    text: int


@cache
def terms() -> list[Term]:
    """Return the rows of the table."""
    with open(TABLE, encoding="utf-8", newline="") as file:
        return [Term(**row) for row in csv.DictReader(file)]


def page() -> str:
    """Return the glossary as a page in Markdown."""
    rows = [
        f"| `{term.ours}` | {term.write.replace('|', '&#124;')} | {term.meaning} | {COUNTED[term.counted]} |"
        for term in sorted(terms(), key=lambda term: term.ours.lower())
    ]
    return HEAD + "\n".join(rows) + "\n"


def room_of(path: Path) -> str:
    """Return the room of a file: a package, a part of mechanics, `tests` or `docs`."""
    parts = path.relative_to(ROOT).parts
    if parts[0] != "clearsweep" or path.suffix == ".md":
        return "tests" if parts[0] == "tests" else "docs"
    depth = 3 if parts[1] == "mechanics" else 2
    return "/".join(parts[1 : min(depth, len(parts) - 1)]) or "clearsweep"


def words(path: Path) -> tuple[Counter, str]:
    """Return how often each identifier is in a file of Python, and its strings and comments as one text."""
    identifiers, text = Counter({path.stem: 1}), []
    for token in tokenize.generate_tokens(io.StringIO(path.read_text(encoding="utf-8")).readline):
        if token.type == tokenize.NAME:
            identifiers[token.string] += 1
        elif token.type in (tokenize.STRING, tokenize.COMMENT):
            text.append(token.string)
    return identifiers, "\n".join(text)


def occurrences(text: str) -> int:
    """Return how often the words to avoid are in a text."""
    avoided = "|".join(re.escape(term.ours) for term in terms() if term.counted != "name")
    return len(re.findall(rf"\b(?:{avoided})\b", text))


def counts(root: Path = ROOT) -> dict[str, Count]:
    """Return room -> how often the words to avoid are used there."""
    names = {term.ours for term in terms() if term.counted != "text"}
    rooms: dict[str, Count] = {}

    def add(room: str, identifiers: int, text: int) -> None:
        before = rooms.get(room, Count(0, 0))
        rooms[room] = Count(before.identifiers + identifiers, before.text + text)

    for path in sorted([*(root / "clearsweep").rglob("*.py"), *(root / "tests").rglob("*.py")]):
        identifiers, text = words(path)
        add(room_of(path), sum(identifiers[name] for name in names), occurrences(text))
    for path in [root / "README.md", root / "CONTRIBUTING.md", *sorted((root / "docs").rglob("*.md"))]:
        if path.name != PAGE.name:
            add("docs", 0, occurrences(path.read_text(encoding="utf-8")))
    return dict(sorted(rooms.items()))


def recorded() -> dict[str, Count]:
    """Return the recorded counts; a room that has none may not use the words at all."""
    return {room: Count(*both) for room, both in json.loads(RECORD.read_text(encoding="utf-8")).items()}


def exceeded(now: dict[str, Count], record: dict[str, Count]) -> list[str]:
    """Return one sentence per room that uses the words to avoid more often than recorded."""
    sentences = []
    for room, count in now.items():
        for kind, used, allowed in zip(Count._fields, count, record.get(room, Count(0, 0)), strict=True):
            if used > allowed:
                sentences.append(f"{room}: {used} words to avoid in {kind}, {allowed} recorded; see docs/glossary.md")
    return sentences


def lowered(now: dict[str, Count], record: dict[str, Count]) -> dict[str, Count]:
    """Return the counts to record: those of now where they are lower."""
    before = {room: record.get(room, Count(0, 0)) for room in now}
    least = {room: Count(*map(min, zip(count, before[room], strict=True))) for room, count in now.items()}
    return {room: count for room, count in least.items() if any(count)}


def main(arguments: list[str]) -> None:
    """Write the page; lower the recorded counts if asked to; print the sum of all rooms."""
    PAGE.write_text(page(), encoding="utf-8")
    now = counts()
    if "--record" in arguments:
        lines = [f'  "{room}": [{count.identifiers}, {count.text}]' for room, count in lowered(now, recorded()).items()]
        RECORD.write_text("{\n" + ",\n".join(lines) + "\n}\n", encoding="utf-8")
    for room, count in now.items():
        print(f"{room:24s} {count.identifiers:5d} identifiers {count.text:5d} in text")
    both = Count(*map(sum, zip(*now.values(), strict=True)))
    print(f"{'all':24s} {both.identifiers:5d} identifiers {both.text:5d} in text")


if __name__ == "__main__":
    main(sys.argv[1:])
