"""From a case, names and numbers, to a scene, types and numbers: the only place where names become types."""

import math
import time
from collections.abc import Mapping
from dataclasses import dataclass
from os import PathLike
from typing import Any

import numpy as np

from .. import grid
from ..case import Case, Joint
from ..catalogue import Catalogue, Mechanism
from ..errors import InputError
from ..layout import Layout
from ..mechanics import rates
from ..mechanics.joint import dry, registry
from ..mechanics.joint.contract import every_internal_state
from ..mechanics.joint.elastic.contract import elastic_force
from ..mechanics.mechanism import MECHANISMS
from ..mechanics.mechanism.contract import Built, IdealMotion
from . import figures

_WEAR_WARNING = 1e-2  # of coefficient times hardness
_LARGEST_WEAR = 1e-11  # m^2/N: times the hardness of steel, 2 GPa, it is beyond _WEAR_WARNING


class Patience:
    """How long a case may take."""

    def __init__(self, budget: float):
        """Begin to count; budget : s of this process's time."""
        self.deadline = time.process_time() + budget

    def forgive(self, seconds: float) -> None:
        """Leave out of account what went to other cases, s of this process's time."""
        self.deadline += seconds

    def at_end(self) -> bool:
        """Return whether the case is to be given up."""
        return time.process_time() >= self.deadline


@dataclass(frozen=True)
class Scene:
    """A case made ready: its compiled form and where it starts."""

    case: Case
    mechanism: Mechanism
    built: Built
    value: rates.Scene
    layout: Layout
    start: np.ndarray  # (n,) initial state, see mechanics.rates
    in_contact: bool  # all joints begin in contact
    patience: "Patience | None" = None  # None: as much time as it takes


def catalogue() -> Catalogue:
    """Return all that a grid can name, and all that its cases can give."""
    return Catalogue(registry.described(), tuple(MECHANISMS.values()), figures.FIGURES, rates.JOINT_CHANNELS)


def load_case(source: str | PathLike | Mapping, overrides: Mapping[str, Any] | None = None) -> Scene:
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
    mechanism, bodies = MECHANISMS[case.mechanism.type], case.mechanism.values
    drive = case.drive.speed if case.drive else None
    joints = {joint.name: registry.joint_term(joint, mechanism.site(joint.name).distal) for joint in case.joints}
    offsets, roots = dict.fromkeys(joints, (0.0, 0.0)), np.zeros(len(joints))
    if case.simulate.start == "seated":
        assert mechanism.ideal is not None  # the grid knows `start` for mechanisms that have one
        offsets, roots = _seated(mechanism.ideal(bodies, drive, 0.0).reactions, joints)
    built = mechanism.build(bodies, drive, joints, offsets)
    terms = tuple(joints.values())
    sigma = math.sqrt(min(term.clearance for term in terms))
    value = rates.Scene(built.value, terms, (0.0,) * len(built.lengths), built.rate, sigma)
    start = np.concatenate([built.start, roots, [began for _, _, began in every_internal_state(terms)]])
    return Scene(case, mechanism, built, value, Layout.of(case, catalogue()), start, bool(np.any(roots)))


def _seated(reactions: Mapping[str, np.ndarray], joints: dict[str, dry.Joint]) -> tuple[dict, np.ndarray]:
    """Return where the distal pin of each joint starts relative to the proximal one, and the penetrations' roots.

    It is displaced along the load (N) of the ideal mechanism to static penetration.
    """
    offsets, roots = {}, np.zeros(len(joints))
    for place, (name, joint) in enumerate(joints.items()):
        force = reactions[name]
        load = float(np.hypot(*force))
        if load == 0.0:
            raise InputError(f"simulate.start: seated needs a load, but {name} carries none at t = 0; use centred")
        depth = static_penetration(joint.elastic, load)
        roots[place] = math.sqrt(depth)
        offsets[name] = -(joint.clearance + depth) * force / load
    return offsets, roots


def static_penetration(elastic: Any, load: float) -> float:
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


def _types(term: tuple) -> str:
    """Return the name of a compiled form's type, with those of the types it holds: 'Archard(Mean)'."""
    inner = ", ".join(_types(part) for part in term if isinstance(part, tuple))
    return f"{type(term).__name__}({inner})" if inner else type(term).__name__


def derived(case: Case) -> dict[str, tuple[float, str]]:
    """Return what follows from other values of a case: dotted path -> (value, unit)."""
    return {
        f"joints.{joint.name}.{key}": value for joint in case.joints for key, value in registry.derived(joint).items()
    }


def ideal_motion(case: Case, angles: np.ndarray) -> IdealMotion | None:
    """Return a case's mechanism without clearance at angles (rad) of its drive; None where it has no ideal."""
    ideal = MECHANISMS[case.mechanism.type].ideal
    return ideal(case.mechanism.values, case.drive.speed, angles) if ideal and case.drive else None


def warnings(case: Case) -> list[str]:
    """Return sentences about values of a case that may not be what was meant."""
    sentences = []
    for joint in case.joints:
        if registry.pulls(joint):
            sentences.append(
                f"joints.{joint.name}.contact.law: {joint.contact.law} pulls before the surfaces part, as published; "
                "its normal force can be negative and is not clipped"
            )
        if joint.wear is None:
            continue
        if "hardness" not in joint.wear.values:
            sentences += _unchecked_wear(joint)
            continue
        hardness = joint.wear.values["hardness"]
        for body in ("bearing", "journal"):
            ratio = joint.wear.values[f"{body}_coefficient"] * hardness
            if ratio > _WEAR_WARNING:
                sentences.append(
                    f"joints.{joint.name}.wear: {body} coefficient times hardness is {ratio:.2g}; it is the share of "
                    f"contacts that shed a particle and should be far below 1"
                )
    return sentences


def _unchecked_wear(joint: Joint) -> list[str]:
    """Return a sentence where a joint's wear coefficient, not checked by a hardness, is larger than any of metals."""
    assert joint.wear is not None  # asked of joints that wear
    largest = max(joint.wear.values[f"{body}_coefficient"] for body in ("bearing", "journal"))
    if largest <= _LARGEST_WEAR:
        return []
    return [
        f"joints.{joint.name}.wear: the coefficient {largest:.2g} m^2/N is above {_LARGEST_WEAR:g}, which metals do "
        "not reach; is it in mm^2/N? (1 mm^2/N is 1e-6 m^2/N); `hardness` lets it be checked"
    ]
