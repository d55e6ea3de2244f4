"""The compiled form of a planar machine: types define the topology, values the dimensions.

It consists of records of `contracts.machine`.  In place of names of bodies and joints they have numbers, in place of
names of points and of angles of lines points and unit vectors, and () in place of what is not needed.

The number of a body is the length of a tuple of empty tuples, which needs no memory; the ground is 0.  Points are
measured from the centre of mass of their body in its own frame, and those on its x axis or at the centre have types of
their own, which avoids multiplications by zero.

A link that bends is a uniform bar between two pins in a floating frame, its chord, with foreshortening.  With w the
deflection across the chord and l the length between the pins, a point of the bar is at

    x = s - 1/2 int_0^s w'^2 + stretch,    y = w = sum q_k sin(k pi s / l),

to second order in w (Shabana 2020, "Dynamics of Multibody Systems", 5th ed., chapter 5; Kane, Ryan & Banerjee 1987,
J. Guidance 10:139).  The shortening makes an axial load change the bending stiffness.  The kinetic energy is that of
all of x and y.  Mass and moment of inertia are as given: what the uniform line lacks of them is rigid.  Functions of
s / l are given by their coefficients of a few shapes.  Integrals over the bar are then products of coefficients with
known numbers.
"""

import functools
import itertools
import math
from typing import NamedTuple

import numpy as np

from ....contracts.machine import Bending, Body, Elastic, Machine
from ....tracing import portable
from ....tracing.compiled.family import kernel
from ....tracing.compiled.pinned import array_handle, load_item, load_items

# ---------------------------------------------------------------------------------------------- bodies and joints


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


class Planar(NamedTuple):
    """The compiled form of a planar machine."""

    bodies: tuple  # of Mass, Segment, Housing and bending.Bent, without the ground
    joints: tuple  # of Pin, Guide, Slot and Mesh in the order of the grid, then of their stops, Mesh and Stops; Stretch
    sites: tuple  # Ideal() or Open() for each of them
    dependent: tuple  # indices of the dependent coordinates
    crank: tuple  # number of the driven body
    drive: tuple  # of `drives`
    gravity: float  # m/s^2, along -y
    loads: tuple  # of `load_forms`
    aim: tuple  # Aim
    cycle: tuple  # Cycle of the ideal machine: its output, then the dependent coordinates
    sides: tuple = ()  # 1 or -1, the assembly of each dyad that closes a loop; () unless dyads close all loops


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


BranchingCycle = NamedTuple("BranchingCycle", [*Cycle.__annotations__.items()])
BranchingCycle.__doc__ = """The Cycle of a machine whose loops pass change points.

Further columns are derivatives of those of its loops.
"""


def make_cycle(columns: list[tuple[np.ndarray, np.ndarray, np.ndarray]], start: float, form: type = Cycle) -> tuple:
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


# ---------------------------------------------------------------------------------------------- links that bend


class Bent(NamedTuple):
    """A body whose line between two pins bends."""

    mass: float  # kg
    inertia: float  # kg m^2, about the centre of mass, beyond that of the line; may be negative
    length: float  # m, of the line
    axis: tuple  # AlongX or Along, of the line in the frame of the body
    modes: tuple  # number of bending modes
    stiffness: tuple  # N/m, of each mode, then of each axial segment
    damping: tuple  # N s/m
    edge_modulus: float  # Pa m, Young's modulus times the distance of the edge


class BentPoint(NamedTuple):
    """A point of a body that bends, at = its place without deformation; the others are its derivatives.

    A point off the line turns with its section, a point beyond a pin with the section at that pin.
    """

    at: tuple  # Centre, OnAxis or OffAxis
    slopes: tuple  # by each mode (1), then by the extension of each axial segment
    curvatures: tuple  # second derivatives by pairs of modes (1/m), see `pairs_of`
    turns: tuple  # of the angle of its section by each mode, 1/m
    cuts: tuple  # number of stations between it and the first pin: where the bar is cut there, it moves with the rest


class Line(NamedTuple):
    """The line of a link: its first point and direction in the frame of the link, and its length."""

    near: np.ndarray  # m
    direction: np.ndarray  # unit vector
    length: float  # m


