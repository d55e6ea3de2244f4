"""Elastic laws: one battery for all of them, then each against its published formula, its inverse or its limit."""

import math

import numpy as np
import pytest
from law_cases import RECIPES, compiled_elastic, few, force, in_millimetres, joint, names, resolved, written
from mechanism_cases import PAIR, changed, slider_crank
from scipy.integrate import quad
from scipy.special import lambertw

import clearsweep
from clearsweep import simulation
from clearsweep.answers.validity import (
    LIMIT_SHARE,
    ONSET_RATE,
    YIELD_SPEED,
    Remarks,
    law_range_remark,
    required_columns,
)
from clearsweep.mechanics.describe import REFERENCE
from clearsweep.mechanics.joints import registry
from clearsweep.mechanics.laws.cylinders import LOGARITHMIC_END, inverse_lambert
from clearsweep.mechanics.laws.elastic import (
    CONFORMAL_END,
    FIT_END,
    angle_minus_sine,
    elastic_force,
    fit_conformal_power,
    load_ratio,
    material_stiffness,
    root_parity,
)

pytestmark = pytest.mark.heavy

LAWS = names("elastic")
MODULUS = 207e9 / (2.0 * (1.0 - 0.3**2))  # E*, Pa
CLEARANCE, LENGTH, BEARING, JOURNAL = 0.5e-3, 20e-3, 10e-3, 9.5e-3
LOGARITHMIC = ("johnson", "radzimovsky", "dubowsky-freudenstein", "goldsmith", "esdu-78035")


def made(name, **changes):
    section = joint(elastic=name, **changes)
    return RECIPES["elastic", name].make(section), RECIPES["elastic", name].limit(section)


# ---------------------------------------------------------------------------------------------- every law


@pytest.mark.parametrize("name", LAWS)
def test_force_is_zero_at_contact_finite_and_grows_without_end(name):
    term, limit = made(name)
    assert elastic_force(term, 0.0) == 0.0
    around = [limit * (1.0 + k * 1e-6) for k in range(-5, 6)] if math.isfinite(limit) else []
    pens = np.sort([*np.geomspace(1e-30, 1.0, 400), *around])
    forces = np.array([elastic_force(term, pen) for pen in pens])
    assert np.all(np.isfinite(forces))
    assert forces[0] > 0.0
    assert np.all(np.diff(forces) > 0.0)
    for pen in (1e-300, 1e-200, 1e-100):
        assert 0.0 <= elastic_force(term, pen) < math.inf


@pytest.mark.parametrize("name", LAWS)
def test_force_and_slope_continue_smoothly_past_the_limit(name):
    term, limit = made(name)
    if math.isinf(limit):
        return
    step = 1e-5 * limit
    at = elastic_force(term, limit)
    before, after = at - elastic_force(term, limit - step), elastic_force(term, limit + step) - at
    assert after == pytest.approx(before, rel=1e-4)


@pytest.mark.parametrize("name", LAWS)
def test_a_trial_step_past_the_separation_sees_the_smoother_of_two_ways_on(name):
    term, _ = made(name)
    roots = np.linspace(-1e-3, 1e-3, 41)

    order = 5 if name == "bai-zhao-literal" else 4  # of a fourth power the fourth differences are alike both ways

    def bend(sign):
        forces = [(sign if root < 0.0 else 1.0) * elastic_force(term, root * root) for root in roots]
        return np.abs(np.diff(forces, order)).max()

    assert bend(root_parity(term)) < bend(-root_parity(term))


@pytest.mark.parametrize("name", LAWS)
def test_compiled_and_plain_code_give_the_same_force(name):
    term, limit = made(name)
    pens = np.append(np.geomspace(1e-15, 1e-2, 200), [0.0, *(c * limit for c in (0.9, 1.1) if math.isfinite(limit))])
    plain = np.array([elastic_force(term, pen) for pen in pens])
    np.testing.assert_allclose(compiled_elastic(term, pens), plain, rtol=1e-13, atol=0.0)


