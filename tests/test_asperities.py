"""The load of asperities: Hertz's law for pairs of their tips, summed over both surfaces."""

import math

import numpy as np
import pytest
from scipy.integrate import quad

from clearsweep.contracts.case import Contact, Film, Joint, Material, Materials
from clearsweep.mechanics.laws.contract import RECIPES
from clearsweep.mechanics.laws.film import GreenwoodTripp, Ramp, asperity_integral, asperity_load
from clearsweep.tracing.compiled.dual import Dual

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
