"""docs/grid.md has every key of a grid file, as the program that reads them has it."""

import functools
import re
from pathlib import Path

import pytest
from click.testing import CliRunner

from clearsweep import grid
from clearsweep.cli import verbs
from clearsweep.contracts.outline import ANY
from clearsweep.grid.key_trees import key_trees
from clearsweep.simulation.scene import catalogue

PAGE = (Path(__file__).parents[1] / "docs/grid.md").read_text(encoding="utf-8")


def test_the_page_is_what_the_program_writes():
    assert CliRunner().invoke(verbs, ["schema", "--markdown"]).stdout == PAGE


def keys(schema, path=()):
    """Yield (path, keys) of every object in a JSON Schema that contains keys of its own."""
    inner, others = schema.get("properties", {}), schema.get("additionalProperties")
    if isinstance(others, dict) and "properties" in others:
        inner = inner | {ANY: others}
    if inner:
        yield ".".join(path), set(inner)
    for key, value in inner.items():
        yield from keys(value, (*path, key))


def sections():
    """Return the text under the heading of each section; several with the same keys share a heading."""
    parts = re.findall(r"^## (.*)\n((?:.|\n)*?)(?=^## |\Z)", PAGE, re.MULTILINE)
    return {path: text for title, text in parts for path in re.findall(r"`(.*?)`", title)}


def common(path):
    """Return the path of a section as the page has it: joints are one, a list is a row."""
    return re.sub(r"^joints\.[^.]+", f"joints.{ANY}", path)


def is_row(known, path):
    """Return whether a path is a row of the section above it."""
    above, _, key = common(path).rpartition(".")
    return f"| `{key}` |" in known.get(above, "")


@pytest.mark.parametrize(
    "branch", ["else else else else else", "else else else else then", "else else else then", "else then", "then"]
)
def test_every_key_of_the_schema_stands_under_its_section(branch):
    schema = functools.reduce(dict.__getitem__, branch.split(), grid.schema(catalogue()))
    apart = ("sample", "seek", "refine", "optimise", "identify")  # under "Choosing cases"
    objects = {path: names for path, names in keys(schema) if path.partition(".")[0] not in apart}
    known, missing = sections(), []
    for path, names in objects.items():
        if names <= {"0", "1", "2"} and is_row(known, path):
            continue
        text = known.get(common(path), "") if path else PAGE.partition("\n## Choosing cases\n")[2]
        for name in names:
            full = f"{path}.{name}".lstrip(".")
            if (
                full not in objects
                and not any(each.startswith(common(full)) for each in known)
                and f"| `{name}` |" not in text
            ):
                missing.append(full)
    assert not missing
    assert len(objects) > 5


def test_a_section_stands_once_and_says_which_mechanisms_have_a_key():
    headings = re.findall(r"^## .*", PAGE, re.MULTILINE)
    assert len(headings) == len(set(headings))
    assert "| `branch` |  | `open`, `crossed` | `open` | *four-bar*: the coupler's pin on the left" in PAGE
    assert "; in space, slot: without `karnopp`, `dahl`, `lugre`, `elasto-plastic` |" in PAGE
    assert "| `horizon` |  | `true`, `false` | `false` | *not impact-pair*: " in PAGE


def test_a_list_is_a_row_and_a_key_in_two_units_has_both():
    assert "| `tilt` | rad | two, each any | 0 | *in space*: rotation vector of the bearing" in PAGE
    assert "| `velocity_scale` | m/s or rad/s | above 0 | required | `threlfall`: " in PAGE
    assert "## `joints.NAME.contact.material.bearing`, `joints.NAME.contact.material.journal`\n" in PAGE


def test_joints_with_one_place_on_the_page_have_the_same_keys():
    """The page shows the pins of the first mechanism alone, so that they have to be like all others."""
    trees = [tree for tree in key_trees(catalogue()) if "revolute" in tree.joints.values()]
    assert len(trees) == 2
    keys = [
        {inner.removeprefix(f"joints.{joint}") for inner in tree.keys if inner.startswith(f"joints.{joint}.")}
        for tree in trees
        for joint, kind in tree.joints.items()
        if kind == "revolute"
    ]
    assert len(keys) == 7
    assert all(each == keys[0] for each in keys)


@pytest.mark.parametrize("section", ["seek", "refine", "optimise", "identify"])
def test_every_key_of_what_adds_cases_stands_under_its_heading(section):
    text = PAGE.partition(f"\n### `{section}`\n")[2].partition("\n### ")[0]
    named = {name for row in re.findall(r"^\| (.*?) \|", text, re.MULTILINE) for name in re.findall(r"`(\w+)`", row)}
    assert named == dict(keys(grid.schema(catalogue())["else"]["else"]["else"]["else"]["else"]))[section]


def test_a_quantity_stands_with_unit_range_default_and_meaning():
    assert re.search(r"\| `clearance` \| m \| above 0 \| required \| .*radial clearance, or a fit of ISO 286 as", PAGE)
    assert "| `bins` |  | whole, 8 to 1e6 | 360 | angular bins around each body; *fixed* |" in PAGE
