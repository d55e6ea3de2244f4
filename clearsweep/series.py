"""Wear along a measured series: Archard's equation over a table of time, pressure or force, and sliding speed.

The table may contain wear depth and clearance.  They are compared with those from its pressures and speeds,
but never fitted.
"""

import json
import math
import re
from collections.abc import Mapping
from os import PathLike
from pathlib import Path
from typing import NamedTuple

import numpy as np

from .contracts.case import DOUBTFUL_WEAR_NUMBER, LARGEST_WEAR_NUMBER, LEAST_WEAR_NUMBER
from .contracts.catalogue import LARGEST
from .grid.written import complete_rows_of_csv, split_header
from .language import quantity
from .language.errors import InputError, did_you_mean

_LARGEST_FILE = 64 * 2**20  # bytes of a file
_MAX_PRINTED_ROWS = 200  # rows of the printed table; --json has all
_MAX_ROUNDING = 0.05  # of the depth; a more coarsely rounded table is not compared
_ROUNDING_ERROR = 1e-9  # of the depth; rounding error of sums in double precision
_ROUNDED_COLUMNS = ("depth", "clearance")  # columns whose rounding matters
_DIGITS = frozenset("0123456789+-.eE ")
#: Column -> SI unit, and the names by which its head may begin: `contact_pressure [MPa]` or `contact_pressure_MPa`.
COLUMNS = {
    "time": ("s", ("time", "t")),
    "pressure": ("Pa", ("contact_pressure", "pressure")),
    "force": ("N", ("normal_force", "force")),
    "speed": ("m/s", ("sliding_velocity", "sliding_speed", "velocity", "speed")),
    "depth": ("m", ("wear_depth", "depth")),
    "clearance": ("m", ("radial_clearance", "clearance")),
}
_KNOWN_COLUMNS_TEXT = ", ".join(f"{names[0]} [{unit}]" for unit, names in COLUMNS.values())


class Series(NamedTuple):
    """The columns of a table in SI."""

    columns: Mapping[str, np.ndarray]  # by the names of COLUMNS, each (rows,)
    rounding: Mapping[str, np.ndarray]  # (rows,) for depth and clearance: half a unit in the last written digit, SI
    path: str


class SeriesWear(NamedTuple):
    """The wear computed from a series."""

    series: Series
    coefficient: float  # m^2/N
    pressure: np.ndarray  # (rows,) Pa
    depths: Mapping[str, np.ndarray]  # 'trapezoidal', 'left', 'right' -> (rows,) m
    implied_coefficients: np.ndarray | None  # (rows - 1,) m^2/N, implied by each step of the table's own depth
    remarks: tuple[str, ...]  # contradictions in the table
    notes: tuple[str, ...]


def read_coefficient(text: str, hardness: str | None) -> tuple[float, float | None]:
    """Return the wear coefficient k (m^2/N), and the dimensionless one if a hardness is given.

    text : '2e-14 m^2/N', or with a `hardness` the number k hardness.  Raises InputError.
    """
    if hardness is None:
        value = _read_quantity("--coefficient", text, "m^2/N")
        if value < 0.0:
            raise InputError(f"--coefficient: found {text}; allowed: at least 0 m^2/N")
        if not 1.0 / LARGEST <= value <= LARGEST and (value or _has_nonzero_digit(text)):
            raise InputError(f"--coefficient: found {text}; allowed: 0, or {1.0 / LARGEST:g} to {LARGEST:g} m^2/N")
        return value, None
    pressure = read_positive("--hardness", hardness, "Pa")
    try:
        wear_number = float(text)
    except ValueError:
        wear_number = _read_quantity("--coefficient", text, "m^2/N") * pressure
    if not (wear_number == 0.0 or LEAST_WEAR_NUMBER <= wear_number <= LARGEST_WEAR_NUMBER):
        raise InputError(
            f"--coefficient: found {text}, which is a dimensionless {wear_number:.3g} at the hardness "
            f"{hardness}; allowed: {LEAST_WEAR_NUMBER:g} to {LARGEST_WEAR_NUMBER:g}; if the coefficient "
            "has a unit, write it (1 mm^2/N is 1e-6 m^2/N)"
        )
    return wear_number / pressure, wear_number


