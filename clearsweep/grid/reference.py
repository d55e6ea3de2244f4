"""The keys of grid files as a page to read, made of the keys there are."""

from collections.abc import Iterator
from typing import NamedTuple

from ..contracts.catalogue import Catalogue, Field
from ..contracts.outline import ANY
from .axes import FORMS
from .fits import FORM
from .key_trees import key_trees
from .json_schema import schema
from .limit_keys import SECTIONS
from .keys import ITEMS, Flag, Name, Number, Section, Shape, Table, Word
from .sampling import DISTRIBUTIONS, METHODS
from .uncertain import UNCERTAIN

_NEED = {"required": "required", "optional": "may be left out", "implied": "may be left out where all has a default"}
_SEARCHES = ("seek", "refine", "optimise", "identify")
_HEAD = """\
# Keys of a grid file

<!-- written by `clearsweep schema --markdown`; a test compares -->

A grid file is YAML 1.2. Its keys depend on `mechanism.type`; `NAME` stands for a name that the grid chooses. A quantity
is text with a unit (`0.5 mm`, `5000 rpm`) or a bare number in the SI unit given here; any unit of the same dimension
will do. *Required* stands where a key has no default; a dash, where it may be left out. Every key can be swept, unless
it says that it cannot; of words, only the names of laws can. `clearsweep list NAME` says what a law does with its keys.
The same as a JSON Schema, for editors: `clearsweep schema`.
"""
_TABLE = "| key | unit | allowed | default | meaning |\n| --- | --- | --- | --- | --- |"


class _Row(NamedTuple):
    """One line of a table."""

    key: str
    unit: str
    allowed: str
    default: str
    text: str

    def __str__(self) -> str:
        cells = (f"`{self.key}`", self.unit, self.allowed, self.default, self.text)
        return f"| {' | '.join(cell.replace('|', '&#124;').replace('<', '&lt;') for cell in cells)} |"


def markdown(catalogue: Catalogue) -> str:
    """Return every key of a grid file with unit, range, default and meaning, as a page in Markdown."""
    parts = [_HEAD]
    written: dict[tuple[_Row, ...], tuple[str, str]] = {}
    for form in key_trees(catalogue):
        name = f"{form.mechanism}, spatial" if form.spatial else form.mechanism
        parts.append(f"## {name}\n")
        for title, section, rows in _blocks(form.keys):
            parts.append(f"### {title}\n\n{_sentence(section)}\n")
            where = written.setdefault(rows, (name, title))
            same = f"The same keys as in {where[1].partition(',')[0]} of {where[0]}.\n"
            parts.append(same if where != (name, title) else "\n".join((_TABLE, *map(str, rows))) + "\n")
    return "\n".join([*parts, _cases(catalogue)])


def _sentence(section: Section) -> str:
    """Return what a section is, and whether it is needed."""
    need = "" if "left out" in section.text else f"; {_NEED[section.need]}"
    form = f"; a list of {ITEMS[section.items]}" if section.items else ""
    form += " or one quantity" if section.alone else ""
    return f"{section.text[0].upper()}{section.text[1:]}{form}{need}."


def _blocks(tree: Shape) -> Iterator[tuple[str, Section, tuple[_Row, ...]]]:
    """Yield (title, section, rows) of each section; joints, which differ only in a few words, are one."""
    kinds: dict[tuple[str, ...], list[str]] = {}  # the sections within a joint -> joints
    for path in (path for path in tree if path.startswith("joints.") and path.count(".") == 1):
        inside = tuple(each.removeprefix(path) for each in tree if each.startswith(f"{path}."))
        kinds.setdefault(inside, []).append(path)
    first = {joints[0]: joints for joints in kinds.values()}
    others = tuple(f"{joint}." for joints in kinds.values() for joint in joints[1:])
    for path, node in tree.items():
        if not isinstance(node, Section) or f"{path}.".startswith(others):
            continue
        alike = {path: path}
        start = ".".join(path.split(".")[:2])
        if start in first:
            alike = {joint: path.replace(start, joint, 1) for joint in first[start]}
        rows = _merged({joint.rpartition(".")[2]: tuple(_rows(tree, section)) for joint, section in alike.items()})
        if rows:
            yield ", ".join(f"`{section}`" for section in alike.values()), node, rows


def _merged(tables: dict[str, tuple[_Row, ...]]) -> tuple[_Row, ...]:
    """Return the rows that several joints have in common; a cell in which they differ says so joint by joint."""
    merged = []
    for rows in zip(*tables.values(), strict=True):
        cells = []
        for values in zip(*rows, strict=True):
            each = "; ".join(f"{joint}: {value}" for joint, value in zip(tables, values, strict=True))
            cells.append(values[0] if len(set(values)) == 1 else each)
        merged.append(_Row(*cells))
    return tuple(merged)


def _rows(tree: Shape, path: str) -> Iterator[_Row]:
    """Yield the rows of the keys that stand directly in the section at `path`."""
    for inner, node in tree.items():
        parent, _, key = inner.rpartition(".")
        if isinstance(tree.get(parent), Number):  # a quantity, or a section in its place
            parent, _, above = parent.rpartition(".")
            key = f"{above}.{key}"
        if parent != path or isinstance(node, Section):
            continue
        if isinstance(node, Table):
            columns = "; ".join(f"`{field.name}` ({field.unit})" for field in node.columns[2] + node.columns[3])
            yield _Row(key, "", f"a .csv file with columns of {columns}", "-", f"{node.columns.text}; cannot be swept")
        elif isinstance(node, Name):
            yield _Row(key, "", "a name of a library", "-", f"{node.text}; cannot be swept")
        elif isinstance(node, Flag):
            default = "`true`" if node.default else "`false`"
            yield _Row(key, "", "`true`, `false`", default, f"{node.text}; cannot be swept")
        elif isinstance(node, Word):
            default = f"`{node.default}`" if node.default else "required"
            named = any(ANY in option for option in node.options)
            allowed = "a name" if named else ", ".join(f"`{option}`" for option in node.options)
            yield _Row(key, "", allowed, "-" if named else default, node.text)
        else:
            yield from _quantity(tree, inner, key, node)


