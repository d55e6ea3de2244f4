"""Compiled tables of the ideal machine's motion over a revolution of its crank.

Between stations a polynomial of degree five matches values and two derivatives at both ends; with 720
stations this is as accurate as the stations themselves.
"""

import math
from typing import NamedTuple

import numpy as np

from ....tracing.compiled.family import kernel
from ....tracing.compiled.pinned import array_handle, load_item

WIDTH = 3  # numbers at a station: value and its first two derivatives by the crank's angle


class Cycle(NamedTuple):
    """Quantities over a revolution: columns of (value, derivative, second derivative) at equidistant stations."""

    table: float  # address of (stations + 1, columns, WIDTH) numbers
    stations: float
    columns: float
    start: float  # rad, crank's angle at the first station


class BranchingCycle(NamedTuple):
    """The Cycle of a machine whose loops pass change points; further columns are derivatives of those of its loops."""

    table: float
    stations: float
    columns: float
    start: float


def make_cycle(
    columns: list[tuple[np.ndarray, np.ndarray, np.ndarray]], start: float, form: type = Cycle
) -> Cycle | BranchingCycle:
    """Return the Cycle of quantities, each given with its derivatives at all stations."""
    table = np.array([list(column) for column in columns]).transpose(2, 0, 1)  # (stations + 1, columns, WIDTH)
    return form(array_handle(table), float(table.shape[0] - 1), float(table.shape[1]), start)


@kernel
def evaluate_cycle(cycle, column, angle):
    """Return value and derivative of a column of a Cycle at a crank angle (rad), continuous over revolutions."""
    stations, columns = int(cycle.stations), int(cycle.columns)
    revolutions = (angle - cycle.start) * (0.5 / math.pi)
    turns = math.floor(revolutions)
    position = (revolutions - turns) * stations
    station = min(max(int(position), 0), stations - 1)  # the angle of a trial step may be enormous
    t, h = position - station, 2.0 * math.pi / stations
    start_offset = WIDTH * (columns * station + column)
    end_offset = start_offset + WIDTH * columns
    f0, d0, s0 = (
        load_item(cycle.table, start_offset),
        h * load_item(cycle.table, start_offset + 1),
        h * h * load_item(cycle.table, start_offset + 2),
    )
    f1, d1, s1 = (
        load_item(cycle.table, end_offset),
        h * load_item(cycle.table, end_offset + 1),
        h * h * load_item(cycle.table, end_offset + 2),
    )
    value_defect = f1 - f0 - d0 - 0.5 * s0
    slope_defect, slope_change = d1 - d0 - s0, s1 - s0
    a3, a4 = (
        10.0 * value_defect - 4.0 * slope_defect + 0.5 * slope_change,
        -15.0 * value_defect + 7.0 * slope_defect - slope_change,
    )
    a5 = 6.0 * value_defect - 3.0 * slope_defect + 0.5 * slope_change
    value = f0 + t * (d0 + t * (0.5 * s0 + t * (a3 + t * (a4 + t * a5))))
    slope = d0 + t * (s0 + t * (3.0 * a3 + t * (4.0 * a4 + t * 5.0 * a5)))
    first_offset, last_offset = WIDTH * column, WIDTH * (columns * stations + column)
    growth = load_item(cycle.table, last_offset) - load_item(cycle.table, first_offset)
    return value + growth * turns, slope / h
