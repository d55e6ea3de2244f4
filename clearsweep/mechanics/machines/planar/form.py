"""The compiled form of a planar machine: types define the topology, values the dimensions.

The number of a body is the length of a tuple of empty tuples, which needs no memory; the ground is 0.  Points are
measured from the centre of mass of their body in its own frame, and those on its x axis or at the centre have types of
their own, which avoids multiplications by zero.
"""

import math
from typing import NamedTuple

import numpy as np

from ....tracing.compiled.family import kernel
from ....tracing.compiled.pinned import array_handle, load_item, load_items

# -------------------------------------------------------------------------------------------- bodies, joints and output


class Mass(NamedTuple):
    """A body that moves."""

    mass: float  # kg
    inertia: float  # kg m^2, about the centre of mass


class Segment(NamedTuple):
    """A further mass of the preceding elastic link, attached by a spring."""

    mass: float  # kg
    inertia: float  # kg m^2, about its centre of mass


class Housing(NamedTuple):
    """A housing on springs, or what lies between its springs: it does not turn, and has no weight."""

    mass: float  # kg
    inertia: float  # 0


class ElasticGuide(NamedTuple):
    """A guide between two masses of an elastic link, or under a housing, with a spring and damper along it."""

    stiffness: float  # N/m
    damping: float  # N s/m


class Centre(NamedTuple):
    """The centre of mass of a body, or the origin of the ground."""


class OnAxis(NamedTuple):
    """A point on the line through the centre of mass along the body's x axis."""

    x: float  # m


class OffAxis(NamedTuple):
    """A point anywhere."""

    x: float  # m
    y: float


class AlongX(NamedTuple):
    """The direction of a frame's x axis."""


class Along(NamedTuple):
    """A direction in a frame."""

    x: float
    y: float


class Hinge(NamedTuple):
    """A revolute joint."""

    site: tuple  # Ideal() or Open()
    proximal: tuple  # number of the body
    distal: tuple
    near: tuple  # Centre, OnAxis or Off, on the proximal body
    far: tuple  # on the distal body


class Slide(NamedTuple):
    """A prismatic joint."""

    site: tuple  # Ideal(), Open() or Sprung
    proximal: tuple
    distal: tuple
    near: tuple
    far: tuple
    axis: tuple  # AlongX or Along, in the frame of the proximal body


class Gear(NamedTuple):
    """Two bodies whose angles keep a ratio: two wheels in mesh, or the halves of a coupling."""

    site: tuple  # Ideal() or Open()
    proximal: tuple
    distal: tuple
    near: tuple  # the centres
    far: tuple
    axis: tuple  # AlongX or Along, from the first centre to the second in the frame of the carrier; () for a coupling
    carrier: tuple  # number of the body
    pins: tuple  # numbers of the pins of both bodies as tuples of empty tuples; () for a coupling
    eccentric: tuple  # points, the centre of each pitch circle from its pin; () if both are at their pins
    ratio: float  # of the second angle in the sum that stays constant
    arm: float  # m, position along the line of action for a unit of the first angle
    across: float  # force on the second centre across the line of centres per force on the drive flank
    apart: float  # force along it per force on either flank
    rest: float  # rad, the constant sum


class Travel(NamedTuple):
    """The travel of a guide without clearance, at whose ends it is stopped."""

    site: tuple  # Open()
    proximal: tuple
    distal: tuple
    near: tuple
    far: tuple
    guide: tuple  # number of the guide


class PointAim(NamedTuple):
    """The output is the position of a point along a direction of the fixed frame."""

    body: tuple
    point: tuple
    direction: tuple  # AlongX or Along


class AngleAim(NamedTuple):
    """The output is the angle of a body."""

    body: tuple


class Planar(NamedTuple):
    """The compiled form of a planar machine."""

    bodies: tuple  # of Mass, Segment, Housing and bending.Bent, without the ground
    joints: tuple  # of Hinge, Slide and Gear in the order of the grid, then of their stops, Gear and Travel
    dependent: tuple  # indices of the dependent coordinates
    crank: tuple  # number of the driven body
    drive: tuple  # of `drive`
    gravity: float  # m/s^2, along -y
    loads: tuple  # of `loads`
    aim: tuple  # PointAim or AngleAim
    cycle: tuple  # Cycle of the ideal machine: its output, then the dependent coordinates


