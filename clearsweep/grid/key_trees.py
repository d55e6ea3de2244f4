"""Every key that any grid may contain, by mechanism: the source of all lists of keys."""

from collections.abc import Iterator, Mapping
from typing import NamedTuple

from ..contracts.catalogue import Catalogue, Mechanism
from ..contracts.outline import ANY, EVERYTHING, IN_SPACE, JointOutline
from .key_table import shape
from .keys import Shape


def full_shape(mechanism: Mechanism, catalogue: Catalogue) -> Shape:
    """Return every dotted path that a grid of this mechanism may contain, with NAME for user-defined names."""
    if not mechanism.outlined:
        return shape(mechanism, catalogue)
    complete = mechanism.outlined(EVERYTHING)
    return shape(complete, catalogue) | shape(complete._replace(free=True), catalogue)  # `horizon` and `time_limit`


class KeyTree(NamedTuple):
    """The keys of a mechanism, in the plane or in space."""

    mechanism: str  # its name
    keys: Shape
    joints: Mapping[str, str]  # joints that may have clearance -> kind, as in `JointSite`
    spatial: bool = False


def key_trees(catalogue: Catalogue, *, slots: bool = False) -> Iterator[KeyTree]:
    """Yield the keys of all mechanisms, with NAME in place of user-defined names; with `slots` also those of a slot."""
    for mechanism in catalogue.mechanisms:
        complete = mechanism.outlined(EVERYTHING) if mechanism.outlined else mechanism
        kinds = {site.name: site.kind for site in complete.joints}
        yield KeyTree(mechanism.name, full_shape(mechanism, catalogue), kinds)
        if slots and ANY in kinds and mechanism.outlined:
            slot = mechanism.outlined(EVERYTHING._replace(joints=(JointOutline(ANY, "slot", "", ""),)))
            yield KeyTree(mechanism.name, shape(slot, catalogue), {ANY: "slot"})
        in_space = mechanism.outlined(IN_SPACE) if mechanism.outlined else mechanism
        if in_space.spatial:
            kinds = {site.name: site.kind for site in in_space.joints}
            yield KeyTree(mechanism.name, shape(in_space, catalogue), kinds, spatial=True)
