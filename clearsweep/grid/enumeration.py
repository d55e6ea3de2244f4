"""Numbers the cases of a grid, which are a product of factors: blocks of axes, or axes in step."""

import math
from bisect import bisect_right
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import accumulate, product
from typing import Any, NamedTuple

from .keys import Shape, Word, value_key

KEPT = 4096  # rows of a factor kept in memory while all cases are enumerated

Words = frozenset[tuple[str, str]]  # swept paths and their law names


class Block(NamedTuple):
    """A combination of law names and the axes in use with it."""

    words: dict[str, str | None]  # swept law names; None: not in use
    paths: tuple[str, ...]
    size: int


class Factor(NamedTuple):
    """Axes that depend on the same law names, in blocks; the cases of a grid are the product of its factors."""

    blocks: tuple[Block, ...]
    ends: tuple[int, ...]  # index after the last row of each block

    @property
    def size(self) -> int:
        """Return the number of combinations of these axes."""
        return self.ends[-1]

    def point(self, index: int, axes: Mapping[str, tuple[Any, ...]]) -> dict[str, Any]:
        """Return the values of these axes at `index`; the last axis varies fastest."""
        factor_index = bisect_right(self.ends, index)
        block = self.blocks[factor_index]
        index -= self.ends[factor_index] - block.size
        values: dict[str, Any] = dict(block.words)
        for path in reversed(block.paths):
            index, k = divmod(index, len(axes[path]))
            values[path] = axes[path][k]
        return values


class Step(NamedTuple):
    """Axes in step: cases take their values row by row."""

    paths: tuple[str, ...]
    rows: tuple[int, ...]  # positions on the axes; only the first of equal rows

    @property
    def size(self) -> int:
        """Return the number of different rows."""
        return len(self.rows)

    def point(self, index: int, axes: Mapping[str, tuple[Any, ...]]) -> dict[str, Any]:
        """Return the values of these axes at `index`."""
        return {path: axes[path][self.rows[index]] for path in self.paths}


def step_of(paths: tuple[str, ...], axes: Mapping[str, tuple[Any, ...]]) -> Step:
    """Return axes in step; of equal rows only the first is kept."""
    rows: dict[tuple[Any, ...], int] = {}
    for row, values in enumerate(zip(*(axes[path] for path in paths), strict=True)):
        rows.setdefault(values, row)
    return Step(paths, tuple(rows.values()))


def factor_of(
    paths: list[str], axes: Mapping[str, tuple[Any, ...]], shape: Shape, names_in_grid: Mapping[str, frozenset[str]]
) -> Factor:
    """Return the blocks of axes that depend on the same law names, one for each distinct combination."""
    word_paths = [path for path in paths if isinstance(shape[path], Word)]
    blocks = {}
    for choice in product(*(axes[path] for path in word_paths)):
        names = dict(names_in_grid) | {path: frozenset({word}) for path, word in zip(word_paths, choice, strict=True)}
        numbers_chosen = {
            path: word if value_key(shape, path).used(names) else None
            for path, word in zip(word_paths, choice, strict=True)
        }
        used_paths = tuple(path for path in paths if path not in numbers_chosen and value_key(shape, path).used(names))
        blocks[tuple(numbers_chosen.values())] = Block(
            numbers_chosen, used_paths, math.prod(len(axes[path]) for path in used_paths)
        )
    return Factor(tuple(blocks.values()), tuple(accumulate(block.size for block in blocks.values())))


def words_at(point: Mapping[str, Any]) -> Words:
    """Return the law names among the values at a point."""
    return frozenset((path, value) for path, value in point.items() if isinstance(value, str))


def combined(
    factors: Sequence[Factor | Step],
    axes: Mapping[str, tuple[Any, ...]],
    texts_of: Callable[[Mapping[str, Any]], dict[str, str]],
    interval: range,
) -> Iterator[tuple[Words, dict[str, str]]]:
    """Yield law names and value texts of the cases in `interval`, a range of indices of step 1, in order.

    `texts_of` returns the texts of part of a point.  Cases before the range take no time.
    """
    if not factors:
        if len(interval):
            yield frozenset(), {}
        return
    *outer_factors, last = factors

    def rows(indices: range) -> Iterator[tuple[Words, dict[str, str]]]:
        points = (last.point(k, axes) for k in indices)
        return ((words_at(point), texts_of(point)) for point in points)

    cached_rows = list(rows(range(last.size))) if last.size <= KEPT else None
    outer = range(interval.start // last.size, -(-interval.stop // last.size))
    for k, (word_paths, texts) in zip(outer, combined(outer_factors, axes, texts_of, outer), strict=True):
        start, end = max(interval.start - k * last.size, 0), min(interval.stop - k * last.size, last.size)
        for row_words, row_values in rows(range(start, end)) if cached_rows is None else cached_rows[start:end]:
            yield word_paths | row_words, texts | row_values
