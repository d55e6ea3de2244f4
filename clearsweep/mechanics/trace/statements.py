"""Statements of a body on symbols, except loops."""

import ast
from typing import Any

from . import symbols
from .activation import LANES, RETURNED, Returns
from .expressions import Expressions
from .lanes import all_lanes, blended, none_of, nothing
from .paths import Path, alike, changed, leaves, meeting, rebuilt
from .symbols import NotTraceableError, Truth, is_symbol, trace


class Statements(Expressions):
    """Runs the statements of an activation."""

    def block(self, statements: list[Any]) -> bool:
        """Run statements; return whether no path continues after them."""
        for statement in statements:
            self.at.node = statement
            if getattr(self, f"do_{type(statement).__name__}", self.do_what)(statement):
                return True
        return False

    def do_what(self, node: Any) -> bool:
        """Refuse a statement."""
        raise NotTraceableError(f"has a statement that is not known ({type(node).__name__})")

    def do_Expr(self, node: Any) -> bool:  # noqa: N802 - named by the syntax, as all that follow
        """Evaluate an expression for its effect."""
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
        if lanes is None or (self.at.mask is None and LANES not in self.at.names and not self.at.loops):
            self.leave(value)
        elif self.at.loops and RETURNED not in self.at.names:
            raise Returns(value)
        else:
            self.keep(RETURNED, value, lanes)
            self.stop(LANES, lanes)
        return True

    def leave(self, value: Any) -> None:
        """End this path of the function for all lanes; lanes that ended before keep their returned values."""
        if RETURNED in self.at.names:
            value = blended(self.at.names[LANES], value, self.at.names[RETURNED])
        self.at.returns.append(Path(trace().builder.block, value))

    def stop(self, name: str, lanes: Any) -> None:
        """Deactivate some lanes."""
        is_running = self.at.names.get(name, True)
        self.at.names[name] = symbols.both(is_running, symbols.opposite(lanes))

    def do_Assign(self, node: Any) -> bool:  # noqa: N802
        """Assign a value to names, items or places in arrays."""
        value = self.value(node.value)
        for target in node.targets:
            self.assign(target, value)
        return False

    def do_AnnAssign(self, node: Any) -> bool:  # noqa: N802
        """Assign a value to an annotated name."""
        if node.value:
            self.assign(node.target, self.value(node.value))
        return False

    def do_AugAssign(self, node: Any) -> bool:  # noqa: N802
        """Change a value in place."""
        target = node.target
        if isinstance(target, ast.Name):
            self.assign(target, self.binary(node.op, self.at.look_up(target.id), self.value(node.value)))
            return False
        if isinstance(target, ast.Attribute):
            fields, name = self.fields(target), target.attr
            setattr(fields, name, self.binary(node.op, getattr(fields, name), self.value(node.value)))
            return False
        holder, index = self.value(target.value), self.index(target.slice)
        old_value = self.item(holder, index)
        holder[index] = self.binary(node.op, old_value, self.value(node.value))
        return False

    def do_If(self, node: Any) -> bool:  # noqa: N802
        """Run one branch, or both if the condition is a symbol."""
        condition = self.answer(node.test)
        if not is_symbol(condition):
            return self.block(node.body if condition else node.orelse)
        if condition.width > 1:
            return self.in_some(condition, node)
        builder, active_trace, previous = trace().builder, trace(), self.at.names
        sides = (active_trace.block(), node.body), (active_trace.block(), node.orelse)
        builder.cbranch(condition.value, sides[0][0], sides[1][0])
        paths = []
        for begin, statements in sides:
            builder.position_at_end(begin)
            self.at.names = dict(previous)
            if not self.block(statements):
                paths.append(Path(builder.block, self.at.names))
        return self.join(paths)

    def in_some(self, condition: Truth, node: Any) -> bool:
        """Run each branch in its lanes, if there are any; return whether no path continues."""
        builder, active_trace, outer = trace().builder, trace(), self.at.mask
        has_ended = []
        for taken_mask, statements in ((condition, node.body), (symbols.opposite(condition), node.orelse)):
            if not statements:
                has_ended.append(False)
                continue
            self.at.mask = taken_mask if outer is None else symbols.both(outer, taken_mask)
            begin, skip = active_trace.block(), active_trace.block()
            previous = dict(self.at.names)
            builder.cbranch(none_of(self.at.lanes_in_all()).value, skip, begin)
            builder.position_at_end(begin)
            has_ended.append(self.block(statements))
            inside = self.at.names
            for name, value in inside.items():  # a new name has no value in lanes of the other branch
                if name not in previous:
                    previous[name] = (
                        all_lanes(active_trace.width) if name.startswith(LANES) else changed(value, nothing)
                    )
            self.join([Path(builder.block, inside), Path(skip, previous)])
            self.at.mask = outer
        return all(has_ended)

    def join(self, paths: list[Path]) -> bool:
        """Continue where paths join, with their common variables; return whether there are no paths."""
        if not paths:
            return True
        if len(paths) == 1:
            trace().builder.position_at_end(paths[0].block)
            self.at.names = paths[0].value
            return False
        constant_value = [name for name in paths[0].value if all(name in path.value for path in paths)]
        builder, end = trace().builder, trace().block()
        met: dict[str, Any] = {}
        for name in constant_value:
            column = [path.value[name] for path in paths]
            if all(x is column[0] for x in column):
                met[name] = column[0]
                continue
            try:
                column = alike(column)
                rows = [list(leaves(x)) for x in column]
                if len({len(row) for row in rows}) != 1:
                    continue
                blocks = [path.block for path in paths]
                results = [meeting(blocks, list(items), end) for items in zip(*rows, strict=True)]
            except NotTraceableError:
                continue  # a name with different structures has no value from here on
            met[name] = rebuilt(column[0], iter(results))
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
        """End a turn of a loop."""
        lanes = self.at.lanes()
        if lanes is not None:
            self.stop(f"{LANES}of turn {len(self.at.loops)}", lanes)
            return True
        self.at.loops[-1].goes_on.append(Path(trace().builder.block, dict(self.at.names)))
        return True
