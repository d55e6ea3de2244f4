"""No roughness, for grids that sweep rough and smooth surfaces."""

from typing import NamedTuple

from ....contracts.catalogue import Law
from ...joints.recipe import register


class Smooth(NamedTuple):
    """Rigid smooth surfaces."""


register(
    Law(
        "roughness",
        "smooth",
        "no roughness: the elastic law alone",
        "pen = bulk(F)",
        "the limit of surfaces whose scale goes to zero",
        notes="The same as a joint without the section, except for the identity of the case.  For sweeps over rough "
        "surfaces.",
    ),
    (Smooth,),
    lambda joint: Smooth(),
)
