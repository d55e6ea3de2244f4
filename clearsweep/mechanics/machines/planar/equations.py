"""The equations of a planar machine: its observables, and members of the families of `contract`."""

import operator

from ....tracing.compiled.family import known
from ....tracing.compiled.formulas import ONE, ZERO, Expr, Program, sum_of
from ...joints.dry import Gap
from ...joints.guide import GuideGap
from ...joints.mesh import MeshGap
from .. import contract
from ..programs import PlaneVector, generated, vector_sum
from .dynamics import impact_masses_of, link_signals_of, motion_of
from .form import STATIONS, Planar, evaluate_cycle
from .friction import FrictionMotion, accelerate_with_friction
from .kinematics import Bodies, vector_of
from .pose import pose_of
from .structure import ANGLE, FRICTION_LOADS, TRAVEL, Coordinate, MachineType, machine_type

# ---------------------------------------------------------------------------------------------- observables


@contract.gaps.member(Planar)
@generated(machine_type)
def gaps_of(machine: MachineType) -> Program:
    """Return the program of `contract.gaps`."""
    bodies = Bodies(machine)
    joint_gaps: list[Gap | GuideGap | MeshGap] = []
    for j in machine.open:
        if machine.sites[j].link.geared:
            joint_gaps.append(_mesh_gap(bodies, j))
            continue
        link, path = machine.sites[j].link, bodies.gap(j)
        position, velocity = bodies.position(path), bodies.velocity(path)
        if link.slides:
            joint_gaps.append(_guide_gap(bodies, j, position, velocity))
        else:
            joint, spin_at = bodies.joints[j], bodies.spin_at
            spins = spin_at(link.proximal, joint.near), spin_at(link.distal, joint.far)
            joint_gaps.append(Gap(*position, *velocity, *spins))
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


def _mesh_gap(bodies: Bodies, j: int) -> MeshGap:
    if bodies.machine.sites[j].guide is not None:
        travel, rate, axis = bodies.travel_along(bodies.machine.sites[j].guide, j)
        return MeshGap(travel, rate, ZERO, ZERO, *(-axis), *(ZERO,) * 6)
    mesh, site = bodies.mechanism.joints[j], bodies.machine.sites[j]
    shares = bodies.shares(j)
    twist = sum_of([*(share * bodies.angle(group) for group, share in shares), -mesh.rest])
    twist_rate = sum_of(share * bodies.rate[Coordinate(ANGLE, group)] for group, share in shares)
    x, v = mesh.arm * twist, mesh.arm * twist_rate
    if not site.pins:
        return MeshGap(x, v, *(ZERO,) * 10)
    (offset, velocity), axis = bodies.displacement_of_centres(j), bodies.line_of_centres(j)
    across = axis.left()
    x, v = x - mesh.across * across.dot(offset), v - mesh.across * across.dot(velocity)
    wider, widening = mesh.apart * axis.dot(offset), mesh.apart * axis.dot(velocity)
    turned = mesh.across * across.dot(offset) * (1.0 / sum_of([mesh.arm, mesh.arm * mesh.ratio]))  # the line of centres
    roll = bodies.angle_of(site.link.proximal) - bodies.angle_of(site.carrier) - turned
    rates = roll, bodies.spin(site.link.proximal) - bodies.spin(site.link.distal), *velocity
    return MeshGap(x, v, wider, widening, *(mesh.across * across), *(mesh.apart * axis), *rates)


