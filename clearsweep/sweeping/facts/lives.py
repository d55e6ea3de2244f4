"""The shortest and the longest life of a run, for its last lines."""

import operator
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from ...answers.words import FIELD_BY_COLUMN, hours_text, interval_text, life_criterion_text, read_lifetime, spread_text
from ...contracts.layout import Layout

COMPARISONS = {"shortest": operator.lt, "longest": operator.gt}


class LifeExtremes:
    """Keeps the shortest and longest life of finished cases."""

    def __init__(self, layout: Layout, section: Mapping[str, Any]):
        """Prepare for the layout of a run and the section `life` of its grid; without a life nothing is kept."""
        column_names = {column.name for column in layout.columns}
        names = {name: f"{layout.life}_{name}" for name in FIELD_BY_COLUMN} if layout.life else {}
        self.columns_by_name, self.joint = (
            {name: column for name, column in names.items() if column in column_names},
            layout.life,
        )
        self.columns = [*self.columns_by_name.values()]
        self.until = life_criterion_text(section)
        self.unreached = 0
        self.extremes: dict[str, dict[str, Any]] = {}  # key of COMPARISONS -> the case

    def add(self, block: Mapping[str, np.ndarray], describe: Callable[[int], dict[str, Any]]) -> None:
        """Add finished cases; describe : index in the block -> description of the case."""
        if not self.columns:
            return
        hours = block[self.columns[0]].astype(float)
        self.unreached += int(np.isnan(hours).sum())
        if np.isnan(hours).all():
            return
        for index in dict.fromkeys((int(np.nanargmin(hours)), int(np.nanargmax(hours)))):
            life = read_lifetime(
                {name: float(block[column].astype(float)[index]) for name, column in self.columns_by_name.items()}
            )
            for key, precedes in COMPARISONS.items():
                if key not in self.extremes or precedes(life.hours, self.extremes[key]["hours"]):
                    self.extremes[key] = describe(index) | {
                        "hours": life.hours,
                        "text": hours_text(life),
                        "remarks": [text for text in (interval_text(life), spread_text(life)) if text],
                    }

    def facts(self) -> dict[str, Any] | None:
        """Return both lives and the number of cases that did not reach their limit, for JSON, or None without lives."""
        return (
            {"joint": self.joint, "until": self.until, **self.extremes, "unreached": self.unreached}
            if self.columns
            else None
        )
