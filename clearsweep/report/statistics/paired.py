"""Trend of a figure with one swept value, from pairs of otherwise equal cases, without assumed distributions."""

import itertools
import math

import numpy as np

from ...answers.probability import CONFIDENCE, Estimate

MAX_EXACT_PAIRS = (
    3000  # comparisons up to which the distribution of orders is exact; above, it is approximated as normal
)


def trend_exponent(x: np.ndarray, table: np.ndarray, claims: int = 1) -> tuple[Estimate, int]:
    """Return the exponent of `x` in the trend of a figure, its interval, and the number of pairs of cases.

    The exponent is the median slope of log figure over log x of all pairs of a row; the interval contains the
    slopes that the orders within the rows do not reject (Sen 1968, J. Am. Stat. Assoc. 63:1379; several rows as
    blocks: Hirsch, Slack & Smith 1982, Water Resour. Res. 18:107). The method assumes that without a trend every
    order of a row is equally likely, and that rows are independent.

    Parameters
    ----------
    x : (values,) above 0, distinct
    table : (rows, values) the positive figure; in a row everything except x is equal; NaN if unknown
    claims : number of claims that share the probability of error of one interval (Bonferroni)

    Returns
    -------
    exponent : Estimate, NaN without a pair; its ends NaN with too few pairs for an interval

    """
    log_values, log_x = np.log(table), np.log(np.asarray(x, float))
    slope_arrays = [
        (log_values[:, k] - log_values[:, j]) / (log_x[k] - log_x[j])
        for j, k in itertools.combinations(range(len(log_x)), 2)
    ]
    slopes = np.sort(np.concatenate(slope_arrays)) if slope_arrays else np.empty(0)
    slopes = slopes[np.isfinite(slopes)]
    if not len(slopes):
        return Estimate(math.nan, math.nan, math.nan), 0
    sizes = np.isfinite(log_values).sum(axis=1)
    beyond = _slopes_beyond(sizes[sizes > 1], 0.5 * (1.0 - CONFIDENCE) / claims)
    interval = (float(slopes[beyond]), float(slopes[-1 - beyond])) if beyond >= 0 else (math.nan, math.nan)
    return Estimate(float(np.median(slopes)), *interval), len(slopes)


def _slopes_beyond(sizes: np.ndarray, tail: float) -> int:
    """Return the number of ordered slopes beyond each end of the interval, -1 without ends.

    The number of descending pairs of n values without a trend is distributed like the inversions of a permutation.

    tail : probability beyond either end
    """
    if (sizes * (sizes - 1) // 2).sum() > MAX_EXACT_PAIRS:
        from scipy.special import ndtri  # loads in a fraction of the time of scipy.stats

        pairs = 0.5 * (sizes * (sizes - 1.0)).sum()
        deviation = math.sqrt((sizes * (sizes - 1.0) * (2.0 * sizes + 5.0)).sum() / 72.0)
        return int(0.5 * pairs + ndtri(tail) * deviation - 0.5)
    probabilities = np.ones(1)
    for size in sizes:
        for count in range(2, size + 1):  # the last of `count` values has any rank with equal probability
            probabilities = np.convolve(probabilities, np.full(count, 1.0 / count))
    return int(np.searchsorted(np.cumsum(probabilities), tail, side="right")) - 1
