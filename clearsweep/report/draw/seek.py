"""Drawings of the answers of `seek`: intervals that contain the limit, over another axis."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes

from ..data.axis import Axis
from .style import BLUE, plain_axes


def intervals(ax: Axes, rows: Sequence[tuple[float, float, float, float]], over: Axis, axis: Axis) -> None:
    """Draw answers.

    Each row has the value on the axis `over`, the ends of the interval and the answer on `axis`, in SI.
    """
    x, low, high, answer = np.array(rows).T
    x = over.scale.of(x)
    low, high, answer = (axis.scale.of(each) for each in (low, high, answer))
    ax.vlines(x, low, high, color=BLUE, linewidth=2.0)
    ax.plot(x, answer, "o-", color=BLUE, markersize=4.0, linewidth=0.8)
    ax.set(xlabel=over.label(), ylabel=axis.label())
    if low.min() > 0.0:
        ax.set_ylim(0.0, 1.1 * high.max())
    plain_axes(ax)
