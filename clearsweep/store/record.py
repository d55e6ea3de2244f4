"""run.json: the grid, the versions and the results of a run; it contains a checksum of itself."""

import contextlib
import datetime
import functools
import hashlib
import io
import json
import os
import platform
import re
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import clearsweep

from ..contracts.layout import Column, JointLayout, Layout
from ..grid import ADDED, SCHEMA_VERSION, Fit, Grid, leaves
from ..language.errors import DamagedError, DirectoryError, quoted
from ..searches import SEARCHES, search_of
from . import durable

# ----------------------------------------------------------------------------------------------------------------------
# Validation of run.json: its checksum proves integrity, but not that `clearsweep run` wrote it.
#
# A results directory may be untrusted, so run.json is validated like a grid before it is used: names become
# names of files, texts appear in pages and tables.


MAX_LENGTH = 10_000  # characters of a text
MAX_INTEGER = 10**300  # largest integer that a float represents
MAX_BINS = 10**6  # bins or contacts of a joint
MAX_DEPTH = 20  # nesting of sections
MOST_DIFFERENCES = 5  # lines below a message on another grid
_CONTROL = re.compile("[\x00-\x1f\x7f-\x9f\u2028-\u202e\u2066-\u2069]")  # including line ends and bidirectional marks

Check = Callable[[Any, str], None]  # (value, where it is); raises MisshapenError


class MisshapenError(Exception):
    """Content of run.json that `clearsweep run` does not write; the text states key, value and what was expected."""


def check_record(record: dict[str, Any]) -> None:
    """Raise MisshapenError if the content of a run.json cannot have been written by `clearsweep run`."""
    _check_plain(record, "")
    _check(_RECORD, record, "")
    columns = {column["name"] for column in record["layout"]["columns"]} | record.get("figures", {}).keys()
    limits = record.get("limits", {})
    times = [limit["times"] for limit in limits.values() if isinstance(limit, dict) and "times" in limit]
    for kind, names, available in (("keys", record["keys"], record.keys()), ("limits", [*limits, *times], columns)):
        unknown = [name for name in names if name not in available]
        if unknown:
            raise MisshapenError(f"{kind} names {unknown[0]!r}, which is missing")


def check_facts(facts: Any) -> None:
    """Raise MisshapenError if the metadata of a batch cannot have been written by `clearsweep run`."""
    _check(_BATCH_FACTS, facts, "")


def _refusal(path: str, value: Any, expected: str) -> MisshapenError:
    actual = repr(value)
    return MisshapenError(f"{path or 'it'} is {actual if len(actual) <= 60 else actual[:57] + '...'}, not {expected}")


def _check_plain(value: Any, path: str, depth: int = 0) -> None:
    """Check that all texts, keys included, have one line and that the nesting of sections is limited."""
    if depth > MAX_DEPTH:
        raise MisshapenError(f"{path} is nested too deeply")
    if isinstance(value, str):
        if len(value) > MAX_LENGTH or _CONTROL.search(value):
            raise _refusal(path, value, f"a line of at most {MAX_LENGTH} characters")
    elif isinstance(value, list):
        for item in value:
            if not isinstance(item, int | float):  # shortcut for long axes
                _check_plain(item, path, depth + 1)
    elif isinstance(value, dict):
        for key, item in value.items():
            _check_plain(key, path, depth + 1)
            _check_plain(item, f"{path}.{key}" if path else key, depth + 1)


class _Chosen(NamedTuple):
    """The form of a section whose keys are chosen freely: that of each key, and of each value."""

    key: Any
    item: Any


class _Fields(NamedTuple):
    """The form of a section written from a NamedTuple: it has all fields without a default, and no others."""

    kind: Any
    fields: dict[str, Any]


