"""Normal laws: one battery for all of them, then closed forms and the tables of their hysteresis factors."""

import math
from itertools import repeat

import numpy as np
import pytest
from law_cases import (
    ASKED,
    RECIPES,
    STEEL,
    all_finite,
    compiled_contact,
    in_millimetres,
    joint,
    names,
    takes_restitution,
    written,
)
from mechanism_cases import PAIR, changed, slider_crank
from ruamel.yaml import YAML
from scipy.integrate import solve_ivp
from scipy.special import lambertw

import clearsweep
from clearsweep import InputError, simulation
from clearsweep.mechanics import describe
from clearsweep.mechanics.coupling import entries
from clearsweep.mechanics.joints import registry
from clearsweep.mechanics.joints.contract import with_internal_state
from clearsweep.mechanics.laws.elastic import elastic_force
from clearsweep.mechanics.laws.loss import contact_force, lowest_force
from clearsweep.mechanics.machines import MECHANISMS
from clearsweep.tracing import objects

LAWS = names("law")
YIELDING = [name for name in LAWS if hasattr(RECIPES["law", name].make(joint(name)), "deepest")]
WITH_RESTITUTION = [name for name in LAWS if takes_restitution("law", name)]
# chi over ASKED, computed from the phase curve of the free impact; four digits
CHI = {
    "hunt-crossley": (1.35, 1.2, 1.05, 0.9, 0.75, 0.6, 0.45, 0.3, 0.15, 0.075, 0.015),
    "herbert-mcwhannell": (1.4835, 1.4286, 1.3291, 1.1842, 1.0, 0.7895, 0.5696, 0.3571, 0.1648, 0.0787, 0.0151),
    "lee-wang": (0.675, 0.6, 0.525, 0.45, 0.375, 0.3, 0.225, 0.15, 0.075, 0.0375, 0.0075),
    "lankarani-nikravesh": (0.7425, 0.72, 0.6825, 0.63, 0.5625, 0.48, 0.3825, 0.27, 0.1425, 0.0731, 0.0149),
    "gonthier": (9.9, 4.8, 3.0333, 2.1, 1.5, 1.0667, 0.7286, 0.45, 0.2111, 0.1026, 0.0201),
    "zhiying-qishao": (4.4919, 3.5662, 2.7677, 2.0917, 1.5290, 1.0683, 0.6970, 0.4028, 0.1740, 0.0808, 0.0152),
    "flores": (14.4, 6.4, 3.7333, 2.4, 1.6, 1.0667, 0.6857, 0.4, 0.1778, 0.0842, 0.0162),
    "hu-guo": (13.5, 6.0, 3.5, 2.25, 1.5, 1.0, 0.6429, 0.375, 0.1667, 0.0789, 0.0152),
    "safaeifar-farshidianfar": (11.25, 5.0, 2.9167, 1.875, 1.25, 0.8333, 0.5357, 0.3125, 0.1389, 0.0658, 0.0126),
    "carvalho-martins": (7.7447, 4.6286, 3.0365, 2.0739, 1.4318, 0.9750, 0.6349, 0.3732, 0.1665, 0.0789, 0.0152),
    "gharib-hurmuzlu": (10.0, 5.0, 3.3333, 2.5, 2.0, 1.6667, 1.4286, 1.25, 1.1111, 1.0526, 1.0101),
    "exact": (9.9982, 4.9192, 3.0871, 2.0825, 1.4328, 0.9749, 0.6348, 0.3731, 0.1665, 0.0789, 0.0152),
    "pant-wijeyewickrema": (148.5, 36.0, 15.167, 7.875, 4.5, 2.6667, 1.5612, 0.8437, 0.3519, 0.1620, 0.0305),
}
GIVEN_BACK = {"exact", "gonthier-exact", "tsuji", "anagnostopoulos", *YIELDING}  # exactly what was asked for
ON_APPROACH = {  # restitutions asked for and returned, of the laws that damp the approach alone
    "pant-wijeyewickrema": (
        (0.1, 0.2, 0.3, 0.5, 0.7, 0.8, 0.9, 0.95, 0.99),
        (0.1141, 0.2236, 0.3281, 0.5254, 0.7137, 0.8072, 0.9021, 0.9506, 0.9900),
    ),
    "jankowski": (
        (0.1, 0.3, 0.5, 0.65, 0.7, 0.8, 0.9, 0.99),
        (0.0933, 0.2917, 0.4946, 0.6470, 0.6977, 0.7989, 0.8997, 0.9900),
    ),
}


