"""Every key that any grid may contain, mechanism by mechanism: what lists of keys are made of."""

from collections.abc import Iterator
from typing import NamedTuple

from ..contracts.catalogue import Catalogue, Mechanism
from ..contracts.outline import EVERYTHING, IN_SPACE
from .key_table import shape
from .keys import Shape


def full_shape(mechanism: Mechanism, catalogue: Catalogue) -> Shape:
    """Return every dotted path that any grid of this mechanism may contain, NAME standing for what it names."""
    complete = mechanism.outlined(EVERYTHING)._replace(free=True) if mechanism.outlined else mechanism
    return shape(complete, catalogue)


class KeyTree(NamedTuple):
    """All that a grid of a mechanism may contain, in the plane or in space."""

    mechanism: str  # its name
    keys: Shape
    spatial: bool = False


def key_trees(catalogue: Catalogue) -> Iterator[KeyTree]:
    """Yield the forms of all mechanisms, NAME standing for what a grid names."""
    for mechanism in catalogue.mechanisms:
        yield KeyTree(mechanism.name, keys=full_shape(mechanism, catalogue))
        found = mechanism.outlined(IN_SPACE) if mechanism.outlined else mechanism
        if found.spatial:
            yield KeyTree(mechanism.name, keys=shape(found, catalogue), spatial=True)
