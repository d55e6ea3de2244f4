"""Formulas that close the loops of a planar machine one joint after the other, as those of dyads.

A joint that closes a loop determines as many coordinates as it has equations.  If an angle is among them, the other one
is eliminated, and what remains for its direction e = (cosine, sine) is a line across a circle:

    g . e = h,   so that   e = (h g + side sqrt(g^2 - h^2) g') / g^2,    g' : g turned to the left by 90 degrees.

Two angles (a dyad RRR) close K + R_a p + R_b q = 0, so that g . e = K . R_a p and 2 h = q^2 - p^2 - K^2.  An angle and
a length (RRP, RPR) meet on a line; lengths alone (RPP) follow from linear equations.  The side is that of the assembly
and changes only in a singular position.  Near one the root loses digits, but the loop still closes to rounding.
"""

from collections.abc import Mapping
from typing import NamedTuple

from ....tracing.compiled import calculus as math
from ....tracing.compiled.choosing import SHIFT, where
from ....tracing.compiled.dual import Dual, slope, value
from ....tracing.compiled.family import kernel
from ....tracing.compiled.formulas import ONE, ZERO, Expr, Program, sum_of
from ..programs import NO_VECTOR, PlaneVector, generated
from .kinematics import Kinematics, PoseProgram
from .loops import Solver, equations_of_joint
from .structure import ANGLE, SHIFT_X, SHIFT_Y, TRAVEL, Coordinate, MachineType, machine_type


class Step(NamedTuple):
    """A joint that closes a loop, and the dependent coordinates that it determines."""

    joint: int
    unknowns: tuple[Coordinate, ...]
    angles: tuple[Coordinate, ...]  # those of which its equations contain the directions

    @property
    def lengths(self) -> tuple[Coordinate, ...]:
        """Return the others that move a point."""
        return tuple(coordinate for coordinate in self.unknowns if coordinate.kind != ANGLE)


class Line(NamedTuple):
    """The equation g . e = h of the direction e of an angle."""

    g: PlaneVector
    h: Expr


def steps_of(kinematics: Kinematics) -> list[Step]:
    """Return the joints that close all loops one after the other; [] if some determine coordinates only together."""
    steps: list[Step] = []
    pending, unknown = list(kinematics.spanning_tree.loop_joints), list(kinematics.machine.dependent)
    while pending:
        step = next((step for j in pending if (step := _step_of(kinematics, j, unknown))), None)
        if step is None:
            return []
        steps.append(step)
        pending.remove(step.joint)
        unknown = [coordinate for coordinate in unknown if coordinate not in step.unknowns]
    return steps


def _step_of(kinematics: Kinematics, j: int, unknown: list[Coordinate]) -> Step | None:
    """Return the step of a joint, None if not as many coordinates are unknown as it has equations."""
    link = kinematics.machine.sites[j].link
    own = {Coordinate(ANGLE, group) for group, _ in kinematics.shares(j)} if link.geared else _movers(kinematics, j)
    unknowns = tuple(coordinate for coordinate in unknown if coordinate in own)
    angles = () if link.geared else tuple(coordinate for coordinate in unknowns if coordinate.kind == ANGLE)
    return Step(j, unknowns, angles) if len(unknowns) == (1 if link.slides or link.geared else 2) else None


def _movers(kinematics: Kinematics, j: int) -> set[Coordinate]:
    """Return the angles and lengths in the equations of a pin or a guide."""
    path, sites = kinematics.gap(j), kinematics.machine.sites
    guides = [*path.travel_signs, *([j] if sites[j].link.slides else [])]
    groups = [g for g, arm in path.arms.items() if arm != NO_VECTOR]
    groups += [kinematics.spanning_tree.group[sites[guide].link.proximal] for guide in guides]
    lengths = [Coordinate(TRAVEL, guide) for guide in path.travel_signs]
    lengths += [Coordinate(kind, body) for body in path.floating_signs for kind in (SHIFT_X, SHIFT_Y)]
    return {*(Coordinate(ANGLE, g) for g in groups), *lengths}


def line_of(kinematics: Kinematics, step: Step) -> Line:
    """Return the equation of the first angle of a step; other unknown lengths are zero."""
    link, path = kinematics.machine.sites[step.joint].link, kinematics.gap(step.joint)
    groups = [angle.owner for angle in step.angles]
    fixed = kinematics.position(path._replace(arms={g: arm for g, arm in path.arms.items() if g not in groups}))
    arm = path.arms.get(groups[0], NO_VECTOR)
    if len(groups) > 1:
        far = path.arms[groups[1]]
        twice_h = sum_of([far.dot(far), -arm.dot(arm), -fixed.dot(fixed)])
        return Line(PlaneVector(fixed.dot(arm), fixed.dot(arm.left())), 0.5 * twice_h)
    length = Coordinate(TRAVEL, step.joint) if link.slides else step.lengths[0]
    axis, group = PlaneVector(ONE, ZERO) if length.kind == SHIFT_X else PlaneVector(ZERO, ONE), 0
    if length.kind == TRAVEL:
        axis = kinematics.joints[length.owner].axis
        group = kinematics.spanning_tree.group[kinematics.machine.sites[length.owner].link.proximal]
    if group == groups[0]:
        normal = axis.left()
        return Line(PlaneVector(normal.dot(fixed), normal.left().dot(fixed)), -normal.dot(arm))
    normal = kinematics.to_fixed_frame(group, axis).left()
    return Line(PlaneVector(normal.dot(arm), normal.dot(arm.left())), -normal.dot(fixed))


