"""The implicit method, and the choice between it and the explicit one."""

from types import SimpleNamespace

import numpy as np
import pytest
from mechanism_cases import PAIR, changed, slider_crank, untimed

import clearsweep
from clearsweep import simulate
from clearsweep.mechanics.observe import NODE_FRACTIONS, STAGES
from clearsweep.mechanics.solver import preconditioner, radau, step
from clearsweep.mechanics.solver.collocation import A, basis_functions
from clearsweep.simulation.running.run import Run
from clearsweep.verify import comparisons, extremes, stability
from clearsweep.verify.accuracy import all_problems, scene_of

pytestmark = pytest.mark.heavy

FIGURES = ("rod_slider_force_peak", "rod_slider_force_rms", "rod_slider_penetration_max", "slider_acceleration_rms")


def run(method, changes, source=None):
    case = changed(source or slider_crank("rod-slider"), {"simulate.method": method, **changes})
    trajectory = clearsweep.simulate(clearsweep.load_case(case))
    assert trajectory.status == "ok", trajectory.message
    return trajectory.summary


def heavy(damping):
    contact = {"law": "kelvin-voigt", "stiffness": 1e8, "damping": damping}
    return {"joints.rod-slider.contact": contact, "simulate.tolerance": 1e-6, "simulate.revolutions": 0.5}


@pytest.mark.parametrize("fixed", [0, 4])
def test_factors_solve_a_system(fixed):
    generator = np.random.default_rng(3)
    matrix, right = generator.normal(size=(9, 9)), generator.normal(size=9)
    matrix[:4, :4] = np.eye(4)
    if not fixed:
        matrix[0, 0] = 0.0  # needs pivoting
    factors, pivots, result = matrix.T.copy(), np.zeros(9, dtype=np.int64), right.copy()
    assert radau.factorise(factors, pivots, fixed)
    radau.substitute(factors, pivots, result)
    assert matrix @ result == pytest.approx(right, abs=1e-12)
    assert not radau.factorise(np.zeros((3, 3)), np.zeros(3, dtype=np.int64), 0)


def test_the_tableau_is_collocation_of_order_nine():
    nodes = radau.C
    for power in range(1, 6):  # A integrates polynomials up to degree 4 exactly at each node, the last row to degree 8
        assert radau.A @ nodes ** (power - 1) == pytest.approx(nodes**power / power, abs=1e-14)
    for power in range(6, 10):
        assert radau.A[-1] @ nodes ** (power - 1) == pytest.approx(1.0 / power, abs=1e-14)
    assert np.min(np.abs(np.linalg.eigvals(np.linalg.inv(radau.A)) - radau.GAMMA)) < 1e-12


def test_stages_say_what_lies_between_them():
    """Dense output, observables and Jacobians are polynomials through the stages: exact for such."""
    shares = np.linspace(0.0, 1.0, 7)
    stages = radau.C**5 - 2.0 * radau.C  # above a start at 0
    assert basis_functions(shares)[:, :5] @ radau.DENSE @ stages == pytest.approx(shares**5 - 2.0 * shares, abs=1e-13)
    seen = NODE_FRACTIONS[1:8]
    assert radau.TO_EXPLICIT_STAGES @ np.append(1.0, 1.0 + stages) == pytest.approx(
        1.0 + seen**5 - 2.0 * seen, abs=1e-13
    )
    assert radau.TO_ALL_STAGES @ radau.C[radau.JACOBIAN_STAGES] ** 2 == pytest.approx(radau.C**2, abs=1e-13)


def test_the_error_estimate_is_of_the_order_it_says():
    """The estimate for y' = y^0 t^k, whose rate at the start is 0 for k > 0, vanishes up to the fourth power of t."""
    for power in range(1, 6):
        result = radau.E @ radau.C ** (power + 1) / (power + 1)
        assert (abs(result) < 1e-13) == (power < radau.ORDER - 1)


@pytest.mark.parametrize(("damping", "steps"), [(1e6, 250), (1e7, 700), (7e7, 1500)])
def test_a_stiff_contact_has_the_same_figures_by_every_method(damping, steps):
    """With plain sweeps the explicit method takes 31,132, 309,295 and more than 999,993 steps."""
    auto, explicit, implicit = (run(method, heavy(damping)) for method in ("auto", "explicit", "implicit"))
    assert explicit["steps"] < steps
    for figure in FIGURES:
        assert auto[figure] == pytest.approx(explicit[figure], rel=2e-5)
        assert implicit[figure] == pytest.approx(explicit[figure], rel=2e-5)
    assert auto["energy_residual"] < 1e-5


def test_stiff_bristles_are_left_to_the_implicit_method():
    auto, explicit = run("auto", clamped_mass(1e6)), run("explicit", clamped_mass(1e6))
    assert auto["rhs_evaluations"] < 0.9 * explicit["rhs_evaluations"]


