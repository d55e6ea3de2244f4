"""Materials, oils and wear pairs by name: values within their ranges, standards, what a case makes of a name."""

import copy
import re
import runpy
from pathlib import Path

import pytest
from click.testing import CliRunner
from fake_runs import JOINT
from mechanism_cases import slider_crank
from right_grids import text_of

from clearsweep import cli, grid, simulation
from clearsweep import grid as grids
from clearsweep.answers import validity
from clearsweep.contracts.case import NO_CONTACT, Joint
from clearsweep.grid import library
from clearsweep.grid.library import MATERIALS
from clearsweep.sweeping.pool.case_runner import SIMULATION
from clearsweep.sweeping.sweep import facts

ENTRIES = [(kind, entry) for kind, known in library.LIBRARIES.items() for entry in known.values()]
BOTH = {"bearing": "CuSn8", "journal": "100Cr6"}
OIL_TOOL = runpy.run_path(str(Path(__file__).parents[1] / "docs/tools/oils.py"))
warm_viscosity = OIL_TOOL["warm_viscosity"]


def with_joint(section, value, **more):
    changes = {f"{JOINT}.{section}": value, f"{JOINT}.length": "20 mm"} | more
    return grid.load(slider_crank("rod-slider", changes=copy.deepcopy(changes)), simulation.catalogue())


def test_every_value_lies_in_its_range_and_every_entry_has_a_source():
    for kind, entry in ENTRIES:
        assert entry.source, (kind, entry.name)
        assert entry.summary, (kind, entry.name)
        for key, value in entry.values.items():
            assert 0.0 < value.low <= value.typical <= value.high, (entry.name, key)
            assert value.low < value.high or kind == "bearings", (entry.name, key)


def test_the_coefficients_of_archard_are_those_of_a_reprint():
    reprinted = {"mild": 7e-3, "hard tool": 1.3e-4, "brass": 6e-4, "PTFE": 2.5e-5}  # Wikipedia, Wear coefficient
    pairs = [entry for entry in library.PAIRS.values() if entry.checked]
    coefficients = sorted(float(entry.source.rpartition(": ")[2].partition(",")[0]) for entry in pairs)
    assert coefficients == sorted(reprinted.values())


PUBLISHED = {  # data sheets and standards of each alloy; strengths and hardnesses as least and largest
    "S355": {"young": 210e9, "poisson": 0.3, "density": 7850, "expansion": 12e-6, "yield_strength": (335e6, 355e6)},
    "C45": {"yield_strength": (275e6, 340e6), "hardness": (162 * 9.81e6, 190 * 9.81e6), "young": 210e9},
    "16MnCr5": {"yield_strength": (440e6, 735e6)},  # core of test pieces of 11 to 63 mm
    "100Cr6": {"young": 210e9, "poisson": 0.3, "expansion": 11.4e-6},
    "EN-GJS-400-15": {"yield_strength": 250e6, "hardness": (135 * 9.81e6, 180 * 9.81e6), "young": 169e9},
    "EN-GJS-700-2": {"yield_strength": 420e6, "hardness": (225 * 9.81e6, 305 * 9.81e6), "young": 176e9},
    "CuSn8": {"density": 8800, "young": (109e9, 115e9), "expansion": 18.2e-6, "yield_strength": (190e6, 500e6)},
    "EN AW-6082-T6": {"density": 2700, "young": 70e9, "expansion": 23.4e-6, "hardness": 95 * 9.81e6},
    "EN AW-7075-T6": {"density": 2800, "young": (70e9, 72e9), "expansion": 23.4e-6, "yield_strength": (460e6, 503e6)},
    "PTFE": {"hardness": (25e6, 37e6), "young": (0.4e9, 0.7e9), "yield_strength": 10e6, "density": (2140, 2190)},
    "POM": {"young": (2.5e9, 3.0e9), "yield_strength": (65e6, 72e6), "hardness": 125e6, "expansion": 120e-6},
}


