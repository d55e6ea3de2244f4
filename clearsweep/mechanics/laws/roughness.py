"""Fractal surfaces of a joint, their parameters from a measured profile, and the load on their contact spots.

The spots' areas a are spread with the density n(a) = (D / 2) psi^((2 - D) / 2) a_L^(D / 2) a^(-(D + 2) / 2) up to the
largest, a_L (Majumdar & Bhushan 1991, J. Tribol. 113:1); psi extends the domain over all spots (Wang & Komvopoulos
1994, J. Tribol. 116:812).  A spot of area a is pressed G^(D - 1) a^((2 - D) / 2) deep.

Areas are represented by logarithms, as they span hundreds of decades when D is near an end of its range.

A measured profile gives D and G.  The heights of a Weierstrass-Mandelbrot profile z = G^(D - 1) sum gamma^((D - 2) n)
cos(2 pi gamma^n x + phase) differ, at two points a lag t apart, in the mean square by the structure function
S = C G^(2 D - 2) t^(4 - 2 D),

    C = (2 pi)^s / ln(gamma) pi / (2 Gamma(1 + s) sin(pi s / 2)),  s = 4 - 2 D,

the sum over n taken as an integral (Majumdar & Bhushan 1990, J. Tribol. 112:205; C is derived here).  So the slope of
ln S over ln t gives D, and its intercept G.  Waves shorter than the steps of the profile are missing in S by
the same amount at every lag, and the noise of an instrument adds such an amount: C G^(2 D - 2) t^s - B is fitted, by
least squares of ln S.
"""

import functools
import math
from typing import NamedTuple

import numpy as np

from ...contracts.case import Joint
from ...contracts.catalogue import Columns, Field, ranged
from ...language.errors import InputError
from .contract import register, require
from .elastic import hardness_factor, plane_strain_modulus

require("roughness")  # no compiled family: tables are computed before compiling
MAX_LOG_AREA = 600.0  # bound of the logarithm of areas (m^2) at which a spot's load changes its form


class Piece(NamedTuple):
    """The load of a spot, factor area^power (N), for areas up to an upper one."""

    log_upper_area: float  # logarithm of an area, m^2
    log_factor: float  # logarithm of the factor, N m^(-2 power)
    power: float  # 1


class Surface(NamedTuple):
    """A fractal surface."""

    dimension: float  # D, 1
    scale: float  # G, m
    pieces: tuple[Piece, ...]  # from the smallest spots on; the last piece is unbounded


@functools.cache
def domain_extension(dimension: float) -> float:
    """Return psi, the root of psi^((2 - D) / 2) - (1 + psi^(-D / 2))^(-(2 - D) / D) = (2 - D) / D."""
    from scipy.optimize import brentq

    exponent_ratio = (2.0 - dimension) / dimension

    def residual(psi: float) -> float:
        growth = math.expm1(0.5 * (2.0 - dimension) * math.log(psi))
        return growth - math.expm1(-exponent_ratio * math.log1p(psi ** (-0.5 * dimension))) - exponent_ratio

    return float(brentq(residual, 1.0, 10.0, xtol=1e-14))


def log_critical_area(dimension: float, scale: float, ratio: float) -> float:
    """Return the logarithm of (G ratio^(1 / (D - 1)))^2, m^2; `ratio` : of a modulus over a pressure."""
    logarithm = 2.0 * math.log(scale) + 2.0 / (dimension - 1.0) * math.log(ratio)
    return min(max(logarithm, -MAX_LOG_AREA), MAX_LOG_AREA)


def log_spot_load(surface: Surface, log_area: np.ndarray) -> np.ndarray:
    """Return the logarithm of the load (N) of one spot, from that of its area (m^2)."""
    log_area = np.asarray(log_area, dtype=float)
    log_load = np.full(log_area.shape, np.nan)
    for piece in reversed(surface.pieces):
        log_load = np.where(log_area <= piece.log_upper_area, piece.log_factor + piece.power * log_area, log_load)
    return log_load


