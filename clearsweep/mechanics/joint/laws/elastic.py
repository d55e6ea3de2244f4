"""Elastic laws: the normal force over penetration, from numbers the user gives or from radii, length and material.

E* is the modulus of the pair, 1 / E* = (1 - nu_b^2) / E_b + (1 - nu_j^2) / E_j, c the radial clearance, L the length of
the joint, R_b and R_j the radii of bearing and journal.
"""

import functools
import math

import numpy as np

from ....case import Joint
from ....catalogue import Field, Range
from ....errors import InputError
from ..elastic.conformal import CONFORMAL_END, Conformal, Foundation, Liu, LiuTangent, conformal_load
from ..elastic.cylinders import LOGARITHMIC_END, Logarithmic
from ..elastic.power import Linear, Power, PowerThreeHalves
from .material import line_modulus, material_stiffness
from .recipe import enter

NEEDS = ("length", "material")


def power(stiffness: float, exponent: float):
    """Return the cheapest form of K pen^n."""
    if exponent == 1.5:
        return PowerThreeHalves(stiffness)
    return Linear(stiffness) if exponent == 1.0 else Power(stiffness, exponent)


def _derived_stiffness(stiffness: float, exponent: float) -> dict:
    unit = f"N/m^{exponent:.6g}" if exponent != 1.0 else "N/m"
    return {"contact.stiffness": (stiffness, unit)}


def _derived_power(term: Power) -> dict:
    return _derived_stiffness(term.stiffness, term.exponent) | {"contact.exponent": (term.exponent, "1")}


def _given_stiffness(joint):
    stiffness = joint.contact.values.get("stiffness")
    return material_stiffness(joint) if stiffness is None else stiffness


enter(
    "elastic",
    "power",
    "a power of the penetration",
    "F_elastic = K pen^n",
    "Hertz 1881 for n = 1.5",
    lambda joint: power(_given_stiffness(joint), joint.contact.values["exponent"]),
    Field("stiffness", "N/m^exponent", "K; follows from `material` where that is given instead and n = 1.5"),
    Field("exponent", "1", "n", default=1.5),
    derived=lambda joint: (
        {}
        if "stiffness" in joint.contact.values
        else _derived_stiffness(material_stiffness(joint), joint.contact.values["exponent"])
    ),
    notes="With `material`, K = (4/3) E* sqrt(R_b R_j / (R_b - R_j)): a ball in a socket, whatever the length of "
    "the pin; it grows without bound as the clearance shrinks.  Papers that write h = (1 - nu^2) / (pi E) "
    "have a pi in K; mixing the two is a factor of pi.",
)


enter(
    "elastic",
    "lankarani-nikravesh-cylindrical",
    "the sphere's stiffness with another exponent",
    "F_elastic = (4/3) E* sqrt(R_b R_j / (R_b - R_j)) pen^n",
    "after Lankarani & Nikravesh 1994, Nonlinear Dyn. 5:193; as found in multibody codes",
    lambda joint: power(material_stiffness(joint), joint.contact.values["exponent"]),
    Field("exponent", "1", "n", 1.0, 1.5, False, False, default=1.5),
    needs=("material",),
    derived=lambda joint: _derived_stiffness(material_stiffness(joint), joint.contact.values["exponent"]),
    notes="Dimensionally inconsistent unless n = 1.5: the penetration is in metres.  It knows no length.",
)

# ---------------------------------------------------------------------------------------------- line contact

_FOLD = (
    "Folds back where pen = g S / e; beyond 0.736 times that, where the tangent stiffness is twice the secant, the "
    "force goes on along the tangent."
)


def _logarithmic_limit(term: Logarithmic) -> float:
    return LOGARITHMIC_END * term.depth


def _line_law(name, summary, formula, source, make, notes):
    """Enter a law pen = g F ln(S / F), g = 1 / (pi E* L), with its S."""
    enter(
        "elastic",
        name,
        summary,
        formula,
        source,
        make,
        needs=NEEDS,
        limit=lambda joint: _logarithmic_limit(make(joint)),
        derived=lambda joint: {"contact.penetration_limit": (_logarithmic_limit(make(joint)), "m")},
        notes=f"{notes}  {_FOLD}",
    )


