"""Runs the body of a function on symbols, statement by statement, as its syntax tree has it.

What is known while tracing is worked out by Python: which law it is, how many joints there are, whether a number has a
slope.  A decision on a symbol becomes two blocks, whose variables meet behind it; a loop whose end is not known, or
that may end early, becomes a loop of blocks.  Other loops are written out.
"""

import ast
import builtins
import functools
import itertools
import linecache
import math
import types
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np

from . import symbols
from .symbols import NotTraceable, Number, Path, Symbol, Truth, View, Whole, is_symbol, joined, trace

_PRIMITIVES: dict[Any, Callable] = {}  # functions that are emitted otherwise than by their bodies
_RULES: dict[str, Callable] = {}  # operation of Python -> what does it to numbers with slopes
_BODIES = "__traced__"  # attribute of a function: its body is run here wherever it is called, ON_ITS_OWN or INSIDE
ON_ITS_OWN, INSIDE = "on its own", "inside"  # as a function of machine code, or as a part of its caller


def primitive(*functions: Any) -> Callable:
    """Enter what emits a call of any of these functions where one of the values given is a symbol."""

    def enter(emit: Callable) -> Callable:
        for function in functions:
            _PRIMITIVES[function] = emit
        return emit

    return enter


def rules_of_slopes(rules: dict[str, Callable]) -> None:
    """Enter what is done to numbers with slopes, by the operation of Python."""
    _RULES.update(rules)


def traceable(function: Any, how: str = INSIDE) -> Any:
    """Return a function marked so that its body is run on symbols."""
    setattr(function, _BODIES, how)
    return function


LARGEST_POWER = 16  # of whole powers that are written out
LANES = "lanes "  # names of variables that hold in which lanes a function, a loop or its turn goes on
RETURNED = "returned "  # name of the variable that holds what was returned in lanes that go on no more
_NUMBERS = itertools.count()  # of activations


class _Returns(Exception):  # noqa: N818 - it is no error: the loop is emitted anew
    """A loop returns a value in some lanes, for which there is to be a variable when it begins."""

    def __init__(self, value: Any):
        super().__init__()
        self.value = value


class _Loop(NamedTuple):
    """Where the paths that leave a turn of a loop are kept."""

    breaks: list[Path]
    goes_on: list[Path]


class _Activation:
    """A function at work."""

    __slots__ = ("asked_by", "free", "function", "loops", "mask", "names", "node", "number", "returns")

    def __init__(self, function: Any, names: dict[str, Any], free: dict[str, Any]):
        self.function, self.names, self.free = function, names, free
        self.returns: list[Path] = []
        self.loops: list[_Loop] = []
        self.node: Any = None
        self.number = next(_NUMBERS)
        self.mask: Any = None  # in which lanes a statement is to do something; None: in all
        self.asked_by: Any = trace().lanes()  # in which lanes the function is wanted

    def lanes(self) -> Any:
        """Return in which lanes a statement does something, as far as this function decides; None: in all."""
        found = self.mask
        for name, there in self.names.items():
            if name.startswith(LANES):
                found = there if found is None else symbols.both(found, there)
        return found

    def lanes_in_all(self) -> Any:
        """Return the same, as all functions at work decide."""
        found = self.lanes()
        if found is None or self.asked_by is None:
            return self.asked_by if found is None else found
        return symbols.both(self.asked_by, found)

    def look_up(self, name: str) -> Any:
        """Return what a name stands for."""
        for space in (self.names, self.free, self.function.__globals__):
            if name in space:
                return space[name]
        try:
            return getattr(builtins, name)
        except AttributeError:
            raise NotTraceable(f"uses {name}, which has no value on every path") from None


@functools.cache
def _trees(file: str, first: int, count: int) -> dict[int, Any]:
    text = "".join(linecache.getlines(file))
    found: dict[int, Any] = {}
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.FunctionDef):
            begin = min([node.lineno, *(item.lineno for item in node.decorator_list)])
            found[begin] = node
        elif isinstance(node, ast.Lambda):
            found.setdefault(node.lineno, node)
    return found


@functools.cache
def _tree(code: types.CodeType) -> Any:
    lines = linecache.getlines(code.co_filename)
    trees = _trees(code.co_filename, hash("".join(lines)), len(lines))
    if code.co_firstlineno not in trees:
        raise NotTraceable(f"is a function whose source is not at hand: {code.co_name}")
    return trees[code.co_firstlineno]


@functools.cache
def _stored(node: Any) -> tuple[str, ...]:
    """Return the names that a statement, or what is in it, gives values."""
    names = [n.id for n in ast.walk(node) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)]
    return tuple(dict.fromkeys(names))


@functools.cache
def _contains(node: Any, kind: type) -> bool:
    """Return whether there is a statement of a kind in a loop."""
    return any(isinstance(n, kind) for statement in node.body for n in ast.walk(statement))


def _without(names: dict[str, Any], name: str) -> dict[str, Any]:
    return {key: value for key, value in names.items() if key != name}


def _refusal(activation: _Activation, reason: str) -> NotTraceable:
    code, line = activation.function.__code__, getattr(activation.node, "lineno", 0)
    text = linecache.getline(code.co_filename, line).strip()
    return NotTraceable(f"{code.co_filename}:{line}: {code.co_name} cannot be traced: it {reason}: {text}")


def run(function: Any, *given: Any, **named: Any) -> Any:
    """Return what a function returns, emitting what it does to symbols."""
    return run_bound(function, _bound(function, given, named))


