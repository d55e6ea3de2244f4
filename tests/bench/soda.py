"""numbalsoda's DOP853 and LSODA, stopped at every contact onset and separation by a compiled driver.

DOP853 is numbalsoda's `solve_ivp`, which finds the root of an event function on its dense output.  That function is the
least margin of all joints, so that the first of two events in a step is found first.  Its root is found to 1e-8 units
of time; the driver's unit is a microsecond, so to 1e-14 s.  Other drivers tried took longer at the same error: `dop853`
sampled on a grid with a restart at the last sample before the event, a first step remembered from the last contact of
the kind, every step saved, places weighted by 0.1 to 100, relative tolerances.

LSODA has no event function: it is sampled on a grid, restarted at the last sample before an event up to where the
samples say that it is, again where that is not close, and brought to it by a Newton step.
"""

import functools
import math
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from numba import carray, cfunc, from_dtype, njit, types
from numbalsoda import dop853, lsoda, solve_ivp

from clearsweep.mechanics.solver.integration import ONSET, SEPARATION
from clearsweep.verify.accuracy import scene_of
from clearsweep.verify.rivals import EVENT_DEAD_TIME, LEAST_RELATIVE_TOLERANCE, MAX_STEP_TURNS, Solution

from .mechanics import FLOOR, FREE, MODELS, PRESSED, RECORD, margin, parameters, units

TICK = 1e-6  # s, unit of time
MOST = 400  # events
TRIES, NEAR = 5, 1e-10  # s, so close to an event that a Newton step ends on it
GRID = 48  # samples of a stretch that LSODA runs through at once
AHEAD, FLIGHT = 1.2, 0.1  # how far such a stretch reaches: last contact's durations, turns of the crank
STEPS = 100_000
AT_ONCE = 8  # cases that a thread takes
FINE, MAX_BINS = 400, 1e-5  # samples of a stretch whose force peaks are searched for, and turns between them; not timed
NUMBER, NUMBERS = types.float64, types.CPointer(types.float64)
SIGNATURE = types.void(NUMBER, NUMBERS, NUMBERS, types.CPointer(from_dtype(RECORD)))


@functools.cache
def compiled(model):
    """Return the addresses of the right-hand side and of the event function, both in ticks."""
    rates, depths, joints, size = model

    @cfunc(SIGNATURE, error_model="numpy")
    def slope(t, u, du, data):
        rates(t * TICK, u, du, carray(data, 1)[0])
        for i in range(size):
            du[i] *= TICK

    @cfunc(SIGNATURE, error_model="numpy")
    def event(t, u, out, data):
        p = carray(data, 1)[0]
        depths(t * TICK, u, p)
        out[0] = margin(p, 0, t * TICK)
        for j in range(1, joints):
            out[0] = min(out[0], margin(p, j, t * TICK))

    return slope, event


@njit(error_model="numpy")
def switch(p, j, t, log, count):
    """Begin or end the contact of joint `j` at `t` (s), whose depth and rate were just evaluated; log it."""
    kind = ONSET if p.state[j] == FREE else SEPARATION
    log[count, 0], log[count, 1], log[count, 2], log[count, 3] = t, j, kind, p.closing_rate[j]
    p.state[j] = PRESSED if kind == ONSET else FREE
    if kind == ONSET:
        p.onset[j] = max(p.closing_rate[j], FLOOR)
    p.latest, p.blind = j, t + EVENT_DEAD_TIME * 2.0 * math.pi / p.rate


@functools.cache
def by_events(model):
    """Return the compiled driver of numbalsoda's DOP853; the state at the end follows those at the events."""
    rates, _, joints, _ = model
    slope, event = (function.address for function in compiled(model))

    @njit(error_model="numpy")
    def drive(record, u, end, tolerance, log, states):
        p, du, count, t = record[0], np.empty_like(u), 0, 0.0
        span, last = np.array([0.0, end / TICK]), np.array([end / TICK])
        longest = MAX_STEP_TURNS * 2.0 * math.pi / (p.rate * TICK)
        while count < MOST:
            span[0] = t
            result = solve_ivp(
                slope,
                span,
                u,
                last,
                "DOP853",
                1,
                event,
                record.ctypes.data,
                0.0,
                longest,
                LEAST_RELATIVE_TOLERANCE,
                tolerance,
            )
            if not result.event_found:
                states[count] = result.y[-1]
                break
            t, u = result.t_event, result.y_event.copy()
            rates(t * TICK, u, du, p)
            j = 0
            for other in range(1, joints):
                if margin(p, other, t * TICK) < margin(p, j, t * TICK):
                    j = other
            switch(p, j, t * TICK, log, count)
            states[count] = u
            count += 1
        return count

    return drive


