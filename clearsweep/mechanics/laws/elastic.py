"""The interface of elastic laws, values from the material of a joint, powers of the penetration, conformal contact.

A law that folds back or diverges at some penetration is used up to where its tangent stiffness is
twice the secant stiffness, and continued along that tangent: the force always increases and stays finite.

In conformal contact journal and bearing have nearly equal radii.  E* is the modulus of the pair,
1 / E* = (1 - nu_b^2) / E_b + (1 - nu_j^2) / E_j, c the radial clearance, L the length of the joint, R_b and R_j the
radii of bearing and journal.
"""

import functools
import math
from typing import Any, NamedTuple

import numpy as np

from ...contracts.case import Joint, Materials
from ...contracts.catalogue import Field, Merit, Range, ranged
from ...language.errors import InputError
from ...tracing import portable
from ...tracing.compiled import calculus
from ...tracing.compiled.choosing import where
from ...tracing.compiled.dual import as_type_of
from ...tracing.compiled.family import family, family_with_default, kernel
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
def force_and_energy(elastic, pen):
    """Return the elastic force (N) and energy (J) at penetration `pen`; a law where they share work is a member."""
    return elastic_force(elastic, pen), elastic_energy(elastic, pen)


@family_with_default
def force_and_stiffness(elastic, pen):
    """Return the elastic force F (N) and F^2 / (2 W), N/m: the stiffness of a linear spring of this force and energy.

    A law need not be a member: the default follows from force and energy.
    """
    force, energy = force_and_energy(elastic, pen)
    stiffness = 0.5 * force * force / where(energy > 0.0, energy, 1.0)
    return force, where(energy > 0.0, stiffness, as_type_of(0.0, energy))


#: Nodes x of the Gauss-Legendre rule on (0, 1), and weights times 2 x, for an integral over pen x^2.
NODES = tuple((float(0.5 * x + 0.5), float(w * (0.5 * x + 0.5))) for x, w in zip(*gauss_rule(5), strict=True))

require("elastic", elastic_force, root_parity)


def register_elastic_force(law_type, *, is_odd: bool):
    """Return the decorator that registers the `elastic_force` of a type.

    `is_odd` : whether the force at small penetration is an odd power of the root of the penetration.
    """

    def decorate(function):
        root_parity.member(law_type)(lambda elastic: -1.0 if is_odd else 1.0)
        return elastic_force.member(law_type)(function)

    return decorate


DEEPEST = 1e9  # m, beyond any penetration: a law that does not carry a load there never does


@functools.lru_cache(maxsize=1024)  # many cases of a sweep share their surfaces and their load
def static_penetration(elastic, load: float) -> float:
    """Return the penetration (m) at which an elastic law carries `load` (N); InputError if it never does."""
    low, high = 0.0, 1e-12
    while elastic_force(elastic, high) < load:
        high *= 2.0
        if high > DEEPEST:
            raise InputError(
                f"joints: a contact law never carries {load:.4g} N at rest; its force must grow with depth"
            )
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


def hardness_factor(poisson: float) -> float:
    """Return K = 0.454 + 0.41 nu: the largest Hertzian pressure over hardness at first yield of a sphere."""
    return 0.454 + 0.41 * poisson


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
    exponent = 1.5


@register_elastic_force(PowerThreeHalves, is_odd=True)
def _power_three_halves(elastic, pen):
    return elastic.stiffness * pen * calculus.sqrt(pen)


elastic_energy.member(PowerThreeHalves)(lambda elastic, pen: 0.4 * elastic.stiffness * pen * pen * calculus.sqrt(pen))


@force_and_stiffness.member(PowerThreeHalves)
def _force_and_stiffness_power_three_halves(elastic, pen):
    return elastic_force(elastic, pen), 1.25 * elastic.stiffness * calculus.sqrt(pen)


class Linear(NamedTuple):
    """F = K pen."""

    stiffness: float  # N/m
    exponent = 1.0


@register_elastic_force(Linear, is_odd=False)
def _linear(elastic, pen):
    return elastic.stiffness * pen