def run_bound(function: Any, names: dict[str, Any]) -> Any:
    """Return the same where the names of what is given are known."""
    node = _tree(function.__code__)
    free = {}
    if function.__closure__:
        free = dict(zip(function.__code__.co_freevars, (c.cell_contents for c in function.__closure__), strict=True))
    at_work = _Activation(function, names, free)
    hand, asking = trace(), trace().lanes
    hand.lanes = at_work.lanes_in_all
    try:
        if isinstance(node, ast.Lambda):
            return _Runner(at_work).value(node.body)
        runner = _Runner(at_work)
        if not runner.block(node.body):
            runner.leave(None)
        elif RETURNED in at_work.names and not at_work.returns:
            runner.leave(at_work.names[RETURNED])
        return joined(at_work.returns)
    except NotTraceable as error:
        if str(error).startswith(function.__code__.co_filename) or "cannot be traced" in str(error):
            raise
        raise _refusal(at_work, str(error)) from error
    except Exception as error:
        if not hasattr(error, "traced_at"):
            error.traced_at = True  # type: ignore[attr-defined]
            error.add_note(str(_refusal(at_work, "fails")))
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
    """Return what a call returns, emitting what it does to symbols."""
    try:
        emit = _PRIMITIVES.get(function)
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
    if hasattr(function, _BODIES):
        if getattr(function, _BODIES) == ON_ITS_OWN:
            return _on_its_own(function, given, named)
        return run(function, *given, **named)
    if isinstance(function, _Lambda):
        return function(*given)
    return function(*given, **named)


class _Function(NamedTuple):
    """A function of machine code, made of a body for values of certain forms."""

    code: Any
    result: Any  # what it returns, with places in what the code returns for symbols


class _Returned:
    """The place of a symbol in what the code of a function returns."""

    def __init__(self, place: int, symbol: Symbol):
        self.place, self.kind, self.width = place, type(symbol), symbol.width


def _on_its_own(function: Any, given: tuple, named: dict[str, Any]) -> Any:
    """Return what a function returns that becomes one of machine code, once for values of each form."""
    hand = trace()
    bound = _bound(function, given, named)
    try:
        lanes = hand.lanes()
        key = (function, lanes is None, *((name, symbols.form_of(value)) for name, value in bound.items()))
        made = hand.functions.get(key, ...)
    except (TypeError, NotTraceable):
        return run(function, *given, **named)
    if made is ...:
        made = hand.functions[key] = _made(function, bound, lanes)
    if made is None:
        return run(function, *given, **named)
    passed = [x for value in (lanes, *bound.values()) for x in symbols.passed(value)]
    returned = hand.builder.call(made.code, passed)
    return symbols.changed(
        made.result,
        lambda x: x.kind(hand.builder.extract_value(returned, x.place), x.width) if isinstance(x, _Returned) else x,
    )


def _made(function: Any, bound: dict[str, Any], lanes: Any) -> _Function | None:
    """Return the function of machine code for values of these forms, None where it returns arrays."""
    hand, outside, asking = trace(), trace().builder, trace().lanes
    passed = [x for value in (lanes, *bound.values()) for x in symbols.passed(value)]
    kinds = [x.type for x in passed]
    name = hand.module.get_unique_name(function.__name__)
    begun = symbols.ir.Function(hand.module, symbols.ir.FunctionType(symbols.ir.VoidType(), kinds), name)
    hand.builder = symbols.ir.IRBuilder(begun.append_basic_block())
    arguments = iter(begun.args)
    asked_for = symbols.received(lanes, arguments)
    hand.lanes = lambda: asked_for
    inner = {name: symbols.received(value, arguments) for name, value in bound.items()}
    try:
        found = run_bound(function, inner)
        every = list(symbols.leaves(found))
        if any(isinstance(x, (View, _Lambda)) for x in every):
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
    result = symbols.changed(found, lambda x: _Returned(next(count), x) if is_symbol(x) else x)
    return _Function(begun, result)


def call_body(body: Any, given: tuple, named: dict[str, Any]) -> Any:
    """Return what a body returns that is entered somewhere, itself a kernel or not."""
    if isinstance(body, types.FunctionType) and not any(hasattr(body, name) for name in ("body_of", "each", _BODIES)):
        return run(body, *given, **named)
    return call(body, *given, **named)


def _mapped(function: Any, items: tuple, partners: tuple, place: Any, shared: Any) -> tuple:
    one, following = function.each
    results = []
    for item, partner in zip(items, partners, strict=True):
        results.append(call_body(one, (item, partner, place, shared), {}))
        place = call(following, place, item)
    return tuple(results)


def _either(first: Any, second: Any, condition: Any, given: tuple) -> Any:
    """Return `first(*given)` where the condition holds, else `second(*given)`."""
    if not is_symbol(condition):
        return call_body(first if condition else second, given, {})
    if condition.width > 1:
        return _either_in_lanes(first, second, condition, given)
    builder, hand = trace().builder, trace()
    one, other = hand.block(), hand.block()
    builder.cbranch(condition.value, one, other)
    paths = []
    for block, body in ((one, first), (other, second)):
        builder.position_at_end(block)
        value = call_body(body, given, {})
        paths.append(Path(builder.block, value))
    return joined(paths)


