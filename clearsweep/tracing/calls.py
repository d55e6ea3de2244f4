"""Calls of traced bodies, of functions with other emitted code, and of what Python may run while tracing."""

import ast
import inspect
import itertools
import types
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

from . import protocols, symbols
from .activation import (
    RETURNED,
    Activation,
    Path,
    all_of,
    join_paths,
    leaves,
    map_leaves,
    none_of,
    passed_values,
    place_of,
    receive_values,
    select_values,
    syntax_tree,
    type_key,
)
from .memory import View, rebase
from .protocols import KNOWN, PRIMITIVES, SEPARATE, Composite, mode_of
from .symbols import Boolean, NotTraceableError, Symbol, is_symbol, trace

RUNNERS: list[Callable] = []  # runs bodies; registers itself, since it calls functions of this module

# What Python may run while a body is traced: it has no effect, and sees numbers known at run time only as items.
STRUCTURAL = (tuple, list, range, zip, enumerate, reversed, len, hasattr, getattr, type)
PURE = (any, all, sum, sorted, round, divmod, callable, repr, ord, chr, issubclass, slice, str, dict, set, frozenset)
PURE_METHODS = {
    str: None,  # all
    tuple: ("index", "count"),
    list: ("index", "count"),
    range: ("index", "count"),
    dict: ("get", "items", "keys", "values"),
    int: None,
    float: None,
}
NAMED_TUPLE_METHODS = ("_replace", "_asdict", "_make")


def run(function: Any, *operands: Any, **keywords: Any) -> Any:
    """Return the result of a function, emitting its operations on symbols."""
    return run_bound(function, _bind_arguments(function, operands, keywords))


def run_bound(function: Any, names: dict[str, Any]) -> Any:
    """Return the result of a function for arguments bound to names."""
    node = syntax_tree(function.__code__)
    trace().sources.add(function.__code__.co_filename)
    cells = function.__closure__ or ()
    closure = {name: c.cell_contents for name, c in zip(function.__code__.co_freevars, cells, strict=True)}
    activation = Activation(function, names, closure)
    active_trace, caller_lanes = trace(), trace().lanes
    active_trace.lanes = activation.lanes_in_all
    try:
        return _run_activation(activation, node)
    except NotTraceableError as error:
        _add_place(error, activation)
        raise
    except Exception as error:
        endless = isinstance(error, RecursionError)
        failure = NotTraceableError(
            "calls itself without end" if endless else f"fails with {type(error).__name__}: {error}"
        )
        _add_place(failure, activation)
        raise failure from error
    finally:
        active_trace.lanes = caller_lanes


def _run_activation(activation: Activation, node: Any) -> Any:
    runner = RUNNERS[0](activation)
    if isinstance(node, ast.Lambda):
        activation.node = node
        return runner.value(node.body)
    if any(isinstance(value, Iterator) for value in activation.names.values()):
        raise NotTraceableError("receives an iterator, which could be used only once")
    if not runner.block(node.body):
        runner.leave(None)
    elif RETURNED in activation.names and not activation.returns:
        runner.leave(activation.names[RETURNED])
    return join_paths(activation.returns)


def _add_place(error: NotTraceableError, activation: Activation) -> None:
    place, text = place_of(activation.function, activation.node)
    name = activation.function.__code__.co_name
    reason = "called by {name}" if error.places else f"{{name}} cannot be traced: it {error.args[0]}"
    error.add_place(f"{place}: {reason.replace('{name}', name)}: {text}")


def _bind_arguments(function: Any, operands: tuple, keywords: dict[str, Any]) -> dict[str, Any]:
    code = function.__code__
    is_variable = code.co_flags & (inspect.CO_VARARGS | inspect.CO_VARKEYWORDS)
    if not (keywords or is_variable or code.co_kwonlyargcount) and len(operands) == code.co_argcount:
        return dict(zip(code.co_varnames[: code.co_argcount], operands, strict=True))
    try:
        bound = inspect.signature(function, follow_wrapped=False).bind(*operands, **keywords)
    except TypeError as error:
        raise NotTraceableError(f"calls {code.co_name} with other arguments than it takes: {error}") from None
    bound.apply_defaults()
    return bound.arguments


