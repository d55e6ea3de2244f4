"""Small bodies written at random: machine code does what Python does."""

import functools
import itertools
import linecache

import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st
from test_trace_bodies import machine

from clearsweep.tracing.compiled.family import kernel
from clearsweep.tracing.objects import machine_code
from clearsweep.tracing.symbols import WIDTH, NotTraceableError

NUMBERS = st.sampled_from([0.0, -0.0, 1.0, -1.0, 0.5, 2.0, -3.0, 7.25, 1e3])
FLOATS, WHOLE = ("a", "b", "x", "y"), ("i", "j")
_COUNT = itertools.count()


def indented(lines):
    return [f"    {line}" for line in lines]


def expressions(leaf, extend):
    return st.recursive(leaf, extend, max_leaves=6)


WHOLE_NUMBERS = st.deferred(
    lambda: expressions(
        st.sampled_from([*WHOLE, "0", "1", "3", "-2", "int(x)", "int(a)"]),
        lambda e: st.one_of(
            st.builds("({} {} {})".format, e, st.sampled_from(["+", "-", "*", "&", "|", "^"]), e),
            st.builds("({} {} ({} or 3))".format, e, st.sampled_from(["//", "%"]), e),
            st.builds("({} and {} or {})".format, e, e, e),
            st.builds("({} ** 2)".format, e),
            st.builds("(-{})".format, e),
            st.builds("abs({})".format, e),
            st.builds("(({} & 7) << 2 >> 1)".format, e),
            st.builds("({} + (x > {}))".format, e, e),
        ),
    )
)
CONDITIONS = st.deferred(
    lambda: expressions(
        st.one_of(
            st.builds("{} {} {}".format, VALUES, st.sampled_from(["<", "<=", ">", ">=", "==", "!="]), VALUES),
            st.builds("{} < {} <= {}".format, VALUES, VALUES, VALUES),
            st.builds("{} in ({}, {})".format, VALUES, VALUES, VALUES),
            st.builds("{} {} {}".format, WHOLE_NUMBERS, st.sampled_from(["<", "==", "!="]), WHOLE_NUMBERS),
            st.builds("({} > {}) {} ({} > x)".format, VALUES, VALUES, st.sampled_from(["<", "==", "!=", ">="]), VALUES),
            VALUES,
        ),
        lambda e: st.one_of(
            st.builds("({} {} {})".format, e, st.sampled_from(["and", "or"]), e),
            st.builds("(not {})".format, e),
        ),
    )
)
VALUES = st.deferred(
    lambda: expressions(
        st.sampled_from([*FLOATS, "0.0", "1.5", "-2.0", "float(i)"]),
        lambda e: st.one_of(
            st.builds("({} {} {})".format, e, st.sampled_from(["+", "-", "*"]), e),
            st.builds("({} / (1.0 + {} * {}))".format, e, e, e),
            st.builds("({} {} {})".format, e, st.sampled_from(["and", "or"]), e),
            st.builds("({} if {} > {} else {})".format, e, e, e, e),
            st.builds("{}({}, {})".format, st.sampled_from(["min", "max"]), e, e),
            st.builds("{}(({}, {}, {}))".format, st.sampled_from(["min", "max"]), e, e, e),
            st.builds("({}, {}, {})[{} % 3]".format, e, e, e, WHOLE_NUMBERS),
            st.builds("({}, {})[{} > {}]".format, e, e, e, e),
            st.builds("(lambda u, v=1.0: u - v)({})".format, e),
            st.builds("abs({})".format, e),
            st.builds("(-{})".format, e),
            st.builds("twice({})".format, e),
        ),
    )
)


