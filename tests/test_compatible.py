"""Conformal contact over an elastic arc: a contact solved on a grid, Johnson's and Persson's limits, fits to it."""

import math
from pathlib import Path

import numpy as np
import pytest
from arc_contact import on_a_grid, persson_load, persson_peak
from law_cases import RECIPES, force, joint
from mechanism_cases import slider_crank
from scipy.integrate import quad
from scipy.optimize import brentq

from clearsweep import InputError, grid, simulation
from clearsweep.mechanics.joints import registry
from clearsweep.mechanics.laws.cylinders import END_DEPTH, MAX_HALF_ANGLE, Compatible, depth_of_arc
from clearsweep.mechanics.laws.elastic import elastic_energy, elastic_force

UNIT = Compatible(0.5 * math.pi, 1.0)  # force over E* c L at a penetration in clearances
MODULUS, CLEARANCE, LENGTH, RADIUS = 207e9 / (2.0 * (1.0 - 0.3**2)), 0.5e-3, 20e-3, 10e-3


@pytest.mark.few("0.1")
@pytest.mark.parametrize("depth", [1e-6, 2e-3, 0.1, 0.5])
def test_force_arc_and_pressure_are_those_of_a_contact_on_a_grid(depth):
    result = on_a_grid(depth, elements=150)
    assert elastic_force(UNIT, depth) == pytest.approx(result.load, rel=1e-5)
    half = brentq(lambda angle: depth_of_arc(angle) - depth, 1e-9, 1.3, xtol=1e-14)
    assert result.half_angle == pytest.approx(half, rel=0.02)
    s = math.sin(0.5 * half)
    inside = result.angles < 0.9 * half
    t = np.sin(0.5 * result.angles[inside])
    ellipse = (1.0 + depth) * np.cos(0.5 * result.angles[inside]) * np.sqrt(s * s - t * t)
    assert result.pressure[inside] == pytest.approx(ellipse, rel=5e-3)


def test_it_is_johnson_s_law_where_the_arc_is_small():
    for pen in (1e-12, 1e-10, 1e-8):
        assert force("compatible", pen) == pytest.approx(force("johnson", pen), rel=2.0 * pen / CLEARANCE)


def test_it_bears_what_persson_s_pressure_bears_over_the_same_arc():
    for degrees, allowed in ((0.1, 1e-5), (1, 6e-4), (5, 0.0071), (20, 0.033), (40, 0.041)):
        angle = math.radians(degrees)
        assert elastic_force(UNIT, depth_of_arc(angle)) == pytest.approx(persson_load(angle), rel=allowed)
    below = elastic_force(UNIT, depth_of_arc(MAX_HALF_ANGLE)) / persson_load(MAX_HALF_ANGLE) - 1.0
    assert below == pytest.approx(-0.0909, abs=1e-4, rel=0.0)


def test_the_rigid_arc_is_four_times_as_stiff_at_a_micrometre():
    assert force("persson", 1e-6) / force("compatible", 1e-6) == pytest.approx(4.39, rel=1e-3)


def test_beyond_twice_the_secant_the_tangent_continues():
    step = 1e-6
    before = (elastic_force(UNIT, END_DEPTH) - elastic_force(UNIT, END_DEPTH - step)) / step
    after = (elastic_force(UNIT, END_DEPTH + step) - elastic_force(UNIT, END_DEPTH)) / step
    assert before == pytest.approx(2.0 * elastic_force(UNIT, END_DEPTH) / END_DEPTH, rel=1e-5)
    assert after == pytest.approx(before, rel=1e-5)


@pytest.mark.parametrize(("depth", "allowed"), [(1e-6, 1e-9), (1e-2, 1e-8), (0.3, 2e-7), (0.5, 1e-6), (3.0, 2e-5)])
def test_the_energy_is_the_integral_of_the_force(depth, allowed):
    points = [math.log(END_DEPTH)] if depth > END_DEPTH else None
    whole, _ = quad(
        lambda x: elastic_force(UNIT, math.exp(x)) * math.exp(x),
        -60.0,
        math.log(depth),
        points=points,
        epsabs=0.0,
        epsrel=1e-11,
        limit=500,
    )
    assert elastic_energy(UNIT, depth) == pytest.approx(whole, rel=allowed)


