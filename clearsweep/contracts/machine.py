"""Description of a planar machine: rigid bodies, joints, drive and loads, in SI.

Every planar mechanism of a grid is translated into these records; `mechanics.machines.planar` derives
its equations of motion from them.
"""

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

GROUND = "ground"  # the fixed body
STARTED_FRACTION = 0.95  # of the no-load speed, at which a motor counts as started


class Bending(NamedTuple):
    """Bending of a link across the line between two of its points, in modes of a bar with pinned ends."""

    modes: int
    rigidity: float  # N m^2, E I
    young: float  # Pa
    edge: float  # m, of the section from its centre, across the line in the plane
    area: float  # m^2; nan: unknown


class Elastic(NamedTuple):
    """Compliance of a link between two of its points: a uniform bar of the link's mass, in segments along its line."""

    near: str  # name of the point nearer the drive
    far: str
    stiffness: float  # N/m, E A / l of the whole link
    segments: int  # 0: the link keeps its length, except for the shortening by its bending
    damping: float = 0.0  # 1, ratio of the first axial mode with free ends, and of the first bending mode with pinned
    bending: Bending | None = None


class Initial(NamedTuple):
    """Initial position and velocity of the centre of mass of a free body, in the fixed frame."""

    x: float  # m
    y: float
    angle: float  # rad, of its frame
    vx: float  # m/s
    vy: float
    rate: float  # rad/s


class Body(NamedTuple):
    """A body, rigid except for the compliance in `elastic`; its frame turns with it."""

    mass: float  # kg; 0 for the ground
    inertia: float  # kg m^2, about the centre of mass
    center: tuple[float, float]  # m, centre of mass in its own frame
    points: Mapping[str, tuple[float, float]]  # m, by name, in its own frame
    elastic: Elastic | None = None
    initial: Initial | None = None  # of a body that no ideal joint determines; None: starts as in the ideal machine
    mounted: bool = False  # a housing on springs, or what lies between its springs


class BodyPoint(NamedTuple):
    """A point of a body, by name."""

    body: str
    point: str


def ends_of(record: Any) -> dict[str, BodyPoint]:
    """Return the points of bodies that a joint or a load connects or acts on, by field."""
    return {field: part for field, part in record._asdict().items() if isinstance(part, BodyPoint)}


class Pin(NamedTuple):
    """A revolute joint: two points coincide, except for clearance."""

    name: str
    proximal: BodyPoint
    distal: BodyPoint


class Guide(NamedTuple):
    """A prismatic joint: the distal point stays on a line through the proximal one, and the frames stay parallel."""

    name: str
    proximal: BodyPoint
    distal: BodyPoint
    axis: float  # rad, of the line in the frame of the proximal body


class Slot(NamedTuple):
    """A pin in a straight slot: the distal point stays on a line through the proximal one, and may turn."""

    name: str
    proximal: BodyPoint
    distal: BodyPoint
    axis: float  # rad, of the line in the frame of the proximal body


class Mesh(NamedTuple):
    """Two bodies whose angles keep a ratio, except for play: two wheels in mesh, or the halves of a coupling.

    Without play, first angle + `ratio` x second angle = `rest`, both measured from the carrier.
    """

    name: str
    proximal: BodyPoint  # the first body and its centre
    distal: BodyPoint
    carrier: str  # body on which both turn; of a coupling it has no effect
    ratio: float  # pitch radius of the second wheel over that of the first, below 0 in an internal gear; coupling: -1
    arm: float = 1.0  # m, base radius of the first wheel; of a coupling 1, so that a force is a torque
    centres: float = 0.0  # rad, direction from the first centre to the second in the frame of the carrier
    pins: tuple[str, ...] = ()  # names of the pins of the first and the second wheel; () of a coupling
    across: float = 0.0  # force on the second wheel across this direction for a unit of force on the drive flank
    apart: float = 0.0  # force along it for a unit of force on either flank
    rest: float = 0.0  # rad
    eccentricities: tuple = ()  # (x, y) m of the centre of each pitch circle from its pin, in the wheel's frame
    teeth: float = 0.0  # of the first wheel; 0: unknown
    approach: float = 0.5  # share of the base pitch before the pitch point in which a pair of teeth carries the force


class Stops(NamedTuple):
    """The two ends of the angle of a pin or the travel of a guide without clearance, which exert forces only there."""

    name: str
    proximal: BodyPoint
    distal: BodyPoint
    guide: str = ""  # name of the guide; '': of a pin


class Stretch(NamedTuple):
    """A spring and damper between two segments of an elastic link, or under a housing, which a guide keeps straight."""

    name: str
    proximal: BodyPoint
    distal: BodyPoint
    axis: float  # rad, of the line in the frame of the proximal body
    stiffness: float  # N/m
    damping: float  # N s/m


class Mount(NamedTuple):
    """A housing that carries the ground's side of a joint: it does not turn and has no weight."""

    joint: str
    mass: float  # kg
    stiffness: tuple[float, float]  # N/m, along x and y
    damping: tuple[float, float]  # N s/m


