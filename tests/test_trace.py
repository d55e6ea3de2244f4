"""What Python bodies become: machine code does what they do, for one state and in each of several lanes."""

from pathlib import Path

import numpy as np
import pytest
from traced_states import observed, rates_of, states

from clearsweep import simulation
from clearsweep.grid import load
from clearsweep.mechanics.coupling import entries
from clearsweep.mechanics.observe import END, ERROR, ERROR_RATE, STAGES
from clearsweep.tracing.compiled.family import form_number

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


@pytest.mark.few("slider_crank.yaml", "two_joints.yaml", "lubricated.yaml", "worn_slider_crank.yaml", "four_bar.yaml")
@pytest.mark.parametrize("name", CONFIGS)
def test_all_stages_observed_at_once_have_the_bits_of_each_in_every_example(name):
    for scene in scenes(name):
        for seed in (7, 8):
            state = states(scene, seed)
            each, together = rates_of(scene, state).o, observed(scene, state).o
            each[[ERROR, ERROR_RATE], :END] = 0.0  # looked up at the end alone
            np.testing.assert_array_equal(each, together)


@pytest.mark.few("slider_crank.yaml", "lubricated.yaml", "worn_slider_crank.yaml", "spatial_four_bar.yaml")
@pytest.mark.parametrize("name", CONFIGS)
def test_machine_code_does_what_the_body_does(name):
    """To rounding: where nothing fuses, sums of products differ in their last digits, and what cancels by more."""
    for scene in scenes(name):
        state = states(scene)
        result = rates_of(scene, state)
        for row in range(STAGES):
            y = np.ascontiguousarray(state.nodes[:-1, row])
            entries.rates_entry((scene.value,), y, state.mode, state.latched, state.k, state.o, row)
            for ours, theirs in ((result.k, state.k), (result.o, state.o)):
                size = np.maximum(np.abs(theirs[:, row]), 1e-6 * np.abs(theirs[:, row]).max())
                np.testing.assert_array_less(np.abs(ours[:, row] - theirs[:, row]), 1e-9 * size + 1e-300)
