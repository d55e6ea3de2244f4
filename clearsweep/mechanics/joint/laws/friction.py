"""Friction laws: the tangential force over sliding speed, and over bristles that remember how far they are bent."""

import math
from collections.abc import Mapping

from ....catalogue import Field
from ..friction.bristles import Dahl, LuGre
from ..friction.sliding import Ambrosio, BengisuAkay, Stribeck, Tanh, Threlfall
from ..friction.stick import Karnopp
from .recipe import enter

COEFFICIENT = Field("coefficient", "1", "of kinetic friction, mu", low_open=False)
STATIC = Field("static_coefficient", "1", "of static friction, mu_s", low_open=False)
SCALE = Field("velocity_scale", "m/s", "sliding speed at which 76 % of the friction acts")


def _maker(form, *names):
    return lambda joint: form(*(joint.friction.values[name] for name in names))


def _enter(name, summary, formula, source, form, *fields, notes):
    """Enter a friction law whose compiled form takes its fields in their order."""
    make = _maker(form, *(field.name for field in fields))
    enter("friction", name, summary, formula, source, make, *fields, notes=notes)


_enter(
    "tanh",
    "smooth Coulomb friction",
    "T = -mu N tanh(slip / velocity_scale)",
    "regularised Coulomb friction",
    Tanh,
    COEFFICIENT,
    SCALE,
    notes="Creeps where it should stick.",
)
_enter(
    "coulomb",
    "the same as tanh",
    "T = -mu N sgn(slip), the sign smoothed to tanh(slip / velocity_scale)",
    "Coulomb 1785; regularised",
    Tanh,
    COEFFICIENT,
    SCALE,
    notes="The jump at rest is smoothed: it creeps where it should stick, the less the smaller velocity_scale.",
)
_enter(
    "ambrosio",
    "Coulomb friction with a dead band",
    "T = -mu N sgn(slip) min(1, max(0, (|slip| - v0) / (v1 - v0)))",
    "Ambrosio 2003, in Virtual Nonlinear Multibody Systems, NATO Science Series 103",
    Ambrosio,
    COEFFICIENT,
    Field("v0", "m/s", "no friction below this sliding speed", low_open=False),
    Field("v1", "m/s", "full friction above this sliding speed"),
    notes="No friction at all within the dead band: parts creep.",
)
_enter(
    "threlfall",
    "Coulomb friction with an exponential rise",
    "T = -mu N sgn(slip) (1 - exp(-3 |slip| / velocity_scale)) / 0.95 up to velocity_scale, -mu N sgn(slip) above",
    "after Threlfall 1978, Mech. Mach. Theory 13:475",
    Threlfall,
    COEFFICIENT,
    Field("velocity_scale", "m/s", "full friction above this sliding speed"),
    notes="As published it jumps by 0.02 % at velocity_scale, where the rise has reached 1.000224.  Creeps where "
    "it should stick.",
)
_enter(
    "bengisu-akay",
    "static friction that falls to kinetic friction",
    "T = -N sgn(slip) mu_s (1 - (|slip| - v)^2 / v^2) up to v = velocity_scale, "
    "-N sgn(slip) (mu + (mu_s - mu) exp(-decay (|slip| - v))) above",
    "after Bengisu & Akay 1994, J. Sound Vib. 171:557",
    BengisuAkay,
    COEFFICIENT,
    STATIC,
    Field("velocity_scale", "m/s", "sliding speed at which the static friction is reached"),
    Field("decay", "s/m", "how fast it falls from static to kinetic friction beyond", low_open=False),
    notes="Creeps where it should stick.",
)
_enter(
    "stribeck",
    "smooth friction with Stribeck's fall and a viscous part",
    "T = -N ((mu + (mu_s - mu) exp(-|slip / stribeck_velocity|^shape)) tanh(slip / velocity_scale) + viscous slip)",
    "Stribeck 1902, Z. VDI 46:1341, in the form of Armstrong-Helouvry, Dupont & Canudas de Wit 1994, Automatica "
    "30:1083; regularised",
    Stribeck,
    COEFFICIENT,
    STATIC,
    Field("stribeck_velocity", "m/s", "sliding speed over which friction falls from static to kinetic"),
    Field("shape", "1", "2: a Gaussian fall, 1: an exponential one", default=2.0),
    Field("viscous", "s/m", "growth of the coefficient with the sliding speed", low_open=False, default=0.0),
    SCALE,
    notes="Creeps where it should stick; velocity_scale should be well below stribeck_velocity, else the static "
    "friction is never reached.",
)

