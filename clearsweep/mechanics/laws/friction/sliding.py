"""Friction as a function of sliding speed; none of these laws sticks."""

from typing import NamedTuple

from ....contracts.catalogue import Field, Law, Order
from ....contracts.roles import MODEL
from ....tracing.compiled import calculus as math
from ....tracing.compiled.choosing import where
from ....tracing.compiled.family import kernel
from ...joints.kinks import kinks, register_kinks, slip_variable
from ...joints.recipe import register
from .contract import COEFFICIENT, KINETIC_FIRST, STATIC, STRIBECK, VISCOUS, friction_force, maker_from_values
from .piecewise import register_force_in_piece

SCALE = Field("velocity_scale", "m/s", "sliding speed at which 76 % of the friction acts", role=MODEL)


class Tanh(NamedTuple):
    """T = -mu N tanh(slip / scale)."""

    coefficient: float  # 1
    velocity_scale: float  # m/s


@friction_force.member(Tanh)
def _friction_force_tanh(friction, normal, slip):
    return -friction.coefficient * normal * math.tanh(slip / friction.velocity_scale)


register(
    Law(
        "friction",
        "tanh",
        "smooth Coulomb friction",
        "T = -mu N tanh(slip / velocity_scale)",
        "regularised Coulomb friction",
        (COEFFICIENT, SCALE),
        notes="Creeps where it should stick.",
    ),
    (Tanh,),
    maker_from_values(Tanh),
)


register(
    Law(
        "friction",
        "coulomb",
        "the same as tanh",
        "T = -mu N sgn(slip), the sign smoothed to tanh(slip / velocity_scale)",
        "Coulomb 1785; regularised",
        (COEFFICIENT, SCALE),
        notes="The jump at rest is smoothed: it creeps where it should stick; a smaller velocity_scale reduces this "
        "creep.",
    ),
    (Tanh,),
    maker_from_values(Tanh),
)


class Ambrosio(NamedTuple):
    """T = -mu N sgn(slip) times 0 below v0, 1 above v1, linear between."""

    coefficient: float  # 1
    v0: float  # m/s
    v1: float  # m/s


def _kinks_ambrosio(friction):
    return -friction.v1, -friction.v0, friction.v0, friction.v1


@register_force_in_piece(Ambrosio, _kinks_ambrosio)
def _force_in_piece_ambrosio(friction, piece, normal, slip):
    dead_zone = where(piece < 2.0, -friction.v0, friction.v0)
    ramp = (slip - dead_zone) / (friction.v1 - friction.v0)
    ratio = where(piece == 2.0, 0.0, where(piece == 0.0, -1.0, where(piece == 4.0, 1.0, ramp)))
    return -friction.coefficient * normal * ratio


register(
    Law(
        "friction",
        "ambrosio",
        "Coulomb friction with a dead band",
        "T = -mu N sgn(slip) min(1, max(0, (|slip| - v0) / (v1 - v0)))",
        "Ambrosio 2003, in Virtual Nonlinear Multibody Systems, NATO Science Series 103",
        (
            COEFFICIENT,
            Field("v0", "m/s", "sliding speed below which there is no friction", low_open=False, role=MODEL),
            Field("v1", "m/s", "sliding speed of full friction", role=MODEL),
        ),
        notes="No friction at all within the dead band: parts creep.",
        orders=(Order("v0", "v1", "friction grows from v0 to v1"),),
    ),
    (Ambrosio,),
    maker_from_values(Ambrosio),
)


class Threlfall(NamedTuple):
    """T = -mu N sgn(slip) / divisor times 1 - exp(-3 |slip| / scale) up to the scale, 0.95 above it."""

    coefficient: float  # 1
    velocity_scale: float  # m/s
    divisor: float  # 1


def _kinks_threlfall(friction):
    return -friction.velocity_scale, 0.0, friction.velocity_scale


@register_force_in_piece(Threlfall, _kinks_threlfall)
def _force_in_piece_threlfall(friction, piece, normal, slip):
    sign, is_rising = where(piece < 2.0, -1.0, 1.0), (piece == 1.0) | (piece == 2.0)
    x = sign * slip / friction.velocity_scale
    ratio = where(is_rising, -math.expm1(-3.0 * x), 0.95) / friction.divisor
    return -friction.coefficient * normal * (sign * ratio)


register(
    Law(
        "friction",
        "threlfall",
        "Coulomb friction with an exponential rise",
        "T = -mu N sgn(slip) / divisor times 1 - exp(-3 |slip| / velocity_scale) up to velocity_scale, 0.95 above",
        "after Threlfall 1978, Mech. Mach. Theory 13:475; both forms as cited by others, not compared with the paper",
        (
            COEFFICIENT,
            Field("velocity_scale", "m/s", "sliding speed of full friction", role=MODEL),
            Field(
                "divisor",
                "1",
                "divisor of the formula; 0.95: full friction is mu N; 1: it is 0.95 mu N, as in papers without the "
                "divisor",
                0.95,
                1.0,
                False,
                False,
                default=0.95,
            ),
        ),
        notes="It jumps by 0.02 % at velocity_scale, where the rise has reached 1 - exp(-3) = 0.950213.  Two forms "
        "are in use.  The default is the rise over 0.95 and then mu N; divisor 1 is the rise alone and then 0.95 mu "
        "N, 5 % lower throughout.  Creeps where it should stick.",
    ),
    (Threlfall,),
    maker_from_values(Threlfall),
)


