"""A spatial revolute joint: a journal with radial and axial clearance, which may tilt in its bearing.

Both are cylinders (geometry after Marques, Isaac, Dourado & Flores 2017, Mechanism and Machine Theory 116).  Everything
is in the frame of the journal, whose axis is z, from the centre of the bearing.  The points where the surfaces can
touch are separate contacts:

    1, 2    an end circle of the journal, at the end of +z and of -z, on the wall of the bore; or, if that is beyond
            the bore and there are no flanges, the edge of the bore at this end on the journal
    3, 4    the rims of the same ends on the flanges, up to which the bore extends

Each is one point, the deepest point of the surfaces: on a circle its exact maximiser, otherwise energy would be lost.
Force and moment act on each body at its own surface point; their distance along the normal is the penetration, and all
powers add up to normal force times rate of penetration and friction times sliding speed.  The walls share the load in
parallel: each has half of the stiffness at its point (`EndContacts`), or all is spread over the length (`Spread`).

Two auxiliary contacts follow, which only report: the vector sum of the walls' normal forces, and the difference of
their magnitudes, with the sine of the tilt as its depth.
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
