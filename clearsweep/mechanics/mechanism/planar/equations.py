"""Generated functions of a planar machine's compiled form.

A family has one body for all planar machines, which calls the code generated for the type of its argument at the
first call: plain code without loops or tables, which consists only of sums and products.
"""

import functools
import linecache
from collections.abc import Callable

from ...compiled import calculus
from ...compiled.choosing import where
from ...compiled.dual import Dual, as_type_of, plain, value
from ...compiled.family import inlined, kernel
from ...joint.dry import Gap
from ...joint.friction.contract import friction_force, static_limit
from ...joint.guide import GuideGap
from ..contract import Motion
from . import dynamics, rubbing
from .cycle import at_angle
from .drive import driven, torque_at
from .dynamics import mass_of
from .kinematics import Bodies
from .loads import by_table
from .machine_type import MachineType, Vector, kinds_of, machine_type
from .placing import closed, loops, place, step
from .pose import Pose, Turn
from .spanning_tree import RUN, Coordinate
from .writer import Lines, number, tupled


def function_of(mechanism, name: str) -> Callable:
    """Return the generated function `name` for the type of a machine, for calls from Python."""
    return _functions(kinds_of(mechanism))[name]


def written(name: str) -> Callable:
    """Return the function `name`, generated for the type of machine at its first call."""

    def dispatch(mechanism, *remainder):
        return _functions(kinds_of(mechanism))[name](mechanism, *remainder)

    dispatch.body_of = functools.partial(function_of, name=name)
    return dispatch


@functools.lru_cache(maxsize=1024)
def _functions(kinds: tuple) -> dict[str, Callable]:
    """Return all functions of a type of machine by their names."""
    text = source(kinds)
    name = f"<planar machine {hash(kinds):x}>"
    linecache.cache[name] = (len(text), None, text.splitlines(keepends=True), name)  # for tracebacks
    functions: dict = {
        "direction": calculus.direction,
        "driven": driven,
        "torque_at": torque_at,
        "at_angle": at_angle,
        "by_table": by_table,
        "as_type_of": as_type_of,
        "plain": plain,
        "math": calculus,
        "Gap": Gap,
        "GuideGap": GuideGap,
        "Motion": Motion,
        "RubbedMotion": rubbing.RubbedMotion,
        "friction_force": friction_force,
        "static_limit": static_limit,
        "where": where,
        "Pose": Pose,
        "Turn": Turn,
    }
    exec(compile(text, name, "exec"), functions)
    if "under_friction" in functions:
        functions["under_friction"] = kernel(functions["under_friction"])
    if "step" in functions:
        functions["step"], functions["closed"] = inlined(functions["step"]), kernel(functions["closed"])
        functions["again"] = _again(functions["step"])
    return functions


def _again(step: Callable) -> Callable:
    """Return the extra Newton step `step` for numbers differentiated twice; others need none."""

    @kernel
    def repeated(mechanism, known_values, dependent):
        return (
            step(mechanism, known_values, dependent)
            if any(isinstance(value(x), Dual) for x in dependent)
            else dependent
        )

    return repeated


def source(kinds: tuple) -> str:
    """Return the code of all functions of a type of machine."""
    machine = machine_type(kinds)
    solvers = (step, closed) if machine.dependent else (loops,) if machine.spanning_tree.loop_joints else ()
    accelerate_source = rubbing.accelerate if machine.friction_loads else dynamics.accelerate
    return "\n\n".join(write(machine) for write in (*solvers, accelerate_source, *_WRITERS))


# ---------------------------------------------------------------------------------------------- observables


def _gaps(machine: MachineType) -> str:
    write = Bodies(machine, "mechanism", "pose")
    gaps = []
    for j in machine.open:
        between, link = write.between(*write.site(j)), machine.sites[j].link
        position, velocity = write.place(between), write.combination(write.columns(between), write.rate)
        spins = (write.spin(link.proximal), write.spin(link.distal))
        if link.slides:
            gaps.append(f"GuideGap({', '.join(map(number, _between_walls(write, j, position, velocity)))})")
        else:
            gaps.append(f"Gap({', '.join(map(number, (*position, *velocity, *spins)))})")
    return write.lines.function("gaps", tupled(gaps))


def _between_walls(write: Bodies, j: int, position: Vector, velocity: Vector) -> tuple:
    """Return the fields of a GuideGap."""
    lines, link = write.lines, write.machine.sites[j].link
    guide_axis = write.axis(j)
    left_side, spin = write.left(guide_axis), write.spin(link.proximal)
    x, y = (lines.total(*lines.dot(axis, position)) for axis in (guide_axis, left_side))
    vx, vy = (
        lines.total(*lines.dot(axis, velocity)) for axis in (guide_axis, left_side)
    )  # minus the rotation of the walls
    observed = (lines.total(vx, lines.product(spin, y)), lines.total(vy, lines.minus(lines.product(spin, x))))
    (c, s), (cd, sd) = (write.direction(body) for body in (link.proximal, link.distal))
    cosine = lines.total(lines.product(c, cd), lines.product(s, sd))
    sine = lines.total(lines.product(c, sd), lines.minus(lines.product(s, cd)))
    return (x, y, *observed, spin, write.spin(link.distal), *guide_axis, cosine, sine)


