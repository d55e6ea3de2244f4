"""Reads the values of a varied key: a list, evenly spaced values, or a `sample` design of distributions."""

import math
from collections.abc import Callable, Iterator, Mapping
from typing import Any, NamedTuple

from ...contracts.catalogue import Field
from ...language import np, quantity
from ...language.errors import InputError, did_you_mean, quoted
from ..written import MistakeError, Problems, WrittenValue
from . import (
    NAME_SCHEMAS,
    CountKey,
    EntriesKey,
    Key,
    KeySection,
    Sample,
    ValueReader,
    WordKey,
    read_quantity,
    report_mixed_units,
    report_unknown_keys,
    single_key_schemas,
)

# ----------------------------------------------------------------------------------------------------------------------
# Distributions of values: from one record each follow grid files, schema, pages and messages.
#
# Exponentials and powers are those of the C library: numpy's differ in the last bit between processors with and without
# AVX-512, and the same grid would have other cases.


_TAIL_PROBABILITY = 1e-6  # tail of a distribution that may lie out of range: too rare to be drawn
_MAX_RELATIVE_STD = 1e3  # std over mean of a lognormal; beyond, half of its values are below a millionth of the mean
_ENDS, _MOMENTS = ("low", "high"), ("mean", "std", "cv", "low", "high")

Parameters = dict[str, float]  # parameter -> value, SI; without `cv`, which becomes `std`
ParameterTexts = Mapping[str, str]  # parameter -> its value as the user wrote it


class DistributionLaw(NamedTuple):
    """A law of values."""

    form: str  # of its parameters in a grid
    keys: tuple[str, ...]  # parameters, in the order in which they are read
    #: Returns the quantiles at points, (rows,) in (0, 1); of moments, for a standard deviation above 0.
    quantiles: "Callable[[Parameters, np.ndarray], np.ndarray]"
    is_positive: bool = False  # its values are above 0
    needs_bound: bool = False


class Distribution(NamedTuple):
    """The distribution of one value."""

    name: str  # of its law
    parameters: Parameters

    def values(self, points: "np.ndarray") -> "np.ndarray":
        """Return the quantiles at `points`, (rows,) in (0, 1); without spread, exactly the mean."""
        if self.parameters.get("std") == 0.0:
            return 0.0 * points + self.parameters["mean"]
        return DISTRIBUTIONS[self.name].quantiles(self.parameters, points)

    def resolved(self) -> dict[str, Any]:
        """Return the distribution in the form of a grid file, in SI."""
        values = self.parameters
        return {self.name: dict(values) if "mean" in values else [values[key] for key in _ENDS]}


def _bounds(parameters: Parameters) -> tuple[float, float]:
    """Return the bounds of the values; a missing bound is infinite."""
    return parameters.get("low", -math.inf), parameters.get("high", math.inf)


def _uniform_quantiles(parameters: Parameters, points: "np.ndarray") -> "np.ndarray":
    low, high = _bounds(parameters)
    return (low + (high - low) * points).clip(low, high)


def _loguniform_quantiles(parameters: Parameters, points: "np.ndarray") -> "np.ndarray":
    low, high = _bounds(parameters)
    return np.array([low * (high / low) ** point for point in points.tolist()]).clip(low, high)


def _normal_quantiles(parameters: Parameters, points: "np.ndarray") -> "np.ndarray":
    from scipy.special import ndtr, ndtri

    mean, std, (low, high) = parameters["mean"], parameters["std"], _bounds(parameters)
    probability_below, probability_above = ndtr((low - mean) / std), ndtr((high - mean) / std)
    quantiles: np.ndarray = mean + std * ndtri(probability_below + (probability_above - probability_below) * points)
    return quantiles.clip(low, high)


def _lognormal_quantiles(parameters: Parameters, points: "np.ndarray") -> "np.ndarray":
    from scipy.special import ndtri

    mean, std = parameters["mean"], parameters["std"]
    variance = math.log1p((std / mean) ** 2)  # of the logarithm
    exponents = math.sqrt(variance) * ndtri(points) - variance / 2.0
    return mean * np.array([math.exp(exponent) for exponent in exponents.tolist()])


