"""The equations of motion written anew for the speed comparison, against the compiled ones."""

import json

import numpy as np
import pytest
from bench import mechanics, speed

from clearsweep.mechanics.compiled.family import flatten
from clearsweep.mechanics.joint.dry import FREE, PRESSED
from clearsweep.verify.problems import problems, scene_of
from clearsweep.verify.rivals import DEPTH, JOINT_WIDTH, NORMAL, RATE, ROWS, rates_of
from clearsweep.verify.rivals import _evaluate as evaluate

pytestmark = pytest.mark.heavy

PROBLEMS = {problem.name: problem for problem in problems() if problem.name in speed.NAMES}


def near(problem, draw):
    """Return a time and a state near one of the reference trajectory, in or out of contact."""
    row, half = draw.integers(len(problem.samples)), problem.samples.shape[1] // 2
    state = problem.samples[row].copy()
    state[:half] += draw.normal(0.0, 1e-3, half)
    state[half:] += draw.normal(0.0, 1.0, half)
    return problem.times[row], state


@pytest.mark.parametrize("pressed", [True, False])
@pytest.mark.parametrize("name", speed.NAMES)
def test_accelerations_gaps_and_forces_are_those_of_the_kernels(name, pressed):
    problem, draw = PROBLEMS[name], np.random.default_rng(3)
    scene = scene_of(problem, 1e-9)
    joints, model = len(scene.value.joints), mechanics.MODELS[tuple(problem.grid["joints"])]
    numbers = flatten(scene.value)
    entry, n = rates_of(scene.value, numbers), model.size
    state, onset = np.full(joints, PRESSED if pressed else FREE), draw.uniform(0.5, 2.0, joints)
    record = mechanics.parameters(scene)
    record["state"][0, :joints] = mechanics.PRESSED if pressed else mechanics.FREE
    record["onset"][0, :joints] = onset
    unit, k, du = mechanics.units(record, model), np.zeros((ROWS, n + 1 + JOINT_WIDTH * joints)), np.empty(n)
    forces = 0
    for _ in range(200):
        t, y = near(problem, draw)
        ours = evaluate(entry, t, y, np.empty(n + 1), state, onset, k)
        model.rates(t, y / unit, du, record[0])
        assert du * unit == pytest.approx(ours[:n], rel=1e-9, abs=1e-9 * np.abs(ours[:n]).max())
        seen = ours[n + 1 :].reshape(joints, JOINT_WIDTH)
        for place, found in ((DEPTH, "depth"), (RATE, "closing"), (NORMAL, "force")):
            scale = np.abs(seen[:, place]).max()
            assert record[found][0, :joints] == pytest.approx(seen[:, place], rel=1e-9, abs=1e-9 * scale)
        depths = record["depth"].copy()
        model.depths(t, y / unit, record[0])
        assert record["depth"] == pytest.approx(depths, abs=1e-14)
        forces += int(np.any(seen[:, NORMAL] > 0.0))
    assert (forces > 20) == pressed


def test_errors_out_of_order_are_pooled():
    rows = [
        {"method": "m", "error_first_half": e, "ms_per_revolution": t}
        for e, t in ((1e-4, 1.0), (1e-8, 2.0), (1e-6, 3.0), (1e-10, 4.0))
    ]
    pooled = [row["error_first_half"] for row in speed.in_order({"rows": rows}, "m")["rows"]]
    assert pooled == pytest.approx([1e-4, 1e-7, 1e-7, 1e-10], rel=1e-12, abs=0.0)
    assert speed.time_of({"rows": rows}, "m", 1e-5) == pytest.approx(2.0 ** (1.0 / 3.0))


def test_a_ratio_says_whether_what_was_asked_is_met():
    times = {speed.OURS: 1.0, speed.SODA: 3.0, speed.SCIPY: 250.0}
    rows = [
        {"method": method, "error_first_half": error, "ms_per_revolution": np.float64(factor * time)}
        for method, time in times.items()
        for error, factor in ((1e-6, 0.5), (1e-10, 2.0))
    ]
    found = {ratio["method"]: ratio for ratio in speed.ratios({"name": "b_base", "rows": rows})}
    assert found[speed.SODA]["over_ours"] == pytest.approx(3.0)
    assert found[speed.SODA]["met"] is False
    assert found[speed.SCIPY]["met"] is True
    assert found[speed.OURS]["met"] is None
    assert json.loads(json.dumps(found, allow_nan=False)) == found