@pytest.mark.parametrize("name", PUBLISHED)
def test_a_checked_material_has_the_values_of_data_sheets_in_its_range(name):
    assert library.MATERIALS[name].checked
    for key, published in PUBLISHED[name].items():
        low, high = published if isinstance(published, tuple) else (published, published)
        value = library.MATERIALS[name].values[key]
        assert value.low <= 1.01 * low, (key, value)
        assert value.high >= 0.99 * high, (key, value)


def test_only_compared_entries_count_as_checked():
    assert {name for name, entry in library.MATERIALS.items() if entry.checked} == set(PUBLISHED)


def test_oils_differ_in_density_by_grade():
    densities = [library.OILS[f"ISO VG {grade}"].values["density"].typical for grade in (10, 46, 220, 1500)]
    assert densities == pytest.approx([850.0, 870.0, 890.0, 915.0], abs=1.0)


@pytest.mark.parametrize(
    ("section", "value"),
    [
        ("wear", {"pair": "steel/POM dry"}),
        ("contact", {"law": "flores", "restitution": 0.5, "material": "PA66"}),
        ("contact", {"law": "flores", "restitution": 0.5, "material": {"bearing": "CuSn12-C", "journal": "C45"}}),
    ],
)
def test_values_from_memory_need_consent(section, value):
    material = value.get("material")
    if isinstance(material, str):
        value = value | {"material": {"name": material, "unchecked": True}}
    elif material:
        value = value | {"material": {"bearing": {"name": material["bearing"], "unchecked": True}, "journal": "C45"}}
        both = value | {"material": material | {"unchecked": True}}
        assert with_joint(section, both).case_id(0) == with_joint(section, value).case_id(0)
    else:
        value = value | {"unchecked": True}
    assert len(with_joint(section, value)) == 1


def test_a_swept_material_from_memory_needs_consent_too():
    contact = {"law": "flores", "restitution": 0.5, "material": {"bearing": "CuSn8", "journal": "C45"}}
    axis = {"sweep": {f"{JOINT}.contact.material.bearing": ["CuSn8", "CuSn12-C"]}}
    contact["material"]["unchecked"] = True
    made = with_joint("contact", contact, **axis)
    assert len(made) == len(grid.load(made.resolved(), simulation.catalogue())) == 2


def coefficients(wear, **more):
    values = with_joint("wear", {"unchecked": True} | wear, **more).case(0).joints[0].wear.values
    return values["bearing_coefficient"], values["journal_coefficient"]


def test_of_unlike_bodies_only_the_softer_wears():
    pom = library.PAIRS["steel/POM dry"].values["coefficient"].typical
    assert coefficients({"pair": "steel/POM dry"}) == (pom, 0.0)  # as in a bush
    contact = {"law": "flores", "restitution": 0.5, "material": {"bearing": "C45", "journal": "POM"}}
    assert coefficients({"pair": "steel/POM dry"}, **{f"{JOINT}.contact": contact}) == (0.0, pom)
    assert coefficients({"pair": "steel/POM dry", "coefficient": "2e-15 m^2/N"}) == (2e-15, 0.0)
    assert coefficients({"pair": "steel/POM dry", "journal_coefficient": "1e-18 m^2/N"}) == (pom, 1e-18)
    steel = library.PAIRS["hardened steel/steel dry"].values["coefficient"].typical
    assert coefficients({"pair": "hardened steel/steel dry"}) == (steel, steel)
    message, _ = facts(with_joint("wear", {"pair": "steel/POM dry", "unchecked": True}), SIMULATION)
    assert message[f"{JOINT}.wear.journal_coefficient (steel/POM dry)"]["max"] == 0.0