elastic_energy.member(Linear)(lambda elastic, pen: 0.5 * elastic.stiffness * pen * pen)
force_and_stiffness.member(Linear)(lambda elastic, pen: (elastic_force(elastic, pen), elastic.stiffness))


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
    "elastic power: a power of the penetration",
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
    types=POWERS,
    make=lambda joint: power_of(_stiffness_of(joint), joint.contact.values["exponent"]),
    contact="ball",
    trusted=(_BALL,),
    notes="With `material`, K = (4/3) E* sqrt(R_b R_j / (R_b - R_j)): a ball in a socket, whatever the length of the "
    "pin; it grows without bound as the clearance shrinks.  Papers that write h = (1 - nu^2) / (pi E) have a pi in K; "
    "mixing the two conventions is an error of a factor pi.",
    derived=lambda joint: (
        {}
        if "stiffness" in joint.contact.values
        else derived_stiffness(material_stiffness(joint), joint.contact.values["exponent"])
    ),
)


register(
    "elastic lankarani-nikravesh-cylindrical: the sphere's stiffness with another exponent",
    "F_elastic = (4/3) E* sqrt(R_b R_j / (R_b - R_j)) pen^n",
    "after Lankarani & Nikravesh 1994, Nonlinear Dyn. 5:193; as found in multibody codes",
    (ranged("exponent", "1", "exponent n", "[1, 1.5]", default=1.5),),
    types=POWERS,
    make=lambda joint: power_of(material_stiffness(joint), joint.contact.values["exponent"]),
    needs=("material",),
    contact="ball",
    trusted=(_BALL,),
    notes="Dimensionally inconsistent unless n = 1.5: the penetration is in metres.  It does not depend on the length.",
    derived=lambda joint: derived_stiffness(material_stiffness(joint), joint.contact.values["exponent"]),
)


# ---------------------------------------------------------------------------------------------- conformal contact


_CONFORMAL: dict[str, Any] = {"contact": "line", "needs": CYLINDER_NEEDS, "trusted": (WIDE_ARC,)}  # of all laws here
_ARC = "The contact arc is that of rigid circles, cos theta = c / (c + pen)."


class Liu(NamedTuple):
    """F = K pen sqrt(pen / (2 (c + pen)))."""

    stiffness: float  # N/m
    clearance: float  # c, m


@register_elastic_force(Liu, is_odd=True)
def _liu(elastic, pen):
    return elastic.stiffness * pen * calculus.sqrt(0.5 * pen / (elastic.clearance + pen))


def _make_liu(joint):
    return Liu(0.5 * calculus.pi * line_modulus(joint), joint.clearance)


register(
    "elastic liu: two cylinders whose contact arc follows from geometry",
    "F_elastic = (1/2) pi E* L pen sqrt(pen / (2 (c + pen)))",
    "after Liu, Zhang & Yang 2007, Mech. Mach. Theory 42:183",
    types=(Liu,),
    make=_make_liu,
    **_CONFORMAL,
    notes=f"{_ARC}  Softer than the laws of line contact by an order of magnitude at small penetration.",
)


register(
    "elastic bai-zhao-consistent: liu's force, of which Bai & Zhao's stiffness is the derivative",
    "F_elastic = (1/2) pi E* L pen sqrt(pen / (2 (c + pen))), its derivative K_n L",
    "after Bai & Zhao 2012, Int. J. Mech. Sci. 54:190; the integral of their K_n",
    types=(Liu,),
    make=_make_liu,
    **_CONFORMAL,
    notes="Their K_n = (1/8) pi E* sqrt(2 pen (3 c + 2 pen)^2 / (c + pen)^3) is exactly dF/dpen of liu per length, a "
    "tangent stiffness, and this law uses it as such.  With contact.law zhiying-qishao it is their hybrid model.",
)


class LiuTangent(NamedTuple):
    """F = pen^n times the derivative of Liu's force per length."""

    modulus: float  # (1/2) pi E*, Pa
    clearance: float  # m
    exponent: float  # n, 1


@register_elastic_force(LiuTangent, is_odd=False)
def _liu_tangent(elastic, pen):
    clearance_and_pen = elastic.clearance + pen
    factor = (1.5 * elastic.clearance + pen) / clearance_and_pen
    return elastic.modulus * pen**elastic.exponent * factor * calculus.sqrt(0.5 * pen / clearance_and_pen)


