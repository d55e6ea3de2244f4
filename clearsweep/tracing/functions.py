"""Elementary functions whose bits are the same on every machine, for one number and for numbers in lanes.

They use only `+ - * /`, fma, comparisons, selections and operations on bits (`portable`), so they run on floats and
symbols.  An inexact product enters a sum by fma or by `product`, so nothing can be contracted.

Largest error in units in the last place, over 9 to 18 million random arguments, against 80-bit extended precision:

| function | error | | function | error | | function | error |
| --- | --- | --- | --- | --- | --- | --- | --- |
| exp | 0.64, denormal 0.75 | | cosh | 0.64 | | sin, cos (to 2^40 rad) | 0.83 |
| expm1 | 0.61 | | log | 0.86 | | atan | 0.70 |
| tanh | 0.56 | | log1p | 0.83 | | atan2 | 0.75 |
| sinh | 0.58 | | log2 | 0.50 | | pow | 0.88 |

References
----------
Cody & Waite 1980, Software Manual for the Elementary Functions: argument reduction.
Muller 2016, Elementary Functions, 3rd ed.: double-word arithmetic, reduction with fma, Estrin's scheme.
Dekker 1971, Numer. Math. 18:224: sums and products of two words.
"""

import math
from math import copysign
from typing import Any

from .portable import bits_of, fma, number_of, where

# ----------------------------------------------------------------------------------------------------------------------
# Coefficients of the polynomials of elementary functions, lowest power first.
#
# They interpolate Taylor series at Chebyshev nodes, which is nearly minimax, and are computed in rational arithmetic
# and rounded; tests/test_trace_functions.py computes them again.


EXPONENTIAL = (  # (e^r - 1 - r) / r^2 for |r| <= ln(2) / 2, in r
    0.5,
    0.1666666666666667,
    0.04166666666666667,
    0.008333333333326136,
    0.0013888888888883748,
    0.0001984126987482046,
    2.4801587325547624e-05,
    2.7557255400384007e-06,
    2.7557273643237114e-07,
    2.510521694271232e-08,
    2.0914686923805015e-09,
)
LOGARITHM = (  # 2 (artanh(s) - s) / s^3 for |s| <= 3 - sqrt(8), in s^2
    0.6666666666666666,
    0.4000000000000088,
    0.285714285708032,
    0.22222222391803267,
    0.18181795630791592,
    0.15386240204981408,
    0.13268759773872016,
    0.13086765506179404,
)
LOGARITHM_TAIL = (  # 2 (artanh(s) - s - s^3 / 3) / s^5, in s^2
    0.4,
    0.28571428571429364,
    0.22222222221655857,
    0.18181818335395336,
    0.15384594962434103,
    0.13334804693091473,
    0.11706236434923845,
    0.11723177261448073,
)
SINE = (  # (sin(r) - r) / r^3 for |r| <= pi / 4 + 0.001, in r^2
    -0.16666666666666666,
    0.008333333333333331,
    -0.00019841269841265003,
    2.7557319219291704e-06,
    -2.5052106215981178e-08,
    1.605852901234455e-10,
    -7.58654365795576e-13,
)
COSINE = (  # (cos(r) - 1 + r^2 / 2) / r^4, in r^2
    0.041666666666666664,
    -0.0013888888888887378,
    2.4801587298736866e-05,
    -2.755731725679824e-07,
    2.087614316034329e-09,
    -1.1382408782475453e-11,
)
ARC = (  # (atan(t) - t) / t^3 for |t| <= tan(pi / 8), in t^2
    -0.3333333333333333,
    0.19999999999999804,
    -0.14285714285659776,
    0.11111111105150576,
    -0.09090908753259476,
    0.07692296368062823,
    -0.06666424760615176,
    0.05878927559098276,
    -0.05230443671468991,
    0.04551544855072575,
    -0.03456931763594485,
    0.016284377293342128,
)


# ----------------------------------------------------------------------------------------------------------------------


SHIFT = 1.5 * 2.0**52  # adding this rounds a number to an integer in its last bits
ONE_BITS = 1023 << 52
FRACTION_BITS = (1 << 52) - 1
EXPONENT_BITS = 2047 << 52
ROOT_HALF_BITS = 0x3FE6A09E667F3BCD  # of sqrt(1/2)
TWO_52_BITS = 1075 << 52  # of 2^52: an integer below 2^52 is added to have it as a number
TWO_52 = 2.0**52

