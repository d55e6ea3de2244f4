"""Draws cases from distributions: reads `sample`, generates its design points, converts them to values."""

import math
from typing import TYPE_CHECKING, Any, NamedTuple

from ...contracts.catalogue import Field
from ...language import quantity
from ...language.errors import InputError, nearest, shown
from ..written.document import Problems, WrittenValue
from .axes import Reading, half_bare

if TYPE_CHECKING:
    import numpy as np  # imported only when values are drawn


_MOST_CASES = 1_000_000
_RARE = 1e-6  # tail of a distribution that may lie out of range: too rare to be drawn
_WIDEST = 1e3  # std over mean of a lognormal; beyond, half of its values are below a millionth of the mean
_NUDGE = 1e-9  # of the distance between the 5 % and 95 % quantiles; a disturbance without physical effect
_POWERS_OF_TWO = ("sobol", "saltelli")  # a Sobol sequence is balanced only for powers of two
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
    """The section `sample` without its distributions."""

    method: str
    n: int
    seed: int
    points: "np.ndarray"  # (rows, variables) in the open interval (0, 1); the rows of the design
    drawn: dict[str, WrittenValue]  # values drawn earlier, which are kept


class Distribution(NamedTuple):
    """The distribution of one value, in SI."""

    kind: str
    numbers: dict[str, float]

    def values(self, points: "np.ndarray") -> "np.ndarray":
        """Return the quantiles at `points`, (rows,) in (0, 1); without spread, exactly the constant value."""
        import numpy as np
        from scipy.special import ndtr, ndtri

        low, high = self.numbers.get("low", -math.inf), self.numbers.get("high", math.inf)
        if self.kind == "uniform":
            return np.clip(low + (high - low) * points, low, high)
        if self.kind == "loguniform":
            return np.clip(low * (high / low) ** points, low, high)
        mean, std = self.numbers["mean"], self.numbers["std"]
        if std == 0.0:
            return np.full(len(points), mean)
        quantiles: np.ndarray
        if self.kind == "lognormal":
            variance = math.log1p((std / mean) ** 2)  # of the logarithm
            quantiles = mean * np.exp(math.sqrt(variance) * ndtri(points) - variance / 2.0)
        else:
            lower_share, upper_share = ndtr((low - mean) / std), ndtr((high - mean) / std)
            quantiles = np.clip(mean + std * ndtri(lower_share + (upper_share - lower_share) * points), low, high)
        return quantiles

    def written(self) -> dict[str, Any]:
        """Return the distribution in the form of a grid file, in SI."""
        ends = self.kind in ("uniform", "loguniform")
        return {self.kind: [self.numbers["low"], self.numbers["high"]] if ends else dict(self.numbers)}


def read_sample(problems: Problems, written: WrittenValue, variables: int) -> Sample | None:
    """Return the section `sample` for a number of variables, or None if it is missing or invalid."""
    moments, noted = written.value, len(problems)
    allowed = ("method", "n", "seed", "over", "drawn")
    for key in moments:
        if key not in allowed:
            sentence = f"unknown key '{key}'{nearest(key, allowed)} (allowed: {', '.join(allowed)})"
            problems.add(written.key_place(key), f"sample.{key}", sentence)
    method = moments["method"].value if "method" in moments else None
    if method not in METHODS:
        suggestion = nearest(method, METHODS) if isinstance(method, str) else ""
        invalid = f"unknown method {shown(method)}{suggestion}" if "method" in moments else "is missing"
        problems.add(moments.get("method", written), "sample.method", f"{invalid} (known: {', '.join(METHODS)})")
    seed = _whole(problems, written, "seed", (0, 2**63 - 1), 0)
    if method == "one-at-a-time":
        for key in ("n", "seed"):
            if key in moments:
                sentence = "is not used by one-at-a-time, whose cases follow from the variables; leave it out"
                problems.add(written.key_place(key), f"sample.{key}", sentence)
        n: int | None = 1
    else:
        n = _whole(problems, written, "n", (2, _MOST_CASES), None)
    if n and method in _POWERS_OF_TWO and n & (n - 1):
        low = 1 << (n.bit_length() - 1)
        problems.add(moments["n"], "sample.n", f"found {n}; {method} needs a power of 2, such as {low} or {2 * low}")
    if n and method == "saltelli" and n * (variables + 2) > _MOST_CASES:
        sentence = f"found {n}; with {variables} variables these are {n * (variables + 2)} cases, at most {_MOST_CASES}"
        problems.add(moments["n"], "sample.n", sentence)
    drawn = moments.get("drawn", WrittenValue({})).value
    if not isinstance(drawn, dict):
        problems.add(moments["drawn"], "sample.drawn", f"found {shown(drawn)}; expected the values of each variable")
    if len(problems) > noted or method is None or n is None or seed is None:
        return None
    return Sample(method, n, seed, _points(method, n, seed, variables), drawn)


