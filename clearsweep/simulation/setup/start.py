"""Inputs and control of one integration of a scene."""

import math
from itertools import accumulate, pairwise
from typing import NamedTuple

import numpy as np

from ...contracts.layout import Layout
from ...mechanics.solver import integration
from .crank_clock import STALL_TURNS
from .revolutions import NO_MARKS, Marks
from .scene import Scene

MAX_STEP_TURNS = 0.02  # crank turns per step at most: keeps maxima and histograms of slow motions accurate
NO_TIMES = np.empty(0)  # to report
UNLIMITED = 2**62  # largest count of steps or events

_METHODS = {"auto": integration.AUTO, "explicit": integration.EXPLICIT, "implicit": integration.IMPLICIT}


def period(scene: Scene) -> float:
    """Return the time (s) of a revolution of the crank."""
    return 2.0 * math.pi / scene.value.reference_rate


class BatchKey(NamedTuple):
    """Properties that scenes of one type must share to reuse one Run."""

    layout: Layout
    samples: int
    marks: int
    knots: int


class RunInputs(NamedTuple):
    """Input arrays of the loop, under their names in Work, Record and RevolutionMarks."""

    times: np.ndarray
    marks: np.ndarray
    knots: np.ndarray
    initial_values: np.ndarray
    side: np.ndarray
    limit_depth: np.ndarray


def inputs_of(values: np.ndarray, batch_key: BatchKey, contacts: int, internal: int) -> RunInputs:
    """Return views of the inputs in one array, for a number of contacts and `internal` states."""
    sizes = batch_key.samples, batch_key.marks, batch_key.knots, internal, contacts, contacts
    return RunInputs._make(values[begin:end] for begin, end in pairwise(accumulate(sizes, initial=0)))


class Start(NamedTuple):
    """Scene and inputs of an integration."""

    scene: Scene
    batch_key: BatchKey
    marks: Marks
    inputs: np.ndarray  # the arrays of a RunInputs, concatenated
    max_step: float  # s, longest step

    @property
    def times(self) -> np.ndarray:
        """Return the times at which results are reported."""
        return self.inputs[: self.batch_key.samples]


def start_of(scene: Scene, times: np.ndarray, marks: Marks = NO_MARKS) -> Start:
    """Return the Start of a scene with results at `times` and these `marks`."""
    return Start(
        scene=scene,
        batch_key=BatchKey(scene.layout, times.size, marks.turns.size, scene.inputs.knots),
        marks=marks,
        inputs=np.concatenate([times, scene.crank_clock.values_after(marks.turns), scene.inputs.loop_inputs]),
        max_step=MAX_STEP_TURNS * period(scene) if scene.mechanism.turns else math.inf,
    )


def control_of(scene: Scene, end: float, *, keep_events: bool) -> integration.Control:
    """Return the control of an integration up to `end` (s, or rad for a free crank)."""
    settings = scene.case.simulate
    has_crank, free = scene.mechanism.turns, scene.crank_clock.free
    window_start = scene.crank_clock.value_after(settings.discard) if has_crank else 0.0
    budget_units = max(settings.revolutions, 1.0) if has_crank else settings.impacts
    return integration.Control(
        window=window_start,
        end=end,
        separations=0 if has_crank else int(settings.impacts),
        step_budget=min(int(settings.step_budget * budget_units), UNLIMITED),
        event_budget=min(int(settings.event_budget * budget_units), UNLIMITED),
        method=_METHODS[settings.method],
        keep_events=keep_events,
        time_limit=settings.time_limit if free else math.inf,
        patience=STALL_TURNS * period(scene) if free else math.inf,
    )
