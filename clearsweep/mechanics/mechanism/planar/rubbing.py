"""Generates the code for friction in joints without clearance and for friction of given size.

The friction in a pin is a couple, in a guide a force, from a friction law and the reaction.  The reactions depend on
all friction.  Both are iterated to convergence: the couples are small compared with the moments of reactions at the
length of a body, so each iteration reduces the error tenfold or more.
"""

from typing import NamedTuple

from ...compiled.family import family
from ..contract import Motion
from .dynamics import Dynamics, Row, mass_of
from .kinematics import Bodies
from .loops import Solver, equations
from .machine_type import FrictionLoad, MachineType, Vector
from .spanning_tree import ANGLE, Coordinate
from .writer import number, tupled

SWEEPS = 200  # over friction and reactions
LEAST_YIELD = 1e-6  # rad/s^2 per N m, m/s^2 per N: a less compliant joint follows the crank and cannot stick
SETTLED = 1e-15  # tolerance, relative to the largest friction
JAMS = 1e-9  # the same after all sweeps: a larger change means that the joint jams

_SOLVED = """def accelerate(mechanism, pose, loads):
    normal = under_friction(mechanism, pose, loads, {zeros})[1]
    rub = {friction}
    change, largest = 0.0, 0.0
    for _ in range({sweeps}):
        normal = under_friction(mechanism, pose, loads, rub)[1]
        before, rub = rub, {friction}
        change, largest = 0.0, 0.0
        for i in range({count}):
            change = max(change, abs(plain(rub[i]) - plain(before[i])))
            largest = max(largest, abs(plain(rub[i])))
        if change <= {near} * largest:
            break
    motion = under_friction(mechanism, pose, loads, rub)[0]
    valid = 1.0 if change <= {jams} * largest else math.nan
    return RubbedMotion(motion.accelerations, motion.output, motion.torque, {power}, {speeds})
"""


_GIVEN = """def accelerate(mechanism, pose, loads):
    rub = {friction}
    motion = under_friction(mechanism, pose, loads, rub)[0]
    return RubbedMotion(motion.accelerations, motion.output, motion.torque, {power}, {speeds})
"""


#: Karnopp 1985: below the band each couple or force makes the slip decay with the rate of the crank,
#: within its limits, which may depend on reactions; several are iterated (projected Gauss-Seidel).
_STICKING = """def accelerate(mechanism, pose, loads):
    _, normal, pace = under_friction(mechanism, pose, loads, {zeros})
    rub = {friction}
    _, normal, pace = under_friction(mechanism, pose, loads, rub)
    yields, stuck, slips = {yields}, {stuck}, {slips}
    change, largest = 0.0, 0.0
    for _ in range({sweeps}):
        before = rub
        rub = {sliding}
{turns}
        change, largest = 0.0, 0.0
        for i in range({count}):
            change = max(change, abs(plain(rub[i]) - plain(before[i])))
            largest = max(largest, abs(plain(rub[i])))
        if change <= {near} * largest:
            break
    motion = under_friction(mechanism, pose, loads, rub)[0]
    valid = 1.0 if change <= {jams} * largest else math.nan
    return RubbedMotion(motion.accelerations, motion.output, motion.torque, {power}, {speeds})
"""


class RubbedMotion(NamedTuple):
    """Motion of a machine with friction in its ideal joints, with the powers of that friction."""

    accelerations: tuple
    output: float
    torque: float  # N m
    powers: tuple  # W, of each friction; nan without convergence
    slips: tuple  # at which its law is evaluated: m/s, or rad/s for a couple of a given size


@family
def rubbed_powers(motion):
    """Return the power (W) of each friction in joints without clearance, or of a given size."""


@rubbed_powers.member(Motion)
def _rubbed_powers_motion(motion):
    return ()


@rubbed_powers.member(RubbedMotion)
def _rubbed_powers_rubbed_motion(motion):
    return motion.powers


@family
def rubbed_slips(motion):
    """Return the sliding speed that the law of each friction is evaluated at."""


