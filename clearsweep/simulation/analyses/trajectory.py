"""Computes the trajectory of a scene: one or more integrations of the required length.

And runs a finished case again for what was not saved: its peak revolution, the forces of its pins.
"""

import contextlib
import dataclasses
import math
import time
from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ...answers.validity import ERROR_CHECK_FAILED, UNBALANCED, film_temperature_remark, join_remarks
from ...contracts.case import Case, Joint, column_name
from ...contracts.layout import DIFFERENCE
from ...contracts.machine import GROUND, Machine, Pin, Stretch
from ...contracts.results import Peak, Trajectory
from ...grid import check_memory, history_bytes
from ...language import phases
from ...language.errors import InputError, quoted
from ...mechanics.machines.planar.reactions import JointForce, Motion, reactions
from ...mechanics.solver import integration, loop
from ...mechanics.solver.slow_sums import Record
from ...tracing.compiled.family import Routine, empty_entries
from ..figures.catalogue import SETUP, WORK_COUNTS, first_sample, recorded_part, records_samples, with_own_figures
from ..machine.ideal import mechanism_of
from ..running.observed_run import LaterWindow, Observer, Snapshot, restore
from ..running.run import Run, integrate, integration_of, release, run_integration
from ..setup.scene import Scene
from ..setup.start import NO_TIMES, UNLIMITED, control_of, marks_of, peaks_of, start_of
from . import repeated
from .extrapolation import extrapolate_life
from .life import BlockRecord, LifeRun, Log, RateObserver, block_record_of, failures, further_lives
from .life import figures as uncertain_figures
from .outcome import add_cost, trajectory_of


def simulate(
    scene: Scene,
    times: ArrayLike | None = None,
    observers: Sequence[Observer] = (),
    *,
    progress: bool = False,
    log: Log | None = None,
    events: bool = True,
) -> Trajectory:
    """Return the trajectory of a scene.

    Parameters
    ----------
    scene : result of `load_case` or `scene.build`.
    times : (n,) s, increasing, within the run: times of the samples.  None: the sampling of the case.
    observers : observers of the run, see `observed_run.run_observed`.
    progress : whether to print the progress of a long run on stderr; no bit of the
        result depends on it.
    log : storage of a life's block results, from which it resumes.
    events : whether to return the events of the whole run even without histories.

    A failed integration is also a Trajectory: `status` names the reason, `message` explains it.  Raises
    InputError for times outside the run.
    """
    if not isinstance(scene, Scene):
        raise InputError(
            f"simulate: found {quoted(scene)}; expected the result of load_case, as in "
            "clearsweep.simulate(clearsweep.load_case('grid.yaml'))"
        )
    begin = time.thread_time()
    with phases.show_progress(progress):
        deadline = time.process_time() + scene.case.simulate.time_budget
        scene = scene.for_run(deadline, keep_events=scene.keep_events or events or times is not None)
        trajectory = _all_integrations(scene, times, observers, log)
    summary, elapsed = trajectory.summary, scene.build_time + time.thread_time() - begin
    summary[SETUP.name] = max(elapsed - (summary.get("run_time") or 0.0), 0.0)
    summary.update(scene.verdict.evaluate_case(summary, failed=trajectory.status != "ok"))
    return trajectory


def _all_integrations(
    scene: Scene, times: ArrayLike | None, observers: Sequence[Observer], log: Log | None
) -> Trajectory:
    """Return the trajectory of a scene, with all integrations that its case requires."""
    balance = None
    if repeated.has_balance(scene.case):
        end_of(scene)  # a crank that never gets there is refused before many runs
        with phases.phase("temperature of the joints", covers_nested=True):
            scene, balance = repeated.at_equilibrium(scene)
    if balance and balance.seized:
        trajectory = _seized(scene, balance)
    elif scene.case.life:
        trajectory = _run_life(scene, times, observers, LifeRun(scene, log))
    else:
        trajectory = (
            _run_until_converged(scene, times, observers) if scene.layout.until else _simulate(scene, times, observers)
        )
    if balance:
        add_cost(trajectory.summary, balance.cost)
        trajectory = trajectory if balance.seized else _with_balance(scene, trajectory, balance)
    if scene.layout.error_check:
        with phases.phase("the same at a tenth of the tolerance"):
            trajectory = _error_checked(scene, trajectory)
    return trajectory


