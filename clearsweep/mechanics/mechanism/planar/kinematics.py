"""Generates the code for positions, velocities and accelerations of a planar machine's bodies.

A point is reached from the ground through arms, each fixed in a body, and displacements along guides:

    r = sum over angle groups g of R_g p_g + position of a floating body,    p_g constant except along guides

so its derivative by the angle of g is R_g p_g turned by 90 degrees, and its acceleration without any of the coordinates
is -omega_g^2 R_g p_g + 2 omega_g x (velocity of the runs).
"""

from typing import NamedTuple

from .loads import ByAngle, Pushing, Springing
from .machine_type import LoadKind, MachineType, Vector
from .spanning_tree import ANGLE, RUN, SHIFT_X, SHIFT_Y, Coordinate
from .writer import Lines

Columns = dict[Coordinate, Vector]  # derivatives of a place by coordinates


class Path(NamedTuple):
    """The path to a point: the arms, guides and floating body on it, with signs for directions."""

    arms: dict[int, Vector]  # of each group
    runs: dict[int, str]  # guide -> sign
    roots: dict[int, str]  # floating body -> sign


class Kinematics:
    """Positions and their derivatives in the lines of a function; subclasses define the source of angles and rates."""

    def __init__(self, machine: MachineType, lines: Lines):
        self.machine, self.lines, self.spanning_tree = machine, lines, machine.spanning_tree
        self.cosine: dict[int, str] = {}
        self.sine: dict[int, str] = {}
        self.rate: dict[Coordinate, str | None] = {}  # of every coordinate, the driven crank's angle among them
        self.run: dict[int, str] = {}
        self.shift: dict[int, Vector] = {}

    def from_pose(self) -> None:
        """Take angles, rates and positions from the Pose `pose`."""
        for i, g in enumerate(self.machine.groups):
            self.cosine[g], self.sine[g] = (self.lines.let(f"pose.turns[{i}].{k}") for k in ("c", "s"))
            self.rate[Coordinate(ANGLE, g)] = self.lines.let(f"pose.turns[{i}].rate")
        runs = [item.of for item in self.spanning_tree.coordinates if item.kind == RUN]
        for i, j in enumerate(runs):
            self.run[j] = self.lines.let(f"pose.runs[{i}][0]")
            self.rate[Coordinate(RUN, j)] = self.lines.let(f"pose.runs[{i}][1]")
        for i, body in enumerate(self.spanning_tree.roots()):
            self.shift[body] = tuple(self.lines.let(f"pose.roots[{i}][{k}]") for k in range(2))
            for k, kind in enumerate((SHIFT_X, SHIFT_Y)):
                self.rate[Coordinate(kind, body)] = self.lines.let(f"pose.roots[{i}][{2 + k}]")

    # ------------------------------------------------------------------------------------------ vectors

    def sum(self, *vectors: Vector) -> Vector:
        """Return the sum of vectors."""
        return tuple(self.lines.total(*parts) for parts in zip(*vectors, strict=True))

    def scaled(self, factor: str | None, vector: Vector) -> Vector:
        """Return a vector times a number."""
        return tuple(self.lines.product(factor, component) for component in vector)

    def minus(self, vector: Vector) -> Vector:
        """Return the negative of a vector."""
        return tuple(self.lines.minus(component) for component in vector)

    def signed(self, sign: str, vector: Vector) -> Vector:
        """Return a vector, or its negative."""
        return vector if sign == "+" else self.minus(vector)

    def turned(self, group: int, vector: Vector) -> Vector:
        """Return a vector fixed in a group, in the fixed frame."""
        if group == 0:
            return vector
        lines, c, s = self.lines, self.cosine[group], self.sine[group]
        x, y = vector
        return (
            lines.total(lines.product(c, x), lines.minus(lines.product(s, y))),
            lines.total(lines.product(s, x), lines.product(c, y)),
        )

    def left(self, vector: Vector) -> Vector:
        """Return a vector rotated by 90 degrees, counter-clockwise."""
        return self.lines.minus(vector[1]), vector[0]

    # ------------------------------------------------------------------------------------------ paths

    def path_to(self, body: int, point: Vector = (None, None)) -> Path:
        """Return the path to a point of a body, or to its centre of mass."""
        arms: dict[int, Vector] = {}
        runs: dict[int, str] = {}
        roots: dict[int, str] = {}
        group = self.spanning_tree.group[body]
        if body != 0 and self.spanning_tree.parents[body] is None:
            roots[body] = "+"
        elif body != 0:
            parent, j = self.spanning_tree.parents[body]
            site = self.machine.sites[j]
            forward = site.link.proximal == parent
            outer_end, inner_end = (site.far, site.near) if forward else (site.near, site.far)
            path_to_parent = self.path_to(parent, inner_end)
            arms, runs, roots = dict(path_to_parent.arms), dict(path_to_parent.runs), dict(path_to_parent.roots)
            arms[group] = self.sum(arms.get(group, (None, None)), self.minus(outer_end))
            if site.link.slides:
                runs[j] = "+" if forward else "-"
                unit = self.scaled(self.run[j], site.axis)
                arms[group] = self.sum(arms[group], self.signed(runs[j], unit))
        arms[group] = self.sum(arms.get(group, (None, None)), point)
        return Path(arms, runs, roots)

    def between(self, first: Path, second: Path) -> Path:
        """Return the path from one point to another."""
        arms = dict(second.arms)
        for g, arm in first.arms.items():
            other_arm = arms.get(g, (None, None))
            arms[g] = (None, None) if arm == other_arm else self.sum(other_arm, self.minus(arm))
        return Path(arms, _less(second.runs, first.runs), _less(second.roots, first.roots))

    def site(self, j: int) -> tuple[Path, Path]:
        """Return the paths to both points of a joint."""
        site = self.machine.sites[j]
        return self.path_to(site.link.proximal, site.near), self.path_to(site.link.distal, site.far)

    def direction(self, body: int) -> Vector:
        """Return cosine and sine of a body's angle."""
        group = self.spanning_tree.group[body]
        return (self.cosine[group], self.sine[group]) if group else ("1.0", None)

    def spin(self, body: int) -> str | None:
        """Return the rate of a body's angle."""
        return self.rate.get(Coordinate(ANGLE, self.spanning_tree.group[body]))

    # ------------------------------------------------------------------------------------------ motion

    def place(self, path: Path) -> Vector:
        """Return the position at the end of a path."""
        shifts = (self.signed(sign, self.shift[body]) for body, sign in path.roots.items())
        return self.sum((None, None), *shifts, *(self.turned(g, arm) for g, arm in path.arms.items()))

    def axis(self, j: int) -> Vector:
        """Return the direction of a guide in the fixed frame."""
        site = self.machine.sites[j]
        return self.turned(self.spanning_tree.group[site.link.proximal], site.axis)

    def columns(self, path: Path) -> Columns:
        """Return the derivatives of the position at the end of a path."""
        columns = {Coordinate(ANGLE, g): self.left(self.turned(g, arm)) for g, arm in path.arms.items() if g != 0}
        for j, sign in path.runs.items():
            columns[Coordinate(RUN, j)] = self.signed(sign, self.axis(j))
        for body, sign in path.roots.items():
            columns[Coordinate(SHIFT_X, body)] = self.signed(sign, ("1.0", None))
            columns[Coordinate(SHIFT_Y, body)] = self.signed(sign, (None, "1.0"))
        return {item: vector for item, vector in columns.items() if vector != (None, None)}

    def combination(self, columns: Columns, rates: dict) -> Vector:
        """Return the sum of columns times rates."""
        return self.sum((None, None), *(self.scaled(rates[item], column) for item, column in columns.items()))

    def bias(self, path: Path) -> Vector:
        """Return the acceleration at the end of a path from rates only."""
        terms = []
        for g, arm in path.arms.items():
            if g != 0 and arm != (None, None):
                rate = self.rate[Coordinate(ANGLE, g)]
                square = self.lines.product(rate, rate)
                terms.append(self.minus(self.scaled(square, self.turned(g, arm))))
        for j, sign in path.runs.items():
            g = self.spanning_tree.group[self.machine.sites[j].link.proximal]
            if g != 0:
                swept = self.lines.product("2.0", self.rate[Coordinate(ANGLE, g)], self.rate[Coordinate(RUN, j)])
                transverse = self.scaled(swept, self.left(self.axis(j)))
                terms.append(self.signed(sign, transverse))
        return self.sum((None, None), *terms)