def line_of(body: Body, elastic: Elastic) -> Line:
    """Return the line between the pins of an elastic link."""
    near, far = (np.array(body.points[point]) for point in (elastic.near, elastic.far))
    length = float(np.hypot(*(far - near)))
    return Line(near, (far - near) / length, length)


def first_rate(body: Body, elastic: Elastic) -> float:
    """Return the rate (rad/s) of the first bending mode between pins: (pi / l)^2 sqrt(E I l / m)."""
    length = line_of(body, elastic).length
    assert elastic.bending is not None  # only of links that bend
    return (math.pi / length) ** 2 * math.sqrt(elastic.bending.rigidity * length / body.mass)


def compile_bent(body: Body, elastic: Elastic, bending: Bending) -> Bent:
    """Return the compiled form of a body that bends."""
    line = line_of(body, elastic)
    orders = np.arange(1, bending.modes + 1)
    bending_stiffness = 0.5 * bending.rigidity * line.length * (orders * math.pi / line.length) ** 4
    axial_stiffness = np.full(elastic.segments, elastic.segments * elastic.stiffness)
    axial_rate = math.pi * math.sqrt(elastic.stiffness / body.mass) if elastic.segments else math.inf
    damping_times = (
        np.full(bending.modes, 2.0 * elastic.damping / first_rate(body, elastic)),
        np.full(elastic.segments, 2.0 * elastic.damping / axial_rate),
    )
    stiffness = np.concatenate([bending_stiffness, axial_stiffness])
    return Bent(
        body.mass,
        body.inertia - body.mass * line.length**2 / 12.0,
        line.length,
        compile_direction(*map(float, line.direction)),
        as_empty_tuples(bending.modes),
        tuple(stiffness.tolist()),
        tuple((stiffness * np.concatenate(damping_times)).tolist()),
        bending.young * bending.edge,
    )


def compile_bent_point(body: Body, elastic: Elastic, bending: Bending, place: tuple[float, float]) -> BentPoint:
    """Return the compiled form of a point (m, in the frame of the body) of a body that bends."""
    line, orders = line_of(body, elastic), np.arange(1, bending.modes + 1)
    axial = line.direction
    transverse = np.array([-axial[1], axial[0]])
    arm = np.array(place) - line.near
    axial_part, transverse_part = float(portable.product(arm, axial)), float(portable.product(arm, transverse))
    section = min(max(axial_part / line.length, 0.0), 1.0)
    section = round(section) if abs(section - round(section)) < AT_PIN else section
    offset_along, offset_across = axial_part - section * line.length, transverse_part
    turns = orders * math.pi / line.length * portable.cos(orders * math.pi * section)
    deflections = portable.sin(orders * math.pi * section) if 0.0 < section < 1.0 else np.zeros(bending.modes)
    slopes = [
        _compile_vector(-offset_across * turn * axial + (deflection + offset_along * turn) * transverse)
        for turn, deflection in zip(turns, deflections, strict=True)
    ]
    stretches = [_compile_vector(ramp(i, elastic.segments, section) * axial) for i in range(elastic.segments)]
    curvatures = []
    for k, j in pairs_of(bending.modes):
        shortening = -shortening_at(k, j, section) / line.length
        turn = turns[k] * turns[j]
        curvatures.append(
            _compile_vector((shortening - turn * offset_along) * axial - turn * offset_across * transverse)
        )
    at = compile_point(*map(float, np.subtract(place, body.center)))
    cuts = as_empty_tuples(sum(place < section or section == 1.0 for place in STATIONS))
    return BentPoint(at, (*slopes, *stretches), tuple(curvatures), tuple(turns.tolist()), cuts)


