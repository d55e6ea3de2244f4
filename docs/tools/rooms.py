"""Draws docs/rooms.svg: the rooms of the package in the layers that pyproject.toml keeps, each with what it is for.

`python docs/tools/rooms.py` writes the picture; a test compares.
"""

import ast
import textwrap
import tomllib
from html import escape
from pathlib import Path

ROOT = Path(__file__).parents[2]
PICTURE = ROOT / "docs/rooms.svg"
WIDTH, MARGIN, GAP, LINE = 720, 14, 10, 15  # px
LETTER = 5.6  # px, mean width of a letter of a description


def layers() -> list[list[str]]:
    """Return the layers of the package from the top down, each a list of its modules."""
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    contract = next(c for c in settings["tool"]["importlinter"]["contracts"] if c["type"] == "layers")
    return [[name.strip(" ()") for name in layer.replace(":", "|").split("|")] for layer in contract["layers"]]


def source_of(name: str) -> Path:
    """Return the file whose docstring says what a module is for."""
    package = ROOT / "clearsweep" / name / "__init__.py"
    return package if package.exists() else ROOT / f"clearsweep/{name}.py"


def purpose(path: Path) -> str:
    """Return the first sentence of the docstring of a file."""
    text = ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or ""
    return text.split("\n\n")[0].replace("\n", " ").split(".  ")[0].rstrip(".").replace("`", "")


def inner(name: str) -> list[str]:
    """Return the rooms within a room."""
    return sorted(path.parent.name for path in (ROOT / "clearsweep" / name).glob("*/__init__.py"))


def box(name: str, x: float, y: float, width: float, height: float) -> list[str]:
    """Return the drawing of one room."""
    parts = [
        f'<rect x="{x:.0f}" y="{y:.0f}" width="{width:.0f}" height="{height:.0f}" rx="5" class="room"/>',
        f'<text x="{x + 10:.0f}" y="{y + 20:.0f}" class="name">{escape(name)}</text>',
    ]
    lines = [*textwrap.wrap(purpose(source_of(name)), int((width - 20) / LETTER)), *inner_line(name, width)]
    for number, line in enumerate(lines):
        parts.append(f'<text x="{x + 10:.0f}" y="{y + 38 + LINE * number:.0f}" class="text">{escape(line)}</text>')
    return parts


def inner_line(name: str, width: float) -> list[str]:
    """Return the lines that name the rooms within a room."""
    rooms = inner(name)
    return textwrap.wrap(f"holds: {', '.join(rooms)}", int((width - 20) / LETTER)) if rooms else []


def height_of(layer: list[str], width: float) -> float:
    """Return the height of a layer whose rooms have this width."""
    columns = int((width - 20) / LETTER)
    most = max(len(textwrap.wrap(purpose(source_of(name)), columns)) + len(inner_line(name, width)) for name in layer)
    return 32 + LINE * most


def picture() -> str:
    """Return the rooms as SVG, the layers from the top down."""
    parts, y = [], MARGIN
    for layer in layers():
        width = (WIDTH - 2 * MARGIN - GAP * (len(layer) - 1)) / len(layer)
        height = height_of(layer, width)
        for place, name in enumerate(layer):
            parts += box(name, MARGIN + place * (width + GAP), y, width, height)
        y += height + GAP
    head = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {y + MARGIN - GAP:.0f}" role="img">'
    style = (
        "<style>.room{fill:#fff;stroke:#5b6b7b}.name{font:bold 14px sans-serif;fill:#14303f}"
        ".text{font:11px sans-serif;fill:#333}</style>"
    )
    ground = '<rect width="100%" height="100%" fill="#eef2f5"/>'
    return "\n".join(
        [head, "<title>The rooms of clearsweep and their layers</title>", style, ground, *parts, "</svg>\n"]
    )


if __name__ == "__main__":
    PICTURE.write_text(picture(), encoding="utf-8")