def free_impact(chi):
    """Return the restitution of a free impact with hysteresis factor chi: (1 + W0(-(1+chi) exp(-(1+chi)))) / chi."""
    return 1.0 if chi == 0.0 else float((1.0 + lambertw(-(1.0 + chi) * math.exp(-(1.0 + chi))).real) / chi)


def term_of(name, **changes):
    return RECIPES["law", name].make(joint(name, **changes))


def bounce(speed=1.0, orbits="none", **contact):
    """Return the trajectory of an impact pair of effective mass 0.1 kg with this contact section."""
    law = RECIPES["law", contact["law"]].law
    section = {"stiffness": 6.61e10 if law.uses_elastic else 1e8} | contact
    fields = {field.name for field in law.fields} - {*law.one_of[1:]} | {"law", "stiffness"}
    if law.uses_elastic:
        fields |= {"elastic", "exponent"}
    needed = {}
    if "material" in law.needs:
        section |= {"material": STEEL, "hardness": 5e8}
        fields.add("material")
        needed["joints.pair.bearing_radius"] = 0.01
    case = changed(
        PAIR,
        needed
        | {
            "joints.pair.contact": {k: v for k, v in section.items() if k in fields},
            "mechanism.speed": speed,
            "simulate.impacts": 1,
            "save.orbits": orbits,
        },
    )
    trajectory = clearsweep.simulate(clearsweep.load_case(case))
    assert trajectory.status == "ok"
    return trajectory


def returned(**contact):
    return bounce(**contact).summary["pair_restitution"]


# ---------------------------------------------------------------------------------------------- every law


@pytest.mark.parametrize("law", LAWS)
def test_every_normal_law_is_finite_elastic_at_rest_and_dissipates_over_a_cycle(law):
    term, elastic = registry.compile_contact(joint(law))
    assert contact_force(term, elastic, 0.0, 0.0, 1.0) == (0.0, 0.0)
    for pen in (1e-300, 1e-12, 1e-5, 1.0):
        force, stored = contact_force(term, elastic, pen, 0.0, 1.0)
        if law == "kogut-etsion":  # softer than its elastic law, and what comes back is no fixed share
            assert 0.0 <= stored <= force <= elastic_force(elastic, pen)
        else:
            assert force == elastic_force(elastic, pen) >= 0.0
            assert stored == (term.returned_fraction * force if law in YIELDING else force)
        for rate in (-1e3, 1e3):
            assert all_finite(contact_force(term, elastic, pen, rate, 1e-3))
    phase = np.linspace(0.0, 2.0 * np.pi, 2001)
    pen, rate = 1e-5 * (1.0 - np.cos(phase)), 1e-2 * np.sin(phase)
    terms = [
        with_internal_state(term, [2e-5 if r < 0.0 else 0.0], 0) if law in YIELDING else term for r in rate
    ]  # what laws with an internal state then have in it
    force = [max(contact_force(*ends, 1.0)[0], lowest_force(term)) for ends in zip(terms, repeat(elastic), pen, rate)]
    loss = np.trapezoid(np.array(force) * rate, phase)
    assert loss == pytest.approx(0.0, abs=1e-12) if law == "hertz" else loss > 0.0


@pytest.mark.parametrize("law", LAWS)
def test_force_grows_with_the_closing_rate(law):
    term, elastic = registry.compile_contact(joint(law))
    for pen in (1e-8, 1e-5, 1e-3):
        forces = [contact_force(term, elastic, pen, rate, 0.5)[0] for rate in np.linspace(-1.0, 1.0, 41)]
        assert np.all(np.diff(forces) >= 0.0)


