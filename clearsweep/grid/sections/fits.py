"""Reads clearances written as ISO 286 fits or as groups of rolling bearings and replaces them by numbers.

A fit is `{fit: H7/f7}` as a value or in a list, `{fits: [H7/g6, H7/f7]}` as an axis, and as a distribution
`{fit: H7/f7}` or `{fit: H7/f7, distribution: normal}`.  A group is written likewise, with the words `group` and
`groups`; next to them, `fit` and `inner_warmer` mount the bearing.  All later readers see clearances in m.
"""

from collections.abc import Callable, Iterable, Mapping
from fractions import Fraction
from typing import Any, NamedTuple

from ...language import quantity
from ...language.errors import InputError, did_you_mean, quoted
from ..keys import Number
from ..keys.library_names import BEARING
from ..library import parse_bearing_name
from ..library.fits import MOUNTING_KEYS, NORMAL_GROUP, BearingSizes, Fit, find_fit, find_group, mounted
from ..written import MistakeError, WrittenValue, placed
from . import Reader
from .axes import FROM_FIT

DISTRIBUTION_FORM = "{fit: H7/f7}, or {fit: H7/f7, distribution: normal}"


class Naming(NamedTuple):
    """How clearances are named: as fits of a pin or as groups of a rolling bearing."""

    word: str  # the key of one
    words: str  # the key of an axis
    example: str
    other_example: str
    size_key: str  # the key of the joint that determines the clearances
    noun: str
    size_noun: str
    extras: tuple[str, ...] = ()  # further keys


#: Field.fit -> naming of its clearances.
NAMINGS = {
    "fit": Naming("fit", "fits", "H7/f7", "H7/g6", "bearing_radius", "a fit of ISO 286", "nominal diameter"),
    "group": Naming("group", "groups", "C3", "CN", "bore", "a group of ISO 5753-1", "bore", (*MOUNTING_KEYS,)),
}


def naming_of(grid_reader: Reader, path: str) -> Naming | None:
    """Return how the clearance at a path is named, or None if it has none."""
    key = grid_reader.keys_in_use.get(path)
    return NAMINGS.get(key.uses[0].field.fit) if isinstance(key, Number) else None


def replace_fits_by_clearances(grid_reader: Reader, values_of: Callable[[str], tuple[float, ...]]) -> None:
    """Replace the fits of a reader by radial clearances; `values_of` returns the known values of a path."""
    for path in list(grid_reader.keys_in_use):
        naming = naming_of(grid_reader, path)
        if naming is None:
            continue
        _report_needless_mounting(grid_reader, path, naming)
        for entries in (grid_reader.written, grid_reader.written_axes):
            if path not in entries or not _has_name(entries[path], naming):
                continue
            reader = _FitReader(grid_reader, path, naming, values_of)
            is_base = entries is grid_reader.written and path in grid_reader.written_axes
            with grid_reader.problems.reporting():
                if reader.bearing in grid_reader.varied_names and not is_base:
                    _mount_each(reader, entries[path])
                radii = reader.radii[:1] if is_base else reader.radii
                value = entries[path]
                is_axis = entries is grid_reader.written_axes
                entries[path] = reader.read_axis(value) if is_axis else reader.mean_clearance(value, radii)
                if is_base:
                    grid_reader.fits.pop(path, None)  # a value next to an axis belongs to no case
                continue
            for mapping in (grid_reader.keys_in_use, grid_reader.written_axes, grid_reader.written):
                mapping.pop(path, None)  # its problem is reported already


def _report_needless_mounting(grid_reader: Reader, path: str, naming: Naming) -> None:
    """Report a mounting on the joint of a clearance that is no group."""
    joint, entries = path.rpartition(".")[0], (grid_reader.written, grid_reader.written_axes)
    if any(path in values and _has_name(values[path], naming) for values in entries):
        return
    for key in naming.extras:
        if f"{joint}.{key}" in grid_reader.written:
            text = "mounts a group, and clearance has none; write clearance: {group: C3}, or leave this out"
            grid_reader.problems.add(grid_reader.written[f"{joint}.{key}"], f"{joint}.{key}", text)