def read_positive(option: str, text: str, unit: str) -> float:
    """Return the positive quantity of an option in SI.  Raises InputError."""
    value = _read_quantity(option, text, unit)
    if value <= 0.0 and not (value == 0.0 and _has_nonzero_digit(text)):
        raise InputError(f"{option}: found {text}; allowed: above 0 {unit}")
    if not 1.0 / LARGEST <= value <= LARGEST:
        raise InputError(f"{option}: found {text}; allowed: {1.0 / LARGEST:g} to {LARGEST:g} {unit}")
    return value


def _has_nonzero_digit(text: str) -> bool:
    """Return whether a written number is not zero, although it may be too small for a float."""
    return re.match(r"[\s+-]*[0.]*[1-9]", text) is not None


def read_series(file: str | PathLike) -> Series:
    """Return the series in a CSV file.  Raises InputError, with row and column."""
    path = Path(file)
    titles, rows = complete_rows_of_csv(path, _LARGEST_FILE)
    columns: dict[str, np.ndarray] = {}
    rounding: dict[str, np.ndarray] = {}
    for column, title in enumerate(titles):
        name, unit = _parse_title(title)
        if name in columns:
            raise InputError(f"{path}:1:{column + 1}: '{title.strip()}' is a second column of {name}; keep one of them")
        if name:
            texts = [row[column] for _, row in rows]
            columns[name] = _parse_values(
                texts, unit, COLUMNS[name][0], f"{path}:{{}}:{column + 1}", [line for line, _ in rows]
            )
            if name in _ROUNDED_COLUMNS:
                half_digit_scale = 0.5 * quantity.read(f"1 {unit}", COLUMNS[name][0])
                rounding[name] = half_digit_scale * np.array([_last_digit_value(text) for text in texts])
    _check_columns(path, columns, titles)
    return Series(columns, rounding, str(path))


def compute_wear(series: Series, coefficient: float, area: float | None = None) -> SeriesWear:
    """Return the wear of a series with a `coefficient` (m^2/N).

    area : m^2, loaded by the force; None if the pressure is a column.  Raises InputError.
    """
    columns, notes = series.columns, []
    if area is not None:
        if "force" not in columns:
            raise InputError(f"{series.path}: has no column of force for --area; add one, such as normal_force [N]")
        pressure = columns["force"] / area
        notes = ["The pressure is force over --area; the pressure column is not used."] if "pressure" in columns else []
    elif "pressure" in columns:
        pressure = columns["pressure"]
    else:
        raise InputError(
            f"{series.path}: has no column of pressure; add one, such as contact_pressure [MPa], or give the area "
            "that bears the force with --area"
        )
    rate, steps = pressure * np.abs(columns["speed"]), np.diff(columns["time"])
    rates = {"trapezoidal": 0.5 * (rate[1:] + rate[:-1]), "left": rate[:-1], "right": rate[1:]}
    depth = {rule: coefficient * np.concatenate([[0.0], np.cumsum(depths * steps)]) for rule, depths in rates.items()}
    if max(depths[-1] for depths in depth.values()) > LARGEST:
        raise InputError(
            f"{series.path}: {coefficient:.3g} m^2/N with pressures up to {pressure.max():.3g} Pa wears more than "
            f"{LARGEST:g} m; check the units of the coefficient, the area and the columns"
        )
    implied = None
    if "depth" in columns:
        work = rates["trapezoidal"] * steps
        with np.errstate(over="ignore"):
            implied = np.divide(np.diff(columns["depth"]), work, out=np.full(len(work), np.nan), where=work > 0.0)
    result = SeriesWear(series, coefficient, pressure, depth, implied, (), ())
    remarks = [*_depth_remarks(result), *_clearance_remarks(series), *_area_remarks(series)]
    if coefficient > 0.0:
        (remarks if _depth_remarks(result) else notes).append(_unit_remark(result))
    return result._replace(remarks=tuple(remarks), notes=tuple(notes))