@pytest.mark.parametrize("law", LAWS)
def test_compiled_and_plain_code_give_the_same_force(law):
    term, elastic = registry.compile_contact(joint(law))
    rates = np.linspace(-2.0, 2.0, 41)
    for pen in (0.0, 1e-9, 1e-5, 1e-3, 1e-1):
        plain = [contact_force(term, elastic, pen, rate, 0.5)[0] for rate in rates]
        np.testing.assert_allclose(compiled_contact(term, elastic, pen, rates, 0.5), plain, rtol=1e-13, atol=0.0)


@pytest.mark.few("hertz", "hunt-crossley", "exact", "kelvin-voigt", "kelvin-voigt-unclipped")
@pytest.mark.parametrize("law", LAWS)
def test_only_a_law_that_says_so_pulls(law):
    sample = {"restitution": 0.3, "damping": 2e3 if law != "kuwabara-kono" else 1e6, "mass": 0.1, "depth": 1e-5}
    trajectory = bounce(law=law, orbits="all", **sample)
    least = trajectory["joints/pair/force_normal"].min()
    pulls = lowest_force(term_of(law)) < 0.0
    assert least < 0.0 if pulls else least >= 0.0
    assert ("pulls" in RECIPES["law", law].law.notes.lower()) == pulls
    assert trajectory.summary["energy_residual"] < 1e-9


@pytest.mark.parametrize("law", WITH_RESTITUTION)
def test_simulated_restitution_is_the_free_impact(law):
    for asked in ASKED:
        expected = RECIPES["law", law].free_restitution(asked)
        got = returned(law=law, restitution=asked, mass=0.1)
        assert got == pytest.approx(expected, abs=1e-8)
        if law in GIVEN_BACK:
            assert got == pytest.approx(asked, abs=5.1e-5)
        elif law not in ON_APPROACH:
            chi = CHI["hu-guo" if law == "ye" else law][ASKED.index(asked)]
            assert got == pytest.approx(free_impact(chi), abs=5.1e-5)


@pytest.mark.parametrize("law", LAWS)
def test_a_law_does_not_depend_on_the_unit_of_length(law):
    scaled = in_millimetres(written(law))
    for pen, rate in ((1e-6, 0.3), (1e-4, -0.2)):
        plain = contact_force(*registry.compile_contact(joint(law)), pen, rate, 0.5)
        in_mm = contact_force(*registry.compile_contact(scaled), 1e3 * pen, 1e3 * rate, 500.0)
        assert in_mm == pytest.approx([1e3 * part for part in plain], rel=1e-9)


# ---------------------------------------------------------------------------------------------- factors


@pytest.mark.parametrize("law", CHI)
def test_hysteresis_factor_has_its_tabulated_values(law):
    assert [term_of(law, restitution=e).factor for e in ASKED] == pytest.approx(CHI[law], rel=3e-5, abs=5.1e-5)


def test_gharib_and_hurmuzlu_s_factor_gives_back_lambert_s_free_impact():
    returned_by = RECIPES["law", "gharib-hurmuzlu"].free_restitution
    assert [returned_by(e) for e in ASKED] == pytest.approx([free_impact(1.0 / e) for e in ASKED], rel=1e-12)
    assert returned_by(0.01) == pytest.approx(0.01, rel=1e-12)
    assert max(map(returned_by, ASKED)) < returned_by(1.0) == pytest.approx(0.59362426, rel=1e-8)


@pytest.mark.parametrize("law", ["lankarani-nikravesh", "flores", "exact"])
@pytest.mark.parametrize("exponent", [1.0, 1.2])
def test_restitution_does_not_depend_on_the_exponent(law, exponent):
    stiffness = 1e8 if exponent == 1.0 else 6.61e10
    for asked in (0.1, 0.6, 0.95):
        got = returned(law=law, restitution=asked, exponent=exponent, stiffness=stiffness)
        assert got == pytest.approx(free_impact(term_of(law, restitution=asked).factor), abs=1e-9)


