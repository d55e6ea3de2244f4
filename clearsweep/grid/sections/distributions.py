"""Distributions of values: a law is one class, from which grid files, schema, pages and messages follow.

A law has a name, the form of its parameters in a grid, its own conditions, and its quantile.  `@law` registers it.
"""

import math
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any, ClassVar

from ...contracts.catalogue import Field
from ...language import quantity
from ...language.errors import did_you_mean, quoted
from ..written import Problems, WrittenValue
from . import ValueReader, read_quantity, report_mixed_units, report_unknown_keys

if TYPE_CHECKING:
    import numpy as np  # imported only when values are drawn

_TAIL_PROBABILITY = 1e-6  # tail of a distribution that may lie out of range: too rare to be drawn
_MAX_RELATIVE_STD = 1e3  # std over mean of a lognormal; beyond, half of its values are below a millionth of the mean

Parameters = dict[str, float]  # parameter -> value, SI; without `cv`, which becomes `std`
ParameterTexts = Mapping[str, str]  # parameter -> its value as the user wrote it


class Distribution:
    """The distribution of one value, with its parameters in SI.

    Exponentials and powers are those of the C library: numpy's differ in the last bit between processors with and
    without AVX-512, and the same grid would have other cases.
    """

    name: ClassVar[str]
    form: ClassVar[str]  # of its parameters in a grid
    keys: ClassVar[tuple[str, ...]]  # parameters, in the order in which they are read

    def __init__(self, parameters: Parameters):
        self.parameters = parameters

    @property
    def bounds(self) -> tuple[float, float]:
        """Return the bounds of the values; a missing bound is infinite."""
        return self.parameters.get("low", -math.inf), self.parameters.get("high", math.inf)

    def values(self, points: "np.ndarray") -> "np.ndarray":
        """Return the quantiles at `points`, (rows,) in (0, 1)."""
        raise NotImplementedError

    def resolved(self) -> dict[str, Any]:
        """Return the distribution in the form of a grid file, in SI."""
        raise NotImplementedError

    @classmethod
    def mistakes(cls, parameters: Parameters, texts: ParameterTexts) -> Iterator[str]:
        """Yield what is wrong with the parameters."""
        raise NotImplementedError

    @classmethod
    def read(cls, problems: Problems, key_path: str, written: WrittenValue, reading: ValueReader) -> Parameters | None:
        """Return the parameters from a grid, or None if they are invalid."""
        raise NotImplementedError


DISTRIBUTIONS: dict[str, type[Distribution]] = {}


def register(distribution: type[Distribution]) -> type[Distribution]:
    """Register a law under its name, and return it."""
    DISTRIBUTIONS[distribution.name] = distribution
    return distribution


class _Bounded(Distribution):
    """A law with two ends."""

    form = "[low, high]"
    keys = ("low", "high")

    def resolved(self) -> dict[str, Any]:
        """Return the distribution in the form of a grid file, in SI."""
        return {self.name: [self.parameters[key] for key in self.keys]}

    @classmethod
    def mistakes(cls, parameters: Parameters, texts: ParameterTexts) -> Iterator[str]:
        """Yield what is wrong with the parameters."""
        if parameters["low"] > parameters["high"]:
            yield f"the low end {texts['low']} is above the high end {texts['high']}; swap them"

    @classmethod
    def read(cls, problems: Problems, key_path: str, written: WrittenValue, reading: ValueReader) -> Parameters | None:
        """Return the parameters from a grid, or None if they are invalid."""
        bounds = written.value
        if not isinstance(bounds, list) or len(bounds) != len(cls.keys):
            problems.add(written, key_path, f"{cls.name}: found {quoted(bounds)}; expected {cls.form}")
            return None
        low, high = (reading.value(item) for item in bounds)
        if report_mixed_units(problems, key_path, bounds, reading.unit) or low is None or high is None:
            return None
        parameters = {"low": low, "high": high}
        texts = {
            key: quantity.written_text(item.value, reading.unit) for key, item in zip(cls.keys, bounds, strict=True)
        }
        for message in cls.mistakes(parameters, texts):
            problems.add(written, key_path, f"{cls.name}: {message}")
        return parameters


