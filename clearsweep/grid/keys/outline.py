"""The outline of a grid (drive, loads, bodies, joints), and the keys and units that follow from it."""

import re
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from typing import Any, NamedTuple

from ...contracts.catalogue import (
    ANY,
    FULL_OUTLINE,
    IN_SPACE,
    SIZES,
    BendingOutline,
    BodyOutline,
    Catalogue,
    JointOutline,
    LoadOutline,
    Mechanism,
    Outline,
)
from ...contracts.vibration import FRAME, MAX_ORDERS, NO_SEVERITY, SEVERITIES, PlaceOutline, VibrationOutline
from ...language import quantity
from ...language.errors import InputError
from ..written import AXIS_SECTIONS, WrittenValue, leaves
from ..written.law_files import plain_value, with_recorded_laws
from . import KeyTable, Number, Word
from .key_table import table_of_keys

NAME_PATTERN = re.compile(r"[A-Za-z][A-Za-z0-9_-]{0,39}")
MAX_NAMES = 100  # bodies, points of a body, joints or loads; compiled code grows with their number
INVALID_NAME_TEXT = "is not a valid name; expected a letter, then letters, digits, - or _, at most 40 characters"
CRANK_PIN = "ground-crank"  # of a mechanism without the key `driven`
DRIVES = ("speed", "angle", "torque", "motor", "servo")  # keys of `drive`, of which a grid has exactly one
#: Keys of a load that show its form, the first that is written.
FORMS = (
    ("friction", "friction"),
    ("torsional_stiffness", "torsion"),
    ("torsional_damping", "torsion"),
    ("between", "spring"),
    ("table", "table"),
    ("law", "own"),
)
LENGTHS = {"time": "time", "cycles": "cycles", "period": "cycles", "revolutions": "revolutions"}  # key -> what it shows
_SECTIONS = ("mechanism", "drive", "loads", "joints", "vibration", "simulate")
_USER_NAMED_SECTIONS = re.compile(r"loads|vibration\.at|mechanism\.(bodies|joints|bodies\.[^.]+\.points)")
_RESERVED = frozenset(  # names that orbits.h5 already uses
    [
        "case_id",
        "crank_angle",
        "drive",
        "events",
        "history",
        "joints",
        "life",
        "offsets",
        "output",
        "poincare",
        "t",
        "wear",
    ]
)


def has_user_names(path: str) -> bool:
    """Return whether the keys of the section at `path` are user-defined names."""
    return bool(_USER_NAMED_SECTIONS.fullmatch(path))


def outline_of(tree: Mapping[str, Any], varied_paths: Iterable[str] = ()) -> Outline:
    """Return the outline of a grid given as plain values in the form of its file."""
    path_set = set(varied_paths)
    mechanism, drive = _section(tree.get("mechanism")), _section(tree.get("drive"))
    sections = {name: _section(content) for name, content in _section(tree.get("joints")).items()}
    is_spatial = mechanism.get("spatial") is True
    stopped = {name for name, content in sections.items() if "stops" in content}
    ideal = {name for name in stopped if {*sections[name]} == {"stops"} and f"joints.{name}.clearance" not in path_set}
    bodies = _section(mechanism.get("bodies"))
    joints, output = _section(mechanism.get("joints")), _section(mechanism.get("output"))
    return Outline(
        type=str(mechanism.get("type", "")),
        drive=_drive_form(drive, {path.split(".")[1] for path in path_set if path.startswith("drive.")} | set(drive)),
        loads=tuple(
            _load_outline(name, content, path_set) for name, content in _named_entries(_section(tree.get("loads")))
        ),
        bodies=tuple(
            BodyOutline(name, tuple(point for point, _ in _named_entries(_section(_section(content).get("points")))))
            for name, content in _named_entries(bodies)
        ),
        joints=tuple(
            _joint_outline(name, _section(content), stops=name in stopped) for name, content in _named_entries(joints)
        ),
        rotary="point" not in output,
        clearances=frozenset(sections) - ideal,
        spatial=is_spatial,
        axial=frozenset(name for name in sections if is_spatial and sections[name].get("flange") is not False),
        rolling=frozenset(name for name in sections if not is_spatial and "type" in sections[name]),
        elastic=frozenset(
            name for name, content in _named_entries(bodies or mechanism) if "elastic" in _section(content)
        ),
        bending=tuple(_bending_outlines("mechanism.bodies" if bodies else "mechanism", bodies or mechanism, path_set)),
        mounts=tuple(name for name, _ in _named_entries(_section(mechanism.get("mounts")))),
        vibration=_vibration_outline(tree["vibration"], path_set, mechanism) if "vibration" in tree else None,
        inclined=isinstance(mechanism.get("gravity"), list) and not is_spatial,
        length=_length_of(_section(tree.get("simulate")), path_set),
    )


