"""Bristle models of friction, with the bristle deflection as internal state."""

from collections.abc import Mapping
from typing import NamedTuple

from ...contracts.catalogue import Field, ranged
from ...tracing.compiled import calculus as math
from ...tracing.compiled.choosing import where
from ...tracing.compiled.family import family, kernel
from . import contract
from .friction import (
    COEFFICIENT,
    KINETIC_FIRST,
    STATIC,
    STRIBECK,
    friction_force,
    settled_state,
    stribeck_coefficient,
)

SLIDING = COEFFICIENT._replace(low_open=True)
BRISTLES = Field("bristle_stiffness", "1/m", "stiffness of the bristles per load, sigma0")


@kernel
def sign_of(slip):
    """Return the sign of a sliding speed, 0 at rest."""
    return where(slip > 0.0, 1.0, where(slip < 0.0, -1.0, 0.0))


def _bristle_state(friction):
    return (contract.InternalState(friction.coefficient / friction.bristle_stiffness, False),)


class Dahl(NamedTuple):
    """T = -N sigma0 z with bristles bent by z: z' = slip (1 - x)^shape, x = sigma0 z sgn(slip) / mu.

    The energy balance counts all work of T as dissipated, including energy stored in bristles, until it is returned.
    """

    coefficient: float  # mu, 1
    bristle_stiffness: float  # sigma0, 1/m, per load
    shape: float  # 1
    bend: float = 0.0  # z, m


friction_force.member(Dahl)(lambda friction, normal, slip: -normal * friction.bristle_stiffness * friction.bend)
settled_state.member(Dahl)(lambda friction, slip: (friction.coefficient * sign_of(slip) / friction.bristle_stiffness,))
contract.internal_state.member(Dahl)(_bristle_state)
contract.register_kinks(Dahl, contract.slip_variable, contract.zero_kink)


@contract.internal_rates.member(Dahl)
def _internal_rates_dahl(friction, contact):
    slip = contact.slip
    bend_deficit = 1.0 - friction.bristle_stiffness * friction.bend * math.copysign(1.0, slip) / friction.coefficient
    return (slip * math.copysign(abs(bend_deficit) ** friction.shape, bend_deficit),)


contract.register(
    "friction dahl: bending bristles: elastic before sliding",
    "T = -N sigma0 z, z' = slip sgn(1 - x) |1 - x|^shape with x = sigma0 z sgn(slip) / mu",
    "after Dahl 1968, A Solid Friction Model, Aerospace Corp. TOR-0158(3107-18)-1; per load",
    (
        SLIDING,
        BRISTLES,
        ranged(
            "shape",
            "1",
            "exponent of the approach to sliding; 1: exponential, larger: slower",
            "[1, inf)",
            default=1.0,
        ),
    ),
    types=(Dahl,),
    has_state=True,
    notes="z, the deflection of the bristles, begins at 0 with every contact.  No static friction above the kinetic "
    "one; creeps under an alternating load.  A shape below 1, with a corner at the onset of sliding, is not "
    "available.  Friction settles within mu / sigma0 of sliding: 1 um with mu = 0.1 and 1e5 1/m, which is stiff.  "
    "Energy in the bristles counts as friction loss until they return it.  The force is proportional to the load, so "
    "a varying load can draw energy from bent bristles, up to mu^2 / (2 sigma0) times its change.",
)


class LuGre(NamedTuple):
    """T = -N (sigma0 z + sigma1(slip) z' + viscous slip), z' = slip - sigma0 |slip| z / g(slip); energy as in Dahl."""

    coefficient: float  # kinetic, 1
    static_coefficient: float  # 1
    stribeck_velocity: float  # m/s
    shape: float  # 1
    viscous: float  # s/m
    bristle_stiffness: float  # sigma0, 1/m, per load
    bristle_damping: float  # sigma1 at rest, s/m, per load
    damping_velocity: float  # m/s, sigma1 falls with exp(-(slip / damping_velocity)^2)
    bend: float = 0.0  # z, m


@family
def bend_rate(friction, slip):
    """Return the rate (m/s) of deflection of damped bristles at sliding speed `slip` (m/s)."""


