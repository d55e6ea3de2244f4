"""Elementary functions: accurate to a unit in the last place, right at their limits, the same bits in every form."""

import decimal
import functools
import itertools
import math
import sys
from decimal import Decimal
from fractions import Fraction

import numpy as np
import pytest

from clearsweep.tracing import functions, portable
from clearsweep.tracing.compiled.choosing import rolled_range
from clearsweep.tracing.objects import machine_code

PI = Decimal("3.14159265358979323846264338327950288419716939937510582097494459230781640628620899862803482534211706798")
OF_ONE = ("exp", "expm1", "tanh", "sinh", "cosh", "log", "log2", "log1p", "sin", "cos", "atan")
OF_TWO = ("pow", "atan2")
COUNT = 120  # arguments of each range
PIECE = 128  # numbers that one call of machine code takes
TINY, LARGE = 5e-324, 1.7976931348623157e308
SPECIAL = [
    *(0.0, 0.25, 0.5, 1.0, 1.5, 2.0, 3.0, 1.0 - 2.0**-53, 1.0 + 2.0**-52, math.inf, TINY, 1e-310, 2.0**-1022, LARGE),
    *(1e-300, 1e300, 1e-20, 22.0, 37.5, 40.0, 709.782712893384, 709.7827128933841, 710.4758600739439, 745.13, 745.14),
    *(711.0, 2.0**52 - 0.5, 2.0**52 + 1.0, 2.0**53 - 1.0, 2.0**53, 2.0**60),
]
SPECIAL = [*SPECIAL, *(-x for x in SPECIAL), math.nan]


# ---------------------------------------------------------------------------------------------- exact values


def cos_and_sin(x):
    """Return cosine and sine of a Decimal."""
    turns = (x / (PI / 2)).to_integral_value()
    r = x - turns * PI / 2
    terms = list(itertools.accumulate(range(1, 50), lambda term, i: term * r / i, initial=Decimal(1)))
    c = sum(term if i % 4 == 0 else -term for i, term in enumerate(terms) if i % 2 == 0)
    s = sum(term if i % 4 == 1 else -term for i, term in enumerate(terms) if i % 2 == 1)
    return ((c, s), (-s, c), (-c, -s), (s, -c))[int(turns) % 4]


def angle(y, x):
    """Return atan2 of Decimals by a step of third order from the float's."""
    big = max(abs(x), abs(y))
    start = Decimal(math.atan2(float(y / big), float(x / big)))
    c, s = cos_and_sin(start)
    return start + (y * c - x * s) / (x * c + y * s)


def power(x, y):
    return (y * x.ln()).exp()


EXACT = {
    "exp": lambda x: x.exp(),
    "expm1": lambda x: x.exp() - 1,
    "tanh": lambda x: 1 - 2 / ((2 * x).exp() + 1),
    "sinh": lambda x: (x.exp() - (-x).exp()) / 2,
    "cosh": lambda x: (x.exp() + (-x).exp()) / 2,
    "log": lambda x: x.ln(),
    "log2": lambda x: x.ln() / Decimal(2).ln(),
    "log1p": lambda x: (1 + x).ln(),
    "sin": lambda x: cos_and_sin(x)[1],
    "cos": lambda x: cos_and_sin(x)[0],
    "atan": lambda x: angle(x, Decimal(1)),
    "pow": power,
    "atan2": angle,
}