def _either_in_lanes(first: Any, second: Any, condition: Truth, given: tuple) -> Any:
    """Return the same lane by lane: one of them runs where all lanes want that, else both."""
    builder, hand = trace().builder, trace()
    one, other, mixed = hand.block(), hand.block(), hand.block()
    builder.cbranch(everywhere(condition).value, one, other)
    builder.position_at_end(one)
    value = call_body(first, given, {})
    paths = [Path(builder.block, value)]
    builder.position_at_end(other)
    rest = call_body(second, given, {})
    paths.append(Path(builder.block, rest))
    end = hand.block()
    builder.cbranch(nowhere(condition).value, end, mixed)
    builder.position_at_end(end)
    paths[-1] = Path(end, rest)
    builder.position_at_end(mixed)
    value = call_body(first, given, {})
    value, rest = symbols.alike([value, rest])
    pairs = zip(symbols.leaves(value), symbols.leaves(rest), strict=True)
    blend = [a if a is b else symbols.selected(condition, a, b) for a, b in pairs]
    paths.append(Path(builder.block, symbols.rebuilt(value, iter(blend))))
    return joined(paths)


def _lanes(condition: Any, number: int) -> Any:
    builder = trace().builder
    if not is_symbol(condition):
        return bool(condition) if number else not condition
    if condition.width == 1:
        return condition if number else symbols.opposite(condition)
    bits = builder.bitcast(condition.value, symbols.ir.IntType(condition.width))
    return Truth(builder.icmp_signed("==", bits, symbols.ir.Constant(bits.type, number)))


def everywhere(condition: Any) -> Any:
    """Emit whether a condition holds in every lane."""
    return _lanes(condition, -1)


def nowhere(condition: Any) -> Any:
    """Emit whether a condition holds in no lane."""
    return _lanes(condition, 0)


def _all_lanes(width: int) -> Truth:
    """Return yes in every lane."""
    return Truth(symbols.constant(symbols.BIT, True, width), width)


def _none(x: Any) -> Any:
    """Return a value of the kind of a symbol that means nothing; of what is known, itself."""
    return type(x)(symbols.constant(x.item, 0, x.width), x.width) if is_symbol(x) else x


def _blended(lanes: Any, new: Any, old: Any) -> Any:
    """Return a value in some lanes, that before in the others; the new one where they are of different forms."""
    if new is old:
        return new
    try:
        new, old = symbols.alike([new, old])
        pairs = list(zip(symbols.leaves(new), symbols.leaves(old), strict=True))
        made = [a if a is b else symbols.selected(lanes, a, b) for a, b in pairs]
    except (NotTraceable, ValueError, TypeError):
        return new
    return symbols.rebuilt(new, iter(made))


def _as_answer(x: Any) -> Any:
    """Return whether a symbol counts as yes; what is known as it is."""
    return symbols.compared("!=", x, 0) if isinstance(x, (Number, Whole)) else x


class _Lambda:
    """A function that a body makes."""

    def __init__(self, node: ast.Lambda, at_work: _Activation):
        self.node, self.at_work = node, at_work

    def __call__(self, *given: Any) -> Any:
        names = [item.arg for item in self.node.args.args]
        inner = _Activation(self.at_work.function, self.at_work.names | dict(zip(names, given, strict=True)), self.at_work.free)
        return _Runner(inner).value(self.node.body)


LOOPS: list[Any] = [range]  # functions that give whole numbers to count by; but for the first, to be left loops
BINARY: dict[type, tuple[str, Callable, Callable]] = {}  # syntax -> rule's name, what Python does, what is emitted
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


def _has_slope(*given: Any) -> bool:
    return any(hasattr(x, "parts") for x in given)


def _slopes_in(given: tuple) -> bool:
    return _has_slope(*given)


