"""Computes the life of a case: wear is extrapolated from blocks of revolutions, each run in a worn state.

Every block starts as the case does, `discard` included, and not from the end of the last block. Between the two blocks
the surfaces have moved by more than a penetration, so the old contacts no longer apply. Thus a block is a function of
the worn state alone, and the errors of blocks are independent. A life that was killed is resumed from the results of
its blocks, with the same end.
"""

import dataclasses
import io
import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple, Protocol

import numpy as np

from ...answers.validity import LIFE_FAILED, LIFE_UNREACHED, conformal_remark
from ...contracts.case import Case
from ...language import phases
from ...language.wording import count_text
from ...mechanics.joints import registry
from ...mechanics.machines.contract import body_angles
from ...mechanics.solver.integration import Work
from ...mechanics.wear import MAX_BINS, Account, Worn
from ..figures.catalogue import MIN_REVOLUTIONS, Blocks
from ..figures.sums import half_width
from ..figures.window import by_joint, interpolated_depths
from ..machine.ideal import Touch, first_touch, first_touch_in_slot
from ..running.observed_run import Decision, LifeLimits
from ..running.observed_run import Life as LifePhase
from ..running.run import Run
from ..setup.scene import Scene, build
from ..setup.start import Marks
from .extrapolation import Life, StepControl, extrapolate_life
from .repeated import WindowLength, longest_run

# A block of revolutions of a life: its length, and the wear rates that follow from it.

PHASES = 24  # phases of a revolution at which relative body angles are recorded
LOOK_RATIO = 1.1  # of successive lengths at which irregular motion may end: sooner or later chance makes it narrow


class WornJoint(NamedTuple):
    """A joint with wear, and its elements of the worn state."""

    joint_index: int
    name: str
    column: str
    bins: int  # of each body
    bearing: slice  # elements that are depths (m) of the bearing
    journal: slice  # those of the journal, which follow
    all_bins: slice  # those of both bodies
    sliding_distance: int  # m, sliding distance


def worn_joints_of(case: Case) -> tuple[WornJoint, ...]:
    """Return the joints with wear; the worn state is the bins of all, their sliding distances, then the time."""
    joints_with_wear = [(index, joint, joint.wear) for index, joint in enumerate(case.joints) if joint.wear]
    bins = [min(wear.bins, MAX_BINS) for *_, wear in joints_with_wear]
    worn_joints, first = [], 0
    for k, (index, joint, _) in enumerate(joints_with_wear):
        middle, end = first + bins[k], first + 2 * bins[k]
        elements = slice(first, middle), slice(middle, end), slice(first, end)
        worn_joints.append(WornJoint(index, joint.name, joint.column, bins[k], *elements, 2 * sum(bins) + k))
        first = end
    return tuple(worn_joints)


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
            scene, marks, rates, (wear_rate_column(case.life.column), case.life.tolerance), longest_run(case)
        )
        self.next_look = float(MIN_REVOLUTIONS)
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
            if len(self.relative_angles) == PHASES:
                self.per_revolution = 1
            if len(self.relative_angles) > 1:
                return Decision.CONTINUE
        decision = super().observe(work)
        if self.turns > self.next_look:
            self.next_look *= LOOK_RATIO
        elif decision == Decision.END and not self.blocks.period:
            return Decision.CONTINUE
        return decision


def wear_rate_column(joint: str) -> str:
    """Return the column of a joint's wear rate."""
    return f"{joint}_wear_rate_max"


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
        rate[worn.sliding_distance] = (
            Account(totals.account[worn.joint_index]).sliding_distance - earlier_sliding
        ) / turns
        width[worn.all_bins] = _half_widths(observer.blocks, worn) * rate[-1]
    peaks = np.array(totals.joint.column("force_max"))
    seconds, angles = np.array([run.duration, process_time]), np.array(observer.relative_angles)
    return BlockRecord(rate, width, peaks, angles, run.counts.numbers.copy(), seconds, turns)


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
        widths[np.argmax(depths[-1] - depths[0])] = blocks.interval(figure).half_width
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
    import zipfile  # loads all compressions

    if content is None:
        return []
    try:
        with np.load(io.BytesIO(content), allow_pickle=False) as file:
            arrays = [file[name] for name in BlockRecord._fields]
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile):
        return []
    return [BlockRecord(*row) for row in zip(*arrays, strict=True)] if arrays[0].shape[1:] == (size,) else []


