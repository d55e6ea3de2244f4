"""`clearsweep list KEY` explains every key of the page of keys, with an example that a grid may contain."""

import math
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
import yaml
from click.testing import CliRunner
from right_grids import text_of

from clearsweep import grid
from clearsweep.cli import verbs
from clearsweep.grid.pages import page_sections, section_examples, section_texts
from clearsweep.language import quantity
from clearsweep.mechanics.describe import REFERENCE, law_text
from clearsweep.mechanics.joints.registry import all_laws
from clearsweep.simulation import advice, advice_text, load_case, recommendations
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


# `clearsweep list --for GRID`: what laws say of where they hold, compared against a joint.


GRID = text_of("a crank with law and friction")


@pytest.fixture
def joint_grid(tmp_path):
    """Return a grid of a joint in two clearances, of which pereira allows one."""
    path = tmp_path / "grid.yaml"
    path.write_text(GRID, encoding="utf-8")
    return path


def test_the_arc_is_that_of_hertz():
    """1 kN on the reference joint: half-width 3.2611245e-4 m on a radius of 10 mm (Johnson 1985, section 4.2)."""
    assert advice.half_contact_arc(REFERENCE, 1000.0) == pytest.approx(math.asin(3.2611245e-2), rel=1e-7)


def verdict(joint, load, law):
    return next(each for each in advice.elastic_assessments(joint, load) if each.law == law)


def test_a_law_of_half_spaces_is_doubted_over_a_wide_arc_alone():
    close = REFERENCE._replace(clearance=5e-6)
    assert verdict(REFERENCE, 1e3, "johnson").rating == advice.SUITABLE
    assert verdict(close, 1e4, "johnson").rating == advice.DOUBTFUL
    assert "half-spaces (trusted for arc up to 10 deg)" in verdict(close, 1e4, "johnson").reason
    assert verdict(close, 1e4, "persson").rating == advice.SUITABLE
    assert "rigid circles" in verdict(REFERENCE, 1e3, "persson").reason


def test_a_load_beyond_the_depth_of_a_law_is_told_with_both():
    """Johnson's law is followed up to 2 exp(-2) of 4 c exp(-1)."""
    message = verdict(REFERENCE._replace(clearance=1e-6), 1e5, "johnson").reason
    assert f"deep under the load, valid up to {8.0 * math.exp(-3.0):.3f}\u00a0µm" in message


def line_of(path, law):
    """Return what is said of a law by its name."""
    lines = advice_text(path, law).splitlines()
    return next(line for line in lines if line.split()[:1] == [law])


def test_what_a_law_lacks_and_what_it_returns_is_told(joint_grid):
    said = "not here  clearance from 5e-06 to 0.01 m: it was fitted there (1 of 2 cases)"
    assert said in line_of(joint_grid, "pereira")
    assert "not here  needs thickness" in line_of(joint_grid, "winkler")
    assert "not here  needs mass" in line_of(joint_grid, "tsuji")
    assert "doubtful  has a restitution of 0.796 instead of 0.7" in line_of(joint_grid, "lankarani-nikravesh")
    assert "suitable" in line_of(joint_grid, "exact")
    message = advice_text(joint_grid)
    assert "radial clearance 4.000 um (diametral 8.000 um)" in message.replace("\u00b5", "u").replace("\u00a0", " ")


def test_one_law_of_each_family_is_recommended_and_doubtful_ones_are_folded(joint_grid):
    message = advice_text(joint_grid)
    (line,) = (line for line in message.splitlines() if line.startswith("Recommended for rod-slider: "))
    assert ": elastic law compatible (its contact arc follows" in line
    assert "; contact law exact (a free impact has the specified" in line
    assert line.endswith("The contact law in use, flores, is suitable.")
    (folded,) = (line for line in message.splitlines() if line.startswith("  doubtful: hertz,"))
    assert "lankarani-nikravesh" in folded
    assert re.search(r"The choice among the \d+ valid elastic laws changes the force up to [\d.]+ times at", message)


def test_a_written_stiffness_is_recommended(tmp_path):
    path = tmp_path / "grid.yaml"
    path.write_text(
        GRID.replace("elastic: johnson, material: {young: 207 GPa, poisson: 0.3}", "stiffness: 1e9 N/m^1.5"),
        encoding="utf-8",
    )
    message = advice_text(path)
    assert "Recommended for rod-slider: elastic law power (its stiffness is given in the grid), in use; " in message
    (first, *_) = recommendations(load_case(path, {"sweep": None}).case)
    assert (first.law, first.rating) == ("power", advice.SUITABLE)


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("rod_slider_force_peak", "largest normal force"),
        ("slider_error_max", "slider"),
        ("crank_torque_peak", "torque"),
    ],
)
def test_a_column_of_the_summary_is_explained(name, words):
    text = advice.laws_text(name)
    assert text.startswith(f"{name}\n")
    assert words in text


FILM = """
    film: {law: finite, viscosity: 0.4 Pa*s}
    roughness: {law: fractal, dimension: 1.5, scale: 0.1 nm, hardness: 2 GPa}
"""


def test_films_are_chosen_by_length_and_rough_surfaces_by_depth(tmp_path):
    path = tmp_path / "oiled.yaml"
    path.write_text(GRID.replace("    contact:", f"{FILM.strip(chr(10))}\n    contact:"), encoding="utf-8")
    assert "suitable" in line_of(path, "finite")  # 20 mm on 20 mm
    assert "a longer bearing carries less (trusted for length / diameter up to 0.5)" in line_of(path, "short")
    assert "doubtful" in line_of(path, "long")
    assert "doubtful" in line_of(path, "pinkus-sternlicht")
    assert "deep under the load" in line_of(path, "fractal")


def test_one_law_is_asked_for_by_its_name(joint_grid):
    message = CliRunner().invoke(verbs, ["list", "power", "--for", str(joint_grid)], catch_exceptions=False).stdout
    assert "the stiffness from `material` is that of a ball in a socket" in message
    assert "johnson" not in message


@pytest.mark.parametrize("law", [law for law in all_laws() if law.ranges or law.trusted or law.unsound])
def test_a_law_states_its_ranges_where_it_is_described(law):
    message = " ".join(law_text(law.name).split())
    assert all(limit.reason in message for limit in (*law.ranges, *law.trusted))
    assert law.unsound in message
