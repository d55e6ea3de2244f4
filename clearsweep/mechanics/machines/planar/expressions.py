"""Formulas that write the code of a generated function.

An `Expr` is a number of that function, and operators on it write code.  A sum is assigned to a variable at once, a
product when it becomes a term's factor on the right or is assigned by name.  Equal expressions share a variable, and
zero terms, zero factors and factors of one are left out.  Operations keep the order and the grouping of the formula:
`a * b * c` is (a b) c, `a * (b * c)` assigns b c first; so the result is fixed to the last bit.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

Components = tuple[str | None, str | None]  # code of x and y of a vector; None: zero


class FunctionCode:
    """The code of a generated function, line by line."""

    def __init__(self, *arguments: str):
        self.arguments = arguments
        self.lines: list[str] = []
        self._variables: dict[str, str] = {}

    def write(self, line: str) -> None:
        """Append a statement."""
        self.lines.append(line)

    def expression(self, text: str | None) -> "Expr":
        """Return code as an Expr without assigning it to a variable."""
        return ZERO if text is None else Expr(text, self)

    def vector(self, components: Components) -> "PlaneVector":
        """Return the vector with these components, which are not assigned to variables."""
        return PlaneVector(*map(self.expression, components))

    def assign(self, value: "Expr | str") -> "Expr":
        """Return a variable with this value; write its assignment if no variable has the value yet."""
        text = str(value)
        if text.isidentifier() or text in (ZERO.text, ONE.text):
            return Expr(text, self)
        if text not in self._variables:
            self._variables[text] = f"v{len(self._variables)}"
            self.write(f"{self._variables[text]} = {text}")
        return Expr(self._variables[text], self)

    def call(self, function: str, *arguments: "Expr | str") -> "Expr":
        """Return a variable with the value of a function."""
        return self.assign(f"{function}({', '.join(map(str, arguments))})")

    def function(self, name: str, result: "Expr | str") -> str:
        """Return the code of the complete function."""
        body = "".join(f"    {line}\n" for line in [*self.lines, f"return {result}"])
        return f"def {name}({', '.join(self.arguments)}):\n{body}"


@dataclass(frozen=True)
class Expr:
    """A number of a generated function: a variable, a literal, or a product, which may begin with a minus sign."""

    text: str
    code: FunctionCode | None = field(default=None, compare=False, repr=False)  # None: a constant
    is_product: bool = field(default=False, compare=False)

    def __str__(self) -> str:
        return self.text

    def __neg__(self) -> "Expr":
        if self == ZERO:
            return ZERO
        text = self.text[1:] if self.text.startswith("-") else f"-{self.text}"
        return Expr(text, self.code, self.is_product)

    def __add__(self, other: "Expr") -> "Expr":
        return sum_of((self, other))

    def __sub__(self, other: "Expr") -> "Expr":
        return sum_of((self, -other))

    def __mul__(self, other: "Expr") -> "Expr":
        if not isinstance(other, Expr):
            return NotImplemented
        if ZERO in (self, other):
            return ZERO
        left_factor = self if self.is_product else self.assigned()
        if other == ONE:
            return left_factor
        right_factor = other.assigned()
        if self == ONE:
            return right_factor
        return Expr(f"{left_factor} * {right_factor}", self.code or other.code, is_product=True)

    def __rmul__(self, number: float) -> "Expr":
        return Expr(repr(number), self.code) * self

    def __rtruediv__(self, number: float) -> "Expr":
        return Expr(f"{number!r} / {self.assigned()}", self.code).assigned()

    def assigned(self) -> "Expr":
        """Return a variable with this value."""
        return self if self.code is None else self.code.assign(self)


ZERO, ONE = Expr("0.0"), Expr("1.0")


def sum_of(terms: Iterable[Expr]) -> Expr:
    """Return a variable with the sum of terms, added from left to right."""
    present_terms = [term for term in terms if term != ZERO]
    if not present_terms:
        return ZERO
    text = present_terms[0].text
    for term in present_terms[1:]:
        text += f" - {term.text[1:]}" if term.text.startswith("-") else f" + {term.text}"
    code = next((term.code for term in present_terms if term.code), None)
    return Expr(text, code).assigned()


@dataclass(frozen=True)
class PlaneVector:
    """A vector in the plane of a generated function."""

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


def tuple_code(items: Iterable[Expr | str]) -> str:
    """Return the code of a tuple."""
    return f"({''.join(f'{item}, ' for item in items)})"
