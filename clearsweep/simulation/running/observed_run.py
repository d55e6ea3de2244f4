"""Runs with observers, which measure the growth of a perturbation or decide whether the run is long enough.

An observed run pauses between two steps and resumes without a trace: its motion and figures are, to the last bit, those
of a plain run of the same length and window. An observer may begin the window anew; a step then ends where it begins.
"""

import enum
import math
import time
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple, Protocol

import numpy as np

from ...language import phases
from ...language.wording import quantity_text
from ...mechanics.laws.contract import touches
from ...mechanics.solver import integration, step
from ...mechanics.solver.integration import Work
from ...tracing.memory import Fields
from ..setup.scene import Scene

# Progress of a case: the phases of an integration and of a life.


class Revolutions(phases.Phase):
    """The phase of an integration: its share of finished revolutions."""

    def __init__(self, scene: Scene):
        """Prepare for the integration of a scene."""
        super().__init__(self._text)
        self.revolutions = scene.case.simulate.revolutions if scene.mechanism.turns else None
        self.at_most_text = " at most" if scene.layout.until or scene.case.life else ""  # it may end earlier

    @property
    def turns(self) -> float:
        """Return the number of finished revolutions."""
        return (self.share or 0.0) * (self.revolutions or 0.0)

    def _text(self) -> str:
        if not self.revolutions or self.share is None:
            return "integrating"
        return f"revolution {self.turns:,.6g} of {self.revolutions:,.6g}{self.at_most_text}"


class LifeLimits(NamedTuple):
    """Settings that determine the time of a life."""

    limit: float  # m
    first_jump: float  # m, most wear in the first jump
    blocks: int  # at most
    min_revolutions: float  # revolutions of a block
    constant_rates: bool  # one block is enough
    further_lives: int = 0  # lives after this one, which take about as long


class Life(phases.Phase):
    """The phase of a life: its block, the limited wear (m), and the time of the remaining blocks."""

    def __init__(self, limits: LifeLimits, earlier_blocks: int, name: str = ""):
        """Prepare after `earlier_blocks` blocks in another process; `name` is that of a further life."""
        super().__init__(self._text, covers_nested=True)
        self.limits, self.earlier_blocks, self.name = limits, earlier_blocks, name
        self.block, self.worn, self.jump = 1, 0.0, limits.first_jump
        self.block_begin = self.begin  # s, start of the current block

    def _text(self) -> str:
        life = f"{self.name}, " if self.name else ""
        return f"{life}block {self.block}, {quantity_text(self.worn, 'm')} of {quantity_text(self.limits.limit, 'm')}"

    def reached(self, worn: float) -> None:
        """Record the end of a block, with the wear depth (m) that the limit refers to."""
        self.block, self.jump = self.block + 1, max(worn - self.worn, 0.0) or self.jump
        self.worn, self.block_begin, self.compile_time = worn, time.monotonic(), 0.0
        self.note(block=self.block, reached=worn, limit=self.limits.limit)

    def remaining_time(self, now: float) -> float | None:
        """Return the time (s) left, for jumps like the last one up to the limit."""
        block_time = self._block_seconds(now)
        if block_time is None:
            return None
        jumps = 0.0 if self.limits.constant_rates else max(self.limits.limit - self.worn, 0.0) / self.jump
        blocks = 1.0 + min(jumps, float(max(self.limits.blocks - self.block, 0)))
        remaining = max(block_time * blocks - (now - self.block_begin - self.compile_time), 0.0)
        return remaining + self.limits.further_lives * block_time * (self.block - 1 + blocks) or None

    def _block_seconds(self, now: float) -> float | None:
        """Return the time (s) of a block: the mean of finished blocks, or else the time of the shortest block."""
        finished_blocks = self.block - 1 - self.earlier_blocks
        if finished_blocks > 0:
            return (self.block_begin - self.begin) / finished_blocks
        integration_phase = phases.innermost_phase()
        if not isinstance(integration_phase, Revolutions) or not integration_phase.turns:
            return None
        return (now - integration_phase.begin - integration_phase.compile_time) * max(
            self.limits.min_revolutions / integration_phase.turns, 1.0
        )


#: Turns before the end of a revolution at which a run pauses: longer than a step, so that it can still end there.
PAUSE_LEAD = 0.025


