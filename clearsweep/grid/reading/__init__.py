"""Reads a document in the order in which its parts depend on each other."""

from collections.abc import Callable, Collection, Mapping
from dataclasses import replace
from functools import partial
from typing import Any

from ...contracts.catalogue import NUMERICS, Catalogue, FigureOutline, Mechanism, Outline
from ...contracts.layout import ALWAYS_STORED, Layout
from ...language.errors import did_you_mean, nearest_words, quoted
from ..keys import Flag, KeyTable, Name, NameList, Number, Section, Table, Use, Word, has_keys_below
from ..keys.joint_keys import REFUSED_SECTIONS
from ..keys.key_table import table_of_keys
from ..keys.library_names import find_varied_names, keys_of_names, replace_library_names, written_names
from ..keys.outline import DRIVES, LENGTHS, has_user_names, outline_of_document, with_possible_forms, wrong_names
from ..keys.run_keys import CHANNELS, LIFE, TIME_BUDGET_FIELD, TIME_BUDGET_PATH
from ..sections import Reader, find_added_cases, variations
from ..sections.fits import replace_fits_by_clearances
from ..sections.named_sections import (
    FIGURES_SECTION,
    LIMITS_SECTION,
    ROLES_SECTION,
    UNCERTAIN,
    expected_columns,
    read_limits,
    read_roles,
    read_uncertain,
)
from ..written import Problems, WrittenValue
from ..written.definitions import DEFINE, resolve_definitions, varied_paths
from ..written.law_files import LAWS
from ..written.tables import with_damping_ratios
from . import values

#: Sections that belong to no law, mechanism or search: those before the searches and those after them.
_FIRST_TOP_SECTIONS = ("name", LAWS, DEFINE, FIGURES_SECTION.name, LIMITS_SECTION.name, ROLES_SECTION.name, UNCERTAIN)


def read_keys(
    root: WrittenValue, catalogue: Catalogue, problems: Problems, fixed_paths: frozenset[str] = frozenset()
) -> Reader:
    """Return the values in the document `root`; mistakes go to `problems`.  Paths in `fixed_paths` do not vary."""
    defined_section = root.value.get(DEFINE)
    root = variations.with_branch_axes(root, problems)
    root, definitions = resolve_definitions(root, problems, fixed_paths)
    root = with_damping_ratios(root, problems)
    own_figures = _own_figures(root, catalogue)
    outline = with_possible_forms(outline_of_document(root), catalogue)._replace(
        laws=catalogue.own_laws,
        figures=tuple(_figure_outline(name, entry, catalogue) for name, entry in own_figures.value.items()),
    )
    mechanism, keys_in_plane = _mechanism_and_keys_in_plane(root, catalogue, outline)
    root, library_numbers, unchecked_sections = replace_library_names(root, problems)
    all_keys = variations.keys_of_definitions(definitions) | table_of_keys(mechanism, catalogue, [*own_figures.value])
    varied = [path for path, _ in varied_paths(root.value)]
    variations.with_carried_paths(all_keys, varied)
    varied_names = find_varied_names(varied, library_numbers, all_keys, unchecked_sections)
    searches = {search.name: search for search in catalogue.searches}
    reader = Reader(
        problems,
        mechanism,
        outline,
        searches=searches,
        defined=definitions,
        varied_names=varied_names,
        keys_in_plane=keys_in_plane,
    )
    all_keys |= keys_of_names(varied_names)
    figures = {FIGURES_SECTION.name: own_figures} if own_figures.value else {}
    _read_section(reader, root.with_value(root.without(FIGURES_SECTION.name).value | figures), "", all_keys)
    reader.written |= written_names(varied_names, root)
    _select_keys_in_use(reader, all_keys)
    variations.record_variations(reader, root, all_keys, fixed_paths)
    _record_axes_of_searches(reader, all_keys, lambda search: search.axes(reader, root))
    variations.replace_label_axes(reader)
    values_of = partial(values.values_before_reading, reader)
    replace_fits_by_clearances(reader, values_of)
    reader.library_numbers = {
        item.path: item
        for item in library_numbers
        if item.path not in reader.written_axes and not any(item.path in each.paths for each in varied_names.values())
    }
    values.set_wear_units(reader)
    _record_axes_of_searches(reader, all_keys, lambda search: search.late_axes(reader, root, all_keys, values_of))
    find_added_cases(reader, root)
    for path, key in reader.keys_in_use.items():
        if isinstance(key, Word):
            values.read_word_key(reader, path, key)
        elif isinstance(key, Number):
            values.read_number(reader, path, key)
        elif isinstance(key, Flag):
            values.read_flag(reader, path)
        elif isinstance(key, Table):
            values.read_table_key(reader, path, key)
        elif isinstance(key, NameList):
            read_channels(reader, path)
    reader.axes = {path: reader.axes[path] for path in reader.written_axes if path in reader.axes}
    values.report_mixed_numbers(reader, root)
    variations.check_variations(reader)
    variations.check_dependents(reader)
    variations.check_branches(reader, root)
    read_uncertain(reader, root)
    read_roles(reader, root)
    reader.figures = expected_columns(reader, catalogue)
    variations.report_column_name_clashes(reader, defined_section)
    read_limits(reader, root)
    reader.search = next(filter(None, [search.read(reader, root) for search in searches.values()]), None)
    return reader