def _energy(machine: MachineType) -> str:
    write = Bodies(machine, "mechanism", "pose")
    lines, doubled, falling = write.lines, [], []
    for body in range(1, machine.bodies):
        mass, inertia = mass_of(lines, body)
        velocity = write.combination(write.columns(write.path_to(body)), write.rate)
        doubled += [lines.product(mass, component, component) for component in velocity]
        spin = write.spin(body)
        doubled.append(lines.product(inertia, spin, spin))
        falling.append(lines.product(mass, velocity[1]))
    kinetic, potential_terms = lines.product("0.5", lines.total(*doubled)), lines.total(*falling)
    power = [lines.minus(lines.product("mechanism.gravity", potential_terms))]
    for body, point, force, torque in write.applied():
        velocity = write.combination(write.columns(write.path_to(body, point)), write.rate)
        power += [*lines.dot(force, velocity), lines.product(torque, write.spin(body))]
    for j in machine.sprung:
        power.append(lines.minus(lines.product(write.tension(j), write.rate[Coordinate(RUN, j)])))
    return lines.function("energy", f"({number(kinetic)}, {number(lines.total(*power))})")


def _describe(machine: MachineType) -> str:
    write = Bodies(machine, "mechanism", "pose", "motion", "out")
    lines, crank = write.lines, machine.groups.index(machine.spanning_tree.crank)
    position, velocity = _aim(write)
    values = ["pose.time", f"pose.turns[{crank}].angle", "motion.torque", position, velocity, "motion.output"]
    for masses in machine.whole:
        group = machine.spanning_tree.group[masses[0]]
        values += _center(write, masses)
        values += [f"pose.turns[{machine.groups.index(group)}].angle", write.spin(masses[0])] if group else [None, None]
        if masses[1:]:
            runs = (write.run[j] for j in machine.sprung if machine.sites[j].link.distal in masses)
            values.append(lines.total(*runs))
    for i, name in enumerate(values):
        lines.text.append(f"out[{i}] = {number(name)}")
    return lines.function("describe", str(len(values)))


def _center(write: Bodies, masses: tuple[int, ...]) -> list[str | None]:
    """Return position and velocity of the centre of mass of a body or of an elastic link's masses."""
    lines, paths = write.lines, [write.path_to(body) for body in masses]
    centers = [(*write.place(path), *write.combination(write.columns(path), write.rate)) for path in paths]
    if not masses[1:]:
        return list(centers[0])
    weights = [mass_of(lines, body)[0] for body in masses]
    share = lines.let(f"1.0 / {number(lines.total(*weights))}")
    parts = zip(*centers, strict=True)
    return [lines.product(share, lines.total(*map(lines.product, weights, component))) for component in parts]


def _body_angles(machine: MachineType) -> str:
    pairs = []
    for j in machine.open:
        link = machine.sites[j].link
        pairs.append(f"({_angle(machine, link.proximal)}, {_angle(machine, link.distal)})")
    return Lines("mechanism", "pose").function("body_angles", tupled(pairs))


def _angle(machine: MachineType, body: int) -> str:
    group = machine.spanning_tree.group[body]
    return f"pose.turns[{machine.groups.index(group)}].angle" if group else "0.0"


def _output_and_crank(machine: MachineType) -> str:
    write = Bodies(machine, "mechanism", "pose")
    crank = f"pose.turns[{machine.groups.index(machine.spanning_tree.crank)}]"
    values = (*map(number, _aim(write)), f"{crank}.angle", f"{crank}.rate")
    return write.lines.function("output", f"({', '.join(values)})")


def _crank_rate(machine: MachineType) -> str:
    crank = machine.groups.index(machine.spanning_tree.crank)
    return Lines("mechanism", "pose").function("crank_rate", f"pose.turns[{crank}].rate")


def _rubs(machine: MachineType) -> str:
    return Lines("mechanism").function(
        "rubs", tupled([f"mechanism.loads[{friction_load.load}].friction" for friction_load in machine.friction_loads])
    )


def _with_rubs(machine: MachineType) -> str:
    """Return the code of a function that replaces the laws of friction loads."""
    loads = [f"mechanism.loads[{i}]" for i in range(len(machine.loads))]
    for i, friction_load in enumerate(machine.friction_loads):
        loads[friction_load.load] = f"mechanism.loads[{friction_load.load}]._replace(friction=laws[{i}])"
    return Lines("mechanism", "laws").function("with_rubs", f"mechanism._replace(loads={tupled(loads)})")


def _aim(write: Bodies) -> tuple[str | None, str | None]:
    """Return the output's position and its rate."""
    machine, lines = write.machine, write.lines
    body, point, guide_axis = machine.aim
    if point is None:
        group = machine.spanning_tree.group[body]
        return (f"pose.turns[{machine.groups.index(group)}].angle", write.spin(body)) if group else (None, None)
    path = write.path_to(body, point)
    velocity = write.combination(write.columns(path), write.rate)
    return lines.total(*lines.dot(write.place(path), guide_axis)), lines.total(*lines.dot(velocity, guide_axis))


_WRITERS = (
    place,
    _gaps,
    dynamics.impact_masses,
    _energy,
    _describe,
    _body_angles,
    _output_and_crank,
    _crank_rate,
    _rubs,
    _with_rubs,
)