def _mount_each(reader: "_FitReader", written: WrittenValue) -> None:
    """Let the clearance of a bearing whose name varies follow from each name, as `written` next to it."""
    grid_reader, path, content = reader.grid_reader, reader.path, written.value
    if path in grid_reader.written_axes or "group" not in content:
        text = f"{reader.bearing} varies: write the groups in its names, such as [6204 C2, 6204 C3], or a length"
        raise MistakeError(written, path, f"has groups, and {text}")
    varied, names = grid_reader.varied_names[reader.bearing], grid_reader.written_axes.get(reader.bearing)
    numbers = dict(varied.numbers)
    for item in names.value if names and isinstance(names.value, list) else ():
        if not isinstance(item.value, str) or item.value not in numbers:
            continue  # reported when the names are read
        group = parse_bearing_name(item.value).group
        if group and not content["group"].by_name:
            message = f"conflicts with the group {group} in a name under {reader.bearing}; remove one of the two"
            raise MistakeError(written, path, message)
        named_group = item.with_value(group or NORMAL_GROUP) if content["group"].by_name else content["group"]
        named = dict(numbers[item.value])

        def values_of(size: str, named: Mapping[str, float] = named) -> tuple[float, ...]:
            return (named[size],) if size in named else reader.values_of(size)

        each = _FitReader(grid_reader, path, reader.naming, values_of)
        fit = each.fit(written.with_value(content | {"group": named_group}), each.radii)
        numbers[item.value] = named | {path: fit.mean}
    content = content | reader.mounting_on_joint
    mounting = {key: entry.value for key, entry in content.items() if not entry.by_name}
    clearance = {path: mounting} if mounting else {}
    grid_reader.varied_names[reader.bearing] = varied._replace(numbers=numbers, clearance=clearance)


def read_fit_names(
    grid_reader: Reader, paths: list[str], among: WrittenValue, values_of: Callable[[str], tuple[float, ...]]
) -> list[Fit]:
    """Return the fits or groups in `among` (at least one) of clearances of one size; MistakeError if one is wrong."""
    namings = [naming_of(grid_reader, path) for path in paths]
    naming = namings[0]
    for path, other in zip(paths, namings, strict=True):
        if naming is None or other is None:
            raise MistakeError(among, path, "is not a clearance, so it cannot have a fit")
    assert naming is not None
    if set(namings) != {naming}:
        message = "the clearances are of pins and of rolling bearings; seek each separately"
        raise MistakeError(among, "seek.among", message)
    readers = [_FitReader(grid_reader, path, naming, values_of) for path in paths]
    if len({reader.all_sizes() for reader in readers}) > 1:
        message = f"the clearances have different {naming.size_key.replace('_', ' ')}s; seek each separately"
        raise MistakeError(among, "seek.among", message)
    try:
        fits = [readers[0].fit(item, readers[0].radii) for item in readers[0].items(among)]
    except MistakeError as error:
        message = str(error) or f"its {naming.size_key.replace('_', ' ')} is not known"
        raise MistakeError(error.written, "seek.among", message) from None
    grid_reader.fits.pop(paths[0], None)  # a clearance on the axis is not the mean of its fit
    return fits


def _has_name(written: WrittenValue, naming: Naming) -> bool:
    """Return whether a value, an axis or a distribution contains a fit or a group."""
    if isinstance(written.value, list):
        return any(isinstance(item.value, dict) for item in written.value)
    words = {word for item in NAMINGS.values() for word in (item.word, item.words)} | {*naming.extras}
    return isinstance(written.value, dict) and not words.isdisjoint(written.value)


