"""Bodies that a tracer could compile to other results than Python's: they give these, or are refused with a place."""

import ast
import importlib
import math
import sys
from typing import NamedTuple

import numpy as np
import pytest

from clearsweep.tracing import activation
from clearsweep.tracing.objects import machine_code
from clearsweep.tracing.symbols import NotTraceableError

WRITTEN, K, TABLE = {}, 2.0, np.array([10.0, 20.0, 30.0])
SMALL, TRUTHS = np.array([0.1], dtype=np.float32), np.array([True, False])
TWO_ON_A_LINE = (lambda a, b: a * 10.0, lambda a, b: b + 1.0)
CONSTANTS = (lambda a, b: 4.0, lambda a, b: 5.0, lambda a, b: a * TABLE[0])


class Pair(NamedTuple):
    x: float
    y: float

    @property
    def larger(self):
        return self.x if self.x > self.y else self.y

    def scaled(self, factor):
        return self.larger * factor


class Vector(NamedTuple):
    x: float

    def __add__(self, other):
        return Vector(self.x + other.x if self.x > 0.0 else 0.0)


def either(a, b):
    return a or b, a and b, (a and b) or 3.0, not (a or b), 5.0 if (a and b) else 6.0


def whole_quotients(a, b):
    return int(a) // int(b), int(a) % int(b), int(a) // -2, int(a) % -3, 17 % int(b)


def quotient_by_need(a, b):
    return 7 // int(a) if int(a) != 0 and 7 // int(a) > 1 else 0


def second_lambda_of_a_line(a, b):
    return TWO_ON_A_LINE[1](a, b), TWO_ON_A_LINE[0](a, b)


def order_of_truths(a, b):
    return (a > 0.0) < (b > 0.0), (a > 0.0) >= (b > 0.0), (a > 0.0) << 1, +(a > 0.0), abs(a > 0.0), bool(a) + 1


def untraced_helper(a, b):
    return _helper(a) + _helper(b)


def _helper(x):
    return 7.0 if x == 0.0 or x in (1.0, 5.0) else x


def keyword_only(a, b):
    return _scaled(a), _scaled(a, factor=b), _scaled(x=b)


def _scaled(x, *, factor=3.0):
    return factor * x


def from_the_end(a, b):
    return (10.0, 20.0, 30.0)[-abs(int(a)) % 3 - 3], TABLE[-1 - abs(int(a)) % 3], TABLE[-1]


def whole_powers(a, b):
    return int(a) ** 20, int(b) ** 0, a**2, a**0, 2.0 ** int(b)


def methods(a, b):
    return Pair(a, b).larger + Pair(a, b).scaled(2.0), Pair(a, b)._replace(x=b).larger


def default_of_a_lambda(a, b):
    raised = lambda x, k=5.0: x + k  # noqa: E731
    return raised(a), raised(a, k=b)


def shifts(a, b):
    return 5 << abs(int(b)), 1000 >> abs(int(a)), -1 >> 40 + abs(int(b))


def item_by_a_truth(a, b):
    return (a, b)[a > b]


@pytest.mark.parametrize(
    "body",
    [
        either,
        whole_quotients,
        quotient_by_need,
        second_lambda_of_a_line,
        order_of_truths,
        untraced_helper,
        keyword_only,
        from_the_end,
        whole_powers,
        methods,
        default_of_a_lambda,
        shifts,
        item_by_a_truth,
    ],
)
def test_a_body_gives_what_it_gives_in_python(body):
    compiled = machine_code(body)
    for a, b in ((1.0, 2.0), (2.0, 3.0), (-7.0, 2.0), (7.0, -2.0), (0.0, 5.0), (3.0, 3.0)):
        assert compiled(a, b) == body(a, b)


def item_of_a_list_in_a_branch(a, b):
    items = [a]
    if a > b:
        items[0] = 5.0  # here
    return items[0]


def list_that_grows(a, b):
    items = [a]
    items.append(b)  # here
    return items[1]


def list_in_place(a, b):
    items = other = [a]
    items += [b]  # here
    return len(other) * a


def dict_of_a_module(a, b):
    WRITTEN["a"] = a  # here
    return b


def item_of_a_table(a, b):
    TABLE[0] = 1.0  # here
    return a


def loop_with_else(a, b):
    while 0.0 < a < b:  # here
        a *= 2.0
        if a > 100.0:
            break
    else:
        a = -1.0
    return a


def local_name_of_a_global(a, b):
    if a > b:
        K = 3.0
    return K  # here


def list_through_a_loop(a, b):
    items = [a]
    for _ in range(5):
        items = [items[0] + 1.0]  # here
    return items[0]


def nothing_through_a_loop(a, b):
    last = None
    for _ in range(4):
        last = a if last is None else last + b  # here
    return last


def type_of_a_number(a, b):
    return a if isinstance(a, float) else b  # here


def text_of_values(a, b):
    return a if f"{1}" == "1" else b  # here


def generator_used_twice(a, b):
    products = (x * a for x in (1.0, 2.0))  # here
    return max(products) + b


def too_many_arguments(a, b):
    return _helper(a, b)  # here


def floats_divided(a, b):
    return a // b  # here


def integer_to_an_unknown_power(a, b):
    return 2 ** int(a)  # here


def sum_of_numbers(a, b):
    return sum([a, b])  # here


def equal_tuples(a, b):
    return a if (a, b) == (1.0, 2.0) else b  # here


def lambda_of_a_comprehension(a, b):
    functions = [lambda x: x + i for i in range(3)]  # noqa: B023 # here
    return functions[0](a)


def same_object(a, b):
    return a if (a > 0.0) is True else b  # here


def effect(a, b):
    print(a)  # here
    return b


def single_precision(a, b):
    return SMALL[0] * a  # here


