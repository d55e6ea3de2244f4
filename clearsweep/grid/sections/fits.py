"""Reads clearances written as ISO 286 fits and replaces them by numbers.

A fit is `{fit: H7/f7}` as a value or in a list, `{fits: [H7/g6, H7/f7]}` as an axis, and as a distribution
`{fit: H7/f7}` or `{fit: H7/f7, distribution: normal}`.  All later readers see radial clearances in m.
"""

from collections.abc import Callable, Mapping
from fractions import Fraction
from typing import Any

from ...language.errors import InputError, did_you_mean, quoted
from ..keys.kinds import Number
from ..library.iso286 import Fit, find_fit
from ..written.document import WrittenValue
from .distributions import FROM_FIT
from .reader import Reader

DISTRIBUTION_FORM = "{fit: H7/f7}, or {fit: H7/f7, distribution: normal}"


def replace_fits_by_clearances(grid_reader: Reader, values_of: Callable[[str], tuple[float, ...]]) -> None:
    """Replace the fits of a reader by radial clearances; `values_of` returns the known values of a path."""
    for path, key in list(grid_reader.keys_in_use.items()):
        if not isinstance(key, Number) or not key.uses[0].field.fit:
            continue
        for entries in (grid_reader.written, grid_reader.written_axes):
            if path not in entries or not _has_fit(entries[path]):
                continue
            reader = _FitReader(grid_reader, path, values_of)
            try:
                entries[path] = (reader.read_value if entries is grid_reader.written else reader.read_axis)(
                    entries[path]
                )
            except _WrongFitError as error:
                if str(error):
                    grid_reader.problems.add(error.written, path, str(error))
                for mapping in (
                    grid_reader.keys_in_use,
                    grid_reader.written_axes,
                    grid_reader.written,
                ):  # its problem is reported already
                    mapping.pop(path, None)
            if entries is grid_reader.written and path in grid_reader.written_axes:
                grid_reader.fits.pop(path, None)  # a value next to an axis belongs to no case


def read_fit_names(
    grid_reader: Reader, paths: list[str], names: list[WrittenValue], values_of: Callable[[str], tuple[float, ...]]
) -> list[Fit] | None:
    """Return the fits with these names (at least one) for clearances with one bearing radius.

    Return None if one is wrong.
    """
    for path in paths:
        key = grid_reader.keys_in_use.get(path)
        if not isinstance(key, Number) or not key.uses[0].field.fit:
            grid_reader.problems.add(names[0], path, "is not a clearance, so it cannot have a fit")
            return None
    readers = [_FitReader(grid_reader, path, values_of) for path in paths]
    if len({reader.radii for reader in readers}) > 1:
        message = "the clearances have different bearing radii; seek each separately"
        grid_reader.problems.add(names[0], "seek.among", message)
        return None
    fits = []
    for name in names:
        try:
            fits += [reader.fit(name, reader.radii) for reader in readers[:1]]
        except _WrongFitError as error:
            grid_reader.problems.add(error.written, "seek.among", str(error) or "its bearing radius is not known")
            return None
    grid_reader.fits.pop(paths[0], None)  # a clearance on the axis is not the mean of its fit
    return fits


class _WrongFitError(Exception):
    """A mistake in a fit, with its place; without a sentence if it is reported for another value."""

    def __init__(self, written: WrittenValue, message: str):
        super().__init__(message)
        self.written = written


def _has_fit(written: WrittenValue) -> bool:
    """Return whether a value, an axis or a distribution contains a fit."""
    if isinstance(written.value, list):
        return any(isinstance(item.value, dict) for item in written.value)
    return isinstance(written.value, dict) and not {"fit", "fits"}.isdisjoint(written.value)


