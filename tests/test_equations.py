"""A slider-crank moves as virtual powers say, put together in coordinates of its own."""

import itertools
import math
import random
from typing import NamedTuple

import numpy as np
import pytest

from clearsweep.contracts.machine import Aim, Body, BodyPoint, Constant, Guide, Machine, Pin
from clearsweep.mechanics.joints.dry import Gap, Joint, joint_load
from clearsweep.mechanics.laws.contract import PRESSED
from clearsweep.mechanics.laws.elastic import PowerThreeHalves
from clearsweep.mechanics.laws.friction import Tanh
from clearsweep.mechanics.laws.hysteresis import Lossless
from clearsweep.mechanics.machines import planar
from clearsweep.mechanics.machines.contract import accelerate, describe, gap_accelerations, gaps, pose_at
from clearsweep.mechanics.machines.planar.kinematics import PlaneVector
from clearsweep.mechanics.machines.programs import LDL
from clearsweep.mechanics.machines.spatial.kinematics import NO_VECTOR, SpatialVector
from clearsweep.tracing import objects
from clearsweep.tracing.compiled.dual import Dual
from clearsweep.tracing.compiled.formulas import ONE, ZERO, Program, sum_of
from clearsweep.tracing.protocols import register_emitter


class Links(NamedTuple):
    """What the slider-crank is."""

    crank_length: float  # m
    crank_center: float  # m, of the centre of mass, from the ground
    crank_mass: float  # kg
    crank_inertia: float  # kg m^2
    rod_length: float
    rod_center: float  # m, from the crank
    rod_mass: float
    rod_inertia: float
    slider_mass: float
    gravity: float  # m/s^2, along -y
    speed: float  # rad/s


LINKS = Links(0.05, 0.02, 0.3, 1e-4, 0.12, 0.07, 0.21, 2.5e-4, 0.14, 9.81, 300.0)
MACHINE = Machine(
    {
        "ground": Body(0.0, 0.0, (0.0, 0.0), {"pivot": (0.0, 0.0)}),
        "crank": Body(
            LINKS.crank_mass, LINKS.crank_inertia, (LINKS.crank_center, 0.0), {"a": (0.0, 0.0), "b": (0.05, 0.0)}
        ),
        "rod": Body(LINKS.rod_mass, LINKS.rod_inertia, (LINKS.rod_center, 0.0), {"b": (0.0, 0.0), "c": (0.12, 0.0)}),
        "slider": Body(LINKS.slider_mass, 0.0, (0.0, 0.0), {"c": (0.0, 0.0)}),
    },
    (
        Pin("ground-crank", BodyPoint("ground", "pivot"), BodyPoint("crank", "a")),
        Pin("crank-rod", BodyPoint("crank", "b"), BodyPoint("rod", "b")),
        Pin("rod-slider", BodyPoint("rod", "c"), BodyPoint("slider", "c")),
        Guide("slider-ground", BodyPoint("ground", "pivot"), BodyPoint("slider", "c"), 0.0),
    ),
    "ground-crank",
    Constant(LINKS.speed),
    LINKS.gravity,
    Aim("slider", "c", 0.0),
)


class Load(NamedTuple):
    """What the equations of motion take of a joint."""

    fx: float  # N, on the distal body
    fy: float  # N
    moment_proximal: float  # N m
    moment_distal: float  # N m


OPENINGS = [opening for count in (1, 2, 3) for opening in itertools.combinations("ABC", count)]
STEP = 1e-30  # of the complex step, whose derivative has no rounding


def positions(opening, q, theta):
    """Return (r1, r2, r3, e_A, e_B, e_C), (6, 2), as the page's table of coordinates has them; any kind of number."""
    l1, s1, l2, s2 = LINKS.crank_length, LINKS.crank_center, LINKS.rod_length, LINKS.rod_center
    u1, u2 = (np.array([np.cos(angle), np.sin(angle)]) for angle in (theta, q[0]))
    zero, slider = np.zeros(2), np.array([q[1], 0.0])
    if opening == ("C",):
        a, b = zero, l1 * u1
    elif opening == ("B",):
        a, b = zero, slider - l2 * u2
    elif opening == ("A",):
        b = slider - l2 * u2
        a = b - l1 * u1
    elif opening == ("A", "B"):
        a, b = np.array(q[2:4]), slider - l2 * u2
    elif opening == ("A", "C"):
        a = np.array(q[2:4])
        b = a + l1 * u1
    else:
        b = np.array(q[2:4]) - s2 * u2
        a = np.array(q[4:6]) if opening == ("A", "B", "C") else zero
    return np.array([a + s1 * u1, b + s2 * u2, slider, a, b - a - l1 * u1, slider - b - l2 * u2])


