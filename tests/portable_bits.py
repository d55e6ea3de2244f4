"""Prints a hash of constants, set-up and short runs: `python tests/portable_bits.py LEVEL [CONFIG ...]`.

LEVEL is a level of processors for which code is compiled.  Environment variables make numpy and OpenBLAS choose code
for another processor; see `test_portable`.
"""

import hashlib
import importlib
import json
import pkgutil
import sys
from pathlib import Path

import numpy as np

import clearsweep
from clearsweep import grid, mechanics
from clearsweep.mechanics.trace import objects
from clearsweep.simulation import catalogue, scene

CONFIGS = Path(__file__).parents[1] / "configs"
CLOCKS = ("run_time", "setup_time")


def digest(*arrays):
    """Return a hash of the bits of arrays."""
    return hashlib.sha256(b"".join(np.ascontiguousarray(array).tobytes() for array in arrays)).hexdigest()[:16]


def constants():
    """Return a hash of all arrays and numbers of each module of the mechanics."""
    digests = {}
    for module in pkgutil.walk_packages(mechanics.__path__, "clearsweep.mechanics."):
        values = vars(importlib.import_module(module.name)).values()
        arrays = [np.asarray(value) for value in values if isinstance(value, float | np.ndarray)]
        digests[module.name] = digest(*(array for array in arrays if array.dtype == float))
    return digests


def run(name):
    """Return the identity of the first case of a grid, and hashes of its start, its motion and its figures."""
    loaded = grid.load(CONFIGS / name, catalogue())
    case = loaded.case(0)
    short = case.simulate._replace(revolutions=min(case.simulate.revolutions, 2), discard=0)
    made = scene.build(case._replace(simulate=short, life=None))
    path = clearsweep.simulate(made)
    figures = [x for key, x in path.summary.items() if isinstance(x, float) and key not in CLOCKS]
    return loaded.case_id(0), digest(made.start), digest(path.t, *path.channels.values()), digest(figures)


if __name__ == "__main__":
    level, *names = sys.argv[1:]
    objects._own_level = lambda: level
    print(json.dumps({"constants": constants()} | {name: run(name) for name in names}))
