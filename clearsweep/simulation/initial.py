"""Inputs of all runs of a scene: its initial state, error scales, and numbers of its contacts."""

import math
from itertools import chain
from typing import TYPE_CHECKING, Any, NamedTuple

from ..mechanics.compiled.family import flatten, numbers_of
from ..mechanics.coupling.state import every_state
from ..mechanics.joint import registry
from ..mechanics.joint.contract import (
    ONSET_FLOOR,
    contact_modes,
    every_contact,
    every_latched,
    states_of,
)
from ..mechanics.joint.lubricated import film_depths
from .crank_clock import knots_of

if TYPE_CHECKING:
    from .scene import Scene  # which has these inputs

#: Allowed error of one step, per tolerance: of coordinates in clearances, of rates in clearances times
#: crank speed, of roots of penetration in roots of the clearance.  Errors of coordinates rotate the contact force a
#: little; those of a root of penetration change its magnitude, so they count most.  Chosen on the one-joint
#: reference trajectories: 15 to 20 % fewer evaluations at equal error than with 1, 1, 1 or a relative tolerance.
POSITION_WEIGHT, RATE_WEIGHT, ROOT_WEIGHT = 30.0, 3.0, 0.1
FILM_RATE_FACTOR = 0.1  # of RATE_WEIGHT with a film: a small error of a rate is a large one of the damping force
ROUNDING = 1e-15  # of the mechanism's size and speed: least tolerance


class InitialState(NamedTuple):
    """Arrays of the initial state of a motion."""

    parameters: Any  # numbers of the compiled scene, see `family.flatten`; names as in Work
    y: Any
    weight: Any
    latched: Any
    clearance: Any
    film: Any


class SceneInputs(NamedTuple):
    """Inputs that all runs of a scene share."""

    initial_values: list[float]  # the arrays of an InitialState, concatenated
    loop_inputs: list[float]  # those of a RunInputs after `marks`, concatenated
    knots: int  # number of the first of these
    has_friction: tuple[bool, ...]  # by contact
    sliding_distance: tuple[float, ...]  # m, by contact: of earlier wear


def scene_inputs(scene: "Scene") -> SceneInputs:
    """Return the inputs that all runs of a scene share."""
    contacts = ContactInputs(*zip(*_contact_inputs(scene), strict=True))
    internal, latched = _internal_states(scene)
    knots = knots_of(scene.machine)
    initial = InitialState(
        parameters=numbers_of(scene.value),
        y=scene.start.tolist(),
        weight=_weights(scene, len(contacts.side), [state.scale for _, state, _ in internal]),
        latched=[ONSET_FLOOR] * len(contacts.side) + [began for _, began in latched],
        clearance=contacts.clearance,
        film=chain.from_iterable(contacts.film),
    )
    return SceneInputs(
        initial_values=list(chain.from_iterable(initial)),
        loop_inputs=[*knots, *[began for _, _, began in internal], *contacts.side, *contacts.limit_depth],
        knots=len(knots),
        has_friction=contacts.has_friction,
        sliding_distance=contacts.sliding_distance,
    )


class ContactInputs(NamedTuple):
    """Inputs that a contact has from its joint, or those of all contacts by field."""

    side: Any  # of the joint, see `dry.Joint`
    limit_depth: Any  # m, to which its elastic law is valid
    clearance: Any  # m
    film: Any  # m, see `film_depths`
    has_friction: Any  # whether there may be a tangential force
    sliding_distance: Any  # m, of earlier wear


def _contact_inputs(scene: "Scene") -> list[ContactInputs]:
    """Return the inputs of all contacts."""
    contacts: list[ContactInputs] = []
    for joint, case_joint in zip(scene.value.joints, scene.case.joints, strict=True):
        earlier_wear = scene.worn.get(case_joint.name)
        inputs = ContactInputs(
            side=joint.side,
            limit_depth=registry.penetration_limit(case_joint),
            clearance=joint.clearance,
            film=film_depths(joint),
            has_friction=case_joint.friction is not None or case_joint.film is not None,
            sliding_distance=earlier_wear.sliding_distance if earlier_wear else 0.0,
        )
        contacts += [inputs] * len(contact_modes(joint))
    return contacts


def initial_shapes(scene: "Scene") -> dict[str, tuple[int, ...]]:
    """Return the shapes of the arrays of an InitialState."""
    contacts, latched = len(every_contact(scene.value.joints)), _internal_states(scene)[1]
    shapes = flatten(scene.value).shape, scene.start.shape, scene.start.shape, (contacts + len(latched),)
    return InitialState(*shapes, (contacts,), (contacts, 2))._asdict()


def _internal_states(scene: "Scene") -> tuple[list, list]:
    """Return the internal state of a scene's laws: the integrated part and the latched part."""
    return every_state(scene.value), every_latched(scene.value.joints) if states_of(scene.value).latched else []


def _weights(scene: "Scene", contacts: int, internal: list[float]) -> list[float]:
    """Return one over the allowed error of one step in each component of the state; `internal`: scales of its laws."""
    value, tolerance = scene.value, scene.case.simulate.tolerance
    clearance, mechanism_size = min([joint.clearance for joint in value.joints]), scene.built.size
    lengths, has_film = scene.built.lengths.tolist(), any(joint.film for joint in scene.layout.joints)
    rate_weight = FILM_RATE_FACTOR * RATE_WEIGHT if has_film else RATE_WEIGHT
    length_error = max(POSITION_WEIGHT * tolerance * clearance, ROUNDING * mechanism_size)
    rate_error = max(rate_weight * tolerance * clearance, ROUNDING * mechanism_size) * value.reference_rate
    time_error = max(POSITION_WEIGHT * tolerance, ROUNDING) / value.reference_rate
    root_error = ROOT_WEIGHT * tolerance * math.sqrt(clearance)
    allowed_errors = [
        *[length_error / length for length in lengths],
        *[rate_error / length for length in lengths],
        time_error,
        *[root_error] * contacts,
        *[tolerance * scale for scale in internal],
    ]
    return [1.0 / error for error in allowed_errors]
