"""Loops of a traced body, and the interpreter of whole bodies."""

import ast
import functools
import math
from types import FunctionType
from typing import Any, NamedTuple

import numpy as np

from . import functions, portable, protocols, symbols
from .activation import (
    LANES,
    RETURNED,
    Activation,
    LoopExits,
    Path,
    ReturnInLanes,
    all_lanes,
    assigned_names,
    contains,
    leaves,
    map_leaves,
    none_of,
    rebuild,
    select_values,
    undefined_like,
)
from .calls import RUNNERS, call
from .memory import View
from .statements import Statements
from .symbols import (
    WIDTH,
    Boolean,
    Integer,
    LaneIndices,
    NotTraceableError,
    Number,
    Symbol,
    as_boolean,
    is_symbol,
    trace,
)

# ----------------------------------------------------------------------------------------------------------------------
# Loops: unrolled if the number of iterations is known, otherwise a loop of blocks.
#
# Each variable that a loop of blocks changes needs a phi node.  Its kind (number, integer, in lanes or not) is known
# only after an iteration has been emitted.  If a narrower kind was assumed, the loop is emitted again, and nothing
# leads to the blocks of the first attempt.


class Bounds(NamedTuple):
    """Range of a loop."""

    start: Any  # None: the loop depends on a condition
    stop: Any = None
    step: int = 1
    source: Any = None  # an array whose items are the loop's values


class _Attempt:
    """An attempt to emit a loop from its own first block on, to which nothing leads until it is accepted."""

    def __init__(self, activation: Activation):
        self.activation, self.names, self.mask = activation, dict(activation.names), activation.mask
        self.preceding_block, self.begin = trace().builder.block, trace().block()
        self.comprehensions = activation.comprehensions
        self.paths = [
            (paths, len(paths)) for paths in (activation.returns, *(x for loop in activation.loops for x in loop[:2]))
        ]
        self.depth = len(activation.loops)
        trace().builder.position_at_end(self.begin)

    def accept(self) -> None:
        """Let the preceding code lead to the loop."""
        builder, end = trace().builder, trace().builder.block
        builder.position_at_end(self.preceding_block)
        builder.branch(self.begin)
        builder.position_at_end(end)

    def give_up(self) -> None:
        """Restore the activation, and end the blocks that were left open; LLVM removes them."""
        builder = trace().builder
        for block in trace().open_blocks(self.begin):
            builder.position_at_end(block)
            builder.unreachable()
        builder.position_at_end(self.preceding_block)
        for paths, count in self.paths:
            del paths[count:]
        del self.activation.loops[self.depth :]
        self.activation.comprehensions = self.comprehensions
        self.activation.names, self.activation.mask = dict(self.names), self.mask


class _Variable:
    """A variable shared by the iterations of a loop."""

    def __init__(self, initial: Any, kind: type, width: int):
        self.kind, self.width = kind, width
        self.initial = symbols.as_kind(initial, kind, width)
        self.phi: Any = None

    def begin(self, preceding_block: Any) -> Symbol:
        """Emit the phi node of the variable; return its value within an iteration."""
        self.phi = trace().builder.phi(symbols.llvm_type(self.kind.item, self.width))  # type: ignore[attr-defined]
        self.phi.add_incoming(self.initial, preceding_block)
        phi_node: Symbol = self.kind(self.phi, self.width)
        return phi_node

    def required_kind(self, final_value: Any) -> tuple[type, int] | None:
        """Return the kind and width its value needs at the end of an iteration, or None if they are unchanged."""
        required = symbols.kind_of(self.kind(None), final_value), max(self.width, symbols.width_of(final_value))
        return None if required == (self.kind, self.width) else required

    def close(self, final_value: Any) -> None:
        """Set the value of the variable in the next iteration to its value at the end of this one."""
        value = symbols.as_kind(final_value, self.kind, self.width)
        self.phi.add_incoming(value, trace().builder.block)


