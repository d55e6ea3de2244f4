"""Keys of joints: contact, friction, heat, roughness, oil films, joints in space, and rolling bearings."""

import itertools
import math
from collections.abc import Iterable, Mapping
from typing import Any

from ...contracts.case import Materials
from ...contracts.catalogue import CHOICE, CONDITION, MODEL, Catalogue, Field, JointSite, Law, ranged
from ...contracts.layout import PRELOAD
from ..library import MATERIALS, OILS, bearing_names
from ..library.fits import MOUNTING_KEYS
from . import (
    Condition,
    ConditionalDefault,
    Flag,
    KeyTable,
    Name,
    Number,
    Section,
    Table,
    Use,
    Word,
    section_key,
    word_key,
)
from .library_names import BEARING, HOUSING_MATERIAL, MATERIAL, OIL, UNCHECKED

# ----------------------------------------------------------------------------------------------------------------------
# Keys of joints: contact, friction, heat, roughness, oil films, and joints in space.


JOURNAL_LAW = "compatible"  # name of the elastic law of a journal in a bearing

_YIELD_STRENGTH_TEXT = "yield strength of {}, used only for `J_yield_speed`; default: the hardness divided by 2.8"
_MATERIAL_FIELDS = (
    Field("young", "Pa", "Young's modulus of {}"),
    ranged("poisson", "1", "Poisson's ratio of {}", "(-1, 0.5]"),
    Field("yield_strength", "Pa", _YIELD_STRENGTH_TEXT, optional=True),
)

_ONSET_TEXT = (
    "period for which the damping uses the onset rate of a contact; first: until the surfaces separate; "
    "renewed: until a lasting contact begins"
)
ONSET_KEY = Word(("first", "renewed"), _ONSET_TEXT, "renewed", sweep=True, role=MODEL, may_be_unused=True)


def add_numbers(keys: KeyTable, path: str, fields: tuple[Field, ...], role: str, *, sweep: bool = True) -> None:
    """Add keys that are in use with any choice of laws; role : of the fields that have none of their own."""
    for field in fields:
        keys[f"{path}.{field.name}"] = Number((Use(field),), field.role or role, sweep)


def law_key(names: tuple[str, ...], text: str, default: str | None = None, **further: Any) -> Word:
    """Return the key of a law's name; further : fields of Word."""
    return Word(names, text, default, sweep=True, noun="law", role=MODEL)._replace(**further)


def add_friction(keys: KeyTable, path: str, catalogue: Catalogue, refusal: str = "") -> None:
    """Add the keys of friction in a joint; refusal : why it cannot have laws that stick or keep a state, or ''."""
    laws = tuple(law for law in catalogue.of("friction") if not (refusal and (law.has_state or law.sticks)))
    names = tuple(law.name for law in laws)
    refused = dict.fromkeys(set(catalogue.names("friction")) - set(names), refusal)
    keys[f"{path}.friction"] = Section(
        "friction of the joint. Without this section, the joint has no friction", "optional"
    )
    keys[f"{path}.friction.law"] = law_key(names, "the friction law", refused=refused)
    add_laws(keys, f"{path}.friction", "law", laws)


def add_profile(keys: KeyTable, path: str, catalogue: Catalogue) -> None:
    """Add the keys of the shape of a bearing, where a law file declares one."""
    if laws := catalogue.of("profile"):
        keys[f"{path}.profile"] = Section("shape of the bearing. Without this section, it is a circle", "optional")
        text = "law of the shape, of a law file"
        keys[f"{path}.profile.law"] = law_key(catalogue.names("profile"), text, role=CHOICE)
        add_laws(keys, f"{path}.profile", "law", laws)


_PIN_PRELOAD_TEXT = (
    "constant force on the joint, such as the force of a seal; its friction acts as a torque, "
    "friction force x bearing_radius"
)
GUIDE_PRELOAD_TEXT = "constant force on the block, such as the force of a seal; its friction acts along the guide"


