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


def read(file: str | PathLike, units: Mapping[str, str | None], *, other_columns: bool = False) -> Measured:
    """Return the signals in a file whose SI units are `units`, by name.  Raises InputError with row and column.

    units : None for an arbitrary unit; other_columns : whether other columns are allowed, which are not read
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
    for index, heading in enumerate(heads):
        name, unit = head_of(heading)
        if other_columns and name not in (*OVER, *units):
            continue
        if name not in (*OVER, *units):
            allowed = [*OVER, *units]
            raise InputError(
                f"{path}:1:{index + 1}: '{heading.strip()}' is no signal of this run{nearest(name, allowed)} "
                f"(known: {', '.join(allowed)}); write its unit behind it, such as acceleration [m/s^2]"
            )
        if name in columns:
            raise InputError(f"{path}:1:{index + 1}: '{name}' is there twice; keep one of them")
        unit_wanted = OVER.get(name) or units[name]
        columns[name] = np.array(_values(str(path), rows, index, unit if unit_wanted else "", unit_wanted or "1"))
    if other_columns and (missing := [name for name in units if name not in columns]):
        found_heads = ", ".join(heading.strip() for heading in heads)
        raise InputError(f"{path}:1: has no column '{missing[0]}'{nearest(missing[0], heads)} (found: {found_heads})")
    abscissae = [name for name in OVER if name in columns]
    if len(abscissae) != 1 or len(columns) < 2:
        raise InputError(f"{path}:1: found {', '.join(columns)}; expected crank_angle [deg] or time [s], and a signal")
    places = columns.pop(abscissae[0])
    _check_steps(str(path), abscissae[0], places, [line for line, _ in rows])
    return Measured(str(path), abscissae[0], places, columns)


def _values(file: str, rows: list[TableRow], index: int, unit: str, unit_wanted: str) -> list[float]:
    """Return the numbers of a column in the unit `unit_wanted`.  Raises InputError for anything but a number."""
    try:
        scale = quantity.read(f"1 {unit}", unit_wanted) if unit else 1.0
    except InputError as error:
        raise InputError(f"{file}:1:{index + 1}: {error}") from None
    numbers = []
    for line, cells in rows:
        try:
            value = float(cells[index])
        except ValueError:
            value = float("nan")
        if value - value != 0.0:
            sentence = f"found {shown(cells[index])}; expected a finite number: leave out what was not measured"
            raise InputError(f"{file}:{line}:{index + 1}: {sentence}")
        numbers.append(scale * value)
    return numbers


def _check_steps(file: str, abscissae: str, places: "np.ndarray", lines: list[int]) -> None:
    """Raise InputError if the angle or the time does not increase, or if samples are missing."""
    import numpy as np

    steps = np.diff(places)
    if (steps <= 0.0).any():
        line = lines[int(np.argmax(steps <= 0.0)) + 1]
        raise InputError(f"{file}:{line}: {abscissae} does not ascend; sort the rows, and write an unwrapped angle")
    if steps.max() > GAP * np.median(steps):
        line = lines[int(np.argmax(steps)) + 1]
        sentence = f"a step of {abscissae} is {steps.max() / np.median(steps):.3g} times the usual one"
        raise InputError(f"{file}:{line}: {sentence}; cut the file there, samples are missing")
