"""Clearance fits of holes and shafts: ISO 286-1:2010, standard tolerances and fundamental deviations of 1 to 500 mm.

The tables are copied from the standard.  Its formulas (annex B of the 1988 edition) give them before rounding, which
follows no single rule; the tables are checked against them.
"""

import re
from bisect import bisect_left
from fractions import Fraction
from typing import NamedTuple

from ...language.errors import InputError, quoted

SMALLEST_DIAMETER, LARGEST_DIAMETER = 1, 500  # mm, both included
_DIAMETER_STEPS = (3, 6, 10, 18, 30, 50, 80, 120, 180, 250, 315, 400, 500)  # mm, upper end of each range
_FINE_DIAMETER_STEPS = (
    3,
    6,
    10,
    14,
    18,
    24,
    30,
    40,
    50,
    65,
    80,
    100,
    120,
    140,
    160,
    180,
    200,
    225,
    250,
    280,
    315,
    355,
    400,
    450,
    500,
)
#: Standard tolerances in um: the grade, then one for each of _DIAMETER_STEPS (table 1).
_TOLERANCES = """
1  0.8 1   1   1.2  1.5  1.5  2    2.5  3.5  4.5  6    7    8
2  1.2 1.5 1.5 2    2.5  2.5  3    4    5    7    8    9    10
3  2   2.5 2.5 3    4    4    5    6    8    10   12   13   15
4  3   4   4   5    6    7    8    10   12   14   16   18   20
5  4   5   6   8    9    11   13   15   18   20   23   25   27
6  6   8   9   11   13   16   19   22   25   29   32   36   40
7  10  12  15  18   21   25   30   35   40   46   52   57   63
8  14  18  22  27   33   39   46   54   63   72   81   89   97
9  25  30  36  43   52   62   74   87   100  115  130  140  155
10 40  48  58  70   84   100  120  140  160  185  210  230  250
11 60  75  90  110  130  160  190  220  250  290  320  360  400
12 100 120 150 180  210  250  300  350  400  460  520  570  630
13 140 180 220 270  330  390  460  540  630  720  810  890  970
"""
#: How far in um a shaft's upper limit of size lies below the nominal size, and a hole's lower one of the same letter
#: above it (tables 2 and 4); of a, b and c for each of _FINE_DIAMETER_STEPS, of the others for each of _DIAMETER_STEPS.
_SHAFT_UPPER_DEVIATIONS = """
a 270 270 280 290 290 300 300 310 320 340 360 380 410 460 520 580 660 740 820 920 1050 1200 1350 1500 1650
b 140 140 150 150 150 160 160 170 180 190 200 220 240 260 280 310 340 380 420 480 540 600 680 760 840
c 60 70 80 95 95 110 110 120 130 140 150 170 180 200 210 230 240 260 280 300 330 360 400 440 480
d 20 30 40 50 65 80 100 120 145 170 190 210 230
e 14 20 25 32 40 50 60 72 85 100 110 125 135
f 6 10 13 16 20 25 30 36 43 50 56 62 68
g 2 4 5 6 7 9 10 12 14 15 17 18 20
h 0 0 0 0 0 0 0 0 0 0 0 0 0
"""
#: How far in um a shaft's lower limit of size lies above the nominal size (table 5); k of the grades 4 to 7, else 0.
_SHAFT_LOWER_DEVIATIONS = """
k 0 1 1 1 2 2 2 3 3 4 4 4 5
m 2 4 6 7 8 9 11 13 15 17 20 21 23
n 4 8 10 12 15 17 20 23 27 31 34 37 40
p 6 12 15 18 22 26 32 37 43 50 56 62 68
"""
#: Grades of holes whose upper limit follows from the shaft of their letter: -ei + IT(grade) - IT(grade - 1), without
#: the difference up to 3 mm (4.3.2.5; the standard tabulates the result).
_TIGHT_HOLE_GRADES = dict.fromkeys("kmn", ("5", "6", "7", "8")) | {"p": ("5", "6", "7")}
_CLASS_PATTERN = re.compile(r"([A-Za-z]{1,2})(\d{1,2})")


def _parse_rows(table: str) -> dict[str, tuple[Fraction, ...]]:
    """Return the rows of a table, in um, by their first word."""
    rows = (line.split() for line in table.strip().splitlines())
    return {heading: tuple(map(Fraction, numbers)) for heading, *numbers in rows}


_TOLERANCE_BY_GRADE, _UPPER_BY_LETTER, _LOWER_BY_LETTER = map(
    _parse_rows, (_TOLERANCES, _SHAFT_UPPER_DEVIATIONS, _SHAFT_LOWER_DEVIATIONS)
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