def test_the_exact_factor_has_the_same_bits_as_scipy_s_root(monkeypatch):
    from scipy.optimize import brentq

    from clearsweep.mechanics.laws import loss

    restitutions = np.linspace(2e-3, 0.9999, 300).tolist()
    own = [loss.exact_factor(restitution) for restitution in restitutions]
    monkeypatch.setattr(loss, "find_root", lambda *known: brentq(*known[:3], xtol=known[3], rtol=known[4]))
    assert [loss.exact_factor(restitution) for restitution in restitutions] == own


def test_a_root_is_found_between_opposite_signs_only():
    from clearsweep.mechanics.laws.loss import find_root

    assert find_root(lambda x: x**3 - 2.0, 0.0, 2.0, 1e-15, 1e-15) == pytest.approx(2.0 ** (1 / 3), abs=1e-15)
    assert find_root(lambda x: x, 0.0, 1.0, 1e-15, 1e-15) == 0.0
    with pytest.raises(ValueError, match="one sign"):
        find_root(lambda x: x * x + 1.0, -1.0, 1.0, 1e-15, 1e-15)


@pytest.mark.parametrize("chi", [1e-9, 1e-5, 1.01e-4, 1e-2, 0.099, 0.101, 0.5, 3.0, 10.0, 150.0])
def test_rebound_of_a_factor_is_lambert_s_free_impact(chi):
    from clearsweep.mechanics.laws.loss import hysteresis_rebound

    expected = free_impact(chi) if chi > 1e-2 else 1.0 - 2.0 * chi / 3.0 + 4.0 * chi**2 / 9.0 - 44.0 * chi**3 / 135.0
    assert hysteresis_rebound(chi) == pytest.approx(expected, abs=1e-12 + 0.5 * chi**4 * (chi <= 1e-2))


@pytest.mark.parametrize("asked", [0.01, 0.1, 0.5, 0.9, 0.99, 0.999, 0.9999, 0.99999, 0.999999, 1.0])
def test_exact_law_returns_what_was_requested(asked):
    assert returned(law="exact", restitution=asked) == pytest.approx(asked, abs=1e-8)


def test_hertz_gives_everything_back_and_meets_the_elastic_impact():
    trajectory = bounce(law="hertz", stiffness=6.610198e10, orbits="all")
    duration = np.diff(trajectory.events["t"])[0]
    assert trajectory.summary["pair_restitution"] == pytest.approx(1.0, abs=1e-10)
    deepest = (2.5 * 0.1 / (2.0 * 6.610198e10)) ** 0.4  # half the energy of 0.1 kg at 1 m/s goes into K pen^2.5 / 2.5
    assert deepest == pytest.approx(2.0449289e-5, rel=3e-8, abs=0.0)
    assert trajectory.summary["pair_penetration_max"] == pytest.approx(deepest, rel=1e-11, abs=0.0)
    assert trajectory.summary["pair_force_peak"] == pytest.approx(6.610198e10 * deepest**1.5, rel=1e-11)
    lasts = 2.0 * math.sqrt(math.pi) * math.gamma(1.4) / math.gamma(0.9) * deepest
    assert duration == pytest.approx(lasts, rel=1e-9, abs=0.0)


@pytest.mark.parametrize("law", ON_APPROACH)
def test_laws_that_damp_the_approach_alone_return_their_tabulated_restitution(law):
    for asked, expected in zip(*ON_APPROACH[law], strict=True):
        assert RECIPES["law", law].free_restitution(asked) == pytest.approx(expected, abs=5.1e-5)


# ---------------------------------------------------------------------------------------------- springs and dampers


@pytest.mark.parametrize("zeta", [0.0335184, 0.1, 0.3, 0.6, 0.8, 1.5, 3.0])
def test_clipped_kelvin_voigt_restitution_is_the_free_impact(zeta):
    root = math.sqrt(abs(1.0 - zeta * zeta))
    if zeta < 1.0:
        expected = math.exp(-zeta / root * math.atan2(2.0 * zeta * root, 2.0 * zeta * zeta - 1.0))
    else:
        expected = ((zeta + root) / (zeta - root)) ** (-zeta / root)
    got = returned(law="kelvin-voigt", stiffness=1e8, damping=2.0 * zeta * math.sqrt(1e8 * 0.1))
    assert got == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize(("zeta", "expected"), [(0.0335184, 0.9), (0.1128085, 0.7), (0.2154538, 0.5), (0.5911550, 0.1)])
