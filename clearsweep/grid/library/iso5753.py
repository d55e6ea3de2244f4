"""Radial internal clearance of rolling bearings by group: ISO 5753-1:2009, bores of 2.5 to 500 mm, cylindrical.

The tables of deep groove ball bearings end at 100 mm here.  Needle roller bearings with an inner ring have the
clearances of cylindrical roller bearings, but no group C5 up to 10 mm.
"""

from bisect import bisect_left
from collections.abc import Mapping
from fractions import Fraction

from ...language.errors import InputError, did_you_mean, quoted
from .iso286 import Fit

GROUPS = ("C2", "CN", "C3", "C4", "C5")
NORMAL_GROUP = "CN"  # of a bearing whose name has no group
#: Upper end of the range of bores in mm (the lower end is that of the row before), then smallest and largest clearance
#: in um of each group; '-' where the standard has none.  Compared with the catalogue NTN-TPI CAT 2202/TE, table 6.1, up
#: to 65 mm and with two reprints up to 100 mm.
_BALL_TABLE = """
2.5 - - - - - - - - - -
6 0 7 2 13 8 23 - - - -
10 0 7 2 13 8 23 14 29 20 37
18 0 9 3 18 11 25 18 33 25 45
24 0 10 5 20 13 28 20 36 28 48
30 1 11 5 20 13 28 23 41 30 53
40 1 11 6 20 15 33 28 46 40 64
50 1 11 6 23 18 36 30 51 45 73
65 1 15 8 28 23 43 38 61 55 90
80 1 15 10 30 25 51 46 71 65 105
100 1 18 12 36 30 58 53 84 75 120
"""
#: Compared with a reprint of the table of the standard (original-bearing.com) and with the catalogue of IKO.
_ROLLER_TABLE = """
10 0 25 20 45 35 60 50 75 - -
24 0 25 20 45 35 60 50 75 65 90
30 0 25 20 45 35 60 50 75 70 95
40 5 30 25 50 45 70 60 85 80 105
50 5 35 30 60 50 80 70 100 95 125
65 10 40 40 70 60 90 80 110 110 140
80 10 45 40 75 65 100 90 125 130 165
100 15 50 50 85 75 110 105 140 155 190
120 15 55 50 90 85 125 125 165 180 220
140 15 60 60 105 100 145 145 190 200 245
160 20 70 70 120 115 165 165 215 225 275
180 25 75 75 125 120 170 170 220 250 300
200 35 90 90 145 140 195 195 250 275 330
225 45 105 105 165 160 220 220 280 305 365
250 45 110 110 175 170 235 235 300 330 395
280 55 125 125 195 190 260 260 330 370 440
315 55 130 130 205 200 275 275 350 410 485
355 65 145 145 225 225 305 305 385 455 535
400 100 190 190 280 280 370 370 460 510 600
450 110 210 210 310 310 410 410 510 565 665
500 110 220 220 330 330 440 440 550 625 735
"""
_Row = tuple[Fraction, Mapping[str, tuple[int, int]]]  # upper end of the bores (mm), limits (um) by group


def _parse_rows(table: str) -> tuple[_Row, ...]:
    rows = (line.split() for line in table.strip().splitlines())
    return tuple(
        (
            Fraction(bore),
            {
                group: (int(low), int(high))
                for group, low, high in zip(GROUPS, limits[::2], limits[1::2], strict=True)
                if low != "-"
            },
        )
        for bore, *limits in rows
    )


_ROWS = {"ball": _parse_rows(_BALL_TABLE), "roller": _parse_rows(_ROLLER_TABLE)}
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