def _mistakes(law: DistributionLaw, parameters: Parameters, texts: ParameterTexts) -> Iterator[str]:
    """Yield what is wrong with the parameters of a law."""
    low, high = _bounds(parameters)
    if law.keys == _ENDS:
        if low > high:
            yield f"the low end {texts['low']} is above the high end {texts['high']}; swap them"
        if law.is_positive and low <= 0.0:
            yield f"found {texts['low']}; both ends must be above 0; use uniform"
        return
    mean, std = parameters["mean"], parameters["std"]
    if law.needs_bound and parameters.keys().isdisjoint(_ENDS):
        yield "has no bound; write low, high or both, or use normal"
    if std < 0.0:
        yield "the spread is negative; write a std or cv of at least 0"
    if not low <= mean <= high or low == high:
        limits = " and ".join(f"{key} {texts[key]}" for key in _ENDS if key in texts)
        yield f"the mean {texts['mean']} is not between its bounds ({limits}); change one"
    if law.is_positive and std > _MAX_RELATIVE_STD * mean > 0.0:
        yield f"found a std of {std / mean:.3g} times the mean; at most {_MAX_RELATIVE_STD:g}"
    if law.is_positive and mean <= 0.0:
        yield f"found the mean {texts['mean']}; it must be above 0; use normal"


#: Those with bounds among their moments are truncated there.
DISTRIBUTIONS = {
    "uniform": DistributionLaw("[low, high]", _ENDS, _uniform_quantiles),
    "loguniform": DistributionLaw("[low, high]", _ENDS, _loguniform_quantiles, is_positive=True),
    "normal": DistributionLaw("{mean, std or cv, low?, high?}", _MOMENTS, _normal_quantiles),
    "truncated-normal": DistributionLaw(
        "{mean, std or cv, low and/or high}", _MOMENTS, _normal_quantiles, needs_bound=True
    ),
    "lognormal": DistributionLaw("{mean, std or cv}", _MOMENTS[:3], _lognormal_quantiles, is_positive=True),
}
#: Name of a distribution -> its section in a grid, from a fit.
FROM_FIT = {
    "uniform": lambda limits: {"uniform": [limits.low, limits.high]},
    "normal": lambda limits: {  # the limits are at 3 standard deviations; parts beyond them are rejected
        "truncated-normal": {
            "mean": limits.mean,
            "std": (limits.high - limits.low) / 6.0,
            "low": limits.low,
            "high": limits.high,
        }
    },
}


def parameter_forms() -> dict[str, str]:
    """Return name -> form of the parameters, of every law."""
    return {name: law.form for name, law in DISTRIBUTIONS.items()}


def forms_text() -> str:
    """Return the grid form of every law, for messages: `{uniform: [low, high]}, ...`."""
    return ", ".join(f"{{{name}: {form}}}" for name, form in parameter_forms().items())


def _read_ends(
    problems: Problems, key_path: str, name: str, written: WrittenValue, reading: ValueReader
) -> tuple[Parameters, ParameterTexts]:
    """Return the two ends of a distribution and their texts."""
    bounds = written.value
    if not isinstance(bounds, list) or len(bounds) != len(_ENDS):
        message = f"{name}: found {quoted(bounds)}; expected {DISTRIBUTIONS[name].form}"
        raise MistakeError(written, key_path, message)
    low, high = (reading.value(item) for item in bounds)
    if report_mixed_units(problems, key_path, bounds, reading.unit) or low is None or high is None:
        raise MistakeError(written, key_path)
    texts = (quantity.written_text(item.value, reading.unit) for item in bounds)
    return {"low": low, "high": high}, dict(zip(_ENDS, texts, strict=True))


