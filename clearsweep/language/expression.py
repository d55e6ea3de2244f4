"""Arithmetic on columns of the summary or on user-defined quantities, with a check of units.  Runs no other code.

An expression uses a small part of Python's grammar; everything else is refused.  Allowed are names, numbers,
quantities in quotes ('5 kN'), + - * /, ** with a number, brackets, and the functions below.
"""

import ast
import operator
import re
from collections.abc import Callable, Mapping
from fractions import Fraction
from functools import lru_cache, reduce
from typing import Any, NamedTuple

from . import np, quantity
from .errors import InputError, did_you_mean, quoted

MAX_LENGTH = 500  # characters
DIGITS = 60  # of an exact value; with more it is rounded, as products of products would grow without bound
LARGEST_EXPONENT = 1000  # of ten, of an exact value
LARGEST_POWER, SMALLEST_POWER = 99, Fraction(1, 1000)  # of a base unit
_EXACT_BITS = 200  # of numerator and denominator, up to which a value has at most DIGITS digits
_SUM_OPERATORS: dict[type, Callable] = {ast.Add: operator.add, ast.Sub: operator.sub}
_PRODUCT_OPERATORS: dict[type, tuple[Callable, int]] = {ast.Mult: (operator.mul, 1), ast.Div: (operator.truediv, -1)}
_SIGN_OPERATORS: dict[type, Callable] = {ast.UAdd: operator.pos, ast.USub: operator.neg}
_SAME_UNIT_FUNCTIONS = {"min": "minimum", "max": "maximum"}  # functions of two or more arguments -> name in numpy
_ONE_ARGUMENT_FUNCTIONS = {"abs": Fraction(1), "sqrt": Fraction(1, 2)}  # function -> power of the unit
FUNCTIONS = (*_SAME_UNIT_FUNCTIONS, *_ONE_ARGUMENT_FUNCTIONS)
# a quantity without quotes
_UNQUOTED_QUANTITY = re.compile(r"(?<![\w.])(\d[\d.]*(?:[eE][+-]?\d+)?) *([^\W\d_][^\s,()']*)")

Dimension = dict[str, Fraction]


class Vocabulary(NamedTuple):
    """Words of messages for the names in an expression."""

    noun: str
    unknown_text: str  # text for an unknown name
    example: str


COLUMNS = Vocabulary(
    "columns", "not a column of this grid", "'1 - rod_slider_load_peak / (2 * rod_slider_force_peak_ideal)'"
)
DEFINED = Vocabulary("names of `define`", "not defined under `define`", "= d / 2 + '5 um'")


def unit_of(text: str, units: Mapping[str, str], vocabulary: Vocabulary = COLUMNS) -> str:
    """Return the SI unit ('1' for none) of an expression over names with the SI units `units`.

    Raises InputError with the mistake; an expression of columns has a column.
    """
    if vocabulary is COLUMNS and not names_in(text):
        raise InputError(f"found {quoted(text)}, which contains no column; {_expected_text(COLUMNS)}")
    if "t" in names_in(text, vocabulary) - units.keys():
        raise InputError(
            f"found {quoted(text)}, but an expression has one value and no time t; write what varies with time as a "
            "table instead, such as a file with the columns time [s] and angle [deg]"
        )
    try:
        dimension = _DimensionChecker(units, vocabulary).dimension(_parse(text, vocabulary))
    except RecursionError:
        raise InputError(f"found {quoted(text)}, which is nested too deeply; define its parts by name") from None
    return quantity.unit_of(tuple(sorted(dimension.items())))


def value_of(text: str, columns: "Mapping[str, np.ndarray]") -> "np.ndarray":
    """Return the values (n,) of an expression checked by `unit_of`; NaN if the result is not finite."""
    with np.errstate(all="ignore"):
        values = np.asarray(_evaluate(_parse(text), columns), float)
    finite: np.ndarray = np.where(np.isfinite(values), values, np.nan)
    return finite


def exact_value(text: str, values: Mapping[str, Fraction]) -> Fraction:
    """Return the value (SI) of an expression checked by `unit_of`, with at least DIGITS digits.

    Only sqrt and ** round to fewer, those of a float.  Raises InputError for a division by zero, a root of a negative
    number, or a number too large for a float.
    """
    try:
        exact = Fraction(_evaluate_exactly(_parse(text, DEFINED), values))
        float(exact)
    except ZeroDivisionError:
        raise InputError(f"found {quoted(text)}, which divides by zero") from None
    except (ArithmeticError, ValueError, TypeError) as error:
        raise InputError(f"found {quoted(text)}, which cannot be evaluated: {error}") from None
    return exact


