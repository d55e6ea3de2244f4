"""Formulas for the observables of a planar machine: gaps, energy, output and time histories."""

import operator

from ....tracing.compiled.formulas import Expr, Program, sum_of
from ...joints.dry import Gap
from ...joints.guide import GuideGap
from ..programs import generated
from .expressions import PlaneVector, vector_of
from .kinematics import Bodies
from .machine_type import MachineType, machine_type
from .spanning_tree import TRAVEL, Coordinate


@generated(machine_type)
def gaps_of(machine: MachineType) -> Program:
    """Return the program of `contract.gaps`."""
    bodies = Bodies(machine)
    joint_gaps: list[Gap | GuideGap] = []
    for j in machine.open:
        link, path = machine.sites[j].link, bodies.gap(j)
        position, velocity = bodies.position(path), bodies.velocity(path)
        if link.slides:
            joint_gaps.append(_guide_gap(bodies, j, position, velocity))
        else:
            joint_gaps.append(Gap(*position, *velocity, bodies.spin(link.proximal), bodies.spin(link.distal)))
    return bodies.program.returns(tuple(joint_gaps))


def _guide_gap(bodies: Bodies, j: int, position: PlaneVector, velocity: PlaneVector) -> GuideGap:
    link, axis, spin = bodies.machine.sites[j].link, bodies.axis(j), bodies.spin(bodies.machine.sites[j].link.proximal)
    normal = axis.left()
    x, y = axis.dot(position), normal.dot(position)
    vx, vy = axis.dot(velocity), normal.dot(velocity)
    relative_vx, relative_vy = vx + spin * y, vy - spin * x  # as seen from the rotating walls
    proximal, distal = bodies.direction(link.proximal), bodies.direction(link.distal)
    cosine, sine = proximal.dot(distal), proximal.cross(distal)
    return GuideGap(x, y, relative_vx, relative_vy, spin, bodies.spin(link.distal), *axis, cosine, sine)


@generated(machine_type)
def energy_of(machine: MachineType) -> Program:
    """Return the program of `contract.energy`."""
    bodies = Bodies(machine)
    twice_kinetic, vertical_momenta = [], []
    for body in range(1, machine.bodies):
        mass, inertia = bodies.inertia_of(body)
        velocity, spin = bodies.velocity(bodies.path_to(body)), bodies.spin(body)
        twice_kinetic += [mass * component * component for component in velocity]
        twice_kinetic.append(inertia * spin * spin)
        vertical_momenta.append(mass * velocity.y)
    kinetic, momentum = 0.5 * sum_of(twice_kinetic), sum_of(vertical_momenta)
    power = [-(bodies.mechanism.gravity * momentum)]
    for load in bodies.applied_loads():
        velocity = bodies.velocity(bodies.path_to(load.body, load.point))
        power += [*load.force.products(velocity), load.torque * bodies.spin(load.body)]
    for j in machine.sprung:
        power.append(-(bodies.tension(j) * bodies.rate[Coordinate(TRAVEL, j)]))
    return bodies.program.returns((kinetic, sum_of(power)))


@generated(machine_type)
def histories_of(machine: MachineType) -> Program:
    """Return the program of the time histories that `contract.describe` writes, from a mechanism, pose and Motion."""
    bodies = Bodies(machine, 3)
    motion = bodies.program.parameters[2]
    position, velocity = _output_motion(bodies)
    crank_angle = bodies.angle(machine.spanning_tree.crank)
    values = [bodies.pose.time, crank_angle, motion.torque, position, velocity, motion.output]
    for masses in machine.whole_bodies:
        values += _centre_of_mass(bodies, masses)
        values += [bodies.angle(machine.spanning_tree.group[masses[0]]), bodies.spin(masses[0])]
        if masses[1:]:
            values.append(sum_of(bodies.travel[j] for j in machine.sprung if machine.sites[j].link.distal in masses))
    return bodies.program.returns(tuple(values))


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


@generated(machine_type)
def body_angles_of(machine: MachineType) -> Program:
    """Return the program of `contract.body_angles`, of a pose."""
    bodies, group = Bodies(machine), machine.spanning_tree.group
    links = [machine.sites[j].link for j in machine.open]
    angles = [(bodies.angle(group[link.proximal]), bodies.angle(group[link.distal])) for link in links]
    return bodies.program.returns(tuple(angles))


@generated(machine_type)
def output_and_crank_of(machine: MachineType) -> Program:
    """Return the program of the output and the crank's angle, each with its rate, from a mechanism and its pose."""
    bodies, crank = Bodies(machine), machine.spanning_tree.crank
    position, rate = _output_motion(bodies)
    return bodies.program.returns((position, rate, bodies.angle(crank), crank_rate_in(bodies)))


@generated(machine_type)
def crank_rate_of(machine: MachineType) -> Program:
    """Return the program of `contract.crank_rate`."""
    bodies = Bodies(machine)
    return bodies.program.returns(crank_rate_in(bodies))


def crank_rate_in(bodies: Bodies) -> Expr:
    """Return the rate of the crank's angle."""
    return bodies.spin(bodies.machine.crank)


def _output_motion(bodies: Bodies) -> tuple[Expr, Expr]:
    """Return the output's position and its rate."""
    body, point, direction = bodies.machine.aim
    if point is None:
        return bodies.angle(bodies.spanning_tree.group[body]), bodies.spin(body)
    aim = bodies.mechanism.aim
    path, axis = bodies.path_to(body, vector_of(point, aim.point)), vector_of(direction, aim.direction)
    velocity = bodies.velocity(path)
    return bodies.position(path).dot(axis), velocity.dot(axis)
