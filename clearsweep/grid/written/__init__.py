"""Reads written input: documents, overrides, tables, and expressions of defined quantities."""

import contextlib
import csv
import os
import re
import stat
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from os import PathLike, fspath
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from ...language.errors import InputError, quoted

if TYPE_CHECKING:  # few grids name workbooks
    import zipfile
    from xml.etree import ElementTree

# ----------------------------------------------------------------------------------------------------------------------
# Reads the rows of tables: CSV with any usual separator and decimal sign, Excel and Parquet files.


TableRow = tuple[int, list[Any]]  # number and cells

_HEADER_PATTERN = re.compile(r"\s*([^\[\]]*?)\s*(?:\[([^\[\]]*)\]\s*)?")
_DECIMAL_COMMA = re.compile(r"\s*[+-]?(\d*),(\d+)(?:[eE][+-]?\d+)?(?=\s|$|[^\d,.])")
NOT_UTF_8 = "not UTF-8 text (byte {}); save the file as UTF-8"
_SHEET_PATTERN = re.compile(r"xl/worksheets/sheet(\d+)\.xml")
_CELL_PATTERN = re.compile(r"([A-Z]{1,3})\d+")
MAX_PART_BYTES = 256 * 2**20  # bytes of a part of a workbook, unpacked


def split_header(heading: str) -> tuple[str, str]:
    """Return name and unit of a column header such as `drive.speed [rpm]`; '' for a missing part."""
    match = _HEADER_PATTERN.fullmatch(heading)
    return (match[1], (match[2] or "").strip()) if match else ("", "")


def rows_of_csv(file: Path) -> tuple[list[str], list[TableRow]]:
    """Return the headers, and line number and cells of every row that is not blank.

    Columns are separated by the first of tab, semicolon and comma that the header contains; numbers of the first two
    may have a decimal comma.  Raises ValueError where a comma may be a decimal or a thousands separator, and for a
    file that is not UTF-8.
    """
    try:
        with open(file, newline="", encoding="utf-8-sig") as stream:
            first_line = stream.readline()
            separator = next((sign for sign in "\t;" if sign in first_line), ",")
            stream.seek(0)
            lines = csv.reader(stream, delimiter=separator)
            headers = next(lines, [])
            rows = [(lines.line_num, cells) for cells in lines if any(cell.strip() for cell in cells)]
    except UnicodeDecodeError as error:
        raise ValueError(f"{NOT_UTF_8.format(error.start)}, in Excel as 'CSV UTF-8'") from None
    return headers, rows if separator == "," else _with_decimal_points(rows)


def _with_decimal_points(rows: list[TableRow]) -> list[TableRow]:
    """Return rows with decimal points in place of commas; ValueError if it is not clear what the commas mean."""
    commas = [(line, cell, match) for line, cells in rows for cell in cells if (match := _DECIMAL_COMMA.match(cell))]
    if not commas:
        _check_points(rows)
        return rows
    point = next((line for line, cells in rows for cell in cells if re.match(r"\s*[+-]?\d*\.\d", cell)), None)
    if point is not None:
        raise ValueError(
            f"row {commas[0][0]} has the decimal comma of {commas[0][1].strip()!r}, row {point} a decimal point; write "
            "one of the two"
        )
    if all(len(match[2]) == 3 and match[1].lstrip("0") for *_, match in commas):
        message = f"row {commas[0][0]}: {commas[0][1].strip()!r} may be a fraction or thousands; write a decimal point"
        raise ValueError(message)
    return [
        (line, [cell.replace(",", ".", 1) if _DECIMAL_COMMA.match(cell) else cell for cell in cells])
        for line, cells in rows
    ]


