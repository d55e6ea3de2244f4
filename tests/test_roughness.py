"""Rough surfaces in series with an elastic law: sums over spots, their limits, profiles, what a grid says of them."""

import math

import numpy as np
import pytest
from law_cases import RECIPES, compiled_elastic, joint
from mechanism_cases import PAIR, changed, slider_crank
from scipy.integrate import quad

import clearsweep
from clearsweep import grid, simulation
from clearsweep.contracts.case import Contact, Film, Joint, Material, Materials, Roughness
from clearsweep.mechanics import describe
from clearsweep.mechanics.joints import registry
from clearsweep.mechanics.laws.elastic import elastic_energy, elastic_force
from clearsweep.mechanics.laws.film import GreenwoodTripp, Ramp, asperity_integral, asperity_load
from clearsweep.mechanics.laws.roughness import (
    domain_extension,
    fit_profile,
    log_critical_area,
    log_spot_load,
    log_total_load,
    make_kogut_etsion_surface,
    make_yielding_surface,
)
from clearsweep.tracing.compiled import calculus
from clearsweep.tracing.compiled.dual import Dual

MODULUS, HARDNESS, POISSON = 113.7e9, 5.5e9, 0.3
BULK = ("power", "johnson", "liu", "persson", "compatible")
TEXTURE = {"dimension": 1.5, "scale": 1e-11, "hardness": HARDNESS}


def profile(dimension, scale=1e-10, rows=4000, seed=1):
    """Return places and heights (m) of a Weierstrass-Mandelbrot profile, its waves far shorter than its steps, too."""
    x = np.arange(rows) * 1e-6
    draw, heights = np.random.default_rng(seed), np.zeros(rows)
    for n in range(math.floor(math.log(0.1 / x[-1]) / math.log(1.5)), math.ceil(math.log(5e8) / math.log(1.5))):
        heights += 1.5 ** ((dimension - 2.0) * n) * np.cos(
            2.0 * math.pi * 1.5**n * x + draw.uniform(0.0, 2.0 * math.pi)
        )
    return x, scale ** (dimension - 1.0) * heights


def rough(elastic="johnson", law="fractal", **texture):
    """Return a steel joint of which `texture` replaces what the roughness is made of."""
    return joint(elastic=elastic)._replace(roughness=Roughness(law, TEXTURE | texture, {}))


def term_of(section):
    return registry.compile_contact(section)[1]


# ---------------------------------------------------------------------------------------------- spots


@pytest.mark.parametrize(
    ("dimension", "scale", "critical", "elastic", "plastic"),
    [
        (1.4, 1e-11, 1.2082e-14, 22.1796, 2.15269),
        (1.5, 1e-11, 2.9222e-16, 11.0559, 2.15731),
        (1.6, 1e-11, 2.4440e-17, 8.49636, 4.16909),
        (1.3, 1e-12, 5.9729e-14, 31.6301, 1.51661),
    ],
)
def test_the_load_on_fractal_spots_has_its_tabulated_parts(dimension, scale, critical, elastic, plastic):
    surface = make_yielding_surface(dimension, scale, HARDNESS, MODULUS)
    assert math.exp(log_critical_area(dimension, scale, 2.0 * MODULUS / HARDNESS)) == pytest.approx(critical, rel=5e-5)
    largest = np.log([1e-8])
    whole = math.exp(log_total_load(surface, largest)[0])
    hard = surface._replace(pieces=(surface.pieces[0], surface.pieces[1]._replace(log_factor=-700.0)))
    yielded = math.exp(log_total_load(hard, largest)[0])
    assert yielded == pytest.approx(plastic, rel=5e-6)
    assert whole - yielded == pytest.approx(elastic, rel=5e-6)


@pytest.mark.parametrize(("dimension", "psi"), [(1.3, 2.18371), (1.4, 2.08485), (1.5, 2.00071), (1.6, 1.92831)])
def test_the_domain_of_the_spots_is_extended_as_tabulated(dimension, psi):
    assert domain_extension(dimension) == pytest.approx(psi, rel=3e-6)


