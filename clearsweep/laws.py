"""The laws a user can name: one block each, with all there is to say of it and what makes its compiled form.

To add a law of the form F = F_elastic (1 + chi u) is to add one block with its chi; any other law also needs a type and
a body in its family under `kernels`.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

from scipy.optimize import brentq

from .catalogue import Catalogue, Field, Law
from .kernels.friction import Ambrosio, Frictionless, Tanh
from .kernels.normal import Hysteresis, Linear, Lossless, Power, PowerThreeHalves, ViscousSpring
from .kernels.wear import Archard, NoWear


class Recipe(NamedTuple):
    """A law as the user sees it, and `make`, which turns its numbers (a dict in SI) into its compiled form."""

    law: Law
    make: Callable


RECIPES: dict[tuple[str, str], Recipe] = {}


def _enter(make: Callable, family: str, name: str, summary: str, formula: str, source: str, *fields: Field, **rest):
    RECIPES[family, name] = Recipe(Law(family, name, summary, formula, source, fields, **rest), make)


# ---------------------------------------------------------------------------------------------- normal force


def exact_factor(restitution: float) -> float:
    """Return the chi with which a free impact gives back exactly `restitution`, for any exponent, stiffness and mass.

    The root of ln((1 + chi) / (1 - e chi)) = chi (1 + e) in (0, 1/e), from the phase curve of m x'' = -K x^n (1 + chi u)
    integrated from u = 1 to u = -e.
    """
    if restitution == 1.0:
        return 0.0
    if 1.0 - restitution < 1e-5:  # the root is lost in rounding; two terms of its series are exact to 1e-15
        return 1.5 * (1.0 - restitution) * (2.0 - restitution)

    def excess(s):  # 1 - e chi = exp(-s) keeps the root away from the singular end
        chi = -math.expm1(-s) / restitution
        return math.log1p(chi) + s - chi * (1.0 + restitution)

    return -math.expm1(-brentq(excess, 1e-9, 800.0, xtol=1e-15, rtol=1e-15)) / restitution


def _restitution(low_open: bool) -> Field:
    return Field("restitution", "1", "wanted ratio of rebound to approach speed", 0.0, 1.0, low_open, False)


def _factor_law(name, summary, chi_text, source, chi, low_open=False, notes=""):
    formula = f"F = F_elastic (1 + chi rate / onset_rate), chi = {chi_text}"

    def make(values):
        return Hysteresis(float(chi(values["restitution"])))

    _enter(make, "law", name, summary, formula, source, _restitution(low_open), notes=notes)


_enter(lambda values: Lossless(), "law", "hertz", "no loss", "F = F_elastic", "Hertz 1881, J. reine angew. Math. 92:156")
_factor_law(
    "lankarani-nikravesh", "hysteresis for restitution near 1", "3 (1 - e^2) / 4",
    "Lankarani & Nikravesh 1990, J. Mech. Des. 112:369", lambda e: 0.75 * (1.0 - e * e),
    notes="First-order exact as e -> 1; below about 0.9 it gives back more than asked for, never less than 0.663.",
)  # fmt: skip
_factor_law(
    "hunt-crossley", "the oldest of its form, for restitution near 1", "3 (1 - e) / 2",
    "Hunt & Crossley 1975, J. Appl. Mech. 42:440", lambda e: 1.5 * (1.0 - e),
    notes="First-order exact as e -> 1; never gives back less than 0.488.",
)  # fmt: skip
_factor_law(
    "flores", "for the whole range of restitution", "8 (1 - e) / (5 e)",
    "Flores, Machado, Silva & Martins 2011, Multibody Syst. Dyn. 25:357", lambda e: 1.6 * (1.0 - e) / e, True,
    notes="6.7 % too dissipative as e -> 1.",
)  # fmt: skip
_factor_law(
    "exact", "gives back exactly the restitution asked for", "the root of ln((1 + chi)/(1 - e chi)) = chi (1 + e)",
    "phase curve of the free impact; the exact form of Gonthier et al. 2004, Multibody Syst. Dyn. 11:209",
    exact_factor, True,
)  # fmt: skip
_enter(
    lambda values: ViscousSpring(values["damping"]), "law", "kelvin-voigt", "linear spring and damper",
    "F = max(0, k pen + c rate)", "Kelvin-Voigt; clipped at zero",
    Field("stiffness", "N/m", "of the spring"), Field("damping", "N*s/m", "of the damper", low_open=False),
    uses_elastic=False,
    notes="The force jumps to c times the onset rate at contact and is clipped where it would pull, which gives back more "
    "than exp(-pi zeta / sqrt(1 - zeta^2)).",
)  # fmt: skip


def _make_power(values):
    stiffness, exponent = values["stiffness"], values["exponent"]
    if exponent == 1.5:
        return PowerThreeHalves(stiffness)
    return Linear(stiffness) if exponent == 1.0 else Power(stiffness, exponent)


_enter(
    _make_power, "elastic", "power", "a power of the penetration", "F_elastic = K pen^n", "Hertz 1881 for n = 1.5",
    Field("stiffness", "N/m^exponent", "K; follows from `material` where that is given instead and n = 1.5"),
    Field("exponent", "1", "n", default=1.5),
    notes="With `material`, K = (4/3) E* sqrt(R_b R_j / (R_b - R_j)): a ball in a socket, whatever the length of the pin; "
    "it grows without bound as the clearance shrinks.",
)  # fmt: skip

# ---------------------------------------------------------------------------------------------- friction

_COEFFICIENT = Field("coefficient", "1", "of friction, mu", low_open=False)
_enter(
    lambda values: Tanh(values["coefficient"], values["velocity_scale"]), "friction", "tanh", "smooth Coulomb friction",
    "T = -mu N tanh(slip / velocity_scale)", "regularised Coulomb friction", _COEFFICIENT,
    Field("velocity_scale", "m/s", "sliding speed at which 76 % of the friction acts"),
    notes="Creeps where it should stick.",
)  # fmt: skip
_enter(
    lambda values: Ambrosio(values["coefficient"], values["v0"], values["v1"]), "friction", "ambrosio",
    "Coulomb friction with a dead band", "T = -mu N sgn(slip) min(1, max(0, (|slip| - v0) / (v1 - v0)))",
    "Ambrosio 2003, in Virtual Nonlinear Multibody Systems, NATO Science Series 103", _COEFFICIENT,
    Field("v0", "m/s", "no friction below this sliding speed", low_open=False),
    Field("v1", "m/s", "full friction above this sliding speed"),
    notes="No friction at all within the dead band: parts creep.",
)  # fmt: skip

# ---------------------------------------------------------------------------------------------- wear

_enter(
    None, "wear", "archard", "depth grows with pressure and sliding", "dh = k p |slip| dt",
    "Archard 1953, J. Appl. Phys. 24:981",
    notes="k in m^2/N; 1 mm^3/(N m) = 1e-9 m^2/N.  k times the hardness must be far below 1.",
)  # fmt: skip
_enter(
    None, "pressure", "hertz-line", "Hertzian line contact", "half-width a = sqrt(4 f R / (pi E*)), f = F / length",
    "Johnson 1985, Contact Mechanics, section 4.2(c)",
    notes="E* from `material`; without it from the stiffness of the power law, E* = 3 K / (4 sqrt(R)).",
)  # fmt: skip


def catalogue() -> Catalogue:
    """Return all laws a grid can name."""
    return Catalogue(tuple(recipe.law for recipe in RECIPES.values()))


def plane_strain_modulus(material: dict) -> float:
    """Return E* (Pa) of two bodies of one material: 1/E* = 2 (1 - nu^2) / E (Johnson 1985, 4.24)."""
    return material["young"] / (2.0 * (1.0 - material["poisson"] ** 2))


def relative_radius(joint: dict) -> float:
    """Return R_b R_j / (R_b - R_j) in m of a joint section of a case."""
    bearing = joint["bearing_radius"]
    return bearing * (bearing - joint["clearance"]) / joint["clearance"]


def material_stiffness(joint: dict) -> float:
    """Return (4/3) E* sqrt(R) in N/m^1.5, the sphere-in-socket stiffness of a joint from its material and radii.

    Flores, Ambrosio, Claro & Lankarani 2008, Kinematics and Dynamics of Multibody Systems with Imperfect Joints, (3.4).
    """
    return 4.0 / 3.0 * plane_strain_modulus(joint["contact"]["material"]) * math.sqrt(relative_radius(joint))


def contact_terms(joint: dict) -> tuple:
    """Return the compiled form of (law, elastic) of a joint section of a case."""
    values = dict(joint["contact"])
    if "stiffness" not in values and "material" in values:
        values["stiffness"] = material_stiffness(joint)
    law = RECIPES["law", values["law"]]
    if not law.law.uses_elastic:
        return law.make(values), Linear(values["stiffness"])
    return law.make(values), RECIPES["elastic", values["elastic"]].make(values)


def friction_term(joint: dict):
    """Return the compiled form of the friction of a joint section of a case."""
    friction = joint.get("friction")
    return RECIPES["friction", friction["law"]].make(friction) if friction else Frictionless()


def wear_term(joint: dict):
    """Return the compiled form of the wear of a joint section of a case."""
    wear, contact = joint.get("wear"), joint["contact"]
    if not wear:
        return NoWear()
    radius = relative_radius(joint)
    if "material" in contact:
        modulus = plane_strain_modulus(contact["material"])
    else:
        modulus = 3.0 * contact["stiffness"] / (4.0 * math.sqrt(radius))
    return Archard(wear["bearing_coefficient"], wear["journal_coefficient"], float(wear["bins"]), joint["length"],
                   modulus, radius)  # fmt: skip