def _check_points(rows: list[TableRow]) -> None:
    """Raise ValueError if every point of a table whose decimal sign may be a comma may separate thousands."""
    points = [(line, cell.strip()) for line, cells in rows for cell in cells if re.match(r"\s*[+-]?\d*\.\d", cell)]
    if points and all(re.fullmatch(r"[+-]?[1-9]\d{0,2}\.\d{3}", cell) for _, cell in points):
        line, cell = points[0]
        raise ValueError(
            f"row {line}: {cell!r} may be a fraction or thousands; write {cell}0 or {cell.replace('.', '')}"
        )


def complete_rows_of_csv(path: Path, max_bytes: int) -> tuple[list[str], list[TableRow]]:
    """Return headers and rows as `rows_of_csv`.

    Raise InputError, with the row, if a row lacks a cell or has too many.
    """
    try:
        check_regular_file(path, max_bytes)
        headers, rows = rows_of_csv(path)
    except (OSError, ValueError, csv.Error) as error:
        raise InputError(f"{path}: cannot be read: {getattr(error, 'strerror', None) or error}") from None
    for line, cells in rows:
        if len(cells) != len(headers):
            raise InputError(
                f"{path}:{line}: the row has {len(cells)} cells but the header has {len(headers)}; write every value"
            )
    return headers, rows


def rows_of_parquet(file: Path) -> tuple[list[str], list[TableRow]]:
    """Return the headers, and number and cells of every row."""
    import pyarrow.parquet as pq

    with pq.ParquetFile(file, pre_buffer=False) as content:
        table = content.read(use_threads=False)
    columns = [table.column(k).to_pylist() for k in range(table.num_columns)]
    rows = zip(*columns, strict=True)
    return table.column_names, [(number, list(cells)) for number, cells in enumerate(rows, start=1)]


def rows_of_xlsx(file: Path, sheet: int = 1) -> tuple[list[str], list[TableRow]]:
    """Return the headers, and number and cells of every row of a sheet of an Excel workbook that is not blank.

    sheet : its number, 1 for the first.  Values of formulas are those that Excel stored.  Raises ValueError if the
    file is no workbook or has no such sheet.
    """
    import zipfile
    from xml.etree import ElementTree

    try:
        with zipfile.ZipFile(file) as book:
            sheets = {int(match[1]): name for name in book.namelist() if (match := _SHEET_PATTERN.fullmatch(name))}
            if sheet not in sheets:
                raise ValueError(f"has {len(sheets)} sheets; there is no sheet {sheet}")
            has_shared = "xl/sharedStrings.xml" in book.namelist()
            items = _part(book, "xl/sharedStrings.xml").iterfind("{*}si") if has_shared else ()
            shared = ["".join(text.text or "" for text in item.iterfind(".//{*}t")) for item in items]
            root = _part(book, sheets[sheet])
        rows = _rows_of_sheet(root, shared)
    except (zipfile.BadZipFile, ElementTree.ParseError, LookupError, NotImplementedError, RuntimeError) as error:
        raise ValueError(f"is no Excel workbook (.xlsx), or is encrypted: {error}") from None
    if not rows:
        return [], []
    headers = [str(cell) for cell in rows[0][1]]
    return headers, [(number, cells + [""] * (len(headers) - len(cells))) for number, cells in rows[1:]]


def _rows_of_sheet(root: "ElementTree.Element", shared: list[str]) -> list[TableRow]:
    """Return number and cells of every row that is not blank."""
    rows = []
    for number, row in enumerate(root.iterfind(".//{*}sheetData/{*}row"), start=1):
        cells = {_column(cell, k): _cell_value(cell, shared) for k, cell in enumerate(row.iterfind("{*}c"))}
        if any(value not in ("", None) for value in cells.values()):
            rows.append((int(row.get("r", number)), [cells.get(k, "") for k in range(max(cells) + 1)]))
    return rows


def _part(book: "zipfile.ZipFile", name: str) -> "ElementTree.Element":
    """Return a part of a workbook; ValueError if it is too large once it is unpacked."""
    from xml.etree import ElementTree

    if book.getinfo(name).file_size > MAX_PART_BYTES:
        raise ValueError(f"its part {name} has more than {MAX_PART_BYTES:,} bytes")
    return ElementTree.fromstring(book.read(name))  # expat limits the expansion of entities