class _Runner:
    """Runs the statements of one activation."""

    def __init__(self, at_work: _Activation):
        self.at = at_work

    # ------------------------------------------------------------------------------------------ statements

    def block(self, statements: list[Any]) -> bool:
        """Run statements; return whether no path goes on behind them."""
        for statement in statements:
            self.at.node = statement
            if getattr(self, f"do_{type(statement).__name__}", self.do_what)(statement):
                return True
        return False

    def do_what(self, node: Any) -> bool:
        """Refuse a statement."""
        raise NotTraceable(f"has a statement that is not known ({type(node).__name__})")

    def do_Expr(self, node: Any) -> bool:  # noqa: N802 - named by the syntax, as all that follow
        """Run an expression for what it does."""
        if not isinstance(node.value, ast.Constant):
            self.value(node.value)
        return False

    def do_Pass(self, node: Any) -> bool:  # noqa: N802
        """Do nothing."""
        return False

    def do_Assert(self, node: Any) -> bool:  # noqa: N802
        """Do nothing."""
        return False

    def do_Return(self, node: Any) -> bool:  # noqa: N802
        """End this path of the function."""
        value = self.value(node.value) if node.value else None
        lanes = self.at.lanes()
        if lanes is None or self.at.mask is None and LANES not in self.at.names and not self.at.loops:
            self.leave(value)
        elif self.at.loops and RETURNED not in self.at.names:
            raise _Returns(value)
        else:
            self.keep(RETURNED, value, lanes)
            self.stop(LANES, lanes)
        return True

    def leave(self, value: Any) -> None:
        """End this path of the function for all lanes; those that have ended before keep what they returned."""
        if RETURNED in self.at.names:
            value = _blended(self.at.names[LANES], value, self.at.names[RETURNED])
        self.at.returns.append(Path(trace().builder.block, value))

    def keep(self, name: str, value: Any, lanes: Any) -> None:
        """Give a variable a value in some lanes."""
        names = self.at.names
        names[name] = _blended(lanes, value, names[name]) if name in names else value

    def stop(self, name: str, lanes: Any) -> None:
        """Let some lanes take no further part."""
        going = self.at.names.get(name, True)
        self.at.names[name] = symbols.both(going, symbols.opposite(lanes))

    def do_Assign(self, node: Any) -> bool:  # noqa: N802
        """Give names, items or places in arrays a value."""
        value = self.value(node.value)
        for target in node.targets:
            self.assign(target, value)
        return False

    def do_AnnAssign(self, node: Any) -> bool:  # noqa: N802
        """Do the same where the name has a type."""
        if node.value:
            self.assign(node.target, self.value(node.value))
        return False

    def do_AugAssign(self, node: Any) -> bool:  # noqa: N802
        """Change a value in its place."""
        target = node.target
        if isinstance(target, ast.Name):
            self.assign(target, self.binary(node.op, self.at.look_up(target.id), self.value(node.value)))
            return False
        holder, index = self.value(target.value), self.index(target.slice)
        old = self.item(holder, index)
        holder[index] = self.binary(node.op, old, self.value(node.value))
        return False

    def assign(self, target: Any, value: Any) -> None:
        """Give a target a value."""
        if isinstance(target, ast.Name):
            lanes = self.at.lanes()
            if lanes is None:
                self.at.names[target.id] = value
            else:
                self.keep(target.id, value, lanes)
        elif isinstance(target, (ast.Tuple, ast.List)):
            items = list(value)
            if len(items) != len(target.elts):
                raise NotTraceable(f"unpacks {len(items)} values into {len(target.elts)}")
            for part, item in zip(target.elts, items, strict=True):
                self.assign(part, item)
        elif isinstance(target, ast.Subscript):
            self.value(target.value)[self.index(target.slice)] = value
        else:
            raise NotTraceable("changes an attribute")

    def do_If(self, node: Any) -> bool:  # noqa: N802
        """Take a side, or both where it is not known which."""
        condition = self.answer(node.test)
        if not is_symbol(condition):
            return self.block(node.body if condition else node.orelse)
        if condition.width > 1:
            return self.in_some(condition, node)
        builder, hand, before = trace().builder, trace(), self.at.names
        sides = (hand.block(), node.body), (hand.block(), node.orelse)
        builder.cbranch(condition.value, sides[0][0], sides[1][0])
        paths = []
        for begin, statements in sides:
            builder.position_at_end(begin)
            self.at.names = dict(before)
            if not self.block(statements):
                paths.append(Path(builder.block, self.at.names))
        return self.meet(paths)

    def in_some(self, condition: Truth, node: Any) -> bool:
        """Run each side of a decision in the lanes that want it, if one does; return whether none goes on."""
        builder, hand, outer = trace().builder, trace(), self.at.mask
        ended = []
        for wanted, statements in ((condition, node.body), (symbols.opposite(condition), node.orelse)):
            if not statements:
                ended.append(False)
                continue
            self.at.mask = wanted if outer is None else symbols.both(outer, wanted)
            begin, skip = hand.block(), hand.block()
            before = dict(self.at.names)
            builder.cbranch(nowhere(self.at.lanes_in_all()).value, skip, begin)
            builder.position_at_end(begin)
            ended.append(self.block(statements))
            inside = self.at.names
            for name, value in inside.items():  # what is new has no meaning where no lane wants it
                if name not in before:
                    before[name] = _all_lanes(hand.width) if name.startswith(LANES) else symbols.changed(value, _none)
            self.meet([Path(builder.block, inside), Path(skip, before)])
            self.at.mask = outer
        return all(ended)

    def answer(self, node: Any) -> Any:
        """Return whether what an expression is counts as yes."""
        x = _as_answer(self.value(node))
        return x if is_symbol(x) else bool(x)

    def meet(self, paths: list[Path]) -> bool:
        """Go on where paths meet, with the variables that they have in common; return whether there are none."""
        if not paths:
            return True
        if len(paths) == 1:
            trace().builder.position_at_end(paths[0].block)
            self.at.names = paths[0].value
            return False
        known = [name for name in paths[0].value if all(name in path.value for path in paths)]
        builder, end = trace().builder, trace().block()
        met: dict[str, Any] = {}
        for name in known:
            column = [path.value[name] for path in paths]
            if all(x is column[0] for x in column):
                met[name] = column[0]
                continue
            try:
                column = symbols.alike(column)
                rows = [list(symbols.leaves(x)) for x in column]
                if len({len(row) for row in rows}) != 1:
                    continue
                blocks = [path.block for path in paths]
                made = [symbols._meeting(blocks, list(items), end) for items in zip(*rows, strict=True)]
            except NotTraceable:
                continue  # a name that stands for different things has no value from here on
            met[name] = symbols.rebuilt(column[0], iter(made))
        for path in paths:
            builder.position_at_end(path.block)
            builder.branch(end)
        builder.position_at_end(end)
        self.at.names = met
        return False

    def do_Break(self, node: Any) -> bool:  # noqa: N802
        """Leave a loop."""
        lanes = self.at.lanes()
        if lanes is not None:
            self.stop(f"{LANES}of loop {len(self.at.loops)}", lanes)
            return True
        self.at.loops[-1].breaks.append(Path(trace().builder.block, dict(self.at.names)))
        return True

    def do_Continue(self, node: Any) -> bool:  # noqa: N802
        """Leave a turn of a loop."""
        lanes = self.at.lanes()
        if lanes is not None:
            self.stop(f"{LANES}of turn {len(self.at.loops)}", lanes)
            return True
        self.at.loops[-1].goes_on.append(Path(trace().builder.block, dict(self.at.names)))
        return True

    def do_For(self, node: Any) -> bool:  # noqa: N802
        """Run a loop over what is known, or over whole numbers."""
        if node.orelse:
            raise NotTraceable("has an else behind a loop")
        known = node.iter
        if isinstance(known, ast.Call) and isinstance(known.func, ast.Name) and self.at.look_up(known.func.id) in LOOPS:
            ends = [self.value(item) for item in known.args]
            if any(map(is_symbol, ends)):
                return self.loop(node, *self.bounds(ends))
            turns: Any = range(*[int(x) for x in ends])
            unused = isinstance(node.target, ast.Name) and node.target.id == "_"
            if len(turns) > 1 and (unused or self.at.look_up(known.func.id) is not range):
                return self.loop(node, turns.start, turns.stop, turns.step)
        else:
            turns = self.value(known)
            if isinstance(turns, View):
                return self.loop(node, 0, turns.shape[0], 1, turns)
            turns = turns.tolist() if isinstance(turns, np.ndarray) else turns
        return self.written_out(node, list(turns))

    def bounds(self, ends: list[Any]) -> tuple[Any, Any, int]:
        """Return start, end and step of a range."""
        start, stop, step = (0, ends[0], 1) if len(ends) == 1 else (*ends, 1)[:3]
        if is_symbol(step):
            raise NotTraceable("counts by steps that are not known")
        return start, stop, int(step)

    def written_out(self, node: Any, turns: list[Any]) -> bool:
        """Run every turn of a loop."""
        inside = _Loop([], [])
        name = self.begin_loop(node)
        for item in turns:
            self.assign(node.target, item)
            inside.goes_on.clear()
            if self.turn(node, inside):
                return self.meet([Path(path.block, _without(path.value, name)) for path in inside.breaks])
        self.at.names.pop(name, None)
        if inside.breaks:
            return self.meet([*inside.breaks, Path(trace().builder.block, self.at.names)])
        return False

    def begin_loop(self, node: Any) -> str:
        """Let lanes leave a loop one by one, where it may be left early; return the name of what says which go on."""
        name = f"{LANES}of loop {len(self.at.loops) + 1}"
        if trace().width > 1 and (isinstance(node, ast.While) or _contains(node, ast.Break)):
            self.at.names[name] = _all_lanes(trace().width)
        return name

    def turn(self, node: Any, inside: _Loop) -> bool:
        """Run a turn of a loop; return whether none goes on behind it."""
        self.at.loops.append(inside)
        name = f"{LANES}of turn {len(self.at.loops)}"
        if trace().width > 1 and _contains(node, ast.Continue):
            self.at.names[name] = _all_lanes(trace().width)
        ended = self.block(node.body)
        self.at.loops.pop()
        paths = list(inside.goes_on)
        if not ended or name in self.at.names or any(x.startswith(LANES) for x in self.at.names):
            paths.append(Path(trace().builder.block, self.at.names))
        if self.meet(paths):
            return True
        self.at.names.pop(name, None)
        return False

    def do_While(self, node: Any) -> bool:  # noqa: N802
        """Run a loop for as long as a condition holds."""
        return self.loop(node, None, None, 1)

    def loop(self, node: Any, start: Any, stop: Any, step: int, source: Any = None) -> bool:
        """Emit a loop; start : None where its condition is that of the node."""
        loop_lanes, begin, depth, mask = self.begin_loop(node), _Mark(), len(self.at.loops), self.at.mask
        names = dict(self.at.names)
        try:
            return self.loop_carried(node, (start, stop, step), source, loop_lanes)
        except _Returns as found:
            if depth:
                raise  # the outermost loop is the one to begin anew
            begin.back()
            del self.at.loops[depth:]
            self.at.mask, self.at.names = mask, names
            self.at.names[RETURNED] = symbols.changed(found.value, _none)
            self.at.names.setdefault(LANES, _all_lanes(trace().width))
            return self.loop_carried(node, (start, stop, step), source, loop_lanes)

    def loop_carried(self, node: Any, bounds: tuple, source: Any, loop_lanes: str) -> bool:
        """Emit a loop with the variables that it changes."""
        inner = [name for name in self.at.names if name.startswith(LANES) or name == RETURNED]
        carried = [*(name for name in _stored(node) if name in self.at.names), *inner]
        begin, names = _Mark(), dict(self.at.names)
        kinds: dict[Any, Any] = {}
        while True:
            self.at.names = dict(names)
            wider = self.loop_of_kinds(node, bounds, source, carried, kinds)
            if not wider:
                break
            kinds.update(wider)
            begin.back()
        if not self.loop_end:
            self.at.names.pop(loop_lanes, None)
        return self.loop_end

    def loop_of_kinds(self, node, bounds, source, carried, kinds) -> dict:  # type: ignore[no-untyped-def]
        """Emit a loop whose variables are of kinds; return those for which that does not do."""
        builder, hand = trace().builder, trace()
        start, stop, step = bounds
        counts = start is not None
        before = builder.block
        phis: list[tuple[tuple[str, int], Any, type]] = []
        first_values: list[Any] = []
        if counts:
            first_values.append(symbols.as_kind(start, Whole))
        entering: dict[str, list[Any]] = {}
        for name in carried:
            if name in kinds:  # it stands for something else behind every turn: it has no value where one begins
                del self.at.names[name]
                continue
            entering[name] = list(symbols.leaves(self.at.names[name]))
            if not all(isinstance(x, (Symbol, int, float, np.number, np.bool_, View)) for x in entering[name]):
                del entering[name]
        starting: dict[tuple[str, int], Any] = {}
        for name, parts in entering.items():
            for place, x in enumerate(parts):
                if isinstance(x, View):
                    continue
                kind, width = kinds.get((name, place)) or (symbols.kind_of(x), symbols.width_of(x))
                starting[name, place] = (kind, symbols.as_kind(x, kind, width), width)
        header = hand.block()
        builder.branch(header)
        builder.position_at_end(header)
        counter = None
        if counts:
            counter = builder.phi(symbols.WHOLE)
            counter.add_incoming(first_values[0], before)
        for name, parts in entering.items():
            held = []
            for place, x in enumerate(parts):
                if isinstance(x, View):
                    held.append(x)
                    continue
                kind, value, width = starting[name, place]
                phi = builder.phi(symbols.form(kind.item, width))  # type: ignore[attr-defined]
                phi.add_incoming(value, before)
                phis.append(((name, place), phi, kind))
                held.append(kind(phi, width))
            self.at.names[name] = symbols.rebuilt(self.at.names[name], iter(held))
        condition = (
            symbols.compared("<" if step > 0 else ">", Whole(counter), stop) if counts else self.answer(node.test)
        )
        loop_lanes = f"{LANES}of loop {len(self.at.loops) + 1}"
        if is_symbol(condition) and condition.width > 1:
            self.at.names[loop_lanes] = symbols.both(self.at.names[loop_lanes], condition)
            condition = True
        if loop_lanes in self.at.names:
            going = symbols.opposite(nowhere(self.at.lanes_in_all()))
            condition = symbols.both(condition, going)
        after: list[Path] = []
        body = hand.block()
        if is_symbol(condition):
            out = hand.block()
            builder.cbranch(condition.value, body, out)
            after.append(Path(out, dict(self.at.names)))
        elif condition:
            builder.branch(body)
        else:
            raise NotTraceable("has a loop without turns")
        builder.position_at_end(body)
        inside = _Loop([], [])
        if counts:
            self.assign(node.target, Whole(counter) if source is None else source[Whole(counter)])
        if not self.turn(node, inside):
            wider: dict[Any, Any] = {}
            last: dict[tuple[str, int], Any] = {}
            for name, parts in entering.items():
                now = self.at.names.get(name)
                rows = list(symbols.leaves(now))
                if name not in self.at.names or len(rows) != len(parts) or not _same_arrays(rows, parts):
                    wider[name] = type(None)
                    continue
                last.update({(name, place): x for place, x in enumerate(rows) if not isinstance(x, View)})
            for key, phi, kind in phis:
                if key[0] in wider:
                    continue
                width = phi.type.count if hasattr(phi.type, "count") else 1
                now = last[key]
                met = symbols.kind_of(kind(None), now), max(width, symbols.width_of(now))
                if met != (kind, width):
                    wider[key] = met
            if wider:
                return wider
            if counts:
                counter.add_incoming(builder.add(counter, symbols.WHOLE(step)), builder.block)
            for key, phi, kind in phis:
                width = phi.type.count if hasattr(phi.type, "count") else 1
                phi.add_incoming(symbols.as_kind(last[key], kind, width), builder.block)
            builder.branch(header)
        self.loop_end = self.meet([*after, *inside.breaks])
        return {}

    # ------------------------------------------------------------------------------------------ expressions

    def value(self, node: Any) -> Any:
        """Return what an expression is."""
        return getattr(self, f"see_{type(node).__name__}", self.see_what)(node)

    def see_what(self, node: Any) -> Any:
        """Refuse an expression."""
        raise NotTraceable(f"has an expression that is not known ({type(node).__name__})")

    def see_Constant(self, node: Any) -> Any:  # noqa: N802
        """Return a constant."""
        return node.value

    def see_Name(self, node: Any) -> Any:  # noqa: N802
        """Return what a name stands for."""
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
        """Yield the values of expressions, those with a star one by one."""
        for node in nodes:
            if isinstance(node, ast.Starred):
                yield from self.value(node.value)
            else:
                yield self.value(node)

    def see_JoinedStr(self, node: Any) -> Any:  # noqa: N802
        """Return a text that nothing is done with."""
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
            given = index if isinstance(index, tuple) else (index,)
            if any(map(is_symbol, given)):
                return symbols.gathered(symbols.table_of(holder), given)
            found = holder[index]
            return found if isinstance(found, np.ndarray) else found.item()
        if hasattr(holder, "traced_item"):
            return run(holder.traced_item, holder, index)
        if is_symbol(index) and isinstance(holder, tuple):
            return _one_of(holder, index)
        return holder[index]

    def see_BinOp(self, node: Any) -> Any:  # noqa: N802
        """Return what an operation makes of two values."""
        return self.binary(node.op, self.value(node.left), self.value(node.right))

    def binary(self, operation: Any, a: Any, b: Any) -> Any:
        """Return the same of values."""
        if isinstance(operation, ast.Pow):
            return self.power(a, b)
        rule, plainly, emit = BINARY[type(operation)]
        if _has_slope(a, b):
            return run(_RULES[rule], a, b)
        if is_symbol(a) or is_symbol(b):
            return emit(a, b, (self.at.number, trace().builder.block))
        return plainly(a, b)

    def power(self, a: Any, b: Any) -> Any:
        """Return a power; a whole one that is known becomes products."""
        if _has_slope(a, b):
            return run(_RULES["__pow__"], a, b)
        if is_symbol(a) and not is_symbol(b) and float(b).is_integer() and 1.0 <= b <= LARGEST_POWER:
            found = a
            for bit in bin(int(b))[3:]:
                found = symbols.times(found, found)
                found = symbols.times(found, a) if bit == "1" else found
            return found
        if is_symbol(a) or is_symbol(b):
            return call(pow, a, b)
        return a**b

    def see_UnaryOp(self, node: Any) -> Any:  # noqa: N802
        """Return what an operation makes of one value."""
        x = self.value(node.operand)
        if isinstance(node.op, ast.Not):
            x = _as_answer(x)
            return symbols.opposite(x) if is_symbol(x) else not x
        if isinstance(node.op, ast.USub):
            if _has_slope(x):
                return run(_RULES["__neg__"], x)
            return symbols.negative(x) if is_symbol(x) else -x
        if isinstance(node.op, ast.Invert):
            return symbols.without_common(x, -1) if is_symbol(x) else ~x
        if isinstance(node.op, ast.UAdd):
            return x
        raise NotTraceable("has an operation that is not known")

    def see_Compare(self, node: Any) -> Any:  # noqa: N802
        """Return an answer, or several one after the other."""
        left, answer = self.value(node.left), None
        for operation, item in zip(node.ops, node.comparators, strict=True):
            right = self.value(item)
            one = self.compare(operation, left, right)
            if answer is None:
                answer = one
            elif is_symbol(answer) or is_symbol(one):
                answer = symbols.both(answer, one)
            else:
                answer = answer and one
            left = right
        return answer

    def compare(self, operation: Any, a: Any, b: Any) -> Any:
        """Return what a comparison says."""
        if isinstance(operation, (ast.Is, ast.IsNot)):
            return (a is b) == isinstance(operation, ast.Is)
        if isinstance(operation, (ast.In, ast.NotIn)):
            found: Any = False
            if is_symbol(a) or (isinstance(b, tuple) and any(map(is_symbol, b))):
                for x in b:
                    one = self.compare(ast.Eq(), a, x)
                    found = symbols.one_of(found, one) if is_symbol(found) or is_symbol(one) else found or one
            else:
                found = a in b
            if isinstance(operation, ast.In):
                return found
            return symbols.opposite(found) if is_symbol(found) else not found
        rule, sign, plainly = COMPARED[type(operation)]
        if _has_slope(a, b):
            return run(_RULES[rule], a, b)
        if is_symbol(a) or is_symbol(b):
            return symbols.compared(sign, a, b)
        return plainly(a, b)

    def see_BoolOp(self, node: Any) -> Any:  # noqa: N802
        """Return whether all answers are yes, or one is; what decides is found out first."""
        is_and, answer = isinstance(node.op, ast.And), None
        for place, item in enumerate(node.values):
            if place == 0:
                answer = self.value(item)
                continue
            if not is_symbol(answer):
                if bool(answer) != is_and:
                    return answer
                answer = self.value(item)
                continue
            answer = self.further(_as_answer(answer), item, is_and=is_and)
        return answer

    def further(self, answer: Truth, node: Any, *, is_and: bool) -> Any:
        """Return an answer and a further one together; the further one is asked for where the first does not decide."""
        if answer.width > 1 or not any(isinstance(n, (ast.Call, ast.Subscript)) for n in ast.walk(node)):
            other = _as_answer(self.value(node))
            return symbols.both(answer, other) if is_and else symbols.one_of(answer, other)
        builder, hand = trace().builder, trace()
        more, known = hand.block(), hand.block()
        builder.cbranch(answer.value, *((more, known) if is_and else (known, more)))
        builder.position_at_end(more)
        other = _as_answer(self.value(node))
        paths = [Path(builder.block, other), Path(known, not is_and)]
        return joined(paths)

    def see_IfExp(self, node: Any) -> Any:  # noqa: N802
        """Return one of two values."""
        condition = self.answer(node.test)
        if not is_symbol(condition):
            return self.value(node.body if condition else node.orelse)
        if condition.width > 1:
            return self.one_each(condition, node)
        builder, hand = trace().builder, trace()
        one, other = hand.block(), hand.block()
        builder.cbranch(condition.value, one, other)
        paths = []
        for block, side in ((one, node.body), (other, node.orelse)):
            builder.position_at_end(block)
            value = self.value(side)
            paths.append(Path(builder.block, value))
        return joined(paths)

    def one_each(self, condition: Truth, node: Any) -> Any:
        """Return one of two values in each lane."""
        outer, found = self.at.mask, []
        for wanted, side in ((condition, node.body), (symbols.opposite(condition), node.orelse)):
            self.at.mask = wanted if outer is None else symbols.both(outer, wanted)
            found.append(self.value(side))
        self.at.mask = outer
        a, b = symbols.alike(found)
        pairs = zip(symbols.leaves(a), symbols.leaves(b), strict=True)
        return symbols.rebuilt(a, iter([x if x is y else symbols.selected(condition, x, y) for x, y in pairs]))

    def see_Call(self, node: Any) -> Any:  # noqa: N802
        """Return what a call returns."""
        function = self.value(node.func)
        given = list(self.items(node.args))
        named: dict[str, Any] = {}
        for item in node.keywords:
            if item.arg is None:
                named.update(self.value(item.value))
            else:
                named[item.arg] = self.value(item.value)
        if _slopes_in(tuple(given)) and (rule := slope_rule(function)):
            return run(rule, *given)
        return call(function, *given, **named)

    def see_Lambda(self, node: Any) -> Any:  # noqa: N802
        """Return a function."""
        return _Lambda(node, self.at)

    def see_GeneratorExp(self, node: Any) -> Any:  # noqa: N802
        """Return the items of a comprehension."""
        return list(self.comprehended(node, 0))

    see_ListComp = see_GeneratorExp  # noqa: N815

    def comprehended(self, node: Any, level: int) -> Iterator[Any]:
        """Yield the items."""
        if level == len(node.generators):
            yield self.value(node.elt)
            return
        part, kept = node.generators[level], self.at.names
        for item in list(self.value(part.iter)):
            self.at.names = dict(kept)
            self.assign(part.target, item)
            if all(self.value(condition) for condition in part.ifs):
                yield from self.comprehended(node, level + 1)
        self.at.names = kept


