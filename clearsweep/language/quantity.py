"""Converts a physical quantity as users write it, `0.5 mm` or `0.0005`, to a float in SI; the only reader of units.

`Hz` counts turns (3 Hz of a shaft is 3 turns a second, not 3 rad/s), and an angle is a dimension (1/s is not a shaft
speed).  Arithmetic is exact until the last rounding, so that `0.5 mm`, `500 um` and `5e-4` give the same bits, and with
them the same case.  A library of units would take a third of the start of a run, and need this grammar in front of it.
"""

import re
from collections.abc import Mapping
from fractions import Fraction
from functools import cache
from typing import Any, NamedTuple

from .errors import InputError, did_you_mean, quoted

#: Names of each unit, and its size.
_UNIT_TABLE = """
m metre meter = [length]
kg kilogram = [mass]
s second = [time]
rad radian = [angle]
K kelvin = [temperature]
g gram = 1e-3 kg
t tonne = 1e3 kg
min minute = 60 s
h hour = 3600 s
in inch = 0.0254 m
ft foot = 0.3048 m
mil thou = 2.54e-5 m
lb lbm pound = 0.45359237 kg
turn rev revolution = 6.28318530717958647692528676655900576839433879875 rad
deg degree ° = 1/360 turn
Hz hertz = 1 turn/s
rpm = 1 turn/min
N newton = 1 kg*m/s^2
lbf pound_force = 4.4482216152605 N
kgf kilogram_force = 9.80665 N
Pa pascal = 1 N/m^2
psi = 1 lbf/in^2
ksi = 1e3 psi
bar = 1e5 Pa
atm = 101325 Pa
cP centipoise = 1e-3 Pa*s
cSt centistokes = 1e-6 m^2/s
J joule = 1 N*m
W watt = 1 J/s
hp horsepower = 550 ft*lbf/s
degreerankine = 5/9 K
standardgravity = 9.80665 m/s^2
"""
_PREFIXES = {
    name: Fraction(size)
    for names, size in (
        ("p pico", "1e-12"),
        ("n nano", "1e-9"),
        ("u µ μ micro", "1e-6"),
        ("m milli", "1e-3"),
        ("c centi", "1e-2"),
        ("k kilo", "1e3"),
        ("M mega", "1e6"),
        ("G giga", "1e9"),
    )
    for name in names.split()
}
_BASE_UNITS = {"[length]": "m", "[mass]": "kg", "[time]": "s", "[angle]": "rad", "[temperature]": "K"}
COMMON_UNITS = (
    "m mm um nm cm in inch ft mil kg g mg t lb s ms us min h rad deg turn rev Hz kHz rpm g0 N mN kN MN lbf kgf Pa kPa "
    "MPa GPa bar psi ksi J mJ kJ W kW hp K degC degF cP cSt Nm"
)
_UNIT_NAMES = (
    "metre meter millimetre millimeter micrometre micrometer kilogram gram second minute hour radian degree "
    "revolution hertz newton kilonewton pascal megapascal gigapascal joule watt"
)
_EXAMPLES = {
    "1": "0.9 or 90 %",
    "m": "0.5 mm, 20 um or 0.0005",
    "m^2": "100 mm^2 or 1e-4",
    "kg": "0.3 kg, 140 g or 0.3",
    "kg*m^2": "1e-4 kg*m^2 or 0.0001",
    "s": "2 ms or 0.002",
    "rad": "30 deg or 0.52",
    "rad/s": "5000 rpm, 5000 1/min, 80 Hz (turns per second) or 523.6 rad/s",
    "m/s": "1 mm/s or 0.001",
    "m/s^2": "9.81 m/s^2 or 9.81",
    "N": "5 kN or 5000",
    "N*m": "5 N*m or 5",
    "W": "20 W or 20",
    "m^3": "1 mm^3 or 1e-9",
    "N/m": "1e6 N/m or 1e6",
    "N*s/m": "100 N*s/m or 100",
    "Pa": "207 GPa or 2.07e11",
    "K": "60 degC, 333.15 K or 333.15",
    "Pa*s": "0.1 Pa*s or 0.1",
    "m^2/s": "46 mm^2/s or 4.6e-5",
    "kg/m^3": "870 kg/m^3 or 870",
    "1/K": "12e-6 1/K or 1.2e-5",
    "1/m": "1e5 1/m or 1e5",
    "W/K": "2 W/K or 2",
    "W/m^2": "1 W/mm^2 or 1e6",
    "s/m": "0.3 s/m or 0.3",
    "m^4": "341 mm^4 or 3.41e-10",
    "N*m/rad": "20 kN*m/rad or 20000",
    "N*m*s/rad": "0.02 N*m*s/rad or 0.02",
    "N*m/(rad*s)": "500 N*m/(rad*s) or 500",
    "m^2/N": "2e-14 m^2/N or 2e-5 mm^3/(N*m)",
}
_QUANTITY = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(.*?)\s*")
_EXPONENT = r"[+-]?\d{1,2}(?:\.\d+)?(?:/\d{1,2})?"
_POWER = rf"(?:\^|\*\*)\s*(?:{_EXPONENT}|\(\s*{_EXPONENT}\s*\))"
_UNIT_TOKEN = re.compile(rf"\s*({_POWER}|[²³]|[^\W\d_²³]+|°|[*/·()]|1(?=\s*/))\s*")
_PER_MINUTE = r"(1\s*)?/\s*min|min\s*(\^|\*\*)\s*\(?\s*-1\s*\)?"
#: Name of a temperature unit with another zero -> its size and its zero in K.
_TEMPERATURES = dict.fromkeys(("degC", "°C"), (Fraction(1), Fraction("273.15"))) | dict.fromkeys(
    ("degF", "°F"), (Fraction(5, 9), Fraction("459.67") * Fraction(5, 9))
)
#: Products without a sign, as data sheets print them, such as `Nm`, `kgcm^2`, `mPas` and `ft-lbf`.
_PRODUCTS = {
    "".join(factors): "*".join(factors)
    for firsts, seconds in (
        ("N kN MN mN", "m mm cm s m*s"),
        ("kg", "m mm cm"),
        ("g", "mm cm"),
        ("Pa mPa", "s"),
        ("W kW", "s h"),
        ("lb lbf lb- lbf-", "ft in"),
        ("ft in ft- in-", "lb lbf"),
    )
    for factors in ((first, *second.split("*")) for first in firsts.split() for second in seconds.split())
}
_WORD = re.compile(rf"(?<![^\W\d_])((?:ft|in|lbf?)-[a-z]+|[^\W\d_]+)(\s*(?:{_POWER}|[²³]))?")
#: Other spellings of units; in a product, temperatures are differences.
_SPELLINGS = (
    (r"g_?[0n]", "standardgravity"),
    (r"[Ur](?=\s*/)", "turn"),
    (r"(?:deg|°)C", "kelvin"),
    (r"(?:deg|°)F", "degreerankine"),
)
#: Unit -> unit that is meant where its dimension is wrong.
_MISTAKEN_UNITS = {"nm": "N*m", "NM": "N*m", "g": "g0", "kg": "kgf", "lb": "lbf"}
_SUPERSCRIPTS = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹·", "-0123456789.")
_TYPOGRAPHY = str.maketrans({"\u2212": "-", "\u00a0": " ", "\u202f": "", "\u2009": " ", "\u00d7": "x"})
_MAX_LENGTH = 200  # characters of a quantity
_POWER_OF_POWER = "'{}' has a power of a power; write m^6 for (m^2)^3"  # such a size would have no bound
MIN_PLURAL = 4  # letters of a unit whose name may have a plural

