"""Decides whether a run is long enough: its figure has converged, or its motion is periodic."""

import math
from collections import deque
from collections.abc import Callable

import numpy as np

from ..contracts import case
from ..contracts.case import Simulate
from ..mechanics.solver.integration import Work
from .batch_means import Blocks, Interval
from .observed_run import Snapshot, pause_at, snapshot_of
from .revolutions import period_of, with_whole_revolutions
from .scene import Scene


def pauses(settings: Simulate, value_after: Callable[[float], float]) -> np.ndarray:
    """Return the pauses: one per revolution, at a fixed crank angle, up to the longest run."""
    count = math.ceil(max_revolutions(settings) - settings.discard - 1e-9)
    return np.array([pause_at(k, settings.discard, value_after) for k in range(1, count + 1)])


class ConvergenceObserver:
    """Ends a run when its figure has converged or its motion is periodic."""

    per_revolution = 1

    def __init__(self, scene: Scene, samples: np.ndarray):
        """Prepare for a run of `scene` that stores its time histories at the `pauses` in `samples`."""
        settings, save, until = scene.case.simulate, scene.case.save, until_of(scene.case.simulate)
        self.figure, self.relative = until.figure, until.relative_ci
        self.blocks = Blocks(scene.layout, (self.figure,))
        self.discard, self.min_revolutions = settings.discard, settings.revolutions
        self.samples, self.columns, self.units = samples, *_journal_channels(scene)
        # snapshots, oldest first, from which the saved revolutions can be repeated
        self.snapshots: deque[Snapshot] = deque(maxlen=math.ceil(save.revolutions) + 1 if save.orbits == "last" else 1)
        self.revolutions, self.settled = 0.0, False
        self.period: int | None = None  # revolutions
        self.interval: Interval | None = None

    def observe(self, work: Work) -> bool:
        """Return whether the run may end with this revolution."""
        turns = self.blocks.turns
        self.revolutions = self.discard + turns
        self.snapshots.append(snapshot_of(work))
        if self.blocks.record(work) or self.interval is None:
            self.interval = self.blocks.interval(self.figure)
        self.period = period_of(self.samples[:turns, self.columns] / self.units)
        self.settled = self.period is not None or self.interval.within(self.relative)
        return turns > 0 and self.settled and self.revolutions >= self.min_revolutions

    def figures(self) -> dict[str, float | None]:
        """Return the results as columns of the summary."""
        width = self.interval.half_width if self.interval and math.isfinite(self.interval.half_width) else None
        return {
            "revolutions_run": self.revolutions,
            "period": self.period,
            "figure_ci": width,
            "settled": int(self.settled),
        }


def _journal_channels(scene: Scene) -> tuple[list[int], np.ndarray]:
    """Return the channels of journal positions and velocities, and the unit of each."""
    names = [channel.name for channel in scene.layout.channels]
    columns: list[int] = []
    units: list[float] = []
    for joint_layout, joint in zip(scene.layout.joints, scene.value.joints, strict=True):
        columns += [names.index(f"joints/{joint_layout.name}/{name}") for name in ("x", "y", "vx", "vy")]
        units += [joint.clearance] * 2 + [joint.clearance * scene.value.reference_rate] * 2
    return columns, np.array(units)


def max_revolutions(settings: Simulate) -> float:
    """Return the largest number of revolutions that `until` allows: `discard` plus whole ones."""
    return with_whole_revolutions(settings.discard, until_of(settings).max_revolutions)


def until_of(settings: Simulate) -> case.Until:
    """Return the criterion `until` of a case that has one."""
    assert settings.until is not None
    return settings.until
