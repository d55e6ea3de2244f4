"""Generated functions of a planar machine's compiled form.

A family has one body for all planar machines, which calls the code generated for the type of its argument at the
first call: plain code without loops or tables, which consists only of sums and products.
"""

import functools
import linecache
import operator
from collections.abc import Callable

from ....tracing.compiled import calculus
from ....tracing.compiled.choosing import where
from ....tracing.compiled.dual import Dual, as_type_of, plain, value
from ....tracing.compiled.family import form_number, inlined, kernel
from ...joints.dry import Gap
from ...joints.guide import GuideGap
from ...laws.friction import friction_force, friction_in_pin, static_limit, static_limit_in_pin
from ..contract import Motion
from . import dynamics, friction
from .cycle import evaluate_cycle
from .drive import drive_motion, torque_at
from .expressions import ZERO, Expr, FunctionCode, PlaneVector, sum_of, tuple_code
from .kinematics import Bodies
from .loads import table_values
from .machine_type import MachineType, kinds_of, machine_type
from .pose import Orientation, Pose
from .pose_generation import close_loops_code, loop_jacobian_code, newton_step_code, pose_code
from .spanning_tree import TRAVEL, Coordinate


def function_of(mechanism, name: str) -> Callable:
    """Return the generated function `name` for the type of a machine, for calls from Python."""
    return _functions(kinds_of(mechanism))[name]


def generated(name: str) -> Callable:
    """Return the function `name`, generated for the type of machine at its first call."""

    def dispatch(mechanism, *arguments):
        form = form_number(mechanism)
        if form not in by_form:
            by_form[form] = function_of(mechanism, name)
        return by_form[form](mechanism, *arguments)

    by_form = {}  # faster than by `kinds_of`
    dispatch.body_of = functools.partial(function_of, name=name)
    return dispatch


@functools.lru_cache(maxsize=1024)
def _functions(kinds: tuple) -> dict[str, Callable]:
    """Return all functions of a type of machine by their names."""
    text = source_text(kinds)
    name = f"<planar machine {hash(kinds):x}>"
    linecache.cache[name] = (len(text), None, text.splitlines(keepends=True), name)  # for tracebacks
    functions: dict = {
        "direction": calculus.direction,
        "drive_motion": drive_motion,
        "torque_at": torque_at,
        "evaluate_cycle": evaluate_cycle,
        "table_values": table_values,
        "as_type_of": as_type_of,
        "plain": plain,
        "math": calculus,
        "Gap": Gap,
        "GuideGap": GuideGap,
        "Motion": Motion,
        "FrictionMotion": friction.FrictionMotion,
        "friction_force": friction_force,
        "friction_in_pin": friction_in_pin,
        "static_limit": static_limit,
        "static_limit_in_pin": static_limit_in_pin,
        "where": where,
        "Pose": Pose,
        "Orientation": Orientation,
    }
    exec(compile(text, name, "exec"), functions)
    if "under_friction" in functions:
        functions["under_friction"] = kernel(functions["under_friction"])
    if "newton_step" in functions:
        functions["newton_step"], functions["close_loops"] = (
            inlined(functions["newton_step"]),
            kernel(functions["close_loops"]),
        )
        functions["extra_newton_step"] = _extra_step(functions["newton_step"])
    return functions


def _extra_step(step: Callable) -> Callable:
    """Return the extra Newton step `step` for numbers differentiated twice; others need none."""

    @kernel
    def repeated(mechanism, known_values, dependent):
        return (
            step(mechanism, known_values, dependent)
            if any(isinstance(value(x), Dual) for x in dependent)
            else dependent
        )

    return repeated


def source_text(kinds: tuple) -> str:
    """Return the code of all functions of a type of machine, as text."""
    machine = machine_type(kinds)
    solvers = (
        (newton_step_code, close_loops_code)
        if machine.dependent
        else (loop_jacobian_code,)
        if machine.spanning_tree.loop_joints
        else ()
    )
    accelerate_source = friction.accelerate_code if machine.friction_loads else dynamics.accelerate_code
    return "\n\n".join(generate(machine) for generate in (*solvers, accelerate_source, *_GENERATORS))


# ---------------------------------------------------------------------------------------------- observables


def _gaps_code(machine: MachineType) -> str:
    bodies = Bodies(machine, "mechanism", "pose")
    gaps = []
    for j in machine.open:
        link, path = machine.sites[j].link, bodies.gap(j)
        position, velocity = bodies.position(path), bodies.velocity(path)
        if link.slides:
            gaps.append(_guide_gap_code(bodies, j, position, velocity))
        else:
            gaps.append(_call_code("Gap", *position, *velocity, bodies.spin(link.proximal), bodies.spin(link.distal)))
    return bodies.code.function("gaps", tuple_code(gaps))


def _guide_gap_code(bodies: Bodies, j: int, position: PlaneVector, velocity: PlaneVector) -> str:
    """Return the code of a GuideGap."""
    link, axis, spin = bodies.machine.sites[j].link, bodies.axis(j), bodies.spin(bodies.machine.sites[j].link.proximal)
    normal = axis.left()
    x, y = axis.dot(position), normal.dot(position)
    vx, vy = axis.dot(velocity), normal.dot(velocity)
    relative_vx, relative_vy = vx + spin * y, vy - spin * x  # as seen from the rotating walls
    proximal, distal = bodies.direction(link.proximal), bodies.direction(link.distal)
    cosine, sine = proximal.dot(distal), proximal.cross(distal)
    return _call_code("GuideGap", x, y, relative_vx, relative_vy, spin, bodies.spin(link.distal), *axis, cosine, sine)


