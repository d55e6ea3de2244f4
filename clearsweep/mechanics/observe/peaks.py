"""Where between the stages of a step an observable is largest."""

from typing import NamedTuple

from ..compiled.family import kernel
from ..solver.dop853 import SCRATCH
from ..solver.event import evaluate_dense
from ..solver.step import finish_dense
from .observables import NODES, SHARES, put_load


@kernel
def highest_node(o, column, sign):
    """Return the node of the stage at which an observable, times `sign`, is largest."""
    best = 0
    for m in range(1, NODES.size):
        if sign * o[NODES[m], column] > sign * o[NODES[best], column]:
            best = m
    return best


@kernel
def observable_at(at, x, column):
    """Return the observable at the share `x` of the step, from the dense output in `work.f`."""
    work = at[0]
    evaluate_dense(at, x)
    for j in range(work.mode.size):
        if work.rubs[j]:
            put_load(work.o, SCRATCH, j)
    return work.o[SCRATCH, column]


@kernel
def refined_peak(at, column, sign, node):
    """Return the largest value of the observable, times `sign`, near the stage `node`: successive parabolas."""
    m = min(max(node, 1), NODES.size - 2)
    a, b, c = SHARES[m - 1], SHARES[m], SHARES[m + 1]
    fa = sign * observable_at(at, a, column)
    fb = sign * observable_at(at, b, column)
    fc = sign * observable_at(at, c, column)
    best = max(fa, fb, fc)
    for _ in range(3):
        bend = (fa - fb) / (a - b) - (fb - fc) / (b - c)
        if bend * (a - c) >= 0.0:  # not concave: the peak is at an end
            break
        x = 0.5 * (a + b) - 0.5 * (a - c) * (fa - fb) / ((a - b) * bend)
        x = min(max(x, 0.0), 1.0)
        if x in (a, b, c):
            break
        fx = sign * observable_at(at, x, column)
        best = max(best, fx)
        if abs(x - a) > abs(x - c):  # drop the farther end
            a, fa, b, fb = b, fb, x, fx
        else:
            b, fb, c, fc = x, fx, b, fb
    return best


class Peak(NamedTuple):
    """What is looked for between the ends of a step."""

    column: int  # of the observables
    sign: float  # by which it is multiplied
    least: float  # below which it is of no account
    highest: float  # at the stages, -inf where it has no peak in the step, see `along.highest_inside`


@kernel
def located(at, h, peak, best, dense):
    """Return the largest value of an observable in the step, and whether the dense output is made now.

    `best` is the larger of the values at the ends, times the sign of the Peak; what lies between is located unless it
    stays below its least.
    """
    if peak.highest > peak.least:
        node = highest_node(at[0].o, peak.column, peak.sign)
        if not dense:
            finish_dense(at, h)
        return max(best, refined_peak(at, peak.column, peak.sign, node)), True
    return best, dense
