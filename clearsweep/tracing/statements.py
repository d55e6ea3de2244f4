"""Statements of a body on symbols, except loops."""

import ast
import contextlib
from typing import Any

from . import activation, symbols
from .expressions import Expressions
from .symbols import Boolean, NotTraceableError, is_symbol, trace


class Statements(Expressions):
    """Runs the statements of an activation."""

    def block(self, statements: list[Any]) -> bool:
        """Run statements; return whether no path continues after them."""
        for i, statement in enumerate(statements):
            running, self.activation.node = self.activation.names.get(activation.LANES), statement
            if getattr(self, f"execute_{type(statement).__name__}", self.refuse_statement)(statement):
                return True
            if (
                self.activation.names.get(activation.LANES) is not running and not self.activation.loops
            ):  # some lanes returned
                return self.run_if_any(statements[i + 1 :])
        return False

    def refuse_statement(self, node: Any) -> bool:
        """Raise the error for an unsupported statement."""
        raise NotTraceableError(f"has an unsupported statement ({type(node).__name__})")

    def execute_Expr(self, node: Any) -> bool:  # noqa: N802 - named by the syntax, as all that follow
        """Evaluate an expression for its effect."""
        if not isinstance(node.value, ast.Constant):
            self.value(node.value)
        return False

    def execute_Pass(self, node: Any) -> bool:  # noqa: N802
        """Do nothing."""
        return False

    def execute_Assert(self, node: Any) -> bool:  # noqa: N802
        """Check what is known while tracing."""
        condition = self.condition_value(node.test)
        if is_symbol(condition):
            raise NotTraceableError("asserts what is known only at run time, where nothing can be raised")
        if not condition:
            raise NotTraceableError("asserts what is false")
        return False

    def execute_Return(self, node: Any) -> bool:  # noqa: N802
        """End this path of the function."""
        value = self.value(node.value) if node.value else None
        lanes = self.activation.lanes()
        if lanes is None or (
            self.activation.mask is None and activation.LANES not in self.activation.names and not self.activation.loops
        ):
            self.leave(value)
        elif activation.RETURNED not in self.activation.names and any(loop.is_rolled for loop in self.activation.loops):
            raise activation.ReturnInLanes(value)
        else:
            self.activation.names[activation.RETURNED] = activation.select_values(
                lanes, value, self.activation.names.get(activation.RETURNED, value)
            )
            self.stop(activation.LANES, lanes)
        return True

    def leave(self, value: Any) -> None:
        """End this path of the function for all lanes; lanes that ended before keep their returned values."""
        if activation.RETURNED in self.activation.names:
            value = activation.select_values(
                self.activation.names[activation.LANES], value, self.activation.names[activation.RETURNED]
            )
        self.activation.returns.append(activation.Path(trace().builder.block, value))

    def stop(self, name: str, lanes: Any) -> None:
        """Deactivate some lanes."""
        is_running = self.activation.names.get(name, True)
        self.activation.names[name] = symbols.bit_and(is_running, symbols.logical_not(lanes))

    def execute_Assign(self, node: Any) -> bool:  # noqa: N802
        """Assign a value to names, items or places in arrays."""
        assigned = self.value(node.value)
        for target in node.targets:
            self.assign(target, assigned)
        return False

    def execute_AnnAssign(self, node: Any) -> bool:  # noqa: N802
        """Assign a value to an annotated name."""
        if node.value:
            self.assign(node.target, self.value(node.value))
        return False

    def execute_AugAssign(self, node: Any) -> bool:  # noqa: N802
        """Change a value in place."""
        target = node.target
        if isinstance(target, ast.Name):
            old_value = self.activation.look_up(target.id)
            if isinstance(old_value, (list, set, dict)):
                raise NotTraceableError(f"changes a {type(old_value).__name__} in place")
            self.assign(target, self.binary(node.op, old_value, self.value(node.value)))
            return False
        if isinstance(target, ast.Attribute):
            fields, name = self.fields(target), target.attr
            setattr(fields, name, self.binary(node.op, getattr(fields, name), self.value(node.value)))
            return False
        array, index = self.array(target), self.index(target.slice)
        old_value = self.item(array, index)
        array[index] = self.binary(node.op, old_value, self.value(node.value))
        return False

    def execute_If(self, node: Any) -> bool:  # noqa: N802
        """Run one branch, or both if the condition is a symbol."""
        condition = self.condition_value(node.test)
        if not is_symbol(condition):
            return self.block(node.body if condition else node.orelse)
        if condition.width > 1:
            return self.run_branches_in_lanes(condition, node)
        builder, active_trace, names_before = trace().builder, trace(), self.activation.names
        branches = (active_trace.block(), node.body), (active_trace.block(), node.orelse)
        builder.cbranch(condition.value, branches[0][0], branches[1][0])
        paths = []
        for begin, statements in branches:
            builder.position_at_end(begin)
            self.activation.names = dict(names_before)
            if not self.block(statements):
                paths.append(activation.Path(builder.block, self.activation.names))
        return self.join(paths)

    def run_branches_in_lanes(self, condition: Boolean, node: Any) -> bool:
        """Run each branch in its lanes, if there are any; return whether no path continues."""
        outer, has_ended = self.activation.mask, []
        for branch_lanes, statements in ((condition, node.body), (symbols.logical_not(condition), node.orelse)):
            self.activation.mask = branch_lanes if outer is None else symbols.bit_and(outer, branch_lanes)
            has_ended.append(self.run_if_any(statements))
            self.activation.mask = outer
        return all(has_ended)

    def run_if_any(self, statements: list[Any]) -> bool:
        """Run statements if any lane is active; return whether no path continues in these lanes."""
        if not statements:
            return False
        builder, begin, skip = trace().builder, trace().block(), trace().block()
        skipped_names = dict(self.activation.names)
        builder.cbranch(activation.none_of(self.activation.lanes_in_all()).value, skip, begin)
        builder.position_at_end(begin)
        has_ended = self.block(statements)
        branch_names = self.activation.names
        for name, value in branch_names.items():  # a new name has no value in lanes that skip
            if name not in skipped_names:
                is_mask = name.startswith(activation.LANES)
                skipped_names[name] = (
                    activation.all_lanes(trace().width)
                    if is_mask
                    else activation.map_leaves(value, activation.undefined_like)
                )
        self.join([activation.Path(builder.block, branch_names), activation.Path(skip, skipped_names)])
        return has_ended

    def join(self, paths: list[activation.Path]) -> bool:
        """Continue where paths join, with their common variables; return whether there are no paths."""
        if not paths:
            return True
        if len(paths) == 1:
            trace().builder.position_at_end(paths[0].block)
            self.activation.names = paths[0].value
            return False
        common_names = [name for name in paths[0].value if all(name in path.value for path in paths)]
        end, merged_names = trace().block(), dict[str, Any]()
        for name in common_names:
            column = [path.value[name] for path in paths]
            if all(x is column[0] for x in column):
                merged_names[name] = column[0]
                continue
            with contextlib.suppress(NotTraceableError):  # a name with different structures has no value from here on
                merged_names[name] = activation.merged([path.block for path in paths], column, end)
        activation.lead(paths, end)
        self.activation.names = merged_names
        return False

    def execute_Break(self, node: Any) -> bool:  # noqa: N802
        """Leave a loop."""
        return self.end("loop", self.activation.loops[-1].breaks)

    def execute_Continue(self, node: Any) -> bool:  # noqa: N802
        """End an iteration of a loop."""
        return self.end("iteration", self.activation.loops[-1].continues)

    def end(self, kind: str, exits: list[activation.Path]) -> bool:
        """End a loop or an iteration of it: active lanes by its mask, all lanes by an exit; no path continues."""
        lanes = self.activation.lanes()
        if lanes is not None:
            self.stop(f"{activation.LANES}of {kind} {len(self.activation.loops)}", lanes)
        else:
            exits.append(activation.Path(trace().builder.block, dict(self.activation.names)))
        return True
