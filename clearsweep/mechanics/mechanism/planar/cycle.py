"""Compiled tables of the ideal machine's motion over a turn of its crank.

Between stations a polynomial of degree five matches values and two derivatives at both ends; with 720
stations this is as accurate as the stations themselves.
"""

import math
from typing import NamedTuple

import numpy as np

from ...compiled.array_handle import array_handle, load_item
from ...compiled.family import kernel

WIDTH = 3  # numbers at a station: value and its first two derivatives by the crank's angle


class Cycle(NamedTuple):
    """Quantities over a turn: columns of (value, derivative, second derivative) at equidistant stations."""

    table: float  # address of (stations + 1, columns, WIDTH) numbers
    stations: float
    columns: float
    start: float  # rad, crank's angle at the first station


def cycle_of(columns: list[tuple[np.ndarray, np.ndarray, np.ndarray]], start: float) -> Cycle:
    """Return the Cycle of quantities, each given with its derivatives at all stations."""
    table = np.array([list(column) for column in columns]).transpose(2, 0, 1)  # (stations + 1, columns, WIDTH)
    return Cycle(array_handle(table), float(table.shape[0] - 1), float(table.shape[1]), start)


@kernel
def at_angle(given, column, angle):
    """Return value and derivative of a column of a Cycle at a crank angle (rad), continuous over turns."""
    stations, columns = int(given.stations), int(given.columns)
    turns = (angle - given.start) * (0.5 / math.pi)
    whole = math.floor(turns)
    position = (turns - whole) * stations
    station = min(int(position), stations - 1)
    t, h = position - station, 2.0 * math.pi / stations
    near = WIDTH * (columns * station + column)
    far = near + WIDTH * columns
    f0, d0, s0 = (
        load_item(given.table, near),
        h * load_item(given.table, near + 1),
        h * h * load_item(given.table, near + 2),
    )
    f1, d1, s1 = (
        load_item(given.table, far),
        h * load_item(given.table, far + 1),
        h * h * load_item(given.table, far + 2),
    )
    rise = f1 - f0 - d0 - 0.5 * s0
    tilt, bend = d1 - d0 - s0, s1 - s0
    a3, a4 = 10.0 * rise - 4.0 * tilt + 0.5 * bend, -15.0 * rise + 7.0 * tilt - bend
    a5 = 6.0 * rise - 3.0 * tilt + 0.5 * bend
    value = f0 + t * (d0 + t * (0.5 * s0 + t * (a3 + t * (a4 + t * a5))))
    slope = d0 + t * (s0 + t * (3.0 * a3 + t * (4.0 * a4 + t * 5.0 * a5)))
    first, last = WIDTH * column, WIDTH * (columns * stations + column)
    winding = load_item(given.table, last) - load_item(given.table, first)
    return value + winding * whole, slope / h
