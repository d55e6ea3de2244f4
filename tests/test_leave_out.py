"""A scene costs only what is in it: compiled code, columns, histories, memory."""

import tracemalloc

import numpy as np
import pytest
from law_cases import RECIPES, joint
from mechanism_cases import slider_crank, told_both_ways
from test_every_transition import case_of as in_transition
from test_film import oiled
from test_roughness import rough

import clearsweep
from clearsweep import simulation
from clearsweep.mechanics.coupling import entries
from clearsweep.simulation import solve
from clearsweep.simulation.running.run import integration_of
from clearsweep.tracing import objects
from clearsweep.tracing.compiled import family

pytestmark = pytest.mark.heavy

FRICTION = {"law": "tanh", "coefficient": 0.1, "velocity_scale": 1e-3}
WEAR = {"law": "archard", "coefficient": 2e-14}


def scene(**changes):
    return clearsweep.load_case(
        slider_crank("rod-slider", changes={k.replace("__", "."): v for k, v in changes.items()})
    )


def code_of(made):
    """Return the compiled code of the right-hand side of a scene, as text."""
    return str(objects.trace_scene(entries.rates_entry, made.value, "fifff").module)


def test_a_frictionless_scene_compiles_no_friction():
    name = "joints.rod-slider.friction"
    with_friction = code_of(clearsweep.load_case(slider_crank("rod-slider", changes={name: FRICTION})))
    without = code_of(scene())
    assert '@"tanh' in with_friction
    assert '@"tanh' not in without
    assert len(without) < len(with_friction)


def test_a_law_compiles_itself_alone():
    spring = {"law": "kelvin-voigt", "stiffness": 1e8, "damping": 100.0}
    damper = code_of(clearsweep.load_case(slider_crank("rod-slider", changes={"joints.rod-slider.contact": spring})))
    general = code_of(scene(**{"joints__rod-slider__contact__exponent": 1.3}))
    assert '@"pow' in general
    assert '@"pow' not in damper
    assert '@"pow' not in code_of(scene())  # exponent 1.5 is a square root


def test_only_a_scene_with_wear_has_code_columns_and_arrays_for_it():
    worn = clearsweep.load_case(slider_crank("rod-slider", changes={"joints.rod-slider.wear": WEAR}))
    bare = scene()
    assert any("wear" in column.name for column in worn.layout.columns)
    assert not any("wear" in column.name for column in bare.layout.columns)
    end = 1e-5
    run = integration_of(bare, np.empty(0), end)
    assert run.work.wear == family.NO_ENTRY
    assert run.work.sample == family.NO_ENTRY
    assert run.totals.wear.size == 0
    assert clearsweep.simulate(bare).wear == {}


def test_without_orbits_a_sweep_keeps_no_history_and_no_events():
    trajectory = solve(scene(save__orbits="none").case)
    assert trajectory.channels == {}
    assert trajectory.events.size == 0
    assert trajectory.summary["rod_slider_impacts_per_rev"] > 5


def test_memory_does_not_grow_with_the_length_of_a_run_without_orbits():
    def most(**changes):
        made = scene(save__orbits="none", simulate__tolerance=1e-6, **changes)
        clearsweep.simulate(made, events=False)
        tracemalloc.start()
        clearsweep.simulate(made, events=False)
        _, peak = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        return peak

    assert most(simulate__revolutions=20) < 1.05 * most(simulate__revolutions=1) + 10_000


@pytest.mark.parametrize("joints", ["rod-slider", "crank-rod"])
def test_one_open_joint_integrates_two_coordinates(joints):
    made = clearsweep.load_case(slider_crank(joints))
    assert len(made.value.coordinates) == 2


#: Programs that leave a trajectory `t`, and how closely its figures and what else is printed of it are to agree.
BOTH_WAYS = {
    "wear": (
        "from test_leave_out import WEAR, scene; t = clearsweep.simulate(scene(simulate__revolutions=0.1, "
        "simulate__tolerance=1e-7, save__orbits='all', save__revolutions=0.1, **{'joints__rod-slider__wear': WEAR}))",
        dict.fromkeys(("rod_slider_force_peak", "rod_slider_force_p99", "rod_slider_wear_volume", "steps"), 1e-7)
        | {"t['slider/x'][-1]": 1e-7},
    ),
    "friction that remembers": (
        "from test_friction_memory import LUGRE, crank; "
        "t = clearsweep.simulate(crank(LUGRE, simulate__revolutions=0.03, simulate__tolerance=1e-6))",
        dict.fromkeys(("rod_slider_force_peak", "steps", "crank_torque_peak"), 1e-9),
    ),
    "contact that yields": (
        "from test_plastic_law import crank; t = crank(simulate__revolutions=0.03, simulate__tolerance=1e-6)",
        dict.fromkeys(("rod_slider_force_peak", "steps", "rod_slider_force_rms"), 1e-9),
    ),
    "surfaces that stick": (  # rounding decides at which sweep an iteration ends
        "from test_karnopp import crank; t = clearsweep.simulate("
        "crank('crank-rod', 'rod-slider', simulate__revolutions=0.02, simulate__tolerance=1e-8))",
        {"rod_slider_force_peak": 1e-7, "steps": 0.05, "crank_torque_peak": 1e-7},
    ),
    "spread walls": (
        "from spatial_cases import spatial; rubs = {'law': 'tanh', 'coefficient': 0.1, 'velocity_scale': 1e-2}; "
        "case = spatial(walls='spread', tilt=[0.004, 0.003], friction=rubs); "
        "case['simulate'] |= {'revolutions': 0.04, 'tolerance': 1e-9}; "
        "t = clearsweep.simulate(clearsweep.load_case(case), times=[0.001, 0.002])",
        {f"t['{name}'][{k}]": 1e-6 for name in ("slider/a", "joints/crank_rod/force_normal_1") for k in (0, 1)}
        | {"len(t.events)": 0.0},
    ),
}


@pytest.mark.few("wear")
@pytest.mark.compiled
@pytest.mark.parametrize("name", BOTH_WAYS)
def test_the_same_program_runs_uncompiled(name):
    """With the compiler off the same code runs as plain Python and gives the same motion."""
    program, closely = BOTH_WAYS[name]
    printed = ", ".join(what if "t[" in what or "(" in what else f"t.summary['{what}']" for what in closely)
    compiled, plain = told_both_ways(f"{program}\nprint(t.status, {printed})")
    for first, other, tolerance in zip(compiled, plain, closely.values(), strict=True):
        assert first == pytest.approx(other, rel=tolerance, abs=0.0)


# Every scene is vectorised: with any law the stages of a step can be traced in the lanes of a register.


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
