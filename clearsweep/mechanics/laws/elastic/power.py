"""The normal force as a power of the penetration."""

from typing import NamedTuple

from ....contracts.catalogue import Field, Law, Range
from ....tracing.compiled import calculus as math
from ...joints.material import material_stiffness
from ...joints.recipe import register
from .contract import elastic_energy, energy_stiffness, register_elastic_force


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
    return elastic.stiffness * pen * math.sqrt(pen)


@elastic_energy.member(PowerThreeHalves)
def _elastic_energy_power_three_halves(elastic, pen):
    return 0.4 * elastic.stiffness * pen * pen * math.sqrt(pen)


@energy_stiffness.member(PowerThreeHalves)
def _energy_stiffness_power_three_halves(elastic, pen):
    return 1.25 * elastic.stiffness * math.sqrt(pen)


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
        (Field("exponent", "1", "exponent n", 1.0, 1.5, False, False, default=1.5),),
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
