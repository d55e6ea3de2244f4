"""Functions made of formulas: a `Program` records the operations of formulas once, then runs them on any numbers.

An `Expr` is a value of a program, and operators on it record operations.  A sum is evaluated once, a product when it
becomes a term's factor on the right or is used by itself.  Equal expressions are one value, and zero terms, zero
factors and factors of one are left out.  Operations keep the order and the grouping of the formula: `a * b * c` is
(a b) c, `a * (b * c)` computes b c first; so the result is fixed to the last bit.

Floats and numbers with slopes are computed by Python.  On symbols, the operations are emitted as those of one traced
body, so a sum is fused with a product of the same program.
"""

import ast
import functools
import operator
from collections.abc import Callable, Hashable, Iterable, Iterator
from typing import Any, NamedTuple

from ..activation import Activation
from ..calls import call, run
from ..expressions import Expressions
from ..protocols import has_slope, slope_rule

ATTRIBUTE, ITEM, CALL, SUM, INVERSE = range(5)  # kinds of operations


class Expr:
    """A value of a program: a result of an operation, a constant, or a product of these; it may be negative.

    Its attributes and items are values of the program, too.
    """

    __slots__ = ("factors", "negative", "program")
    __iter__ = None  # its items are not known

    def __init__(self, program: "Program | None", factors: tuple, negative: bool = False):
        """factors : places of results in the program, or known numbers; program : None for a known number."""
        self.program, self.factors, self.negative = program, factors, negative

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Expr) and self.key == other.key

    def __hash__(self) -> int:
        return hash(self.key)

    def __getattr__(self, name: str) -> "Expr":
        if name.startswith("_"):
            raise AttributeError(name)
        slot = self.slot
        return self.program.result(ATTRIBUTE, name, slot) if type(slot) is _Slot else constant(getattr(slot, name))

    def __getitem__(self, index: int) -> "Expr":
        slot = self.slot
        return self.program.result(ITEM, index, slot) if type(slot) is _Slot else constant(slot[index])

    @property
    def key(self) -> tuple:
        """Return what equal expressions share."""
        return self.negative, self.factors

    @property
    def slot(self) -> Any:
        """Return the slot of its value."""
        return self.assigned().factors[0]

    def assigned(self) -> "Expr":
        """Return this value as one result."""
        if self.program is None:
            return constant(-self.factors[0]) if self.negative else self
        if len(self.factors) == 1 and not self.negative:
            return self
        return self.program.result(SUM, None, (self.key,))

    def __neg__(self) -> "Expr":
        return self if self == ZERO else Expr(self.program, self.factors, not self.negative)

    def __add__(self, other: "Expr") -> "Expr":
        return sum_of((self, other))

    def __sub__(self, other: "Expr") -> "Expr":
        return sum_of((self, -other))

    def __mul__(self, other: "Expr") -> "Expr":
        if not isinstance(other, Expr):
            return NotImplemented
        if ZERO in (self, other):
            return ZERO
        left_factor = self if len(self.factors) > 1 else self.assigned()
        if other == ONE:
            return left_factor
        right_factor = other.assigned()
        if self == ONE:
            return right_factor
        factors = left_factor.factors + right_factor.factors
        return Expr(self.program or other.program, factors, left_factor.negative)

    def __rmul__(self, number: float) -> "Expr":
        return constant(number) * self

    def __rtruediv__(self, number: float) -> "Expr":
        if self.program is None:
            return constant(number / self.factors[0])
        return self.program.result(INVERSE, number, self.slot)


def constant(number: float) -> Expr:
    """Return a number that is known before the program runs."""
    return Expr(None, (number,))


ZERO, ONE = constant(0.0), constant(1.0)


def sum_of(terms: Iterable[Expr]) -> Expr:
    """Return the sum of terms, added from left to right."""
    present_terms = [term for term in terms if term != ZERO]
    if not present_terms:
        return ZERO
    if len(present_terms) == 1:
        return present_terms[0].assigned()
    program = next((term.program for term in present_terms if term.program), None)
    if program is None:
        return constant(sum(term.assigned().factors[0] for term in present_terms))
    return program.result(SUM, None, tuple(term.key for term in present_terms))


class _Operation(NamedTuple):
    """An operation of a program."""

    kind: int
    name: Any  # of an attribute, index of an item, function, or numerator of an inverse
    operands: Any  # places, or nested tuples of these
    slot: "_Slot"  # of the result


