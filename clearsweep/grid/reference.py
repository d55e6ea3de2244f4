"""The keys of grid files as a page to read, made of the keys there are."""

from collections.abc import Collection, Iterable, Iterator, Mapping
from typing import Any, NamedTuple

from ..contracts.catalogue import Catalogue, Field
from ..contracts.outline import ANY
from .axes import FORMS
from .fits import FORM
from .json_schema import schema
from .key_trees import KeyTree, key_trees
from .keys import ITEMS, Flag, Name, Number, Section, Shape, Table, Word
from .limit_keys import SECTIONS
from .sampling import DISTRIBUTIONS, METHODS
from .uncertain import UNCERTAIN

_NEED = {"required": "required", "optional": "may be left out", "implied": "may be left out where all has a default"}
_SEARCHES = ("seek", "refine", "optimise", "identify")
_HEAD = """\
# Keys of a grid file

<!-- written by `clearsweep schema --markdown`; a test compares -->

A grid file is YAML 1.2. Its keys depend on `mechanism.type`; `NAME` represents a name that the grid chooses. A quantity
is text with a unit (`0.5 mm`, `5000 rpm`) or a bare number in the SI unit given here; any unit of the same dimension
will do. *Required* means that a key has no default, a dash that it may be left out. Every key can be swept, unless it
says that it cannot; of words, only the names of laws can. `clearsweep list NAME` says what a law does with its keys.
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
    laws: tuple[str, ...] = ()  # those for which the key has this meaning; none: whatever the law
    options: tuple[str, ...] = ()  # words that are allowed

    def __str__(self) -> str:
        cells = (f"`{self.key}`", self.unit, self.allowed or _quoted(self.options), self.default, self.text)
        return f"| {' | '.join(cell.replace('|', '&#124;').replace('<', '&lt;') for cell in cells)} |"


def _quoted(words: Iterable[str]) -> str:
    """Return words one after the other, as code."""
    return ", ".join(f"`{word}`" for word in words)


class _Where(NamedTuple):
    """Whose grids have a section: a mechanism, in the plane or in space; of joints also which of them."""

    mechanism: str
    spatial: bool
    joints: tuple[str, ...] = ()

    def name(self) -> str:
        """Return the title of the mechanism."""
        return f"{self.mechanism} in space" if self.spatial else self.mechanism


_Places = dict[_Where, tuple[Section, tuple[_Row, ...]]]


def markdown(catalogue: Catalogue) -> str:
    """Return every key of a grid file with unit, range, default and meaning, as a page in Markdown.

    A section that several mechanisms or joints have is there once; a row says which of them has it, unless all have.
    """
    sections: dict[str, _Places] = {}
    for tree in key_trees(catalogue):
        for path, where, section, rows in _sections(tree):
            if rows:
                sections.setdefault(path, {})[where] = section, rows
    alike: dict[tuple[_Row, ...], list[str]] = {}
    tops = list(dict.fromkeys(path.partition(".")[0] for path in sections))
    for path, places in sorted(sections.items(), key=lambda item: tops.index(item[0].partition(".")[0])):
        alike.setdefault(tuple(_together(places)), []).append(path)
    parts = [_HEAD, *_overview(sections)]
    for rows, paths in alike.items():
        texts = dict.fromkeys(_sentences(sections[path]) for path in paths)
        parts += [f"## {_quoted(paths)}\n", " ".join(texts) + "\n", _TABLE, *map(str, rows), ""]
    return "\n".join([*parts, _cases(catalogue)])


def _sections(tree: KeyTree) -> Iterator[tuple[str, _Where, Section, tuple[_Row, ...]]]:
    """Yield (path, where, section, rows) of each section; joints with the same sections inside are one, called NAME."""
    kinds: dict[tuple[str, ...], list[str]] = {}  # the sections within a joint -> joints
    for joint in (path for path in tree.keys if path.startswith("joints.") and path.count(".") == 1):
        inside = tuple(each.removeprefix(joint) for each in tree.keys if each.startswith(f"{joint}."))
        kinds.setdefault(inside, []).append(joint)
    for path, node in tree.keys.items():
        if not isinstance(node, Section):
            continue
        if not path.startswith("joints."):
            yield path, _Where(tree.mechanism, tree.spatial), node, tuple(_rows(tree.keys, path))
            continue
        joint = ".".join(path.split(".")[:2])
        alike = next(joints for joints in kinds.values() if joint in joints)
        if joint == alike[0]:
            names = tuple(each.removeprefix("joints.") for each in alike)
            tables = {name: tuple(_rows(tree.keys, path.replace(joint, f"joints.{name}", 1))) for name in names}
            where = _Where(tree.mechanism, tree.spatial, names if len(kinds) > 1 else ())
            yield path.replace(joint, f"joints.{ANY}", 1), where, node, _merged(tables)


def _overview(sections: Mapping[str, _Places]) -> Iterator[str]:
    """Yield a table of the mechanisms and of the sections that describe their bodies."""
    yield "| mechanism | its own sections |\n| --- | --- |"
    names = list(dict.fromkeys(where.name() for places in sections.values() for where in places))
    for name in names:
        own = [path for path, places in sections.items() if name in {where.name() for where in places}]
        listed = _quoted(path for path in own if path.startswith("mechanism."))
        yield f"| {name} | {listed} |"
    yield ""


def _together(places: _Places) -> Iterator[_Row]:
    """Yield the rows of a section; those that only some of its mechanisms or joints have say which.

    Rows that differ in laws or options alone are one: which laws a joint can have is in the row of `law`.
    """
    rows: dict[_Row, dict[_Where, _Row]] = {}
    for where, (_, own) in places.items():
        for row in own:
            rows.setdefault(row._replace(laws=(), options=()), {})[where] = row
    order, known = list(dict.fromkeys(row.key for row in rows)), tuple[str, ...]()
    for row, owners in sorted(rows.items(), key=lambda item: order.index(item[0].key)):
        laws = tuple(dict.fromkeys(law for each in owners.values() for law in each.laws))
        options = tuple(dict.fromkeys(word for each in owners.values() for word in each.options))
        known = options if row.key == "law" else known
        text = f"{_laws(laws, known)}: {row.text}" if laws else row.text
        lacking: dict[tuple[str, ...], list[_Where]] = {}
        for where, each in owners.items():
            lacking.setdefault(tuple(word for word in options if word not in each.options), []).append(where)
        for words, those in lacking.items():
            text += f"; {_only(those, owners)}: without {_quoted(words)}" if words else ""
        only = _only(owners, places)
        yield row._replace(text=f"*{only}*: {text}" if only else text, options=options)


def _laws(own: Collection[str], known: Collection[str]) -> str:
    """Return the names of laws; where most of a section's have something, of those that have not."""
    others = [name for name in known if name not in own]
    return f"all but {_quoted(others)}" if 0 < len(others) < len(own) / 2 and {*own} <= {*known} else _quoted(own)


