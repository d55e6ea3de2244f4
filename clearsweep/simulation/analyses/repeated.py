"""Runs before a case, and runs until a criterion is met: chains of cases, a heat balance, a precision."""

import dataclasses
import itertools
import math
from collections import deque
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from ...contracts.case import REFERENCE_TEMPERATURE, Case, Joint
from ...contracts.layout import Layout
from ...language import phases
from ...language.errors import InputError
from ...mechanics.solver import integration
from ...mechanics.solver.integration import Work
from ...mechanics.wear import Worn
from ..figures.catalogue import MIN_REVOLUTIONS, Blocks
from ..figures.sums import half_width
from ..figures.window import NO_COST, Cost, by_joint
from ..running.observed_run import Decision, Snapshot, snapshot_of
from ..running.run import Run, integration_of, release
from ..setup import scene as setup
from ..setup.places import Carried, contact_units, places_of, units_of
from ..setup.scene import Scene
from ..setup.start import MARK_TOLERANCE, MIN_REPEATS, NO_TIMES, Marks, marks_of, repetition_of

# ---------------------------------------------------------------------------------------------- chains of cases


#: The cases of the chain that this process computed last, and how they ended.
_chain: list[tuple[Case, Carried]] = []


def build(case: Case, worn: Mapping[str, Worn] | None = None) -> Scene:
    """Return the scene of a case, which starts where the case before it in its chain ended, if it has one.

    What was computed last in this process is not computed again; the rest of the chain is run before it.
    `worn` is as in `setup.scene.build`, for a case without others before it.  Raises InputError if the initial state is
    impossible, or if a case before it failed.
    """
    if not case.before:
        return setup.build(case, worn)
    shared = itertools.takewhile(lambda pair: pair[0][0] == pair[1], zip(_chain, case.before, strict=False))
    del _chain[len([*shared]) :]
    for number, earlier in enumerate(case.before[len(_chain) :], start=len(_chain) + 1):
        with phases.phase(f"case {number} of {len(case.before)} before it in its chain"):
            scene = _scene(earlier)
            end = scene.crank_clock.value_after(earlier.simulate.revolutions)
            run = integration_of(scene, NO_TIMES, end, marks=marks_of(scene, earlier.simulate.revolutions))
        if run.status != integration.OK:
            place = f"number {number} of {len(case.before)} before it"
            raise InputError(f"simulate.start: carried needs the end of a case that failed, {place}; see its status")
        _chain.append((earlier, _end_of(scene, run)))
        release(run)
    return _scene(case)


def _scene(case: Case) -> Scene:
    """Return the scene of a case after those that are known."""
    return setup.build(case._replace(before=()), earlier_end=_chain[-1][1] if _chain else None)


def keep_end(scene: Scene, run: Run) -> None:
    """Keep the end of a finished run if it continues the chain, so that the next case need not run it again."""
    if scene.case.simulate.start != "carried" or run.status != integration.OK:
        return
    if scene.earlier_end is None:
        _chain.clear()
    if scene.earlier_end is (_chain[-1][1] if _chain else None):
        _chain.append((scene.case, _end_of(scene, run)))


def _end_of(scene: Scene, run: Run) -> Carried:
    """Return the end of a run in the units that the next case shares."""
    work, joints, rate = run.work, scene.value.joints, scene.value.reference_rate
    state: np.ndarray = work.end if np.any(work.end) else work.y
    places, rates = places_of(scene.built, state[: work.time + 1])
    units, contacts = units_of(joints), contact_units(joints)
    own, latched = state[work.time + 1 :], work.latched.copy()
    latched[: len(contacts)] /= contacts * abs(rate)
    return Carried(
        places / units,
        rates / (units * abs(rate)),
        own[: len(contacts)] / np.sqrt(contacts),
        own[len(contacts) :].copy(),
        latched,
        work.mode.copy(),
    )


# Decides whether a run is long enough: the interval of its figure is narrow, in periodic or in other motion.


