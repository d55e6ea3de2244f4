"""The interface of elastic laws, values from the material of a joint, and laws that are a power of the penetration.

A law that folds back or diverges at some penetration is used up to where its tangent stiffness is
twice the secant stiffness, and continued along that tangent: the force always increases and stays finite.
"""

import functools
import math
from typing import NamedTuple

from ...contracts.case import Joint, Materials
from ...contracts.catalogue import Field, Law, Range, ranged
from ...tracing.compiled import calculus
from ...tracing.compiled.choosing import where
from ...tracing.compiled.dual import as_type_of
from ...tracing.compiled.family import family, family_with_default
from ...tracing.portable import gauss_rule
from .contract import register, require


@family
def elastic_force(elastic, pen):
    """Return the elastic force (N) at penetration `pen` (m, at least 0)."""


@family
def root_parity(elastic):
    """Return -1 if the force at small penetration is an odd power of the root of the penetration, else 1."""


@family_with_default
def elastic_energy(elastic, pen):
    """Return the energy (J) stored at penetration `pen` (m, at least 0), the integral of the force over it.

    A law without a closed form need not be a member: the default is Gauss quadrature over the root of penetration,
    in which forces are smooth; its relative error is below 1e-6 for all laws here.
    """
    total = 0.0
    for node, weight in NODES:
        total += weight * elastic_force(elastic, pen * (node * node))
    return pen * total


@family_with_default
def energy_stiffness(elastic, pen):
    """Return F^2 / (2 W) at penetration `pen`, N/m: the stiffness of a linear spring with this force and energy.

    A law need not be a member: the default follows from force and energy.
    """
    force, energy = elastic_force(elastic, pen), elastic_energy(elastic, pen)
    return where(energy > 0.0, 0.5 * force * force / where(energy > 0.0, energy, 1.0), as_type_of(0.0, energy))


#: Nodes x of the Gauss-Legendre rule on (0, 1), and weights times 2 x, for an integral over pen x^2.
NODES = tuple((float(0.5 * x + 0.5), float(w * (0.5 * x + 0.5))) for x, w in zip(*gauss_rule(5), strict=True))

require("elastic", elastic_force, root_parity)


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


# ---------------------------------------------------------------------------------------------- material


def plane_strain_modulus(material: Materials) -> float:
    """Return E* (Pa) of two bodies: 1/E* = (1 - nu_b^2) / E_b + (1 - nu_j^2) / E_j (Johnson 1985, 4.24)."""
    bearing, journal = material
    if bearing == journal:  # same bits as for one common material
        return bearing.young / (2.0 * (1.0 - bearing.poisson**2))
    return 1.0 / ((1.0 - bearing.poisson**2) / bearing.young + (1.0 - journal.poisson**2) / journal.young)


def relative_radius(joint: Joint) -> float:
    """Return R_b R_j / (R_b - R_j) in m."""
    bearing = joint.bearing_radius
    return bearing * (bearing - joint.clearance) / joint.clearance


def material_stiffness(joint: Joint) -> float:
    """Return (4/3) E* sqrt(R) in N/m^1.5, the sphere-in-socket stiffness of a joint from its material and radii.

    Flores, Ambrosio, Claro & Lankarani 2008, Kinematics and Dynamics of Multibody Systems with Imperfect Joints, (3.4).
    """
    return 4.0 / 3.0 * plane_strain_modulus(joint.contact.material) * math.sqrt(relative_radius(joint))


def line_modulus(joint: Joint) -> float:
    """Return E* times the length of the joint, N/m."""
    return plane_strain_modulus(joint.contact.material) * joint.length


# ---------------------------------------------------------------------------------------------- powers


class Power(NamedTuple):
    """F = K pen^n."""

    stiffness: float  # N m^-n
    exponent: float  # 1


@register_elastic_force(Power, is_odd=False)
def _power(elastic, pen):
    return elastic.stiffness * pen**elastic.exponent


@elastic_energy.member(Power)
def _elastic_energy_power(elastic, pen):
    return elastic.stiffness * pen * pen**elastic.exponent / (elastic.exponent + 1.0)


class PowerThreeHalves(NamedTuple):
    """F = K pen^(3/2), Hertz's exponent: a square root instead of a general power."""

    stiffness: float  # N m^-1.5