class _FitReader:
    """Reads the fits of one clearance."""

    def __init__(self, grid_reader: Reader, path: str, values_of: Callable[[str], tuple[float, ...]]):
        self.grid_reader, self.path = grid_reader, path
        self.radius_path = f"{path.rpartition('.')[0]}.bearing_radius"
        self.radii = values_of(self.radius_path)

    def read_value(self, written: WrittenValue) -> WrittenValue:
        """Return a value outside all axes with its fit replaced by a radial clearance (m)."""
        return self._mean_clearance(
            written, self.radii[:1] if self.path in self.grid_reader.written_axes else self.radii
        )

    def read_axis(self, written: WrittenValue) -> WrittenValue:
        """Return a written axis with its fits replaced by radial clearances (m)."""
        if self.grid_reader.varied_by.get(self.path) == "sample":
            return _at_position_of(written, self._distribution(written))
        items = written.value
        if isinstance(items, dict):
            if set(items) != {"fits"} or not isinstance(items["fits"].value, list):
                raise _WrongFitError(written, f"found {quoted(items)}; expected {{fits: [H7/g6, H7/f7]}}")
            items = [_at_position_of(item, {"fit": item}) for item in items["fits"].value]
        is_zipped = self.radius_path in self.grid_reader.written_axes and self.grid_reader.vary_together(
            self.path, self.radius_path
        )
        radii = [self.radii[row : row + 1] if is_zipped else self.radii for row in range(len(items))]
        return _at_position_of(written, list(map(self._mean_clearance, items, radii)))

    def _mean_clearance(self, written: WrittenValue, radii: tuple[float, ...]) -> WrittenValue:
        """Return the mean clearance of `{fit: NAME}` at a bearing radius (m); other values are returned unchanged."""
        if not isinstance(written.value, dict):
            return written
        if set(written.value) != {"fit"}:
            raise _WrongFitError(written, f"found {quoted(written.value)}; expected {{fit: H7/f7}}")
        return _at_position_of(written, _length_text(self.fit(written.value["fit"], radii).mean))

    def _distribution(self, written: WrittenValue) -> Any:
        """Return the distribution of a fit, as a grid section."""
        written_name = written.value.get("distribution")
        if not {"fit"} <= set(written.value) <= {"fit", "distribution"}:
            raise _WrongFitError(written, f"found {quoted(written.value)}; expected {DISTRIBUTION_FORM}")
        name = "uniform" if written_name is None else written_name.value
        if not isinstance(name, str) or name not in FROM_FIT:
            suggestion = did_you_mean(name, FROM_FIT) if isinstance(name, str) else ""
            known_names = ", ".join(FROM_FIT)
            raise _WrongFitError(
                written, f"unknown distribution {quoted(name)} of a fit{suggestion} (known: {known_names})"
            )
        return _lengths_like(FROM_FIT[name](self.fit(written.value["fit"], self.radii)), written)

    def fit(self, name: WrittenValue, radii: tuple[float, ...]) -> Fit:
        """Return the fit called `name` at a bearing radius (m), and record it."""
        if len(radii) != 1:
            message = (
                f"found the fit {quoted(name.value)}, whose radial clearance follows from one nominal diameter; "
                f"{self.radius_path} is varied: vary both together under `zip`, the fit once for each radius"
            )
            is_varied = (
                self.radius_path in self.grid_reader.written_axes
                or self.radius_path in self.grid_reader.defined.dependents
            )
            raise _WrongFitError(name, message if is_varied else "")
        if not isinstance(name.value, str):
            raise _WrongFitError(name, f"found {quoted(name.value)}; expected a fit of ISO 286, such as H7/f7")
        try:
            found_fit = find_fit(name.value, Fraction(repr(radii[0])) * 2000)
        except InputError as error:
            raise _WrongFitError(name, str(error)) from None
        fits = self.grid_reader.fits.setdefault(self.path, [])
        if found_fit not in fits:
            fits.append(found_fit)
        return found_fit


def recorded_fits(record: Mapping[str, Any]) -> dict[str, tuple[Fit, ...]]:
    """Return path of a clearance -> its fits as the user wrote them, from run.json."""
    return {path: tuple(Fit(**limits) for limits in fits) for path, fits in record.get("fits", {}).items()}


def _at_position_of(written: WrittenValue, value: Any) -> WrittenValue:
    """Return a new value at the position of another."""
    return WrittenValue(value, written.origin, written.line, written.column)


def _lengths_like(value: Any, written: WrittenValue) -> Any:
    """Return dicts and lists of numbers as lengths, each at the position of `written`."""
    if isinstance(value, dict):
        return {key: _at_position_of(written, _lengths_like(item, written)) for key, item in value.items()}
    if isinstance(value, list):
        return [_at_position_of(written, _lengths_like(item, written)) for item in value]
    return _length_text(value)


def _length_text(length: float) -> str:
    """Return a length with a unit, as a user would write it."""
    return f"{length!r} m"
