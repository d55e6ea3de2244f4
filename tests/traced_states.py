"""States of scenes, and the results of machine code for them."""

import math
from typing import NamedTuple

import numpy as np

from clearsweep.mechanics.coupling import entries, rates
from clearsweep.mechanics.observe import ROW_COUNT, STAGES
from clearsweep.tracing import objects
from clearsweep.tracing.compiled.family import form_number, kinds, numbers_of
from clearsweep.tracing.symbols import WIDTH


class State(NamedTuple):
    """Eight states of a scene, as the stages of a step, and the results for them."""

    parameters: np.ndarray
    nodes: np.ndarray  # (n + 1 + contacts, STAGES)
    mode: np.ndarray
    latched: np.ndarray
    k: np.ndarray  # (n, ROW_COUNT)
    o: np.ndarray  # (columns, ROW_COUNT)


def states(scene, seed=7):
    """Return the State of a scene with eight different states, some in contact."""
    drawn, value = np.random.default_rng(seed), scene.value
    contacts, n, latching = rates.size_of(value)
    clearance, half = value.joints[0].clearance, len(value.coordinates)
    start = np.resize(scene.start, n)[:, None] * np.ones(STAGES)
    start[2 * half + 1 :] = 0.0
    size = np.zeros(n)
    size[:half], size[half : 2 * half], size[2 * half] = 0.3 * clearance, 0.1, 1e-4
    size[2 * half + 1 :] = math.sqrt(0.01 * clearance)
    nodes = np.zeros((n + 1 + contacts, STAGES))
    nodes[:n] = start + size[:, None] * drawn.normal(size=(n, STAGES))
    nodes[2 * half + 1 : n] = np.abs(nodes[2 * half + 1 : n])
    mode = drawn.integers(0, 2, size=contacts)
    numbers = np.array(numbers_of(value), dtype=float)
    k, o = np.zeros((n, ROW_COUNT)), np.zeros((rates.observed_width(value), ROW_COUNT))
    return State(*map(aligned, (numbers, nodes, mode, np.full(latching, 0.5), k, o)))


def aligned(array):
    """Return a copy of an array with the alignment of a register."""
    buffer = np.zeros(array.size + WIDTH, dtype=array.dtype)
    first = -buffer.ctypes.data // 8 % WIDTH
    copied = buffer[first : first + array.size].reshape(array.shape)
    copied[...] = array
    return copied


def code_of(scene, function, items):
    """Return the machine code of a function of `trial_step` for a scene, compiled once for each kind of scene."""
    key = form_number(scene.value), function
    if key not in _CODE:
        _CODE[key] = objects.compiled_code(function, scene.value, kinds(scene.value), items)
    return _CODE[key]


_CODE = {}


def rates_of(scene, state):
    """Return the State with rates and observables of its stages by machine code, one after another."""
    result = State(*map(aligned, state))
    call = objects.function_at(code_of(scene, entries.rates_entry, "fifff").address, 5)
    for row in range(STAGES):
        y = np.ascontiguousarray(result.nodes[: len(result.k), row])
        given = result.parameters, y, result.mode, result.latched, result.k, result.o
        call(*(array.ctypes.data for array in given), row)
    return result


def observed(scene, state):
    """Return the State with observables of its stages by machine code, all at once."""
    result = State(*map(aligned, state))
    call = objects.function_at(code_of(scene, entries.observe_entry, "fiff").address, 4)
    given = result.parameters, result.nodes, result.mode, result.latched, result.o
    call(*(array.ctypes.data for array in given), 0)
    return result