def _record_axes_of_searches(reader: Reader, all_keys: KeyTable, axes_of: Callable[[Any], Mapping]) -> None:
    """Record the values that searches may choose; `axes_of` returns those of one search."""
    for search in reader.searches.values():
        with reader.problems.reporting():
            for path, (position, written) in axes_of(search).items():
                variations.record_axis(reader, search.name, path, position, written, all_keys)


def _own_figures(root: WrittenValue, catalogue: Catalogue) -> WrittenValue:
    """Return the part of the section `figures` that names figures of one's own, each as a section."""
    written: WrittenValue = root.value.get(FIGURES_SECTION.name, WrittenValue({}))
    names = catalogue.names("figure")
    own = {
        name: replace(entry, value={"law": entry}) if entry.value in names else entry
        for name, entry in written.entries.items()
        if isinstance(entry.value, dict) or (isinstance(entry.value, str) and entry.value in names)
    }
    return written.with_value(own)


def _figure_outline(name: str, written: WrittenValue, catalogue: Catalogue) -> FigureOutline:
    """Return the outline of a figure of one's own; of an unknown one, which the reader reports, without a unit."""
    law_name = written.value["law"].value if "law" in written.value else ""
    law = catalogue.find("figure", law_name)
    return FigureOutline(name, law.name, law.unit, law.formula) if law else FigureOutline(name, "")


def _mechanism_and_keys_in_plane(
    root: WrittenValue, catalogue: Catalogue, outline: Outline
) -> tuple[Mechanism, Collection[str]]:
    """Return the mechanism whose keys apply: the named one, or the most likely one if the name is wrong.

    Of one in space the keys that it would have in the plane are returned, too.
    """
    section = root.value.get("mechanism", WrittenValue({}))
    by_name = {mechanism.name: mechanism for mechanism in catalogue.mechanisms}
    type_name = str(section.entries.get("type", WrittenValue("")).value)
    candidates = [name for name in by_name if name == type_name or f"'{name}'" in did_you_mean(type_name, by_name)]
    mechanism = by_name[candidates[0]] if candidates else catalogue.mechanisms[0]
    if mechanism.with_outline is None:
        return mechanism, ()
    in_plane = mechanism.with_outline(outline._replace(spatial=False, axial=frozenset())) if outline.spatial else None
    return mechanism.with_outline(outline), table_of_keys(in_plane, catalogue).keys() if in_plane else ()


