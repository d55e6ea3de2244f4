"""Names, values, limits and lives of a run in words: the same on the terminal, on the page and in answer.json."""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from ..contracts.layout import Layout
from ..language import wording
from .ranking import column_texts
from .verdict import Limit, column_label, limit_label, limits_and_figures_of, units_of

MIN_DIGITS, MAX_DIGITS = 4, 16  # significant digits of a varied value: as few as distinguish the values of its axis
MAX_LINES, MAX_LENGTH = 6, 160  # of an answer, and characters of a line
PERCENT = f"{wording.BLANK}%"
MAX_NAMED_AXES = 4  # varied values of a case above which a sentence has its id instead

Answer = Mapping[str, Any]


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
        fits = (self.record.get("fits") or {}).get(path)
        return wording.name_with_fits(name, [fit["name"] for fit in fits or ()])

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
        named = [(self.axis_name(path), self.value(path, value)) for path, value in values.items()]
        return ", ".join(f"{name} {text}{joints}" for name, joints, text in wording.of_joints(named))

    def design(self, design: Mapping[str, Any]) -> str:
        """Return the values of a design in words, after its name in the table of cases if it has one."""
        names = (texts[0] for texts in design.get("labels", {}).values() if len(texts) == 1)
        return ", ".join(filter(None, (next(names, ""), self.setting(design["values"]))))

    def axes(self, paths: Sequence[str]) -> list[str]:
        """Return the names of varied paths; joints in which the same quantity varies share one."""
        named = [(self.axis_name(path), None) for path in paths]
        return [f"{name}{joints}" for name, joints, _ in wording.of_joints(named)]

    def figure(self, column: str) -> str:
        """Return the label of a column."""
        return column_label(self.layout, column)

    def figures(self, column: str, numbers: Sequence[float]) -> list[str]:
        """Return values of a column in words, in one unit."""
        known = self._values_of(column).astype(float)
        return column_texts(column, self.units.get(column, "1"), known, numbers)

    def is_zero(self, column: str) -> bool:
        """Return whether no finished case has another value than 0 in a column."""
        return not np.nan_to_num(self._values_of(column).astype(float)).any()

    def limit(self, limit: Limit) -> str:
        """Return a limit in words: 'force peak at most 60 kN'."""
        return limit_label(self.layout, limit, self.units.get(limit.column, "1"))

    def limits_text(self) -> tuple[str, str]:
        """Return 'the limits' and ': force peak at most 60 kN', or 'all 3 limits' and '' if there are more than two."""
        texts = [self.limit(limit) for limit in self.limits]
        return (
            ("the limits", f": {wording.sentence_list(texts)}") if len(texts) <= 2 else (f"all {len(texts)} limits", "")
        )

    def margin(self, entry: Mapping[str, Any]) -> str:
        """Return a margin or an excess of a design in words: 'margin 12 %', '1.4 times the limit of force peak'."""
        margin, excess, column = entry["margin"], entry["excess"], entry["limit"]
        if margin is not None:
            return margin_text(margin, [limit for limit in self.limits if limit.column == column], self.figure(column))
        if excess is not None:
            (text,) = self.figures(column, [excess])
            return f"{self.figure(column)} {text} beyond the limit of 0"
        return f"{self.figure(column)} beyond its limit" if column else ""


def listed(items: Sequence[str], max_length: int, more: str = "{} more") -> str:
    """Return as many items as fit into `max_length` characters, and how many more there are if `more` says so."""
    for count in range(len(items), 0, -1):
        rest = "; " + more.format(len(items) - count) if more and count < len(items) else ""
        text = "; ".join(items[:count]) + rest
        if len(text) <= max_length or count == 1:
            return text
    return ""


def every_text(answer: Answer, words: Words) -> str:
    """Return ' at every crank speed, in every draw and under every contact law', or ''."""
    paths = {
        role: [path for path, of_path in answer["roles"].items() if of_path == role]
        for role in ("condition", "uncertainty", "model")
    }
    drawn = (words.record.get("sample") or {}).get("drawn", {}).keys() & {*paths["uncertainty"]}
    conditions = words.axes([*paths["condition"], *(path for path in paths["uncertainty"] if path not in drawn)])
    models = words.axes(paths["model"])
    parts = [f"at every {wording.sentence_list(conditions)}"] if conditions else []
    parts += ["in every draw"] if drawn else []
    parts += [f"under every {wording.sentence_list(models)}"] if models else []
    return f" {wording.sentence_list(parts)}" if parts else ""


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


Rule = Callable[[Answer, Words], Iterable[str]]


