"""Columns of short runs of `configs/`, and hashes of their bits: `python tests/portable_bits.py LEVEL [CONFIG ...]`.

LEVEL is a level of processors for which code is compiled, also one below those of the package.  Environment variables
make numpy and OpenBLAS choose code for another processor; see `test_portable`.
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
from clearsweep.contracts.results import TIMINGS
from clearsweep.simulation import catalogue
from clearsweep.simulation.setup import scene
from clearsweep.tracing import objects

CONFIGS = Path(__file__).parents[1] / "configs"
REVOLUTIONS = 1.0  # of a short run, at most
LONGER = 3.0  # revolutions at most of a run whose length depends on its figures


def digest(*arrays):
    """Return a hash of the bits of arrays."""
    return hashlib.sha256(b"".join(np.ascontiguousarray(array).tobytes() for array in arrays)).hexdigest()[:12]


def constants():
    """Return a hash of all arrays and numbers of each module of the mechanics."""
    digests = {}
    for module in pkgutil.walk_packages(mechanics.__path__, "clearsweep.mechanics."):
        values = vars(importlib.import_module(module.name)).values()
        arrays = [np.asarray(value) for value in values if isinstance(value, float | np.ndarray)]
        digests[module.name] = digest(*(array for array in arrays if array.dtype == float))
    return digests


def shortened(case):
    """Return a case of at most REVOLUTIONS that stores histories; if it discards any, a quarter; its life stays."""
    settings = case.simulate
    length = min(settings.revolutions, REVOLUTIONS)
    changes = {"revolutions": length, "discard": 0.25 * length if settings.discard else 0.0}
    if settings.until:
        changes["until"] = settings.until._replace(max_revolutions=LONGER)
    save = case.save._replace(revolutions=min(case.save.revolutions or length, length))
    if save.orbits == "none":
        save = save._replace(orbits="last")
    return case._replace(simulate=settings._replace(**changes), save=save)


def columns(name, last=False):
    """Return the figures of the first or last case of a grid, as numbers or texts, and its arrays: all by name."""
    loaded = grid.load(CONFIGS / name, catalogue())
    built = scene.build(shortened(loaded.case(len(loaded) - 1 if last else 0)))
    path = clearsweep.simulate(built)
    figures = {"status": path.status} | {key: value for key, value in path.summary.items() if key not in TIMINGS}
    arrays = {"start": built.start} | path.channels | path.poincare
    arrays |= {f"history/{key}": values for key, values in path.history.items()}
    arrays |= {f"events/{key}": path.events[key] for key in ("t", "rate", "force_peak")}
    for joint, depths in path.wear.items():
        arrays |= {f"wear/{joint}/{body}": depth for body, depth in zip(("bearing", "journal"), depths, strict=True)}
    return figures | arrays


def bits(values):
    """Return the text of each figure, with all its digits, and the hash of each array."""
    return {name: digest(value) if isinstance(value, np.ndarray) else repr(value) for name, value in values.items()}


class NoFeatures(dict):
    """The features of a processor that has no more than its level."""

    def flatten(self):
        """Return them as a text for LLVM."""
        return ""


if __name__ == "__main__":
    level, *names = sys.argv[1:]
    objects._own_level = lambda: level
    objects.llvm.get_host_cpu_features = NoFeatures
    print(json.dumps({"constants": constants()} | {name: bits(columns(name)) for name in names}))
