"""Elastic links of a case: values derived from stiffness, and what is doubtful in them."""

import math
from collections.abc import Iterator
from typing import NamedTuple

from ...contracts.case import Case
from ...contracts.machine import Body, Elastic, Machine
from ...mechanics.machines import planar
from .ideal import max_drive_speed, mechanism_of

STEEL_MODULUS = 210e9  # Pa; a softer metal needs a larger section, so steel bends most
#: Drive speed over first bending frequency at which dynamic bending exceeds static bending by 4 %.
BENDING_LIMIT = 0.2
BENT_RATIO = 0.5  # drive speed over the first bending rate, beyond which a link that bends leaves its model
MANY_MODES = 6
MASS_TOLERANCE = 0.1  # by which a mass may differ from that of section and density
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
    """Return the links of a case that are elastic along the line of their pins."""
    machine = _elastic_machine(case)
    bodies = machine.bodies.items() if machine else ()
    return tuple(
        _link(machine, name, body, body.elastic)
        for name, body in bodies
        if machine and body.elastic and body.elastic.segments
    )


class BendingLink(NamedTuple):
    """A link that bends."""

    name: str
    modes: int
    rate: float  # rad/s, first mode between pins
    ratio: float  # largest drive speed over this rate
    mass_ratio: float  # given mass over that of its section and density; nan: unknown


def bending_links(case: Case) -> tuple[BendingLink, ...]:
    """Return the links of a case that bend."""
    machine, links = _elastic_machine(case), []
    section = "bodies." if case.outline.bodies else ""
    for name, body in machine.bodies.items() if machine else ():
        elastic = body.elastic
        if machine and elastic and elastic.bending:
            rate, length = planar.first_rate(body, elastic), planar.line_of(body, elastic).length
            density = case.mechanism.values.get(f"{section}{name}.elastic.density", math.nan)
            mass_ratio = body.mass / (density * elastic.bending.area * length)
            links.append(BendingLink(name, elastic.bending.modes, rate, max_drive_speed(machine) / rate, mass_ratio))
    return tuple(links)


def _elastic_machine(case: Case) -> Machine | None:
    """Return the planar machine of a case with elastic links, else None."""
    mechanism = mechanism_of(case)
    if mechanism.machine is None or not case.outline.elastic:
        return None
    machine: Machine = mechanism.machine(case)
    return machine


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
        0.0 if elastic.bending else max_drive_speed(machine) / first_bending,
        tuple(joint.name for joint in machine.joints if pins & {tuple(joint.proximal), tuple(joint.distal)}),
    )


def link_warnings(case: Case) -> list[str]:
    """Return warnings on elastic links: single springs, bending that would matter, or that exceeds its model."""
    bodies = "mechanism.bodies" if case.outline.bodies else "mechanism"
    return [
        *(f"{bodies}.{link.name}.elastic{text}" for link in bending_links(case) for text in _bending_warnings(link)),
        *(f"{bodies}.{link.name}.elastic{text}" for link in elastic_links(case) for text in _axial_warnings(link)),
    ]


def _axial_warnings(link: ElasticLink) -> Iterator[str]:
    """Yield what is doubtful in a link that is elastic along its line."""
    if link.segments == 1:
        yield (
            ".segments: a single spring between two masses is no bar; peaks of impacts err by up to 27 % in a steel "
            "rod, and by more in a softer one; use 4 or more"
        )
    if link.bending > BENDING_LIMIT:
        yield (
            f": the drive turns at {link.bending:.2g} of the first bending mode of a round steel bar of this "
            f"stiffness. Above {BENDING_LIMIT:g} bending matters, but the model neglects it; use a shorter or thicker "
            "link, or let it bend"
        )


def _bending_warnings(link: BendingLink) -> Iterator[str]:
    """Yield what is doubtful in a link that bends."""
    if link.ratio > BENT_RATIO:
        yield (
            f": the drive turns at {link.ratio:.2g} of the first bending rate; above {BENT_RATIO:g} the deflections "
            "leave the second-order model; use a shorter or thicker link"
        )
    if link.modes > MANY_MODES:
        yield (
            f".bending: {link.modes} modes are more than {MANY_MODES}; the highest ones make every step short, and the "
            "model neglects shear and rotary inertia, which matter to them; 2 or 3 are enough"
        )
    if abs(link.mass_ratio - 1.0) > MASS_TOLERANCE:
        yield (
            f".density: the mass is {link.mass_ratio:.3g} times that of the section with this density; the given mass "
            "counts, evenly distributed over the length"
        )
