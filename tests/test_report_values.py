"""The report shows the values that all cases share in the units in which their laws take them."""

import re

import fake_physics
import pytest
from fake_sweeps import sweep

from clearsweep import report
from clearsweep.sweeping.simulator import SIMULATION

pytestmark = pytest.mark.heavy

JOINT = "joints.rod-slider"
STEEL = {"young": "207 GPa", "poisson": 0.3}
SLIDES = {"coefficient": 0.1, "static_coefficient": 0.15, "stribeck_velocity": 2e-3}
LAYER = {"law": "hertz", "elastic": "winkler", "material": STEEL, "thickness": "5 mm"}
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
def shown(tmp_path_factory):
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
        ("kuwabara-kono, lugre", "contact.stiffness", "66.1 \u00d7 10⁹ N/m¹·⁵"),
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
def test_a_value_of_a_law_is_shown_in_the_unit_the_law_takes_it_in(shown, name, key, text):
    assert shown(name, f"{JOINT}.{key}") == text


def test_values_beside_the_joints_are_shown_in_their_units(shown):
    expected = {
        "mechanism.crank.length": "50 mm",
        "mechanism.crank.mass": "0.3 kg",
        "mechanism.crank.inertia": "100 \u00d7 10⁻⁶ kg m²",
        "mechanism.rod.center": "60 mm",
        "drive.speed": "5000 rpm",
        "simulate.tolerance": "1 \u00d7 10⁻⁸",
        "simulate.revolutions": "10",
    }
    assert {path: shown("kuwabara-kono, lugre", path) for path in expected} == expected
