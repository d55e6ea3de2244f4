"""The laws a user can name: one block each, with all there is to say of it and what makes its compiled form.

To add a law of the form F = F_elastic (1 + chi u) is to add one block with its chi in `normal`; any other law also
needs a type and a body in its family under `kernels`.
"""

import math

from ..catalogue import Catalogue
from ..kernels.elastic import Linear
from ..kernels.friction import Frictionless
from ..kernels.wear import NoWear
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
    "friction_term",
    "material_stiffness",
    "penetration_limit",
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