def _seized(scene: Scene, balance: repeated.Balance) -> Trajectory:
    """Return the failed trajectory of a case with a joint that closes as it warms up."""
    trajectory = _simulate(scene, NO_TIMES)
    work_counts = {figure.name: trajectory.summary[figure.name] for figure in WORK_COUNTS}
    closing_joints = [
        f"{joint.name}, with {1e6 * cold.clearance:.4g} um of clearance at 20 degC, closes on its way to "
        f"{balance.implied[joint.column]:.4g} K"
        for joint, cold in zip(scene.case.joints, balance.cold, strict=True)
        if joint.column in balance.seized
    ]
    message = f"{'; '.join(closing_joints)}; a larger clearance or thermal.conductance helps, or less friction"
    summary = dict.fromkeys(trajectory.summary) | work_counts
    return dataclasses.replace(
        trajectory, status="seized", message=message, summary=summary, channels={}, wear={}, poincare={}
    )


def _with_balance(scene: Scene, trajectory: Trajectory, balance: repeated.Balance) -> Trajectory:
    """Return a trajectory with the accuracy of its joint temperatures."""
    figure_names = {joint.column: "film_temperature" if joint.film else "temperature" for joint in scene.case.joints}
    for joint, width in balance.width.items():
        trajectory.summary[f"{joint}_{figure_names[joint]}_ci"] = width if math.isfinite(width) else None
    if trajectory.status != "ok":
        return trajectory
    subjects = {joint.column: f"the film of {joint.name}" if joint.film else joint.name for joint in scene.case.joints}
    accuracy_remark = film_temperature_remark(
        [(subjects[joint], *accuracy) for joint, accuracy in balance.doubtful().items()]
    )
    remark = accuracy_remark if balance.converged else UNBALANCED
    return dataclasses.replace(trajectory, message=join_remarks(trajectory.message, remark))


def end_of(scene: Scene) -> float:
    """Return the end of a scene's run: a time (s), for a free crank its angle (rad); inf without a crank.

    Raises InputError if the crank never gets there.
    """
    if not scene.mechanism.turns:
        return math.inf
    end = scene.crank_clock.value_after(scene.case.simulate.revolutions)
    if math.isinf(end):
        raise InputError(
            f"drive.speed.table: the crank stops before {scene.case.simulate.revolutions:.6g} revolutions; "
            f"extend the table, or reduce simulate.{'until.max_' if scene.layout.until else ''}revolutions"
        )
    return end


def _simulate(scene: Scene, times: ArrayLike | None, observers: Sequence[Observer] = ()) -> Trajectory:
    """Return the trajectory of a scene of given length."""
    end, free, full_run = end_of(scene), scene.crank_clock.free, None
    if times is not None:
        sample_times = checked_times(times, math.inf if free else end)
    elif not records_samples(scene.case):
        sample_times = NO_TIMES
    elif not scene.mechanism.turns:  # its duration is unknown before the run
        full_run = integration_of(scene, NO_TIMES, end)
        sample_times = np.linspace(0.0, full_run.work.end[full_run.work.time], scene.case.save.samples + 1)
    else:
        check_memory(history_bytes(scene.layout, recorded_part(scene.case), scene.case.simulate.revolutions))
        sample_times = sampling_times(scene)
    marks, in_angles = marks_of(scene, scene.case.simulate.revolutions), free and times is None
    run = integration_of(scene, sample_times, end, observers, in_angles=in_angles, marks=marks)
    if free and times is not None and run.status == integration.OK:
        finish_samples(scene, run)
    if full_run:
        run.add_cost(full_run)
        release(full_run)
    trajectory = trajectory_of(scene, run, end)
    repeated.keep_end(scene, run)
    release(run)
    return trajectory if times is not None else with_own_figures(scene.case, trajectory)


def finish_samples(scene: Scene, run: Run) -> None:
    """Fill in the samples at the end of a free crank's run, whose time was unknown before.

    Raises InputError for times beyond it.
    """
    end_time, times = float(run.work.end[run.work.time]), run.record.times
    if times.size and times[-1] > end_time * (1.0 + 1e-9):
        raise InputError(f"times: found {times[-1]:.6g} s; the run lasts from 0 to {end_time:.6g} s")
    times[:] = np.minimum(times, end_time)
    run.work.y[:] = run.work.end
    run.work.stepper.next_length = 0.0
    run.advance(control_of(scene, math.inf, keep_events=False)._replace(window=math.inf, step_budget=0))
    run.status = integration.OK


