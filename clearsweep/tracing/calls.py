"""Calls of traced bodies, of functions with other emitted code, and of plain Python functions."""

import ast
import itertools
import types
from collections.abc import Callable
from typing import Any, NamedTuple

from . import symbols
from .activation import RETURNED, Activation, syntax_tree, untraceable_error
from .lanes import all_of, none_of
from .memory import View, rebase
from .paths import (
    Path,
    join_paths,
    leaves,
    map_leaves,
    passed_values,
    rebuild,
    receive_values,
    type_key,
    with_common_slopes,
)
from .primitives import BODIES, PRIMITIVES, SEPARATE
from .symbols import Boolean, NotTraceableError, Symbol, is_symbol, trace

RUNNERS: list[Callable] = []  # runs bodies; registers itself, since it calls functions of this module


def run(function: Any, *operands: Any, **keywords: Any) -> Any:
    """Return the result of a function, emitting its operations on symbols."""
    return run_bound(function, _bind_arguments(function, operands, keywords))


def run_bound(function: Any, names: dict[str, Any]) -> Any:
    """Return the result of a function for arguments bound to names."""
    node = syntax_tree(function.__code__)
    closure_values = {}
    if function.__closure__:
        closure_values = dict(
            zip(function.__code__.co_freevars, (c.cell_contents for c in function.__closure__), strict=True)
        )
    activation = Activation(function, names, closure_values)
    active_trace, caller_lanes = trace(), trace().lanes
    active_trace.lanes = activation.lanes_in_all
    try:
        if isinstance(node, ast.Lambda):
            return RUNNERS[0](activation).value(node.body)
        runner = RUNNERS[0](activation)
        if not runner.block(node.body):
            runner.leave(None)
        elif RETURNED in activation.names and not activation.returns:
            runner.leave(activation.names[RETURNED])
        return join_paths(activation.returns)
    except NotTraceableError as error:
        if str(error).startswith(function.__code__.co_filename) or "cannot be traced" in str(error):
            raise
        raise untraceable_error(activation, str(error)) from error
    except Exception as error:
        if not hasattr(error, "traced_at"):
            error.traced_at = True  # type: ignore[attr-defined]
            error.add_note(str(untraceable_error(activation, "fails")))
        raise
    finally:
        active_trace.lanes = caller_lanes


def _bind_arguments(function: Any, operands: tuple, keywords: dict[str, Any]) -> dict[str, Any]:
    code = function.__code__
    count = code.co_argcount
    names = code.co_varnames[:count]
    values = dict(zip(names, operands, strict=False))
    values.update(keywords)
    defaults = function.__defaults__ or ()
    for name, value in zip(names[count - len(defaults) :], defaults, strict=True):
        values.setdefault(name, value)
    if code.co_flags & 0x04:  # takes any number of values
        values[code.co_varnames[count + code.co_kwonlyargcount]] = operands[count:]
    return values


def call(function: Any, *operands: Any, **keywords: Any) -> Any:
    """Return the result of a call, emitting its operations on symbols."""
    try:
        emit = PRIMITIVES.get(function)
    except TypeError:  # it cannot be looked up
        emit = None
    if emit is not None:
        return emit(*operands, **keywords)
    if hasattr(function, "body_of"):
        return call_body(function.body_of(operands[0]), operands, keywords)
    if hasattr(function, "each"):
        return _call_each(function, *operands)
    if hasattr(function, "sides"):
        return _select_call(*function.sides, *operands)
    if hasattr(function, BODIES):
        if getattr(function, BODIES) == SEPARATE:
            return _call_separate(function, operands, keywords)
        return run(function, *operands, **keywords)
    if isinstance(function, Lambda):
        return function(*operands)
    return function(*operands, **keywords)


class _CompiledFunction(NamedTuple):
    """A machine code function, compiled from a body for arguments of certain forms."""

    code: Any
    result: Any  # its result, with placeholders for symbols


class _ResultPlaceholder:
    """Placeholder of a symbol in the result of a function."""

    def __init__(self, index: int, symbol: Symbol):
        self.index, self.kind, self.width = index, type(symbol), symbol.width


def _call_separate(function: Any, operands: tuple, keywords: dict[str, Any]) -> Any:
    """Return the result of a function that is compiled separately, once for each form of arguments."""
    active_trace = trace()
    arguments = {
        name: map_leaves(value, rebase) for name, value in _bind_arguments(function, operands, keywords).items()
    }
    try:
        lanes = active_trace.lanes()
        key = (function, lanes is None, *((name, type_key(value)) for name, value in arguments.items()))
        compiled = active_trace.functions.get(key, ...)
    except (TypeError, NotTraceableError):
        return run(function, *operands, **keywords)
    if compiled is ...:
        compiled = active_trace.functions[key] = _compile(function, arguments, lanes)
    if compiled is None:
        return run(function, *operands, **keywords)
    llvm_operands = [item for value in (lanes, *arguments.values()) for item in passed_values(value)]
    result_struct = active_trace.builder.call(compiled.code, llvm_operands)
    return map_leaves(
        compiled.result,
        lambda item: (
            item.kind(active_trace.builder.extract_value(result_struct, item.index), item.width)
            if isinstance(item, _ResultPlaceholder)
            else item
        ),
    )