class Program:
    """A function without branches: operations in order, each on arguments and results of earlier ones."""

    def __init__(self, parameters: int):
        """Begin a program; parameters : their number."""
        self.parameters = tuple(Expr(self, (_Slot(i),)) for i in range(parameters))
        self._operations: list[_Operation] = []
        self._results: dict[Hashable, Expr] = {}  # by operation
        self._steps: list[tuple[int, Any, Any]] = []  # kind, name, operands by their places
        self._returned: Any = None

    def result(self, kind: int, name: Any, operands: Any) -> Expr:
        """Return the result of an operation, recorded unless it was before."""
        key = kind, name, operands
        if key not in self._results:
            slot = _Slot(len(self.parameters) + len(self._operations))
            self._operations.append(_Operation(*key, slot))
            self._results[key] = Expr(self, (slot,))
        return self._results[key]

    def known(self, value: Any) -> Expr:
        """Return a value that is known before the program runs."""
        return Expr(self, (value,))

    def call(self, function: Callable, *arguments: Any) -> Expr:
        """Return the result of a function; arguments : Exprs, known numbers, or nested tuples of these."""
        return self.result(CALL, function, _with_slots(arguments))

    def returns(self, value: Any) -> "Program":
        """Return this program, which returns a value: Exprs, known numbers, or nested tuples of these.

        Operations that it does not need are removed.
        """
        self._returned = _with_slots(value)
        needed, kept = set(_slots_in(self._returned)), []
        for operation in reversed(self._operations):
            if operation.slot in needed:
                needed.update(_slots_in(operation.operands))
                kept.append(operation)
        self._operations = kept[::-1]
        for place, operation in enumerate(self._operations, start=len(self.parameters)):
            operation.slot.place = place
        self._steps = [(kind, name, _step(kind, operands)) for kind, name, operands, _ in self._operations]
        return self

    def __call__(self, *arguments: Any) -> Any:
        """Return its value for floats and numbers with slopes."""
        return self._run(Known, arguments)

    def emit(self, *arguments: Any) -> Any:
        """Return its value for symbols, emitting the operations."""
        return self._run(Traced(), arguments)

    def _run(self, on: Any, arguments: tuple) -> Any:
        values, call = list(arguments), on.call
        for kind, name, operands in self._steps:
            if kind == SUM:
                value = _sum(on, values, operands)
            elif kind == ATTRIBUTE:
                value = getattr(values[operands], name)
            elif kind == ITEM:
                value = on.item(values[operands], name)
            elif kind == CALL:
                value = call(name, *_with_values(operands, values))
            else:
                value = on.divide(name, values[operands])
            values.append(value)
        return _with_values(self._returned, values)


class _Slot:
    """The place of a result among the values of a program."""

    __slots__ = ("place",)

    def __init__(self, place: int):
        self.place = place


def _with_slots(value: Any) -> Any:
    """Return nested tuples with the places of results for Exprs."""
    return _map_items(lambda item: item.slot if isinstance(item, Expr) else item, value)


def _with_values(value: Any, values: list) -> Any:
    """Return nested tuples with the results at their places."""
    return _map_items(lambda item: values[item.place] if type(item) is _Slot else item, value)


def _map_items(function: Callable[[Any], Any], value: Any) -> Any:
    """Return nested tuples with every item changed."""
    if not isinstance(value, tuple):
        return function(value)
    items = [_map_items(function, item) for item in value]
    return type(value)(*items) if hasattr(value, "_fields") else tuple(items)


def _slots_in(value: Any) -> Iterator[_Slot]:
    """Yield the places in nested tuples."""
    if isinstance(value, tuple):
        for item in value:
            yield from _slots_in(item)
    elif type(value) is _Slot:
        yield value


def _step(kind: int, operands: Any) -> Any:
    """Return the operands of an operation with numbers for places: of a sum, (negative, first, others) of each term."""
    if kind == SUM:
        places = [(negative, [x.place if type(x) is _Slot else x for x in factors]) for negative, factors in operands]
        return [(negative, first, others) for negative, (first, *others) in places]
    return operands if kind == CALL else operands.place


def _sum(on: Any, values: list, terms: list) -> Any:
    """Return the sum of products with signs; a factor is a place (an integer) or a known number."""
    total, add, subtract, multiply = None, on.add, on.subtract, on.multiply
    for negative, first, others in terms:
        term = values[first] if type(first) is int else first
        if negative and total is None:
            term = on.negate(term)
        for factor in others:
            term = multiply(term, values[factor] if type(factor) is int else factor)
        total = term if total is None else subtract(total, term) if negative else add(total, term)
    return total


class Known:
    """Operations that Python does."""

    add, subtract, multiply, divide = operator.add, operator.sub, operator.mul, operator.truediv
    negate, item = operator.neg, operator.getitem

    @staticmethod
    def call(function: Callable, *arguments: Any) -> Any:
        """Return the result of a function."""
        return function(*arguments)


class Traced:
    """Operations that are emitted as those of one body."""

    def __init__(self) -> None:
        body = Expressions(Activation(None, {}, {}))
        operations = ast.Add(), ast.Sub(), ast.Mult(), ast.Div()
        self.add, self.subtract, self.multiply, self.divide = (functools.partial(body.binary, x) for x in operations)
        self.negate, self.item = functools.partial(run, lambda x: -x), body.item

    def call(self, function: Callable, *arguments: Any) -> Any:
        """Return the result of a function, emitting its operations."""
        rule = slope_rule(function) if has_slope(*arguments) else None
        return run(rule, *arguments) if rule else call(function, *arguments)