def drawn(name):
    """Yield arrays of arguments of a function."""
    draw = np.random.default_rng(11)

    def uniform(low, high):
        return draw.uniform(low, high, COUNT)

    def spread(low, high):
        return 2.0 ** uniform(low, high)

    quarters = np.round(uniform(-1e6, 1e6)) * (0.5 * math.pi)
    middle = math.tan(math.pi / 8.0) + 1e-9 * uniform(-1.0, 1.0)
    exponents = draw.choice([0.25, -0.125, 0.5, 0.146, -0.237], COUNT)
    some = {
        "exp": [uniform(-745.0, 709.7), draw.normal(size=COUNT)],
        "expm1": [uniform(-45.0, 709.7), uniform(-1.5, 1.5), -spread(-70.0, 0.0)],
        "tanh": [uniform(-24.0, 24.0), uniform(-1.0, 1.0), spread(-70.0, 0.0)],
        "sinh": [uniform(-710.0, 710.0), uniform(-2.0, 2.0), spread(-70.0, 0.0)],
        "cosh": [uniform(-710.0, 710.0), uniform(-2.0, 2.0)],
        "log": [spread(-1074.0, 1024.0), uniform(0.5, 2.0), 1.0 + spread(-52.0, 0.0), 1.0 - spread(-53.0, -1.0)],
        "log1p": [spread(-100.0, 1024.0), uniform(-1.0, 3.0), -spread(-70.0, 0.0), spread(-52.0, -1.0) - 1.0],
        "sin": [uniform(-7.0, 7.0), uniform(-1e6, 1e6), spread(-30.0, 40.0), quarters],
        "atan": [spread(-1022.0, 1023.0), draw.normal(size=COUNT), middle],
        "atan2": [draw.normal(size=(2, COUNT)), (spread(-1e3, 1e3), -spread(-1e3, 1e3)), (-middle, uniform(-1.0, 1.0))],
        "pow": [
            (spread(-1074.0, 1024.0), exponents),
            (spread(-600.0, 600.0), np.full(COUNT, 1.5)),
            (1.0 + spread(-40.0, -1.0), uniform(-1700.0, 1700.0)),
            (uniform(0.5, 10.0), uniform(-300.0, 300.0)),
        ],
    }
    some |= {"log2": some["log"], "cos": some["sin"]}
    return [np.atleast_2d(x) for x in some[name]]


def given(name):
    """Return arguments of a function: drawn and special ones."""
    special = itertools.product(SPECIAL, repeat=2 if name in OF_TWO else 1)
    return np.concatenate([*drawn(name), np.array(list(special)).T], axis=1)


@functools.cache
def compiled(name):
    """Return machine code that writes a function of arrays of PIECE numbers to another one."""
    function = getattr(functions, name)

    def of_one(x, values):
        for i in rolled_range(PIECE):
            values[i] = function(x[i])

    def of_two(x, y, values):
        for i in rolled_range(PIECE):
            values[i] = function(x[i], y[i])

    return machine_code(of_two if name in OF_TWO else of_one)


def on_arrays(name, arguments):
    """Return a function of arrays, by machine code."""
    arguments = np.atleast_2d(arguments)
    pieces = np.pad(arguments, ((0, 0), (0, -arguments.shape[1] % PIECE))).reshape(len(arguments), -1, PIECE)
    values = np.zeros(pieces.shape[1:])
    for k, row in enumerate(values):
        compiled(name)(*(piece.copy() for piece in pieces[:, k]), row)
    return values.ravel()[: arguments.shape[1]]


def error(result, exact):
    """Return the error of a float in units in the last place of the exact value."""
    unit = Decimal(math.ulp(float(exact)))
    return abs(Decimal(result) - exact) / unit


@pytest.mark.parametrize("name", [*OF_ONE, *OF_TWO])
def test_error_is_below_a_unit_in_the_last_place(name):
    with decimal.localcontext(decimal.Context(prec=60, Emin=-9999, Emax=9999)):
        for arguments in drawn(name):
            for result, *exact in zip(on_arrays(name, arguments), *arguments, strict=True):
                expected = EXACT[name](*map(Decimal, map(float, exact)))
                assert error(float(result), expected) < 0.9, (name, exact)


# ---------------------------------------------------------------------------------------------- limits


def library(name, *x):
    """Return what the machine's C library says, by numpy, which raises nothing."""
    called = {"pow": "power", "atan": "arctan", "atan2": "arctan2"}.get(name, name)
    with np.errstate(all="ignore"):
        return float(getattr(np, called)(*map(np.float64, x)))