@pytest.mark.parametrize("name", LAWS)
def test_a_law_does_not_depend_on_the_unit_of_length_or_says_so(name):
    scaled = in_millimetres(written(elastic=name))
    recipe = RECIPES["elastic", name]
    same = all(
        elastic_force(recipe.make(scaled), 1e3 * pen)
        == pytest.approx(1e3 * elastic_force(recipe.make(joint(elastic=name)), pen), rel=1e-9)
        for pen in (1e-8, 1e-6, 1e-4)
    )
    assert same or "Dimensionally inconsistent" in recipe.law.notes


def test_the_sphere_s_stiffness_depends_on_the_unit_of_length_for_other_exponents():
    section = written(elastic="lankarani-nikravesh-cylindrical", exponent=1.2)
    make = RECIPES["elastic", "lankarani-nikravesh-cylindrical"].make
    ratio = elastic_force(make(in_millimetres(section)), 1e-3) / elastic_force(make(resolved(section)), 1e-6)
    assert ratio == pytest.approx(1e3 * 1e3**-0.3, rel=1e-9)


@pytest.mark.few("power", "johnson")
@pytest.mark.parametrize("name", few("elastic", "power", "johnson", "persson"))
def test_a_free_impact_gives_back_the_restitution_requested_for_any_elastic_law(name):
    section = written("exact", name, restitution=0.6)
    case = changed(PAIR, {"joints.pair": section, "simulate.impacts": 1, "mechanism.speed": 0.5})
    run = clearsweep.simulate(clearsweep.load_case(case))
    assert run.status == "ok"
    assert run.summary["pair_restitution"] == pytest.approx(0.6, abs=1e-8)
    assert run.summary["energy_residual"] < 1e-10


@pytest.mark.parametrize("name", LAWS)
def test_what_a_law_derives_is_a_number_with_a_unit(name):
    section = joint(elastic=name)
    result = registry.derived_values(section)
    assert all(math.isfinite(value) and unit for value, unit in result.values())
    if "contact.penetration_limit" in result:
        assert result["contact.penetration_limit"][0] == registry.penetration_limit(section)


# ---------------------------------------------------------------------------------------------- published values

DEPTHS = (0.1e-6, 1e-6, 5e-6, 10e-6, 20e-6)
FORCES = {  # N, over DEPTHS in the reference joint; computed from the formulas by root finding, not published
    "power": (2.090, 66.10, 739.0, 2090.0, 5912.0),
    "lankarani-nikravesh-cylindrical": (2.090, 66.10, 739.0, 2090.0, 5912.0),
    "johnson": (63.068, 814.618, 5158.36, 11700.0, 27138.3),
    "radzimovsky": (61.434, 786.83, 4930.4, 11105.0, 25506.0),
    "esdu-78035": (52.909, 649.74, 3878.8, 8477.0, 18712.0),
    "dubowsky-freudenstein": (52.693, 646.42, 3854.7, 8419.0, 18568.0),
    "goldsmith": (32.686, 367.53, 2013.8, 4201.9, 8784.7),
    "liu": (3.5728, 112.88, 1257.0, 3537.9, 9910.1),
    "bai-zhao-consistent": (3.5728, 112.88, 1257.0, 3537.9, 9910.1),
    "pereira": (58.932, 856.88, 5565.8, 12459.0, 27891.0),
    "winkler": (29.719, 938.71, 10441.0, 29344.0, 81960.0),
}


@pytest.mark.parametrize("name", FORCES)
def test_reference_forces(name):
    more = {"thickness": 5e-3} if name == "winkler" else {}
    section = written(elastic=name, **more)
    section["contact"].pop("stiffness", None)  # from the material
    term = RECIPES["elastic", name].make(resolved(section))
    got = [elastic_force(term, pen) for pen in DEPTHS]
    assert got == pytest.approx(FORCES[name], rel=2e-4)


# ---------------------------------------------------------------------------------------------- line contact