def test_spots_that_all_yield_bear_the_hardness():
    surface = make_yielding_surface(1.5, 1e-9, HARDNESS, MODULUS)
    largest = surface.pieces[0].log_upper_area - 3.0
    assert log_total_load(surface, np.array([largest]))[0] == pytest.approx(
        math.log(3.0 * HARDNESS) + largest, rel=1e-14
    )


@pytest.mark.parametrize(("r", "below", "above"), [(1.0, 1.0, 1.03), (6.0, 13.234, 13.457), (110.0, 530.16, 571.92)])
def test_an_asperity_jumps_between_its_regimes_as_the_fits_do(r, below, above):
    dimension, scale = 1.5, 1e-11
    surface, factor = make_kogut_etsion_surface(dimension, scale, HARDNESS, MODULUS, POISSON), 0.454 + 0.41 * POISSON
    critical = log_critical_area(dimension, scale, 2.0 * MODULUS / (factor * HARDNESS))
    area = critical - math.log(r) / (dimension - 1.0)
    unit = math.log(2.0 / 3.0 * factor * HARDNESS / math.pi / r) + area  # F_c of an asperity of this area
    softer, harder = (math.exp(log_spot_load(surface, area + step)[()] - unit) for step in (1e-9, -1e-9))
    assert (softer, harder) == (pytest.approx(below, rel=4e-5), pytest.approx(above, rel=4e-5))


def test_the_elastic_regime_is_hertz_s_force_on_a_sphere():
    dimension, scale, area = 1.4, 1e-11, 1e-9
    surface = make_kogut_etsion_surface(dimension, scale, HARDNESS, MODULUS, POISSON)
    depth = scale ** (dimension - 1.0) * area ** (1.0 - 0.5 * dimension)
    radius = area ** (0.5 * dimension) / (math.pi**2 * scale ** (dimension - 1.0))
    hertz = 4.0 / 3.0 * MODULUS * math.sqrt(radius) * depth**1.5
    assert math.exp(log_spot_load(surface, math.log(area))[()]) == pytest.approx(hertz, rel=1e-12)


@pytest.mark.parametrize("dimension", [1.2, 1.5, 1.8])
@pytest.mark.parametrize("make", [make_yielding_surface, lambda *given: make_kogut_etsion_surface(*given, POISSON)])
def test_the_sum_over_all_spots_is_an_integral(dimension, make):
    surface = make(dimension, 1e-10, HARDNESS, MODULUS)
    last = surface.pieces[-2].log_upper_area + 5.0
    ends = [piece.log_upper_area for piece in surface.pieces[:-1]]

    def borne(area):  # by spots around an area, over ln area
        spots = 0.5 * dimension * math.exp(0.5 * dimension * (last - area))
        return math.exp(log_spot_load(surface, area)[()]) * spots

    parts = zip([ends[0] - 200.0, *ends], [*ends, last], strict=True)
    whole = sum(quad(borne, low, high, epsabs=0.0, epsrel=1e-11, limit=200)[0] for low, high in parts)
    assert log_total_load(surface, np.array([last]))[0] == pytest.approx(math.log(whole), rel=1e-9)


# ---------------------------------------------------------------------------------------------- in series


def total_depth(force, surface, bulk, section):
    """Return the penetration (m) at a force (N), by bisection and the sums of this file alone."""
    dimension, scale, psi = surface.dimension, surface.scale, domain_extension(surface.dimension)
    low, high = -150.0, 20.0
    for _ in range(100):
        middle = 0.5 * (low + high)
        spread = math.log(psi) * (1.0 - 0.5 * dimension)
        low, high = (
            (middle, high)
            if log_total_load(surface, np.array([middle]))[0] + spread < math.log(force)
            else (low, middle)
        )
    spots = psi ** (1.0 - 0.5 * dimension) * dimension / (2.0 - dimension) * math.exp(low)
    modulus = 207e9 / (2.0 * 0.91)
    narrow, wide = 0.0, math.radians(84.8)
    for _ in range(100):
        angle = 0.5 * (narrow + wide)
        b2 = math.tan(0.5 * angle) ** 2
        borne = 2.0 * math.pi * b2 * (b2 + 1.0) / (2.0 - math.log1p(b2) - 2.0 * b2 * b2)
        enough = borne * modulus * section.clearance * section.length < force
        narrow, wide = (angle, wide) if enough else (narrow, angle)
    contents = low - math.log1p((spots / (2.0 * section.bearing_radius * angle * section.length)) ** 8) / 8.0
    return bulk + scale ** (dimension - 1.0) * math.exp((1.0 - 0.5 * dimension) * contents)


