"""The laws a user can name: one block each, with all there is to say of it and what makes its compiled form.

To add a law of the form F = F_elastic (1 + chi u) is to add one block with its chi in `normal`; any other law also
needs a type and a body in its family beside them.
"""

import math

from ....catalogue import Catalogue
from ..elastic import Linear, elastic_force
from ..friction import Frictionless
from ..normal import Lossless
from ..wear import NoWear
from . import elastic, friction, mechanism, normal, wear  # noqa: F401 - each enters its laws
from .describe import text
from .material import material_stiffness
from .recipe import RECIPES, Recipe

__all__ = [
    "RECIPES",
    "Recipe",
    "catalogue",
    "contact_terms",
    "derived",
    "elastic_choices",
    "elastic_forces",
    "friction_term",
    "material_stiffness",
    "penetration_limit",
    "restitution",
    "text",
    "wear_term",
]


def catalogue() -> Catalogue:
    """Return all laws a grid can name."""
    return Catalogue(tuple(recipe.law for recipe in RECIPES.values()))


def _elastic(joint: dict) -> Recipe | None:
    """Return the elastic law of a joint section of a case, None where the contact law brings its own spring."""
    contact = joint["contact"]
    uses_elastic = RECIPES["law", contact["law"]].law.uses_elastic
    return RECIPES["elastic", contact["elastic"]] if uses_elastic else None


def contact_terms(joint: dict) -> tuple:
    """Return the compiled form of (law, elastic) of a joint section of a case."""
    law, elastic_law = RECIPES["law", joint["contact"]["law"]], _elastic(joint)
    return law.make(joint), elastic_law.make(joint) if elastic_law else Linear(joint["contact"]["stiffness"])


def penetration_limit(joint: dict) -> float:
    """Return the largest penetration (m) that the elastic law of a joint section of a case holds for, inf if any."""
    elastic_law = _elastic(joint)
    return elastic_law.limit(joint) if elastic_law else math.inf


def elastic_forces(joint: dict, depths) -> list[float]:
    """Return the elastic force (N) in a joint section of a case at each of some penetrations (m)."""
    term = contact_terms(joint)[1]
    return [float(elastic_force(term, depth)) for depth in depths]


def elastic_choices(joint: dict) -> dict[str, dict]:
    """Return, by name, a joint section of a case with each elastic law that its radii, length and material allow."""
    contact, found = joint["contact"], {}
    if _elastic(joint) is None or "material" not in contact:
        return found
    for law in catalogue().of("elastic"):
        defaults = {field.name: field.default for field in law.fields if field.default is not None}
        section = joint | {"contact": defaults | contact | {"elastic": law.name}}
        follows = {*section["contact"], "stiffness"}  # from the material
        known = {field.name for field in law.fields} <= follows and set(law.needs) <= {*joint, *contact}
        values = {**joint, **{f"contact.material.{key}": value for key, value in contact["material"].items()}}
        if known and all(limit.low <= values[limit.path] <= limit.high for limit in law.ranges):
            found[law.name] = section
    return found


def restitution(joint: dict) -> float | None:
    """Return what a free impact in a joint section of a case gives back, None where mass and speed decide that."""
    contact, returned = joint["contact"], RECIPES["law", joint["contact"]["law"]].returned
    if returned:
        return float(returned(contact["restitution"]))
    return 1.0 if isinstance(contact_terms(joint)[0], Lossless) else None


def derived(joint: dict) -> dict[str, tuple[float, str]]:
    """Return what the contact of a joint section of a case derives: path within the joint -> (value, unit)."""
    elastic_law = _elastic(joint)
    return elastic_law.derived(joint) if elastic_law else {}


def friction_term(joint: dict):
    """Return the compiled form of the friction of a joint section of a case."""
    friction_law = joint.get("friction")
    return RECIPES["friction", friction_law["law"]].make(joint) if friction_law else Frictionless()


def wear_term(joint: dict):
    """Return the compiled form of the wear of a joint section of a case."""
    wear_law = joint.get("wear")
    return RECIPES["wear", wear_law["law"]].make(joint) if wear_law else NoWear()
