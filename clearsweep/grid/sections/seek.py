"""Reads `seek` and `refine`: a search for the largest or smallest value within limits, and cases along their border."""

import math
from collections.abc import Callable, Mapping
from fractions import Fraction
from typing import Any, NamedTuple

from ...language import quantity
from ...language.errors import quoted
from ..keys.kinds import Number, value_key
from ..library.iso286 import Fit
from ..written.document import WrittenValue
from .fits import read_fit_names
from .reader import Reader, check_always_used
from .section import FITS_SCHEMA, Key, KeySection, NamesKey, QuantityKey, RangeKey, WordKey, cases_key, section_in

SEEK = "seek"
SEEK_DIRECTIONS, SEEK_SCOPES = ("largest", "smallest"), ("each", "all")
MAX_HALVINGS = 40  # of a range: then its width is near the rounding of floats
FIRST_INTERVALS = 4  # of the range, whose ends are tried first
_SEEK_EXAMPLE = "{largest: joints.rod-slider.clearance, between: [5 um, 200 um], within: 1 um}"
_PATH_NOUN = "dotted path"
_AMONG_EXAMPLE = "{fits: [H7/g6, H7/f7]}"
SEEK_SECTION = KeySection(
    SEEK,
    "search for the largest or smallest value of one key for which cases meet `limits`",
    _SEEK_EXAMPLE,
    (
        NamesKey(
            "largest",
            ("path whose largest value is searched for, or several paths with one common value"),
            noun=_PATH_NOUN,
        ),
        NamesKey(
            "smallest",
            "path whose smallest value is searched for, or several paths with one common value",
            noun=_PATH_NOUN,
        ),
        RangeKey(
            "between", "[low, high]: the range of the search", missing="; write the range, such as [5 um, 200 um]"
        ),
        QuantityKey(
            "within",
            "required accuracy of the answer, at most a quarter of the range",
            missing="; write the accuracy of the answer, such as 1 um",
        ),
        Key(
            "among",
            f"{_AMONG_EXAMPLE} replaces `between` and `within`: each fit is tested at its largest clearance",
            FITS_SCHEMA,
        ),
        WordKey(
            "meeting",
            "condition that the cases must meet; `limits` is the only choice",
            words=("limits",),
            default="limits",
        ),
        WordKey(
            "for",
            "`each`: one answer for each case of the other axes (default); `all`: one answer, for the worst case",
            words=SEEK_SCOPES,
            default=SEEK_SCOPES[0],
        ),
    ),
    {
        "anyOf": [{"required": ["between", "within"]}, {"required": ["among"]}],
        "oneOf": [{"required": [direction]} for direction in SEEK_DIRECTIONS],
    },
)


