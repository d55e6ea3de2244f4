"""Generates the code for friction in joints without clearance and for friction of given size.

The friction in a pin is a couple, in a guide a force, from a friction law and the reaction.  The reactions depend on
all friction.  Both are iterated to convergence: the couples are small compared with the moments of reactions at the
length of a body, so each iteration reduces the error tenfold or more.
"""

from typing import NamedTuple

from ....tracing.compiled.family import family
from ..contract import Motion
from .dynamics import Dynamics
from .expressions import NO_VECTOR, ZERO, Expr, PlaneVector, sum_of, tuple_code, vector_sum
from .kinematics import Bodies, combination, signed
from .loops import Row, Solver, loop_equations_of
from .machine_type import FrictionLoad, MachineType
from .spanning_tree import ANGLE, Coordinate

SWEEPS = 200  # over friction and reactions
MIN_COMPLIANCE = 1e-6  # rad/s^2 per N m, m/s^2 per N: a less compliant joint follows the crank and cannot stick
CONVERGED = 1e-15  # tolerance, relative to the largest friction
JAM_TOLERANCE = 1e-9  # the same after all sweeps: a larger change means that the joint jams

_UNTIL_CONVERGED = """        change, largest = 0.0, 0.0
        for i in range({count}):
            change = max(change, abs(plain(friction[i]) - plain(before[i])))
            largest = max(largest, abs(plain(friction[i])))
        if change <= {converged} * largest:
            break
    motion = under_friction(mechanism, pose, loads, friction)[0]
    valid = 1.0 if change <= {jams} * largest else math.nan
    return FrictionMotion(motion.accelerations, motion.output, motion.torque, {power}, {speeds})
"""


_SOLVED = (
    """def accelerate(mechanism, pose, loads):
    normal = under_friction(mechanism, pose, loads, {zeros})[1]
    friction = {friction}
    change, largest = 0.0, 0.0
    for _ in range({sweeps}):
        normal = under_friction(mechanism, pose, loads, friction)[1]
        before, friction = friction, {friction}
"""
    + _UNTIL_CONVERGED
)


_GIVEN = """def accelerate(mechanism, pose, loads):
    friction = {friction}
    motion = under_friction(mechanism, pose, loads, friction)[0]
    return FrictionMotion(motion.accelerations, motion.output, motion.torque, {power}, {speeds})
"""


#: Karnopp 1985: while the slip is below the band, each couple or force makes it decay at the rate of
#: the crank, within its limits, which may depend on reactions; several are iterated (projected Gauss-Seidel).
_STICKING = (
    """def accelerate(mechanism, pose, loads):
    _, normal, slip_rates = under_friction(mechanism, pose, loads, {zeros})
    friction = {friction}
    _, normal, slip_rates = under_friction(mechanism, pose, loads, friction)
    compliances, stuck, slips = {compliances}, {stuck}, {slips}
    change, largest = 0.0, 0.0
    for _ in range({sweeps}):
        before = friction
        friction = {sliding}
{sweep_lines}
"""
    + _UNTIL_CONVERGED
)


class FrictionMotion(NamedTuple):
    """Motion of a machine, with powers and sliding speeds of friction in joints without clearance or of given size."""

    accelerations: tuple
    output: float
    torque: float  # N m
    powers: tuple  # W, of each friction; nan without convergence
    slips: tuple  # at which its law is evaluated: m/s, or rad/s for a couple of a given size


@family
def friction_powers_of(motion):
    """Return the power (W) of each friction in joints without clearance, or of a given size."""


@friction_powers_of.member(Motion)
def _friction_powers_of_motion(motion):
    return ()


@friction_powers_of.member(FrictionMotion)
def _friction_powers_of_friction_motion(motion):
    return motion.powers


@family
def friction_slips_of(motion):
    """Return the sliding speed at which the law of each friction is evaluated."""


@friction_slips_of.member(Motion)
def _friction_slips_of_motion(motion):
    return ()


@friction_slips_of.member(FrictionMotion)
def _friction_slips_of_friction_motion(motion):
    return motion.slips


