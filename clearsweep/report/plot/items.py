"""What is drawn on axes, and how it looks."""

from typing import Any, NamedTuple

import numpy as np

PAPER = "#ffffff"  # behind all


class Stroke(NamedTuple):
    """How a line is drawn."""

    colour: str
    width: float = 1.5  # points
    dash: str = ""  # lengths of lines and gaps, in widths
    alpha: float = 1.0
    cap: str = "butt"


class Marks(NamedTuple):
    """How points are drawn."""

    shape: str
    colour: str
    size: float  # points
    alpha: float = 1.0
    filled: str = ""  # the colour inside of an open circle
    edge: float = 1.0  # points, of what is a line


class Item(NamedTuple):
    """One thing on the axes, in the numbers of its sides."""

    kind: str  # 'line', 'points', 'area', 'cells', 'ellipse' or 'words'
    x: np.ndarray
    y: np.ndarray
    look: Any
    order: float
    across: bool = False  # whether y is a share of the height, of 'upright' x of the width
    upright: bool = False


class Entry(NamedTuple):
    """One row of a legend."""

    name: str
    stroke: Stroke | None = None
    marks: Marks | None = None
    fill: str = ""


class Words(NamedTuple):
    """How a text is written."""

    text: str
    ha: str
    va: str
    size: float
    colour: str
    weight: str
    halo: dict[str, Any] | None = None  # what is behind: facecolor, alpha, pad (points)


class Spines(dict):
    """The four edges; several are chosen by a list."""

    def __getitem__(self, names: Any) -> Any:
        edges = self

        class Chosen:
            """Edges that are changed together."""

            @staticmethod
            def set_visible(shown: bool) -> None:
                """Show or hide them."""
                edges.update(dict.fromkeys([names] if isinstance(names, str) else names, shown))

        return Chosen


class Box(NamedTuple):
    """The place of axes on a sheet, in points from its upper left corner."""

    left: float
    top: float
    wide: float
    high: float