def add_preload(keys: KeyTable, path: str, catalogue: Catalogue, text: str = _PIN_PRELOAD_TEXT) -> None:
    """Add the keys of the preload of a pin, or of a guide, which also acts without contact."""
    laws = frozenset(law.name for law in catalogue.of("friction") if not law.sticks)
    key_use = Use(Field(PRELOAD, "N", text, optional=True), ((f"{path}.friction.law", laws),))
    keys[f"{path}.friction.{PRELOAD}"] = Number((key_use,), CONDITION)


def add_contact(keys: KeyTable, path: str, catalogue: Catalogue, contact: str = "") -> None:
    """Add the keys of the normal force of a joint, or at the path `contact`: law, elastic part, and parameters."""
    contact = contact or f"{path}.contact"
    elastic_in_use = ((f"{contact}.law", frozenset(law.name for law in catalogue.of("law") if law.uses_elastic)),)
    keys[contact] = Section("law and parameters of the normal force")
    keys[f"{contact}.law"] = law_key(catalogue.names("law"), "law of the normal force")
    keys[f"{contact}.elastic"] = _elastic_law_key(path, catalogue, contact)._replace(when=elastic_in_use)
    onset_in_use = ((f"{contact}.law", frozenset(law.name for law in catalogue.of("law") if law.uses_onset)),)
    keys[f"{contact}.onset"] = ONSET_KEY._replace(when=onset_in_use)
    add_laws(keys, contact, "elastic", catalogue.of("elastic"), elastic_in_use)
    add_laws(keys, contact, "law", catalogue.of("law"))
    material = f"{contact}.material"
    keys[material] = Section(
        "material of both bodies, or its name; it determines the stiffness unless `stiffness` is given", "optional"
    )
    add_material_name(keys, material, "of both bodies")
    for field in _MATERIAL_FIELDS:
        requirement_text = "" if field.optional else "; required unless each body has its own"
        default_field = field._replace(text=field.text.format("both bodies") + requirement_text, optional=True)
        keys[f"{material}.{field.name}"] = Number((Use(default_field, elastic_in_use),), CHOICE)
    for body in Materials._fields:
        keys[f"{material}.{body}"] = Section(
            f"material of the {body}, or its name; write the materials of both bodies or of neither", "optional"
        )
        add_material_name(keys, f"{material}.{body}", f"of the {body}")
        for field in _MATERIAL_FIELDS:
            body_field = field._replace(text=field.text.format(f"the {body}"))
            keys[f"{material}.{body}.{field.name}"] = Number((Use(body_field, elastic_in_use),), CHOICE)


def add_name(keys: KeyTable, path: str, key: str, names: Iterable[str], text: str) -> None:
    """Add a key that takes a name of a library, and the consent to values from memory."""
    keys[f"{path}.{key}"] = Name(tuple(names), text)
    keys[f"{path}.{UNCHECKED}"] = Flag("consent to values of a library that were compared with no published text")


def add_material_name(keys: KeyTable, path: str, bodies_text: str) -> None:
    """Add the key that names a material; the name may also replace the section."""
    text = f"name of the material {bodies_text}, from `clearsweep list materials`"
    add_name(keys, path, MATERIAL, MATERIALS, f"{text}; numbers in the same section override its values")


def _elastic_law_key(path: str, catalogue: Catalogue, contact: str) -> Word:
    """Return the key of the elastic law; its default is JOURNAL_LAW if its inputs are given but no stiffness."""
    names = catalogue.names("elastic")
    key = law_key(names, "law of the elastic force", "power")
    if JOURNAL_LAW not in names:
        return key
    hertzian_laws = frozenset(law.name for law in catalogue.of("law") if "hertz" in law.needs)
    default_rule = ConditionalDefault(
        JOURNAL_LAW,
        all_of=(f"{contact}.material", f"{path}.length", f"{path}.bearing_radius"),
        none_of=(f"{contact}.stiffness", f"{contact}.exponent"),
        unless=(f"{contact}.law", hertzian_laws),
    )
    text = (
        f"{key.text}; default: {JOURNAL_LAW} if `material` and `length` are given without `stiffness` and `exponent`, "
        "otherwise power"
    )
    return key._replace(text=text, conditional_default=default_rule)


