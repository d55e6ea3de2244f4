"""Values of a case in words, for the last lines of a run."""

from collections.abc import Iterable, Mapping
from typing import Any

from ...answers.words import MIN_DIGITS, grid_text, number_of_joints, varied_text
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
