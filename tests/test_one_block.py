"""A law is one block: entered here, it is known to the grid, to `clearsweep list` and to a run, with no other edit."""

import os
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from click.testing import CliRunner
from law_cases import compiled_contact
from mechanism_cases import PAIR, changed, slider_crank

from clearsweep import InputError, grid, simulation
from clearsweep.cli import verbs
from clearsweep.contracts.catalogue import Field, Law
from clearsweep.mechanics.joints import registry
from clearsweep.mechanics.laws import contract
from clearsweep.mechanics.laws.contract import internal_state
from clearsweep.mechanics.laws.elastic import Linear, elastic_force
from clearsweep.mechanics.laws.friction import friction_force
from clearsweep.mechanics.laws.loss import RESTITUTION, contact_force, hysteresis_rebound, register_contact_force

BLOCK = """
from typing import NamedTuple
from clearsweep.contracts.catalogue import Field
from clearsweep.mechanics.laws.elastic import elastic_force
from clearsweep.mechanics.laws.loss import register_contact_force
from clearsweep.mechanics.laws.contract import register

class Sticky(NamedTuple):
    damping: float

@register_contact_force(Sticky, pulls=True, times_elastic=True)
def _sticky(law, elastic, pen, rate, onset_rate):
    force = elastic_force(elastic, pen)
    return force * (1.0 + law.damping * rate / onset_rate), force

register(
    "law sticky: made up for a test",
    "F = F_elastic (1 + b u)",
    "nobody",
    (Field("loss", "1", "b"),),
    types=(Sticky,),
    make=lambda joint: Sticky(joint.contact.values["loss"]),
)
"""
CONTACT = {"law": "sticky", "stiffness": 6.61e10, "loss": 0.8}


@pytest.fixture
def recipes():
    """Restore the laws that were there before."""
    before = dict(contract.RECIPES)
    yield contract.RECIPES
    contract.RECIPES.clear()
    contract.RECIPES.update(before)


@pytest.fixture
def sticky(recipes, tmp_path):
    """Return the type of a law entered by its block alone."""
    names, file = {"__name__": "block"}, tmp_path / "block.py"
    file.write_text(BLOCK)
    exec(compile(BLOCK, str(file), "exec"), names)
    return names["Sticky"]


def test_the_grid_and_the_list_know_a_law_that_was_entered(sticky):
    (joint,) = grid.load(changed(PAIR, {"joints.pair.contact": CONTACT}), simulation.catalogue()).case(0).joints
    law, elastic = registry.compile_contact(joint)
    assert law == sticky(0.8)
    assert registry.can_pull(joint)
    assert registry.restitution(joint) is None
    message = CliRunner().invoke(verbs, ["laws", "sticky"])
    assert message.exit_code == 0
    assert "F = F_elastic (1 + b u)" in message.output
    assert "made up for a test" in CliRunner().invoke(verbs, ["laws"]).output
    rates = np.linspace(-2.0, 2.0, 9)
    expected = elastic_force(elastic, 1e-5) * (1.0 + 0.8 * rates / 0.5)
    assert compiled_contact(law, elastic, 1e-5, rates, 0.5) == pytest.approx(expected, rel=1e-12)
    with pytest.raises(InputError, match=r"contact\.loss: is missing for sticky"):
        grid.load(
            changed(PAIR, {"joints.pair.contact": {"law": "sticky", "stiffness": 6.61e10}}), simulation.catalogue()
        )


def test_a_law_that_was_entered_runs():
    """A free impact gives back the closed form of its factor; the compiler is off, lest its cache keep the law."""
    case = changed(PAIR, {"joints.pair.contact": CONTACT, "simulate.impacts": 1, "simulate.tolerance": 1e-8})
    program = (
        f"{BLOCK}\nimport clearsweep\nrun = clearsweep.simulate(clearsweep.load_case({case!r}))\n"
        "print(run.status, run.summary['pair_restitution'])\n"
    )
    place = {"cwd": Path(__file__).parents[1], "env": {**os.environ, "CLEARSWEEP_DISABLE_JIT": "1"}}
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False, **place)
    assert done.returncode == 0, done.stderr
    status, restitution = done.stdout.split()
    assert status == "ok"
    assert float(restitution) == pytest.approx(hysteresis_rebound(0.8), abs=1e-6)