def _column(cell: "ElementTree.Element", default: int) -> int:
    """Return the number of the column of a cell, 0 for the first: 27 of AB4."""
    match = _CELL_PATTERN.fullmatch(cell.get("r", ""))
    if not match:
        return default
    number = 0
    for letter in match[1]:
        number = 26 * number + ord(letter) - ord("A") + 1
    return number - 1


def _cell_value(cell: "ElementTree.Element", shared: list[str]) -> Any:
    """Return the value of a cell: text, or the text of a number; `=` and a formula whose value is not stored."""
    if cell.get("t") == "inlineStr":
        return "".join(text.text or "" for text in cell.iterfind(".//{*}t"))
    content, formula = cell.findtext("{*}v") or "", cell.findtext("{*}f")
    if cell.get("t") == "s" and content:
        return shared[int(content)]
    if cell.get("t") == "b":
        return "TRUE" if content == "1" else "FALSE"
    return content or (f"={formula}" if formula else "")


#: Ending of the name of a file -> the function that reads its rows.
READERS: dict[str, Callable[..., tuple[list[str], list[TableRow]]]] = {
    ".csv": rows_of_csv,
    ".tsv": rows_of_csv,
    ".txt": rows_of_csv,
    ".xlsx": rows_of_xlsx,
    ".parquet": rows_of_parquet,
}
KNOWN_FILES_TEXT = "a .csv, .xlsx or .parquet file"


# ----------------------------------------------------------------------------------------------------------------------
# Reads a YAML 1.2 file or a dict into values with their positions, applies overrides, and collects mistakes.


_MAX_BYTES = 64 * 2**20  # bytes of a grid file
_PREFIXED_INTEGER = re.compile(r"[+-]?(0x[0-9a-f]{1,40}|0o[0-7]{1,40})")
_MAX_DEPTH = 60  # of sections and lists, more than any key has
_TOO_DEEP = f"nested too deeply, or contains itself; expected at most {_MAX_DEPTH} levels of sections and lists"
EXTENDS = "extends"  # the key that names the file which a grid extends
MERGE_KEY = "<<"
_MERGE_KEY_TEXT = (
    "merge keys belong to YAML 1.1 and are not read; write the section out, use `*name` as the whole section, or put "
    "what grids share into a file and write `extends: FILE` at the top"
)
_TAG_PREFIX = "tag:yaml.org,2002:"
#: Types of values without a tag.
_UNTAGGED_TYPES = ("map", "seq", "str", "int", "float", "bool", "null", "timestamp", "merge", "value")


@dataclass(frozen=True, slots=True)
class WrittenValue:
    """A value as written, with its position."""

    value: Any  # dict of str to WrittenValue, list of WrittenValue, text or number as written, bool or None
    origin: str = ""  # file, 'overrides', or '' for a dict
    line: int = 0  # 1 for the first line; 0: not from a file
    column: int = 0
    keys: dict[str, "WrittenValue"] = field(default_factory=dict)  # key -> the place of the key itself, without a value
    expression: str = ""  # from which the value was evaluated
    by_name: bool = False  # the user wrote the name of a fit or of a library entry here

    @property
    def position_text(self) -> str:
        """Return the position as `grid.yaml:14:12: `, or the known part of it."""
        return f"{self.origin}:{self.line}:{self.column}: " if self.line else f"{self.origin}: " if self.origin else ""

    def with_value(self, value: Any) -> "WrittenValue":
        """Return another value at this position, and with these positions of keys."""
        return WrittenValue(value, self.origin, self.line, self.column, self.keys)

    @property
    def entries(self) -> dict[str, "WrittenValue"]:
        """Return the content of a section, or {} of anything else."""
        return self.value if isinstance(self.value, dict) else {}

    @property
    def items(self) -> list["WrittenValue"]:
        """Return the items of a list, or the single value in its place."""
        return self.value if isinstance(self.value, list) else [self]

    def without(self, key: str) -> "WrittenValue":
        """Return a section without a key, or any other value unchanged."""
        return self.with_value({k: value for k, value in self.value.items() if k != key}) if self.entries else self

    def key_position(self, key: str) -> "WrittenValue":
        """Return the position of a key of this section, or that of its value if it is unknown."""
        position = self.keys.get(key)
        return self.value[key] if position is None else position


