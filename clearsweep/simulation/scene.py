"""From a case, names and numbers, to a scene, types and numbers: the only place where names become types."""

import math
from dataclasses import dataclass

import numpy as np

from .. import grid
from ..case import Case, Joint
from ..errors import InputError
from ..mechanics import rates
from ..mechanics.joint import dry, registry
from ..mechanics.joint.elastic.contract import elastic_force
from ..mechanics.joint.internal_state import memory
from ..mechanics.mechanism import ideal
from ..mechanics.mechanism import slider_crank as mechanisms
from ..mechanics.mechanism.slider_crank import COORDINATES, Links, Pair
from ..results import Layout

JOINTS = {"ground-crank": "A", "crank-rod": "B", "rod-slider": "C"}
_DISTAL = {"ground-crank": "crank", "crank-rod": "rod", "rod-slider": "slider"}
_WEAR_WARNING = 1e-2  # of coefficient times hardness


@dataclass(frozen=True)
class Scene:
    """A case made ready: its compiled form and where it starts."""

    case: Case
    value: rates.Scene
    layout: Layout
    start: np.ndarray  # (n,) initial state, see mechanics.rates
    in_contact: bool  # all joints begin in contact


def catalogue():
    """Return all laws that a grid can name."""
    return registry.catalogue()


def load_case(source, overrides: dict | None = None) -> Scene:
    """Return the scene of a grid without `sweep`: a path or a dict of the same shape.

    `overrides` maps dotted paths to values that replace those written.  Raises InputError.
    """
    loaded = grid.load(source, catalogue(), overrides)
    if len(loaded) != 1:
        raise InputError(
            f"{loaded.source or 'the grid'}: sweeps {', '.join(loaded.axes)}; expected one case: override the swept "
            "paths, or use clearsweep.sweep"
        )
    return build(loaded.case(0))


def build(case: Case) -> Scene:
    """Return the scene of a resolved case.  Raises InputError where it cannot start as asked."""
    layout = Layout.of(case)
    joints = tuple(map(_joint, case.joints))
    if case.mechanism.type == "impact-pair":
        return _pair_scene(case, layout, joints)
    open_joints = "".join(JOINTS[joint.name] for joint in case.joints)
    mechanism = getattr(mechanisms, f"Open{open_joints}")(_links(case))
    sigma = math.sqrt(min(joint.clearance for joint in joints))
    memories = _memories(joints)
    value = rates.Scene(mechanism, joints, (0.0,) * COORDINATES[type(mechanism)], case.drive.speed, sigma, memories)
    offsets, roots = _offsets(case, joints)
    start = np.append(_start(case, open_joints, offsets, roots), np.zeros(len(memories)))
    return Scene(case, value, layout, start, bool(np.any(roots)))


def _pair_scene(case: Case, layout: Layout, joints: tuple) -> Scene:
    """Return the scene of an impact pair: centred, approaching."""
    values = case.mechanism.values
    first, second, speed = values["masses.0"], values["masses.1"], values["speed"]
    clearance = joints[0].clearance
    memories = _memories(joints)
    value = rates.Scene(
        Pair(first * second / (first + second)), joints, (0.0,), speed / clearance, math.sqrt(clearance), memories
    )
    return Scene(case, value, layout, np.array([0.0, speed, 0.0, 0.0] + [0.0] * len(memories)), False)


def _memories(joints: tuple) -> tuple:
    """Return the size of each number that the laws of joints remember."""
    return tuple(size for joint in joints for law in (joint.law, joint.friction) for size in memory(law))


def _joint(joint: Joint) -> dry.Joint:
    """Return the compiled form of a joint."""
    law, elastic = registry.contact_terms(joint)
    side = 1.0 if joint.journal == _DISTAL.get(joint.name) or joint.name == "pair" else -1.0
    radius = joint.bearing_radius or 2.0 * joint.clearance  # of no meaning in an impact pair
    return dry.Joint(
        joint.clearance,
        radius,
        radius - joint.clearance,
        side,
        law,
        elastic,
        registry.friction_term(joint),
        registry.wear_term(joint),
    )


def _links(case: Case) -> Links:
    values = case.mechanism.values
    return Links(
        values["crank.length"],
        values["crank.center"],
        values["crank.mass"],
        values["crank.inertia"],
        values["rod.length"],
        values["rod.center"],
        values["rod.mass"],
        values["rod.inertia"],
        values["slider.mass"],
        values["gravity"],
        case.drive.speed,
    )


