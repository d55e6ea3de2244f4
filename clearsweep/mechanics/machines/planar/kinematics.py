"""Formulas for positions, velocities and accelerations of a planar machine's bodies.

A point is reached from the ground through arms, each fixed in a body, and displacements along guides:

    r = sum over angle groups g of R_g p_g + position of a floating body,    p_g constant except along guides

so its derivative by the angle of g is R_g p_g turned by 90 degrees, and its acceleration without any of the coordinates
is -omega_g^2 R_g p_g + 2 omega_g x (velocity of the runs).
"""

import functools
from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

from ....contracts.machine import OwnPush, Push, Spring, TorsionSpring
from ....tracing.compiled import calculus as math
from ....tracing.compiled.choosing import where
from ....tracing.compiled.dual import plain
from ....tracing.compiled.family import inlined
from ....tracing.compiled.formulas import ONE, ZERO, Expr, Program, sum_of
from ..programs import NO_VECTOR, PlaneVector, vector_sum
from .bent_line import BentLine
from .form import AlongX, Centre, OnAxis, evaluate_cycle, pairs_of
from .load_forms import AngleTableLoad, applied_load, table_values
from .structure import ANGLE, BEND, SHIFT_X, SHIFT_Y, TRAVEL, BentForm, Coordinate, LoadKind, MachineType, PointForm

# ---------------------------------------------------------------------------------------------- vectors


@dataclass(frozen=True)
class BentVector(PlaneVector):
    """A point of a body that bends, in its frame, with its derivatives by the deformation."""

    group: int
    slopes: tuple[tuple[Coordinate, PlaneVector], ...]
    curvatures: tuple[tuple[Coordinate, Coordinate, PlaneVector], ...]  # of each pair once
    turns: tuple[tuple[Coordinate, Expr], ...]  # of the angle of its section


def vector_of(form: type | None, value: Expr) -> PlaneVector:
    """Return a point or direction of the compiled form; form : its type, None without one."""
    if form in (None, Centre):
        return NO_VECTOR
    if form is AlongX:
        return PlaneVector(ONE, ZERO)
    return PlaneVector(value.x, ZERO if form is OnAxis else value.y)


# ---------------------------------------------------------------------------------------------- bodies


Row = dict[Coordinate, Expr]
Columns = dict[Coordinate, PlaneVector]  # derivatives of a position by coordinates
CENTRE = NO_VECTOR  # centre of mass of a body, from which its points are given


class Path(NamedTuple):
    """The path to a point: arms, guides, floating body and points that bend, with signs (1 or -1) for directions."""

    arms: dict[int, PlaneVector]  # of each group
    travel_signs: dict[int, int]  # guide -> sign
    floating_signs: dict[int, int]  # floating body -> sign
    bent_signs: dict[BentVector, int]  # point of a body that bends -> sign


class JointVectors(NamedTuple):
    """The points of a joint, each from the centre of mass of its body and in its frame."""

    near: PlaneVector  # on the proximal body
    far: PlaneVector
    axis: PlaneVector  # of a guide, in the frame of the proximal body


class Load(NamedTuple):
    """An external load."""

    body: int
    point: PlaneVector  # of the body
    force: PlaneVector
    torque: Expr


