"""The interface of film laws, the shear of a film, and its transition to dry contact.

A film's force is given in the frame of the line of centres: `radial` along the journal's eccentricity, `tangential`
along the direction turned by +90 degrees, both on the journal.  It depends on the eccentricity ratio, its rate and the
effective spin: the spins of journal and bearing minus twice that of the line of centres, all inertial.  So the force is
independent of a rigid rotation of journal and bearing.

The power dissipated by the pressure is P = -F_r eps' c + e F_t w / 2; a law should not make it
negative in any motion.

All films have corners at some depths, at which steps end.  Laws that treat a closing and an opening film, or both
directions of rotation, by different formulas also have corners where the rate or the spin changes its sign: they are
members of `has_reversal_corners`.

The pressure alone exerts a moment: the force on the journal acts along a line through the bearing's centre only if
its tangential part is 0.  A film has no inertia, so its couples on both bodies and the moment e F_t of its force
add up to 0.  Split equally, M_j = -C - e F_t / 2 and M_b = C - e F_t / 2, only C is left to a law.
"""

from typing import NamedTuple

from ...contracts.catalogue import Field, ranged
from ...tracing.compiled import calculus as math
from ...tracing.compiled.dual import as_type_of
from ...tracing.compiled.family import family, family_with_default, kernel
from ...tracing.portable import gauss_rule
from .contract import ACTS, MEETS, NEVER, TOUCHING, Guard, distances_past_kinks, guard_values, guards, register, require
from .elastic import plane_strain_modulus


class FilmMotion(NamedTuple):
    """Motion of the journal in the film."""

    ratio: float  # eccentricity over clearance, below 1
    squeeze_rate: float  # 1/s, its rate
    spin: float  # rad/s, effective: of journal and bearing minus twice that of the line of centres
    eccentricity: float = 0.0  # m, ratio times clearance
    rate: float = 0.0  # m/s, squeeze rate times clearance


class FilmArc(NamedTuple):
    """The half of the circumference in which a half film has pressure.

    Angles are measured from the thickest film, opposite to the line of centres.
    """

    cosine: float  # of the angle where it begins
    sine: float
    end_product: float  # product of the film thickness, over the clearance, at both ends
    one_minus_square: float  # 1 - ratio^2
    inverse_thickness: float  # rad, integral of 1 / thickness over the arc, thickness in clearances


@family
def film_force(law, motion):
    """Return the (radial, tangential) force (N) of a film on the journal for a FilmMotion."""


@family_with_default
def film_pressure(law, motion):
    """Return the largest pressure (Pa) in the film; laws without a pressure need not be members."""
    return 0.0


@family
def shear_couple(shear, motion, rotation):
    """Return the couple C (N m) with which film shear brakes the journal and drives the bearing.

    rotation : rad/s, spin of the journal minus that of the bearing.
    """


@family_with_default
def film_couples(shear, motion, rotation, moment):
    """Return the couples (N m) of a film on journal and bearing; shear laws need not be members.

    moment : N m, of the tangential force about the bearing's centre; it and the couples add up to 0.
    """
    couple = shear_couple(shear, motion, rotation)
    return -couple - 0.5 * moment, couple - 0.5 * moment


@family
def dry_fraction(transition, depth):
    """Return the fraction of the dry force, 0 to 1, if the eccentricity exceeds the clearance by `depth` (m)."""


@family_with_default
def asperity_load(transition, depth):
    """Return the load (N) carried by asperities through the film; 0 by default."""
    return as_type_of(0.0, depth)


require("film", film_force)
require("film-friction", shear_couple)
require("transition", dry_fraction)


@kernel
def arc_from(ratio, sine, cosine):
    """Return the Arc that begins where sine and cosine have the given ratio; one of them must not be 0."""
    norm = math.sqrt(sine * sine + cosine * cosine)
    sine, cosine = sine / norm, cosine / norm
    one_minus_square = 1.0 - ratio * ratio
    root = math.sqrt(one_minus_square)
    inverse_thickness = (math.pi + 2.0 * math.atan(ratio * sine / root)) / root
    return FilmArc(cosine, sine, 1.0 - (ratio * cosine) ** 2, one_minus_square, inverse_thickness)


# ---------------------------------------------------------------------------------------------- corners


AFLOAT = ACTS | MEETS  # apart: the film carries load, an onset is searched for
MARGIN = 1e-9  # of the clearance: a step that begins this close to a corner has just passed it


class Corners(NamedTuple):
    """The part of a joint with a film that ends steps at corners of the film's force."""

    clamped: float  # m, depth beyond which the film's formula is kept constant
    begin: float  # m, depth from which the dry contact carries load; inf: never
    end: float  # m, depth from which only the dry contact carries load; inf: never
    margin: float  # m