class _LoopVariables:
    """The variables that a loop changes in an activation; `kinds` : those determined so far, by name and place."""

    def __init__(self, activation: Activation, names: list[str], kinds: dict[Any, Any]):
        self.activation, self.initial_values = activation, {}
        self.fixed_values: dict[str, Any] = {}  # of other kinds, which an iteration must not change
        self.variables: dict[tuple[str, int], _Variable] = {}
        for name in names:
            if name in kinds:  # its structure varies, so an iteration cannot use the value of the previous one
                del activation.names[name]
                continue
            values = leaves(activation.names[name])
            if all(isinstance(x, (Symbol, int, float, np.number, np.bool_, View)) for x in values):
                self.initial_values[name] = values
            else:
                self.fixed_values[name] = activation.names[name]
        for name, values in self.initial_values.items():
            for position, x in enumerate(values):
                if not isinstance(x, View):
                    kind = kinds.get((name, position)) or (symbols.kind_of(x), symbols.width_of(x))
                    self.variables[name, position] = _Variable(x, *kind)

    def begin(self, preceding_block: Any) -> None:
        """Emit the phi nodes of all variables; bind their values in the activation."""
        for name, initial_values in self.initial_values.items():
            phi_values = [
                x if isinstance(x, View) else self.variables[name, position].begin(preceding_block)
                for position, x in enumerate(initial_values)
            ]
            self.activation.names[name] = rebuild(self.activation.names[name], iter(phi_values))

    def close(self) -> dict[Any, Any]:
        """Set the values for the next iteration; return the kinds of the variables whose kind was too narrow."""
        too_narrow: dict[Any, Any] = {}
        final_values: dict[tuple[str, int], Any] = {}
        for name, initial_values in self.initial_values.items():
            values = leaves(self.activation.names.get(name))
            pairs = zip(values, initial_values, strict=False)
            if (
                name not in self.activation.names
                or len(values) != len(initial_values)
                or any(x is not y for x, y in pairs if isinstance(x, View) or isinstance(y, View))
            ):
                too_narrow[name] = None
                continue
            final_values |= {(name, position): x for position, x in enumerate(values) if not isinstance(x, View)}
        for name, initial in self.fixed_values.items():
            if not _is_same(self.activation.names.get(name, ...), initial):
                too_narrow[name] = None
        too_narrow |= {key: kind for key, x in final_values.items() if (kind := self.variables[key].required_kind(x))}
        if not too_narrow:
            for key, x in final_values.items():
                self.variables[key].close(x)
        return too_narrow


def _is_same(value: Any, initial: Any) -> bool:
    return value is initial or (type(value) is type(initial) is str and value == initial)


