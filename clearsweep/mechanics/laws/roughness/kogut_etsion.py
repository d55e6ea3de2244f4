"""Fractal surfaces with elastic, elastic-plastic and plastic spots."""

import math

from ....contracts.case import Joint
from ....contracts.catalogue import Law
from ...joints.material import plane_strain_modulus
from ...joints.recipe import register
from .fractal import HARDNESS, NEEDED, SERIES
from .profile import DIMENSION, PROFILE, SCALE, derived_profile_values, dimension_and_scale
from .spots import Piece, Surface, log_critical_area

#: Up to which interference r, in critical ones, the force on an asperity is c r^n critical forces: (r, c, n).
REGIMES = ((1.0, 1.0, 1.5), (6.0, 1.03, 1.425), (110.0, 1.40, 1.263))


def hardness_factor(poisson: float) -> float:
    """Return K = 0.454 + 0.41 nu: the largest Hertzian pressure over hardness at first yield of an asperity."""
    return 0.454 + 0.41 * poisson


def make_kogut_etsion_surface(
    dimension: float, scale: float, hardness: float, modulus: float, poisson: float
) -> Surface:
    """Return a surface (scale in m, hardness and E* in Pa) of spots in three regimes and full plasticity."""
    pressure_ratio = hardness_factor(poisson)
    log_area = log_critical_area(dimension, scale, 2.0 * modulus / (pressure_ratio * hardness))
    critical_pressure = (
        2.0 / 3.0 * pressure_ratio * hardness / math.pi
    )  # F_c r / a, Pa: that of a spot of critical interference
    pieces = [
        Piece(
            log_area - math.log(REGIMES[-1][0]) / (dimension - 1.0),
            math.log(critical_pressure * 3.0 / pressure_ratio),
            1.0,
        )
    ]
    upper_ends = [math.inf, *(log_area - math.log(r) / (dimension - 1.0) for r, _, _ in REGIMES[:-1])]
    for upper_end, (_, coefficient, power) in reversed(list(zip(upper_ends, REGIMES, strict=True))):
        exponent_change = (dimension - 1.0) * (
            power - 1.0
        )  # F = F_c c r^power, r = (a_c / a)^(D - 1), F_c r = critical_pressure a
        pieces.append(
            Piece(
                upper_end,
                math.log(critical_pressure * coefficient) + exponent_change * log_area,
                1.0 - exponent_change,
            )
        )
    return Surface(dimension, scale, tuple(pieces))


def _make_kogut_etsion(joint: Joint) -> Surface:
    assert joint.roughness is not None
    material = joint.contact.material
    hardness, poisson = joint.roughness.values["hardness"], material.bearing.poisson
    return make_kogut_etsion_surface(*dimension_and_scale(joint), hardness, plane_strain_modulus(material), poisson)


register(
    Law(
        "roughness",
        "kogut-etsion",
        "fractal surfaces, spots elastic, elastic-plastic in two regimes, and plastic",
        "P = integral of F(a) n(a) over a up to a_L, n = (D/2) psi^((2-D)/2) a_L^(D/2) a^(-(D+2)/2); F = F_c r^1.5 for "
        "r < 1, 1.03 F_c r^1.425 up to 6, 1.40 F_c r^1.263 up to 110, 3 F_c r / K beyond; r = (a_c / a)^(D-1), a_c "
        "= G^2 (2 E* / (K H))^(2/(D-1)), F_c r = (2/3) K H a / pi, K = 0.454 + 0.41 nu",
        "after Kogut & Etsion 2002, J. Appl. Mech. 69:657, for one asperity, of radius a^(D/2) / (pi^2 G^(D-1)), "
        "pressed G^(D-1) a^((2-D)/2) deep; spots as in Majumdar & Bhushan 1991, psi after Wang & Komvopoulos 1994.  In "
        "the manner of Li, Han, Wang, Sun & Li 2018, Chin. J. Mech. Eng. 31:109, whose equations were not read",
        (DIMENSION, SCALE, HARDNESS),
        needs=NEEDED,
        tables=(PROFILE,),
        notes=f"{SERIES}  nu is the bearing's.  A spot's force jumps where the published fits meet, by 3 % at r = 1, "
        "1.7 % at 6 and 7.9 % (nu 0.3) at 110; the sum over all spots does not.  a is the base of an asperity, a / "
        "pi its elastic contact.  So an elastic spot carries 1 / pi^1.5 of one of fractal with the same a, D and G, "
        "5.57 times less: do not compare the two at equal G.",
    ),
    (Surface,),
    _make_kogut_etsion,
    derived=derived_profile_values,
)
