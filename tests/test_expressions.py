"""Formulas of a program keep their order and grouping, share what is equal and leave out what is zero."""

import math
import random

import numpy as np
import pytest

from clearsweep.mechanics.machines.planar.kinematics import PlaneVector
from clearsweep.mechanics.machines.programs import LDL
from clearsweep.mechanics.machines.spatial.kinematics import NO_VECTOR, SpatialVector
from clearsweep.tracing import objects
from clearsweep.tracing.compiled.dual import Dual
from clearsweep.tracing.compiled.formulas import ONE, ZERO, Program, sum_of
from clearsweep.tracing.protocols import register_emitter

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
