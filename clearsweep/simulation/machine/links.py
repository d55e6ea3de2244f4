"""Elastic links of a case: values derived from stiffness, and whether the neglected bending would matter."""

import math
from typing import NamedTuple

from ...contracts.case import Case
from ...contracts.machine import Body, Constant, Elastic, Machine, Motor, Schedule
from .ideal import mechanism_of

STEEL_MODULUS = 210e9  # Pa; a softer metal needs a larger section, so steel bends most
#: Drive speed over first bending frequency at which dynamic bending exceeds static bending by 4 %.
BENDING_LIMIT = 0.2
#: Segments that a wave front has to cross for an error of the peak below 3 % (table in docs/model.md), where the peak
#: is below or above FRONT_SHARE of that of the front.
SEGMENTS_OF_FRONT, SEGMENTS_OF_RINGING_FRONT, FRONT_SHARE = 1.7, 4.0, 0.65


class ElasticLink(NamedTuple):
    """A link that is elastic along the line of its pins."""

    name: str
    stiffness: float  # N/m, E A / l
    segments: int
    first_mode: float  # rad/s, axial, both ends free: pi sqrt(k / m)
    impedance: float  # N s/m, wave impedance at a pin: sqrt(k m)
    bending: float  # largest drive speed over the first bending frequency of a round steel bar of this stiffness
    joints: tuple[str, ...]  # at its two pins


def elastic_links(case: Case) -> tuple[ElasticLink, ...]:
    """Return the elastic links of a case."""
    mechanism = mechanism_of(case)
    if mechanism.machine is None or not case.outline.elastic:
        return ()
    machine = mechanism.machine(case)
    return tuple(_link(machine, name, body, body.elastic) for name, body in machine.bodies.items() if body.elastic)


def segments_to_resolve(link: ElasticLink, peak: float, depth: float, rate: float) -> int:
    """Return the number of segments that an impact at a link's pin needs: peak (N), depth (m) and approach (m/s).

    A wave front is as long as the rise of the contact, depth / rate.  Where the peak is that of the front, impedance x
    rate, the masses behind it ring, and it has to cross more segments.
    """
    front = depth / rate * link.stiffness / link.impedance  # length over that of the link
    is_peak_of_front = peak > FRONT_SHARE * link.impedance * rate
    return math.ceil((SEGMENTS_OF_RINGING_FRONT if is_peak_of_front else SEGMENTS_OF_FRONT) / front)


def _link(machine: Machine, name: str, body: Body, elastic: Elastic) -> ElasticLink:
    length = math.dist(body.points[elastic.near], body.points[elastic.far])
    speed_of_sound = length * math.sqrt(elastic.stiffness / body.mass)
    diameter = math.sqrt(4.0 * elastic.stiffness * length / (math.pi * STEEL_MODULUS))
    first_bending = math.pi**2 * speed_of_sound * diameter / (4.0 * length**2)  # see `Elastic links` in docs/model.md
    pins = {(name, elastic.near), (name, elastic.far)}
    return ElasticLink(
        name,
        elastic.stiffness,
        elastic.segments,
        math.pi * math.sqrt(elastic.stiffness / body.mass),
        math.sqrt(elastic.stiffness * body.mass),
        max_drive_speed(machine) / first_bending,
        tuple(joint.name for joint in machine.joints if pins & {tuple(joint.proximal), tuple(joint.distal)}),
    )


def max_drive_speed(machine: Machine) -> float:
    """Return the largest speed (rad/s) of a drive; for a free crank under constant torque, its initial speed."""
    drive = machine.drive
    if isinstance(drive, Constant):
        return abs(drive.speed)
    if isinstance(drive, Schedule):
        return float(max(abs(drive.speeds)))
    assert isinstance(drive, Motor)  # the only other drive
    return max(abs(speed) for speed in (drive.initial_speed, drive.no_load_speed) if math.isfinite(speed))


def warnings(case: Case) -> list[str]:
    """Return a warning for each elastic link that is a single spring or whose bending would matter."""
    links, bodies = elastic_links(case), "mechanism.bodies" if case.outline.bodies else "mechanism"
    return [
        f"{bodies}.{link.name}.elastic.segments: a single spring between two masses is no bar; peaks of impacts err by "
        "up to 27 % in a steel rod, and by more in a softer one; use 4 or more"
        for link in links
        if link.segments == 1
    ] + [
        f"{bodies}.{link.name}.elastic: the drive turns at "
        f"{link.bending:.2g} of the first bending mode of a round steel bar of this stiffness. Above "
        f"{BENDING_LIMIT:g} bending matters, but the model neglects it; use a shorter or thicker link"
        for link in links
        if link.bending > BENDING_LIMIT
    ]
