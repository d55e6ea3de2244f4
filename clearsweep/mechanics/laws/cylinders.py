"""Line contact of two cylinders, one in the other: half-spaces over a small arc, or elastic bodies over any arc.

E* is the modulus of the pair, 1 / E* = (1 - nu_b^2) / E_b + (1 - nu_j^2) / E_j, c the radial clearance, L the length of
the joint, R_b and R_j the radii of bearing and journal.

The law `compatible` has the arc from elastic displacements instead of the overlap of rigid circles.
Journal and bearing deform like half-spaces bent to the bearing's radius R: a radial pressure p(phi) moves the
surfaces towards each other by

    w(phi) = 2 R / (pi E*) integral of p(psi) (-1 - ln sin(|phi - psi| / 2)) d psi ,

with the constant of Johnson 1985, section 5.6, where each body includes the approach of a disc to its centre.  They
touch over |phi| <= theta, where w is the overlap of the circles, w(phi) = (c + pen) cos(phi) - c.  Differentiated and
written in y = tan(phi / 2), this is the aerofoil equation; its solution without singular ends is a half
ellipse over sin(phi / 2),

    p = E* (c + pen) / R  cos(phi / 2) sqrt(s^2 - sin^2(phi / 2)),  s = sin(theta / 2) ,

the first term of Persson's pressure.  Inserted at phi = 0 and integrated over the arc, with q = s^2:

    pen / (c + pen) = q (ln(4 / q) - 1),   F = (pi / 2) E* L (c + pen) q (2 - q) .

For small arcs F = pi E* L c q, and the first is Johnson's law.
"""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ...contracts.case import Joint
from ...contracts.catalogue import Columns, Field, Merit, Order, Range, ranged
from ...language.errors import InputError
from ...tracing.compiled import calculus
from ...tracing.compiled.dual import as_type_of
from ...tracing.compiled.family import kernel
from ...tracing.portable import line_through, log, power
from .contract import register
from .elastic import (
    CYLINDER_NEEDS,
    NODES,
    SMALL_ARC,
    Power,
    derived_power,
    elastic_energy,
    elastic_force,
    force_and_energy,
    line_modulus,
    register_elastic_force,
)

#: Where the tangent of pen = g F ln(S / F) is twice the secant, in units of g S.  The law folds back at exp(-1).
LOGARITHMIC_END = 2.0 * calculus.exp(-2.0)


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
    q = -calculus.log(w)  # v - ln v = q
    r = calculus.sqrt(q - 1.0)
    v = 1.0 + r * (1.41612896 + r * (1.02969292 + r * 0.26107797)) / (1.0 + 0.26129776 * r)
    z = v - q - calculus.log(v)
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
    return Logarithmic(calculus.pi * line_modulus(joint), depth)


_FOLD = (
    "Folds back where pen = g S / e; beyond 0.736 times that, "
    "where the tangent stiffness is twice the secant, the force continues along the tangent."
)


def register_line_law(*described: Any, make: Callable, notes: str, **further: Any) -> None:
    """Register a law pen = g F ln(S / F), g = 1 / (pi E* L), as `register`; make : joint -> Logarithmic, with its S."""
    register(
        *described,
        types=(Logarithmic,),
        make=make,
        limit=lambda joint: LOGARITHMIC_END * make(joint).depth,
        contact="line",
        needs=CYLINDER_NEEDS,
        trusted=(SMALL_ARC,),
        notes=f"{notes}  {_FOLD}",
        **further,
    )


def _make_johnson(joint, constant=-1.0):
    return make_logarithmic(joint, 4.0 * joint.clearance * calculus.exp(constant))


register_line_law(
    "elastic johnson: two cylinders, one in the other",
    "pen = F / (pi E* L) (ln(4 pi E* c L / F) - 1); F = pen / (g v), v the root of v exp(-v) = pen / (g S), v > 1",
    "after Johnson 1985, Contact Mechanics; solved for F by the lower branch of Lambert's W",
    make=_make_johnson,
    notes="Treats the bodies as half-spaces, so it is for small contact arcs.",
    merit=Merit(3, "it is the line contact of elastic half-spaces, and the arc is small"),
)


