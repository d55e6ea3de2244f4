"""Formulas write code in which the order and grouping of operations are those of the formula."""

import math
import random

import pytest

from clearsweep.mechanics.machines.planar.expressions import ONE, ZERO, FunctionCode, PlaneVector, sum_of
from clearsweep.mechanics.machines.planar.ldl import LDL
from clearsweep.mechanics.machines.spatial.expressions import NO_VECTOR, SpatialVector

NAMES = ("a", "b", "c", "d")
FORMULAS = {
    "left to right": (lambda a, b, c, d: a + b + c + d, ["v0 = a + b", "v1 = v0 + c", "v2 = v1 + d", "return v2"]),
    "grouped sums": (lambda a, b, c, d: a + (b + c), ["v0 = b + c", "v1 = a + v0", "return v1"]),
    "difference": (lambda a, b, c, d: a - (b - c), ["v0 = b - c", "v1 = a - v0", "return v1"]),
    "product": (lambda a, b, c, d: a * b * c, ["return a * b * c"]),
    "grouped product": (lambda a, b, c, d: a * (b * c), ["v0 = b * c", "return a * v0"]),
    "sum of products": (lambda a, b, c, d: a * b - c * d, ["v0 = a * b - c * d", "return v0"]),
    "minus a product": (lambda a, b, c, d: -(a * b) - -(c * d), ["v0 = -a * b + c * d", "return v0"]),
    "minus a factor": (lambda a, b, c, d: a * -b, ["v0 = -b", "return a * v0"]),
    "sum as a factor": (lambda a, b, c, d: (a + b) * (c + d), ["v0 = a + b", "v1 = c + d", "return v0 * v1"]),
    "reciprocal": (lambda a, b, c, d: 1.0 / (a * b), ["v0 = a * b", "v1 = 1.0 / v0", "return v1"]),
    "number": (lambda a, b, c, d: 2.0 * a * b, ["v0 = 2.0", "return v0 * a * b"]),
    "many terms": (lambda a, b, c, d: sum_of([a, -b, c * d]), ["v0 = a - b + c * d", "return v0"]),
    "zero": (lambda a, b, c, d: a * ZERO + b * ONE - ZERO, ["return b"]),
    "shared": (lambda a, b, c, d: (a + b) * c + (a + b) * d, ["v0 = a + b", "v1 = v0 * c + v0 * d", "return v1"]),
}


def written(formula):
    """Return the code of a formula of a, b, c and d."""
    code = FunctionCode(*NAMES)
    return code.function("f", formula(*map(code.expression, NAMES)))


@pytest.mark.parametrize("name", FORMULAS)
def test_a_formula_is_written_in_its_own_order(name):
    formula, lines = FORMULAS[name]
    assert [line.strip() for line in written(formula).splitlines()[1:]] == lines


@pytest.mark.parametrize("name", [name for name in FORMULAS if name != "zero"])
def test_the_code_has_every_bit_of_the_formula_in_floats(name):
    formula, _ = FORMULAS[name]
    if name == "many terms":

        def formula_in_floats(a, b, c, d):
            return a - b + c * d
    else:
        formula_in_floats = formula
    functions = {}
    exec(written(formula), functions)
    draw = random.Random(7)
    for _ in range(300):
        numbers = [draw.uniform(-1.0, 1.0) * 10.0 ** draw.randrange(-12, 12) for _ in NAMES]
        assert functions["f"](*numbers) == formula_in_floats(*numbers)


def test_vectors_in_the_plane_rotate_and_multiply():
    code = FunctionCode("c", "s", "x", "y")
    c, s, x, y = map(code.expression, code.arguments)
    vector = PlaneVector(x, y)
    rotated = vector.rotated(c, s)
    functions = {}
    exec(code.function("f", f"({rotated.x}, {rotated.y}, {vector.dot(rotated)}, {vector.cross(rotated)})"), functions)
    angle, (x, y) = 0.7, (0.3, -1.2)
    rx, ry, scalar, normal = functions["f"](math.cos(angle), math.sin(angle), x, y)
    square = x * x + y * y
    assert (scalar, normal) == pytest.approx((square * math.cos(angle), square * math.sin(angle)), rel=1e-14)
    assert complex(rx, ry) == pytest.approx(complex(x, y) * complex(math.cos(angle), math.sin(angle)), rel=1e-14)


def test_zero_vectors_leave_no_code():
    code = FunctionCode("a")
    a = SpatialVector("a", code)
    assert (a + NO_VECTOR, NO_VECTOR + a, a - NO_VECTOR) == (a, a, a)
    assert a.cross(NO_VECTOR) == 2.0 * NO_VECTOR == NO_VECTOR
    assert code.lines == []


def test_ldl_factors_solve_a_symmetric_system():
    size, draw = 4, random.Random(3)
    root = [[draw.uniform(-1.0, 1.0) for _ in range(size)] for _ in range(size)]
    matrix = [[sum(a * b for a, b in zip(p, q, strict=True)) + (p is q) for q in root] for p in root]
    code = FunctionCode("m", "r")
    factors = LDL(range(size), lambda i, j: code.expression(f"m[{i}][{j}]"))
    solution = factors.solve({i: code.expression(f"r[{i}]") for i in range(size)})
    functions = {}
    exec(code.function("f", f"({', '.join(str(solution[i]) for i in range(size))})"), functions)
    right = [draw.uniform(-1.0, 1.0) for _ in range(size)]
    unknown = functions["f"](matrix, right)
    assert [sum(a * x for a, x in zip(row, unknown, strict=True)) for row in matrix] == pytest.approx(right, rel=1e-12)
