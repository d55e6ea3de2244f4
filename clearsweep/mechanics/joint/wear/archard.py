"""Wear that grows with pressure and sliding."""

from typing import NamedTuple

from ....case import Joint
from ....catalogue import Law
from ..recipe import compiled_term, enter
from .contract import FINEST, wear_rate


class Archard(NamedTuple):
    """dh = k p |v| dt."""

    bearing_coefficient: float  # m^2/N
    journal_coefficient: float  # m^2/N
    bins: float  # of each body
    length: float  # m, of the joint along its pin
    pressure: tuple  # half_arc, share_before


@wear_rate.member(Archard)
def _archard(law, rubbing):
    sliding = rubbing.line_load * rubbing.slip
    return law.bearing_coefficient * sliding, law.journal_coefficient * sliding


def _make_archard(joint: Joint) -> Archard:
    wear = joint.wear
    return Archard(
        wear.values["bearing_coefficient"],
        wear.values["journal_coefficient"],
        float(min(wear.bins, FINEST)),
        joint.length,
        compiled_term("pressure", wear.pressure, joint),
    )


enter(
    Law(
        "wear",
        "archard",
        "depth grows with pressure and sliding",
        "dh = k p |slip| dt",
        "Archard 1953, J. Appl. Phys. 24:981",
        notes="k in m^2/N; 1 mm^3/(N m) = 1e-9 m^2/N.  k times the hardness must be far below 1.",
    ),
    (Archard,),
    _make_archard,
)