register_line_law(
    "elastic esdu-78035: johnson with + 1 in place of - 1",
    "pen = F (h_b + h_j) / L (ln(4 L c / (F (h_b + h_j))) + 1), h = (1 - nu^2) / (pi E)",
    "after ESDU 78035, Contact phenomena I; not compared with the original",
    make=lambda joint: _make_johnson(joint, 1.0),
    notes="Some codes have a further factor pi, which is wrong.",
)


def _make_radzimovsky(joint):
    # b^2 = 1.6^2 f k R / E* with R = R_b R_j / c leaves ln(4 R_b / b) + ln(4 R_j / b) = ln(16 E* c / (2.56 k f))
    width_factor_squared = 2.56 * joint.contact.values["curvature_factor"]
    return make_logarithmic(
        joint, 16.0 / width_factor_squared / calculus.pi * joint.clearance * calculus.exp(2.0 / 3.0)
    )


register_line_law(
    "elastic radzimovsky: two cylinders, by Roark's formula",
    "pen = F / (pi E* L) (2/3 + ln(4 R_b / b) + ln(4 R_j / b)), b = 1.60 sqrt(F K_D / (L E*)), K_D = curvature_factor "
    "R_b R_j / (R_b - R_j)",
    "after Radzimovsky 1953, Univ. Illinois Eng. Exp. Station Bulletin 408; b as in Roark's Formulas for Stress and "
    "Strain",
    (
        ranged(
            "curvature_factor",
            "1",
            "definition of K_D; 2: by diameters, as in Roark; 1: by radii, as in the multibody literature",
            "[1, 2]",
            default=2,
            integer=True,
        ),
    ),
    make=_make_radzimovsky,
    notes="b is the full width of contact, and K_D uses diameters.  With radii, as often printed, b is too small by "
    "sqrt(2) and the force 6 to 13 % lower; curvature_factor 1 reproduces curves of the multibody literature.",
)


def _make_dubowsky_freudenstein(joint, power_of_length=3.0):
    radii = joint.bearing_radius * (joint.bearing_radius - joint.clearance)
    return make_logarithmic(joint, joint.length ** (power_of_length - 1.0) * joint.clearance / radii * calculus.e)


register_line_law(
    "elastic dubowsky-freudenstein: two cylinders, with the length in the logarithm",
    "pen = F (h_b + h_j) / L (ln(L^3 c / (F R_b R_j (h_b + h_j))) + 1), h = (1 - nu^2) / (pi E)",
    "after Dubowsky & Freudenstein 1971, J. Eng. Ind. 93:305",
    make=_make_dubowsky_freudenstein,
    unsound="the length in its logarithm has no physical basis",
    notes="The length in the logarithm has no physical basis; only its third power makes the argument dimensionless.",
)


register_line_law(
    "elastic goldsmith: dubowsky-freudenstein with the length to the first power",
    "pen = F (h_b + h_j) / L (ln(L c / (F R_b R_j (h_b + h_j)) m^2) + 1), h = (1 - nu^2) / (pi E)",
    "after Goldsmith 1960, Impact",
    make=lambda joint: _make_dubowsky_freudenstein(joint, 1.0),
    unsound="dimensionally inconsistent",
    notes="Dimensionally inconsistent: the argument of the logarithm has the unit 1/m^2.  Here all lengths are in "
    "metres; in millimetres the law gives other forces.",
)


def _make_pereira(joint):
    clearance = joint.clearance * 1e3  # mm, like all lengths of the fit; moduli in MPa
    y = 1.51 * calculus.log(1e3 * clearance) ** -0.151 if clearance < 0.34954 else 0.0151 * clearance + 1.151
    exponent = y * clearance**-0.005
    stiffness = (0.965 * clearance + 0.0965) * line_modulus(joint) * 1e-3 / clearance  # N/mm^n
    return Power(stiffness * 1e3**exponent, exponent)


