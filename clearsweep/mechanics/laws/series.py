"""An elastic law with rough surfaces in series: pen = bulk(F) + approach(F).

Bodies and asperities carry the same force F.  With u the penetration of the bodies alone, F is the elastic law's at u,
and pen = u + approach(F(u)) increases with u.  A table has ln(u / pen) over ln pen as polynomials of degree five with
four continuous derivatives, and the elastic law itself is evaluated at u.  So smooth surfaces do not change it, except
for rounding; a kink in the load on asperities is smoothed over a row of the table.

The energy is F pen times a second column of the table, from the integral of the force.
"""

import functools
import math
from typing import NamedTuple

import numpy as np

from ...tracing import portable
from ...tracing.compiled import calculus
from ...tracing.compiled.dual import as_type_of, plain
from ...tracing.compiled.family import kernel
from ...tracing.compiled.pinned import ArrayHandle, array_handle, load_item
from .elastic import elastic_energy, elastic_force, half_angle_at_load, root_parity
from .roughness import Surface, approach, domain_extension, log_contact_area, log_largest_spot

# m, ends of the table: below, the force is a power law; beyond, u / pen is constant
MIN_PENETRATION = 1e-13
MAX_PENETRATION = 0.1
STEP = 0.04  # step of the logarithm of penetration between rows
MIN_BULK = 1e-90  # m, range of penetrations of the bodies
MAX_STEPS, TOLERANCE = 40, 1e-11  # search for u at a row: most steps, and relative tolerance on pen
BLEND = 8.0  # the area A of the spots is bounded by that of the arc, A_n: A (1 + (A / A_n)^8)^(-1/8)
MIN_ROUGH_FRACTION = 0.01  # of the penetration: below this fraction of rough surfaces, their flattening does not matter
_POWERS = 6  # degree of the polynomial between two rows
_WIDTH = 2 * _POWERS  # numbers in a row


class Rough(NamedTuple):
    """An elastic law with rough surfaces in series."""

    elastic: tuple  # elastic law of the bodies
    table: ArrayHandle  # address of (rows, _WIDTH) numbers: polynomials of ln(u / pen), then of the energy over F pen
    rows: float
    start: float  # ln pen of the first row
    slope_below: float  # slope of ln(u / pen) before it
    root_parity: float  # as in the contract of elastic laws


class ArcParameters(NamedTuple):
    """Parameters that determine the contact arc of a joint."""

    stiffness: float  # E* c L, N
    width: float  # 2 R_b L, m^2: the area of an arc over its half-angle


class Series(NamedTuple):
    """Rough surfaces in series with an elastic law: the compiled form and its valid range."""

    compiled: Rough
    flattening_depth: float  # m, penetration at which the spots would cover the whole arc; inf if that never matters
    surface: Surface
    arc: ArcParameters

    def total_depth(self, bulk: float) -> float:
        """Return the total penetration (m) at which that of the bodies is `bulk` (m)."""
        if math.isinf(bulk):
            return bulk
        return bulk + float(rough_approach(self.surface, self.arc, np.log(elastic_force(self.compiled.elastic, bulk))))


@kernel
def _table_value(rough, x, column):
    """Return the value of a table column at x = ln pen, not below its start."""
    position = (x - rough.start) * (1.0 / STEP)
    last_row = rough.rows - 1.0
    row = int(min(plain(position), last_row))
    t = min(position, rough.rows) - row
    offset = _WIDTH * row + _POWERS * column
    value = load_item(rough.table, offset) * t + load_item(rough.table, offset + 1)
    for i in range(2, _POWERS):
        value = value * t + load_item(rough.table, offset + i)
    return value


@elastic_force.member(Rough)
def _elastic_force_rough(elastic, pen):
    if pen <= 0.0:
        return as_type_of(0.0, pen)
    x = calculus.log(pen)
    if x < elastic.start:
        log_ratio = _table_value(elastic, as_type_of(elastic.start, x), 0) + elastic.slope_below * (x - elastic.start)
    else:
        log_ratio = _table_value(elastic, x, 0)
    return elastic_force(elastic.elastic, pen * calculus.exp(log_ratio))


@elastic_energy.member(Rough)
def _elastic_energy_rough(elastic, pen):
    if pen <= 0.0:
        return as_type_of(0.0, pen)
    return elastic_force(elastic, pen) * pen * _table_value(elastic, max(calculus.log(pen), elastic.start), 1)


root_parity.member(Rough)(lambda elastic: elastic.root_parity)


