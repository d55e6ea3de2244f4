"""Largest eccentricity of the journal in a worn joint before its surfaces touch, over all directions."""

from typing import NamedTuple

import numpy as np


class Touch(NamedTuple):
    """The largest eccentricity of a journal before its surfaces touch."""

    growth: float  # m, eccentricity minus the clearance of the unworn joint
    bearing_bin: int  # bins in contact there
    journal_bin: int
    growth_per_depth: (
        float  # growth of the eccentricity per depth worn there: 1 / cos of the angle between both directions
    )


def first_touch(clearance: float, bearing: np.ndarray, journal: np.ndarray, relative_angles: np.ndarray) -> Touch:
    """Return the largest eccentricity of a journal before its surfaces touch.

    With the gap clearance + h_bearing + h_journal - e cos(phi - gamma), a journal that moves in the direction gamma
    touches at e = min over phi of (clearance + h_bearing + h_journal) / cos(phi - gamma), to first order in depths
    over the radius.  The result is the largest e over all gamma and relative angles of the bodies.

    bearing, journal : (bins,) m, depth of each bin in the frame of its body; relative_angles : (n,) rad, the angles
    of the body of the journal minus those of the body of the bearing.
    """
    bins = len(bearing)
    bin_shifts = np.unique(np.round(np.asarray(relative_angles) * bins / (2.0 * np.pi)).astype(int) % bins)
    bin_numbers = np.arange(bins)
    facing_bin = (
        bin_numbers - bin_shifts[:, None]
    ) % bins  # (rotations, bins) bin of the journal that faces each bin of the bearing
    gap = clearance + bearing + journal[facing_bin]
    bins_in_reach = int(np.arccos(clearance / gap.max()) * bins / (2.0 * np.pi)) + 1  # no first touch beyond this angle
    offsets = [bin_offset for bin_offset in range(-bins_in_reach, bins_in_reach + 1) if 4 * abs(bin_offset) < bins]
    smallest, offset_of_smallest = gap.copy(), np.zeros(gap.shape, int)
    for bin_offset in offsets:
        eccentricity = np.roll(gap, -bin_offset, axis=1) / np.cos(2.0 * np.pi * bin_offset / bins)
        is_smaller = eccentricity < smallest
        smallest[is_smaller], offset_of_smallest[is_smaller] = eccentricity[is_smaller], bin_offset
    rotation, direction = np.unravel_index(int(np.argmax(smallest)), smallest.shape)
    offset = int(offset_of_smallest[rotation, direction])
    bearing_bin = int((direction + offset) % bins)
    growth_per_depth = float(1.0 / np.cos(2.0 * np.pi * offset / bins))
    return Touch(
        float(smallest[rotation, direction]) - clearance,
        bearing_bin,
        int(facing_bin[rotation, bearing_bin]),
        growth_per_depth,
    )


def first_touch_in_slot(bearing: np.ndarray, journal: np.ndarray) -> Touch:
    """Return an upper bound for a pin in a slot: the deepest bins of wall and pin face each other.

    bearing, journal : (bins,) m, depth of each bin; the bins of the wall follow its arc length
    """
    bearing_bin, journal_bin = int(np.argmax(bearing)), int(np.argmax(journal))
    return Touch(float(bearing[bearing_bin] + journal[journal_bin]), bearing_bin, journal_bin, 1.0)
