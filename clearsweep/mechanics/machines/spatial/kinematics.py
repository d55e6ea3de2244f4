"""Generates the code for positions, velocities and observables of a tree's bodies."""

from ..planar.expressions import Expr, sum_of, tuple_code
from .expressions import NO_VECTOR, SpatialVector
from .form import AngleAim, Driven, Loose, Sleeve, Slide
from .machine_type import MachineType
from .tree_code import PosedTreeCode, TreeCode


def pose_code(tree: MachineType) -> str:
    """Return the code of the family member of that name."""
    tree_code, n = TreeCode(tree, "mechanism", "y"), tree.coordinates
    code = tree_code.code
    for body in range(1, len(tree.parts) + 1):
        _write_attitude(tree_code, body)
        _write_centre(tree_code, body)
    bodies = range(1, len(tree.parts) + 1)
    frames, spins, centres, velocities = (tuple_code(f"{letter}{body}" for body in bodies) for letter in "fwrv")
    quaternion_motions = tuple_code(f"t{body}" if tree.part(body).turns_freely else "()" for body in bodies)
    q, rates = tuple_code(f"y[{i}]" for i in range(n)), tuple_code(f"y[{n + i}]" for i in range(n))
    return code.function(
        "pose_at", f"Pose(angle, {q}, {rates}, {frames}, {spins}, {centres}, {velocities}, {quaternion_motions})"
    )


def _write_attitude(tree_code: TreeCode, body: int) -> None:
    """Write frame `f` and angular velocity `w` of a body, and its QuaternionMotion `t` if it has a quaternion."""
    tree, write, n = tree_code.tree, tree_code.code.write, tree_code.tree.coordinates
    part = tree.part(body)
    k, parent = part.coordinate, part.parent
    if part.form is Driven:
        write(f"angle = mechanism.speed * y[{2 * n}]")
        write("c1, s1 = direction(angle)")
        write(f"f{body} = on_ground(c1, s1)")
        write(f"w{body} = Vector(0.0, 0.0, mechanism.speed)")
    elif part.turns_freely:
        values = [f"y[{k + j}]" for j in range(4)] + [f"y[{n + k + j}]" for j in range(4)]
        write(f"t{body} = QuaternionMotion({', '.join(values)})")
        write(f"f{body} = frame_of({', '.join(values[:4])})")
        write(f"w{body} = to_fixed_frame(f{body}, spin_of(t{body}))")
    elif part.form is Slide:
        write(f"f{body} = {f'f{parent}' if parent else 'on_ground(1.0, 0.0)'}")
        write(f"w{body} = {f'w{parent}' if parent else NO_VECTOR}")
    else:
        rotation_index = k + (part.form is Sleeve)
        write(f"c{body}, s{body} = direction(y[{rotation_index}])")
        write(f"f{body} = " + (f"turned_about_z(f{parent}, " if parent else "on_ground(") + f"c{body}, s{body})")
        rotation = tree_code.code.expression(f"y[{n + rotation_index}]") * tree_code.z_axis(parent)
        write(f"w{body} = {tree_code.vector(f'w{parent}') + rotation if parent else rotation}")


def _write_centre(tree_code: TreeCode, body: int) -> None:
    """Write position `r` and velocity `v` of a body's centre of mass."""
    tree, write, vector = tree_code.tree, tree_code.code.write, tree_code.vector
    part, n = tree.part(body), tree_code.tree.coordinates
    k, parent = part.coordinate, part.parent
    if part.form is Loose:
        write(f"r{body} = Vector(y[{k + 4}], y[{k + 5}], y[{k + 6}])")
        write(f"v{body} = Vector(y[{n + k + 4}], y[{n + k + 5}], y[{n + k + 6}])")
        return
    own_arm = tree_code.own_arm(body)
    arm = tree_code.near_arm(body) + tree_code.along_axis(body, f"y[{k}]")
    velocity = tree_code.along_axis(body, f"y[{n + k}]")
    if parent:
        write(f"r{body} = {vector(f'r{parent}') + arm + own_arm}")
        velocity = vector(f"v{parent}") + vector(f"w{parent}").cross(arm) + velocity
    else:
        write(f"r{body} = {arm + own_arm}")
    if parent or part.form is not Slide:
        velocity += vector(f"w{body}").cross(own_arm)
    write(f"v{body} = {velocity}")


def gaps_code(tree: MachineType) -> str:
    """Return the code of the family member of that name."""
    tree_code, items = PosedTreeCode(tree, "mechanism", "pose"), []
    for j, (bearing, journal) in enumerate(tree.openings):
        opening = f"mechanism.openings[{j}]"
        bearing_position, bearing_velocity = _point_motion(tree_code, bearing, f"{opening}.at_bearing")
        journal_position, journal_velocity = _point_motion(tree_code, journal, f"{opening}.at_journal")
        observed = (
            journal_position - bearing_position,
            journal_velocity - bearing_velocity,
            tree_code.to_fixed_frame(bearing, tree_code.vector(f"{opening}.axis")),
            tree_code.spin(bearing),
            tree_code.spin(journal),
        )
        in_journal = ", ".join(str(tree_code.to_body_frame(journal, vector)) for vector in observed)
        items.append(f"SpatialGap({in_journal}, {tree_code.frame(journal)})")
    return tree_code.code.function("gaps", tuple_code(items))


