"""Keys of rolling bearings, and what their values must fulfil together."""

import itertools
import math
from collections.abc import Mapping

from ...contracts.catalogue import CHOICE, CONDITION, MODEL, Catalogue, Field, JointSite
from ..library.bearings import bearing_names
from ..library.mounting import MOUNTING_KEYS
from .joint_keys import (
    ONSET_KEY,
    UNCHECKED_KEY,
    add_friction,
    add_laws,
    add_material_name,
    add_numbers,
    onset_key_without_mass,
)
from .kinds import KeyTable, Name, Number, Section, Use, Word
from .library_names import BEARING, UNCHECKED

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
_SIZES = (
    Field(
        "clearance",
        "m",
        "radial internal clearance as catalogues give it: how far the rings can move from one extreme to the other; "
        "negative: a preload; or a group of ISO 5753-1 as {group: C3}, mounted as {group: C3, fit: k5/H7, "
        "inner_warmer: 5 K}",
        -math.inf,
        fit="group",
    ),
    Field("element_diameter", "m", "diameter of an element"),
    Field("pitch_diameter", "m", "diameter of the circle on which the centres of the elements lie"),
    Field(
        "bore",
        "m",
        "diameter of the hole of the inner ring; the friction of the bearing acts at half of it",
        optional=True,
    ),
    Field(
        "outside_diameter",
        "m",
        "outside diameter of the outer ring, on which the clearance of a mounted bearing depends",
        optional=True,
    ),
)
_ELEMENTS = Field("elements", "1", "number of elements", 3, 60, low_open=False, high_open=False, integer=True)
_GROOVES = tuple(
    Field(str(k), "1", f"radius of the groove of the {ring} ring over the diameter of a ball", 0.5, 1.0)
    for k, ring in enumerate(("inner", "outer"))
)
_LENGTH = Field("length", "m", "effective length of a roller along its axis")
_PHASE = Field("phase", "rad", "angle of the first element in the fixed frame at the start", -math.inf, default=0.0)
_MATERIAL = (
    Field("young", "Pa", "Young's modulus of balls and rings", default=210e9),
    Field("poisson", "1", "Poisson's ratio of balls and rings", -1.0, 0.5, high_open=False, default=0.3),
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
    keys[f"{path}.{BEARING}"] = Name(bearing_names(), text)
    keys[f"{path}.{UNCHECKED}"] = UNCHECKED_KEY
    for name, text in MOUNTING_KEYS.items():
        keys[f"{path}.{name}"] = Name((), f"{text}; for every group of the clearance")
    keys[kind] = Word(KINDS, "kind of the elements; needle: long rollers", noun="kind")
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
    keys[f"{contact}.law"] = Word(names, "law of the normal force", sweep=True, noun="law", role=MODEL, refused=refused)
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
