"""Inputs of all runs of a scene: its initial state, error scales, and numbers of its contacts."""

import math
from collections.abc import Mapping
from itertools import chain
from typing import Any, NamedTuple

import numpy as np

from ...contracts.case import Case
from ...contracts.machine import Machine
from ...mechanics.coupling import rates
from ...mechanics.coupling.state import every_state
from ...mechanics.joints import registry
from ...mechanics.joints.contract import contact_modes, every_contact, every_latched, state_kinds_of
from ...mechanics.joints.lubricated import film_depths
from ...mechanics.laws.contract import ONSET_FLOOR
from ...mechanics.machines.contract import Built
from ...mechanics.wear import Worn
from ...tracing.compiled.family import flatten, numbers_of
from .crank_clock import knots_of

#: Allowed error of one step, per tolerance: of coordinates in clearances, of rates in clearances times
#: crank speed, of roots of penetration in roots of the clearance.  Errors of coordinates rotate the contact force a
#: little; those of a root of penetration change its magnitude, so they count most.  Chosen on the one-joint
#: reference trajectories: 15 to 20 % fewer evaluations at equal error than with 1, 1, 1 or a relative tolerance.
POSITION_WEIGHT, RATE_WEIGHT, ROOT_WEIGHT = 30.0, 3.0, 0.1
FILM_RATE_FACTOR = 0.1  # of RATE_WEIGHT with a film: a small error of a rate is a large one of the damping force
#: Revolutions below which the scale of errors of rates is a tenth of the clearance over the run's duration, not that of
#: the crank.
SHORT_RUN = 0.1 / (2.0 * math.pi)
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


def scene_inputs(
    case: Case, built: Built, value: rates.Scene, start: np.ndarray, machine: Machine | None, worn: Mapping[str, Worn]
) -> SceneInputs:
    """Return the inputs that all runs of a scene share, from its parts."""
    contacts = ContactInputs(*zip(*_contact_inputs(case, value, worn), strict=True))
    internal, latched = _internal_states(value)
    knots = knots_of(machine)
    initial = InitialState(
        parameters=numbers_of(value),
        y=start.tolist(),
        weight=_weights(case, built, value, len(contacts.side), [state.scale for _, state, _ in internal]),
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


def _contact_inputs(case: Case, value: rates.Scene, worn: Mapping[str, Worn]) -> list[ContactInputs]:
    """Return the inputs of all contacts."""
    contacts: list[ContactInputs] = []
    for joint, case_joint in zip(value.joints, case.joints, strict=True):
        earlier_wear = worn.get(case_joint.name)
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


def initial_shapes(value: rates.Scene, start: np.ndarray) -> dict[str, tuple[int, ...]]:
    """Return the shapes of the arrays of an InitialState."""
    contacts, latched = len(every_contact(value.joints)), _internal_states(value)[1]
    shapes = flatten(value).shape, start.shape, start.shape, (contacts + len(latched),)
    return InitialState(*shapes, (contacts,), (contacts, 2))._asdict()


def _internal_states(value: rates.Scene) -> tuple[list, list]:
    """Return the internal state of a scene's laws: the integrated part and the latched part."""
    return every_state(value), every_latched(value.joints) if state_kinds_of(value).latched else []


def _weights(case: Case, built: Built, value: rates.Scene, contacts: int, internal: list[float]) -> list[float]:
    """Return one over the allowed error of one step in each component of the state; `internal`: scales of its laws."""
    tolerance, mechanism_size, lengths = case.simulate.tolerance, built.size, built.lengths.tolist()
    clearance, has_film = min([joint.clearance for joint in value.joints]), any(joint.film for joint in case.joints)
    rate_weight = FILM_RATE_FACTOR * RATE_WEIGHT if has_film else RATE_WEIGHT
    length_error = max(POSITION_WEIGHT * tolerance * clearance, ROUNDING * mechanism_size)
    rate_error = max(rate_weight * tolerance * clearance, ROUNDING * mechanism_size) * value.reference_rate
    if 0.0 < case.simulate.revolutions < SHORT_RUN:  # the crank is slow compared with the motion
        rate_error *= SHORT_RUN / case.simulate.revolutions
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