def test_lower_branch_of_lambert_is_accurate_from_tiny_arguments_to_the_end():
    for v in np.geomspace(2.0, 680.0, 3001):
        assert inverse_lambert(v * math.exp(-v)) * v == pytest.approx(1.0, abs=2e-13 if v > 100.0 else 3e-14)
    for w in np.geomspace(1e-300, LOGARITHMIC_END, 301):
        assert -1.0 / inverse_lambert(w) == pytest.approx(lambertw(-w, -1).real, rel=4e-15)


@pytest.mark.parametrize(("name", "constant_term"), [("johnson", -1.0), ("esdu-78035", 1.0)])
def test_penetration_follows_back_from_the_force_of_johnson_and_esdu(name, constant_term):
    _, limit = made(name)
    for pen in np.geomspace(1e-12, 0.999 * limit, 200):
        line = force(name, pen) / LENGTH
        back = line / (math.pi * MODULUS) * (math.log(4.0 * math.pi * MODULUS * CLEARANCE / line) + constant_term)
        assert back == pytest.approx(pen, rel=1e-13, abs=0.0)


@pytest.mark.parametrize("factor", [1, 2])
def test_penetration_follows_back_by_radzimovsky_and_roark(factor):
    for pen in np.geomspace(1e-12, 1e-4, 100):
        line = force("radzimovsky", pen, curvature_factor=factor) / LENGTH
        width = 1.60 * math.sqrt(line * factor * BEARING * JOURNAL / CLEARANCE / MODULUS)
        ends = 2.0 / 3.0 + math.log(4.0 * BEARING / width) + math.log(4.0 * JOURNAL / width)
        assert line / (math.pi * MODULUS) * ends == pytest.approx(pen, rel=1e-13, abs=0.0)


def test_radzimovsky_s_forces_with_radii():
    result = [force("radzimovsky", pen, curvature_factor=1) for pen in DEPTHS]
    assert result == pytest.approx((57.685, 724.97, 4441.6, 9860.8, 22210.0), rel=2e-4)


@pytest.mark.parametrize(("name", "power"), [("dubowsky-freudenstein", 3), ("goldsmith", 1)])
def test_penetration_follows_back_with_the_length_in_the_logarithm(name, power):
    h = 1.0 / (math.pi * MODULUS)
    for pen in np.geomspace(1e-12, 1e-4, 100):
        load = force(name, pen)
        argument = LENGTH**power * CLEARANCE / (load * BEARING * JOURNAL * h)
        assert load * h / LENGTH * (math.log(argument) + 1.0) == pytest.approx(pen, rel=1e-13, abs=0.0)


@pytest.mark.parametrize("name", [*LOGARITHMIC, "persson"])
def test_laws_that_end_are_left_where_the_tangent_is_twice_the_secant(name):
    term, limit = made(name)
    step = 1e-6 * limit
    slope = (elastic_force(term, limit) - elastic_force(term, limit - step)) / step
    assert slope == pytest.approx(2.0 * elastic_force(term, limit) / limit, rel=1e-5)
    assert elastic_force(term, 2.0 * limit) == pytest.approx(3.0 * elastic_force(term, limit), rel=1e-9)


def test_johnson_would_fold_back_beyond_its_limit():
    _, limit = made("johnson")
    fold = limit * math.exp(-1.0) / LOGARITHMIC_END
    assert fold == pytest.approx(4.0 * CLEARANCE / math.e**2, rel=1e-12, abs=0.0)
    assert fold == pytest.approx(2.7067e-4, rel=1e-4)


# ---------------------------------------------------------------------------------------------- conformal contact


def test_small_arcs_are_followed_without_cancellation():
    for angle in (1e-8, 1e-3, 0.1, 0.5, 0.999, 1.001, 2.0):
        series = sum((-1) ** k * angle ** (2 * k + 3) / math.factorial(2 * k + 3) for k in range(14))
        assert angle_minus_sine(angle) == pytest.approx(series, rel=1e-14)


