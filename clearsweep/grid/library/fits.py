"""Clearance by name: fits of holes and shafts, groups of rolling bearings, and what mounting leaves of a group."""

import re
from bisect import bisect_left
from fractions import Fraction
from pathlib import Path
from typing import NamedTuple

from ...language.errors import InputError, did_you_mean, quoted

# ----------------------------------------------------------------------------------------------------------------------
# Clearance fits of holes and shafts: ISO 286-1:2010, standard tolerances and fundamental deviations of 1 to 500 mm.
#
# The tables in iso_286.txt are copied from the standard.  Its formulas (annex B of the 1988 edition) give them before
# rounding, which follows no single rule; the tables are checked against them.


SMALLEST_DIAMETER, LARGEST_DIAMETER = 1, 500  # mm, both included
_DIAMETER_STEPS = (3, 6, 10, 18, 30, 50, 80, 120, 180, 250, 315, 400, 500)  # mm, upper end of each range
_FINE_DIAMETER_STEPS = (
    3, 6, 10, 14, 18, 24, 30, 40, 50, 65, 80, 100, 120, 140, 160, 180, 200, 225, 250, 280, 315, 355, 400, 450, 500,
)  # fmt: skip
#: Grades of holes whose upper limit follows from the shaft of their letter: -ei + IT(grade) - IT(grade - 1), without
#: the difference up to 3 mm (4.3.2.5; the standard tabulates the result).
_TIGHT_HOLE_GRADES = dict.fromkeys("kmn", ("5", "6", "7", "8")) | {"p": ("5", "6", "7")}
_CLASS_PATTERN = re.compile(r"([A-Za-z]{1,2})(\d{1,2})")


def tables_of(name: str) -> list[dict[str, list[str]]]:
    """Return the tables in a file next to this one, between blank lines: first word of a row -> the others."""
    text = re.sub("(?m)^#.*\n", "", Path(__file__).with_name(name).read_text(encoding="utf-8"))
    return [{row.split()[0]: row.split()[1:] for row in table.splitlines()} for table in text.strip().split("\n\n")]


_TOLERANCE_BY_GRADE, _UPPER_BY_LETTER, _LOWER_BY_LETTER = (
    {heading: tuple(map(Fraction, numbers)) for heading, numbers in table.items()} for table in tables_of("iso_286.txt")
)
KNOWN_CLASSES_TEXT = (
    f"holes {', '.join(letter.upper() for letter in _UPPER_BY_LETTER)}, JS, and K, M, N (grades 5 to 8), P (5 to 7), "
    f"shafts {', '.join((*_UPPER_BY_LETTER, 'js', *_LOWER_BY_LETTER))}"
)


class Fit(NamedTuple):
    """A fit at a nominal diameter with its radial clearances, or a group of a rolling bearing.

    The clearances of a group are its radial internal ones, from one extreme position to the other.
    """

    name: str  # 'H7/f7', or the group 'C3'
    diameter: float  # m, nominal, or the bore
    low: float  # m, least radial clearance
    mean: float  # m
    high: float  # m

    @property
    def is_group(self) -> bool:
        """Return whether this is a group of a rolling bearing."""
        return "/" not in self.name


def find_fit(name: str, diameter: Fraction) -> Fit:
    """Return the fit called `name`, 'H7/f7', at a nominal `diameter` (mm).

    Raises InputError if there is no such fit, or if it has interference.
    """
    hole_class, slash, shaft_class = re.sub(r"\s", "", name).partition("/")
    if not slash or not hole_class[:1].isupper() or not shaft_class[:1].islower():
        raise InputError(f"found {quoted(name)}; expected a fit of ISO 286, hole before shaft, such as H7/f7")
    if not SMALLEST_DIAMETER <= diameter <= LARGEST_DIAMETER:
        in_metres = diameter > 20.0 * LARGEST_DIAMETER  # the size in mm, read as m
        remedy = "a bearing_radius without a unit is in m" if in_metres else "write the radial clearance"
        raise InputError(
            f"found {name} at a nominal diameter of {float(diameter):g} mm, twice the bearing_radius; fits are known "
            f"from {SMALLEST_DIAMETER} to {LARGEST_DIAMETER} mm: {remedy}"
        )
    hole_limits, shaft_limits = limit_deviations(hole_class, diameter), limit_deviations(shaft_class, diameter)
    low, high = hole_limits[0] - shaft_limits[1], hole_limits[1] - shaft_limits[0]  # diametral, um
    if low <= 0:
        kind_text = (
            "an interference fit"
            if high <= 0
            else "a transition fit"
            if low < 0
            else ("a fit that may have no clearance")
        )
        raise InputError(
            f"found {name}, {kind_text} at a nominal diameter of {float(diameter):g} mm: its diametral clearance is "
            f"{float(low):g} to {float(high):g} um, radial {float(low / 2):g} to {float(high / 2):g} um; choose a "
            "fit with a clearance above 0, such as H7/g6 or H7/f7"
        )
    radial = [float(clearance / 2 / 10**6) for clearance in (low, (low + high) / 2, high)]
    return Fit(f"{hole_class}/{shaft_class}", float(diameter / 1000), *radial)


