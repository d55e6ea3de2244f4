"""Evaluates expressions of a body on symbols."""

import ast
import contextlib
import functools
from collections.abc import Callable, Iterator
from types import FunctionType
from typing import Any

import numpy as np

from . import functions, symbols
from .activation import Activation, Path, blend, join_paths, select_values
from .calls import Lambda, call, is_foreign, run
from .memory import Fields, View, constant_table, index_from_start
from .protocols import RULES, Composite, has_slope, slope_rule
from .symbols import Boolean, Integer, NotTraceableError, Number, is_symbol, trace

LARGEST_POWER = 16  # largest integer power that is expanded


BINARY: dict[type, tuple[str, Callable, Callable]] = {}  # syntax -> (name of the rule, Python function, emitter)
for _syntax, _name, _on_floats, _emit in (
    (ast.Add, "__add__", lambda a, b: a + b, symbols.plus),
    (ast.Sub, "__sub__", lambda a, b: a - b, symbols.minus),
    (ast.Mult, "__mul__", lambda a, b: a * b, symbols.times),
    (ast.Div, "__truediv__", lambda a, b: a / b, symbols.divide),
    (ast.FloorDiv, "__floordiv__", lambda a, b: a // b, symbols.floor_divide),
    (ast.Mod, "__mod__", lambda a, b: a % b, symbols.remainder),
    (ast.BitAnd, "__and__", lambda a, b: a & b, symbols.bit_and),
    (ast.BitOr, "__or__", lambda a, b: a | b, symbols.bit_or),
    (ast.BitXor, "__xor__", lambda a, b: a ^ b, symbols.bit_xor),
    (ast.RShift, "__rshift__", lambda a, b: a >> b, symbols.shift_right),
    (ast.LShift, "__lshift__", lambda a, b: a << b, symbols.shift_left),
):
    BINARY[_syntax] = (_name, _on_floats, _emit)
COMPARED: dict[type, tuple[str, str, Callable]] = {
    ast.Lt: ("__lt__", "<", lambda a, b: a < b),
    ast.LtE: ("__le__", "<=", lambda a, b: a <= b),
    ast.Gt: ("__gt__", ">", lambda a, b: a > b),
    ast.GtE: ("__ge__", ">=", lambda a, b: a >= b),
    ast.Eq: ("__eq__", "==", lambda a, b: a == b),
    ast.NotEq: ("__ne__", "!=", lambda a, b: a != b),
}


KNOWN_ITEMS = (tuple, list, str, dict, range)  # whose items Python takes while tracing
#: What may have an effect, or differ where it is not needed: evaluated in its own block.
EFFECTS = (ast.Call, ast.Subscript)


UNARY: dict[type, tuple[str, Callable, Callable]] = {
    ast.USub: ("__neg__", lambda x: -x, symbols.negate),
    ast.UAdd: ("__pos__", lambda x: +x, lambda x: symbols.plus(x, 0) if isinstance(x, Boolean) else x),
    ast.Invert: ("__invert__", lambda x: ~x, lambda x: symbols.bit_xor(x, -1)),
}


def _rule(name: str) -> Any:
    if name not in RULES:
        raise NotTraceableError("has an operation that is not defined for a number with a slope")
    return RULES[name]


def _refuse_own_operators(rule: str, *operands: Any) -> None:
    """Raise an error if the class of a value defines an operator in Python, which would not be traced."""
    reflected = f"__r{rule[2:]}"
    for x in operands:
        if isinstance(x, View) or any(
            isinstance(getattr(type(x), name, None), FunctionType) for name in (rule, reflected)
        ):
            raise NotTraceableError(f"uses an operator of a {type(x).__name__}: call a function instead")


def _chosen(condition: Boolean, left: Any, right: Any, *, is_and: bool) -> Any:
    """Return `left and right` or `left or right`, both evaluated; condition : the truth value of `left`."""
    if isinstance(left, Boolean) and isinstance(right, (Boolean, bool)):
        return symbols.bit_and(left, right) if is_and else symbols.bit_or(left, right)
    return select_values(condition, right, left) if is_and else select_values(condition, left, right)


def as_boolean(x: Any) -> Any:
    """Return the truth value of a symbol, or of the value of a number with a slope; known values unchanged."""
    while has_slope(x):
        x = x.traced_parts()[0]
    if isinstance(x, Composite):
        raise NotTraceableError(f"takes the truth value of a {type(x).__name__}")
    return symbols.as_boolean(x)


def _item_at(items: Any, index: Any) -> Any:
    """Return an item of a tuple or list whose index is known only at run time."""
    if isinstance(index, Number) or not items:
        raise NotTraceableError("takes an item by a float, or of nothing")
    count = len(items)
    value = items[count - 1]
    for position in range(count - 2, -1, -1):
        is_from_end = symbols.compare("==", index, position - count)
        is_chosen = symbols.bit_or(symbols.compare("==", index, position), is_from_end)
        value = select_values(is_chosen, items[position], value)
    return value


class OneShot(list):  # type: ignore[type-arg]
    """The items of a generator expression, which Python could take only once."""


class Expressions:
    """Evaluates the expressions of an activation."""

    def __init__(self, activation: Activation):
        self.activation = activation

    def value(self, node: Any) -> Any:
        """Return the value of an expression."""
        return getattr(self, f"visit_{type(node).__name__}", self.refuse_expression)(node)

    def refuse_expression(self, node: Any) -> Any:
        """Raise the error for an unsupported expression."""
        raise NotTraceableError(f"has an unsupported expression ({type(node).__name__})")

    def visit_Constant(self, node: Any) -> Any:  # noqa: N802
        """Return a constant."""
        return node.value

    def visit_Name(self, node: Any) -> Any:  # noqa: N802
        """Return the value of a name."""
        return self.activation.look_up(node.id)

    def visit_Attribute(self, node: Any) -> Any:  # noqa: N802
        """Return an attribute."""
        holder, name = self.value(node.value), node.attr
        if is_symbol(holder) or (isinstance(holder, View) and name not in View.ATTRIBUTES):
            raise NotTraceableError(f"uses the attribute {name} of {'a number' if is_symbol(holder) else 'an array'}")
        declared = getattr(type(holder), name, None)
        if isinstance(declared, property) and is_foreign(declared.fget):
            return run(declared.fget, holder)
        return getattr(holder, name)

    def visit_Tuple(self, node: Any) -> Any:  # noqa: N802
        """Return a tuple."""
        return tuple(self.items(node.elts))

    def visit_List(self, node: Any) -> Any:  # noqa: N802
        """Return a list."""
        return list(self.items(node.elts))

    def items(self, nodes: list[Any]) -> Iterator[Any]:
        """Yield the values of expressions; starred ones are unpacked."""
        for node in nodes:
            if isinstance(node, ast.Starred):
                yield from self.value(node.value)
            else:
                yield self.value(node)

    def visit_JoinedStr(self, node: Any) -> Any:  # noqa: N802
        """Refuse a text of values, which may be known only at run time."""
        raise NotTraceableError("makes a text of values")

    def index(self, node: Any) -> Any:
        """Return an index, or a part of an array."""
        if isinstance(node, ast.Slice):
            low, high, step = (x and self.value(x) for x in (node.lower, node.upper, node.step))
            return slice(low, high, step)
        if isinstance(node, ast.Tuple):
            return tuple(self.index(x) for x in node.elts)
        return self.value(node)

    def visit_Subscript(self, node: Any) -> Any:  # noqa: N802
        """Return an item, or a part of an array."""
        return self.item(self.value(node.value), self.index(node.slice))

    def item(self, container: Any, index: Any) -> Any:
        """Return an item of an array, a tuple or a state with slopes."""
        if isinstance(container, np.ndarray):
            table, indices = constant_table(container), index if isinstance(index, tuple) else (index,)
            if any(map(is_symbol, indices)):
                return table[tuple(map(index_from_start, indices, container.shape))]
            value = container[index]
            return value if isinstance(value, np.ndarray) else value.item()
        if isinstance(container, Composite) and container.traced_item:
            return run(container.traced_item, container, index)
        if isinstance(container, (View, Composite)):
            return container[index]
        if not isinstance(container, KNOWN_ITEMS):
            raise NotTraceableError(f"takes an item of a {type(container).__name__}")
        if is_symbol(index) and isinstance(container, (tuple, list)):
            return _item_at(container, index)
        return container[index]

    def visit_BinOp(self, node: Any) -> Any:  # noqa: N802
        """Return the result of a binary operation."""
        return self.binary(node.op, self.value(node.left), self.value(node.right))

    def binary(self, operation: Any, a: Any, b: Any) -> Any:
        """Return the result of a binary operation on values."""
        if isinstance(operation, ast.Pow):
            return self.power(a, b)
        if type(operation) not in BINARY:
            raise NotTraceableError(f"has an unsupported operation ({type(operation).__name__})")
        rule, on_known, emit = BINARY[type(operation)]
        if has_slope(a, b):
            return run(_rule(rule), a, b)
        if is_symbol(a) or is_symbol(b):
            return emit(a, b, (self.activation.number, trace().builder.block))
        _refuse_own_operators(rule, a, b)
        return on_known(a, b)

    def power(self, a: Any, b: Any) -> Any:
        """Return a power; a known integer power becomes products."""
        if has_slope(b):
            raise NotTraceableError("raises to a power that has a slope")
        if has_slope(a):
            return run(RULES["__pow__"], a, b)
        if not (is_symbol(a) or is_symbol(b)):
            _refuse_own_operators("__pow__", a, b)
            return a**b
        is_whole = all(isinstance(x, (Integer, Boolean, int)) for x in (a, b))
        if is_whole and (is_symbol(b) or b < 0):
            raise NotTraceableError("raises an integer to a power that is negative or known only at run time")
        if is_whole and b == 0:
            return 1
        known_power = 0.0 if is_symbol(b) or not isinstance(b, (int, float)) else float(b)
        if (
            is_symbol(a)
            and known_power.is_integer()
            and known_power >= 1.0
            and (is_whole or known_power <= LARGEST_POWER)
        ):
            factor = a if is_whole or isinstance(a, Number) else symbols.as_number(a)
            product = factor
            for bit in bin(int(known_power))[3:]:
                product = symbols.times(product, product)
                product = symbols.times(product, factor) if bit == "1" else product
            return product
        operands = (x if isinstance(x, float) else symbols.as_number(x) if is_symbol(x) else float(x) for x in (a, b))
        return call(functions.pow, *operands)

    def visit_UnaryOp(self, node: Any) -> Any:  # noqa: N802
        """Return the result of a unary operation."""
        if isinstance(node.op, ast.Not):
            x = self.condition_value(node.operand)
            return symbols.logical_not(x) if is_symbol(x) else not x
        x = self.value(node.operand)
        if isinstance(node.op, ast.USub) and has_slope(x):
            return run(RULES["__neg__"], x)
        if has_slope(x):
            raise NotTraceableError("has an operation that is not defined for a number with a slope")
        rule, on_known, emit = UNARY[type(node.op)]
        if is_symbol(x):
            return emit(x)
        _refuse_own_operators(rule, x)
        return on_known(x)

    def visit_Compare(self, node: Any) -> Any:  # noqa: N802
        """Return the result of a comparison or of a chain of comparisons."""
        return self.compare_chain(self.value(node.left), node.ops, node.comparators)

    def compare_chain(self, left: Any, operations: list[Any], nodes: list[Any]) -> Any:
        """Return the result of a chain of comparisons, evaluated from the left as far as necessary."""
        right = self.value(nodes[0])
        comparison = self.compare(operations[0], left, right)
        if len(nodes) == 1 or not (is_symbol(comparison) or comparison):
            return comparison
        if not is_symbol(comparison):
            return self.compare_chain(right, operations[1:], nodes[1:])
        is_separate = any(isinstance(n, ast.Call) for node in nodes[1:] for n in ast.walk(node))
        return self.combine(
            comparison,
            lambda: self.compare_chain(right, operations[1:], nodes[1:]),
            is_and=True,
            is_separate=is_separate,
        )

    def compare(self, operation: Any, a: Any, b: Any) -> Any:
        """Return the result of a comparison."""
        if isinstance(operation, (ast.Is, ast.IsNot)):
            at_run_time = (symbols.Symbol, View, Composite)
            if a is not None and b is not None and (isinstance(a, at_run_time) or isinstance(b, at_run_time)):
                raise NotTraceableError("asks whether values known only at run time are the same object")
            return (a is b) == isinstance(operation, ast.Is)
        if isinstance(operation, (ast.In, ast.NotIn)):
            is_member = self.is_member(a, b)
            if isinstance(operation, ast.In):
                return is_member
            return symbols.logical_not(is_member) if is_symbol(is_member) else not is_member
        rule, sign, on_known = COMPARED[type(operation)]
        if has_slope(a, b):
            return run(RULES[rule], a, b)
        if is_symbol(a) or is_symbol(b):
            return symbols.compare(sign, a, b)
        _refuse_own_operators(rule, a, b)
        return on_known(a, b)

    def is_member(self, a: Any, container: Any) -> Any:
        """Return whether a value is an item."""
        if isinstance(container, (tuple, list, View)):
            items = list(container)
        elif is_symbol(a) or has_slope(a):
            items = list(container) if isinstance(container, (dict, range)) else [container]
        else:
            return a in container
        if not any(is_symbol(x) or has_slope(x) for x in (a, *items)):
            return a in items
        result: Any = False
        for x in items:
            is_equal = a is x or self.compare(ast.Eq(), a, x)
            is_known = not (is_symbol(result) or is_symbol(is_equal))
            result = result or is_equal if is_known else symbols.bit_or(result, is_equal)
        return result

    def visit_BoolOp(self, node: Any) -> Any:  # noqa: N802
        """Return the operand of `and` or `or` that decides; the others are not evaluated."""
        return self.decide(node, self.value)

    def decide(self, node: Any, evaluate: Callable) -> Any:
        """Return the operand of `and` or `or` that decides, as `evaluate` returns it from its syntax tree."""
        is_and, result = isinstance(node.op, ast.And), evaluate(node.values[0])
        for operand_node in node.values[1:]:
            if is_symbol(as_boolean(result)):
                is_separate = any(isinstance(n, EFFECTS) for n in ast.walk(operand_node))
                operand = functools.partial(evaluate, operand_node)
                result = self.combine(result, operand, is_and=is_and, is_separate=is_separate)
            elif bool(result) != is_and:
                return result
            else:
                result = evaluate(operand_node)
        return result

    def combine(self, left: Any, evaluate: Callable, *, is_and: bool, is_separate: bool) -> Any:
        """Return `left and evaluate()` or `left or evaluate()`; is_separate : evaluate only where it is necessary."""
        condition = as_boolean(left)
        is_needed = condition if is_and else symbols.logical_not(condition)
        if condition.width > 1 and is_separate:
            with self.within(is_needed):
                return _chosen(condition, left, evaluate(), is_and=is_and)
        if condition.width > 1 or not is_separate:
            return _chosen(condition, left, evaluate(), is_and=is_and)
        builder, active_trace = trace().builder, trace()
        evaluate_block, short_circuit_block = active_trace.block(), active_trace.block()
        builder.cbranch(
            condition.value,
            *((evaluate_block, short_circuit_block) if is_and else (short_circuit_block, evaluate_block)),
        )
        builder.position_at_end(evaluate_block)
        right = evaluate()
        is_truth = isinstance(left, Boolean) and isinstance(right, (Boolean, bool))
        paths = [Path(builder.block, right), Path(short_circuit_block, not is_and if is_truth else left)]
        return join_paths(paths)

    @contextlib.contextmanager
    def within(self, lanes: Boolean) -> Iterator[None]:
        """In this context, statements have an effect in some lanes alone."""
        outer = self.activation.mask
        self.activation.mask = lanes if outer is None else symbols.bit_and(outer, lanes)
        try:
            yield
        finally:
            self.activation.mask = outer

    def condition_value(self, node: Any) -> Any:
        """Return the truth value of an expression."""
        if isinstance(node, ast.BoolOp):
            return self.decide(node, self.condition_value)
        x = as_boolean(self.value(node))
        return x if is_symbol(x) else bool(x)

    def visit_IfExp(self, node: Any) -> Any:  # noqa: N802
        """Return one of two values."""
        condition = self.condition_value(node.test)
        if not is_symbol(condition):
            return self.value(node.body if condition else node.orelse)
        if condition.width > 1:
            return self.select_in_lanes(condition, node)
        builder, active_trace = trace().builder, trace()
        true_block, false_block = active_trace.block(), active_trace.block()
        builder.cbranch(condition.value, true_block, false_block)
        paths = []
        for block, branch in ((true_block, node.body), (false_block, node.orelse)):
            builder.position_at_end(block)
            value = self.value(branch)
            paths.append(Path(builder.block, value))
        return join_paths(paths)

    def select_in_lanes(self, condition: Boolean, node: Any) -> Any:
        """Return one of two values in each lane."""
        values = []
        for branch_lanes, branch in ((condition, node.body), (symbols.logical_not(condition), node.orelse)):
            with self.within(branch_lanes):
                values.append(self.value(branch))
        return select_values(condition, *values)

    def visit_Call(self, node: Any) -> Any:  # noqa: N802
        """Return the result of a call."""
        function = self.value(node.func)
        operands = list(self.items(node.args))
        named: dict[str, Any] = {}
        for item in node.keywords:
            if item.arg is None:
                named.update(self.value(item.value))
            else:
                named[item.arg] = self.value(item.value)
        if has_slope(*operands) and (rule := slope_rule(function)):
            return run(rule, *operands, **named)
        return call(function, *operands, **named)

    def visit_Lambda(self, node: Any) -> Any:  # noqa: N802
        """Return a function."""
        if self.activation.comprehensions:
            raise NotTraceableError("defines a function in a comprehension")
        arguments = node.args
        if arguments.vararg or arguments.kwarg or arguments.kwonlyargs or arguments.posonlyargs:
            raise NotTraceableError("defines a function with other than plain arguments")
        return Lambda(node, self.activation, tuple(map(self.value, arguments.defaults)))

    def visit_GeneratorExp(self, node: Any) -> Any:  # noqa: N802
        """Return the items of a generator expression."""
        return OneShot(self.visit_ListComp(node))

    def visit_ListComp(self, node: Any) -> Any:  # noqa: N802
        """Return the items of a comprehension."""
        self.activation.comprehensions += 1
        items = list(self.comprehended(node, 0))
        self.activation.comprehensions -= 1
        return items

    def comprehended(self, node: Any, level: int) -> Iterator[Any]:
        """Yield the items."""
        if level == len(node.generators):
            yield self.value(node.elt)
            return
        generator, outer_names = node.generators[level], self.activation.names
        for item in list(self.value(generator.iter)):
            self.activation.names = dict(outer_names)
            self.assign(generator.target, item)
            if all(map(self.known_condition, generator.ifs)):
                yield from self.comprehended(node, level + 1)
        self.activation.names = outer_names

    def known_condition(self, node: Any) -> bool:
        """Return the truth value of the condition of a comprehension."""
        condition = self.condition_value(node)
        if is_symbol(condition):
            raise NotTraceableError("decides in a comprehension by what is known only at run time")
        return bool(condition)

    def assign(self, target: Any, value: Any) -> None:
        """Assign a value to a target."""
        if isinstance(target, ast.Name):
            if isinstance(value, (Iterator, OneShot)):
                raise NotTraceableError("gives a name to an iterator, which could be used only once")
            lanes = self.activation.lanes()
            if lanes is None:
                self.activation.names[target.id] = value
            else:
                self.assign_in_lanes(target.id, value, lanes)
        elif isinstance(target, (ast.Tuple, ast.List)):
            if any(isinstance(element, ast.Starred) for element in target.elts):
                raise NotTraceableError("unpacks to a starred name")
            items = list(value)
            if len(items) != len(target.elts):
                raise NotTraceableError(f"unpacks {len(items)} values into {len(target.elts)}")
            for element, item in zip(target.elts, items, strict=True):
                self.assign(element, item)
        elif isinstance(target, ast.Subscript):
            self.array(target)[self.index(target.slice)] = value
        else:
            setattr(self.fields(target), target.attr, value)

    def array(self, target: Any) -> View:
        """Return the array of which a target is an item."""
        holder = self.value(target.value)
        if not isinstance(holder, View):
            raise NotTraceableError(f"changes an item of a {type(holder).__name__}, which is no array in memory")
        return holder

    def fields(self, target: Any) -> Fields:
        """Return the Fields to which the number of a target belongs."""
        holder = self.value(target.value)
        if not isinstance(holder, Fields) or target.attr not in holder.DECLARED:
            raise NotTraceableError("assigns an attribute that is no number in memory")
        return holder

    def assign_in_lanes(self, name: str, value: Any, lanes: Any) -> None:
        """Assign a value to a variable in some lanes."""
        names = self.activation.names
        names[name] = blend(lanes, value, names[name]) if name in names else value
