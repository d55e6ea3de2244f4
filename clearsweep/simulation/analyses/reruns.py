"""Runs a finished case again for what was not saved: its peak revolution, the forces of its pins."""

import dataclasses
from typing import NamedTuple

import numpy as np

from ...contracts.case import Case, Joint, column_name
from ...contracts.machine import GROUND, Machine, Pin, Stretch
from ...contracts.results import Peak, Trajectory
from ...mechanics.machines.planar.reactions import JointForce, Motion, Reactions, reactions
from ..machine.ideal import mechanism_of
from ..running.observed_run import LaterWindow
from ..running.run import Run, integration_of
from ..setup.scene import Scene
from ..setup.start import UNLIMITED, marks_of, peaks_of
from .chain import build
from .outcome import trajectory_of
from .repeated import at_equilibrium, has_balance
from .trajectory import simulate

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
    scene = build(case._replace(simulate=settings, save=case.save._replace(orbits="none")))
    if has_balance(case):
        scene, _ = at_equilibrium(scene)
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
    return PinReactions(trajectory, on_journals, *_couples_and_torque(result))


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


def _couples_and_torque(result: Reactions) -> tuple[dict[str, np.ndarray], np.ndarray]:
    return {column_name(name): couple for name, couple in result.couples.items()}, result.torque