def _read_section(reader: Reader, written: WrittenValue, path: str, all_keys: KeyTable) -> None:
    """Record the sections and values under `path`; report keys that do not belong there."""
    allowed = [child_path.rpartition(".")[2] for child_path in all_keys if child_path.rpartition(".")[0] == path]
    allowed += [] if path else [*_FIRST_TOP_SECTIONS, *reader.searches, *variations.VARYING_SECTIONS]
    reader.sections[path] = written
    content = written.value
    section = all_keys.get(path)
    if allowed == ["table"] and isinstance(all_keys.get(f"{path}.table"), Table) and _is_bare_table(content):
        content = {"table": written}
    if isinstance(section, Section) and section.items:
        content = values.list_items(reader, written, path, all_keys)
        if content is None:
            return
    if content is None and isinstance(section, Section) and section.need == "implied":
        content = {}
    if not isinstance(content, dict):
        table = "a table: the name of a .csv or .xlsx file, or columns with their values"
        expected = table if allowed == ["table"] else f"a section with the keys {', '.join(allowed)}"
        reader.problems.add(written, path, f"found {quoted(content)}; expected {expected}")
        reader.unread_sections.add(path)
        return
    invalid = dict(wrong_names(path, content)) if has_user_names(path) else {}
    misspelt_by_key: dict[str, WrittenValue] = {}  # by the intended key
    for key_name, entry in content.items():
        child_path = f"{path}.{key_name}" if path else key_name
        if key_name in invalid:
            reader.problems.add(written.key_position(key_name), child_path, f"'{key_name}' {invalid[key_name]}")
        elif "." not in key_name and child_path in all_keys:
            _record_entry(reader, entry, child_path, all_keys)
        elif key_name not in allowed and not _report_invalid_names(reader, child_path, entry):
            reader.problems.add(
                written.key_position(key_name), child_path, _unknown_key_text(reader, path, key_name, allowed)
            )
            # stops may be on a joint without clearance, in which nothing else is missing
            reader.unread_sections |= {path} if key_name == "stops" else set()
            misspelt_by_key |= {
                intended: entry for intended in nearest_words(key_name, allowed) if intended not in content
            }
    for (
        key_name,
        entry,
    ) in misspelt_by_key.items():  # its content is read as that of the intended key, so that nothing is missing
        _record_entry(reader, entry, f"{path}.{key_name}" if path else key_name, all_keys)
    content = content | misspelt_by_key
    for child_path, key in all_keys.items() if path not in reader.unread_sections else ():
        parent, _, key_name = child_path.rpartition(".")
        is_required = isinstance(key, Section) and key.need == "required" and key.unless not in content
        if isinstance(key, Section) and is_required and parent == path and key_name not in content:
            reader.problems.add(written, child_path, f"is missing; write the section '{key_name}' ({key.text})")


def _is_bare_table(content: Any) -> bool:
    """Return whether a value is the name of a table's file, or its columns, without the key `table`."""
    if isinstance(content, dict):
        return bool(content) and all(isinstance(entry.value, list) for entry in content.values())
    return isinstance(content, str)


def _record_entry(reader: Reader, entry: WrittenValue, path: str, all_keys: KeyTable) -> None:
    """Record the value of a known key or the content of a section, even of one that replaces a quantity."""
    key = all_keys.get(path)
    is_replaced = isinstance(key, Number) and isinstance(entry.value, dict) and has_keys_below(all_keys, path)
    if isinstance(key, Section) or is_replaced:
        _read_section(reader, entry, path, all_keys)
    elif key is not None:
        reader.written[path] = entry


def _report_invalid_names(reader: Reader, path: str, entry: WrittenValue) -> bool:
    """Report invalid names in an open section, and return whether there are any."""
    names = list(entry.entries) if has_user_names(path) else []
    invalid = dict(wrong_names(path, names))
    for name, message in invalid.items():
        reader.problems.add(entry.key_position(name), f"{path}.{name}", f"'{name}' {message}")
    return bool(invalid)


def _unknown_key_text(reader: Reader, path: str, key_name: str, allowed: list[str]) -> str:
    """Return the message for a key that does not belong in the section at `path`."""
    if path == "drive" and key_name in DRIVES:
        other_drive = next((drive for drive in DRIVES if drive in allowed), DRIVES[0])
        return f"conflicts with {other_drive}; a drive can have only one of {', '.join(DRIVES)}; remove the others"
    own = [key for key in LENGTHS if key in allowed]  # none where a run ends by itself
    if path == "simulate" and key_name in LENGTHS and own:
        return f"conflicts with {own[0]}; the length of a run is one of revolutions, time, or cycles with their period"
    if path == "simulate" and key_name in ("until", "time_limit") and "revolutions" not in allowed:
        return f"{key_name} counts revolutions, so it needs a run whose length is in revolutions; remove one of the two"
    if key_name == "type" and path.startswith("joints."):
        return "only a pin in the plane can be a rolling bearing; leave type out"
    if key_name == "stops" and path.startswith("joints."):
        return "only pins and guides of mechanism.type `planar` may have stops; use this type, or leave them out"
    if key_name in REFUSED_SECTIONS and "element_diameter" in allowed:
        return REFUSED_SECTIONS[key_name]
    if path == "mechanism.mounts":
        return (
            f"'{key_name}' is not a joint at the ground that may have a mount{did_you_mean(key_name, allowed)}; mounts "
            f"are possible at {', '.join(allowed) or 'none'}, and their sections have these names"
        )
    if (path, key_name) == ("mechanism", "mounts"):
        return "only the ground joints of a planar mechanism with a crank can yield; leave `mounts` out"
    if key_name == "law" and (path == "drive.motor" or path.startswith("loads.")):
        noun, other = ("motor", "a linear motor") if path == "drive.motor" else ("load", "force and torque")
        return f"no law file declares a {noun}; name the file in `{LAWS}`, or leave law out for {other}"
    if key_name == "elastic" and path.startswith("mechanism."):
        elastic_text = "only a link between two pins of a planar mechanism can be elastic"
        return f"{elastic_text}; this one is rigid: leave `elastic` out"
    if key_name[:1].isdigit() and not any(name[:1].isdigit() for name in allowed):
        return f"unknown key '{key_name}'; write numbers with a decimal point, not a comma"
    if (f"{path}.{key_name}" if path else key_name) in reader.keys_in_plane:
        return f"'{key_name}' is possible only in the plane; leave it out, or leave `mechanism.spatial` out"
    allowed_text = f"(allowed: {', '.join(allowed)})" if allowed else "(this section allows no keys here)"
    return f"unknown key '{key_name}'{did_you_mean(key_name, allowed)} {allowed_text}"