# ---------------------------------------------------------------------------------------------- what is not declared


class Bare(NamedTuple):
    """A type whose body is entered past the declarations."""


class Forgetful(NamedTuple):
    """A type that has an internal state, but says nothing of its rates."""


@contact_force.member(Bare)
def _bare(law, elastic, pen, rate, onset_rate):
    return 0.0, 0.0


@friction_force.member(Forgetful)
@internal_state.member(Forgetful)
def _forgetful(friction, *rest):
    return ()


def entered(law, form):
    contract.register_recipe(contract.Recipe(law, (form,), lambda joint: form()))


def test_a_law_without_its_declarations_is_refused_when_it_is_entered(recipes):
    known = len(recipes)
    with pytest.raises(TypeError, match="law 'bare': Bare declares no lowest_force, sign_past_separation"):
        entered(Law("law", "bare", "", "", ""), Bare)
    with pytest.raises(TypeError, match="elastic 'bare': Bare declares no elastic_force, root_parity"):
        entered(Law("elastic", "bare", "", "", ""), Bare)
    with pytest.raises(TypeError, match="wear 'bare': Bare declares no wear_rate"):
        entered(Law("wear", "bare", "", "", ""), Bare)
    with pytest.raises(TypeError, match="pressure 'bare': Bare declares no half_arc, cumulative_pressure"):
        entered(Law("pressure", "bare", "", "", ""), Bare)
    with pytest.raises(TypeError, match="Forgetful declares one of internal_state and internal_rates"):
        entered(Law("friction", "forgetful", "", "", ""), Forgetful)
    with pytest.raises(TypeError, match="unknown family"):
        entered(Law("lubrication", "bare", "", "", ""), Bare)
    with pytest.raises(TypeError, match="pulls"):
        register_contact_force(Bare, times_elastic=True)
    assert len(recipes) == known


def test_a_law_whose_description_does_not_fit_its_numbers_is_refused(recipes):
    hertz = recipes["law", "hertz"]
    with pytest.raises(TypeError, match="law 'hertz': is the name of a law of the package"):
        contract.register_recipe(hertz)
    silent = hertz.law._replace(name="silent", fields=(RESTITUTION,))
    with pytest.raises(TypeError, match="takes a restitution, but declares none that a free impact returns"):
        contract.register_recipe(hertz._replace(law=silent, free_restitution=None))
    with pytest.raises(TypeError, match="takes no stiffness for a spring of its own"):
        contract.register_recipe(hertz._replace(law=hertz.law._replace(name="loose", uses_elastic=False)))


def test_a_maker_that_returns_another_type_than_it_was_entered_with_is_found(recipes):
    hertz = recipes["law", "hertz"]
    contract.register_recipe(hertz._replace(law=hertz.law._replace(name="astray"), make=lambda joint: Linear(1.0)))
    case = changed(PAIR, {"joints.pair.contact": {"law": "astray", "stiffness": 6.61e10}})
    joint = grid.load(case, simulation.catalogue()).case(0).joints[0]
    with pytest.raises(TypeError, match="law 'astray': makes a Linear, entered with Lossless"):
        registry.compile_contact(joint)


def test_a_pressure_and_a_friction_law_that_were_entered_are_found_by_the_grid(recipes):
    mean, tanh = recipes["pressure", "mean"], recipes["friction", "tanh"]
    contract.register_recipe(mean._replace(law=mean.law._replace(name="even")))
    fields = (*tanh.law.fields[:1], Field("velocity_scale", "m/s", default=2e-3))
    contract.register_recipe(tanh._replace(law=tanh.law._replace(name="soft", fields=fields)))
    changes = {
        "joints.rod-slider.wear": {"law": "archard", "coefficient": 2e-14, "pressure": "even"},
        "joints.rod-slider.friction": {"law": "soft", "coefficient": 0.1},
    }
    joint = grid.load(slider_crank("rod-slider", changes=changes), simulation.catalogue()).case(0).joints[0]
    assert type(registry.compile_wear(joint).pressure) is mean.types[0]
    assert registry.compile_friction(joint) == (0.1, 2e-3)