def _logarithmic(joint, depth):
    return Logarithmic(math.pi * line_modulus(joint), depth)


def _johnson(joint, constant=-1.0):
    return _logarithmic(joint, 4.0 * joint.clearance * math.exp(constant))


def _radzimovsky(joint):
    # b^2 = 1.6^2 f 2 R / E* with R = R_b R_j / c leaves ln(4 R_b / b) + ln(4 R_j / b) = ln(16 E* c / (5.12 f))
    return _logarithmic(joint, 16.0 / 5.12 / math.pi * joint.clearance * math.exp(2.0 / 3.0))


def _dubowsky_freudenstein(joint, power_of_length=3.0):
    radii = joint.bearing_radius * (joint.bearing_radius - joint.clearance)
    return _logarithmic(joint, joint.length ** (power_of_length - 1.0) * joint.clearance / radii * math.e)


_line_law(
    "johnson",
    "two cylinders, one in the other",
    "pen = F / (pi E* L) (ln(4 pi E* c L / F) - 1); F = pen / (g v), v the root of v exp(-v) = pen / (g S), v > 1",
    "after Johnson 1985, Contact Mechanics; solved for F by the lower branch of Lambert's W",
    _johnson,
    "Half-spaces, so for contact arcs that are small.",
)
_line_law(
    "radzimovsky",
    "two cylinders, by Roark's formula",
    "pen = F / (pi E* L) (2/3 + ln(4 R_b / b) + ln(4 R_j / b)), b = 1.60 sqrt(F K_D / (L E*)), "
    "K_D = 2 R_b R_j / (R_b - R_j)",
    "after Radzimovsky 1953, Univ. Illinois Eng. Exp. Station Bulletin 408; b as in Roark's Formulas for Stress "
    "and Strain",
    _radzimovsky,
    "b is the full width of contact and K_D is made of diameters.  With radii in their place, as often printed, b is "
    "too small by sqrt(2) and the force 6 to 13 % too low.",
)
_line_law(
    "dubowsky-freudenstein",
    "two cylinders, with the length in the logarithm",
    "pen = F (h_b + h_j) / L (ln(L^3 c / (F R_b R_j (h_b + h_j))) + 1), h = (1 - nu^2) / (pi E)",
    "after Dubowsky & Freudenstein 1971, J. Eng. Ind. 93:305",
    _dubowsky_freudenstein,
    "The length within the logarithm has no physical ground; only its third power makes the argument a pure number.",
)
_line_law(
    "goldsmith",
    "dubowsky-freudenstein with the length to the first power",
    "pen = F (h_b + h_j) / L (ln(L c / (F R_b R_j (h_b + h_j)) m^2) + 1), h = (1 - nu^2) / (pi E)",
    "after Goldsmith 1960, Impact",
    lambda joint: _dubowsky_freudenstein(joint, 1.0),
    "Dimensionally inconsistent: the logarithm is taken of a number in 1/m^2, here with all lengths in metres; in "
    "millimetres the law is another.",
)
_line_law(
    "esdu-78035",
    "johnson with + 1 in place of - 1",
    "pen = F (h_b + h_j) / L (ln(4 L c / (F (h_b + h_j))) + 1), h = (1 - nu^2) / (pi E)",
    "after ESDU 78035, Contact phenomena I; not compared with the original",
    lambda joint: _johnson(joint, 1.0),
    "A further factor pi, found in codes, does not belong there.",
)

# ---------------------------------------------------------------------------------------------- conformal contact

_ARC = "The contact arc is that of rigid circles, cos theta = c / (c + pen)."


def _liu(joint):
    return Liu(0.5 * math.pi * line_modulus(joint), joint.clearance)