def table_of_truths(a, b):
    return a if TRUTHS[int(a)] else b  # here


def range_of_floats(a, b):
    for _ in range(a):  # here
        b += 1.0
    return b


def large_integer(a, b):
    return a if int(a) < 2**70 else b  # here


def operator_of_a_class(a, b):
    return (Vector(a) + Vector(b)).x  # here


def library_function(a, b):
    return math.gamma(a)  # here


def rounded(a, b):
    return round(a)  # here


REFUSED = [
    item_of_a_list_in_a_branch,
    list_that_grows,
    list_in_place,
    dict_of_a_module,
    item_of_a_table,
    loop_with_else,
    local_name_of_a_global,
    list_through_a_loop,
    nothing_through_a_loop,
    type_of_a_number,
    text_of_values,
    generator_used_twice,
    too_many_arguments,
    floats_divided,
    integer_to_an_unknown_power,
    sum_of_numbers,
    equal_tuples,
    lambda_of_a_comprehension,
    same_object,
    effect,
    single_precision,
    table_of_truths,
    range_of_floats,
    large_integer,
    operator_of_a_class,
    library_function,
    rounded,
]


@pytest.mark.parametrize("body", REFUSED, ids=lambda body: body.__name__)
def test_a_body_is_refused_with_file_line_and_statement(body):
    with open(__file__, encoding="utf-8") as stream:
        lines = stream.read().splitlines()
    first = body.__code__.co_firstlineno
    line = next(n for n in range(first, first + 9) if lines[n - 1].endswith("# here"))
    with pytest.raises(NotTraceableError) as caught:
        machine_code(body)(1.0, 2.0)
    message = str(caught.value)
    assert message.startswith(f"{__file__}:{line}: {body.__name__} cannot be traced: it ")
    assert message.endswith(lines[line - 1].strip())
    assert "a" not in WRITTEN


def test_the_callers_of_a_refused_statement_are_named():
    def calls_it(a, b):
        return rounded(a, b) + 1.0

    with pytest.raises(NotTraceableError) as caught:
        machine_code(calls_it)(1.0, 2.0)
    first, second = str(caught.value).splitlines()
    assert "rounded cannot be traced: it calls round" in first
    assert second.endswith("called by calls_it: return rounded(a, b) + 1.0")


@pytest.mark.parametrize("table", [None, b""], ids=["with positions", "without positions"])
def test_lambdas_of_one_line_are_told_apart_by_what_they_return(table):
    """Python 3.12 keeps no position of a constant that is returned, and no_debug_ranges none at all."""
    for body, expected in zip(CONSTANTS, ("4.0", "5.0", "a * TABLE[0]"), strict=True):
        code = body.__code__ if table is None else body.__code__.replace(co_linetable=table)
        assert ast.unparse(activation.syntax_tree(code).body) == expected


@pytest.fixture
def module_of(tmp_path, monkeypatch):
    """Return a function that imports a module with a text, and its path."""
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(sys, "dont_write_bytecode", True)

    def write(name, text):
        path = tmp_path / f"{name}.py"
        path.write_text(text)
        importlib.invalidate_caches()
        return importlib.import_module(name), path

    return write


def test_a_source_that_changed_since_its_import_is_not_traced(module_of):
    module, path = module_of("law_that_is_edited", "SCALE = 2.0\n\n\ndef law(x):\n    return SCALE * x\n")
    path.write_text(path.read_text().replace("SCALE * x", "SCALE * x * x"))
    with pytest.raises(NotTraceableError, match="source on disk is no longer what Python runs: start Python again"):
        machine_code(module.law)(3.0)


def test_an_assertion_is_checked_while_tracing_or_refused(module_of):
    text = (
        "K = 2\n\n\ndef law(x):\n    assert K > 1\n    return x\n\n\ndef other(x):\n    assert x > 1.0\n    return x\n"
    )
    module, path = module_of("law_with_assertion", text)
    assert machine_code(module.law)(3.0) == 3.0
    with pytest.raises(NotTraceableError) as caught:
        machine_code(module.other)(3.0)
    message = f"{path}:10: other cannot be traced: it asserts what is known only at run time"
    assert str(caught.value).startswith(message)


def test_a_generator_or_a_global_statement_is_refused_wherever_it_stands(module_of):
    text = "def law(x):\n    if x is None:\n        yield x\n    return x\n"
    module, _ = module_of("law_that_yields", text)
    with pytest.raises(NotTraceableError, match="which is a generator"):
        machine_code(module.law)(3.0)
    module, _ = module_of("law_with_global", text.replace("yield x", "global S"))
    with pytest.raises(NotTraceableError, match="has a global statement in line 3"):
        machine_code(module.law)(3.0)


def test_arrays_are_of_doubles_or_integers_and_share_no_memory():
    def moved(source, target):
        target[0] = 1.0
        return source[0] + target[-1]

    array = np.array([3.0, 4.0])
    with pytest.raises(TypeError, match="share memory"):
        machine_code(moved)(array, array)
    with pytest.raises(TypeError, match="float32"):
        machine_code(moved)(array.astype(np.float32), np.zeros(2))
    target = np.array([5.0, 6.0])
    assert machine_code(moved)(array, target) == 9.0
    assert target.tolist() == [1.0, 6.0]


def test_parts_of_arrays_are_those_of_python():
    def parts(x):
        first, last, middle = x[:-1], x[-2:], x[1:99]
        return first[-1], len(first), last[0], middle[0], middle[-1], x.reshape(2, 3)[1, 0], x.size

    x = np.arange(6.0)
    assert machine_code(parts)(x) == parts(x)
    with pytest.raises(NotTraceableError, match="every n-th item"):
        machine_code(lambda x: x[::2][1])(x)