def test_winkler_is_the_integral_of_its_pressure():
    modulus = 0.7 * 207e9 / (1.3 * 0.4 * 5e-3)
    for pen in (1e-7, 1e-5, 5e-4):
        whole = CLEARANCE + pen
        end = math.acos(CLEARANCE / whole)
        load, _ = quad(
            lambda phi, whole=whole: (whole * math.cos(phi) - CLEARANCE) * math.cos(phi), -end, end, epsrel=1e-12
        )
        expected = modulus * BEARING * LENGTH * load
        assert force("winkler", pen, thickness=5e-3) == pytest.approx(expected, rel=1e-9)


def test_bai_and_zhao_s_stiffness_is_the_derivative_of_liu_s_force():
    for pen in np.geomspace(1e-8, 1e-2, 40):
        printed = (
            0.125
            * math.pi
            * MODULUS
            * math.sqrt(2.0 * pen * (3.0 * CLEARANCE + 2.0 * pen) ** 2 / (CLEARANCE + pen) ** 3)
        )
        step = 1e-5 * pen
        slope = (force("liu", pen + step) - force("liu", pen - step)) / (2.0 * step)
        assert printed * LENGTH == pytest.approx(slope, rel=1e-9)
        for exponent in (1.0, 1.5, 2.0):
            literal = force("bai-zhao-literal", pen, exponent=exponent)
            assert literal == pytest.approx(printed * pen**exponent, rel=1e-13)
        assert force("bai-zhao-consistent", pen) == force("liu", pen)
    assert force("bai-zhao-literal", 10e-6) == pytest.approx(833.6, rel=1e-4)  # with the exponent as printed, in SI


def test_pereira_s_exponent_is_continuous_where_its_fit_changes():
    def exponent(clearance):
        return RECIPES["elastic", "pereira"].make(joint(elastic="pereira", clearance=clearance)).exponent

    assert exponent(0.349539e-3) == pytest.approx(exponent(0.349541e-3), abs=1e-4)
    assert exponent(0.5e-3) == pytest.approx((0.0151 * 0.5 + 1.151) * 0.5**-0.005, rel=1e-14)


def depth_of(degrees):
    """Return the penetration in clearances at which the rigid arc has this half-angle."""
    return 1.0 / math.cos(math.radians(degrees)) - 1.0


def test_persson_has_its_tabulated_loads_and_hertz_s_limit():
    table = {
        1: 2.3928544e-4,
        5: 0.0060059058,
        10: 0.0243248105,
        30: 0.2517769258,
        45: 0.7084357,
        60: 1.8740587,
        80: 15.8547,
    }
    for degrees, load in table.items():
        assert 2.0 * math.pi * load_ratio(depth_of(degrees)) == pytest.approx(load, rel=1e-6)
    for degrees in (0.01, 0.1):  # Hertz: half-width R eps with f = pi E* c eps^2 / 4
        angle = math.radians(degrees)
        expected = math.pi * angle**2 / 4.0
        assert 2.0 * math.pi * load_ratio(depth_of(degrees)) == pytest.approx(expected, rel=angle**2)
    assert depth_of(80.4127) == pytest.approx(CONFORMAL_END, rel=1e-5)


@pytest.mark.parametrize("degrees", [0.5, 5, 30, 60, 80])
def test_persson_s_pressure_carries_its_load(degrees):
    b = math.tan(0.5 * math.radians(degrees))
    b2 = b * b

    def pressure(y):  # times radius over load
        root, whole = math.sqrt(max(b2 - y * y, 0.0)), math.sqrt(b2 + 1.0)
        first = 2.0 * root / (math.pi * whole * (1.0 + y * y))
        return first + math.log((whole + root) / (whole - root)) / (2.0 * math.pi * b2 * (1.0 + b2))

    def line_load(t):  # y = b sin t leaves no root at the ends; phi = 2 atan y
        y = b * math.sin(t)
        return pressure(y) * math.cos(2.0 * math.atan(y)) * 2.0 / (1.0 + y * y) * b * math.cos(t)

    total, _ = quad(line_load, -0.5 * math.pi, 0.5 * math.pi, epsabs=1e-13, epsrel=1e-13, limit=200)
    assert total == pytest.approx(1.0, abs=1e-10)
    peaks = {5: 7.3020828, 30: 1.2602886, 60: 0.7117214}
    if degrees in peaks:
        assert pressure(0.0) == pytest.approx(peaks[degrees], rel=1e-6)