def _only(owners: Collection[_Where], places: Collection[_Where]) -> str:
    """Return which of several have something, in words; nothing, where all have it."""
    if len(owners) == len(places):
        return ""
    for spatial, text in ((True, "in space"), (False, "in the plane")):
        if set(owners) == {where for where in places if where.spatial == spatial}:
            return text
    others = [where for where in places if where not in owners]
    return f"not {_named(others, places)}" if len(others) < len(owners) else _named(owners, places)


def _named(owners: Collection[_Where], places: Collection[_Where]) -> str:
    """Return the names of the mechanisms and, where it is only some of their joints, of these."""
    words = []
    for name in dict.fromkeys(where.name() for where in owners):
        own, every = ([where for where in those if where.name() == name] for those in (owners, places))
        joints = "" if len(own) == len(every) else f" ({', '.join(joint for where in own for joint in where.joints)})"
        words.append(f"{name}{joints}")
    return ", ".join(words)


def _sentences(places: _Places) -> str:
    """Return what a section is, and whether it is needed; where that differs, for whom."""
    texts: dict[str, list[_Where]] = {}
    for where, (section, _) in places.items():
        texts.setdefault(_sentence(section), []).append(where)
    return " ".join(f"{text[:-1]} ({only})." if (only := _only(own, places)) else text for text, own in texts.items())