@pytest.mark.parametrize("elastic", BULK)
@pytest.mark.parametrize("texture", [(1.5, 1e-11), (1.3, 1e-10), (1.8, 1e-10)])
def test_bodies_and_asperities_share_the_penetration_at_one_force(elastic, texture):
    dimension, scale = texture
    section = rough(elastic, dimension=dimension, scale=scale)
    term, bulk = term_of(section), term_of(section._replace(roughness=None))
    surface = make_yielding_surface(dimension, scale, HARDNESS, 207e9 / (2.0 * 0.91))
    for depth in np.geomspace(1e-8, 1e-4, 9):
        force = elastic_force(bulk, depth)
        total = total_depth(force, surface, depth, section)
        assert elastic_force(term, total) == pytest.approx(force, rel=5e-4)


def test_away_from_the_critical_area_the_table_errs_by_less_than_a_billionth():
    section = rough("compatible", dimension=1.6, scale=1e-11)
    term, bulk = term_of(section), term_of(section._replace(roughness=None))
    surface = make_yielding_surface(1.6, 1e-11, HARDNESS, 207e9 / (2.0 * 0.91))
    for depth in np.geomspace(1e-8, 1e-4, 15):
        force = elastic_force(bulk, depth)
        assert elastic_force(term, total_depth(force, surface, depth, section)) == pytest.approx(force, rel=1e-9)


@pytest.mark.parametrize("law", ["fractal", "kogut-etsion"])
@pytest.mark.parametrize("elastic", [name for of, name in RECIPES if of == "elastic"])
def test_every_elastic_law_with_rough_surfaces_grows_from_zero_and_is_softer(law, elastic):
    section = rough(elastic, law)
    term, bulk = term_of(section), term_of(section._replace(roughness=None))
    assert elastic_force(term, 0.0) == 0.0
    pens = np.geomspace(1e-20, 1e-2, 300)
    forces = np.array([elastic_force(term, pen) for pen in pens])
    smooth = np.array([elastic_force(bulk, pen) for pen in pens])
    assert np.all(np.diff(forces) > 0.0)
    assert np.all(forces < smooth)
    assert forces[-1] > 0.5 * smooth[-1]


@pytest.mark.parametrize("law", ["fractal", "kogut-etsion"])
@pytest.mark.parametrize("elastic", BULK)
def test_without_heights_the_smooth_law_is_left(law, elastic):
    section = rough(elastic, law, scale=1e-60)
    term, bulk = term_of(section), term_of(section._replace(roughness=None))
    for pen in np.geomspace(1e-9, 1e-2, 60):
        assert elastic_force(term, pen) == pytest.approx(elastic_force(bulk, pen), rel=1e-9, abs=0.0)
        if pen < 1e-4:
            assert elastic_energy(term, pen) == pytest.approx(elastic_energy(bulk, pen), rel=1e-5, abs=0.0)
    assert registry.penetration_limit(section) == pytest.approx(
        registry.penetration_limit(section._replace(roughness=None)), rel=1e-9
    )


@pytest.mark.parametrize("texture", [{"dimension": 1.001}, {"dimension": 1.999}, {"scale": 1e-3}, {"hardness": 1.0}])
def test_the_ends_of_the_ranges_are_finite(texture):
    for law in ("fractal", "kogut-etsion"):
        term = term_of(rough(law=law, **texture))
        forces = np.array([elastic_force(term, pen) for pen in np.geomspace(1e-12, 1e-2, 60)])
        assert np.isfinite(forces).all()
        assert np.all(np.diff(forces) >= 0.0)