@contract.energy.member(Planar)
@generated(machine_type)
def energy_of(machine: MachineType) -> Program:
    """Return the program of `contract.energy`."""
    bodies = Bodies(machine)
    twice_kinetic, vertical_momenta, bending_power = [], [], []
    for body in range(1, machine.bodies):
        mass, inertia = bodies.inertia_of(body)
        velocity, spin = bodies.velocity(bodies.path_to(body)), bodies.spin(body)
        if body in bodies.lines:
            line = bodies.lines[body]
            field = line.velocity(velocity, spin)
            twice_kinetic.append(mass * field.dot(field))
            for coordinate in line.kind.coordinates:
                rate = bodies.rate[coordinate]
                twice_kinetic.append(line.lumped_mass(coordinate) * (rate * rate))
                bending_power.append(-(line.tension(coordinate) * rate))
            velocity = line.mean(field)
        else:
            twice_kinetic += [mass * component * component for component in velocity]
        twice_kinetic.append(inertia * spin * spin)
        if body not in machine.housings:
            vertical_momenta.append(mass * velocity.y)
    kinetic, momentum = 0.5 * sum_of(twice_kinetic), sum_of(vertical_momenta)
    power = [-(bodies.mechanism.gravity * momentum)]
    for load in bodies.applied_loads():
        velocity = bodies.velocity(bodies.path_to(load.body, load.point))
        power += [*load.force.products(velocity), load.torque * bodies.spin_at(load.body, load.point)]
    for j in machine.sprung:
        power.append(-(bodies.tension(j) * bodies.rate[Coordinate(TRAVEL, j)]))
    return bodies.program.returns((kinetic, sum_of([*power, *bending_power])))


@contract.body_motions.member(Planar)
@generated(machine_type)
def body_motions_of(machine: MachineType) -> Program:
    """Return the program of `contract.body_motions`."""
    bodies, motions = Bodies(machine), []
    for body in range(1, machine.bodies):
        path, (mass, inertia) = bodies.path_to(body), bodies.inertia_of(body)
        spin, axis = bodies.spin(body), bodies.direction(body)
        position, velocity, momentum = bodies.position(path), bodies.velocity(path), inertia * spin
        if body in bodies.lines:
            line = bodies.lines[body]
            field, mean_position = line.velocity(velocity, spin), line.mean(line.position)
            momenta = [momentum, mass * line.mean_moment(field)]
            position, velocity = position + mean_position, line.mean(field)
            momentum = sum_of([*momenta, -(mass * mean_position.cross(velocity))])
        place = (*position, *velocity)
        weighs = ZERO if body in machine.housings else ONE
        motions.append(contract.BodyMotion(mass, momentum, *place, *(spin * axis.left()), *(-(spin * axis)), weighs))
    return bodies.program.returns(tuple(motions))


@contract.load_resultants.member(Planar)
@generated(machine_type)
def load_resultants_of(machine: MachineType) -> Program:
    """Return the program of `contract.load_resultants`."""
    bodies, resultants = Bodies(machine), []
    for i in range(len(machine.loads)):
        loads = [load for load in bodies.loads_of(i) if load.body]
        moments = [load.torque for load in loads]
        for load in loads:
            point = bodies.position(bodies.path_to(load.body, load.point))
            moments += [point.x * load.force.y, -(point.y * load.force.x)]
        force = vector_sum(load.force for load in loads)
        resultants.append((force.x, force.y, sum_of(moments)))
    return bodies.program.returns(tuple(resultants))


@generated(machine_type)
def histories_of(machine: MachineType) -> Program:
    """Return the program of the time histories that `contract.describe` returns, from a mechanism, pose and Motion."""
    bodies = Bodies(machine, 3)
    motion = bodies.program.parameters[2]
    position, velocity = _output_motion(bodies)
    crank_angle = bodies.angle(machine.spanning_tree.crank)
    values = [bodies.pose.time, crank_angle, motion.torque, position, velocity, motion.output]
    for masses in machine.whole_bodies:
        values += _centre_of_mass(bodies, masses)
        values += [bodies.angle(machine.spanning_tree.group[masses[0]]), bodies.spin(masses[0])]
        if masses[0] in bodies.lines:
            values += bodies.lines[masses[0]].histories()
        if masses[1:]:
            values.append(sum_of(bodies.travel[j] for j in machine.sprung if machine.sites[j].link.distal in masses))
    values += bodies.mount_motions()
    return bodies.program.returns(tuple(values))


def _centre_of_mass(bodies: Bodies, masses: tuple[int, ...]) -> list[Expr]:
    """Return position and velocity of the centre of mass of a body or of an elastic link's masses."""
    paths = [bodies.path_to(body) for body in masses]
    if masses[0] in bodies.lines:
        line, (path,) = bodies.lines[masses[0]], paths
        field = line.velocity(bodies.velocity(path), bodies.spin(masses[0]))
        return [*(bodies.position(path) + line.mean(line.position)), *line.mean(field)]
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
    bodies = Bodies(machine)
    sites = [(machine.sites[j].link, bodies.joints[j]) for j in machine.open]
    angles = [
        (bodies.angle_at(link.proximal, joint.near), bodies.angle_at(link.distal, joint.far)) for link, joint in sites
    ]
    return bodies.program.returns(tuple(angles))