_Size = tuple[Fraction, dict[str, Fraction]]  # size of a unit in SI, and its dimension: base quantity -> power


def read(value: Any, unit: str) -> float:
    """Return `value`, text such as `0.5 mm` or a bare number in SI, as a float in the SI `unit` ('1' for none).

    Raises InputError with what was found and expected for anything else.  Zero has no sign.
    """
    if isinstance(value, float) and value - value == 0.0:  # a finite number in SI already, as in long axes
        return float(value) or 0.0  # of a long axis the number itself
    number = exact(value, unit)
    try:
        return float(number)
    except OverflowError:
        raise InputError(_not_finite_message(value, unit)) from None


def exact(value: Any, unit: str) -> Fraction:
    """Return `value` in the SI `unit` without rounding; a float counts as the shortest decimal that gives it.

    Raises InputError like `read`.
    """
    if isinstance(value, str):
        return _parse_quantity(value, unit)
    if isinstance(value, bool) or not hasattr(value, "__float__"):
        raise InputError(f"found {quoted(value)}; {expected_text(unit)}")
    try:
        return Fraction(repr(float(value)))
    except (OverflowError, ValueError):
        raise InputError(_not_finite_message(value, unit)) from None


def has_unit(value: Any) -> bool:
    """Return whether a quantity is text with a unit."""
    return bool(_parts(value)[1])


