"""Where the bodies are within a step."""

import numpy as np

from ...compiled.family import kernel
from ...observe.histogram import BETWEEN
from ...observe.observables import NODES, SHARES
from ..dop853 import dense_component
from ..event import IMPLICIT

PLACES = np.arange(1, BETWEEN + 2) / (BETWEEN + 1)


def _integrals(nodes, ends):
    """Return the (nodes, ends) matrix of the integral from 0 to `ends` of the polynomial through values at `nodes`."""
    coefficients = np.linalg.inv(np.vander(nodes, increasing=True))
    powers = np.arange(1, nodes.size + 1)
    return ((ends[:, None] ** powers / powers) @ coefficients).T


TRAVEL = np.ascontiguousarray(_integrals(SHARES, PLACES))  # (stages, BETWEEN + 1), to the end of the step at last


@kernel
def look_between(at, h, between):
    """Put coordinates, their rates and time at the quarters of the step of length `h` into `between`.

    between : (BETWEEN, 2 coordinates + 1).  The explicit method's are the polynomial through the rates at its stages,
    put right at the end of the step; the implicit method has its dense output.
    """
    work = at[0]
    for i in range(between.shape[1]):
        if work.method[0] == IMPLICIT:
            for place in range(BETWEEN):
                between[place, i] = dense_component(PLACES[place], i, work.y, work.f)
            continue
        amiss = work.end[i] - work.y[i]
        for m in range(NODES.size):
            amiss -= h * TRAVEL[m, BETWEEN] * work.k[NODES[m], i]
        for place in range(BETWEEN):
            travel = amiss * PLACES[place]
            for m in range(NODES.size):
                travel += h * TRAVEL[m, place] * work.k[NODES[m], i]
            between[place, i] = work.y[i] + travel
