"""Numbers that carry a derivative, and the derivatives of every law and mechanism that come from them."""

import math

import law_cases
import numpy as np
import pytest
from mechanism_cases import slider_crank

import clearsweep
from clearsweep.mechanics.coupling.rates import slopes_of
from clearsweep.mechanics.joints import registry
from clearsweep.mechanics.laws.contract import STUCK
from clearsweep.mechanics.laws.elastic import elastic_force
from clearsweep.mechanics.laws.friction import friction_force
from clearsweep.mechanics.laws.loss import contact_force
from clearsweep.mechanics.solver import integration, radau
from clearsweep.simulation.running.run import Run
from clearsweep.simulation.setup.start import start_of
from clearsweep.tracing.compiled import calculus
from clearsweep.tracing.compiled.choosing import MAX_EXACT_ANGLE, direction
from clearsweep.tracing.compiled.dual import FUNCTIONS, Dual, Seeded, as_dual, slope, value
from clearsweep.tracing.compiled.family import kernel
from clearsweep.tracing.objects import machine_code

pytestmark = pytest.mark.heavy

PEN, RATE, ONSET = 3e-6, 0.2, 0.3  # m, m/s, m/s
NORMAL, SLIPS = 50.0, (-3.1e-3, -2e-4, 2.7e-4, 4.1e-3)  # N, m/s
OPENINGS = (
    ("ground-crank",),
    ("crank-rod",),
    ("rod-slider",),
    ("ground-crank", "crank-rod"),
    ("ground-crank", "rod-slider"),
    ("crank-rod", "rod-slider"),
    ("ground-crank", "crank-rod", "rod-slider"),
)


def differences(function, x, size):
    """Return the derivative of `function` at `x` by Richardson's extrapolation of central differences."""
    h = 1e-3 * size
    table = [[(function(x + h / 2**k) - function(x - h / 2**k)) / (2.0 * h / 2**k)] for k in range(5)]
    for k in range(1, 5):
        for m in range(1, k + 1):
            table[k].append(table[k][m - 1] + (table[k][m - 1] - table[k - 1][m - 1]) / (4**m - 1))
    return table[4][4]


@machine_code
def slope_of_elastic(term, pen):
    return slope(elastic_force(term, Dual(pen, 1.0)))


@machine_code
def slopes_of_contact(law, term, pen, rate, onset):
    by_pen = contact_force(law, term, Dual(pen, 1.0), Dual(rate, 0.0), onset)[0]
    by_rate = contact_force(law, term, Dual(pen, 0.0), Dual(rate, 1.0), onset)[0]
    return slope(by_pen), slope(by_rate)


@machine_code
def slopes_of_friction(term, normal, slip):
    by_slip, by_normal = Dual(slip, 1.0), Dual(normal, 1.0)
    return slope(friction_force(term, normal, by_slip)), slope(friction_force(term, by_normal, slip))


@pytest.mark.parametrize("name", law_cases.names("elastic"))
def test_stiffness_of_every_elastic_law_is_exact(name):
    term = law_cases.RECIPES["elastic", name].make(law_cases.joint(elastic=name))
    expected = differences(lambda pen: elastic_force(term, pen), PEN, PEN)
    assert slope_of_elastic(term, PEN) == pytest.approx(expected, rel=1e-7)


@pytest.mark.parametrize("rate", [RATE, -RATE])
@pytest.mark.parametrize("name", law_cases.names("law"))
def test_derivatives_of_every_contact_law_are_exact(name, rate):
    law, term = registry.compile_contact(law_cases.joint(law=name))
    by_pen, by_rate = slopes_of_contact(law, term, PEN, rate, ONSET)
    expected = differences(lambda pen: contact_force(law, term, pen, rate, ONSET)[0], PEN, PEN)
    assert by_pen == pytest.approx(expected, rel=1e-7)
    expected = differences(lambda rate: contact_force(law, term, PEN, rate, ONSET)[0], rate, RATE)
    assert by_rate == pytest.approx(expected, rel=1e-7, abs=1e-9)


@pytest.mark.parametrize("slip", SLIPS)
@pytest.mark.parametrize("name", law_cases.names("friction"))
def test_derivatives_of_every_friction_law_are_exact(name, slip):
    term = law_cases.RECIPES["friction", name].make(law_cases.joint(friction=name))
    by_slip, by_normal = slopes_of_friction(term, NORMAL, slip)
    assert by_normal == pytest.approx(friction_force(term, NORMAL, slip) / NORMAL, rel=1e-12)
    expected = differences(lambda slip: friction_force(term, NORMAL, slip), slip, abs(slip))
    assert by_slip == pytest.approx(expected, rel=1e-7, abs=1e-6)


def evaluate(work, y):
    integration.evaluate((work,), y, 0)


def differentiate(work, y):
    radau.differentiate((work,), y, 0)


@pytest.mark.few("crank-rod+rod-slider")  # each is a compiled form of its own
@pytest.mark.parametrize("names", OPENINGS, ids="+".join)
def test_the_jacobian_of_every_mechanism_is_exact(names):
    """In contact, moving, under friction; the truth are differences, in units in which every component is near 1."""
    friction = {"law": "tanh", "coefficient": 0.3, "velocity_scale": 1.0}
    assert jacobian_error(names, friction) < 1e-7