LARGE_MARGIN = 10.0  # from which a margin is a multiple of the limit, not per cent of it


def margin_text(margin: float, limits: Sequence[Limit], name: str = "") -> str:
    """Return a margin in words: in per cent where it is met, as a multiple of the limit where large or exceeded.

    limits : those of the column that decides; name : of the column, or ''
    """
    if margin >= LARGE_MARGIN:
        return f"margin {wording.number_text(margin)} times the limit"
    if margin >= 0.0:
        return f"margin {wording.short_number_text(100.0 * margin, 3)}{wording.BLANK}%"
    of_name = f" of {name}" if name else ""
    kinds = {limit.kind for limit in limits if limit.value}  # a limit of 0 has no margin
    if len(kinds) == 1 and all(limit.value >= 0.0 for limit in limits):
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
    while digits < MAX_DIGITS:
        texts = (varied_text(path, value, unit, written_units, digits) for value in values)
        if all(text != following for text, following in pairwise(texts)):  # they rise, so equals are neighbours
            break
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


# Fits of joints: what a verdict at their mean clearances leaves open.

MAX_LISTED = 4  # fits in one sentence


def is_group(fit: Mapping[str, Any]) -> bool:
    """Return whether the recorded fit of a clearance is a group of a rolling bearing."""
    return "/" not in fit["name"]


def coverage_text(record: Mapping[str, Any], answer: Mapping[str, Any]) -> str:
    """Return which fits meet the limits up to the end of their tolerance; '' without fits or limits.

    With fits in one joint, the end of a tolerance towards the limit is covered if a larger (smaller) clearance that was
    run meets the limits and the verdict changes once.  Pairs of fits are judged at their mean clearances alone.
    """
    drawn = (record.get("sample") or {}).get("drawn", {})
    paths = [path for path in record.get("fits") or {} if answer["roles"].get(path) and path not in drawn]
    if not paths or not answer["designs"]:
        return ""
    if len(paths) > 1 or any(set(design["values"]) != set(paths) for design in answer["designs"]):
        nouns = {("Groups" if is_group(record["fits"][path][0]) else "Fits") for path in paths}
        return (
            f"{wording.sentence_list(sorted(nouns))} are judged at their mean clearances; add the ends of their "
            "tolerances to check the whole range."
        )
    (path,) = paths
    noun = "group" if is_group(record["fits"][path][0]) else "fit"
    fits = {fit["name"]: fit for fit in record["fits"][path]}
    clearance_of = {name: fit["mean"] for name, fit in fits.items()}
    named = [(design["values"][path], design["verdict"]) for design in answer["designs"]]
    verdicts = sorted((clearance_of.get(value, value), verdict == "meets") for value, verdict in named)
    covered = [
        name for name, verdict in named if name in fits and verdict == "meets" and _is_covered(fits[name], verdicts)
    ]
    open_fits = [name for name, verdict in named if name in fits and verdict == "meets" and name not in covered]
    end = "from the smallest clearance of its tolerance on" if _fails_below(verdicts) else "up to the largest clearance"
    parts = [f"{wording.sentence_list(covered[:MAX_LISTED])} {end}"] if covered else []
    parts += [f"{wording.sentence_list(open_fits[:MAX_LISTED])} at the mean clearance only"] if open_fits else []
    return f"Limits met: {'; '.join(parts)}." if parts else f"No {noun} meets the limits at its mean clearance."


def _is_covered(fit: Mapping[str, Any], verdicts: list[tuple[float, bool]]) -> bool:
    """Return whether the clearances that meet the limits enclose the end of a tolerance towards the limit."""
    safe = [clearance for clearance, met in verdicts if met]
    if len(_changes(verdicts)) > 1 or not safe:
        return False
    return bool(fit["low"] >= safe[0] if _fails_below(verdicts) else fit["high"] <= safe[-1])


def _changes(verdicts: list[tuple[float, bool]]) -> list[bool]:
    """Return whether the limits are met just below each clearance at which the verdict changes."""
    return [met for (_, met), (_, met_next) in pairwise(verdicts) if met != met_next]


def _fails_below(verdicts: list[tuple[float, bool]]) -> bool:
    return _changes(verdicts) == [False]


# Texts on a life: hours, with the intervals from numerics and from uncertain wear coefficients.

WEAR_UNCERTAINTY_FACTORS = (3.0, 10.0)  # usual uncertainty of a wear coefficient
FASTER_WEAR = "{:g} to {:g} times".format(*WEAR_UNCERTAINTY_FACTORS)
INTERVAL_DIGITS = (3, 4, 5)  # digits: as few as distinguish the ends of an interval
MIN_RELATIVE_HALF_WIDTH = 1e-5  # of a life: a smaller interval is reported as below this


