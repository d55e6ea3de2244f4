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
        which = bisect_right(self.ends, index)
        block = self.blocks[which]
        index -= self.ends[which] - block.size
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
    words = [path for path in paths if isinstance(shape[path], Word)]
    blocks = {}
    for choice in product(*(axes[path] for path in words)):
        names = dict(names_in_grid) | {path: frozenset({word}) for path, word in zip(words, choice, strict=True)}
        chosen = {
            path: word if value_key(shape, path).used(names) else None for path, word in zip(words, choice, strict=True)
        }
        used = tuple(path for path in paths if path not in chosen and value_key(shape, path).used(names))
        blocks[tuple(chosen.values())] = Block(chosen, used, math.prod(len(axes[path]) for path in used))
    return Factor(tuple(blocks.values()), tuple(accumulate(block.size for block in blocks.values())))


def words_at(point: Mapping[str, Any]) -> Words:
    """Return the law names among the values at a point."""
    return frozenset((path, value) for path, value in point.items() if isinstance(value, str))


def combined(
    factors: Sequence[Factor | Step],
    axes: Mapping[str, tuple[Any, ...]],
    texts_of: Callable[[Mapping[str, Any]], dict[str, str]],
    part: range,
) -> Iterator[tuple[Words, dict[str, str]]]:
    """Yield law names and value texts of the cases in `part`, a range of indices of step 1, in order.

    `texts_of` returns the texts of part of a point.  Cases before the range take no time.
    """
    if not factors:
        if len(part):
            yield frozenset(), {}
        return
    *before, last = factors

    def rows(some: range) -> Iterator[tuple[Words, dict[str, str]]]:
        points = (last.point(k, axes) for k in some)
        return ((words_at(point), texts_of(point)) for point in points)

    kept = list(rows(range(last.size))) if last.size <= KEPT else None
    outer = range(part.start // last.size, -(-part.stop // last.size))
    for k, (words, texts) in zip(outer, combined(before, axes, texts_of, outer), strict=True):
        begin, end = max(part.start - k * last.size, 0), min(part.stop - k * last.size, last.size)
        for more, further in rows(range(begin, end)) if kept is None else kept[begin:end]:
            yield words | more, texts | further
