"""`seek`: the largest or smallest value of a key at which cases meet their limits.  Its section and its answers."""

import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import Any, ClassVar, NamedTuple

import numpy as np

from ..contracts.layout import Column
from ..contracts.search import CaseResults, Found, FurtherRuns, Point, Search, SearchTable
from ..grid import Fit, Grid, sections
from ..grid.keys import KeyTable, Number, Word
from ..grid.sections.fits import NAMINGS, read_fit_names
from ..grid.written import MistakeError, WrittenValue
from ..language import quantity
from ..language.errors import quoted
from . import seeking
from .seeking import unit_of_path

SEEK = "seek"
SEEK_DIRECTIONS, SEEK_SCOPES = ("largest", "smallest"), ("each", "all")
MAX_HALVINGS = 40  # of a range: then its width is near the rounding of floats
_SEEK_EXAMPLE = "{largest: joints.rod-slider.clearance, between: [5 um, 200 um], within: 1 um}"
_PATH_NOUN = "dotted path"
_AMONG_EXAMPLE, _GROUPS_EXAMPLE = "{fits: [H7/g6, H7/f7]}", "{groups: [CN, C3]}"
_SCOPE_TEXT = "`each`: one answer for each case of the other axes (default); `all`: one answer, for the worst case"
_AMONG_TEXT = (
    f"{_AMONG_EXAMPLE} replaces `between` and `within`: each fit is tested at its largest clearance; "
    f"{_GROUPS_EXAMPLE} of rolling bearings"
)
SEEK_SECTION = sections.KeySection(
    SEEK,
    "search for the largest or smallest value of one key for which cases meet `limits`",
    _SEEK_EXAMPLE,
    (
        sections.NamesKey(
            "largest",
            "path whose largest value is searched for, or several paths with one common value",
            noun=_PATH_NOUN,
        ),
        sections.NamesKey(
            "smallest",
            "path whose smallest value is searched for, or several paths with one common value",
            noun=_PATH_NOUN,
        ),
        sections.RangeKey(
            "between", "[low, high]: the range of the search", missing="; write the range, such as [5 um, 200 um]"
        ),
        sections.QuantityKey(
            "within",
            "required accuracy of the answer, at most a quarter of the range",
            missing="; write the accuracy of the answer, such as 1 um",
        ),
        sections.Key("among", _AMONG_TEXT, {"anyOf": sections.AXES_OF_NAMES}),
        sections.WordKey(
            "meeting",
            "condition that the cases must meet; `limits` is the only choice",
            words=("limits",),
            default="limits",
        ),
        sections.WordKey("for", _SCOPE_TEXT, words=SEEK_SCOPES, default=SEEK_SCOPES[0]),
    ),
    {
        "anyOf": [{"required": ["between", "within"]}, {"required": ["among"]}],
        "oneOf": [{"required": [direction]} for direction in SEEK_DIRECTIONS],
    },
)


class Answer(NamedTuple):
    """Answer for one case of the other axes, or for the worst of them, in SI."""

    point: Point
    value: float | None  # last safe value; None: no value is safe
    low: float | None
    high: float | None
    limiting: str | None  # column of the first exceeded limit, or the status of a failed case
    probes: int
    fits: bool = False  # the search was among fits
    fit: str | None = None  # the fit at `value`
    beyond: tuple[str, ...] = ()  # fits beyond the border that nevertheless meet the limits
    best: tuple[dict[str, Any], ...] = ()  # if no value meets the limits: how near each case comes


_VALUE_TEXT = "the answer: this value and all tried values on its safe side meet the limits; null: none does"
_LIMITING_TEXT = (
    "column whose limit is exceeded first beyond the answer, or the status of a failed case there; null: none"
)


