"""The integrator against trajectories in quadruple precision and closed forms, and the rivals it is measured by."""

import json
import math

import numpy as np
import pytest

from clearsweep import simulate, verify
from clearsweep.mechanics.solver.integration import ONSET, SEPARATION
from clearsweep.verify import accuracy, comparisons, stability, text
from clearsweep.verify.accuracy import all_problems, restitution_of, scene_of, solution_of
from clearsweep.verify.rivals import runge_kutta_4, scipy_ivp

pytestmark = pytest.mark.heavy

PROBLEMS = {problem.name: problem for problem in all_problems()}
TRAJECTORIES = [name for name in PROBLEMS if name not in ("impact_pair", "b_damped")]
STEPS = [1e-6 / 1.1**k for k in range(12)] + [1e-7 / 1.1**k for k in range(12)]  # s


def verdict_of(name, tolerance):
    """Return the Verdict on our own solution of a problem."""
    problem = PROBLEMS[name]
    times = problem.times if len(problem.times) else [0.0]
    return problem.assess(solution_of(problem, simulate(scene_of(problem, tolerance), times=times)))


def test_references_hold_five_trajectories_with_one_and_two_open_joints():
    assert TRAJECTORIES == ["b_base", "b_grav_fric", "a_base", "ab_base", "b_stiff"]
    assert {name: len(PROBLEMS[name].events) for name in TRAJECTORIES} == {
        "b_base": 56,
        "b_grav_fric": 19,
        "a_base": 25,
        "ab_base": 60,
        "b_stiff": 48,
    }


@pytest.mark.parametrize("name", TRAJECTORIES)
def test_tight_tolerance_follows_the_reference_to_the_end(name):
    verdict = verdict_of(name, 1e-12)
    assert verdict.error_whole <= 1e-6
    assert verdict.events_exact
    assert verdict.peak_error_first_half <= 1e-6


@pytest.mark.parametrize("name", TRAJECTORIES)
def test_usual_tolerance_follows_the_reference_through_the_first_half(name):
    verdict = verdict_of(name, 1e-9)
    assert verdict.error_first_half <= 1e-6
    assert verdict.events_exact


@pytest.mark.parametrize("name", TRAJECTORIES)
def test_event_times_and_rates_are_those_of_the_reference(name):
    problem = PROBLEMS[name]
    result = solution_of(problem, simulate(scene_of(problem, 1e-12), times=problem.times)).events
    assert result[:, 0] == pytest.approx(problem.events[:, 0], abs=1e-6 * problem.end)
    assert result[:, 3] == pytest.approx(problem.events[:, 3], abs=1e-6)


def test_error_falls_with_the_tolerance():
    tolerances = (1e-4, 1e-6, 1e-8, 1e-10)
    errors = [verdict_of("a_base", tolerance).error_first_half for tolerance in tolerances]
    assert all(error < 10.0 * tolerance for error, tolerance in zip(errors, tolerances, strict=True))
    assert errors[3] < 1e-4 * errors[0]


def test_impact_pair_returns_the_closed_form():
    assert verdict_of("impact_pair", 1e-12).error_whole <= 1e-9
    assert verdict_of("impact_pair", 1e-12).events_exact


@pytest.mark.parametrize(("factor", "ratio"), [(0.1425, 0.91317668), (1.0, 0.59362426), (10.0, 0.09998162)])
def test_closed_form_of_restitution_gives_known_values(factor, ratio):
    assert restitution_of(factor) == pytest.approx(ratio, abs=1e-8)
    chi, e = factor, restitution_of(factor)
    assert chi * e + math.log1p(-chi * e) == pytest.approx(-(chi - math.log1p(chi)), rel=1e-9)


def test_fixed_step_without_event_location_is_of_first_order():
    """An onset is found late by any part of a step: the error, averaged over steps close by, falls like the step."""
    problem = PROBLEMS["b_grav_fric"]
    scene = scene_of(problem, 1e-9)
    errors = [problem.assess(runge_kutta_4(scene, problem.times, step)).error_first_half for step in STEPS]
    order = np.polyfit(np.log(STEPS), np.log(errors), 1)[0]
    assert 0.75 < order < 1.25
    assert np.all(np.array(errors) > 1e-5)  # far from what the same force law gives with located events


