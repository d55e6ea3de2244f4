"""Effect of uncertain wear coefficients on the computed life.

The life is computed twice more, with all coefficients at the lower or at the upper end of their 95 % intervals.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ...answers.validity import LIFE_FAILED
from ...contracts.case import Case
from ...language import phases
from .extrapolation import Life, extrapolate_life
from .life import LifeRun
from .life_block import BlockRecord, WornJoint

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
            lives[end] = BoundingLife(
                extrapolate_life(_repeated(_scaled(life_run, case)), life_run, life_run.settings(), life_run.start), ()
            )
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
            factors[elements] = _ratio(life_run.scene.case, case, worn, body)
    return record._replace(rate=record.rate * factors, width=record.width * factors)


def _ratio(case: Case, other_case: Case, worn: WornJoint, body: str) -> float:
    """Return the ratio of a body's wear coefficients in two cases; 1 if it does not wear."""
    coefficient, other_coefficient = (_coefficient(of_case, worn, body) for of_case in (case, other_case))
    return other_coefficient / coefficient if coefficient else 1.0


def _coefficient(case: Case, worn: WornJoint, body: str) -> float:
    """Return the wear coefficient of a body, in the unit of the grid."""
    wear = case.joints[worn.joint_index].wear
    assert wear is not None  # asked of joints that wear
    return wear.values[f"{body}_coefficient"]


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
    lives_by_side = {"low": lives[HIGH].life, "high": lives[LOW].life}
    revolutions_at = {
        end: life.revolutions if life and life.reached else math.nan for end, life in lives_by_side.items()
    }
    return {
        f"{column}_life_{end}_uncertain": life_turns if math.isfinite(life_turns) else None
        for end, life_turns in revolutions_at.items()
    }
