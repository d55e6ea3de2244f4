"""What a grid says of laws that need more of their joint than their own numbers."""

import math

import pytest
from law_cases import RECIPES, few, names, written
from mechanism_cases import PAIR, changed, resolved, slider_crank

import clearsweep
from clearsweep import InputError, grid, simulation
from clearsweep.mechanics.joints import registry
from clearsweep.mechanics.laws.elastic import plane_strain_modulus

MATERIAL = {"young": 207e9, "poisson": 0.3}
JOINT = "joints.rod-slider"


def cylinders(elastic="johnson", **changes):
    """Return a slider-crank whose joint has this elastic law; `changes` has `__` for dots within the joint."""
    contact = {"law": "exact", "restitution": 0.6, "elastic": elastic, "material": dict(MATERIAL)}
    inner = {f"{JOINT}.{key.replace('__', '.')}": value for key, value in changes.items()}
    return slider_crank("rod-slider", changes={f"{JOINT}.contact": contact} | inner)


def problems(source):
    with pytest.raises(InputError) as caught:
        grid.load(source, simulation.catalogue())
    return caught.value.problems


@pytest.mark.few("johnson")
@pytest.mark.parametrize("name", few("elastic", "power", "johnson", "persson"))
def test_every_elastic_law_resolves_builds_and_runs_in_a_slider_crank(name):
    contact = {key: value for key, value in written("exact", name, restitution=0.6)["contact"].items() if key != "law"}
    case = resolved(cylinders(**{f"contact__{key}": value for key, value in contact.items()}))
    assert case["joints"]["rod-slider"]["contact"]["elastic"] == name
    run = clearsweep.simulate(
        clearsweep.load_case(
            changed(
                cylinders(**{f"contact__{key}": value for key, value in contact.items()}),
                {"simulate.revolutions": 0.05, "simulate.tolerance": 1e-8},
            )
        )
    )
    assert run.status == "ok"
    assert run.summary["rod_slider_force_peak"] > 0.0
    assert run.summary["energy_residual"] < 1e-6


@pytest.mark.parametrize("name", [name for name in names("elastic") if "length" in RECIPES["elastic", name].law.needs])
def test_a_missing_length_is_reported(name):
    extra = {"contact__thickness": 5e-3} if name == "winkler" else {}
    (message,) = problems(cylinders(name, length=None, **extra))
    assert f"{JOINT}.length: is missing; elastic '{name}' needs the joint's length" in message


def test_laws_that_need_nothing_and_laws_that_do_can_be_swept_together():
    source = cylinders(contact__stiffness=6.61e10)
    source["sweep"] = {f"{JOINT}.contact.elastic": ["power", "johnson", "persson"]}
    cases = grid.load(source, simulation.catalogue())
    result = [cases.written_case(k)["joints"]["rod-slider"]["contact"] for k in range(len(cases))]
    assert ["stiffness" in contact for contact in result] == [True, False, False]
    assert len({cases.case_id(k) for k in range(3)}) == 3
    del source["joints"]["rod-slider"]["length"]
    assert len(problems(source)) == 2


def test_an_elastic_law_that_the_contact_law_does_not_use_needs_nothing():
    spring = {"law": "kelvin-voigt", "stiffness": "1e8 N/m", "damping": 100.0}
    source = slider_crank("rod-slider", changes={f"{JOINT}.contact": spring, f"{JOINT}.length": None})
    assert "elastic" not in resolved(source)["joints"]["rod-slider"]["contact"]


def test_an_impact_pair_takes_the_sizes_that_cylinders_need():
    contact = {"law": "exact", "restitution": 0.5, "elastic": "johnson", "material": MATERIAL}
    sized = {"joints.pair": {"clearance": 0.5e-3, "bearing_radius": 0.01, "length": 0.02, "contact": contact}}
    assert resolved(changed(PAIR, sized))["joints"]["pair"]["length"] == 0.02
    message = problems(changed(PAIR, {"joints.pair": {"clearance": 0.5e-3, "contact": contact}}))
    assert [problem for problem in message if "bearing_radius: is missing" in problem]
    assert [problem for problem in message if "length: is missing" in problem]
    assert "length" not in resolved(PAIR)["joints"]["pair"]


def test_an_impact_pair_can_take_its_stiffness_from_the_material():
    contact = {"law": "hertz", "material": MATERIAL}
    pair = {"clearance": 0.5e-3, "bearing_radius": 0.01, "contact": contact}
    joint = clearsweep.load_case(changed(PAIR, {"joints.pair": pair})).case.joints[0]
    assert registry.compile_contact(joint)[1].stiffness == pytest.approx(6.610198e10, rel=1e-7)
    del pair["bearing_radius"]
    assert "bearing_radius: is missing" in problems(changed(PAIR, {"joints.pair": pair}))[0]


@pytest.mark.parametrize("name", names("friction"))
def test_every_friction_law_resolves_with_its_own_numbers(name):
    section = written(friction=name)["friction"]
    case = resolved(slider_crank("rod-slider", changes={f"{JOINT}.friction": section}))
    assert case["joints"]["rod-slider"]["friction"] == pytest.approx(section)


