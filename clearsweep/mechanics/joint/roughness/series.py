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
from numpy.polynomial.legendre import leggauss

from ...compiled import calculus
from ...compiled.array_handle import ArrayHandle, array_handle, load_item
from ...compiled.dual import as_type_of, plain
from ...compiled.family import kernel
from ..elastic.conformal import half_angle_at_load
from ..elastic.contract import elastic_energy, elastic_force, root_parity
from .spots import Surface, approach, contact_area, domain_extension, largest_spot

MIN_PENETRATION, MAX_PENETRATION = (
    1e-13,
    0.1,
)  # m, ends of the table: below, the force is a power law; beyond, u / pen is constant
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


class Arc(NamedTuple):
    """Parameters that determine the contact arc of a joint."""

    stiffness: float  # E* c L, N
    width: float  # 2 R_b L, m^2: the area of an arc over its half-angle


class Series(NamedTuple):
    """Rough surfaces in series with an elastic law: the compiled form and its valid range."""

    term: Rough
    flattening_depth: float  # m, penetration at which the spots would cover the whole arc; inf if that never matters
    surface: Surface
    arc: Arc

    def depth(self, bulk: float) -> float:
        """Return the total penetration (m) at which that of the bodies is `bulk` (m)."""
        if math.isinf(bulk):
            return bulk
        return bulk + float(rough_approach(self.surface, self.arc, np.log(elastic_force(self.term.elastic, bulk))))


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


@root_parity.member(Rough)
def _parity_rough(elastic):
    return elastic.root_parity


@functools.lru_cache(maxsize=256, typed=True)  # laws of different types may have equal numbers
def in_series(elastic: tuple, surface: Surface, arc: Arc) -> Series:
    """Return an elastic law with rough surfaces in series."""
    from scipy.interpolate import make_interp_spline

    x, bulk, force = _solve_bulk_penetration(elastic, surface, arc)
    log_ratio = make_interp_spline(x, bulk - x, k=5)
    log_force = make_interp_spline(x, force, k=5)
    power = float(log_force(x[0], 1))
    energy = make_interp_spline(x, _energies(x, log_force, power) / np.exp(force + x), k=5)
    columns = [
        curve(x[:-1], order) * STEP**order / math.factorial(order) for curve in (log_ratio, energy) for order in _ORDERS
    ]
    term = Rough(
        elastic,
        array_handle(np.stack(columns, -1)),
        float(len(x) - 1),
        float(x[0]),
        float(log_ratio(x[0], 1)),
        -1.0 if round(2.0 * power) % 2 else 1.0,
    )
    spots = contact_area(surface, largest_spot(surface, force, _psi(surface)), _psi(surface))
    flattened_rows = np.flatnonzero((spots >= _log_arc_area(arc, force)) & (x - bulk > MIN_ROUGH_FRACTION))
    return Series(term, float(np.exp(x[flattened_rows[0]])) if flattened_rows.size else math.inf, surface, arc)


_ORDERS = tuple(reversed(range(_POWERS)))


def _psi(surface: Surface) -> float:
    return domain_extension(surface.dimension)


def _log_arc_area(arc: Arc, force: np.ndarray) -> np.ndarray:
    """Return the logarithm of the contact arc's area (m^2) from that of the force (N)."""
    return np.log(arc.width * half_angle_at_load(np.exp(force) / arc.stiffness))


def rough_approach(surface: Surface, arc: Arc, force: np.ndarray) -> np.ndarray:
    """Return the approach (m) of rough surfaces from the logarithm of the force (N)."""
    psi = _psi(surface)
    largest = largest_spot(surface, force, psi)
    residual = contact_area(surface, largest, psi) - _log_arc_area(arc, force)
    return approach(surface, largest - np.logaddexp(0.0, BLEND * residual) / BLEND)


def _solve_bulk_penetration(elastic: tuple, surface: Surface, arc: Arc) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return ln pen in uniform steps, and the logarithms of u (m) and of the force (N) at each step."""
    from scipy.interpolate import PchipInterpolator

    def curve_at(bulk: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        force = np.log([elastic_force(elastic, depth) for depth in np.exp(bulk)])
        return np.log(np.exp(bulk) + rough_approach(surface, arc, force)), force

    coarse = np.linspace(math.log(MIN_BULK), math.log(MAX_PENETRATION), 800)
    pen = curve_at(coarse)[0]
    guess = PchipInterpolator(pen, coarse)
    lowest = max(math.log(MIN_PENETRATION), float(pen[0]))
    step_count = math.ceil((float(pen[-1]) - lowest) / STEP)
    x = float(pen[-1]) - STEP * np.arange(step_count, -1.0, -1.0)
    x = x[x >= pen[0]]
    upper = np.clip(np.searchsorted(pen, x), 1, len(pen) - 1)
    low, high = coarse[upper - 1], coarse[upper]
    bulk, slope = guess(x), guess(x, 1)
    pen, force = curve_at(bulk)
    for _ in range(MAX_STEPS):  # Newton's method with the slope of the guess, halving where that leaves the bracket
        unsolved = np.flatnonzero(np.abs(pen - x) > TOLERANCE)
        if not unsolved.size:
            break
        current, residual = bulk[unsolved], pen[unsolved] - x[unsolved]
        low[unsolved], high[unsolved] = (
            np.where(residual < 0.0, current, low[unsolved]),
            np.where(residual > 0.0, current, high[unsolved]),
        )
        newton = current - slope[unsolved] * residual
        is_inside = (newton > low[unsolved]) & (newton < high[unsolved])
        bulk[unsolved] = np.where(is_inside, newton, 0.5 * (low[unsolved] + high[unsolved]))
        pen[unsolved], force[unsolved] = curve_at(bulk[unsolved])
    return x, bulk, force


def _energies(x: np.ndarray, load, power: float) -> np.ndarray:
    """Return the integral (J) of the force over the penetration up to each x = ln pen; `load` : spline of ln F."""
    nodes, weights = leggauss(5)
    points = x[:-1, None] + 0.5 * STEP * (nodes + 1.0)
    increments = 0.5 * STEP * np.exp(load(points) + points) @ weights
    return np.concatenate([[0.0], np.cumsum(increments)]) + math.exp(float(load(x[0])) + x[0]) / (power + 1.0)
