"""The couples with which the shear of a film drags at journal and bearing."""

from typing import NamedTuple

from ....contracts.catalogue import Law
from ...compiled import calculus as math
from ...compiled.dual import as_type_of
from ..recipe import enter
from .contract import film_couples


class Unsheared(NamedTuple):
    """No couple."""


@film_couples.member(Unsheared)
def _none(shear, motion, turning, moment):
    nothing = as_type_of(0.0, moment)
    return nothing, nothing


enter(
    Law("film-friction", "none", "no couple", "M = 0", "a film's force through the centres alone"),
    (Unsheared,),
    lambda joint: Unsheared(),
)


class Petroff(NamedTuple):
    """M = -drag (w_j - w_b) on the journal, the opposite on the bearing."""

    drag: float  # 2 pi mu R^3 L / c, N m s


@film_couples.member(Petroff)
def _petroff(shear, motion, turning, moment):
    couple = as_type_of(shear.drag * turning, moment)
    return -couple, couple


def drag(joint) -> float:
    """Return 2 pi mu R^3 L / c of a joint with a film, N m s."""
    return 2.0 * math.pi * joint.film.viscosity * joint.bearing_radius**3 * joint.length / joint.clearance


enter(
    Law(
        "film-friction",
        "petroff",
        "shear as in a concentric bearing",
        "M_j = -2 pi mu R^3 L (w_j - w_b) / c, M_b = -M_j",
        "Petroff 1883",
        notes="Knows no eccentricity: the least that a full film drags.",
    ),
    (Petroff,),
    lambda joint: Petroff(drag(joint)),
)


class SommerfeldShear(NamedTuple):
    """Petroff's couple, grown with the eccentricity as in a long bearing."""

    drag: float  # 2 pi mu R^3 L / c, N m s


@film_couples.member(SommerfeldShear)
def _sommerfeld(shear, motion, turning, moment):
    squared = motion.ratio * motion.ratio
    growth = 2.0 * (1.0 + 2.0 * squared) / ((2.0 + squared) * math.sqrt(1.0 - squared))
    couple = shear.drag * growth * turning
    return -couple, couple


enter(
    Law(
        "film-friction",
        "sommerfeld",
        "shear of a long, full film",
        "M_j = -4 pi mu R^3 L (w_j - w_b) (1 + 2 eps^2) / (c (2 + eps^2) (1 - eps^2)^(1/2)), M_b = -M_j",
        "Sommerfeld 1904, for the journal; here the bearing's is its opposite",
        notes="Petroff's at eps = 0.",
    ),
    (SommerfeldShear,),
    lambda joint: SommerfeldShear(drag(joint)),
)


class ButenschoenShear(NamedTuple):
    """Petroff's couple over sqrt(1 - eps^2), and half of the tangential force's moment on either body."""

    drag: float  # 2 pi mu R^3 L / c, N m s


@film_couples.member(ButenschoenShear)
def _butenschoen(shear, motion, turning, moment):
    couple = shear.drag * turning / math.sqrt(1.0 - motion.ratio * motion.ratio)
    return -couple - 0.5 * moment, couple - 0.5 * moment


enter(
    Law(
        "film-friction",
        "butenschoen",
        "shear of a bearing of finite length, with the moment of the film's force",
        "M_j = -2 pi mu R^3 L (w_j - w_b) / (c (1 - eps^2)^(1/2)) - e F_t / 2, M_b = 2 pi mu R^3 L (w_j - w_b) / (c (1 "
        "- eps^2)^(1/2)) - e F_t / 2",
        "after Butenschoen 1976: mu_f = psi (pi |w_j - w_b| / (|w| (1 - eps^2)^(1/2) So_D) + eps sin(beta) / 2), M = "
        "mu_f So_D L D mu |w| R / psi^2, as in the public multibody program MBDyn",
        notes="Half of the moment e F_t acts on either body, so that forces and couples together have none and what "
        "the film takes does not depend on a rotation of everything; for the journal of a bearing at rest this is the "
        "published formula.",
    ),
    (ButenschoenShear,),
    lambda joint: ButenschoenShear(drag(joint)),
)
#: What `film.friction: by-law` stands for.
BY_LAW = {"finite": "butenschoen", "short": "petroff", "long": "sommerfeld", "pinkus-sternlicht": "sommerfeld"}
