"""Names, values and limits of a run in words: the same on the terminal, on the page and in answer.json."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from ..contracts.layout import Layout
from ..language import wording
from . import labels
from .cases import column_texts
from .verdict import Limit, limits_and_figures_of, units_of

MIN_DIGITS, MAX_DIGITS = 4, 16  # significant digits of a varied value: as few as distinguish the values of its axis
MAX_LINES, MAX_LENGTH = 6, 160  # of an answer, and characters of a line
PERCENT = f"{wording.BLANK}%"
MAX_NAMED_AXES = 4  # varied values of a case above which a sentence has its id instead

Answer = Mapping[str, Any]


class Sentence(NamedTuple):
    """A template and the values that fill it."""

    template: str
    values: Mapping[str, Any] = {}

    @property
    def text(self) -> str:
        """Return the sentence, which begins with a capital letter."""
        return labels.capitalise(self.template.format(**self.values))


class Words:
    """The words of a run's answer."""

    def __init__(self, record: Mapping[str, Any], layout: Layout, values_of: Callable[[str], np.ndarray]):
        """Prepare for a run.

        record : run.json; values_of : returns all values (n,) of a column, SI, which decide its display unit
        """
        self.record, self.layout, self._values_of = record, layout, values_of
        self.units = units_of(record)
        self.path_units: Mapping[str, str] = record.get("units") or {}
        self.written_units = common_units(record)
        self.digits = {path: digits_of(record, path, self.written_units) for path in self.path_units}
        self._joints = number_of_joints(self.path_units)

    @property
    def limits(self) -> tuple[Limit, ...]:
        """Return the limits of the grid."""
        return limits_and_figures_of(self.record).limits

    def axis_name(self, path: str) -> str:
        """Return the name of a varied path."""
        name = wording.axis_name(path, self._joints)
        has_fits = (self.record.get("fits") or {}).get(path)
        return name.replace("clearance", "radial clearance", 1) if has_fits else name

    def value(self, path: str, value: Any) -> str:
        """Return a varied value in words; labels, fits and laws are words already."""
        if value is None or isinstance(value, str):
            return value or wording.DASH
        unit = self.path_units.get(path, "1")
        return varied_text(path, value, unit, self.written_units, self.digits.get(path, MIN_DIGITS))

    def setting(self, values: Mapping[str, Any], case_id: str | None = None) -> str:
        """Return 'crank speed 60 rpm, clearance 0.1 mm', or the case if there are many values."""
        if len(values) > MAX_NAMED_AXES and case_id:
            return f"case {wording.short_id(case_id)}"
        return ", ".join(f"{self.axis_name(path)} {self.value(path, value)}" for path, value in values.items())

    def figure(self, column: str) -> str:
        """Return the label of a column."""
        return labels.column_label(self.layout, column)

    def figures(self, column: str, numbers: Sequence[float]) -> list[str]:
        """Return values of a column in words, in one unit."""
        known = self._values_of(column).astype(float)
        return column_texts(column, self.units.get(column, "1"), known, numbers)

    def limit(self, limit: Limit) -> str:
        """Return a limit in words: 'force peak at most 60 kN'."""
        return labels.limit_label(self.layout, limit, self.units.get(limit.column, "1"))

    def limits_text(self, most: int = 2) -> str:
        """Return the limits in words, or their number if there are more than `most`."""
        texts = [self.limit(limit) for limit in self.limits]
        return wording.sentence_list(texts) if len(texts) <= most else f"{len(texts)} limits"

    def margin(self, entry: Mapping[str, Any]) -> str:
        """Return a margin or an excess of a design in words: 'margin 12 %', '1.4 times the limit of force peak'."""
        margin, excess, column = entry["margin"], entry["excess"], entry["limit"]
        if margin is not None:
            return margin_text(margin, [limit for limit in self.limits if limit.column == column], self.figure(column))
        if excess is not None:
            (text,) = self.figures(column, [excess])
            return f"{self.figure(column)} {text} beyond the limit of 0"
        return f"{self.figure(column)} beyond its limit" if column else ""


def listed(items: Sequence[str], room: int, separator: str = "; ", more: str = "{} more") -> str:
    """Return as many items as fit into `room` characters, and how many more there are if `more` says so."""
    for count in range(len(items), 0, -1):
        rest = separator + more.format(len(items) - count) if more and count < len(items) else ""
        text = separator.join(items[:count]) + rest
        if len(text) <= room or count == 1:
            return text
    return ""


def every_text(answer: Answer, words: Words) -> str:
    """Return ' at every crank speed and under every contact law', or ''."""
    paths = {
        role: [path for path, of_path in answer["roles"].items() if of_path == role]
        for role in ("condition", "uncertainty", "model")
    }
    conditions = [words.axis_name(path) for path in (*paths["condition"], *paths["uncertainty"])]
    models = [words.axis_name(path) for path in paths["model"]]
    parts = [f" at every {wording.sentence_list(conditions)}"] if conditions else []
    parts += [f" under every {wording.sentence_list(models)}"] if models else []
    return " and".join(parts)


def in_brackets(text: str) -> str:
    """Return ' (text)', or '' for no text."""
    return f" ({text})" if text else ""


def from_to(first: str, last: str) -> str:
    """Return 'from 1 to 2 mm' for '1 mm' and '2 mm'."""
    for blank in (wording.BLANK, " "):
        _, _, unit = last.partition(blank)
        if unit and first.endswith(f"{blank}{unit}") and "(" not in last:
            return f"from {first.removesuffix(f'{blank}{unit}')} to {last}"
    return f"from {first} to {last}"


