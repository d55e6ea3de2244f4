"""Reference integrators, on the right-hand side in time of the same compiled laws and mechanism.

The state is coordinates, their rates, time; the penetration follows from the coordinates.  One integrator is classical
Runge-Kutta 4 with a fixed step and without event location, as in most papers on clearance joints.  The others are
scipy's DOP853, LSODA and Radau, stopped and restarted at every contact onset and separation.
"""

import functools
import math
from typing import NamedTuple

import numpy as np

from ..contracts.results import EVENT_DTYPE, EVENT_KINDS, Trajectory
from ..mechanics.coupling.state import every_state
from ..mechanics.joints.dry import Joint, joint_load
from ..mechanics.laws.contract import CLIPPED, FREE, ONSET_FLOOR, PRESSED
from ..mechanics.machines.contract import accelerate, gaps, pose_at
from ..mechanics.solver.integration import ONSET, SEPARATION
from ..tracing.compiled.family import Entry, entry, flatten, invoke, kernel, shaped
from ..tracing.objects import function_at, machine_code

STAGES = 4  # of the rates: the stages of Runge-Kutta 4
DEPTH_COLUMN, RATE_COLUMN, NORMAL_COLUMN, JOINT_WIDTH = 0, 1, 2, 3  # numbers after the rates, for every joint
TINY_DEPTH = 1e-300  # m
LEAST_RELATIVE_TOLERANCE = 2.3e-14  # least relative tolerance of scipy
EVENT_DEAD_TIME = 1e-9  # turns of the crank after an event during which its joint has no other event
RIVAL_METHODS = ("DOP853", "LSODA")  # of scipy, on a user's case
MAX_STEP_TURNS = 0.02  # largest step in turns of the crank, so that no step skips a contact


class Solution(NamedTuple):
    """Result and cost of an integration."""

    states: np.ndarray  # (samples, coordinates and their rates)
    events: np.ndarray  # (events, 5) time (s), joint, ONSET or SEPARATION, rate (m/s), force peak (N)
    steps: int
    rejected: int | None
    evaluations: int


# ---------------------------------------------------------------------------------------------- right-hand side


@kernel
def load_of(joint, gap, state, onset):
    """Return the Load of a joint at the penetration of its Gap; a pulling force is clipped at zero."""
    depth = math.sqrt(gap.x * gap.x + gap.y * gap.y) - joint.clearance
    if depth < 0.0:  # a trial step past the separation
        return joint_load(joint, gap, FREE, 0.0, onset)
    load = joint_load(joint, gap, state, depth, onset)
    return joint_load(joint, gap, CLIPPED, depth, onset) if load.contacts[0].raw < 0.0 else load


@kernel
def rates_in_time(scene, y, state, onset, k, row):
    """Write the rates of `y` in time to `k[row]`, then depth, its rate and the normal force of every joint.

    y : (n,) coordinates, rates, time; k : (ROWS, n + JOINT_WIDTH * joints); state, onset : (joints,).
    """
    coordinate_count = len(scene.coordinates)
    pose = pose_at(scene.mechanism, y)
    pairs = list(enumerate(zip(scene.joints, gaps(scene.mechanism, pose), strict=True)))
    loads = tuple([load_of(joint, gap, state[j], onset[j]) for j, (joint, gap) in pairs])
    motion = accelerate(scene.mechanism, pose, loads)
    for i in range(coordinate_count):
        k[row, i] = y[coordinate_count + i]
        k[row, coordinate_count + i] = motion.accelerations[i]
    k[row, 2 * coordinate_count] = 1.0
    for j in range(len(scene.joints)):
        contact, first_column = loads[j].contacts[0], 2 * coordinate_count + 1 + JOINT_WIDTH * j
        k[row, first_column + DEPTH_COLUMN], k[row, first_column + RATE_COLUMN] = contact.depth, contact.rate
        k[row, first_column + NORMAL_COLUMN] = contact.normal