class Kinematics:
    """Positions and their derivatives in a program; subclasses define the source of angles and rates."""

    cuts_links = False  # whether links that bend are cut, to find their normal forces

    def __init__(self, machine: MachineType, parameters: int):
        """Begin a program; parameters : their number, the mechanism being the first."""
        self.machine, self.program, self.spanning_tree = machine, Program(parameters), machine.spanning_tree
        self.mechanism = self.program.parameters[0]
        self.cosine: dict[int, Expr] = {}
        self.sine: dict[int, Expr] = {}
        self.turned: dict[int, Expr] = {}  # angle of each group
        self.rate: dict[Coordinate, Expr] = {}  # of every coordinate, the driven crank's angle among them
        self.travel: dict[int, Expr] = {}
        self.shift: dict[int, PlaneVector] = {}
        self.bend: Row = {}  # values of the deformations of links that bend

    @functools.cached_property
    def joints(self) -> list[JointVectors]:
        """Return the points and axes of all joints; of links that bend, as they are deformed."""
        return [self._joint_vectors(j) for j in range(len(self.machine.sites))]

    def _joint_vectors(self, j: int) -> JointVectors:
        site, joint = self.machine.sites[j], self.mechanism.joints[j]
        axis = vector_of(site.axis, joint.centres if site.link.geared else joint.axis) if site.axis else NO_VECTOR
        near = self.point_of(site.link.proximal, site.near, joint.proximal.point)
        far = self.point_of(site.link.distal, site.far, joint.distal.point)
        return JointVectors(near, far, axis)

    def point_of(self, body: int, form: PointForm, value: Expr) -> PlaneVector:
        """Return a point of a body in its frame, from its compiled form."""
        if not isinstance(form, BentForm):
            return vector_of(form, value)
        kind = self.machine.bent[body]
        slopes = {c: [vector_of(form.slopes[i], value.slopes[i])] for i, c in enumerate(kind.coordinates)}
        terms = [vector_of(form.at, value.at), *(self.bend[c] * slope for c, (slope,) in slopes.items())]
        curvatures = []
        for i, (k, j) in enumerate(pairs_of(kind.modes)):
            vector = vector_of(form.curvatures[i], value.curvatures[i])
            if vector == NO_VECTOR:
                continue
            first, second = kind.coordinates[k], kind.coordinates[j]
            curvatures.append((first, second, vector))
            slopes[first].append(self.bend[second] * vector)
            if k != j:
                slopes[second].append(self.bend[first] * vector)
            product = self.bend[first] * self.bend[second]
            terms.append((0.5 * product if k == j else product).assigned() * vector)
        place = vector_sum(terms)
        sums = ((c, vector_sum(parts)) for c, parts in slopes.items())
        present = tuple((c, slope) for c, slope in sums if slope != NO_VECTOR)
        if self.cuts_links:
            axis = vector_of(kind.axis, self.mechanism.bodies[body - 1].axis)
            present += tuple((cut, axis) for cut in kind.cuts[: form.cuts])
        turns = tuple((c, value.turns[i]) for i, c in enumerate(kind.coordinates[: kind.modes]))
        return BentVector(*place, self.spanning_tree.group[body], present, tuple(curvatures), turns)

    def take_pose(self, pose: Expr) -> None:
        """Take angles, rates and positions from a Pose."""
        for i, g in enumerate(self.machine.groups):
            orientation = pose.orientations[i]
            self.cosine[g], self.sine[g], self.turned[g] = orientation.c, orientation.s, orientation.angle
            self.rate[Coordinate(ANGLE, g)] = orientation.rate
        runs = [coordinate.owner for coordinate in self.spanning_tree.coordinates if coordinate.kind == TRAVEL]
        for i, j in enumerate(runs):
            self.travel[j], self.rate[Coordinate(TRAVEL, j)] = pose.travels[i][0], pose.travels[i][1]
        for i, body in enumerate(self.spanning_tree.roots()):
            root = pose.roots[i]
            self.shift[body] = PlaneVector(root[0], root[1])
            self.rate[Coordinate(SHIFT_X, body)], self.rate[Coordinate(SHIFT_Y, body)] = root[2], root[3]
        deformations = [coordinate for coordinate in self.spanning_tree.coordinates if coordinate.kind == BEND]
        for i, coordinate in enumerate(deformations):
            self.bend[coordinate], self.rate[coordinate] = pose.bends[i][0], pose.bends[i][1]

    def predicted_rates(self, crank_angle: Expr) -> tuple[Row, Row]:
        """Return the first two derivatives of the dependent coordinates of the ideal machine by the crank's angle.

        Empty unless the loops pass change points: near these, rates follow the ideal machine.
        """
        slopes: Row = {}
        curvatures: Row = {}
        if self.machine.branches:
            first_column, angle = 1 + len(self.machine.dependent), self.program.call(plain, crank_angle)
            for i, coordinate in enumerate(self.machine.dependent, start=first_column):
                derivatives = self.program.call(evaluate_cycle, self.mechanism.cycle, i, angle)
                slopes[coordinate], curvatures[coordinate] = derivatives[0], derivatives[1]
        return slopes, curvatures

    # ------------------------------------------------------------------------------------------ paths

    def path_to(self, body: int, point: PlaneVector = CENTRE) -> Path:
        """Return the path to a point of a body."""
        arms: dict[int, PlaneVector] = {}
        travel_signs: dict[int, int] = {}
        floating_signs: dict[int, int] = {}
        bent_signs: dict[BentVector, int] = {}
        group = self.spanning_tree.group[body]
        if body != 0 and self.spanning_tree.parents[body] is None:
            floating_signs[body] = 1
        elif body != 0:
            parent, j = self.spanning_tree.parents[body]
            link, joint = self.machine.sites[j].link, self.joints[j]
            forward = link.proximal == parent
            outer_end, inner_end = (joint.far, joint.near) if forward else (joint.near, joint.far)
            path_to_parent = self.path_to(parent, inner_end)
            arms, travel_signs, floating_signs, bent_signs = map(dict, path_to_parent)
            arms[group] = arms.get(group, NO_VECTOR) - outer_end
            if isinstance(outer_end, BentVector):
                bent_signs[outer_end] = -1
            if link.slides:
                travel_signs[j] = 1 if forward else -1
                arms[group] += signed(travel_signs[j], self.travel[j] * joint.axis)
        arms[group] = arms.get(group, NO_VECTOR) + point
        if isinstance(point, BentVector):
            bent_signs = _difference(bent_signs, {point: -1})
        return Path(arms, travel_signs, floating_signs, bent_signs)

    def between(self, start: Path, end: Path) -> Path:
        """Return the path from one point to another."""
        arms = dict(end.arms)
        for g, arm in start.arms.items():
            other_arm = arms.get(g, NO_VECTOR)
            arms[g] = NO_VECTOR if arm == other_arm else other_arm - arm
        return Path(
            arms,
            _difference(end.travel_signs, start.travel_signs),
            _difference(end.floating_signs, start.floating_signs),
            _difference(end.bent_signs, start.bent_signs),
        )

    def shares(self, j: int) -> list[tuple[int, Expr]]:
        """Return the groups of a gear's bodies, each with the factor of its angle in the sum that stays constant."""
        site, ratio = self.machine.sites[j], self.mechanism.joints[j].ratio
        shares = [(site.link.proximal, ONE), (site.link.distal, ratio)]
        if site.pins:
            shares.append((site.carrier, -(ONE + ratio)))
        groups = [(self.spanning_tree.group[body], share) for body, share in shares]
        return [(group, share) for group, share in groups if group != 0]

    def travel_along(self, guide: int, j: int) -> tuple[Expr, Expr, PlaneVector]:
        """Return the travel of the guide that joint `j` stops, its rate, and its direction, as seen from the walls."""
        path, axis = self.gap(j), self.axis(guide)
        position, spin = self.position(path), self.spin(self.machine.sites[guide].link.proximal)
        return axis.dot(position), axis.dot(self.velocity(path)) + spin * axis.left().dot(position), axis

    def line_of_centres(self, j: int) -> PlaneVector:
        """Return the direction from the first centre of a gear to the second without clearance, in the fixed frame."""
        return self.to_fixed_frame(self.spanning_tree.group[self.machine.sites[j].carrier], self.joints[j].axis)

    def displacement_of_centres(self, j: int) -> tuple[PlaneVector, PlaneVector]:
        """Return how far the second centre of a gear is displaced relative to the first, and its rate.

        Both are as seen from the carrier, in the fixed frame.  A centre moves if its pin has clearance, or with a wheel
        whose pitch circle is eccentric.
        """
        site, wheels = self.machine.sites[j], (self.machine.sites[j].link.proximal, self.machine.sites[j].link.distal)
        offsets, velocities = [], []
        for k, (pin, sign) in enumerate(zip(site.pins, (-1, 1), strict=True)):
            link = self.machine.sites[pin].link
            if site.eccentric:
                centre = vector_of(site.eccentric[k], self.mechanism.joints[j].eccentricities[k])
                arm = self.to_fixed_frame(self.spanning_tree.group[wheels[k]], centre)
                offsets.append(signed(sign, arm))
                velocities.append(signed(sign, self.spin(wheels[k]) * arm.left()))
            if link.open:
                path, outward = self.gap(pin), sign if link.proximal == site.carrier else -sign
                offsets.append(signed(outward, self.position(path)))
                velocities.append(signed(outward, self.velocity(path)))
        offset, velocity = vector_sum(offsets), vector_sum(velocities)
        return offset, velocity - self.spin(site.carrier) * offset.left()

    def gap(self, j: int) -> Path:
        """Return the path from the proximal to the distal point of a joint."""
        link, joint = self.machine.sites[j].link, self.joints[j]
        return self.between(self.path_to(link.proximal, joint.near), self.path_to(link.distal, joint.far))

    def direction(self, body: int) -> PlaneVector:
        """Return cosine and sine of a body's angle."""
        group = self.spanning_tree.group[body]
        return PlaneVector(self.cosine[group], self.sine[group]) if group else PlaneVector(ONE, ZERO)

    def spin(self, body: int) -> Expr:
        """Return the rate of a body's angle."""
        return self.rate.get(Coordinate(ANGLE, self.spanning_tree.group[body]), ZERO)

    def spin_at(self, body: int, point: PlaneVector) -> Expr:
        """Return the rate of the angle of a body at one of its points, which turns with its section where it bends."""
        return sum_of([self.spin(body), *section_turns(point, self.rate)])

    # ------------------------------------------------------------------------------------------ motion

    def to_fixed_frame(self, group: int, vector: PlaneVector) -> PlaneVector:
        """Return a vector fixed in a group, in the fixed frame."""
        return vector.rotated(self.cosine[group], self.sine[group]) if group else vector

    def position(self, path: Path) -> PlaneVector:
        """Return the position at the end of a path."""
        shifts = [signed(sign, self.shift[body]) for body, sign in path.floating_signs.items()]
        return vector_sum([*shifts, *(self.to_fixed_frame(g, arm) for g, arm in path.arms.items())])

    def axis(self, j: int) -> PlaneVector:
        """Return the direction of a guide in the fixed frame."""
        return self.to_fixed_frame(self.spanning_tree.group[self.machine.sites[j].link.proximal], self.joints[j].axis)

    def columns(self, path: Path) -> Columns:
        """Return the derivatives of the position at the end of a path."""
        columns = {Coordinate(ANGLE, g): self.to_fixed_frame(g, arm).left() for g, arm in path.arms.items() if g != 0}
        for j, sign in path.travel_signs.items():
            columns[Coordinate(TRAVEL, j)] = signed(sign, self.axis(j))
        for body, sign in path.floating_signs.items():
            columns[Coordinate(SHIFT_X, body)] = signed(sign, PlaneVector(ONE, ZERO))
            columns[Coordinate(SHIFT_Y, body)] = signed(sign, PlaneVector(ZERO, ONE))
        for point, sign in path.bent_signs.items():
            for coordinate, slope in point.slopes:
                column = signed(sign, self.to_fixed_frame(point.group, slope))
                columns[coordinate] = columns.get(coordinate, NO_VECTOR) + column
        return {coordinate: vector for coordinate, vector in columns.items() if vector != NO_VECTOR}

    def velocity(self, path: Path) -> PlaneVector:
        """Return the velocity at the end of a path."""
        return combination(self.columns(path), self.rate)

    def bias(self, path: Path) -> PlaneVector:
        """Return the acceleration at the end of a path from rates only."""
        terms = []
        for g, arm in path.arms.items():
            if g != 0 and arm != NO_VECTOR:
                rate = self.rate[Coordinate(ANGLE, g)]
                terms.append(-((rate * rate).assigned() * self.to_fixed_frame(g, arm)))
        for j, sign in path.travel_signs.items():
            g = self.spanning_tree.group[self.machine.sites[j].link.proximal]
            if g != 0:
                coriolis = (2.0 * self.rate[Coordinate(ANGLE, g)] * self.rate[Coordinate(TRAVEL, j)]).assigned()
                terms.append(signed(sign, coriolis * self.axis(j).left()))
        for point, sign in path.bent_signs.items():
            rates = [self.rate[coordinate] * slope for coordinate, slope in point.slopes if coordinate in self.rate]
            twice_spin = (2.0 * self.rate[Coordinate(ANGLE, point.group)]).assigned()
            parts = [twice_spin * vector_sum(rates).left()]
            for first, second, curvature in point.curvatures:
                product = self.rate[first] * self.rate[second]
                parts.append((product if first == second else 2.0 * product).assigned() * curvature)
            terms.append(signed(sign, self.to_fixed_frame(point.group, vector_sum(parts))))
        return vector_sum(terms)

    def acceleration(self, path: Path, accelerations: Mapping[Coordinate, Expr]) -> PlaneVector:
        """Return the acceleration at the end of a path; coordinates without an entry do not accelerate."""
        return self.bias(path) + combination(self.columns(path), accelerations)


