"""Registered laws: description, compiled types and constructor of each."""

import math
from collections.abc import Callable
from typing import NamedTuple

from ...contracts.case import Joint
from ...contracts.catalogue import Law
from ..laws.elastic import contract as elastic
from ..laws.film import contract as film
from ..laws.friction import contract as friction
from ..laws.loss import contract as loss
from ..wear import contract as wear
from .contract import describe_missing_members

#: Family of laws -> the compiled families of which each type must be a member.
REQUIRED_FAMILIES = {
    "law": loss.FAMILIES,
    "elastic": elastic.FAMILIES,
    "roughness": (),  # tables are computed before compiling
    "friction": friction.FAMILIES,
    "wear": wear.WEAR_FAMILIES,
    "pressure": wear.PRESSURE_FAMILIES,
    "film": film.FAMILIES,
    "film-friction": film.SHEAR_FAMILIES,
    "transition": film.TRANSITION_FAMILIES,
}


def no_limit(joint: Joint) -> float:
    """Return the default for the largest valid penetration (m): infinity."""
    return math.inf


def no_derived_values(joint: Joint) -> dict:
    """Return the default for derived values: none."""
    return {}


class Recipe(NamedTuple):
    """A law as described to users, and the constructor of its compiled form."""

    law: Law
    types: tuple[type, ...]  # the types that `make` may return
    make: Callable  # joint -> compiled form
    free_restitution: Callable | None = None  # requested restitution -> restitution of a free impact, in closed form
    limit: Callable = no_limit  # joint -> largest valid penetration, m
    derived: Callable = no_derived_values  # joint -> derived values: path within the joint -> (value, unit)


RECIPES: dict[tuple[str, str], Recipe] = {}


def register(law: Law, types: tuple[type, ...], make: Callable, **options) -> None:
    """Register a law; `options` goes to its Recipe.  Raises TypeError if a member is missing.

    A `source` that begins with 'after' names the paper whose formula was taken from later work that quotes it.
    """
    for problem in _describe_faults(law, types, options.get("free_restitution")):
        raise TypeError(f"{law.family} '{law.name}': {problem}")
    RECIPES[law.family, law.name] = Recipe(law, types, make, **options)


def _describe_faults(law: Law, types: tuple[type, ...], free_restitution: Callable | None):
    """Yield descriptions of the missing declarations of a law."""
    if law.family not in REQUIRED_FAMILIES:
        yield f"unknown family (known: {', '.join(REQUIRED_FAMILIES)})"
        return
    if (law.family, law.name) in RECIPES:
        yield "is entered already; give it another name"
    for law_type in types:
        missing = [family.__name__ for family in REQUIRED_FAMILIES[law.family] if law_type not in family.members]
        if missing:
            yield f"{law_type.__name__} declares no {', '.join(missing)}"
        yield from (f"{law_type.__name__} {problem}" for problem in describe_missing_members(law_type))
    names = {field.name for field in law.fields}
    if "restitution" in names and free_restitution is None:
        yield "takes a restitution, but declares none that a free impact returns"
    if not law.uses_elastic and "stiffness" not in names:
        yield "uses no elastic law, but takes no stiffness for a spring of its own"


def compile_law(family: str, name: str, joint: Joint):
    """Return the compiled form of the law called `name` for a joint."""
    recipe = RECIPES[family, name]
    compiled = recipe.make(joint)
    if type(compiled) not in recipe.types:
        types = ", ".join(law_type.__name__ for law_type in recipe.types)
        raise TypeError(f"{family} '{name}': makes a {type(compiled).__name__}, entered with {types}")
    return compiled
