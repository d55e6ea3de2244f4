"""Formats quantities and names for people: SI prefixes, revolutions per minute, three digits, plain words."""

import contextlib
import math
import re
from collections.abc import Iterable, Iterator, Mapping
from contextvars import ContextVar
from typing import Any, NamedTuple

_SUPERSCRIPTS = str.maketrans("-0123456789.", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹·")
BLANK = "\u00a0"  # keeps number and unit on one line
DASH, TIMES, MINUS = "\u2013", "\u00d7", "\u2212"
UNLIMITED = "unlimited"  # for infinity
SHORT_ID = 8  # characters of a case_id: 10,000 cases collide in one run of a hundred
_RAD_PER_S_OF_RPM = 2.0 * math.pi / 60.0  # rad/s in one revolution per minute

#: SI unit -> (smallest magnitude, factor, unit shown), largest first.
_METRIC_SCALES = {
    "m": ((1.0, 1.0, "m"), (1e-4, 1e-3, "mm"), (1e-7, 1e-6, "µm"), (1e-10, 1e-9, "nm"), (0.0, 1e-12, "pm")),
    "N": ((1e6, 1e6, "MN"), (1e3, 1e3, "kN"), (0.1, 1.0, "N"), (1e-4, 1e-3, "mN"), (0.0, 1e-6, "µN")),
    "m/s": (
        (0.01, 1.0, "m/s"),
        (1e-4, 1e-3, "mm/s"),
        (1e-7, 1e-6, "µm/s"),
        (1e-10, 1e-9, "nm/s"),
        (0.0, 1e-12, "pm/s"),
    ),
    "m/s^2": ((1e4, 1e3, "km/s²"), (0.0, 1.0, "m/s²")),
    "N*m": ((1e3, 1e3, f"kN{BLANK}m"), (0.1, 1.0, f"N{BLANK}m"), (0.0, 1e-3, f"mN{BLANK}m")),
    "m^3": ((1e-12, 1e-9, "mm³"), (1e-16, 1e-15, f"10³{BLANK}µm³"), (0.0, 1e-18, "µm³")),
    "s": ((7200.0, 3600.0, "h"), (120.0, 60.0, "min"), (0.1, 1.0, "s"), (1e-4, 1e-3, "ms"), (0.0, 1e-6, "µs")),
    "Pa": ((1e8, 1e9, "GPa"), (1e5, 1e6, "MPa"), (0.0, 1.0, "Pa")),
    "W/m^2": ((1e5, 1e6, f"MPa{BLANK}m/s"), (0.0, 1.0, "W/m²")),
    "kg": ((0.1, 1.0, "kg"), (0.0, 1e-3, "g")),
    "rad": ((0.0, math.pi / 180.0, "°"),),
}
_INCH, _FOOT, _POUND, _POUND_FORCE, _PSI = 0.0254, 0.3048, 0.45359237, 4.4482216152605, 6894.757293168361

#: The same for US customary units, and the factor and the unit shown of those without prefixes.
_IMPERIAL_SCALES = {
    "m": ((0.05 * _INCH, _INCH, "in"), (1e-5 * _INCH, 1e-3 * _INCH, "mil"), (0.0, 1e-6 * _INCH, "µin")),
    "N": ((0.0, _POUND_FORCE, "lbf"),),
    "m/s": ((10.0 * _FOOT, _FOOT, "ft/s"), (0.0, _INCH, "in/s")),
    "m/s^2": ((0.0, _FOOT, "ft/s²"),),
    "N*m": ((_FOOT * _POUND_FORCE, _FOOT * _POUND_FORCE, f"lbf{BLANK}ft"), (0.0, _INCH * _POUND_FORCE, "lbf in")),
    "m^3": ((1e-3 * _INCH**3, _INCH**3, "in³"), (0.0, 1e-9 * _INCH**3, "mil³")),
    "Pa": ((1e4 * _PSI, 1e3 * _PSI, "ksi"), (0.0, _PSI, "psi")),
    "W/m^2": ((0.0, _PSI * _FOOT / 60.0, f"psi{BLANK}ft/min"),),
    "kg": ((0.0, _POUND, "lb"),),
    "kg*m^2": ((0.0, _POUND * _INCH**2, f"lb{BLANK}in²"),),
    "s": _METRIC_SCALES["s"],
    "rad": _METRIC_SCALES["rad"],
}
_IMPERIAL_FIXED_UNITS = {
    "m^2": (_INCH**2, "in²"),
    "m^2/N": (_INCH**2 / _POUND_FORCE, "in²/lbf"),
    "N/m": (_POUND_FORCE / _INCH, "lbf/in"),
    "N*s/m": (_POUND_FORCE / _INCH, f"lbf{BLANK}s/in"),
}
SYSTEMS = ("metric", "imperial")
_SYSTEM: ContextVar[str] = ContextVar("system of units", default="metric")


@contextlib.contextmanager
def unit_system(system: str) -> Iterator[None]:
    """Format quantities in a system of units (one of SYSTEMS) in this context."""
    token = _SYSTEM.set(system)
    try:
        yield
    finally:
        _SYSTEM.reset(token)


class Scale(NamedTuple):
    """A display unit: its number times `factor` plus `offset` is the value in SI."""

    factor: float
    unit: str  # '' for none
    offset: float = 0.0  # SI; for temperatures with another zero

    def from_si(self, values: Any) -> Any:
        """Return SI values, a number or an array, in this unit."""
        return (values - self.offset) / self.factor

    def number_text(self, value: float | None, digits: int = 3) -> str:
        """Return an SI value as a formatted number without unit; a dash for a missing value, a word for infinity."""
        if value is None or is_missing(value):
            return DASH
        return UNLIMITED if value == math.inf else number_text(self.from_si(float(value)), digits)

    def text(self, value: float | None, digits: int = 3) -> str:
        """Return an SI value as number and unit."""
        return self.with_unit(self.number_text(value, digits))

    def exact_text(self, value: float | None, digits: int = 6) -> str:
        """Return a user-chosen SI value as number and unit, with no more digits than necessary."""
        return self.with_unit(self.exact_number_text(value, digits))

    def exact_number_text(self, value: float | None, digits: int = 6) -> str:
        """Return the number of a user-chosen SI value, with no more digits than necessary."""
        return DASH if value is None or is_missing(value) else short_number_text(self.from_si(float(value)), digits)

    def with_unit(self, number: str) -> str:
        """Return a number, or a list of numbers, followed by the unit."""
        if number in (DASH, UNLIMITED) or not self.unit:
            return number
        separator = f"{BLANK}{TIMES}{BLANK}" if self.unit.startswith("10") else "" if self.unit == "°" else BLANK
        return f"{number}{separator}{self.unit}"


def scale(unit: str, values: Iterable[float | None] | float, *, speed: bool = False) -> Scale:
    """Return the scale that suits the largest of `values` (SI `unit`); a shaft `speed` is in rpm."""
    if speed and unit == "rad/s":
        return Scale(_RAD_PER_S_OF_RPM, "rpm")
    if isinstance(values, Iterable) and getattr(getattr(values, "dtype", None), "kind", "") == "f":  # of numpy, pandas
        sizes: Any = abs(values)  # type: ignore[arg-type]
        values = sizes[sizes < math.inf]
        values = float(values.max()) if values.size else 0.0  # type: ignore[union-attr]
    all_values = values if isinstance(values, Iterable) else (values,)
    magnitudes = [abs(float(value)) for value in all_values if value is not None and not is_missing(value)]
    largest = max((magnitude for magnitude in magnitudes if math.isfinite(magnitude)), default=0.0)
    for smallest, factor, shown_unit in (_IMPERIAL_SCALES if _SYSTEM.get() == "imperial" else _METRIC_SCALES).get(
        unit, ()
    ):
        if largest >= smallest:
            return Scale(factor, shown_unit) if largest > 0.0 else Scale(1.0, unit_text(unit))
    imperial = _IMPERIAL_FIXED_UNITS.get(unit) if _SYSTEM.get() == "imperial" else None
    factor, shown_unit = imperial or (1.0, unit_text(unit))
    largest /= factor
    if unit in ("1", "", None) or 1e-3 <= largest < 1e5 or largest == 0.0:
        return Scale(factor, shown_unit)
    power = math.floor(math.log10(largest) + 1e-12)
    return Scale(factor * 10.0**power, f"10{str(power).translate(_SUPERSCRIPTS)}{BLANK}{shown_unit}")


def temperature_scale() -> Scale:
    """Return the scale of temperatures, not of their differences."""
    if _SYSTEM.get() == "imperial":
        return Scale(5.0 / 9.0, "°F", 273.15 - 160.0 / 9.0)
    return Scale(1.0, "°C", 273.15)


def written_scale(written: Mapping[str, Any] | None, unit: str) -> Scale | None:
    """Return the scale of a grid value (SI `unit`) in the unit in which it is `written`.

    Return None if no unit is written, or if the imperial system has its own; the scale then follows from the values.
    """
    if _SYSTEM.get() == "imperial":
        if unit == "K":
            return temperature_scale()
        if unit in _IMPERIAL_SCALES or unit in _IMPERIAL_FIXED_UNITS:
            return None
    return recorded_scale(written) if written else None


def recorded_scale(written: Mapping[str, Any]) -> Scale:
    """Return the scale of a written unit from its record in a run: `unit`, `factor`, `offset`."""
    name = {"degC": "°C", "deg": "°", "um": "µm", "us": "µs"}.get(written["unit"], written["unit"])
    return Scale(written["factor"], unit_text(name.replace("**", "^")), written["offset"])


def name_with_fits(name: str, fits: Iterable[str]) -> str:
    """Return the name of a clearance that has these fits or groups: 'radial clearance', 'radial internal clearance'."""
    has_groups = {"/" not in fit for fit in fits}
    kind = "radial internal clearance" if True in has_groups else "radial clearance"
    return name.replace("clearance", kind, 1) if has_groups else name


def of_joints(named: Iterable[tuple[str, Any]]) -> list[tuple[str, str, Any]]:
    """Return names, ' in 3 joints' or '', and what is said of them; what is the same of several joints occurs once.

    named : name of a varied path, which may end in its joint in brackets, and what is said of it
    """
    names_by_quantity: dict[tuple[str, Any], list[str]] = {}
    for name, content in named:
        names_by_quantity.setdefault((name.partition(" (")[0], content), []).append(name)
    return [
        (names[0], "", content) if len(names) == 1 else (quantity, f" in {len(names)} joints", content)
        for (quantity, content), names in names_by_quantity.items()
    ]


def fit_scale() -> Scale:
    """Return the scale of the clearances of fits, in which their tables are: micrometres, or thousandths of an inch."""
    return Scale(1e-3 * _INCH, "mil") if _SYSTEM.get() == "imperial" else Scale(1e-6, "µm")


def quantity_text(value: float | str | None, unit: str, digits: int = 3) -> str:
    """Return an SI value as number and unit, with a suitable prefix; a word, such as a zone, stays."""
    if isinstance(value, str):
        return value
    return DASH if value is None or is_missing(value) else scale(unit, value).text(value, digits)


def texts_in_common_unit(values: Iterable[float | None], unit: str) -> list[str]:
    """Return SI values of one quantity, each as number and unit, with the prefix that suits the largest.

    Values in one sentence are compared, and 18.8 kN next to 2,720 N is easily misread.
    """
    values = list(values)
    return [*map(scale(unit, values).text, values)]


def is_missing(value: object) -> bool:
    """Return whether there is no value: None or NaN."""
    return value is None or (isinstance(value, float) and math.isnan(value))


def unit_text(unit: str | None) -> str:
    """Return an SI unit in printed form; '' for a pure number."""
    superscripted = re.sub(r"\^(-?[0-9.]+)", lambda power: power[1].translate(_SUPERSCRIPTS), unit or "1")
    return "" if superscripted == "1" else superscripted.replace("*", BLANK)


def number_text(number: float, digits: int = 3) -> str:
    """Return a number with `digits` significant digits, never in the form 1e5."""
    if number == 0.0 or not math.isfinite(number):
        return "0" if number == 0.0 else "∞" if number > 0 else f"{MINUS}∞"
    power = math.floor(math.log10(abs(float(f"{number:.{digits - 1}e}"))))
    if -4 <= power < 6:
        return _group_thousands(f"{number:.{max(digits - 1 - power, 0)}f}").replace("-", MINUS)
    mantissa = f"{number:.{digits - 1}e}".partition("e")[0].replace("-", MINUS)
    return f"{mantissa}{BLANK}{TIMES}{BLANK}10{str(power).translate(_SUPERSCRIPTS)}"


def short_number_text(number: float, digits: int = 6) -> str:
    """Return a number with at most `digits` significant digits, without trailing zeros."""
    mantissa, times_sign, power = number_text(number, digits).partition(f"{BLANK}{TIMES}")
    mantissa = mantissa.rstrip("0").rstrip(".") if "." in mantissa else mantissa
    return mantissa + times_sign + power


def percent_text(share: float) -> str:
    """Return a share in whole per cent."""
    if is_missing(share):
        return DASH
    return f"{100.0 * share:.0f}{BLANK}%" if share >= 0.01 or share == 0.0 else f"under 1{BLANK}%"


def count_text(number: int, noun: str, plural: str | None = None) -> str:
    """Return '1 case' or '12 345 cases'."""
    return f"{_group_thousands(str(int(number)))} {noun if number == 1 else plural or noun + 's'}"


def bytes_text(bytes_total: float) -> str:
    """Return a number of bytes as '12 MB'."""
    for factor, unit in ((1e12, "TB"), (1e9, "GB"), (1e6, "MB"), (1e3, "kB")):
        if bytes_total >= factor:
            return f"{bytes_total / factor:.3g} {unit}"
    return f"{bytes_total:.0f} B"


def duration_text(seconds: float) -> str:
    """Return a duration as '3 s', '4 min 20 s' or '5 h 10 min'."""
    if seconds < 1.0:
        return f"{seconds:.1f} s"
    minutes, rest_seconds = divmod(round(seconds), 60)
    if not minutes:
        return f"{rest_seconds} s"
    hours, rest_minutes = divmod(minutes, 60)
    return f"{hours} h {rest_minutes} min" if hours else f"{minutes} min {rest_seconds} s"


def sentence_list(words: list[str]) -> str:
    """Return words as 'a, b and c'."""
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}" if words else ""


