"""Reads measured signals: a CSV file with a column of the crank angle or of time, and columns of signals with units."""

import csv
from collections.abc import Mapping
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from ..language import quantity
from ..language.errors import InputError, nearest, shown
from .case_table import TableRow, head_of, rows_of_csv
from .document import refuse_endless

if TYPE_CHECKING:
    import numpy as np  # imported only when a file is read

LARGEST = 512 * 2**20  # bytes of a file
OVER = {"crank_angle": "rad", "time": "s"}  # a file has exactly one of these columns; SI units
GAP = 3.0  # times the median step; a longer step means missing samples
LEAST_ROWS = 16


class Measured(NamedTuple):
    """The content of a file of measured signals, in SI."""

    file: str
    over: str  # a key of OVER
    places: "np.ndarray"  # (n,) rad or s, ascending
    signals: "dict[str, np.ndarray]"  # name in the header -> (n,) values


def read(file: str | PathLike, units: Mapping[str, str | None], *, others: bool = False) -> Measured:
    """Return the signals in a file whose SI units are `units`, by name.  Raises InputError with row and column.

    units : None for an arbitrary unit; others : whether other columns are allowed, which are not read
    """
    import numpy as np

    path = Path(file)
    try:
        refuse_endless(path, LARGEST)
        heads, rows = rows_of_csv(path)
    except (OSError, ValueError, csv.Error) as error:
        raise InputError(f"{path}: cannot be read: {getattr(error, 'strerror', None) or error}") from None
    for line, cells in rows:
        if len(cells) != len(heads):
            raise InputError(
                f"{path}:{line}: the row has {len(cells)} cells but the header has {len(heads)}; write every value"
            )
    if len(rows) < LEAST_ROWS:
        raise InputError(f"{path}: has {len(rows)} rows; at least {LEAST_ROWS} are needed")
    columns: dict[str, np.ndarray] = {}
    for place, head in enumerate(heads):
        name, unit = head_of(head)
        if others and name not in (*OVER, *units):
            continue
        if name not in (*OVER, *units):
            known = [*OVER, *units]
            raise InputError(
                f"{path}:1:{place + 1}: '{head.strip()}' is no signal of this run{nearest(name, known)} "
                f"(known: {', '.join(known)}); write its unit behind it, such as acceleration [m/s^2]"
            )
        if name in columns:
            raise InputError(f"{path}:1:{place + 1}: '{name}' occurs twice; keep one of them")
        wanted = OVER.get(name) or units[name]
        columns[name] = np.array(_values(str(path), rows, place, unit if wanted else "", wanted or "1"))
    if others and (missing := [name for name in units if name not in columns]):
        there = ", ".join(head.strip() for head in heads)
        raise InputError(f"{path}:1: has no column '{missing[0]}'{nearest(missing[0], heads)} (found: {there})")
    over = [name for name in OVER if name in columns]
    if len(over) != 1 or len(columns) < 2:
        raise InputError(f"{path}:1: found {', '.join(columns)}; expected crank_angle [deg] or time [s], and a signal")
    places = columns.pop(over[0])
    _check_steps(str(path), over[0], places, [line for line, _ in rows])
    return Measured(str(path), over[0], places, columns)


def _values(file: str, rows: list[TableRow], place: int, unit: str, wanted: str) -> list[float]:
    """Return the numbers of a column in the unit `wanted`.  Raises InputError for anything but a number."""
    try:
        scale = quantity.read(f"1 {unit}", wanted) if unit else 1.0
    except InputError as error:
        raise InputError(f"{file}:1:{place + 1}: {error}") from None
    numbers = []
    for line, cells in rows:
        try:
            value = float(cells[place])
        except ValueError:
            value = float("nan")
        if value - value != 0.0:
            sentence = f"found {shown(cells[place])}; expected a finite number: leave out what was not measured"
            raise InputError(f"{file}:{line}:{place + 1}: {sentence}")
        numbers.append(scale * value)
    return numbers


def _check_steps(file: str, over: str, places: "np.ndarray", lines: list[int]) -> None:
    """Raise InputError if the angle or the time does not increase, or if samples are missing."""
    import numpy as np

    steps = np.diff(places)
    if (steps <= 0.0).any():
        line = lines[int(np.argmax(steps <= 0.0)) + 1]
        raise InputError(f"{file}:{line}: {over} does not ascend; sort the rows, and write an unwrapped angle")
    if steps.max() > GAP * np.median(steps):
        line = lines[int(np.argmax(steps)) + 1]
        sentence = f"a step of {over} is {steps.max() / np.median(steps):.3g} times the usual one"
        raise InputError(f"{file}:{line}: {sentence}; samples are missing; cut the file there")
