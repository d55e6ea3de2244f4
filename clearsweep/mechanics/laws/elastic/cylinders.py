"""Line contact of two cylinders, one in the other.

E* is the modulus of the pair, 1 / E* = (1 - nu_b^2) / E_b + (1 - nu_j^2) / E_j, c the radial clearance, L the length of
the joint, R_b and R_j the radii of bearing and journal.
"""

from collections.abc import Callable
from typing import NamedTuple

from ....contracts.case import Joint
from ....contracts.catalogue import Field, Law, Merit, Range
from ....tracing.compiled import calculus as math
from ....tracing.compiled.family import kernel
from ...joints.material import line_modulus
from ...joints.recipe import register
from .contract import CYLINDER_NEEDS, SMALL_ARC, elastic_energy, elastic_force, register_elastic_force
from .power import Power, derived_power

#: Where the tangent of pen = g F ln(S / F) is twice the secant, in units of g S.  The law folds back at exp(-1).
LOGARITHMIC_END = 2.0 * math.exp(-2.0)


class Logarithmic(NamedTuple):
    """pen = g F ln(S / F), the approach of two cylinders: the laws of this form differ only in their g and S."""

    stiffness: float  # 1 / g, N/m
    depth: float  # g S, m; the law folds back at exp(-1) of it


@kernel
def inverse_lambert(w):
    """Return 1 / v, v = -W(-w) of the lower branch of Lambert's function, the root v >= 2 of v exp(-v) = w.

    `w` : above 0, at most LOGARITHMIC_END.  Relative error below 1e-15: a rational function of the distance from the
    branch point, accurate to 4e-4, then one step of fourth order (Fritsch, Shafer & Crowley 1973, Commun. ACM 16:123).
    """
    q = -math.log(w)  # v - ln v = q
    r = math.sqrt(q - 1.0)
    v = 1.0 + r * (1.41612896 + r * (1.02969292 + r * 0.26107797)) / (1.0 + 0.26129776 * r)
    z = v - q - math.log(v)
    base = 1.0 - v
    quadratic = 2.0 * base * (base + 2.0 / 3.0 * z)
    denominator = base * (
        quadratic - 2.0 * z
    )  # v (1 + z (quadratic - z) / denominator) is the root; its inverse needs one division
    return denominator / (v * (denominator + z * (quadratic - z)))


@register_elastic_force(Logarithmic, is_odd=False)
def _logarithmic(elastic, pen):
    if pen <= 0.0:
        return 0.0
    w = pen / elastic.depth
    if w < LOGARITHMIC_END:
        return elastic.stiffness * pen * inverse_lambert(w)
    return elastic.stiffness * elastic.depth * (w - 0.5 * LOGARITHMIC_END)


@elastic_energy.member(Logarithmic)
def _elastic_energy_logarithmic(elastic, pen):
    """Return F pen minus the integral of pen = g F ln(S / F) over F, by parts: F pen / 2 + g F^2 / 4."""
    force = elastic_force(elastic, pen)
    if pen < LOGARITHMIC_END * elastic.depth:
        return 0.5 * force * pen - 0.25 * force * force / elastic.stiffness
    end_force = LOGARITHMIC_END * elastic.depth  # where F = pen / (2 g); beyond along the tangent 1 / g
    return 0.1875 * elastic.stiffness * end_force * end_force + 0.5 * (force + 0.5 * elastic.stiffness * end_force) * (
        pen - end_force
    )


def make_logarithmic(joint: Joint, depth: float) -> Logarithmic:
    """Return the Logarithmic law of a joint whose g S is `depth` (m)."""
    return Logarithmic(math.pi * line_modulus(joint), depth)


_FOLD = (
    "Folds back where pen = g S / e; beyond 0.736 times that, "
    "where the tangent stiffness is twice the secant, the force continues along the tangent."
)


def register_line_law(law: Law, make: Callable) -> None:
    """Register a law pen = g F ln(S / F), g = 1 / (pi E* L); make : joint -> Logarithmic, which has the law's S."""
    law = law._replace(notes=f"{law.notes}  {_FOLD}", trusted=(SMALL_ARC,))
    register(law, (Logarithmic,), make, limit=lambda joint: LOGARITHMIC_END * make(joint).depth)


def _make_johnson(joint, constant=-1.0):
    return make_logarithmic(joint, 4.0 * joint.clearance * math.exp(constant))


register_line_law(
    Law(
        "elastic",
        "johnson",
        "two cylinders, one in the other",
        "pen = F / (pi E* L) (ln(4 pi E* c L / F) - 1); F = pen / (g v), v the root of v exp(-v) = pen / (g S), v > 1",
        "after Johnson 1985, Contact Mechanics; solved for F by the lower branch of Lambert's W",
        contact="line",
        needs=CYLINDER_NEEDS,
        notes="Treats the bodies as half-spaces, so it is for small contact arcs.",
        merit=Merit(3, "it is the line contact of elastic half-spaces, and the arc is small"),
    ),
    _make_johnson,
)


