"""A rolling bearing with internal clearance: a ring of balls or rollers between the journal and the bearing.

Everything is in the plane of the rings.  Element i is at the angle

    phi_i = phi_0 + 2 pi i / Z + cage angle,   cage angle = (1 - g) / 2 x angle of the inner ring
                                                           + (1 + g) / 2 x angle of the outer ring,

with g the diameter of an element over the pitch diameter: pure rolling at a contact angle of 0 (Harris & Kotzalas 2006,
Rolling Bearing Analysis, 5th ed., chapter 10).  The inner ring is on the body of the journal.  Its displacement (x, y)
closes the gap at an element by x cos phi_i + y sin phi_i - s / 2, with s the radial internal clearance between the
extreme positions, as catalogues give it.  A negative s is a preload.

The elastic force of an element is that of its contacts at both rings in series.  Of a ball they are Hertz's elliptical
contacts, of a roller the line contacts of ISO/TS 16281.  Each element is a contact of its own, whose onset and
separation are located.  By virtual work the force Q_i also turns the rings, by the shares above of Q_i times the
displacement across phi_i: so the forces on both bodies are in balance about any point, and their power is that of the
closing.

Two auxiliary contacts follow, which only report: the resultant of the elements, and the rings.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from ...tracing import portable
from ...tracing.compiled import calculus
from ...tracing.compiled.choosing import direction, rough_cube_root, where
from ...tracing.compiled.dual import as_type_of, plain
from ...tracing.compiled.family import family, inlined
from ..laws.contract import ACTS, FREE, PRESSED, REPORTING
from ..laws.elastic import Power, PowerThreeHalves
from ..laws.friction import friction_force
from ..wear.bins import never_wears
from . import contract
from .dry import Clip, load_on_journal, normal_forces, reported_contact, separate_contact
from .worn import bodies_of, gap_with_angles, with_angles

FATIGUE_FORCE = 1e3  # N, unit of the forces whose powers are summed
LEAST_SCALE = 1e-4  # of an element's diameter: least length in which displacements are measured
SOLVER_STEPS, SOLVER_TOLERANCE = 500, 1e-14  # of the static position; relative to the load


class Element(NamedTuple):
    """The direction of an element at a cage angle of 0."""

    cosine: float
    sine: float


class Rolling(NamedTuple):
    """A rolling bearing between two bodies."""

    clearance: float  # m, the length in which displacements are measured: half the internal clearance if large enough
    side: float  # +1: the journal, and so the inner ring, sits on the distal body
    radial_clearance: float  # m, half the radial internal clearance; negative with a preload
    inner_share: float  # turns of the cage for a turn of the inner ring
    outer_share: float  # and for a turn of the outer ring
    phase: float  # rad, angle of the first element where the angles of both rings are 0
    friction_radius: float  # m, at which the friction of the whole bearing acts
    law: tuple  # contact_force, of each element
    elastic: tuple  # elastic_force
    friction: tuple  # friction_force, of the resultant
    elements: tuple  # of Element; their number is part of the type


class Cage(NamedTuple):
    """Motion of the inner ring relative to the outer one, and of the cage."""

    x: float  # m, displacement of the inner ring
    y: float  # m
    vx: float  # m/s
    vy: float  # m/s
    cosine: float  # of the angle of the cage
    sine: float
    rate: float  # rad/s, of the cage
    speed: float  # rad/s, of the inner ring relative to the outer one
    approach_bound: float  # m/s, that no closing exceeds


class ElementLoad(NamedTuple):
    """The force of an element."""

    fx: float  # N, on the inner ring
    fy: float
    moment: float  # N m, of the closing by the angle of the cage: its shares turn the rings
    loaded: float  # 1, or 0 where the element is free
    inner_fatigue: float  # see `fatigue_loads`
    outer_fatigue: float
    contact: contract.Contact


Rings = NamedTuple("Rings", [*contract.CONTACT_FIELDS, ("inner", float), ("outer", float)])
Rings.__doc__ = """What is observed of both rings.

