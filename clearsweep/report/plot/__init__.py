"""Axes that write SVG for the pages of reports, with the methods of matplotlib's that the drawings call."""

from .axes import Axes
from .sheet import Sheet
from .side import UnsupportedError

__all__ = ["Axes", "Sheet", "UnsupportedError"]
