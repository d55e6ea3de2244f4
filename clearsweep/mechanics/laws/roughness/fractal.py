"""Fractal surfaces with plastic small spots and elastic large spots."""

import math

from ....contracts.case import Joint
from ....contracts.catalogue import Field, Law
from ...joints.material import plane_strain_modulus
from ...joints.recipe import register
from .profile import DIMENSION, PROFILE, SCALE, derived_profile_values, dimension_and_scale
from .spots import Piece, Surface, log_critical_area

HARDNESS = Field("hardness", "Pa", "hardness H of the softer body")
SERIES = (
    "In series with the elastic law: pen = bulk(F) + approach(F), approach = G^(D-1) a_L^((2-D)/2) with the a_L at "
    "which the spots carry F; tabulated for each joint as ln(bulk / pen) over ln pen.  Where the area A_r = "
    "psi^((2-D)/2) D / (2-D) a_L of the spots nears that of the arc of contact, A_n = 2 R_b theta L with the "
    "half-angle theta of Persson's load, it is kept below it, A_r (1 + (A_r / A_n)^8)^(-1/8); from A_r = A_n on a "
    "remark says so.  The asperities are springs; the contact law accounts for all losses."
)
NEEDED = ("length", "material", "bearing_radius")  # from the contact arc and E*


def make_yielding_surface(dimension: float, scale: float, hardness: float, modulus: float) -> Surface:
    """Return a surface (scale in m, hardness and E* in Pa) of which spots below a_c yield."""
    log_elastic_factor = math.log(4.0 * math.sqrt(math.pi) / 3.0 * modulus) + (dimension - 1.0) * math.log(scale)
    log_area = log_critical_area(dimension, scale, 2.0 * modulus / hardness)
    pieces = Piece(log_area, math.log(hardness), 1.0), Piece(math.inf, log_elastic_factor, 0.5 * (3.0 - dimension))
    return Surface(dimension, scale, pieces)


def _make_fractal(joint: Joint) -> Surface:
    assert joint.roughness is not None
    hardness = joint.roughness.values["hardness"]
    return make_yielding_surface(*dimension_and_scale(joint), hardness, plane_strain_modulus(joint.contact.material))


register(
    Law(
        "roughness",
        "fractal",
        "fractal surfaces, small spots plastic and large ones elastic",
        "P = psi^((2-D)/2) [(4 sqrt(pi)/3) E* G^(D-1) D / (3-2D) a_L^(D/2) (a_L^((3-2D)/2) - a_c^((3-2D)/2)) + H D / "
        "(2-D) a_L^(D/2) a_c^((2-D)/2)], a_c = G^2 / (H / (2 E*))^(2/(D-1)); P = psi^((2-D)/2) H D / (2-D) a_L for a_L "
        "< a_c; its limit, a logarithm, at D = 3/2; psi^((2-D)/2) - (1 + psi^(-D/2))^(-(2-D)/D) = (2-D) / D",
        "after Majumdar & Bhushan 1991, J. Tribol. 113:1; psi after Wang & Komvopoulos 1994, J. Tribol. 116:812",
        (DIMENSION, SCALE, HARDNESS),
        needs=NEEDED,
        tables=(PROFILE,),
        notes=f"{SERIES}  The areas a are real contact areas; papers that use those of Hertz have 4/(3 pi) instead of "
        "4 sqrt(pi)/3.  An elastic spot here carries pi^1.5 = 5.57 times as much as one of kogut-etsion with the "
        "same a, D and G, where a is the base of an asperity: do not compare the two at equal G.  E* is that of the "
        "pair.  In this model small spots yield and large ones do not; kogut-etsion has the regimes between.",
    ),
    (Surface,),
    _make_fractal,
    derived=derived_profile_values,
)
