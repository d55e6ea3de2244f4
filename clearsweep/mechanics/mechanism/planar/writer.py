"""Sums and products written as lines of code; what is zero is not written.

A number is the name of one, or None where it is zero.  The same expression is written once.
"""


class Lines:
    """Lines of a function in the making."""

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
        """Write a line, but only the first time that it is asked for."""
        if line not in self.text:
            self.text.append(line)

    def product(self, *factors: str | None) -> str | None:
        """Return a product, without a name so far."""
        if None in factors:
            return None
        written = [self.let(factor) for factor in factors if factor != "1.0"]
        return " * ".join(written) if written else "1.0"

    def total(self, *terms: str | None) -> str | None:
        """Return a name for a sum of products; of one that begins with '-' the rest is subtracted."""
        there = [term for term in terms if term is not None]
        if not there:
            return None
        text = there[0]
        for term in there[1:]:
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
        """Return the function as a whole."""
        body = "".join(f"    {line}\n" for line in [*self.text, f"return {result}"])
        return f"def {name}({', '.join(self.arguments)}):\n{body}"


def number(name: str | None) -> str:
    """Return a name as it is written where a number has to appear."""
    return "0.0" if name is None else name


def packed(names: list) -> str:
    """Return a tuple of numbers as it is written."""
    return tupled(list(map(number, names)))


def tupled(items: list[str]) -> str:
    """Return a tuple of what is written already."""
    return f"({''.join(f'{item}, ' for item in items)})"
