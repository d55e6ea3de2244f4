"""Fractal dimension D and scale G of a surface from a measured profile.

The heights of a Weierstrass-Mandelbrot profile z = G^(D - 1) sum gamma^((D - 2) n) cos(2 pi gamma^n x + phase) differ,
at two points a lag t apart, in the mean square by the structure function S = C G^(2 D - 2) t^(4 - 2 D),

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

from ....contracts.case import Joint
from ....contracts.catalogue import Columns, Field
from ....language.errors import InputError

GAMMA = 1.5  # ratio of the frequencies of the profile
MIN_ROWS = 1000
SEGMENTS = 8  # segments of the profile, whose scatter gives the confidence
_LAG_DIVISOR = 40  # the longest lag is this fraction of the profile, a fifth of a segment
_STEP_TOLERANCE = 0.01  # relative tolerance of equal steps
_POWER_MARGIN = 0.02  # distance from the ends 0 and 2, where a power of the lag is not fractal

DIMENSION = Field("dimension", "1", "fractal dimension D of a profile", 1.0, 2.0, optional=True)
SCALE = Field("scale", "m", "length G, which scales the heights of the profile", optional=True)
PROFILE = Columns(
    "from_profile",
    "measured profile that replaces dimension and scale; it needs at least 1000 rows in even steps",
    (Field("x", "m", "position along the surface", -math.inf),),
    (Field("height", "m", "height of the surface", -math.inf),),
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
