"""Line contact of two cylinders, one in the other."""

from typing import NamedTuple

from ...compiled import calculus as math
from ...compiled.family import kernel
from .contract import elastic_form

#: Where the tangent of pen = g F ln(S / F) is twice the secant, in units of g S.  It folds back at exp(-1).
LOGARITHMIC_END = 2.0 * math.exp(-2.0)


class Logarithmic(NamedTuple):
    """pen = g F ln(S / F), the approach of two cylinders: the laws of this form differ only in their g and S."""

    stiffness: float  # 1 / g, N/m
    depth: float  # g S, m; the law folds back at exp(-1) of it


@kernel
def inverse_lambert(w):
    """Return 1 / v, v = -W(-w) of the lower branch of Lambert's function, the root v >= 2 of v exp(-v) = w.

    `w` : above 0, at most LOGARITHMIC_END.  Relative error below 1e-15: a fraction in the distance from the
    branch point good to 4e-4, then one step of fourth order (Fritsch, Shafer & Crowley 1973, Commun. ACM 16:123).
    """
    q = -math.log(w)  # v - ln v = q
    r = math.sqrt(q - 1.0)
    v = 1.0 + r * (1.41612896 + r * (1.02969292 + r * 0.26107797)) / (1.0 + 0.26129776 * r)
    z = v - q - math.log(v)
    base = 1.0 - v
    second = 2.0 * base * (base + 2.0 / 3.0 * z)
    below = base * (second - 2.0 * z)  # v (1 + z (second - z) / below) is the root; inverted, it takes one division
    return below / (v * (below + z * (second - z)))


@elastic_form(Logarithmic, odd=False)
def _logarithmic(elastic, pen):
    if pen <= 0.0:
        return 0.0
    w = pen / elastic.depth
    if w < LOGARITHMIC_END:
        return elastic.stiffness * pen * inverse_lambert(w)
    return elastic.stiffness * elastic.depth * (w - 0.5 * LOGARITHMIC_END)