def is_foreign(function: Any) -> bool:
    """Return whether a function of Python is none of the tracer."""
    module = getattr(function, "__module__", None) or ""
    return isinstance(function, types.FunctionType) and not module.startswith(__package__)


def call(function: Any, *operands: Any, **keywords: Any) -> Any:
    """Return the result of a call, emitting its operations on symbols."""
    try:
        emit = PRIMITIVES.get(function)
    except TypeError:  # it cannot be looked up
        emit = None
    if emit is not None:
        return emit(*operands, **keywords)
    if body := protocols.body_of(function, operands):
        trace().chooses = True
        return call(body, *operands, **keywords)
    if both := protocols.sides(function):
        return _select_call(*both, *operands)
    mode = mode_of(function)
    if mode == SEPARATE:
        return _call_separate(function, operands, keywords)
    if mode == KNOWN:
        trace().sources.add(function.__code__.co_filename)
    if mode == KNOWN or isinstance(function, Lambda):
        return function(*operands, **keywords)
    if isinstance(function, types.MethodType) and is_foreign(function.__func__):
        if isinstance(function.__self__, (tuple, type)) and function.__name__ in NAMED_TUPLE_METHODS:
            return function(*operands, **keywords)
        return call(function.__func__, function.__self__, *operands, **keywords)
    if mode or is_foreign(function):
        return run(function, *operands, **keywords)
    if isinstance(body := getattr(function, "py_func", None), types.FunctionType):  # a function of numba
        return call(body, *operands, **keywords)
    return _call_known(function, operands, keywords)


def _call_known(function: Any, operands: tuple, keywords: dict[str, Any]) -> Any:
    """Return the result of a class, or of a function that Python runs while tracing, if it has no effect."""
    values = (*operands, *keywords.values())
    if function is isinstance:
        _check_classes(*operands)
    elif function is map:
        return [call(operands[0], *items) for items in zip(*operands[1:], strict=False)]
    elif isinstance(function, type) and issubclass(function, (tuple, Composite, View)) and not _has_own_code(function):
        return function(*operands, **keywords)
    elif function in STRUCTURAL:
        if function in (hasattr, getattr, type) and isinstance(operands[0], (Symbol, View)):
            raise NotTraceableError("asks for type or attribute of what is known only at run time")
    elif isinstance(function, types.FunctionType) or isinstance(
        getattr(function, "__func__", None), types.FunctionType
    ):
        return function(*operands, **keywords)  # of the tracer itself
    elif not (function in PURE or _is_pure_method(function)):
        name = getattr(function, "__qualname__", type(function).__qualname__)
        raise NotTraceableError(f"calls {name}, which is not compiled and may have an effect")
    elif any(map(_is_at_run_time, values)):
        raise NotTraceableError(f"calls {function.__qualname__} with what is known only at run time")
    return function(*operands, **keywords)


def _is_at_run_time(x: Any) -> bool:
    """Return whether a value has parts that are known only at run time."""
    if isinstance(x, list):
        return any(map(_is_at_run_time, x))
    return any(isinstance(item, (Symbol, View, Lambda)) for item in leaves(x))


def _check_classes(value: Any, classes: Any) -> None:
    """Raise an error if Python's answer to isinstance depends on a number that is known only at run time."""
    named = classes if isinstance(classes, tuple) else (classes,)
    if isinstance(value, (Symbol, View)) and not all(issubclass(x, (tuple, Composite)) for x in named):
        raise NotTraceableError("asks for the type of a number or array known only at run time")


def _has_own_code(cls: type) -> bool:
    """Return whether Python code of the class makes its values, but for what namedtuple writes."""
    makers = [vars(base).get(name) for base in cls.__mro__ for name in ("__new__", "__init__")]
    makers = [maker for maker in makers if is_foreign(getattr(maker, "__func__", maker))]
    return any(getattr(maker, "__func__", maker).__code__.co_filename != "<string>" for maker in makers)


