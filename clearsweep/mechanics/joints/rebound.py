"""The restitution of a free impact in closed form, and the parameters for a given restitution.

For a law F = F_elastic(pen) (1 + chi rate / onset_rate) the phase curve of m pen'' = -F gives the restitution whatever
the elastic force, the mass and the speed.  For F = F_elastic + 2 zeta sqrt(m) F_elastic / sqrt(2 U) rate, U the elastic
energy, sqrt(2 U) and sqrt(m) rate move like the deflection and the speed of a linear oscillator of damping ratio zeta
(Antypov & Elliott 2011, EPL 94:50004, for the exponent 3/2); for a power n the damping is that of the root of F / pen
with the factor sqrt(2 (n + 1)) zeta.
"""

import functools
import math
from collections.abc import Callable

MAX_ITERATIONS = 100  # of a search for a root


def exact_factor(restitution: float) -> float:
    """Return the chi for which a free impact has exactly `restitution`, for any exponent, stiffness and mass.

    The root of ln((1 + chi) / (1 - e chi)) = chi (1 + e) in (0, 1/e), from the phase curve of
    m x'' = -K x^n (1 + chi u) integrated from u = 1 to u = -e.
    """
    if restitution == 1.0:
        return 0.0
    if 1.0 - restitution < 1e-5:  # the root is lost in rounding; two terms of the series are accurate to 1e-15
        return 1.5 * (1.0 - restitution) * (2.0 - restitution)

    def residual(s):  # the substitution 1 - e chi = exp(-s) avoids the singular end
        chi = -math.expm1(-s) / restitution
        return math.log1p(chi) + s - chi * (1.0 + restitution)

    return -math.expm1(-find_root(residual, 1e-9, 800.0, 1e-15, 1e-15)) / restitution


def find_root(function: Callable[[float], float], low: float, high: float, xtol: float, rtol: float) -> float:
    """Return a root of a function with opposite signs at `low` and `high`, within 2 (xtol + rtol |root|).

    Brent 1973, Algorithms for Minimization without Derivatives, ch. 4, step by step as in `scipy.optimize.brentq`,
    which gives the same bits but takes a third of a second to import.
    """
    previous, current = low, high
    f_previous, f_current = function(previous), function(current)
    if f_previous == 0.0 or f_current == 0.0:
        return previous if f_previous == 0.0 else current
    if (f_previous < 0.0) == (f_current < 0.0):
        raise ValueError(f"the function has one sign at {low:g} and {high:g}")
    opposite, f_opposite, step, previous_step = previous, f_previous, current - previous, current - previous
    for _ in range(MAX_ITERATIONS):
        if (f_previous < 0.0) != (f_current < 0.0):
            opposite, f_opposite, step, previous_step = previous, f_previous, current - previous, current - previous
        if abs(f_opposite) < abs(f_current):
            previous, current, opposite = current, opposite, current
            f_previous, f_current, f_opposite = f_current, f_opposite, f_current
        tolerance, half_interval = 0.5 * (xtol + rtol * abs(current)), 0.5 * (opposite - current)
        if f_current == 0.0 or abs(half_interval) < tolerance:
            return current
        last_steps = previous_step, step
        previous_step = step = half_interval
        if abs(last_steps[0]) > tolerance and abs(f_current) < abs(f_previous):
            if previous == opposite:  # secant
                trial = -f_current * (current - previous) / (f_current - f_previous)
            else:  # inverse quadratic interpolation
                previous_slope = (f_previous - f_current) / (previous - current)
                opposite_slope = (f_opposite - f_current) / (opposite - current)
                trial = (
                    -f_current
                    * (f_opposite * opposite_slope - f_previous * previous_slope)
                    / (opposite_slope * previous_slope * (f_opposite - f_previous))
                )
            if 2.0 * abs(trial) < min(abs(last_steps[0]), 3.0 * abs(half_interval) - tolerance):
                previous_step, step = last_steps[1], trial
        previous, f_previous = current, f_current
        current += step if abs(step) > tolerance else math.copysign(tolerance, half_interval)
        f_current = function(current)
    raise ValueError("the search for a root did not converge")


def approach_loss(chi: float) -> float:
    """Return chi - ln(1 + chi), without cancellation for small chi."""
    if chi > 0.1:
        return chi - math.log1p(chi)
    return chi * chi * math.fsum((-chi) ** k / (k + 2) for k in range(16))


@functools.lru_cache(1024)
def hysteresis_rebound(chi: float) -> float:
    """Return the restitution of a free impact with the hysteresis factor `chi`.

    The root of chi e + ln(1 - chi e) = -(chi - ln(1 + chi)); the closed form is (1 + W0(-(1+chi) exp(-(1+chi)))) / chi.
    """
    if chi < 1e-4:
        return 1.0 - chi * (2.0 / 3.0 - chi * (4.0 / 9.0 - chi * 44.0 / 135.0))
    loss = approach_loss(chi)
    # with 1 - chi e = exp(-s) the root s of expm1(-s) + s = loss is below loss + 1; the left side is convex, so that
    # Newton's method falls towards the root
    s, previous_s = loss + 1.0, math.inf
    while s < previous_s:
        s, previous_s = s + (math.expm1(-s) + s - loss) / math.expm1(-s), s
    return -math.expm1(-previous_s) / chi


def approach_hysteresis_rebound(chi: float) -> float:
    """Return the restitution of a free impact with the hysteresis factor `chi` acting on the approach only."""
    return math.sqrt(2.0 * approach_loss(chi)) / chi if chi > 0.0 else 1.0


def damping_ratio(restitution: float) -> float:
    """Return the zeta of a linear oscillator that returns to zero with `restitution` times its speed."""
    loss = -math.log(restitution)
    return loss / math.hypot(math.pi, loss)


def approach_damping_rebound(zeta: float) -> float:
    """Return the restitution with a damping ratio `zeta` that acts on the approach only."""
    root_term = math.sqrt(abs(1.0 - zeta * zeta))
    if zeta < 1.0:
        return math.exp(-zeta / root_term * math.atan2(root_term, zeta))
    if root_term < 1e-6:
        return math.exp(-1.0)
    return ((zeta + root_term) / (zeta - root_term)) ** (-0.5 * zeta / root_term)
