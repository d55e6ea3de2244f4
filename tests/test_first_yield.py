"""The speed at which a contact first yields: loads by quadrature, energies by quadrature, masses by trial."""

import math
from functools import partial

import numpy as np
import pytest
from mechanism_cases import PAIR, slider_crank
from scipy.integrate import quad

import clearsweep
from clearsweep.contracts.case import Contact, Joint, Material, Materials, Wear
from clearsweep.mechanics.joints import registry
from clearsweep.mechanics.laws.elastic import elastic_force, plane_strain_modulus, relative_radius, static_penetration
from clearsweep.simulation.remarks import largest_masses, yield_speeds
from clearsweep.simulation.setup.scene import build, catalogue

STEEL = Material(207e9, 0.3, 600e6)
RADIUS, LENGTH, MASS = 10e-3, 20e-3, 0.14


def joint(elastic="compatible", clearance=0.1e-3, material=STEEL, **more):
    materials = Materials(material, material) if material else None
    contact = Contact("hertz", elastic, {"exponent": 1.5, **more.pop("values", {})}, materials)
    return Joint("rod-slider", clearance, contact, RADIUS, LENGTH, **more)


def speed(made):
    """Return the approach speed (m/s) at which a joint first yields under MASS."""
    return math.sqrt(2.0 * registry.yield_energy(made, registry.compile_contact(made)[1]) / MASS)


@pytest.mark.parametrize("degrees", [3.0, 20.0, 60.0, 77.0])
def test_the_load_of_a_line_is_the_integral_of_the_pressure_over_its_arc(degrees):
    made, half = joint(), math.radians(degrees)
    modulus, s = plane_strain_modulus(made.contact.material), math.sin(0.5 * half)
    whole = made.clearance / (1.0 - s * s * (math.log(4.0 / (s * s)) - 1.0))  # c + pen

    def pressure(phi):
        return modulus * whole / RADIUS * math.cos(0.5 * phi) * math.sqrt(max(s * s - math.sin(0.5 * phi) ** 2, 0.0))

    load = RADIUS * LENGTH * quad(lambda phi: pressure(phi) * math.cos(phi), -half, half, epsrel=1e-10)[0]
    assert registry.load_at_pressure("line", pressure(0.0), made, modulus) == pytest.approx(load, rel=1e-6)


def test_narrow_contacts_have_the_loads_of_hertz():
    made = joint(clearance=2e-3)
    modulus, radius = plane_strain_modulus(made.contact.material), relative_radius(made)
    line = math.pi * radius * LENGTH * (0.1e9) ** 2 / modulus  # p0 = sqrt(f E* / (pi R))
    # R = R_b R_j / c of the line is R_b^2 / c here: the bodies are bent to one radius
    line *= RADIUS / (RADIUS - made.clearance)
    assert registry.load_at_pressure("line", 0.1e9, made, modulus) == pytest.approx(line, rel=2e-3)
    ball = registry.load_at_pressure("ball", 0.1e9, made, modulus)
    assert (6.0 * ball * modulus**2 / (math.pi**3 * radius**2)) ** (1.0 / 3.0) == pytest.approx(0.1e9, rel=1e-12)


def test_a_ball_that_fills_its_socket_bears_what_a_pressure_over_half_of_it_does():
    made = joint("power", 20e-6)
    modulus, pressure = plane_strain_modulus(made.contact.material), 1e9
    bore = quad(lambda t: 2.0 * math.pi * RADIUS**2 * pressure * math.cos(t) ** 2 * math.sin(t), 0.0, 0.5 * math.pi)[0]
    assert registry.load_at_pressure("ball", pressure, made, modulus) == pytest.approx(bore, rel=1e-9)


@pytest.mark.parametrize(
    ("elastic", "clearance", "known"),
    [("power", 500e-6, 1.6), ("johnson", 500e-6, 6.2), ("johnson", 20e-6, 10.0), ("compatible", 100e-6, 11.2)],
)
def test_steel_first_yields_at_metres_a_second_and_not_at_centimetres(elastic, clearance, known):
    """Hertz's load by hand gives 1.6 and 6.2; the others are of arcs that reach round the bore."""
    assert speed(joint(elastic, clearance)) == pytest.approx(known, rel=0.08)


@pytest.mark.parametrize("elastic", ["power", "johnson", "compatible", "persson", "liu"])
def test_the_energy_is_the_work_up_to_the_load_at_first_yield(elastic):
    made = joint(elastic)
    term, modulus = registry.compile_contact(made)[1], plane_strain_modulus(made.contact.material)
    kind = registry.contact_kind(made)
    load = registry.load_at_pressure(kind, {"line": 1.67, "ball": 1.6}[kind] * 600e6, made, modulus)
    depth = static_penetration(term, load)
    work = quad(partial(elastic_force, term), 0.0, depth, limit=200, epsrel=1e-9)[0]
    assert registry.yield_energy(made, term) == pytest.approx(work, rel=1e-5)


def test_the_weaker_body_or_a_hardness_decides_and_without_both_nothing_is_judged():
    soft = STEEL._replace(yield_strength=200e6)
    made = joint()
    assert made._replace(contact=made.contact._replace(material=Materials(STEEL, soft))).strength == 200e6
    bare = joint(material=STEEL._replace(yield_strength=None))
    assert bare.strength is None
    assert registry.yield_energy(bare, registry.compile_contact(bare)[1]) is None
    hard = bare._replace(wear=Wear("archard", "mean", 360, {"hardness": 2.8e9}))
    assert hard.strength == pytest.approx(1e9)
    assert speed(hard) > speed(joint())


