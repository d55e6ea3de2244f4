"""Largest eccentricity of the journal in a worn joint: where its surfaces touch first, in any direction."""

from typing import NamedTuple

import numpy as np


class Touch(NamedTuple):
    """The largest eccentricity of a journal before its surfaces touch."""

    growth: float  # m, of the eccentricity over the clearance of the unworn joint
    bearing: int  # bins that touch there
    journal: int
    slant: float  # eccentricity that a depth worn off them is worth: 1 / cos of the angle between both directions


def first_touch(clearance: float, bearing: np.ndarray, journal: np.ndarray, turned: np.ndarray) -> Touch:
    """Return the largest eccentricity of a journal before its surfaces touch.

    With the gap clearance + h_bearing + h_journal - e cos(phi - gamma), a journal that goes in the direction gamma
    touches at e = min over phi of (clearance + h_bearing + h_journal) / cos(phi - gamma), to first order in what is
    small against the radius; the largest e over all gamma and over how the bodies are placed to each other counts.

    bearing, journal : (bins,) m, depth of each bin in the frame of its body; turned : (n,) rad, the angles of the
    journal's body less those of the bearing's.
    """
    bins = len(bearing)
    steps = np.unique(np.round(np.asarray(turned) * bins / (2.0 * np.pi)).astype(int) % bins)
    places = np.arange(bins)
    on_journal = (places - steps[:, None]) % bins  # (turns, bins) the bin of the journal that faces each of the bearing
    gap = clearance + bearing + journal[on_journal]
    reach = int(np.arccos(clearance / gap.max()) * bins / (2.0 * np.pi)) + 1  # beyond, nothing can touch first
    offsets = [k for k in range(-reach, reach + 1) if 4 * abs(k) < bins]
    nearest, at_step = gap.copy(), np.zeros(gap.shape, int)
    for k in offsets:
        there = np.roll(gap, -k, axis=1) / np.cos(2.0 * np.pi * k / bins)
        first = there < nearest
        nearest[first], at_step[first] = there[first], k
    turn, direction = np.unravel_index(int(np.argmax(nearest)), nearest.shape)
    offset = int(at_step[turn, direction])
    touched = int((direction + offset) % bins)
    slant = float(1.0 / np.cos(2.0 * np.pi * offset / bins))
    return Touch(float(nearest[turn, direction]) - clearance, touched, int(on_journal[turn, touched]), slant)