def test_unclipped_kelvin_voigt_restitution_is_the_free_impact(zeta, expected):
    got = returned(law="kelvin-voigt-unclipped", stiffness=1e8, damping=2.0 * zeta * math.sqrt(1e8 * 0.1))
    assert got == pytest.approx(math.exp(-math.pi * zeta / math.sqrt(1.0 - zeta * zeta)), abs=1e-9)
    assert got == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize(("asked", "alpha"), [(0.1, 1.3218628), (0.5, 0.4817693), (0.9, 0.0749495)])
def test_tsuji_s_factor_has_its_values(asked, alpha):
    assert term_of("tsuji", restitution=asked, mass=0.1).damping == pytest.approx(alpha * math.sqrt(0.1), rel=1e-6)
    damping = term_of("tsuji", restitution=asked, mass=0.1).damping
    force, stored = contact_force(term_of("tsuji", restitution=asked, mass=0.1), joint_power(), 1e-5, 0.5, 1.0)
    assert force - stored == pytest.approx(damping * math.sqrt(6.61e10) * 1e-5**0.25 * 0.5, rel=1e-12)


def joint_power():
    return RECIPES["elastic", "power"].make(joint(stiffness=6.61e10))


@pytest.mark.parametrize("exponent", [1.0, 1.2, 2.0])
def test_tsuji_s_restitution_holds_for_any_power(exponent):
    stiffness = {1.0: 1e8, 1.2: 1e9, 2.0: 1e13}[exponent]
    got = returned(law="tsuji", restitution=0.6, mass=0.1, exponent=exponent, stiffness=stiffness)
    assert got == pytest.approx(0.6, abs=1e-8)


@pytest.mark.few("adams-impact-numbers2")
@pytest.mark.parametrize(
    ("law", "numbers"),
    [
        ("ristow", {"damping": 500.0}),
        ("kuwabara-kono", {"damping": 3e5}),
        ("adams-impact", {"damping": 3000.0, "depth": 2e-5}),
    ],
)
def test_laws_without_a_restitution_move_as_an_independent_integration_says(law, numbers):
    term, elastic = registry.compile_contact(joint(law, stiffness=6.61e10, **numbers))

    def motion_of(t, y):
        return [y[1], -max(contact_force(term, elastic, max(y[0], 0.0), y[1], 1.0)[0], 0.0) / 0.1]

    def parts(t, y):
        return y[0] + 1e-15

    parts.terminal, parts.direction = True, -1.0
    done = solve_ivp(motion_of, (0.0, 1e-3), [0.0, 1.0], "DOP853", events=parts, rtol=1e-11, atol=1e-18, max_step=1e-6)
    assert returned(law=law, **numbers) == pytest.approx(-done.y_events[0][0][1], abs=1e-6)


def test_adams_damping_grows_as_a_smooth_step():
    term, elastic = registry.compile_contact(joint("adams-impact", damping=100.0, depth=1e-3))
    shares = []
    for pen in (0.0, 0.25e-3, 0.5e-3, 1e-3, 2e-3):
        force, stored = contact_force(term, elastic, pen, 1.0, 1.0)
        shares.append((force - stored) / 100.0)
    assert shares == pytest.approx([0.0, 0.15625, 0.5, 1.0, 1.0], rel=1e-6)


# ---------------------------------------------------------------------------------------------- in a grid


def test_all_laws_can_be_swept_in_one_grid():
    from clearsweep import grid

    factors = [name for name in LAWS if RECIPES["law", name].law.uses_elastic]
    case = changed(
        PAIR,
        {
            "joints.pair.contact": {"stiffness": 6.61e10, "restitution": 0.5, "mass": 0.1, "depth": 1e-5},
            "sweep": {
                "joints.pair.contact.law": [
                    name
                    for name in factors
                    if "restitution" in {field.name for field in RECIPES["law", name].law.fields}
                ]
            },
        },
    )
    cases = grid.load(case, simulation.catalogue())
    kinds = {type(registry.compile_contact(cases.case(k).joints[0])[0]).__name__ for k in range(len(cases))}
    assert len(cases) > 10
    assert kinds == {"Renewed", "RootDamper", "ApproachRootDamper", "Plastic"}