def _check(form: Any, value: Any, path: str) -> None:
    """Raise MisshapenError unless a value, which is at `path`, has a form.

    A form is a Check; [form] for a list of such items; a tuple of forms of which one is enough; key -> form for a
    section with these keys, of which those that end with '?' may be missing, and any others; a _Chosen or a _Fields.
    """
    match form:
        case list():
            _LIST(value, path)
            for index, item in enumerate(value):
                _check(form[0], item, f"{path}[{index}]")
        case _Chosen():
            _SECTION(value, path)
            for name, item in value.items():
                _check(form.key, name, f"a key of {path}")
                _check(form.item, item, f"{path}.{name}")
        case _Fields():
            defaults = form.kind._field_defaults
            _check({f"{name}{'?' * (name in defaults)}": form.fields[name] for name in form.kind._fields}, value, path)
            if unknown := [name for name in value if name not in form.kind._fields]:
                raise MisshapenError(f"{path}.{unknown[0]} is unknown")
        case tuple():
            for each in form[:-1]:
                with contextlib.suppress(MisshapenError):
                    return _check(each, value, path)
            return _check(form[-1], value, path)  # whose error is that of all
        case dict():
            _check_section(form, value, path)
        case _:
            form(value, path)
    return None


def _check_section(section: dict[str, Any], value: Any, path: str) -> None:
    _SECTION(value, path)
    for key, form in section.items():
        name = key.removesuffix("?")
        item_path = f"{path}.{name}" if path else name
        if name in value:
            _check(form, value[name], item_path)
        elif name == key:
            raise MisshapenError(f"{item_path} is missing")


def _type_check(kinds: type | tuple[type, ...], expected: str) -> Check:
    """Return a check of the type of a value; a bool is no number."""

    def check_type(value: Any, path: str) -> None:
        is_bool = isinstance(value, bool)
        if not isinstance(value, kinds) or (is_bool and kinds is not bool):
            raise _refusal(path, value, expected)

    return check_type


def _text_check(pattern: str, expected: str, flags: re.RegexFlag = re.ASCII) -> Check:
    """Return a check that a value is text of a form."""
    compiled_pattern = re.compile(pattern, flags)

    def check_text(value: Any, path: str) -> None:
        if not isinstance(value, str) or not compiled_pattern.fullmatch(value):
            raise _refusal(path, value, expected)

    return check_text


def _accept_any(value: Any, path: str) -> None:
    """Accept any value."""


def _check_list_of_values(value: Any, path: str) -> None:
    _LIST(value, path)
    nested = next((item for item in value if isinstance(item, list | dict)), None)
    if nested is not None:
        raise _refusal(path, nested, "a number or a word")


def _check_number(value: Any, path: str) -> None:
    _type_check((int, float), "a number")(value, path)
    if isinstance(value, int) and abs(value) > MAX_INTEGER:
        raise _refusal(path, value, "a number")


def _range_check(largest: int, expected: str) -> Check:
    """Return a check of a whole number from 0 to `largest`."""

    def check_range(value: Any, path: str) -> None:
        _type_check(int, expected)(value, path)
        if not 0 <= value <= largest:
            raise _refusal(path, value, expected)

    return check_range


def _each(names: str, form: Any) -> dict[str, Any]:
    """Return the form of each of some keys."""
    return dict.fromkeys(names.split(), form)


