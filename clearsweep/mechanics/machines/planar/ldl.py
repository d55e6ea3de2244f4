"""LDL factors of a symmetric matrix in a program, and the solution of linear equations by them."""

from collections.abc import Callable, Mapping, Sequence
from typing import Generic, TypeVar

from ....tracing.compiled.formulas import ZERO, Expr, sum_of

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
