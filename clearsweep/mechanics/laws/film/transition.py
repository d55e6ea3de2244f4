"""Transition from a film to dry contact."""

import math
from typing import NamedTuple

from ....contracts.catalogue import Field, Law
from ....tracing.compiled import calculus
from ....tracing.compiled.dual import as_type_of
from ....tracing.compiled.family import kernel
from ....tracing.portable import gauss_rule
from ...joints.material import plane_strain_modulus
from ...joints.recipe import register
from .contract import asperity_load, dry_fraction

MAX_SEPARATION = 5.0  # standard deviations: further away the load is below 3e-8 of that at contact
#: Of ln F_5/2 + 2.5 ln g by powers of g from the sixth to the first, fitted to the integral: F_5/2 within 0.15 % from 0
#: to 4 standard deviations, and within 1.5 % below and up to MAX_SEPARATION.
EXPONENT_FIT = (0.00043721, -0.00780786, 0.05308344, -0.1640149, -0.31382968, -0.05197362)
#: Nodes and weights of Gauss's rule on (0, 1): of half the arc in which asperities touch.
NODES = tuple((float(0.5 * x + 0.5), float(0.5 * w)) for x, w in zip(*gauss_rule(12), strict=True))


class Ramp(NamedTuple):
    """The dry fraction grows linearly over a width."""

    begin: float  # m, of the depth
    width: float  # m


class GreenwoodTripp(NamedTuple):
    """A linear ramp, before which asperities of both surfaces carry part of the load."""

    begin: float  # m, of the depth
    width: float  # m
    load: float  # N, of F_5/2, integrated over the arc
    roughness: float  # m, standard deviation of both surfaces together
    clearance: float  # m
    mean_height: float  # m, of the asperities of both surfaces together


@kernel
def _ramp_fraction(transition, depth):
    lowest, highest = as_type_of(0.0, depth), as_type_of(1.0, depth)
    return min(max((depth - transition.begin) / transition.width, lowest), highest)


dry_fraction.member(Ramp)(_ramp_fraction)
dry_fraction.member(GreenwoodTripp)(_ramp_fraction)


@kernel
def asperity_integral(x):
    """Return F_5/2(x), the integral of (s - x)^(5/2) over the Gaussian density of s above x.

    g = (x + sqrt(x^2 + 4)) / 2 is 1 / -x far below 0, where F_5/2 is (-x)^(5/2), and x far above.
    """
    root = calculus.sqrt(x * x + 4.0)
    g = 0.5 * (root + x) if x > 0.0 else 2.0 / (root - x)  # the same without cancellation
    exponent = as_type_of(0.0, x)
    for coefficient in EXPONENT_FIT:
        exponent = (exponent + coefficient) * g
    return calculus.exp(exponent) / (g * g * calculus.sqrt(g))


@asperity_load.member(GreenwoodTripp)
def _asperity_load_greenwood_tripp(transition, depth):
    eccentricity = transition.clearance + depth
    contact_height = MAX_SEPARATION * transition.roughness + transition.mean_height
    if depth <= -contact_height:
        return as_type_of(0.0, depth)
    cosine_of_edge = max((transition.clearance - contact_height) / eccentricity, as_type_of(-1.0, depth))
    half_angle = (
        2.0 * calculus.atan(calculus.sqrt((1.0 - cosine_of_edge) / (1.0 + cosine_of_edge)))
        if cosine_of_edge > -1.0
        else as_type_of(math.pi, depth)
    )
    total, mean_gap = as_type_of(0.0, depth), transition.clearance - transition.mean_height
    for node, weight in NODES:
        cosine = calculus.cos(half_angle * node)
        total += weight * asperity_integral((mean_gap - eccentricity * cosine) / transition.roughness) * cosine
    return 2.0 * transition.load * half_angle * total


def transition_depths(transition) -> tuple[float, float]:
    """Return the depths (m) from which dry contact carries part of the load, and all of it."""
    return transition.begin, transition.begin + transition.width


def asperity_depth(transition) -> float:
    """Return the depth (m) from which dry contact or asperities carry load."""
    if isinstance(transition, GreenwoodTripp):
        return -MAX_SEPARATION * transition.roughness - transition.mean_height
    return transition.begin


register(
    Law(
        "transition",
        "ramp",
        "linear transition from film to dry contact over a width",
        "F = (1 - w) F_film + w F_dry, w = min(1, max(0, (e - clearance - from) / width))",
        "after Ravn 1998, Multibody Syst. Dyn. 2:1, and Flores, Ambrosio, Claro & Lankarani 2006, as cited by others",
        notes="The width should be a few times the roughness of the surfaces, 0.5 to 5 um, not a fraction of the "
        "clearance.",
    ),
    (Ramp,),
    lambda joint: Ramp(joint.film.begin, joint.film.width),
)


def _make_greenwood_tripp(joint) -> GreenwoodTripp:
    values, film = joint.film.asperities, joint.film
    modulus = values.get("modulus") or plane_strain_modulus(joint.contact.material)
    factor = 16.0 * math.sqrt(2.0) * math.pi / 15.0 * values["density"] ** 2 * math.sqrt(values["sharpness"])
    load = factor * modulus * joint.bearing_radius * joint.length
    return GreenwoodTripp(
        film.begin, film.width, load, values["roughness"], joint.clearance, values.get("mean_height", 0.0)
    )


register(
    Law(
        "transition",
        "greenwood-tripp",
        "asperities carry part of the load through the film, then as ramp",
        "F = (1 - w) (F_film + F_asperities) + w F_dry, p_asperities = (16 sqrt(2) pi / 15) density^2 sharpness^(1/2) "
        "E* F_5/2((h - mean_height) / roughness) over the arc, F_5/2(x) the integral of (s - x)^(5/2) exp(-s^2 / 2) / "
        "(2 pi)^(1/2) over s > x, 1 / E* = (1 - nu_1^2) / E_1 + (1 - nu_2^2) / E_2",
        "after Greenwood & Tripp 1970, Proc. Instn. Mech. Engrs. 185:625; the factor derived anew from Hertz's law for "
        "a pair of paraboloids",
        (
            Field("roughness", "m", "standard deviation of the combined heights of both surfaces"),
            Field("density", "1", "number of asperities per area, times tip radius, times roughness", default=0.05),
            Field("sharpness", "1", "roughness divided by the tip radius of the asperities", default=0.01),
            Field(
                "mean_height",
                "m",
                "mean height of the asperities of both surfaces above the zero of the film thickness; default: 0",
                low_open=False,
                optional=True,
            ),
            Field("modulus", "Pa", "contact modulus E* of both bodies; default: from contact.material", optional=True),
        ),
        notes="Sources that take E' = 2 E* have half the factor.  F_5/2 is a fit, within 0.15 % from h = 0 to 4 "
        "roughnesses; from 5 on asperities carry nothing.  Their load is elastic, and the joint's friction acts on "
        "it. Their load counts as dry contact.",
    ),
    (GreenwoodTripp,),
    _make_greenwood_tripp,
)