def _run_until_converged(scene: Scene, times: ArrayLike | None, observers: Sequence[Observer]) -> Trajectory:
    """Return the trajectory of a scene that runs until a figure has converged.

    The samples come from a second, bit-identical run over the saved revolutions, as their times were unknown.
    """
    full_scene = scene.with_settings(revolutions=repeated.longest_run(scene.case))
    end = end_of(full_scene)
    marks = marks_of(scene, full_scene.case.simulate.revolutions)
    run = Run(start_of(scene, np.zeros(1), marks), in_angles=True)  # with a sample, also sections can be computed
    observer = repeated.ConvergenceObserver(scene, marks)
    integrate(full_scene, run, end, (observer, *observers))
    run.record = Record(NO_TIMES, NO_TIMES, run.record.independent)
    if run.status != integration.OK:
        return trajectory_of(full_scene, run, end)
    trajectory = _converged_trajectory(scene, run, observer, times)
    trajectory.summary.update(observer.results())
    return trajectory


def _converged_trajectory(
    scene: Scene, run: Run, observer: repeated.WindowLength, times: ArrayLike | None
) -> Trajectory:
    """Return the trajectory of a run that has determined its length."""
    value_after = scene.crank_clock.value_after
    final_scene = scene.with_settings(revolutions=observer.revolutions, discard=observer.discard)
    end = value_after(observer.revolutions)
    run.marks = run.marks.after(observer.discard)
    if times is not None or records_samples(scene.case):
        saved = recorded_part(scene.case)
        check_memory(0.0 if times is not None else history_bytes(scene.layout, saved, observer.revolutions))
        end_time = math.inf if scene.crank_clock.free else end
        sample_times = sampling_times(final_scene) if times is None else checked_times(times, end_time)
        second_run = Run(start_of(scene, sample_times), in_angles=times is None, records_signals=False)
        _record_samples(final_scene, run, second_run, end, observer.snapshots)
    trajectory = trajectory_of(final_scene, run, end)
    return trajectory if times is not None else with_own_figures(final_scene.case, trajectory)


def _run_life(scene: Scene, times: ArrayLike | None, observers: Sequence[Observer], life_run: LifeRun) -> Trajectory:
    """Return the trajectory of a life: its last block, with the history up to the limit."""
    begin = time.process_time()
    life_run.scene = scene = dataclasses.replace(scene, deadline=scene.deadline - life_run.seconds_before)
    latest_block: list[tuple[Scene, Run, RateObserver]] = []

    def run_block(life_run: LifeRun, state: np.ndarray) -> BlockRecord | None:
        latest_block[:] = [_block(life_run.scene_at(state), observers)]
        worn_scene, run, observer = latest_block[0]
        if run.status != integration.OK:
            life_run.failure = _failed_block(worn_scene, run).status
            return None
        return block_record_of(worn_scene, run, observer, life_run.seconds_before + time.process_time() - begin)

    with phases.phase(life_run.progress):
        life = extrapolate_life(life_run.logged(run_block), life_run, life_run.settings(), life_run.start)
        if life and not life_run.constant_rates:
            last_block = run_block(life_run, life.nodes[-1].state)
            life = life_run.with_last_block(life, last_block) if last_block else None
        elif life and not latest_block and not run_block(life_run, life_run.start):  # its only block is in the log
            life = None
    worn_scene, run, observer = latest_block[0]
    if life is None:
        failed = _failed_block(worn_scene, run)
        return dataclasses.replace(failed, message=f"block {len(life_run.records) + 1} of its life: {failed.message}")
    bounding_lives = further_lives(life_run, run_block) if scene.case.uncertain else {}
    for block_record in [
        *([] if life_run.constant_rates else life_run.records),
        *(block_record for bounding_life in bounding_lives.values() for block_record in bounding_life.records),
    ]:
        run.counts.numbers[:] += block_record.counts
        run.duration += float(block_record.seconds[0])
    trajectory = _converged_trajectory(worn_scene, run, observer, times)
    trajectory.summary.update(life_run.figures(life))
    trajectory.summary.update(uncertain_figures(life_run.target.column, bounding_lives) if bounding_lives else {})
    message = join_remarks(trajectory.message, life_run.reason_unreached(life), *failures(bounding_lives))
    return dataclasses.replace(trajectory, history=life_run.history(life), message=message)