def test_conformal_fit_stays_as_close_to_persson_as_stated():
    _, exponent, residual = fit_conformal_power()
    depths = (np.arange(20000) + 0.5) / 20000 * FIT_END * CLEARANCE
    error = [force("conformal-fit", pen) / force("persson", pen) - 1.0 for pen in depths]
    assert np.sqrt(np.mean(np.square(error))) == pytest.approx(residual, rel=1e-3)
    assert residual < 0.02
    assert 1.0 < exponent < 1.1
    derived = registry.derived_values(joint(elastic="conformal-fit"))
    assert derived["contact.fit_residual"] == (residual, "1")


def test_material_stiffness_has_its_published_value():
    assert material_stiffness(REFERENCE) == pytest.approx(6.610198e10, rel=1e-7)


@pytest.mark.parametrize(("exponent", "kind"), [(1.5, "PowerThreeHalves"), (1.0, "Linear"), (1.3, "Power")])
def test_the_exponent_chooses_the_cheapest_code_that_gives_the_same_force(exponent, kind):
    term = RECIPES["elastic", "power"].make(joint(stiffness=3e9, exponent=exponent))
    assert type(term).__name__ == kind
    assert elastic_force(term, 2e-5) == pytest.approx(3e9 * 2e-5**exponent, rel=1e-14)


# ------------------------------------------------------------------------------------------- beyond the limit of a law


CONTACT = {"law": "hertz", "elastic": "johnson", "material": {"young": 1e6, "poisson": 0.3}}


def test_time_beyond_the_range_of_the_law_is_the_share_of_samples_beyond_it():
    changes = {"joints.rod-slider.contact": CONTACT, "drive.speed": "300 rpm", "simulate.tolerance": 1e-7}
    scene = clearsweep.load_case(slider_crank("rod-slider", changes=changes))
    limit = registry.penetration_limit(scene.case.joints[0])
    trajectory = clearsweep.simulate(scene, times=np.linspace(0.0, 0.2, 20001))
    assert trajectory.status == "ok"
    depth = np.hypot(trajectory["joints/rod_slider/x"], trajectory["joints/rod_slider/y"]) - 0.5e-3
    assert 0.0 < np.mean(depth > limit) < 1.0
    assert trajectory.summary["rod_slider_law_limit_fraction"] == pytest.approx(np.mean(depth > limit), abs=2e-3)
    assert trajectory.message.startswith("law-limit: rod-slider exceeds 0.1991 mm, the limit of johnson,")


def test_a_law_without_a_limit_is_never_beyond_it():
    trajectory = clearsweep.simulate(clearsweep.load_case(slider_crank("rod-slider")))
    assert trajectory.summary["rod_slider_law_limit_fraction"] == 0.0
    assert trajectory.message == ""


def columns_of_case(row):
    """Columns of one case."""
    return {column: [value] for column, value in row.items()}


