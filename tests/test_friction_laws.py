"""Friction laws: one battery for all of them, then their published values."""

import math

import numpy as np
import pytest
from law_cases import RECIPES, compiled_friction, few, in_millimetres, joint, names, written
from mechanism_cases import slider_crank

import clearsweep
from clearsweep.contracts.case import Friction
from clearsweep.mechanics.joints import registry
from clearsweep.mechanics.laws.friction import friction_force

LAWS = names("friction")
_FORWARD = np.geomspace(1e-12, 1e3, 300)
SLIPS = np.concatenate([-_FORWARD[::-1], [0.0], _FORWARD])


def made(name, **changes):
    return registry.compile_friction(joint(friction=name, **changes))


def force(name, slip, normal=100.0, **numbers):
    term = RECIPES["friction", name].make(joint()._replace(friction=Friction(name, numbers)))
    return friction_force(term, normal, slip)


# ---------------------------------------------------------------------------------------------- every law


@pytest.mark.parametrize("name", LAWS)
def test_friction_never_drives_is_odd_and_finite(name):
    term = made(name)
    forces = np.array([friction_force(term, 100.0, slip) for slip in SLIPS])
    assert np.all(np.isfinite(forces))
    assert np.all(forces * SLIPS <= 0.0)
    np.testing.assert_allclose(forces, -forces[::-1], rtol=0.0, atol=0.0)
    assert friction_force(term, 100.0, 0.0) == 0.0


@pytest.mark.parametrize("name", LAWS)
def test_friction_is_proportional_to_the_normal_force(name):
    term = made(name)
    for slip in (-0.3, 1e-4, 2e-3, 5.0):
        assert friction_force(term, 0.0, slip) == 0.0
        assert friction_force(term, 300.0, slip) == pytest.approx(3.0 * friction_force(term, 100.0, slip), rel=1e-14)


@pytest.mark.parametrize("name", LAWS)
def test_compiled_and_plain_code_give_the_same_force(name):
    term = made(name)
    plain = [friction_force(term, 100.0, slip) for slip in SLIPS]
    # to rounding of the normal force: compiled code fuses products and sums, so what cancels cancels otherwise
    np.testing.assert_allclose(compiled_friction(term, 100.0, SLIPS), plain, rtol=1e-13, atol=1e-13 * 100.0)


@pytest.mark.parametrize("name", LAWS)
def test_a_law_does_not_depend_on_the_unit_of_length(name):
    scaled = registry.compile_friction(in_millimetres(written(friction=name)))
    for slip in (1e-4, 1.5e-3, 0.3):
        expected = friction_force(registry.compile_friction(joint(friction=name)), 100.0, slip)
        assert friction_force(scaled, 100.0, 1e3 * slip) == pytest.approx(expected, rel=1e-12)


@pytest.mark.compiled  # as plain Python, shorter: test_plain
@pytest.mark.parametrize("name", few("friction", "ambrosio", "lugre"))
def test_friction_takes_energy_out_of_a_slider_crank(name):
    section = written(friction=name)["friction"]
    section |= {key: 0.1 for key in section if key == "velocity_scale"}
    case = slider_crank("rod-slider", changes={"joints.rod-slider.friction": section, "simulate.revolutions": 0.2})
    run = clearsweep.simulate(clearsweep.load_case(case))
    assert run.status == "ok"
    assert run.summary["energy_residual"] < 1e-6


# ---------------------------------------------------------------------------------------------- published values


@pytest.mark.parametrize("name", ["tanh", "coulomb"])
def test_smoothed_coulomb_friction(name):
    assert force(name, 0.01, coefficient=0.1, velocity_scale=0.01) == pytest.approx(-0.761594 * 10.0, rel=1e-6)


def test_ambrosio_has_a_dead_band_and_a_ramp():
    numbers = {"coefficient": 0.1, "v0": 1e-3, "v1": 3e-3}
    assert force("ambrosio", 2e-3, **numbers) == pytest.approx(-5.0)
    assert force("ambrosio", -0.9e-3, **numbers) == 0.0
    assert force("ambrosio", -1.0, **numbers) == pytest.approx(10.0)


def test_threlfall_rises_as_printed_and_jumps_by_two_hundredths_of_a_percent():
    numbers = {"coefficient": 0.1, "velocity_scale": 0.02, "divisor": 0.95}
    assert force("threlfall", 0.01, **numbers) == pytest.approx(-8.17758, rel=1e-6)
    assert force("threlfall", 0.02, **numbers) == pytest.approx(-10.00224, rel=1e-6)
    assert force("threlfall", math.nextafter(0.02, 1.0), **numbers) == pytest.approx(-10.0, rel=1e-15)


