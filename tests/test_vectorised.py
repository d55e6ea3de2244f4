"""Every scene is vectorised: with any law the stages of a step can be traced in the lanes of a register."""

import pytest
from law_cases import RECIPES, joint
from mechanism_cases import slider_crank
from test_every_transition import case_of as in_transition
from test_film import oiled
from test_roughness import rough

import clearsweep
from clearsweep import simulation
from clearsweep.mechanics.coupling import entries
from clearsweep.tracing import objects

pytestmark = pytest.mark.heavy

#: Family -> a joint with the law of that name; laws of wear are no part of a step.
JOINTS = {
    "law": joint,
    "elastic": lambda name: joint("exact", name),
    "friction": lambda name: joint(friction=name),
    "roughness": lambda name: rough(law=name),
    "film": oiled,
    "film-friction": lambda name: oiled(friction=name),
    "transition": in_transition,
}


@pytest.mark.few("law-exact", "elastic-persson", "friction-lugre", "roughness-fractal", "film-reynolds")
@pytest.mark.parametrize(("family", "name"), [key for key in RECIPES if key[0] in JOINTS])
def test_steps_with_every_law_are_vectorised(family, name):
    """The stages of a step of a slider-crank can be traced; NotTraceableError says why not."""
    case = clearsweep.load_case(slider_crank("rod-slider")).case
    scene = simulation.build(case._replace(joints=(JOINTS[family](name),)))
    objects.trace_scene(entries.sweep_entry, scene.value, "fifffff")
