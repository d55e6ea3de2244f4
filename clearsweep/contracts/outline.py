"""What a grid names itself, and so decides which keys it has: the form of its drive, its loads, bodies and joints.

None of it is a number and none can be swept: all cases of a grid have one outline.
"""

from typing import NamedTuple

GROUND = "ground"
ANY = "NAME"  # represents a name that a user chooses, where keys are listed


class BodyOutline(NamedTuple):
    """A body of a `planar` mechanism."""

    name: str
    points: tuple[str, ...]


class JointOutline(NamedTuple):
    """A joint of a `planar` mechanism; its two points are 'body.point', '' where that could not be read."""

    name: str
    type: str  # 'revolute', 'prismatic' or 'slot'
    proximal: str
    distal: str
    journal: str = ""  # a body; '': the distal one

    @property
    def bodies(self) -> tuple[str, str]:
        """Return the proximal and the distal body."""
        return self.proximal.partition(".")[0], self.distal.partition(".")[0]


class LoadOutline(NamedTuple):
    """A load."""

    name: str
    form: str  # the name of a law of the family 'load'
    on: str = ""  # the body it acts on, or the joint
    given: str = ""  # of friction of a given size: 'torque' or 'force'


class Outline(NamedTuple):
    """What a grid names itself."""

    type: str = ""  # mechanism.type
    drive: str = "speed"  # the name of a law of the family 'drive'
    loads: tuple[LoadOutline, ...] = ()
    bodies: tuple[BodyOutline, ...] = ()  # of a `planar` mechanism, the ground among them
    joints: tuple[JointOutline, ...] = ()  # of a `planar` mechanism
    rotary: bool = False  # the output of a `planar` mechanism is an angle
    clearances: frozenset[str] = frozenset()  # joints with clearance
    spatial: bool = False  # its bodies move in space
    axial: frozenset[str] = frozenset()  # joints with clearance between flanges, of a mechanism in space
    elastic: frozenset[str] = frozenset()  # bodies that give along a line

    @property
    def free(self) -> bool:
        """Return whether the crank is free, its motion not prescribed."""
        return self.drive in ("torque", "motor")


#: Keys that give friction a size of its own: of a couple in a pin, of a force in a guide.
SIZES = ("torque", "force")

#: An outline of a mechanism in space, for lists of keys.
IN_SPACE = Outline(
    bodies=(BodyOutline(GROUND, (ANY,)), BodyOutline(ANY, (ANY,))),
    joints=(JointOutline(ANY, ANY, "", ""),),
    spatial=True,
    axial=frozenset((ANY,)),
)

#: An outline with everything that a grid may name, for lists of keys.
EVERYTHING = Outline(
    drive=ANY,
    loads=(LoadOutline(ANY, ANY, ANY),),
    bodies=(BodyOutline(GROUND, (ANY,)), BodyOutline(ANY, (ANY,))),
    joints=(JointOutline(ANY, ANY, "", ""),),
)