def add_thermal(keys: KeyTable, path: str) -> None:
    """Add the keys of a dry joint's heat balance."""
    thermal = f"{path}.thermal"
    text = "heat balance of dry friction: temperature = ambient + mean friction power / conductance"
    keys[thermal] = Section(f"{text}. Without this section, friction does not heat the joint", "optional")
    add_numbers(keys, thermal, HEAT_BALANCE_FIELDS, CHOICE)
    text = "thermal expansion of both bodies. Without this section, the temperature does not change the clearance"
    keys[f"{thermal}.expansion"] = Section(text, "optional")
    for body in Materials._fields:
        field = ranged(
            body, "1/K", f"coefficient of thermal expansion of the {body}; a named material provides it", "[0, inf)"
        )
        add_numbers(keys, f"{thermal}.expansion", (field,), CHOICE)
    housing = f"{thermal}.housing"
    keys[housing] = Section(
        "housing that grips the bearing, a bush, at its outside and does not give. Without this section, the bearing "
        "expands freely",
        "optional",
    )
    text = "material of the housing, from `clearsweep list materials`; it provides the expansion"
    add_name(keys, housing, HOUSING_MATERIAL, MATERIALS, text)
    add_numbers(keys, housing, HOUSING_FIELDS, CHOICE)


def add_laws(
    keys: KeyTable, path: str, key: str, laws: tuple[Law, ...], when: tuple[Condition, ...] = (), role: str = CHOICE
) -> None:
    """Add the keys of the laws that `key` chooses from; the chosen law decides the meaning of a shared key.

    role : of the numbers that have none of their own
    """
    for law in laws:
        for field in law.fields:
            key_use = Use(field, (*when, (f"{path}.{key}", frozenset((law.name,)))))
            existing_key = keys.get(f"{path}.{field.name}")
            uses = existing_key.uses if isinstance(existing_key, Number) else ()
            if not uses or any(existing_use.when for existing_use in uses):
                keys[f"{path}.{field.name}"] = Number((*uses, key_use), field.role or role)
    tables = {
        columns: frozenset(law.name for law in laws if columns in law.tables) for law in laws for columns in law.tables
    }
    for columns, names in tables.items():
        keys[f"{path}.{columns.name}"] = Table(columns, (*when, (f"{path}.{key}", names)), optional=True)


def modulus_paths(joint: str) -> tuple[str, ...]:
    """Return the paths in a joint that determine the modulus for wear pressure."""
    return f"{joint}.contact.material", f"{joint}.wear.pressure_modulus"


def laws_of_point_contacts(catalogue: Catalogue) -> tuple[Law, ...]:
    """Return the contact laws that are suitable for a point without a radius."""
    return tuple(law for law in catalogue.laws if law.family != "elastic" or not law.needs)


def onset_key_without_mass(keys: KeyTable, contact: str) -> Word:
    """Return the key `onset` for contacts whose effective impact mass is unknown."""
    text = "period for which the damping uses the onset rate of a contact; first: until the surfaces separate"
    return word_key(keys, f"{contact}.onset")._replace(options=("first",), default="first", text=text)


DEFAULT_FILM_LAW = "reynolds"
_LIMIT_TEXT = "largest eccentricity ratio of the film's formula; beyond it, the formula is evaluated at this value"
OIL_FIELDS = (
    ranged("at_40C", "m^2/s", "kinematic viscosity of the oil at 40 degC", "(2e-6, inf)"),
    ranged("at_100C", "m^2/s", "kinematic viscosity of the oil at 100 degC, lower than at 40 degC", "(2e-6, inf)"),
    Field("density", "kg/m^3", "density of the oil"),
)
HEAT_BALANCE_FIELDS = (
    Field("conductance", "W/K", "heat flow per temperature difference to the surroundings"),
    Field("ambient", "K", "temperature of the surroundings", role=CONDITION),
)
_EXPANSION_TEXT = "coefficient of thermal expansion of the housing; a named material provides it"
HOUSING_FIELDS = (ranged("expansion", "1/K", _EXPANSION_TEXT, "[0, inf)"), Field("wall", "m", "thickness of the bush"))
_TRANSITION_TEXT = "eccentricity minus clearance at which the dry contact begins to carry load"
TRANSITION_FIELDS = (
    ranged("from", "m", _TRANSITION_TEXT, "[0, inf)", default=0.0),
    Field("width", "m", "range over which the load passes from the film to the dry contact", default=2e-6),
)


