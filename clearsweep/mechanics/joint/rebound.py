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

    return -math.expm1(-root(residual, 1e-9, 800.0, 1e-15, 1e-15)) / restitution


def root(function: Callable[[float], float], low: float, high: float, xtol: float, rtol: float) -> float:
    """Return a root of a function with opposite signs at `low` and `high`, within 2 (xtol + rtol |root|).

    Brent 1973, Algorithms for Minimization without Derivatives, ch. 4, step by step as in `scipy.optimize.brentq`,
    which gives the same bits but takes a third of a second to import.
    """
    before, now = low, high
    f_before, f_now = function(before), function(now)
    if f_before == 0.0 or f_now == 0.0:
        return before if f_before == 0.0 else now
    if (f_before < 0.0) == (f_now < 0.0):
        raise ValueError(f"the function has one sign at {low:g} and {high:g}")
    opposite, f_opposite, step, step_before = before, f_before, now - before, now - before
    for _ in range(MAX_ITERATIONS):
        if (f_before < 0.0) != (f_now < 0.0):
            opposite, f_opposite, step, step_before = before, f_before, now - before, now - before
        if abs(f_opposite) < abs(f_now):
            before, now, opposite = now, opposite, now
            f_before, f_now, f_opposite = f_now, f_opposite, f_now
        tolerance, half = 0.5 * (xtol + rtol * abs(now)), 0.5 * (opposite - now)
        if f_now == 0.0 or abs(half) < tolerance:
            return now
        last_steps = step_before, step
        step_before = step = half
        if abs(last_steps[0]) > tolerance and abs(f_now) < abs(f_before):
            if before == opposite:  # secant
                trial = -f_now * (now - before) / (f_now - f_before)
            else:  # inverse quadratic interpolation
                slope = (f_before - f_now) / (before - now)
                slope_opposite = (f_opposite - f_now) / (opposite - now)
                trial = (
                    -f_now
                    * (f_opposite * slope_opposite - f_before * slope)
                    / (slope_opposite * slope * (f_opposite - f_before))
                )
            if 2.0 * abs(trial) < min(abs(last_steps[0]), 3.0 * abs(half) - tolerance):
                step_before, step = last_steps[1], trial
        before, f_before = now, f_now
        now += step if abs(step) > tolerance else math.copysign(tolerance, half)
        f_now = function(now)
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
    s, larger = loss + 1.0, math.inf
    while s < larger:
        s, larger = s + (math.expm1(-s) + s - loss) / math.expm1(-s), s
    return -math.expm1(-larger) / chi


def approach_hysteresis_rebound(chi: float) -> float:
    """Return the restitution of a free impact with the hysteresis factor `chi` acting on the approach only."""
    return math.sqrt(2.0 * approach_loss(chi)) / chi if chi > 0.0 else 1.0


def damping_ratio(restitution: float) -> float:
    """Return the zeta of a linear oscillator that returns to zero with `restitution` times its speed."""
    loss = -math.log(restitution)
    return loss / math.hypot(math.pi, loss)


def approach_damping_rebound(zeta: float) -> float:
    """Return the restitution with a damping ratio `zeta` that acts on the approach only."""
    width = math.sqrt(abs(1.0 - zeta * zeta))
    if zeta < 1.0:
        return math.exp(-zeta / width * math.atan2(width, zeta))
    if width < 1e-6:
        return math.exp(-1.0)
    return ((zeta + width) / (zeta - width)) ** (-0.5 * zeta / width)
