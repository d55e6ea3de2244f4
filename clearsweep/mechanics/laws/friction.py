"""The interface of friction laws, and the laws without bristles: functions of the sliding speed, and one that sticks.

The formula of some changes at some sliding speeds, so that steps end there.
"""

from typing import NamedTuple

from ...contracts.catalogue import MODEL, Field, Order, ranged
from ...tracing.compiled import calculus as math
from ...tracing.compiled.choosing import where
from ...tracing.compiled.family import family, family_with_default, kernel
from . import contract


@family
def friction_force(friction, normal, slip):
    """Return the tangential force (N) at normal force `normal` (N) and sliding speed `slip` (m/s); it opposes `slip`.

    `normal` is at least 0, except in trial steps past the end of a contact.
    """


@family_with_default
def static_limit(friction):
    """Return the static limit of tangential over normal force while sticking, 0 if the law does not stick.

    If a friction law of a scene is a member, contacts in the mode STUCK carry the force that keeps their surfaces from
    sliding.
    """
    return 0.0


class Sliding(NamedTuple):
    """The contact of surfaces that always touch, as far as the internal rates of a law of friction need it."""

    normal: float = 1.0  # N
    slip: float = 0.0  # m/s


@kernel
def friction_in_pin(friction, reaction, slip):
    """Return the tangential force (N) in a pin without clearance, from its `reaction` R (N).

    R is the resultant of normal force N and friction T, so T = R sin(atan(T/N)): the couple of T is that of R at the
    friction circle.  T/N is that of a normal force of 1 N, as laws are proportional to it.
    """
    ratio = friction_force(friction, 1.0, slip)
    return reaction * ratio / math.sqrt(1.0 + ratio * ratio)


@kernel
def static_limit_in_pin(friction, reaction):
    """Return the largest tangential force (N) of a pin that sticks, from its reaction (N), see `friction_in_pin`."""
    limit = static_limit(friction)
    return reaction * limit / math.sqrt(1.0 + limit * limit)


@family
def settled_state(friction, slip):
    """Return the internal state of a law after long sliding at `slip` (m/s), one number per field of state."""


class Settled(NamedTuple):
    """A friction law whose internal state is the settled one at any sliding speed, as for a machine without history."""

    law: tuple


@friction_force.member(Settled)
def _friction_force_settled(friction, normal, slip):
    law = friction.law
    parameter_count = len(law) - len(law._field_defaults)
    return friction_force(type(law)(*law[:parameter_count], *settled_state(law, slip)), normal, slip)


def without_history(friction):
    """Return a law without history: itself, or Settled where its state is integrated."""
    return Settled(friction) if type(friction) in settled_state.members else friction


contract.require("friction", friction_force)


class Frictionless(NamedTuple):
    """No tangential force; the sliding speed is never computed for it."""


friction_force.member(Frictionless)(lambda friction, normal, slip: 0.0)


# ---------------------------------------------------------------------------------------------- fields of several laws

COEFFICIENT = ranged("coefficient", "1", "coefficient of kinetic friction, mu", "[0, inf)")
STATIC = ranged("static_coefficient", "1", "coefficient of static friction, mu_s", "[0, inf)")
VISCOUS = ranged("viscous", "s/m", "increase of the coefficient per sliding speed", "[0, inf)", default=0.0)
STRIBECK = (
    Field("stribeck_velocity", "m/s", "sliding speed over which friction falls from static to kinetic"),
    Field(
        "shape", "1", "exponent of the fall from static to kinetic friction; 2: Gaussian, 1: exponential", default=2.0
    ),
    VISCOUS,
)
KINETIC_FIRST = Order("coefficient", "static_coefficient", "friction falls once surfaces slide", equal=True)


# ---------------------------------------------------------------------------------------------- formulas by pieces


class PiecewiseFriction(NamedTuple):
    """A friction law of a contact, with the piece of the law that applies."""

    law: tuple  # a member of `force_in_piece` and, over the sliding speed, of `kinks`
    piece: float = contract.UNKNOWN