_IDENTIFIER = _text_check(r"[A-Za-z_]\w{0,199}", "a name of letters, digits and _")
_NAME_OR_NONE = _text_check(r"([A-Za-z_]\w{0,199})?", "a name of letters, digits and _")
_WORD = _text_check(r"[A-Za-z_][\w-]{0,199}", "a name of letters, digits, - and _")
_WORD_OR_NONE = _text_check(r"([A-Za-z_][\w-]{0,199})?", "a name of letters, digits, - and _")
_CHANNEL = _text_check(r"[\w-]{1,99}(/[\w-]{1,99}){0,9}", "names of letters, digits, - and _ with / between")
_PATH = _text_check(r"[\w-]{1,99}(\.[\w-]{1,99}){0,19}", "a dotted path of a grid")
_UNIT = _text_check(r"[A-Za-z0-9*/^().+% -]{0,99}", "a unit")
_TEXT = _type_check(str, "text")
_FLAG = _type_check(bool, "true or false")
_NUMBER = _check_number
_COUNT = _type_check(int, "a whole number")
_SMALL_COUNT = _range_check(MAX_BINS, "a whole number of bins or contacts")
_NOTHING = _type_check(type(None), "null")
_LIST = _type_check(list, "a list")
_SECTION = _type_check(dict, "a section")
_CHECKSUM = _text_check(r"[0-9a-f]{1,64}", "a checksum")
_DIGESTS = _Chosen(_text_check(r"mark|[a-z]+\.(parquet|h5)", "the name of a file of results"), _CHECKSUM)
_VALUES_BY_PATH = _Chosen(_PATH, _check_list_of_values)
_COLUMN_NAME = _TEXT  # of a user's own figures: any identifier, checked where it is read
_JOINT_FIELDS = {
    name: {str: _NAME_OR_NONE, int: _SMALL_COUNT, bool: _FLAG}[kind]
    for name, kind in JointLayout.__annotations__.items()
}
_COLUMN_FIELDS = {"unit": _UNIT, "description": _TEXT, "kind": _text_check("float|int|text", "float, int or text")}
_COLUMN_FIELDS |= _each("figure joint", _NAME_OR_NONE)
_COLUMN_FIELDS["null"] = _text_check("|nothing|endless", "nothing or endless")
_LAYOUT_FIELDS = {
    "mechanism": _WORD,
    "output": _WORD_OR_NONE,
    "joints": [_Fields(JointLayout, _JOINT_FIELDS)],
    "columns": [_Fields(Column, _COLUMN_FIELDS | {"name": _IDENTIFIER})],
    "channels": [_Fields(Column, _COLUMN_FIELDS | {"name": _CHANNEL})],
    "frictions": [_IDENTIFIER],
    "listed": [_CHANNEL],
    **_each("until life", _NAME_OR_NONE),
    **_each("turns horizon error_check", _FLAG),
}
_FIT = _Fields(Fit, {"name": _TEXT, **_each("diameter low mean high", _NUMBER)})
_FEATURE = _each("channel kind feature", _TEXT) | {"unit": _UNIT} | _each("measured computed deviations", _NUMBER)
_SIGNAL = {"file": _TEXT, "channel": _TEXT, "revolutions": _COUNT, "speed": (_NOTHING, _NUMBER)}
_SIGNAL |= _each("samples orders angle", _NUMBER) | {"noise": [_NUMBER]}
_PARAMETER = {"path": _PATH, "determined": _text_check("well|weakly|not", "well, weakly or not"), "ends": [_WORD]}
_IDENTIFIED = {
    "parameters": [_PARAMETER | _each("value low high", _NUMBER)],
    "traded": [[(_PATH, _NUMBER)]],
    "fits": [_FEATURE],
    "signals": [_SIGNAL],
    "misfit": _NUMBER,
    "explained": _FLAG,
    **_each("looked_at finished", _COUNT),
    "computed_speed": _NUMBER,
    "priors": {"gain": _NUMBER, "noise": [_NUMBER]},
}
_BEST = {
    "point": _Chosen(_PATH, (_NOTHING, _TEXT, _FLAG, _NUMBER)),
    "value": _NUMBER,
    "margin": (_NOTHING, _NUMBER),
    "needed": _Chosen(_COLUMN_NAME, _TEXT),
    **_each("fit limiting", (_NOTHING, _TEXT)),
}
_EFFECT = {"path": _PATH, "unit": _UNIT, "value": _NUMBER, "margin": _NUMBER}
_EFFECT |= _each("lower upper", (_NOTHING, _NUMBER))
_NEAREST = {
    "best?": [_BEST],
    "needed?": _Chosen(_COLUMN_NAME, _TEXT),
    "effects?": [_EFFECT],
    "furthest?": (_NOTHING, {"point": _SECTION, "value": _NUMBER, "margin": _NUMBER}),
}
_BATCH_FACTS = {
    "shard": (_NOTHING, _text_check(r"[0-9a-f]{16}-[0-9a-f]{16}\.h5", "the name of a file of histories")),
    "sha256": _text_check("([0-9a-f]{64})?", "a checksum"),
    "written": _range_check(2**63 - 1, "a time in ns"),
    "frame": _text_check("[0-9a-f]{64}", "a checksum"),
    "span?": [_range_check(2**31 - 1, "a number of cases")],
}
_LAW_FILE = {
    **_each("name path package", _TEXT),
    "text": [_TEXT],
    "sha256": _CHECKSUM,
    "laws": [_SECTION],
    "named?": _Chosen(_TEXT, _CHECKSUM),
}
_LAW_SECTION = {"law?": _WORD, "elastic?": _WORD, "exponent?": _NUMBER, "pressure?": _WORD}
_RECORD = {
    "frame": _SECTION,
    "keys": [_WORD],
    "layout": _Fields(Layout, _LAYOUT_FIELDS),
    "units": _Chosen(_PATH, _UNIT),
    "name?": _text_check(r"\w[\w .+-]{0,99}", "the name of a run", re.UNICODE),
    "mechanism?": {"type": _WORD, "ideal?": _Chosen(_WORD, _WORD)},
    **_each("drive? loads? simulate? save? seeds? machine?", _SECTION),
    **{f"{search.name}?": _SECTION for search in SEARCHES},
    "laws?": [_LAW_FILE],
    "life?": {"limit?": _NUMBER, "of?": _WORD, "joint?": _WORD},
    "joints?": _Chosen(_WORD, _each("contact? friction? wear? film? roughness? profile?", _LAW_SECTION)),
    **_each("sweep? zip? cases?", _VALUES_BY_PATH),
    "sample?": {"method": _WORD, "drawn": _VALUES_BY_PATH, "seed?": _COUNT},
    "check_laws?": (_FLAG, _SECTION),
    "limits?": _Chosen(_COLUMN_NAME, ({"at_most?": _NUMBER, "at_least?": _NUMBER, "times?": _COLUMN_NAME}, _NUMBER)),
    "figures?": _Chosen(_COLUMN_NAME, (_TEXT, _SECTION)),
    "seek?": {**_each("largest? smallest?", (_PATH, [_PATH])), "for?": _WORD},
    "optimise?": {"over": _Chosen(_PATH, _accept_any), **_each("minimise? maximise?", [_COLUMN_NAME])},
    "identify?": {"over": _Chosen(_PATH, _accept_any)},
    "identified?": (_NOTHING, _IDENTIFIED),
    "nearest?": _NEAREST,
    "found?": {"sentences": [_TEXT]},
    "define?": _Chosen(_IDENTIFIER, _TEXT),
    "case_labels?": [_TEXT],
    "fits?": _Chosen(_PATH, [_FIT]),
    "labels?": _Chosen(_PATH, _Chosen(_TEXT, _NUMBER)),
    "written_units?": _Chosen(_PATH, {"unit": _TEXT, "factor": _NUMBER, "offset": _NUMBER}),
    "roles?": _Chosen(_PATH, _WORD),
    "versions?": _Chosen(_WORD, _TEXT),
    **_each("source? start? end?", (_TEXT, _NOTHING)),
    "counts?": _Chosen(_WORD, _COUNT),
    **_each("merged? answers?", _DIGESTS),
    "blocks?": {"size": _COUNT, "count": _COUNT, "numbers": [_COUNT]},
    "derived?": _Chosen(_TEXT, {"unit": _UNIT, "min": _NUMBER, "max": _NUMBER}),
    "warnings?": [_TEXT],
    "shard?": (_NOTHING, _text_check(r"\d{1,9}/\d{1,9}", "a shard such as 2/8")),
    "joined?": [_TEXT],
}