normal : rad/s, size of their relative speed; depth : number of loaded elements; inner, outer : rad/s, relative speed
times the fatigue loads of that ring, see `fatigue_loads`.
"""


contract.power_stored.member(Rings)(lambda rings: rings.inner)
contract.power_lost.member(Rings)(lambda rings: rings.outer)
with_angles.member(Rolling)(gap_with_angles)


@contract.contact_modes.member(Rolling)
def _contact_modes_rolling(joint):
    elements = (contract.ContactModes(FREE, PRESSED),) * len(joint.elements)
    return *elements, contract.ContactModes(ACTS, ACTS), contract.ContactModes(REPORTING, REPORTING)


@contract.parts.member(Rolling)
def _parts_rolling(joint):
    count = len(joint.elements)
    every_part = [contract.Part(law, i) for i in range(count) for law in (Clip(), joint.law)]
    return *every_part, contract.Part(joint.friction, count)


# ---------------------------------------------------------------------------------------------- motion


@inlined
def cage_angle(joint, gap):
    """Return the angle (rad) of the first element in the fixed frame, from the GapWithAngles of the bearing."""
    outer, inner, _, _ = bodies_of(joint, gap)
    return joint.phase + joint.inner_share * inner + joint.outer_share * outer


@inlined
def cage_motion(joint, gap):
    """Return the Cage of a bearing from its GapWithAngles."""
    _, _, outer_spin, inner_spin = bodies_of(joint, gap)
    x, y, vx, vy = joint.side * gap.x, joint.side * gap.y, joint.side * gap.vx, joint.side * gap.vy
    cosine, sine = direction(cage_angle(joint, gap))
    rate = joint.inner_share * inner_spin + joint.outer_share * outer_spin
    return Cage(
        x=x,
        y=y,
        vx=vx,
        vy=vy,
        cosine=cosine,
        sine=sine,
        rate=rate,
        speed=inner_spin - outer_spin,
        approach_bound=abs(vx) + abs(vy) + (abs(x) + abs(y)) * abs(rate),
    )


# ---------------------------------------------------------------------------------------------- forces


@family
def fatigue_loads(elastic, force):
    """Return the force (in FATIGUE_FORCE) of an element to the powers by which its load counts for both rings.

    Inner ring, then outer: 3 and 10/3 for a point contact, 4 and 9/2 for a line contact (ISO/TS 16281:2008, mean loads
    of a ring that turns relative to the load and of one at rest).
    """


@fatigue_loads.member(PowerThreeHalves)
def _fatigue_loads_of_ball(elastic, force):
    positive = plain(where(force > 0.0, force, 1.0))
    cube, root = force * force * force, rough_cube_root(positive)
    for _ in (1, 2, 3):  # of Halley's method, to rounding
        root_cube = root * root * root
        root = root * (root_cube + 2.0 * positive) / (2.0 * root_cube + positive)
    return cube, cube * root


@fatigue_loads.member(Power)
def _fatigue_loads_of_roller(elastic, force):
    fourth = (force * force) * (force * force)
    return fourth, fourth * calculus.sqrt(force)


class _Normal(NamedTuple):
    """Direction of an element and its motion along it."""

    x: float  # unit vector
    y: float
    across: float  # m, displacement of the inner ring across it
    depth: float  # m
    rate: float  # m/s


@inlined
def _normal_of(element, joint, cage):
    nx = cage.cosine * element.cosine - cage.sine * element.sine
    ny = cage.sine * element.cosine + cage.cosine * element.sine
    across = cage.y * nx - cage.x * ny
    depth = cage.x * nx + cage.y * ny - joint.radial_clearance
    return _Normal(nx, ny, across, depth, cage.vx * nx + cage.vy * ny + across * cage.rate)


@inlined
def _element_load(element, number, joint, cage, offsets, state):
    index, zero = offsets.contact + number, as_type_of(0.0, cage.x)
    if state.mode[index] == FREE:
        normal = _normal_of(element, joint, cage)  # here and below: where nothing observes it, it takes no time
        contact = separate_contact(normal.depth, normal.rate, cage.approach_bound)
        return ElementLoad(zero, zero, zero, zero, zero, zero, contact)
    normal = _normal_of(element, joint, cage)
    law_offsets = contract.repeated_offsets(offsets, number, (joint.law,))
    current = joint._replace(law=contract.with_current_state(joint.law, state.y, state.latched, law_offsets))
    root, mode, onset_rate = state.y[state.roots + index], state.mode[index], state.latched[index]
    force, _, elastic, unclipped = normal_forces(current, mode, root * abs(root), normal.rate, onset_rate)
    contact = contract.Contact(
        normal=force, tangential=zero, slip=zero, rate=normal.rate, depth=normal.depth, elastic=elastic, raw=unclipped
    )
    fatigue = fatigue_loads(joint.elastic, max(force, 0.0) * (1.0 / FATIGUE_FORCE))
    loaded = as_type_of(1.0, cage.x)
    return ElementLoad(-force * normal.x, -force * normal.y, -force * normal.across, loaded, *fatigue, contact)


@contract.load.member(Rolling)
def _load_rolling(joint, gap, offsets, state):
    cage = cage_motion(joint, gap)
    loads = [_element_load(element, i, joint, cage, offsets, state) for i, element in enumerate(joint.elements)]
    zero = as_type_of(0.0, cage.x)
    fx, fy, moment, loaded, inner_fatigue, outer_fatigue, contacts = zero, zero, zero, zero, zero, zero, ()
    for i in range(len(joint.elements)):
        fx, fy, moment = fx + loads[i].fx, fy + loads[i].fy, moment + loads[i].moment
        loaded, contacts = loaded + loads[i].loaded, (*contacts, loads[i].contact)
        inner_fatigue, outer_fatigue = inner_fatigue + loads[i].inner_fatigue, outer_fatigue + loads[i].outer_fatigue
    square = fx * fx + fy * fy
    normal = where(square > 0.0, calculus.sqrt(where(square > 0.0, square, 1.0)), 0.0 * square)
    slip, speed = cage.speed * joint.friction_radius, abs(cage.speed)
    tangential = as_type_of(friction_force(joint.friction, normal, slip), slip)
    eccentricity = calculus.sqrt(cage.x * cage.x + cage.y * cage.y)
    resultant = reported_contact(normal, eccentricity - joint.clearance, zero)
    inner_moment = joint.inner_share * moment + joint.friction_radius * tangential
    outer_moment = joint.outer_share * moment - joint.friction_radius * tangential
    rings = Rings(*reported_contact(speed, loaded, zero)[:7], speed * inner_fatigue, speed * outer_fatigue)
    contacts = *contacts, resultant._replace(tangential=tangential, slip=slip), rings
    return load_on_journal(joint, fx, fy, (outer_moment, inner_moment), contacts)


# ---------------------------------------------------------------------------------------------- time histories


@contract.gap_histories.member(Rolling)
def _gap_histories_rolling(joint, gap, side):
    return side * gap.x, side * gap.y, side * gap.vx, side * gap.vy, cage_angle(joint, gap)


@contract.load_histories.member(Rolling)
def _load_histories_rolling(joint, load):
    count = len(joint.elements)
    values = load.contacts[count].normal, load.contacts[count].tangential
    for i in range(count):
        values = (*values, load.contacts[i].normal)
    return values


# ---------------------------------------------------------------------------------------------- statics


def element_directions(count: int) -> tuple[Element, ...]:
    """Return the Elements of a bearing, evenly spaced from the angle 0."""
    angles = [2.0 * math.pi * i / count for i in range(count)]
    return tuple(Element(math.cos(angle), math.sin(angle)) for angle in angles)


def directions_at(joint: Rolling, angle: Any) -> tuple[np.ndarray, np.ndarray]:
    """Return cosines and sines (..., Z) of the elements of a bearing whose first is at `angle` (...) rad."""
    cosine, sine = np.cos(np.asarray(angle))[..., None], np.sin(np.asarray(angle))[..., None]
    cosines, sines = np.array(joint.elements).T
    return cosine * cosines - sine * sines, sine * cosines + cosine * sines


def element_approaches(joint: Rolling, x: Any, y: Any, angle: Any) -> np.ndarray:
    """Return by how much the inner ring at (x, y) m closes the gap at each element, (..., Z) m; negative for a gap.

    x, y : (...) m, displacement of the inner ring from the outer one.  angle : (...) rad, of the first element.
    """
    cosines, sines = directions_at(joint, angle)
    approaches: np.ndarray = np.asarray(x)[..., None] * cosines + np.asarray(y)[..., None] * sines
    return approaches - joint.radial_clearance


def element_loads(joint: Rolling, x: Any, y: Any, angle: Any) -> np.ndarray:
    """Return the elastic force (..., Z) N of each element; arguments as in `element_approaches`."""
    elastic: Any = joint.elastic  # mypy takes it for a tuple of anything
    loads: np.ndarray = elastic.stiffness * np.maximum(element_approaches(joint, x, y, angle), 0.0) ** elastic.exponent
    return loads


def static_position(joint: Rolling, load: tuple[float, float], angle: float) -> tuple[float, float]:
    """Return the displacement (m) of the inner ring under a load (N) on it, with the first element at `angle` (rad).

    It minimises the elastic energy minus the work of the load, a convex function, by the method of Levenberg (1944,
    Quart. Appl. Math. 2:164), from where the elements carry the load along it.  Across the load it is 0 where no
    element determines it.
    """
    force = np.array(load)
    size = float(np.hypot(*force))
    unit = np.stack(directions_at(joint, angle), axis=-1)  # (Z, 2)
    elastic: Any = joint.elastic
    exponent = elastic.exponent

    def energy(position: np.ndarray) -> float:
        approaches = np.maximum(portable.product(unit, position) - joint.radial_clearance, 0.0)
        stored = elastic.stiffness / (exponent + 1.0) * np.sum(approaches ** (exponent + 1.0))
        return float(stored - portable.product(force, position))

    low, high, toward = 0.0, joint.clearance, force / size
    toward_elements = portable.product(unit, toward)
    while portable.product(element_loads(joint, *(high * toward), angle), toward_elements) < size:
        low, high = high, 2.0 * high
    for _ in range(60):
        middle = 0.5 * (low + high)
        is_short = portable.product(element_loads(joint, *(middle * toward), angle), toward_elements) < size
        low, high = (middle, high) if is_short else (low, middle)
    position = high * toward
    damping, least = 1e-3, energy(position)
    for _ in range(SOLVER_STEPS):
        approaches = np.maximum(portable.product(unit, position) - joint.radial_clearance, 0.0)
        residual = force - portable.product(elastic.stiffness * approaches**exponent, unit)
        if np.hypot(*residual) <= SOLVER_TOLERANCE * size:
            break
        rates = np.where(approaches > 0.0, elastic.stiffness * exponent * approaches ** (exponent - 1.0), 0.0)
        stiffness = portable.product((unit * rates[:, None]).T, unit)
        step = portable.solve(stiffness + damping * np.trace(stiffness) * np.eye(2), residual)
        reached = energy(position + step)
        if reached <= least + 1e-15 * abs(least):
            position, least, damping = position + step, reached, max(0.1 * damping, 1e-15)
        else:
            damping *= 10.0
    return float(position[0]), float(position[1])


never_wears(Rolling)