def _growth_tolerance(result: SeriesWear) -> np.ndarray:
    """Return the rounding error (rows,) m of the growth of the table's depth: half a last digit at each end."""
    half_digit = result.series.rounding["depth"]
    first_half_digit = half_digit[0] if result.series.columns["depth"][0] else 0.0
    return np.asarray(half_digit + first_half_digit + _ROUNDING_ERROR * result.depths["right"][-1])


def _depth_remarks(result: SeriesWear) -> list[str]:
    """Return remarks on rows whose depth disagrees with pressures and speeds."""
    columns, implied = result.series.columns, result.implied_coefficients
    if implied is None or result.coefficient == 0.0:
        return []
    growth = columns["depth"] - columns["depth"][0]
    time, tolerances = columns["time"], _growth_tolerance(result)[1:]
    agreeing = {rule: np.abs(growth[1:] - depths[1:]) <= tolerances for rule, depths in result.depths.items()}
    counts = {rule: len(agrees) if agrees.all() else int(np.argmin(agrees)) for rule, agrees in agreeing.items()}
    best = max(counts, key=lambda rule: counts[rule])
    if counts[best] == len(time) - 1:
        return []
    totals = {rule: _um_text(depths[-1]) for rule, depths in result.depths.items()}
    needed = implied[np.isfinite(implied)]
    sentence = (
        f"Wear depth: the table grows by {_um_text(growth[-1])} um, but its pressures and speeds with "
        f"{result.coefficient:.3g} m^2/N give {totals['trapezoidal']} um (trapezoidal rule; {totals['left']} with the "
        f"first values of each step, {totals['right']} with the last). "
    )
    if counts[best]:
        sentence += f"Its steps follow one of these sums, the {best} one, up to {time[counts[best]]:g} s. "
    else:
        sentence += "Its steps follow none of these sums, from the first on. "
    if len(needed) and not _has_common_coefficient(result):
        sentence += f"No single coefficient gives this depth: its steps need {needed[0]:.3g} to {needed[-1]:.3g} m^2/N."
    return [sentence.strip()]


def _has_common_coefficient(result: SeriesWear) -> bool:
    """Return whether one coefficient explains every step of the table's depth, by some rule and within rounding."""
    columns, depth = result.series.columns, np.diff(result.series.columns["depth"])
    rounding = result.series.rounding["depth"][1:] + result.series.rounding["depth"][:-1]
    rate, steps = result.pressure * np.abs(columns["speed"]), np.diff(columns["time"])
    upper = np.maximum(rate[1:], rate[:-1]) * steps
    lower = np.minimum(rate[1:], rate[:-1]) * steps
    with np.errstate(all="ignore"):
        low = np.where(upper > 0.0, (depth - rounding) / upper, 0.0)
        high = np.where(lower > 0.0, (depth + rounding) / lower, np.inf)
    return bool(low.max() <= high.min())


def _clearance_remarks(series: Series) -> list[str]:
    """Return a remark if the table's clearance shrinks while it wears."""
    if not {"clearance", "depth"} <= series.columns.keys():
        return []
    clearance, depth = series.columns["clearance"], series.columns["depth"]
    change, growth = clearance[-1] - clearance[0], depth[-1] - depth[0]
    if abs(change - growth) <= sum(float(series.rounding[name][[0, -1]].sum()) for name in _ROUNDED_COLUMNS):
        return []
    verb = "shrinks" if change < 0.0 else "grows"
    return [
        f"Clearance: the table's radial clearance {verb} by {1e6 * abs(change):.3g} um (diametral "
        f"{2e6 * abs(change):.3g} um) while {1e6 * growth:.3g} um are worn; wear enlarges a clearance, by no more than "
        "its depth."
    ]