def slopes(opening, q, theta):
    """Return the derivatives of the positions with respect to coordinates and crank angle, (6, 2, n + 1)."""
    columns = []
    for i in range(len(q) + 1):
        shifted = np.append(q, theta).astype(complex)
        shifted[i] += 1j * STEP
        columns.append(positions(opening, shifted[:-1], shifted[-1]).imag / STEP)
    return np.stack(columns, axis=-1)


def expected(opening, q, v, theta, loads):
    """Return accelerations, drive torque and the accelerations of all positions by the principle of virtual power."""
    n, speed = len(q), LINKS.speed
    motion = np.append(v, speed)
    jacobian = slopes(opening, q, theta)

    def velocity(share):
        moved = np.append(q, theta) + share * motion
        return slopes(opening, moved[:-1], moved[-1]) @ motion

    def difference(h):
        return (velocity(h) - velocity(-h)) / (2.0 * h)

    bias = (4.0 * difference(1e-6) - difference(2e-6)) / 3.0  # accelerations while the coordinates do not accelerate
    masses = np.array([LINKS.crank_mass, LINKS.rod_mass, LINKS.slider_mass])
    gravity = np.array([0.0, -LINKS.gravity])
    mass = np.einsum("b,bxi,bxj->ij", masses, jacobian[:3], jacobian[:3])
    mass[0, 0] += LINKS.rod_inertia
    right = np.einsum("b,bxi,bx->i", masses, jacobian[:3], gravity - bias[:3])
    turned = {"A": (None, n), "B": (n, 0), "C": (0, None)}  # coordinates that are angles of proximal and distal body
    for joint, load in zip(opening, loads, strict=True):
        right += np.array([load.fx, load.fy]) @ jacobian[3 + "ABC".index(joint)]
        for place_, moment in zip(turned[joint], (load.moment_proximal, load.moment_distal), strict=True):
            if place_ is not None:
                right[place_] += moment
    accelerations = np.linalg.solve(mass[:n, :n], right[:n])
    moved = jacobian[:, :, :n] @ accelerations + bias
    return accelerations, mass[n, :n] @ accelerations - right[n], moved


def seen(mechanism, y, opening, motion):
    """Return coordinates and rates as `positions` has them, from what a machine says of its bodies."""
    crank, rod, slider = np.reshape(describe(mechanism, y, pose_at(mechanism, y), motion)[6:], (3, 6))
    l1, turned = LINKS.crank_center, (np.cos(crank[4]), np.sin(crank[4]))
    pivot = crank[:2] - l1 * np.array(turned)
    swept = crank[2:4] - l1 * crank[5] * np.array([-turned[1], turned[0]])
    q, v = [rod[4], slider[0]], [rod[5], slider[2]]
    if opening in (("B", "C"), ("A", "B", "C")):
        q, v = [*q, *rod[:2]], [*v, *rod[2:4]]
    if "A" in opening and len(opening) > 1:
        q, v = [*q, *pivot], [*v, *swept]
    return np.array(q), np.array(v), crank[4]


