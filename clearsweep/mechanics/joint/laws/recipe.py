"""What a law is made of, and where all laws are entered."""

import math
from collections.abc import Callable
from typing import NamedTuple

from ....case import Joint
from ....catalogue import Field, Law


def unlimited(joint: Joint) -> float:
    """Return the largest penetration (m) that a law holds for where it has none."""
    return math.inf


def nothing(joint: Joint) -> dict:
    """Return what follows from other values of a joint for a law that derives nothing."""
    return {}


class Recipe(NamedTuple):
    """A law as the user sees it, and what turns his numbers into its compiled form.

    All functions take a joint section of a resolved case, in SI.
    """

    law: Law
    make: Callable  # joint -> compiled form
    limit: Callable = unlimited  # joint -> largest penetration that the law holds for, m
    derived: Callable = nothing  # joint -> path within the joint -> (value, unit), what follows from other values
    returned: Callable | None = None  # restitution asked for -> restitution of a free impact, in closed form


RECIPES: dict[tuple[str, str], Recipe] = {}


def enter(
    family: str,
    name: str,
    summary: str,
    formula: str,
    source: str,
    make: Callable,
    *fields: Field,
    limit: Callable = unlimited,
    derived: Callable = nothing,
    returned: Callable | None = None,
    **rest,
) -> None:
    """Enter a law; `rest` goes to its catalogue.Law.

    A `source` that begins with 'after' names the paper whose formula was taken from later work that quotes it.
    """
    law = Law(family, name, summary, formula, source, fields, **rest)
    RECIPES[family, name] = Recipe(law, make, limit, derived, returned)
