"""Programs of machines: made once for each type of a compiled form, run on its values."""

import functools
from collections.abc import Callable
from typing import Any

from ...tracing.compiled.family import form_number
from ...tracing.compiled.formulas import Program
from ...tracing.protocols import register_emitter
from ...tracing.symbols import trace


def kinds_of(value: Any) -> Any:
    """Return the types in nested tuples."""
    if not isinstance(value, tuple):
        return float
    return (
        type(value),
        *[float if type(item) is float else kinds_of(item) for item in value],
    )  # most items are floats


def generated(structure_of: Callable[[tuple], Any]) -> Callable:
    """Return a decorator that makes a function of a machine's structure, which returns a Program, run that program.

    structure_of : returns the structure for the result of `kinds_of`; the function takes (mechanism, ...)
    """

    def decorate(build: Callable) -> Callable:
        program_for = functools.lru_cache(maxsize=1024)(lambda kinds: build(structure_of(kinds)))
        by_form: dict[int, Program] = {}  # faster than by kinds

        @functools.wraps(build)
        def run(mechanism: tuple, *arguments: Any) -> Any:
            form = form_number(mechanism)
            if form not in by_form:
                by_form[form] = program_for(kinds_of(mechanism))
            return by_form[form](mechanism, *arguments)

        @register_emitter(run)
        def emit(mechanism: tuple, *arguments: Any) -> Any:
            trace().sources.add(build.__code__.co_filename)
            return program_for(kinds_of(mechanism)).emit(mechanism, *arguments)

        return run

    return decorate