class Bodies(Kinematics):
    """Positions of all bodies in a program whose second parameter is their Pose."""

    def __init__(self, machine: MachineType, parameters: int = 2):
        super().__init__(machine, parameters)
        self.pose = self.program.parameters[1]
        self.take_pose(self.pose)

    def inertia_of(self, body: int) -> tuple[Expr, Expr]:
        """Return mass and moment of inertia of a body."""
        properties = self.mechanism.bodies[body - 1]
        return properties.mass, properties.inertia

    def angle(self, group: int) -> Expr:
        """Return the angle of a group."""
        return self.turned[group] if group else ZERO

    def angle_at(self, body: int, point: PlaneVector) -> Expr:
        """Return the angle of a body at one of its points, which turns with its section where it bends."""
        return sum_of([self.angle(self.spanning_tree.group[body]), *section_turns(point, self.bend)])

    @functools.cached_property
    def lines(self) -> dict[int, BentLine]:
        """Return the lines of the bodies that bend."""
        lines: dict[int, BentLine] = {}
        for body, kind in self.machine.bent.items():
            properties = self.mechanism.bodies[body - 1]
            axis = self.to_fixed_frame(self.spanning_tree.group[body], vector_of(kind.axis, properties.axis))
            lines[body] = BentLine(kind, properties, axis, self.bend, self.rate)
        return lines

    def applied_loads(self) -> list[Load]:
        """Return every external load except gravity."""
        return [load for i in range(len(self.machine.loads)) for load in self.loads_of(i)]

    def loads_of(self, i: int) -> list[Load]:
        """Return load number `i` of the grid: what a spring exerts at both ends, or none of friction."""
        load = self.machine.loads[i]
        if load is None:
            return []
        if load.form is TorsionSpring:
            return self._torsion_spring(i, load)
        return self._spring(i, load) if load.form is Spring else [self._push(i, load)]

    def _push(self, i: int, load: LoadKind) -> Load:
        """Return load `i`: a force and a torque on one body, constant or from a table."""
        values = self.mechanism.loads[i]
        ((body, point, _),) = load.points
        if load.form is OwnPush:
            path = self.path_to(body, self.point_of(body, point, values.at.point))
            motion = tuple(self.position(path)), tuple(self.velocity(path))
            row = self.program.call(
                applied_load, values.law, self.pose.time, self.angle(self.spanning_tree.crank), *motion
            )
            return Load(body, self.point_of(body, point, values.at.point), PlaneVector(row[0], row[1]), row[2])
        if load.form is Push:
            force, torque = PlaneVector(values.fx, values.fy), values.torque
        else:
            argument = self.angle(self.spanning_tree.crank) if load.form is AngleTableLoad else self.pose.time
            row = self.program.call(table_values, values.table, argument)
            force, torque = PlaneVector(row[0], row[1]), row[2]
        return Load(body, self.point_of(body, point, values.at.point), force, torque)

    def _torsion_spring(self, i: int, load: LoadKind) -> list[Load]:
        """Return the torques of the load number `i`, a torsion spring and damper, on both bodies."""
        spring, ((first, _, _), (second, _, _)) = self.mechanism.loads[i], load.points
        twist = self.angle_of(second) - self.angle_of(first) - spring.free_angle
        rate = self.spin(second) - self.spin(first)
        torque = (spring.stiffness * twist + spring.damping * rate).assigned()
        return [Load(first, CENTRE, NO_VECTOR, torque), Load(second, CENTRE, NO_VECTOR, -torque)]

    def mount_motions(self) -> list[Expr]:
        """Return the displacements (m) of all housings, along x and y."""
        housings = self.machine.housings
        return [self.travel[j] for j in self.machine.sprung if self.machine.sites[j].link.distal in housings]

    def angle_of(self, body: int) -> Expr:
        """Return the angle of a body."""
        return self.angle(self.spanning_tree.group[body])

    def tension(self, j: int) -> Expr:
        """Return the force (N) with which the spring number `j` of an elastic link pulls its ends together."""
        spring = self.mechanism.joints[j]
        return spring.stiffness * self.travel[j] + spring.damping * self.rate[Coordinate(TRAVEL, j)]

    def _spring(self, i: int, load: LoadKind) -> list[Load]:
        """Return the forces of the load number `i`, a spring and damper, at both ends."""
        spring = self.mechanism.loads[i]
        (first_body, first_point), (second_body, second_point) = (
            (body, self.point_of(body, point, getattr(spring, field).point)) for body, point, field in load.points
        )
        path = self.between(self.path_to(first_body, first_point), self.path_to(second_body, second_point))
        distance, velocity = self.position(path), self.velocity(path)
        length = self.program.call(_spring_length, distance.dot(distance), spring.free_length)
        unit = (1.0 / length) * distance
        rate = unit.assigned().dot(velocity)
        extension = length - spring.free_length
        force = ((spring.stiffness * extension + spring.damping * rate) * unit).assigned()
        return [Load(first_body, first_point, force, ZERO), Load(second_body, second_point, -force, ZERO)]


