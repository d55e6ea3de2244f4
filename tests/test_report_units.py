"""The report shows fixed and shared values in the units of the key table and of the laws."""

import re

import fake_physics
import pytest
from fake_physics import sweep
from fake_runs import Run
from mechanism_cases import PAIR, changed

from clearsweep import grid, report, simulation
from clearsweep.grid.key_table import shape
from clearsweep.grid.keys import Number
from clearsweep.grid.pattern import nested
from clearsweep.language import quantity
from clearsweep.report import study
from clearsweep.report.section import Columns, Facts
from clearsweep.report.sections import setup
from clearsweep.sweeping.simulator import SIMULATION

CATALOGUE = simulation.catalogue()
JOINT = "joints.rod-slider"
BASE = {
    "mechanism": {
        "type": "slider-crank",
        "crank": {"length": 0.05, "mass": 0.3, "inertia": 1e-4},
        "rod": {"length": 0.12, "mass": 0.21, "inertia": 2.5e-4},
        "slider": {"mass": 0.14},
    },
    "drive": {"speed": 100.0},
    "joints": {
        "rod-slider": {
            "clearance": 1e-4,
            "bearing_radius": 0.01,
            "length": 0.02,
            "contact": {"law": "exact", "stiffness": 6.61e10, "restitution": 0.9},
        }
    },
}
LUGRE = {"law": "lugre", "coefficient": 0.1, "static_coefficient": 0.15, "stribeck_velocity": 0.1}
LUGRE |= {"bristle_stiffness": 1e4, "bristle_damping": 100.0, "viscous": 2.0}
KARNOPP = {"law": "karnopp", "coefficient": 0.1, "static_coefficient": 0.15, "stribeck_velocity": 0.1, "band": 0.02}
LOWERED = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹·", "-0123456789.")
STEEL = {"young": 207e9, "poisson": 0.3}


def shown(record) -> dict[str, str]:
    """Return dotted path -> what the page shows of the values that all cases share."""
    run = Run(sweep={}, histories=False, wear=False)
    run.grid = {key: value for key, value in run.grid.items() if key not in study.BASE} | record
    (section,) = setup.sections(study.prepare(run))
    (columns,) = (block for block in section.blocks if isinstance(block, Columns))
    facts = next(block for block in columns.columns[0] if isinstance(block, Facts) and block.label == "Fixed values")
    return dict(facts.rows)


def resolved(contact, friction=None, axes=None):
    """Return the record of a slider-crank with these sections."""
    joint = BASE["joints"]["rod-slider"] | {"contact": contact} | ({"friction": friction} if friction else {})
    source = BASE | {"joints": {"rod-slider": joint}} | ({"sweep": axes} if axes else {})
    return grid.load(source, CATALOGUE).resolved()


def written(text: str) -> str:
    """Return a quantity as a person would write it in a grid: '2 N*s/m^1.5' for '2 N s/m¹·⁵'."""
    number, _, unit = text.partition("\u00a0")
    unit = re.sub(r"[⁻⁰¹²³⁴⁵⁶⁷⁸⁹·]+", lambda power: f"^{power[0].translate(LOWERED)}", unit)
    return f"{number} {unit}".replace("\u00a0", "*").strip()


NAMED = tuple(mechanism for mechanism in CATALOGUE.mechanisms if mechanism.joints)  # else a grid names its keys


@pytest.mark.parametrize(
    "mechanism",
    [NAMED[0], *(pytest.param(each, marks=pytest.mark.slow) for each in NAMED[1:])],
    ids=[mechanism.name for mechanism in NAMED],
)
def test_every_key_is_shown_in_the_unit_that_the_key_table_gives(mechanism):
    checked = 0
    for path, node in shape(mechanism, CATALOGUE).items():
        for use in node.uses if isinstance(node, Number) else ():
            exponent = {f"{path.rpartition('.')[0]}.exponent": 2.5} if "^exponent" in use.field.unit else {}
            values = {path: 2.0, "mechanism.type": mechanism.name, **exponent}
            values |= {chooser: min(names) for chooser, names in use.when}
            text = shown(nested(values, ()))[path]
            unit = quantity.exponent_of(use.field.unit, 2.5)
            assert quantity.read(written(text), unit) == pytest.approx(2.0, rel=1e-5), (path, text, unit)
            checked += 1
    assert checked > 40


