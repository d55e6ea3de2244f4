"""The preconditioned iteration of explicit steps."""

from types import SimpleNamespace

import numpy as np
import pytest
from mechanism_cases import changed, slider_crank

import clearsweep
from clearsweep import simulate
from clearsweep.mechanics.observe import STAGES
from clearsweep.mechanics.solver import preconditioner, step
from clearsweep.mechanics.solver.collocation import A
from clearsweep.verify.accuracy import all_problems, scene_of

pytestmark = pytest.mark.heavy

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