@lru_cache(256)
def _parse(text: str, vocabulary: Vocabulary = COLUMNS) -> ast.expr:
    """Return the syntax tree of an expression; InputError if it cannot be read."""
    if len(text) > MAX_LENGTH:
        raise InputError(f"found {len(text):,} characters; expected at most {MAX_LENGTH}")
    try:
        return ast.parse(text.strip(), mode="eval").body
    except SyntaxError as error:
        position = f" at character {error.offset}" if error.offset else ""
        hint = _hint_text(text, vocabulary)
        message = f"found {quoted(text)}, which cannot be read{position}; {hint}{_expected_text(vocabulary)}"
        raise InputError(message) from None
    except (ValueError, RecursionError, MemoryError):
        raise InputError(f"found {quoted(text)}, which cannot be read; {_expected_text(vocabulary)}") from None


def _hint_text(text: str, vocabulary: Vocabulary) -> str:
    """Return the likely remedy for an expression that cannot be read, or '' if none is known."""
    if text.count("(") > text.count(")") and vocabulary is DEFINED:
        return "inside {} or [] write an expression with a comma in quotes; "
    bare_quantity = next((match for match in _UNQUOTED_QUANTITY.finditer(text) if quantity.is_unit(match[2])), None)
    return f"write a number with a unit in quotes, '{bare_quantity[1]} {bare_quantity[2]}'; " if bare_quantity else ""


def names_in(text: str, vocabulary: Vocabulary = COLUMNS) -> set[str]:
    """Return the names in an expression, without functions."""
    nodes = list(ast.walk(_parse(text, vocabulary)))
    calls = {node.func for node in nodes if isinstance(node, ast.Call)}
    return {node.id for node in nodes if isinstance(node, ast.Name) and node not in calls}


def _quoted_part(node: ast.expr) -> str:
    """Return a part of an expression as a message cites it."""
    try:
        return quoted(ast.unparse(node))
    except RecursionError:
        return "a long part of it"


def _expected_text(vocabulary: Vocabulary) -> str:
    """Return the allowed parts of an expression, as the second half of a message."""
    functions = ", ".join(FUNCTIONS)
    return f"expected {vocabulary.noun}, numbers, + - * / **, brackets, {functions}, such as {vocabulary.example}"


class _DimensionChecker:
    """Dimensions of expressions over known names."""

    def __init__(self, units: Mapping[str, str], vocabulary: Vocabulary):
        self.units, self.vocabulary = units, vocabulary

    def dimension(self, node: ast.expr) -> Dimension:
        """Return the dimension of an expression; InputError if it has none."""
        match node:
            case ast.Constant(value=bool() | None) | ast.Constant(value=complex()) | ast.Constant(value=bytes()):
                raise InputError(f"found {_quoted_part(node)}; {_expected_text(self.vocabulary)}")
            case ast.Constant(value=str(quoted_quantity)):
                return dict(quantity.value_and_dimension(quoted_quantity)[1])
            case ast.Constant(value=int() | float()):
                _signed_number(node)
                return {}
            case ast.Name(id=name):
                if name not in self.units:
                    hint = f"{did_you_mean(name, self.units)} (known: {', '.join(self.units) or 'none'})"
                    raise InputError(f"{quoted(name)} is {self.vocabulary.unknown_text}{hint}")
                return dict(quantity.dimension_of(self.units[name]))
            case ast.UnaryOp(op=operation, operand=operand) if type(operation) in _SIGN_OPERATORS:
                return self.dimension(operand)
            case ast.BinOp(left=left, op=ast.Pow(), right=power):
                return _dimension_power(self.dimension(left), Fraction(repr(_signed_number(power))))
            case ast.BinOp(left=left, op=operation, right=right) if type(operation) in _PRODUCT_OPERATORS:
                exponent = Fraction(_PRODUCT_OPERATORS[type(operation)][1])
                first, second = self.dimension(left), _dimension_power(self.dimension(right), exponent)
                none = Fraction(0)
                return _checked_powers(
                    {name: first.get(name, none) + second.get(name, none) for name in first | second}
                )
            case ast.BinOp(left=left, op=operation, right=right) if type(operation) in _SUM_OPERATORS:
                return self._common_dimension(left, right)
            case ast.Call(func=ast.Name(id=name), args=[_, _, *_] as arguments, keywords=[]) if (
                name in _SAME_UNIT_FUNCTIONS
            ):
                return [self._common_dimension(arguments[0], argument) for argument in arguments[1:]][-1]
            case ast.Call(func=ast.Name(id=name), args=[argument], keywords=[]) if name in _ONE_ARGUMENT_FUNCTIONS:
                return _dimension_power(self.dimension(argument), _ONE_ARGUMENT_FUNCTIONS[name])
        raise InputError(f"found {_quoted_part(node)}; {_expected_text(self.vocabulary)}")

    def _common_dimension(self, left: ast.expr, right: ast.expr) -> Dimension:
        """Return the common dimension of two operands."""
        dimensions = self.dimension(left), self.dimension(right)
        if dimensions[0] == dimensions[1]:
            return dimensions[0]
        texts = [
            f"{_quoted_part(operand)} in {quantity.unit_of(tuple(sorted(dimension.items())))}"
            for operand, dimension in zip((left, right), dimensions, strict=True)
        ]
        raise InputError(
            f"{texts[0]} and {texts[1]} cannot be added or compared; write a number with a unit in quotes, "
            "such as '5 kN'"
        )