register(
    "elastic pereira: a power fitted to two cylinders, one in the other",
    "F_elastic = (0.965 c + 0.0965) L E* / c pen^n in mm, N, MPa; n = Y c^-0.005, Y = 1.51 ln(1000 c)^-0.151 for c < "
    "0.34954 mm, else 0.0151 c + 1.151",
    "after Pereira, Ramalho & Ambrosio 2011, Nonlinear Dyn. 63:681, internal contact",
    types=(Power,),
    make=_make_pereira,
    contact="line",
    needs=CYLINDER_NEEDS,
    ranges=(Range("clearance", 5e-6, 1e-2, "m", "it was fitted there"),),
    notes="Dimensionally inconsistent: a fit with all lengths in millimetres.  n = (Y c)^-0.005, found in some codes, "
    "is wrong.",
    derived=lambda joint: derived_power(_make_pereira(joint)),
)


# ---------------------------------------------------------------------------------------------- elastic arcs


MAX_HALF_ANGLE = math.radians(45.0)  # largest valid half-angle: there Persson's load over the same arc is 10 % larger
#: Where the tangent stiffness is twice the secant stiffness: q, and penetration and force in clearances and
#: K c; a half-angle of 77.3 degrees.
END_Q, END_DEPTH, END_FORCE = 0.3904034394336609, 1.0747499705677557, 1.303756352688982


class Compatible(NamedTuple):
    """pen / (c + pen) = q (ln(4 / q) - 1), F = K (c + pen) q (2 - q)."""

    stiffness: float  # K = (pi / 2) E* L, N/m
    clearance: float  # c, m


def depth_of_arc(angle: float) -> float:
    """Return the penetration in clearances at which the half-angle of the arc is `angle` (rad)."""
    q = math.sin(0.5 * angle) ** 2
    depth_ratio = q * (math.log(4.0 / q) - 1.0)
    return depth_ratio / (1.0 - depth_ratio)


@register_elastic_force(Compatible, is_odd=False)
def _compatible(elastic, pen):
    if pen <= 0.0:
        return as_type_of(0.0, pen)
    c = elastic.clearance
    if pen < END_DEPTH * c:
        depth_ratio = pen / (c + pen)
        q = depth_ratio * inverse_lambert(0.25 * math.e * depth_ratio)
        return elastic.stiffness * (c + pen) * q * (2.0 - q)
    return elastic.stiffness * END_FORCE * (2.0 / END_DEPTH * pen - c)


@kernel
def energy_ratio(q):
    """Return the energy in units of K c^2: the integral of the force over the penetration, by parts.

    With w = pen / (c + pen) and h = w (2 - w) / (1 - w)^2 it is q (2 - q) h / 2 minus the integral of (1 - q) h over q;
    its part 2 w, with a logarithm at small q, is integrated in closed form.
    """
    w = q * (calculus.log(4.0 / q) - 1.0)
    energy_factor = 0.0
    for node, weight in NODES:
        q_at_node = q * (node * node)
        logarithm = q_at_node * (calculus.log(4.0 / q_at_node) - 1.0)
        energy_factor += (
            weight * logarithm * ((1.0 - q_at_node) * (2.0 - logarithm) / ((1.0 - logarithm) * (1.0 - logarithm)) - 2.0)
        )
    return 0.5 * q * (2.0 - q) * w * (2.0 - w) / ((1.0 - w) * (1.0 - w)) - q * (w + 0.5 * q + energy_factor)


END_ENERGY = energy_ratio(END_Q)


@force_and_energy.member(Compatible)
def _force_and_energy_compatible(elastic, pen):
    if pen <= 0.0:
        return as_type_of(0.0, pen), as_type_of(0.0, pen)
    c = elastic.clearance
    if pen < END_DEPTH * c:
        depth_ratio = pen / (c + pen)
        q = depth_ratio * inverse_lambert(0.25 * math.e * depth_ratio)
        return elastic.stiffness * (c + pen) * q * (2.0 - q), elastic.stiffness * c * c * energy_ratio(q)
    overshoot = pen - END_DEPTH * c
    force = elastic.stiffness * END_FORCE * (2.0 / END_DEPTH * pen - c)
    return force, elastic.stiffness * (END_ENERGY * c * c + END_FORCE * overshoot * (c + overshoot / END_DEPTH))


elastic_energy.member(Compatible)(lambda elastic, pen: force_and_energy(elastic, pen)[1])


def _make_compatible(joint: Joint) -> Compatible:
    return Compatible(0.5 * math.pi * line_modulus(joint), joint.clearance)