class Constant(NamedTuple):
    """A crank at constant speed."""

    speed: float  # rad/s
    start_angle: float = 0.0  # rad


class Schedule(NamedTuple):
    """A crank whose speed follows a table, linear between its rows and constant beyond them."""

    times: np.ndarray  # (rows,) s, increasing
    speeds: np.ndarray  # (rows,) rad/s
    start_angle: float = 0.0


class Path(NamedTuple):
    """A crank whose angle follows a table from time 0 on: a natural cubic spline, at constant speed behind it."""

    times: np.ndarray  # (rows,) s, increasing, the first 0
    angles: np.ndarray  # (rows,) rad
    start_angle: float = 0.0  # rad, the first angle


class Servo(NamedTuple):
    """A torque stiffness x (target - angle) + damping x (target rate - rate) + integral, at most a limit either way."""

    target: Path
    stiffness: float  # N m/rad
    damping: float  # N m s/rad
    torque_limit: float = math.inf  # N m
    integral: float | None = None  # N m/(rad s), torque per time and angle behind the target; None: no integral
    tracking_time: float = 1.0  # s, in which the integral gives way at the limit


class Motor(NamedTuple):
    """A free crank under a torque `stall_torque` (1 - speed / no_load_speed); a constant one if that is infinite."""

    stall_torque: float  # N m
    no_load_speed: float = math.inf  # rad/s
    initial_speed: float = 0.0  # rad/s
    inertia: float = 0.0  # kg m^2, of a flywheel, added to the crank's about its centre of mass
    start_angle: float = 0.0  # rad
    law: tuple | None = None  # compiled, of `torque_at`: a law of one's own; the numbers above are those of its start
    curve: tuple[np.ndarray, np.ndarray] | None = None  # (rows,) rad/s and N m: a table in place of the first numbers
    servo: Servo | None = None  # in place of the first numbers


class Push(NamedTuple):
    """A force of fixed direction at a point of a body, and a torque on it."""

    name: str
    at: BodyPoint
    fx: float  # N
    fy: float
    torque: float  # N m


class TabledPush(NamedTuple):
    """A Push that depends on the crank angle, repeating over the span of its table, or on time, constant beyond it."""

    name: str
    at: BodyPoint
    over: str  # 'angle' or 'time'
    knots: np.ndarray  # (rows,) rad or s, increasing
    fx: np.ndarray  # (rows,) N, between them monotone cubic (PCHIP)
    fy: np.ndarray
    torque: np.ndarray  # (rows,) N m
    scale: float = 1.0


class OwnPush(NamedTuple):
    """A force and a torque at a point of a body by a law of one's own."""

    name: str
    at: BodyPoint
    law: tuple  # compiled, of `applied_load`


class Spring(NamedTuple):
    """A spring and damper in the line from a point of one body to a point of another."""

    name: str
    first: BodyPoint
    second: BodyPoint
    stiffness: float  # N/m
    free_length: float  # m
    damping: float  # N s/m


class TorsionSpring(NamedTuple):
    """A spring and damper between the angles of two bodies."""

    name: str
    first: BodyPoint
    second: BodyPoint
    stiffness: float  # N m/rad
    free_angle: float  # rad, of the second body minus that of the first, without torque
    damping: float  # N m s/rad


class Rubbing(NamedTuple):
    """Friction in a joint without clearance: in a pin a couple, radius times its law's force, in a guide a force."""

    name: str
    joint: str
    friction: tuple  # compiled friction law, as in a clearance joint
    radius: float = 0.0  # m, of a pin


class Braking(NamedTuple):
    """Friction of a given size in a joint with or without clearance: a law under a constant normal force.

    In a pin the couple radius T(normal, radius x relative rate), in a guide the force T(normal, relative rate).
    """

    name: str
    joint: str
    friction: tuple  # compiled form of a friction law
    radius: float = 1.0  # m
    normal: float = 1.0  # N; 1 where the coefficients of the law are couples (N m) or forces (N)


class Aim(NamedTuple):
    """The output motion of the machine: of a point along a direction, or of a body's angle."""

    body: str
    point: str = ""  # '': the angle
    direction: float = 0.0  # rad


class Machine(NamedTuple):
    """A planar machine."""

    bodies: Mapping[str, Body]  # 'ground' among them
    joints: tuple  # Pin, Guide, Slot and Mesh in the order of the grid, then Stops; Stretch in elastic links
    driven: str  # name of the Pin that the drive turns: its proximal body is the ground
    drive: tuple  # Constant, Schedule, Path or Motor
    gravity: float  # m/s^2, along -y
    aim: Aim
    start: Mapping[str, float] = {}  # rad, first guesses of body angles for closing loops at the start angle; default 0
    loads: tuple = ()  # Push, TabledPush, Spring, TorsionSpring, Rubbing, Braking
    mounts: tuple[Mount, ...] = ()  # of joints at the ground
    #: rad from the start: crank angles of the run, infinite where unknown; None: a whole revolution
    visited: tuple[float, float] | None = None