enter(
    "elastic",
    "liu",
    "two cylinders whose contact arc follows from geometry",
    "F_elastic = (1/2) pi E* L pen sqrt(pen / (2 (c + pen)))",
    "after Liu, Zhang & Yang 2007, Mech. Mach. Theory 42:183",
    _liu,
    needs=NEEDS,
    notes=f"{_ARC}  Softer than the laws of line contact by an order of magnitude at small penetration.",
)
enter(
    "elastic",
    "bai-zhao-consistent",
    "liu's force, of which Bai & Zhao's stiffness is the derivative",
    "F_elastic = (1/2) pi E* L pen sqrt(pen / (2 (c + pen))), its derivative K_n L",
    "after Bai & Zhao 2012, Int. J. Mech. Sci. 54:190; the integral of their K_n",
    _liu,
    needs=NEEDS,
    notes="Their K_n = (1/8) pi E* sqrt(2 pen (3 c + 2 pen)^2 / (c + pen)^3) is exactly dF/dpen of liu per length, "
    "a tangent stiffness; this law takes it for one.  With contact.law zhiying-qishao it is their hybrid "
    "model.",
)
enter(
    "elastic",
    "bai-zhao-literal",
    "Bai & Zhao's stiffness times the penetration, as printed",
    "F_elastic = K_n L pen, K_n = (1/8) pi E* sqrt(2 pen (3 c + 2 pen)^2 / (c + pen)^3)",
    "after Bai & Zhao 2012, Int. J. Mech. Sci. 54:190, with exponent 1",
    lambda joint: LiuTangent(*_liu(joint)),
    needs=NEEDS,
    notes="A tangent stiffness taken for a secant one: 1.5 times liu at small penetration.  The paper's exponent n "
    "= 1.5 would be dimensionally wrong.  With contact.law zhiying-qishao it is their hybrid model.",
)


def foundation_modulus(joint: Joint) -> float:
    """Return (1 - nu) E / ((1 + nu) (1 - 2 nu) t) in Pa/m, the modulus of a thin layer held at its back."""
    material = joint.contact.material
    young, poisson = material.young, material.poisson
    if poisson >= 0.5:
        raise InputError(
            f"contact.material.poisson: found {poisson:g}; winkler allows below 0.5: its layer would not give way"
        )
    return (1.0 - poisson) * young / ((1.0 + poisson) * (1.0 - 2.0 * poisson) * joint.contact.values["thickness"])


enter(
    "elastic",
    "winkler",
    "a layer of radial springs in the bearing",
    "F_elastic = k R_b L ((c + pen) theta - c sin theta), cos theta = c / (c + pen), k = (1 - nu) E / ((1 + nu) (1 "
    "- 2 nu) t)",
    "elastic foundation: Johnson 1985, Contact Mechanics, section 4.3; integrated over p = k ((c + pen) cos phi - c)",
    lambda joint: Foundation(foundation_modulus(joint) * joint.bearing_radius * joint.length, joint.clearance),
    Field("thickness", "m", "t, of the layer that gives way"),
    needs=NEEDS,
    ranges=(Range("contact.material.poisson", -1.0, 0.499, "1", "an incompressible layer does not give way"),),
    limit=lambda joint: 0.1 * joint.contact.values["thickness"],
    derived=lambda joint: {
        "contact.foundation_modulus": (foundation_modulus(joint), "Pa/m"),
        "contact.penetration_limit": (0.1 * joint.contact.values["thickness"], "m"),
    },
    notes="The thickness is a guess where there is no layer.  Held to be good up to a tenth of the thickness; the same "
    "formula goes on beyond.",
)


def _pereira(joint):
    clearance = joint.clearance * 1e3  # mm, as all lengths of the fit; moduli in MPa
    y = 1.51 * math.log(1e3 * clearance) ** -0.151 if clearance < 0.34954 else 0.0151 * clearance + 1.151
    exponent = y * clearance**-0.005
    stiffness = (0.965 * clearance + 0.0965) * line_modulus(joint) * 1e-3 / clearance  # N/mm^n
    return Power(stiffness * 1e3**exponent, exponent)


