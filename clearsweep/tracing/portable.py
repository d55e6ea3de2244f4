"""Arithmetic for constants and set-up whose bits are the same on every processor.

Libraries choose their code for linear algebra and for elementary functions of arrays by the processor; their last bits
then differ, and chaos amplifies these.  Here linear algebra is exact and rounded once.  Functions of arrays call the C
library for each number.
"""

import functools
import math
import struct
from collections.abc import Callable
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np

NEWTON_STEPS = 6  # for the nodes of a rule; three are enough


def _elementwise(function: Callable[[float], float]) -> Callable[[Any], Any]:
    """Return a function of the C library for a number or an array."""

    @functools.wraps(function)
    def on_arrays(values: Any) -> Any:
        if isinstance(values, float):
            return function(values)
        numbers = np.asarray(values, dtype=float)
        return np.fromiter(map(function, numbers.ravel().tolist()), float, numbers.size).reshape(numbers.shape)[()]

    return on_arrays


sin, cos, tan, asin, atan, atanh, exp, log, log1p = map(
    _elementwise, (math.sin, math.cos, math.tan, math.asin, math.atan, math.atanh, math.exp, math.log, math.log1p)
)
_power = np.frompyfunc(math.pow, 2, 1)


def power(base: Any, exponent: Any) -> Any:
    """Return a power by the C library, of numbers or arrays."""
    return np.asarray(_power(base, exponent), dtype=float)[()]


class Exact(NamedTuple):
    """A matrix of rational numbers."""

    rows: list[list[int]]
    denominator: int

    def __matmul__(self, other: "Exact") -> "Exact":
        columns = list(zip(*other.rows, strict=True))
        rows = [[sum(map(int.__mul__, row, column)) for column in columns] for row in self.rows]
        return Exact(rows, self.denominator * other.denominator)

    @property
    def transposed(self) -> "Exact":
        """Return the matrix with rows and columns exchanged."""
        return Exact([list(column) for column in zip(*self.rows, strict=True)], self.denominator)

    def rounded(self) -> np.ndarray:
        """Return the matrix as floats, each the nearest."""
        return np.array([[number / self.denominator for number in row] for row in self.rows])


