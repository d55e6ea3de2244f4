"""Generates the code for positions, velocities and accelerations of a planar machine's bodies.

A point is reached from the ground through arms, each fixed in a body, and displacements along guides:

    r = sum over angle groups g of R_g p_g + position of a floating body,    p_g constant except along guides

so its derivative by the angle of g is R_g p_g turned by 90 degrees, and its acceleration without any of the coordinates
is -omega_g^2 R_g p_g + 2 omega_g x (velocity of the runs).
"""

from collections.abc import Mapping
from typing import NamedTuple

from .expressions import NO_VECTOR, ONE, ZERO, Expr, FunctionCode, PlaneVector, vector_sum
from .loads import AngleTableLoad, PushLoad, SpringLoad
from .machine_type import LoadKind, MachineType
from .spanning_tree import ANGLE, SHIFT_X, SHIFT_Y, TRAVEL, Coordinate

Row = dict[Coordinate, Expr]
Columns = dict[Coordinate, PlaneVector]  # derivatives of a position by coordinates
CENTRE = NO_VECTOR  # centre of mass of a body, from which its points are given


class Path(NamedTuple):
    """The path to a point: the arms, guides and floating body on it, with signs (1 or -1) for directions."""

    arms: dict[int, PlaneVector]  # of each group
    travel_signs: dict[int, int]  # guide -> sign
    floating_signs: dict[int, int]  # floating body -> sign


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
    """Positions and their derivatives in the code of a function; subclasses define the source of angles and rates."""

    def __init__(self, machine: MachineType, code: FunctionCode):
        self.machine, self.code, self.spanning_tree = machine, code, machine.spanning_tree
        self.joints = [JointVectors(*map(code.vector, (site.near, site.far, site.axis))) for site in machine.sites]
        self.cosine: dict[int, Expr] = {}
        self.sine: dict[int, Expr] = {}
        self.rate: dict[Coordinate, Expr] = {}  # of every coordinate, the driven crank's angle among them
        self.travel: dict[int, Expr] = {}
        self.shift: dict[int, PlaneVector] = {}

    def from_pose(self) -> None:
        """Take angles, rates and positions from the Pose `pose`."""
        assign = self.code.assign
        for i, g in enumerate(self.machine.groups):
            self.cosine[g], self.sine[g] = (assign(f"pose.orientations[{i}].{k}") for k in ("c", "s"))
            self.rate[Coordinate(ANGLE, g)] = assign(f"pose.orientations[{i}].rate")
        runs = [coordinate.owner for coordinate in self.spanning_tree.coordinates if coordinate.kind == TRAVEL]
        for i, j in enumerate(runs):
            self.travel[j] = assign(f"pose.travels[{i}][0]")
            self.rate[Coordinate(TRAVEL, j)] = assign(f"pose.travels[{i}][1]")
        for i, body in enumerate(self.spanning_tree.roots()):
            self.shift[body] = PlaneVector(*(assign(f"pose.roots[{i}][{k}]") for k in range(2)))
            for k, kind in enumerate((SHIFT_X, SHIFT_Y)):
                self.rate[Coordinate(kind, body)] = assign(f"pose.roots[{i}][{2 + k}]")

    def predicted_rates(self, crank_angle: str) -> tuple[Row, Row]:
        """Return the first two derivatives of the dependent coordinates of the ideal machine by the crank's angle.

        Empty unless the loops pass change points: near these, rates follow the ideal machine.
        """
        dependent = self.machine.dependent if self.machine.branches else ()
        angle = self.code.call("plain", crank_angle) if dependent else ZERO
        column = 1 + len(dependent)
        derivatives = [
            [self.code.assign(f"evaluate_cycle(mechanism.cycle, {i}, {angle})[{order}]") for order in (0, 1)]
            for i in range(column, column + len(dependent))
        ]
        first, second = zip(*derivatives, strict=True) if derivatives else ((), ())
        return dict(zip(dependent, first, strict=True)), dict(zip(dependent, second, strict=True))

    # ------------------------------------------------------------------------------------------ paths

    def path_to(self, body: int, point: PlaneVector = CENTRE) -> Path:
        """Return the path to a point of a body."""
        arms: dict[int, PlaneVector] = {}
        travel_signs: dict[int, int] = {}
        floating_signs: dict[int, int] = {}
        group = self.spanning_tree.group[body]
        if body != 0 and self.spanning_tree.parents[body] is None:
            floating_signs[body] = 1
        elif body != 0:
            parent, j = self.spanning_tree.parents[body]
            link, joint = self.machine.sites[j].link, self.joints[j]
            forward = link.proximal == parent
            outer_end, inner_end = (joint.far, joint.near) if forward else (joint.near, joint.far)
            path_to_parent = self.path_to(parent, inner_end)
            arms, travel_signs, floating_signs = (
                dict(path_to_parent.arms),
                dict(path_to_parent.travel_signs),
                dict(path_to_parent.floating_signs),
            )
            arms[group] = arms.get(group, NO_VECTOR) - outer_end
            if link.slides:
                travel_signs[j] = 1 if forward else -1
                arms[group] += signed(travel_signs[j], self.travel[j] * joint.axis)
        arms[group] = arms.get(group, NO_VECTOR) + point
        return Path(arms, travel_signs, floating_signs)

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
        )

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
            columns[Coordinate(SHIFT_X, body)] = signed(sign, self.code.vector(("1.0", None)))
            columns[Coordinate(SHIFT_Y, body)] = signed(sign, self.code.vector((None, "1.0")))
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
                square = self.code.assign(rate * rate)
                terms.append(-(square * self.to_fixed_frame(g, arm)))
        for j, sign in path.travel_signs.items():
            g = self.spanning_tree.group[self.machine.sites[j].link.proximal]
            if g != 0:
                coriolis = self.code.assign(2.0 * self.rate[Coordinate(ANGLE, g)] * self.rate[Coordinate(TRAVEL, j)])
                terms.append(signed(sign, coriolis * self.axis(j).left()))
        return vector_sum(terms)

    def acceleration(self, path: Path, accelerations: Mapping[Coordinate, Expr]) -> PlaneVector:
        """Return the acceleration at the end of a path; coordinates without an entry do not accelerate."""
        return self.bias(path) + combination(self.columns(path), accelerations)


