"""Laws that add a damper's force to the elastic force."""

from typing import NamedTuple

from ...contracts.catalogue import Field, Law, ranged
from ...tracing.compiled import calculus as math
from ...tracing.compiled.choosing import where
from .contract import UNKNOWN, current_piece, kinks, penetration_variable, rate_variable, register, register_pieces
from .elastic import elastic_force
from .loss import (
    RESTITUTION,
    approach_damping_rebound,
    approach_rate,
    damping_ratio,
    register_contact_force,
    zero_rate_kink,
)

MASS = Field("mass", "kg", "effective mass of the impact, m1 m2 / (m1 + m2)")
SPRING = Field("stiffness", "N/m", "stiffness of the spring")
DAMPER = ranged("damping", "N*s/m", "coefficient of the damper", "[0, inf)")

# ---------------------------------------------------------------------------------------------- root of the stiffness


class RootDamper(NamedTuple):
    """F = F_elastic + d sqrt(F_elastic / pen) rate; it pulls before the separation."""

    damping: float  # d, kg^0.5: sqrt(F_elastic / pen) is the root of a stiffness


@register_contact_force(RootDamper, pulls=True, times_elastic=False)
def _root_damper(law, elastic, pen, rate, onset_rate):
    force = elastic_force(elastic, pen)
    root_stiffness = (
        math.sqrt(force / pen) if pen > 0.0 else 0.0
    )  # the limit, except for a linear spring, where a single point does not matter
    return force + law.damping * root_stiffness * rate, force


def _make_tsuji(joint):
    parameters = joint.contact.values
    # Hertz's exponent if the elastic force is not a power law
    alpha = math.sqrt(2.0 * (parameters.get("exponent", 1.5) + 1.0)) * damping_ratio(parameters["restitution"])
    return RootDamper(alpha * math.sqrt(parameters["mass"]))


register(
    Law(
        "law",
        "tsuji",
        "damped Hertzian spring with exactly the specified restitution",
        "F = F_elastic + alpha sqrt(mass F_elastic / pen) rate, alpha = -sqrt(2 (n + 1)) ln e / sqrt(pi^2 + ln(e)^2); "
        "for n = 1.5: F = K pen^1.5 + alpha sqrt(mass K) pen^0.25 rate with sqrt(5) in alpha",
        "Tsuji, Tanaka & Ishida 1992, Powder Technol. 71:239; alpha by Antypov & Elliott 2011, EPL 94:50004",
        (RESTITUTION, MASS),
        notes="Pulls before the surfaces part, and is not clipped: the restitution applies for a release at zero "
        "penetration.  Exact for elastic: power; elsewhere n = 1.5 is in alpha.",
    ),
    (RootDamper,),
    _make_tsuji,
    free_restitution=lambda e: e,
)


class ApproachRootDamper(NamedTuple):
    """A RootDamper during approach; only the elastic force during rebound."""

    damping: float  # kg^0.5
    piece: float = UNKNOWN


register_pieces(ApproachRootDamper, rate_variable)
kinks.member(ApproachRootDamper)(zero_rate_kink)


@register_contact_force(ApproachRootDamper, pulls=False, times_elastic=False)
def _approach_root_damper(law, elastic, pen, rate, onset_rate):
    force = elastic_force(elastic, pen)
    root_stiffness = math.sqrt(force / pen) if pen > 0.0 else 0.0
    return force + law.damping * root_stiffness * approach_rate(law.piece, rate), force


def jankowski_ratio(e: float) -> float:
    """Return xi = (9 sqrt(5) / 2) (1 - e^2) / (e (e (9 pi - 16) + 16))."""
    return 4.5 * math.sqrt(5.0) * (1.0 - e * e) / (e * (e * (9.0 * math.pi - 16.0) + 16.0))


def _make_jankowski(joint):
    parameters = joint.contact.values
    return ApproachRootDamper(2.0 * jankowski_ratio(parameters["restitution"]) * math.sqrt(parameters["mass"]))


register(
    Law(
        "law",
        "jankowski",
        "Hertzian spring, damped only during the approach",
        "F = F_elastic + 2 xi sqrt(mass F_elastic / pen) rate while rate > 0, else F_elastic; "
        "xi = (9 sqrt(5) / 2) (1 - e^2) / (e (e (9 pi - 16) + 16))",
        "after Jankowski 2005, Earthq. Eng. Struct. Dyn. 34:595, and 2006, 35:517",
        (RESTITUTION, MASS),
        notes="Made for an exponent of 1.5; within 7 % of the specified restitution from 0.1 on, 1.1 % from 0.5 on.",
    ),
    (ApproachRootDamper,),
    _make_jankowski,
    free_restitution=lambda e: approach_damping_rebound(2.0 * jankowski_ratio(e) / math.sqrt(5.0)),
)

# ---------------------------------------------------------------------------------------------- constant damping


def _viscous_spring(law, elastic, pen, rate, onset_rate):
    force = elastic_force(elastic, pen)
    return force + law.damping * rate, force


class PullingSpring(NamedTuple):
    """F = F_elastic + c rate; it pulls before the separation."""

    damping: float  # c, N s/m


register_contact_force(PullingSpring, pulls=True, times_elastic=False)(_viscous_spring)


def _make_anagnostopoulos(joint):
    parameters = joint.contact.values
    zeta = damping_ratio(parameters["restitution"])
    return PullingSpring(2.0 * zeta * math.sqrt(parameters["stiffness"] * parameters["mass"]))