def test_a_stiffness_of_hertz_gives_the_modulus_where_no_material_does():
    given = joint("power", 0.5e-3)
    stiffness = registry.compile_contact(given)[1].stiffness
    wear = Wear("archard", "mean", 360, {"hardness": 2.8 * 600e6})
    bare = joint("power", 0.5e-3, None, values={"stiffness": stiffness}, wear=wear)
    assert speed(bare) == pytest.approx(speed(given), rel=1e-9)
    other = joint("power", 0.5e-3, None, values={"stiffness": stiffness, "exponent": 1.2}, wear=wear)
    assert registry.yield_energy(other, registry.compile_contact(other)[1]) is None


def test_the_largest_mass_is_that_of_the_best_of_many_directions():
    yields = np.array([[9.0, -5.0], [-5.0, 12.0]])  # 1/kg

    def mass(angle):
        way = np.array([math.cos(angle), math.sin(angle)])
        return 1.0 / (way @ yields @ way)

    distance = np.array([mass(angle) for angle in (0.0, 0.25 * math.pi, 0.5 * math.pi)])
    assert registry.largest_mass(distance) == pytest.approx(max(map(mass, np.linspace(0.0, math.pi, 20001))), rel=1e-7)
    assert registry.largest_mass(np.zeros(3)) is None


MATERIAL = {"young": "207 GPa", "poisson": 0.3, "yield_strength": "600 MPa"}


def machine(law="hertz", **material):
    contact = {"law": law, "elastic": "johnson", "material": {**MATERIAL, **material}}
    return clearsweep.load_case(slider_crank("rod-slider", changes={"joints.rod-slider.contact": contact}))


def test_a_slider_crank_yields_under_the_mass_of_its_slider():
    scene = machine()
    result = joint("johnson", scene.case.joints[0].clearance)._replace(length=scene.case.joints[0].length)
    result = result._replace(bearing_radius=scene.case.joints[0].bearing_radius)
    energy = registry.yield_energy(result, registry.compile_contact(result)[1])
    slider = scene.case.mechanism.values["slider.mass"]  # at crank angle 0 it moves alone along the rod
    assert yield_speeds(scene) == {"rod_slider_yield_speed": pytest.approx(math.sqrt(2.0 * energy / slider), rel=1e-9)}
    assert "rod_slider_yield_speed" in scene.layout.units


def test_laws_that_yield_are_not_judged_and_unknown_strengths_have_no_column():
    contact = {"law": "lankarani-nikravesh-plastic", "restitution": 0.7, "elastic": "johnson", "material": MATERIAL}
    yielding = clearsweep.load_case(slider_crank("rod-slider", changes={"joints.rod-slider.contact": contact}))
    assert yield_speeds(yielding) == {"rod_slider_yield_speed": None}
    bare = {key: value for key, value in MATERIAL.items() if key != "yield_strength"}
    contact = {"law": "hertz", "elastic": "johnson", "material": bare}
    unknown = clearsweep.load_case(slider_crank("rod-slider", changes={"joints.rod-slider.contact": contact}))
    assert yield_speeds(unknown) == {}
    assert "rod_slider_yield_speed" not in unknown.layout.units


def test_the_speed_can_be_limited_and_an_impact_pair_has_its_own():
    contact = {"law": "hertz", "elastic": "johnson", "material": MATERIAL}
    limits = {"rod_slider_yield_speed": {"at_least": "2 m/s"}}
    assert machine().case.joints[0].strength == 600e6
    source = slider_crank("rod-slider", changes={"joints.rod-slider.contact": contact, "limits": limits})
    assert clearsweep.load_case(source).verdict.limits[0].value == 2.0
    pair = {"clearance": 1e-4, "bearing_radius": RADIUS, "length": LENGTH, "contact": contact}
    source = PAIR | {"joints": {"pair": pair}, "limits": {"pair_yield_speed": {"at_least": 2.0}}}
    scene = clearsweep.load_case(source)
    masses = [scene.case.mechanism.values[f"masses.{place}"] for place in (0, 1)]
    energy = registry.yield_energy(scene.case.joints[0], registry.compile_contact(scene.case.joints[0])[1])
    reduced = masses[0] * masses[1] / sum(masses)
    assert yield_speeds(scene)["pair_yield_speed"] == pytest.approx(math.sqrt(2.0 * energy / reduced), rel=1e-9)


def test_cases_with_one_mechanism_and_start_share_the_effective_masses():
    contact = {"law": "hertz", "elastic": "johnson", "material": MATERIAL}
    source = slider_crank("rod-slider", changes={"joints.rod-slider.contact": contact, "simulate.start": "centred"})
    source["sweep"] = {"joints.rod-slider.clearance": {"linspace": ["0.05 mm", "0.5 mm", 10]}}
    cases = clearsweep.grid.load(source, catalogue())
    largest_masses.cache_clear()
    for index in range(len(cases)):
        yield_speeds(build(cases.case(index)))
    assert largest_masses.cache_info().misses == 1
