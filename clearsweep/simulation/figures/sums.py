"""Computes figures from sums over the motion: over the whole window, and over its blocks with an interval.

Each kind of figure has three functions.  `take(totals, index)` returns the present sums of a joint or, if `index`
is None, of the mechanism; `value(window, index)` the figure over the window; `over_blocks(times, sums, revolutions)`
the figure over all blocks and the half-width of its 95 % interval, from the times (s) at the ends of the blocks, the
sums there, and the revolutions of a block.
"""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ...contracts.catalogue import Figure
from ...contracts.layout import Layout
from ...mechanics import observe
from ...mechanics.solver.totals import Totals
from ...tracing import portable
from .window import CONFIDENCE, DRY_FORCE_THRESHOLD, RARE_SHARE, Summed, Window, inflation_of, lag_correlation

#: `student_quantile` of 1, 2, 3... degrees of freedom by scipy, which takes longer to load than a case to run.
STUDENT_QUANTILES = (
    12.706204736174694, 4.302652729749462, 3.1824463052837078, 2.7764451051977934, 2.5705818356363146,
    2.4469118511449786, 2.364624251592784, 2.306004135204166, 2.262157162798205, 2.228138851986274,
    2.200985160091639, 2.1788128296672284, 2.1603686564627913, 2.144786687917804, 2.131449545559776,
    2.1199052992212546, 2.1098155778333156, 2.1009220402410382, 2.0930240544083087, 2.085963447265864,
    2.0796138447276795, 2.0738730679040254, 2.0686576104190486, 2.0638985616280245, 2.0595385527532972,
    2.0555294386428735, 2.0518305164802846, 2.0484071417952454, 2.045229642132703, 2.0422724563012378,
    2.039513446396408, 2.0369333434601016, 2.0345152974493383, 2.0322445093177186, 2.030107928250343,
    2.0280940009804502, 2.0261924630291093, 2.0243941639119694, 2.022690920036761, 2.021075390306273,
)  # fmt: skip
MIN_SKEWNESS = 1e-6  # of a mean: below, the correction for skewness is less than rounding
SHORTFALL_SHARE = 0.25  # that counts where a bin that scatters falls short: runs tend to end when it is low by chance


def half_width(values: np.ndarray) -> float:
    """Return the half-width of the 95 % interval of the mean of successive values: inf for one, 0 for equal ones.

    Student's interval with two corrections for few values:

    * The variance of the mean is that of a first-order autoregressive process. The correlation r of neighbours comes
      out too small by (1 + 3 r) / n (Kendall 1954, Biometrika 41:403), which is added.
    * The mean of skewed values is skewed as well. Its interval extends further to one side (Hall 1992, J. R. Stat. Soc.
      B 54:221, the cubic transformation); this side is returned.
    """
    count = len(values)
    if count < 2:
        return math.inf
    deviations = values - values.mean()
    sum_of_squares = float(portable.product(deviations, deviations))
    if sum_of_squares == 0.0:
        return 0.0
    correlation = lag_correlation(values)
    inflation = inflation_of(correlation + (1.0 + 3.0 * correlation) / count)
    standard_error = math.sqrt(sum_of_squares / (count * (count - 1)) * inflation)
    skewness_of_values = abs(float(np.sum(deviations**3))) * math.sqrt(count) / sum_of_squares**1.5
    skewness, end = skewness_of_values * math.sqrt(inflation / count), student_quantile(count - 1)
    if skewness >= MIN_SKEWNESS:  # of the mean
        end = 3.0 / skewness * (1.0 - math.cbrt(1.0 - skewness * (end + skewness / 6.0)))
    return end * standard_error


def student_quantile(freedom: int) -> float:
    """Return the end of the central 95 % of Student's distribution with `freedom` degrees of freedom."""
    if freedom <= len(STUDENT_QUANTILES):
        return STUDENT_QUANTILES[freedom - 1]
    from scipy.special import stdtrit

    return float(stdtrit(freedom, 0.5 + 0.5 * CONFIDENCE))