_OF_RUN = "control", "counts", "log", "slopes", "step", "contact_steps", "profiles", "recording"
_OF_CONTACTS = "clearance", "film", "limit_depth", "has_friction", "has_histogram", "resultant"
_MODES = "apart", "pressed", "journal_sides"
#: Arrays of a run or of its scene, which the motion does not change
_NOT_OF_MOTION = {*_OF_RUN, *_OF_CONTACTS, *_MODES, "knots", "weight", "reset_by", "initial_internal"}
Snapshot = dict[str, np.ndarray]  # copies by name of all arrays that determine the further motion


class Decision(enum.IntEnum):
    """What an observer decides at the end of a revolution."""

    CONTINUE = 0
    END = 1  # end the run with this revolution
    BEGIN_WINDOW = 2  # begin the window of the figures at the end of this revolution


class Pausing(Protocol):
    """An integration that can pause and resume: a `run.Run`."""

    work: Work

    def advance(self, control: integration.Control) -> tuple[int, np.ndarray]:
        """Return status and events from the present state to the end or pause in `control`."""

    def forget_figures(self) -> None:
        """Forget the figures of the window, which begins anew later."""


class Observer(Protocol):
    """An observer of a run."""

    per_revolution: int  # observations per revolution, later perhaps fewer

    def observe(self, work: Work) -> Decision:
        """Observe the run; return a decision, at any but the end of a revolution CONTINUE."""


class LaterWindow:
    """Begins the window anew as another run did, whose motion is repeated."""

    per_revolution = 1

    def __init__(self, revolutions: float):
        """Prepare for a window that begins `revolutions` after the first one."""
        self.revolutions_left = round(revolutions)

    def observe(self, work: Work) -> Decision:
        """Return BEGIN_WINDOW at the end of the revolution before the window."""
        is_time = self.revolutions_left == 0
        self.revolutions_left -= 1
        return Decision.BEGIN_WINDOW if is_time else Decision.CONTINUE


