"""A block of revolutions of a life: its length, and the wear rates that follow from it."""

import io
import math
import zipfile
from collections.abc import Sequence
from typing import Any, NamedTuple, Protocol

import numpy as np

from ...contracts.case import Case
from ...mechanics.machines.contract import body_angles
from ...mechanics.solver.integration import Work
from ...mechanics.wear import MAX_BINS, SLIDING_DISTANCE
from ..figures.batch_means import Blocks
from ..figures.sums import half_width
from ..figures.window import by_joint
from ..running.observed_run import Decision
from ..running.run import Run
from ..setup.revolutions import Marks, with_whole_revolutions
from ..setup.scene import Scene
from .until import WindowLength

PHASES = 24  # phases of a revolution at which relative body angles are recorded


class WornJoint(NamedTuple):
    """A joint with wear, and its elements of the worn state."""

    joint_index: int
    name: str
    column: str
    bins: int  # of each body
    first: int  # first bin of the bearing; the journal's bins follow
    sliding_distance: int  # m, sliding distance

    @property
    def bearing(self) -> slice:
        """Return the elements that are depths (m) of the bearing."""
        return slice(self.first, self.first + self.bins)

    @property
    def journal(self) -> slice:
        """Return the elements that are depths (m) of the journal."""
        return slice(self.first + self.bins, self.first + 2 * self.bins)

    @property
    def all_bins(self) -> slice:
        """Return the elements that are depths (m) of both bodies."""
        return slice(self.first, self.first + 2 * self.bins)


def worn_joints_of(case: Case) -> tuple[WornJoint, ...]:
    """Return the joints with wear; the worn state is the bins of all, their sliding distances, then the time."""
    joints_with_wear = [(index, joint, joint.wear) for index, joint in enumerate(case.joints) if joint.wear]
    bins = [min(wear.bins, MAX_BINS) for *_, wear in joints_with_wear]
    first_bins = [2 * sum(bins[:k]) for k in range(len(bins))]
    return tuple(
        WornJoint(index, joint.name, joint.column, bins[k], first_bins[k], 2 * sum(bins) + k)
        for k, (index, joint, _) in enumerate(joints_with_wear)
    )


class BlockRecord(NamedTuple):
    """Result of a block of revolutions; n elements: depths (m) of all bins, sliding distances (m), the time (s)."""

    rate: np.ndarray  # (n,) per revolution
    width: np.ndarray  # (n,) half-width of their 95 % interval, inf where unknown
    force_peak: np.ndarray  # (joints,) N
    turned: np.ndarray  # (PHASES, joints) rad, body angle of the journal minus that of the bearing over a revolution
    counts: np.ndarray  # see solver.integration
    seconds: np.ndarray  # (2,) s: integration time, and total processor time so far
    turns: float  # revolutions whose mean the rates are
    life: int = 0  # index of the life: 0 for the case's own


class RateObserver(WindowLength):
    """Ends a block when the wear rate of the limited joint is accurate enough."""

    per_revolution = PHASES

    def __init__(self, scene: Scene, marks: Marks):
        """Prepare for a block of `scene`, a run with these marks."""
        case = scene.case
        assert case.life is not None  # asked of cases that have one
        rates = [wear_rate_column(worn.column) for worn in worn_joints_of(case)]
        super().__init__(
            scene, marks, rates, (wear_rate_column(case.life.column), case.life.tolerance), longest_block(case)
        )
        self.phase = 0
        self.mechanism, self.sides = scene.value.mechanism, [joint.side for joint in scene.value.joints]
        self.relative_angles: list[list[float]] = []

    def observe(self, work: Work) -> Decision:
        """Record the angles of the bodies over the first revolution; return the decision at the end of every one."""
        if len(self.relative_angles) < PHASES:
            angles = body_angles(self.mechanism, work.y)
            self.relative_angles.append(
                [
                    side * (journal_angle - bearing_angle)
                    for side, (bearing_angle, journal_angle) in zip(self.sides, angles, strict=True)
                ]
            )
        phase, self.phase = self.phase, (self.phase + 1) % PHASES
        if phase:
            return Decision.CONTINUE
        decision = self.decide(work)
        if decision == Decision.BEGIN_WINDOW:
            self.phase = 0
        return decision