class Bodies(Kinematics):
    """Positions of all bodies in a generated function of their pose."""

    def __init__(self, machine: MachineType, *arguments: str):
        super().__init__(machine, Lines(*arguments))
        self.from_pose()

    def applied(self) -> list[tuple[int, Vector, Vector, str | None]]:
        """Return body, point, force and torque of every external load except gravity."""
        lines, terms = self.lines, []
        for i, load in enumerate(self.machine.loads):
            path = f"mechanism.loads[{i}]"
            if load is None:
                continue
            if load.form is Springing:
                terms += self._springing(path, load)
                continue
            if load.form is Pushing:
                parts = tuple(lines.let(f"{path}.{component}") for component in ("fx", "fy", "torque"))
            else:
                crank = f"pose.turns[{self.machine.groups.index(self.spanning_tree.crank)}].angle"
                argument = crank if load.form is ByAngle else "pose.time"
                parts = tuple(f"{component}_{i}" for component in ("fx", "fy", "torque"))
                lines.once(f"{', '.join(parts)} = by_table({path}.table, {argument})")
            ((body, point),) = load.ends
            terms.append((body, point, parts[:2], parts[2]))
        return terms

    def tension(self, j: int) -> str:
        """Return the force (N) with which the spring number `j` of an elastic link pulls its ends together."""
        lines, path = self.lines, f"mechanism.joints[{j}].site"
        stretched = lines.product(f"{path}.stiffness", self.run[j])
        return lines.let(lines.total(stretched, lines.product(f"{path}.damping", self.rate[Coordinate(RUN, j)])))

    def _springing(self, path: str, load: LoadKind) -> list[tuple[int, Vector, Vector, None]]:
        """Return the forces of a spring and damper at both ends."""
        lines = self.lines
        (first, near_end), (second, far_end) = load.ends
        between = self.between(self.path_to(first, near_end), self.path_to(second, far_end))
        distance, velocity = self.place(between), self.combination(self.columns(between), self.rate)
        length = lines.let(f"math.sqrt({lines.total(*lines.dot(distance, distance))})")
        unit = self.scaled(lines.let(f"1.0 / {length}"), distance)
        rate = lines.total(*lines.dot(tuple(map(lines.let, unit)), velocity))
        longer = lines.total(length, lines.minus(lines.let(f"{path}.free_length")))
        tension = lines.total(lines.product(f"{path}.stiffness", longer), lines.product(f"{path}.damping", rate))
        force = tuple(lines.let(component) for component in self.scaled(tension, unit))
        return [(first, near_end, force, None), (second, far_end, self.minus(force), None)]


def _less(signs: dict, removed: dict) -> dict:
    """Return the difference of two signed collections."""
    opposite = {"+": "-", "-": "+"}
    return {item: sign for item, sign in signs.items() if item not in removed} | {
        item: opposite[sign] for item, sign in removed.items() if item not in signs
    }
