"""The equations of motion written anew for the speed comparison, against the compiled ones."""

import copy
import json

import numpy as np
import pytest
from bench import against, compiled, efficiency, ensemble, mechanics, parts, speed, stepwise

from clearsweep import grid
from clearsweep.mechanics.laws.contract import FREE, PRESSED
from clearsweep.simulation import catalogue
from clearsweep.verify.accuracy import all_problems, scene_of
from clearsweep.verify.rivals import DEPTH_COLUMN, JOINT_WIDTH, NORMAL_COLUMN, RATE_COLUMN, CountedRates

pytestmark = pytest.mark.heavy

PROBLEMS = {problem.name: problem for problem in all_problems() if problem.name in speed.NAMES}


def near(problem, draw):
    """Return a time and a state near one of the reference trajectory, in or out of contact."""
    row, half = draw.integers(len(problem.samples)), problem.samples.shape[1] // 2
    state = problem.samples[row].copy()
    state[:half] += draw.normal(0.0, 1e-3, half)
    state[half:] += draw.normal(0.0, 1.0, half)
    return problem.times[row], state


@pytest.mark.few("b_grav_fric-True", "ab_base-False")
@pytest.mark.parametrize("pressed", [True, False])
@pytest.mark.parametrize("name", speed.NAMES)
def test_accelerations_gaps_and_forces_are_those_of_the_kernels(name, pressed):
    problem, draw = PROBLEMS[name], np.random.default_rng(3)
    scene = scene_of(problem, 1e-9)
    joints, model = len(scene.value.joints), mechanics.MODELS[tuple(problem.grid["joints"])]
    evaluate, n = CountedRates(scene.value), model.size
    evaluate.state[:], evaluate.onset[:] = PRESSED if pressed else FREE, draw.uniform(0.5, 2.0, joints)
    record = mechanics.parameters(scene)
    record["state"][0, :joints] = mechanics.PRESSED if pressed else mechanics.FREE
    record["onset"][0, :joints] = evaluate.onset
    unit, du = mechanics.units(record, model), np.empty(n)
    forces = 0
    for _ in range(200):
        t, y = near(problem, draw)
        ours = evaluate(t, y)
        model.rates(t, y / unit, du, record[0])
        assert du * unit == pytest.approx(ours[:n], rel=1e-9, abs=1e-9 * np.abs(ours[:n]).max())
        seen = ours[n + 1 :].reshape(joints, JOINT_WIDTH)
        for place, result in ((DEPTH_COLUMN, "depth"), (RATE_COLUMN, "closing_rate"), (NORMAL_COLUMN, "force")):
            scale = np.abs(seen[:, place]).max()
            assert record[result][0, :joints] == pytest.approx(seen[:, place], rel=1e-9, abs=1e-9 * scale)
        depths = record["depth"].copy()
        model.depths(t, y / unit, record[0])
        assert record["depth"] == pytest.approx(depths, abs=1e-14)
        forces += int(np.any(seen[:, NORMAL_COLUMN] > 0.0))
    assert (forces > 20) == pressed


@pytest.mark.slow
def test_scipy_stepped_from_event_to_event_follows_the_reference():
    problem = PROBLEMS["b_base"]
    verdict = problem.assess(stepwise.solve(problem, 1e-11))
    assert verdict.events_exact
    assert verdict.error_first_half < 1e-6


def row(method, error, time):
    """Return a row of the table that ends up in results/speed.md."""
    return {"method": method, "error_first_half": error, "ms_per_revolution": time}


def test_the_least_time_for_an_error_is_that_of_any_tolerance_that_errs_no_more():
    entry = {"rows": [row("m", *pair) for pair in ((1e-4, 1.0), (1e-8, 2.0), (1e-6, 3.0), (1e-10, 4.0), (None, 0.1))]}
    times = [speed.least_time(entry, "m", error) for error in (1e-4, 1e-5, 1e-6, 1e-8, 9e-9, 1e-11)]
    assert times == [1.0, 2.0, 2.0, 2.0, 4.0, None]


def test_a_ratio_is_the_mean_over_all_errors_and_says_whether_what_was_asked_is_met():
    times = {speed.OURS: 1.0, speed.SODA: 3.0, speed.SCIPY: 140.0, "heyoka": 5.0}
    rows = [
        row(method, error, np.float64(factor * time))
        for method, time in times.items()
        for error, factor in ((1e-6, 1.0), (1e-10, 2.0 if method == speed.OURS else 4.0))
        if (method, error) != ("heyoka", 1e-10)
    ]
    result = {ratio["method"]: ratio for ratio in speed.ratios({"name": "b_base", "rows": rows})}
    assert result[speed.SODA]["each"] == [3.0, *[6.0] * 8]
    assert result[speed.SODA]["over_ours"] == pytest.approx(3.0 * 2.0 ** (8.0 / 9.0))
    assert [result[name]["met"] for name in (speed.SODA, speed.SCIPY, "heyoka")] == [True, True, None]
    assert result["heyoka"]["over_ours"] == pytest.approx(5.0)  # it errs by less nowhere: one error counts
    assert json.loads(json.dumps(result, allow_nan=False)) == result


def test_a_time_at_an_error_lies_on_log_log_lines():
    points = [(1e-6, 1.0), (1e-10, 16.0), (1e-8, 4.0)]
    assert ensemble.at_error(1e-7, points) == pytest.approx(2.0)
    assert ensemble.at_error(1e-9, points) == pytest.approx(8.0)
    assert ensemble.at_error(1e-11, points) is None


def test_parts_are_added_to_every_joint_of_a_copy():
    source = PROBLEMS["ab_base"].grid
    before = copy.deepcopy(source)
    case = grid.load(parts.changed(source, parts.WEAR | {"JOINTS.wear.bins": 90}), catalogue()).case(0)
    assert [joint.wear.bins for joint in case.joints] == [90, 90]
    assert source == before


@pytest.mark.parametrize("pair", parts.PAIRS, ids=lambda pair: pair.name)
def test_a_part_is_one_that_a_grid_may_ask_for(pair):
    assert len(grid.load(parts.changed(PROBLEMS[pair.problem].grid, pair.changes), catalogue())) == 1


def test_commits_are_compared_on_grids_that_can_be_read():
    counts = {name: len(grid.load(source, catalogue())) for name, source in against.grids().items()}
    assert counts == {"thousand_cases": 1000, "with friction": 400, "with two joints": 400}
    assert set(counts) == set(against.ASKED)


def test_two_workers_share_cases_of_every_length_requested():
    for length, count in efficiency.LENGTHS.items():
        assert len(grid.load(efficiency.grid(2, count), catalogue())) == count
        assert 0.0 < efficiency.ASKED[length] < 1.0


@pytest.mark.slow  # numba compiles both models
@pytest.mark.parametrize("name", speed.NAMES)
def test_a_solver_by_hand_has_the_events_of_quadruple_precision(name):
    errors = [PROBLEMS[name].assess(compiled.solve(PROBLEMS[name], tolerance)) for tolerance in (1e-8, 1e-11)]
    assert all(error.events_exact for error in errors)
    assert errors[0].error_first_half < 1e-4
    assert errors[1].error_first_half < 1e-2 * errors[0].error_first_half + 1e-9