def problem_of_links(machine: Machine) -> tuple[str, str] | None:
    """Return a body, with its key, and a sentence if a link of a machine cannot bend as described; else None."""
    for name, body in machine.bodies.items():
        elastic = body.elastic
        if elastic is None or elastic.bending is None:
            continue
        line, orders = line_of(body, elastic), np.arange(2, elastic.bending.modes + 1, 2)
        bar = body.mass * line.length**2
        least = bar * float(np.sum(2.0 / (orders * math.pi) ** 2))
        if body.inertia <= least:
            return f"{name}.inertia", (
                f"found {body.inertia:.6g} kg*m^2; a uniform bar of this mass and length has {bar / 12.0:.6g} kg*m^2, "
                f"and the {elastic.bending.modes} bending modes alone have {least:.6g} kg*m^2; write more than that"
            )
        for joint in machine.joints:
            for end in (joint.proximal, joint.distal):
                arm = np.array(body.points[end.point]) - line.near if end.body == name else np.zeros(2)
                offset = abs(float(arm[0] * line.direction[1] - arm[1] * line.direction[0]))
                if offset > OFF_LINE * line.length:
                    return f"{name}.elastic", (
                        f"{joint.name}, at {end.body}.{end.point}, is {1e3 * offset:.4g} mm off the line of its pins; "
                        "only a bar whose pins are on one line bends: leave `elastic` out, or move the point"
                    )
    return None


OFF_LINE = 1e-6  # of the length: a pin farther from the line makes a plate of the bar
STATIONS = tuple(i / 10 for i in range(11))  # s / l, where the stress is computed
AT_PIN = 1e-9  # of the length: a point so near a pin is at it
NO_LENGTH = 1e-14  # of a unit: rounding of a component that is zero


def _compile_vector(vector: np.ndarray) -> tuple:
    """Return a vector in the form without zeros."""
    x, y = (0.0 if abs(component) < NO_LENGTH else float(component) for component in vector)
    return compile_point(x, y)


def pairs_of(modes: int) -> list[tuple[int, int]]:
    """Return the pairs of modes, each with itself or a later one, counted from 0."""
    return [(k, j) for k in range(modes) for j in range(k, modes)]


# ---------------------------------------------------------------------------------------------- shapes of the line


Shape = tuple  # (name, numbers): ('one',), ('line',), ('sine', k), ('ramp', segment, segments), ('step', place)
ONE_SHAPE, LINE_SHAPE = ("one",), ("line",)
GAUSS_POINTS = 32


def ramp(segment: int, segments: int, place):
    """Return the share of the extension of a segment that a place, s / l, moves by."""
    return np.clip(segments * place - segment, 0.0, 1.0)


def value_of(shape: Shape, place):
    """Return a shape at places s / l."""
    name, *numbers = shape
    if name == "sine":
        return portable.sin(numbers[0] * math.pi * place)
    if name == "ramp":
        return ramp(*numbers, place)
    if name == "step":
        return np.where(place > numbers[0], 1.0, 0.0)
    return place - 0.5 if name == "line" else np.ones_like(place)


def _ends_of_pieces(shape: Shape) -> set[float]:
    """Return the places between which a shape is smooth."""
    name, *numbers = shape
    if name == "ramp":
        return {numbers[0] / numbers[1], (numbers[0] + 1) / numbers[1]}
    return {numbers[0]} if name == "step" else set()


@functools.lru_cache(maxsize=4096)
def integral_of_product(first: Shape, second: Shape) -> float:
    """Return the integral of the product of two shapes over s / l from 0 to 1; 0 where only rounding is left."""
    ends = sorted({0.0, 1.0} | _ends_of_pieces(first) | _ends_of_pieces(second))
    nodes, weights = portable.gauss_rule(GAUSS_POINTS)
    total = 0.0
    for begin, end in itertools.pairwise(ends):
        places = begin + 0.5 * (end - begin) * (nodes + 1.0)
        products = value_of(first, places) * value_of(second, places)
        total += 0.5 * (end - begin) * float(portable.product(weights, products))
    return total if abs(total) > NO_LENGTH else 0.0


@functools.cache
def shortening_shapes(k: int, j: int) -> dict[Shape, float]:
    """Return l int_0^s w_k' w_j' in shapes, for modes k and j, counted from 0."""
    first, second = k + 1, j + 1
    factor = 0.5 * math.pi**2 * first * second
    shapes = {("sine", first + second): factor / (math.pi * (first + second))}
    if k == j:
        return {ONE_SHAPE: 0.5 * factor, LINE_SHAPE: factor} | shapes
    distance = abs(first - second)
    return {("sine", distance): factor / (math.pi * distance)} | shapes


def shortening_at(k: int, j: int, place: float) -> float:
    """Return l int_0^s w_k' w_j' at a place s / l."""
    return sum(weight * float(value_of(shape, np.array(place))) for shape, weight in shortening_shapes(k, j).items())