FIRST_WEAR = 0.02  # of the smallest clearance: most wear in the first jump
MAX_SMOOTHING_WIDTH = math.radians(14.5)  # that of a scar 0.25 clearances deep, up to which lives err by at most 3 %
BOUNDING_LIVES = 2  # further lives of a case with uncertain wear coefficients
FIRST_SLIDING = 0.1  # of the running-in distance: most sliding in the first jump
HOUR = 3600.0  # s


class LifeRun:
    """Wear of a case: the worn state, a vector; the blocks that give its rates; the figures of its life."""

    def __init__(self, scene: Scene, log: Log | None, life_index: int = 0, name: str = ""):
        """Prepare for the unworn scene; `log` stores the results of blocks.

        life_index : index among the lives of the case, 0 for its own.  They share a log and are run one by one.
        name : name of a further life, for progress messages
        """
        assert scene.case.life is not None  # only for cases with a life
        self.scene, self.log, self.life, self.worn_joints = scene, log, scene.case.life, worn_joints_of(scene.case)
        self.size = self.worn_joints[-1].sliding_distance + 2
        self.life_index = self.last_life_index = life_index
        self.failure = ""  # status of a block that failed
        stored_blocks = decoded(log.read() if log else None, self.size)
        self.records_of_earlier_lives = [record for record in stored_blocks if record.life < life_index]
        self.records = [record for record in stored_blocks if record.life == life_index]
        self.blocks_requested = 0  # blocks requested in this process
        self.conformal_joint: WornJoint | None = None  # whose surfaces fit each other too closely
        #: Processor time (s) of earlier processes.
        self.seconds_before = float(stored_blocks[-1].seconds[1]) if stored_blocks else 0.0
        self.start = np.zeros(self.size)
        self.target = next(worn for worn in self.worn_joints if worn.name == self.life.joint)
        most_wear = FIRST_WEAR * min(joint.clearance for joint in scene.case.joints)
        blocks, turns = self.life.blocks, scene.case.simulate.revolutions
        limits = LifeLimits(self.life.limit, most_wear, blocks, turns, self.constant_rates)
        if scene.case.uncertain and not self.constant_rates:  # else one block also gives the further lives
            limits = limits._replace(further_lives=BOUNDING_LIVES - life_index)
        self.progress = LifePhase(limits, len(self.records), name)

    def bounding(self, case: Case, name: str) -> "LifeRun":
        """Return the LifeRun of another case as the next life, with the processor time and log of this one."""
        self.last_life_index += 1
        scene = dataclasses.replace(build(case), deadline=self.scene.deadline, verdict=self.scene.verdict)
        bounding_run = LifeRun(scene, self.log, self.last_life_index, name)
        bounding_run.seconds_before = self.seconds_before
        return bounding_run

    @property
    def identical_blocks(self) -> bool:
        """Return whether the motion is independent of wear."""
        return not any(joint.wear.evolve for joint in self.scene.case.joints if joint.wear)

    @property
    def constant_rates(self) -> bool:
        """Return whether the wear rates are independent of wear."""
        return self.identical_blocks and not any(
            joint.wear.running_in for joint in self.scene.case.joints if joint.wear
        )

    def settings(self) -> StepControl:
        """Return limit and step control of the extrapolation."""
        case, life, first_growth = self.scene.case, self.life, np.full(self.size, math.inf)
        for worn in self.worn_joints:
            first_growth[worn.all_bins] = FIRST_WEAR * min(joint.clearance for joint in case.joints)
            wear = case.joints[worn.joint_index].wear
            if wear and wear.running_in:
                first_growth[worn.sliding_distance] = FIRST_SLIDING * wear.running_in["distance"]
        return StepControl(
            limit=life.limit,
            tolerance=life.tolerance,
            blocks=life.blocks,
            min_jump=case.simulate.revolutions - case.simulate.discard,
            max_jump=life.longest_jump,
            max_first_growth=first_growth,
            groups=tuple(worn.all_bins for worn in self.worn_joints),
            constant_rates=self.constant_rates,
            identical_blocks=self.identical_blocks,
            drifting_rates=any(joint.wear.running_in for joint in case.joints if joint.wear),
        )

    def scene_at(self, state: np.ndarray) -> Scene:
        """Return the scene in a worn state."""
        scene = build(self.scene.case, {worn.name: self._worn(worn, state) for worn in self.worn_joints})
        return dataclasses.replace(
            scene, deadline=self.scene.deadline, keep_events=self.scene.keep_events, verdict=self.scene.verdict
        )

    @staticmethod
    def _worn(worn: WornJoint, state: np.ndarray) -> Worn:
        """Return the wear of a joint in a worn state."""
        return Worn(state[worn.bearing], state[worn.journal], state[worn.sliding_distance])

    def keep(self, record: BlockRecord, state: np.ndarray) -> None:
        """Append the result of a block, run in the worn state `state`, to the log."""
        self.records.append(record._replace(life=self.life_index))
        self.progress.reached(self.value(state))
        self.blocks_requested += 1
        if self.log:
            self.log.keep(encoded([*self.records_of_earlier_lives, *self.records]))

    def logged(
        self, run_block: Callable[["LifeRun", np.ndarray], BlockRecord | None]
    ) -> Callable[[np.ndarray], BlockRecord | None]:
        """Return a function that runs the next block by `run_block` and logs it, or reads it from the log."""

        def measure(state: np.ndarray) -> BlockRecord | None:
            if self.blocks_requested < len(self.records):  # run by an earlier process
                self.blocks_requested += 1
                self.progress.reached(self.value(state))
                return self.records[self.blocks_requested - 1]
            record = run_block(self, state)
            if record:
                self.keep(record, state)
            return record

        return measure

    def first_touch_at(self, worn: WornJoint, state: np.ndarray) -> Touch:
        """Return the largest eccentricity of a joint before its surfaces touch."""
        joint = self.scene.case.joints[worn.joint_index]
        relative_angles = self.records[0].turned[:, worn.joint_index]
        if joint.flanked:  # teeth meet at the same places of their path of contact
            depths = state[worn.bearing] + state[worn.journal]
            return Touch(float(depths.max()), int(np.argmax(depths)), int(np.argmax(depths)), 1.0)
        if joint.slot_length is not None:
            return first_touch_in_slot(state[worn.bearing], state[worn.journal])
        return first_touch(joint.clearance, state[worn.bearing], state[worn.journal], relative_angles)

    def value(self, state: np.ndarray) -> float:
        """Return the limited quantity (m) of a worn state."""
        if self.life.of == "clearance_growth":
            return self.first_touch_at(self.target, state).growth
        return float(state[self.target.all_bins].max())

    def slope(self, state: np.ndarray) -> np.ndarray:
        """Return the derivatives (n,) of the limited quantity."""
        slope, worn = np.zeros(self.size), self.target
        if self.life.of == "clearance_growth":
            touch = self.first_touch_at(worn, state)
            slope[[worn.bearing.start + touch.bearing_bin, worn.journal.start + touch.journal_bin]] = (
                touch.growth_per_depth
            )
        else:
            slope[worn.all_bins.start + int(np.argmax(state[worn.all_bins]))] = 1.0
        return slope

    def shape_error(self, state: np.ndarray) -> float:
        """Return the error (m) of the limited quantity: how much smoothing, or bins twice as wide, change it."""
        wear = self._worn(self.target, state)
        acting = registry.acting_wear(self.scene.case.joints[self.target.joint_index], wear)
        if acting is None:
            return 0.0
        value, changed = self.value(state), []
        coarse = [
            0.25 * np.roll(depths, 1) + 0.5 * depths + 0.25 * np.roll(depths, -1)
            for depths in (wear.bearing, wear.journal)
        ]
        for bearing, journal in (acting[:2], coarse):
            other = state.copy()
            other[self.target.bearing], other[self.target.journal] = bearing, journal
            changed.append(abs(self.value(other) - value))
        return math.fsum(changed)

    def is_valid(self, state: np.ndarray) -> bool:
        """Return whether contact at one point can represent all worn surfaces."""
        joints = self.scene.case.joints
        widths = (
            (worn, registry.smoothing_width(joints[worn.joint_index], self._worn(worn, state)))
            for worn in self.worn_joints
        )
        conformal = (worn for worn, width in widths if width is not None and width > MAX_SMOOTHING_WIDTH)
        self.conformal_joint = next(conformal, None)
        return self.conformal_joint is None

    def with_last_block(self, life: Life, record: BlockRecord) -> Life:
        """Return a life with the block of its last node's worn state."""
        last_node = life.nodes[-1]._replace(rate=record.rate, block=record)
        return life._replace(nodes=(*life.nodes[:-1], last_node), blocks=life.blocks + 1)

    def figures(self, life: Life) -> dict[str, float | int | None]:
        """Return the figures of a life, by column of the summary."""
        last_node, target = life.nodes[-1], self.target.column
        hours = last_node.state[-1] / HOUR
        numbers = {
            f"{target}_life_revolutions": life.known_revolutions,
            f"{target}_life_hours": hours if life.reached else life.known_revolutions,
            f"{target}_life_low": life.low,
            f"{target}_life_low_hours": hours * (life.low / life.revolutions) if life.revolutions else life.low,
            f"{target}_life_high": life.high if life.unlimited or math.isfinite(life.high) else math.nan,
            f"{target}_life_jump_error": life.jump_error,
            f"{target}_life_shape_error": life.shape_error,
        }
        numbers |= {
            f"{worn.column}_clearance_growth": self.first_touch_at(worn, last_node.state).growth
            for worn in self.worn_joints
        }
        figures: dict[str, float | int | None] = {
            name: None if math.isnan(value) else float(value) for name, value in numbers.items()
        }
        return figures | {f"{target}_life_blocks": life.blocks}

    def reason_unreached(self, life: Life) -> str:
        """Return why a life did not reach its limit, or '' if it did."""
        if life.reached:
            return ""
        if worn := self.conformal_joint:
            joint, last_state = self.scene.case.joints[worn.joint_index], life.nodes[-1].state
            return conformal_remark(joint, float(last_state[worn.all_bins].max()), life.revolutions)
        if life.unlimited:
            return f"{LIFE_UNREACHED}{self.life.joint} has no wear, so it never reaches life.limit"
        return (
            f"{LIFE_UNREACHED}{self.life.joint} does not reach life.limit in {life.revolutions:.6g} revolutions, after "
            f"{count_text(life.blocks, 'block')}; increase life.blocks, or life.tolerance for longer jumps"
        )

    def history(self, life: Life) -> dict[str, np.ndarray]:
        """Return the history of a life: dataset below `history/` -> values by node."""
        nodes, layouts = life.nodes, self.scene.layout.joints
        columns = {"revolutions": np.array([node.revolutions for node in nodes])}
        for worn in self.worn_joints:
            clearance, bins = self.scene.case.joints[worn.joint_index].clearance, layouts[worn.joint_index].wear_bins
            values: dict[str, list] = {
                "wear_depth_max": [node.state[worn.all_bins].max() for node in nodes],
                "clearance": [clearance + self.first_touch_at(worn, node.state).growth for node in nodes],
                "force_peak": [node.block.force_peak[worn.joint_index] for node in nodes],
                "wear_rate": [node.rate[worn.all_bins].max() / node.rate[-1] for node in nodes],
            }
            for body, elements in (("bearing", worn.bearing), ("journal", worn.journal)):
                profiles = [node.state[elements] for node in nodes]
                values[f"profile_{body}"] = [
                    profile if bins == worn.bins else interpolated_depths(profile, bins) for profile in profiles
                ]
            columns |= {f"{worn.column}/{name}": np.array(each) for name, each in values.items()}
        return columns


