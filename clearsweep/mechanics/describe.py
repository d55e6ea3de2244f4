"""Texts that `clearsweep list` prints."""

import math
import textwrap
from collections.abc import Iterable

from ..contracts.case import Contact, Joint, Material, Materials
from ..contracts.catalogue import Columns, Field, Law
from .laws.contract import RECIPES, Recipe
from .laws.elastic import elastic_force
from .machines import MECHANISMS
from .machines.drives import DRIVES
from .machines.loads import LOADS

WIDTH = 100  # characters of a line
RESTITUTIONS = (0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 0.99)
STEEL = Material(207e9, 0.3)
DEPTHS = (0.1e-6, 1e-6, 5e-6, 10e-6, 20e-6)  # m
#: The joint for which forces are shown: a steel pin in a steel bearing.
REFERENCE = Joint(
    "rod-slider",
    clearance=0.5e-3,
    contact=Contact("hertz", "power", {"thickness": 5e-3}, Materials(STEEL, STEEL)),
    bearing_radius=10e-3,
    length=20e-3,
)
_REFERENCE_TEXT = "steel, 207 GPa, 0.3; bearing radius 10 mm, clearance 0.5 mm, length 20 mm"
ONSET = (
    "onset: first or renewed, how long the onset rate counts: to the end of the contact, or until it has proved "
    "lasting; default renewed"
)
KEYS = {
    "mechanism": "mechanism.type",
    "drive": "drive",
    "load": "loads",
    "motor": "drive.motor.law",
    "law": "contact.law",
    "elastic": "contact.elastic",
    "roughness": "roughness.law",
    "friction": "friction.law",
    "wear": "wear.law",
    "pressure": "wear.pressure",
    "film": "film.law",
    "film-friction": "film.friction",
    "transition": "film.transition.law",
    "profile": "profile.law",
    "figure": "figures.NAME.law",
}


def law_text(name: str | None = None) -> str:
    """Return the description of the laws called `name`, or '' if there are none.

    Without a name, one line for each law.
    """
    descriptions = _all_descriptions()
    if name is not None:
        return "\n\n".join(text_of(law) for law in descriptions if law.name == name)
    blocks, width = [], max(len(law.name) for law in descriptions)
    for family, key in KEYS.items():
        lines = [f"  {law.name:{width}}  {law.summary}" for law in descriptions if law.family == family]
        blocks += ["\n".join([key, *lines])] if lines else []  # of motors and figures there are only own ones
    return "\n\n".join(blocks)


def law_names() -> tuple[str, ...]:
    """Return all names that `law_text` accepts."""
    return tuple(dict.fromkeys(law.name for law in _all_descriptions()))


def _all_descriptions() -> tuple[Law, ...]:
    """Return the mechanisms, drives, loads and all laws."""
    mechanisms = (mechanism.law for mechanism in MECHANISMS.values())
    return (*mechanisms, *DRIVES.values(), *LOADS.values(), *(recipe.law for recipe in RECIPES.values()))


def own_laws_text(laws: Iterable[Law]) -> str:
    """Return a line for each law of one's own, with its place, or '' if there are none."""
    rows = [f"  {KEYS[law.family]}: {law.name}  {law.summary} ({law.origin})" for law in laws]
    return "\n".join(["laws of one's own", *rows]) if rows else ""