class MistakeError(Exception):
    """A mistake in a document with its place; without a sentence if it is reported for another value."""

    def __init__(self, written: WrittenValue, path: str, sentence: str = ""):
        super().__init__(sentence)
        self.written, self.path = written, path


def placed(written: WrittenValue, path: str, read: Callable[..., Any], *arguments: Any) -> Any:
    """Return what a call returns; its InputError becomes the mistake of the value at dotted `path`."""
    try:
        return read(*arguments)
    except InputError as error:
        raise MistakeError(written, path, str(error)) from None


class Problems:
    """The mistakes in a document, each reported once, in the order of the file."""

    def __init__(self) -> None:
        self._positions: dict[str, tuple[int, int]] = {}
        self.unread: set[str] = set()  # paths whose expression has no value; the placeholder there must not be reported
        self.base = ""  # the file that the document extends

    def __len__(self) -> int:
        return len(self._positions)

    def add(self, written: WrittenValue, path: str, sentence: str) -> None:
        """Report that the value at dotted `path` is wrong."""
        if written.expression and path in self.unread:
            return
        sentence += f" (found is the value of {quoted(written.expression)})" if written.expression else ""
        if self.base and ("conflicts with" in sentence or sentence.startswith("replaces ")):
            sentence += f"; `null` in place of a value leaves out a key of {self.base}"
        is_named = not path or written.position_text in (
            f"{SET_OPTION} {path}: ",
            f"{SWEEP_OPTION} {path.removeprefix('sweep.')}: ",
        )
        message = f"{written.position_text}{'' if is_named else f'{path}: '}{sentence}"
        self._positions.setdefault(message, (written.line, written.column))

    @contextlib.contextmanager
    def reporting(self) -> Iterator[None]:
        """In this context, a `MistakeError` is reported, and ends it."""
        try:
            yield
        except MistakeError as mistake:
            if str(mistake):
                self.add(mistake.written, mistake.path, str(mistake))

    def check(self) -> None:
        """Raise an InputError with all mistakes, if there are any."""
        if self._positions:
            raise InputError(*sorted(self._positions, key=self._positions.__getitem__))


#: Part of a problem in the words of YAML -> what a reader of the grid can see of it.
_EXPLANATIONS = {
    "character '\\t'": "a tab in the indentation; indent with spaces",
    "but got '<scalar>'": "text after a value; inside {} or [] put a comma between values, and write an expression "
    "with a comma in quotes",
    "',' or '}', but got '['": "a bracket within a key; inside {} write a header in quotes, such as 'time [s]'",
    "expected <block end>, but found '<block": "this line is indented differently from the lines above it",
}