@rubbed_slips.member(Motion)
def _rubbed_slips_motion(motion):
    return ()


@rubbed_slips.member(RubbedMotion)
def _rubbed_slips_rubbed_motion(motion):
    return motion.slips


class Reacting(Dynamics):
    """Accelerations under given friction, and the corresponding reactions."""

    def forces(self):
        """Return the terms of the forces on the bodies and of the moments about their centres of mass."""
        force, moment = super().forces()
        for i, friction_load in enumerate(self.machine.friction_loads):
            site, size = self.machine.sites[friction_load.joint], self.lines.let(f"rub[{i}]")
            endpoints = ((site.link.distal, site.far, "+"), (site.link.proximal, site.near, "-"))
            for body, point, sign in endpoints:
                if not site.link.slides:
                    moment[body].append(size if sign == "+" else self.lines.minus(size))
                    continue
                friction_force = self.signed(sign, self.scaled(size, self.axis(friction_load.joint)))
                force[body].append(friction_force)
                moment[body].append(self.moment(body, point, friction_force))
            if (
                site.link.slides and friction_load.joint in self.machine.open
            ):  # the walls are loaded at the position of the block
                moment[site.link.proximal].append(self.lines.product(size, _offset(self, friction_load.joint)))
        return force, moment

    def normals(self, accelerations: Row) -> list[str | None]:
        """Return the magnitude of the reaction in each joint with friction, for the accelerations of all coordinates.

        It is 0 for friction of given size.
        """
        lines, machine = self.lines, self.machine
        if all(friction_load.given for friction_load in machine.friction_loads):
            return ["0.0"] * len(machine.friction_loads)
        missing, couples = self._missing(accelerations)
        reactions = self._multipliers(missing, couples)
        for j, known_reaction in reactions.items():
            link = machine.sites[j].link
            missing[link.distal] = self.sum(missing[link.distal], self.minus(known_reaction))
            missing[link.proximal] = self.sum(missing[link.proximal], known_reaction)
        sizes = []
        for friction_load in machine.friction_loads:
            if friction_load.given:
                sizes.append("0.0")
                continue
            reaction = reactions.get(friction_load.joint) or self._through(friction_load.joint, missing)
            if machine.sites[friction_load.joint].link.slides:
                transverse = lines.total(*lines.dot(self.left(self.axis(friction_load.joint)), reaction))
                sizes.append(f"abs({transverse})")
            else:
                sizes.append(f"math.sqrt({lines.total(*lines.dot(reaction, reaction))})")
        return [size if size == "0.0" else lines.let(size) for size in sizes]

    def pace(self, friction_load: FrictionLoad, accelerations: Row) -> str | None:
        """Return the derivative of a joint's slip (rad/s^2 or m/s^2), for the accelerations of all coordinates."""
        lines, link = self.lines, self.machine.sites[friction_load.joint].link
        if not link.slides:
            relative_turn = (
                accelerations.get(Coordinate(ANGLE, self.spanning_tree.group[body]))
                for body in (link.distal, link.proximal)
            )
            distal, proximal = relative_turn
            return lines.total(distal, lines.minus(proximal))
        path, axis = self.between(*self.site(friction_load.joint)), self.axis(friction_load.joint)
        columns = self.columns(path)
        change = self.sum(
            self.bias(path),
            self.combination({item: columns[item] for item in columns if item in accelerations}, accelerations),
        )
        transverse = lines.total(*lines.dot(self.left(axis), self.combination(columns, self.rate)))
        return lines.total(*lines.dot(axis, change), lines.product(self.spin(link.proximal), transverse))

    def _missing(self, accelerations: Row) -> tuple[dict[int, Vector], dict[int, str | None]]:
        """Return force and moment of the joints on each body."""
        lines = self.lines
        force, moment = self.forces()
        missing: dict[int, Vector] = {0: (None, None)}
        couples: dict[int, str | None] = {0: None}
        for body, path in self.paths.items():
            mass, inertia = mass_of(lines, body)
            change = self.sum(self.bias(path), self.combination(self.tree[body], accelerations))
            safe_yield = [tuple(map(lines.minus, force_vector)) for force_vector in force[body]]
            missing[body] = self.sum(self.scaled(mass, change), *safe_yield)
            spun = lines.product(inertia, accelerations.get(Coordinate(ANGLE, self.spanning_tree.group[body])))
            couples[body] = lines.total(spun, *map(lines.minus, moment[body]))
        return missing, couples

    def _multipliers(self, missing: dict, couples: dict) -> dict[int, Vector]:
        """Return the force on the distal body of each joint that closes a loop."""
        lines, machine, right_side = self.lines, self.machine, {}
        if not machine.dependent:
            return {}
        for item in machine.dependent:
            terms = [part for body in self.paths for part in self._work(item, body, missing)]
            if item.kind == ANGLE:
                terms += [couples[body] for body in self.paths if self.spanning_tree.group[body] == item.of]
            right_side[item] = lines.total(*terms)
        rows = [equation.columns for equation in equations(self, with_rates=False)]
        multipliers = Solver(lines, rows, machine.dependent).transposed(right_side)
        results, row = {}, 0
        for j in self.spanning_tree.loop_joints:
            if machine.sites[j].link.slides:
                results[j] = self.scaled(multipliers[row], self.left(self.axis(j)))
                row += 1
            else:
                results[j] = (multipliers[row], multipliers[row + 1])
                row += 2
        return results

    def _work(self, item: Coordinate, body: int, missing: dict) -> tuple:
        column = self.tree[body].get(item)
        return self.lines.dot(column, missing[body]) if column else ()

    def _through(self, joint: int, missing: dict) -> Vector:
        """Return the force that a tree joint transmits to its subtree."""
        hung = [body for body in self.paths if self._hangs(body, joint)]
        return self.sum((None, None), *(missing[body] for body in hung))

    def _hangs(self, body: int, joint: int) -> bool:
        while self.spanning_tree.parents[body] is not None:
            body, through = self.spanning_tree.parents[body]
            if through == joint:
                return True
        return False


