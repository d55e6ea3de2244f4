"""The stretch of a run over which figures are taken: all that their formulas are functions of."""

from typing import NamedTuple

import numpy as np

from ..case import Case
from ..catalogue import Mechanism
from ..layout import Layout
from ..mechanics.joint import dry
from ..mechanics.observe.tally import Tally


class Window(NamedTuple):
    """What a run came to after `discard`: what formulas of figures are functions of, with a joint's place."""

    case: Case
    mechanism: Mechanism
    layout: Layout
    joints: tuple[dry.Joint, ...]
    tally: Tally
    counts: np.ndarray  # see solver.event, of all that was integrated
    seconds: float  # s, that integrating took
    duration: float  # s
    turns: float  # revolutions; 1 where nothing turns
    onset: np.ndarray  # (joints,) m/s, onset rate that its law goes by at the end; nan: none


def wear_depths(layout: Layout, tally: Tally, place: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the wear depths (m) of the bearing and the journal of a joint, by bin."""
    bearing, journal = tally.wear.reshape(len(layout.joints), 2, -1)[place, :, : layout.joints[place].wear_bins]
    return bearing, journal


def wear_of(layout: Layout, tally: Tally) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Return the wear depths (m) of bearing and journal by joint, where there is wear."""
    return {
        joint.name: (bearing.copy(), journal.copy())
        for place, joint in enumerate(layout.joints)
        if joint.wear_bins
        for bearing, journal in (wear_depths(layout, tally, place),)
    }
