"""The implicit method, and the choice between it and the explicit one."""

import numpy as np
import pytest
from mechanism_cases import PAIR, changed, slider_crank

import clearsweep
from clearsweep.kernels import stiff

FIGURES = ("rod_slider_force_peak", "rod_slider_force_rms", "rod_slider_penetration_max", "slider_acceleration_rms")


def run(method, changes, source=None):
    case = changed(source or slider_crank("rod-slider"), {"simulate.method": method, **changes})
    trajectory = clearsweep.simulate(clearsweep.load_case(case))
    assert trajectory.status == "ok", trajectory.message
    return trajectory.summary


def heavy(damping):
    contact = {"law": "kelvin-voigt", "stiffness": 1e8, "damping": damping}
    return {"joints.rod-slider.contact": contact, "simulate.tolerance": 1e-6, "simulate.revolutions": 0.5}


def test_factors_solve_a_system_that_needs_pivoting():
    generator = np.random.default_rng(3)
    matrix, right = generator.normal(size=(9, 9)), generator.normal(size=9)
    matrix[0, 0] = 0.0
    factors, pivots, found = matrix.copy(), np.zeros(9, dtype=np.int64), right.copy()
    assert stiff.factorise(factors, pivots)
    stiff.substitute(factors, pivots, found)
    assert matrix @ found == pytest.approx(right, abs=1e-12)
    assert not stiff.factorise(np.zeros((3, 3)), np.zeros(3, dtype=np.int64))


def test_the_tableau_is_collocation_of_order_five():
    nodes = np.array([*stiff.C, 1.0])
    for power in range(1, 4):  # A integrates polynomials up to degree 2 exactly at each node, the last row to degree 4
        assert stiff.A @ nodes ** (power - 1) == pytest.approx(nodes**power / power, abs=1e-15)
    for power in range(4, 6):
        assert stiff.A[2] @ nodes ** (power - 1) == pytest.approx(1.0 / power, abs=1e-15)


@pytest.mark.parametrize(("damping", "gain"), [(1e6, 4.0), (1e7, 20.0)])
def test_stiff_contact_is_left_to_the_implicit_method_with_the_same_figures(damping, gain):
    auto, explicit = run("auto", heavy(damping)), run("explicit", heavy(damping))
    assert gain * auto["rhs_evaluations"] < explicit["rhs_evaluations"]
    for figure in FIGURES:
        assert auto[figure] == pytest.approx(explicit[figure], rel=1e-5)
    assert auto["energy_residual"] < 1e-5


def test_a_motion_that_is_not_stiff_pays_nothing():
    changes = {"simulate.revolutions": 2}
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
