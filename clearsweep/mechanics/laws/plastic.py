"""Plastic contacts: they unload to a permanent indentation, which they keep until separation."""

from typing import NamedTuple

from ...contracts.catalogue import Field, Law, ranged
from ...tracing.compiled import calculus as math
from ...tracing.compiled.dual import as_type_of
from ...tracing.compiled.family import kernel
from .contract import (
    NEVER,
    TOUCHING,
    Guard,
    depth_variable,
    distances_past_kinks,
    guard_values,
    guards,
    kink_variable,
    kinks,
    latched,
    register,
)
from .elastic import elastic_force, plane_strain_modulus, relative_radius
from .loss import RESTITUTION, always_needs_onset_rate, needs_onset_rate, register_contact_force

MIN_DEPTH = 1e-12  # m, least recorded depth of a yielding contact
RELOAD_FACTOR = 1.0 + 1e-12  # times the root of the deepest penetration: keeps rounding from reaching it again
UNLOADING, RELOADING = 0, 1  # guards: unloading begins; reloading reaches the deepest point


class Plastic(NamedTuple):
    """F = F_elastic(pen) during loading, then along the same curve compressed towards the deepest point.

    Unloading and reloading: F = F_elastic((pen - residual) / e^2), where residual = (1 - e^2) deepest is the permanent
    indentation.  The fraction e^2 of the work of loading is returned.
    """

    returned_fraction: float  # e^2, 1
    yield_rate: float  # m/s, onset rate up to which the contact is elastic
    deepest: float = 0.0  # m, deepest penetration of the last loading; 0 during loading


@register_contact_force(Plastic, pulls=False, times_elastic=True)
def _plastic(law, elastic, pen, rate, onset_rate):
    fraction = law.returned_fraction if onset_rate > law.yield_rate else 1.0
    if law.deepest < MIN_DEPTH:
        force = elastic_force(elastic, pen)
        return force, fraction * force
    recovered = (pen - (1.0 - fraction) * law.deepest) / fraction
    force = math.copysign(elastic_force(elastic, abs(recovered)), recovered)  # negative if the indentation is clear
    return force, max(force, 0.0)


needs_onset_rate.member(Plastic)(always_needs_onset_rate)


class YieldingSphere(NamedTuple):
    """F = F_hertz(pen), softened beyond the yield depth; unloading by the fit of Etsion, Kligerman & Kadin.

    Unloading and reloading: F = F_m ((pen - residual) / (deepest - residual))^n, where residual is the permanent
    indentation and F_m the force at the deepest point; see `unloading_fit`.
    """

    yield_depth: float  # w_c, m
    plastic_factor: float  # 3 / K: the force on a fully plastic contact over pen / w_c, in forces at the yield depth
    deepest: float = 0.0  # m, deepest penetration of the last loading; 0 during loading


#: Factor and power of the published fits of the force over Hertz's.
FIRST_FIT, SECOND_FIT = (1.03, -0.075), (1.40, -0.237)
#: Yield depths from which on the fits are used, and one follows the other.
FIRST_FIT_BEGIN = FIRST_FIT[0] ** (-1.0 / FIRST_FIT[1])
SECOND_FIT_BEGIN = (SECOND_FIT[0] / FIRST_FIT[0]) ** (1.0 / (FIRST_FIT[1] - SECOND_FIT[1]))
#: Powers of the deepest point in the published fits of the residual indentation and of the exponent of unloading.
RESIDUAL_POWERS, UNLOADING_POWER = (-0.28, -0.69), -0.0331
SMALLEST_SHARE = 1e-30  # of the recovered depth: keeps a negative power of it finite


@kernel
def force_ratio(law, x):
    """Return the force over Hertz's at `x` >= 1 yield depths, and its exponent in `x`: the least published fit."""
    ratio, power = FIRST_FIT[0] * x ** FIRST_FIT[1], FIRST_FIT[1]
    second_ratio = SECOND_FIT[0] * x ** SECOND_FIT[1]
    if second_ratio < ratio:
        ratio, power = second_ratio, SECOND_FIT[1]
    plastic_ratio = law.plastic_factor * x**-0.5
    if plastic_ratio < ratio:
        ratio, power = plastic_ratio, -0.5
    if ratio > 1.0:
        ratio, power = 1.0, 0.0
    return ratio, power