def agrees(a, b):
    if math.isnan(a) or math.isnan(b) or math.isinf(b) or b == 0.0:
        return (math.isnan(a) and math.isnan(b)) or (a == b and math.copysign(1.0, a) == math.copysign(1.0, b))
    return abs(a - b) <= 1.5 * math.ulp(b)


@pytest.mark.parametrize("name", [*OF_ONE, *OF_TWO])
def test_special_arguments_give_the_values_of_the_c_standard(name):
    arguments = np.array(list(itertools.product(SPECIAL, repeat=2 if name in OF_TWO else 1))).T
    for result, *x in zip(on_arrays(name, arguments), *arguments, strict=True):
        if name in ("sin", "cos") and abs(x[0]) > functions.MAX_ANGLE:
            assert math.isnan(result)
        elif not (name == "pow" and x[1] == 0.5):  # numpy takes the square root, which differs for -0 and -inf
            assert agrees(float(result), library(name, *x)), (name, x)


def test_powers_of_negative_numbers_are_those_of_c():
    assert functions.pow(-2.0, 3.0) == -8.0
    assert functions.pow(-2.0, -2.0) == 0.25
    assert math.isnan(functions.pow(-2.0, 0.5))
    assert functions.pow(-math.inf, 0.5) == math.inf
    assert math.copysign(1.0, functions.pow(-0.0, 0.5)) == 1.0
    assert functions.pow(-1.0, 2.0**53 - 1.0) == -1.0


def test_exact_values_stay_exact():
    assert [functions.log2(2.0**n) for n in range(-1074, 1024)] == list(range(-1074, 1024))
    assert [functions.pow(2.0, float(n)) for n in range(-1074, 1024, 7)] == [2.0**n for n in range(-1074, 1024, 7)]
    assert [functions.pow(float(n), 2.0) for n in range(1, 300)] == [float(n * n) for n in range(1, 300)]
    assert functions.exp(0.0) == functions.cos(0.0) == functions.cosh(0.0) == 1.0
    assert functions.log(1.0) == 0.0
    assert functions.exp(1.0) == math.e
    assert functions.atan2(0.0, -1.0) == math.pi


# ---------------------------------------------------------------------------------------------- shape


def neighbours(x, count=200):
    """Return the floats around x, from below to above."""
    spacing = math.ulp(x)
    return x + spacing * np.arange(-count, count + 1)


ROOT = math.sqrt(0.5)
BREAKS = {
    "exp": [math.log(2.0) * (n + 0.5) for n in (-1021, -2, -1, 0, 1, 500)] + [-708.396418532264],
    "expm1": [math.log(2.0) * (n + 0.5) for n in (-50, -2, -1, 0, 1, 53, 54, 55, 500)] + [2.0**-54, -40.0, 1e-12],
    "log": [ROOT, 2.0 * ROOT, 2.0**-1022, 2.0**20 * ROOT],
    "log2": [ROOT, 2.0 * ROOT, 2.0**-1022],
    "log1p": [ROOT - 1.0, 2.0 * ROOT - 1.0, 4.0 * ROOT - 1.0, 2.0**-54, 2.0**53, 2.0**60 * ROOT, 1e-9],
    "tanh": [math.log(2.0) * (n + 0.5) / 2.0 for n in (0, 1, 2, 25)] + [2.0**-28, 22.0, 18.7],
    "sinh": [math.log(2.0) * (n + 0.5) for n in (0, 1, 2, 55)] + [2.0**-28, 40.0, 0.22314355131420976],
    "cosh": [math.log(2.0) * (n + 0.5) for n in (0, 1, 2, 55)] + [40.0, 710.0],
    "atan": [math.tan(math.pi / 8.0), 1.0, math.tan(3.0 * math.pi / 8.0), 2.0**400],
    "sin": [math.pi / 4.0, 2.0**-27, 8.25 * math.pi],
}


