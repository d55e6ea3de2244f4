"""Reads the values of a varied key: a list, evenly spaced values, or the points of a `sample` design."""

from typing import TYPE_CHECKING, Any

from ...language import quantity
from ...language.errors import InputError, quoted
from ..written import Problems, WrittenValue
from . import (
    NAME_SCHEMAS,
    CountKey,
    EntriesKey,
    Key,
    KeySection,
    Sample,
    ValueReader,
    WordKey,
    report_mixed_units,
    single_key_schemas,
)
from .distributions import FROM_FIT, parameter_forms

if TYPE_CHECKING:
    import numpy as np  # imported only when values are drawn


_MAX_LISTED_VALUES = 100_000  # values in a list: as many as a person or a script may reasonably write out
_MAX_VALUES = 1_000_000  # values on one axis; they are kept in memory
SPACING_FORMS = {
    "linspace": "[first, last, count]",
    "geomspace": "[first, last, count]",
    "logspace": "[exponent of the first value, exponent of the last, count]; a fourth item is the unit if it is not SI",
}


def read_axis(
    problems: Problems, key_path: str, written: WrittenValue, reading: ValueReader, *, distinct: bool = True
) -> list[Any] | None:
    """Return the values of the axis at the key at `key_path`, or None if it is invalid.

    Values must be distinct unless they vary together with those of other axes.
    """
    if isinstance(written.value, list):
        if not written.value:
            problems.add(written, key_path, "the list is empty; write at least one value, or leave the path out")
        if report_mixed_units(problems, key_path, written.value, reading.unit):
            return None
        return (
            _distinct_values(problems, key_path, written, reading) if distinct else _repeatable_values(written, reading)
        )
    if (
        reading.unit
        and isinstance(written.value, dict)
        and len(written.value) == 1
        and set(written.value) <= set(SPACING_FORMS)
    ):
        ((spacing, parameters),) = written.value.items()
        return _spaced_values(problems, key_path, spacing, parameters, reading)
    spacing_text = (
        f", {{label: a, other label: b}}, or {{linspace: {SPACING_FORMS['linspace']}}}, or geomspace or logspace in "
        "its place"
    )
    problems.add(
        written,
        key_path,
        f"found {quoted(written.value)}; expected a list such as [a, b]{spacing_text if reading.unit else ''}",
    )
    return None


def _repeatable_values(written: WrittenValue, reading: ValueReader) -> list[Any] | None:
    """Return the values of a list, which may repeat."""
    values = [reading.value(item) for item in written.value]
    return None if not values or None in values else values


def _distinct_values(
    problems: Problems, key_path: str, written: WrittenValue, reading: ValueReader
) -> list[Any] | None:
    """Return the values of a list, which must all differ."""
    if written.line and len(written.value) > _MAX_LISTED_VALUES:
        problems.add(
            written,
            key_path,
            f"found a list of {len(written.value)} values; at most {_MAX_LISTED_VALUES} can be written out: "
            "use {linspace: [first, last, count]} or {geomspace: [first, last, count]}",
        )
        return None
    first_items: dict[Any, WrittenValue] = {}
    for item in written.value:
        value = reading.value(item)
        if value is not None and value in first_items:
            line_text = f" (line {first_items[value].line})" if first_items[value].line else ""
            problems.add(
                item,
                key_path,
                f"duplicate value {quoted(item.value)}, the same as {quoted(first_items[value].value)}{line_text}; "
                "each value may occur only once",
            )
        elif value is not None:
            first_items[value] = item
    return list(first_items) if len(first_items) == len(written.value) else None