@register
class Uniform(_Bounded):
    """Uniform distribution between two ends."""

    name = "uniform"

    def values(self, points: "np.ndarray") -> "np.ndarray":
        """Return the quantiles at `points`, (rows,) in (0, 1)."""
        low, high = self.bounds
        return (low + (high - low) * points).clip(low, high)


@register
class LogUniform(_Bounded):
    """Uniform distribution of the logarithm, between two ends above 0."""

    name = "loguniform"

    def values(self, points: "np.ndarray") -> "np.ndarray":
        """Return the quantiles at `points`, (rows,) in (0, 1)."""
        import numpy as np

        low, high = self.bounds
        return np.array([low * (high / low) ** point for point in points.tolist()]).clip(low, high)

    @classmethod
    def mistakes(cls, parameters: Parameters, texts: ParameterTexts) -> Iterator[str]:
        """Yield what is wrong with the parameters."""
        yield from super().mistakes(parameters, texts)
        if parameters["low"] <= 0.0:
            yield f"found {texts['low']}; both ends must be above 0; use uniform"


class _WithMean(Distribution):
    """A law with a mean, a standard deviation, and perhaps bounds."""

    keys: ClassVar[tuple[str, ...]] = ("mean", "std", "cv", "low", "high")

    def values(self, points: "np.ndarray") -> "np.ndarray":
        """Return the quantiles; without spread, exactly the mean."""
        import numpy as np

        return (
            np.full(len(points), self.parameters["mean"])
            if self.parameters["std"] == 0.0
            else self.quantiles_about_mean(points)
        )

    def quantiles_about_mean(self, points: "np.ndarray") -> "np.ndarray":
        """Return the quantiles of a standard deviation above 0."""
        raise NotImplementedError

    def resolved(self) -> dict[str, Any]:
        """Return the distribution in the form of a grid file, in SI."""
        return {self.name: dict(self.parameters)}

    @classmethod
    def mistakes(cls, parameters: Parameters, texts: ParameterTexts) -> Iterator[str]:
        """Yield what is wrong with the parameters."""
        low, high = parameters.get("low", -math.inf), parameters.get("high", math.inf)
        if parameters["std"] < 0.0:
            yield "the spread is negative; write a std or cv of at least 0"
        if not low <= parameters["mean"] <= high or low == high:
            limits = " and ".join(f"{key} {texts[key]}" for key in ("low", "high") if key in texts)
            yield f"the mean {texts['mean']} is not between its bounds ({limits}); change one"

    @classmethod
    def read(cls, problems: Problems, key_path: str, written: WrittenValue, reading: ValueReader) -> Parameters | None:
        """Return the parameters from a grid, or None if they are invalid."""
        moments = written.value
        if not isinstance(moments, dict):
            problems.add(written, key_path, f"{cls.name}: found {quoted(moments)}; expected {cls.form}")
            return None
        report_unknown_keys(problems, f"{key_path}.{cls.name}", written, cls.keys)
        if ("std" in moments) == ("cv" in moments) or "mean" not in moments:
            problems.add(written, key_path, f"{cls.name}: expected mean and either std or cv: {cls.form}")
            return None
        quantities = [item for key, item in moments.items() if key != "cv"]
        if report_mixed_units(problems, f"{key_path}.{cls.name}", quantities, reading.unit):
            return None
        units = {key: "1" if key == "cv" else reading.unit for key in cls.keys[1:] if key in moments}
        values = {"mean": reading.value(moments["mean"])}
        values |= {key: read_quantity(problems, key_path, moments[key], unit) for key, unit in units.items()}
        if None in values.values():
            return None
        cv = values.pop("cv", None)
        std = values.pop("std") if cv is None else cv * abs(values["mean"])
        parameters = {"mean": values.pop("mean"), "std": std, **values}
        texts = {key: quantity.written_text(moments[key].value, reading.unit) for key in parameters if key in moments}
        for message in cls.mistakes(parameters, texts):
            problems.add(written, key_path, f"{cls.name}: {message}")
        return parameters


