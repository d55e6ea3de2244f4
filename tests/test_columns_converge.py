"""Every column of every file of configs/ converges with the tolerance where the motion does.

`python tests/test_columns_converge.py [FILE ...]` prints the columns that do not.  The first case of each file runs for
at most one revolution at tolerances from 1e-6 to 1e-11.
"""

import itertools
import sys

import numpy as np
import portable_bits
import pytest

import clearsweep
from clearsweep import grid
from clearsweep.simulation import catalogue
from clearsweep.simulation.setup import scene

GRIDS = sorted(path.name for path in portable_bits.CONFIGS.glob("*.yaml"))
TOLERANCES = (1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11)
SAME_MOTION = 1e-4  # of the range of each position: largest difference of two runs whose columns are compared
ALLOWED = 0.02  # of a column
#: Of the share of time with narrow arcs: their width is straight between the nodes of a step, which no onset is.
OF_NARROW_ARCS = 1e-3
OF_A_LIFE = 0.05  # of the limit of a life: some blocks have all its columns, and each takes minutes at 1e-11
#: Parts of the names of columns that describe the computation: its cost, its errors, its message, what its tolerance
#: defines.
OF_THE_COMPUTATION = (
    "horizon",
    "steps",
    "evaluations",
    "_time_wall",
    "tolerance",
    "residual",
    "message",
    "status",
    "_difference",
)


def runs_of(name):
    """Return the positions (channels, samples), the figures and the duration (s) at each tolerance."""
    case = portable_bits.shortened(grid.load(portable_bits.CONFIGS / name, catalogue()).case(0))
    case = case._replace(save=case.save._replace(orbits="all"))
    if case.life:
        case = case._replace(life=case.life._replace(limit=OF_A_LIFE * case.life.limit))
    runs = []
    for tolerance in TOLERANCES:
        built = scene.build(case._replace(simulate=case.simulate._replace(tolerance=tolerance)))
        path = clearsweep.simulate(built)
        if path.status == "ok":
            channels = [path[key] for key in sorted(path.channels) if key.endswith(("/x", "/y", "/angle", "/place"))]
            runs.append((channels, path.summary, path.t[-1] - path.t[0]))
    return runs


def apart(first, second):
    """Return the largest difference of the positions of two runs over their range; inf if they differ in length."""
    if any(a.shape != b.shape for a, b in zip(first, second, strict=True)):
        return np.inf
    return max((np.max(np.abs(a - b)) / (np.ptp(b) or 1.0) for a, b in zip(first, second, strict=True)), default=0.0)


def astray(first, second, duration):
    """Return what does not agree in the figures of two runs of the same motion: column -> both values.

    duration : s; the growth of a disturbance over it is known to a factor e, as an impact changes its size at once
    """
    columns = {}
    for key in first.keys() & second.keys():
        a, b = first[key], second[key]
        if any(part in key for part in OF_THE_COMPUTATION) or key in portable_bits.TIMINGS or a == b:
            continue
        numbers = isinstance(a, int | float) and isinstance(b, int | float)
        floor = 1.0 if isinstance(a, int) and isinstance(b, int) else 0.0
        floor = OF_NARROW_ARCS if key.endswith("wear_narrow_arcs") else floor
        floor = 1.0 / duration if key == "lyapunov_exponent" else floor
        if not (numbers and abs(a - b) <= max(ALLOWED * max(abs(a), abs(b)), floor)):
            columns[key] = (a, b)
    return columns


def columns_astray(name):
    """Return the columns of a file that differ between two tolerances at which its motion is the same."""
    differences = {}
    for (slower, coarse, duration), (finer, fine, *_) in itertools.pairwise(runs_of(name)):
        if apart(slower, finer) < SAME_MOTION:
            differences |= astray(coarse, fine, duration)
    return differences


@pytest.mark.slow
@pytest.mark.parametrize("name", GRIDS)
def test_columns_converge_where_the_motion_does(name):
    assert columns_astray(name) == {}


if __name__ == "__main__":
    for name in sys.argv[1:] or GRIDS:
        print(name, flush=True)
        for key, values in sorted(columns_astray(name).items()):
            print(f"  {key}: {values[0]} at a larger tolerance, {values[1]} at a smaller one", flush=True)
