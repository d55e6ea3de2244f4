"""Reads `sample` and generates the points of its design."""

from typing import TYPE_CHECKING, NamedTuple

from ...language.errors import shown
from ..written.document import Problems, WrittenValue
from .distributions import FROM_FIT, parameter_forms
from .section import FIT_FORM, FIT_NAME, Key, KeySection, named_forms

if TYPE_CHECKING:
    import numpy as np  # imported only when values are drawn


_MOST_CASES = 1_000_000
_NUDGE = 1e-9  # of the distance between the 5 % and 95 % quantiles; a disturbance without physical effect
_POWERS_OF_TWO = ("sobol", "saltelli")  # a Sobol sequence is balanced only for powers of two
METHODS = {
    "sobol": "scrambled Sobol sequence; n is a power of 2, and a larger n keeps the cases of a smaller one",
    "latin-hypercube": "a Latin hypercube of n points",
    "random": "n independent points; a larger n keeps the cases of a smaller one",
    "saltelli": "n (variables + 2) points from which Sobol indices follow; n a power of 2",
    "one-at-a-time": "the medians, and each variable alone at its 5 % and 95 % quantile and slightly changed; no n",
}
SAMPLE = "sample"
_FIT_FORM = FIT_FORM | {"properties": FIT_NAME | {"distribution": {"enum": list(FROM_FIT), "default": "uniform"}}}
SAMPLE_SECTION = KeySection(
    SAMPLE,
    "cases drawn from distributions",
    "{method: sobol, n: 64, over: {joints.rod-slider.clearance: {uniform: [20 um, 80 um]}}}",
    (
        Key(
            "method",
            "one of the designs below",
            words=tuple(METHODS),
            noun="method",
            required=True,
            form={"description": "; ".join(map(": ".join, METHODS.items()))},
        ),
        Key("n", "number of points, at least 2", whole=(2, _MOST_CASES)),
        Key("seed", "a whole number, default 0; the same seed gives the same cases", whole=(0, 2**63 - 1), default=0),
        Key(
            "over",
            "dotted path -> distribution",
            required=True,
            form={
                "type": "object",
                "minProperties": 1,
                "additionalProperties": {
                    "anyOf": [*named_forms({k: {"description": v} for k, v in parameter_forms().items()}), _FIT_FORM]
                },
            },
        ),
        Key("drawn", "values drawn before, as run.json keeps them", form={"type": "object"}, internal=True),
    ),
    adds_cases=False,
)


class Sample(NamedTuple):
    """The section `sample` without its distributions."""

    method: str
    n: int
    seed: int
    points: "np.ndarray"  # (rows, variables) in the open interval (0, 1); the rows of the design
    drawn: dict[str, WrittenValue]  # values drawn earlier, which are kept


def read_sample(problems: Problems, written: WrittenValue, variables: int) -> Sample | None:
    """Return the section `sample` for a number of variables, or None if it is missing or invalid."""
    moments, problems_before = written.value, len(problems)
    values = SAMPLE_SECTION.read(problems, written)
    method, n, seed = values["method"], values["n"], values["seed"]
    if method == "one-at-a-time":
        for key in ("n", "seed"):
            if key in moments:
                sentence = "is not used by one-at-a-time, whose cases follow from the variables; leave it out"
                problems.add(written.key_place(key), f"sample.{key}", sentence)
        n = 1
    elif "n" not in moments:
        problems.add(written, "sample.n", "is missing; write the number of points, such as 64")
    if n and method in _POWERS_OF_TWO and n & (n - 1):
        low = 1 << (n.bit_length() - 1)
        problems.add(moments["n"], "sample.n", f"found {n}; {method} needs a power of 2, such as {low} or {2 * low}")
    if n and method == "saltelli" and n * (variables + 2) > _MOST_CASES:
        sentence = f"found {n}; with {variables} variables these are {n * (variables + 2)} cases, at most {_MOST_CASES}"
        problems.add(moments["n"], "sample.n", sentence)
    drawn = moments.get("drawn", WrittenValue({})).value
    if not isinstance(drawn, dict):
        problems.add(moments["drawn"], "sample.drawn", f"found {shown(drawn)}; expected the values of each variable")
    if len(problems) > problems_before or method is None or n is None or seed is None:
        return None
    return Sample(method, n, seed, _points(method, n, seed, variables), drawn)


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
