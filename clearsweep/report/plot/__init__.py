"""Axes that write SVG for the pages of reports, with the subset of matplotlib's methods that the drawings use."""

from .axes import Axes
from .items import UnsupportedError
from .sheet import PolarSheet, Sheet

__all__ = ["Axes", "PolarSheet", "Sheet", "UnsupportedError", "sheet_of"]


def make_sheet(size: tuple[float, float], projection: str | None) -> Sheet:
    """Return a sheet for a projection: None or 'polar'; raise UnsupportedError for others.  size : inches."""
    if projection not in (None, "polar"):
        raise UnsupportedError(str(projection))
    return PolarSheet(size) if projection else Sheet(size)
