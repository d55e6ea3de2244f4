"""One side of axes: its scale, its limits, its ticks and their labels."""

import itertools
import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from matplotlib.ticker import MaxNLocator

from ...language import wording

MARGIN = 0.05  # of the data's extent, left free at its ends
_STEPS = [1, 2, 2.5, 5, 10]
_MIN_TICK_DISTANCE = {"x": 30.0, "y": 17.0}  # least distance of ticks, points
MAX_DECADE = 300.0  # powers of ten of a logarithmic axis stay within those of floats
_MAX_TICKS = 9  # largest number of ticks
_MAX_DECADES = 7  # decades up to which each has a tick
_SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


class UnsupportedError(Exception):
    """A drawing that these axes do not support."""


class Side:
    """The abscissa or the ordinate of axes."""

    def __init__(self, axis_name: str):
        """Take the letter of the side, 'x' or 'y'."""
        self.axis_name, self.label, self.is_log = axis_name, "", False
        self.fixed_limits: list[float | None] = [None, None]  # the limits set by a drawing
        self.data: list[np.ndarray] = []
        self.sticky_ends: set[float] = set()  # ends without margin
        self.locator: Any = None
        self.formatter: Callable[[float, Any], str] | None = None
        self.fixed_ticks: tuple[list[float], list[str] | None] | None = None
        self.label_style: dict[str, Any] = {}  # of the tick labels
        self.tick_length, self.font_size, self.margin = 3.5, 8.0, MARGIN

    def extend_data(self, values: Any) -> None:
        """Extend the data by values; non-finite ones are ignored."""
        values = np.asarray(values, float).ravel()
        self.data.append(values[np.isfinite(values)])

    def get_scale(self) -> str:
        """Return 'log' or 'linear'."""
        return "log" if self.is_log else "linear"

    def limits(self) -> tuple[float, float]:
        """Return both ends: as set, or those of the data with a margin."""
        values = np.concatenate([np.empty(0), *self.data])
        values = values[values > 0.0] if self.is_log else values
        low, high = (float(values.min()), float(values.max())) if len(values) else (1.0 if self.is_log else 0.0, 1.0)
        a, b = (math.log10(low), math.log10(high)) if self.is_log else (low, high)
        margin = self.margin * (b - a) if b > a else 0.05 * (abs(a) or 1.0)
        limits = [
            end if data_end in self.sticky_ends else end + sign * margin
            for end, data_end, sign in ((a, low, -1.0), (b, high, 1.0))
        ]
        limits = [10.0 ** min(max(end, -MAX_DECADE), MAX_DECADE) for end in limits] if self.is_log else limits
        low, high = (
            end if set_limit is None else set_limit for end, set_limit in zip(limits, self.fixed_limits, strict=True)
        )
        return low, high

    def fraction(self, values: Any) -> np.ndarray:
        """Return values relative to both ends, 0 to 1."""
        low, high = self.limits()
        values = np.asarray(values, float)
        if self.is_log:
            with np.errstate(all="ignore"):
                values = np.log10(np.where(values > 0.0, values, np.nan))
            low, high = math.log10(low), math.log10(high)
        return (values - low) / ((high - low) or 1.0)

    def set_major_locator(self, locator: Any) -> None:
        """Take the locator of ticks."""
        self.locator, self.fixed_ticks = locator, None

    def set_minor_locator(self, locator: Any) -> None:
        """Take the locator of minor ticks; it is ignored."""

    def set_major_formatter(self, formatter: Callable[[float, Any], str]) -> None:
        """Take the formatter of tick labels."""
        self.formatter = formatter

    def set_ticks(self, ticks: Sequence[float], labels: Sequence[str] | None = None, **style: Any) -> None:
        """Take ticks and their labels."""
        if not {*style} <= {"rotation", "ha", "rotation_mode", "fontsize"}:
            raise UnsupportedError(f"style of ticks: {style}")
        self.fixed_ticks = (
            [float(position) for position in ticks],
            None if labels is None else [str(label) for label in labels],
        )
        self.label_style, self.font_size = style, style.get("fontsize", self.font_size)

    def ticks(self, length: float) -> list[tuple[float, str]]:
        """Return the ticks within both ends and their labels; length : of the side, in points."""
        low, high = sorted(self.limits())
        if self.fixed_ticks is not None:
            positions, labels = self.fixed_ticks
        else:
            labels = None
            if self.locator is not None:
                positions = [float(value) for value in self.locator.tick_values(low, high)]
            elif self.is_log:
                positions = _decades(low, high)
            else:
                max_ticks = max(2, min(_MAX_TICKS, int(length / _MIN_TICK_DISTANCE[self.axis_name])))
                positions = [float(value) for value in MaxNLocator(max_ticks, steps=_STEPS).tick_values(low, high)]
        names = labels if labels is not None else self._tick_labels(positions)
        tolerance = 1e-9 * (high - low)
        visible_ticks = [
            (position, name)
            for position, name in zip(positions, names, strict=True)
            if low - tolerance <= position <= high + tolerance
        ]
        return visible_ticks

    def _tick_labels(self, positions: Sequence[float]) -> list[str]:
        if self.formatter is not None:
            return [self.formatter(position, None) for position in positions]
        if self.is_log:
            return [f"10{f'{round(math.log10(position))}'.translate(_SUPERSCRIPTS)}" for position in positions]
        step = min((b - a for a, b in itertools.pairwise(positions)), default=1.0) or 1.0
        largest = max(map(abs, positions), default=0.0)
        if largest >= 1e5 or 0.0 < step < 1e-4:
            return [
                wording.short_number_text(position if abs(position) > 1e-9 * largest else 0.0, 4)
                for position in positions
            ]
        digits = next((d for d in range(8) if all(abs(round(p, d) - p) < 1e-6 * step for p in positions)), 8)
        return [f"{position + 0.0:.{digits}f}".replace("-", wording.MINUS) for position in positions]


def _decades(low: float, high: float) -> list[float]:
    """Return the powers of ten between two ends; if they are many, every second or third."""
    first, last = math.ceil(math.log10(low) - 1e-9), math.floor(math.log10(high) + 1e-9)
    stride = max(1, math.ceil((last - first + 1) / _MAX_DECADES))
    return [10.0**power for power in range(first, last + 1, stride)]