@bend_rate.member(LuGre)
def _bend_rate_lugre(friction, slip):
    return slip - friction.bristle_stiffness * abs(slip) * friction.bend / stribeck_coefficient(friction, slip)


@friction_force.member(LuGre)
def _friction_force_lugre(friction, normal, slip):
    decay = math.exp(-((slip / friction.damping_velocity) ** 2))
    coefficient = friction.bristle_stiffness * friction.bend
    coefficient += friction.bristle_damping * decay * bend_rate(friction, slip)
    return -normal * (coefficient + friction.viscous * slip)


@settled_state.member(LuGre)
def _settled_state_damped(friction, slip):
    return (stribeck_coefficient(friction, slip) * sign_of(slip) / friction.bristle_stiffness,)


contract.internal_state.member(LuGre)(_bristle_state)
contract.register_kinks(LuGre, contract.slip_variable, contract.zero_kink)


@contract.internal_rates.member(LuGre)
def _internal_rates_lugre(friction, contact):
    return (bend_rate(friction, contact.slip),)


def passive_velocity(friction: Mapping[str, float]) -> float:
    """Return the largest damping_velocity (m/s) for which damped bristles are passive.

    They are passive if sigma1 exp(-(v / v_d)^2) <= 4 g(v) / |v|; the left side times |v| is at most
    sigma1 v_d / sqrt(2 e).
    """
    least_coefficient = min(friction["coefficient"], friction["static_coefficient"])
    damping = friction["bristle_damping"]
    return 4.0 * math.sqrt(2.0 * math.e) * least_coefficient / damping if damping > 0.0 else math.inf


def _maker_with_damping_velocity(law_type):
    """Return a function that creates a law from a joint; damping_velocity defaults to the passive one."""

    def make(joint):
        parameters = joint.friction.values
        values = {"damping_velocity": passive_velocity(parameters)} | parameters
        return law_type(*(values[name] for name in law_type._fields if name not in law_type._field_defaults))

    return make


DAMPED_BRISTLES = (
    SLIDING,
    STATIC._replace(low_open=True),
    *STRIBECK,
    BRISTLES,
    ranged("bristle_damping", "s/m", "damping of the bristles per load, at zero sliding speed, sigma1", "[0, inf)"),
    Field(
        "damping_velocity",
        "m/s",
        "sliding speed over which the damping falls; default: the largest value at which the bristles never drive the "
        "slip",
        optional=True,
    ),
)


contract.register(
    "friction lugre: bending bristles with the Stribeck effect: sticks, breaks away, slides",
    "T = -N (sigma0 z + sigma1 exp(-(slip / damping_velocity)^2) z' + viscous slip), z' = slip - sigma0 |slip| z / g, "
    "g = mu + (mu_s - mu) exp(-|slip / stribeck_velocity|^shape)",
    "after Canudas de Wit, Olsson, Astrom & Lischinsky 1995, IEEE Trans. Autom. Control 40:419; per load, the falling "
    "damping after Olsson 1996, Control Systems with Friction, Lund",
    DAMPED_BRISTLES,
    types=(LuGre,),
    make=_maker_with_damping_velocity(LuGre),
    has_state=True,
    notes="z, the deflection of the bristles, begins at 0 with every contact.  With a damping that does not fall, a "
    "large damping_velocity, the bristles drive where sigma1 > 4 g / |slip|: from 1.3 mm/s on with mu = 0.1, sigma1 = "
    "316 s/m; left out, damping_velocity is 4 sqrt(2 e) min(mu, mu_s) / sigma1 and they never do under a steady "
    "load.  Common values are sigma0 = 1e5 1/m and sigma1 = 316 s/m.  Friction settles within g / sigma0 of sliding: "
    "1 um, which is stiff.  Energy in the bristles counts as friction loss until they return it.  The force is "
    "proportional to the load, so a varying load can draw energy from bent bristles, up to g^2 / (2 sigma0) times its "
    "change.",
    orders=(KINETIC_FIRST,),
)


