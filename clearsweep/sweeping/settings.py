"""Values of a case in words, for the last lines of a run."""

from collections.abc import Iterable, Mapping
from typing import Any

from ..language import wording


def grid_text(value: float, unit: str, *, speed: bool = False) -> str:
    """Return a value as it could be written in a grid: '0.5 mm', '5000 rpm', '6.61e+10 N/m^1.5'."""
    scale = wording.scale(unit, value, speed=speed)
    scale = scale._replace(unit="deg") if scale.unit == "°" else scale
    if scale.unit.replace(wording.BLANK, " ").isascii() or scale.unit.startswith("µ"):
        return f"{value / scale.factor:.4g} {scale.unit}".rstrip()
    return f"{value:.4g} {unit}"


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


def given_text(path: str, value: float, unit: str, written: Mapping[str, Mapping[str, Any]]) -> str:
    """Return a value in the unit that the grid uses; `written` is `written_units` of run.json."""
    scale = wording.written_scale(written.get(path), unit)
    if scale is None:
        return grid_text(value, unit, speed=path.endswith("speed"))
    name = written[path]["unit"] if path in written and scale == wording.recorded_scale(written[path]) else scale.unit
    return f"{scale.from_si(value):.4g} {name}"


def number_of_joints(paths: Iterable[str]) -> int:
    """Return the number of joints in dotted paths."""
    return len({path.split(".")[1] for path in paths if path.startswith("joints.")})


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


def common_units(record: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    """Return the display unit of each varied path: the unit in the grid, else one that suits the values.

    record : run.json; the result is like its `written_units`
    """
    written = dict(record.get("written_units") or {})
    drawn = (record.get("sample") or {}).get("drawn", {})
    labelled = {path: [*values.values()] for path, values in (record.get("labels") or {}).items()}
    varied = labelled | dict(record.get("sweep") or {}) | dict(record.get("zip") or {}) | drawn
    for path, values in varied.items():
        numbers = [value for value in values if isinstance(value, int | float) and not isinstance(value, bool)]
        unit = record["units"].get(path, "1")
        if path in written or not numbers or unit == "1":
            continue
        scale = wording.scale(unit, numbers, speed=path.endswith("speed"))
        scale = wording.fit_scale() if (record.get("fits") or {}).get(path) else scale
        if scale.unit.replace(wording.BLANK, " ").isascii() or scale.unit.startswith("\u00b5"):
            written[path] = {"unit": scale.unit, "factor": scale.factor, "offset": scale.offset}
    return written


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
    return given_text(path, value, facts["units"].get(path, "1"), facts["written_units"]) + fit
