"""Times and speeds at which the free crank of an ideal machine passes given angles.

Collocation at the eight points of `observe.stages`, as in `solver.collocation` but without events. The whole motion
is one call of compiled code.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.polynomial import legendre

from ....contracts.machine import Motor
from ...compiled.choosing import lane_range
from ...compiled.family import entry, flatten, invoke, kernel, shaped
from ...observe.stages import POINTS, STAGES
from ...trace.portable import Exact, coefficients_through, exact, inverse, powers
from ..contract import accelerate, pose_at

MAX_WAIT = 30.0  # longest wait for a free crank, in times at its nominal speed
STEPS_PER_TURN = 300  # capacity, steps per revolution
TOLERANCE = 1e-9  # tolerance of a step: of angle (rad) and of rate over the nominal rate
STAGE_TOLERANCE = 1e-3  # of the tolerance: the iteration has converged where a sweep moves the stages by less
MAX_SWEEPS = 30  # of a step, at most
FIRST_STEP, SHRINK, GROW, SAFETY = 0.01, 0.3, 2.0, 0.8  # first step, in turns at the nominal rate; factors of the step
MIN_STEP = 1e-12  # turns at the nominal rate: the integration stops where it needs shorter steps
MAX_ITERATIONS = 60  # most iterations; Newton's method needs five
FRACTION_TOLERANCE = 1e-13  # of a step, of the time at which an angle is passed

C = np.array(POINTS)
_FROM_RATES, _LCM = coefficients_through(C).transposed, math.lcm(*range(1, STAGES + 1))
_RISE = Exact(
    [[number * (_LCM // (power + 1)) for power, number in enumerate(row)] for row in _FROM_RATES.rows],
    _FROM_RATES.denominator * _LCM,
)
_WITHOUT_FIRST = exact(np.eye(STAGES + 1)[:, 1:])
#: (stage that gives, power): the rise over a share x of the step is h x times the sum of rates and powers of x.
RISE = _RISE.rounded()
#: (stage that gives, stage that gets): the integral up to each stage.
A = (_RISE @ (powers(C, STAGES + 1) @ _WITHOUT_FIRST).transposed).rounded()
#: (stage, order): coefficients of the rates in Legendre's polynomials.
SERIES = inverse(exact(legendre.legvander(2.0 * C - 1.0, STAGES - 1))).transposed.rounded()


@kernel
def _sweep(mechanism, y, h, nodes, rates, weight):
    """Evaluate all stages and update them from their rates; return the largest change over the allowed error.

    y : angle (rad) and rate (rad/s) at the start; nodes : (3, STAGES) the same and the time (s) at the stages; rates :
    (4, STAGES) their rates, and their changes; weight : 1 / allowed error of both.
    """
    for i in lane_range(STAGES):
        rates[1, i] = accelerate(mechanism, pose_at(mechanism, nodes[:, i]), ()).accelerations[0]
    for row in (1, 0):  # the rate first, then the angle from it
        for i in lane_range(STAGES):
            if row == 0:
                rates[0, i] = nodes[1, i]
        for i in lane_range(STAGES):
            total = A[0, i] * rates[row, 0]
            for j in range(1, STAGES):
                total += A[j, i] * rates[row, j]
            predicted = y[row] + h * total
            rates[2 + row, i] = abs(predicted - nodes[row, i]) * weight[row]
            nodes[row, i] = predicted
    largest_change = 0.0
    for row in range(2):
        for i in range(STAGES):
            largest_change = max(largest_change, rates[2 + row, i])
    return largest_change


@kernel
def _error(h, rates, weight):
    """Return the error of a step over the allowed one, from how its rates decay in Legendre's polynomials."""
    last_pair = earlier_pair = 0.0
    for row in range(2):
        for m in range(STAGES - 4, STAGES):
            total = SERIES[0, m] * rates[row, 0]
            for j in range(1, STAGES):
                total += SERIES[j, m] * rates[row, j]
            size = h * total * weight[row]
            if m >= STAGES - 2:
                last_pair += size * size
            else:
                earlier_pair += size * size
    if not last_pair + earlier_pair < math.inf:
        return math.inf
    return math.sqrt(last_pair) * (last_pair / earlier_pair if last_pair < earlier_pair else 1.0)


@kernel
def _solve_step(mechanism, y, h, nodes, rates, weight):
    """Compute the stages of a step of length `h` (s) from the state `y`; return its error over the allowed one.

    y : angle (rad), rate (rad/s), time (s).
    """
    for i in lane_range(STAGES):
        nodes[1, i] = y[1] + 0.0 * C[i]
        nodes[0, i] = y[0] + h * C[i] * y[1]
        nodes[2, i] = y[2] + h * C[i]
    for _ in range(MAX_SWEEPS):
        change = _sweep(mechanism, y, h, nodes, rates, weight)
        if change < STAGE_TOLERANCE:
            return _error(h, rates, weight)
        if not change < math.inf:
            break
    return math.inf