def accelerate(machine: MachineType) -> str:
    """Return the code of `accelerate` for machines with friction in joints without clearance."""
    write = Reacting(machine, "mechanism", "pose", "loads", "rub")
    motion, accelerations = write.motion()
    sizes, paces = (
        write.normals(accelerations),
        [write.pace(friction_load, accelerations) for friction_load in machine.friction_loads if friction_load.sticks],
    )
    returned = (motion, tupled(sizes), tupled([number(pace) for pace in paces])) if paces else (motion, tupled(sizes))
    function_name = write.lines.function("under_friction", tupled(list(returned)))
    kinematics = Bodies(machine, "mechanism", "pose")
    frictions = [_friction_code(kinematics, i, friction_load) for i, friction_load in enumerate(machine.friction_loads)]
    friction, power = (
        [code.force for code in frictions],
        [f"rub[{i}] * {code.slip}" for i, code in enumerate(frictions)],
    )
    places = {
        "zeros": tupled(["0.0"] * len(frictions)),
        "friction": tupled(friction),
        "sweeps": SWEEPS,
        "count": len(frictions),
        "near": SETTLED,
        "jams": JAMS,
        "speeds": tupled([code.speed for code in frictions]),
    }
    if any(friction_load.sticks for friction_load in machine.friction_loads):
        template, places = _STICKING, places | _sticking(machine, frictions)
    else:
        template = _GIVEN if all(friction_load.given for friction_load in machine.friction_loads) else _SOLVED
    header, body = template.split("\n", 1)
    valid = template is not _GIVEN
    text = body.format(power=tupled([f"valid * ({power_term})" for power_term in power] if valid else power), **places)
    slips = "".join(f"    {line}\n" for line in kinematics.lines.text)
    return f"{function_name}\n\n{header}\n{slips}{text}"


