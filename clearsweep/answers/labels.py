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


def column_label(layout: Layout, name: str) -> str:
    """Return the label of a column, with its joint if there are several; for a user-defined figure, its name."""
    column = next((column for column in layout.columns if column.name == name), None)
    if column is None or not column.figure:
        return re.sub(r"\bum\b", "\u00b5m", name.replace("_", " "))
    label_text = _LABELS.get(column.figure, column.figure.replace("_", " ")).format(output=layout.output)
    is_joint_named = column.joint and len(layout.joints) > 1
    return f"{label_text} ({wording.joint_name(column.joint)})" if is_joint_named else label_text


def limit_label(layout: Layout, limit: Limit, unit: str) -> str:
    """Return a limit in words: 'force peak at most 60 kN', 'load peak at most 2 times the ideal peak'."""
    bound_text = limit.bound_text(unit)
    if limit.times:
        bound_text = bound_text.replace(limit.times, f"the {column_label(layout, limit.times)}")
    return f"{column_label(layout, limit.column)} {bound_text}"


def capitalise(text: str) -> str:
    """Return a text with a capital first letter."""
    return text[:1].upper() + text[1:]
