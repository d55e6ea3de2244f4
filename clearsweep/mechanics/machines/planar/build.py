"""Builds planar machines: rigid bodies with revolute and prismatic joints in any topology, each joint ideal or open."""

import itertools
import math
from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

import numpy as np

from ....contracts.case import housing_name
from ....contracts.catalogue import Channel
from ....contracts.machine import (
    GROUND,
    Aim,
    Body,
    BodyPoint,
    Constant,
    Elastic,
    Machine,
    Mesh,
    Motor,
    Path,
    Pin,
    Schedule,
    Spring,
    Stops,
    Stretch,
    TabledPush,
    ends_of,
)
from ...joints.contract import Load
from ..contract import Built, IdealMotion, Open, has_finite_accelerations
from ..contract import Ideal as Closed
from ..programs import kinds_of, shared_by
from . import equations  # noqa: F401 - registers the equations of motion
from . import form as planar_form
from .closure import FIRST_STATIONS, STATIONS, ClosureError, MobilityError, extent
from .drives import compile_drive, drive_motion
from .dyads import assembly_of
from .ideal import IdealMachine, ideal_of, masses_of, rigid
from .load_forms import AngleTableLoad, TimeTableLoad, compile_table, discontinuity_times_of
from .loops import loop_jacobian
from .pose import pose_of
from .stations import geometry_of, initial_coordinate
from .structure import ANGLE, BEND, FRICTION_LOADS, INTEGRAL, TRAVEL, Coordinate, MachineType, machine_type

# ---------------------------------------------------------------------------------------------- elastic links

# Elastic links as chains of masses: each segment of a uniform bar is a spring between two of them.
#
# The masses are at the ends of the segments (m / 2n at the ends of the bar, m / n between them), the springs have n
# times the stiffness of the bar: the lumped bar of Craig & Kurdila 2006, "Fundamentals of Structural Dynamics", 2nd
# ed., section 9.1.  All masses rotate together, so mass, centre of mass and moment of inertia of the link are as given
# without stretch: the difference from the masses on the line is distributed evenly.


def with_segments(machine: Machine) -> Machine:
    """Return a machine with housings as bodies, and every elastic link that does not bend as a chain of masses."""
    machine = _with_housings(machine)
    links = {name: body.elastic for name, body in machine.bodies.items() if body.elastic and not body.elastic.bending}
    if not links:
        return machine
    bodies: dict[str, Body] = {}
    stretches: list[Stretch] = []
    for name, body in machine.bodies.items():
        bodies |= _chain(name, body, links[name]) if name in links else {name: body}
        stretches += _springs(name, body, links[name]) if name in links else []

    def moved_endpoint(endpoint: BodyPoint) -> BodyPoint:
        elastic = links.get(endpoint.body)
        return (
            BodyPoint(mass_name(endpoint.body, elastic.segments), endpoint.point)
            if elastic and endpoint.point == elastic.far
            else endpoint
        )

    def moved(record: Any) -> Any:
        return record._replace(**{field: moved_endpoint(end) for field, end in ends_of(record).items()})

    start = {
        body_name: angle
        for name, angle in machine.start.items()
        for body_name in ([mass_name(name, i) for i in range(links[name].segments + 1)] if name in links else [name])
    }
    joints, loads = tuple(map(moved, machine.joints)), tuple(map(moved, machine.loads))
    aim = machine.aim
    if aim.point:
        aim = aim._replace(body=moved_endpoint(BodyPoint(aim.body, aim.point)).body)
    return machine._replace(bodies=bodies, joints=(*joints, *stretches), start=start, loads=loads, aim=aim)


def _with_housings(machine: Machine) -> Machine:
    """Return a machine in which the ground's side of every mounted joint is on a housing.

    A carriage without mass slides along x on the ground, the housing along y on the carriage.
    """
    if not machine.mounts:
        return machine
    bodies, joints = dict(machine.bodies), {joint.name: joint for joint in machine.joints}
    springs: list[Stretch] = []
    for mount in machine.mounts:
        joint = joints[mount.joint]
        end = "proximal" if joint.proximal.body == GROUND else "distal"
        under = getattr(joint, end)
        place = machine.bodies[GROUND].points[under.point]
        for axis, mass, angle, stiffness, damping in zip(
            "xy", (0.0, mount.mass), (0.0, 0.5 * math.pi), mount.stiffness, mount.damping, strict=True
        ):
            name = housing_name(mount.joint, axis)
            bodies[name] = Body(mass, 0.0, place, {under.point: place}, mounted=True)
            above = BodyPoint(name, under.point)
            springs.append(Stretch(name, under, above, angle, stiffness, damping))
            under = above
        for name, other in joints.items():
            if (other.proximal, other.distal) == (joint.proximal, joint.distal):  # the joint, or its stops
                joints[name] = other._replace(**{end: under})
    return machine._replace(bodies=bodies, joints=(*joints.values(), *springs), mounts=())


