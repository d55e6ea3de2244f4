"""Values between the stages of a step, from its dense output: positions, maxima, time histories, states at marks."""

from typing import NamedTuple

import numpy as np

from ....tracing.compiled.choosing import lane_range
from ....tracing.compiled.family import invoke, invoke_each, kernel
from ...observe import (
    END,
    NODE_FRACTIONS,
    NODES,
    NORMAL,
    QUARTER_POINTS,
    SCRATCH,
    STAGES,
    STATE_POINTS,
    column_of,
    put_load,
)
from ..collocation import dense_component, dense_state
from ..integration import evaluate_dense

POINT_FRACTIONS = np.minimum(np.arange(STATE_POINTS) / (QUARTER_POINTS + 1), 1.0)


@kernel
def evaluate_dense_states(pointer, dense_states):
    """Write coordinates, their rates and the time at points within the step to `dense_states`.

    dense_states : (2 coordinates + 1, STATE_POINTS), at every quarter of the step, then its end again.
    """
    y, end_value, f = pointer[0].y, pointer[0].end, pointer[0].f
    for i in range(dense_states.shape[0]):
        for index in lane_range(STATE_POINTS):
            x = POINT_FRACTIONS[index]
            u = 2.0 * x - 1.0
            total = f[i, STAGES - 1]
            for m in range(STAGES - 2, -1, -1):
                total = total * u + f[i, m]
            dense_states[i, index] = y[i] + x * total
        for index in range(QUARTER_POINTS + 1, STATE_POINTS):
            dense_states[i, index] = end_value[i]


@kernel
def node_of_maximum(o, column, sign):
    """Return the node of the stage with the largest value of an observable times `sign`."""
    highest_node = 0
    for m in range(1, NODES.size):
        if sign * o[column, NODES[m]] > sign * o[column, NODES[highest_node]]:
            highest_node = m
    return highest_node


@kernel
def observable_at(pointer, x, column):
    """Return the observable at the fraction `x` (0 to 1) of the step, from the dense output in `work.f`."""
    work = pointer[0]
    evaluate_dense(pointer, x)
    for j in range(work.mode.size):
        if work.has_friction[j]:
            put_load(work.o, SCRATCH, j)
    return work.o[column, SCRATCH]


@kernel
def refine_peak(pointer, column, sign, node):
    """Return the largest value of the observable times `sign` near the stage `node`, by successive parabolas."""
    m = min(max(node, 1), NODES.size - 2)
    a, b, c = NODE_FRACTIONS[m - 1], NODE_FRACTIONS[m], NODE_FRACTIONS[m + 1]
    fa = sign * observable_at(pointer, a, column)
    fb = sign * observable_at(pointer, b, column)
    fc = sign * observable_at(pointer, c, column)
    largest = max(fa, fb, fc)
    for _ in range(3):
        curvature = (fa - fb) / (a - b) - (fb - fc) / (b - c)
        if curvature * (a - c) >= 0.0:  # not concave: the maximum is at an end
            break
        x = 0.5 * (a + b) - 0.5 * (a - c) * (fa - fb) / ((a - b) * curvature)
        x = min(max(x, 0.0), 1.0)
        if x in (a, b, c):
            break
        fx = sign * observable_at(pointer, x, column)
        largest = max(largest, fx)
        if abs(x - a) > abs(x - c):  # drop the farther end
            a, fa, b, fb = b, fb, x, fx
        else:
            b, fb, c, fc = x, fx, b, fb
    return largest


@kernel
def maximum_in_step(pointer, column, sign):
    """Return the largest value of the observable times `sign` near its highest stage, from the dense output."""
    return refine_peak(pointer, column, sign, node_of_maximum(pointer[0].o, column, sign))


class Record(NamedTuple):
    """Times and samples of the time histories."""

    times: np.ndarray  # (samples,) s, or rad of a free crank, increasing
    samples: np.ndarray  # (samples, channels)
    independent: int  # index in the state of the quantity that `times` gives


@kernel
def fraction_at(pointer, independent, target):
    """Return the fraction (0 to 1) of the step at which component `independent` of the state equals `target`."""
    work = pointer[0]
    a, b = 0.0, 1.0
    x = (target - work.y[independent]) / (work.end[independent] - work.y[independent])
    for _ in range(60):
        residual = dense_component(x, independent, work.y, work.f) - target
        if residual > 0.0:
            b = x
        else:
            a = x
        step = 1e-7  # a difference quotient suffices: only the root matters
        slope = (dense_component(x + step, independent, work.y, work.f) - residual - target) / step
        newton = x - residual / slope if slope > 0.0 else 0.5 * (a + b)
        if not a <= newton <= b:
            newton = 0.5 * (a + b)
        if abs(newton - x) <= 1e-15:
            return newton
        x = newton
    return x


