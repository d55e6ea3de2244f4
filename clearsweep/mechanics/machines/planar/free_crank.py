"""Times and speeds at which the free crank of an ideal machine passes given angles.

Collocation at the eight points of `observe.stages`, as in `solver.collocation` but without events. The whole motion
is one call of compiled code.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.polynomial import legendre

from ....contracts.machine import Motor
from ....tracing.compiled.choosing import lane_range, rolled_range
from ....tracing.compiled.family import Routine, entry, flatten, invoke, kernel, known, shaped
from ....tracing.portable import exact, integrals_through, inverse, powers
from ...observe import POINTS, STAGES
from ..contract import accelerate, pose_at
from .drives import is_regulated

MAX_WAIT = 30.0  # longest wait for a free crank, in times at its nominal speed
STEPS_PER_TURN = 300  # capacity, steps per revolution
TOLERANCE = 1e-9  # tolerance of a step: of angle (rad) and of rate over the nominal rate
STAGE_TOLERANCE = 1e-3  # of the tolerance: the iteration has converged where a sweep moves the stages by less
MAX_SWEEPS = 30  # of a step, at most
FIRST_STEP, SHRINK, GROW, SAFETY = 0.01, 0.3, 2.0, 0.8  # first step, in turns at the nominal rate; factors of the step
MIN_STEP = 1e-12  # turns at the nominal rate: the integration stops where it needs shorter steps
MAX_ITERATIONS = 60  # most iterations; Newton's method needs three
FRACTION_TOLERANCE = 1e-13  # of a step, of the time at which an angle is passed

C = np.array(POINTS)
_RISE = integrals_through(C)
_WITHOUT_FIRST = exact(np.eye(STAGES + 1)[:, 1:])
#: (stage that gives, power): the rise over a share x of the step is h x times the sum of rates and powers of x.
RISE = _RISE.rounded()
#: (stage that gives, stage that gets): the integral up to each stage.
A = (_RISE @ (powers(C, STAGES + 1) @ _WITHOUT_FIRST).transposed).rounded()
#: (stage, order): coefficients of the rates in Legendre's polynomials.
SERIES = inverse(exact(legendre.legvander(2.0 * C - 1.0, STAGES - 1))).transposed.rounded()


@known
def _count(mechanism):
    """Return the number of coordinates: the angle, and the integral over time of the drive's integral part."""
    return 2 if is_regulated(mechanism.drive) else 1


@kernel
def _sweep(mechanism, y, h, nodes, rates, weight):
    """Evaluate all stages and update them from their rates; return the largest change over the allowed error.

    y : n coordinates (rad) and their rates (rad/s) at the start; nodes : (2 n + 1, STAGES) the same and the time (s) at
    the stages; rates : (4 n, STAGES) their rates, and their changes; weight : 1 / allowed error of all.
    """
    count = _count(mechanism)
    for i in lane_range(STAGES):
        accelerations = accelerate(mechanism, pose_at(mechanism, nodes[:, i]), ()).accelerations
        for k in range(count):
            rates[count + k, i] = accelerations[k]
    for k in range(2 * count):  # the rates first, then the coordinates from them
        row = 2 * count - 1 - k
        for i in lane_range(STAGES):
            if row < count:
                rates[row, i] = nodes[count + row, i]
        for i in lane_range(STAGES):
            total = A[0, i] * rates[row, 0]
            for j in range(1, STAGES):
                total += A[j, i] * rates[row, j]
            predicted = y[row] + h * total
            rates[2 * count + row, i] = abs(predicted - nodes[row, i]) * weight[row]
            nodes[row, i] = predicted
    largest_change = 0.0
    for row in range(2 * count):
        for i in range(STAGES):
            largest_change = max(largest_change, rates[2 * count + row, i])
    return largest_change