def mass_name(link: str, i: int) -> str:
    """Return the name of mass number `i` of a link; the first one has the link's own."""
    return f"{link}~{i}" if i else link


def axial_rate(body: Body) -> float:
    """Return the angular frequency (rad/s) of the first axial mode of a link with free ends."""
    assert body.elastic is not None  # only elastic links
    return math.pi * math.sqrt(body.elastic.stiffness / body.mass)


def _line(body: Body, elastic: Elastic) -> tuple[np.ndarray, np.ndarray]:
    """Return the first point of the line (m, in the frame of the link) and the vector to its second point."""
    near_end, far_end = (np.array(body.points[point]) for point in (elastic.near, elastic.far))
    return near_end, far_end - near_end


def _chain(name: str, body: Body, elastic: Elastic) -> dict[str, Body]:
    """Return the masses of a link by name."""
    (near_end, direction), count = _line(body, elastic), elastic.segments
    mass_fractions = np.full(count + 1, 1.0 / count)
    mass_fractions[[0, -1]] *= 0.5
    line_centre = near_end + 0.5 * direction
    centre_offset = np.array(body.center) - line_centre  # of the centre of mass
    positions = [near_end + direction * (i / count) + centre_offset for i in range(count + 1)]
    moment = math.fsum(
        mass_fraction * body.mass * float(np.sum((position - body.center) ** 2))
        for mass_fraction, position in zip(mass_fractions, positions, strict=True)
    )
    inertia = float(body.inertia - moment) / (count + 1)  # may be negative: the masses rotate together
    joints = {f"~{i}": tuple(map(float, near_end + direction * (i / count))) for i in range(1, count + 1)}
    points = {**body.points, **joints}
    return {
        mass_name(name, i): Body(
            float(mass_fraction) * body.mass, inertia, (float(position[0]), float(position[1])), points
        )
        for i, (mass_fraction, position) in enumerate(zip(mass_fractions, positions, strict=True))
    }


def _springs(name: str, body: Body, elastic: Elastic) -> list[Stretch]:
    """Return the springs of a link."""
    _, direction = _line(body, elastic)
    stiffness = elastic.segments * elastic.stiffness
    damping = stiffness * 2.0 * elastic.damping / axial_rate(body)
    axis = math.atan2(direction[1], direction[0])
    return [
        Stretch(
            f"{name}~{i}",
            BodyPoint(mass_name(name, i - 1), f"~{i}"),
            BodyPoint(mass_name(name, i), f"~{i}"),
            axis,
            stiffness,
            damping,
        )
        for i in range(1, elastic.segments + 1)
    ]


# ---------------------------------------------------------------------------------------------- dependent coordinates


NEAR_SINGULAR = 1e-7  # least singular value over the largest: a change point, where no choice is better
EXAMINED_ANGLES = 36  # crank angles that are examined
EXAMINED_SIDES = 12  # crank angles at which the sides of dyads are


