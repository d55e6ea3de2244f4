"""What a law of one's own does, found by sampling it: what is no number, jumps, kinks, gains of energy, restitution.

The laws of the package are tested for these; a law of one's own is sampled before the first case runs, as Python.
"""

import itertools
import math
import traceback
from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

import numpy as np

from ...language.errors import InputError, quoted

SPEEDS = (0.01, 0.03, 0.1, 0.3, 1.0)  # m/s, at which the restitution of an impact is found
MASSES = (1.0, 100.0)  # kg: with both masses, a restitution that does not depend on it is the same
PARTS, POINTS, ZOOMS = 12, 16, 8  # of a range that is searched for kinks: intervals, points of each, times eight closer
KINK_DECREASE, JUMP_DECREASE = 1.0 / 22.0, 0.4  # of the bend of a function, see `_sharpest_bend`
LEAST_CHANGE = 1e-3  # of the slope at a kink that counts, relative to the largest value over the range
GAIN = 1e-6  # relative gain of energy that is not rounding
MAX_STEPS = 20_000  # of an impact


class Range(NamedTuple):
    """A range of one argument of a law."""

    name: str
    unit: str
    low: float
    high: float

    def intervals(self) -> list[tuple[float, float]]:
        """Return intervals that cover the range and overlap: of equal ratio if it is above zero, else equal."""
        shares = [(max(i - 0.07, 0.0) / PARTS, min(i + 1.06, PARTS) / PARTS) for i in range(PARTS)]
        if self.low > 0.0:
            return [(self.low * (self.high / self.low) ** a, self.low * (self.high / self.low) ** b) for a, b in shares]
        width = self.high - self.low
        return [(self.low + a * width, self.low + b * width) for a, b in shares]


class Break(NamedTuple):
    """A place at which a law jumps or has a kink."""

    over: Range
    place: float
    is_jump: bool

    def text(self) -> str:
        """Return the place in words."""
        kind = "jumps" if self.is_jump else "has a kink"
        return f"{kind} at {self.over.name} {self.place:.4g} {self.over.unit}"


def attempted(function: Callable[[], float], otherwise: float) -> float:
    """Return what a function returns, or `otherwise` if it fails: the check of the law then says why."""
    try:
        return float(function())
    except Exception:
        return otherwise


def checked(function: Callable[..., float], names: Sequence[str], place: str) -> Callable[..., float]:
    """Return a function that raises InputError where `function` raises or returns what is no finite number.

    names : of its arguments; place : of the law, at the beginning of the message.
    """

    def check(*arguments: float) -> float:
        try:
            returned = function(*arguments)
        except InputError:
            raise
        except Exception as error:
            frame = traceback.extract_tb(error.__traceback__)[-1]
            reason = f"fails with {type(error).__name__}: {error}, in {frame.filename}:{frame.lineno}: {frame.line}"
        else:
            is_number = isinstance(returned, (int, float, np.number))
            if is_number and math.isfinite(returned):
                return float(returned)
            reason = f"gives {returned}" if is_number else f"returns {quoted(returned)}; expected a number"
        sample = ", ".join(f"{name} {number:.4g}" for name, number in zip(names, arguments, strict=True))
        raise InputError(f"{place}: {reason}, at {sample} (SI); return its limit there")

    return check


def breaks(function: Callable[[float], float], over: Range, declared: Sequence[float]) -> Iterator[Break]:
    """Yield the jumps and kinks of a function of one argument that are not declared."""
    intervals, width, known = over.intervals(), over.high - over.low, [*declared]
    largest = max(abs(function(x)) for interval in intervals for x in interval)
    for interval in intervals:
        place, decrease, change = _sharpest_bend(function, interval, 1e-11 * largest)
        is_known = any(abs(place - kink) <= 1e-3 * abs(kink) + 1e-6 * (interval[1] - interval[0]) for kink in known)
        if decrease > KINK_DECREASE and change > LEAST_CHANGE * largest / width and not is_known:
            known.append(place)
            is_at_zero = abs(place) < 1e-6 * (interval[1] - interval[0])
            yield Break(over, 0.0 if is_at_zero else place, decrease > JUMP_DECREASE)