@kernel
def _error(h, rates, weight, count):
    """Return the error of a step over the allowed one, from how its rates decay in Legendre's polynomials."""
    last_pair = earlier_pair = 0.0
    for row in range(2 * count):
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

    y : coordinates (rad), their rates (rad/s), time (s).
    """
    count = _count(mechanism)
    for i in lane_range(STAGES):
        for k in range(count):
            nodes[count + k, i] = y[count + k] + 0.0 * C[i]
            nodes[k, i] = y[k] + h * C[i] * y[count + k]
        nodes[2 * count, i] = y[2 * count] + h * C[i]
    for _ in range(MAX_SWEEPS):
        change = _sweep(mechanism, y, h, nodes, rates, weight)
        if change < STAGE_TOLERANCE:
            return _error(h, rates, weight, count)
        if not change < math.inf:
            break
    return math.inf


def motion_entry(machine, settings, y, nodes, rates, times, states, powers, capacity):
    """Integrate the crank from the state `y`, up to `capacity` steps; from bare pointers.

    settings : (4 + 2 n,) the angle (rad) and the time (s) at which to stop, the nominal rate (rad/s); then the steps
    taken; 1 / allowed error of coordinates and rates; times : (capacity + 1,) s; states : (capacity + 1, 2 n); powers :
    (capacity, 2 n, STAGES), h times rates and RISE.
    """
    mechanism, count_of_state = machine[0], 2 * _count(machine[0])
    settings, y = shaped(settings, (4 + count_of_state,)), shaped(y, (count_of_state + 1,))
    nodes, rates = shaped(nodes, (count_of_state + 1, STAGES)), shaped(rates, (2 * count_of_state, STAGES))
    times = shaped(times, (capacity + 1,))
    states = shaped(states, (capacity + 1, count_of_state))
    powers = shaped(powers, (capacity, count_of_state, STAGES))
    weight = tuple([settings[4 + row] for row in range(count_of_state)])
    full_turn = 2.0 * math.pi / settings[2]
    length, highest, count, is_running = FIRST_STEP * full_turn, y[0], 0, True
    times[0] = y[count_of_state]
    for row in range(count_of_state):
        states[0, row] = y[row]
    while is_running:
        error = _solve_step(mechanism, y, length, nodes, rates, weight)
        factor = SHRINK
        if error < math.inf:
            factor = min(max(SAFETY / math.sqrt(math.sqrt(math.sqrt(max(error, 1e-10)))), SHRINK), GROW)
        if error < 1.0:
            for row in range(count_of_state):
                for m in lane_range(STAGES):
                    total = RISE[0, m] * rates[row, 0]
                    for j in range(1, STAGES):
                        total += RISE[j, m] * rates[row, j]
                    powers[count, row, m] = length * total
                y[row] = nodes[row, STAGES - 1]
            y[count_of_state] += length
            count += 1
            times[count] = y[count_of_state]
            for row in range(count_of_state):
                states[count, row] = y[row]
            highest = max(highest, y[0])
        length *= factor
        is_running = y[0] < settings[0] and y[count_of_state] < settings[1] and count < capacity
        is_running = is_running and (settings[0] == math.inf or y[0] >= highest - 2.0 * math.pi)
        is_running = is_running and length > MIN_STEP * full_turn
    settings[3] = count


class FreeMotion(NamedTuple):
    """Angle (rad) and rate (rad/s) of the crank over n steps, with the polynomials of the steps in between.

    The integral part (N m) of a drive follows them.
    """

    times: np.ndarray  # (n + 1,) s
    states: np.ndarray  # (n + 1, 2 or 3)
    powers: np.ndarray  # (n, 2 or 3, STAGES) of the change over a fraction of a step, divided by the fraction


@kernel
def _state_in_step(motion, step, row, fraction):
    """Return the angle (row 0) or the rate (row 1) at a fraction of a step."""
    change = motion.powers[step, row, STAGES - 1]
    for k in range(STAGES - 2, -1, -1):
        change = change * fraction + motion.powers[step, row, k]
    return motion.states[step, row] + change * fraction


@kernel
def _fraction_at(motion, step, angle):
    """Return the fraction of a step at which the crank passes an angle (rad), by Newton's method between bounds."""
    low, high, length = 0.0, 1.0, motion.times[step + 1] - motion.times[step]
    fraction = (angle - motion.states[step, 0]) / (motion.states[step + 1, 0] - motion.states[step, 0])
    fraction = min(max(fraction, low), high)
    for _ in range(MAX_ITERATIONS):
        difference = _state_in_step(motion, step, 0, fraction) - angle
        if difference < 0.0:
            low = fraction
        else:
            high = fraction
        slope = length * _state_in_step(motion, step, 1, fraction)
        improved = fraction - difference / slope if slope != 0.0 else math.inf
        if not low <= improved <= high:
            improved = 0.5 * (low + high)
        change, fraction = abs(improved - fraction), improved
        if change < FRACTION_TOLERANCE:
            break
    return fraction


