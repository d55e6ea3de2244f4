"""Draws cases from distributions: reads `sample`, makes the points of its design, turns them into values."""

import math
from collections.abc import Callable
from typing import NamedTuple

from .. import quantity
from ..errors import InputError, nearest, shown
from .document import Entry, Problems

_MOST_CASES = 1_000_000
_RARE = 1e-6  # share of a distribution on either side that may lie out of range: so rare that it is not drawn
_WIDEST = 1e3  # std of a lognormal over its mean; beyond, half of it lies a millionth of the mean and lower
_NUDGE = 1e-9  # of the distance between the 5 % and 95 % quantiles: a disturbance too small to matter by itself
_POWERS_OF_TWO = ("sobol", "saltelli")  # the balance of a Sobol sequence holds for these numbers of points only
METHODS = {
    "sobol": "a scrambled Sobol sequence; n a power of 2, and a larger n keeps the cases of a smaller one",
    "latin-hypercube": "a Latin hypercube of n points",
    "random": "n independent points; a larger n keeps the cases of a smaller one",
    "saltelli": "n (variables + 2) points from which Sobol indices follow; n a power of 2",
    "one-at-a-time": "the middle, and each variable alone at its 5 % and 95 % quantile and disturbed a little; no n",
}
DISTRIBUTIONS = {
    "uniform": "[low, high]",
    "loguniform": "[low, high]",
    "normal": "{mean, std or cv, low?, high?}",
    "truncated-normal": "{mean, std or cv, low and/or high}",
    "lognormal": "{mean, std or cv}",
}


class Sample(NamedTuple):
    """What `sample` says but for the distributions."""

    method: str
    n: int
    seed: int
    points: object  # (rows, variables) in the open interval (0, 1); the rows of the design
    drawn: dict[str, Entry]  # values drawn before, which are kept


class Distribution(NamedTuple):
    """How one value varies; its numbers are in SI."""

    kind: str
    numbers: dict[str, float]

    def values(self, points):
        """Return the quantiles at `points`, (rows,) in (0, 1); with no spread exactly the one value there is."""
        import numpy as np
        from scipy.special import ndtr, ndtri

        low, high, mean, std = (self.numbers.get(name) for name in ("low", "high", "mean", "std"))
        if self.kind == "uniform":
            return np.clip(low + (high - low) * points, low, high)
        if self.kind == "loguniform":
            return np.clip(low * (high / low) ** points, low, high)
        if std == 0.0:
            return np.full(len(points), mean)
        if self.kind == "lognormal":
            variance = math.log1p((std / mean) ** 2)  # of the logarithm
            return mean * np.exp(math.sqrt(variance) * ndtri(points) - variance / 2.0)
        low, high = -math.inf if low is None else low, math.inf if high is None else high
        below, above = ndtr((low - mean) / std), ndtr((high - mean) / std)
        return np.clip(mean + std * ndtri(below + (above - below) * points), low, high)

    def written(self) -> dict:
        """Return the distribution as a grid may have it, in SI."""
        ends = self.kind in ("uniform", "loguniform")
        return {self.kind: [self.numbers["low"], self.numbers["high"]] if ends else dict(self.numbers)}


