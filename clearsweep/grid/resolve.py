"""Converts a resolved case from the form of a grid file to its typed form; elsewhere no case is a dict."""

from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import Any

from ..contracts import case
from ..contracts.catalogue import JointOutline, LoadOutline, Outline
from ..contracts.vibration import FRAME, SEVERITIES, Frame, Location, Mount, Vibration, VibrationOutline
from .keys.joint_keys import PRELOAD, ROLLING
from .keys.key_table import DIMENSIONLESS
from .sections.named_sections import UNCERTAIN, uncertain_of
from .written import leaves
from .written.law_files import LAWS

Tree = Mapping[str, Any]  # section of a grid file in SI: key -> number, word, list or section


class SharedSection(dict):
    """A section that many cases share; its typed form is created once and kept with it."""

    typed_form: Any = None


def _typed(build: Callable[..., Any], section: Tree, *arguments: Any) -> Any:
    """Return the typed form of a section, which is created once."""
    if not isinstance(section, SharedSection):
        return build(section, *arguments)
    if section.typed_form is None:
        section.typed_form = build(section, *arguments)
    return section.typed_form


def case_of(tree: Tree, outline: Outline) -> case.Case:
    """Return the typed form of a case given as nested sections in SI with defaults and only keys in use."""
    sections = tree.get("joints", {})
    joints = (
        *(_typed(_joint, section, name, outline.laws) for name, section in sections.items() if {*section} != {"stops"}),
        *(_stops(sections[joint.name]["stops"], joint, outline) for joint in outline.joints if joint.stops),
    )
    simulate = _typed(_simulate, tree["simulate"])
    save = _typed(
        lambda section: case.Save(**{**section, "channels": tuple(section.get("channels", ()))}), tree["save"]
    )
    if outline.length == "time":  # which saves the whole run
        save = save._replace(revolutions=simulate.revolutions)
    return case.Case(
        mechanism=_typed(lambda section: _with_values(case.Mechanism, dict(leaves(section))), tree["mechanism"]),
        joints=joints,
        simulate=simulate,
        save=save,
        drive=_typed(_drive, tree["drive"], outline.laws) if "drive" in tree else None,
        loads=(
            *[_typed(_load, tree["loads"][load.name], load, outline.laws) for load in outline.loads],
            *_preloads(joints),
        ),
        outline=outline,
        life=_typed(lambda section: case.Life(**section), tree["life"]) if "life" in tree else None,
        uncertain=_typed(uncertain_of, tree[UNCERTAIN]) if UNCERTAIN in tree else (),
        law_files=tree.get(LAWS, ()),
        vibration=_typed(_vibration, tree["vibration"], outline.vibration) if "vibration" in tree else None,
        figures=_typed(_figures, tree["figures"], outline.laws) if "figures" in tree else (),
    )


def _preloads(joints: tuple[case.Joint, ...]) -> Iterator[case.Load]:
    """Yield the preloads of clearance joints, which also act without contact, as loads on bodies."""
    for joint in joints:
        if joint.friction and PRELOAD in joint.friction.values:
            radius = joint.bearing_radius or 1.0  # of a pin; the friction in a guide is a force
            values = {"on": joint.name, "radius": radius, PRELOAD: joint.friction.values[PRELOAD]}
            yield case.Load(f"{PRELOAD} of {joint.name}", PRELOAD, values, friction=joint.friction, laws=joint.laws)


def _simulate(section: Tree) -> case.Simulate:
    until = {"until": case.Until(**section["until"])} if "until" in section else {}
    values = {**section, **until}
    if "cycles" in values:
        values["revolutions"] = values.pop("cycles")
    elif "time" in values:
        duration, before = values.pop("time"), values.pop("discard")
        window = duration - before
        values |= {"revolutions": duration / window, "discard": before / window, "period": window}
    return case.Simulate(**values)


def _vibration(section: Tree, outline: VibrationOutline) -> Vibration:
    frame, others = _split_keys(section.get("at", {}), FRAME)
    bounds = tuple(section.get("zones", ())) or SEVERITIES[section["severity"]]
    return Vibration(
        tuple(section["band"]),
        bounds,
        _frame(frame or {}),
        tuple(
            Location(FRAME, case.housing_name(place.body), None)
            if place.name == FRAME
            else _place(place.name, others[place.name])
            for place in outline.places
            if place.name != FRAME or place.body
        ),
    )


def _figures(section: Tree, laws: str) -> tuple[case.OwnFigure, ...]:
    return tuple(_with_values(case.OwnFigure, figure, name=name, laws=laws) for name, figure in section.items())


def _frame(section: Tree) -> Frame:
    about, mount, values = _split_keys(section, "about", "mount")
    mount = Mount(tuple(mount["stiffness"]), mount["damping"]) if mount else None
    return Frame(tuple(about) if about else None, mount=mount, **values)


def _place(name: str, section: Tree) -> Location:
    point = section.get("point")
    return Location(name, section["body"], tuple(point) if point else None)


def _drive(section: Tree, laws: str) -> case.Drive:
    speed, angle, motor, servo, values = _split_keys(section, "speed", "angle", "motor", "servo")
    if isinstance(speed, dict):
        return case.Drive(table=_table(speed["table"]), **values)
    if angle:
        path = _table(angle["table"])
        return case.Drive(table=path, start_angle=path["angle"][0], **values)
    if servo:
        target, own_values = _split_keys(servo, "target")
        return case.Drive(table=_table(target["table"]), values=own_values, **values)
    if motor and "table" in motor:
        return case.Drive(table=_table(motor["table"]), **values)
    if motor and "law" in motor:
        law, own_values = _split_keys(motor, "law")
        return case.Drive(law=law, values=own_values, laws=laws, **values)
    if motor:
        return case.Drive(torque=motor["stall_torque"], no_load_speed=motor["no_load_speed"], **values)
    return case.Drive(**values) if speed is None else case.Drive(speed=speed, **values)


