"""Quantities of single revolutions: force peaks, the motion at crank angle 0, the period of the motion."""

import functools
import math
import operator
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ...contracts.layout import MAX_REVOLUTIONS
from ...mechanics.solver.accumulate.within_step import RevolutionMarks
from ..figures.extreme import expected_largest
from ..figures.spread import Quantile, Repetition, Spread, quantiles
from ..figures.window import force_contacts
from .scene import Scene, state_units

LONGEST_PERIOD, MIN_REPEATS = 16, 3  # most revolutions of a period; how often it must be repeated
LAST_RETURNS = LONGEST_PERIOD * (MIN_REPEATS + 1)  # revolutions from which a period is found
RETURN_TOLERANCE = 1e-3  # clearances, and clearances times crank speed: tolerance of a periodic motion
MARK_TOLERANCE = 1e-9  # revolutions: closer marks are merged


class Marks(NamedTuple):
    """Times of a run, in revolutions since its start, at which something is recorded."""

    turns: np.ndarray  # (marks,) increasing
    window: np.ndarray  # (w,) indices of the bounds of the window's revolutions
    sections: np.ndarray  # (s,) indices of the marks at crank angle 0

    def after(self, turns: float) -> "Marks":
        """Return the marks of a window that begins `turns` revolutions after the start."""
        return self._replace(window=self.window[self.turns[self.window] > turns - MARK_TOLERANCE])


NO_MARKS = Marks(np.empty(0), np.empty(0, int), np.empty(0, int))


def marks_of(scene: Scene, revolutions: float) -> Marks:
    """Return the marks of a run of `revolutions`; there are none if nothing turns."""
    if not scene.mechanism.turns:
        return NO_MARKS
    phase = None if scene.case.save.orbits == "none" else -start_turns(scene) % 1.0
    return _marks(scene.case.simulate.discard, revolutions, phase)


@functools.lru_cache(maxsize=64)  # the cases of a sweep share them
def _marks(discard: float, revolutions: float, phase: float | None) -> Marks:
    """Return the marks of a run whose window begins at `discard`; sections begin at `phase`, None for no sections."""
    window = _consecutive(discard, revolutions)
    sections = np.empty(0) if phase is None else _consecutive(phase, revolutions)
    if np.array_equal(window, sections[len(sections) - len(window) :]):  # almost always
        turns = sections
    else:
        turns = np.sort(np.concatenate([window, sections]))
        turns = turns[np.diff(turns, prepend=-1.0) > MARK_TOLERANCE]
    return Marks(np.minimum(turns, revolutions), _nearest(turns, window), _nearest(turns, sections))


def with_whole_revolutions(discard: float, most: float) -> float:
    """Return `discard` plus as many whole revolutions as there are up to `most`."""
    return discard + math.floor(most - discard + MARK_TOLERANCE)


def _consecutive(start: float, end: float) -> np.ndarray:
    """Return start, start + 1, ... up to `end`; if there are many, only the last ones."""
    count = max(math.floor(end - start + MARK_TOLERANCE) + 1, 0)
    return start + np.arange(max(count - MAX_REVOLUTIONS - 1, 0), count)


def start_turns(scene: Scene) -> float:
    """Return the crank angle at the start, in turns."""
    return scene.case.drive.start_angle / (2.0 * math.pi) if scene.case.drive else 0.0


def _nearest(turns: np.ndarray, requested: np.ndarray) -> np.ndarray:
    return np.searchsorted(turns, requested - MARK_TOLERANCE)


def buffers_for(marks: np.ndarray, state_size: int, contacts: int, zeros: Callable[..., np.ndarray]) -> RevolutionMarks:
    """Return the buffers for values at the `marks` of a run with `state_size` state numbers, except those in lanes.

    `zeros` creates the arrays.
    """
    count = len(marks)
    return RevolutionMarks(
        marks=marks,
        states=zeros((count, state_size)),
        peaks=zeros((count, contacts)),
        step_peak=np.zeros(0),
        peak_since_mark=np.zeros(0),
        passed=zeros(1, dtype=np.int64),
    )


def peak_spreads(scene: Scene, marks: Marks, revolutions: Any, repetition: Repetition | None) -> tuple[Spread, ...]:
    """Return the distribution of each joint's force peaks over the window's revolutions."""
    return tuple([_spread(peaks, marks, repetition) for peaks in peaks_of(scene, marks, revolutions).T])