LOG2_E = 1.4426950408889634
LOG2_E_LOW = float.fromhex("0x1.777d0ffda0d24p-56")
LN2_HIGH = float.fromhex("0x1.62e42fefa3800p-1")  # 42 bits: its product with an exponent is exact
LN2_LOW = float.fromhex("0x1.ef35793c76730p-45")
TWO_OVER_PI = 0.6366197723675814
HALF_PI = 1.5707963267948966  # pi / 2 is the sum of the three
HALF_PI_MIDDLE = float.fromhex("0x1.1a62633145c07p-54")
HALF_PI_LOW = float.fromhex("-0x1.f1976b7ed8fbcp-110")
QUARTER_PI = float.fromhex("0x1.921fb54442d18p-1")  # 50 bits: its products with 0 to 4 are exact
QUARTER_PI_LOW = float.fromhex("0x1.1a62633145c07p-55")
TWO_THIRDS = 0.6666666666666666
TWO_THIRDS_LOW = float.fromhex("0x1.5555555555555p-55")
TAN_EIGHTH_PI = 0.4142135623730951

MAX_ANGLE = 2.0**40  # rad: beyond, the reduction by three words of pi / 2 loses digits; sin and cos return nan
MAX_EXPONENT = 710.0  # exp overflows below it
MIN_EXPONENT = -746.0  # exp underflows to 0 above it
MAX_HYPERBOLIC = 710.6  # sinh and cosh overflow below it


def polynomial(x: Any, coefficients: tuple[Any, ...]) -> Any:
    """Return sum c_i x^i by Estrin's scheme, whose chain of operations is short (Muller 2016)."""
    count = len(coefficients)
    if count == 1:
        return coefficients[0]
    pairs = tuple(fma(coefficients[i + 1], x, coefficients[i]) for i in range(0, count - 1, 2))
    return polynomial(x * x, pairs + coefficients[2 * len(pairs) :])


def product(a: Any, b: Any) -> Any:
    """Return a b with its own rounding: a sum is fused only with products of the same function."""
    return a * b


# ---------------------------------------------------------------------------------------------- exponentials


def _reduce_exponent(x: Any, low: Any) -> tuple[Any, Any, Any]:
    """Return n + SHIFT and two words of r with x + low = n ln 2 + r, |r| <= ln(2) / 2."""
    shifted = fma(x, LOG2_E, SHIFT)
    n = shifted - SHIFT
    r_high = fma(-n, LN2_HIGH, x)  # exact
    correction = fma(-n, LN2_LOW, low)
    r = r_high + correction
    return shifted, r, (r_high - r) + correction


def _exp_remainder(r: Any, r_low: Any) -> Any:
    """Return e^(r + r_low) - 1 - r."""
    return fma(r * r, polynomial(r, EXPONENTIAL), fma(r_low, r, r_low))


def _scale_by_power(x: Any, shifted: Any) -> Any:
    """Return x 2^n in two steps, as 2^n may overflow or underflow where the result does not; -2048 <= n < 2048."""
    shifted_bits = (bits_of(shifted) + 2048) & 4095  # n + 2048
    half = shifted_bits >> 1
    return x * number_of((half - 1) << 52) * number_of((shifted_bits - half - 1) << 52)


def _exp_of_sum(x: Any, low: Any) -> Any:
    """Return e^(x + low) for MIN_EXPONENT <= x <= MAX_EXPONENT, |low| < 1e-12."""
    shifted, r, r_low = _reduce_exponent(x, low)
    high = 1.0 + r
    return _scale_by_power(high + (((1.0 - high) + r) + _exp_remainder(r, r_low)), shifted)


def _clamp(x: Any, lower: float, upper: float) -> Any:
    """Return x within limits; nan stays."""
    x = where(x > upper, upper, x)
    return where(x < lower, lower, x)


def exp(x: Any) -> Any:
    """Return e^x."""
    return _exp_of_sum(_clamp(x, MIN_EXPONENT, MAX_EXPONENT), 0.0)


def _expm1_words(x: Any, down: int) -> tuple[Any, Any]:
    """Return two words whose sum is (e^x - 1) / 2^down, -40 <= x <= MAX_EXPONENT or, for down = 2, MAX_HYPERBOLIC."""
    shifted, r, r_low = _reduce_exponent(x, 0.0)
    scale = number_of((bits_of(shifted) + (1023 - down)) << 52)
    unit = 0.5**down
    a, b = scale - unit, scale * r
    a_low = where(scale < unit, scale - (a + unit), (scale - a) - unit)
    partial_sum = a + b  # |a| > |b|, or a = 0
    square = r * r
    half_square = 0.5 * square  # a separate word, as a and b may cancel
    series = fma(square * r, polynomial(r, EXPONENTIAL[1:]), fma(r_low, r, r_low) + fma(0.5 * r, r, -half_square))
    c = scale * half_square
    high = partial_sum + c
    return high, (((a - partial_sum) + b) + ((partial_sum - high) + c)) + fma(scale, series, a_low)