# Effect of uncertain wear coefficients on the computed life.
#
# The life is computed twice more, with all coefficients at the lower or at the upper end of their 95 % intervals.

LOW, HIGH = "low", "high"


class BoundingLife(NamedTuple):
    """A life with all wear coefficients at one end of their intervals."""

    life: Life | None  # None: a block of it failed
    records: tuple[BlockRecord, ...]  # blocks run for it
    failure: str = ""  # status of the block that failed


def with_bounding_coefficients(case: Case, end: str) -> Case:
    """Return a case whose uncertain wear coefficients are all at one end of their 95 % intervals, LOW or HIGH."""
    joints = {joint.name: joint for joint in case.joints}
    for coefficient in case.uncertain:
        joint, value = joints[coefficient.joint], getattr(coefficient, end)
        assert joint.wear is not None  # grids accept uncertain coefficients only for joints with wear
        known = joint.wear.values  # a body that does not wear stays so
        values = {
            key: known[key] * value if coefficient.relative else value for key in coefficient.keys if known[key] > 0.0
        }
        joints[coefficient.joint] = joint._replace(wear=joint.wear._replace(values={**joint.wear.values, **values}))
    return case._replace(joints=tuple(joints.values()))


def further_lives(
    life_run: LifeRun, run_block: Callable[[LifeRun, np.ndarray], BlockRecord | None]
) -> dict[str, BoundingLife]:
    """Return the lives with the coefficients at their LOW and HIGH ends.

    If wear rates are independent of wear, every rate is proportional to the coefficient of its body, so
    that one block gives both lives; otherwise each is run block by block.

    Parameters
    ----------
    life_run : LifeRun of the case itself, whose life is known.
    run_block : (LifeRun, (n,) worn state) -> block, or None if it failed.
    """
    lives = {}
    for end in (LOW, HIGH):
        case = with_bounding_coefficients(life_run.scene.case, end)
        if life_run.constant_rates:
            run_once, settings = _repeated(_scaled(life_run, case)), life_run.settings()
            lives[end] = BoundingLife(extrapolate_life(run_once, life_run, settings, life_run.start), ())
            continue
        bounding_run = life_run.bounding(case, f"life with the wear coefficients at their {end} ends")
        with phases.phase(bounding_run.progress):
            life = extrapolate_life(
                bounding_run.logged(run_block), bounding_run, bounding_run.settings(), bounding_run.start
            )
        lives[end] = BoundingLife(life, tuple(bounding_run.records), bounding_run.failure)
    return lives


