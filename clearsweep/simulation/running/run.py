"""One integration of a scene: its buffers, and the compiled calls that do it."""

import contextlib
import dataclasses
import functools
import math
import sys
import time
from collections.abc import Sequence
from typing import Any

import numpy as np

from ...language import phases
from ...mechanics.coupling.entries import guards_of, rates_of, stage_observables_of, sweep_of, wear_of
from ...mechanics.coupling.rates import first_signal, rates, samples_of, scene_signal_count, slopes_of
from ...mechanics.coupling.state import every_state
from ...mechanics.joints.contract import Offsets, every_contact, every_latched, offsets_of, with_current_state
from ...mechanics.laws.contract import touches
from ...mechanics.laws.loss import needs_mass, needs_onset_rate
from ...mechanics.machines.contract import link_signal_count
from ...mechanics.observe import ROW_COUNT
from ...mechanics.solver import integration, loop, radau, totals
from ...mechanics.solver.preconditioner import preconditioner_of
from ...mechanics.solver.signal_sums import NODE_COUNT
from ...mechanics.solver.slow_sums import SIGNALS, Record, RevolutionMarks
from ...mechanics.wear import Account
from ...tracing.compiled.family import NO_ENTRY, put_numbers
from ...tracing.compiled.pinned import Pinned
from ..setup.scene import Scene, start_up, state_units
from ..setup.start import (
    NO_MARKS,
    NO_TIMES,
    Marks,
    Memory,
    Start,
    arrays_of,
    control_of,
    fields_from,
    period,
    start_of,
)
from .deformation import LinkSignals
from .observed_run import Branches, Observer, Perturbed, Revolutions, run_observed
from .vibration import CAPACITY, Signals

REST = 1e-9  # of the onset rate and of the largest depth: less is rest, in a contact
#: Further statuses besides those of the loop
TIME_BUDGET, ROUNDING, BENT_TOO_FAR, HISTORY_NOT_FINITE = -1, -2, -3, -4
MIN_STEPS = 1 << 15  # steps after which the budget that a run will need is estimated
#: Change of a rate over a step by rounding of a position, over the allowed error, from which rounding limits the step.
#: Runs that it limits have 0.2 to 3, others below 1e-3.
LARGEST_ROUNDING = 0.05
NO_EVENTS = np.empty((0, 5))
MAX_RETAINED_BYTES = 2**23  # bytes of time histories of a run that waits for the next case


