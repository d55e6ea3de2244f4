"""The code of a machine contains what its motion needs: loops that only follow the crank cost a sweep nothing."""

import copy
import math
from collections import Counter

import pytest
from mechanism_cases import JOINT

import clearsweep
from clearsweep.mechanics.coupling import entries, rates
from clearsweep.tracing import objects

ROD = {"mass": 0.21, "inertia": 2.5e-4, "center": [0.06, 0], "points": {"big": [0, 0], "small": [0.12, 0]}}
PISTON = {"mass": 0.14, "inertia": 1e-4, "points": {"pin": [0, 0]}}
CRANK = {"mass": 0.3, "inertia": 1e-4, "center": [0.025, 0], "points": {"pivot": [0, 0], "pin": [0.05, 0]}}
LOADS = {
    "nothing": {},
    "gas": {"table": "configs/engine_gas.csv"},
    "a spring": {"anchor": ["300 mm", 0], "stiffness": "2 kN/m"},
    "a constant force": {"force": [3.0, 1.0]},
}
ENTRIES = {  # of a run: function and kinds of its arrays
    "sweep": (entries.sweep_entry, "fifffff"),
    "rates": (entries.rates_entry, "fifff"),
    "observables": (entries.observe_entry, "fiff"),
    "time histories": (rates.sample_entry, "fifff"),
}


def engine(cylinders, load="nothing"):
    """Return the grid of a radial engine with clearance in its first small end, and a load on every piston."""
    bodies = {"ground": {"points": {"main": [0, 0]}}, "crank": CRANK}
    joints = {"main": {"type": "revolute", "between": ["ground.main", "crank.pivot"]}}
    start, loads = {}, {}
    for i in range(cylinders):
        angle = 2.0 * math.pi * i / cylinders
        bodies[f"rod{i}"], bodies[f"piston{i}"] = copy.deepcopy((ROD, PISTON))
        joints[f"big{i}"] = {"type": "revolute", "between": ["crank.pin", f"rod{i}.big"]}
        joints[f"small{i}"] = {"type": "revolute", "between": [f"rod{i}.small", f"piston{i}.pin"]}
        joints[f"bore{i}"] = {"type": "prismatic", "between": ["ground.main", f"piston{i}.pin"], "axis": angle}
        start[f"rod{i}"] = angle + math.asin(0.05 / 0.12 * math.sin(angle))
        ends = {"between": ["ground", f"piston{i}"]} if load == "a spring" else {"on": f"piston{i}"}
        loads |= {f"load{i}": ends | LOADS[load]} if LOADS[load] else {}
    output = {"body": "piston0", "point": "pin", "along": 0.0}
    return {
        "mechanism": {
            "type": "planar", "bodies": bodies, "joints": joints, "driven": "main", "start": start, "output": output
        },
        "drive": {"speed": "2000 rpm"},
        "loads": loads,
        "joints": {"small0": copy.deepcopy(JOINT)},
    }  # fmt: skip


def code_of(source, entry):
    """Return the LLVM code of an entry of a grid's scene, as it was traced."""
    function, items = ENTRIES[entry]
    return str(objects.trace_scene(function, clearsweep.load_case(source).value, items).module)


def instructions_of(code):
    """Return the kinds of the instructions of optimised code."""
    functions = objects.optimise(code).functions
    return [str(each.opcode) for function in functions for block in function.blocks for each in block.instructions]


@pytest.mark.few("nothing")
@pytest.mark.parametrize("load", ["nothing", "gas", "a spring", "a constant force"])
def test_a_sweep_of_an_engine_contains_its_open_cylinder_alone(load):
    single, three = (instructions_of(code_of(engine(cylinders, load), "sweep")) for cylinders in (1, 3))
    assert Counter(three) == Counter(single)


@pytest.mark.slow
def test_code_grows_with_the_bodies_of_a_machine_and_no_faster():
    """From 8 to 26 bodies, as traced and as optimised."""
    written, compiled = [], []
    for cylinders in (3, 12):
        codes = [code_of(engine(cylinders), entry) for entry in ENTRIES]
        written.append(sum(code.count("\n") for code in codes))
        compiled.append(sum(len(instructions_of(code)) for code in codes))
    for small, large in (written, compiled):
        assert math.log(large / small) / math.log(26 / 8) <= 1.15
