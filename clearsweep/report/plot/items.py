"""Items on axes, and their styles."""

from typing import Any, NamedTuple

import numpy as np

PAPER = "#ffffff"  # background


class Stroke(NamedTuple):
    """Style of a line."""

    colour: str
    width: float = 1.5  # points
    dash: str = ""  # lengths of lines and gaps, in widths
    alpha: float = 1.0
    cap: str = "butt"


class MarkerStyle(NamedTuple):
    """Style of points."""

    shape: str
    colour: str
    size: float  # points
    alpha: float = 1.0
    fill_colour: str = ""  # fill colour of an open circle
    edge_width: float = 1.0  # points, for markers drawn as lines


class Item(NamedTuple):
    """One item on the axes, in data coordinates."""

    kind: str  # 'line', 'points', 'area', 'cells', 'ellipse' or 'text'
    x: np.ndarray
    y: np.ndarray
    style: Any
    order: float
    spans_height: bool = False  # y is a share of the height of the axes
    spans_width: bool = False  # x is a share of their width


class LegendEntry(NamedTuple):
    """One row of a legend."""

    name: str
    stroke: Stroke | None = None
    marker_style: MarkerStyle | None = None
    fill_colour: str = ""


class TextStyle(NamedTuple):
    """Style of a text."""

    text: str
    ha: str
    va: str
    size: float
    colour: str
    weight: str
    halo: dict[str, Any] | None = None  # background: facecolor, alpha, pad (points)


class Spines(dict):
    """The four edges; a list selects several."""

    def __getitem__(self, names: Any) -> Any:
        edges = self

        class EdgeSelection:
            """Edges that are changed together."""

            @staticmethod
            def set_visible(visible: bool) -> None:
                """Show or hide the edges."""
                edges.update(dict.fromkeys([names] if isinstance(names, str) else names, visible))

        return EdgeSelection


class Box(NamedTuple):
    """The position of axes on a sheet, in points from its upper left corner."""

    left: float
    top: float
    width: float
    height: float
