"""A revolute joint in space: a journal with radial and axial clearance in its bearing, in which it may tilt.

Both are cylinders (geometry after Marques, Isaac, Dourado & Flores 2017, Mechanism and Machine Theory 116).  All is
in the frame of the journal, whose axis is its z, from the middle of the bearing.  The places where the surfaces
can touch are contacts of their own:

    1, 2    an end circle of the journal, at the end of +z and of -z, on the wall of the bore; or, where that is beyond
            the bore and there are no flanges, the edge of the bore at this end on the journal
    3, 4    the rims of the same ends on the flanges, which the bore goes on to

Each is one point, where the surfaces come deepest: on a circle its exact maximiser, as else work is lost.  Force and
moment act on each body at its own surface point; these lie the penetration apart along the normal, and all powers add
up to normal force times rate of penetration and friction times sliding speed.  The walls share what the joint bears in
parallel: each has half of the stiffness at its point (`EndContacts`), or all is spread over the length (`Spread`).

Behind these contacts are two that only report: the sum of the walls' normal forces as vectors, and their difference in
size, with the sine of the tilt as its depth.
"""

from .forces import CHANNELS, POINT_CHANNELS
from .form import AtEdges, EndContacts, Flanged, InBore, Overlapping, SpatialGap, SpatialLoad, Spread, Through
from .points import ENDS, deepest_of, flange_point, jam_angle, overlap_of, tilt_of, wall_point
from .spread import bearing_length
from .strips import spread_over

__all__ = [
    "CHANNELS",
    "ENDS",
    "POINT_CHANNELS",
    "AtEdges",
    "EndContacts",
    "Flanged",
    "InBore",
    "Overlapping",
    "SpatialGap",
    "SpatialLoad",
    "Spread",
    "Through",
    "bearing_length",
    "deepest_of",
    "flange_point",
    "jam_angle",
    "overlap_of",
    "spread_over",
    "tilt_of",
    "wall_point",
]
