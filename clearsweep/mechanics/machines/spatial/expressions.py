"""Vectors in space, of the values of a program; operations call the functions of `compiled.vector`."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from ....tracing.compiled import vector as vectors
from ....tracing.compiled.formulas import Expr, constant
from ....tracing.compiled.vector import Vector
from .pose import elementwise_product

AXES = "xyz"


@dataclass(frozen=True)
class SpatialVector:
    """A vector of a program."""

    value: Expr

    def __add__(self, other: "SpatialVector") -> "SpatialVector":
        if NO_VECTOR in (self, other):
            return other if self == NO_VECTOR else self
        return self._call(vectors.plus, self, other)

    def __sub__(self, other: "SpatialVector") -> "SpatialVector":
        return self if other == NO_VECTOR else other._call(vectors.minus, self, other)

    def __neg__(self) -> "SpatialVector":
        return -1.0 * self

    def __rmul__(self, factor: Expr | float) -> "SpatialVector":
        return NO_VECTOR if self == NO_VECTOR else self._call(vectors.times, factor, self)

    def __getitem__(self, axis: int) -> Expr:
        """Return the component number `axis`."""
        component: Expr = getattr(self.value, AXES[axis])
        return component

    def cross(self, other: "SpatialVector") -> "SpatialVector":
        """Return the vector product."""
        return NO_VECTOR if NO_VECTOR in (self, other) else self._call(vectors.cross, self, other)

    def dot(self, other: "SpatialVector") -> Expr:
        """Return the scalar product."""
        return self._call(vectors.dot, self, other).value

    def componentwise(self, other: "SpatialVector") -> "SpatialVector":
        """Return the vector of the products of the components."""
        return self._call(elementwise_product, self, other)

    def _call(self, function: Any, *arguments: Any) -> "SpatialVector":
        program = next(x.value.program for x in arguments if isinstance(x, SpatialVector) and x.value.program)
        values = (x.value if isinstance(x, SpatialVector) else x for x in arguments)
        return SpatialVector(program.call(function, *values))


NO_VECTOR = SpatialVector(constant(Vector(0.0, 0.0, 0.0)))


def vector_sum(addends: Iterable[SpatialVector]) -> SpatialVector:
    """Return the sum of vectors, added from left to right."""
    total = NO_VECTOR
    for vector in addends:
        total += vector
    return total