def code_of(**contact):
    """Return the compiled code of the right-hand side of a slider-crank with this contact, as text."""
    case = slider_crank("rod-slider", changes={"joints.rod-slider.contact": contact})
    made = clearsweep.load_case(case)
    return str(objects.trace_scene(entries.rates_entry, made.value, "fifff").module)


@pytest.mark.heavy
@pytest.mark.compiled
def test_a_scene_compiles_the_laws_it_uses_and_no_other():
    material = {"young": 207e9, "poisson": 0.3}
    johnson = code_of(law="hertz", elastic="johnson", material=material)
    liu = code_of(law="hertz", elastic="liu", material=material)
    assert '@"log' in johnson
    assert '@"log' not in liu
    assert '@"log' not in code_of(law="hertz", stiffness=6.61e10)


# ---------------------------------------------------------------------------------------------- descriptions of a law


def test_the_list_names_every_law_with_one_line():
    listed = describe.law_text()
    for (_, name), recipe in RECIPES.items():
        assert f"  {name} " in listed
        assert recipe.law.summary in listed


@pytest.mark.parametrize("law", [mechanism.law for mechanism in MECHANISMS.values()])
def test_the_mechanisms_are_described_next_to_the_laws(law):
    assert f"  {law.name} " in describe.law_text()
    assert f"mechanism.type: {law.name}" in describe.law_text(law.name)
    assert all(field.name in describe.law_text(law.name) for field in law.fields)


@pytest.mark.parametrize("name", dict.fromkeys(name for _, name in RECIPES))
def test_every_law_reports_formula_parameters_and_source(name):
    message = " ".join(describe.law_text(name).split())
    for recipe in (result for (_, other), result in RECIPES.items() if other == name):
        for part in (recipe.law.formula, recipe.law.source, *(field.name for field in recipe.law.fields)):
            assert " ".join(part.split()) in message
        if takes_restitution(recipe.law.family, recipe.law.name):
            assert f"0.5 {recipe.free_restitution(0.5):.4f}" in message
        if recipe.law.family == "elastic":
            assert "pen, um" in message


def test_johnson_reports_its_force_at_a_micrometre_and_its_limit():
    message = describe.law_text("johnson")
    assert "814.62" in message
    assert "valid up to 199.1 um" in message


def test_a_name_in_two_families_shows_both(monkeypatch):
    recipe = RECIPES["law", "hertz"]
    twin = recipe._replace(law=recipe.law._replace(family="elastic", name="hertz"), make=lambda joint: joint_power())
    monkeypatch.setitem(RECIPES, ("elastic", "hertz"), twin)
    message = describe.law_text("hertz")
    assert "contact.law: hertz" in message
    assert "contact.elastic: hertz" in message


# ---------------------------------------------------------------------------------------------- given dampers


STIFFNESS = 6.61e10  # N/m^1.5


def impact_grid(speed: float, **contact) -> dict:
    """Return a pair of bodies that collide at `speed` (m/s), with a contact of that stiffness."""
    section = {"law": "hunt-crossley", "stiffness": STIFFNESS, "exponent": 1.5} | contact
    return {
        "name": "pair",
        "mechanism": {"type": "impact-pair", "masses": [0.2, 0.2], "speed": speed},
        "joints": {"pair": {"clearance": 1e-3, "contact": section}},
        "simulate": {"impacts": 1, "tolerance": 1e-11},
        "save": {"orbits": "none"},
    }


@pytest.mark.compiled
@pytest.mark.parametrize(("chi", "known"), [(0.1, 0.937475580), (0.5, 0.748434932), (3.0, None)])
def test_the_restitution_is_that_of_the_free_impact(chi, known):
    """chi = D v0 / K; two values are from outside."""
    restitution = free_impact(chi)
    assert known is None or restitution == pytest.approx(known, abs=5e-10)
    for speed in (0.2, 1.0):
        scene = clearsweep.load_case(impact_grid(speed, damping=chi * STIFFNESS / speed))
        assert clearsweep.simulate(scene).summary["pair_restitution"] == pytest.approx(restitution, rel=1e-8)