def _whole(
    problems: Problems, section: WrittenValue, key: str, allowed: tuple[int, int], default: int | None
) -> int | None:
    """Return a whole number of the section, in the range `allowed`, or None if it is missing or invalid."""
    written, (low, high) = section.value.get(key), allowed
    if written is None:
        if default is None:
            problems.add(section, f"sample.{key}", "is missing; write the number of points, such as 64")
        return default
    try:
        number = quantity.exact(written.value, "1")
        if number.denominator == 1 and low <= number <= high:
            return int(number)
        sentence = f"found {written.value}; expected a whole number from {low} to {high}"
    except InputError as error:
        sentence = str(error)
    problems.add(written, f"sample.{key}", sentence)
    return None


def _points(method: str, n: int, seed: int, variables: int) -> "np.ndarray":
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
    points = np.clip(points, 2.0**-54, 1.0 - 2.0**-53)  # 0 and 1 have no finite quantile
    return _saltelli(points, variables) if method == "saltelli" else points


def _saltelli(points: "np.ndarray", variables: int) -> "np.ndarray":
    """Return A, B, and A with each column in turn from B: Saltelli et al. 2010, Comput. Phys. Commun. 181, 259."""
    import numpy as np

    start, second = points[:, :variables], points[:, variables:]
    mixed = []
    for k in range(variables):
        mixed.append(start.copy())
        mixed[-1][:, k] = second[:, k]
    return np.vstack([start, second, *mixed])


def _one_at_a_time(variables: int) -> "np.ndarray":
    """Return the middle, then for each variable alone: its 5 % quantile, its 95 % quantile, the middle disturbed."""
    import numpy as np

    rows = np.full((1 + 3 * variables, variables), 0.5)
    for k in range(variables):
        rows[1 + 3 * k : 4 + 3 * k, k] = 0.05, 0.95, 0.5 + _NUDGE
    return rows


def read_distribution(problems: Problems, where: str, written: WrittenValue, reading: Reading) -> Distribution | None:
    """Return the distribution at the key `where`, or None if it is invalid."""
    kinds = ", ".join(f"{{{kind}: {form}}}" for kind, form in DISTRIBUTIONS.items())
    if not isinstance(written.value, dict) or len(written.value) != 1:
        problems.add(written, where, f"found {shown(written.value)}; expected one of {kinds}")
        return None
    ((kind, moments),) = written.value.items()
    if kind not in DISTRIBUTIONS:
        suggestion = nearest(kind, DISTRIBUTIONS)
        problems.add(written.key_place(kind), where, f"unknown distribution '{kind}'{suggestion} (known: {kinds})")
        return None
    noted = len(problems)
    if kind in ("uniform", "loguniform"):
        numbers = _ends(problems, where, kind, moments, reading)
    else:
        numbers = _moments(problems, where, kind, moments, reading)
    return None if numbers is None or len(problems) > noted else Distribution(kind, numbers)


def _ends(
    problems: Problems, where: str, kind: str, moments: WrittenValue, reading: Reading
) -> dict[str, float] | None:
    """Return both ends of a uniform or loguniform distribution."""
    if not isinstance(moments.value, list) or len(moments.value) != 2:
        problems.add(moments, where, f"{kind}: found {shown(moments.value)}; expected [low, high]")
        return None
    low, high = (reading.value(item) for item in moments.value)
    if half_bare(problems, where, moments.value, reading.unit) or low is None or high is None:
        return None
    start, last = (quantity.said(item.value, reading.unit) for item in moments.value)
    if low > high:
        problems.add(moments, where, f"{kind}: the low end {start} is above the high end {last}; swap them")
    if kind == "loguniform" and low <= 0.0:
        problems.add(moments, where, f"loguniform: found {start}; both ends have to be above 0; use uniform")
    return {"low": low, "high": high}


