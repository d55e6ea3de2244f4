"""The JSON Schema of grid files, generated from the key table."""

from typing import Any

from ...contracts.catalogue import Catalogue
from ...contracts.outline import ANY
from ...judging.verdict import KINDS
from ...language import quantity
from ..keys.kinds import ITEMS, Flag, Name, NameList, Number, Section, Shape, Table, Word
from ..keys.outline import key_trees
from ..library.naming import MATERIAL
from ..sections.added_cases import ADDED, CHECK_LAWS, CHECK_LAWS_TEXT
from ..sections.distributions import forms
from ..sections.fits import SPREADS
from ..sections.identify import FEATURES, IDENTIFY
from ..sections.optimise import AMONG, SENSES, WHOLE
from ..sections.sample import METHODS
from ..sections.seek import REFINE_ALONG, SEEK_ENDS, SEEK_FOR
from ..sections.uncertain import FACTOR, LARGEST_FACTOR, PUBLISHED, UNCERTAIN, UNCERTAIN_TEXT
from ..sections.variations import LONGEST, RESERVED
from ..written.definitions import DEFINE, DEFINE_TEXT

_ADDED = {"type": "object", "description": "cases added before, as run.json keeps them"}
_CHECKED = {"type": "object", "additionalProperties": False, "properties": {ADDED: _ADDED}}
_NAME = {"fit": {"type": "string", "description": "a clearance fit of ISO 286, such as H7/f7"}}
_FIT: dict[str, Any] = {
    "type": "object",
    "required": ["fit"],
    "additionalProperties": False,
    "properties": _NAME,
}
_FITS = {
    "type": "object",
    "required": ["fits"],
    "additionalProperties": False,
    "properties": {"fits": {"type": "array", "minItems": 1, "items": {"type": "string"}}},
}

_FIGURES = {
    "description": "name -> expression of columns of summary.parquet: a figure of your own",
    "type": "object",
    "minProperties": 1,
    "additionalProperties": {"type": "string"},
}


def schema(catalogue: Catalogue) -> dict[str, Any]:
    """Return the JSON Schema (2020-12) of grid files for editors: keys, words, units and descriptions."""

    def axes(text: str) -> dict[str, Any]:
        return {
            "description": f"dotted path -> values, {text}",
            "type": "object",
            "minProperties": 1,
            "additionalProperties": {"$ref": "#/$defs/axis"},
        }

    schemas = []
    for form in key_trees(catalogue):
        top = _object(form.keys, "")
        top["properties"] |= {
            DEFINE: {
                "description": DEFINE_TEXT,
                "type": "object",
                "minProperties": 1,
                "additionalProperties": {"$ref": "#/$defs/quantity"},
            },
            "name": {"type": "string", "description": "name of the run; results/<name> by default"},
            "sweep": axes("each by each: the cases are the product"),
            "zip": axes("in step: case after case takes the next value of each"),
            "cases": {"anyOf": [{"type": "string", "description": "a .csv or .parquet file"}, axes("in step")]},
            "sample": _sample(),
            "figures": _FIGURES,
            "limits": {
                "description": "figure (a column of summary.parquet) -> the largest value that is acceptable, or "
                "{at_most or at_least: value, times: another figure}",
                "type": "object",
                "minProperties": 1,
                "additionalProperties": {"anyOf": [{"$ref": "#/$defs/quantity"}, _bounds()]},
            },
            UNCERTAIN: _uncertain(),
            "seek": _seek(),
            "refine": _refine(),
            CHECK_LAWS: {"description": CHECK_LAWS_TEXT, "anyOf": [{"type": "boolean"}, _CHECKED]},
            "optimise": _optimise(),
            IDENTIFY: _identify(),
        }
        chosen_by = {"type": form.mechanism} | ({"spatial": True} if form.spatial else {})
        for key, value in chosen_by.items():
            top["properties"]["mechanism"]["properties"][key] = {"const": value}
        schemas.append((top, chosen_by))
    chosen = schemas[0][0]  # editors offer these keys before a type is written
    for top, chosen_by in schemas[1:]:
        fixed = {key: {"const": value} for key, value in chosen_by.items()}
        kind = {"required": [*fixed], "properties": fixed}
        chosen = {"if": {"required": ["mechanism"], "properties": {"mechanism": kind}}, "then": top, "else": chosen}
    quantities = {"type": "array", "minItems": 2, "maxItems": 2, "prefixItems": [{"$ref": "#/$defs/quantity"}] * 2}
    spaced = {"type": "array", "minItems": 3, "maxItems": 4}
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "clearsweep grid",
        "type": "object",
        **chosen,
        "$defs": {
            "quantity": {"anyOf": [{"type": "number"}, {"type": "string", "pattern": r"^\s*(=|[+-]?(\d|\.\d))"}]},
            "pair": quantities,
            "axis": {
                "anyOf": [
                    {"type": "array", "minItems": 1},
                    _FITS,
                    _labels(),
                    *(
                        {
                            "type": "object",
                            "required": [name],
                            "additionalProperties": False,
                            "properties": {name: spaced},
                        }
                        for name in ("linspace", "geomspace", "logspace")
                    ),
                ]
            },
        },
    }