@pytest.mark.parametrize("name", BREAKS)
def test_no_step_back_where_pieces_meet(name):
    for place in BREAKS[name]:
        values = on_arrays(name, [neighbours(place)])
        assert np.all(np.diff(values) >= -np.spacing(np.abs(values[1:])) * (name in ("log1p", "sin"))), place
        assert values[-1] >= values[0]


def test_odd_functions_are_odd():
    for name in ("sin", "tanh", "sinh", "atan"):
        x = given(name)
        positive, negative = on_arrays(name, x), on_arrays(name, -x)
        assert np.array_equal(
            positive.view(np.int64)[~np.isnan(positive)], (-negative).view(np.int64)[~np.isnan(negative)]
        )


# ---------------------------------------------------------------------------------------------- bits


def same_bits(a, b):
    return (math.isnan(a) and math.isnan(b)) or portable.bits_of(a) == portable.bits_of(b)


class Fusing:
    """A number that may fuse a sum with a product made in the same function, as symbols do."""

    def __init__(self, value, factors=None, frame=None):
        self.value, self.factors, self.frame = value, factors, frame

    def __mul__(self, other):
        a, b = value_of(self), value_of(other)
        return Fusing(a * b, (a, b), sys._getframe(1))

    __rmul__ = __mul__

    def __add__(self, other):
        return fused(self, other, 1.0, sys._getframe(1))

    def __radd__(self, other):
        return fused(other, self, 1.0, sys._getframe(1))

    def __sub__(self, other):
        return fused(self, other, -1.0, sys._getframe(1))

    def __rsub__(self, other):
        return fused(other, self, -1.0, sys._getframe(1))

    def __truediv__(self, other):
        return Fusing(value_of(self) / value_of(other))

    def __rtruediv__(self, other):
        return Fusing(value_of(other) / value_of(self))

    def __neg__(self):
        return Fusing(-self.value)

    def __abs__(self):
        return Fusing(abs(self.value))

    def __lt__(self, other):
        return self.value < value_of(other)

    def __le__(self, other):
        return self.value <= value_of(other)

    def __gt__(self, other):
        return self.value > value_of(other)

    def __ge__(self, other):
        return self.value >= value_of(other)

    def __eq__(self, other):
        return self.value == value_of(other)

    def __ne__(self, other):
        return self.value != value_of(other)

    __hash__ = None


#: What the functions call on such numbers.
OPERATIONS = {
    "fma": lambda *factors: Fusing(portable.fma(*map(value_of, factors))),
    "copysign": lambda a, b: Fusing(math.copysign(value_of(a), value_of(b))),
    "bits_of": lambda x: portable.bits_of(value_of(x)),
}


def value_of(x):
    return x.value if isinstance(x, Fusing) else float(x)


def is_same(a, b):
    return a == b or (math.isnan(a) and math.isnan(b))


def fused(a, b, sign, frame):
    """Return a + sign b, once it is seen that a fused product made in `frame` gives the same."""
    x, y = value_of(a), value_of(b)
    plain = x + sign * y
    if isinstance(a, Fusing) and a.frame is frame:
        assert is_same(portable.fma(*a.factors, sign * y), plain), frame.f_lineno
    if isinstance(b, Fusing) and b.frame is frame:
        assert is_same(portable.fma(sign * b.factors[0], b.factors[1], x), plain), frame.f_lineno
    return Fusing(plain)


