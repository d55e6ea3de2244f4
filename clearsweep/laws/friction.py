"""Friction laws: the tangential force over sliding speed; none has a memory."""

from ..catalogue import Field
from ..kernels.friction import Ambrosio, BengisuAkay, Stribeck, Tanh, Threlfall
from .recipe import enter

COEFFICIENT = Field("coefficient", "1", "of kinetic friction, mu", low_open=False)
STATIC = Field("static_coefficient", "1", "of static friction, mu_s", low_open=False)
SCALE = Field("velocity_scale", "m/s", "sliding speed at which 76 % of the friction acts")


def _maker(form, *names):
    return lambda joint: form(*(joint["friction"][name] for name in names))


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