def expm1(x: Any) -> Any:
    """Return e^x - 1."""
    high, low = _expm1_words(_clamp(x, -40.0, MAX_EXPONENT), 1)
    half = high + low
    return where(abs(x) < 2.0**-54, x, half + half)


def tanh(x: Any) -> Any:
    """Return the hyperbolic tangent of x."""
    size = abs(x)
    high, low = _expm1_words(-2.0 * where(size > 22.0, 22.0, size), 1)  # e = (exp(-2 |x|) - 1) / 2
    e = high + low
    e_low = (high - e) + low
    d = 1.0 + e
    d_low = ((1.0 - d) + e) + e_low
    inverse = 1.0 / d
    t = e * inverse
    remaining = fma(-t, d, e) + fma(-t, d_low, e_low)
    return where(size < 2.0**-28, x, copysign(fma(remaining, inverse, t), x))


def sinh(x: Any) -> Any:
    """Return the hyperbolic sine of x."""
    size = abs(x)
    high, low = _expm1_words(where(size > MAX_HYPERBOLIC, MAX_HYPERBOLIC, size), 2)  # e = (exp |x| - 1) / 4
    e = high + low
    e_low = (high - e) + low
    four = 4.0 * e
    d = fma(4.0, e, 1.0)
    d_low = fma(4.0, e_low, where(four < 1.0, (1.0 - d) + four, (four - d) + 1.0))
    inverse = 1.0 / d
    t = product(e, inverse)
    remaining = fma(-t, d, e) + fma(-t, d_low, e_low)
    is_large = size > 40.0  # d may be infinite
    t, remaining = where(is_large, 0.25, t), where(is_large, 0.0, remaining)
    total = e + t
    half = total + (((e - total) + t) + fma(remaining, inverse, e_low))
    return where(size < 2.0**-28, x, copysign(half + half, x))


def cosh(x: Any) -> Any:
    """Return the hyperbolic cosine of x."""
    size = abs(x)
    shifted, r, r_low = _reduce_exponent(where(size > MAX_HYPERBOLIC, MAX_HYPERBOLIC, size), 0.0)
    scale = number_of((bits_of(shifted) + 1021) << 52)
    rounded = 1.0 + r
    remaining = ((1.0 - rounded) + r) + _exp_remainder(r, r_low)
    high = rounded + remaining
    u, u_low = scale * high, scale * ((rounded - high) + remaining)  # exp |x| / 4
    capped = where(size > 40.0, 2.0**60, u)
    d = 16.0 * capped
    inverse = 1.0 / d
    remaining = fma(-inverse, 16.0 * u_low, fma(-inverse, d, 1.0))
    total = u + inverse
    half = total + (((u - total) + inverse) + fma(remaining, inverse, u_low))
    return half + half


# ---------------------------------------------------------------------------------------------- logarithms


def _exponent_and_mantissa(x: Any) -> tuple[Any, Any]:
    """Return k and m with x = 2^k m, sqrt(1/2) <= m < sqrt(2), for 0 < x < inf."""
    is_denormal = x < 2.0**-1022
    shifted_bits = bits_of(where(is_denormal, x * 2.0**54, x)) + (ONE_BITS - ROOT_HALF_BITS)
    k = number_of(((shifted_bits & EXPONENT_BITS) >> 52) + TWO_52_BITS) - where(
        is_denormal, TWO_52 + 1077.0, TWO_52 + 1023.0
    )
    return k, number_of((shifted_bits & FRACTION_BITS) + ROOT_HALF_BITS)


def _log_with(k: Any, f: Any, correction: Any) -> Any:
    """Return k ln 2 + log(1 + f + correction), 1 + f within sqrt(1/2) and sqrt(2), correction below its last bit."""
    s = f / (2.0 + f)
    z = s * s
    half_square = product(0.5 * f, f)
    series = product(z, polynomial(z, LOGARITHM))
    high = fma(k, LN2_HIGH, f)
    rounding_error = f - fma(-k, LN2_HIGH, high)
    remaining = fma(s, half_square + series, -half_square)  # log(1 + f) - f, as f - s f = (1 - s) f^2 / 2
    slope = fma(-2.0 * s, fma(-s, 1.0 - s, 1.0), 1.0)  # 1 / (1 + f) = (1 - s) / (1 + s), to 0.2 %
    return high + (rounding_error + fma(k, LN2_LOW, fma(correction, slope, remaining)))