register(
    Law(
        "law",
        "anagnostopoulos",
        "linear spring and damper from the restitution",
        "F = k pen + c rate, c = 2 zeta sqrt(k mass), zeta = -ln e / sqrt(pi^2 + ln(e)^2)",
        "Anagnostopoulos 1988, Earthq. Eng. Struct. Dyn. 16:443, and 2004, 33:897",
        (SPRING, RESTITUTION, MASS),
        uses_elastic=False,
        notes="The force jumps to c times the onset rate at contact, pulls before the surfaces part and is not "
        "clipped.  The restitution applies for a release at zero penetration.  The law kelvin-voigt with the same "
        "damping, clipped, has a larger restitution.",
    ),
    (PullingSpring,),
    _make_anagnostopoulos,
    free_restitution=lambda e: e,
)


register(
    Law(
        "law",
        "kelvin-voigt-unclipped",
        "linear spring and damper that pulls until the surfaces part",
        "F = k pen + c rate",
        "Kelvin-Voigt",
        (SPRING, DAMPER),
        uses_elastic=False,
        notes="The force jumps to c times the onset rate at contact and pulls before the surfaces part.  The "
        "restitution of a free impact is exp(-pi zeta / sqrt(1 - zeta^2)), zeta = c / (2 sqrt(k m)) < 1; from zeta = "
        "1 on the surfaces never part.  A pulling force causes no friction.",
    ),
    (PullingSpring,),
)


class ViscousSpring(NamedTuple):
    """A PullingSpring whose force is clipped at 0."""

    damping: float  # c, N s/m


register_contact_force(ViscousSpring, pulls=False, times_elastic=False)(_viscous_spring)


register(
    Law(
        "law",
        "kelvin-voigt",
        "linear spring and damper, clipped",
        "F = max(0, k pen + c rate)",
        "Kelvin-Voigt; clipped at zero",
        (SPRING, DAMPER),
        uses_elastic=False,
        notes="The force jumps to c times the onset rate at contact and is clipped where it would pull.  The "
        "restitution of a free impact is exp(-(zeta / w) atan2(2 zeta w, 2 zeta^2 - 1)), zeta = c / (2 sqrt(k m)) < 1, "
        "w = sqrt(1 - zeta^2): more than exp(-pi zeta / w), which applies without clipping.  With zeta > 1 it is "
        "exp(-2 zeta arcosh(zeta) / sqrt(zeta^2 - 1)), below exp(-2) = 0.135.",
    ),
    (ViscousSpring,),
)


register(
    Law(
        "law",
        "ristow",
        "elastic force and a constant damper, clipped",
        "F = max(0, F_elastic + damping rate)",
        "after Ristow 1992, J. Phys. I France 2:649",
        (DAMPER,),
        notes="The restitution depends on the speed.  The force jumps to damping times the onset rate at contact.",
    ),
    (ViscousSpring,),
)

# ---------------------------------------------------------------------------------------------- damping over depth


class RootViscous(NamedTuple):
    """F = F_elastic + g sqrt(pen) rate."""

    damping: float  # g, N s/m^1.5


@register_contact_force(RootViscous, pulls=False, times_elastic=False)
def _root_viscous(law, elastic, pen, rate, onset_rate):
    force = elastic_force(elastic, pen)
    return force + law.damping * math.sqrt(pen) * rate, force


register(
    Law(
        "law",
        "kuwabara-kono",
        "viscoelastic spheres, clipped",
        "F = max(0, F_elastic + damping sqrt(pen) rate)",
        "Kuwabara & Kono 1987, Jpn. J. Appl. Phys. 26:1230",
        (ranged("damping", "N*s/m^1.5", "coefficient of the damper per square root of the penetration", "[0, inf)"),),
        notes="The restitution depends on the speed and tends to 1 at low speed.  Made for an exponent of 1.5.",
    ),
    (RootViscous,),
)


class SteppedDamper(NamedTuple):
    """F = F_elastic + c step(pen) rate, with step growing as 3 x^2 - 2 x^3 of x = pen / depth from 0 to 1."""

    damping: float  # c, N s/m
    depth: float  # m
    piece: float = UNKNOWN


register_pieces(SteppedDamper, penetration_variable)


@kinks.member(SteppedDamper)
def _kinks_stepped_damper(law):
    return (law.depth,)


@register_contact_force(SteppedDamper, pulls=False, times_elastic=False)
def _stepped_damper(law, elastic, pen, rate, onset_rate):
    force = elastic_force(elastic, pen)
    x = where(current_piece(law.piece, kinks(law), pen) == 0.0, pen / law.depth, 1.0)
    return force + law.damping * x * x * (3.0 - 2.0 * x) * rate, force


register(
    Law(
        "law",
        "adams-impact",
        "the IMPACT function of MSC Adams",
        "F = max(0, F_elastic + damping step(pen) rate), step = 3 x^2 - 2 x^3 of x = min(1, pen / depth)",
        "MSC Adams/Solver, functions IMPACT and STEP",
        (
            DAMPER,
            Field("depth", "m", "penetration from which the full damping acts"),
        ),
        notes="With elastic: power its K and e are `stiffness` and `exponent`, c_max is `damping`, d is `depth`.  The "
        "restitution depends on the speed.",
    ),
    (SteppedDamper,),
)