class FrictionDynamics(Dynamics):
    """Accelerations under given friction, and the corresponding reactions."""

    def forces(self) -> tuple[dict[int, list[PlaneVector]], dict[int, list[Expr]]]:
        """Return the terms of the forces on the bodies and of the moments about their centres of mass."""
        force, moment = super().forces()
        for i, friction_load in enumerate(self.machine.friction_loads):
            j, size = friction_load.joint, self.code.assign(f"friction[{i}]")
            link, joint = self.machine.sites[j].link, self.joints[j]
            if not link.slides:
                moment[link.distal].append(size)
                moment[link.proximal].append(-size)
                continue
            for body, point, sign in ((link.distal, joint.far, 1), (link.proximal, joint.near, -1)):
                friction_force = signed(sign, size * self.axis(j))
                force[body].append(friction_force)
                moment[body].append(self.moment(body, point, friction_force))
            if j in self.machine.open:  # the walls are loaded at the position of the block
                moment[link.proximal].append(size * _guide_offset(self, j))
        return force, moment

    def normals(self, accelerations: Row) -> list[Expr]:
        """Return the magnitude of the reaction in each joint with friction, for the accelerations of all coordinates.

        It is that across a guide, and 0 for friction of given size.
        """
        friction_loads = self.machine.friction_loads
        if all(friction_load.is_given for friction_load in friction_loads):
            return [ZERO] * len(friction_loads)
        force, moment = self._joint_loads(accelerations)
        loop_reactions = self._loop_reactions(force, moment)
        for j, reaction in loop_reactions.items():
            link = self.machine.sites[j].link
            force[link.distal] -= reaction
            force[link.proximal] += reaction
        sizes = []
        for friction_load in friction_loads:
            j = friction_load.joint
            reaction = loop_reactions[j] if j in loop_reactions else self._tree_reaction(j, force)
            if friction_load.is_given:
                sizes.append(ZERO)
            elif self.machine.sites[j].link.slides:
                sizes.append(f"abs({self.axis(j).left().dot(reaction)})")
            else:
                sizes.append(f"math.sqrt({reaction.dot(reaction)})")
        return [self.code.assign(size) for size in sizes]

    def slip_rate(self, friction_load: FrictionLoad, accelerations: Row) -> Expr:
        """Return the derivative of a joint's slip (rad/s^2 or m/s^2), for the accelerations of all coordinates."""
        link = self.machine.sites[friction_load.joint].link
        if not link.slides:
            distal, proximal = (
                accelerations.get(Coordinate(ANGLE, self.spanning_tree.group[body]), ZERO)
                for body in (link.distal, link.proximal)
            )
            return distal - proximal
        path, axis = self.gap(friction_load.joint), self.axis(friction_load.joint)
        acceleration = self.acceleration(path, accelerations)
        transverse = axis.left().dot(self.velocity(path))
        return sum_of([*axis.products(acceleration), self.spin(link.proximal) * transverse])

    def _joint_loads(self, accelerations: Row) -> tuple[dict[int, PlaneVector], dict[int, Expr]]:
        """Return force and moment of the joints without clearance on each body."""
        applied_force, applied_moment = self.forces()
        force: dict[int, PlaneVector] = {0: NO_VECTOR}
        moment: dict[int, Expr] = {0: ZERO}
        for body, path in self.paths.items():
            mass, inertia = self.inertia_of(body)
            acceleration = self.bias(path) + combination(self.tree_columns[body], accelerations)
            force[body] = vector_sum([mass * acceleration, *(-term for term in applied_force[body])])
            angular_acceleration = accelerations.get(Coordinate(ANGLE, self.spanning_tree.group[body]), ZERO)
            moment[body] = sum_of([inertia * angular_acceleration, *(-term for term in applied_moment[body])])
        return force, moment

    def _loop_reactions(self, force: dict[int, PlaneVector], moment: dict[int, Expr]) -> dict[int, PlaneVector]:
        """Return the force on the distal body of each joint that closes a loop."""
        machine = self.machine
        if not machine.dependent:
            return {}
        right_side: Row = {}
        for coordinate in machine.dependent:
            terms: list[Expr] = []
            for body, columns in self.tree_columns.items():
                terms += columns[coordinate].products(force[body]) if coordinate in columns else ()
            if coordinate.kind == ANGLE:
                terms += [moment[body] for body in self.paths if self.spanning_tree.group[body] == coordinate.owner]
            right_side[coordinate] = sum_of(terms)
        loop_rows = [equation.columns for equation in loop_equations_of(self, with_rates=False)]
        multipliers = Solver(loop_rows, machine.dependent, branches=machine.branches).solve_transposed(right_side)
        reactions: dict[int, PlaneVector] = {}
        row = 0
        for j in self.spanning_tree.loop_joints:
            if machine.sites[j].link.slides:
                reactions[j] = multipliers[row] * self.axis(j).left()
                row += 1
            else:
                reactions[j] = PlaneVector(multipliers[row], multipliers[row + 1])
                row += 2
        return reactions

    def _tree_reaction(self, joint: int, force: dict[int, PlaneVector]) -> PlaneVector:
        """Return the force that a tree joint transmits to its subtree."""
        return vector_sum([force[body] for body in self.paths if self._in_subtree(body, joint)])

    def _in_subtree(self, body: int, joint: int) -> bool:
        """Return whether the path from the ground to a body passes a joint of the tree."""
        while self.spanning_tree.parents[body] is not None:
            body, passed_joint = self.spanning_tree.parents[body]
            if passed_joint == joint:
                return True
        return False