def test_a_run_tells_how_many_cases_leave_the_range_of_their_laws():
    messages = Remarks(["crank_rod", "rod_slider"])
    zero = dict.fromkeys(
        (f"{joint}_{figure}" for joint in messages.joints for figure in (ONSET_RATE, LIMIT_SHARE)), 0.0
    )
    zero |= {"crank_rod_yield_speed": 0.1, "rod_slider_yield_speed": 0.5}
    messages.add(columns_of_case({"case_id": "a", "message": "", **zero, "rod_slider_onset_rate_max": 0.5}))
    messages.add(columns_of_case({"case_id": "b", "message": "", **zero, "crank_rod_onset_rate_max": 0.4}))
    messages.add(columns_of_case({"case_id": "c", "message": "", **zero, "rod_slider_onset_rate_max": 5.0}))
    message = law_range_remark([("crank-rod", "liu", np.inf, 0.0), ("rod-slider", "johnson", 2e-4, 0.125)])
    messages.add(columns_of_case({"case_id": "d", "message": message, **zero, "rod_slider_law_limit_fraction": 0.125}))
    messages.add(columns_of_case({"case_id": "e", "message": None, **zero, "rod_slider_law_limit_fraction": None}))
    fast, deep = messages.sentences()
    assert "in 2 of 5 cases: the fastest approaches at 5 m/s, 10 times the 0.5 m/s at which its contact first" in fast
    assert "(case c, rod-slider)" in fast
    assert "Beyond yield an elastic law overstates forces" in fast  # which law it is the row does not say
    assert "in 1 of 5 cases, longest in case d: rod-slider exceeds 0.2 mm, the limit of johnson," in deep
    assert "for 12 % of the time." in deep
    together = Remarks(messages.joints)
    rates = {column: [value] * 3 for column, value in zero.items()}
    rates["crank_rod_onset_rate_max"] = [0.11, np.nan, 0.5]
    together.add({"case_id": list("abc"), "message": ["", message, None], **rates})
    assert "in 2 of 3 cases: the fastest approaches at 0.5 m/s" in together.sentences()[0]
    assert "(case c, crank-rod)" in together.sentences()[0]


def test_contacts_of_unknown_strength_are_not_blamed():
    message = Remarks(["crank_rod", "rod_slider"])
    rows = {"case_id": list("abc"), "message": ["", "", ""]}
    rows |= {f"{joint}_law_limit_fraction": [0.0] * 3 for joint in message.joints}
    rows |= {"crank_rod_onset_rate_max": [0.6, 0.2, 0.0], "rod_slider_onset_rate_max": [9.0, 9.0, 9.0]}
    rows |= {"crank_rod_yield_speed": [None, 0.1, 0.1]}  # of a law that yields; nothing is known of rod-slider
    message.add(rows)
    (fast,) = message.sentences()
    assert "in 1 of 3 cases: the fastest approaches at 0.2 m/s, 2 times the 0.1 m/s" in fast
    assert "(case b, crank-rod)" in fast
    assert required_columns(message.joints, rows)[-1] == f"crank_rod_{YIELD_SPEED}"


def test_a_run_within_what_its_laws_are_made_for_has_nothing_to_tell():
    message = Remarks(["pair"])
    message.add(
        columns_of_case({"case_id": "a", "message": "", "pair_onset_rate_max": 0.0, "pair_law_limit_fraction": 0.0})
    )
    assert message.sentences() == []
    assert law_range_remark([("pair", "johnson", 1e-4, 0.0)]) == ""


@pytest.mark.parametrize(("law", "pulls"), [("tsuji", True), ("exact", False)])
def test_a_law_that_pulls_is_named_before_the_run(law, pulls):
    contact = {"law": law, "stiffness": 1e9, "restitution": 0.7, **({"mass": 0.1} if pulls else {})}
    case = clearsweep.load_case(slider_crank("rod-slider", changes={"joints.rod-slider.contact": contact})).case
    assert any("tsuji pulls before the surfaces part" in sentence for sentence in simulation.warnings(case)) == pulls


@pytest.mark.filterwarnings("ignore:overflow")
def test_a_step_that_overflows_is_rejected():
    from clearsweep.mechanics.solver.collocation import error_norm

    coefficients = np.zeros((4, 8))
    coefficients[2, 7] = 1e200
    assert error_norm(coefficients, np.ones(4)) == np.inf
    coefficients[2, 7] = np.nan
    assert not error_norm(coefficients, np.ones(4)) < 1.0
