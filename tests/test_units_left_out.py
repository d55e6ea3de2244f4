"""Numbers without a unit in a grid file: refused next to others with one, else said; sizes that no machine has."""

import pytest
import yaml
from fake_runs import CATALOGUE, TEXT

from clearsweep import grid, simulation
from clearsweep.sweeping.facts import assumed_sentences

BARE = """\
mechanism:
  type: slider-crank
  crank: {length: 50, mass: 0.30, inertia: 1e-4}
  rod: {length: 120, mass: 0.21, inertia: 2.5e-4, center: 60}
  slider: {mass: 0.14}
drive: {speed: 1500}
joints:
  rod-slider: {clearance: 0.1, bearing_radius: 10, contact: {law: flores, stiffness: 6.61e10, restitution: 0.5}}
"""


@pytest.mark.parametrize(
    "change",
    [
        ("center: 60 mm", "center: 0"),  # 0 is the same in every unit
        ("revolutions: 10", "revolutions: 12"),
        ("stiffness: 6.61e10 N/m^1.5", "stiffness: 6.61e10"),  # no length, mass or speed
        ("restitution: 0.9", "restitution: 0.7"),
    ],
)
def test_zero_counts_and_pure_numbers_need_no_unit(at, change):
    assert len(at(TEXT.replace(*change))) == 1


def test_dicts_and_overrides_may_mix(at):
    assert at(TEXT, {"drive.speed": 100}).case(0).drive.speed == 100.0
    mixed = yaml.safe_load(TEXT) | {"drive": {"speed": 100.0}}
    assert grid.load(mixed, CATALOGUE).case(0).drive.speed == 100.0
    source = grid.OverriddenGrid("grid.yaml", {"drive.speed": "100"}, {"mechanism.slider.mass": "0.1, 0.2"})
    assert grid.load(source, CATALOGUE).case(0).drive.speed == 100.0


def test_a_bare_grid_says_what_was_read(at):
    (sentence,) = assumed_sentences(at(BARE))
    assert sentence.startswith("no unit given, SI assumed: crank speed 1500 rad/s = 14,324 rpm, crank length 50 m, ")
    assert "clearance 0.1 m = 100 mm" in sentence
    assert not assumed_sentences(at(TEXT))
    assert not assumed_sentences(grid.load(yaml.safe_load(BARE), CATALOGUE))  # numbers of a program are in SI


def test_sizes_that_no_machine_has_are_remarked_on(at):
    sentence = next(text for text in simulation.warnings(at(BARE).case(0)) if "sizes that no machine has" in text)
    for text in (
        "mechanism.crank has 0.006 kg per metre of its length, 50 m",
        "mechanism.rod is 120 m long",
        "the end of crank moves at 7.5e+04 m/s",
        "a pin of 20 m diameter",
        "joints.rod-slider.clearance is 100 mm",
    ):
        assert text in sentence
    assert not any("no machine" in text for text in simulation.warnings(at(TEXT).case(0)))
