"""DOP853 by hand in numba, with events on its dense output: the fastest program that a user might write.

It allocates nothing, calls nothing and starts each stretch with the step length of the last one of its kind.
Coefficients and dense output are those of scipy (Hairer, Norsett & Wanner 1993, Solving Ordinary Differential Equations
I, section II.10); error and places are scaled as in `soda`.
"""

import functools
import math

import numpy as np
from numba import njit
from scipy.integrate._ivp import dop853_coefficients as table

from clearsweep.mechanics.solver.integration import ONSET, SEPARATION
from clearsweep.verify.accuracy import scene_of
from clearsweep.verify.rivals import EVENT_DEAD_TIME, LEAST_RELATIVE_TOLERANCE, MAX_STEP_TURNS, Solution

from .mechanics import FLOOR, FREE, MODELS, PRESSED, margin, parameters, units

MOST = 400  # events
STAGES, ALL_STAGES, POWERS = table.N_STAGES, table.N_STAGES_EXTENDED, table.INTERPOLATOR_POWER
A, C, B, E3, E5, D = table.A, table.C, table.B, table.E3, table.E5, table.D
FIRST_STEP = 1e-4  # turns of the crank
SAFETY, LEAST_RATIO, LARGEST_RATIO = 0.9, 0.2, 10.0  # of step lengths
ROOT_ERROR = 1e-14  # s


