"""Generates the code for positions, velocities and observables of a tree's bodies."""

from ..planar.writer import number, tupled
from .form import AngleAim, Driven, Loose, Sleeve, Slide
from .machine_type import MachineType
from .writer import AXES, ZERO, Posed, Writer


def place(tree: MachineType) -> str:
    """Return the code of the family member of that name."""
    write, n = Writer(tree, "mechanism", "y"), tree.coordinates
    lines = write.lines
    for i, part in enumerate(tree.parts):
        body, k, p = i + 1, part.coordinate, part.parent
        orientation = "()"
        if part.form is Driven:
            lines.text.append(f"angle = mechanism.speed * y[{2 * n}]")
            lines.text.append("c1, s1 = direction(angle)")
            lines.text.append(f"f{body} = on_ground(c1, s1)")
            lines.text.append(f"w{body} = Vector(0.0, 0.0, mechanism.speed)")
        elif part.turns_freely:
            values = [f"y[{k + j}]" for j in range(4)] + [f"y[{n + k + j}]" for j in range(4)]
            orientation = f"Turning({', '.join(values)})"
            lines.text.append(f"t{body} = {orientation}")
            lines.text.append(f"f{body} = frame_of({', '.join(values[:4])})")
            lines.text.append(f"w{body} = in_fixed(f{body}, spin_of(t{body}))")
        elif part.form is Slide:
            lines.text.append(f"f{body} = {f'f{p}' if p else 'on_ground(1.0, 0.0)'}")
            lines.text.append(f"w{body} = {f'w{p}' if p else ZERO}")
        else:
            turn = k + (part.form is Sleeve)
            lines.text.append(f"c{body}, s{body} = direction(y[{turn}])")
            frame = f"turned_about_z(f{p}, c{body}, s{body})" if p else f"on_ground(c{body}, s{body})"
            lines.text.append(f"f{body} = {frame}")
            spin = f"times(y[{n + turn}], {write.z_of(p)})"
            lines.text.append(f"w{body} = {f'plus(w{p}, {spin})' if p else spin}")
        _put_center(write, body)
    bodies = range(1, len(tree.parts) + 1)
    parts = [tupled([f"{letter}{body}" for body in bodies]) for letter in "fwrv"]
    turnings = tupled([f"t{body}" if tree.part(body).turns_freely else "()" for body in bodies])
    q, rates = tupled([f"y[{i}]" for i in range(n)]), tupled([f"y[{n + i}]" for i in range(n)])
    return lines.function("place", f"Pose(angle, {q}, {rates}, {', '.join(parts)}, {turnings})")


def _put_center(write: Writer, body: int) -> None:
    """Write position and velocity of a body's centre of mass."""
    tree, lines = write.tree, write.lines
    part, n = tree.part(body), tree.coordinates
    k, p = part.coordinate, part.parent
    if part.form is Loose:
        lines.text.append(f"r{body} = Vector(y[{k + 4}], y[{k + 5}], y[{k + 6}])")
        lines.text.append(f"v{body} = Vector(y[{n + k + 4}], y[{n + k + 5}], y[{n + k + 6}])")
        return
    near_end, own_values = write.near(body), write.own(body)
    shift, rising = write.shift(body, f"y[{k}]"), write.shift(body, f"y[{n + k}]")
    arm_to_body = write.all_of(near_end, shift)
    lines.text.append(f"r{body} = {write.all_of(f'r{p}' if p else None, arm_to_body, own_values)}")
    at_hinge = write.all_of(f"v{p}", write.cross(f"w{p}", arm_to_body)) if p else None
    turned = None if part.form is Slide and not p else write.cross(f"w{body}", own_values)
    velocity = write.all_of(at_hinge, rising, turned)
    lines.text.append(f"v{body} = {velocity}")


def gaps(tree: MachineType) -> str:
    """Return the code of the family member of that name."""
    write, terms = Posed(tree, "mechanism", "pose"), []
    for j, (bearing, journal) in enumerate(tree.openings):
        site, frame = f"mechanism.openings[{j}]", write.frame(journal)
        arms = [write.arm(body, f"{site}.{name}") for body, name in ((bearing, "at_bearing"), (journal, "at_journal"))]
        places = [write.all_of(write.at(body), arm) for body, arm in zip((bearing, journal), arms, strict=True)]
        velocities = [
            write.all_of(write.velocity(body), write.cross(write.spin(body), arm))
            for body, arm in zip((bearing, journal), arms, strict=True)
        ]
        distance, velocity = (write.difference(*pair[::-1]) for pair in (places, velocities))
        observed = (
            distance,
            velocity,
            write.fixed(bearing, f"{site}.axis"),
            *(write.spin(b) or ZERO for b in (bearing, journal)),
        )
        terms.append(f"SpatialGap({', '.join(f'in_body({frame}, {vector})' for vector in observed)}, {frame})")
    return write.lines.function("gaps", tupled(terms))


