"""Finds the border in a sequence of places that begins with good ones: the places to try next, and the answer.

Near the border the motion is chaotic, so good and bad places may alternate.  Hence a scan and bisection enclose it;
then neighbours on both sides are examined until REPEATS of them in a row agree, further away each
time they do not.  Good places beyond the first bad place of the scan do not count.
"""

import math
from collections.abc import Mapping
from typing import NamedTuple

SCAN = 4  # equal intervals whose ends are examined first
REPEATS = 2  # neighbours on each side that must agree with the border

Known = Mapping[int, bool]  # place -> whether it is good


class Border(NamedTuple):
    """The end of the good places."""

    good: int | None  # last place up to which all examined places are good; None: none is
    bad: int | None  # first place from which on all examined places are bad; None: the last place is good


class Search(NamedTuple):
    """State of a search: the next places to try, or the answer."""

    wanted: tuple[int, ...] = ()
    border: Border | None = None


def scan(last: int) -> tuple[int, ...]:
    """Return the first places to examine, of 0 to `last`; `last` is a power of 2."""
    return tuple(range(0, last + 1, max(last // SCAN, 1)))


def usual_probes(last: int) -> int:
    """Return how many places of 0 to `last` are examined if the border is sharp."""
    return len(scan(last)) + int(math.log2(last / SCAN)) + 2 * REPEATS


def search(known: Known, last: int) -> Search:
    """Return the next places of 0 to `last` to examine, or the border; it depends only on `known`."""
    first = scan(last)
    if wanted := _unknown(first, known):
        return Search(wanted)
    start = next((place for place in first if known[place]), None)
    if start is None:
        return Search((), Border(None, 0))
    bad = next((place for place in first if place > start and not known[place]), None)
    good = max(place for place in first if place >= start and (bad is None or place < bad))
    while bad is not None and bad - good > 1:
        middle = (good + bad) // 2
        if middle not in known:
            return Search((middle,))
        good, bad = (middle, bad) if known[middle] else (good, middle)
    below, above = _settled(known, good, -1, start), _settled(known, bad, 1, last)
    if wanted := (*below.wanted, *above.wanted):
        return Search(tuple(sorted(set(wanted))))
    return Search((), Border(below.place, above.place))


class _Side(NamedTuple):
    wanted: tuple[int, ...] = ()
    place: int | None = None


def _settled(known: Known, place: int | None, step: int, end: int) -> _Side:
    """Return the first place from `place` towards `end` whose next REPEATS neighbours agree with it.

    Below the border (`step` -1) places must be good, above it bad.  None if the sequence ends earlier.
    """
    stride = 1
    while place is not None and (end - place) * step >= 0:
        if place not in known:
            return _Side((place,))
        around = [place + step * k for k in range(1, REPEATS + 1) if (end - place) * step >= k]
        if known[place] is (step < 0):
            if wanted := _unknown(around, known):
                return _Side(wanted)
            others = [each for each in around if known[each] is not known[place]]
            if not others:
                return _Side((), place)
            place = others[-1]
        place += step * stride
        stride *= 2
    return _Side()


def _unknown(places: tuple[int, ...] | list[int], known: Known) -> tuple[int, ...]:
    return tuple(place for place in places if place not in known)