def log_total_load(surface: Surface, log_largest: np.ndarray, psi: float = 1.0) -> np.ndarray:
    """Return the logarithm of the load (N) of all spots, from that of the area (m^2) of the largest."""
    log_largest = np.asarray(log_largest, dtype=float)
    half_dimension = 0.5 * surface.dimension
    log_total, log_low = np.full(log_largest.shape, -math.inf), -math.inf
    for log_upper_area, log_factor, power in surface.pieces:
        log_high = np.minimum(log_largest, log_upper_area)
        # integral of a^(p - 1), p = power - D / 2, over the part of the piece below the largest spot
        p, is_covered = power - half_dimension, log_high > log_low
        log_span = np.where(is_covered, log_high - log_low, 1.0)
        if log_low == -math.inf:
            log_pressure = -math.log(p)
        elif p == 0.0:
            log_pressure = np.log(log_span)
        else:
            log_pressure = max(-p, 0.0) * log_span + np.log(-np.expm1(-abs(p) * log_span)) - math.log(abs(p))
        exponent = log_factor + p * log_high + half_dimension * log_largest + log_pressure
        log_total = np.logaddexp(log_total, np.where(is_covered, exponent, -math.inf))
        log_low = log_upper_area
    return log_total + math.log(half_dimension) + 0.5 * (2.0 - surface.dimension) * math.log(psi)


def log_largest_spot(surface: Surface, log_force: np.ndarray, psi: float) -> np.ndarray:
    """Return the logarithm of the area (m^2) of the largest spot, from that of the load (N): Newton's method."""
    log_domain_factor = 0.5 * (2.0 - surface.dimension) * math.log(psi)
    smallest = surface.pieces[0]
    log_area = (
        log_force - smallest.log_factor - log_domain_factor - math.log(surface.dimension / (2.0 - surface.dimension))
    ) / smallest.power
    for _ in range(60):
        log_current_load = log_total_load(surface, log_area, psi)
        slope = (
            0.5
            * surface.dimension
            * (1.0 + np.exp(log_domain_factor + log_spot_load(surface, log_area) - log_current_load))
        )
        step = (log_force - log_current_load) / slope
        log_area += step
        if np.all(np.abs(step) < 1e-12 * (1.0 + np.abs(log_area))):
            break
    return log_area


def log_contact_area(surface: Surface, log_largest: np.ndarray, psi: float) -> np.ndarray:
    """Return the logarithm of the area (m^2) of all spots, from that of the largest."""
    area_ratio = surface.dimension / (2.0 - surface.dimension)
    return log_largest + math.log(area_ratio) + 0.5 * (2.0 - surface.dimension) * math.log(psi)


def approach(surface: Surface, log_largest: np.ndarray) -> np.ndarray:
    """Return the approach (m) of the surface from the logarithm of the area (m^2) of the largest spot."""
    dimension = surface.dimension
    return np.exp((dimension - 1.0) * math.log(surface.scale) + 0.5 * (2.0 - dimension) * log_largest)


# ---------------------------------------------------------------------------------------------- measured profiles


GAMMA = 1.5  # ratio of the frequencies of the profile
MIN_ROWS = 1000
SEGMENTS = 8  # segments of the profile, whose scatter gives the confidence
_LAG_DIVISOR = 40  # the longest lag is this fraction of the profile, a fifth of a segment
_STEP_TOLERANCE = 0.01  # relative tolerance of equal steps
_POWER_MARGIN = 0.02  # distance from the ends 0 and 2, where a power of the lag is not fractal

DIMENSION = ranged("dimension", "1", "fractal dimension D of a profile", "(1, 2)", optional=True)
SCALE = Field("scale", "m", "length G, which scales the heights of the profile", optional=True)
PROFILE = Columns(
    "from_profile",
    "measured profile that replaces dimension and scale; it needs at least 1000 rows in even steps",
    (ranged("x", "m", "position along the surface", "(-inf, inf)"),),
    (ranged("height", "m", "height of the surface", "(-inf, inf)"),),
)


class ProfileFit(NamedTuple):
    """Result of a profile, with 95 % confidence intervals."""

    dimension: float  # 1
    scale: float  # m
    dimension_low: float
    dimension_high: float
    scale_low: float  # m
    scale_high: float
    residual: float  # rms residual of ln S, 1


def dimension_and_scale(joint: Joint) -> tuple[float, float]:
    """Return dimension and scale (m) of the surfaces of a joint, as given or from its profile.  Raises InputError."""
    assert joint.roughness is not None  # only rough joints
    if joint.roughness.tables:
        return fit_joint_profile(joint)[:2]
    return joint.roughness.values["dimension"], joint.roughness.values["scale"]


def fit_joint_profile(joint: Joint) -> ProfileFit:
    """Return the parameters from the profile of a joint.  Raises InputError."""
    assert joint.roughness is not None
    table = joint.roughness.tables[PROFILE.name]
    try:
        return fit_profile(table["x"], table["height"])
    except ValueError as error:
        raise InputError(f"joints.{joint.name}.roughness.{PROFILE.name}: {error}") from None


