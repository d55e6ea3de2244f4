"""The JSON Schema of grid files, generated from the key table."""

import functools
import hashlib
import json
from collections import Counter
from typing import Any

from ...contracts.catalogue import ANY, Catalogue
from ...language import quantity
from ..keys import COUNT_WORDS, Flag, KeyTable, Name, NameList, Number, Section, Table, Word, has_keys_below
from ..keys.library_names import MATERIAL
from ..keys.outline import key_trees
from ..sections import AXES_OF_NAMES, NAME_SCHEMAS, QUANTITY_SCHEMA, entries_schema, single_key_schemas
from ..sections.axes import SAMPLE_SECTION
from ..sections.named_sections import FIGURES_SECTION, LIMITS_SECTION, ROLES_SECTION, UNCERTAIN_SECTION
from ..sections.variations import MAX_LABEL_LENGTH, RESERVED_LABELS
from ..written import EXTENDS
from ..written.definitions import DEFINE, DEFINE_TEXT
from ..written.law_files import LAWS, LAWS_TEXT

NAME_SECTIONS = (FIGURES_SECTION, LIMITS_SECTION, ROLES_SECTION, UNCERTAIN_SECTION)


SCHEMA_ID = "https://clearsweep.invalid/grid.schema.json"  # identifies the schema; it is no address
_LEAST_SHARED = 110  # characters of a part that is written once under `$defs`


def _merge(first: dict[str, Any], second: dict[str, Any]) -> dict[str, Any]:
    """Return a schema of what either of two schemas allows; of sections, key by key."""
    if first == second:
        return first
    if "enum" in first and "enum" in second and first.keys() - second.keys() <= {"description"}:
        return first | {"enum": list(dict.fromkeys([*first["enum"], *second["enum"]]))}
    if not (_is_section(first) and _is_section(second)):
        branches = [*first.get("anyOf", [first]), *second.get("anyOf", [second])]
        unique = {json.dumps(branch, sort_keys=True): branch for branch in branches}
        return {"anyOf": [*unique.values()]} if len(unique) > 1 else branches[0]
    properties = {}
    for key in {**first.get("properties", {}), **second.get("properties", {})}:
        of_key = [each.get("properties", {}).get(key, each.get("additionalProperties")) for each in (first, second)]
        properties[key] = functools.reduce(_merge, [part for part in of_key if isinstance(part, dict)])
    merged = first | {"properties": properties}
    required = [key for key in first.get("required", []) if key in second.get("required", [])]
    differing = {"required", "additionalProperties"} | (
        {"anyOf"} if first.get("anyOf") != second.get("anyOf") else set()
    )
    merged = {key: value for key, value in merged.items() if key not in differing}
    ends = (each.get("additionalProperties", True) for each in (first, second))
    open_ends = [end for end in ends if end is not False]
    if not open_ends:
        merged["additionalProperties"] = False
    elif True not in open_ends:
        merged["additionalProperties"] = functools.reduce(_merge, open_ends)
    return merged | ({"required": required} if required else {})


def _is_section(part: dict[str, Any]) -> bool:
    """Return whether a schema is that of a section; `anyOf` there only says which keys it needs."""
    has_keys = not {"properties", "additionalProperties"}.isdisjoint(part)
    return has_keys and all(set(branch) == {"required"} for branch in part.get("anyOf", []))


def _count_parts(part: Any) -> Counter[str]:
    """Return how often each part of a schema occurs, by its text."""
    children = part.values() if isinstance(part, dict) else part if isinstance(part, list) else ()
    counts = sum((_count_parts(child) for child in children), Counter[str]())
    if isinstance(part, dict):
        counts[json.dumps(part, sort_keys=True)] += 1
    return counts


def _share(part: Any, counts: Counter[str], definitions: dict[str, Any], *, is_schema: bool = True) -> Any:
    """Return a schema whose long repeated parts are references to `definitions`, which are filled."""
    if isinstance(part, list):
        return [_share(item, counts, definitions) for item in part]
    if not isinstance(part, dict):
        return part
    text = json.dumps(part, sort_keys=True)
    content = {
        key: _share(value, counts, definitions, is_schema=key not in ("properties", "$defs"))
        for key, value in part.items()
    }
    if not is_schema or counts[text] < 2 or len(text) < _LEAST_SHARED:
        return content
    name = f"part-{hashlib.sha256(text.encode()).hexdigest()[:8]}"
    definitions[name] = content
    return {"$ref": f"#/$defs/{name}"}


