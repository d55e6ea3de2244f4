"""Lyapunov exponent: a second, perturbed run is brought back towards the first whenever it has departed."""

import math
from collections.abc import Sequence

import numpy as np

from ..mechanics.joint.contract import touches
from ..mechanics.solver import event_actions, run_control
from ..mechanics.solver.event import Work
from .watch import Pausing, go_to, moment_of

PARTS = 20  # of a revolution: a disturbance is brought back so often
SIZE, OVER, MOST = 1e-6, 1e3, 1e-3  # clearances: what it is brought back to; so many tolerances if that is more
FAINTEST = 1e-9  # of that: where a motion forgets a disturbance altogether, no logarithm of zero
SATURATED = 0.1  # clearances: a disturbance that grows no more
SETTLED = 4  # revolutions
HORIZON = 0.01  # clearances: where prediction ends


class Perturbed:
    """A second run, perturbed, and brought back whenever it has departed from the first: Benettin et al. 1980.

    The distance is that of the coordinates in clearances and of their rates in clearances times crank rate, at equal
    times. To bring the run back, all differences of the two states are scaled by the same factor. This waits while one
    run is in contact and the other is not. The perturbed run then continues with the step length of the first, so that
    steps and their errors hardly differ until one of the runs meets an event without the other.
    """

    parts = PARTS

    def __init__(
        self,
        control: run_control.Control,
        run: Pausing,
        scale: np.ndarray,
        tolerance: float,
        phases: Sequence[int] = (),
    ):
        """Perturb the motion in `run`, unused so far.

        scale : (coordinates and rates,) what counts as 1; phases : places of latched numbers whose sign says by what
        rule a force goes: where they differ, the two motions wait as if one were in contact and the other not.
        """
        self.phases = list(phases)
        self.control = control._replace(keep_events=False, end=math.inf)
        self.run, self.work, self.scale, self.tolerance = run, run.work, scale, tolerance
        self.size = max(SIZE, min(OVER * tolerance, MOST))
        self.times: list[float] = []  # s
        self.growths: list[float] = []  # logarithm of the growth from the start to each of `times`
        self.status = run_control.OK

    def see(self, base: Work) -> bool:
        """Follow `base` to where it is now."""
        moment = float(base.y[base.time])
        if not self.times:
            self.times, self.growths = [moment], [0.0]
            self._bring(base, self.scale / math.sqrt(self.scale.size), 0.0)
        elif self.status == run_control.OK and moment > self.work.y[base.time]:
            control = self.control._replace(window=moment, pause=moment)
            status, _ = self.run.go(control)
            if status != run_control.PAUSED:
                self.status = status
                return False
            self._measure(base)
        return False

    def _measure(self, base: Work) -> None:
        """Record the distance of the perturbed motion from `base`, and rescale it."""
        work, n = self.work, self.scale.size
        alike = bool(np.all(work.mode == base.mode))
        alike = alike and bool(np.all(np.sign(work.latched[self.phases]) == np.sign(base.latched[self.phases])))
        off = float(np.linalg.norm((work.y[:n] - base.y[:n]) / self.scale))
        if not alike and off < SATURATED:
            return
        self.times.append(float(base.y[base.time]))
        self.growths.append(self.growths[-1] + math.log(max(off, FAINTEST * self.size) / self.size))
        if alike and off > 0.0:
            self._bring(base, (work.y - base.y) / off, (work.latched - base.latched) / off)
        else:
            self._bring(base, self.scale / math.sqrt(n), 0.0)

    def _bring(self, base: Work, direction: np.ndarray, latched: np.ndarray | float) -> None:
        """Put the perturbed motion next to `base`, off in (the first components of) the state and in latches."""
        work = self.work
        go_to(moment_of(base), work)
        work.y[: len(direction)] += self.size * direction
        work.latched[:] += self.size * latched
        roots = work.y[work.time + 1 : work.time + 1 + work.mode.size]
        roots[:] = np.where(touches(work.mode), np.maximum(roots, event_actions.SEED * work.sigma), 0.0)

    def figures(self, turn: float) -> dict[str, float | None]:
        """Return the exponent and the horizon, or None if there is none, or where a disturbance does not grow.

        Of more than SETTLED revolutions the first does not count: in it the disturbance turns to where it grows most.
        """
        exponent = horizon = None
        if self.status == run_control.OK and len(self.times) > 1:
            turns = (np.array(self.times) - self.times[0]) / turn
            first = int(np.searchsorted(turns, 1.0)) if turns[-1] > SETTLED else 0
            exponent = (self.growths[-1] - self.growths[first]) / (self.times[-1] - self.times[first])
        if exponent is not None and exponent > 0.0:
            horizon = max(math.log(HORIZON / self.tolerance), 0.0) / (exponent * turn)
        return {"lyapunov_exponent": exponent, "horizon_revolutions": horizon}
