"""The interface of elastic laws.

A law that folds back or diverges at some penetration is used up to where its tangent stiffness is
twice the secant stiffness, and continued along that tangent: the force always increases and stays finite.
"""

import functools
import math

from ....contracts.catalogue import Range
from ....tracing.compiled.choosing import where
from ....tracing.compiled.dual import as_type_of
from ....tracing.compiled.family import family
from ....tracing.portable import gauss_rule


@family
def elastic_force(elastic, pen):
    """Return the elastic force (N) at penetration `pen` (m, at least 0)."""


@family
def root_parity(elastic):
    """Return -1 if the force at small penetration is an odd power of the root of the penetration, else 1."""


@family
def elastic_energy(elastic, pen):
    """Return the energy (J) stored at penetration `pen` (m, at least 0), the integral of the force over it.

    A law without a closed form need not be a member: the default is Gauss quadrature over the root of penetration,
    in which forces are smooth; its relative error is below 1e-6 for all laws here.
    """


@elastic_energy.member(None)
def _default_elastic_energy(elastic, pen):
    total = 0.0
    for node, weight in NODES:
        total += weight * elastic_force(elastic, pen * (node * node))
    return pen * total


@family
def energy_stiffness(elastic, pen):
    """Return F^2 / (2 W) at penetration `pen`, N/m: the stiffness of a linear spring with this force and energy.

    A law need not be a member: the default follows from force and energy.
    """


@energy_stiffness.member(None)
def _default_energy_stiffness(elastic, pen):
    force, energy = elastic_force(elastic, pen), elastic_energy(elastic, pen)
    return where(energy > 0.0, 0.5 * force * force / where(energy > 0.0, energy, 1.0), as_type_of(0.0, energy))


#: Nodes x of the Gauss-Legendre rule on (0, 1), and weights times 2 x, for an integral over pen x^2.
NODES = tuple((float(0.5 * x + 0.5), float(w * (0.5 * x + 0.5))) for x, w in zip(*gauss_rule(5), strict=True))

FAMILIES = (elastic_force, root_parity)  # every type must be a member of these families


def register_elastic_force(law_type, *, is_odd: bool):
    """Return the decorator that registers the `elastic_force` of a type.

    `is_odd` : whether the force at small penetration is an odd power of the root of the penetration.
    """

    def decorate(function):
        root_parity.member(law_type)(_odd if is_odd else _even)
        return elastic_force.member(law_type)(function)

    return decorate


def _odd(elastic):
    return -1.0


def _even(elastic):
    return 1.0


@functools.lru_cache(maxsize=1024)  # many cases of a sweep share their surfaces and their load
def static_penetration(elastic, load: float) -> float:
    """Return the penetration (m) at which an elastic law carries `load` (N)."""
    low, high = 0.0, 1e-12
    while elastic_force(elastic, high) < load:
        high *= 2.0
    for _ in range(200):  # bisection works for any increasing law, within one unit in the last place
        midpoint = 0.5 * (low + high)
        if midpoint in (low, high):
            break
        low, high = (midpoint, high) if elastic_force(elastic, midpoint) < load else (low, midpoint)
    return high


CYLINDER_NEEDS = ("length", "material")  # of the laws of cylinders
#: Half the contact arc (rad) under the load, by Hertz's line contact: up to about 10 degrees the bodies are
#: approximately half-spaces (Johnson 1985, section 4.2).
_HALF_SPACE_ARC = math.radians(10.0)
SMALL_ARC = Range("arc", 0.0, _HALF_SPACE_ARC, "rad", "it treats the bodies as half-spaces")
WIDE_ARC = Range(
    "arc",
    _HALF_SPACE_ARC,
    0.5 * math.pi,
    "rad",
    "its arc is that of rigid circles, but elastic bodies touch over a smaller one",
)
