"""Claims about materials as categories: an axis names them, and every case has the numbers of its name."""

from pathlib import Path

import pytest
from fake_runs import JOINT
from right_grids import text_of

from clearsweep import grid as grids
from clearsweep import simulation
from clearsweep.grid.library import MATERIALS

BEARING = f"{JOINT}.contact.material.bearing"
CATALOGUE = simulation.catalogue()
TEXT = text_of("materials that vary")


@pytest.fixture
def real_at(tmp_path, monkeypatch):
    """Return a function that writes a text as grid.yaml and loads it with all laws."""
    monkeypatch.chdir(tmp_path)

    def write(text):
        Path("grid.yaml").write_text(text, encoding="utf-8")
        return grids.load("grid.yaml", CATALOGUE)

    return write


@pytest.fixture
def names():
    """Two names of the library."""
    return "CuSn8", next(name for name in MATERIALS if name not in ("CuSn8", "100Cr6"))


def swept(names, more=""):
    return f"{TEXT}sweep: {{{BEARING}: [{', '.join(repr(name) for name in names)}]{more}}}\n"


def bearing_of(grid, index):
    return grid.written_case(index)["joints"]["rod-slider"]["contact"]["material"]["bearing"]


def test_every_case_has_the_numbers_of_its_name(real_at, names):
    grid = real_at(swept(names))
    assert grid.axes == {f"{BEARING}.name": names}
    for index, name in enumerate(names):
        assert bearing_of(grid, index) == {
            key: MATERIALS[name].values[key].typical for key in ("young", "poisson", "yield_strength")
        }


def test_identities_are_those_of_the_numbers(real_at, names):
    grid = real_at(swept(names))
    for index, name in enumerate(names):
        alone = real_at(TEXT.replace("bearing: CuSn8", f"bearing: {name!r}"))
        assert alone.case_id(0) == grid.case_id(index)


def test_a_resolved_grid_has_the_same_cases(real_at, names):
    grid = real_at(swept(names, ", drive.speed: [500 rpm, 1000 rpm]"))
    again = grids.load(grid.resolved(), CATALOGUE)
    assert [again.case_id(k) for k in range(4)] == [grid.case_id(k) for k in range(4)]
    assert grid.resolved()["joints"]["rod-slider"]["contact"]["material"]["bearing"] == {"name": "CuSn8"}


def test_a_number_next_to_the_name_takes_precedence_for_every_material(real_at, names):
    text = swept(names).replace("bearing: CuSn8", "bearing: {name: CuSn8, young: 99 GPa}")
    grid = real_at(text)
    assert [bearing_of(grid, k)["young"] for k in range(2)] == [99e9, 99e9]
    assert bearing_of(grid, 1)["poisson"] == MATERIALS[names[1]].values["poisson"].typical


def test_the_expansion_of_a_warm_joint_follows_the_name(real_at, names):
    thermal = "    thermal: {conductance: 2 W/K, ambient: 20 degC}\n"
    text = swept(names).replace("simulate:", f"{thermal}simulate:", 1)
    expansions = [real_at(text).written_case(k)["joints"]["rod-slider"]["thermal"]["expansion"] for k in range(2)]
    assert [expansion["bearing"] for expansion in expansions] == [
        MATERIALS[name].values["expansion"].typical for name in names
    ]
    assert expansions[0]["journal"] == expansions[1]["journal"]


def test_optimise_chooses_among_materials_and_starts_with_the_written_one(real_at, names):
    listed = ", ".join(repr(name) for name in names)
    over = f"{{{BEARING}: {{among: [{listed}]}}, drive.speed: [500 rpm, 1000 rpm]}}"
    grid = real_at(f"{TEXT}optimise: {{over: {over}, minimise: rod_slider_force_rms, cases: 32}}\n")
    assert grid.search.over[f"{BEARING}.name"].values == names
    assert grid.search.start[f"{BEARING}.name"] == "CuSn8"
    assert grid.point(0)[f"{BEARING}.name"] == "CuSn8"
    assert {bearing_of(grid, k)["young"] for k in range(16)} == {MATERIALS[n].values["young"].typical for n in names}