class WindowLength:
    """Decides at every revolution whether the window is long enough to know a figure.

    Once the motion is periodic, the window is begun anew, because the motion before it, the run-in, never occurs again.
    The figures are then those of whole periods.
    """

    def __init__(self, scene: Scene, marks: Marks, figures: Sequence[str], accuracy: tuple[str, float], longest: float):
        """Prepare for a run of `scene`.

        marks : of the run; figures : those with blocks; accuracy : the figure that decides, and the largest half-width
        of its interval relative to it; longest : revolutions of the longest run
        """
        self.scene, self.marks, self.figures, self.longest = scene, marks, figures, longest
        self.figure, self.relative = accuracy
        settings, save = scene.case.simulate, scene.case.save
        self.discard, self.shortest = settings.discard, settings.revolutions  # revolutions
        self.revolutions = self.discard
        self.blocks = Blocks(scene.layout, figures)
        self.interval = self.blocks.interval(self.figure)
        self.turns, self.settled = 0, False  # turns: revolutions of the window
        # snapshots, oldest first, from which the saved revolutions can be repeated
        self.snapshots: deque[Snapshot] = deque(maxlen=math.ceil(save.revolutions) + 1 if save.orbits == "last" else 1)

    def observe(self, work: Work) -> Decision:
        """Return the decision at the end of a revolution, or at the start of the window.

        A run pauses shortly before the end of a revolution, so the blocks begin in the first revolution of the window.
        """
        turns, self.turns = self.turns, self.turns + 1
        self.revolutions = self.discard + turns
        self.take_snapshot(work)
        if not turns:
            return Decision.CONTINUE
        revolutions: Any = work.revolutions  # mypy takes it for a tuple of anything
        repetition = repetition_of(self.scene, self.marks, revolutions)
        period = repetition.period if repetition else None
        leaves_room = period is not None and self.revolutions + (MIN_REPEATS + 1) * period <= self.longest
        if period != self.blocks.period and leaves_room:
            self.discard, self.blocks = self.revolutions, Blocks(self.scene.layout, self.figures, period)
            self.turns, self.settled = 0, False
            return Decision.BEGIN_WINDOW
        if self.blocks.record(work):
            self.interval = self.blocks.interval(self.figure)
        is_narrow = self.interval.within(self.relative)
        if self.blocks.period:
            has_whole_periods = turns % self.blocks.period == 0 and self.interval.blocks >= MIN_REPEATS
            self.settled = is_narrow and has_whole_periods and repetition is not None
        else:
            self.settled = is_narrow and self.interval.revolutions >= MIN_REVOLUTIONS
        return Decision.END if self.settled and self.revolutions >= self.shortest else Decision.CONTINUE

    def take_snapshot(self, work: Work) -> None:
        """Take a snapshot, from which the saved revolutions can be repeated."""
        self.snapshots.append(snapshot_of(work))


class ConvergenceObserver(WindowLength):
    """Ends a run when its figure has converged."""

    per_revolution = 1

    def __init__(self, scene: Scene, marks: Marks):
        """Prepare for a run of `scene` with these marks."""
        until = scene.case.simulate.until
        assert until is not None  # asked of cases that have one
        super().__init__(scene, marks, (until.figure,), (until.figure, until.relative_ci), longest_run(scene.case))

    def results(self) -> dict[str, float | None]:
        """Return the results as columns of the summary."""
        return {
            "revolutions_run": self.revolutions,
            "window_from": self.discard,
            "figure_ci": self.interval.half_width if math.isfinite(self.interval.half_width) else None,
            "settled": int(self.settled),
        }


def longest_run(case: Case) -> float:
    """Return the largest number of revolutions of a block of a life, or of a run with `until`.

    These are `discard` plus whole ones.
    """
    criterion, discard = case.life or case.simulate.until, case.simulate.discard
    assert criterion is not None  # asked of cases that have one
    return discard + math.floor(criterion.max_revolutions - discard + MARK_TOLERANCE)


# Equilibrium temperature of a joint: friction loss equals conducted heat.
#
# The warmer the oil of a joint, the thinner it is; the warmer a dry joint, the wider or narrower its clearance. The
# temperature is that of equilibrium, T = ambient + mean loss / conductance of every joint with a heat balance; the
# hours of warming up are left out. The case is run at a temperature, and its loss gives the next one by the secant
# method until both agree within ABSOLUTE_TOLERANCE or RELATIVE_TOLERANCE of the rise above ambient. After STRICT_RUNS
# runs a difference within the scatter of the revolutions is also accepted, up to DOUBTFUL_WIDTH of the rise. The
# first guess, the ambient temperature, is never accepted.