def accelerate_code(machine: MachineType) -> str:
    """Return the code of `accelerate` for machines with friction in joints without clearance."""
    dynamics = FrictionDynamics(machine, "mechanism", "pose", "loads", "friction")
    motion, accelerations = dynamics.motion()
    normals = dynamics.normals(accelerations)
    slip_rates = [dynamics.slip_rate(load, accelerations) for load in machine.friction_loads if load.sticks]
    results = [motion, tuple_code(normals), *([tuple_code(slip_rates)] if slip_rates else [])]
    under_friction = dynamics.code.function("under_friction", tuple_code(results))
    bodies = Bodies(machine, "mechanism", "pose")
    frictions = [_friction_code(bodies, i, friction_load) for i, friction_load in enumerate(machine.friction_loads)]
    powers = [f"friction[{i}] * {code.slip}" for i, code in enumerate(frictions)]
    fields = {
        "zeros": tuple_code(["0.0"] * len(frictions)),
        "friction": tuple_code(code.force for code in frictions),
        "sweeps": SWEEPS,
        "count": len(frictions),
        "converged": CONVERGED,
        "jams": JAM_TOLERANCE,
        "speeds": tuple_code(code.speed for code in frictions),
    }
    if slip_rates:
        template, fields = _STICKING, fields | _sticking_code(machine, frictions)
    else:
        template = _GIVEN if all(friction_load.is_given for friction_load in machine.friction_loads) else _SOLVED
    fields["power"] = tuple_code(powers if template is _GIVEN else (f"valid * ({power})" for power in powers))
    header, body = template.split("\n", 1)
    slips = "".join(f"    {line}\n" for line in bodies.code.lines)
    return f"{under_friction}\n\n{header}\n{slips}{body.format(**fields)}"


class _FrictionCode(NamedTuple):
    """Source expressions for the friction in one joint."""

    path: str  # of the load
    arm: str  # m, of the couple; '' in a guide
    normal: str  # N; in a pin the reaction, unless the size is given
    in_pin: bool  # whether `normal` is the reaction of a pin, which friction contributes to
    slip: str  # rad/s or m/s, between the bodies
    speed: str  # at which the law is evaluated

    @property
    def force(self) -> str:
        """Return the generated expression for the sliding friction: a torque (N m) in a pin, a force (N) in a guide."""
        law = "friction_in_pin" if self.in_pin else "friction_force"
        force = f"{law}({self.path}.friction, {self.normal}, {self.speed})"
        return f"{self.arm} * {force}" if self.arm else force

    @property
    def limit(self) -> str:
        """Return the generated expression for the largest sticking friction, a torque (N m) or a force (N)."""
        static_limit_text = (
            f"static_limit_in_pin({self.path}.friction, {self.normal})"
            if self.in_pin
            else f"static_limit({self.path}.friction) * {self.normal}"
        )
        return f"{self.arm} * {static_limit_text}" if self.arm else static_limit_text


