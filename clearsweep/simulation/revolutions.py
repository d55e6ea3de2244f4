"""Quantities of single revolutions: force peaks, the motion at crank angle 0, the period of the motion."""

import functools
import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from ..contracts.layout import MOST_REVOLUTIONS
from ..mechanics.solver.accumulate.turns import Turns
from .scene import Scene, unit_of
from .spread import Spread, quantiles
from .window import bearing_of

LONGEST_PERIOD, REPEATS = 16, 3  # revolutions; times that a period has to be repeated
RETURN = 1e-3  # clearances, and clearances times crank rate: how closely a periodic motion returns
SAME = 1e-9  # revolutions: marks that are nearer are one


class Marks(NamedTuple):
    """Places along a run, in revolutions since its start, at which something is recorded."""

    turns: np.ndarray  # (marks,) increasing
    window: np.ndarray  # (w,) which of them begin or end a revolution of the window
    sections: np.ndarray  # (s,) which of them are at crank angle 0


NO_MARKS = Marks(np.empty(0), np.empty(0, int), np.empty(0, int))


def marks_of(scene: Scene, revolutions: float) -> Marks:
    """Return the marks of a run of so many revolutions; none where nothing turns."""
    if not scene.mechanism.turns:
        return NO_MARKS
    phase = None if scene.case.save.orbits == "none" else -begun(scene) % 1.0
    return _marks(scene.case.simulate.discard, revolutions, phase)


@functools.lru_cache(maxsize=64)  # the cases of a sweep share them
def _marks(discard: float, revolutions: float, phase: float | None) -> Marks:
    """Return the marks of a run whose window begins at `discard`, with sections from `phase` on; None: without."""
    window = _each(discard, revolutions)
    sections = np.empty(0) if phase is None else _each(phase, revolutions)
    if np.array_equal(window, sections[len(sections) - len(window) :]):  # as good as always
        turns = sections
    else:
        turns = np.sort(np.concatenate([window, sections]))
        turns = turns[np.diff(turns, prepend=-1.0) > SAME]
    return Marks(np.minimum(turns, revolutions), _nearest(turns, window), _nearest(turns, sections))


def _each(first: float, last: float) -> np.ndarray:
    """Return first, first + 1, ... up to `last`; of many only the last ones."""
    count = max(math.floor(last - first + SAME) + 1, 0)
    return first + np.arange(max(count - MOST_REVOLUTIONS - 1, 0), count)


def begun(scene: Scene) -> float:
    """Return the crank angle at the start, in turns."""
    return scene.case.drive.start_angle / (2.0 * math.pi) if scene.case.drive else 0.0


def _nearest(turns: np.ndarray, wanted: np.ndarray) -> np.ndarray:
    return np.searchsorted(turns, wanted - SAME)


def room_for(marks: np.ndarray, n: int, contacts: int, zeros: Callable[..., np.ndarray]) -> Turns:
    """Return room for what is taken at `marks` of a run, `n` numbers in its state, but for what lies in a lane.

    `zeros` makes the arrays.
    """
    count = len(marks)
    return Turns(
        marks=marks,
        states=zeros((count, n)),
        peaks=zeros((count, contacts)),
        highest=np.zeros(0),
        since=np.zeros(0),
        passed=zeros(1, dtype=np.int64),
    )


def spreads_of(scene: Scene, marks: Marks, turns: Any) -> tuple[Spread, ...]:
    """Return how the force peaks of each joint spread over the window's revolutions."""
    begins = marks.turns[reached(marks.window, turns)]
    return tuple([_spread(peaks, begins) for peaks in peaks_of(scene, marks, turns).T])


def _spread(peaks: np.ndarray, begins: np.ndarray) -> Spread:
    """Return how the peaks (N) of revolutions spread that begin so many after the start of the run."""
    median, p95 = quantiles(peaks, (0.5, 0.95))
    return Spread(median, p95, _highest(peaks, begins))