@pytest.mark.parametrize("opening", OPENINGS, ids="".join)
def test_a_slider_crank_moves_as_virtual_powers_say(opening):
    chance = np.random.default_rng(7)
    names = dict(zip("ABC", ("ground-crank", "crank-rod", "rod-slider"), strict=True))
    opened = dict.fromkeys(names[joint] for joint in opening)
    for _ in range(5):
        built = planar.build(MACHINE, opened, {name: 1e-4 * chance.normal(size=2) for name in opened})
        mechanism, y, n = built.value, built.start.copy(), 2 * len(opening)
        y[:n] += 0.02 * chance.normal(size=n)
        y[n : 2 * n] += chance.normal(size=n) * 10.0
        y[-1] = chance.uniform(0.0, 0.02)
        numbers = chance.uniform(-1.0, 1.0, (len(opening), 4)) * [1000.0, 1000.0, 5.0, 5.0]
        loads = tuple(Load(*row) for row in numbers)
        pose = pose_at(mechanism, y)
        motion = accelerate(mechanism, pose, loads)
        q, v, theta = seen(mechanism, y, opening, motion)
        accelerations, torque, moved = expected(opening, q, v, theta, loads)
        assert motion.output == pytest.approx(accelerations[1], rel=1e-7, abs=1e-7 * abs(accelerations).max())
        assert motion.torque == pytest.approx(torque, rel=1e-6, abs=1e-6)
        rows = [3 + "ABC".index(joint) for joint in opening]
        result = np.array([item[:2] for item in gap_accelerations(mechanism, y, motion)])
        assert result == pytest.approx(moved[rows], rel=1e-6, abs=1e-7 * abs(moved).max())
        where, rates = positions(opening, q, theta), slopes(opening, q, theta) @ np.append(v, LINKS.speed)
        for row, gap in zip(rows, gaps(mechanism, pose), strict=True):
            assert [gap.x, gap.y, gap.vx, gap.vy] == pytest.approx([*where[row], *rates[row]], rel=1e-11, abs=1e-11)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_the_powers_on_both_bodies_leave_the_couple_of_two_contact_points(side):
    """Also against the two bodies turning as one: what they slide at is the penetration times their rate."""
    joint = Joint(5e-4, 0.01, 0.0095, side, Lossless(), PowerThreeHalves(1e9), Tanh(0.3, 1e-3), ())
    pen, spin = 2e-5, (70.0, -20.0)
    gap = Gap(3.12e-4, 4.16e-4, 0.2, -0.4, *spin)
    first = joint_load(joint, gap, PRESSED, pen, 0.1)
    (contact,) = first.contacts
    power = first.fx * gap.vx + first.fy * gap.vy + first.moment_proximal * spin[0] + first.moment_distal * spin[1]
    taken = -contact.normal * contact.rate + contact.tangential * contact.slip
    assert power == pytest.approx(taken, rel=1e-12, abs=0.0)
    couple = gap.x * first.fy - gap.y * first.fx + first.moment_proximal + first.moment_distal
    assert couple == pytest.approx(pen * contact.tangential, rel=1e-9, abs=0.0)
    rigid = gap._replace(vx=-50.0 * gap.y, vy=50.0 * gap.x, spin_proximal=50.0, spin_distal=50.0)
    (contact,) = joint_load(joint, rigid, PRESSED, pen, 0.1).contacts
    assert contact.slip == pytest.approx(50.0 * pen, rel=1e-9, abs=0.0)


# Formulas of a program keep their order and grouping, share what is equal and leave out what is zero.


NAMES = ("a", "b", "c", "d")
FORMULAS = {
    "left to right": (lambda a, b, c, d: a + b + c + d, "(((a + b) + c) + d)"),
    "grouped sums": (lambda a, b, c, d: a + (b + c), "(a + (b + c))"),
    "difference": (lambda a, b, c, d: a - (b - c), "(a - (b - c))"),
    "product": (lambda a, b, c, d: a * b * c, "((a * b) * c)"),
    "grouped product": (lambda a, b, c, d: a * (b * c), "(a * (b * c))"),
    "sum of products": (lambda a, b, c, d: a * b - c * d, "((a * b) - (c * d))"),
    "minus a product": (lambda a, b, c, d: -(a * b) - -(c * d), "((-a * b) + (c * d))"),
    "minus a factor": (lambda a, b, c, d: a * -b, "(a * -b)"),
    "sum as a factor": (lambda a, b, c, d: (a + b) * (c + d), "((a + b) * (c + d))"),
    "reciprocal": (lambda a, b, c, d: 1.0 / (a * b), "(1.0 / (a * b))"),
    "number": (lambda a, b, c, d: 2.0 * a * b, "((2.0 * a) * b)"),
    "many terms": (lambda a, b, c, d: sum_of([a, -b, c * d]), "((a - b) + (c * d))"),
    "zero": (lambda a, b, c, d: a * ZERO + b * ONE - ZERO, "b"),
    "shared": (lambda a, b, c, d: (a + b) * c + (a + b) * d, "(((a + b) * c) + ((a + b) * d))"),
}


class Written:
    """A number that writes down the operations on it, and counts those of all numbers."""

    operations = 0

    def __init__(self, text):
        self.text = text

    def _join(self, sign, other):
        Written.operations += 1
        left, right = (x.text if isinstance(x, Written) else repr(x) for x in (self, other))
        return Written(f"({left} {sign} {right})")

    def __add__(self, other):
        return self._join("+", other)

    def __sub__(self, other):
        return self._join("-", other)

    def __mul__(self, other):
        return self._join("*", other)

    def __rmul__(self, other):
        return Written(repr(other))._join("*", self)

    def __rtruediv__(self, other):
        return Written(repr(other))._join("/", self)

    def __neg__(self):
        return Written(f"-{self.text}")


