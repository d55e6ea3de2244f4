"""Reads `sample` and generates the points of its design."""

from typing import TYPE_CHECKING, NamedTuple

from ...language import quantity
from ...language.errors import InputError, nearest, shown
from ..written.document import Problems, WrittenValue

if TYPE_CHECKING:
    import numpy as np  # imported only when values are drawn


_MOST_CASES = 1_000_000
_NUDGE = 1e-9  # of the distance between the 5 % and 95 % quantiles; a disturbance without physical effect
_POWERS_OF_TWO = ("sobol", "saltelli")  # a Sobol sequence is balanced only for powers of two
METHODS = {
    "sobol": "a scrambled Sobol sequence; n a power of 2, and a larger n keeps the cases of a smaller one",
    "latin-hypercube": "a Latin hypercube of n points",
    "random": "n independent points; a larger n keeps the cases of a smaller one",
    "saltelli": "n (variables + 2) points from which Sobol indices follow; n a power of 2",
    "one-at-a-time": "the middle, and each variable alone at its 5 % and 95 % quantile and disturbed a little; no n",
}


class Sample(NamedTuple):
    """The section `sample` without its distributions."""

    method: str
    n: int
    seed: int
    points: "np.ndarray"  # (rows, variables) in the open interval (0, 1); the rows of the design
    drawn: dict[str, WrittenValue]  # values drawn earlier, which are kept


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
