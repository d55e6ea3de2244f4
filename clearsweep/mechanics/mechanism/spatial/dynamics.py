"""Generates the code for the accelerations of a tree.

Newton's and Euler's equations of all bodies, multiplied by the derivatives of their velocities by the speeds of the
tree (Kane & Levinson 1985, "Dynamics: Theory and Applications", chapter 6): a symmetric mass matrix, solved by LDL
factors.  The speeds are the rates of the coordinates; for a quaternion they are the body's angular velocity in its
own frame, as is its inertia.
"""

from typing import Any

from ..planar.writer import number, tupled
from .form import AngleAim, Ball, Driven, Hinge, Loose, Sleeve, Slide
from .machine_type import SPEEDS, MachineType
from .writer import AXES, UP, ZERO, Posed


class Unit:
    """An axis of a body's own frame, as an angular velocity."""

    def __init__(self, axis: int):
        self.axis = axis


class Dynamics(Posed):
    """The equations of motion; the last speed is that of the crank, which the drive prescribes."""

    def __init__(self, tree: MachineType):
        super().__init__(tree, "mechanism", "pose", "loads")
        self.known = tree.speeds  # the crank's speed
        self.angular: list[dict[int, Any]] = [{}]  # for each body: speed -> angular velocity in its own frame
        self.spinning: list[dict[int, str]] = [{}]  # the same in the fixed frame
        self.moving: list[dict[int, str]] = [{}]  # velocity of its centre of mass
        self.alpha: list[str | None] = [None]  # acceleration without those of the speeds
        self.bias: list[str | None] = [None]
        for body in range(1, len(tree.parts) + 1):
            self._hang(body)
        self.force: list[list] = [[] for _ in range(len(tree.parts) + 1)]
        self.moment: list[list] = [[] for _ in range(len(tree.parts) + 1)]
        self._load()

    def _hang(self, body: int) -> None:
        """Derive the motion of a body from the speeds."""
        part = self.tree.part(body)
        p, first = part.parent, part.speed
        if part.form is Loose:
            axes = {first + i: self.let(f"axis_{AXES[i]}({self.frame(body)})") for i in range(3)}
            self.spinning.append(axes)
            self.angular.append({first + i: Unit(i) for i in range(3)})
            fixed = {
                first + 3 + i: f"Vector({', '.join('1.0' if i == k else '0.0' for k in range(3))})" for i in range(3)
            }
            self.moving.append(fixed)
            self.alpha.append(None)
            self.bias.append(None)
            return
        own_values, near_end = self.own(body), self.near(body)
        shift = self.shift(body, f"pose.q[{part.coordinate}]")
        arm_to_body = self.all_of(near_end, shift)
        moving = dict(self.moving[p])
        spinning: dict[int, str] = {}
        for u, spin in self.spinning[p].items():
            moving[u] = self.all_of(moving.get(u), self.cross(spin, arm_to_body))
        if not part.turns_freely:
            spinning = dict(self.spinning[p])
        at_hinge = self._carried(p, arm_to_body)
        alpha = None if part.turns_freely else self.alpha[p]
        rising = self.shift(body, f"pose.rates[{part.coordinate}]")
        if rising is not None and p:
            at_hinge = self.all_of(at_hinge, self.let(f"times(2.0, {self.cross(self.spin(p), rising)})"))
        angular = self._own_speeds(body, moving, spinning)
        if part.form in (Hinge, Sleeve) and p and not self.tree.up(p):
            at = part.coordinate + (part.form is Sleeve)
            turned = self.let(f"times(pose.rates[{at}], {self.z_of(p)})")
            alpha = self.all_of(alpha, self.cross(self.spin(p), turned))
        for u, spin in spinning.items():
            moving[u] = self.all_of(moving.get(u), self.cross(spin, own_values))
        self.spinning.append(spinning)
        self.moving.append({u: v for u, v in moving.items() if v is not None})
        self.angular.append({u: angular.get(u) or self._in_own(body, u, spin) for u, spin in spinning.items()})
        self.alpha.append(alpha)
        spun = None if part.form is Slide and not p else self.spin(body)
        if spun is None:
            self.bias.append(at_hinge)
        else:
            self.bias.append(self.let(f"transported({at_hinge or ZERO}, {alpha or ZERO}, {spun}, {own_values})"))

    def _carried(self, body: int, arm: str | None) -> str | None:
        """Return the acceleration of a point of a body, without the accelerations of the speeds."""
        if not body or self.spin_free(body):
            return self.bias[body]
        return self.let(f"transported({self.bias[body] or ZERO}, {self.alpha[body] or ZERO}, {self.spin(body)}, {arm})")

    def spin_free(self, body: int) -> bool:
        """Return whether a body does not turn."""
        while body and self.tree.part(body).form is Slide:
            body = self.tree.part(body).parent
        return body == 0

    def _own_speeds(self, body: int, moving: dict, spinning: dict) -> dict:
        """Add a body's own speeds at its attachment; return angular velocities that are axes of its frame."""
        part, p = self.tree.part(body), self.tree.part(body).parent
        first, axes = part.speed, {}
        if part.form is Driven:
            spinning[self.known], axes[self.known] = UP, Unit(2)
        elif part.form is Slide:
            moving[first] = self.axis(body)
        elif part.form is Ball:
            for i in range(3):
                spinning[first + i] = self.let(f"axis_{AXES[i]}({self.frame(body)})")
                axes[first + i] = Unit(i)
        else:
            if part.form is Sleeve:
                moving[first] = self.z_of(p)
            turn = first + (part.form is Sleeve)
            spinning[turn], axes[turn] = self.z_of(p), Unit(2)
        if not part.turns_freely:  # it shares its z axis with its parent
            axes |= {
                u: observed
                for u, observed in self.angular[p].items()
                if isinstance(observed, Unit) and observed.axis == 2
            }
        return axes

    def _in_own(self, body: int, u: int, spin: str) -> str | None:
        return self.let(f"in_body({self.frame(body)}, {spin})")

    def _load(self) -> None:
        """Add gravity, known accelerations, and the loads of the joints with clearance."""
        for body in range(1, len(self.tree.parts) + 1):
            part = f"mechanism.parts[{body - 1}]"
            lifted = "mechanism.gravity" if self.bias[body] is None else f"minus(mechanism.gravity, {self.bias[body]})"
            self.force[body].append(self.let(f"times({part}.mass, {lifted})"))
            if self.spin_free(body):
                continue
            spin = self.let(f"in_body({self.frame(body)}, {self.spin(body)})")
            self.moment[body].append(self.let(f"cross(elementwise_product({part}.inertia, {spin}), {spin})"))
            if self.alpha[body] is not None:
                turned = self.let(
                    f"elementwise_product({part}.inertia, in_body({self.frame(body)}, {self.alpha[body]}))"
                )
                self.moment[body].append(self.let(f"times(-1.0, {turned})"))
        for j, (bearing, journal) in enumerate(self.tree.openings):
            site, frame = f"mechanism.openings[{j}]", self.frame(journal)
            force = self.let(f"in_fixed({frame}, loads[{j}].force)")
            reaction = self.let(f"times(-1.0, {force})")
            for body, at, push, couple in (
                (journal, "at_journal", force, "on_journal"),
                (bearing, "at_bearing", reaction, "on_bearing"),
            ):
                if not body:
                    continue
                self.force[body].append(push)
                moment = self.all_of(
                    self.let(f"in_fixed({frame}, loads[{j}].{couple})"),
                    self.cross(self.arm(body, f"{site}.{at}"), push),
                )
                self.moment[body].append(self.let(f"in_body({self.frame(body)}, {moment})"))

    def entry(self, a: int, b: int) -> str | None:
        """Return an entry of the mass matrix."""
        terms = []
        for body in range(1, len(self.tree.parts) + 1):
            part = f"mechanism.parts[{body - 1}]"
            moving, angular = self.moving[body], self.angular[body]
            if a in moving and b in moving:
                terms.append(f"{part}.mass * dot({moving[a]}, {moving[b]})")
            if a in angular and b in angular:
                terms.append(self._turned(angular[a], angular[b], f"{part}.inertia"))
        return self.lines.total(*terms)

    def _turned(self, a: Any, b: Any, inertia: str) -> str | None:
        if isinstance(a, Unit) and isinstance(b, Unit):
            return f"{inertia}.{AXES[a.axis]}" if a.axis == b.axis else None
        if isinstance(b, Unit):
            a, b = b, a
        if isinstance(a, Unit):
            return f"{inertia}.{AXES[a.axis]} * {b}.{AXES[a.axis]}"
        return f"dot({a}, elementwise_product({inertia}, {b}))"

    def right(self, a: int) -> str | None:
        """Return the generalised force of a speed."""
        terms = []
        for body in range(1, len(self.tree.parts) + 1):
            force, moment = self.all_of(*self.force[body]), self.all_of(*self.moment[body])
            if a in self.moving[body]:
                terms.append(f"dot({self.moving[body][a]}, {force})")
            if a in self.angular[body] and moment is not None:
                observed = self.angular[body][a]
                terms.append(
                    f"{moment}.{AXES[observed.axis]}" if isinstance(observed, Unit) else f"dot({observed}, {moment})"
                )
        return self.lines.total(*terms)

    def solved(self) -> list[str | None]:
        """Return the accelerations of the speeds, by the LDL factors of the mass matrix."""
        lines, count = self.lines, self.tree.speeds
        lower: dict[tuple[int, int], str | None] = {}
        scaled: dict[tuple[int, int], str | None] = {}
        inverse: list[str | None] = []
        left_side: list[str | None] = []
        for j in range(count):
            eliminated = [lines.minus(lines.product(scaled[j, k], lower[j, k])) for k in range(j)]
            inverse.append(lines.let(f"1.0 / {number(lines.total(self.entry(j, j), *eliminated))}"))
            for a in range(j + 1, count):
                eliminated = [lines.minus(lines.product(scaled[a, k], lower[j, k])) for k in range(j)]
                scaled[a, j] = lines.total(self.entry(a, j), *eliminated)
                lower[a, j] = lines.let(lines.product(scaled[a, j], inverse[j]))
        for a in range(count):
            eliminated = [lines.minus(lines.product(lower[a, k], left_side[k])) for k in range(a)]
            left_side.append(lines.total(self.right(a), *eliminated))
        accelerations: list[str | None] = [None] * count
        for a in range(count - 1, -1, -1):
            eliminated = [lines.minus(lines.product(lower[k, a], accelerations[k])) for k in range(a + 1, count)]
            accelerations[a] = lines.total(lines.product(left_side[a], inverse[a]), *eliminated)
        return accelerations

    def coordinates(self, accelerations: list[str | None]) -> list[str]:
        """Return the accelerations of the coordinates."""
        values = []
        for i, part in enumerate(self.tree.parts):
            own_values = [number(accelerations[part.speed + k]) for k in range(SPEEDS[part.form])]
            if part.turns_freely:
                body, alpha = i + 1, f"Vector({', '.join(own_values[:3])})"
                spin = self.let(f"in_body({self.frame(body)}, {self.spin(body)})")
                turned = f"accelerated(pose.turnings[{i}], {spin}, {alpha}, mechanism.speed)"
                values += [f"{self.let(turned)}[{k}]" for k in range(4)]
                own_values = own_values[3:]
            values += own_values
        return values

    def output(self, accelerations: list[str | None]) -> str | None:
        """Return the acceleration of the output."""
        tree, lines, body = self.tree, self.lines, self.tree.aimed
        if tree.aim is AngleAim:
            return lines.total(*(lines.product(accelerations[u]) for u in self.spinning[body] if u != self.known))
        arm = self.arm(body, "mechanism.aim.at")
        terms = []
        without_rates = self._carried(body, arm)
        if without_rates is not None:
            terms.append(f"dot(mechanism.aim.direction, {without_rates})")
        for u in {**self.moving[body], **self.spinning[body]}:
            if u != self.known:
                change = self.all_of(self.moving[body].get(u), self.cross(self.spinning[body].get(u), arm))
                terms.append(f"{number(accelerations[u])} * dot(mechanism.aim.direction, {change})")
        return lines.total(*terms)


def accelerate(tree: MachineType) -> str:
    """Return the code of the family member of that name."""
    write = Dynamics(tree)
    lines, solution = write.lines, write.solved()
    known_terms = (lines.product(write.entry(write.known, u), solution[u]) for u in range(tree.speeds))
    torque = lines.total(*known_terms, lines.minus(write.right(write.known)))
    accelerations = tupled(write.coordinates(solution))
    return lines.function("accelerate", f"Motion({accelerations}, {number(write.output(solution))}, {number(torque)})")
