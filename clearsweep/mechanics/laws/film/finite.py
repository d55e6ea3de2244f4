"""The film of a bearing of finite length, fitted to solutions of Reynolds' equation in two dimensions."""

from typing import NamedTuple

from ....contracts.catalogue import Law, Range
from ....tracing.compiled import calculus as math
from ....tracing.compiled.family import kernel
from ...joints.recipe import register
from .contract import film_force
from .corners import has_reversal_corners


class Finite(NamedTuple):
    """Butenschoen's fits; a1 to a9 depend only on length / diameter."""

    force: float  # L D mu / psi^2, N s
    slenderness: float  # b, length / diameter, 1
    a1: float
    a2: float
    a3: float
    a4: float
    a5: float
    a6: float
    a7: float
    a8: float
    a9: float


def make_butenschoen(force: float, b: float) -> Finite:
    """Return the compiled law with the factor `force` (N s) for a length / diameter `b`."""
    return Finite(
        force,
        b,
        a1=1.1642 - 1.9456 * b + 7.1161 * b**2 - 10.1073 * b**3 + 5.0141 * b**4,
        a2=-1.000026 - 0.023634 * b - 0.4215 * b**2 - 0.038817 * b**3 - 0.090551 * b**4,
        a3=1.152624 - 0.104565 * b,
        a4=-2.5905 + 0.798745 * b,
        a5=8.73393 - 2.3291 * b,
        a6=-13.3414 + 3.424337 * b,
        a7=6.6294 - 1.591732 * b,
        a8=0.70038 + 3.2415 * b - 12.2486 * b**2 + 18.895 * b**3 - 9.3561 * b**4,
        a9=-0.999935 + 0.0157434 * b - 0.74224 * b**2 + 0.42278 * b**3 - 0.368928 * b**4,
    )


@kernel
def wedge_number(law, ratio):
    """Return the Sommerfeld number of the wedge and sine and cosine of the attitude."""
    one_minus_square = 1.0 - ratio * ratio
    b, root = law.slenderness, math.sqrt(one_minus_square)
    number = (
        0.5
        * b
        * b
        * ratio
        / (one_minus_square * one_minus_square)
        * math.sqrt(math.pi**2 * one_minus_square + 16.0 * ratio * ratio)
    )
    number *= law.a1 * (ratio - 1.0) / (law.a2 + ratio)
    attitude_factor = law.a3 + ratio * (law.a4 + ratio * (law.a5 + ratio * (law.a6 + ratio * law.a7)))
    # arctan(pi root / (2 ratio)), also for a ratio of 0
    attitude = (0.5 * math.pi - math.atan(2.0 * ratio / (math.pi * root))) * attitude_factor
    return number, math.sin(attitude), math.cos(attitude)


@kernel
def squeeze_number(law, ratio):
    """Return the Sommerfeld number of the squeeze; the ratio has the sign of its rate."""
    one_minus_square = 1.0 - ratio * ratio
    b, root = law.slenderness, math.sqrt(one_minus_square)
    arc = 0.25 * math.pi + 0.5 * math.atan(ratio / root)  # pi / 2 - arccos(ratio) / 2
    number = (
        4.0
        * b
        * b
        / (one_minus_square * one_minus_square * root)
        * (arc * (1.0 + 2.0 * ratio * ratio) + 1.5 * ratio * root)
    )
    return number * law.a8 * (1.0 - ratio) / (-law.a9 - ratio)


has_reversal_corners.member(Finite)(None)


@film_force.member(Finite)
def _film_force_finite(law, motion):
    ratio, squeeze_rate, entrainment = motion.ratio, motion.squeeze_rate, motion.spin
    wedge, sine, cosine = wedge_number(law, ratio)
    squeeze = squeeze_number(law, ratio if squeeze_rate >= 0.0 else -ratio)
    radial = -law.force * (wedge * cosine * abs(entrainment) + squeeze * squeeze_rate)
    return radial, law.force * wedge * sine * entrainment


def _make_finite(joint):
    slenderness = 0.5 * joint.length / joint.bearing_radius
    psi = joint.clearance / joint.bearing_radius
    return make_butenschoen(joint.length * 2.0 * joint.bearing_radius * joint.film.viscosity / (psi * psi), slenderness)


register(
    Law(
        "film",
        "finite",
        "a bearing of finite length, fitted to solutions of Reynolds' equation",
        "F_r = -(L D mu / psi^2) (So_D |w| cos(beta) + So_V eps'), F_t = (L D mu / psi^2) So_D w sin(beta), psi = c / "
        "R, w = w_j + w_b - 2 gamma'; So_D = b^2 eps (pi^2 (1 - eps^2) + 16 eps^2)^(1/2) / (2 (1 - eps^2)^2) a1 (eps - "
        "1) / (a2 + eps), So_V = 4 b^2 (1 - eps^2)^(-5/2) ((pi / 2 - arccos(eps) / 2) (1 + 2 eps^2) + 1.5 eps (1 - "
        "eps^2)^(1/2)) a8 (1 - eps) / (-a9 - eps) with eps of the sign of eps', beta = arctan(pi (1 - eps^2)^(1/2) / "
        "(2 eps)) (a3 + a4 eps + a5 eps^2 + a6 eps^3 + a7 eps^4), b = L / D, a1 to a9 polynomials of b",
        "after Butenschoen 1976, Das hydrodynamische, zylindrische Gleitlager endlicher Breite unter instationaerer "
        "Belastung, Karlsruhe; fits as in the public multibody program MBDyn",
        needs=("length",),
        ranges=(
            Range(
                "length / diameter",
                0.0,
                1.2,
                "1",
                "beyond, its fit of the squeeze changes sign and generates energy; choose the law reynolds, or long",
            ),
        ),
        trusted=(
            Range(
                "length / diameter",
                0.125,
                1.0,
                "1",
                "its fits of a steady wedge and of a pure squeeze are accurate within 7 %",
            ),
        ),
        notes="It adds a wedge and a squeeze that were fitted separately.  With both, a closing film is up to a third "
        "off.  From an eccentricity ratio of 0.6 on, an opening film may push where it should pull and so generate "
        "energy; the message of such a case says so.  The law reynolds generates none.  This law gives no pressure.",
    ),
    (Finite,),
    _make_finite,
)