def outline_of_document(root: WrittenValue) -> Outline:
    """Return the outline of a grid as written."""
    sections, nothing = root.value, WrittenValue({})
    tree = {key: plain_value(sections[key]) for key in _SECTIONS if key in sections}
    axis_sections = [sections.get(section_name, nothing) for section_name in AXIS_SECTIONS]
    axis_sections.append(sections.get("sample", nothing).entries.get("over", nothing))
    return outline_of(tree, [path for section in axis_sections for path in section.entries])


def with_possible_forms(outline: Outline, catalogue: Catalogue) -> Outline:
    """Return an outline whose motor and loads follow laws only if law files declare such laws."""
    drive = "motor" if outline.drive == "motor-law" and not catalogue.of("motor") else outline.drive
    if catalogue.of("load"):
        return outline._replace(drive=drive)
    loads = (load._replace(form="force") if load.form == "own" else load for load in outline.loads)
    return outline._replace(drive=drive, loads=tuple(loads))


def wrong_names(path: str, names: Iterable[str]) -> Iterable[tuple[str, str]]:
    """Yield the invalid names in the open section at `path`, each with the reason."""
    columns: dict[str, str] = {}
    for position, name in enumerate(names, start=1):
        column = name.replace("-", "_")
        if not NAME_PATTERN.fullmatch(name):
            yield name, INVALID_NAME_TEXT
        elif path == "mechanism.bodies" and column in _RESERVED:
            yield name, "is reserved for columns of the results; rename the body"
        elif column in columns:
            yield (
                name,
                (
                    f"has the same column as '{columns[column]}', because columns have _ instead of -; "
                    "rename one of them"
                ),
            )
        elif position > MAX_NAMES:
            yield name, f"is name number {position}; at most {MAX_NAMES} names are allowed here"
        columns.setdefault(column, name)


def _named_entries(section: Mapping[str, Any]) -> list[tuple[str, Any]]:
    return [(name, content) for name, content in section.items() if NAME_PATTERN.fullmatch(name)][:MAX_NAMES]


def _section(value: Any) -> Mapping[str, Any]:
    """Return a value that is a section, or an empty section."""
    return value if isinstance(value, Mapping) else {}


def _drive_form(drive: Mapping[str, Any], keys: set[str]) -> str:
    """Return the form of a drive with these keys, or the most likely form."""
    if "motor" in keys:
        motor = _section(drive.get("motor"))
        return "motor-law" if "law" in motor else "motor-table" if "table" in motor else "motor"
    if "servo" in keys:
        return "servo"
    if "angle" in keys:
        return "angle-table"
    if "torque" in keys or ("speed" not in keys and not keys.isdisjoint(("initial_speed", "inertia"))):
        return "torque"
    return "speed-table" if isinstance(drive.get("speed"), Mapping) else "speed"


def _length_of(simulate: Mapping[str, Any], paths: set[str]) -> str:
    """Return what the length of a run is measured in."""
    return next(
        (length for key, length in LENGTHS.items() if key in simulate or f"simulate.{key}" in paths), "revolutions"
    )


