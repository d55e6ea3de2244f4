"""Values of a case in words, for the last lines of a run."""

import math
from collections.abc import Iterable, Mapping
from typing import Any

from ...answers.words import MIN_DIGITS, grid_text, number_of_joints, varied_text
from ...grid import Grid, leaves
from ...language import wording

__all__ = ["given_text", "grid_text", "grid_texts", "number_of_joints", "setting_name", "setting_text", "value_text"]


def grid_texts(values: Iterable[float], unit: str, *, speed: bool = False) -> list[str]:
    """Return values of one quantity as `grid_text` does, all in the unit of the largest."""
    values = list(values)
    scale = wording.scale(unit, values, speed=speed)
    name = "deg" if scale.unit == "\u00b0" else scale.unit.replace(wording.BLANK, " ")
    if not name:
        return [_pure_number(value) for value in values]
    if name.isascii() or name.startswith("\u00b5"):
        return [f"{value / scale.factor:.4g} {name}" for value in values]
    return [f"{value:.4g} {unit}" for value in values]


def _pure_number(value: float) -> str:
    """Return a number without unit; 15440, not 1.544e+04."""
    return f"{float(f'{value:.4g}'):.0f}" if 1e4 <= abs(value) < 1e6 else f"{value:.4g}"


def given_text(
    path: str, value: float, unit: str, written: Mapping[str, Mapping[str, Any]], digits: int = MIN_DIGITS
) -> str:
    """Return a value in the unit that the grid uses; `written` is `written_units` of run.json."""
    return varied_text(path, value, unit, written, digits)


def setting_text(swept: dict[str, Any], facts: dict[str, Any]) -> str:
    """Return the swept values of a case in words."""
    return ", ".join(
        f"{setting_name(path, swept, facts)} {value_text(path, value, facts)}"
        for path, value in swept.items()
        if value is not None
    )


def setting_name(path: str, paths: Iterable[str], facts: Mapping[str, Any]) -> str:
    """Return the name of a swept path, one of `paths`; clearances of fits are named radial."""
    name = wording.axis_name(path, number_of_joints(paths))
    return name.replace("clearance", "radial clearance", 1) if facts["fits"].get(path) else name


def value_text(path: str, value: Any, facts: dict[str, Any]) -> str:
    """Return a swept value with its unit; its label comes first, and the fit of which it is the mean is added."""
    if value is None or isinstance(value, str):
        return value or "-"
    label = next((name for name, labelled in facts.get("labels", {}).get(path, {}).items() if labelled == value), "")
    number = _number_text(path, value, facts)
    return f"{label} ({number})" if label else number


def _number_text(path: str, value: float, facts: dict[str, Any]) -> str:
    """Return a swept number with its unit; if it is the mean clearance of a fit, the fit is added."""
    fit = next((f" ({fit['name']})" for fit in facts["fits"].get(path, ()) if fit["mean"] == value), "")
    digits = facts.get("digits", {}).get(path, MIN_DIGITS)
    return given_text(path, value, facts["units"].get(path, "1"), facts["written_units"], digits) + fit


def first_and_last_value(grid: Grid, path: str) -> list[Any]:
    """Return the value of a path, or its first and last value; [] if the first case does not use it."""
    axis = grid.axes.get(path)
    if axis is None:
        return [value for key, value in leaves(grid.written_case(0)) if key == path]
    return list(dict.fromkeys((axis[0], axis[-1])))


def assumed_texts(assumed_units: Mapping[str, Mapping[str, Any]]) -> dict[str, str]:
    """Return path -> value of each quantity written without a unit: '100 rad/s = 954.9 rpm'."""
    texts = {}
    for path, entry in assumed_units.items():
        unit = entry["unit"]
        values = f"{' to '.join(f'{value:.6g}' for value in entry['values'])} {unit}"
        readable = " to ".join(grid_text(value, unit, speed=path.endswith("speed")) for value in entry["values"])
        if unit == "rad/s":
            readable = f"{' to '.join(f'{30.0 * value / math.pi:,.5g}' for value in entry['values'])} rpm"
        texts[path] = f"{values}{'' if readable == values else f' = {readable}'}"
    return texts


_SIZES = ("m", "kg", "kg*m^2", "rad/s", "m/s")  # units of lengths, masses, inertias and speeds
_MANY = 15  # quantities in a sentence


def assumed_sentences(grid: Grid) -> list[str]:
    """Return a sentence on the sizes and speeds that a grid file writes without a unit; [] if there are none."""
    paths = [path for path in grid.assumed_units if grid.source and grid.unit(path) in _SIZES]
    bounds = {path: first_and_last_value(grid, path) for path in sorted(paths, key=lambda path: path[:5] != "drive")}
    texts = assumed_texts(
        {path: {"unit": grid.unit(path), "values": values} for path, values in bounds.items() if values}
    )
    lines = [f"{wording.axis_name(path, number_of_joints(texts))} {text}" for path, text in texts.items()]
    more = f", and {len(lines) - _MANY} more that --dry-run lists" if len(lines) > _MANY else ""
    return [f"no unit given, SI assumed: {', '.join(lines[:_MANY])}{more}"] if lines else []