def _area_remarks(series: Series) -> list[str]:
    """Return a remark if the loaded area shrinks while the force grows."""
    if not {"pressure", "force"} <= series.columns.keys():
        return []
    force, pressure = series.columns["force"], series.columns["pressure"]
    if np.any(pressure <= 0.0) or np.ptp(force) == 0.0:
        return []
    area, low, high = force / pressure, int(np.argmin(force)), int(np.argmax(force))
    if area[high] >= 0.99 * area[low]:
        return []
    return [
        f"Area: force over pressure falls from {1e6 * area[low]:.4g} to {1e6 * area[high]:.4g} mm^2 while the force "
        f"grows from {force[low]:.4g} to {force[high]:.4g} N; the arc of a conformal contact grows with its force."
    ]


def _unit_remark(result: SeriesWear) -> str:
    """Return a remark with the coefficient in mm^2/N, and with the wear if that number were in m^2/N."""
    depth = result.depths["trapezoidal"][-1]
    return (
        f"Unit: {result.coefficient:.3g} m^2/N is {1e6 * result.coefficient:.3g} mm^2/N; "
        f"{1e6 * result.coefficient:.3g} m^2/N, as such a number is often printed, would wear "
        f"{1e6 * depth:.3g} m, not {1e6 * depth:.3g} um."
    )


def wear_json(result: SeriesWear, wear_number: float | None = None) -> str:
    """Return the result as JSON, in SI; `wear_number` is the dimensionless coefficient if a hardness was given."""
    columns = {name: values.tolist() for name, values in result.series.columns.items()}
    implied_coefficients = (
        None
        if result.implied_coefficients is None
        else [k if math.isfinite(k) else None for k in result.implied_coefficients.tolist()]
    )
    return json.dumps(
        {
            "coefficient": result.coefficient,
            "wear_number": wear_number,
            "depth": {rule: float(depths[-1]) for rule, depths in result.depths.items()},
            "table_depth": columns["depth"][-1] if "depth" in columns else None,
            "series": columns | {"pressure": result.pressure.tolist()},
            "depths": {rule: depths.tolist() for rule, depths in result.depths.items()},
            "implied_coefficients": implied_coefficients,
            "contradictions": list(result.remarks),
            "notes": list(result.notes),
        },
        indent=2
        if len(result.pressure) <= _MAX_PRINTED_ROWS
        else None,  # Python's encoder of indented text takes a minute
        allow_nan=False,
    )


def wear_text(result: SeriesWear, wear_number: float | None = None) -> str:
    """Return the series with its depths as a fixed-width table, followed by remarks and notes."""
    columns, rules = result.series.columns, ("trapezoidal", "left", "right")
    printed = {"time, s": columns["time"], "pressure, MPa": 1e-6 * result.pressure, "speed, m/s": columns["speed"]}
    printed |= {f"{rule}, um": result.depths[rule] for rule in rules}
    if result.implied_coefficients is not None:
        printed |= {"table, um": columns["depth"], "its k, m^2/N": np.append(np.nan, result.implied_coefficients)}
    cells = []
    for title, values in printed.items():
        text_of = _um_text if title.endswith(", um") else "{:.4g}".format
        texts = [title, *("-" if math.isnan(value) else text_of(value) for value in values[:_MAX_PRINTED_ROWS])]
        cells.append([text.rjust(max(map(len, texts))) for text in texts])
    lines = ["  ".join(row) for row in zip(*cells, strict=True)]
    if len(columns["time"]) > _MAX_PRINTED_ROWS:
        lines.append(f"... {len(columns['time']) - _MAX_PRINTED_ROWS:,} more rows; --json has all")
    dimensionless = "" if wear_number is None else f" (dimensionless {wear_number:.3g})"
    totals = ", ".join(f"{_um_text(result.depths[rule][-1])} um {rule}" for rule in rules)
    duration = f"{columns['time'][-1]:g} s"
    lines += ["", f"k = {result.coefficient:.4g} m^2/N{dimensionless}; depth after {duration}: {totals}", ""]
    compared = result.implied_coefficients is not None and result.coefficient > 0.0
    if compared and bool(_growth_tolerance(result)[-1] > _MAX_ROUNDING * result.depths["trapezoidal"][-1]):
        lines += ["The table's depth is rounded too coarsely to be compared with its own pressures and speeds.", ""]
    elif "depth" in columns and not result.remarks:
        lines += ["The table agrees with its own pressures and speeds.", ""]
    if result.remarks:
        lines += ["The table contradicts its own equations:", *(f"* {remark}" for remark in result.remarks), ""]
    lines += [f"Note: {note}" for note in result.notes]
    if wear_number is not None and wear_number > DOUBTFUL_WEAR_NUMBER:
        lines.append(f"Note: the dimensionless coefficient {wear_number:.3g} should be far below 1.")
    return "\n".join(lines)