def _sum(totals: Totals | Summed, index: int | None, name: str) -> Any:
    return getattr(totals.mechanism if index is None else totals.joint[index], name)


def _mean(times: np.ndarray, sums: Sequence[Any]) -> tuple[float, float]:
    """Return a mean over time, and its half-width."""
    return (sums[-1] - sums[0]) / (times[-1] - times[0]), half_width(np.diff(sums) / np.diff(times))


class Mean(NamedTuple):
    """A mean over time, from an integral over time."""

    name: str  # of a field of ContactTotals or MechanismTotals

    def take(self, totals: Totals | Summed, index: int | None) -> Any:
        """Return the integral."""
        return _sum(totals, index, self.name)

    def value(self, window: Window, index: int | None) -> Any:
        """Return the mean over the window."""
        return self.take(window.totals, index) / window.duration

    def over_blocks(self, times: np.ndarray, sums: Sequence[Any], revolutions: int) -> tuple[float, float]:
        """Return the mean and its half-width."""
        return _mean(times, sums)


class FreeShare(Mean):
    """The share of the time that an integral does not count."""

    def value(self, window: Window, index: int | None) -> Any:
        """Return the share over the window."""
        return 1.0 - super().value(window, index)

    def over_blocks(self, times: np.ndarray, sums: Sequence[Any], revolutions: int) -> tuple[float, float]:
        """Return the share and its half-width."""
        mean, width = super().over_blocks(times, sums, revolutions)
        return 1.0 - mean, width


class FrictionMean(Mean):
    """The mean power of friction in a joint without clearance."""

    def take(self, totals: Totals | Summed, index: int | None) -> Any:
        """Return the work (J); `index` is the index of the joint in `Layout.rubbing`."""
        assert index is not None
        return totals.friction[index]


def figure_of_joint(figure: Figure, layout: Layout, joint: str) -> Figure:
    """Return a figure for a joint; for a joint without clearance, the friction power is that of the friction loads."""
    return figure._replace(sums=FrictionMean("friction")) if joint in layout.rubbing else figure


class Ratio(NamedTuple):
    """The ratio of two integrals over time."""

    numerator: str  # field of ContactTotals or MechanismTotals
    denominator: str  # likewise

    def take(self, totals: Totals | Summed, index: int | None) -> Any:
        """Return both integrals."""
        return np.array([_sum(totals, index, self.numerator), _sum(totals, index, self.denominator)])

    def value(self, window: Window, index: int | None) -> Any:
        """Return the ratio over the window, or 0 if both integrals are 0."""
        numerator, denominator = self.take(window.totals, index)
        return numerator / denominator if denominator else 0.0

    def over_blocks(self, times: np.ndarray, sums: Sequence[Any], revolutions: int) -> tuple[float, float]:
        """Return the ratio and its half-width, that of the mean of numerator - ratio denominator (Cochran, 6.4)."""
        numerator, denominator = np.diff(sums, axis=0).T
        if not denominator.any():
            return 0.0, 0.0
        ratio = numerator.sum() / denominator.sum()
        return ratio, half_width(numerator - ratio * denominator) / denominator.mean()


class DryLoadRatio(Ratio):
    """The share of a load that a contact behind a film carries, or None without a contact."""

    def value(self, window: Window, index: int | None) -> Any:
        """Return the share over the window."""
        assert index is not None
        return super().value(window, index) if window.case.joints[index].is_dry else None


class RootMean(Mean):
    """A root mean square, from the integral of the square over time."""

    def value(self, window: Window, index: int | None) -> Any:
        """Return the root mean square over the window."""
        return math.sqrt(self.take(window.totals, index) / window.duration)

    def over_blocks(self, times: np.ndarray, sums: Sequence[Any], revolutions: int) -> tuple[float, float]:
        """Return the root mean square and its half-width, which follows from that of the mean square."""
        square, width = _mean(times, sums)
        value = math.sqrt(square)
        return value, 0.5 * width / value if value else 0.0


