"""Times and speeds at which the free crank of an ideal machine passes given angles."""

import math
from typing import NamedTuple

import numpy as np

from ....contracts.machine import Motor
from ...compiled.family import entry, flatten, invoke, shaped
from ..contract import accelerate, place

LONGEST = 30.0  # longest wait for a free crank, in times at its nominal speed
STEPS = 300  # for a turn of it
RTOL, ATOL = 1e-9, 1e-11  # tolerance of angle (rad) and of rate over the nominal rate
HALVINGS = 60  # most iterations; Newton's method needs five
CLOSE = 1e-13  # of a step: closer estimates are equal


def rates_entry(machine, y, rates, _):
    """Write the crank's rate (rad/s) and acceleration to `rates`; y : (3,) its angle (rad), rate, and time (s)."""
    here, state, out = machine[0], shaped(y, (3,)), shaped(rates, (2,))
    out[0], out[1] = state[1], accelerate(here, place(here, state), ()).accelerations[0]


class FreeMotion(NamedTuple):
    """Angle (rad) and rate (rad/s) of the crank over n steps, with the dense output of DOP853 in between."""

    times: np.ndarray  # (n + 1,) s
    states: np.ndarray  # (n + 1, 2)
    powers: np.ndarray  # (7, n, 2)

    def at(self, step: np.ndarray, share: np.ndarray) -> np.ndarray:
        """Return angle and rate (m, 2) at shares (m,) of steps."""
        values = np.zeros((len(step), 2))
        for k, power in enumerate(self.powers[::-1]):
            values += power[step]
            values *= (share if k % 2 == 0 else 1.0 - share)[:, None]
        return values + self.states[step]


class Passage:
    """The motion of a free crank until it passes the angle `end` (rad) or turns back for good."""

    def __init__(self, drive: Motor, machine: tuple, rate: float, end: float):
        """Integrate; machine : the compiled ideal machine; rate : rad/s, the nominal speed."""
        self.end = end
        self._course = _integrated(drive, machine, rate, end)
        self._reached = np.maximum.accumulate(self._course.states[:, 0])

    def at(self, angles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the times (s) at which the crank first passes angles (n,) rad, and its rates; nan if it never does."""
        motion, times = self._course, np.full((2, len(angles)), math.nan)
        step = np.searchsorted(self._reached, angles) - 1
        begun, passed = step < 0, (step >= 0) & (step < len(motion.times) - 1)
        times[:, begun] = np.array([[motion.times[0]], [motion.states[0, 1]]])
        step, wanted = step[passed], angles[passed]
        low, high = np.zeros(len(step)), np.ones(len(step))
        share, length = 0.5 * (low + high), np.diff(motion.times)[step]
        for _ in range(HALVINGS):
            angle, rate = motion.at(step, share).T
            low, high = np.where(angle < wanted, share, low), np.where(angle < wanted, high, share)
            with np.errstate(divide="ignore", invalid="ignore"):
                newton = share - (angle - wanted) / (rate * length)
            following = np.where((newton >= low) & (newton <= high), newton, 0.5 * (low + high))
            change, share = np.max(np.abs(following - share), initial=0.0), following
            if change < CLOSE:
                break
        times[:, passed] = motion.times[step] + share * length, motion.at(step, share)[:, 1]
        return times[0], times[1]


def _integrated(drive: Motor, machine: tuple, rate: float, end: float) -> FreeMotion:
    from scipy.integrate import DOP853

    parameters, state, out = flatten(machine), np.zeros(3), np.zeros(2)
    code = entry(rates_entry, machine, "ff", parameters)

    def rates(time, y):
        state[:2], state[2] = y, time
        invoke(code.code, code.parameters, (state, out), 0)
        return out.copy()

    turns = max((end - drive.start_angle) / (2.0 * math.pi), 1.0)
    begin = [drive.start_angle, drive.initial_speed]
    longest = LONGEST * turns * 2.0 * math.pi / rate
    solver = DOP853(rates, 0.0, begin, longest, rtol=RTOL, atol=[ATOL, ATOL * rate])
    times, states, powers, highest = [0.0], [np.array(begin)], [], begin[0]
    while solver.status == "running" and states[-1][0] < end and len(powers) < STEPS * (turns + 1.0):
        if states[-1][0] < highest - 2.0 * math.pi:
            break
        solver.step()
        times.append(solver.t)
        states.append(solver.y.copy())
        powers.append(solver.dense_output().F)
        highest = max(highest, float(solver.y[0]))
    return FreeMotion(np.array(times), np.array(states), np.array(powers).reshape(-1, 7, 2).transpose(1, 0, 2))