def _sentence(section: Section) -> str:
    """Return what a section is, and whether it is needed."""
    need = "" if "left out" in section.text else f"; {_NEED[section.need]}"
    form = f"; a list of {ITEMS[section.items]}" if section.items else ""
    form += " or one quantity" if section.alone else ""
    return f"{section.text[0].upper()}{section.text[1:]}{form}{need}."


def _merged(tables: dict[str, tuple[_Row, ...]]) -> tuple[_Row, ...]:
    """Return the rows that several joints have in common; a cell in which they differ says so joint by joint."""
    merged = []
    for rows in zip(*tables.values(), strict=True):
        cells: list[Any] = []
        for values in zip(*rows, strict=True):
            each = "; ".join(
                f"{joint}: {_quoted(value) if isinstance(value, tuple) else value}"
                for joint, value in zip(tables, values, strict=True)
            )
            cells.append(values[0] if len(set(values)) == 1 else each)
        row = _Row(*cells)
        merged.append(row if isinstance(row.options, tuple) else row._replace(allowed=row.options, options=()))
    return tuple(merged)


def _rows(tree: Shape, path: str) -> Iterator[_Row]:
    """Yield the rows of the keys that are directly in the section at `path`."""
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
            options = () if named else tuple(filter(None, node.options))
            yield _Row(
                key,
                "",
                "a name" if named or not any(options) else "",
                "-" if named else default,
                node.text,
                options=options,
            )
        else:
            yield from _quantity(tree, inner, key, node)


def _quantity(tree: Shape, path: str, key: str, node: Number) -> Iterator[_Row]:
    """Yield one row for each meaning of a key that contains a quantity, with the laws for which it has that meaning."""
    meanings: dict[Field, list[str]] = {}
    elastic = tree.get(f"{'.'.join(path.split('.')[:2])}.contact.elastic")
    for field, when in node.uses:
        always = not when or (isinstance(elastic, Word) and when == elastic.when)
        meanings.setdefault(field, []).extend(() if always else sorted(when[-1][1]))
    for field, laws in meanings.items():
        default = "-" if field.optional else "required"
        default = default if field.default is None else f"{field.default:.15g}"
        fixed = "" if node.sweep else "; cannot be swept"
        allowed = field._replace(unit="1").allowed()
        unit = "" if field.unit == "1" else field.unit
        yield _Row(key, unit, allowed, default, f"{field.text}{fixed}", tuple(laws))


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
            "\n| form | contains |\n| --- | --- |",
            *axes,
            *_searches(),
            "\n### `sample`\n",
            "| key | meaning |\n| --- | --- |",
            *sample,
            "\n| design | what it draws |\n| --- | --- |",
            *methods,
            "\n| distribution | contains |\n| --- | --- |",
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
        "| `from` | CSV file next to the grid -> {channel: column}, of what was measured |",
        "| `cases` | a whole number, at least 16: how many there may be |",
        "| `features` | a list of rms, peaks, spectrum, impacts; default all of them |",
        "| `seed` | a whole number, at least 0, default 0, of what is drawn |",
        row,
    ]
    lines = []
    for name, rows in (("seek", seek), ("refine", refine), ("optimise", optimise), ("identify", identify)):
        lines += [f"\n### `{name}`\n", "| key | meaning |\n| --- | --- |", *rows]
    return lines