def _sharpest_bend(function: Callable, interval: tuple[float, float], rounding: float) -> tuple[float, float, float]:
    """Return where a function bends most in an interval, how its bend decreases there, and the change of its slope.

    The bend is a second difference.  As steps become eight times smaller, that of a smooth function becomes 64 times
    smaller, that of a kink 8 times, and that of a jump stays; it is followed down to the `rounding`.
    """
    low, high = interval
    history, place, change = [], 0.5 * (low + high), 0.0
    for _ in range(ZOOMS):
        step = (high - low) / POINTS
        values = [function(low + i * step) for i in range(POINTS + 1)]
        bends = [abs(values[i - 1] - 2.0 * values[i] + values[i + 1]) for i in range(1, POINTS)]
        sharpest = max(range(POINTS - 1), key=bends.__getitem__)
        if bends[sharpest] <= rounding or step < 1e-12 * abs(low):
            break
        history.append(bends[sharpest])
        low, high = low + sharpest * step, low + (sharpest + 2) * step
        place, change = low + step, bends[sharpest] / step
    ratios = [b / a for a, b in itertools.pairwise(history)][-3:]
    return place, math.prod(ratios) ** (1.0 / len(ratios)) if ratios else 0.0, change


def undeclared_kinks(
    function: Callable[[float], float], over: Range, declared: Sequence[float], place: str
) -> list[str]:
    """Return remarks on kinks that a law does not declare; raise InputError where it jumps without declaring it."""
    places = list(breaks(function, over, declared))
    for jump in (x for x in places if x.is_jump):
        raise InputError(
            f"{place}: {jump.text()}, which no integration follows; make it continuous, or declare the place in kinks"
        )
    return [
        f"{place}: {kink.text()} that it does not declare: steps do not end there, which costs steps" for kink in places
    ]


def rebound(force: Callable[[float, float], float], mass: float, speed: float) -> float:
    """Return the restitution of an impact of a mass (kg) at a speed (m/s): m x'' = -max(0, F(x, x')), from x = 0.

    Runge-Kutta's fourth order with steps halved and doubled by Richardson's estimate (Hairer, Norsett & Wanner 1993,
    Solving Ordinary Differential Equations I, section II.4); 0 if the bodies do not part.
    """

    def acceleration(pen: float, rate: float) -> float:
        return -max(force(max(pen, 0.0), rate), 0.0) / mass

    pen, rate, step, deepest = 0.0, speed, 1e-9 / speed, 0.0
    for _ in range(MAX_STEPS):
        full = _step(acceleration, pen, rate, step)
        half = _step(acceleration, *_step(acceleration, pen, rate, 0.5 * step), 0.5 * step)
        error = max(abs(half[0] - full[0]) / max(deepest, abs(half[0])), abs(half[1] - full[1]) / speed) / 15.0
        is_past = half[0] < 0.0 and half[0] < -1e-9 * deepest
        if error <= 1e-10 and not is_past:
            pen, rate = half
            deepest = max(deepest, pen)
            if rate < 0.0 and (pen <= 1e-9 * deepest or acceleration(pen, rate) == 0.0):
                return -rate / speed
        step *= 0.5 if is_past else min(2.0, max(0.2, 0.9 * (1e-10 / max(error, 1e-16)) ** 0.2))
    return 0.0


def _step(acceleration: Callable, pen: float, rate: float, step: float) -> tuple[float, float]:
    """Return penetration and rate after a step of the classical Runge-Kutta method."""
    a = acceleration(pen, rate)
    b = acceleration(pen + 0.5 * step * rate, rate + 0.5 * step * a)
    c = acceleration(pen + 0.5 * step * rate + 0.25 * step * step * a, rate + 0.5 * step * b)
    d = acceleration(pen + step * rate + 0.5 * step * step * b, rate + step * c)
    return pen + step * rate + step * step * (a + b + c) / 6.0, rate + step * (a + 2.0 * b + 2.0 * c + d) / 6.0
