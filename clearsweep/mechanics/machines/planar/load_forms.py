"""Loads on a planar machine that are no numbers: compiled tables over angle or time, and loads of one's own."""

import math
from typing import NamedTuple

import numpy as np

from ....contracts.catalogue import Law
from ....contracts.machine import Push, Spring, TabledPush, TorsionSpring
from ....tracing.compiled.dual import plain
from ....tracing.compiled.family import family, kernel
from ....tracing.compiled.pinned import ArrayHandle, array_handle, load_item, load_items, row_of
from ...laws.contract import Recipe, require
from ...laws.own import Own, maker

_QUANTITIES = 3  # quantities in a table: force x, y, torque
_POWERS = 4  # coefficients of the polynomials between its rows
_LOAD_WIDTH = 1 + _QUANTITIES * _POWERS  # numbers in a row: knot, then the polynomials after it


class Table(NamedTuple):
    """Table of force and torque."""

    table: ArrayHandle  # address of (rows, _LOAD_WIDTH) numbers
    row_count: float
    span: float  # rad, period; 0: constant beyond its ends


class AngleTableLoad(NamedTuple):
    """A force and torque on a body that depend on the angle of the crank."""

    at: tuple  # BodyPoint
    table: Table


class TimeTableLoad(NamedTuple):
    """A force and torque on a body that depend on time."""

    at: tuple  # BodyPoint
    table: Table


@family
def applied_load(law, time, angle, position, velocity):
    """Return force x, y (N) and torque (N m) of a load of one's own.

    time : s; angle : rad, of the crank; position, velocity : (x, y) m and m/s, of its point in the fixed frame.
    """


require("load", applied_load)


@maker("load")
def _load_recipe(own: Own, description: Law) -> Recipe:
    evaluate, kind = own.evaluate, own.type_of("law", ("p",))

    @applied_load.member(kind)
    def load(law, time, angle, position, velocity):
        return evaluate(law.p, time, angle, position, velocity)

    def make(owner):
        return kind(own.parameters(owner.values))

    def check(owner):
        p = make(owner).p
        own.check_traced(p, 0.1, 1.0, (0.1, 0.1), (0.0, 0.0))

        def total(time, angle, x, speed):
            fx, fy, torque = evaluate(p, time, angle, (x, 0.5 * x), (speed, -speed))
            return fx + fy + torque

        own.check_at(total, t=(0.0, 0.01, 1.0), angle=(0.0, 1.0, 3.0, 5.0), x=(0.0, 0.1), speed=(0.0, 1.0))
        return ()

    return Recipe(description, (kind,), make, check=check)


@kernel
def table_values(table, argument):
    """Return force x, y (N) and torque (N m) of a Table at an angle (rad) or time (s)."""
    row_count = int(table.row_count)
    first_knot, last_knot = load_item(table.table, 0), load_item(table.table, _LOAD_WIDTH * (row_count - 1))
    plain_argument = plain(argument)
    shift = table.span * math.floor((plain_argument - first_knot) / table.span) if table.span > 0.0 else 0.0
    plain_argument = min(max(plain_argument - shift, first_knot), last_knot)
    row = row_of(table.table, _LOAD_WIDTH, row_count - 1, plain_argument)
    remaining = argument - (shift + load_item(table.table, row))
    if table.span == 0.0 and (plain(argument) < first_knot or plain(argument) > last_knot):
        remaining = 0.0 * remaining + (plain_argument - load_item(table.table, row))
    return (
        _polynomial(table.table, row + 1, remaining),
        _polynomial(table.table, row + 1 + _POWERS, remaining),
        _polynomial(table.table, row + 1 + 2 * _POWERS, remaining),
    )


@kernel
def _polynomial(table, index, x):
    """Return the value of the cubic whose coefficients, highest power first, begin at `index`."""
    a, b, c, d = load_items(table, index, _POWERS)
    return ((a * x + b) * x + c) * x + d


def compile_table(load: TabledPush) -> Table:
    """Return a table in compiled form: monotone cubics (PCHIP, Fritsch & Carlson 1980) between its rows."""
    from scipy.interpolate import PchipInterpolator

    knots = np.asarray(load.knots, dtype=float)
    columns = load.scale * np.stack([load.fx, load.fy, load.torque], -1)
    is_periodic = load.over == "angle"
    coefficients = _periodic(knots, columns) if is_periodic else PchipInterpolator(knots, columns).c
    rows = np.zeros((len(knots), _LOAD_WIDTH))
    rows[:, 0] = knots
    rows[:-1, 1:] = coefficients.transpose(1, 2, 0).reshape(len(knots) - 1, -1)
    rows[-1, _POWERS::_POWERS] = columns[-1]
    return Table(array_handle(rows), float(len(knots)), float(knots[-1] - knots[0]) if is_periodic else 0.0)


def _periodic(knots: np.ndarray, columns: np.ndarray) -> np.ndarray:
    """Return the coefficients (4, rows - 1, 3) of monotone cubics whose slopes agree at both ends."""
    from scipy.interpolate import PchipInterpolator

    span, overlap = knots[-1] - knots[0], min(2, len(knots) - 1)
    extended = np.concatenate([knots[-1 - overlap : -1] - span, knots, knots[1 : 1 + overlap] + span])
    values = np.concatenate([columns[-1 - overlap : -1], columns, columns[1 : 1 + overlap]])
    return PchipInterpolator(extended, values).c[:, overlap : overlap + len(knots) - 1]


def evaluate_table(table: Table, argument: np.ndarray) -> np.ndarray:
    """Return force x, y (N) and torque (N m) of a Table at angles (N,) rad or times (N,) s."""
    rows = table.table.array.reshape(-1, _LOAD_WIDTH)
    first_knot, last_knot = rows[0, 0], rows[-1, 0]
    within_span = (
        first_knot + np.remainder(argument - first_knot, table.span)
        if table.span > 0.0
        else np.clip(argument, first_knot, last_knot)
    )
    row = rows[np.clip(np.searchsorted(rows[:, 0], within_span, side="right") - 1, 0, len(rows) - 2)]
    remaining, coefficients = (within_span - row[:, 0])[:, None], row[:, 1:].reshape(-1, _QUANTITIES, _POWERS)
    return (
        (coefficients[..., 0] * remaining + coefficients[..., 1]) * remaining + coefficients[..., 2]
    ) * remaining + coefficients[..., 3]


def discontinuity_times_of(load: Push | TabledPush | Spring | TorsionSpring) -> list[float]:
    """Return the times (s) at which the slope of a load jumps: both ends of a table over time."""
    if isinstance(load, TabledPush) and load.over == "time":
        return [float(load.knots[0]), float(load.knots[-1])]
    return []
