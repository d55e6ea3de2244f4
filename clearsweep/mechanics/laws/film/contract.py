"""The interface of film laws and of shear laws.

A film's force is given in the frame of the line of centres: `radial` along the journal's eccentricity, `tangential`
along the direction turned by +90 degrees, both on the journal.  It depends on the eccentricity ratio, its rate and the
effective spin: the spins of journal and bearing minus twice that of the line of centres, all inertial.  So the force is
independent of a rigid rotation of journal and bearing.

The power dissipated by the pressure is P = -F_r eps' c + e F_t w / 2; a law should not make it
negative in any motion.
"""

from typing import NamedTuple

from ....tracing.compiled import calculus as math
from ....tracing.compiled.dual import as_type_of
from ....tracing.compiled.family import family, kernel


class FilmMotion(NamedTuple):
    """Motion of the journal in the film."""

    ratio: float  # eccentricity over clearance, below 1
    squeeze_rate: float  # 1/s, its rate
    spin: float  # rad/s, effective: of journal and bearing minus twice that of the line of centres


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


@family
def film_pressure(law, motion):
    """Return the largest pressure (Pa) in the film; laws without a pressure need not be members."""


@film_pressure.member(None)
def _default_film_pressure(law, motion):
    return 0.0


@family
def shear_couple(shear, motion, rotation):
    """Return the couple C (N m) with which film shear brakes the journal and drives the bearing.

    rotation : rad/s, spin of the journal minus that of the bearing.
    """


@family
def film_couples(shear, motion, rotation, moment):
    """Return the couples (N m) of a film on journal and bearing; shear laws need not be members.

    moment : N m, of the tangential force about the bearing's centre; it and the couples add up to 0.
    """


@film_couples.member(None)
def _default_film_couples(shear, motion, rotation, moment):
    couple = shear_couple(shear, motion, rotation)
    return -couple - 0.5 * moment, couple - 0.5 * moment


@family
def dry_fraction(transition, depth):
    """Return the fraction of the dry force, 0 to 1, if the eccentricity exceeds the clearance by `depth` (m)."""


@family
def asperity_load(transition, depth):
    """Return the load (N) carried by asperities through the film; 0 by default."""


@asperity_load.member(None)
def _default_asperity_load(transition, depth):
    return as_type_of(0.0, depth)


FAMILIES = (film_force,)  # every film law must be a member of these families
SHEAR_FAMILIES = (shear_couple,)
TRANSITION_FAMILIES = (dry_fraction,)


@kernel
def arc_from(ratio, sine, cosine):
    """Return the Arc that begins where sine and cosine have the given ratio; one of them must not be 0."""
    norm = math.sqrt(sine * sine + cosine * cosine)
    sine, cosine = sine / norm, cosine / norm
    one_minus_square = 1.0 - ratio * ratio
    root = math.sqrt(one_minus_square)
    inverse_thickness = (math.pi + 2.0 * math.atan(ratio * sine / root)) / root
    return FilmArc(cosine, sine, 1.0 - (ratio * cosine) ** 2, one_minus_square, inverse_thickness)


@kernel
def maximum_over_arc(law, motion, profile, start):
    """Return the largest `profile(law, motion, cosine, sine)` over the half circle from the angle `start` (rad)."""
    low, high = start, start + math.pi
    for _ in range(40):  # golden section search to 1e-8 of the arc
        golden_step = 0.3819660112501051 * (high - low)
        a, b = low + golden_step, high - golden_step
        if profile(law, motion, math.cos(a), math.sin(a)) < profile(law, motion, math.cos(b), math.sin(b)):
            low = a
        else:
            high = b
    midpoint = 0.5 * (low + high)
    return profile(law, motion, math.cos(midpoint), math.sin(midpoint))
