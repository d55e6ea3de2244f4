"""Vectors in the plane, of the numbers of a program."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from ....tracing.compiled.formulas import ZERO, Expr, sum_of


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