@pytest.mark.few("exp", "sin", "pow", "atan2")
@pytest.mark.parametrize("name", [*OF_ONE, *OF_TWO])
def test_floats_machine_code_and_fusing_numbers_have_the_same_bits(name, monkeypatch):
    arguments, function = given(name), getattr(functions, name)
    arguments = arguments[:, :: max(1, arguments.shape[1] // 500)]
    results, plain = on_arrays(name, arguments), [function(*x) for x in arguments.T.tolist()]
    for operation, on_fusing in OPERATIONS.items():
        monkeypatch.setattr(functions, operation, on_fusing)
    for result, expected, first in zip(results.tolist(), plain, arguments.T.tolist(), strict=True):
        assert same_bits(expected, result), (name, first)
        assert same_bits(expected, value_of(function(*map(Fusing, first)))), (name, first)


def test_fused_products_are_rounded_once():
    draw = np.random.default_rng(3)
    a, b = draw.normal(size=(2, 3000)) * 2.0 ** draw.uniform(-300.0, 300.0, (2, 3000))
    near = -(a * b) * (1.0 + draw.integers(-2, 3, 3000) * 2.0**-52)
    for c in (near, near * 2.0 ** draw.uniform(-70.0, 70.0, 3000), np.zeros(3000)):
        exact = [float(Fraction(x) * Fraction(y) + Fraction(z)) for x, y, z in zip(a, b, c, strict=True)]
        assert list(map(portable.fma, a.tolist(), b.tolist(), c.tolist())) == exact
    fused_sum = machine_code(portable.fma)
    for x, y, z in itertools.product((0.0, -0.0, TINY, -1e-200, 1.0, 1e200, -LARGE, math.inf, math.nan), repeat=3):
        if not (math.isinf(x * y) and math.isinf(z)):  # of finite numbers the product overflows in Python alone
            assert same_bits(portable.fma(x, y, z), fused_sum(x, y, z))


def test_bits_go_there_and_back():
    for x in SPECIAL:
        assert same_bits(portable.number_of(portable.bits_of(x)), x)
    assert portable.number_of((portable.bits_of(1.0) << 12) + (1 << 64)) == portable.number_of(0x3FF << 64)


# ---------------------------------------------------------------------------------------------- coefficients


def interpolated(series, low, high, count):
    """Return the polynomial through a series at Chebyshev nodes (rounded to 2^-20), computed in rational numbers."""
    roots = [math.cos(math.pi * (2 * i + 1) / (2 * count)) for i in range(count)]
    nodes = [Fraction(round(2**20 * (0.5 * (low + high) + 0.5 * (high - low) * root)), 2**20) for root in roots]
    differences = [sum(c * node**i for i, c in enumerate(series)) for node in nodes]
    for order in range(1, count):
        for i in range(count - 1, order - 1, -1):
            differences[i] = (differences[i] - differences[i - 1]) / (nodes[i] - nodes[i - order])
    result = [Fraction(0)]
    for node, difference in zip(reversed(nodes), reversed(differences), strict=True):
        moved = [Fraction(0), *result]
        result = [a - node * b for a, b in zip(moved, [*result, 0], strict=True)]
        result[0] += difference
    return tuple(float(c) for c in result[:count])


HALF = 0.5 * math.log(2.0) * 1.0001
LARGEST_S = (3.0 - 2.0 * math.sqrt(2.0)) ** 2 * 1.0001
LARGEST_R = (math.pi / 4.0 + 1e-3) ** 2
LARGEST_T = (math.sqrt(2.0) - 1.0) ** 2 * 1.0001


@pytest.mark.parametrize(
    ("name", "term", "terms", "low", "high"),
    [
        ("EXPONENTIAL", lambda k: Fraction(1, math.factorial(k + 2)), 30, -HALF, HALF),
        ("LOGARITHM", lambda k: Fraction(2, 2 * k + 3), 40, 0.0, LARGEST_S),
        ("LOGARITHM_TAIL", lambda k: Fraction(2, 2 * k + 5), 40, 0.0, LARGEST_S),
        ("SINE", lambda k: Fraction((-1) ** (k + 1), math.factorial(2 * k + 3)), 30, 0.0, LARGEST_R),
        ("COSINE", lambda k: Fraction((-1) ** k, math.factorial(2 * k + 4)), 30, 0.0, LARGEST_R),
        ("ARC", lambda k: Fraction((-1) ** (k + 1), 2 * k + 3), 60, 0.0, LARGEST_T),
    ],
)
def test_coefficients_are_what_they_are_said_to_be(name, term, terms, low, high):
    kept = getattr(functions, name)
    assert kept == interpolated([term(k) for k in range(terms)], low, high, len(kept))