def _load_outline(name: str, content: Any, paths: set[str]) -> LoadOutline:
    """Return the outline of a load."""
    section, prefix = _section(content), f"loads.{name}."
    keys = set(section) | {path.removeprefix(prefix).split(".")[0] for path in paths if path.startswith(prefix)}
    form = next((form for key, form in FORMS if key in keys), "force")
    loaded_body = _word_pair(section.get("between"))[1] if form in ("spring", "torsion") else section.get("on")
    friction_keys = set(_section(section.get("friction"))) | {
        path.rpartition(".")[2] for path in paths if path.startswith(f"{prefix}friction.")
    }
    size_key = (
        next((size for size in SIZES if {size, f"static_{size}"} & friction_keys), "") if form == "friction" else ""
    )
    body = loaded_body if isinstance(loaded_body, str) else ""
    return LoadOutline(name, form, body, size_key, section.get("reacted") is not False)


def _vibration_outline(content: Any, paths: set[str], mechanism: Mapping[str, Any]) -> VibrationOutline:
    """Return the outline of the section `vibration`; where housings yield, the frame moves with that of the crank."""
    section, places = _section(content), list[PlaceOutline]()
    mounted = [name for name, _ in _named_entries(_section(mechanism.get("mounts")))]
    crank_pin = mechanism.get("driven", CRANK_PIN)
    frame_mount = crank_pin if crank_pin in mounted else (*mounted, "")[0]
    for name, written in _named_entries(_section(section.get("at"))):
        place, path = _section(written), f"vibration.at.{name}"
        moves = name != FRAME or "mass" in place or f"{path}.mass" in paths or bool(frame_mount)
        body = frame_mount if name == FRAME else place.get("body", "")
        places.append(PlaceOutline(name, moves, body if isinstance(body, str) else "", "point" not in place))
    orders = 0
    with suppress(InputError):
        number = quantity.exact(section.get("orders", 0), "1")
        orders = int(number) if number.denominator == 1 and 0 < number <= MAX_ORDERS else 0
    severity = section.get("severity", NO_SEVERITY)
    has_zones = "zones" in section or (severity != NO_SEVERITY and severity in SEVERITIES)
    return VibrationOutline(tuple(places), orders, has_zones)


def _joint_outline(name: str, section: Mapping[str, Any], *, stops: bool) -> JointOutline:
    """Return the outline of a joint."""
    body_pair = _word_pair(section.get("between"))
    journal = section.get("journal")
    written_type = section.get("type")
    likely = "gear" if "ratio" in section else "revolute"
    kind = written_type if written_type in ("prismatic", "slot", "gear", "coupling") else likely
    has_stops = stops and kind in ("revolute", "prismatic")
    return JointOutline(name, kind, *body_pair, journal if isinstance(journal, str) else "", has_stops)


_BENDING_KEYS = {"section", "area", "second_moment", "edge", "bending", "young", "material", "density", "stress_life"}
_STRETCHING_KEYS = {"segments", "axial_stiffness"}


def _bending_outlines(section: str, bodies: Mapping[str, Any], varied_paths: set[str]) -> Iterator[BendingOutline]:
    """Yield the elastic links that bend."""
    for name, content in _named_entries(bodies):
        path = f"{section}.{name}.elastic."
        varied = {varied_path.removeprefix(path).split(".")[0] for varied_path in varied_paths}
        keys = varied | set(_section(_section(content).get("elastic")))
        if "elastic" in _section(content) and keys & _BENDING_KEYS:
            yield BendingOutline(name, bool(keys & _STRETCHING_KEYS), "stress_life" in keys)


def _word_pair(value: Any) -> tuple[str, str]:
    """Return two words, with '' for anything that is not a word."""
    first, second = value if isinstance(value, list) and len(value) == 2 else ("", "")
    return (first if isinstance(first, str) else ""), (second if isinstance(second, str) else "")


class KeyTree(NamedTuple):
    """The keys of a mechanism, in the plane or in space."""

    mechanism: str  # its name
    keys: KeyTable
    joints: Mapping[str, str]  # joints that may have clearance -> kind, as in `JointSite`
    spatial: bool = False