def rates_entry(scene, y, state, onset, k, row):
    """Evaluate `rates_in_time` with arrays from bare pointers; `scene` is a pointer to the Scene."""
    compiled_scene = scene[0]
    joints, n = len(compiled_scene.joints), 2 * len(compiled_scene.coordinates) + 1
    rates_in_time(
        compiled_scene,
        shaped(y, (n,)),
        shaped(state, (joints,)),
        shaped(onset, (joints,)),
        shaped(k, (STAGES, n + JOINT_WIDTH * joints)),
        row,
    )


def rates_of(scene, parameters) -> Entry:
    """Return the Entry of the right-hand side in time of the compiled `scene`."""
    return entry(rates_entry, scene, "fiff", parameters)


# ---------------------------------------------------------------------------------------------- Runge-Kutta 4


def runge_kutta_4(scene, times, step, separations=0) -> Solution:
    """Integrate with a fixed step and without event location.

    Parameters
    ----------
    scene : as `clearsweep.load_case` returns it; begins out of contact.
    times : (n,) s, equidistant and ending with the run; empty where `separations` ends it.
    step : s, shortened a little so that a whole number of steps lies between the times.
    separations : stop after so many; 0: at the last of the times.
    """
    parameters = flatten(scene.value)  # compiled code contains its address
    n, joints = 2 * len(scene.value.coordinates) + 1, len(scene.value.joints)
    steps_per_sample = 0
    if len(times):
        steps_per_sample = math.ceil(times[0] / step * (1.0 - 1e-9))
        step = times[0] / steps_per_sample
    states, log = np.zeros((len(times), n - 1)), np.zeros((MAX_EVENTS, 5))
    counts = np.array([*rates_of(scene.value, parameters), steps_per_sample, separations, 0, 0, 0])
    work = RungeKuttaState(
        y=scene.start[:n].copy(),
        z=np.zeros(n),
        k=np.zeros((STAGES, n + JOINT_WIDTH * joints)),
        state=np.full(joints, FREE),
        onset=np.ones(joints),
        peak=np.zeros(joints),
    )
    _march(work, counts, states, log, step)
    steps, evaluations, events = counts[STEPS:].tolist()
    return Solution(states, log[:events].copy(), steps, None, evaluations)


class RungeKuttaState(NamedTuple):
    """Arrays of Runge-Kutta 4: n numbers in the state, j joints."""

    y: np.ndarray  # (n,) state
    z: np.ndarray  # (n,) state of a stage
    k: np.ndarray  # (ROWS, n + JOINT_WIDTH j) as in `rates_in_time`
    state: np.ndarray  # (j,) int64, mode of each contact
    onset: np.ndarray  # (j,) m/s
    peak: np.ndarray  # (j,) N


CODE, PARAMETERS, STEPS_PER_SAMPLE, SEPARATIONS, STEPS, EVALUATIONS, EVENTS = range(7)  # of `counts`
MAX_EVENTS = 1 << 16  # capacity of the log