def _friction_code(bodies: Bodies, i: int, friction_load: FrictionLoad) -> _FrictionCode:
    path, slip = f"mechanism.loads[{friction_load.load}]", str(_slip_expression(bodies, friction_load))
    arm = "" if bodies.machine.sites[friction_load.joint].link.slides else f"{path}.radius"
    normal = f"{path}.normal" if friction_load.is_given else f"normal[{i}]"
    in_pin = bool(arm) and not friction_load.is_given
    return _FrictionCode(path, arm, normal, in_pin, slip, f"{arm} * {slip}" if arm else slip)


def _sticking_code(machine: MachineType, frictions: list[_FrictionCode]) -> dict[str, str]:
    """Return the additional code for a machine whose joints can stick, by field of the template _STICKING."""
    sticking_indices = [i for i, friction_load in enumerate(machine.friction_loads) if friction_load.sticks]
    rate = f"abs(pose.orientations[{machine.groups.index(machine.spanning_tree.crank)}].rate)"

    def with_force(i: int, force: str) -> str:
        return tuple_code([force if j == i else f"friction[{j}]" for j in range(len(frictions))])

    sliding, compliances, stuck, sweep_lines = [code.force for code in frictions], [], [], []
    for k, i in enumerate(sticking_indices):
        sliding[i] = f"where(stuck[{k}], friction[{i}], {frictions[i].force})"
        perturbed = with_force(i, f"friction[{i}] + 1.0")
        compliances.append(f"under_friction(mechanism, pose, loads, {perturbed})[2][{k}] - slip_rates[{k}]")
        stuck.append(f"abs({frictions[i].speed}) < {frictions[i].path}.friction.band")
        sweep_lines += [
            "_, normal, slip_rates = under_friction(mechanism, pose, loads, friction)",
            f"compliance = where(compliances[{k}] > {MIN_COMPLIANCE}, compliances[{k}], 1.0)",
            f"limit = {frictions[i].limit}",
            f"stopping_force = friction[{i}] - (slip_rates[{k}] + {rate} * slips[{k}]) / compliance",
            "stopping_force = min(max(stopping_force, -limit), limit)",
            f"bounded = where(compliances[{k}] > {MIN_COMPLIANCE}, stopping_force, friction[{i}])",
            f"friction = {with_force(i, f'where(stuck[{k}], bounded, friction[{i}])')}",
        ]
    return {
        "sliding": tuple_code(sliding),
        "compliances": tuple_code(compliances),
        "stuck": tuple_code(stuck),
        "slips": tuple_code([frictions[i].slip for i in sticking_indices]),
        "sweep_lines": "\n".join(f"        {line}" for line in sweep_lines),
    }


def _slip_expression(bodies: Bodies, friction_load: FrictionLoad) -> Expr:
    """Return the rate at which the distal body rotates or slides on the proximal one."""
    j = friction_load.joint
    link = bodies.machine.sites[j].link
    if not link.slides:
        return bodies.spin(link.distal) - bodies.spin(link.proximal)
    terms = [*bodies.axis(j).products(bodies.velocity(bodies.gap(j)))]
    if j in bodies.machine.open:
        terms.append(bodies.spin(link.proximal) * _guide_offset(bodies, j))
    return sum_of(terms)


def _guide_offset(bodies: Bodies, joint: int) -> Expr:
    """Return the offset (m) of a block from the middle of its guide, normal to the walls."""
    return bodies.axis(joint).left().dot(bodies.position(bodies.gap(joint)).assigned())