def motion_entry(machine, settings, y, nodes, rates, times, states, powers, capacity):
    """Integrate the crank from the state `y`, up to `capacity` steps; from bare pointers.

    settings : (4,) the angle (rad) and the time (s) at which to stop, the nominal rate (rad/s); then the steps taken;
    times : (capacity + 1,) s; states : (capacity + 1, 2); powers : (capacity, 2, STAGES), h times rates and RISE.
    """
    mechanism, settings, y = machine[0], shaped(settings, (4,)), shaped(y, (3,))
    nodes, rates = shaped(nodes, (3, STAGES)), shaped(rates, (4, STAGES))
    times, states, powers = (
        shaped(times, (capacity + 1,)),
        shaped(states, (capacity + 1, 2)),
        shaped(powers, (capacity, 2, STAGES)),
    )
    weight = 1.0 / TOLERANCE, 1.0 / (TOLERANCE * settings[2])
    full_turn = 2.0 * math.pi / settings[2]
    length, highest, count, is_running = FIRST_STEP * full_turn, y[0], 0, True
    times[0], states[0, 0], states[0, 1] = y[2], y[0], y[1]
    while is_running:
        error = _solve_step(mechanism, y, length, nodes, rates, weight)
        factor = SHRINK
        if error < math.inf:
            factor = min(max(SAFETY / math.sqrt(math.sqrt(math.sqrt(max(error, 1e-10)))), SHRINK), GROW)
        if error < 1.0:
            for row in range(2):
                for m in lane_range(STAGES):
                    total = RISE[0, m] * rates[row, 0]
                    for j in range(1, STAGES):
                        total += RISE[j, m] * rates[row, j]
                    powers[count, row, m] = length * total
                y[row] = nodes[row, STAGES - 1]
            y[2] += length
            count += 1
            times[count], states[count, 0], states[count, 1] = y[2], y[0], y[1]
            highest = max(highest, y[0])
        length *= factor
        is_running = y[0] < settings[0] and y[2] < settings[1] and y[0] >= highest - 2.0 * math.pi and count < capacity
        is_running = is_running and length > MIN_STEP * full_turn
    settings[3] = count


class FreeMotion(NamedTuple):
    """Angle (rad) and rate (rad/s) of the crank over n steps, with the polynomials of the steps in between."""

    times: np.ndarray  # (n + 1,) s
    states: np.ndarray  # (n + 1, 2)
    powers: np.ndarray  # (n, 2, STAGES) of the change over a fraction of a step, divided by the fraction

    def interpolant(self, step: np.ndarray) -> Callable[[np.ndarray], np.ndarray]:
        """Return the function that gives angle and rate (2, m) at fractions (m,) of steps (m,)."""
        start, powers = self.states[step].T, np.ascontiguousarray(self.powers[step].transpose(2, 1, 0))

        def evaluate(fraction: np.ndarray) -> np.ndarray:
            values = powers[STAGES - 1]
            for k in range(STAGES - 2, -1, -1):
                values = values * fraction + powers[k]
            predicted: np.ndarray = start + values * fraction
            return predicted

        return evaluate


class CrankPassage:
    """The motion of a free crank until it passes the angle `end` (rad) or turns back for good."""

    def __init__(self, drive: Motor, machine: tuple, rate: float, end: float):
        """Integrate; machine : the compiled ideal machine; rate : rad/s, the nominal speed."""
        self.end = end
        self._motion = _free_motion(drive, machine, rate, end)
        self._highest_angles = np.maximum.accumulate(self._motion.states[:, 0])

    def passage_at(self, angles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the times (s) at which the crank first passes angles (n,) rad, and its rates; nan if it never does."""
        motion, times = self._motion, np.full((2, len(angles)), math.nan)
        step = np.searchsorted(self._highest_angles, angles) - 1
        is_before_start, is_passed = step < 0, (step >= 0) & (step < len(motion.times) - 1)
        times[:, is_before_start] = np.array([[motion.times[0]], [motion.states[0, 1]]])
        step, target = step[is_passed], angles[is_passed]
        low, high, interpolant = np.zeros(len(step)), np.ones(len(step)), motion.interpolant(step)
        fraction, length = 0.5 * (low + high), np.diff(motion.times)[step]
        for _ in range(MAX_ITERATIONS):
            angle, rate = interpolant(fraction)
            low, high = np.where(angle < target, fraction, low), np.where(angle < target, high, fraction)
            with np.errstate(divide="ignore", invalid="ignore"):
                newton = fraction - (angle - target) / (rate * length)
            improved = np.where((newton >= low) & (newton <= high), newton, 0.5 * (low + high))
            change, fraction = np.max(np.abs(improved - fraction), initial=0.0), improved
            if change < FRACTION_TOLERANCE:
                break
        times[:, is_passed] = motion.times[step] + fraction * length, interpolant(fraction)[1]
        return times[0], times[1]


def _free_motion(drive: Motor, machine: tuple, rate: float, end: float) -> FreeMotion:
    revolutions = max((end - drive.start_angle) / (2.0 * math.pi), 1.0)
    capacity = math.ceil(STEPS_PER_TURN * (revolutions + 1.0))
    settings = np.array([end, MAX_WAIT * revolutions * 2.0 * math.pi / rate, rate, 0.0])
    times, states, powers = np.empty(capacity + 1), np.empty((capacity + 1, 2)), np.empty((capacity, 2, STAGES))
    parameters, y = flatten(machine), np.array([drive.start_angle, drive.initial_speed, 0.0])
    motion = entry(motion_entry, machine, "fffffff", parameters)
    arrays = settings, y, np.zeros((3, STAGES)), np.zeros((4, STAGES)), times, states, powers
    invoke(motion.code, motion.parameters, arrays, capacity)
    count = int(settings[3])
    return FreeMotion(times[: count + 1], states[: count + 1], powers[:count])