def test_fixed_step_is_of_fourth_order_in_free_flight():
    problem = PROBLEMS["b_base"]
    scene = scene_of(problem, 1e-13)
    times = np.array([0.5, 1.0]) * 0.9 * problem.events[0, 0]  # before the first onset
    exact = runge_kutta_4(scene, times, times[0] / 4000).states[-1]
    coarse, fine = (np.abs(runge_kutta_4(scene, times, times[0] / n).states[-1] - exact).max() for n in (1, 2))
    assert 12.0 < coarse / fine < 20.0


@pytest.mark.few("b_grav_fric")
@pytest.mark.parametrize("name", ["b_base", "b_grav_fric", "ab_base"])
def test_scipy_on_the_same_laws_agrees_with_the_reference_and_with_ours(name):
    problem = PROBLEMS[name]
    result = scipy_ivp(scene_of(problem, 1e-9), problem.times, problem.end, 1e-12)
    verdict = problem.assess(result)
    assert verdict.error_first_half < 1e-7
    assert verdict.events_exact
    ours = solution_of(problem, simulate(scene_of(problem, 1e-12), times=problem.times))
    assert np.max(np.abs(result.states - ours.states) / problem.scales) < 1e-5
    assert result.events[:, 3] == pytest.approx(ours.events[:, 3], abs=1e-4)


def test_rivals_return_the_closed_form_of_the_impact_pair():
    problem = PROBLEMS["impact_pair"]
    scene = scene_of(problem, 1e-9)
    located = problem.assess(scipy_ivp(scene, (), problem.end, 1e-12, problem.separations))
    stepped = problem.assess(runge_kutta_4(scene, (), 1e-7, problem.separations))
    assert located.events_exact
    assert located.error_whole < 1e-9
    assert stepped.events_exact
    assert stepped.error_whole < 1e-5


def test_verdict_sees_a_missing_event_and_a_wrong_order():
    problem = PROBLEMS["ab_base"]
    result = solution_of(problem, simulate(scene_of(problem, 1e-9), times=problem.times))
    assert problem.assess(result).events_exact
    assert not problem.assess(result._replace(events=result.events[:-1])).events_exact
    swapped = result.events[[1, 0, *range(2, len(result.events))]]
    assert not problem.assess(result._replace(events=swapped)).events_exact
    assert {ONSET, SEPARATION} == set(result.events[:, 2])


@pytest.fixture(scope="module")
def results():
    """Return what two problems give, at few settings and in one round, and stiff cases of one compiled form."""
    one_joint = [case for case in comparisons.stiff_cases() if case.name.startswith(("damping/C", "stiffness/C"))]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(accuracy, "all_problems", lambda: [PROBLEMS["b_base"], PROBLEMS["impact_pair"]])
        patch.setattr(accuracy, "QUICK_STEPS", (1e-5, 1e-6))
        patch.setattr(accuracy, "QUICK_ROUNDS", 1)
        patch.setattr(comparisons, "QUICK_LENGTHS", (10, 20))
        patch.setattr(stability, "QUICK_CASES", 4)
        patch.setattr(comparisons, "stiff_cases", lambda: one_joint)
        return verify.measure(quick=True)


@pytest.mark.slow
def test_results_survive_json_and_are_complete(results):
    read = json.loads(json.dumps(results, allow_nan=False))
    assert read["version"]
    assert read["date"]
    assert {"processor", "python", "llvmlite", "scipy"} <= set(read["machine"])
    for entry in read["problems"]:
        assert {row["method"] for row in entry["rows"]} == {method.name for method in accuracy.all_methods(quick=True)}
        for row in entry["rows"]:
            assert ("tolerance" in row) != ("step" in row)
            assert row["ms_per_revolution"] > 0.0
            assert row["rhs_evaluations"] > row["steps"] > 0
    figures = read["headline"]
    assert figures["ratio_at_equal_tolerance"] == figures["scipy_ms_per_revolution"] / figures["ms_per_revolution"]
    assert figures["error_first_half"] <= 1e-6


@pytest.mark.slow
def test_quick_measurement_judges_every_stiff_case():
    result = comparisons.measure_stiff(quick=True)
    assert [row["name"] for row in result["rows"]] == [case.name for case in comparisons.stiff_cases()]
    assert {row["name"] for row in result["choices"]} == {case.name for case in comparisons.stiff_cases()}


@pytest.mark.slow
def test_table_is_narrow_and_has_a_line_for_every_row(results):
    lines = text.results_text(results).splitlines()
    assert sum("tolerance 1e-06" in line for line in lines) == 12
    assert all(len(line) <= 132 for line in lines)
    assert any(line.startswith("b_base at tolerance 1e-09") for line in lines)


