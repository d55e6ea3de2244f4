"""The right grids of `wrong_grids.txt`, for all tests: each is there once, by its name."""

from pathlib import Path

from ruamel.yaml import YAML

PAGE = Path(__file__).with_name("wrong_grids.txt")
READER = YAML(typ="safe", pure=True)


def text_of(name: str) -> str:
    """Return the text of a right grid."""
    section = PAGE.read_text(encoding="utf-8").partition(f"== {name}\n")[2]
    return section.partition("\n\n")[0].rstrip("\n") + "\n"


def grid_of(name: str) -> dict:
    """Return a right grid as a dict, new at each call."""
    return READER.load(text_of(name))