class PoseProgram(Kinematics):
    """The program of a pose, from values of the coordinates."""

    def __init__(self, machine: MachineType, parameters: int):
        super().__init__(machine, parameters)
        self.values: dict[Coordinate, Expr] = {}
        known = [Coordinate(ANGLE, g) for g in machine.groups]
        known += [coordinate for coordinate in machine.spanning_tree.coordinates if coordinate.kind == TRAVEL]
        known += [Coordinate(kind, body) for body in machine.spanning_tree.roots() for kind in (SHIFT_X, SHIFT_Y)]
        known += [coordinate for coordinate in machine.spanning_tree.coordinates if coordinate.kind == BEND]
        self.known = [coordinate for coordinate in known if coordinate not in machine.dependent]

    def take(self, coordinate: Coordinate, value: Expr) -> None:
        """Take the value of a coordinate."""
        self.values[coordinate] = value
        if coordinate.kind == ANGLE:
            self.turned[coordinate.owner] = value
            direction = self.program.call(math.direction, value)
            self.cosine[coordinate.owner], self.sine[coordinate.owner] = direction[0], direction[1]

    def take_dependent(self, dependent: Expr) -> None:
        """Take the values of the dependent coordinates from a tuple."""
        for i, coordinate in enumerate(self.machine.dependent):
            self.take(coordinate, dependent[i])

    def place(self) -> None:
        """Take the positions of all bodies from the values of the coordinates."""
        self.travel = {
            coordinate.owner: value for coordinate, value in self.values.items() if coordinate.kind == TRAVEL
        }
        for body in self.spanning_tree.roots():
            self.shift[body] = PlaneVector(*(self.values[Coordinate(kind, body)] for kind in (SHIFT_X, SHIFT_Y)))
        self.bend = {coordinate: value for coordinate, value in self.values.items() if coordinate.kind == BEND}

    def known_values(self) -> tuple[Expr, ...]:
        """Return the numbers with which the loops are closed: directions, then other coordinates."""
        angles = [coordinate.owner for coordinate in self.known if coordinate.kind == ANGLE]
        directions = [component for g in angles for component in (self.cosine[g], self.sine[g])]
        others = (coordinate for coordinate in self.known if coordinate.kind != ANGLE or self.closes_gears)
        return (*directions, *(self.values[coordinate] for coordinate in others))

    @property
    def closes_gears(self) -> bool:
        """Return whether a loop contains angles themselves, not only their directions."""
        return any(self.machine.sites[j].link.geared for j in self.spanning_tree.loop_joints)


