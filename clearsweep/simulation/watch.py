"""Runs with observers, which measure how fast a perturbation grows, or decide whether the run is long enough.

A watched run pauses between two steps and goes on as if it had not: its motion and figures are, to the last bit, those
of a plain run of the same length.
"""

import itertools
from collections.abc import Callable, Sequence
from typing import Any, Protocol

import numpy as np

from ..mechanics.solver import run_control
from ..mechanics.solver.event import Work

#: Turns before the end of a revolution at which a run pauses: more than a step spans, so that it can still end there.
LEAD = 0.025


_OWN = "control", "counts", "log", "slopes", "step"  # of a run, whatever its motion
Moment = dict[str, np.ndarray]  # copies of all arrays that a motion goes on from, by name


class Pausing(Protocol):
    """An integration that can pause and go on: a `run.Run`."""

    work: Work

    def go(self, control: run_control.Control) -> tuple[int, np.ndarray]:
        """Return the status and the events from where it is to where `control` ends or pauses it."""


class Observer(Protocol):
    """An observer of a run."""

    parts: int  # of a revolution, at the end of each of which it looks

    def see(self, work: Work) -> bool:
        """Observe the run; return whether it may end with this revolution."""


def drive(
    control: run_control.Control,
    run: Pausing,
    discard: float,
    at: Callable[[float], float],
    watchers: Sequence[Observer],
) -> tuple[int, np.ndarray]:
    """Return the status and the events of an integration that `watchers` observe.

    discard : revolutions after which they begin; at : revolutions -> where they end, see `crank_clock`.
    """
    work, logs, parts = run.work, [], max(watcher.parts for watcher in watchers)
    for k in itertools.count():
        pause = mark(k / parts, discard, at)
        if pause >= control.end:
            break
        status, log = run.go(control._replace(pause=pause))
        logs.append(log)
        if status != run_control.PAUSED:
            return status, np.concatenate(logs)
        end = at(discard + k // parts)
        enough = [watcher.see(work) for watcher in watchers if k % (parts // watcher.parts) == 0]
        if any(enough) and work.y[work.independent] < end:
            control = control._replace(end=end)
    status, log = run.go(control)
    return status, np.concatenate([*logs, log])


def mark(turns: float, discard: float, at: Callable[[float], float]) -> float:
    """Return where to pause so many turns after the first `discard` ones: LEAD before, save at the start."""
    return at(discard + turns - LEAD if turns else discard)


def moment_of(work: Work) -> Moment:
    """Return copies of all arrays of `work` (event.Work) that the motion goes on from."""
    return {name: array.copy() for name, array in _arrays(work).items() if name not in _OWN}


def go_to(moment: Moment, work: Work) -> None:
    """Let `work` go on from what `moment_of` returned of another run of the same scene."""
    arrays = _arrays(work)
    for name, array in moment.items():
        arrays[name][...] = array


def _arrays(work: Work) -> dict[str, np.ndarray]:
    """Return the arrays of `work` (event.Work) by name, those of the implicit method among them."""
    implicit: Any = work.implicit  # what mypy takes for a tuple of anything
    fields: dict[str, Any] = work._asdict() | implicit._asdict()
    return {name: value for name, value in fields.items() if isinstance(value, np.ndarray)}