def read(problems: Problems, entry: Entry, variables: int) -> Sample | None:
    """Return the `sample` section for a number of variables, None where it is wrong."""
    given, told = entry.value, len(problems)
    known = ("method", "n", "seed", "over", "drawn")
    for key in given:
        if key not in known:
            sentence = f"unknown key '{key}'{nearest(key, known)} (allowed: {', '.join(known)})"
            problems.add(entry.keys.get(key, entry), f"sample.{key}", sentence)
    method = given["method"].value if "method" in given else None
    if method not in METHODS:
        near = nearest(method, METHODS) if isinstance(method, str) else ""
        found = f"unknown method {shown(method)}{near}" if "method" in given else "is missing"
        problems.add(given.get("method", entry), "sample.method", f"{found} (known: {', '.join(METHODS)})")
    seed = _whole(problems, given.get("seed"), "seed", 0, 2**63 - 1, 0, entry)
    if method == "one-at-a-time":
        for key in ("n", "seed"):
            if key in given:
                sentence = "is not used by one-at-a-time, whose cases follow from the variables; leave it out"
                problems.add(entry.keys.get(key, given[key]), f"sample.{key}", sentence)
        n = 1
    else:
        n = _whole(problems, given.get("n"), "n", 2, _MOST_CASES, None, entry)
    if n and method in _POWERS_OF_TWO and n & (n - 1):
        low = 1 << (n.bit_length() - 1)
        problems.add(given["n"], "sample.n", f"found {n}; {method} needs a power of 2, such as {low} or {2 * low}")
    if n and method == "saltelli" and n * (variables + 2) > _MOST_CASES:
        sentence = f"found {n}; with {variables} variables these are {n * (variables + 2)} cases, at most {_MOST_CASES}"
        problems.add(given["n"], "sample.n", sentence)
    drawn = given.get("drawn", Entry({})).value
    if not isinstance(drawn, dict):
        problems.add(given["drawn"], "sample.drawn", f"found {shown(drawn)}; expected the values of each variable")
    if len(problems) > told:
        return None
    return Sample(method, n, seed, _points(method, n, seed, variables), drawn)


def _whole(problems: Problems, entry: Entry | None, key: str, low: int, high: int, default, section: Entry):
    """Return a whole number of the section, None where it is wrong."""
    if entry is None:
        if default is None:
            problems.add(section, f"sample.{key}", "is missing; write the number of points, such as 64")
        return default
    try:
        number = quantity.exact(entry.value, "1")
        if number.denominator == 1 and low <= number <= high:
            return int(number)
        sentence = f"found {entry.value}; expected a whole number from {low} to {high}"
    except InputError as error:
        sentence = str(error)
    problems.add(entry, f"sample.{key}", sentence)
    return None


def _points(method: str, n: int, seed: int, variables: int):
    """Return the points of a design, (rows, variables) in (0, 1)."""
    import numpy as np

    if method == "one-at-a-time":
        return _one_at_a_time(variables)
    chance = np.random.default_rng(seed)
    if method == "random":
        points = chance.random((n, variables))
    else:
        from scipy.stats import qmc

        engine = qmc.LatinHypercube if method == "latin-hypercube" else qmc.Sobol
        points = engine(2 * variables if method == "saltelli" else variables, seed=chance).random(n)
    points = np.clip(points, 2.0**-54, 1.0 - 2.0**-53)  # 0 and 1 have no quantile
    return _saltelli(points, variables) if method == "saltelli" else points


def _saltelli(points, variables: int):
    """Return A, B, and A with each column in turn from B: Saltelli et al. 2010, Comput. Phys. Commun. 181, 259."""
    import numpy as np

    first, second = points[:, :variables], points[:, variables:]
    mixed = []
    for k in range(variables):
        mixed.append(first.copy())
        mixed[-1][:, k] = second[:, k]
    return np.vstack([first, second, *mixed])


def _one_at_a_time(variables: int):
    """Return the middle, then for each variable alone: its 5 % quantile, its 95 % quantile, the middle disturbed."""
    import numpy as np

    rows = np.full((1 + 3 * variables, variables), 0.5)
    for k in range(variables):
        rows[1 + 3 * k : 4 + 3 * k, k] = 0.05, 0.95, 0.5 + _NUDGE
    return rows


def distribution(problems: Problems, where: str, entry: Entry, one: Callable, unit: str) -> Distribution | None:
    """Return the distribution written at the key `where`, None where it is wrong; `one(entry)` reads a value."""
    forms = ", ".join(f"{{{kind}: {form}}}" for kind, form in DISTRIBUTIONS.items())
    if not isinstance(entry.value, dict) or len(entry.value) != 1:
        problems.add(entry, where, f"found {shown(entry.value)}; expected one of {forms}")
        return None
    ((kind, given),) = entry.value.items()
    if kind not in DISTRIBUTIONS:
        near = nearest(kind, DISTRIBUTIONS)
        problems.add(entry.keys.get(kind, given), where, f"unknown distribution '{kind}'{near} (known: {forms})")
        return None
    told = len(problems)
    if kind in ("uniform", "loguniform"):
        numbers = _ends(problems, where, kind, given, one)
    else:
        numbers = _moments(problems, where, kind, given, one, unit)
    return None if numbers is None or len(problems) > told else Distribution(kind, numbers)