@njit(error_model="numpy")
def cubic_root(y0, slope0, y1, slope1):
    """Return where the cubic with these end values and slopes falls through zero between 0 and 1, to 1e-9."""
    low, high = 0.0, 1.0
    for _ in range(30):
        x = 0.5 * (low + high)
        rest = 1.0 - x
        value = rest * rest * (y0 * (1.0 + 2.0 * x) + slope0 * x) + x * x * (y1 * (3.0 - 2.0 * x) - slope1 * rest)
        low, high = (x, high) if value > 0.0 else (low, x)
    return high


@njit(error_model="numpy")
def first_past(p, depths, times, result):
    """Return the first row that is past an event, 0 where there is none."""
    for i in range(1, times.size):
        depths(times[i] * TICK, result[i], p)
        for j in range(p.joints):
            if margin(p, j, times[i] * TICK) < 0.0:
                return i
    return 0


@njit(error_model="numpy")
def longest_step(p, t, began, lasted):
    """Return how far to go at once, ticks."""
    far = FLIGHT * 2.0 * math.pi / (p.rate * TICK)
    for j in range(p.joints):
        if p.state[j] == PRESSED and lasted[j] > 0.0:
            far = min(far, max(began[j] + AHEAD * lasted[j] - t, 0.1 * lasted[j]))
        elif p.state[j] == PRESSED:
            far = min(far, 0.01 * far)
    return far


@njit(error_model="numpy")
def located(record, rates, slope, times, result, j, tolerance):
    """Return (time, state) of joint `j`'s event between two rows, in ticks."""
    p, du = record[0], np.empty_like(result[0])
    sign = -1.0 if p.state[j] == FREE else 1.0
    h = times[1] - times[0]
    rates(times[0] * TICK, result[0], du, p)
    before, slope_before = max(sign * p.depth[j], 0.0), sign * p.closing_rate[j] * h * TICK
    rates(times[1] * TICK, result[1], du, p)
    x = cubic_root(before, slope_before, sign * p.depth[j], sign * p.closing_rate[j] * h * TICK)
    t, u, rest = times[0] + x * h, result[0], 0.0
    for _ in range(TRIES):
        u = result[0]
        if t > times[0]:
            u = lsoda(slope, u, np.array([times[0], t]), record, LEAST_RELATIVE_TOLERANCE, tolerance, STEPS)[0][1]
        rates(t * TICK, u, du, p)
        rest = -p.depth[j] / p.closing_rate[j]  # s
        if abs(rest) < NEAR or t + rest / TICK <= times[0]:
            break
        t += rest / TICK
    return t + rest / TICK, u + rest * du


@functools.cache
def by_grid(model):
    """Return the compiled driver of numbalsoda's LSODA; see `prepared`."""
    rates, depths, joints, size = model
    slope = compiled(model)[0].address

    @njit(error_model="numpy")
    def drive(record, u, end, tolerance, log, states):
        p, count, t, end = record[0], 0, 0.0, end / TICK
        began, lasted, du = np.zeros(joints), np.zeros(joints), np.empty(size)
        while t < end and count < MOST:
            times = np.linspace(t, min(t + longest_step(p, t, began, lasted), end), GRID + 1)
            result, fine = lsoda(slope, u, times, record, LEAST_RELATIVE_TOLERANCE, tolerance, STEPS)
            if not fine:
                break
            i = first_past(p, depths, times, result)
            if i == 0:
                t, u = times[-1], result[-1].copy()
                continue
            t, chosen = math.inf, 0
            for j in range(joints):
                depths(times[i] * TICK, result[i], p)
                if margin(p, j, times[i] * TICK) < 0.0:
                    moment, state = located(
                        record, rates, slope, times[i - 1 : i + 1], result[i - 1 : i + 1], j, tolerance
                    )
                    if moment < t:
                        t, u, chosen = moment, state, j
            rates(t * TICK, u, du, p)
            if p.state[chosen] == FREE:
                began[chosen] = t
            else:
                lasted[chosen] = t - began[chosen]
            switch(p, chosen, t * TICK, log, count)
            states[count] = u
            count += 1
        return count

    return drive


DRIVERS = {"DOP853": by_events, "LSODA": by_grid}