def _repeated(record: BlockRecord) -> Callable[[np.ndarray], BlockRecord]:
    """Return a function that repeats the result of one block, for motion that is independent of wear."""
    return lambda state: record


def _scaled(life_run: LifeRun, case: Case) -> BlockRecord:
    """Return the result of a block with its rates scaled to the wear coefficients of another case."""
    record = life_run.records[0]
    factors = np.ones(life_run.size)
    for worn in life_run.worn_joints:
        for body, elements in (("bearing", worn.bearing), ("journal", worn.journal)):
            wears = [of_case.joints[worn.joint_index].wear for of_case in (life_run.scene.case, case)]
            own, other = (wear.values[f"{body}_coefficient"] for wear in wears if wear)
            factors[elements] = other / own if own else 1.0
    return record._replace(rate=record.rate * factors, width=record.width * factors)


def failures(lives: dict[str, BoundingLife]) -> tuple[str, ...]:
    """Return a remark for each life with a failed block, whose column is null."""
    return tuple(
        f"{LIFE_FAILED}the life with the wear coefficients at their {end} ends is not known: its block "
        f"{len(life.records) + 1} has the status {life.failure}"
        for end, life in lives.items()
        if life.failure
    )


def figures(column: str, lives: dict[str, BoundingLife]) -> dict[str, float | None]:
    """Return both ends of a joint's life by column, with None for unknown ones; more wear means a shorter life."""
    sides = {"low": lives[HIGH].life, "high": lives[LOW].life}
    turns = {end: life.known_revolutions if life else math.nan for end, life in sides.items()}
    return {f"{column}_life_{end}_uncertain": None if math.isnan(each) else each for end, each in turns.items()}