#: Joints with keys of their own besides pins and guides.
FURTHER_JOINTS = (
    *(JointOutline(ANY, kind, "", "") for kind in ("slot", "gear", "coupling")),
    *(JointOutline(ANY, kind, "", "", stops=True) for kind in ("revolute", "prismatic")),
)


def key_trees(catalogue: Catalogue, *, slots: bool = False) -> Iterator[KeyTree]:
    """Yield the keys of all mechanisms, with NAME for user-defined names.

    slots : whether the keys of slots, gears, couplings and stops are yielded, too
    """

    def tree(mechanism: Mechanism, free_keys: KeyTable | None = None) -> KeyTree:
        kinds = {site.name: site.kind for site in mechanism.joints}
        keys = table_of_keys(mechanism, catalogue) | (free_keys or {})
        return KeyTree(mechanism.name, keys, kinds, mechanism.spatial)

    for mechanism in catalogue.mechanisms:
        if not mechanism.with_outline:
            yield tree(mechanism)
            continue
        full = mechanism.with_outline(FULL_OUTLINE)
        yield tree(full, table_of_keys(full._replace(free=True), catalogue))  # with `horizon` and `time_limit`
        kinds = {site.name: site.kind for site in full.joints}
        for joint in FURTHER_JOINTS if slots and ANY in kinds else ():
            yield tree(mechanism.with_outline(FULL_OUTLINE._replace(joints=(joint,))))
        if pins := frozenset(name for name, kind in kinds.items() if kind in ("revolute", ANY)):
            pin_outline = FULL_OUTLINE._replace(joints=(JointOutline(ANY, "revolute", "", ""),), rolling=pins)
            yield tree(mechanism.with_outline(pin_outline))
        in_space = mechanism.with_outline(IN_SPACE)
        if in_space.spatial:
            yield tree(in_space)


def key_units(resolved: Mapping, catalogue: Catalogue) -> dict[str, str]:
    """Return dotted path -> SI unit of every number in use in the result of `Grid.resolved`.

    Numbers of a law that is missing from the catalogue have no unit.
    """
    catalogue = with_recorded_laws(catalogue, resolved)
    mechanism = catalogue.with_outline(resolved["mechanism"]["type"], outline_of(resolved, _axis_values(resolved)))
    figures = [name for name, figure in resolved.get("figures", {}).items() if isinstance(figure, dict)]
    keys = table_of_keys(mechanism, catalogue, figures) if mechanism else {}
    axes = _axis_values(resolved)
    values = dict(leaves(resolved))
    words_by_path = {
        path: frozenset(axes.get(path) or [values.get(path, key.default)])
        for path, key in keys.items()
        if isinstance(key, Word)
    }
    units_by_path = {}
    for path, key in keys.items():
        if isinstance(key, Number):
            exponent_path = f"{path.rpartition('.')[0]}.exponent"
            exponent_key = keys.get(exponent_path)
            fields = exponent_key.fields(words_by_path) if isinstance(exponent_key, Number) else ()
            default = fields[0].default if fields else None
            exponent = None if exponent_path in axes else values.get(exponent_path, default)
            units_by_path[path] = unit_of_number(key, words_by_path, exponent)
    return {path: unit for path, unit in units_by_path.items() if unit}


def _axis_values(resolved: Mapping) -> dict:
    """Return path -> values of the varied keys of a resolved grid."""
    return {
        path: values for section_name in AXIS_SECTIONS for path, values in (resolved.get(section_name) or {}).items()
    }


def unit_of_number(key: Number, words_by_path: Mapping[str, frozenset[str]], exponent: float | None) -> str:
    """Return the SI unit of a number with the law names in use, 'A or B' where they differ, or '' if none is in use.

    `exponent` is the value of the key `exponent` next to it, or None if there is none or it varies.
    """
    symbolic_units = [field.unit for field in key.fields(words_by_path)]
    units = (
        symbolic_units if exponent is None else [quantity.replace_exponent(unit, exponent) for unit in symbolic_units]
    )
    return " or ".join(dict.fromkeys(units))