@generated(machine_type)
def output_and_crank_of(machine: MachineType) -> Program:
    """Return the program of the output and the crank's angle, each with its rate, from a mechanism and its pose."""
    bodies, crank = Bodies(machine), machine.spanning_tree.crank
    position, rate = _output_motion(bodies)
    return bodies.program.returns((position, rate, bodies.angle(crank), bodies.spin(machine.crank)))


@generated(machine_type)
def crank_rate_of(machine: MachineType) -> Program:
    """Return the program of `contract.crank_rate`."""
    bodies = Bodies(machine)
    return bodies.program.returns(bodies.spin(machine.crank))


def _output_motion(bodies: Bodies) -> tuple[Expr, Expr]:
    """Return the output's position and its rate."""
    body, point, direction = bodies.machine.aim
    if point is None:
        return bodies.angle(bodies.spanning_tree.group[body]), bodies.spin(body)
    aim = bodies.mechanism.aim
    path, axis = bodies.path_to(body, bodies.point_of(body, point, aim.point)), vector_of(direction, aim.direction)
    velocity = bodies.velocity(path)
    return bodies.position(path).dot(axis), velocity.dot(axis)


# ---------------------------------------------------------------------------------------------- members of families


contract.pose_at.member(Planar)(pose_of)
contract.impact_masses.member(Planar)(impact_masses_of)
contract.crank_rate.member(Planar)(lambda mechanism, pose, nominal: crank_rate_of(mechanism, pose))
contract.gravity_of.member(Planar)(lambda mechanism: (0.0, -mechanism.gravity))
contract.body_angles.member(Planar)(lambda mechanism, y: body_angles_of(mechanism, pose_of(mechanism, y)))
contract.friction_slips.member(Planar)(
    lambda mechanism, motion: motion.slips if isinstance(motion, FrictionMotion) else ()
)
contract.friction_powers.member(Planar)(
    lambda mechanism, motion: motion.powers if isinstance(motion, FrictionMotion) else ()
)


@contract.accelerate.member(Planar)
def _accelerate_planar(mechanism, pose, loads):
    if contract.friction_laws(mechanism):
        return accelerate_with_friction(mechanism, pose, loads)
    return motion_of(mechanism, pose, loads)


@contract.link_signals.member(Planar)
def _link_signals_planar(mechanism, pose, loads, motion):
    return link_signals_of(mechanism, pose, loads, motion) if contract.link_signal_count(mechanism) else ()


@contract.link_signal_count.member(Planar)
@known
def _link_signal_count_planar(mechanism):
    machine = machine_type(mechanism)
    count = len(machine.housings) + sum(kind.modes + len(STATIONS) for kind in machine.bent.values())
    return 1 + count if count else 0


@contract.load_power.member(Planar)
def _load_power_planar(mechanism, motion):
    powers = contract.friction_powers(mechanism, motion)
    total = powers[0] if powers else 0.0
    for i in range(1, len(powers)):
        total = total + powers[i]
    return total


@contract.friction_laws.member(Planar)
@known
def _friction_laws_planar(mechanism):
    return tuple(load.friction for load in mechanism.loads if isinstance(load, FRICTION_LOADS))


@contract.with_friction_laws.member(Planar)
@known
def _with_friction_laws_planar(mechanism, laws):
    remaining = iter(laws)
    loads = (
        load._replace(friction=next(remaining)) if isinstance(load, FRICTION_LOADS) else load
        for load in mechanism.loads
    )
    return mechanism._replace(loads=tuple(loads))


@contract.output_error.member(Planar)
def _output_error_planar(mechanism, pose):
    output, output_rate, angle, rate = output_and_crank_of(mechanism, pose)
    ideal_output, slope = evaluate_cycle(mechanism.cycle, 0, angle)
    return output - ideal_output, output_rate - slope * rate


contract.describe.member(Planar)(lambda mechanism, y, pose, motion: histories_of(mechanism, pose, motion))