def _um_text(depth: float) -> str:
    """Return a depth (m) in um without its unit, to the nanometre for depths below a metre."""
    return f"{1e6 * depth:.3f}" if abs(depth) < 1.0 else f"{1e6 * depth:.4g}"


def _parse_title(title: str) -> tuple[str, str]:
    """Return the name in COLUMNS and the unit from the title of a column; '' for a missing part."""
    name, unit = split_header(title)
    word = name.lower().replace(" ", "_")
    for column, (_, names) in COLUMNS.items():
        for alias in names:
            if word == alias:
                return column, unit
            if not unit and word.startswith(f"{alias}_"):
                return column, name[len(alias) + 1 :].replace("_", "/", 1)
    return "", ""


def _parse_values(texts: list[str], unit: str, si_unit: str, location: str, lines: list[int]) -> np.ndarray:
    """Return the numbers (rows,) of `texts` in `unit`, in the SI unit `si_unit`; `location`: `{}` is the line."""
    if frozenset().union(*texts) <= _DIGITS:  # plain numbers, a million of which are converted at once
        scale = quantity.exact(f"1 {unit}", si_unit)
        is_exact = max(scale.numerator, scale.denominator) < 2**53
        try:
            values = np.array(texts, float)
        except ValueError:
            is_exact = False
        if is_exact:
            with np.errstate(over="ignore"):
                values = values * float(scale.numerator) / float(scale.denominator)
            if np.isfinite(values).all():
                return values
    cells = zip(texts, lines, strict=True)
    return np.array(
        [_read_quantity(location.replace("{}", str(line)), f"{text.strip()} {unit}", si_unit) for text, line in cells]
    )


def _last_digit_value(text: str) -> float:
    """Return one unit in the last digit of a written number."""
    mantissa, _, power = text.strip().lower().partition("e")
    return 10.0 ** min(int(power or 0) - len(mantissa.partition(".")[2]), 300)


def _read_quantity(location: str, text: str, unit: str) -> float:
    """Return a written quantity in the SI `unit`; the InputError names its location."""
    try:
        return quantity.read(text.strip(), unit)
    except InputError as error:
        raise InputError(f"{location}: {error}") from None


def _check_columns(path: Path, columns: Mapping[str, np.ndarray], titles: list[str]) -> None:
    """Raise InputError if a series lacks a column or its time does not increase."""
    names = [name for _, (_, aliases) in COLUMNS.items() for name in aliases]
    for name in ("time", "speed"):
        if name not in columns:
            hint = next((hint for title in titles if (hint := did_you_mean(split_header(title)[0], names))), "")
            raise InputError(f"{path}:1:1: has no column of {name}{hint} (known: {_KNOWN_COLUMNS_TEXT})")
    for name, values in columns.items():
        if values.size and np.abs(values).max() > LARGEST:
            row = int(np.argmax(np.abs(values)))
            raise InputError(
                f"{path}: row {row + 2}: found a {name} of {values[row]:.3g}; allowed: at most {LARGEST:g} in SI; "
                "check the unit in the header"
            )
    if len(columns["time"]) < 2:
        raise InputError(f"{path}: has {len(columns['time'])} rows; a series needs at least 2")
    not_increasing = np.flatnonzero(np.diff(columns["time"]) <= 0.0)
    if len(not_increasing):
        raise InputError(f"{path}: row {not_increasing[0] + 3}: the time does not increase; order the rows by it")
    for name in ("pressure", "force"):
        if name in columns and np.any(columns[name] < 0.0):
            row = int(np.flatnonzero(columns[name] < 0.0)[0]) + 2
            raise InputError(f"{path}: row {row}: the {name} is negative; write compression as a positive value")