def add_roughness(keys: KeyTable, path: str, catalogue: Catalogue) -> None:
    """Add the keys of a joint's surface roughness."""
    roughness = f"{path}.roughness"
    text = "roughness of the surfaces, in series with the elastic law. Without this section, the surfaces are smooth"
    keys[roughness] = Section(text, "optional")
    keys[f"{roughness}.law"] = law_key(catalogue.names("roughness"), "law of the roughness")
    add_laws(keys, roughness, "law", catalogue.of("roughness"))


def add_film(keys: KeyTable, path: str, catalogue: Catalogue) -> None:
    """Add the keys of a joint's oil film, with or without dry contact."""
    keys[f"{path}.contact"] = section_key(keys, f"{path}.contact")._replace(unless="film")
    film = f"{path}.film"
    keys[film] = Section("oil film. Without this section, the joint has no film", "optional")
    keys[f"{film}.law"] = law_key(catalogue.names("film"), "law of the film force", DEFAULT_FILM_LAW)
    add_name(keys, film, OIL, OILS, "oil from `clearsweep list oils`; it determines viscosities and density")
    text = "dynamic viscosity of the oil, or kinematic viscosities at two temperatures"
    add_numbers(keys, film, (Field("viscosity", "Pa*s", text),), CHOICE)
    add_numbers(keys, f"{film}.viscosity", OIL_FIELDS, CHOICE)
    text = "temperature of the oil; required with two viscosities"
    add_numbers(keys, film, (Field("temperature", "K", text, optional=True),), CONDITION)
    add_numbers(keys, film, (ranged("limit", "1", _LIMIT_TEXT, "(0, 0.999]", default=0.99),), MODEL)
    add_laws(keys, film, "law", catalogue.of("film"))
    keys[f"{film}.thermal"] = Section(
        "heat balance of the film: temperature = ambient + mean loss / conductance", "optional"
    )
    add_numbers(keys, f"{film}.thermal", HEAT_BALANCE_FIELDS, CHOICE)
    text = "law of the torque from the shear of the film; by-law: butenschoen"
    keys[f"{film}.friction"] = law_key(("by-law", *catalogue.names("film-friction")), text, "by-law")
    keys[f"{film}.transition"] = Section("transition from the film to dry contact", "implied", needs="contact")
    transition = f"{film}.transition"
    text = "law of the transition from the film to dry contact"
    keys[f"{transition}.law"] = law_key(catalogue.names("transition"), text, "ramp")
    add_numbers(keys, transition, TRANSITION_FIELDS, MODEL)
    add_laws(keys, transition, "law", catalogue.of("transition"), role=MODEL)


_SPATIAL_SIZES = (
    Field("clearance", "m", "radial clearance"),
    Field("bearing_radius", "m", "radius of the bearing; the radius of the journal is smaller by the clearance"),
    Field("length", "m", "length of the bearing along its axis"),
    Field("journal_length", "m", "length of the journal; default: the length of the bearing", optional=True),
)
_AXIAL_CLEARANCE_TEXT = "clearance between the ends of bearing and journal on each side, with the journal in the middle"
_AXIAL_CLEARANCE = Field("axial_clearance", "m", _AXIAL_CLEARANCE_TEXT)
_MISALIGNMENTS = (
    ("tilt", "rotation vector of the bearing about x and y of its body", "rad", 2),
    ("offset", "offset of the bearing's middle along the axes of its body", "m", 3),
)


def add_flanges(keys: KeyTable, path: str, catalogue: Catalogue) -> None:
    """Add the further keys of a spatial revolute joint with flanges."""
    add_numbers(keys, path, (_AXIAL_CLEARANCE,), CHOICE)
    axial = f"{path}.axial"
    _add_point_contact(keys, axial, catalogue._replace(laws=laws_of_point_contacts(catalogue)))
    for nested in [nested for nested in keys if nested.startswith(f"{axial}.material")]:
        del keys[nested]
    keys[axial] = Section(
        "normal force at a flange. Without this section, `contact` also applies to the flanges", "optional"
    )


