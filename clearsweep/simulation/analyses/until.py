"""Decides whether a run is long enough: the interval of its figure is narrow, in periodic or in other motion."""

import math
from collections import deque
from collections.abc import Sequence
from typing import Any

from ...contracts import case
from ...contracts.case import Simulate
from ...mechanics.solver.integration import Work
from ..figures.batch_means import MIN_REVOLUTIONS, Blocks
from ..running.observed_run import Decision, Snapshot, snapshot_of
from ..setup.revolutions import MIN_REPEATS, Marks, repetition_of, with_whole_revolutions
from ..setup.scene import Scene


class WindowLength:
    """Decides at every revolution whether the window is long enough to know a figure.

    Once the motion is periodic, the window is begun anew, because the motion before it, the run-in, never occurs again.
    The figures are then those of whole periods.
    """

    def __init__(self, scene: Scene, marks: Marks, figures: Sequence[str], accuracy: tuple[str, float], longest: float):
        """Prepare for a run of `scene`.

        marks : of the run; figures : those with blocks; accuracy : the figure that decides, and the largest half-width
        of its interval relative to it; longest : revolutions of the longest run
        """
        self.scene, self.marks, self.figures, self.longest = scene, marks, figures, longest
        self.figure, self.relative = accuracy
        settings, save = scene.case.simulate, scene.case.save
        self.discard, self.shortest = settings.discard, settings.revolutions  # revolutions
        self.revolutions = self.discard
        self.blocks = Blocks(scene.layout, figures)
        self.interval = self.blocks.interval(self.figure)
        self.turns, self.settled = 0, False  # turns: revolutions of the window
        # snapshots, oldest first, from which the saved revolutions can be repeated
        self.snapshots: deque[Snapshot] = deque(maxlen=math.ceil(save.revolutions) + 1 if save.orbits == "last" else 1)

    def decide(self, work: Work) -> Decision:
        """Return the decision at the end of a revolution, or at the start of the window.

        A run pauses shortly before the end of a revolution, so the blocks begin in the first revolution of the window.
        """
        turns, self.turns = self.turns, self.turns + 1
        self.revolutions = self.discard + turns
        self.take_snapshot(work)
        if not turns:
            return Decision.CONTINUE
        revolutions: Any = work.revolutions  # mypy takes it for a tuple of anything
        repetition = repetition_of(self.scene, self.marks, revolutions)
        if repetition and repetition.period != self.blocks.period and self._leaves_room_for(repetition.period):
            self.discard, self.blocks = self.revolutions, Blocks(self.scene.layout, self.figures, repetition.period)
            self.turns, self.settled = 0, False
            return Decision.BEGIN_WINDOW
        if self.blocks.record(work):
            self.interval = self.blocks.interval(self.figure)
        is_narrow = self.interval.within(self.relative)
        if self.blocks.period:
            has_whole_periods = turns % self.blocks.period == 0 and self.interval.blocks >= MIN_REPEATS
            self.settled = is_narrow and has_whole_periods and repetition is not None
        else:
            self.settled = is_narrow and self.interval.revolutions >= MIN_REVOLUTIONS
        return Decision.END if self.settled and self.revolutions >= self.shortest else Decision.CONTINUE

    def take_snapshot(self, work: Work) -> None:
        """Take a snapshot, from which the saved revolutions can be repeated."""
        self.snapshots.append(snapshot_of(work))

    def _leaves_room_for(self, period: int) -> bool:
        """Return whether the longest run has enough periods left for a window of periodic motion."""
        return self.revolutions + (MIN_REPEATS + 1) * period <= self.longest


class ConvergenceObserver(WindowLength):
    """Ends a run when its figure has converged."""

    per_revolution = 1

    def __init__(self, scene: Scene, marks: Marks):
        """Prepare for a run of `scene` with these marks."""
        until = until_of(scene.case.simulate)
        accuracy = until.figure, until.relative_ci
        super().__init__(scene, marks, (until.figure,), accuracy, max_revolutions(scene.case.simulate))

    def observe(self, work: Work) -> Decision:
        """Return the decision at a revolution."""
        return self.decide(work)

    def results(self) -> dict[str, float | None]:
        """Return the results as columns of the summary."""
        return {
            "revolutions_run": self.revolutions,
            "window_from": self.discard,
            "figure_ci": self.interval.half_width if math.isfinite(self.interval.half_width) else None,
            "settled": int(self.settled),
        }


def max_revolutions(settings: Simulate) -> float:
    """Return the largest number of revolutions that `until` allows: `discard` plus whole ones."""
    return with_whole_revolutions(settings.discard, until_of(settings).max_revolutions)


def until_of(settings: Simulate) -> case.Until:
    """Return the criterion `until` of a case that has one."""
    assert settings.until is not None
    return settings.until
