"""What Python bodies become: machine code does what they do, for one case and in each of several lanes."""

import itertools
import math
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from clearsweep import simulation
from clearsweep.grid import load
from clearsweep.mechanics import attempt, rates
from clearsweep.mechanics.compiled.family import WIDTH, form_number, numbers_of
from clearsweep.mechanics.joint.places import observed_columns
from clearsweep.mechanics.observe.along import step_width
from clearsweep.mechanics.solver.dop853 import END, ROWS
from clearsweep.mechanics.trace import objects

CONFIGS = sorted(path.name for path in (Path(__file__).parents[1] / "configs").glob("*.yaml"))
MOST = 3  # kinds of scenes of a grid that are looked at


def scenes(name):
    """Yield the scenes of a grid of `configs`, one of each kind."""
    grid, seen = load(Path(__file__).parents[1] / "configs" / name, simulation.catalogue()), set()
    for i in range(min(len(grid), 64)):
        scene = simulation.build(grid.case(i))
        if form_number(scene.value) not in seen and len(seen) < MOST:
            seen.add(form_number(scene.value))
            yield scene


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
    shapes = ((latching,), (n,), (ROWS, n), (ROWS, observed_columns(value.joints)), (n,), (step_width(contacts, n),))
    latched, weight, k, o, end, step = (np.zeros((*shape, WIDTH)) for shape in shapes)
    latched[:], end[:] = 0.5, y
    made = State(numbers, y, mode, latched, weight, k, o, end, step)
    return State(*(np.ascontiguousarray(array) for array in made))


def aligned(array):
    """Return a copy of an array where a register is loaded from."""
    room = np.zeros(array.size + WIDTH, dtype=array.dtype)
    first = -room.ctypes.data // 8 % WIDTH
    copied = room[first : first + array.size].reshape(array.shape)
    copied[...] = array
    return copied


def code_of(scene, width):
    """Return the machine code of a step of so many cases."""
    made = objects.traced(attempt.attempt_entry, scene.value, attempt.ARRAYS, width=width, spread=True)
    return objects.loaded(objects.object_of(made))


def filled(code, state, row, width):
    """Return the State after machine code has filled a row of all lanes, one by one or side by side."""
    found = State(*map(aligned, state))
    call = objects.function_at(code.address, len(attempt.ARRAYS))
    for place in range(0, WIDTH, width):
        call(*(array.ctypes.data + 8 * place for array in found), row)
    return found


@pytest.mark.parametrize("name", CONFIGS)
def test_every_scene_of_the_examples_goes_one_by_one_and_side_by_side_with_the_same_bits(name):
    for scene in scenes(name):
        codes = {width: code_of(scene, width) for width in (1, WIDTH)}
        for row, seed in itertools.product((5, END), (7, 8)):
            state = states(scene, seed)
            one, eight = (filled(code, state, row, width) for width, code in codes.items())
            np.testing.assert_array_equal(one.k, eight.k)
            np.testing.assert_array_equal(one.o, eight.o)


@pytest.mark.parametrize("name", CONFIGS)
def test_machine_code_does_what_the_body_does(name):
    """To rounding: where nothing fuses, sums of products differ in their last digits, and what cancels by more."""
    for scene in scenes(name):
        state = states(scene)
        found = filled(code_of(scene, 1), state, END, 1)
        for place in range(WIDTH):
            plain = State(*(np.ascontiguousarray(array[..., place]) for array in state))
            attempt.attempt_entry((scene.value,), *plain[1:], END)
            for ours, theirs in ((found.k, plain.k), (found.o, plain.o)):
                size = np.maximum(np.abs(theirs[END]), 1e-6 * np.abs(theirs[END]).max())
                np.testing.assert_array_less(np.abs(ours[END, :, place] - theirs[END]), 1e-9 * size + 1e-300)
