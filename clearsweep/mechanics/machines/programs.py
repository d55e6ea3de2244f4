"""Programs of machines: made once for each type of a compiled form, run on its values; vectors and linear equations."""

import functools
from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from ...tracing.compiled.family import form_number
from ...tracing.compiled.formulas import ZERO, Expr, Program, sum_of
from ...tracing.protocols import register_emitter
from ...tracing.symbols import trace


def kinds_of(value: Any) -> Any:
    """Return the types in nested tuples."""
    if not isinstance(value, tuple):
        return float
    return (type(value), *[float if type(item) is float else kinds_of(item) for item in value])  # most items are floats


class _AlwaysEqual:
    """A value that equals any other, so that a cache finds results by the other parts of a key."""

    def __init__(self, value: Any):
        self.value = value

    def __eq__(self, other_value: object) -> bool:
        return isinstance(other_value, _AlwaysEqual)

    def __hash__(self) -> int:
        return 0


Function = TypeVar("Function", bound=Callable)


def shared_by(key_of: Callable, size: int = 64) -> Callable[[Function], Function]:
    """Return a decorator that lets calls share their result if `key_of`, which takes their arguments, is equal."""

    def decorate(function: Function) -> Function:
        @functools.lru_cache(maxsize=size)
        def shared(key: Hashable, arguments: _AlwaysEqual) -> Any:
            values, arguments.value = arguments.value, ()  # the cache keeps its keys
            return function(*values)

        @functools.wraps(function)
        def call(*arguments: Any) -> Any:
            return shared(key_of(*arguments), _AlwaysEqual(arguments))

        return call

    return decorate


def generated(structure_of: Callable[[Any], Any]) -> Callable:
    """Return a decorator that makes a function of a machine's structure, which returns a Program, run that program.

    structure_of : returns the structure of a compiled machine, by its types; the function takes (mechanism, ...)
    """

    def decorate(build: Callable) -> Callable:
        @shared_by(kinds_of, 1024)
        def program_for(mechanism: tuple) -> Program:
            return build(structure_of(mechanism))

        by_form: dict[int, Program] = {}  # faster than by kinds

        @functools.wraps(build)
        def run(mechanism: tuple, *arguments: Any) -> Any:
            form = form_number(mechanism)
            if form not in by_form:
                by_form[form] = program_for(mechanism)
            return by_form[form](mechanism, *arguments)

        @register_emitter(run)
        def emit(mechanism: tuple, *arguments: Any) -> Any:
            trace().sources.add(build.__code__.co_filename)
            return program_for(mechanism).emit(mechanism, *arguments)

        return run

    return decorate


# ---------------------------------------------------------------------------------------------- linear equations


Unknown = TypeVar("Unknown")


class LDL(Generic[Unknown]):
    """The factors L D L^T of a symmetric positive definite matrix, L with ones on its diagonal."""

    def __init__(self, unknown: Sequence[Unknown], entry: Callable[[Unknown, Unknown], Expr]):
        """Compute the factors; entry : the entry of the matrix in the row and column of two unknowns."""
        self.unknown = unknown
        self.inverse: dict[Unknown, Expr] = {}  # 1 / D
        self._lower: dict[tuple[Unknown, Unknown], Expr] = {}  # L below its diagonal
        scaled: dict[tuple[Unknown, Unknown], Expr] = {}  # L D
        for j, b in enumerate(unknown):
            eliminated = [-(scaled[b, k] * self._lower[b, k]) for k in unknown[:j]]
            self.inverse[b] = 1.0 / sum_of([entry(b, b), *eliminated])
            for a in unknown[j + 1 :]:
                eliminated = [-(scaled[a, k] * self._lower[b, k]) for k in unknown[:j]]
                scaled[a, b] = sum_of([entry(a, b), *eliminated])
                self._lower[a, b] = (scaled[a, b] * self.inverse[b]).assigned()

    def forward(self, right_side: Mapping[Unknown, Expr]) -> dict[Unknown, Expr]:
        """Return L^-1 times a column; a missing entry is zero."""
        solution: dict[Unknown, Expr] = {}
        for i, a in enumerate(self.unknown):
            eliminated = [-(self._lower[a, k] * solution[k]) for k in self.unknown[:i]]
            solution[a] = sum_of([right_side.get(a, ZERO), *eliminated])
        return solution

    def solve(self, right_side: Mapping[Unknown, Expr]) -> dict[Unknown, Expr]:
        """Return the unknowns for a right-hand side."""
        reduced = self.forward(right_side)  # D L^T times the unknowns
        solution: dict[Unknown, Expr] = {}
        for i in range(len(self.unknown) - 1, -1, -1):
            a = self.unknown[i]
            eliminated = [-(self._lower[k, a] * solution[k]) for k in self.unknown[i + 1 :]]
            solution[a] = sum_of([reduced[a] * self.inverse[a], *eliminated])
        return solution


# ---------------------------------------------------------------------------------------------- vectors in the plane


@dataclass(frozen=True)
class PlaneVector:
    """A vector in the plane, of the numbers of a program."""

    x: Expr
    y: Expr

    def __iter__(self) -> Iterator[Expr]:
        return iter((self.x, self.y))

    def __neg__(self) -> "PlaneVector":
        return PlaneVector(-self.x, -self.y)

    def __add__(self, other: "PlaneVector") -> "PlaneVector":
        return vector_sum((self, other))

    def __sub__(self, other: "PlaneVector") -> "PlaneVector":
        return vector_sum((self, -other))

    def __rmul__(self, factor: Expr) -> "PlaneVector":
        return PlaneVector(factor * self.x, factor * self.y)

    def dot(self, other: "PlaneVector") -> Expr:
        """Return the scalar product."""
        return sum_of(self.products(other))

    def products(self, other: "PlaneVector") -> tuple[Expr, Expr]:
        """Return the two terms of the scalar product."""
        return self.x * other.x, self.y * other.y

    def cross(self, other: "PlaneVector") -> Expr:
        """Return the component of the vector product normal to the plane."""
        return self.x * other.y - self.y * other.x

    def left(self) -> "PlaneVector":
        """Return the vector rotated by 90 degrees, counter-clockwise."""
        return PlaneVector(-self.y, self.x)

    def rotated(self, cosine: Expr, sine: Expr) -> "PlaneVector":
        """Return the vector rotated by the angle of this cosine and sine."""
        return PlaneVector(cosine * self.x - sine * self.y, sine * self.x + cosine * self.y)

    def assigned(self) -> "PlaneVector":
        """Return the vector with its components in variables."""
        return PlaneVector(self.x.assigned(), self.y.assigned())


NO_VECTOR = PlaneVector(ZERO, ZERO)


def vector_sum(vectors: Iterable[PlaneVector]) -> PlaneVector:
    """Return the sum of vectors, its components in variables."""
    present_vectors = list(vectors)
    return PlaneVector(sum_of(v.x for v in present_vectors), sum_of(v.y for v in present_vectors))