def _spread(peaks: np.ndarray, marks: Marks, repetition: Repetition | None) -> Spread:
    """Return the distribution of the peaks (N) of the window's revolutions.

    All later revolutions of a periodic motion have the peaks of its last periods, without those of the run-in.
    """
    median, p95 = quantiles(peaks, (0.5, 0.95))
    if repetition is None:
        of_million = expected_largest(peaks)
    else:
        lasting = float(peaks[-MIN_REPEATS * repetition.period :].max())
        of_million = Quantile(lasting, lasting, lasting)
    return Spread(median, p95, of_million, _largest_peak(peaks, marks))


def _largest_peak(peaks: np.ndarray, marks: Marks) -> tuple[float, int] | None:
    """Return the largest of the peaks (N) of the window's revolutions and the number of its revolution, or None."""
    if not len(peaks):
        return None
    index = int(peaks.argmax())
    return float(peaks[index]), math.floor(marks.turns[marks.window[index]] + MARK_TOLERANCE) + 1


def marks_reached(indices: np.ndarray, revolutions: Any) -> np.ndarray:
    """Return the `indices` of marks that a run has reached."""
    passed = revolutions.passed.item()
    return indices if passed == len(revolutions.marks) else indices[indices < passed]


def peaks_of(scene: Scene, marks: Marks, revolutions: Any) -> np.ndarray:
    """Return the largest normal force (N) of each joint in each revolution of the window: (revolutions, joints)."""
    window = marks_reached(marks.window, revolutions)
    if len(window) < 2:
        return np.zeros((0, len(scene.layout.joints)))
    begin, end = int(window[0]) + 1, int(window[-1]) + 1
    peaks: np.ndarray = revolutions.peaks[begin:end]
    if len(peaks) != len(window) - 1:
        peaks = np.maximum.reduceat(peaks, window[:-1] - window[0])
    if len(scene.layout.joints) == peaks.shape[1]:
        return peaks
    return peaks[:, force_contacts(scene.layout)]


def repetition_of(scene: Scene, marks: Marks, revolutions: Any) -> Repetition | None:
    """Return the period of the window's motion and where it begins, or None if the motion is not periodic."""
    rows = marks_reached(marks.window, revolutions)
    if len(rows) <= MIN_REPEATS:
        return None
    units, coordinate_count = state_units(scene), len(scene.value.coordinates)
    angle_period = 2.0 * math.pi / units[:coordinate_count]

    def states(chosen: np.ndarray) -> np.ndarray:
        return revolutions.states[chosen, : 2 * coordinate_count] / units  # type: ignore[no-any-return]

    period = period_of(states(rows[-LAST_RETURNS:]), angle_period)
    if period is None:
        return None
    every = states(rows)
    differences = every[period:] - every[:-period]
    angles = differences[:, :coordinate_count]
    angles -= angle_period * np.round(angles / angle_period)
    departures = np.flatnonzero(np.abs(differences).max(axis=1) > RETURN_TOLERANCE)
    first = int(departures[-1]) + 1 if len(departures) else 0
    return Repetition(period, float(marks.turns[rows[first]]))


def period_of(returns: np.ndarray, angle_period: np.ndarray | None = None) -> int | None:
    """Return the period of the last rows of (revolutions, columns), or None.

    angle_period : period of the angles in the first columns: multiples of it count as no difference.
    """
    rows = returns[-LAST_RETURNS:].tolist()  # nearly every motion differs in the first numbers; floats are faster then
    angle_periods = [] if angle_period is None else angle_period.tolist()
    for period in range(1, min(LONGEST_PERIOD, len(rows) // (MIN_REPEATS + 1)) + 1):
        repeats = zip(rows[-MIN_REPEATS * period :], rows[-(MIN_REPEATS + 1) * period : -period], strict=True)
        if all(_is_return(row, previous_row, angle_periods) for row, previous_row in repeats):
            return period
    return None


def _is_return(row: list[float], previous_row: list[float], angle_periods: list[float]) -> bool:
    """Return whether two rows are equal within the tolerance; angle_periods : as in `period_of`."""
    differences = map(operator.sub, row, previous_row)
    is_same_angle = all(
        abs(math.remainder(difference, angle_period)) <= RETURN_TOLERANCE
        for angle_period, difference in zip(angle_periods, differences, strict=False)
    )
    return is_same_angle and all(abs(difference) <= RETURN_TOLERANCE for difference in differences)