def choose_dependent(
    value: planar_form.Planar, machine: MachineType, profiles: list, is_closed: np.ndarray
) -> list[int]:
    """Return the indices of the coordinates that, taken as dependent, keep the loops furthest from singular.

    value : a machine without dependent coordinates; profiles : (values, slopes, ...) of each coordinate at
    equidistant angles over a revolution of the ideal machine; is_closed : mask of the angles that count.
    """
    from scipy.linalg import qr

    if not machine.free:
        value = value._replace(drive=Constant(1.0, value.cycle.start))
    jacobians_at_angles = []
    closed_angles = np.flatnonzero(is_closed[:-1])
    for k in closed_angles[:: max(len(closed_angles) // EXAMINED_ANGLES, 1)].tolist():
        time = 2.0 * np.pi * k / (len(profiles[0][0]) - 1)
        y = np.array([*(profile[0][k] for profile in profiles), *(0.0 for _ in profiles), time])
        jacobians_at_angles.append(np.array(loop_jacobian(value, pose_of(value, y))))
    jacobians = np.array(jacobians_at_angles)
    fixed_coordinates = {
        Coordinate(ANGLE, machine.spanning_tree.crank),
        *(Coordinate(TRAVEL, j) for j in machine.sprung),
        *(coordinate for kind in machine.bent.values() for coordinate in kind.coordinates),
    }
    candidates = [
        i for i, coordinate in enumerate(machine.spanning_tree.coordinates) if coordinate not in fixed_coordinates
    ]
    scale = np.max(np.abs(jacobians), axis=(0, 2), keepdims=True)
    jacobians = (jacobians / scale)[:, :, candidates]
    singular_values = np.linalg.svd(jacobians, compute_uv=False)
    jacobians = jacobians[singular_values[:, -1] > NEAR_SINGULAR * singular_values[:, 0]]  # not at change points
    jacobians /= np.maximum(np.max(np.abs(jacobians), axis=(0, 1)), 1e-300)
    count = jacobians.shape[1]
    choices = {tuple(sorted(qr(angle_jacobian, mode="r", pivoting=True)[1][:count])) for angle_jacobian in jacobians}
    if len(candidates) <= 8:
        choices |= set(itertools.combinations(range(len(candidates)), count))

    def smallest_singular_value(choice: tuple) -> float:
        return float(np.min(np.linalg.svd(jacobians[:, :, list(choice)], compute_uv=False)[:, -1]))

    return sorted(candidates[i] for i in max(sorted(choices), key=smallest_singular_value))


# ---------------------------------------------------------------------------------------------- the compiled form


def mount_channels(joints: Iterable[str]) -> tuple[Channel, ...]:
    """Return the time histories of the housings of `joints`."""
    return tuple(
        Channel(
            f"joints/{joint.replace('-', '_')}/mount_{axis}", "m", f"displacement of the housing of {joint}, {axis}"
        )
        for joint in joints
        for axis in "xy"
    )


def build(machine: Machine, joints: Mapping, offsets: Mapping) -> Built:
    """Return the compiled form of a machine and its initial state.

    joints : compiled form of each joint with clearance, by name; offsets : (2,) m, of the distal point of each from the
    proximal one at the start, without relative velocity.  Raises ClosureError, MobilityError.
    """
    if problem := planar_form.problem_of_links(machine):
        raise MobilityError(": ".join(problem))
    machine = with_segments(machine)
    ideal_machine, names = ideal_of(machine), frozenset(joints)
    if names not in ideal_machine.compiled_by_open_joints:
        ideal_machine.compiled_by_open_joints[names] = _compile(machine, names)
    compiled = ideal_machine.compiled_by_open_joints[names]
    if compiled.form.dependent and ideal_machine.is_near_change_point(0):
        raise _refused_start(ideal_machine)
    if compiled.massless:
        names_text = ", ".join(compiled.massless)
        raise MobilityError(
            f"with these joints open, these bodies move without mass or moment of inertia: {names_text}"
        )
    displaced = any(map(any, offsets.values()))
    start = _initial_state(ideal_machine, compiled.state, offsets) if displaced else compiled.start
    return Built(compiled.form, start, compiled.lengths, ideal_machine.closure.size, ideal_machine.reference_rate())


def _refused_start(ideal_machine: IdealMachine) -> ClosureError:
    """Return why a machine whose loops are closed cannot start at a change point, and where it can start."""
    start, body = ideal_machine.machine.drive.start_angle, ideal_machine.closure.names[0]
    text = "it would start in a singular position, where its loops may go on in more than one way"
    stations = range(0, STATIONS, STATIONS // FIRST_STATIONS)
    elsewhere = next(station for station in stations if not ideal_machine.is_near_change_point(station))
    degrees = math.degrees(start) + 360.0 * elsewhere / STATIONS
    return ClosureError(text, body, start, f"start elsewhere, such as with drive.start_angle {degrees:.6g} deg")


def ideal(machine: Machine, at, *, over_time: bool = False) -> IdealMotion:
    """Return the motion of the output and the reactions without clearance at angles (rad, any shape) of the crank.

    over_time : `at` are times (s), of a crank that may turn back
    """
    shape, ideal_machine = np.shape(at), ideal_of(machine)
    places = np.asarray(at, dtype=float).ravel()
    motion = ideal_machine.motion(places, lambda: ideal_form(ideal_machine), over_time=over_time)
    reactions = {name: force.reshape((*shape, 2)) for name, force in motion.reactions.items()}
    torque = np.reshape(motion.torque, shape)
    return IdealMotion(*(np.reshape(array, shape) for array in motion[:3]), reactions, torque)


def ideal_reactions(machine: Machine, at: np.ndarray, *, over_time: bool = False) -> dict[str, np.ndarray]:
    """Return the force (N, 2) N on each joint's distal body without clearance at angles (N,) rad of the crank.

    over_time : as for `ideal`
    """
    ideal_machine = ideal_of(machine)
    return ideal_machine.reactions(at, lambda: ideal_form(ideal_machine), over_time=over_time)


def ideal_form(ideal_machine: IdealMachine) -> planar_form.Planar:
    """Return the compiled form of a machine without clearance."""
    return _compiled_form(rigid(ideal_machine.machine), frozenset())


class _Compiled(NamedTuple):
    """A compiled machine with some of its joints open, for any clearances and laws: cases of a sweep share it."""

    form: planar_form.Planar
    state: list[Coordinate]
    lengths: np.ndarray  # m, as in Built
    start: np.ndarray  # as in Built, with zero offsets
    massless: list[str]  # moving bodies without mass or inertia


def _compile(machine: Machine, open_joints: frozenset[str]) -> _Compiled:
    """Return the compiled form of a machine with open joints of these names, and its coordinates."""
    form = _compiled_form(machine, open_joints)
    state = machine_type(form).state
    start = _initial_state(ideal_of(machine), state, {})
    lengths = np.array([_length_per_unit(machine, coordinate) for coordinate in state])
    if state and state[-1].kind == INTEGRAL:  # as far as the servo's stiffness lets the crank turn
        lengths[-1] = lengths[0] * ideal_of(machine).reference_rate() / machine.drive.servo.stiffness
    return _Compiled(form, state, lengths, start, _massless_bodies(machine, form, start))


def _compiled_form(machine: Machine, open_joints: frozenset[str]) -> planar_form.Planar:
    """Return the compiled form of a machine with open joints of these names."""
    ideal_machine, form = ideal_of(machine), _independent_form(machine, open_joints)
    structure = machine_type(form)
    coordinates = [
        ideal_machine.coordinate_over_revolution(coordinate) for coordinate in structure.spanning_tree.coordinates
    ]
    output = ideal_machine.output_over_revolution()
    form = form._replace(cycle=planar_form.make_cycle([output], machine.drive.start_angle))
    dependent = _dependent_indices(ideal_machine, form, coordinates) if structure.spanning_tree.loop_joints else ()
    form = form._replace(dependent=tuple(map(planar_form.as_empty_tuples, dependent)))
    columns, kind = [output, *(coordinates[i] for i in dependent)], planar_form.Cycle
    if ideal_machine.change_points and dependent:
        slopes = [coordinates[i][1:] for i in dependent]
        columns += [(*slope, np.gradient(slope[1], ideal_machine.revolution.angles, edge_order=2)) for slope in slopes]
        kind = planar_form.BranchingCycle
    elif dependent:
        form = form._replace(sides=_sides(ideal_machine, form, coordinates))
    return form._replace(cycle=planar_form.make_cycle([*columns], machine.drive.start_angle, kind))


@shared_by(lambda ideal_machine, form, _: (geometry_of(ideal_machine.full_machine), kinds_of(form)))
def _dependent_indices(ideal_machine: IdealMachine, form: planar_form.Planar, coordinates: list) -> tuple[int, ...]:
    """Return the indices of the dependent coordinates: machines that differ in masses and loads share them."""
    is_closed = ideal_machine.stations.is_closed
    return tuple(choose_dependent(form, machine_type(form), coordinates, is_closed))


@shared_by(lambda ideal_machine, form, _: (geometry_of(ideal_machine.full_machine), kinds_of(form)))
def _sides(ideal_machine: IdealMachine, form: planar_form.Planar, coordinates: list) -> tuple[float, ...]:
    """Return the sides of the dyads that close the loops; () unless dyads close them on the same sides all along."""
    stations, values = np.flatnonzero(ideal_machine.stations.is_closed[:-1]), [column[0] for column in coordinates]
    if not machine_type(form).free:
        values = [ideal_machine.revolution.angles, *values]
    examined = stations[:: max(len(stations) // EXAMINED_SIDES, 1)].tolist()
    positions = [tuple(float(value[k]) for value in values) for k in examined]
    sines = [[cross / math.sqrt(square) for cross, square in assembly_of(form, position)] for position in positions]
    sides = np.sign(sines[0])
    return tuple(sides.tolist()) if np.all(sines * sides > NEAR_SINGULAR) else ()


def _has_finite_accelerations(form: planar_form.Planar, start: np.ndarray) -> bool:
    """Return whether all accelerations at the initial state are finite."""
    no_loads = tuple(Load(0.0, 0.0, 0.0, 0.0, ()) for site in form.sites if isinstance(site, Open))
    return has_finite_accelerations(form, start, no_loads)


def _check_spring_directions(machine: Machine, form: planar_form.Planar, start: np.ndarray) -> None:
    """Raise MobilityError if a spring with a free length has no direction at the start: its ends coincide."""
    without_free_lengths = tuple(
        load._replace(free_length=0.0) if isinstance(load, Spring) else load for load in form.loads
    )
    if not _has_finite_accelerations(form._replace(loads=without_free_lengths), start):
        return
    names = ", ".join(f"loads.{load.name}" for load in machine.loads if isinstance(load, Spring) and load.free_length)
    raise MobilityError(
        f"the ends of a spring coincide at the start, so the direction of its force is unknown: {names}; move its "
        "anchor or its point, or write free_length: 0"
    )


def _massless_bodies(machine: Machine, form: planar_form.Planar, start: np.ndarray) -> list[str]:
    """Return the moving bodies without mass or moment of inertia, or [] if all accelerations are finite."""
    if _has_finite_accelerations(form, start):
        return []
    _check_spring_directions(machine, form, start)
    moving_bodies = _moving_names(machine)
    return [
        name for name in moving_bodies if 0.0 in (machine.bodies[name].mass, machine.bodies[name].inertia)
    ] or moving_bodies


def _initial_state(ideal_machine: IdealMachine, state: list[Coordinate], offsets: Mapping) -> np.ndarray:
    """Return the initial state (2n+1,): n coordinates (m or rad), their rates, time (s).

    offsets : as for `build`; if there are any, elastic links are extended by the forces of the ideal motion.  Raises
    ClosureError if the joints cannot be displaced by them.
    """
    machine, angle = ideal_machine.full_machine, ideal_machine.machine.drive.start_angle
    speed = crank_speed(machine)
    extensions = ideal_machine.static_extensions(angle, speed) if offsets and ideal_machine.closure.springs else {}
    displaced_state = ideal_machine.displaced_states({**offsets, **extensions}, angle)
    if not np.all(np.isfinite(displaced_state.q)):
        raise ClosureError("its joints cannot have the specified initial distances", _moving_names(machine)[0], angle)
    values = [ideal_machine.coordinate(coordinate, displaced_state) for coordinate in state]
    coordinates, rates = [float(value[0]) for value, _ in values], [speed * float(slope[0]) for _, slope in values]
    for i, coordinate in enumerate(state):
        initial = (
            None
            if coordinate.kind in (TRAVEL, BEND, INTEGRAL)
            else machine.bodies[_moving_names(machine)[coordinate.owner - 1]].initial
        )
        if initial is not None:
            coordinates[i], rates[i] = initial_coordinate(initial, coordinate.kind)
    return np.array([*coordinates, *rates, 0.0])


def crank_speed(machine: Machine) -> float:
    """Return the initial speed (rad/s) of the crank."""
    if isinstance(machine.drive, Motor):
        return machine.drive.initial_speed
    return drive_motion(compile_drive(machine.drive), 0.0)[1]


def discontinuity_times(machine: Machine) -> list[float]:
    """Return the times (s) at which an acceleration or the slope of a load jumps, where steps should end."""
    times = {time for load in machine.loads for time in discontinuity_times_of(load)}
    drive = machine.drive.servo.target if isinstance(machine.drive, Motor) and machine.drive.servo else machine.drive
    if isinstance(drive, (Schedule, Path)):
        times |= set(map(float, drive.times))
    return sorted(time for time in times if time > 0.0)


def _independent_form(machine: Machine, open_joints: frozenset[str]) -> planar_form.Planar:
    """Return the compiled form with open joints of these names, without dependent coordinates."""
    numbers = {name: planar_form.as_empty_tuples(i) for i, name in enumerate([GROUND, *_moving_names(machine)])}
    names = [joint.name for joint in machine.joints]

    def located(end: BodyPoint) -> Any:
        return BodyPoint(numbers[end.body], _compile_point(machine, end))

    def joint_number(name: str) -> tuple:
        return planar_form.as_empty_tuples(names.index(name))

    def numbered(record: Any, **replacements: Any) -> Any:
        """Return a joint or a load without its name, with its ends and further fields replaced."""
        ends = {field: located(end) for field, end in ends_of(record).items()}
        return record._replace(name=(), **ends, **replacements)

    def compiled_joint(joint: Any) -> Any:
        if isinstance(joint, Stops) and joint.guide:
            return numbered(joint, guide=joint_number(joint.guide))
        if isinstance(joint, Stops):  # as a gear: the angle of the distal body minus the other one
            return compiled_joint(Mesh("", joint.distal, joint.proximal, GROUND, -1.0))
        if isinstance(joint, Mesh):
            return numbered(
                joint,
                carrier=numbers[joint.carrier],
                centres=_compile_direction(joint.centres) if joint.pins else (),
                pins=tuple(map(joint_number, joint.pins)),
                eccentricities=tuple(itertools.starmap(planar_form.compile_point, joint.eccentricities)),
                teeth=(),
                approach=(),
            )
        return numbered(joint) if isinstance(joint, Pin) else numbered(joint, axis=_compile_direction(joint.axis))

    def compiled_load(load: Any) -> Any:
        if isinstance(load, TabledPush):
            table_type = AngleTableLoad if load.over == "angle" else TimeTableLoad
            return table_type(located(load.at), compile_table(load))
        is_friction = isinstance(load, FRICTION_LOADS)
        return numbered(load, joint=joint_number(load.joint)) if is_friction else numbered(load)

    crank = next(joint.distal.body for joint in machine.joints if joint.name == machine.driven)
    aim, point, direction = machine.aim, (), ()
    if aim.point:
        point, direction = _compile_point(machine, BodyPoint(aim.body, aim.point)), _compile_direction(aim.direction)
    return planar_form.Planar(
        bodies=tuple(masses_of(machine)),
        joints=tuple(map(compiled_joint, machine.joints)),
        sites=tuple(Open() if name in open_joints else Closed() for name in names),
        dependent=(),
        crank=numbers[crank],
        drive=compile_drive(machine.drive),
        gravity=machine.gravity,
        loads=tuple(map(compiled_load, machine.loads)),
        aim=Aim(numbers[aim.body], point, direction),
        cycle=(),
    )


def _moving_names(machine: Machine) -> list[str]:
    return [name for name in machine.bodies if name != GROUND]


def _compile_point(machine: Machine, endpoint: BodyPoint) -> tuple:
    body = machine.bodies[endpoint.body]
    center = (0.0, 0.0) if endpoint.body == GROUND else body.center
    place, elastic = body.points[endpoint.point], body.elastic
    if elastic and elastic.bending:
        return planar_form.compile_bent_point(body, elastic, elastic.bending, place)
    x, y = np.subtract(place, center)
    return planar_form.compile_point(float(x), float(y))


def _compile_direction(angle: float) -> tuple:
    return planar_form.compile_direction(math.cos(angle), math.sin(angle))


def _length_per_unit(machine: Machine, coordinate: Coordinate) -> float:
    """Return the displacement (m) of bodies for a unit of a coordinate; a point is as large as the machine."""
    if coordinate.kind != ANGLE:  # a link deflects by a unit where the shape of a mode is largest
        return 1.0
    body = _moving_names(machine)[coordinate.owner - 1]
    arms = [
        abs(arm)
        for mesh in machine.joints
        if isinstance(mesh, Mesh)
        for end, arm in ((mesh.proximal, mesh.arm), (mesh.distal, mesh.arm * mesh.ratio))
        if end.body == body
    ]
    return max([extent(machine.bodies[body]), *arms]) or ideal_of(machine).closure.size