# ----------------------------------------------------------------------------------------------------------------------


RECORD_FILE = "run.json"
_checked: set[str] = set()  # checksums of contents that this process has checked: a run reads its own several times


def record_bytes(grid: Grid, facts: dict[str, Any]) -> bytes:
    """Return run.json: the resolved grid, versions, machine and `facts` (start, end, counts and the like)."""
    written = grid.resolved()
    return signed(
        {
            **written,
            "keys": list(written),
            "source": grid.source,
            "layout": grid.layout.written(),
            "frame": grid.fixed_settings(),
            "model_version": clearsweep.MODEL_VERSION,
            "units": {path: grid.unit(path) for path in grid.axes},
            "fits": {path: [entry._asdict() for entry in fits] for path, fits in grid.fits.items()},
            "labels": grid.labels,
            "case_labels": list(grid.case_labels),
            "roles": grid.roles,
            "written_units": {path: entry._asdict() for path, entry in grid.written_units.items()},
            "seeds": {"sample": written["sample"]["seed"]} if "seed" in written.get("sample", {}) else {},
            "versions": _package_versions(),
            "machine": {
                "node": platform.node(),
                "system": platform.platform(),
                "processor": platform.machine(),
                "cores": os.cpu_count(),
            },
            **facts,
        }
    )