register(
    "elastic bai-zhao-literal: Bai & Zhao's stiffness times a power of the penetration, as printed",
    "F_elastic = K_n pen^n, K_n = (1/8) pi E* sqrt(2 pen (3 c + 2 pen)^2 / (c + pen)^3)",
    "after Bai & Zhao 2012, Int. J. Mech. Sci. 54:190; as reported by others, not compared with the paper",
    (ranged("exponent", "1", "exponent n; the published value is 1.5", "[1, 2]", default=1.5),),
    types=(LiuTangent,),
    make=lambda joint: LiuTangent(
        0.5 * calculus.pi * plane_strain_modulus(joint.contact.material),
        joint.clearance,
        joint.contact.values["exponent"],
    ),
    contact="line",
    needs=("material",),
    unsound="dimensionally inconsistent, and independent of the length",
    notes="Dimensionally inconsistent: K_n is in Pa, so the product is a force only for n = 2; all quantities are in "
    "SI units.  It does not depend on the length.  K_n is the tangent stiffness of liu per length, used as a secant "
    "stiffness.  With contact.law zhiying-qishao it is their hybrid model; bai-zhao-consistent is the consistent form.",
)


class Foundation(NamedTuple):
    """F = K ((c + pen) theta - c sin theta), cos theta = c / (c + pen): a bed of radial springs (Winkler)."""

    stiffness: float  # N/m
    clearance: float  # c, m


@kernel
def angle_minus_sine(angle):
    """Return angle - sin(angle) for an angle (rad) of at least 0, without cancellation at small angles."""
    if angle > 1.0:
        return angle - calculus.sin(angle)
    x = angle * angle
    series = 1.0 - x / 156.0 * (1.0 - x / 210.0)
    for divisor in (110.0, 72.0, 42.0, 20.0):
        series = 1.0 - x / divisor * series
    return angle * x / 6.0 * series


@register_elastic_force(Foundation, is_odd=True)
def _foundation(elastic, pen):
    angle = 2.0 * calculus.atan(calculus.sqrt(pen / (2.0 * elastic.clearance + pen)))
    return elastic.stiffness * (pen * angle + elastic.clearance * angle_minus_sine(angle))


def foundation_modulus(joint: Joint) -> float:
    """Return (1 - nu) E / ((1 + nu) (1 - 2 nu) t) in Pa/m, the foundation modulus of a thin bonded layer."""
    layer = joint.contact.material.bearing
    young, poisson = layer.young, layer.poisson
    if poisson >= 0.5:
        raise InputError(
            f"contact.material.poisson: found {poisson:g}; winkler allows below 0.5: its layer would be rigid"
        )
    return (1.0 - poisson) * young / ((1.0 + poisson) * (1.0 - 2.0 * poisson) * joint.contact.values["thickness"])


register(
    "elastic winkler: a layer of radial springs in the bearing",
    "F_elastic = k R_b L ((c + pen) theta - c sin theta), cos theta = c / (c + pen), k = (1 - nu) E / ((1 + nu) (1 - "
    "2 nu) t)",
    "elastic foundation: Johnson 1985, Contact Mechanics, section 4.3; integrated over p = k ((c + pen) cos phi - c)",
    (Field("thickness", "m", "thickness t of the compliant layer"),),
    types=(Foundation,),
    make=lambda joint: Foundation(foundation_modulus(joint) * joint.bearing_radius * joint.length, joint.clearance),
    needs=CYLINDER_NEEDS,
    ranges=(Range("contact.material.bearing.poisson", -1.0, 0.499, "1", "an incompressible layer is rigid"),),
    notes="E and nu of the layer are those of the bearing.  Without a real layer the thickness is a guess.  "
    "Considered valid up to a tenth of the thickness; beyond, the same formula applies.",
    limit=lambda joint: 0.1 * joint.contact.values["thickness"],
    derived=lambda joint: {"contact.foundation_modulus": (foundation_modulus(joint), "Pa/m")},
)


class Conformal(NamedTuple):
    """F = K b^2 (b^2 + 1) / (2 - ln(b^2 + 1) - 2 b^4), b = tan(theta / 2), cos theta = c / (c + pen) (Persson)."""

    stiffness: float  # N
    clearance: float  # c, m


#: Where the tangent of Persson's force is twice the secant, in clearances: a half-angle of 80.41
#: degrees.  The force grows without bound towards 84.83 degrees.
CONFORMAL_END = 5.004202079905


@kernel
def load_ratio(depth_ratio):
    """Return Persson's load in units of 2 pi E* clearance length, at a penetration of `depth_ratio` clearances."""
    b2 = depth_ratio / (2.0 + depth_ratio)
    return b2 * (b2 + 1.0) / (2.0 - calculus.log1p(b2) - 2.0 * b2 * b2)