def _with_limits(x: Any, value: Any) -> Any:
    """Return a logarithm of x with its values at 0, at infinity and below 0."""
    return where(x > 0.0, where(x < math.inf, value, x), where(x == 0.0, -math.inf, math.nan))


def log(x: Any) -> Any:
    """Return the natural logarithm of x."""
    k, m = _exponent_and_mantissa(x)
    return _with_limits(x, _log_with(k, m - 1.0, 0.0))


def log1p(x: Any) -> Any:
    """Return log(1 + x)."""
    u = 1.0 + x
    x_rounded = u - x
    rounding_error = (1.0 - x_rounded) + (x - (u - x_rounded))  # exact 1 + x = u + rounding_error
    k, m = _exponent_and_mantissa(u)
    is_unscaled = (k == 0.0) & (u > 0.0)
    scale = number_of((bits_of(SHIFT - k) + 1023) << 52)  # 2^-k
    value = _log_with(k, where(is_unscaled, x, m - 1.0), where(is_unscaled | (k > 60.0), 0.0, rounding_error * scale))
    return where(abs(x) < 2.0**-54, x, _with_limits(u, value))


def _log_words(x: Any) -> tuple[Any, Any, Any, Any]:
    """Return k, ln m in two words and the low word of ln m with x = 2^k m, to 2^-65 of ln m."""
    k, m = _exponent_and_mantissa(x)
    f, d = m - 1.0, m + 1.0  # f is exact
    inverse = 1.0 / d
    s = f * inverse
    s_low = inverse * fma(-s, (1.0 - d) + m, fma(-s, d, f))
    z = s * s
    z_low = fma(s + s, s_low, fma(s, s, -z))
    tail = product(z, polynomial(z, LOGARITHM_TAIL))
    t = TWO_THIRDS + tail
    t_low = ((TWO_THIRDS - t) + tail) + TWO_THIRDS_LOW
    w = z * t
    w_low = fma(z, t_low, fma(z_low, t, fma(z, t, -w)))
    u = s * w
    u_low = fma(s, w_low, fma(s_low, w, fma(s, w, -u)))
    return k, s + s, u, fma(2.0, s_low, u_low)


def _log_in_two(x: Any) -> tuple[Any, Any]:
    """Return ln x in two words for 0 < x < inf."""
    k, leading, second, third = _log_words(x)
    a = fma(k, LN2_HIGH, leading)
    a_lost = leading - fma(-k, LN2_HIGH, a)
    b = a + second
    low = fma(k, LN2_LOW, third + (a_lost + ((a - b) + second)))
    high = b + low
    return high, (b - high) + low


def log2(x: Any) -> Any:
    """Return the logarithm of x to base 2, exact for powers of 2."""
    k, leading, second, third = _log_words(x)
    high = leading + second
    low = ((leading - high) + second) + third
    scaled_log = product(high, LOG2_E)
    remaining = fma(low, LOG2_E, fma(high, LOG2_E_LOW, fma(high, LOG2_E, -scaled_log)))
    total = k + scaled_log  # |k| > |scaled_log|, or k = 0
    return _with_limits(x, total + (((k - total) + scaled_log) + remaining))


def pow(x: Any, y: Any) -> Any:
    """Return x^y, as C's pow does; nan for x < 0 unless y is an integer."""
    size, power = abs(x), abs(y)
    high, low = _log_in_two(size)
    exponent = y * high
    remaining = fma(y, low, fma(y, high, -exponent))
    value = _exp_of_sum(
        _clamp(exponent, MIN_EXPONENT, MAX_EXPONENT), where(abs(exponent) < -MIN_EXPONENT, remaining, 0.0)
    )

    at_infinity = where(y > 0.0, math.inf, where(y < 0.0, 0.0, y))
    at_zero = where(y > 0.0, 0.0, where(y < 0.0, math.inf, y))
    value = where(size < math.inf, where(size == 0.0, at_zero, value), where(size == math.inf, at_infinity, x))

    rounded = power + TWO_52
    is_integer = (rounded - TWO_52 == power) | (power >= TWO_52)
    is_odd = is_integer & (power < 2.0 * TWO_52) & (bits_of(where(power < TWO_52, rounded, power)) & 1 == 1)
    value = where((copysign(1.0, x) < 0.0) & is_odd, -value, value)
    value = where((x < 0.0) & (x > -math.inf) & (rounded - TWO_52 != power) & (power < TWO_52), math.nan, value)
    return where((y == 0.0) | (x == 1.0) | ((x == -1.0) & (power == math.inf)), 1.0, value)


