"""Axes that write SVG: for the pages of reports, and for files, which are made of the same SVG."""

from .axes import Axes
from .items import BLUES, VIRIDIS, ColourScale, multiples_of, round_ticks, split_decades
from .sheet import Sheet

__all__ = [
    "BLUES",
    "VIRIDIS",
    "Axes",
    "ColourScale",
    "Sheet",
    "multiples_of",
    "round_ticks",
    "split_decades",
]