@dataclass(frozen=True)
class SeekFound(Found):
    """The answers of a finished search."""

    seek: "Seek"
    answers: tuple[Answer, ...]
    effects: tuple[seeking.Effect, ...] = ()  # effects of other keys on the margin, if an answer is missing

    @property
    def best(self) -> list[dict[str, Any]]:
        """Return how near each case comes to the limits, of the searches without an answer."""
        return [case for answer in self.answers for case in answer.best]

    def table(self, axes: Sequence[Column], units: Mapping[str, str]) -> SearchTable | None:
        """Return a row for each answer."""
        answers, paths = self.answers, self.seek.paths
        unit = next(axis.unit for axis in axes if axis.name == paths[0])
        columns = [axis._replace(description="swept value") for axis in axes if axis.name not in paths]
        values = [[answer.point[column.name] for answer in answers] for column in columns]
        columns += [Column(f"seek.{path}", unit, _VALUE_TEXT) for path in paths]
        values += [[answer.value for answer in answers]] * len(paths)
        if self.seek.fits:
            columns += [
                Column("seek_fit", "", "the answer as a fit, assessed at its largest clearance", "text"),
                Column("seek_beyond", "", "fits beyond the border that meet the limits", "text"),
            ]
            values += [[answer.fit for answer in answers], [", ".join(answer.beyond) or None for answer in answers]]
        columns += [
            Column("seek_low", unit, "lower end of the interval that contains the border"),
            Column("seek_high", unit, "upper end of the interval that contains the border"),
            Column("limiting", "", _LIMITING_TEXT, "text"),
            Column("probes", "1", "cases that the search used", "int"),
        ]
        values += [[getattr(answer, name) for answer in answers] for name in ("low", "high", "limiting", "probes")]
        return SearchTable(columns, values)

    def further(self, grid: Any, record: Mapping[str, Any], runs: FurtherRuns) -> tuple[Found, dict[str, Any]]:
        """Return the answers with the effects of other keys, and what is nearest to the limits, if one is missing."""
        if not self.best:
            return self, {}
        with_effects = replace(self, effects=tuple(seeking.effects(grid, self.best, runs)))
        return with_effects, {"nearest": with_effects._remedies(runs.catalogue, record)}

    def facts(self, catalogue: Any, record: Mapping[str, Any], judged: Any) -> dict[str, Any]:
        """Return the answers, and the remedies where one is missing."""
        remedies = self._remedies(catalogue, record)
        nearest_cases = iter(remedies.pop("best"))
        answers = [
            answer._asdict() | {"best": [*itertools.islice(nearest_cases, len(answer.best))]} for answer in self.answers
        ]
        asked = self.seek.resolved() | {"unit": record["units"][self.seek.path]}
        return {"asked": asked, "answers": answers} | remedies

    def _remedies(self, catalogue: Any, record: Mapping[str, Any]) -> dict[str, Any]:
        return seeking.unanswered_facts(record, self.best, self.effects, catalogue)


