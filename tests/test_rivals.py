"""The equations of motion written anew for the speed comparison, against the compiled ones."""

import copy
import json
import re
from pathlib import Path
from typing import NamedTuple

import numpy as np
import published_machines as machines
import published_mechanisms as mechanisms
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


# ---------------------------------------------------------------------------------------------- published machines


CASES = {
    "forced oscillator with friction": machines.den_hartog,
    "block on a belt": machines.belt,
    "free oscillator with friction": machines.siconos_oscillator,
    "mass on a linear floor": machines.exudyn_floors,
    "bouncing ball": machines.bouncing_ball,
    "ball between spring and roof": machines.compliant_ball,
    "stick that falls on its end": machines.impacting_stick,
    "chain of tapered balls": machines.chains,
    "rocking block": machines.housner,
    "ball on a vibrating table": machines.bouncing_on_a_table,
    "body that slides until it rolls": mechanisms.sliding_to_rolling,
    "friction circle": mechanisms.friction_circle,
    "squeeze film": mechanisms.squeeze,
    "squeeze film of finite length": mechanisms.squeeze_of_finite_length,
    "pendulum": mechanisms.adams_pendulum,
    "mass on a spring": mechanisms.adams_springs,
    "slider-crank under a torque": mechanisms.slider_crank_under_torque,
    "N-four-bar": mechanisms.n_four_bar,
    "block in its guide": mechanisms.block_in_guide,
}
PAGE = (Path(__file__).parents[1] / "docs/published.md").read_text(encoding="utf-8")


class Claim(NamedTuple):
    """A row of the page: of several values it prints the last, and the tolerance is that of all."""

    machine: str
    source: str
    quantity: str
    reference: float
    computed: float
    tolerance: float


def table(heading, columns):
    """Return the rows of the first table below a heading of the page that has that many columns."""
    rows = re.findall(rf"^\|{' ([^|]+) [|]' * columns}$", PAGE.split(f"## {heading}\n")[1].split("\n## ")[0], re.M)
    return rows[2:]


CLAIMS = [Claim(*row[:3], *map(float, row[3:])) for row in table("Machines with a known solution", 6)]


def test_every_machine_of_the_table_is_run():
    assert {claim.machine for claim in CLAIMS} == set(CASES)


@pytest.mark.few("friction circle", "mass on a spring", "pendulum", "squeeze film")
@pytest.mark.parametrize("name", CASES)
def test_a_machine_moves_as_its_reference_and_as_the_page_says(name):
    claims, values = [claim for claim in CLAIMS if claim.machine == name], CASES[name]()
    assert [claim.quantity for claim in claims] == list(values)
    for claim in claims:
        reference, computed = map(np.atleast_1d, values[claim.quantity])
        assert computed == pytest.approx(reference, abs=claim.tolerance, rel=0.0), claim.quantity
        printed = (claim.reference, claim.computed)
        assert printed == pytest.approx((reference[-1], computed[-1]), abs=claim.tolerance, rel=1e-6)


# ---------------------------------------------------------------------------------------------- steps of other programs


def errors(column):
    """Return step (s) -> error of a time stepper, as the page prints them; those of the programs come first."""
    rows = table("Where a program differs by its step", 4)
    return {float(row[0].split()[0]): float(row[column]) for row in rows if row[column] != "-"}


def test_siconos_oscillator_is_off_by_its_step():
    printed, times = machines.PRINTED["siconos_oscillator"]["x"], machines.PRINTED["siconos_oscillator"]["t"]
    assert machines.siconos_oscillator_steps(1e-2, times) == pytest.approx(printed, abs=1e-11)
    exact = machines.coulomb_oscillator(np.array(times))
    for step, error in errors(1).items():
        off = np.max(np.abs(machines.siconos_oscillator_steps(step, times) - exact))
        assert off == pytest.approx(error, rel=0.05), step


def test_siconos_ball_on_a_spring_is_off_by_its_step():
    printed, times = machines.PRINTED["siconos_ball"]["x"], np.array(machines.PRINTED["siconos_ball"]["t"])
    assert machines.siconos_ball_steps(5e-4, times) == pytest.approx(printed, abs=1e-11)
    exact = machines.ball_on_a_spring(times)
    for step, error in errors(2).items():
        off = np.max(np.abs(machines.siconos_ball_steps(step, times) - exact))
        assert off == pytest.approx(error, rel=0.05), step


def test_siconos_stick_follows_newton_s_law_with_the_friction_of_the_last_slip():
    """Its printed figures, at a step of 0.1 ms, are -0.50687 m/s and 3.21207 rad/s."""
    newton, exact = (machines.stick_after_impacts(law) for law in (machines.newton_rebound, machines.slide_and_rebound))
    assert newton["vx"] == pytest.approx(-0.50687, abs=2e-5)
    assert newton["rate"] == pytest.approx(3.21207, abs=6e-3)
    assert exact["vx"] - newton["vx"] == pytest.approx(6.4e-3, abs=1e-4)
    for law, gain in ((machines.newton_rebound, 7.08e-4), (machines.slide_and_rebound, -7.39e-4)):
        works = []

        def watched(u, w, coupling, friction, law=law, works=works):
            impulse = np.array(law(u, w, coupling, friction))
            works.append(impulse @ (np.array([u, w]) + 0.5 * coupling @ impulse))
            return impulse

        machines.stick_after_impacts(watched)
        assert works[0] == pytest.approx(gain, abs=1e-6)  # J: friction takes energy, and Newton's law adds more


@pytest.mark.slow
def test_moreau_s_rule_converges_to_the_motion_of_the_block():
    """The program's own value at 0.1 ms is 1.49164 revolutions; its scheme errs to the other side of ours."""
    (computed,) = [claim.computed for claim in CLAIMS if claim.quantity.startswith("revolutions of the crank")]
    for step, error in errors(3).items():
        off = abs(mechanisms.moreau_guide(step, [0.1])[0, 0] - computed)
        assert off == pytest.approx(error, rel=0.05), step


def print_rows():
    """Print the rows of today, with tolerances of the page where it has them."""
    known = {(claim.machine, claim.quantity): claim for claim in CLAIMS}
    for name, case in CASES.items():
        for quantity, pair in case().items():
            reference, computed = map(np.atleast_1d, pair)
            off = np.max(np.abs(computed - reference))
            claim = known.get((name, quantity))
            ends = (claim.source, f"{claim.tolerance:g}") if claim else ("", "")
            print(
                f"| {name} | {ends[0]} | {quantity} | {reference[-1]:.7g} | {computed[-1]:.7g} | {ends[1]} | {off:.1e}"
            )


if __name__ == "__main__":
    print_rows()
