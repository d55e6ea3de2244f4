"""Couples on journal and bearing from the shear of a film.

The pressure alone exerts a moment: the force on the journal acts along a line through the bearing's centre only if
its tangential part is 0.  A film has no inertia, so its couples on both bodies and the moment e F_t of its force
add up to 0.  Split equally, M_j = -C - e F_t / 2 and M_b = C - e F_t / 2, only C is left to a law.
"""

from typing import NamedTuple

from ....contracts.catalogue import Law
from ....tracing.compiled import calculus as math
from ....tracing.compiled.dual import as_type_of
from ...joints.recipe import register
from .contract import film_couples, shear_couple

BALANCED = "M_j = -C - e F_t / 2, M_b = C - e F_t / 2, C = "
DEFAULT_SHEAR_LAW = "butenschoen"  # the meaning of `film.friction: by-law`


class Unsheared(NamedTuple):
    """No couple."""


@shear_couple.member(Unsheared)
def _shear_couple_unsheared(shear, motion, rotation):
    return as_type_of(0.0, motion.ratio)


@film_couples.member(Unsheared)
def _film_couples_unsheared(shear, motion, rotation, moment):
    zero = as_type_of(0.0, moment)
    return zero, zero


register(
    Law(
        "film-friction",
        "none",
        "no shear torque: the film's force acts through the centres",
        "M_j = M_b = 0",
        "a convention of multibody papers",
        notes="The moment e F_t of the force is not balanced.  So film_loss depends on how fast both bodies turn "
        "together and may be below 0.  For comparison with trajectories computed in this way.",
    ),
    (Unsheared,),
    lambda joint: Unsheared(),
)


class Petroff(NamedTuple):
    """C = drag (w_j - w_b)."""

    drag: float  # 2 pi mu R^3 L / c, N m s


@shear_couple.member(Petroff)
def _shear_couple_petroff(shear, motion, rotation):
    return as_type_of(shear.drag * rotation, motion.ratio)


def petroff_drag(joint) -> float:
    """Return 2 pi mu R^3 L / c of a joint with a film, N m s."""
    return 2.0 * math.pi * joint.film.viscosity * joint.bearing_radius**3 * joint.length / joint.clearance


register(
    Law(
        "film-friction",
        "petroff",
        "shear as in a concentric bearing",
        BALANCED + "2 pi mu R^3 L (w_j - w_b) / c",
        "Petroff 1883 for C; the balance of moments for the rest",
        notes="C does not depend on the eccentricity: it is the smallest drag of a full film.",
    ),
    (Petroff,),
    lambda joint: Petroff(petroff_drag(joint)),
)


class Couette(NamedTuple):
    """C = drag (w_j - w_b) / sqrt(1 - eps^2), the integral of the surfaces' shear over a filled gap."""

    drag: float  # 2 pi mu R^3 L / c, N m s


@shear_couple.member(Couette)
def _shear_couple_couette(shear, motion, rotation):
    return shear.drag * rotation / math.sqrt(1.0 - motion.ratio * motion.ratio)


register(
    Law(
        "film-friction",
        "sommerfeld",
        "shear of a long, full film, with the moment of the film's own force",
        BALANCED + "2 pi mu R^3 L (w_j - w_b) / (c (1 - eps^2)^(1/2))",
        "Sommerfeld 1904; C = his couple on the journal, 4 pi mu R^3 L w (1 + 2 eps^2) / (c (2 + eps^2) (1 - "
        "eps^2)^(1/2)), less e F_t / 2 of his full film, 6 pi mu R^3 L w eps^2 / (c (2 + eps^2) (1 - eps^2)^(1/2))",
        notes="C is that of butenschoen and is valid for any full film.",
    ),
    (Couette,),
    lambda joint: Couette(petroff_drag(joint)),
)


register(
    Law(
        "film-friction",
        "butenschoen",
        "shear of a filled gap, with the moment of the film's force",
        BALANCED + "2 pi mu R^3 L (w_j - w_b) / (c (1 - eps^2)^(1/2))",
        "after Butenschoen 1976: mu_f = psi (pi |w_j - w_b| / (|w| (1 - eps^2)^(1/2) So_D) + eps sin(beta) / 2), M = "
        "mu_f So_D L D mu |w| R / psi^2, as in the public multibody program MBDyn",
        notes="Exact for the pressure of any law that obeys Reynolds' equation, if oil fills the cavity; an empty "
        "cavity has about half the drag.  For the journal of a bearing at rest this is the published formula.",
    ),
    (Couette,),
    lambda joint: Couette(petroff_drag(joint)),
)