@pytest.mark.parametrize("law", ["fractal", "kogut-etsion"])
def test_the_energy_is_the_integral_of_the_force(law):
    term = term_of(rough(law=law))
    for pen in (1e-9, 1e-6, 1e-4):
        whole = quad(
            lambda x: elastic_force(term, math.exp(x)) * math.exp(x),
            math.log(1e-17),
            math.log(pen),
            epsabs=0.0,
            epsrel=1e-10,
            limit=2000,
        )[0]
        assert elastic_energy(term, pen) == pytest.approx(whole, rel=1e-9)


def test_the_penetration_limit_is_that_of_the_bodies_plus_what_the_asperities_give():
    section = rough("winkler", dimension=1.9, scale=1e-12)  # too smooth to be flattened
    smooth = section._replace(roughness=None)
    limit, bulk = registry.penetration_limit(section), registry.penetration_limit(smooth)
    assert bulk < limit < 1.001 * bulk
    force = elastic_force(term_of(smooth), bulk)
    assert elastic_force(term_of(section), limit) == pytest.approx(force, rel=1e-9)


def test_flattened_asperities_end_the_range():
    section = rough("johnson", dimension=1.5, scale=1e-11)
    limit = registry.penetration_limit(section)
    assert limit == pytest.approx(2.8e-6, rel=0.05)
    assert registry.derived_values(section)["contact.penetration_limit"] == (limit, "m")
    assert section.elastic_name == "johnson with fractal roughness"


@pytest.mark.plain
def test_the_slope_that_the_implicit_method_sees_is_that_of_the_force():
    assert calculus.log(Dual(2.0, 1.0)).slope == 0.5  # these are plain Python's
    term = term_of(rough("compatible"))
    for pen in (1e-15, 1e-9, 1e-6, 1e-4, 0.2):
        step = 1e-6 * pen
        expected = (elastic_force(term, pen + step) - elastic_force(term, pen - step)) / (2.0 * step)
        assert elastic_force(term, Dual(pen, 1.0)).slope == pytest.approx(expected, rel=1e-7)


@pytest.mark.heavy
@pytest.mark.compiled
def test_compiled_code_reads_the_same_table():
    term = term_of(rough("johnson"))
    pens = np.append(0.0, np.geomspace(1e-16, 1.0, 300))
    plain = [elastic_force(term, pen) for pen in pens]
    np.testing.assert_allclose(compiled_elastic(term, pens), plain, rtol=1e-12, atol=0.0)


@pytest.mark.plain
@pytest.mark.parametrize("law", ["fractal", "kogut-etsion"])
def test_a_free_impact_of_rough_surfaces_gives_back_the_restitution_requested(law):
    contact = {"law": "exact", "elastic": "johnson", "restitution": 0.6, "material": {"young": 207e9, "poisson": 0.3}}
    sizes = {"clearance": 1e-3, "bearing_radius": 0.01, "length": 0.02}
    pair = sizes | {"contact": contact, "roughness": {"law": law, **TEXTURE}}
    source = changed(PAIR, {"joints.pair": pair, "simulate.impacts": 1, "simulate.tolerance": 1e-10})
    run = clearsweep.simulate(clearsweep.load_case(source))
    assert run.status == "ok"
    assert run.summary["pair_restitution"] == pytest.approx(0.6, rel=1e-8)
    assert run.summary["energy_residual"] < 1e-9


# ---------------------------------------------------------------------------------------------- grids

CONTACT = {"law": "exact", "elastic": "johnson", "restitution": 0.6, "material": {"young": 207e9, "poisson": 0.3}}


def source(**roughness):
    section = {"law": "fractal", "dimension": 1.5, "scale": "1e-11 m", "hardness": "5.5 GPa"} | roughness
    section = {key: value for key, value in section.items() if value is not None}
    changes = {"joints.rod-slider.contact": CONTACT, "joints.rod-slider.roughness": section}
    return slider_crank("rod-slider", changes=changes)


def loaded(given):
    return grid.load(given, simulation.catalogue())


def with_profile(path, seed=1):
    x, heights = profile(1.5, rows=1000, seed=seed)
    rows = "".join(f"{1e3 * a!r},{1e6 * b!r}\n" for a, b in zip(x.tolist(), heights.tolist(), strict=True))
    path.write_text(f"x [mm],height [um]\n{rows}")
    return source(from_profile=str(path), dimension=None, scale=None)