@functools.lru_cache(maxsize=256, typed=True)  # laws of different types may have equal numbers
def combine_in_series(elastic: tuple, surface: Surface, arc: ArcParameters) -> Series:
    """Return an elastic law with rough surfaces in series."""
    from scipy.interpolate import make_interp_spline

    log_pen, log_bulk, log_force = _solve_bulk_penetration(elastic, surface, arc)
    log_ratio_spline = make_interp_spline(log_pen, log_bulk - log_pen, k=5)
    log_force_spline = make_interp_spline(log_pen, log_force, k=5)
    power = float(log_force_spline(log_pen[0], 1))
    energy_spline = make_interp_spline(
        log_pen, _energies(log_pen, log_force_spline, power) / np.exp(log_force + log_pen), k=5
    )
    columns = [
        curve(log_pen[:-1], order) * STEP**order / math.factorial(order)
        for curve in (log_ratio_spline, energy_spline)
        for order in _ORDERS
    ]
    compiled = Rough(
        elastic,
        array_handle(np.stack(columns, -1)),
        float(len(log_pen) - 1),
        float(log_pen[0]),
        float(log_ratio_spline(log_pen[0], 1)),
        -1.0 if round(2.0 * power) % 2 else 1.0,
    )
    psi = domain_extension(surface.dimension)
    log_spot_area = log_contact_area(surface, log_largest_spot(surface, log_force, psi), psi)
    flattened_rows = np.flatnonzero(
        (log_spot_area >= _log_arc_area(arc, log_force)) & (log_pen - log_bulk > MIN_ROUGH_FRACTION)
    )
    return Series(
        compiled, float(np.exp(log_pen[flattened_rows[0]])) if flattened_rows.size else math.inf, surface, arc
    )


_ORDERS = tuple(reversed(range(_POWERS)))


def _log_arc_area(arc: ArcParameters, log_force: np.ndarray) -> np.ndarray:
    """Return the logarithm of the contact arc's area (m^2) from that of the force (N)."""
    return np.log(arc.width * half_angle_at_load(np.exp(log_force) / arc.stiffness))


def rough_approach(surface: Surface, arc: ArcParameters, log_force: np.ndarray) -> np.ndarray:
    """Return the approach (m) of rough surfaces from the logarithm of the force (N)."""
    psi = domain_extension(surface.dimension)
    log_largest = log_largest_spot(surface, log_force, psi)
    residual = log_contact_area(surface, log_largest, psi) - _log_arc_area(arc, log_force)
    return approach(surface, log_largest - np.logaddexp(0.0, BLEND * residual) / BLEND)


def _solve_bulk_penetration(
    elastic: tuple, surface: Surface, arc: ArcParameters
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return ln pen in uniform steps, and the logarithms of u (m) and of the force (N) at each step."""
    from scipy.interpolate import PchipInterpolator

    def curve_at(log_bulk: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        log_force = np.log([elastic_force(elastic, depth) for depth in np.exp(log_bulk)])
        return np.log(np.exp(log_bulk) + rough_approach(surface, arc, log_force)), log_force

    coarse_log_bulk = np.linspace(math.log(MIN_BULK), math.log(MAX_PENETRATION), 800)
    log_pen_at_bulk = curve_at(coarse_log_bulk)[0]
    first_log_bulk = PchipInterpolator(log_pen_at_bulk, coarse_log_bulk)
    lowest = max(math.log(MIN_PENETRATION), float(log_pen_at_bulk[0]))
    step_count = math.ceil((float(log_pen_at_bulk[-1]) - lowest) / STEP)
    log_pen = float(log_pen_at_bulk[-1]) - STEP * np.arange(step_count, -1.0, -1.0)
    log_pen = log_pen[log_pen >= log_pen_at_bulk[0]]
    upper = np.clip(np.searchsorted(log_pen_at_bulk, log_pen), 1, len(log_pen_at_bulk) - 1)
    low_log_bulk, high_log_bulk = coarse_log_bulk[upper - 1], coarse_log_bulk[upper]
    log_bulk, slope = first_log_bulk(log_pen), first_log_bulk(log_pen, 1)
    log_pen_at_bulk, log_force = curve_at(log_bulk)
    for _ in range(MAX_STEPS):  # Newton's method with the slope of the guess, halving where that leaves the bracket
        unsolved = np.flatnonzero(np.abs(log_pen_at_bulk - log_pen) > TOLERANCE)
        if not unsolved.size:
            break
        current, residual = log_bulk[unsolved], log_pen_at_bulk[unsolved] - log_pen[unsolved]
        low_log_bulk[unsolved] = np.where(residual < 0.0, current, low_log_bulk[unsolved])
        high_log_bulk[unsolved] = np.where(residual > 0.0, current, high_log_bulk[unsolved])
        newton = current - slope[unsolved] * residual
        is_inside = (newton > low_log_bulk[unsolved]) & (newton < high_log_bulk[unsolved])
        log_bulk[unsolved] = np.where(is_inside, newton, 0.5 * (low_log_bulk[unsolved] + high_log_bulk[unsolved]))
        log_pen_at_bulk[unsolved], log_force[unsolved] = curve_at(log_bulk[unsolved])
    return log_pen, log_bulk, log_force


def _energies(x: np.ndarray, log_force, power: float) -> np.ndarray:
    """Return the integral (J) of the force over the penetration up to each x = ln pen; `log_force` : spline of ln F."""
    nodes, weights = portable.gauss_rule(5)
    points = x[:-1, None] + 0.5 * STEP * (nodes + 1.0)
    increments = 0.5 * STEP * portable.product(np.exp(log_force(points) + points), weights)
    return np.concatenate([[0.0], np.cumsum(increments)]) + math.exp(float(log_force(x[0])) + x[0]) / (power + 1.0)