class Run:
    """The buffers of one integration and its results."""

    def __init__(self, start: Start, *, in_angles: bool = False, records_signals: bool = True):
        """Initialise at `start`; its times are in s or, `in_angles`, in rad of a free crank.

        records_signals : whether the run gives the figures of a grid's `vibration`
        """
        scene, value, contacts = start.scene, start.scene.value, every_contact(start.scene.value.joints)
        internal, self.memory = every_state(value), Memory()
        n, contact_count, zeros = scene.start.size, len(contacts), self.memory.zeros
        self.kind = *start.kind, in_angles
        self.arrays = arrays = arrays_of(scene, len(start.marks.turns), zeros)
        self.parameters = arrays["parameters"]  # compiled code keeps its address
        time_index = 2 * len(value.coordinates)
        independent = 0 if scene.crank_clock.free else time_index
        self.inputs = start.inputs.copy()
        sizes = len(start.times), len(start.marks.turns), scene.inputs.knots, len(internal), contact_count
        times, marks, knots, internal_values, sides, limit_depths = np.split(self.inputs, np.cumsum(sizes))
        self.totals = totals.Totals(**fields_from(totals.Totals, arrays))
        width = scene_signal_count(value) if records_signals else 0
        self.recording = np.zeros((CAPACITY, SIGNALS + width, NODE_COUNT) if width else (0, 0, 0))
        self.signals = Signals(scene, SIGNALS + width) if scene.case.vibration and records_signals else None
        self.link_signals = LinkSignals(scene) if records_signals and link_signal_count(value.mechanism) else None
        samples = zeros((times.size, len(scene.layout.channels)))
        self.record = Record(times, samples, independent if in_angles else time_index)
        self.work = integration.Work(
            rates=rates_of(value, self.parameters),
            sweep=sweep_of(value, self.parameters),
            observe_stages=stage_observables_of(value, self.parameters),
            sample=samples_of(value, self.parameters) if times.size else NO_ENTRY,
            wear=wear_of(value, self.parameters) if self.totals.workspace.size else NO_ENTRY,
            time=time_index,
            independent=independent,
            crank=0 if scene.mechanism.free else -1,
            knots=knots,
            reference_rate=0.0,
            sigma=0.0,
            max_duration=0.0,
            apart=np.array([modes.apart for _, modes in contacts], dtype=np.int64),
            pressed=np.array([modes.pressed for _, modes in contacts], dtype=np.int64),
            journal_sides=sides,
            reset_by=np.array(
                [-1 if state.survives_separation else contact for contact, state, _ in internal], dtype=np.int64
            ),
            initial_internal=internal_values,
            guards=guards_of(value, self.parameters, zeros),
            limit_depth=limit_depths,
            implicit=radau.implicit_of(n, zeros),
            preconditioner=preconditioner_of(n - 1 - contact_count - len(value.coordinates), zeros),
            totals=self.totals,
            record=self.record,
            recording=self.recording,
            signals=first_signal(value),
            revolutions=RevolutionMarks(marks=marks, **fields_from(RevolutionMarks, arrays)),
            **fields_from(integration.Work, arrays),
        )
        self.pinned = Pinned(self.work)
        self._begin(start)

    def begin(self, start: Start) -> None:
        """Restart from another scene of the same kind, as if this run were new."""
        self._clear_histograms()
        self.memory.clear()
        self._begin(start)

    def _clear_histograms(self) -> None:
        """Empty the histograms; most of a histogram was never written."""
        for histogram_rows, highest in zip(
            self.totals.histogram, self.totals.bins[:, totals.HIGHEST_BIN].tolist(), strict=True
        ):
            histogram_rows[: highest + 1] = 0.0
        self.totals.dry.fill(0.0)

    def forget_figures(self) -> None:
        """Forget the figures of the window, which begins anew later; the loop itself resets those that it computes."""
        self._clear_histograms()
        self.totals.bins.fill(0)
        self.totals.wear.fill(0.0)
        self.totals.account.fill(0.0)
        self._begin_account()
        if self.signals:
            self.signals.reset()
        if self.link_signals:
            self.link_signals.reset()

    def _begin_account(self) -> None:
        """Enter the earlier wear in the account, which is empty."""
        if self.earlier_sliding:
            Account(self.totals.account).column("sliding_distance")[:] = self.earlier_sliding

    def _begin(self, start: Start) -> None:
        """Initialise; the run's own arrays are zero already."""
        work: Any = self.work  # mypy takes its parts for tuples of anything
        arrays, scene, value, inputs = self.arrays, start.scene, start.scene.value, start.scene.inputs
        initial_count = len(inputs.initial_values)
        self.inputs[:] = start.inputs
        arrays["initial_values"][:initial_count], arrays["initial_values"][initial_count:] = inputs.initial_values, 0.0
        roots = scene.start[work.time + 1 :][: work.mode.size]
        arrays["nodes"][work.y.size + 1 :] = 0.0  # nothing is found yet
        arrays["mode"][:] = np.where(roots > 0.0, work.pressed, work.apart) if scene.in_contact else work.apart
        arrays["has_friction"][:] = inputs.has_friction
        if scene.earlier_end is not None:
            arrays["mode"][:] = scene.earlier_end.mode
        put_numbers(value, inputs.initial_values[: self.parameters.size], self.parameters)
        mechanism_totals: Any = self.totals.mechanism
        mechanism_totals.target_speed, mechanism_totals.target_time = start_up(scene.machine)
        self.earlier_sliding = inputs.sliding_distance if scene.worn else None  # m, before the run
        self._begin_account()
        self.pinned.put(reference_rate=value.reference_rate, sigma=value.sigma, max_duration=start.max_step)
        self.work = self.pinned.value
        self.value, self.deadline, self.marks = value, scene.deadline, start.marks
        self.rounding = sys.float_info.epsilon * scene.built.size / scene.built.lengths  # of the coordinates
        self.status, self.events, self.duration = integration.OK, NO_EVENTS, 0.0
        self.logs: list[np.ndarray] = []  # blocks of events, as they were copied
        self.counts = work.counts.copy()  # work counts, including perturbed runs
        self.figures: dict[str, float | None] = {}  # those that were found on the way
        self.phase: phases.Phase | None = None  # progress of the run
        if self.signals:
            self.signals.begin(scene)
        if self.link_signals:
            self.link_signals = LinkSignals(scene)

    @functools.cached_property
    def offsets(self) -> tuple[Offsets, ...]:
        """Return the index of each joint's first number, which depends on the types of its laws."""
        offsets: tuple[Offsets, ...] = offsets_of(self.value.joints, self.work.time + 1)
        return offsets

    def advance(self, control: integration.Control) -> tuple[int, np.ndarray]:
        """Return the status and the events, (events, 5), from the present state to the end in `control`."""
        self.work.control.numbers[:], self.work.stepper.begun, self.logs = control, 0.0, []
        is_paused = True
        while is_paused:
            begin = time.thread_time()
            loop.integrate(self.pinned)
            self.duration += time.thread_time() - begin
            is_paused = not self.has_ended(int(self.work.stepper.status))
        return self.status, np.concatenate(self.logs) if self.logs else NO_EVENTS

    def has_ended(self, status: int) -> bool:
        """Return whether the paused integration has ended; if not, prepare to resume it.

        Code for stiff motion is compiled only when it is needed.
        """
        work = self.work
        if logged := int(work.stepper.logged):
            self.logs.append(work.log[:logged].copy())
        self.status, work.stepper.begun = status, 0.0
        if recorded := int(work.stepper.recorded):
            work.stepper.recorded, rows = 0.0, self.recording[:recorded]
            if self.link_signals:
                self.link_signals.add(rows)
            if self.signals:
                self.signals.add(rows)
        if status == integration.OK and not self.link_signals:
            return True
        if status == integration.TURNS_STIFF:
            work.slopes.numbers[:] = slopes_of(self.value, self.parameters)
            return False
        if self.phase:
            self.phase.note(share=float(work.y[work.independent] / work.control.end))
        if status == integration.PAUSED and time.process_time() >= self.deadline:
            self.status = TIME_BUDGET
            return True
        if self.link_signals and self.link_signals.bends_too_far():
            self.status = BENT_TOO_FAR
            return True
        if self.is_held_at_rest():
            self.status = integration.OK
            return True
        if self.exceeds_step_budget() and rounding_of_rates(self) > LARGEST_ROUNDING:
            self.status = ROUNDING
            return True
        return status != integration.PAUSED or bool(work.y[work.independent] >= work.control.pause)

    def is_held_at_rest(self) -> bool:
        """Return whether two bodies that should part rest in contact: overdamped, and pulled together."""
        work: Any = self.work  # mypy takes its parts for tuples of anything
        if not work.control.separations or (work.mode == work.apart).any():
            return False
        speed, depth_root = np.abs(work.y[work.time // 2 : work.time]).max(), work.y[work.time + 1]
        is_slow = speed <= REST * work.latched.max()
        return bool(is_slow and depth_root**2 <= REST * np.asarray(work.totals.joint[0].depth_max).max())

    def expected_steps(self) -> float:
        """Return the number of steps that the whole run needs at the present rate."""
        work = self.work
        steps, position = float(work.counts.steps + work.counts.rejected), float(work.y[work.independent])
        share = position / work.control.end if position > 0.0 else 0.0
        return steps / share if share > 0.0 else math.inf

    def exceeds_step_budget(self) -> bool:
        """Return whether a long run has reached its step budget, or will reach it at the present rate."""
        work: Any = self.work  # mypy takes its parts for tuples of anything
        if work.counts.steps < MIN_STEPS:
            return False
        will_reach = math.isfinite(work.control.end) and self.expected_steps() > work.control.step_budget
        return self.status == integration.STEP_BUDGET or (self.status == integration.PAUSED and will_reach)

    def conclude(self, log: np.ndarray) -> None:
        """Record all events and the work counts of the integration, and fail it if its histories are not finite."""
        self.events = log
        self.counts.numbers[:] += self.work.counts.numbers
        if self.status == integration.OK and not math.isfinite(self.record.samples.sum()):
            self.status = HISTORY_NOT_FINITE

    def add_cost(self, other_run: "Run") -> None:
        """Add the work counts of another run."""
        self.counts.numbers[:] += other_run.counts.numbers
        self.duration += other_run.duration


released_runs: list[Run] = []  # the last ones: creating a run takes four times as long as restarting one
MAX_RELEASED = 2  # a case without a crank takes two different ones: without samples, and with them


def initial_run(scene: Scene, times: np.ndarray, *, in_angles: bool, marks: Marks) -> Run:
    """Return a run at the start of a scene: a released run if one has the same kind."""
    start = start_of(scene, times, marks)
    kind = *start.kind, in_angles
    for run in released_runs[:]:
        if run.kind == kind:
            with contextlib.suppress(ValueError):  # another thread has taken it
                released_runs.remove(run)
                run.begin(start)
                return run
    return Run(start, in_angles=in_angles)


def release(run: Run) -> None:
    """Release a run for reuse, except one with large time histories."""
    if run.record.samples.nbytes <= MAX_RETAINED_BYTES:
        released_runs[:] = [run, *released_runs[: MAX_RELEASED - 1]]


def rounding_of_rates(run: Run) -> float:
    """Return the largest change of a rate over a step by the rounding of a position, over its allowed error.

    The place of a contact is a difference of positions, whose rounding turns the force of the contact.
    """
    work: Any = run.work  # mypy takes its parts for tuples of anything
    count = len(run.rounding)
    rows = slice(count, 2 * count)

    def accelerations(y: np.ndarray) -> np.ndarray:
        k = np.zeros((y.size, ROW_COUNT))
        rates(run.value, y, work.mode, work.latched, k, None, 0)
        return k[rows, 0]

    at_start, largest = accelerations(work.y), 0.0
    for i in range(count):
        rounded = work.y.copy()
        rounded[i] += run.rounding[i]
        change = np.abs(accelerations(rounded) - at_start) * work.step.length
        largest = max(largest, float(np.max(change * work.weight[rows])))
    return largest


def onset_rates(run: Run) -> list[float]:
    """Return the onset rate (m/s) that each joint's law uses at the end of a run, or nan if it uses none."""
    work: Any = run.work  # mypy takes its parts for tuples of anything
    rates = [math.nan] * len(run.value.joints)
    for j, offsets in enumerate(run.offsets):
        if not touches(work.mode.item(offsets.contact)):
            continue
        law: Any = run.value.joints[j].law  # mypy takes it for a tuple of anything
        if law._field_defaults:  # it has an internal state
            law = with_current_state(law, work.end, work.latched, offsets)
        if needs_onset_rate(law):
            rates[j] = work.latched.item(offsets.contact)
    return rates


def integration_of(
    scene: Scene,
    times: np.ndarray,
    end: float,
    observers: Sequence[Observer] = (),
    *,
    in_angles: bool = False,
    marks: Marks = NO_MARKS,
) -> Run:
    """Return the integration of a scene up to `end` (s, or rad for a free crank), reported at `times`."""
    run = initial_run(scene, times, in_angles=in_angles, marks=marks)
    scene = dataclasses.replace(scene, keep_events=True) if times.size and not scene.keep_events else scene
    integrate(scene, run, end, observers)
    return run


def integrate(scene: Scene, run: Run, end: float, observers: Sequence[Observer] = ()) -> None:
    """Integrate a scene up to `end` (s, or rad for a free crank), observed by `observers`, see `observed_run`."""
    control = control_of(scene, end, keep_events=scene.keep_events)
    if not scene.layout.horizon:
        run_integration(run, control, scene, observers)
        return
    perturbed_run = Run(start_of(scene, NO_TIMES), records_signals=False)
    # Indices of the latched numbers that select a branch of a law
    joints = scene.value.joints
    latched_laws = list(enumerate(every_latched(joints), start=len(every_contact(joints))))
    branches = Branches(
        by_sign=[index for index, (law, _) in latched_laws if type(law) in needs_mass.members],
        by_value=[index for index, (law, _) in latched_laws if hasattr(law, "piece")],
    )
    perturbed = Perturbed(control, perturbed_run, state_units(scene), scene.case.simulate.tolerance, branches)
    run_integration(run, control, scene, (*observers, perturbed))
    run.figures = perturbed.figures(period(scene))
    perturbed_run.counts.numbers[:] += perturbed_run.work.counts.numbers
    run.add_cost(perturbed_run)


def run_integration(run: Run, control: integration.Control, scene: Scene, observers: Sequence[Observer] = ()) -> None:
    """Integrate in one call, or with pauses if there are observers."""
    if control.method == integration.IMPLICIT and run.work.stepper.next_length == 0.0:
        run.work.method.current = run.work.method.next = integration.IMPLICIT
    run.phase = phases.start(Revolutions(scene))
    try:
        if observers:
            run.status, log = run_observed(
                control, run, scene.case.simulate.discard, scene.crank_clock.value_after, observers
            )
        else:
            run.status, log = run.advance(control)
    finally:
        phases.end(run.phase)
        run.phase = None
    run.conclude(log)