def _failed_block(scene: Scene, run: Run) -> Trajectory:
    """Return the trajectory of a failed block."""
    full_scene = scene.with_settings(revolutions=repeated.longest_run(scene.case))
    return trajectory_of(full_scene, run, scene.crank_clock.value_after(full_scene.case.simulate.revolutions))


def _block(scene: Scene, observers: Sequence[Observer]) -> tuple[Scene, Run, RateObserver]:
    """Return a scene, the run of a block of revolutions, and its observer."""
    revolutions = repeated.longest_run(scene.case)
    full_scene = scene.with_settings(revolutions=revolutions)
    marks = marks_of(full_scene, revolutions)
    run, observer = Run(start_of(full_scene, NO_TIMES, marks)), RateObserver(scene, marks)
    integrate(full_scene, run, scene.crank_clock.value_after(revolutions), (observer, *observers))
    return scene, run, observer


def _record_samples(scene: Scene, run: Run, second_run: Run, end: float, starts: Iterable[Snapshot]) -> None:
    """Record the motion of a run in `second_run`, from the last suitable snapshot in `starts` or from the beginning."""
    times, independent = second_run.record.times, second_run.record.independent
    snapshots = [start for start in starts if times.size and start["y"][independent] <= times[0]]
    if snapshots:
        restore(snapshots[-1], second_run.work)
    control = control_of(scene, end, keep_events=False)._replace(step_budget=UNLIMITED, event_budget=UNLIMITED)
    run_integration(second_run, control, scene)
    if scene.crank_clock.free and independent == second_run.work.time and second_run.status == integration.OK:
        finish_samples(scene, second_run)
    run.status, run.record = second_run.status, second_run.record
    run.add_cost(second_run)


def _error_checked(scene: Scene, trajectory: Trajectory) -> Trajectory:
    """Return a trajectory with the change of every figure at a tenth of the tolerance in its summary."""
    if trajectory.status != "ok":
        return trajectory
    tighter_settings = {"tolerance": 0.1 * scene.case.simulate.tolerance}
    if scene.layout.until:
        tighter_settings["revolutions"] = trajectory.summary["revolutions_run"]
        tighter_settings["discard"] = trajectory.summary["window_from"]
    tighter_run = _simulate(scene.with_settings(**tighter_settings), NO_TIMES)
    # Add to a summary the differences of its figures from a tighter tolerance, and the work of that run
    for name in [name for name in trajectory.summary if name.endswith(DIFFERENCE)]:
        values = (trajectory.summary[name.removesuffix(DIFFERENCE)], tighter_run.summary[name.removesuffix(DIFFERENCE)])
        trajectory.summary[name] = None if None in values else abs(values[0] - values[1])
    for figure in WORK_COUNTS:
        trajectory.summary[figure.name] += tighter_run.summary[figure.name]
    if tighter_run.status == "ok":
        return trajectory
    failure = (
        f"{ERROR_CHECK_FAILED}the run at a tenth of the tolerance has the status {tighter_run.status}: "
        f"{tighter_run.message}"
    )
    return dataclasses.replace(trajectory, message=join_remarks(trajectory.message, failure))


def compile_for(case: Case) -> None:
    """Compile the code of a case's scene, or load it from the cache; stiff motion may need further code."""
    scene = repeated.build(case._replace(before=()))
    without_samples = not records_samples(case) and not scene.layout.until
    Run(start_of(scene, NO_TIMES if without_samples else np.array([0.0])))


def compile_loop(case: Case) -> None:
    """Compile the code that is the same for all cases, the integration loop above all, or load it from the cache."""
    scene = repeated.build(case._replace(before=()))
    with empty_entries():
        run = Run(start_of(scene, NO_TIMES))
    loop.compile_for(run.pinned)
    for routine in Routine.ALL:
        routine.compile()


def checked_times(times: ArrayLike, end: float) -> np.ndarray:
    """Return the requested times (s) as an array; raise InputError unless they lie within a run up to `end`."""
    array: np.ndarray = np.full(1, math.nan)
    with contextlib.suppress(TypeError, ValueError):
        array = np.ascontiguousarray(times, dtype=float)
    if array.ndim != 1 or not np.all(np.isfinite(array)) or np.any(np.diff(array) < 0.0):
        raise InputError("times: expected a one-dimensional array of increasing, finite times in s")
    if array.size and not (array[0] >= 0.0 and array[-1] <= end * (1.0 + 1e-12)):
        raise InputError(f"times: found {array[0]:.6g} s to {array[-1]:.6g} s; the run lasts from 0 to {end:.6g} s")
    return np.minimum(array, end)  # type: ignore[no-any-return]


