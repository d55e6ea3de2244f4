"""Operations from which elementary functions are made, for floats, numpy arrays of float64 and symbols.

Each is exact or rounded once, as IEEE 754 prescribes, so its bits are the same on every machine.  A symbol names the
class that emits its operations in the attribute `operations`; that class has the same static methods as `Floats`.
Integers are int64 patterns of bits: `+ - & >> <<` on them wrap around when `number_of` reads them.
"""

import math
import struct
from fractions import Fraction
from typing import Any

import numpy as np

_ALL_BITS = (1 << 64) - 1  # bits of a number


class Floats:
    """Operations on Python's floats."""

    @staticmethod
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

    @staticmethod
    def where(condition: Any, a: Any, b: Any) -> Any:
        """Return `a` where the condition is true, else `b`."""
        return a if condition else b

    @staticmethod
    def bits_of(x: float) -> int:
        """Return the 64 bits of a number as an int64."""
        return struct.unpack("<q", struct.pack("<d", x))[0]

    @staticmethod
    def number_of(bits: int) -> float:
        """Return the number of these bits; those above the 64th are dropped."""
        return struct.unpack("<d", struct.pack("<Q", bits & _ALL_BITS))[0]

    @staticmethod
    def copysign(x: float, sign: float) -> float:
        """Return |x| with a sign."""
        return math.copysign(x, sign)


class Arrays:
    """Operations on arrays of float64."""

    @staticmethod
    def fma(a: Any, b: Any, c: Any) -> np.ndarray:
        """Return a b + c, rounded once.

        References
        ----------
        Boldo & Melquiond 2008, IEEE Trans. Computers 57:462: the small parts are summed with rounding to odd.
        """
        a, b, c = (np.array(x, dtype=float) for x in np.broadcast_arrays(a, b, c))
        with np.errstate(all="ignore"):
            product = a * b
            plain = product + c
            high, sum_low = _two_sum(c, _product_error(a, b, product))
            total, remaining = _two_sum(product, high)
            fused = total + _sum_to_odd(sum_low, remaining)
            magnitude = np.maximum(np.abs(product), np.maximum(np.abs(a), np.maximum(np.abs(b), np.abs(c))))
            is_splittable = (magnitude < 2.0**990) & (np.abs(product) > 2.0**-960)  # else an error overflows or is lost
        finite = np.isfinite(a) & np.isfinite(b) & np.isfinite(c) & (a != 0.0) & (b != 0.0)
        result = np.where(finite, fused, plain)
        for index in zip(*np.nonzero(finite & ~is_splittable), strict=True):
            result[index] = Floats.fma(float(a[index]), float(b[index]), float(c[index]))
        return result

    where = staticmethod(np.where)
    copysign = staticmethod(np.copysign)

    @staticmethod
    def bits_of(x: np.ndarray) -> np.ndarray:
        """Return the 64 bits of numbers as int64."""
        return x.view(np.int64)

    @staticmethod
    def number_of(bits: np.ndarray) -> np.ndarray:
        """Return the numbers of these bits."""
        return bits.view(np.float64)


def _two_sum(a: Any, b: Any) -> tuple[np.ndarray, np.ndarray]:
    """Return a + b and its rounding error (Knuth 1998, The Art of Computer Programming 2, section 4.2.2)."""
    total = a + b
    b_rounded = total - a
    return total, (a - (total - b_rounded)) + (b - b_rounded)


def _product_error(a: np.ndarray, b: np.ndarray, product: np.ndarray) -> np.ndarray:
    """Return a b - product (Dekker 1971, Numer. Math. 18:224)."""
    (a_high, a_low), (b_high, b_low) = _split(a), _split(b)
    return ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low


def _split(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return two parts of at most 26 bits."""
    scaled = 134217729.0 * x  # 2^27 + 1
    high = scaled - (scaled - x)
    return high, x - high


def _sum_to_odd(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return a + b or, if it is not exact, the neighbour of the exact sum whose last bit is set."""
    total, error = _two_sum(a, b)
    bits = total.view(np.int64)
    shifted_bits = bits + np.where((error > 0.0) == (total > 0.0), 1, -1)
    return np.where((error != 0.0) & (bits & 1 == 0), shifted_bits, bits).view(np.float64)


def _operations_for(*operands: Any) -> Any:
    """Return the class of operations for the first value that is not a plain number."""
    for x in operands:
        if isinstance(x, np.ndarray):
            return Arrays
        if hasattr(x, "operations"):
            return x.operations
    return Floats


def fma(a: Any, b: Any, c: Any) -> Any:
    """Return a b + c, rounded once."""
    return _operations_for(a, b, c).fma(a, b, c)


def where(condition: Any, a: Any, b: Any) -> Any:
    """Return `a` where the condition is true, else `b`; both are computed."""
    return _operations_for(condition).where(condition, a, b)


def bits_of(x: Any) -> Any:
    """Return the 64 bits of a number as an int64."""
    return _operations_for(x).bits_of(x)


def number_of(bits: Any) -> Any:
    """Return the number of these 64 bits."""
    return _operations_for(bits).number_of(bits)


def copysign(x: Any, sign: Any) -> Any:
    """Return |x| with the sign of `sign`."""
    return _operations_for(x, sign).copysign(x, sign)