def test_threlfall_without_the_division_is_five_per_cent_lower_throughout():
    numbers = {"coefficient": 0.1, "velocity_scale": 0.02}
    for slip in (1e-4, 0.01, 0.02, 0.021, 5.0):
        ratio = force("threlfall", slip, divisor=1.0, **numbers) / force("threlfall", slip, divisor=0.95, **numbers)
        assert ratio == pytest.approx(0.95, rel=1e-14)
    assert force("threlfall", 0.01, divisor=1.0, **numbers) == pytest.approx(-10.0 * (1.0 - math.exp(-1.5)), rel=1e-14)
    assert force("threlfall", 5.0, divisor=1.0, **numbers) == pytest.approx(-9.5, rel=1e-14)


def test_brown_and_mcphee_s_friction_peaks_at_its_speed_and_then_falls():
    numbers = {"coefficient": 0.1, "static_coefficient": 0.15, "stribeck_velocity": 2e-3, "viscous": 0.0}
    at = force("brown-mcphee", 2e-3, **numbers)
    assert at == pytest.approx(-100.0 * (0.15 - 0.1 * (1.0 - math.tanh(4.0))), rel=1e-14)
    slips = np.linspace(1e-5, 4e-3, 4000)
    forces = np.array([-force("brown-mcphee", slip, **numbers) for slip in slips])
    assert slips[forces.argmax()] == pytest.approx(2e-3, rel=0.01)
    assert forces.max() == pytest.approx(15.0, rel=5e-4)
    assert force("brown-mcphee", 2.0, **numbers) == pytest.approx(-10.0, rel=1e-8)
    slope = -force("brown-mcphee", 1e-12, **numbers) / 1e-12  # N s/m at rest
    assert slope == pytest.approx(100.0 * (4.0 * 0.1 + 0.05 / 0.75**2) / 2e-3, rel=1e-9)
    more = force("brown-mcphee", 0.5, **numbers | {"viscous": 0.04}) - force("brown-mcphee", 0.5, **numbers)
    assert more == pytest.approx(-100.0 * 0.02, rel=1e-12)


def test_brown_and_mcphee_s_steady_sliding_loses_the_area_under_its_curve():
    """The work of a slip that swings, over a whole swing, against the integral in closed form."""
    numbers = {"coefficient": 0.1, "static_coefficient": 0.15, "stribeck_velocity": 2e-3, "viscous": 0.0}
    x = np.linspace(0.0, 5.0, 20001)
    area = np.trapezoid([-force("brown-mcphee", 2e-3 * each, **numbers) for each in x], x)
    closed = 100.0 * (0.1 * math.log(math.cosh(20.0)) / 4.0 + 0.05 * 2.0 * (1.0 / 0.75 - 1.0 / (25.0 / 4.0 + 0.75)))
    assert area == pytest.approx(closed, rel=1e-7)


def test_bengisu_akay_rises_to_static_and_falls_to_kinetic_friction():
    numbers = {"coefficient": 0.1, "static_coefficient": 0.15, "velocity_scale": 0.01, "decay": 100.0}
    assert force("bengisu-akay", 0.005, **numbers) == pytest.approx(-0.75 * 15.0)
    assert force("bengisu-akay", 0.01, **numbers) == pytest.approx(-15.0)
    assert force("bengisu-akay", 0.02, **numbers) == pytest.approx(-(10.0 + 5.0 * math.exp(-1.0)))
    assert force("bengisu-akay", -10.0, **numbers) == pytest.approx(10.0)


def test_stribeck_falls_from_static_to_kinetic_friction():
    numbers = {"coefficient": 0.1, "static_coefficient": 0.15, "stribeck_velocity": 1e-3, "velocity_scale": 1e-6}
    gauss = force("stribeck", 1e-3, shape=2.0, viscous=0.0, **numbers)
    assert gauss == pytest.approx(-100.0 * 0.11839397, rel=1e-7)
    assert force("stribeck", 1e-5, shape=1.0, viscous=0.0, **numbers) == pytest.approx(
        -100.0 * (0.1 + 0.05 * math.exp(-0.01))
    )
    assert force("stribeck", 0.5, shape=2.0, viscous=0.04, **numbers) == pytest.approx(-100.0 * (0.1 + 0.02))
