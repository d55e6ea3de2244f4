"""Specified and effective restitution of laws."""

from typing import NamedTuple

import numpy as np
import pandas as pd

from ... import simulation
from ...language import wording
from ...language.errors import InputError
from ..blocks.picture import Picture
from ..blocks.section import Part
from ..blocks.table import Column, Quantity, Table
from ..data.axis import Axis
from ..data.dotted_paths import value_at
from ..data.study import Joint, Study, joint_of, resolve_cases
from ..draw import comparison
from ..statistics.matching import axis_key
from .elastic_comparison import UNKNOWN_LAW_TEXT

MAX_VALUES = 5  # largest number of displayed values of the restitution, evenly spaced
MIN_DIFFERENCE = 5e-4  # smaller differences of restitution count as equal


class EffectiveRestitution(NamedTuple):
    """Effective restitution of a law in a free impact."""

    law: str
    specified: float  # NaN for a law without this parameter
    effective: float  # NaN if it depends on mass and speed
    measured: float  # median of the cases; NaN without measurement

    @property
    def difference(self) -> float:
        """Return the effective minus the specified restitution."""
        return self.effective - self.specified


def compare_restitutions(study: Study, axis: Axis, joint: Joint) -> Part:
    """Return sentence, picture and table of the swept laws of a joint."""
    points = _restitution_points(study, axis, joint)
    representatives = points.drop_duplicates()
    displayed = _displayed_values(points["specified"])
    representatives = representatives[
        representatives["specified"].isna() | representatives["specified"].isin(displayed)
    ]
    try:
        sections = [joint_of(case, joint) for case in resolve_cases(study, representatives.index)]
    except InputError:
        return Part([UNKNOWN_LAW_TEXT], [], [])
    rows = []
    for (law, value), section in zip(representatives.itertuples(index=False), sections, strict=True):
        effective = simulation.restitution(section)
        rows.append(
            EffectiveRestitution(
                law,
                section.contact.values.get("restitution", np.nan),
                np.nan if effective is None else effective,
                _measured_restitution(study, points, joint, law, value),
            )
        )
    rows.sort(key=lambda row: (np.isnan(row.specified), row.specified, axis.values.index(row.law)))
    valued_rows = [row for row in rows if not np.isnan(row.effective)]
    return Part(
        _sentences(rows), [_picture(axis, valued_rows)] if valued_rows else [], [_table(study, axis, joint, rows)]
    )


def _restitution_points(study: Study, axis: Axis, joint: Joint) -> pd.DataFrame:
    """Return law and specified restitution of each case."""
    path = f"joints.{joint.title}.contact.restitution"
    specified = study.cases[path] if path in study.cases else value_at(study.base, path)
    points = pd.DataFrame({"law": study.cases[axis.path], "specified": specified}, index=study.cases.index)
    return points.astype({"specified": float})


def _displayed_values(specified: pd.Series) -> np.ndarray:
    """Return the displayed values of the restitution, at most MAX_VALUES."""
    known = np.sort(specified.dropna().unique())
    if not len(known):
        return known
    return known[np.unique(np.linspace(0, len(known) - 1, MAX_VALUES).round().astype(int))]


def _measured_restitution(study: Study, points: pd.DataFrame, joint: Joint, law: str, specified: float) -> float:
    """Return the median of the measured restitution of the cases of a law, or NaN if none was measured."""
    if not study.has(joint.column("restitution")):
        return np.nan
    has_value = points["specified"].isna() if np.isnan(specified) else points["specified"] == specified
    return float(study.cases[joint.column("restitution")][(points["law"] == law) & has_value].median())


def _table(study: Study, axis: Axis, joint: Joint, rows: list[EffectiveRestitution]) -> Table:
    columns = [Column(axis.name), Column("specified"), Column("computed"), Column("difference")]
    cells: list[tuple] = [
        (row.law, row.specified, row.effective, Quantity(row.difference, _signed_text(row.difference))) for row in rows
    ]
    if study.has(joint.column("restitution")):
        columns.append(Column("measured here"))
        cells = [(*cell, row.measured) for cell, row in zip(cells, rows, strict=True)]
    note = (
        f"The values follow in closed form for a free impact; the elastic law has no effect. A dash ({wording.DASH}) "
        "means that the law has no restitution, or that it depends on mass and speed (kelvin-voigt and others)."
    )
    key = f"{axis_key(axis)}_restitution"
    return Table(key, "Specified and computed restitution", note, tuple(columns), cells)


def _sentences(rows: list[EffectiveRestitution]) -> list[str]:
    """Return sentences on the largest difference between laws with the same specified restitution."""
    ranges = []
    for specified in {row.specified for row in rows if not np.isnan(row.specified)}:
        known = [row for row in rows if row.specified == specified and not np.isnan(row.effective)]
        if known:
            ordered = sorted(known, key=lambda row: (row.effective, row.law))
            ranges.append((ordered[-1].effective - ordered[0].effective, ordered[0], ordered[-1]))
    if not ranges:
        return []
    widest, lowest, highest = max(ranges, key=lambda entry: (entry[0], entry[1].specified))
    if widest < MIN_DIFFERENCE:
        return [
            "In a free impact these laws do not differ: each gives the specified restitution, or all give the same "
            "value."
        ]
    return [
        f"With a specified restitution of {wording.short_number_text(lowest.specified, 3)}, a free impact has a "
        "restitution of "
        f"{wording.number_text(lowest.effective)} ({lowest.law}) to {wording.number_text(highest.effective)} "
        f"({highest.law})."
    ]


def _picture(axis: Axis, rows: list[EffectiveRestitution]) -> Picture:
    points = [(row.law, row.specified, row.effective) for row in rows]
    alt = "; ".join(f"{law}, specified {specified:.3g}: {effective:.3g}" for law, specified, effective in points)
    return Picture(
        "Restitution of a free impact",
        "Computed for a free impact, and compared with the specified restitution.",
        f"Restitution by {axis.name}. {alt}",
        lambda ax: comparison.draw_restitutions(ax, points),
        size=(4.2, 1.15 + 0.22 * len({row.law for row in rows})),
    )


def _signed_text(difference: float) -> str:
    return wording.DASH if np.isnan(difference) else f"{difference:+.4f}".replace("-", wording.MINUS)