def _ends(problems: Problems, where: str, kind: str, given: Entry, one: Callable) -> dict | None:
    """Return both ends of a uniform or loguniform distribution."""
    if not isinstance(given.value, list) or len(given.value) != 2:
        problems.add(given, where, f"{kind}: found {shown(given.value)}; expected [low, high]")
        return None
    low, high = (one(item) for item in given.value)
    if low is None or high is None:
        return None
    if low > high:
        problems.add(given, where, f"{kind}: the low end {low:.15g} is above the high end {high:.15g}; swap them")
    if kind == "loguniform" and low <= 0.0:
        problems.add(given, where, f"loguniform: found {low:.15g}; both ends have to be above 0; use uniform")
    return {"low": low, "high": high}


def _moments(problems: Problems, where: str, kind: str, given: Entry, one: Callable, unit: str) -> dict | None:
    """Return mean, standard deviation and bounds of a normal or lognormal distribution."""
    if not isinstance(given.value, dict):
        sentence = f"{kind}: found {shown(given.value)}; expected {DISTRIBUTIONS[kind]}"
        problems.add(given, where, sentence)
        return None
    known = ("mean", "std", "cv") if kind == "lognormal" else ("mean", "std", "cv", "low", "high")
    for key in given.value:
        if key not in known:
            sentence = f"unknown key '{key}'{nearest(key, known)} (allowed: {', '.join(known)})"
            problems.add(given.keys.get(key, given), f"{where}.{kind}", sentence)
    if ("std" in given.value) == ("cv" in given.value) or "mean" not in given.value:
        problems.add(given, where, f"{kind}: expected mean and either std or cv: {DISTRIBUTIONS[kind]}")
        return None
    mean = one(given.value["mean"])
    numbers = {
        key: _quantity(problems, where, given.value[key], "1" if key == "cv" else unit)
        for key in known[1:]
        if key in given.value
    }
    if mean is None or None in numbers.values():
        return None
    std = numbers["std"] if "std" in numbers else numbers["cv"] * abs(mean)
    low, high = numbers.get("low", -math.inf), numbers.get("high", math.inf)
    if std < 0.0:
        problems.add(given, where, f"{kind}: the spread is negative; write a std or cv of at least 0")
    if kind == "lognormal" and std > _WIDEST * mean > 0.0:
        problems.add(given, where, f"lognormal: found a std of {std / mean:.3g} times the mean; at most {_WIDEST:g}")
    if kind == "truncated-normal" and "low" not in numbers and "high" not in numbers:
        problems.add(given, where, "truncated-normal: has no bound; write low, high or both, or use normal")
    if not low <= mean <= high or low == high:
        sentence = f"{kind}: the mean {mean:.15g} is not between low {low:.15g} and high {high:.15g}; change one"
        problems.add(given, where, sentence)
    if kind == "lognormal" and mean <= 0.0:
        problems.add(given, where, f"lognormal: found the mean {mean:.15g}; it has to be above 0; use normal")
    bounds = {key: numbers[key] for key in ("low", "high") if key in numbers}
    return {"mean": mean, "std": std} | bounds


def _quantity(problems: Problems, where: str, entry: Entry, unit: str) -> float | None:
    """Return a number of a distribution in SI, None where it is wrong."""
    try:
        return quantity.read(entry.value, unit)
    except InputError as error:
        problems.add(entry, where, str(error))
        return None


def draw(problems: Problems, where: str, entry: Entry, found: Distribution, points, fields) -> list[float] | None:
    """Return the values of a variable at `points` (rows,), None where some would be out of the range of `fields`."""
    import numpy as np

    values = found.values(points)
    extremes = (*found.values(np.array([_RARE, 1.0 - _RARE])), values.min(), values.max())
    for field in fields:
        outside = [value for value in extremes if not field.holds(value)]
        if outside:
            sentence = (
                f"{found.kind}: {outside[0]:.6g} is among its values, out of range; allowed: {field.allowed()}; write "
                "low and high within that, or a distribution that stays there"
            )
            problems.add(entry, where, sentence)
            return None
    return values.tolist()
