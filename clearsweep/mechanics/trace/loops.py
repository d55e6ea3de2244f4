"""Loops: unrolled if the number of turns is known, otherwise a loop of blocks.

Each variable that a loop of blocks changes needs a phi node.  Its kind (number, integer, in lanes or not) is known only
after a turn has been emitted.  If a narrower kind was assumed, the loop is removed and emitted again.
"""

import ast
from typing import Any, NamedTuple

import numpy as np

from . import symbols
from .activation import LANES, RETURNED, Activation, Loop, Returns, contains, stored
from .lanes import all_lanes, none_of, nothing
from .memory import View
from .paths import Path, changed, leaves, rebuilt
from .primitives import ABREAST, LOOPS
from .statements import Statements
from .symbols import WIDTH, Abreast, NotTraceableError, Symbol, Whole, is_symbol, trace


class Bounds(NamedTuple):
    """Range of a loop."""

    start: Any  # None: the loop depends on a condition
    stop: Any = None
    step: int = 1
    source: Any = None  # an array whose items are the loop's values


class _Mark:
    """A position in the code and in an activation that can be restored."""

    def __init__(self, at: Activation):
        builder = trace().builder
        self.at, self.names, self.mask = at, dict(at.names), at.mask
        self.block, self.function = builder.block, builder.function
        self.instructions, self.blocks = len(self.block.instructions), len(self.function.blocks)
        self.paths = [(paths, len(paths)) for paths in (at.returns, *(x for loop in at.loops for x in loop))]
        self.depth = len(at.loops)

    def back(self) -> None:
        """Remove the code emitted since."""
        builder = trace().builder
        del self.function.blocks[self.blocks :]
        del self.block.instructions[self.instructions :]
        self.block.terminator = None
        builder.position_at_end(self.block)
        for paths, count in self.paths:
            del paths[count:]
        del self.at.loops[self.depth :]
        self.at.names, self.at.mask = dict(self.names), self.mask


class _Variable:
    """A variable shared by the turns of a loop."""

    def __init__(self, leading: Any, kind: type, width: int):
        self.kind, self.width = kind, width
        self.first = symbols.as_kind(leading, kind, width)
        self.phi: Any = None

    def begin(self, previous: Any) -> Symbol:
        """Emit the phi node of the variable; return its value within a turn."""
        self.phi = trace().builder.phi(symbols.form(self.kind.item, self.width))  # type: ignore[attr-defined]
        self.phi.add_incoming(self.first, previous)
        phi_node: Symbol = self.kind(self.phi, self.width)
        return phi_node

    def wider(self, last: Any) -> tuple[type, int] | None:
        """Return the kind and width required for its value at the end of a turn, or None if they are unchanged."""
        required = symbols.kind_of(self.kind(None), last), max(self.width, symbols.width_of(last))
        return None if required == (self.kind, self.width) else required

    def close(self, last: Any) -> None:
        """Set the value of the variable in the next turn to its value at the end of this one."""
        value = symbols.as_kind(last, self.kind, self.width)
        self.phi.add_incoming(value, trace().builder.block)


class _Carried:
    """The variables that a loop changes in an activation; `kinds` : those determined so far, by name and place."""

    def __init__(self, at: Activation, names: list[str], kinds: dict[Any, Any]):
        self.at, self.parts = at, {}
        self.variables: dict[tuple[str, int], _Variable] = {}
        for name in names:
            if name in kinds:  # its structure changes from turn to turn, so it has no value at the start of a turn
                del at.names[name]
                continue
            parts = list(leaves(at.names[name]))
            if all(isinstance(x, (Symbol, int, float, np.number, np.bool_, View)) for x in parts):
                self.parts[name] = parts
        for name, parts in self.parts.items():
            for position, x in enumerate(parts):
                if not isinstance(x, View):
                    kind = kinds.get((name, position)) or (symbols.kind_of(x), symbols.width_of(x))
                    self.variables[name, position] = _Variable(x, *kind)

    def begin(self, previous: Any) -> None:
        """Emit the phi nodes of all variables; bind their values in the activation."""
        for name, parts in self.parts.items():
            phi_node = [
                x if isinstance(x, View) else self.variables[name, position].begin(previous)
                for position, x in enumerate(parts)
            ]
            self.at.names[name] = rebuilt(self.at.names[name], iter(phi_node))

    def close(self) -> dict[Any, Any]:
        """Set the values for the next turn; return the kinds of the variables whose kind was too narrow."""
        wider: dict[Any, Any] = {}
        last: dict[tuple[str, int], Any] = {}
        for name, parts in self.parts.items():
            rows = list(leaves(self.at.names.get(name)))
            if name not in self.at.names or len(rows) != len(parts) or not _same_arrays(rows, parts):
                wider[name] = None
                continue
            last |= {(name, position): x for position, x in enumerate(rows) if not isinstance(x, View)}
        wider |= {key: kind for key, x in last.items() if (kind := self.variables[key].wider(x))}
        if not wider:
            for key, x in last.items():
                self.variables[key].close(x)
        return wider


