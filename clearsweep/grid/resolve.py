"""From a resolved case in the shape of a grid file to its typed form: the last place where a case is a dict."""

from collections.abc import Iterator, Mapping
from typing import Any

from ..contracts.case import (
    NO_CONTACT,
    Case,
    Contact,
    Drive,
    Film,
    Friction,
    Joint,
    Life,
    Load,
    Material,
    Materials,
    Mechanism,
    Oil,
    Roughness,
    Save,
    Simulate,
    Table,
    Thermal,
    Until,
    Wear,
)
from ..contracts.outline import Outline
from .key_table import DIMENSIONLESS

Tree = Mapping[str, Any]  # a section of a grid file in SI: key -> number, word, list or section


def case_of(tree: Tree, outline: Outline) -> Case:
    """Return the typed form of a case: nested sections, SI, defaults filled in, only keys in use."""
    kind, bodies = _taken(tree["mechanism"], "type")
    simulate = tree["simulate"]
    if "until" in simulate:
        simulate = dict(simulate) | {"until": Until(**simulate["until"])}
    return Case(
        mechanism=Mechanism(kind, dict(leaves(bodies))),
        joints=tuple(_joint(name, section) for name, section in tree["joints"].items()),
        simulate=Simulate(**simulate),
        save=Save(**tree["save"]),
        drive=_drive(tree["drive"]) if "drive" in tree else None,
        loads=tuple(_load(load.name, load.form, tree["loads"][load.name]) for load in outline.loads),
        outline=outline,
        life=Life(**tree["life"]) if "life" in tree else None,
    )


def _drive(section: Tree) -> Drive:
    speed, motor, values = _taken(section, "speed", "motor")
    if isinstance(speed, dict):
        return Drive(table=_table(speed["table"]), **values)
    if motor:
        return Drive(torque=motor["stall_torque"], no_load_speed=motor["no_load_speed"], **values)
    return Drive(**values) if speed is None else Drive(speed=speed, **values)


def _load(name: str, form: str, section: Tree) -> Load:
    table, friction, rest = _taken(section, "table", "friction")
    rubbing = Friction(*_taken(friction, "law")) if friction else None
    return Load(name, form, dict(leaves(rest)), _table(table) if table else None, rubbing)


def _table(columns: Tree) -> Table:
    return {name: tuple(values) for name, values in columns.items()}


def _joint(name: str, section: Tree) -> Joint:
    sections: dict[str, Any] = {"contact": _contact(section["contact"]) if "contact" in section else NO_CONTACT}
    if "roughness" in section:
        sections["roughness"] = _roughness(section["roughness"])
    if "axial" in section:
        sections["axial"] = _contact(section["axial"])
    for listed in ("tilt", "offset"):
        if listed in section:
            sections[listed] = tuple(section[listed])
    if "friction" in section:
        sections["friction"] = Friction(*_taken(section["friction"], "law"))
    if "wear" in section:
        sections["wear"] = _wear(section["wear"])
    if "film" in section:
        sections["film"] = _film(section["film"])
    return Joint(name=name, **(_taken(section, "type")[1] | sections))


def _wear(section: Tree) -> Wear:
    law, pressure, bins, unit, running_in, evolve, along, values = _taken(
        section, "law", "pressure", "bins", "coefficient_unit", "running_in", "evolve", "length_bins"
    )
    return Wear(law, pressure, bins, values, unit == DIMENSIONLESS, running_in, bool(evolve), along or 1)


def _film(section: Tree) -> Film:
    transition, viscosity, thermal, values = _taken(section, "transition", "viscosity", "thermal")
    if transition:
        law, begin, width, rest = _taken(transition, "law", "from", "width")
        values |= {"transition": law, "begin": begin, "width": width, "asperities": rest}
    if not isinstance(viscosity, dict):
        return Film(viscosity=viscosity, **values)
    oil = Oil(viscosity["at_40C"], viscosity["at_100C"], viscosity["density"])
    if thermal:
        values |= {"thermal": Thermal(**thermal)}
        values.setdefault("temperature", thermal["ambient"])
    return Film(viscosity=oil.viscosity(values["temperature"]), density=oil.density, oil=oil, **values)


def _contact(section: Tree) -> Contact:
    law, elastic, material, onset, fit, values = _taken(section, "law", "elastic", "material", "onset", "fit")
    return Contact(
        law, elastic, values, _materials(material) if material else None, onset, _table(fit) if fit else None
    )


def _roughness(section: Tree) -> Roughness:
    law, values = _taken(section, "law")
    tables = {key: _table(value) for key, value in values.items() if isinstance(value, dict)}
    return Roughness(law, {key: value for key, value in values.items() if key not in tables}, tables)


def _materials(section: Tree) -> Materials:
    """Return the materials of bearing and journal: each its own, or one for both."""
    own = "bearing" in section
    return Materials(*(Material(**(section[body] if own else section)) for body in Materials._fields))


def _taken(section: Tree, *keys: str) -> tuple[Any, ...]:
    """Return the values of some keys, None for one that is not there, and a dict of all others."""
    return (*(section.get(key) for key in keys), {key: value for key, value in section.items() if key not in keys})


def leaves(tree: Tree, start: str = "") -> Iterator[tuple[str, Any]]:
    """Yield dotted path and value of everything in nested sections and lists."""
    for key, value in tree.items():
        if isinstance(value, dict):
            yield from leaves(value, f"{start}{key}.")
        elif isinstance(value, list):
            yield from ((f"{start}{key}.{place}", item) for place, item in enumerate(value))
        else:
            yield f"{start}{key}", value
