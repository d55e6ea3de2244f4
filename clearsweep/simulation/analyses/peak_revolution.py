"""The revolution of a case with its largest normal force."""

import dataclasses

import numpy as np

from ...contracts.case import Case
from ...contracts.results import Peak
from ..running.observed_run import LaterWindow
from ..running.run import Run, integration_of
from ..setup.revolutions import marks_of, peaks_of
from ..setup.scene import build
from ..setup.start import UNLIMITED
from .heat import at_equilibrium, has_balance
from .outcome import trajectory_of

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