def test_a_machine_may_be_without_events():
    nothing, moments = np.empty(0), np.array([1e-3, 2e-3])
    assert comparisons.event_error(nothing, nothing) == 0.0
    assert comparisons.event_error(moments, np.array([1.000001e-3, 1.999997e-3])) == pytest.approx(3e-9, rel=1e-6)


@pytest.mark.slow
def test_statistics_come_with_an_interval_for_every_tolerance_and_length(results):
    rows = results["convergence"]["rows"]
    assert [(row["revolutions"], row["tolerance"]) for row in rows] == [
        (length, tolerance) for tolerance in comparisons.QUICK_AVERAGE_TOLERANCES for length in (10, 20)
    ]
    assert all(row[figure]["half_width"] > 0.0 for row in rows for figure in comparisons.FIGURES)
    assert all(row[figure]["blocks"] == row["revolutions"] for row in rows for figure in comparisons.FIGURES)
    lines = text.results_text(results).splitlines()
    first = next(line for line in lines if line.split()[:2] == ["10", "1e-06"])
    assert f"{rows[0]['rod_slider_force_rms']['value']:.0f} +- " in first


@pytest.mark.slow
def test_statistics_agree_between_tolerances_and_narrow_with_the_length_of_the_run():
    rows = [row for tolerance in (1e-6, 1e-9) for row in comparisons.run_at_tolerance(tolerance, (30, 300))]
    for figure in comparisons.FIGURES:
        short, long, _, other = (row[figure] for row in rows)
        assert long["half_width"] < 0.7 * short["half_width"]
        apart = abs(long["value"] - other["value"])
        assert apart < 1.5 * math.hypot(long["half_width"], other["half_width"])  # 3 standard errors


@pytest.mark.slow
def test_main_prints_text_or_json(results, monkeypatch, capsys):
    monkeypatch.setattr(verify, "measure", lambda quick, report_progress: results)
    verify.main(json=True, quick=True)
    assert json.loads(capsys.readouterr().out)["headline"]["problem"] == "b_base"
    verify.main(json=False, quick=True)
    assert "b_base: rod-slider" in capsys.readouterr().out


def test_time_at_equal_error_lies_between_the_settings():
    rows = [{"method": "m", "error_first_half": e, "ms_per_revolution": t} for e, t in ((1e-2, 10.0), (1e-6, 1000.0))]
    assert accuracy.time_at_error({"rows": rows}, "m", 1e-4) == pytest.approx(100.0)
    assert accuracy.time_at_error({"rows": rows}, "m", 1e-8) is None


@pytest.mark.slow
@pytest.mark.parametrize("ending", ["svg", "png"])
def test_figure_is_written(results, tmp_path, ending):
    path = verify.draw(results, tmp_path / f"error.{ending}")
    assert path.stat().st_size > 10_000


@pytest.mark.slow
def test_the_stiff_problem_has_the_same_answer_by_methods_of_others():
    problem = PROBLEMS["b_damped"]
    for method, tolerance, error in (("DOP853", 1e-6, 1e-6), ("Radau", 1e-8, 1e-8), ("LSODA", 1e-8, 1e-6)):
        scene = scene_of(problem, 1e-9)
        verdict = problem.assess(scipy_ivp(scene, problem.times, problem.end, tolerance, method=method))
        assert verdict.events_exact
        assert verdict.error_whole < error


def test_each_method_solves_the_stiff_problem_the_implicit_one_cheapest():
    problem, spent = PROBLEMS["b_damped"], {}
    for method in ("auto", "explicit", "implicit"):
        result = solution_of(problem, simulate(scene_of(problem, 1e-6, method), times=problem.times))
        assert problem.assess(result).error_whole < 1e-5
        spent[method] = result.evaluations
    assert spent["implicit"] < 0.6 * spent["explicit"]
    assert spent["auto"] <= spent["explicit"] < 8_000  # with plain sweeps the explicit method takes 13,767 steps


@pytest.mark.slow
def test_the_report_is_written_with_its_figure(results, tmp_path):
    page = verify.write(results, tmp_path).read_text(encoding="utf-8")
    assert (tmp_path / "accuracy" / "error.svg").stat().st_size > 10_000
    assert "accuracy/error.svg" in page
    assert results["date"] in page
    for row in results["stability"]["rows"]:
        assert f"| {row['name']} | ok |" in page
