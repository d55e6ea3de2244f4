"""Search for the maximum of an observable between the stages of a step."""

from ...compiled.family import kernel
from ...observe.observables import put_load
from ...observe.stages import NODES, SCRATCH, SHARES
from ..event import evaluate_dense


@kernel
def highest_node(o, column, sign):
    """Return the node of the stage with the largest value of an observable times `sign`."""
    largest = 0
    for m in range(1, NODES.size):
        if sign * o[column, NODES[m]] > sign * o[column, NODES[largest]]:
            largest = m
    return largest


@kernel
def observable_at(at, x, column):
    """Return the observable at the share `x` (0 to 1) of the step, from the dense output in `work.f`."""
    work = at[0]
    evaluate_dense(at, x)
    for j in range(work.mode.size):
        if work.rubs[j]:
            put_load(work.o, SCRATCH, j)
    return work.o[column, SCRATCH]


@kernel
def refined_peak(at, column, sign, node):
    """Return the largest value of the observable times `sign` near the stage `node`, by successive parabolas."""
    m = min(max(node, 1), NODES.size - 2)
    a, b, c = SHARES[m - 1], SHARES[m], SHARES[m + 1]
    fa = sign * observable_at(at, a, column)
    fb = sign * observable_at(at, b, column)
    fc = sign * observable_at(at, c, column)
    largest = max(fa, fb, fc)
    for _ in range(3):
        curvature = (fa - fb) / (a - b) - (fb - fc) / (b - c)
        if curvature * (a - c) >= 0.0:  # not concave: the maximum is at an end
            break
        x = 0.5 * (a + b) - 0.5 * (a - c) * (fa - fb) / ((a - b) * curvature)
        x = min(max(x, 0.0), 1.0)
        if x in (a, b, c):
            break
        fx = sign * observable_at(at, x, column)
        largest = max(largest, fx)
        if abs(x - a) > abs(x - c):  # drop the farther end
            a, fa, b, fb = b, fb, x, fx
        else:
            b, fb, c, fc = x, fx, b, fb
    return largest


@kernel
def highest_between(at, column, sign):
    """Return the largest value of the observable times `sign` near its highest stage, from the dense output."""
    return refined_peak(at, column, sign, highest_node(at[0].o, column, sign))