def text_of(law: Law) -> str:
    """Return the description of a law, of the package or of one's own."""
    recipe = RECIPES.get((law.family, law.name))  # None of a mechanism, a drive or a load, and of a law of one's own
    blocks = [f"{KEYS[law.family]}: {law.name}\n{_wrapped('  ', law.summary)}", _wrapped("  ", law.formula)]
    blocks += [f"unit: {law.unit}"] if law.unit else []
    if law.fields or law.needs or law.tables:
        onset = [_wrapped("  ", ONSET)] if law.uses_onset else []
        blocks.append(
            "\n".join(
                [
                    "parameters",
                    *map(_parameter_text, law.fields),
                    *map(_table_key_text, law.tables),
                    *map(_need_text, law.needs),
                    *onset,
                ]
            )
        )
    ranges = [f"{limit.path} {limit.allowed()}: {limit.reason}" for limit in (*law.ranges, *law.trusted) if limit.high]
    objections = [limit.reason for limit in law.trusted if not limit.high] + ([law.unsound] if law.unsound else [])
    for heading, lines in (("valid for", ranges), ("against it", objections)):
        if lines:
            blocks.append("\n".join([heading, *(_wrapped("  ", line) for line in lines)]))
    if law.family == "elastic" and recipe:
        kind = f"of a {law.contact}" if law.contact else "not assessed"
        blocks.append(f"first yield: {kind}")
    if law.source:
        blocks.append(_wrapped("", f"source: {law.source}"))
    if law.notes:
        blocks.append(_wrapped("", f"notes: {law.notes}"))
    if recipe and any(field.name == "restitution" for field in law.fields):
        blocks.append(_restitution_table(recipe))
    if law.family == "elastic" and recipe:
        blocks.append(_force_table(law, recipe))
    return "\n\n".join(blocks)


def _wrapped(indent: str, content: str) -> str:
    return textwrap.fill(content, WIDTH, initial_indent=indent, subsequent_indent="  ", break_on_hyphens=False)


def _parameter_text(field: Field) -> str:
    unit = "" if field.unit == "1" else f", {field.unit}"
    allowed = field._replace(unit="1").allowed()
    default = "" if field.default is None else f"; default {field.default:g}"
    return _wrapped("  ", f"{field.name}{unit}: {field.text}; {allowed}{default}")


def _table_key_text(columns: Columns) -> str:
    headings = ", ".join(f"{field.name} [{field.unit}]" for field in (*columns.over, *columns.values))
    return _wrapped("  ", f"{columns.name}: {columns.text}; a .csv file of {headings}; may be left out")


def _need_text(name: str) -> str:
    texts = {
        "length": "m: of the joint, along the pin",
        "bearing_radius": "m",
        "material": "young (Pa) and poisson of both bodies, or of bearing and journal",
        "hertz": "elastic: power with the exponent 1.5",
        "friction": "of the joint, by whatever law",
        "modulus": "Pa: Young's, from `material` or from the stiffness of a power law",
    }
    return _wrapped("  ", texts[name] if name == "hertz" else f"{name}, {texts[name]}")


def _table(heading: str, columns: tuple[str, str], rows: list[tuple[str, str]]) -> str:
    lines = [heading, f"  {columns[0]:>12}  {columns[1]:>12}"]
    return "\n".join(lines + [f"  {left_cell:>12}  {right_cell:>12}" for left_cell, right_cell in rows])


def _restitution_table(recipe: Recipe) -> str:
    rows = [(f"{e:g}", f"{recipe.free_restitution(e):.4f}") for e in RESTITUTIONS]
    return _table("restitution of a free impact", ("specified", "returned"), rows)


def _force_table(law: Law, recipe: Recipe) -> str:
    defaults = {field.name: field.default for field in law.fields if field.default is not None}
    contact = REFERENCE.contact
    joint = REFERENCE._replace(contact=contact._replace(elastic=law.name, values=contact.values | defaults))
    elastic, limit, derived = recipe.make(joint), recipe.limit(joint), recipe.derived(joint)
    layer = ", layer 5 mm" if any(field.name == "thickness" for field in law.fields) else ""
    limit_text = "" if math.isinf(limit) else f"\n  valid up to {1e6 * limit:.4g} um"
    rows = [(f"{1e6 * pen:g}", f"{elastic_force(elastic, pen):.5g}") for pen in DEPTHS]
    derived_lines = [
        f"\n  {key}: {value:.5g}{'' if unit == '1' else f' {unit}'}" for key, (value, unit) in derived.items()
    ]
    return _table(f"force ({_REFERENCE_TEXT}{layer})", ("pen, um", "F, N"), rows) + "".join(derived_lines) + limit_text