class WrittenUnit(NamedTuple):
    """A unit as the user wrote it: its number times `factor` plus `offset` is the value in SI."""

    unit: str
    factor: float
    offset: float


def written_unit(value: Any, unit: str) -> WrittenUnit | None:
    """Return the unit of a written quantity of the SI `unit`, or None if it has no unit or is not a quantity."""
    unit_name = _parts(value)[1]
    if not unit_name:
        return None
    try:
        value_of_zero, value_of_one = (exact(f"{number} {unit_name}", unit) for number in (0, 1))
    except InputError:
        return None
    return WrittenUnit(unit_name, float(value_of_one - value_of_zero), float(value_of_zero))


def is_unit(name: str) -> bool:
    """Return whether a word is a unit."""
    return not isinstance(_parse_unit(name), str)


def is_bare(value: Any) -> bool:
    """Return whether a quantity is a number without a unit; 0 is the same in every unit and does not count."""
    if isinstance(value, str):
        number, unit_name = _parts(value)
        return number != "" and not unit_name and float(number) != 0.0
    return isinstance(value, int | float) and not isinstance(value, bool) and value != 0


def written_text(value: Any, unit: str) -> str:
    """Return a written quantity, followed by the SI `unit` if it has no unit."""
    text = f"{value:.15g}" if isinstance(value, float) else str(value)
    return text if has_unit(value) or unit in ("1", "") else f"{text} {unit}"


def expected_text(unit: str) -> str:
    """Return the expected form of a quantity of this SI unit, with examples, as the second half of a message."""
    if unit == "1":
        return f"expected a number without unit, such as {_EXAMPLES[unit]}"
    return f"expected a quantity in {unit}, such as {_EXAMPLES.get(unit, f'1e9 {unit} or 1e9')}"


def example_text(unit: str) -> str:
    """Return an example of a quantity of this SI unit."""
    first_example, *_ = re.split(r", | or ", _EXAMPLES.get(unit, f"1e9 {unit}"))
    return first_example


def replace_exponent(unit: str, exponent: float) -> str:
    """Return a unit with `exponent`, or `exponent+1`, replaced by the number: `N/m^1.5`, `N*s/m^2.5`."""
    power = exponent + unit.endswith("+1")
    return unit.removesuffix("+1").replace("^exponent", "" if power == 1 else f"^{power:.15g}")


def dimension_of(unit: str) -> tuple[tuple[str, Fraction], ...]:
    """Return the dimension of an SI unit, as pairs of a base quantity and its power, in order.

    The unit of a column in another unit, such as hours, has no dimension: it accepts plain numbers.
    """
    size, dimension = _require_unit(unit, unit) if unit else (Fraction(1), ())
    return dimension if size == 1 else ()


def unit_of(dimension: tuple[tuple[str, Fraction], ...]) -> str:
    """Return the SI unit of a dimension: a derived unit such as N if there is one, else base units."""
    for unit in _EXAMPLES:
        if dimension_of(unit) == dimension:
            return unit
    factors = [(_BASE_UNITS[name], float(power)) for name, power in dimension]
    numerator, denominator = (
        "*".join(f"{name}^{sign * power:.15g}".removesuffix("^1") for name, power in factors if sign * power > 0.0)
        for sign in (1, -1)
    )
    denominator = f"({denominator})" if "*" in denominator else denominator
    return f"{numerator or 1}/{denominator}" if denominator else numerator


def value_and_dimension(text: str) -> tuple[float, tuple[tuple[str, Fraction], ...]]:
    """Return the quantity in `text`, with a unit or without, in SI, and its dimension; InputError like `read`."""
    number, unit_name = _parts(text)
    if not number:
        raise InputError(f"found {quoted(text)}, which does not begin with a number; expected one such as '5 kN'")
    unit_name = "K" if unit_name in _TEMPERATURES else unit_name
    dimension = _require_unit(unit_name, text)[1] if unit_name not in ("", "%") else ()
    return read(text, unit_of(dimension)), dimension