class Unloading(NamedTuple):
    """The published fit of the unloading from a depth."""

    recovered: float  # share of the depth that unloading recovers
    exponent: float  # of the force over the recovered depth
    energy_slope: float  # derivative of the returned energy by the depth, over the force


@kernel
def unloading_fit(x, force_power):
    """Return the Unloading from `x` >= 1 yield depths, where the force of loading varies as pen^force_power.

    residual / deepest = (1 - x^-0.28) (1 - x^-0.69), n = 1.5 x^-0.0331; the returned energy is F pen recovered / (n +
    1).
    """
    first, second = x ** RESIDUAL_POWERS[0], x ** RESIDUAL_POWERS[1]
    recovered, exponent = first + second - first * second, 1.5 * x**UNLOADING_POWER
    recovered_slope = (
        RESIDUAL_POWERS[0] * first
        + RESIDUAL_POWERS[1] * second
        - (RESIDUAL_POWERS[0] + RESIDUAL_POWERS[1]) * (first * second)
    )  # times x, as the next line
    exponent_slope = UNLOADING_POWER * exponent
    if x <= 1.0:
        exponent_slope = 0.0 * exponent
    share = recovered / (exponent + 1.0)
    share_slope = (recovered_slope - share * exponent_slope) / (exponent + 1.0)
    return Unloading(recovered, exponent, (force_power + 1.0) * share + share_slope)


@register_contact_force(YieldingSphere, pulls=False, times_elastic=True)
def _yielding_sphere(law, elastic, pen, rate, onset_rate):
    is_loading = law.deepest < MIN_DEPTH
    deepest_now = pen if is_loading else as_type_of(law.deepest, pen)
    x = max(deepest_now / law.yield_depth, 1.0)
    force_factor, power_change = force_ratio(law, x)
    unloading = unloading_fit(x, 1.5 + power_change)
    if is_loading:
        force = force_factor * elastic_force(elastic, pen)
        return force, unloading.energy_slope * force
    share = 1.0 + (pen / deepest_now - 1.0) / unloading.recovered  # of the recovered depth
    # of Hertz's exponent; by exp and log, as the exponent has a derivative, too
    change = math.exp((unloading.exponent - 1.5) * math.log(max(abs(share), SMALLEST_SHARE)))
    force = force_factor * change * elastic_force(elastic, deepest_now * abs(share))
    force = math.copysign(force, share)  # negative if the indentation is clear
    return force, max(force, 0.0)


@kinks.member(YieldingSphere)
def _kinks_yielding_sphere(law):
    plastic_ratio = (law.plastic_factor / SECOND_FIT[0]) ** (1.0 / (0.5 + SECOND_FIT[1]))
    depth_ratios = 1.0, FIRST_FIT_BEGIN, SECOND_FIT_BEGIN, plastic_ratio
    return tuple([law.yield_depth * depth_ratio for depth_ratio in depth_ratios])


kink_variable.member(YieldingSphere)(depth_variable)


@guards.member(YieldingSphere)
def _guards_yielding_sphere(law):
    return (*_guards_plastic(law), Guard(TOUCHING))


@guard_values.member(YieldingSphere)
def _guard_values_yielding_sphere(law, start, contact, root):
    if law.deepest == 0.0:
        distance_past_kink, _ = distances_past_kinks(kinks(law), start.contact.depth, contact.depth)
        return -contact.rate, NEVER, distance_past_kink
    return NEVER, root - RELOAD_FACTOR * math.sqrt(law.deepest), NEVER


@guards.member(Plastic)
def _guards_plastic(law):
    return Guard(TOUCHING), Guard(TOUCHING)


@guard_values.member(Plastic)
def _guard_values_plastic(law, start, contact, root):
    if law.deepest == 0.0:
        return -contact.rate, NEVER
    return NEVER, root - RELOAD_FACTOR * math.sqrt(law.deepest)


@latched.member(YieldingSphere)
@latched.member(Plastic)
def _latched_yielding_sphere_or_plastic(law, event, contact, root):
    if event == UNLOADING:
        return (max(root * root, MIN_DEPTH),)
    return (0.0,)