class PerRevolution(Mean):
    """A mean over revolutions, from a count."""

    def value(self, window: Window, index: int | None) -> Any:
        """Return the mean over the window's revolutions."""
        return self.take(window.totals, index) / window.turns

    def over_blocks(self, times: np.ndarray, sums: Sequence[Any], revolutions: int) -> tuple[float, float]:
        """Return the mean over revolutions and its half-width."""
        return (sums[-1] - sums[0]) / (revolutions * (len(sums) - 1)), half_width(np.diff(sums) / revolutions)


class DepthRate(NamedTuple):
    """Wear rate (m/s) of the deepest bin of a joint, of either body."""

    def take(self, totals: Totals | Summed, index: int | None) -> Any:
        """Return the depths (m) of all bins of both bodies."""
        return totals.wear.reshape(len(totals.joint), -1)[index].copy()

    def value(self, window: Window, index: int | None) -> Any:
        """Return the largest depth over the window's time."""
        return self.take(window.totals, index).max() / window.duration

    def over_blocks(self, times: np.ndarray, depths: Sequence[Any], revolutions: int) -> tuple[float, float]:
        """Return the rate of the finally deepest bin, and its half-width, up to the end of the interval of any bin."""
        rates = np.diff(depths, axis=0) / np.diff(times)[:, None]
        reach = student_quantile(len(rates)) / math.sqrt(len(rates))
        rival = int(np.argmax(SHORTFALL_SHARE * rates.mean(axis=0) + reach * rates.std(axis=0)))
        (rate, width), (other_rate, other_width) = (
            _mean(times, [depth[each] for depth in depths]) for each in (np.argmax(depths[-1] - depths[0]), rival)
        )
        return rate, max(width, other_width - SHORTFALL_SHARE * (rate - other_rate))


class ForceExceeded(NamedTuple):
    """Normal force (N) of a joint that is exceeded for the share RARE_SHARE of the time."""

    def take(self, totals: Totals, index: int | None) -> Any:
        """Return the joint's histogram of the force over time."""
        return totals.histogram[index].copy()

    def value(self, window: Window, index: int) -> Any:
        """Return the force over the window."""
        return window.exceeded_force[index]

    def over_blocks(self, times: np.ndarray, histograms: Sequence[Any], revolutions: int) -> tuple[float, float]:
        """Return the force and its half-width.

        The interval is that of the time share above the force, by block, converted to forces (Woodruff 1952).
        """
        difference, duration = histograms[-1] - histograms[0], times[-1] - times[0]

        def force(fraction: float) -> float:
            return observe.force_quantile(difference, min(max(fraction, 0.0), 1.0) * duration)

        value = force(RARE_SHARE)
        time_above = np.array([observe.time_above(value, forces) for forces in histograms])
        width = half_width(np.diff(time_above) / np.diff(times))
        return value, max(force(RARE_SHARE - width) - value, value - force(RARE_SHARE + width))


class DryTime(NamedTuple):
    """Share of time with a dry force above, or not above, DRY_FORCE_THRESHOLD of the mean load."""

    above: bool  # True: above

    def take(self, totals: Totals, index: int | None) -> Any:
        """Return the joint's histogram of the dry force over time, and the integral of its load (N s)."""
        return totals.dry[index].copy(), _sum(totals, index, "load_time")

    def value(self, window: Window, index: int) -> Any:
        """Return the share of the window."""
        return self._share(window.dry_time[index] / window.duration)

    def over_blocks(self, times: np.ndarray, sums: Sequence[Any], revolutions: int) -> tuple[float, float]:
        """Return the share and its half-width, with the mean load of all blocks."""
        histograms, loads = zip(*sums, strict=True)
        threshold = DRY_FORCE_THRESHOLD * (loads[-1] - loads[0]) / (times[-1] - times[0])
        fraction, width = _mean(times, [observe.time_above(threshold, forces) for forces in histograms])
        return self._share(fraction), width

    def _share(self, fraction: float) -> float:
        return fraction if self.above else 1.0 - fraction