Rule = Callable[[Answer, Words], Iterable[Sentence]]


def margin_text(margin: float, limits: Sequence[Limit], name: str = "") -> str:
    """Return a margin in words: in per cent where it is met, as a multiple of the limit where it is exceeded.

    limits : those of the column that decides; name : of the column, or ''
    """
    if margin >= 0.0:
        return f"margin {wording.short_number_text(100.0 * margin, 3)}{wording.BLANK}%"
    of_name = f" of {name}" if name else ""
    kinds = {limit.kind for limit in limits}
    if len(kinds) == 1 and all(limit.value > 0.0 for limit in limits):
        factor = 1.0 - margin if kinds == {"at_most"} else 1.0 + margin
        return f"{factor_text(factor)} times the limit{of_name}"
    excess = (
        f"{share_text(-margin)} of its size"
        if margin > -1.0
        else f"{wording.short_number_text(-margin, 2)} times its size"
    )
    return f"{name} beyond the limit by {excess}".lstrip()


def case_margin_text(margin: float, limits: Sequence[Limit], exceeded: str) -> str:
    """Return the margin of a case in words for a table; exceeded : columns whose limits it exceeds, comma separated."""
    if np.isfinite(margin):
        of_case = [limit for limit in limits if limit.column in exceeded.split(",")]
        return margin_text(margin, of_case or limits).removeprefix("margin ")
    return "exceeded" if exceeded else wording.DASH


def share_text(share: float) -> str:
    """Return a share in per cent with two digits: '0.52 %', '100 %'; nothing but all is 100 %, but none is 0 %."""
    digits = 2 if share < 0.1 else 0
    text = wording.short_number_text(100.0 * share, 2) if digits else f"{100.0 * share:.0f}"
    return f"{'over 99' if share < 1.0 and text == '100' else text}{PERCENT}"


def factor_text(factor: float) -> str:
    """Return a factor with as few digits as distinguish it from 1."""
    digits = next((digits for digits in range(2, 7) if float(f"{factor:.{digits - 1}e}") != 1.0), 2)
    return wording.number_text(factor, digits)


def number_of_joints(paths: Iterable[str]) -> int:
    """Return the number of joints in dotted paths."""
    return len({path.split(".")[1] for path in paths if path.startswith("joints.")})


def varied_values(record: Mapping[str, Any], path: str) -> list[float]:
    """Return the numbers that a path has on the axes of a grid, from its run.json."""
    labelled = [*((record.get("labels") or {}).get(path) or {}).values()]
    sections = (record.get("sweep"), record.get("zip"), record.get("cases"), (record.get("sample") or {}).get("drawn"))
    values = labelled or next((section[path] for section in sections if section and path in section), [])
    return [value for value in values if isinstance(value, int | float) and not isinstance(value, bool)]


def common_units(record: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    """Return the display unit of each varied path: the unit in the grid, else one that suits the values.

    record : run.json; the result is like its `written_units`
    """
    written = dict(record.get("written_units") or {})
    for path, unit in (record.get("units") or {}).items():
        numbers = varied_values(record, path)
        if path in written or not numbers or unit == "1":
            continue
        scale = wording.scale(unit, numbers, speed=path.endswith("speed"))
        scale = wording.fit_scale() if (record.get("fits") or {}).get(path) else scale
        if scale.unit.replace(wording.BLANK, " ").isascii() or scale.unit.startswith("\u00b5"):
            written[path] = {"unit": scale.unit, "factor": scale.factor, "offset": scale.offset}
    return written


def digits_of(record: Mapping[str, Any], path: str, written_units: Mapping[str, Mapping[str, Any]]) -> int:
    """Return the significant digits that distinguish the values of an axis, at least MIN_DIGITS."""
    if path in ((record.get("sample") or {}).get("drawn") or {}):
        return MIN_DIGITS
    unit, values = (record.get("units") or {}).get(path, "1"), sorted(set(varied_values(record, path)))
    digits = MIN_DIGITS
    while digits < MAX_DIGITS and len(
        {varied_text(path, value, unit, written_units, digits) for value in values}
    ) < len(values):
        digits += 1
    return digits


def varied_text(path: str, value: float, unit: str, written: Mapping[str, Mapping[str, Any]], digits: int) -> str:
    """Return a varied number in the unit that the grid uses; `written` is like `written_units` of run.json."""
    scale = wording.written_scale(written.get(path), unit)
    if scale is None:
        return grid_text(value, unit, speed=path.endswith("speed"), digits=digits)
    name = written[path]["unit"] if path in written and scale == wording.recorded_scale(written[path]) else scale.unit
    return f"{scale.from_si(value):.{digits}g} {name}"


def grid_text(value: float, unit: str, *, speed: bool = False, digits: int = MIN_DIGITS) -> str:
    """Return a value as it could be written in a grid: '0.5 mm', '5000 rpm', '6.61e+10 N/m^1.5'."""
    scale = wording.scale(unit, value, speed=speed)
    scale = scale._replace(unit="deg") if scale.unit == "°" else scale
    if scale.unit.replace(wording.BLANK, " ").isascii() or scale.unit.startswith("µ"):
        return f"{value / scale.factor:.{digits}g} {scale.unit}".rstrip()
    return f"{value:.{digits}g} {unit}"