@pytest.mark.parametrize(
    ("pair", "material", "fits"),
    [
        ("steel/POM dry", {"bearing": "POM", "journal": "C45"}, True),
        ("steel/POM dry", {"bearing": "100Cr6", "journal": "POM"}, True),
        ("steel/POM dry", {"bearing": "CuSn8", "journal": "100Cr6"}, False),
        ("steel/POM dry", "C45", False),
        ("steel/cast iron greased", {"bearing": "EN-GJL-250", "journal": "42CrMo4"}, True),
        ("hardened steel/steel dry", "16MnCr5", True),
        ("steel/bronze dry", {"bearing": "CuAl10Ni5Fe4", "journal": "S355"}, True),
        ("steel/bronze dry", {"bearing": "EN AW-6082-T6", "journal": "S355"}, False),
    ],
)
def test_a_pair_of_other_materials_than_those_of_the_joint_is_noted(pair, material, fits):
    material = {"bearing": material, "journal": material} if isinstance(material, str) else material
    contact = {"law": "flores", "restitution": 0.5, "material": {"unchecked": True} | material}
    made = with_joint("wear", {"pair": pair, "unchecked": True}, **{f"{JOINT}.contact": contact})
    assert [pair in warning for warning in made.warnings] == ([] if fits else [True])


def test_the_remark_on_a_worn_bearing_agrees_with_the_pairs():
    joint = Joint("rod-slider", 1e-4, NO_CONTACT, bearing_radius=0.01)
    text = validity.wear_rate_remark([(joint, 1.0)])
    for name in ("steel/bronze greased", "steel/bronze dry"):
        known = library.PAIRS[name].values["coefficient"]
        assert f"{known.low:g} to {known.high:g}".replace("e-0", "e-") in text
    high = library.PAIRS["steel/steel dry"].values["coefficient"].high
    assert f"{high:g}" in text


def test_steels_irons_bronzes_aluminium_and_plastics_exist_with_all_their_values():
    names = " ".join(library.MATERIALS)
    for expected in ("100Cr6", "GJL", "CuSn", "EN AW", "PTFE", "POM", "PA66"):
        assert expected in names
    for entry in library.MATERIALS.values():
        assert set(entry.values) == {"young", "poisson", "density", "yield_strength", "hardness", "expansion"}
        assert entry.values["poisson"].high < 0.5
        assert entry.values["hardness"].typical > entry.values["yield_strength"].typical


def test_the_viscosity_index_is_that_of_the_examples_of_the_standard():
    # ASTM D2270: 73.30 and 8.86 mm^2/s have VI 92 (L 119.94, H 69.48); 22.83 and 5.05 have 156
    assert warm_viscosity(8.86, 92.4) == pytest.approx(73.30, rel=1e-3)
    assert warm_viscosity(5.05, 156.4) == pytest.approx(22.83, rel=2e-3)
    # its reference oils: L and H at 5, 10, 20 and 30 mm^2/s
    for hot, low, high in ((5.0, 40.23, 28.49), (10.0, 147.7, 82.87), (20.0, 493.2, 229.5), (70.0, 4905.0, 1558.0)):
        assert warm_viscosity(hot, 0.0) == pytest.approx(low, rel=2e-3)
        assert warm_viscosity(hot, 100.0) == pytest.approx(high, rel=2e-3)


def test_the_formula_of_the_viscosity_index_has_no_jumps():
    for border in (3.8, 4.4, 5.0, 6.4, 7.0, 7.7, 9.0, 12.0, 15.0, 18.0, 22.0, 28.0, 40.0, 55.0, 70.0):
        for index in (0.0, 95.0):
            below, above = warm_viscosity(border * (1.0 - 1e-9), index), warm_viscosity(border, index)
            assert above == pytest.approx(below, rel=3e-3), border


def test_a_grade_has_its_viscosity_at_40_degrees_and_index_95():
    for grade in (10, 46, 320, 1500):
        values = library.OILS[f"ISO VG {grade}"].values
        assert values["at_40C"].typical == pytest.approx(grade * 1e-6)
        assert warm_viscosity(1e6 * values["at_100C"].typical, 95.0) == pytest.approx(grade, rel=1e-9)
    assert OIL_TOOL["hot_viscosity"](46.0, 95.0) == pytest.approx(6.65, abs=0.05)  # 6.6 to 6.8 on data sheets
    numbers = re.compile(r"(?<=[ |])[\d.]+(?:e-\d+)?(?=[ |])")
    made, stored = OIL_TOOL["table"](), OIL_TOOL["FILE"].read_text(encoding="utf-8")
    assert numbers.sub("", made) == numbers.sub("", stored)
    assert list(map(float, numbers.findall(made))) == pytest.approx(list(map(float, numbers.findall(stored))), 1e-12)