@pytest.mark.parametrize(
    ("contact", "friction", "path", "text"),
    [
        ({"law": "kuwabara-kono", "stiffness": 1e10, "damping": 2e3}, None, "contact.damping", "2000 N s/m¹·⁵"),
        ({"law": "kelvin-voigt", "stiffness": 1e8, "damping": 2e3}, None, "contact.damping", "2000 N s/m"),
        ({"law": "kelvin-voigt", "stiffness": 2e4, "damping": 2e3}, None, "contact.stiffness", "20 000 N/m"),
        (
            {"law": "exact", "elastic": "winkler", "material": STEEL, "thickness": 5e-3, "restitution": 0.7},
            None,
            "contact.thickness",
            "5 mm",
        ),
        (BASE["joints"]["rod-slider"]["contact"], LUGRE, "friction.stribeck_velocity", "0.1 m/s"),
        (BASE["joints"]["rod-slider"]["contact"], LUGRE, "friction.bristle_stiffness", "10 000 1/m"),
        (BASE["joints"]["rod-slider"]["contact"], LUGRE, "friction.bristle_damping", "100 s/m"),
        (BASE["joints"]["rod-slider"]["contact"], LUGRE, "friction.viscous", "2 s/m"),
        (BASE["joints"]["rod-slider"]["contact"], KARNOPP, "friction.band", "0.02 m/s"),
    ],
)
def test_the_parameters_of_laws_are_shown_with_their_units(contact, friction, path, text):
    row = shown(resolved(contact, friction))[f"{JOINT}.{path}"]
    assert row.replace("\u00a0", " ").replace("\u2009", " ") == text


def test_a_stiffness_beside_a_swept_law_has_the_exponent_that_the_law_takes_by_default():
    contact = {"law": "exact", "stiffness": 2e4, "restitution": 0.9}
    record = resolved(contact, axes={f"{JOINT}.contact.law": ["exact", "flores"]})
    assert grid.key_units(record, CATALOGUE)[f"{JOINT}.contact.stiffness"] == "N/m^1.5"


def test_a_value_that_laws_of_different_units_share_is_shown_with_both():
    contact = {"law": "ristow", "stiffness": 1e10, "damping": 100.0}
    record = resolved(contact, axes={f"{JOINT}.contact.law": ["ristow", "kuwabara-kono"]})
    assert grid.key_units(record, CATALOGUE)[f"{JOINT}.contact.damping"] == "N*s/m or N*s/m^1.5"


def test_a_swept_exponent_leaves_the_unit_open():
    record = resolved(BASE["joints"]["rod-slider"]["contact"], axes={f"{JOINT}.contact.exponent": [1.0, 1.5]})
    assert grid.key_units(record, CATALOGUE)[f"{JOINT}.contact.stiffness"] == "N/m^exponent"


def test_the_masses_of_a_pair_are_shown_in_kilograms():
    assert shown(grid.load(PAIR, CATALOGUE).resolved())["mechanism.masses"].count("kg") == 2


def test_laws_of_another_version_leave_their_values_bare_and_the_rest_in_units():
    record = changed(BASE, {f"{JOINT}.contact.law": "forgotten", f"{JOINT}.contact.gain": 3.0})
    facts = shown(record)
    assert facts[f"{JOINT}.contact.gain"] == "3"
    assert facts[f"{JOINT}.clearance"] == "0.1\u00a0mm"


@pytest.mark.parametrize("name", ["law_comparison", "two_joints", "impact_pair", "slider_crank", "thousand_cases"])
def test_swept_values_have_the_unit_that_the_grid_gives(name):
    cases = grid.load(f"configs/{name}.yaml", CATALOGUE)
    units = grid.key_units(cases.resolved(), CATALOGUE)
    assert {path: cases.unit(path) for path in cases.axes} == {path: units.get(path, "") for path in cases.axes}


def test_page_shows_the_unit_of_a_law_parameter(tmp_path):
    run = Run(sweep={}, histories=False, wear=False)
    run.grid |= resolved({"law": "kuwabara-kono", "stiffness": 1e10, "damping": 2e3})
    page = report.write(run, tmp_path / "page.html").read_text(encoding="utf-8")
    assert "2000\u00a0N\u00a0s/m¹·⁵" in page


pytestmark = pytest.mark.heavy