def _labels() -> dict[str, Any]:
    """Return the schema of an axis whose values have labels."""
    return {
        "type": "object",
        "description": "label -> value",
        "minProperties": 1,
        "propertyNames": {"not": {"enum": list(RESERVED)}, "maxLength": LONGEST},
        "additionalProperties": {"anyOf": [{"$ref": "#/$defs/quantity"}, _FIT]},
    }


def _bounds() -> dict[str, Any]:
    """Return the schema of a limit written as a section."""
    properties = {kind: {"$ref": "#/$defs/quantity"} for kind in KINDS} | {"times": {"type": "string"}}
    return {"type": "object", "properties": properties, "additionalProperties": False, "minProperties": 1}


def _uncertain() -> dict[str, Any]:
    """Return the schema of the section `uncertain`."""
    factor = {"type": "number", "exclusiveMinimum": 1, "maximum": LARGEST_FACTOR}
    kinds = [
        {"type": "object", "required": [kind], "additionalProperties": False, "properties": {kind: form}}
        for kind, form in ((FACTOR, factor), *((kind, {"description": form}) for kind, form in forms().items()))
    ]
    return {
        "description": UNCERTAIN_TEXT,
        "type": "object",
        "minProperties": 1,
        "additionalProperties": {"anyOf": [*kinds, {"const": PUBLISHED}]},
    }


def _seek() -> dict[str, Any]:
    """Return the schema of the section `seek`."""
    size = {"$ref": "#/$defs/quantity"}
    return {
        "description": "the largest or smallest value of one key with which cases keep to `limits`",
        "type": "object",
        "anyOf": [{"required": ["between", "within"]}, {"required": ["among"]}],
        "oneOf": [{"required": [sense]} for sense in SEEK_ENDS],
        "additionalProperties": False,
        "properties": {
            **{
                sense: {
                    "anyOf": [{"type": "string"}, {"type": "array", "minItems": 1, "items": {"type": "string"}}],
                    "description": f"dotted path, or several in step: the {sense} value is to be found",
                }
                for sense in SEEK_ENDS
            },
            "among": _FITS | {"description": "clearance fits; each is judged at its largest clearance"},
            "between": {"type": "array", "items": size, "minItems": 2, "maxItems": 2},
            "within": size,
            "meeting": {"enum": ["limits"]},
            "for": {"enum": list(SEEK_FOR)},
            ADDED: _ADDED,
        },
    }