@functools.cache
def driver(model):  # noqa: PLR0915 - one compiled program
    """Return the compiled driver of one choice of open joints."""
    rates, depths, joints, size = model

    @njit(error_model="numpy")
    def least_margin(t, u, p):
        depths(t, u, p)
        least, first = math.inf, 0
        for j in range(joints):
            value = margin(p, j, t)
            if value < least:
                least, first = value, j
        return least, first

    @njit(error_model="numpy")
    def stage(s, t, h, u, k, place, p):
        """Evaluate the rates of stage `s` of a step."""
        for i in range(size):
            change = 0.0
            for r in range(s):
                change += A[s, r] * k[r, i]
            place[i] = u[i] + h * change
        rates(t + C[s] * h, place, k[s], p)

    @njit(error_model="numpy")
    def error_of(h, tolerance, u, after, k):
        """Return the estimated error of a step over the allowed one."""
        fifth = third = 0.0
        for i in range(size):
            scale = tolerance + LEAST_RELATIVE_TOLERANCE * max(abs(u[i]), abs(after[i]))
            first = second = 0.0
            for s in range(STAGES + 1):
                first += E5[s] * k[s, i]
                second += E3[s] * k[s, i]
            fifth += (first / scale) ** 2
            third += (second / scale) ** 2
        if fifth == 0.0:
            return 0.0
        return h * fifth / math.sqrt((fifth + 0.01 * third) * size)

    @njit(error_model="numpy")
    def prepare_dense(t, h, u, after, k, dense, place, p):
        """Fill the coefficients (POWERS, size) of the dense output of a step."""
        for s in range(STAGES + 1, ALL_STAGES):
            stage(s, t, h, u, k, place, p)
        for i in range(size):
            change = after[i] - u[i]
            dense[0, i], dense[1, i] = change, h * k[0, i] - change
            dense[2, i] = 2.0 * change - h * (k[STAGES, i] + k[0, i])
            for row in range(POWERS - 3):
                total = 0.0
                for s in range(ALL_STAGES):
                    total += D[row, s] * k[s, i]
                dense[3 + row, i] = h * total

    @njit(error_model="numpy")
    def evaluate_dense(x, u, dense, place):
        """Put the state at the share `x` of a step into `place`."""
        for i in range(size):
            value = 0.0
            for power in range(POWERS):
                value = (value + dense[POWERS - 1 - power, i]) * (x if power % 2 == 0 else 1.0 - x)
            place[i] = u[i] + value

    @njit(error_model="numpy")
    def root(t, h, before, behind, u, dense, place, p):
        """Return the share of a step at which the margin vanishes (Illinois method); `place` is the state there."""
        low, high, x = 0.0, 1.0, 1.0
        for _ in range(60):
            x = 0.5 * (low + high)
            if before < math.inf:  # infinite just after an event of this joint
                x = (low * behind - high * before) / (behind - before)
            evaluate_dense(x, u, dense, place)
            value = least_margin(t + x * h, place, p)[0]
            if value > 0.0:
                low, before, behind = x, value, 0.5 * behind
            else:
                high, behind, before = x, value, 0.5 * before
            if value == 0.0 or (high - low) * h < ROOT_ERROR:
                break
        return x

    @njit(error_model="numpy", nogil=True)
    def drive(  # noqa: PLR0912, PLR0915 - one loop
        record, u, end, tolerance, log, times, samples, k, dense, work
    ):
        """Integrate from event to event; return their number and that of the steps.

        log : (MOST, 5); times, samples : (n,) s, (n, size); k, dense, work : arrays for stages, dense output, places
        """
        p, after, place = record[0], work[0], work[1]
        turn = 2.0 * math.pi / p.rate
        lengths = work[2]
        lengths[:2] = FIRST_STEP * turn
        t, count, steps, sampled, kind = 0.0, 0, 0, 0, 0
        h, before = lengths[0], least_margin(0.0, u, p)[0]
        rates(t, u, k[0], p)
        while t < end and count < MOST:
            h = min(h, MAX_STEP_TURNS * turn)
            length = min(h, end - t)
            for s in range(1, STAGES):
                stage(s, t, length, u, k, place, p)
            for i in range(size):
                change = 0.0
                for s in range(STAGES):
                    change += B[s] * k[s, i]
                after[i] = u[i] + length * change
            rates(t + length, after, k[STAGES], p)
            error = error_of(length, tolerance, u, after, k)
            ratio = LARGEST_RATIO if error == 0.0 else SAFETY * error**-0.125
            if not error <= 1.0:
                h = length * max(LEAST_RATIO, ratio if ratio > 0.0 else 0.0)
                continue
            steps += 1
            behind = least_margin(t + length, after, p)[0]
            is_event, share = behind < 0.0, 1.0
            if is_event or (sampled < times.size and times[sampled] <= t + length):
                prepare_dense(t, length, u, after, k, dense, place, p)
            if is_event:
                share = root(t, length, before, behind, u, dense, place, p)
            while sampled < times.size and times[sampled] <= t + share * length:
                evaluate_dense((times[sampled] - t) / length, u, dense, samples[sampled])
                sampled += 1
            h = max(h, length * min(ratio, LARGEST_RATIO)) if length < h else length * min(ratio, LARGEST_RATIO)
            if not is_event:
                t += length
                for i in range(size):
                    u[i], k[0, i] = after[i], k[STAGES, i]
                before = least_margin(t, u, p)[0]
                continue
            lengths[kind] = length
            evaluate_dense(share, u, dense, after)
            t += share * length
            for i in range(size):
                u[i] = after[i]
            rates(t, u, k[0], p)
            j = least_margin(t, u, p)[1]
            log[count, 0], log[count, 1], log[count, 3] = t, j, p.closing_rate[j]
            log[count, 2] = ONSET if p.state[j] == FREE else SEPARATION
            if p.state[j] == FREE:
                p.state[j], p.onset[j] = PRESSED, max(p.closing_rate[j], FLOOR)
            else:
                p.state[j] = FREE
            p.latest, p.blind = j, t + EVENT_DEAD_TIME * turn
            count += 1
            kind = 0
            for other in range(joints):
                kind = max(kind, int(p.state[other] == PRESSED))
            h = lengths[kind]
            rates(t, u, k[0], p)
            before = least_margin(t, u, p)[0]
        return count, steps

    return drive


def prepared(problem, tolerance, times):
    """Return a function that integrates a problem and returns its record, log, samples at `times` (s) and steps."""
    scene = scene_of(problem, tolerance)
    model = MODELS[tuple(problem.grid["joints"])]
    drive, fresh = driver(model), parameters(scene)
    start = scene.start[: model.size] / units(fresh, model)
    k, dense, work = (np.zeros((rows, model.size)) for rows in (ALL_STAGES, POWERS, 3))
    log, samples = np.zeros((MOST, 5)), np.zeros((len(times), model.size))

    def integrate():
        record = fresh.copy()
        count, steps = drive(record, start.copy(), problem.end, tolerance, log, times, samples, k, dense, work)
        return record, log[:count], samples * units(fresh, model), steps

    return integrate


def repeat(problem, tolerance):
    """Return a function that integrates a problem, to be timed: events alone, no samples, no force peaks."""
    integrate = prepared(problem, tolerance, np.empty(0))
    return lambda: integrate() and None


def solve(problem, tolerance) -> Solution:
    """Return the Solution of a problem at its times; force peaks are not searched."""
    record, log, samples, steps = prepared(problem, tolerance, problem.times)()
    return Solution(samples, log.copy(), steps, None, int(record["evaluations"][0]))
