"""The outline of a grid (drive, loads, bodies, joints), and the keys and units that follow from it."""

import re
from collections.abc import Iterable, Iterator, Mapping
from typing import Any, NamedTuple

from ...contracts.catalogue import Catalogue, Mechanism
from ...contracts.outline import ANY, EVERYTHING, IN_SPACE, SIZES, BodyOutline, JointOutline, LoadOutline, Outline
from ...language import quantity
from ..written.document import WrittenValue, leaves
from .key_table import shape
from .kinds import Number, Shape, Word

NAME = re.compile(r"[A-Za-z][A-Za-z0-9_-]{0,39}")
MOST = 40  # bodies, points of a body, joints or loads; compiled code grows with their number
NAMING = "is not a valid name; expected a letter, then letters, digits, - or _, at most 40 characters"
DRIVES = ("speed", "torque", "motor")  # keys of `drive`, of which a grid has exactly one
_SECTIONS = ("mechanism", "drive", "loads", "joints")
_OPEN = re.compile(r"loads|mechanism\.(bodies|joints|bodies\.[^.]+\.points)")
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


def is_open(path: str) -> bool:
    """Return whether the keys of the section at `path` are user-defined names."""
    return bool(_OPEN.fullmatch(path))


def outline_of(tree: Mapping[str, Any], swept: Iterable[str] = ()) -> Outline:
    """Return the outline of a grid given as plain values in the form of its file; `swept`: varied paths."""
    paths = set(swept)
    mechanism, drive = _section(tree.get("mechanism")), _section(tree.get("drive"))
    bodies = _section(mechanism.get("bodies"))
    joints, output = _section(mechanism.get("joints")), _section(mechanism.get("output"))
    return Outline(
        type=str(mechanism.get("type", "")),
        drive=_drive(drive, {path.split(".")[1] for path in paths if path.startswith("drive.")} | set(drive)),
        loads=tuple(_load(name, content, paths) for name, content in _named(_section(tree.get("loads")))),
        bodies=tuple(
            BodyOutline(name, tuple(point for point, _ in _named(_section(_section(content).get("points")))))
            for name, content in _named(bodies)
        ),
        joints=tuple(_joint(name, _section(content)) for name, content in _named(joints)),
        rotary="point" not in output,
        clearances=frozenset(_section(tree.get("joints"))),
        spatial=mechanism.get("spatial") is True,
        axial=frozenset(_flanged(_section(tree.get("joints")))) if mechanism.get("spatial") is True else frozenset(),
        elastic=frozenset(name for name, content in _named(bodies or mechanism) if "elastic" in _section(content)),
    )


def outline_of_document(root: WrittenValue) -> Outline:
    """Return the outline of a grid as written."""
    top = root.value if isinstance(root.value, dict) else {}
    tree = {key: _plain(top[key]) for key in _SECTIONS if key in top}
    axis_sections = [_section(top[variation].value) for variation in ("sweep", "zip", "cases") if variation in top]
    if "sample" in top:
        over = _section(top["sample"].value).get("over")
        axis_sections.append(_section(over.value if over else None))
    return outline_of(tree, [path for variation in axis_sections for path in variation])


def wrong_names(path: str, names: Iterable[str]) -> Iterable[tuple[str, str]]:
    """Yield the invalid names in the open section at `path`, each with the reason."""
    columns: dict[str, str] = {}
    for number, name in enumerate(names, start=1):
        column = name.replace("-", "_")
        if not NAME.fullmatch(name):
            yield name, NAMING
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
        elif number > MOST:
            yield name, f"is name number {number}; at most {MOST} names are allowed here"
        columns.setdefault(column, name)


def _named(section: Mapping[str, Any]) -> list[tuple[str, Any]]:
    return [(name, content) for name, content in section.items() if NAME.fullmatch(name)][:MOST]


def _section(value: Any) -> Mapping[str, Any]:
    return value if isinstance(value, Mapping) else {}


def _plain(written: WrittenValue) -> Any:
    """Return a written value without its position."""
    if isinstance(written.value, dict):
        return {key: _plain(item) for key, item in written.value.items()}
    if isinstance(written.value, list):
        return [_plain(item) for item in written.value]
    return written.value


def _drive(drive: Mapping[str, Any], keys: set[str]) -> str:
    """Return the form of a drive with these keys, or the most likely form."""
    if "motor" in keys:
        return "motor"
    if "torque" in keys or ("speed" not in keys and not keys.isdisjoint(("initial_speed", "inertia"))):
        return "torque"
    return "speed-table" if isinstance(drive.get("speed"), Mapping) else "speed"


def _load(name: str, content: Any, paths: set[str]) -> LoadOutline:
    """Return the outline of a load."""
    section, start = _section(content), f"loads.{name}."
    keys = set(section) | {path.removeprefix(start).split(".")[0] for path in paths if path.startswith(start)}
    form = next(
        (form for key, form in (("friction", "friction"), ("between", "spring"), ("table", "table")) if key in keys),
        "force",
    )
    on = _pair(section.get("between"))[1] if form == "spring" else section.get("on")
    sizes = set(_section(section.get("friction"))) | {
        path.rpartition(".")[2] for path in paths if path.startswith(f"{start}friction.")
    }
    size_key = next((size for size in SIZES if {size, f"static_{size}"} & sizes), "") if form == "friction" else ""
    return LoadOutline(name, form, on if isinstance(on, str) else "", size_key)