def add_spatial_revolute(keys: KeyTable, path: str, catalogue: Catalogue) -> None:
    """Add the keys of a spatial revolute joint without flanges."""
    keys[path] = Section("a revolute joint with radial and axial clearance, in which the journal may tilt", "optional")
    refused = {"rolling": "a rolling bearing acts in the plane of its rings only; write the mechanism in the plane"}
    keys[f"{path}.type"] = Word(("spatial",), "kind of the joint", refused=refused)
    add_numbers(keys, path, _SPATIAL_SIZES, CHOICE)
    keys[f"{path}.flange"] = Flag(
        "the bearing has flanges, `axial_clearance` away from the journal on each side", default=True
    )
    elastic = frozenset(law.name for law in catalogue.of("law") if not law.yields)
    keys[f"{path}.walls"] = Word(
        ("spread", "ends"),
        "distribution of the load along the walls; spread: evenly over the overlap of journal and bore; ends: at the "
        "two ends, with half of the stiffness each; laws with permanent indentation always use `ends`",
        "spread",
        sweep=True,
        role=MODEL,
        when=((f"{path}.contact.law", elastic),),
        may_be_unused=True,
    )
    for name, text, unit, count in _MISALIGNMENTS:
        keys[f"{path}.{name}"] = Section(text, "implied", count)
        axes = (
            ranged(str(k), unit, f"about {axis}" if unit == "rad" else f"along {axis}", "(-inf, inf)", default=0.0)
            for k, axis in enumerate("xyz"[:count])
        )
        add_numbers(keys, f"{path}.{name}", tuple(axes), CONDITION)
    _add_point_contact(keys, f"{path}.contact", catalogue)
    add_friction(keys, path, catalogue, "is not for a joint in space; choose a law that keeps no state")


def _add_point_contact(keys: KeyTable, contact: str, catalogue: Catalogue) -> None:
    """Add the keys of the normal force at contact points, whose effective impact mass is unknown."""
    add_contact(keys, contact.rpartition(".")[0], catalogue, contact)
    keys[f"{contact}.onset"] = onset_key_without_mass(keys, contact)


# ----------------------------------------------------------------------------------------------------------------------
# Keys of rolling bearings, and what their values must fulfil together.