def _evaluate(node: Any, columns: "Mapping[str, np.ndarray]") -> Any:
    """Return the value of an expression that `_DimensionChecker.dimension` accepts."""
    match node:
        case ast.Constant(value=str(quoted_quantity)):
            return quantity.value_and_dimension(quoted_quantity)[0]
        case ast.Constant():
            return _signed_number(node)
        case ast.Name(id=name):
            return columns[name]
        case ast.UnaryOp(op=operation, operand=operand):
            return _SIGN_OPERATORS[type(operation)](_evaluate(operand, columns))
        case ast.BinOp(left=left, op=ast.Pow(), right=power):
            return np.asarray(_evaluate(left, columns), float) ** _signed_number(power)
        case ast.BinOp(left=left, op=operation, right=right):
            function = _SUM_OPERATORS.get(type(operation)) or _PRODUCT_OPERATORS[type(operation)][0]
            return function(_evaluate(left, columns), _evaluate(right, columns))
        case ast.Call(func=ast.Name(id=name), args=arguments):
            values = [_evaluate(argument, columns) for argument in arguments]
            return (
                reduce(getattr(np, _SAME_UNIT_FUNCTIONS[name]), values)
                if name in _SAME_UNIT_FUNCTIONS
                else getattr(np, name)(*values)
            )
    raise AssertionError(node)  # `unit_of` has refused it


def _evaluate_exactly(node: Any, values: Mapping[str, Fraction]) -> Fraction:
    """Return the exact value of an expression that `_DimensionChecker.dimension` accepts."""
    match node:
        case ast.Constant(value=str(quoted_quantity)):
            return Fraction(repr(quantity.value_and_dimension(quoted_quantity)[0]))
        case ast.Constant():
            return Fraction(repr(_signed_number(node)))
        case ast.Name(id=name):
            return values[name]
        case ast.UnaryOp(op=operation, operand=operand):
            return Fraction(_SIGN_OPERATORS[type(operation)](_evaluate_exactly(operand, values)))
        case ast.BinOp(left=left, op=ast.Pow(), right=power):
            return _rounded_power(_evaluate_exactly(left, values), _signed_number(power))
        case ast.BinOp(left=left, op=operation, right=right):
            function = _SUM_OPERATORS.get(type(operation)) or _PRODUCT_OPERATORS[type(operation)][0]
            return _rounded(Fraction(function(_evaluate_exactly(left, values), _evaluate_exactly(right, values))))
        case ast.Call(func=ast.Name(id="sqrt"), args=[argument]):
            return _rounded_power(_evaluate_exactly(argument, values), 0.5)
        case ast.Call(func=ast.Name(id=name), args=arguments):
            built_in: Any = {"min": min, "max": max, "abs": abs}[name]
            return Fraction(built_in(*(_evaluate_exactly(argument, values) for argument in arguments)))
    raise AssertionError(node)  # `unit_of` has refused it


def _rounded(value: Fraction) -> Fraction:
    """Return a value with DIGITS digits if it has more; ValueError if it is too large or too small."""
    top, bottom = value.numerator.bit_length(), value.denominator.bit_length()
    if max(top, bottom) <= _EXACT_BITS:
        return value
    exponent = round((top - bottom) * 0.30103)
    if abs(exponent) > LARGEST_EXPONENT:
        raise ValueError(f"a value of the size 1e{exponent}")
    scale = Fraction(10) ** (DIGITS - exponent)
    return round(value * scale) / scale


def _rounded_power(base: Fraction, power: float) -> Fraction:
    """Return a power as floats give it; ValueError if it is not real."""
    result = float(base) ** power
    if isinstance(result, complex):
        raise ValueError("a root of a negative number")
    return Fraction(repr(result))


def _signed_number(node: ast.expr) -> float:
    """Return a written number with its sign."""
    match node:
        case ast.UnaryOp(op=ast.USub(), operand=operand):
            return -_signed_number(operand)
        case ast.Constant(value=int() | float() as value) if not isinstance(value, bool) and abs(value) < 1e300:
            return float(value)
    raise InputError(f"found {_quoted_part(node)}; expected a plain number below 1e300")


def _dimension_power(dimension: Dimension, power: Fraction) -> Dimension:
    """Return a dimension raised to a power."""
    return _checked_powers({name: power * exponent for name, exponent in dimension.items()})


def _checked_powers(powers: Dimension) -> Dimension:
    """Return the powers that are not 0; InputError for one that no unit can be written with."""
    for power in powers.values():
        if power and not SMALLEST_POWER <= abs(power) <= LARGEST_POWER:
            raise InputError(
                f"a unit to the power {float(_rounded(power)):.3g}; expected powers of a size from "
                f"{float(SMALLEST_POWER):g} to {LARGEST_POWER}"
            )
    return {name: power for name, power in powers.items() if power}
