"""Global maxima of functions on an interval that can be evaluated anywhere and may jump."""

import functools
from collections.abc import Callable

import numpy as np

ACCURACY = 1e-9  # of the largest value: allowed difference of neighbouring samples at a maximum
MIN_SPACING = 1e-12  # of the interval: of two closer points one is dropped
STEEPNESS = 8.0  # times the median slope of neighbours: a steeper interval may contain a jump
NEIGHBOURS = 7  # intervals in this median
MAX_REFINED = 32  # jumps, and maxima of a function, that are refined
SAMPLES_PER_SIDE = 8  # further samples on each side of a maximum per round
VERTEX_OFFSET = 1e-3  # of its interval: distance of two more samples from the vertex of the parabola
MAX_ROUNDS = 60

Functions = Callable[[np.ndarray], np.ndarray]  # (n,) -> (m, n): m functions at n points


def largest(functions: Functions, points: np.ndarray) -> np.ndarray:
    """Return the largest value (m,) of each function between the ends of `points`; nan if undefined.

    points : (n,) increasing, initial samples; a peak that lies between two of them can be missed.
    """
    points = points[np.append(True, np.diff(points) > MIN_SPACING * np.ptp(points))]
    values = functions(points)
    maxima = np.full(len(values), np.nan)
    defined = np.isfinite(values).all(axis=1)
    if defined.any():

        def defined_functions(x: np.ndarray) -> np.ndarray:
            return functions(x)[defined]

        samples = [(points, values[defined])]
        maxima[defined] = _maxima(defined_functions, *_merged(samples + _jumps(defined_functions, *samples[0])))
    return maxima


def _merged(samples: list[tuple[np.ndarray, np.ndarray]]) -> tuple[np.ndarray, np.ndarray]:
    """Return samples, points (n,) and values (m, n), merged in increasing order."""
    points, values = (np.concatenate(arrays, axis=-1) for arrays in zip(*samples, strict=True))
    order = np.argsort(points, kind="stable")
    return points[order], values[:, order]