def across(tree: MachineType) -> str:
    """Return the code of a function of a pose: the bearings' own x axes in the frames of the journals."""
    write = Posed(tree, "mechanism", "pose")
    speeds = [
        f"in_body({write.frame(journal)}, {write.fixed(bearing, f'mechanism.openings[{j}].across')})"
        for j, (bearing, journal) in enumerate(tree.openings)
    ]
    return write.lines.function("across", tupled(speeds))


def energy(tree: MachineType) -> str:
    """Return the code of the family member of that name."""
    write, doubled, falling = Posed(tree, "mechanism", "pose"), [], []
    for body in range(1, len(tree.parts) + 1):
        part_path, velocity = f"mechanism.parts[{body - 1}]", write.velocity(body)
        spin = write.let(f"in_body({write.frame(body)}, {write.spin(body)})")
        doubled += [
            f"{part_path}.mass * dot({velocity}, {velocity})",
            f"dot({spin}, elementwise_product({part_path}.inertia, {spin}))",
        ]
        falling.append(f"{part_path}.mass * dot({velocity}, mechanism.gravity)")
    return write.lines.function("energy", f"0.5 * ({' + '.join(doubled)}), {' + '.join(falling)}")


def describe(tree: MachineType) -> str:
    """Return the code of the family member of that name."""
    write = Posed(tree, "mechanism", "y", "pose", "motion", "out")
    output, rate = aim(write)
    values = [f"y[{2 * tree.coordinates}]", "pose.angle", "motion.torque", output, rate, "motion.output"]
    for body in tree.reported:
        position, velocity, spin = write.at(body), write.velocity(body), write.spin(body)
        values += [f"{vector}.{axis}" for vector in (position, velocity) for axis in AXES]
        values += [f"{write.let(_quaternion(write, body))}[{k}]" for k in range(4)]
        values += [f"{spin}.{axis}" for axis in AXES]
    for i, name in enumerate(values):
        write.lines.text.append(f"out[{i}] = {number(name)}")
    return write.lines.function("describe", str(len(values)))


def _quaternion(write: Writer, body: int) -> str:
    """Return the unit quaternion of a body; for an attached body, from its rotation about its own z axis."""
    part = write.tree.part(body)
    if part.turns_freely:
        return f"quaternion_of(pose.turnings[{body - 1}])"
    parent_quaternion = _quaternion(write, part.parent) if part.parent else "(1.0, 0.0, 0.0, 0.0)"
    if part.form is Slide:
        return parent_quaternion
    turn = "pose.angle" if part.form is Driven else f"pose.q[{part.coordinate + (part.form is Sleeve)}]"
    return f"turned_quaternion({parent_quaternion}, {turn})"


def aim(write: Posed) -> tuple[str | None, str | None]:
    """Return the output's position and its rate."""
    tree, body = write.tree, write.tree.aimed
    if tree.aim is AngleAim:
        angles = {"q": [], "rates": []}
        while body:
            part = tree.part(body)
            if part.form is Driven:
                angles["q"].append("pose.angle")
                angles["rates"].append("mechanism.speed")
            elif part.form is not Slide:
                for name, terms in angles.items():
                    terms.append(f"pose.{name}[{part.coordinate + (part.form is Sleeve)}]")
            body = part.parent
        return tuple(" + ".join(terms) for terms in angles.values())
    arm = write.arm(body, "mechanism.aim.at")
    position = write.all_of(write.at(body), arm)
    velocity = write.all_of(write.velocity(body), write.cross(write.spin(body), arm))
    return write.let(f"dot(mechanism.aim.direction, {position})"), write.let(
        f"dot(mechanism.aim.direction, {velocity})"
    )


def output(tree: MachineType) -> str:
    """Return the code of a function of a pose: place and rate of the output."""
    write = Posed(tree, "mechanism", "pose")
    return write.lines.function("output", ", ".join(map(number, aim(write))))