@family
def force_in_piece(law, piece, normal, slip):
    """Return the `friction_force` by the formula of a piece, counted from the lowest sliding speed."""


@friction_force.member(PiecewiseFriction)
def _friction_force_piecewise_friction(friction, normal, slip):
    law = friction.law
    return force_in_piece(law, contract.current_piece(friction.piece, contract.kinks(law), slip), normal, slip)


contract.register_pieces(PiecewiseFriction, contract.slip_variable, lambda friction: contract.kinks(friction.law))


def register_force_in_piece(law_type, kink_speeds):
    """Return the decorator that registers the `force_in_piece` of a type of law; kink_speeds : law -> its `kinks`."""

    def register(force_function):
        contract.kinks.member(law_type)(kink_speeds)
        friction_force.member(law_type)(
            lambda law, normal, slip: force_in_piece(law, contract.piece_at(contract.kinks(law), slip), normal, slip)
        )
        return force_in_piece.member(law_type)(force_function)

    return register


def as_contact_friction(friction):
    """Return a compiled friction law in the form used by a contact, which stores the piece that applies."""
    return PiecewiseFriction(friction) if type(friction) in force_in_piece.members else friction


# ---------------------------------------------------------------------------------------------- laws that slide


SCALE = Field("velocity_scale", "m/s", "sliding speed at which 76 % of the friction acts", role=MODEL)


class Tanh(NamedTuple):
    """T = -mu N tanh(slip / scale)."""

    coefficient: float  # 1
    velocity_scale: float  # m/s


@friction_force.member(Tanh)
def _friction_force_tanh(friction, normal, slip):
    return -friction.coefficient * normal * math.tanh(slip / friction.velocity_scale)


contract.register(
    "friction tanh: smooth Coulomb friction",
    "T = -mu N tanh(slip / velocity_scale)",
    "regularised Coulomb friction",
    (COEFFICIENT, SCALE),
    types=(Tanh,),
    notes="Creeps where it should stick.",
)


contract.register(
    "friction coulomb: the same as tanh",
    "T = -mu N sgn(slip), the sign smoothed to tanh(slip / velocity_scale)",
    "Coulomb 1785; regularised",
    (COEFFICIENT, SCALE),
    types=(Tanh,),
    notes="The jump at rest is smoothed: it creeps where it should stick; a smaller velocity_scale reduces this creep.",
)


class Ambrosio(NamedTuple):
    """T = -mu N sgn(slip) times 0 below v0, 1 above v1, linear between."""

    coefficient: float  # 1
    v0: float  # m/s
    v1: float  # m/s


@register_force_in_piece(Ambrosio, lambda law: (-law.v1, -law.v0, law.v0, law.v1))
def _force_in_piece_ambrosio(friction, piece, normal, slip):
    dead_zone = where(piece < 2.0, -friction.v0, friction.v0)
    ramp = (slip - dead_zone) / (friction.v1 - friction.v0)
    ratio = where(piece == 2.0, 0.0, where(piece == 0.0, -1.0, where(piece == 4.0, 1.0, ramp)))
    return -friction.coefficient * normal * ratio