def _jumps(functions: Functions, points: np.ndarray, values: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return samples that converge to every jump, by bisection of the intervals that may contain one."""
    scale = np.maximum(np.abs(values).max(axis=1, keepdims=True), np.finfo(float).tiny)
    change, half_width = np.abs(np.diff(values)) / scale, NEIGHBOURS // 2
    slope = change / np.diff(points)
    padded = np.pad(slope, ((0, 0), (half_width, half_width)), "edge")
    window = np.lib.stride_tricks.sliding_window_view(padded, NEIGHBOURS, axis=1)
    smallest = functools.reduce(np.minimum, (window[..., k] for k in range(NEIGHBOURS)))
    rows, columns = np.nonzero((slope > STEEPNESS * smallest) & (change > ACCURACY))  # few; the median takes longer
    median_slope = np.median(window[rows, columns], axis=-1)
    steep = np.zeros(len(points) - 1)
    np.maximum.at(steep, columns, np.where(slope[rows, columns] > STEEPNESS * median_slope, change[rows, columns], 0.0))
    columns = np.flatnonzero(steep)
    columns = columns[np.argsort(-steep[columns], kind="stable")[:MAX_REFINED]]
    low, high, low_value, high_value = points[columns], points[columns + 1], values[:, columns], values[:, columns + 1]
    jumps = []
    for _ in range(MAX_ROUNDS):
        centre = 0.5 * (low + high)
        is_open = (low < centre) & (centre < high) & (np.abs(high_value - low_value) > ACCURACY * scale).any(axis=0)
        if not is_open.any():
            break
        low, high, low_value, high_value, centre = (
            low[is_open],
            high[is_open],
            low_value[:, is_open],
            high_value[:, is_open],
            centre[is_open],
        )
        value_at_centre = functions(centre)
        jumps.append((centre, value_at_centre))
        jump_is_right = (np.abs(high_value - value_at_centre) / scale).sum(axis=0) > (
            np.abs(value_at_centre - low_value) / scale
        ).sum(axis=0)
        low, low_value = np.where(jump_is_right, centre, low), np.where(jump_is_right, value_at_centre, low_value)
        high, high_value = np.where(jump_is_right, high, centre), np.where(jump_is_right, high_value, value_at_centre)
    return jumps


def _maxima(functions: Functions, points: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return the largest value of each function, refining around every maximum that may be the largest."""
    largest_values: np.ndarray = values.max(axis=1)
    rows, x, y = _candidates(points, values)
    fractions = np.arange(1, SAMPLES_PER_SIDE + 1) / (SAMPLES_PER_SIDE + 1.0)
    for _ in range(MAX_ROUNDS):
        drop = y[:, 1] - y.min(axis=1)
        is_wide = x[:, 2] - x[:, 0] > 4.0 * np.spacing(np.abs(x).max(axis=1))
        is_open = is_wide & (drop > ACCURACY * np.abs(largest_values[rows])) & (y[:, 1] + drop >= largest_values[rows])
        if not is_open.any():
            break
        rows, x, y = rows[is_open], x[is_open], y[is_open]
        low, top, high = (x[:, k : k + 1] for k in range(3))
        near_vertex = np.clip(_vertex(x, y)[:, None] + (high - low) * VERTEX_OFFSET * np.arange(-1, 2), low, high)
        new_points = np.concatenate(
            [low + fractions * (top - low), top + fractions * (high - top), near_vertex], axis=1
        )
        new_values = functions(new_points.ravel())[
            np.repeat(rows, new_points.shape[1]), np.arange(new_points.size)
        ].reshape(new_points.shape)
        x, y = np.concatenate([x, new_points], axis=1), np.concatenate([y, new_values], axis=1)
        order = np.argsort(x, axis=1, kind="stable")
        x, y = np.take_along_axis(x, order, 1), np.take_along_axis(y, order, 1)
        neighbours = _neighbours(np.argmax(y, axis=1), x.shape[1])
        x, y = np.take_along_axis(x, neighbours, 1), np.take_along_axis(y, neighbours, 1)
        np.maximum.at(largest_values, rows, y[:, 1])
    return largest_values


def _vertex(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Return the vertices (b,) of the parabolas through three samples each, points and values (b, 3)."""
    left_width, right_width = x[:, 1] - x[:, 0], x[:, 2] - x[:, 1]
    rise, fall = _slope(y[:, 1] - y[:, 0], left_width), _slope(y[:, 1] - y[:, 2], right_width)
    curvature = rise + fall  # above 0: the middle value is the largest
    vertex: np.ndarray = x[:, 1] + _slope(rise * right_width - fall * left_width, 2.0 * curvature)
    return vertex


def _slope(rise: np.ndarray, run: np.ndarray) -> np.ndarray:
    """Return `rise` over `run`, or 0 if `run` is 0: a maximum at an end has no neighbour on one side."""
    slope: np.ndarray = np.divide(rise, run, out=np.zeros_like(rise), where=run > 0.0)
    return slope


def _candidates(points: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the candidates for the largest value: function index (b,), points and values (b, 3) around each."""
    step = np.diff(values)
    rises, falls = np.pad(step, ((0, 0), (1, 0))), np.pad(step, ((0, 0), (0, 1)))  # before and behind each sample
    upper_bound = values + np.maximum(rises, -falls)
    rows, columns = np.nonzero((rises >= 0.0) & (falls <= 0.0) & (upper_bound >= values.max(axis=1, keepdims=True)))
    order = np.lexsort((-values[rows, columns], rows))  # largest first for each function
    order = order[np.arange(len(rows)) - np.searchsorted(rows, rows) < MAX_REFINED]
    rows, columns = rows[order], columns[order]
    neighbours = _neighbours(columns, len(points))
    return rows, points[neighbours], values[rows[:, None], neighbours]


def _neighbours(indices: np.ndarray, count: int) -> np.ndarray:
    """Return indices below `count` with their neighbours: (b, 3) from (b,)."""
    return np.stack([np.maximum(indices - 1, 0), indices, np.minimum(indices + 1, count - 1)], axis=-1)