def test_stribeck_s_shape_and_viscous_part_have_defaults():
    written = {
        "law": "stribeck",
        "coefficient": 0.1,
        "static_coefficient": 0.15,
        "stribeck_velocity": "1 mm/s",
        "velocity_scale": "0.1 mm/s",
    }
    friction = resolved(slider_crank("rod-slider", changes={f"{JOINT}.friction": written}))["joints"]["rod-slider"]
    assert friction["friction"]["shape"] == 2.0
    assert friction["friction"]["viscous"] == 0.0


# ---------------------------------------------------------------------------------------------- two materials

BRONZE = {"young": 110e9, "poisson": 0.34}
PAIR_MODULUS = 1.0 / ((1.0 - 0.34**2) / 110e9 + (1.0 - 0.3**2) / 207e9)  # E*, Pa


def bushed(**changes):
    """Return the first joint of a slider-crank with a bronze bearing and a steel journal."""
    own = {"bearing": dict(BRONZE), "journal": dict(MATERIAL)}
    source = cylinders(**{"contact__material": own} | changes)
    return grid.load(source, simulation.catalogue()).case(0).joints[0]


def test_two_materials_make_the_modulus_of_the_pair_whichever_body_has_which():
    bronze_on_steel = plane_strain_modulus(bushed().contact.material)
    swapped = {"contact__material": {"bearing": dict(MATERIAL), "journal": dict(BRONZE)}}
    assert bronze_on_steel == pytest.approx(PAIR_MODULUS, rel=1e-14)
    assert plane_strain_modulus(bushed(**swapped).contact.material) == pytest.approx(PAIR_MODULUS, rel=1e-14)


@pytest.mark.parametrize("name", ["power", "lankarani-nikravesh-cylindrical", "pereira", "liu", "bai-zhao-literal"])
def test_a_force_that_grows_with_the_modulus_is_that_of_the_pair(name):
    steel = registry.elastic_forces(bushed(contact__elastic=name, contact__material=dict(MATERIAL)), [1e-6])[0]
    both = registry.elastic_forces(bushed(contact__elastic=name), [1e-6])[0]
    assert both / steel == pytest.approx(PAIR_MODULUS / (207e9 / (2.0 * (1.0 - 0.3**2))), rel=1e-12)


def test_a_logarithmic_law_follows_back_with_the_modulus_of_the_pair():
    (load,) = registry.elastic_forces(bushed(), [1e-6])
    line = load / 0.02
    back = line / (math.pi * PAIR_MODULUS) * (math.log(4.0 * math.pi * PAIR_MODULUS * 0.5e-3 / line) - 1.0)
    assert back == pytest.approx(1e-6, rel=1e-12, abs=0.0)


def test_winkler_s_layer_and_the_yielding_ball_are_of_the_bearing_s_material():
    (load,) = registry.elastic_forces(bushed(contact__elastic="winkler", contact__thickness=5e-3), [1e-6])
    alone = bushed(contact__elastic="winkler", contact__thickness=5e-3, contact__material=dict(BRONZE))
    assert load == registry.elastic_forces(alone, [1e-6])[0]
    yields = {"law": "kogut-etsion", "hardness": 1e9, "material": {"bearing": BRONZE, "journal": MATERIAL}}
    joint = bushed(contact=yields)
    depth = (math.pi * (0.454 + 0.41 * 0.34) * 1e9 / (2.0 * PAIR_MODULUS)) ** 2 * 0.01 * 0.0095 / 0.5e-3
    assert registry.derived_values(joint)["contact.yield_depth"] == (pytest.approx(depth, rel=1e-12, abs=0.0), "m")


def test_the_same_material_twice_is_one_material_to_the_last_digit():
    twice = bushed(contact__material={"bearing": dict(MATERIAL), "journal": dict(MATERIAL)})
    once = bushed(contact__material=dict(MATERIAL))
    assert twice == once


def test_the_material_of_one_body_can_be_swept_and_has_its_own_identity():
    own = {"bearing": dict(BRONZE), "journal": dict(MATERIAL)}
    source = cylinders(contact__material=own)
    source["sweep"] = {f"{JOINT}.contact.material.bearing.young": ["90 GPa", "110 GPa"]}
    cases = grid.load(source, simulation.catalogue())
    moduli = [cases.case(k).joints[0].contact.material.bearing.young for k in range(2)]
    assert moduli == [90e9, 110e9]
    assert cases.case_id(0) != cases.case_id(1)


# ---------------------------------------------------------------------------------------------- laws with conditions


@pytest.mark.parametrize("law", ["brown-mcphee", "elasto-plastic", "lugre", "karnopp"])
def test_static_friction_may_equal_kinetic_friction(law):
    section = written(friction=law)["friction"]
    equal = section | {"static_coefficient": section["coefficient"]}
    assert resolved(slider_crank("rod-slider", changes={f"{JOINT}.friction": equal}))


def test_other_elastic_laws_take_their_own_exponent():
    contact = {"law": "hertz", "elastic": "bai-zhao-literal", "exponent": 2.0, "material": MATERIAL}
    choices = registry.elastic_choices(bushed(contact=contact))
    chosen = {name: joint.contact.values.get("exponent") for name, joint in choices.items()}
    assert (chosen["bai-zhao-literal"], chosen["power"], chosen["lankarani-nikravesh-cylindrical"]) == (2.0, 1.5, 1.5)