def axis_name(path: str, joints: int = 1) -> str:
    """Return a dotted path in words; the joint is named only if there are several."""
    parts = path.split(".")
    if path == "drive.speed":
        return "crank speed"
    if path == "drive.inertia":  # in addition to that of the crank
        return "drive inertia"
    if path.endswith(".contact.elastic"):
        parts = [*parts[:-2], "elastic", "law"]
    if parts[-2:-1] == ["masses"]:
        return f"mass of body {int(parts[-1]) + 1}"
    if parts[0] == "joints" and len(parts) > 2:
        words = _key_words(parts[2:])
        if parts[2:4] == ["stops", "at"] and len(parts) > 4:
            words = f"{'lower' if parts[4] == '0' else 'upper'} stop"
        return words if joints == 1 else f"{words} ({joint_name(parts[1])})"
    if parts[:2] == ["mechanism", "mounts"] and len(parts) > 3:
        axis = f" along {_AXES[parts[4]]}" if len(parts) > 4 else ""
        return f"{_key_words([parts[3]])}{axis} of the mount of {parts[2]}"
    if parts[-3:-1] == ["elastic", "section"]:
        return f"{'width' if parts[-1] == '0' else 'height'} of the section of {parts[-4]}"
    return _key_words(parts[1:] if len(parts) > 1 else parts)