def _moments(
    problems: Problems, where: str, kind: str, moments: WrittenValue, reading: Reading
) -> dict[str, float] | None:
    """Return mean, standard deviation and bounds of a normal or lognormal distribution."""
    if not isinstance(moments.value, dict):
        sentence = f"{kind}: found {shown(moments.value)}; expected {DISTRIBUTIONS[kind]}"
        problems.add(moments, where, sentence)
        return None
    allowed = ("mean", "std", "cv") if kind == "lognormal" else ("mean", "std", "cv", "low", "high")
    for key in moments.value:
        if key not in allowed:
            sentence = f"unknown key '{key}'{nearest(key, allowed)} (allowed: {', '.join(allowed)})"
            problems.add(moments.key_place(key), f"{where}.{kind}", sentence)
    if ("std" in moments.value) == ("cv" in moments.value) or "mean" not in moments.value:
        problems.add(moments, where, f"{kind}: expected mean and either std or cv: {DISTRIBUTIONS[kind]}")
        return None
    lengths = [item for key, item in moments.value.items() if key != "cv"]
    if half_bare(problems, f"{where}.{kind}", lengths, reading.unit):
        return None
    mean = reading.value(moments.value["mean"])
    written = {
        key: quantity.said(item.value, reading.unit)
        for key, item in moments.value.items()
        if key in ("mean", "low", "high")
    }
    values = {
        key: _quantity(problems, where, moments.value[key], "1" if key == "cv" else reading.unit)
        for key in allowed[1:]
        if key in moments.value
    }
    numbers = {key: value for key, value in values.items() if value is not None}
    if mean is None or len(numbers) < len(values):
        return None
    std = numbers["std"] if "std" in numbers else numbers["cv"] * abs(mean)
    low, high = numbers.get("low", -math.inf), numbers.get("high", math.inf)
    if std < 0.0:
        problems.add(moments, where, f"{kind}: the spread is negative; write a std or cv of at least 0")
    if kind == "lognormal" and std > _WIDEST * mean > 0.0:
        problems.add(moments, where, f"lognormal: found a std of {std / mean:.3g} times the mean; at most {_WIDEST:g}")
    if kind == "truncated-normal" and "low" not in numbers and "high" not in numbers:
        problems.add(moments, where, "truncated-normal: has no bound; write low, high or both, or use normal")
    if not low <= mean <= high or low == high:
        limits = " and ".join(f"{key} {written[key]}" for key in ("low", "high") if key in written)
        sentence = f"{kind}: the mean {written['mean']} is not between its bounds ({limits}); change one"
        problems.add(moments, where, sentence)
    if kind == "lognormal" and mean <= 0.0:
        mean = quantity.said(moments.value["mean"].value, reading.unit)
        sentence = f"lognormal: found the mean {mean}; it has to be above 0"
        problems.add(moments, where, f"{sentence}; use normal")
    bounds = {key: numbers[key] for key in ("low", "high") if key in numbers}
    return {"mean": mean, "std": std} | bounds


def _quantity(problems: Problems, where: str, written: WrittenValue, unit: str) -> float | None:
    """Return a number of a distribution in SI, or None if it is invalid."""
    try:
        return quantity.read(written.value, unit)
    except InputError as error:
        problems.add(written, where, str(error))
        return None


def draw_values(
    problems: Problems,
    where: str,
    written: WrittenValue,
    spread: Distribution,
    points: "np.ndarray",
    fields: tuple[Field, ...],
) -> list[float] | None:
    """Return the values of a variable at `points` (rows,), or None if some are out of the range of `fields`."""
    import numpy as np

    values = spread.values(points)
    extremes = (*spread.values(np.array([_RARE, 1.0 - _RARE])), values.min(), values.max())
    for field in fields:
        out_of_range = [value for value in extremes if not field.contains(value)]
        if out_of_range:
            sentence = (
                f"{spread.kind}: {out_of_range[0]:.6g} is among its values, out of range; allowed: "
                f"{field.allowed(out_of_range[0])}; write low and high within that, or a distribution that stays there"
            )
            problems.add(written, where, sentence)
            return None
    return [float(value) for value in values]