def _call_code(function: str, *arguments: Expr) -> str:
    """Return the code of a call."""
    return f"{function}({', '.join(map(str, arguments))})"


def _energy_code(machine: MachineType) -> str:
    bodies = Bodies(machine, "mechanism", "pose")
    code, twice_kinetic, vertical_momenta = bodies.code, [], []
    for body in range(1, machine.bodies):
        mass, inertia = bodies.inertia_of(body)
        velocity, spin = bodies.velocity(bodies.path_to(body)), bodies.spin(body)
        twice_kinetic += [mass * component * component for component in velocity]
        twice_kinetic.append(inertia * spin * spin)
        vertical_momenta.append(mass * velocity.y)
    kinetic, momentum = 0.5 * sum_of(twice_kinetic), sum_of(vertical_momenta)
    power = [-(code.expression("mechanism.gravity") * momentum)]
    for load in bodies.applied_loads():
        velocity = bodies.velocity(bodies.path_to(load.body, load.point))
        power += [*load.force.products(velocity), load.torque * bodies.spin(load.body)]
    for j in machine.sprung:
        power.append(-(bodies.tension(j) * bodies.rate[Coordinate(TRAVEL, j)]))
    return code.function("energy", f"({kinetic}, {sum_of(power)})")


def _describe_code(machine: MachineType) -> str:
    bodies = Bodies(machine, "mechanism", "pose", "motion", "out")
    code, crank = bodies.code, machine.groups.index(machine.spanning_tree.crank)
    position, velocity = _output_motion(bodies)
    values = ["pose.time", f"pose.orientations[{crank}].angle", "motion.torque", position, velocity, "motion.output"]
    for masses in machine.whole_bodies:
        group = machine.spanning_tree.group[masses[0]]
        values += _centre_of_mass(bodies, masses)
        values += (
            [f"pose.orientations[{machine.groups.index(group)}].angle", bodies.spin(masses[0])]
            if group
            else [ZERO, ZERO]
        )
        if masses[1:]:
            values.append(sum_of(bodies.travel[j] for j in machine.sprung if machine.sites[j].link.distal in masses))
    for i, item in enumerate(values):
        code.write(f"out[{i}] = {item}")
    return code.function("describe", str(len(values)))


def _centre_of_mass(bodies: Bodies, masses: tuple[int, ...]) -> list[Expr]:
    """Return position and velocity of the centre of mass of a body or of an elastic link's masses."""
    paths = [bodies.path_to(body) for body in masses]
    centres = [(*bodies.position(path), *bodies.velocity(path)) for path in paths]
    if not masses[1:]:
        return list(centres[0])
    weights = [bodies.inertia_of(body)[0] for body in masses]
    inverse = 1.0 / sum_of(weights)
    components = zip(*centres, strict=True)
    return [inverse * sum_of(map(operator.mul, weights, component)) for component in components]


def _body_angles_code(machine: MachineType) -> str:
    pairs = []
    for j in machine.open:
        link = machine.sites[j].link
        pairs.append(f"({_angle_code(machine, link.proximal)}, {_angle_code(machine, link.distal)})")
    return FunctionCode("mechanism", "pose").function("body_angles", tuple_code(pairs))


def _angle_code(machine: MachineType, body: int) -> str:
    group = machine.spanning_tree.group[body]
    return f"pose.orientations[{machine.groups.index(group)}].angle" if group else "0.0"


def _output_and_crank_code(machine: MachineType) -> str:
    bodies = Bodies(machine, "mechanism", "pose")
    crank, (position, rate) = (
        f"pose.orientations[{machine.groups.index(machine.spanning_tree.crank)}]",
        _output_motion(bodies),
    )
    return bodies.code.function("output", f"({position}, {rate}, {crank}.angle, {crank}.rate)")


def _crank_rate_code(machine: MachineType) -> str:
    crank = machine.groups.index(machine.spanning_tree.crank)
    return FunctionCode("mechanism", "pose").function("crank_rate", f"pose.orientations[{crank}].rate")


def _friction_laws_code(machine: MachineType) -> str:
    laws = tuple_code(f"mechanism.loads[{friction_load.load}].friction" for friction_load in machine.friction_loads)
    return FunctionCode("mechanism").function("friction_laws", laws)


def _with_friction_laws_code(machine: MachineType) -> str:
    """Return the code of a function that replaces the laws of friction loads."""
    loads = [f"mechanism.loads[{i}]" for i in range(len(machine.loads))]
    for i, friction_load in enumerate(machine.friction_loads):
        loads[friction_load.load] = f"mechanism.loads[{friction_load.load}]._replace(friction=laws[{i}])"
    return FunctionCode("mechanism", "laws").function(
        "with_friction_laws", f"mechanism._replace(loads={tuple_code(loads)})"
    )


def _output_motion(bodies: Bodies) -> tuple[Expr, Expr]:
    """Return the output's position and its rate."""
    machine = bodies.machine
    body, point, direction = machine.aim
    if point is None:
        return bodies.code.expression(_angle_code(machine, body)), bodies.spin(body)
    path, axis = bodies.path_to(body, bodies.code.vector(point)), bodies.code.vector(direction)
    velocity = bodies.velocity(path)
    return bodies.position(path).dot(axis), velocity.dot(axis)


_GENERATORS = (
    pose_code,
    _gaps_code,
    dynamics.impact_masses_code,
    _energy_code,
    _describe_code,
    _body_angles_code,
    _output_and_crank_code,
    _crank_rate_code,
    _friction_laws_code,
    _with_friction_laws_code,
)
