"""Conformal contact with an arc from elastic displacements instead of the overlap of rigid circles.

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
from typing import NamedTuple

import numpy as np

from ....contracts.case import Joint
from ....contracts.catalogue import Columns, Field, Law, Merit, Order
from ....language.errors import InputError
from ....tracing.compiled import calculus
from ....tracing.compiled.dual import as_type_of
from ....tracing.compiled.family import kernel
from ....tracing.portable import line_through, log, power
from ...joints.material import line_modulus
from ...joints.recipe import register
from .contract import CYLINDER_NEEDS, NODES, elastic_energy, elastic_force, register_elastic_force
from .cylinders import inverse_lambert
from .power import Power, derived_power

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


@elastic_energy.member(Compatible)
def _elastic_energy_compatible(elastic, pen):
    if pen <= 0.0:
        return as_type_of(0.0, pen)
    c = elastic.clearance
    if pen < END_DEPTH * c:
        depth_ratio = pen / (c + pen)
        return elastic.stiffness * c * c * energy_ratio(depth_ratio * inverse_lambert(0.25 * math.e * depth_ratio))
    overshoot = pen - END_DEPTH * c
    return elastic.stiffness * (END_ENERGY * c * c + END_FORCE * overshoot * (c + overshoot / END_DEPTH))


def _make_compatible(joint: Joint) -> Compatible:
    return Compatible(0.5 * math.pi * line_modulus(joint), joint.clearance)


register(
    Law(
        "elastic",
        "compatible",
        "conformal contact, with the arc from the elastic displacements",
        "pen / (c + pen) = q (ln(4 / q) - 1), F_elastic = (pi/2) E* L (c + pen) q (2 - q), q = sin^2(theta / 2)",
        "half-space compatibility over the arc, in the manner of 'A continuous contact force model for planar revolute "
        "joint based on fitting method' 2017, Adv. Mech. Eng. 9(2), whose equations were not read; derived here",
        contact="line",
        needs=CYLINDER_NEEDS,
        notes="Johnson's law for small arcs.  Its pressure is half an ellipse over sin(phi / 2), the first term of "
        "Persson's.  Over the same arc its load is within 4 % of Persson's up to a half-angle of 40 degrees.  At 45, "
        "the end of its range, it is 9 % lower.  From 77.3 degrees on, where the tangent stiffness is twice "
        "the secant, the force continues along the tangent.  docs/model-contact.md derives it.",
        merit=Merit(1, "its contact arc follows from both elastic bodies, small or wide, without a fitted constant"),
    ),
    (Compatible,),
    _make_compatible,
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
    Law(
        "elastic",
        "compatible-fit",
        "a power law fitted to compatible, or to user-defined points",
        "F_elastic = K_f pen^n_f, K_f = k(n_f, range / c) E* L c^(1 - n_f); ln K_f and n_f the least squares of ln F "
        "over fit_from to fit_to, evenly in ln pen, or over the points of `fit`",
        "in the manner of 'A continuous contact force model for planar revolute joint based on fitting method' 2017, "
        "Adv. Mech. Eng. 9(2); the coefficients are fitted here, not the paper's",
        (FIT_FROM, FIT_TO),
        contact="line",
        needs=CYLINDER_NEEDS,
        orders=(Order("fit_from", "fit_to", "there would be nothing to fit"),),
        tables=(FIT,),
        notes="K_f, n_f and the rms of the relative error are among the derived values of a run.  The power law "
        "continues outside its range; a remark then says so.  Points of `fit` replace fit_from and fit_to.",
        merit=Merit(2, "it is a power fitted to `compatible`, which models the arc of elastic bodies"),
    ),
    (Power,),
    lambda joint: fit_power_law(joint).power,
    limit=lambda joint: fit_power_law(joint).max_penetration,
    derived=lambda joint: (
        derived_power(fit_power_law(joint).power) | {"contact.fit_residual": (fit_power_law(joint).residual, "1")}
    ),
)