def _optimise() -> dict[str, Any]:
    """Return the schema of the section `optimise`."""
    pair = {"type": "array", "minItems": 2, "maxItems": 2}
    among = {"anyOf": [{"type": "array", "minItems": 1}, _FITS]}
    kinds = [
        {"type": "object", "required": [kind], "additionalProperties": False, "properties": {kind: form}}
        for kind, form in ((AMONG, among), (WHOLE, pair))
    ]
    columns = {"anyOf": [{"type": "string"}, {"type": "array", "minItems": 1, "items": {"type": "string"}}]}
    return {
        "description": "values that minimise or maximise columns of summary.parquet within `limits`",
        "type": "object",
        "required": ["over", "cases"],
        "anyOf": [{"required": [sense]} for sense in SENSES],
        "additionalProperties": False,
        "properties": {
            "over": {"type": "object", "minProperties": 1, "additionalProperties": {"anyOf": [pair, *kinds]}},
            **{sense: columns | {"description": f"columns or own figures to {sense}"} for sense in SENSES},
            "cases": {"type": "integer", "minimum": 1, "description": "how many there may be"},
            "seed": {"type": "integer", "minimum": 0, "description": "of the sampler, default 0"},
            ADDED: _ADDED,
        },
    }


def _identify() -> dict[str, Any]:
    """Return the schema of the section `identify`."""
    pair = {"type": "array", "minItems": 2, "maxItems": 2}
    columns = {"type": "object", "minProperties": 1, "additionalProperties": {"type": "string"}}
    return {
        "description": "values of keys that reproduce measured signals",
        "type": "object",
        "required": ["over", "from", "cases"],
        "additionalProperties": False,
        "properties": {
            "over": {"type": "object", "minProperties": 1, "additionalProperties": pair},
            "from": columns | {"additionalProperties": columns, "description": "file -> channel -> column of the file"},
            "cases": {"type": "integer", "minimum": 16, "description": "how many there may be"},
            "features": {"type": "array", "minItems": 1, "items": {"enum": list(FEATURES)}},
            "seed": {"type": "integer", "minimum": 0, "description": "seed of the random sample; default 0"},
            ADDED: _ADDED,
        },
    }


def _refine() -> dict[str, Any]:
    """Return the schema of the section `refine`."""
    return {
        "description": "further cases between those of `sweep`, where the border of `limits` runs",
        "type": "object",
        "required": ["cases"],
        "additionalProperties": False,
        "properties": {
            "along": {"enum": [REFINE_ALONG], "description": "what border they follow"},
            "cases": {"type": "integer", "minimum": 1, "description": "how many there may be"},
            ADDED: _ADDED,
        },
    }


def _sample() -> dict[str, Any]:
    """Return the schema of the section `sample`."""
    whole_number = {"type": "integer", "minimum": 0}
    kinds = [
        {"type": "object", "required": [kind], "properties": {kind: {"description": form}}}
        for kind, form in forms().items()
    ]
    spread = {"distribution": {"enum": list(SPREADS), "default": "uniform"}}
    kinds.append(_FIT | {"properties": _NAME | spread})
    return {
        "description": "cases drawn from distributions",
        "type": "object",
        "required": ["method", "over"],
        "additionalProperties": False,
        "properties": {
            "method": {"enum": list(METHODS), "description": "; ".join(map(": ".join, METHODS.items()))},
            "n": whole_number | {"minimum": 2},
            "seed": whole_number,
            "over": {"type": "object", "minProperties": 1, "additionalProperties": {"anyOf": kinds}},
            "drawn": {"type": "object", "description": "values drawn before, as run.json keeps them"},
        },
    }


