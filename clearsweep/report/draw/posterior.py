"""Drawings of identified values: their distribution, and the joint distribution of pairs of keys."""

from typing import TYPE_CHECKING

import numpy as np

from ..data.axis import Axis
from .style import BLUE, set_plain_axes

if TYPE_CHECKING:
    from matplotlib.axes import Axes

BIN_COUNT = 40


def draw_density(
    ax: "Axes", values: np.ndarray, weights: np.ndarray, quantiles: tuple[float, float, float], axis: Axis
) -> None:
    """Draw a histogram of weighted values; quantiles : of the interval, and the median, on `axis`, SI."""
    scale = axis.scale
    ax.hist(scale.from_si(values), BIN_COUNT, weights=weights, color=BLUE, alpha=0.5, density=True)
    for quantile, style in zip(quantiles, ("--", "-", "--"), strict=True):
        ax.axvline(scale.from_si(quantile), color=BLUE, linestyle=style, linewidth=1.0)
    ax.set(xlabel=axis.label(), ylabel="probability density")
    ax.set_yticks([])
    set_plain_axes(ax)


def draw_joint_density(
    ax: "Axes", values_of_keys: tuple[np.ndarray, np.ndarray], weights: np.ndarray, axes: tuple[Axis, Axis]
) -> None:
    """Draw the weighted values of two keys as a grid of shades."""
    x_values, y_values = (axis.scale.from_si(values) for values, axis in zip(values_of_keys, axes, strict=True))
    counts, x_edges, y_edges = np.histogram2d(x_values, y_values, BIN_COUNT // 2, weights=weights)
    ax.pcolormesh(x_edges, y_edges, counts.T, cmap="Blues", rasterized=True)
    ax.set(xlabel=axes[0].label(), ylabel=axes[1].label())