@kernel
def write_sample(pointer, y, out):
    """Write the time histories at the state `y` to `out`, in the order of the channels."""
    work = pointer[0]
    invoke(work.sample.code, work.sample.parameters, (y, work.mode, work.latched, work.journal_sides, out), out.size)


@kernel
def write_samples(pointer):
    """Write the samples within the latest step, from its dense output."""
    work = pointer[0]
    record = work.record
    independent = record.independent
    i = work.counts.samples
    while i < record.times.size and record.times[i] <= work.end[independent]:
        dense_state(fraction_at(pointer, independent, record.times[i]), work.y, work.f, work.z)
        work.z[independent] = record.times[i]
        for j in range(work.mode.size):  # just before a separation rounding may put the interpolant below zero
            work.z[work.time + 1 + j] = max(work.z[work.time + 1 + j], 0.0)
        write_sample(pointer, work.z, record.samples[i])
        i += 1
    work.counts.samples = i


def sample_states(work, states, out):
    """Write the time histories at `states` (states, n) to `out` (states, channels), without forces."""
    repeated_arrays = [
        np.broadcast_to(array, (len(states), array.size)) for array in (work.mode, work.latched, work.journal_sides)
    ]
    invoke_each(work.sample.code, work.sample.parameters, (states, *repeated_arrays, out), out.shape[1])


PROBE_DISTANCE = 1e-4  # of a step: distance from a mark at which a rising force is detected


class RevolutionMarks(NamedTuple):
    """States and force peaks at marks along the motion."""

    marks: np.ndarray  # (marks,) s, or rad of a free crank, increasing
    states: np.ndarray  # (marks, n) the state at each mark
    peaks: np.ndarray  # (marks, contacts) N, largest normal force since the previous mark
    step_peak: np.ndarray  # (contacts,) N, largest normal force of the current step, 0 if none acts
    peak_since_mark: np.ndarray  # (contacts,) N, largest of the earlier steps since the last mark
    passed: np.ndarray  # (1,) int64, number of marks passed


@kernel
def record_start(pointer):
    """Record the state at a mark at the start of the run."""
    work = pointer[0]
    revolutions, i = work.revolutions, work.revolutions.passed[0]
    if i < revolutions.marks.size and revolutions.marks[i] <= work.y[work.independent]:
        for c in range(revolutions.states.shape[1]):
            revolutions.states[i, c] = work.y[c]
        revolutions.passed[0] = i + 1


@kernel
def split_peaks(pointer, i, x):
    """Split the largest forces of the step into those before and after mark `i`, at the fraction `x` of the step."""
    work = pointer[0]
    revolutions, mark_row = work.revolutions, END
    if x < 1.0:
        evaluate_dense(pointer, x)
        mark_row = SCRATCH
    for j in range(work.mode.size):
        column, step_peak = column_of(j, NORMAL), revolutions.step_peak[j]
        force_at_mark = work.o[column, mark_row] if step_peak > 0.0 else 0.0
        peak_after = max(force_at_mark, work.o[column, END]) if step_peak > 0.0 else 0.0
        peak_before = force_at_mark
        if step_peak > peak_after:
            is_rising = x < 1.0 and observable_at(pointer, min(x + PROBE_DISTANCE, 1.0), column) > force_at_mark
            peak_before, peak_after = (force_at_mark, step_peak) if is_rising else (step_peak, peak_after)
            if x < 1.0:
                evaluate_dense(pointer, x)
        revolutions.peaks[i, j] = max(revolutions.peak_since_mark[j], peak_before)
        revolutions.peak_since_mark[j], revolutions.step_peak[j] = 0.0, peak_after


@kernel
def record_marks(pointer):
    """Record and pass the marks within the current step."""
    work = pointer[0]
    revolutions = work.revolutions
    i = revolutions.passed[0]
    while i < revolutions.marks.size and revolutions.marks[i] <= work.end[work.independent]:
        x = 1.0
        if revolutions.marks[i] < work.end[work.independent]:
            x = fraction_at(pointer, work.independent, revolutions.marks[i])
        split_peaks(pointer, i, x)
        if x < 1.0:
            dense_state(x, work.y, work.f, work.z)
        for c in range(revolutions.states.shape[1]):
            revolutions.states[i, c] = work.z[c] if x < 1.0 else work.end[c]
        i += 1
    revolutions.passed[0] = i