def _parse_quantity(text: str, unit: str) -> Fraction:
    """Return the quantity in `text` in SI, exactly."""
    if text.strip().lower().lstrip("+-.") in ("inf", "infinity", "nan"):
        raise InputError(_not_finite_message(text, unit))
    digits, unit_name = _parts(text)
    if not digits:
        raise InputError(f"found {quoted(text)}, which does not begin with a number; {expected_text(unit)}")
    if unit_name.startswith(","):
        raise InputError(f"found {quoted(text)}; write a decimal point, not a comma ({expected_text(unit)})")
    zero_offset = Fraction(0)
    if not unit_name:
        scale = Fraction(1)
    elif unit_name in _TEMPERATURES and unit == "K":
        scale, zero_offset = _TEMPERATURES[unit_name]
    elif unit_name == "%" and unit == "1":
        scale = Fraction(1, 100)
    elif unit == "rad/s" and re.fullmatch(_PER_MINUTE, unit_name):  # for a shaft these are turns, as on a rating plate
        scale, _ = _require_unit("rpm", text)
    else:
        scale, dimension = _require_unit(unit_name, text)
        size, expected_dimension = _require_unit(unit, unit)
        scale /= size  # 1, or the unit of a column in hours
        if dimension != expected_dimension:
            meant = _meant_unit(unit_name, expected_dimension)
            hint = f"; did you mean '{digits} {meant}'?" if meant else ""
            message = f"found {quoted(text)}, whose unit {unit_name} has another dimension{hint}; {expected_text(unit)}"
            raise InputError(message)
    approximate = float(digits)  # 0 and infinity would need too much memory as exact digits (1e-999999999)
    if approximate - approximate != 0.0:
        raise InputError(_not_finite_message(text, unit))
    return (Fraction(digits) * scale if approximate else Fraction(0)) + zero_offset


def _parts(value: Any) -> tuple[str, str]:
    """Return number and unit of a written quantity, also with the signs that clearsweep prints; ('', '') if it is none.

    Printed are a minus sign, a power of ten, spaces between groups of digits, and superscripts in units.
    """
    if not isinstance(value, str) or len(value) > _MAX_LENGTH:
        return "", ""
    if not value.isascii():
        value = re.sub(r"\s*x\s*10(?=[⁻⁰¹²³⁴⁵⁶⁷⁸⁹])", "e", value.translate(_TYPOGRAPHY))
        value = re.sub(r"(?<=e)[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+", lambda power: power[0].translate(_SUPERSCRIPTS), value)
        superscript = r"[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+(?:·[⁰¹²³⁴⁵⁶⁷⁸⁹]+)?"
        value = re.sub(superscript, lambda power: f"^{power[0].translate(_SUPERSCRIPTS)}", value)
    match = _QUANTITY.fullmatch(value)
    return (match[1], match[2]) if match else ("", "")


def _meant_unit(unit_name: str, dimension: tuple) -> str:
    """Return the unit of this dimension that a user may have meant by `unit_name`, or '' if none is known."""
    for word, meant in _MISTAKEN_UNITS.items():
        candidate = re.sub(rf"(?<![^\W\d_]){word}(?![^\W_])", meant, _spelled_out(unit_name))
        size_and_dimension = _parse_unit(candidate)
        if not isinstance(size_and_dimension, str) and size_and_dimension[1] == dimension:
            return candidate.strip("()") if candidate.count("(") == 1 else candidate
    return ""


def _spelled_out(unit_name: str) -> str:
    """Return a unit with a sign in its products and the names of the unit table."""

    def factors(word: re.Match) -> str:
        product, power = _PRODUCTS.get(word[1]), word[2] or ""
        return f"({product.replace('-', '')}{power})" if product else word[0]

    spelled = _WORD.sub(factors, unit_name)
    for spelling, name in _SPELLINGS:
        spelled = re.sub(rf"(?<![^\W\d_]){spelling}(?![^\W_])", name, spelled)
    return spelled


def _not_finite_message(value: Any, unit: str) -> str:
    """Return the message for a number beyond the range of floats."""
    return f"found {quoted(value)}, which is not a finite number; {expected_text(unit)}"


def _require_unit(unit_name: str, quantity_text: str) -> tuple[Fraction, tuple]:
    """Return the exact size of a unit in SI and its dimension; InputError cites `quantity_text`."""
    size_and_dimension = _parse_unit(unit_name)
    if isinstance(size_and_dimension, str):
        raise InputError(f"found {quoted(quantity_text)}; {size_and_dimension}")
    return size_and_dimension


@cache
def _parse_unit(unit_name: str) -> tuple[Fraction, tuple] | str:
    """Return size and dimension of a unit, or the reason why it cannot be read."""
    if unit_name == "1":
        return Fraction(1), ()
    if unit_name == "%":
        return "% is allowed only for quantities without a unit"
    try:
        return _Parser(_spelled_out(unit_name), _unit_table()).parsed()
    except _UnitError as error:
        return str(error)
    except (ArithmeticError, ValueError):
        return f"'{unit_name}' cannot be read as a unit; write units such as mm, N*s/m, kg*m^2 or N/m^1.5"