@pytest.mark.slow
@pytest.mark.parametrize("names", OPENINGS, ids="+".join)
def test_the_jacobian_of_surfaces_that_stick_is_exact(names):
    """The force that applies follows from accelerations of the gaps, which are slopes themselves: Duals of Duals."""
    strong = {"coefficient": 0.1, "static_coefficient": 10.0, "stribeck_velocity": 1e-2, "band": 1e-3}
    assert jacobian_error(names, {"law": "karnopp", **strong}, STUCK) < 1e-7


def jacobian_error(names, friction, state=None):
    """Return how far the Jacobian of a slider-crank in contact is from differences, over the largest of each row."""
    changes = {"mechanism.gravity": 9.81, "simulate.start": "seated"}
    case = slider_crank(*names, changes=changes | {f"joints.{name}.friction": friction for name in names})
    made = clearsweep.load_case(case)
    run = Run(start_of(made, np.empty(0)))  # keeps what compiled code reads
    work = run.work
    if state is not None:
        work.mode[:] = state
    work.slopes.numbers[:] = slopes_of(made.value, run.parameters)
    half, clearance = len(made.value.coordinates), made.value.joints[0].clearance
    roots = work.y[2 * half + 1 :]
    size = np.concatenate([np.full(half, clearance), np.full(half, 1.0), [1.0 / made.value.reference_rate], roots])
    y = work.y + 0.1 * size * np.random.default_rng(7).normal(size=size.size)
    work.z[:] = y  # states that compiled code is given lie in a lane
    differentiate(work, work.z)
    jacobian = work.implicit.jacobian[0, :, : size.size] * size

    def rates_along(column):
        def rates(x):
            work.z[:] = y
            work.z[column] += x * size[column]
            evaluate(work, work.z)
            return work.k[:, 0].copy()

        return rates

    expected = np.column_stack([differences(rates_along(column), 0.0, 3.0) for column in range(size.size)])
    largest = np.abs(expected).max(axis=1, keepdims=True)
    return np.max(np.abs(jacobian - expected) / np.where(largest > 0.0, largest, 1.0))  # some numbers keep still


@machine_code
def mixed(y, direction):
    z = Seeded(y, direction)
    total = 0.0
    for i in range(3):
        total += z[i] * z[i] / (1.0 + abs(z[i]))
    total -= max(z[0], 0.5) * min(z[1], 2.0) ** 2 + 3.0 / z[2] - (-z[1])
    made = as_dual(total if z[0] > z[1] else 0.0)
    return value(made), slope(made)


@pytest.mark.compiled
def test_compiled_and_uncompiled_arithmetic_is_the_same():
    for y in (np.array([0.7, -0.3, 1.9]), np.array([0.2, 0.3, 1.9]), np.array([0.3, -0.4, 0.6])):
        for axis in range(3):
            assert mixed(y, axis) == pytest.approx(mixed.__wrapped__(y, axis), rel=1e-15)


@kernel
def curve(x):
    return calculus.sqrt(1.0 + x * x) * calculus.sin(3.0 * x) / (2.0 - x) + abs(x) ** 3


@machine_code
def first_derivative(x):
    return slope(curve(Dual(x, 1.0)))


@machine_code
def second_derivative(x):
    return slope(slope(curve(Dual(Dual(x, 1.0), 1.0))))


def test_duals_of_duals_give_second_derivatives():
    for x in (-0.8, 0.3, 1.1):
        assert first_derivative(x) == pytest.approx(differences(curve, x, 0.5), rel=1e-9)
        assert second_derivative(x) == pytest.approx(differences(first_derivative, x, 0.5), rel=1e-9)


def curvature_of_circle(x):
    z = Dual(Dual(x, 1.0), Dual(1.0, 0.0))
    return slope(slope(calculus.sqrt(1.0 - z * z)))


@pytest.mark.parametrize("how", [curvature_of_circle, machine_code(curvature_of_circle)])
def test_a_root_that_stands_still_has_its_second_derivative(how):
    assert how(0.0) == -1.0
    assert how(0.6) == pytest.approx(-1.0 / 0.8**3)


@pytest.mark.parametrize("name", [name for name in FUNCTIONS if name != "copysign"])
def test_a_function_of_mathematics_has_its_derivative(name):
    expected = differences(getattr(math, name), 0.4, 0.4)
    assert FUNCTIONS[name](Dual(0.4, 2.0)).slope == pytest.approx(2.0 * expected, rel=1e-9)
    assert FUNCTIONS[name](Dual(0.4, 2.0)).value == getattr(math, name)(0.4)


# ---------------------------------------------------------------------------------------------- directions


compiled = machine_code(direction)


@pytest.mark.parametrize("function", [direction, compiled])
@pytest.mark.parametrize("largest", [1e-9, 0.1, 7.0, 1e3, MAX_EXACT_ANGLE])
def test_a_direction_is_exact_to_rounding(function, largest):
    angles = np.concatenate([np.linspace(-largest, largest, 2001), np.arange(-40, 41) * math.pi / 8 % largest])
    result = np.array([function(float(angle)) for angle in angles])
    np.testing.assert_allclose(result, np.column_stack([np.cos(angles), np.sin(angles)]), rtol=0, atol=2e-16)


@pytest.mark.parametrize("function", [direction, compiled])
def test_beyond_it_is_exact_to_the_rounding_of_the_angle(function):
    for angle in (1e7, -3e9, 1e12):
        rounding = np.spacing(abs(angle))
        assert function(angle) == pytest.approx((math.cos(angle), math.sin(angle)), rel=0.0, abs=2e-16 + rounding)
    assert all(math.isnan(part) for part in function(math.nan))
