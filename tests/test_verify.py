"""The integrator against trajectories in quadruple precision and closed forms, and the rivals it is measured by."""

import json
import math
from collections.abc import Iterable
from importlib import resources

import numpy as np
import pytest
from click.testing import CliRunner

from clearsweep import cli, grid, simulate, simulation, verify
from clearsweep.mechanics.solver.integration import ONSET, SEPARATION
from clearsweep.verify import accuracy, comparisons, measured, stability, text
from clearsweep.verify.accuracy import all_problems, restitution_of, scene_of, solution_of
from clearsweep.verify.measured import contact, films, machines, points
from clearsweep.verify.measured.points import KINDS, Row
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
    path = text.draw(results, tmp_path / f"error.{ending}")
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


# ---------------------------------------------------------------------------------------------- measured machines


KEYS = {"benchmark", "kind", "source", "point", "quantity", "unit", "reference", "computed", "difference"}
slow = pytest.mark.slow


def largest(rows: Iterable[Row], quantity: str, variant: str = "") -> float:
    """Return the largest difference of a quantity; there has to be one."""
    result = [abs(row.difference) for row in rows if (row.quantity, row.variant) == (quantity, variant)]
    assert result
    return max(result)


@pytest.mark.parametrize("name", ["oblique", "bar", "bushing", "spatial", "squeezer", "stick_slip", "rig", "whirl"])
def test_the_grid_of_a_benchmark_is_a_file_that_anybody_can_run(name):
    file = resources.files("clearsweep.verify") / "references" / "grids" / f"{name}.yaml"
    assert len(grid.load(str(file), simulation.catalogue())) == 1


def test_every_benchmark_says_what_it_compares_and_why_it_differs():
    assert all(len(benchmark.text) > 100 for benchmark in measured.BENCHMARKS)
    assert len({benchmark.text for benchmark in measured.BENCHMARKS}) == len(measured.BENCHMARKS)


def test_a_hertz_impact_is_as_deep_hard_and_long_as_the_closed_form():
    rows = contact.measure_hertz()
    assert len(rows) == 12
    assert all(row.computed == pytest.approx(row.reference, rel=5e-5) for row in rows)


def test_an_impact_on_a_chain_of_six_springs_is_that_on_the_continuous_bar():
    rows = contact.measure_bar()
    assert len(rows) == 6
    for row in rows:
        assert row.computed == pytest.approx(row.reference, rel=0.01), row


@pytest.mark.slow
def test_a_housing_settles_where_the_table_of_its_film_says():
    rows = films.measure_at_rest(quick=True)
    assert largest(rows, "eccentricity ratio", "reynolds") < 0.003
    assert largest(rows, "attitude", "reynolds") < 4.6
    assert largest(rows, "eccentricity ratio", "finite") < 0.01


@slow
def test_every_film_settles_where_both_tables_say_and_drags_as_tabulated():
    rows = films.measure_at_rest()
    published = [row for row in rows if row.kind == "published"]
    assert len({row.point for row in published}) >= 24
    assert largest(published, "eccentricity ratio", "reynolds") < 0.003
    assert largest(published, "attitude", "reynolds") < 4.6
    drag = [row for row in rows if row.quantity == "friction variable"]
    assert all(row.computed == pytest.approx(row.reference, rel=0.012) for row in drag)


def at(rows, quantity, variant, low, high):
    """Return the rows of a quantity and a law whose incidence lies between two angles (deg)."""
    result = [row for row in rows if (row.quantity, row.variant) == (quantity, variant)]
    return [row for row in result if low <= float(row.point.split()[1]) <= high]


@pytest.mark.slow
def test_a_ball_that_sticks_springs_back_with_bristles_and_stops_without():
    rows = contact.measure_oblique(quick=True)
    for row in at(rows, "tangential restitution", "tanh", 0.0, 30.0):
        assert row.computed == pytest.approx(5.0 / 7.0, abs=1e-3)
    bristles = at(rows, "tangential restitution", "dahl", 10.0, 25.0)
    assert [row.computed for row in bristles] == pytest.approx([row.reference for row in bristles], abs=0.04)


@slow
@pytest.mark.parametrize("law", contact.FRICTION_LAWS)
def test_every_friction_law_gives_the_measured_rebound_of_a_ball_that_slides(law, impacts):
    restitution = at(impacts, "tangential restitution", law, 30.0, 90.0)
    assert len(restitution) == 6
    assert [row.computed for row in restitution] == pytest.approx([row.reference for row in restitution], abs=0.025)
    spin = at(impacts, "rebound spin", law, 45.0, 90.0)
    assert [row.computed for row in spin] == pytest.approx([row.reference for row in spin], rel=0.06)