def _same_arrays(rows: list[Any], others: list[Any]) -> bool:
    return all(x is y for x, y in zip(rows, others, strict=True) if isinstance(x, View) or isinstance(y, View))


class _Mark:
    """A place in the code to which one can go back."""

    def __init__(self) -> None:
        builder = trace().builder
        self.block, self.function = builder.block, builder.function
        self.instructions, self.blocks = len(self.block.instructions), len(self.function.blocks)

    def back(self) -> None:
        """Take out all that was emitted since."""
        builder = trace().builder
        del self.function.blocks[self.blocks :]
        del self.block.instructions[self.instructions :]
        self.block.terminator = None
        builder.position_at_end(self.block)


def _one_of(holder: Any, index: Any) -> Any:
    """Return the item of a tuple whose number is known when the program runs."""
    found = holder[len(holder) - 1]
    for place in range(len(holder) - 2, -1, -1):
        values = symbols.alike([holder[place], found])
        pairs = zip(symbols.leaves(values[0]), symbols.leaves(values[1]), strict=True)
        chosen = symbols.compared("==", index, place)
        made = [a if a is b else symbols.selected(chosen, a, b) for a, b in pairs]
        found = symbols.rebuilt(values[0], iter(made))
    return found


_SLOPE_RULES: dict[Any, Callable] = {}  # function -> what it does to numbers with slopes