ABSOLUTE_TOLERANCE = 0.02  # K
RELATIVE_TOLERANCE = 0.01  # of the rise
STRICT_RUNS = 8  # runs
DOUBTFUL_WIDTH = 0.1  # of the rise: a less accurate temperature gets a remark
MAX_RUNS = 30  # runs
FILM_DAMPING = 0.5  # damping of a film's first step: oil thins as it warms up
DRY_TOLERANCE, EARLY_RUNS = 1e-7, 5  # of the rise: accuracy for a dry joint while there are fewer runs than STRICT_RUNS
SEIZED_CLEARANCE = 0.01  # of the cold clearance: a joint with less has seized


class Balance(NamedTuple):
    """Temperatures of the joints of a case, and the temperatures that follow from their losses."""

    temperature: dict[str, float]  # K, by column name
    width: dict[str, float]  # K, half-width of the 95 % interval; inf: too few revolutions
    rise: dict[str, float]  # K, above ambient
    converged: bool
    cold: tuple[Joint, ...]  # joints as in the grid, before any temperature is applied
    implied: dict[str, float]  # K, implied by the last loss
    seized: tuple[str, ...]  # column names of dry joints whose clearance closes before equilibrium
    cost: Cost  # of all integrations

    def doubtful(self) -> dict[str, tuple[float, float, float]]:
        """Return temperature, half-width and rise (K) of each joint with a half-width above its DOUBTFUL_WIDTH."""
        return {
            joint: (self.temperature[joint], width, self.rise[joint])
            for joint, width in self.width.items()
            if width > max(ABSOLUTE_TOLERANCE, DOUBTFUL_WIDTH * self.rise[joint])
        }


class Losses(NamedTuple):
    """Losses of the joints with a heat balance in the window of a run."""

    mean: np.ndarray  # (joints,) W
    width: np.ndarray  # (joints,) W, half of the 95 % interval; inf: too few revolutions
    cost: Cost


class HeatObserver:
    """Records the heat of the observed joints once in each revolution."""

    per_revolution = 1

    def __init__(self, layout: Layout, energies: dict[int, str]):
        """Prepare for joints, by index, with the field of ContactTotals in which the heat of each accumulates."""
        self.layout, self.energies = layout, energies
        self.times: list[float] = []
        self.sums: list[np.ndarray] = []

    def observe(self, work: Work) -> Decision:
        """Record the time (s) and the accumulated energies (J); the run continues."""
        self.times.append(float(work.end[work.time]))  # at the end of a run `y` is the start of its last step
        totals: Any = work.totals  # mypy takes it for a tuple of anything
        joints = by_joint(totals, self.layout).joint
        self.sums.append(np.array([getattr(joints[index], field) for index, field in self.energies.items()]))
        return Decision.CONTINUE

    def losses(self, cost: Cost) -> Losses:
        """Return the losses between the first and the last time, of a run with this cost.

        A run pauses shortly before the ends of revolutions, so the first mean and the last are of a part of one.  The
        interval is that of the whole revolutions between them.
        """
        times, sums = np.array(self.times), np.array(self.sums)
        means = (np.diff(sums, axis=0) / np.diff(times)[:, None])[1:-1]
        widths = np.array(list(map(half_width, means.T)))
        return Losses((sums[-1] - sums[0]) / (times[-1] - times[0]), widths, cost)


def has_balance(case: Case) -> bool:
    """Return whether a joint of the case has a heat balance."""
    return any(joint.heat_balance for joint in case.joints)