def short_id(case_id: str) -> str:
    """Return the first characters of a case_id, which identify a case of a run and which commands accept."""
    return case_id[:SHORT_ID]


def joint_name(name: str) -> str:
    """Return the name of a joint in words: 'rod-slider' for 'rod_slider'."""
    return name.replace("_", "-")


def _key_words(parts: list[str]) -> str:
    if parts[-2:-1] == ["material"] and parts[-1] == "name":
        return "material"
    if parts[-3:-2] == ["material"] and parts[-1] == "name":
        return f"material of the {parts[-2]}"
    if len(parts) > 1 and parts[-1] in _AXES and parts[-2] in _AXIS_PREPOSITIONS:
        return f"{_key_words(parts[:-1])} {_AXIS_PREPOSITIONS[parts[-2]]} {_AXES[parts[-1]]}"
    if parts[-1] in _KEY_NAMES:
        body = parts[-2] if len(parts) > 1 and parts[-2] in ("bearing", "journal") else ""
        return _KEY_NAMES[parts[-1]] + (f" of the {body}" if body else "")
    if len(parts) > 2 and parts[-2] in ("bearing", "journal"):  # a key of one of two bodies
        return f"{_key_words([*parts[:-2], parts[-1]])} of the {parts[-2]}"
    named_parts = parts if len(parts) < 2 or parts[-1] not in _UNAMBIGUOUS_KEYS else parts[-1:]
    return " ".join(named_parts).replace("_", " ").replace("-", " ")


_AXES = {"0": "x", "1": "y", "2": "z"}  # of the list that a key contains
_AXIS_PREPOSITIONS = {"tilt": "about", "inertia": "about", "offset": "along", "center": "along"}
_KEY_NAMES = {"young": "Young's modulus", "poisson": "Poisson's ratio"}
_UNAMBIGUOUS_KEYS = {"stiffness", "restitution", "damping", "exponent"}


def _group_thousands(digits: str) -> str:
    integer, dot, fraction = digits.partition(".")
    grouped = f"{int(integer):,}".replace(",", "\u202f") if len(integer.lstrip("-")) > 4 else integer
    return grouped + dot + fraction