@register_elastic_force(PowerThreeHalves, is_odd=True)
def _power_three_halves(elastic, pen):
    return elastic.stiffness * pen * calculus.sqrt(pen)


@elastic_energy.member(PowerThreeHalves)
def _elastic_energy_power_three_halves(elastic, pen):
    return 0.4 * elastic.stiffness * pen * pen * calculus.sqrt(pen)


@energy_stiffness.member(PowerThreeHalves)
def _energy_stiffness_power_three_halves(elastic, pen):
    return 1.25 * elastic.stiffness * calculus.sqrt(pen)


class Linear(NamedTuple):
    """F = K pen."""

    stiffness: float  # N/m


@register_elastic_force(Linear, is_odd=False)
def _linear(elastic, pen):
    return elastic.stiffness * pen


@elastic_energy.member(Linear)
def _elastic_energy_linear(elastic, pen):
    return 0.5 * elastic.stiffness * pen * pen


@energy_stiffness.member(Linear)
def _energy_stiffness_linear(elastic, pen):
    return elastic.stiffness


POWERS = (Power, PowerThreeHalves, Linear)


def power_of(stiffness: float, exponent: float):
    """Return the cheapest form of K pen^n."""
    if exponent == 1.5:
        return PowerThreeHalves(stiffness)
    return Linear(stiffness) if exponent == 1.0 else Power(stiffness, exponent)


def derived_stiffness(stiffness: float, exponent: float) -> dict:
    """Return the stiffness (N m^-exponent) as a derived value: path -> (value, unit)."""
    unit = f"N/m^{exponent:.6g}" if exponent != 1.0 else "N/m"
    return {"contact.stiffness": (stiffness, unit)}


def derived_power(term: Power) -> dict:
    """Return stiffness and exponent as derived values: path -> (value, unit)."""
    return derived_stiffness(term.stiffness, term.exponent) | {"contact.exponent": (term.exponent, "1")}


def _stiffness_of(joint):
    stiffness = joint.contact.values.get("stiffness")
    return material_stiffness(joint) if stiffness is None else stiffness


_BALL = Range("length", 0.0, 0.0, "m", "the stiffness from `material` is that of a ball in a socket, for any length")

register(
    Law(
        "elastic",
        "power",
        "a power of the penetration",
        "F_elastic = K pen^n",
        "Hertz 1881 for n = 1.5",
        (
            Field(
                "stiffness",
                "N/m^exponent",
                "stiffness K; if `material` is given instead and n = 1.5, K follows from it",
            ),
            Field("exponent", "1", "exponent n", default=1.5),
        ),
        contact="ball",
        trusted=(_BALL,),
        notes="With `material`, K = (4/3) E* sqrt(R_b R_j / (R_b - R_j)): a ball in a socket, whatever the length of "
        "the pin; it grows without bound as the clearance shrinks.  Papers that write h = (1 - nu^2) / (pi E) have a "
        "pi in K; mixing the two conventions is an error of a factor pi.",
    ),
    POWERS,
    lambda joint: power_of(_stiffness_of(joint), joint.contact.values["exponent"]),
    derived=lambda joint: (
        {}
        if "stiffness" in joint.contact.values
        else derived_stiffness(material_stiffness(joint), joint.contact.values["exponent"])
    ),
)


register(
    Law(
        "elastic",
        "lankarani-nikravesh-cylindrical",
        "the sphere's stiffness with another exponent",
        "F_elastic = (4/3) E* sqrt(R_b R_j / (R_b - R_j)) pen^n",
        "after Lankarani & Nikravesh 1994, Nonlinear Dyn. 5:193; as found in multibody codes",
        (ranged("exponent", "1", "exponent n", "[1, 1.5]", default=1.5),),
        needs=("material",),
        contact="ball",
        trusted=(_BALL,),
        notes="Dimensionally inconsistent unless n = 1.5: the penetration is in metres.  It does not depend on the "
        "length.",
    ),
    POWERS,
    lambda joint: power_of(material_stiffness(joint), joint.contact.values["exponent"]),
    derived=lambda joint: derived_stiffness(material_stiffness(joint), joint.contact.values["exponent"]),
)