def as_empty_tuples(count: int) -> tuple:
    """Return a number as a tuple of empty tuples."""
    return ((),) * count


def compile_point(x: float, y: float) -> tuple:
    """Return a point (m, from the centre of mass) in the form without zeros."""
    if y != 0.0:
        return OffAxis(x, y)
    return OnAxis(x) if x != 0.0 else Centre()


def compile_direction(x: float, y: float) -> tuple:
    """Return a unit vector in the form without zeros."""
    return AlongX() if (x, y) == (1.0, 0.0) else Along(x, y)


# ---------------------------------------------------------------------------------------------- the pose


class Orientation(NamedTuple):
    """Orientation of the bodies in a group."""

    c: float  # cosine of their angle
    s: float
    angle: float  # rad
    rate: float  # rad/s


class Pose(NamedTuple):
    """Positions and velocities of the bodies."""

    orientations: tuple  # an Orientation for each group except the ground's
    travels: tuple  # (m, m/s) along each guide of the tree
    roots: tuple  # (x m, y m, vx m/s, vy m/s) of each floating body's centre of mass
    time: float  # s
    bends: tuple = ()  # (m, m/s) of each deformation of a link that bends
    integral: float = 0.0  # N m, integral part of a drive's torque


# ---------------------------------------------------------------------------------------------- the ideal machine

# Compiled tables of the ideal machine's motion over a revolution of its crank.
#
# Between stations a polynomial of degree five matches values and two derivatives at both ends; with 720
# stations this is as accurate as the stations themselves.


WIDTH = 3  # numbers at a station: value and its first two derivatives by the crank's angle


class Cycle(NamedTuple):
    """Quantities over a revolution: columns of (value, derivative, second derivative) at equidistant stations."""

    table: float  # address of (stations + 1, columns, WIDTH) numbers
    stations: float
    columns: float
    start: float  # rad, crank's angle at the first station


class BranchingCycle(NamedTuple):
    """The Cycle of a machine whose loops pass change points; further columns are derivatives of those of its loops."""

    table: float
    stations: float
    columns: float
    start: float


def make_cycle(
    columns: list[tuple[np.ndarray, np.ndarray, np.ndarray]], start: float, form: type = Cycle
) -> Cycle | BranchingCycle:
    """Return the Cycle of quantities, each given with its derivatives at all stations."""
    table = np.array([list(column) for column in columns]).transpose(2, 0, 1)  # (stations + 1, columns, WIDTH)
    return form(array_handle(table), float(table.shape[0] - 1), float(table.shape[1]), start)


@kernel
def evaluate_cycle(cycle, column, angle):
    """Return value and derivative of a column of a Cycle at a crank angle (rad), continuous over revolutions."""
    stations, columns = int(cycle.stations), int(cycle.columns)
    revolutions = (angle - cycle.start) * (0.5 / math.pi)
    turns = math.floor(revolutions)
    position = (revolutions - turns) * stations
    station = min(max(int(position), 0), stations - 1)  # the angle of a trial step may be enormous
    t, h = position - station, 2.0 * math.pi / stations
    start_offset = WIDTH * (columns * station + column)
    end_offset = start_offset + WIDTH * columns
    f0, d0, s0 = load_items(cycle.table, start_offset, 3)
    f1, d1, s1 = load_items(cycle.table, end_offset, 3)
    d0, s0, d1, s1 = h * d0, h * h * s0, h * d1, h * h * s1
    value_defect = f1 - f0 - d0 - 0.5 * s0
    slope_defect, slope_change = d1 - d0 - s0, s1 - s0
    a3 = 10.0 * value_defect - 4.0 * slope_defect + 0.5 * slope_change
    a4 = -15.0 * value_defect + 7.0 * slope_defect - slope_change
    a5 = 6.0 * value_defect - 3.0 * slope_defect + 0.5 * slope_change
    value = f0 + t * (d0 + t * (0.5 * s0 + t * (a3 + t * (a4 + t * a5))))
    slope = d0 + t * (s0 + t * (3.0 * a3 + t * (4.0 * a4 + t * 5.0 * a5)))
    first_offset, last_offset = WIDTH * column, WIDTH * (columns * stations + column)
    growth = load_item(cycle.table, last_offset) - load_item(cycle.table, first_offset)
    return value + growth * turns, slope / h