register_line_law(
    Law(
        "elastic",
        "esdu-78035",
        "johnson with + 1 in place of - 1",
        "pen = F (h_b + h_j) / L (ln(4 L c / (F (h_b + h_j))) + 1), h = (1 - nu^2) / (pi E)",
        "after ESDU 78035, Contact phenomena I; not compared with the original",
        contact="line",
        needs=CYLINDER_NEEDS,
        notes="Some codes have a further factor pi, which is wrong.",
    ),
    lambda joint: _make_johnson(joint, 1.0),
)


def _make_radzimovsky(joint):
    # b^2 = 1.6^2 f k R / E* with R = R_b R_j / c leaves ln(4 R_b / b) + ln(4 R_j / b) = ln(16 E* c / (2.56 k f))
    width_factor_squared = 2.56 * joint.contact.values["curvature_factor"]
    return make_logarithmic(joint, 16.0 / width_factor_squared / math.pi * joint.clearance * math.exp(2.0 / 3.0))


register_line_law(
    Law(
        "elastic",
        "radzimovsky",
        "two cylinders, by Roark's formula",
        "pen = F / (pi E* L) (2/3 + ln(4 R_b / b) + ln(4 R_j / b)), b = 1.60 sqrt(F K_D / (L E*)), "
        "K_D = curvature_factor R_b R_j / (R_b - R_j)",
        "after Radzimovsky 1953, Univ. Illinois Eng. Exp. Station Bulletin 408; b as in Roark's Formulas for Stress "
        "and Strain",
        (
            Field(
                "curvature_factor",
                "1",
                "definition of K_D; 2: by diameters, as in Roark; 1: by radii, as in the multibody literature",
                1.0,
                2.0,
                False,
                False,
                default=2,
                integer=True,
            ),
        ),
        contact="line",
        needs=CYLINDER_NEEDS,
        notes="b is the full width of contact, and K_D uses diameters.  With radii, as often printed, b is too small "
        "by sqrt(2) and the force 6 to 13 % lower; curvature_factor 1 reproduces curves of the multibody literature.",
    ),
    _make_radzimovsky,
)


def _make_dubowsky_freudenstein(joint, power_of_length=3.0):
    radii = joint.bearing_radius * (joint.bearing_radius - joint.clearance)
    return make_logarithmic(joint, joint.length ** (power_of_length - 1.0) * joint.clearance / radii * math.e)


register_line_law(
    Law(
        "elastic",
        "dubowsky-freudenstein",
        "two cylinders, with the length in the logarithm",
        "pen = F (h_b + h_j) / L (ln(L^3 c / (F R_b R_j (h_b + h_j))) + 1), h = (1 - nu^2) / (pi E)",
        "after Dubowsky & Freudenstein 1971, J. Eng. Ind. 93:305",
        contact="line",
        needs=CYLINDER_NEEDS,
        unsound="the length in its logarithm has no physical basis",
        notes="The length in the logarithm has no physical basis; only its third power makes the argument "
        "dimensionless.",
    ),
    _make_dubowsky_freudenstein,
)


register_line_law(
    Law(
        "elastic",
        "goldsmith",
        "dubowsky-freudenstein with the length to the first power",
        "pen = F (h_b + h_j) / L (ln(L c / (F R_b R_j (h_b + h_j)) m^2) + 1), h = (1 - nu^2) / (pi E)",
        "after Goldsmith 1960, Impact",
        contact="line",
        needs=CYLINDER_NEEDS,
        unsound="dimensionally inconsistent",
        notes="Dimensionally inconsistent: the argument of the logarithm has the unit 1/m^2.  Here all lengths are in "
        "metres; in millimetres the law gives other forces.",
    ),
    lambda joint: _make_dubowsky_freudenstein(joint, 1.0),
)


def _make_pereira(joint):
    clearance = joint.clearance * 1e3  # mm, like all lengths of the fit; moduli in MPa
    y = 1.51 * math.log(1e3 * clearance) ** -0.151 if clearance < 0.34954 else 0.0151 * clearance + 1.151
    exponent = y * clearance**-0.005
    stiffness = (0.965 * clearance + 0.0965) * line_modulus(joint) * 1e-3 / clearance  # N/mm^n
    return Power(stiffness * 1e3**exponent, exponent)


register(
    Law(
        "elastic",
        "pereira",
        "a power fitted to two cylinders, one in the other",
        "F_elastic = (0.965 c + 0.0965) L E* / c pen^n in mm, N, MPa; n = Y c^-0.005, Y = 1.51 ln(1000 c)^-0.151 for "
        "c < 0.34954 mm, else 0.0151 c + 1.151",
        "after Pereira, Ramalho & Ambrosio 2011, Nonlinear Dyn. 63:681, internal contact",
        contact="line",
        needs=CYLINDER_NEEDS,
        ranges=(Range("clearance", 5e-6, 1e-2, "m", "it was fitted there"),),
        notes="Dimensionally inconsistent: a fit with all lengths in millimetres.  n = (Y c)^-0.005, found in some "
        "codes, is wrong.",
    ),
    (Power,),
    _make_pereira,
    derived=lambda joint: derived_power(_make_pereira(joint)),
)
