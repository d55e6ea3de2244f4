"""Global maxima of functions on an interval that can be evaluated anywhere and may jump."""

import functools
from collections.abc import Callable

import numpy as np

ACCURATE = 1e-9  # of the largest value: allowed difference of neighbouring samples at a maximum
CLOSEST = 1e-12  # of the interval: of two closer places one is dropped
STEEP = 8.0  # times the median slope of neighbours: a steeper interval may contain a jump
NEIGHBOURS = 7  # intervals in this median
MOST = 32  # jumps, and maxima of a function, that are refined
INSIDE = 8  # further samples on each side of a maximum per round
BESIDE = 1e-3  # of its interval: distance of two more samples from the vertex of the parabola
ROUNDS = 60

Functions = Callable[[np.ndarray], np.ndarray]  # (n,) -> (m, n): m functions at n places


def largest(functions: Functions, places: np.ndarray) -> np.ndarray:
    """Return the largest value of each function between the ends of `places`, (m,); nan if undefined.

    places : (n,) increasing, initial samples; a peak that lies between two of them can be missed.
    """
    places = places[np.append(True, np.diff(places) > CLOSEST * np.ptp(places))]
    values = functions(places)
    most = np.full(len(values), np.nan)
    defined = np.isfinite(values).all(axis=1)
    if defined.any():

        def those(at: np.ndarray) -> np.ndarray:
            return functions(at)[defined]

        samples = [(places, values[defined])]
        most[defined] = _maxima(those, *_merged(samples + _jumps(those, *samples[0])))
    return most


def _merged(samples: list[tuple[np.ndarray, np.ndarray]]) -> tuple[np.ndarray, np.ndarray]:
    """Return samples, places (n,) and values (m, n), merged in increasing order."""
    places, values = (np.concatenate(parts, axis=-1) for parts in zip(*samples, strict=True))
    order = np.argsort(places, kind="stable")
    return places[order], values[:, order]


def _jumps(functions: Functions, places: np.ndarray, values: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return samples that enclose every jump ever more closely, by bisection of the intervals that may contain one."""
    scale = np.maximum(np.abs(values).max(axis=1, keepdims=True), np.finfo(float).tiny)
    change, half = np.abs(np.diff(values)) / scale, NEIGHBOURS // 2
    slope = change / np.diff(places)
    padded = np.pad(slope, ((0, 0), (half, half)), "edge")
    window = np.lib.stride_tricks.sliding_window_view(padded, NEIGHBOURS, axis=1)
    least = functools.reduce(np.minimum, (window[..., k] for k in range(NEIGHBOURS)))
    of, at = np.nonzero((slope > STEEP * least) & (change > ACCURATE))  # few; the median takes longer
    usual = np.median(window[of, at], axis=-1)
    steep = np.zeros(len(places) - 1)
    np.maximum.at(steep, at, np.where(slope[of, at] > STEEP * usual, change[of, at], 0.0))
    at = np.flatnonzero(steep)
    at = at[np.argsort(-steep[at], kind="stable")[:MOST]]
    low, high, below, above = places[at], places[at + 1], values[:, at], values[:, at + 1]
    jumps = []
    for _ in range(ROUNDS):
        middle = 0.5 * (low + high)
        going = (low < middle) & (middle < high) & (np.abs(above - below) > ACCURATE * scale).any(axis=0)
        if not going.any():
            break
        low, high, below, above, middle = low[going], high[going], below[:, going], above[:, going], middle[going]
        between = functions(middle)
        jumps.append((middle, between))
        later = (np.abs(above - between) / scale).sum(axis=0) > (np.abs(between - below) / scale).sum(axis=0)
        low, below = np.where(later, middle, low), np.where(later, between, below)
        high, above = np.where(later, high, middle), np.where(later, above, between)
    return jumps


def _maxima(functions: Functions, places: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return the largest value of each function, refining around every maximum that may be the largest."""
    most: np.ndarray = values.max(axis=1)
    of, x, y = _candidates(places, values)
    share = np.arange(1, INSIDE + 1) / (INSIDE + 1.0)
    for _ in range(ROUNDS):
        fall = y[:, 1] - y.min(axis=1)
        wide = x[:, 2] - x[:, 0] > 4.0 * np.spacing(np.abs(x).max(axis=1))
        going = wide & (fall > ACCURATE * np.abs(most[of])) & (y[:, 1] + fall >= most[of])
        if not going.any():
            break
        of, x, y = of[going], x[going], y[going]
        low, top, high = (x[:, k : k + 1] for k in range(3))
        near_vertex = np.clip(_vertex(x, y)[:, None] + (high - low) * BESIDE * np.arange(-1, 2), low, high)
        more = np.concatenate([low + share * (top - low), top + share * (high - top), near_vertex], axis=1)
        there = functions(more.ravel())[np.repeat(of, more.shape[1]), np.arange(more.size)].reshape(more.shape)
        x, y = np.concatenate([x, more], axis=1), np.concatenate([y, there], axis=1)
        order = np.argsort(x, axis=1, kind="stable")
        x, y = np.take_along_axis(x, order, 1), np.take_along_axis(y, order, 1)
        near = _neighbours(np.argmax(y, axis=1), x.shape[1])
        x, y = np.take_along_axis(x, near, 1), np.take_along_axis(y, near, 1)
        np.maximum.at(most, of, y[:, 1])
    return most


def _vertex(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Return the vertices (b,) of the parabolas through three samples each, places and values (b, 3)."""
    before, after = x[:, 1] - x[:, 0], x[:, 2] - x[:, 1]
    rise, fall = _slope(y[:, 1] - y[:, 0], before), _slope(y[:, 1] - y[:, 2], after)
    bend = rise + fall  # above 0: the middle value is the largest
    vertex: np.ndarray = x[:, 1] + _slope(rise * after - fall * before, 2.0 * bend)
    return vertex


def _slope(rise: np.ndarray, run: np.ndarray) -> np.ndarray:
    """Return `rise` over `run`, or 0 if `run` is 0: a maximum at an end has no neighbour on one side."""
    slope: np.ndarray = np.divide(rise, run, out=np.zeros_like(rise), where=run > 0.0)
    return slope


def _candidates(places: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the candidates for the largest value: function index (b,), places and values (b, 3) around each."""
    step = np.diff(values)
    rises, falls = np.pad(step, ((0, 0), (1, 0))), np.pad(step, ((0, 0), (0, 1)))  # before and behind each sample
    reach = values + np.maximum(rises, -falls)
    of, at = np.nonzero((rises >= 0.0) & (falls <= 0.0) & (reach >= values.max(axis=1, keepdims=True)))
    order = np.lexsort((-values[of, at], of))  # largest first for each function
    order = order[np.arange(len(of)) - np.searchsorted(of, of) < MOST]
    of, at = of[order], at[order]
    near = _neighbours(at, len(places))
    return of, places[near], values[of[:, None], near]


def _neighbours(at: np.ndarray, count: int) -> np.ndarray:
    """Return indices below `count` with their neighbours: (b, 3) from (b,)."""
    return np.stack([np.maximum(at - 1, 0), at, np.minimum(at + 1, count - 1)], axis=-1)
