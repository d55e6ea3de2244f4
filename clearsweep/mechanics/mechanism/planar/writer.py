"""Writes sums and products as lines of code, without zero terms.

A number is represented by its name, or None if zero.  The same expression is written once.
"""


class Lines:
    """Lines of a generated function."""

    def __init__(self, *arguments: str):
        self.arguments = arguments
        self.text: list[str] = []
        self._names: dict[str, str] = {}

    def let(self, expression: str | None) -> str | None:
        """Return a name for an expression."""
        if expression is None or expression.isidentifier() or expression == "1.0":
            return expression
        if expression not in self._names:
            self._names[expression] = f"v{len(self._names)}"
            self.text.append(f"{self._names[expression]} = {expression}")
        return self._names[expression]

    def once(self, line: str) -> None:
        """Write a line, unless it is there already."""
        if line not in self.text:
            self.text.append(line)

    def product(self, *factors: str | None) -> str | None:
        """Return a product as an expression without a name."""
        if None in factors:
            return None
        operands = [self.let(factor) for factor in factors if factor != "1.0"]
        return " * ".join(operands) if operands else "1.0"

    def total(self, *terms: str | None) -> str | None:
        """Return a name for a sum of products; a product that begins with '-' is subtracted."""
        present_terms = [term for term in terms if term is not None]
        if not present_terms:
            return None
        text = present_terms[0]
        for term in present_terms[1:]:
            text += f" - {term[1:]}" if term.startswith("-") else f" + {term}"
        return self.let(text)

    def minus(self, term: str | None) -> str | None:
        """Return the negative of a product."""
        if term is None:
            return None
        return term[1:] if term.startswith("-") else f"-{term}"

    def dot(self, first: tuple, second: tuple) -> tuple:
        """Return the terms of the scalar product of two vectors."""
        return tuple(self.product(a, b) for a, b in zip(first, second, strict=True))

    def function(self, name: str, result: str) -> str:
        """Return the code of the whole function."""
        body = "".join(f"    {line}\n" for line in [*self.text, f"return {result}"])
        return f"def {name}({', '.join(self.arguments)}):\n{body}"


def number(name: str | None) -> str:
    """Return a name, or '0.0' for None."""
    return "0.0" if name is None else name


def packed(names: list) -> str:
    """Return the code of a tuple of numbers."""
    return tupled(list(map(number, names)))


def tupled(items: list[str]) -> str:
    """Return the code of a tuple of expressions."""
    return f"({''.join(f'{item}, ' for item in items)})"
