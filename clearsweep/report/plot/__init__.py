"""Axes that write SVG: for the pages of reports, and for files, which are made of the same SVG."""

from .axes import Axes
from .items import BLUES, VIRIDIS, ColourScale, multiples_of, round_ticks, split_decades
from .sheet import PolarSheet, Sheet, make_sheet

__all__ = [
    "BLUES",
    "VIRIDIS",
    "Axes",
    "ColourScale",
    "PolarSheet",
    "Sheet",
    "make_sheet",
    "multiples_of",
    "round_ticks",
    "split_decades",
]
