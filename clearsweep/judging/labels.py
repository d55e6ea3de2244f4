"""Labels of columns in words: the same in the last lines of a run and on its page."""

import re

from ..contracts.layout import Layout
from ..language import wording
from .verdict import Limit

#: Figure -> its label, where this is not its name in words.
_LABELS = {
    "error_max": "{output} error",
    "film_loss": "film loss",
    "film_thickness_min": "least film",
    "force_peak_ideal": "ideal peak",
    "force_peak_ratio": "load over ideal peak",
    "impacts_per_rev": "impacts per revolution",
    "life_hours": "life",
    "onset_rate_max": "fastest onset",
    "start_up_time": "start-up time",
    "crank_speed_after": "lowest crank speed after the start",
    "crank_speed_max": "highest crank speed",
    "force_peak_start": "force peak until the start-up time",
    "wear_depth_max": "wear depth",
    "wear_rate_max": "wear rate",
}


def label(layout: Layout, name: str) -> str:
    """Return the label of a column, with its joint if there are several; for a user-defined figure, its name."""
    column = next((column for column in layout.columns if column.name == name), None)
    if column is None or not column.figure:
        return re.sub(r"\bum\b", "\u00b5m", name.replace("_", " "))
    words = _LABELS.get(column.figure, column.figure.replace("_", " ")).format(output=layout.output)
    several = column.joint and len(layout.joints) > 1
    return f"{words} ({wording.joint_name(column.joint)})" if several else words


def limit_label(layout: Layout, limit: Limit, unit: str) -> str:
    """Return a limit in words: 'force peak at most 60 kN', 'load peak at most 2 times the ideal peak'."""
    threshold = limit.words(unit)
    if limit.times:
        threshold = threshold.replace(limit.times, f"the {label(layout, limit.times)}")
    return f"{label(layout, limit.column)} {threshold}"


def capital(text: str) -> str:
    """Return a text with a capital first letter."""
    return text[:1].upper() + text[1:]