@slow
def test_bristles_alone_let_the_contact_point_of_a_ball_spring_back(impacts):
    for law in contact.FRICTION_LAWS:
        (back,) = at(impacts, "rebound angle of the contact point", law, 20.0, 21.0)
        springs = law in ("dahl", "lugre", "elasto-plastic")
        assert back.difference < 2.5 if springs else back.computed == pytest.approx(0.0, abs=0.1)


@pytest.mark.slow
def test_the_squeezer_ends_where_the_reference_of_its_fourteen_numbers_is():
    rows = machines.measure_squeezer(quick=True)
    assert len(rows) == 14
    assert largest(rows, "angle at 0.03 s", "all pins ideal") < 1e-8
    assert largest(rows, "rate at 0.03 s", "all pins ideal") < 5e-6


@pytest.mark.slow
def test_a_block_drawn_along_a_guide_sticks_and_slips_as_in_the_paper():
    """A guide takes laws with internal state: each corner that touches bends bristles of its own."""
    rows = machines.measure_stick_slip(quick=True)
    assert len(rows) == 14
    assert largest(rows, "place", "lugre") < 1e-6
    assert largest(rows, "bend of the bristles", "lugre") < 5e-12  # of 12 um
    assert largest(rows, "begins", "lugre") < 2e-4
    assert largest(rows, "peak speed", "lugre") < 1e-5


@pytest.mark.slow
def test_a_rig_has_the_torque_of_its_source_while_the_film_bears_alone():
    rows = machines.measure_crank_pin(quick=True)
    result = {row.point: row for row in rows if row.quantity == "shaft torque"}
    assert result["8 kN, 1000 rpm"].computed == pytest.approx(result["8 kN, 1000 rpm"].reference, rel=0.08)
    assert (
        result["4 kN, 250 rpm"].computed < 0.7 * result["4 kN, 250 rpm"].reference
    )  # mixed friction: as the page says


@slow
def test_every_point_of_the_rig_is_between_both_counts_of_the_film():
    rows = [row for row in machines.measure_crank_pin() if row.quantity == "shaft torque"]
    by = {(row.point, row.variant): row.computed for row in rows}
    points = {row.point: row.reference for row in rows}
    assert len(points) == 15
    for point, torque in points.items():
        low, high = by[point, "reynolds"], by[point, machines.MEAN_HEIGHTS]
        assert low <= torque <= high or torque == pytest.approx(low, rel=0.13), point


@slow
def test_oil_whirl_begins_where_the_closed_form_says():
    rows = machines.measure_whirl()
    closed = [row for row in rows if row.variant == "short"]
    assert len(closed) == 16
    assert [row.computed for row in closed] == pytest.approx([row.reference for row in closed], rel=0.02)
    assert all(2.1 < row.computed < 2.76 for row in rows if row.variant == "reynolds")


@slow
def test_grooves_move_a_journal_by_some_hundredths_of_the_clearance():
    rows = films.measure_books()
    assert 0.01 < largest(rows, "eccentricity ratio", "reynolds") < 0.035
    assert largest(rows, "attitude", "reynolds") < 15.0


@slow
def test_grooves_cost_a_film_damping_across_its_load_and_a_rotor_its_threshold():
    rows = films.measure_books()
    assert len(rows) == 452  # of 35 bearings the place, of 20 the coefficients, of 16 of them a threshold, by two laws
    ratios = {}
    for row in rows:
        if row.variant == "reynolds":
            ratios.setdefault(row.quantity, []).append(row.computed / row.reference)
    for quantity, low, high in (  # what the page says
        ("stiffness Kxx", 0.45, 1.1),
        ("stiffness Kxy", 0.88, 1.12),
        ("damping Bxx", 0.83, 1.17),
        ("damping Byy", 0.75, 3.4),
        ("threshold speed", 0.99, 1.28),
    ):
        assert low < min(ratios[quantity]) < max(ratios[quantity]) < high, quantity
    light = {row.computed for row in rows if row.quantity == "threshold speed" and row.point == "L/D 1, S 2.95"}
    assert min(light) == pytest.approx(2.54, abs=0.03)  # as the whirling rotor of whirl.py runs


