"""results/speed.md, of which several commands write a part each."""

import re
from pathlib import Path

PAGE = Path(__file__).parent.parent / "results" / "speed.md"
#: What writes each part, in the order of the page.
PARTS = {
    "other programs": "make bench ARGS=--write",
    "side by side": "make bench ARGS=--write",
    "taken away": "make bench ARGS=--write",
    "machines": "make bench ARGS=--write",
    "two workers": "make bench ARGS=--write",
    "two commits": "make bench AGAINST=TREE ARGS=--write",
    "README of two commits": "python -m bench.against TREE --readme --write",
    "files of two commits": "python -m bench.against TREE --files --write",
    "many cases": "make scale ARGS=--write",
    "first run": "make bench ARGS=--write",
    "blocks": "python tests/scale_blocks.py write LOG",
}
_MARK = re.compile(r"^<!-- part: (.*?); written by .*? -->\n", re.MULTILINE)


def parts(text: str) -> dict[str, str]:
    """Return the parts of a page by their names."""
    _, *pieces = _MARK.split(text)
    return dict(zip(pieces[::2], pieces[1::2], strict=True))


def write(part: str, text: str, page: Path = PAGE) -> None:
    """Replace one of PARTS by `text`, or add it."""
    texts = parts(page.read_text(encoding="utf-8")) | {part: text}
    kept = [f"{mark(name)}{texts[name].strip()}\n" for name in PARTS if name in texts]
    page.write_text("\n".join(kept), encoding="utf-8")


def mark(part: str) -> str:
    """Return the line before a part."""
    return f"<!-- part: {part}; written by `{PARTS[part]}` -->\n"