def limit_deviations(tolerance_class: str, diameter: Fraction) -> tuple[Fraction, Fraction]:
    """Return the lower and the upper limit deviation (um) of a tolerance class, 'H7' of a hole or 'f7' of a shaft.

    `diameter` in mm, from SMALLEST_DIAMETER to LARGEST_DIAMETER.  Raises InputError for a class that is missing from
    the tables.
    """
    match = _CLASS_PATTERN.fullmatch(tolerance_class)
    letter, grade = match.groups() if match else ("", "")
    lower_letter, is_hole = letter.lower(), letter.isupper()
    is_tight_hole = is_hole and grade in _TIGHT_HOLE_GRADES.get(lower_letter, ())
    is_known = (
        lower_letter in _UPPER_BY_LETTER
        or lower_letter == "js"
        or (lower_letter in _LOWER_BY_LETTER and (not is_hole or is_tight_hole))
    )
    if not is_known or letter not in (lower_letter, lower_letter.upper()) or grade not in _TOLERANCE_BY_GRADE:
        is_interference_letter = is_hole and not is_known and lower_letter >= "j"
        reason = "other holes from J to ZC are made for transition and interference; " if is_interference_letter else ""
        raise InputError(
            f"{quoted(tolerance_class)} is not a known tolerance class; {reason}known are {KNOWN_CLASSES_TEXT}, in the "
            f"grades 1 to {len(_TOLERANCE_BY_GRADE)}"
        )
    tolerance = _entry_for_diameter(_TOLERANCE_BY_GRADE[grade], diameter)
    if lower_letter == "js":
        return -tolerance / 2, tolerance / 2
    if lower_letter in _UPPER_BY_LETTER:
        offset = _entry_for_diameter(_UPPER_BY_LETTER[lower_letter], diameter)
        return (offset, offset + tolerance) if is_hole else (-offset - tolerance, -offset)
    offset = (
        _entry_for_diameter(_LOWER_BY_LETTER[lower_letter], diameter)
        if lower_letter != "k" or 4 <= int(grade) <= 7
        else Fraction(0)
    )
    if is_hole:
        finer = _entry_for_diameter(_TOLERANCE_BY_GRADE[str(int(grade) - 1)], diameter)
        upper = tolerance - finer - offset if diameter > _DIAMETER_STEPS[0] else -offset
        return upper - tolerance, upper
    return offset, offset + tolerance


def _entry_for_diameter(row: tuple[Fraction, ...], diameter: Fraction) -> Fraction:
    """Return the entry of a row for a nominal diameter (mm)."""
    return row[
        bisect_left(_FINE_DIAMETER_STEPS if len(row) == len(_FINE_DIAMETER_STEPS) else _DIAMETER_STEPS, diameter)
    ]


# ----------------------------------------------------------------------------------------------------------------------
# Radial internal clearance of rolling bearings by group: ISO 5753-1:2009, bores of 2.5 to 500 mm, cylindrical.
#
# The tables of deep groove ball bearings end at 100 mm here.  Needle roller bearings with an inner ring have the
# clearances of cylindrical roller bearings, but no group C5 up to 10 mm.


GROUPS = ("C2", "CN", "C3", "C4", "C5")
NORMAL_GROUP = "CN"  # of a bearing whose name has no group
#: Table -> upper end of a range of bores (mm), and the limits (um) of its groups.
_ROWS: dict[str, list[tuple[Fraction, dict[str, tuple[int, int]]]]] = {
    kind: [
        (
            Fraction(bore),
            {
                group: (int(low), int(high))
                for group, low, high in zip(GROUPS, limits[::2], limits[1::2], strict=True)
                if low != "-"
            },
        )
        for bore, limits in table.items()
    ]
    for kind, table in zip(("ball", "roller"), tables_of("iso_5753.txt"), strict=True)
}
_NAMES = {"ball": "deep groove ball bearings", "roller": "cylindrical and needle roller bearings"}


def find_group(name: str, bore: Fraction, kind: str) -> Fit:
    """Return the radial internal clearances (m) of the group called `name`, 'C3', at a `bore` (mm).

    kind : of the elements, 'ball', 'roller' or 'needle'.
    Raises InputError if there is no such group, or none at this bore.
    """
    group = name.strip().upper()
    if group not in GROUPS:
        hint = did_you_mean(group, GROUPS)
        raise InputError(f"unknown group {quoted(name)}{hint} (known: {', '.join(GROUPS)}, by ISO 5753-1)")
    table = "ball" if kind == "ball" else "roller"
    rows = _ROWS[table]
    ends = [end for end, _ in rows]
    if not 0 < bore <= ends[-1]:
        in_metres = " (a bore without a unit is in m)" if bore > ends[-1] else ""
        raise InputError(
            f"found the group {group} at a bore of {float(bore):g} mm; groups of {_NAMES[table]} are known up to "
            f"{float(ends[-1]):g} mm{in_metres}; write the clearance itself"
        )
    groups = rows[bisect_left(ends, bore)][1]
    if group not in groups:
        known = f"known there: {', '.join(groups)}" if groups else "no group is known there"
        raise InputError(
            f"found the group {group}, which ISO 5753-1 does not have for {_NAMES[table]} with a bore of "
            f"{float(bore):g} mm; {known}; or write the clearance itself"
        )
    low, high = groups[group]
    return Fit(group, float(bore / 1000), low / 1e6, (low + high) / 2e6, high / 1e6)