def _point_motion(tree_code: PosedTreeCode, body: int, point: str) -> tuple[SpatialVector, SpatialVector]:
    """Return position and velocity of a point of a body."""
    arm = tree_code.arm(body, point)
    return tree_code.centre(body) + arm, tree_code.velocity(body) + tree_code.spin(body).cross(arm)


def bearing_axes_code(tree: MachineType) -> str:
    """Return the code of a function of a pose: the bearings' own x axes in the frames of the journals."""
    tree_code = PosedTreeCode(tree, "mechanism", "pose")
    axes = [
        str(
            tree_code.to_body_frame(
                journal, tree_code.to_fixed_frame(bearing, tree_code.vector(f"mechanism.openings[{j}].across"))
            )
        )
        for j, (bearing, journal) in enumerate(tree.openings)
    ]
    return tree_code.code.function("bearing_axes", tuple_code(axes))


def energy_code(tree: MachineType) -> str:
    """Return the code of the family member of that name."""
    tree_code, twice_kinetic, gravity_powers = PosedTreeCode(tree, "mechanism", "pose"), [], []
    for body in range(1, len(tree.parts) + 1):
        part, velocity = f"mechanism.parts[{body - 1}]", tree_code.velocity(body)
        mass, inertia = tree_code.code.expression(f"{part}.mass"), tree_code.vector(f"{part}.inertia")
        spin = tree_code.to_body_frame(body, tree_code.spin(body))
        twice_kinetic += [mass * velocity.dot(velocity), spin.dot(inertia.componentwise(spin))]
        gravity_powers.append(mass * velocity.dot(tree_code.vector("mechanism.gravity")))
    return tree_code.code.function("energy", f"{0.5 * sum_of(twice_kinetic)}, {sum_of(gravity_powers)}")


def describe_code(tree: MachineType) -> str:
    """Return the code of the family member of that name."""
    tree_code = PosedTreeCode(tree, "mechanism", "y", "pose", "motion", "out")
    output, rate = output_motion(tree_code)
    values = [f"y[{2 * tree.coordinates}]", "pose.angle", "motion.torque", output, rate, "motion.output"]
    for body in tree.reported:
        position, velocity, spin = tree_code.centre(body), tree_code.velocity(body), tree_code.spin(body)
        values += [vector[axis] for vector in (position, velocity) for axis in range(3)]
        values += [f"{tree_code.code.assign(_quaternion_code(tree, body))}[{k}]" for k in range(4)]
        values += [spin[axis] for axis in range(3)]
    for i, value in enumerate(values):
        tree_code.code.write(f"out[{i}] = {value}")
    return tree_code.code.function("describe", str(len(values)))


def _quaternion_code(tree: MachineType, body: int) -> str:
    """Return the code of a body's unit quaternion; for an attached body, from its rotation about its own z axis."""
    part = tree.part(body)
    if part.turns_freely:
        return f"quaternion_of(pose.quaternion_motions[{body - 1}])"
    parent_quaternion = _quaternion_code(tree, part.parent) if part.parent else "(1.0, 0.0, 0.0, 0.0)"
    if part.form is Slide:
        return parent_quaternion
    rotation = "pose.angle" if part.form is Driven else f"pose.q[{part.coordinate + (part.form is Sleeve)}]"
    return f"turned_quaternion({parent_quaternion}, {rotation})"


def output_motion(tree_code: PosedTreeCode) -> tuple[Expr, Expr]:
    """Return the output's position and its rate."""
    tree, body, expression = tree_code.tree, tree_code.tree.aimed, tree_code.code.expression
    if tree.aim is AngleAim:
        angles, rates = [], []
        while body:
            part = tree.part(body)
            if part.form is Driven:
                angles.append(expression("pose.angle"))
                rates.append(expression("mechanism.speed"))
            elif part.form is not Slide:
                rotation_index = part.coordinate + (part.form is Sleeve)
                angles.append(expression(f"pose.q[{rotation_index}]"))
                rates.append(expression(f"pose.rates[{rotation_index}]"))
            body = part.parent
        return sum_of(angles), sum_of(rates)
    position, velocity = _point_motion(tree_code, body, "mechanism.aim.point")
    direction = tree_code.vector("mechanism.aim.direction")
    return direction.dot(position), direction.dot(velocity)


def output_code(tree: MachineType) -> str:
    """Return the code of a function of a pose: position and rate of the output."""
    tree_code = PosedTreeCode(tree, "mechanism", "pose")
    position, rate = output_motion(tree_code)
    return tree_code.code.function("output", f"{position}, {rate}")