def exact(matrix: Any) -> Exact:
    """Return the matrix of rows of floats."""
    ratios = [[number.as_integer_ratio() for number in row] for row in np.asarray(matrix, dtype=float).tolist()]
    denominator = math.lcm(*(divisor for row in ratios for _, divisor in row))
    return Exact([[numerator * (denominator // divisor) for numerator, divisor in row] for row in ratios], denominator)


def inverse(matrix: Exact) -> Exact:
    """Return the inverse of a square matrix by elimination without fractions (Bareiss 1968, Math. Comput. 22:565)."""
    size = len(matrix.rows)
    rows = [[*row, *(int(i == j) for j in range(size))] for i, row in enumerate(matrix.rows)]
    previous_pivot = 1
    for k in range(size):
        pivot = next(i for i in range(k, size) if rows[i][k] != 0)
        rows[k], rows[pivot] = rows[pivot], rows[k]
        for i in range(size):
            if i != k:
                factor, divisor = rows[i][k], rows[k][k]
                rows[i] = [(divisor * a - factor * b) // previous_pivot for a, b in zip(rows[i], rows[k], strict=True)]
        previous_pivot = rows[k][k]
    return Exact([[number * matrix.denominator for number in row[size:]] for row in rows], previous_pivot)


def least_squares(matrix: Exact) -> Exact:
    """Return the matrix that maps values to the coefficients of the closest combination of columns."""
    return inverse(matrix.transposed @ matrix) @ matrix.transposed


def powers(points: Any, count: int) -> Exact:
    """Return the first `count` powers of each point, from 0 on, a row per point."""
    (row,), unit = exact([points])
    return Exact([[n**i * unit ** (count - 1 - i) for i in range(count)] for n in row], unit ** (count - 1))


def coefficients_through(points: Any) -> Exact:
    """Return the inverse of the square matrix `powers` of the places, from Lagrange's polynomials.

    It maps values at the points to the coefficients, by powers, of the polynomial through them.
    """
    (row,), unit = exact([points])
    full_product = [1]  # the product of all (unit x - n), the constant first
    for n in row:
        full_product = [unit * a - n * b for a, b in zip([0, *full_product], [*full_product, 0], strict=True)]
    polynomials, scales = [], []
    for n in row:
        quotient = [full_product[-1] // unit]  # `full_product` divided by (unit x - n)
        for c in full_product[-2:0:-1]:
            quotient.append((c + n * quotient[-1]) // unit)
        polynomials.append(quotient[::-1])
        scales.append(math.prod(n - other_node for other_node in row if other_node != n))
    denominator = math.lcm(*scales)
    columns = [
        [c * (denominator // scale) for c in quotient] for quotient, scale in zip(polynomials, scales, strict=True)
    ]
    return Exact(columns, denominator).transposed


def integrals_through(points: Any) -> Exact:
    """Return the integrals from 0 to x, divided by x, of the Lagrange polynomials of points: a row of powers each."""
    rows, denominator = coefficients_through(points).transposed
    multiple = math.lcm(*range(1, len(rows) + 1))
    return Exact([[c * (multiple // (k + 1)) for k, c in enumerate(row)] for row in rows], denominator * multiple)


def polynomial_through(function: Callable, degree: int) -> np.ndarray:
    """Return the coefficients, by powers, of the polynomial through a function at `chebyshev_points`."""
    points = chebyshev_points(degree + 1)
    return (coefficients_through(points) @ exact(function(points)[:, None])).rounded()[:, 0]


def chebyshev_points(count: int) -> np.ndarray:
    """Return `count` increasing multiples of 1/4096 next to Chebyshev's points between 0 and 1.

    Exact arithmetic is fast with short numbers.
    """
    return np.array([round(2048.0 - 2048.0 * math.cos(math.pi * (i + 0.5) / count)) / 4096.0 for i in range(count)])


def _legendre(degree: int, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return Legendre's polynomial and its slope at points between -1 and 1."""
    previous_value, value = np.zeros(x.size), np.ones(x.size)
    for n in range(degree):
        previous_value, value = value, ((2 * n + 1) * x * value - n * previous_value) / (n + 1)
    return value, degree * (previous_value - x * value) / (1.0 - x * x)


def gauss_rule(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return nodes and weights of Gauss's rule on -1 to 1."""
    nodes = -cos(math.pi * (np.arange(count) + 0.75) / (count + 0.5))
    for _ in range(NEWTON_STEPS):
        value, slope = _legendre(count, nodes)
        nodes = nodes - value / slope
        nodes = 0.5 * (nodes - nodes[::-1])  # symmetric
    _, slope = _legendre(count, nodes)
    return nodes, 2.0 / ((1.0 - nodes * nodes) * slope * slope)


def lobatto_rule(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return nodes and weights of Lobatto's rule on -1 to 1, whose first and last nodes are the ends."""
    degree = count - 1
    inner = -cos(math.pi * np.arange(1, degree) / degree)
    for _ in range(NEWTON_STEPS):
        value, slope = _legendre(degree, inner)
        curvature = (2.0 * inner * slope - degree * count * value) / (1.0 - inner * inner)
        inner = inner - slope / curvature
        inner = 0.5 * (inner - inner[::-1])
    value, _ = _legendre(degree, inner)
    end_nodes = np.ones(1)
    return np.concatenate([-end_nodes, inner, end_nodes]), 2.0 / (
        degree * count * np.concatenate([end_nodes, value**2, end_nodes])
    )


def product(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return a @ b for an array b (n,) or (n, m), with sums in an order that is the same on every processor.

    OpenBLAS, which numpy takes for `@`, has code of its own for each processor.
    """
    result: np.ndarray = np.einsum("...i,i->..." if np.ndim(b) == 1 else "...i,ij->...j", a, b)
    return result


def solve(matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Return x (n,) of matrix x = right for a matrix (n, n), by Gauss and Jordan's elimination with pivots."""
    rows, count = np.column_stack([matrix, right]), len(matrix)
    for k in range(count):
        pivot = k + int(np.argmax(np.abs(rows[k:, k])))
        rows[[k, pivot]] = rows[[pivot, k]]
        rows[k] /= rows[k, k]
        others = np.arange(count) != k
        rows[others] -= np.outer(rows[others, k], rows[k])
    return rows[:, -1]


def line_through(x: np.ndarray, y: np.ndarray, weights: np.ndarray) -> tuple[float, float]:
    """Return slope and value at 0 of the line with the least weighted sum of squared distances in y."""
    total = math.fsum(weights)
    middle_x, middle_y = math.fsum(weights * x) / total, math.fsum(weights * y) / total
    slope = math.fsum(weights * (x - middle_x) * (y - middle_y)) / math.fsum(weights * (x - middle_x) ** 2)
    return slope, middle_y - slope * middle_x


# ----------------------------------------------------------------------------------------------------------------------
# Operations from which elementary functions are made, of floats; `loops` emits them of symbols.
#
# Each is exact or rounded once, as IEEE 754 prescribes, so its bits are the same on every machine.  Integers are int64
# patterns of bits: `+ - & >> <<` on them wrap around when `number_of` reads them.


_ALL_BITS = (1 << 64) - 1  # bits of a number


def fma(a: float, b: float, c: float) -> float:
    """Return a b + c, rounded once."""
    plain = a * b + c
    if a == 0.0 or b == 0.0 or not all(map(math.isfinite, (a, b, c))):
        return plain
    exact = Fraction(a) * Fraction(b) + Fraction(c)
    if not exact:
        return plain  # a zero with its sign
    try:
        return float(exact) or (0.0 if exact > 0 else -0.0)
    except OverflowError:
        return math.inf if exact > 0 else -math.inf


def where(condition: Any, a: Any, b: Any) -> Any:
    """Return `a` where the condition is true, else `b`; both are computed."""
    return a if condition else b


def bits_of(x: float) -> int:
    """Return the 64 bits of a number as an int64."""
    return int(struct.unpack("<q", struct.pack("<d", x))[0])


def number_of(bits: int) -> float:
    """Return the number of these bits; those above the 64th are dropped."""
    return float(struct.unpack("<d", struct.pack("<Q", int(bits) & _ALL_BITS))[0])