@dataclass(frozen=True)
class Seek(Search):
    """The section `seek`, in SI."""

    name: ClassVar[str] = SEEK
    keys: ClassVar[sections.KeySection] = SEEK_SECTION
    example: ClassVar[str] = (
        "seek: {largest: joints.rod-slider.clearance, between: [5 um, 200 um], within: 2 um, for: all}"
    )
    in_step: ClassVar[bool] = True
    answer_key: ClassVar[str] = SEEK
    refusal_of_shards: ClassVar[str] = (
        "the probes of `seek` depend on one another; divide the values of the other axes instead"
    )
    direction: str  # one of SEEK_DIRECTIONS
    paths: tuple[str, ...]  # in step: all have the same value
    between: tuple[float, float]
    within: float  # 0 among fits
    is_per_case: bool  # for each case of the other axes; False: for all of them together
    fits: tuple[Fit, ...] = ()  # in order of their largest clearances, which are assessed; () of a range
    among: Mapping[str, Any] = field(default_factory=dict)  # the section that names them

    @property
    def varied_paths(self) -> tuple[str, ...]:
        """Return the searched paths."""
        return self.paths

    @property
    def path(self) -> str:
        """Return the first path; all other paths have the same value."""
        return self.paths[0]

    @property
    def last_index(self) -> int:
        """Return the last index: the number of fits minus 1, or of equal steps of at most `within`, a power of 2."""
        if self.fits:
            return len(self.fits) - 1
        low, high = self.between
        return 1 << max(math.ceil(math.log2((high - low) / self.within)), seeking.SCAN_INTERVALS.bit_length() - 1)

    def value(self, index: int) -> float:
        """Return the value at an index from 0 to `last_index`, counted from the safer end."""
        if self.fits:
            return self.fit(index).high
        low, high = (Fraction(limit) for limit in self.between)
        k = index if self.direction == SEEK_DIRECTIONS[0] else self.last_index - index
        return float(low + (high - low) * k / self.last_index)

    def fit(self, index: int) -> Fit:
        """Return the fit at an index."""
        return self.fits[index if self.direction == SEEK_DIRECTIONS[0] else self.last_index - index]

    def first_values(self) -> tuple[float, ...]:
        """Return the values to try first, ascending."""
        if self.fits:
            return tuple(fit.high for fit in self.fits)
        return tuple(sorted(self.value(index) for index in seeking.scan_indices(self.last_index)))

    def first(self) -> dict[str, tuple[float, ...]]:
        """Return the values to try first by path."""
        return dict.fromkeys(self.paths, self.first_values())

    def labels(self) -> dict[str, dict[str, float]]:
        """Return the names of the fits as labels of their largest clearances."""
        names = {fit.name: fit.high for fit in self.fits}
        return dict.fromkeys(self.paths, names) if self.fits else {}

    def resolved(self) -> dict[str, Any]:
        """Return the section in the form of a grid file, in SI."""
        section: dict[str, Any] = {self.direction: self.path if len(self.paths) == 1 else list(self.paths)}
        if self.fits:
            section["among"] = dict(self.among)
        else:
            section |= {"between": list(self.between), "within": self.within}
        return section | {"meeting": "limits", "for": SEEK_SCOPES[not self.is_per_case]}

    @classmethod
    def axis_path(cls, path: str) -> str:
        """Return the key with the values of the paths."""
        return f"{SEEK}.between"

    @classmethod
    def late_axes(
        cls, reader: sections.Reader, root: WrittenValue, keys: KeyTable, values_of: Callable[[str], tuple[float, ...]]
    ) -> dict[str, tuple[WrittenValue, WrittenValue]]:
        """Return the paths, each with the ends of the range or all values to try; report those that have no range."""
        axes: dict[str, tuple[WrittenValue, WrittenValue]] = {}
        section = SEEK_SECTION.find(reader.problems, root)
        if section is None:
            return axes
        directions = [direction for direction in SEEK_DIRECTIONS if direction in section.value]
        if len(directions) != 1:
            message = "has both largest and smallest; write one of them"
            message = message if directions else "is missing; write the path to vary"
            raise MistakeError(section, f"{SEEK}.{SEEK_DIRECTIONS[0]}", f"{message}, such as {_SEEK_EXAMPLE}")
        paths = SEEK_SECTION.value(reader.problems, section, directions[0]) or []
        values: WrittenValue | None = None
        if "among" in section.value and paths:
            values = _read_fits(reader, section, [path.value for path in paths], values_of)
        elif paths:
            values = SEEK_SECTION.value(reader.problems, section, "between")
        if values is None:
            return axes
        for written_path in paths:
            path, key = written_path.value, keys.get(written_path.value)
            if isinstance(key, Word) or (isinstance(key, Number) and any(use.field.integer for use in key.uses)):
                noun = "a name" if isinstance(key, Word) else "a whole number"
                reason = f"is {noun}, which has no values in between; write it under `sweep`"
            elif path.endswith(".exponent"):
                reason = "cannot be searched for, because units of other keys depend on it"
            else:
                axes[path] = written_path, values
                continue
            reader.problems.add(written_path, SEEK, f"{path} {reason}")
        return axes

    @classmethod
    def read(cls, reader: sections.Reader, root: WrittenValue) -> "Seek | None":
        """Return the section `seek`, or None if it is missing or wrong."""
        section = root.value.get(SEEK)
        paths = tuple(path for path, section_name in reader.varied_by.items() if section_name == SEEK)
        if section is None or not paths or not set(paths) <= reader.axes.keys():
            return None
        path = paths[0]
        fits = reader.choices.get(path, ())
        entries, problems_before = section.value, len(reader.problems)
        (direction,) = [direction for direction in SEEK_DIRECTIONS if direction in entries]
        low, high = reader.axes[path][0], reader.axes[path][-1]
        for other_path in paths[1:]:
            if unit_of_path(reader, other_path) != unit_of_path(reader, path):
                units_text = f"in {unit_of_path(reader, other_path)}, {path} in {unit_of_path(reader, path)}"
                message = f"{other_path} is {units_text}; paths that vary together need the same unit"
                reader.problems.add(entries[direction], f"{SEEK}.{direction}", message)
        if low >= high and not fits:
            reader.problems.add(
                entries["between"], f"{SEEK}.between", "the first value is not below the second; swap them"
            )
        if not reader.limits:
            reader.problems.add(section, SEEK, "needs limits that the cases must meet; add the section 'limits'")
        scope = SEEK_SECTION.value(reader.problems, section, "for")
        SEEK_SECTION.value(reader.problems, section, "meeting")  # `limits` is the only word so far
        for other_path in reader.axes:
            sections.check_always_used(reader, entries[direction], SEEK, other_path)
        is_per_case = scope == SEEK_SCOPES[0]
        if fits:
            names = [fit.name for fit in fits]
            words = [naming.words for naming in NAMINGS.values()]
            among = {key: names if key in words else item.value for key, item in entries["among"].value.items()}
            seek = Seek(direction, paths, (low, high), 0.0, is_per_case, fits, among)
            return seek if len(reader.problems) == problems_before else None
        tolerance = SEEK_SECTION.value(reader.problems, section, "within", unit_of_path(reader, path))
        if tolerance is None or len(reader.problems) > problems_before:
            return None
        if not (high - low) / 2.0**MAX_HALVINGS < tolerance <= (high - low) / seeking.SCAN_INTERVALS:
            smallest, largest = (
                quantity.written_text(size, unit_of_path(reader, path))
                for size in ((high - low) / 1e12, (high - low) / 4.0)
            )
            message = f"found {entries['within'].value}; allowed: {smallest} to {largest}, a quarter of the range"
            reader.problems.add(entries["within"], f"{SEEK}.within", message)
            return None
        return Seek(direction, paths, (low, high), tolerance, is_per_case)

    def expected_cases(self, grid: Any) -> tuple[int, float]:
        """Return how many cases the search adds if the border is sharp; among fits none."""
        if self.fits:
            return 0, 0.0
        factor = seeking.expected_probe_count(self.last_index) / len(self.first_values())
        return round(len(grid) * max(factor - 1.0, 0.0)), 0.0

    def expectation(self, added: int) -> str:
        """Return a sentence on the cases that it will add."""
        return f"time and storage include about {added:,} cases that `seek` adds to these" if added else ""

    def further_cases(self, grid: Any) -> int:
        """Return how many cases show which other keys help, at most."""
        return seeking.most_cases(grid)

    def begin(self, grid: Any, simulator: Any) -> "SeekRounds":
        """Return the search at work."""
        return SeekRounds(grid, self)

    @classmethod
    def missing_answer(cls, answer: Mapping[str, Any]) -> str:
        """Return how many searches have no answer."""
        rows = answer["search"]
        unanswered = sum(all(value is None for name, value in row.items() if name.startswith("seek.")) for row in rows)
        return f"`seek` has no answer for {unanswered} of {len(rows)} searches" if unanswered or not rows else ""

    @classmethod
    def table_columns(cls, record: Mapping[str, Any]) -> set[str]:
        """Return the columns of seek.parquet."""
        section = record.get(SEEK) or {}
        searched = section.get("largest") or section.get("smallest") or []
        searched = searched if isinstance(searched, list) else [searched]
        names = {*record["units"], "seek_low", "seek_high", "limiting", "probes"} - {*searched}
        fits = {"seek_fit", "seek_beyond"} if "among" in section else set()
        return names | {f"seek.{path}" for path in searched} | fits


