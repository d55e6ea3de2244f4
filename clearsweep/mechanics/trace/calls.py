"""Calls of traced bodies, of functions with other emitted code, and of plain Python functions."""

import ast
import itertools
import types
from collections.abc import Callable
from typing import Any, NamedTuple

from . import symbols
from .activation import RETURNED, Activation, refusal, tree_of
from .lanes import all_of, none_of
from .memory import View
from .paths import Path, alike, changed, form_of, joined, leaves, passed, rebuilt, received
from .primitives import BODIES, ON_ITS_OWN, PRIMITIVES
from .symbols import NotTraceableError, Symbol, Truth, is_symbol, trace

RUNNERS: list[Callable] = []  # runs bodies; registers itself, since it calls functions of this module


def run(function: Any, *operands: Any, **named: Any) -> Any:
    """Return the result of a function, emitting its operations on symbols."""
    return run_bound(function, _bound(function, operands, named))


def run_bound(function: Any, names: dict[str, Any]) -> Any:
    """Return the result of a function for arguments bound to names."""
    node = tree_of(function.__code__)
    free = {}
    if function.__closure__:
        free = dict(zip(function.__code__.co_freevars, (c.cell_contents for c in function.__closure__), strict=True))
    at_work = Activation(function, names, free)
    active_trace, asking = trace(), trace().lanes
    active_trace.lanes = at_work.lanes_in_all
    try:
        if isinstance(node, ast.Lambda):
            return RUNNERS[0](at_work).value(node.body)
        runner = RUNNERS[0](at_work)
        if not runner.block(node.body):
            runner.leave(None)
        elif RETURNED in at_work.names and not at_work.returns:
            runner.leave(at_work.names[RETURNED])
        return joined(at_work.returns)
    except NotTraceableError as error:
        if str(error).startswith(function.__code__.co_filename) or "cannot be traced" in str(error):
            raise
        raise refusal(at_work, str(error)) from error
    except Exception as error:
        if not hasattr(error, "traced_at"):
            error.traced_at = True  # type: ignore[attr-defined]
            error.add_note(str(refusal(at_work, "fails")))
        raise
    finally:
        active_trace.lanes = asking


def _bound(function: Any, operands: tuple, named: dict[str, Any]) -> dict[str, Any]:
    code = function.__code__
    count = code.co_argcount
    names = code.co_varnames[:count]
    values = dict(zip(names, operands, strict=False))
    values.update(named)
    defaults = function.__defaults__ or ()
    for name, value in zip(names[count - len(defaults) :], defaults, strict=True):
        values.setdefault(name, value)
    if code.co_flags & 0x04:  # takes any number of values
        values[code.co_varnames[count + code.co_kwonlyargcount]] = operands[count:]
    return values


def call(function: Any, *operands: Any, **named: Any) -> Any:
    """Return the result of a call, emitting its operations on symbols."""
    try:
        emit = PRIMITIVES.get(function)
    except TypeError:  # it cannot be looked up
        emit = None
    if emit is not None:
        return emit(*operands, **named)
    if hasattr(function, "body_of"):
        return call_body(function.body_of(operands[0]), operands, named)
    if hasattr(function, "each"):
        return _mapped(function, *operands)
    if hasattr(function, "sides"):
        return _either(*function.sides, *operands)
    if hasattr(function, BODIES):
        if getattr(function, BODIES) == ON_ITS_OWN:
            return _on_its_own(function, operands, named)
        return run(function, *operands, **named)
    if isinstance(function, Lambda):
        return function(*operands)
    return function(*operands, **named)


class _Function(NamedTuple):
    """A machine code function, compiled from a body for arguments of certain forms."""

    code: Any
    result: Any  # its result, with placeholders for symbols


class _Returned:
    """Placeholder of a symbol in the result of a function."""

    def __init__(self, position: int, symbol: Symbol):
        self.place, self.kind, self.width = position, type(symbol), symbol.width


def _on_its_own(function: Any, operands: tuple, named: dict[str, Any]) -> Any:
    """Return the result of a function that is compiled separately, once for each form of arguments."""
    active_trace = trace()
    call_arguments = _bound(function, operands, named)
    try:
        lanes = active_trace.lanes()
        key = (function, lanes is None, *((name, form_of(value)) for name, value in call_arguments.items()))
        results = active_trace.functions.get(key, ...)
    except (TypeError, NotTraceableError):
        return run(function, *operands, **named)
    if results is ...:
        results = active_trace.functions[key] = _made(function, call_arguments, lanes)
    if results is None:
        return run(function, *operands, **named)
    handed = [x for value in (lanes, *call_arguments.values()) for x in passed(value)]
    returned = active_trace.builder.call(results.code, handed)
    return changed(
        results.result,
        lambda x: (
            x.kind(active_trace.builder.extract_value(returned, x.place), x.width) if isinstance(x, _Returned) else x
        ),
    )


