"""What a law is made of, and where all laws are entered."""

import math
from collections.abc import Callable
from typing import NamedTuple

from ...contracts.case import Joint
from ...contracts.catalogue import Law
from .contract import undeclared
from .elastic import contract as elastic
from .film import contract as film
from .friction import contract as friction
from .loss import contract as loss
from .wear import contract as wear

#: What the compiled types of a law declare: each is a member of every one of these.
DECLARED = {
    "law": loss.FAMILIES,
    "elastic": elastic.FAMILIES,
    "roughness": (),  # tabulated before anything is compiled
    "friction": friction.FAMILIES,
    "wear": wear.WEAR_FAMILIES,
    "pressure": wear.PRESSURE_FAMILIES,
    "film": film.FAMILIES,
    "film-friction": film.SHEAR_FAMILIES,
    "transition": film.TRANSITION_FAMILIES,
}


def unlimited(joint: Joint) -> float:
    """Return the largest penetration (m) that a law is valid for where it has none."""
    return math.inf


def nothing(joint: Joint) -> dict:
    """Return what follows from other values of a joint for a law that derives nothing."""
    return {}


class Recipe(NamedTuple):
    """A law as the user sees it, and what turns his numbers into its compiled form."""

    law: Law
    types: tuple[type, ...]  # the types that `make` may return
    make: Callable  # joint -> compiled form
    returned: Callable | None = None  # restitution asked for -> restitution of a free impact, in closed form
    limit: Callable = unlimited  # joint -> largest penetration that the law is valid for, m
    derived: Callable = nothing  # joint -> path within the joint -> (value, unit), what follows from other values


RECIPES: dict[tuple[str, str], Recipe] = {}


def register(law: Law, types: tuple[type, ...], make: Callable, **rest) -> None:
    """Enter a law; `rest` goes to its Recipe.  Raises TypeError where something is not declared.

    A `source` that begins with 'after' names the paper whose formula was taken from later work that quotes it.
    """
    for problem in _undeclared(law, types, rest.get("returned")):
        raise TypeError(f"{law.family} '{law.name}': {problem}")
    RECIPES[law.family, law.name] = Recipe(law, types, make, **rest)


def _undeclared(law: Law, types: tuple[type, ...], returned: Callable | None):
    """Yield, in words, what a law that is to be entered leaves out."""
    if law.family not in DECLARED:
        yield f"unknown family (known: {', '.join(DECLARED)})"
        return
    if (law.family, law.name) in RECIPES:
        yield "is entered already; give it another name"
    for form in types:
        missing = [family.__name__ for family in DECLARED[law.family] if form not in family.members]
        if missing:
            yield f"{form.__name__} declares no {', '.join(missing)}"
        yield from (f"{form.__name__} {problem}" for problem in undeclared(form))
    names = {field.name for field in law.fields}
    if "restitution" in names and returned is None:
        yield "takes a restitution, but declares none that a free impact returns"
    if not law.uses_elastic and "stiffness" not in names:
        yield "uses no elastic law, but takes no stiffness for a spring of its own"


def compiled_term(family: str, name: str, joint: Joint):
    """Return the compiled form of the law called `name` for a joint."""
    recipe = RECIPES[family, name]
    term = recipe.make(joint)
    if type(term) not in recipe.types:
        types = ", ".join(form.__name__ for form in recipe.types)
        raise TypeError(f"{family} '{name}': makes a {type(term).__name__}, entered with {types}")
    return term
