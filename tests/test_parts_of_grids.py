"""The identities of a range of cases are those that the cases have in the whole grid, and cost no more."""

import itertools

import pytest
from fake_physics import CATALOGUE, grid

from clearsweep import grid as grids

LAW = "joints.rod-slider.contact.law"
LOSS = "joints.rod-slider.contact.restitution"
MASS, SPEED = "mechanism.slider.mass", "drive.speed"
SWEEPS = {
    "numbers": {MASS: [0.1, 0.2, 0.3], "mechanism.gravity": [0.0, 1.0], SPEED: [100.0, 200.0, 300.0, 400.0]},
    "laws": {LAW: ["hertz", "lankarani-nikravesh"], LOSS: [0.5, 0.7, 0.9], MASS: [0.1, 0.2]},
    "one": {MASS: [0.1]},
}


@pytest.mark.parametrize("name", SWEEPS)
def test_identities_of_any_range_are_those_of_the_whole(name):
    whole = grids.load(grid(sweep=SWEEPS[name]), CATALOGUE)
    ids, words = list(whole.identities()), list(whole.law_assignments())
    assert [f"{case_id:016x}" for case_id in ids] == [whole.case_id(index) for index in range(len(whole))]
    for first, last in itertools.combinations(range(len(whole) + 1), 2):
        assert list(whole.identities(range(first, last))) == ids[first:last]
        assert list(whole.law_assignments(range(first, last))) == words[first:last]


def test_added_cases_are_behind_the_product_in_a_range_too():
    whole = grids.load(grid(sweep=SWEEPS["numbers"]), CATALOGUE)
    point = whole.point(3) | {MASS: 0.7}
    whole = whole.with_added([point])
    ids = list(whole.identities())
    assert list(whole.identities(range(22, 25))) == ids[22:]
    assert list(whole.identities(range(24, 25))) == [int(whole.case_id(24), 16)]


def test_the_last_of_a_hundred_million_identities_come_at_once():
    many = [float(value) for value in range(1, 501)]
    whole = grids.load(grid(sweep={MASS: many, "mechanism.gravity": many, SPEED: many}), CATALOGUE)
    last = len(whole) - 3
    assert [f"{identity:016x}" for identity in whole.identities(range(last, len(whole)))] == [
        whole.case_id(index) for index in range(last, len(whole))
    ]


def test_a_plain_product_has_no_case_twice_and_says_so():
    plain = grids.load(grid(sweep=SWEEPS["laws"]), CATALOGUE)
    assert not plain.may_repeat
    assert len(set(plain.identities())) == len(plain)
    stepped = {"zip": {MASS: [0.1, 0.2], SPEED: [100.0, 200.0]}}
    assert grids.load(grid(sweep={"mechanism.gravity": [0.0]}, **stepped), CATALOGUE).may_repeat