class _FrictionCode(NamedTuple):
    """The code of one friction."""

    path: str  # of the load
    arm: str  # m, of the couple; '' in a guide
    normal: str  # N
    slip: str  # rad/s or m/s, between the bodies
    speed: str  # at which the law is evaluated

    @property
    def force(self) -> str:
        """Return the code of the couple (N m) or force (N) while the surfaces slide."""
        force = f"friction_force({self.path}.friction, {self.normal}, {self.speed})"
        return f"{self.arm} * {force}" if self.arm else force

    @property
    def limit(self) -> str:
        """Return the code of the largest couple (N m) or force (N) while the surfaces stick."""
        static_limit_text = f"static_limit({self.path}.friction) * {self.normal}"
        return f"{self.arm} * {static_limit_text}" if self.arm else static_limit_text


def _friction_code(kinematics: Bodies, i: int, friction_load: FrictionLoad) -> _FrictionCode:
    path, slip = f"mechanism.loads[{friction_load.load}]", _slip(kinematics, friction_load)
    arm = "" if kinematics.machine.sites[friction_load.joint].link.slides else f"{path}.radius"
    normal = f"{path}.normal" if friction_load.given else f"normal[{i}]"
    return _FrictionCode(path, arm, normal, slip, f"{arm} * {slip}" if arm else slip)


def _sticking(machine: MachineType, frictions: list[_FrictionCode]) -> dict[str, str]:
    """Return the further code of a machine in which joints stick, by its places in _STICKING."""
    sticking = [i for i, friction_load in enumerate(machine.friction_loads) if friction_load.sticks]
    rate = f"abs(pose.turns[{machine.groups.index(machine.spanning_tree.crank)}].rate)"

    def with_one(i: int, value: str) -> str:
        return tupled([value if j == i else f"rub[{j}]" for j in range(len(frictions))])

    sliding, yields, stuck, turns = [code.force for code in frictions], [], [], []
    for k, i in enumerate(sticking):
        sliding[i] = f"where(stuck[{k}], rub[{i}], {frictions[i].force})"
        perturbed = with_one(i, f"rub[{i}] + 1.0")
        yields.append(f"under_friction(mechanism, pose, loads, {perturbed})[2][{k}] - pace[{k}]")
        stuck.append(f"abs({frictions[i].speed}) < {frictions[i].path}.friction.band")
        turns += [
            "_, normal, pace = under_friction(mechanism, pose, loads, rub)",
            f"there = where(yields[{k}] > {LEAST_YIELD}, yields[{k}], 1.0)",
            f"limit = {frictions[i].limit}",
            f"wanted = rub[{i}] - (pace[{k}] + {rate} * slips[{k}]) / there",
            "wanted = min(max(wanted, -limit), limit)",
            f"bounded = where(yields[{k}] > {LEAST_YIELD}, wanted, rub[{i}])",
            f"rub = {with_one(i, f'where(stuck[{k}], bounded, rub[{i}])')}",
        ]
    return {
        "sliding": tupled(sliding),
        "yields": tupled(yields),
        "stuck": tupled(stuck),
        "slips": tupled([frictions[i].slip for i in sticking]),
        "turns": "\n".join(f"        {turn}" for turn in turns),
    }


def _slip(write: Bodies, friction_load: FrictionLoad) -> str:
    """Return the rate at which the distal body turns or slides on the proximal one."""
    lines, link = write.lines, write.machine.sites[friction_load.joint].link
    if not link.slides:
        couples = lines.total(write.spin(link.distal), lines.minus(write.spin(link.proximal)))
        return number(lines.let(couples))
    velocity = write.combination(write.columns(write.between(*write.site(friction_load.joint))), write.rate)
    terms = lines.dot(write.axis(friction_load.joint), velocity)
    if friction_load.joint in write.machine.open:
        terms = (*terms, lines.product(write.spin(link.proximal), _offset(write, friction_load.joint)))
    return number(lines.total(*terms))


def _offset(write: Bodies, joint: int) -> str | None:
    """Return the offset (m) of a block from the middle of its guide."""
    lines = write.lines
    offset = tuple(map(lines.let, write.place(write.between(*write.site(joint)))))
    return lines.total(*lines.dot(write.left(write.axis(joint)), offset))
