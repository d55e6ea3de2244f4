"""Wear that grows with pressure and sliding."""

import math
from typing import NamedTuple

from ....case import Joint
from ....catalogue import Law
from ...compiled.family import kernel
from ..recipe import compiled_term, enter
from .contract import ARCS, NARROW, half_arc, share_before, wear_rate

WIDE = 5.0  # bins: an arc narrower than this is not resolved, and counted


class Archard(NamedTuple):
    """dh = k p |v| dt."""

    bearing_coefficient: float  # m^2/N
    journal_coefficient: float  # m^2/N
    bins: float  # of each body
    length: float  # m, of the joint along its pin
    pressure: tuple  # half_arc, share_before


class Arc(NamedTuple):
    """An arc of one body that is worn."""

    middle: float  # rad
    half: float  # rad, half its width
    amount: float  # m rad, depth times angle


@wear_rate.member(Archard)
def _archard(law, joint, rubbing, bins):
    line_load = rubbing.force / law.length
    half = half_arc(law.pressure, joint, line_load, rubbing.depth)
    bins.account[ARCS] += 1.0
    if 2.0 * half < WIDE * 2.0 * math.pi / law.bins:
        bins.account[NARROW] += 1.0
    sliding, count = line_load * rubbing.distance, int(law.bins)
    on_bearing = Arc(rubbing.on_bearing, half, law.bearing_coefficient * sliding / joint.bearing_radius)
    spread(law.pressure, on_bearing, bins.depths, bins.first, count)
    on_journal = Arc(rubbing.on_journal, half, law.journal_coefficient * sliding / joint.journal_radius)
    spread(law.pressure, on_journal, bins.depths, bins.first + bins.stride, count)


@kernel
def spread(pressure, arc, depths, first, count):
    """Add what an Arc is worn by, spread like the pressure, to the means of `count` bins from `depths[first]` on."""
    if arc.amount == 0.0:
        return
    width = 2.0 * math.pi / count
    begin = math.floor((arc.middle - arc.half) / width)
    last = math.floor((arc.middle + arc.half) / width)
    before = 0.0
    for place in range(int(begin), int(last) + 1):
        up_to = 1.0
        if place < last:
            up_to = share_before(pressure, ((place + 1) * width - arc.middle) / arc.half)
        depths[first + place % count] += arc.amount * (up_to - before) / width
        before = up_to


def _make_archard(joint: Joint) -> Archard:
    wear = joint.wear
    return Archard(
        wear.values["bearing_coefficient"],
        wear.values["journal_coefficient"],
        float(wear.bins),
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
