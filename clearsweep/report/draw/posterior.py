"""Drawings of identified values: their distribution, and the joint distribution of pairs of keys."""

import numpy as np
from matplotlib.axes import Axes

from ..data.axis import Axis
from .style import BLUE, plain_axes

BINS = 40


def density(ax: Axes, values: np.ndarray, weights: np.ndarray, ends: tuple[float, float, float], axis: Axis) -> None:
    """Draw a histogram of weighted values; ends : of the interval, and the median, on `axis`, SI."""
    scale = axis.scale
    ax.hist(scale.of(values), BINS, weights=weights, color=BLUE, alpha=0.5, density=True)
    for end, style in zip(ends, ("--", "-", "--"), strict=True):
        ax.axvline(scale.of(end), color=BLUE, linestyle=style, linewidth=1.0)
    ax.set(xlabel=axis.label(), ylabel="probability density")
    ax.set_yticks([])
    plain_axes(ax)


def pair(ax: Axes, both: tuple[np.ndarray, np.ndarray], weights: np.ndarray, axes: tuple[Axis, Axis]) -> None:
    """Draw the weighted values of two keys as a grid of shades."""
    across, up = (axis.scale.of(values) for values, axis in zip(both, axes, strict=True))
    counts, x, y = np.histogram2d(across, up, BINS // 2, weights=weights)
    ax.pcolormesh(x, y, counts.T, cmap="Blues", rasterized=True)
    ax.set(xlabel=axes[0].label(), ylabel=axes[1].label())