def schema(catalogue: Catalogue) -> dict[str, Any]:
    """Return the JSON Schema (2020-12) of grid files for editors: keys, words, units and descriptions.

    It allows what any mechanism allows; parts that occur often are written once, under `$defs`.
    """
    whole = whole_schema(catalogue)
    definitions: dict[str, Any] = {}
    parts = {key: value for key, value in whole.items() if key != "$defs"}
    shared = _share(parts, _count_parts(parts), definitions)
    return {**shared, "$defs": {**definitions, **whole["$defs"]}}


CASES_FILES = "a .csv, .xlsx or .parquet file"


def _cases_schema() -> dict[str, Any]:
    text = {"type": "string"}
    properties = {
        "table": text | {"description": CASES_FILES},
        "sheet": {"type": "integer", "minimum": 1, "description": "number of the sheet of a workbook"},
        "columns": {
            "type": "object",
            "additionalProperties": text,
            "description": "header -> dotted path, with a unit: joints.rod-slider.clearance [um]",
        },
        "label": text | {"description": "header of a column of texts that ride along"},
    }
    return {"type": "object", "required": ["table"], "additionalProperties": False, "properties": properties}


def whole_schema(catalogue: Catalogue) -> dict[str, Any]:
    """Return the schema with every part written out where it belongs."""

    def axes(text: str) -> dict[str, Any]:
        return {"description": f"dotted path -> values, {text}", **entries_schema({"$ref": "#/$defs/axis"})}

    schemas, text = [], {"type": "string"}
    for key_tree in key_trees(catalogue):
        mechanism_schema = _object_schema(key_tree.keys, "")
        mechanism_schema["properties"] |= {
            DEFINE: {"description": DEFINE_TEXT, **entries_schema(QUANTITY_SCHEMA)},
            "name": {"type": "string", "description": "name of the run; results/<name> by default"},
            EXTENDS: {"type": "string", "description": "grid file in the same folder whose values this one overrides"},
            LAWS: {"anyOf": [text, {"type": "array", "items": text, "minItems": 1}], "description": LAWS_TEXT},
            "sweep": axes("axes in all combinations"),
            "zip": axes("axes that vary together: each case takes the next value of each"),
            "cases": {"anyOf": [{"type": "string", "description": CASES_FILES}, _cases_schema(), axes("in step")]},
            SAMPLE_SECTION.name: SAMPLE_SECTION.schema,
            **{search.name: search.schema() for search in catalogue.searches},
            **{section.name: section.schema for section in NAME_SECTIONS},
        }
        mechanism_schema["properties"]["mechanism"]["properties"]["type"] = {"enum": [key_tree.mechanism]}
        schemas.append(mechanism_schema)
    merged = functools.reduce(_merge, schemas)
    pair_schema = {"type": "array", "minItems": 2, "maxItems": 2, "prefixItems": [QUANTITY_SCHEMA] * 2}
    spacing_schema = {"type": "array", "minItems": 3, "maxItems": 4}
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "$id": SCHEMA_ID,
        "title": "clearsweep grid",
        "type": "object",
        **merged,
        "$defs": {
            "quantity": {"anyOf": [{"type": "number"}, {"type": "string", "pattern": r"^\s*(=|[+-]?(\d|\.\d))"}]},
            "pair": pair_schema,
            "axis": {
                "anyOf": [
                    {"type": "array", "minItems": 1},
                    *AXES_OF_NAMES,
                    {
                        "type": "object",
                        "description": "label -> value",
                        "minProperties": 1,
                        "propertyNames": {"not": {"enum": list(RESERVED_LABELS)}, "maxLength": MAX_LABEL_LENGTH},
                        "additionalProperties": {"anyOf": [QUANTITY_SCHEMA, *NAME_SCHEMAS.values()]},
                    },
                    *single_key_schemas(dict.fromkeys(("linspace", "geomspace", "logspace"), spacing_schema)),
                ]
            },
        },
    }