def _read_moments(
    problems: Problems, key_path: str, name: str, written: WrittenValue, reading: ValueReader
) -> tuple[Parameters, ParameterTexts]:
    """Return mean, standard deviation and bounds of a distribution, and their texts."""
    law, moments = DISTRIBUTIONS[name], written.value
    if not isinstance(moments, dict):
        raise MistakeError(written, key_path, f"{name}: found {quoted(moments)}; expected {law.form}")
    report_unknown_keys(problems, f"{key_path}.{name}", written, law.keys)
    if ("std" in moments) == ("cv" in moments) or "mean" not in moments:
        raise MistakeError(written, key_path, f"{name}: expected mean and either std or cv: {law.form}")
    quantities = [item for key, item in moments.items() if key != "cv"]
    if report_mixed_units(problems, f"{key_path}.{name}", quantities, reading.unit):
        raise MistakeError(written, key_path)
    units = {key: "1" if key == "cv" else reading.unit for key in law.keys[1:] if key in moments}
    values = {"mean": reading.value(moments["mean"])}
    values |= {key: read_quantity(problems, key_path, moments[key], unit) for key, unit in units.items()}
    if None in values.values():
        raise MistakeError(written, key_path)
    cv = values.pop("cv", None)
    std = values.pop("std") if cv is None else cv * abs(values["mean"])
    parameters = {"mean": values.pop("mean"), "std": std, **values}
    return parameters, {
        key: quantity.written_text(moments[key].value, reading.unit) for key in parameters if key in moments
    }


def read_distribution(problems: Problems, key_path: str, written: WrittenValue, reading: ValueReader) -> Distribution:
    """Return the distribution at the key at `key_path`; MistakeError if it is invalid."""
    if not isinstance(written.value, dict) or len(written.value) != 1:
        raise MistakeError(written, key_path, f"found {quoted(written.value)}; expected one of {forms_text()}")
    ((name, written_parameters),) = written.value.items()
    if name not in DISTRIBUTIONS:
        message = f"unknown distribution '{name}'{did_you_mean(name, DISTRIBUTIONS)} (known: {forms_text()})"
        raise MistakeError(written.key_position(name), key_path, message)
    read = _read_moments if "mean" in DISTRIBUTIONS[name].keys else _read_ends
    problems_before = len(problems)
    parameters, texts = read(problems, key_path, name, written_parameters, reading)
    for message in _mistakes(DISTRIBUTIONS[name], parameters, texts):
        problems.add(written_parameters, key_path, f"{name}: {message}")
    if len(problems) > problems_before:
        raise MistakeError(written, key_path)
    return Distribution(name, parameters)


def distribution_of(written: Mapping[str, Any]) -> Distribution:
    """Return the distribution of a resolved grid, given in SI in the form of `Distribution.resolved`."""
    ((name, parameters),) = written.items()
    if not isinstance(parameters, Mapping):
        parameters = dict(zip(DISTRIBUTIONS[name].keys, parameters, strict=True))
    return Distribution(name, dict(parameters))


def draw_values(
    key_path: str, written: WrittenValue, distribution: Distribution, points: "np.ndarray", fields: tuple[Field, ...]
) -> list[float]:
    """Return the values of a variable at `points` (rows,); MistakeError if some are out of the range of `fields`."""
    values = distribution.values(points)
    extremes = (
        *distribution.values(np.array([_TAIL_PROBABILITY, 1.0 - _TAIL_PROBABILITY])),
        values.min(),
        values.max(),
    )
    for field in fields:
        out_of_range = [value for value in extremes if not field.contains(value)]
        if out_of_range:
            message = (
                f"{distribution.name}: {out_of_range[0]:.6g} is among its values, out of range; allowed: "
                f"{field.allowed(out_of_range[0])}; write low and high within that, or a distribution that stays there"
            )
            raise MistakeError(written, key_path, message)
    return [float(value) for value in values]


# ----------------------------------------------------------------------------------------------------------------------
# Axes: a list of values, or evenly spaced ones; designs of `sample`.


_MAX_LISTED_VALUES = 100_000  # values in a list: as many as a person or a script may reasonably write out
_MAX_VALUES = 1_000_000  # values on one axis; they are kept in memory
SPACING_FORMS = {
    "linspace": "[first, last, count]",
    "geomspace": "[first, last, count]",
    "logspace": "[exponent of the first value, exponent of the last, count]; a fourth item is the unit if it is not SI",
}


