"""heyoka's Taylor series, stopped at every contact onset and separation by its own event detection, on `b_base` alone.

One integrator flies, one is in contact; Python goes from one to the other.  The force grows with depth^1.5, which has
no Taylor series at depth zero: contact begins and ends at a depth of a nanometre, where the force is milli-newtons.
"""

import functools
import math

import heyoka as hy
import numpy as np

from clearsweep.mechanics.solver.integration import ONSET, SEPARATION
from clearsweep.verify.accuracy import scene_of
from clearsweep.verify.rivals import Solution

from .mechanics import FREE, PRESSED

SHALLOW = 1e-9  # m


@functools.cache
def integrators(tolerance, mechanism, joint, rate):
    """Return the integrators of free flight and of contact, whose parameter is the onset rate (m/s); no gravity."""
    crank, rod, center, rod_mass, rod_inertia, slider_mass = mechanism
    clearance, stiffness, loss = joint
    angle, x, spin, v = hy.make_vars("angle", "x", "spin", "v")
    turn, tip = rate * hy.time, crank * rate
    c, s = hy.cos(angle), hy.sin(angle)
    dx, dy = x - crank * hy.cos(turn) - rod * c, -crank * hy.sin(turn) - rod * s
    vx, vy = v + tip * hy.sin(turn) + rod * spin * s, -tip * hy.cos(turn) - rod * spin * c
    pull = tip * rate * rod_mass * center * (c * hy.sin(turn) - s * hy.cos(turn))
    inertia = rod_inertia + rod_mass * center * center
    flight = [(angle, spin), (x, v), (spin, pull / inertia), (v, 0.0 * x)]
    away = hy.sqrt(dx * dx + dy * dy)
    depth, last_lines = away - clearance, (dx * vx + dy * vy) / away
    normal = stiffness * depth**1.5 * (1.0 + loss * last_lines / hy.par[0])
    fx, fy = -normal * dx / away, -normal * dy / away
    angle_rate = (pull - rod * (c * fy - s * fx)) / inertia
    contact = [(angle, spin), (x, v), (spin, angle_rate), (v, fx / slider_mass)]
    onset = hy.t_event(dx * dx + dy * dy - clearance * clearance, direction=hy.event_direction.positive)
    parting = hy.t_event(depth - SHALLOW, direction=hy.event_direction.negative)
    start = [0.1, 0.1, 0.0, 0.0]
    return (
        hy.taylor_adaptive(flight, start, tol=tolerance, t_events=[onset]),
        hy.taylor_adaptive(contact, start, tol=tolerance, pars=[1.0], t_events=[parting]),
    )


def prepared(problem, tolerance):
    """Return a function that integrates the problem and returns (events, state at every time asked for, steps)."""
    scene = scene_of(problem, tolerance)
    case = scene.case
    joint, rate = case.joints[0], case.drive.speed
    contact = joint.contact.values
    crank, rod_length = case.mechanism.values["crank.length"], case.mechanism.values["rod.length"]
    loss = 0.75 * (1.0 - contact["restitution"] ** 2)
    names = ("crank.length", "rod.length", "rod.center", "rod.mass", "rod.inertia", "slider.mass")
    links = tuple(case.mechanism.values[name] for name in names)
    both = integrators(tolerance, links, (joint.clearance, contact["stiffness"], loss), rate)

    def depth_and_rate(t, y):
        c, s, c1, s1 = math.cos(y[0]), math.sin(y[0]), math.cos(rate * t), math.sin(rate * t)
        dx, dy = y[1] - crank * c1 - rod_length * c, -crank * s1 - rod_length * s
        vx = y[3] + rate * crank * s1 + rod_length * y[2] * s
        vy = -rate * crank * c1 - rod_length * y[2] * c
        away = math.hypot(dx, dy)
        return away - joint.clearance, (dx * vx + dy * vy) / away

    def integrate(times):
        state, t, y, steps, events, states = FREE, 0.0, scene.start[:4], 0, [], []
        while True:
            run = both[state]
            run.time, run.state[:] = t, y
            run.reset_cooldowns()  # those of the last flight or contact
            outcome, *_, taken, output, _ = run.propagate_until(problem.end, c_output=len(times) > 0)
            steps += taken
            if len(times):
                states += [output(time).copy() for time in times[(times > t) & (times <= run.time)]]
            if outcome == hy.taylor_outcome.time_limit:
                return np.array(events), np.array(states), steps
            depth, speed = depth_and_rate(run.time, run.state)
            events.append((run.time, 0, ONSET if state == FREE else SEPARATION, speed, 0.0))
            if state == FREE:
                both[PRESSED].pars[0] = speed
                run.propagate_for((SHALLOW - depth) / speed)  # the event is off by as much as the step
            t, y, state = run.time, run.state.copy(), PRESSED - state

    return integrate


def repeat(problem, tolerance):
    """Return a function that integrates the problem, to be timed."""
    integrate = prepared(problem, tolerance)
    return lambda: integrate(()) and None


def solve(problem, tolerance) -> Solution:
    """Return the Solution of the problem at its times; there are steps, but no evaluations to count."""
    events, states, steps = prepared(problem, tolerance)(problem.times)
    return Solution(states, events, steps, None, None)