def _offsets(case: Case, joints: tuple) -> tuple[dict, np.ndarray]:
    """Return where the distal pin of each open joint starts relative to the proximal one, and the penetrations' roots.

    Seated: displaced along the load of the ideal mechanism to static penetration.
    """
    offsets, roots = {}, np.zeros(len(joints))
    if case.simulate.start == "centred":
        return offsets, roots
    loads = ideal.reactions(case.mechanism.values, case.drive.speed, 0.0)._asdict()
    for place, (joint, term) in enumerate(zip(case.joints, joints, strict=True)):
        force = loads[joint.column]
        load = float(np.hypot(*force))
        if load == 0.0:
            raise InputError(
                f"simulate.start: seated needs a load, but {joint.name} carries none at t = 0; use centred"
            )
        depth = static_penetration(term.elastic, load)
        roots[place] = math.sqrt(depth)
        offsets[JOINTS[joint.name]] = -(joint.clearance + depth) * force / load
    return offsets, roots


def static_penetration(elastic, load: float) -> float:
    """Return the penetration (m) at which an elastic law carries `load` (N)."""
    low, high = 0.0, 1e-12
    while elastic_force(elastic, high) < load:
        high *= 2.0
    for _ in range(200):  # bisection: any increasing law, and never more than one unit in the last place off
        middle = 0.5 * (low + high)
        if middle in (low, high):
            break
        low, high = (middle, high) if elastic_force(elastic, middle) < load else (low, middle)
    return high


def _start(case: Case, open_joints: str, offsets: dict, roots: np.ndarray) -> np.ndarray:
    """Return the state at crank angle 0 with the pins apart by `offsets` and at rest relative to each other."""
    values, speed = case.mechanism.values, case.drive.speed
    radius, length, center = values["crank.length"], values["rod.length"], values["rod.center"]
    a, b, c = (np.asarray(offsets.get(joint, (0.0, 0.0))) for joint in "ABC")
    crank_pin = a + np.array([radius, 0.0]) + b
    sin2 = -(crank_pin[1] + c[1]) / length
    cos2 = math.sqrt(1.0 - sin2**2)
    rate = -radius * speed / (length * cos2)
    rod_center = crank_pin + center * np.array([cos2, sin2])
    rod_velocity = np.array([0.0, radius * speed]) + center * rate * np.array([-sin2, cos2])
    places = [[math.asin(sin2), crank_pin[0] + length * cos2 + c[0]]]
    rates = [[rate, -length * rate * sin2]]
    if "B" in open_joints and "C" in open_joints:
        places.append(rod_center)
        rates.append(rod_velocity)
    if "A" in open_joints and len(open_joints) > 1:
        places.append(a)
        rates.append([0.0, 0.0])
    return np.concatenate([*places, *rates, [0.0], roots]).astype(float)


def signature(case: Case) -> tuple:
    """Return what decides the compiled code of a case: the types in its scene."""
    joints = tuple(
        (
            joint.name,
            *map(_types, registry.contact_terms(joint)),
            _types(registry.friction_term(joint)),
            _types(registry.wear_term(joint)),
        )
        for joint in case.joints
    )
    return case.mechanism.type, joints


def _types(term) -> str:
    """Return the name of a compiled form's type, with those of the types it holds: 'Archard(Mean)'."""
    inner = ", ".join(_types(part) for part in term if isinstance(part, tuple))
    return f"{type(term).__name__}({inner})" if inner else type(term).__name__


def derived(case: Case) -> dict[str, tuple[float, str]]:
    """Return what follows from other values of a case: dotted path -> (value, unit)."""
    return {
        f"joints.{joint.name}.{key}": value for joint in case.joints for key, value in registry.derived(joint).items()
    }


def warnings(case: Case) -> list[str]:
    """Return sentences about values of a case that may not be what was meant."""
    sentences = []
    for joint in case.joints:
        if registry.pulls(joint):
            sentences.append(
                f"joints.{joint.name}.contact.law: {joint.contact.law} pulls before the surfaces part, as published; "
                "its normal force can be negative and is not clipped"
            )
        hardness = joint.wear.values.get("hardness") if joint.wear else None
        if hardness is None:
            continue
        for body in ("bearing", "journal"):
            ratio = joint.wear.values[f"{body}_coefficient"] * hardness
            if ratio > _WEAR_WARNING:
                sentences.append(
                    f"joints.{joint.name}.wear: {body} coefficient times hardness is {ratio:.2g}; it is the share of "
                    f"contacts that shed a particle and should be far below 1"
                )
    return sentences