def wear_rate_column(joint: str) -> str:
    """Return the column of a joint's wear rate."""
    return f"{joint}_wear_rate_max"


def longest_block(case: Case) -> float:
    """Return the largest number of revolutions of a block: `discard` plus whole ones."""
    assert case.life is not None
    return with_whole_revolutions(case.simulate.discard, case.life.max_revolutions)


def block_record_of(scene: Scene, run: Run, observer: RateObserver, process_time: float) -> BlockRecord:
    """Return the result of a finished block; `process_time`: s, total processor time so far."""
    worn_joints = worn_joints_of(scene.case)
    turns = observer.revolutions - observer.discard
    contact_totals: Any = run.totals  # mypy takes it for a tuple of anything
    totals = by_joint(contact_totals, scene.layout)
    depths = totals.wear.reshape(len(scene.layout.joints), 2, -1)
    rate, width = np.zeros(worn_joints[-1].sliding_distance + 2), np.zeros(worn_joints[-1].sliding_distance + 2)
    rate[-1] = (float(run.work.end[run.work.time]) - float(contact_totals.mechanism.window_start)) / turns
    for worn in worn_joints:
        rate[worn.all_bins] = depths[worn.joint_index, :, : worn.bins].ravel() / turns
        earlier_sliding = scene.worn[worn.name].sliding_distance
        rate[worn.sliding_distance] = (totals.account[worn.joint_index, SLIDING_DISTANCE] - earlier_sliding) / turns
        width[worn.all_bins] = _half_widths(observer.blocks, worn) * rate[-1]
    peaks = np.array(totals.joint.column("force_max"))
    seconds = np.array([run.duration, process_time])
    return BlockRecord(
        rate, width, peaks, np.array(observer.relative_angles), run.counts.numbers.copy(), seconds, turns
    )


def _half_widths(blocks: Blocks, worn: WornJoint) -> np.ndarray:
    """Return the half-widths of the 95 % intervals of bin wear rates (m/s); inf for fewer than two blocks."""
    widths = np.full(2 * worn.bins, math.inf)
    if len(blocks.sums_at_ends) > 2:
        figure = wear_rate_column(worn.column)
        depths = np.array([sums[figure].reshape(2, -1)[:, : worn.bins].ravel() for _, sums in blocks.sums_at_ends])
        rates = np.diff(depths, axis=0) / np.diff([time for time, _ in blocks.sums_at_ends])[:, None]
        has_worn = rates.any(axis=0)
        widths[:] = 0.0
        widths[has_worn] = [half_width(bin_rates) for bin_rates in rates.T[has_worn]]
    return widths


class Log(Protocol):
    """Storage for the block results of a case until it is finished."""

    def read(self) -> bytes | None:
        """Return the stored content, or None if there is none."""

    def keep(self, content: bytes) -> None:
        """Replace the stored content."""


def encoded(records: Sequence[BlockRecord]) -> bytes:
    """Return the results of blocks as bytes; `read` restores them to the last bit."""
    content = io.BytesIO()
    arrays: dict[str, Any] = {
        name: np.array([getattr(record, name) for record in records]) for name in BlockRecord._fields
    }
    np.savez(content, **arrays)
    return content.getvalue()


def decoded(content: bytes | None, size: int) -> list[BlockRecord]:
    """Return the results stored by `encoded`, for vectors of this size; [] for any other content."""
    if content is None:
        return []
    try:
        with np.load(io.BytesIO(content), allow_pickle=False) as file:
            arrays = [file[name] for name in BlockRecord._fields]
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile):
        return []
    return [BlockRecord(*row) for row in zip(*arrays, strict=True)] if arrays[0].shape[1:] == (size,) else []