# ---------------------------------------------------------------------------------------------- angles


def cos_and_sin(x: Any) -> tuple[Any, Any]:
    """Return cosine and sine of an angle x (rad); nan beyond MAX_ANGLE."""
    shifted = fma(x, TWO_OVER_PI, SHIFT)
    n = shifted - SHIFT
    r_high = fma(-n, HALF_PI, x)  # exact
    middle_part = product(n, HALF_PI_MIDDLE)
    middle_low = fma(n, HALF_PI_MIDDLE, -middle_part)
    r = r_high - middle_part
    rounded = r - r_high
    rounding_error = (r_high - (r - rounded)) - (middle_part + rounded)
    r_low = fma(-n, HALF_PI_LOW, rounding_error - middle_low)

    z = r * r
    half_square = 0.5 * z
    sine = r + fma(r * z, polynomial(z, SINE), fma(-r_low, half_square, r_low))
    high = 1.0 - half_square
    half_square_low = fma(0.5 * r, r, -half_square)
    cosine = high + (((1.0 - high) - half_square) + fma(z * z, polynomial(z, COSINE), fma(-r, r_low, -half_square_low)))

    quarter_turns = bits_of(shifted)
    is_swapped = quarter_turns & 1 == 1
    sine, cosine = where(is_swapped, cosine, sine), where(is_swapped, sine, cosine)
    sine = where(quarter_turns & 2 == 2, -sine, sine)
    cosine = where((quarter_turns + 1) & 2 == 2, -cosine, cosine)
    is_in_range = abs(x) <= MAX_ANGLE
    sine = where(abs(x) < 2.0**-27, x, sine)
    return where(is_in_range, cosine, math.nan), where(is_in_range, sine, math.nan)


def sin(x: Any) -> Any:
    """Return the sine of an angle x (rad); nan beyond MAX_ANGLE."""
    return cos_and_sin(x)[1]


def cos(x: Any) -> Any:
    """Return the cosine of an angle x (rad); nan beyond MAX_ANGLE."""
    return cos_and_sin(x)[0]


def atan2(y: Any, x: Any) -> Any:
    """Return the angle (rad) of the point (x, y), from -pi to pi, as C's atan2 does."""
    width, height = abs(x), abs(y)
    is_steep = height > width
    larger, smaller = where(is_steep, height, width), where(is_steep, width, height)
    scale = where(larger > 2.0**400, 2.0**-24, 2.0**600)  # no sum or inverse overflows, no remainder underflows
    is_infinite = larger == math.inf
    smaller = where(is_infinite, where(smaller == math.inf, 1.0, 0.0), smaller * scale)
    larger = where(is_infinite | (larger == 0.0), 1.0, larger * scale)

    is_middle = smaller > TAN_EIGHTH_PI * larger  # there atan(b / a) = pi / 4 + atan((b - a) / (b + a))
    numerator = where(is_middle, smaller - larger, smaller)
    numerator_low = where(is_middle, smaller - (numerator + larger), 0.0)
    denominator = where(is_middle, larger + smaller, larger)
    denominator_low = where(is_middle, smaller - (denominator - larger), 0.0)
    inverse = 1.0 / denominator
    t = numerator * inverse
    t_low = (fma(-t, denominator, numerator) + fma(-t, denominator_low, numerator_low)) * inverse
    z = t * t
    remaining = fma(z * t, polynomial(z, ARC), fma(-z, t_low, t_low))

    # the angle is j pi / 4 + t + remaining, mirrored at the diagonal and at the vertical
    j = where(is_middle, 1.0, 0.0)
    is_left = copysign(1.0, x) < 0.0
    j = where(is_steep, 2.0 - j, j)
    j = where(is_left, 4.0 - j, j)
    mirrored = where(is_steep, -1.0, 1.0) * where(is_left, -1.0, 1.0)
    t, remaining = mirrored * t, mirrored * remaining
    high = fma(j, QUARTER_PI, t)
    rounding_error = t - fma(-j, QUARTER_PI, high)
    angle = high + (rounding_error + fma(j, QUARTER_PI_LOW, remaining))
    return where((x != x) | (y != y), math.nan, copysign(angle, y))  # noqa: PLR0124 - only nan differs from itself


def atan(x: Any) -> Any:
    """Return the angle (rad) whose tangent is x."""
    return atan2(x, 1.0)
