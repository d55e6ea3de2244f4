"""Where and how the figures of a page are written; apart from `paper`, which loads all of matplotlib."""

from pathlib import Path
from typing import NamedTuple


class FigureOptions(NamedTuple):
    """Directory, format and width of the figures."""

    directory: Path
    form: str = "svg"  # one of `paper.FORMS`
    width: str = "auto"  # one of `paper.WIDTHS`; auto: COLUMN or PAGE, by the size on the page