ROLLING = "rolling"  # the word in `type` of a joint
KINDS = ("ball", "roller", "needle")
ROUNDING = 1e-9  # of a diameter; rollers without an inner ring roll on the shaft, whose diameter is the bore
LARGEST_CLEARANCE = 0.1  # of an element's diameter, either way
#: Sections that other joints may have, and why a rolling bearing has none.
REFUSED_SECTIONS = {
    "film": "grease and the film between elements and rings are not modelled; leave it out",
    "wear": "the wear of rolling elements and rings is not modelled; leave it out",
    "roughness": "the elements of a rolling bearing are smooth here; leave it out",
    "thermal": "the warmth of a rolling bearing is not modelled; write the clearance that it has when warm",
    "bearing_radius": "a rolling bearing has no bearing radius; write element_diameter and pitch_diameter",
    "axial_clearance": "a rolling bearing acts in the plane of its rings; axial loads, misaligned rings and crowned "
    "rollers are not modelled; leave it out",
}
_BALLS = frozenset(KINDS[:1])
_ROLLERS = frozenset(KINDS[1:])
_OUTSIDE_DIAMETER_TEXT = "outside diameter of the outer ring, on which the clearance of a mounted bearing depends"
_BORE_TEXT = "diameter of the hole of the inner ring; the friction of the bearing acts at half of it"
_ROLLING_CLEARANCE_TEXT = (
    "radial internal clearance as catalogues give it: how far the rings can move from one extreme to the other; "
    "negative: a preload; or a group of ISO 5753-1 as {group: C3}, mounted as {group: C3, fit: k5/H7, "
    "inner_warmer: 5 K}"
)
_SIZES = (
    ranged("clearance", "m", _ROLLING_CLEARANCE_TEXT, "(-inf, inf)", fit="group"),
    Field("element_diameter", "m", "diameter of an element"),
    Field("pitch_diameter", "m", "diameter of the circle on which the centres of the elements lie"),
    Field("bore", "m", _BORE_TEXT, optional=True),
    Field("outside_diameter", "m", _OUTSIDE_DIAMETER_TEXT, optional=True),
)
_ELEMENTS = ranged("elements", "1", "number of elements", "[3, 60]", integer=True)
_GROOVES = tuple(
    ranged(str(k), "1", f"radius of the groove of the {ring} ring over the diameter of a ball", "(0.5, 1)")
    for k, ring in enumerate(("inner", "outer"))
)
_LENGTH = Field("length", "m", "effective length of a roller along its axis")
_PHASE = ranged(
    "phase", "rad", "angle of the first element in the fixed frame at the start", "(-inf, inf)", default=0.0
)
_MATERIAL = (
    Field("young", "Pa", "Young's modulus of balls and rings", default=210e9),
    ranged("poisson", "1", "Poisson's ratio of balls and rings", "(-1, 0.5]", default=0.3),
)
_CAPACITY = (
    Field("dynamic", "N", "basic dynamic radial load rating C (ISO 281), as a catalogue gives it", optional=True),
    Field("static", "N", "basic static radial load rating C0 (ISO 76), as a catalogue gives it", optional=True),
)


def add_rolling(keys: KeyTable, path: str, site: JointSite, catalogue: Catalogue) -> None:
    """Add the keys of a rolling bearing."""
    kind = f"{path}.kind"
    keys[path] = Section("a rolling bearing with internal clearance", "optional")
    keys[f"{path}.type"] = Word((ROLLING,), "kind of the joint")
    text = (
        "rolling bearing from `clearsweep list bearings`, also with a group, such as 6204 C3; it determines kind, "
        "sizes, ratings and clearance, and keys next to it override its values"
    )
    add_name(keys, path, BEARING, bearing_names(), text)
    for name, text in MOUNTING_KEYS.items():
        keys[f"{path}.{name}"] = Name((), f"{text}; for every group of the clearance")
    keys[kind] = Word(
        KINDS, "kind of the elements; needle: long rollers; `bearing: 6204` gives it and all sizes", noun="kind"
    )
    add_numbers(keys, path, _SIZES, CHOICE)
    add_numbers(keys, path, (_ELEMENTS,), CHOICE, sweep=False)
    add_numbers(keys, path, (_PHASE,), CONDITION)
    keys[f"{path}.groove"] = Section("radii of the grooves of balls, inner ring first", "optional", len(_GROOVES))
    for field in _GROOVES:
        keys[f"{path}.groove.{field.name}"] = Number((Use(field, ((kind, _BALLS),)),), CHOICE)
    keys[f"{path}.length"] = Number((Use(_LENGTH, ((kind, _ROLLERS),)),), CHOICE)
    keys[f"{path}.journal"] = Word(site.journals, "body that carries the inner ring", site.journals[0])
    _add_element_contact(keys, path, catalogue)
    keys[f"{path}.material"] = Section("material of balls and rings; default: steel", "optional")
    add_material_name(keys, f"{path}.material", "of balls and rings")
    for field in _MATERIAL:
        keys[f"{path}.material.{field.name}"] = Number((Use(field, ((kind, _BALLS),)),), CHOICE)
    keys[f"{path}.capacity"] = Section("load ratings of the bearing", "optional")
    add_numbers(keys, f"{path}.capacity", _CAPACITY, CHOICE)
    add_friction(keys, path, catalogue, "is not for a rolling bearing; choose a law that keeps no state")
    text = (
        "friction of the whole bearing: the law's force under the resultant load, at half of the bore. A constant "
        "coefficient gives the moment of catalogues, 0.5 x coefficient x load x bore. Without this section, the "
        "bearing turns freely"
    )
    keys[f"{path}.friction"] = Section(text, "optional")