@register_elastic_force(Conformal, is_odd=False)
def _conformal(elastic, pen):
    depth_ratio = pen / elastic.clearance
    if depth_ratio < CONFORMAL_END:
        return elastic.stiffness * load_ratio(depth_ratio)
    return elastic.stiffness * load_ratio(CONFORMAL_END) * (2.0 * depth_ratio / CONFORMAL_END - 1.0)


#: Squared tangent of half of 84.83 degrees, the half-angle at which Persson's load becomes infinite.
MAX_B2 = 0.8346152454776572


def half_angle_at_load(load: np.ndarray) -> np.ndarray:
    """Return the half-angle (rad) of contact by Persson, for loads in units of E* clearance length."""
    low, high = np.zeros(np.shape(load)), np.full(np.shape(load), MAX_B2)  # of b^2
    for _ in range(60):
        b2 = 0.5 * (low + high)
        is_below = 2.0 * np.pi * b2 * (b2 + 1.0) < load * (2.0 - portable.log1p(b2) - 2.0 * b2 * b2)
        low, high = np.where(is_below, b2, low), np.where(is_below, high, b2)
    return 2.0 * portable.atan(np.sqrt(0.5 * (low + high)))


register(
    "elastic persson: conformal contact over any arc up to its limiting angle",
    "F_elastic = 2 pi E* c L b^2 (b^2 + 1) / (2 - ln(b^2 + 1) - 2 b^4), b = tan(theta / 2), cos theta = c / (c + pen)",
    "after Persson 1964 (thesis, Chalmers) and Ciavarella & Decuzzi 2001, Int. J. Solids Struct. 38:4507, like "
    "materials; the scale from Hertz's limit, the arc over penetration an assumption made here",
    types=(Conformal,),
    make=lambda joint: Conformal(2.0 * calculus.pi * line_modulus(joint) * joint.clearance, joint.clearance),
    **_CONFORMAL,
    notes=f"The load over the half-angle theta is that of the theory, which has no penetration.  {_ARC}  It makes "
    "the force linear at small penetration, (pi/2) E* L pen: 4.4 times johnson's at 1 um and 0.5 mm clearance.  "
    "Elastic bodies touch over a smaller arc than rigid ones; compatible models this.  The half-angle cannot "
    "pass 84.83 degrees; beyond 80.41, where the tangent stiffness is twice the secant, the force continues "
    "along the tangent.",
    merit=Merit(
        4, "its load over the arc follows the theory of conformal contact, but its arc is that of rigid circles"
    ),
    limit=lambda joint: CONFORMAL_END * joint.clearance,
)


FIT_END = 0.5  # clearances: largest penetration of the fit to persson


@functools.cache
def fit_conformal_power() -> tuple[float, float, float]:
    """Return (k, n, residual) of the best-fitting power law k x^n for Persson's load over 0 < x <= FIT_END.

    The load is in units of E* c L, x in clearances; least squares of the relative error, `residual` its rms.
    """
    nodes, weights = portable.gauss_rule(200)
    x = 0.5 * FIT_END * (nodes + 1.0)
    load = 2.0 * calculus.pi * np.array([load_ratio(depth) for depth in x])
    exponent, logarithm = portable.line_through(portable.log(x), portable.log(load), weights)
    error = calculus.exp(logarithm) * portable.power(x, exponent) / load - 1.0
    return calculus.exp(logarithm), exponent, calculus.sqrt(calculus.fsum(weights * error**2) / calculus.fsum(weights))


def _make_fit(joint):
    factor, exponent, _ = fit_conformal_power()
    return Power(factor * line_modulus(joint) * joint.clearance ** (1.0 - exponent), exponent)


register(
    "elastic conformal-fit: a power law fitted to persson",
    "F_elastic = K_f pen^n_f, K_f = k E* L c^(1 - n_f); k and n_f by least squares of the relative error for pen up "
    "to c / 2",
    "in the manner of 'A continuous contact force model for planar revolute joint based on fitting method' 2017, Adv. "
    "Mech. Eng. 9(2); the coefficients are fitted here, not the paper's",
    types=(Power,),
    make=_make_fit,
    **_CONFORMAL,
    notes="Has the rigid contact arc of persson, and is therefore 4.4 times as stiff as johnson at 1 um and 0.5 mm "
    "clearance; compatible-fit is fitted to an elastic arc.  Continues as a power law beyond c / 2.  contact.law "
    "exact gives the loss that energy conservation requires.",
    limit=lambda joint: FIT_END * joint.clearance,
    derived=lambda joint: derived_power(_make_fit(joint)) | {"contact.fit_residual": (fit_conformal_power()[2], "1")},
)