def test_stiffness_costs_little_where_the_tolerance_limits_the_steps():
    """With plain sweeps the explicit method takes 25 times as many evaluations as the implicit one."""
    changes = heavy(1e6) | {"simulate.tolerance": 1e-10}
    auto, implicit = run("auto", changes), run("implicit", changes)
    assert auto["rhs_evaluations"] < 1.2 * implicit["rhs_evaluations"]  # a sweep counts as eight


@pytest.mark.parametrize(
    ("speed", "restitution", "tolerance"), [(5000, 0.9, 1e-9), (1000, 0.7, 1e-8), (3000, 0.5, 1e-8)]
)
def test_a_motion_that_is_not_stiff_pays_nothing(speed, restitution, tolerance):
    """Though steps in contact are as long, times the largest eigenvalue, as where stiffness limits them."""
    changes = {
        "drive.speed": f"{speed} rpm",
        "joints.rod-slider.contact.restitution": restitution,
        "simulate.tolerance": tolerance,
        "simulate.revolutions": 2,
    }
    auto, explicit = run("auto", changes), run("explicit", changes)
    for figure in ("steps", "rhs_evaluations", *FIGURES):
        assert auto[figure] == explicit[figure]


def test_the_implicit_method_alone_converges_to_the_explicit_solution():
    exact = run("explicit", {"simulate.revolutions": 0.1, "simulate.tolerance": 1e-10})["rod_slider_force_peak"]
    errors = []
    for tolerance in (1e-5, 1e-7, 1e-9):
        changes = {"simulate.revolutions": 0.1, "simulate.tolerance": tolerance}
        errors.append(abs(run("implicit", changes)["rod_slider_force_peak"] / exact - 1.0))
    assert errors[0] > errors[1] > errors[2]
    assert errors[2] < 1e-6


def test_the_implicit_method_returns_the_restitution_too():
    changes = {"simulate.tolerance": 1e-10, "simulate.impacts": 1}
    assert run("implicit", changes, PAIR)["pair_restitution"] == pytest.approx(0.5, abs=1e-6)


MOST_EVALUATIONS = {  # of the explicit method at 1e-6; with plain sweeps 3.0, 29.9 and 16.1 millions
    "damping/C 1e6 N s/m": 40_000,
    "damping/C 1e7 N s/m": 100_000,
    "damping/BC 1e6 N s/m": 120_000,
}