def test_a_profile_takes_the_place_of_dimension_and_scale_by_its_content(tmp_path):
    first = loaded(with_profile(tmp_path / "a.csv"))
    joint = first.case(0).joints[0]
    derived = registry.derived_values(joint)
    result = fit_profile(joint.roughness.tables["from_profile"]["x"], joint.roughness.tables["from_profile"]["height"])
    assert derived["roughness.dimension"] == (result.dimension, "1")
    assert derived["roughness.scale"] == (result.scale, "m")
    assert derived["roughness.dimension_low"][0] < result.dimension < derived["roughness.dimension_high"][0]
    given = rough(dimension=result.dimension, scale=result.scale)
    assert elastic_force(term_of(joint), 1e-6) == elastic_force(term_of(given), 1e-6)
    assert loaded(with_profile(tmp_path / "b.csv")).case_id(0) == first.case_id(0)
    assert loaded(with_profile(tmp_path / "a.csv", seed=2)).case_id(0) != first.case_id(0)


def test_a_smooth_joint_compiles_to_what_it_was():
    smooth = source(law="smooth", dimension=None, scale=None, hardness=None)
    plain = changed(source(), {"joints.rod-slider.roughness": None})
    assert simulation.signature(loaded(smooth).case(0)) == simulation.signature(loaded(plain).case(0))
    assert "Rough" in str(simulation.signature(loaded(source()).case(0)))


def test_rough_and_smooth_surfaces_are_swept_beside_each_other():
    swept = loaded(source() | {"sweep": {"joints.rod-slider.roughness.law": ["smooth", "fractal", "kogut-etsion"]}})
    assert [swept.case(k).joints[0].roughness.law for k in range(3)] == ["smooth", "fractal", "kogut-etsion"]
    assert [sorted(swept.case(k).joints[0].roughness.values) for k in range(2)] == [[], sorted(TEXTURE)]


def test_texture_is_drawn_from_distributions():
    over = {
        "joints.rod-slider.roughness.dimension": {"truncated-normal": {"mean": 1.45, "std": 0.05, "low": 1.3}},
        "joints.rod-slider.roughness.scale": {"lognormal": {"mean": "1e-11 m", "cv": 0.2}},
        "joints.rod-slider.roughness.hardness": {"normal": {"mean": "5.5 GPa", "cv": 0.05}},
        "joints.rod-slider.clearance": {"normal": {"mean": "0.1 mm", "cv": 0.05}},
    }
    drawn = loaded(source() | {"sample": {"method": "latin-hypercube", "n": 8, "seed": 3, "over": over}})
    textures = [drawn.case(k).joints[0].roughness.values for k in range(8)]
    assert len({texture["dimension"] for texture in textures}) == 8
    assert all(1.3 <= texture["dimension"] < 2.0 and texture["scale"] > 0.0 for texture in textures)
    softest, hardest = (
        elastic_force(term_of(drawn.case(k).joints[0]), 1e-6)
        for k in sorted(range(8), key=lambda k: textures[k]["scale"])[::7]
    )
    assert softest != hardest


@pytest.mark.parametrize("law", [name for of, name in RECIPES if of == "law"])
def test_rough_surfaces_go_with_every_contact_law(law):
    contact = dict(joint(law).contact.values)
    given = {"law": law, **contact, "material": {"young": 207e9, "poisson": 0.3}}
    if RECIPES["law", law].law.uses_elastic:
        given.pop("stiffness", None)
        given.pop("exponent", None)
    case = loaded(changed(source(), {"joints.rod-slider.contact": given})).case(0)
    assert "Rough" in type(term_of(case.joints[0])).__name__
    made_for_hertz = "hertz" in RECIPES["law", law].law.needs
    assert any("made for Hertz's force" in sentence for sentence in simulation.warnings(case)) == made_for_hertz