LUBRICATED_JOINT = "joints.rod-slider"
STEEL_PIN = {"young": "207 GPa", "poisson": 0.3}
SLIDES = {"coefficient": 0.1, "static_coefficient": 0.15, "stribeck_velocity": 2e-3}
LAYER = {"law": "hertz", "elastic": "winkler", "material": STEEL_PIN, "thickness": "5 mm"}
SECTIONS = {
    "kuwabara-kono, lugre": {
        "contact": {"law": "kuwabara-kono", "stiffness": "6.61e10 N/m^1.5", "damping": 120.0},
        "friction": SLIDES | {"law": "lugre", "bristle_stiffness": 5000.0, "bristle_damping": 316.0},
    },
    "kelvin-voigt, karnopp": {
        "contact": {"law": "kelvin-voigt", "stiffness": "2e4 N/m", "damping": 120.0},
        "friction": SLIDES | {"law": "karnopp", "band": 2e-4},
    },
    "layer, stribeck": {
        "contact": LAYER,
        "friction": SLIDES | {"law": "stribeck", "velocity_scale": 1e-4, "viscous": 0.04},
    },
}


class MadeUp(fake_physics.Fake):
    """Made-up results of any law there is."""

    catalogue = staticmethod(SIMULATION.catalogue)

    @staticmethod
    def derived(case):
        """Return nothing that follows from other values."""
        return {}


@pytest.fixture(scope="module")
def shared_values(tmp_path_factory):
    """Return a function: name of some laws, path -> the value on the page of a run with these laws."""
    pages = {}

    def value(name, path):
        if name not in pages:
            directory = tmp_path_factory.mktemp("values")
            source = fake_physics.grid(1, orbits="none")
            source["joints"]["rod-slider"] |= SECTIONS[name]
            run = sweep(source, directory / "run", executor="serial", show_progress=False, simulator=MadeUp).open()
            pages[name] = report.write(run, directory / "page.html").read_text(encoding="utf-8")
        (cell,) = re.findall(rf'<th scope="row">{re.escape(path)}</th><td>([^<]*)</td>', pages[name])
        return cell.replace("\u00a0", " ")

    return value


@pytest.mark.parametrize(
    ("name", "key", "text"),
    [
        ("kuwabara-kono, lugre", "clearance", "0.5 mm"),
        ("kuwabara-kono, lugre", "contact.stiffness", "6.61 \u00d7 10¹⁰ N/m¹·⁵"),
        ("kuwabara-kono, lugre", "contact.damping", "120 N s/m¹·⁵"),
        ("kuwabara-kono, lugre", "friction.bristle_stiffness", "5000 1/m"),
        ("kuwabara-kono, lugre", "friction.bristle_damping", "316 s/m"),
        ("kelvin-voigt, karnopp", "contact.stiffness", "20\u2009000 N/m"),
        ("kelvin-voigt, karnopp", "contact.damping", "120 N s/m"),
        ("kelvin-voigt, karnopp", "friction.band", "0.2 mm/s"),
        ("layer, stribeck", "contact.thickness", "5 mm"),
        ("layer, stribeck", "contact.material.young", "207 GPa"),
        ("layer, stribeck", "contact.material.poisson", "0.3"),
        ("layer, stribeck", "friction.stribeck_velocity", "2 mm/s"),
        ("layer, stribeck", "friction.velocity_scale", "0.1 mm/s"),
        ("layer, stribeck", "friction.viscous", "0.04 s/m"),
        ("layer, stribeck", "friction.shape", "2"),
        ("layer, stribeck", "friction.coefficient", "0.1"),
    ],
)
def test_a_value_of_a_law_is_shown_in_the_unit_the_law_takes_it_in(shared_values, name, key, text):
    assert shared_values(name, f"{LUBRICATED_JOINT}.{key}") == text


def test_values_beside_the_joints_are_shown_in_their_units(shared_values):
    expected = {
        "mechanism.crank.length": "50 mm",
        "mechanism.crank.mass": "0.3 kg",
        "mechanism.crank.inertia": "1 \u00d7 10⁻⁴ kg m²",
        "mechanism.rod.center": "60 mm",
        "drive.speed": "5000 rpm",
        "simulate.tolerance": "1 \u00d7 10⁻⁸",
        "simulate.revolutions": "10",
    }
    assert {path: shared_values("kuwabara-kono, lugre", path) for path in expected} == expected