def sampling_times(scene: Scene) -> np.ndarray:
    """Return the sampling times of a scene: at k / samples of a revolution, both ends of the range included."""
    save, revolutions, crank_clock = scene.case.save, scene.case.simulate.revolutions, scene.crank_clock
    sample_numbers = np.arange(first_sample(scene.case), math.floor(revolutions * save.samples + 1e-9) + 1)
    times, end = crank_clock.values_after(sample_numbers / save.samples), crank_clock.value_after(revolutions)
    return np.minimum(times, end)  # type: ignore[no-any-return]


# The revolution of a case with its largest normal force.

REFINEMENT, MAX_SAMPLES = 20, 1_000_000  # times the usual number of samples
REFINED_SAMPLES = 1.5  # usual samples on each side of the largest force within which all fine samples are kept


def peak_revolution(case: Case, joint: int, revolutions: float, window_from: float | None = None) -> Peak:
    """Return the revolution with the largest normal force of a joint in the window, with time histories.

    The case is run twice, with the same bits as before: without histories, then sampled over that revolution.  Samples
    are those of `save.samples` and, because impacts are short, REFINEMENT times as dense around the largest force.

    Parameters
    ----------
    case : the case as it was run.
    joint : index among the clearance joints.
    revolutions : length of the run; that of the case unless `simulate.until` determined it.
    window_from : revolutions before the window of the figures, if `simulate.until` determined them.
    """
    settings = case.simulate._replace(until=None, horizon=False, error_check=False)
    scene = repeated.build(case._replace(simulate=settings, save=case.save._replace(orbits="none")))
    if repeated.has_balance(case):
        scene, _ = repeated.at_equilibrium(scene)
    # the balance and its budgets are those of the case, and the run has kept its budgets, which are of another length
    scene = scene.with_settings(revolutions=revolutions, step_budget=UNLIMITED, event_budget=UNLIMITED)
    value_after, crank_is_free = scene.crank_clock.value_after, scene.crank_clock.free
    end, all_marks, discard = value_after(revolutions), marks_of(scene, revolutions), scene.case.simulate.discard
    window_from = discard if window_from is None else window_from

    def integration_at(times: np.ndarray) -> Run:
        observers = (LaterWindow(window_from - discard),) if window_from > discard else ()
        run = integration_of(scene, times, end, observers, in_angles=crank_is_free, marks=all_marks)
        run.marks = all_marks.after(window_from)
        return run

    run = integration_at(np.empty(0))
    marks = run.marks
    peaks, window = peaks_of(scene, marks, run.work.revolutions), marks.turns[marks.window]
    peak_index = int(peaks[:, joint].argmax()) if len(peaks) else 0
    begin_revolution, end_revolution = (
        window[peak_index : peak_index + 2].tolist() if len(peaks) else (max(revolutions - 1.0, 0.0), revolutions)
    )
    samples, density = case.save.samples, max(min(REFINEMENT, MAX_SAMPLES // case.save.samples), 1)
    sample_numbers = np.arange(
        round(begin_revolution * samples) * density, round(end_revolution * samples) * density + 1
    )
    times = np.minimum([value_after(count / (density * samples)) for count in sample_numbers.tolist()], end)
    trajectory = trajectory_of(scene.with_settings(discard=window_from), integration_at(np.asarray(times)), end)
    if trajectory.status != "ok":
        return Peak(begin_revolution, trajectory)
    largest = int(trajectory[f"joints/{case.joints[joint].column}/force_normal"].argmax())
    is_kept = (sample_numbers % density == 0) | (
        np.abs(np.arange(len(sample_numbers)) - largest) <= REFINED_SAMPLES * density
    )
    return Peak(
        begin_revolution,
        dataclasses.replace(trajectory, channels={name: trajectory[name][is_kept] for name in trajectory.channels}),
    )


# Forces in the joints without clearance of one case over time, from the accelerations of its motion.

STEP = 1e-6  # of the mean distance of the samples of a turn, between the two velocities of an acceleration
PIN_CHANNELS = ("x", "y", "force_normal", "force_tangential")  # channels of an open pin


class PinReactions(NamedTuple):
    """A trajectory, and the forces on the bodies with the journals of its pins without clearance, at its times."""

    trajectory: Trajectory
    forces: dict[str, np.ndarray]  # joint in columns ('crank_rod') -> (n, 2) N, in the fixed frame
    couples: dict[str, np.ndarray]  # guide in columns -> (n,) N m, on the sliding body
    torque: np.ndarray  # (n,) N m, of the drive


def reactions_unknown(case: Case) -> str:
    """Return why the forces in the joints without clearance are not known for a case; '' if they are."""
    mechanism = mechanism_of(case)
    if mechanism.machine is None:
        return "the mechanism is not planar"
    machine = mechanism.machine(case)
    if any(isinstance(joint, Stretch) for joint in machine.joints):
        return "a link is elastic"
    if any(body.initial is not None for body in machine.bodies.values()):
        return "a body is free"
    joints_by_name = {joint.name: joint for joint in machine.joints}
    if not all(isinstance(joints_by_name[joint.name], Pin) and joint.film is None for joint in case.joints):
        return "a joint with clearance is not a dry pin"
    return "its life changes the surfaces" if case.life else ""


def pin_reactions(scene: Scene, times: np.ndarray) -> PinReactions:
    """Return a trajectory at times (n,) s and the forces in its joints without clearance, or none if it failed.

    `reactions_unknown` must be '' for the case.  An acceleration is the difference of two close velocities.  Bristles
    of friction in joints without clearance count as bent by long sliding.
    """
    case, machine_of = scene.case, mechanism_of(scene.case).machine
    assert machine_of is not None  # of a case that is not refused
    machine = machine_of(case)
    step = STEP * float(np.min(np.diff(times)))
    first_times = np.append(times[:-1], times[-1] - step)
    trajectory = simulate(scene, np.stack([first_times, first_times + step], -1).ravel())
    if trajectory.status != "ok":
        return PinReactions(trajectory, {}, {}, np.zeros(0))
    result = reactions(
        machine,
        _motion(machine, trajectory),
        {joint.name: _joint_force(joint, machine, trajectory) for joint in case.joints},
    )
    signs = {site.name: -1.0 if site.journals[0] == site.proximal else 1.0 for site in mechanism_of(case).joints}
    on_journals = {column_name(name): signs.get(name, 1.0) * force for name, force in result.forces.items()}
    couples = {column_name(name): couple for name, couple in result.couples.items()}
    return PinReactions(trajectory, on_journals, couples, result.torque)


def _motion(machine: Machine, trajectory: Trajectory) -> Motion:
    """Return the bodies at every second sample of a trajectory, with the accelerations up to the sample after it."""
    channels = trajectory.channels
    names = [column_name(name) for name in machine.bodies if name != GROUND]
    time, step = channels["t"][::2], np.diff(channels["t"])[::2]
    q = np.stack([channels[f"{name}/{key}"] for name in names for key in ("x", "y", "angle")], -1)
    rates = np.stack([channels[f"{name}/{key}"] for name in names for key in ("vx", "vy", "rate")], -1)
    accelerations = (rates[1::2] - rates[::2]) / step[:, None]
    return Motion(time, channels["crank_angle"][::2], q[::2], rates[::2], accelerations)


def _joint_force(joint: Joint, machine: Machine, trajectory: Trajectory) -> JointForce:
    """Return force and moment in a dry pin with clearance at every second sample of a trajectory."""
    x, y, normal, tangential = (
        trajectory.channels[f"joints/{column_name(joint.name)}/{key}"][::2] for key in PIN_CHANNELS
    )
    distance = np.hypot(x, y)
    outward = np.stack([x, y], -1) / np.where(distance > 0.0, distance, 1.0)[:, None]
    on_journal = -normal[:, None] * outward + tangential[:, None] * np.stack([-outward[:, 1], outward[:, 0]], -1)
    radius = joint.bearing_radius or 0.0
    couples = (radius - joint.clearance) * tangential, -radius * tangential
    distal = next(machine_joint.distal.body for machine_joint in machine.joints if machine_joint.name == joint.name)
    if joint.journal in (None, distal):
        return JointForce(on_journal, *couples)
    return JointForce(-on_journal, *couples[::-1])