def _object(tree: Shape, path: str) -> dict[str, Any]:
    """Return the schema of the section at `path`, '' for the whole file."""
    properties: dict[str, Any] = {}
    required: list[str] = []
    alternatives: list[list[str]] = []
    for nested, node in tree.items():
        parent, _, key = nested.rpartition(".")
        if parent != path:
            continue
        if isinstance(node, Section):
            properties[key] = _items(tree, nested, node) if node.items else _section(tree, nested, node)
        elif isinstance(node, Word):
            has_free_names = any(ANY in option for option in node.options)  # the user chooses the keys
            properties[key] = {"description": node.text} | (
                {"type": "string"} if has_free_names else {"enum": list(node.options)}
            )
            properties[key] |= {"default": node.default} if node.default and not has_free_names else {}
        elif isinstance(node, Name):
            properties[key] = {"description": node.text, "enum": list(node.options)}
        elif isinstance(node, Table):
            properties[key] = _table(node)
        elif isinstance(node, NameList):
            names = {"type": "array", "items": {"type": "string"}, "minItems": 1}
            properties[key] = {"description": f"{node.text}; such as {node.example}", **names}
        elif isinstance(node, Flag):
            properties[key] = {"description": node.text, "type": "boolean", "default": bool(node.default)}
        else:
            key_trees = [
                {"$ref": "#/$defs/quantity"},
                *(_object(tree, item) for item in (nested,) if _has_keys_below(tree, item)),
            ]
            key_trees += [_FIT] if any(key_use.field.fit for key_use in node.uses) else []
            value = {"anyOf": key_trees} if key_trees[1:] else key_trees[0]
            properties[key] = {"description": _described(node), **value}
        if isinstance(node, Section) and node.need == "required" and key != ANY:
            required += [] if node.unless else [key]
            alternatives += [[key, node.unless]] if node.unless else []
    properties_of = {ANY: False} | properties  # every user-defined name has the schema of the placeholder
    object_schema = {"type": "object", "additionalProperties": properties_of.pop(ANY), "properties": properties_of}
    object_schema |= {"required": required} if required else {}
    for pair in alternatives:
        object_schema["anyOf"] = [{"required": [key]} for key in pair]
    return object_schema


def _has_keys_below(tree: Shape, path: str) -> bool:
    """Return whether there are keys below `path`."""
    return any(nested.rpartition(".")[0] == path for nested in tree)


def _section(tree: Shape, path: str, node: Section) -> dict[str, Any]:
    complete, name = _object(tree, path), tree.get(f"{path}.{MATERIAL}")
    if isinstance(name, Name):
        return {"description": node.text, "anyOf": [{"enum": list(name.options)}, complete]}
    return {"description": node.text, **complete}


def _items(tree: Shape, path: str, node: Section) -> dict[str, Any]:
    """Return the schema of a list of quantities or names, or of the single quantity that may replace it."""
    item_key, count = tree[f"{path}.0"], node.items
    number = ITEMS[count]
    size = {"type": "array", "minItems": count, "maxItems": count}
    if isinstance(item_key, Word):
        return {"description": f"{node.text}: {number} names", "items": {"type": "string"}} | size
    assert isinstance(item_key, Number)
    described = {"description": f"{node.text}: {number} quantities ({item_key.uses[0].field.unit})"}
    if count == 2:
        return described | {"$ref": "#/$defs/pair"}
    quantity_of = {"$ref": "#/$defs/quantity"}
    sized = size | {"prefixItems": [quantity_of] * count}
    return described | ({"anyOf": [quantity_of, sized]} if node.alone else sized)


def _table(node: Table) -> dict[str, Any]:
    """Return the schema of a table: a file name, or columns."""
    over, values = (", ".join(f"{field.name} ({field.unit})" for field in fields) for fields in node.columns[2:4])
    lists = {"type": "object", "minProperties": 2, "additionalProperties": {"type": "array", "minItems": 2}}
    return {
        "description": f"{node.columns.text}; a .csv file or columns: {over.replace(', ', ' or ')}; any of {values}",
        "anyOf": [{"type": "string", "pattern": r"\.[cC][sS][vV]$"}, lists],
    }


def _described(node: Number) -> str:
    """Return the description of a quantity, by law where it differs, with range, default and an example."""
    lines = []
    for field, when in node.uses:
        laws = f"{', '.join(sorted(when[-1][1]))}: " if when else ""
        default = "" if field.default is None else f"; default {field.default:.15g}"
        unit = quantity.exponent_of(field.unit, 1.5)
        lines.append(f"{laws}{field.text}; {field.allowed()}{default}; {quantity.expected(unit)}")
    return "\n".join(dict.fromkeys(lines))
