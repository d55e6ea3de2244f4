"""Drawings of the answers of `seek`: intervals that contain the limit, over another axis."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..data.axis import Axis
from .style import BLUE, set_plain_axes

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def draw_intervals(ax: "Axes", rows: Sequence[tuple[float, float, float, float]], x_axis: Axis, y_axis: Axis) -> None:
    """Draw answers.

    Each row has the value on the axis `x_axis`, the ends of the interval and the answer on `y_axis`, in SI.
    """
    x, low, high, answer = np.array(rows).T
    x = x_axis.scale.from_si(x)
    low, high, answer = (y_axis.scale.from_si(values) for values in (low, high, answer))
    ax.vlines(x, low, high, color=BLUE, linewidth=2.0)
    ax.plot(x, answer, "o-", color=BLUE, markersize=4.0, linewidth=0.8)
    ax.set(xlabel=x_axis.label(), ylabel=y_axis.label())
    if low.min() > 0.0:
        ax.set_ylim(0.0, 1.1 * high.max())
    set_plain_axes(ax)