def derived_profile_values(joint: Joint) -> dict[str, tuple[float, str]]:
    """Return the parameters from the profile of a joint as derived values: path -> (value, unit)."""
    if not joint.roughness or not joint.roughness.tables:
        return {}
    units = {"scale": "m", "scale_low": "m", "scale_high": "m"}
    return {
        f"roughness.{key}": (value, units.get(key, "1")) for key, value in fit_joint_profile(joint)._asdict().items()
    }


@functools.lru_cache(maxsize=8)
def fit_profile(x: tuple[float, ...], height: tuple[float, ...]) -> ProfileFit:
    """Return the parameters from a profile (m, m).  Raises ValueError if it is not fractal."""
    from scipy.special import stdtrit

    positions, heights = np.array(x), np.array(height)
    steps = np.diff(positions)
    step = (positions[-1] - positions[0]) / (len(positions) - 1)
    if len(positions) < MIN_ROWS:
        raise ValueError(f"has {len(positions)} rows; at least {MIN_ROWS} are needed to estimate a dimension")
    if np.abs(steps - step).max() > _STEP_TOLERANCE * step:
        raise ValueError(f"has steps of x from {steps.min():.4g} to {steps.max():.4g} m; expected even steps")
    heights = heights - np.polyval(
        np.polyfit(positions - positions[0], heights, 1), positions - positions[0]
    )  # remove the tilt
    lags = np.unique(np.geomspace(1, len(heights) // _LAG_DIVISOR, 24).round().astype(int))
    distances = step * lags
    power, log_factor, cut_off, residual = _fit_structure_function(distances, _structure_function(heights, lags))
    dimension, log_scale = _dimension_and_log_scale(power, log_factor)
    estimates = []
    for segment in np.array_split(heights, SEGMENTS):
        squares = _structure_function(segment, lags) + cut_off
        estimates.append(_dimension_and_log_scale(*np.polyfit(np.log(distances), np.log(squares), 1)))
    half_widths = stdtrit(SEGMENTS - 1, 0.975) * np.std(estimates, axis=0, ddof=1) / math.sqrt(SEGMENTS)
    slope_error = residual / math.log(lags[-1] / lags[0])  # error of D if S had the residual at both ends
    half_widths *= math.hypot(1.0, slope_error / float(half_widths[0]))
    return ProfileFit(
        dimension,
        math.exp(log_scale),
        dimension - float(half_widths[0]),
        dimension + float(half_widths[0]),
        math.exp(log_scale - float(half_widths[1])),
        math.exp(log_scale + float(half_widths[1])),
        residual,
    )


def _structure_function(heights: np.ndarray, lags: np.ndarray) -> np.ndarray:
    """Return the structure function (m^2) of heights (m) at each lag, in rows."""
    squares = np.array([np.mean((heights[lag:] - heights[:-lag]) ** 2) for lag in lags])
    if not squares.all():
        raise ValueError("is flat; expected heights that differ")
    return squares


def _fit_structure_function(distances: np.ndarray, squares: np.ndarray) -> tuple[float, float, float, float]:
    """Return s, ln of the factor of t^s, B (m^2) and the rms residual of ln S, S the `squares` (m^2) over lags (m)."""
    from scipy.optimize import least_squares

    log_distances, target = np.log(distances / distances[0]), np.log(squares / squares[0])

    def residuals(guess: np.ndarray) -> np.ndarray:
        power, log_factor, cut_off = guess
        return np.log(np.maximum(np.exp(log_factor + power * log_distances) - cut_off, 1e-9)) - target

    start = [min(max(np.polyfit(log_distances, target, 1)[0], 0.1), 1.9), 0.0, 0.0]
    fit = least_squares(residuals, start, bounds=([0.0, -50.0, -0.95], [2.0, 50.0, 50.0]))
    power, log_factor, cut_off = map(float, fit.x)
    if not _POWER_MARGIN < power < 2.0 - _POWER_MARGIN:
        raise ValueError(
            f"is not a fractal: its height differences grow with the distance to the power {0.5 * power:.3g}; allowed: "
            "between 0 (noise) and 1 (a smooth line)"
        )
    log_factor += math.log(squares[0]) - power * math.log(distances[0])
    return power, log_factor, cut_off * float(squares[0]), float(np.sqrt(np.mean(fit.fun**2)))


def _dimension_and_log_scale(power: float, log_factor: float) -> tuple[float, float]:
    """Return D and ln G (G in m) of S = exp(log_factor) t^power."""
    from scipy.special import gamma

    dimension = 2.0 - 0.5 * power
    constant = (2.0 * math.pi) ** power / math.log(GAMMA) * 0.5 * math.pi
    constant /= gamma(1.0 + power) * math.sin(0.5 * math.pi * power)
    return float(dimension), float((log_factor - math.log(constant)) / (2.0 * (dimension - 1.0)))


# ---------------------------------------------------------------------------------------------- smooth surfaces


class Smooth(NamedTuple):
    """Rigid smooth surfaces."""


register(
    "roughness smooth: no roughness: the elastic law alone",
    "pen = bulk(F)",
    "the limit of surfaces whose scale goes to zero",
    types=(Smooth,),
    notes="The same as a joint without the section, except for the identity of the case.  For sweeps over rough "
    "surfaces.",
)


# ---------------------------------------------------------------------------------------------- two kinds of spots


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
    "roughness fractal: fractal surfaces, small spots plastic and large ones elastic",
    "P = psi^((2-D)/2) [(4 sqrt(pi)/3) E* G^(D-1) D / (3-2D) a_L^(D/2) (a_L^((3-2D)/2) - a_c^((3-2D)/2)) + H D / "
    "(2-D) a_L^(D/2) a_c^((2-D)/2)], a_c = G^2 / (H / (2 E*))^(2/(D-1)); P = psi^((2-D)/2) H D / (2-D) a_L for a_L < "
    "a_c; its limit, a logarithm, at D = 3/2; psi^((2-D)/2) - (1 + psi^(-D/2))^(-(2-D)/D) = (2-D) / D",
    "after Majumdar & Bhushan 1991, J. Tribol. 113:1; psi after Wang & Komvopoulos 1994, J. Tribol. 116:812",
    (DIMENSION, SCALE, HARDNESS),
    types=(Surface,),
    make=_make_fractal,
    needs=NEEDED,
    tables=(PROFILE,),
    notes=f"{SERIES}  The areas a are real contact areas; papers that use those of Hertz have 4/(3 pi) instead of "
    "4 sqrt(pi)/3.  An elastic spot here carries pi^1.5 = 5.57 times as much as one of kogut-etsion with the "
    "same a, D and G, where a is the base of an asperity: do not compare the two at equal G.  E* is that of the "
    "pair.  In this model small spots yield and large ones do not; kogut-etsion has the regimes between.",
    derived=derived_profile_values,
)


# ---------------------------------------------------------------------------------------------- spots in four regimes


#: Up to which interference r, in critical ones, the force on an asperity is c r^n critical forces: (r, c, n).
REGIMES = ((1.0, 1.0, 1.5), (6.0, 1.03, 1.425), (110.0, 1.40, 1.263))


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
                upper_end, math.log(critical_pressure * coefficient) + exponent_change * log_area, 1.0 - exponent_change
            )
        )
    return Surface(dimension, scale, tuple(pieces))