# ----------------------------------------------------------------------------------------------------------------------
# Clearance of a mounted rolling bearing: what interference fits and a warmer inner ring leave of its group.
#
# Shaft, rings and housing are of steel, the shaft is solid and the housing thick.  By Lame's equations a raceway then
# moves by the interference times d / F at the inner and times E / D at the outer ring: d, D the diameters of its seat,
# F and E those of the raceways (NTN, Ball and Roller Bearings, tables 8.3 and 8.4).  A loose fit changes nothing.
# Ground seats are smoothed by 1 to 2.5 um when they are fitted (NTN, section 7), which is not subtracted.


#: Keys next to a group of clearances, or of the joint.
MOUNTING_KEYS = {
    "fit": "classes of shaft and housing of the mounted bearing, such as k5/H7",
    "inner_warmer": "how much warmer the inner ring is than the outer one, such as 5 K",
}
EXPANSION = 12.5e-6  # 1/K, of bearing steel (NTN, equation 8.5)
PROBABLE_PART = 2.0 / 3.0  # of the tolerance zones of both parts, within which their sizes lie (Schaeffler, HR 1)
#: Diameters (mm, upper end of each range) and lower deviation (um) of the bore and of the outside, class Normal of
#: ISO 492; the upper one is 0.
_BORE_STEPS = (18, 30, 50, 80, 120, 180, 250, 315, 400, 500)
_BORE_DEVIATIONS = (-8, -10, -12, -15, -20, -25, -30, -35, -40, -45)
_OUTSIDE_STEPS = (18, 30, 50, 80, 120, 150, 180, 250, 315, 400, 500)
_OUTSIDE_DEVIATIONS = (-8, -9, -11, -13, -15, -18, -25, -30, -35, -40, -45)


class BearingSizes(NamedTuple):
    """The diameters (m) on which a mounted clearance depends."""

    bore: float
    outside_diameter: float
    element_diameter: float
    pitch_diameter: float


def mounted(group: Fit, name: str, sizes: BearingSizes, warmer: float = 0.0) -> Fit:
    """Return the clearances that are left of those of a `group` in a mounted bearing.

    name : fits of shaft and housing, 'k5/H7'; '' for loose fits.  warmer : K, of the inner ring above the outer one.
    Raises InputError for an unknown fit.
    """
    inner_raceway = sizes.pitch_diameter - sizes.element_diameter
    outer_raceway = sizes.pitch_diameter + sizes.element_diameter
    heating = EXPANSION * warmer * outer_raceway
    low = mean = high = 0.0
    if name:
        shaft, slash, housing = (part.strip() for part in name.partition("/"))
        if not slash or not shaft[:1].islower() or not housing[:1].isupper():
            raise InputError(f"found {quoted(name)}; expected the shaft's class before the housing's, such as k5/H7")
        bore, outside = _millimetres(sizes.bore), _millimetres(sizes.outside_diameter)
        inner_ring = (_deviation(bore, _BORE_STEPS, _BORE_DEVIATIONS), 0.0)
        outer_ring = (_deviation(outside, _OUTSIDE_STEPS, _OUTSIDE_DEVIATIONS), 0.0)
        interferences = (
            (_interference(_limits(shaft, bore), inner_ring), sizes.bore / inner_raceway),
            (_interference(outer_ring, _limits(housing, outside)), outer_raceway / sizes.outside_diameter),
        )
        low, mean, high = (
            sum(share * max(interference[k], 0.0) for interference, share in interferences) for k in range(3)
        )
    return group._replace(
        low=group.low - high - heating, mean=group.mean - mean - heating, high=group.high - low - heating
    )


def _millimetres(length: float) -> Fraction:
    return Fraction(repr(length)) * 1000


def _limits(tolerance_class: str, size: Fraction) -> tuple[float, float]:
    low, high = limit_deviations(tolerance_class, size)
    return float(low), float(high)


def _deviation(size: Fraction, steps: tuple[int, ...], deviations: tuple[int, ...]) -> float:
    if size > steps[-1]:
        raise InputError(f"found a ring of {float(size):g} mm; fits are known up to {steps[-1]} mm")
    return float(deviations[bisect_left(steps, size)])


def _interference(inside: tuple[float, float], outside: tuple[float, float]) -> tuple[float, float, float]:
    """Return least, mean and largest probable interference (m) from limits (um) of the inner and the outer part."""
    mean = 0.5 * (sum(inside) - sum(outside))
    half_range = 0.5 * PROBABLE_PART * (inside[1] - inside[0] + outside[1] - outside[0])
    return (mean - half_range) / 1e6, mean / 1e6, (mean + half_range) / 1e6