def _select_keys_in_use(reader: Reader, all_keys: KeyTable) -> None:
    """Select the keys in use from all keys; wear and roughness also get keys that otherwise only laws have."""
    for path, key in all_keys.items():
        parent = path.rpartition(".")[0]
        is_present = True
        if isinstance(key, Section):  # written or implied, together with the sections it needs
            required = f"{parent.rpartition('.')[0]}.{key.needs}"
            is_present = path in reader.sections or key.need == "implied"
            is_present = is_present and (not key.needs or required in reader.keys_in_use)
        if isinstance(all_keys.get(parent), Number):
            is_present = parent in reader.sections
        elif isinstance(key, Number) and path in reader.sections:  # a section replaces it
            is_present = False
        has_parent = not parent or parent in reader.keys_in_use or isinstance(all_keys.get(parent), Number)
        if (
            is_present
            and has_parent
            and not isinstance(key, Name)
            and reader.unread_sections.isdisjoint((path, parent))
        ):
            reader.keys_in_use[path] = key
            if isinstance(key, Section):
                reader.sections.setdefault(path, reader.sections[parent])
    if LIFE in reader.keys_in_use and TIME_BUDGET_PATH in reader.keys_in_use:
        field = TIME_BUDGET_FIELD._replace(default=None, optional=True)
        reader.keys_in_use[TIME_BUDGET_PATH] = Number((Use(field),), NUMERICS, sweep=False)
    for path, key in reader.keys_in_use.items():
        joint = ".".join(path.split(".")[:2])
        is_of_material = path.startswith(f"{joint}.contact.material.")
        is_required_by_roughness = f"{joint}.roughness" in reader.keys_in_use and (
            is_of_material or path in (f"{joint}.length", f"{joint}.bearing_radius")
        )
        if isinstance(key, Number) and (
            is_required_by_roughness or (is_of_material and f"{joint}.wear" in reader.keys_in_use)
        ):
            reader.keys_in_use[path] = key._replace(
                uses=tuple(key_use._replace(when=()) for key_use in key.uses), sweep=True
            )


def read_channels(reader: Reader, path: str) -> None:
    """Read the names of the time histories to store; `check_channels` checks them once the layout is known."""
    entry, key = reader.written.get(path), reader.keys_in_use[path]
    if entry is None:
        return
    assert isinstance(key, NameList), path
    items = entry.value if isinstance(entry.value, list) else []
    invalid = [item for item in items if not isinstance(item.value, str)]
    for item in invalid or ([] if items else [entry]):
        reader.problems.add(item, path, f"found {quoted(item.value)}; expected {key.noun}, such as {key.example}")
    if invalid or not items:
        return
    if reader.values.get("save.orbits") == "none":
        reader.problems.add(entry, path, "is not used, as save.orbits is none; leave one of them out")
    else:
        reader.values[path] = list(dict.fromkeys(item.value for item in items))


def check_channels(reader: Reader, layout: Layout) -> None:
    """Report names in `save.channels` that no time history of these cases has."""
    entry = reader.written.get(CHANNELS)
    if entry is None or CHANNELS not in reader.values:
        return
    allowed = [channel.name for channel in layout.channels if channel.name not in ALWAYS_STORED]
    for item in entry.value:
        if isinstance(item, WrittenValue) and item.value not in (*allowed, *ALWAYS_STORED):
            suggestion = did_you_mean(item.value, allowed) or f" (known: {', '.join(allowed)})"
            reader.problems.add(item, CHANNELS, f"there is no channel '{item.value}'{suggestion}")