_enter(
    "karnopp",
    "sticks: below a sliding speed the surfaces hold each other",
    "above band: T = -N sgn(slip) (mu + (mu_s - mu) exp(-|slip / stribeck_velocity|^shape) + viscous |slip|); below: "
    "T is what stops the sliding, at most mu_s N either way, or what slides at the edge of the band if that is more",
    "after Karnopp 1985, J. Dyn. Syst. Meas. Control 107:100; with Stribeck's fall",
    Karnopp,
    COEFFICIENT,
    STATIC,
    Field("stribeck_velocity", "m/s", "sliding speed over which friction falls from static to kinetic"),
    Field("shape", "1", "2: a Gaussian fall, 1: an exponential one", default=2.0),
    Field("viscous", "s/m", "growth of the coefficient with the sliding speed", low_open=False, default=0.0),
    Field("band", "m/s", "sliding speed below which the surfaces stick; well below stribeck_velocity"),
    notes="T in the band follows from the motion: it makes the sliding speed die away with the crank's rate, so what "
    "is left of it, less than band, is a creep of no meaning.  The edge of the band is located; T jumps there.  "
    "Static friction is bounded by the load alone, so surfaces let go when the load on them falls.",
)

# ---------------------------------------------------------------------------------------------- with a memory

SLIDING = COEFFICIENT._replace(low_open=True)
BRISTLES = Field("bristle_stiffness", "1/m", "force of the bristles per load and bend, sigma0")

_enter(
    "dahl",
    "bristles that bend: elastic before it slides",
    "T = -N sigma0 z, z' = slip sgn(1 - x) |1 - x|^shape with x = sigma0 z sgn(slip) / mu",
    "after Dahl 1968, A Solid Friction Model, Aerospace Corp. TOR-0158(3107-18)-1; per load",
    Dahl,
    SLIDING,
    BRISTLES,
    Field("shape", "1", "1: exponential approach to sliding; larger: slower", 1.0, low_open=False, default=1.0),
    notes="z, the bend of the bristles, begins at 0 with every contact.  No static friction above the kinetic one; "
    "creeps under a load that comes and goes.  A shape below 1, which reaches sliding with a corner, is not offered.  "
    "Friction settles within mu / sigma0 of sliding: 1 um with mu = 0.1 and 1e5 1/m, which is stiff.  What the "
    "bristles store counts as rubbed off until they give it back; as the force goes with the load, a load that changes "
    "can draw energy from bent bristles, up to mu^2 / (2 sigma0) of it.",
)


def passive_velocity(friction: Mapping[str, float]) -> float:
    """Return the largest damping_velocity (m/s) with which LuGre's bristles never drive.

    They do not while sigma1 exp(-(v / v_d)^2) <= 4 g(v) / |v|; the left side times |v| is at most
    sigma1 v_d / sqrt(2 e).
    """
    least = min(friction["coefficient"], friction["static_coefficient"])
    damping = friction["bristle_damping"]
    return 4.0 * math.sqrt(2.0 * math.e) * least / damping if damping > 0.0 else math.inf


def _lugre(joint):
    friction = joint.friction.values
    names = (name for name in LuGre._fields if name not in ("damping_velocity", "bend"))
    velocity = friction.get("damping_velocity", passive_velocity(friction))
    return LuGre(*(friction[name] for name in names), velocity)


enter(
    "friction",
    "lugre",
    "bristles that bend, with Stribeck's fall: sticks, breaks away, slides",
    "T = -N (sigma0 z + sigma1 exp(-(slip / damping_velocity)^2) z' + viscous slip), z' = slip - sigma0 |slip| z / g, "
    "g = mu + (mu_s - mu) exp(-|slip / stribeck_velocity|^shape)",
    "after Canudas de Wit, Olsson, Astrom & Lischinsky 1995, IEEE Trans. Autom. Control 40:419; per load, the falling "
    "damping after Olsson 1996, Control Systems with Friction, Lund",
    _lugre,
    SLIDING,
    STATIC._replace(low_open=True),
    Field("stribeck_velocity", "m/s", "sliding speed over which friction falls from static to kinetic"),
    Field("shape", "1", "2: a Gaussian fall, 1: an exponential one", default=2.0),
    Field("viscous", "s/m", "growth of the coefficient with the sliding speed", low_open=False, default=0.0),
    BRISTLES,
    Field("bristle_damping", "s/m", "of the bristles at rest per load, sigma1", low_open=False),
    Field(
        "damping_velocity",
        "m/s",
        "sliding speed over which the damping falls; left out: the largest with which it never drives",
        optional=True,
    ),
    notes="z, the bend of the bristles, begins at 0 with every contact.  With a damping that does not fall, a large "
    "damping_velocity, the bristles drive where sigma1 > 4 g / |slip|: from 1.3 mm/s on with mu = 0.1, sigma1 = 316 "
    "s/m; left out, damping_velocity is 4 sqrt(2 e) min(mu, mu_s) / sigma1 and they never do under a steady load.  "
    "In use are sigma0 = 1e5 1/m, sigma1 = 316 s/m.  Friction settles within g / sigma0 of sliding: 1 um, which is "
    "stiff.  What the bristles store counts as rubbed off until they give it back; as the force goes with the load, "
    "a load that changes can draw energy from bent bristles, up to g^2 / (2 sigma0) of it.",
)
