"""`clearsweep list KEY` explains every key of the page of keys, with an example that a grid may contain."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
import yaml
from click.testing import CliRunner

from clearsweep import grid
from clearsweep.cli import verbs
from clearsweep.grid.pages import page_sections, section_examples, section_texts
from clearsweep.language import quantity
from clearsweep.simulation.setup.scene import catalogue

COMMANDS = (Path(__file__).parents[1] / "docs/commands.md").read_text(encoding="utf-8")
KEYS = [(path, row) for part in page_sections(catalogue()) for path in part.paths for row in part.rows]


def listed(name):
    return CliRunner().invoke(verbs, ["list", name], catch_exceptions=False).stdout


def values(section):
    """Return the one value that a nested section of one key each contains."""
    while isinstance(section, dict):
        ((_, section),) = section.items()
    return section


@pytest.mark.parametrize("first", sorted({path.partition(".")[0] for path, _ in KEYS}))
def test_every_key_has_its_meaning_and_an_example_in_yaml(first):
    known = catalogue()
    for path, row in (key for key in KEYS if key[0].partition(".")[0] == first):
        text = grid.key_text(f"{path}.{row.key}", known)
        assert text is not None
        assert "meaning" in text
        for example in re.findall(r"example   (.*)", text):
            assert values(yaml.safe_load(example)) is not None
            assert "NAME" not in example


def test_a_path_of_a_grid_is_that_of_the_page_with_its_own_names():
    text = listed("joints.rod-slider.film.viscosity")
    assert text in COMMANDS
    assert "joints.NAME.film.viscosity" in listed("viscosity")
    assert "example   loads: {gas: {scale: 1}}" in listed("loads.gas.scale")


def test_a_number_of_an_example_is_allowed():
    numbers = [row for _, row in KEYS if row.example and not row.example.startswith("[")]
    assert len(numbers) > 100
    for row in numbers:
        units = [quantity.replace_exponent(unit, 1.5) or "1" for unit in row.units]
        value = quantity.read(row.example, units[0])
        low, high = bounds(row.allowed)
        assert low <= value <= high, (row.key, row.example, row.allowed)


def bounds(allowed):
    """Return the ends of a range in the words of the page."""
    low = re.search(r"(?:above|at least|from) ([-\de.]+)|([-\de.]+) to", allowed)
    high = re.search(r"(?:below|up to|to) ([-\de.]+)", allowed)
    return (
        float(low.group(1) or low.group(2)) if low else float("-inf"),
        float(high.group(1)) if high else float("inf"),
    )


SECTION_EXAMPLES = section_examples(catalogue())


@pytest.mark.parametrize("name", [*SECTION_EXAMPLES, "seek.between", "identify.features", "geomspace", "sobol"])
def test_sections_that_choose_cases_are_explained(name):
    text = listed(name)
    assert "meaning" in text
    section = name.partition(".")[0]
    if section in SECTION_EXAMPLES:
        assert SECTION_EXAMPLES[section].split()[0] in text
        assert yaml.safe_load(SECTION_EXAMPLES[section]).keys() == {section}


def test_sections_that_choose_cases_all_have_an_example():
    assert {*section_texts(catalogue())} == {*SECTION_EXAMPLES}


def test_a_law_and_a_key_of_one_name_are_both_explained():
    text = listed("motor")
    assert "drive: motor" in text
    assert "drive.motor" in text
    assert "material" in listed("material")


def test_a_kind_of_joint_is_found_by_its_name():
    assert listed("gear").startswith("mechanism.joints.NAME.type\n  meaning   kind of the joint;")


def test_an_unknown_name_gets_the_nearest_key():
    message = str(CliRunner().invoke(verbs, ["list", "clearanse"]).exception)
    assert "unknown name 'clearanse'" in message
    assert "clearance" in message
    assert "`clearsweep list` prints" in message


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_the_lines_of_the_documentation_complete_commands(shell):
    (line,) = re.findall(rf"`([^`]*{shell}_source[^`]*)`", COMMANDS)
    variable, source = re.search(r"(\w+)=(\w+_source)", line).groups()
    command = [sys.executable, "-c", "from clearsweep.cli import verbs; verbs(prog_name='clearsweep')"]
    environment = os.environ | {variable: source}
    script = subprocess.run(command, env=environment, capture_output=True, text=True, check=True).stdout
    assert f"{variable}={shell}_complete" in script
    if shell == "bash":
        environment |= {variable: "bash_complete", "COMP_WORDS": "clearsweep st", "COMP_CWORD": "1"}
        words = subprocess.run(command, env=environment, capture_output=True, text=True, check=True).stdout
        assert words.split(",") == ["plain", "status\n"]