class ElastoPlastic(NamedTuple):
    """LuGre with z' = slip (1 - a sigma0 z sgn(slip) / g), where a is 0 up to a bend and 1 from g / sigma0 on."""

    coefficient: float  # kinetic, 1
    static_coefficient: float  # 1
    stribeck_velocity: float  # m/s
    shape: float  # 1
    viscous: float  # s/m
    bristle_stiffness: float  # sigma0, 1/m, per load
    bristle_damping: float  # sigma1 at rest, s/m, per load
    elastic_share: float  # sigma0 times the elastic limit of deflection, over the kinetic coefficient, 1
    damping_velocity: float  # m/s
    bend: float = 0.0  # z, m


contract.guards.member(ElastoPlastic)(lambda friction: (contract.Guard(contract.TOUCHING),) * 6)


@contract.guard_values.member(ElastoPlastic)
def _guard_values_elasto_plastic(friction, start, contact, root):
    """Return guards for zero slip, and for both ends of the range of bends in which part of the slip is plastic."""
    elastic_limit = friction.elastic_share * friction.coefficient
    sliding_force = stribeck_coefficient(friction, contact.slip)
    sliding_force_before = stribeck_coefficient(friction, start.contact.slip)
    return (
        *contract.distances_past_kinks((0.0,), start.contact.slip, contact.slip),
        *contract.distances_past_kinks((0.0,), _excess(start.law, elastic_limit), _excess(friction, elastic_limit)),
        *contract.distances_past_kinks(
            (0.0,), _excess(start.law, sliding_force_before), _excess(friction, sliding_force)
        ),
    )


@kernel
def _excess(friction, coefficient):
    """Return how far the square of the bristles' force, over that of a coefficient, is above 1."""
    return (friction.bristle_stiffness * friction.bend / coefficient) ** 2 - 1.0


@bend_rate.member(ElastoPlastic)
def _bend_rate_elasto_plastic(friction, slip):
    bristle_force = (
        friction.bristle_stiffness * friction.bend * math.copysign(1.0, slip)
    )  # negative while bristles relax
    sliding_force = stribeck_coefficient(friction, slip)
    elastic_limit = friction.elastic_share * friction.coefficient
    transition = math.sin(
        0.5 * math.pi * min(max((bristle_force - elastic_limit) / (sliding_force - elastic_limit), 0.0), 1.0)
    )
    return slip * (1.0 - transition * transition * bristle_force / sliding_force)


friction_force.member(ElastoPlastic)(_friction_force_lugre)
settled_state.member(ElastoPlastic)(_settled_state_damped)
contract.internal_state.member(ElastoPlastic)(_bristle_state)
contract.internal_rates.member(ElastoPlastic)(_internal_rates_lugre)


contract.register(
    "friction elasto-plastic: the bristles of lugre without creep: elastic up to a fraction of the friction",
    "T = -N (sigma0 z + sigma1 exp(-(slip / damping_velocity)^2) z' + viscous slip), z' = slip (1 - a x / g), x = "
    "sigma0 z sgn(slip), g = mu + (mu_s - mu) exp(-|slip / stribeck_velocity|^shape); a = 0 up to x = elastic_share "
    "mu, 1 from x = g on, (1 + sin(pi (x - m) / d)) / 2 between, m the mean of these two and d their difference",
    "after Dupont, Hayward, Armstrong & Altpeter 2002, IEEE Trans. Autom. Control 47:787, as in public programs that "
    "quote it; per load, the falling damping after Olsson 1996, Control Systems with Friction, Lund",
    (
        *DAMPED_BRISTLES,
        ranged(
            "elastic_share",
            "1",
            "friction relative to mu N up to which all displacement is elastic; the default is a choice",
            "(0, 1)",
            default=0.7,
        ),
    ),
    types=(ElastoPlastic,),
    make=_maker_with_damping_velocity(ElastoPlastic),
    has_state=True,
    notes="Under an alternating force below elastic_share mu N no displacement remains; lugre, whose a is 1 "
    "throughout, creeps.  Otherwise as lugre: z begins at 0 with every contact; left out, damping_velocity is 4 "
    "sqrt(2 e) mu / sigma1, with which the bristles never drive under a steady load; friction settles within g / "
    "sigma0 of sliding: 1 um with mu = 0.1 and sigma0 = 1e5 1/m, which is stiff; energy in the bristles counts as "
    "friction loss until they return it.",
    orders=(KINETIC_FIRST,),
)