def program_of(formula):
    """Return the program of a formula of a, b, c and d."""
    program = Program(4)
    return program.returns(formula(*program.parameters))


@pytest.mark.parametrize("name", FORMULAS)
def test_a_formula_is_evaluated_in_its_own_order(name):
    formula, text = FORMULAS[name]
    assert program_of(formula)(*map(Written, NAMES)).text == text


def test_equal_expressions_are_evaluated_once():
    Written.operations = 0
    program_of(FORMULAS["shared"][0])(*map(Written, NAMES))
    assert Written.operations == 4  # one sum of a and b, two products, their sum


def test_what_nothing_needs_is_not_evaluated():
    program = Program(2)
    a, b = program.parameters
    _ = 1.0 / b
    assert program.returns((a * a, ZERO))(3.0, 0.0) == (9.0, 0.0)


def drawn(count):
    """Return four numbers of very different sizes, `count` times."""
    draw = random.Random(7)
    return [[draw.uniform(-1.0, 1.0) * 10.0 ** draw.randrange(-12, 12) for _ in NAMES] for _ in range(count)]


@pytest.mark.parametrize("name", [name for name in FORMULAS if name not in ("zero", "many terms")])
def test_a_program_has_every_bit_of_the_formula(name):
    formula, _ = FORMULAS[name]
    program = program_of(formula)
    for numbers in drawn(300):
        assert program(*numbers) == formula(*numbers)


@pytest.mark.parametrize("name", ["sum of products", "sum as a factor", "shared", "reciprocal"])
def test_machine_code_has_the_bits_of_a_traced_body(name):
    formula, _ = FORMULAS[name]
    program = program_of(formula)

    def run(a, b, c, d):
        return program(a, b, c, d)

    def body(a, b, c, d):
        return run(a, b, c, d)

    register_emitter(run)(program.emit)
    both = [objects.machine_code(function) for function in (body, formula)]
    for numbers in drawn(20):
        assert both[0](*numbers) == both[1](*numbers)


def test_a_program_is_differentiated():
    program = program_of(lambda a, b, c, d: a * b - 1.0 / (c * d))
    a, b, c, d = 0.3, -1.2, 0.7, 2.0
    slope = program(Dual(a, 1.0), b, Dual(c, 1.0), d).slope
    assert slope == pytest.approx(b + 1.0 / (c * c * d), rel=1e-14)


def test_vectors_in_the_plane_rotate_and_multiply():
    program = Program(4)
    c, s, x, y = program.parameters
    vector = PlaneVector(x, y)
    rotated = vector.rotated(c, s)
    program.returns((rotated.x, rotated.y, vector.dot(rotated), vector.cross(rotated)))
    angle, (x, y) = 0.7, (0.3, -1.2)
    rx, ry, scalar, normal = program(math.cos(angle), math.sin(angle), x, y)
    square = x * x + y * y
    assert (scalar, normal) == pytest.approx((square * math.cos(angle), square * math.sin(angle)), rel=1e-14)
    assert complex(rx, ry) == pytest.approx(complex(x, y) * complex(math.cos(angle), math.sin(angle)), rel=1e-14)


def test_zero_vectors_leave_no_operations():
    a = SpatialVector(Program(1).parameters[0])
    assert (a + NO_VECTOR, NO_VECTOR + a, a - NO_VECTOR) == (a, a, a)
    assert a.cross(NO_VECTOR) == 2.0 * NO_VECTOR == NO_VECTOR


def test_ldl_factors_solve_a_symmetric_system():
    size, draw = 4, random.Random(3)
    root = [[draw.uniform(-1.0, 1.0) for _ in range(size)] for _ in range(size)]
    matrix = [[sum(a * b for a, b in zip(p, q, strict=True)) + (p is q) for q in root] for p in root]
    program = Program(2)
    m, r = program.parameters
    factors = LDL(range(size), lambda i, j: m[i][j])
    solution = factors.solve({i: r[i] for i in range(size)})
    program.returns(tuple(solution[i] for i in range(size)))
    right = np.array([draw.uniform(-1.0, 1.0) for _ in range(size)])
    assert matrix @ np.array(program(matrix, right)) == pytest.approx(right, rel=1e-12)