def _is_pure_method(function: Any) -> bool:
    owner = getattr(function, "__self__", None)
    if not isinstance(function, (types.BuiltinMethodType, types.MethodWrapperType)) or type(owner) not in PURE_METHODS:
        return False
    names = PURE_METHODS[type(owner)]
    return names is None or function.__name__ in names


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
    name = active_trace.module.get_unique_name(function.__name__)
    result_type = active_trace.module.context.get_identified_type(f"result of {name}")  # its items follow
    kind = symbols.ir.FunctionType(result_type, [x.type for x in llvm_operands])
    machine_function = symbols.ir.Function(active_trace.module, kind, name)
    machine_function.linkage = "internal"
    active_trace.builder = symbols.ir.IRBuilder(machine_function.append_basic_block())
    received_values = iter(machine_function.args)
    active_lanes = receive_values(lanes, received_values)
    active_trace.lanes = lambda: active_lanes
    parameters = {name: receive_values(value, received_values) for name, value in arguments.items()}
    try:
        symbolic_result = run_bound(function, parameters)
        items = leaves(symbolic_result)
        if any(isinstance(x, (View, Lambda, list)) for x in items):
            result_type.set_body()
            active_trace.builder.unreachable()  # LLVM removes it, as nothing calls it
            return None
        symbols_in_result = [x for x in items if is_symbol(x)]
        result_type.set_body(*(x.value.type for x in symbols_in_result))
        value: Any = symbols.ir.Constant(result_type, symbols.ir.Undefined)
        for position, x in enumerate(symbols_in_result):
            value = active_trace.builder.insert_value(value, x.value, position)
        active_trace.builder.ret(value)
    finally:
        active_trace.builder, active_trace.lanes = outer_builder, caller_lanes
    count = itertools.count()
    result = map_leaves(symbolic_result, lambda x: _ResultPlaceholder(next(count), x) if is_symbol(x) else x)
    return _CompiledFunction(machine_function, result)


def _select_call(if_true: Any, if_false: Any, condition: Any, operands: tuple) -> Any:
    """Return `if_true(*arguments)` where the condition is true, else `if_false(*arguments)`."""
    if not is_symbol(condition):
        return call(if_true if condition else if_false, *operands)
    if condition.width > 1:
        return _select_call_in_lanes(if_true, if_false, condition, operands)
    builder, active_trace = trace().builder, trace()
    true_block, false_block = active_trace.block(), active_trace.block()
    builder.cbranch(condition.value, true_block, false_block)
    paths = []
    for block, body in ((true_block, if_true), (false_block, if_false)):
        builder.position_at_end(block)
        value = call(body, *operands)
        paths.append(Path(builder.block, value))
    return join_paths(paths)


def _select_call_in_lanes(if_true: Any, if_false: Any, condition: Boolean, operands: tuple) -> Any:
    """Return the result of `_select_call` by lane: only one function runs if all lanes agree, otherwise both."""
    builder, active_trace = trace().builder, trace()
    true_block, not_all_block, mixed_block = active_trace.block(), active_trace.block(), active_trace.block()
    builder.cbranch(all_of(condition).value, true_block, not_all_block)
    builder.position_at_end(true_block)
    value = call(if_true, *operands)
    paths = [Path(builder.block, value)]
    builder.position_at_end(not_all_block)
    second_value = call(if_false, *operands)
    paths.append(Path(builder.block, second_value))
    end = active_trace.block()
    builder.cbranch(none_of(condition).value, end, mixed_block)
    builder.position_at_end(end)
    paths[-1] = Path(end, second_value)
    builder.position_at_end(mixed_block)
    value = call(if_true, *operands)
    blended_value = select_values(condition, value, second_value)
    paths.append(Path(builder.block, blended_value))
    return join_paths(paths)


class Lambda:
    """A function defined in a body, with the values of its last arguments if a call does not give them."""

    def __init__(self, node: ast.Lambda, activation: Activation, defaults: tuple):
        self.node, self.activation, self.defaults = node, activation, defaults

    def __call__(self, *operands: Any, **keywords: Any) -> Any:
        names = [item.arg for item in self.node.args.args]
        given = dict(zip(names[len(names) - len(self.defaults) :], self.defaults, strict=True))
        given |= dict(zip(names, operands, strict=False)) | keywords
        if len(operands) > len(names) or set(given) != set(names) or set(names[: len(operands)]) & set(keywords):
            raise NotTraceableError("calls a function with other arguments than it takes")
        outer = self.activation
        call_activation = Activation(outer.function, outer.names | given, outer.closure)
        call_activation.node = self.node
        return RUNNERS[0](call_activation).value(self.node.body)