guards.member(Corners)(lambda corners: (Guard((ACTS, AFLOAT)),) * 2 + (Guard(TOUCHING),) * 4)


@guard_values.member(Corners)
def _guard_values_corners(corners, start, contact, root):
    depth_before, depth_now, margin = start.contact.depth, contact.depth, corners.margin
    return (
        depth_now - corners.clamped if depth_before < corners.clamped - margin else NEVER,
        corners.clamped - depth_now if depth_before > corners.clamped + margin else NEVER,
        depth_now - corners.begin if depth_before < corners.begin - margin else NEVER,
        corners.begin - depth_now if depth_before > corners.begin + margin else NEVER,
        depth_now - corners.end if depth_before < corners.end - margin else NEVER,
        corners.end - depth_now if depth_before > corners.end + margin else NEVER,
    )


@family
def has_reversal_corners(law):
    """Declare that a film's force has corners where the rate of the eccentricity or the spin changes its sign."""


class Reversals(NamedTuple):
    """The part of a joint with such a film that ends steps where the rate or the spin changes its sign."""

    end: float  # m, depth from which only the dry contact carries load; inf: never


guards.member(Reversals)(lambda reversals: (Guard((ACTS, AFLOAT, *TOUCHING)),) * 4)


@guard_values.member(Reversals)
def _guard_values_reversals(reversals, start, contact, root):
    above_zero_rate, below_zero_rate = distances_past_kinks((0.0,), start.contact.rate, contact.rate)
    above_zero_spin, below_zero_spin = distances_past_kinks(
        (0.0,), start.contact.guard_quantity, contact.guard_quantity
    )
    if start.contact.depth < reversals.end:
        return above_zero_rate, below_zero_rate, above_zero_spin, below_zero_spin
    return NEVER, NEVER, NEVER, NEVER


# ---------------------------------------------------------------------------------------------- shear


BALANCED = "M_j = -C - e F_t / 2, M_b = C - e F_t / 2, C = "
DEFAULT_SHEAR_LAW = "butenschoen"  # the meaning of `film.friction: by-law`


class Unsheared(NamedTuple):
    """No couple."""


shear_couple.member(Unsheared)(lambda shear, motion, rotation: as_type_of(0.0, motion.ratio))


@film_couples.member(Unsheared)
def _film_couples_unsheared(shear, motion, rotation, moment):
    zero = as_type_of(0.0, moment)
    return zero, zero


register(
    "film-friction none: no shear torque: the film's force acts through the centres",
    "M_j = M_b = 0",
    "a convention of multibody papers",
    types=(Unsheared,),
    notes="The moment e F_t of the force is not balanced.  So film_loss depends on how fast both bodies turn together "
    "and may be below 0.  For comparison with trajectories computed in this way.",
)


class Petroff(NamedTuple):
    """C = drag (w_j - w_b)."""

    drag: float  # 2 pi mu R^3 L / c, N m s


shear_couple.member(Petroff)(lambda shear, motion, rotation: as_type_of(shear.drag * rotation, motion.ratio))


def petroff_drag(joint) -> float:
    """Return 2 pi mu R^3 L / c of a joint with a film, N m s."""
    return 2.0 * math.pi * joint.film.viscosity * joint.bearing_radius**3 * joint.length / joint.clearance


register(
    "film-friction petroff: shear as in a concentric bearing",
    BALANCED + "2 pi mu R^3 L (w_j - w_b) / c",
    "Petroff 1883 for C; the balance of moments for the rest",
    types=(Petroff,),
    make=lambda joint: Petroff(petroff_drag(joint)),
    notes="C does not depend on the eccentricity: it is the smallest drag of a full film.",
)


class Couette(NamedTuple):
    """C = drag (w_j - w_b) / sqrt(1 - eps^2), the integral of the surfaces' shear over a filled gap."""

    drag: float  # 2 pi mu R^3 L / c, N m s


@shear_couple.member(Couette)
def _shear_couple_couette(shear, motion, rotation):
    return shear.drag * rotation / math.sqrt(1.0 - motion.ratio * motion.ratio)


register(
    "film-friction sommerfeld: shear of a long, full film, with the moment of the film's own force",
    BALANCED + "2 pi mu R^3 L (w_j - w_b) / (c (1 - eps^2)^(1/2))",
    "Sommerfeld 1904; C = his couple on the journal, 4 pi mu R^3 L w (1 + 2 eps^2) / (c (2 + eps^2) (1 - "
    "eps^2)^(1/2)), less e F_t / 2 of his full film, 6 pi mu R^3 L w eps^2 / (c (2 + eps^2) (1 - eps^2)^(1/2))",
    types=(Couette,),
    make=lambda joint: Couette(petroff_drag(joint)),
    notes="C is that of butenschoen and is valid for any full film.",
)


