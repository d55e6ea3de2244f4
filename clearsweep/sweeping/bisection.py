"""Finds the border in a sequence of values that begins with good ones: the next values to try, and the answer.

Values are addressed by index.  Near the border the motion is chaotic, so good and bad values may alternate.
Hence a scan and bisection enclose it; then neighbours on both sides are examined until REPEATS of them in a row
agree, further away each time they do not.  Good values beyond the first bad one of the scan do not count.
"""

import math
from collections.abc import Mapping
from typing import NamedTuple

SCAN = 4  # equal intervals whose ends are examined first
REPEATS = 2  # neighbours on each side that must agree with the border

Known = Mapping[int, bool]  # index -> whether it is good


class Border(NamedTuple):
    """The end of the good values, by index."""

    last_good: int | None  # last index up to which all examined ones are good; None: none is
    first_bad: int | None  # index after the border that is bad like its next REPEATS; None: the last index is good


class Search(NamedTuple):
    """State of a search: the next indices to try, or the answer."""

    probes: tuple[int, ...] = ()
    border: Border | None = None


def scan(last: int) -> tuple[int, ...]:
    """Return the first indices to examine, of 0 to `last`; `last` is a power of 2."""
    return tuple(range(0, last + 1, max(last // SCAN, 1)))


def usual_probes(last: int) -> int:
    """Return how many indices of 0 to `last` are examined if the border is sharp."""
    return len(scan(last)) + int(math.log2(last / SCAN)) + 2 * REPEATS


def search(known: Known, last: int) -> Search:
    """Return the next indices of 0 to `last` to examine, or the border; it depends only on `known`."""
    first = scan(last)
    if unknown := _unknown(first, known):
        return Search(unknown)
    start = next((index for index in first if known[index]), None)
    if start is None:
        return Search((), Border(None, 0))
    first_bad = next((index for index in first if index > start and not known[index]), None)
    last_good = max(index for index in first if index >= start and (first_bad is None or index < first_bad))
    while first_bad is not None and first_bad - last_good > 1:
        middle = (last_good + first_bad) // 2
        if middle not in known:
            return Search((middle,))
        last_good, first_bad = (middle, first_bad) if known[middle] else (last_good, middle)
    lower, upper = _settled(known, last_good, -1, start), _settled(known, first_bad, 1, last)
    if unknown := (*lower.probes, *upper.probes):
        return Search(tuple(sorted(set(unknown))))
    return Search((), Border(lower.position, upper.position))


class _Side(NamedTuple):
    probes: tuple[int, ...] = ()
    position: int | None = None


def _settled(known: Known, index: int | None, step: int, end: int) -> _Side:
    """Return the first index from `index` towards `end` whose next REPEATS neighbours agree with it.

    Below the border (`step` -1) values must be good, above it bad.  None if the sequence ends earlier.
    """
    stride = 1
    while index is not None and (end - index) * step >= 0:
        if index not in known:
            return _Side((index,))
        neighbours = [index + step * k for k in range(1, REPEATS + 1) if (end - index) * step >= k]
        if known[index] is (step < 0):
            if unknown := _unknown(neighbours, known):
                return _Side(unknown)
            disagreeing = [neighbour for neighbour in neighbours if known[neighbour] is not known[index]]
            if not disagreeing:
                return _Side((), index)
            index = disagreeing[-1]
        index += step * stride
        stride *= 2
    return _Side()


def _unknown(indices: tuple[int, ...] | list[int], known: Known) -> tuple[int, ...]:
    return tuple(index for index in indices if index not in known)