class Loops(Statements):
    """Runs the loops of an activation."""

    def execute_For(self, node: Any) -> bool:  # noqa: N802 - named by the syntax
        """Run a loop over known values, over integers, or over the items of an array."""
        if node.orelse:
            raise NotTraceableError("has a loop with an else block")
        iterable = node.iter
        is_named_call = isinstance(iterable, ast.Call) and isinstance(iterable.func, ast.Name)
        if is_named_call and self.activation.look_up(iterable.func.id) in protocols.LANE_LOOPS:
            return self.run_in_lanes(node, self.value(iterable.args[0]))
        if is_named_call and self.activation.look_up(iterable.func.id) in protocols.LOOPS:
            range_arguments = list(self.items(iterable.args))
            if iterable.keywords or any(isinstance(x, (float, Number)) for x in range_arguments):
                raise NotTraceableError("has a range of other than integers")
            if any(map(is_symbol, range_arguments)):
                return self.loop(node, self.bounds(range_arguments))
            iterations: Any = range(*[int(x) for x in range_arguments])
            is_unused = isinstance(node.target, ast.Name) and node.target.id == "_"
            if len(iterations) > 1 and (is_unused or self.activation.look_up(iterable.func.id) is not range):
                return self.loop(node, Bounds(iterations.start, iterations.stop, iterations.step))
        else:
            iterations = self.value(iterable)
            if isinstance(iterations, View):
                return self.loop(node, Bounds(0, iterations.shape[0], source=iterations))
            iterations = iterations.tolist() if isinstance(iterations, np.ndarray) else iterations
        return self.unroll(node, list(iterations))

    def run_in_lanes(self, node: Any, count: Any) -> bool:
        """Run all iterations of a loop simultaneously, each in a lane."""
        active_trace = trace()
        if count != WIDTH or active_trace.width != 1:
            raise NotTraceableError(f"runs other than {WIDTH} iterations at once, or in a nested loop")
        active_trace.width = WIDTH
        has_ended = self.unroll(node, [LaneIndices(0)])
        active_trace.width = 1
        return has_ended

    def bounds(self, range_arguments: list[Any]) -> Bounds:
        """Return the Bounds of a range."""
        start, stop, step = (0, range_arguments[0], 1) if len(range_arguments) == 1 else (*range_arguments, 1)[:3]
        if is_symbol(step) or not step:
            raise NotTraceableError("has a step of 0, or one that is known only at run time")
        if any(getattr(bound, "width", 1) > 1 for bound in (start, stop)):
            raise NotTraceableError("has a range that differs from lane to lane; use a while loop")
        return Bounds(start, stop, int(step))

    def execute_While(self, node: Any) -> bool:  # noqa: N802
        """Run a loop for as long as a condition is true."""
        if node.orelse:
            raise NotTraceableError("has a loop with an else block")
        return self.loop(node, Bounds(None))

    # ------------------------------------------------------------------------------------------ iterations

    def unroll(self, node: Any, iterations: list[Any]) -> bool:
        """Unroll a loop."""
        exits = LoopExits([], [], is_rolled=False)
        loop_mask = self.begin_loop(node)
        for item in iterations:
            self.assign(node.target, item)
            exits.continues.clear()
            if self.run_iteration(node, exits):
                for path in exits.breaks:
                    path.value.pop(loop_mask, None)
                return self.join(exits.breaks)
        self.activation.names.pop(loop_mask, None)
        if exits.breaks:
            return self.join([*exits.breaks, Path(trace().builder.block, self.activation.names)])
        return False

    def begin_loop(self, node: Any) -> str:
        """Let lanes leave a loop one by one, if it may end early; return the name of the mask of continuing lanes."""
        loop_mask = f"{LANES}of loop {len(self.activation.loops) + 1}"
        if trace().width > 1 and (isinstance(node, ast.While) or contains(node, ast.Break)):
            self.activation.names[loop_mask] = all_lanes(trace().width)
        return loop_mask

    def run_iteration(self, node: Any, exits: LoopExits) -> bool:
        """Run an iteration of a loop; return whether no path continues after it."""
        self.activation.loops.append(exits)
        iteration_mask = f"{LANES}of iteration {len(self.activation.loops)}"
        if trace().width > 1 and contains(node, ast.Continue):
            self.activation.names[iteration_mask] = all_lanes(trace().width)
        has_ended = self.block(node.body)
        self.activation.loops.pop()
        paths = list(exits.continues)
        if not has_ended or any(x.startswith(LANES) for x in self.activation.names):
            paths.append(Path(trace().builder.block, self.activation.names))
        if self.join(paths):
            return True
        self.activation.names.pop(iteration_mask, None)
        return False

    # ------------------------------------------------------------------------------------------ loops of blocks

    def loop(self, node: Any, bounds: Bounds) -> bool:
        """Emit a loop of blocks; return whether no path continues after it."""
        loop_mask, attempt = self.begin_loop(node), _Attempt(self.activation)
        try:
            has_ended = self.with_variables(node, bounds)
            attempt.accept()
        except ReturnInLanes as returned:
            if attempt.depth:
                raise  # the outermost loop is emitted again
            attempt.give_up()
            self.activation.names[RETURNED] = map_leaves(returned.value, undefined_like)
            self.activation.names.setdefault(LANES, all_lanes(trace().width))
            has_ended = self.with_variables(node, bounds)
        if not has_ended:
            self.activation.names.pop(loop_mask, None)
        return has_ended

    def with_variables(self, node: Any, bounds: Bounds) -> bool:
        """Emit a loop with variables of the required kinds."""
        masks = [name for name in self.activation.names if name.startswith(LANES) or name == RETURNED]
        names = [*(name for name in assigned_names(node) if name in self.activation.names), *masks]
        kinds = dict[Any, Any]()
        while True:
            exits: list[Path] = []
            attempt = _Attempt(self.activation)
            too_narrow = self.emit_with(node, bounds, _LoopVariables(self.activation, names, kinds), exits)
            if not too_narrow:
                attempt.accept()
                return self.join(exits)
            kinds |= too_narrow
            attempt.give_up()

    def emit_with(
        self, node: Any, bounds: Bounds, loop_variables: _LoopVariables, loop_exits: list[Path]
    ) -> dict[Any, Any]:
        """Emit a loop with these variables and record its exits; return the kinds of those that were too narrow."""
        builder, active_trace = trace().builder, trace()
        preceding_block, header = builder.block, active_trace.block()
        counter = _Variable(bounds.start, Integer, 1) if bounds.start is not None else None
        builder.branch(header)
        builder.position_at_end(header)
        position = counter.begin(preceding_block) if counter else None
        loop_variables.begin(preceding_block)
        self.enter_iteration(self.has_next_iteration(node, bounds, position), loop_exits)
        if position is not None:
            self.assign(node.target, position if bounds.source is None else bounds.source[position])
        iteration_exits = LoopExits([], [], is_rolled=True)
        if not self.run_iteration(node, iteration_exits):
            too_narrow = loop_variables.close()
            if too_narrow:
                return too_narrow
            if counter:
                counter.close(symbols.plus(position, bounds.step))
            builder.branch(header)
        loop_exits += iteration_exits.breaks
        return {}

    def has_next_iteration(self, node: Any, bounds: Bounds, position: Any) -> Any:
        """Return whether a loop has another iteration, in any lane."""
        self.activation.node = node
        if position is not None:
            condition = symbols.compare("<" if bounds.step > 0 else ">", position, bounds.stop)
        else:
            condition = self.condition_value(node.test)
        loop_mask = f"{LANES}of loop {len(self.activation.loops) + 1}"
        if is_symbol(condition) and condition.width > 1:
            self.activation.names[loop_mask] = symbols.bit_and(self.activation.names[loop_mask], condition)
            condition = True
        if loop_mask in self.activation.names:
            condition = symbols.bit_and(condition, symbols.logical_not(none_of(self.activation.lanes_in_all())))
        return condition

    def enter_iteration(self, condition: Any, loop_exits: list[Path]) -> None:
        """Continue in the body of an iteration, if there is another iteration."""
        builder, body = trace().builder, trace().block()
        if is_symbol(condition):
            exit_block = trace().block()
            builder.cbranch(condition.value, body, exit_block)
            loop_exits.append(Path(exit_block, dict(self.activation.names)))
        elif condition:
            builder.branch(body)
        else:
            raise NotTraceableError("has a loop without iterations")
        builder.position_at_end(body)