def _read_fits(
    reader: sections.Reader, section: WrittenValue, paths: list[str], values_of: Callable[[str], tuple[float, ...]]
) -> WrittenValue:
    """Return the largest clearances of the fits to search, ascending; `values_of` returns known values of a path."""
    among: WrittenValue = section.value["among"]
    for key in ("between", "within"):
        if key in section.value:
            message = "conflicts with `among`, which lists the values to try; remove one of the two"
            raise MistakeError(section.value[key], f"{SEEK}.{key}", message)
    if not isinstance(among.value, dict):
        message = f"found {quoted(among.value)}; expected {_AMONG_EXAMPLE} or {_GROUPS_EXAMPLE}"
        raise MistakeError(among, f"{SEEK}.among", message)
    ascending = tuple(sorted(read_fit_names(reader, paths, among, values_of), key=lambda fit: fit.high))
    reader.choices |= dict.fromkeys(paths, ascending)
    position = among.origin, among.line, among.column
    return among.with_value([WrittenValue(f"{fit.high!r} m", *position, by_name=True) for fit in ascending])


class _Probe(NamedTuple):
    is_good: bool
    margin: float  # margin to the limits; minus infinity for a failed case
    limiting: str | None
    margins: Mapping[str, float]  # by limited column


class SeekRounds:
    """One search, round by round."""

    def __init__(self, grid: Grid, seek: Seek):
        self.seek = seek
        points = (grid.point(index) for index in range(len(grid)))
        others = (tuple((path, value) for path, value in point.items() if path not in seek.paths) for point in points)
        self.other_points = [dict(point) for point in dict.fromkeys(others)]  # combinations of the other axes
        self.index_of = {tuple(point.values()): j for j, point in enumerate(self.other_points)}
        subjects = range(len(self.other_points))
        self.subjects = [(j,) for j in subjects] if self.seek.is_per_case else [tuple(subjects)]
        self.probes: list[dict[int, _Probe]] = [{} for _ in self.other_points]  # for each: index -> probe
        last = self.seek.last_index
        indices = range(last + 1) if self.seek.fits else seeking.scan_indices(last)
        self.indices = {self.seek.value(index): index for index in indices}  # value -> index

    def record(self, grid: Grid, first_index: int, results: CaseResults) -> None:
        """Record how the cases of a grid, from the index `first_index` on, compare to its limits."""
        for index in range(first_index, len(grid)):
            point = grid.point(index)
            value_index = self.indices[[point.pop(path) for path in self.seek.paths].pop()]
            self.probes[self.index_of[tuple(point.values())]][value_index] = _probe(results, index - first_index)

    def ask(self) -> list[Point]:
        """Return the points of the next cases."""
        probes = [  # all fits are tried at once
            (j, index)
            for subject in (() if self.seek.fits else self.subjects)
            for index in seeking.search(self._outcomes(subject), self.seek.last_index).probes
            for j in subject
        ]
        return [self._point(*probe) for probe in dict.fromkeys(probes)]

    def result(self) -> SeekFound:
        """Return the answers: one for each case of the other axes, or one for all."""
        return SeekFound(self.seek, tuple(self._answer(subject) for subject in self.subjects))

    def _outcomes(self, subject: tuple[int, ...]) -> dict[int, bool]:
        """Return index -> whether all cases there meet their limits."""
        return {index: all(self.probes[j][index].is_good for j in subject) for index in self.probes[subject[0]]}

    def _point(self, j: int, index: int) -> Point:
        value = self.seek.value(index)
        self.indices[value] = index
        return self.other_points[j] | dict.fromkeys(self.seek.paths, value)

    def _answer(self, subject: tuple[int, ...]) -> Answer:
        """Return the answer from the probes of some cases of the other axes."""
        outcomes, seek = self._outcomes(subject), self.seek
        border = (
            seeking.border_of_all(outcomes, seek.last_index)
            if seek.fits
            else seeking.search(outcomes, seek.last_index).border
        )
        assert border is not None  # the search is finished
        deciding = seeking.deciding_index(outcomes, border, seek.last_index)
        worst = min(subject, key=lambda j: (self.probes[j][deciding].margin, j))
        limiting = None if outcomes[deciding] else self.probes[worst][deciding].limiting
        point = self.other_points[worst]
        if border.last_good is None:
            nearest = max(outcomes, key=lambda index: (min(self.probes[j][index].margin for j in subject), -index))
            best = tuple(self._best(j, nearest) for j in subject)
            probe_count = len(outcomes) * len(subject)
            return Answer(point, None, None, None, limiting, probe_count, fits=bool(seek.fits), best=best)
        last_good = seek.value(border.last_good)
        first_bad = seek.value(seek.last_index if border.first_bad is None else border.first_bad)
        answer = Answer(
            point,
            last_good,
            min(last_good, first_bad),
            max(last_good, first_bad),
            limiting,
            len(outcomes) * len(subject),
        )
        if not seek.fits:
            return answer
        passing_beyond = tuple(
            seek.fit(index).name for index in sorted(outcomes) if outcomes[index] and index > border.last_good
        )
        return answer._replace(fits=True, fit=seek.fit(border.last_good).name, beyond=passing_beyond)

    def _best(self, j: int, index: int) -> dict[str, Any]:
        """Return the best margin for one combination of the other axes, and the limiting column there."""
        probe = self.probes[j][index]
        finite = np.isfinite(probe.margin)
        return {
            "point": self.other_points[j],
            "value": self.seek.value(index),
            "fit": self.seek.fit(index).name if self.seek.fits else None,
            "margin": probe.margin if finite else None,
            "limiting": probe.limiting,
            "margins": {name: margin for name, margin in probe.margins.items() if np.isfinite(margin)},
        }


def _probe(results: CaseResults, index: int) -> _Probe:
    """Return the probe of the case at an index of a grid."""
    status = results.status[index]
    if status != "ok":
        return _Probe(is_good=False, margin=-np.inf, limiting=status, margins={})
    margins = {name: values[index] for name, values in results.margins.items()}
    unmet = [name for name in results.unmet[index].split(",") if name]
    worst = min(unmet, key=lambda name: np.nan_to_num(margins[name], nan=-np.inf), default=None)
    finite = [margin for margin in margins.values() if not np.isnan(margin)]
    return _Probe(is_good=not unmet, margin=float(min(finite, default=np.inf)), limiting=worst, margins=margins)