register(
    "elastic compatible: conformal contact, with the arc from the elastic displacements",
    "pen / (c + pen) = q (ln(4 / q) - 1), F_elastic = (pi/2) E* L (c + pen) q (2 - q), q = sin^2(theta / 2)",
    "half-space compatibility over the arc, in the manner of 'A continuous contact force model for planar revolute "
    "joint based on fitting method' 2017, Adv. Mech. Eng. 9(2), whose equations were not read; derived here",
    types=(Compatible,),
    make=_make_compatible,
    contact="line",
    needs=CYLINDER_NEEDS,
    notes="Johnson's law for small arcs.  Its pressure is half an ellipse over sin(phi / 2), the first term of "
    "Persson's.  Over the same arc its load is within 4 % of Persson's up to a half-angle of 40 degrees.  At 45, the "
    "end of its range, it is 9 % lower.  From 77.3 degrees on, where the tangent stiffness is twice the secant, the "
    "force continues along the tangent.  docs/model-contact.md derives it.",
    merit=Merit(1, "its contact arc follows from both elastic bodies, small or wide, without a fitted constant"),
    limit=lambda joint: depth_of_arc(MAX_HALF_ANGLE) * joint.clearance,
)

# ---------------------------------------------------------------------------------------------- a power

_POINTS = 200  # points of the fit to `compatible`, uniform in the logarithm of the penetration
FIT = Columns(
    "fit",
    "user-defined points, such as finite-element results, to which the power law is fitted instead of to `compatible`",
    (Field("penetration", "m", "penetration of the journal into the bearing"),),
    (Field("force", "N", "normal force of the whole joint"),),
)
FIT_FROM = Field("fit_from", "m", "smallest penetration of the fit", default=1e-7)
FIT_TO = Field("fit_to", "m", "largest penetration of the fit", default=2e-5)


class FittedPower(NamedTuple):
    """A power law fitted to points."""

    power: Power
    residual: float  # rms of the relative error, 1
    max_penetration: float  # m, largest penetration of the points


def fit_power_law(joint: Joint) -> FittedPower:
    """Return the best-fitting power law for a joint's points, or for `compatible`.  Raises InputError."""
    values, points = joint.contact.values, joint.contact.fit
    if points is None:
        depths = np.geomspace(values["fit_from"], values["fit_to"], _POINTS)
        term = _make_compatible(joint)
        points = {"penetration": tuple(depths), "force": tuple(elastic_force(term, depth) for depth in depths)}
    depths, forces = (np.array(points[name]) for name in ("penetration", "force"))
    exponent, logarithm = line_through(log(depths), log(forces), np.ones(len(depths)))
    if not exponent > 0.0:
        raise InputError(f"joints.{joint.name}.contact.fit: its forces do not grow with the penetration")
    error = math.exp(logarithm) * power(depths, exponent) / forces - 1.0
    law = Power(math.exp(logarithm), exponent)
    return FittedPower(law, float(np.sqrt(np.mean(error**2))), float(depths[-1]))


register(
    "elastic compatible-fit: a power law fitted to compatible, or to user-defined points",
    "F_elastic = K_f pen^n_f, K_f = k(n_f, range / c) E* L c^(1 - n_f); ln K_f and n_f the least squares of ln F over "
    "fit_from to fit_to, evenly in ln pen, or over the points of `fit`",
    "in the manner of 'A continuous contact force model for planar revolute joint based on fitting method' 2017, Adv. "
    "Mech. Eng. 9(2); the coefficients are fitted here, not the paper's",
    (FIT_FROM, FIT_TO),
    types=(Power,),
    make=lambda joint: fit_power_law(joint).power,
    contact="line",
    needs=CYLINDER_NEEDS,
    orders=(Order("fit_from", "fit_to", "there would be nothing to fit"),),
    tables=(FIT,),
    notes="K_f, n_f and the rms of the relative error are among the derived values of a run.  The power law continues "
    "outside its range; a remark then says so.  Points of `fit` replace fit_from and fit_to.",
    merit=Merit(2, "it is a power fitted to `compatible`, which models the arc of elastic bodies"),
    limit=lambda joint: fit_power_law(joint).max_penetration,
    derived=lambda joint: (
        derived_power(fit_power_law(joint).power) | {"contact.fit_residual": (fit_power_law(joint).residual, "1")}
    ),
)