@machine_code
def _march(work, counts, states, log, step):
    """Take steps of Runge-Kutta 4; fill a row of `states` every counts[STEPS_PER_SAMPLE] steps.

    A contact begins at the first step with penetration, which also sets the onset rate, and ends at the first step
    without penetration.
    """
    y, z, k, state, onset, peak = work.y, work.z, work.k, work.state, work.onset, work.peak
    n, joints, steps_per_sample, separations = y.size, state.size, counts[STEPS_PER_SAMPLE], 0
    while separations < counts[SEPARATIONS] or counts[STEPS] < steps_per_sample * states.shape[0]:
        invoke(counts[CODE], counts[PARAMETERS], (y, state, onset, k), 0)
        counts[EVALUATIONS] += 4
        is_changed = False
        for j in range(joints):
            column = n + JOINT_WIDTH * j
            is_inside, rate = k[0, column + DEPTH_COLUMN] > 0.0, k[0, column + RATE_COLUMN]
            if is_inside != (state[j] != FREE) and counts[EVENTS] < MAX_EVENTS:
                event = counts[EVENTS]
                log[event, 0], log[event, 1], log[event, 3] = y[n - 1], j, rate
                log[event, 2], log[event, 4] = (ONSET, 0.0) if is_inside else (SEPARATION, peak[j])
                counts[EVENTS] += 1
            if is_inside and state[j] == FREE:
                state[j], onset[j], peak[j], is_changed = PRESSED, max(rate, ONSET_FLOOR), 0.0, True
            elif not is_inside and state[j] != FREE:
                state[j], is_changed = FREE, True
                separations += 1
        if is_changed:
            invoke(counts[CODE], counts[PARAMETERS], (y, state, onset, k), 0)
            counts[EVALUATIONS] += 1
        for j in range(joints):
            peak[j] = max(peak[j], k[0, n + JOINT_WIDTH * j + NORMAL_COLUMN])
        for row in range(1, STAGES):
            length = step if row == 3 else 0.5 * step
            for i in range(n):
                z[i] = y[i] + length * k[row - 1, i]
            invoke(counts[CODE], counts[PARAMETERS], (z, state, onset, k), row)
        for i in range(n):
            y[i] += step / 6.0 * (k[0, i] + 2.0 * k[1, i] + 2.0 * k[2, i] + k[3, i])
        counts[STEPS] += 1
        y[n - 1] = counts[STEPS] * step
        if steps_per_sample > 0 and counts[STEPS] % max(steps_per_sample, 1) == 0:
            for i in range(n - 1):
                states[counts[STEPS] // max(steps_per_sample, 1) - 1, i] = y[i]


# ---------------------------------------------------------------------------------------------- scipy


def rival_problem(case_scene) -> str:
    """Return why scipy cannot integrate a scene on our right-hand side in time; '' if it can."""
    if case_scene.mechanism.spatial:
        return "joints in space have several contacts each"
    if any(type(joint) is not Joint for joint in case_scene.value.joints):
        return "only dry pins of unworn shape have this right-hand side"
    if every_state(case_scene.value):
        return "laws with an internal state need its equations"
    return ""


def sampled(case_scene, times, solution: Solution) -> Trajectory:
    """Return a solution as a Trajectory: the journals' positions at `times` (n,) s, and the events."""
    names = [joint_layout.name for joint_layout in case_scene.layout.joints]
    prefixes = [f"joints/{name}" for name in names]
    channels = {f"{prefix}/{axis}": np.empty(len(times)) for prefix in prefixes for axis in "xy"}
    for row, (time, state) in enumerate(zip(times, solution.states, strict=True)):
        joint_gaps = gaps(case_scene.value.mechanism, pose_at(case_scene.value.mechanism, np.append(state, time)))
        for prefix, joint, gap in zip(prefixes, case_scene.value.joints, joint_gaps, strict=True):
            channels[f"{prefix}/x"][row], channels[f"{prefix}/y"][row] = joint.side * gap.x, joint.side * gap.y
    rows = [
        (moment, names[int(joint)], EVENT_KINDS[int(kind == SEPARATION)], rate, peak)
        for moment, joint, kind, rate, peak in solution.events
    ]
    return Trajectory("ok", "", {}, channels | {"t": times}, np.array(rows, EVENT_DTYPE))


def scipy_ivp(scene, times, end, tolerance, separations=0, method="DOP853") -> Solution:
    """Integrate with `scipy.integrate.solve_ivp` and its `method`, from event to event, located on dense output.

    `times` : (n,) s, output times, may be empty; `end` : s; or `separations`, after which to stop.  Errors are scaled
    as ours are, in clearances: the error of a step is at most `tolerance` times clearance, of rates times crank speed,
    regardless of the size of the coordinates.  There is no search for force peaks.
    """
    from scipy.integrate import solve_ivp

    compiled_scene, evaluate = scene.value, CountedRates(scene.value)
    coordinate_count, joints = len(compiled_scene.coordinates), len(compiled_scene.joints)
    period = 2.0 * math.pi / compiled_scene.reference_rate
    state, onset = evaluate.state, evaluate.onset

    def state_rates(t, y):
        return evaluate(t, y)[: 2 * coordinate_count].copy()

    def depth_of(j):
        row = 2 * coordinate_count + 1 + JOINT_WIDTH * j + DEPTH_COLUMN

        def depth(t, y):
            if at_event == j and t - begin < dead_time:  # 0 but for rounding, whose sign must not hide the next event
                return -TINY_DEPTH * depth.direction
            return evaluate(t, y)[row]

        depth.terminal = True
        return depth

    depths = [depth_of(j) for j in range(joints)]
    clearance = min(joint.clearance for joint in compiled_scene.joints)
    absolute_tolerance = tolerance * clearance * np.repeat([1.0, compiled_scene.reference_rate], coordinate_count)
    begin, y, at_event = 0.0, scene.start[: 2 * coordinate_count], -1
    dead_time, max_step = EVENT_DEAD_TIME * period, math.inf if separations else MAX_STEP_TURNS * period
    states, events, steps, separation_count = [], [], 0, 0
    while begin < end:
        for j in range(joints):
            depths[j].direction = 1.0 if state[j] == FREE else -1.0
        remaining = times[times > begin] if len(times) else None
        with np.errstate(all="ignore"):  # a trial step that is far too long may overflow; it is rejected
            solution = solve_ivp(
                state_rates,
                (begin, end),
                y,
                method,
                remaining,
                events=depths,
                rtol=LEAST_RELATIVE_TOLERANCE,
                atol=absolute_tolerance,
                max_step=max_step,
                dense_output=remaining is not None,
            )
        steps += len(solution.t if remaining is None else solution.sol.ts) - 1
        states += list(np.transpose(solution.y)) if remaining is not None and len(solution.t) else []
        if solution.status != 1:
            break
        j = at_event = min(
            (j for j in range(joints) if len(solution.t_events[j])), key=lambda j: solution.t_events[j][0]
        )
        begin, y = solution.t_events[j][0], solution.y_events[j][0]
        rate = evaluate(begin, y)[2 * coordinate_count + 1 + JOINT_WIDTH * j + RATE_COLUMN]
        kind = ONSET if state[j] == FREE else SEPARATION
        events.append((begin, j, kind, rate, 0.0))
        state[j], onset[j] = (PRESSED, max(rate, ONSET_FLOOR)) if kind == ONSET else (FREE, 1.0)
        separation_count += kind == SEPARATION
        if 0 < separations <= separation_count:
            break
    return Solution(np.array(states), np.array(events).reshape(-1, 5), steps, None, evaluate.count)


class CountedRates:
    """The right-hand side of a compiled scene for scipy, and how often it was evaluated."""

    def __init__(self, compiled_scene):
        """Begin out of contact."""
        self._parameters = flatten(compiled_scene)  # compiled code contains its address
        self._rates = rates_of(compiled_scene, self._parameters)
        coordinate_count, joints = len(compiled_scene.coordinates), len(compiled_scene.joints)
        self.state, self.onset, self.count = np.full(joints, FREE), np.ones(joints), 0
        self._k = np.zeros((STAGES, 2 * coordinate_count + 1 + JOINT_WIDTH * joints))
        self._z = np.empty(2 * coordinate_count + 1)
        self._call, self._code = compiled_call(), function_at(self._rates.code, 4)

    def __call__(self, t, y):
        """Return the first row of `rates_in_time` at a time (s) and the coordinates and their rates."""
        self.count += 1
        self._call(self._code, self._rates.parameters, t, y, self._z, self.state, self.onset, self._k)
        return self._k[0]


@functools.cache
def compiled_call():
    """Return the right-hand side as numba compiles it: one call from Python, as a user of scipy would write it."""
    from numba import njit

    @njit
    def call(code, parameters, t, y, z, state, onset, k):
        z[: y.size] = y
        z[y.size] = t
        code(parameters, z.ctypes, state.ctypes, onset.ctypes, k.ctypes, 0)

    return call