def _compile(function: Any, arguments: dict[str, Any], lanes: Any) -> _CompiledFunction | None:
    """Return the machine code function for arguments of these forms, or None if it returns arrays."""
    active_trace, outer_builder, caller_lanes = trace(), trace().builder, trace().lanes
    llvm_operands = [x for value in (lanes, *arguments.values()) for x in passed_values(value)]
    kinds = [x.type for x in llvm_operands]
    name = active_trace.module.get_unique_name(function.__name__)
    machine_function = symbols.ir.Function(
        active_trace.module, symbols.ir.FunctionType(symbols.ir.VoidType(), kinds), name
    )
    active_trace.builder = symbols.ir.IRBuilder(machine_function.append_basic_block())
    received_values = iter(machine_function.args)
    active_lanes = receive_values(lanes, received_values)
    active_trace.lanes = lambda: active_lanes
    parameters = {name: receive_values(value, received_values) for name, value in arguments.items()}
    try:
        symbolic_result = run_bound(function, parameters)
        items = list(leaves(symbolic_result))
        if any(isinstance(x, (View, Lambda)) for x in items):
            del active_trace.module.globals[name]
            return None
        symbols_in_result = [x for x in items if is_symbol(x)]
        return_type = symbols.ir.LiteralStructType([x.value.type for x in symbols_in_result])
        value: Any = symbols.ir.Constant(return_type, symbols.ir.Undefined)
        for position, x in enumerate(symbols_in_result):
            value = active_trace.builder.insert_value(value, x.value, position)
        active_trace.builder.ret(value)
    finally:
        active_trace.builder, active_trace.lanes = outer_builder, caller_lanes
    kind = symbols.ir.FunctionType(return_type, kinds)
    machine_function.ftype, machine_function.type = kind, kind.as_pointer()
    machine_function.return_value = type(machine_function.return_value)(machine_function, return_type)
    machine_function.linkage = "internal"
    count = itertools.count()
    result = map_leaves(symbolic_result, lambda x: _ResultPlaceholder(next(count), x) if is_symbol(x) else x)
    return _CompiledFunction(machine_function, result)


def call_body(body: Any, operands: tuple, keywords: dict[str, Any]) -> Any:
    """Return the result of a registered body, a kernel or not."""
    if isinstance(body, types.FunctionType) and not any(hasattr(body, name) for name in ("body_of", "each", BODIES)):
        return run(body, *operands, **keywords)
    return call(body, *operands, **keywords)


def _call_each(function: Any, items: tuple, partners: tuple, position: Any, context: Any) -> tuple:
    body, next_position = function.each
    results = []
    for item, partner in zip(items, partners, strict=True):
        results.append(call_body(body, (item, partner, position, context), {}))
        position = call(next_position, position, item)
    return tuple(results)


def _select_call(if_true: Any, if_false: Any, condition: Any, operands: tuple) -> Any:
    """Return `if_true(*arguments)` where the condition is true, else `if_false(*arguments)`."""
    if not is_symbol(condition):
        return call_body(if_true if condition else if_false, operands, {})
    if condition.width > 1:
        return _select_call_in_lanes(if_true, if_false, condition, operands)
    builder, active_trace = trace().builder, trace()
    true_block, false_block = active_trace.block(), active_trace.block()
    builder.cbranch(condition.value, true_block, false_block)
    paths = []
    for block, body in ((true_block, if_true), (false_block, if_false)):
        builder.position_at_end(block)
        value = call_body(body, operands, {})
        paths.append(Path(builder.block, value))
    return join_paths(paths)


def _select_call_in_lanes(if_true: Any, if_false: Any, condition: Boolean, operands: tuple) -> Any:
    """Return the result of `_select_call` by lane: only one function runs if all lanes agree, otherwise both."""
    builder, active_trace = trace().builder, trace()
    true_block, not_all_block, mixed_block = active_trace.block(), active_trace.block(), active_trace.block()
    builder.cbranch(all_of(condition).value, true_block, not_all_block)
    builder.position_at_end(true_block)
    value = call_body(if_true, operands, {})
    paths = [Path(builder.block, value)]
    builder.position_at_end(not_all_block)
    second_value = call_body(if_false, operands, {})
    paths.append(Path(builder.block, second_value))
    end = active_trace.block()
    builder.cbranch(none_of(condition).value, end, mixed_block)
    builder.position_at_end(end)
    paths[-1] = Path(end, second_value)
    builder.position_at_end(mixed_block)
    value = call_body(if_true, operands, {})
    value, second_value = with_common_slopes([value, second_value])
    pairs = zip(leaves(value), leaves(second_value), strict=True)
    blended_items = [a if a is b else symbols.select(condition, a, b) for a, b in pairs]
    paths.append(Path(builder.block, rebuild(value, iter(blended_items))))
    return join_paths(paths)


class Lambda:
    """A function defined in a body."""

    def __init__(self, node: ast.Lambda, activation: Activation):
        self.node, self.activation = node, activation

    def __call__(self, *operands: Any) -> Any:
        names = [item.arg for item in self.node.args.args]
        call_activation = Activation(
            self.activation.function,
            self.activation.names | dict(zip(names, operands, strict=True)),
            self.activation.closure,
        )
        return RUNNERS[0](call_activation).value(self.node.body)