def read_document(source: str | PathLike | Mapping, problems: Problems) -> WrittenValue:
    """Return the document in a file or a dict; raise InputError if it cannot be read at all."""
    if not isinstance(source, (str, PathLike)):
        return written_of(source, "")
    from ruamel.yaml import YAML
    from ruamel.yaml.error import MarkedYAMLError, YAMLError

    name = fspath(source)
    try:
        check_regular_file(name, _MAX_BYTES)
        with open(name, encoding="utf-8-sig") as file:
            text = file.read()
    except UnicodeDecodeError as error:
        raise InputError(f"{name}: {NOT_UTF_8.format(error.start)}") from error
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        similar = next((each for each in (f"{name}.yaml", f"{name}.yml") if Path(each).is_file()), "")
        remedy = f"did you mean {similar}?" if similar else "give the path of a grid file"
        raise InputError(f"{name}: cannot be read: {reason}; {remedy}") from error
    try:
        node = YAML(typ="safe", pure=True).compose(text)
    except MarkedYAMLError as error:
        error_mark = error.problem_mark or error.context_mark
        where = f"{name}:{error_mark.line + 1}:{error_mark.column + 1}" if error_mark else name
        problem = error.problem or error.context or ""
        plain_text = next((text for part, text in _EXPLANATIONS.items() if part in problem), problem)
        raise InputError(f"{where}: not valid YAML: {plain_text}") from error
    except (YAMLError, ValueError) as error:
        first_line = (str(error).strip().splitlines() or ["it cannot be read"])[0]
        raise InputError(f"{name}: not valid YAML: {first_line}") from error
    except RecursionError:
        raise InputError(f"{name}: {_TOO_DEEP}") from None
    if node is None:
        raise InputError(f"{name}:1:1: the file is empty; `clearsweep init` writes a grid to start from")
    _check_depth(node, name)
    return from_node(node, name, "", problems, {})


def check_regular_file(name: str | PathLike, max_bytes: int) -> None:
    """Raise OSError unless `name` is a regular file, no device or pipe, of at most `max_bytes` bytes."""
    file_status = os.stat(name)
    if not stat.S_ISREG(file_status.st_mode):
        raise OSError(0, "it is a directory" if stat.S_ISDIR(file_status.st_mode) else "it is not a regular file")
    if file_status.st_size > max_bytes:
        raise OSError(0, f"it has {file_status.st_size:,} bytes, more than the {max_bytes:,} that are read")


def _check_depth(root: Any, origin: str) -> None:
    """Raise InputError if a document is nested too deeply for the functions that read it; aliases count as nesting."""
    heights: dict[int, int] = {}  # of the finished nodes, each visited once
    pending = {id(root): (root, iter(_children(root)))}  # the nodes around the present one
    while pending:
        node, children = pending[next(reversed(pending))]
        child = next((child for child in children if id(child) not in pending and id(child) not in heights), None)
        if child is not None:
            pending[id(child)] = (child, iter(_children(child)))
            continue
        del pending[id(node)]
        heights[id(node)] = 1 + max((heights.get(id(child), 0) for child in _children(node)), default=0)
        if heights[id(node)] > _MAX_DEPTH:
            mark = node.start_mark
            raise InputError(f"{origin}:{mark.line + 1}:{mark.column + 1}: {_TOO_DEEP}")


def _children(node: Any) -> list[Any]:
    """Return the sections and lists directly in a node, keys of sections included."""
    entries = node.value if isinstance(node.value, list) else []
    parts = (part for entry in entries for part in (entry if isinstance(entry, tuple) else (entry,)))
    return [part for part in parts if isinstance(part.value, list)]


def written_of(value: Any, origin: str, depth: int = 0) -> WrittenValue:
    """Return a Python value (mapping, sequence, array, number or text) as a written value."""
    if depth > _MAX_DEPTH:
        raise InputError(f"{origin or 'the grid'}: {_TOO_DEEP}")
    if hasattr(value, "items"):
        return WrittenValue({str(key): written_of(item, origin, depth + 1) for key, item in value.items()}, origin)
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, (list, tuple, range)):
        return WrittenValue([written_of(item, origin, depth + 1) for item in value], origin)
    return WrittenValue(value, origin)


def override(root: WrittenValue, path: str, value: Any, problems: Problems) -> WrittenValue:
    """Return `root` with `value` at dotted `path`; None removes the value there."""
    if path.count(".") >= _MAX_DEPTH:
        raise InputError(f"{quoted(path)}: {_TOO_DEEP}")
    written = value if isinstance(value, WrittenValue) else written_of(value, "overrides")
    return _with_value(
        root,
        path.split("."),
        written,
        lambda passed: problems.add(
            WrittenValue(None, written.origin),
            path,
            (f"continues below {quoted(passed)}, which is a value and not a section; correct the path"),
        ),
    )