@register
class Normal(_WithMean):
    """Normal distribution, truncated at bounds if there are any."""

    name = "normal"
    form = "{mean, std or cv, low?, high?}"

    def quantiles_about_mean(self, points: "np.ndarray") -> "np.ndarray":
        """Return the quantiles of a standard deviation above 0."""
        from scipy.special import ndtr, ndtri

        mean, std = self.parameters["mean"], self.parameters["std"]
        low, high = self.bounds
        probability_below, probability_above = ndtr((low - mean) / std), ndtr((high - mean) / std)
        quantiles: np.ndarray = mean + std * ndtri(probability_below + (probability_above - probability_below) * points)
        return quantiles.clip(low, high)


@register
class TruncatedNormal(Normal):
    """Normal distribution, truncated at one or two bounds."""

    name = "truncated-normal"
    form = "{mean, std or cv, low and/or high}"

    @classmethod
    def mistakes(cls, parameters: Parameters, texts: ParameterTexts) -> Iterator[str]:
        """Yield what is wrong with the parameters."""
        if parameters.keys().isdisjoint(("low", "high")):
            yield "has no bound; write low, high or both, or use normal"
        yield from super().mistakes(parameters, texts)


@register
class LogNormal(_WithMean):
    """Normal distribution of the logarithm, for values above 0."""

    name = "lognormal"
    form = "{mean, std or cv}"
    keys = ("mean", "std", "cv")

    def quantiles_about_mean(self, points: "np.ndarray") -> "np.ndarray":
        """Return the quantiles of a standard deviation above 0."""
        import numpy as np
        from scipy.special import ndtri

        mean, std = self.parameters["mean"], self.parameters["std"]
        variance = math.log1p((std / mean) ** 2)  # of the logarithm
        exponents = math.sqrt(variance) * ndtri(points) - variance / 2.0
        return mean * np.array([math.exp(exponent) for exponent in exponents.tolist()])

    @classmethod
    def mistakes(cls, parameters: Parameters, texts: ParameterTexts) -> Iterator[str]:
        """Yield what is wrong with the parameters."""
        yield from super().mistakes(parameters, texts)
        mean, std = parameters["mean"], parameters["std"]
        if std > _MAX_RELATIVE_STD * mean > 0.0:
            yield f"found a std of {std / mean:.3g} times the mean; at most {_MAX_RELATIVE_STD:g}"
        if mean <= 0.0:
            yield f"found the mean {texts['mean']}; it must be above 0; use normal"


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
    return {distribution.name: distribution.form for distribution in DISTRIBUTIONS.values()}


def forms_text() -> str:
    """Return the grid form of every law, for messages: `{uniform: [low, high]}, ...`."""
    return ", ".join(f"{{{name}: {form}}}" for name, form in parameter_forms().items())


def read_distribution(
    problems: Problems, key_path: str, written: WrittenValue, reading: ValueReader
) -> Distribution | None:
    """Return the distribution at the key at `key_path`, or None if it is invalid."""
    if not isinstance(written.value, dict) or len(written.value) != 1:
        problems.add(written, key_path, f"found {quoted(written.value)}; expected one of {forms_text()}")
        return None
    ((name, written_parameters),) = written.value.items()
    if name not in DISTRIBUTIONS:
        message = f"unknown distribution '{name}'{did_you_mean(name, DISTRIBUTIONS)} (known: {forms_text()})"
        problems.add(written.key_position(name), key_path, message)
        return None
    problems_before = len(problems)
    numbers = DISTRIBUTIONS[name].read(problems, key_path, written_parameters, reading)
    return None if numbers is None or len(problems) > problems_before else DISTRIBUTIONS[name](numbers)


def distribution_of(written: Mapping[str, Any]) -> Distribution:
    """Return the distribution of a resolved grid, given in SI in the form of `Distribution.resolved`."""
    ((name, parameters),) = written.items()
    if not isinstance(parameters, Mapping):
        parameters = dict(zip(DISTRIBUTIONS[name].keys, parameters, strict=True))
    return DISTRIBUTIONS[name](dict(parameters))


def draw_values(
    problems: Problems,
    key_path: str,
    written: WrittenValue,
    distribution: Distribution,
    points: "np.ndarray",
    fields: tuple[Field, ...],
) -> list[float] | None:
    """Return the values of a variable at `points` (rows,), or None if some are out of the range of `fields`."""
    import numpy as np

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
            problems.add(written, key_path, message)
            return None
    return [float(value) for value in values]