def run_observed(
    control: integration.Control,
    run: Pausing,
    discard: float,
    value_after: Callable[[float], float],
    observers: Sequence[Observer],
) -> tuple[int, np.ndarray]:
    """Return the status and the events of an integration that `observers` observe.

    discard : revolutions before the first observation; value_after : revolutions -> clock, see `crank_clock`.
    """
    work, logs, per_revolution = run.work, [], max(observer.per_revolution for observer in observers)
    observation = 0
    while True:
        due = [each for each in observers if observation % (per_revolution // each.per_revolution) == 0]
        if not due:
            observation += 1
            continue
        turns = observation / per_revolution
        pause = value_after(discard + turns - PAUSE_LEAD if turns else discard)
        if pause >= control.end:
            break
        status, log = run.advance(control._replace(pause=pause))
        logs.append(log)
        if status != integration.PAUSED:
            return status, np.concatenate(logs)
        revolutions = discard + observation // per_revolution
        end = value_after(revolutions)
        decision = max(observer.observe(work) for observer in due)
        observation += 1
        if work.y[work.independent] >= end:
            continue
        if decision == Decision.BEGIN_WINDOW:
            run.forget_figures()
            control, discard, observation = control._replace(window=end), revolutions, 0
        elif decision == Decision.END:
            control = control._replace(end=end)
    status, log = run.advance(control)
    return status, np.concatenate([*logs, log])


def snapshot_of(work: Work) -> Snapshot:
    """Return copies of all arrays of `work` (integration.Work) that determine the further motion."""
    return {name: array.copy() for name, array in arrays_of_motion(work).items()}


def restore(snapshot: Snapshot, work: Work) -> None:
    """Restore `work` from the result of `snapshot_of`, of this or another run of the same scene."""
    arrays = arrays_of_motion(work)
    for name, array in snapshot.items():
        arrays[name][...] = array


def arrays_of_motion(work: Work) -> Snapshot:
    """Return what `snapshot_of` copies: the arrays by name, those of the implicit method among them."""
    implicit: Any = work.implicit  # mypy takes it for a tuple of anything
    fields: dict[str, Any] = work._asdict() | implicit._asdict()
    numbers = {name: value.numbers if isinstance(value, Fields) else value for name, value in fields.items()}
    return {
        name: value for name, value in numbers.items() if isinstance(value, np.ndarray) and name not in _NOT_OF_MOTION
    }


# Lyapunov exponent from a second, perturbed run that is rescaled whenever it departs from the first.

RESCALINGS = 20  # rescalings per revolution
# clearances: size after rescaling, and the least in tolerances
DISTURBANCE = 1e-6
DISTURBANCE_PER_TOLERANCE = 1e3
MAX_DISTURBANCE = 1e-3
SMALLEST_DISTURBANCE = 1e-9  # of that: lower bound of a disturbance, to avoid the logarithm of zero
SATURATION = 0.1  # clearances: a saturated disturbance
ALIGNMENT_RUN = 4  # revolutions
HORIZON_SIZE = 0.01  # clearances: size at which prediction ends


class Branches(NamedTuple):
    """Indices of latched numbers that select the branch of a force law: by their sign, or by their value."""

    by_sign: Sequence[int]
    by_value: Sequence[int]


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
        branches: Branches,
    ):
        """Perturb the initial state of `run`.

        scale : (coordinates and rates,) unit of each; branches : while they differ, rescaling waits, as if only one run
        were in contact.
        """
        self.branches = branches
        self.control = control._replace(keep_events=False, end=math.inf)
        self.run, self.work, self.scale, self.tolerance = run, run.work, scale, tolerance
        self.aligned = scale / math.sqrt(scale.size)
        self.roots = slice(run.work.time + 1, run.work.time + 1 + run.work.mode.size)  # of penetrations, in the state
        self.size = max(DISTURBANCE, min(DISTURBANCE_PER_TOLERANCE * tolerance, MAX_DISTURBANCE))
        self.arrays: list[tuple[np.ndarray, np.ndarray]] = []  # of this and of the other motion
        self.times: list[float] = []  # s
        self.growths: list[float] = []  # logarithm of the growth from the start to each of `times`
        self.status = integration.OK

    def observe(self, base: Work) -> Decision:
        """Advance the perturbed run to the present time of `base`; the run continues."""
        time = float(base.y[base.time])
        if not self.times:
            self.times, self.growths = [time], [0.0]
            self.arrays = list(zip(*(arrays_of_motion(work).values() for work in (self.work, base)), strict=True))
            self._displace(base, self.aligned, 0.0, 0.0)
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
        work = self.work
        same_branches = self._branches_of(work) == self._branches_of(base)
        difference = work.y - base.y
        scaled = difference[: self.scale.size] / self.scale
        distance = math.sqrt((scaled * scaled).sum())
        if not same_branches and distance < SATURATION:
            return
        self.times.append(float(base.y[base.time]))
        self.growths.append(self.growths[-1] + math.log(max(distance, SMALLEST_DISTURBANCE * self.size) / self.size))
        if same_branches and distance > 0.0:
            roots, base_roots = work.y[self.roots], base.y[self.roots]
            depth_difference = roots * roots - base_roots * base_roots
            latched = (work.latched - base.latched) / distance
            self._displace(base, difference / distance, latched, depth_difference / distance)
        else:
            self._displace(base, self.aligned, 0.0, 0.0)

    def _branches_of(self, work: Work) -> tuple[list, ...]:
        """Return the modes of the contacts and what selects the branches of their laws."""
        latched = work.latched.tolist()
        signs = [(latched[index] > 0.0) - (latched[index] < 0.0) for index in self.branches.by_sign]
        return work.mode.tolist(), signs, [latched[index] for index in self.branches.by_value]

    def _displace(
        self, base: Work, direction: np.ndarray, latched: np.ndarray | float, depth_difference: np.ndarray | float
    ) -> None:
        """Place the perturbed motion next to `base`, displaced along `direction` in its first components.

        depth_difference : m, likewise of the penetrations.  At an onset they grow from nothing, and their roots do not
        follow a small displacement linearly.
        """
        work, smallest_root = self.work, step.ONSET_ROOT * self.work.sigma
        for own_array, array in self.arrays:
            own_array[...] = array
        roots = work.y[self.roots]
        depths = np.maximum(roots * roots + self.size * depth_difference, smallest_root * smallest_root)
        work.y[: len(direction)] += self.size * direction
        work.latched[:] += self.size * latched
        roots[...] = np.sqrt(depths) * touches(work.mode)

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
