"""A joint with prescribed relative motion, without a mechanism, and the wear computed by its kernels."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from clearsweep.mechanics.observe import (
    DEPTH_ROW,
    FORCE_ROW,
    FRICTION_POWER_ROW,
    KAPPA_ROW,
    PARTS,
    QUARTER_POINTS,
    SLIP_ROW,
    STATE_POINTS,
    STEP_VALUE_ROWS,
)
from clearsweep.mechanics.wear import ACCOUNT_SIZE, Account, Bins, JointAccount
from clearsweep.mechanics.wear.arc import WORKSPACE_SIZE, accumulate_distance, workspace_of
from clearsweep.mechanics.wear.bins import (
    POSITIONS,
    SLOPES,
    AxialRows,
    Step,
    StripRows,
    fit_positions,
    fit_profiles,
    update_worn_profile,
)


class History(NamedTuple):
    """Functions of the time (s) over a duration."""

    duration: float  # s
    load: Callable  # N, normal force
    slip: Callable  # m/s, sliding speed
    depth: Callable  # m, penetration
    work: Callable  # W, dissipated by friction
    on_bearing: Callable  # rad, contact angle in the frame of the body
    on_journal: Callable  # rad


def steady(duration, load, slip, depth, work, angle) -> History:
    """Return the History with constant values."""
    constants = (lambda t, value=value: value + 0.0 * t for value in (load, slip, depth, work, angle, angle))
    return History(duration, *constants)


def _step_of(history, begin, length, workspace):
    """Return the Step of a History that starts at `begin` (s)."""
    step_values, positions = np.zeros((1, STEP_VALUE_ROWS, PARTS + 1)), np.zeros((1, POSITIONS + SLOPES, STATE_POINTS))
    even = begin + length * np.arange(PARTS + 1) / PARTS
    quarters = begin + length * np.arange(QUARTER_POINTS + 2) / (QUARTER_POINTS + 1)
    step_values[0, KAPPA_ROW] = 1.0
    rows = (FORCE_ROW, SLIP_ROW, DEPTH_ROW, FRICTION_POWER_ROW)
    for row, function in zip(rows, (history.load, history.slip, history.depth, history.work), strict=True):
        step_values[0, row] = function(even)
    for row, angle in enumerate((history.on_bearing, history.on_journal)):
        positions[0, row, : QUARTER_POINTS + 2] = angle(quarters)
        ends, nearby = quarters[[0, -1]], 1e-3 * length
        slopes = length * (angle(ends + nearby) - angle(ends - nearby)) / (2.0 * nearby)
        positions[0, SLOPES + row, [0, QUARTER_POINTS + 1]] = slopes
    neighbour = (
        AxialRows(np.zeros((1, AxialRows.SIZE, STATE_POINTS))),
        StripRows(np.zeros((StripRows.SIZE, PARTS + 1))),
        workspace,
        np.zeros(0),
    )
    return Step(step_values, length, np.zeros(1), positions, *neighbour)


def worn_off(joint, history, steps=1):
    """Return the depths (m) of bearing and journal, the account, and the workspace of the last of `steps` steps."""
    law, account, workspace = joint.wear, Account(np.zeros(ACCOUNT_SIZE)), workspace_of(np.zeros(WORKSPACE_SIZE))
    count, length = int(law.bins), history.duration / steps
    depths = np.zeros(2 * count)
    for k in range(steps):
        step = _step_of(history, k * length, length, workspace)
        fit_profiles(step.workspace, step.step_values[0], law.length)
        fit_positions(step.workspace, step.positions[0])
        accumulate_distance(step, 0, account)
        bins = Bins(depths, 0, count), Bins(depths, count, count)
        update_worn_profile(joint, workspace, step.step_values[0], length, bins, JointAccount(account, 1.0))
    return depths[:count], depths[count:], account, workspace
