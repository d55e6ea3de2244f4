"""Runs with observers, which measure the growth of a perturbation or decide whether the run is long enough.

An observed run pauses between two steps and resumes without a trace: its motion and figures are, to the last bit, those
of a plain run of the same length and window. An observer may begin the window anew; a step then ends where it begins.
"""

import enum
from collections.abc import Callable, Sequence
from typing import Any, Protocol

import numpy as np

from ...mechanics.solver import integration
from ...mechanics.solver.integration import Work
from ...tracing.fields import Fields

#: Turns before the end of a revolution at which a run pauses: longer than a step, so that it can still end there.
PAUSE_LEAD = 0.025


_NOT_OF_MOTION = (
    "control",
    "counts",
    "log",
    "slopes",
    "step",
    "contact_steps",
    "profiles",
)  # of a run, not of its motion
Snapshot = dict[str, np.ndarray]  # copies by name of all arrays that determine the further motion


class Decision(enum.IntEnum):
    """What an observer decides at the end of a revolution."""

    CONTINUE = 0
    END = 1  # end the run with this revolution
    BEGIN_WINDOW = 2  # begin the window of the figures at the end of this revolution


class Pausing(Protocol):
    """An integration that can pause and resume: a `run.Run`."""

    work: Work

    def advance(self, control: integration.Control) -> tuple[int, np.ndarray]:
        """Return status and events from the present state to the end or pause in `control`."""

    def forget_figures(self) -> None:
        """Forget the figures of the window, which begins anew later."""


class Observer(Protocol):
    """An observer of a run."""

    per_revolution: int  # observations per revolution

    def observe(self, work: Work) -> Decision:
        """Observe the run; return a decision, at any but the end of a revolution CONTINUE."""


class LaterWindow:
    """Begins the window anew as another run did, whose motion is repeated."""

    per_revolution = 1

    def __init__(self, revolutions: float):
        """Prepare for a window that begins `revolutions` after the first one."""
        self.revolutions_left = round(revolutions)

    def observe(self, work: Work) -> Decision:
        """Return BEGIN_WINDOW at the end of the revolution before the window."""
        is_time = self.revolutions_left == 0
        self.revolutions_left -= 1
        return Decision.BEGIN_WINDOW if is_time else Decision.CONTINUE


def run_observed(
    control: integration.Control,
    run: Pausing,
    discard: float,
    value_after: Callable[[float], float],
    observers: Sequence[Observer],
) -> tuple[int, np.ndarray]:
    """Return the status and the events of an integration that `observers` observe.

    discard : revolutions before the first observation; value_after : revolutions -> clock, see `crank_clock`.
    """
    work, logs, per_revolution = run.work, [], max(observer.per_revolution for observer in observers)
    observation = 0
    while (pause := pause_at(observation / per_revolution, discard, value_after)) < control.end:
        status, log = run.advance(control._replace(pause=pause))
        logs.append(log)
        if status != integration.PAUSED:
            return status, np.concatenate(logs)
        revolutions = discard + observation // per_revolution
        end = value_after(revolutions)
        decision = max(
            observer.observe(work)
            for observer in observers
            if observation % (per_revolution // observer.per_revolution) == 0
        )
        observation += 1
        if work.y[work.independent] >= end:
            continue
        if decision == Decision.BEGIN_WINDOW:
            run.forget_figures()
            control, discard, observation = control._replace(window=end), revolutions, 0
        elif decision == Decision.END:
            control = control._replace(end=end)
    status, log = run.advance(control)
    return status, np.concatenate([*logs, log])


def pause_at(turns: float, discard: float, value_after: Callable[[float], float]) -> float:
    """Return the pause for `turns` after the first `discard`: LEAD earlier, except at the start."""
    return value_after(discard + turns - PAUSE_LEAD if turns else discard)


def snapshot_of(work: Work) -> Snapshot:
    """Return copies of all arrays of `work` (integration.Work) that determine the further motion."""
    return {name: array.copy() for name, array in _arrays(work).items() if name not in _NOT_OF_MOTION}


def restore(snapshot: Snapshot, work: Work) -> None:
    """Restore `work` from the result of `snapshot_of`, of this or another run of the same scene."""
    arrays = _arrays(work)
    for name, array in snapshot.items():
        arrays[name][...] = array


def _arrays(work: Work) -> dict[str, np.ndarray]:
    """Return the arrays of `work` (integration.Work) by name, those of the implicit method among them."""
    implicit: Any = work.implicit  # mypy takes it for a tuple of anything
    fields: dict[str, Any] = work._asdict() | implicit._asdict()
    numbers = {name: value.numbers if isinstance(value, Fields) else value for name, value in fields.items()}
    return {name: value for name, value in numbers.items() if isinstance(value, np.ndarray)}