class _FitReader:
    """Reads the fits or the groups of one clearance."""

    def __init__(
        self, grid_reader: Reader, path: str, naming: Naming, values_of: Callable[[str], tuple[float, ...]]
    ) -> None:
        self.grid_reader, self.path, self.naming, self.values_of = grid_reader, path, naming, values_of
        self.joint = path.rpartition(".")[0]
        self.radius_path, self.bearing = f"{self.joint}.{naming.size_key}", f"{self.joint}.{BEARING}"
        self.radii = values_of(self.radius_path)

    @property
    def mounting_on_joint(self) -> dict[str, WrittenValue]:
        """Return what the joint itself says of its mounting."""
        paths = {key: f"{self.joint}.{key}" for key in self.naming.extras}
        return {key: self.grid_reader.written[path] for key, path in paths.items() if path in self.grid_reader.written}

    def all_sizes(self) -> tuple[Any, ...]:
        """Return all values of the joint that determine its clearances."""
        if not self.naming.extras:
            return self.radii
        return (self._kind(), *(self.values_of(f"{self.joint}.{name}") for name in BearingSizes._fields))

    def read_axis(self, written: WrittenValue) -> WrittenValue:
        """Return a written axis with its fits replaced by clearances (m)."""
        if self.grid_reader.varied_by.get(self.path) == "sample":
            return written.with_value(self._distribution(written))
        items = self.items(written) if isinstance(written.value, dict) else written.value
        is_zipped = self.radius_path in self.grid_reader.written_axes and self.grid_reader.vary_together(
            self.path, self.radius_path
        )
        radii = [self.radii[row : row + 1] if is_zipped else self.radii for row in range(len(items))]
        return written.with_value(list(map(self.mean_clearance, items, radii)))

    def items(self, written: WrittenValue) -> list[WrittenValue]:
        """Return each entry of `{fits: [...]}` or `{groups: [...]}` as a single one."""
        content = written.value
        extras = {key: content[key] for key in self.naming.extras if key in content}
        names = content.get(self.naming.words)
        if {*content} - {*extras} != {self.naming.words} or not isinstance(names.value, list) or not names.value:
            axis_text = f"{{{self.naming.words}: [{self.naming.other_example}, {self.naming.example}]}}"
            raise MistakeError(written, self.path, f"found {quoted(content)}; expected {axis_text}")
        return [name.with_value({self.naming.word: name, **extras}) for name in names.value]

    def mean_clearance(self, written: WrittenValue, radii: tuple[float, ...]) -> WrittenValue:
        """Return the mean clearance of `{fit: NAME}` at a size (m); other values are returned unchanged."""
        if not isinstance(written.value, dict):
            return written
        if not {self.naming.word} <= set(written.value) <= {self.naming.word, *self.naming.extras}:
            raise MistakeError(
                written, self.path, self._expected_text(written.value, f"{{{self.naming.word}: {self.naming.example}}}")
            )
        return written.with_value(_length_text(self.fit(written, radii).mean))

    def _distribution(self, written: WrittenValue) -> Any:
        """Return the distribution of a fit, as a grid section."""
        written_name = written.value.get("distribution")
        if not {self.naming.word} <= set(written.value) <= {self.naming.word, "distribution", *self.naming.extras}:
            namings = DISTRIBUTION_FORM.replace("fit: H7/f7", f"{self.naming.word}: {self.naming.example}")
            raise MistakeError(written, self.path, self._expected_text(written.value, namings))
        name = "uniform" if written_name is None else written_name.value
        if not isinstance(name, str) or name not in FROM_FIT:
            suggestion = did_you_mean(name, FROM_FIT) if isinstance(name, str) else ""
            known_names = ", ".join(FROM_FIT)
            message = f"unknown distribution {quoted(name)} of a {self.naming.word}{suggestion} (known: {known_names})"
            raise MistakeError(written, self.path, message)
        return _lengths_like(FROM_FIT[name](self.fit(written, self.radii)), written)

    def _expected_text(self, content: Mapping[str, WrittenValue], expected: str) -> str:
        """Return what is wrong with the keys of a mapping."""
        if self.naming.extras and self.naming.word not in content and not {*content} - {*self.naming.extras}:
            return f"has a mounting without a group; write both, such as {{{self.naming.word}: C3, fit: k5/H7}}"
        return f"found {quoted(content)}; expected {expected}"

    def fit(self, written: WrittenValue, radii: tuple[float, ...]) -> Fit:
        """Return the fit or group of a mapping at a size (m), and record it."""
        name = written.value[self.naming.word]
        if len(radii) != 1:
            raise MistakeError(name, self.path, self._size_text(name))
        if not isinstance(name.value, str):
            message = f"found {quoted(name.value)}; expected {self.naming.noun}, such as {self.naming.example}"
            raise MistakeError(name, self.path, message)
        size = Fraction(repr(radii[0])) * 1000
        found_fit: Fit = placed(name, self.path, self._found, name.value, written.value, size)
        fits = self.grid_reader.fits.setdefault(self.path, [])
        if found_fit not in fits:
            fits.append(found_fit)
        return found_fit

    def _size_text(self, name: WrittenValue) -> str:
        """Return why a fit has not one size, or '' if that is reported elsewhere."""
        is_varied = (
            self.radius_path in self.grid_reader.written_axes or self.radius_path in self.grid_reader.defined.dependents
        )
        if is_varied:
            return (
                f"found the {self.naming.word} {quoted(name.value)}, whose clearance follows from one "
                f"{self.naming.size_noun}; {self.radius_path} is varied: vary both together under `zip`, the "
                f"{self.naming.word} once for each value"
            )
        if self.naming.extras and not self.grid_reader.is_given(self.radius_path):
            return f"found the group {quoted(name.value)}, which needs the bore: {self.radius_path}, such as 20 mm"
        return ""

    def _found(self, name: str, content: Mapping[str, WrittenValue], size: Fraction) -> Fit:
        """Return the fit or the group called `name` at a size (mm); raise InputError if there is none."""
        if not self.naming.extras:
            return find_fit(name, 2 * size)
        group = find_group(name, size, self._kind())
        if twice := sorted(self.mounting_on_joint.keys() & content.keys()):
            raise InputError(f"conflicts with {self.joint}.{twice[0]}; write {twice[0]} in one of the two places")
        content = {**self.mounting_on_joint, **content}
        if not any(key in content for key in MOUNTING_KEYS):
            return group
        fit, warmer = (content[key].value if key in content else None for key in MOUNTING_KEYS)
        if fit is not None and not isinstance(fit, str):
            raise InputError(f"found the fit {quoted(fit)}; expected classes of shaft and housing, such as k5/H7")
        warmer = 0.0 if warmer is None else _temperature_difference(warmer)
        return mounted(group, fit or "", BearingSizes(*self._mounted_sizes(is_fitted=bool(fit))), warmer)

    def _kind(self) -> str:
        """Return the kind of the elements as written, or '' if it is missing."""
        kind = self.grid_reader.written.get(f"{self.joint}.kind")
        return str(kind.value) if kind else ""

    def _mounted_sizes(self, *, is_fitted: bool) -> Iterable[float]:
        """Yield the sizes (m) of a mounted bearing; the outside diameter, nan if not known, counts in a fit only."""
        for name in BearingSizes._fields:
            values = self.values_of(f"{self.joint}.{name}")
            if len(values) == 1:
                yield values[0]
            elif not values and name == "outside_diameter" and not is_fitted:
                yield float("nan")
            else:
                reason = "is varied; a mounted clearance follows from one value" if values else "is missing"
                raise InputError(f"is of a mounted bearing, whose {name} {reason}; write {self.joint}.{name}")


def _temperature_difference(value: Any) -> float:
    """Return a temperature difference (K); raise InputError for a temperature."""
    if isinstance(value, str) and not value.strip().endswith("K"):
        raise InputError(f"found inner_warmer: {quoted(value)}; expected a difference of temperatures, such as 10 K")
    return quantity.read(value, "K")


def recorded_fits(record: Mapping[str, Any]) -> dict[str, tuple[Fit, ...]]:
    """Return path of a clearance -> its fits as the user wrote them, from run.json."""
    return {path: tuple(Fit(**limits) for limits in fits) for path, fits in record.get("fits", {}).items()}


def _lengths_like(value: Any, written: WrittenValue) -> Any:
    """Return dicts and lists of numbers as lengths, each at the position of `written`."""
    if isinstance(value, dict):
        return {key: written.with_value(_lengths_like(item, written)) for key, item in value.items()}
    if isinstance(value, list):
        return [written.with_value(_lengths_like(item, written)) for item in value]
    return _length_text(value)


def _length_text(length: float) -> str:
    """Return a length with a unit, as a user would write it."""
    return f"{length!r} m"