def _made(function: Any, call_arguments: dict[str, Any], lanes: Any) -> _Function | None:
    """Return the machine code function for arguments of these forms, or None if it returns arrays."""
    active_trace, outside, asking = trace(), trace().builder, trace().lanes
    handed = [x for value in (lanes, *call_arguments.values()) for x in passed(value)]
    kinds = [x.type for x in handed]
    name = active_trace.module.get_unique_name(function.__name__)
    begun = symbols.ir.Function(active_trace.module, symbols.ir.FunctionType(symbols.ir.VoidType(), kinds), name)
    active_trace.builder = symbols.ir.IRBuilder(begun.append_basic_block())
    arguments = iter(begun.args)
    asked_for = received(lanes, arguments)
    active_trace.lanes = lambda: asked_for
    inner = {name: received(value, arguments) for name, value in call_arguments.items()}
    try:
        variant = run_bound(function, inner)
        every = list(leaves(variant))
        if any(isinstance(x, (View, Lambda)) for x in every):
            del active_trace.module.globals[name]
            return None
        returned = [x for x in every if is_symbol(x)]
        is_whole = symbols.ir.LiteralStructType([x.value.type for x in returned])
        value: Any = symbols.ir.Constant(is_whole, symbols.ir.Undefined)
        for position, x in enumerate(returned):
            value = active_trace.builder.insert_value(value, x.value, position)
        active_trace.builder.ret(value)
    finally:
        active_trace.builder, active_trace.lanes = outside, asking
    kind = symbols.ir.FunctionType(is_whole, kinds)
    begun.ftype, begun.type = kind, kind.as_pointer()
    begun.return_value = type(begun.return_value)(begun, is_whole)
    begun.linkage = "internal"
    count = itertools.count()
    result = changed(variant, lambda x: _Returned(next(count), x) if is_symbol(x) else x)
    return _Function(begun, result)


def call_body(body: Any, operands: tuple, named: dict[str, Any]) -> Any:
    """Return the result of a registered body, a kernel or not."""
    if isinstance(body, types.FunctionType) and not any(hasattr(body, name) for name in ("body_of", "each", BODIES)):
        return run(body, *operands, **named)
    return call(body, *operands, **named)


def _mapped(function: Any, items: tuple, partners: tuple, position: Any, shared: Any) -> tuple:
    one_lane, following = function.each
    results = []
    for item, partner in zip(items, partners, strict=True):
        results.append(call_body(one_lane, (item, partner, position, shared), {}))
        position = call(following, position, item)
    return tuple(results)


def _either(leading: Any, second: Any, condition: Any, operands: tuple) -> Any:
    """Return `first(*given)` where the condition is true, else `second(*given)`."""
    if not is_symbol(condition):
        return call_body(leading if condition else second, operands, {})
    if condition.width > 1:
        return _either_in_lanes(leading, second, condition, operands)
    builder, active_trace = trace().builder, trace()
    one_lane, right_operand = active_trace.block(), active_trace.block()
    builder.cbranch(condition.value, one_lane, right_operand)
    paths = []
    for block, body in ((one_lane, leading), (right_operand, second)):
        builder.position_at_end(block)
        value = call_body(body, operands, {})
        paths.append(Path(builder.block, value))
    return joined(paths)


def _either_in_lanes(leading: Any, second: Any, condition: Truth, operands: tuple) -> Any:
    """Return the result of `_either` by lane: only one function runs if all lanes agree, otherwise both."""
    builder, active_trace = trace().builder, trace()
    one_lane, right_operand, divergent = active_trace.block(), active_trace.block(), active_trace.block()
    builder.cbranch(all_of(condition).value, one_lane, right_operand)
    builder.position_at_end(one_lane)
    value = call_body(leading, operands, {})
    paths = [Path(builder.block, value)]
    builder.position_at_end(right_operand)
    remaining = call_body(second, operands, {})
    paths.append(Path(builder.block, remaining))
    end = active_trace.block()
    builder.cbranch(none_of(condition).value, end, divergent)
    builder.position_at_end(end)
    paths[-1] = Path(end, remaining)
    builder.position_at_end(divergent)
    value = call_body(leading, operands, {})
    value, remaining = alike([value, remaining])
    pairs = zip(leaves(value), leaves(remaining), strict=True)
    blend = [a if a is b else symbols.selected(condition, a, b) for a, b in pairs]
    paths.append(Path(builder.block, rebuilt(value, iter(blend))))
    return joined(paths)


class Lambda:
    """A function defined in a body."""

    def __init__(self, node: ast.Lambda, at_work: Activation):
        self.node, self.at_work = node, at_work

    def __call__(self, *operands: Any) -> Any:
        names = [item.arg for item in self.node.args.args]
        inner = Activation(
            self.at_work.function, self.at_work.names | dict(zip(names, operands, strict=True)), self.at_work.free
        )
        return RUNNERS[0](inner).value(self.node.body)