def read_axis(
    problems: Problems, key_path: str, written: WrittenValue, reading: ValueReader, *, distinct: bool = True
) -> list[Any]:
    """Return the values of the axis at the key at `key_path`; MistakeError if it is invalid.

    Values must be distinct unless they vary together with those of other axes.
    """
    if isinstance(written.value, list):
        if not written.value:
            message = "the list is empty; write at least one value, or leave the path out"
            raise MistakeError(written, key_path, message)
        if report_mixed_units(problems, key_path, written.value, reading.unit):
            raise MistakeError(written, key_path)
        if distinct:
            return _distinct_values(problems, key_path, written, reading)
        return _known([reading.value(item) for item in written.value], written, key_path)
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
    message = f"found {quoted(written.value)}; expected a list such as [a, b]{spacing_text if reading.unit else ''}"
    raise MistakeError(written, key_path, message)


def _known(values: list[Any], written: WrittenValue, key_path: str) -> list[Any]:
    """Return values none of which is None; MistakeError if one was wrong, which is reported."""
    if None in values:
        raise MistakeError(written, key_path)
    return values


def _distinct_values(problems: Problems, key_path: str, written: WrittenValue, reading: ValueReader) -> list[Any]:
    """Return the values of a list, which must all differ."""
    if written.line and len(written.value) > _MAX_LISTED_VALUES:
        message = (
            f"found a list of {len(written.value)} values; at most {_MAX_LISTED_VALUES} can be written out: "
            "use {linspace: [first, last, count]} or {geomspace: [first, last, count]}"
        )
        raise MistakeError(written, key_path, message)
    first_items: dict[Any, WrittenValue] = {}
    for item in written.value:
        value = reading.value(item)
        if value is not None and value in first_items:
            line_text = f" (line {first_items[value].line})" if first_items[value].line else ""
            message = (
                f"duplicate value {quoted(item.value)}, the same as {quoted(first_items[value].value)}{line_text}; "
                "each value may occur only once"
            )
            problems.add(item, key_path, message)
        elif value is not None:
            first_items[value] = item
    return _known([*first_items, *[None] * (len(written.value) - len(first_items))], written, key_path)


def _spaced_values(
    problems: Problems, key_path: str, spacing: str, parameters: WrittenValue, reading: ValueReader
) -> list[Any]:
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
            raise MistakeError(parameters, key_path)
        else:
            values = _values_between(spacing, items, int(count), reading.unit)
        if len(set(values)) < len(values):
            raise InputError(f"{len(values)} values from {values[0]!r} to {values[-1]!r} (SI) are not all different")
    except InputError as error:
        raise MistakeError(parameters, key_path, f"{spacing}: {error}") from None
    return _known([reading.value(parameters.with_value(value)) for value in values], parameters, key_path)


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
        message = f"found {quoted(earlier_values)}; expected the values of each variable"
        problems.add(content["drawn"], "sample.drawn", message)
    if len(problems) > problems_before or method is None or n is None or seed is None:
        return None
    return Sample(method, n, seed, _design_points(method, n, seed, variables), earlier_values)


def _design_points(method: str, n: int, seed: int, variables: int) -> "np.ndarray":
    """Return the points of a design, (rows, variables) in (0, 1)."""
    if method == "one-at-a-time":
        rows = np.full((1 + 3 * variables, variables), 0.5)  # the middle, then for each variable alone its quantiles
        for k in range(variables):
            rows[1 + 3 * k : 4 + 3 * k, k] = 0.05, 0.95, 0.5 + _DISTURBANCE
        return rows
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
    matrix_a, matrix_b = points[:, :variables], points[:, variables:]
    matrices_ab = []
    for k in range(variables):
        matrices_ab.append(matrix_a.copy())
        matrices_ab[-1][:, k] = matrix_b[:, k]
    return np.vstack([matrix_a, matrix_b, *matrices_ab])