def _add_element_contact(keys: KeyTable, path: str, catalogue: Catalogue) -> None:
    """Add the keys of the normal force of each element, whose elastic part follows from the sizes."""
    contact = f"{path}.contact"
    with_mass = {law.name for law in catalogue.laws for field in law.fields if field.name == "mass"}
    laws = [law for law in catalogue.of("law") if law.uses_elastic and not law.yields and law.name not in with_mass]
    keys[contact] = Section("law of the normal force of each element; its elastic part follows from the sizes")
    names = tuple(law.name for law in laws)
    reason = "is not for a rolling bearing, whose sizes give the elastic law; choose a law that uses it without a mass"
    refused = dict.fromkeys(set(catalogue.names("law")) - set(names), reason)
    keys[f"{contact}.law"] = law_key(names, "law of the normal force", refused=refused)
    add_laws(keys, contact, "law", tuple(laws))
    onset_laws = frozenset(law.name for law in laws if law.uses_onset)
    keys[f"{contact}.onset"] = ONSET_KEY._replace(when=((f"{contact}.law", onset_laws),))
    keys[f"{contact}.onset"] = onset_key_without_mass(keys, contact)
    for name, key in keys.items():
        if isinstance(key, Number) and name.startswith(f"{contact}."):
            keys[name] = key._replace(uses=tuple(_of_balls(key_use, path) for key_use in key.uses))


def _of_balls(key_use: Use, path: str) -> Use:
    """Return a meaning of a key whose unit depends on the elastic exponent with that of balls, which alone have it."""
    if not key_use.field.unit.endswith("^exponent+1"):
        return key_use
    unit = key_use.field.unit.replace("exponent+1", "2.5")
    return Use(key_use.field._replace(unit=unit), ((f"{path}.kind", _BALLS), *key_use.when))


def conflicts(values: Mapping[str, tuple[float, ...]], given: set[str]) -> list[tuple[str, str]]:
    """Return (key of a rolling bearing, what is wrong) for values that do not fit together.

    values : key -> all its values in SI.  given : the sections and keys that the grid writes.
    """
    counts, clearances, bores = (values[name] for name in ("elements", "clearance", "bore"))
    problems = []
    for diameter, pitch in itertools.product(values["element_diameter"], values["pitch_diameter"]):
        chord = min((pitch * math.sin(math.pi / count) for count in counts), default=math.inf)
        if diameter >= chord:
            text = (
                f"found {_mm(diameter)}, but {max(counts):g} elements on a pitch diameter of {_mm(pitch)} overlap from "
                f"{_mm(chord)} on; write fewer or smaller elements"
            )
            problems.append(("element_diameter", text))
        raceway = (pitch - diameter) * (1.0 + (ROUNDING if "length" in given else -ROUNDING))
        if max(bores, default=0.0) > raceway:
            limit = "at most" if "length" in given else "below"
            text = (
                f"found {_mm(max(bores))}; allowed: {limit} {_mm(pitch - diameter)}, the pitch diameter minus an "
                "element's, as the inner ring lies between"
            )
            problems.append(("bore", text))
        if min(values["outside_diameter"], default=math.inf) <= pitch + diameter:
            text = (
                f"found {_mm(min(values['outside_diameter']))}; allowed: above {_mm(pitch + diameter)}, the pitch "
                "diameter plus an element's, as the outer ring lies outside"
            )
            problems.append(("outside_diameter", text))
        if max(map(abs, clearances), default=0.0) > LARGEST_CLEARANCE * diameter:
            text = (
                f"found {_mm(max(clearances, key=abs))}; allowed: up to {_mm(LARGEST_CLEARANCE * diameter)} "
                f"either way, {LARGEST_CLEARANCE:g} of the diameter of an element"
            )
            problems.append(("clearance", text))
    if "friction" in given and "bore" not in given:
        problems.append(("bore", "is missing; friction acts at half of the bore; for example: 20 mm"))
    return list(dict(problems).items())


def _mm(length: float) -> str:
    return f"{1e3 * length:.6g} mm"
