"""The temperature at which a film stands: what it takes is led away, and the warmer the oil, the thinner it is.

It is the equilibrium, T = ambient + mean loss / conductance of every joint with a heat balance, not the hours of
warming up.  The case is run at a temperature, its loss gives the next one by the secant method, until the two differ by
no more than CLOSE or NEAR of the rise above ambient.  After PATIENT runs a difference within the scatter of the
revolutions is accepted, too, up to UNSURE of the rise.  The first guess, the ambient, is never accepted.
"""

import dataclasses
import math
from typing import NamedTuple

import numpy as np

from ..contracts.case import Case, Film
from ..mechanics.solver import plan
from ..mechanics.solver.accumulate.tally import HEAT
from ..mechanics.solver.event import Work
from .run import integrated
from .scene import Scene, build
from .sums import half_width

CLOSE = 0.02  # K
NEAR = 0.01  # of the rise
PATIENT = 8  # runs
UNSURE = 0.1  # of the rise: a temperature that is known less closely is remarked on
MOST = 30  # runs
CAUTIOUS = 0.5  # of the way to where the loss points, in the first step


class Balance(NamedTuple):
    """Where the heat balances of a case stand, joint by joint."""

    temperature: dict[str, float]  # K, by column name
    width: dict[str, float]  # K, half of the 95 % interval; inf: too few revolutions to give one
    rise: dict[str, float]  # K, above ambient
    stands: bool

    def unsure(self) -> dict[str, tuple[float, float, float]]:
        """Return temperature, half-width and rise (K) of every joint whose temperature is known less than UNSURE."""
        return {
            joint: (self.temperature[joint], width, self.rise[joint])
            for joint, width in self.width.items()
            if width > max(CLOSE, UNSURE * self.rise[joint])
        }


class _Blocks:
    """Notes the heat of every film at the end of each revolution."""

    parts = 1

    def __init__(self, rows: list[int]):
        """Take the contacts to look at."""
        self.rows = rows
        self.times: list[float] = []
        self.sums: list[np.ndarray] = []

    def see(self, work: Work) -> bool:
        """Note the time (s) and what has been summed up (J); the run goes on."""
        self.times.append(float(work.y[work.time]))
        self.sums.append(work.tally.joint[self.rows, HEAT].copy())  # type: ignore[attr-defined]
        return False


def has_balance(case: Case) -> bool:
    """Return whether the temperature of a film is to be found."""
    return any(joint.film and joint.film.thermal for joint in case.joints)


def balanced(scene: Scene) -> tuple[Scene, Balance]:
    """Return the scene of a case with its oils at the temperatures at which they stand, and these.

    Where a run on the way fails, that is the scene that fails.
    """
    joints = [joint for joint in scene.case.joints if joint.film and joint.film.thermal]
    names = [joint.column for joint in joints]
    thermals = [joint.film.thermal for joint in joints if joint.film and joint.film.thermal]
    ambient = np.array([thermal.ambient for thermal in thermals])
    conductance = np.array([thermal.conductance for thermal in thermals])
    here, last, missing = ambient.copy(), ambient.copy(), np.zeros(len(names))
    width, stands = np.full(len(names), math.inf), False
    for run in range(MOST):
        scene = at_temperatures(scene, dict(zip(names, here, strict=True)))
        measured = _losses(scene, names)
        if measured is None:
            break
        loss, width = measured
        found, width = ambient + loss / conductance, width / conductance
        before, missing = missing, found - here
        allowed = np.maximum(CLOSE, NEAR * (found - ambient))
        if run >= PATIENT:
            allowed = np.maximum(allowed, np.minimum(width, UNSURE * (found - ambient)))
        stands = run > 0 and bool(np.all(np.abs(missing) <= allowed))
        if stands or run == MOST - 1:
            break
        step = CAUTIOUS * missing
        if run:
            bend = missing - before
            moved = here - last
            secant = np.where(bend * moved < 0.0, -missing * moved / np.where(bend == 0.0, 1.0, bend), step)
            step = np.clip(secant, -2.0 * np.abs(missing), 2.0 * np.abs(missing))
        last, here = here, np.maximum(here + step, ambient)
    at, within, rise = (dict(zip(names, map(float, each), strict=True)) for each in (here, width, here - ambient))
    return scene, Balance(at, within, rise, stands)


def at_temperatures(scene: Scene, temperatures: dict[str, float]) -> Scene:
    """Return the scene with the oil of some joints at other temperatures (K)."""
    joints = tuple(
        joint._replace(film=_at(joint.film, temperatures[joint.column])) if joint.column in temperatures else joint
        for joint in scene.case.joints
    )
    return dataclasses.replace(build(scene.case._replace(joints=joints), scene.worn), deadline=scene.deadline)


def _at(film: Film | None, temperature: float) -> Film:
    assert film is not None  # asked of films whose oil is known
    assert film.oil is not None
    return film._replace(temperature=temperature, viscosity=film.oil.viscosity(temperature))


def _losses(scene: Scene, names: list[str]) -> tuple[np.ndarray, np.ndarray] | None:
    """Return the mean loss (W) in some joints over the window, and half of its 95 % interval; None: the run failed."""
    ends = np.cumsum([len(joint.contacts) for joint in scene.layout.joints])
    rows = [int(end) - 1 for end, joint in zip(ends, scene.layout.joints, strict=True) if joint.name in names]
    settings, blocks = scene.case.simulate, _Blocks(rows)
    end = scene.turning.at(settings.revolutions)
    run = integrated(scene, np.empty(0), end, (blocks,), turned=True)
    if run.status != plan.OK:
        return None
    blocks.see(run.work)
    times, sums = np.array(blocks.times), np.array(blocks.sums)
    means = np.diff(sums, axis=0) / np.diff(times)[:, None]
    widths = np.array([half_width(means[:, k]) if len(means) > 1 else math.inf for k in range(len(rows))])
    return (sums[-1] - sums[0]) / (times[-1] - times[0]), widths