def _same_arrays(rows: list[Any], others: list[Any]) -> bool:
    return all(x is y for x, y in zip(rows, others, strict=True) if isinstance(x, View) or isinstance(y, View))


class Loops(Statements):
    """Runs the loops of an activation."""

    def do_For(self, node: Any) -> bool:  # noqa: N802 - named by the syntax
        """Run a loop over known values, over integers, or over the items of an array."""
        if node.orelse:
            raise NotTraceableError("has an else behind a loop")
        constant_value = node.iter
        counted = isinstance(constant_value, ast.Call) and isinstance(constant_value.func, ast.Name)
        if counted and self.at.look_up(constant_value.func.id) in ABREAST:
            return self.at_once(node, self.value(constant_value.args[0]))
        if counted and self.at.look_up(constant_value.func.id) in LOOPS:
            ends = [self.value(item) for item in constant_value.args]
            if any(map(is_symbol, ends)):
                return self.loop(node, self.bounds(ends))
            turns: Any = range(*[int(x) for x in ends])
            unused = isinstance(node.target, ast.Name) and node.target.id == "_"
            if len(turns) > 1 and (unused or self.at.look_up(constant_value.func.id) is not range):
                return self.loop(node, Bounds(turns.start, turns.stop, turns.step))
        else:
            turns = self.value(constant_value)
            if isinstance(turns, View):
                return self.loop(node, Bounds(0, turns.shape[0], source=turns))
            turns = turns.tolist() if isinstance(turns, np.ndarray) else turns
        return self.written_out(node, list(turns))

    def at_once(self, node: Any, count: Any) -> bool:
        """Run all turns of a loop simultaneously, each in a lane."""
        active_trace = trace()
        if count != WIDTH or active_trace.width != 1:
            raise NotTraceableError(f"runs other than {WIDTH} turns at once, or within others")
        active_trace.width = WIDTH
        has_ended = self.written_out(node, [Abreast(0)])
        active_trace.width = 1
        return has_ended

    def bounds(self, ends: list[Any]) -> Bounds:
        """Return the Bounds of a range."""
        start, stop, step = (0, ends[0], 1) if len(ends) == 1 else (*ends, 1)[:3]
        if is_symbol(step):
            raise NotTraceableError("counts by steps that are not known")
        return Bounds(start, stop, int(step))

    def do_While(self, node: Any) -> bool:  # noqa: N802
        """Run a loop for as long as a condition is true."""
        return self.loop(node, Bounds(None))

    # ------------------------------------------------------------------------------------------ turns

    def written_out(self, node: Any, turns: list[Any]) -> bool:
        """Unroll a loop."""
        inside = Loop([], [])
        name = self.begin_loop(node)
        for item in turns:
            self.assign(node.target, item)
            inside.goes_on.clear()
            if self.turn(node, inside):
                return self.join([Path(path.block, _without(path.value, name)) for path in inside.breaks])
        self.at.names.pop(name, None)
        if inside.breaks:
            return self.join([*inside.breaks, Path(trace().builder.block, self.at.names)])
        return False

    def begin_loop(self, node: Any) -> str:
        """Let lanes leave a loop one by one, if it may end early; return the name of the mask of continuing lanes."""
        name = f"{LANES}of loop {len(self.at.loops) + 1}"
        if trace().width > 1 and (isinstance(node, ast.While) or contains(node, ast.Break)):
            self.at.names[name] = all_lanes(trace().width)
        return name

    def turn(self, node: Any, inside: Loop) -> bool:
        """Run a turn of a loop; return whether no path continues after it."""
        self.at.loops.append(inside)
        name = f"{LANES}of turn {len(self.at.loops)}"
        if trace().width > 1 and contains(node, ast.Continue):
            self.at.names[name] = all_lanes(trace().width)
        has_ended = self.block(node.body)
        self.at.loops.pop()
        paths = list(inside.goes_on)
        if not has_ended or any(x.startswith(LANES) for x in self.at.names):
            paths.append(Path(trace().builder.block, self.at.names))
        if self.join(paths):
            return True
        self.at.names.pop(name, None)
        return False

    # ------------------------------------------------------------------------------------------ loops of blocks

    def loop(self, node: Any, bounds: Bounds) -> bool:
        """Emit a loop of blocks; return whether no path continues after it."""
        name, begin = self.begin_loop(node), _Mark(self.at)
        try:
            has_ended = self.with_variables(node, bounds)
        except Returns as returned:
            if begin.depth:
                raise  # the outermost loop is emitted again
            begin.back()
            self.at.names[RETURNED] = changed(returned.value, nothing)
            self.at.names.setdefault(LANES, all_lanes(trace().width))
            has_ended = self.with_variables(node, bounds)
        if not has_ended:
            self.at.names.pop(name, None)
        return has_ended

    def with_variables(self, node: Any, bounds: Bounds) -> bool:
        """Emit a loop with variables of the required kinds."""
        lanes = [name for name in self.at.names if name.startswith(LANES) or name == RETURNED]
        names = [*(name for name in stored(node) if name in self.at.names), *lanes]
        begin, kinds = _Mark(self.at), dict[Any, Any]()
        while True:
            left: list[Path] = []
            wider = self.of_kinds(node, bounds, _Carried(self.at, names, kinds), left)
            if not wider:
                return self.join(left)
            kinds |= wider
            begin.back()

    def of_kinds(self, node: Any, bounds: Bounds, loop_carried: _Carried, left: list[Path]) -> dict[Any, Any]:
        """Emit a loop with these variables and record its exits; return the kinds of those that were too narrow."""
        builder, active_trace = trace().builder, trace()
        previous, header = builder.block, active_trace.block()
        counter = _Variable(bounds.start, Whole, 1) if bounds.start is not None else None
        builder.branch(header)
        builder.position_at_end(header)
        position = counter.begin(previous) if counter else None
        loop_carried.begin(previous)
        self.enter_turn(self.goes_on(node, bounds, position), left)
        if position is not None:
            self.assign(node.target, position if bounds.source is None else bounds.source[position])
        inside = Loop([], [])
        if not self.turn(node, inside):
            wider = loop_carried.close()
            if wider:
                return wider
            if counter:
                counter.close(symbols.plus(position, bounds.step))
            builder.branch(header)
        left += inside.breaks
        return {}

    def goes_on(self, node: Any, bounds: Bounds, position: Any) -> Any:
        """Return whether a loop has another turn, in any lane."""
        if position is not None:
            condition = symbols.compared("<" if bounds.step > 0 else ">", position, bounds.stop)
        else:
            condition = self.answer(node.test)
        name = f"{LANES}of loop {len(self.at.loops) + 1}"
        if is_symbol(condition) and condition.width > 1:
            self.at.names[name] = symbols.both(self.at.names[name], condition)
            condition = True
        if name in self.at.names:
            condition = symbols.both(condition, symbols.opposite(none_of(self.at.lanes_in_all())))
        return condition

    def enter_turn(self, condition: Any, left: list[Path]) -> None:
        """Continue in the body of a turn, if there is another turn."""
        builder, body = trace().builder, trace().block()
        if is_symbol(condition):
            out = trace().block()
            builder.cbranch(condition.value, body, out)
            left.append(Path(out, dict(self.at.names)))
        elif condition:
            builder.branch(body)
        else:
            raise NotTraceableError("has a loop without turns")
        builder.position_at_end(body)


def _without(names: dict[str, Any], name: str) -> dict[str, Any]:
    return {key: value for key, value in names.items() if key != name}