@st.composite
def blocks(draw, depth=2, is_loop=False):
    """Return the lines of some statements."""
    lines = []
    for _ in range(draw(st.integers(1, 3))):
        kinds = ["float", "whole", "augmented", "pair", *(["if", "for", "range", "while"] if depth else [])]
        kinds += ["break", "continue"] if is_loop else []
        kinds += ["return"]
        kind = draw(st.sampled_from(kinds))
        inner = functools.partial(draw, blocks(depth - 1, is_loop))
        if kind == "float":
            lines.append(f"{draw(st.sampled_from(('x', 'y')))} = {draw(VALUES)}")
        elif kind == "whole":
            lines.append(f"{draw(st.sampled_from(WHOLE))} = ({draw(WHOLE_NUMBERS)}) % 1000")
        elif kind == "augmented":
            lines.append(f"x {draw(st.sampled_from(['+', '-', '*']))}= {draw(VALUES)}")
        elif kind == "pair":
            lines.append(f"x, y = {draw(VALUES)}, {draw(VALUES)}")
        elif kind == "if":
            lines += [f"if {draw(CONDITIONS)}:", *indented(inner())]
            if draw(st.booleans()):
                lines += ["else:", *indented(inner())]
        elif kind in ("for", "range"):
            values = draw(st.sampled_from(["(1.0, -2.0, 0.5)", "(a, b)"]))
            bounds = draw(st.sampled_from(["3", "abs(i) % 4", "1, 4", "3, 0, -1", "abs(j) % 3, 5, 2"]))
            name = draw(st.sampled_from(WHOLE))
            header = f"for y in {values}:" if kind == "for" else f"for {name} in range({bounds}):"
            lines += [header, *indented(draw(blocks(depth - 1, True)))]
        elif kind == "while":
            name = f"n{depth}"  # a loop within must not begin the count anew
            body = draw(blocks(depth - 1, True))
            lines += [f"{name} = 0", f"while {name} < 4 and {draw(CONDITIONS)}:", f"    {name} += 1", *indented(body)]
        else:
            statement = f"return {draw(VALUES)}, y, i, j" if kind == "return" else kind
            lines += [f"if {draw(CONDITIONS)}:", f"    {statement}"]
    return lines


def function_of(lines, result="x, y, i, j"):
    """Return the function with this body, whose source tracebacks and the tracer can read."""
    text = "\n".join(
        [
            "def twice(u):",
            "    if u > 1.0:",
            "        return u",
            "    return u + u",
            "",
            "def body(a, b):",
            "    x, y, i, j = a, b, 3, int(b)",
            *indented(lines),
            f"    return {result}",
        ]
    )
    path, names = f"<body {next(_COUNT)}>", {}
    linecache.cache[path] = (len(text), None, [f"{line}\n" for line in text.splitlines()], path)
    exec(compile(text, path, "exec"), names)
    return names["body"]


def same(ours, theirs):
    if isinstance(theirs, tuple):
        return isinstance(ours, tuple) and len(ours) == len(theirs) and all(map(same, ours, theirs))
    if theirs != theirs:  # noqa: PLR0124 - nan
        return ours != ours  # noqa: PLR0124
    return ours == pytest.approx(theirs, rel=1e-9, abs=1e-9)


@given(blocks(), NUMBERS, NUMBERS)
@settings(max_examples=60)
@example(["x = a or b", "y = a and b", "i = i and j"], 2.0, 3.0)
@example(["i = j // -2", "j = j % -3"], 7.0, 7.0)
@example(["i = (a > 0.0) < (b > 0.0)"], -1.0, 2.0)
@example(["for i in range(3):", "    if a > b:", "        break", "    x += i"], 1.0, 2.0)
def test_a_random_body_is_machine_code_that_does_what_python_does(lines, a, b):
    body = function_of(lines)
    try:
        expected = body(a, b)
    except ZeroDivisionError:
        assume(False)
    try:
        result = machine_code(body)(a, b)
    except NotTraceableError as error:
        assume("a loop without iterations" not in str(error))  # is refused; everything else has to be machine code
        raise
    assert same(result, expected), "\n".join(lines)


EIGHT = st.lists(NUMBERS, min_size=WIDTH, max_size=WIDTH)


@given(blocks(), EIGHT, EIGHT)
@settings(max_examples=15)
@example(["for y in (a, b):", "    if x > 1.0:", "        return x, y, i, j", "    x += y"], [0.5, 2.0] * 4, [1.0] * 8)
def test_a_random_body_does_in_each_lane_what_python_does(lines, a, b):
    """Or it is refused: loops whose ends differ from lane to lane are only partly supported."""
    lines = [line.replace("return ", "return one_number(").replace(", y, i, j", ")") for line in lines]
    body = function_of(lines, "one_number(x + 2.0 * y + 3.0 * i + 5.0 * j)")
    body.__globals__["one_number"] = float
    try:
        expected = [body(*pair) for pair in zip(a, b, strict=True)]
    except ZeroDivisionError:
        assume(False)
    try:
        result = machine(kernel(body), WIDTH)(np.array(a), np.array(b))
    except NotTraceableError:
        assume(False)
    assert same(tuple(result.tolist()), tuple(expected)), "\n".join(lines)