def test_elastic_spots_of_both_laws_differ_by_the_factor_that_their_notes_report():
    """Of F = exp(level) a^power the last piece of `fractal` and the first of `kogut-etsion` are elastic."""
    dimension, scale, hardness, modulus = 1.4, 1e-11, 5.5e9, 113.7e9
    large = make_yielding_surface(dimension, scale, hardness, modulus).pieces[-1]
    spots = make_kogut_etsion_surface(dimension, scale, hardness, modulus, 0.3).pieces
    elastic = next(piece for piece in spots if math.isinf(piece.log_upper_area))
    assert large.power == pytest.approx(elastic.power, rel=1e-12)
    assert math.exp(large.log_factor - elastic.log_factor) == pytest.approx(math.pi**1.5, rel=1e-9)
    for name in ("fractal", "kogut-etsion"):
        assert "do not compare the two at equal G" in " ".join(describe.law_text(name).split())


# ---------------------------------------------------------------------------------------------- profiles


@pytest.mark.parametrize("dimension", [1.3, 1.5, 1.7])
def test_a_profile_of_known_dimension_is_recognised(dimension):
    x, heights = profile(dimension)
    result = fit_profile(tuple(x), tuple(heights))
    assert result.dimension == pytest.approx(dimension, abs=0.03, rel=0.0)
    assert result.dimension_low < dimension < result.dimension_high
    assert result.dimension_high - result.dimension_low < 0.2
    assert math.log10(result.scale) == pytest.approx(-10.0, abs=0.5, rel=0.0)
    assert result.scale_low < result.scale < result.scale_high
    assert result.residual < 0.05


def test_tilt_and_height_of_a_profile_do_not_matter():
    x, heights = profile(1.5, rows=2000)
    tilted = fit_profile(tuple(x), tuple(heights + 0.3 * x + 1.0))
    assert tilted.dimension == pytest.approx(fit_profile(tuple(x), tuple(heights)).dimension, rel=1e-6)


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (lambda x, z: (x[:500], z[:500]), "has 500 rows; at least 1000"),
        (lambda x, z: (x**1.1, z), "expected even steps"),
        (lambda x, z: (x, 0.0 * z), "is flat"),
        (lambda x, z: (x, np.sin(2e3 * x)), "grow with the distance to the power"),
    ],
)
def test_what_is_no_profile_of_a_fractal_is_reported(spoil, message):
    x, heights = spoil(*profile(1.5, rows=1200))
    with pytest.raises(ValueError, match=message):
        fit_profile(tuple(x), tuple(heights))


# ---------------------------------------------------------------------------------------------- asperities


ROUGHNESS, SHARPNESS, DENSITY = 0.4e-6, 0.01, 0.05
STEEL, BRONZE = Material(207e9, 0.3), Material(110e9, 0.34)
CLEARANCE, RADIUS, LENGTH = 50e-6, 0.02, 0.04


def integral(x):
    """Return F_5/2(x), the integral of (s - x)^(5/2) over the Gaussian density of s, with s = x + u^2."""
    return quad(
        lambda u: 2.0 * u**6 * math.exp(-0.5 * (x + u * u) ** 2) / math.sqrt(2.0 * math.pi),
        *(0.0, math.sqrt(12.0 + abs(x))),
        epsrel=1e-10,
        limit=200,
    )[0]


@pytest.mark.parametrize("x", np.arange(0.0, 4.01, 0.25))
def test_the_share_of_asperities_is_its_integral(x):
    assert asperity_integral(x) == pytest.approx(integral(x), rel=2e-3)


@pytest.mark.parametrize("x", [-30.0, -6.0, -2.0, -0.5, 4.5, 5.0])
def test_the_share_of_asperities_is_near_its_integral_beyond(x):
    assert asperity_integral(x) == pytest.approx(integral(x), rel=2e-2)


@pytest.mark.plain  # numbers with a derivative
def test_the_share_of_asperities_falls_smoothly():
    for x in np.arange(-3.0, 5.0, 0.11):
        slope = asperity_integral(Dual(x, 1.0)).slope
        assert slope < 0.0
        assert slope == pytest.approx(
            (asperity_integral(x + 1e-5) - asperity_integral(x - 1e-5)) / 2e-5, rel=1e-7, abs=1e-13
        )
    assert asperity_integral(Dual(1e-9, 1.0)).slope == pytest.approx(
        asperity_integral(Dual(-1e-9, 1.0)).slope, rel=1e-7
    )