class Lifetime(NamedTuple):
    """The life of a joint: time and revolutions until its limit, with 95 % intervals; NaN for missing values."""

    hours: float  # h
    revolutions: float  # until the limit, as all following bounds
    revolutions_low: float  # lower bound from the numerical error
    revolutions_high: float  # upper bound; inf or NaN: unbounded
    revolutions_low_with_wear_uncertainty: float = math.nan  # lower bound from the uncertain wear coefficients
    revolutions_high_with_wear_uncertainty: float = math.nan  # upper bound from them


#: Name of a joint's column -> field of Lifetime.
FIELD_BY_COLUMN = {
    "life_hours": "hours",
    "life_revolutions": "revolutions",
    "life_low": "revolutions_low",
    "life_high": "revolutions_high",
    "life_low_uncertain": "revolutions_low_with_wear_uncertainty",
    "life_high_uncertain": "revolutions_high_with_wear_uncertainty",
}


def read_lifetime(columns: Mapping[str, float]) -> Lifetime:
    """Return a life from `columns`, whose names lack the joint; missing columns are NaN."""
    return Lifetime(**{field: columns.get(name, math.nan) for name, field in FIELD_BY_COLUMN.items()})


#: Value of `life.of` -> the condition at which a life ends.
_CRITERIA = {"wear_depth_max": "wear of one body reaches", "clearance_growth": "the clearance has grown by"}


def life_criterion_text(life_section: Mapping[str, Any]) -> str:
    """Return the condition at which a life ends as 'until ...', or ''; life_section : `life` of a grid."""
    if not life_section:
        return ""
    wear_limit = life_section.get("limit")
    limit_text = wording.quantity_text(wear_limit, "m") if isinstance(wear_limit, float) else "its limit"
    return f"until {_CRITERIA[life_section['of']]} {limit_text}"


def hours_text(life: Lifetime) -> str:
    """Return a life in hours."""
    return f"{wording.number_text(life.hours)} h"


def interval_text(life: Lifetime) -> str:
    """Return the 95 % interval of a life that the numerics leave, or '' if it is unknown."""
    if math.isnan(life.revolutions_low):
        return ""
    return f"computing error alone, 95{wording.BLANK}%: {_numerical_interval_text(life)}"


def spread_text(life: Lifetime) -> str:
    """Return what the wear coefficient leaves open: the interval of an uncertain one, or faster wear."""
    ends = life.revolutions_low_with_wear_uncertainty, life.revolutions_high_with_wear_uncertainty
    if any(map(math.isfinite, ends)):
        low, high = (
            _interval_end_text(life, end, INTERVAL_DIGITS[0]) if math.isfinite(end) else "unknown" for end in ends
        )
        return f"With the uncertain wear coefficients: {low} to {high}"
    if not math.isfinite(life.hours):
        return ""
    texts = [wording.number_text(life.hours / factor) for factor in WEAR_UNCERTAINTY_FACTORS]
    hours = f"{' to '.join(texts)}{wording.BLANK}h"  # '159 to 47.8 h'
    return f"With wear {FASTER_WEAR} as fast, the usual uncertainty of its coefficient: {hours}"


def _interval_end_text(life: Lifetime, revolutions: float, digits: int) -> str:
    """Return an end of an interval (revolutions) in hours, rounded to `digits`."""
    return f"{wording.number_text(life.hours * revolutions / life.revolutions, digits)} h"


def _numerical_interval_text(life: Lifetime) -> str:
    """Return the numerical 95 % interval: its ends if five digits distinguish them, else its half-width."""
    if not math.isfinite(life.revolutions_high):
        return f"at least {_interval_end_text(life, life.revolutions_low, INTERVAL_DIGITS[0])}"
    for digits in INTERVAL_DIGITS:
        texts = [
            _interval_end_text(life, revolutions, digits)
            for revolutions in (life.revolutions_low, life.revolutions, life.revolutions_high)
        ]
        if len({*texts}) == len(texts):
            return f"{texts[0]} to {texts[2]}"
    relative_half_width = 0.5 * (life.revolutions_high - life.revolutions_low) / life.revolutions
    if relative_half_width < MIN_RELATIVE_HALF_WIDTH:
        return f"\u00b1 under {wording.number_text(100.0 * MIN_RELATIVE_HALF_WIDTH, 1)}{wording.BLANK}%"
    return f"\u00b1 {wording.number_text(100.0 * relative_half_width, 2)}{wording.BLANK}%"