contract.register(
    "friction ambrosio: Coulomb friction with a dead band",
    "T = -mu N sgn(slip) min(1, max(0, (|slip| - v0) / (v1 - v0)))",
    "Ambrosio 2003, in Virtual Nonlinear Multibody Systems, NATO Science Series 103",
    (
        COEFFICIENT,
        ranged("v0", "m/s", "sliding speed below which there is no friction", "[0, inf)", role=MODEL),
        Field("v1", "m/s", "sliding speed of full friction", role=MODEL),
    ),
    types=(Ambrosio,),
    notes="No friction at all within the dead band: parts creep.",
    orders=(Order("v0", "v1", "friction grows from v0 to v1"),),
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


contract.register(
    "friction threlfall: Coulomb friction with an exponential rise",
    "T = -mu N sgn(slip) / divisor times 1 - exp(-3 |slip| / velocity_scale) up to velocity_scale, 0.95 above",
    "after Threlfall 1978, Mech. Mach. Theory 13:475; both forms as cited by others, not compared with the paper",
    (
        COEFFICIENT,
        Field("velocity_scale", "m/s", "sliding speed of full friction", role=MODEL),
        ranged(
            "divisor",
            "1",
            "divisor of the formula; 0.95: full friction is mu N; 1: it is 0.95 mu N, as in papers without the divisor",
            "[0.95, 1]",
            default=0.95,
        ),
    ),
    types=(Threlfall,),
    notes="It jumps by 0.02 % at velocity_scale, where the rise has reached 1 - exp(-3) = 0.950213.  Two forms are in "
    "use.  The default is the rise over 0.95 and then mu N; divisor 1 is the rise alone and then 0.95 mu N, 5 % lower "
    "throughout.  Creeps where it should stick.",
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


contract.register(
    "friction bengisu-akay: static friction that falls to kinetic friction",
    "T = -N sgn(slip) mu_s (1 - (|slip| - v)^2 / v^2) up to v = velocity_scale, -N sgn(slip) (mu + (mu_s - mu) "
    "exp(-decay (|slip| - v))) above",
    "after Bengisu & Akay 1994, J. Sound Vib. 171:557",
    (
        COEFFICIENT,
        STATIC,
        Field("velocity_scale", "m/s", "sliding speed at which the static friction is reached", role=MODEL),
        ranged("decay", "s/m", "rate of the fall from static to kinetic friction", "[0, inf)"),
    ),
    types=(BengisuAkay,),
    notes="Creeps where it should stick.",
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


contract.register(
    "friction brown-mcphee: smooth friction with the Stribeck effect, all derivatives continuous",
    "T = -N (mu tanh(4 x) + (mu_s - mu) x / (x^2 / 4 + 3/4)^2 + viscous slip), x = slip / stribeck_velocity",
    "after Brown & McPhee 2016, J. Comput. Nonlinear Dyn. 11:054502, as in public programs that quote it",
    (
        COEFFICIENT,
        STATIC,
        Field("stribeck_velocity", "m/s", "sliding speed at which the static friction is reached, v_t"),
        VISCOUS,
    ),
    types=(BrownMcPhee,),
    notes="At stribeck_velocity mu_s - 0.0007 mu, from there falling to mu, which is reached to 1 % of the difference "
    "at twelve times that speed.  The paper's viscous part does not grow with the load; here it does, as in the other "
    "laws.  Creeps where it should stick.",
    orders=(KINETIC_FIRST,),
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


contract.register_kinks(
    Stribeck, contract.slip_variable, lambda friction: (where(friction.shape == 2.0, math.inf, 0.0),)
)


@friction_force.member(Stribeck)
def _friction_force_stribeck(friction, normal, slip):
    ratio = stribeck_coefficient(friction, slip)
    return -normal * (ratio * math.tanh(slip / friction.velocity_scale) + friction.viscous * slip)


contract.register(
    "friction stribeck: smooth friction with the Stribeck effect and a viscous part",
    "T = -N ((mu + (mu_s - mu) exp(-|slip / stribeck_velocity|^shape)) tanh(slip / velocity_scale) + viscous slip)",
    "Stribeck 1902, Z. VDI 46:1341, in the form of Armstrong-Helouvry, Dupont & Canudas de Wit 1994, Automatica "
    "30:1083; regularised",
    (COEFFICIENT, STATIC, *STRIBECK, SCALE),
    types=(Stribeck,),
    notes="Creeps where it should stick; velocity_scale should be well below stribeck_velocity, otherwise the static "
    "friction is never reached.",
)


# ---------------------------------------------------------------------------------------------- a law that sticks


#: Guards: the sliding speed enters the band, or leaves it; its sign is not known yet; it changes sign while the force
#: is clipped; the force needed to stop the sliding passes its upper or lower limit, outwards or back.
STICKS, SLIPS, DIRECTION_UNKNOWN, REVERSES, REACHES_UPPER, REACHES_LOWER, BELOW_UPPER, ABOVE_LOWER = range(8)
RELEASE_FACTOR = 1.001  # times the sticking speed: sliding speed at which surfaces are released


class Karnopp(NamedTuple):
    """Slides by Stribeck's law down to the sliding speed `band`; below it sticks, see `coupling.inertia`."""

    coefficient: float  # kinetic, 1
    static_coefficient: float  # 1
    stribeck_velocity: float  # m/s
    shape: float  # 1
    viscous: float  # s/m
    band: float  # m/s
    sliding_sign: float = 0.0  # sign of the sliding speed as it began to slide; 0: not known yet


@friction_force.member(Karnopp)
def _friction_force_karnopp(friction, normal, slip):
    sign = where(friction.sliding_sign != 0.0, friction.sliding_sign, min(max(slip / friction.band, -1.0), 1.0))
    return -normal * (stribeck_coefficient(friction, slip) * sign + friction.viscous * slip)


@static_limit.member(Karnopp)
def _static_limit_karnopp(friction):
    edge_coefficient = stribeck_coefficient(friction, friction.band) + friction.viscous * friction.band
    return max(friction.static_coefficient, edge_coefficient)  # otherwise released surfaces would stick again at once


@contract.guards.member(Karnopp)
def _guards_karnopp(friction):
    return (
        contract.Guard((contract.PRESSED,), contract.STUCK, at_start=True),
        contract.Guard(contract.STICKING, contract.PRESSED),
        contract.Guard((contract.PRESSED,), at_start=True),
        contract.Guard((contract.CLIPPED,)),
        contract.Guard((contract.STUCK,), contract.AT_LIMIT_UP),
        contract.Guard((contract.STUCK,), contract.AT_LIMIT_DOWN),
        contract.Guard((contract.AT_LIMIT_UP,), contract.STUCK),
        contract.Guard((contract.AT_LIMIT_DOWN,), contract.STUCK),
    )


@contract.guard_values.member(Karnopp)
def _guard_values_karnopp(friction, start, contact, root):
    slip_sign = where(friction.sliding_sign != 0.0, friction.sliding_sign, math.copysign(1.0, start.contact.slip))
    limit = static_limit(friction) * contact.normal
    return (
        friction.band - slip_sign * contact.slip,
        abs(contact.slip) - RELEASE_FACTOR * friction.band,
        abs(slip_sign) - abs(friction.sliding_sign),
        -slip_sign * contact.slip,
        contact.guard_quantity - limit,
        -contact.guard_quantity - limit,
        limit - contact.guard_quantity,
        limit + contact.guard_quantity,
    )


@contract.latched.member(Karnopp)
def _latched_karnopp(friction, event, contact, root):
    if event == REVERSES:
        return (-friction.sliding_sign,)
    return (math.copysign(1.0, contact.slip) if event in (SLIPS, DIRECTION_UNKNOWN) else 0.0,)


contract.register(
    "friction karnopp: stick-slip: below a sliding speed the surfaces stick",
    "above band: T = -N sgn(slip) (mu + (mu_s - mu) exp(-|slip / stribeck_velocity|^shape) + viscous |slip|); below: "
    "T stops the sliding, at most mu_s N either way, or the friction at the edge of the band if that is larger",
    "after Karnopp 1985, J. Dyn. Syst. Meas. Control 107:100; with the Stribeck effect",
    (
        COEFFICIENT,
        STATIC,
        *STRIBECK,
        Field("band", "m/s", "sliding speed below which the surfaces stick; choose it well below stribeck_velocity"),
    ),
    types=(Karnopp,),
    has_state=True,
    sticks=True,
    notes="T in the band follows from the motion: it makes the sliding speed decay at the crank's rate.  The "
    "remaining creep, below band, has no physical meaning.  The edge of the band is located; T jumps there.  Static "
    "friction is bounded by the load alone, so surfaces start to slide when their load falls.",
    orders=(
        KINETIC_FIRST,
        Order("band", "stribeck_velocity", "friction falls beyond what counts as sticking", equal=True),
    ),
)