def slope_rule(function: Any) -> Callable | None:
    """Return what a function does to numbers with slopes, None where it has a body for them."""
    try:
        return _SLOPE_RULES.get(function)
    except TypeError:
        return None


def rule_of_function(function: Any, rule: Callable) -> None:
    """Enter what a function does to numbers with slopes."""
    _SLOPE_RULES[function] = rule


# ---------------------------------------------------------------------------------------------- functions of Python


def for_symbols(function: Any, emit: Callable) -> None:
    """Enter what emits a function of Python where a symbol is given; else Python does it."""

    def entered(*given: Any, **named: Any) -> Any:
        flat = given[0] if len(given) == 1 and isinstance(given[0], (list, tuple)) else given
        return emit(*given, **named) if any(map(is_symbol, flat)) else function(*given, **named)

    _PRIMITIVES[function] = entered


def _size(x: Any) -> Any:
    if isinstance(x, Whole):
        return symbols.selected(symbols.compared("<", x, 0), symbols.negative(x), x)
    return symbols.intrinsic("fabs", x)


for_symbols(max, symbols.extreme(">"))
for_symbols(min, symbols.extreme("<"))
for_symbols(abs, _size)
for_symbols(int, symbols.as_whole)
for_symbols(float, symbols.number)
for_symbols(bool, lambda x: x)
for_symbols(math.sqrt, lambda x: symbols.intrinsic("sqrt", x))
for_symbols(math.copysign, lambda a, b: symbols.intrinsic("copysign", a, b))
for_symbols(math.floor, lambda x: symbols.as_whole(symbols.floor_number(x)))
for_symbols(math.isfinite, lambda x: symbols.compared("<", symbols.intrinsic("fabs", x), math.inf))


def _of_the_library(name: str, *given: Any) -> Number:
    """Emit the library's function, lane by lane."""
    hand, width = trace(), symbols.width_of(*given)
    kind = symbols.ir.FunctionType(symbols.DOUBLE, [symbols.DOUBLE] * len(given))
    function = hand.module.globals.get(name) or symbols.ir.Function(hand.module, kind, name)
    values = [symbols.as_kind(x, Number, width) for x in given]
    if width == 1:
        return Number(hand.builder.call(function, values))
    found: Any = symbols.ir.Constant(symbols.form(symbols.DOUBLE, width), symbols.ir.Undefined)
    for lane in range(width):
        place = symbols.WHOLE(lane)
        one = hand.builder.call(function, [hand.builder.extract_element(x, place) for x in values])
        found = hand.builder.insert_element(found, one, place)
    return Number(found, width)


for _function in (
    "sin", "cos", "tan", "tanh", "exp", "expm1", "log", "log1p", "log2", "atan", "atan2", "cosh", "sinh", "asin", "acos", "hypot",
):  # fmt: skip
    for_symbols(getattr(math, _function), functools.partial(_of_the_library, _function))
for_symbols(pow, functools.partial(_of_the_library, "pow"))
