"""scipy's DOP853, stepped from Python and started anew at every contact onset and separation.

The right-hand side is plain compiled scalars, positions in m and rad, rates in those per radian of the crank, so that
one relative tolerance suits all.  Stepping `scipy.integrate.DOP853` takes a sixth less than `solve_ivp`.  First steps
ten times as long, and steps in flight twice as long or without bounds, gain nothing at equal error.
"""

import functools
import math

import numpy as np
from numba import njit
from scipy.integrate import DOP853
from scipy.optimize import brentq

from clearsweep.mechanics.solver.integration import ONSET, SEPARATION
from clearsweep.verify.accuracy import scene_of
from clearsweep.verify.rivals import EVENT_DEAD_TIME, Solution

from .mechanics import FLOOR, FREE, MODELS, PRESSED, margin, parameters

FIRST_FREE, FIRST_PRESSED = 1e-6, 1e-8  # s, first steps after an event
LONGEST = 1e-4  # s, in flight
ABSOLUTE = 1e-5  # absolute tolerance over the relative one
EXACT = 4.0 * np.finfo(float).eps  # to which events are located, as solve_ivp does


@functools.cache
def compiled(model):
    """Return the right-hand side and how far (m) the state is from its next event, as functions of t (s), y, record."""
    rates, depths, joints, size = model

    @njit(error_model="numpy")
    def slope(t, y, record):
        du = np.empty(size)
        rates(t, y, du, record[0])
        return du

    @njit(error_model="numpy")
    def upcoming(t, y, record):
        p = record[0]
        depths(t, y, p)
        least = p.clearance  # where no joint is looked at: a root is searched for between finite values
        for j in range(joints):
            least = min(least, margin(p, j, t))
        return least

    return slope, upcoming


class _Drive:
    """An integration under way."""

    def __init__(self, problem, model, fresh):
        self.record, self.model, self.end = fresh.copy(), model, problem.end
        self.slope, self.stepper = compiled(model)
        self.events, self.spans = [], []

    def run(self, y, tolerance, *, keep):
        """Integrate from `y`; `keep`: dense output of all steps."""
        t = 0.0
        while t is not None:
            t, y = self._to_event(t, y, tolerance, keep=keep)
            if t is not None:
                self._switch(t, y)

    def _to_event(self, t, y, tolerance, *, keep):
        record, upcoming, compiled_slope = self.record, self.stepper, self.slope

        def slope(t, y):
            return compiled_slope(t, y, record)

        flight = not record["state"].any()
        solver = DOP853(
            slope,
            t,
            y,
            self.end,
            max_step=LONGEST if flight else math.inf,
            rtol=tolerance,
            atol=ABSOLUTE * tolerance,
            first_step=min(FIRST_FREE if flight else FIRST_PRESSED, self.end - t),
        )
        solver.fun = slope  # without the wrappers that count and convert: 6 % faster
        before = upcoming(t, y, record)
        while solver.status == "running":
            solver.step()
            after = upcoming(solver.t, solver.y, record)
            passed = after <= 0.0 <= before
            if passed or keep:
                dense = solver.dense_output()
                self.spans += [dense] if keep else []
            if passed:
                t = brentq(_margin, solver.t_old, solver.t, args=(dense, upcoming, record), xtol=EXACT, rtol=EXACT)
                return t, dense(t)
            before = after
        return None, y

    def _switch(self, t, y):
        self.slope(t, y, self.record)
        p = self.record[0]
        j = min(range(self.model.joints), key=lambda j: margin(p, j, t))
        kind, rate = ONSET if p["state"][j] == FREE else SEPARATION, p["closing_rate"][j]
        self.events.append((t, j, kind, rate, 0.0))
        p["state"][j] = PRESSED if kind == ONSET else FREE
        if kind == ONSET:
            p["onset"][j] = max(rate, FLOOR)
        p["latest"], p["blind"] = j, t + EVENT_DEAD_TIME * 2.0 * math.pi / p["rate"]

    def at(self, times):
        """Return the states at `times` (s), each by the last step that reaches it: earlier ones went past an event."""
        ends = np.array([dense.t_old for dense in self.spans])
        return np.array([self.spans[np.searchsorted(ends, time, side="left") - 1](time) for time in times])


def _margin(t, dense, upcoming, record):
    return upcoming(t, dense(t), record)


def prepared(problem, tolerance):
    """Return a function that integrates a problem and returns its _Drive, and the units of the state."""
    scene = scene_of(problem, tolerance)
    model, fresh = MODELS[tuple(problem.grid["joints"])], parameters(scene)
    fresh["place"] = fresh["angle"] = 1.0
    fresh["speed"] = fresh["spin"] = fresh["rate"]
    unit = np.repeat([1.0, fresh["rate"][0]], model.size // 2)
    start = scene.start[: model.size] / unit

    def integrate(*, keep=False):
        drive = _Drive(problem, model, fresh)
        drive.run(start, tolerance, keep=keep)
        return drive

    return integrate, unit


def repeat(problem, tolerance):
    """Return a function that integrates a problem, to be timed: events alone."""
    integrate, _ = prepared(problem, tolerance)
    return lambda: integrate() and None


def solve(problem, tolerance) -> Solution:
    """Return the Solution of a problem at its times; force peaks are not searched for."""
    integrate, unit = prepared(problem, tolerance)
    evaluations, drive = int(integrate().record["evaluations"][0]), integrate(keep=True)
    return Solution(drive.at(problem.times) * unit, np.array(drive.events), len(drive.spans), None, evaluations)