def _with_value(
    written: WrittenValue, keys: list[str], value: WrittenValue, report_obstacle: Callable[[Any], None]
) -> WrittenValue:
    """Return `written` with `value` at the position `keys`; `refuse` is called for a value that is in the way."""
    entries = dict(enumerate(written.value)) if isinstance(written.value, list) else written.value
    if not isinstance(entries, dict):
        report_obstacle(written.value)
        return written
    entries = {str(key): item for key, item in entries.items()}
    key, *remaining = keys
    if remaining:
        entries[key] = _with_value(entries.get(key, WrittenValue({}, value.origin)), remaining, value, report_obstacle)
    elif value.value is None:
        entries.pop(key, None)
    else:
        entries[key] = value
    return written.with_value(entries)


def from_node(
    node: Any, origin: str, path: str, problems: Problems, nodes_read: dict[int, WrittenValue | None]
) -> WrittenValue:
    """Return the value of a YAML node; a node with aliases is converted once."""
    location = (origin, node.start_mark.line + 1, node.start_mark.column + 1)
    if id(node) in nodes_read:
        earlier = nodes_read[id(node)]
        if earlier is None:
            problems.add(WrittenValue(None, *location), path, "an alias contains itself; write its value instead")
        return earlier or WrittenValue(None, *location)
    nodes_read[id(node)] = None
    if str(node.tag).removeprefix(_TAG_PREFIX) not in _UNTAGGED_TYPES:
        problems.add(WrittenValue(None, *location), path, f"the YAML tag {node.tag} is not supported; remove the tag")
    if node.id == "mapping":
        values: dict[str, WrittenValue] = {}
        keys: dict[str, WrittenValue] = {}
        inherited: dict[str, WrittenValue] = {}  # by merge keys, so that nothing is missing where one is reported
        for key_node, value_node in node.value:
            key_location = WrittenValue(None, location[0], key_node.start_mark.line + 1, key_node.start_mark.column + 1)
            key = str(key_node.value) if not isinstance(key_node.value, list) else "?"
            nested = f"{path}.{key}" if path else key
            if key in values:
                message = f"duplicate key; it is also on line {keys[key].line}: keep one of them"
                problems.add(key_location, nested, message)
                continue
            value = from_node(value_node, location[0], nested, problems, nodes_read)
            if key == MERGE_KEY:
                problems.add(key_location, nested, _MERGE_KEY_TEXT)
                inherited |= value.entries
                continue
            is_blank = value.value is None and not value_node.value  # an empty value has no position
            values[key], keys[key] = key_location if is_blank else value, key_location
        written = WrittenValue(inherited | values, *location, keys)
    elif node.id == "sequence":
        written = WrittenValue([from_node(item, origin, path, problems, nodes_read) for item in node.value], *location)
    else:
        written = WrittenValue(
            _scalar(str(node.tag), node.value, WrittenValue(None, *location), path, problems), *location
        )
    nodes_read[id(node)] = written
    return written


def _scalar(tag: str, text: str, key_location: WrittenValue, path: str, problems: Problems) -> bool | int | str | None:
    """Return a YAML scalar: bool, None, or text, from which quantities are read exactly."""
    kind, word = tag.removeprefix(_TAG_PREFIX), text.lower()
    if kind == "bool" and word in ("true", "false"):
        return word == "true"
    if kind == "null" and word in ("", "~", "null"):
        return None
    if kind == "int" and _PREFIXED_INTEGER.fullmatch(word):
        return int(word, 0)
    if kind in ("bool", "null"):  # a tag on another text
        problems.add(key_location, path, f"found {quoted(text)}, which is no {kind}; remove the tag")
    return text


AXIS_SECTIONS = ("sweep", "zip", "cases")  # their entries are dotted path -> values, and may have labels
SET_OPTION, SWEEP_OPTION = "--set", "--sweep"