def _quantity(tree: Shape, path: str, key: str, node: Number) -> Iterator[_Row]:
    """Yield one row for each meaning of a key that holds a quantity, with the laws for which it has that meaning."""
    meanings: dict[Field, list[str]] = {}
    elastic = tree.get(f"{'.'.join(path.split('.')[:2])}.contact.elastic")
    for field, when in node.uses:
        always = not when or (isinstance(elastic, Word) and when == elastic.when)
        meanings.setdefault(field, []).extend(() if always else sorted(when[-1][1]))
    for field, laws in meanings.items():
        default = "-" if field.optional else "required"
        default = default if field.default is None else f"{field.default:.15g}"
        names = ", ".join(f"`{law}`" for law in laws)
        fixed = "" if node.sweep else "; cannot be swept"
        allowed = field._replace(unit="1").allowed()
        unit = "" if field.unit == "1" else field.unit
        yield _Row(key, unit, allowed, default, f"{names}: {field.text}{fixed}" if laws else f"{field.text}{fixed}")


def _cases(catalogue: Catalogue) -> str:
    """Return the sections that choose cases."""
    top = schema(catalogue)
    while "else" in top:  # those of any mechanism
        top = top["else"]
    top = top["properties"]
    texts = {
        key: top[key].get("description", "")
        for key in ("name", "define", "sweep", "zip", "sample", *SECTIONS, UNCERTAIN, *_SEARCHES)
    }
    texts["cases"] = "a table next to the grid, .csv or .parquet: one path with its unit a column, one case a row"
    texts["name"] = texts["name"].replace("<name>", "NAME")
    rows = [
        f"| `{key}` | {texts[key]} |"
        for key in (
            "name",
            "define",
            "sweep",
            "zip",
            "cases",
            "sample",
            *SECTIONS,
            UNCERTAIN,
            "seek",
            "refine",
            "optimise",
            "identify",
        )
    ]
    axes = [f"| `{kind}` | {form} |" for kind, form in FORMS.items()]
    axes.append("| `fits` | [H7/g6, H7/f7], of a radial clearance: the means of fits of ISO 286 |")
    methods = [f"| `{name}` | {text} |" for name, text in METHODS.items()]
    kinds = [f"| `{name}` | {text} |" for name, text in DISTRIBUTIONS.items()]
    kinds.append(f"| `fit` | {FORM}, of a radial clearance: between the limits of a fit |")
    sample = [
        "| `method` | one of the designs below |",
        "| `n` | a whole number, at least 2: how many points |",
        "| `seed` | a whole number, at least 0, default 0: the same seed gives the same cases |",
        "| `over` | dotted path -> distribution |",
    ]
    return "\n".join(
        [
            "## Choosing cases\n",
            "| key | meaning |\n| --- | --- |",
            *rows,
            "\nAn axis is a list of values, or one of",
            "\n| form | holds |\n| --- | --- |",
            *axes,
            *_searches(),
            "\n### `sample`\n",
            "| key | meaning |\n| --- | --- |",
            *sample,
            "\n| design | what it draws |\n| --- | --- |",
            *methods,
            "\n| distribution | holds |\n| --- | --- |",
            *kinds,
            "",
        ]
    )


def _searches() -> list[str]:
    """Return the sections that add cases, line by line."""
    row = "| `added` | nothing that is written: run.json keeps the cases here that a run added |"
    seek = [
        "| `largest` | the dotted path whose largest value is sought, or several that take the same value |",
        "| `smallest` | or the path whose smallest value is sought |",
        "| `between` | [low, high]: the range to look in |",
        "| `within` | how close the answer has to be, at most a quarter of the range |",
        "| `among` | {fits: [H7/g6, H7/f7]} in place of both: each fit is judged at its largest clearance |",
        "| `meeting` | `limits`, the default |",
        "| `for` | `each` case of the other axes, the default, or `all`: the worst of them |",
        row,
    ]
    refine = [
        "| `along` | `limits`, the default: whose border the further cases follow |",
        "| `cases` | a whole number, at least 1: how many there may be |",
        row,
    ]
    optimise = [
        "| `over` | dotted path -> [low, high], {among: [a, b, ...]} (words, fits, numbers) or {whole: [low, high]} |",
        "| `minimise` | the column, or columns, to make small |",
        "| `maximise` | the column, or columns, to make large |",
        "| `cases` | a whole number, at least 1: how many there may be |",
        "| `seed` | a whole number, at least 0, default 0, of the sampler |",
        row,
    ]
    identify = [
        "| `over` | dotted path -> [low, high], the range of its prior |",
        "| `from` | CSV file beside the grid -> {channel: column}, of what was measured |",
        "| `cases` | a whole number, at least 16: how many there may be |",
        "| `features` | a list of rms, peaks, spectrum, impacts; default all of them |",
        "| `seed` | a whole number, at least 0, default 0, of what is drawn |",
        row,
    ]
    lines = []
    for name, rows in (("seek", seek), ("refine", refine), ("optimise", optimise), ("identify", identify)):
        lines += [f"\n### `{name}`\n", "| key | meaning |\n| --- | --- |", *rows]
    return lines
