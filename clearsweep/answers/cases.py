"""The finished cases of a run and the display units of their columns."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from ..contracts.layout import Layout
from ..language import wording
from .case_ranking import MAX_SPEED, SPEED_AFTER_START

UNIT_QUANTILE = 0.95  # the display unit suits this quantile of the values, so that a single peak does not decide it
DISPLAY_RANGE = (1e-3, 1e5)  # numbers outside this range have a unit of their own


class FinishedCases(NamedTuple):
    """The finished cases of a run, as numbers."""

    record: Mapping[str, Any]  # run.json
    layout: Layout
    varied_paths: tuple[str, ...]
    values_of: Callable[[str], np.ndarray]  # values (n,) of a column or a path; SI, NaN for null

    def __len__(self) -> int:
        return len(self.values_of("case_id"))

    def has_values(self, column_name: str) -> bool:
        """Return whether any case has a figure."""
        if not any(known.name == column_name for known in self.layout.columns):
            return False
        return bool(np.isfinite(self.values_of(column_name).astype(float)).any())

    def number(self, path: str) -> np.ndarray | None:
        """Return a number of the grid in each case (n,), whether it varies or not; None if it is not a number."""
        if path in self.varied_paths:
            return self.values_of(path).astype(float)
        value: Any = self.record
        for key in path.split("."):
            value = value.get(key) if isinstance(value, Mapping) else None
        return np.full(len(self), value) if isinstance(value, float) else None


def column_scale(column_name: str, unit: str, column_values: np.ndarray) -> wording.Scale:
    """Return the display unit of a column: it suits the 0.95 quantile of the values, for film thicknesses the median.

    column_values : (n,) SI, the values of the column
    """
    if column_name in (MAX_SPEED, SPEED_AFTER_START):
        return wording.scale(unit, 0.0, speed=True)
    magnitudes = np.abs(column_values[np.isfinite(column_values)])
    magnitudes = magnitudes[magnitudes > 0.0]
    quantile = 0.5 if column_name.endswith("film_thickness_min") else UNIT_QUANTILE
    typical_magnitude = np.quantile(magnitudes, quantile) if magnitudes.size else 0.0
    return wording.scale(unit, float(typical_magnitude))


def column_texts(column_name: str, unit: str, column_values: np.ndarray, values: Sequence[float]) -> list[str]:
    """Return values of a column as number and unit: in the unit of the column, or in their own if it does not suit."""
    if unit == "K" and column_name.endswith("temperature"):
        return [wording.temperature_scale().text(value) for value in values]
    scale = column_scale(column_name, unit, np.asarray(column_values, float))
    displayed_magnitudes = [abs(value) / scale.factor for value in values if value and np.isfinite(value)]
    if displayed_magnitudes and not (
        DISPLAY_RANGE[0] <= min(displayed_magnitudes) and max(displayed_magnitudes) < DISPLAY_RANGE[1]
    ):
        return wording.texts_in_common_unit(values, unit)
    return [scale.text(value) for value in values]