class _UnitError(Exception):
    """The reason why a unit cannot be read."""


class _Parser:
    """A text such as `kg*m^2/s` as a product of units; blanks multiply. ValueError or ArithmeticError if it is none."""

    def __init__(self, text: str, units: Mapping[str, _Size]):
        """Prepare to read `text`; `units` : size of each name."""
        self.text, self.units = text, units
        self.tokens: list[str] = []
        place = 0
        while place < len(text):
            token = _UNIT_TOKEN.match(text, place)
            if not token:
                raise ValueError(text)
            self.tokens.append(token[1])
            place = token.end()
        self.tokens.reverse()  # the next one is the last

    def parsed(self) -> tuple[Fraction, tuple]:
        """Return size in SI and dimension: pairs of a base quantity and its power, in order."""
        size, dimension, _ = self.product()
        if self.tokens:
            raise ValueError(self.text)
        return Fraction(size), tuple(sorted((name, power) for name, power in dimension.items() if power))

    def product(self) -> tuple[Any, dict[str, Fraction], bool]:
        """Return size (a float after a root) and dimension up to the next bracket, and whether a power is in it."""
        size, dimension, has_power = self.factor()
        while self.tokens and self.tokens[-1] != ")":
            sign = -1 if self.tokens[-1] == "/" else 1
            if self.tokens[-1] in "*·/":
                self.tokens.pop()
            factor_size, factor_dimension, factor_has_power = self.factor(sign)
            size *= factor_size
            for name, power in factor_dimension.items():
                dimension[name] = dimension.get(name, Fraction(0)) + power
            has_power |= factor_has_power
        return size, dimension, has_power

    def factor(self, sign: int = 1) -> tuple[Any, dict[str, Fraction], bool]:
        """Return size and dimension of a unit or brackets to a power times `sign`, and whether a power is in it."""
        token = self.tokens.pop() if self.tokens else ""
        if token == "(":
            size, dimension, has_power = self.product()
            if not self.tokens or self.tokens.pop() != ")":
                raise ValueError(self.text)
        elif token == "1":
            return Fraction(1), {}, False
        elif token.isalpha() or token == "°":
            size, dimension = self.size_of(token)
            dimension, has_power = dict(dimension), False
        else:
            raise ValueError(self.text)
        exponent = Fraction(sign)
        if self._is_power_next():
            if has_power:
                raise _UnitError(_POWER_OF_POWER.format(self.text))
            text = re.sub(r"[\s^*()]", "", self.tokens.pop())
            exponent, has_power = sign * Fraction({"²": "2", "³": "3"}.get(text, text)), True
        if self._is_power_next():
            raise _UnitError(_POWER_OF_POWER.format(self.text))
        return size**exponent, {name: power * exponent for name, power in dimension.items()}, has_power

    def _is_power_next(self) -> bool:
        return bool(self.tokens) and re.match(r"\^|\*\*|[²³]", self.tokens[-1]) is not None

    def size_of(self, name: str) -> _Size:
        """Return the size of a unit: its name may have a prefix, and a long name an s at its end."""
        singular = name[:-1] if name.endswith("s") and len(name) > MIN_PLURAL else name
        for unit_name in (name, singular):
            if unit_name in self.units:
                return self.units[unit_name]
            for prefix, factor in _PREFIXES.items():
                if unit_name.startswith(prefix) and unit_name[len(prefix) :] in self.units:
                    size, dimension = self.units[unit_name[len(prefix) :]]
                    return factor * size, dimension
        meant = _MISTAKEN_UNITS.get(name, "")
        suggestion = meant and f"; did you mean '{meant}'?"
        suggestion = suggestion or did_you_mean(name, f"{COMMON_UNITS} {_UNIT_NAMES}".split())
        raise _UnitError(f"unknown unit '{name}'{suggestion} (known: {COMMON_UNITS}, N*s/m, m^2)")


@cache
def _unit_table() -> Mapping[str, _Size]:
    """Return the size of each name of the table."""
    units: dict[str, _Size] = {}
    for line in _UNIT_TABLE.strip().splitlines():
        names, _, size_text = line.partition(" = ")
        number, _, unit_name = size_text.partition(" ")
        if unit_name:
            size, dimension, _ = _Parser(unit_name, units).product()
            entry = Fraction(number) * size, dimension
        else:
            entry = Fraction(1), {number: Fraction(1)}
        units.update(dict.fromkeys(names.split(), entry))
    return units
