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


def run(function: Any, *given: Any, **named: Any) -> Any:
    """Return the result of a function, emitting its operations on symbols."""
    return run_bound(function, _bound(function, given, named))


def run_bound(function: Any, names: dict[str, Any]) -> Any:
    """Return the same for arguments bound to names."""
    node = tree_of(function.__code__)
    free = {}
    if function.__closure__:
        free = dict(zip(function.__code__.co_freevars, (c.cell_contents for c in function.__closure__), strict=True))
    at_work = Activation(function, names, free)
    hand, asking = trace(), trace().lanes
    hand.lanes = at_work.lanes_in_all
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
        hand.lanes = asking


def _bound(function: Any, given: tuple, named: dict[str, Any]) -> dict[str, Any]:
    code = function.__code__
    count = code.co_argcount
    names = code.co_varnames[:count]
    values = dict(zip(names, given, strict=False))
    values.update(named)
    defaults = function.__defaults__ or ()
    for name, value in zip(names[count - len(defaults) :], defaults, strict=True):
        values.setdefault(name, value)
    if code.co_flags & 0x04:  # takes any number of values
        values[code.co_varnames[count + code.co_kwonlyargcount]] = given[count:]
    return values


def call(function: Any, *given: Any, **named: Any) -> Any:
    """Return the result of a call, emitting its operations on symbols."""
    try:
        emit = PRIMITIVES.get(function)
    except TypeError:  # it cannot be looked up
        emit = None
    if emit is not None:
        return emit(*given, **named)
    if hasattr(function, "body_of"):
        return call_body(function.body_of(given[0]), given, named)
    if hasattr(function, "each"):
        return _mapped(function, *given)
    if hasattr(function, "sides"):
        return _either(*function.sides, *given)
    if hasattr(function, BODIES):
        if getattr(function, BODIES) == ON_ITS_OWN:
            return _on_its_own(function, given, named)
        return run(function, *given, **named)
    if isinstance(function, Lambda):
        return function(*given)
    return function(*given, **named)


class _Function(NamedTuple):
    """A machine code function, compiled from a body for arguments of certain forms."""

    code: Any
    result: Any  # its result, with placeholders for symbols


class _Returned:
    """Placeholder of a symbol in the result of a function."""

    def __init__(self, place: int, symbol: Symbol):
        self.place, self.kind, self.width = place, type(symbol), symbol.width


def _on_its_own(function: Any, given: tuple, named: dict[str, Any]) -> Any:
    """Return the result of a function that is compiled separately, once for each form of arguments."""
    hand = trace()
    call_arguments = _bound(function, given, named)
    try:
        lanes = hand.lanes()
        key = (function, lanes is None, *((name, form_of(value)) for name, value in call_arguments.items()))
        made = hand.functions.get(key, ...)
    except (TypeError, NotTraceableError):
        return run(function, *given, **named)
    if made is ...:
        made = hand.functions[key] = _made(function, call_arguments, lanes)
    if made is None:
        return run(function, *given, **named)
    handed = [x for value in (lanes, *call_arguments.values()) for x in passed(value)]
    returned = hand.builder.call(made.code, handed)
    return changed(
        made.result,
        lambda x: x.kind(hand.builder.extract_value(returned, x.place), x.width) if isinstance(x, _Returned) else x,
    )