def signed(record: dict[str, Any]) -> bytes:
    """Return the content of run.json with its checksum."""
    content = json_round_trip(record)
    content["checksum"] = record_checksum(content)
    written = io.BytesIO()
    for part in json.JSONEncoder(indent=2).iterencode(content):  # the list of all parts takes ten times their text
        written.write(part.encode())
    return written.getvalue()


def read_record(directory: Path) -> dict[str, Any]:
    """Return the content of run.json; DamagedError if it was changed, DirectoryError if it is missing."""
    path = Path(directory) / RECORD_FILE
    try:
        record = json.loads(durable.read(path))
        checksum = record_checksum(record) if isinstance(record, dict) else None
    except (FileNotFoundError, NotADirectoryError):
        reason = "there is no run.json in it" if Path(directory).is_dir() else "there is no directory of this name"
        reason = "it is a file" if Path(directory).is_file() else reason
        raise DirectoryError(
            f"{directory}: contains no run ({reason}); give a directory that `clearsweep run` has written"
        ) from None
    except (ValueError, RecursionError) as error:
        raise damaged_error(path, f"it is not JSON: {error}") from error
    if checksum is None or not isinstance(record.get("frame"), dict):
        raise damaged_error(path, "it was not written by `clearsweep run`")
    if "checksum" not in record and record["frame"].get("schema") != SCHEMA_VERSION:
        return dict(record)  # written by a version without checksums
    if record.get("checksum") != checksum:
        raise damaged_error(path, "its checksum differs")
    if record["frame"].get("schema") == SCHEMA_VERSION and checksum not in _checked:
        try:
            check_record(record)
            _checked.add(checksum)
        except MisshapenError as problem:
            version = record.get("model_version")
            if isinstance(version, str) and version != clearsweep.MODEL_VERSION:
                raise _of_another_version(directory, record, str(problem)) from None
            raise damaged_error(path, f"it was not written by `clearsweep run`: {problem}") from None
    return dict(record)


def _of_another_version(directory: Path, record: dict[str, Any], problem: str) -> DirectoryError:
    """Return the error for a run.json that an earlier or later version may have written, with entries of its own."""
    versions = record.get("versions")
    written = versions.get("clearsweep") if isinstance(versions, dict) else None
    return DirectoryError(
        f"{directory}: its run.json is of model version {quoted(record['model_version'])}, written by clearsweep "
        f"{quoted(written)}; this version has model version {clearsweep.MODEL_VERSION} and reads other entries "
        f"({problem}). Run the grid again into another directory, or read it with that version"
    )


def check_format(directory: Path, record: dict[str, Any]) -> None:
    """Raise DirectoryError if this version cannot read the format of a run directory."""
    number = record["frame"].get("schema")
    if number != SCHEMA_VERSION:
        written = record.get("versions", {}).get("clearsweep", "unknown")
        raise DirectoryError(
            f"{directory}: has format {number} of run directories, written by clearsweep {written}; this version "
            f"reads format {SCHEMA_VERSION}: run the grid again into another directory, or read it with that version"
        )


