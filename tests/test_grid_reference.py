"""docs/grid.md has every key of a grid file, as the program that reads them has it."""

import functools
import re
from pathlib import Path

import pytest
from click.testing import CliRunner

from clearsweep import grid
from clearsweep.cli import verbs
from clearsweep.contracts.outline import ANY
from clearsweep.simulation.scene import catalogue

PAGE = (Path(__file__).parents[1] / "docs/grid.md").read_text(encoding="utf-8")


def test_the_page_is_what_the_program_writes():
    assert CliRunner().invoke(verbs, ["schema", "--markdown"]).stdout == PAGE


def keys(schema, path=()):
    """Yield (path, keys) of every object in a JSON Schema that holds keys of its own."""
    inner, others = schema.get("properties", {}), schema.get("additionalProperties")
    if isinstance(others, dict) and "properties" in others:
        inner = inner | {ANY: others}
    if inner:
        yield ".".join(path), set(inner)
    for key, value in inner.items():
        yield from keys(value, (*path, key))


def sections(mechanism):
    """Return the text under each heading of a mechanism's part of the page."""
    text = PAGE.partition(f"\n## {mechanism}\n")[2].partition("\n## ")[0]
    return dict(re.findall(r"^### (.*)\n((?:.|\n)*?)(?=^### |\Z)", text, re.MULTILINE))


def body(mechanism, path):
    """Return what stands under the heading of a section, or of the one that it refers to."""
    text = next((text for title, text in sections(mechanism).items() if f"`{path}`" in title), "")
    other = re.search(r"The same keys as in `(.*)` of (.*)\.", text)
    return body(*other.groups()[::-1]) if other else text


@pytest.mark.parametrize(
    ("branch", "mechanism"),
    [
        ("else else else else else", "slider-crank"),
        ("else else else else then", "slider-crank, spatial"),
        ("else else else then", "four-bar"),
        ("then", "impact-pair"),
    ],
)
def test_every_key_of_the_schema_stands_under_its_section(branch, mechanism):
    schema = functools.reduce(dict.__getitem__, branch.split(), grid.schema(catalogue()))
    apart = (
        "sample",
        "seek",
        "refine",
        "optimise",
        "identify",
    )  # under "Choosing cases", as they are the same for every mechanism
    objects = {path: names for path, names in keys(schema) if path.partition(".")[0] not in apart}
    headings, missing = "".join(sections(mechanism)), []
    for path, names in objects.items():
        text = body(mechanism, path) if path else PAGE.partition("\n## Choosing cases\n")[2]
        for name in names:
            full = f"{path}.{name}".lstrip(".")
            if full not in objects and f"`{full}`" not in headings and f"| `{name}` |" not in text:
                missing.append(full)
    assert not missing
    assert len(objects) > 5


@pytest.mark.parametrize("section", ["seek", "refine", "optimise", "identify"])
def test_every_key_of_what_adds_cases_stands_under_its_heading(section):
    text = PAGE.partition(f"\n### `{section}`\n")[2].partition("\n### ")[0]
    named = {name for row in re.findall(r"^\| (.*?) \|", text, re.MULTILINE) for name in re.findall(r"`(\w+)`", row)}
    assert named == dict(keys(grid.schema(catalogue())["else"]["else"]["else"]["else"]["else"]))[section]


def test_a_quantity_stands_with_unit_range_default_and_meaning():
    assert "| `clearance` | m | above 0 | required | radial clearance, or a fit of ISO 286 as {fit: H7/f7} |" in PAGE
    assert "| `bins` |  | a whole number at least 8 and at most 1000000 | 360 |" in PAGE