def _highest(peaks: np.ndarray, begins: np.ndarray) -> tuple[float, int] | None:
    """Return the largest of the peaks (N) of revolutions, and the number of the one in which it lies; None of none.

    begins : where they begin, in revolutions since the start of the run.
    """
    if not len(peaks):
        return None
    place = int(peaks.argmax())
    return float(peaks[place]), math.floor(begins[place] + SAME) + 1


def reached(places: np.ndarray, turns: Any) -> np.ndarray:
    """Return those `places` of marks that a run has reached."""
    passed = turns.passed.item()
    return places if passed == len(turns.marks) else places[places < passed]


def peaks_of(scene: Scene, marks: Marks, turns: Any) -> np.ndarray:
    """Return the largest normal force (N) of each joint in each revolution of the window: (revolutions, joints).

    Of a joint with several contacts it is that of the one that bears most, as its largest force is; of a joint in space
    that of its walls together.
    """
    window = reached(marks.window, turns)
    if len(window) < 2:
        return np.zeros((0, len(scene.layout.joints)))
    first, last = int(window[0]) + 1, int(window[-1]) + 1
    peaks: np.ndarray = turns.peaks[first:last]
    if len(peaks) != len(window) - 1:
        peaks = np.maximum.reduceat(peaks, window[:-1] - window[0])
    if len(scene.layout.joints) == peaks.shape[1]:
        return peaks
    return np.stack([peaks[:, row].max(axis=1) for row in bearing_of(scene.layout)], axis=1)


def periods_in(runs: Sequence[tuple[Scene, Marks, Any]]) -> list[int | None]:
    """Return after how many revolutions the window's motion repeats itself, or None if it was not seen to.

    runs : scene, Marks and Turns of each; those of as many revolutions are looked at together, which takes much less.
    """
    periods: list[int | None] = [None] * len(runs)
    alike: dict[int, list[int]] = {}  # revolutions -> places of runs
    for place, (_, marks, turns) in enumerate(runs):
        alike.setdefault(len(reached(marks.window, turns)), []).append(place)
    for places in [places for rows, places in alike.items() if rows > REPEATS]:
        units = np.array([unit_of(runs[place][0]) for place in places])[:, None]
        states = np.array([_returns(*runs[place]) for place in places])
        turn = 2.0 * math.pi / units[..., : units.shape[-1] // 2]
        for place, period in zip(places, periods_of(states / units, turn), strict=True):
            periods[place] = period
    return periods


def _returns(scene: Scene, marks: Marks, turns: Any) -> np.ndarray:
    """Return coordinates and rates at the ends of the window's last revolutions, (revolutions, columns)."""
    rows = reached(marks.window, turns)[-LONGEST_PERIOD * (REPEATS + 1) :]
    states: np.ndarray = turns.states[rows, : 2 * len(scene.value.coordinates)]
    return states


def period_of(returns: np.ndarray, turn: np.ndarray | None = None) -> int | None:
    """Return after how many rows of (revolutions, columns) the last ones repeat themselves; None: they do not.

    turn : whole multiples of it in the first columns are no difference: whether an angle has gone round.
    """
    return periods_of(returns[None], None if turn is None else turn[None, None])[0]


def periods_of(returns: np.ndarray, turn: np.ndarray | None = None) -> list[int | None]:
    """Return the same of each of several motions, (motions, revolutions, columns); turn : (motions, 1, angles)."""
    periods, rows = np.zeros(len(returns), int), returns.shape[1]
    for period in range(1, min(LONGEST_PERIOD, rows // (REPEATS + 1)) + 1):
        left = np.flatnonzero(periods == 0)
        if not left.size:
            break
        off = returns[left, rows - REPEATS * period :] - returns[left, rows - (REPEATS + 1) * period : -period]
        if turn is not None:
            angles = off[..., : turn.shape[-1]]
            angles -= np.round(angles / turn[left]) * turn[left]
        periods[left[np.all(np.abs(off) <= RETURN, axis=(1, 2))]] = period
    return [period or None for period in periods.tolist()]