@pytest.mark.parametrize(
    ("ratio", "threshold"), [(0.1, 2.741), (0.3, 2.606), (0.5, 2.542), (0.7, 3.628), (0.8, math.inf)]
)
def test_a_short_film_has_the_threshold_of_its_closed_form(ratio, threshold):
    """Stiffness and damping of Ocvirk's film in closed form, with Routh's criterion: see the section on oil whirl."""
    slenderness, slow_share = 0.25, 1.0 - ratio**2
    root = math.sqrt(math.pi**2 * slow_share + 16.0 * ratio**2)
    sommerfeld = 0.5 * slenderness**2 * ratio * root / slow_share**2
    attitude = math.atan2(math.pi * math.sqrt(slow_share), 4.0 * ratio)
    film = films.film_coefficients("short", slenderness, sommerfeld, ratio, attitude)
    assert film["damping Bxy"] == pytest.approx(film["damping Byx"], rel=1e-5)
    assert films.whirl_threshold(film) == pytest.approx(threshold, abs=2e-3)


@slow
def test_ten_micrometres_in_a_pin_move_the_squeezer_by_less_than_0_1_rad():
    opened = [row for row in machines.measure_squeezer() if row.variant == "one pin open"]
    assert 1e-3 < largest(opened, "angle at 0.03 s", "one pin open") < 0.1


@slow
def test_pressure_laws_agree_on_volume_and_joints_in_space_wear_at_edges():
    rows = contact.measure_wear()
    ratios = {row.point: row.computed for row in rows if row.quantity == "ratio of worn volumes"}
    # arcs of up to 30 degrees: the pressure all round is up to 0.7 % more than its resultant
    assert ratios.pop("line contact over foundation, worn in") == pytest.approx(0.993, abs=0.02)
    assert list(ratios.values()) == pytest.approx([1.0, 1.0, 1.0], abs=0.05)
    assert largest(rows, "place of the deepest wear") == 0.0
    profiles = contact.new_profiles()
    apart = [np.sqrt(np.mean((depth - profiles["persson"]) ** 2)) for depth in profiles.values()]
    assert max(apart) < 0.1 * profiles["persson"].mean()  # the page says that they hardly differ
    springs, line = (depths for _, depths in contact.worn_in_profiles().values())
    for node, rms, most in ((1, 0.05, 0.11), (-1, 0.07, 0.27)):  # new and worn in
        difference = springs[node] / springs[node].mean() - line[node] / line[node].mean()
        measured = np.sqrt(np.mean(difference**2)), np.abs(difference).max()
        assert measured == pytest.approx((rms, most), abs=0.03)


@pytest.fixture(scope="module")
def impacts():
    return contact.measure_oblique()


@pytest.fixture
def few(monkeypatch):
    """Leave only what takes no time."""
    monkeypatch.setattr(measured, "BENCHMARKS", (contact.HERTZ_IMPACTS,))


def test_of_differences_that_are_normal_the_spread_contains_19_of_20_further_ones():
    chance, inside = np.random.default_rng(7), []
    (row,) = contact.measure_hertz()[:1]
    for _ in range(300):
        drawn = chance.normal(0.0, 2.0, 6)
        limit = points.expected_difference([row._replace(difference=float(value)) for value in drawn])
        inside.append(np.mean(np.abs(chance.normal(0.0, 2.0, 100)) <= limit))
    assert 0.94 < np.mean(inside) < 0.99
    assert points.expected_difference([row]) is None


@pytest.mark.usefixtures("few")
def test_the_command_prints_rows_of_the_contract_as_json():
    message = CliRunner().invoke(cli.verbs, ["verify", "--measured", "--json"])
    assert message.exit_code == 0, message.output
    rows = json.loads(message.stdout)
    assert len(rows) == 12
    for row in rows:
        assert set(row) >= KEYS
        assert row["kind"] in KINDS
        assert row["difference"] == pytest.approx(row["computed"] - row["reference"])


def test_the_page_has_every_point_its_source_and_its_spread(tmp_path):
    rows = contact.measure_hertz()
    words = points.write_page(rows, tmp_path, (contact.HERTZ_IMPACTS,)).read_text(encoding="utf-8")
    assert words.count("| Hertz impacts |") == 12
    assert rows[0].source in words
    assert "| depth |  | published | 4 |" in words
    assert "Hertz impacts, depth" in points.rows_text(rows)