def prepared(problem, method, tolerance):
    """Return a function that integrates a problem and returns its record, event log and states at the events."""
    scene = scene_of(problem, tolerance)
    model = MODELS[tuple(problem.grid["joints"])]
    drive, fresh = DRIVERS[method](model), parameters(scene)
    start = scene.start[: model.size] / units(fresh, model)

    def integrate():
        record, log, states = fresh.copy(), np.zeros((MOST, 5)), np.empty((MOST + 1, model.size))
        count = drive(record, start.copy(), problem.end, tolerance, log, states)
        return record, log[:count], states[:count]

    return integrate, model, fresh, start


@functools.cache
def in_turn(model):
    """Return the compiled function that integrates several cases, one after the other, without Python's lock."""
    drive, size = by_events(model), model.size

    @njit(error_model="numpy", nogil=True)
    def each(records, starts, ends, tolerance, final):
        log, states = np.zeros((MOST, 5)), np.empty((MOST + 1, size))
        for i in range(ends.size):
            count = drive(records[i : i + 1], starts[i].copy(), ends[i], tolerance, log, states)
            final[i] = states[count]

    return each


def many(problems, scenes, tolerance):
    """Return a function that integrates problems of one model in so many threads and returns their final states."""
    model = MODELS[tuple(problems[0].grid["joints"])]
    each, fresh = in_turn(model), np.concatenate([parameters(scene) for scene in scenes])
    unit = np.array([units(fresh[i : i + 1], model) for i in range(len(problems))])
    starts = np.array([scene.start[: model.size] for scene in scenes]) / unit
    ends = np.array([problem.end for problem in problems])

    def integrate(threads):
        records, final = fresh.copy(), np.empty_like(starts)

        def part(first):
            some = slice(first, first + AT_ONCE)
            each(records[some], starts[some], ends[some], tolerance, final[some])

        firsts = range(0, len(problems), AT_ONCE)
        if threads == 1:
            list(map(part, firsts))
        else:
            with ThreadPoolExecutor(threads) as pool:
                list(pool.map(part, firsts))
        return final * unit

    return integrate


def repeat(problem, tolerance, method):
    """Return a function that integrates a problem, to be timed: events alone, no samples, no force peaks."""
    integrate = prepared(problem, method, tolerance)[0]
    return lambda: integrate() and None


def solve(problem, tolerance, method) -> Solution:
    """Return the Solution of a problem at its times, with the force peaks of its contacts."""
    integrate, model, record, start = prepared(problem, method, tolerance)
    done, log, turns = integrate()
    slope, unit, turn = compiled(model)[0].address, units(record, model), 2.0 * math.pi / record["rate"][0]
    bounds = [(0.0, start), *((row[0], state) for row, state in zip(log, turns, strict=True))]
    samples, peaks = [], np.zeros(model.joints)
    for (t, u), stop, event in zip(bounds, [*log[:, 0], problem.end], [*log, None], strict=True):
        wanted = problem.times[(problem.times > t) & (problem.times <= stop)]
        fine = max(FINE, math.ceil((stop - t) / (MAX_BINS * turn)))
        grid = np.unique(np.concatenate([np.linspace(t, stop, fine + 1), wanted]))
        result, _ = dop853(
            slope, np.ascontiguousarray(u), grid / TICK, record, LEAST_RELATIVE_TOLERANCE, tolerance, STEPS
        )
        samples += [result[np.searchsorted(grid, time)] * unit for time in wanted]
        for j in np.flatnonzero(record["state"][0, : model.joints] == PRESSED):
            force = forces(model.rates, record, grid, result, j)
            peaks[j] = max(peaks[j], _largest(grid, force))
        if event is None:
            break
        j = int(event[1])
        if event[2] == SEPARATION:
            event[4], peaks[j] = peaks[j], 0.0
        record["state"][0, j] = PRESSED if event[2] == ONSET else FREE
        record["onset"][0, j] = max(event[3], FLOOR)
    return Solution(np.array(samples), log, len(log), None, int(done["evaluations"][0]))


@njit(error_model="numpy")
def forces(rates, record, times, states, j):
    """Return the normal forces (N) of joint `j` at `times` (s)."""
    result, du = np.empty(times.size), np.empty(states.shape[1])
    for i in range(times.size):
        rates(times[i], states[i], du, record[0])
        result[i] = record[0].force[j]
    return result


def _largest(times, force) -> float:
    """Return the largest of the forces, on the parabola through it and its neighbours."""
    i = int(np.argmax(force))
    if not 0 < i < len(force) - 1:
        return force[i]
    parabola = np.polynomial.Polynomial.fit(times[i - 1 : i + 2], force[i - 1 : i + 2], 2)
    return float(parabola(parabola.deriv().roots()[0]))
