"""Evaluates expressions of a body on symbols."""

import ast
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from . import symbols
from .activation import Activation
from .calls import Lambda, call, run
from .fields import Fields
from .lanes import blend
from .memory import constant_table, gather
from .paths import Path, join_paths, leaves, rebuild, with_common_slopes
from .primitives import RULES, slope_rule
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


def _has_slope(*operands: Any) -> bool:
    return any(hasattr(x, "parts") for x in operands)


def as_boolean(x: Any) -> Any:
    """Return the truth value of a symbol; known values unchanged."""
    return symbols.compare("!=", x, 0) if isinstance(x, (Number, Integer)) else x


def _select_item(items: Any, index: Any) -> Any:
    """Return an item of a tuple whose index is known only at run time."""
    value = items[len(items) - 1]
    for position in range(len(items) - 2, -1, -1):
        values = with_common_slopes([items[position], value])
        pairs = zip(leaves(values[0]), leaves(values[1]), strict=True)
        is_chosen = symbols.compare("==", index, position)
        selected_items = [a if a is b else symbols.select(is_chosen, a, b) for a, b in pairs]
        value = rebuild(values[0], iter(selected_items))
    return value


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
        return getattr(self.value(node.value), node.attr)

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
        """Return a text, which is not used."""
        return ""

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
            indices = index if isinstance(index, tuple) else (index,)
            if any(map(is_symbol, indices)):
                return gather(constant_table(container), indices)
            value = container[index]
            return value if isinstance(value, np.ndarray) else value.item()
        if hasattr(container, "traced_item"):
            return run(container.traced_item, container, index)
        if is_symbol(index) and isinstance(container, tuple):
            return _select_item(container, index)
        return container[index]

    def visit_BinOp(self, node: Any) -> Any:  # noqa: N802
        """Return the result of a binary operation."""
        return self.binary(node.op, self.value(node.left), self.value(node.right))

    def binary(self, operation: Any, a: Any, b: Any) -> Any:
        """Return the result of a binary operation on values."""
        if isinstance(operation, ast.Pow):
            return self.power(a, b)
        rule, on_floats, emit = BINARY[type(operation)]
        if _has_slope(a, b):
            return run(RULES[rule], a, b)
        if is_symbol(a) or is_symbol(b):
            return emit(a, b, (self.activation.number, trace().builder.block))
        return on_floats(a, b)

    def power(self, a: Any, b: Any) -> Any:
        """Return a power; a known integer power becomes products."""
        if _has_slope(a, b):
            return run(RULES["__pow__"], a, b)
        if is_symbol(a) and not is_symbol(b) and float(b).is_integer() and 1.0 <= b <= LARGEST_POWER:
            product = a
            for bit in bin(int(b))[3:]:
                product = symbols.times(product, product)
                product = symbols.times(product, a) if bit == "1" else product
            return product
        if is_symbol(a) or is_symbol(b):
            return call(pow, a, b)
        return a**b

    def visit_UnaryOp(self, node: Any) -> Any:  # noqa: N802
        """Return the result of a unary operation."""
        x = self.value(node.operand)
        if isinstance(node.op, ast.Not):
            x = as_boolean(x)
            return symbols.logical_not(x) if is_symbol(x) else not x
        if isinstance(node.op, ast.USub):
            if _has_slope(x):
                return run(RULES["__neg__"], x)
            return symbols.negate(x) if is_symbol(x) else -x
        if isinstance(node.op, ast.Invert):
            return symbols.bit_xor(x, -1) if is_symbol(x) else ~x
        if isinstance(node.op, ast.UAdd):
            return x
        raise NotTraceableError("has an unsupported operation")

    def visit_Compare(self, node: Any) -> Any:  # noqa: N802
        """Return the result of a comparison or of a chain of comparisons."""
        left, result = self.value(node.left), None
        for operation, operand_node in zip(node.ops, node.comparators, strict=True):
            right = self.value(operand_node)
            comparison = self.compare(operation, left, right)
            if result is None:
                result = comparison
            elif is_symbol(result) or is_symbol(comparison):
                result = symbols.bit_and(result, comparison)
            else:
                result = result and comparison
            left = right
        return result

    def compare(self, operation: Any, a: Any, b: Any) -> Any:
        """Return the result of a comparison."""
        if isinstance(operation, (ast.Is, ast.IsNot)):
            return (a is b) == isinstance(operation, ast.Is)
        if isinstance(operation, (ast.In, ast.NotIn)):
            is_member: Any = False
            if is_symbol(a) or (isinstance(b, tuple) and any(map(is_symbol, b))):
                for x in b:
                    is_equal = self.compare(ast.Eq(), a, x)
                    is_member = (
                        symbols.bit_or(is_member, is_equal)
                        if is_symbol(is_member) or is_symbol(is_equal)
                        else is_member or is_equal
                    )
            else:
                is_member = a in b
            if isinstance(operation, ast.In):
                return is_member
            return symbols.logical_not(is_member) if is_symbol(is_member) else not is_member
        rule, sign, on_floats = COMPARED[type(operation)]
        if _has_slope(a, b):
            return run(RULES[rule], a, b)
        if is_symbol(a) or is_symbol(b):
            return symbols.compare(sign, a, b)
        return on_floats(a, b)

    def visit_BoolOp(self, node: Any) -> Any:  # noqa: N802
        """Return the result of `and` or `or`, with short-circuit evaluation."""
        is_and, result = isinstance(node.op, ast.And), None
        for position, operand_node in enumerate(node.values):
            if position == 0:
                result = self.value(operand_node)
                continue
            if not is_symbol(result):
                if bool(result) != is_and:
                    return result
                result = self.value(operand_node)
                continue
            result = self.combine(as_boolean(result), operand_node, is_and=is_and)
        return result

    def combine(self, condition: Boolean, node: Any, *, is_and: bool) -> Any:
        """Return the combination of a condition with a further one, evaluated only where necessary."""
        if condition.width > 1 or not any(isinstance(n, (ast.Call, ast.Subscript)) for n in ast.walk(node)):
            right = as_boolean(self.value(node))
            return symbols.bit_and(condition, right) if is_and else symbols.bit_or(condition, right)
        builder, active_trace = trace().builder, trace()
        evaluate_block, short_circuit_block = active_trace.block(), active_trace.block()
        builder.cbranch(
            condition.value,
            *((evaluate_block, short_circuit_block) if is_and else (short_circuit_block, evaluate_block)),
        )
        builder.position_at_end(evaluate_block)
        right = as_boolean(self.value(node))
        paths = [Path(builder.block, right), Path(short_circuit_block, not is_and)]
        return join_paths(paths)

    def condition_value(self, node: Any) -> Any:
        """Return the truth value of an expression."""
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
        outer, values = self.activation.mask, []
        for branch_lanes, branch in ((condition, node.body), (symbols.logical_not(condition), node.orelse)):
            self.activation.mask = branch_lanes if outer is None else symbols.bit_and(outer, branch_lanes)
            values.append(self.value(branch))
        self.activation.mask = outer
        a, b = with_common_slopes(values)
        pairs = zip(leaves(a), leaves(b), strict=True)
        return rebuild(a, iter([x if x is y else symbols.select(condition, x, y) for x, y in pairs]))

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
        if _has_slope(*operands) and (rule := slope_rule(function)):
            return run(rule, *operands)
        return call(function, *operands, **named)

    def visit_Lambda(self, node: Any) -> Any:  # noqa: N802
        """Return a function."""
        return Lambda(node, self.activation)

    def visit_GeneratorExp(self, node: Any) -> Any:  # noqa: N802
        """Return the items of a comprehension."""
        return list(self.comprehended(node, 0))

    visit_ListComp = visit_GeneratorExp  # noqa: N815

    def comprehended(self, node: Any, level: int) -> Iterator[Any]:
        """Yield the items."""
        if level == len(node.generators):
            yield self.value(node.elt)
            return
        generator, outer_names = node.generators[level], self.activation.names
        for item in list(self.value(generator.iter)):
            self.activation.names = dict(outer_names)
            self.assign(generator.target, item)
            if all(self.value(condition) for condition in generator.ifs):
                yield from self.comprehended(node, level + 1)
        self.activation.names = outer_names

    def assign(self, target: Any, value: Any) -> None:
        """Assign a value to a target."""
        if isinstance(target, ast.Name):
            lanes = self.activation.lanes()
            if lanes is None:
                self.activation.names[target.id] = value
            else:
                self.assign_in_lanes(target.id, value, lanes)
        elif isinstance(target, (ast.Tuple, ast.List)):
            items = list(value)
            if len(items) != len(target.elts):
                raise NotTraceableError(f"unpacks {len(items)} values into {len(target.elts)}")
            for element, item in zip(target.elts, items, strict=True):
                self.assign(element, item)
        elif isinstance(target, ast.Subscript):
            self.value(target.value)[self.index(target.slice)] = value
        else:
            setattr(self.fields(target), target.attr, value)

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
