"""Where journals, blocks and flanks are at the start of a run: as given, carried from a case, random, or seated."""

import itertools
import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from ...contracts.case import STOPS_SUFFIX, Case
from ...contracts.machine import Machine
from ...language.errors import InputError
from ...language.wording import quantity_text
from ...mechanics.joints.contract import contact_modes, every_contact
from ...mechanics.joints.guide import Guide as GuideTerm
from ...mechanics.joints.guide import deepest_corner
from ...mechanics.joints.mesh import COAST, DRIVE, Mesh
from ...mechanics.joints.rolling import Rolling, cage_angle, element_approaches, static_position
from ...mechanics.joints.slot import SlotJoint, WornSlot
from ...mechanics.joints.slot import normal_of as slot_normal_of
from ...mechanics.joints.worn import with_body_angles
from ...mechanics.laws.elastic import static_penetration
from ...mechanics.machines import planar
from ...mechanics.machines.contract import Built, body_angles, gaps, pose_at
from ...mechanics.machines.spatial.build import initial_seats

BRANCHES = ("carried", "random")  # starts that are placed here

ITERATIONS = 20  # of Newton's method, which needs four
PLACED = 1e-13  # of the machine's size: largest distance of a journal from where it should be
DIFFERENCE = 1e-5  # of the machine's size: displacement for a derivative


class Carried(NamedTuple):
    """The end of a case, in units that another case shares: clearances, and clearances times crank speed."""

    places: np.ndarray  # (k,) of the open joints: x and y of a journal, or the position of flanks along their normal
    rates: np.ndarray  # (k,) of these places
    roots: np.ndarray  # (contacts,) of penetration, over roots of the clearance
    internal: np.ndarray  # (i,) internal state of laws, in its own units
    latched: np.ndarray  # (contacts + l,) rates of onset, in the units of `rates`, then those of laws, in their own
    mode: np.ndarray  # (contacts,)


def random_places(seed: int, draw: int, flanked: Sequence[bool]) -> tuple[np.ndarray, np.ndarray]:
    """Return random places (k,) of the open joints in clearances, and rates (k,) in clearances times crank speed.

    A journal is anywhere in its clearance circle with equal probability, flanks anywhere in their play; rates have the
    same distribution.  The numbers depend on seed and draw alone.  `flanked` says which joints are gears or couplings.
    """
    generator = np.random.default_rng([int(seed), int(draw)])
    places, rates = list[float](), list[float]()
    for has_flanks, values in itertools.product(flanked, (places, rates)):
        if has_flanks:
            values.append(float(generator.uniform(-1.0, 1.0)))
        else:
            radius, angle = math.sqrt(generator.uniform()), generator.uniform(0.0, 2.0 * math.pi)
            values += [radius * math.cos(angle), radius * math.sin(angle)]
    return np.array(places), np.array(rates)


def with_places(case: Case, built: Built, joints: tuple, earlier_end: Carried | None) -> Built:
    """Return a mechanism that starts where another case ended, or at random; the first of a chain starts centred.

    Raises InputError if more moves freely than the joints with clearance.
    """
    units = units_of(joints)
    if len(units) != len(built.lengths):
        raise InputError(
            f"simulate.start: {case.simulate.start} places {len(units)} coordinates of joints with clearance, and this "
            f"machine has {len(built.lengths)}; leave out mechanism.mounts and links that bend, or use centred"
        )
    if earlier_end is None and case.simulate.start == "carried":
        return built
    flanked = [bool(joint.flanked) for joint in case.joints]
    places, rates = random_places(case.simulate.seed, case.simulate.draw, flanked)
    if earlier_end is not None:
        places, rates = earlier_end.places, earlier_end.rates
    return built._replace(start=placed(built, units * places, units * abs(built.rate) * rates))


def latched_of(earlier_end: Carried, joints: tuple, built: Built) -> list[float]:
    """Return the numbers that change only at events, as Work has them: those of contacts in m/s."""
    contacts, latched = contact_units(joints), earlier_end.latched.copy()
    latched[: len(contacts)] *= contacts * abs(built.rate)
    return latched.tolist()  # type: ignore[no-any-return]


def units_of(joints: tuple) -> np.ndarray:
    """Return the clearance (m) of each place of the open joints, (k,)."""
    return np.array([joint.clearance for joint in joints for _ in range(1 if isinstance(joint, Mesh) else 2)])