def at_equilibrium(scene: Scene) -> tuple[Scene, Balance]:
    """Return the scene with its joints at equilibrium temperature, and the temperatures.

    If a run fails, its scene is returned.
    """
    joints = [joint for joint in scene.case.joints if joint.heat_balance]
    names, cold_scene = [joint.column for joint in joints], scene
    balances = [joint.heat_balance for joint in joints if joint.heat_balance]
    ambient = np.array([thermal.ambient for thermal in balances])
    conductance = np.array([thermal.conductance for thermal in balances])
    is_dry = np.array([joint.film is None for joint in joints])
    seizure = np.array(list(map(_seizure_temperature, joints)))
    temperatures, last_temperatures, residual = np.minimum(ambient, seizure), ambient.copy(), np.zeros(len(names))
    width, converged, implied_temperatures = np.full(len(names), math.inf), False, ambient
    cost = NO_COST
    for run_index in range(MAX_RUNS):
        scene = at_temperatures(cold_scene, dict(zip(names, temperatures, strict=True)))
        losses = _losses(scene, names)
        if losses is None:
            break
        loss, width, cost = losses.mean, losses.width, cost.plus(losses.cost)
        implied_temperatures, width = ambient + loss / conductance, width / conductance
        last_residual, residual = residual, np.minimum(implied_temperatures, seizure) - temperatures
        accuracy = np.maximum(ABSOLUTE_TOLERANCE, RELATIVE_TOLERANCE * (implied_temperatures - ambient))
        if run_index < EARLY_RUNS:
            accuracy = np.where(is_dry, DRY_TOLERANCE * (implied_temperatures - ambient), accuracy)
        if run_index >= STRICT_RUNS:
            accuracy = np.maximum(accuracy, np.minimum(width, DOUBTFUL_WIDTH * (implied_temperatures - ambient)))
        converged = run_index > 0 and bool(np.all(np.abs(residual) <= accuracy))
        if converged or run_index == MAX_RUNS - 1:
            break
        step = np.where(is_dry, 1.0, FILM_DAMPING) * residual
        if run_index:
            residual_change = residual - last_residual
            temperature_change = temperatures - last_temperatures
            secant = np.where(
                residual_change * temperature_change < 0.0,
                -residual * temperature_change / np.where(residual_change == 0.0, 1.0, residual_change),
                step,
            )
            step = np.clip(secant, -2.0 * np.abs(residual), 2.0 * np.abs(residual))
        last_temperatures, temperatures = temperatures, np.minimum(np.maximum(temperatures + step, ambient), seizure)
    temperature, half_width, rise, implied = (
        dict(zip(names, map(float, values), strict=True))
        for values in (temperatures, width, temperatures - ambient, implied_temperatures)
    )
    closed_joints = tuple(
        joint.column for joint in joints if joint.thermal and joint.warm_clearance(implied[joint.column]) <= 0.0
    )
    return scene, Balance(
        temperature, half_width, rise, converged, cold_scene.case.joints, implied, closed_joints, cost
    )


def _seizure_temperature(joint: Joint) -> float:
    """Return the temperature (K) at which SEIZED_CLEARANCE of a joint's clearance is left; inf if it never closes."""
    if not joint.thermal:
        return math.inf
    rate = joint.clearance_rate
    return REFERENCE_TEMPERATURE - (1.0 - SEIZED_CLEARANCE) * joint.clearance / rate if rate < 0.0 else math.inf


def at_temperatures(scene: Scene, temperatures: dict[str, float]) -> Scene:
    """Return the scene with some joints at other temperatures (K): the oil of a film, the bodies of a dry joint."""
    joints = tuple(
        _joint_at_temperature(joint, temperatures[joint.column]) if joint.column in temperatures else joint
        for joint in scene.case.joints
    )
    warm_scene = build(scene.case._replace(joints=joints), scene.worn)
    return dataclasses.replace(warm_scene, deadline=scene.deadline, keep_events=scene.keep_events)


def _joint_at_temperature(joint: Joint, temperature: float) -> Joint:
    if joint.film is None:
        return joint._replace(clearance=joint.warm_clearance(temperature), temperature=temperature)
    assert joint.film.oil is not None  # only films of a known oil
    viscosity = joint.film.oil.viscosity(temperature)
    return joint._replace(film=joint.film._replace(temperature=temperature, viscosity=viscosity))


def _losses(scene: Scene, names: list[str]) -> Losses | None:
    """Return the losses of joints of these names in a run of a scene, or None if it failed."""
    observed = [(row, joint) for row, joint in enumerate(scene.layout.joints) if joint.name in names]
    observer = HeatObserver(scene.layout, {row: "heat" if joint.film else "friction_energy" for row, joint in observed})
    end = scene.crank_clock.value_after(scene.case.simulate.revolutions)
    run = integration_of(scene, np.empty(0), end, (observer,), in_angles=True)
    if run.status != integration.OK:
        return None
    observer.observe(run.work)
    return observer.losses(Cost(run.counts, run.duration))
