"""Computes the life of a case: wear is extrapolated from blocks of revolutions, each run in a worn state.

Every block starts as the case does, `discard` included, and not from the end of the last block. Between the two blocks
the surfaces have moved by more than a penetration, so the old contacts no longer apply. Thus a block is a function of
the worn state alone, and the errors of blocks are independent. A life that was killed is resumed from the results of
its blocks, with the same end.
"""

import dataclasses
import math
from collections.abc import Callable

import numpy as np

from ...answers.validity import LIFE_UNREACHED, ConformalJoint, conformal_remark
from ...contracts.case import Case
from ...language.wording import count_text
from ...mechanics.joints import registry
from ...mechanics.wear import Worn
from ..figures.window import interpolated_depths
from ..machine.first_touch import Touch, first_touch, first_touch_in_slot
from ..running.progress import Life as LifePhase
from ..running.progress import LifeLimits
from ..setup.scene import Scene, build
from .extrapolation import Life, Node, StepControl
from .life_block import BlockRecord, Log, WornJoint, decoded, encoded, worn_joints_of

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
        self.life_index, self.last_life_index, self.failure = (
            life_index,
            life_index,
            "",
        )  # status of a block that failed
        stored_blocks = decoded(log.read() if log else None, self.size)
        self.records_of_earlier_lives = [record for record in stored_blocks if record.life < life_index]
        self.records = [record for record in stored_blocks if record.life == life_index]
        self.blocks_requested = 0  # blocks requested in this process
        self.conformal_joint: WornJoint | None = None  # whose surfaces fit each other too closely
        self.seconds_before = (
            float(stored_blocks[-1].seconds[1]) if stored_blocks else 0.0
        )  # s, processor time of earlier processes
        self.start = np.zeros(self.size)
        self.target = next(worn for worn in self.worn_joints if worn.name == self.life.joint)
        most_wear = FIRST_WEAR * min(joint.clearance for joint in scene.case.joints)
        limits = LifeLimits(
            self.life.limit, most_wear, self.life.blocks, scene.case.simulate.revolutions, self.constant_rates
        )
        if (
            scene.case.uncertain and not self.constant_rates
        ):  # if rates are constant, one block also gives the further lives
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

    def next_stored_block(self, state: np.ndarray) -> BlockRecord | None:
        """Return the result of the next block from an earlier process, or None if it has not been run."""
        if self.blocks_requested == len(self.records):
            return None
        self.blocks_requested += 1
        self.progress.reached(self.value(state))
        return self.records[self.blocks_requested - 1]

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
            if (stored := self.next_stored_block(state)) is not None:
                return stored
            record = run_block(self, state)
            if record:
                self.keep(record, state)
            return record

        return measure

    def first_touch_at(self, worn: WornJoint, state: np.ndarray) -> Touch:
        """Return the largest eccentricity of a joint before its surfaces touch."""
        joint, relative_angles = (
            self.scene.case.joints[worn.joint_index],
            self.records[0].turned[:, worn.joint_index],
        )
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
            slope[worn.first + int(np.argmax(state[worn.all_bins]))] = 1.0
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
        self.conformal_joint = next((worn for worn in self.worn_joints if self._conforms(worn, state)), None)
        return self.conformal_joint is None

    def _conforms(self, worn: WornJoint, state: np.ndarray) -> bool:
        """Return whether the worn surfaces of a joint fit each other too closely for contact at one point."""
        width = registry.smoothing_width(self.scene.case.joints[worn.joint_index], self._worn(worn, state))
        return width is not None and width > MAX_SMOOTHING_WIDTH

    def with_last_block(self, life: Life, record: BlockRecord) -> Life:
        """Return a life with the block of its last node's worn state."""
        last_node = life.nodes[-1]._replace(rate=record.rate, block=record)
        return life._replace(nodes=(*life.nodes[:-1], last_node), blocks=life.blocks + 1)

    def figures(self, life: Life) -> dict[str, float | int | None]:
        """Return the figures of a life, by column of the summary."""
        last_node, target = life.nodes[-1], self.target.column
        numbers = {
            f"{target}_life_revolutions": life.revolutions if life.reached else math.nan,
            f"{target}_life_hours": last_node.state[-1] / HOUR if life.reached else math.nan,
            f"{target}_life_low": life.low,
            f"{target}_life_high": life.high,
            f"{target}_life_jump_error": life.jump_error,
            f"{target}_life_shape_error": life.shape_error,
        }
        numbers |= {
            f"{worn.column}_clearance_growth": self.first_touch_at(worn, last_node.state).growth
            for worn in self.worn_joints
        }
        figures: dict[str, float | int | None] = {
            name: float(value) if math.isfinite(value) else None for name, value in numbers.items()
        }
        return figures | {f"{target}_life_blocks": life.blocks}

    def remarks(self, life: Life) -> tuple[str, ...]:
        """Return the remark on why a life did not reach its limit, or '' if it did."""
        return (self._reason_unreached(life),)

    def _reason_unreached(self, life: Life) -> str:
        """Return why a life did not reach its limit, or '' if it did."""
        if life.reached:
            return ""
        if worn := self.conformal_joint:
            joint, last_state = self.scene.case.joints[worn.joint_index], life.nodes[-1].state
            assert joint.wear is not None  # only joints with wear
            depth, in_slot = float(last_state[worn.all_bins].max()), joint.slot_length is not None
            return conformal_remark(ConformalJoint(worn.name, joint.wear.pressure, in_slot, depth, life.revolutions))
        if life.revolutions == 0.0:
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
            columns |= {
                f"{worn.column}/{name}": np.array([self._node_values(worn, node)[name] for node in nodes])
                for name in ("wear_depth_max", "clearance", "force_peak", "wear_rate")
            }
            bins = layouts[worn.joint_index].wear_bins
            for body, elements in (("bearing", worn.bearing), ("journal", worn.journal)):
                profiles = [node.state[elements] for node in nodes]
                columns[f"{worn.column}/profile_{body}"] = np.array(
                    [profile if bins == worn.bins else interpolated_depths(profile, bins) for profile in profiles]
                )
        return columns

    def _node_values(self, worn: WornJoint, node: Node) -> dict[str, float]:
        """Return the values of a joint at a node of the history."""
        return {
            "wear_depth_max": float(node.state[worn.all_bins].max()),
            "clearance": self.scene.case.joints[worn.joint_index].clearance
            + self.first_touch_at(worn, node.state).growth,
            "force_peak": float(node.block.force_peak[worn.joint_index]),
            "wear_rate": float(node.rate[worn.all_bins].max() / node.rate[-1]),
        }
