"""The load on a fractal surface from the load on a single contact spot.

The spots' areas a are spread with the density n(a) = (D / 2) psi^((2 - D) / 2) a_L^(D / 2) a^(-(D + 2) / 2) up to the
largest, a_L (Majumdar & Bhushan 1991, J. Tribol. 113:1); psi extends the domain over all spots (Wang & Komvopoulos
1994, J. Tribol. 116:812).  A spot of area a is pressed G^(D - 1) a^((2 - D) / 2) deep.

Areas are represented by logarithms, as they span hundreds of decades when D is near an end of its range.
"""

import functools
import math
from typing import NamedTuple

import numpy as np

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