register(
    Law(
        "law",
        "lankarani-nikravesh-plastic",
        "yields during loading, unloads elastically from an indentation",
        "F = F_elastic(pen) while pen deepens; below the deepest, pen_m, where it last turned back: "
        "F = F_elastic((pen - pen_p) / e^2), pen_p = (1 - e^2) pen_m, 0 below pen_p; for a power n that is "
        "F = F_m ((pen - pen_p) / (pen_m - pen_p))^n, F_m = K pen_m^n",
        "after Lankarani & Nikravesh 1994, Nonlinear Dyn. 5:193; pen_p such that a free impact loses (1 - e^2) m v0^2 "
        "/ 2",
        (
            RESTITUTION,
            ranged("yield_rate", "m/s", "onset rate up to which the contact is elastic", "[0, inf)", default=0.0),
        ),
        notes="For impacts that leave the elastic range.  Left out, yield_rate is 0: every contact yields.  With a "
        "law that does not yield, the column J_yield_speed of the joint is the speed of first yield.  At separation "
        "(pen < 0) pen_m is reset, so the next contact meets a fresh surface.  A journal that moves along the wall "
        "within one contact carries its indentation along.  There pen < pen_p counts as contact without force, each "
        "entry into it as a clip.  A contact that stays shakes down to an elastic one.",
        yields=True,
    ),
    (Plastic,),
    lambda joint: Plastic(joint.contact.values["restitution"] ** 2, joint.contact.values["yield_rate"]),
    free_restitution=lambda e: e,
)


def _hardness_factor(joint):
    """Return K = 0.454 + 0.41 nu, the largest Hertzian pressure over hardness at first yield."""
    return 0.454 + 0.41 * joint.contact.material.bearing.poisson


def yield_depth(joint) -> float:
    """Return the penetration (m) at first yield of a ball in a socket: (pi K H / (2 E*))^2 R."""
    pressure = math.pi * _hardness_factor(joint) * joint.contact.values["hardness"]
    return (pressure / (2.0 * plane_strain_modulus(joint.contact.material))) ** 2 * relative_radius(joint)


register(
    Law(
        "law",
        "kogut-etsion",
        "a ball in a socket that yields as a finite-element model of a sphere, from a hardness",
        "F = F_elastic least(1, 1.03 x^-0.075, 1.40 x^-0.237, (3 / K) x^-0.5) while pen deepens, x = max(1, pen / "
        "w_c), w_c = (pi K H / (2 E*))^2 R, K = 0.454 + 0.41 nu, R = R_b R_j / (R_b - R_j); below the deepest, pen_m, "
        "where it last turned back: F = F_m ((pen - pen_p) / (pen_m - pen_p))^n, n = 1.5 x_m^-0.0331, 0 below pen_p = "
        "pen_m (1 - x_m^-0.28) (1 - x_m^-0.69)",
        "after Kogut & Etsion 2002, J. Appl. Mech. 69:657 (loading; coefficients as in public programs that quote it) "
        "and Etsion, Kligerman & Kadin 2005, Int. J. Solids Struct. 42:3716 (unloading; coefficients remembered)",
        (Field("hardness", "Pa", "hardness H of the softer body"),),
        needs=("material", "hertz"),
        notes="The restitution decreases with speed: no energy is lost up to w_c.  Three pieces are published, F "
        "/ F_elastic = 1.03 x^-0.075 for x = 1 to 6, 1.40 x^-0.237 to 110 and full plasticity, 2 pi R pen H, beyond.  "
        "They do not meet; here the least of them and Hertz's force acts, which is continuous: at most 3 % below the "
        "first piece, up to x = 1.48, 2 % below the second, up to 6.7, and 8 % below the third, up to some 150 (nu = "
        "0.3).  A Hertzian contact of the flattened radius would return more energy: restitutions up to 0.04 higher.  "
        "Made for a sphere and a rigid flat; nu is the bearing's.  In a close-fitting socket "
        "R and therefore w_c are large: where the derived contact.yield_depth passes the clearance nothing yields.  "
        "At separation pen_m is reset, so the next contact meets a fresh surface.  Within a contact pen < pen_p "
        "counts as contact without force, each entry into it as a clip.",
        yields=True,
    ),
    (YieldingSphere,),
    lambda joint: YieldingSphere(yield_depth(joint), 3.0 / _hardness_factor(joint)),
    derived=lambda joint: {"contact.yield_depth": (yield_depth(joint), "m")},
)
