"""Keys of a spatial revolute joint."""

import math

from ..contracts.catalogue import Catalogue, Field, JointSite
from .joint_keys import add_contact, add_friction, add_numbers, first_onset, point_laws
from .keys import Flag, Section, Shape, Word

_SLEEVE = (
    Field("clearance", "m", "radial clearance"),
    Field("bearing_radius", "m", "radius of the bearing; the journal's is smaller by the clearance"),
    Field("length", "m", "length of the bearing along its axis"),
    Field("journal_length", "m", "length of the journal; default: that of the bearing", optional=True),
)
_AXIAL = Field(
    "axial_clearance", "m", "between the ends of bearing and journal on each side, with the journal in the middle"
)
_MISALIGNED = (
    ("tilt", "rotation vector of the bearing about x and y of its body", "rad", 2),
    ("offset", "offset of the bearing's middle along the axes of its body", "m", 3),
)


def flanged(tree: Shape, path: str, catalogue: Catalogue) -> None:
    """Add the further keys of a spatial revolute joint with flanges."""
    add_numbers(tree, path, (_AXIAL,))
    axial = f"{path}.axial"
    _pointed_contact(tree, axial, catalogue._replace(laws=point_laws(catalogue)))
    for nested in [nested for nested in tree if nested.startswith(f"{axial}.material")]:
        del tree[nested]
    tree[axial] = Section("the normal force at a flange; left out: as `contact`", "optional")


def through(tree: Shape, path: str, site: JointSite, catalogue: Catalogue) -> None:
    """Add the keys of a spatial revolute joint without flanges."""
    tree[path] = Section("a revolute joint with radial and axial clearance, in which the journal may tilt", "optional")
    tree[f"{path}.type"] = Word(("spatial",), "the kind of the joint")
    add_numbers(tree, path, _SLEEVE)
    tree[f"{path}.flange"] = Flag(
        "the bearing has flanges, `axial_clearance` away from the journal on each side", default=True
    )
    elastic = frozenset(law.name for law in catalogue.of("law") if not law.yields)
    tree[f"{path}.walls"] = Word(
        ("spread", "ends"),
        "where the walls carry load; spread: evenly over the overlap of journal and bore; ends: at "
        "the two ends, half the stiffness each; laws with permanent indentation: at the ends",
        "spread",
        sweep=True,
        when=((f"{path}.contact.law", elastic),),
        idle=True,
    )
    for name, text, unit, count in _MISALIGNED:
        tree[f"{path}.{name}"] = Section(text, "implied", count)
        axes = (
            Field(str(k), unit, f"about {axis}" if unit == "rad" else f"along {axis}", -math.inf, default=0.0)
            for k, axis in enumerate("xyz"[:count])
        )
        add_numbers(tree, f"{path}.{name}", tuple(axes))
    _pointed_contact(tree, f"{path}.contact", catalogue)
    laws = tuple(law for law in catalogue.laws if not (law.remembers or law.sticks))
    add_friction(tree, path, catalogue._replace(laws=laws))


def _pointed_contact(tree: Shape, contact: str, catalogue: Catalogue) -> None:
    """Add the keys of the normal force at contact points, whose effective impact mass is unknown."""
    add_contact(tree, contact.rpartition(".")[0], catalogue, contact)
    tree[f"{contact}.onset"] = first_onset(tree, contact)