# ----------------------------------------------------------------------------------------------------------------------
# Interprets the body of a function on symbols, statement by statement, from its syntax tree.
#
# Values known while tracing are computed by Python: the law, the number of joints, whether a number has a
# slope.  A branch on a symbol becomes two blocks, whose variables are merged after it; a loop of unknown length, or one
# that may end early, becomes a loop of blocks.  Other loops are unrolled.  In lanes, both sides of a branch run,
# each in its active lanes, and a loop runs until all lanes have left it.


RUNNERS.append(Loops)


def _absolute(x: Any) -> Any:
    if isinstance(x, (Boolean, Integer)):
        return symbols.select(symbols.compare("<", x, 0), symbols.negate(x), x)
    return symbols.call_intrinsic("fabs", x)


protocols.register_symbol_emitter(max, symbols.extremum_emitter(">"))
protocols.register_symbol_emitter(min, symbols.extremum_emitter("<"))
protocols.register_symbol_emitter(abs, _absolute)
protocols.register_symbol_emitter(int, symbols.truncate)
protocols.register_symbol_emitter(float, symbols.as_number)
protocols.register_symbol_emitter(bool, as_boolean)
protocols.register_symbol_emitter(math.sqrt, lambda x: symbols.call_intrinsic("sqrt", x))
protocols.register_symbol_emitter(math.copysign, lambda a, b: symbols.call_intrinsic("copysign", a, b))
protocols.register_symbol_emitter(math.floor, lambda x: symbols.truncate(symbols.call_intrinsic("floor", x)))
protocols.register_symbol_emitter(
    math.isfinite, lambda x: symbols.compare("<", symbols.call_intrinsic("fabs", x), math.inf)
)


protocols.register_emitter(portable.where)(select_values)
protocols.register_symbol_emitter(portable.fma, symbols.fma)
protocols.register_symbol_emitter(portable.bits_of, symbols.bits_of)
protocols.register_symbol_emitter(portable.number_of, symbols.number_of)


def _refused(name: str, *operands: Any) -> Any:
    raise NotTraceableError(f"calls {name}, which has no portable implementation")


#: Functions of Python that are emitted from the bodies in `functions`: bits do not depend on the system's library.
PORTABLE = ("atan", "atan2", "cos", "cosh", "exp", "expm1", "log", "log1p", "log2", "sin", "sinh", "tanh")
for _name, _body in vars(functions).items():
    if isinstance(_body, FunctionType) and _body.__module__ == functions.__name__:
        protocols.mark_traceable(_body, protocols.SEPARATE if _name in (*PORTABLE, "pow") else protocols.INLINED)
for _name in PORTABLE:
    protocols.register_symbol_emitter(getattr(math, _name), functools.partial(call, getattr(functions, _name)))
protocols.register_symbol_emitter(pow, functools.partial(_refused, "pow"))


for _name, _function in vars(math).items():
    if callable(_function) and _function not in protocols.PRIMITIVES and not _name.startswith("_"):
        protocols.register_symbol_emitter(_function, functools.partial(_refused, f"math.{_name}"))