def damaged_error(path: Path, reason: str) -> DamagedError:
    """Return the error for a file of a run that was changed."""
    return DamagedError(
        f"{path}: damaged ({reason}); run the grid again with --out {path.parent}, which restores it from its batches"
    )


def is_finished(record: dict[str, Any]) -> bool:
    """Return whether a run has merged all its cases; one with too many failures stops before."""
    return "merged" in record and not record.get("counts", {}).get("missing")


def record_checksum(record: dict[str, Any]) -> str:
    """Return the checksum of run.json without the checksum itself, regardless of layout."""
    content = {key: value for key, value in record.items() if key != "checksum"}
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()


def declared_values(record: Mapping[str, Any], path: str) -> list[Any] | None:
    """Return the values of an axis in run.json; None if a search adds others."""
    if search_of(record):
        return None
    sections = [
        *(record.get(name, {}) for name in ("sweep", "zip", "cases")),
        record.get("sample", {}).get("drawn", {}),
    ]
    return next((section[path] for section in sections if path in section), None)


def kind_of_axis(record: Mapping[str, Any], path: str) -> str:
    """Return the kind of the column of an axis; '' if it is unknown."""
    values = declared_values(record, path)
    return "" if values is None else "text" if all(isinstance(value, str) for value in values) else "float"


_UNCOMPARED_KEYS = ("name", "roles")  # run.json has the roles of all axes, the grid those that it sets


def grid_changes(first: Mapping[str, Any], second: Mapping[str, Any]) -> dict[str, tuple[Any, Any]]:
    """Return dotted path -> values of both grids where they differ, None for a missing one; cases added are left out.

    first, second : the content of run.json, or of a resolved grid with its sections as `keys`
    """
    first_values, second_values = (
        {
            path: value
            for path, value in leaves({key: record[key] for key in record["keys"] if key not in _UNCOMPARED_KEYS})
            if ADDED not in path.split(".")
        }
        for record in (first, second)
    )
    return differing(first_values, second_values)


def differing(first: Mapping[str, Any], second: Mapping[str, Any]) -> dict[str, tuple[Any, Any]]:
    """Return key -> both values where two mappings differ, None for a missing one."""
    pairs = {key: (first.get(key), second.get(key)) for key in {**first, **second}}
    return {key: pair for key, pair in pairs.items() if pair[0] != pair[1]}


def difference_lines(lines: Iterable[str]) -> str:
    """Return lines on differences below a message: the first of them, and how many more there are."""
    listed = list(lines)
    more = [f"and {len(listed) - MOST_DIFFERENCES} more"] if len(listed) > MOST_DIFFERENCES else []
    return "".join(f"\n  {line}" for line in [*listed[:MOST_DIFFERENCES], *more])


def grid_record(grid: Grid) -> dict[str, Any]:
    """Return a grid in the form that `grid_changes` compares with run.json."""
    written = grid.resolved()
    record: dict[str, Any] = json_round_trip({**written, "keys": list(written)})
    return record


def json_round_trip(value: Any) -> Any:
    """Return `value` after a round trip through JSON."""
    return json.loads(json.dumps(value, default=lambda scalar: scalar.item()))


def utc_now() -> str:
    """Return the time in UTC, ISO 8601."""
    return datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds")


@functools.cache  # it is asked for at the start and at the end of a run
def _package_versions() -> dict[str, str]:
    names = ("numpy", "llvmlite", "scipy", "pandas", "pyarrow", "h5py")
    return {
        "clearsweep": clearsweep.__version__,
        "python": platform.python_version(),
        **{name: _installed_version(name) for name in names},
    }


def _installed_version(name: str) -> str:
    """Return the version of a package from the name of its folder; `importlib.metadata` takes 8 ms for each."""
    folders = list(Path(np.__file__).parents[1].glob(f"{name}-*.dist-info"))
    if len(folders) == 1:
        return folders[0].stem.removeprefix(f"{name}-")
    from importlib import metadata

    return metadata.version(name)
