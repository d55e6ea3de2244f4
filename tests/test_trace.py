"""What Python bodies become: machine code does what they do, for one case and in each of several lanes."""

import itertools
from pathlib import Path

import numpy as np
import pytest
from traced_states import State, code_of, filled, states

from clearsweep import simulation
from clearsweep.grid import load
from clearsweep.mechanics.compiled.family import WIDTH, form_number
from clearsweep.mechanics.coupling import trial_step
from clearsweep.mechanics.solver.dop853 import END

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


@pytest.mark.parametrize("name", CONFIGS)
def test_every_scene_of_the_examples_goes_one_by_one_and_side_by_side_with_the_same_bits(name):
    for scene in scenes(name):
        codes = {width: code_of(scene, width) for width in (1, WIDTH)}
        for row, seed in itertools.product((5, END), (7, 8)):
            state = states(scene, seed)
            first, eight = (filled(code, state, row, width) for width, code in codes.items())
            np.testing.assert_array_equal(first.k, eight.k)
            np.testing.assert_array_equal(first.o, eight.o)


@pytest.mark.parametrize("name", CONFIGS)
def test_machine_code_does_what_the_body_does(name):
    """To rounding: where nothing fuses, sums of products differ in their last digits, and what cancels by more."""
    for scene in scenes(name):
        state = states(scene)
        result = filled(code_of(scene, 1), state, END, 1)
        for place in range(WIDTH):
            plain = State(*(np.ascontiguousarray(array[..., place]) for array in state))
            trial_step.trial_step_entry((scene.value,), *plain[1:], END)
            for ours, theirs in ((result.k, plain.k), (result.o, plain.o)):
                size = np.maximum(np.abs(theirs[END]), 1e-6 * np.abs(theirs[END]).max())
                np.testing.assert_array_less(np.abs(ours[END, :, place] - theirs[END]), 1e-9 * size + 1e-300)
