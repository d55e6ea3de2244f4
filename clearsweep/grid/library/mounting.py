"""Clearance of a mounted rolling bearing: what interference fits and a warmer inner ring leave of its group.

Shaft, rings and housing are of steel, the shaft is solid and the housing thick.  By Lame's equations a raceway then
moves by the interference times d / F at the inner and times E / D at the outer ring: d, D the diameters of its seat, F
and E those of the raceways (NTN, Ball and Roller Bearings, tables 8.3 and 8.4).  A loose fit changes nothing.  Ground
seats are smoothed by 1 to 2.5 um when they are fitted (NTN, section 7), which is not subtracted.
"""

from bisect import bisect_left
from fractions import Fraction
from typing import NamedTuple

from ...language.errors import InputError, quoted
from .iso286 import Fit, limit_deviations

#: Keys next to a group of clearances, or of the joint.
MOUNTING_KEYS = {
    "fit": "classes of shaft and housing of the mounted bearing, such as k5/H7",
    "inner_warmer": "how much warmer the inner ring is than the outer one, such as 5 K",
}
EXPANSION = 12.5e-6  # 1/K, of bearing steel (NTN, equation 8.5)
PROBABLE_PART = 2.0 / 3.0  # of the tolerance zones of both parts, within which their sizes lie (Schaeffler, HR 1)
#: Diameters (mm, upper end of each range) and lower deviation (um) of the bore and of the outside, class Normal of
#: ISO 492; the upper one is 0.
_BORE_STEPS = (18, 30, 50, 80, 120, 180, 250, 315, 400, 500)
_BORE_DEVIATIONS = (-8, -10, -12, -15, -20, -25, -30, -35, -40, -45)
_OUTSIDE_STEPS = (18, 30, 50, 80, 120, 150, 180, 250, 315, 400, 500)
_OUTSIDE_DEVIATIONS = (-8, -9, -11, -13, -15, -18, -25, -30, -35, -40, -45)


class BearingSizes(NamedTuple):
    """The diameters (m) on which a mounted clearance depends."""

    bore: float
    outside_diameter: float
    element_diameter: float
    pitch_diameter: float


def mounted(group: Fit, name: str, sizes: BearingSizes, warmer: float = 0.0) -> Fit:
    """Return the clearances that are left of those of a `group` in a mounted bearing.

    name : fits of shaft and housing, 'k5/H7'; '' for loose fits.  warmer : K, of the inner ring above the outer one.
    Raises InputError for an unknown fit.
    """
    inner_raceway = sizes.pitch_diameter - sizes.element_diameter
    outer_raceway = sizes.pitch_diameter + sizes.element_diameter
    heating = EXPANSION * warmer * outer_raceway
    low = mean = high = 0.0
    if name:
        shaft, slash, housing = (part.strip() for part in name.partition("/"))
        if not slash or not shaft[:1].islower() or not housing[:1].isupper():
            raise InputError(f"found {quoted(name)}; expected the shaft's class before the housing's, such as k5/H7")
        interferences = (
            (_inner_interference(shaft, sizes.bore), sizes.bore / inner_raceway),
            (_outer_interference(housing, sizes.outside_diameter), outer_raceway / sizes.outside_diameter),
        )
        low, mean, high = (
            sum(share * max(interference[k], 0.0) for interference, share in interferences) for k in range(3)
        )
    return group._replace(
        low=group.low - high - heating, mean=group.mean - mean - heating, high=group.high - low - heating
    )


def _inner_interference(shaft: str, bore: float) -> tuple[float, float, float]:
    """Return least, mean and largest probable interference (m) of a shaft of a class in a bore (m)."""
    size = _millimetres(bore)
    ring = (_deviation(size, _BORE_STEPS, _BORE_DEVIATIONS), 0.0)
    return _interference(_limits(shaft, size), ring)


def _outer_interference(housing: str, outside_diameter: float) -> tuple[float, float, float]:
    """Return least, mean and largest probable interference (m) of an outer ring in a housing of a class."""
    size = _millimetres(outside_diameter)
    ring = (_deviation(size, _OUTSIDE_STEPS, _OUTSIDE_DEVIATIONS), 0.0)
    return _interference(ring, _limits(housing, size))


def _millimetres(length: float) -> Fraction:
    return Fraction(repr(length)) * 1000


def _limits(tolerance_class: str, size: Fraction) -> tuple[float, float]:
    low, high = limit_deviations(tolerance_class, size)
    return float(low), float(high)


def _deviation(size: Fraction, steps: tuple[int, ...], deviations: tuple[int, ...]) -> float:
    if size > steps[-1]:
        raise InputError(f"found a ring of {float(size):g} mm; fits are known up to {steps[-1]} mm")
    return float(deviations[bisect_left(steps, size)])


def _interference(inside: tuple[float, float], outside: tuple[float, float]) -> tuple[float, float, float]:
    """Return least, mean and largest probable interference (m) from limits (um) of the inner and the outer part."""
    mean = 0.5 * (sum(inside) - sum(outside))
    half_range = 0.5 * PROBABLE_PART * (inside[1] - inside[0] + outside[1] - outside[0])
    return (mean - half_range) / 1e6, mean / 1e6, (mean + half_range) / 1e6