def _make_kogut_etsion(joint: Joint) -> Surface:
    assert joint.roughness is not None
    material = joint.contact.material
    hardness, poisson = joint.roughness.values["hardness"], material.bearing.poisson
    return make_kogut_etsion_surface(*dimension_and_scale(joint), hardness, plane_strain_modulus(material), poisson)


register(
    "roughness kogut-etsion: fractal surfaces, spots elastic, elastic-plastic in two regimes, and plastic",
    "P = integral of F(a) n(a) over a up to a_L, n = (D/2) psi^((2-D)/2) a_L^(D/2) a^(-(D+2)/2); F = F_c r^1.5 for r "
    "< 1, 1.03 F_c r^1.425 up to 6, 1.40 F_c r^1.263 up to 110, 3 F_c r / K beyond; r = (a_c / a)^(D-1), a_c = G^2 (2 "
    "E* / (K H))^(2/(D-1)), F_c r = (2/3) K H a / pi, K = 0.454 + 0.41 nu",
    "after Kogut & Etsion 2002, J. Appl. Mech. 69:657, for one asperity, of radius a^(D/2) / (pi^2 G^(D-1)), pressed "
    "G^(D-1) a^((2-D)/2) deep; spots as in Majumdar & Bhushan 1991, psi after Wang & Komvopoulos 1994.  In the manner "
    "of Li, Han, Wang, Sun & Li 2018, Chin. J. Mech. Eng. 31:109, whose equations were not read",
    (DIMENSION, SCALE, HARDNESS),
    types=(Surface,),
    make=_make_kogut_etsion,
    needs=NEEDED,
    tables=(PROFILE,),
    notes=f"{SERIES}  nu is the bearing's.  A spot's force jumps where the published fits meet, by 3 % at r = 1, "
    "1.7 % at 6 and 7.9 % (nu 0.3) at 110; the sum over all spots does not.  a is the base of an asperity, a / "
    "pi its elastic contact.  So an elastic spot carries 1 / pi^1.5 of one of fractal with the same a, D and G, "
    "5.57 times less: do not compare the two at equal G.",
    derived=derived_profile_values,
)
