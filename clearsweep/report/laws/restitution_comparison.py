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
from ..data.dotted import dig
from ..data.study import Joint, Study, joint_of, resolved
from ..draw import comparison
from ..statistics.matching import axis_key
from .elastic_comparison import UNKNOWN

MOST = 5  # largest number of displayed values of the restitution, evenly spaced
ALIKE = 5e-4  # smaller differences of restitution count as equal


class Returned(NamedTuple):
    """Effective restitution of a law in a free impact."""

    law: str
    wanted: float  # NaN for a law without this parameter
    given: float  # NaN if it depends on mass and speed
    measured: float  # median of the cases; NaN without measurement


def of_axis(study: Study, axis: Axis, joint: Joint) -> Part:
    """Return sentence, picture and table of the swept laws of a joint."""
    points = _points(study, axis, joint)
    firsts = points.drop_duplicates()
    firsts = firsts[firsts["wanted"].isna() | firsts["wanted"].isin(_shown(points["wanted"]))]
    try:
        sections = [joint_of(case, joint) for case in resolved(study, firsts.index)]
    except InputError:
        return Part([UNKNOWN], [], [])
    rows = []
    for (law, value), section in zip(firsts.itertuples(index=False), sections, strict=True):
        given = simulation.restitution(section)
        rows.append(
            Returned(
                law,
                section.contact.values.get("restitution", np.nan),
                np.nan if given is None else given,
                _measured(study, points, joint, law, value),
            )
        )
    rows.sort(key=lambda row: (np.isnan(row.wanted), row.wanted, axis.values.index(row.law)))
    known = [row for row in rows if not np.isnan(row.given)]
    return Part(_sentences(rows), [_picture(axis, known)] if known else [], [_table(study, axis, joint, rows)])


def _points(study: Study, axis: Axis, joint: Joint) -> pd.DataFrame:
    """Return law and specified restitution of each case."""
    path = f"joints.{joint.title}.contact.restitution"
    wanted = study.cases[path] if path in study.cases else dig(study.base, path)
    points = pd.DataFrame({"law": study.cases[axis.path], "wanted": wanted}, index=study.cases.index)
    return points.astype({"wanted": float})


def _shown(wanted: pd.Series) -> np.ndarray:
    """Return the displayed values of the restitution, at most MOST."""
    known = np.sort(wanted.dropna().unique())
    if not len(known):
        return known
    return known[np.unique(np.linspace(0, len(known) - 1, MOST).round().astype(int))]


def _measured(study: Study, points: pd.DataFrame, joint: Joint, law: str, wanted: float) -> float:
    """Return the median of the measured restitution of the cases of a law, NaN without measurement."""
    if not study.has(joint.column("restitution")):
        return np.nan
    alike = points["wanted"].isna() if np.isnan(wanted) else points["wanted"] == wanted
    return float(study.cases[joint.column("restitution")][(points["law"] == law) & alike].median())


def _table(study: Study, axis: Axis, joint: Joint, rows: list[Returned]) -> Table:
    columns = [Column(axis.name), Column("asked for"), Column("given back"), Column("difference")]
    cells: list[tuple] = [
        (row.law, row.wanted, row.given, Quantity(row.given - row.wanted, _signed(row.given - row.wanted)))
        for row in rows
    ]
    if study.has(joint.column("restitution")):
        columns.append(Column("measured here"))
        cells = [(*cell, row.measured) for cell, row in zip(cells, rows, strict=True)]
    note = (
        f"Computed for a free impact in closed form; the elastic law has no influence. {wording.DASH}: the law has no "
        "restitution, or mass and speed determine the result (kelvin-voigt and others)."
    )
    key = f"{axis_key(axis)}_restitution"
    return Table(key, "Specified and computed restitution", note, tuple(columns), cells)


def _sentences(rows: list[Returned]) -> list[str]:
    """Return sentences on the largest difference between laws with the same specified restitution."""
    spans = []
    for wanted in {row.wanted for row in rows if not np.isnan(row.wanted)}:
        known = [row for row in rows if row.wanted == wanted and not np.isnan(row.given)]
        if known:
            ordered = sorted(known, key=lambda row: (row.given, row.law))
            spans.append((ordered[-1].given - ordered[0].given, ordered[0], ordered[-1]))
    if not spans:
        return []
    widest, least, most = max(spans, key=lambda span: (span[0], span[1].wanted))
    if widest < ALIKE:
        return ["In a free impact all these laws give the same restitution, or the specified one."]
    return [
        f"With a specified restitution of {wording.short(least.wanted, 3)}, a free impact has a restitution of "
        f"{wording.plain(least.given)} ({least.law}) to {wording.plain(most.given)} ({most.law})."
    ]


def _picture(axis: Axis, rows: list[Returned]) -> Picture:
    points = [(row.law, row.wanted, row.given) for row in rows]
    alt = "; ".join(f"{law}, specified {wanted:.3g}: {given:.3g}" for law, wanted, given in points)
    return Picture(
        "Restitution of a free impact",
        "Computed for a free impact, and compared with the specified restitution.",
        f"Restitution by {axis.name}. {alt}",
        lambda ax: comparison.returned(ax, points),
        size=(4.2, 1.15 + 0.22 * len({row.law for row in rows})),
    )


def _signed(difference: float) -> str:
    return wording.DASH if np.isnan(difference) else f"{difference:+.4f}".replace("-", wording.MINUS)