def _spaced_values(
    problems: Problems, key_path: str, spacing: str, parameters: WrittenValue, reading: ValueReader
) -> list[Any] | None:
    """Return evenly spaced values."""
    items = parameters.value if isinstance(parameters.value, list) else []
    try:
        if len(items) != 3 and not (spacing == "logspace" and len(items) == 4):
            raise InputError(f"found {quoted(parameters.value)} of {len(items)}; expected {SPACING_FORMS[spacing]}")
        count = quantity.read(items[2].value, "1")
        if count != int(count) or not 2 <= count <= _MAX_VALUES:
            raise InputError(f"found the count {count:.15g}; expected a whole number from 2 to {_MAX_VALUES}")
        if spacing == "logspace":
            values = _powers_of_ten(items, int(count), reading.unit)
        elif report_mixed_units(problems, key_path, items[:2], reading.unit) or None in [
            reading.value(item) for item in items[:2]
        ]:
            return None
        else:
            values = _values_between(spacing, items, int(count), reading.unit)
        if len(set(values)) < len(values):
            raise InputError(f"{len(values)} values from {values[0]!r} to {values[-1]!r} (SI) are not all different")
    except InputError as error:
        problems.add(parameters, key_path, f"{spacing}: {error}")
        return None
    checked = [
        reading.value(WrittenValue(value, parameters.origin, parameters.line, parameters.column)) for value in values
    ]
    return None if None in checked else checked


def _values_between(spacing: str, items: list[WrittenValue], count: int, unit: str) -> list[float]:
    """Return values from the first to the second item, both included.

    Linear spacing is exact before the last rounding, so each value equals the one a user would write out.
    """
    steps = count - 1
    first, last = quantity.exact(items[0].value, unit), quantity.exact(items[1].value, unit)
    if spacing == "linspace":
        denominator = first.denominator * last.denominator * steps
        start, stop = first.numerator * last.denominator, last.numerator * first.denominator
        return [(start * (steps - k) + stop * k) / denominator for k in range(count)]
    if first * last <= 0:
        raise InputError("first and last must be both above 0 or both below; use linspace")
    low, high = float(first), float(last)
    return [low, *(low * (high / low) ** (k / steps) for k in range(1, steps)), high]


def _powers_of_ten(items: list[WrittenValue], count: int, unit: str) -> list[float]:
    """Return powers of ten from one exponent to another, in the unit of the fourth item or in SI."""
    first, last = (quantity.read(item.value, "1") for item in items[:2])
    unit_text = items[3].value if len(items) == 4 else ""
    if not isinstance(unit_text, str):
        raise InputError(f"found {quoted(unit_text)} as the unit; expected one such as {unit if unit != '1' else '%'}")
    scale = quantity.read(f"1 {unit_text}", unit) if unit_text else 1.0
    try:
        return [scale * 10.0 ** (first + (last - first) * (k / (count - 1))) for k in range(count)]
    except OverflowError:
        raise InputError(f"the exponents {first:.15g} and {last:.15g} exceed the range of numbers") from None


_MAX_CASES = 1_000_000
_DISTURBANCE = 1e-9  # of the distance between the 5 % and 95 % quantiles; a disturbance without physical effect
_POWERS_OF_TWO = ("sobol", "saltelli")  # a Sobol sequence is balanced only for powers of two
DESIGNS = {
    "sobol": "scrambled Sobol sequence; n is a power of 2, and a larger n keeps the cases of a smaller one",
    "latin-hypercube": "a Latin hypercube of n points",
    "random": "n independent points; a larger n keeps the cases of a smaller one",
    "saltelli": "n (variables + 2) points for Sobol indices; n is a power of 2",
    "one-at-a-time": "all medians; then each variable at its 5 % and 95 % quantiles and slightly changed; no n",
}
_MISSING_N_TEXT = "; write the number of points, such as 64"
SAMPLE = "sample"
_DISTRIBUTION_OF_NAME = {"distribution": {"enum": list(FROM_FIT), "default": "uniform"}}
_NAME_FORMS = [
    schema | {"properties": schema["properties"] | _DISTRIBUTION_OF_NAME} for schema in NAME_SCHEMAS.values()
]
SAMPLE_SECTION = KeySection(
    SAMPLE,
    "cases drawn from distributions",
    "{method: sobol, n: 64, over: {joints.rod-slider.clearance: {uniform: [20 um, 80 um]}}}",
    (
        WordKey(
            "method",
            "one of the designs below",
            words=tuple(DESIGNS),
            noun="method",
            required=True,
            form={"description": "; ".join(map(": ".join, DESIGNS.items()))},
        ),
        CountKey("n", "number of points, at least 2", low=2, high=_MAX_CASES, missing=_MISSING_N_TEXT),
        CountKey(
            "seed", "a whole number, default 0; the same seed gives the same cases", low=0, high=2**63 - 1, default=0
        ),
        EntriesKey(
            "over",
            "dotted path -> distribution",
            required=True,
            entry={
                "anyOf": [
                    *single_key_schemas({k: {"description": v} for k, v in parameter_forms().items()}),
                    *_NAME_FORMS,
                ]
            },
        ),
        Key("drawn", "values drawn before, as run.json keeps them", {"type": "object"}, internal=True),
    ),
    adds_cases=False,
)