class OverriddenGrid(NamedTuple):
    """Overrides of a grid from the command line, each as YAML text."""

    source: str | PathLike | Mapping
    fixed: Mapping[str, str] = {}  # dotted path -> the value of every case
    swept: Mapping[str, str] = {}  # dotted path -> its values, as in a list, or evenly spaced ones in braces


def read_options(option: str, arguments: tuple[str, ...]) -> dict[str, str]:
    """Return path -> text of the `PATH=VALUE` arguments of an option; InputError for any other form."""
    form, example = ("VALUE", "3000rpm") if option == SET_OPTION else ("A,B,C", "1000rpm,3000rpm")
    options: dict[str, str] = {}
    invalid = []
    for text in arguments:
        path, equals, value = (word.strip() for word in text.partition("="))
        if not equals or not path or not (value or option == SET_OPTION):
            invalid.append(f"{option} {text}: expected PATH={form}, such as {option} drive.speed={example}")
        elif path in options:
            invalid.append(f"{option} {path}: is given twice; remove one of the two")
        options[path] = value
    if invalid:
        raise InputError(*invalid)
    return options


def apply_overrides(root: WrittenValue, overrides: OverriddenGrid, problems: Problems) -> WrittenValue:
    """Return the document with the overrides applied; an empty value removes the key."""
    for path in sorted(overrides.fixed.keys() & overrides.swept.keys()):
        problems.add(WrittenValue(None, SET_OPTION), path, f"is given with {SWEEP_OPTION}, too; remove one of the two")
    for path in (path for path in overrides.fixed if path.startswith("sweep.")):
        raise InputError(f"{SET_OPTION} {path}: is an axis; write {SWEEP_OPTION} {path.removeprefix('sweep.')}=VALUES")
    for path, text in overrides.fixed.items():
        root = override(root, path, _read_yaml_text(f"{SET_OPTION} {path}", path, text, problems), problems)
    for path, text in overrides.swept.items():
        listed = text if text[:1] in "[{" else f"[{text}]"
        values = _read_yaml_text(f"{SWEEP_OPTION} {path}", path, listed, problems)
        section = root.value.get("sweep", WrittenValue({}, values.origin))
        if isinstance(section.value, dict):  # else its problem is reported elsewhere
            keys = {key: location for key, location in section.keys.items() if key != path}
            with_axis = replace(section, value=section.value | {path: values}, keys=keys)
            root = root.with_value(root.value | {"sweep": with_axis})
    return root


def _read_yaml_text(origin: str, path: str, text: str, problems: Problems) -> WrittenValue:
    """Return the value of a YAML text that comes from `origin`."""
    from ruamel.yaml import YAML
    from ruamel.yaml.error import YAMLError

    try:
        node = YAML(typ="safe", pure=True).compose(text)
    except (YAMLError, ValueError):
        raise InputError(f"{origin}: found {quoted(text)}, which is not valid YAML") from None
    except RecursionError:
        raise InputError(f"{origin}: found {quoted(text)}: {_TOO_DEEP}") from None
    if node is None:
        return WrittenValue(None, origin)
    _check_depth(node, origin)
    return _without_line(from_node(node, origin, path, problems, {}), origin)


def _without_line(written: WrittenValue, origin: str) -> WrittenValue:
    """Return a value without line and column, which have no meaning on a command line."""
    value = written.value
    if isinstance(value, dict):
        value = {key: _without_line(item, origin) for key, item in value.items()}
    elif isinstance(value, list):
        value = [_without_line(item, origin) for item in value]
    return WrittenValue(value, origin)


def leaves(tree: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Yield dotted path and value of every entry in nested sections and lists."""
    for key, value in tree.items():
        if isinstance(value, dict):
            yield from leaves(value, f"{prefix}{key}.")
        elif isinstance(value, list):
            yield from ((f"{prefix}{key}.{index}", item) for index, item in enumerate(value))
        else:
            yield f"{prefix}{key}", value
