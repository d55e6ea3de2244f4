"""Time histories: samples at exact times, from the dense output of the steps."""

from typing import NamedTuple

import numpy as np

from ...compiled.family import invoke, kernel, pointer_to
from ..collocation import dense_component, dense_state


class Record(NamedTuple):
    """Times and samples of the time histories."""

    times: np.ndarray  # (samples,) s, or rad of a free crank, increasing
    samples: np.ndarray  # (samples, channels)
    independent: int  # place in the state of the quantity that `times` gives


@kernel
def share_at(at, independent, moment):
    """Return the share (0 to 1) of the step at which the state's number at `independent` equals `moment`."""
    work = at[0]
    a, b = 0.0, 1.0
    x = (moment - work.y[independent]) / (work.end[independent] - work.y[independent])
    for _ in range(60):
        miss = dense_component(x, independent, work.y, work.f) - moment
        if miss > 0.0:
            b = x
        else:
            a = x
        step = 1e-7  # a difference quotient suffices: only the root matters
        slope = (dense_component(x + step, independent, work.y, work.f) - miss - moment) / step
        new = x - miss / slope if slope > 0.0 else 0.5 * (a + b)
        if not a <= new <= b:
            new = 0.5 * (a + b)
        if abs(new - x) <= 1e-15:
            return new
        x = new
    return x


@kernel
def write_sample(at, y, out):
    """Write the time histories at the state `y` to `out`, in the order of the channels."""
    work = at[0]
    invoke(work.sample.code, work.sample.parameters, (y, work.mode, work.latched, work.side, out), out.size)


@kernel
def write_samples(at):
    """Write the samples within the latest step, from its dense output."""
    work = at[0]
    record = work.record
    independent = record.independent
    i = work.counts.samples
    while i < record.times.size and record.times[i] <= work.end[independent]:
        dense_state(share_at(at, independent, record.times[i]), work.y, work.f, work.z)
        work.z[independent] = record.times[i]
        for j in range(work.mode.size):  # just before a separation rounding may put the interpolant below zero
            work.z[work.time + 1 + j] = max(work.z[work.time + 1 + j], 0.0)
        write_sample(at, work.z, record.samples[i])
        i += 1
    work.counts.samples = i


def sample_states(work, states, out):
    """Write the time histories at `states` (states, n) to `out` (states, channels), without forces."""
    at = pointer_to(work)
    for i in range(states.shape[0]):
        work.z[:] = states[i]
        write_sample(at, work.z, out[i])