def _passages(settings, times, states, powers, highest_angles, angles, passages, count):
    """Write the times (s) at which the crank first passes angles (count,) rad, and its rates, to (2, count).

    settings : (1,) int64, n; highest_angles : (n + 1,) rad, up to the end of each step; for the others see FreeMotion;
    arrays are bare pointers.
    """
    n = shaped(settings, (1,))[0]
    times, states, powers = shaped(times, (n + 1,)), shaped(states, (n + 1, 2)), shaped(powers, (n, 2, STAGES))
    highest_angles, angles = shaped(highest_angles, (n + 1,)), shaped(angles, (count,))
    passages, motion = shaped(passages, (2, count)), FreeMotion(times, states, powers)
    for k in rolled_range(count):
        angle = angles[k]
        if angle <= highest_angles[0]:
            passages[0, k], passages[1, k] = times[0], states[0, 1]
        elif not angle <= highest_angles[n]:
            passages[0, k] = passages[1, k] = math.nan
        else:
            step, end = 0, n  # the last step before which the angle was not passed
            while end - step > 1:
                middle = (step + end) // 2
                if highest_angles[middle] < angle:
                    step = middle
                else:
                    end = middle
            fraction = _fraction_at(motion, step, angle)
            passages[0, k] = times[step] + fraction * (times[step + 1] - times[step])
            passages[1, k] = _state_in_step(motion, step, 1, fraction)


_write_passages = Routine(_passages, "iffffff")


class CrankPassage:
    """The motion of a free crank until it passes the angle `end` (rad) or turns back for good."""

    def __init__(self, drive: Motor, machine: tuple, rate: float, end: float):
        """Integrate; machine : the compiled ideal machine; rate : rad/s, the nominal speed."""
        self.end = end
        self._motion = _free_motion(drive, machine, rate, end)
        self._highest_angles = np.maximum.accumulate(self._motion.states[:, 0])

    def passage_at(self, angles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the times (s) at which the crank first passes angles (n,) rad, and its rates; nan if it never does."""
        passages = np.empty((2, len(angles)))
        arrays = *self._motion, self._highest_angles, np.require(angles, float, "CW"), passages
        _write_passages((np.array([len(self._motion.powers)]), *arrays), len(angles))
        return passages[0], passages[1]


class CrankHistory:
    """The motion of a free crank up to the time `end` (s), in whatever direction."""

    def __init__(self, drive: Motor, machine: tuple, rate: float, end: float):
        """Integrate; machine : the compiled ideal machine; rate : rad/s, the nominal speed."""
        self.end = end
        self._motion = _free_motion(drive, machine, rate, math.inf, end)

    def motion_at(self, times: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return angles (rad), rates (rad/s) and the drive's integral part (N m), 0 without one, at times (n,) s.

        They are nan behind the end of the integration.
        """
        motion = self._motion
        step = np.clip(np.searchsorted(motion.times, times, side="right") - 1, 0, len(motion.powers) - 1)
        fraction = (times - motion.times[step]) / (motion.times[step + 1] - motion.times[step])
        changes = [
            np.sum(motion.powers[step, row] * fraction[:, None] ** np.arange(1, STAGES + 1), axis=1)
            for row in range(motion.states.shape[1])
        ]
        is_known = times <= motion.times[-1]
        rows = [np.where(is_known, motion.states[step, row] + change, math.nan) for row, change in enumerate(changes)]
        return (*rows, np.zeros(len(times)))[:3]


def _free_motion(drive: Motor, machine: tuple, rate: float, end: float, duration: float | None = None) -> FreeMotion:
    """Return the motion up to the angle `end` (rad), or over a `duration` (s) if that is given."""
    turns = (end - drive.start_angle if duration is None else duration * rate) / (2.0 * math.pi)
    revolutions = max(turns, 1.0)
    capacity = math.ceil(STEPS_PER_TURN * (revolutions + 1.0))
    last_time = MAX_WAIT * revolutions * 2.0 * math.pi / rate if duration is None else duration
    coordinates = _count(machine)
    units = [1.0, drive.servo.stiffness / rate] if drive.servo and coordinates > 1 else [1.0]  # of a rad
    weights = [1.0 / (TOLERANCE * unit) for unit in units] + [1.0 / (TOLERANCE * rate * unit) for unit in units]
    settings = np.array([end, last_time, rate, 0.0, *weights])
    width, starts = 2 * coordinates, [drive.start_angle, 0.0][:coordinates]
    times, states, powers = np.empty(capacity + 1), np.empty((capacity + 1, width)), np.empty((capacity, width, STAGES))
    parameters, y = flatten(machine), np.array([*starts, drive.initial_speed, 0.0, 0.0][: width + 1])
    motion = entry(motion_entry, machine, "fffffff", parameters)
    stages = np.zeros((width + 1, STAGES)), np.zeros((2 * width, STAGES))
    invoke(motion.code, motion.parameters, (settings, y, *stages, times, states, powers), capacity)
    count, rows = int(settings[3]), [0, coordinates, *range(coordinates + 1, width)]
    return FreeMotion(
        times[: count + 1], *(np.take(array, rows, axis=1) for array in (states[: count + 1], powers[:count]))
    )