def places_of(built: Built, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the places (k,) m of the open joints at a state, and their rates (k,) m/s."""
    relative = gaps(built.value, pose_at(built.value, y))
    places = [place for gap in relative for place in ((gap.x,) if hasattr(gap, "wider") else (gap.x, gap.y))]
    rates = [rate for gap in relative for rate in ((gap.v,) if hasattr(gap, "wider") else (gap.vx, gap.vy))]
    return np.array(places, float), np.array(rates, float)


def contact_units(joints: tuple) -> np.ndarray:
    """Return the clearance (m) of the joint of each contact, (contacts,)."""
    return np.array([joint.clearance for joint in joints for _ in contact_modes(joint)])


def placed(built: Built, places: np.ndarray, rates: np.ndarray) -> np.ndarray:
    """Return the initial state (2n + 1,) with the open joints at `places` (m) and with `rates` (m/s).

    The state of `built` is the first guess of Newton's method.  Raises InputError if the machine has no such state.
    """
    y, count = built.start.copy(), len(built.lengths)
    for _ in range(ITERATIONS):
        missing = places - places_of(built, y)[0]
        if np.max(np.abs(missing)) <= PLACED * built.size:
            break
        steps = DIFFERENCE * built.size / built.lengths
        y[:count] += _solution(_slopes(built, y, steps, 0), missing, built.lengths)
    else:
        raise InputError("simulate.start: the bodies cannot have these places in their joints; use centred")
    y[count : 2 * count] += _solution(
        _slopes(built, y, built.rate * built.size / built.lengths, 1), rates - places_of(built, y)[1], built.lengths
    )
    return y


def _slopes(built: Built, y: np.ndarray, steps: np.ndarray, order: int) -> np.ndarray:
    """Return the derivatives of places (`order` 0) or rates (1) by the coordinates or their rates, (k, n)."""
    columns = []
    for index, step in enumerate(steps):
        forward, backward = y.copy(), y.copy()
        forward[index + order * len(steps)] += step
        backward[index + order * len(steps)] -= step
        columns.append((places_of(built, forward)[order] - places_of(built, backward)[order]) / (2.0 * step))
    return np.stack(columns, -1)


def _solution(slopes: np.ndarray, missing: np.ndarray, lengths: np.ndarray) -> np.ndarray:
    """Return the least change of the coordinates, measured by `lengths` (m per unit), that adds what is missing."""
    solution: Any = np.linalg.lstsq(slopes / lengths, missing, rcond=None)[0]
    return solution / lengths  # type: ignore[no-any-return]


SLOT_ROUNDING = 1e-9  # of its length: rounding of a stroke that just fits
TOUCHING = 1e-14  # of the mechanism's size: rounding of the penetration of bodies that touch at the start
LARGEST_TWIST = 0.1  # rad, by which flanks may overlap at the start: more is an angle of another tooth


def with_elements_at_start(case: Case, built: Built, terms: tuple, depth_roots: np.ndarray) -> tuple[tuple, np.ndarray]:
    """Return the joints with the phases of rolling bearings, and the roots of penetrations with those of elements.

    The first element of a bearing starts where the grid says.
    """
    phased, roots, first = list(terms), depth_roots.copy(), 0
    relative = with_body_angles(
        terms, gaps(built.value, pose_at(built.value, built.start)), body_angles(built.value, built.start)
    )
    for index, (term, joint, gap) in enumerate(zip(terms, case.joints, relative, strict=True)):
        count = len(contact_modes(term))
        if joint.rolling:
            angle, side = joint.rolling.phase, term.side
            phased[index] = term._replace(phase=angle - float(cage_angle(term, gap) - term.phase))
            approaches = element_approaches(term, side * gap.x, side * gap.y, angle)
            touching = np.where(approaches > TOUCHING * built.size, approaches, 0.0)
            roots[first : first + joint.rolling.elements] = np.sqrt(touching)
        first += count
    return tuple(phased), roots


def check_spatial_start(built: Built, joints: Mapping[str, Any]) -> None:
    """Raise InputError if a spatial journal starts outside its bearing or penetrates it."""
    for name, contact in initial_seats(built, joints).items():
        if contact.overlap <= 0.0:
            raise InputError(
                f"joints.{name}: the journal is {-1e3 * contact.overlap:.6g} mm outside its bearing along the axis at "
                "the start; reduce offset.2, or give bearing or journal more length"
            )
        if contact.depth > 0.0:
            raise InputError(
                f"joints.{name}: the journal penetrates its bearing by {1e6 * contact.depth:.6g} um at the start; "
                "reduce tilt or offset, or widen the clearances"
            )


def check_planar_start(built: Built, joints: Mapping[str, Any]) -> None:
    """Raise InputError if the bodies of a planar joint penetrate at the start."""
    relative = gaps(built.value, pose_at(built.value, built.start))
    for (name, joint), gap in zip(joints.items(), relative, strict=True):
        if isinstance(joint, GuideTerm):
            depth = deepest_corner(joint, gap)
        elif isinstance(joint, Rolling):
            approaches = element_approaches(joint, joint.side * gap.x, joint.side * gap.y, joint.phase)
            depth = float(approaches.max()) + min(joint.radial_clearance, 0.0)
        elif isinstance(joint, (SlotJoint, WornSlot)):
            depth = slot_normal_of(joint, gap).depth
        elif isinstance(joint, Mesh):
            continue
        else:
            depth = math.hypot(gap.x, gap.y) - joint.clearance
        if depth > TOUCHING * built.size:
            raise InputError(
                f"joints.{name}: its bodies penetrate each other by {1e6 * depth:.6g} um at the start; change "
                "`initial` of a body that it joins, or widen the clearance"
            )


def press_flanks(built: Built, joints: Mapping[str, Any], depth_roots: np.ndarray) -> None:
    """Write the roots of the depths of flanks that touch at the start; raise InputError if they are far too deep."""
    relative, contact = gaps(built.value, pose_at(built.value, built.start)), 0
    for (name, joint), gap in zip(joints.items(), relative, strict=True):
        if isinstance(joint, Mesh):
            for side in (DRIVE, COAST):
                depth = side * (gap.x - joint.middle) - gap.wider - joint.reach
                if name.endswith(STOPS_SUFFIX) and depth > TOUCHING * built.size:
                    unit = "rad" if joint.arm_proximal else "m"
                    place, beyond = (quantity_text(value, unit, 4) for value in (gap.x, depth))
                    raise InputError(
                        f"joints.{name.removesuffix(STOPS_SUFFIX)}.stops.at: the joint starts at {place}, {beyond} "
                        "beyond a stop; move the stop, or change where the motion starts"
                    )
                if depth > LARGEST_TWIST * min(joint.arm_proximal, abs(joint.arm_distal)):
                    angles = quantity_text(gap.x / joint.arm_distal, "rad", 4)
                    raise InputError(
                        f"joints.{name}: its flanks overlap at the start, where the second body is {angles} from the "
                        "middle of the play; change `initial` of a body that it joins. The middle is where the "
                        "first angle plus ratio times the second is 0; in a coupling both angles are equal there"
                    )
                depth_roots[contact + (side == COAST)] = math.sqrt(max(depth, 0.0))
        contact += len(contact_modes(joint))


def check_slot_lengths(case: Case, machine: Machine) -> None:
    """Raise InputError if a drive of prescribed speed takes a pin beyond the ends of its slot; a free crank stops."""
    if case.outline.free:
        return
    for joint in case.joints:
        if joint.slot_length is None:
            continue
        travel = planar.slot_travel(machine, joint.name)
        reach = float(np.max(np.abs(travel), initial=0.0))
        if 2.0 * reach > (joint.slot_length + 2.0 * joint.clearance) * (1.0 + SLOT_ROUNDING):
            lengths = float(np.ptp(travel)), reach, 2.0 * reach, joint.slot_length
            stroke, reach_text, needed, given = (quantity_text(length, "m", 4) for length in lengths)
            raise InputError(
                f"joints.{joint.name}.slot_length: found {given}, but the pin's stroke is {stroke}, up to {reach_text} "
                f"from the slot's middle; write at least {needed}, or shorten the stroke"
            )


def seated_offsets(reactions: Mapping[str, np.ndarray], joints: Mapping[str, Any]) -> tuple[dict, np.ndarray]:
    """Return the initial offset (m) of each joint's distal pin and the roots of the penetrations.

    The pin is displaced along the load (N) of the ideal mechanism to static penetration; the roots of the elements of
    a rolling bearing are left 0.
    """
    offsets: dict[str, Any] = {}
    depth_roots, first = np.zeros(len(every_contact(joints.values()))), 0
    for name, joint in joints.items():
        first += len(contact_modes(joint))
        if name.endswith(STOPS_SUFFIX):
            offsets[name] = (0.0, 0.0)
            continue
        force = reactions[name]
        load = float(np.hypot(*force))
        if load == 0.0:
            raise InputError(f"simulate.start: seated needs a load, but {name} carries none at t = 0; use centred")
        if isinstance(joint, Rolling):
            offsets[name] = joint.side * np.array(static_position(joint, tuple(-joint.side * force), joint.phase))
        elif isinstance(joint, Mesh):  # its roots follow from the angles
            offsets[name] = (joint.clearance + static_penetration(joint.elastic, load)) * force / joint.arm_proximal
            offsets[name] /= load
        else:
            depth = static_penetration(joint.elastic, load)
            depth_roots[first - len(contact_modes(joint))] = math.sqrt(depth)
            offsets[name] = -(joint.clearance + depth) * force / load
    return offsets, depth_roots