@pytest.mark.compiled
def test_damping_and_damping_factor_are_the_same_motion():
    """They differ by the stiffness, which is a power of two here."""
    stiffness = 2.0**36
    summaries = [
        clearsweep.simulate(clearsweep.load_case(impact_grid(0.7, stiffness=stiffness, **damper))).summary
        for damper in ({"damping": 0.5 * stiffness}, {"damping_factor": 0.5})
    ]
    assert summaries[0]["pair_restitution"] == summaries[1]["pair_restitution"]


@pytest.mark.compiled
def test_the_restitution_at_two_speeds_is_derived():
    """At 0.1 and 1 m/s, for any exponent."""
    from clearsweep.simulation import derived

    case = clearsweep.load_case(impact_grid(1.0, exponent=1.2, damping=2.0 * STIFFNESS)).case
    values = derived(case)
    for speed in (0.1, 1.0):
        value, unit = values[f"joints.pair.contact.restitution at {speed:g} m/s"]
        assert (value, unit) == (pytest.approx(free_impact(2.0 * speed), rel=1e-12), "1")


@pytest.mark.compiled
def test_the_damper_can_be_swept_in_its_unit(tmp_path):
    """More damping leaves less of the speed."""
    grid = impact_grid(1.0, damping=1e9) | {
        "sweep": {"joints.pair.contact.damping": ["1e9 N*s/m^2.5", "1e10 N*s/m^2.5", "1e11 N*s/m^2.5"]}
    }
    clearsweep.sweep(grid, out=tmp_path / "run", executor="serial")
    summary = clearsweep.open(tmp_path / "run").summary.sort_values("joints.pair.contact.damping")
    restitutions = summary["pair_restitution"].tolist()
    expected = [free_impact(damping / STIFFNESS) for damping in (1e9, 1e10, 1e11)]
    assert restitutions == pytest.approx(expected, rel=1e-7)


@pytest.mark.compiled
def test_a_swept_key_without_its_path_is_told_with_its_laws(tmp_path):
    """`sweep: {damping: ...}` names the path and the laws that take it."""
    grid = tmp_path / "grid.yaml"
    with grid.open("w", encoding="utf-8") as stream:
        YAML(typ="safe").dump(impact_grid(1.0, damping=1e9) | {"sweep": {"damping": [1e9, 2e9]}}, stream)
    with pytest.raises(InputError, match=r"joints\.pair\.contact\.damping \(law .*hunt-crossley"):
        clearsweep.sweep(grid, out=tmp_path / "run", executor="serial")


@pytest.mark.compiled
@pytest.mark.parametrize("tolerance", [1e-10, 1e-6, 1e-3])
def test_an_overdamped_contact_that_pulls_ends_with_restitution_0(tolerance):
    # x = v / (a - b) (exp(-b t) - exp(-a t)), a and b > 0 the roots of m s^2 - c s + k: never 0 again
    contact = {"law": "kelvin-voigt-unclipped", "stiffness": 1e6, "damping": 1500.0}
    path = clearsweep.simulate(
        clearsweep.load_case(
            {
                "mechanism": {"type": "impact-pair", "masses": [1.0, 1.0], "speed": 1.0},
                "joints": {"pair": {"clearance": 1e-3, "contact": contact}},
                "simulate": {"impacts": 1, "tolerance": tolerance},
            }
        )
    )
    assert path.status == "ok", path.message
    assert path.summary["pair_restitution"] == 0.0
    a, b = np.roots([0.5, -1500.0, 1e6]).real
    depth = 1.0 / (a - b) * ((b / a) ** (b / (a - b)) - (b / a) ** (a / (a - b)))
    assert path.summary["pair_penetration_max"] == pytest.approx(depth, rel=10.0 * tolerance + 1e-9)