def _made(function: Any, call_arguments: dict[str, Any], lanes: Any) -> _Function | None:
    """Return the machine code function for arguments of these forms, or None if it returns arrays."""
    hand, outside, asking = trace(), trace().builder, trace().lanes
    handed = [x for value in (lanes, *call_arguments.values()) for x in passed(value)]
    kinds = [x.type for x in handed]
    name = hand.module.get_unique_name(function.__name__)
    begun = symbols.ir.Function(hand.module, symbols.ir.FunctionType(symbols.ir.VoidType(), kinds), name)
    hand.builder = symbols.ir.IRBuilder(begun.append_basic_block())
    arguments = iter(begun.args)
    asked_for = received(lanes, arguments)
    hand.lanes = lambda: asked_for
    inner = {name: received(value, arguments) for name, value in call_arguments.items()}
    try:
        variant = run_bound(function, inner)
        every = list(leaves(variant))
        if any(isinstance(x, (View, Lambda)) for x in every):
            del hand.module.globals[name]
            return None
        returned = [x for x in every if is_symbol(x)]
        whole = symbols.ir.LiteralStructType([x.value.type for x in returned])
        value: Any = symbols.ir.Constant(whole, symbols.ir.Undefined)
        for place, x in enumerate(returned):
            value = hand.builder.insert_value(value, x.value, place)
        hand.builder.ret(value)
    finally:
        hand.builder, hand.lanes = outside, asking
    kind = symbols.ir.FunctionType(whole, kinds)
    begun.ftype, begun.type = kind, kind.as_pointer()
    begun.return_value = type(begun.return_value)(begun, whole)
    begun.linkage = "internal"
    count = itertools.count()
    result = changed(variant, lambda x: _Returned(next(count), x) if is_symbol(x) else x)
    return _Function(begun, result)


def call_body(body: Any, given: tuple, named: dict[str, Any]) -> Any:
    """Return the result of a registered body, a kernel or not."""
    if isinstance(body, types.FunctionType) and not any(hasattr(body, name) for name in ("body_of", "each", BODIES)):
        return run(body, *given, **named)
    return call(body, *given, **named)


def _mapped(function: Any, items: tuple, partners: tuple, place: Any, shared: Any) -> tuple:
    single, following = function.each
    results = []
    for item, partner in zip(items, partners, strict=True):
        results.append(call_body(single, (item, partner, place, shared), {}))
        place = call(following, place, item)
    return tuple(results)


def _either(first: Any, second: Any, condition: Any, given: tuple) -> Any:
    """Return `first(*given)` where the condition is true, else `second(*given)`."""
    if not is_symbol(condition):
        return call_body(first if condition else second, given, {})
    if condition.width > 1:
        return _either_in_lanes(first, second, condition, given)
    builder, hand = trace().builder, trace()
    single, other = hand.block(), hand.block()
    builder.cbranch(condition.value, single, other)
    paths = []
    for block, body in ((single, first), (other, second)):
        builder.position_at_end(block)
        value = call_body(body, given, {})
        paths.append(Path(builder.block, value))
    return joined(paths)


def _either_in_lanes(first: Any, second: Any, condition: Truth, given: tuple) -> Any:
    """Return the same by lane: only one function runs if all lanes agree, otherwise both."""
    builder, hand = trace().builder, trace()
    single, other, mixed = hand.block(), hand.block(), hand.block()
    builder.cbranch(all_of(condition).value, single, other)
    builder.position_at_end(single)
    value = call_body(first, given, {})
    paths = [Path(builder.block, value)]
    builder.position_at_end(other)
    rest = call_body(second, given, {})
    paths.append(Path(builder.block, rest))
    end = hand.block()
    builder.cbranch(none_of(condition).value, end, mixed)
    builder.position_at_end(end)
    paths[-1] = Path(end, rest)
    builder.position_at_end(mixed)
    value = call_body(first, given, {})
    value, rest = alike([value, rest])
    pairs = zip(leaves(value), leaves(rest), strict=True)
    blend = [a if a is b else symbols.selected(condition, a, b) for a, b in pairs]
    paths.append(Path(builder.block, rebuilt(value, iter(blend))))
    return joined(paths)


class Lambda:
    """A function defined in a body."""

    def __init__(self, node: ast.Lambda, at_work: Activation):
        self.node, self.at_work = node, at_work

    def __call__(self, *given: Any) -> Any:
        names = [item.arg for item in self.node.args.args]
        inner = Activation(
            self.at_work.function, self.at_work.names | dict(zip(names, given, strict=True)), self.at_work.free
        )
        return RUNNERS[0](inner).value(self.node.body)
