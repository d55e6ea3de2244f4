"""Lyapunov exponent from a second, perturbed run that is rescaled whenever it departs from the first."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ...mechanics.laws.contract import touches
from ...mechanics.solver import event_actions, integration
from ...mechanics.solver.integration import Work
from .observed_run import Decision, Pausing, restore, snapshot_of

RESCALINGS = 20  # rescalings per revolution
DISTURBANCE, DISTURBANCE_PER_TOLERANCE, MAX_DISTURBANCE = (
    1e-6,
    1e3,
    1e-3,
)  # clearances: size after rescaling, and the least in tolerances
SMALLEST_DISTURBANCE = 1e-9  # of that: lower bound of a disturbance, to avoid the logarithm of zero
SATURATION = 0.1  # clearances: a saturated disturbance
ALIGNMENT_RUN = 4  # revolutions
HORIZON_SIZE = 0.01  # clearances: size at which prediction ends


class Branches(NamedTuple):
    """Indices of latched numbers that select the branch of a force law: by their sign, or by their value."""

    by_sign: Sequence[int] = ()
    by_value: Sequence[int] = ()


NO_BRANCHES = Branches()


class Perturbed:
    """A second run, perturbed and rescaled whenever it departs from the first (Benettin et al. 1980).

    The distance is measured at equal times, with coordinates in clearances and rates in clearances times crank
    speed. Rescaling multiplies all differences of the two states by the same factor. It waits while one
    run is in contact and the other is not. The perturbed run then continues with the step length of the first, so that
    steps and their errors hardly differ until one of the runs meets an event without the other.
    """

    per_revolution = RESCALINGS

    def __init__(
        self,
        control: integration.Control,
        run: Pausing,
        scale: np.ndarray,
        tolerance: float,
        branches: Branches = NO_BRANCHES,
    ):
        """Perturb the initial state of `run`.

        scale : (coordinates and rates,) unit of each; branches : while they differ, rescaling waits, as if only one run
        were in contact.
        """
        self.by_sign, self.by_value = list(branches.by_sign), list(branches.by_value)
        self.control = control._replace(keep_events=False, end=math.inf)
        self.run, self.work, self.scale, self.tolerance = run, run.work, scale, tolerance
        self.roots = slice(run.work.time + 1, run.work.time + 1 + run.work.mode.size)  # of penetrations, in the state
        self.size = max(DISTURBANCE, min(DISTURBANCE_PER_TOLERANCE * tolerance, MAX_DISTURBANCE))
        self.times: list[float] = []  # s
        self.growths: list[float] = []  # logarithm of the growth from the start to each of `times`
        self.status = integration.OK

    def observe(self, base: Work) -> Decision:
        """Advance the perturbed run to the present time of `base`; the run continues."""
        time = float(base.y[base.time])
        if not self.times:
            self.times, self.growths = [time], [0.0]
            self._displace(base, self.scale / math.sqrt(self.scale.size), 0.0, 0.0)
        elif self.status == integration.OK and time > self.work.y[base.time]:
            control = self.control._replace(window=time, pause=time)
            status, _ = self.run.advance(control)
            if status != integration.PAUSED:
                self.status = status
                return Decision.CONTINUE
            self._measure(base)
        return Decision.CONTINUE

    def _measure(self, base: Work) -> None:
        """Record the distance of the perturbed motion from `base`, and rescale it."""
        work, n = self.work, self.scale.size
        same_contacts = bool(np.all(work.mode == base.mode))
        same_contacts = same_contacts and bool(
            np.all(np.sign(work.latched[self.by_sign]) == np.sign(base.latched[self.by_sign]))
        )
        same_contacts = same_contacts and bool(np.all(work.latched[self.by_value] == base.latched[self.by_value]))
        distance = float(np.linalg.norm((work.y[:n] - base.y[:n]) / self.scale))
        if not same_contacts and distance < SATURATION:
            return
        self.times.append(float(base.y[base.time]))
        self.growths.append(self.growths[-1] + math.log(max(distance, SMALLEST_DISTURBANCE * self.size) / self.size))
        if same_contacts and distance > 0.0:
            depth_difference = np.square(work.y[self.roots]) - np.square(base.y[self.roots])
            self._displace(
                base,
                (work.y - base.y) / distance,
                (work.latched - base.latched) / distance,
                depth_difference / distance,
            )
        else:
            self._displace(base, self.scale / math.sqrt(n), 0.0, 0.0)

    def _displace(
        self, base: Work, direction: np.ndarray, latched: np.ndarray | float, depth_difference: np.ndarray | float
    ) -> None:
        """Place the perturbed motion next to `base`, displaced along `direction` in its first components.

        depth_difference : m, likewise of the penetrations.  At an onset they grow from nothing, and their roots do not
        follow a small displacement linearly.
        """
        work, smallest_root = self.work, event_actions.ONSET_ROOT * self.work.sigma
        restore(snapshot_of(base), work)
        work.y[: len(direction)] += self.size * direction
        work.latched[:] += self.size * latched
        roots = np.sqrt(
            np.maximum(np.square(base.y[self.roots]) + self.size * depth_difference, smallest_root * smallest_root)
        )
        work.y[self.roots] = np.where(touches(work.mode), roots, 0.0)

    def figures(self, period: float) -> dict[str, float | None]:
        """Return exponent and horizon, each None if undefined or if disturbances do not grow.

        In runs longer than ALIGNMENT_RUN the first revolution does not count: in it the disturbance aligns with the
        fastest growth.
        """
        exponent = horizon = None
        if self.status == integration.OK and len(self.times) > 1:
            turns = (np.array(self.times) - self.times[0]) / period
            first_sample = int(np.searchsorted(turns, 1.0)) if turns[-1] > ALIGNMENT_RUN else 0
            exponent = (self.growths[-1] - self.growths[first_sample]) / (self.times[-1] - self.times[first_sample])
        if exponent is not None and exponent > 0.0:
            horizon = max(math.log(HORIZON_SIZE / self.tolerance), 0.0) / (exponent * period)
        return {"lyapunov_exponent": exponent, "horizon_revolutions": horizon}
