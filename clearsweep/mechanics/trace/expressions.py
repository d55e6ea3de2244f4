"""Evaluates expressions of a body on symbols."""

import ast
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from . import symbols
from .activation import Activation
from .calls import Lambda, call, run
from .fields import Fields
from .lanes import blended
from .memory import gathered, table_of
from .paths import Path, alike, joined, leaves, rebuilt
from .primitives import RULES, slope_rule
from .symbols import NotTraceableError, Number, Truth, Whole, is_symbol, trace

LARGEST_POWER = 16  # largest integer power that is expanded


BINARY: dict[type, tuple[str, Callable, Callable]] = {}  # syntax -> (name of the rule, Python function, emitter)
for _syntax, _name, _plainly, _emit in (
    (ast.Add, "__add__", lambda a, b: a + b, symbols.plus),
    (ast.Sub, "__sub__", lambda a, b: a - b, symbols.minus),
    (ast.Mult, "__mul__", lambda a, b: a * b, symbols.times),
    (ast.Div, "__truediv__", lambda a, b: a / b, symbols.over),
    (ast.FloorDiv, "__floordiv__", lambda a, b: a // b, symbols.whole_over),
    (ast.Mod, "__mod__", lambda a, b: a % b, symbols.remainder),
    (ast.BitAnd, "__and__", lambda a, b: a & b, symbols.both),
    (ast.BitOr, "__or__", lambda a, b: a | b, symbols.one_of),
    (ast.BitXor, "__xor__", lambda a, b: a ^ b, symbols.without_common),
    (ast.RShift, "__rshift__", lambda a, b: a >> b, symbols.shifted_right),
    (ast.LShift, "__lshift__", lambda a, b: a << b, symbols.shifted_left),
):
    BINARY[_syntax] = (_name, _plainly, _emit)
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


def as_answer(x: Any) -> Any:
    """Return the truth value of a symbol; known values unchanged."""
    return symbols.compared("!=", x, 0) if isinstance(x, (Number, Whole)) else x


def _one_of(holder: Any, index: Any) -> Any:
    """Return an item of a tuple whose index is known only at run time."""
    value = holder[len(holder) - 1]
    for position in range(len(holder) - 2, -1, -1):
        values = alike([holder[position], value])
        pairs = zip(leaves(values[0]), leaves(values[1]), strict=True)
        chosen = symbols.compared("==", index, position)
        results = [a if a is b else symbols.selected(chosen, a, b) for a, b in pairs]
        value = rebuilt(values[0], iter(results))
    return value


class Expressions:
    """Evaluates the expressions of an activation."""

    def __init__(self, at_work: Activation):
        self.at = at_work

    def value(self, node: Any) -> Any:
        """Return the value of an expression."""
        return getattr(self, f"see_{type(node).__name__}", self.see_what)(node)

    def see_what(self, node: Any) -> Any:
        """Refuse an expression."""
        raise NotTraceableError(f"has an expression that is not known ({type(node).__name__})")

    def see_Constant(self, node: Any) -> Any:  # noqa: N802
        """Return a constant."""
        return node.value

    def see_Name(self, node: Any) -> Any:  # noqa: N802
        """Return the value of a name."""
        return self.at.look_up(node.id)

    def see_Attribute(self, node: Any) -> Any:  # noqa: N802
        """Return an attribute."""
        return getattr(self.value(node.value), node.attr)

    def see_Tuple(self, node: Any) -> Any:  # noqa: N802
        """Return a tuple."""
        return tuple(self.items(node.elts))

    def see_List(self, node: Any) -> Any:  # noqa: N802
        """Return a list."""
        return list(self.items(node.elts))

    def items(self, nodes: list[Any]) -> Iterator[Any]:
        """Yield the values of expressions; starred ones are unpacked."""
        for node in nodes:
            if isinstance(node, ast.Starred):
                yield from self.value(node.value)
            else:
                yield self.value(node)

    def see_JoinedStr(self, node: Any) -> Any:  # noqa: N802
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

    def see_Subscript(self, node: Any) -> Any:  # noqa: N802
        """Return an item, or a part of an array."""
        return self.item(self.value(node.value), self.index(node.slice))

    def item(self, holder: Any, index: Any) -> Any:
        """Return an item of an array, a tuple or a state with slopes."""
        if isinstance(holder, np.ndarray):
            operands = index if isinstance(index, tuple) else (index,)
            if any(map(is_symbol, operands)):
                return gathered(table_of(holder), operands)
            value = holder[index]
            return value if isinstance(value, np.ndarray) else value.item()
        if hasattr(holder, "traced_item"):
            return run(holder.traced_item, holder, index)
        if is_symbol(index) and isinstance(holder, tuple):
            return _one_of(holder, index)
        return holder[index]

    def see_BinOp(self, node: Any) -> Any:  # noqa: N802
        """Return the result of a binary operation."""
        return self.binary(node.op, self.value(node.left), self.value(node.right))

    def binary(self, operation: Any, a: Any, b: Any) -> Any:
        """Return the result of a binary operation on values."""
        if isinstance(operation, ast.Pow):
            return self.power(a, b)
        slope_rule_, plainly, emit = BINARY[type(operation)]
        if _has_slope(a, b):
            return run(RULES[slope_rule_], a, b)
        if is_symbol(a) or is_symbol(b):
            return emit(a, b, (self.at.number, trace().builder.block))
        return plainly(a, b)

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

    def see_UnaryOp(self, node: Any) -> Any:  # noqa: N802
        """Return the result of a unary operation."""
        x = self.value(node.operand)
        if isinstance(node.op, ast.Not):
            x = as_answer(x)
            return symbols.opposite(x) if is_symbol(x) else not x
        if isinstance(node.op, ast.USub):
            if _has_slope(x):
                return run(RULES["__neg__"], x)
            return symbols.negative(x) if is_symbol(x) else -x
        if isinstance(node.op, ast.Invert):
            return symbols.without_common(x, -1) if is_symbol(x) else ~x
        if isinstance(node.op, ast.UAdd):
            return x
        raise NotTraceableError("has an operation that is not known")

    def see_Compare(self, node: Any) -> Any:  # noqa: N802
        """Return the result of a comparison or of a chain of comparisons."""
        left, answer = self.value(node.left), None
        for operation, item in zip(node.ops, node.comparators, strict=True):
            right = self.value(item)
            one_lane = self.compare(operation, left, right)
            if answer is None:
                answer = one_lane
            elif is_symbol(answer) or is_symbol(one_lane):
                answer = symbols.both(answer, one_lane)
            else:
                answer = answer and one_lane
            left = right
        return answer

    def compare(self, operation: Any, a: Any, b: Any) -> Any:
        """Return the result of a comparison."""
        if isinstance(operation, (ast.Is, ast.IsNot)):
            return (a is b) == isinstance(operation, ast.Is)
        if isinstance(operation, (ast.In, ast.NotIn)):
            holds_true: Any = False
            if is_symbol(a) or (isinstance(b, tuple) and any(map(is_symbol, b))):
                for x in b:
                    one_lane = self.compare(ast.Eq(), a, x)
                    holds_true = (
                        symbols.one_of(holds_true, one_lane)
                        if is_symbol(holds_true) or is_symbol(one_lane)
                        else holds_true or one_lane
                    )
            else:
                holds_true = a in b
            if isinstance(operation, ast.In):
                return holds_true
            return symbols.opposite(holds_true) if is_symbol(holds_true) else not holds_true
        slope_rule_, sign, plainly = COMPARED[type(operation)]
        if _has_slope(a, b):
            return run(RULES[slope_rule_], a, b)
        if is_symbol(a) or is_symbol(b):
            return symbols.compared(sign, a, b)
        return plainly(a, b)

    def see_BoolOp(self, node: Any) -> Any:  # noqa: N802
        """Return the result of `and` or `or`, with short-circuit evaluation."""
        is_and, answer = isinstance(node.op, ast.And), None
        for position, item in enumerate(node.values):
            if position == 0:
                answer = self.value(item)
                continue
            if not is_symbol(answer):
                if bool(answer) != is_and:
                    return answer
                answer = self.value(item)
                continue
            answer = self.further(as_answer(answer), item, is_and=is_and)
        return answer

    def further(self, answer: Truth, node: Any, *, is_and: bool) -> Any:
        """Return the combination of a condition with a further one, evaluated only where necessary."""
        if answer.width > 1 or not any(isinstance(n, (ast.Call, ast.Subscript)) for n in ast.walk(node)):
            right_operand = as_answer(self.value(node))
            return symbols.both(answer, right_operand) if is_and else symbols.one_of(answer, right_operand)
        builder, active_trace = trace().builder, trace()
        more, constant_value = active_trace.block(), active_trace.block()
        builder.cbranch(answer.value, *((more, constant_value) if is_and else (constant_value, more)))
        builder.position_at_end(more)
        right_operand = as_answer(self.value(node))
        paths = [Path(builder.block, right_operand), Path(constant_value, not is_and)]
        return joined(paths)

    def answer(self, node: Any) -> Any:
        """Return the truth value of an expression."""
        x = as_answer(self.value(node))
        return x if is_symbol(x) else bool(x)

    def see_IfExp(self, node: Any) -> Any:  # noqa: N802
        """Return one of two values."""
        condition = self.answer(node.test)
        if not is_symbol(condition):
            return self.value(node.body if condition else node.orelse)
        if condition.width > 1:
            return self.one_each(condition, node)
        builder, active_trace = trace().builder, trace()
        one_lane, right_operand = active_trace.block(), active_trace.block()
        builder.cbranch(condition.value, one_lane, right_operand)
        paths = []
        for block, side in ((one_lane, node.body), (right_operand, node.orelse)):
            builder.position_at_end(block)
            value = self.value(side)
            paths.append(Path(builder.block, value))
        return joined(paths)

    def one_each(self, condition: Truth, node: Any) -> Any:
        """Return one of two values in each lane."""
        outer, values = self.at.mask, []
        for taken_mask, side in ((condition, node.body), (symbols.opposite(condition), node.orelse)):
            self.at.mask = taken_mask if outer is None else symbols.both(outer, taken_mask)
            values.append(self.value(side))
        self.at.mask = outer
        a, b = alike(values)
        pairs = zip(leaves(a), leaves(b), strict=True)
        return rebuilt(a, iter([x if x is y else symbols.selected(condition, x, y) for x, y in pairs]))

    def see_Call(self, node: Any) -> Any:  # noqa: N802
        """Return the result of a call."""
        function = self.value(node.func)
        operands = list(self.items(node.args))
        named: dict[str, Any] = {}
        for item in node.keywords:
            if item.arg is None:
                named.update(self.value(item.value))
            else:
                named[item.arg] = self.value(item.value)
        if _has_slope(*operands) and (slope_rule_ := slope_rule(function)):
            return run(slope_rule_, *operands)
        return call(function, *operands, **named)

    def seeLambda(self, node: Any) -> Any:  # noqa: N802
        """Return a function."""
        return Lambda(node, self.at)

    def see_GeneratorExp(self, node: Any) -> Any:  # noqa: N802
        """Return the items of a comprehension."""
        return list(self.comprehended(node, 0))

    see_ListComp = see_GeneratorExp  # noqa: N815

    def comprehended(self, node: Any, level: int) -> Iterator[Any]:
        """Yield the items."""
        if level == len(node.generators):
            yield self.value(node.elt)
            return
        piece, kept_arrays = node.generators[level], self.at.names
        for item in list(self.value(piece.iter)):
            self.at.names = dict(kept_arrays)
            self.assign(piece.target, item)
            if all(self.value(condition) for condition in piece.ifs):
                yield from self.comprehended(node, level + 1)
        self.at.names = kept_arrays

    def assign(self, target: Any, value: Any) -> None:
        """Assign a value to a target."""
        if isinstance(target, ast.Name):
            lanes = self.at.lanes()
            if lanes is None:
                self.at.names[target.id] = value
            else:
                self.keep(target.id, value, lanes)
        elif isinstance(target, (ast.Tuple, ast.List)):
            items = list(value)
            if len(items) != len(target.elts):
                raise NotTraceableError(f"unpacks {len(items)} values into {len(target.elts)}")
            for piece, item in zip(target.elts, items, strict=True):
                self.assign(piece, item)
        elif isinstance(target, ast.Subscript):
            self.value(target.value)[self.index(target.slice)] = value
        else:
            setattr(self.fields(target), target.attr, value)

    def fields(self, target: Any) -> Fields:
        """Return the Fields to which the number of a target belongs."""
        holder = self.value(target.value)
        if not isinstance(holder, Fields) or target.attr not in holder.DECLARED:
            raise NotTraceableError("changes an attribute that is no number in memory")
        return holder

    def keep(self, name: str, value: Any, lanes: Any) -> None:
        """Assign a value to a variable in some lanes."""
        names = self.at.names
        names[name] = blended(lanes, value, names[name]) if name in names else value