def read_sample(problems: Problems, written: WrittenValue, variables: int) -> Sample | None:
    """Return the section `sample` for a number of variables, or None if it is missing or invalid."""
    content, problems_before = written.value, len(problems)
    method = SAMPLE_SECTION.value(problems, written, "method")
    if method == "one-at-a-time":
        for key in ("n", "seed"):
            if key in content:
                message = "is not used by one-at-a-time, whose cases follow from the variables; leave it out"
                problems.add(written.key_position(key), f"sample.{key}", message)
        n, seed = 1, 0
    else:
        n, seed = (SAMPLE_SECTION.value(problems, written, key) for key in ("n", "seed"))
    if n and method in _POWERS_OF_TWO and n & (n - 1):
        low = 1 << (n.bit_length() - 1)
        problems.add(content["n"], "sample.n", f"found {n}; {method} needs a power of 2, such as {low} or {2 * low}")
    if n and method == "saltelli" and n * (variables + 2) > _MAX_CASES:
        message = f"found {n}; with {variables} variables these are {n * (variables + 2)} cases, at most {_MAX_CASES}"
        problems.add(content["n"], "sample.n", message)
    earlier_values = content.get("drawn", WrittenValue({})).value
    if not isinstance(earlier_values, dict):
        problems.add(
            content["drawn"], "sample.drawn", f"found {quoted(earlier_values)}; expected the values of each variable"
        )
    if len(problems) > problems_before or method is None or n is None or seed is None:
        return None
    return Sample(method, n, seed, _design_points(method, n, seed, variables), earlier_values)


def _design_points(method: str, n: int, seed: int, variables: int) -> "np.ndarray":
    """Return the points of a design, (rows, variables) in (0, 1)."""
    import numpy as np

    if method == "one-at-a-time":
        return _one_at_a_time_points(variables)
    generator = np.random.default_rng(seed)
    if method == "random":
        points = generator.random((n, variables))
    else:
        from scipy.stats import qmc

        sampler = qmc.LatinHypercube if method == "latin-hypercube" else qmc.Sobol
        points = sampler(2 * variables if method == "saltelli" else variables, seed=generator).random(n)
    points = np.clip(points, 2.0**-54, 1.0 - 2.0**-53)  # 0 and 1 have no finite quantile
    return _saltelli_points(points, variables) if method == "saltelli" else points


def _saltelli_points(points: "np.ndarray", variables: int) -> "np.ndarray":
    """Return A, B, and A with each column in turn from B: Saltelli et al. 2010, Comput. Phys. Commun. 181, 259."""
    import numpy as np

    matrix_a, matrix_b = points[:, :variables], points[:, variables:]
    matrices_ab = []
    for k in range(variables):
        matrices_ab.append(matrix_a.copy())
        matrices_ab[-1][:, k] = matrix_b[:, k]
    return np.vstack([matrix_a, matrix_b, *matrices_ab])


def _one_at_a_time_points(variables: int) -> "np.ndarray":
    """Return the middle, then for each variable alone its 5 % quantile, its 95 % quantile and a disturbed middle."""
    import numpy as np

    rows = np.full((1 + 3 * variables, variables), 0.5)
    for k in range(variables):
        rows[1 + 3 * k : 4 + 3 * k, k] = 0.05, 0.95, 0.5 + _DISTURBANCE
    return rows
