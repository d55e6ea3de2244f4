"""Effect of the other valid laws on the deciding case of a run (`check_laws`), in words."""

import itertools
import math
from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np

from ..language import wording
from .order import Lead
from .verdict import MARGIN

LISTED = 4  # laws that a sentence names


class Row(NamedTuple):
    """The deciding case under one other law."""

    case_id: str
    path: str  # of the law's name
    law: str
    column: str  # of the figure that ranks the cases
    value: float  # SI, nan for null


def rows_of(block: Mapping[str, np.ndarray], base: Mapping[str, str], lead: Lead) -> list[Row]:
    """Return what finished cases that check laws came to; base : path -> law of the grid."""
    values, which = lead.worst(block)
    rows = []
    for place, case_id in enumerate(block["case_id"].tolist()):
        now = {path: block[path][place] for path in base}
        ((path, law),) = ((path, law) for path, law in now.items() if law is not None and law != base[path])
        rows.append(Row(case_id, path, law, lead.candidates[int(which[place])].columns[0], float(values[place])))
    return rows


def sentence(own: Row, rows: list[Row], text: Callable[[str, float], str]) -> str:
    """Return whether the other laws move the verdict on the deciding case; text : column and value -> in words."""
    known = sorted((row for row in rows if not math.isnan(row.value)), key=lambda row: row.value)
    many = "other valid law" if len(rows) == 1 else "other valid laws"
    head = f"case {wording.short_id(own.case_id)} under {len(rows)} {many}"
    if not known or math.isnan(own.value):
        return f"{head}: no figure to compare."
    names = _names(known)
    first, last, written = (_figure(row, text) for row in (known[0], known[-1], own))
    span = f"{first} ({names[0]})" + (f" to {last} ({names[-1]})" if len(known) > 1 else "")
    figure = "margin " if own.column == MARGIN else ""
    return f"{head}: {figure}{span}; {written} under the laws of the grid. {_moved(own, known)}"


def _figure(row: Row, text: Callable[[str, float], str]) -> str:
    return f"{wording.short(100.0 * row.value, 3)} %" if row.column == MARGIN else text(row.column, row.value)


def _names(rows: list[Row]) -> list[str]:
    """Return the laws, with their joints where there are several."""
    joints = [row.path.split(".")[1] for row in rows]
    several = len({*joints}) > 1
    return [f"{row.law}, {joint}" if several else row.law for row, joint in zip(rows, joints, strict=True)]


def _moved(own: Row, known: list[Row]) -> str:
    """Return whether the verdict is another one under some law, without limits how far the figure moves."""
    if own.column != MARGIN:
        factors = [row.value / own.value for row in known if own.value]
        if not factors:
            return "The figure is zero under the laws of the grid."
        low, high = (wording.plain(end, 3) for end in (min(factors), max(factors)))
        return f"They give {' to '.join(dict.fromkeys((low, high)))} times the figure under the laws of the grid."
    moved = [(row.value >= 0.0) != (own.value >= 0.0) for row in known]
    other = list(itertools.compress(_names(known), moved))
    if not other:
        return "No law changes the verdict."
    named = [*other[:LISTED], *([f"{len(other) - LISTED} more"] if len(other) > LISTED else [])]
    does = "exceeds a limit" if own.value >= 0.0 else "meets the limits"
    return f"The verdict changes: the case {does} with {wording.sentence_list(named)}."