def _joint(name: str, section: Mapping[str, Any]) -> JointOutline:
    """Return the outline of a joint."""
    body_pair = _pair(section.get("between"))
    journal = section.get("journal")
    written = section.get("type")
    kind = written if written in ("prismatic", "slot") else "revolute"
    return JointOutline(name, kind, *body_pair, journal if isinstance(journal, str) else "")


def _flanged(joints: Mapping[str, Any]) -> Iterable[str]:
    """Yield the joints whose section does not declare that they have no flanges."""
    return (name for name, content in joints.items() if _section(content).get("flange") is not False)


def _pair(value: Any) -> tuple[str, str]:
    """Return two words, with '' for anything that is not a word."""
    proximal, distal = value if isinstance(value, list) and len(value) == 2 else ("", "")
    return (proximal if isinstance(proximal, str) else ""), (distal if isinstance(distal, str) else "")


def full_shape(mechanism: Mechanism, catalogue: Catalogue) -> Shape:
    """Return every dotted path that a grid of this mechanism may contain, with NAME for user-defined names."""
    if not mechanism.outlined:
        return shape(mechanism, catalogue)
    outlined = mechanism.outlined(EVERYTHING)
    return shape(outlined, catalogue) | shape(outlined._replace(free=True), catalogue)  # `horizon` and `time_limit`


class KeyTree(NamedTuple):
    """The keys of a mechanism, in the plane or in space."""

    mechanism: str  # its name
    keys: Shape
    joints: Mapping[str, str]  # joints that may have clearance -> kind, as in `JointSite`
    spatial: bool = False


def key_trees(catalogue: Catalogue, *, slots: bool = False) -> Iterator[KeyTree]:
    """Yield the keys of all mechanisms, with NAME for user-defined names; with `slots` also the keys of a slot."""
    for mechanism in catalogue.mechanisms:
        outlined = mechanism.outlined(EVERYTHING) if mechanism.outlined else mechanism
        kinds = {site.name: site.kind for site in outlined.joints}
        yield KeyTree(mechanism.name, full_shape(mechanism, catalogue), kinds)
        if slots and ANY in kinds and mechanism.outlined:
            slot = mechanism.outlined(EVERYTHING._replace(joints=(JointOutline(ANY, "slot", "", ""),)))
            yield KeyTree(mechanism.name, shape(slot, catalogue), {ANY: "slot"})
        in_space = mechanism.outlined(IN_SPACE) if mechanism.outlined else mechanism
        if in_space.spatial:
            kinds = {site.name: site.kind for site in in_space.joints}
            yield KeyTree(mechanism.name, shape(in_space, catalogue), kinds, spatial=True)


VARIATIONS = ("sweep", "zip", "cases")  # sections of a resolved grid with dotted path -> values


def key_units(resolved: Mapping, catalogue: Catalogue) -> dict[str, str]:
    """Return dotted path -> SI unit of every number in use in the result of `Grid.resolved`.

    Numbers of a law that is missing from the catalogue have no unit.
    """
    mechanism = catalogue.outlined(resolved["mechanism"]["type"], outline_of(resolved, _varied(resolved)))
    keys = shape(mechanism, catalogue) if mechanism else {}
    axes = _varied(resolved)
    values = dict(leaves(resolved))
    names = {
        path: frozenset(axes.get(path) or [values.get(path, node.default)])
        for path, node in keys.items()
        if isinstance(node, Word)
    }
    units_by_path = {}
    for path, node in keys.items():
        if isinstance(node, Number):
            sibling = f"{path.rpartition('.')[0]}.exponent"
            exponent = None if sibling in axes else values.get(sibling, _default_number(keys.get(sibling), names))
            units_by_path[path] = unit_of_number(node, names, exponent)
    return {path: name for path, name in units_by_path.items() if name}


def _varied(resolved: Mapping) -> dict:
    """Return path -> values of the varied keys of a resolved grid."""
    return {path: values for variation in VARIATIONS for path, values in (resolved.get(variation) or {}).items()}


def unit_of_number(node: Number, names: Mapping[str, frozenset[str]], exponent: float | None) -> str:
    """Return the SI unit of a number with the law names in use, 'A or B' where they differ, or '' if none is in use.

    `exponent` is the value of the key `exponent` next to it, or None if there is none or it varies.
    """
    written = [field.unit for field in node.fields(names)]
    exact = written if exponent is None else [quantity.with_exponent(name, exponent) for name in written]
    return " or ".join(dict.fromkeys(exact))


def _default_number(node: object, names: Mapping[str, frozenset[str]]) -> float | None:
    """Return the default of a missing key, or None if it has no numeric default."""
    fields = node.fields(names) if isinstance(node, Number) else ()
    return fields[0].default if fields else None