register(
    "film-friction butenschoen: shear of a filled gap, with the moment of the film's force",
    BALANCED + "2 pi mu R^3 L (w_j - w_b) / (c (1 - eps^2)^(1/2))",
    "after Butenschoen 1976: mu_f = psi (pi |w_j - w_b| / (|w| (1 - eps^2)^(1/2) So_D) + eps sin(beta) / 2), M = mu_f "
    "So_D L D mu |w| R / psi^2, as in the public multibody program MBDyn",
    types=(Couette,),
    make=lambda joint: Couette(petroff_drag(joint)),
    notes="Exact for the pressure of any law that obeys Reynolds' equation, if oil fills the cavity; an empty cavity "
    "has about half the drag.  For the journal of a bearing at rest this is the published formula.",
)


# ---------------------------------------------------------------------------------------------- transition


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
    root = math.sqrt(x * x + 4.0)
    g = 0.5 * (root + x) if x > 0.0 else 2.0 / (root - x)  # the same without cancellation
    exponent = as_type_of(0.0, x)
    for coefficient in EXPONENT_FIT:
        exponent = (exponent + coefficient) * g
    return math.exp(exponent) / (g * g * math.sqrt(g))


@asperity_load.member(GreenwoodTripp)
def _asperity_load_greenwood_tripp(transition, depth):
    eccentricity = transition.clearance + depth
    contact_height = MAX_SEPARATION * transition.roughness + transition.mean_height
    if depth <= -contact_height:
        return as_type_of(0.0, depth)
    cosine_of_edge = max((transition.clearance - contact_height) / eccentricity, as_type_of(-1.0, depth))
    half_angle = (
        2.0 * math.atan(math.sqrt((1.0 - cosine_of_edge) / (1.0 + cosine_of_edge)))
        if cosine_of_edge > -1.0
        else as_type_of(math.pi, depth)
    )
    total, mean_gap = as_type_of(0.0, depth), transition.clearance - transition.mean_height
    for node, weight in NODES:
        cosine = math.cos(half_angle * node)
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
    "transition ramp: linear transition from film to dry contact over a width",
    "F = (1 - w) F_film + w F_dry, w = min(1, max(0, (e - clearance - from) / width))",
    "after Ravn 1998, Multibody Syst. Dyn. 2:1, and Flores, Ambrosio, Claro & Lankarani 2006, as cited by others",
    types=(Ramp,),
    make=lambda joint: Ramp(joint.film.begin, joint.film.width),
    notes="The width should be a few times the roughness of the surfaces, 0.5 to 5 um, not a fraction of the "
    "clearance.",
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
    "transition greenwood-tripp: asperities carry part of the load through the film, then as ramp",
    "F = (1 - w) (F_film + F_asperities) + w F_dry, p_asperities = (16 sqrt(2) pi / 15) density^2 sharpness^(1/2) E* "
    "F_5/2((h - mean_height) / roughness) over the arc, F_5/2(x) the integral of (s - x)^(5/2) exp(-s^2 / 2) / (2 "
    "pi)^(1/2) over s > x, 1 / E* = (1 - nu_1^2) / E_1 + (1 - nu_2^2) / E_2",
    "after Greenwood & Tripp 1970, Proc. Instn. Mech. Engrs. 185:625; the factor derived anew from Hertz's law for a "
    "pair of paraboloids",
    (
        Field("roughness", "m", "standard deviation of the combined heights of both surfaces"),
        Field("density", "1", "number of asperities per area, times tip radius, times roughness", default=0.05),
        Field("sharpness", "1", "roughness divided by the tip radius of the asperities", default=0.01),
        ranged(
            "mean_height",
            "m",
            "mean height of the asperities of both surfaces above the zero of the film thickness; default: 0",
            "[0, inf)",
            optional=True,
        ),
        Field("modulus", "Pa", "contact modulus E* of both bodies; default: from contact.material", optional=True),
    ),
    types=(GreenwoodTripp,),
    make=_make_greenwood_tripp,
    notes="Sources that take E' = 2 E* have half the factor.  F_5/2 is a fit, within 0.15 % from h = 0 to 4 "
    "roughnesses; from 5 on asperities carry nothing.  Their load is elastic, and the joint's friction acts on it. "
    "Their load counts as dry contact.",
)
