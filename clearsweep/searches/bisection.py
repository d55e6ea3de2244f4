"""Finds the border in a sequence of values that begins with good ones: the next values to try, and the answer.

Values are addressed by index.  Near the border the motion is chaotic, so good and bad values may alternate.
Hence a scan and bisection enclose it; then neighbours on both sides are examined until AGREEING_NEIGHBOURS of them
in a row agree, further away each time they do not.  Good values beyond the first bad one of the scan do not count.
"""

import math
from collections.abc import Mapping
from typing import NamedTuple

SCAN_INTERVALS = 4  # equal intervals whose ends are examined first
AGREEING_NEIGHBOURS = 2  # neighbours on each side that must agree with the border

Outcomes = Mapping[int, bool]  # index -> whether it is good


class Border(NamedTuple):
    """The end of the good values, by index."""

    last_good: int | None  # last index up to which all examined ones are good; None: none is
    first_bad: int | None  # index after the border that is bad like its next neighbours; None: the last index is good


class Bisection(NamedTuple):
    """State of a search: the next indices to try, or the answer."""

    probes: tuple[int, ...] = ()
    border: Border | None = None


def interval_count(low: float, high: float, within: float) -> int:
    """Return the number of equal steps of at most `within` between two values, a power of 2."""
    return 1 << max(math.ceil(math.log2((high - low) / within)), SCAN_INTERVALS.bit_length() - 1)


def scan_indices(last_index: int) -> tuple[int, ...]:
    """Return the first indices to examine, of 0 to `last_index`, a power of 2."""
    return tuple(range(0, last_index + 1, max(last_index // SCAN_INTERVALS, 1)))


def expected_probe_count(last_index: int) -> int:
    """Return how many indices of 0 to `last_index` are examined if the border is sharp."""
    return len(scan_indices(last_index)) + int(math.log2(last_index / SCAN_INTERVALS)) + 2 * AGREEING_NEIGHBOURS


def search(outcomes: Outcomes, last_index: int) -> Bisection:
    """Return the next indices of 0 to `last_index` to examine, or the border; it depends only on `outcomes`."""
    scanned = scan_indices(last_index)
    if untested := _untested(scanned, outcomes):
        return Bisection(untested)
    first_good = next((index for index in scanned if outcomes[index]), None)
    if first_good is None:
        return Bisection((), Border(None, 0))
    first_bad = next((index for index in scanned if index > first_good and not outcomes[index]), None)
    last_good = max(index for index in scanned if index >= first_good and (first_bad is None or index < first_bad))
    while first_bad is not None and first_bad - last_good > 1:
        middle = (last_good + first_bad) // 2
        if middle not in outcomes:
            return Bisection((middle,))
        last_good, first_bad = (middle, first_bad) if outcomes[middle] else (last_good, middle)
    lower = _first_agreeing(outcomes, last_good, -1, first_good)
    upper = _first_agreeing(outcomes, first_bad, 1, last_index)
    if untested := (*lower.probes, *upper.probes):
        return Bisection(tuple(sorted(set(untested))))
    return Bisection((), Border(lower.position, upper.position))


class _BorderSide(NamedTuple):
    probes: tuple[int, ...] = ()
    position: int | None = None


def _first_agreeing(outcomes: Outcomes, index: int | None, step: int, end: int) -> _BorderSide:
    """Return the first index from `index` towards `end` whose next AGREEING_NEIGHBOURS neighbours agree with it.

    Below the border (`step` -1) values must be good, above it bad.  None if the sequence ends earlier.
    """
    stride = 1
    while index is not None and (end - index) * step >= 0:
        if index not in outcomes:
            return _BorderSide((index,))
        neighbours = [index + step * k for k in range(1, AGREEING_NEIGHBOURS + 1) if (end - index) * step >= k]
        if outcomes[index] is (step < 0):
            if untested := _untested(neighbours, outcomes):
                return _BorderSide(untested)
            disagreeing = [neighbour for neighbour in neighbours if outcomes[neighbour] is not outcomes[index]]
            if not disagreeing:
                return _BorderSide((), index)
            index = disagreeing[-1]
        index += step * stride
        stride *= 2
    return _BorderSide()


def _untested(indices: tuple[int, ...] | list[int], outcomes: Outcomes) -> tuple[int, ...]:
    return tuple(index for index in indices if index not in outcomes)


def deciding_index(outcomes: Outcomes, border: Border, last_index: int) -> int:
    """Return the index that determines the limiting column: the first bad one beyond the border."""
    if border.last_good is None:
        return min((index for index, is_good in outcomes.items() if not is_good), default=0)
    return min(
        (index for index, is_good in outcomes.items() if index > border.last_good and not is_good), default=last_index
    )


def border_of_all(outcomes: Mapping[int, bool], last_index: int) -> Border:
    """Return the border if all indices from 0 to `last_index` are known: it is before the first bad one."""
    first_good = next((index for index in range(last_index + 1) if outcomes[index]), None)
    if first_good is None:
        return Border(None, 0)
    first_bad = next((index for index in range(first_good, last_index + 1) if not outcomes[index]), None)
    return Border(last_index if first_bad is None else first_bad - 1, first_bad)
