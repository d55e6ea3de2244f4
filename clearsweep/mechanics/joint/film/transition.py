"""How a film gives way to the dry contact behind it."""

import math
from typing import NamedTuple

import numpy as np

from ....contracts.catalogue import Field, Law
from ...compiled import calculus
from ...compiled.dual import as_type_of
from ...compiled.family import kernel
from ..material import plane_strain_modulus
from ..recipe import enter
from .contract import asperity_load, dry_share

HIGHEST = 4.0  # standard deviations: asperities are no higher
FIT, EXPONENT = 4.4086e-5, 6.804  # of F_5/2, the load that asperities of Gaussian heights share
#: Nodes and weights of Gauss's rule on (0, 1): of half the arc in which asperities touch.
NODES = tuple((float(0.5 * x + 0.5), float(0.5 * w)) for x, w in zip(*np.polynomial.legendre.leggauss(12), strict=True))


class Ramp(NamedTuple):
    """The share grows evenly over a width."""

    begin: float  # m, of the depth
    width: float  # m


class GreenwoodTripp(NamedTuple):
    """The same, and before it asperities of both surfaces bear a part of the load."""

    begin: float  # m, of the depth
    width: float  # m
    load: float  # N, of (4 - thickness / roughness)^6.804, integrated over the arc
    roughness: float  # m, standard deviation of both surfaces together
    clearance: float  # m


@kernel
def _even(transition, depth):
    none, all_of_it = as_type_of(0.0, depth), as_type_of(1.0, depth)
    return min(max((depth - transition.begin) / transition.width, none), all_of_it)


dry_share.member(Ramp)(_even)
dry_share.member(GreenwoodTripp)(_even)


@asperity_load.member(GreenwoodTripp)
def _greenwood_tripp(transition, depth):
    eccentricity = transition.clearance + depth
    highest = HIGHEST * transition.roughness
    if depth <= -highest:
        return as_type_of(0.0, depth)
    edge = max((transition.clearance - highest) / eccentricity, as_type_of(-1.0, depth))
    reach = (
        2.0 * calculus.atan(calculus.sqrt((1.0 - edge) / (1.0 + edge))) if edge > -1.0 else as_type_of(math.pi, depth)
    )
    total = as_type_of(0.0, depth)
    for node, weight in NODES:
        cosine = calculus.cos(reach * node)
        near = HIGHEST - (transition.clearance - eccentricity * cosine) / transition.roughness
        total += weight * max(near, as_type_of(0.0, depth)) ** EXPONENT * cosine
    return 2.0 * transition.load * reach * total


def bounds(transition) -> tuple[float, float]:
    """Return the depths (m) at which the dry contact begins to bear, and from which it bears alone."""
    return transition.begin, transition.begin + transition.width


def bears_from(transition) -> float:
    """Return the depth (m) from which anything but the film bears."""
    return -HIGHEST * transition.roughness if isinstance(transition, GreenwoodTripp) else transition.begin


enter(
    Law(
        "transition",
        "ramp",
        "from film to dry contact evenly over a width",
        "F = (1 - w) F_film + w F_dry, w = min(1, max(0, (e - clearance - from) / width))",
        "after Ravn 1998, Multibody Syst. Dyn. 2:1, and Flores, Ambrosio, Claro & Lankarani 2006, as told by others",
        notes="The width is to be a few times the surfaces' roughness, 0.5 to 5 um, not a share of the clearance.",
    ),
    (Ramp,),
    lambda joint: Ramp(joint.film.begin, joint.film.width),
)


def _greenwood(joint) -> GreenwoodTripp:
    values, film = joint.film.asperities, joint.film
    modulus = values.get("modulus") or 2.0 * plane_strain_modulus(joint.contact.material)
    factor = 16.0 * math.sqrt(2.0) * math.pi / 15.0 * values["density"] ** 2 * math.sqrt(values["sharpness"])
    load = factor * modulus * FIT * joint.bearing_radius * joint.length
    return GreenwoodTripp(film.begin, film.width, load, values["roughness"], joint.clearance)


enter(
    Law(
        "transition",
        "greenwood-tripp",
        "asperities bear a part of the load through the film, then as ramp",
        "F = (1 - w) (F_film + F_asperities) + w F_dry, p_asperities = (16 sqrt(2) pi / 15) density^2 sharpness^(1/2) "
        "E' F_5/2(h / roughness) over the arc, F_5/2(x) = 4.4086e-5 (4 - x)^6.804 below 4",
        "after Greenwood & Tripp 1970, Proc. Instn. Mech. Engrs. 185:625, as told by others; the fit of F_5/2 as in "
        "engine bearing programs",
        (
            Field("roughness", "m", "standard deviation of the heights of both surfaces together"),
            Field("density", "1", "asperities per area times radius of their tips times roughness", default=0.05),
            Field("sharpness", "1", "roughness over radius of the tips", default=0.01),
            Field("modulus", "Pa", "E' = 2 E*; follows from contact.material where that is given", optional=True),
        ),
        notes="At h = 0 the fit of F_5/2 gives 0.55 where the integral is 0.617.  The load of the asperities is "
        "elastic, and the joint's friction acts on it.  What they bear counts as dry.",
    ),
    (GreenwoodTripp,),
    _greenwood,
)
