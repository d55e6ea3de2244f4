"""What a grid says of laws that need more of their joint than their own numbers."""

import pytest
from law_cases import RECIPES, few, names, written
from mechanism_cases import PAIR, changed, resolved, slider_crank

import clearsweep
from clearsweep import InputError, grid, simulation
from clearsweep.mechanics.joint import registry

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
def test_a_missing_length_is_told(name):
    extra = {"contact__thickness": 5e-3} if name == "winkler" else {}
    (told,) = problems(cylinders(name, length=None, **extra))
    assert f"{JOINT}.length: is missing; elastic '{name}' needs the joint's length" in told


def test_a_missing_material_is_told():
    (told,) = problems(cylinders(contact__material=None))
    assert "contact.material: is missing; elastic 'johnson' needs both bodies' material" in told


def test_what_only_another_elastic_law_uses_is_refused():
    (told,) = problems(cylinders(contact__stiffness=6.61e10))
    assert "contact.stiffness: is not used by" in told


def test_laws_that_need_nothing_and_laws_that_do_can_be_swept_together():
    source = cylinders(contact__stiffness=6.61e10)
    source["sweep"] = {f"{JOINT}.contact.elastic": ["power", "johnson", "persson"]}
    cases = grid.load(source, simulation.catalogue())
    found = [cases.written_case(k)["joints"]["rod-slider"]["contact"] for k in range(len(cases))]
    assert ["stiffness" in contact for contact in found] == [True, False, False]
    assert len({cases.case_id(k) for k in range(3)}) == 3
    del source["joints"]["rod-slider"]["length"]
    assert len(problems(source)) == 2


def test_a_fit_is_refused_for_clearances_it_was_not_made_for():
    (told,) = problems(cylinders("pereira", clearance="3 um"))
    assert "clearance: found 3e-06; elastic 'pereira' allows 5e-06 to 0.01 (m): it was fitted there" in told
    source = cylinders("pereira")
    source["sweep"] = {f"{JOINT}.clearance": ["3 um", "0.1 mm"]}
    assert "found 3e-06" in problems(source)[0]


def test_a_layer_that_cannot_give_way_is_refused():
    (told,) = problems(cylinders("winkler", contact__thickness=5e-3, contact__material__poisson=0.5))
    assert "poisson: found 0.5; elastic 'winkler' allows" in told


def test_an_elastic_law_that_the_contact_law_does_not_use_needs_nothing():
    spring = {"law": "kelvin-voigt", "stiffness": "1e8 N/m", "damping": 100.0}
    source = slider_crank("rod-slider", changes={f"{JOINT}.contact": spring, f"{JOINT}.length": None})
    assert "elastic" not in resolved(source)["joints"]["rod-slider"]["contact"]


def test_an_impact_pair_takes_the_sizes_that_cylinders_need():
    contact = {"law": "exact", "restitution": 0.5, "elastic": "johnson", "material": MATERIAL}
    sized = {"joints.pair": {"clearance": 0.5e-3, "bearing_radius": 0.01, "length": 0.02, "contact": contact}}
    assert resolved(changed(PAIR, sized))["joints"]["pair"]["length"] == 0.02
    told = problems(changed(PAIR, {"joints.pair": {"clearance": 0.5e-3, "contact": contact}}))
    assert [problem for problem in told if "bearing_radius: is missing" in problem]
    assert [problem for problem in told if "length: is missing" in problem]
    assert "length" not in resolved(PAIR)["joints"]["pair"]


def test_an_impact_pair_can_take_its_stiffness_from_the_material():
    contact = {"law": "hertz", "material": MATERIAL}
    pair = {"clearance": 0.5e-3, "bearing_radius": 0.01, "contact": contact}
    joint = clearsweep.load_case(changed(PAIR, {"joints.pair": pair})).case.joints[0]
    assert registry.contact_terms(joint)[1].stiffness == pytest.approx(6.610198e10, rel=1e-7)
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