class Seek(NamedTuple):
    """The section `seek`, in SI."""

    direction: str  # one of SEEK_DIRECTIONS
    paths: tuple[str, ...]  # in step: all have the same value
    between: tuple[float, float]
    within: float  # 0 among fits
    is_per_case: bool  # for each case of the other axes; False: for all of them together
    fits: tuple[Fit, ...] = ()  # in order of their largest clearances, which are assessed; () of a range

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
        halvings = max(math.ceil(math.log2((high - low) / self.within)), FIRST_INTERVALS.bit_length() - 1)
        return 1 << halvings

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

    def first(self) -> tuple[float, ...]:
        """Return the values to try first, ascending."""
        if self.fits:
            return tuple(fit.high for fit in self.fits)
        return tuple(
            sorted(self.value(index) for index in range(0, self.last_index + 1, self.last_index // FIRST_INTERVALS))
        )

    def resolved(self) -> dict[str, Any]:
        """Return the section in the form of a grid file, in SI."""
        section: dict[str, Any] = {self.direction: self.path if len(self.paths) == 1 else list(self.paths)}
        if self.fits:
            section["among"] = {"fits": [fit.name for fit in self.fits]}
        else:
            section |= {"between": list(self.between), "within": self.within}
        return section | {"meeting": "limits", "for": SEEK_SCOPES[not self.is_per_case]}


def read_seek_range(
    reader: Reader, root: WrittenValue, values_of: Callable[[str], tuple[float, ...]]
) -> tuple[list[WrittenValue], WrittenValue] | None:
    """Return the searched paths and their values as written, or None if there is nothing to vary.

    `values_of` returns the known values of a path, which determine the sizes of fits.
    """
    section = SEEK_SECTION.find(reader.problems, root)
    if section is None:
        return None
    directions = [direction for direction in SEEK_DIRECTIONS if direction in section.value]
    if len(directions) != 1:
        message = (
            "has both largest and smallest; write one of them" if directions else "is missing; write the path to vary"
        )
        reader.problems.add(section, f"{SEEK}.{SEEK_DIRECTIONS[0]}", f"{message}, such as {_SEEK_EXAMPLE}")
        return None
    paths = SEEK_SECTION.value(reader.problems, section, directions[0])
    if paths is None:
        return None
    if "among" in section.value:
        return _read_fits(reader, section, paths, values_of)
    between = SEEK_SECTION.value(reader.problems, section, "between")
    return None if between is None else (paths, between)


def _read_fits(
    reader: Reader, section: WrittenValue, paths: list[WrittenValue], values_of: Callable[[str], tuple[float, ...]]
) -> tuple[list[WrittenValue], WrittenValue] | None:
    """Return the paths, and the largest clearances of the fits to search, ascending."""
    among = section.value["among"]
    for key in ("between", "within"):
        if key in section.value:
            message = "conflicts with `among`, which lists the values to try; remove one of the two"
            reader.problems.add(section.value[key], f"{SEEK}.{key}", message)
            return None
    content = among.value
    names = content["fits"].value if isinstance(content, dict) and [*content] == ["fits"] else None
    if not isinstance(names, list) or not names:
        reader.problems.add(among, f"{SEEK}.among", f"found {quoted(content)}; expected {_AMONG_EXAMPLE}")
        return None
    fits = read_fit_names(reader, [path.value for path in paths], names, values_of)
    if fits is None:
        return None
    reader.searched_fits = tuple(sorted(fits, key=lambda fit: fit.high))
    position = among.origin, among.line, among.column
    values = [WrittenValue(f"{fit.high!r} m", *position, by_name=True) for fit in reader.searched_fits]
    return paths, WrittenValue(values, among.origin, among.line, among.column)


def read_seek(reader: Reader, root: WrittenValue, limits: Mapping[str, Any]) -> Seek | None:
    """Return the section `seek`, or None if it is missing or wrong; its axis must have been read."""
    section = section_in(root, SEEK)
    paths = tuple(path for path, section_name in reader.varied_by.items() if section_name == SEEK)
    if section is None or not paths or not set(paths) <= reader.axes.keys():
        return None
    path = paths[0]
    entries, problems_before = section.value, len(reader.problems)
    (direction,) = [direction for direction in SEEK_DIRECTIONS if direction in entries]
    low, high = reader.axes[path][0], reader.axes[path][-1]
    for other_path in paths[1:]:
        if _unit_of_path(reader, other_path) != _unit_of_path(reader, path):
            units_text = f"in {_unit_of_path(reader, other_path)}, {path} in {_unit_of_path(reader, path)}"
            reader.problems.add(
                entries[direction],
                f"{SEEK}.{direction}",
                (f"{other_path} is {units_text}; paths that vary together need the same unit"),
            )
    if low >= high and not reader.searched_fits:
        reader.problems.add(entries["between"], f"{SEEK}.between", "the first value is not below the second; swap them")
    if not limits:
        reader.problems.add(section, SEEK, "needs limits that the cases must meet; add the section 'limits'")
    scope = SEEK_SECTION.value(reader.problems, section, "for")
    SEEK_SECTION.value(reader.problems, section, "meeting")  # `limits` is the only word so far
    for other_path in reader.axes:
        check_always_used(reader, entries[direction], SEEK, other_path)
    is_per_case = scope == SEEK_SCOPES[0]
    if reader.searched_fits:
        seek = Seek(direction, paths, (low, high), 0.0, is_per_case, reader.searched_fits)
        return seek if len(reader.problems) == problems_before else None
    tolerance = SEEK_SECTION.value(reader.problems, section, "within", _unit_of_path(reader, path))
    if tolerance is None or len(reader.problems) > problems_before:
        return None
    if not (high - low) / 2.0**MAX_HALVINGS < tolerance <= (high - low) / FIRST_INTERVALS:
        smallest, largest = (
            quantity.written_text(size, _unit_of_path(reader, path))
            for size in ((high - low) / 1e12, (high - low) / 4.0)
        )
        message = f"found {entries['within'].value}; allowed: {smallest} to {largest}, a quarter of the range"
        reader.problems.add(entries["within"], f"{SEEK}.within", message)
        return None
    return Seek(direction, paths, (low, high), tolerance, is_per_case)


def _unit_of_path(reader: Reader, path: str) -> str:
    key = reader.keys_in_use[path]
    assert isinstance(key, Number)  # others cannot be searched for
    exponents = reader.values_of(f"{path.rpartition('.')[0]}.exponent")
    return quantity.replace_exponent(key.fields(reader.names)[0].unit, exponents[0] if exponents else 1.5)


REFINE = "refine"
REFINE_BORDER = "limits"
MAX_CASES = 1_000_000
REFINE_SECTION = KeySection(
    REFINE,
    "further cases between those of `sweep`, along the border of `limits`",
    "{along: limits, cases: 200}",
    (
        WordKey(
            "along",
            "border along which cases are added; `limits` is the only choice",
            words=(REFINE_BORDER,),
            default=REFINE_BORDER,
        ),
        cases_key(1, MAX_CASES),
    ),
)


class Refine(NamedTuple):
    """The section `refine`: the number of cases to add along the border, and the values to subdivide."""

    cases: int  # at most
    paths: tuple[str, ...]  # swept numbers

    def resolved(self) -> dict[str, Any]:
        """Return the section in the form of a grid file."""
        return {"along": REFINE_BORDER, "cases": self.cases}


def read_refine(reader: Reader, root: WrittenValue, limits: Mapping[str, Any]) -> Refine | None:
    """Return the section `refine`, or None if it is missing or wrong; the axes must have been read."""
    problems_before = len(reader.problems)
    section = REFINE_SECTION.find(reader.problems, root)
    if section is None:
        return None
    if SEEK in root.value:
        message = "conflicts with `seek`, which finds the limit automatically; remove one of the two"
        reader.problems.add(section, REFINE, message)
    if not limits:
        reader.problems.add(section, REFINE, "needs limits, whose border it refines; add `limits`")
    paths = tuple(path for path in reader.axes if reader.varied_by[path] == "sweep" and _is_divisible(reader, path))
    if not paths:
        message = "cannot add cases between those of the grid; `sweep` at least one quantity with two or more values"
        reader.problems.add(section, REFINE, message)
    for path in reader.axes:
        check_always_used(reader, section, REFINE, path)
    REFINE_SECTION.value(reader.problems, section, "along")
    cases = REFINE_SECTION.value(reader.problems, section, "cases")
    return None if cases is None or len(reader.problems) > problems_before else Refine(cases, paths)


def _is_divisible(reader: Reader, path: str) -> bool:
    """Return whether an axis can be subdivided."""
    key = value_key(reader.keys_in_use, path)
    is_indivisible = not isinstance(key, Number) or any(key_use.field.integer for key_use in key.uses)
    return not is_indivisible and not path.endswith(".exponent") and len(reader.axes[path]) > 1
