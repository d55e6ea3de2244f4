"""What a wear law and the pressure it acts on declare."""

from typing import NamedTuple

import numpy as np

from ...compiled.family import family

# Columns of the account of a joint's wear
ARCS, NARROW, ACCOUNT = range(3)


class Rubbing(NamedTuple):
    """A share of a step: what presses where while it slides."""

    force: float  # N
    depth: float  # m, penetration
    distance: float  # m, of sliding
    on_bearing: float  # rad, where the contact is on the bearing
    on_journal: float  # rad


class Bins(NamedTuple):
    """Where the wear of a joint is entered."""

    depths: np.ndarray  # (2 joints stride,) m, mean depth of each bin
    first: int  # of the bearing's bins
    stride: int  # from there to the first of the journal's
    account: np.ndarray  # (ACCOUNT,) contact arcs worn, and how many of them were narrow


@family
def wear_rate(law, joint, rubbing, bins):
    """Enter the wear of a Rubbing into the Bins of a joint."""


@family
def half_arc(pressure, joint, line_load, depth):
    """Return half the width (rad) of the contact arc under `line_load` (N/m) at penetration `depth` (m)."""


@family
def share_before(pressure, x):
    """Return the share of the load that lies before `x` of the arc, whose ends are -1 and 1."""


PRESSURE_FAMILIES = (half_arc, share_before)  # a type of pressure is a member of each
WEAR_FAMILIES = (wear_rate,)


class NoWear(NamedTuple):
    """Nothing is worn and nothing computed."""


@wear_rate.member(NoWear)
def _no_wear(law, joint, rubbing, bins):
    pass
