"""Elastic links as chains of masses: each segment of a uniform bar is a spring between two of them.

The masses are at the ends of the segments (m / 2n at the ends of the bar, m / n between them), the springs have n
times the stiffness of the bar: the lumped bar of Craig & Kurdila 2006, "Fundamentals of Structural Dynamics", 2nd
ed., section 9.1.  All masses rotate together, so mass, centre of mass and moment of inertia of the link are as given
without stretch: the difference from the masses on the line is distributed evenly.
"""

import math

import numpy as np

from ....contracts.machine import Body, BodyPoint, Elastic, Machine, Stretch


def with_segments(machine: Machine) -> Machine:
    """Return a machine with every elastic link replaced by a chain of masses."""
    links = {name: body.elastic for name, body in machine.bodies.items() if body.elastic}
    if not links:
        return machine
    bodies: dict[str, Body] = {}
    stretches: list[Stretch] = []
    for name, body in machine.bodies.items():
        bodies |= _chain(name, body, body.elastic) if body.elastic else {name: body}
        stretches += _springs(name, body, body.elastic) if body.elastic else []

    def moved_endpoint(endpoint: BodyPoint) -> BodyPoint:
        elastic = links.get(endpoint.body)
        return (
            BodyPoint(mass_name(endpoint.body, elastic.segments), endpoint.point)
            if elastic and endpoint.point == elastic.far
            else endpoint
        )

    joints = tuple(
        joint._replace(proximal=moved_endpoint(joint.proximal), distal=moved_endpoint(joint.distal))
        for joint in machine.joints
    )
    start = {
        body_name: angle
        for name, angle in machine.start.items()
        for body_name in ([mass_name(name, i) for i in range(links[name].segments + 1)] if name in links else [name])
    }
    loads = tuple(
        load._replace(
            **{
                field: moved_endpoint(getattr(load, field))
                for field in ("at", "first", "second")
                if hasattr(load, field)
            }
        )
        for load in machine.loads
    )
    aim = machine.aim
    if aim.point:
        aim = aim._replace(body=moved_endpoint(BodyPoint(aim.body, aim.point)).body)
    return machine._replace(bodies=bodies, joints=(*joints, *stretches), start=start, loads=loads, aim=aim)


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
