"""User-defined names of a grid, which determine its keys: form of the drive, loads, bodies and joints.

It contains no numbers and nothing that can be swept: all cases of a grid have the same outline.
"""

from typing import NamedTuple

GROUND = "ground"
ANY = "NAME"  # placeholder for user-defined names in lists of keys


class BodyOutline(NamedTuple):
    """A body of a `planar` mechanism."""

    name: str
    points: tuple[str, ...]


class JointOutline(NamedTuple):
    """A joint of a `planar` mechanism; its two points are 'body.point', or '' if that could not be read."""

    name: str
    type: str  # 'revolute', 'prismatic' or 'slot'
    proximal: str
    distal: str
    journal: str = ""  # the body that carries the journal; '': the distal one

    @property
    def bodies(self) -> tuple[str, str]:
        """Return the proximal and the distal body."""
        return self.proximal.partition(".")[0], self.distal.partition(".")[0]


class LoadOutline(NamedTuple):
    """A load."""

    name: str
    form: str  # the name of a law of the family 'load'
    on: str = ""  # the body or joint that it acts on
    given: str = ""  # for friction of a given size: 'torque' or 'force'


class Outline(NamedTuple):
    """The user-defined names of a grid."""

    type: str = ""  # mechanism.type
    drive: str = "speed"  # the name of a law of the family 'drive'
    loads: tuple[LoadOutline, ...] = ()
    bodies: tuple[BodyOutline, ...] = ()  # of a `planar` mechanism, including the ground
    joints: tuple[JointOutline, ...] = ()  # of a `planar` mechanism
    rotary: bool = False  # whether the output of a `planar` mechanism is an angle
    clearances: frozenset[str] = frozenset()  # joints with clearance
    spatial: bool = False  # its bodies move in space
    axial: frozenset[str] = frozenset()  # joints with clearance between flanges, of a mechanism in space
    elastic: frozenset[str] = frozenset()  # bodies with elastic links

    @property
    def free(self) -> bool:
        """Return whether the crank is free, its motion not prescribed."""
        return self.drive in ("torque", "motor")


#: Keys that set the size of friction directly: a couple in a pin, a force in a guide.
SIZES = ("torque", "force")

#: An outline of a mechanism in space, for lists of keys.
IN_SPACE = Outline(
    bodies=(BodyOutline(GROUND, (ANY,)), BodyOutline(ANY, (ANY,))),
    joints=(JointOutline(ANY, ANY, "", ""),),
    spatial=True,
    axial=frozenset((ANY,)),
)

#: An outline with everything that a grid may define, for lists of keys.
FULL_OUTLINE = Outline(
    drive=ANY,
    loads=(LoadOutline(ANY, ANY, ANY),),
    bodies=(BodyOutline(GROUND, (ANY,)), BodyOutline(ANY, (ANY,))),
    joints=(JointOutline(ANY, ANY, "", ""),),
)