@inlined
def _spring_length(square, free_length):
    """Return the length (m) of a spring from its square.

    Where its ends coincide its direction is unknown; a spring without free length then has no force.
    """
    return math.sqrt(where((square > 0.0) | (free_length > 0.0), square, 1.0))


def signed(sign: int, vector: PlaneVector) -> PlaneVector:
    """Return a vector times a sign."""
    return vector if sign > 0 else -vector


def combination(columns: Columns, rates: Mapping[Coordinate, Expr]) -> PlaneVector:
    """Return the sum of columns times rates; a missing rate is zero."""
    return vector_sum([rates[coordinate] * column for coordinate, column in columns.items() if coordinate in rates])


def section_turns(point: PlaneVector, rates: Mapping[Coordinate, Expr]) -> list[Expr]:
    """Return the terms of the angle of a point's section, or of its rates, that bending adds to those of its body."""
    turns = point.turns if isinstance(point, BentVector) else ()
    return [turn * rates[coordinate] for coordinate, turn in turns if coordinate in rates]


def _difference(signs: dict, removed: dict) -> dict:
    """Return the difference of two signed collections."""
    return {coordinate: sign for coordinate, sign in signs.items() if coordinate not in removed} | {
        coordinate: -sign for coordinate, sign in removed.items() if coordinate not in signs
    }
