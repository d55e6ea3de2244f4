"""Run time of cases relative to the duration of their motion, for the last lines of a run."""

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from ...contracts.layout import Layout
from ...language import wording

SPEED, REVOLUTIONS = "drive.speed", "simulate.revolutions"  # paths of a grid
REVOLUTIONS_RUN, RUN_TIME = "revolutions_run", "run_time"  # columns


class SlowestCase:
    """Keeps the case with the longest run time relative to the duration of its motion."""

    def __init__(self, record: Mapping[str, Any], layout: Layout):
        """Prepare from run.json; lives and free cranks are left out."""
        self.fixed_values = {path: _recorded_number(record, path) for path in (SPEED, REVOLUTIONS)}
        swept = [path for path in self.fixed_values if path in record.get("sweep", record["units"])]
        names = {column.name for column in layout.columns}
        self.revolutions = REVOLUTIONS_RUN if REVOLUTIONS_RUN in names else REVOLUTIONS
        required = {SPEED, self.revolutions}
        is_known = required <= {
            REVOLUTIONS_RUN,
            *swept,
            *(path for path, value in self.fixed_values.items() if value is not None),
        }
        self.columns = [RUN_TIME, *sorted(required & {REVOLUTIONS_RUN, *swept})] if is_known and not layout.life else []
        self.slowest: dict[str, Any] | None = None

    def add(self, block: Mapping[str, np.ndarray], describe: Callable[[int], dict[str, Any]]) -> None:
        """Add finished cases; describe : index in the block -> description of the case."""
        if not self.columns:
            return
        run_times = block[RUN_TIME].astype(float)
        speed, revolutions = (
            block[name].astype(float) if name in self.columns else np.full(run_times.size, self.fixed_values[name])
            for name in (SPEED, self.revolutions)
        )
        with np.errstate(divide="ignore", invalid="ignore"):
            motion_times = 2.0 * math.pi * revolutions / np.abs(speed)
            factors = motion_times / run_times
        if np.isfinite(factors).any():
            index = int(np.nanargmin(factors))
            if self.slowest is None or factors[index] < self.slowest["factor"]:
                times = {
                    "factor": float(factors[index]),
                    "motion": float(motion_times[index]),
                    "spent": float(run_times[index]),
                }
                self.slowest = describe(index) | times


def slowest_case_lines(slowest: dict[str, Any] | None) -> list[str]:
    """Return the line on the case with the longest run time relative to the duration of its motion."""
    if not slowest:
        return []
    factor = wording.quantity_text(slowest["factor"], "1", 2)
    motion, spent = wording.texts_in_common_unit([slowest["motion"], slowest["spent"]], "s")
    return [
        f"Slowest case relative to its motion: {wording.short_id(slowest['case_id'])}, {motion} of motion in {spent} "
        f"({factor} times real time)"
    ]


def _recorded_number(record: Mapping[str, Any], path: str) -> float | None:
    """Return a number of a grid, or None if there is none at this path."""
    section, key = path.split(".")
    value = (record.get(section) or {}).get(key)
    return float(value) if isinstance(value, (int, float)) else None