def _object_schema(key_table: KeyTable, path: str) -> dict[str, Any]:
    """Return the schema of the section at `path`, '' for the whole file."""
    properties: dict[str, Any] = {}
    required: list[str] = []
    alternatives: list[list[str]] = []
    for nested, key in key_table.items():
        parent, _, key_name = nested.rpartition(".")
        if parent != path:
            continue
        if isinstance(key, Section):
            name, content = key_table.get(f"{nested}.{MATERIAL}"), _object_schema(key_table, nested)
            named = {"anyOf": [{"enum": list(name.options)}, content]} if isinstance(name, Name) else content
            of_section = {"description": key.text, **named}
            properties[key_name] = _list_schema(key_table, nested, key) if key.items else of_section
        elif isinstance(key, Word):
            has_free_names = any(ANY in option for option in key.options)  # the user chooses the keys
            properties[key_name] = {"description": key.text} | (
                {"enum": list(key.options)} if key.options and not has_free_names else {"type": "string"}
            )
            properties[key_name] |= {"default": key.default} if key.default and not has_free_names else {}
            if key.other_forms:
                properties[key_name]["anyOf"] = [{"enum": properties[key_name].pop("enum")}, *key.other_forms]
        elif isinstance(key, Name):
            options = [*key.options, *(int(option) for option in key.options if option.isdigit())]
            allowed = {"enum": options} if options else {"type": ["string", "number"]}
            properties[key_name] = {"description": key.text, **allowed}
        elif isinstance(key, Table):
            properties[key_name] = _table_schema(key)
        elif isinstance(key, NameList):
            names = {"type": "array", "items": {"type": "string"}, "minItems": 1}
            properties[key_name] = {"description": f"{key.text}; such as {key.example}", **names}
        elif isinstance(key, Flag):
            properties[key_name] = {"description": key.text, "type": "boolean", "default": bool(key.default)}
        else:
            schemas = [
                QUANTITY_SCHEMA,
                *(_object_schema(key_table, item) for item in (nested,) if has_keys_below(key_table, item)),
            ]
            schemas += [NAME_SCHEMAS[form] for form in {key_use.field.fit for key_use in key.uses} if form]
            value = {"anyOf": schemas} if schemas[1:] else schemas[0]
            properties[key_name] = {"description": _number_description(key), **value}
        if isinstance(key, Section) and key.need == "required" and key_name != ANY:
            required += [] if key.unless else [key_name]
            alternatives += [[key_name, key.unless]] if key.unless else []
    user_properties = {ANY: False} | properties  # every user-defined name has the schema of the placeholder
    object_schema = {"type": "object", "additionalProperties": user_properties.pop(ANY), "properties": user_properties}
    object_schema |= {"required": required} if required else {}
    for pair in alternatives:
        object_schema["anyOf"] = [{"required": [key_name]} for key_name in pair]
    return object_schema


def _list_schema(key_table: KeyTable, path: str, key: Section) -> dict[str, Any]:
    """Return the schema of a list of quantities or names, or of the single quantity that may replace it."""
    item_key, count = key_table[f"{path}.0"], key.items
    number = COUNT_WORDS[count]
    length_schema = {"type": "array", "minItems": count, "maxItems": count}
    if isinstance(item_key, Word):
        return {"description": f"{key.text}: {number} names", "items": {"type": "string"}} | length_schema
    assert isinstance(item_key, Number)
    description = {"description": f"{key.text}: {number} quantities ({item_key.uses[0].field.unit})"}
    quantity_schema = QUANTITY_SCHEMA
    list_schema = {"$ref": "#/$defs/pair"} if count == 2 else length_schema | {"prefixItems": [quantity_schema] * count}
    return description | ({"anyOf": [quantity_schema, list_schema]} if key.scalar_factors else list_schema)


def _table_schema(key: Table) -> dict[str, Any]:
    """Return the schema of a table: a file name, or columns."""
    independent_columns, dependent_columns = (
        ", ".join(f"{field.name} ({field.unit})" for field in fields) for fields in key.columns[2:4]
    )
    columns_schema = {"type": "object", "minProperties": 2, "additionalProperties": {"type": "array", "minItems": 2}}
    return {
        "description": f"{key.columns.text}; a .csv file or columns: {independent_columns.replace(', ', ' or ')}; "
        f"any of {dependent_columns}",
        "anyOf": [{"type": "string", "pattern": r"\.[cC][sS][vV]$"}, columns_schema],
    }


def _number_description(key: Number) -> str:
    """Return the description of a quantity, by law where it differs, with range, default and an example."""
    lines = []
    for field, when in key.uses:
        laws = f"{', '.join(sorted(when[-1][1]))}: " if when else ""
        default = "" if field.default is None else f"; default {field.default:.15g}"
        unit = quantity.replace_exponent(field.unit, 1.5)
        lines.append(f"{laws}{field.text}; {field.allowed()}{default}; such as {quantity.example_text(unit)}")
    return "\n".join(dict.fromkeys(lines))
