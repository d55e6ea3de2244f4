"""Where the bodies are within a step."""

import numpy as np

from ...compiled.choosing import abreast
from ...compiled.family import kernel
from ...observe.histogram import BETWEEN, MOMENTS
from ...observe.observables import NODES, SHARES
from ..dop853 import dense_component
from ..event import IMPLICIT

PLACES = np.minimum(np.arange(MOMENTS) / (BETWEEN + 1), 1.0)


def _integrals(nodes, ends):
    """Return the (nodes, ends) matrix of the integral from 0 to `ends` of the polynomial through values at `nodes`."""
    coefficients = np.linalg.inv(np.vander(nodes, increasing=True))
    powers = np.arange(1, nodes.size + 1)
    return ((ends[:, None] ** powers / powers) @ coefficients).T


TRAVEL = np.ascontiguousarray(_integrals(SHARES, PLACES))  # (stages, MOMENTS)


@kernel
def look_between(at, h, between):
    """Put coordinates, their rates and time at the moments of the step of length `h` into `between`.

    between : (2 coordinates + 1, MOMENTS), from the start to the end of the step by quarters, then the end again.  The
    explicit method's are the polynomial through the rates at its stages, put right at the end of the step; the implicit
    method has its dense output.
    """
    work = at[0]
    for i in range(between.shape[0]):
        begin, end = work.y[i], work.end[i]
        if work.method[0] == IMPLICIT:
            for place in range(1, BETWEEN + 1):
                between[i, place] = dense_component(PLACES[place], i, work.y, work.f)
        else:
            amiss = end - begin
            for m in range(NODES.size):
                amiss -= h * TRAVEL[m, BETWEEN + 1] * work.k[NODES[m], i]
            for place in abreast(MOMENTS):
                travel = amiss * PLACES[place]
                for m in range(NODES.size):
                    travel += h * TRAVEL[m, place] * work.k[NODES[m], i]
                between[i, place] = begin + travel
        between[i, 0] = begin
        for place in range(BETWEEN + 1, MOMENTS):
            between[i, place] = end
