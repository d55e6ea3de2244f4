"""The largest values of functions that can be evaluated anywhere, have ends and may jump."""

import functools
from collections.abc import Callable

import numpy as np

ACCURATE = 1e-9  # of the largest value: how much two neighbouring samples about it may differ
CLOSEST = 1e-12  # of the whole: of two places that are closer one is left out
STEEP = 8.0  # times the median slope of its neighbours: there may be a jump in such an interval
NEIGHBOURS = 7  # intervals of which that median is taken
MOST = 32  # jumps, and maxima of a function, that are looked into
INSIDE = 8  # further samples on either side of a maximum in each round
BESIDE = 1e-3  # of its interval: two more samples are so far from where a parabola has its maximum
ROUNDS = 60

Functions = Callable[[np.ndarray], np.ndarray]  # (n,) -> (m, n): m functions at n places


def largest(functions: Functions, places: np.ndarray) -> np.ndarray:
    """Return the largest value of each function between the ends of `places`: (m,); nan where it is undefined.

    places : (n,) in order, at which to begin; a rise and fall between two of them is missed.
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
    """Return samples, places (n,) and values (m, n), in one row and in order."""
    places, values = (np.concatenate(parts, axis=-1) for parts in zip(*samples, strict=True))
    order = np.argsort(places, kind="stable")
    return places[order], values[:, order]


def _jumps(functions: Functions, places: np.ndarray, values: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return samples ever closer to every jump, on both its sides, by halving the intervals that may hold one."""
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
    """Return the largest value of each function, sampling ever closer about every maximum that may hold it."""
    most: np.ndarray = values.max(axis=1)
    of, x, y = _brackets(places, values)
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
    """Return where the parabolas through three samples each, places and values (b, 3), have their maxima: (b,)."""
    before, after = x[:, 1] - x[:, 0], x[:, 2] - x[:, 1]
    rise, fall = _slope(y[:, 1] - y[:, 0], before), _slope(y[:, 1] - y[:, 2], after)
    bend = rise + fall  # above 0: the middle one is the largest
    vertex: np.ndarray = x[:, 1] + _slope(rise * after - fall * before, 2.0 * bend)
    return vertex


def _slope(rise: np.ndarray, run: np.ndarray) -> np.ndarray:
    """Return `rise` over `run`, 0 where that is 0: a maximum at an end has nothing on its other side."""
    slope: np.ndarray = np.divide(rise, run, out=np.zeros_like(rise), where=run > 0.0)
    return slope


def _brackets(places: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the maxima that may hold the largest value: their function (b,), places and values (b, 3) about each."""
    step = np.diff(values)
    rises, falls = np.pad(step, ((0, 0), (1, 0))), np.pad(step, ((0, 0), (0, 1)))  # before and behind each sample
    reach = values + np.maximum(rises, -falls)
    of, at = np.nonzero((rises >= 0.0) & (falls <= 0.0) & (reach >= values.max(axis=1, keepdims=True)))
    order = np.lexsort((-values[of, at], of))  # of each function the largest first
    order = order[np.arange(len(of)) - np.searchsorted(of, of) < MOST]
    of, at = of[order], at[order]
    near = _neighbours(at, len(places))
    return of, places[near], values[of[:, None], near]


def _neighbours(at: np.ndarray, count: int) -> np.ndarray:
    """Return places in a row of `count` with those next to them: (b, 3) from (b,)."""
    return np.stack([np.maximum(at - 1, 0), at, np.minimum(at + 1, count - 1)], axis=-1)
