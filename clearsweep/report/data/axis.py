"""Axes of a run for display: names, scales and texts of swept values."""

from collections.abc import Iterable, Mapping
from types import MappingProxyType
from typing import NamedTuple

import numpy as np
import pandas as pd

from ... import grid
from ...grid import Fit
from ...language import wording

AT_ONCE = 65_536  # values looked up together
DIGITS = 4  # of a swept value, if these distinguish its values
FEW_NUMBERS, FEW_NAMES = 6, 16  # most values of an axis that a sentence lists
MANY = 30  # distinct values of a parallel axis above which it is scattered and its levels are not compared


class Axis(NamedTuple):
    """One swept path and its values: numbers ascend, names are in the order of the grid."""

    path: str
    name: str  # in words
    scale: wording.Scale
    values: tuple  # SI floats or strings
    digits: int  # significant digits that distinguish its values, at least DIGITS
    scattered: bool = False  # shown case by case: few cases share a value; `values` are ascending
    written: bool = False  # its scale is the unit written in the grid
    names: Mapping[float, str] = MappingProxyType({})  # value -> its name in the grid: a fit of ISO 286
    labels: Mapping[float, str] = MappingProxyType({})  # value -> the user's own label

    @property
    def numeric(self) -> bool:
        """Return whether the values are numbers, not names."""
        return not any(isinstance(value, str) for value in self.values)

    def number(self, value: float | str) -> str:
        """Return a value without its unit."""
        if isinstance(value, str):
            return value
        number = self.scale.given_number(value, self.digits) + self._named(value)
        return f"{self.labels[value]} ({number})" if value in self.labels else number

    def text(self, value: float | str) -> str:
        """Return a value with its unit."""
        if isinstance(value, str):
            return value
        text = self.scale.given(value, self.digits) + self._named(value)
        return f"{self.labels[value]} ({text})" if value in self.labels else text

    def short(self, value: float | str) -> str:
        """Return the name of a value, or its number with few digits, for an axis of a figure."""
        if isinstance(value, str):
            return value
        return self.labels.get(value) or self.names.get(value) or wording.short(self.scale.of(value), 3)

    def _named(self, value: float) -> str:
        return f" ({self.names[value]})" if value in self.names else ""

    def listed(self) -> str:
        """Return the values in a sentence: a few are listed with one unit; of many, the count and both ends."""
        if self.scattered or len(self.values) > (FEW_NUMBERS if self.numeric else FEW_NAMES):
            return f"in {self.span()}"
        if self.names or self.labels:
            return ", ".join(map(self.text, self.values))
        return self.scale.joined(", ".join(self.number(value) for value in self.values))

    def span(self) -> str:
        """Return the number of values and both ends."""
        return f"{len(self.values)} values, {self.text(self.values[0])} to {self.text(self.values[-1])}"

    def label(self) -> str:
        """Return name and unit, for an axis of a figure."""
        named = all(value in self.names or value in self.labels for value in self.values)
        return f"{self.name} [{self.scale.unit}]" if self.scale.unit and not named else self.name


def position(axis: Axis, values: pd.Series) -> np.ndarray:
    """Return the index of each value on its axis (0, 1, ...), -1 if it is not on the axis."""
    if not axis.numeric:
        return values.map({value: place for place, value in enumerate(axis.values)}).fillna(-1).to_numpy(np.int32)
    known, given = np.asarray(axis.values, float), values.to_numpy(float)
    order, places = np.argsort(known), np.empty(len(given), np.int32)
    for start in range(0, len(given), AT_ONCE):
        here = given[start : start + AT_ONCE]
        above = np.searchsorted(known[order], here).clip(1, max(len(known) - 1, 1))
        neighbours = order[np.stack([above - 1, above.clip(max=len(known) - 1)])]
        nearest = neighbours[np.abs(known[neighbours] - here).argmin(axis=0), np.arange(len(here))]
        places[start : start + AT_ONCE] = np.where(np.isclose(known[nearest], here, rtol=1e-9, atol=0.0), nearest, -1)
    return places


def axes_of(record: Mapping, tried: dict, units: Mapping[str, str], joints: int) -> tuple[Axis, ...]:
    """Return the axes of a run: swept, parallel, drawn, and `tried` by a search; without values added by `refine`."""
    swept, step = record.get("sweep") or {}, (record.get("zip") or {}) | (record.get("cases") or {}) | tried
    drawn, among = (record.get("sample") or {}).get("drawn", {}), bool((record.get("seek") or {}).get("among"))
    axes = [_axis(path, tuple(values), units.get(path, "1"), joints) for path, values in swept.items()]
    for path, values in (step | drawn).items():
        different = tuple(dict.fromkeys(values))
        if path in drawn or (path in tried and not among) or len(different) > MANY:
            ordered = tuple(sorted(different))
            ends = _axis(path, ordered[:: max(len(ordered) - 1, 1)], units.get(path, "1"), joints)
            axes.append(ends._replace(values=ordered, digits=DIGITS, scattered=True))
        else:
            axes.append(_axis(path, different, units.get(path, "1"), joints))
    axes, fits = _alike(axes, units), grid.recorded_fits(record)
    noted = record.get("written_units", {})
    own = {axis.path: wording.written_scale(noted.get(axis.path), units.get(axis.path, "1")) for axis in axes}
    axes = [axis._replace(scale=scale, written=True) if (scale := own[axis.path]) else axis for axis in axes]
    labels = grid.recorded_labels(record)
    axes = [axis._replace(labels={value: label for label, value in labels.get(axis.path, {}).items()}) for axis in axes]
    return tuple(_with_fits(axis, fits.get(axis.path, ()), drawn=axis.path in drawn) for axis in axes)


def _alike(axes: list[Axis], units: Mapping[str, str]) -> list[Axis]:
    """Return axes with a common unit for axes of the same kind, such as the clearances of several joints."""
    kinds: dict[tuple[str, str], list[float]] = {}
    for axis in axes:
        if axis.numeric:
            kinds.setdefault(_kind(axis, units), []).extend(axis.values)
    scales = {kind: wording.scale(kind[1], values, speed=kind[0] == "speed") for kind, values in kinds.items()}
    return [axis._replace(scale=scales[_kind(axis, units)]) if axis.numeric else axis for axis in axes]


def _kind(axis: Axis, units: Mapping[str, str]) -> tuple[str, str]:
    return axis.path.rsplit(".", 1)[-1], units.get(axis.path, "1")


def _with_fits(axis: Axis, fits: Iterable[Fit], *, drawn: bool) -> Axis:
    """Return an axis that names the fits whose mean clearances are its values, or from which they are `drawn`."""
    names = {known.mean: known.name for known in fits}
    radial = axis.name.replace("clearance", "radial clearance", 1) if names else axis.name
    if drawn and names:
        return axis._replace(name=f"{radial} ({wording.sentence_list(list(names.values()))})")
    return axis._replace(name=radial, names=names)


def _axis(path: str, values: tuple, unit: str, joints: int) -> Axis:
    numbers = [value for value in values if not isinstance(value, str)]
    values = tuple(sorted(values)) if len(numbers) == len(values) else values
    scale = wording.scale(unit, numbers, speed=path.endswith("speed")) if numbers else wording.Scale(1.0, "")
    digits = DIGITS
    while digits < 16 and len({scale.given_number(value, digits) for value in numbers}) < len(set(numbers)):
        digits += 1
    return Axis(path, wording.axis_name(path, joints), scale, values, digits)