class BengisuAkay(NamedTuple):
    """T = -N sgn(slip) times a parabola up to the static coefficient at the scale, then falling exponentially."""

    coefficient: float  # kinetic, 1
    static_coefficient: float  # 1
    velocity_scale: float  # m/s
    decay: float  # s/m


@register_force_in_piece(BengisuAkay, _kinks_threlfall)
def _force_in_piece_bengisu_akay(friction, piece, normal, slip):
    sign, is_rising = where(piece < 2.0, -1.0, 1.0), (piece == 1.0) | (piece == 2.0)
    speed_above = sign * slip - friction.velocity_scale
    parabola = friction.static_coefficient * (1.0 - (speed_above / friction.velocity_scale) ** 2)
    decay = math.exp(-friction.decay * speed_above)
    falling = friction.coefficient + (friction.static_coefficient - friction.coefficient) * decay
    return -normal * (sign * where(is_rising, parabola, falling))


register(
    Law(
        "friction",
        "bengisu-akay",
        "static friction that falls to kinetic friction",
        "T = -N sgn(slip) mu_s (1 - (|slip| - v)^2 / v^2) up to v = velocity_scale, "
        "-N sgn(slip) (mu + (mu_s - mu) exp(-decay (|slip| - v))) above",
        "after Bengisu & Akay 1994, J. Sound Vib. 171:557",
        (
            COEFFICIENT,
            STATIC,
            Field("velocity_scale", "m/s", "sliding speed at which the static friction is reached", role=MODEL),
            Field("decay", "s/m", "rate of the fall from static to kinetic friction", low_open=False),
        ),
        notes="Creeps where it should stick.",
    ),
    (BengisuAkay,),
    maker_from_values(BengisuAkay),
)


class BrownMcPhee(NamedTuple):
    """T = -N (mu tanh(4 x) + (mu_s - mu) x / (x^2 / 4 + 3/4)^2 + viscous slip), x = slip / stribeck_velocity."""

    coefficient: float  # kinetic, 1
    static_coefficient: float  # 1
    stribeck_velocity: float  # m/s
    viscous: float  # s/m


@friction_force.member(BrownMcPhee)
def _friction_force_brown_mcphee(friction, normal, slip):
    x = slip / friction.stribeck_velocity
    width = 0.25 * x * x + 0.75
    ratio = friction.coefficient * math.tanh(4.0 * x)
    ratio += (friction.static_coefficient - friction.coefficient) * x / (width * width)
    return -normal * (ratio + friction.viscous * slip)


register(
    Law(
        "friction",
        "brown-mcphee",
        "smooth friction with the Stribeck effect, all derivatives continuous",
        "T = -N (mu tanh(4 x) + (mu_s - mu) x / (x^2 / 4 + 3/4)^2 + viscous slip), x = slip / stribeck_velocity",
        "after Brown & McPhee 2016, J. Comput. Nonlinear Dyn. 11:054502, as in public programs that quote it",
        (
            COEFFICIENT,
            STATIC,
            Field("stribeck_velocity", "m/s", "sliding speed at which the static friction is reached, v_t"),
            VISCOUS,
        ),
        notes="At stribeck_velocity mu_s - 0.0007 mu, from there falling to mu, which is reached to 1 % of the "
        "difference at twelve times that speed.  The paper's viscous part does not grow with the load; here it does, "
        "as in the other laws.  Creeps where it should stick.",
        orders=(KINETIC_FIRST,),
    ),
    (BrownMcPhee,),
    maker_from_values(BrownMcPhee),
)


class Stribeck(NamedTuple):
    """T = -N (mu_d + (mu_s - mu_d) exp(-|slip / stribeck|^shape)) tanh(slip / scale) - N viscous slip."""

    coefficient: float  # kinetic, 1
    static_coefficient: float  # 1
    stribeck_velocity: float  # m/s
    shape: float  # 1
    viscous: float  # s/m
    velocity_scale: float  # m/s


@kernel
def stribeck_coefficient(friction, slip):
    """Return mu + (mu_s - mu) exp(-|slip / stribeck_velocity|^shape)."""
    decay = math.exp(-(abs(slip / friction.stribeck_velocity) ** friction.shape))
    return friction.coefficient + (friction.static_coefficient - friction.coefficient) * decay


register_kinks(Stribeck, slip_variable)


@kinks.member(Stribeck)
def _kinks_stribeck(friction):
    return (where(friction.shape == 2.0, math.inf, 0.0),)


@friction_force.member(Stribeck)
def _friction_force_stribeck(friction, normal, slip):
    ratio = stribeck_coefficient(friction, slip)
    return -normal * (ratio * math.tanh(slip / friction.velocity_scale) + friction.viscous * slip)


register(
    Law(
        "friction",
        "stribeck",
        "smooth friction with the Stribeck effect and a viscous part",
        "T = -N ((mu + (mu_s - mu) exp(-|slip / stribeck_velocity|^shape)) tanh(slip / velocity_scale) + viscous slip)",
        "Stribeck 1902, Z. VDI 46:1341, in the form of Armstrong-Helouvry, Dupont & Canudas de Wit 1994, Automatica "
        "30:1083; regularised",
        (COEFFICIENT, STATIC, *STRIBECK, SCALE),
        notes="Creeps where it should stick; velocity_scale should be well below stribeck_velocity, otherwise the "
        "static friction is never reached.",
    ),
    (Stribeck,),
    maker_from_values(Stribeck),
)
