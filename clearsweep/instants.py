"""The times at which a motion is reported."""

import math

import numpy as np

from .errors import InputError


def checked(times, end: float) -> np.ndarray:
    """Return times (s) that a user asks for, as an array; raise InputError unless they lie within a run up to `end`."""
    times = np.ascontiguousarray(times, dtype=float)
    if times.ndim != 1 or not np.all(np.isfinite(times)) or np.any(np.diff(times) < 0.0):
        raise InputError("times: expected a one-dimensional array of increasing, finite times in s")
    if times.size and not (times[0] >= 0.0 and times[-1] <= end * (1.0 + 1e-12)):
        raise InputError(f"times: found {times[0]:.6g} s to {times[-1]:.6g} s; the run lasts from 0 to {end:.6g} s")
    return np.minimum(times, end)


def own(case: dict, turn: float, end: float) -> np.ndarray:
    """Return the times (s) of a case's own sampling: k / samples of a `turn` (s), both ends of the stretch included."""
    save, revolutions = case["save"], case["simulate"]["revolutions"]
    first = 0 if save["orbits"] == "all" else round((revolutions - save["revolutions"]) * save["samples"])
    count = np.arange(first, math.floor(revolutions * save["samples"] + 1e-9) + 1)
    return np.minimum(count / save["samples"] * turn, end)
