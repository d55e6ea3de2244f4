"""Rolling bearings by name: deep groove ball bearings and needle roller bearings without an inner ring.

Balls: boundary dimensions and ratings are those of a catalogue.  Number and diameter of the balls are in no catalogue;
they are those, in steps of 1/64 in, whose ratings by ISO 281 and ISO 76 are the catalogue's.
"""

import csv
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

from ...language.errors import InputError, quoted
from .entries import Entry, Value
from .fits import GROUPS

GROOVES = (0.52, 0.53)  # radii over the ball's diameter, up to which ISO 281 has its ratings
_COLUMNS = {  # column of the file -> key of the joint, unit, factor from the file's unit to SI
    "elements": ("elements", "1", 1.0),
    "element_diameter": ("element_diameter", "m", 1e-3),
    "pitch_diameter": ("pitch_diameter", "m", 1e-3),
    "bore": ("bore", "m", 1e-3),
    "outside_diameter": ("outside_diameter", "m", 1e-3),
    "width": ("width", "m", 1e-3),
    "length": ("length", "m", 1e-3),
    "dynamic": ("capacity.dynamic", "N", 1e3),
    "static": ("capacity.static", "N", 1e3),
}
WIDTH = "width"  # listed, but of no effect in the plane of the rings
_BALL_SOURCE = (
    "KYK, general catalogue, deep groove ball bearings (dimensions of ISO 15, ratings); balls by the ratings, ISO 281 "
    "and ISO 76; pitch diameter: mean of bore and outside diameter; grooves: ISO 281"
)
_BALL_CHECKED = "dimensions and ratings with the catalogue; the balls, by the ratings that follow from them, within 4 %"
_NEEDLE_SOURCE = (
    "UBC, catalogue of needle roller bearings (dimensions, ratings); diameter of the needles from memory, their number "
    "and effective length by the static rating, ISO 76; the bore is the raceway of the shaft"
)


def _read_bearings() -> dict[str, Entry]:
    text = Path(__file__).with_name("bearings.csv").read_text(encoding="utf-8")
    return {row["name"]: _entry(row) for row in csv.DictReader(text.splitlines(), delimiter="|")}


def _entry(row: Mapping[str, str]) -> Entry:
    values = {
        key: _exactly(unit, float(row[name]) * factor) for name, (key, unit, factor) in _COLUMNS.items() if row[name]
    }
    if has_inner_ring(row["name"]):
        values |= {f"groove.{k}": _exactly("1", radius) for k, radius in enumerate(GROOVES)}
        return Entry(row["name"], "deep groove ball bearing", values, _BALL_SOURCE, _BALL_CHECKED)
    form = "drawn cup needle roller bearing" if row["name"].startswith("HK") else "needle roller bearing"
    return Entry(row["name"], f"{form} without inner ring", values, _NEEDLE_SOURCE, "")


def _exactly(unit: str, number: float) -> Value:
    value = float(f"{number:.12g}")
    return Value(unit, value, value, value)


def has_inner_ring(name: str) -> bool:
    """Return whether a bearing has an inner ring; shaft and housing determine the clearance of the others."""
    return name[:1].isdigit()


BEARINGS = _read_bearings()


class BearingName(NamedTuple):
    """The name of a bearing in its parts."""

    designation: str  # '6204'
    group: str  # of its clearance, 'C3'; '' if it is not written


def parse_bearing_name(name: str) -> BearingName:
    """Return the parts of a name such as '6204 C3'."""
    words = name.split()
    if len(words) > 1 and (words[-1].upper() in GROUPS or " ".join(words[:-1]) in BEARINGS):
        return BearingName(" ".join(words[:-1]), words[-1].upper())
    return BearingName(name, "")


def bearing_names() -> tuple[str, ...]:
    """Return all names, those of bearings with an inner ring also with a group."""
    groups = {name: ("", *GROUPS) if has_inner_ring(name) else ("",) for name in BEARINGS}
    return tuple(f"{name} {group}".strip() for name in BEARINGS for group in groups[name])


def check_group(designation: str, group: str) -> None:
    """Raise InputError if a bearing without an inner ring has a group."""
    if group and not has_inner_ring(designation):
        raise InputError(
            f"found {quoted(f'{designation} {group}')}, but {designation} has no group: shaft and housing determine "
            "its clearance; write the name alone and `clearance`"
        )