class Bodies(Kinematics):
    """Positions of all bodies in a generated function of their pose."""

    def __init__(self, machine: MachineType, *arguments: str):
        super().__init__(machine, FunctionCode(*arguments))
        self.from_pose()

    def inertia_of(self, body: int) -> tuple[Expr, Expr]:
        """Return mass and moment of inertia of a body."""
        mass, inertia = (self.code.assign(f"mechanism.bodies[{body - 1}].{key}") for key in ("mass", "inertia"))
        return mass, inertia

    def applied_loads(self) -> list[Load]:
        """Return every external load except gravity."""
        loads: list[Load] = []
        for i, load in enumerate(self.machine.loads):
            if load is not None:
                loads += self._spring(i, load) if load.form is SpringLoad else [self._push(i, load)]
        return loads

    def _push(self, i: int, load: LoadKind) -> Load:
        """Return load `i`: a force and a torque on one body, constant or from a table."""
        path = f"mechanism.loads[{i}]"
        if load.form is PushLoad:
            fx, fy, torque = (self.code.assign(f"{path}.{component}") for component in ("fx", "fy", "torque"))
        else:
            crank = f"pose.orientations[{self.machine.groups.index(self.spanning_tree.crank)}].angle"
            argument = crank if load.form is AngleTableLoad else "pose.time"
            variables = [f"{component}_{i}" for component in ("fx", "fy", "torque")]
            line = f"{', '.join(variables)} = table_values({path}.table, {argument})"
            if line not in self.code.lines:
                self.code.write(line)
            fx, fy, torque = map(self.code.expression, variables)
        ((body, point),) = load.points
        return Load(body, self.code.vector(point), PlaneVector(fx, fy), torque)

    def tension(self, j: int) -> Expr:
        """Return the force (N) with which the spring number `j` of an elastic link pulls its ends together."""
        stiffness, damping = (
            self.code.expression(f"mechanism.joints[{j}].site.{name}") for name in ("stiffness", "damping")
        )
        return stiffness * self.travel[j] + damping * self.rate[Coordinate(TRAVEL, j)]

    def _spring(self, i: int, load: LoadKind) -> list[Load]:
        """Return the forces of the load number `i`, a spring and damper, at both ends.

        Where its ends coincide its direction is unknown; a spring without free length then has no force.
        """
        path_code = f"mechanism.loads[{i}]"
        stiffness, damping = (self.code.expression(f"{path_code}.{name}") for name in ("stiffness", "damping"))
        (first_body, first_point), (second_body, second_point) = (
            (body, self.code.vector(point)) for body, point in load.points
        )
        path = self.between(self.path_to(first_body, first_point), self.path_to(second_body, second_point))
        distance, velocity = self.position(path), self.velocity(path)
        square, free_length = distance.dot(distance).assigned(), self.code.assign(f"{path_code}.free_length")
        known_square = f"where(({square} > 0.0) | ({free_length} > 0.0), {square}, 1.0)"
        length = self.code.call("math.sqrt", known_square)
        unit = (1.0 / length) * distance
        rate = unit.assigned().dot(velocity)
        extension = length - free_length
        force = ((stiffness * extension + damping * rate) * unit).assigned()
        return [Load(first_body, first_point, force, ZERO), Load(second_body, second_point, -force, ZERO)]


def signed(sign: int, vector: PlaneVector) -> PlaneVector:
    """Return a vector times a sign."""
    return vector if sign > 0 else -vector


def combination(columns: Columns, rates: Mapping[Coordinate, Expr]) -> PlaneVector:
    """Return the sum of columns times rates; a missing rate is zero."""
    return vector_sum([rates[coordinate] * column for coordinate, column in columns.items() if coordinate in rates])


def _difference(signs: dict, removed: dict) -> dict:
    """Return the difference of two signed collections."""
    return {coordinate: sign for coordinate, sign in signs.items() if coordinate not in removed} | {
        coordinate: -sign for coordinate, sign in removed.items() if coordinate not in signs
    }