class Closing:
    """The dependent coordinates of a pose, one step after the other."""

    def __init__(self, writer: PoseProgram, near: Mapping[Coordinate, Expr]):
        """Begin with all other positions; near : angles (rad) within half a turn of the dependent ones."""
        self.writer, self.near = writer, near
        writer.values |= dict.fromkeys(writer.machine.dependent, ZERO)
        writer.turned |= {coordinate.owner: ZERO for coordinate in near}
        writer.place()
        self.steps = steps_of(writer)
        for number, step in enumerate(self.steps):
            self._take_step(number, step)

    def _take_step(self, number: int, step: Step) -> None:
        """Take the coordinates that a joint determines."""
        writer = self.writer
        if not step.angles:
            equations = equations_of_joint(writer, step.joint, with_rates=False)
            solver = Solver([equation.columns for equation in equations], step.unknowns)
            for coordinate, change in solver.solve([-equation.value for equation in equations]).items():
                writer.take(coordinate, change)
        else:
            self._take_direction(step.angles[0], self.direction(number, step.angles[0], line_of(writer, step)))
            path = writer.gap(step.joint)
            if len(step.angles) > 1:
                far = path.arms.pop(step.angles[1].owner)
                end, scale = -writer.position(path), 1.0 / far.dot(far)
                self._take_direction(step.angles[1], scale * PlaneVector(far.dot(end), far.cross(end)))
            for length in step.lengths:
                writer.take(length, -writer.columns(path)[length].dot(writer.position(path)))
        writer.place()

    def _take_direction(self, angle: Coordinate, direction: PlaneVector) -> None:
        """Take the direction of an angle, and the angle (rad) itself, which few need."""
        cosine, sine = direction.assigned()
        self.writer.cosine[angle.owner], self.writer.sine[angle.owner] = cosine, sine
        turned = self.writer.program.call(_angle, cosine, sine, self.near[angle])
        self.writer.values[angle] = self.writer.turned[angle.owner] = turned

    def direction(self, number: int, angle: Coordinate, line: Line) -> PlaneVector:
        """Return the direction of the first angle of a step."""
        square = line.g.dot(line.g)
        root = self.writer.program.call(_root, square - line.h * line.h)
        across = (self.writer.mechanism.sides[number] * root).assigned()
        return (1.0 / square) * (line.h * line.g + across * line.g.left())


class _Assembly(Closing):
    """The sides of a closed pose."""

    def __init__(self, writer: PoseProgram, near: Mapping[Coordinate, Expr]):
        """Begin with all other positions; near : the dependent angles (rad)."""
        self.sides: dict[int, tuple[Expr, Expr]] = {}  # of each step: g x e and g^2
        super().__init__(writer, near)

    def direction(self, number: int, angle: Coordinate, line: Line) -> PlaneVector:
        """Return the direction of the first angle of a step, and note its side."""
        known = self.writer.program.call(math.direction, self.near[angle])
        direction = PlaneVector(known[0], known[1])
        self.sides[number] = line.g.cross(direction), line.g.dot(line.g)
        return direction


@generated(machine_type)
def assembly_of(machine: MachineType) -> Program:
    """Return the program of the sides of a closed position, from a mechanism and the values of all coordinates.

    The crank's angle is the first; the program returns pairs g x e and g^2 of each step, (1, 1) where there is only one
    side.  It returns () for a machine whose loops are not closed by one joint after the other.
    """
    writer = PoseProgram(machine, 2)
    crank, values = Coordinate(ANGLE, machine.spanning_tree.crank), writer.program.parameters[1]
    coordinates = dict.fromkeys([crank, *machine.spanning_tree.coordinates])
    numbers = {coordinate: values[i] for i, coordinate in enumerate(coordinates)}
    for coordinate in writer.known:
        writer.take(coordinate, numbers[coordinate])
    near = {coordinate: numbers[coordinate] for coordinate in machine.dependent if coordinate.kind == ANGLE}
    assembly = _Assembly(writer, near)
    return writer.program.returns(tuple(assembly.sides.get(i, (ONE, ONE)) for i in range(len(assembly.steps))))


@kernel
def _root(square):
    """Return a square root; nan of a negative number, where the loop does not close."""
    return math.sqrt(where(square >= 0.0, square, math.nan * square))


@kernel
def _angle(cosine, sine, near):
    """Return the angle (rad) of a direction that is nearest to another angle."""
    if isinstance(cosine, Dual) or isinstance(sine, Dual):
        rate = value(cosine) * slope(sine) - value(sine) * slope(cosine)
        return Dual(_angle(value(cosine), value(sine), near), rate)
    angle = math.atan2(sine, cosine)
    turns = ((near - angle) * (0.5 / math.pi) + SHIFT) - SHIFT
    return angle + 2.0 * math.pi * turns