def joint_with(**asperities):
    values = {"roughness": ROUGHNESS, "density": DENSITY, "sharpness": SHARPNESS, **asperities}
    film = Film("short", "none", 0.1, 0.99, transition="greenwood-tripp", width=2e-6, asperities=values)
    contact = Contact("hertz", "power", {}, Materials(STEEL, BRONZE))
    return Joint("rod-slider", CLEARANCE, contact, RADIUS, LENGTH, film=film)


def pressure_of_pairs(height):
    """Return the pressure (Pa) of paraboloids: Hertz's force on every pair of tips that reach into each other.

    Two tips of the radius beta each, r aside, overlap by w - r^2 / (4 beta) and press like a ball of radius beta / 2:
    (4 / 3) E* (beta / 2)^(1/2) overlap^(3/2).  There are density / (beta roughness) of them on either surface.
    """
    tip = ROUGHNESS / SHARPNESS
    many = DENSITY / (tip * ROUGHNESS)
    modulus = 1.0 / sum((1.0 - body.poisson**2) / body.young for body in (STEEL, BRONZE))
    x, weights = np.polynomial.legendre.leggauss(40)

    def borne(deep):
        aside = 0.5 * (x + 1.0) * 2.0 * math.sqrt(tip * deep)
        overlap = deep - aside**2 / (4.0 * tip)
        force = 4.0 / 3.0 * modulus * math.sqrt(0.5 * tip) * overlap**1.5
        return float((0.5 * weights * 2.0 * math.sqrt(tip * deep)) @ (2.0 * math.pi * aside * force))

    def density(u):  # of the sum of both heights, height + u^2
        return math.exp(-0.5 * ((height + u * u) / ROUGHNESS) ** 2) / (ROUGHNESS * math.sqrt(2.0 * math.pi))

    end = math.sqrt(9.0 * ROUGHNESS + abs(height))
    return many**2 * quad(lambda u: 2.0 * u * borne(u * u) * density(u) if u else 0.0, 0.0, end, epsrel=1e-8)[0]


@pytest.mark.parametrize("depth", [-1.2e-6, -0.4e-6, 0.0])
def test_asperities_bear_what_hertz_says_of_all_their_pairs(depth):
    """Over the arc; the modulus that a grid may write is E* of both bodies."""
    term = RECIPES["transition", "greenwood-tripp"].make(joint_with())
    eccentricity = CLEARANCE + depth
    x, weights = np.polynomial.legendre.leggauss(32)
    reach = math.acos(min((CLEARANCE - 5.0 * ROUGHNESS) / eccentricity, 1.0))
    angles, weights = 0.5 * reach * (x + 1.0), 0.5 * reach * weights
    pressure = np.array([pressure_of_pairs(CLEARANCE - eccentricity * math.cos(angle)) for angle in angles])
    load = 2.0 * RADIUS * LENGTH * float(weights @ (pressure * np.cos(angles)))
    assert asperity_load(term, depth) == pytest.approx(load, rel=5e-3)
    modulus = 1.0 / sum((1.0 - body.poisson**2) / body.young for body in (STEEL, BRONZE))
    written = RECIPES["transition", "greenwood-tripp"].make(joint_with(modulus=modulus))
    assert asperity_load(written, depth) == pytest.approx(asperity_load(term, depth), rel=1e-12)


def test_asperities_bear_the_integral_of_their_pressure_over_the_arc():
    term = GreenwoodTripp(0.0, 2e-6, 3.0, ROUGHNESS, CLEARANCE, 0.0)
    for depth in (-1.9e-6, -0.5e-6, 0.0, 1e-6):
        eccentricity = CLEARANCE + depth
        edge = math.acos(min((CLEARANCE - 5.0 * ROUGHNESS) / eccentricity, 1.0))

        def pressure(angle, eccentricity=eccentricity):
            return 3.0 * asperity_integral((CLEARANCE - eccentricity * math.cos(angle)) / ROUGHNESS) * math.cos(angle)

        assert asperity_load(term, depth) == pytest.approx(quad(pressure, -edge, edge, epsrel=1e-10)[0], rel=1e-5)
    assert asperity_load(term, -2.0e-6) == asperity_load(term, -1.0) == 0.0
    assert asperity_load(Ramp(0.0, 1e-6), 0.0) == 0.0