def _load(section: Tree, load: LoadOutline, laws: str) -> case.Load:
    table, friction, remainder = _split_keys(section, "table", "friction")
    friction_law = _with_values(case.Friction, friction) if friction else None
    return case.Load(
        load.name, load.form, dict(leaves(remainder)), _table(table) if table else None, friction_law, laws
    )


def _table(columns: Tree) -> case.Table:
    return {name: tuple(values) for name, values in columns.items()}


def _joint(section: Tree, name: str, laws: str) -> case.Joint:
    values: dict[str, Any] = {"contact": case.NO_CONTACT, **section}
    values.pop("stops", None)
    if values.pop("type", None) == ROLLING:
        values = _rolling(values)
    play = values.get("backlash", values.get("play"))
    if play is not None:
        values["clearance"] = 0.5 * play
    for key, build in _JOINT_SECTIONS:
        if key in section:
            values[key] = _typed(build, section[key])
    return case.Joint(name=name, laws=laws, **values)


def _stops(section: Tree, joint: JointOutline, outline: Outline) -> case.Joint:
    """Return the stops of a joint, which have a name of their own next to a clearance."""
    name, at = (
        f"{joint.name}{case.SUFFIX_WITH_CLEARANCE if joint.name in outline.clearances else ''}",
        tuple(section["at"]),
    )
    stops = case.Joint(name, 0.5 * (at[1] - at[0]), _contact(section["contact"]), stops=at, stopped=joint.name)
    return stops._replace(slides=joint.type == "prismatic", laws=outline.laws)


def _rolling(section: Tree) -> dict[str, Any]:
    """Return the values of a joint that is a rolling bearing, whose diametral clearance becomes a radial one."""
    material, capacity = section.get("material"), section.get("capacity", {})
    sections = {"groove": tuple(section.get("groove", ())), "capacity": case.Capacity(**capacity)}
    sections |= {"material": case.Material(**material)} if material else {}
    own = {key: value for key, value in section.items() if key in case.Rolling._fields}
    others = {key: value for key, value in section.items() if key not in case.Rolling._fields}
    elements = own | sections | {"elements": int(section["elements"])}
    return others | {"clearance": 0.5 * section["clearance"], "rolling": case.Rolling(**elements)}


def _with_values(kind: Callable[..., Any], section: Tree, **further: Any) -> Any:
    """Return a record of a kind whose field `values` has the keys of a section that are no fields of it."""
    names = kind._fields  # type: ignore[attr-defined]
    fields = {key: value for key, value in section.items() if key in names}
    return kind(**fields, values={key: value for key, value in section.items() if key not in names}, **further)


def _wear(section: Tree) -> case.Wear:
    unit, others = _split_keys(section, "coefficient_unit")
    wear: case.Wear = _with_values(case.Wear, others, dimensionless=unit == DIMENSIONLESS)
    return wear


def _thermal(section: Tree) -> case.Thermal:
    expansion, housing, values = _split_keys(section, "expansion", "housing")
    return case.Thermal(**values, **(expansion or {}), housing=case.Housing(**housing) if housing else None)


def _film(section: Tree) -> case.Film:
    transition, viscosity, thermal, values = _split_keys(section, "transition", "viscosity", "thermal")
    if transition:
        law, start, width, remainder = _split_keys(transition, "law", "from", "width")
        values |= {"transition": law, "begin": start, "width": width, "asperities": remainder}
    values["own"] = {key: values.pop(key) for key in [*values] if key not in case.Film._fields}
    if not isinstance(viscosity, dict):
        return case.Film(viscosity=viscosity, **values)
    oil = case.Oil(viscosity["at_40C"], viscosity["at_100C"], viscosity["density"])
    if thermal:
        values |= {"thermal": case.Thermal(**thermal)}
        values.setdefault("temperature", thermal["ambient"])
    return case.Film(viscosity=oil.viscosity(values["temperature"]), density=oil.density, oil=oil, **values)


def _contact(section: Tree) -> case.Contact:
    material, fit, others = _split_keys(section, "material", "fit")
    contact: case.Contact = _with_values(case.Contact, {"elastic": None} | others)
    if material:
        parts = [material[body] if "bearing" in material else material for body in case.Materials._fields]
        contact = contact._replace(material=case.Materials(*(case.Material(**part) for part in parts)))
    return contact._replace(fit=_table(fit)) if fit else contact


def _roughness(section: Tree) -> case.Roughness:
    tables = {key: _table(value) for key, value in section.items() if isinstance(value, dict)}
    others = {key: value for key, value in section.items() if key not in tables}
    roughness: case.Roughness = _with_values(case.Roughness, others, tables=tables)
    return roughness


_JOINT_SECTIONS: tuple[tuple[str, Callable[[Any], Any]], ...] = (
    ("contact", _contact),
    ("roughness", _roughness),
    ("axial", _contact),
    ("mesh_stiffness", _table),
    ("tilt", tuple),
    ("offset", tuple),
    ("friction", partial(_with_values, case.Friction)),
    ("profile", partial(_with_values, case.Profile)),
    ("wear", _wear),
    ("film", _film),
    ("thermal", _thermal),
)


def _split_keys(section: Tree, *keys: str) -> tuple[Any, ...]:
    """Return the values of some keys, None for missing ones, and a dict of all others."""
    return (*(section.get(key) for key in keys), {key: value for key, value in section.items() if key not in keys})