def test_a_name_gives_the_case_of_its_numbers():
    values = {name: library.MATERIALS[name].values for name in BOTH.values()}
    written = {
        body: {key: values[name][key].typical for key in ("young", "poisson", "yield_strength")}
        for body, name in BOTH.items()
    }
    contact = {"law": "lankarani-nikravesh", "restitution": 0.8}
    named, plain = (with_joint("contact", contact | {"material": each}) for each in (BOTH, written))
    assert named.case_id(0) == plain.case_id(0)
    assert named.case(0).joints[0].contact.material.bearing.young == pytest.approx(115e9)


def test_numbers_next_to_a_name_override():
    first = {"name": "cusn8", "young": "100 GPa"}
    contact = {"law": "lankarani-nikravesh", "restitution": 0.8, "material": first}
    made = with_joint("contact", contact)
    bearing, journal = made.case(0).joints[0].contact.material
    assert bearing == journal
    assert (bearing.young, bearing.poisson) == (100e9, 0.34)
    assert [each.path.rpartition(".")[2] for each in made.library_values] == ["poisson", "yield_strength"]
    wear = (
        with_joint("wear", {"unchecked": True, "pair": "steel/bronze greased", "coefficient": "1e-15 m^2/N"})
        .case(0)
        .joints[0]
        .wear
    )
    assert (wear.values["bearing_coefficient"], wear.law) == (1e-15, "archard")


def test_an_oil_gives_the_viscosity_at_a_temperature():
    film = with_joint("film", {"oil": "ISO VG 46", "temperature": "40 degC"}).case(0).joints[0].film
    assert film.viscosity == pytest.approx(46e-6 * 870.0, rel=1e-9)
    both = with_joint(
        "film", {"oil": "iso vg 46", "viscosity": {"density": "900 kg/m^3"}, "temperature": "40 degC"}
    ).case(0)
    assert both.joints[0].film.viscosity == pytest.approx(46e-6 * 900.0, rel=1e-9)


def test_what_is_taken_is_reported_with_its_range():
    made = with_joint("wear", {"unchecked": True, "pair": "steel/bronze greased"})
    message, _ = facts(made, SIMULATION)
    path = f"{JOINT}.wear.coefficient (steel/bronze greased"
    known = library.PAIRS["steel/bronze greased"].values["coefficient"]
    assert message[f"{path})"]["min"] == known.typical
    assert (message[f"{path}, range)"]["min"], message[f"{path}, range)"]["max"]) == known[2:]
    swept = with_joint(
        "wear", {"unchecked": True, "pair": "steel/bronze greased"}, sweep={f"{JOINT}.wear.coefficient": [1e-15, 2e-15]}
    )
    assert ([item.path for item in swept.library_values], len(swept)) == ([f"{JOINT}.wear.journal_coefficient"], 2)


def test_the_published_range_is_an_uncertainty_of_a_life():
    path = f"{JOINT}.wear.coefficient"
    life = {"limit": "20 um", "joint": "rod-slider"}
    made = with_joint(
        "wear", {"unchecked": True, "pair": "steel/bronze greased"}, life=life, uncertain={path: "published"}
    )
    known = library.PAIRS["steel/bronze greased"].values["coefficient"]
    (each,) = made.case(0).uncertain
    assert each.low == pytest.approx(known.low * (known.high / known.low) ** 0.025, rel=1e-9)
    assert each.high == pytest.approx(known.low * (known.high / known.low) ** 0.975, rel=1e-9)


def test_every_library_and_entry_is_printed():
    run = CliRunner()
    for kind, known in library.LIBRARIES.items():
        printed = run.invoke(cli.verbs, ["list", kind]).output
        for name, entry in known.items():
            assert f"{name}: {entry.summary}"[:60] in printed
            assert {"source:", "checked:"} <= set(run.invoke(cli.verbs, ["list", name]).output.split())
    assert "did you mean 'materials'" in str(run.invoke(cli.verbs, ["list", "matrials"]).exception)


# ---------------------------------------------------------------------------------------------- materials that vary


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