@pytest.mark.few
def test_the_table_of_the_model_is_what_the_grid_gives():
    text = Path("docs/model-contact.md").read_text(encoding="utf-8").partition("half-angle, deg")[2]
    rows = [line for line in text.splitlines()[2:12] if line.startswith("| ")]
    assert len(rows) == 7
    for row in rows:
        pen, *shown = map(float, row.strip("| ").split("|"))
        result = on_a_grid(1e-6 * pen / CLEARANCE, elements=150)
        unit, pressure = MODULUS * CLEARANCE * LENGTH, MODULUS * CLEARANCE / RADIUS
        laws = [force(name, 1e-6 * pen) for name in ("compatible", "johnson", "compatible-fit", "persson")]
        expected = [
            math.degrees(result.half_angle),
            result.load * unit,
            *laws,
            persson_load(result.half_angle) * unit,
            1e-6 * result.peak * pressure,
            1e-6 * persson_peak(result.load) * pressure,
        ]
        assert shown == pytest.approx(expected, rel=2e-2), row  # an arc is a whole number of elements
        assert shown[1:6] + shown[7:] == pytest.approx(expected[1:6] + expected[7:], rel=1e-3), row


# ---------------------------------------------------------------------------------------------- a power


def test_the_power_is_as_close_to_it_as_the_residual_says():
    section = joint(elastic="compatible-fit", fit_from=1e-6, fit_to=1e-5)
    derived = registry.derived_values(section)
    depths = np.geomspace(1e-6, 1e-5, 5000)
    term = RECIPES["elastic", "compatible-fit"].make(section)
    error = np.array([elastic_force(term, pen) / force("compatible", pen) - 1.0 for pen in depths])
    residual = derived["contact.fit_residual"][0]
    assert np.sqrt(np.mean(error**2)) == pytest.approx(residual, rel=0.02)
    assert 1e-3 < residual < 0.02
    assert 1.1 < derived["contact.exponent"][0] < 1.2
    assert derived["contact.penetration_limit"] == (1e-5, "m")


def with_points(tmp_path, name, rows):
    points = tmp_path / name
    points.write_text("penetration [um],force [kN]\n" + "".join(f"{pen!r},{load!r}\n" for pen, load in rows))
    contact = {"law": "exact", "restitution": 0.6, "elastic": "compatible-fit", "fit": str(points)}
    return slider_crank("rod-slider", changes={"joints.rod-slider.contact": contact})


def loaded(source):
    return grid.load(source, simulation.catalogue())


def test_scattered_points_are_fitted_by_least_squares_of_log_force(tmp_path):
    rows = [(0.5, 0.11e-3), (1.0, 0.19e-3), (2.0, 0.52e-3), (4.0, 0.95e-3), (9.0, 3.1e-3)]  # um, kN
    joint_of_points = loaded(with_points(tmp_path, "points.csv", rows)).case(0).joints[0]
    x, y = (np.log([scale * row[k] for row in rows]) for k, scale in ((0, 1e-6), (1, 1e3)))
    exponent = np.sum((x - x.mean()) * (y - y.mean())) / np.sum((x - x.mean()) ** 2)
    logarithm = y.mean() - exponent * x.mean()
    derived = registry.derived_values(joint_of_points)
    assert derived["contact.exponent"][0] == pytest.approx(exponent, rel=1e-12)
    assert derived["contact.stiffness"][0] == pytest.approx(math.exp(logarithm), rel=1e-10)
    off = np.exp(logarithm + exponent * x - y) - 1.0
    assert derived["contact.fit_residual"][0] == pytest.approx(np.sqrt(np.mean(off**2)), rel=1e-10)
    assert off.max() > 0.05


def test_points_of_one_s_own_give_stiffness_and_exponent_without_a_material(tmp_path):
    rows = [(pen, 1e-3 * 3e9 * (1e-6 * pen) ** 1.2) for pen in (0.5, 1.0, 3.0, 10.0)]
    source = with_points(tmp_path, "points.csv", rows)
    case = loaded(source).case(0)
    term = registry.compile_contact(case.joints[0])[1]
    assert (term.stiffness, term.exponent) == (pytest.approx(3e9, rel=1e-9), pytest.approx(1.2, rel=1e-12))
    assert registry.penetration_limit(case.joints[0]) == pytest.approx(10e-6, rel=1e-12)
    moved = loaded(with_points(tmp_path, "moved.csv", rows))
    assert moved.case_id(0) == loaded(source).case_id(0)
    other = loaded(with_points(tmp_path, "points.csv", [(0.5, 0.1), *rows[1:]]))
    assert other.case_id(0) != moved.case_id(0)


def test_forces_that_fall_are_reported(tmp_path):
    case = loaded(with_points(tmp_path, "points.csv", [(1.0, 2.0), (2.0, 1.0)])).case(0)
    with pytest.raises(InputError, match=r"contact\.fit: its forces do not grow"):
        registry.compile_contact(case.joints[0])
