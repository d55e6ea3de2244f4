"""Colours and line styles of the pictures of results/measured.md."""

from typing import Any

from matplotlib.axes import Axes

COLOURS = ("#0072B2", "#E69F00", "#009E73", "#CC79A7", "#56B4E9", "#D55E00", "#666666")  # Okabe and Ito 2008
REFERENCE_STYLE: dict[str, Any] = {
    "color": "black",
    "marker": "o",
    "markerfacecolor": "none",
    "linestyle": "",
    "zorder": 3,
}
LINE_STYLES: dict[str, dict[str, Any]] = {
    "reynolds": {"color": COLOURS[0]},
    "finite": {"color": COLOURS[1], "linestyle": "--"},
    "short": {"color": COLOURS[2], "linestyle": ":"},
}


def style_axes(panel: Axes) -> None:
    """Give axes a light grid and no box."""
    panel.grid(color="#dde3e8", linewidth=0.6)
    panel.set_axisbelow(True)
    for side in ("top", "right"):
        panel.spines[side].set_visible(False)