enter(
    "elastic",
    "pereira",
    "a power fitted to two cylinders, one in the other",
    "F_elastic = (0.965 c + 0.0965) L E* / c pen^n in mm, N, MPa; n = Y c^-0.005, Y = 1.51 ln(1000 c)^-0.151 for "
    "c < 0.34954 mm, else 0.0151 c + 1.151",
    "after Pereira, Ramalho & Ambrosio 2011, Nonlinear Dyn. 63:681, internal contact",
    _pereira,
    needs=NEEDS,
    ranges=(Range("clearance", 5e-6, 1e-2, "m", "it was fitted there"),),
    derived=lambda joint: _derived_power(_pereira(joint)),
    notes="Dimensionally inconsistent: a fit with all lengths in millimetres.  n = (Y c)^-0.005, found in codes, "
    "is wrong.",
)


def _persson(joint):
    return Conformal(2.0 * math.pi * line_modulus(joint) * joint.clearance, joint.clearance)


enter(
    "elastic",
    "persson",
    "conformal contact over any arc up to its limiting angle",
    "F_elastic = 2 pi E* c L b^2 (b^2 + 1) / (2 - ln(b^2 + 1) - 2 b^4), b = tan(theta / 2), cos theta = c / (c + pen)",
    "after Persson 1964 (thesis, Chalmers) and Ciavarella & Decuzzi 2001, Int. J. Solids Struct. 38:4507, like "
    "materials; the scale from Hertz's limit, the arc over penetration an assumption made here",
    _persson,
    needs=NEEDS,
    limit=lambda joint: CONFORMAL_END * joint.clearance,
    derived=lambda joint: {"contact.penetration_limit": (CONFORMAL_END * joint.clearance, "m")},
    notes=f"Load over half-angle theta is the theory's; it knows no penetration.  {_ARC}  It makes the force linear "
    "at small penetration, (pi/2) E* L pen, above the laws of line contact: elastic bodies touch over less "
    "than the rigid arc.  The half-angle cannot pass 84.83 degrees; beyond 80.41, where the tangent "
    "stiffness is twice the secant, the force goes on along the tangent.",
)

FIT_END = 0.5  # clearances: the penetration up to which conformal-fit follows persson


@functools.cache
def conformal_fit() -> tuple[float, float, float]:
    """Return (k, n, residual) of the power k x^n that is closest to Persson's load over 0 < x <= FIT_END.

    The load is in units of E* c L, x in clearances; least squares of the relative error, `residual` its rms.
    """
    nodes, weights = np.polynomial.legendre.leggauss(200)
    x = 0.5 * FIT_END * (nodes + 1.0)
    load = 2.0 * math.pi * np.array([conformal_load(depth) for depth in x])
    exponent, logarithm = np.polyfit(np.log(x), np.log(load), 1, w=np.sqrt(weights))
    error = np.exp(logarithm) * x**exponent / load - 1.0
    return float(np.exp(logarithm)), float(exponent), float(np.sqrt(np.average(error**2, weights=weights)))


def _conformal_power(joint):
    factor, exponent, _ = conformal_fit()
    return Power(factor * line_modulus(joint) * joint.clearance ** (1.0 - exponent), exponent)


enter(
    "elastic",
    "conformal-fit",
    "a power fitted to the conformal contact of persson",
    "F_elastic = K_f pen^n_f, K_f = k E* L c^(1 - n_f); k and n_f the least squares of the relative error for pen "
    "up to c / 2",
    "in the manner of 'A continuous contact force model for planar revolute joint based on fitting method' 2017, "
    "Adv. Mech. Eng. 9(2); the coefficients are fitted here, not the paper's",
    _conformal_power,
    needs=NEEDS,
    limit=lambda joint: FIT_END * joint.clearance,
    derived=lambda joint: (
        _derived_power(_conformal_power(joint))
        | {
            "contact.fit_residual": (conformal_fit()[2], "1"),
            "contact.penetration_limit": (FIT_END * joint.clearance, "m"),
        }
    ),
    notes="Shares the contact arc of persson, and its stiffness at small penetration.  Goes on as the power beyond "
    "c / 2.  contact.law exact gives the loss that energy conservation asks for.",
)