@pytest.mark.slow
def test_where_stability_limits_plain_sweeps_preconditioned_ones_are_far_cheaper():
    """In the second half of the turn, impacts of two joints multiply the error by 20, at every tolerance.

    Of one case, rounding moves errors and evaluations by some per cent; what the choice costs shows in the sum of all.
    """
    sums = dict.fromkeys(("explicit", "auto"), 0.0)
    for case in comparisons.stiff_cases():
        (row,) = comparisons.compare_at_equal_error(case, (1e-6,))
        assert row["auto"]["error"] <= row["explicit"]["error"]
        for method in sums:
            sums[method] += row[method]["rhs_evaluations"]
        if case.name not in MOST_EVALUATIONS:
            continue
        assert row["explicit"]["rhs_evaluations"] < MOST_EVALUATIONS[case.name]
        runs = (comparisons.run_case(case, value, "explicit") for value in (1e-6, comparisons.REFERENCE_TOLERANCE))
        first_halves = ({name: x[: comparisons.SAMPLES // 2] for name, x in run.channels.items()} for run in runs)
        assert comparisons.error_of(*first_halves, case) < 5e-5
    assert sums["explicit"] / sums["auto"] >= 1.0


@pytest.mark.few("b_grav_fric", "a_base")
@pytest.mark.parametrize(
    "problem", [p for p in comparisons.all_problems() if p.name != "b_damped"], ids=lambda p: p.name
)
def test_the_automatic_choice_costs_no_more_where_nothing_is_stiff(problem):
    assert comparisons.evaluation_ratio(problem)["evaluations_ratio"] <= 1.05


@pytest.mark.slow
def test_a_step_cut_where_no_iteration_converges_still_gives_finite_figures():
    case = next(case for case in extremes.extreme_cases() if case.name == "stiff/BC damping 1e+06, 1500 rpm")
    assert stability.run_case(case)["failure"] == ""


NAMED = (
    "stiffness/BC 1e+05",
    "stiffness/ABC 1e+10",
    "mass/ABC all x 10",
    "clearance/ABC 2e-04 m",
    "friction/BC tanh 0.01",
    "stiff/C damping 1e+06, 300 rpm",
)
SCENES = [*comparisons.stiff_cases(), *(case for case in extremes.extreme_cases() if case.name in NAMED)]


def over_half_a_turn(case, method, tolerance=1e-8):
    """Return the trajectory of half a revolution of a case."""
    settings = {"simulate.method": method, "simulate.tolerance": tolerance, "simulate.step_budget": 3e6}
    settings |= {"simulate.revolutions": 0.5, "simulate.discard": 0}
    return clearsweep.simulate(clearsweep.load_case(changed(case.grid, settings)))


@pytest.mark.few("stiffness/BC 1e+05", "mass/ABC all x 10", "stiff/C damping 1e+06, 300 rpm")
@pytest.mark.parametrize("case", SCENES, ids=lambda case: case.name)
def test_every_method_ends_a_stiff_case_alike(case):
    """Status and events are of the case, not of the method; the figures agree within what impacts amplify."""
    runs = {method: over_half_a_turn(case, method) for method in comparisons.METHODS}
    assert {path.status for path in runs.values()} == {"ok"}, {name: path.message for name, path in runs.items()}
    exact = over_half_a_turn(case, "explicit", 1e-10).summary
    for path in runs.values():
        for name in exact:
            if name.endswith(("force_peak", "penetration_max", "impacts_per_rev")):
                assert path.summary[name] == pytest.approx(exact[name], rel=1e-3), name


@pytest.mark.parametrize("method", ["explicit", "implicit"])
def test_a_run_reads_nothing_that_an_earlier_one_left(method, monkeypatch):
    """Three joints: the observables of all contacts at all stages are those of this run."""
    case = next(case for case in extremes.extreme_cases() if case.name == "mass/ABC all x 10")
    clean, begin = over_half_a_turn(case, method, 1e-6), Run._begin

    def spoiled(run, start):
        for name in ("k", "o", "nodes", "f", "polynomials", "step", "part_times", "end", "z"):
            run.arrays[name][...] = 1e300
        begin(run, start)

    monkeypatch.setattr(Run, "_begin", spoiled)
    assert untimed(over_half_a_turn(case, method, 1e-6)) == untimed(clean)


def clamped_mass(stiffness):
    """Return the changes with which bristles of a stiffness (1/m) stick and hold for most of a slow stroke."""
    names = {"coefficient": 0.3, "static_coefficient": 0.3, "stribeck_velocity": 0.01, "bristle_damping": 0.0}
    return {
        "joints.rod-slider.friction": {"law": "lugre", "bristle_stiffness": stiffness, **names},
        "joints.rod-slider.contact.onset": "first",
        "drive.speed": "60 rpm",
        "simulate.start": "seated",
        "simulate.revolutions": 0.3,
        "simulate.discard": 0,
        "simulate.tolerance": 1e-6,
    }


@pytest.mark.parametrize(("method", "ratio"), [("auto", 8.0), ("implicit", 2.0)])
def test_overdamped_contact_costs_little_more_at_a_million_crank_rates(method, ratio):
    """Damping over mass is 1e4 and 1e6 times the crank's rate; with plain sweeps the cost grows as their ratio."""
    mild, stiffest = (run(method, heavy(damping)) for damping in (7e5, 7e7))
    assert stiffest["rhs_evaluations"] < ratio * mild["rhs_evaluations"]
    assert stiffest["steps"] < ratio * mild["steps"]


@pytest.mark.parametrize("method", ["auto", "implicit"])
def test_surfaces_held_by_stiffer_bristles_cost_little_more(method):
    mild, stiffest = (run(method, clamped_mass(stiffness)) for stiffness in (1e4, 1e7))
    assert stiffest["rhs_evaluations"] < 2.5 * mild["rhs_evaluations"]
    assert stiffest["energy_residual"] < 1e-5


@pytest.mark.slow
def test_an_event_at_the_start_of_an_implicit_step_leaves_the_motion_finite():
    """Three joints with friction as steep as can be: events follow each other within rounding."""
    (case,) = (case for case in extremes.extreme_cases() if case.name == "friction/ABC tanh 1")
    assert stability.run_case(case)["failure"] == ""


@pytest.mark.compiled
def test_powers_of_implicit_steps_are_those_of_the_solved_stages():
    """A film moves 160 times the kinetic energy; forces before the last iteration miss 1e-5 of it."""
    slow = {"drive.speed": "200 rpm", "joints.rod-slider.film.temperature": "40 degC", "simulate.revolutions": 2}
    pump = clearsweep.simulate(clearsweep.load_case("configs/pump.yaml", slow))
    assert pump.status == "ok"
    assert pump.summary["energy_residual"] < 3e-7


# The preconditioned iteration of explicit steps.


COORDINATES, CONTACTS, UNKNOWNS = 2, 1, 3  # of a state of 2 coordinates, 2 velocities, time, 1 root, 1 internal state


def pointer_with(generator):
    """Return a pointer to the arrays that a sweep of this state leaves, with derivatives of its unknowns."""
    arrays = preconditioner.preconditioner_of(UNKNOWNS)
    arrays.linear[:] = generator.normal(size=(UNKNOWNS, UNKNOWNS)) * 8.0
    arrays.quadratic[:] = generator.normal(size=(UNKNOWNS, UNKNOWNS)) * 20.0
    arrays.before[:] = generator.normal(size=(UNKNOWNS, STAGES))
    work = SimpleNamespace(
        preconditioner=arrays,
        nodes=generator.normal(size=(8, STAGES)),
        y=np.zeros(7),
        weight=np.arange(1.0, 8.0),
        time=2 * COORDINATES,
        mode=np.zeros(CONTACTS, dtype=np.int64),
    )
    return (work,)


def test_eigenvectors_diagonalise_the_matrix_of_the_stages():
    values = np.random.default_rng(1).normal(size=STAGES)
    real, imaginary = values @ preconditioner.TO_REAL, values @ preconditioner.TO_IMAGINARY
    components = (real + 1j * imaginary)[: preconditioner.PAIRS]
    for power in range(3):
        scaled = components * np.array([complex(*pair) for pair in preconditioner.EIGENVALUES]) ** power
        result = scaled.real @ preconditioner.FROM_REAL + scaled.imag @ preconditioner.FROM_IMAGINARY
        assert result == pytest.approx(values @ np.linalg.matrix_power(A, power), abs=1e-11)


def test_the_change_of_a_sweep_becomes_that_of_newtons_method():
    pointer = pointer_with(np.random.default_rng(2))
    work, arrays = pointer[0], pointer[0].preconditioner
    rows = [preconditioner.row_of(pointer, unknown) for unknown in range(UNKNOWNS)]
    assert rows == [2, 3, 6]
    change, others = work.nodes[rows] - arrays.before, work.nodes[[0, 1, 4, 5]].copy()
    matrix = np.eye(UNKNOWNS * STAGES) - np.kron(arrays.linear, A.T) - np.kron(arrays.quadratic, A.T @ A.T)
    expected = np.linalg.solve(matrix, change.ravel()).reshape(change.shape)
    preconditioner.factorise_pairs(arrays)
    preconditioner.eliminate(pointer)
    preconditioner.substitute_back(pointer)
    assert work.nodes[rows] - arrays.before == pytest.approx(expected, rel=1e-9)
    assert work.nodes[7] == pytest.approx(work.weight[rows] ** 2 @ expected**2, rel=1e-10)
    assert np.array_equal(work.nodes[[0, 1, 4, 5]], others)


def test_more_unknowns_than_lanes_are_left_to_plain_sweeps():
    assert preconditioner.preconditioner_of(preconditioner.MAX_UNKNOWNS).increment.size == STAGES - 1
    assert preconditioner.preconditioner_of(preconditioner.MAX_UNKNOWNS + 1).increment.size == 0


def slow_after(preconditioned, is_solved, contraction=0.0, rejections=0.0):
    """Return whether the next iteration may be preconditioned after this one."""
    work = SimpleNamespace(
        step=SimpleNamespace(preconditioned=preconditioned, contraction=contraction),
        stepper=SimpleNamespace(slow=preconditioned, rejections=rejections),
    )
    step.note_contraction((work,), is_solved)
    return work.stepper.slow


def test_a_slow_iteration_is_preconditioned_and_plain_after_two_failures():
    assert slow_after(0.0, True, contraction=0.14) == 0.0
    assert slow_after(0.0, True, contraction=0.16) == 1.0
    assert slow_after(0.0, False) == 1.0
    assert slow_after(1.0, True, contraction=0.5) == 1.0
    assert slow_after(1.0, False) == 1.0
    assert slow_after(1.0, False, rejections=1.0) == 0.0


def test_two_joints_take_half_of_the_steps_that_plain_sweeps_allow():
    """With plain sweeps 1,841 steps: their contraction, mostly by damping, limits them."""
    (problem,) = (problem for problem in all_problems() if problem.name == "ab_base")
    assert simulate(scene_of(problem, 1e-8)).summary["steps"] < 1000


def test_a_stiff_link_does_not_limit_the_steps():
    """With plain sweeps 13,545 steps; the force of the link depends on coordinates, not on roots."""
    changes = {
        "mechanism.rod.elastic": {"axial_stiffness": "385e6 N/m", "damping": "1 %"},
        "drive.speed": "300 rpm",
        "joints.rod-slider.contact.restitution": 0.3,
        "simulate.revolutions": 1,
        "simulate.method": "explicit",
    }
    case = clearsweep.load_case(changed(slider_crank("rod-slider"), changes))
    assert simulate(case).summary["steps"] < 6500
