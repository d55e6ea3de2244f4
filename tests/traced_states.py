"""States of scenes, and what machine code makes of them."""

import math
from typing import NamedTuple

import numpy as np

from clearsweep.mechanics.compiled.family import WIDTH, form_number, numbers_of
from clearsweep.mechanics.coupling import rates, trial_step
from clearsweep.mechanics.solver.accumulate.step_sums import step_width
from clearsweep.mechanics.solver.dop853 import ROWS
from clearsweep.mechanics.trace import objects


class State(NamedTuple):
    """Arrays of several cases, as an Attempt has them, and the parameters of their scenes."""

    parameters: np.ndarray
    y: np.ndarray
    mode: np.ndarray
    latched: np.ndarray
    weight: np.ndarray
    k: np.ndarray
    o: np.ndarray
    end: np.ndarray
    step: np.ndarray

    def lane(self, place):
        """Return the arrays of one case."""
        return State(*(array[..., place] for array in self))


def states(scene, seed=7):
    """Return the State of WIDTH cases of one scene, each somewhere else, in contact or not."""
    drawn, value = np.random.default_rng(seed), scene.value
    contacts, n, latching = rates.size_of(value)
    clearance, half = value.joints[0].clearance, len(value.coordinates)
    start = np.resize(scene.start, n)[:, None] * np.ones(WIDTH)
    start[2 * half + 1 :] = 0.0
    size = np.zeros(n)
    size[:half], size[half : 2 * half], size[2 * half] = 0.3 * clearance, 0.1, 1e-4
    size[2 * half + 1 :] = math.sqrt(0.01 * clearance)
    y = start + size[:, None] * drawn.normal(size=(n, WIDTH))
    y[2 * half + 1 :] = np.abs(y[2 * half + 1 :])
    mode = drawn.integers(0, 2, size=(contacts, WIDTH))
    numbers = np.array(numbers_of(value), dtype=float)[:, None] * np.ones(WIDTH)
    shapes = ((latching,), (n,), (ROWS, n), (ROWS, rates.observed_width(value)), (n,), (step_width(contacts, n),))
    latched, weight, k, o, end, step = (np.zeros((*shape, WIDTH)) for shape in shapes)
    latched[:], end[:] = 0.5, y
    made = State(numbers, y, mode, latched, weight, k, o, end, step)
    return State(*(np.ascontiguousarray(array) for array in made))


def aligned(array):
    """Return a copy of an array where a register is loaded from."""
    buffer = np.zeros(array.size + WIDTH, dtype=array.dtype)
    first = -buffer.ctypes.data // 8 % WIDTH
    copied = buffer[first : first + array.size].reshape(array.shape)
    copied[...] = array
    return copied


def code_of(scene, width):
    """Return the machine code of a step of so many cases; that of a kind of scene is made once."""
    key = form_number(scene.value), width
    if key not in _CODE:
        _CODE[key] = _made(scene, width)
    return _CODE[key]


_CODE = {}


def _made(scene, width):
    made = objects.traced(trial_step.trial_step_entry, scene.value, trial_step.ARRAYS, width=width, spread=True)
    return objects.loaded(objects.object_of(made))


def filled(code, state, row, width):
    """Return the State after machine code has filled a row of all lanes, one by one or side by side."""
    result = State(*map(aligned, state))
    call = objects.function_at(code.address, len(trial_step.ARRAYS))
    for place in range(0, WIDTH, width):
        call(*(array.ctypes.data + 8 * place for array in result), row)
    return result
