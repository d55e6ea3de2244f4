"""Formulas of vectors that write the code of a generated function; numbers are those of `planar.expressions`.

Operations call the functions of `compiled.vector`, and each result is assigned to a variable at once.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field

from ..planar.expressions import Expr, FunctionCode

AXES = "xyz"


@dataclass(frozen=True)
class SpatialVector:
    """A vector of a generated function."""

    text: str
    code: FunctionCode | None = field(default=None, compare=False, repr=False)  # None: zero

    def __str__(self) -> str:
        return self.text

    def __add__(self, other: "SpatialVector") -> "SpatialVector":
        if NO_VECTOR in (self, other):
            return other if self == NO_VECTOR else self
        return self._call("plus", self, other)

    def __sub__(self, other: "SpatialVector") -> "SpatialVector":
        return self if other == NO_VECTOR else other._call("minus", self, other)

    def __neg__(self) -> "SpatialVector":
        return -1.0 * self

    def __rmul__(self, factor: Expr | float) -> "SpatialVector":
        return NO_VECTOR if self == NO_VECTOR else self._call("times", factor, self)

    def __getitem__(self, axis: int) -> Expr:
        """Return the component number `axis`."""
        return Expr(f"{self}.{AXES[axis]}", self.code)

    def cross(self, other: "SpatialVector") -> "SpatialVector":
        """Return the vector product."""
        return NO_VECTOR if NO_VECTOR in (self, other) else self._call("cross", self, other)

    def dot(self, other: "SpatialVector") -> Expr:
        """Return the scalar product."""
        return Expr(f"dot({self}, {other})", self.code or other.code).assigned()

    def componentwise(self, other: "SpatialVector") -> "SpatialVector":
        """Return the vector of the products of the components."""
        return self._call("elementwise_product", self, other)

    def _call(self, function: str, *arguments: object) -> "SpatialVector":
        assert self.code is not None  # zero vectors are handled before
        return SpatialVector(self.code.call(function, *map(str, arguments)).text, self.code)


NO_VECTOR = SpatialVector("Vector(0.0, 0.0, 0.0)")


def vector_sum(vectors: Iterable[SpatialVector]) -> SpatialVector:
    """Return the sum of vectors, added from left to right."""
    total = NO_VECTOR
    for vector in vectors:
        total += vector
    return total
